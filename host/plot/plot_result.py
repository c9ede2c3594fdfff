#!/usr/bin/env python3
# SPDX-License-Identifier: BSD-3-Clause
"""plot_result.py DATA PICTURE KIND: the picture of `ra2d plot` of one result, or of several.

DATA is what the command hands over (host/plot/result_picture.cpp), KIND is png, svg or pdf. Ends with status 9 when
there is no matplotlib.
"""
import math
import sys

import picture_style as style
from picture_style import BLACK, BLUE, GREEN, GREY, PLUM, RUST, SKY, literal, number, numbers, quantity, scale, series
import numpy as np
from matplotlib.lines import Line2D
from matplotlib.ticker import FuncFormatter, LogLocator, MaxNLocator, NullFormatter

LEVEL = "dB re 1 nm/s"


# ---- a panel each --------------------------------------------------------------------------------

def together_text(drawn):
    return "" if drawn["together"] <= 1 else f"  (band: extremes of {drawn['together']} samples, line: mean)"


def draw_profiles(figure, panel, alone):
    rows = 3 if alone else 2
    axes = figure.subplots(rows, 1, sharex=True, height_ratios=[1.3, 1, 1][:rows] if alone else [1.5, 1])
    title = "Faces at the start, where the slider passes (heights much enlarged)"
    if "empty" in panel:
        for other in axes[1:]:
            other.remove()
        style.say_empty(axes[0], panel["empty"], title)
        return
    faces = axes[0]
    both = [panel[name] for name in ("resonator", "slider") if name in panel]
    unit, one = scale("m", style.extremes(*both))
    series(faces, panel["resonator"], BLUE, 1e-3, one, label="resonator", mean=False, fill=0.9)
    if "slider" in panel:
        series(faces, panel["slider"], RUST, 1e-3, one, line="--", label="slider at t = 0, face down", mean=False,
               fill=0.9)
        title += f"; mean lines {quantity(panel['gap'], 'm')} apart"
    faces.set_title(title)
    faces.set_ylabel(f"height [{unit}]")
    faces.legend(loc="upper right", ncol=2)
    low, high = faces.get_ylim()
    high += 0.22 * (high - low)  # for the legend
    faces.set_ylim(low - 0.05 * (high - low), high)
    faces.set_xlim(*(x / 1e-3 for x in panel["range"]))
    draw_places(axes[1], panel)
    if alone:
        draw_strongest(axes[2], panel)
    axes[-1].set_xlabel("place on the resonator [mm]")


def draw_places(axes, panel):
    if not panel["shocks"]:
        style.say_empty(axes, "there were no shocks: nothing touched", "Places of contact", keep_x=True)
        return
    edges = numbers(panel["places"]["edges"]) / 1e-3
    counts = numbers(panel["places"]["counts"])
    axes.stairs(counts, edges, fill=True, color=PLUM, alpha=0.85)
    width = edges[1] - edges[0]
    axes.set_title(f"Places of contact: {panel['shocks']} shock{'s' if panel['shocks'] != 1 else ''}")
    axes.set_ylabel(f"shocks per\n{width:.2g} mm")
    axes.yaxis.set_major_locator(MaxNLocator(4, integer=True))
    axes.set_ylim(0, 1.1 * counts.max())


def draw_strongest(axes, panel):
    if not panel["shocks"]:
        style.say_empty(axes, "there were no shocks: nothing touched", "Peak forces", keep_x=True)
        return
    dots = panel["strongest"]
    force, x = numbers(dots["force"]), numbers(dots["x"]) / 1e-3
    unit, one = scale("N", force)
    cloud = axes.scatter(x, force / one, c=numbers(dots["time"]), s=9, cmap="viridis", lw=0, rasterized=len(x) > 500)
    axes.figure.colorbar(cloud, ax=axes, label="begins at [s]", pad=0.01, aspect=14)
    some = len(x) < panel["shocks"]
    axes.set_title(f"Peak forces: the {len(x)} strongest of {panel['shocks']} shocks" if some else
                   "Peak forces: every shock")
    axes.set_ylabel(f"peak force [{unit}]")
    axes.set_ylim(0, None)


def time_axis(axes, seconds, note=""):
    """Sets limits and label; says what one unit is."""
    unit, one = scale("s", numbers(seconds[-1:]))
    from_start = len(seconds) < 2 or seconds[0] < seconds[1] - seconds[0]
    axes.set_xlim(0 if from_start else seconds[0] / one, seconds[-1] / one)
    axes.set_xlabel(f"time [{unit}]{note}")
    return one


