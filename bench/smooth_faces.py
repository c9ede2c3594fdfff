#!/usr/bin/env python3
# SPDX-License-Identifier: BSD-3-Clause
"""What answers owe to the mesh, between linear and between smooth faces (scene.faces).

    bench/smooth_faces.py convergence PROGRAM [OUT.csv] [--seeds 10] [--duration 1]
                                      [--stiffness 1e15 1e16 1e17]
    bench/smooth_faces.py tone        PROGRAM [OUT.csv] [--seeds 10] [--duration 1]
    bench/smooth_faces.py parts       PROGRAM [OUT.csv] [--seeds 10] [--duration 1]
    bench/smooth_faces.py maps        PROGRAM [OUT.csv] [--seeds 10] [--duration 1]

PROGRAM is ra2d. Each case runs scenes/dang2012.toml (maps: scenes/areal.toml) over several seeds
of both surfaces and appends its numbers to OUT.csv (smooth_faces_CASE.csv beside this script); runs
whose row is there already are not run again, so it can be interrupted. `--summary` runs nothing and
prints the means, with 95 % intervals over the seeds. With --jobs N, N runs at a time. convergence
takes some 20 minutes on one core; --seeds 3 --duration 0.2 one. --chart FILE also draws
convergence's error of the rate over the time of a run.

convergence: level, rate of shocks, durations and peak forces over the spacing, and the processor
  time.
tone: how far the line at speed/spacing stands above the spectrum around it. Each spectrum is
  averaged over the resonator; the line is the mean of the five lines at the tone, its surroundings
  the 20 lines on either side beyond five. The rise is the ratio of the means over the seeds, in dB;
  its interval comes from leaving out one seed at a time. The control is the rise at the same
  frequency between smooth faces of the other spacings, whose mesh has no tone there: what the modes
  and the slope of the spectrum make.
parts: which part of the tone at 8 um is which face's. Both faces are files with a height every 1
  um. The resonator's is the straight lines between its heights every 8 um ("chords", as a linear
  face there), or the spline through them. The slider's is the spline, sampled at every 1 um, or
  only every eighth of its nodes can touch ("nodes": the others are lowered by 0.4 um, and the
  stiffness is eight times as large). So "chords" under "nodes" is the linear scene at 8 um, and
  "spline" under "spline", the control, has no mesh of 8 um.
maps: of an areal scene, both: convergence over the spacings along x and across, and the tone; the
  limit is that of the finest rows. Some three minutes a seed on one core.
"""
import argparse
import concurrent.futures
import csv
import math
import os
import pathlib
import statistics
import subprocess
import sys
import tempfile

import h5py
import numpy
import scipy.interpolate
import scipy.signal
import scipy.stats

from pictures import pyplot

ROOT = pathlib.Path(__file__).resolve().parents[1]
SCENE = ROOT / "scenes" / "dang2012.toml"
MAPS = ROOT / "scenes" / "areal.toml"
SPEED = 0.1  # m/s, of both scenes
TOLERANCE = 1e-6

COLUMNS = {
    "convergence": ["stiffness", "faces", "spacing", "seed", "duration", "level", "rate",
                    "median_duration",
                    "mean_duration", "median_peak", "contact_share", "seconds"],
    "tone": ["faces", "spacing", "seed", "duration", "frequency", "line", "around"],
    "maps": ["faces", "spacing", "spacing_y", "seed", "duration", "level", "rate",
             "median_duration", "mean_duration", "median_peak", "contact_share", "seconds",
             "frequency", "line", "around"],
    "parts": ["resonator", "slider", "seed", "duration", "frequency", "line", "around"],
}


