#!/usr/bin/env python3
# SPDX-License-Identifier: BSD-3-Clause
"""The paper's first test (its Fig. 2, 3): one peak passes six, beside plane-strain finite elements.

six_shocks_calculix.py has the numbers of the scene and what CalculiX makes of it. That takes minutes, so its results are
kept in docs/validation/six-shocks-*.csv; the target six-shocks-calculix makes them anew.

Two things part the two by theory. A beam of Euler and Bernoulli has neither shear nor rotary inertia, and finite elements
have both. And the implicit steps of CalculiX (Hilber, Hughes and Taylor) lower the frequencies of the higher modes and
damp them. How far each moves the shocks, a few lines here say: the same modes and contact, marched on their own, with the
frequencies of either theory (Timoshenko's for pinned ends, in closed form), and with those that the steps make of them.
"""
import csv

import h5py
import numpy as np

import common
from six_shocks_calculix import (BEST, DENSITY, DURATION, HALF_WIDTH, HEIGHT, MESHES, OVERLAP, PEAKS, PITCH, POISSON, RESONATOR,
                                 SLIDER, SPEED, STIFFNESS, THICKNESS, WIDTH, YOUNG, input_text, peak)

PLANE_STRAIN = YOUNG / (1 - POISSON**2)
SPACING = 5e-6
AUDIBLE, TEN = (6, 2), (10, 10)  # modes of resonator and slider: those up to 20 kHz, and ten of each
MODES = (AUDIBLE, (8, 4), TEN, (20, 20), (40, 40))


def profile(case, name, length, peaks):
    """Writes a face to a file for ra2d; its mean height, which ra2d takes off."""
    x = SPACING * np.arange(round(length / SPACING) + 1)
    heights = sum(peak(x - at) for at in peaks)
    np.savetxt(case.scratch / name, np.column_stack([x, heights]), fmt="%.17g")
    return heights.mean()


def scene(case, modes, young, stiffness, scheme, setting):
    mean = {"slider": profile(case, "slider.csv", SLIDER, [SLIDER / 2]),
            "resonator": profile(case, "resonator.csv", RESONATOR, PEAKS)}

    def body(name, length, count):
        return {"support": "pinned", "length": length, "thickness": THICKNESS, "width": WIDTH, "young": young,
                "density": DENSITY, "damping": 0.0, "modes": count, "surface": {"kind": "file", "path": f"{name}.csv"}}

    return {
        "scene": {"duration": DURATION, "speed": SPEED, "start": 0.0, "gap": 2 * HEIGHT - OVERLAP - sum(mean.values()),
                  "spacing": SPACING, "initial": "rest"},
        "resonator": body("resonator", RESONATOR, modes[0]), "slider": body("slider", SLIDER, modes[1]),
        "contact": {"law": "penalty", "stiffness": stiffness},
        "time": {"scheme": scheme, "tolerance" if scheme == "adaptive" else "step": setting},
        "output": {"rate": 1e6, "slider_probes": [SLIDER / 2]},
    }


def marched(case, modes=TEN, young=PLANE_STRAIN, stiffness=STIFFNESS, scheme="adaptive", setting=1e-9):
    """Time, displacement of the summit, contact force, largest pressure: as the columns of six-shocks-*.csv."""
    time, probe, force, lower, upper = case.run(scene(case, modes, young, stiffness, scheme, setting), "time",
                                                "slider_probes/displacement", "contact/force",
                                                "resonator/displacement", "slider/displacement")
    near = np.arange(-HALF_WIDTH, HALF_WIDTH, SPACING)  # of the summit
    pressure = np.zeros(len(time))
    for i in np.flatnonzero(force):
        x = SLIDER / 2 + SPEED * time[i] + near
        gap = (2 * HEIGHT - OVERLAP - peak(near) - sum(peak(x - at) for at in PEAKS)
               - shapes(SLIDER, modes[1], SLIDER / 2 + near) @ upper[i] - shapes(RESONATOR, modes[0], x) @ lower[i])
        pressure[i] = stiffness * max(0, -gap.min())
    return np.column_stack([time, probe[:, 0], force, pressure])


