#!/usr/bin/env python3
# SPDX-License-Identifier: BSD-3-Clause
"""How long trajectories mean anything: independent integrators on the paper's scenes, and how fast
a small difference of the initial state grows.

The peers are CVODE (Adams and BDF) and Boost.Odeint's dopri5 on equations of their own
(bench/peers). States are compared in the norm of the energy: d^2 = sum m (dV^2 + omega^2 dU^2)/2
over both bodies' modes, over the same of the state. A rigid mode counts by its velocity alone.

The small difference is a blow on the plate: a force that crosses its right half in a tenth of a
microsecond and then is gone. Its e-folding time is the slope of the difference's logarithm over
time, between the start and 1e-4 of the state.
"""
import json
import tomllib

import numpy as np
from scipy import stats

import common

SCENES = {"pinned": "dang2012-pinned", "free": "dang2012"}
DURATION = {"pinned": 0.4, "free": 0.01}  # s, of the runs with and without a blow
# s, at which integrators are compared
TIMES = {"pinned": (5e-3, 20e-3, 50e-3, 100e-3, 150e-3, 200e-3, 300e-3),
         "free": (0.25e-3, 0.5e-3, 1e-3, 2e-3, 3e-3, 4e-3, 6e-3)}
PEERS = (("cvode-adams", 1e-12), ("cvode-adams", 1e-10), ("cvode-bdf", 1e-10), ("dopri5", 1e-12))
FORCE = 1e-6       # N, of the blow
SEEDS = 20
GAPS = (14e-6, 17e-6, 20e-6, 23e-6)  # m
WEAK = 0.01        # of the state: a bound beyond says nothing
TOO_LARGE = 1e-4   # of the state: beyond, a difference feels that it is bounded
TOLERANCE = 1e-13
BLOW = 1e-7        # s, that the force is on the plate
BODIES = ("resonator", "slider")


def papers(kind, duration, seed=0, blow=0.0, samples=400, gap=None):
    """The paper's scene, with the blow's force [N] and another gap [m]."""
    scene = tomllib.loads((common.ROOT / "scenes" / f"{SCENES[kind]}.toml").read_text())
    scene["scene"]["duration"] = duration
    for body in BODIES:
        scene[body]["surface"]["seed"] += 1000 * seed  # as a study does
    scene["time"] = {"scheme": "adaptive", "tolerance": TOLERANCE}
    scene["output"] = {"rate": samples / duration, "probes": [0.15]}
    if gap:
        scene["scene"]["gap"] = gap
    if blow:
        half = scene["resonator"]["length"] / 2
        scene["resonator"]["moving_force"] = [{"force": blow, "speed": half / BLOW, "start": half}]
    return scene


def masses(scene):
    """Mass per length of both bodies [kg/m]."""
    return [scene[body]["density"] * scene[body]["thickness"] * scene[body]["width"]
            for body in BODIES]


def energy(states, frequencies, mass):
    """Twice the energy of states [(displacements, velocities) of each body]: (time)."""
    return sum(m * ((v**2).sum(-1) + ((2 * np.pi * f * u)**2).sum(-1))
               for (u, v), f, m in zip(states, frequencies, mass))


def marched(case, scene):
    """Times, number of shocks, states, frequencies."""
    names = [f"{body}/{what}" for body in BODIES
             for what in ("displacement", "velocity", "frequency")]
    time, shocks, *found = case.run(scene, "time", "shocks/start", *names)
    return time, len(shocks), [(found[0], found[1]), (found[3], found[4])], [found[2], found[5]]


def distance(first, second, frequencies, mass):
    """Of states, over the largest of the first: (time)."""
    apart = [(u1 - u2, v1 - v2) for (u1, v1), (u2, v2) in zip(first, second)]
    return np.sqrt(energy(apart, frequencies, mass) / energy(first, frequencies, mass).max())


