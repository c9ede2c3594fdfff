#!/usr/bin/env python3
# SPDX-License-Identifier: BSD-3-Clause
"""A mass slides over a pinned beam, against the constrained equations of motion.

The program: a free slider of two spacings' length that touches with its middle node alone, on a
penalty spring. The peer: the mass stays on the beam, z(t) = w(X(t), t) with X = x0 + V t, and so
feels the convective terms of

    z'' = w_tt + 2 V w_xt + V^2 w_xx.

With w = sum q_k psi_k (upwards) and f = W + m z'' the force between the two, the modes obey

    (1 + (m/mu) psi psi^T) q'' = -omega^2 q - (psi/mu) (W + m (2 V psi'.q' + V^2 psi''.q)),

mu the beam's mass per length. Integrated by DOP853 of scipy until f = 0: there the mass lifts off,
since the contact cannot pull. From there it flies, z'' = -W/m, over free modes, until it meets the
beam again.
"""
import dataclasses

import numpy as np
from scipy.integrate import solve_ivp
from scipy.optimize import brentq

import common
import moving_load
from plate import BEAM, CRITICAL_SPEED, LENGTH, MASS_PER_LENGTH, STIFFNESS, WIDTH, omegas, shapes

MODES = 10
GRAVITY = 9.81                       # m/s^2
SPACING = 1e-6                       # m: the mass starts one spacing from the left support
KAPPA = 1e18                         # Pa/m
BEAM_SPRING = 48 * STIFFNESS / LENGTH**3  # N/m, of the beam's middle


def spring(kappa, spacing=SPACING):
    """Stiffness of one node's contact [N/m]."""
    return kappa * spacing * WIDTH