def waves(length, count):
    return np.arange(1, count + 1) * np.pi / length


def shapes(length, count, x):
    return np.sqrt(2 / length) * np.sin(np.outer(x, waves(length, count)))


def theory(length, count, shear):
    """Natural frequencies [1/s] and masses [kg/m^2] of a pinned strip's modes, with shear and rotary inertia or without.
    Shear coefficient: Cowper's for a rectangle of that Poisson's ratio under plane strain, 5/(6 - nu)."""
    k, r2 = waves(length, count), THICKNESS**2 / 12
    if not shear:
        return np.sqrt(PLANE_STRAIN * r2 / DENSITY) * k**2, np.full(count, DENSITY * THICKNESS)
    stiff = 5 / (6 - POISSON) * YOUNG / (2 * (1 + POISSON))
    a, b, c = DENSITY * r2 / stiff, 1 + r2 * k**2 * (1 + PLANE_STRAIN / stiff), PLANE_STRAIN * r2 * k**4 / DENSITY
    square = (b - np.sqrt(b**2 - 4 * a * c)) / (2 * a)
    turn = k - DENSITY * square / (stiff * k)  # of the cross section, over the deflection
    return np.sqrt(square), DENSITY * THICKNESS * (1 + r2 * turn**2)


def in_steps(omega, step, alpha=-0.05):
    """Frequencies and decay [1/s] that the implicit steps of CalculiX make of natural frequencies [1/s]."""
    beta, gamma = (1 - alpha)**2 / 4, 0.5 - alpha
    roots = []
    for k in omega**2:
        new = [[1, 0, -beta * step**2], [0, 1, -gamma * step], [(1 + alpha) * k, 0, 1]]  # displacement, velocity, acceleration
        old = [[1, step, (0.5 - beta) * step**2], [0, 1, (1 - gamma) * step], [alpha * k, 0, 0]]
        root = max(np.linalg.eigvals(np.linalg.solve(new, old)), key=lambda each: each.imag)
        roots.append(np.log(root) / step)
    return np.imag(roots), -np.real(roots)


def by_hand(shear, peers_step=None, speed=SPEED, overlap=OVERLAP, modes=TEN, step=4e-7, spacing=2e-5):
    """Time, displacement of the summit and contact force: modes turn exactly over a step, forces are blows between."""
    omega, mass, state = map(list, zip(*((*theory(length, count, shear), np.zeros((2, count)))
                                         for length, count in ((RESONATOR, modes[0]), (SLIDER, modes[1])))))
    decay = [np.zeros_like(w) for w in omega]
    if peers_step:
        omega, decay = zip(*(in_steps(w, peers_step) for w in omega))
    turns = [(np.cos(w * step), np.sin(w * step)) for w in omega]
    losses = [np.exp(-d * step) for d in decay]
    near = np.arange(-1.2e-3, 1.2e-3, spacing)
    face, upper = peak(near), shapes(SLIDER, modes[1], SLIDER / 2 + near)
    summit = shapes(SLIDER, modes[1], [SLIDER / 2])[0]
    time = step * np.arange(round(DURATION * SPEED / speed / step))
    found = np.zeros((len(time), 3))
    for i, t in enumerate(time):
        x = SLIDER / 2 + speed * t
        off = x - min(PEAKS, key=lambda at: abs(at - x))
        force = 0.0
        if abs(off) < 1.2e-3:
            lower = shapes(RESONATOR, modes[0], x + near)
            gap = 2 * HEIGHT - overlap - face - peak(near + off) - upper @ state[1][0] - lower @ state[0][0]
            blows = STIFFNESS * spacing * np.maximum(0, -gap)
            force = WIDTH * blows.sum()
            for (_, velocity), shape, m in zip(state, (lower, upper), mass):
                velocity -= step * (blows @ shape) / m
        found[i] = t, summit @ state[1][0], force
        for w, (cosine, sine), lost, each in zip(omega, turns, losses, state):
            u, v = each
            each[:] = lost * (cosine * u + sine / w * v), lost * (cosine * v - w * sine * u)
    return found