class Run:
    """A run of a scene with other keys; its numbers."""

    def __init__(self, options, folder, seed, scheme, scene=SCENE, **keys):
        self.file = pathlib.Path(folder) / "run.h5"
        settings = {"scene.duration": options.duration, **scheme, **keys}
        if "slider.surface" not in keys:
            settings |= {"resonator.surface.seed": 2 * seed, "slider.surface.seed": 2 * seed - 1}
        words = [options.program, "run", scene, "--quiet", "--force", "-o", self.file]
        for key, value in settings.items():
            words += ["--set", f"{key}={value}"]
        with tempfile.TemporaryFile() as said:
            child = subprocess.Popen(list(map(str, words)), stdout=subprocess.DEVNULL, stderr=said)
            _, status, used = os.wait4(child.pid, 0)
            child.returncode = os.waitstatus_to_exitcode(status)
            if child.returncode:
                said.seek(0)
                raise RuntimeError(
                    f"{' '.join(map(str, words))} ended with "
                    f"{child.returncode}:\n{said.read().decode()}")
        self.seconds = used.ru_utime

    def numbers(self):
        with h5py.File(self.file) as file:
            summary = {name: float(value[()]) for name, value in file["summary"].items()}
            mean = float(file["shocks/duration"][:].mean())
        return {"level": summary["lv"], "rate": summary["shock_rate"],
                "median_duration": summary["shock_duration_median"],
                "mean_duration": mean, "median_peak": summary["peak_force_median"],
                "contact_share": summary["contact_share"], "seconds": self.seconds}

    def tone(self, frequency):
        """The power around a frequency: of its line, and beside it."""
        with h5py.File(self.file) as file:
            time, velocity = file["contact/time"][:], file["resonator/velocity"][:]
        rate = (len(time) - 1) / (time[-1] - time[0])
        segment = 2 ** max(8, round(math.log2(len(time) / 8)))
        f, power = scipy.signal.welch(velocity, rate, nperseg=segment, axis=0)
        power = power.sum(axis=1)
        at = round(frequency / f[1])
        line = power[at - 2:at + 3].mean()
        around = numpy.concatenate([power[at - 25:at - 5], power[at + 6:at + 26]]).mean()
        return float(line), float(around)


def scheme_of(options, faces):
    """Of smooth faces the fixed scheme with --fixed; else adaptive."""
    if faces == "smooth" and options.fixed:
        return {"time.scheme": "exact", "time.step": options.fixed}
    return {"time.scheme": "adaptive", "time.tolerance": TOLERANCE}


def spacings_of(options, faces):
    return [s * 1e-6
            for s in (options.spacings
                      or ([64, 32, 16, 8, 4] if faces == "smooth" else [32, 16, 8, 4, 2, 1]))]


def convergence(options):
    for seed in range(1, options.seeds + 1):
        for stiffness in options.stiffness:
            for faces in ("smooth", "linear"):
                for spacing in spacings_of(options, faces):
                    key = {"stiffness": stiffness, "faces": faces, "spacing": spacing, "seed": seed}

                    def run(folder, seed=seed, stiffness=stiffness, faces=faces, spacing=spacing):
                        return [Run(options, folder, seed, scheme_of(options, faces), **{
                            "contact.stiffness": stiffness, "scene.faces": faces,
                            "scene.spacing": spacing}).numbers()]
                    yield key, run


def tone(options):
    spacings = [s * 1e-6 for s in (options.spacings or [8, 16, 32])]
    for seed in range(1, options.seeds + 1):
        for faces in ("smooth", "linear"):
            for spacing in spacings:
                key = {"faces": faces, "spacing": spacing, "seed": seed}

                def run(folder, seed=seed, faces=faces, spacing=spacing):
                    made = Run(options, folder, seed, scheme_of(options, faces), **{
                        "scene.faces": faces, "scene.spacing": spacing})
                    rows = []
                    for other in spacings:
                        line, around = made.tone(SPEED / other)
                        rows.append({"frequency": SPEED / other, "line": line, "around": around})
                    return rows
                yield key, run


