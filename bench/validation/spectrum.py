#!/usr/bin/env python3
# SPDX-License-Identifier: BSD-3-Clause
"""Peaks of the spectrum beside natural frequencies, over the load; and the mesh's tone over the
spacing.

Two closed forms hold the peaks. Without load the slider hardly touches: the plate's own modes,
their damping ratio that of the scene. Under load the slider rides along: its mass and its inertia
against tilting join the modes,

    (mu delta_kl + M psi_k psi_l + J psi_k' psi_l') q'' + mu omega_k^2 q = 0   at the place of the
    slider.

Where it touches in one point off its middle, it also tilts away, and less of its mass joins: a
quarter at its end. A mode is heard most where it is driven most: the frequencies along the slider's
way are weighted with psi_k^2.
"""
import json
import tomllib

import numpy as np
import scipy.linalg
from scipy import stats

import common
import plate

SEEDS = 6
LOADS = (0.01, 0.1, 0.3, 1, 3, 10, 100)       # of the weight
# s, m: the slider's middle goes from 50 to 250 mm, at 0.1 m/s
DURATION, START = 2.0, 0.04
# m: of 14 um the tone lies between two natural frequencies
SPACINGS = (32e-6, 16e-6, 14e-6, 8e-6, 4e-6, 2e-6)
TONE_LOADS = (1, 100)
# Hz: what counts as the tone, and its two lines alone
SURROUNDINGS, NARROW = 50.0, 4.0
LINES = 12.5                                  # Hz, from line to line, for all spacings
PAPER = tomllib.loads((common.ROOT / "scenes" / "dang2012.toml").read_text())
SLIDER = PAPER["slider"]
MASS = SLIDER["density"] * SLIDER["length"] * SLIDER["thickness"] * SLIDER["width"]
TILTING = MASS * SLIDER["length"]**2 / 12
WEIGHT = MASS * 9.80665
MODES = int((plate.omegas(100) < 2 * np.pi * PAPER["resonator"]["max_frequency"]).sum())
NATURAL = plate.omegas(MODES) / (2 * np.pi)   # Hz
SHOWN = (2, 3, 4, 6, 8, 10, 13, 19)           # modes in the chapter's tables
FREE = 7                                      # from here on a mode has lines enough in a second


def papers(seed, load, duration=DURATION, start=START, spacing=8e-6, rate=50e3):
    scene = tomllib.loads((common.ROOT / "scenes" / "dang2012.toml").read_text())
    scene["scene"].update(duration=duration, start=start, spacing=spacing)
    for body in ("resonator", "slider"):
        scene[body]["surface"]["seed"] += 1000 * seed  # as a study does
    scene["slider"]["load"] = load * WEIGHT
    scene["time"] = {"scheme": "adaptive", "tolerance": 1e-6}
    scene["output"] = {"rate": rate, "probes": []}
    return scene


def analysed(case, scene, *words):
    """What `ra2d analyze --json` says of a run."""
    case.run(scene)
    return json.loads(case.call(case.program, "analyze", case.scratch / "result.h5",
                                "--json", *words))


def attached(place, mass=MASS, tilting=TILTING):
    """Natural frequencies [Hz] of the plate with a rigid body on it at a place."""
    shape, slope = plate.shapes(MODES, place), plate.shapes(MODES, place, 1)
    masses = plate.MASS_PER_LENGTH * np.eye(MODES) + mass * np.outer(shape,
                                                                     shape) + tilting * np.outer(
                                                                         slope, slope)
    stiffness = plate.MASS_PER_LENGTH * plate.omegas(MODES)**2
    return np.sqrt(scipy.linalg.eigh(np.diag(stiffness), masses, eigvals_only=True)) / (2 * np.pi)


