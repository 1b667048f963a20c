"""Two bodies that touch, recomputed from the nodes, tetrahedra and triangles of their run files.

Nothing of the program's own coupling is used: triangles of both faces are clipped against each other here, products of shape functions
integrated by another rule, normals weighted, the elastic stiffness assembled. What a file says has to agree, and its solution has to
satisfy equilibrium of each body, the conditions of contact and the law of friction.

    python3 python-checks/pairs.py --scenes 200 --seed 1

solves random scenes of two bodies and counts those with something wrong.
"""

import os
import sys
import tempfile
from collections import Counter
from dataclasses import dataclass
from pathlib import Path

os.environ.setdefault("OPENBLAS_NUM_THREADS", "1")

if __package__ in (None, ""):
    sys.path[0] = str(Path(__file__).resolve().parent)
sys.path.insert(0, str(Path(__file__).resolve().parent.parent / "scripts"))

from campaign import arguments, require

require("blake3", "h5py", "numpy", "scipy")

import h5py
import numpy as np
from scipy import sparse
from scipy.optimize import linprog

from faults.program import Program
from run_file import facet_faces, open_run, read_enum, read_matrix, read_scene
from structured_mesh import mesh_text

FLAT = 1e-12
"""Relative error of integrals of polynomials."""
CURVED = 2e-4
"""The same over curved pieces, where two rules of quadrature differ."""
CONDITIONS = 1e-8
"""Of the largest displacement: gaps of solutions that are accurate to 1e-12 of their stresses."""
REACH = 1.0
"""Faces farther apart than they are wide do not see each other."""
SOLVED = ("converged", "machine_precision", "reduced_accuracy")


def triangle_shape(at: np.ndarray, n_nodes: int) -> np.ndarray:
    """Shape functions of 3 or 6 nodes at barycentric places [..., 3]."""
    if n_nodes == 3:
        return at
    a, b, c = np.moveaxis(at, -1, 0)
    parts = [a * (2 * a - 1), b * (2 * b - 1), c * (2 * c - 1), 4 * a * b, 4 * b * c, 4 * c * a]
    return np.stack(parts, axis=-1)


def triangle_slopes(at: np.ndarray, n_nodes: int) -> np.ndarray:
    """Their derivatives along the second and third coordinate, the first being one less both, [..., 2, n_nodes]."""
    a, b, c = np.moveaxis(at, -1, 0)
    o = np.zeros_like(a)
    if n_nodes == 3:
        rows = [[o - 1, o + 1, o], [o - 1, o, o + 1]]
    else:
        rows = [
            [1 - 4 * a, 4 * b - 1, o, 4 * (a - b), 4 * c, -4 * c],
            [1 - 4 * a, o, 4 * c - 1, -4 * b, 4 * b, 4 * (a - c)],
        ]
    return np.stack([np.stack(row, axis=-1) for row in rows], axis=-2)


def gauss(degree_points: int = 5) -> tuple[np.ndarray, np.ndarray]:
    """Barycentric places and weights on a triangle, which sum to 1: Gauss points of a square that is folded."""
    x, w = np.polynomial.legendre.leggauss(degree_points)
    x, w = (x + 1) / 2, w / 2
    u, v = np.meshgrid(x, x, indexing="ij")
    weights = 2 * np.outer(w * (1 - x), w).ravel()
    b, c = u.ravel(), ((1 - u) * v).ravel()
    return np.stack([1 - b - c, b, c], axis=-1), weights


POINTS, WEIGHTS = gauss()


