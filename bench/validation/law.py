#!/usr/bin/env python3
# SPDX-License-Identifier: BSD-3-Clause
"""The paper's Fig. 5 and its equation (14), v_rms ~ Rq^n V^m: the level over five roughnesses and
six speeds, and n and m as one thing at a time is moved away from the scene.

Exponents are fitted to each seed by itself, and the interval is Student's t over the seeds: runs of
one seed share their surfaces, so they are not independent of one another, but the seeds are.
"""
import itertools
import json

import h5py
import numpy as np
import xarray
from scipy import stats

import common
from plate import LENGTH, MASS_PER_LENGTH, omegas, shapes, waves

RQ = (2e-6, 4e-6, 8e-6, 12e-6, 20e-6)         # m, the paper's
SPEEDS = (0.01, 0.02, 0.05, 0.1, 0.2, 0.5)    # m/s
# m/s: up to here every run lasts a second, as in the paper
SLOW = 0.1
# m: what the slider has before it, from scene.start
DISTANCE = 0.175
# m: the slider's middle at the start, half of its length
MIDDLE, HALF = 0.11, 0.01
DAMPING = 0.02
SEEDS, FEW = 10, 5                            # of the scene itself, of its variants
PAPER = {"n": (0.19, 0.25), "m": (0.20, 0.31)}
HIGH = 1e3                                    # Hz: modes above it radiate better
NUMERICS = {"time.scheme": "adaptive", "time.tolerance": 1e-6, "output.rate": 1e4}

# half an interval that is too wide to say where an exponent lies
OPEN = 0.15


def both(key, value):
    return {f"resonator.{key}": value, f"slider.{key}": value}


REST = {"scene.initial": "rest"}
# group, what the chapter calls it, what is set beyond NUMERICS
VARIANTS = {
    "base": ("", "as it is: from equilibrium, own weight", {}),
    "rest": ("start", "let go from rest, touching", REST),
    "rest-later": ("start", "let go from rest, second half of each run", REST),
    "rest-drop": ("start", "let go from rest, gap 0.2 mm", {**REST, "scene.gap": 2e-4}),
    "rest-10": ("start", "let go from rest, 10 N", {**REST, "slider.load": 10.0}),
    "load-0.1": ("load", "load 0.1 N", {"slider.load": 0.1}),
    "load-10": ("load", "load 10 N", {"slider.load": 10.0}),
    "load-100": ("load", "load 100 N", {"slider.load": 100.0}),
    "load-1000": ("load", "load 1000 N", {"slider.load": 1000.0}),
    "pinned": ("support", "slider pinned, gap 2.5 Rq", {}),
    "pinned-20": ("support", "slider pinned, gap 20 um", {}),
    "kappa-13": ("kappa", "kappa 1e13 Pa/m", {"contact.stiffness": 1e13}),
    "kappa-17": ("kappa", "kappa 1e17 Pa/m", {"contact.stiffness": 1e17}),
    "damping-0.002": ("damping", "damping ratio 0.002", both("damping", 0.002)),
    "damping-0.01": ("damping", "damping ratio 0.01", both("damping", 0.01)),
    "damping-0.1": ("damping", "damping ratio 0.1", both("damping", 0.1)),
    "modes-5": ("modes", "modes up to 5 kHz", both("max_frequency", 5e3)),
    "modes-80": ("modes", "modes up to 80 kHz", both("max_frequency", 8e4)),
    "spacing-4": ("spacing", "spacing 4 um", {"scene.spacing": 4e-6}),
    "spacing-16": ("spacing", "spacing 16 um", {"scene.spacing": 16e-6}),
    "rsm-3.1": ("surface", "RSm 3.1 mm, not 1.55 mm", both("surface.rsm", 3.1e-3)),
    # not a choice of the scene: how far the slider goes, how well it is solved
    "way": ("sliding", "the same distance at every speed, 0.175 m", {}),
    "tolerance": ("scheme", "tolerance 1e-8, not 1e-6", {"time.tolerance": 1e-8}),
}


