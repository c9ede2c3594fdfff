#!/usr/bin/env python3
# SPDX-License-Identifier: BSD-3-Clause
"""Shocks of the paper's scene: how many, how long, how hard; over load, speed and roughness, and
towards rigid contact; over the spacing of two springs; beside what the paper's authors published
later, and beside three things that must hold.

Momentum: the slider is carried by shocks alone, so their impulses add up to load times time, less
what the slider's mean velocity has gained. Duration: a node that meets a stiff spring leaves it
after half a period of that spring on the masses of all modes, pi sqrt(m/(kappa chi w)), 1/m the sum
of psi^2/mu over both bodies' modes at the place. Unbroken contact: where the slider's support goes
from one asperity to another, its velocity jumps by the speed times the difference of the slopes.
The contact spring holds a jump of up to g/omega. Jumps add up while it rings, so contact is
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
SPEEDS = (0.001, 0.002, 0.005, 0.01, 0.02, 0.05, 0.1, 0.2, 0.5)  # m/s
LOADS = (0.1, 1, 10, 100)                                # of the weight
ROUGHNESS = (2e-6, 4e-6, 8e-6, 12e-6, 20e-6)             # m
STIFFNESS = (1e13, 1e14, 1e15, 1e16, 1e17, 1e18, 1e19)   # Pa/m
OTHER_STIFFNESS, FEWER_SEEDS = (1e13, 1e17), 4           # of the regimes
MULTIPLIERS = (("backward-euler", 1e-6), ("backward-euler", 1e-7), ("backward-euler", 1e-8),
               ("midpoint", 1e-7))
SPACINGS = (16e-6, 8e-6, 4e-6, 2e-6, 1e-6)               # m
STIFF = 1e18                                             # Pa/m, of the second sweep of the spacing
PAPER = tomllib.loads((common.ROOT / "scenes" / "dang2012.toml").read_text())
SLIDER = PAPER["slider"]
MASS = SLIDER["density"] * SLIDER["length"] * SLIDER["thickness"] * SLIDER["width"]
WEIGHT = MASS * GRAVITY


def papers(seed=0, duration=1.0, speed=0.1, load=1.0, rq=8e-6, stiffness=1e15, spacing=8e-6,
           multipliers=None):
    """The paper's scene, with what is varied; `load` in weights, `multipliers`: scheme and step
    [s]."""
    scene = copy.deepcopy(PAPER)
    # the plate ends
    scene["scene"].update(speed=speed, duration=min(duration, 0.17 / speed), spacing=spacing)
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
    of_plate = sum(2 / plate.LENGTH * np.sin(wave * place)**2
                   for wave in plate.waves(modes)) / plate.MASS_PER_LENGTH
    # the slider goes up and down, and tilts
    return of_plate + (1 + 12 * (along / SLIDER["length"] - 0.5)**2) / MASS


def unbroken_below(stiffness):
    """Speed [m/s] at which the contact spring just holds what a usual change of the slope throws
    up. The slope is the root mean square of a face, 2 pi Rq/RSm; the two slopes of a contact are
    equal and opposite."""
    surface = PAPER["resonator"]["surface"]
    spring = stiffness * PAPER["scene"]["spacing"] * SLIDER["width"]
    omega = np.sqrt(spring * inverse_mass(plate.LENGTH / 2 + np.zeros(1), SLIDER["length"] / 2)[0])
    return GRAVITY / omega / (2 * np.pi * surface["rq"] / surface["rsm"])


OF_SHOCKS = ("start", "duration", "peak_force", "impulse", "position")


def marched(case, scene):
    """A run's shocks, each an array, and its single figures."""
    found = dict(zip(OF_SHOCKS, case.run(scene, *(f"shocks/{name}" for name in OF_SHOCKS))))
    with h5py.File(case.scratch / "result.h5") as file:
        # of its middle, towards the plate
        velocity = file["slider/velocity"][:, 0] / np.sqrt(SLIDER["length"])
        steps = int(file.attrs["steps"])
        found["level"], found["share"] = file["level/lv"][()], file["summary/contact_share"][()]
    keys, penalty = scene["scene"], scene["contact"]["law"] == "penalty"
    span, load = keys["duration"], scene["slider"]["load"]
    carried = load * span - MASS * (velocity[-1] - velocity[0])
    found["rate"] = len(found["start"]) / span
    found["off"] = abs(found["impulse"].sum() / carried - 1)
    found["may be off"] = steps * (TOLERANCE * MASS * np.abs(velocity).max() / carried if penalty
                                   else np.finfo(float).eps)
    case.check(f"{'penalty' if penalty else 'multipliers'}: sum of impulses, against load times "
               "time, off by", found["off"],
               found["may be off"], "the tolerance, at every step" if penalty
               else "a rounding at every step")
    if penalty:
        along = found["position"] - keys["start"] - keys["speed"] * (found["start"]
                                                                     + found["duration"] / 2)
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
    case.check("duration over half a period, less 1, over what 1/sqrt(kappa) makes of a softer "
               "spring's",
               abs(last) / (abs(first) * 10**(-decades / 2)), 1.5,
               "what disturbs a shock acts for its duration, ~ 1/sqrt(kappa)")
    angle = 2 * np.pi * PAPER["resonator"]["max_frequency"] * np.median(over(stiff, "duration"))
    case.check("duration over half a period, less 1, of the stiffest spring", abs(last), angle,
               "how far the fastest mode turns meanwhile, in radians")
    shape = np.median(over(stiff, "impulse") / over(stiff, "peak_force") / over(stiff, "duration"))
    case.check("impulse over peak times duration, against 2/pi, off by", abs(shape * np.pi / 2 - 1),
               angle, "the same: a half sine")
    return first, last, shape


