"""What Psi really does: its derivative at solutions, the rate of successive approximations, laws times a factor."""

import math
from collections.abc import Callable, Sequence

import numpy as np

from ._forms import Array, factor, largest_eigenvalue, root
from ._mapping import Mapping
from ._norms import DisplacementNorm
from ._results import Contraction, NormConstants, ScaledSolution

#: Factors of the law: decades, steps in each, and the least decade that is tried while Psi' is not small.
DECADES = (-2, 6)
PER_DECADE = 4
LEAST_DECADE = -12
#: Halvings of a step between factors: 10^(1/4) to the power 2^-12 is 1.00014.
SCALE_HALVINGS = 12
#: Size of the disturbance whose growth is observed, of which rounding is 1e-5; kinks of steep laws are not far away.
DISTURBANCE = 1e-8
#: Applications of Psi to it: mirror-image panes make pairs of eigenvalues a few per cent apart, of which the smaller one shows for
#: a hundred. A disturbance that shrinks faster than VANISHED in one leaves only rounding.
RATE_STEPS = 300
VANISHED = 1e-4
#: Steps of successive approximations from zero, and the change at which they end.
APPROXIMATIONS = 200
CONVERGED = 1e-11


def contraction(mapping: Mapping, norms: Sequence[DisplacementNorm], multiplier: Array) -> Contraction | None:
    """Psi' at a solution, one-sided at kinks; None where the derivative of the frozen problem is singular.

    Psi' = O Z D: D takes (phi, g) to the friction that they freeze, Z this to lambda, O that to (phi, lambda_nu).
    """
    face, m = mapping.problem.face, len(mapping.problem.areas)
    slips, inverse_by_slip, bound = mapping.derivatives(multiplier)
    _, by_multiplier, by_frozen = mapping.residual(multiplier, mapping.frozen(multiplier))
    try:
        response = np.linalg.solve(by_multiplier, by_frozen)
    except np.linalg.LinAlgError:
        return None
    if not np.isfinite(response).all():
        return None
    # The rows of open panes are those of the identity, but for what elimination rounds.
    response[:m][(by_multiplier[:m] == np.eye(m, 3 * m)).all(axis=1)] = 0.0
    by_pressure, by_inverse = response[:, :m] * bound, response[:, m:]
    # The eigenvalues of O Z D other than zero are those of D O Z.
    moved = inverse_by_slip @ slips
    cycle = np.block([[by_pressure[:m], by_inverse[:m]], [moved @ by_pressure, moved @ by_inverse]])
    radius = float(np.abs(np.linalg.eigvals(cycle)).max(initial=0.0))
    parts = [inverse_by_slip[:, k::2][:, face.free] for k in range(2)]
    solve_mass = factor(face.mass)
    by_slip_ball = by_inverse @ root(sum(part @ solve_mass(part.T.copy()) for part in parts))

    def weighted(norm: DisplacementNorm) -> float:
        """The least bound of |Psi'| in w |phi| + |mu| over all weights w: the largest eigenvalue of the norms of its parts."""
        sizes = np.empty((2, 2))
        pressure_ball = np.linalg.inv(np.linalg.cholesky(norm.glued)).T
        for column, images in enumerate((by_slip_ball, by_pressure @ pressure_ball)):
            phi = (slips @ images).reshape(len(face.points), 2, images.shape[1])[face.free]
            forms = sum(phi[:, k].T @ (face.mass @ phi[:, k]) for k in range(2)), images[:m].T @ norm.glued @ images[:m]
            sizes[:, column] = [math.sqrt(max(largest_eigenvalue(form), 0.0)) for form in forms]
        half = (sizes[0, 0] - sizes[1, 1]) / 2
        return sizes.trace() / 2 + math.hypot(half, math.sqrt(sizes[0, 1] * sizes[1, 0]))

    return Contraction(radius, int(np.linalg.slogdet(np.eye(3 * m) - cycle)[0]), tuple(weighted(norm) for norm in norms))


