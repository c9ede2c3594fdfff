#!/usr/bin/env python3
# SPDX-License-Identifier: BSD-3-Clause
"""An areal scene: a round, rigid block passes six bumps of a plate, beside finite elements in three
dimensions.

six_bumps_calculix.py has the numbers of the scene and what CalculiX makes of it. That takes
minutes, so its results are kept in docs/validation/six-bumps-*.csv, and all forms compare with
these.

What CalculiX itself is in doubt by is seen where its step is twice as long, its elements half as
wide, or those of the block. ra2d's own doubt is seen in twice the modes and twice the spacing. Both
must agree within the sum of these: differences observed in this scene, no bounds from theory.

By theory shear and rotary inertia part the two as well: ra2d's plate is Kirchhoff's. How far, a few
lines say: the same modes and contact, marched on their own with the frequencies of either theory
(Mindlin's for four such edges, in closed form). In CalculiX two things work against them. Wide
elements make fast modes too fast, and the bumps stiffen the plate, as they are of its steel (the
first mode by 0.14 %). So the few lines also take CalculiX's own natural frequencies.
"""
import csv

import numpy as np

import common
from six_bumps_calculix import (BEST, BLOCK, BUMPS, DENSITY, DURATION, HEIGHT, LENGTH, MESHES,
                                OF_FREQUENCIES, OVERLAP, PITCH,
                                POISSON, PROBE, ROW, SPEED, START, STIFFNESS, THICKNESS, WIDTH,
                                YOUNG, block_heights, input_text, mark,
                                plate_heights)

MODES, MORE = 100, 200
SPACING, COARSE = 4e-5, 8e-5          # m, of nodes
TOLERANCE = 1e-9
HALF = 1.5e-3                         # s: the first three bumps, of the short form
OWN_SPACING = "its spacing: 80 um instead of 40"
NATURAL = 30
SHEAR = "shear and rotary inertia, by theory"
BENDING = YOUNG * THICKNESS**3 / 12 / (1 - POISSON**2)
LONG, FINE, BLOCKS, LONGEST = ("160-elements-4us", "640-elements-8us",
                               "160-elements-8us-fine-block", "160-elements-8us")


def rows_of(spacing, length):
    """Places of rows: in the middles of strips."""
    return spacing * (np.arange(round(length / spacing)) + 0.5)


def scene(case, modes, spacing, duration, rate):
    y = ROW - BLOCK / 2 + rows_of(spacing, BLOCK)[:, None]
    x = spacing * np.arange(round(LENGTH / spacing) + 1)
    plate = plate_heights(x, y)
    block = block_heights(spacing * np.arange(round(BLOCK / spacing) + 1) - BLOCK / 2, y - ROW)
    np.save(case.scratch / "plate.npy", plate)
    np.save(case.scratch / "block.npy", block)

    def surface(name):
        return {"kind": "file", "path": f"{name}.npy", "spacing": spacing, "spacing_y": spacing}

    return {
        "scene": {"kind": "areal", "duration": duration, "speed": SPEED, "start": START - BLOCK / 2,
                  "side": ROW - BLOCK / 2,
                  "gap": 2 * HEIGHT - OVERLAP - plate.mean() - block.mean(), "spacing": spacing,
                  "initial": "rest"},
        "resonator": {"support": "pinned", "length": LENGTH, "width": WIDTH, "thickness": THICKNESS,
                      "young": YOUNG,
                      "poisson": POISSON, "density": DENSITY, "damping": 0.0, "modes": modes,
                      "surface": surface("plate")},
        "slider": {"support": "rigid", "length": BLOCK, "width": BLOCK,
                   "surface": surface("block")},
        "contact": {"law": "penalty", "stiffness": STIFFNESS},
        "time": {"scheme": "adaptive", "tolerance": TOLERANCE},
        "output": {"rate": rate, "probes": [list(PROBE)]},
    }


