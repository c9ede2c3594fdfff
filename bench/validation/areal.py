#!/usr/bin/env python3
# SPDX-License-Identifier: BSD-3-Clause
"""The paper's bodies as a plate and a block with height maps, and as beams with profiles: level,
shocks, the exponents of roughness and speed, vibration over the contact's area, and how far a slow
block stands off the plate.

Both models have the same Rq, RSm, load, speed and contact stiffness, and smooth faces. A slow block
rests on straight ones, which have the same summits.

Two things must hold. Momentum: shocks alone carry the block, so their impulses add up to load times
time, less what it gains. Extreme values: a slow block rests on the highest of many independent
summits, whose height varies far less than Rq, and the less the more of them there are (Ponthus et
al. 2019). The law of Le Bot, Bou-Chakra and Michon (2011) says how the energy goes with the area:
contact_size.py. """
import copy
import json
import tomllib

import h5py
import numpy as np

import common
from contact_size import NOISE, decibels, exponents, mean, plus_minus

SEEDS, SOME, FEW = 8, 6, 4
RQ, SPEEDS = (4e-6, 8e-6, 16e-6), (0.05, 0.1, 0.2)  # m, m/s
SIDES = (10e-3, 20e-3, 40e-3)  # m, of square blocks
MUCH, USUAL, LITTLE = 0.1, 0.02, 0.002  # damping ratio of the plate
SLOW_SIDES, SLOW_SEEDS, STARTS = (5e-3, 10e-3, 20e-3, 40e-3), 12, 20
TOLERANCE = 1e-6
# m; rates are within some per cent of those of finer meshes (docs/accuracy.md)
MESHES = {"plane": {"spacing": 32e-6}, "areal": {"spacing": 62.5e-6, "spacing_y": 16e-6}}
PLANE, AREAL = (
    tomllib.loads((common.ROOT / "scenes" / name).read_text())
    for name in ("dang2012.toml", "areal.toml")
)
STIFFNESS = AREAL["contact"]["stiffness"]
AUTHORS_RATE = 1e4  # 1/s on 4 cm^2: Dang's thesis (2013)


def scene_of(kind, seed, duration, rq=8e-6, speed=0.1, side=20e-3, damping=USUAL):
    """A second of the paper's case, or less, by one of the two models; `side` of a square block
    [m]."""
    scene = copy.deepcopy(AREAL if kind == "areal" else PLANE)
    scene["scene"].update(duration=duration, speed=speed)
    scene["scene"].update(faces="smooth", **MESHES[kind])
    for body in ("resonator", "slider"):
        scene[body]["surface"]["seed"] += 1000 * seed  # as a study does
        scene[body]["surface"]["rq"] = rq
    scene["resonator"]["damping"] = damping
    scene["slider"].update(length=side, width=side, load="weight")
    scene["contact"] = {"stiffness": STIFFNESS}
    scene["time"] = {"scheme": "adaptive", "tolerance": TOLERANCE}
    scene["output"] = {"rate": 50e3, "from": duration / 5}
    return scene


