# SPDX-License-Identifier: BSD-3-Clause
"""Groups of an HDF5 file as xarray Datasets that read when they are asked for numbers."""
from __future__ import annotations

import contextlib
import math
import pathlib
from collections.abc import Iterable, Iterator, Mapping
from typing import Any

import h5py
import numpy as np
import xarray as xr
from xarray.backends import BackendArray
from xarray.core import indexing

from .errors import Error, FileError
from .sealed import Seal, SealedFile

# parts of xarray without types
_lazy: Any = indexing.LazilyIndexedArray
_copied_when_set: Any = indexing.CopyOnWriteArray  # the file stays as it is
_variable: Any = xr.Variable


LARGEST = 1e100  # in any unit: no run comes to it, and squares of larger numbers may overflow
MOST_DEFLATED = 1032  # bytes from one: no more can be had of deflate

# what h5py and xarray raise on a damaged file
_DAMAGE = (OSError, KeyError, RuntimeError, ValueError, TypeError, AttributeError)


def dataset(file: Any, path: str, axes: int | None = None) -> Any:
    """A dataset of an open file, or None where there is none. Every reading begins here. Raises
    ValueError where it holds neither numbers nor texts, where they do not all stand in this file,
    where there are more than fit into it, and, with `axes`, where it has not so many, or no
    numbers."""
    found, path = file, "/" + path.strip("/")
    for name in path[1:].encode().split(b"/"):
        if not isinstance(found, h5py.Group) or not found.id.links.exists(name):
            return None
        # before it is followed: h5py waits without end for a file that a sealed one names
        if found.id.links.get_info(name).type != h5py.h5l.TYPE_HARD:
            raise ValueError(f"{path} is a link to something else, as ra2d writes none")
        found = found[name]
    if not isinstance(found, h5py.Dataset):
        raise ValueError(f"{path} is no dataset")
    if found.external or found.is_virtual:  # which no seal covers
        raise ValueError(f"{path} is kept in other files")
    if found.shape is None:
        raise ValueError(f"{path} is empty")
    # a few bytes of a file can say that there are any number of them
    is_packed = found.id.get_create_plist().get_nfilters() > 0
    room = MOST_DEFLATED * found.id.get_storage_size() if is_packed else file.id.get_filesize()
    if math.prod(found.shape) * found.id.get_type().get_size() > room:
        raise ValueError(f"{path} should hold more numbers than the file has room for")
    if found.dtype.kind not in "fiu" and not h5py.check_string_dtype(found.dtype):
        raise ValueError(f"{path} has neither numbers nor texts")
    if axes is not None and found.dtype.kind not in "fiu":
        raise ValueError(f"{path} has no numbers")
    if axes is not None and len(found.shape) != axes:
        raise ValueError(f"{path} is of the shape {found.shape}, not of {axes} axes")
    return found


def required(file: Any, path: str, axes: int) -> Any:
    """As `dataset`; ValueError where there is none."""
    if (found := dataset(file, path, axes)) is None:
        raise ValueError(f"/{path.strip('/')} is missing")
    return found


class _Dataset(BackendArray):
    """A dataset of a file, which is opened at each reading: nothing stays open, and parts alone are
    read."""

    def __init__(self, file: File, name: str, dataset: Any, gaps: bool = False) -> None:
        self.file, self.name, self.gaps = file, name, gaps
        self.shape, self.dtype = dataset.shape, np.dtype(dataset.dtype)

    def __getitem__(self, key: Any) -> Any:
        return indexing.explicit_indexing_adapter(key, self.shape,
                                                  indexing.IndexingSupport.OUTER_1VECTOR,
                                                  self._read)

    def _read(self, key: tuple[Any, ...]) -> Any:
        with self.file.opened() as file:
            stored = dataset(file, self.name)
            values = (stored.asstr() if h5py.check_string_dtype(stored.dtype) else stored)[key]
            if stored.dtype.kind == "f" and not self.gaps and not (np.abs(values) < LARGEST).all():
                raise ValueError(f"{self.name} has values that are no numbers, or too large for "
                                 "any run")
            return values


def _units(stored: Any) -> dict[str, str]:
    found = {name: stored.attrs[name] for name in ("units", "long_name") if name in stored.attrs}
    if not all(isinstance(text, str) for text in found.values()):
        raise ValueError(f"{stored.name} has a unit or a name that is no text")
    return found