def draw_in_time(figure, lines, alone, quantity_name, unit_name, title, close_title):
    """Series over the whole run; alone, a close-up below."""
    panels = figure.subplots(2 if alone else 1, 1, squeeze=False)[:, 0]
    for axes, key in zip(panels, ("series", "close")):
        drawn = [line[key] for line in lines]
        unit, one = scale(unit_name, style.extremes(*drawn))
        seconds = time_axis(axes, drawn[0]["x"], together_text(drawn[0]))
        for i, line in enumerate(lines):
            series(axes, line[key], style.SERIES[i], seconds, one, line=style.LINES[i], label=line["label"])
        axes.set_ylabel(f"{quantity_name} [{unit}]")
        axes.set_title(title if key == "series" else close_title)
        if len(lines) > 1 or lines[0]["label"]:
            low, high = axes.get_ylim()
            axes.set_ylim(low, high + 0.2 * (high - low))
            axes.legend(loc="upper right", ncol=3)
    return panels


def draw_force(figure, panel, alone):
    if "empty" in panel:
        style.say_empty(figure.subplots(), panel["empty"], "Contact force")
        return
    panels = draw_in_time(figure, [dict(panel, label=None)], alone, "force", "N", "Contact force",
                          "Around the largest sample, every sample")
    for axes in panels:
        axes.set_ylim(0, None)


def draw_displacement(figure, panel, alone):
    if "empty" in panel:
        style.say_empty(figure.subplots(), panel["empty"], "Displacement of probes")
        return
    more = f" ({panel['left_out']} more probes are not drawn)" if panel["left_out"] else ""
    draw_in_time(figure, panel["lines"], alone, "displacement", "m", "Displacement of probes" + more,
                 "Around the largest force, every sample")


def decades_shown(values, most=9):
    """Limits of a density's axis: what lies more decades below its peak says nothing of the noise."""
    values = values[np.isfinite(values) & (values > 0)]
    if not values.size:
        return None
    low, high = max(values.min(), values.max() * 10.0 ** -most), values.max()
    return low / 2, high * 10 ** (0.1 * math.log10(high / low) + 0.5)


def draw_densities(figure, panel, title, lines):
    """Spectra, [(what is drawn, its looks)], with what they share."""
    axes = figure.subplots()
    if "empty" in panel:
        style.say_empty(axes, panel["empty"], title)
        return
    axes.set_yscale("log")
    for drawn, look in lines(panel):
        series(axes, drawn, **look)
    drawn = [drawn for drawn, _ in lines(panel)]
    limits = decades_shown(style.extremes(*drawn))
    if limits:
        axes.set_ylim(*limits)
    x = numbers(drawn[0]["x"])
    style.frequency_axis(axes, x[0], x[-1])
    mark_frequencies(axes, panel)
    axes.set_ylabel("PSD of velocity [(m/s)\u00b2/Hz]")
    axes.set_title(title + (f" ({panel['left_out']} more are not drawn)" if panel.get("left_out") else ""))
    axes.set_xlabel(f"frequency [Hz]  (a line every {panel['resolution']:.3g} Hz; {panel['segments']} segments)")
    if panel["aliased"]:
        axes.text(0.02, 0.9, f"{panel['aliased']} modes lie above half the rate of the samples:\n"
                  "their power stands at frequencies not theirs", transform=axes.transAxes, va="top", color=RUST,
                  fontsize=8, weight="bold")
    low, high = number(panel["low"]), number(panel["high"])
    if math.isfinite(low) and math.isfinite(high):
        draw_confidence(axes, low, high)


def draw_spectrum(figure, panel, _):
    draw_densities(figure, panel, "Velocity spectrum, mean over the resonator",
                   lambda panel: [(panel["series"], {"colour": BLUE})])


def draw_probe_spectra(figure, panel, _):
    draw_densities(figure, panel, "Velocity spectra of probes", lambda panel: [
        (line["series"], {"colour": style.SERIES[i], "line": style.LINES[i], "label": line["label"], "fill": 0.15})
        for i, line in enumerate(panel["lines"])])


