#!/usr/bin/env python3
# SPDX-License-Identifier: BSD-3-Clause
"""How often the 95 % intervals of level and rate of shocks hold the truth, on real runs of short
scenes.

usage: coverage.py [--folder FOLDER] [--threads N] [--short] PROGRAM

Of several runs: a study of 1000 seeds of each scene, whose mean is taken for the truth, and 20 000
draws of 3, 5, 10 and 20 runs from them. The intervals are computed here by their formula
(docs/analysis.md), which is compared with the program's for all runs.

Of one run: the intervals that `ra2d analyze` prints for runs of a second, 24 sliders on 10 plates
each. They are to hold the mean over the plates with the slider that the run has; how often they
hold the mean over all is the other column, to show what they do not promise.

Prints how often the intervals of docs/analysis.md hold the truth. FOLDER keeps the studies (a
temporary one without it). Half an hour of one core. Needs numpy, scipy and h5py.

    bench/coverage.py build/release/ra2d
"""
import argparse
import json
import math
import pathlib
import subprocess
import tempfile

import h5py
import numpy as np
import scipy.stats

SCENES = pathlib.Path(__file__).resolve().parent.parent / "scenes"
RUNS = {  # name: (words, base, speed, duration)
    "s1": ("free slider, 0.1 m/s", "dang2012.toml", 0.1, 0.1),
    "s2": ("pinned slider, 0.1 m/s", "dang2012-pinned.toml", 0.1, 0.1),
    "s3": ("free slider, 0.02 m/s", "dang2012.toml", 0.02, 0.1),
    "s4": ("free slider, 0.5 m/s", "dang2012.toml", 0.5, 0.05)}
ONE = {
    "q1": ("free slider, 0.1 m/s", "dang2012.toml", 0.1, 1.0),
    "q2": ("pinned slider, 0.1 m/s", "dang2012-pinned.toml", 0.1, 1.0),
    "q4": ("free slider, 0.02 m/s", "dang2012.toml", 0.02, 1.0)}


def study(options, name, scene, seeds, vary, files):
    """Runs a study and gives its folder."""
    _, base, speed, duration = scene
    keep = '["level", "shocks", "files"]' if files else '["level", "shocks"]'
    text = (f'base = "{SCENES / base}"\nseeds = {seeds}\nkeep = {keep}\n'
            f'[set]\n"scene.duration" = {duration}\n"time.scheme" = "adaptive"\n"time.tolerance" = '
            '1e-6\n'
            f'"output.rate" = 1e4\n' + (f'"scene.speed" = {speed}\n' if files else "")
            + f"[vary]\n{vary}\n")
    file = options.folder / f"{name}.toml"
    file.write_text(text)
    subprocess.run([options.program, "study", file, "-o", options.folder / name, "--threads",
                    str(options.threads), "--quiet"],
                   check=True)
    return options.folder / name


def interval(values, positive):
    """Low and high of the mean of each row: Student's t, of positive values of the mean's
    logarithm."""
    n = values.shape[1]
    mean = values.mean(1)
    half = scipy.stats.t.ppf(0.975, n - 1) * values.std(1, ddof=1) / math.sqrt(n)
    return (mean * np.exp(-half / mean),
            mean * np.exp(half / mean)) if positive else (mean - half, mean + half)


def held(low, high, truth):
    return 100 * np.mean((low <= truth) & (truth <= high))


def same_as_the_program(options, folder, name, values, positive):
    said = json.loads(subprocess.run([options.program, "analyze", folder, "--json"], check=True,
                                     capture_output=True,
                                     text=True).stdout)["points"][0][name]
    low, high = interval(values[None, :], positive)
    if not np.allclose([said["low"], said["high"]], [low[0], high[0]], rtol=1e-9):
        raise SystemExit(f"coverage: {name}: the program says {said}, the formula {low[0]} to "
                         f"{high[0]}")


def of_runs(options, seeds, draws):
    dice = np.random.default_rng(1)
    counts = (3, 5, 10, 20)
    print(f"| mean of so many runs, of {seeds} | " + " | ".join(f"level, {n}"
                                                                for n in counts) + " | " +
          " | ".join(f"rate, {n}" for n in counts) + " |\n|---|" + 8 * "--:|")
    least = 100
    for name, scene in RUNS.items():
        folder = study(options, name, scene, seeds,
                       f'speed = {{ key = "scene.speed", values = [{scene[2]}] }}', False)
        with h5py.File(folder / "results.h5") as table:
            level, rate = table["level"][...].ravel(), table["shock_rate"][...].ravel()
        same_as_the_program(options, folder, "lv", level, False)
        same_as_the_program(options, folder, "shock_rate", rate, True)
        cells = []
        for values, positive in ((level, False), (rate, True)):
            for n in counts:
                drawn = np.array([dice.choice(len(values), n, replace=False) for _ in range(draws)])
                cells.append(held(*interval(values[drawn], positive), values.mean()))
        least = min(least, *cells)
        print(f"| {scene[0]} | " + " | ".join(f"{cell:.1f} %" for cell in cells) + " |")
    return least


def of_one(options, scenes, sliders, plates):
    print(f"\n| one run, of {sliders} sliders on {plates} plates | level, the slider's truth | "
          "level, of all "
          "| rate, the slider's truth | rate, of all |\n|---|" + 4 * "--:|")
    for name, scene in scenes.items():
        values = ", ".join(str(101 + i) for i in range(plates))
        folder = study(options, name, scene, sliders,
                       f'plate = {{ key = "resonator.surface.seed", values = [{values}] }}', True)
        with h5py.File(folder / "results.h5") as table:
            files = [folder / file.decode() for file in table["file"][...].ravel()]
            shape = table["v_rms"].shape  # plates, sliders
        said = json.loads(subprocess.run([options.program, "analyze", *files, "--json"], check=True,
                                         capture_output=True,
                                         text=True).stdout)["files"]
        cells = []
        for value, low_high in ((lambda f: f["lv"], lambda f: f["lv_interval"]),
                                (lambda f: f["shocks"]["rate"],
                                 lambda f: f["shocks"]["rate_interval"])):
            found = np.array([value(f) for f in said]).reshape(shape)
            low, high = (np.array([low_high(f)[side] for f in said], float).reshape(shape)
                         for side in ("low", "high"))
            # of the plates that the run has not seen
            others = (found.sum(0) - found) / (shape[0] - 1)
            cells += [held(low, high, others), held(low, high, found.mean())]
        print(f"| {scene[0]} | " + " | ".join(f"{cell:.0f} %" for cell in cells) + " |")


def main():
    parser = argparse.ArgumentParser(usage=__doc__.split("\n\n")[1].removeprefix("usage: "))
    parser.add_argument("program")
    parser.add_argument("--folder", type=pathlib.Path)
    parser.add_argument("--threads", type=int, default=1)
    parser.add_argument("--short", action="store_true")
    options = parser.parse_args()
    with tempfile.TemporaryDirectory() as temporary:
        options.folder = options.folder or pathlib.Path(temporary)
        if options.short:
            for name, scene in RUNS.items():
                RUNS[name] = (*scene[:3], 0.01)
            least = of_runs(options, 24, 400)
            of_one(options, {"q1": (*ONE["q1"][:3], 0.8)}, 2, 2)
            if not least > 70:  # of 24 runs drawn again and again the truth is not known better
                raise SystemExit(f"coverage: an interval holds the truth in {least} %")
        else:
            of_runs(options, 1000, 20_000)
            of_one(options, ONE, 24, 10)


if __name__ == "__main__":
    main()