def carried(mass, tilting):
    """How far each mode is moved by a body that rides along, of its frequency; over the slider's
    way."""
    path = START + SLIDER["length"] / 2 + np.linspace(0, DURATION * PAPER["scene"]["speed"], 201)
    weights = np.array([plate.shapes(MODES, place)**2 for place in path])
    moved = np.array([attached(place, mass, tilting) for place in path]) / NATURAL - 1
    return (moved * weights).sum(0) / weights.sum(0)


def peaks(found):
    """Relative shift and damping ratio of each mode: (run, mode), NaN where analyze gives none."""
    fits = [[(peak["resonance"], peak["damping"]) for peak in each["peaks"]] for each in found]
    fits = np.array(fits, dtype=float)  # null is NaN
    return fits[:, :, 0] / NATURAL - 1, fits[:, :, 1]


def mean(values, confidence=0.95):
    """Means over the runs, and half of their intervals of Student's t; NaN where a run has none."""
    return np.mean(values, axis=0), stats.t.ppf(0.5 + confidence / 2,
                                                len(values) - 1) * stats.sem(values, axis=0)


def undisturbed(case, found):
    """A slider that hardly touches leaves the plate as it is, but for the share of the time in
    which it may ride along."""
    touching = np.mean([each["contact_share"] for each in found])
    riding_along = touching * abs(carried(MASS, TILTING)[FREE - 1:].mean())
    for what, values, true, more in zip(("shift of the peaks", "half-power damping"), peaks(found),
                                        (0, SLIDER["damping"]), (riding_along, 0)):
        middle, half = mean(values[:, FREE - 1:].mean(axis=1), 0.999)
        case.check(f"load of {LOADS[0]} weights: {what}, mean over modes {FREE} to {MODES}, off by",
                   abs(middle - true + more / 2), half + more / 2,  # mass only lowers a peak
                   "the seeds: Student's t, 99.9 %" + (
                       "; and the slider's mass while it touches" if more else ""))


def riding(case, found):
    """Under a heavy slider a peak lies where a part of its mass, from a quarter to all, joins the
    mode."""
    least, most = carried(MASS / 4, 0), carried(MASS, TILTING)
    shift, half = mean(peaks(found)[0], 1 - 1e-3 / MODES)
    for mode in np.flatnonzero(np.isfinite(shift)):
        case.check(f"load of {LOADS[-1]} weights: shift of a peak, from the middle of what a "
                   "slider that rides along can do",
                   abs(shift[mode] - (least + most)[mode] / 2),
                   abs(least - most)[mode] / 2 + half[mode],
                   "a quarter of its mass to all of it, and the seeds: 99.9 % for all modes "
                   "together")


def passing(spacing):
    """How often nodes pass nodes [Hz]."""
    return PAPER["scene"]["speed"] / spacing


def tone_over_surroundings(analysis, frequency, most):
    """Mean square velocity [(m/s)^2] of the lines that lie no further than `most` [Hz] from a
    frequency."""
    lines, density = (np.array(analysis["spectrum"][name]) for name in ("frequency", "psd_mean"))
    return density[np.abs(lines - frequency) <= most].sum() * lines[1]


def tone(analysis, finest, frequency):
    """The tone's mean square velocity [(m/s)^2]: what the finest mesh has there, on the same
    surfaces, is noise. The lines to either side would not do for it: the noise itself has a peak
    where the tone stands on a resonance."""
    return tone_over_surroundings(analysis, frequency,
                                  SURROUNDINGS) - tone_over_surroundings(finest, frequency,
                                                                         SURROUNDINGS)


def rise(analysis, frequency):
    """`mesh_tone.rise` at another frequency [dB]: the highest of five lines above the median of the
    36 about them."""
    density = np.array(analysis["spectrum"]["psd_mean"])
    line = round(frequency / analysis["spectrum"]["frequency"][1])
    around = np.r_[density[line - 20:line - 2], density[line + 3:line + 21]]
    return 10 * np.log10(density[line - 2:line + 3].max() / np.median(around))


