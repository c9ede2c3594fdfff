#!/usr/bin/env python3
# SPDX-License-Identifier: BSD-3-Clause
"""Attempts on ra2d: scenes, profiles and results at fault, kills, signals; and whether runs that
were cut off go on.

    hostile.py PROGRAM PART [--times N] [--share I/N] [--seed S] [--kills N]

PART: scenes, profiles, kills, signals, resumes, studies or readers. --times multiplies the random
cases; --share runs every Nth case from the Ith (from 1) on. Prints how many there were and how they
ended. The status is 1 if there were fewer than --kills kills of those that go on, if they went on
from checkpoints less than once a case, or if one of them

- ended with a status that is not promised, by a crash, or not within a minute (a study: five);
- ended with 0 and data that are not finite, in the file or in the report;
- harmed an earlier result: it stands byte for byte, or a whole new file does;
- left anything else behind, or changed an input;
- went on from a kill or a signal to other bits than a run that was left alone;
- printed more than 20 kB on stderr, or a control character;
- made anything of a result, a study's table or a kept result that was damaged or changed (part
  readers), or called it complete or whole.
"""
import argparse
import hashlib
import io
import math
import os
import random
import re
import resource
import select
import signal
import struct
import subprocess
import sys
import tempfile
import time
import tomllib
import zipfile
from collections import Counter
from pathlib import Path

import h5py
import numpy
import xxhash

sys.path.insert(0, str(Path(__file__).resolve().parents[1] / "host"))
import seal  # noqa: E402
import warm_python  # noqa: E402

EARLIER = b"an earlier result\n"
RUN, FORCE = ["run", "s.toml", "-o", "out.h5"], ["--force"]  # which alone replaces what is there
# of a run that was cut off
BESIDE_OUTPUT = ("out.h5.parts", "out.h5.checkpoint", "out.h5.checkpoint.previous")
MEMORY = 4 << 30  # bytes, of each process
PATIENCE = 60.0   # s
STUDY_PATIENCE = 300.0  # s: with sanitizers, while other tests run, one has taken 60
ENOUGH = 1.5      # s, after which a run that is long by its own plan is interrupted
LONG_RUN = 10.0   # s, by its plan, at worst

SCENE = """[scene]
duration = 2e-5
speed = 0.5
start = 0.02
spacing = 4e-5
{scene}
[resonator]
support = "pinned"
length = 0.06
thickness = 1e-3
width = 0.02
young = 210e9
density = 7800
damping = 0.02
modes = 6
surface = {{ kind = "gaussian", rq = 1e-6, rsm = 4e-4, seed = 2 }}
{resonator}
[slider]
support = "free"
length = 0.004
thickness = 0.004
width = 0.02
young = 210e9
density = 7800
damping = 0.02
max_frequency = 2e5
surface = {{ kind = "gaussian", rq = 1e-6, rsm = 4e-4, seed = 1 }}
load = "weight"
{slider}
[contact]
stiffness = 1e14
[time]
scheme = "backward-euler"
step = 1e-7
[output]
rate = 1e6
probes = [0.03]
"""
PLAIN = SCENE.format(scene="", resonator="", slider="")

# what each number takes in a sensible scene: low, high
NUMBERS = {
    "scene.duration": (1e-6, 1e-4), "scene.speed": (1e-3, 50), "scene.start": (1e-4, 0.05),
    "scene.gap": (-1e-5, 1e-3), "scene.spacing": (1e-5, 1e-3),
    "contact.stiffness": (1e8, 1e18), "time.step": (1e-9, 1e-5), "time.tolerance": (1e-13, 1e-2),
    "output.rate": (1e3, 1e7), "slider.load": (1e-6, 1e4),
}
for body, length, thick in (("resonator", 0.06, 1e-3), ("slider", 0.004, 4e-3)):
    NUMBERS |= {f"{body}.length": (length / 3, length * 3),
                f"{body}.thickness": (thick / 10, thick * 10),
                f"{body}.width": (1e-4, 1), f"{body}.young": (1e5, 1e13),
                f"{body}.density": (1, 1e6),
                f"{body}.damping": (1e-6, 0.99), f"{body}.surface.rq": (1e-10, 1e-3),
                f"{body}.surface.rsm": (1e-4, 1e-2)}
EXTREMES = ["0", "-1", "5e-324", "-5e-324", "1e-300", "1e300", "1.7e308", "-1.7e308", "nan",
            "inf", "-inf",
            "9223372036854775807", "1e16", "1e-16", "true", "[]"]


class Folder:
    """A folder of one case: a scene, an earlier result, and what else is an input."""

    def __init__(self, scene, inputs=None):
        self.temporary = tempfile.TemporaryDirectory(prefix="ra2d_hostile_")
        self.path = Path(self.temporary.name)
        self.inputs = {"s.toml": scene if isinstance(scene, bytes) else scene.encode()}
        for name, content in (inputs or {}).items():
            self.inputs[name] = content
        for name, content in self.inputs.items():
            (self.path / name).write_bytes(content)
        (self.path / "out.h5").write_bytes(EARLIER)

    def close(self):
        self.temporary.cleanup()


def start(program, words, folder):
    return subprocess.Popen([program, *words], cwd=folder.path, stdin=subprocess.DEVNULL,
                            stdout=open(folder.path / ".stdout", "wb"),
                            stderr=open(folder.path / ".stderr", "wb"))


def ended_within(process, seconds):
    """At once when it ends: subprocess looks every 50 ms only."""
    if process.poll() is not None:
        return True
    handle = os.pidfd_open(process.pid)
    ended = bool(select.select([handle], [], [], seconds)[0])
    os.close(handle)
    return ended


def end(process, seconds=PATIENCE):
    """The exit status, as a shell tells it; None for one that had to be killed."""
    if not ended_within(process, seconds):
        process.kill()
        process.wait()
        return None
    status = process.wait()
    return 128 - status if status < 0 else status


def planned_time(program, words, folder):
    """What a run takes at worst by its plan, in s; 0 where that says nothing."""
    words = [b"plan", *(word for word in words[1:] if word not in (b"-o", b"out.h5", b"--force"))]
    try:
        plan = subprocess.run([program, *words], cwd=folder.path, stdin=subprocess.DEVNULL,
                              capture_output=True,
                              timeout=PATIENCE).stdout.decode()
    except subprocess.TimeoutExpired:
        return 0
    cost = re.search(r"^cost .*?(?=of one core)", plan, re.MULTILINE | re.DOTALL)
    units = {"ps": 1e-12, "ns": 1e-9, "us": 1e-6, "ms": 1e-3, "s": 1, "min": 60, "h": 3600}
    times = re.findall(r"([\d.e+-]+|inf) (ps|ns|us|ms|s|min|h)\b", cost.group()) if cost else []
    return max((float(number) * units[unit] for number, unit in times), default=0)