def lasts(name, speed):
    return DISTANCE / speed if name == "way" else min(1.0, DISTANCE / speed)


def study_text(name, seeds, rq=RQ, speeds=SPEEDS, sets=None, keep=("level", "shocks"), lasts=lasts):
    """The study of a variant, as a user would write it."""
    roughness = {"keys": ["resonator.surface.rq", "slider.surface.rq"], "values": list(rq)}
    if name == "pinned":
        roughness = {"keys": [*roughness["keys"], "scene.gap"],
                     "values": [[each, each, 2.5 * each] for each in rq]}
    speed = {"keys": ["scene.speed", "scene.duration"],
             "values": [[each, lasts(name, each)] for each in speeds]}
    if name == "rest-later":
        speed = {"keys": [*speed["keys"], "output.from"],
                 "values": [[v, t, t / 2] for v, t in speed["values"]]}
    scene = "dang2012-pinned.toml" if name.startswith("pinned") else "dang2012.toml"
    top = {"base": str(common.ROOT / "scenes" / scene), "seeds": seeds, "keep": keep}
    values = {**NUMERICS, **VARIANTS.get(name, ("", "", {}))[2], **(sets or {})}
    return "\n".join([*(f"{key} = {common.to_toml(value)}" for key, value in top.items()),
                      "[set]",
                      *(f'"{key}" = {common.to_toml(value)}' for key, value in values.items()),
                      "[vary]", f"rq = {common.to_toml(roughness)}",
                      f"speed = {common.to_toml(speed)}"]) + "\n"


def study(case, name, seeds, folder=None, **other):
    """Runs the study of a variant. Its folder, and its table."""
    folder = case.scratch / (folder or name)
    file = case.scratch / f"{folder.name}.toml"
    file.write_text(study_text(name, seeds, **other))
    case.call(case.program, "study", file, "-o", folder, "--quiet",
              *(["--threads", "1"] if case.short else []))
    return folder, xarray.load_dataset(folder / "results.h5", engine="netcdf4")


def terms(table, curved=False):
    """Logarithms of roughness and speed at each point, about their means: (point, term), after a
    constant."""
    x, y = (grid.ravel() for grid in np.meshgrid(np.log10(table.rq), np.log10(table.speed),
                                                 indexing="ij"))
    x, y = x - x.mean(), y - y.mean()
    return np.stack([np.ones_like(x), x, y, *([x * x, y * y, x * y] if curved else [])], axis=1)


def fits(table, curved=False):
    """Coefficients of log10 v_rms for each seed, (seed, term), and the deviations of all runs in
    dB. Runs in which nothing touches have no level."""
    matrix, found, deviations = terms(table, curved), [], []
    for seed in table.seed:
        v = table.v_rms.sel(seed=seed).values.ravel()
        heard = v > 0
        each = np.linalg.lstsq(matrix[heard], np.log10(v[heard]), rcond=None)[0]
        found.append(each)
        deviations.append(20 * (np.log10(v[heard]) - matrix[heard] @ each))
    return np.array(found), np.concatenate(deviations)


def mean(values):
    """Mean over the seeds, and half of its 95 % interval of Student's t."""
    with np.errstate(invalid="ignore"):  # where a run is silent: -inf, and no interval
        return np.mean(values), stats.t.ppf(0.975, len(values) - 1) * stats.sem(values)


def exponents(table):
    """{n, m: (mean, half)}"""
    found = fits(table)[0]
    return {"n": mean(found[:, 1]), "m": mean(found[:, 2])}


def slow(table):
    return table.sel(speed=table.speed[table.speed <= SLOW])


def shown(value, half):
    """0.93 ± 0.02"""
    value = round(value, 2) + 0.0  # no -0.00
    return f"{value:.2f} ± {half:.2f}" if half >= 0.005 else f"{value:.2f}"


