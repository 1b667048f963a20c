"""The discrete contact problem of a run file, and its laws, in plain numpy.

Nothing here reads /post: tests recompute it from what this module offers.
"""

from dataclasses import dataclass
from functools import cached_property

import h5py
import numpy as np
from scipy import sparse
from scipy.sparse.linalg import splu

from run_file import read_matrix, read_scene


@dataclass(frozen=True)
class RawProblem:
    """A u = l - B' lambda with multipliers on panes, and the stored solution."""

    scene: dict
    coordinates: np.ndarray
    tetrahedra: np.ndarray
    contact_nodes: np.ndarray
    pane_average: sparse.csc_matrix
    pane_area: np.ndarray
    dof: np.ndarray
    stiffness: sparse.csc_matrix
    load: np.ndarray
    coupling: sparse.csr_matrix
    dual_rhs: np.ndarray
    displacement: np.ndarray
    multiplier: np.ndarray
    steplength: float
    local_stiffness: np.ndarray

    @classmethod
    def read(cls, file: h5py.File) -> "RawProblem":
        """Take the raw arrays of a solved file."""
        assemble, solve, mesh = file["assemble"], file["solve"], file["mesh"]
        # Tangential parts are there with friction alone.
        parts = ("normal", "tangential") if "coupling_tangential" in assemble else ("normal",)
        coupling = [read_matrix(assemble[f"coupling_{part}"]) for part in parts]

        def both(name: str) -> np.ndarray:
            return np.concatenate([solve[f"{name}_{part}"][:].ravel() for part in parts])

        return cls(
            scene=read_scene(file),
            coordinates=mesh["coordinates"][:],
            tetrahedra=mesh["tetrahedra"][:],
            contact_nodes=mesh["contact_nodes"][:],
            pane_average=read_matrix(mesh["pane_average"]),
            pane_area=mesh["pane_area"][:],
            dof=assemble["degree_of_freedom"][:],
            stiffness=read_matrix(assemble["stiffness"]),
            load=file["load/force"][:],
            coupling=sparse.vstack(coupling, format="csr"),
            dual_rhs=file["load/dual_rhs"][:],
            displacement=solve["displacement"][:],
            multiplier=both("multiplier"),
            steplength=float(solve["steplength"][()]),
            local_stiffness=both("local_stiffness"),
        )

    @property
    def n_panes(self) -> int:
        """Number of panes m."""
        return self.pane_area.size

    @property
    def gap(self) -> float:
        """Initial gap d in m."""
        return self.scene["contact"].get("gap", 0.0)

    @property
    def normal(self) -> np.ndarray:
        """Normal multipliers, [m]."""
        return self.multiplier[: self.n_panes]

    @property
    def tangential(self) -> np.ndarray:
        """Tangential multipliers, [m, 2]."""
        return self.multiplier[self.n_panes :].reshape(-1, 2)

    def slip_bound(self, normal: np.ndarray) -> np.ndarray:
        """The slip bound under normal multipliers: these, or no more than the law's cap."""
        return np.minimum(normal, self.scene["friction"].get("pressure_cap", np.inf))

    @property
    def free_displacement(self) -> np.ndarray:
        """Displacement over the free degrees of freedom."""
        return self.to_free(self.displacement)

    @cached_property
    def frame(self) -> np.ndarray:
        """Rows: outward normal, t1, t2 = t1 x normal."""
        contact = self.scene["contact"]
        axis, end = contact["face"].split("_")
        normal = np.eye(3)["xyz".index(axis)] * (1.0 if end == "max" else -1.0)
        default = [0.0, 1.0, 0.0] if axis == "x" else [1.0, 0.0, 0.0]
        axis_1 = np.array(contact.get("axis_1", default))
        axis_1 = axis_1 / np.linalg.norm(axis_1)
        return np.array([normal, axis_1, np.cross(axis_1, normal)])

    @cached_property
    def solve_stiffness(self):
        """The function b -> A^-1 b of scipy's own sparse factorisation."""
        return splu(self.stiffness).solve

    @cached_property
    def dual_operator(self) -> np.ndarray:
        """S = B A^-1 B', dense, made symmetric against rounding."""
        s = self.coupling @ self.solve_stiffness(self.coupling.T.toarray())
        return (s + s.T) / 2

    @cached_property
    def spectrum(self) -> np.ndarray:
        """Eigenvalues of S, increasing."""
        return np.linalg.eigvalsh(self.dual_operator)

    def to_free(self, nodal: np.ndarray) -> np.ndarray:
        """Values of a nodal field at the free degrees of freedom."""
        free = np.empty(self.load.size)
        free[self.dof[self.dof >= 0]] = nodal[self.dof >= 0]
        return free

    def to_nodes(self, free: np.ndarray) -> np.ndarray:
        """A nodal field that vanishes where it is held."""
        nodal = np.zeros(self.dof.shape)
        nodal[self.dof >= 0] = free[self.dof[self.dof >= 0]]
        return nodal

    def displacement_of(self, multiplier: np.ndarray) -> np.ndarray:
        """u = A^-1 (l - B' lambda) at all nodes."""
        return self.to_nodes(
            self.solve_stiffness(self.load - self.coupling.T @ multiplier)
        )

    def slip(self, displacement: np.ndarray) -> np.ndarray:
        """|u_t1|, |u_t2| at the contact nodes, [n_contact_nodes, 2]."""
        return np.abs(displacement[self.contact_nodes] @ self.frame[1:].T)

    def nodal_friction(self, slip: np.ndarray) -> np.ndarray:
        """F_1, F_2 of the scene's law at the contact nodes."""
        laws = [self.scene["friction"][f"coefficient_{i}"] for i in (1, 2)]
        pairs = zip(laws, slip.T, strict=True)
        return np.column_stack([coefficient(law, s) for law, s in pairs])

    def friction_inverse(self, nodal_friction: np.ndarray) -> np.ndarray:
        """The mean of 1/F, interpolated linearly, on each pane (HKL (4.2))."""
        return self.pane_average.T @ (1.0 / nodal_friction)

    def project(
        self, point: np.ndarray, slip_bound: np.ndarray, friction_inverse: np.ndarray
    ) -> np.ndarray:
        """The nearest admissible multiplier: a half-line and an ellipse per pane."""
        m = self.n_panes
        semi_axes = slip_bound[:, None] / friction_inverse
        tangential = nearest_in_ellipses(point[m:].reshape(-1, 2), semi_axes)
        return np.concatenate([np.maximum(point[:m], 0.0), tangential.ravel()])


