#!/usr/bin/env python3
# SPDX-License-Identifier: BSD-3-Clause
"""Whether the tests would notice: puts small faults into the code, one at a time, and runs the
tests that ought to fail.

usage: faults_on_purpose.py BUILD_FOLDER [--only TEXT] [--share I/N] [--jobs N]
       faults_on_purpose.py --list [--only TEXT] [--share I/N]
       faults_on_purpose.py --check [SOURCE_FOLDER]

faults.toml in this folder has the faults, in groups [[faults_of]]. A group has

  file     from the root
  compile  the sources compiled with it, where `file` is a header
  tests    a test program and a filter, as `test_kernels Gap.*`; several such are tried in turn
  program  true: the tests run the program ra2d, which is then linked with the fault, too
  faults   a list of
    id       a name
    in       name of a function: only its body is searched (default: the whole file)
    find     a regular expression that matches once. A blank in it matches any white space
    replace  what it becomes, as for re.sub

A fault may have `tests` of its own. --check only verifies that each pattern matches exactly once:
it takes a second.

Neither the sources nor the build folder change: the faulty file stands in a folder of its own that
is searched first, only the sources named are compiled with it, and their objects take the place of
the sound ones when the test program is linked. The build folder must be up to date.

A fault is killed when a test fails, crashes or does not end. One that survives is a test that is
missing; that is a failure of this script, as is a fault that does not compile or whose pattern does
not match once.
"""

import argparse
import concurrent.futures
import json
import pathlib
import re
import shlex
import subprocess
import sys
import tempfile
import threading
import time
import tomllib

HERE = pathlib.Path(__file__).resolve().parent
ROOT = HERE.parents[1]
COMPILE_LIMIT, TEST_LIMIT = 600, 240  # s


class Broken(Exception):
    """A fault in the table, not in the code."""


def shell(command, folder, limit):
    return subprocess.run(command, cwd=folder, timeout=limit, text=True, errors="replace",
                          stdout=subprocess.PIPE, stderr=subprocess.STDOUT)


# by host/CMakeLists.txt
GENERATED = re.compile(r"generated/march_(semi_implicit|staged|implicit|adaptive)_(few|many)\.cpp")
MASKED = re.compile(r'//[^\n]*|/\*.*?\*/|"(?:[^"\\\n]|\\.)*"' + r"|'(?:[^'\\\n]|\\.)'", re.DOTALL)


def end_of(text, begin, open, close):
    """The place behind the bracket that closes the one at `begin`."""
    depth = 0
    for at in range(begin, len(text)):
        depth += (text[at] == open) - (text[at] == close)
        if depth == 0:
            return at + 1
    return len(text)


def bodies_of(text, function):
    """Where the bodies of the functions of a name stand: [(begin, end)]."""
    masked = MASKED.sub(lambda found: " " * len(found.group(0)), text)
    bodies = []
    for named in re.finditer(rf"\b{function}\s*\(", masked):
        behind = end_of(masked, named.end() - 1, "(", ")")
        if body := re.compile(r"[\s\w:&*<>,]*(?:->[\s\w:&*<>,]*)?\{").match(masked, behind):
            bodies.append((body.end(), end_of(masked, body.end() - 1, "{", "}")))
    return bodies


def changed(text, fault):
    """The text with the fault in it."""
    pattern = re.compile(re.sub(" +", r"\\s+", fault["find"]))
    ranges = bodies_of(text, fault["in"]) if "in" in fault else [(0, len(text))]
    if not ranges:
        raise Broken(f"{fault['file']} defines no function {fault['in']}")
    found = [match for begin, end in ranges for match in pattern.finditer(text, begin, end)]
    if len(found) != 1:
        raise Broken(f"its pattern matches {len(found)} times in {fault['file']}")
    made = found[0].expand(fault["replace"])
    if made == found[0].group(0):
        raise Broken("it changes nothing")
    return text[: found[0].start()] + made + text[found[0].end() :]


def read_faults():
    """All faults, each with the keys of its group."""
    faults = []
    for group in tomllib.loads((HERE / "faults.toml").read_text())["faults_of"]:
        shared = {key: value for key, value in group.items() if key != "faults"}
        faults += [{**shared, **fault} for fault in group["faults"]]
    ids = [fault["id"] for fault in faults]
    if twice := {name for name in ids if ids.count(name) > 1}:
        sys.exit(f"more than one fault is called {', '.join(sorted(twice))}")
    return faults


def check(faults, root):
    """What is wrong with the table, a line each."""
    for fault in faults:
        named = [fault["file"], *fault.get("compile", [])]
        if missing := [name for name in named if not (root / name).exists()
                       and not GENERATED.fullmatch(name)]:
            yield f"{fault['id']}: there is no {', '.join(missing)}"
        elif fault["file"].endswith(".hpp") and "compile" not in fault:
            yield f"{fault['id']}: a header needs `compile`"
        else:
            try:
                changed((root / fault["file"]).read_text(), fault)
            except Broken as what:
                yield f"{fault['id']}: {what}"