PARTS = (1, 4, 10)  # of the speed that the spring holds


def unbroken(case, stiffness, seeds, parts=PARTS):
    """Share of the time without contact at parts of the speed that the spring holds, of each
    run."""
    apart = []
    for part in parts:
        found = runs(case, seeds, speed=unbroken_below(stiffness) / part, stiffness=stiffness,
                     duration=0.1 if case.short else 1.0)
        apart.append([1 - each["share"] for each in found])
    case.check("share of the time without contact, at a tenth of the speed that the spring holds",
               np.mean(apart[-1]),
               2 * stats.norm.sf(10), "slopes are normal: ten standard deviations")
    return apart


def compare(case):
    if case.short:
        runs(case, 2, duration=0.1)
        runs(case, 1, duration=0.05, multipliers=("backward-euler", 1e-6))
        rigid(case, *(runs(case, 2, duration=0.1, stiffness=stiffness)
                      for stiffness in (1e17, 1e19)), 2)
        unbroken(case, 1e15, 1, PARTS[-1:])
        return
    report(case)


WHAT = ("shocks a second", "duration, us: median", "10 to 90 %", "peak / weight: median", "99 %",
        "largest in a run",
        "impulse, uN s: median", "99 %", "time in contact", "level, dB")
TENTHS = (0.1, 0.5, 0.9, 0.99)


def plus_minus(values, digits=2):
    """mean ± half of the interval, with as many digits as the latter has."""
    middle, half = mean(values)
    places = max(0, digits - 1 - int(np.floor(np.log10(half)))) if half > 0 else 2
    return f"{middle:.{places}f} ± {half:.{places}f}"


def share(value):
    return f"{100 * value:.3g} %" if value < 0.9995 or value == 1 else f"{100 * value:.4f} %"


def quantiles(found, name, unit=1.0):
    """TENTHS of all shocks of several runs: each with the ends of its 95 % interval, by a bootstrap
    over the runs."""
    run = np.repeat(np.arange(len(found)), [len(each[name]) for each in found])
    values = over(found, name) / unit
    order = np.argsort(values)
    drawn = np.random.default_rng(0).multinomial(len(found),
                                                 np.full(len(found), 1 / len(found)), 400)
    summed = (np.cumsum(times[run[order]]) for times in (np.ones(len(found)), *drawn))
    each = np.array([values[order[np.searchsorted(upto, np.multiply(TENTHS, upto[-1]))]]
                     for upto in summed])
    return np.column_stack([each[0], *np.quantile(each[1:], (0.025, 0.975), axis=0)])


def within(quantile):
    """A quantile with its interval."""
    return "{} ({} to {})".format(*map(common.shown, quantile))


def row(found):
    """What a table says of some runs."""
    duration, peak, impulse = (quantiles(found, *each)
                               for each in (("duration", 1e-6), ("peak_force", WEIGHT),
                                            ("impulse", 1e-6)))
    return (plus_minus([each["rate"] for each in found]), within(duration[1]),
            f"{common.shown(duration[0, 0])} to {common.shown(duration[2, 0])}", within(peak[1]),
            within(peak[3]),
            plus_minus([each["peak_force"].max() / WEIGHT for each in found], 1),
            within(impulse[1]), within(impulse[3]),
            share(np.mean([each["share"] for each in found])),
            plus_minus([each["level"] for each in found]))


def numbers(found):
    """The same for other programs."""
    return (*mean([each["rate"] for each in found]),
            *(number for name in ("duration", "peak_force", "impulse")
            for quantile in quantiles(found, name, WEIGHT if name == "peak_force" else 1.0)
              for number in quantile),
            max(each["peak_force"].max() for each in found) / WEIGHT,
            np.mean([each["share"] for each in found]),
            *mean([each["level"] for each in found]))


def changes(found, base, name):
    """What a quantity of a run changes by, on the same surfaces."""
    return [each[name] - other[name] for each, other in zip(found, base)]


