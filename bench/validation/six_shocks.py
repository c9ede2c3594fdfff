#!/usr/bin/env python3
# SPDX-License-Identifier: BSD-3-Clause
"""The paper's first test (its Fig. 2, 3): one peak passes six, beside plane-strain finite elements.

six_shocks_calculix.py has the numbers of the scene and what CalculiX makes of it. That takes
minutes, so its results are kept in docs/validation/six-shocks-*.csv, and the short form compares
with these.

Two things part the two by theory. A beam of Euler and Bernoulli has neither shear nor rotary
inertia, and finite elements have both. And the implicit steps of CalculiX (Hilber, Hughes and
Taylor) lower the frequencies of the higher modes and damp them. How far each moves the shocks, a
few lines here say: the same modes and contact, marched on their own, with the frequencies of either
theory (Timoshenko's for pinned ends, in closed form), exactly or in those steps. These are
differences observed in this scene, no bounds. What is checked of the explanation is its direction:
beams with shear must come nearer to the finite elements than ra2d's.
"""
import csv
import resource

import numpy as np

import common
from six_shocks_calculix import (BEST, DENSITY, DURATION, HALF_WIDTH, HEIGHT, MESH_ALONE, MESHES,
                                 OVERLAP, PEAKS, PITCH, POISSON,
                                 RESONATOR, SLIDER, SPEED, STIFFNESS, THICKNESS, WIDTH, YOUNG,
                                 input_text, peak)

PLANE_STRAIN = YOUNG / (1 - POISSON**2)
SPACING = 5e-6
# modes of resonator and slider: those up to 20 kHz, ten and twenty of each
AUDIBLE, TEN, MORE = (6, 2), (10, 10), (20, 20)
MODES = (AUDIBLE, (8, 4), TEN, MORE, (40, 40))


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
        return {"support": "pinned", "length": length, "thickness": THICKNESS, "width": WIDTH,
                "young": young,
                "density": DENSITY, "damping": 0.0, "modes": count,
                "surface": {"kind": "file", "path": f"{name}.csv"}}

    return {
        "scene": {"duration": DURATION, "speed": SPEED, "start": 0.0,
                  "gap": 2 * HEIGHT - OVERLAP - sum(mean.values()),
                  "spacing": SPACING, "faces": "linear", "initial": "rest"},
        "resonator": body("resonator", RESONATOR, modes[0]),
        "slider": body("slider", SLIDER, modes[1]),
        "contact": {"law": "penalty", "stiffness": stiffness},
        "time": {"scheme": scheme, "tolerance" if scheme == "adaptive" else "step": setting},
        "output": {"rate": 1e6, "slider_probes": [SLIDER / 2]},
    }