class Face:
    """One of two faces: its triangles with their nodes, normals at nodes, and the modulus behind it."""

    def __init__(self, mesh: h5py.Group, name: str, modulus: float):
        on = np.flatnonzero(facet_faces(mesh) == name)
        nodes = mesh["facets"][:][on]
        if "facet_mid_edges" in mesh:
            nodes = np.hstack([nodes, mesh["facet_mid_edges"][:][on]])
        self.facets, self.nodes, self.modulus = on, nodes, modulus
        self.x = mesh["coordinates"][:]
        corners = self.x[nodes[:, :3]]
        self.area_vectors = np.cross(corners[:, 1] - corners[:, 0], corners[:, 2] - corners[:, 0]) / 2
        self.areas = np.linalg.norm(self.area_vectors, axis=1)
        n = nodes.shape[1]
        corner = np.eye(3)
        own = np.vstack([corner, (corner + np.roll(corner, -1, axis=0)) / 2])[:n]
        slopes = triangle_slopes(own, n)
        self.normals = np.zeros_like(self.x)
        ways = [np.roll(corners, -k, axis=1) - corners for k in (1, 2)]
        ways = [way / np.linalg.norm(way, axis=2)[:, :, None] for way in ways]
        angles = np.full(nodes.shape, np.pi)
        angles[:, :3] = np.arccos((ways[0] * ways[1]).sum(axis=2))
        for at, angle in zip(nodes, angles, strict=True):
            along = slopes @ self.x[at]
            normals = np.cross(along[:, 0], along[:, 1])
            normals /= np.linalg.norm(normals, axis=1)[:, None]
            np.add.at(self.normals, at, angle[:, None] * normals)
        with np.errstate(invalid="ignore"):
            self.normals /= np.linalg.norm(self.normals, axis=1)[:, None]
        self.units = self.area_vectors / self.areas[:, None]
        self.is_flat = np.abs(self.units - self.units[0]).max() < 1e-6
        middles = (corners + np.roll(corners, -1, axis=1)) / 2
        off = np.abs(self.x[nodes[:, 3:]] - middles).max() if n == 6 else 0.0
        self.is_faceted = not self.is_flat and off < 1e-9 * np.sqrt(self.areas.max())
        if self.is_faceted:
            means = self.normals.copy()
            for node in np.unique(nodes[:, :3]):
                self.normals[node] = self.fitted(node, means[node])
            for at in nodes if n == 6 else []:
                sums = self.normals[at[:3]] + self.normals[np.roll(at[:3], -1)]
                self.normals[at[3:]] = sums / np.linalg.norm(sums, axis=1)[:, None]

    def fitted(self, node: int, normal: np.ndarray) -> np.ndarray:
        """The normal of the quadratic through a corner that fits the corners of two rings of triangles; the mean on edges of the body."""
        corners = self.nodes[:, :3]
        own = np.flatnonzero((corners == node).any(axis=1))
        smooth = self.units @ self.units.T > np.cos(np.pi / 6)
        if not smooth[np.ix_(own, own)].all():
            return normal
        near = set()
        for k in own:
            beside = np.isin(corners, corners[k]).any(axis=1) & smooth[k]
            near |= set(corners[beside].ravel())
        near = sorted(near - {node})
        if len(near) < 5:
            return normal
        ways = self.x[near] - self.x[node]
        size = np.linalg.norm(ways, axis=1).max()
        around = 0.0
        for _ in range(5):
            across = np.linalg.svd(normal[None])[2][1:]
            (x, z), y = across @ ways.T / size, ways @ normal / size
            terms = np.stack([x, z, x * x, np.sqrt(2) * x * z, z * z], axis=1)
            found = np.linalg.lstsq(terms, y - around * y * y / 2, rcond=1e-6)[0]
            square, both = 4 * found[2:] @ found[2:], 2 * (found[2] + found[4])
            around = square / both if both * both > square / 4 else 0.0
            normal = normal - found[:2] @ across
            normal /= np.linalg.norm(normal)
        return normal

    def bulge(self, k: int, at: np.ndarray) -> float:
        """How far the curved face that a triangle stands for lies outside it, by the normals of its corners."""
        x, n = self.x[self.nodes[k]], self.normals[self.nodes[k, :3]]
        along = triangle_slopes(np.eye(3), self.nodes.shape[1]) @ x
        own = np.cross(along[:, 0], along[:, 1])
        turned = (n * own).sum(axis=1) < np.cos(np.radians(15.0)) * np.linalg.norm(own, axis=1)
        if self.is_flat or turned.any():
            return 0.0
        edges = ((0, 1), (1, 2), (2, 0))
        if self.is_faceted:
            return sum(at[a] * at[b] * (x[b] - x[a]) @ (n[b] - n[a]) / 2 for a, b in edges)
        slope = [max(((3 * x[i] + x[j] - 4 * x[3 + e]) @ n[i] for i, j in ((b, a), (a, b))), key=abs) for e, (a, b) in enumerate(edges)]
        whole = sum(c * at[a] * at[b] * (at[a] - at[b]) ** 2 for c, (a, b) in zip(slope, edges, strict=True))
        return whole + at.prod() * sum(at[v] * (7 * slope[(v + 1) % 3] - 2 * sum(slope)) for v in range(3))

    def meet(self, k: int, along: np.ndarray, places: np.ndarray) -> np.ndarray:
        """Barycentric places where lines along a direction through some places meet the triangle, [..., 3]."""
        across = np.linalg.svd(along[None])[2][1:]
        x = self.x[self.nodes[k]] @ across.T
        target = places @ across.T
        n = len(x)
        sides = np.stack([x[1] - x[0], x[2] - x[0]], axis=-1)
        at = np.linalg.solve(sides, (target - x[0]).T).T
        for _ in range(8 if n == 6 else 0):
            b = np.column_stack([1 - at.sum(axis=1), at])
            jacobian = np.swapaxes(triangle_slopes(b, n) @ x, -1, -2)
            at = at + np.linalg.solve(jacobian, (target - triangle_shape(b, n) @ x)[..., None])[..., 0]
        return np.column_stack([1 - at.sum(axis=1), at])