def marches(folder):
    return any(".partial" in entry for entry in os.listdir(folder.path))


def end_scene(process, program, words, folder):
    """The same of a run that may have a lot to do: then it is interrupted, once it marches.
    Whatever has little to do, or does not come to march, has to end by itself: a loop without end
    would be interrupted, too."""
    if not ended_within(process, ENOUGH) and words[0] == b"run" and planned_time(program, words,
                                                                                 folder) > LONG_RUN:
        begun = time.monotonic()
        while time.monotonic() - begun < PATIENCE and not marches(folder) and not ended_within(
            process, 0.1):
            pass
        if marches(folder):
            process.send_signal(signal.SIGINT)
    return end(process, PATIENCE - ENOUGH)


def printed(folder):
    out, err = ((folder.path / name).read_bytes() for name in (".stdout", ".stderr"))
    (folder.path / ".stdout").unlink()
    (folder.path / ".stderr").unlink()
    return out, err


def raw_characters(text):
    try:
        text = text.decode()
    except UnicodeDecodeError:
        return "bytes that are no UTF-8"
    found = re.search("[\x00-\x09\x0b-\x1f\x7f\x80-\x9f\u061c\u200e\u200f"
                      "\u2028-\u202e\u2066-\u2069\ufeff]", text)
    return f"the control character {found.group()!r}" if found else None


ALWAYS = ["level/v_rms", "level/lv"] + [f"summary/{name}" for name in (
    "lv", "v_rms", "shock_rate", "contact_share", "nodes_evaluated", "energy_residual",
    "energy_turnover",
    "energy_closure", "step_seconds", "wall_seconds")]  # of a complete file


def output_from(file):
    """The time from which a run is counted, s."""
    return tomllib.loads(file.attrs["scene"])["output"]["from"]


def faults_of_file(path, complete):
    """What is wrong with a result; `complete` is None where it may or may not be."""
    found = []
    try:
        with h5py.File(path) as file:
            if complete is not None and file.attrs["complete"] != complete:
                found.append("wrongly marked as cut short, or not")

            def visit(name, node):
                if not isinstance(node, h5py.Dataset) or node.dtype.kind != "f":
                    return
                values = node[()]
                if name.endswith("/lv") and file["level/v_rms"][()] == 0:  # -inf by definition
                    return
                if not numpy.all(numpy.isfinite(values)):
                    found.append(f"{name} is not finite")
            if complete:
                counted = numpy.count_nonzero(file["time"][()] >= output_from(file))
                found += [f"{name} is missing" for name in ALWAYS
                          if name not in file and not (counted < 2 and "energy" in name)]
                file.visititems(visit)
    except (OSError, KeyError) as fault:
        found.append(f"not a whole result: {fault}")
    return found


def check_outcome(folder, status, allowed, new_names=(), may_leave_partial=False):
    """Everything that went wrong with a case that has ended."""
    out, err = printed(folder)
    found = []
    if status is None:
        return [f"did not end within {PATIENCE:g} s"]
    if status not in allowed:
        found.append(f"ended with {status}: {err[-300:]!r}")
    if b"runtime error" in err or b"Sanitizer" in err:
        found.append(f"a sanitizer spoke: {err[:600]!r}")
    if len(err) > 20_000:
        found.append(f"{len(err)} bytes on stderr")
    for name, text in (("stdout", out), ("stderr", err)):
        if raw := raw_characters(text):
            found.append(f"{name} has {raw}")
    if status == 0:
        if odd := re.search(rb"(?<![\w.])-?(nan|inf)\b",
                            out.replace(b"-inf dB: the resonator did not vibrate", b"")):
            found.append(f"the report has {odd.group()!r}")
    elif status < 128 and not err.strip():
        found.append(f"ended with {status} without a word")
    for name, content in folder.inputs.items():
        if not (folder.path / name).exists() or (folder.path / name).read_bytes() != content:
            found.append(f"{name} was changed")
    result = (folder.path / "out.h5")
    if not result.exists():
        found.append("the earlier result is gone")
    elif result.read_bytes() != EARLIER:
        if status in (2, 4):
            found.append("the earlier result was replaced")
        if status in (0, 3) or status >= 128:
            found += faults_of_file(result, None if status >= 128 else status == 0)
    for entry in os.listdir(folder.path):
        partial = ".partial" in entry or entry.endswith(".lock")
        goes_on = entry in BESIDE_OUTPUT and (status >= 128 or status == 5)
        if entry not in folder.inputs and entry not in ("out.h5", *new_names) and not goes_on \
                and not (partial and may_leave_partial):
            found.append(f"left {entry!r}")
    return found


# ---- scenes


def damaged(text, dice):
    """A text at fault, and in which way."""
    data = bytearray(text.encode())
    choice = dice.randrange(6)
    if choice == 0:
        return bytes(data[:dice.randrange(len(data))])
    if choice == 1:
        for _ in range(dice.randrange(1, 6)):
            data[dice.randrange(len(data))] = dice.randrange(256)
        return bytes(data)
    if choice == 2:
        at = dice.randrange(len(data))
        return bytes(data[:at]) + dice.randbytes(dice.randrange(1, 40)) + bytes(data[at:])
    lines = text.split("\n")
    if choice == 3:
        del lines[dice.randrange(len(lines))]
    elif choice == 4:
        lines.insert(dice.randrange(len(lines)), dice.choice(lines))
    else:
        a, b = dice.randrange(len(lines)), dice.randrange(len(lines))
        lines[a], lines[b] = lines[b], lines[a]
    return "\n".join(lines).encode()


