#!/usr/bin/env python3
# SPDX-License-Identifier: BSD-3-Clause
"""Whether the commands of docs/tutorial.md work and print what the page shows.

usage: tutorial.py RA2D TUTORIAL.md

In an empty folder: each ```toml block that begins with "# NAME" is saved as NAME; each ```sh block
runs, and must end with 0. Each line of a ```text block must be among what the commands before it
have printed since the last ```text block, in this order. Numbers may differ: other processors give
other last bits, and the motion is chaotic. Afterwards every file that a comment of a command names
must be there.
"""
import os
import pathlib
import re
import subprocess
import sys
import tempfile

BLOCK = re.compile(r"^```(\w+)\n(.*?)^```$", re.MULTILINE | re.DOTALL)
NUMBER = re.compile(r"[-+]?\d+(?:\.\d+)?(?:e[-+]?\d+)?")


def plain(line):
    return " ".join(NUMBER.sub("N", line).split())


def expect_in_order(shown, printed):
    lines = iter([plain(line) for line in printed.splitlines()])
    for line in shown.splitlines():
        if not any(each == plain(line) for each in lines):
            raise SystemExit(f"the page shows '{line}', which was not printed there:\n{printed}")


def main():
    program, page = pathlib.Path(sys.argv[1]).resolve(), pathlib.Path(sys.argv[2]).read_text()
    environment = {**os.environ, "PATH": f"{program.parent}:{os.environ['PATH']}"}
    counts = {"sh": 0, "text": 0, "toml": 0}
    with tempfile.TemporaryDirectory() as folder:
        printed = ""
        for kind, text in BLOCK.findall(page):
            if kind not in counts:
                continue
            counts[kind] += 1
            if kind == "toml":
                name = text.split("\n")[0].removeprefix("# ")
                pathlib.Path(folder, name).write_text(text)
            elif kind == "text":
                expect_in_order(text, printed)
                printed = ""
            else:
                done = subprocess.run(["bash", "-euc", text], cwd=folder, env=environment,
                                      text=True, capture_output=True,
                                      timeout=300, check=False)
                if done.returncode:
                    raise SystemExit(f"{text}ended with "
                                     f"{done.returncode}:\n{done.stdout}{done.stderr}")
                printed += done.stdout
                for name in re.findall(r"# (\S+\.\w+)", text):
                    if not pathlib.Path(folder, name.rstrip(":")).is_file():
                        raise SystemExit(f"{text}was to make {name}")
    if not all(counts.values()):
        raise SystemExit(f"the page has too few blocks to be a tutorial: {counts}")
    print(f"{counts['sh']} blocks of commands, {counts['text']} of output: as the page has them")


if __name__ == "__main__":
    main()