def marched(case, modes=MODES, spacing=SPACING, duration=DURATION, rate=1e6):
    """The columns of six-bumps-*.csv. The largest pressure is that of ra2d's displacements at
    points COARSE apart."""
    time, probe, force, plate = case.run(scene(case, modes, spacing, duration, rate), "time",
                                         "probes/displacement", "contact/force",
                                         "resonator/displacement")
    pressure = np.zeros_like(time)
    meeting = Meeting(False, modes, COARSE)
    for i in np.flatnonzero(force):
        pressure[i] = meeting.pressure(time[i], plate[i]).max()
    return np.column_stack([time, probe[:, 0], force, pressure])


def chosen_modes(count):
    """Half-waves (m, n) along x and y of the lowest modes; of one frequency first that with fewer
    along x, as in ra2d. In whole numbers, so that equal frequencies are equal."""
    m, n = np.mgrid[1:60, 1:60].reshape(2, -1)
    lowest = np.argsort((m * round(1e3 * WIDTH))**2 + (n * round(1e3 * LENGTH))**2,
                        kind="stable")[:count]
    return m[lowest], n[lowest]


def theory(wave, shear):
    """Natural frequencies [1/s] and masses [kg/m^2] of modes of such wave numbers, with shear and
    rotary inertia or without: on edges that hold the displacements within their plane, Mindlin's
    plate has the sines of Kirchhoff's. Shear coefficient: 5/(6 - nu)."""
    mass, r2 = DENSITY * THICKNESS, THICKNESS**2 / 12
    if not shear:
        return np.sqrt(BENDING / mass) * wave**2, np.full(len(wave), mass)
    stiff, plane = 5 / (6 - POISSON) * YOUNG / (2 * (1 + POISSON)), YOUNG / (1 - POISSON**2)
    a, b, c = DENSITY * r2 / stiff, 1 + r2 * wave**2 * (1
                                                        + plane
                                                        / stiff), plane * r2 * wave**4 / DENSITY
    square = (b - np.sqrt(b**2 - 4 * a * c)) / (2 * a)
    turn = wave - DENSITY * square / (stiff * wave)  # of the cross section, over the deflection
    return np.sqrt(square), mass * (1 + r2 * turn**2)


class Meeting:
    """The plate's modes and the contact with the block, whose face has points in the middles of
    squares of side `spacing`."""

    def __init__(self, shear, count, spacing):
        self.m, self.n = chosen_modes(count)
        self.omega, self.mass = theory(np.pi * np.hypot(self.m / LENGTH, self.n / WIDTH), shear)
        self.place, self.area = rows_of(spacing, BLOCK) - BLOCK / 2, spacing**2
        self.block = block_heights(self.place[:, None], self.place)
        self.across = self.sines(self.n, WIDTH, ROW + self.place)
        self.probe = (self.sines(self.m, LENGTH,
                                 PROBE[:1]) * self.sines(self.n, WIDTH, PROBE[1:]))[0]

    @staticmethod
    def sines(waves, length, x):
        return np.sqrt(2 / length) * np.sin(np.outer(x, waves) * np.pi / length)

    def set(self, time):
        """The gap of a plate at rest, and the modes' factors along x; None far from any summit."""
        x = START + SPEED * time
        if min(abs(x - at) for at in BUMPS) > 0.45 * PITCH:
            return None
        place = x + self.place
        return (2 * HEIGHT - OVERLAP - self.block - plate_heights(place[:, None], ROW + self.place),
                self.sines(self.m, LENGTH, place))

    def pressure(self, time, u):
        found = self.set(time)
        if found is None:
            return np.zeros((1, 1))
        gap, along = found
        return STIFFNESS * np.maximum(0, (along * u) @ self.across.T - gap)

    def load(self, time, pressure):
        """The force on each mode over the area's root."""
        found = self.set(time)
        return 0 if found is None else self.area * np.einsum("im,ij,jm->m", found[1], pressure,
                                                             self.across, optimize=True)

    def row(self, time, u, pressure):
        return time, self.probe @ u, self.area * pressure.sum(), pressure.max()