TEXTS = {
    "empty": b"", "a zero": b"\0", "not UTF-8": b"[scene]\nname = '\xff'\n",
    "UTF-16": PLAIN.encode("utf-16"),
    "byte-order mark": b"\xef\xbb\xbf" + PLAIN.encode(),
    "CR LF": PLAIN.replace("\n", "\r\n").encode(),
    "CR": PLAIN.replace("\n", "\r").encode(), "HDF5": b"\x89HDF\r\n\x1a\n" + bytes(1000),
    "17 MB": b"#" * 17_000_000, "comments": b"# x\n" * 100_000 + PLAIN.encode(),
    "dotted key": b"a." * 300_000 + b"a = 1", "dotted header": b"[" + b"a." * 300_000 + b"a]",
    "quoted keys": b"'a'." * 300_000 + b"a = 1", "dotted in a table": b"x = {" + b"a." * 300_000
    + b"a = 1}",
    "arrays": b"x = " + b"[" * 1_000_000, "tables": b"x = " + b"{a=" * 300_000,
    "tables of dotted keys": b"x = " + b"{a.b.c.d.e=" * 100_000,
    "arrays of tables": b"[[a]]\n" * 100_000,
    "headers": b"".join(b"[a.b%d]\n" % i for i in range(30_000)),
    "a long key": b"x" * 5_000_000 + b" = 1",
    "a long text": b"x = '" + b"y" * 5_000_000 + b"'",
    "unknown keys": b"".join(b"k%d = 1\n" % i for i in range(20_000)),
    "quotes": b'"' * 100_001, "backslashes": b'x = "' + b"\\" * 100_001,
    "many lines": b"\n" * 1_000_000,
    "bad probes": PLAIN.replace("[0.03]", "[" + "9, " * 200_000 + "]").encode(),
    "probes of text": PLAIN.replace("[0.03]", "[" + "'a', " * 100_000 + "]").encode(),
    "many probes": PLAIN.replace("[0.03]", "[" + "0.03, " * 20_000 + "]").encode(),
    "a control name": SCENE.format(scene='name = "a\\u001b[2J\\u009b \\n \\u0000 \\u202e\\u2028"',
                                   resonator="", slider="").encode(),
    "a long name": SCENE.format(scene=f'name = "{"n" * 3_000_000}"', resonator="",
                                slider="").encode(),
    "many peaks": PLAIN.replace('kind = "gaussian", rq = 1e-6, rsm = 4e-4, seed = 1',
                                'kind = "peaks", peaks = ['
                                + "{at=0.002,height=1e-6,half_width=1e-4}," * 3000 + "]").encode(),
    "many forces": SCENE.format(scene="", resonator="moving_force = ["
                                + "{force=1e-3,speed=1,start=0}," * 3000 + "]", slider="").encode(),
    "a deep override": PLAIN.encode(),
}
OVERRIDES = [
    "", "=", "=1", ".=1", "scene", "scene=1", "scene.=1", ".scene=1", "scene..x=1", "a b=1",
    "scene.speed=", "scene.speed==1",
    "scene.speed=1\n2", "scene.speed=[", "scene.name=\x1b[31m", "scene.\x1b=1",
    "scene.name=" + "x" * 100_000, "x" * 100_000,
    "scene.name=\udcff", "scene.speed={a=1}", "resonator={}", "resonator.surface=3",
    "output.probes=[1,[2]]",
    "output.probes=[nan]", "scene.start.x.y=1", "time.scheme=\x00x"[:12], "a." * 60_000 + "a=1",
    "scene.x=" + "[" * 100_000,
    "resonator.surface={kind='file',path=''}", "resonator.surface={kind='file',path='.'}",
    "resonator.surface={kind='file',path='\\u001b'}",
    "slider.surface={kind='file',path='/dev/zero'}",
    "slider.surface={kind='file',path='/proc/self/mem'}",
    "slider.surface={kind='file',path='s.toml'}",
    "slider.surface={kind='file',path='" + "p" * 5000 + "'}",
    "resonator.moving_force=[{force=1e300,speed=1e300,start=0}]",
    "resonator.moving_force=[{force=1,speed=1e9,start=-1}]",
    "resonator.moving_force=[{force=nan,speed=1,start=0}]",
    "resonator.moving_force=[{force=1,speed=0,start=1e308}]",
    "slider.surface={kind='peaks',peaks=[{at=0.002,height=1e300,half_width=1e-4}]}",
    "slider.surface={kind='peaks',peaks=[{at=0.002,height=1e-6,half_width=5e-324}]}",
    "slider.surface={kind='peaks',peaks=[{at=1e308,height=1,half_width=1.7e308}]}",
    "resonator.modes=1000000", "resonator.modes=-1", "resonator.modes=256",
    "resonator.max_frequency=1e300",
    "resonator.surface.seed=9223372036854775807", "resonator.surface.seed=-1",
    "resonator.surface.correlation_length=1",
]


CHARTS = [  # refused, as a scene of them would be, and before anything is written
    "accuracy s.toml --budget nan", "accuracy s.toml --budget 1e300", "accuracy s.toml --budget -1",
    "accuracy s.toml --peers s.toml", "accuracy s.toml -o .", "stability s.toml -o nowhere/x",
    *(f"{kind} s.toml --set {given}" for kind in ("accuracy", "stability")
      for given in ("resonator.max_frequency=1e9", "resonator.modes=1000000", "time.step=nan",
                    "time.step=0",
                    "scene.spacing=5e-324", "contact.stiffness=inf", "slider.young=1e300"))]


def log_uniform(dice, low, high):
    if low < 0:
        return dice.uniform(low, high)
    return math.exp(dice.uniform(math.log(low), math.log(high)))


def random_overrides(dice):
    """A scene that might run, with a few numbers far out."""
    given = []
    for key in dice.sample(list(NUMBERS), dice.randrange(1, 5)):
        low, high = NUMBERS[key]
        given.append(f"{key}={log_uniform(dice, low, high):.6g}")
    scheme = dice.choice(["explicit-euler", "midpoint", "backward-euler", "heun", "rk4", "rk8",
                          "exact", "gautschi", "adaptive"])
    given.append(f"time.scheme={scheme}")
    if dice.random() < 0.3:
        given.append("contact.law=multiplier")
    if dice.random() < 0.3:
        given.append("time.contact_force=new")
    if dice.random() < 0.3:
        given.append("time.force=true")
    if dice.random() < 0.3:
        given.append("scene.initial=static")
    given.append(f"resonator.support={dice.choice(['pinned', 'pinned', 'free', 'rigid'])}")
    if dice.random() < 0.5:
        given.append(f"slider.support={dice.choice(['pinned', 'free', 'rigid'])}")
        if dice.random() < 0.5:
            given.append("slider.load=0")
    return given


def scene_cases(times, dice):
    """Name, text, overrides; of a chart, its words."""
    cases = [(f"{key}={value}", PLAIN.encode(), [f"{key}={value}"]) for key in NUMBERS
             for value in EXTREMES]
    cases += [(name, text, ["a." * 60_000 + "a=1"] if name == "a deep override" else [])
              for name, text in TEXTS.items()]
    cases += [(f"override {text[:40]!r}", PLAIN.encode(), [text]) for text in OVERRIDES]
    cases += [(f"chart {words}", PLAIN.encode(), ["chart", *words.split()]) for words in CHARTS]
    for i in range(50 * times):
        cases.append((f"damaged {i}", damaged(PLAIN, dice), []))
    for i in range(50 * times):
        given = random_overrides(dice)
        cases.append((f"random {i}: {' '.join(given)}", PLAIN.encode(), given))
    return cases


