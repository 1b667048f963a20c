"""The inner problem of Algorithm 4.1 as a conic program for Clarabel."""

import clarabel
import numpy as np
from scipy import sparse
from scipy.optimize import root

from raw_problem import RawProblem


def solve_inner(
    problem: RawProblem, slip_bound: np.ndarray, friction_inverse: np.ndarray
) -> np.ndarray:
    """The minimiser of x'Sx/2 - x'h over x_nu >= 0, |F^-1 x_t| <= g on every pane.

    Solved in the unit of the largest stored multiplier, so that numbers are near 1.
    Panes with g = 0 have no interior; there x_t = 0 is an equation.
    """
    m = problem.n_panes
    unit = np.abs(problem.multiplier).max()
    scale = 1 / np.linalg.norm(problem.dual_rhs)
    slack, bound = [-np.eye(m, 3 * m)], [np.zeros(m)]
    cones = [clarabel.NonnegativeConeT(m)]
    for pane in range(m):
        rows = np.zeros((2, 3 * m))
        rows[[0, 1], [m + 2 * pane, m + 2 * pane + 1]] = -friction_inverse[pane]
        if slip_bound[pane] > 0:
            slack.append(np.vstack([np.zeros(3 * m), rows]))
            bound.append(np.array([slip_bound[pane] / unit, 0, 0]))
            cones.append(clarabel.SecondOrderConeT(3))
        else:
            slack.append(rows)
            bound.append(np.zeros(2))
            cones.append(clarabel.ZeroConeT(2))
    settings = clarabel.DefaultSettings()
    settings.verbose = False
    settings.tol_gap_abs = settings.tol_gap_rel = settings.tol_feas = 1e-13
    solution = clarabel.DefaultSolver(
        sparse.csc_matrix(np.triu(problem.dual_operator) * unit * scale),
        -problem.dual_rhs * scale,
        sparse.csc_matrix(np.vstack(slack)),
        np.concatenate(bound),
        cones,
        settings,
    ).solve()
    solved = {clarabel.SolverStatus.Solved, clarabel.SolverStatus.AlmostSolved}
    assert solution.status in solved, solution.status
    point = unit * np.array(solution.x)
    return polished(problem, point, slip_bound, friction_inverse)


def polished(
    problem: RawProblem,
    point: np.ndarray,
    slip_bound: np.ndarray,
    friction_inverse: np.ndarray,
) -> np.ndarray:
    """The root of x - P(x - a (S x - h)) near a point, by MINPACK's hybrid method.

    An interior point stops at a gap, and the square root of a gap is no small distance:
    Clarabel can stop at 1e-4 of the multipliers from the minimiser. The root is the same
    minimiser by another characterisation; the better of the two points is returned.
    """
    unit = np.abs(problem.multiplier).max()

    def residual(x: np.ndarray) -> np.ndarray:
        r = problem.dual_operator @ (unit * x) - problem.dual_rhs
        step = unit * x - problem.steplength * r
        return x - problem.project(step, slip_bound, friction_inverse) / unit

    start = point / unit
    found = root(residual, start, method="hybr", tol=1e-14).x
    return unit * min(start, found, key=lambda x: np.linalg.norm(residual(x)))
