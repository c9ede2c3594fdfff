# SPDX-License-Identifier: BSD-3-Clause
"""A stretch of a run, which is looked at as if it were a run of its own."""
from __future__ import annotations

import math
from typing import Any

import numpy as np
import pandas as pd
import xarray as xr

from .errors import RequestError
from .results import Body, Result
from .style import quantity

_SUMS = ("damping_loss", "sliding_work", "load_work")  # energies since t = 0


def seconds(name: str, value: float | None) -> float | None:
    """A time that was given, as a number."""
    if value is None:
        return None
    if isinstance(value, bool) or not isinstance(value,
                                                 int | float
                                                 | np.number) or not math.isfinite(value):
        raise RequestError(f"{name} is {value!r}: expected a time of the run in s")
    return float(value)


class Stretch(Result):
    """A result between two times. Its series, shocks and numbers are those of the stretch; energies
    that are sums since the start count from its own."""

    def __init__(self, whole: Result, start: float | None, stop: float | None) -> None:
        super().__init__(whole.path)
        self._file = whole._file  # that very file
        self._hears = whole._hears
        self.start, self.stop = seconds("start", start), seconds("stop", stop)
        self.end = end = whole.duration
        self.first = 0.0 if self.start is None else self.start          # s
        self.last = end if self.stop is None else min(self.stop, end)   # s
        if self.first < 0 or not self.first < self.last:
            until = "on" if self.stop is None else f"to {self.stop:g} s"
            raise RequestError(
                f"from {self.first:g} s {until} there is nothing of {whole.path.name}: the run "
                f"goes from 0 s to {end:g} s, and start is before stop")
        half = 0.5e-3 / whole.rate if math.isfinite(whole.rate) else 0.0  # roundings of times
        self._within = slice(self.first - half, self.last + half)
        self._samples = int(self._part(super().contact).sizes["time"])
        if self._samples < 2:
            raise RequestError(
                f"from {self.first:g} s to {self.last:g} s there are fewer than two samples, which "
                "are "
                               f"{quantity(1 / whole.rate, 's')} apart: take a longer stretch, or "
                               "'ra2d run --zoom'")

    def _part(self, series: xr.Dataset) -> xr.Dataset:
        part: xr.Dataset = series.sel(time=self._within)
        return part

    def analysis(self, **options: Any) -> dict[str, Any]:
        """Of the stretch."""
        stretch: dict[str, Any] = {"start": self.start, "stop": self.stop}
        return super().analysis(**(stretch | options))

    @property
    def probes(self) -> xr.Dataset:
        """Of the stretch."""
        return self._part(super().probes)

    @property
    def slider_probes(self) -> xr.Dataset:
        """Of the stretch."""
        return self._part(super().slider_probes)

    @property
    def contact(self) -> xr.Dataset:
        """Of the stretch."""
        return self._part(super().contact)

    @property
    def energy(self) -> xr.Dataset:
        """Of the stretch; sums count from its first sample."""
        part = self._part(super().energy).load()
        for name in _SUMS:
            part[name] = part[name] - part[name][0]
        return part

    def modes(self, body: Body = "resonator") -> xr.Dataset:
        """Of the stretch."""
        return self._part(super().modes(body))

    @property
    def shocks(self) -> pd.DataFrame:
        """That begin in the stretch."""
        table = super().shocks
        return table[(table.start >= self._within.start) & (table.start <= self._within.stop)]

    @property
    def samples(self) -> int:
        """In the stretch."""
        return self._samples

    @property
    def duration(self) -> float:
        """Time of its last sample [s], from the start of the run."""
        return self.last


def of(whole: Result, start: float | None, stop: float | None) -> Result:
    """The stretch from `start` to `stop` [s] of a result; itself where neither is given."""
    return whole if start is None and stop is None else Stretch(whole, start, stop)


def first_time(result: Result) -> float:
    """Time at which a result or its stretch begins [s]."""
    return result.first if isinstance(result, Stretch) else 0.0


def whole_duration(result: Result) -> float:
    """Time of the last sample of the run [s]."""
    return result.end if isinstance(result, Stretch) else result.duration


def words(result: Result) -> str:
    """The words for a stretch in the head of a picture."""
    if not isinstance(result, Stretch):
        return ""
    return (f", from {quantity(result.first, 's', 7) if result.first else '0'} to "
            f"{quantity(result.last, 's', 7)}")