def try_scene(program, case, dice):
    name, text, given = case
    folder = Folder(text)
    if name.startswith("chart "):
        status = end(start(program, given, folder))
        return folder, status, check_outcome(folder, status, (2, 4))
    choice = dice.random()
    words = ["plan", "s.toml"] if choice < 0.1 else [*RUN, *(FORCE if choice < 0.9 else [])]
    for one in given:
        words += ["--set", one]
    words = [os.fsencode(word) for word in words]
    status = end_scene(start(program, words, folder), program, words, folder)
    found = check_outcome(folder, status, (0, 2, 3, 4, 130) if choice < 0.9 else (2, 3, 4))
    if choice >= 0.9 and (folder.path / "out.h5").read_bytes() != EARLIER:
        found.append("what was there was replaced unasked")
    return folder, status, found


# ---- profiles


def face(dice, count=151, spacing=4e-5):
    z, rows = 0.0, []
    for n in range(count):
        z = 0.9 * z + dice.gauss(0, 4e-7)
        rows.append((n * spacing, z))
    return rows


def csv(rows, form="{:.6e},{:.6e}", line_end="\n"):
    return "".join(form.format(x, z) + line_end for x, z in rows).encode()


def sdf(rows, binary):
    step = rows[1][0] - rows[0][0]
    if binary:
        numbers = struct.pack("<HHddddBBB", len(rows), 1, step, step, 1e-9, 0, 0, 6, 0)
        return (b"bISO-1.0us        " + b"211120260000" * 2 + numbers
                + b"".join(struct.pack("<i", round(z * 1e9)) for _, z in rows))
    head = (f"aISO-1.0\nNumPoints = {len(rows)}\nNumProfiles = 1\nXscale = {step}\nZscale = "
            "1e-9\nDataType = 7\n*\n")
    return (head + "\n".join(f"{z * 1e9:.6g}" for _, z in rows) + "\n*\n").encode()


def x3p(rows):
    data = b"".join(struct.pack("<d", z) for _, z in rows)
    step = rows[1][0] - rows[0][0]
    main = ("<p:ISO5436_2 xmlns:p='o'><Record1><Axes>"
            f"<CX><AxisType>I</AxisType><Increment>{step}</Increment></CX>"
            "<CZ><AxisType>A</AxisType><DataType>D</DataType></CZ></Axes></Record1><Record3>"
            f"<MatrixDimension><SizeX>{len(rows)}</SizeX><SizeY>1</SizeY><SizeZ>1</SizeZ>"
            "</MatrixDimension>"
            "<DataLink><PointDataLink>bindata/data.bin</PointDataLink><MD5ChecksumPointData>"
            f"{hashlib.md5(data).hexdigest()}</MD5ChecksumPointData></DataLink></Record3>"
            "</p:ISO5436_2>").encode()
    packed = io.BytesIO()
    with zipfile.ZipFile(packed, "w", zipfile.ZIP_DEFLATED) as archive:
        md5 = hashlib.md5(main).hexdigest()
        for name, content in (("main.xml", main), ("md5checksum.hex", md5),
                              ("bindata/data.bin", data)):
            archive.writestr(zipfile.ZipInfo(name, (1980, 1, 1, 0, 0, 0)), content)
    return packed.getvalue()


def profile_cases(times, dice):
    """Name, content of the slider's profile."""
    rows = face(dice)
    good = csv(rows)
    cases = [
        ("good", good), ("blanks", csv(rows, "{:.6e}  {:.6e}")),
        ("CR LF", csv(rows, line_end="\r\n")),
        ("names", b"x,z\n" + good), ("semicolons", csv(rows, "{:.6e};{:.6e}")),
        ("decimal commas", csv(rows, "{:.6f};{:.9f}").replace(b".", b",")),
        ("CR", csv(rows, line_end="\r")),
        ("UTF-16", good.decode().encode("utf-16")), ("BOM", b"\xef\xbb\xbf" + good), ("empty", b""),
        ("a zero", b"\0"),
        ("zeros", bytes(100_000)), ("blank lines", b"\n" * 100_000), ("one point", csv(rows[:1])),
        ("two points", b"0 0\n1 0\n"), ("names alone", b"x z\n"),
        ("comments", b"# a\n" * 50_000 + good),
        ("commas", b"," * 5_000_000), ("a long line", b"1 " * 3_000_000),
        ("a long comment", b"#" + b"-" * 5_000_000),
        ("long lines", (b"," * 60_000 + b"\n") * 100), ("control", b"0 \x1b[2J\n1 \x07\n"),
        ("C1", b"0 \xc2\x9b\n1 2\n"),
        ("HDF5", b"\x89HDF\r\n\x1a\n" + bytes(1000)),
        ("nan", good.replace(b"e-07", b"e-07 nan", 1)),
        ("no end", good.rstrip()), ("reversed", csv(rows[::-1])),
        ("constant x", csv([(0, z) for _, z in rows])),
        ("three columns", csv(rows, "{0:.6e},{1:.6e},{1:.6e}")),
        ("one column", csv(rows, "{1:.6e}")),
        ("large", csv([(x, 1.7e308 * (n % 2)) for n, (x, _) in enumerate(rows)])),
        ("far", csv([(x * 1e306, z) for x, z in rows])),
        ("small", csv([(x, 5e-324) for x, _ in rows])),
        ("short", csv(rows[:50])),
        ("100 000 points", csv(face(dice, 100_000, 1e-7), "{:.9e} {:.3e}")),
    ]
    for x_unit in (1, 1e-3, 1e-6, 1e-9):
        for z_unit in (1e-3, 1e-6, 1e-9):
            cases.append((f"units {x_unit} {z_unit}",
                          csv([(x / x_unit, z / z_unit) for x, z in rows])))
    for i in range(20 * times):
        cases.append((f"cut {i}", good[:dice.randrange(len(good))]))
    for i in range(25 * times):
        data = bytearray(good)
        for _ in range(dice.randrange(1, 4)):
            data[dice.randrange(len(data))] = dice.choice(b"0123456789eE+-., \n\t#x\x00\xff")
        cases.append((f"changed {i}", bytes(data)))
    for kind, good in (("SDF", sdf(rows, False)), ("binary SDF", sdf(rows, True)),
                       ("X3P", x3p(rows))):
        cases.append((f"good {kind}", good))
        for i in range(5 * times):
            cases.append((f"cut {kind} {i}", good[:dice.randrange(len(good))]))
            data = bytearray(good)
            data[dice.randrange(len(data))] = dice.randrange(256)
            cases.append((f"changed {kind} {i}", bytes(data)))
    return cases