def growth(case, kind, seed, duration=None, gap=None):
    """How a blow's difference grows: times, distances; the exponent [1/s]; shocks a second."""
    duration = duration or DURATION[kind]
    time, shocks, first, frequencies = marched(case, papers(kind, duration, seed, gap=gap))
    second = marched(case, papers(kind, duration, seed, FORCE, gap=gap))[2]
    apart = distance(first, second, frequencies, masses(papers(kind, duration)))[1:]
    over = np.flatnonzero(apart > TOO_LARGE)
    end = over[0] if len(over) else len(apart)
    return time[1:], apart, np.polyfit(time[1:end + 1], np.log(apart[:end]),
                                       1)[0], shocks / duration


def mean(values):
    """Mean and half of its 95 % interval of Student's t."""
    return np.mean(values), stats.t.ppf(0.975, len(values) - 1) * stats.sem(values)


def agreement(case, kind, times):
    """Rows (peer, time, distance, bound) and the numbers of shocks until the times."""
    step = min(times)
    scene = papers(kind, max(times), samples=round(max(times) / step))
    mass = masses(scene)
    grown_time, grown, *_ = growth(case, kind, 0, max(times))
    time, _, states, frequencies = marched(case, scene)
    starts = case.run(scene, "shocks/start")[0]
    file = case.scene_file(scene)  # the peers': no other scene may come between
    largest = energy(states, frequencies, mass).max()
    rows = []
    for peer, tolerance in PEERS:
        for until in times:
            answer = json.loads(case.call(case.peers, file, "--integrator", peer, "--tolerance",
                                          tolerance, "--until", until))
            at = round(until / step)
            if abs(time[at] - until) > 1e-12:
                raise SystemExit(f"horizon: no sample at {until} s: TIMES must be multiples of the "
                                 "first")
            apart, size = [], 0
            for body, (u, v) in zip(BODIES, states):
                there = [np.array(answer[f"{body}_{what}"])
                         for what in ("displacement", "velocity")]
                apart.append((u[at] - there[0], v[at] - there[1]))
                size += 2 * there[0].size
            distance_now = float(np.sqrt(energy(apart, frequencies, mass) / largest))
            grown_by = grown[grown_time <= until].max(initial=grown[0]) / grown[0]
            # its tolerance is on the root mean square of its `size` unknowns
            rows.append((kind, peer, tolerance, until, distance_now,
                         answer["steps"] * tolerance * np.sqrt(size) * grown_by))
    return rows, [int((starts <= until).sum()) for until in times]


def compare(case):
    if not case.peers:
        raise SystemExit("horizon: ra2d_peers is missing; it is built where SUNDIALS and Boost are "
                         "(docs/building.md)")
    times = {"pinned": (5e-3, 10e-3), "free": (0.25e-3, 0.5e-3, 1e-3)} if case.short else TIMES
    rows, shocks = [], {}
    for kind in SCENES:
        of_kind, shocks[kind] = agreement(case, kind, times[kind])
        rows += of_kind
    for kind, peer, tolerance, _, apart, bound in rows:
        if bound < WEAK:
            case.check(f"{kind}: state, against `{peer}`, {common.shown(tolerance, 1)}",
                       apart, bound,
                       "the peer's tolerance at each of its steps, grown as a blow's difference "
                       "grows")
    if not case.short:
        report(case, rows, shocks)


def crossing(times, apart, level):
    """When distances first pass a level: between two times, their logarithms interpolated."""
    above = next(i for i, value in enumerate(apart) if value > level)
    part = np.log(level / apart[above - 1]) / np.log(apart[above] / apart[above - 1])
    return times[above - 1] + part * (times[above] - times[above - 1])