def report(case):
    base = runs(case)
    sweeps = {
        "speed": ("speed, m/s", {speed: base if speed == 0.1 else runs(case, speed=speed)
                                 for speed in SPEEDS}),
        "load": ("load / weight", {load: base if load == 1 else runs(case, load=load)
                                   for load in LOADS}),
        "roughness": ("Rq, um", {1e6 * rq: base if rq == 8e-6 else runs(case, rq=rq)
                                 for rq in ROUGHNESS}),
        "spacing": ("spacing, um", {1e6 * spacing: runs(case, spacing=spacing, duration=0.5)
                                    for spacing in SPACINGS}),
        "spacing-stiff": ("spacing, um",
                          {1e6 * spacing: runs(case, spacing=spacing, stiffness=STIFF, duration=0.5)
                           for spacing in SPACINGS}),
        "stiffness": ("kappa, Pa/m", {stiffness: runs(case, stiffness=stiffness, duration=0.5)
                                      for stiffness in STIFFNESS}),
    }
    rows = []
    for name, (what, sweep) in sweeps.items():
        case.text(name, common.markdown((what, *WHAT), [(common.shown(value, 1), *row(found))
                                                        for value, found in sweep.items()]))
        rows += [(name, value, *numbers(found)) for value, found in sweep.items()]
    limits = {}
    for scheme, step in MULTIPLIERS:
        seeds, duration = (SEEDS, 0.5) if step > 1e-8 else (FEWER_SEEDS, 0.1)
        limits[scheme, step] = runs(case, seeds, multipliers=(scheme, step), duration=duration)
    case.text("multipliers", common.markdown(("multipliers, step, s", *WHAT), [
        (f"`{scheme}`, {common.shown(step, 1)}", *row(found))
        for (scheme, step), found in limits.items()]))
    rows += [(f"multipliers, {scheme}", step, *numbers(found))
             for (scheme, step), found in limits.items()]
    stiffest = sweeps["stiffness"][1]
    case.text("closed-form", common.markdown(
        ("kappa, Pa/m", "median of duration over half a period, less 1",
         "median of impulse / (peak x duration)"),
        [(common.shown(stiffness, 1), common.shown(longer(found)),
          common.shown(np.median(over(found, "impulse") / over(found,
                                                               "peak_force")
                                 / over(found, "duration")), 4))
         for stiffness, found in stiffest.items()]))
    rigid(case, stiffest[1e18], stiffest[1e19], 1)
    regimes = {1e15: sweeps["speed"][1]}
    for stiffness in OTHER_STIFFNESS:
        regimes[stiffness] = {speed: runs(case, FEWER_SEEDS, speed=speed, stiffness=stiffness,
                                          duration=0.5) for speed in SPEEDS[::2]}
    regimes = {stiffness: {speed: [np.mean([each[name] for each in found])
                                   for name in ("share", "rate")]
                           for speed, found in by_speed.items()}
               for stiffness, by_speed in regimes.items()}
    apart = {stiffness: unbroken(case, stiffness, FEWER_SEEDS) for stiffness in sorted(regimes)}
    case.text("regimes", common.markdown(
        ("kappa, Pa/m", "the spring holds up to, mm/s", "time without contact at that speed",
         *(f"at 1/{part} of it" for part in PARTS[1:]),
         *(f"time in contact at {speed} m/s" for speed in SPEEDS[::2])),
        [(common.shown(stiffness, 1), common.shown(1e3 * unbroken_below(stiffness)),
          *(common.shown(np.mean(each)) for each in apart[stiffness]),
          *(share(by_speed[speed][0]) for speed in SPEEDS[::2]))
         for stiffness, by_speed in sorted(regimes.items())]))
    case.text("level-apart",
              plus_minus(changes(stiffest[1e18], limits["backward-euler", 1e-7], "level")))
    case.text("rate", plus_minus([each["rate"] for each in base]))
    case.text("rigid-rate", plus_minus([each["rate"] for each in stiffest[1e19]]))
    case.text("largest", plus_minus([each["peak_force"].max() / WEIGHT for each in base], 1))
    for name in ("spacing", "spacing-stiff"):
        rates = {value: np.array([each["rate"] for each in found])
                 for value, found in sweeps[name][1].items()}
        for coarse, fine in zip(rates, list(rates)[1:]):
            case.text(f"{name}-{coarse:.0f}-to-{fine:.0f}",
                      plus_minus(100 * (rates[fine] / rates[coarse] - 1)))
    hard = [found for name in ("spacing", "spacing-stiff", "stiffness")
            for value, found in sweeps[name][1].items()
            if name != "stiffness" or value >= 1e15]
    rates = [np.mean([each["rate"] for each in found]) for found in hard]
    case.text("least-rate", min(rates))
    case.text("most-rate", max(rates))
    moves = [mean(changes(found, stiffest[1e15], "level")) for found in hard]
    case.text("level-moves", max(abs(middle) + half for middle, half in moves))
    case.text("level-soft", plus_minus(changes(stiffest[1e13], stiffest[1e15], "level")))
    sticking = np.mean([each["share"] for each in limits["backward-euler", 1e-7]])
    case.text("sticking", 100 * sticking)
    case.text("median", 1e6 * np.median(over(base, "duration")))
    case.text("thesis-stiffness", 1e15 * (np.median(over(base, "duration")) / 1e-4)**2, 1)
    quarter = np.array([apart[stiffness][1] for stiffness in sorted(apart)])
    case.text("lost", f"{(quarter[0] > 0).sum()} of {quarter.shape[1]}")
    case.text("seeds", f"{SEEDS}")
    case.text("stiff", STIFF, 1)
    case.text("weight", WEIGHT)
    case.text("fewer", f"{FEWER_SEEDS}")
    case.text("momentum",
              max(found for what, (found, *_) in case.checks.items() if "impulses" in what))
    case.text("holds", 1e3 * unbroken_below(1e15))
    case.text("longer", longer(stiffest[1e19]))
    names = ("rate, 1/s", "half of its 95 % interval", *(
        f"{what}, {100 * part:.0f} %{end}"
        for what in ("duration, s", "peak over weight", "impulse, N s") for part in TENTHS
        for end in ("", ", from", ", to")), "largest peak over weight", "share of time in contact",
             "level, dB", "half of its 95 % interval")
    case.table(("what is varied", "value", *names), rows)
    draw(case, sweeps, regimes)


