#!/usr/bin/env python3
# SPDX-License-Identifier: BSD-3-Clause
"""Six bumps of a plate by finite elements in three dimensions: writes the input for CalculiX, runs
it, keeps what the case six-bumps compares with.

    six_bumps_calculix.py --input MESH FILE.inp     writes the input of one of the meshes
    six_bumps_calculix.py --run CCX FOLDER [MESH]   runs CalculiX on all meshes or some;
    FOLDER/six-bumps-MESH.csv, six-bumps-frequencies.csv

A rigid block, round below, slides at a given height and speed over six bumps of a plate. The plate
is one layer of solids with twenty nodes and reduced integration (C3D20R). They lock neither in
bending nor in shear, and have no rotations to hold at an edge. Its four edges can turn: they hold
the displacements within the plane of the edge. The block's nodes follow what is imposed. Contact is
surface to surface, its pressure linear in the overclosure with the stiffness kappa of ra2d's
penalty contact. Implicit steps of one length, geometrically nonlinear.

What CalculiX asks for is as in six_shocks_calculix.py: a cube that flies freely, far away and fast,
so that steps are not shortened; 20 characters of a number. The sliding needs no smooth beginning,
as nothing of the block can vibrate.

Its units here are mm, N, s, MPa and tonnes.
"""
import csv
import hashlib
import pathlib

import calculix
import numpy as np

LENGTH, WIDTH, THICKNESS = 0.064, 0.040, 5e-4     # m, of the plate
YOUNG, POISSON, DENSITY = 210e9, 0.3, 7800.0
HEIGHT, PITCH, ROW = 4e-6, 8e-3, 0.016            # m: of a bump, from one to the next, their y
OVERLAP = 1e-7                                    # m, of two summits of a plate at rest
BLOCK = 4e-3                                      # m, side of the block
SPEED, STIFFNESS = 16.0, 1e12                     # m/s, Pa/m
DURATION, START = 3e-3, 8e-3                      # s; m: the block's middle at t = 0
BUMPS = [0.012 + PITCH * i for i in range(6)]     # m, along the plate
PROBE = (0.032, 0.016)                            # m, on the plate: between two bumps

# side of the plate's elements [mm], elements along the block, step [s]
MESHES = {"160-elements-2us": (4, 8, 2e-6),
          "160-elements-4us": (4, 8, 4e-6),
          "160-elements-8us": (4, 8, 8e-6),
          "640-elements-8us": (2, 8, 8e-6),
          "160-elements-8us-fine-block": (4, 16, 8e-6)}
BEST = next(iter(MESHES))  # one that takes minutes; what a finer mesh changes, the last two say
OF_FREQUENCIES, FREQUENCIES = ("160-elements-8us", "640-elements-8us"), 40
COLUMNS = ("time, s", "displacement of the probe, m", "contact force, N",
           "largest contact pressure, Pa")
CURVED = HEIGHT / 2 / (PITCH / 2)**2  # 1/m: a summit at (0, 0) falls by this times x^2 + y^2


def plate_heights(x, y):
    """Heights [m] of the plate's face: paraboloids, each on a square of 8 mm, joined in a row. At
    the square's sides they fall to zero in straight lines over 4 mm more. Elements with sides of 4
    or 2 mm have this face exactly. Nothing touches the straight lines."""
    half = PITCH / 2
    along = (x - BUMPS[0]) / half
    inner = np.clip(along, -1, 11)              # the row of squares
    along_one = (inner + 1) % 2 - 1             # within a square, from -1 to 1
    across = (y - ROW) / half
    outside = np.clip(np.abs(along - inner), 0, 1), np.clip(np.abs(across) - 1, 0, 1)
    top = 1 - (along_one**2 + np.clip(across, -1, 1)**2) / 2
    return HEIGHT * top * (1 - outside[0]) * (1 - outside[1])


def block_heights(x, y):
    """Heights [m] of the block's face over its middle, down; those of one bump."""
    return HEIGHT - CURVED * (x**2 + y**2)


