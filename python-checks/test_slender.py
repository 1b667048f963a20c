"""Strips so slender that B A^-1 B' loses the digits of their gaps, against the saddle point problem [A B'; B 0] of scipy's sparse LU."""

import numpy as np
import pytest
from scipy import sparse
from scipy.sparse.linalg import splu

from raw_problem import RawProblem, nearest_in_ellipses
from run_file import open_run

# 500 thicknesses long; its tip would sink by 9 m without the floor, which is wavy by a micrometre.
STRIP = """
title = "strip"
[body]
element = "P2"
[body.brick]
size = [100.0, 1.0, 0.2]
cells = [20, 2, 1]
[material.isotropic]
young_modulus = 8.0594e+08
poisson_ratio = 0.3
[[clamp]]
face = "x_min"
[body_force]
value = [{along}, 0.0, -3.3991]
[contact]
face = "z_min"
multipliers = "nodal"
gap = "7.267469359152741e-07*(1 + cos(0.03084214042701261*x))"
{friction}
"""
COEFFICIENT = 0.3
SCENES = {
    "frictionless": ("0.0", ""),
    "friction": ("0.5", f"[friction]\ncoefficient.constant = {COEFFICIENT}"),
}


@pytest.fixture(params=SCENES)
def solved(request, contact3d, tmp_path):
    """The raw problem of a strip, its mean gaps times areas, and whether it has friction."""
    scene, path = tmp_path / "strip.toml", tmp_path / "strip.h5"
    along, friction = SCENES[request.param]
    scene.write_text(STRIP.format(along=along, friction=friction))
    contact3d("run", scene, path, "--no-figures")
    with open_run(path) as file:
        problem = RawProblem.read(file)
    x = problem.coordinates[problem.contact_nodes, 0]
    gap = 7.267469359152741e-07 * (1.0 + np.cos(0.03084214042701261 * x))
    return problem, problem.pane_area * (problem.pane_average.T @ gap), bool(friction)


def test_contact_stresses_are_those_of_the_saddle_point_problem(solved):
    problem, gap, has_friction = solved
    m, n = problem.n_panes, problem.load.size
    a, b = problem.stiffness, problem.coupling
    gaps = np.zeros(b.shape[0])
    gaps[:m] = gap
    pressed = problem.normal > 0.0
    # Rows of the system: pressed panes have no gap, and those that stick no slip; others have a known stress.
    fixed = np.concatenate([pressed, np.zeros(b.shape[0] - m, bool)])
    if has_friction:
        share = np.hypot(*problem.tangential.T) / np.maximum(problem.normal, 1e-300)
        sticks = pressed & (share < COEFFICIENT * (1.0 - 1e-9))
        assert 0 < sticks.sum() < pressed.sum()
        fixed[m:] = np.repeat(sticks, 2)
    known = np.where(fixed, 0.0, problem.multiplier)
    rows = b[fixed]
    scale = abs(a).max() / abs(b).max()
    system = sparse.bmat([[a, scale * rows.T], [scale * rows, None]], format="csc")
    rhs = np.concatenate([problem.load - b.T @ known, scale * gaps[fixed]])
    factor = splu(system)
    solution = factor.solve(rhs)
    for _ in range(3):
        solution += factor.solve(rhs - system @ solution)
    expected = known.copy()
    expected[fixed] = scale * solution[n:]
    # Two factorisations of a matrix with a condition number near 1e12, refined.
    assert np.abs(expected - problem.multiplier).max() <= 1e-8 * problem.normal.max()
    # Open panes do not penetrate, pressed ones pull nowhere, and friction works against the slip.
    open_gaps = gap - (b @ solution[:n])[:m]
    assert expected[:m].min() >= 0.0
    assert open_gaps[~pressed].min() >= -1e-9 * gap.max()
    if has_friction:
        slip = (b @ solution[:n])[m:].reshape(-1, 2)
        slides = pressed & ~sticks
        along = np.sum(slip * problem.tangential, axis=1)[slides]
        sizes = np.hypot(*slip.T) * np.hypot(*problem.tangential.T)
        assert (along >= (1.0 - 1e-6) * sizes[slides]).all()
        bound = COEFFICIENT * problem.normal[:, None] * np.ones(2)
        nearest = nearest_in_ellipses(problem.tangential, bound)
        assert np.abs(nearest - problem.tangential).max() <= 1e-12 * problem.normal.max()
