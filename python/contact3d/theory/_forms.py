"""Forms of linear elements, and extreme eigenvalues."""

import math
from collections.abc import Callable
from typing import Any

import numpy as np
from scipy import sparse
from scipy.linalg import eigh
from scipy.sparse.linalg import LinearOperator, eigsh, splu

Array = np.ndarray
#: A symmetric matrix: an array, a sparse matrix or an operator.
Form = Any
Solve = Callable[[Array], Array]

#: Eigenvalue problems up to this size are solved densely, in a few milliseconds.
DENSE_SIZE = 300
#: Relative residual of a Ritz pair at which Lanczos' method ends; the error of the eigenvalue is about its square.
RITZ_TOLERANCE = 1e-8
#: Vectors that Lanczos' method keeps between restarts.
KRYLOV_SIZE = 60


def simplex_gradients(points: Array, simplices: Array) -> tuple[Array, Array]:
    """Gradients of the barycentric coordinates of triangles or tetrahedra, [t, corners, 3], and their measures, [t]."""
    edges = points[simplices[:, 1:]] - points[simplices[:, :1]]
    gram = edges @ edges.transpose(0, 2, 1)
    inner = np.linalg.solve(gram, edges)
    measures = np.sqrt(np.linalg.det(gram)) / math.factorial(edges.shape[1])
    return np.concatenate([-inner.sum(axis=1, keepdims=True), inner], axis=1), measures


def scalar_forms(points: Array, simplices: Array) -> tuple[sparse.csc_array, sparse.csc_array]:
    """Mass and stiffness of continuous functions that are linear on simplices, over all points."""
    gradients, measures = simplex_gradients(points, simplices)
    corners = simplices.shape[1]
    mass = (np.ones((corners, corners)) + np.eye(corners)) / (corners * (corners + 1))
    places = (np.repeat(simplices, corners, axis=1).ravel(), np.tile(simplices, corners).ravel())

    def assembled(local: Array) -> sparse.csc_array:
        entries = (measures[:, None, None] * local).ravel()
        return sparse.csc_array((entries, places), shape=(len(points),) * 2)

    return assembled(mass), assembled(gradients @ gradients.transpose(0, 2, 1))


def factor(matrix: sparse.csc_array, order: Array | None = None) -> Solve:
    """b -> X^-1 b for a symmetric positive definite X, with a fill-reducing order if one is known."""
    options = {"diag_pivot_thresh": 0.0, "options": {"SymmetricMode": True}}
    if order is None:
        return splu(sparse.csc_array(matrix), permc_spec="MMD_AT_PLUS_A", **options).solve
    lu, back = splu(sparse.csc_array(matrix[order][:, order]), permc_spec="NATURAL", **options), np.argsort(order)
    return lambda rhs: lu.solve(rhs[order])[back]


def operator(product: Solve, size: int) -> LinearOperator:
    """A symmetric matrix by its products."""
    return LinearOperator((size, size), matvec=product, matmat=product, dtype=float)


def largest_ratio(form: Form, norm: Form, inverse: Form) -> float:
    """sup v'Xv / v'Yv, the largest eigenvalue of X v = theta Y v, from products with X, Y and Y^-1."""
    size = form.shape[0]
    if size <= DENSE_SIZE:
        return largest_eigenvalue(*((part + part.T) / 2 for part in (form @ np.eye(size), norm @ np.eye(size))))
    start = np.random.default_rng(1).standard_normal(size)
    options = {"v0": start, "ncv": KRYLOV_SIZE, "tol": RITZ_TOLERANCE, "return_eigenvectors": False}
    return float(eigsh(form, 1, norm, which="LA", Minv=inverse, **options)[0])


def largest_eigenvalue(form: Array, norm: Array | None = None) -> float:
    """The largest eigenvalue of X v = theta Y v for dense matrices; 0 for empty ones."""
    last = len(form) - 1
    return 0.0 if last < 0 else float(eigh(form, norm, eigvals_only=True, subset_by_index=[last, last])[0])


def root(form: Array) -> Array:
    """A rectangular R with R R' = X for a semidefinite X, without the directions that rounding alone gives it."""
    values, vectors = np.linalg.eigh(form)
    kept = values > len(values) * np.finfo(float).eps * values.max(initial=0.0)
    return vectors[:, kept] * np.sqrt(values[kept])
