"""Quadratic and adaptive meshes against scikit-fem's own P2 assembly, plain geometry and dense algebra."""

import numpy as np
import pytest
from scipy.sparse import linalg as sparse_linalg
from skfem import Basis, ElementTetP2, ElementVector, FacetBasis, LinearForm, MeshTet
from skfem.models.elasticity import lame_parameters, linear_elasticity

from conftest import ROOT
from run_file import open_run, read_matrix, read_scene

EDGES = [(0, 1), (1, 2), (0, 2), (0, 3), (1, 3), (2, 3)]


@pytest.fixture(scope="module", params=["quadratic.toml", "adaptive.toml"])
def run(request, contact3d, tmp_path_factory):
    """A P2 run file: equal cells, and tetrahedra cut where the error sits."""
    path = tmp_path_factory.mktemp("quadratic") / "run.h5"
    changes = {
        "quadratic.toml": ["--set", "body.brick.cells=[6,2,2]"],
        "adaptive.toml": ["--error", "12%"],
    }
    scene = ROOT / "pipelines" / request.param
    contact3d("run", scene, path, "--no-figures", *changes[request.param])
    with open_run(path) as file:
        yield file


@pytest.fixture(scope="module")
def mesh(run):
    """Corners, tetrahedra and mid-edge nodes of the file."""
    return (
        run["mesh/coordinates"][:],
        run["mesh/tetrahedra"][:],
        run["mesh/tetrahedron_mid_edges"][:],
    )


@pytest.fixture(scope="module")
def basis(mesh):
    """scikit-fem's P2 displacements on the corners of the file."""
    coordinates, tetrahedra, _ = mesh
    corners = np.unique(tetrahedra)
    assert np.array_equal(corners, np.arange(len(corners))), "corners come first"
    theirs = MeshTet(coordinates[corners].T, tetrahedra.T, sort_t=False)
    return Basis(theirs, ElementVector(ElementTetP2()), intorder=4)


@pytest.fixture(scope="module")
def order(run, mesh, basis):
    """scikit-fem's number of each free degree of freedom: its points of support are our nodes."""
    keys = {}
    for dof, place in enumerate(basis.doflocs.T):
        keys.setdefault(tuple(np.round(place, 9) + 0.0), []).append(dof)
    number = run["assemble/degree_of_freedom"][:]
    order = np.empty(number.max() + 1, dtype=int)
    for place, numbers in zip(np.round(mesh[0], 9) + 0.0, number, strict=True):
        for theirs, ours in zip(keys[tuple(place)], numbers, strict=True):
            if ours >= 0:
                order[ours] = theirs
    return order


def test_mid_edge_nodes_stand_in_the_middle(mesh):
    """On straight edges."""
    coordinates, tetrahedra, middles = mesh
    for k, (a, b) in enumerate(EDGES):
        mean = (coordinates[tetrahedra[:, a]] + coordinates[tetrahedra[:, b]]) / 2
        assert np.abs(coordinates[middles[:, k]] - mean).max() < 1e-14


def test_the_mesh_is_conforming(run, mesh):
    """Every triangle belongs to two tetrahedra or to one and the boundary; the volume is the body's."""
    coordinates, tetrahedra, _ = mesh
    sides = [np.delete(tetrahedra, k, axis=1) for k in range(4)]
    sides = np.concatenate([*sides, run["mesh/facets"][:]])
    _, counts = np.unique(np.sort(sides, axis=1), axis=0, return_counts=True)
    assert np.all(counts == 2)
    p = coordinates[tetrahedra]
    volume = np.linalg.det(p[:, 1:] - p[:, :1]) / 6
    assert volume.min() > 0
    assert volume.sum() == pytest.approx(3.0, rel=1e-13)


def test_stiffness(run, basis, order):
    """A entry by entry; both integrate polynomials exactly, so only roundings differ."""
    material = read_scene(run)["material"]["isotropic"]
    lame = lame_parameters(material["young_modulus"], material["poisson_ratio"])
    theirs = linear_elasticity(*lame).assemble(basis).tocsr()[order][:, order]
    ours = read_matrix(run["assemble/stiffness"])
    assert abs(ours - theirs).max() < 1e-12 * abs(theirs).max()


def test_load(run, basis, order):
    """l: the same two tractions."""
    tractions = {t["face"]: np.array(t["value"]) for t in read_scene(run)["traction"]}
    load = np.zeros(basis.N)
    for face, value in tractions.items():
        axis, side = "xyz".index(face[0]), face.endswith("max")
        size = [3.0, 1.0, 1.0][axis]
        at = size if side else 0.0
        facets = basis.mesh.facets_satisfying(
            lambda x, axis=axis, at=at: np.abs(x[axis] - at) < 1e-9
        )
        face_basis = FacetBasis(basis.mesh, basis.elem, facets=facets, intorder=2)
        form = LinearForm(
            lambda v, w, value=value: sum(value[c] * v[c] for c in range(3))
        )
        load += form.assemble(face_basis)
    assert np.abs(run["load/force"][:] - load[order]).max() < 1e-12 * np.abs(load).max()


def test_the_answer_is_in_equilibrium(run):
    """A u + N'lambda_nu + T'lambda_t = l for the stored arrays."""
    stiffness = read_matrix(run["assemble/stiffness"])
    normal = read_matrix(run["assemble/coupling_normal"])
    tangential = read_matrix(run["assemble/coupling_tangential"])
    load = run["load/force"][:]
    inner = normal.T @ run["solve/multiplier_normal"][:]
    inner += tangential.T @ run["solve/multiplier_tangential"][:].ravel()
    u = sparse_linalg.spsolve(stiffness, load - inner)
    number = run["assemble/degree_of_freedom"][:]
    stored = np.empty_like(u)
    stored[number[number >= 0]] = run["solve/displacement"][:][number >= 0]
    # The condition of A, about 1e5, times rounding.
    assert np.linalg.norm(u - stored) < 1e-10 * np.linalg.norm(u)


def test_the_estimate_is_the_sum_of_its_indicators(run):
    """eta^2 = sum of eta_T^2, contact included."""
    group = run["post/discretisation_error"]
    total = group["total"][()]
    assert np.linalg.norm(group["indicator"][:]) == pytest.approx(total, rel=1e-12)


def test_levels(run):
    """Levels fall to the target."""
    if "adapt" not in run:
        assert "adapt" not in read_scene(run)
        return
    target = read_scene(run)["adapt"]["error"]
    errors = run["adapt/levels/estimated_error"][:]
    assert errors[-1] <= target < errors[:-1].min()
    assert run["adapt/levels/n_tetrahedra"][-1] == len(run["mesh/tetrahedra"])
    assert run["adapt/levels/n_free"][-1] == len(run["load/force"])
    cuts = run["adapt/cuts"][:]
    assert run["adapt/n_cuts"][:].sum() == len(cuts)
    counts = run["adapt/levels/n_tetrahedra"][:]
    cells = run["adapt/cells"][:] if "adapt/cells" in run else np.zeros((len(counts) - 1, 3), int)
    anew = cells.any(axis=1)
    assert np.array_equal(run["adapt/n_cuts"][:], np.where(anew, 0, counts[:-1]))
    # Five tetrahedra a cell.
    assert np.array_equal(5 * cells.prod(axis=1)[anew], counts[1:][anew])
