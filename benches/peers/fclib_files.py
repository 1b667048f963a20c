"""Local problems of FCLIB, read and written with h5py, and the error of their solutions.

In a triplet matrix (nz >= 0) p holds columns and i rows, as FCLIB's own code has it.
"""

from dataclasses import dataclass
from pathlib import Path

import h5py
import numpy as np
from scipy import sparse


@dataclass(frozen=True)
class LocalProblem:
    """u = W r + q, components N, T1, T2 contact after contact, Coulomb's law with mu."""

    matrix: sparse.csc_matrix
    offset: np.ndarray
    mu: np.ndarray


def read_matrix(group: h5py.Group) -> sparse.csc_matrix:
    """A matrix of any of the three storages."""
    shape = (int(group["m"][0]), int(group["n"][0]))
    nz = int(group["nz"][0])
    p, i, x = group["p"][:], group["i"][:], group["x"][:]
    if nz == -1:
        return sparse.csc_matrix((x, i, p), shape)
    if nz == -2:
        return sparse.csc_matrix(sparse.csr_matrix((x, i, p), shape))
    return sparse.csc_matrix(sparse.coo_matrix((x[:nz], (i[:nz], p[:nz])), shape))


def read_local(path: Path) -> LocalProblem:
    """The problem of a file."""
    with h5py.File(path, "r") as file:
        group = file["fclib_local"]
        vectors = group["vectors"]
        return LocalProblem(read_matrix(group["W"]), vectors["q"][:], vectors["mu"][:])


def read_solution(path: Path) -> tuple[np.ndarray, np.ndarray]:
    """r and u of a file."""
    with h5py.File(path, "r") as file:
        return file["solution/r"][:], file["solution/u"][:]


def write_local(path: Path, problem: LocalProblem, title: str) -> None:
    """A file with the problem, W by compressed columns."""
    matrix = sparse.csc_matrix(problem.matrix)
    matrix.sort_indices()
    with h5py.File(path, "w") as file:
        group = file.create_group("fclib_local")
        group["spacedim"] = np.array([3], dtype=np.int32)
        stored = group.create_group("W")
        for name, value in (
            ("nzmax", matrix.nnz),
            ("m", matrix.shape[0]),
            ("n", matrix.shape[1]),
            ("nz", -1),
        ):
            stored[name] = np.array([value], dtype=np.int32)
        stored["p"] = matrix.indptr.astype(np.int32)
        stored["i"] = matrix.indices.astype(np.int32)
        stored["x"] = matrix.data
        vectors = group.create_group("vectors")
        vectors["q"], vectors["mu"] = problem.offset, problem.mu
        group.create_group("info")["title"] = np.bytes_(title)


def cone_projection(points: np.ndarray, mu: np.ndarray) -> np.ndarray:
    """The nearest points of the cones |x_T| <= mu x_N, rows N, T1, T2."""
    normal, tangential = points[:, 0], np.hypot(points[:, 1], points[:, 2])
    height = (normal + mu * tangential) / (1.0 + mu**2)
    with np.errstate(invalid="ignore", divide="ignore"):
        share = mu * height / tangential
    surface = np.column_stack([height, points[:, 1] * share, points[:, 2] * share])
    inside = (tangential <= mu * normal)[:, None]
    polar = (mu * tangential <= -normal)[:, None]
    return np.where(polar, 0.0, np.where(inside, points, surface))


def natural_map_error(problem: LocalProblem, force: np.ndarray) -> float:
    """|r - P(r - u^)| / max(|q|, |r|, |u|) with u^ = u + (mu |u_T|, 0, 0), as Siconos 4.4 has it."""
    u = (problem.matrix @ force + problem.offset).reshape(-1, 3)
    r = force.reshape(-1, 3)
    size = max(map(np.linalg.norm, (problem.offset, r, u)))
    u[:, 0] += problem.mu * np.hypot(u[:, 1], u[:, 2])
    residual = np.linalg.norm(r - cone_projection(r - u, problem.mu))
    return residual / size if size > 0.0 else residual
