"""The constants of HKL section 3 from raw arrays, in plain numpy.

Everything is dense and meant for a few hundred unknowns on the contact face.
"""

from dataclasses import dataclass
from functools import cache, cached_property

import numpy as np
from scipy import sparse
from scipy.linalg import cho_factor, cho_solve, eigh
from scipy.optimize import minimize
from scipy.sparse.linalg import splu

from raw_problem import RawProblem

# Barycentric mass of a triangle of area 1, and of a tetrahedron of volume 1.
TRIANGLE_MASS = (np.ones((3, 3)) + np.eye(3)) / 12
TETRAHEDRON_MASS = (np.ones((4, 4)) + np.eye(4)) / 20


def largest(form: np.ndarray, norm: np.ndarray) -> float:
    """The largest eigenvalue of form x = value norm x."""
    size = form.shape[0]
    return float(eigh(form, norm, eigvals_only=True, subset_by_index=[size - 1] * 2)[0])


def smallest(form: np.ndarray, norm: np.ndarray) -> float:
    """The smallest eigenvalue of form x = value norm x."""
    return float(eigh(form, norm, eigvals_only=True, subset_by_index=[0, 0])[0])


def gradients(corners: np.ndarray) -> tuple[np.ndarray, float]:
    """Gradients of the barycentric coordinates of a simplex, [k + 1, 3], and its measure."""
    edges = corners[1:] - corners[0]
    gram = edges @ edges.T
    inner = np.linalg.solve(gram, edges)
    measure = np.sqrt(np.linalg.det(gram)) / (2 if len(edges) == 2 else 6)
    return np.vstack([-inner.sum(axis=0), inner]), float(measure)


def scalar_forms(
    coordinates: np.ndarray, simplices: np.ndarray, mass: np.ndarray
) -> tuple[sparse.csc_matrix, sparse.csc_matrix]:
    """Mass and stiffness of scalar P1 functions on simplices."""
    rows, columns, masses, stiffnesses = [], [], [], []
    for nodes in simplices:
        gradient, measure = gradients(coordinates[nodes])
        rows.append(np.repeat(nodes, len(nodes)))
        columns.append(np.tile(nodes, len(nodes)))
        masses.append((measure * mass).ravel())
        stiffnesses.append((measure * gradient @ gradient.T).ravel())
    at = (np.concatenate(rows), np.concatenate(columns))
    shape = (len(coordinates),) * 2
    both = (np.concatenate(part) for part in (masses, stiffnesses))
    mass_matrix, stiffness = (sparse.csc_matrix((part, at), shape) for part in both)
    return mass_matrix, stiffness


@dataclass(frozen=True)
class Face:
    """Scalar forms on the contact face, over its nodes."""

    coordinates: np.ndarray
    triangles: np.ndarray
    mass: np.ndarray
    stiffness: np.ndarray
    free: np.ndarray

    @classmethod
    def of(cls, problem: RawProblem, facets: np.ndarray) -> "Face":
        """The face with the given triangles, in node numbers of the mesh."""
        nodes = problem.contact_nodes
        triangles = np.searchsorted(nodes, facets)
        coordinates = problem.coordinates[nodes]
        mass, stiffness = scalar_forms(coordinates, triangles, TRIANGLE_MASS)
        free = np.flatnonzero((problem.dof[nodes] >= 0).any(axis=1))
        return cls(coordinates, triangles, mass.toarray(), stiffness.toarray(), free)

    def on_free(self, form: np.ndarray) -> np.ndarray:
        """A form over the nodes that can move."""
        return form[np.ix_(self.free, self.free)]

    @property
    def size(self) -> float:
        """h: the largest diameter of a triangle."""
        corners = self.coordinates[self.triangles]
        return float(np.linalg.norm(corners - np.roll(corners, 1, axis=1), axis=2).max())

    @property
    def lumped(self) -> np.ndarray:
        """The integral of each hat function."""
        return self.mass.sum(axis=1)

    def inverse_first(self) -> float:
        """c_inv(1,0) of (3.7)."""
        mass = self.on_free(self.mass)
        stiffness = self.on_free(self.stiffness)
        return self.size * np.sqrt(largest(stiffness + mass, mass))

    @cached_property
    def areas(self) -> list[float]:
        """The area of each triangle."""
        return [gradients(self.coordinates[nodes])[1] for nodes in self.triangles]

    def fourth_power(self, values: np.ndarray) -> tuple[float, np.ndarray, np.ndarray]:
        """The integral of the fourth power of a P1 function, its gradient and its Hessian.

        By collapsed Gauss points on each triangle, exact for polynomials of degree 4.
        """
        total, slope = 0.0, np.zeros_like(values)
        curvature = np.zeros((values.size, values.size))
        for nodes, area in zip(self.triangles, self.areas, strict=True):
            at = POINTS @ values[nodes]
            total += area * WEIGHTS @ at**4
            slope[nodes] += 4 * area * POINTS.T @ (WEIGHTS * at**3)
            block = 12 * area * POINTS.T @ ((WEIGHTS * at**2)[:, None] * POINTS)
            curvature[np.ix_(nodes, nodes)] += block
        return total, slope, curvature

    def least_fourth(self, node: int) -> float:
        """The least L4 norm of a function of Y^h with value 1 at a node, by Newton's method."""
        values = np.zeros(len(self.coordinates))
        values[node] = 1.0
        others = self.free[self.free != node]
        value = self.fourth_power(values)[0]
        for _ in range(200):
            _, slope, curvature = self.fourth_power(values)
            block = curvature[np.ix_(others, others)]
            # Far from the node the Hessian vanishes with the function.
            block += 1e-9 * np.trace(block) / len(others) * np.eye(len(others))
            step = np.zeros_like(values)
            step[others] = -np.linalg.solve(block, slope[others])
            length = 1.0
            while (new := self.fourth_power(values + length * step)[0]) > value:
                length /= 2
                if length < 1e-9:
                    return value**0.25
            if value - new < 1e-14 * value:
                return new**0.25
            values, value = values + length * step, new
        return value**0.25