def try_profile(program, case, dice):
    name, content = case
    scene = PLAIN.replace('surface = { kind = "gaussian", rq = 1e-6, rsm = 4e-4, seed = 1 }',
                          'surface = { kind = "file", path = "p.csv" }')
    folder = Folder(scene, {"p.csv": content})
    words = ["plan", "s.toml"] if dice.random() < 0.1 else RUN + FORCE
    status = end(start(program, words, folder))
    found = check_outcome(folder, status, (0, 2, 3, 4))
    if name.startswith("units") and status != 2:
        found.append("read in a wrong unit without a fault")
    if (name.startswith("good") or name == "no end") and status != 0:
        found.append("refused")
    return folder, status, found


# ---- kills and signals


LONG = PLAIN.replace("duration = 2e-5", "duration = 0.05").replace("speed = 0.5", "speed = 0.1")


def kill_cases(times, dice):
    """When to kill, s after the start."""
    return [(f"kill {i}", dice.uniform(0, 0.15)) for i in range(50 * times)]


def try_kill(program, case, dice):
    folder = Folder(LONG)
    process = start(program, RUN + FORCE, folder)
    time.sleep(case[1])
    process.kill()
    status = end(process)
    found = check_outcome(folder, status, (0, 128 + signal.SIGKILL), may_leave_partial=True)
    if dice.random() < 0.2:  # the next run into this folder cleans up
        (folder.path / "out.h5").write_bytes(EARLIER)
        again = end(start(program, [*RUN, *FORCE, "--set", "scene.duration=1e-5"], folder))
        found += [f"run again: {what}" for what in check_outcome(folder, again, (0,))]
    return folder, status, found


def signal_cases(times, dice):
    kinds = [signal.SIGINT, signal.SIGTERM, signal.SIGHUP, signal.SIGQUIT]
    setups = ["", "", "scene.spacing=2e-7", "resonator.modes=120", "scene.initial=static"]
    return [(f"{kinds[i % 4].name} {i} {setup}", kinds[i % 4], dice.uniform(0, 0.3),
             i % 3 == 2, setup)
            for i in range(30 * times) for setup in [dice.choice(setups)]]


def try_signal(program, case, dice):
    _, kind, delay, twice, setup = case
    folder = Folder(LONG)
    words = RUN + FORCE + (["--set", setup] if setup else [])
    process = start(program, words, folder)
    time.sleep(delay)
    process.send_signal(kind)
    if twice:
        time.sleep(dice.uniform(0, 0.05))
        process.send_signal(kind)
    begun = time.monotonic()
    status = end(process)
    found = check_outcome(folder, status, (0, 128 + kind))
    if time.monotonic() - begun > 1.4:
        found.append("did not end within a second")
    return folder, status, found


# ---- runs that go on


SCHEMES = [(scheme, law, force) for scheme in ("explicit-euler", "midpoint", "backward-euler",
                                               "heun", "rk4", "rk8",
                                               "exact", "gautschi", "adaptive")
           for law in ("penalty", "multiplier") for force in ("old", "new")
           if (force == "old" or (scheme, law) == ("backward-euler", "penalty"))
           and (law == "penalty" or scheme not in ("explicit-euler", "adaptive"))]
RESUMED = PLAIN.replace("speed = 0.5", "speed = 0.2")
SLOWER = 1  # than a release build
# s between two checkpoints: often, that runs are cut off while they write them. With sanitizers
# to write one takes far longer, and a run with so many would not end
CHECKPOINT = {"run": "1e-5", "study": "1e-4"}
# how runs that were to go on were cut off, and how often they went on from a checkpoint
CUTS = Counter()


def resume_cases(times, dice):
    """A scheme and a law, and other surfaces."""
    return [(f"{' '.join(SCHEMES[i % len(SCHEMES)])} {i}", SCHEMES[i % len(SCHEMES)],
             dice.randrange(1000))
            for i in range(len(SCHEMES) * times)]


def content(path):
    """Every dataset's bytes but those of times and of cost, which launches change."""
    found = {}
    with h5py.File(path) as file:
        def visit(name, node):
            if isinstance(node,
                          h5py.Dataset) and not name.endswith(("_seconds", "nodes_evaluated")):
                found[name] = node[()].tobytes()
        file.visititems(visit)
        found["complete"] = bool(file.attrs["complete"])
    return found


def try_resume(program, case, dice):
    _, (scheme, law, force), seed = case
    folder = Folder(RESUMED.replace("2e-5", "0.012" if SLOWER == 1 else "0.004"))
    words = ["run", "s.toml", "--set", f"time.scheme={scheme}", "--set",
             f"contact.law={law}", "--set",
             f"time.contact_force={force}", "--set", "time.force=true", "--set",
             f"slider.surface.seed={seed}"]
    status = end(start(program, [*words, "-o", "whole.h5"], folder))
    if status != 0:
        return folder, status, [f"ended with {status}: {printed(folder)[1][-300:]!r}"]
    went_on = 0
    found = []
    longer = 1.0  # on a busy machine a run may be cut off before its first checkpoint
    for attempt in range(31):
        if attempt > 2 and went_on == 0:
            longer *= 1.2
        process = start(program, [*words, "-o", "out.h5", "--checkpoint", CHECKPOINT["run"],
                                  *FORCE], folder)
        cut = attempt < 30
        allowed = (0, 137, 143) if cut else (0,)
        if cut:
            time.sleep(longer * SLOWER * dice.uniform(0.02, 0.08))
            if dice.random() < 0.2:  # ends what the system has not loaded yet
                process.send_signal(signal.SIGUSR1)
                allowed += (128 + signal.SIGUSR1,)
            process.send_signal(dice.choice([signal.SIGKILL, signal.SIGKILL, signal.SIGTERM]))
        status = end(process)
        CUTS[status] += status != 0
        went_on += b"goes on from" in (folder.path / ".stderr").read_bytes()
        found += check_outcome(folder, status, allowed, ("whole.h5",), may_leave_partial=True)
        if status == 0:
            break
    if status == 0 and content(folder.path / "out.h5") != content(folder.path / "whole.h5"):
        found.append("went on to other bits")
    CUTS["went on"] += went_on
    return folder, status, found