def with_spacing(case, load, spacing, duration=1.0, lines=LINES):
    rate = max(50e3, 0.25 / spacing)  # the tone must be within the spectrum
    return [analysed(case, papers(seed, load, duration, 0.1, spacing, rate), "--resolution", lines)
            for seed in range(SEEDS)]


def meshes(case, load, by_spacing):
    """Within the plate's modes, the line at speed/spacing is that of the mesh: a finer one has it
    not."""
    finest, missing = min(by_spacing), []
    for spacing, found in by_spacing.items():
        if spacing > finest and passing(spacing) < NATURAL[-1]:
            drop, half = mean([rise(fine, passing(spacing)) - each["mesh_tone"]["rise"]
                               for fine, each in zip(by_spacing[finest], found)], 0.99)
            missing.append(drop + half)
    case.check(f"load of {load} weights: how a spacing of {1e6 * finest:.0f} um changes the rise "
               "of the line at speed/spacing, dB, "
               "upper end of the interval", max(missing), 0,
               "the line is the mesh's, so it falls. The seeds: Student's t, 99 %")


def compare(case):
    if case.short:
        undisturbed(case, [analysed(case, papers(seed, LOADS[0], duration=1.0))
                           for seed in range(6)])
        meshes(case, 1, {spacing: with_spacing(case, 1, spacing, 0.5) for spacing in (16e-6, 8e-6)})
        return
    found = {load: [analysed(case, papers(seed, load)) for seed in range(SEEDS)] for load in LOADS}
    tones = {load: {spacing: with_spacing(case, load, spacing) for spacing in SPACINGS}
             for load in TONE_LOADS}
    undisturbed(case, found[LOADS[0]])
    riding(case, found[LOADS[-1]])
    for load, by_spacing in tones.items():
        meshes(case, load, by_spacing)
    report(case, found, tones)


def decibels(squares):
    """Levels [dB re 1 nm/s] of mean square velocities."""
    return 10 * np.log10(np.array(squares) / 1e-18)


def plus_minus(middle, half, unit=1.0):
    """mean ± half of the interval, with two digits of the latter."""
    if not np.isfinite(half):
        return "no fit"
    places = max(0, 1 - int(np.floor(np.log10(half / unit))))
    return f"{middle / unit:.{places}f} ± {half / unit:.{places}f}"


