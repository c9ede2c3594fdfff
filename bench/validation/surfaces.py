#!/usr/bin/env python3
# SPDX-License-Identifier: BSD-3-Clause
"""The paper's Table 2 beside random profiles of ra2d, which `ra2d surface generate` makes and `ra2d
surface measure` measures.

The paper says "gaussian height distribution", and prints a kurtosis of 3.6 to 4.6. So for each row
of the table there are profiles of the plate's length with the row's Rq and RSm and with heights of
three kinds: normal ones, ones of the row's Rku, and flat ones, of the kurtosis of a uniform
distribution, which have the paper's Ra.

The paper names no filter and no sampling length. Here there is no filter, and sampling lengths are
2.5 mm. RSm is that of ISO 21920-2, which leaves out small elements. `--rsm` of `surface generate`
is the distance of upward crossings; it is asked for so that the median RSm is the paper's.
"""
import json

import numpy as np
from scipy import stats

import common

NAMES = ("Rq", "Rt", "Rz", "Ra", "Rku", "RSm")
ROWS = ((2, 12.8, 6.0, 1.7, 3.6, 1574), (4, 27.8, 12.2, 3.5, 4.6, 1520),
        (8, 53.0, 23.5, 6.8, 3.6, 1560),
        (12, 86.7, 36.1, 10.4, 3.8, 1552), (20, 138, 61, 17.6, 4.2, 1546))  # um, but for Rku
LENGTH, SPACING, SAMPLING = 0.3, 8e-6, 2.5e-3  # m
SECTIONS = round(LENGTH / SAMPLING)
CROSSING = 1.19  # RSm over the distance of upward crossings, of such profiles
SEEDS = 40
FLAT = 1.8  # kurtosis of a uniform distribution


def generated(case, row, kurtosis, seed):
    """The file of a profile."""
    file = case.scratch / "profile.csv"
    case.call(case.program, "surface", "generate", "-o", file, "--length", LENGTH, "--spacing",
              SPACING, "--rq", f"{row[0]}e-6",
              "--rsm", f"{row[5] / CROSSING:.6g}e-6", "--kurtosis", kurtosis, "--seed",
              seed, "--quiet")
    return file


def measured(case, file):
    """NAMES of a profile [um, but for Rku]."""
    found = json.loads(case.call(case.program, "surface", "measure", file, "--filter", "none",
                                 "--cutoff", SAMPLING,
                                 "--sampling-lengths", "all", "--json"))["parameters"]
    return [found[name] * (1 if name == "Rku" else 1e6) for name in NAMES]


def by_numpy(z):
    """Parameters of heights by their definitions: all but RSm. Rz is the mean height of the
    sampling lengths."""
    z = z - z.mean()
    rq = np.sqrt((z**2).mean())
    # a sampling length is no whole number of nodes
    ends = len(z) * np.arange(1, SECTIONS) // SECTIONS
    return {"Rq": rq, "Rt": np.ptp(z), "Rz": np.mean([np.ptp(part) for part in np.split(z, ends)]),
            "Ra": np.abs(z).mean(),
            "Rku": (z**4).mean() / rq**4}


def spread_of_rq(row):
    """Variance of Rq^2 over its mean of normal heights with the correlation exp(-(x/l)^2), over
    LENGTH: 2 l sqrt(pi/2)/LENGTH. Rice: the distance of upward crossings is sqrt(2) pi l."""
    return np.sqrt(2 * np.pi) * 1e-6 * row[5] / CROSSING / (np.sqrt(2) * np.pi) / LENGTH


def compare(case):
    rows, seeds = (ROWS[2:3], 6) if case.short else (ROWS, SEEDS)
    found = {}  # of (row, kind): an array (seed, NAMES)
    for i, row in enumerate(rows):
        for kind, kurtosis in (("normal", 3), ("row's", row[4]), ("flat", FLAT)):
            if case.short and kind != "normal":
                continue
            profiles = []
            for seed in range(1000 * i, 1000 * i + seeds):
                file = generated(case, row, kurtosis, seed)
                profiles.append(measured(case, file))
                if seed % 1000 == 0:
                    against_numpy(case, kind, row, file, profiles[-1])
            found[row, kind] = np.array(profiles)
    normal = np.concatenate([found[row, "normal"] for row in rows])
    bias = max(spread_of_rq(row) for row in rows)
    ratio = np.sqrt(2 / np.pi)
    for name, values, expected, of_bias in (
            ("Ra/Rq", normal[:, NAMES.index("Ra")] / normal[:, NAMES.index("Rq")], ratio,
             bias / 8 * ratio),
            ("Rku", normal[:, NAMES.index("Rku")], 3, 3 * bias)):
        case.check(f"normal heights: mean {name}, from {common.shown(expected, 3)}",
                   abs(values.mean() - expected),
                   stats.t.ppf(0.9999, len(values) - 1) * stats.sem(values) + of_bias,
                   f"{len(values)} profiles: beyond by chance once in 5000 times; and what a "
                   "finite length leaves out")
    if not case.short:
        report(case, found)


