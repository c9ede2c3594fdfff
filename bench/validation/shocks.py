#!/usr/bin/env python3
# SPDX-License-Identifier: BSD-3-Clause
"""Shocks of the paper's scene: how many, how long, how hard; over load, speed and roughness, and towards rigid contact;
beside what the paper's authors published later, and beside three things that must hold.

Momentum: the slider is carried by shocks alone, so their impulses add up to load times time, less what the slider's
mean velocity has gained. Duration: a node that meets a stiff spring leaves it after half a period of that spring on the
masses of all modes, pi sqrt(m/(kappa chi w)), 1/m the sum of psi^2/mu over both bodies' modes at the place. Unbroken
contact: where the slider's support goes from one asperity to another, its velocity jumps by the speed times the
difference of the slopes. The contact spring holds a jump of up to g/omega. Jumps add up while it rings, so contact is
unbroken for certain only far below.
"""
import copy
import tomllib

import h5py
import numpy as np
from scipy import stats

import common
import plate

GRAVITY = 9.80665  # m/s^2, the standard one
TOLERANCE = 1e-6
SEEDS = 10
THESIS_RATE = 1e4  # 1/s
ORDER = 0.5        # decades: what "of the order of" leaves open
SPEEDS = (0.001, 0.002, 0.005, 0.01, 0.02, 0.05, 0.1, 0.2, 0.5)  # m/s
LOADS = (0.1, 1, 10, 100)                                # of the weight
ROUGHNESS = (2e-6, 4e-6, 8e-6, 12e-6, 20e-6)             # m
STIFFNESS = (1e13, 1e14, 1e15, 1e16, 1e17, 1e18, 1e19)   # Pa/m
OTHER_STIFFNESS, FEWER_SEEDS = (1e13, 1e17), 4           # of the regimes
MULTIPLIERS = (("backward-euler", 1e-6), ("backward-euler", 1e-7), ("backward-euler", 1e-8), ("midpoint", 1e-7))
SPACINGS = (16e-6, 8e-6, 4e-6, 2e-6)                     # m
PAPER = tomllib.loads((common.ROOT / "scenes" / "dang2012.toml").read_text())
SLIDER = PAPER["slider"]
MASS = SLIDER["density"] * SLIDER["length"] * SLIDER["thickness"] * SLIDER["width"]
WEIGHT = MASS * GRAVITY


def papers(seed=0, duration=1.0, speed=0.1, load=1.0, rq=8e-6, stiffness=1e15, spacing=8e-6, multipliers=None):
    """The paper's scene, with what is varied; `load` in weights, `multipliers`: scheme and step [s]."""
    scene = copy.deepcopy(PAPER)
    scene["scene"].update(speed=speed, duration=min(duration, 0.17 / speed), spacing=spacing)  # the plate ends
    for body in ("resonator", "slider"):
        scene[body]["surface"]["seed"] += 1000 * seed  # as a study does
        scene[body]["surface"]["rq"] = rq
    scene["slider"]["load"] = load * WEIGHT
    scene["contact"] = {"law": "penalty", "stiffness": stiffness}
    scene["time"] = {"scheme": "adaptive", "tolerance": TOLERANCE}
    if multipliers:
        scene["contact"] = {"law": "multiplier"}
        scene["time"] = {"scheme": multipliers[0], "step": multipliers[1]}
    scene["output"] = {"rate": 20 / scene["scene"]["duration"], "probes": []}
    return scene


def inverse_mass(place, along):
    """sum of psi^2/mu over all modes [1/kg], at places of the plate and along the slider [m]."""
    modes = (plate.omegas(100) < 2 * np.pi * PAPER["resonator"]["max_frequency"]).sum()
    of_plate = sum(2 / plate.LENGTH * np.sin(wave * place)**2 for wave in plate.waves(modes)) / plate.MASS_PER_LENGTH
    return of_plate + (1 + 12 * (along / SLIDER["length"] - 0.5)**2) / MASS  # the slider goes up and down, and tilts


def unbroken_below(stiffness):
    """Speed [m/s] at which the contact spring just holds what a usual change of the slope throws up. The slope is the
    root mean square of a face, 2 pi Rq/RSm; the two slopes of a contact are equal and opposite."""
    surface = PAPER["resonator"]["surface"]
    spring = stiffness * PAPER["scene"]["spacing"] * SLIDER["width"]
    omega = np.sqrt(spring * inverse_mass(plate.LENGTH / 2 + np.zeros(1), SLIDER["length"] / 2)[0])
    return GRAVITY / omega / (2 * np.pi * surface["rq"] / surface["rsm"])