def marched(case, scene):
    """Figures of a run from output.from on: level, shocks, mean square velocity above NOISE."""
    names = (
        "time",
        "resonator/frequency",
        "resonator/velocity",
        "resonator/mean_square",
        "slider/velocity",
        "shocks/impulse",
    )
    time, frequency, plate, mean_square, slider, impulse = case.run(scene, *names)
    with h5py.File(case.scratch / "result.h5") as file:
        steps = int(file.attrs["steps"])
    keys = scene["slider"]
    area = keys["length"] * keys["width"]
    weight = keys["density"] * keys["thickness"] * area * 9.80665
    # the first mode is 1/sqrt(area), of a beam 1/sqrt(length)
    velocity = slider[:, 0] / np.sqrt(
        area if scene["scene"].get("kind") == "areal" else keys["length"]
    )
    carried = weight * time[-1] - weight / 9.80665 * (velocity[-1] - velocity[0])
    case.check(
        "sum of impulses, against load times time, off by",
        abs(impulse.sum() / carried - 1),
        steps * TOLERANCE * weight / 9.80665 * np.abs(velocity).max() / carried,
        "the tolerance, at every step",
    )
    found = json.loads(case.call(case.program, "analyze", case.scratch / "result.h5", "--json"))
    counted = time >= scene["output"]["from"]
    square = (plate[counted] ** 2).mean(0) * mean_square
    shocks = found["shocks"]
    return {
        "level": found["lv"],
        "all": square.sum(),
        "noise": square[frequency > NOISE].sum(),
        "rate": shocks["rate"],
        "duration": 1e6 * shocks["duration"]["median"],
        "force": shocks["peak_force"]["median"],
        "largest": shocks["peak_force"]["p90"],
        "at once": shocks["simultaneous"]["mean"],
        "share": found["contact_share"],
    }


def separation(case, side, seed, starts):
    """Distance of the two mean planes, in m, as a block on a rigid face rests at `starts` places:
    sliding with V = 0."""
    scene = scene_of("areal", seed, 1e-6, side=side)
    gap = 12 * AREAL["slider"]["surface"]["rq"]
    scene["scene"].update(
        gap=gap, faces="linear", spacing=64e-6, spacing_y=64e-6, initial="static"
    )
    scene["resonator"] = {
        "support": "rigid",
        "length": 0.3,
        "width": 0.2,
        "surface": scene["resonator"]["surface"],
    }
    scene["output"] = {"rate": 1e6}
    found = []
    for start in np.linspace(0.0, 0.3 - 1.01 * side, starts):
        scene["scene"]["start"] = round(start / 64e-6) * 64e-6
        (displacement,) = case.run(scene, "slider/displacement")
        found.append(gap - displacement[0, 0] / side)
    return np.array(found)


def slow(case, seeds, starts, sides):
    """{side: for each seed (mean, rms variation) of the separation over Rq of both faces}."""
    rq = np.sqrt(2) * AREAL["slider"]["surface"]["rq"]
    return {
        side: [
            (d.mean() / rq, d.std(ddof=1) / rq)
            for seed in range(seeds)
            for d in [separation(case, side, seed, starts)]
        ]
        for side in sides
    }


def check_slow(case, found):
    """The separation varies less than the heights, and less under a larger block."""
    for side, seeds in found.items():
        case.check(
            f"rms variation of the separation over Rq, block of {1e3 * side:g} mm",
            np.mean([rms for _, rms in seeds]),
            1,
            "a summit that is the highest of many varies less than a height",
        )
    small, large = (np.array([rms for _, rms in found[side]]) for side in (min(found), max(found)))
    if case.short:  # too few to tell them apart
        return
    change, half = mean(large - small)
    case.check(
        "the same, of the largest block less of the smallest, upper end of the interval",
        change + half,
        0,
        "extreme values: the more summits, the less the highest varies. The seeds: Student's t, 95 "
        "%",
    )


def compare(case):
    if case.short:
        for kind in ("plane", "areal"):
            marched(case, scene_of(kind, 0, 0.02, side=10e-3))
        check_slow(case, slow(case, 1, 8, (5e-3, 10e-3)))
        return
    sides = {
        kind: [marched(case, scene_of(kind, seed, 1.0)) for seed in range(SEEDS)]
        for kind in ("plane", "areal")
    }
    law = {
        kind: {
            (rq, speed): [
                marched(case, scene_of(kind, seed, 0.5, rq, speed)) for seed in range(FEW)
            ]
            for rq in RQ
            for speed in SPEEDS
        }
        for kind in ("plane", "areal")
    }
    area = {
        damping: {
            side: [
                marched(case, scene_of("areal", seed, 0.6, side=side, damping=damping))
                for seed in range(SOME)
            ]
            for side in SIDES
        }
        for damping in (MUCH, USUAL, LITTLE)
    }
    still = slow(case, SLOW_SEEDS, STARTS, SLOW_SIDES)
    check_slow(case, still)
    report(case, sides, law, area, still)