class ScaledLaws:
    """Solutions for the law times 10^-2 to 10^6, each from the one before, with Psi' there."""

    def __init__(self, mapping: Mapping, norms: Sequence[DisplacementNorm]):
        self._mapping, self._norms = mapping, norms
        self.points: list[ScaledSolution] = []
        near = None
        for k in range(DECADES[0] * PER_DECADE, DECADES[1] * PER_DECADE + 1):
            point, near = self._at(10 ** (k / PER_DECADE), near)
            self.points.append(point)
        decade = DECADES[0]
        while self.points[0].contraction and max(self.points[0].contraction.norms) > 1 and decade > LEAST_DECADE:
            decade -= 1
            self.points.insert(0, self._at(10.0**decade, None)[0])

    def _at(self, scale: float, near: Array | None) -> tuple[ScaledSolution, Array | None]:
        """The solution for a factor, and its multipliers; those nearby where none is found."""
        mapping = self._mapping.scaled(scale)
        start = mapping.without_friction() if near is None else near
        found = None if start is None else mapping.solution(start)
        local = None if found is None else contraction(mapping, self._norms, found)
        return ScaledSolution(scale, local), near if local is None else found

    def first(self, is_beyond: Callable[[Contraction], bool]) -> float | None:
        """The least factor at which a measure, small for small factors, turns true, to four digits; None where none is found."""
        solved = [point for point in self.points if point.contraction]
        place = next((k for k, point in enumerate(solved) if is_beyond(point.contraction)), None)
        if not place:
            return None if place is None else solved[0].scale
        low, high = solved[place - 1].scale, solved[place].scale
        near = self._at(low, None)[1]
        for _ in range(SCALE_HALVINGS):
            middle = math.sqrt(low * high)
            point, moved = self._at(middle, near)
            if point.contraction and is_beyond(point.contraction):
                high = middle
            else:
                low, near = middle, moved
        return math.sqrt(low * high)


def observed_rate(mapping: Mapping, solution: Array) -> float | None:
    """The geometric mean of the factors by which a random disturbance shrinks in the last half of many applications of Psi; None
    without contact stresses, and where a frozen problem is not solved."""
    size = DISTURBANCE * np.linalg.norm(solution)
    if size == 0:
        return None
    direction = solution * np.random.default_rng(1).uniform(-1, 1, len(solution))
    factors = np.empty(RATE_STEPS)
    for step in range(RATE_STEPS):
        image = mapping(mapping.frozen(solution + size * direction / np.linalg.norm(direction)), solution)
        if image is None:
            return None
        direction = image - solution
        factors[step] = np.linalg.norm(direction) / size
        if factors[step] < VANISHED:
            return float(factors[step])
    return float(np.exp(np.log(factors[RATE_STEPS // 2 :]).mean()))


def from_zero(mapping: Mapping, energy: DisplacementNorm, constants: NormConstants) -> tuple[int | None, tuple[float, float]]:
    """Steps of Algorithm 4.1 with exact inner problems from phi = 0, g = 0 to a change of 1e-11, None where 200 do not suffice,
    and the largest |phi| / R_1 and |lambda_nu|_* / R_2 on the way: Lemma 3.3 says at most 1."""
    face, last, lemma = mapping.problem.face, np.zeros(len(mapping.rhs)), np.zeros(2)
    found = mapping.without_friction()
    for step in range(1, APPROXIMATIONS + 1):
        if found is None:
            break
        slip, pressure = mapping.state(found)
        squares = np.sum(slip[face.free] * (face.mass @ slip[face.free])), pressure @ energy.glued @ pressure
        lemma = np.maximum(lemma, np.sqrt(squares) / [constants.radius_slip, constants.radius_pressure])
        if np.linalg.norm(found - last) <= CONVERGED * np.linalg.norm(found):
            return step, (float(lemma[0]), float(lemma[1]))
        last, found = found, mapping(mapping.frozen(found), found)
    return None, (float(lemma[0]), float(lemma[1]))


def friction_functional(mapping: Mapping, multiplier: Array) -> tuple[float, float] | None:
    """The program's friction functional, the sum of g |R| |F mean(u_t)| over panes, over HKL's j, less 1; and the largest
    |F^-1 lambda_t| / g - 1 at points of pressed panes, where the program bounds means (4.2). None for nodal multipliers."""
    problem, frozen = mapping.problem, mapping.frozen(multiplier)
    if problem.panes is None:
        return None
    values, weights = problem.face.quadrature
    tangential, (slip, pressure) = mapping.tangential(multiplier), mapping.state(multiplier)
    pane = problem.panes.repeat(len(weights) // len(problem.panes))
    coefficients, bound = mapping.law.at(values @ problem.face.points, values @ slip)[0], frozen.bound[pane]
    exact = np.sum(weights * bound * np.linalg.norm(coefficients * (values @ tangential), axis=1))
    means = problem.integrals @ tangential
    averaged = np.sum(frozen.bound * np.linalg.norm(means / frozen.inverse, axis=1))
    stresses = np.linalg.norm(multiplier[len(pressure) :].reshape(-1, 2)[pane] / coefficients, axis=1)
    excess = np.max(stresses[bound > 0] / bound[bound > 0] - 1, initial=-math.inf)
    return float(averaged / exact - 1) if exact else 0.0, float(excess)
