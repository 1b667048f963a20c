"""The dual problem of a run file and what proves an answer of it, in plain numpy.

A convex problem has one solution, and whatever satisfies its conditions is that solution. So an answer is proven by the
residual of its conditions after a few Newton steps in extended precision, however it was found. Without friction and
floating, non-negative least squares with the Cholesky factor of S, an active set method, finds the same from nothing.
"""

from dataclasses import dataclass, replace

import h5py
import numpy as np
from scipy import sparse
from scipy.linalg import cholesky, solve_triangular
from scipy.optimize import nnls
from scipy.sparse.linalg import splu

from ellipse import project
from run_file import read_matrix, read_scene

IDLE = 4
"""Newton steps that may not halve the residual; two steps in all are the rule."""
CORRECTIONS = 12
"""Solves with a factor in double precision; each wins some digits up to those of extended precision."""
UNFELT = 1e-10
"""Share of the largest effect of a rigid motion on the face below which it has none."""
ROUNDINGS = 64
"""What is allowed beside epsilon, in units of the rounding of S times its condition number."""


@dataclass(frozen=True)
class Dual:
    """Minimise x'Sx/2 - x'h over x_nu >= 0 and ellipses under G'x = e."""

    operator: np.ndarray
    rhs: np.ndarray
    n_panes: int
    axes: np.ndarray
    """Semi-axes of the ellipses, [n_pairs, 2]."""
    motions: np.ndarray
    """G, [n_multipliers, n_motions]."""
    resultant: np.ndarray
    area: np.ndarray
    slip: np.ndarray
    """What the displacement found makes of pairs, the integrals of u_t over panes, [2 n_pairs]."""
    anchor: np.ndarray
    """The multipliers that S counts from: S (x - anchor) - h."""

    @classmethod
    def read(cls, file: h5py.File) -> "Dual":
        """S, h and what else makes the problem of a solved file."""
        scene, assemble = read_scene(file), file["assemble"]
        rhs = file["load/dual_rhs"][:]
        area = file["mesh/pane_area"][:]
        motions, resultant = balance(file)
        return cls(
            operator=assemble["dual_operator"][:],
            rhs=rhs,
            n_panes=area.size,
            axes=semi_axes(scene, area.size, rhs.size),
            motions=motions,
            resultant=resultant,
            area=area,
            slip=slip_integrals(file),
            anchor=np.zeros(rhs.size),
        )

    @property
    def stiffness(self) -> np.ndarray:
        """The local stiffness (S^-1)_ii, one for each pair; 0 where no multiplier moves anything."""
        moves = np.diag(self.operator) > 0
        scale = 1.0 / np.sqrt(np.diag(self.operator)[moves])
        inverse = np.linalg.inv(
            self.operator[np.ix_(moves, moves)] * np.outer(scale, scale)
        )
        stiffness = np.zeros(self.rhs.size)
        stiffness[moves] = np.diag(inverse) * scale**2
        pairs = stiffness[self.n_panes :].reshape(-1, 2)
        both = (pairs > 0).all(axis=1)
        pairs[both] = pairs[both].mean(axis=1, keepdims=True)
        return stiffness

    @property
    def rounding(self) -> float:
        """What rounding of S makes of multipliers: epsilon cond S, of S with unit diagonal."""
        diagonal = np.diag(self.operator)
        scale = 1.0 / np.sqrt(diagonal[diagonal > 0])
        kept = self.operator[np.ix_(diagonal > 0, diagonal > 0)] * np.outer(
            scale, scale
        )
        return float(np.finfo(float).eps * np.linalg.cond(kept))

    def size(self, multiplier: np.ndarray) -> float:
        """The area-weighted norm of multipliers."""
        m = self.n_panes
        squares = multiplier[:m] ** 2
        squares[: len(self.axes)] += (multiplier[m:].reshape(-1, 2) ** 2).sum(axis=1)
        return float(np.sqrt(self.area @ squares))

    def strength(self) -> float:
        """The area-weighted norm of what friction can bear."""
        return float(
            np.sqrt(
                self.area[: len(self.axes)] @ self.axes.max(axis=1, initial=0.0) ** 2
            )
        )


def semi_axes(scene: dict, n_panes: int, n_multipliers: int) -> np.ndarray:
    """Slip bound times coefficients, on all panes or none."""
    if n_multipliers == n_panes:
        return np.zeros((0, 2))
    law = scene["friction"]
    first = law.get("coefficient", law.get("coefficient_1"))["constant"]
    second = law.get("coefficient", law.get("coefficient_2"))["constant"]
    return np.tile(
        [law["slip_bound"] * first, law["slip_bound"] * second], (n_panes, 1)
    )