def study_cases(times, dice):
    """How many threads, whether results are kept, and other surfaces."""
    return [(f"{1 + i % 2} threads, {'kept' if i % 4 < 2 else 'not kept'} {i}", 1 + i % 2,
             i % 4 < 2, dice.randrange(1000))
            for i in range(2 * times)]


def study_content(folder):
    """The table without times, and the results that are kept."""
    with h5py.File(folder / "results.h5") as file:
        found = {name: file[name][()].tobytes() for name in file if name != "wall_seconds"
                 and file[name].dtype.kind != "O"}
    for kept in sorted(folder.glob("runs/*.h5")):
        found |= {f"{kept.name}/{name}": value for name, value in content(kept).items()}
    return found


def await_checkpoint(process, runs):
    """Until a run of a study has one, or the study ends."""
    latest = time.monotonic() + STUDY_PATIENCE
    while (process.poll() is None and not any(runs.glob("*.h5.checkpoint"))
           and time.monotonic() < latest):
        time.sleep(0.002)


def try_study(program, case, dice):
    """Every scheme and law in one study, killed again and again."""
    _, threads, kept, seed = case
    folder = Folder(RESUMED.replace("2e-5", "0.04" if SLOWER == 1 else "0.002"))
    values = ", ".join(f'["{scheme} {law} {force}", "{scheme}", "{law}", "{force}"]'
                       for scheme, law, force in SCHEMES)
    (folder.path / "study.toml").write_text(
        f'base = "s.toml"\nkeep = {["level", "shocks", *["files"] * kept]}\n'
        f'[set]\n"time.force" = true\n"slider.surface.seed" = {seed}\n'
        '[vary]\nscheme = { keys = ["scene.name", "time.scheme", "contact.law", '
        '"time.contact_force"], '
        f'values = [{values}] }}\n')
    words = ["study", "study.toml", "--threads", str(threads), "--checkpoint", CHECKPOINT["study"]]
    status = end(start(program, [*words, "-o", "whole"], folder), STUDY_PATIENCE)
    found = [] if status == 0 else [f"ended with {status}: {printed(folder)[1][-300:]!r}"]
    went_on = attempt = 0
    while not found:
        process = start(program, [*words, "-o", "out"], folder)
        attempt += 1
        if attempt <= 8:
            if attempt > 2 and went_on == 0:  # on a slow machine a cut falls before the first run
                await_checkpoint(process, folder.path / "out" / "runs")
            else:
                time.sleep(SLOWER * dice.uniform(0.03, 0.2))
            process.send_signal(dice.choice([signal.SIGKILL, signal.SIGKILL, signal.SIGTERM]))
        status = end(process, STUDY_PATIENCE)
        CUTS[status] += status != 0
        out, err = printed(folder)
        went_on += b"from checkpoints, " in out
        if status not in ((0, 137, 143) if attempt <= 8 else (0,)) or b"starts anew" in err:
            found.append(f"ended with {status}: {err[-300:]!r}")
        if status == 0:
            break
    if not found and study_content(folder.path / "out") != study_content(folder.path / "whole"):
        found.append("went on to other numbers")
    CUTS["went on"] += went_on
    found += [f"left {left.name}" for left in folder.path.glob("out/runs/*.h5.*") if not found]
    return folder, status, found


# ---- results that were damaged, changed or forged


MADE = {}  # what the cases begin with, made once: the bytes of a result, and a study's folder
READERS = {"analyze": ["analyze", "out.h5"], "json": ["analyze", "out.h5", "--json"],
           "report": ["report", "out.h5", "-o", "page.html"],
           "sound": ["sound", "out.h5", "-o", "noise.wav"],
           "plot": ["plot", "out.h5", "-o", "picture.png"],
           "check": ["check", "out.h5"], "run": ["run", "s.toml", "-o", "out.h5"],
           "several": ["analyze", "whole.h5", "out.h5"]}
SEAL = seal.LINE  # bytes at the very end


def sealed(data):
    """As a forger does it."""
    return data + seal.seal_of(data)


# These compare with the seal what they use, and nothing else: of bytes that they do not use they
# take no notice. (Not `plot`, whose Python takes seconds: it is asked only where it must refuse.)
READS_A_PART = ["analyze", "json", "report", "sound", "several"]
READS_A_PART_OF_STUDY = [["analyze", "study"], ["report", "study", "-o", "page.html"]]
MAY_GO_UNSEEN = ("bit", "bit of the metadata")


def answer(program, words, folder):
    """All that a command makes of a whole file."""
    if end(start(program, words, folder)) != 0:
        sys.exit(f"{words} failed: {printed(folder)[1][-300:]!r}")
    return answered(words, folder, printed(folder)[0])


def answered(words, folder, out):
    """What it prints, without the times that it took, and what it makes."""
    made = (folder.path / words[-1]).read_bytes() if "-o" in words else b""
    return re.sub(rb"\d+(\.\d+)? m?s\b", b"", out), made


def ask_reader(program, folder, words):
    """The command refuses the file, or its answer is that of the whole one."""
    status, out, err, found = ask(program, folder, words, (0, 4))
    if status == 0 and answered(words, folder, out) != MADE[tuple(words)]:
        found.append(f"{words} made another answer of a damaged file: {out[:300]!r}")
    return status, out, err, found


def make_once(program):
    if MADE:
        return
    folder = Folder(PLAIN.replace("duration = 2e-5", "duration = 1e-3"))
    (folder.path / "study.toml").write_text(
        'base = "s.toml"\nkeep = ["level", "shocks", "files"]\nseeds = 2\n[vary]\nspeed = { key = '
        '"scene.speed", values = [0.2, 0.5] }\n')
    for words in (["run", "s.toml", "-o", "whole.h5"], ["study", "study.toml", "-o", "study"]):
        if end(start(program, words, folder)) != 0:
            sys.exit(f"{words} failed: {printed(folder)[1][-300:]!r}")
    MADE["result"] = (folder.path / "whole.h5").read_bytes()
    MADE["study"] = {path.relative_to(folder.path): path.read_bytes()
                     for path in sorted((folder.path / "study").rglob("*")) if path.is_file()}
    (folder.path / "out.h5").write_bytes(MADE["result"])
    for words in [READERS[name] for name in READS_A_PART] + READS_A_PART_OF_STUDY:
        MADE[tuple(words)] = answer(program, words, folder)
    MADE["inputs"] = {name: (folder.path / name).read_bytes() for name in ("s.toml", "study.toml")}
    with open(folder.path / "whole.h5", "rb") as file:
        MADE["metadata"] = places_of_metadata(file)
    folder.close()


