"""The mapping Psi of HKL section 3: frozen problems, and the solutions as its fixed points."""

from collections.abc import Callable
from dataclasses import dataclass, replace

import numpy as np

from ._forms import Array, largest_eigenvalue
from ._law import FrictionLaw, slips_of
from ._norms import DisplacementNorm
from ._problem import Problem

#: Steps of Newton's method, halvings of one, and the residual over the multipliers below which a problem is solved.
NEWTON_STEPS = 60
HALVINGS = 30
SOLVED = 1e-11
#: Where Newton's method fails, attempts from elsewhere, and steps of projected gradients that lead there.
ATTEMPTS = 20
GRADIENT_STEPS = 200
#: An ellipse that is smaller than this share of the distance to it is a point.
NEGLIGIBLE = 1e-100


@dataclass(frozen=True)
class Frozen:
    """The friction of a frozen problem: slip bounds g, [m], and diagonals of the inverse coefficients (4.2), [m, 2]."""

    bound: Array
    inverse: Array


@dataclass(frozen=True)
class Mapping:
    """Psi takes slips phi and a pressure g to those of the problem whose friction they freeze.

    Multipliers are the roots of R = lambda - P(lambda - rho (S lambda - h)) with the projection P on half-lines and ellipses.

    :param dual: S, with the right-hand side h.
    :param steplengths: rho, the local stiffness of each multiplier, which makes R a stress.
    :param compliance: what a unit of each multiplier takes from (u_t1, u_t2) at the contact nodes, [2 n, 3 m].
    :param free: (u_t1, u_t2) there without contact, [2 n].
    """

    problem: Problem
    law: FrictionLaw
    dual: Array
    rhs: Array
    steplengths: Array
    compliance: Array
    free: Array

    @classmethod
    def of(cls, problem: Problem, energy: DisplacementNorm) -> "Mapping":
        """Psi of a solved problem; the Gram matrix of the face in the energy norm is its compliance."""
        run, rows = problem.run, np.arange(3 * len(problem.areas)).reshape(-1, 3)
        is_tangential = np.arange(len(energy.gram)) % 3 > 0
        compliance = energy.gram[is_tangential] @ np.kron(problem.integrals, np.eye(3)).T
        parts = [run[f"solve/local_stiffness_{part}"].values.ravel() for part in ("normal", "tangential")]
        steplengths, dual = np.concatenate(parts), run["assemble/dual_operator"].values.copy()
        # A multiplier along a held component moves nothing and is 0.
        held = np.flatnonzero(np.diag(dual) == 0)
        steplengths[held] = steplengths.max()
        dual[held, held] = 1 / steplengths.max()
        free = problem.selection @ energy.solve(problem.load)
        return cls(problem, FrictionLaw.of(problem.contact, run.scene), dual, run["load/dual_rhs"].values, steplengths,
                   compliance[:, np.concatenate([rows[:, 0], rows[:, 1:].ravel()])], free[is_tangential])

    def scaled(self, factor: float) -> "Mapping":
        """Psi of the law times a factor."""
        return replace(self, law=replace(self.law, scale=factor))

    def tangential(self, multiplier: Array) -> Array:
        """(u_t1, u_t2) at the contact nodes, [n, 2]."""
        return (self.free - self.compliance @ multiplier).reshape(-1, 2)

    def state(self, multiplier: Array) -> tuple[Array, Array]:
        """The point (phi, lambda_nu) of Y^h x Y^h x L^H, [n, 2] and [m]."""
        return slips_of(self.tangential(multiplier))[0], multiplier[: len(self.problem.areas)]

    def frozen(self, multiplier: Array) -> Frozen:
        """The friction that the state of a multiplier freezes."""
        slip, pressure = self.state(multiplier)
        coefficients = self.law.at(self.problem.face.points, slip)[0]
        return Frozen(self.law.bound(pressure)[0], self.problem.integrals @ (1 / coefficients) / self.problem.areas[:, None])

    def derivatives(self, multiplier: Array) -> tuple[Array, Array, Array]:
        """d phi / d lambda, [2 n, 3 m], the derivative of the inverse coefficients by phi, [2 m, 2 n], and dg / dlambda_nu, [m]."""
        average = self.problem.integrals / self.problem.areas[:, None]
        slip, slopes = slips_of(self.tangential(multiplier))
        coefficients, by_slip = self.law.at(self.problem.face.points, slip)
        inverse_by_slip = np.zeros((2 * len(average), slip.size))
        for k, l in np.ndindex(2, 2):
            inverse_by_slip[k::2, l::2] = -average * (by_slip[:, k, l] / coefficients[:, k] ** 2)
        return -(slopes @ self.compliance), inverse_by_slip, self.law.bound(multiplier[: len(average)])[1]

    def residual(self, multiplier: Array, frozen: Frozen, share: float = 1.0) -> tuple[Array, Array, Array]:
        """R for a share of the steplengths, dR / dlambda, and -dR by g of the panes, then by their pairs of inverse coefficients."""
        m, steplengths = len(frozen.bound), share * self.steplengths
        trial = multiplier - steplengths * (self.dual @ multiplier - self.rhs)
        pairs, bound = trial[m:].reshape(-1, 2), frozen.bound[:, None]
        nearest, by_trial, by_axes = nearest_in_ellipses(pairs, bound / frozen.inverse)
        # An ellipse that begins to grow from a point is reached first furthest along the trial stress.
        scaled = pairs / frozen.inverse
        furthest = scaled / frozen.inverse / np.maximum(np.hypot(*scaled.T), np.finfo(float).tiny)[:, None]
        by_bound = np.where(bound == 0, furthest, np.einsum("prk,pk->pr", by_axes, 1 / frozen.inverse))
        by_inverse = -by_axes * (bound / frozen.inverse**2)[:, None]
        projection, by_frozen, panes = np.zeros((3 * m, 3 * m)), np.zeros((3 * m, 3 * m)), np.arange(m)
        projection[panes, panes] = trial[:m] > 0
        for r in range(2):
            by_frozen[m + 2 * panes + r, panes] = by_bound[:, r]
            for k in range(2):
                place = m + 2 * panes + r, m + 2 * panes + k
                projection[place], by_frozen[place] = by_trial[:, r, k], by_inverse[:, r, k]
        by_multiplier = np.eye(3 * m) - projection @ (np.eye(3 * m) - steplengths[:, None] * self.dual)
        return multiplier - np.concatenate([np.maximum(trial[:m], 0.0), nearest.ravel()]), by_multiplier, by_frozen

    def __call__(self, frozen: Frozen, near: Array) -> Array | None:
        """The multipliers of a frozen problem, a strictly convex minimisation, from some nearby; None where they are not found."""
        share = None
        for _ in range(ATTEMPTS):
            found = newton(lambda multiplier: self.residual(multiplier, frozen)[:2], near)
            if found is not None:
                return found
            metric = np.sqrt(self.steplengths)
            share = share or 1 / largest_eigenvalue(metric[:, None] * self.dual * metric)
            for _ in range(GRADIENT_STEPS):
                near = near - self.residual(near, frozen, share)[0]
        return None

    def without_friction(self) -> Array | None:
        """The multipliers of phi = 0, g = 0."""
        m = len(self.problem.areas)
        return self(Frozen(np.zeros(m), np.ones((m, 2))), np.zeros(3 * m))

    def solution(self, near: Array) -> Array | None:
        """A fixed point of Psi by Newton's method; where that fails, it begins again after a step of successive approximations."""

        def followed(multiplier: Array) -> tuple[Array, Array]:
            value, slope, by_frozen = self.residual(multiplier, self.frozen(multiplier))
            slips, inverse_by_slip, bound = self.derivatives(multiplier)
            slope[:, : len(bound)] -= by_frozen[:, : len(bound)] * bound
            return value, slope - by_frozen[:, len(bound) :] @ (inverse_by_slip @ slips)

        start: Array | None = near
        for _ in range(ATTEMPTS):
            if start is None or (found := newton(followed, start)) is not None:
                return None if start is None else found
            start = self(self.frozen(start), start)
        return None