def balance(file: h5py.File) -> tuple[np.ndarray, np.ndarray]:
    """G = B R and e = R'l for rigid motions R that no clamp holds, from coordinates alone."""
    x, dof = file["mesh/coordinates"][:], file["assemble/degree_of_freedom"][:]
    centred = x - x.mean(axis=0)
    axes = np.eye(3)
    fields = [np.broadcast_to(a, x.shape) for a in axes]
    fields += [np.cross(a, centred) / np.ptp(x) for a in axes]
    held = np.array([field[dof < 0] for field in fields])
    _, values, rows = np.linalg.svd(held.T, full_matrices=True)
    values = np.concatenate([values, np.zeros(6 - values.size)])
    free_motions = rows[values <= 1e-9 * max(values.max(), 1.0)]
    modes = np.zeros((dof.max() + 1, len(free_motions)))
    for k, weights in enumerate(free_motions):
        field = np.tensordot(weights, np.array(fields), axes=1)
        modes[dof[dof >= 0], k] = field[dof >= 0]
    names = ("coupling_normal", "coupling_tangential")
    parts = [
        read_matrix(file["assemble"][name])
        for name in names
        if name in file["assemble"]
    ]
    coupling = np.vstack([part @ modes for part in parts])
    if not coupling.size:
        return coupling, modes.T @ file["load/force"][:]
    # Motions that contact does not feel are rounding in G and e, which no scaling may raise to a condition.
    _, values, rows = np.linalg.svd(coupling, full_matrices=False)
    felt = rows[values > UNFELT * values[0]].T
    return coupling @ felt, felt.T @ (modes.T @ file["load/force"][:])


def slip_integrals(file: h5py.File) -> np.ndarray:
    """The tangential part of B u."""
    if "coupling_tangential" not in file["assemble"]:
        return np.zeros(0)
    dof = file["assemble/degree_of_freedom"][:]
    displacement = np.zeros(dof.max() + 1)
    displacement[dof[dof >= 0]] = file["solve/displacement"][:][dof >= 0]
    return read_matrix(file["assemble/coupling_tangential"]) @ displacement


def about(file: h5py.File, dual: Dual, multiplier: np.ndarray) -> Dual:
    """The same problem about an answer of a body that supports hold, with B u - gap there in extended precision.

    S and h of a badly conditioned stiffness are less accurate than their entries. Here that counts only as a share of
    the way from the answer.
    """
    wide = np.longdouble
    names = ("coupling_normal", "coupling_tangential")
    parts = [
        read_matrix(file["assemble"][name])
        for name in names
        if name in file["assemble"]
    ]
    coupling = sparse.csr_matrix(sparse.vstack(parts)).astype(wide)
    stiffness = sparse.csr_matrix(read_matrix(file["assemble/stiffness"]))
    solve, exact = splu(sparse.csc_matrix(stiffness)).solve, stiffness.astype(wide)
    forces = file["load/force"][:].astype(wide) - coupling.T @ multiplier.astype(wide)
    displacement = np.zeros(forces.size, dtype=wide)
    for _ in range(CORRECTIONS):
        displacement += solve(np.asarray(forces - exact @ displacement, dtype=float))
    closing = coupling @ displacement
    closing[: dual.n_panes] -= gap_integrals(file)
    return replace(dual, rhs=np.asarray(closing, dtype=float), anchor=multiplier)


def gap_integrals(file: h5py.File) -> np.ndarray:
    """The integrals over panes of the gap of the scene, interpolated between contact nodes, in m^3."""
    gap = read_scene(file)["contact"].get("gap", 0.0)
    nodes = file["mesh/coordinates"][:][file["mesh/contact_nodes"][:]]
    known = {"x": nodes[:, 0], "sin": np.sin, "__builtins__": {}}
    values = eval(gap, known) if isinstance(gap, str) else gap
    values = np.broadcast_to(np.asarray(values, dtype=float), len(nodes))
    return file["mesh/pane_area"][:] * (
        read_matrix(file["mesh/pane_average"]).T @ values
    )


def by_active_sets(dual: Dual) -> np.ndarray | None:
    """The solution without friction where supports hold the body, by non-negative least squares."""
    if len(dual.axes) or dual.motions.size or not (np.diag(dual.operator) > 0).all():
        return None
    scale = 1.0 / np.sqrt(np.diag(dual.operator))
    factor = cholesky(dual.operator * np.outer(scale, scale))
    target = solve_triangular(factor, scale * dual.rhs, trans="T")
    return scale * nnls(factor, target, maxiter=30 * dual.rhs.size)[0]


