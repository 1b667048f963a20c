"""Condition (3.1) and the Babuska-Brezzi constant of HKL section 3.2 for several spaces of multipliers on a brick."""

import math
from collections.abc import Callable

import numpy as np
from scipy.linalg import eigh

from ._face import ContactFace
from ._forms import Array, largest_eigenvalue
from ._norms import DisplacementNorm
from ._results import MultiplierSpace


def multiplier_spaces(here: DisplacementNorm, finest: DisplacementNorm | None) -> tuple[MultiplierSpace, ...]:
    """Constants on pieces of 1, 4 and 16 cells (FE2) where they fit, and continuous linear functions (FE1)."""
    face = here.problem.face
    spaces = [(f"{width} x {width} cells", *found) for width in (1, 2, 4) if (found := _boxes(here, width))]
    spaces.append(("linear", face.h, face.mass.toarray(), lambda other: _hats(face, other)))
    return tuple(_stability(*space, here, finest) for space in spaces)


def _stability(space: str, size: float, mass: Array, integrals: Callable[[ContactFace], Array], here: DisplacementNorm,
               finest: DisplacementNorm | None) -> MultiplierSpace:
    """A space of a size H by its mass matrix and the integrals of its functions with the hat functions of any face."""
    norm = here.normal(integrals(here.problem.face))
    smallest = float(eigh(norm, mass, eigvals_only=True, subset_by_index=[0, 0])[0])
    # beta^2 is the least |mu|^2_*,h here over that on the finest mesh.
    finer = None if finest is None else finest.normal(integrals(finest.problem.face))
    beta = None if finer is None else 1 / math.sqrt(largest_eigenvalue(finer, norm))
    c_inv_half = math.sqrt(size / smallest) if smallest > 0 else math.inf
    return MultiplierSpace(space, size / here.problem.face.h, smallest, c_inv_half, beta)


def _boxes(here: DisplacementNorm, width: int) -> tuple[float, Array, Callable[[ContactFace], Array]] | None:
    """Pieces of width^2 cells of the brick; None where they do not fit."""
    across = int(np.abs(here.problem.frame[0, 0]).argmax())
    axes = [axis for axis in range(3) if axis != across]
    planes = [np.unique(here.problem.run["mesh/coordinates"].values[:, axis]) for axis in axes]
    if any((len(part) - 1) % width for part in planes):
        return None
    planes = [part[::width] for part in planes]

    def boxes(face: ContactFace) -> Array:
        """The piece of each triangle."""
        centres = face.points[face.triangles].mean(axis=1)
        first, second = (np.searchsorted(part, centres[:, axis]) for axis, part in zip(axes, planes, strict=True))
        return second * (len(planes[0]) + 1) + first

    used = np.unique(boxes(here.problem.face))

    def integrals(face: ContactFace) -> Array:
        found = np.zeros((len(used), len(face.points)))
        np.add.at(found, (np.searchsorted(used, boxes(face))[:, None], face.triangles), face.geometry[1][:, None] / 3)
        return found

    areas = integrals(here.problem.face).sum(axis=1)
    return math.hypot(*(np.diff(part).max() for part in planes)), np.diag(areas), integrals


def _hats(coarse: ContactFace, face: ContactFace) -> Array:
    """The integrals of products of the free hat functions of a face with those of one that is nested in it."""
    offsets = face.points[:, None] - coarse.points[coarse.triangles[:, 0]]
    values = np.einsum("tac,ntc->nta", coarse.geometry[0], offsets) + np.eye(3)[0]
    # The triangle in which the least barycentric coordinate of a point is largest holds it.
    triangle, nodes = values.min(axis=2).argmax(axis=1), np.arange(len(face.points))
    hats = np.zeros((len(nodes), len(coarse.points)))
    np.put_along_axis(hats, coarse.triangles[triangle], values[nodes, triangle], axis=1)
    at, weights = face.quadrature
    return hats[:, coarse.free].T @ (at.T @ (weights[:, None] * at.toarray()))
