#!/usr/bin/env python3
# SPDX-License-Identifier: BSD-3-Clause
"""The similarity groups of the equations: scenes that must map onto one another, and whether their
results do.

The equations are linear in everything vertical but for max(0, -g), which knows no scale either. So
heights and places along the beam have units of their own, and six changes of a scene leave the
motion similar (GROUPS below). A factor of two rounds nothing: the results must then agree to the
last bit. A factor of three rounds: they agree to what the motion makes of roundings.
"""
import copy
import tomllib

import numpy as np

import common

SAMPLED = ("time", "probes/displacement", "probes/velocity", "contact/force", "energy/kinetic")
OF_SHOCKS = ("shocks/start", "shocks/duration", "shocks/peak_force")


def on_bodies(**powers):
    return {(body, key): power for body in ("resonator", "slider") for key, power in powers.items()}


def surfaces(**powers):
    return {(body, "surface", key): power for body in ("resonator", "slider")
            for key, power in powers.items()}


# what is multiplied by which power of the factor, and by which power then time, displacement,
# velocity, force and energy are multiplied
LOAD = ("slider", "load")
GROUPS = {
    "heights": ({**surfaces(rq=1), ("scene", "gap"): 1, LOAD: 1}, (0, 1, 1, 1, 2)),
    "rates": ({**on_bodies(young=2), ("contact", "stiffness"): 2, LOAD: 2, ("scene", "speed"): 1,
               ("scene", "duration"): -1,
               ("output", "rate"): 1, ("time", "step"): -1, **on_bodies(max_frequency=1)},
              (-1, 0, 1, 2, 2)),
    "lengths": ({**on_bodies(length=1, young=4), **surfaces(rsm=1), LOAD: 1,
                 ("scene", "spacing"): 1, ("scene", "start"): 1,
                 ("scene", "speed"): 1, ("output", "probes"): 1}, (0, 0, 0, 1, 1)),
    "masses": ({**on_bodies(young=1, density=1), ("contact", "stiffness"): 1, LOAD: 1},
               (0, 0, 0, 1, 1)),
    "widths": ({**on_bodies(width=1), LOAD: 1}, (0, 0, 0, 1, 1)),
    "thicknesses": (on_bodies(thickness=1, young=-3, density=-1), (0, 0, 0, 0, 0)),
}


# of areal scenes: amplitudes of modes go with the root of the area, forces of nodes with it
AREAL_SAMPLED = ("time", "resonator/displacement", "resonator/velocity", "contact/force",
                 "energy/kinetic")
AREAL_GROUPS = {
    **{name: GROUPS[name] for name in ("heights", "rates", "masses", "thicknesses")},
    "lengths": ({**on_bodies(length=1, width=1, young=4), **surfaces(rsm=1), LOAD: 2,
                 **{("scene", key): 1 for key in ("spacing", "spacing_y", "start", "side",
                                                  "speed")}}, (0, 1, 1, 2, 2)),
}


def changed(scene, powers, factor):
    scene = copy.deepcopy(scene)
    for place, power in powers.items():
        part = scene
        for key in place[:-1]:
            part = part.get(key, {})
        value = part.get(place[-1])
        if isinstance(value, list):
            part[place[-1]] = [each * factor**power for each in value]
        elif value is not None and not isinstance(value, str):  # "touching", "weight"
            part[place[-1]] = float(value) * factor**power
    return scene


def papers(name, duration, scheme, setting):
    """A scene of the paper, with a load in newtons."""
    scene = tomllib.loads((common.ROOT / "scenes" / f"{name}.toml").read_text())
    scene["scene"]["duration"] = duration
    scene["output"]["rate"] = 1e5
    if "load" in scene["slider"]:
        body = scene["slider"]
        scene["slider"]["load"] = body["density"] * body["length"] * body["thickness"] * body[
            "width"] * 9.81
    scene["time"] = {"scheme": scheme, "tolerance" if scheme == "adaptive" else "step": setting}
    return scene


def areal(support, scheme, setting, **time):
    """A small block on the plate of scenes/areal.toml."""
    scene = tomllib.loads((common.ROOT / "scenes" / "areal.toml").read_text())
    scene["scene"].update(duration=2e-3, spacing=1e-4, spacing_y=1.5e-4, side=0.06)
    scene["slider"].update(support=support, length=5e-3, width=3e-3)
    if support == "rigid":
        scene["scene"].update(gap=15e-6, initial="rest")
    scene["slider"]["load"] = 0.5 if support == "free" else 0.0
    scene["resonator"]["max_frequency"] = 8e3
    scene["contact"]["stiffness"] = 1e14
    # the scene's probe is not within a plate that is made smaller
    scene["output"] = {"rate": 100e3}
    scene["time"] = {"scheme": scheme, "tolerance" if scheme == "adaptive"
                     else "step": setting, **time}
    return scene


