"""Verified solutions of the contact problem, found from given starts.

A semismooth Newton method, with residuals from the exact S, finds the zones; Newton's method on the
smooth equations of these zones, with residuals in double-double arithmetic, finds their solution; and
nothing counts as a solution before all conditions hold to `TOLERANCE`.
"""

from collections.abc import Iterator
from dataclasses import dataclass

import numpy as np

from ellipse import Projection, project
from trust.contact import Problem, Zone
from trust.double_double import DD

TOLERANCE = 1e-20
"""Of every condition, relative."""
SETTLED = 1e-9
"""Residual of the natural map below which zones are tried."""
MOST_STEPS = 40
MOST_HALVINGS = 12
MOST_CORRECTIONS = 40
SAME = 1e-12
"""Solutions that differ by less are one."""


@dataclass(frozen=True)
class Solution:
    """A verified solution."""

    multiplier: DD
    zones: np.ndarray
    violation: float


@dataclass(frozen=True)
class State:
    """The natural map lambda - P(lambda - rho r) at some multipliers."""

    residual: np.ndarray
    pressed: np.ndarray
    projection: Projection
    friction: np.ndarray
    friction_slope: np.ndarray | None
    bound: np.ndarray
    bound_slope: np.ndarray

    @property
    def norm(self) -> float:
        """Euclidean norm of the residual."""
        return float(np.linalg.norm(self.residual))

    @property
    def zones(self) -> np.ndarray:
        """Zones that the projection says."""
        held = np.where(self.projection.outside, Zone.SLIP, Zone.STICK)
        return np.where(self.pressed, held, Zone.OPEN)


def natural_map(problem: Problem, multiplier: np.ndarray, rho: np.ndarray) -> State:
    """Evaluate the natural map with the gradient to full double precision."""
    m = problem.m
    exact = DD.of(multiplier)
    trial = multiplier - rho * problem.gradient(exact).hi
    friction, slope = problem.friction(exact)
    pressure = np.maximum(trial[:m], 0.0)
    bound, bound_slope = problem.law.bound(DD.of(pressure))
    projection = project(trial[m:].reshape(m, 2), bound.hi[:, None] / friction.hi)
    image = np.concatenate([pressure, projection.point.ravel()])
    return State(
        multiplier - image,
        trial[:m] > 0.0,
        projection,
        friction.hi,
        slope,
        bound.hi,
        bound_slope,
    )


def jacobian(problem: Problem, state: State, rho: np.ndarray) -> np.ndarray:
    """A generalised derivative of the natural map."""
    m, n = problem.m, 3 * problem.m
    by_trial = np.eye(n) - rho[:, None] * problem.exact.operator.hi
    image = np.zeros((n, n))
    image[:m] = np.where(state.pressed[:, None], by_trial[:m], 0.0)
    bound = state.bound_slope[:, None] * image[:m]
    axes = bound[:, None, :] / state.friction[:, :, None]
    if state.friction_slope is not None:
        share = state.bound[:, None] / state.friction**2
        axes = axes - share[:, :, None] * state.friction_slope
    pairs = by_trial[m:].reshape(m, 2, n)
    moved = state.projection.by_trial @ pairs + state.projection.by_axes @ axes
    image[m:] = moved.reshape(2 * m, n)
    return np.eye(n) - image


def semismooth(
    problem: Problem, start: np.ndarray, rho: np.ndarray, most: int = MOST_STEPS
) -> tuple[np.ndarray, State]:
    """Newton's method with halving on the natural map; the last multipliers and state."""
    at, state = start, natural_map(problem, start, rho)
    best, idle = state.norm, 0
    for _ in range(most):
        size = np.linalg.norm(at)
        if state.norm <= 1e-13 * size or idle > 6 or not np.isfinite(state.norm):
            break
        step = direction(jacobian(problem, state, rho), state.residual)
        if step is None:
            break
        full = None
        for halving in range(MOST_HALVINGS):
            there = at + step * 0.5**halving
            trial = natural_map(problem, there, rho)
            full = full or (there, trial)
            if trial.norm < state.norm:
                full = (there, trial)
                break
        at, state = full
        idle = idle + 1 if state.norm > 0.9 * best else 0
        best = min(best, state.norm)
    return at, state


