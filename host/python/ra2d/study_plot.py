# SPDX-License-Identifier: BSD-3-Clause
"""The picture of a study: its level against each varied key, and the law."""
from __future__ import annotations

import math
from typing import TYPE_CHECKING, Any

import matplotlib
import numpy as np
import pandas as pd
from matplotlib.lines import Line2D
from matplotlib.ticker import FixedLocator, NullFormatter, NullLocator

from . import style
from .errors import RequestError
from .style import BLACK, DECIBEL, GREY, MARKS, Picture, literal, scale

if TYPE_CHECKING:
    from .studies import Law, Study

FULL_WIDTH = 5.6   # inches of a panel
MOST_MARKS = 8
MOST_COLOURS = 12  # above them the legend names every other one


def _is_number(values: Any) -> bool:
    return bool(np.issubdtype(np.asarray(values).dtype, np.number))


def words(values: list[Any], unit: str) -> tuple[list[str], str]:
    """Values as an axis shows them, with the prefix that suits the largest, and the unit."""
    if not _is_number(values):
        return [literal(str(value)[:18]) for value in values], ""
    if not unit:
        return [f"{value:g}" for value in values], ""
    name, one = scale(unit, values, up=20)
    return [f"{value / one:.4g}" for value in values], name


def _axis_name(name: str, unit: str) -> str:
    return literal(f"{name} [{unit}]" if unit else name)


def _colours(count: int) -> list[Any]:
    """From dark to light in one scale, so that an order can be seen; the lightest yellow is left
    out."""
    return [matplotlib.colormaps["plasma"](at) for at in np.linspace(0, 0.82, count)]