def mark_frequencies(axes, panel):
    """Natural frequencies as ticks at the top, the tone of the mesh as a line."""
    natural = [f for f in panel["natural"] if axes.get_xlim()[0] <= f <= axes.get_xlim()[1]]
    top = axes.get_xaxis_transform()
    if natural:
        colour = GREY if "lines" in panel else RUST  # which is a line's own
        axes.vlines(natural, 0.955, 1, transform=top, color=colour, lw=1.1,
                    label="natural frequencies, free resonator")
    mesh = number(panel["mesh"])
    if math.isfinite(mesh):
        axes.axvline(mesh, ls=(0, (4, 2)), color=BLACK, lw=0.9, label=f"mesh, speed/spacing: {quantity(mesh, 'Hz')}")
    if natural or math.isfinite(mesh) or "lines" in panel:
        axes.legend(loc="lower left")


def draw_confidence(axes, low, high):
    """A bar as high as 95 % of chance."""
    x, y = 0.975, 0.86
    bottom, top = axes.get_ylim()
    middle = bottom * (top / bottom) ** y
    axes.errorbar([x], [middle], yerr=[[middle * (1 - low)], [middle * (high - 1)]], color=GREY, capsize=3, lw=1.2,
                  transform=axes.get_yaxis_transform(), zorder=5)
    axes.text(x - 0.015, middle, "95 %", transform=axes.get_yaxis_transform(), ha="right", va="center", color=GREY,
              fontsize=8)


def draw_histogram(axes, drawn, unit_name, what, count):
    edges, counts = numbers(drawn["edges"]), numbers(drawn["counts"])
    if not counts.size:
        style.say_empty(axes, f"no shock has a {what} above 0", what.capitalize())
        return
    unit, one = scale(unit_name, np.array([number(drawn["median"])]))
    axes.stairs(100 * counts / count, edges / one, fill=True, color=SKY, ec=BLUE, lw=0.8)
    axes.set_xscale("log")
    low, high = edges[0] / one, edges[-1] / one
    axes.set_xlim(low / 1.15, high * 1.15)
    if high / low < 50:
        axes.xaxis.set_major_locator(LogLocator(subs=(1, 2, 5)))
    axes.xaxis.set_major_formatter(FuncFormatter(lambda value, _: f"{value:g}"))
    axes.xaxis.set_minor_formatter(NullFormatter())
    axes.set_xlabel(f"{what} [{unit}]")
    axes.set_ylabel("share of shocks [%]")
    axes.set_ylim(0, 1.45 * 100 * counts.max() / count)
    for key, line, name in (("median", "-", "median"), ("p90", "--", "90 % up to")):
        value = number(drawn[key])
        axes.axvline(value / one, ls=line, color=BLACK, lw=1, label=f"{name} {quantity(value, unit_name)}")
    axes.legend(loc="upper right", handlelength=1.6, fontsize=8)


def draw_shocks(figure, panel, alone):
    if "empty" in panel:
        style.say_empty(figure.subplots(), panel["empty"], "Shocks")
        return
    count = panel["count"]
    kinds = [("duration", "s", "duration"), ("peak_force", "N", "peak force"),
             ("impulse", "N s", "impulse"), ("interval", "s", "time from start to start")]
    panels = figure.subplots(2 if alone else 1, 2, squeeze=False).flat
    for axes, (key, unit, what) in zip(panels, kinds if alone else kinds[:2]):
        draw_histogram(axes, panel[key], unit, what, count)
    title = f"{count} shock{'s' if count != 1 else ''}"
    if panel["from"]:
        title += f" from {quantity(panel['from'], 's')} on"
    figure.axes[0].set_title(title + (", bins of equal ratio, ten to a decade" if alone else ""))


def draw_level(figure, panel, _):
    axes = figure.subplots()
    title = "Level of the resonator's noise in time"
    if "empty" in panel:
        style.say_empty(axes, panel["empty"], title)
        return
    x, levels = numbers(panel["x"]), numbers(panel["level"])
    unit, one = scale("s", np.array([panel["to"]]))
    axes.plot(x / one, levels, color=BLUE, lw=1.2, marker="o", ms=2.5)
    lv = number(panel["lv"])
    if math.isfinite(lv):
        axes.hlines(lv, panel["from"] / one, panel["to"] / one, color=RUST, ls="--", lw=1.2, zorder=4,
                    label=f"from {quantity(panel['from'], 's')} on: {lv:.2f} dB" if panel["from"] else f"whole: {lv:.2f} dB")
        axes.legend(loc="lower right")
    finite = levels[np.isfinite(levels)]
    if finite.size:
        high = max(finite.max(), lv if math.isfinite(lv) else -math.inf)
        low = max(finite.min(), high - 80)
        margin = max(1.0, 0.08 * (high - low))
        axes.set_ylim(low - 2.5 * margin, high + margin)
    axes.set_xlim(0, panel["to"] / one)
    axes.set_xlabel(f"time [{unit}]")
    axes.set_ylabel(f"level [{LEVEL}]")
    axes.set_title(f"{title}, over {quantity(panel['window'], 's')} each")


