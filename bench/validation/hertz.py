#!/usr/bin/env python3
# SPDX-License-Identifier: BSD-3-Clause
"""Level and shocks under contact.stiffness = "hertz" over the speed and the roughness.

Set against the scene as it is (1e15 Pa/m) on the same surfaces, as the choices are (choices.py).
The number that it takes is that of the scene's materials, E* / (sqrt(2) w): 1/E* is the sum of (1 -
poisson^2) / young of the bodies, w the slider's width.
"""
import h5py
import numpy as np

import choices
import common

SPEEDS = choices.SHOWN
YOUNG, POISSON, WIDTH = 210e9, 0.3, 0.02  # Pa, 1, m: of the scene
SETS = {"contact.stiffness": "hertz"}


def taken(case):
    """The stiffness in the scene that a result keeps [Pa/m]."""
    result = case.scratch / "one.h5"
    case.call(case.program, "run", common.ROOT / "scenes" / "dang2012.toml", "-o", result,
              "--quiet", "--set", 'contact.stiffness="hertz"',
              "--set", "scene.duration=1e-4")
    with h5py.File(result) as file:
        lines = file.attrs["scene"].splitlines()
    return float(next(line.split("=")[1].split("#")[0]
                      for line in lines if line.startswith("stiffness")))


def compare(case):
    expected = YOUNG / (2 * (1 - POISSON**2)) / (np.sqrt(2) * WIDTH)
    found = taken(case)
    case.check("the stiffness, over that of the materials, off by", abs(found / expected - 1),
               8 * np.finfo(float).eps, "a formula of five roundings")
    if case.short:
        return
    tables = {name: choices.runs(case, name, sets, speeds=SPEEDS)
              for name, sets in (("base", {}), ("hertz", SETS))}
    changes = {(rq, speed): choices.Change(tables["hertz"].sel(rq=rq),
                                           tables["base"].sel(rq=rq), speed)
               for rq in choices.RQ for speed in SPEEDS}
    names = {"level": lambda change: "{:+.1f} ± {:.1f} dB".format(*change.level),
             "shocks": lambda change: change.factor_text("shock_rate"),
             "median duration": lambda change: change.factor_text("shock_duration_median"),
             "median peak force": lambda change: change.factor_text("peak_force_median")}
    case.text("speeds", common.markdown(("", *(f"{speed:g} m/s" for speed in SPEEDS)), [
        (f"Rq {1e6 * rq:g} um, {name}", *(text(changes[rq, speed]) for speed in SPEEDS))
        for rq in choices.RQ for name, text in names.items()]))
    case.text("stiffness", found)
    case.text("level-range",
              "{:+.1f} to {:+.1f}".format(*(pick(change.level[0] for change in changes.values())
                                            for pick in (min, max))))
    case.text("rate-range",
              choices.factors([change.factor("shock_rate")[0] for change in changes.values()]))
    case.text("seeds", f"{choices.SEEDS}")
    case.table(("Rq, m", "V, m/s", "level, dB", "half of its 95 % interval",
                *(f"{what}, factor{end}" for what in choices.QUANTITIES
                  for end in ("", ", from", ", to"))),
               [(rq, speed, *(f"{x:.2f}" for x in change.level),
                 *(f"{x:.4g}" for kind in choices.QUANTITIES for x in change.factor(kind)))
                for (rq, speed), change in changes.items()])


if __name__ == "__main__":
    common.main("hertz", compare)