OF_SHOCKS = ("start", "duration", "peak_force", "impulse", "position")


def marched(case, scene):
    """A run's shocks, each an array, and its single figures."""
    found = dict(zip(OF_SHOCKS, case.run(scene, *(f"shocks/{name}" for name in OF_SHOCKS))))
    with h5py.File(case.scratch / "result.h5") as file:
        velocity = file["slider/velocity"][:, 0] / np.sqrt(SLIDER["length"])  # of its middle, towards the plate
        steps = int(file.attrs["steps"])
        found["level"], found["share"] = file["level/lv"][()], file["summary/contact_share"][()]
    keys, penalty = scene["scene"], scene["contact"]["law"] == "penalty"
    span, load = keys["duration"], scene["slider"]["load"]
    carried = load * span - MASS * (velocity[-1] - velocity[0])
    found["rate"] = len(found["start"]) / span
    found["off"] = abs(found["impulse"].sum() / carried - 1)
    found["may be off"] = steps * (TOLERANCE * MASS * np.abs(velocity).max() / carried if penalty else np.finfo(float).eps)
    case.check(f"{'penalty' if penalty else 'multipliers'}: sum of impulses, against load times time, off by", found["off"],
               found["may be off"], "the tolerance, at every step" if penalty else "a rounding at every step")
    if penalty:
        along = found["position"] - keys["start"] - keys["speed"] * (found["start"] + found["duration"] / 2)
        spring = scene["contact"]["stiffness"] * keys["spacing"] * SLIDER["width"]
        found["half period"] = np.pi / np.sqrt(spring * inverse_mass(found["position"], along))
    return found


def runs(case, seeds=SEEDS, **changes):
    return [marched(case, papers(seed, **changes)) for seed in range(seeds)]


def mean(values):
    """Mean and half of its 95 % interval of Student's t."""
    return np.mean(values), stats.t.ppf(0.975, len(values) - 1) * stats.sem(values)


def over(found, name):
    """Of all shocks of several runs."""
    return np.concatenate([each[name] for each in found])


def longer(found):
    """The median of duration over half period, less 1."""
    return np.median(over(found, "duration") / over(found, "half period")) - 1


def rigid(case, soft, stiff, decades):
    """The closed form of a shock, at the ends of some decades of stiffness."""
    first, last = longer(soft), longer(stiff)
    case.check("duration over half a period, less 1, over what 1/sqrt(kappa) makes of a softer spring's",
               abs(last) / (abs(first) * 10**(-decades / 2)), 1.5, "what disturbs a shock acts for its duration, ~ 1/sqrt(kappa)")
    angle = 2 * np.pi * PAPER["resonator"]["max_frequency"] * np.median(over(stiff, "duration"))
    case.check("duration over half a period, less 1, of the stiffest spring", abs(last), angle,
               "how far the fastest mode turns meanwhile, in radians")
    shape = np.median(over(stiff, "impulse") / over(stiff, "peak_force") / over(stiff, "duration"))
    case.check("impulse over peak times duration, against 2/pi, off by", abs(shape * np.pi / 2 - 1), angle, "the same: a half sine")
    return first, last, shape


PARTS = (1, 4, 10)  # of the speed that the spring holds


def unbroken(case, stiffness, seeds, parts=PARTS):
    """Share of the time without contact at parts of the speed that the spring holds."""
    apart = []
    for part in parts:
        found = runs(case, seeds, speed=unbroken_below(stiffness) / part, stiffness=stiffness, duration=0.1 if case.short else 1.0)
        apart.append(1 - np.mean([each["share"] for each in found]))
    case.check("share of the time without contact, at a tenth of the speed that the spring holds", apart[-1], 2 * stats.norm.sf(10),
               "slopes are normal: ten standard deviations")
    return apart


def compare(case):
    if case.short:
        runs(case, 2, duration=0.1)
        runs(case, 1, duration=0.05, multipliers=("backward-euler", 1e-6))
        rigid(case, *(runs(case, 2, duration=0.1, stiffness=stiffness) for stiffness in (1e17, 1e19)), 2)
        unbroken(case, 1e15, 1, PARTS[-1:])
        return
    report(case)


WHAT = ("shocks a second", "duration, us: median", "10 to 90 %", "peak / weight: median", "99 %", "largest in a run",
        "time in contact", "level, dB")


def plus_minus(values, digits=2):
    """mean ± half of the interval, with as many digits as the latter has."""
    middle, half = mean(values)
    places = max(0, digits - 1 - int(np.floor(np.log10(half)))) if half > 0 else 2
    return f"{middle:.{places}f} ± {half:.{places}f}"


