#!/usr/bin/env python3
# SPDX-License-Identifier: BSD-3-Clause
"""The six shocks by plane-strain finite elements: writes the input for CalculiX, runs it, keeps
what the case six-shocks compares with.

    six_shocks_calculix.py --input MESH FILE.inp     writes the input of one of the meshes
    six_shocks_calculix.py --run CCX FOLDER [MESH]   runs CalculiX on all meshes or one;
    FOLDER/six-shocks-MESH.csv, .inp

Triangles with six nodes (CPE6), as in the paper; geometrically nonlinear; surface-to-surface
contact, its pressure linear in the overclosure with the stiffness kappa of ra2d's penalty contact;
implicit steps of one length. What CalculiX asks for:

- Initial velocities do not reach plane elements, which it expands into solid ones. So the sliding
  begins smoothly, before the time that counts.
- It shortens its steps where energy appears from nowhere, and it leaves out the work of imposed
  displacements. A block that flies freely, far away and fast, makes the energy so large that
  nothing is noticed.
- It reads 20 characters of a number.

Its units here are mm, N, s, MPa and tonnes.
"""
import concurrent.futures
import csv
import os
import pathlib

import calculix
import numpy as np

RESONATOR, SLIDER, THICKNESS, WIDTH = 0.05, 0.02, 5e-4, 0.01  # m
YOUNG, POISSON, DENSITY = 210e9, 0.3, 7800.0
SPEED, PITCH, HEIGHT, HALF_WIDTH = 6.0, 5e-3, 1e-6, 2e-3      # m/s, m, m, m
OVERLAP = 1e-7                                                # m, of two summits of beams at rest
STIFFNESS = 1e12                                              # Pa/m
# m: from the first peak to the summit at t = 0
BEFORE = 2.5e-3
DURATION = 4.75e-3                                            # s
PEAKS = [SLIDER / 2 + BEFORE + PITCH * i for i in range(6)]   # m, along the resonator
STARTING = 1e-3                                               # s, in which the sliding begins

# elements along the resonator, along the slider, through the thickness; step [s]
MESHES = {"280-elements-1us": (100, 40, 1, 1e-6),
          "720-elements-2us": (100, 80, 2, 2e-6),
          "720-elements-4us": (100, 80, 2, 4e-6),
          "280-elements-2us": (100, 40, 1, 2e-6),
          "280-elements-4us": (100, 40, 1, 4e-6)}
BEST = next(iter(MESHES))  # steps matter more than the mesh
MESH_ALONE = ("280-elements-4us", "720-elements-4us")
COLUMNS = ("time, s", "displacement of the summit, m", "contact force, N",
           "largest contact pressure, Pa")


def peak(x):
    """Height of a peak at a distance x [m] from its summit: four pieces of parabolas, which
    elements with six nodes have exactly."""
    r = np.abs(x) / HALF_WIDTH
    return HEIGHT * np.where(r < 0.5, 1 - 2 * r**2, np.where(r < 1, 2 * (1 - r)**2, 0))