def report(case, found, tones):
    rows, tables = [], {"shift": [], "damping": []}
    for load, analyses in found.items():
        rate, contact = np.mean([(each["shocks"]["rate"], each["contact_share"])
                                 for each in analyses], axis=0)
        for name, values in zip(tables, peaks(analyses)):
            middle, half = mean(values)
            tables[name].append((load, common.shown(rate), f"{100 * contact:.3g} %",
                                 *(plus_minus(middle[mode - 1], half[mode - 1], 0.01)
                                   for mode in SHOWN)))
            rows += [(name, load, mode + 1, NATURAL[mode], middle[mode], half[mode])
                     for mode in range(MODES)]
    header = ("load / weight", "shocks a second", "time in contact",
              *(f"mode {mode}, {NATURAL[mode - 1]:.0f} Hz" for mode in SHOWN))
    forms = [(name, "", "", *(f"{100 * moved[mode - 1]:.1f}" for mode in SHOWN))
             for name, moved in (
        ("closed form: a quarter of the mass rides along", carried(MASS / 4, 0)),
        ("closed form: all of it", carried(MASS, TILTING)))]
    case.text("shift", common.markdown(header, [*tables["shift"], *forms]))
    case.text("damping", common.markdown(header, tables["damping"]))
    shift = mean(peaks(found[1])[0])[0]
    most = np.nanargmin(shift)
    case.text("largest-shift", -100 * shift[most])
    case.text("largest-mode", f"{most + 1}")
    case.text("quarter", -100 * carried(MASS / 4, 0)[most])
    case.text("whole", -100 * carried(MASS, TILTING)[most])
    middles, halves = zip(*(mean(peaks(analyses)[1]) for analyses in found.values()))
    load, mode = np.unravel_index(np.nanargmax(middles), np.shape(middles))
    case.text("largest-damping", plus_minus(middles[load][mode], halves[load][mode], 0.01))
    case.text("largest-damping-at", f"mode {mode + 1}, {LOADS[load]} weights")
    case.text("free-damping",
              plus_minus(*mean(peaks(found[LOADS[0]])[1][:, FREE - 1:].mean(axis=1)), 0.01))
    case.text("free-from", f"{FREE}")
    case.text("modes", f"{MODES}")
    case.text("first", NATURAL[0])
    case.text("first-width", 2 * SLIDER["damping"] * NATURAL[0])
    case.text("weight-contact", 100 * np.mean([each["contact_share"] for each in found[1]]))
    table, curves = [], {}
    for load, by_spacing in tones.items():
        finest = by_spacing[min(by_spacing)]  # has no tone but the noise: far below any
        levels = {spacing: decibels([max(tone(each, fine, passing(spacing)), 1e-30)
                                     for each, fine in zip(analyses, finest)])
                  for spacing, analyses in by_spacing.items()}
        for spacing, analyses in by_spacing.items():
            own, half = mean(levels[spacing])
            heard = levels[spacing].min() > 0
            less = mean(levels[2 * spacing]
                        - levels[spacing]) if heard and 2 * spacing in levels else None
            part = 10**((levels[spacing] - np.array([each["lv"] for each in analyses])) / 10)
            away = passing(spacing) / NATURAL[np.abs(NATURAL - passing(spacing)).argmin()] - 1
            rises = ([each["mesh_tone"]["rise"] for each in analyses],
                     [rise(each, passing(spacing)) for each in by_spacing[SPACINGS[-1]]])
            table.append((load, common.shown(1e6 * spacing), common.shown(passing(spacing)),
                          f"{100 * away:+.0f} %" if passing(spacing) < NATURAL[-1]
                          else "above the last",
                          plus_minus(own, half) if heard else "lost in the noise",
                          plus_minus(*less) if less else "",
                          common.shown(part.mean()) if heard else "",
                          *(plus_minus(*mean(each)) for each in rises),
                          plus_minus(*mean([each["lv"] for each in analyses]))))
            curves[load, spacing] = (own, half) if heard else (np.nan, np.nan)
            rows.append(("tone", load, spacing, passing(spacing), *curves[load, spacing]))
            if load == 1 and spacing == PAPER["scene"]["spacing"]:
                case.text("tone-part", part.mean())
                case.text("tone-at", f"{passing(spacing) / 1e3:.1f}")
            if less:
                case.text(f"less-{load}-{1e6 * spacing:.0f}", plus_minus(*less))
        case.text(f"between-{load}", plus_minus(*mean(levels[16e-6] - levels[14e-6])))
        if load == 1:
            case.text("tone-16", plus_minus(*mean(levels[16e-6])))
    narrow = with_spacing(case, 1, 16e-6, lines=1.0)
    case.text("tone-16-narrow",
              plus_minus(*mean(decibels([tone_over_surroundings(each, passing(16e-6), NARROW)
                                         for each in narrow]))))
    mode = np.abs(NATURAL - passing(16e-6)).argmin() + 1
    case.text("split", mode * PAPER["scene"]["speed"] / (2 * plate.LENGTH))
    case.text("split-mode", f"{mode}")
    case.text("beside", f"{SURROUNDINGS:.0f}")
    case.text("narrow", f"{NARROW:.0f}")
    case.text("tone", common.markdown(
        ("load / weight", "spacing, um", "tone, Hz", "from the nearest natural frequency",
         "tone, dB re 1 nm/s",
         "less than at twice the spacing, dB", "part of the energy", "its line's rise, dB",
         f"the same line's rise at {1e6 * SPACINGS[-1]:.0f} um, dB", "level Lv, dB"), table))
    case.text("seeds", f"{SEEDS}")
    case.table(("what", "load over weight", "mode, or spacing, m", "frequency, Hz", "value",
                "half of its 95 % interval"), rows)
    draw(case, found, curves)