class Crossing:
    """A mass, as a part of the beam's, and a speed, as a part of the critical one."""

    def __init__(self, mass, speed, modes=MODES, spacing=SPACING):
        self.mass = mass * MASS_PER_LENGTH * LENGTH  # kg
        self.weight = self.mass * GRAVITY            # N
        self.speed = speed * CRITICAL_SPEED          # m/s
        self.modes, self.spacing = modes, spacing
        self.duration = (LENGTH - 3 * spacing) / self.speed
        self.middle = shapes(modes, LENGTH / 2)

    def where(self, time):
        return self.spacing + self.speed * time

    def scene(self, kappa, tolerance=1e-11, samples=400):
        thickness = 0.02
        return {
            "scene": {"duration": self.duration, "speed": self.speed, "start": 0.0,
                      "spacing": self.spacing, "faces": "linear",
                      "gap": "touching", "initial": "static"},
            "resonator": {**BEAM, "modes": self.modes},
            "slider": {"support": "free", "length": 2 * self.spacing, "thickness": thickness,
                       "width": WIDTH,
                       "young": 210e9,
                       "density": self.mass / (2 * self.spacing * thickness * WIDTH),
                       "damping": 0.0,
                       "modes": 0, "load": self.weight,
                       "surface": {"kind": "peaks",
                                   "peaks": [{"at": self.spacing, "height": 1e-4,
                                              "half_width": self.spacing}]}},
            "contact": {"law": "penalty", "stiffness": kappa},
            "time": {"scheme": "adaptive", "tolerance": tolerance},
            "output": {"rate": samples / self.duration, "probes": [LENGTH / 2]},
        }

    # ---- the peer --------------------------------------------------------------------------------

    def forces(self, time, q, v):
        """q'' and the force between mass and beam [N]."""
        psi, slope, bending = (shapes(self.modes, self.where(time), d) for d in range(3))
        convective = self.mass * (2 * self.speed * slope @ v + self.speed**2 * bending @ q)
        free = -omegas(self.modes)**2 * q - psi / MASS_PER_LENGTH * (self.weight + convective)
        share = self.mass / MASS_PER_LENGTH
        a = free - psi * (share * (psi @ free) / (1 + share * (psi @ psi)))
        return a, self.weight + self.mass * (psi @ a) + convective

    def static(self):
        """The modes under the weight where the mass starts."""
        return -shapes(self.modes,
                       self.spacing) * self.weight / (MASS_PER_LENGTH * omegas(self.modes)**2)

    def size(self):
        """Of the state: each mode's displacements and velocities under the weight in its middle."""
        still = np.sqrt(2 / LENGTH) * self.weight / (MASS_PER_LENGTH * omegas(self.modes)**2)
        return np.concatenate([still, still * omegas(self.modes)])

    def constrained(self, tolerance=1e-12):
        """The motion with the mass on the beam, until it lifts off or leaves: scipy's solution."""
        n = self.modes

        def rate(time, y):
            return np.concatenate([y[n:], self.forces(time, y[:n], y[n:])[0]])

        def force(time, y):
            return self.forces(time, y[:n], y[n:])[1]
        force.terminal, force.direction = True, -1
        start = self.static()
        return solve_ivp(rate, (0, self.duration), np.concatenate([start, 0 * start]),
                         method="DOP853", rtol=tolerance,
                         atol=tolerance * self.size(), events=force, dense_output=True)

    def lift_off(self, solution):
        """When the mass leaves the beam [s]; None where it never does."""
        return solution.t_events[0][0] if len(solution.t_events[0]) else None

    def landing(self, solution):
        """When the mass that has lifted off meets the beam again [s]; None where the beam ends
        before."""
        n, omega, off = self.modes, omegas(self.modes), self.lift_off(solution)
        q, v = solution.y[:n, -1], solution.y[n:, -1]
        psi, slope = shapes(n, self.where(off)), shapes(n, self.where(off), 1)
        z, rate = psi @ q, psi @ v + self.speed * slope @ q

        def gap(time):
            t = time - off
            w = shapes(n,
                       self.where(time)) @ (q * np.cos(omega * t) + v / omega * np.sin(omega * t))
            return z + rate * t - 0.5 * GRAVITY * t * t - w
        times = np.linspace(off, self.duration, 20001)[1:]
        gaps = np.array([gap(t) for t in times])
        shut = np.flatnonzero((gaps[1:] <= 0) & (gaps[:-1] > 0))
        return brentq(gap, times[shut[0]], times[shut[0] + 1], xtol=1e-15) if len(shut) else None

    def deflection(self, solution, times):
        """Of the beam's middle [m]: while the mass is on the beam, and of the free beam after
        it."""
        n, omega = self.modes, omegas(self.modes)[:, None]
        q = solution.sol(np.minimum(times, solution.t[-1]))[:n]
        last, rate, t = solution.y[:n, -1:], solution.y[n:, -1:], times - solution.t[-1]
        free = last * np.cos(omega * t) + rate / omega * np.sin(omega * t)
        return self.middle @ np.where(t > 0, free, q)

    # ---- the same with the spring, while it is pressed
    # --------------------------------------------

    def sprung(self, stiffness, times, tolerance=1e-12):
        """The middle's deflection at times, of the program's own model by the peer's integrator."""
        n, omega2 = self.modes, omegas(self.modes)**2

        def rate(time, y):
            psi = shapes(n, self.where(time))
            force = stiffness * (psi @ y[:n] - y[2 * n])
            return np.concatenate([y[n:2 * n], -omega2 * y[:n] - psi / MASS_PER_LENGTH * force,
                                   [y[2 * n + 1], force / self.mass - GRAVITY]])
        q = self.static()
        start = np.concatenate([q, 0 * q,
                                [shapes(n, self.spacing) @ q - self.weight / stiffness, 0.0]])
        size = np.concatenate([self.size(),
                               self.weight / BEAM_SPRING * np.array([1, omegas(1)[0]])])
        solution = solve_ivp(rate, (0, times[-1]), start, method="DOP853", rtol=tolerance,
                             atol=tolerance * size, t_eval=times)
        return self.middle @ solution.y[:n]

    # ---- side by side
    # ------------------------------------------------------------------------------

    @staticmethod
    def run(case, scene):
        return case.run(scene, "time", "probes/displacement", "shocks/start", "shocks/duration")

    def marched(self, case, kappa, **settings):
        return self.run(case, self.scene(kappa, **settings))

    def differences(self, marched, solution):
        """The largest difference of the middle's deflection, over the largest deflection: until the
        mass has lifted off in one of the two, and after that."""
        time, probe = marched[0], marched[1][:, 0]
        exact = self.deflection(solution, time)
        off = self.lift_off(solution)
        difference = np.abs(probe - exact) / np.abs(exact).max()
        in_contact = time <= (self.duration if off is None
                              else min(off, self.last_touch(marched, off)))
        return difference[in_contact].max(), difference[~in_contact].max(initial=0)

    def blow_of_lift_off(self, off, solution, kappa):
        """What the middle's deflection may differ by after lift-off, over the largest: the weight
        for a period of the contact more or less is a blow, after which mode k swings by blow
        psi_k/(mu omega_k)."""
        blow = self.weight * self.period(kappa)
        amplitude = np.abs(self.middle * shapes(self.modes,
                                                self.where(off))) / (MASS_PER_LENGTH
                                                                     * omegas(self.modes))
        return blow * amplitude.sum() / np.abs(self.deflection(solution,
                                                               np.linspace(0, self.duration,
                                                                           401))).max()

    def last_touch(self, marched, off):
        """When the marched mass lifts off for good [s]: the end of the last contact before it flies
        for longer than half of what is left after the peer has lifted off. Before that a stiff
        contact may open for a part of its period."""
        end = marched[2] + marched[3]
        flights = np.append(marched[2][1:], self.duration) - end
        long = np.flatnonzero(flights > 0.5 * (self.duration - off))
        return end[long[0]] if len(long) else np.nan

    def period(self, kappa):
        """Of the mass on its contact spring [s]."""
        return 2 * np.pi * np.sqrt(self.mass / spring(kappa, self.spacing))


