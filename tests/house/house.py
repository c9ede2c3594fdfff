#!/usr/bin/env python3
# SPDX-License-Identifier: BSD-3-Clause
"""Whether the house stands: no floor includes what is above it, and no two things have one name.

usage: house.py SOURCE_FOLDER

- Every folder of host/ stands above all that it includes, and so does every header of kernels/.
- What reads and writes results (OF_FILES) stands without the device: it includes neither Kokkos nor
  kernels/ nor host/device, and no header that does.
- Kokkos is reached by the sources of host/ that host/CMakeLists.txt gives to its compiler
  (device_sources), by bench/chain.cpp and by the tests of KNOW_KOKKOS alone: in a build for CUDA no
  other source finds it.
- No two headers have one name: an include by its last word would find either.
- No two types have one name: two structs of one name in two files are undefined behaviour (of those
  in unnamed namespaces, which are no harm, a reader would confuse them: `allowed` lists these).
"""

import collections
import pathlib
import re
import sys

# From the ground up.
HOST = ["base", "system", "ranks", "scene", "surface", "body", "radiation", "scene_file", "result",
        "store", "analysis",
        "model", "device", "plan", "run", "ensemble", "study", "savings", "chart", "commands"]
# What reads and writes files: it reaches neither kernels/ nor host/device, by no chain of includes,
# but for what a scene names of the kernels.
IN_SCENES = ["kernels/nodes.hpp", "kernels/schemes/mode_step.hpp"]
OF_FILES = ["result", "store", "analysis"]
KNOW_KOKKOS = ("bench/chain.cpp", "tests/cuda/", "tests/install/", "tests/kernels/", "tests/ptx/",
               "tests/warp/")
KERNELS = ["check", "function", "limits", "nodes", "schemes", "tables", "state", "warp", "lanes",
           "displacement", "gap", "place", "footprint",
           "group_sweep", "candidate_groups", "candidates", "shocks", "contact", "fixed",
           "adaptive", "march"]

INCLUDE = re.compile(r'^\s*#include "((?:host|kernels|tests|bench)/[^"]+)"', re.MULTILINE)
KOKKOS = re.compile(r"^\s*#include <(Kokkos_[^>]+)>", re.MULTILINE)
TYPE = re.compile(r"^(?:template <.*>\s*)?(?:struct|class|enum(?: class)?) (\w+)(?: final)?(?: "
                  r"?:[^:;()][^;()]*)? \{", re.MULTILINE)


def floor_of(path):
    """(part, number of the floor, its name); None where the file belongs to no floor."""
    parts = path.split("/")
    if parts[0] == "host":
        name = parts[1] if len(parts) > 2 else "."
        return ("host", HOST.index(name), name) if name in HOST else None
    name = parts[1] if len(parts) > 2 else pathlib.PurePath(path).stem
    return ("kernels", KERNELS.index(name), name) if name in KERNELS else None


def without_comments(text):
    return re.sub(r"//[^\n]*|/\*.*?\*/", "", text, flags=re.DOTALL)


def named_types(text):
    """Types defined in namespace ra2d itself: at the left margin, outside unnamed namespaces."""
    text = without_comments(text)
    for unnamed in re.findall(r"^namespace \{\n.*?^\}  ?\n|^namespace \{\n.*?^\}\s*$", text,
                              re.DOTALL | re.MULTILINE):
        text = text.replace(unnamed, "")
    return TYPE.findall(text)


def chain_to(ends, path, includes):
    """A chain of includes from a file to one whose name begins with one of these; empty where there
    is none."""
    chains, seen = [[path]], {path}
    while chains:
        chain = chains.pop(0)
        for included in includes.get(chain[-1], []):
            if included.startswith(ends) and included not in IN_SCENES:
                return chain + [included]
            if included not in seen:
                seen.add(included)
                chains.append(chain + [included])
    return []


def reach_kokkos(root, includes):
    """Sources that no compiler of a build for CUDA could compile."""
    listed = re.search(r"set\(device_sources ([^)]*)\)", (root / "host/CMakeLists.txt").read_text())
    know = [f"host/{source}" for source in listed[1].split()]
    for path in includes:
        if path.endswith(".cpp") and path not in know and not path.startswith(KNOW_KOKKOS):
            if chain := chain_to("Kokkos_", path, includes):
                yield "what is compiled without Kokkos needs it: " + " includes ".join(chain)


def faults(root):
    files = sorted(p for folder in ("host", "kernels") for p in (root / folder).rglob("*.?pp"))
    if len(files) < 50:
        yield f"{root}: only {len(files)} files of host/ and kernels/ were found"
    headers, types = collections.defaultdict(list), collections.defaultdict(list)
    others = [p for folder in ("tests", "bench") for p in (root / folder).rglob("*.?pp")]
    texts = {file.relative_to(root).as_posix(): file.read_text() for file in files + others}
    includes = {path: INCLUDE.findall(text) + KOKKOS.findall(text) for path, text in texts.items()}
    yield from reach_kokkos(root, includes)
    for file in files:
        path = file.relative_to(root).as_posix()
        text = texts[path]
        here = floor_of(path)
        if here is None:
            yield f"{path}: its folder is on no floor: name it in tests/house/house.py"
            continue
        if here[0] == "host" and here[2] in OF_FILES and (
                chain := chain_to(("Kokkos_", "kernels/", "host/device/"), path, includes)):
            yield "what is made of files reaches the device: " + " includes ".join(chain)
        for included in INCLUDE.findall(text):
            there = floor_of(included)
            if there is None or not (root / included).exists():
                yield f"{path} includes {included}, which is on no floor"
            elif here[0] == "kernels" and there[0] == "host":
                yield f"{path} includes {included}: the kernels know nothing of host/"
            elif here[0] == there[0] and there[1] > here[1]:
                yield f"{path} includes {included}: '{there[2]}' is above '{here[2]}'"
        if path.endswith(".hpp"):
            headers[file.name].append(path)
        for name in set(named_types(text)):
            types[name].append(path)
    for what, names in (("headers", headers), ("types", types)):
        for name, places in names.items():
            if len(places) > 1:
                yield f"two {what} are called {name}: {', '.join(places)}"


def main():
    found = list(faults(pathlib.Path(sys.argv[1])))
    print("\n".join(found) or "the house stands")
    return 1 if found else 0


if __name__ == "__main__":
    sys.exit(main())