def clipped(polygon: np.ndarray, triangle: np.ndarray) -> np.ndarray:
    """What a convex polygon in the plane has in common with a triangle whose corners turn counterclockwise (Sutherland and Hodgman)."""
    for a, b in zip(triangle, np.roll(triangle, -1, axis=0), strict=True):
        if not len(polygon):
            break
        edge = b - a
        inside = edge[0] * (polygon[:, 1] - a[1]) - edge[1] * (polygon[:, 0] - a[0])
        kept = []
        for i in range(len(polygon)):
            j = (i + 1) % len(polygon)
            if inside[i] >= 0:
                kept.append(polygon[i])
            if (inside[i] >= 0) != (inside[j] >= 0):
                share = inside[i] / (inside[i] - inside[j])
                kept.append(polygon[i] + share * (polygon[j] - polygon[i]))
        polygon = np.array(kept).reshape(-1, 2)
    return polygon


@dataclass
class Overlaps:
    """What each triangle of a side has in common with the other face."""

    area: np.ndarray
    whole: np.ndarray
    integrals: sparse.csr_matrix
    """Of shape functions over it, [n_triangles, n_nodes]."""
    products: list[sparse.csr_matrix]
    """Of shape functions of both sides, [n_nodes, n_nodes] for each triangle."""


def overlaps(side: Face, other: Face) -> Overlaps:
    """Clips all triangles of both faces in the planes of the side's."""
    n, n_nodes = side.nodes.shape[1], len(side.x)
    area, whole = np.zeros(len(side.facets)), np.zeros(len(side.facets))
    integrals = sparse.lil_matrix((len(side.facets), n_nodes))
    products = []
    for f, nodes in enumerate(side.nodes):
        corners = side.x[nodes[:3]]
        normal = side.area_vectors[f] / side.areas[f]
        first = (corners[1] - corners[0]) / np.linalg.norm(corners[1] - corners[0])
        plane = np.array([first, np.cross(normal, first)])
        own = (corners - corners[0]) @ plane.T
        inverse = np.linalg.inv(np.column_stack([own[1], own[2]]))
        rows, columns, values = [], [], []

        def points(triangle, inverse=inverse, nodes=nodes):
            bary = (POINTS @ triangle) @ inverse.T
            at = np.column_stack([1 - bary.sum(axis=1), bary])
            along = triangle_slopes(at, n) @ side.x[nodes]
            density = np.linalg.norm(np.cross(along[:, 0], along[:, 1]), axis=1)
            sides = (triangle[1:] - triangle[0]) @ inverse.T
            return at, WEIGHTS * density * abs(np.linalg.det(sides)) / 2

        whole[f] = points(own)[1].sum()
        facing = other.area_vectors @ normal < -0.5 * other.areas
        for k in np.flatnonzero(facing):
            theirs = other.x[other.nodes[k, :3]]
            if np.linalg.norm(theirs.mean(axis=0) - corners.mean(axis=0)) > REACH * (extent(side) + extent(other)):
                continue
            seen = ((theirs - corners[0]) @ plane.T)[::-1]
            polygon = clipped(own, seen)
            for i in range(1, len(polygon) - 1):
                at, weights = points(polygon[[0, i, i + 1]])
                phi = triangle_shape(at, n)
                bary = other.meet(k, normal, phi @ side.x[nodes])
                psi = triangle_shape(bary, n)
                area[f] += weights.sum()
                for j in range(n):
                    integrals[f, nodes[j]] += weights @ phi[:, j]
                rows += list(np.repeat(nodes, n))
                columns += list(np.tile(other.nodes[k], n))
                values += list((phi.T @ (weights[:, None] * psi)).ravel())
        products.append(sparse.coo_matrix((values, (rows, columns)), (n_nodes, n_nodes)).tocsr())
    return Overlaps(area, whole, integrals.tocsr(), products)


def extent(face: Face) -> float:
    """Half of the diagonal of the box around a face."""
    return float(np.linalg.norm(np.ptp(face.x[np.unique(face.nodes)], axis=0)) / 2)


def opposite(side: Face, other: Face, node: int) -> tuple[np.ndarray, float, bool]:
    """Weighted normal and gap at a node of the side, and whether something lies on the line along its normal."""
    along, x = side.normals[node], side.x[node]
    best = None
    for k in np.flatnonzero(other.area_vectors @ along < 0):
        bary = other.meet(k, along, x[None])[0]
        at = triangle_shape(bary, other.nodes.shape[1])
        place = at @ other.x[other.nodes[k]]
        inside = bary.min() > -1e-9
        key = (inside, -abs((place - x) @ along) if inside else bary.min())
        if np.abs(bary).max() < 1e3 and (best is None or key > best[0]):
            best = (key, place - along * other.bulge(k, bary), at @ other.normals[other.nodes[k]])
    if best is None:
        return along, np.nan, False
    (inside, _), place, theirs = best
    theirs = theirs / np.linalg.norm(theirs)
    normal = side.modulus * along - other.modulus * theirs
    normal /= np.linalg.norm(normal)
    (k, local), *_ = np.argwhere(side.nodes == node)
    at = np.vstack([np.eye(3), (np.eye(3) + np.roll(np.eye(3), -1, axis=0)) / 2])[local]
    return normal, float((place - x - along * side.bulge(k, at)) @ normal), inside