@dataclasses.dataclass
class Found:
    """Of one mass at one speed. Differences of the middle's deflection over its largest."""
    mass: float       # over the beam's
    speed: float      # over the critical one
    largest: float    # m
    soft: float       # difference until lift-off, under the softer spring
    stiff: float      # ... under the stiffer one
    after: float      # ... of that, after lift-off
    off: float        # s: lift-off; NaN where there is none, as the three around it
    late: float       # s: of the marched mass, after that
    periods: float    # the same in periods of the contact
    force: float      # difference of a constant force instead of the mass


def compare_crossing(case, crossing, solution, kappas):
    """Runs a mass under both springs and compares; hands the case its checks."""
    soft, stiff = (crossing.marched(case, kappa) for kappa in kappas)
    (of_soft, _), (of_stiff, after) = (crossing.differences(marched, solution)
                                       for marched in (soft, stiff))
    case.check("difference of the deflection, over a tenth of that under a spring 10 times softer",
               10 * of_stiff / of_soft, 1.5,
               "what the spring yields goes with 1/kappa")
    off, late = crossing.lift_off(solution), np.nan
    if off is None:
        off = after = np.nan
    else:
        if crossing.landing(solution):
            raise SystemExit("moving-mass: the mass comes down again, and the constrained "
                             "equations do not say what follows")
        late = crossing.last_touch(stiff, off) - off
        case.check("lift-off, in periods of the mass on its spring",
                   abs(late) / crossing.period(kappas[1]), 1,
                   "the contact may open once a period where the mean force is small")
        case.check("deflection after lift-off", after,
                   crossing.blow_of_lift_off(off, solution, kappas[1]) + of_stiff,
                   "the weight for a period of the contact, more or less, as a blow")
    exact = crossing.deflection(solution, stiff[0])
    force = moving_load.middle(crossing.modes, crossing.speed, stiff[0], -crossing.weight)
    return Found(crossing.mass / (MASS_PER_LENGTH * LENGTH), crossing.speed / CRITICAL_SPEED,
                 np.abs(exact).max(), of_soft, of_stiff,
                 after, off, late, late / crossing.period(kappas[1]),
                 np.abs(force - exact).max() / np.abs(exact).max())


