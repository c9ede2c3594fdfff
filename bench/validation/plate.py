# SPDX-License-Identifier: BSD-3-Clause
"""The paper's plate, without damping, and its modes by the textbook: pinned, by Euler and
Bernoulli."""
import numpy as np

LENGTH, THICKNESS, WIDTH, YOUNG, DENSITY = 0.3, 0.002, 0.2, 210e9, 7800.0  # m, m, m, Pa, kg/m^3
STIFFNESS = YOUNG * WIDTH * THICKNESS**3 / 12    # D, N m^2
MASS_PER_LENGTH = DENSITY * THICKNESS * WIDTH    # m, kg/m
CRITICAL_SPEED = np.pi / LENGTH * np.sqrt(STIFFNESS / MASS_PER_LENGTH)  # m/s

BEAM = {"support": "pinned", "length": LENGTH, "thickness": THICKNESS, "width": WIDTH,
        "young": YOUNG,
        "density": DENSITY, "damping": 0.0}


def waves(modes):
    """k pi/L of each mode [1/m]."""
    return np.arange(1, modes + 1) * np.pi / LENGTH


def omegas(modes):
    """1/s"""
    return np.sqrt(STIFFNESS / MASS_PER_LENGTH) * waves(modes)**2


def shapes(modes, x, derivative=0):
    """psi_k, or its first or second derivative, at x [m]."""
    beta = waves(modes)
    return np.sqrt(2 / LENGTH) * beta**derivative * np.sin(beta * x + derivative * np.pi / 2)