def report(case, rows, shocks):
    grown = {kind: [growth(case, kind, seed) for seed in range(SEEDS)] for kind in SCENES}
    exponents = []
    for kind in SCENES:
        rates = np.array([rate for _, _, rate, _ in grown[kind]])
        rate, half = mean(rates)
        exponents.append((kind, rate, half, rates.min(), rates.max(),
                          np.mean([shocks for *_, shocks in grown[kind]])))
        of_peer = {peer: [row[4] for row in rows if row[:3] == (kind, *peer)] for peer in PEERS}
        case.text(f"{kind}-agreement", common.markdown(
            ("ms", "shocks so far",
             *(f"`{peer}`, {common.shown(tolerance, 1)}" for peer, tolerance in PEERS)),
            [(common.shown(1e3 * time), count, *(common.shown(of_peer[peer][i]) for peer in PEERS))
             for i, (time, count) in enumerate(zip(TIMES[kind], shocks[kind]))]))
        checked = [max(row[3] for row in rows if row[:3] == (kind, *peer) and row[5] < WEAK)
                   for peer in PEERS]
        case.text(f"{kind}-checked", 1e3 * checked[0])
        case.text(f"{kind}-checked-others", 1e3 * min(checked))
        case.text(f"{kind}-horizon", 1e3 * crossing(TIMES[kind], of_peer[PEERS[0]], 1e-3))
        case.text(f"{kind}-efold", 1e3 / rate)
        case.text(f"{kind}-rounding", 1e3 * np.log(1e-3 / 1e-15) / rate)
    case.text("seeds", f"{SEEDS}")
    case.text("growth", common.markdown(
        ("slider", "exponent, 1/s", "e-folding time, ms", "exponents of single pairs, 1/s",
         "shocks a second", "shocks an e-fold"),
        [(kind, f"{rate:.0f} ± {half:.0f}",
          f"{1e3 / (rate + half):.2g} to {1e3 / (rate - half):.2g}",
          f"{low:.0f} to {high:.0f}", common.shown(per_second),
          f"{per_second / (rate + half):.0f} to {per_second / (rate - half):.0f}")
         for kind, rate, half, low, high, per_second in exponents]))
    by_gap(case)
    case.table(("slider", "peer", "tolerance", "time, s", "distance", "bound"), rows)
    draw(case, rows, grown)


def by_gap(case):
    """Exponents of the pinned slider at other gaps, which strikes more or less often."""
    rows = []
    for gap in GAPS:
        of_gap = [growth(case, "pinned", seed, DURATION["pinned"] / 2, gap)
                  for seed in range(SEEDS)]
        rate, half = mean([rate for _, _, rate, _ in of_gap])
        shocks = np.mean([each[3] for each in of_gap])
        rows.append((common.shown(1e6 * gap), f"{rate:.0f} ± {half:.0f}", common.shown(shocks),
                     f"{shocks / (rate + half):.0f} to {shocks / (rate - half):.0f}"))
    case.text("gaps",
              common.markdown(("gap, um", "exponent, 1/s", "shocks a second",
                               "shocks an e-fold"), rows))


def draw(case, rows, grown):
    plt, style = common.pyplot()
    figure, panels = plt.subplots(2, 1, figsize=(7, 7), layout="constrained")
    for axes, kind in zip(panels, SCENES):
        for i, (time, apart, *_) in enumerate(grown[kind]):
            axes.semilogy(1e3 * time[::7], apart[::7], color=style.SKY, lw=0.6,
                          label="after a blow, each pair of surfaces" if i == 0 else None)
        rate = np.mean([rate for _, _, rate, _ in grown[kind]])
        time = grown[kind][0][0]
        first = np.exp(np.mean([np.log(apart[:5]).mean() for _, apart, *_ in grown[kind]]))
        line = first * np.exp(rate * time)
        axes.semilogy(1e3 * time[line < 1], line[line < 1], color=style.BLUE, lw=1.5,
                      label="mean exponent")
        for (peer, tolerance), colour, mark in zip(PEERS, (style.BLACK, style.PLUM, style.RUST,
                                                           style.GREEN), "ovs^"):
            of = [(1e3 * row[3], row[4]) for row in rows if row[:3] == (kind, peer, tolerance)]
            axes.semilogy(*zip(*of), mark, color=colour, ms=4.5, mfc="none",
                          label=f"ra2d and {peer}, {common.shown(tolerance, 1)}")
        axes.set(title=f"{SCENES[kind]}.toml", xlabel="ms", ylabel="distance over the state",
                 ylim=(1e-12, 5))
    panels[0].legend(loc="lower right")
    case.figure(figure)


if __name__ == "__main__":
    common.main("horizon", compare)
