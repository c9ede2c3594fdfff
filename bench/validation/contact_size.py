#!/usr/bin/env python3
# SPDX-License-Identifier: BSD-3-Clause
"""Vibration over the length of the contact, beside the two regimes of Le Bot and Bou-Chakra (2010)
and of Le Bot, Bou-Chakra and Michon (2011): energy proportional to the contact's area, or
independent of it.

Their law: a contact of the area S gives the power p S, the plate loses D E of its energy E, the
contact c S E. So E = p S/(D + c S), and its exponent over S is the plate's share of the loss, D/(D
+ c S): 1 where the plate's damping wins, 0 where the contact's does. The share can be found without
the exponent. A tenth of the plate's damping raises the energy by R = (D + c S)/(D/10 + c S), so c
S/D = (1 - R/10)/(R - 1).

The contact of ra2d dissipates nothing under penalty. It takes energy from the plate's modes all the
same, to give it to other modes of the plate and of the slider.
"""
import copy
import tomllib

import h5py
import numpy as np
from scipy import stats

import common

SEEDS = 6
LENGTHS = (10e-3, 20e-3, 40e-3, 80e-3, 160e-3)  # m
SETTLED = 0.2    # s: what is before does not count
# Hz: below, a moving load bends the plate, and slow modes do not settle in a second
NOISE = 1000.0
CUTS = (500.0, 2000.0)  # Hz: NOISE halved and doubled
NEAR = LENGTHS[:3]      # m: up to here the block is short beside the plate
PAPER = tomllib.loads((common.ROOT / "scenes" / "dang2012.toml").read_text())
# N/m: the cube's weight
PER_LENGTH = (PAPER["slider"]["density"] * PAPER["slider"]["thickness"] * PAPER["slider"]["width"]
              * 9.80665)
BLOCK, STRIP = {}, {"thickness": 5e-3, "damping": 0.2}
MUCH, USUAL, LITTLE = 0.1, 0.02, 0.002  # damping ratio of the plate
SLIDERS = {  # slider, contact law, whether the load grows with the length
    "block": (BLOCK, "penalty", True),
    "block, one load": (BLOCK, "penalty", False),
    "block, multipliers": (BLOCK, "multiplier", True),
    "damped strip": (STRIP, "penalty", True),
}


def papers(seed, length, damping, slider, law, growing, duration=1.0):
    scene = copy.deepcopy(PAPER)
    # its middle goes from 100 to 200 mm
    scene["scene"].update(duration=duration, start=0.1 - length / 2)
    for body in ("resonator", "slider"):
        scene[body]["surface"]["seed"] += 1000 * seed  # as a study does
    scene["slider"].update(length=length, load=PER_LENGTH * (length if growing else 0.02), **slider)
    scene["resonator"]["damping"] = damping
    scene["contact"] = {"law": law, "stiffness": 1e15}
    scene["time"] = {"scheme": "adaptive",
                     "tolerance": 1e-6} if law == "penalty" else {"scheme": "backward-euler",
                                                                  "step": 1e-6}
    scene["output"] = {"rate": 50e3, "probes": [], "from": min(SETTLED, duration / 2)}
    return scene


