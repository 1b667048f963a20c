"""Bodies that only contact holds: rigid modes, balance, the answer by another route, and proofs that nothing holds them."""

import numpy as np
import pytest
from scipy import sparse
from scipy.optimize import linprog, minimize
from scipy.sparse.linalg import splu

from conftest import ROOT
from faults.program import Program
from floating.__main__ import verdict
from floating.bodies import body
from run_file import open_run, read_matrix

SLOPE = ROOT / "pipelines" / "block_on_slope.toml"
FRICTION = 0.3


def run(contact3d, folder, name, *changes, scene=SLOPE, code=0):
    """The run file of a scene with changes."""
    path = folder / f"{name}.h5"
    arguments = [word for change in changes for word in ("--set", change)]
    contact3d("run", scene, path, "--no-figures", *arguments, expect=code)
    return path


@pytest.fixture(scope="module")
def file(contact3d, tmp_path_factory):
    """A coarse block on a slope."""
    folder = tmp_path_factory.mktemp("floating")
    path = run(contact3d, folder, "slope", "body.brick.cells=[8,4,2]")
    with open_run(path) as file:
        yield file


def coupling(file):
    """B, [3m, n_free]."""
    names = ("coupling_normal", "coupling_tangential")
    return sparse.vstack([read_matrix(file["assemble"][name]) for name in names]).tocsr()


def multiplier(file):
    """Normal components, then pairs."""
    names = ("multiplier_normal", "multiplier_tangential")
    return np.concatenate([file["solve"][name][:].ravel() for name in names])


def free(file, nodal):
    """A nodal field over the free degrees of freedom."""
    dof = file["assemble/degree_of_freedom"][:]
    values = np.empty(dof.max() + 1)
    values[dof[dof >= 0]] = nodal[dof >= 0]
    return values


def rigid_motions(file):
    """Translations and rotations about the origin from coordinates alone, [6, n_free]."""
    x = file["mesh/coordinates"][:]
    axes = np.eye(3)
    fields = [np.broadcast_to(a, x.shape) for a in axes] + [np.cross(a, x) for a in axes]
    return np.array([free(file, field) for field in fields])


def test_the_modes_are_the_rigid_motions(file):
    modes, pins = file["assemble/rigid_modes"][:], file["assemble/rigid_pins"][:]
    stiffness = read_matrix(file["assemble/stiffness"])
    assert np.array_equal(modes[:, pins], np.eye(6))
    # Rounding of coordinates in products with entries of A.
    assert np.abs(stiffness @ modes.T).max() < 1e-12 * np.abs(stiffness.data).max()
    both = np.vstack([modes, rigid_motions(file)])
    assert np.linalg.matrix_rank(both, tol=1e-9) == 6


def test_the_factor_is_that_of_the_body_on_springs(file):
    stiffness = read_matrix(file["assemble/stiffness"]).tolil()
    spring = float(file["assemble/rigid_spring"][()])
    for pin in file["assemble/rigid_pins"][:]:
        stiffness[pin, pin] += spring
    solve = splu(stiffness.tocsc()).solve
    b = coupling(file)
    operator = b @ solve(b.T.toarray())
    stored = file["assemble/dual_operator"][:]
    # Two factorisations of a matrix whose condition is below 1e6.
    assert np.abs(operator - stored).max() < 1e-9 * np.abs(stored).max()


def test_forces_and_moments_balance(file):
    stiffness = read_matrix(file["assemble/stiffness"])
    load, u = file["load/force"][:], free(file, file["solve/displacement"][:])
    contact = coupling(file).T @ multiplier(file)
    left = load - contact - stiffness @ u
    # Rounding of A u for a displacement of its own size.
    assert np.abs(left).max() < 1e-9 * np.abs(load).max()
    resultant = rigid_motions(file) @ (load - contact)
    assert np.abs(resultant).max() < 1e-12 * np.abs(rigid_motions(file)).max() * np.abs(load).sum()