def parts(options):
    for seed in range(1, options.seeds + 1):
        for resonator in ("chords", "spline"):
            for slider in ("nodes", "spline"):
                key = {"resonator": resonator, "slider": slider, "seed": seed}

                def run(folder, seed=seed, resonator=resonator, slider=slider):
                    keys = {"scene.spacing": 1e-6, "contact.stiffness": 8e15
                            if slider == "nodes" else 1e15}
                    for body, face in (("resonator", resonator), ("slider", slider)):
                        path = write_face(options, folder, body, face, seed)
                        keys[f"{body}.surface"] = (
                            f'{{ kind = "file", path = "{path}", x_unit = "m", z_unit = "m" }}')
                    made = Run(options, folder, seed, scheme_of(options, "linear"), **keys)
                    line, around = made.tone(12.5e3)
                    return [{"frequency": 12.5e3, "line": line, "around": around}]
                yield key, run


# um: faces, spacing, spacing_y
MAP_SPACINGS = [("linear", 32, 32), ("linear", 16, 16), ("linear", 8, 8), ("smooth", 62.5, 32),
                ("smooth", 62.5, 16), ("smooth", 32, 16), ("smooth", 62.5, 8)]


def maps(options):
    frequencies = sorted({SPEED / (1e-6 * spacing) for _, spacing, _ in MAP_SPACINGS})
    for seed in range(1, options.seeds + 1):
        for faces, along, across in MAP_SPACINGS:
            key = {"faces": faces, "spacing": along, "spacing_y": across, "seed": seed}

            def run(folder, seed=seed, faces=faces, along=along, across=across):
                made = Run(options, folder, seed, scheme_of(options, faces), MAPS, **{
                    "scene.faces": faces, "scene.spacing": 1e-6 * along,
                    "scene.spacing_y": 1e-6 * across})
                rows = []
                for frequency in frequencies:
                    line, around = made.tone(frequency)
                    rows.append(made.numbers()
                                | {"frequency": frequency, "line": line, "around": around})
                return rows
            yield key, run


def write_face(options, folder, body, face, seed):
    """The heights of a body at every 1 um, from those every 8 um."""
    coarse, fine = pathlib.Path(folder) / f"{body}-coarse.csv", pathlib.Path(folder) / f"{body}.txt"
    number = 2 * seed if body == "resonator" else 2 * seed - 1
    words = [options.program, "surface", "generate", "--length", "0.3" if body == "resonator"
             else "0.02", "--spacing", "8e-6",
             "--rq", "8e-6", "--rsm", "1.55e-3", "--seed", str(number), "-o", str(coarse)]
    subprocess.run(words, check=True, capture_output=True)
    x, z = numpy.loadtxt((line for line in open(coarse) if line[0] in "-.0123456789"),
                         delimiter=",", unpack=True)
    between = numpy.linspace(x[0], x[-1], 8 * (len(x) - 1) + 1)
    if face == "chords":
        heights = numpy.interp(between, x, z)
    else:
        heights = scipy.interpolate.CubicSpline(x, z, bc_type="not-a-knot")(between)
    if face == "nodes":
        heights[numpy.arange(len(heights)) % 8 != 0] -= 4e-7  # contacts are some nm deep
    numpy.savetxt(fine, numpy.column_stack([between, heights]), fmt="%.17g")
    return fine


def same(row, key):
    return all(row[name] == str(value) for name, value in key.items())


def run_all(options, rows):
    """The runs whose rows are missing; a row is written as its run ends."""
    columns = COLUMNS[options.case]
    todo = [(key, run) for key, run in CASES[options.case](options)
            if not any(same(row, key | {"duration": options.duration}) for row in rows)]
    with open(options.out, "a",
              newline="") as file, concurrent.futures.ThreadPoolExecutor(options.jobs) as pool:
        table = csv.DictWriter(file, columns)
        if file.tell() == 0:
            table.writeheader()

        def one(task):
            key, run = task
            with tempfile.TemporaryDirectory() as folder:
                return key, run(folder)
        for key, found in pool.map(one, todo):
            for row in found:
                table.writerow(key | {"duration": options.duration} | row)
            file.flush()
            print(", ".join(f"{name} {value:g}" if isinstance(value, float) else f"{name} {value}"
                            for name, value in (key | found[0]).items()), flush=True)