class File:
    """A file of ra2d as it is now. Once it is replaced, reading is an error: no numbers of another
    run."""

    def __init__(self, path: pathlib.Path) -> None:
        self.path = path
        self._identity = self._now()
        self._seal: Seal | None = None  # once it has been read

    def _now(self) -> tuple[int, ...]:
        try:
            found = self.path.stat()
        except (OSError, ValueError) as fault:
            why = "there is no such file" if isinstance(fault, FileNotFoundError) else fault
            raise FileError(f"cannot read {str(self.path)!r}: {why}") from fault
        return found.st_dev, found.st_ino, found.st_size, found.st_mtime_ns

    def require_unchanged(self) -> None:
        """Raises FileError where the file is gone, or is another one by now."""
        if self._now() != self._identity:
            raise FileError(f"{str(self.path)!r} has been replaced since it was opened: open it "
                            "again, "
                            "with ra2d.load or ra2d.load_study")

    @property
    def is_sealed(self) -> bool:
        """Whether what is read of it is compared with a seal."""
        self._seal = self._seal or Seal(self.path)
        return self._seal.size > 0

    @contextlib.contextmanager
    def opened(self) -> Iterator[Any]:
        """The HDF5 file, open for reading as long as the block runs."""
        self.require_unchanged()
        sealed: SealedFile | None = None
        why: FileError | None = None
        try:
            self._seal = self._seal or Seal(self.path)
            with contextlib.ExitStack() as open_files:
                if self._seal.size > 0:
                    sealed = open_files.enter_context(SealedFile(self.path, self._seal))
                yield open_files.enter_context(h5py.File(sealed or self.path, "r"))
            if sealed is not None:
                why = sealed.fault  # which h5py has kept to itself
        except Error:
            raise
        except _DAMAGE as fault:
            what = str(fault.args[0] if isinstance(fault, KeyError) else fault)  # else in quotes
            why = FileError(f"cannot read {str(self.path)!r} as a result of ra2d: {what}. 'ra2d "
                            "check' says what of it is damaged")
            if sealed is not None and sealed.fault is not None:
                why = sealed.fault
        # not from the fault, whose frames hold what h5py must give back before the interpreter ends
        if why is not None:
            raise why

    def read(self, group: str, dims: Mapping[str, tuple[str, ...]],
             numbers: Iterable[str] = (), rising: Iterable[str] = (),
             gaps: bool = False) -> xr.Dataset:
        """A group as a Dataset. `dims`: the dimensions of each dataset, by name; others are left
        out. Datasets with the name of a dimension are its coordinates. Raises FileError where one
        of `numbers` is missing, or has no numbers, where coordinates of the names `rising` do not
        rise, and, unless there are `gaps`, where a value is read that no run comes to."""
        variables, needed = {}, set(numbers)
        with self.opened() as file:
            for name, of in dims.items():
                path = f"{group.rstrip('/')}/{name}"
                stored = required(file, path, len(of)) if name in needed else dataset(file, path)
                if stored is not None:
                    values = _copied_when_set(_lazy(_Dataset(self, path, stored, gaps)))
                    variables[name] = _variable(of, values, _units(stored))
            coordinates = {name: of for name, of in variables.items() if (name,) == of.dims}
            for name in coordinates.keys() & set(rising):
                values = coordinates[name].values
                if values.dtype.kind not in "fiu" or not (np.diff(values) > 0).all():
                    raise ValueError(f"{group.rstrip('/')}/{name} does not rise")
            return xr.Dataset({name: of for name, of in variables.items()
                               if name not in coordinates}, coordinates)

    def scalars(self, group: str, names: Iterable[str]) -> xr.Dataset:
        """Single numbers of a group. Those that do not exist are left out. By name: libhdf5 1.10
        ends the interpreter where it cannot read one while it goes through a group."""
        with self.opened() as file:
            found = {name: dataset(file, f"{group}/{name}", 0) for name in names}
            return xr.Dataset({name: _variable((), of[()], _units(of))
                               for name, of in found.items() if of is not None})

    def attributes(self) -> dict[str, Any]:
        """The attributes of the file: texts, and numbers."""
        with self.opened() as file:
            return {name: value.item() if isinstance(value, np.generic) else value
                    for name, value in file.attrs.items()}
