"""The last inner problem, and the whole fixed-point loop, solved again by Clarabel."""

import numpy as np

from quadratic_program import solve_inner
from run_file import open_run


def distance_bound(problem, x, slip_bound, friction_inverse) -> float:
    """An upper bound of the distance of x to the minimiser.

    With the reduced gradient g = (x - P(x - a (S x - h)))/a of a convex quadratic:
    |x - x*| <= (1 + a |S|) |g| / smallest eigenvalue of S, as S is strongly monotone.
    """
    a = problem.steplength
    r = problem.dual_operator @ x - problem.dual_rhs
    nearest = problem.project(x - a * r, slip_bound, friction_inverse)
    smallest, largest = problem.spectrum[[0, -1]]
    return (1 + a * largest) * np.linalg.norm(x - nearest) / a / smallest


def inner_error(run, problem) -> float:
    """The distance to the minimiser that the last inner tolerance allows."""
    tolerance = run["solve/history/inner_tolerance"][-1]
    smallest, largest = problem.spectrum[[0, -1]]
    reduced = tolerance * np.linalg.norm(problem.dual_rhs)
    return (1 + problem.steplength * largest) * reduced / smallest


def test_last_inner_problem(run, problem):
    """Within the error that the inner tolerance allows, plus that of our own solver."""
    frozen = run["solve/slip_bound"][:], run["solve/friction_inverse"][:]
    expected = solve_inner(problem, *frozen)
    size = np.linalg.norm(expected)
    own = distance_bound(problem, expected, *frozen)
    assert own <= 1e-11 * size
    allowed = inner_error(run, problem) + own
    assert np.linalg.norm(problem.multiplier - expected) <= allowed
    # The allowance itself means something: a small part of the multipliers.
    assert allowed <= 0.1 * size


def successive_approximations(problem, epsilon: float) -> tuple[np.ndarray, list]:
    """Algorithm 4.1 of HKL with exact inner problems from phi = 0, g = 0: x, changes."""
    multiplier = np.zeros(3 * problem.n_panes)
    slip = np.zeros((problem.contact_nodes.size, 2))
    changes = [np.inf]
    while changes[-1] > epsilon and len(changes) < 100:
        previous = multiplier
        slip_bound = problem.slip_bound(np.maximum(previous[: problem.n_panes], 0))
        inverse = problem.friction_inverse(problem.nodal_friction(slip))
        multiplier = solve_inner(problem, slip_bound, inverse)
        slip = problem.slip(problem.displacement_of(multiplier))
        change = np.linalg.norm(multiplier - previous) / np.linalg.norm(multiplier)
        changes.append(float(change))
    assert changes[-1] <= epsilon
    return multiplier, changes[1:]


def test_whole_loop(tight, tight_path):
    """The published scene at n_div = 4, from zero to a change of 1e-8."""
    epsilon = 1e-8
    expected, changes = successive_approximations(tight, epsilon)
    # Exact inner problems contract by a steady factor q once the zones are settled.
    factor = changes[-1] / changes[-2]
    assert factor < 0.2
    size = np.linalg.norm(expected)
    with open_run(tight_path) as file:
        inner = inner_error(file, tight)
    # x is within (e + q epsilon)/(1 - q) of the fixed point if its last change is
    # epsilon and its last inner problem has the error e; ours has e = 0.
    allowed = (inner + 2 * factor * epsilon * size) / (1 - factor)
    assert np.linalg.norm(tight.multiplier - expected) <= allowed
    assert allowed <= 1e-5 * size
