"""The contact face and what holds for all functions of Y^h on it: inverse inequalities and interpolation (HKL section 3)."""

import math
from dataclasses import dataclass
from functools import cached_property

import numpy as np
from scipy import sparse

from ._forms import Array, factor, largest_ratio, operator, scalar_forms, simplex_gradients

#: Rings of triangles around a node beyond which functions vanish in (3.17); each takes a tenth or less of what the one before does.
RINGS = 8
#: Rings that decide whether the surroundings of two nodes are the same, to this share of h.
ALIKE_RINGS = 4
ALIKE = 1e-7
#: Points along each side of the square that is searched for the worst cut of a triangle, first and later, and searches.
GRID = (33, 5)
SEARCHES = 40


def triangle_rule() -> tuple[Array, Array]:
    """Barycentric points and weights on a triangle, exact to degree 5 (J. Radon, Monatsh. Math. 52 (1948) 286)."""
    points, weights = [[1 / 3] * 3], [9 / 40]
    for sign in (-1, 1):
        near = (6 + sign * math.sqrt(15)) / 21
        points += np.where(np.eye(3, dtype=bool), 1 - 2 * near, near).tolist()
        weights += [(155 + sign * math.sqrt(15)) / 1200] * 3
    return np.array(points), np.array(weights)


@dataclass(frozen=True)
class ContactFace:
    """Continuous linear functions on triangles that vanish at some nodes: the space Y^h.

    :param free: the nodes at which they need not vanish, increasing.
    """

    points: Array
    triangles: Array
    free: Array

    @cached_property
    def geometry(self) -> tuple[Array, Array]:
        """Gradients of the barycentric coordinates, [t, 3, 3], and areas of the triangles."""
        return simplex_gradients(self.points, self.triangles)

    @cached_property
    def h(self) -> float:
        """The largest diameter of a triangle."""
        corners = self.points[self.triangles]
        return float(np.linalg.norm(corners - np.roll(corners, 1, axis=1), axis=2).max())

    @cached_property
    def mass(self) -> sparse.csc_array:
        """The products of L2 over the free nodes."""
        return scalar_forms(self.points, self.triangles)[0][self.free][:, self.free]

    @cached_property
    def first(self) -> sparse.csc_array:
        """The products of H1, of functions and gradients, over the free nodes."""
        mass, stiffness = scalar_forms(self.points, self.triangles)
        return (mass + stiffness)[self.free][:, self.free]

    @cached_property
    def stars(self) -> sparse.csr_array:
        """1 where a triangle touches a node, [n, t]."""
        count = len(self.triangles)
        places = (self.triangles.ravel(), np.repeat(np.arange(count), 3))
        return sparse.csr_array((np.ones(3 * count), places), shape=(len(self.points), count))

    @cached_property
    def quadrature(self) -> tuple[sparse.csr_array, Array]:
        """Nodal values to those at seven points of each triangle, [7 t, n], and the weights of the points."""
        shapes, weights = triangle_rule()
        rows = np.arange(7 * len(self.triangles)).repeat(3)
        entries = (np.tile(shapes.ravel(), len(self.triangles)), (rows, self.triangles.repeat(7, axis=0).ravel()))
        return sparse.csr_array(entries, shape=(len(rows) // 3, len(self.points))), np.outer(self.geometry[1], weights).ravel()

    def c_inv_10(self) -> float:
        """(3.7): |psi|_1 <= c / h |psi|_0."""
        return self.h * math.sqrt(largest_ratio(self.first, self.mass, operator(factor(self.mass), len(self.free))))

    def c_inv_infinity(self) -> float:
        """(3.17): max |psi| <= c / sqrt(h) |psi|_0,4.

        A linear function is largest at a node, where a vector field may be replaced by its component along its value: so c is
        sqrt(h) over the least norm of a function that is 1 at some node. Nodes in the same surroundings have the same one.
        """
        touching, reached = self.stars[self.free], sparse.eye_array(len(self.free), format="csr")
        neighbours = sparse.csr_array((touching @ touching.T).sign())
        for ring in range(RINGS):
            reached = (neighbours @ reached).sign()
            if ring == ALIKE_RINGS - 1:
                shown = sparse.csr_array(reached @ touching)
        centres = self.points[self.triangles].mean(axis=1)
        held = 3 - np.isin(self.triangles, self.free).sum(axis=1)
        distinct = {}
        for place, node in enumerate(self.free):
            triangles = shown[[place]].indices
            offsets = np.round((centres[triangles] - self.points[node]) / (ALIKE * self.h))
            around = np.column_stack([offsets, held[triangles]]) + 0.0
            distinct.setdefault(around[np.lexsort(around.T)].tobytes(), place)
        least = min(self._least_fourth(place, reached[[place]].indices) for place in distinct.values())
        return math.sqrt(self.h) * least**-0.25

    def _least_fourth(self, place: int, around: Array) -> float:
        """The least integral of psi^4 for psi = 1 at a free node and 0 beyond those around it, by Newton's method."""
        values, weights = self.quadrature
        values = sparse.csc_array(values)[:, self.free[around]]
        inside = np.unique(values.indices)
        values, weights = sparse.csr_array(values)[inside], weights[inside]
        psi, others = (around == place).astype(float), np.flatnonzero(around != place)
        last, integral = math.inf, weights @ (values @ psi) ** 4
        while last - integral > np.finfo(float).eps * integral and len(others):
            at = values @ psi
            slope = 4 * (values.T @ (weights * at**3))[others]
            bend = 12 * (values.T @ sparse.diags_array(weights * at**2) @ values).toarray()[np.ix_(others, others)]
            # Far from the node the Hessian vanishes with the function.
            bend += np.finfo(float).eps * np.trace(bend) * np.eye(len(others))
            step = np.zeros_like(psi)
            step[others] = -np.linalg.solve(bend, slope)
            moved = (psi + 0.5**k * step for k in range(20))
            psi = next((new for new in moved if weights @ (values @ new) ** 4 < integral), psi)
            last, integral = integral, weights @ (values @ psi) ** 4
        return float(integral)

    def c_t(self, axes: Array) -> float:
        """Lemma 3.2: |phi_t|_1 <= c |phi|_1 for nodal fields and axes of friction, [n, 2, 3]; 1 where they do not turn."""
        if (axes == axes[0]).all():
            return 1.0
        along = sparse.vstack([sparse.hstack([sparse.diags_array(axes[self.free, k, c]) for c in range(3)]) for k in range(2)])
        form = sparse.csc_array(along.T @ sparse.kron(np.eye(2), self.first) @ along)
        norm = sparse.csc_array(sparse.kron(np.eye(3), self.first))
        return math.sqrt(largest_ratio(form, norm, operator(factor(norm), norm.shape[0])))

    def c_r_absolute(self) -> float:
        """(3.3) for Lagrange's interpolation of |phi| with phi in Y^h, where (3.6) uses it, triangle by triangle.

        If phi is -1 at one corner and cuts the edges there at shares s and t, then |phi| less its interpolant is twice the
        negative part, whose norm is known. The square (0, 1]^2 of cuts is searched, then smaller ones around the best.
        """
        gram = self.geometry[0] @ self.geometry[0].transpose(0, 2, 1)
        gram = np.concatenate([np.roll(gram, (k, k), axis=(1, 2)) for k in range(3)])
        gram = np.unique(np.round(gram * self.h**2, 12), axis=0)
        centre, half, best = np.full((2, len(gram)), 0.5), 0.5, np.zeros(len(gram))
        for search in range(SEARCHES):
            offsets = half * np.linspace(-1, 1, GRID[min(search, 1)])
            s, t = (centre[:, :, None] + np.stack(np.meshgrid(offsets, offsets)).reshape(2, 1, -1)).clip(1e-9, 1.0)
            slopes = np.stack([np.full_like(s, -1.0), 1 / s - 1, 1 / t - 1])
            ratio = 2 / 3 * (1 - s * t * (3 - s - t)) / np.einsum("aij,iab,bij->ij", slopes, gram, slopes)
            place = (np.arange(len(gram)), ratio.argmax(axis=1))
            better = ratio[place] > best
            best, centre = np.where(better, ratio[place], best), np.where(better, [s[place], t[place]], centre)
            half *= 2 / (len(offsets) - 1)
        return math.sqrt(best.max())

    def c_r(self, parts: int, clement: bool) -> float:
        """(3.3) for Lagrange's interpolation, or for Clement's (3.19), on linear functions of triangles cut in parts^2."""
        fine, origin = self._cut(parts)
        coarse = sparse.csr_array(origin[fine.free][:, self.free])
        if clement:
            children = sparse.kron(sparse.diags_array(self.geometry[1]), np.full((1, parts**2), 1 / (3 * parts**2)))
            integrals = self.stars[self.free] @ children @ sparse.csr_array(fine.stars.T)[:, fine.free]
            values = sparse.diags_array(1 / (self.stars[self.free] @ self.geometry[1])) @ integrals
        else:
            values = (coarse == 1.0).astype(float).T
        error = sparse.csr_array(sparse.eye_array(len(fine.free)) - coarse @ values)
        form = operator(lambda v: error.T @ (fine.mass @ (error @ v)), len(fine.free))
        return math.sqrt(largest_ratio(form, fine.first, operator(factor(fine.first), len(fine.free)))) / self.h

    def _cut(self, parts: int) -> tuple["ContactFace", sparse.csr_array]:
        """The face with each triangle cut in equal ones, and its nodes in barycentric coordinates of ours, [fine n, n]."""
        lattice = np.array([(parts - i - j, i, j) for i in range(parts + 1) for j in range(parts + 1 - i)])
        number = {(i, j): place for place, (_, i, j) in enumerate(lattice.tolist())}
        upright = [[(i, j), (i + 1, j), (i, j + 1)] for i, j in number if i + j < parts]
        turned = [[(i + 1, j + 1), (i, j + 1), (i + 1, j)] for i, j in number if i + j < parts - 1]
        small = np.array([[number[corner] for corner in triangle] for triangle in upright + turned])
        # A node of the lattice is known by our nodes around it, each with its weight.
        known = np.where(lattice > 0, self.triangles[:, None] * (parts + 1) + lattice, -1)
        known.sort(axis=2)
        distinct, names = np.unique(known.reshape(-1, 3), axis=0, return_inverse=True)
        row, column = np.nonzero(distinct >= 0)
        node, weight = np.divmod(distinct[row, column], parts + 1)
        origin = sparse.csr_array((weight / parts, (row, node)), shape=(len(distinct), len(self.points)))
        triangles = names.reshape(len(self.triangles), -1)[:, small].reshape(-1, 3)
        free = np.flatnonzero(origin[:, self.free].sum(axis=1))
        return ContactFace(origin @ self.points, triangles, free), origin