def places_of_metadata(file):
    """Bytes of a result that are neither samples nor zeros: where HDF5 may stumble."""
    data = seal.without_seal(file.read())
    is_meta = bytearray(b"\1" * len(data))
    with h5py.File(file.name) as results:
        def visit(_, node):
            if not isinstance(node, h5py.Dataset):
                return
            chunks = [node.id.get_chunk_info(i)
                      for i in range(node.id.get_num_chunks())] if node.chunks else []
            parts = [(chunk.byte_offset, chunk.size) for chunk in chunks]
            if not node.chunks and node.id.get_offset():
                parts = [(node.id.get_offset(), node.id.get_storage_size())]
            for at, size in parts:
                is_meta[at:at + size] = bytes(size)
        results.visititems(visit)
    return [at for at, meta in enumerate(is_meta) if meta and data[at]]


def spoil_bytes(data, choice, dice):
    """Damage that no program has made on purpose."""
    data = bytearray(data)
    at, size = dice.randrange(len(data)), dice.randrange(1, 5000)
    if choice == "bit":
        data[at] ^= 1 << dice.randrange(8)
    elif choice == "bit of the metadata":
        data[dice.choice(MADE["metadata"])] ^= 1 << dice.randrange(8)
    elif choice == "bit of the seal":
        data[-1
             - dice.randrange(len(data) - len(seal.without_seal(data)))] ^= 1 << dice.randrange(8)
    elif choice == "cut":
        del data[dice.choice([at, 5000, len(data) - 1, len(data) - SEAL, 8, 0]):]
    elif choice == "longer":
        data += dice.choice([b"\n", bytes(size), data[-SEAL:], bytes(data)])
    elif choice == "zeros":
        data[at:at + size] = bytes(len(data[at:at + size]))
        data[0] ^= 1  # there may have been zeros
    elif choice == "moved":
        other = dice.randrange(len(data))
        part = data[other:other + size]
        del data[other:other + size]
        data[at % max(1, len(data)):0] = part
        data[0] ^= 1
    return bytes(data)


def first_number(file):
    return file["contact/force"] if "contact/force" in file else file["v_rms"]


EDITS = {  # what h5py makes of a file, on purpose
    "opened to be written": lambda file: None,
    "scene": lambda file: file.attrs.modify("scene" if "scene" in file.attrs
                                            else "base", "x = 1\n"),
    "complete": lambda file: file.attrs.modify("complete", 0),
    "unit": lambda file: first_number(file).attrs.modify("units", "km"),
    "value": lambda file: first_number(file).__setitem__(..., 0.25),
    "added": lambda file: file.create_dataset("new", data=[1.0]),
    "removed": lambda file: file.__delitem__("contact" if "contact" in file else "contact_share"),
    "renamed": lambda file: file.move("energy" if "energy" in file else "energy_closure", "other"),
}


def edited(data, edit, path):
    path.write_bytes(data)
    with h5py.File(path, "r+") as file:
        edit(file)
    return path.read_bytes()


def forge(name, value):
    """One number of a dataset, and its hash, so that nothing but the number itself is wrong."""
    def edit(file):
        for dataset in (file[path] for path in name.split()):
            values = dataset[()]
            if dataset.shape:
                values[-1] = value
            else:
                values = numpy.float64(value)
            dataset[...] = values
            dataset.attrs.modify("xxh3_128",
                                 xxhash.xxh3_128_hexdigest(
                                     numpy.ascontiguousarray(values).tobytes()))
    return edit


FORGED = {  # numbers that no run comes to
    "a shock without end": forge("shocks/duration", 1e300),
    "a shock longer than the run": forge("shocks/duration", 2e-3),
    "a shock after the end": forge("shocks/start", 1e6),
    "a shock of no duration": forge("shocks/duration", math.nan),
    "a shock elsewhere": forge("shocks/position", 7.0),
    "a time after the end": forge("time", 5e300),
    "a frequency": forge("resonator/frequency", -1.0),
    "a frequency without end": forge("slider/frequency", math.inf),
    "a probe elsewhere": forge("probes/position", 1e9),
    "a level": forge("level/lv summary/lv", 200.0),
    "a velocity": forge("level/v_rms summary/v_rms", 1.0),
    "one of two levels": forge("level/lv", 1.0),
    "a share": forge("summary/contact_share", 2.0),
    "a number of steps": lambda file: file.attrs.modify("steps", -5),
    "a size": lambda file: file["shocks/start"].resize((10 ** 12,)),
    "a large size": lambda file: file["time"].resize((10 ** 6,)),
}

SPOILT = ["bit", "bit of the metadata", "bit of the seal", "cut", "longer", "zeros", "moved"]


def reader_cases(times, dice):
    cases = [(f"{choice} {i}", "spoilt", choice) for i in range(2 * times) for choice in SPOILT]
    cases += [(f"changed: {name}", "changed", name) for name in EDITS]
    cases += [(f"forged: {name}", "forged", name) for name in FORGED]
    cases += [(f"forged bit {i}", "forged bit", "") for i in range(15 * times)]
    cases += [(f"study's {what}: {choice} {i}", f"study {what}", choice) for i in range(times)
              for what in ("table", "kept result")
              for choice in [*SPOILT, *EDITS]]
    dice.shuffle(cases)
    return cases


def ask(program, folder, words, allowed, made=()):
    """What is wrong with how a command ends. It may leave nothing but `made`."""
    before = set(os.listdir(folder.path))
    process = start(program, words, folder)
    status = end(process)
    out, err = printed(folder)
    found = []
    if status not in allowed:
        found.append(f"{words[0]} ended with {status}: {err[-300:]!r}")
    if status == 4 and not err.strip():
        found.append(f"{words[0]} ended with 4 without a word")
    if b"complete: nothing to do" in out and 0 not in allowed:
        found.append(f"{words[0]} calls it complete")
    if b"Sanitizer" in err or b"runtime error" in err:
        found.append(f"{words[0]}: a sanitizer spoke: {err[:600]!r}")
    if raw := raw_characters(out + err):
        found.append(f"{words[0]} printed {raw}")
    left = set(os.listdir(folder.path)) - before - {".stdout", ".stderr"} - set(made)
    if status == 4 and left:
        found.append(f"{words[0]} left {left}")
    return status, out, err, found