def share(value):
    return f"{100 * value:.3g} %" if value < 0.9995 or value == 1 else f"{100 * value:.4f} %"


def row(found):
    """What a table says of some runs."""
    duration, peak = 1e6 * over(found, "duration"), over(found, "peak_force") / WEIGHT
    low, high = np.quantile(duration, (0.1, 0.9))
    return (plus_minus([each["rate"] for each in found]), common.shown(np.median(duration)),
            f"{common.shown(low)} to {common.shown(high)}", common.shown(np.median(peak)), common.shown(np.quantile(peak, 0.99)),
            plus_minus([each["peak_force"].max() / WEIGHT for each in found], 1), share(np.mean([each["share"] for each in found])),
            plus_minus([each["level"] for each in found]))


def numbers(found):
    """The same for other programs."""
    rates, levels = mean([each["rate"] for each in found]), mean([each["level"] for each in found])
    return (*rates, *np.quantile(over(found, "duration"), (0.1, 0.5, 0.9, 0.99)),
            *np.quantile(over(found, "peak_force") / WEIGHT, (0.1, 0.5, 0.9, 0.99, 1)),
            np.mean([each["share"] for each in found]), *levels)


def report(case):
    base = runs(case)
    sweeps = {
        "speed": ("speed, m/s", {speed: base if speed == 0.1 else runs(case, speed=speed) for speed in SPEEDS}),
        "load": ("load / weight", {load: base if load == 1 else runs(case, load=load) for load in LOADS}),
        "roughness": ("Rq, um", {1e6 * rq: base if rq == 8e-6 else runs(case, rq=rq) for rq in ROUGHNESS}),
        "spacing": ("spacing, um", {1e6 * spacing: runs(case, spacing=spacing, duration=0.5) for spacing in SPACINGS}),
        "stiffness": ("kappa, Pa/m", {stiffness: runs(case, stiffness=stiffness, duration=0.5) for stiffness in STIFFNESS}),
    }
    rows = []
    for name, (what, sweep) in sweeps.items():
        case.text(name, common.markdown((what, *WHAT), [(common.shown(value, 1), *row(found)) for value, found in sweep.items()]))
        rows += [(name, value, *numbers(found)) for value, found in sweep.items()]
    limits = {}
    for scheme, step in MULTIPLIERS:
        seeds, duration = (SEEDS, 0.5) if step > 1e-8 else (FEWER_SEEDS, 0.1)
        limits[scheme, step] = runs(case, seeds, multipliers=(scheme, step), duration=duration)
    case.text("multipliers", common.markdown(("multipliers, step, s", *WHAT), [
        (f"`{scheme}`, {common.shown(step, 1)}", *row(found)) for (scheme, step), found in limits.items()]))
    rows += [(f"multipliers, {scheme}", step, *numbers(found)) for (scheme, step), found in limits.items()]
    stiffest = sweeps["stiffness"][1]
    case.text("closed-form", common.markdown(
        ("kappa, Pa/m", "median of duration over half a period, less 1", "median of impulse / (peak x duration)"),
        [(common.shown(stiffness, 1), common.shown(longer(found)),
          common.shown(np.median(over(found, "impulse") / over(found, "peak_force") / over(found, "duration")), 4))
         for stiffness, found in stiffest.items()]))
    rigid(case, stiffest[1e18], stiffest[1e19], 1)
    case.check("shocks a second at the paper's numbers, against the thesis, decades off",
               abs(np.log10(np.mean([each["rate"] for each in base]) / THESIS_RATE)), ORDER, "\"of the order of\": half a decade")
    regimes = {1e15: sweeps["speed"][1]}
    for stiffness in OTHER_STIFFNESS:
        regimes[stiffness] = {speed: runs(case, FEWER_SEEDS, speed=speed, stiffness=stiffness, duration=0.5) for speed in SPEEDS[::2]}
    regimes = {stiffness: {speed: [np.mean([each[name] for each in found]) for name in ("share", "rate")]
                           for speed, found in by_speed.items()} for stiffness, by_speed in regimes.items()}
    apart = {stiffness: unbroken(case, stiffness, FEWER_SEEDS) for stiffness in sorted(regimes)}
    case.text("regimes", common.markdown(
        ("kappa, Pa/m", "the spring holds up to, mm/s", "time without contact at that speed", *(f"at 1/{part} of it" for part in PARTS[1:]),
         *(f"time in contact at {speed} m/s" for speed in SPEEDS[::2])),
        [(common.shown(stiffness, 1), common.shown(1e3 * unbroken_below(stiffness)), *map(common.shown, apart[stiffness]),
          *(share(by_speed[speed][0]) for speed in SPEEDS[::2])) for stiffness, by_speed in sorted(regimes.items())]))
    softer, harder = ([each["level"] for each in found] for found in (stiffest[1e18], limits["backward-euler", 1e-7]))
    case.text("level-apart", plus_minus(np.subtract(softer, harder)))
    case.text("rate", plus_minus([each["rate"] for each in base]))
    case.text("rigid-rate", plus_minus([each["rate"] for each in stiffest[1e19]]))
    case.text("largest", plus_minus([each["peak_force"].max() / WEIGHT for each in base], 1))
    coarse, fine = (np.mean([each["rate"] for each in sweeps["spacing"][1][1e6 * spacing]]) for spacing in (8e-6, 4e-6))
    case.text("finer", 100 * (1 - fine / coarse))
    sticking = np.mean([each["share"] for each in limits["backward-euler", 1e-7]])
    case.text("sticking", 100 * sticking)
    case.text("median", 1e6 * np.median(over(base, "duration")))
    case.text("thesis-stiffness", 1e15 * (np.median(over(base, "duration")) / 1e-4)**2, 1)
    case.text("seeds", f"{SEEDS}")
    case.text("fewer", f"{FEWER_SEEDS}")
    case.text("momentum", max(found for what, (found, *_) in case.checks.items() if "impulses" in what))
    case.text("holds", 1e3 * unbroken_below(1e15))
    case.text("longer", longer(stiffest[1e19]))
    names = ("rate, 1/s", "half of its 95 % interval", *(f"duration, {q} %, s" for q in (10, 50, 90, 99)),
             *(f"peak over weight, {q} %" for q in (10, 50, 90, 99, 100)), "share of time in contact", "level, dB", "half of its 95 % interval")
    case.table(("what is varied", "value", *names), rows)
    draw(case, sweeps, regimes)