def against_spring(case, crossing, kappa):
    """The program's own model, spring and all, by the peer's integrator; so soft a spring that the
    contact stays shut."""
    tolerance = 1e-11
    time, probe = crossing.marched(case, kappa, tolerance=tolerance)[:2]
    exact = crossing.sprung(spring(kappa, crossing.spacing), time)
    difference = np.abs(probe[:, 0] - exact).max() / np.abs(exact).max()
    case.check("deflection, against the same spring in the peer's integrator", difference,
               10 * tolerance, "ten tolerances")
    case.text("own", difference)


def against_steps(case, crossing, solution, schemes, steps):
    """Multipliers instead of the spring: the contact is as rigid as the peer's, at the end of every
    step. Rows of what each scheme makes of each step."""
    off, rows = crossing.lift_off(solution), []
    for scheme in schemes:
        found = []
        for step in steps:
            scene = crossing.scene(KAPPA)
            scene["contact"], scene["time"] = {"law": "multiplier"}, {"scheme": scheme,
                                                                      "step": step}
            scene["output"]["rate"] = 1e4
            marched = crossing.run(case, scene)
            found.append((crossing.differences(marched, solution)[0],
                          crossing.last_touch(marched, off) - off, len(marched[2])))
            rows.append((scheme, step, *found[-1]))
        for i in range(len(steps) - 1):
            ratio = steps[i] / steps[i + 1]
            case.check("multipliers: difference of the deflection, over what first order makes of "
                       "a longer step's",
                       ratio * found[i + 1][0] / found[i][0], 1.5,
                       "the constraint holds at the ends of steps: first order")
            # the others open and close, and lift off at one of these
            if scheme == "backward-euler":
                case.check("multipliers, `backward-euler`: lift-off, over what first order makes "
                           "of a longer step's",
                           ratio * abs(found[i + 1][1] / found[i][1]), 1.5, "first order")
    return rows


def compare(case):
    if case.short:
        for crossing in (Crossing(0.5, 0.6, modes=5, spacing=1e-5),
                         Crossing(1.0, 0.3, modes=5, spacing=1e-5)):
            compare_crossing(case, crossing, crossing.constrained(), (1e16, 1e17))
        against_spring(case, Crossing(0.1, 0.6, modes=5, spacing=1e-5), 1e13)
        against_steps(case, crossing, crossing.constrained(), ("backward-euler", "midpoint"),
                      (1e-6, 1e-7))
        return
    crossings = [Crossing(mass, speed) for mass in (0.1, 0.5, 1.0, 2.0)
                 for speed in (0.05, 0.1, 0.3, 0.6, 1.0)]
    solutions = [crossing.constrained() for crossing in crossings]
    found = [compare_crossing(case, crossing, solution, (KAPPA / 10, KAPPA))
             for crossing, solution in zip(crossings, solutions)]
    against_spring(case, Crossing(0.1, 0.6), 1e14)
    tell_differences(case, found)
    chosen = next(i for i, each in enumerate(found) if np.allclose((each.mass, each.speed),
                                                                   (0.5, 0.6)))
    tell_peer(case, crossings[chosen], solutions[chosen])
    fall = tell_spring(case, crossings[chosen], solutions[chosen])
    tell_length(case)
    tell_steps(case)
    draw(case, zip(found, crossings, solutions), fall)