def half_width(values):
    """Of a mean's 95 % interval."""
    if len(values) < 2:
        return math.nan
    return scipy.stats.t.ppf(0.975,
                             len(values) - 1) * statistics.stdev(values) / math.sqrt(len(values))


def summarize_convergence(rows):
    """Differences to the finest smooth faces, over pairs of the same seed."""
    groups = {}
    for row in rows:
        groups.setdefault((float(row["stiffness"]), row["faces"], float(row["spacing"])),
                          {})[row["seed"]] = row
    print("| kappa (Pa/m) | faces | spacing (um) | seeds | level (dB) | rate (1/s) | to the limit "
          "(%) | median duration (us) | to the limit (%) | median peak (N) | to the limit (%) | s "
          "of processor |")
    print("|" + "---|" * 12)
    for (stiffness, faces, spacing), found in sorted(groups.items(),
                                                     key=lambda g: (g[0][0], g[0][1], -g[0][2])):
        limits = [s for (k, f, s) in groups if k == stiffness and f == "smooth"]
        limit = groups[stiffness, "smooth", min(limits)] if limits else {}

        def mean(name, scale=1.0, digits=4, found=found):
            values = [scale * float(row[name]) for row in found.values()]
            return f"{statistics.mean(values):.{digits}g} ± {half_width(values):.2g}"

        def off(name, found=found, limit=limit):
            shared = [seed for seed in found if seed in limit and found is not limit]
            logs = [math.log(float(found[s][name]) / float(limit[s][name])) for s in shared]
            if not logs:
                return ""
            mean, half = statistics.mean(logs), half_width(logs)
            return f"{100 * math.expm1(mean):+.1f} ± {100 * math.exp(mean) * half:.1f}"
        print(f"| {stiffness:.0e} | {faces} | {1e6 * spacing:g} | {len(found)} | "
              f"{mean('level', digits=5)} | {mean('rate')} | {off('rate')} | "
              f"{mean('median_duration', 1e6, 3)} | {off('median_duration')} | "
              f"{mean('median_peak', 1, 3)} | {off('median_peak')} | {mean('seconds', 1, 3)} |")


def summarize_maps(rows):
    """Differences to the finest rows, and the rise at speed/spacing above that of faces of other
    spacings, over pairs of the same seed."""
    groups = {}
    for row in rows:
        group = row["faces"], float(row["spacing"]), float(row["spacing_y"])
        groups.setdefault(group, {}).setdefault(row["seed"], {})[float(row["frequency"])] = row
    limit = groups[min(groups, key=lambda g: (g[0] != "smooth", g[2]))]

    def one(found, seed):
        return next(iter(found[seed].values()))

    def lines(found, seeds, frequency):
        return [(float(found[s][frequency]["line"]), float(found[s][frequency]["around"]))
                for s in seeds]
    print("| faces | spacing (um) | across (um) | seeds | level (dB) | rate (1/s) | to the limit "
          "(%) | median duration (us) | to the limit (%) | tone (dB) | s of processor |")
    print("|" + "---|" * 11)
    for (faces, along, across), found in sorted(groups.items(), key=lambda g: (g[0][0], -g[0][2],
                                                                               -g[0][1])):
        seeds = sorted(set(found) & set(limit))

        def mean(name, scale=1.0, digits=4, found=found):
            values = [scale * float(one(found, s)[name]) for s in found]
            return f"{statistics.mean(values):.{digits}g} ± {half_width(values):.2g}"

        def off(name, found=found, seeds=seeds):
            if found is limit:
                return ""
            logs = [math.log(float(one(found, s)[name]) / float(one(limit, s)[name]))
                    for s in seeds]
            middle = statistics.mean(logs)
            return (f"{100 * math.expm1(middle):+.1f} ± "
                    f"{100 * math.exp(middle) * half_width(logs):.1f}")
        frequency = SPEED / (1e-6 * along)
        others = [g for (f, a, _), g in groups.items() if f == "smooth" and a != along]

        def above(chosen, found=found, frequency=frequency, others=others):
            return level(lines(found, chosen, frequency)) - level(
                [line for other in others for line in lines(other, chosen, frequency)])
        tone_above, half = jackknife(above, seeds)
        print(f"| {faces} | {along:g} | {across:g} | {len(found)} | {mean('level', digits=5)} | "
              f"{mean('rate')} | {off('rate')} | {mean('median_duration', 1e6, 3)} | "
              f"{off('median_duration')} | {tone_above:+.2f} ± {half:.2f} | "
              f"{mean('seconds', 1, 3)} |")