def check_analyze(case, folder, table):
    """What `ra2d analyze` says of the law, beside scipy's least squares of the table."""
    law = json.loads(case.call(case.program, "analyze", folder, "--json"))["law"]["exponents"]
    # each seed has the same points, so the mean is the fit of all
    found = np.mean(fits(table)[0], axis=0)
    case.check("exponents of `ra2d analyze`, beside numpy's least squares of the table",
               max(abs(law["rq"]["value"] - found[1]), abs(law["speed"]["value"] - found[2])),
               1e-11,
               "roundings of a sum of some hundred numbers, each about 1")
    return law


def check_pinned(case, table):
    """A pinned slider whose gap goes with the roughness: n = 1, and a power of two rounds
    nothing."""
    v = table.v_rms.sel(rq=list(RQ[:3])).values
    case.check("n of the pinned slider from 1, over 2, 4 and 8 um",
               np.abs(np.log2(v[1:] / v[:-1]) - 1).max(), 1e-14,
               "a power of two rounds nothing; a logarithm does")


def passage(load, speed):
    """Level of the plate that bends under a force that passes: no roughness, no mass of the slider.
    At first it is at rest, bent by the force, so it rings a little."""
    omega, drive = omegas(19), waves(19) * speed
    pole = omega * (1j * np.sqrt(1 - DAMPING**2) - DAMPING)
    t = np.linspace(0, min(1.0, DISTANCE / speed), 10001)[:, None]
    forced = (load * np.sqrt(2 / LENGTH) / MASS_PER_LENGTH * np.exp(1j * waves(19) * MIDDLE)
              / (omega**2 - drive**2 + 2j * DAMPING * omega * drive))
    # of the ring, at the start
    u = load * shapes(19, MIDDLE) / (MASS_PER_LENGTH * omega**2) - forced.imag
    ring = u + 1j * ((1j * drive * forced).imag - DAMPING * omega * u) / pole.imag
    velocity = (1j * drive * forced * np.exp(1j * drive * t)).imag + (pole * ring
                                                                      * np.exp(pole * t)).real
    return 10 * np.log10((velocity**2).sum(1).mean() / LENGTH) + 180


def check_passage(case):
    """A heavy slider on nearly smooth surfaces bends the plate, and that is all. Its level."""
    found = study(case, "load-1000", 1, "smooth", rq=(2e-7,), speeds=(0.5,))[1].level.item()
    case.check("level under 1000 N on surfaces of 0.2 um from the closed form of the passage, dB",
               abs(found - passage(1000, 0.5)), -20 * np.log10(np.cos(np.pi / LENGTH * HALF)),
               "the force may be at the slider's ends, not in its middle: first mode")
    return found


def check_scaling(case, tables):
    """Ten times the roughness under ten times the load: 20 dB, whatever the speed."""
    for less, more in ((10, 100), (100, 1000)):
        rise = tables[f"load-{more}"].level.sel(rq=RQ[-1]) - tables[
            f"load-{less}"].level.sel(rq=RQ[0])
        found, half = mean(rise.mean("speed").values)
        case.check(f"level at 20 um and {more} N, from 20 dB above that at 2 um and {less} N, dB",
                   abs(found - 20), half,
                   "n + l = 1; the seeds' 95 % interval")


def compare(case):
    if case.short:
        folder, table = study(case, "pinned", 2, rq=RQ[:3], speeds=(0.35, 0.5))
        check_analyze(case, folder, table)
        check_pinned(case, table)
        check_passage(case)
        return
    folders, tables = {}, {}
    for name in VARIANTS:
        folders[name], tables[name] = study(case, name, SEEDS if name == "base" else FEW)
    law = check_analyze(case, folders["base"], tables["base"])
    check_pinned(case, tables["pinned"])
    # at no speed, which a logarithm does not take: in a second the slider moves by a nanometre
    ring = [study(case, "rest", FEW, f"ring-{begin}", speeds=(1e-9,),
                  sets={"output.from": begin})[1] for begin in (0.0, 0.5)]
    case.text("passage-smooth", f"{check_passage(case):.1f}")
    check_scaling(case, tables)
    of_the_modes(case)
    report(case, tables, law, *ring)