def marched(case, modes=TEN, young=PLANE_STRAIN, stiffness=STIFFNESS, scheme="adaptive",
            setting=1e-9):
    """Time, displacement of the summit, contact force, largest pressure, as the columns of
    six-shocks-*.csv, and the pressure at the summit."""
    time, probe, force, lower, upper = case.run(scene(case, modes, young, stiffness, scheme,
                                                      setting), "time",
                                                "slider_probes/displacement", "contact/force",
                                                "resonator/displacement", "slider/displacement")
    near = np.arange(-HALF_WIDTH, HALF_WIDTH, SPACING)  # of the summit
    pressure = np.zeros((len(time), 2))
    for i in np.flatnonzero(force):
        x = SLIDER / 2 + SPEED * time[i] + near
        gap = (2 * HEIGHT - OVERLAP - peak(near) - sum(peak(x - at) for at in PEAKS)
               - shapes(SLIDER, modes[1], SLIDER / 2 + near) @ upper[i]
               - shapes(RESONATOR, modes[0], x) @ lower[i])
        pressure[i] = stiffness * np.maximum(0, -np.array([gap.min(), gap[len(near) // 2]]))
    return np.column_stack([time, probe[:, 0], force, pressure])


def waves(length, count):
    return np.arange(1, count + 1) * np.pi / length


def shapes(length, count, x):
    return np.sqrt(2 / length) * np.sin(np.outer(x, waves(length, count)))


def theory(length, count, shear):
    """Natural frequencies [1/s] and masses [kg/m^2] of a pinned strip's modes, with shear and
    rotary inertia or without. Shear coefficient: Cowper's for a rectangle of that Poisson's ratio
    under plane strain, 5/(6 - nu)."""
    k, r2 = waves(length, count), THICKNESS**2 / 12
    if not shear:
        return np.sqrt(PLANE_STRAIN * r2 / DENSITY) * k**2, np.full(count, DENSITY * THICKNESS)
    stiff = 5 / (6 - POISSON) * YOUNG / (2 * (1 + POISSON))
    a, b, c = DENSITY * r2 / stiff, 1 + r2 * k**2 * (1
                                                     + PLANE_STRAIN
                                                     / stiff), PLANE_STRAIN * r2 * k**4 / DENSITY
    square = (b - np.sqrt(b**2 - 4 * a * c)) / (2 * a)
    turn = k - DENSITY * square / (stiff * k)  # of the cross section, over the deflection
    return np.sqrt(square), DENSITY * THICKNESS * (1 + r2 * turn**2)


def meeting(shear, modes, spacing, speed=SPEED, overlap=OVERLAP):
    """Natural frequencies and masses of both beams' modes, what they make at the upper summit, and
    a function of time: what they make near it, and the gap of beams at rest there."""
    omega, mass = map(np.concatenate,
                      zip(*(theory(length, count, shear)
                            for length, count in zip((RESONATOR, SLIDER), modes))))
    near = np.arange(-1.2e-3, 1.2e-3, spacing)
    face, upper = peak(near), shapes(SLIDER, modes[1], SLIDER / 2 + near)

    def faces(time):
        x = SLIDER / 2 + speed * time
        off = x - min(PEAKS, key=lambda at: abs(at - x))
        if abs(off) > 1.2e-3:
            return np.zeros((1, len(omega))), np.ones(1)
        return np.hstack([shapes(RESONATOR, modes[0], x + near),
                          upper]), 2 * HEIGHT - overlap - face - peak(near + off)
    return omega, mass, np.append(np.zeros(modes[0]), shapes(SLIDER, modes[1], [SLIDER / 2])), faces


def by_hand(shear, step=4e-7, spacing=2e-5, speed=SPEED, overlap=OVERLAP):
    """The columns of six-shocks-*.csv: modes turn exactly over a step, forces are blows between."""
    omega, mass, summit, faces = meeting(shear, TEN, spacing, speed, overlap)
    cosine, sine = np.cos(omega * step), np.sin(omega * step)
    u, v = np.zeros((2, len(omega)))
    found = []
    for time in step * np.arange(round(DURATION * SPEED / speed / step)):
        shape, gap = faces(time)
        pressure = STIFFNESS * np.maximum(0, shape @ u - gap)
        v = v - step * spacing * (pressure @ shape) / mass
        found.append((time, summit @ u, WIDTH * spacing * pressure.sum(), pressure.max()))
        u, v = cosine * u + sine / omega * v, cosine * v - omega * sine * u
    return np.array(found)


def in_steps(step, modes=TEN, spacing=2e-5, alpha=-0.05):
    """The same with shear, modes and contact in the implicit steps of CalculiX."""
    omega, mass, summit, faces = meeting(True, modes, spacing)
    beta, gamma = (1 - alpha)**2 / 4, 0.5 - alpha
    share = (1 + alpha) * beta * step**2
    u, v, a, force = np.zeros((4, len(omega)))
    found = []
    for time in step * np.arange(round(DURATION / step) + 1):
        shape, gap = faces(time)
        ahead, new, last = u + step * v + (0.5 - beta) * step**2 * a, a, force
        for _ in range(50):  # Newton's
            u = ahead + beta * step**2 * new
            pressure = STIFFNESS * np.maximum(0, shape @ u - gap)
            force = mass * omega**2 * u + spacing * (pressure @ shape)
            touching = shape[pressure > 0]
            change = np.linalg.solve(np.diag(mass * (1 + share * omega**2))
                                     + share * STIFFNESS * spacing * touching.T @ touching,
                                     mass * new + (1 + alpha) * force - alpha * last)
            new = new - change
            if np.abs(change).max() <= 1e-9 * np.abs(new).max():
                break
        v, a = v + step * ((1 - gamma) * a + gamma * new), new
        found.append((time, summit @ u, WIDTH * spacing * pressure.sum(), pressure.max()))
    return np.array(found)


def shocks(found, speed=SPEED):
    """Of each peak: time of the impulse's centre [s], impulse [N s], largest force [N], largest
    pressure [Pa]; NaN where nothing touches."""
    rows = []
    for at in PEAKS:
        part = found[np.abs(SLIDER / 2 + speed * found[:, 0] - at) <= PITCH / 2]
        time, force = part[:, 0], part[:, 2]
        impulse = np.trapz(force, time)
        rows.append((np.trapz(force * time, time) / impulse if impulse else np.nan, impulse,
                     force.max(), part[:, 3].max()))
    return np.array(rows)


def calculix(mesh):
    """What CalculiX has found, its processor time [s], its version."""
    with open(common.ROOT / "docs" / "validation" / f"six-shocks-{mesh}.csv") as file:
        (note,), _, *rows = csv.reader(file)
    return np.array(rows, dtype=float), float(note.split(":")[1].split()[0]), note.split()[-1]


MEASURES = ("times, s", "impulses, over the largest", "pressures, over their own",
            "displacement of the summit, over the largest")


def apart(first, second, many=len(PEAKS)):
    """Largest differences of so many shocks: of times [s], impulses over the second's largest,
    pressures over the second's own; inf where a shock is missing."""
    first, second = first[:many], second[:many]
    off = np.abs(first - second)
    found = off[:, 0].max(), off[:, 1].max() / second[:, 1].max(), (off[:, 3] / second[:, 3]).max()
    return tuple(np.inf if np.isnan(off[:, 0]).any() else each for each in found)


def displaced(first, second, many=len(PEAKS)):
    """Largest difference of the summit's displacement over the second's largest, until the shock
    after so many."""
    until = (PEAKS[0] + many * PITCH - HALF_WIDTH / 2 - SLIDER / 2) / SPEED
    second = second[second[:, 0] < until]
    return np.abs(np.interp(second[:, 0], first[:, 0], first[:, 1])
                  - second[:, 1]).max() / np.abs(second[:, 1]).max()


def differences(first, second, many=len(PEAKS)):
    """One of each of MEASURES."""
    return *apart(shocks(first), shocks(second), many), displaced(first, second, many)


def compare(case):
    kept = (common.ROOT / "docs" / "validation" / "six-shocks.inp").read_text().splitlines()
    case.check("CalculiX: lines of the input that are not those of its kept results",
               len(set(kept) ^ set(input_text(BEST).splitlines())), 0.5,
               "the results are of this scene")
    best, found, plain, shear = calculix(BEST)[0], marched(case), by_hand(False), by_hand(True)
    rough = differences(by_hand(False, step=8e-7, spacing=4e-5), plain)
    for what, ours, most in zip(MEASURES, differences(found, plain), rough):
        case.check(f"ra2d beside the same modes by hand: {what}", ours, most,
                   "what these move with twice their step and spacing")
    for what, with_shear, without in zip(MEASURES, differences(shear, best),
                                         differences(found, best)):
        case.check(f"beams with shear by hand, from CalculiX over ra2d from CalculiX: {what}",
                   with_shear / without, 1,
                   "if shear is the difference, beams that have it are nearer")
    if not case.short:
        report(case, found, best, plain, shear)


def row(found, peer, many=len(PEAKS)):
    """The differences as a table has them."""
    times, *others = differences(found, peer, many)
    return in_us(times), *map(percent, others)


def of_answers(case, what, setting, best, many):
    """A row of a table: how far ra2d's answer is from CalculiX's, and from its own with many modes;
    the processor time of a run, the median of five."""
    took = []
    for _ in range(5):
        before = resource.getrusage(resource.RUSAGE_CHILDREN).ru_utime
        found = marched(case, **setting)
        took.append(resource.getrusage(resource.RUSAGE_CHILDREN).ru_utime - before)
    return what, *row(found, best), *row(found, many)[:2], common.shown(np.median(took))


def of_mesh(mesh):
    return mesh.replace("-elements-", " elements at ").replace("us", " us")


def in_us(seconds):
    return common.shown(1e6 * seconds) if np.isfinite(seconds) else "a shock is missing"


def percent(share):
    return common.shown(100 * share) if np.isfinite(share) else "a shock is missing"


def report(case, found, best, plain, shear):
    step, (coarse, fine) = MESHES[BEST][-1], (calculix(mesh)[0] for mesh in MESH_ALONE)
    causes = {"shear and rotary inertia": (shear, plain),
              f"CalculiX's steps of {in_us(step)} us": (in_steps(step), shear),
              f"{MORE[0]} modes of each beam instead of {TEN[0]}": (marched(case, MORE), found),
              f"its mesh: {of_mesh(MESH_ALONE[1])}, instead of {of_mesh(MESH_ALONE[0])}":
              (fine, coarse)}
    case.text("audible",
              " and ".join(f"{(theory(length, 40, False)[0] < 2 * np.pi * 20e3).sum()} of the "
                           f"{which} beam"
                           for which, length in (("lower", RESONATOR), ("upper", SLIDER))))
    of = {"ra2d": shocks(found), "calculix": shocks(best),
          "audible": shocks(marched(case, AUDIBLE))}
    rows = []
    for i in range(len(PEAKS)):
        peer, ours, few = (of[name][i] for name in ("calculix", "ra2d", "audible"))
        rows.append((i + 1, f"{1e6 * peer[0]:.1f}", f"{1e6 * (ours[0] - peer[0]):+.1f}",
                     f"{1e6 * (few[0] - peer[0]):+.1f}",
                     f"{1e6 * peer[1]:.3f}", f"{100 * (ours[1] / peer[1] - 1):+.1f}",
                     f"{100 * (few[1] / peer[1] - 1):+.1f}",
                     f"{1e-3 * peer[3]:.1f}", f"{100 * (ours[3] / peer[3] - 1):+.1f}"))
    case.text("shocks", common.markdown(
        ("peak", "CalculiX: time, us", "ra2d, ten modes, us", "audible modes, us",
         "CalculiX: impulse, uN s", "ra2d, %",
         "audible modes, %", "CalculiX: largest pressure, kPa", "ra2d, %"), rows))
    many = marched(case, MODES[-1])
    for name, modes in (("ten", TEN), ("audible", AUDIBLE)):
        case.text(f"{name}-times", row(marched(case, modes), many)[0])
        case.text(f"{name}-impulses", row(marched(case, modes), many)[1])
    head = ("", "times, us", "impulses, %", "pressures, %", "displacement, %",
            "from forty modes: times, us", "impulses, %", "takes, s")
    rows = {(lower, upper): of_answers(case, f"{lower} and {upper} modes",
                                       {"modes": (lower, upper)}, best, many)
            for lower, upper in MODES}
    case.text("modes", common.markdown(head, rows.values()))
    case.text("seconds-ra2d", rows[TEN][-1])
    case.text("choices", common.markdown(head, [
        ("ten modes, `adaptive`, 1e-9", *rows[TEN][1:]),
        of_answers(case, "`backward-euler`, 1e-7 s", {"scheme": "backward-euler", "setting": 1e-7},
                   best, many),
        of_answers(case, "`backward-euler`, 1e-8 s", {"scheme": "backward-euler", "setting": 1e-8},
                   best, many),
        of_answers(case, "E instead of E/(1 - nu²)", {"young": YOUNG}, best, many)]))
    case.text("steps", common.markdown(
        ("CalculiX", *(f"{name}: {what}" for name in ("ra2d", "with shear")
                       for what in ("times, us", "impulses, %")),
         "with shear, in its steps: times, us", "impulses, %", "pressures, %", "displacement, %"),
        [(of_mesh(mesh), *row(found, peer)[:2], *row(shear, peer)[:2],
          *row(in_steps(MESHES[mesh][-1]), peer))
         for mesh, peer in ((mesh, calculix(mesh)[0]) for mesh in MESHES)]))
    coarse, fine = (calculix(f"{elements}-elements-2us")[0] for elements in (280, 720))
    case.text("mesh", row(fine, coarse)[0])
    for name, peer in (("coarse", coarse), ("fine", fine)):
        case.text(f"{name}-left", row(in_steps(2e-6), peer)[0])
    case.text("causes",
              common.markdown(("", "times, us", "impulses, %", "pressures, %", "displacement, %"), [
        (what, *row(*pair)) for what, pair in causes.items()]))
    faster = [shocks(by_hand(each, speed=10.0, overlap=2e-7), 10.0) for each in (True, False)]
    case.text("faster-times", in_us(apart(*faster)[0]))
    case.text("faster-impulses", percent(apart(*faster)[1]))
    for name, so_many in (("two", 2), ("five", 5), ("all", len(PEAKS))):
        for measure, ours, hand in zip(("times", "impulses", "pressures", "displacement"),
                                       row(found, best, so_many),
                                       row(shear, best, so_many)):
            case.text(f"{name}-{measure}", ours)
            case.text(f"{name}-{measure}-shear", hand)
    touched = [best[(best[:, 2] > 0) & (np.abs(SLIDER / 2 + SPEED * best[:, 0] - at) <= PITCH / 2),
                    0] for at in PEAKS]
    for name, at in (("shortest", 0), ("longest", -1)):
        case.text(name, 1e6 * sorted(np.ptp(times) for times in touched)[at])
    summits = [found[np.abs(SLIDER / 2 + SPEED * found[:, 0] - at) <= PITCH / 2, 4].max()
               for at in PEAKS]
    case.text("summit", 1e-3 * max(summits))
    case.text("bare", str(sum(pressure == 0 for pressure in summits)))
    for name, stiffness in (("", STIFFNESS), ("-stiff", 1e15)):
        share, wide = local_compliance(best[:, 2].max(), stiffness)
        case.text(f"local{name}", 100 * share)
        case.text(f"wide{name}", 1e6 * wide)
    case.text("peer-seconds", calculix(BEST)[1], 1)
    case.text("peer-minutes", sum(calculix(mesh)[1] for mesh in MESHES) / 60)
    case.text("version", calculix(BEST)[2])
    for name, mesh in (("", BEST), ("fine-", MESH_ALONE[1])):
        text = input_text(mesh)
        case.text(f"{name}nodes", str(text.split("NSET=BEAMS\n")[1].split("*")[0].count("\n")))
        case.text(f"{name}elements",
                  str(sum(part.split("*")[0].count("\n") - 1
                          for part in text.split("TYPE=CPE6")[1:])))
        case.text(f"{name}step", 1e6 * MESHES[mesh][-1], 1)
    columns = ("time, s", "impulse, N s", "largest force, N", "largest pressure, Pa")
    case.table(("peak", *(f"{name}: {what}" for name in of for what in columns)),
               [(i + 1, *np.concatenate([of[name][i] for name in of])) for i in range(len(PEAKS))])
    draw(case, found, best)


def local_compliance(force, stiffness):
    """By how much the faces yield about the contact under a force [N], over what its own spring
    yields; its width [m]. A strip of half-width a under a line load f yields by f/(pi E') (2 ln(2
    d/a) - nu/(1 - nu)) as seen from a depth d (Johnson, Contact Mechanics, section 5.6); d is half
    the thickness, and there are two faces. Two parabolas that overlap by o touch over a = sqrt(o)
    half_width/sqrt(4 height), with the force kappa 4/3 o a."""
    load, width = force / WIDTH, HALF_WIDTH / np.sqrt(4 * HEIGHT)
    overlap = (0.75 * load / (stiffness * width))**(2 / 3)
    a = width * np.sqrt(overlap)
    return 2 * load / (np.pi * PLANE_STRAIN) * (2 * np.log(THICKNESS / a)
                                                - POISSON / (1 - POISSON)) / overlap, 2 * a


def draw(case, found, best):
    plt, style = common.pyplot()
    few = marched(case, AUDIBLE)
    figure = plt.figure(figsize=(7, 6), layout="constrained")
    grid = figure.add_gridspec(2, len(PEAKS))
    axes = figure.add_subplot(grid[0, :])
    lines = ((best, "CalculiX", style.BLACK, "-", 1.8),
             (found, "ra2d, ten modes", style.SKY, "-", 1.0),
             (few, "ra2d, audible modes", style.RUST, ":", 1.2))
    for each, label, colour, line, width in lines:
        axes.plot(1e3 * each[::6, 0], 1e9 * each[::6, 1], color=colour, ls=line, lw=width,
                  label=label)
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
