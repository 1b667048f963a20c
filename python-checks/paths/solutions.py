"""All solutions of contact problems of a few nodes, by Newton's method from a dense grid of slips.

S is ordered as (normal of every node, then the tangential pairs). Every node is open, sticks or slips.
The slips u of slipping nodes are the unknowns beside their pressures: the stress of a slip is
p F(u)^2 u / |F(u) u|, so nothing of the program's own equations (angles, half circles, boxes) is used.
"""

import itertools
from collections.abc import Callable
from dataclasses import dataclass

import numpy as np

Law = Callable[[np.ndarray], np.ndarray]
"""F_1 and F_2, `[..., 2]`, of slips `[..., 2]`."""

SOLVED = 1e-11
"""Residual without unit at which Newton's method has converged: rounding of systems of condition 1e3."""
SAME = 1e-6
"""Solutions nearer than this share of the largest stress are one."""
SLACK = 1e-9
"""Inequalities hold to this share of their size."""


MOST_STARTS = 800
MOST_STEPS = 30


@dataclass(frozen=True)
class Problem:
    """S in m^3/Pa, h in m^3, the areas of nodes in m^2 and the law."""

    operator: np.ndarray
    rhs: np.ndarray
    area: np.ndarray
    law: Law
    grid: tuple[int, int]
    """Directions and sizes of slip from which each node starts."""


def components(nodes, m: int) -> np.ndarray:
    """The places of (normal, t1, t2) of nodes, one after the other."""
    return np.array([[i, m + 2 * i, m + 2 * i + 1] for i in nodes], int).ravel()


def stresses(problem: Problem, x: np.ndarray) -> np.ndarray:
    """(p, lambda_t) of slipping nodes from (p, u), `[..., k, 3]`."""
    pressure, slip = x[..., :1], x[..., 1:]
    friction = problem.law(slip)
    size = np.linalg.norm(friction * slip, axis=-1, keepdims=True)
    size = np.maximum(size, 1e-300)
    return np.concatenate([pressure, pressure * friction**2 * slip / size], axis=-1)


def slipping(problem: Problem, S, h, area) -> np.ndarray:
    """All zeros of the equations of k slipping nodes, `[:, k, 3]`, whatever their signs."""
    k = len(area)
    glued = np.linalg.solve(S, h)
    stress = np.abs(glued).max()
    way = (np.abs(h.reshape(k, 3)[:, 1:]) / area[:, None]).max()
    scale = np.tile([stress, way, way], (k, 1))
    rows = np.abs(S) @ np.full(3 * k, stress)

    def residual(x):
        carried = stresses(problem, x * scale).reshape(*x.shape[:-2], 3 * k)
        r = carried @ S - h
        r = r.reshape(*x.shape[:-2], k, 3)
        r[..., 1:] += area[:, None] * (x * scale)[..., 1:]
        return r.reshape(*x.shape[:-2], 3 * k) / rows

    x = starts(problem, k)
    for _ in range(MOST_STEPS):
        value = residual(x)
        step = 1e-7
        columns = []
        for j in range(3 * k):
            moved = np.zeros((k, 3))
            moved.flat[j] = step
            columns.append((residual(x + moved) - residual(x - moved)) / (2 * step))
        matrix = np.stack(columns, axis=-1) + 1e-14 * np.eye(3 * k)
        try:
            change = np.linalg.solve(matrix, value[..., None])[..., 0]
        except np.linalg.LinAlgError:
            matrix = matrix + 1e-9 * np.eye(3 * k)
            change = np.linalg.solve(matrix, value[..., None])[..., 0]
        size = np.abs(change).max(axis=-1, keepdims=True)
        change *= np.minimum(1, 0.5 / np.maximum(size, 1e-300))
        x = x - change.reshape(x.shape)
        fine = np.isfinite(x).all(axis=(1, 2)) & (np.abs(x).max(axis=(1, 2)) < 1e6)
        x = x[fine]
        if len(x) == 0:
            break
    if len(x) == 0:
        return np.zeros((0, k, 3))
    x = x[np.abs(residual(x)).max(axis=-1) < SOLVED]
    return x * scale


def starts(problem: Problem, k: int) -> np.ndarray:
    """Slips on a grid of directions and sizes, or at random places of it where there are too many."""
    directions, sizes = problem.grid
    angle = 2 * np.pi * (np.arange(directions) + 0.37) / directions
    size = np.geomspace(3e-3, 3, sizes)
    one = np.stack(np.meshgrid(angle, size, [0.3, 1.0], indexing="ij"), -1).reshape(-1, 3)
    if len(one) ** k <= MOST_STARTS:
        chosen = np.array(list(itertools.product(range(len(one)), repeat=k)))
    else:
        chosen = np.random.default_rng(k).integers(len(one), size=(MOST_STARTS, k))
    angle, size, pressure = np.moveaxis(one[chosen], -1, 0)
    return np.stack([pressure, size * np.cos(angle), size * np.sin(angle)], -1)


def all_solutions(problem: Problem) -> list[np.ndarray]:
    """The multipliers of all solutions that are found."""
    m = len(problem.area)
    found: list[np.ndarray] = []
    for states in itertools.product("otl", repeat=m):
        closed = [i for i, state in enumerate(states) if state != "o"]
        stuck = [i for i, state in enumerate(states) if state == "t"]
        slide = [i for i, state in enumerate(states) if state == "l"]
        T, L = components(stuck, m), components(slide, m)
        S, h = problem.operator, problem.rhs
        solved = np.linalg.solve(S[np.ix_(T, T)], np.c_[h[T], S[np.ix_(T, L)]])
        if slide:
            condensed = S[np.ix_(L, L)] - S[np.ix_(L, T)] @ solved[:, 1:]
            rest = h[L] - S[np.ix_(L, T)] @ solved[:, 0]
            places = slipping(problem, condensed, rest, problem.area[slide])
        else:
            places = np.zeros((1, 0, 3))
        for place in places:
            multiplier = np.zeros(3 * m)
            multiplier[L] = stresses(problem, place).ravel()
            multiplier[T] = solved[:, 0] - solved[:, 1:] @ multiplier[L]
            size = np.abs(multiplier).max()
            known = any(np.abs(multiplier - other).max() <= SAME * max(size, np.abs(other).max()) for other in found)
            if not known and holds(problem, states, multiplier, closed):
                found.append(multiplier)
    return found


def holds(problem: Problem, states, multiplier: np.ndarray, closed) -> bool:
    """Whether the inequalities of the states hold."""
    m = len(states)
    r = problem.operator @ multiplier - problem.rhs
    stress, way = np.abs(multiplier).max(), np.abs(problem.rhs).max()
    if any(multiplier[i] < -SLACK * stress for i in closed):
        return False
    at_rest = problem.law(np.zeros(2))
    for i, state in enumerate(states):
        pair = multiplier[m + 2 * i : m + 2 * i + 2]
        if state == "o" and r[i] < -SLACK * way:
            return False
        if state == "t" and np.linalg.norm(pair / at_rest) > multiplier[i] + SLACK * stress:
            return False
        if state == "l" and np.abs(r[m + 2 * i : m + 2 * i + 2]).max() <= SLACK * way:
            return False
    return True