def of_the_modes(case):
    """n and m of the slow modes and of the fast ones, and the part that the slow ones have of
    v_rms^2 at each point."""
    folder, table = study(case, "base", FEW, "modes", sets={"output.rate": 2e3},
                          keep=("level", "files"))
    parts = {name: table.copy(deep=True) for name in ("low", "high")}
    for at in itertools.product(*(range(size) for size in table.v_rms.shape)):
        with h5py.File(folder / str(table.file.values[at])) as file:
            body = file["resonator"]
            square = (body["velocity"][()]**2).mean(axis=0) * body["mean_square"][()]
            high = body["frequency"][()] > HIGH
        for name, which in (("low", ~high), ("high", high)):
            parts[name].v_rms.values[at] = np.sqrt(square[which].sum())
    for name, part in parts.items():
        for over, some in (("", part), ("-slow", slow(part))):
            for key, found in exponents(some).items():
                case.text(f"{key}-{name}{over}", shown(*found))
    share = parts["low"].v_rms**2 / (parts["low"].v_rms**2 + parts["high"].v_rms**2)
    case.text("share-low", f"{100 * share.sel(rq=8e-6, speed=0.1).mean().item():.0f}")
    mean_share = 100 * share.mean("seed")
    case.text("share-low-range", f"{mean_share.min().item():.0f} to {mean_share.max().item():.0f}")


def in_papers_range(found):
    """Whether both exponents lie in the paper's ranges, within their own intervals."""
    if max(half for _, half in found.values()) > OPEN:
        return "undecided"
    within = all(low - found[key][1] <= found[key][0] <= high + found[key][1]
                 for key, (low, high) in PAPER.items())
    return "yes" if within else "no"


def levels(table):
    """Mean level and half of its interval at each point: {(rq, speed): (mean, half)}."""
    return {(rq, speed): mean(table.level.sel(rq=rq, speed=speed).values)
            for rq in table.rq.values for speed in table.speed.values}


def local(table):
    """m between neighbouring speeds, over all roughnesses: (mean, half) of each."""
    v = np.log10(table.v_rms).mean("rq").transpose("speed", "seed").values
    return [mean(slope)
            for slope in np.diff(v, axis=0) / np.diff(np.log10(table.speed.values))[:, None]]


def n_at(table, speed):
    """n at one speed."""
    v = np.log10(table.v_rms.sel(speed=speed).transpose("rq", "seed").values)
    return mean(np.polyfit(np.log10(table.rq), v, 1)[0])


