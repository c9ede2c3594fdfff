#!/usr/bin/env python3
# SPDX-License-Identifier: BSD-3-Clause
"""Whether two builds of ra2d give the same answers, bit for bit.

    same_bits.py OLD_PROGRAM NEW_PROGRAM [--keep FOLDER] [--only NAME]

Both programs run some hundred scenes of every scheme, law, support, surface and way to end. Every
dataset of their result files is compared, and for runs that fail the exit status and the message.
What a run cost (time, nodes evaluated) and where it was built and ran may differ. Both programs
must be built for the same instruction set by the same compiler: between others nothing is promised
(CONTRIBUTING.md).

The scenes are drawn here, by a generator with a seed: they are the same at every call. --only takes
the scenes whose name holds NAME. --keep leaves scenes and results in FOLDER:
FOLDER/NAME/scene.toml, old.h5, new.h5.

The status is 1 if anything differs, or if the scenes do not show what they are there for: a scene
that ends in another way than it is meant to, that has fewer shocks than it is meant to, or fewer
than 60 scenes with contact.
"""
import argparse
import collections
import concurrent.futures
import itertools
import math
import pathlib
import random
import shutil
import subprocess
import sys
import tempfile
import time
import tomllib

import h5py
import numpy as np

PATIENCE = 60  # s, for one run
LEAST_WITH_CONTACT = 60
LEAST_SHOCKS = 5  # of a scene, unless it says otherwise
ROOT = pathlib.Path(__file__).resolve().parents[2]

# ---- comparing two results
# -------------------------------------------------------------------------------------

COST = {f"summary/{name}" for name in ("nodes_evaluated", "step_seconds", "wall_seconds")}
# attributes of a file; the words of warnings are the program's
PROVENANCE = {"commit", "version", "started", "wall_seconds", "threads", "backend", "key", "format",
              "warnings"}
# which files of older programs lack
ADDED = {"shocks/shock", "summary/lv_low", "summary/lv_high", "summary/shock_rate_low",
         "summary/shock_rate_high",
         # of areal scenes
         "shocks/y", "probes/probe", "probes/y", "slider_probes/probe", "slider_probes/y",
         *(f"{body}/{name}" for body in ("resonator", "slider")
           for name in ("position", "y", "shape_x", "shape_y"))}
LINEAR = 'faces = "linear"\n'  # a line which scenes of older results lack
RENAMED = {"shocks/serial": "shocks/shock"}  # since format 3
# doubles in format 2, integers in 3
COUNTS = {"shocks/shock", "contact/nodes", "resonator/mode", "slider/mode"}


def read(path):
    """All datasets of a result file, by name, and its attributes. The time, which stands in many
    groups, once."""
    found = {}

    def walk(group):
        for item in group.values():
            if isinstance(item, h5py.Group):
                walk(item)
            elif item.name == "/time" or item != group.file.get("time"):
                name = RENAMED.get(item.name[1:], item.name[1:])
                found[name] = item[()].astype(np.float64) if name in COUNTS else item[()]

    with h5py.File(path, "r") as file:
        walk(file)
        return found, dict(file.attrs)


def ulps_between(a, b):
    """How many doubles further b is than a; None where one is no number."""
    if math.isnan(a) or math.isnan(b):
        return None

    def rank(x):
        bits = int(np.float64(x).view(np.int64))
        return bits if bits >= 0 else -(bits & 0x7FFF_FFFF_FFFF_FFFF)

    return abs(rank(b) - rank(a))


def difference_of(a, b):
    """Two doubles of different bits, and by how much they differ."""
    a, b = float(a), float(b)
    text = f"{a!r} -> {b!r}"
    ulps = ulps_between(a, b)
    if ulps is None:
        return text
    if ulps == 0:
        return f"{text}: the sign of zero"
    scale = max(abs(a), abs(b))
    relative = f", relative {abs(b - a) / scale:.2g}" if math.isfinite(scale) else ""
    return (f"{text}{relative}, {ulps if ulps < 1e6 else f'{ulps:.2g}'} "
            f"ulp{'s' if ulps != 1 else ''}")


def difference_of_texts(a, b):
    """The first lines that differ."""
    for number, (old, new) in enumerate(itertools.zip_longest(a.split("\n"), b.split("\n")), 1):
        if old != new:
            return (f"line {number}: " if "\n" in a else "") + f"{old!r} -> {new!r}"


class Difference:
    """One dataset that differs: where first, and how much of it."""

    def __init__(self, name, text, when=math.inf):
        self.name, self.text, self.when = name, text, when  # when: s, for the order

    def __str__(self):
        return f"{self.name}: {self.text}"


SAMPLED = ("time", "displacement", "velocity", "force", "nodes", "kinetic", "elastic", "contact",
           "damping_loss",
           "sliding_work", "load_work")


def place_of(name, index, data):
    """What the place of a number in a dataset is called, and its time in s; -inf: it was there
    before the run."""
    group, _, leaf = name.rpartition("/")
    if group == "shocks":
        start = float(data["shocks/start"][index[0]])
        return f"shock {index[0]}, which starts at t = {start:.9g} s", start
    if leaf in SAMPLED:
        at = float(data["time"][index[0]])
        column = f", {'probe' if 'probes' in group else 'mode'} {index[1]}" if len(
            index) > 1 else ""
        return f"sample {index[0]}, t = {at:.9g} s{column}", at
    if leaf == "shape":
        return f"mode {index[0]}, place {index[1]}", -math.inf
    return f"{'mode' if leaf in ('frequency', 'mean_square') else 'row'} {index[0]}", -math.inf