def modulus(scene: dict, body: dict) -> float:
    """E/(1 - nu^2) of the material of a body."""
    young, poisson = lame_source(scene, body)
    return young / (1 - poisson**2)


def lame_source(scene: dict, body: dict) -> tuple[float, float]:
    """Young's modulus and Poisson's ratio of a body."""
    of = (body.get("material") or scene["material"])["isotropic"]
    return of["young_modulus"], of["poisson_ratio"]


def stiffness(mesh: h5py.Group, scene: dict) -> sparse.csr_matrix:
    """The elastic stiffness of all nodes, from tetrahedra with straight edges, [3 n, 3 n]."""
    x, corners = mesh["coordinates"][:], mesh["tetrahedra"][:]
    n = len(x)
    edges = x[corners[:, 1:]] - x[corners[:, :1]]
    volume = np.linalg.det(edges) / 6
    slopes = np.linalg.inv(edges)
    slopes = np.concatenate([-slopes.sum(axis=2, keepdims=True), slopes], axis=2).swapaxes(1, 2)
    if "tetrahedron_mid_edges" in mesh:
        nodes = np.hstack([corners, mesh["tetrahedron_mid_edges"][:]])
        a, b = (5 - np.sqrt(5)) / 20, (5 + 3 * np.sqrt(5)) / 20
        gradients = []
        for q in range(4):
            at = np.full(4, a)
            at[q] = b
            own = [(4 * at[i] - 1) * slopes[:, i] for i in range(4)]
            pairs = [(0, 1), (1, 2), (0, 2), (0, 3), (1, 3), (2, 3)]
            own += [4 * (at[i] * slopes[:, j] + at[j] * slopes[:, i]) for i, j in pairs]
            gradients.append(np.stack(own, axis=1))
    else:
        nodes, gradients = corners, [slopes]
    starts = mesh["body_tetrahedra"][:]
    young, poisson = np.array([lame_source(scene, body) for body in scene["body"]]).T
    of = np.searchsorted(starts, np.arange(len(corners)), side="right") - 1
    shear = (young / (2 * (1 + poisson)))[of]
    first = (young * poisson / ((1 + poisson) * (1 - 2 * poisson)))[of]
    blocks = 0.0
    for g in gradients:
        weight = volume / len(gradients)
        inner = np.einsum("tic,tjc->tij", g, g)
        outer = np.einsum("tic,tjd->ticjd", g, g)
        block = first[:, None, None, None, None] * outer + shear[:, None, None, None, None] * outer.swapaxes(2, 4)
        block = block + shear[:, None, None, None, None] * np.einsum("tij,cd->ticjd", inner, np.eye(3))
        blocks = blocks + weight[:, None, None, None, None] * block
    dofs = (3 * nodes[:, :, None] + np.arange(3)).reshape(len(nodes), -1)
    size = dofs.shape[1]
    rows, columns = np.repeat(dofs, size, axis=1), np.tile(dofs, (1, size))
    return sparse.coo_matrix((np.ravel(blocks), (rows.ravel(), columns.ravel())), (3 * n, 3 * n)).tocsr()