def by_hand(shear, step=4e-7, spacing=COARSE, lowest=()):
    """The columns of six-bumps-*.csv: modes turn exactly over a step, forces are blows between.
    `lowest`: natural frequencies [1/s] of the lowest modes in place of those of the theory."""
    meeting = Meeting(shear, MODES, spacing)
    omega = meeting.omega
    omega[:len(lowest)] = lowest
    cosine, sine = np.cos(omega * step), np.sin(omega * step)
    u, v = np.zeros((2, MODES))
    found = []
    for time in step * np.arange(round(DURATION / step)):
        pressure = meeting.pressure(time, u)
        if pressure.any():
            v = v - step * meeting.load(time, pressure) / meeting.mass
        found.append(meeting.row(time, u, pressure))
        u, v = cosine * u + sine / omega * v, cosine * v - omega * sine * u
    return np.array(found)


def touched(time, force):
    """How long a force is over a tenth of its largest, straight between samples [s]."""
    level = force.max() / 10
    over = np.flatnonzero(force > level)
    ends = []
    for inside, outside in ((over[0], over[0] - 1), (over[-1], over[-1] + 1)):
        ends.append(np.interp(level, force[[outside, inside]], time[[outside, inside]]))
    return ends[1] - ends[0]


def shocks(found):
    """Of each bump that is passed: time of the impulse's centre [s], impulse [N s], duration [s],
    largest pressure [Pa]."""
    rows = []
    for at in (at for at in BUMPS if START + SPEED * found[-1, 0] > at + 0.45 * PITCH):
        part = found[np.abs(START + SPEED * found[:, 0] - at) <= PITCH / 2]
        time, force = part[:, 0], part[:, 2]
        impulse = np.trapz(force, time)
        rows.append((np.trapz(force * time, time) / impulse, impulse, touched(time, force),
                     part[:, 3].max()))
    return np.array(rows)


def calculix(mesh):
    """What CalculiX has found, and what its file says of the run."""
    with open(common.ROOT / "docs" / "validation" / f"six-bumps-{mesh}.csv") as file:
        (note,), _, *rows = csv.reader(file)
    return np.array(rows, dtype=float), note


MEASURES = ("times, s", "impulses, over the largest", "durations, s",
            "largest pressures, over their own",
            "displacement of the probe, over the largest")


def differences(first, second):
    """One of each of MEASURES: the largest over the shocks."""
    ours, peer = shocks(first), shocks(second)
    off = np.abs(ours - peer)
    moved = np.abs(np.interp(second[:, 0], first[:, 0], first[:, 1])
                   - second[:, 1]).max() / np.abs(second[:, 1]).max()
    return (off[:, 0].max(), off[:, 1].max() / peer[:, 1].max(), off[:, 2].max(),
            (off[:, 3] / peer[:, 3]).max(), moved)


def sum_of(pairs):
    """The sum of what each pair differs by, of each of MEASURES."""
    return np.sum([differences(*pair) for pair in pairs], axis=0)