class _Panel:
    """The level against one key. The key with the most values among the others has the colours;
    combinations of what is left have the marks."""

    apart = 0.07  # of the axis, that labels of numbers stand at least

    def __init__(self, axes: Any, study: Study, means: pd.DataFrame, law: Law | None, name: str,
                 names: list[str]) -> None:
        self.axes, self.study, self.means, self.law, self.name = axes, study, means, law, name
        others = sorted((other for other in names if other != name),
                        key=lambda other: -study.sizes[other])
        self.colour, self.marked = (others[0] if others else None), others[1:]
        values = study[name].values
        self.numeric = _is_number(values)
        self.log = self.numeric and bool((values > 0).all()) and values.size > 1
        self.place = {value: float(value) if self.numeric else float(i)
                      for i, value in enumerate(values.tolist())}

    def unit(self, name: str) -> str:
        return style.unit_text(self.study[name].attrs.get("units", "1"))

    def draw(self) -> None:
        by_colour: list[Any] = sorted(
            self.study[self.colour].values.tolist()) if self.colour else [None]
        by_mark = self.means[self.marked].drop_duplicates().to_records(
            index=False).tolist() if self.marked else [()]
        colours = _colours(len(by_colour)) if self.colour else [style.BLUE]
        series = len(by_colour) * len(by_mark)
        for i, value in enumerate(by_colour):
            for j, rest in enumerate(by_mark):
                of = self.means
                for key, wanted in [(self.colour,
                                     value)] * bool(self.colour) + list(zip(self.marked, rest)):
                    of = of[of[key] == wanted]
                aside = (i * len(by_mark) + j - (series - 1) / 2) / max(series, 6)
                self._draw_series(of, colours[i], MARKS[j % MOST_MARKS], aside)
        self._label(by_colour, by_mark, colours)

    def _draw_series(self, of: pd.DataFrame, colour: Any, mark: str, aside: float) -> None:
        of = of[np.isfinite(of["level"])].copy()
        of["place"] = [self.place[value] for value in of[self.name]]
        of = of.sort_values("place")
        if not len(of):
            return
        x = of["place"].to_numpy()
        everywhere = list(self.place.values())
        span = 0.03 * aside  # bars stand apart
        marks = x * (max(everywhere) / min(everywhere)) ** span if self.log else x + span * (
            np.ptp(everywhere) or 1)
        level = of["level"].to_numpy()
        half_interval = [np.nan_to_num(level - of["level_low"].to_numpy()),
                         np.nan_to_num(of["level_high"].to_numpy() - level)]
        self.axes.errorbar(marks, level, yerr=half_interval, fmt=mark, ms=5, color=colour,
                           mec="white", mew=0.5,
                           ecolor=(*matplotlib.colors.to_rgb(colour), 0.55), elinewidth=1.2,
                           capsize=0, zorder=3)
        if self.law and self.name in self.law.exponents and len(of) > 1:
            at = np.geomspace(x[0], x[-1], 40)
            first = of.iloc[0]
            point = {name: float(first[name]) for name in self.law.exponents}
            self.axes.plot(at, [self.law.level(**(point | {self.name: value})) for value in at],
                           color=colour, lw=1.2,
                           zorder=2)
        else:
            self.axes.plot(marks, level, color=colour, lw=0.7, alpha=0.5, zorder=2)

    def _label(self, by_colour: list[Any], by_mark: list[Any], colours: list[Any]) -> None:
        axes = self.axes
        if self.log:
            axes.set_xscale("log")
        shown = self._ticks()
        labels, unit = words([value for value, _ in shown], self.unit(self.name))
        axes.xaxis.set_major_locator(FixedLocator([at for _, at in shown]))
        axes.xaxis.set_minor_locator(NullLocator())
        axes.xaxis.set_minor_formatter(NullFormatter())
        turned = sum(map(len, labels)) > 48
        axes.set_xticklabels(labels, rotation=40 if turned else 0, ha="right" if turned
                             else "center")
        axes.set_xlabel(_axis_name(self.name, unit))
        axes.set_ylabel(f"level [{DECIBEL}]")
        places = np.array(list(self.place.values()))  # also those without a run
        margin = 0.06 * np.ptp(np.log(places) if self.log else places) if self.numeric else 0.5
        low, high = places.min(), places.max()
        axes.set_xlim(*((low / np.exp(margin), high * np.exp(margin)) if self.log
                        else (low - margin, high + margin)))
        handles = []
        if self.colour:
            shades, unit = words(by_colour, self.unit(self.colour))
            step = math.ceil(len(shades) / MOST_COLOURS)
            handles += [Line2D([], [], ls="none", label=_axis_name(self.colour, unit))]
            handles += [Line2D([], [], color=colour, lw=3, label=word)
                        for colour, word in list(zip(colours, shades))[::-step]]
        if self.marked:
            columns = [words(list(values), self.unit(key))
                       for key, values in zip(self.marked, zip(*by_mark))]
            names = ", ".join(_axis_name(key, unit) for key, (_, unit) in zip(self.marked, columns))
            handles += [Line2D([], [], ls="none", label=names)]
            handles += [Line2D([], [], color=GREY, marker=MARKS[j % MOST_MARKS], ls="none",
                               label=", ".join(texts))
                        for j, texts in enumerate(zip(*(texts for texts, _ in columns)))]
        if handles:
            axes.legend(handles=handles, loc="upper left", bbox_to_anchor=(1.01, 1),
                        borderaxespad=0, frameon=False,
                        fontsize=8, handlelength=1.2)

    def _ticks(self) -> list[tuple[Any, float]]:
        """Values and their places; of numbers, those that stand far enough from the one before."""
        order = sorted(self.place.items(), key=lambda pair: pair[1])

        def across(at: float) -> float:
            return math.log(at) if self.log else at

        span = across(order[-1][1]) - across(order[0][1]) or 1.0
        shown = order[:1]
        for pair in order[1:]:
            if across(pair[1]) - across(shown[-1][1]) > self.apart * span:
                shown.append(pair)
        return shown


def sound_laws(study: Study) -> list[Law]:
    """Those of the A-weighted pressure and power, where the study keeps its sound."""
    laws = []
    for of in ("lpa", "lwa"):
        try:
            laws.append(study.law(of))
        except RequestError:  # without microphones there is none of the pressure
            continue
    return laws


def _law_words(law: Law) -> str:
    parts = [f"{name}^{float(e):.3f}" + ("" if math.isnan(e.low)
                                         else f" ({e.low:.3f} to {e.high:.3f})")
             for name, e in law.exponents.items()]
    spread = "" if math.isnan(law.deviation) else f", {law.deviation:.2f} dB from the law to a run"
    return (f"{law.amplitude} ~ {'  '.join(parts)};  R\u00b2 = {law.r_squared:.4f}, "
            f"{law.about['runs']} runs{spread}")


