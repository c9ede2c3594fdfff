#!/usr/bin/env python3
# SPDX-License-Identifier: BSD-3-Clause
"""How far it holds what a choice does to level and shocks: over the speed, the roughness and the
load.

Each choice is set against the scene without it, on the same surfaces. What orders the answers is
the share of the time in contact. Where the slider flies, a shock is a blow of an asperity. Where
contact hardly opens, the shocks that are counted are the openings of a contact spring that rings.

Two scenes must have the same shocks: heights and load, both four times as large, make every
displacement and force four times as large, and no time changes. A power of two rounds nothing.
"""
import numpy as np
from scipy import stats

import common
from law import DISTANCE, both, study
from law import SPEEDS as FASTER

SPEEDS = (0.005, *FASTER)         # m/s
# m: a slow run goes on until the slider has come so far; how far the slowest does once
LEAST_DISTANCE, FAR = 0.01, 0.1
RQ = (2e-6, 8e-6, 20e-6)          # m
USUAL = 8e-6                      # m, the scene's
WEIGHT = 7800 * 0.02**3 * 9.80665  # N
LOADS = (0.1, 10.0, 100.0)        # N
SEEDS = 5
SHOWN = (0.005, 0.02, 0.1, 0.5)   # m/s, in the page's table
SHARES = (0, 0.1, 0.5, 0.9, 0.99, 0.999, 1)  # of the time in contact: the page's columns
CHOICES = {
    "kappa-13": ("kappa 1e13 Pa/m", {"contact.stiffness": 1e13}),
    "kappa-14": ("kappa 1e14 Pa/m", {"contact.stiffness": 1e14}),
    "kappa-16": ("kappa 1e16 Pa/m", {"contact.stiffness": 1e16}),
    "kappa-17": ("kappa 1e17 Pa/m", {"contact.stiffness": 1e17}),
    "damping-0.002": ("damping ratio 0.002", both("damping", 0.002)),
    "damping-0.1": ("damping ratio 0.1", both("damping", 0.1)),
    "modes-5": ("modes up to 5 kHz", both("max_frequency", 5e3)),
    "modes-80": ("modes up to 80 kHz", both("max_frequency", 8e4)),
    "spacing-4": ("spacing 4 um", {"scene.spacing": 4e-6}),
}
AT_LOADS = ("kappa-13", "kappa-17", "damping-0.002", "damping-0.1")  # under LOADS, too
QUANTITIES = ("shock_rate", "shock_duration_median", "peak_force_median")


def lasts(_, speed):
    return min(max(1.0, LEAST_DISTANCE / speed), DISTANCE / speed)


def runs(case, name, sets, seeds=SEEDS, speeds=SPEEDS, rq=RQ, lasts=lasts):
    """The table of one study."""
    return study(case, "base", seeds, name, rq=rq, speeds=speeds, lasts=lasts, sets=sets)[1]


def marched(case, name, sets):
    """A choice's runs: {(Rq, load): the table over speeds and seeds}. Other loads than the weight
    of some choices alone, and at the usual Rq; of the scene as it is at all."""
    found = {}
    for load in (WEIGHT, *(LOADS if not sets or name in AT_LOADS else ())):
        rq = RQ if load == WEIGHT or not sets else (USUAL,)
        own = {} if load == WEIGHT else {"slider.load": load}
        table = runs(case, f"{name}-{load:.3g}", {**sets, **own}, rq=rq)
        found |= {(each, load): table.sel(rq=each) for each in rq}
    return found


def check_scaling(case, small, large):
    """Tables of which the second has heights and load four times as large."""
    case.check("heights and load four times as large: shocks a second, over the same, off by",
               np.abs(large.shock_rate / small.shock_rate - 1).max(), np.finfo(float).eps,
               "no time changes: a power of two rounds nothing")
    case.check("heights and load four times as large: level, off 20 log10(4), dB",
               np.abs(large.level - small.level - 20 * np.log10(4)).max(),
               4 * np.finfo(float).eps * large.level.max(),
               "a power of two rounds nothing, two logarithms do")