def report(case, tables, law, ring, later):
    base = tables["base"]
    rows = [(name, *VARIANTS[name][:2], exponents(table), exponents(slow(table)),
             fits(table)[1].std(), table)
            for name, table in tables.items()]
    kinds = ("shock_rate", "shock_duration_median", "peak_force_median", "contact_share")
    case.table(("variant", "Rq, m", "V, m/s", "seeds", "level, dB", "95 % interval, dB",
                "shocks a second",
                "median duration, s", "median peak force, N", "share of the time in contact"),
               [(name, rq, v, table.seed.size, *(f"{x:.2f}" for x in at),
                 *(f"{table[kind].sel(rq=rq, speed=v).mean().item():.4g}" for kind in kinds))
                for name, table in tables.items() for (rq, v), at in levels(table).items()])
    case.text("seeds", f"{SEEDS}")
    case.text("few", f"{FEW}")
    case.text("runs", f"{sum(table.level.size for table in tables.values()) + ring.level.size}")
    at = levels(base)
    speeds = [f"{v:g} m/s" for v in SPEEDS]
    case.text("levels", common.markdown(
        ("Rq, um", *speeds),
        [(f"{1e6 * rq:.0f}", *("{:.1f} ± {:.1f}".format(*at[rq, v]) for v in SPEEDS))
         for rq in RQ]))
    case.text("exponents", common.markdown(
        ("moved", "what", "n", "m", "runs off the law by, dB", "in the paper's range",
         "V <= 0.1 m/s: n", "m", "in the paper's range"),
        [(group, what, shown(*whole["n"]), shown(*whole["m"]), f"{deviation:.1f}",
          in_papers_range(whole),
          shown(*low["n"]), shown(*low["m"]), in_papers_range(low))
         for _, group, what, whole, low, deviation, _ in rows]))
    for name, _, _, whole, low, deviation, _ in rows:
        case.text(f"deviation-{name}", f"{deviation:.1f}")
        for key in ("n", "m"):
            case.text(f"{key}-{name}", shown(*whole[key]))
            case.text(f"{key}-{name}-slow", shown(*low[key]))
    papers = {over: [row[2] for row in rows if in_papers_range(row[column]) == "yes"]
              for over, column in (("all", 3), ("slow", 4))}
    for over, names in papers.items():
        case.text(f"paper-{over}", "; ".join(names) or "none")
    case.text("as-papers", f"{sum(map(len, papers.values()))} of {2 * len(rows)}")
    for key, (_, half) in rows[0][3].items():
        case.text(f"{key}-half", f"± {half:.2f}")
    for key, name in (("n", "rq"), ("m", "speed")):
        case.text(f"{key}-analyze",
                  shown(law[name]["value"], (law[name]["high"] - law[name]["low"]) / 2))
    others = ("base", "rest", "load-0.1", "load-10", "rsm-3.1")
    case.text("m-local", common.markdown(
        ("from V, m/s", "to", "m: as it is", "from rest", "0.1 N", "10 N", "RSm 3.1 mm"),
        [(f"{v:g}", f"{w:g}", *(shown(*m) for m in step))
         for v, w, step in zip(SPEEDS, SPEEDS[1:],
                               zip(*(local(tables[name]) for name in others)))]))
    first = omegas(1)[0] / (2 * np.pi)
    case.text("first", first)
    case.text("meets", f"{1.55e-3 * first:.2f}")
    case.text("meets-longer", f"{3.1e-3 * first:.2f}")
    bent = []  # how far each exponent changes by a decade of roughness, and of speed
    for name in ("base", "rest", "load-0.1", "load-10", "load-100", "load-1000", "pinned"):
        curved, left = fits(tables[name], curved=True)
        bent.append((VARIANTS[name][1], f"{fits(tables[name])[1].std():.1f}", f"{left.std():.1f}",
                     shown(*mean(2 * curved[:, 3])),
                     shown(*mean(curved[:, 5])), shown(*mean(2 * curved[:, 4]))))
    case.text("bent", common.markdown(
        ("", "runs off the law by, dB", "off one with quadratic terms, dB",
         "a decade of Rq changes n by",
         "a decade of V changes n by (and one of Rq m)", "a decade of V changes m by"), bent))
    share = base.contact_share.mean("seed")
    case.text("shares", common.markdown(
        ("Rq, um", *speeds),
        [(f"{1e6 * rq:.0f}", *(f"{share.sel(rq=rq, speed=v).item():.2f}" for v in SPEEDS))
         for rq in RQ]))
    the_start(case, tables, ring, later)
    the_distance(case, tables)
    for load in (10, 100, 1000):
        table = tables[f"load-{load}"].sel(speed=0.5)
        case.text(f"passage-{load}", f"{passage(load, 0.5):.1f}")
        case.text(f"passage-{load}-found", " to ".join(f"{table.level.sel(rq=rq).mean().item():.1f}"
                                                       for rq in (RQ[0], RQ[-1])))
    rise = np.log10(tables["load-100"].v_rms / tables["load-10"].v_rms).mean(("rq", "speed"))
    case.text("l-10-100", shown(*mean(rise.values)))
    silent = tables["pinned-20"].level
    case.text("silent", f"{int((~np.isfinite(silent)).sum())} of {silent.size}")
    choices(case, rows)
    draw(case, tables, rows, ring)


