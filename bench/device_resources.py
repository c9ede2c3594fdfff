#!/usr/bin/env python3
# SPDX-License-Identifier: BSD-3-Clause
"""What each compiled march takes of a GPU, and what that leaves room for: registers, stack, spills
and shared memory, as ptxas says, and how many scenes, of `lanes` threads each, are then in flight
on a multiprocessor and on a card.

usage: device_resources.py [--architecture sm_90] [--multiprocessors 132] [--only TEXT] [--jobs N]
                           [-o TABLE.csv] BUILD

BUILD is a folder that was configured for CUDA; nothing in it has to be built. No GPU is needed.
--only takes the sources whose names have TEXT in them:

    cmake --preset cuda && bench/device_resources.py build/cuda

Prints a table in Markdown. Standard library only.
"""
import argparse
import concurrent.futures
import csv
import json
import pathlib
import re
import shlex
import subprocess
import sys
import tempfile

FORMS = ["semi_implicit", "staged", "implicit", "adaptive"]  # Form in kernels/tables.hpp
WARP = 32
# of a multiprocessor of compute capability 8.0, 9.0 and 10.0 alike (CUDA C++ Programming Guide,
# technical specifications): 32-bit registers, which a warp gets in pieces of 256, and blocks
REGISTERS, PIECE, BLOCKS = 65536, 256, 32


def compile_march(entry, wrapper, architecture):
    """What ptxas says of the marches of one source: {(form, lanes, packs): figures}."""
    words = shlex.split(entry["command"])
    words[0] = str(wrapper)
    words = [f"-arch={architecture}" if word.startswith("-arch=") else word for word in words]
    with tempfile.TemporaryDirectory() as folder:
        words[words.index("-o") + 1] = f"{folder}/march.o"
        done = subprocess.run([*words, "-Xptxas", "-v"], cwd=entry["directory"],
                              capture_output=True, text=True)
    if done.returncode != 0:
        raise SystemExit(f"{entry['file']} does not compile:\n{done.stderr[-2000:]}")
    found = {}
    for part in done.stderr.split("Compiling entry function '")[1:]:
        name = subprocess.run(["c++filt", part.split("'")[0]], capture_output=True, text=True,
                              check=True).stdout
        march = re.search(r"ra2d::March<[^,]*, ra2d::WarpLanes<(\d+)>, \(ra2d::Form\)(\d+), (\d+)>",
                          name)
        if not march:
            continue

        def number(pattern):
            match = re.search(pattern, part)
            return int(match[1]) if match else 0

        registers = number(r"Used (\d+) registers")
        pieces = -(-registers * WARP // PIECE) * PIECE
        lanes, form, packs = (int(word) for word in march.groups())
        found[FORMS[form], lanes, packs] = {
            "registers": registers, "stack": number(r"(\d+) bytes stack frame"),
            "spilled": number(r"(\d+) bytes spill stores"), "shared": number(r"(\d+) bytes smem"),
            "constant": number(r"(\d+) bytes cmem"),
            "scenes": min(BLOCKS, REGISTERS // pieces) * (WARP // lanes)}
    return found


def main():
    parser = argparse.ArgumentParser(usage=__doc__.split("\n\n")[1].removeprefix("usage: "))
    parser.add_argument("build", type=pathlib.Path)
    parser.add_argument("--architecture", default="sm_90")
    parser.add_argument("--multiprocessors", type=int, default=132,
                        help="of the card; an H100 or H200 has 132")
    parser.add_argument("--only", default="")
    parser.add_argument("--jobs", type=int, default=1)
    parser.add_argument("-o", "--output", type=pathlib.Path)
    options = parser.parse_args()

    listed = options.build / "compile_commands.json"
    if not listed.exists():
        raise SystemExit(f"{listed} is not there: configure a CUDA build first (cmake --preset "
                         "cuda)")
    entries = [e for e in json.loads(listed.read_text())
               if re.search(r"/generated/march_\w+\.cpp$", e["file"]) and options.only in e["file"]]
    if not entries or "-arch=" not in entries[0]["command"]:
        raise SystemExit(f"{options.build} is not configured for CUDA: cmake --preset cuda")
    wrapper = options.build.resolve() / "_deps/kokkos-src/bin/nvcc_wrapper"
    with concurrent.futures.ThreadPoolExecutor(options.jobs) as pool:
        marches = {}
        for found in pool.map(lambda e: compile_march(e, wrapper, options.architecture), entries):
            marches.update(found)

    print(f"| march, {options.architecture} | modes | lanes | registers | stack, bytes "
          "| spilled, bytes | shared memory, bytes "
          f"| scenes on a multiprocessor | on {options.multiprocessors} |")
    print("|---|---|---|---|---|---|---|---|---|")
    rows = []
    for form, lanes, packs in sorted(
            marches, key=lambda march: (FORMS.index(march[0]), march[1] * march[2])):
        m = marches[form, lanes, packs]
        rows.append([form, lanes * packs, lanes, m["registers"], m["stack"], m["spilled"],
                     m["shared"], m["scenes"],
                     m["scenes"] * options.multiprocessors])
        print("| " + " | ".join(str(cell) for cell in rows[-1]) + " |")
    if options.output:
        with options.output.open("w", newline="") as file:
            writer = csv.writer(file)
            writer.writerow(["march", "modes", "lanes", "registers", "stack", "spilled", "shared",
                             "scenes_on_multiprocessor",
                             "scenes_on_card"])
            writer.writerows(rows)


if __name__ == "__main__":
    sys.exit(main())