def shocks(found, speed=SPEED):
    """Of each peak: time of the impulse's centre [s], impulse [N s], largest force [N], largest pressure [Pa]; NaN where
    nothing touches."""
    rows = []
    for at in PEAKS:
        part = found[np.abs(SLIDER / 2 + speed * found[:, 0] - at) <= PITCH / 2]
        time, force = part[:, 0], part[:, 2]
        impulse = np.trapz(force, time)
        rows.append((np.trapz(force * time, time) / impulse if impulse else np.nan, impulse, force.max(), part[:, -1].max()))
    return np.array(rows)


def calculix(mesh):
    """What CalculiX has found, and its processor time [s]."""
    with open(common.ROOT / "docs" / "validation" / f"six-shocks-{mesh}.csv") as file:
        (note,), _, *rows = csv.reader(file)
    return np.array(rows, dtype=float), float(note.split(":")[1].split()[0])


def apart(first, second, many=len(PEAKS)):
    """Largest difference of the times of so many shocks [s], and of their impulses over the second's largest; inf where one
    is missing."""
    off = np.abs(first - second)[:many]
    found = off[:, 0].max(), off[:, 1].max() / second[:many, 1].max()
    return tuple(np.inf if np.isnan(each) else each for each in found)


def displaced(first, second, many=len(PEAKS)):
    """Largest difference of the summit's displacement over the second's largest, until the shock after so many."""
    until = (PEAKS[0] + many * PITCH - HALF_WIDTH / 2 - SLIDER / 2) / SPEED
    second = second[second[:, 0] < until]
    return np.abs(np.interp(second[:, 0], first[:, 0], first[:, 1]) - second[:, 1]).max() / np.abs(second[:, 1]).max()


def differences(first, second, many=len(PEAKS)):
    return *apart(shocks(first), shocks(second), many), displaced(first, second, many)


def compare(case):
    kept = (common.ROOT / "docs" / "validation" / "six-shocks.inp").read_text().splitlines()
    case.check("CalculiX: lines of the input that are not those of its kept results",
               len(set(kept) ^ set(input_text(BEST).splitlines())), 0.5, "the results are of this scene")
    best, coarse, fine = (calculix(mesh)[0] for mesh in (BEST, "280-elements-4us", "720-elements-4us"))
    found = marched(case)
    plain, shear, stepped = by_hand(False), by_hand(True), by_hand(True, MESHES[BEST][-1])
    causes = {"shear and rotary inertia": (shear, plain), f"CalculiX's steps of {in_us(MESHES[BEST][-1])} us": (stepped, shear),
              "720 elements instead of 280, at 4 us": (fine, coarse)}
    rough = by_hand(False, step=8e-7, spacing=4e-5)
    for i, what in enumerate(("times, s", "impulses, over the largest")):
        case.check(f"ra2d beside the same modes by hand: {what}", apart(shocks(found), shocks(plain))[i],
                   apart(shocks(rough), shocks(plain))[i], "what these move with twice their step and spacing")
    answers = {"ra2d": (found, best), **causes}
    for many, words in ((3, "first three shocks"), (len(PEAKS), "all six")):
        moved = {what: differences(*pair, many) for what, pair in answers.items()}
        ours = moved.pop("ra2d")
        # by the end the displacements are a phase apart: a bound on them would say nothing
        measures = ("times, s", "impulses, over the largest", "displacement of the summit, over the largest")
        for i, what in enumerate(measures if many < len(PEAKS) else measures[:2]):
            case.check(f"{words}: {what}", ours[i], sum(each[i] for each in moved.values()),
                       "shear and rotary inertia, the peer's steps, its mesh: what each moves")
    case.text("left", 1e6 * apart(shocks(stepped), shocks(best), 3)[0])
    if not case.short:
        report(case, found, best, moved)


