#!/usr/bin/env python3
# SPDX-License-Identifier: BSD-3-Clause
"""check_law.py TABLE.json SAID.json: what `ra2d analyze STUDY --json` says of a law, by the
definitions.

TABLE has the values of the axes, the seeds' last, and v_rms in C order.
"""
import itertools
import json
import sys

import numpy as np
import scipy.linalg
import scipy.stats

table, said = (json.load(open(file)) for file in sys.argv[1:3])
law = said["law"]
places = list(itertools.product(*table["axes"]))
v = np.array([np.nan if value is None else value for value in table["v_rms"]])
there = np.isfinite(v)
y = np.log10(v[there])
x = np.column_stack([np.ones(len(y)), np.log10([p[:-1] for p, ok in zip(places, there) if ok])])
seed = np.array([p[-1] for p, ok in zip(places, there) if ok])

# Bell and McCaffrey's sandwich, with matrices of all runs
bread = np.linalg.inv(x.T @ x)
residual = y - x @ bread @ x.T @ y
hat = np.eye(len(y)) - x @ bread @ x.T
for k, name in enumerate(law["exponents"], start=1):
    forms = []
    for s in np.unique(seed):
        own = np.flatnonzero(seed == s)
        values, vectors = scipy.linalg.eigh(np.eye(len(own)) - x[own] @ bread @ x[own].T)
        root = vectors @ np.diag([1 / np.sqrt(w) if w > 1e-9 else 0 for w in values]) @ vectors.T
        whole = np.zeros(len(y))
        whole[own] = root @ x[own] @ bread[k]
        forms.append(hat @ whole)
    forms = np.array(forms)
    error = np.sqrt(np.sum((forms @ residual) ** 2))
    weights = np.linalg.eigvalsh(forms @ forms.T)
    freedom = weights.sum() ** 2 / (weights**2).sum()
    value = bread[k] @ x.T @ y
    half = scipy.stats.t.ppf(0.975, freedom) * error
    found = law["exponents"][name]
    assert np.allclose([found["value"], found["low"], found["high"]],
                       [value, value - half, value + half], rtol=1e-8), \
        (name, found, value, half)

# lack of fit, of the seeds that have every point
shape = [len(axis) for axis in table["axes"]]
grid = np.log10(v).reshape(-1, shape[-1])
points = np.array(places).reshape(-1, shape[-1], len(shape))[:, 0, :-1]
keep = 3 * np.isfinite(grid).sum(1) >= 2 * shape[-1]
grid, points = grid[keep], points[keep]
grid = grid[:, np.isfinite(grid).all(0)]
x = np.column_stack([np.ones(len(points)), np.log10(points)])
seeds, terms = grid.shape[1], len(points) - x.shape[1]
contrasts = scipy.linalg.null_space(x.T)  # what no line follows
left = contrasts.T @ grid
covariance = np.cov(left)
f = seeds * np.sum(left.mean(1) ** 2) / np.trace(covariance)
box = np.trace(covariance) ** 2 / (terms * np.trace(covariance @ covariance))
share = (seeds * terms * box - 2) / (terms * (seeds - 1 - terms * box))
share = min(1, max(share, 1 / terms))
p = scipy.stats.f.sf(f, share * terms, share * terms * (seeds - 1))
line = law["straight_line"]
assert np.allclose([line["f"], *line["degrees_of_freedom"]],
                   [f, share * terms, share * terms * (seeds - 1)],
                   rtol=1e-8), (line, f, share)
assert np.isclose(line["p"], p, rtol=1e-6), (line, p)
assert line["fits"] == bool(p >= 0.05)
print("fine: p =", p)
