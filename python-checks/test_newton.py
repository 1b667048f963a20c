"""The dense dual operator and Newton's answer, against scipy and the raw arrays."""

import subprocess
import sys
from pathlib import Path

import numpy as np
import pytest

from conftest import GIVEN, ROOT
from raw_problem import RawProblem
from run_file import open_run
from schema_check import schema_problems


@pytest.fixture(scope="module", params=GIVEN or [None], ids=lambda path: path.stem if path else "published")
def path(request, contact3d, tmp_path_factory):
    """The published problem at n_div = 4 with the program's own choice of method, or the files given."""
    if GIVEN:
        return request.param
    path = tmp_path_factory.mktemp("newton") / "run.h5"
    scene = ROOT / "pipelines" / "newton.toml"
    cells = "body.brick.cells=[12,4,4]"
    contact3d("run", scene, path, "--no-figures", "--set", cells)
    return path


@pytest.fixture(scope="module")
def solved(path):
    """The open file and its raw problem."""
    with open_run(path) as file:
        yield file, RawProblem.read(file)


def test_schema_of_a_file_with_the_dense_operator(path, schema):
    with open_run(path) as file:
        assert schema_problems(file, schema) == []


def test_dense_operator_is_symmetric_and_equals_backsolves(solved):
    file, problem = solved
    operator = file["assemble/dual_operator"][:]
    assert np.array_equal(operator, operator.T)
    expected = problem.dual_operator
    # Two factorisations of a matrix with condition number near 1e4.
    assert np.abs(operator - expected).max() <= 1e-12 * np.abs(expected).max()


def test_compliance_is_that_of_unit_stresses(solved):
    """H column by column, those of open panes, which no answer shows, included."""
    file, problem = solved
    compliance = file["assemble/contact_compliance"][:]
    moved = problem.solve_stiffness(problem.coupling.T.toarray())
    nodal = np.stack([problem.to_nodes(column) for column in moved.T])
    expected = nodal[:, problem.contact_nodes] @ problem.frame[1:].T
    # Two factorisations of a matrix with condition number near 1e4.
    assert compliance.shape == expected.shape
    assert np.abs(compliance - expected).max() <= 1e-12 * np.abs(expected).max()


def test_compliance_gives_the_tangential_displacement(solved):
    file, problem = solved
    multiplier = problem.multiplier
    compliance = file["assemble/contact_compliance"][:]
    moved = np.tensordot(multiplier, compliance, axes=1)
    slip = np.abs(file["load/slip_free"][:] - moved)
    expected = problem.slip(problem.displacement_of(multiplier))
    # The free slip is some hundred times the final one, so two digits cancel.
    assert np.abs(slip - expected).max() <= 1e-11 * np.abs(expected).max()


def test_answer_is_a_fixed_point_of_projected_gradient_steps(solved):
    file, problem = solved
    multiplier = problem.multiplier
    displacement = problem.displacement_of(multiplier)
    friction = problem.nodal_friction(problem.slip(displacement))
    inverse = problem.friction_inverse(friction)
    gradient = problem.dual_operator @ multiplier - file["load/dual_rhs"][:]
    step = multiplier - file["solve/steplength"][()] * gradient
    image = problem.project(step, np.maximum(problem.normal, 0.0), inverse)
    # Newton stops at 1e-12; S and u are recomputed by another factorisation.
    assert np.linalg.norm(image - multiplier) <= 1e-11 * np.linalg.norm(multiplier)


def test_local_stiffness_is_the_diagonal_of_the_inverse(solved):
    _, problem = solved
    exact = np.diag(np.linalg.inv(problem.dual_operator)).copy()
    pairs = exact[problem.n_panes :].reshape(-1, 2)
    pairs[:] = pairs.mean(axis=1, keepdims=True)
    # Two inverses of a matrix whose condition number is some 1e4.
    assert problem.local_stiffness == pytest.approx(exact, rel=1e-9)


def test_inspection_knows_newton(path):
    script = ROOT / "python-checks" / "inspect_run.py"
    command = [sys.executable, str(script), str(path)]
    result = subprocess.run(command, capture_output=True, text=True, check=False)
    assert result.returncode == 0, result.stderr
    assert "0 outer" in result.stdout
    assert "fixed_point" in result.stdout


def test_history_ends_at_rounding_and_the_accuracy_is_that_asked_for(solved):
    file, _ = solved
    residual = file["solve/newton/residual"][:]
    # The last step measures the error of the answer, which is not moved any more.
    assert max(residual[-1], file["solve/accuracy"][()]) <= 1e-12
    assert len(residual) <= 16
    assert not file["solve/newton/safeguard"][:].any()
    assert file["solve/mapping_change"][()] <= 1e-11
