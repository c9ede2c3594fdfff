#!/usr/bin/env python3
# SPDX-License-Identifier: BSD-3-Clause
"""check_figures.py OUT.h5: every figure of the report and every dataset against its definition.

The file is of tests/host/figures.toml or a variant of it, with a sample at every step of a fixed
length: what the program sums up on its way is found here from the samples, with formulas of its
own. Sums are compared to 1e-9 (their order differs), what the program itself rounds to a thousandth
to that, and what is a trapezoid here and a sum over steps there to the order of a step. An adaptive
run is integrated exactly by the program and sampled densely here: what is summed then agrees to the
order of the time between samples, and starts and ends to that time.
"""
import math
import sys
import tomllib

import h5py
import numpy as np


def close(what, found, expected, relative=1e-9, floor=0.0):
    error = np.max(np.abs(np.asarray(found) - np.asarray(expected)), initial=0.0)
    size = np.max(np.abs(np.asarray(expected)), initial=0.0)
    if not error <= relative * size + floor:
        sys.exit(f"check_figures: {what}: {found} is not {expected} (off by {error:.3g})")


def modes_of(body, count):
    """Masses per length, circular frequencies and shapes (x, mode), by the textbook."""
    mass = body["density"] * body["thickness"] * body["width"]
    stiffness = body["young"] * body["width"] * body["thickness"] ** 3 / 12
    length = body["length"]
    if body["support"] == "pinned":
        wave = (np.arange(count) + 1) * np.pi / length
        return mass, math.sqrt(stiffness / mass) * wave**2, lambda x: math.sqrt(
            2 / length) * np.sin(np.outer(x, wave))
    beta = [0.0, 0.0]
    for k in range(count - 2):  # cosh(b) cos(b) = 1, by bisection about (k + 3/2) pi
        low, high = (k + 1.3) * np.pi, (k + 1.7) * np.pi
        f = lambda b: math.cos(b) - 1 / math.cosh(b)
        for _ in range(200):
            middle = (low + high) / 2
            low, high = (middle, high) if f(low) * f(middle) > 0 else (low, middle)
        beta.append(low / length)

    def shapes(x):
        x = np.asarray(x)
        out = [np.full(len(x), 1 / math.sqrt(length)), math.sqrt(12 / length**3) * (x - length / 2)]
        for b in beta[2:]:
            z = b * length
            s = (math.cosh(z) - math.cos(z)) / (math.sinh(z) - math.sin(z))
            psi = np.cosh(b * x) + np.cos(b * x) - s * (np.sinh(b * x) + np.sin(b * x))
            out.append(psi / math.sqrt(length))
        return np.array(out[:count]).T

    return mass, math.sqrt(stiffness / mass) * np.array(beta[:count]) ** 2, shapes


def walk(group, data, path=""):
    for name, item in group.items():
        if isinstance(item, h5py.Group):
            walk(item, data, f"{path}{name}/")
        else:
            data[path + name] = item[()]


def quantile(values, share):
    ordered = np.sort(values)
    return ordered[max(1, math.ceil(share * len(ordered))) - 1]


