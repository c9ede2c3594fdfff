# SPDX-License-Identifier: BSD-3-Clause
"""What the pictures of the charts have in common. Ends with status 9 when there is no matplotlib."""
import csv
import sys

try:
    import matplotlib
except ImportError:
    sys.exit(9)
matplotlib.use("Agg")
# text stays text; and the same picture has the same bytes
matplotlib.rcParams.update({"svg.fonttype": "none", "pdf.fonttype": 42, "svg.hashsalt": "ra2d"})

# (time.scheme, time.contact_force): name, colour
NAMES = {
    ("explicit-euler", "old"): ("explicit Euler", "#d62728"),
    ("midpoint", "old"): ("midpoint", "#2ca02c"),
    ("backward-euler", "old"): ("backward Euler, old force", "#1f77b4"),
    ("backward-euler", "new"): ("backward Euler, new force", "#17becf"),
    ("heun", "old"): ("Heun", "#ff7f0e"),
    ("rk4", "old"): ("RK4", "#9467bd"),
    ("rk8", "old"): ("RK8", "#8c564b"),
    ("exact", "old"): ("exact, force held", "#7f7f7f"),
    ("adaptive", "continuous"): ("adaptive", "black"),
}


def read(file):
    """The rows of a file of comma-separated values, without the # lines."""
    with open(file, newline="") as lines:
        return list(csv.DictReader(line for line in lines if not line.startswith("#")))


def read_context(file):
    """What the # lines say: {what: which}."""
    with open(file) as lines:
        return dict(line[2:].rstrip("\n").split(": ", 1) for line in lines if line.startswith("# "))


def literal(text):
    """A text from outside, which is no formula to matplotlib."""
    return text.replace("$", r"\$")


def save(figure, picture, kind):
    """Into the file itself, which the program has made and names when it is complete. `kind`: png, svg or pdf."""
    dates = {"svg": {"Date": None}, "pdf": {"CreationDate": None}}.get(kind)
    try:
        with open(picture, "wb") as out:
            figure.savefig(out, format=kind, dpi=130, metadata=dates)
    except OSError as fault:
        sys.exit(f"{picture}: {fault.strerror}")


def draw_tables(main):
    """Runs main with the words of the command line. Tables may come from anywhere."""
    try:
        main(*sys.argv[1:])
    except (KeyError, ValueError, IndexError, UnicodeError) as fault:
        sys.exit(f"a table of the chart has something else than 'ra2d chart' writes: {fault!r}")