class Mesh:
    def __init__(self):
        self.nodes, self.elements = [], []

    def beam(self, left, length, bottom, lower, upper, along, through):
        """A beam [m] of along x through squares, each of two triangles; its lower and upper heights
        are functions of x. Nodes as (column, row) and triangles as (square, layer, 0 below or 1
        above), by their numbers."""
        columns, rows = 2 * along + 1, 2 * through + 1
        numbers = len(self.nodes) + 1 + np.arange(columns * rows).reshape(columns, rows)
        for x in left + length * np.arange(columns) / (2 * along):
            y = bottom + THICKNESS * np.arange(rows) / (rows - 1)
            # peaks lie in the outer layer
            for side, height, next_one in ((0, lower(x), 1), (-1, upper(x), -2)):
                y[side] += height
                y[next_one] += height / 2
            self.nodes += [(x, each) for each in y]
        triangles = {}
        for i in range(along):
            for j in range(through):
                def at(column, row):
                    return numbers[2 * i + column, 2 * j + row]
                for above, corners in enumerate((((0, 0), (2, 0), (2, 2)),
                                                 ((0, 0), (2, 2), (0, 2)))):
                    middles = [tuple((a + b) // 2 for a, b in zip(corners[k], corners[(k + 1) % 3]))
                               for k in range(3)]
                    self.elements.append([at(*corner) for corner in (*corners, *middles)])
                    triangles[i, j, above] = len(self.elements)
        return numbers, triangles


def input_text(mesh):
    along_resonator, along_slider, through, step = MESHES[mesh]
    made = Mesh()
    lower, lower_triangles = made.beam(0, RESONATOR, 0, lambda x: 0,
                                       lambda x: float(sum(peak(x - at) for at in PEAKS)),
                                       along_resonator, through)
    of_lower = len(made.elements)
    left = -SPEED * STARTING / 2  # what the smooth beginning slides
    middle = left + SLIDER / 2
    upper, upper_triangles = made.beam(left, SLIDER, THICKNESS + 2 * HEIGHT - OVERLAP,
                                       lambda x: -float(peak(x - middle)),
                                       lambda x: 0, along_slider, through)
    lines = ["** Six shocks, made by bench/validation/six_shocks_calculix.py; mm, N, s, MPa, t",
             "*NODE,NSET=BEAMS"]
    lines += [f"{i},{1e3 * x:.12g},{1e3 * y:.12g},0" for i, (x, y) in enumerate(made.nodes, 1)]
    for name, first, last in (("RESONATOR", 0, of_lower), ("SLIDER", of_lower, len(made.elements))):
        lines.append(f"*ELEMENT,TYPE=CPE6,ELSET={name}")
        lines += [",".join(map(str, [i + 1, *made.elements[i]])) for i in range(first, last)]
    block = len(made.nodes) + np.arange(1, 9)
    lines.append("*NODE,NSET=BLOCK")
    lines += [f"{number},{500 + x},{500 + y},{z}" for number, (x, y, z) in zip(block, (
        (0, 0, 0), (1, 0, 0), (1, 1, 0), (0, 1, 0), (0, 0, 1), (1, 0, 1), (1, 1, 1), (0, 1, 1)))]
    lines += ["*ELEMENT,TYPE=C3D8,ELSET=BLOCK",
              ",".join(map(str, [len(made.elements) + 1, *block])),
              "*INITIAL CONDITIONS,TYPE=VELOCITY", "BLOCK,2,1e6",
              "*MATERIAL,NAME=STEEL", "*ELASTIC", f"{1e-6 * YOUNG:.9g},{POISSON}", "*DENSITY",
              f"{1e-12 * DENSITY:.9g}"]
    for name, thickness in (("RESONATOR", "1."), ("SLIDER", "1."), ("BLOCK", "")):
        lines += [f"*SOLID SECTION,ELSET={name},MATERIAL=STEEL",
                  *([thickness] if thickness else [])]
    lines += ["*NSET,NSET=ENDS", f"{lower[0, through]},{lower[-1, through]}",
              "*NSET,NSET=SLIDING", f"{upper[0, through]},{upper[-1, through]}",
              "*NSET,NSET=SUMMIT", f"{upper[along_slider, 0]}"]
    lines.append("*SURFACE,NAME=MASTER")
    lines += [f"{lower_triangles[i, through - 1, 1]},S2" for i in range(along_resonator)]
    lines.append("*SURFACE,NAME=SLAVE")
    lines += [f"{upper_triangles[i, 0, 0]},S1" for i in range(along_slider)
              if abs(left + SLIDER * (i + 0.5) / along_slider - middle) < HALF_WIDTH]
    lines += ["*SURFACE INTERACTION,NAME=CONTACT", "*SURFACE BEHAVIOR,PRESSURE-OVERCLOSURE=LINEAR",
              f"{1e-9 * STIFFNESS:.9g}",
              "*CONTACT PAIR,INTERACTION=CONTACT,TYPE=SURFACE TO SURFACE", "SLAVE,MASTER",
              "*BOUNDARY", "ENDS,1,2,0.", "SLIDING,2,2,0.", "*AMPLITUDE,NAME=SLIDE"]
    # the speed rises as 10 r^3 - 15 r^4 + 6 r^5
    for part in np.linspace(0, 1, round(STARTING / step) + 1):
        distance = 1e3 * SPEED * STARTING * part**4 * (2.5 - 3 * part + part**2)
        lines.append(f"{STARTING * part:.9g},{distance:.12g}")
    lines += [f"1.,{1e3 * SPEED * (1 - STARTING / 2):.12g}",
              "*STEP,NLGEOM,INC=100000", "*DYNAMIC,DIRECT", f"{step:.9g},{STARTING + DURATION:.9g}",
              "*BOUNDARY,AMPLITUDE=SLIDE", "SLIDING,1,1,1.", "*NODE PRINT,NSET=SUMMIT", "U",
              "*CONTACT PRINT,SLAVE=SLAVE,MASTER=MASTER", "CF", "*CONTACT PRINT", "CDIS,CSTR",
              "*END STEP"]
    return "\n".join(lines) + "\n"


def kept(text):
    """Rows of COLUMNS of what CalculiX has printed, from the end of the beginning on."""
    # displacements towards the resonator, as in ra2d
    return [(now - STARTING, -1e-3 * float(moved[1]), 1e3 * WIDTH * float(force[1]), 1e6 * pressure)
            for now, moved, force, pressure in calculix.increments(text, STARTING + DURATION)
            if now - STARTING > -1e-9]


def run(ccx, mesh, folder):
    printed, seconds, elapsed = calculix.solve(ccx, input_text(mesh))
    rows = kept(printed)
    with open(folder / f"six-shocks-{mesh}.csv", "w", newline="") as file:
        write = csv.writer(file, lineterminator="\n")
        write.writerow([f"# {mesh}: {seconds:.0f} s of processor time, {elapsed:.0f} s by the "
                        "clock, "
                        f"CalculiX {calculix.version(ccx)}"])
        write.writerow(COLUMNS)
        write.writerows([f"{value:.7g}" for value in row] for row in rows)


def main():
    options = calculix.requested("The six shocks by CalculiX.", MESHES)
    if options.input:
        pathlib.Path(options.input[1]).write_text(input_text(options.input[0]))
    if options.run:
        (pathlib.Path(options.run[1]) / "six-shocks.inp").write_text(input_text(BEST))
        with concurrent.futures.ThreadPoolExecutor(os.cpu_count()) as pool:  # each run on one core
            list(pool.map(lambda mesh: run(options.run[0], mesh, pathlib.Path(options.run[1])),
                          options.meshes))


if __name__ == "__main__":
    main()