def triangle_rule() -> tuple[np.ndarray, np.ndarray]:
    """Barycentric points and weights of a collapsed Gauss rule on a triangle of area 1."""
    x, w = np.polynomial.legendre.leggauss(4)
    x, w = (x + 1) / 2, w / 2
    u, v = (part.ravel() for part in np.meshgrid(x, x, indexing="ij"))
    weights = (np.outer(w, w).ravel()) * 2 * (1 - u)
    second = v * (1 - u)
    return np.column_stack([1 - u - second, u, second]), weights


POINTS, WEIGHTS = triangle_rule()


@dataclass(frozen=True)
class Norms:
    """A norm of displacements and what it makes of the contact face."""

    problem: RawProblem
    face: Face
    matrix: sparse.csc_matrix

    @classmethod
    def first_sobolev(cls, problem: RawProblem, face: Face) -> "Norms":
        """The norm of H1(Omega)^3 on V^h."""
        mass, stiffness = scalar_forms(
            problem.coordinates, problem.tetrahedra, TETRAHEDRON_MASS
        )
        whole = sparse.kron(mass + stiffness, np.eye(3), format="csr")
        free = np.empty(problem.load.size, dtype=int)
        free[problem.dof[problem.dof >= 0]] = np.flatnonzero(problem.dof.ravel() >= 0)
        return cls(problem, face, sparse.csc_matrix(whole[free][:, free]))

    @classmethod
    def energy(cls, problem: RawProblem, face: Face) -> "Norms":
        """The energy norm."""
        return cls(problem, face, problem.stiffness)

    @cached_property
    def solve(self):
        """b -> X^-1 b."""
        return splu(sparse.csc_matrix(self.matrix)).solve

    @cached_property
    def ellipticity(self) -> float:
        """alpha of (2.6)."""
        return smallest(self.problem.stiffness.toarray(), self.matrix.toarray())

    @cached_property
    def continuity(self) -> float:
        """M of (2.7)."""
        return largest(self.problem.stiffness.toarray(), self.matrix.toarray())

    @cached_property
    def load(self) -> float:
        """The norm of the load."""
        return float(np.sqrt(self.problem.load @ self.solve(self.problem.load)))

    @cached_property
    def selection(self) -> np.ndarray:
        """E: nodal (u_nu, u_t1, u_t2) at the contact nodes, node by node."""
        p = self.problem
        rows = np.zeros((3 * p.contact_nodes.size, p.load.size))
        for local, node in enumerate(p.contact_nodes):
            for component in np.flatnonzero(p.dof[node] >= 0):
                place = p.dof[node, component]
                rows[3 * local : 3 * local + 3, place] = p.frame[:, component]
        return rows

    @cached_property
    def gram(self) -> np.ndarray:
        """E X^-1 E'."""
        gram = self.selection @ self.solve(self.selection.T.copy())
        return (gram + gram.T) / 2

    @cached_property
    def weights(self) -> np.ndarray:
        """N in terms of nodal normal displacements, [m, n_contact_nodes]."""
        average = self.problem.pane_average.toarray()
        return (average * self.problem.pane_area).T

    @cached_property
    def normal_gram(self) -> np.ndarray:
        """Q = N X^-1 N'."""
        return self.weights @ self.gram[::3, ::3] @ self.weights.T

    @cached_property
    def glued_gram(self) -> np.ndarray:
        """Q of the displacements whose tangential part vanishes on the face."""
        tangential = np.flatnonzero(np.arange(len(self.gram)) % 3 > 0)
        moving = tangential[np.diag(self.gram)[tangential] > 0]
        cross = self.weights @ self.gram[::3][:, moving]
        block = cho_factor(self.gram[np.ix_(moving, moving)])
        return self.normal_gram - cross @ cho_solve(block, cross.T)

    def inverse_half(self, size: float) -> float:
        """c_inv(0,-1/2) of (3.16) for panes of a diameter."""
        return np.sqrt(size * largest(np.diag(self.problem.pane_area), self.glued_gram))

    def trace_second(self) -> float:
        """c_tr(2) on the contact face."""
        mass = np.kron(self.face.mass, np.eye(3))
        root = np.linalg.cholesky(mass)
        return np.sqrt(np.linalg.eigvalsh(root.T @ self.gram @ root)[-1])

    def trace_absolute(self) -> float:
        """The bound of |r_h |u_t|| by |u|, Lagrange interpolation, with the lumped mass."""
        root = np.sqrt(np.repeat(self.face.lumped, 2))
        tangential = np.arange(len(self.gram)) % 3 > 0
        block = self.gram[np.ix_(tangential, tangential)]
        return np.sqrt(np.linalg.eigvalsh(root[:, None] * block * root)[-1])

    def trace_largest(self) -> float:
        """The bound of max |u| on the face by |u|."""
        nodes = range(0, len(self.gram), 3)
        blocks = [self.gram[n : n + 3, n : n + 3] for n in nodes]
        return np.sqrt(max(np.linalg.eigvalsh(block)[-1] for block in blocks))

    def trace_fourth(self, starts: list[np.ndarray]) -> float:
        """A lower bound of c_tr(4): the best local maximum from some starts."""

        def fourth(values: np.ndarray) -> tuple[float, np.ndarray]:
            total, slope = 0.0, np.zeros_like(values)
            for nodes, area in zip(self.face.triangles, self.face.areas, strict=True):
                at = POINTS @ values[nodes]
                square = (at**2).sum(axis=1)
                total += area * WEIGHTS @ square**2
                slope[nodes] += 4 * area * POINTS.T @ ((WEIGHTS * square)[:, None] * at)
            return total, slope

        best = 0.0
        for start in starts:
            values, last = start, 0.0
            for _ in range(1000):
                _, slope = fourth(values)
                moved = self.gram @ slope.ravel()
                length = np.sqrt(slope.ravel() @ moved)
                values = (moved / length).reshape(-1, 3)
                total, _ = fourth(values)
                if total - last < 1e-13 * total:
                    break
                last = total
            best = max(best, total)
        return best**0.25