def draw(case, found, curves):
    plt, style = common.pyplot()
    figure, ((density, falling), (shift, damping)) = plt.subplots(2, 2, figsize=(9, 7),
                                                                  layout="constrained")
    for load, colour in ((LOADS[0], style.SKY), (1, style.BLUE), (LOADS[-1], style.RUST)):
        spectra = [each["spectrum"] for each in found[load]]
        frequency, mean_density = np.array(spectra[0]["frequency"]), np.mean(
            [each["psd_mean"] for each in spectra], axis=0)
        edges = np.geomspace(30, 25e3, 701)  # means over narrow bands: a small picture
        counts, sums, middles = (np.histogram(frequency, edges, weights=each)[0]
                                 for each in (None, mean_density, frequency))
        some = counts > 0
        density.loglog((middles / np.maximum(counts, 1))[some],
                       (sums / np.maximum(counts, 1))[some], color=colour, lw=0.8,
                       label=f"{load} weights" if load != 1 else "its weight")
    for natural in NATURAL:
        density.axvline(natural, color=style.GREY, lw=0.5, alpha=0.6, zorder=0)
    density.set(title="Density of the plate's velocity (lines: natural)", xlabel="Hz",
                ylabel="(m/s)\u00b2/Hz",
                xlim=(30, 25e3), ylim=(1e-15, 1e-5))
    density.legend(loc="lower left")
    for axes, which in ((shift, 0), (damping, 1)):
        for (load, analyses), colour, mark in zip(found.items(), style.SERIES, style.MARKS):
            if load in (0.1, 10):
                continue
            middle, half = mean(peaks(analyses)[which])
            axes.errorbar(NATURAL, 100 * middle, yerr=100 * half, color=colour, marker=mark, ms=3.5,
                          lw=0.9, capsize=2,
                          label=f"{load} weights" if load != 1 else "its weight")
        axes.set(xscale="log", xlabel="natural frequency [Hz]", ylabel="%")
    shift.fill_between(NATURAL, 100 * carried(MASS / 4, 0), 100 * carried(MASS, TILTING),
                       color=style.GREY, alpha=0.15, lw=0,
                       label="closed form: it rides along")
    shift.set(title="Shift of the peaks", xlim=(150, 22e3), ylim=(-6, 4))
    damping.axhline(100 * SLIDER["damping"], color=style.GREY, lw=1)
    damping.set(title="Half-power damping (line: the scene's)", xlim=(150, 22e3), ylim=(1.5, 6))
    shift.legend(loc="upper left", ncols=2, fontsize=7.5)
    for load, colour, mark in zip(TONE_LOADS, (style.BLUE, style.RUST), style.MARKS):
        middle, half = zip(*(curves[load, spacing] for spacing in SPACINGS))
        falling.errorbar([1e6 * spacing for spacing in SPACINGS], middle, yerr=half, color=colour,
                         marker=mark, ms=4, lw=1.2,
                         capsize=2, label=f"{load} weights" if load != 1 else "its weight")
    falling.axvspan(0.1e6 / NATURAL[-1], 40, color=style.GREY, alpha=0.12, lw=0)
    falling.set(title="Tone of the mesh (grey: the plate's modes)", xlabel="spacing [um]",
                ylabel="dB re 1 nm/s",
                xlim=(1.7, 38), xscale="log")
    ticks = [1e6 * spacing for spacing in SPACINGS if spacing != 14e-6]
    falling.set_xticks(ticks, [f"{tick:g}" for tick in ticks])
    falling.set_xticks([], minor=True)
    falling.legend(loc="lower right")
    case.figure(figure)


if __name__ == "__main__":
    common.main("spectrum", compare)
