# SPDX-License-Identifier: BSD-3-Clause
"""Faces of the bodies: random, measured, or from an array (docs/surfaces.md).

>>> import ra2d
>>> rough = ra2d.surface.gaussian(rq=8e-6, rsm=1.55e-3, seed=7)
>>> ra2d.scene("dang2012").change({"slider.surface": rough})["slider.surface.seed"]
7
"""
from __future__ import annotations

import hashlib
import io
import os
import pathlib
from typing import Any

import numpy as np
import numpy.typing as npt
import pandas as pd
import xarray as xr

from . import files, program
from .errors import FileError, RequestError
from .results import Result
from .scenes import Scene

_masked: Any = np.ma  # without types

# keys of a measured face that `ra2d surface measure` takes as options of the same name
MEASURED = ("x_unit", "z_unit", "spacing", "decimal", "row", "column", "fill", "form", "cutoff_s")


def _require_lengths(**given: Any) -> None:
    """Raises RequestError for what is no positive number; None is left out."""
    for name, value in given.items():
        if value is not None and not (isinstance(value, int | float | np.number)
                                      and 0 < value < np.inf):
            raise RequestError(f"{name} is {value!r}: expected a number > 0 (m)")


class Surface(dict[str, Any]):
    """The words of a scene for a face. It is a dict, for `{"slider.surface": face}` or a scene's
    dict.

    >>> gaussian(rq=8e-6, rsm=1.55e-3, seed=7)
    {'kind': 'gaussian', 'rq': 8e-06, 'rsm': 0.00155, 'seed': 7}
    """

    def heights(self, length: float, spacing: float, width: float | None = None,
                spacing_y: float | None = None) -> xr.DataArray:
        """Heights [m] over `position` [m], as a body of this `length` [m] with nodes `spacing` [m]
        apart has them in a run: read, filtered and levelled by the program. With a `width` [m] a
        map over (y, position), as of the slider of an areal scene; its rows are `spacing_y` [m]
        apart, without it as far as the nodes.

        >>> z = gaussian(rq=8e-6, rsm=1.55e-3, seed=7).heights(0.02, 8e-6)
        >>> z.sizes["position"], f"{float((z**2).mean() ** 0.5):.3g} {z.units}"
        (2501, '8e-06 m')
        >>> gaussian(rq=8e-6, rsm=1.55e-3, seed=7).heights(0.01, 1e-4, width=0.004).shape
        (40, 101)
        """
        _require_lengths(spacing=spacing, width=width, spacing_y=spacing_y)
        if width is None and spacing_y is not None:
            raise RequestError("spacing_y is of the rows of a map: give its width, too")
        # two rigid bodies, for one step: the result holds the faces
        where: dict[str, Any] = {"duration": 1e-6, "speed": 0.0, "start": 0.0, "spacing": spacing}
        rough: dict[str, Any] = {"support": "rigid", "length": length, "width": width or 1.0,
                                 "surface": self}
        flat = {"support": "rigid", "length": 4 * spacing if width is None
                else length + 4 * spacing,
                "width": width or 1.0}
        if width is None:
            bodies = {"resonator": rough, "slider": flat}
        else:  # of the resonator a map's result keeps a strip alone
            where |= {"kind": "areal", "spacing_y": spacing_y or spacing}
            bodies = {"resonator": flat, "slider": rough}
        scene = {"scene": where, **bodies,
                 "contact": {"law": "penalty", "stiffness": 1.0},
                 "time": {"scheme": "exact", "step": 1e-6},
                 "output": {"rate": 1e6}}
        with program.scratch() as folder:
            program.call("run", Scene(scene).file(folder), "-o", folder / "faces.h5", "--quiet")
            return Result(folder / "faces.h5").profile("resonator" if width is None
                                                       else "slider").load()

    def roughness(self, cutoff: float = 2.5e-3, **options: Any) -> pd.Series[float]:
        """Roughness parameters of a measured face, in SI units, by ISO 21920-2 (`ra2d surface
        measure`). `cutoff` [m]; other options by their names there: `standard="iso4287"`,
        `filter="done"`, `sampling_lengths="all"`. What is not defined is NaN.

        >>> face = array(4e-6 * np.sin(np.arange(4000) / 20), spacing=2e-6)
        >>> f"{face.roughness(cutoff=0.8e-3)['Rq']:.3g}"
        '2.83e-06'
        """
        if self.get("kind") != "file":
            raise RequestError(
                "roughness is measured of a file: give ra2d.surface.array(face.heights(...), "
                "spacing) "
                               "or ra2d.surface.read(...)")
        words: dict[str, Any] = {name: self[name] for name in MEASURED if name in self}
        words |= {"cutoff": cutoff, **options}
        given = [str(word) for name, value in words.items()
                 for word in ("--" + name.replace("_", "-"), value)]
        answer = program.ask("surface", "measure", self["path"], *given)
        return pd.Series(answer["parameters"], dtype=float, name=answer["standard"])


