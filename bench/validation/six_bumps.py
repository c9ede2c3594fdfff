#!/usr/bin/env python3
# SPDX-License-Identifier: BSD-3-Clause
"""An areal scene: a round, rigid block passes six bumps of a plate, beside finite elements in three
dimensions.

six_bumps_calculix.py has the numbers of the scene and what CalculiX makes of it. That takes
minutes, so its results are kept in docs/validation/six-bumps-*.csv, and all forms compare with
these.

Two things part the two by theory: ra2d's plate is Kirchhoff's, without shear and rotary inertia,
and the implicit steps of CalculiX (Hilber, Hughes and Taylor) lower and damp higher modes. A few
lines here march the same modes and contact on their own, with the frequencies of either theory
(Mindlin's for four such edges, in closed form), exactly or in those steps. These are differences
observed in this scene, no bounds. What is checked of the explanation is its direction: a plate with
shear, in CalculiX's steps, must come nearer to CalculiX than ra2d's.
"""
import csv

import numpy as np

import common
from six_bumps_calculix import (BEST, BLOCK, BUMPS, DENSITY, DURATION, HEIGHT, LENGTH, MESHES, OVERLAP, PITCH, POISSON, PROBE, ROW,
                                SPEED, START, STIFFNESS, THICKNESS, WIDTH, YOUNG, block_heights, input_text, mark, plate_heights)

MODES, MORE, FEW = 100, 200, 50
SPACING, COARSE = 4e-5, 8e-5          # m, of nodes
TOLERANCE = 1e-9
UNAMBIGUOUS = 120                     # modes, below the first two of one frequency
BENDING = YOUNG * THICKNESS**3 / 12 / (1 - POISSON**2)
COARSE_STEP, FINE_MESH, FINE_CONTACT = "160-elements-4us", "640-elements-4us", "160-elements-4us-block-16"


def rows_of(spacing, length):
    """Places of rows: in the middles of strips."""
    return spacing * (np.arange(round(length / spacing)) + 0.5)


def scene(case, modes, spacing, tolerance):
    y = ROW - BLOCK / 2 + rows_of(spacing, BLOCK)[:, None]
    x = spacing * np.arange(round(LENGTH / spacing) + 1)
    plate = plate_heights(x, y)
    block = block_heights(spacing * np.arange(round(BLOCK / spacing) + 1) - BLOCK / 2, y - ROW)
    np.save(case.scratch / "plate.npy", plate)
    np.save(case.scratch / "block.npy", block)

    def surface(name):
        return {"kind": "file", "path": f"{name}.npy", "spacing": spacing, "spacing_y": spacing}

    return {
        "scene": {"kind": "areal", "duration": DURATION, "speed": SPEED, "start": START - BLOCK / 2, "side": ROW - BLOCK / 2,
                  "gap": 2 * HEIGHT - OVERLAP - plate.mean() - block.mean(), "spacing": spacing, "initial": "rest"},
        "resonator": {"support": "pinned", "length": LENGTH, "width": WIDTH, "thickness": THICKNESS, "young": YOUNG,
                      "poisson": POISSON, "density": DENSITY, "damping": 0.0, "modes": modes, "surface": surface("plate")},
        "slider": {"support": "rigid", "length": BLOCK, "width": BLOCK, "surface": surface("block")},
        "contact": {"law": "penalty", "stiffness": STIFFNESS},
        "time": {"scheme": "adaptive", "tolerance": tolerance},
        "output": {"rate": 1e6, "probes": [list(PROBE)]},
    }


def marched(case, modes=MODES, spacing=SPACING, tolerance=TOLERANCE):
    """The columns of six-bumps-*.csv. The largest pressure is at the summits' nodes alone."""
    time, probe, force, plate = case.run(scene(case, modes, spacing, tolerance), "time", "probes/displacement", "contact/force",
                                         "resonator/displacement")
    pressure = np.zeros_like(time)
    if modes <= UNAMBIGUOUS:
        meeting = Meeting(False, modes, COARSE)
        for i in np.flatnonzero(force):
            pressure[i] = meeting.pressure(time[i], plate[i]).max()
    return np.column_stack([time, probe[:, 0], force, pressure])


def chosen_modes(count):
    """Half-waves (m, n) along x and y of the lowest modes."""
    m, n = np.mgrid[1:60, 1:60].reshape(2, -1)
    lowest = np.argsort((m / LENGTH)**2 + (n / WIDTH)**2, kind="stable")[:count]
    return m[lowest], n[lowest]