def marched(case, scene):
    """Mean square velocities of the plate, of all modes and above NOISE and CUTS; powers [W]: lost
    in plate and slider by their modes' velocities, lost in both by the program's record, given by
    sliding and load, and what of it is then missing: the contact keeps it."""
    names = ("time", "resonator/frequency", "resonator/velocity", "slider/frequency",
             "slider/velocity", "level/v_rms", "shocks/start")
    time, of_plate, plate, of_slider, slider, v_rms, starts = case.run(scene, *names)
    with h5py.File(case.scratch / "result.h5") as file:
        energy, steps = {name: file[f"energy/{name}"][()] for name in file["energy"]
                         if name != "time"}, int(file.attrs["steps"])
    counted = np.flatnonzero(time >= scene["output"]["from"])
    span = time[counted[-1]] - time[counted[0]]
    rise = {name: (record[counted[-1]] - record[counted[0]]) / span
            for name, record in energy.items()}
    given, stored = rise["sliding_work"] + rise["load_work"], rise["kinetic"] + rise[
        "elastic"] + rise["contact"]
    lost = []
    for body, frequency, velocity in (("resonator", of_plate, plate),
                                      ("slider", of_slider, slider)):
        keys = scene[body]
        mass = keys["density"] * keys["thickness"] * keys["width"]
        lost.append((2 * keys["damping"] * mass * 2 * np.pi * frequency
                     * (velocity[counted]**2).mean(0)).sum())
    above = {cut: (plate[counted][:, of_plate > cut]**2).mean(0).sum()
             / scene["resonator"]["length"] for cut in (NOISE, *CUTS)}
    return {"all": float(v_rms)**2, "noise": above.pop(NOISE), **above, "plate": lost[0],
            "slider": lost[1],
            "loss": rise["damping_loss"], "given": given,
            "contact": given - stored - rise["damping_loss"], "steps": steps,
            "rate": (starts >= time[counted[0]]).sum() / span}


def mean(values, confidence=0.95):
    """Mean and half of its interval of Student's t."""
    return np.mean(values), stats.t.ppf(0.5 + confidence / 2, len(values) - 1) * stats.sem(values)


def books(case, found):
    """Under penalty the contact keeps nothing: what the sliding gives is lost in the two bodies."""
    ratio, half = mean([(run["plate"] + run["slider"]) / run["loss"] - 1 for run in found], 0.999)
    case.check("power lost by the modes' velocities, against the recorded loss, off by", abs(ratio),
               half, "the runs: Student's t, 99.9 %")
    for run in found:
        case.check("penalty: power that the contact keeps, of the power given",
                   abs(run["contact"]) / run["given"],
                   2e-6 * np.sqrt(run["steps"]),
                   "twice the tolerance at each step, added up as chance does")


def exponents(by_length, name="noise", lengths=None):
    """Slope of the logarithm of a quantity over that of the length, of each seed."""
    lengths = lengths or list(by_length)
    values = np.log([[run[name] for run in by_length[length]] for length in lengths])
    return np.polyfit(np.log(lengths), values, 1)[0]


def falls(case, name, much, little):
    """The law's sign: the exponent falls with the plate's share of the loss."""
    change, half = mean(exponents(little) - exponents(much), 0.99)
    case.check(f"{name}: exponent over the length, with little damping of the plate less that with "
               "more, upper end of the interval",
               change + half, 0,
               "the law: it falls with the plate's share of the loss. The seeds: Student's t, 99 %")


def decibels(found, name="noise"):
    """Level of each run."""
    return np.array([10 * np.log10(run[name] / 1e-18) for run in found])


def shares(rise):
    """The plate's share of the loss, with its usual and with a tenth of its damping, of what the
    energy rises by [dB]."""
    ratio = np.clip(10**(rise / 10), 1 + 1e-9, 10)
    contact = (1 - ratio / 10) / (ratio - 1)
    return 1 / (1 + contact), 0.1 / (0.1 + contact)


def compare(case):
    if case.short:
        books(case, [marched(case, papers(seed, length, USUAL, *SLIDERS["block"], duration=0.3))
                     for seed in range(3) for length in (10e-3, 40e-3)])
        falls(case, "damped strip",
              *({length: [marched(case, papers(seed, length, damping, *SLIDERS["damped strip"],
                                               duration=0.4))
                          for seed in range(6)] for length in (20e-3, 80e-3)}
                for damping in (USUAL, LITTLE)))
        return
    found = {}
    for name, slider in SLIDERS.items():
        for damping in (MUCH, USUAL, LITTLE) if name == "block" else (USUAL, LITTLE):
            found[name, damping] = {length: [marched(case, papers(seed, length, damping, *slider))
                                             for seed in range(SEEDS)]
                                    for length in LENGTHS}
    books(case, [run for damping in (MUCH, USUAL, LITTLE)
                 for runs in found["block", damping].values() for run in runs])
    for name, much in (("block", MUCH), ("damped strip", USUAL)):
        falls(case, name, found[name, much], found[name, LITTLE])
    report(case, found)


