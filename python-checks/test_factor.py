"""The stored Cholesky factor and the dual data against scipy's own factorisation."""

import numpy as np
import pytest
from scipy import sparse
from scipy.sparse.linalg import spsolve_triangular

from conftest import SCENE, changes
from raw_problem import RawProblem
from run_file import open_run


def cholesky_factor(factor, name: str = "values") -> sparse.csc_matrix:
    """L as a scipy matrix from the supernodal panels."""
    columns = factor["supernode_columns"][:]
    row_offsets, value_offsets = factor["row_offsets"][:], factor["value_offsets"][:]
    row_indices, values = factor["row_indices"][:], factor[name][:]
    rows, cols, data = [], [], []
    for s in range(columns.size - 1):
        own = np.arange(columns[s], columns[s + 1])
        panel_rows = row_indices[row_offsets[s] : row_offsets[s + 1]]
        panel = values[value_offsets[s] : value_offsets[s + 1]]
        assert panel.size == panel_rows.size * own.size
        assert np.array_equal(panel_rows[: own.size], own)
        # Column-major: all rows of the first column, then of the second, and so on.
        rows.append(np.tile(panel_rows, own.size))
        cols.append(np.repeat(own, panel_rows.size))
        data.append(panel)
    entries = tuple(np.concatenate(part) for part in (data, rows, cols))
    size = columns[-1]
    return sparse.csc_matrix((entries[0], entries[1:]), shape=(size, size))


@pytest.fixture(scope="module")
def shared(contact3d, tmp_path_factory):
    """A run file whose factor is in a file beside it: a run file by itself has none of this size."""
    path = tmp_path_factory.mktemp("factor") / "run.h5"
    contact3d("run", SCENE, path, "--no-figures", "--linked", *changes("graded"))
    with open_run(path) as file:
        yield file


@pytest.fixture(scope="module")
def lower(shared):
    """L."""
    return cholesky_factor(shared["assemble/factor"])


@pytest.fixture(scope="module")
def permutation(shared):
    """Row i of P A P' is row permutation[i] of A."""
    return shared["assemble/factor/permutation"][:]


def test_factor_is_lower_triangular(lower, permutation):
    assert sparse.triu(lower, k=1).count_nonzero() == 0
    assert (lower.diagonal() > 0).all()
    assert np.array_equal(np.sort(permutation), np.arange(lower.shape[0]))


def test_factor_times_its_transpose_is_the_stiffness(shared, lower, permutation):
    permuted = RawProblem.read(shared).stiffness[permutation][:, permutation]
    # Backward stable: a row of L has a few hundred entries, each product one rounding.
    difference = abs(lower @ lower.T - permuted).max()
    assert difference <= 1e-12 * abs(permuted).max()


def test_dual_rhs(problem):
    expected = problem.coupling @ problem.solve_stiffness(problem.load)
    expected[: problem.n_panes] -= problem.gap * problem.pane_area
    # Two solves with one matrix of condition 1e4 to 1e5, each 1e-16 times that.
    error = np.linalg.norm(problem.dual_rhs - expected)
    assert error <= 1e-11 * np.linalg.norm(expected)


def test_dual_operator_from_the_stored_factor(shared, lower, permutation):
    problem = RawProblem.read(shared)
    half = spsolve_triangular(
        lower.tocsr(), problem.coupling.T.toarray()[permutation], lower=True
    )
    # S = W'W with W = L^-1 P B' by the stored factor, B A^-1 B' by scipy's; as above.
    difference = abs(half.T @ half - problem.dual_operator).max()
    assert difference <= 1e-11 * abs(problem.dual_operator).max()


def test_dual_operator_is_positive_definite(problem):
    """Condition (3.1) of HKL: B has full row rank."""
    # Far above the rounding of the largest eigenvalue, 1e-16 of it.
    assert problem.spectrum[0] > 1e-6 * problem.spectrum[-1]


def test_steplength(problem):
    """The steplength is 1.9 over an estimate of |S| at most about one per cent high."""
    estimate = 1.9 / problem.steplength
    # The estimate stops at a residual of 1 %; a little below |S| is possible as well.
    assert 0.99 <= estimate / problem.spectrum[-1] <= 1.011
    assert problem.steplength < 2.0 / problem.spectrum[-1]


def test_local_stiffness_is_bounded_by_that_of_single_nodes(problem):
    """These cases hold S implicitly: the stored stiffness bounds (S^-1)_ii from above.

    The displacement of one node of a pane is one of those among which (S^-1)_ii is the
    least energy. A pane of 2 x 2 cells has one node of its own, so the bound is coarse, but
    it knows no rigid motion: within two digits here.
    """
    exact = np.diag(np.linalg.inv(problem.dual_operator)).copy()
    m = problem.n_panes
    pairs = exact[m:].reshape(-1, 2)
    pairs[:] = pairs.mean(axis=1, keepdims=True)
    ratio = problem.local_stiffness / exact
    assert ratio.min() >= 1 - 1e-9  # rounding of the inverse
    assert ratio.max() < 100