def compare(case):
    strange = [mesh for mesh in MESHES
               if f"input {mark(input_text(mesh))};" not in calculix(mesh)[1]]
    case.check("CalculiX: meshes whose kept results are of another input", len(strange), 0.5,
               "the results are of this scene")
    best, long, longest, fine, blocks = (calculix(mesh)[0]
                                         for mesh in (BEST, LONG, LONGEST, FINE, BLOCKS))
    causes = {"CalculiX's step: 4 us instead of 2": (long, best),
              "its plate's elements: 2 mm instead of 4": (fine, longest),
              "its block's elements: 0.25 mm instead of 0.5": (blocks, longest)}
    if case.short:
        found = marched(case, spacing=1e-4, duration=HALF, rate=2.5e5)
        check(case, found, best[best[:, 0] < HALF],
              {what: [each[each[:, 0] < HALF] for each in pair] for what, pair in causes.items()})
        return
    found = marched(case)
    causes |= {"ra2d's modes: 200 instead of 100": (marched(case, MORE), found),
               OWN_SPACING: (marched(case, spacing=COARSE), found)}
    check(case, found, best, causes)
    kirchhoff = by_hand(False)
    rough = differences(by_hand(False, step=8e-7, spacing=2 * COARSE), kirchhoff)
    coarser = differences(*causes[OWN_SPACING])
    for what, ours, step, spacing in zip(MEASURES, differences(found, kirchhoff), rough, coarser):
        case.check(f"ra2d beside the same modes by hand: {what}", ours, step + spacing,
                   "what these move with twice their step and spacing, and ra2d with twice its own")
    report(case, found, best, causes, {
        "Kirchhoff's frequencies": kirchhoff, "with shear and rotary inertia": by_hand(True),
        f"of CalculiX's {NATURAL} lowest modes": by_hand(False,
                                                         lowest=2 * np.pi
                                                         * natural_frequencies()[:, 0])})


def check(case, found, best, causes):
    for what, ours, most in zip(MEASURES, differences(found, best), sum_of(causes.values())):
        case.check(f"ra2d beside CalculiX: {what}", ours, most,
                   "what the mesh and step of either move")


def in_words(found):
    """The differences as a table has them."""
    times, impulses, durations, pressures, displaced = found
    return [common.shown(each) for each in (1e6 * times, 100 * impulses, 1e6 * durations,
                                            100 * pressures, 100 * displaced)]


def report(case, found, best, causes, theories):
    kirchhoff, shear, natural = theories.values()
    for name, each in (("", differences(found, best)), ("own-", sum_of(causes.values())),
                       ("shear-", differences(shear, kirchhoff)),
                       ("with-shear-", differences(shear, best)),
                       ("natural-", differences(natural, best))):
        for measure, value in zip(("times", "impulses", "durations", "pressures", "displacement"),
                                  in_words(each)):
            case.text(name + measure, value)
    rows = []
    ours, peers = shocks(found), shocks(best)
    for i, (own, peer) in enumerate(zip(ours, peers)):
        rows.append((i + 1, f"{1e6 * peer[0]:.1f}", f"{1e6 * (own[0] - peer[0]):+.1f}",
                     f"{1e6 * peer[1]:.3f}",
                     f"{100 * (own[1] / peer[1] - 1):+.1f}", f"{1e6 * peer[2]:.1f}",
                     f"{1e6 * (own[2] - peer[2]):+.1f}",
                     f"{1e-3 * peer[3]:.1f}", f"{100 * (own[3] / peer[3] - 1):+.1f}"))
    case.text("shocks", common.markdown(
        ("bump", "CalculiX: time, us", "ra2d, us", "CalculiX: impulse, uN s", "ra2d, %",
         "CalculiX: duration, us", "ra2d, us",
         "CalculiX: largest pressure, kPa", "ra2d, %"), rows))
    head = ("", "times, us", "impulses, %", "durations, us", "pressures, %", "displacement, %")
    case.text("causes", common.markdown(head, [(what, *in_words(differences(*pair)))
                                               for what, pair in (causes
                                                                  | {SHEAR:
                                                                     (shear, kirchhoff)}).items()]))
    case.text("theories",
              common.markdown(("the modes by hand",
                               *(f"from CalculiX: {word}" for word in head[1:])), [
        (what, *in_words(differences(each, best))) for what, each in theories.items()]))
    case.text("peers",
              common.markdown(("CalculiX", *(f"from ra2d: {word}" for word in head[1:]),
                               "takes, s"), [
        (mesh.replace("-", " ").replace("us", " us"), *in_words(differences(found, peer)),
         note.split()[2])
        for mesh, (peer, note) in ((mesh, calculix(mesh)) for mesh in MESHES)]))
    notes = [calculix(mesh)[1] for mesh in MESHES]
    case.text("peer-minutes", f"{sum(float(note.split()[2]) for note in notes) / 60:.0f}")
    case.text("version", notes[0].split()[-1])
    case.text("elements", BEST.split("-")[0])
    case.text("shortest", 1e6 * peers[:, 2].min())
    case.text("longest", 1e6 * peers[:, 2].max())
    of_frequencies(case)
    case.table(("bump", *(f"{name}: {what}" for name in ("ra2d", "calculix")
                          for what in ("time, s", "impulse, N s", "duration, s",
                                       "largest pressure, Pa"))),
               [(i + 1, *ours[i], *peers[i]) for i in range(len(BUMPS))])
    draw(case, found, best)


