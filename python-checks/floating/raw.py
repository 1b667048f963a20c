"""The contact problem of a body that floats from the raw arrays of its run file, and the conditions of its solutions."""

from dataclasses import dataclass

import h5py
import numpy as np
from scipy import sparse
from scipy.optimize import linprog
from scipy.sparse.linalg import splu

from ellipse import project
from run_file import read_matrix

SIDES = 48
"""Of the polygons in place of the ellipses of friction; they are off by 0.2 per cent."""


@dataclass(frozen=True)
class Floating:
    """r = S x - G a - h, G' x = e for the multipliers x: m normal ones, then pairs where there is friction."""

    area: np.ndarray
    operator: np.ndarray
    rhs: np.ndarray
    motions: np.ndarray
    resultant: np.ndarray
    friction: np.ndarray
    coupling: sparse.csr_matrix
    gap: np.ndarray

    @classmethod
    def read(cls, file: h5py.File, coefficients: tuple[float, float] | None) -> "Floating":
        """From A, B, l and h alone; six degrees of freedom are held in place of the program's springs."""
        assemble = file["assemble"]
        names = [n for n in ("coupling_normal", "coupling_tangential") if n in assemble]
        coupling = sparse.vstack([read_matrix(assemble[n]) for n in names]).tocsr()
        area, load = file["mesh/pane_area"][:], file["load/force"][:]
        modes, pins = assemble["rigid_modes"][:], assemble["rigid_pins"][:]
        stiffness = read_matrix(assemble["stiffness"]).tocsc()
        kept = np.setdiff1d(np.arange(load.size), pins)
        solve = splu(stiffness[kept][:, kept]).solve
        rows = coupling[:, kept]
        operator = rows @ solve(rows.T.toarray())
        grounded = stiffness.tolil()
        for pin in pins:
            grounded[pin, pin] += float(assemble["rigid_spring"][()])
        gap = coupling @ splu(grounded.tocsc()).solve(load) - file["load/dual_rhs"][:]
        return cls(
            area=area,
            operator=(operator + operator.T) / 2,
            rhs=rows @ solve(load[kept]) - gap,
            motions=coupling @ modes.T,
            resultant=modes @ load,
            friction=np.array(coefficients or (0.0, 0.0)),
            coupling=coupling,
            gap=gap,
        )

    @property
    def m(self) -> int:
        """Number of panes."""
        return self.area.size

    def admissible(self, trial: np.ndarray) -> np.ndarray:
        """Pressures that do not pull, and pairs projected on the ellipses of these pressures."""
        m = self.m
        pressure = np.maximum(trial[:m], 0.0)
        if trial.size == m:
            return pressure
        pairs = project(trial[m:].reshape(m, 2), pressure[:, None] * self.friction).point
        return np.concatenate([pressure, pairs.ravel()])

    def error(self, x: np.ndarray, gradient: np.ndarray) -> float:
        """How far x and r = gap - B u are from the conditions: imbalance, and the natural map in units of the panes' stiffness."""
        size = np.linalg.norm(x)
        if size == 0.0:
            return np.inf
        imbalance = np.abs(self.resultant - self.motions.T @ x)
        # Neutral motions carry nothing but rounding.
        carried = np.abs(self.motions).T @ np.abs(x)
        imbalance = np.max(imbalance) / np.max(carried)
        residual = x - self.admissible(x - gradient / np.diag(self.operator).mean())
        return float(max(imbalance, np.linalg.norm(residual) / size))

    def error_of_file(self, file: h5py.File, x: np.ndarray) -> float:
        """The same of an answer with its displacement, and what is left of A u = l - B' x beside the load."""
        dof, nodal = file["assemble/degree_of_freedom"][:], file["solve/displacement"][:]
        u = np.empty(dof.max() + 1)
        u[dof[dof >= 0]] = nodal[dof >= 0]
        load = file["load/force"][:]
        left = load - self.coupling.T @ x - read_matrix(file["assemble/stiffness"]) @ u
        return max(self.error(x, self.gap - self.coupling @ u), np.linalg.norm(left) / np.linalg.norm(load))

    def can_be_held(self, radius: float) -> bool:
        """Whether forces within polygons whose corners lie at `radius` times the ellipses balance the load (a linear programme)."""
        m = self.m
        columns = self.motions[:m]
        if self.motions.shape[0] > m:
            angles = 2 * np.pi * np.arange(SIDES) / SIDES
            corners = radius * self.friction[:, None] * np.array([np.cos(angles), np.sin(angles)])
            pairs = self.motions[m:].reshape(m, 2, -1)
            sheared = np.einsum("ptk,tc->pck", pairs, corners).reshape(-1, pairs.shape[2])
            columns = np.repeat(columns, SIDES, axis=0) + sheared
        scale = np.abs(columns).max(axis=0)
        scale[scale < 1e-9 * scale.max()] = scale.max()
        size = np.abs(self.resultant / scale).max()
        found = linprog(
            np.zeros(columns.shape[0]),
            A_eq=(columns / scale).T,
            b_eq=self.resultant / scale / size,
            method="highs",
            options={"primal_feasibility_tolerance": 1e-9},
        )
        return bool(found.success)