def compare(case):
    speeds = (0.5,) if case.short else SPEEDS[-2:]
    check_scaling(case,
                  *(runs(case, name, {"slider.load": times * WEIGHT}, 2, speeds,
                         (times * USUAL / 4,)).isel(rq=0)
                    for name, times in (("small", 1), ("large", 4))))
    if not case.short:
        base = marched(case, "base", {})
        report(case, base, {name: marched(case, name, sets) for name, (_, sets) in CHOICES.items()})
        far = runs(case, "far", {}, speeds=SPEEDS[:1], rq=(USUAL,), lasts=lambda _,
                   speed: FAR / speed).shock_rate
        case.text("far", f"{1e3 * FAR:.0f}")
        case.text("far-rates", f"{rounded(far.min().item())} to {rounded(far.max().item())}")


def mean(values):
    """Mean over the seeds, and half of its 95 % interval of Student's t."""
    return np.mean(values), stats.t.ppf(0.975, len(values) - 1) * stats.sem(values)


class Change:
    """What a choice changes at one point, on the same seeds."""

    def __init__(self, table, base, speed):
        table, base = (each.sel(speed=speed) for each in (table, base))
        self.level = mean((table.level - base.level).values)
        self.factors = {name: mean(np.log(table[name] / base[name]).values) for name in QUANTITIES}
        self.share = base.contact_share.mean().item()

    def factor(self, name):
        """The factor and the ends of its interval."""
        middle, half = self.factors[name]
        return np.exp(middle), np.exp(middle - half), np.exp(middle + half)

    def text(self):
        return "{:+.1f} ± {:.1f} dB, {}".format(*self.level, self.factor_text("shock_rate"))

    def factor_text(self, name):
        return "x {} ({} to {})".format(*map(rounded, self.factor(name)))


def rounded(value):
    """Two digits, without a power of ten."""
    return common.shown(float(f"{value:.2g}"))


def factors(values):
    """The least and the greatest of some factors."""
    low, high = min(values), max(values)
    return f"x {rounded(low)}" + (f" to {rounded(high)}" if rounded(low) != rounded(high) else "")


def bin_of(share):
    return min(np.searchsorted(SHARES, share, side="right") - 1, len(SHARES) - 2)


def as_it_is(table, speed):
    at = table.sel(speed=speed)
    return (f"{at.level.mean().item():.1f} dB, {common.shown(at.shock_rate.mean().item())} a "
            "second, "
            f"in contact {100 * at.contact_share.mean().item():.3g} %")