def plus_minus(values, digits=1):
    middle, half = mean(values)
    return f"{middle:.{digits}f} ± {half:.{digits}f}"


def report(case, found):
    levels, slopes, rises, rows, points = [], [], [], [], {}
    for (name, damping), by_length in found.items():
        kept = [100 * np.sum([run["contact"] for run in runs])
                / np.sum([run["given"] for run in runs])
                for runs in by_length.values()]
        levels.append((name, damping, *(plus_minus(decibels(runs)) for runs in by_length.values())))
        slopes.append((name, damping, *(plus_minus(exponents(by_length, what), 2)
                                        for what in (CUTS[0], "noise", CUTS[1])),
                       plus_minus(exponents(by_length, lengths=NEAR), 2),
                       *(plus_minus(exponents(by_length, what), 2) for what in ("all", "given")),
                       *(f"{max(0, share):.0f}" for share in (kept[0], kept[-1]))))
        for length, runs in by_length.items():
            rows.append((name, damping, length, *(number for what in ("noise", *CUTS, "all")
                                                  for number in mean(decibels(runs, what))),
                         *(np.mean([run[key] for run in runs])
                           for key in ("plate", "slider", "given", "rate"))))
    for name in SLIDERS:
        usual, little = found[name, USUAL], found[name, LITTLE]
        raised = {length: decibels(little[length]) - decibels(usual[length]) for length in LENGTHS}
        rises.append((name, *(plus_minus(each) for each in raised.values())))
        for which, (damping, by_length) in enumerate(((USUAL, usual), (LITTLE, little))):
            share = {length: shares(each)[which] for length, each in raised.items()}
            for first, last in zip(LENGTHS, LENGTHS[1:]):
                by_law = (share[first] + share[last]) / 2
                measured = (decibels(by_length[last])
                            - decibels(by_length[first])) / (10 * np.log10(last / first))
                points.setdefault((name, damping), []).append((by_law, measured))
    law = [(name, damping,
            *(cell for by_law, measured in of
              for cell in (plus_minus(by_law, 2), plus_minus(measured))))
           for (name, damping), of in points.items()]
    lengths = [f"{1e3 * length:.0f} mm" for length in LENGTHS]
    case.text("levels", common.markdown(("slider", "plate's damping", *lengths), levels))
    near = f"{1e3 * NEAR[0]:.0f} to {1e3 * NEAR[-1]:.0f} mm"
    case.text("exponents", common.markdown(
        ("slider", "plate's damping",
         *(f"above {cut / 1e3:g} kHz" for cut in (CUTS[0], NOISE, CUTS[1])),
         f"above {NOISE / 1e3:g} kHz, {near} only", "all modes", "power given",
         *(f"kept by the contact at {length}, %" for length in (lengths[0], lengths[-1]))), slopes))
    case.text("near", near)
    case.text("rises", common.markdown(("slider", *lengths), rises))
    doublings = (f"{first[:-3]} to {last}: {what}" for first, last in zip(lengths, lengths[1:])
                 for what in ("by the law", "found"))
    case.text("law", common.markdown(("slider", "plate's damping", *doublings), law))
    for word, multipliers in (("penalty", False), ("multipliers", True)):
        apart = [mean(measured - by_law) for (name, _), of in points.items()
                 if ("multipliers" in name) == multipliers for by_law, measured in of]
        off = [abs(middle) > half for middle, half in apart]
        case.text(f"off-{word}", f"{sum(off)} of {len(off)}")
    for damping, word in ((MUCH, "much"), (USUAL, "usual"), (LITTLE, "little")):
        case.text(f"exponent-{word}", plus_minus(exponents(found["block", damping]), 2))
        case.text(f"near-{word}", plus_minus(exponents(found["block", damping], lengths=NEAR), 2))
    for word, of in {"block": ("block", MUCH), "strip": ("damped strip", LITTLE),
                     "strip-usual": ("damped strip", USUAL),
                     "multipliers": ("block, multipliers", LITTLE)}.items():
        by_length = found[of]
        case.text(f"far-{word}",
                  plus_minus(decibels(by_length[80e-3]) - decibels(by_length[20e-3])))
        case.text(f"exponent-{word}", plus_minus(exponents(by_length), 2))
    for word, name, much in (("block", "block", MUCH), ("strip", "damped strip", USUAL)):
        for cut, what in ((CUTS[0], CUTS[0]), (NOISE, "noise"), (CUTS[1], CUTS[1])):
            change = exponents(found[name, LITTLE], what) - exponents(found[name, much], what)
            case.text(f"change-{word}-{cut:.0f}", plus_minus(change, 2))
    for length in (LENGTHS[0], LENGTHS[-1]):
        case.text(f"rate-{1e3 * length:.0f}",
                  np.mean([run["rate"] for run in found["block", USUAL][length]]))
    shortest = found["block, multipliers", LITTLE][LENGTHS[0]]
    case.text("kept",
              100 * np.sum([run["contact"] for run in shortest])
              / np.sum([run["given"] for run in shortest]))
    case.text("seeds", f"{SEEDS}")
    case.text("per-length", PER_LENGTH, 3)
    case.table(("slider", "damping of the plate", "length, m", "level above 1 kHz, dB",
                "half of its 95 % interval",
                "level above 0.5 kHz, dB", "half of its 95 % interval",
                "level above 2 kHz, dB", "half of its 95 % interval", "level of all modes, dB",
                "half of its 95 % interval",
                "lost in the plate, W", "lost in the slider, W", "given, W", "shocks, 1/s"), rows)
    draw(case, found, points)


