"""A load history, solved again in plain numpy from S, B, A and h of a run file.

Each increment is solved by successive approximations on nearest admissible multipliers (a projected gradient method with
Nesterov's momentum inside), another algorithm than the program's; the coefficients and the path of sliding are
evaluated anew from the displacements found here, not from those of the file.
"""

from dataclasses import dataclass

import h5py
import numpy as np

from raw_problem import RawProblem
from run_file import read_scene


@dataclass
class Increment:
    """One increment, as found here."""

    multiplier: np.ndarray
    displacement: np.ndarray
    tangential: np.ndarray
    path: np.ndarray
    dissipation: float


class History:
    """The increments of a run file whose friction is Coulomb's, isotropic or orthotropic."""

    def __init__(self, file: h5py.File, problem: RawProblem, law):
        """`law` gives (F_1, F_2) at the contact nodes for the slips that it follows, [n, 2] and [n]."""
        self.stored = file["history"]
        self.problem = problem
        self.law = law
        self.follows = read_scene(file)["friction"].get("follows", "total-slip")
        self.loads = self.loads_of_increments()

    def loads_of_increments(self) -> np.ndarray:
        """The loads l = A u + B' lambda over the free degrees of freedom, [n_increments, n_free]."""
        p = self.problem
        rows = []
        for u, normal, tangential in zip(
            self.stored["displacement"],
            self.stored["multiplier_normal"],
            self.stored["multiplier_tangential"],
            strict=True,
        ):
            stresses = np.concatenate([normal, tangential.ravel()])
            rows.append(p.stiffness @ p.to_free(u) + p.coupling.T @ stresses)
        return np.array(rows)

    def tangential(self, displacement: np.ndarray) -> np.ndarray:
        """Signed (u_t1, u_t2) at the contact nodes."""
        p = self.problem
        return displacement[p.contact_nodes] @ p.frame[1:].T

    def friction_inverse(self, tangential, origin, path) -> np.ndarray:
        """The mean of 1/F on each pane for the slip that the law follows."""
        moved = tangential - origin
        slips, length = {
            "total-slip": (np.abs(tangential), np.hypot(*tangential.T)),
            "step-slip": (np.abs(moved), np.hypot(*moved.T)),
            "path-length": (path[:, :2] + np.abs(moved), path[:, 2] + np.hypot(*moved.T)),
        }[self.follows]
        return self.problem.friction_inverse(self.law(slips, length))

    def solve(self, load, rhs, origin, path, start) -> np.ndarray:
        """The multiplier that is its own projection, to 1e-13 or so of the largest."""
        p = self.problem
        s, m = p.dual_operator, p.n_panes
        step = 1.0 / p.spectrum[-1]
        multiplier = start
        for _ in range(200):
            displacement = self.displacement_of(load, multiplier)
            inverse = self.friction_inverse(self.tangential(displacement), origin, path)
            bound = p.slip_bound(np.maximum(multiplier[:m], 0.0))
            found = accelerated(s, rhs, step, multiplier, lambda x: p.project(x, bound, inverse))
            change = np.abs(found - multiplier).max() / max(np.abs(found).max(), 1e-300)
            multiplier = found
            if change < 1e-12:
                return multiplier
        raise AssertionError(f"no convergence, change {change}")

    def displacement_of(self, load, multiplier) -> np.ndarray:
        """u = A^-1 (l - B' lambda) at all nodes."""
        p = self.problem
        return p.to_nodes(p.solve_stiffness(load - p.coupling.T @ multiplier))

    def increments(self):
        """All increments, each from the one before."""
        p = self.problem
        nodes = p.contact_nodes.size
        origin, path = np.zeros((nodes, 2)), np.zeros((nodes, 3))
        multiplier = np.zeros(p.multiplier.size)
        for load in self.loads:
            free = p.coupling @ p.solve_stiffness(load)
            free[: p.n_panes] -= p.gap * p.pane_area
            began = (p.pane_average.T @ origin) * p.pane_area[:, None]
            free[p.n_panes :] -= began.ravel()
            multiplier = self.solve(load, free, origin, path, multiplier)
            displacement = self.displacement_of(load, multiplier)
            tangential = self.tangential(displacement)
            moved = tangential - origin
            path = path + np.column_stack([np.abs(moved), np.hypot(*moved.T)])
            slip = (p.pane_average.T @ moved) * p.pane_area[:, None]
            stresses = multiplier[p.n_panes :].reshape(-1, 2)
            yield free, Increment(
                multiplier, displacement, tangential, path, float(np.sum(stresses * slip))
            )
            origin = tangential


def accelerated(s, rhs, step, start, project) -> np.ndarray:
    """Minimises x.Sx/2 - x.rhs over a convex set by projected gradients with momentum, started anew where it rises."""
    x = y = project(start)
    momentum = 1.0
    for _ in range(200_000):
        following = project(y - step * (s @ y - rhs))
        moved = following - x
        if np.abs(following - y).max() <= 1e-15 * np.abs(following).max():
            return following
        if (y - following) @ moved > 0.0:
            momentum, y, x = 1.0, following, following
            continue
        larger = (1.0 + np.sqrt(1.0 + 4.0 * momentum**2)) / 2.0
        y = following + (momentum - 1.0) / larger * moved
        momentum, x = larger, following
    raise AssertionError("the projected gradient method did not end")
