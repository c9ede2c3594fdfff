#!/usr/bin/env python3
# SPDX-License-Identifier: BSD-3-Clause
"""PTX of the marches, one file a form, for the interpreter in tests/ptx: of teams for 24 or 32
modes, or with --packs of whole warps for so many packs of 32.

usage: make_ptx.py [--jobs N] [--packs N] BUILD FOLDER [FORM...]

BUILD was configured for CUDA; nothing in it has to be built. The flags are those of its own
marches, but optimised and with the source's lines: so what is wrong with the flags shows in the
PTX. All is inlined, which the build's own march of multipliers is not (kernels/function.hpp): the
interpreter knows no calls. Writes FOLDER/FORM.ptx; all forms, or those named. Standard library
only.
"""
import argparse
import concurrent.futures
import json
import pathlib
import re
import shlex
import subprocess
import sys

# Form in kernels/tables.hpp; the longest first
FORMS = ["implicit", "adaptive", "staged", "semi_implicit"]
# Lanes of a team and packs of modes, as test_ptx and device_counts take them (march_program.hpp)
SHAPES = {"semi_implicit": (8, 3)}
SOURCE = pathlib.Path(__file__).resolve().parent / "march.cu"


def flags_of(build):
    """How the build compiles a march: its command without what goes in and comes out."""
    listed = build / "compile_commands.json"
    if not listed.exists():
        raise SystemExit(f"{listed} is not there: configure a CUDA build first (cmake --preset "
                         "cuda)")
    for entry in json.loads(listed.read_text()):
        if re.search(r"/generated/march_\w+\.cpp$", entry["file"]) and "-arch=" in entry["command"]:
            words = shlex.split(entry["command"])[1:]
            end = words.index("-o")
            return [w for w in words[:end] if not re.fullmatch(r"-O\d|-G", w)]
    raise SystemExit(f"{build} is not configured for CUDA: cmake --preset cuda")


def make(build, flags, form, packs, out):
    """Compiles one form."""
    width, packs = (32, packs) if packs else SHAPES.get(form, (32, 1))
    wrapper = build / "_deps/kokkos-src/bin/nvcc_wrapper"
    options = [wrapper, "--show", *flags, "-O3", "-lineinfo", f"-DRA2D_PTX_FORM={form}",
               f"-DRA2D_PTX_WIDTH={width}", f"-DRA2D_PTX_PACKS={packs}",
               "-DRA2D_PTX_PORTABLE_FUNCTIONS", "-c", SOURCE, "-o", out]
    shown = subprocess.run([str(word) for word in options], cwd=build,
                           capture_output=True, text=True)
    if shown.returncode != 0:
        raise SystemExit(f"{wrapper} does not say how it calls nvcc:\n"
                         f"{shown.stdout + shown.stderr}")
    # what the wrapper would run, but for PTX
    command = ["-ptx" if word == "-c" else word
               for word in shlex.split(shown.stdout.splitlines()[-1])]
    done = subprocess.run(command, cwd=build, capture_output=True, text=True)
    if done.returncode != 0:
        raise SystemExit(f"{form}: {SOURCE} does not "
                         f"compile:\n{(done.stdout + done.stderr)[-3000:]}")


def main():
    parser = argparse.ArgumentParser(usage=__doc__.split("\n\n")[1].removeprefix("usage: "))
    parser.add_argument("build", type=pathlib.Path)
    parser.add_argument("folder", type=pathlib.Path)
    parser.add_argument("forms", nargs="*", choices=[*FORMS, []], default=[])
    parser.add_argument("--jobs", type=int, default=1)
    parser.add_argument("--packs", type=int)
    options = parser.parse_args()
    build, folder = options.build.resolve(), options.folder.resolve()
    flags = flags_of(build)
    folder.mkdir(parents=True, exist_ok=True)
    with concurrent.futures.ThreadPoolExecutor(options.jobs) as pool:
        list(pool.map(lambda form: make(build, flags, form, options.packs, folder / f"{form}.ptx"),
                      options.forms or FORMS))


if __name__ == "__main__":
    sys.exit(main())