def _head(study: Study, law: Law | None, why_no_law: str) -> list[tuple[str, float, str, str]]:
    a = study.attrs
    counts = f"{a['done']} of {a['runs']} runs done" + (f", {a['failed']} failed"
                                                        if a["failed"] else "")
    means = (f"Means over the seeds ({study.sizes['seed']}) with 95 % intervals (cut at the "
             "panels' ends)" if varied(study) else "Line: mean over the seeds; band: its 95 % "
             "interval")
    lines = [(literal(f"study: {study.folder.name}"), 12.0, "bold", BLACK),
             (f"{counts}. {means}{'; lines: the law' if law else ''}", 8.5, "normal", GREY)]
    if not law:
        return lines + [(literal(why_no_law), 9.0, "normal", BLACK)]
    lines += [(literal(_law_words(one)), 9.0, "normal", BLACK) for one in (law, *sound_laws(study))]
    if law.about["straight_line"]["fits"] is False:
        lines.append((literal(law.about["straight_line"]["says"]), 9.0, "normal", style.RUST))
    return lines


def varied(study: Study) -> list[str]:
    """The keys with two values or more."""
    return [name for name in str(study.attrs["dimensions"]).split() if name != "seed"
            and study.sizes[name] > 1]


def _set_limits(axes: Any, means: pd.DataFrame) -> None:
    """Intervals of few seeds reach far: the levels decide."""
    low, high = means["level"].min(), means["level"].max()
    margin = max(2.0, 0.12 * (high - low))
    axes.set_ylim(low - margin, high + margin)


def panel(study: Study, law: Law | None, name: str, width: float, height: float) -> Picture:
    """The level against one key alone, without a head."""
    means = study.means().reset_index()
    with matplotlib.rc_context(style.RC):
        figure, body = style.page(width, height, [])
        axes = body.subplots()
        drawn = _Panel(axes, study, means, law, name, varied(study))
        drawn.apart *= FULL_WIDTH / width
        drawn.draw()
        _set_limits(axes, means)
    return figure


def _draw_seeds(axes: Any, study: Study, mean: Any) -> None:
    """The level of each seed, where nothing else varies, and `mean`: their mean's row."""
    levels = study["level"].values.ravel()
    axes.axhspan(mean["level_low"], mean["level_high"], color=style.BLUE, alpha=0.12, lw=0)
    axes.axhline(mean["level"], color=style.BLUE, lw=1.2)
    axes.plot(np.arange(levels.size), levels, "o", ms=5, color=style.BLUE, mec="white", mew=0.5)
    most_named = 12
    shown = np.arange(0, levels.size, max(1, math.ceil(levels.size / most_named)))
    axes.set_xticks(shown, [str(seed) for seed in study["seed"].values[shown]])
    axes.set_xlabel("seed")
    axes.set_ylabel(f"level [{DECIBEL}]")
    spread = max(2.0, float(np.ptp(levels[np.isfinite(levels)])))
    axes.set_ylim(np.nanmin(levels) - spread, np.nanmax(levels) + spread)


def picture(study: Study) -> Picture:
    """A panel for each key with two values or more; of a study of seeds alone, one of these."""
    why = ""
    try:
        law = study.law()
    except RequestError as fault:
        law, why = None, str(fault)
    means, names = study.means().reset_index(), varied(study)
    columns = 1 if len(names) <= 1 else 2
    rows = max(1, math.ceil(len(names) / columns))
    with matplotlib.rc_context(style.RC):
        figure, body = style.page(FULL_WIDTH * columns + (1.5 if columns == 1 else 0), 3.7 * rows,
                                  _head(study, law, why))
        grid = list(np.atleast_1d(body.subplots(rows, columns, squeeze=False, sharey=True)).ravel())
        for axes in grid[max(len(names), 1):]:
            axes.set_visible(False)
        if not np.isfinite(means["level"]).any():
            style.say_empty(grid[0], "the table has no levels: none was kept, no run is done, or "
                            "nothing vibrates", "Level")
            return figure
        if not names:
            _draw_seeds(grid[0], study, means.iloc[0])
            return figure
        for axes, name in zip(grid, names):
            _Panel(axes, study, means, law, name, names).draw()
        _set_limits(grid[0], means)
        return figure