def of_answers(case, what, setting, best, many):
    """A row of a table: how far ra2d's answer is from CalculiX's, and from its own with many modes."""
    found, took = marched(case, **setting), seconds_of_last(case)
    pressures = np.abs(shocks(found)[:, 3] / shocks(best)[:, 3] - 1).max()
    return (what, *cells(found, best), percent(displaced(found, best)), percent(pressures), *cells(found, many), common.shown(took))


def seconds_of_last(case):
    """What the last run of ra2d took, by the clock [s]."""
    with h5py.File(case.scratch / "result.h5") as file:
        return float(file.attrs["wall_seconds"])


def cells(found, peer):
    times, impulses = apart(shocks(found), shocks(peer))
    return in_us(times), percent(impulses)


def in_us(seconds):
    return common.shown(1e6 * seconds) if np.isfinite(seconds) else "a shock is missing"


def percent(share):
    return common.shown(100 * share) if np.isfinite(share) else "a shock is missing"


def report(case, found, best, moved):
    marched(case)
    took = seconds_of_last(case)
    case.text("step", 1e6 * MESHES[BEST][-1], 1)
    case.text("seconds-ra2d", took)
    of = {"ra2d": shocks(found), "calculix": shocks(best), "audible": shocks(marched(case, AUDIBLE))}
    rows = []
    for i in range(len(PEAKS)):
        peer, ours, few = (of[name][i] for name in ("calculix", "ra2d", "audible"))
        rows.append((i + 1, f"{1e6 * peer[0]:.1f}", f"{1e6 * (ours[0] - peer[0]):+.1f}", f"{1e6 * (few[0] - peer[0]):+.1f}",
                     f"{1e6 * peer[1]:.3f}", f"{100 * (ours[1] / peer[1] - 1):+.1f}", f"{100 * (few[1] / peer[1] - 1):+.1f}",
                     f"{1e-3 * peer[3]:.1f}", f"{100 * (ours[3] / peer[3] - 1):+.1f}"))
    case.text("shocks", common.markdown(
        ("peak", "CalculiX: time, us", "ra2d, ten modes, us", "audible modes, us", "CalculiX: impulse, uN s", "ra2d, %",
         "audible modes, %", "CalculiX: largest pressure, kPa", "ra2d, %"), rows))
    many = marched(case, MODES[-1])
    for name in ("ten", "audible"):
        times, impulses = cells(found if name == "ten" else marched(case, AUDIBLE), many)
        case.text(f"{name}-times", times)
        case.text(f"{name}-impulses", impulses)
    head = ("", "times, us", "impulses, %", "displacement, %", "pressures, %",
            "from forty modes: times, us", "impulses, %", "takes, s")
    case.text("modes", common.markdown(head, [
        of_answers(case, f"{lower} and {upper} modes", {"modes": (lower, upper)}, best, many) for lower, upper in MODES]))
    case.text("choices", common.markdown(head, [
        of_answers(case, "ten modes, `adaptive`, 1e-9", {}, best, many),
        of_answers(case, "`backward-euler`, 1e-7 s", {"scheme": "backward-euler", "setting": 1e-7}, best, many),
        of_answers(case, "`backward-euler`, 1e-8 s", {"scheme": "backward-euler", "setting": 1e-8}, best, many),
        of_answers(case, "E instead of E/(1 - nu²)", {"young": YOUNG}, best, many)]))
    case.text("steps", common.markdown(
        ("CalculiX", *(f"{name}: {what}" for name in ("ra2d", "with shear", "with shear, in its steps")
                       for what in ("times, us", "impulses, %"))),
        [(mesh.replace("-elements-", " elements, ").replace("us", " us"),
          *(cell for ours in (found, by_hand(True), by_hand(True, MESHES[mesh][-1])) for cell in cells(ours, calculix(mesh)[0])))
         for mesh in MESHES]))
    case.text("causes", common.markdown(("", "times, us", "impulses, % of the largest", "displacement, % of the largest"), [
        (what, in_us(times), percent(impulses), percent(summit)) for what, (times, impulses, summit) in moved.items()]))
    faster = [shocks(by_hand(shear, speed=10.0, overlap=2e-7), 10.0) for shear in (True, False)]
    case.text("faster-times", in_us(apart(*faster)[0]))
    case.text("faster-impulses", percent(apart(*faster)[1]))
    times, impulses = apart(of["ra2d"], of["calculix"])
    case.text("times", 1e6 * times)
    case.text("impulses", 100 * impulses)
    case.text("local", 100 * local_compliance(best[:, 2].max(), STIFFNESS))
    case.text("local-stiff", 100 * local_compliance(best[:, 2].max(), 1e15))
    case.text("peer-seconds", calculix(BEST)[1], 1)
    text = input_text(BEST)
    case.text("nodes", str(text.split("NSET=BEAMS\n")[1].split("*")[0].count("\n")))
    case.text("elements", str(sum(part.split("*")[0].count("\n") - 1 for part in text.split("TYPE=CPE6")[1:])))
    columns = ("time, s", "impulse, N s", "largest force, N", "largest pressure, Pa")
    case.table(("peak", *(f"{name}: {what}" for name in of for what in columns)),
               [(i + 1, *np.concatenate([of[name][i] for name in of])) for i in range(len(PEAKS))])
    draw(case, found, best)