class Pair:
    """The contact of one pair of faces in a run file, made again."""

    def __init__(self, file: h5py.File):
        self.mesh, self.scene = file["mesh"], read_scene(file)
        self.contact = self.scene["contact"]
        assert isinstance(self.contact, dict), "one pair of faces"
        bodies = {body["name"]: body for body in self.scene["body"]}
        self.names = facet_faces(self.mesh)
        owner = str(self.names[self.mesh["contact_facets"][0]])
        other = next(name for name in self.contact["between"] if name != owner)
        self.side, self.other = (
            Face(self.mesh, name, modulus(self.scene, bodies[name.split(".")[0]])) for name in (owner, other)
        )
        self.is_flat = self.side.is_flat and self.other.is_flat
        self.limit = FLAT if self.is_flat else CURVED
        self.found = overlaps(self.side, self.other)
        self.make_panes()

    def make_panes(self) -> None:
        """Gathers triangles on the panes of the file."""
        mesh, found = self.mesh, self.found
        place = {facet: f for f, facet in enumerate(self.side.facets)}
        self.own = np.array([place[f] for f in mesh["contact_facets"][:]])
        self.pane = mesh["contact_facet_pane"][:]
        m = len(mesh["pane_area"])
        gather = sparse.coo_matrix((np.ones(len(self.own)), (self.pane, self.own)), (m, len(self.side.facets))).tocsr()
        self.area, self.weights = gather @ found.area, (gather @ found.integrals).tocsr()
        self.whole = gather @ found.whole
        self.products = [sum(found.products[f] for f in self.own[self.pane == i]) for i in range(m)]

    def geometry(self) -> str | None:
        """What is wrong with areas, weights, products, normals and gaps."""
        mesh, limit = self.mesh, self.limit
        nodes, area = mesh["contact_nodes"][:], mesh["pane_area"][:]
        average = read_matrix(mesh["pane_average"])
        size = area.max()
        if off := beyond(area - self.area, limit * size):
            return f"areas of panes differ by {off:.1e}"
        left = self.found.area.sum() - area.sum()
        if abs(left) > 1e-5 * self.found.area.sum() + limit * size:
            return f"panes cover {area.sum():.6e} of {self.found.area.sum():.6e}"
        stored = sparse.lil_matrix((len(area), len(self.side.x)))
        stored[:, nodes] = (average.toarray() * area).T
        if off := beyond((stored - self.weights).toarray(), limit * size):
            return f"integrals of shape functions differ by {off:.1e}"
        limits, pairs = mesh["opposite_panes"][:], mesh["opposite_pairs"][:]
        values = mesh["opposite_integrals"][:]
        for i, own in enumerate(self.products):
            at = slice(limits[i], limits[i + 1])
            entries = (values[at], (nodes[pairs[at, 0]], pairs[at, 1]))
            theirs = sparse.coo_matrix(entries, own.shape).tocsr()
            if off := beyond((theirs - own).data, limit * size):
                return f"products of pane {i} differ by {off:.1e}"
            # The sum of the other side's shape functions is one: forces balance to rounding.
            sums = np.asarray(theirs.sum(axis=1)).ravel()[nodes]
            if off := beyond(sums - average.toarray()[:, i] * area[i], 1e-13 * size):
                return f"action is not reaction on pane {i}: {off:.1e}"
        return self.normals(nodes)

    def normals(self, nodes: np.ndarray) -> str | None:
        mesh = self.mesh
        if "contact_node_normal" in mesh:
            normal = mesh["contact_node_normal"][:]
        else:
            normal = np.broadcast_to(mesh["contact_normal"][:], (len(nodes), 3))
        gap = mesh["contact_clearance"][:] if "contact_clearance" in mesh else np.zeros(len(nodes))
        # Bodies that overlap by less than their triangles leave of curved faces are taken to touch.
        self.normal, self.gap = normal, gap if self.contact.get("interference") else np.maximum(gap, 0.0)
        for local, node in enumerate(nodes):
            own, distance, inside = opposite(self.side, self.other, node)
            if not (inside or self.is_flat):
                continue
            if off := beyond(own - normal[local], 1e-9):
                return f"the normal at node {node} differs by {off:.1e}"
            if off := beyond(distance - gap[local], 1e-9 * extent(self.side)):
                return f"the gap at node {node} differs by {off:.1e}"
        return None

    def rows(self, file: h5py.File) -> list[sparse.csr_matrix]:
        """N, and T along both axes, over all nodes, [m, 3 n]; the tangential ones with friction alone."""
        nodes = self.mesh["contact_nodes"][:]
        directions = [self.normal]
        if "multiplier_tangential" in file["solve"]:
            directions += [file[f"post/contact_axis_{k}"][:] for k in (1, 2)]
        rows = []
        for direction in directions:
            at = np.zeros_like(self.side.x)
            at[nodes] = direction
            parts = []
            for c in range(3):
                theirs = [np.asarray(product.T @ at[:, c]).ravel() for product in self.products]
                parts.append(self.weights.toarray() * at[:, c] - np.array(theirs))
            rows.append(sparse.csr_matrix(np.stack(parts, axis=-1).reshape(len(self.area), -1)))
        return rows

    def coupling(self, file: h5py.File, rows: list[sparse.csr_matrix]) -> str | None:
        """What is wrong with N and T."""
        dof = file["assemble/degree_of_freedom"][:].ravel()
        free = dof >= 0
        n_free = file["load/force"].shape[0]
        to_free = sparse.coo_matrix((np.ones(free.sum()), (np.flatnonzero(free), dof[free])), (dof.size, n_free)).tocsr()
        stored = [read_matrix(file["assemble/coupling_normal"])]
        if len(rows) > 1:
            both = read_matrix(file["assemble/coupling_tangential"]).tocsr()
            stored += [both[k::2] for k in range(2)]
        for name, own, theirs in zip("N T1 T2".split(), rows, stored, strict=False):
            if off := beyond((own @ to_free - theirs).toarray(), self.limit * self.area.max()):
                return f"{name} differs by {off:.1e}"
        return None

    def solution(self, file: h5py.File, rows: list[sparse.csr_matrix]) -> str | None:
        """What is wrong with the solution."""
        u = file["solve/displacement"][:].ravel()
        pressure = file["solve/multiplier_normal"][:]
        shear = np.zeros((len(pressure), 2))
        if len(rows) > 1:
            shear[: len(file["solve/multiplier_tangential"])] = file["solve/multiplier_tangential"][:]
        contact = rows[0].T @ pressure
        for k, row in enumerate(rows[1:]):
            contact = contact + row.T @ shear[:, k]
        n = len(self.side.x)
        starts = self.mesh["body_nodes"][:]
        forces = contact.reshape(-1, 3)
        halves = [forces[a:b].sum(axis=0) for a, b in zip(starts, starts[1:], strict=False)]
        size = np.abs(pressure) @ self.area
        # The rows above were made without the program; the partition of unity is what is told here.
        if off := beyond(sum(halves), 1e-12 * size):
            return f"contact forces do not balance: {off:.1e} of {size:.1e}"
        moments = np.cross(self.side.x, forces).sum(axis=0)
        # On flat faces nothing is left but the couple of the gap and the friction across it.
        across = np.zeros(3)
        if self.is_flat and len(rows) > 1:
            gaps = self.weights @ self.spread(self.gap)
            axes = [file[f"post/contact_axis_{k}"][:][0] for k in (1, 2)]
            across = -np.cross(self.normal[0], sum((gaps @ part) * axis for part, axis in zip(shear.T, axes, strict=True)))
        reach = np.abs(self.side.x).max()
        if self.is_flat and (off := beyond(moments - across, 1e-12 * size * reach)):
            return f"moments of the contact forces do not balance: {off:.1e} of {size * reach:.1e}"
        if wrong := self.equilibrium(file, u, contact, n):
            return wrong
        largest = np.abs(u).max()
        shift = self.contact.get("gap", 0.0)
        distance = (self.weights @ self.spread(self.gap)) / self.area + shift
        left = distance - (rows[0] @ u) / self.area
        limit = CONDITIONS * max(largest, np.abs(distance).max())
        top = max(pressure.max(initial=0.0), 1e-300)
        if pressure.min(initial=0.0) < -1e-12 * top:
            return f"a pressure of {pressure.min():.1e}"
        if left.min(initial=0.0) < -limit:
            return f"bodies in each other by {-left.min():.1e}, displacements {largest:.1e}"
        if off := beyond(pressure / top * left, limit):
            return f"pressure across a gap: {off:.1e}"
        return self.law(rows, u, pressure, shear, limit)

    def spread(self, values: np.ndarray) -> np.ndarray:
        at = np.zeros(len(self.side.x))
        at[self.mesh["contact_nodes"][:]] = values
        return at

    def equilibrium(self, file: h5py.File, u: np.ndarray, contact: np.ndarray, n: int) -> str | None:
        dof = file["assemble/degree_of_freedom"][:].ravel()
        free = dof >= 0
        load = np.zeros(3 * n)
        load[free] = file["load/force"][:][dof[free]]
        # The stored load has the forces of moved clamps in it.
        moved = np.where(free, u, 0.0)
        if self.is_flat:
            inner = (stiffness(self.mesh, self.scene) @ moved)[free]
        else:
            inner = (read_matrix(file["assemble/stiffness"]) @ moved[free][np.argsort(dof[free])])[dof[free]]
        left = inner - load[free] + contact[free]
        # Roundings of a stiff body under a soft one's forces are as large as its own.
        scale = np.abs(inner).max() + np.abs(contact).max() + np.abs(load).max()
        allowed = 1e-9 if self.is_flat else 1e-3
        return (off := beyond(left, allowed * scale)) and f"forces do not balance at a node: {off / scale:.1e}"

    def law(self, rows, u, pressure, shear, limit) -> str | None:
        friction = self.contact.get("friction") or self.scene.get("friction")
        if len(rows) == 1:
            return None if not friction else "a law without tangential stresses"
        both = coefficients(friction)
        slip = np.column_stack([row @ u for row in rows[1:]]) / self.area[:, None]
        bound = np.maximum(pressure, 0.0)
        used = np.linalg.norm(shear / both, axis=1)
        if off := beyond(np.maximum(used - bound, 0.0), 1e-9 * bound.max()):
            return f"friction beyond its bound by {off:.1e} of {bound.max():.1e}"
        missing = bound * np.linalg.norm(slip * both, axis=1) - (shear * slip).sum(axis=1)
        if off := beyond(missing, 3 * limit * bound.max() * both.max()):
            return f"friction that is not along the slip: {off:.1e}"
        return None

    def can_be_held(self, rows, file) -> bool:
        """Whether forces of the faces within the law, rounded inwards, balance the loads of every body without clamps."""
        dof, m = file["assemble/degree_of_freedom"][:], len(self.area)
        load = np.zeros(self.side.x.shape)
        load[dof >= 0] = file["load/force"][:][dof[dof >= 0]]
        starts = self.mesh["body_nodes"][:]
        equations, right = [], []
        for a, b in zip(starts, starts[1:], strict=False):
            if (dof[a:b] < 0).any():
                continue
            x = self.side.x[a:b] - self.side.x[a:b].mean(axis=0)
            modes = [np.tile(axis, (b - a, 1)) for axis in np.eye(3)] + [np.cross(axis, x) for axis in np.eye(3)]
            for mode in modes:
                whole = np.zeros_like(self.side.x)
                whole[a:b] = mode
                equations.append(np.concatenate([row @ whole.ravel() for row in rows]))
                right.append((whole * load).sum())
        if not equations:
            return True
        equations, right = np.array(equations), np.array(right)
        variables = [(0, None)] * m + [(None, None)] * (m * (len(rows) - 1))
        faces = None
        if len(rows) > 1:
            friction = self.contact.get("friction") or self.scene.get("friction")
            both = coefficients(friction)
            sides = 64
            blocks = []
            for angle in 2 * np.pi * np.arange(sides) / sides:
                direction = np.array([np.cos(angle), np.sin(angle)]) / both
                blocks.append(np.hstack([-np.cos(np.pi / sides) * np.eye(m), *(d * np.eye(m) for d in direction)]))
            faces = np.vstack(blocks)
        scale, top = np.abs(equations).max(axis=1), np.abs(right).max()
        # Motions that contact does not feel: loads must not work in them.
        is_felt = scale > 1e-12 * scale.max()
        if np.abs(right[~is_felt]).max(initial=0.0) > 1e-9 * top:
            return False
        equations, right, scale = equations[is_felt], right[is_felt], scale[is_felt]
        found = linprog(
            np.zeros(len(variables)), faces, None if faces is None else np.zeros(len(faces)),
            equations / scale[:, None], right / scale / top, variables, method="highs",
        )  # fmt: skip
        return found.status == 0


