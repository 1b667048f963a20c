"""Mesh, stiffness, load and coupling against scikit-fem and plain geometry."""

from collections import Counter
from itertools import combinations

import numpy as np
import pytest
from scipy.special import betainc
from skfem import (
    Basis,
    ElementTetP1,
    ElementVector,
    FacetBasis,
    LinearForm,
    MeshTet,
)
from skfem.models.elasticity import lame_parameters, linear_elasticity

from run_file import facet_faces


def face_plane(scene: dict, face: str) -> tuple[int, float, float]:
    """Axis, coordinate and outward sign of a face of the brick."""
    axis, end = "xyz".index(face[0]), face.split("_")[1]
    size = scene["body"]["brick"]["size"][axis]
    return (axis, size, 1.0) if end == "max" else (axis, 0.0, -1.0)


def triangle_normals(coordinates: np.ndarray, triangles: np.ndarray) -> np.ndarray:
    """Area vectors of triangles, by the order of their nodes."""
    a, b, c = np.moveaxis(coordinates[triangles], 1, 0)
    return np.cross(b - a, c - a) / 2


@pytest.fixture(scope="module")
def basis(problem):
    """scikit-fem's P1 displacements on the stored mesh."""
    mesh = MeshTet(problem.coordinates.T, problem.tetrahedra.T)
    return Basis(mesh, ElementVector(ElementTetP1()))


def free_order(problem, basis) -> np.ndarray:
    """scikit-fem's number of each free degree of freedom."""
    order = np.empty(problem.load.size, dtype=int)
    order[problem.dof[problem.dof >= 0]] = basis.nodal_dofs.T[problem.dof >= 0]
    return order


def test_stiffness(problem, basis):
    material = problem.scene["material"]["isotropic"]
    lame = lame_parameters(material["young_modulus"], material["poisson_ratio"])
    order = free_order(problem, basis)
    expected = linear_elasticity(*lame).assemble(basis).tocsc()[order][:, order]
    # Two orders of summation over at most 24 tetrahedra of a node: some 10 roundings.
    difference = abs(problem.stiffness - expected).max()
    assert difference <= 1e-12 * abs(expected).max()
    assert abs(problem.stiffness - problem.stiffness.T).max() == 0.0


def test_load(problem, basis):
    expected = np.zeros(basis.N)
    for traction in problem.scene["traction"]:
        axis, place, _ = face_plane(problem.scene, traction["face"])
        # The plane itself; coordinates of a brick are multiples of a cell, rounded.
        facets = basis.mesh.facets_satisfying(
            lambda x, axis=axis, place=place: np.isclose(x[axis], place, atol=1e-9),
            boundaries_only=True,
        )
        p = np.array(traction["value"])
        form = LinearForm(lambda v, w, p=p: sum(p[i] * v[i] for i in range(3)))
        expected += form.assemble(FacetBasis(basis.mesh, basis.elem, facets=facets))
    expected = expected[free_order(problem, basis)]
    # Some 10 roundings of sums over the triangles of a node.
    assert abs(problem.load - expected).max() <= 1e-12 * abs(expected).max()


def test_coupling_is_the_exact_quadrature(run, problem):
    """Row i of N and T integrates hats over pane i, a third of each triangle's area.

    Between equal cells that is |R|/12 (4 centre + the 8 others).
    """
    triangles = run["mesh/facets"][:][run["mesh/contact_facets"][:]]
    panes = run["mesh/contact_facet_pane"][:]
    area = np.linalg.norm(triangle_normals(problem.coordinates, triangles), axis=1)
    m = problem.n_panes
    expected = np.zeros((3 * m, *problem.dof.shape))
    for pane in range(m):
        members = triangles[panes == pane]
        count = Counter(members.ravel().tolist())
        centres = [node for node, times in count.items() if times == len(members)]
        assert len(members) == 8 and len(count) == 9 and len(centres) == 1
        rows = (pane, m + 2 * pane, m + 2 * pane + 1)
        for node in count:
            weight = area[panes == pane][(members == node).any(axis=1)].sum() / 3
            for row, axis in zip(rows, problem.frame, strict=True):
                expected[row, node] = weight * axis
    free = np.empty((3 * m, problem.load.size))
    free[:, problem.dof[problem.dof >= 0]] = expected[:, problem.dof >= 0]
    # A product of three rounded numbers, and areas summed in another order.
    difference = abs(problem.coupling.toarray() - free).max()
    assert difference <= 1e-13 * abs(free).max()


def test_held_degrees_of_freedom(problem):
    held = np.zeros(problem.dof.shape, dtype=bool)
    for clamp in problem.scene["clamp"]:
        if "box" in clamp:
            low, high = np.array(clamp["box"])
            inside = (low <= problem.coordinates) & (problem.coordinates <= high)
            nodes = inside.all(axis=1)
        else:
            axis, place, _ = face_plane(problem.scene, clamp["face"])
            nodes = np.isclose(problem.coordinates[:, axis], place, atol=1e-9)
        for component in clamp["components"]:
            held[nodes, "xyz".index(component)] = True
    assert np.array_equal(problem.dof == -1, held)
    assert np.array_equal(problem.dof[~held], np.arange(problem.load.size))
    assert not problem.displacement[held].any()