def the_start(case, tables, ring, later):
    """The ring of the start, found at no speed, and the levels of noise and ring together."""
    rest, still = slow(tables["rest"]), ring.isel(speed=0)
    noise = slow(tables["base"]).sel(seed=rest.seed)
    case.text("ring", "{:.1f} ± {:.1f}".format(*mean(still.level.mean("rq").values)))
    case.text("ring-later",
              "{:.1f} ± {:.1f}".format(*mean(later.level.mean(("rq", "speed")).values)))
    case.text("n-ring", shown(*n_at(ring, ring.speed.item())))
    of = [tables[name] for name in ("base", "rest", "rest-drop")]
    case.text("n-speeds", common.markdown(
        ("", "from equilibrium", "let go, touching", "let go, gap 0.2 mm"),
        [*((f"n at {v:g} m/s", *(shown(*n_at(table, v)) for table in of)) for v in SPEEDS),
         ("runs off one n and one m by, dB: V <= 0.1 m/s",
          *(f"{fits(slow(table))[1].std():.1f}" for table in of)),
         ("the same, all speeds", *(f"{fits(table)[1].std():.1f}" for table in of))]))
    both_powers = noise.copy()
    both_powers["v_rms"] = np.sqrt(noise.v_rms**2 + still.v_rms**2)
    found = exponents(both_powers)
    for key in ("n", "m"):
        case.text(f"{key}-together", shown(*found[key]))
    apart, half = mean(20 * np.log10(rest.v_rms / both_powers.v_rms).mean(("rq", "speed")).values)
    case.text("together-apart", f"{apart:.2f} ± {half:.2f}")
    case.check("from rest, V <= 0.1 m/s: mean level beside the powers of noise and ring, dB",
               abs(apart), half,
               "powers of independent motions add; the seeds' 95 % interval")


def the_distance(case, tables):
    """What a short way does: levels of the same seeds over a second and over the whole way, and how
    seeds spread."""
    base, longer = tables["base"].sel(seed=tables["way"].seed), tables["way"]
    rows = []
    for v in SPEEDS:
        more = (longer.level - base.level).sel(speed=v).mean("rq").values
        spread = [table.level.sel(speed=v).std("seed", ddof=1).mean().item()
                  for table in (base, longer)]
        rows.append((f"{v:g}", f"{1e3 * v * lasts('base', v):.3g}", f"{spread[0]:.1f}",
                     f"{1e3 * DISTANCE:.3g}", f"{spread[1]:.1f}",
                     "{:+.1f} ± {:.1f}".format(*mean(more)) if lasts("base", v) < lasts("way", v)
                     else "the same run"))
    case.text("way", common.markdown(("V, m/s", "slides, mm", "seeds spread by, dB",
                                      "slides farther, mm", "seeds spread by, dB",
                                      "mean level, farther less shorter, dB"), rows))


def choices(case, rows):
    """For docs/choices.md: what a choice changes at one point, seed by seed, and its exponents."""
    point, base = {"rq": 8e-6, "speed": 0.1}, rows[0][-1]
    kinds = (("shock_rate", 1), ("shock_duration_median", 1e6), ("peak_force_median", 1))

    def level(table):
        if table is base:
            return "{:.1f} ± {:.1f} dB".format(*mean(base.level.sel(point).values))
        # of the seeds that both have
        return "{:+.1f} ± {:.1f} dB".format(*mean((table.level - base.level).sel(point).values))

    def shocks(table, kind, scale):
        if table is base:
            return common.shown(scale * base[kind].sel(point).mean().item())
        value, half = mean(np.log((table[kind] / base[kind]).sel(point).values))
        return (f"x {common.shown(np.exp(value))} ({common.shown(np.exp(value - half))} to "
                f"{common.shown(np.exp(value + half))})")

    for name, *_, table in rows:
        case.text(f"level-{name}", level(table))
    header = ("", "Lv", "shocks a second", "their median duration, us",
              "their median peak force, N", "n", "m")
    for group in dict.fromkeys(row[1] for row in rows[1:]):
        case.text(f"choice-{group}", common.markdown(header, [
            (what, level(table), *(shocks(table, *kind) for kind in kinds), shown(*whole["n"]),
             shown(*whole["m"]))
            for _, its, what, whole, _, _, table in rows if its in ("", group)]))