FLOOR = 0.1  # %, the least difference that the chart can show


def rate_error(found, limit):
    """Of the rate of shocks, over pairs of the same seed [%]: its difference to the limit, and half
    its interval."""
    shared = [seed for seed in found if seed in limit]
    logs = [math.log(float(found[s]["rate"]) / float(limit[s]["rate"])) for s in shared]
    return 100 * abs(math.expm1(statistics.mean(logs))), 100 * half_width(logs)


def draw_convergence(rows, file):
    """For each stiffness the rate's difference to the finest smooth faces over the seconds of a
    simulated second."""
    plt, _ = pyplot()
    from matplotlib import ticker

    groups = {}
    for row in rows:
        groups.setdefault((float(row["stiffness"]), row["faces"], float(row["spacing"])),
                          {})[row["seed"]] = row
    stiffnesses = sorted({k for k, _, _ in groups})
    figure, axes = plt.subplots(1, len(stiffnesses), figsize=(3.6 * len(stiffnesses), 3.4),
                                sharey=True, squeeze=False,
                                layout="constrained")
    for ax, stiffness in zip(axes[0], stiffnesses):
        limit = groups[stiffness, "smooth",
                       min(s for k, f, s in groups if k == stiffness and f == "smooth")]
        for faces, colour, marker in (("linear", "tab:orange", "s"), ("smooth", "tab:blue", "o")):
            points = []
            for (k, f, spacing), found in sorted(groups.items()):
                if (k, f) != (stiffness, faces) or found is limit:
                    continue
                off, half = rate_error(found, limit)
                cost = statistics.mean(float(r["seconds"]) / float(r["duration"])
                                       for r in found.values())
                points.append((cost, off, half, 1e6 * spacing))
            ax.plot([], [], marker=marker, color=colour, ls="none", label=f"{faces} faces")
            for i, (cost, off, half, spacing) in enumerate(sorted(points)):
                low, high = max(off - half, FLOOR), max(off + half, FLOOR)
                ax.plot([cost, cost], [low, high], color=colour, alpha=0.5, lw=1.5)
                ax.plot(cost, max(off, FLOOR), marker="v" if off < FLOOR else marker,
                        color=colour, ls="none")
                if faces == "linear":
                    ax.annotate(f"{spacing:g}", (cost, max(off, FLOOR)), xytext=(5, 4),
                                textcoords="offset points", fontsize=8)
                else:  # they stand close together: one number above the other
                    top = max(off + half for _, off, half, _ in points)
                    ax.annotate(f"{spacing:g}", (cost, top), xytext=(0, 3 + 9 * (i % 3)),
                                textcoords="offset points", fontsize=8, ha="center")
        ax.axhline(2, color="0.6", lw=0.8, ls="--")
        ax.set(xscale="log", yscale="log", title=f"{stiffness:.0e} Pa/m".replace("e+", "e"),
               xlabel="processor time of a simulated second (s)")
        ax.xaxis.set_major_locator(ticker.LogLocator(subs=(1, 2, 5)))
        ax.xaxis.set_major_formatter(ticker.StrMethodFormatter("{x:g}"))
        ax.xaxis.set_minor_formatter(ticker.NullFormatter())
        ax.grid(alpha=0.3, which="both")
    axes[0][0].set_ylabel("rate of shocks: difference\nto its limit (%)")
    axes[0][-1].legend(loc="lower left", fontsize=8, title="numbers: spacing (um)",
                       title_fontsize=8)
    figure.savefig(file, dpi=110)