# what, its name, colour, line and width: where lines lie upon one another, the wider ones show
FLOWS = [("load", "put in by loads", SKY, "-", 4.5), ("sliding", "put in by sliding", BLUE, "-", 2.2),
         ("damping", "lost to damping", RUST, "--", 1.7), ("stored", "stored since the start", GREEN, ":", 2),
         ("missing", "missing", BLACK, (0, (1, 2)), 1.3)]
STORES = [("kinetic", "kinetic", BLUE, "-", 1.6), ("elastic", "elastic", RUST, "--", 1.6),
          ("contact", "in contacts", GREEN, ":", 1.8)]


def draw_energies(axes, panel, kinds, title):
    unit, one = scale("J", style.extremes(*(panel[key] for key, *_ in kinds)))
    seconds = time_axis(axes, panel["sliding"]["x"], together_text(panel["sliding"]))
    for key, name, colour, line, width in kinds:
        series(axes, panel[key], colour, seconds, one, line=line, label=name, width=width, fill=0.25)
    axes.set_ylabel(f"energy [{unit}]")
    axes.set_title(title)
    low, high = axes.get_ylim()
    axes.set_ylim(low, high + (0.42 if len(kinds) > 3 else 0.2) * (high - low))  # for the legend
    axes.legend(loc="upper left", handlelength=3, ncol=2 if len(kinds) > 3 else 3)


def draw_energy(figure, panel, alone):
    title = "Energy: what went in and where it went"
    if "empty" in panel:
        style.say_empty(figure.subplots(), panel["empty"], title)
        return
    panels = figure.subplots(2 if alone else 1, 1, squeeze=False)[:, 0]
    draw_energies(panels[0], panel, FLOWS, title)
    if alone:
        draw_energies(panels[1], panel, STORES, "Energy that is there")


def draw_bands(figure, panel, _):
    axes = figure.subplots()
    title = "Third octaves of the resonator's velocity"
    if "empty" in panel:
        style.say_empty(axes, panel["empty"], title)
        return
    levels = numbers(panel["level"])
    finite = levels[np.isfinite(levels)]
    bottom = 5 * math.floor((max(finite.min(), finite.max() - 80) - 5) / 5)
    place = np.arange(len(levels))
    bars = axes.bar(place, np.maximum(levels - bottom, 0), 0.85, bottom=bottom, color=SKY, ec=BLUE, lw=0.8,
                    yerr=numbers(panel["spread"]), error_kw={"ecolor": BLACK, "capsize": 2, "lw": 0.9})
    above = [bar for bar, is_above in zip(bars, panel["above"]) if is_above]
    for bar in above:
        bar.set(facecolor="white", hatch="////")
    if above:
        axes.legend(above[:1], [f"above the last mode that was kept, at {quantity(panel['last_mode'], 'Hz')}: "
                                "no information"], loc="upper right")
    band_axis(axes, panel["names"])
    axes.set_ylim(bottom, finite.max() + 6)
    axes.set_ylabel(f"level [{LEVEL}]")
    axes.set_title(f"{title}; in all {number(panel['lv']):.1f} dB; bars: what chance moves, of stationary noise")


def band_axis(axes, names):
    step = max(1, math.ceil(len(names) / 32))
    axes.set_xticks(range(0, len(names), step), names[::step], rotation=60 if len(names) > 12 else 0)
    axes.grid(False, axis="x")
    axes.set_xlim(-0.7, len(names) - 0.3)
    axes.set_xlabel("midband frequency [Hz]")