def test_the_answer_is_that_of_a_pinned_body_by_other_algorithms(file):
    """Six degrees of freedom held instead of springs, and frozen problems by sequential quadratic programming."""
    b, load = coupling(file), file["load/force"][:]
    stiffness = read_matrix(file["assemble/stiffness"]).tocsc()
    modes, pins = rigid_motions(file), file["assemble/rigid_pins"][:]
    kept = np.setdiff1d(np.arange(load.size), pins)
    solve = splu(stiffness[kept][:, kept]).solve
    s = b[:, kept] @ solve(b[:, kept].T.toarray())
    h = b[:, kept] @ solve(load[kept])
    g, e = b @ modes.T, modes @ load
    m = file["mesh/pane_area"].size
    stored = multiplier(file)
    # Pressures of about one, and a compliance of about one.
    unit = e[2] / file["mesh/pane_area"][:].sum()
    scale = np.abs(unit) / np.abs(h).max()
    s, h, g, e = s * scale * abs(unit), h * scale, g * abs(unit), e
    rows = np.abs(g).max(axis=0)
    g, e = g / rows, e / rows
    bound = np.ones(m)
    answer = np.zeros(3 * m)
    answer[:m] = 1.0
    for _ in range(60):
        limits = FRICTION * bound
        inside = {
            "type": "ineq",
            "fun": lambda x, limits=limits: limits**2 - (x[m:].reshape(-1, 2) ** 2).sum(axis=1),
            "jac": lambda x: np.hstack(
                [
                    np.zeros((m, m)),
                    -2
                    * (np.eye(m)[:, :, None] * x[m:].reshape(-1, 2)[None, :, :]).reshape(m, 2 * m),
                ]
            ),
        }
        balance = {"type": "eq", "fun": lambda x: g.T @ x - e, "jac": lambda x: g.T}
        found = minimize(
            lambda x: 0.5 * x @ s @ x - h @ x,
            answer,
            jac=lambda x: s @ x - h,
            bounds=[(0, None)] * m + [(None, None)] * (2 * m),
            constraints=[balance, inside],
            method="SLSQP",
            options={"maxiter": 500, "ftol": 1e-15},
        )
        change = np.abs(found.x - answer).max()
        answer = found.x
        bound = np.maximum(answer[:m], 0.0)
        if change < 1e-8:
            break
    # Pressures are about one. SLSQP leaves changes of some 1e-7, which successive approximations do not average out.
    assert np.abs(answer - stored / abs(unit)).max() < 5e-6


@pytest.mark.parametrize("slope", [FRICTION * (1 + 1e-6), 0.5, 3.0])
def test_no_equilibrium_comes_with_its_proof(contact3d, tmp_path, slope):
    changes = ("body.brick.cells=[8,4,2]", f"parameters.slope={slope!r}")
    with open_run(run(contact3d, tmp_path, "off", *changes, code=1)) as file:
        assert not file["solve/displacement"][:].any()
        assert not file["solve/rigid_motion"][:].any()
        motion = free(file, file["solve/mechanism"][:])
        load = file["load/force"][:]
        area = file["mesh/pane_area"][:]
        moved = coupling(file) @ motion
        normal, slip = moved[: area.size] / area, moved[area.size :].reshape(-1, 2)
        slip = np.linalg.norm(slip, axis=1) / area
        opposed = normal + FRICTION * slip
        # No pressure λ does work against the motion: λ (w_n + F |w_t|) ≤ 0, but for rounding, which would take forces of ten
        # thousand times the load to count.
        assert opposed.max() < 1e-12
        assert motion @ load > 1e-8 * np.abs(motion * load).sum()


@pytest.mark.parametrize(
    ("slope", "holds"), [(FRICTION * (1 - 1e-6), True), (FRICTION * (1 + 1e-6), False)]
)
def test_a_linear_programme_agrees(contact3d, tmp_path, slope, holds):
    """Admissible forces exist in a polygon inside, or do not exist in one around, the circles of friction."""
    changes = ("body.brick.cells=[8,4,2]", f"parameters.slope={slope!r}")
    path = run(contact3d, tmp_path, "lp", *changes, code=0 if holds else 1)
    with open_run(path) as file:
        g = coupling(file) @ rigid_motions(file).T
        e = rigid_motions(file) @ file["load/force"][:]
        m = file["mesh/pane_area"].size
    # A polygon of 64 sides with a corner, or a side, along x, where the load pulls.
    angles = 2 * np.pi * np.arange(64) / 64
    radius = FRICTION
    if not holds:
        angles, radius = angles + np.pi / 64, FRICTION / np.cos(np.pi / 64)
    corners = radius * np.array([np.cos(angles), np.sin(angles)])
    pressures = np.repeat(g[:m], 64, axis=0)
    shears = np.einsum("ptk,tc->pck", g[m:].reshape(m, 2, 6), corners).reshape(-1, 6)
    size = np.abs(e).max()
    found = linprog(
        np.zeros(64 * m),
        A_eq=(pressures + shears).T,
        b_eq=e / size,
        method="highs",
        options={"primal_feasibility_tolerance": 1e-10},
    )
    assert found.success == holds, found.message


def test_random_bodies(program, tmp_path):
    """A few bodies of the campaign `python-checks/floating`."""
    wrong = [verdict(Program(program), body(1, number), tmp_path)[1] for number in range(16)]
    assert not any(wrong), wrong
