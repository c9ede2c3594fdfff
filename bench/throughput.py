#!/usr/bin/env python3
# SPDX-License-Identifier: BSD-3-Clause
"""throughput.py FILE.json [ONE_CORE.json [ALL_CORES.json]] [--picture FILE.svg]: scenes by the
thousand, as docs/ has it.

Of what `bench_throughput --benchmark_out=FILE.json` wrote: on a GPU, and beside it on one core
(OMP_NUM_THREADS=1) and on all cores of the same machine. Prints, for each number of scenes, seconds
simulated in a second, and in brackets how many times that is what one core does at its best; then
all cores and the shocks. The picture shows the same.
"""
import argparse
import collections
import json
import pathlib
import re
import statistics
import sys

from pictures import pyplot

METHODS = {"adaptive": "adaptive, 1e-6", "backward-euler": "backward Euler, 10 ns",
           "adaptive-100kHz": "adaptive, samples at 100 kHz"}


def read(file):
    """What the file says of itself, and {(method, paper): {scenes: {counter: median}}}."""
    values = collections.defaultdict(
        lambda: collections.defaultdict(lambda: collections.defaultdict(list)))
    try:
        content = json.loads(pathlib.Path(file).read_text())
        content["context"]
        for case in content["benchmarks"]:
            name = re.match(r"([\w-]+)/(free|pinned)/(\d+)(/|$)", case["name"])
            if not name or case.get("run_type") == "aggregate" or case.get("error_occurred"):
                continue
            for counter in ("simulated", "shocks", "whole", "at_once"):
                values[name[1], name[2]][int(name[3])][counter].append(float(case[counter]))
    except (OSError, ValueError, KeyError, TypeError, AttributeError) as fault:
        sys.exit(f"{file}: not what --benchmark_out writes: {fault!r}")
    if not values:
        sys.exit(f"{file}: holds no case of bench_throughput")
    return content["context"], {scene: {count: {name: statistics.median(all)
                                                for name, all in counters.items()}
                                        for count, counters in sorted(counts.items())}
                                for scene, counts in values.items()}


def best(counts, counter="simulated"):
    return max(each[counter] for each in counts.values())


def number(value):
    return f"{value:.3g}" if value < 1000 else f"{value:.0f}"


def table(cases, one, all_cores):
    scenes = list(cases)
    counts = sorted({count for each in cases.values() for count in each})
    lines = ["| scenes | " + " | ".join(f"{METHODS.get(method, method)}; {paper}"
                                        for method, paper in scenes) + " |",
             "|" + "---|" * (len(scenes) + 1)]

    def over_one(scene, value):
        return f" ({value / best(one[scene]):.3g})" if scene in one else ""

    def row(title, values):
        lines.append(f"| {title} | " + " | ".join(values) + " |")

    for count in counts:
        row(count,
            [number(cases[scene][count]["simulated"]) + over_one(scene,
                                                                 cases[scene][count]["simulated"])
             if count in cases[scene] else "" for scene in scenes])
    row("the best, making scenes ready included",
        [number(best(cases[scene], "whole")) + over_one(scene, best(cases[scene], "whole"))
         for scene in scenes])
    row("shocks in a second, at the best",
        [number(best(cases[scene], "shocks")) for scene in scenes])
    for title, other in (("one core", one), ("all cores", all_cores)):
        if other:
            row(title, [number(best(other[scene])) + over_one(scene, best(other[scene]))
                        if scene in other else ""
                        for scene in scenes])
    return "\n".join(lines)


def draw(picture, cases, one, all_cores, title):
    plt, style = pyplot()
    from matplotlib.ticker import FuncFormatter
    figure, axes = plt.subplots(1, len(METHODS), figsize=(12, 4.4), layout="constrained")
    for axis, (method, words) in zip(axes, METHODS.items()):
        for paper, colour in (("free", "#1f77b4"), ("pinned", "#d62728")):
            scene = method, paper
            if scene not in cases:
                continue
            counts = cases[scene]
            axis.loglog(list(counts), [each["simulated"] for each in counts.values()], "o-",
                        color=colour,
                        label=f"slider {paper}")
            for other, line in ((one, ":"), (all_cores, "--")):
                if scene in other:
                    axis.axhline(best(other[scene]), color=colour, linestyle=line)
        axis.set(title=words, xlabel="scenes side by side", ylabel="seconds simulated in a second")
        axis.set_xscale("log", base=4)
        for scale in (axis.xaxis, axis.yaxis):
            scale.set_major_formatter(FuncFormatter(lambda value, _: f"{value:g}"))
            scale.set_minor_formatter(FuncFormatter(lambda value, _: ""))
        axis.grid(alpha=0.3)
    handles, labels = axes[0].get_legend_handles_labels()
    handles += [plt.Line2D([], [], color="grey", linestyle=line)
                for line, other in ((":", one), ("--", all_cores)) if other]
    labels += [words for words, other in (("one core", one), ("all cores", all_cores)) if other]
    axes[0].legend(handles, labels, fontsize=8)
    figure.suptitle(style.literal(f"Scenes by the thousand: {title}"))
    pathlib.Path(picture).write_bytes(style.Picture.drawn(figure, pathlib.Path(picture).suffix[1:]))


def main():
    words = argparse.ArgumentParser(description=__doc__.split("\n\n")[0])
    words.add_argument("files", nargs="+", metavar="FILE.json")
    words.add_argument("--picture", help="draws it: .svg, .png or .pdf")
    options = words.parse_args()
    if options.picture and pathlib.Path(options.picture).suffix not in (".svg", ".png", ".pdf"):
        words.error("--picture: a name that ends in .svg, .png or .pdf")
    if len(options.files) > 3:
        words.error("three files at the most: of the GPU, of one core, of all cores")
    context, cases = read(options.files[0])
    one = read(options.files[1])[1] if len(options.files) > 1 else {}
    all_cores = read(options.files[2])[1] if len(options.files) > 2 else {}
    where = context.get("device") or f"{context.get('threads')} threads of a CPU"
    print(f"Seconds simulated in a second, {where}, {context.get('ra2d')}"
          + ("; in brackets, over one core" if one else "") + ":\n")
    print(table(cases, one, all_cores))
    if options.picture:
        draw(options.picture, cases, one, all_cores, where)


if __name__ == "__main__":
    main()