def natural_frequencies():
    """The lowest natural frequencies [Hz] of the plate as CalculiX's meshes have it. Beyond NATURAL
    modes their order may be another one than Kirchhoff's."""
    path = common.ROOT / "docs" / "validation" / "six-bumps-frequencies.csv"
    return np.loadtxt(path, delimiter=",", skiprows=1)[:NATURAL]


def of_frequencies(case):
    """How far natural frequencies are from Kirchhoff's, in both meshes and by theory with shear;
    those of one mode by their order."""
    meshes = natural_frequencies()
    m, n = chosen_modes(len(meshes))
    plain, shear = (theory(np.pi * np.hypot(m / LENGTH, n / WIDTH), each)[0] / 2 / np.pi
                    for each in (False, True))
    rows = []
    for i in (0, 9, 19, 29):
        rows.append((f"{m[i]}, {n[i]}", f"{1e-3 * plain[i]:.2f}",
                     *(f"{100 * (each / plain[i] - 1):+.2f}" for each in (shear[i], *meshes[i]))))
    case.text("frequencies", common.markdown(
        ("half-waves", "Kirchhoff, kHz", "with shear, %",
         *(f"{mesh.rsplit('-', 1)[0].replace('-', ' ')}, %"
           for mesh in OF_FREQUENCIES)), rows))
    for name, column in (("shear", shear), ("coarse", meshes[:, 0]), ("fine", meshes[:, 1])):
        case.text(f"frequency-{name}", f"{100 * (column[-1] / plain[-1] - 1):+.2f}")
    case.text("frequency", f"{1e-3 * plain[-1]:.0f}")


def draw(case, found, best):
    plt, style = common.pyplot()
    figure = plt.figure(figsize=(7, 5.4), layout="constrained")
    grid = figure.add_gridspec(2, len(BUMPS))
    axes = figure.add_subplot(grid[0, :])
    lines = ((best, "CalculiX", style.BLACK, "-", 1.8), (found, "ra2d", style.SKY, "-", 1.0))
    for each, label, colour, line, width in lines:
        part = each[::max(1, len(each) // 750)]
        axes.plot(1e3 * part[:, 0], 1e9 * part[:, 1], color=colour, ls=line, lw=width, label=label)
    axes.set(title="Displacement of the plate's probe", xlabel="ms", ylabel="nm")
    axes.legend(loc="upper left", ncols=2)
    first = None
    for i, (time, *_) in enumerate(shocks(best)):
        first = axes = figure.add_subplot(grid[1, i], sharey=first)
        for each, _, colour, line, width in lines:
            part = each[np.abs(each[:, 0] - time) < 120e-6]
            axes.plot(1e6 * (part[:, 0] - time), 1e3 * part[:, 2], color=colour, ls=line, lw=width)
        axes.set(xlim=(-120, 120), xticks=(-80, 0, 80), title=f"{1e3 * time:.2f} ms")
        axes.tick_params(labelleft=i == 0)
        if i == 0:
            axes.set(ylabel="contact force, mN", xlabel="us")
    case.figure(figure)


if __name__ == "__main__":
    common.main("six-bumps", compare)
