# SPDX-License-Identifier: BSD-3-Clause
"""Numbers with their interval."""
from __future__ import annotations

import math
from collections.abc import Mapping
from typing import Any


class Estimate(float):
    """A number of the program with its 95 % interval. It counts as a float.

    - `low`, `high`: the interval, in the same unit; NaN where there is none
    - `unit`: as text
    - `note`: what the interval covers, or why there is none

    >>> level = Estimate(122.1, 120.0, 124.2, "dB re 1 nm/s")
    >>> level
    122.1 dB re 1 nm/s (95 %: 120.0 to 124.2)
    >>> level > 120, f"{level:.0f}"
    (True, '122')
    """

    low: float
    high: float
    unit: str
    note: str

    def __new__(cls, value: float, low: float = math.nan, high: float = math.nan, unit: str = "",
                note: str = "") -> Estimate:
        made = super().__new__(cls, value)
        made.low, made.high, made.unit, made.note = low, high, unit, note
        return made

    @classmethod
    def of(cls, value: float | None, interval: Mapping[str, Any] | None, unit: str,
           note: str) -> Estimate:
        """From the program's JSON, where null stands for what does not exist."""
        ends = [math.nan if interval is None or interval[end] is None else interval[end]
                for end in ("low", "high")]
        return cls(math.nan if value is None else value, ends[0], ends[1], unit, note)

    def __getnewargs__(self) -> tuple[float, float, float, str, str]:  # type: ignore[override]
        return float(self), self.low, self.high, self.unit, self.note

    def __repr__(self) -> str:
        if math.isnan(self):
            return f"none{f': {self.note}' if self.note else ''}"
        digits = ".1f" if self.unit.startswith("dB") else ".4g"
        interval = "no interval" if math.isnan(
            self.low) else f"95 %: {self.low:{digits}} to {self.high:{digits}}"
        return " ".join(filter(None, [f"{float(self):{digits}}", self.unit, f"({interval})"]))

    __str__ = __repr__
