#!/usr/bin/env python3
# SPDX-License-Identifier: BSD-3-Clause
"""What checkpoints cost: a long run of the paper's scene with a checkpoint every so many seconds,
against the same run with none.

usage: checkpoints.py PROGRAM [--seconds S] [--every S ...] [--runs N] [--folder FOLDER] [--set
       KEY=VALUE ...]

The run takes about S seconds of wall time and records at the scene's rate; its files go to FOLDER,
which should stand on the disk that results go to. What a run does beside its march is compared, and
the runs take turns, so that the machine's other work counts little. One checkpoint costs the same
whatever it covers (its state, and files brought to the disk), and something for each second that it
covers: what was recorded is written as segments and once more as one file. Both are fitted, and
give the cost at the default of ten minutes. The second goes with output.rate, which --set changes.
Standard library only.

    bench/checkpoints.py build/release/ra2d
"""
import argparse
import pathlib
import re
import statistics
import subprocess
import tempfile
import time

SCENE = pathlib.Path(__file__).resolve().parent.parent / "scenes" / "dang2012.toml"
DEFAULT = 600  # s


def run(program, duration, every, folder, settings):
    """Seconds: in all, marching; and how many checkpoints there were."""
    with tempfile.TemporaryDirectory(dir=folder) as place:
        words = [program, "run", SCENE, "-o", f"{place}/out.h5", "--set",
                 f"scene.duration={duration}",
                 "--set", "scene.speed=0.02"]
        for setting in settings:
            words += ["--set", setting]
        if every is not None:
            words += ["--checkpoint", str(every / 60)]
        begun, count = time.perf_counter(), 0
        process = subprocess.Popen(words, text=True, stdout=subprocess.PIPE)
        while process.poll() is None:
            count = max([count] + [int(part.stem)
                                   for part in pathlib.Path(place).glob("out.h5.parts/[0-9]*.h5")])
            time.sleep(0.01)
        wall = time.perf_counter() - begun
        report = process.stdout.read()
        if process.returncode != 0:
            raise SystemExit(f"the run ended with {process.returncode}")
    steps = int(re.search(r"(\d+) steps", report)[1])
    return wall, steps * float(re.search(r"([\d.]+) ns a step", report)[1]) * 1e-9, count


def main():
    parser = argparse.ArgumentParser(usage=__doc__.split("\n\n")[1].removeprefix("usage: "))
    parser.add_argument("program")
    parser.add_argument("--seconds", type=float, default=8)
    parser.add_argument("--every", type=float, nargs="+", default=[2, 1, 0.5, 0.25])
    parser.add_argument("--runs", type=int, default=3)
    parser.add_argument("--folder", default=".")
    parser.add_argument("--set", action="append", default=[])
    options = parser.parse_args()
    tried = 0.1
    duration = tried * options.seconds / run(options.program, tried, None, options.folder,
                                             options.set)[1]
    found = {every: [] for every in (None, *options.every)}
    for _ in range(options.runs):
        for every, runs in found.items():
            runs.append(run(options.program, duration, every, options.folder, options.set))
    overhead = {every: statistics.median(wall - march for wall, march, _ in runs)
                for every, runs in found.items()}
    march = statistics.median(march for runs in found.values() for _, march, _ in runs)
    print(f"{march:.1f} s of march; without checkpoints {overhead[None]:.3f} s beside it")
    print(f"{'every':>8} {'checkpoints':>12} {'cost':>9} {'each':>9} {'of the march':>13}")
    counts, costs = [], []
    for every in options.every:
        counts.append(statistics.median(count for _, _, count in found[every]))
        costs.append(overhead[every] - overhead[None])
        print(f"{every:6g} s {counts[-1]:12g} {costs[-1]:7.3f} s "
              f"{costs[-1] / max(counts[-1], 1) * 1e3:6.1f} ms "
              f"{costs[-1] / march:12.2%}")
    # cost = each * segments + share * march, by least squares; the end is a segment, too
    if len(set(counts)) > 1:
        counts = [count + 1 for count in counts]
        mean_count, mean_cost = statistics.mean(counts), statistics.mean(costs)
        each = (sum((n - mean_count) * (c - mean_cost) for n, c in zip(counts, costs))
                / sum((n - mean_count) ** 2 for n in counts))
        share = (mean_cost - each * mean_count) / march
        print(f"fitted: {each * 1e3:.1f} ms each and {share:.2%} of the march for what they cover; "
              f"at {DEFAULT / 60:g} min that is {each / DEFAULT:.3%} and {share:.2%}")


if __name__ == "__main__":
    main()