class Build:
    def __init__(self, folder):
        self.folder = folder.resolve()
        # of every source: path from the root (of a march, which CMake makes, generated/NAME) ->
        # (arguments, object) for each program that has it
        self.commands = {}
        for entry in json.loads((folder / "compile_commands.json").read_text()):
            path = pathlib.Path(entry["file"])
            arguments = shlex.split(entry["command"])
            for source in self.unity_members(path) or [path]:
                if source.is_relative_to(self.folder / "host"):
                    name = source.relative_to(self.folder / "host").as_posix()
                elif source.is_relative_to(ROOT):
                    name = source.relative_to(ROOT).as_posix()
                else:
                    continue
                self.commands.setdefault(name,
                                         []).append((arguments,
                                                     arguments[arguments.index("-o") + 1]))
        self.links, self.sound, self.lock = {}, {}, threading.Lock()

    def unity_members(self, path):
        """The sources that a file of CMake's includes, where those of a folder are compiled
        together (RA2D_BY_FOLDER)."""
        if path.parent.name != "Unity" or not path.is_relative_to(self.folder):
            return []
        return [pathlib.Path(source) for source in re.findall(r'#include "(.*)"', path.read_text())]

    def link_of(self, target):
        """What links `target`, a path in the build folder."""
        if target not in self.links:
            text = shell(["ninja", "-t", "commands", target], self.folder,
                         60).stdout.splitlines()[-1]
            parts = [shlex.split(part) for part in text.split(" && ")]
            self.links[target] = next(part for part in parts if "-o" in part and target in part)
        return self.links[target]

    def link(self, target, objects, made):
        """Links `target` as the file `made`, with faulty objects for sound ones."""
        def has_tests(place):
            return f"/{pathlib.Path(target).name}.dir/" in place and pathlib.Path(
                place).name.startswith("test_")
        # Where tests are compiled with the fault, others stay out: of a template's function that
        # stands in several objects, the linker takes one, and that may be a sound one.
        alone = any(map(has_tests, objects))
        words = [word for word in self.link_of(target) if word not in objects
                 and not (alone and has_tests(word))]
        # before the libraries that have the sound ones
        words[words.index("-o") + 1 : words.index("-o") + 2] = [made, *objects.values()]
        done = shell(words, self.folder, COMPILE_LIMIT)
        if done.returncode != 0:
            raise Broken("does not link: " + done.stdout[-300:])

    def sources(self, names):
        """As named; where the march is compiled for the most modes alone (RA2D_ONE_MARCH), that one
        for another."""
        found = [name if name in self.commands else name.replace("_few.", "_many.")
                 for name in names]
        if missing := [name for name in found if name not in self.commands]:
            raise Broken(f"no source is called {', '.join(missing)}")
        return found

    def run(self, program, tests, filter, ra2d=None):
        """None where all tests pass, or what fails."""
        try:
            done = shell([*(["env", f"RA2D_PROGRAM={ra2d}"] if ra2d else []), program,
                          f"--gtest_filter={filter}", "--gtest_fail_fast", "--gtest_brief=1"],
                         self.folder, TEST_LIMIT)
        except subprocess.TimeoutExpired:
            return f"{tests}: does not end"
        if re.search(r"^\[==========\] 0 tests", done.stdout, re.MULTILINE):
            raise Broken(f"{tests} has no test {filter}")
        if done.returncode == 0:
            return None
        failed = re.findall(r"^\[  FAILED  \] ([\w./]+)", done.stdout, re.MULTILINE)
        return failed[0] if failed else f"{tests}: ends with {done.returncode}"

    def is_sound(self, tests, filter):
        with self.lock:
            run = self.sound.setdefault((tests, filter), concurrent.futures.Future())
            first = not run.running() and not run.done() and run.set_running_or_notify_cancel()
        if first:
            try:
                run.set_result(self.run(f"{self.folder}/tests/{tests}", tests, filter))
            except Broken as what:
                run.set_exception(what)
        return run.result()


def concerns(source, program):
    """Whether a test program needs a source compiled again: its own, and all of host/. The march is
    left to those that run it: the tests of the kernels include what they test."""
    if source.startswith("tests/"):
        return program == "test_" + source.split("/")[1]
    return program != "test_kernels" or not source.startswith("generated/march_")