def draw(case, sweeps, regimes):
    plt, style = common.pictures()
    figure, ((durations, forces), (contact, rates)) = plt.subplots(2, 2, figsize=(9, 7), layout="constrained")
    part = np.linspace(0, 1, 201)
    for (stiffness, found), colour, line in zip(sweeps["stiffness"][1].items(), style.SERIES, style.LINES):
        durations.semilogx(1e6 * np.quantile(over(found, "duration"), part), part, color=colour, ls=line, lw=1.3,
                           label=f"{common.shown(stiffness, 1)}")
    durations.axvspan(1, 100, color=style.GREY, alpha=0.12, lw=0)
    durations.set(title="Durations, by kappa [Pa/m]", xlabel="us (grey: the authors, 1 us to 0.1 ms)",
                  ylabel="share that is shorter", xlim=(0.1, 1e4))
    durations.legend(loc="lower right")
    larger = np.logspace(-4, 0, 201)
    for speed, colour, line in zip(SPEEDS[:2:-1], style.SERIES, style.LINES):
        peak = over(sweeps["speed"][1][speed], "peak_force") / WEIGHT
        forces.loglog(np.quantile(peak, 1 - larger), larger, color=colour, ls=line, lw=1.3, label=f"{speed:g} m/s")
    forces.axvline(100, color=style.GREY, lw=1)
    forces.set(title="Peak forces, by speed", xlabel="peak over weight (line: the authors' largest)",
               ylabel="share that is larger", ylim=(1e-4, 1.5), xlim=(0.1, 1e3))
    forces.legend(loc="lower left")
    for (stiffness, by_speed), colour, mark in zip(sorted(regimes.items()), style.SERIES, style.MARKS):
        speeds = sorted(by_speed)
        label = f"{common.shown(stiffness, 1)} Pa/m"
        contact.semilogx(speeds, [100 * by_speed[speed][0] for speed in speeds], color=colour, marker=mark, ms=4, lw=1.2, label=label)
        contact.axvline(unbroken_below(stiffness), color=colour, lw=1, ls=":")
        rates.loglog(speeds, [by_speed[speed][1] for speed in speeds], color=colour, marker=mark, ms=4, lw=1.2, label=label)
    contact.set(title="Time in contact (dotted: what the spring holds)", xlabel="speed [m/s]", ylabel="%", ylim=(-3, 103))
    contact.legend(loc="lower left")
    rates.axhline(THESIS_RATE, color=style.GREY, lw=1)
    rates.set(title="Shocks a second (line: the authors')", xlabel="speed [m/s]")
    rates.legend(loc="lower right")
    case.figure(figure)


if __name__ == "__main__":
    common.main("shocks", compare)