def report(case, base, tables):
    usual = base[USUAL, WEIGHT]
    changes = {name: {(rq, load, speed): Change(table, base[rq, load], speed)
                      for (rq, load), table in found.items() for speed in SPEEDS}
               for name, found in tables.items()}
    loads = {load: {(rq, load, speed): Change(base[rq, load], base[rq, WEIGHT], speed) for rq in RQ
                    for speed in SPEEDS} for load in LOADS}
    words = {**{load: f"load {load:g} N" for load in LOADS},
             **{name: what for name, (what, _) in CHOICES.items()}}
    both_kinds = {**changes, **loads}
    speeds = [f"{speed:g} m/s" for speed in SHOWN]

    def own_load(name):
        return name if name in LOADS else WEIGHT

    case.text("speeds", common.markdown(("", *speeds), [
        ("as it is", *(as_it_is(usual, speed) for speed in SHOWN)),
        *((words[name], *(found[USUAL, own_load(name), speed].text() for speed in SHOWN))
          for name, found in both_kinds.items())]))
    for name, kind in (("durations", "shock_duration_median"), ("forces", "peak_force_median")):
        unit = 1e6 if name == "durations" else 1
        case.text(name, common.markdown(("", *speeds), [
            ("as it is" + (", us" if unit > 1 else ", N"),
             *(common.shown(unit * usual[kind].sel(speed=speed).mean().item()) for speed in SHOWN)),
            *((words[each], *(found[USUAL, own_load(each), speed].factor_text(kind)
                              for speed in SHOWN)) for each, found in both_kinds.items())]))

    by_share = {name: [[] for _ in SHARES[1:]] for name in CHOICES}
    for name, found in changes.items():
        for change in found.values():
            by_share[name][bin_of(change.share)].append(change)
    counts = [len(each) for each in by_share["kappa-13"]]
    case.text("shares", common.markdown(
        ("the scene as it is, in contact",
         *(f"{100 * low:g} to {100 * high:g} %" for low, high in zip(SHARES, SHARES[1:])),
         "level, everywhere"),
        [("so many speeds, roughnesses and loads", *counts, ""),
         *((words[name], *(factors([each.factor("shock_rate")[0] for each in some]) if some else ""
                           for some in found),
            "{:+.1f} to {:+.1f} dB".format(*(pick(change.level[0]
                                                  for change in changes[name].values())
                                             for pick in (min, max))))
           for name, found in by_share.items())]))
    for name, found in changes.items():
        at = found[USUAL, WEIGHT, 0.02]
        case.text(f"rate-{name}-slow", at.factor_text("shock_rate"))
        case.text(f"level-{name}-range",
                  "{:+.1f} to {:+.1f}".format(*(pick(change.level[0] for change in found.values())
                                                for pick in (min, max))))
        case.text(f"rate-{name}-range",
                  factors([change.factor("shock_rate")[0] for change in found.values()]))
    for load, found in loads.items():
        case.text(f"load-{load:g}-slow", "{:+.1f} ± {:.1f}".format(*found[USUAL, load, 0.02].level))
        case.text(f"load-{load:g}-range",
                  "{:+.1f} to {:+.1f}".format(*(pick(change.level[0] for change in found.values())
                                                for pick in (min, max))))
    for name, speed in (("slow", 0.02), ("slowest", 0.005)):
        stiffness = {1e13: tables["kappa-13"], 1e15: base, 1e17: tables["kappa-17"]}
        for kappa, found in stiffness.items():
            case.text(f"{name}-{np.log10(kappa):.0f}",
                      common.shown(found[USUAL, WEIGHT].shock_rate.sel(speed=speed).mean().item()))
    for edge, which in (("flies", 0), ("half", 1)):
        some = [change.factor("shock_rate")[0] for name in ("kappa-14", "kappa-16", "kappa-17")
                for change in by_share[name][which]]
        case.text(f"stiff-{edge}", f"{max(max(some), 1 / min(some)):.1f}")
    case.text("seeds", f"{SEEDS}")
    case.text("least-way", f"{1e3 * LEAST_DISTANCE:g}")
    case.text("runs",
              str(sum(table.level.size for found in (base, *tables.values())
                      for table in found.values())))
    case.table(("choice", "Rq, m", "load, N", "V, m/s", "share of the time in contact, as it is",
                "level, dB", "half of its 95 % interval",
                *(f"{what}, factor{end}" for what in QUANTITIES for end in ("", ", from", ", to"))),
               [(words[name], rq, f"{load:.4g}", speed, f"{change.share:.4f}",
                 *(f"{x:.2f}" for x in change.level),
                 *(f"{x:.4g}" for kind in QUANTITIES for x in change.factor(kind)))
                for name, found in both_kinds.items()
                for (rq, load, speed), change in found.items()])
    draw(case, base, tables, changes)


def draw(case, base, tables, changes):
    plt, style = common.pyplot()
    figure, (rates, share) = plt.subplots(1, 2, figsize=(9, 3.8), layout="constrained")
    kappas = {1e13: tables["kappa-13"], 1e14: tables["kappa-14"], 1e15: base,
              1e16: tables["kappa-16"], 1e17: tables["kappa-17"]}
    for (kappa, found), colour, mark in zip(kappas.items(), style.SERIES, style.MARKS):
        table = found[USUAL, WEIGHT]
        rates.loglog(table.speed, table.shock_rate.mean("seed"), color=colour, marker=mark, ms=4,
                     lw=1.2, label=f"{common.shown(kappa, 1)} Pa/m")
    rates.set(title="Shocks a second, own weight, Rq 8 \u00b5m", xlabel="speed [m/s]")
    rates.legend(loc="lower right", fontsize=7.5)
    for name, colour, mark in zip(("kappa-13", "kappa-17", "damping-0.002", "spacing-4"),
                                  style.SERIES, style.MARKS):
        apart = [(1 - change.share, change.factor("shock_rate")[0])
                 for change in changes[name].values()]
        share.loglog(*np.array(apart).T, color=colour, marker=mark, ls="none", ms=3.5,
                     label=CHOICES[name][0])
    share.axhline(1, color=style.GREY, lw=1)
    share.set(title="What a choice does to the rate (all speeds, Rq, loads)",
              xlabel="share of the time without contact", ylabel="factor",
              xlim=(1e-7, 1.5))
    share.invert_xaxis()
    share.legend(loc="upper left", fontsize=7.5)
    case.figure(figure)


if __name__ == "__main__":
    common.main("choices", compare)