def apply(build, fault, folder):
    """(what came of it, more of that)."""
    faulty = folder / "changed" / fault["file"]
    faulty.parent.mkdir(parents=True)
    faulty.write_text(changed((ROOT / fault["file"]).read_text(), fault))
    made = {}

    def objects_for(program):
        """Those of its sources that are concerned: the place of each in the build folder, and the
        faulty one."""
        for source in build.sources(fault.get("compile", [fault["file"]])):
            if not concerns(source, program):
                continue
            compiled = build.commands[source]
            arguments, place = next((each for each in compiled if f"/{program}.dir/" in each[1]),
                                    compiled[0])
            if place not in made:
                mine = f"{folder}/{place.replace('/', '_')}"
                names = {place: mine, f"{ROOT}/{fault['file']}": str(faulty)}
                # of sources that are compiled together: the same, with the faulty one
                for word in arguments:
                    if build.unity_members(pathlib.Path(word)):
                        names[word] = f"{mine}.cxx"
                        pathlib.Path(names[word]).write_text(
                            pathlib.Path(word).read_text().replace(f"{ROOT}/{fault['file']}",
                                                                   str(faulty)))
                done = shell([*(names.get(word, word) for word in arguments), "-iquote",
                              f"{folder}/changed",
                              "-Wno-error"], build.folder, COMPILE_LIMIT)
                if done.returncode != 0:
                    why = re.findall(r"error: .*", done.stdout) or [done.stdout[-300:]]
                    raise Broken("does not compile: " + why[0])
                made[place] = mine
            yield place, made[place]

    wanted = fault["tests"] if isinstance(fault["tests"], list) else [fault["tests"]]
    for tests, filter in (entry.split() for entry in wanted):
        if (failed := build.is_sound(tests, filter)) is not None:
            raise Broken(f"without the fault fails {failed}")
        objects = dict(objects_for(tests))
        ra2d = f"{folder}/ra2d" if fault.get("program") else None
        if ra2d:
            build.link("ra2d", objects, ra2d)
        # those of the program's own sources, its commands, are in no test
        in_tests = {place: mine for place, mine in objects.items() if "/ra2d.dir/" not in place}
        tester = f"{folder}/{tests}" if in_tests else f"{build.folder}/tests/{tests}"
        if in_tests:
            build.link(f"tests/{tests}", in_tests, tester)
        killer = build.run(tester, tests, filter, ra2d)
        if in_tests:
            (folder / tests).unlink()
        if killer:
            return "killed", killer
    return "survived", "of " + ", ".join(wanted)


def judge(build, fault):
    begin = time.time()
    with tempfile.TemporaryDirectory(dir=build.folder, prefix="fault-") as folder:
        try:
            outcome, more = apply(build, fault, pathlib.Path(folder))
        except Broken as what:
            outcome, more = "broken", str(what)
        except subprocess.TimeoutExpired:
            outcome, more = "broken", "takes too long to compile"
    return fault, outcome, more, time.time() - begin


def main():
    arguments = argparse.ArgumentParser(description=__doc__,
                                        formatter_class=argparse.RawDescriptionHelpFormatter)
    arguments.add_argument("build", type=pathlib.Path, nargs="?",
                           help="build folder; of --check the sources")
    arguments.add_argument("--only", action="append",
                           help="those whose id or file contains this; may be repeated")
    arguments.add_argument("--share", default="1/1", help="every N-th of them, from the I-th on")
    arguments.add_argument("--jobs", type=int, default=1, help="faults at a time")
    arguments.add_argument("--list", action="store_true", help="print their names and files")
    arguments.add_argument("--check", action="store_true",
                           help="only verify that each pattern matches once")
    options = arguments.parse_args()
    faults = read_faults()
    if options.only:
        faults = [f for f in faults if any(text in f["id"] or text in f["file"]
                                           for text in options.only)]
    first, of = map(int, options.share.split("/"))
    faults = faults[first - 1 :: of]
    if options.list:
        print("\n".join(f"{fault['id']:<32} {fault['file']}" for fault in faults))
        return 0
    if options.check:
        wrong = list(check(faults, options.build or ROOT))
        print("\n".join(wrong) or f"{len(faults)} faults: each pattern matches once")
        return 1 if wrong else 0
    if options.build is None:
        arguments.error("a build folder is needed")
    if not faults:
        sys.exit("no such fault")
    build = Build(options.build)
    counts = {}
    with concurrent.futures.ThreadPoolExecutor(options.jobs) as pool:
        for run in concurrent.futures.as_completed([pool.submit(judge, build, fault)
                                                    for fault in faults]):
            fault, outcome, more, took = run.result()
            counts[outcome] = counts.get(outcome, 0) + 1
            print(f"{outcome:<9} {fault['id']:<32} {took:4.0f} s  {fault['file']}: {more}",
                  flush=True)
    print(", ".join(f"{number} {outcome}" for outcome, number in sorted(counts.items())))
    return 1 if counts.keys() - {"killed"} else 0


if __name__ == "__main__":
    sys.exit(main())
