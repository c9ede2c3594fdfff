# SPDX-License-Identifier: BSD-3-Clause
"""Other faces of the same roughness: seeds of random ones; of measured ones other stretches of the
trace or map, mirror images, and surrogates of equal spectrum."""
from __future__ import annotations

import dataclasses
import math
import pathlib
from collections.abc import Mapping
from typing import Any

import numpy as np
import numpy.typing as npt

from . import files, program
from .errors import Error, RequestError
from .scenes import Scene
from .surface import MEASURED, Surface, array

Heights = npt.NDArray[np.float64]
BODIES = ("resonator", "slider")
AS_MEASURED = "as measured"
NEXT_SEED = 1000  # from the seed of one run to that of the next, as in `ra2d study`
ROUNDS = 50       # of a surrogate


@dataclasses.dataclass(frozen=True)
class Face:
    """One face of a realisation.

    - `kind`: "seed 1002", "as measured", "offset 20 mm", "mirror image", "surrogate 1"
    - `key`, `value`: the key of the scene that makes it, and its value
    - `distribution_error`: of a surrogate: how far its sorted heights are from those of the
      measured face, as a share of their root mean square; 0 of other faces
    """

    kind: str
    key: str
    value: Any
    distribution_error: float = 0.0


def surrogate(heights: Heights, seed: int) -> tuple[Heights, float]:
    """A profile with the spectrum of another one and other phases, and how far its sorted heights
    are from the other's (root mean square, as a share of that of the heights).

    Iterated amplitude-adjusted Fourier transform (Schreiber and Schmitz 1996): the sorted heights
    and the amplitudes are imposed in turn, the amplitudes last. So the spectrum is equal to
    rounding, and no noise of the sorting stands between neighbouring nodes. The line from the
    first to the last height is taken off before and put back after: a step from the end to the
    beginning would be spread over the whole profile as roughness.

    >>> z = np.sin(np.arange(1000) / 5.0) + np.sin(np.arange(1000) / 13.0)
    >>> other, error = surrogate(z, seed=1)
    >>> error < 0.1 and not np.allclose(z, other)
    True
    """
    line = np.linspace(heights[0], heights[-1], heights.size)
    random = np.exp(2j * np.pi * np.random.default_rng(seed).random(heights.size // 2 + 1))
    random[0] = 1
    if heights.size % 2 == 0:
        random[-1] = 1  # the line at half the rate is real
    return _with_phases(heights, line, random)


def map_surrogate(heights: Heights, seed: int) -> tuple[Heights, float]:
    """As `surrogate`, of a map (rows, x). What is taken off before is its smooth part (Moisan
    2011): a periodic map is left, without the steps from edge to edge. The smooth part does not
    change with the phases, so the surrogate of a small map is some per cent rougher or smoother:
    that counts in the error.

    >>> z = np.random.default_rng(1).normal(size=(40, 60))
    >>> other, error = map_surrogate(z, seed=1)
    >>> other.shape, error < 0.1 and not np.allclose(z, other)
    ((40, 60), True)
    """
    noise = np.fft.rfft2(np.random.default_rng(seed).normal(size=heights.shape))  # of real phases
    noise[0, 0] = 1
    made, _ = _with_phases(heights, _smooth_part(heights), noise / np.abs(noise))
    apart = np.sort(made, axis=None) - np.sort(heights, axis=None)
    return made, float(np.sqrt((apart ** 2).mean()) / heights.std()) if heights.std() > 0 else 0.0


def _smooth_part(heights: Heights) -> Heights:
    """The map whose Laplacian is that of the steps from each edge to the opposite one."""
    steps = np.zeros_like(heights)
    across, along = heights[-1] - heights[0], heights[:, -1] - heights[:, 0]
    steps[0] += across
    steps[-1] -= across
    steps[:, 0] += along
    steps[:, -1] -= along
    rows, columns = heights.shape
    laplacian = (2 * np.cos(2 * np.pi / rows * np.arange(rows))[:, None]
                 + 2 * np.cos(2 * np.pi / columns * np.arange(columns // 2 + 1)) - 4)
    laplacian[0, 0] = 1
    lines = np.fft.rfft2(steps) / laplacian
    lines[0, 0] = 0
    smooth: Heights = np.fft.irfft2(lines, heights.shape)
    return smooth


def _with_phases(heights: Heights, taken_off: Heights,
                 random: npt.NDArray[np.complex128]) -> tuple[Heights, float]:
    """The surrogate that begins with these phases."""
    wanted = heights - taken_off
    middle = float(wanted.mean())
    wanted = wanted - middle
    size = float(np.sqrt((wanted ** 2).mean()))
    if size == 0:
        return heights.copy(), 0.0
    is_map = heights.ndim == 2
    transform: Any = np.fft.rfft2 if is_map else np.fft.rfft
    inverse: Any = np.fft.irfft2 if is_map else np.fft.irfft
    shape: Any = heights.shape if is_map else heights.size
    amplitude, ordered = np.abs(transform(wanted)), np.sort(wanted, axis=None)

    def impose(phases: npt.NDArray[np.complex128]) -> Heights:
        made: Heights = inverse(amplitude * phases, shape)
        return made

    def error_of(made: Heights) -> float:
        return float(np.sqrt(((np.sort(made, axis=None) - ordered) ** 2).mean())) / size

    best = impose(random)
    error = error_of(best)
    made = best
    for _ in range(ROUNDS):
        ranked = np.empty_like(made)
        ranked.flat[np.argsort(made, axis=None, kind="stable")] = ordered
        spectrum = transform(ranked)
        lengths = np.abs(spectrum)
        phases = np.where(lengths > 0, spectrum / np.where(lengths > 0, lengths, 1), 1)
        made = impose(phases)
        found = error_of(made)
        if found < error:
            best, error = made, found
        elif found > 0.9999 * error:
            break
    return best + taken_off + middle, error


def offsets(trace: float, first: float, width: float) -> list[float]:
    """Shifts [m] to other stretches of a trace, none of which overlaps another or the one that is
    used, which begins at `first` and is `width` long.

    >>> offsets(0.1, 0.0, 0.02)
    [0.02, 0.04, 0.06, 0.08]
    """
    slack = 1e-9 * trace
    right = math.floor((trace - first - width + slack) / width)
    left = math.floor((first + slack) / width)
    return [k * width for k in range(1, right + 1)] + [-k * width for k in range(1, left + 1)]


def _trace_length(face: Surface, spacing: float) -> float:
    """Length of the whole measured trace after its filter [m], in whole spacings."""
    words = [str(word) for name in MEASURED if name in face
             for word in ("--" + name.replace("_", "-"), face[name])]
    found = program.ask("surface", "measure", face["path"], *words, "--filter", "none")
    # half at each end
    dropped = face.get("cutoff", 2.5e-3) if face.get("filter") == "gaussian" else 0.0
    return float(math.floor((found["length"] - dropped) / spacing * (1 + 1e-12))) * spacing


def _whole_trace(face: Surface, spacing: float) -> Heights | None:
    """The heights of the whole trace as a run would have them; None where that cannot be found."""
    if face.get("short") == "repeat":
        return None
    try:
        length = _trace_length(face, spacing)
        return np.asarray(face.heights(length, spacing).values) if length > 0 else None
    except Error:
        return None


def _moved(trace: Heights, by: int, nodes: int) -> Heights:
    """The stretch of the trace that begins `by` nodes further; mirrored where the trace has
    ended."""
    at = np.abs(np.arange(nodes) + by)
    last = trace.size - 1
    folded = np.where(at <= last, at, np.maximum(2 * last - at, 0))
    moved: Heights = trace[folded]
    return moved


@dataclasses.dataclass
class _Measured:
    """A measured face of a scene."""

    body: str
    face: Surface
    length: float   # m, of the body
    spacing: float  # m, of the heights: half of the scene's, so that every case has its nodes there
    first: float    # m, where the stretch begins that is touched
    width: float    # m, its length

    def variants(self, heights: Heights, count: int, folder: pathlib.Path) -> list[Face]:
        """The face as it is and `count` - 1 others, each with its file."""
        found = [self._written(AS_MEASURED, heights, folder)]
        trace = _whole_trace(self.face, self.spacing)
        for shift in (offsets((trace.size - 1) * self.spacing, self.first, self.width)
                      if trace is not None else []):
            if len(found) < count and trace is not None:
                name = f"offset {1e3 * shift:.6g} mm"
                found.append(self._written(name, _moved(trace, round(shift / self.spacing),
                                                        heights.size), folder))
        if len(found) < count:
            found.append(self._written("mirror image", heights[::-1], folder))
        for number in range(1, count - len(found) + 1):
            made, error = surrogate(heights, seed=2 * number + BODIES.index(self.body))
            found.append(self._written(f"surrogate {number}", made, folder, error))
        return found

    def _written(self, kind: str, heights: Heights, folder: pathlib.Path,
                 error: float = 0.0) -> Face:
        name = f"{self.body}-{kind.replace(' ', '-').replace('.', '_')}.csv"
        if (heights.size - 1) * self.spacing < self.length:  # the beam's end lies between two nodes
            heights = np.append(heights, heights[-1])
        return Face(kind, f"{self.body}.surface.path",
                    array(heights, self.spacing, folder / name)["path"], error)


@dataclasses.dataclass
class _MeasuredMap:
    """A measured map of an areal scene, whole, as a run prepares it. Each variant is as large and
    has the same mean, from which heights count; what is touched stands in the same place."""

    body: str
    face: Surface
    heights: Heights                # (rows, x)
    spacings: tuple[float, float]   # m, of rows and along x
    first: tuple[int, int]          # where in the map the part begins that is touched: row, column
    size: tuple[int, int]           # of that part

    def variants(self, count: int, folder: pathlib.Path) -> list[Face]:
        found = [self._written(AS_MEASURED, self.heights, folder)]
        for steps in self._stretches():
            if len(found) == count:
                return found
            by = [1e3 * step * apart for step, apart in zip(steps, self.spacings)]
            moved = np.roll(self.heights, [-step for step in steps], (0, 1))
            found.append(self._written(f"offset {by[1]:.6g} and {by[0]:.6g} mm", moved, folder))
        for name, axes in (("mirror image", (1,)), ("mirror image across", (0,)),
                           ("turned", (0, 1))):
            if len(found) == count:
                return found
            back = [self._fold(axis) for axis in axes]
            found.append(self._written(name,
                                       np.roll(np.flip(self.heights, axes), back, axes), folder))
        for number in range(1, count - len(found) + 1):
            made, error = map_surrogate(self.heights, seed=2 * number + BODIES.index(self.body))
            found.append(self._written(f"surrogate {number}", made, folder, error))
        return found

    def _fold(self, axis: int) -> int:
        """By how much a mirror image is rolled: what is touched stands in its place then. The roll
        joins the map's edges. Where the map goes on within what is touched, that would be a step
        there, and it is not rolled."""
        return (2 * self.first[axis] + self.size[axis] - self.heights.shape[axis]
                if self._is_within(axis) else 0)

    def _is_within(self, axis: int) -> bool:
        """Whether what is touched ends within the map."""
        return self.first[axis] + self.size[axis] <= self.heights.shape[axis]

    def _stretches(self) -> list[tuple[int, int]]:
        """Steps [rows, columns] to other parts of the map, the nearest first; none overlaps."""
        if not (self._is_within(0) and self._is_within(1)):
            return []
        places = [range(-(begin // part), (whole - begin) // part) for begin, part, whole in
                  zip(self.first, self.size, self.heights.shape)]
        found = [(i * self.size[0], j * self.size[1]) for i in places[0] for j in places[1]
                 if (i, j) != (0, 0)]
        return sorted(found,
                      key=lambda steps: (abs(steps[0]) / self.size[0]
                                         + abs(steps[1]) / self.size[1], steps))

    def _written(self, kind: str, heights: Heights, folder: pathlib.Path,
                 error: float = 0.0) -> Face:
        name = f"{self.body}-{kind.replace(' ', '-').replace('.', '_')}.npy"
        path = array(heights, self.spacings[1], folder / name, spacing_y=self.spacings[0])["path"]
        return Face(kind, f"{self.body}.surface.path", path, error)

    def words(self, path: str) -> dict[str, Any]:
        """The face that is kept in a file of this map's size."""
        kept = {name: self.face[name] for name in ("offset_x", "offset_y", "short")
                if name in self.face}
        return {"kind": "file", "path": path, "spacing": self.spacings[1],
                "spacing_y": self.spacings[0], "z_unit": "m",
                **kept}


def _measured_map(complete: Mapping[str, Any], body: str) -> _MeasuredMap:
    scene, slider = complete["scene"], complete["slider"]
    face = Surface(complete[body]["surface"])
    words = [str(word) for name in ("spacing", "spacing_y", "z_unit", "decimal", "fill", "form")
             if name in face
             for word in ("--" + name.replace("_", "-"), face[name])]
    with program.scratch() as folder:
        described = program.ask("surface", "map", face["path"], *words, "-o", folder / "map.npy")
        heights = np.asarray(np.load(folder / "map.npy"), dtype=float)
    begins, side, travel = 0.0, 0.0, 0.0
    if body == "resonator":
        begins, side = float(scene["start"]), float(scene["side"])
        travel = float(scene["speed"]) * float(scene["duration"])
    along, across = float(described["spacing"]), float(described["spacing_y"])
    few = 1e-6  # of a point: roundings
    first = (max(0, math.floor((side - float(face.get("offset_y", side))) / across + few)),
             max(0, math.floor((begins - float(face.get("offset_x", 0.0))) / along + few)))
    size = (math.ceil(float(slider["width"]) / across - few),
            math.ceil(float(slider["length"]) / along - few) + 1
            + (math.ceil(travel / along) + 1 if body == "resonator" else 0))
    if "short" not in face:  # all that is touched is there: the sizes are rounded up
        rows, columns = heights.shape
        size = (min(size[0], rows - first[0]), min(size[1], columns - first[1]))
    return _MeasuredMap(body, face, heights, (across, along), first, size)


def is_random(face: Mapping[str, Any]) -> bool:
    return "seed" in face


def is_measured(face: Mapping[str, Any]) -> bool:
    return face.get("kind") == "file"


def has_measured_map(complete: Mapping[str, Any]) -> bool:
    return complete["scene"].get("kind") == "areal" and any(
        is_measured(complete[body].get("surface", {}))
                                                            for body in BODIES)


def _measured(complete: Mapping[str, Any], body: str) -> _Measured:
    section = complete["scene"]
    face = Surface(complete[body]["surface"])
    slider = float(complete["slider"]["length"])
    first = float(section["start"]) if body == "resonator" else 0.0
    width = slider + (float(section["speed"]) * float(section["duration"])
                      if body == "resonator" else 0.0)
    return _Measured(body, face, float(complete[body]["length"]), float(section["spacing"]) / 2,
                     first, width)


def of_scene(what: Scene, complete: Mapping[str, Any], count: int, folder: pathlib.Path
             ) -> tuple[Scene, list[list[Face]]]:
    """The scene whose faces can be exchanged, and the faces of `count` realisations, the first as
    asked. `folder`: where profiles are written, if any."""
    by_body: list[list[Face]] = []
    for body in BODIES:
        face = complete[body].get("surface", {})
        if is_random(face):
            by_body.append([Face(f"seed {face['seed'] + NEXT_SEED * k}", f"{body}.surface.seed",
                                 face["seed"] + NEXT_SEED * k) for k in range(count)])
        elif is_measured(face):
            if complete["scene"].get("kind") == "areal":
                measured_map = _measured_map(complete, body)
                if np.ptp(measured_map.heights) == 0:
                    continue
                files.make_folder(folder)
                faces = measured_map.variants(count, folder)
                what = what.change({f"{body}.surface": measured_map.words(faces[0].value)})
                by_body.append(faces)
                continue
            measured = _measured(complete, body)
            heights = np.asarray(measured.face.heights(measured.length, measured.spacing).values)
            if np.ptp(heights) == 0:  # as flat as a face that is not measured
                continue
            files.make_folder(folder)
            faces = measured.variants(heights, count, folder)
            what = what.change({f"{body}.surface": {"kind": "file", "path": faces[0].value}})
            by_body.append(faces)
    if not by_body:
        raise RequestError(
            "chance is seen in runs of other faces, and neither face of this scene is random, or "
                           "measured and rough. Describe one by its roughness, as "
                           "{'slider.surface': "
                           "ra2d.surface.gaussian(rq=..., rsm=..., seed=1)}, or take a measured "
                           "one. Or let the slider "
                           "start elsewhere, further on than its length and what it slides: "
                           "ra2d.study(scene, {'start': [0.02, 0.06, 0.1]}) shows the scatter over "
                           "parts of one face")
    return what, [list(faces) for faces in zip(*by_body)]
