#!/usr/bin/env python3
# SPDX-License-Identifier: BSD-3-Clause
"""A constant force crosses a pinned beam, against the closed form (Fryba, Vibration of Solids and
Structures under Moving Loads, chapter 1; Olsson, J. Sound Vib. 145, 1991).

Mode k feels P psi_k(V t) while the force is on the beam, for one crossing L/V, and then vibrates
freely:

    U'' + omega^2 U = p sin(Omega t),   p = P sqrt(2/L)/m,   Omega = k pi V/L.

The critical speed is (pi/L) sqrt(D/m): there Omega = omega for the first mode.
"""
import numpy as np

import common
from plate import BEAM, CRITICAL_SPEED, LENGTH, MASS_PER_LENGTH, omegas, shapes

FORCE = 10.0  # N, upwards
MODES = 19    # those up to 20 kHz, as in the paper's calculation
CROSSINGS = 1.5


def amplitudes(modes, speed, time, force=FORCE):
    """U_k(t) in closed form: (mode, time)."""
    omega = omegas(modes)[:, None]
    drive = np.arange(1, modes + 1)[:, None] * np.pi * speed / LENGTH
    p = force * np.sqrt(2 / LENGTH) / MASS_PER_LENGTH
    t = np.minimum(time, LENGTH / speed)[None, :]
    resonant = np.abs(drive - omega) < 1e-9 * omega
    scale = p / np.where(resonant, 1, omega**2 - drive**2)
    u = np.where(resonant, p / (2 * omega**2) * (np.sin(omega * t) - omega * t * np.cos(omega * t)),
                 scale * (np.sin(drive * t) - drive / omega * np.sin(omega * t)))
    v = np.where(resonant, p / 2 * t * np.sin(omega * t),
                 scale * drive * (np.cos(drive * t) - np.cos(omega * t)))
    free = time[None, :] - t  # what it has vibrated freely
    return u * np.cos(omega * free) + v / omega * np.sin(omega * free)


def middle(modes, speed, time, force=FORCE):
    """Deflection of the beam's middle [m] under a force [N]."""
    return shapes(modes, LENGTH / 2) @ amplitudes(modes, speed, time, force)


def scene(speed, scheme, setting):
    duration = CROSSINGS * LENGTH / speed
    return {
        "scene": {"duration": duration, "speed": 0.0, "start": 0.14, "gap": 0.01, "spacing": 1e-3,
                  "faces": "linear", "initial": "rest"},
        "resonator": {**BEAM, "modes": MODES,
                      "moving_force": [{"force": FORCE, "speed": speed, "start": 0.0}]},
        "slider": {"support": "rigid", "length": 0.02, "width": 0.02},
        "contact": {"law": "penalty", "stiffness": 1e15},
        "time": {"scheme": scheme, ("tolerance" if scheme == "adaptive" else "step"): setting},
        "output": {"rate": 200 / duration, "probes": [LENGTH / 2]},
    }


def bound(speed, scheme, setting, time):
    """What the scheme can be off by [m]. The free and the forced vibration of a mode are each at
    most twice its largest amplitude. Backward Euler damps by (omega tau)^2/2 in a step and delays
    by less than a step; RK4 is off by (omega tau)^5/120 in a step, and puts the end of the force
    off by a step."""
    omega = omegas(MODES)
    largest = np.abs(amplitudes(MODES, speed, time)).max(axis=1)
    steps, turn = time[-1] / setting, omega * setting
    off = {"backward-euler": turn + steps * turn**2 / 2,
           "rk4": turn**2 + steps * turn**5 / 120}[scheme]
    return np.abs(shapes(MODES, LENGTH / 2)) @ (2 * largest * off)


def compare(case):
    ratios = (0.4, 1.0, 1.7) if case.short else (0.1, 0.4, 1.0, 1.7)
    settings = [("adaptive", 1e-10), ("backward-euler", 1e-7)]
    if not case.short:
        settings += [("backward-euler", 1e-8), ("rk4", 1e-6)]
    names = [f"`{scheme}`, {common.shown(x, 1)}{'' if scheme == 'adaptive' else ' s'}"
             for scheme, x in settings]
    rows, curves = [], {}
    for ratio in ratios:
        speed = ratio * CRITICAL_SPEED
        found = []
        for (scheme, setting), name in zip(settings, names):
            time, probe = case.run(scene(speed, scheme, setting), "time", "probes/displacement")
            exact = middle(MODES, speed, time)
            largest = np.abs(exact).max()
            curves[ratio, scheme] = time, probe[:, 0], exact
            found.append(np.abs(probe[:, 0] - exact).max() / largest)
            if scheme == "adaptive":
                case.check(name, found[-1], 10 * setting + 1e-12,
                           "ten tolerances, for some fifty steps")
            else:
                case.check(name, found[-1], bound(speed, scheme, setting, time) / largest,
                           "the scheme's damping and delay a step, summed over steps and modes")
        whole = middle(400, speed, time)
        rows.append((ratio, largest, *found, np.abs(exact - whole).max() / np.abs(whole).max()))
    if case.short:
        return
    case.table(("speed over critical", "largest deflection, m", *names, "19 modes instead of 400"),
               rows)
    case.text("table",
              common.markdown(("speed / critical", "largest deflection, mm", *names,
                               "19 modes instead of 400"),
                              [(row[0], common.shown(1e3 * row[1], 3), *map(common.shown, row[2:]))
                               for row in rows]))
    case.text("critical", CRITICAL_SPEED, 3)
    case.text("adaptive", max(row[2] for row in rows))
    case.text("euler", max(row[4] for row in rows))
    case.text("modes", max(row[-1] for row in rows))
    plt, style = common.pyplot()
    figure, (upper, lower) = plt.subplots(2, 1, figsize=(7, 6), layout="constrained")
    colours = dict(zip(ratios, (style.BLUE, style.RUST, style.GREEN, style.PLUM)))
    for ratio in ratios:
        time, probe, exact = curves[ratio, "adaptive"]
        place = time * ratio * CRITICAL_SPEED / LENGTH
        upper.plot(place, 1e3 * exact, color=colours[ratio], lw=1.2, label=f"{ratio} of critical")
        upper.plot(place[::8], 1e3 * probe[::8], "o", color=colours[ratio], ms=3, mfc="none")
        for scheme, line in (("backward-euler", "-"), ("adaptive", ":")):
            time, probe, exact = curves[ratio, scheme]
            lower.semilogy(time[1:] * ratio * CRITICAL_SPEED / LENGTH,
                           (np.abs(probe - exact) / np.abs(exact).max())[1:],
                           color=colours[ratio], lw=1, ls=line)
    upper.set(title="Deflection of the middle: closed form (lines), adaptive (circles)",
              ylabel="mm")
    upper.legend(loc="upper left")
    lower.set(title="Difference over the largest deflection: backward Euler, 10 ns (lines), "
                    "adaptive, 1e-10 (dots)",
              xlabel="way of the force over the beam's length", ylim=(1e-16, 1))
    case.figure(figure)


if __name__ == "__main__":
    common.main("moving-load", compare)