class Mesh:
    def __init__(self):
        self.nodes, self.elements, self.of = [], [], {}

    def node(self, key, place):
        if key not in self.of:
            self.nodes.append(place)
            self.of[key] = len(self.nodes)
        return self.of[key]

    def layer(self, name, at, sides, counts, below, above, thickness):
        """One layer of so many elements along x and y: nodes (name, 2 i, 2 j, 0 to 2) of the
        element (i, j); its faces lie at below(x, y) and above(x, y) [m] from a layer of that
        thickness on z = at[2]."""
        def place(i, j, k):
            x, y = (at[n] + sides[n] * number / (2 * counts[n]) for n, number in enumerate((i, j)))
            low, high = below(x, y), thickness + above(x, y)
            return self.node((name, i, j, k), (x, y, at[2] + low + (high - low) * k / 2))
        corners = ((0, 0), (2, 0), (2, 2), (0, 2))
        middles = ((1, 0), (2, 1), (1, 2), (0, 1))
        faces = {}
        for i in range(counts[0]):
            for j in range(counts[1]):
                order = [(a, b, k) for part, levels in ((corners, (0, 2)), (middles, (0, 2)),
                                                        (corners, (1,)))
                         for k in levels for a, b in part]
                self.elements.append([place(2 * i + a, 2 * j + b, k) for a, b, k in order])
                faces[i, j] = len(self.elements)
        return faces

    def chosen(self, name, which):
        return [number for key, number in self.of.items() if key[0] == name and which(*key[1:])]


def of_set(name, numbers):
    return [f"*NSET,NSET={name}",
            *(",".join(map(str, numbers[i:i + 12])) for i in range(0, len(numbers), 12))]


def input_text(mesh, frequencies=0):
    """The run of a mesh, or so many of its natural frequencies."""
    side, of_block, step = MESHES[mesh]
    made = Mesh()
    along, across = round(1e3 * LENGTH / side), round(1e3 * WIDTH / side)

    def flat(x, y):
        return 0.0
    plate = made.layer("plate", (0, 0, 0), (LENGTH, WIDTH), (along, across), flat,
                       lambda x, y: float(plate_heights(x, y)), THICKNESS)
    of_plate = len(made.elements)
    block = made.layer("block", (START - BLOCK / 2, ROW - BLOCK / 2,
                                 THICKNESS + 2 * HEIGHT - OVERLAP), (BLOCK, BLOCK),
                       (of_block, of_block), lambda x,
                       y: -float(block_heights(x - START, y - ROW)), flat, 1e-3)
    of_both = len(made.elements)
    lines = ["** Six bumps, made by bench/validation/six_bumps_calculix.py; mm, N, s, MPa, t",
             "*NODE,NSET=BODIES"]
    lines += [",".join([str(i), *(f"{1e3 * each:.12g}" for each in place)])
              for i, place in enumerate(made.nodes, 1)]
    for name, first, last in (("PLATE", 0, of_plate), ("BLOCK", of_plate, of_both)):
        lines.append(f"*ELEMENT,TYPE=C3D20R,ELSET={name}")
        for i in range(first, last):
            words = [str(i + 1), *map(str, made.elements[i])]
            lines += [",".join(words[:11]) + ",", ",".join(words[11:])]
    flying = len(made.nodes) + np.arange(1, 9)
    lines.append("*NODE,NSET=FLYING")
    lines += [f"{number},{500 + x},{500 + y},{z}" for number, (x, y, z) in zip(flying, (
        (0, 0, 0), (1, 0, 0), (1, 1, 0), (0, 1, 0), (0, 0, 1), (1, 0, 1), (1, 1, 1), (0, 1, 1)))]
    lines += ["*ELEMENT,TYPE=C3D8,ELSET=FLYING", ",".join(map(str, [of_both + 1, *flying])),
              "*MATERIAL,NAME=STEEL", "*ELASTIC", f"{1e-6 * YOUNG:.9g},{POISSON}", "*DENSITY",
              f"{1e-12 * DENSITY:.9g}"]
    lines += [f"*SOLID SECTION,ELSET={name},MATERIAL=STEEL"
              for name in ("PLATE", "BLOCK", "FLYING")]
    lines += of_set("ENDS", made.chosen("plate", lambda i, j, k: i in (0, 2 * along)))
    lines += of_set("SIDES", made.chosen("plate", lambda i, j, k: j in (0, 2 * across)))
    lines += of_set("SLIDING", made.chosen("block", lambda i, j, k: True))
    probe = [round(2e3 * place / side) for place in PROBE]
    lines += of_set("PROBE", made.chosen("plate", lambda i, j, k: [i, j] == probe and k == 0))
    if frequencies:
        return "\n".join([*lines, "*BOUNDARY", "ENDS,2,3,0.", "SIDES,1,1,0.", "SIDES,3,3,0.",
                          "SLIDING,1,3,0.", "FLYING,1,3,0.",
                          "*STEP", "*FREQUENCY", str(frequencies), "*NODE PRINT,NSET=PROBE", "U",
                          "*END STEP"]) + "\n"
    lines += ["*INITIAL CONDITIONS,TYPE=VELOCITY", "FLYING,2,1e8", f"SLIDING,1,{1e3 * SPEED:.9g}"]
    lines += ["*SURFACE,NAME=MASTER", *(f"{number},S2" for (i, j), number in plate.items()
                                        if abs((j + 0.5) * side * 1e-3 - ROW) < PITCH / 2),
              "*SURFACE,NAME=SLAVE", *(f"{number},S1" for number in block.values()),
              "*SURFACE INTERACTION,NAME=CONTACT", "*SURFACE BEHAVIOR,PRESSURE-OVERCLOSURE=LINEAR",
              f"{1e-9 * STIFFNESS:.9g}",
              "*CONTACT PAIR,INTERACTION=CONTACT,TYPE=SURFACE TO SURFACE", "SLAVE,MASTER",
              "*BOUNDARY", "ENDS,2,3,0.", "SIDES,1,1,0.", "SIDES,3,3,0.", "SLIDING,2,3,0.",
              "*AMPLITUDE,NAME=SLIDE", f"0.,0.,1.,{1e3 * SPEED:.9g}",
              "*STEP,NLGEOM,INC=100000", "*DYNAMIC,DIRECT", f"{step:.9g},{DURATION:.9g}",
              "*BOUNDARY,AMPLITUDE=SLIDE", "SLIDING,1,1,1.", "*NODE PRINT,NSET=PROBE", "U",
              "*CONTACT PRINT,SLAVE=SLAVE,MASTER=MASTER", "CF", "*CONTACT PRINT", "CDIS,CSTR",
              "*END STEP"]
    return "\n".join(lines) + "\n"