def draw_spectrogram(figure, panel, _):
    axes = figure.subplots()
    title = "Velocity spectrum of the resonator in time"
    if "empty" in panel:
        style.say_empty(axes, panel["empty"], title)
        return
    levels = np.array([numbers(row) for row in panel["level"]]).T
    seconds = time_axis(axes, panel["x"] if len(panel["x"]) > 1 else [0, panel["window"]])
    unit, one = scale("Hz", numbers(panel["frequency"]))
    high = np.nanmax(levels[np.isfinite(levels)])
    mesh = axes.pcolormesh(numbers(panel["x"]) / seconds, numbers(panel["frequency"]) / one, levels, cmap="viridis",
                           vmin=high - 70, vmax=high, shading="nearest", rasterized=True)
    axes.grid(False)
    figure.colorbar(mesh, ax=axes, label="PSD of velocity [dB re 1 (nm/s)\u00b2/Hz]", extend="min", pad=0.01)
    tone = number(panel["mesh"])
    if math.isfinite(tone):
        axes.annotate("mesh", (1, tone / one), (-4, 3), xycoords=axes.get_yaxis_transform(),
                      textcoords="offset points", color="white", fontsize=8, ha="right")
        axes.axhline(tone / one, color="white", lw=0.7, ls=(0, (2, 4)))
    axes.set_ylabel(f"frequency [{unit}]")
    axes.set_title(f"{title}, over {quantity(panel['window'], 's')} each")


PANELS = {"profiles": (draw_profiles, 7.5), "force": (draw_force, 6), "displacement": (draw_displacement, 6),
          "spectrum": (draw_spectrum, 5), "probe-spectra": (draw_probe_spectra, 5.6),
          "shocks": (draw_shocks, 6), "level": (draw_level, 4.2),
          "energy": (draw_energy, 7), "spectrogram": (draw_spectrogram, 5.2), "bands": (draw_bands, 4.6)}


# ---- pages ---------------------------------------------------------------------------------------

def facts(head):
    """The figures of the report, in a line."""
    found = []
    lv, rate, share = number(head["lv"]), number(head["shock_rate"]), number(head["contact_share"])
    if head["at_rest"]:
        found.append("the resonator is at rest")
    elif math.isfinite(lv):
        found.append(f"level {lv:.2f} {LEVEL}")
    if math.isfinite(rate):
        found.append(f"{rate:.0f} shocks a second" if rate >= 1000 else f"{rate:.3g} shocks a second" if rate else "no shocks")
    if math.isfinite(share):
        found.append(f"in contact {100 * share:.3g} % of the time")
    if math.isfinite(number(head["energy_closure"])):
        found.append(f"energy closes to {head['energy_closure']:.1e}")
    return "  \u00b7  ".join(found)


def warnings_of(head):
    found = []
    if not head["complete"]:
        found.append(f"The run was cut short after {quantity(number(head['end']), 's')}: {head['ended']}.")
    if head["beyond_limit"]:
        found.append("A step beyond the limit of stability was forced.")
    return literal(" ".join(found))


def head_of(head):
    """Title lines at the top, set apart from the panels' own."""
    lines = [(literal(f"{head['title']}  \u2013  {head['file']}"), 13, "bold", BLACK), (facts(head), 9.5, "normal", BLACK)]
    if warnings_of(head):
        lines.append((warnings_of(head), 9.5, "bold", RUST))
    return lines


def overview(data):
    panels = data["panels"]
    figure, body = style.page(11, 14, head_of(data["head"]))
    rows = body.subfigures(4, 1, height_ratios=[1.45, 1, 1.05, 1])
    draw_profiles(rows[0], panels["profiles"], False)
    for row, names in zip(rows[1:], (("force", "displacement"), ("spectrum", "level"), ("shocks", "energy"))):
        for cell, name in zip(row.subfigures(1, 2), names):
            PANELS[name][0](cell, panels[name], False)
    return figure


def one_panel(data):
    draw, height = PANELS[data["what"]]
    figure, body = style.page(10, height, head_of(data["head"]))
    draw(body, data["panels"][data["what"]], True)
    return figure


# ---- several -------------------------------------------------------------------------------------

def look(i):
    return {"color": style.SERIES[i], "ls": style.LINES[i]}


def names_of(results):
    """File names; whole numbers before those that are the same."""
    names = [literal(one["head"]["file"]) for one in results]
    return [f"{i + 1}: {name}" if names.count(name) > 1 else name for i, name in enumerate(names)]


def shown(results, names, kind):
    """(number, panel) of those that have something to show; the words of the others."""
    found, without = [], []
    for i, (one, name) in enumerate(zip(results, names)):
        panel = one["panels"][kind]
        if "empty" in panel:
            without.append(f"{name}: {panel['empty']}")
        else:
            found.append((i, panel))
    return found, without