def draw(case, tables, rows, ring):
    plt, style = common.pyplot()
    figure = plt.figure(figsize=(7.2, 10), layout="constrained")
    upper, lower = figure.subfigures(2, 1, height_ratios=(0.8, 1.2))
    left, right = upper.subplots(1, 2, sharey=True)
    for axes, name, title in ((left, "base", "From equilibrium"),
                              (right, "rest", "Let go from rest")):
        for rq, colour, mark in zip(RQ, style.SERIES, style.MARKS):
            mid, half = np.array([levels(tables[name])[rq, v] for v in SPEEDS]).T
            axes.errorbar(SPEEDS, mid, half, color=colour, marker=mark, ms=4, lw=1, capsize=2,
                          label=f"{1e6 * rq:.0f} \u00b5m")
        axes.set(title=title, xlabel="speed [m/s]", xscale="log")
        axes.xaxis.set_major_formatter(plt.FuncFormatter(lambda value, _: f"{value:g}"))
        axes.set_xticks(SPEEDS)
        axes.minorticks_off()
    still = ring.level.mean().item()
    right.axhline(still, color=style.GREY, ls="--", lw=1)
    right.annotate("ring of the start, no speed", (SPEEDS[-1], still), xytext=(0, -3),
                   textcoords="offset points", ha="right",
                   va="top", color=style.GREY, fontsize=8)
    left.set_ylabel("Lv [dB re 1 nm/s]")
    left.legend(title="Rq")
    panels = lower.subplots(1, 2, sharey=True)
    for axes, key in zip(panels, ("n", "m")):
        axes.axvspan(*PAPER[key], color=style.RUST, alpha=0.18, lw=0, label="the paper's range")
        for which, colour, mark, shift, label in ((3, style.BLUE, "o", -0.15, "V to 0.5 m/s"),
                                                  (4, style.BLACK, "s", 0.15, "V to 0.1 m/s")):
            value, half = np.array([row[which][key] for row in rows]).T
            axes.errorbar(value, np.arange(len(rows)) + shift, xerr=half, color=colour, marker=mark,
                          ls="none", ms=3.5, lw=1,
                          label=label)
        axes.set(title={"n": "n, of the roughness", "m": "m, of the speed"}[key],
                 xlim=(-0.15, 1.85))
        for i, row in enumerate(rows):
            if row[3][key][0] > 1.85:
                axes.text(row[3][key][0] - row[3][key][1] - 0.05, i - 0.15,
                          f"{shown(*row[3][key])} \u2192", color=style.BLUE,
                          ha="right", va="center", fontsize=7.5)
        for i in range(1, len(rows)):
            if rows[i][1] != rows[i - 1][1]:
                axes.axhline(i - 0.5, color=style.GREY, lw=0.4)
    panels[0].set_yticks(range(len(rows)), [row[2].replace(" um", " \u00b5m") for row in rows])
    panels[0].set_ylim(len(rows) - 0.5, -0.5)
    for axes in panels:  # one half of the legend below each
        handles, labels = axes.get_legend_handles_labels()
        part = slice(0, 1) if axes is panels[0] else slice(1, 3)
        axes.legend(handles[part], labels[part], loc="upper center", bbox_to_anchor=(0.5, -0.04),
                    frameon=False)
    case.figure(figure)


if __name__ == "__main__":
    common.main("law", compare)