def test_mesh_is_conforming(run, problem):
    """Inner triangles belong to two tetrahedra; the others are the stored boundary."""
    triangles = Counter(
        tuple(sorted(three))
        for nodes in problem.tetrahedra.tolist()
        for three in combinations(nodes, 3)
    )
    assert set(triangles.values()) == {1, 2}
    boundary = {three for three, times in triangles.items() if times == 1}
    stored = [tuple(sorted(three)) for three in run["mesh/facets"][:].tolist()]
    assert len(stored) == len(set(stored))
    assert set(stored) == boundary
    assert set(problem.tetrahedra.flat) == set(range(len(problem.coordinates)))


def test_boundary_faces_and_areas(run, problem):
    """Triangles lie on their faces, look outward and cover each face once."""
    size = np.array(problem.scene["body"]["brick"]["size"])
    facets, names = run["mesh/facets"][:], facet_faces(run["mesh"])
    for face in ("x_min", "x_max", "y_min", "y_max", "z_min", "z_max"):
        members = facets[names == face]
        axis, place, sign = face_plane(problem.scene, face)
        # Node coordinates are products and quotients of sizes near 1: one rounding.
        assert np.allclose(problem.coordinates[members][..., axis], place, atol=1e-14)
        normals = triangle_normals(problem.coordinates, members)
        assert (sign * normals[:, axis] > 0).all()
        # A sum of some hundred rounded areas.
        expected = np.prod(np.delete(size, axis))
        assert np.linalg.norm(normals, axis=1).sum() == pytest.approx(expected, 1e-13)


def test_contact_surface(run, problem):
    contact = problem.scene["contact"]["face"]
    names = facet_faces(run["mesh"])
    contact_facets = run["mesh/contact_facets"][:]
    assert set(contact_facets) == set(np.flatnonzero(names == contact))
    triangles = run["mesh/facets"][:][contact_facets]
    assert np.array_equal(problem.contact_nodes, np.unique(triangles))
    area = np.linalg.norm(triangle_normals(problem.coordinates, triangles), axis=1)
    by_pane = np.bincount(run["mesh/contact_facet_pane"][:], weights=area)
    # Sums of 8 areas and of 9 weights in another order: some roundings each.
    assert problem.pane_area == pytest.approx(by_pane, rel=1e-14)
    columns = np.asarray(problem.pane_average.sum(axis=0)).ravel()
    assert columns == pytest.approx(np.ones(problem.n_panes), rel=1e-14)


def planes(brick: dict, axis: int) -> np.ndarray:
    """The planes between a brick's cells, from docs/reference/body.md alone."""
    name, length, cells = "xyz"[axis], brick["size"][axis], brick["cells"][axis]
    given = brick.get("coordinates", {}).get(name)
    if given:
        return np.array(given)
    grading = brick.get("grading", {})
    p, q = (grading.get(f"{name}_{end}", 1.0) for end in ("min", "max"))
    return length * betainc(p, q, np.arange(cells + 1) / cells)


def test_nodes_lie_between_the_planes_of_the_scene(problem):
    """Nodes are where the scene says, the first axis fastest."""
    brick = problem.scene["body"]["brick"]
    z, y, x = np.meshgrid(*(planes(brick, axis) for axis in (2, 1, 0)), indexing="ij")
    expected = np.column_stack([x.ravel(), y.ravel(), z.ravel()])
    # Two ways to the incomplete beta function: some tens of roundings of numbers up to 3.
    assert np.allclose(problem.coordinates, expected, rtol=0.0, atol=1e-14)


def test_quality_figures(run, problem):
    corners = problem.coordinates[problem.tetrahedra]
    edges = corners[:, [1, 2, 3]] - corners[:, [0]]
    volumes = np.linalg.det(edges) / 6
    assert (volumes > 0).all()
    first, second = np.transpose(list(combinations(range(4), 2)))
    lengths = np.linalg.norm(corners[:, first] - corners[:, second], axis=2).T
    shapes = 12 * (3 * volumes) ** (2 / 3) / (lengths**2).sum(axis=0)
    expected = {
        "longest_edge": lengths.max(),
        "shortest_edge": lengths.min(),
        "smallest_volume": volumes.min(),
        "total_volume": np.prod(problem.scene["body"]["brick"]["size"]),
        "smallest_shape": shapes.min(),
        "mean_shape": shapes.mean(),
    }
    assert set(run["mesh/quality"]) == set(expected)
    for name, value in expected.items():
        # Determinants of differences of coordinates: some 100 roundings.
        assert run[f"mesh/quality/{name}"][()] == pytest.approx(value, rel=1e-12), name