def compare_dataset(name, old, new):
    """A Difference, or None; `old` and `new` are all datasets of the two files."""
    a, b = np.asarray(old[name]), np.asarray(new[name])
    if a.shape == b.shape and a.dtype == b.dtype and a.tobytes() == b.tobytes():
        return None
    if a.dtype != np.float64 or b.dtype != np.float64 or a.shape[1:] != b.shape[1:]:
        return Difference(name,
                          f"{a.dtype} of shape {a.shape} -> {b.dtype} of shape {b.shape}",
                          -math.inf)
    if a.ndim == 0:
        return Difference(name, difference_of(a, b))
    length = "" if len(a) == len(b) else f"{len(a)} -> {len(b)} rows; "
    rows = min(len(a), len(b))
    differs = np.ascontiguousarray(a[:rows]).view(np.int64) != np.ascontiguousarray(
        b[:rows]).view(np.int64)
    if not differs.any():
        longer, data = (a, old) if len(a) > len(b) else (b, new)
        where, when = place_of(name, (rows,) + (0,) * (longer.ndim - 1), data)
        return Difference(name, f"{length}the same up to there ({where})", when)
    first = tuple(int(i) for i in np.argwhere(differs)[0])
    where, when = place_of(name, first, old)
    share = f"{np.count_nonzero(differs)} of {differs.size} values differ"
    if differs.ndim > 1:
        share += f", in {np.count_nonzero(differs.any(axis=1))} of {rows} rows"
    return Difference(name, f"{length}{where}: {difference_of(a[first], b[first])}; {share}", when)


def compare_results(old_path, new_path, attributes=True):
    """The differences of two result files, the earliest in simulated time first."""
    (old, old_attributes), (new, new_attributes) = read(old_path), read(new_path)
    found = [Difference(name, "only in the old result" if name in old
                        else "only in the new result", -math.inf)
             for name in sorted((old.keys() ^ new.keys()) - ADDED)]
    for name in old:
        if name in new and name not in COST:
            found.append(compare_dataset(name, old, new))
    if attributes:
        for name in sorted((old_attributes.keys() | new_attributes.keys()) - PROVENANCE):
            a, b = (str(of.get(name, "none")).replace(LINEAR, "")
                    for of in (old_attributes, new_attributes))
            if a != b:
                found.append(Difference(f"attribute {name}", difference_of_texts(a, b)))
    return sorted((each for each in found if each), key=lambda each: each.when)


# ---- scenes
# --------------------------------------------------------------------------------------------------

METHODS = [(scheme, law, "old") for scheme in ("explicit-euler", "midpoint", "backward-euler",
                                               "heun", "rk4", "rk8",
                                               "exact", "adaptive")
           for law in ("penalty", "multiplier")
           if not (law == "multiplier" and scheme in ("explicit-euler", "adaptive"))]
METHODS.insert(3, ("backward-euler", "penalty", "new"))
# modes, so that each compiled number of mode packs is marched
WIDTHS = [(1, 8), (9, 24), (25, 64), (65, 150)]
SURFACES = [("gaussian", "gaussian"), ("peaks", "peaks"), ("file", "gaussian"),
            ("gaussian", "peaks"),
            ("peaks", "file"), ("flat", "gaussian"), ("gaussian", "flat"), ("gaussian", "gaussian"),
            ("flat", "peaks"), ("flat", "flat")]  # resonator, slider

YOUNG, DENSITY = 210e9, 7800.0
DEFLECTION = math.sqrt(YOUNG / 12 / DENSITY)  # m/s: omega = BEND thickness k^2


class Scene:
    """A text, the files beside it, and what is expected of it."""

    def __init__(self, name, tables=None, *, files=None, ends="complete", shocks=LEAST_SHOCKS,
                 path=None, settings=()):
        self.name, self.tables, self.files, self.ends, self.shocks = (name, tables, files or {},
                                                                      ends, shocks)
        self.path, self.settings = path, settings  # of a scene that comes with the program

    def text(self):
        lines = []
        for section, keys in self.tables.items():
            lines.append(f"[{section}]")
            lines += [f"{key} = {toml(value)}" for key, value in keys.items() if value is not None]
        return "\n".join(lines) + "\n"


def toml(value):
    if isinstance(value, bool):
        return "true" if value else "false"
    if isinstance(value, str):
        return f'"{value}"'
    if isinstance(value, float):
        return repr(value)
    if isinstance(value, dict):
        return "{ " + ", ".join(f"{key} = {toml(each)}" for key, each in value.items()) + " }"
    if isinstance(value, (list, tuple)):
        return "[" + ", ".join(toml(each) for each in value) + "]"
    return str(value)


class Deck:
    """Deals its cards in a random order, each as often as the others."""

    def __init__(self, dice, cards):
        self.dice, self.cards, self.left = dice, list(cards), []

    def deal(self):
        if not self.left:
            self.left = self.dice.sample(self.cards, len(self.cards))
        return self.left.pop()


# scenes drawn again, so many times: what came before made few shocks, or ended in a way that was
# not meant
AGAIN = {
    "explicit-euler-penalty-8": 1, "rk4-multiplier-8": 1, "explicit-euler-penalty-24": 1,
    "backward-euler-penalty-64": 1, "exact-multiplier-64": 1, "midpoint-penalty-150": 1,
    "explicit-euler-penalty-64-b": 1, "tolerance-1e-9": 1, "explicit-euler-penalty-150-b": 1,
    "exact-multiplier-8": 2,
    "midpoint-penalty-8-b": 2, "rk8-penalty-24-b": 2, "backward-euler-multiplier-8-b": 3,
    "backward-euler-new-penalty-150": 4}