def lagrange_of_absolute(face: Face) -> float:
    """c_r of (3.3) for Lagrange interpolation on |Y^h|, by a search on each shape; its size does not matter."""
    corners = face.coordinates[face.triangles] / face.size
    shapes = (corners - corners[:, :1]).reshape(len(corners), -1)
    return max(lagrange_on_shape(tuple(shape)) for shape in np.unique(shapes.round(9), axis=0))


@cache
def lagrange_on_shape(shape: tuple[float, ...]) -> float:
    """The same on one triangle, from nine coordinates."""
    gradient, area = gradients(np.array(shape).reshape(3, 3))

    def ratio(values: np.ndarray) -> float:
        slope = area * np.sum((values @ gradient) ** 2)
        if slope == 0:
            return 0.0
        points, weights = FINE
        at = points @ values
        gap = np.abs(at) - points @ np.abs(values)
        return -np.sqrt(area * weights @ gap**2 / slope)

    worst = 0.0
    # Half a turn: v and -v have the same ratio.
    for turn in range(12):
        angle = np.pi * turn / 12
        direction = np.array([np.cos(angle), np.sin(angle)])
        for level in (-0.3, 0.0, 0.3):
            found = minimize(ratio, np.append(direction, level), method="Nelder-Mead")
            worst = max(worst, -found.fun)
    return worst


def fine_rule(parts: int = 24) -> tuple[np.ndarray, np.ndarray]:
    """A composite rule on a triangle of area 1 for functions with a kink."""
    points = []
    for i in range(parts):
        for j in range(parts - i):
            base = np.array([i, j]) / parts
            up = base + np.array([[0, 0], [1, 0], [0, 1]]) / parts
            points.append(POINTS @ up)
            if i + j < parts - 1:
                down = base + np.array([[1, 1], [0, 1], [1, 0]]) / parts
                points.append(POINTS @ down)
    at = np.concatenate(points)
    weights = np.tile(WEIGHTS, len(points)) / parts**2
    return np.column_stack([1 - at.sum(axis=1), at]), weights


FINE = fine_rule()
