"""The referee's arithmetic and equations, against Python's fractions and by differences."""

import random
from fractions import Fraction

import numpy as np
import pytest
from scipy import sparse

from ellipse import project
from raw_problem import nearest_in_ellipses
from trust.double_double import DD, two_product, two_sum
from trust.exact import Unsettled, applied_inverse
from trust.law import Law
from trust.sliced import LongSum, SlicedMatrix

ROUNDING = Fraction(1, 2**100)


def wide(dice: random.Random) -> float:
    """A number of either sign between 1e-9 and 1e9."""
    return dice.choice((-1, 1)) * 10.0 ** dice.uniform(-9.0, 9.0)


def long_number(dice: random.Random) -> DD:
    """A double-double number with all its bits in use."""
    high = wide(dice)
    return DD.of(high) + high * dice.uniform(-1.0, 1.0) * 2.0**-54


@pytest.mark.parametrize("seed", range(40))
def test_operations_agree_with_fractions(seed):
    dice = random.Random(seed)
    a, b = long_number(dice), long_number(dice)
    x, y = a.fraction(), b.fraction()
    assert a.lo != 0.0 and b.lo != 0.0
    for found, true in ((a * b, x * y), (a / b, x / y), (a * a, x * x)):
        assert abs(found.fraction() - true) <= ROUNDING * abs(true)
    for found, true in ((a + b, x + y), (a - b, x - y), (a - (a + b), -y)):
        assert abs(found.fraction() - true) <= ROUNDING * (abs(x) + abs(y))
    root = abs(a.absolute().sqrt().fraction() ** 2 - abs(x))
    assert root <= ROUNDING * abs(x)
    assert a.absolute().fraction() == abs(x)


@pytest.mark.parametrize("seed", range(20))
def test_sums_and_products_lose_nothing(seed):
    dice = random.Random(seed)
    a, b = wide(dice), wide(dice)
    for (total, error), true in (
        (two_sum(a, b), Fraction(a) + Fraction(b)),
        (two_product(a, b), Fraction(a) * Fraction(b)),
    ):
        assert Fraction(total) + Fraction(error) == true
        assert abs(error) <= abs(total) * 2.0**-52


def test_sums_survive_cancellation():
    values = [1e20, 1.0, -1e20, 1e-20, -1.0]
    total = DD.of(np.array(values)).sum()
    # 2^-104 of the sum of magnitudes 2e20; sums of doubles are off by 1.
    assert abs(total.fraction() - Fraction(1e-20)) < 1e-11
    exact = LongSum(1)
    for value in values:
        exact.add(np.array([value]))
    assert exact.value()[0].fraction() == Fraction(1e-20)


def test_matrix_times_vector_agrees_with_fractions():
    dice = random.Random(7)
    matrix = np.array([[wide(dice) for _ in range(13)] for _ in range(5)])
    vector = np.array([wide(dice) for _ in range(13)])
    found = DD.of(matrix) @ vector
    for i in range(5):
        terms = [
            Fraction(m) * Fraction(v) for m, v in zip(matrix[i], vector, strict=True)
        ]
        assert abs(found[i].fraction() - sum(terms)) <= ROUNDING * sum(map(abs, terms))


def test_sliced_products_are_exact():
    dice = random.Random(3)
    matrix = sparse.csr_matrix([[wide(dice) for _ in range(9)] for _ in range(6)])
    factor = np.array([[wide(dice) for _ in range(4)] for _ in range(9)])
    total = LongSum(6, 4)
    SlicedMatrix.of(matrix).add_product(total, factor, drop=240)
    found = total.value()
    for i in range(6):
        for j in range(4):
            row = matrix[i].toarray().ravel()
            terms = [
                Fraction(m) * Fraction(f)
                for m, f in zip(row, factor[:, j], strict=True)
            ]
            error = abs(found[i, j].fraction() - sum(terms))
            assert error <= ROUNDING * abs(sum(terms)) + Fraction(1, 2**170)


