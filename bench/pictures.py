# SPDX-License-Identifier: BSD-3-Clause
"""Pictures of the benchmarks and of the validation, in the style of the program's own."""
import pathlib
import sys

PACKAGE = pathlib.Path(__file__).resolve().parents[1] / "host" / "python"


def pyplot():
    """(matplotlib.pyplot, ra2d.style), for pictures that go to files."""
    try:
        import matplotlib
    except ImportError:
        sys.exit("this Python has no matplotlib to draw with (Debian: /usr/bin/python3, "
                 "python3-matplotlib)")
    matplotlib.use("Agg")
    import matplotlib.pyplot as plt
    sys.path.insert(0, str(PACKAGE))
    from ra2d import style
    matplotlib.rcParams.update(style.RC)
    return plt, style
