#!/usr/bin/env python3
# SPDX-License-Identifier: BSD-3-Clause
"""Whether comments and names keep to plain English and to one name for each thing
(CONTRIBUTING.md).

usage: language.py SOURCE_FOLDER [FOLDER_OR_FILE...]

Of all .hpp, .cpp and .py files, scripts of bash and CMake below kernels, host, tests, bench and
cmake, or of those named:

- no line of comment is longer than 100 columns, nor any line of Python, but for one string that
  cannot be parted (clang-format sees to C++);
- no comment of a declaration (///) begins with "...", "The same", "What" or "Who": it begins with
  the thing;
- no name is one of PRIVATE_NAMES, or one with "_" behind it: they once meant something to their
  authors alone.
"""

import io
import keyword
import pathlib
import re
import sys
import tokenize

# name -> what the field calls it
PRIVATE_NAMES = {
    "pull": "a bound on an acceleration, named for what it bounds",
    "push": "a force or an acceleration, named as such",
    "yield": "acceleration_per_newton",
    "yielding": "compliance",
    "swing": "displacement_per_energy_norm",
    "fourth": "the derivative that it is",
    "light": "of small mass",
    "told": "what is said, by its name",
    "untold": "unreported",
    "known": "the set that it is",
    "asked": "options or requested",
    "beside": "the relation that it is",
    "together": "the relation that it is",
    "several": "the number that it is",
    "Untold": "an error, named for what is wrong",
    "Unbelieved": "CorruptFile",
    "look": "evaluate, search or read, as it is",
    "looks": "evaluations or searches, as it is",
    "look_ahead": "forecast_contact",
    "Outlook": "ContactForecast",
    "outlook": "forecast",
    "watched": "listed_nodes or evaluated",
    "leeway": "margin",
    "kick": "dv, the velocity that a force adds",
    "climb": "a work or a rate, named as such",
    "bend": "a curvature, a deflection or a rise, as it is",
    "reach": "a range, or the bound that it is",
    "way": "a distance, a path, a direction or a choice, as it is",
    "t_": "tables_",
    "s_": "state_",
}
FOLDERS = ["kernels", "host", "tests", "bench", "cmake"]

COMMENT = re.compile(r"^\s*(///|//)( ?)(.*)$")
BEGINS = re.compile(r"^(\.\.\.|The same\b|What\b|Who\b)")
STRING = re.compile(r'"(?:[^"\\\n]|\\.)*"' + r"|'(?:[^'\\\n]|\\.)'")
RAW = re.compile(r'R"(\w*)\((?:.|\n)*?\)\1"')
# a use of a name, but as a member of something (queue.push) or in another namespace
# (std::this_thread::yield)
USED = re.compile(r"(?<![\w.>:])(%s)_?(?!\w)" % "|".join(PRIVATE_NAMES))


def of_scripts(path, text):
    """Lines of comment of Python, bash and CMake."""
    for number, line in enumerate(text.split("\n"), 1):
        if len(line) > 100 and line.lstrip().startswith("#") and "http" not in line:
            yield f"{path}:{number}: a comment of {len(line)} columns"


def of_python(path, text):
    """Names of Python: what stands in strings, formatted ones too, is not seen."""
    yield from of_scripts(path, text)
    for number, line in enumerate(text.split("\n"), 1):
        if len(line) > 100 and not line.lstrip().startswith("#") and len(line.split()) > 1:
            yield f"{path}:{number}: {len(line)} columns"
    for token in tokenize.generate_tokens(io.StringIO(text).readline):
        name = token.string
        if token.type == tokenize.NAME and name in PRIVATE_NAMES and not keyword.iskeyword(name):
            yield f"{path}:{token.start[0]}: '{name}': {PRIVATE_NAMES[name]}"


def faults_of(path, text):
    text = RAW.sub(lambda raw: "\n" * raw.group(0).count("\n"), text)
    begun = False  # in a block of ///
    for number, line in enumerate(text.split("\n"), 1):
        comment = COMMENT.match(line)
        if comment and len(line) > 100 and "http" not in line:
            yield f"{path}:{number}: a comment of {len(line)} columns"
        if comment and comment.group(1) == "///":
            if not begun and BEGINS.match(comment.group(3)):
                yield (f"{path}:{number}: begins with '{BEGINS.match(comment.group(3)).group(0)}': "
                       f"{line.strip()}")
            begun = True
            continue
        begun = False
        if comment:
            continue
        code = STRING.sub('""', line).split("//")[0]
        for found in USED.finditer(code):
            yield f"{path}:{number}: '{found.group(0)}': {PRIVATE_NAMES[found.group(1)]}"


CHECKS = {".hpp": faults_of, ".cpp": faults_of, ".py": of_python, ".sh": of_scripts,
          ".cmake": of_scripts, ".txt": of_scripts}


def main():
    root = pathlib.Path(sys.argv[1])
    named = [root / name for name in sys.argv[2:]] or [root / folder for folder in FOLDERS]
    files = [f for n in named for f in ([n] if n.is_file() else sorted(n.rglob("*")))
             if f.suffix in CHECKS and f.is_file() and "corpus" not in f.parts]
    if not files:
        raise SystemExit(f"{root}: no files")
    found = [fault for file in files
             for fault in CHECKS[file.suffix](file.relative_to(root).as_posix(), file.read_text())]
    print("\n".join(found) or f"{len(files)} files: no fault of language")
    sys.exit(bool(found))


if __name__ == "__main__":
    main()