def coefficient(law: dict, slip: np.ndarray) -> np.ndarray:
    """One coefficient of friction of a scene at some slips."""
    if "constant" in law:
        return np.full(slip.shape, float(law["constant"]))
    ramp = law["ramp"]
    first, last = ramp["initial"], ramp["residual"]
    end = ramp["onset"] + abs(first - last) / ramp["rate"]
    return np.interp(slip, [ramp["onset"], end], [first, last])


def nearest_in_ellipses(points: np.ndarray, semi_axes: np.ndarray) -> np.ndarray:
    """The point of each ellipse (or of its limit, a segment or a point) nearest to a given one, [n, 2].

    Outside, the nearest point is x_i a_i^2 / (t + a_i^2) with the t > 0 that puts it on the
    boundary: where q_i = a_i x_i / (t + a_i^2) has length 1. 1/|q| is concave and rises with t, so
    Newton's method from t = 0 comes nearer from below at every step.
    """
    flat = ~semi_axes.all(axis=1)
    axes = np.where(flat[:, None], 1.0, semi_axes)
    scale = axes.max(axis=1, keepdims=True)
    x, square = points / scale, (axes / scale) ** 2
    product = x * np.sqrt(square)
    t = np.zeros_like(scale)
    for _ in range(100):
        q = product / (t + square)
        length = np.hypot(q[:, :1], q[:, 1:])
        slope = np.sum(q**2 / (t + square), axis=1, keepdims=True)
        step = np.zeros_like(t)
        np.divide((length - 1.0) * length**2, slope, out=step, where=length > 1.0)
        t += step
        if np.all(step <= 1e-15 * t):
            break
    else:
        raise AssertionError("no nearest point")
    nearest = np.where(t > 0.0, scale * square * x / (t + square), points)
    return np.where(flat[:, None], np.clip(points, -semi_axes, semi_axes), nearest)