def draw(case, found, points):
    plt, style = common.pyplot()
    figure, (left, right, legend_axes) = plt.subplots(1, 3, figsize=(10.5, 4), layout="constrained",
                                                      width_ratios=(1, 1, 0.5))
    styles = zip([*style.SERIES, style.GREY], [*style.MARKS, "<"], [*style.LINES, "-"])
    for ((name, damping), by_length), (colour, mark, line) in zip(found.items(), styles):
        middle, half = zip(*(mean(decibels(runs)) for runs in by_length.values()))
        left.errorbar([1e3 * length for length in by_length], middle, yerr=half, color=colour,
                      marker=mark, ls=line, ms=4, lw=1.1,
                      capsize=2, label=f"{name}, {damping:g}")
        if (name, damping) in points:
            (share, wide), (exponent,
                            error) = (np.transpose([mean(each[which])
                                                    for each in points[name, damping]])
                                      for which in (0, 1))
            right.errorbar(share, exponent, xerr=wide, yerr=error, color=colour, marker=mark, ls="",
                           ms=4.5, lw=0.8, capsize=2)
    first = np.mean(decibels(found["block", MUCH][LENGTHS[0]])) - 4
    left.plot([1e3 * LENGTHS[0], 1e3 * LENGTHS[-1]],
              [first, first + 10 * np.log10(LENGTHS[-1] / LENGTHS[0])], color=style.BLACK, lw=0.8)
    left.annotate("proportional", (35, first + 2.5), color=style.GREY, fontsize=8)
    left.set(xscale="log", title="Level above 1 kHz, by slider and plate's damping",
             xlabel="length of the slider [mm]",
             ylabel="dB re 1 nm/s")
    left.set_xticks([1e3 * length for length in LENGTHS],
                    [f"{1e3 * length:.0f}" for length in LENGTHS])
    left.minorticks_off()
    right.plot([0, 1], [0, 1], color=style.BLACK, lw=0.8)
    right.set(title="Exponent of each doubling (line: the law)",
              xlabel="plate's share of the loss, from a tenth of its damping",
              ylabel="exponent of the energy")
    legend_axes.set_axis_off()
    legend_axes.legend(*left.get_legend_handles_labels(), loc="center left", frameon=False)
    case.figure(figure)


if __name__ == "__main__":
    common.main("contact-size", compare)
