"""Solutions of a body that floats by softer and softer springs and block Gauss-Seidel, no part of which the program has."""

import numpy as np

from ellipse import project
from floating.raw import Floating

FACTOR = 0.25
"""Of the springs from one problem to the next."""
MOST_SPRINGS = 30
MOST_SWEEPS = 400
SETTLED = 1e-11
"""Change of a sweep that ends the sweeps."""
SOLVES = 1e-8
"""Error of the conditions from which multipliers are a solution."""


def solution(problem: Floating) -> np.ndarray | None:
    """Multipliers that solve the problem without springs; None where none were found."""
    m, g = problem.m, problem.motions
    stiff = np.linalg.norm(g, axis=0) ** 2 / np.diag(problem.operator).mean()
    x = np.zeros(g.shape[0])
    best, least = None, np.inf
    for step in range(MOST_SPRINGS):
        springs = stiff * FACTOR**step
        supported = problem.operator + (g / springs) @ g.T
        rhs = problem.rhs + (g / springs) @ problem.resultant
        x = gauss_seidel(problem, supported, rhs, x)
        error = problem.error(x, supported @ x - rhs)
        if error < least:
            best, least = x, error
        if least < SOLVES:
            return best
    return None


def gauss_seidel(problem: Floating, s: np.ndarray, h: np.ndarray, x: np.ndarray) -> np.ndarray:
    """Sweeps over panes: the pressure that closes the gap, then the pair that the friction of this pressure allows."""
    m, x = problem.m, x.copy()
    r = s @ x - h
    for _ in range(MOST_SWEEPS):
        before = x.copy()
        for pane in range(m):
            change = max(x[pane] - r[pane] / s[pane, pane], 0.0) - x[pane]
            x[pane] += change
            r += s[:, pane] * change
            if x.size == m:
                continue
            at = slice(m + 2 * pane, m + 2 * pane + 2)
            rho = 1.0 / np.linalg.eigvalsh(s[at, at])[1]
            next_pair = project((x[at] - rho * r[at])[None], (x[pane] * problem.friction)[None]).point[0]
            r += s[:, at] @ (next_pair - x[at])
            x[at] = next_pair
        if np.abs(x - before).max() <= SETTLED * np.abs(x).max(initial=1e-300):
            break
    return x