def theory(wave, shear):
    """Natural frequencies [1/s] and masses [kg/m^2] of modes of such wave numbers, with shear and
    rotary inertia or without: on edges that hold the displacements within their plane, Mindlin's
    plate has the sines of Kirchhoff's. Shear coefficient: 5/(6 - nu)."""
    mass, r2 = DENSITY * THICKNESS, THICKNESS**2 / 12
    if not shear:
        return np.sqrt(BENDING / mass) * wave**2, np.full(len(wave), mass)
    stiff, plane = 5 / (6 - POISSON) * YOUNG / (2 * (1 + POISSON)), YOUNG / (1 - POISSON**2)
    a, b, c = DENSITY * r2 / stiff, 1 + r2 * wave**2 * (1 + plane / stiff), plane * r2 * wave**4 / DENSITY
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
        self.probe = (self.sines(self.m, LENGTH, PROBE[:1]) * self.sines(self.n, WIDTH, PROBE[1:]))[0]

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
        return 0 if found is None else self.area * np.einsum("im,ij,jm->m", found[1], pressure, self.across, optimize=True)

    def row(self, time, u, pressure):
        return time, self.probe @ u, self.area * pressure.sum(), pressure.max()


def by_hand(shear, step=4e-7, spacing=COARSE):
    """The columns of six-bumps-*.csv: modes turn exactly over a step, forces are blows between."""
    meeting = Meeting(shear, MODES, spacing)
    omega = meeting.omega
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


def in_steps(step, spacing=COARSE, alpha=-0.05):
    """The same with shear, modes and contact in the implicit steps of CalculiX."""
    meeting = Meeting(True, MODES, spacing)
    omega, mass = meeting.omega, meeting.mass
    beta, gamma = (1 - alpha)**2 / 4, 0.5 - alpha
    share = (1 + alpha) * beta * step**2
    u, v, a, force = np.zeros((4, MODES))
    found = []
    for time in step * np.arange(round(DURATION / step) + 1):
        ahead, new, last = u + step * v + (0.5 - beta) * step**2 * a, a, force
        for _ in range(50):  # Newton's
            u = ahead + beta * step**2 * new
            pressure = meeting.pressure(time, u)
            force = mass * omega**2 * u
            stiff = np.diag(mass * (1 + share * omega**2))
            if pressure.any():
                force = force + meeting.load(time, pressure)
                i, j = np.nonzero(pressure)
                touching = meeting.set(time)[1][i] * meeting.across[j]
                stiff = stiff + share * STIFFNESS * meeting.area * touching.T @ touching
            change = np.linalg.solve(stiff, mass * new + (1 + alpha) * force - alpha * last)
            new = new - change
            if np.abs(change).max() <= 1e-9 * np.abs(new).max():
                break
        v, a = v + step * ((1 - gamma) * a + gamma * new), new
        found.append(meeting.row(time, u, pressure))
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
    """Of each bump: time of the impulse's centre [s], impulse [N s], duration [s], largest pressure
    [Pa]."""
    rows = []
    for at in BUMPS:
        part = found[np.abs(START + SPEED * found[:, 0] - at) <= PITCH / 2]
        time, force = part[:, 0], part[:, 2]
        impulse = np.trapz(force, time)
        rows.append((np.trapz(force * time, time) / impulse, impulse, touched(time, force), part[:, 3].max()))
    return np.array(rows)


def calculix(mesh):
    """What CalculiX has found, and what its file says of the run."""
    with open(common.ROOT / "docs" / "validation" / f"six-bumps-{mesh}.csv") as file:
        (note,), _, *rows = csv.reader(file)
    return np.array(rows, dtype=float), note


MEASURES = ("times, s", "impulses, over the largest", "durations, s", "largest pressures, over their own",
            "displacement of the probe, over the largest")


def differences(first, second):
    """One of each of MEASURES: the largest over the shocks."""
    ours, peer = shocks(first), shocks(second)
    off = np.abs(ours - peer)
    moved = np.abs(np.interp(second[:, 0], first[:, 0], first[:, 1]) - second[:, 1]).max() / np.abs(second[:, 1]).max()
    return off[:, 0].max(), off[:, 1].max() / peer[:, 1].max(), off[:, 2].max(), (off[:, 3] / peer[:, 3]).max(), moved