def of_law(points):
    """n and m of each seed: slopes of log10 v_rms over those of Rq and V."""
    x = np.array([(1, np.log10(rq), np.log10(speed)) for rq, speed in points])
    levels = np.array([[run["level"] for run in runs] for runs in points.values()]) / 20
    return np.linalg.lstsq(x, levels, rcond=None)[0][1:]


FIGURES = (
    ("level", "level, dB re 1 nm/s", 1),
    ("rate", "shocks a second", 0),
    ("duration", "median duration, us", 1),
    ("force", "median peak force, N", 2),
    ("largest", "90 % of peak forces below, N", 2),
    ("at once", "contacts at once, mean", 2),
    ("share", "share of the time in contact", 2),
)


def report(case, sides, law, area, still):
    rows = []
    for name, words, digits in FIGURES:
        plane, areal = ([run[name] for run in sides[kind]] for kind in ("plane", "areal"))
        case.text(f"plane-{name.replace(' ', '-')}", plus_minus(plane, digits))
        case.text(f"areal-{name.replace(' ', '-')}", plus_minus(areal, digits))
        rows.append((words, plus_minus(plane, digits), plus_minus(areal, digits)))
    case.text(
        "higher",
        plus_minus(
            np.subtract(*([run["level"] for run in sides[kind]] for kind in ("areal", "plane")))
        ),
    )
    ratio, half = mean(
        np.log(np.divide(*([run["rate"] for run in sides[kind]] for kind in ("areal", "plane"))))
    )
    case.text(
        "rate-ratio",
        f"{np.exp(ratio):.2f} ({np.exp(ratio - half):.2f} to {np.exp(ratio + half):.2f})",
    )
    slopes = {kind: of_law(points) for kind, points in law.items()}
    for kind, (n, m) in slopes.items():
        case.text(f"{kind}-n", plus_minus(n, 2))
        case.text(f"{kind}-m", plus_minus(m, 2))
    rows += [
        (
            f"{key}: exponent of {word}",
            *(plus_minus(slopes[kind][i], 2) for kind in ("plane", "areal")),
        )
        for i, (key, word) in enumerate((("n", "Rq"), ("m", "V")))
    ]
    case.text("beside", common.markdown(("", "beams, profiles", "plate, block, maps"), rows))
    of_area = {
        damping: exponents({side**2: runs for side, runs in by_side.items()})
        for damping, by_side in area.items()
    }
    for damping, word in ((MUCH, "much"), (USUAL, "usual"), (LITTLE, "little")):
        case.text(f"area-{word}", plus_minus(of_area[damping], 2))
    case.text(
        "area",
        common.markdown(
            (
                "plate's damping",
                *(f"{1e3 * side:.0f} mm: level above 1 kHz, dB" for side in SIDES),
                "exponent over the area",
            ),
            [
                (
                    damping,
                    *(plus_minus(decibels(runs)) for runs in by_side.values()),
                    plus_minus(of_area[damping], 2),
                )
                for damping, by_side in area.items()
            ],
        ),
    )
    rsm = AREAL["slider"]["surface"]["rsm"]
    slow_rows = [
        (
            f"{1e3 * side:g}",
            f"{side / rsm:.1f}",
            plus_minus([middle for middle, _ in seeds], 2),
            plus_minus([rms for _, rms in seeds], 3),
        )
        for side, seeds in still.items()
    ]
    case.text(
        "slow",
        common.markdown(
            (
                "side of the block, mm",
                "wavelengths (RSm)",
                "mean separation over Rq",
                "its rms variation over Rq",
            ),
            slow_rows,
        ),
    )
    case.text("slow-small", slow_rows[0][3])
    case.text("slow-large", slow_rows[-1][3])
    case.text("seeds", f"{SEEDS}")
    case.text("some", f"{SOME}")
    case.text("few", f"{FEW}")
    case.text("slow-seeds", f"{SLOW_SEEDS}")
    case.text("starts", f"{STARTS}")
    case.table(
        (
            "model",
            "Rq, m",
            "V, m/s",
            "side, m",
            "damping of the plate",
            *(words for _, words, _ in FIGURES),
        ),
        [
            (
                kind,
                rq,
                speed,
                20e-3,
                USUAL,
                *(np.mean([run[name] for run in runs]) for name, _, _ in FIGURES),
            )
            for kind, points in law.items()
            for (rq, speed), runs in points.items()
        ]
        + [
            (
                "areal",
                8e-6,
                0.1,
                side,
                damping,
                *(np.mean([run[name] for run in runs]) for name, _, _ in FIGURES),
            )
            for damping, by_side in area.items()
            for side, runs in by_side.items()
        ],
    )
    draw(case, law, area, still)