def exact_solution(
    matrix: list[list[Fraction]], right: list[Fraction]
) -> list[Fraction]:
    """Gauss' elimination without rounding."""
    rows = [[*row, value] for row, value in zip(matrix, right, strict=True)]
    n = len(rows)
    for k in range(n):
        for i in range(n):
            if i != k:
                share = rows[i][k] / rows[k][k]
                rows[i] = [a - share * b for a, b in zip(rows[i], rows[k], strict=True)]
    return [rows[i][n] / rows[i][i] for i in range(n)]


def test_refinement_solves_what_is_nearly_singular():
    n = 8
    hilbert = np.array([[1.0 / (i + j + 1) for j in range(n)] for i in range(n)])
    assert np.linalg.cond(hilbert) > 1e10
    right = np.linspace(1.0, 2.0, n)[:, None]
    identity = sparse.csr_matrix(np.eye(n))
    found = applied_inverse(sparse.csc_matrix(hilbert), right, identity)
    matrix = [[Fraction(v) for v in row] for row in hilbert]
    true = exact_solution(matrix, [Fraction(v) for v in right[:, 0]])
    for i in range(n):
        assert abs(found[i, 0].fraction() - true[i]) <= Fraction(1, 10**29) * abs(
            true[i]
        )


def test_what_is_singular_is_said():
    n = 14
    hilbert = np.array([[1.0 / (i + j + 1) for j in range(n)] for i in range(n)])
    identity = sparse.csr_matrix(np.eye(n))
    with pytest.raises(Unsettled):
        applied_inverse(sparse.csc_matrix(hilbert), np.ones((n, 1)), identity)


def test_projection_and_its_derivatives():
    random_numbers = np.random.default_rng(5)
    trial = random_numbers.normal(size=(60, 2)) * 2.0
    axes = 10.0 ** random_numbers.uniform(-1.5, 0.5, size=(60, 2))
    axes[0] = 0.0
    axes[1] = 0.0, 0.5
    found = project(trial, axes)
    assert np.abs(found.point - nearest_in_ellipses(trial, axes)).max() <= 1e-13
    assert 10 < found.outside.sum() < 60
    step = 1e-6
    for k in range(2):
        shift = step * np.eye(2)[k]
        by_trial = (
            project(trial + shift, axes).point - project(trial - shift, axes).point
        )
        assert np.abs(by_trial / (2 * step) - found.by_trial[:, :, k]).max() <= 1e-7
        wide_axes = axes[2:], trial[2:]
        by_axes = project(wide_axes[1], wide_axes[0] + shift).point
        by_axes = by_axes - project(wide_axes[1], wide_axes[0] - shift).point
        assert np.abs(by_axes / (2 * step) - found.by_axes[2:, :, k]).max() <= 1e-7


@pytest.mark.parametrize("isotropic", [True, False])
def test_ramps_and_their_derivatives(isotropic):
    ramp = {"initial": 0.3, "residual": 0.2, "onset": 0.25, "rate": 0.1}
    other = {"initial": 0.2, "residual": 0.5, "onset": 0.0, "rate": 0.3}
    names = {"coefficient": {"ramp": ramp}}
    if not isotropic:
        names = {"coefficient_1": {"ramp": ramp}, "coefficient_2": {"ramp": other}}
    law = Law.of({"friction": names})
    u = np.random.default_rng(2).uniform(-2.0, 2.0, size=(50, 2))
    value, slope = law.inverse(DD.of(u))
    slip = np.hypot(*u.T) if isotropic else np.abs(u[:, 0])
    expected = 0.3 - 0.1 * np.clip(slip - 0.25, 0.0, 1.0)
    assert np.abs(value.hi[:, 0] - 1.0 / expected).max() <= 1e-14
    assert len(np.unique(value.hi[:, 0].round(9))) > 15
    for k in range(2):
        shift = 1e-7 * np.eye(2)[k]
        difference = law.inverse(DD.of(u + shift))[0] - law.inverse(DD.of(u - shift))[0]
        assert np.abs(difference.hi / 2e-7 - slope[:, :, k]).max() <= 1e-6
