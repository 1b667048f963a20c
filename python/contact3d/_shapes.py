"""Faces without names: the boundary split at its edges, and what each part is: a plane, a cylinder or another shape."""

import numpy as np
from scipy.optimize import least_squares
from scipy.sparse import coo_array
from scipy.sparse.csgraph import connected_components

#: Distances to a plane or a cylinder that rounding in a mesh file explains, in relation to the size of the part.
FIT_TOLERANCE = 1e-4


def split(points: np.ndarray, triangles: np.ndarray, angle: float) -> list[np.ndarray]:
    """The parts of a surface whose neighbouring triangles meet at less than an angle in degrees, the largest area first.

    :param triangles: corners, seen from outside, [n, 3].
    """
    normals = _normals(points, triangles)
    edges = np.sort(triangles[:, [(0, 1), (1, 2), (2, 0)]].reshape(-1, 2), axis=1)
    order = np.lexsort(edges.T)
    same = np.flatnonzero((edges[order][1:] == edges[order][:-1]).all(axis=1))
    first, second = order[same] // 3, order[same + 1] // 3
    lengths = np.linalg.norm(normals, axis=1)
    cosines = (normals[first] * normals[second]).sum(axis=1) / (lengths[first] * lengths[second])
    is_smooth = cosines > np.cos(np.radians(angle))
    links = (np.ones(is_smooth.sum()), (first[is_smooth], second[is_smooth]))
    _, part = connected_components(coo_array(links, shape=(len(triangles), len(triangles))), directed=False)
    parts = [np.flatnonzero(part == root) for root in np.unique(part)]
    return sorted(parts, key=lambda members: -lengths[members].sum().round(12))


def describe(points: np.ndarray, triangles: np.ndarray) -> str:
    """A plane with its normal, a cylinder with radius and axis, or another shape; and the box that holds it."""
    nodes = points[np.unique(triangles)]
    normals = _normals(points, triangles)
    box = f"x, y, z from {_text(nodes.min(axis=0))} to {_text(nodes.max(axis=0))}"
    middle = nodes.mean(axis=0)
    size = np.linalg.norm(np.ptp(nodes, axis=0))
    normal = normals.sum(axis=0)
    normal /= np.linalg.norm(normal) or 1.0
    if np.abs((nodes - middle) @ normal).max() <= FIT_TOLERANCE * size:
        return f"plane, outward normal {_text(normal)}, {box}"
    # A cylinder has three parameters more than six nodes determine.
    if len(nodes) > 6 and (fit := _cylinder(nodes - middle, normals)) is not None:
        centre, axis, radius = fit
        where = f"axis {_text(axis)} through {_text(middle + centre)}"
        return f"cylinder, radius {_text(radius)}, {where}, {box}"
    return f"other, {box}"


def _normals(points: np.ndarray, triangles: np.ndarray) -> np.ndarray:
    """Normals with the length of the area."""
    a, b, c = (points[triangles[:, n]] for n in range(3))
    return np.cross(b - a, c - a) / 2.0


def _cylinder(nodes: np.ndarray, normals: np.ndarray) -> tuple[np.ndarray, np.ndarray, float] | None:
    """Centre, axis and radius of the cylinder that the nodes lie on, by least squares from the axis that normals leave out."""
    _, frame = np.linalg.eigh(normals.T @ normals)
    frame = frame[:, [1, 2, 0]]
    x, y, z = (nodes @ frame).T
    # A circle in the plane across: x² + y² = 2 a x + 2 b y + c.
    (a, b, c), *_ = np.linalg.lstsq(np.column_stack([2 * x, 2 * y, np.ones_like(x)]), x**2 + y**2, rcond=None)

    def axis(slopes: np.ndarray) -> np.ndarray:
        return np.array([*slopes, 1.0]) / np.sqrt(1.0 + slopes @ slopes)

    def distances(unknowns: np.ndarray) -> np.ndarray:
        away = np.cross(np.column_stack([x - unknowns[0], y - unknowns[1], z]), axis(unknowns[3:]))
        return np.linalg.norm(away, axis=1) - unknowns[2]

    fit = least_squares(distances, [a, b, np.sqrt(max(c + a**2 + b**2, 0.0)), 0.0, 0.0], x_scale="jac", xtol=1e-14)
    radius, size = fit.x[2], np.abs(nodes).max()
    if not (np.abs(fit.fun).max() <= FIT_TOLERANCE * radius and radius < 10 * size):
        return None
    direction, centre = frame @ axis(fit.x[3:]), frame[:, :2] @ fit.x[:2]
    direction *= np.sign(direction[np.abs(direction).argmax()])
    return centre - direction * (direction @ centre), direction, float(radius)


def _text(value: np.ndarray | float) -> str:
    """Numbers with six digits of the largest."""
    values = np.atleast_1d(value)
    largest = np.abs(values).max()
    decimals = 6 if largest == 0.0 else int(np.clip(5 - np.floor(np.log10(largest)), 0, 15))
    return ", ".join(f"{round(float(v), decimals) + 0.0:.12g}" for v in values)