def newton(evaluate: Callable[[Array], tuple[Array, Array]], start: Array) -> Array | None:
    """Newton's method with halved steps to a root of lambda - P(lambda); None where it stops before one."""
    point, (value, slope) = start, evaluate(start)
    for _ in range(NEWTON_STEPS):
        is_solved = np.linalg.norm(value) <= SOLVED * np.linalg.norm(point)
        try:
            step = np.linalg.solve(slope, -value)
        except np.linalg.LinAlgError:
            break
        # A root is polished by whole steps, until rounding stops them.
        for k in range(1 if is_solved else HALVINGS):
            moved = point + 0.5**k * step
            next_value, next_slope = evaluate(moved)
            if np.linalg.norm(next_value) < np.linalg.norm(value):
                break
        else:
            break
        point, value, slope = moved, next_value, next_slope
    # The projection: open panes have no stress at all.
    return point - value if np.linalg.norm(value) <= SOLVED * np.linalg.norm(point) else None


def nearest_in_ellipses(points: Array, axes: Array) -> tuple[Array, Array, Array]:
    """The nearest points of ellipses with semi-axes a, [n, 2], their derivatives by points, [n, 2, 2], and by semi-axes.

    Outside it is p_i = x_i a_i^2 / (t + a_i^2) with the t > 0 for which q_i = a_i x_i / (t + a_i^2) has length 1. 1 / |q| is
    concave and increases with t, so Newton's method comes nearer from below at every step.
    """
    is_point = axes.max(axis=1) <= NEGLIGIBLE * np.hypot(*points.T)
    axes = np.where(is_point[:, None], 1.0, axes)
    scale = axes.max(axis=1, keepdims=True)
    x, a = points / scale, axes / scale
    # A lower bound of t, from |q_i| <= 1.
    t = np.max(a * (np.abs(x) - a), axis=1, keepdims=True).clip(min=0.0)
    while True:
        q = a * x / (t + a**2)
        length = np.hypot(q[:, :1], q[:, 1:])
        slope = np.sum(q**2 / (t + a**2), axis=1, keepdims=True)
        step = np.divide((length - 1) * length**2, slope, out=np.zeros_like(t), where=length > 1)
        if (step <= np.finfo(float).eps * t).all():
            break
        t = t + step
    is_outside = t > 0
    share = np.where(is_outside, a**2 / (t + a**2), 1.0)
    # From |q| = 1: dt by x_i and a_i; by t alone p_i moves by -p_i / (t + a_i^2).
    slope = np.where(is_outside, slope, np.inf)
    t_by_point, t_by_axis = q * a / (t + a**2) / slope, q * x * (t - a**2) / (t + a**2) ** 2 / slope
    by_t, own = -share * x / (t + a**2), 2 * q * t / (t + a**2)
    by_point = by_t[:, :, None] * t_by_point[:, None] + share[:, :, None] * np.eye(2)
    by_axis = by_t[:, :, None] * t_by_axis[:, None] + own[:, :, None] * np.eye(2)
    kept = ~is_point[:, None]
    return scale * share * x * kept, by_point * kept[:, None], by_axis * kept[:, None]