def against_numpy(case, kind, row, file, profile):
    z = 1e6 * np.loadtxt(file, delimiter=",", skiprows=2, usecols=1)
    options = np.abs(by_numpy(z)["Rq"] / row[0] - 1)
    case.check("Rq over the one asked for, from 1", options, (z**2).max() / row[0]**2 / len(z),
               "the weight of one node at an end")
    for name, value in by_numpy(z[:-1]).items():  # the last point begins another sampling length
        case.check("`surface measure` beside the definitions, in numpy",
                   abs(profile[NAMES.index(name)] / value - 1), 1e-10,
                   f"roundings of sums over {len(z)} heights")


def report(case, found):
    words = {"normal": "normal heights", "row's": "heights of the row's Rku",
             "flat": f"flat heights, Rku {FLAT}"}
    within = {kind: np.zeros(len(NAMES), int) for kind in words}
    table, numbers = [], []
    for row in ROWS:
        table.append(("paper", *(f"**{value:g}**" for value in row)))
        numbers.append(("paper", row[0], "", *row))
        for kind, name in words.items():
            low, middle, high = np.percentile(found[row, kind], (5, 50, 95), axis=0)
            within[kind] += (low <= row) & (row <= high)
            table.append((name, *(f"{m:.4g}" if key == "Rq" else f"{m:.4g} ({a:.4g} to {b:.4g})"
                                  for key, a, m, b in zip(NAMES, low, middle, high))))
            numbers += [(name, row[0], what, *values)
                        for what, values in (("5 %", low), ("median", middle), ("95 %", high))]
    case.table(("heights", "row: Rq, um", "of the seeds",
                *(name if name == "Rku" else f"{name}, um" for name in NAMES)), numbers)
    head = [name if name == "Rku" else f"{name}, um" for name in NAMES]
    case.text("table", common.markdown(("", *head), table))
    case.text("within", common.markdown(("", *NAMES[1:-1]), [
        (name, *(f"{count} of {len(ROWS)}" for count in within[kind][1:-1]))
        for kind, name in words.items()]))
    case.text("crossing", f"{CROSSING}")
    case.text("seeds", str(SEEDS))
    ratios = [row[3] / row[0] for row in ROWS]
    case.text("ra-least", min(ratios), 3)
    case.text("ra-most", max(ratios), 3)
    case.text("inequality", max((row[0] / row[3])**2 for row in ROWS))
    rz = [np.median(found[row, "normal"][:, NAMES.index("Rz")]) / row[2] - 1 for row in ROWS]
    case.text("rz-least", 100 * min(rz))
    case.text("rz-most", 100 * max(rz))
    u = np.sqrt(2 * np.log(LENGTH / (1e-6 * np.mean([row[5] for row in ROWS]) / CROSSING)))
    case.text("extremes", 2 * (u + np.euler_gamma / u))
    case.text("papers-extremes", np.mean([row[1] / row[0] for row in ROWS]))
    for kind in ("normal", "flat"):
        every = np.concatenate([found[row, kind] for row in ROWS])
        for name in ("Ra", "Rt"):
            case.text(f"{kind}-{name}", np.median(every[:, NAMES.index(name)] / every[:, 0]), 3)
    draw(case, found, words)


def draw(case, found, words):
    plt, style = common.pyplot()
    # the legend stands in the foot
    figure, (panels, foot) = plt.subplots(2, 4, figsize=(7, 3.4), layout="constrained",
                                          sharey="row",
                                          gridspec_kw={"height_ratios": (8, 1.7)})
    shown = (("Rt", lambda of: of("Rt") / of("Rq"), "Rt / Rq"),
             ("Rz", lambda of: of("Rz") / of("Rq"), "Rz / Rq"),
             ("Ra", lambda of: of("Ra") / of("Rq"), "Ra / Rq"),
             ("Rku", lambda of: of("Rku"), "Rku"))
    rows = np.arange(len(ROWS))
    for axes, (_, value, title) in zip(panels, shown):
        for j, (kind, colour) in enumerate(zip(words, (style.BLUE, style.RUST, style.GREEN))):
            middle, low, high = np.array(
                [np.percentile(value(lambda name: found[row, kind][:, NAMES.index(name)]),
                               (50, 5, 95))
                 for row in ROWS]).T
            axes.errorbar(middle, rows + 0.2 * (j - 1), xerr=(middle - low, high - middle),
                          fmt=style.MARKS[j], ms=3.5,
                          color=colour, lw=1, label=words[kind])
        axes.plot([value(lambda name: row[NAMES.index(name)]) for row in ROWS], rows, "x",
                  color=style.BLACK, ms=6, mew=1.5,
                  label="the paper's table")
        axes.set(title=title)
        axes.grid(axis="y", visible=False)
    panels[0].set(yticks=rows, yticklabels=[f"{row[0]} um" for row in ROWS], ylabel="Rq")
    panels[0].invert_yaxis()
    for axes in foot:
        axes.axis("off")
    figure.legend(*panels[0].get_legend_handles_labels(), loc="lower center", ncols=2)
    case.figure(figure)


if __name__ == "__main__":
    common.main("surfaces", compare)
