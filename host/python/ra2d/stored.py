# SPDX-License-Identifier: BSD-3-Clause
"""Groups of an HDF5 file as xarray Datasets that read when they are asked for numbers."""
from __future__ import annotations

import contextlib
import pathlib
from collections.abc import Iterator, Mapping
from typing import Any

import h5py
import numpy as np
import xarray as xr
from xarray.backends import BackendArray
from xarray.core import indexing

from .errors import FileError

# parts of xarray without types
_lazy: Any = indexing.LazilyIndexedArray
_variable: Any = xr.Variable


@contextlib.contextmanager
def opened(path: pathlib.Path) -> Iterator[Any]:
    """The file, open for reading as long as the block runs."""
    try:
        with h5py.File(path, "r") as file:
            yield file
    except (OSError, KeyError) as fault:
        raise FileError(f"cannot read {str(path)!r} as a result of ra2d: {fault}") from fault


class _Dataset(BackendArray):
    """A dataset of a file, which is opened at each reading: nothing stays open, and parts alone are read."""

    def __init__(self, path: pathlib.Path, name: str, dataset: Any) -> None:
        self.path, self.name = path, name
        self.shape, self.dtype = dataset.shape, np.dtype(dataset.dtype)

    def __getitem__(self, key: Any) -> Any:
        return indexing.explicit_indexing_adapter(key, self.shape, indexing.IndexingSupport.OUTER_1VECTOR, self._read)

    def _read(self, key: tuple[Any, ...]) -> Any:
        with opened(self.path) as file:
            stored = file[self.name]
            return (stored.asstr() if h5py.check_string_dtype(stored.dtype) else stored)[key]


def _units(dataset: Any) -> dict[str, str]:
    return {name: dataset.attrs[name] for name in ("units", "long_name") if name in dataset.attrs}


def read(path: pathlib.Path, group: str, dims: Mapping[str, tuple[str, ...]]) -> xr.Dataset:
    """A group as a Dataset. `dims`: the dimensions of each dataset, by name; others are left out.
    Datasets with the name of a dimension are its coordinates."""
    variables = {}
    with opened(path) as file:
        for name, of in dims.items():
            if name in file[group]:
                stored = file[group][name]
                values = _lazy(_Dataset(path, f"{group}/{name}", stored))
                variables[name] = _variable(of, values, _units(stored))
    coordinates = {name: of for name, of in variables.items() if (name,) == of.dims}
    return xr.Dataset({name: of for name, of in variables.items() if name not in coordinates}, coordinates)


def scalars(path: pathlib.Path, group: str) -> xr.Dataset:
    """The single numbers of a group. Numbers that do not exist are not in it."""
    with opened(path) as file:
        return xr.Dataset({name: _variable((), stored[()], _units(stored)) for name, stored in file[group].items()
                           if stored.shape == ()})


def attributes(path: pathlib.Path) -> dict[str, Any]:
    """The attributes of the file: texts, and numbers."""
    with opened(path) as file:
        return {name: value.item() if isinstance(value, np.generic) else value for name, value in file.attrs.items()}
