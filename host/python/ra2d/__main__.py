# SPDX-License-Identifier: BSD-3-Clause
"""The program's way into this package. `ra2d plot` and its kind start this file with a request, as
JSON, on the standard input (host/commands/python.hpp). `python3 -m ra2d run ...` is the program."""
import importlib
import os
import sys

LIBRARIES = ("numpy", "h5py", "xarray", "pandas", "scipy", "matplotlib", "jinja2", "soundfile",
             "xxhash")
LIBRARY_MISSING = 9  # exit status


def library_missing() -> int:
    """Prints the libraries that cannot be imported; returns the exit status that says so."""
    found = []
    for name in LIBRARIES:
        try:
            importlib.import_module(name)
        except Exception:  # or it is there, and broken
            found.append(name)
    if not found:
        raise  # noqa: PLE0704: the fault that is being handled
    print(*found, sep="\n")
    return LIBRARY_MISSING


def main() -> int:
    if not __package__:  # started as a file: its own folder holds no modules for others
        sys.path[0] = os.path.dirname(os.path.dirname(os.path.abspath(__file__)))
    try:
        commands = importlib.import_module("ra2d.commands")
    except ImportError:
        return library_missing()
    except Exception as fault:  # a library that is broken
        print(f"ra2d: the Python package does not start: {type(fault).__name__}: {fault}",
              file=sys.stderr)
        return 4
    if len(sys.argv) > 1:
        program = importlib.import_module("ra2d.program").find()
        os.execv(program, [str(program), *sys.argv[1:]])
    return int(commands.main(sys.stdin))


if __name__ == "__main__":
    sys.exit(main())