def draw_several_spectra(axes, found):
    axes.set_yscale("log")
    values, low, high = [], math.inf, 0
    for i, panel in found:
        x = numbers(panel["series"]["x"])
        axes.plot(x, numbers(panel["series"]["mean"]), lw=1.1, **look(i))
        values.append(numbers(panel["series"]["mean"]))
        low, high = min(low, x[0]), max(high, x[-1])
    axes.set_ylim(*decades_shown(np.concatenate(values)))
    style.frequency_axis(axes, low, high)
    axes.set_ylabel("PSD of velocity [(m/s)\u00b2/Hz]")


def draw_several_bands(axes, found):
    names = max((panel["names"] for _, panel in found), key=len)
    every, hollow = [], False
    for i, panel in found:
        levels = numbers(panel["level"])
        axes.plot([names.index(n) if n in names else math.nan for n in panel["names"]], levels, marker=style.MARKS[i],
                  ms=5, lw=1.2, **look(i))
        above = [k for k, is_above in enumerate(panel["above"]) if is_above and panel["names"][k] in names]
        axes.plot([names.index(panel["names"][k]) for k in above], levels[above], ls="none", marker=style.MARKS[i],
                  ms=5, mfc="white", mec=look(i)["color"])
        hollow = hollow or bool(above)
        every.append(levels[np.isfinite(levels)])
    every = np.concatenate(every)
    axes.set_ylim(max(every.min(), every.max() - 80) - 3, every.max() + 3)
    band_axis(axes, names)
    if hollow:
        axes.set_xlabel("midband frequency [Hz]  (hollow: above the last mode that was kept, no information)")
    axes.set_ylabel(f"level [{LEVEL}]")


def draw_several_levels(axes, found):
    unit, one = scale("s", np.array([panel["to"] for _, panel in found]))
    every = []
    for i, panel in found:
        levels = numbers(panel["level"])
        axes.plot(numbers(panel["x"]) / one, levels, lw=1.2, marker=style.MARKS[i], ms=4, markevery=8, **look(i))
        every.append(levels[np.isfinite(levels)])
    every = np.concatenate(every)
    axes.set_ylim(max(every.min(), every.max() - 80) - 1, every.max() + 1)
    axes.set_xlim(0, max(panel["to"] for _, panel in found) / one)
    axes.set_xlabel(f"time [{unit}]")
    axes.set_ylabel(f"level [{LEVEL}]")


SEVERAL = {"spectrum": ("Velocity spectra of the resonators (means of lines put together)", draw_several_spectra),
           "bands": ("Third octaves of the resonators' velocities", draw_several_bands),
           "level": ("Levels in time", draw_several_levels)}


def facts_of_level(head):
    lv = number(head["lv"])
    return "at rest" if head["at_rest"] else f"{lv:.2f} {LEVEL}" if math.isfinite(lv) else "no level"


def several(data):
    results = data["results"]
    kinds = list(results[0]["panels"])
    names = names_of(results)
    lines = [(f"{data['asked']} results" + (f", the first {len(results)} of them" if data["asked"] > len(results) else ""),
              13, "bold", BLACK)]
    lines += [(f"{name}: {warnings_of(one['head'])}", 9.5, "normal", RUST) for one, name in zip(results, names)
              if warnings_of(one["head"])]
    key = 0.2 * math.ceil(len(results) / 2) + 0.1
    figure, body = style.page(10, 4 * len(kinds) + key, lines)
    upper, lower = body.subfigures(2, 1, height_ratios=[key, 4 * len(kinds)])
    upper.legend(handles=[Line2D([], [], marker=style.MARKS[i], ms=5, lw=1.4, label=f"{name}: {facts_of_level(one['head'])}",
                                 **look(i)) for i, (one, name) in enumerate(zip(results, names))],
                 loc="upper left", ncol=2, handlelength=4.5, frameon=False)
    for cell, kind in zip(np.atleast_1d(lower.subfigures(len(kinds), 1)), kinds):
        axes = cell.subplots()
        found, without = shown(results, names, kind)
        title, draw = SEVERAL[kind]
        if not found:
            style.say_empty(axes, "; ".join(without), title)
            continue
        draw(axes, found)
        axes.set_title(title)
        if without:
            axes.text(0.01, 0.04, "not drawn: " + "; ".join(without), transform=axes.transAxes, color=GREY, fontsize=8)
    return figure


def main(file, picture, kind):
    data = style.read(file)
    if "results" in data:
        figure = several(data)
    else:
        figure = overview(data) if data["what"] == "overview" else one_panel(data)
    style.save(figure, picture, kind)


if __name__ == "__main__":
    main(*sys.argv[1:])