def newton(dual: Dual, start: np.ndarray) -> tuple[np.ndarray, float]:
    """A solution near an answer and the natural residual there, by semismooth steps.

    A step into other zones may lead away before it leads there. What counts at the end is the residual, which
    knows no zones.
    """
    rho = dual.stiffness
    unknowns = np.concatenate([start, motion_of(dual, start)])
    best = unknowns, natural_residual(dual, unknowns, rho)
    idle = 0
    while idle < IDLE:
        unknowns = step(dual, unknowns, rho)
        size = natural_residual(dual, unknowns, rho)
        idle = 0 if size < 0.5 * best[1] else idle + 1
        if size < best[1]:
            best = unknowns, size
    return best[0][: start.size], best[1]


def gradient(dual: Dual, unknowns: np.ndarray) -> np.ndarray:
    """S x - G a - h in extended precision, for x and the rigid motions a."""
    wide = np.longdouble
    x, motion = np.split(unknowns.astype(wide), [dual.rhs.size])
    moved = dual.operator @ (x - dual.anchor) - dual.motions @ motion
    return np.asarray(moved - dual.rhs, dtype=float)


def motion_of(dual: Dual, x: np.ndarray) -> np.ndarray:
    """The rigid motions that close pressed panes and move the others as the program's displacement does."""
    if not dual.motions.size:
        return np.zeros(0)
    m = dual.n_panes
    known = np.concatenate([x[:m] > 0, np.ones(dual.slip.size, dtype=bool)])
    weights = np.where(known, np.sqrt(dual.stiffness), 0.0)
    r = dual.operator @ x - dual.rhs
    r[m:] += dual.slip
    return np.linalg.lstsq(dual.motions * weights[:, None], weights * r, rcond=1e-12)[0]


def admissible(dual: Dual, x: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    """The nearest admissible multiplier, and how its pairs follow those of x, [n_pairs, 2, 2]."""
    m = dual.n_panes
    tangential = project(x[m:].reshape(-1, 2), dual.axes)
    nearest = np.concatenate([np.maximum(x[:m], 0.0), tangential.point.ravel()])
    return nearest, tangential.by_trial


def natural_residual(dual: Dual, unknowns: np.ndarray, rho: np.ndarray) -> float:
    """The norm of x - P(x - rho r) and of G'x - e beside that of x: 0 for the solution alone."""
    x = unknowns[: dual.rhs.size]
    if not np.isfinite(unknowns).all():
        return np.inf
    trial = np.where(rho > 0, x - rho * gradient(dual, unknowns), 0.0)
    moved = x - admissible(dual, trial)[0]
    whole = max(dual.size(x), dual.strength(), np.finfo(float).tiny)
    missing = dual.motions.T @ x - dual.resultant
    carried = np.abs(dual.motions).T @ np.abs(x) + np.abs(dual.resultant)
    imbalance = np.abs(missing / np.where(carried > 0, carried, 1.0)).max(initial=0.0)
    return max(dual.size(moved) / whole, float(imbalance))


def step(dual: Dual, unknowns: np.ndarray, rho: np.ndarray) -> np.ndarray:
    """One semismooth step on x - P(x - rho r) = 0, G'x = e, for x and the motions."""
    n, m, p = dual.rhs.size, dual.n_panes, dual.motions.shape[1]
    x = unknowns[:n]
    # What no stress moves carries none.
    trial = np.where(rho > 0, x - rho * gradient(dual, unknowns), 0.0)
    projected, by_trial = admissible(dual, trial)
    derivative = np.zeros((n, n))
    pressed = np.flatnonzero(trial[:m] > 0)
    derivative[pressed, pressed] = 1.0
    for pane, block in enumerate(by_trial):
        at = slice(m + 2 * pane, m + 2 * pane + 2)
        derivative[at, at] = block
    derivative[:, rho == 0] = 0.0
    by_r = derivative * rho
    matrix = np.zeros((n + p, n + p))
    matrix[:n, :n] = np.eye(n) - derivative + by_r @ dual.operator
    matrix[:n, n:] = -by_r @ dual.motions
    matrix[n:, :n] = dual.motions.T
    rhs = np.concatenate([projected - x, dual.resultant - dual.motions.T @ x])
    columns = np.linalg.norm(matrix, axis=0)
    columns[columns == 0] = 1.0
    rows = np.linalg.norm(matrix / columns, axis=1)
    rows[rows == 0] = 1.0
    scaled = matrix / columns / rows[:, None]
    if p:
        # Motions that contact does not feel leave the matrix singular.
        change = np.linalg.lstsq(scaled, rhs / rows, rcond=1e-14)[0]
    else:
        change = np.linalg.solve(scaled, rhs / rows)
    return unknowns + change / columns