def level(lines):
    return 10 * math.log10(sum(a for a, _ in lines) / sum(b for _, b in lines))


def jackknife(of, seeds):
    """A number made of seeds, and half the width of its 95 % interval."""
    n = len(seeds)
    if n < 2:
        return of(seeds), math.nan
    without = [of(seeds[:i] + seeds[i + 1:]) for i in range(n)]
    middle = statistics.mean(without)
    error = math.sqrt((n - 1) / n * sum((w - middle)**2 for w in without))
    return of(seeds), scipy.stats.t.ppf(0.975, n - 1) * error


def summarize_tone(rows, names):
    groups = {}
    for row in rows:
        group = tuple(row[name] for name in names) + (float(row["frequency"]),)
        groups.setdefault(group, {})[row["seed"]] = float(row["line"]), float(row["around"])

    def controls(frequency):
        """Smooth faces whose mesh has no tone there."""
        if "spacing" in names:
            return [found for (faces, spacing, f), found in groups.items()
                    if f == frequency and faces == "smooth"
                    and abs(f * float(spacing) - SPEED) > 1e-9]
        return [found for group, found in groups.items() if group[:2] == ("spline", "spline")]
    print("| " + " | ".join(names)
          + " | frequency (Hz) | seeds | rise (dB) | above the control (dB) |\n|"
          + "---|" * (len(names) + 4))
    for group, found in sorted(groups.items()):
        if "spacing" in names and abs(group[-1] * float(group[1]) - SPEED) > 1e-9:
            continue
        others = [c for c in controls(group[-1]) if c is not found]
        seeds = [seed for seed in found if all(seed in c for c in others)]
        value, half = jackknife(lambda chosen: level([found[s] for s in chosen]), seeds)
        above = ""
        if others:
            more, width = jackknife(lambda chosen: level([found[s] for s in chosen])
                                    - level([c[s] for c in others for s in chosen]), seeds)
            above = f"{more:+.2f} ± {width:.2f}"
        print("| " + " | ".join(group[:-1])
              + f" | {group[-1]:g} | {len(seeds)} | {value:+.2f} ± {half:.2f} | {above} |")


CASES = {"convergence": convergence, "tone": tone, "parts": parts, "maps": maps}


def main():
    parser = argparse.ArgumentParser(description=__doc__,
                                     formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("case", choices=CASES)
    parser.add_argument("program")
    parser.add_argument("out", nargs="?")
    parser.add_argument("--seeds", type=int, default=10)
    parser.add_argument("--duration", type=float, default=1.0)
    parser.add_argument("--stiffness", type=float, nargs="+", default=[1e15, 1e16, 1e17])
    parser.add_argument("--spacings", type=float, nargs="+", metavar="UM")
    parser.add_argument("--fixed", type=float, metavar="STEP",
                        help="smooth faces by `exact` with this step [s], not adaptive")
    parser.add_argument("--jobs", type=int, default=1)
    parser.add_argument("--summary", action="store_true")
    parser.add_argument("--chart", metavar="FILE", help="convergence: draws it, too")
    options = parser.parse_args()
    options.out = pathlib.Path(options.out
                               or pathlib.Path(__file__).parent
                               / f"smooth_faces_{options.case}.csv")
    options.program = str(pathlib.Path(options.program).resolve())

    def rows():
        return list(csv.DictReader(open(options.out))) if options.out.exists() else []
    if not options.summary:
        run_all(options, rows())
    found = [row for row in rows() if float(row["duration"]) == options.duration
             and int(row["seed"]) <= options.seeds]
    if not found:
        sys.exit(f"no rows of {options.duration:g} s in {options.out}")
    if options.case == "convergence":
        summarize_convergence(found)
        if options.chart:
            draw_convergence(found, options.chart)
    elif options.case == "maps":
        summarize_maps(found)
    else:
        summarize_tone(found, ["faces", "spacing"] if options.case == "tone"
                       else ["resonator", "slider"])


main()