def draw(case, law, area, still):
    plt, style = common.pyplot()
    figure, (left, middle, right) = plt.subplots(1, 3, figsize=(10.5, 3.8), layout="constrained")
    for (kind, points), line in zip(law.items(), ("--", "-")):
        for rq, colour, mark in zip(RQ, style.SERIES, style.MARKS):
            value, half = np.array(
                [mean([run["level"] for run in points[rq, speed]]) for speed in SPEEDS]
            ).T
            left.errorbar(
                SPEEDS,
                value,
                half,
                color=colour,
                marker=mark,
                ls=line,
                ms=4,
                lw=1.1,
                capsize=2,
                label=f"{1e6 * rq:.0f} \u00b5m" if kind == "areal" else None,
            )
    left.set(
        xscale="log",
        title="Level (dashed: plane)",
        xlabel="speed [m/s]",
        ylabel="Lv [dB re 1 nm/s]",
    )
    left.set_xticks(SPEEDS, [f"{speed:g}" for speed in SPEEDS])
    left.minorticks_off()
    left.legend(title="Rq", frameon=False)
    for (damping, by_side), colour, mark in zip(area.items(), style.SERIES, style.MARKS):
        value, half = np.array([mean(decibels(runs)) for runs in by_side.values()]).T
        middle.errorbar(
            [1e4 * side**2 for side in SIDES],
            value,
            half,
            color=colour,
            marker=mark,
            ms=4,
            lw=1.1,
            capsize=2,
            label=f"damping {damping:g}",
        )
        middle.plot(
            [1e4 * SIDES[0] ** 2, 1e4 * SIDES[-1] ** 2],
            value[0] + np.array([0, 20 * np.log10(SIDES[-1] / SIDES[0])]),
            color=style.GREY,
            lw=0.8,
        )
    middle.set(
        xscale="log",
        title="Level above 1 kHz (line: proportional)",
        xlabel="area of the block [cm\u00b2]",
        ylabel="dB re 1 nm/s",
    )
    middle.set_xticks([1e4 * side**2 for side in SIDES], [f"{1e4 * side**2:g}" for side in SIDES])
    middle.minorticks_off()
    middle.legend(frameon=False)
    rsm = AREAL["slider"]["surface"]["rsm"]
    value, half = np.array([mean([rms for _, rms in seeds]) for seeds in still.values()]).T
    right.errorbar(
        [side / rsm for side in still],
        value,
        half,
        color=style.BLUE,
        marker="o",
        ms=4,
        lw=1.1,
        capsize=2,
    )
    right.set(
        xscale="log",
        ylim=(0, None),
        title="A slow block rises and falls by",
        xlabel="side of the block [RSm]",
        ylabel="rms of the separation [Rq of both faces]",
    )
    right.set_xticks([side / rsm for side in still], [f"{side / rsm:.0f}" for side in still])
    right.minorticks_off()
    case.figure(figure)


if __name__ == "__main__":
    common.main("areal", compare)