def direction(matrix: np.ndarray, residual: np.ndarray) -> np.ndarray | None:
    """The Newton step of a system whose rows are scaled alike; `None` if it has none."""
    scale = 1.0 / np.maximum(np.abs(matrix).max(axis=1), np.finfo(float).tiny)
    try:
        step = -np.linalg.solve(scale[:, None] * matrix, scale * residual)
    except np.linalg.LinAlgError:
        return None
    return step if np.isfinite(step).all() else None


def zone_equations(
    problem: Problem, at: DD, zones: np.ndarray
) -> tuple[DD, np.ndarray]:
    """Residuals of the smooth equations of given zones, and their derivatives.

    Displacements are multiplied by the local stiffness; conditions on slip have no unit of their own.
    """
    m, n = problem.m, 3 * problem.m
    s, k = problem.exact.operator.hi, problem.stiffness
    r = problem.gradient(at)
    friction, slope = problem.friction(at)
    residual = r * k
    matrix = k[:, None] * s
    for pane in np.flatnonzero(zones == Zone.OPEN):
        rows = [pane, m + 2 * pane, m + 2 * pane + 1]
        residual.hi[rows], residual.lo[rows] = at.hi[rows], at.lo[rows]
        matrix[rows] = np.eye(n)[rows]
    slides = np.flatnonzero(zones == Zone.SLIP)
    if slides.size:
        first = m + 2 * slides
        rows = np.stack([first, first + 1], axis=1)
        normal, pair, f = at[slides], at[rows], friction[slides]
        u = -(r * k)[rows]
        outer = f * f * pair
        g, g_slope = problem.law.bound(normal)
        on = (f * f * pair * pair).sum() - g * g
        turn = u[:, 0] * outer[:, 1] - u[:, 1] * outer[:, 0]
        identity = np.eye(n)
        u_by, pair_by = -matrix[rows], identity[rows]
        square = f.hi**2
        outer_by = square[:, :, None] * pair_by
        on_by = 2.0 * np.einsum("ik,ikj->ij", outer.hi, pair_by)
        on_by -= 2.0 * (g.hi * g_slope)[:, None] * identity[slides]
        if slope is not None:
            f_by = slope[slides]
            outer_by = outer_by + (2.0 * f.hi * pair.hi)[:, :, None] * f_by
            on_by = on_by + np.einsum("ik,ikj->ij", 2.0 * f.hi * pair.hi**2, f_by)
        turn_by = (
            u_by[:, 0] * outer.hi[:, 1:]
            + u.hi[:, :1] * outer_by[:, 1]
            - u_by[:, 1] * outer.hi[:, :1]
            - u.hi[:, 1:] * outer_by[:, 0]
        )
        for row, value, derivative in ((first, on, on_by), (first + 1, turn, turn_by)):
            residual.hi[row], residual.lo[row] = value.hi, value.lo
            matrix[row] = derivative
    return residual, matrix


def polish(problem: Problem, start: np.ndarray, zones: np.ndarray) -> DD | None:
    """Newton's method on the equations of some zones until corrections are rounding."""
    at = DD.of(np.where(open_components(zones), 0.0, start))
    before = np.inf
    for _ in range(MOST_CORRECTIONS):
        residual, matrix = zone_equations(problem, at, zones)
        step = direction(matrix, residual.hi)
        if step is None:
            return None
        at = at + step
        size = np.linalg.norm(at.hi)
        share = np.linalg.norm(step) / size if size > 0.0 else 0.0
        if share <= 1e-29 or (before <= 1e-24 and share > 0.1 * before):
            return at
        if not np.isfinite(share) or (share > 1e3 * before and share > 1.0):
            return None
        before = share
    return None