def gaussian(*, rq: float, seed: int, rsm: float | None = None,
             correlation_length: float | None = None,
             **words: Any) -> Surface:
    """A random face. `rq` [m]: root mean square height; `rsm` [m]: mean spacing of its elements, or
    `correlation_length` [m]; `words`: the other keys of docs/scene.md, as `skewness`, `kurtosis`,
    `correlation`, `hurst`, `exact`. A seed means one profile, at every spacing.

    >>> gaussian(rq=4e-6, correlation_length=3e-4, seed=1)["kind"]
    'gaussian'
    """
    if (rsm is None) == (correlation_length is None) and words.get("correlation") != "self-affine":
        raise RequestError("a random face needs rsm or correlation_length, one of them")
    given = {"rq": rq, "rsm": rsm, "correlation_length": correlation_length, **words, "seed": seed}
    return Surface(kind="gaussian",
                   **{name: value for name, value in given.items() if value is not None})


def read(path: str | os.PathLike[str], **words: Any) -> Surface:
    """A measured face: text of two columns, SDF or X3P; of an areal scene X3P, SDF, .npy or a text
    matrix. `words`: the keys of docs/scene.md for `kind = "file"`: `x_unit`, `z_unit`, `spacing`
    [m], `form`, `filter`, `cutoff` [m], `row`, ... The path counts from the current folder.

    >>> face = read(getfixture("profile"), x_unit="mm", z_unit="um", form="line")
    >>> face.heights(0.01, 8e-6).sizes["position"]
    1251
    """
    path = pathlib.Path(path)
    if not path.is_file():
        raise FileError(f"cannot read the profile {str(path)!r}: there is no such file")
    return Surface(kind="file", path=str(path.resolve()), **words)


def array(heights: npt.ArrayLike, spacing: float, path: str | os.PathLike[str] | None = None, *,
          spacing_y: float | None = None, **words: Any) -> Surface:
    """A face from an array of heights [m], `spacing` [m] apart: 1-D, or for an areal scene 2-D, of
    shape (rows, x), its rows of constant y `spacing_y` [m] apart, without it as far as the points.
    They are written to `path`, without it to a file in the current folder that is named by its
    content: .csv, of a map .npy. `words`: as for `read`. Heights that are NaN or masked are
    refused: fill the gaps first, as `np.interp` does.

    >>> array([0.0, 1e-6, 0.0, 2e-6], spacing=8e-6)["path"].endswith(".csv")
    True
    >>> array(np.zeros((30, 40)), spacing=8e-6)["path"].endswith(".npy")
    True
    """
    try:
        if np.iscomplexobj(heights):
            raise TypeError("they are complex numbers")
        z: npt.NDArray[np.float64] = _masked.filled(_masked.asarray(heights, dtype=float), np.nan)
    except (TypeError, ValueError) as fault:
        raise RequestError(f"a face is a row of heights in metres: {fault}") from fault
    if z.ndim not in (1, 2) or min(z.shape) < 2 or not np.isfinite(z).all():
        raise RequestError(
            "a face is a row of at least two finite heights in metres, or rows of them, not an "
            f"array of shape {z.shape} with {np.count_nonzero(~np.isfinite(z))} values that are "
            "not finite, or are masked: fill such gaps first")
    _require_lengths(spacing=spacing, spacing_y=spacing_y)
    if z.ndim == 2:
        return _map(z, float(spacing), float(spacing_y or spacing), path, words)
    if spacing_y is not None:
        raise RequestError("spacing_y is of rows: expected heights of shape (rows, x)")
    text = "x [m],z [m]\n" + "".join(f"{i * float(spacing)!r},{height!r}\n"
                                     for i, height in enumerate(z.tolist()))
    file = pathlib.Path(path or f"face-{hashlib.sha256(text.encode()).hexdigest()[:12]}.csv")
    if file.suffix in (".h5", ".toml", ".npy"):
        raise RequestError(
            f"{str(file)!r}: a face is a text of two columns; expected a name that ends in .csv or "
            ".txt")
    files.write(file, text)
    return read(file, **words)


def _map(heights: npt.NDArray[np.float64], spacing: float, spacing_y: float,
         path: str | os.PathLike[str] | None,
         words: dict[str, Any]) -> Surface:
    buffer = io.BytesIO()
    np.save(buffer, np.ascontiguousarray(heights, dtype="<f8"))
    data = buffer.getvalue()
    file = pathlib.Path(path or f"face-{hashlib.sha256(data).hexdigest()[:12]}.npy")
    if file.suffix != ".npy":
        raise RequestError(f"{str(file)!r}: a map is kept as .npy; expected a name that ends so")
    files.write_bytes(file, data)
    return read(file, spacing=spacing, spacing_y=spacing_y, **words)