def try_reader(program, case, dice):
    make_once(program)
    _, kind, choice = case
    if kind.startswith("study"):
        return try_study_reader(program, kind, choice, dice)
    folder = Folder(MADE["inputs"]["s.toml"])
    result, whole = folder.path / "out.h5", MADE["result"]
    (folder.path / "whole.h5").write_bytes(whole)
    allowed = (4,)
    commands = list(READERS)
    if kind == "spoilt":
        data = spoil_bytes(whole, choice, dice)
    elif kind == "changed":
        data = edited(whole, EDITS[choice], result)
    elif kind == "forged":
        data = sealed(edited(whole, FORGED[choice], result))
        commands.remove("run")  # which does not look at numbers that it does not use
    else:  # the seal fits, and HDF5 may be led astray
        data = bytearray(seal.without_seal(whole))
        for _ in range(dice.choice([1, 1, 8])):
            data[dice.choice(MADE["metadata"])] = dice.randrange(256)
        data = sealed(bytes(data))
        commands, allowed = ["check", "analyze", "sound"], (0, 4)
    if data == whole:
        return folder, 0, ["the case changed nothing"]
    result.write_bytes(data)
    found, status = [], None
    for name in commands:
        words = READERS[name]
        # what neither begins nor ends as a result does is no result: a profile, perhaps
        foreign = not data.startswith(b"\x89HDF\r\n\x1a\n") and b"ra2d seal " != data[-SEAL:][:10]
        if foreign and name in ("plot", "run"):
            continue
        # a run refuses to replace what it cannot read
        if choice in MAY_GO_UNSEEN and name == "plot":
            continue
        if choice in MAY_GO_UNSEEN and name in READS_A_PART:
            status, _, _, wrong = ask_reader(program, folder, words)
        else:
            status, _, _, wrong = ask(program, folder, words, (2,) if name.startswith("run")
                                      and allowed == (4,) else allowed)
        found += wrong
        if result.read_bytes() != data:
            found.append(f"{name} changed the file")
    if kind not in ("forged", "forged bit"):
        again = ask(program, folder, ["run", "s.toml", "-o", "out.h5", "--force"], (0,))
        found += again[3]
        found += ask(program, folder, ["check", "out.h5"], (0,))[3]
    return folder, status, found


def try_study_reader(program, kind, choice, dice):
    folder = Folder(MADE["inputs"]["s.toml"], {"study.toml": MADE["inputs"]["study.toml"]})
    for path, content in MADE["study"].items():
        (folder.path / path).parent.mkdir(parents=True, exist_ok=True)
        (folder.path / path).write_bytes(content)
    of_table = kind == "study table"
    file = folder.path / ("study/results.h5" if of_table
                          else dice.choice([p for p in MADE["study"] if p.parts[1] == "runs"]))
    whole = file.read_bytes()
    if choice in EDITS:
        data = edited(whole, EDITS[choice], file)
    else:
        data = spoil_bytes(whole, "bit" if choice == "bit of the metadata" else choice, dice)
    if data == whole:
        return folder, 0, ["the case changed nothing"]
    file.write_bytes(data)
    found = []
    status, _, err, wrong = ask(program, folder, ["check", "study"], (4,))
    found += wrong + ([] if file.name.encode() in err
                      else [f"check does not name {file.name}: {err[:300]!r}"])
    if of_table:
        for words in READS_A_PART_OF_STUDY:
            found += (ask_reader(program, folder, words) if choice in MAY_GO_UNSEEN
                      else ask(program, folder, words, (4,)))[3]
        if choice not in MAY_GO_UNSEEN:
            found += ask(program, folder, ["plot", "study", "-o", "picture.png"], (4,))[3]
        found += ask(program, folder, ["study", "merge", "study"], (0,))[3]
    else:
        _, _, err, wrong = ask(program, folder, ["study", "study.toml", "-o", "study"], (0,))
        found += wrong + ([] if b"its run is made again" in err or not data
                          else [f"the study says nothing: {err[:300]!r}"])
    found += [f"afterwards: {what}" for what in ask(program, folder, ["check", "study"], (0,))[3]]
    return folder, status, found


PARTS = {"resumes": (resume_cases, try_resume), "studies": (study_cases, try_study),
         "scenes": (scene_cases, try_scene), "profiles": (profile_cases, try_profile),
         "kills": (kill_cases, try_kill), "signals": (signal_cases, try_signal),
         "readers": (reader_cases, try_reader)}


def main():
    parser = argparse.ArgumentParser(description=__doc__,
                                     formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("program")
    parser.add_argument("part", choices=PARTS)
    parser.add_argument("--times", type=int, default=1)
    parser.add_argument("--share", default="1/1")
    parser.add_argument("--seed", type=int, default=1)
    parser.add_argument("--kills", type=int, default=0)
    parser.add_argument("--sanitized", action="store_true",
                        help="the program is: it reserves memory without end")
    options = parser.parse_args()
    resource.setrlimit(resource.RLIMIT_CORE, (0, 0))
    if not options.sanitized:
        # of this program's own children too
        resource.setrlimit(resource.RLIMIT_AS, (MEMORY, MEMORY))
    else:
        global SLOWER
        SLOWER = 6
        CHECKPOINT.update(run="0.02", study="0.002")
    if options.part == "readers":  # which ask Python some hundred times
        with warm_python.started() as path:
            os.environ["PATH"] = path
            sys.exit(attempts(options))
    sys.exit(attempts(options))


def attempts(options):
    """Makes the cases, prints how they ended, and returns the exit status."""
    make, attempt = PARTS[options.part]
    first, of = map(int, options.share.split("/"))
    cases = make(options.times, random.Random(options.seed))[first - 1::of]
    begun, ended, wrong = time.monotonic(), Counter(), 0
    program = os.path.abspath(options.program)
    for case in cases:
        dice = random.Random(hashlib.sha256(case[0].encode(errors="surrogateescape")).digest())
        folder, status, found = attempt(program, case, dice)
        ended[status] += 1
        if found:
            wrong += 1
            print(f"{case[0][:300]!r}:", *found, sep="\n    ", flush=True)
        folder.close()
    endings = ", ".join(f"{count} with {status}"
                        for status, count in sorted(ended.items(), key=str))
    print(f"{options.part} {options.share}: {len(cases)} ended in {time.monotonic() - begun:.1f} "
          f"s: {endings}; "
          f"{wrong} at fault" + "".join(f"; cut off {count} times with {status}"
                                        if status != "went on" else f"; went on {count} times"
                                   for status, count in CUTS.items()))
    too_few = CUTS[128 + signal.SIGKILL] < options.kills or ("went on" in CUTS
                                                             and CUTS["went on"] < len(cases))
    return 1 if wrong or too_few else 0


if __name__ == "__main__":
    main()