class Drawer:
    """Draws scenes: a thin plate and a small slider of one to 150 modes, rough faces that strike
    each other."""

    def __init__(self):
        # deals what there are a few kinds of; numbers are drawn for each scene alone
        self.decks = random.Random(2012)
        cards = {
            "resonator": ["pinned", "pinned", "pinned", "free"],
            "slider": ["free", "free", "pinned", "rigid"],
            "surfaces": SURFACES, "nodes": ["candidates", "candidates", "all"],
            "load": ["weight", "newton"],
            "gap": ["touching", "number"], "initial": ["static", "rest", None],
            "forces": [0, 0, 1, 2],
            "pace": ["rest", "slow", "usual", "usual", "usual", "fast"],
            "rate": ["step", "odd", "odd", "whole"],
            "from": [0, 0, 1], "probes": [0, 0, 1, 3], "slider_probes": [0, 0, 0, 1, 2]}
        self.cards = {key: Deck(self.decks, each) for key, each in cards.items()}

    def ratio(self, low, high):
        return low * (high / low) ** self.dice.random()

    def uniform(self, low, high):
        return low + (high - low) * self.dice.random()

    def scene(self, name, method, modes, **fixed):
        """`modes`: from, to. `fixed` chooses what a deck would deal, and `tolerance`."""
        scheme, law, contact_force = method
        self.dice = dice = random.Random(f"{name} {AGAIN.get(name, 0)}")
        dealt = {key: deck.deal() for key, deck in self.cards.items()} | fixed
        below, above, faces, pace = (dealt[key]
                                     for key in ("resonator", "slider", "surfaces", "pace"))
        # what has landed would stay
        if faces[0] == "flat" and (law == "multiplier" or scheme == "exact"):
            faces = ("peaks", faces[1])
        # all nodes at once: slow
        if faces == ("flat", "flat") and (scheme == "adaptive" or contact_force == "new"):
            faces = ("flat", "peaks")
        flat, files = "flat" in faces, {}

        # sizes, so that the fastest modes of both bodies are about as fast
        modes = dice.randint(*modes)
        rigid_below, rigid_above = 2 * (below == "free"), 2 * (above == "free")
        elastic_above = 0
        if above != "rigid":
            elastic_above = dice.randint(above == "pinned",
                                         max(above == "pinned", min(12, modes // 5)))
        elastic_below = max(1, modes - rigid_below - rigid_above - elastic_above)
        spacing = self.ratio(3e-5, 5e-5)
        length2 = 0.05 if modes <= 24 else 0.08 if modes <= 64 else 0.12
        length1 = self.ratio(0.004, 0.008)
        wave2 = (elastic_below + 0.5 * (below == "free")) * math.pi / length2
        wave1 = max(elastic_above + 0.5 * (above == "free"), 0.5) * math.pi / length1
        omega = 2 * math.pi * self.ratio(5e4, 3e5)
        thick2 = min(max(omega / DEFLECTION / wave2**2, length2 / 1000), length2 / 30)
        thick1 = min(max(0.7 * omega / DEFLECTION / wave1**2, length1 / 100), length1)
        omega = DEFLECTION * max(thick2 * wave2**2, thick1 * wave1**2 if elastic_above else 0)
        width2, width1 = 0.02, 0.01
        damping = self.ratio(*{"explicit-euler": (0.2, 0.6),
                               "exact": (0.05, 0.2)}.get(scheme, (0.005, 0.1)))

        # the spring of a node against the inertia of both bodies, where they yield most
        mass2, mass1 = DENSITY * thick2 * width2 * length2, DENSITY * thick1 * width1 * length1
        yields = (4 * elastic_below + 4 if below == "free" else 2 * elastic_below) / mass2
        if above != "rigid":
            yields += (4 * elastic_above + 4 if above == "free" else 2 * elastic_above) / mass1
        omega_c = omega * self.ratio(0.3, 2)
        spring = omega_c**2 / yields
        fastest = max(omega, omega_c) if law == "penalty" else omega
        step = {"explicit-euler": min(0.6 * damping / omega,
                                      (0.03 if below == "pinned" else 0.004) / omega_c),
                "exact": min(0.1 / omega, 0.01 / omega_c), "heun": 0.15 / fastest,
                "rk4": 0.4 / fastest,
                "rk8": 0.5 / fastest}.get(scheme, 0.25 / fastest)
        if faces == ("flat", "flat") and law == "penalty":  # all nodes touch at once
            step /= 6
        step = float(f"{step:.6g}")  # so that 1/step is the rate of every step

        # how long: by what a step costs
        stages = {"heun": 2, "rk4": 4, "rk8": 11}.get(scheme, 1)
        looked = length1 / spacing if dealt["nodes"] == "all" or flat else 30
        cost = stages * (20e-9
                         + 1e-10 * modes * (3 + 0.5 * looked)) * (1.5 if law == "multiplier" else 1)
        steps = int(min(max(0.1 / cost, 6000), 60_000))
        if scheme == "adaptive":
            steps = int(20_000 / (1 + modes / 20))
        room = 0.98 * (length2 - length1)
        travel = {"rest": 0, "slow": 0.1 * room, "usual": self.uniform(0.4, 0.95) * room,
                  "fast": 0.95 * room}[pace]
        if pace == "fast" and scheme != "adaptive":  # a node in some steps, or in each
            steps = int(travel / spacing / self.ratio(0.1, 1.5))
        duration = steps * step
        start = self.uniform(0, room - travel)

        # faces and what presses them together
        rq = self.ratio(4e-7, 2e-6)
        resonator = {"support": below, "length": length2, "thickness": thick2, "width": width2,
                     "young": YOUNG,
                     "density": DENSITY, "damping": damping, "modes": elastic_below,
                     "surface": self.face("resonator", faces[0], rq, length2, files)}
        slider = {"support": above, "length": length1, "thickness": thick1, "width": width1,
                  "young": YOUNG,
                  "density": DENSITY, "damping": damping, "modes": elastic_above,
                  "surface": self.face("slider", faces[1], rq, length1, files)}
        if above == "rigid":
            for key in ("thickness", "young", "density", "damping", "modes"):
                del slider[key]
        deflection2 = YOUNG * width2 * thick2**3 / 12 / length2**3
        deflection1 = YOUNG * width1 * thick1**3 / 12 / length1**3
        # m/s^2: so many bounces as high as the roughness
        fall = 8 * rq * (self.ratio(30, 100) / duration)**2
        if above == "free":
            press = min(mass1 * fall, 0.05 * spring * rq)
            slider["load"] = "weight" if dealt["load"] == "weight" and fall < 100 else press
        elif above == "pinned" and dealt["load"] == "newton":
            slider["load"] = 384 / 5 * deflection1 * rq * self.ratio(0.2, 1)
        forces = dealt["forces"]
        if flat or pace == "rest":
            forces = max(forces, 2)  # nothing else brings the faces together and apart
        if below == "free" or modes > 64:  # so thin that they alone bring it back
            forces = 2
            force = min(mass2 * fall, 0.05 * spring * rq)
            resonator["moving_force"] = [{"force": force / 2, "speed": 0.2 * length2 / duration,
                                          "start": at * length2}
                                         for at in (0.2, 0.6)]
        elif forces:  # one after the other
            resonator["moving_force"] = [
                {"force": 48 * deflection2 * rq * self.ratio(1, 5),
                 "speed": length2 / duration * forces * self.uniform(0.8, 1.3),
                 "start": -i * length2}
                for i in range(forces)]

        initial = "rest" if below == "free" or flat or pace == "rest" else dealt["initial"]
        gap = None  # "touching"
        highest = rq * sum({"flat": 0, "peaks": 3, "gaussian": 3.2, "file": 2.5}[face]
                           for face in faces)
        if initial == "rest" and (flat
                                  or pace
                                  == "rest") and above == "free" and slider["load"] != "weight":
            gap = 1.02 * highest + 1e-3 * rq  # strikes at once
        elif dealt["gap"] == "number" and above != "free" and (law == "penalty"
                                                               or initial != "rest"):
            gap = rq * sum({"flat": 0, "peaks": 2.85, "gaussian": 1.3, "file": 1.2}[face]
                           for face in faces)
        rate = {"step": 1, "whole": 1 / dice.randint(2, 30),
                "odd": 1 / self.uniform(1, 40)}[dealt["rate"]] / step
        most_samples = 400_000 / modes
        if rate * duration > most_samples:
            rate = 1 / step / math.ceil(duration / step / most_samples)
        tables = {
            "scene": {"name": name, "duration": duration, "speed": travel / duration,
                      "start": start, "gap": gap,
                      "spacing": spacing, "faces": "linear", "initial": initial},
            "resonator": resonator, "slider": slider,
            "contact": {"law": law, "stiffness": spring / spacing / width1},
            "time": {"scheme": scheme, "contact_force": contact_force, "step": step,
                     "nodes": dealt["nodes"]},
            "output": {"rate": rate,
                       "probes": [self.uniform(0, length2) for _ in range(dealt["probes"])],
                       "slider_probes": [self.uniform(0, length1)
                                         for _ in range(dealt["slider_probes"])],
                       "from": dealt["from"] * self.uniform(0.05, 0.6) * duration},
        }
        if scheme == "adaptive":
            tables["time"] = {"scheme": scheme, "tolerance": fixed.get("tolerance", 1e-8),
                              "nodes": dealt["nodes"]}
        return Scene(name, tables, files=files)

    def face(self, body, kind, rq, length, files):
        if kind == "gaussian":
            wave = {"rsm": self.ratio(2.1e-4, 4e-4)} if self.dice.random() < 0.5 else \
                {"correlation_length": self.ratio(2.01e-4, 2.5e-4)}
            return {"kind": kind, "rq": rq, **wave, "seed": self.dice.randrange(1000)}
        if kind == "peaks":
            count = max(1, round(length / 1e-3))
            return {"kind": kind, "peaks": [
                {"at": (i + self.uniform(0.2, 0.8)) * length / count,
                 "height": 3 * rq * self.uniform(0.95, 1.0),
                 "half_width": self.ratio(1e-4, 4e-4)} for i in range(count)]}
        if kind == "file":
            files[f"{body}.csv"] = self.profile(rq, length)
            return {"kind": kind, "path": f"{body}.csv"}
        return {"kind": kind}

    def profile(self, rq, length):
        points = round(length / 4.7e-5) + 1
        x = [length * i / (points - 1) for i in range(points)]
        waves = [(2 * math.pi / self.ratio(3e-4, 1.5e-3), self.uniform(0, 2 * math.pi))
                 for _ in range(30)]
        scale = rq * math.sqrt(2 / len(waves))
        lines = ["# drawn by same_bits.py", "x,z"]
        lines += [f"{at:.12g},{scale * sum(math.sin(k * at + phase) for k, phase in waves):.9g}"
                  for at in x]
        return "\n".join(lines) + "\n"


def drawn_scenes():
    """Every method with every number of mode packs, twice, and then what is to be tried beside
    that."""
    drawer = Drawer()
    for turn in ("", "-b"):
        for width in WIDTHS:
            for scheme, law, contact_force in METHODS:
                new = "-new" if contact_force == "new" else ""
                yield drawer.scene(f"{scheme}{new}-{law}-{width[1]}{turn}",
                                   (scheme, law, contact_force), width)
    for digits in range(4, 13):
        yield drawer.scene(f"tolerance-1e-{digits}", ("adaptive", "penalty", "old"), (4, 40),
                           tolerance=10.0**-digits,
                           pace="usual")
    for below in ("pinned", "free"):
        for above in ("free", "pinned", "rigid"):
            for law in ("penalty", "multiplier"):
                yield drawer.scene(f"{above}-on-{below}-{law}", ("backward-euler", law, "old"),
                                   (6, 30), slider=above,
                                   resonator=below, surfaces=("gaussian", "gaussian"), pace="usual")


def areal_scenes():
    """A small block on the plate of scenes/areal.toml: by every scheme and law, with all nodes,
    held and free."""
    small = ["scene.spacing=1e-4", "slider.length=5e-3", "slider.width=4e-3",
             "resonator.max_frequency=8e3",
             "contact.stiffness=1e14", "output.rate=1e4"]
    free = [*small, "slider.load=0.5"]
    held = [*small, "slider.support=rigid", "slider.load=0", "scene.gap=15e-6",
            "scene.initial=rest"]
    for scheme in ("midpoint", "backward-euler", "heun", "rk4", "rk8", "exact"):
        yield "areal", 3e-3, f"time.scheme={scheme}", "time.step=2e-7", *free
    for settings in (("time.scheme=explicit-euler", "time.step=1e-8"),
                     ("time.scheme=backward-euler", "time.contact_force=new", "time.step=5e-7"),
                     ("time.scheme=midpoint", "contact.law=multiplier", "time.step=2e-7"),
                     ("time.scheme=backward-euler", "contact.law=multiplier", "time.step=5e-7"),
                     (), ("time.tolerance=1e-9",), ("time.nodes=all",), ("scene.initial=rest",),
                     ("time.scheme=rk4", "time.step=2e-7", "time.nodes=all"),
                     ("scene.side=0.01", "scene.spacing_y=1.5e-4")):
        yield "areal", 3e-3, *free, *settings
    for settings in ((), ("time.nodes=all",), ("time.scheme=midpoint", "time.step=2e-7")):
        yield "areal", 3e-3, *held, *settings
    yield "areal", 5e-3, *free, "scene.spacing=2e-5"


def scenes_of_many_modes():
    """All 174 modes of scenes/areal.toml: nodes in squares, whose rows are no multiple of 16, and
    nodes by themselves, in short steps and in long ones."""
    block = ["scene.faces=linear", "slider.thickness=5e-4", "slider.length=8e-4",
             "resonator.surface.rq=1e-6", "slider.surface.rq=1e-6",
             "resonator.surface.rsm=1e-4", "slider.surface.rsm=1e-4", "slider.load=0.05",
             "contact.stiffness=1e15", "output.rate=1e4"]
    by = [("gautschi", 5e-7), ("midpoint", 1e-7), ("rk4", 1e-7), ("rk8", 2e-7), ("heun", 5e-9)]
    for rows, (scheme, step) in zip((17, 18, 33, 19, 17), by):
        width = f"slider.width={rows * 8e-6}"
        yield ("areal", 4e-3 if step > 1e-8 else 4e-4, *block, "scene.spacing=8e-6", width,
               f"time.scheme={scheme}", f"time.step={step}")
    for spacing in (16e-6, 25e-6):
        wave = [f"{body}.surface.rsm={8 * spacing}" for body in ("resonator", "slider")]
        for scheme, step in (("gautschi", 1e-6), ("gautschi", 1e-7), ("rk8", 1e-6),
                             ("midpoint", 5e-7)):
            yield ("areal", 4e-3, *block, f"scene.spacing={spacing}", *wave, "slider.width=5e-4",
                   "contact.stiffness=1e14", f"time.scheme={scheme}", f"time.step={step}")


def smooth_scenes():
    """Between smooth faces: all other scenes here have linear ones."""
    smooth, adaptive = "scene.faces=smooth", "time.scheme=adaptive"
    for spacing in ("8e-6", "32e-6", "64e-6"):
        for tolerance in ("1e-4", "1e-6", "1e-8"):
            yield ("dang2012", 0.03, smooth, adaptive, f"scene.spacing={spacing}",
                   f"time.tolerance={tolerance}")
    for name, duration in (("dang2012", 0.01), ("dang2012-pinned", 0.05)):
        for settings in (("time.scheme=midpoint", "time.step=1e-7"),
                         ("time.scheme=rk4", "time.step=1e-7", "time.nodes=all"),
                         ("time.scheme=backward-euler", "contact.law=multiplier",
                          "time.step=1e-7")):
            yield name, duration, smooth, "scene.spacing=32e-6", *settings
    yield "dang2012", 0.01, smooth, adaptive, "scene.spacing=32e-6", "time.nodes=all"
    yield "dang2012-pinned", 0.05, smooth, adaptive, "scene.spacing=32e-6"
    areal = (smooth, "scene.spacing=1e-4", "scene.spacing_y=5e-5", "slider.length=5e-3",
             "slider.width=4e-3", "contact.stiffness=1e15", "output.rate=1e4", "slider.load=0.5")
    yield "areal", 3e-3, *areal
    yield "areal", 3e-3, *areal, "resonator.max_frequency=2e3"
    yield "areal", 2e-3, *areal, "time.scheme=midpoint", "time.step=2e-7"


def scenes_of_the_program():
    """Those of scenes/, shortened, and as other schemes and laws take them."""
    flat = ["slider.surface.kind=flat", "resonator.surface.kind=flat"]
    listed = [
        ("dang2012", 0.003, "time.scheme=backward-euler"),
        ("dang2012", 0.02, "time.scheme=adaptive"),
        ("dang2012", 0.01, "time.scheme=adaptive", "time.tolerance=1e-4", "time.nodes=all"),
        ("dang2012", 0.005, "time.scheme=rk8", "time.step=1e-7"),
        ("dang2012", 0.005, "time.scheme=gautschi", "time.step=1e-7"),
        ("dang2012-pinned", 0.02, "time.scheme=gautschi", "time.step=5e-8"),
        ("dang2012", 0.004, "contact.law=multiplier", "time.step=2e-8"),
        ("dang2012", 0.02, "time.contact_force=new", "time.step=1e-7"),
        ("dang2012-pinned", 0.02, "time.scheme=midpoint", "time.step=5e-8"),
        ("dang2012-pinned", 0.05, "time.scheme=adaptive"),
        ("dang2012-pinned", 0.02, "contact.law=multiplier", "time.scheme=midpoint",
         "time.step=1e-7"),
        ("drop", 0.01),
        ("drop", 0.01, "time.scheme=heun", "time.nodes=all"),
        ("drop", 0.02, "time.scheme=adaptive"),
        ("drop", 0.01, "resonator.support=rigid", 2),
        ("peaks", 0.015, "scene.start=0.104", 2),
        ("peaks", 0.04, "scene.start=0.104", "time.scheme=adaptive", 2),
        # a thousand nodes touch at once, more than there is room for at first
        ("dang2012", 2e-4, "time.scheme=adaptive", "slider.load=5", "scene.gap=1e-9",
         "scene.spacing=2e-5",
         "scene.initial=rest", *flat),
        ("dang2012", 2e-3, "time.scheme=adaptive", "slider.load=5", *flat, 2),
        ("moving-force", 0.005, 0),
        ("moving-force", 0.015, "time.scheme=adaptive", 0),
        *areal_scenes(),
        *scenes_of_many_modes(),
        *smooth_scenes(),
    ]
    for number, (name, duration, *settings) in enumerate(listed, 1):
        shocks = settings.pop() if settings and isinstance(settings[-1], int) else LEAST_SHOCKS
        yield Scene(f"{name}-{number}", path=ROOT / "scenes" / f"{name}.toml", shocks=shocks,
                    settings=[f"scene.duration={duration}", *settings])


# A rigid slider's peak comes to the resonator's held end, where no mode moves.
BLOCKED = {
    "scene": {"duration": 1e-3, "speed": 2.0, "start": 0.048, "gap": 5e-6, "spacing": 1e-4,
              "faces": "linear", "initial": "rest"},
    "resonator": {"support": "pinned", "length": 0.06, "thickness": 1e-3, "width": 0.02,
                  "young": YOUNG,
                  "density": DENSITY, "damping": 0.02, "modes": 1,
                  "surface": {"kind": "peaks",
                              "peaks": [{"at": 0.06, "height": 5e-6, "half_width": 1e-3}]}},
    "slider": {"support": "rigid", "length": 0.01, "width": 0.02,
               "surface": {"kind": "peaks",
                           "peaks": [{"at": 0.01, "height": 5e-6, "half_width": 5e-4}]}},
    "contact": {"law": "multiplier"},
    "time": {"step": 1e-5},
    "output": {"rate": 1e4},
}


def scenes_that_fail():
    """One or more for each way to end that is not the usual one, but for two that no scene comes to
    here: out of memory, and too fast for the clock. They fail soon: a file holds what the launches
    of the march had handed out by then, and only the first has always the same length."""
    yield Scene("blocked", BLOCKED, ends="blocked", shocks=0)
    listed = [
        ("unstable", "drop", "time.force=true", "time.step=1e-4", "output.rate=1e3"),
        ("unstable", "dang2012", "time.force=true", "time.scheme=explicit-euler", "time.step=1e-3",
         "output.rate=1e3"),
        ("unstable", "moving-force", "time.force=true", "time.scheme=heun", "time.step=1e-4",
         "output.rate=1e4"),
        ("not finite", "dang2012", "time.force=true", "time.scheme=explicit-euler",
         "time.step=1e-3", "output.rate=1"),
        ("not finite", "dang2012", "time.force=true", "time.scheme=rk4", "time.step=1e-3",
         "output.rate=1"),
        ("not finite", "moving-force", "time.force=true", "time.scheme=midpoint", "time.step=1e-4",
         "output.rate=70"),
        # beyond the limit of stability, and yet to the end
        ("complete", "dang2012-pinned", "time.force=true", "time.step=1e-6", "scene.duration=5e-3"),
        ("complete", "dang2012", "time.force=true", "time.scheme=rk4", "time.step=3e-6",
         "scene.duration=5e-3"),
        ("refused", "drop", "time.step=1e-4", "output.rate=1e3"),
        ("refused", "drop", "time.scheme=explicit-euler"),
        ("refused", "drop", "contact.law=multiplier", "scene.gap=5e-6"),
        ("refused", "drop", "contact.law=multiplier", "time.scheme=adaptive"),
        ("refused", "drop", "scene.spacing=1e-2"),
        ("refused", "dang2012", "slider.load=-1", "scene.duration=1e-3"),
        ("refused", "dang2012", "resonator.max_frequency=1e9", "scene.duration=10",
         "output.probes=[9]", "time.stp=1"),
        ("refused", "peaks", "slider.surface={ kind = 'file', path = 'not-there.csv' }"),
    ]
    for number, (ends, name, *settings) in enumerate(listed, 1):
        yield Scene(f"{ends.replace(' ', '-')}-{name}-{number}",
                    path=ROOT / "scenes" / f"{name}.toml",
                    settings=settings, ends=ends, shocks=LEAST_SHOCKS if ends == "complete" else 0)


def scenes():
    yield from drawn_scenes()
    yield from scenes_of_the_program()
    yield from scenes_that_fail()


# ---- running and comparing
# -------------------------------------------------------------------------------------

ENDINGS = {"unstable": "unstable: ", "not finite": "not finite: ",
           "blocked": "no motion of the kept modes",
           "crowded": "more nodes touch at once than there is memory for",
           "stalled": "the motion is too fast for"}


class Run:
    """What one program made of a scene."""

    def __init__(self, program, scene, folder, name):
        self.result = folder / f"{name}.h5"
        # the same names for both programs, so that their messages can be compared
        work = folder / name
        work.mkdir()
        words = [program, "run", str(scene.path or "../scene.toml"), "--quiet", "--threads", "1",
                 "-o", "result.h5"]
        for setting in scene.settings:
            words += ["--set", setting]
        try:
            done = subprocess.run(words, cwd=work, stdin=subprocess.DEVNULL, capture_output=True,
                                  timeout=PATIENCE)
            self.status, self.message = done.returncode, done.stderr.decode(
                errors="replace").strip()
        except subprocess.TimeoutExpired:
            self.status, self.message = None, f"it did not end within {PATIENCE} s"
        if (work / "result.h5").exists():
            (work / "result.h5").replace(self.result)
        shutil.rmtree(work)

    def ending(self):
        if self.status in (0, 2, 4):
            return "complete" if self.status == 0 else "refused"
        for name, text in ENDINGS.items():
            if self.status == 3 and text in self.message:
                return name
        return f"status {self.status}"


class Case:
    """A scene run by both programs: what differs, and what is wrong with the scene."""

    def __init__(self, scene, old_program, new_program, folder):
        self.scene, self.differences, self.faults = scene, [], []
        self.shocks, self.numbers, self.contact, self.kinds = 0, 0, False, {}
        folder.mkdir(parents=True, exist_ok=True)
        for name, text in scene.files.items():
            (folder / name).write_text(text)
        if scene.tables:
            (folder / "scene.toml").write_text(scene.text())
        old, new = Run(old_program, scene, folder, "old"), Run(new_program, scene, folder, "new")
        self.ending = old.ending()
        if self.ending != scene.ends:
            self.faults.append(
                f"is meant to end '{scene.ends}', and ends '{self.ending}': {old.message}")
        if old.status != new.status:
            self.differences.append(
                f"exit status: {old.status} -> {new.status}\n{old.message or '(no message)'}\n-> "
                                    f"{new.message or '(no message)'}")
        elif old.message != new.message:
            self.differences.append(f"message: {old.message}\n-> {new.message}")
        if old.result.exists() != new.result.exists():
            self.differences.append(
                f"the {'old' if old.result.exists() else 'new'} program alone wrote a result")
        elif old.result.exists():
            self.differences += compare_results(old.result, new.result)
        if old.result.exists():
            self.tally(*read(old.result))

    def tally(self, data, attributes):
        """What kind of scene it is, and whether there was something to compare."""
        self.shocks = len(data["shocks/start"])
        self.contact = self.shocks > 0 or bool(np.any(data["contact/nodes"] > 0))
        self.numbers = sum(values.size for values in data.values())
        self.kinds = kinds_of(tomllib.loads(attributes["scene"]),
                              len(data["resonator/mode"]) + len(data["slider/mode"]))
        if self.shocks < self.scene.shocks:
            self.faults.append(
                f"is meant to have {self.scene.shocks} shocks, and has {self.shocks}")


def kinds_of(options, modes):
    """What the scenes differ in, read from a result's own scene."""
    clock, law, output = options["time"], options["contact"]["law"], options["output"]
    body, slider = options["resonator"], options["slider"]
    adaptive = clock["scheme"] == "adaptive"
    steps = 0 if adaptive else 1 / output["rate"] / clock["step"]  # from sample to sample
    implicit = (clock["scheme"], law, clock["contact_force"]) == ("backward-euler",
                                                                  "penalty", "new")
    return {
        "scheme": clock["scheme"] + (" (new)" if implicit else ""),
        "law": law,
        "nodes": clock["nodes"],
        "modes": next(f"up to {most}" for most in (8, 24, 64, 256) if modes <= most),
        "tolerance": f"{clock['tolerance']:.0e}" if adaptive else None,
        "resonator": body["support"],
        "slider": slider["support"],
        "faces": f"{body['surface']['kind']}/{slider['surface']['kind']}",
        "moving forces": len(body.get("moving_force", [])),
        "slides": "yes" if options["scene"]["speed"] > 0 else "no",
        "gap": "touching" if options["scene"]["gap"] == "touching" else "a number",
        "load": None if slider["support"] == "rigid" else
                "weight" if slider["load"] == "weight" else "none" if slider["load"] == 0 else "N",
        "initial": options["scene"]["initial"],
        "counted from": "0" if output["from"] == 0 else "later",
        "samples": None if adaptive else "each step" if round(steps, 6) == 1 else
                   "whole steps" if abs(steps - round(steps)) < 1e-6 else "between steps",
        "probes": "with" if output["probes"] or output["slider_probes"] else "without",
    }


WANTED = {  # each of these in a scene with contact
    "scheme": ["explicit-euler", "midpoint", "backward-euler", "backward-euler (new)", "heun",
               "rk4", "rk8", "exact", "gautschi", "adaptive"],
    "law": ["penalty", "multiplier"], "nodes": ["candidates", "all"],
    "modes": ["up to 8", "up to 24", "up to 64", "up to 256"],
    "tolerance": [f"1e-{digits:02}" for digits in range(4, 13)],
    "resonator": ["pinned", "free", "rigid"], "slider": ["pinned", "free", "rigid"],
    "faces": sorted({"/".join(pair) for pair in SURFACES}), "moving forces": [0, 1, 2],
    "slides": ["yes", "no"],
    "gap": ["touching", "a number"], "load": ["weight", "N", "none"], "initial": ["static", "rest"],
    "counted from": ["0", "later"], "samples": ["each step", "whole steps", "between steps"],
    "probes": ["with", "without"]}


def summary(cases):
    """A table of what was tried, and what is missing in it."""
    touching = [case for case in cases if case.contact]
    lines = [("ends", collections.Counter(case.ending for case in cases))]
    missing = []
    for kind, wanted in WANTED.items():
        found = collections.Counter(case.kinds[kind] for case in touching
                                    if case.kinds.get(kind) is not None)
        lines.append((kind, found))
        missing += [f"no scene with contact has {kind} = {value}" for value in wanted
                    if not found[value]]
    shocks = [case.shocks for case in touching]
    text = [f"{len(cases)} scenes, {len(touching)} with contact: {sum(shocks)} shocks, "
            f"{sum(n >= 10 for n in shocks)} scenes with 10 or more, "
            f"{sum(n >= 100 for n in shocks)} with 100 or more; "
            f"{sum(case.numbers for case in cases) / 1e6:.0f} million numbers"]
    for kind, found in lines:
        text.append(f"  {kind:14} " + ", ".join(f"{value} ({found[value]})"
                                                for value in sorted(found, key=str)))
    if len(touching) < LEAST_WITH_CONTACT:
        missing.append(f"only {len(touching)} scenes had contact, at least {LEAST_WITH_CONTACT} "
                       "are needed")
    return "\n".join(text), missing


def report(case, most):
    """What differs in one scene, the earliest first: so many datasets in full."""
    for fault in case.faults:
        print(f"THE SCENE  {case.scene.name} {fault}")
    if not case.differences:
        return
    print(f"DIFFERENT  {case.scene.name}")
    for difference in case.differences[:most]:
        print("    " + str(difference).replace("\n", "\n    "))
    if len(case.differences) > most:
        print("    and in " + ", ".join(getattr(each, "name", "the message")
                                        for each in case.differences[most:]))


def main():
    parser = argparse.ArgumentParser(description=__doc__,
                                     formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("old", metavar="OLD_PROGRAM")
    parser.add_argument("new", metavar="NEW_PROGRAM")
    parser.add_argument("--keep", metavar="FOLDER", type=pathlib.Path)
    parser.add_argument("--only", metavar="NAME", default="")
    options = parser.parse_args()
    old, new = (str(pathlib.Path(program).resolve()) for program in (options.old, options.new))
    for program in (old, new):
        if shutil.which(program) is None:
            sys.exit(f"{program} is no program")
    begun = time.monotonic()
    todo = [scene for scene in scenes() if options.only in scene.name]
    if not todo:
        sys.exit(f"no scene has {options.only!r} in its name")
    cases = []
    with tempfile.TemporaryDirectory(prefix="ra2d_bits_") as temporary:
        root = (options.keep or pathlib.Path(temporary)).resolve()
        with concurrent.futures.ThreadPoolExecutor(2) as pool:
            for case in pool.map(lambda scene: Case(scene, old, new, root / scene.name), todo):
                cases.append(case)
                report(case, 6 if sum(bool(each.differences) for each in cases) <= 10 else 1)
                if not options.keep:
                    shutil.rmtree(root / case.scene.name)
    text, missing = summary(cases)
    print(text)
    if not options.only:
        print("".join(f"MISSING    {each}\n" for each in missing), end="")
    different = sum(bool(case.differences) for case in cases)
    faulty = sum(bool(case.faults) for case in cases) + (0 if options.only else len(missing))
    print(f"{f'{different} SCENES DIFFER' if different else 'the same, bit for bit'}"
          f"{f'; {faulty} faults of the scenes themselves' if faulty else ''} "
          f"({time.monotonic() - begun:.0f} s)")
    return 1 if different or faulty else 0


if __name__ == "__main__":
    sys.exit(main())