def results(case, scene):
    return case.run(scene, *(AREAL_SAMPLED if scene["scene"].get("kind") == "areal" else SAMPLED),
                    *OF_SHOCKS)


def apart(first, second, powers, factor):
    """(largest difference of any of the sampled, of any of the shocks), each over its largest
    value; and whether all bits are the same. inf where one has other shocks than the other."""
    time, displacement, velocity, force, energy = (float(factor)**power for power in powers)
    worst, bits = [0.0, 0.0], True
    for i, (a, b, scale) in enumerate(zip(first, second, (time, displacement, velocity, force,
                                                          energy, time, time, force))):
        if a.shape != b.shape:
            return np.inf, np.inf, False
        a = a * scale
        bits = bits and np.array_equal(a, b)
        shock = i >= len(SAMPLED)
        if a.size:
            worst[shock] = max(worst[shock], np.abs(a - b).max() / np.abs(a).max())
    return *worst, bits


SCENES = {"pinned": ("dang2012-pinned", 0.02), "free": ("dang2012", 0.002)}
NUDGED = 5  # runs over a second that differ in the last digits of the heights
ADAPTIVE, EULER = ("adaptive", 1e-12), ("backward-euler", 1e-8)


def twice_of(group):
    """A power of two that rounds nothing: modes go with 1/sqrt(length)."""
    return 4.0 if group == "lengths" else 2.0


def rounds(scheme, group):
    """Whether a power of two rounds all the same: the clock of adaptive counts in units of less
    than 2^-60 s."""
    return scheme == "adaptive" and group == "rates"


def nudged(scene, part):
    """The scene, the heights of its slider larger by a small part."""
    return changed(scene, {("slider", "surface", "rq"): 1}, 1 + part)


def compare_areal(case):
    listed = [("free", "adaptive", 1e-9, {}),
              ("rigid", "backward-euler", 5e-7, {"contact_force": "new"}),
              ("rigid", "adaptive", 1e-6, {}), ("free", "backward-euler", 5e-7, {}),
              ("free", "rk4", 2e-7, {"nodes": "all"})]
    for support, scheme, setting, time in listed[:2] if case.short else listed:
        base = areal(support, scheme, setting, **time)
        first = results(case, base)
        if not len(first[5]):
            raise SystemExit(f"scaling: nothing touches in the areal scene, {support}: a longer "
                             "run is needed")
        groups = {group: twice_of(group) for group in AREAL_GROUPS if not rounds(scheme, group)}
        same = [apart(first, results(case, changed(base, AREAL_GROUPS[group][0], factor)),
                      AREAL_GROUPS[group][1], factor)[2]
                for group, factor in groups.items()]
        case.check(f"areal, {support}, `{scheme}`: groups whose bits differ though nothing rounds",
                   same.count(False), 0.5,
                   "a power of two rounds nothing")


def compare(case):
    rows = []
    compare_areal(case)
    for kind, (name, duration) in SCENES.items():
        for scheme, setting in (ADAPTIVE, EULER):
            base = papers(name, duration / 4 if case.short else duration, scheme, setting)
            first = results(case, base)
            if not len(first[5]):
                raise SystemExit(f"scaling: nothing touches in {name}: a longer run is needed")
            bits = {}
            for group, (changes, powers) in GROUPS.items():
                factor = twice_of(group)
                bits[group] = apart(first, results(case, changed(base, changes, factor)),
                                    powers, factor)[2]
            case.check(f"{kind}, `{scheme}`: groups whose bits differ though nothing rounds",
                       sum(not same for group, same in bits.items() if not rounds(scheme, group)),
                       0.5, "a power of two rounds nothing")
            # at fixed steps every step rounds the overlaps: 10^5 times as often
            if scheme != "adaptive":
                rows += [(kind, scheme, group, same, np.nan, np.nan, np.nan)
                         for group, same in bits.items()]
                continue
            nudge = 1e-9  # by this, the heights of the slider
            growth = max(apart(first, results(case, nudged(base, nudge)), (0,) * 5, 1)[:2]) / nudge
            bound = growth * (64 * np.finfo(float).eps + 10 * setting)
            for group, (changes, powers) in GROUPS.items():
                sampled, shocks, _ = apart(first, results(case, changed(base, changes, 3.0)),
                                           powers, 3.0)
                case.check(f"{kind}, `{scheme}`: results by a factor of three",
                           max(sampled, shocks), bound,
                           "64 roundings of the heights and ten tolerances, as the motion makes a "
                           "change of the heights grow")
                rows.append((kind, scheme, group, bits[group], sampled, shocks, bound))
    if not case.short:
        report(case, rows)