def open_components(zones: np.ndarray) -> np.ndarray:
    """Which multipliers vanish in given zones."""
    is_open = zones == Zone.OPEN
    return np.concatenate([is_open, np.repeat(is_open, 2)])


def corrected_zones(problem: Problem, at: DD) -> np.ndarray:
    """The zones that the natural map with local stiffness sees at some multipliers."""
    return natural_map(problem, at.hi, problem.stiffness).zones


def verified(problem: Problem, start: np.ndarray, zones: np.ndarray) -> Solution | None:
    """A solution near `start` whose zones are given, or follow from these in a few corrections."""
    for _ in range(6):
        at = polish(problem, start, zones)
        if at is None:
            return None
        violation = max(problem.violations(at, zones).values())
        if violation <= TOLERANCE:
            return Solution(at, zones, violation)
        start, seen = at.hi, corrected_zones(problem, at)
        if np.array_equal(seen, zones):
            return None
        zones = seen
    return None


def path(first: np.ndarray, last: np.ndarray, steps: int) -> Iterator[np.ndarray]:
    """Steplengths from some to others in geometric steps."""
    for k in range(steps + 1):
        yield first * (last / first) ** (k / steps)


def from_start(problem: Problem, start: np.ndarray) -> Solution | None:
    """The solution that Newton's method finds from some multipliers, at once or by a path."""
    at, state = semismooth(problem, start, problem.stiffness)
    return verified(problem, at, state.zones) or along_path(problem, start, 8)


def along_path(problem: Problem, start: np.ndarray, steps: int) -> Solution | None:
    """The solution at the end of a path from free to local stiffness."""
    at, state = start, None
    for rho in path(problem.own_stiffness, problem.stiffness, steps):
        at, state = semismooth(problem, at, rho)
    return verified(problem, at, state.zones)


class Reference:
    """All solutions of one problem that were found so far."""

    def __init__(self, problem: Problem) -> None:
        """Nothing is found yet."""
        self.problem = problem
        self.solutions: list[Solution] = []

    def add(self, solution: Solution | None) -> bool:
        """Keep a solution unless it is known; whether there is one."""
        if solution is None:
            return False
        if all(self.distance(solution.multiplier.hi, s) > SAME for s in self.solutions):
            self.solutions.append(solution)
        return True

    def search(self, starts: list[np.ndarray], near: float) -> None:
        """Look for solutions along paths from none, and from multipliers not near known ones."""
        nothing = np.zeros(3 * self.problem.m)
        for steps in (8, 24):
            if self.add(along_path(self.problem, nothing, steps)):
                break
        for start in starts:
            if self.error(start) > near:
                self.add(from_start(self.problem, start))

    def distance(self, multiplier: np.ndarray, solution: Solution) -> float:
        """The relative error of multipliers if a solution is the true one.

        Area-weighted; tangential errors relative to the larger of the tangential stresses and of
        the larger coefficient times the slip bound.
        """
        m, area = self.problem.m, self.problem.exact.area
        true = solution.multiplier
        strength = self.problem.law.bound(true[:m])[0].hi
        wrong = (true - multiplier).hi
        value, f = true.hi, self.problem.friction(true)[0].hi

        def size(normal: np.ndarray) -> float:
            return float(np.sqrt(np.sum(area * normal**2)))

        def pairs(vector: np.ndarray) -> float:
            return size(np.hypot(*vector[m:].reshape(m, 2).T))

        scales = size(value[:m]), max(pairs(value), size(strength / f.min(axis=1)))
        errors = size(wrong[:m]), pairs(wrong)
        if scales[0] == 0.0:
            return 0.0 if errors == (0.0, 0.0) else np.inf
        return max(e / s for e, s in zip(errors, scales, strict=True))

    def error(self, multiplier: np.ndarray) -> float:
        """The distance to the nearest solution; infinite if none is known."""
        return min(
            (self.distance(multiplier, s) for s in self.solutions), default=np.inf
        )