def local_compliance(force, stiffness):
    """By how much the faces yield about the contact under a force [N], over what the contact's own spring yields.
    A strip of half-width a under a line load f yields by f/(pi E') (2 ln(2 d/a) - nu/(1 - nu)) as seen from a depth d
    (Johnson, Contact Mechanics, section 5.6); d is half the thickness, and there are two faces. Two parabolas that overlap
    by o touch over a = sqrt(o) half_width/sqrt(4 height), with the force kappa 4/3 o a."""
    load, width = force / WIDTH, HALF_WIDTH / np.sqrt(4 * HEIGHT)
    overlap = (0.75 * load / (stiffness * width))**(2 / 3)
    a = width * np.sqrt(overlap)
    return 2 * load / (np.pi * PLANE_STRAIN) * (2 * np.log(THICKNESS / a) - POISSON / (1 - POISSON)) / overlap


def draw(case, found, best):
    plt, style = common.pictures()
    few = marched(case, AUDIBLE)
    figure = plt.figure(figsize=(7, 6), layout="constrained")
    grid = figure.add_gridspec(2, len(PEAKS))
    axes = figure.add_subplot(grid[0, :])
    lines = ((best, "CalculiX", style.BLACK, "-", 1.8), (found, "ra2d, ten modes", style.SKY, "-", 1.0),
             (few, "ra2d, audible modes", style.RUST, ":", 1.2))
    for each, label, colour, line, width in lines:
        axes.plot(1e3 * each[::4, 0], 1e9 * each[::4, 1], color=colour, ls=line, lw=width, label=label)
    axes.set(title="Displacement of the summit", xlabel="ms", ylabel="nm")
    axes.legend(loc="upper left", ncols=3)
    first = None
    for i, (time, *_) in enumerate(shocks(best)):
        first = axes = figure.add_subplot(grid[1, i], sharey=first)
        for each, _, colour, line, width in lines:
            part = each[np.abs(each[:, 0] - time) < 45e-6]
            axes.plot(1e6 * (part[:, 0] - time), 1e-3 * part[:, 3], color=colour, ls=line, lw=width)
        axes.set(xlim=(-45, 45), xticks=(-30, 0, 30), title=f"{1e3 * time:.2f} ms")
        axes.tick_params(labelleft=i == 0)
        if i == 0:
            axes.set(ylabel="largest pressure, kPa", xlabel="us")
    case.figure(figure)


if __name__ == "__main__":
    common.main("six-shocks", compare)