def level(case, scene):
    return float(case.run(scene, "level/lv")[0])


# what a table says of the groups: what is multiplied, and what then goes with it
WORDS = {
    "heights": ("`rq`, `gap`, `load`: s", "displacements, velocities, forces s; energies s^2"),
    "rates":
    ("`young`, `stiffness`, `load`: s^2; `speed`, `max_frequency`, `rate`: s; `duration`, `step`: "
     "1/s",
     "times 1/s; velocities s; forces, energies s^2"),
    "lengths": ("`length`, `spacing`, `start`, `rsm`, `probes`, `speed`, `load`: s; `young`: s^4",
                "forces, energies s"),
    "masses": ("`young`, `density`, `stiffness`, `load`: s", "forces, energies s"),
    "widths": ("`width`, `load`: s", "forces, energies s"),
    "thicknesses": ("`thickness`: s; `young`: s^-3; `density`: 1/s", "nothing"),
}


def report(case, rows):
    case.table(("slider", "scheme", "group", "same bits by a power of two", "samples by three",
                "shocks by three", "bound"), rows)
    found = {row[:3]: row[3:] for row in rows}
    table = []
    for group, words in WORDS.items():
        bits = ["same bits" if all(found[kind, scheme, group][0] for kind in SCENES) else "rounds"
                for scheme in ("backward-euler", "adaptive")]
        three = [common.shown(max(found[kind, "adaptive", group][1:3])) for kind in SCENES]
        table.append((group, *words, *bits, *three))
    case.text("table",
              common.markdown(("", "multiplied", "then go with",
                               "s a power of two: `backward-euler`", "`adaptive`",
                               "s = 3, `adaptive`: pinned", "free"), table))
    # through a whole second of chaos, and without the load that the group asks for
    changes = GROUPS["heights"][0]
    case.text("nudged", f"{NUDGED}")
    without_load = {key: power for key, power in changes.items() if key != LOAD}
    table = []
    for kind, (name, _) in SCENES.items():
        base = papers(name, 1.0, "adaptive", 1e-8)
        base["output"]["rate"] = 1e4
        first = level(case, base)
        spread = np.std([level(case, nudged(base, 1e-15 * i)) for i in range(1, NUDGED + 1)],
                        ddof=1)
        case.text(f"{kind}-spread", spread)
        for factor in (2.0, 3.0):
            more = level(case, changed(base, changes, factor)) - first
            alone = level(case, changed(base, without_load, factor)) - first
            wanted = 20 * np.log10(factor)
            table.append((kind, f"{factor:.0f}", f"{wanted:.4f}", f"{more:.4f}",
                          f"{alone:.4f}" if kind == "free" else "no load"))
            if factor == 2:
                case.check(f"{kind}: level over a second, heights and load doubled, off by dB",
                           abs(more - wanted), 1e-9,
                           "roundings of a logarithm")
    case.text("levels",
              common.markdown(("slider", "heights times", "20 log10 of it, dB",
                               "level rises by, dB",
                               "with the load left as it is, dB"), table))
    draw(case)


def draw(case):
    plt, style = common.pyplot()
    figure, panels = plt.subplots(2, 1, figsize=(7, 6), layout="constrained")
    colours = dict(zip(GROUPS, (style.BLUE, style.RUST, style.GREEN, style.PLUM, style.AMBER,
                                style.BLACK)))
    for axes, (kind, (name, _)), duration, unit in zip(panels, SCENES.items(),
                                                       (0.15, 0.012), (1, 1e-3)):
        base = papers(name, duration, *ADAPTIVE)
        base["output"]["rate"] = 150 / duration
        first = results(case, base)
        for group, (changes, powers) in GROUPS.items():
            if group in ("widths", "thicknesses"):  # the bits of masses, and of the scene itself
                continue
            velocity = results(case, changed(base, changes, 3.0))[2]
            difference = np.abs(first[2] * 3.0**powers[2] - velocity)[1:,
                                                                      0] / np.abs(velocity).max()
            axes.semilogy(1e3 * first[0][1:], difference, color=colours[group], lw=1, label=group)
        axes.set(title=f"{name}.toml, everything by a factor of three", xlabel="ms",
                 ylabel="velocity of the middle,\ndifference over the largest", ylim=(1e-17, 3))
    panels[0].legend(loc="lower right", ncols=4)
    case.figure(figure)


if __name__ == "__main__":
    common.main("scaling", compare)