def tell_differences(case, found):
    case.table([field.name for field in dataclasses.fields(Found)],
               [dataclasses.astuple(each) for each in found])
    shown, rows = common.shown, []
    for each in found:
        flies = np.isfinite(each.off)
        rows.append((shown(each.mass), shown(each.speed), shown(1e3 * each.largest, 3),
                     shown(each.soft), shown(each.stiff),
                     shown(each.after) if flies else "", shown(1e3 * each.off, 6) if flies
                     else "never",
                     shown(1e6 * each.late) if flies else "", f"{100 * each.force:.1f} %"))
    case.text("table", common.markdown(
        ("mass / beam's", "speed / critical", "largest deflection, mm", "difference, 1e17 Pa/m",
         "1e18 Pa/m", "... after lift-off",
         "lifts off at, ms", "ra2d later by, us", "a force instead of the mass"), rows))
    case.text("stiffness", BEAM_SPRING / spring(KAPPA))
    for name in ("stiff", "soft", "after"):
        case.text(f"largest-{name}", np.nanmax([getattr(each, name) for each in found]))
    case.text("over-estimate", max(each.stiff for each in found) / (BEAM_SPRING / spring(KAPPA)))
    case.text("latest", max(abs(each.periods) for each in found if np.isfinite(each.off)))
    for name, mass in (("light", 0.1), ("heavy", 2.0)):
        case.text(name,
                  f"{100 * max(each.force for each in found if np.isclose(each.mass, mass)):.0f}")


def tell_peer(case, crossing, solution):
    """The peer's own error, and how many modes the answer takes."""
    times = np.linspace(0, crossing.duration, 401)
    finer = crossing.constrained(1e-13)
    exact = crossing.deflection(finer, times)
    case.text("peer",
              np.abs(crossing.deflection(solution, times) - exact).max() / np.abs(exact).max())
    case.text("peer-time", abs(crossing.lift_off(finer) - crossing.lift_off(solution)))
    peers = [Crossing(0.5, 0.6, modes) for modes in (40, 20, 10, 5)]
    rows, fullest = [], None
    for peer in peers:
        solution = peer.constrained()
        deflection = peer.deflection(solution, times)
        fullest = deflection if fullest is None else fullest
        off = np.abs(deflection - fullest).max() / np.abs(fullest).max()
        rows.append((peer.modes, common.shown(off) if off else "",
                     common.shown(1e3 * peer.lift_off(solution), 6)))
    case.text("modes-table", common.markdown(("modes", "deflection off by", "lifts off at, ms"),
                                             rows[::-1]))


def tell_spring(case, crossing, solution):
    """What is left: the spring. Returns (kappa, difference, lateness of lift-off, period of the
    contact, contacts)."""
    fall = []
    for kappa in (1e14, 1e15, 1e16, 1e17, 1e18, 1e19):
        marched, off = crossing.marched(case, kappa), crossing.lift_off(solution)
        fall.append((kappa, crossing.differences(marched, solution)[0],
                     crossing.last_touch(marched, off) - off,
                     crossing.period(kappa), len(marched[2])))
    fall = np.array(fall)
    slope = np.polyfit(*np.log(fall[1:5, :2].T), 1)[0]
    case.check("slope of the difference over kappa, from -1", abs(slope + 1), 0.05,
               "the spring's yield is f/(kappa chi w)")
    case.text("slope", f"{slope:.3f}")
    case.text("kappa-table", common.markdown(
        ("kappa, Pa/m", "difference of the deflection", "lift-off later by, us",
         "period of the contact, us", "contacts"),
        [(common.shown(kappa, 1), common.shown(off), common.shown(1e6 * late),
          common.shown(1e6 * period), f"{contacts:.0f}")
         for kappa, off, late, period, contacts in fall]))
    return fall


