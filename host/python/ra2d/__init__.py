# SPDX-License-Identifier: BSD-3-Clause
"""ra2d: friction noise of two rough beams, in Python. The program `ra2d` simulates and makes
tables; this package runs it, reads its results lazily, draws, listens and compares.

>>> import ra2d
>>> result = ra2d.run("dang2012", duration=0.1, tolerance=1e-6)
>>> result.level.unit
'dB re 1 nm/s'
"""
from . import surface
from .budget import Budget, uncertainty
from .compare_plot import plot
from .comparison import Comparison, compare
from .errors import (Error, FileError, Interrupted, Notice, OutOfTime, ProgramError, RequestError,
                     SimulationError)
from .estimate import Estimate
from .program import find
from .results import Result, load, report
from .runs import run
from .scenes import Scene, scene
from .sound import Sound
from .studies import Study, load_study, study
from .surface import Surface

__version__ = "0.1.0"
__all__ = ["Budget", "Comparison", "Error", "Estimate", "FileError", "Interrupted", "Notice",
           "OutOfTime",
           "ProgramError", "RequestError", "Result", "Scene", "SimulationError", "Sound", "Study",
           "Surface", "compare",
           "find", "load", "load_study", "plot", "report", "run", "scene", "study", "surface",
           "uncertainty"]