def mark(text):
    """What tells an input from another one."""
    return hashlib.sha256(text.encode()).hexdigest()[:16]


def kept(text):
    """Rows of COLUMNS of what CalculiX has printed."""
    return [(now, 1e-3 * float(moved[2]), float(force[2]), 1e6 * pressure)
            for now, moved, force, pressure in calculix.increments(text, DURATION)]


def natural(ccx, folder):
    """Keeps the natural frequencies of the plate as the meshes have it."""
    columns = []
    for mesh in OF_FREQUENCIES:
        lines = calculix.solve(ccx,
                               input_text(mesh,
                                          FREQUENCIES))[0].split("P A R T I C I P")[0].splitlines()
        columns.append([line.split()[3] for line in lines if len(line.split()) == 5
                        and line.split()[0].isdigit()])
    with open(folder / "six-bumps-frequencies.csv", "w", newline="") as file:
        csv.writer(file,
                   lineterminator="\n").writerows([[f"{mesh}: frequency, Hz"
                                                    for mesh in OF_FREQUENCIES],
                                                   *zip(*columns, strict=True)])


def run(ccx, mesh, folder):
    text = input_text(mesh)
    printed, seconds, _ = calculix.solve(ccx, text)
    rows = kept(printed)
    with open(folder / f"six-bumps-{mesh}.csv", "w", newline="") as file:
        write = csv.writer(file, lineterminator="\n")
        write.writerow([f"# {mesh}: {seconds:.0f} s of processor time; input {mark(text)}; "
                        f"CalculiX {calculix.version(ccx)}"])
        write.writerow(COLUMNS)
        write.writerows([f"{value:.6g}" for value in row] for row in rows)


def main():
    options = calculix.requested("Six bumps of a plate by CalculiX.", MESHES)
    if options.input:
        pathlib.Path(options.input[1]).write_text(input_text(options.input[0]))
    if options.run:
        natural(options.run[0], pathlib.Path(options.run[1]))
        for mesh in options.meshes:  # one after the other: each takes minutes of one core
            run(options.run[0], mesh, pathlib.Path(options.run[1]))


if __name__ == "__main__":
    main()
