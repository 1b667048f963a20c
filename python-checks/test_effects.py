"""Frictionless and Tresca contact against scipy and Clarabel on the raw arrays."""

import json

import numpy as np
import pytest
from scipy.linalg import cholesky
from scipy.optimize import nnls
from scipy.sparse.linalg import splu

from conftest import ROOT
from quadratic_program import solve_inner
from raw_problem import RawProblem
from run_file import open_run, read_matrix

CELLS = "body.brick.cells=[12,4,4]"

# J = u'Au/2 - l'u in N m of the published body and loads on a smooth foundation, nodal multipliers,
# n_div = 8, by the active set below; tests/verification.rs has it too.
FRICTIONLESS_ENERGY = -8213.159249


def solve(contact3d, folder, name, *changes):
    """Run a pipeline with changes; the open file and the program's JSON."""
    path = folder / "run.h5"
    scene = ROOT / "pipelines" / name
    settings = [part for change in changes for part in ("--set", change)]
    run = contact3d("run", scene, path, "--no-figures", "--json", *settings)
    return open_run(path), json.loads(run.stdout)


def frictionless(file):
    """S, h, A, l and N of a frictionless problem, by scipy's own factorisation."""
    stiffness = read_matrix(file["assemble/stiffness"]).tocsc()
    normal = read_matrix(file["assemble/coupling_normal"])
    load = file["load/force"][:]
    inverse = splu(stiffness).solve
    operator = normal @ inverse(normal.T.toarray())
    gap = np.zeros(normal.shape[0])
    rhs = normal @ inverse(load) - gap
    return (operator + operator.T) / 2, rhs, stiffness, load, normal


def active_set(operator, rhs):
    """The minimiser of x'Sx/2 - x'h over x >= 0, by Lawson and Hanson's active set."""
    scale = np.abs(operator).max()
    upper = cholesky(operator / scale)
    target = np.linalg.solve(upper.T, rhs / scale)
    unit = np.abs(target).max()
    return unit * nnls(upper, target / unit, maxiter=100 * len(rhs))[0]


@pytest.mark.parametrize("space", ["panes", "nodal"])
def test_frictionless_contact_is_the_active_sets_minimiser(contact3d, tmp_path, space):
    multipliers = f'contact.multipliers="{space}"'
    file, result = solve(
        contact3d, tmp_path, "frictionless.toml", CELLS, multipliers
    )
    with file:
        operator, rhs, stiffness, load, normal = frictionless(file)
        found = file["solve/multiplier_normal"][:]
    expected = active_set(operator, rhs)
    assert np.array_equal(found > 0, expected > 0)
    # Factorisations with condition number near 1e4, and S with one of some hundred.
    limit = 1e-9 * np.linalg.norm(expected)
    assert np.linalg.norm(found - expected) <= limit
    u = splu(stiffness).solve(load - normal.T @ expected)
    # Quadratic in the error of the multipliers, so roundings alone are left.
    assert result["energy"] == pytest.approx(u @ (stiffness @ u) / 2 - load @ u, 1e-12)


def test_energy_of_frictionless_nodal_contact(contact3d, tmp_path):
    """The published body and loads at n_div = 8; the active set's J is the figure."""
    file, result = solve(
        contact3d,
        tmp_path,
        "frictionless.toml",
        "body.brick.cells=[24,8,8]",
        'contact.multipliers="nodal"',
        "pressure=[]",
        'traction=[{face="x_max",value=[1e7,0,2e7]},{face="z_max",value=[0,0,-3e7]}]',
    )
    with file:
        operator, rhs, stiffness, load, normal = frictionless(file)
    u = splu(stiffness).solve(load - normal.T @ active_set(operator, rhs))
    expected = u @ (stiffness @ u) / 2 - load @ u
    # Half a unit of the last digit written.
    assert expected == pytest.approx(FRICTIONLESS_ENERGY, abs=5e-7)
    assert result["energy"] == pytest.approx(FRICTIONLESS_ENERGY, abs=5e-7)


def test_tresca_friction_is_the_conic_programs_minimiser(contact3d, tmp_path):
    file, _ = solve(contact3d, tmp_path, "tresca.toml", CELLS)
    with file:
        problem = RawProblem.read(file)
        margin = file["post/margin"][:]
        place = problem.coordinates[problem.contact_nodes, 0]
    bound = problem.pane_average.T @ (5e6 * (1 - place / 6))
    inverse = np.tile([1.0, 1 / 0.5], (problem.n_panes, 1))
    expected = solve_inner(problem, bound, inverse)
    # The root is found to 1e-14 of a residual; S has a condition number of some hundred.
    limit = 1e-9 * np.linalg.norm(expected)
    assert np.linalg.norm(problem.multiplier - expected) <= limit
    # The bound acts on open panes, and the margin says how near they are to it.
    used = np.linalg.norm(inverse * problem.tangential, axis=1) / bound
    assert used[problem.normal <= 0].max() > 0.5
    assert np.abs(margin - (1 - used)).max() <= 1e-12
