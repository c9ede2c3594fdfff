# SPDX-License-Identifier: BSD-3-Clause
"""Pictures of the charts, from the tables that `ra2d chart` writes."""
from __future__ import annotations

import os
import pathlib
from collections.abc import Sequence

from . import chart_accuracy, chart_stability
from .errors import FileError
from .style import Picture


def picture(chart: str, tables: Sequence[str | os.PathLike[str]]) -> Picture:
    """The picture of a chart, "accuracy" or "stability", from all its tables in their order."""
    files = [pathlib.Path(table) for table in tables]
    try:
        return chart_accuracy.picture(
            *files) if chart == "accuracy" else chart_stability.picture(*files)
    except OSError as fault:
        raise FileError(f"cannot read '{fault.filename}': {fault.strerror}") from fault
    except (KeyError, ValueError, IndexError, TypeError) as fault:
        what = f", and no {fault.args[0]!r}" if isinstance(fault, KeyError) else ""
        raise FileError(f"a table of the chart has something else than 'ra2d chart' writes{what}: "
                        "make the chart again") from fault