def tell_length(case):
    """The slider's length, and with it the spacing, on one spring."""
    rows = []
    for spacing in (1e-4, 1e-5, 1e-6):
        crossing = Crossing(0.5, 0.6, spacing=spacing)
        solution = crossing.constrained()
        marched, off = crossing.marched(case,
                                        KAPPA * SPACING / spacing), crossing.lift_off(solution)
        difference, late = crossing.differences(marched,
                                                solution)[0], crossing.last_touch(
                                                    marched, off) - off
        rows.append((common.shown(1e6 * spacing), common.shown(difference),
                     common.shown(1e6 * late), len(marched[2])))
    case.text("length-table", common.markdown(("spacing, um", "difference of the deflection",
                                               "lift-off later by, us", "contacts"), rows))


def tell_steps(case):
    crossing = Crossing(0.5, 0.6, spacing=1e-5)
    rows = against_steps(case, crossing, crossing.constrained(),
                         ("backward-euler", "midpoint", "rk4", "exact"), (1e-6, 1e-7, 1e-8))
    case.text("steps-table", common.markdown(
        ("scheme", "step, s", "difference of the deflection", "lift-off later by, us", "contacts"),
        [(f"`{scheme}`", common.shown(step, 1), common.shown(off),
          common.shown(1e6 * late), contacts)
         for scheme, step, off, late, contacts in rows]))


def draw(case, all_found, fall):
    plt, style = common.pyplot()
    figure, (upper, middle, lower) = plt.subplots(3, 1, figsize=(7, 8.5), layout="constrained")
    colours = {0.1: style.BLUE, 0.5: style.RUST, 1.0: style.GREEN, 2.0: style.PLUM}
    for found, crossing, solution in all_found:
        if not np.isclose(found.speed, 0.6):
            continue
        mass = next(mass for mass in colours if np.isclose(mass, found.mass))
        static = -crossing.weight / BEAM_SPRING

        def place(time):
            return crossing.where(time) / LENGTH
        times = np.linspace(0, crossing.duration, 121)
        upper.plot(place(times), crossing.deflection(solution, times) / static, color=colours[mass],
                   lw=1.2, label=f"{mass}")
        time, probe = crossing.marched(case, KAPPA, samples=32)[:2]
        upper.plot(place(time), probe[:, 0] / static, "o", color=colours[mass], ms=3, mfc="none")
        if np.isfinite(found.off):
            upper.plot(place(found.off),
                       crossing.deflection(solution, np.array([found.off])) / static, "x",
                       color=colours[mass], ms=8)
    speed = 0.6 * CRITICAL_SPEED
    times = np.linspace(0, LENGTH / speed, 121)
    upper.plot(times * speed / LENGTH,
               moving_load.middle(MODES, speed, times) / (moving_load.FORCE / BEAM_SPRING),
               color=style.GREY, lw=1, ls="--", label="a constant force")
    upper.set(title="0.6 of the critical speed: constrained equations (lines), ra2d (circles), "
                    "lift-off (crosses)",
              xlabel="place of the mass over the beam's length",
              ylabel="deflection of the middle / static")
    upper.legend(title="mass over the beam's", ncols=2)
    kappas, differences, late, periods, _ = fall.T
    middle.loglog(kappas, differences, "o-", color=style.BLUE, ms=4, lw=1,
                  label="difference of the deflection")
    middle.loglog(kappas, differences[2] * kappas[2] / kappas, color=style.GREY, lw=1, ls="--",
                  label="1/kappa")
    middle.set(title="Mass 0.5, speed 0.6: what the contact spring makes",
               ylabel="over the largest deflection", xlabel="kappa, Pa/m")
    lower.loglog(kappas, np.abs(late), "s-", color=style.RUST, ms=4, lw=1,
                 label="difference of the time of lift-off")
    lower.loglog(kappas, periods, color=style.GREY, lw=1, ls="--",
                 label="a period of the mass on its spring")
    lower.set(xlabel="kappa, Pa/m", ylabel="s")
    for axes in (middle, lower):
        axes.legend()
    case.figure(figure)


if __name__ == "__main__":
    common.main("moving-mass", compare)
