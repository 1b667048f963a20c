"""A stress that balances all loads, made again from the forces on the sides of tetrahedra."""

from itertools import combinations

import numpy as np

VOIGT = [(0, 0), (1, 1), (2, 2), (1, 2), (0, 2), (0, 1)]
SIDES = [[1, 2, 3], [0, 2, 3], [0, 1, 3], [0, 1, 2]]
EDGES = [[0, 1], [1, 2], [0, 2], [0, 3], [1, 3], [2, 3]]
MEAN_PRODUCT = (np.ones((4, 4)) + np.eye(4)) / 20
"""Means of the products of barycentric coordinates over a tetrahedron."""


def gradients(points):
    """Gradients of the barycentric coordinates, [4, 3]."""
    return np.linalg.inv(np.hstack([np.ones((4, 1)), points]))[1:].T


def isotropic(young, poisson):
    """The elasticity matrix of engineering strains."""
    lame, shear = young * poisson / ((1 + poisson) * (1 - 2 * poisson)), young / (2 * (1 + poisson))
    matrix = np.diag([2 * shear] * 3 + [shear] * 3)
    matrix[:3, :3] += lame
    return matrix


def strains(points, tetrahedra, middles, displacement):
    """Engineering strains at the corners of quadratic tetrahedra, [n, 4, 6]."""
    found = np.zeros((len(tetrahedra), 4, 6))
    for t, corners in enumerate(tetrahedra):
        slopes = gradients(points[corners])
        for k, at in enumerate(np.eye(4)):
            gradient = sum((4 * at[a] - 1) * np.outer(displacement[n], slopes[a]) for a, n in enumerate(corners))
            for (a, b), n in zip(EDGES, middles[t]):
                gradient = gradient + 4 * np.outer(displacement[n], at[a] * slopes[b] + at[b] * slopes[a])
            sym = gradient + gradient.T
            found[t, k] = [sym[i, j] / (2 if i == j else 1) for i, j in VOIGT]
    return found


def area_vector(triangle, inside):
    """Of a triangle, away from a point."""
    area = np.cross(triangle[1] - triangle[0], triangle[2] - triangle[0]) / 2
    return area if area @ (triangle[0] - inside) > 0 else -area


def stress_rows(part, corner, normal):
    """The traction on a normal at a corner of a part, as rows over the 96 values."""
    rows = np.zeros((3, 96))
    for c, (i, j) in enumerate(VOIGT):
        place = (part * 4 + corner) * 6 + c
        rows[i, place] += normal[j]
        if i != j:
            rows[j, place] += normal[i]
    return rows


def balanced_stress(points, forces, body_force):
    """Values of the stress at the corners of the four parts, [4, 4, 6], with the residual of its equations.

    Each part lies between a side and the centroid. ``forces`` [4, 3, 3] are the integrals of hat functions times the outward traction.
    """
    centroid = points.mean(axis=0)
    rows, right = [], []
    for part, side in enumerate(SIDES):
        area = area_vector(points[side], points[part])
        size = np.linalg.norm(area)
        traction = (12 * forces[part] - 3 * forces[part].sum(axis=0)) / size
        for k in range(3):
            rows.append(stress_rows(part, k, area / size))
            right.append(traction[k])
        slopes = gradients(np.vstack([points[side], centroid]))
        scale = np.abs(points - centroid).max()
        rows.append(scale * sum(stress_rows(part, k, slopes[k]) for k in range(4)))
        right.append(-scale * body_force)
    for part, other in combinations(range(4), 2):
        shared = [k for k in range(4) if k not in (part, other)]
        normal = np.cross(points[shared[0]] - centroid, points[shared[1]] - centroid)
        normal /= np.linalg.norm(normal)
        for corner in [*shared, None]:
            places = [3 if corner is None else SIDES[p].index(corner) for p in (part, other)]
            rows.append(stress_rows(part, places[0], normal) - stress_rows(other, places[1], normal))
            right.append(np.zeros(3))
    rows, right = np.vstack(rows), np.concatenate(right)
    values = np.linalg.lstsq(rows, right, rcond=None)[0]
    return values.reshape(4, 4, 6), np.abs(rows @ values - right).max()


def distance(points, balanced, strain, elasticity):
    """The squared norm of balanced stress less that of a strain, linear between the corners, in the compliance."""
    volume = abs(np.linalg.det(points[1:] - points[0])) / 6
    own = strain @ elasticity
    total = 0.0
    for part, side in enumerate(SIDES):
        apart = balanced[part] - np.vstack([own[side], own.mean(axis=0)])
        total += volume / 4 * np.einsum("ab,ai,ij,bj", MEAN_PRODUCT, apart, np.linalg.inv(elasticity), apart)
    return total
