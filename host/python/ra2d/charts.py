# SPDX-License-Identifier: BSD-3-Clause
"""Pictures of the charts, from the tables that `ra2d chart` writes."""
from __future__ import annotations

import os
import pathlib
import re
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
        value = None if isinstance(fault, UnicodeError) else re.search(r"'.*'", str(fault))
        what = f" ({'no ' if isinstance(fault, KeyError) else ''}{value[0]})" if value else ""
        raise FileError(f"a table of the chart is not what 'ra2d chart' writes{what}: make the "
                        "chart again") from fault