def draw(case, sweeps, regimes):
    plt, style = common.pyplot()
    figure, (durations, forces,
             (of_kappa, contact, rates)) = plt.subplots(3, 3, figsize=(11, 10),
                                                        layout="constrained")
    part, larger = np.linspace(0.01, 0.99, 50), np.logspace(-4, 0, 41)
    kinds = (("speed", "m/s", SPEEDS[:2:-1]), ("load", "weights", LOADS),
             ("roughness", "um", [1e6 * rq for rq in ROUGHNESS]))
    kappa = ("stiffness", "Pa/m", STIFFNESS)
    for axes, force, (name, unit, values) in (*zip(durations, [False] * 3, kinds),
                                              *zip(forces, [True] * 3, kinds),
                                              (of_kappa, False, kappa)):
        for value, colour, line in zip(values, style.SERIES, style.LINES):
            found, label = sweeps[name][1][value], f"{common.shown(value, 1)} {unit}"
            if force:
                peak = over(found, "peak_force") / WEIGHT
                axes.loglog(np.quantile(peak, 1 - larger), larger, color=colour, ls=line, lw=1.3,
                            label=label)
            else:
                axes.semilogx(1e6 * np.quantile(over(found, "duration"), part), part, color=colour,
                              ls=line, lw=1.3, label=label)
        if force:
            axes.axvline(100, color=style.GREY, lw=1)
            axes.set(title=f"Peak forces, by {name}",
                     xlabel="peak over weight (line: the authors' largest)",
                     ylabel="share that is larger", ylim=(1e-4, 1.5), xlim=(0.1, 1e3))
        else:
            axes.axvspan(1, 100, color=style.GREY, alpha=0.12, lw=0)
            axes.set(title=f"Durations, by {name}", xlabel="us (grey: the authors, 1 us to 0.1 ms)",
                     ylabel="share that is shorter", xlim=(0.1, 1e4))
        axes.legend(loc="lower left" if force else "lower right", fontsize=7.5)
    for (stiffness, by_speed), colour, mark in zip(sorted(regimes.items()), style.SERIES,
                                                   style.MARKS):
        speeds = sorted(by_speed)
        label = f"{common.shown(stiffness, 1)} Pa/m"
        contact.semilogx(speeds, [100 * by_speed[speed][0] for speed in speeds], color=colour,
                         marker=mark, ms=4, lw=1.2, label=label)
        contact.axvline(unbroken_below(stiffness), color=colour, lw=1, ls=":")
        rates.loglog(speeds, [by_speed[speed][1] for speed in speeds], color=colour, marker=mark,
                     ms=4, lw=1.2, label=label)
    contact.set(title="Time in contact (dotted: what the spring holds)", xlabel="speed [m/s]",
                ylabel="%", ylim=(-3, 103))
    contact.legend(loc="lower left", fontsize=7.5)
    rates.axhline(THESIS_RATE, color=style.GREY, lw=1)
    rates.set(title="Shocks a second (line: the authors')", xlabel="speed [m/s]")
    rates.legend(loc="lower right", fontsize=7.5)
    case.figure(figure)


if __name__ == "__main__":
    common.main("shocks", compare)