def coefficients(friction: dict) -> np.ndarray:
    """Constant coefficients along both axes."""
    keys = ["coefficient", "coefficient"] if "coefficient" in friction else ["coefficient_1", "coefficient_2"]
    return np.array([friction[key]["constant"] for key in keys])


def beyond(values, limit: float) -> float | None:
    """The largest of some values if it is beyond a limit."""
    most = float(np.abs(values).max(initial=0.0))
    return None if most <= limit else most


def wrong_with(path: Path) -> tuple[str, str | None]:
    """The status of a solved run file with one pair of faces, and what is wrong with it."""
    with open_run(path) as file:
        status = str(read_enum(file["solve/status"]))
        pair = Pair(file)
        if wrong := pair.geometry():
            return status, wrong
        rows = pair.rows(file)
        if wrong := pair.coupling(file, rows):
            return status, wrong
        if status in SOLVED:
            return status, pair.solution(file, rows)
        if status == "no_equilibrium":
            return status, "no_equilibrium, but there are forces in balance" if pair.can_be_held(rows, file) else None
        return status, "not solved" if pair.can_be_held(rows, file) else None


def random_scene(seed: int, number: int, folder: Path) -> str:
    """A scene of two bodies; mesh files of curved ones go to the folder."""
    draw = np.random.default_rng([seed, number])
    element = str(draw.choice(["P1", "P2"]))
    is_curved = draw.random() < 0.25
    unit = 10.0 ** draw.integers(-2, 4)
    stiffer = 10.0 ** draw.uniform(-2.5, 2.5)
    size = np.exp(draw.uniform(-0.4, 0.4, 3))
    upper = size * np.exp(draw.uniform(-0.5, 0.4, 3))
    axis = 2 if is_curved else int(draw.integers(3))
    along = [a for a in range(3) if a != axis]
    limit = 3 if element == "P2" else 4
    both = [2 * draw.integers(1, limit, 3) for _ in range(2)]
    if element == "P2":
        both = [np.maximum(cells // 2, 1) for cells in both]
    origin = np.zeros(3)
    origin[axis] = size[axis] + (draw.choice([0.0, 0.0, 2e-3]) * size[axis])
    if draw.random() < 0.2:
        size[along], upper[along] = size[along], size[along]
    else:
        room = size[along] - upper[along]
        origin[along] = draw.uniform(-0.1, 0.9, 2) * room + draw.uniform(-0.15, 0.15, 2) * size[along]
    holds = str(draw.choice(["moved", "loaded", "floating"])) if not is_curved else str(draw.choice(["moved", "loaded"]))
    friction = draw.choice(["none", "isotropic", "orthotropic"])
    name = "xyz"[axis]
    between = [f"lower.{name}_max", f"upper.{name}_min"]
    text = [f'title = "pair {seed} {number}"']
    text += [f"material.isotropic = {{ young_modulus = {unit}, poisson_ratio = {draw.uniform(0.0, 0.45)} }}"]
    for which, body, cells, place in (("lower", size, both[0], np.zeros(3)), ("upper", upper, both[1], origin)):
        text += ["[[body]]", f'name = "{which}"', f'element = "{element}"', f"origin = {place.tolist()}"]
        if which == "upper":
            own = f"young_modulus = {unit * stiffer}, poisson_ratio = {draw.uniform(0.0, 0.45)}"
            text += [f"material.isotropic = {{ {own} }}"]
        if is_curved:
            bulge = draw.uniform(0.02, 0.12) * (1 if which == "upper" else -1)
            cells = np.maximum(cells, 2)
            file = folder / f"{which}.msh"
            file.write_text(mesh_text(bulged(body, origin, size, bulge, which), tuple(map(int, cells)), element))
            text += [f'gmsh.file = "{file.name}"']
        else:
            text += [f"brick = {{ size = {body.tolist()}, cells = {cells.tolist()} }}"]
    if draw.random() < 0.7 or holds == "floating":
        text += ["[[clamp]]", f'face = "lower.{name}_min"']
    else:
        text += ["[[clamp]]", f'face = "lower.{"xyz"[along[0]]}_min"']
    press = unit * min(stiffer, 1.0) * 10.0 ** draw.uniform(-3.5, -2.0)
    push = np.zeros(3)
    push[along] = draw.uniform(-0.25, 0.25, 2) * press * (friction != "none")
    value = np.zeros(3)
    if holds == "moved":
        value[axis] = -draw.uniform(1e-3, 8e-3) * size[axis] - (origin[axis] - size[axis])
        value[along] = draw.uniform(-4e-3, 4e-3, 2)
        text += ["[[clamp]]", f'face = "upper.{name}_max"', f"value = {value.tolist()}"]
    else:
        if holds == "loaded":
            text += ["[[clamp]]", f'face = "upper.{"xyz"[along[1]]}_max"']
        push[axis] = -press
        text += ["[[traction]]", f'face = "upper.{name}_max"', f"value = {push.tolist()}"]
    text += ["[contact]", f"between = {between}".replace("'", '"')]
    if draw.random() < 0.4:
        text += [f'panes_on = "{draw.choice(between)}"']
    if draw.random() < 0.2:
        text += [f"gap = {1e-3 * draw.random() * size[axis]}"]
    keys = {"none": [], "isotropic": ["coefficient"], "orthotropic": ["coefficient_1", "coefficient_2"]}[str(friction)]
    text += ["[friction]"] * bool(keys) + [f"{key}.constant = {draw.uniform(0.1, 0.8)}" for key in keys]
    return "\n".join(text) + "\n"


def bulged(body: np.ndarray, origin: np.ndarray, size: np.ndarray, bulge: float, which: str):
    """A brick whose face towards the other is a parabola across x around the middle of the lower body."""
    start = origin if which == "upper" else np.zeros(3)

    def place(*at):
        x = np.array(at) * body
        middle = (x[0] + start[0] - size[0] / 2) / size[0]
        share = 1 - at[2] if which == "upper" else at[2]
        return tuple(map(float, (x[0], x[1], x[2] + share * bulge * middle**2)))

    return place


def judge(program: Program, text: str, folder: Path) -> tuple[str, str | None]:
    """How the solve of a scene ended, and what is wrong with that."""
    scene, file = folder / "pair.toml", folder / "pair.h5"
    scene.write_text(text)
    file.unlink(missing_ok=True)
    outcome = program.run("run", scene, file, "--no-figures")
    if outcome.fault or outcome.code not in (0, 1):
        return "refused", outcome.fault or outcome.stderr[-400:]
    return wrong_with(file)


def main() -> int:
    """Judge scenes and print the counts; 1 if anything is wrong."""
    parser = arguments("pairs", __doc__)
    parser.add_argument("--scenes", type=int, default=200, help="number of scenes")
    parser.add_argument("--first", type=int, default=0, help="number of the first one")
    parser.add_argument("--write", type=Path, help="write the scene of --first into a folder, and do no more")
    chosen = parser.parse_args()
    if chosen.write:
        (chosen.write / "pair.toml").write_text(random_scene(chosen.seed, chosen.first, chosen.write))
        return 0
    program = Program.find(chosen.program)
    counts, faults = Counter(), 0
    for number in range(chosen.first, chosen.first + chosen.scenes):
        with tempfile.TemporaryDirectory() as folder:
            status, fault = judge(program, random_scene(chosen.seed, number, Path(folder)), Path(folder))
        counts[status] += 1
        if fault:
            faults += 1
            print(f"scene {number} ({status}): {fault}", flush=True)
    print(", ".join(f"{count} {status}" for status, count in counts.most_common()))
    print(f"{faults} wrong of {chosen.scenes}")
    return int(faults > 0)


if __name__ == "__main__":
    sys.exit(main())
