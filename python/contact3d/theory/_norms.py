"""Constants in a norm of displacements, the radii of Lemma 3.3 and the contraction bound (3.13)."""

import math
from dataclasses import dataclass
from functools import cached_property

import numpy as np
from scipy import sparse
from scipy.linalg import cho_factor, cho_solve

from ._forms import Array, Solve, factor, largest_eigenvalue, largest_ratio, operator
from ._problem import Problem
from ._results import FaceConstants, LawConstants, NormConstants

#: Nodes whose point loads start an ascent for c_tr(4), steps of one, and the growth at which it ends.
POINT_STARTS = 6
ASCENT_STEPS = 500
ASCENT_TOLERANCE = 1e-12


@dataclass(frozen=True)
class DisplacementNorm:
    """|v|^2 = v'Xv on V^h: that of H1(Omega)^3, or the energy norm with X = A.

    :param matrix: X; :param solve: b -> X^-1 b.
    """

    problem: Problem
    matrix: sparse.csc_array
    solve: Solve

    @cached_property
    def gram(self) -> Array:
        """E X^-1 E' on the contact face."""
        return self.problem.gram(self.solve)

    def normal(self, integrals: Array) -> Array:
        """Q = N X^-1 N' of multipliers by their integrals with hat functions: mu'Q mu = sup (mu, v_nu)^2 / |v|^2 over V^h."""
        return integrals @ self.gram[::3, ::3] @ integrals.T

    @cached_property
    def glued(self) -> Array:
        """|mu|^2_*,h over V_0^h, displacements without tangential part on the face, which the proofs of Lemma 3.3 and
        Proposition 3.1 use: Q in H1(Omega)^3, and less in the energy norm, which couples components."""
        integrals = self.problem.integrals
        tangential = np.flatnonzero((np.arange(len(self.gram)) % 3 > 0) & (np.diag(self.gram) > 0))
        cross = self.gram[np.ix_(tangential, range(0, len(self.gram), 3))] @ integrals.T
        block = cho_factor(self.gram[np.ix_(tangential, tangential)])
        form = self.normal(integrals) - cross.T @ cho_solve(block, cross)
        return (form + form.T) / 2

    def alpha(self) -> float:
        """(2.6) on V^h: a(v, v) >= alpha |v|^2."""
        problem = self.problem
        solve = operator(problem.solve_stiffness, len(problem.load))
        return 1.0 if self.matrix is problem.stiffness else 1 / largest_ratio(self.matrix, problem.stiffness, solve)

    def continuity(self) -> float:
        """M of (2.7) on V^h."""
        stiffness = self.problem.stiffness
        return 1.0 if self.matrix is stiffness else largest_ratio(stiffness, self.matrix, operator(self.solve, len(self.problem.load)))

    def load(self) -> float:
        """|l|_* on V^h."""
        return math.sqrt(self.problem.load @ self.solve(self.problem.load))

    def c_inv_half(self) -> float:
        """(3.16): |mu|_0 <= c / sqrt(H) |mu|_*,h, over V_0^h."""
        return math.sqrt(self.problem.big_h * largest_eigenvalue(np.diag(self.problem.areas), self.glued))

    def c_tr_2(self) -> float:
        """|v|_0 <= c |v| on the contact face."""
        return self._trace([0, 1, 2], self.problem.face.mass)

    def tangential_trace(self) -> float:
        """|v_t|_0 <= c |v|."""
        return self._trace([1, 2], self.problem.face.mass)

    def interpolated_trace(self) -> float:
        """|(r_h|v_t1|, r_h|v_t2|)|_0 <= c |v| for Lagrange's r_h: the lumped mass bounds the norm of nodal values of any sign."""
        face = self.problem.face
        return self._trace([1, 2], sparse.diags_array((face.stars @ face.geometry[1])[face.free] / 3))

    def _trace(self, components: list[int], mass: sparse.sparray) -> float:
        """The root of the largest ratio of a mass of components of v on the face and |v|^2."""
        rows = (3 * self.problem.face.free[:, None] + components).ravel()
        mass = sparse.csc_array(sparse.kron(mass, np.eye(len(components))))
        # The eigenvalues of M v = theta G^-1 v are those of G v = theta M^-1 v.
        return math.sqrt(largest_ratio(self.gram[np.ix_(rows, rows)], operator(factor(mass), len(rows)), mass))

    @cached_property
    def peaks(self) -> Array:
        """sup |v(x)|^2 / |v|^2 at each contact node: the largest eigenvalue of its block."""
        nodes = np.arange(len(self.gram) // 3)
        return np.linalg.eigvalsh(self.gram.reshape(len(nodes), 3, -1, 3)[nodes, :, nodes])[:, -1]

    def c_tr_4(self) -> float:
        """|v|_0,4 <= c |v| on the face: the best local maximum of ascents from several starts, so a lower bound.

        The step v <- X^-1 f'(v), normed, increases the convex f = |v|_0,4^4.
        """
        count = len(self.peaks)
        starts = [np.tile(part, (count, 1)) for part in np.eye(3)]
        # Nodes from the softest to the hardest, equal ones in their order.
        for node in np.lexsort((np.arange(count), -self.peaks))[:: -(-count // POINT_STARTS)]:
            starts.append(np.zeros((count, 3)))
            starts[-1][node, 0] = 1.0
        return max(map(self._ascend, starts)) ** 0.25

    def _ascend(self, forces: Array) -> float:
        """The integral of |v|^4 over |v| = 1 on the way up from nodal forces."""
        values, weights = self.problem.face.quadrature
        last = 0.0
        for _ in range(ASCENT_STEPS):
            forces = forces / np.linalg.norm(forces)
            moved = (self.gram @ forces.ravel()).reshape(-1, 3)
            work = np.sum(moved * forces)
            if not work > 0:
                break
            at = values @ (moved / math.sqrt(work))
            square = np.sum(at**2, axis=1)
            value = weights @ square**2
            if value - last <= ASCENT_TOLERANCE * value:
                return max(value, last)
            last, forces = value, values.T @ ((weights * square)[:, None] * at)
        return last

    def constants(self, face: FaceConstants, law: LawConstants) -> NormConstants:
        """All of them, the radii of Lemma 3.3 and the bounds of the Lipschitz modulus of Psi."""
        problem = self.problem
        alpha, continuity, load, c_tr_2, c_tr_4 = self.alpha(), self.continuity(), self.load(), self.c_tr_2(), self.c_tr_4()
        c_inv_half, max_trace = self.c_inv_half(), math.sqrt(self.peaks.max())
        lagrange, tangential = self.interpolated_trace(), self.tangential_trace()
        # |(r_h|v_t1|, r_h|v_t2|)|_0 <= image |v| by (3.6). Constants are interpolated exactly, so the inverse inequality of the
        # gradient alone serves as well, whatever the unit of length: c_inv(1,0)^2 is its square and h^2.
        image, gradient_image = (c_tr_2 * (inverse * face.c_r_absolute * face.c_t + 1) for inverse in
                                 (face.c_inv_10, math.sqrt(face.c_inv_10**2 - face.h**2)))
        radius_pressure = (1 + continuity / alpha) * load
        max_by_fourth = face.c_inv_infinity / math.sqrt(face.h) * c_tr_4
        slope = law.lipschitz * (2 + law.kappa)

        def moved(coefficient: float, slope: float, trace: float, largest: float) -> Array:
            """(a, b) of |u - u'| <= a |g - g'|_* + b |phi - phi'|_0, from (3.15) and (3.18)."""
            return c_inv_half / math.sqrt(face.big_h) / alpha * np.array([coefficient * trace, slope * largest * radius_pressure])

        usual, composed = moved(law.f_max, slope, c_tr_2, max_by_fourth), moved(law.f_max, slope, tangential, max_trace)
        # On panes |F - F'| of the means (4.2) is at most (F_max / F_min)^2 L times the mean of |phi - phi'| at corners, and the
        # linear function of the lengths of vectors at corners has at most twice the norm of that of the vectors themselves. So
        # has the lumped norm of nodal multipliers.
        factors = (2.0, 2.0) if problem.panes is None else (1.0, 2 * (law.f_max / law.f_min) ** 2)
        averaged = moved(factors[0] * law.f_max, factors[1] * slope, c_tr_2, max_by_fourth)
        return NormConstants(
            alpha, continuity, load, c_inv_half, c_tr_2, c_tr_4, max_trace, lagrange, tangential,
            radius_slip=image * load / alpha,
            radius_pressure=radius_pressure,
            q=float((image + continuity) * usual.max()),
            q_weighted=float(usual @ [continuity, gradient_image]),
            q_composed=float(composed @ [continuity, lagrange]),
            q_averaged=float(averaged @ [continuity, gradient_image]),
        )