def main(path):
    with h5py.File(path) as file:
        scene = tomllib.loads(file.attrs["scene"])
        steps = int(file.attrs["steps"])
        data = {}
        walk(file, data)
    adaptive = scene["time"]["scheme"] == "adaptive"
    step = 1 / scene["output"]["rate"] if adaptive else scene["time"]["step"]
    start, begin = scene["scene"], scene["output"]["from"]
    summed, instant = (2e-3, 2 * step) if adaptive else (1e-9, 0.0)  # relative; s
    speed, chi = start["speed"], start["spacing"]
    resonator, slider = scene["resonator"], scene["slider"]
    time, force, touching = data["time"], data["contact/force"], data["contact/nodes"] > 0
    count = len(time)
    if not adaptive:
        assert count == steps + 1 and abs(scene["output"]["rate"] * step
                                          - 1) < 1e-12, "a sample at every step is needed"
    close("time", time, np.arange(count) * step)
    first = math.ceil(begin / step * (1 - 1e-12))

    # bodies, modes, probes, energies
    kinetic = elastic = 0
    for name, body, probes in (("resonator", resonator, "probes"),
                               ("slider", slider, "slider_probes")):
        u, v = data[f"{name}/displacement"], data[f"{name}/velocity"]
        modes = u.shape[1]
        if modes == 0:
            continue
        mass, omega, shapes = modes_of(body, modes)
        close(f"{name}/mode", data[f"{name}/mode"], np.arange(modes))
        close(f"{name}/frequency", data[f"{name}/frequency"], omega / (2 * np.pi), 1e-10)
        close(f"{name}/shape", data[f"{name}/shape"].T, shapes(data[f"{name}/position"]), 1e-9)
        nodes = np.arange(round(body["length"] / chi) + 1) * chi
        close(f"{name}/position", data[f"{name}/position"], nodes)  # few enough to be all of them
        close(f"surface/{name}/position", data[f"surface/{name}/position"], nodes)
        heights = np.zeros(len(nodes))
        for peak in body["surface"].get("peaks", []):
            away = (nodes - peak["at"]) / peak["half_width"]
            heights += np.where(np.abs(away) <= 1,
                                peak["height"] / 2 * (1 + np.cos(np.pi * away)), 0)
        close(f"surface/{name}/height", data[f"surface/{name}/height"], heights, 1e-9)
        elastic_modes = omega > 0
        close(f"{name}/mean_square", data[f"{name}/mean_square"],
              np.mean(shapes(nodes) ** 2, axis=0) * elastic_modes)
        at = shapes(data[f"{probes}/position"])
        close(f"{probes}/displacement", data[f"{probes}/displacement"], u @ at.T)
        close(f"{probes}/velocity", data[f"{probes}/velocity"], v @ at.T)
        kinetic = kinetic + 0.5 * mass * np.sum(v**2, axis=1)
        elastic = elastic + 0.5 * mass * np.sum((omega * u) ** 2, axis=1)
        if name == "resonator":
            velocity = (v[:, elastic_modes] @ shapes(nodes)[:, elastic_modes].T)[first + 1 :]
            v_rms = math.sqrt(np.mean(velocity**2))
        loss = np.concatenate(([0.0],
                               np.cumsum(np.sum(2 * body["damping"] * omega * mass * v[1:] ** 2,
                                                axis=1) * step)))
        damping = loss if name == "resonator" else damping + loss
    close("energy/kinetic", data["energy/kinetic"], kinetic)
    close("energy/elastic", data["energy/elastic"], elastic)
    spring = scene["contact"]["stiffness"] * chi * min(resonator["width"], slider["width"])
    close("energy/contact", data["energy/contact"], force**2 / (2 * spring), 1e-8)
    close("energy/damping_loss", data["energy/damping_loss"], damping, 1e-2)
    load = slider.get("load", 0.0)
    rigid = data["slider/displacement"][:, 0]
    close("energy/load_work", data["energy/load_work"],
          load / math.sqrt(slider["length"]) * (rigid - rigid[0]), 1e-8)
    stored = sum(data[f"energy/{name}"]
                 for name in ("kinetic", "elastic", "contact", "damping_loss"))
    paid = data["energy/sliding_work"] + data["energy/load_work"]
    # work of the imposed sliding: the force on the slope of polygon and bent plate, at the one node
    # that can touch
    node = int(np.argmax(data["surface/slider/height"])) * chi
    place = start["start"] + speed * time + node
    height = data["surface/resonator/height"]
    left = np.minimum((place / chi + 1e-9).astype(int), len(height) - 2)
    wave = (np.arange(data["resonator/mode"].size) + 1) * np.pi / resonator["length"]
    deflection = math.sqrt(2 / resonator["length"]) * wave * np.cos(np.outer(place, wave))
    slope = (height[left + 1]
             - height[left]) / chi + np.sum(deflection * data["resonator/displacement"], axis=1)
    work = np.concatenate(([0.0], np.cumsum((force * speed * slope)[:-1] * step)))
    close("energy/sliding_work", data["energy/sliding_work"], work, max(1e-7, 10 * summed))

    # the level
    close("level/v_rms", data["level/v_rms"], v_rms, summed)
    close("level/lv", data["level/lv"], 20 * math.log10(data["level/v_rms"] / 1e-9))
    close("summary/v_rms", data["summary/v_rms"], data["level/v_rms"], 0)
    close("summary/lv", data["summary/lv"], data["level/lv"], 0)

    # shocks: stretches of steps in contact of the one node that can be
    assert data["contact/nodes"].max() == 1, "more than one node touches"
    edges = np.flatnonzero(np.diff(np.concatenate(([False], touching[:-1], [False])).astype(int)))
    begins, ends = edges[::2], edges[1::2]
    assert len(begins) >= 3, "too few shocks"
    close("shocks/start", data["shocks/start"], begins * step, 1e-9, instant)
    close("shocks/duration", data["shocks/duration"], (ends - begins) * step, 1e-9, instant)
    stretch = [slice(a, b) for a, b in zip(begins, ends)]
    close("shocks/peak_force", data["shocks/peak_force"], [force[s].max() for s in stretch],
          max(1e-8, summed))
    close("shocks/impulse", data["shocks/impulse"], [force[s].sum() * step for s in stretch],
          max(1e-8, summed))
    close("shocks/position", data["shocks/position"],
          [np.average(place[s], weights=force[s]) for s in stretch], max(1e-8, summed * 1e-2))
    own = data["shocks/start"] >= begin * (1 - 1e-12)
    close("summary/shock_rate", data["summary/shock_rate"],
          own.sum() / ((count - 1 - first) * step), summed)
    for figure, values in (("shock_duration", data["shocks/duration"][own]),
                           ("peak_force", data["shocks/peak_force"][own])):
        close(f"summary/{figure}_median", data[f"summary/{figure}_median"],
              quantile(values, 0.5), 1.1e-3)
        close(f"summary/{figure}_90", data[f"summary/{figure}_90"], quantile(values, 0.9), 1.1e-3)
    close("summary/contact_share", data["summary/contact_share"], touching[first:-1].mean(), summed)

    # energies' summary
    residual = (stored - paid)[-1] - (stored - paid)[first]
    turnover = 0.0
    counted = data["energy/kinetic"] + data["energy/elastic"] + data["energy/contact"]
    for values in (counted, *(data[f"energy/{n}"] - data[f"energy/{n}"][first]
                              for n in ("damping_loss", "sliding_work", "load_work"))):
        turnover = max(turnover, np.abs(values[first:]).max())
    close("summary/energy_turnover", data["summary/energy_turnover"], turnover)
    close("summary/energy_residual", data["summary/energy_residual"], residual, 1e-9,
          1e-12 * turnover)
    close("summary/energy_closure", data["summary/energy_closure"], abs(residual) / turnover,
          1e-9, 1e-12)
    if scene["time"]["nodes"] == "all":
        close("summary/nodes_evaluated", data["summary/nodes_evaluated"],
              len(data["surface/slider/height"]))
    assert data["summary/nodes_evaluated"] > 0
    assert 0 < data["summary/step_seconds"] * steps <= data["summary/wall_seconds"] + 1e-12
    print(f"{path}: {len(begins)} shocks, {v_rms:.6g} m/s: every figure is what it should be")


if __name__ == "__main__":
    main(sys.argv[1])
