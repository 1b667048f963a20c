"""Prescribed displacements, springs and reactions, computed again from coordinates and the scene."""

import numpy as np
import pytest
from scipy.sparse.linalg import splu
from scipy.spatial import cKDTree
from skfem import (
    Basis,
    BilinearForm,
    ElementTetP1,
    ElementTetP2,
    ElementVector,
    FacetBasis,
    LinearForm,
    MeshTet,
)
from skfem.models.elasticity import lame_parameters, linear_elasticity

from conftest import ROOT
from run_file import open_run, read_matrix

SIZE = (1.2, 0.8, 0.6)
YOUNG, POISSON = 2e11, 0.3
TENSOR = ((5e11, 1e11, 0.0), (1e11, 4e11, -1e11), (0.0, -1e11, 3e11))

# Clamps: face, held components, displacement at points [3, n]; two of them meet at an edge and agree there.
CLAMPS = (
    ("z_max", (0, 1, 2), lambda x: (2e-6 + 0 * x[0], 1e-6 * x[0], -1e-5 * (1 + x[1]))),
    ("x_max", (1,), lambda x: (0 * x[0], 1e-6 * x[0], 0 * x[0])),
)
# Springs: face, stiffness [3, 3, n] at points for an outward normal.
SPRINGS = (
    ("x_min", lambda x, n: outer(n) * 1e12 * (1 + x[1]) + (unit(x) - outer(n)) * 3e11),
    ("y_max", lambda x, n: np.array(TENSOR)[:, :, None, None] * (1 + x[2])),
)
TRACTION = ("x_max", (1e6, 3e6, -2e6))

SCENE = f"""
title = "supports"
[body]
element = "ELEMENT"
[body.brick]
size = {list(SIZE)}
cells = [6, 4, 4]
[material.isotropic]
young_modulus = {YOUNG}
poisson_ratio = {POISSON}
[[clamp]]
face = "z_max"
value = [2e-6, "1e-6*x", "-1e-5*(1 + y)"]
[[clamp]]
face = "x_max"
components = ["y"]
value = [0.0, "1e-6*x", 0.0]
[[spring]]
face = "x_min"
normal = "1e12*(1 + y)"
tangential = 3e11
[[spring]]
face = "y_max"
tensor = {[[f"{k}*(1 + z)" for k in row] for row in TENSOR]}
[[traction]]
face = "x_max"
value = {list(TRACTION[1])}
[contact]
face = "z_min"
gap = 2e-6
multipliers = "MULTIPLIERS"
[friction]
coefficient.ramp = {{ initial = 0.3, residual = 0.2, onset = 1e-7, rate = 3e4 }}
"""


def unit(x):
    """The unit tensor at points, [3, 3, ...]."""
    return np.eye(3).reshape(3, 3, 1, 1) * np.ones_like(x[0])


def outer(n):
    """n n' at points, [3, 3, ...]."""
    return np.einsum("i...,j...->ij...", n, n)


class Body:
    """The scene in scikit-fem, with the node numbers of the file."""

    def __init__(self, file, element):
        mesh = file["mesh"]
        corners = mesh["tetrahedra"][:]
        self.nodes = mesh["coordinates"][:]
        # Corners come first, whatever the element.
        used = np.unique(corners)
        place = np.full(len(self.nodes), -1)
        place[used] = np.arange(len(used))
        self.mesh = MeshTet(self.nodes[used].T, place[corners].T)
        scalar = {"P1": ElementTetP1, "P2": ElementTetP2}[element]()
        self.element = ElementVector(scalar)
        self.basis = Basis(self.mesh, self.element, intorder=4)
        distance, nearest = cKDTree(self.nodes).query(self.basis.doflocs.T)
        assert distance.max() < 1e-12
        # The place of each of scikit-fem's degrees of freedom among 3 a node.
        component = np.empty(self.basis.N, dtype=int)
        for dofs in (self.basis.nodal_dofs, self.basis.edge_dofs):
            for c in range(min(3, len(dofs))):
                component[dofs[c]] = c
        self.order = 3 * nearest + component
        lame = lame_parameters(YOUNG, POISSON)
        self.elastic = self.sorted(linear_elasticity(*lame).assemble(self.basis))

    def facets(self, face):
        """The triangles of a face."""
        axis, end = "xyz".index(face[0]), face.split("_")[1]
        value = SIZE[axis] if end == "max" else 0.0
        return self.mesh.facets_satisfying(
            lambda x: np.isclose(x[axis], value, atol=1e-9), boundaries_only=True
        )

    def face_nodes(self, face):
        axis, end = "xyz".index(face[0]), face.split("_")[1]
        value = SIZE[axis] if end == "max" else 0.0
        return np.isclose(self.nodes[:, axis], value, atol=1e-9)

    def on(self, face):
        return FacetBasis(
            self.mesh, self.element, facets=self.facets(face), intorder=6
        )

    def sorted(self, matrix):
        """A matrix of scikit-fem by the nodes of the file."""
        back = np.empty_like(self.order)
        back[self.order] = np.arange(self.order.size)
        return matrix.tocsc()[back][:, back]

    def spring(self, face, stiffness):
        """The stiffness of a spring."""

        @BilinearForm
        def form(u, v, w):
            return np.einsum("i...,ij...,j...->...", v, stiffness(w.x, w.n), u)

        return self.sorted(form.assemble(self.on(face)))

    def traction(self, face, value):
        """Nodal forces of a constant traction, [n_nodes, 3]."""
        form = LinearForm(lambda v, w: sum(value[i] * v[i] for i in range(3)))
        forces = np.empty(self.basis.N)
        forces[self.order] = form.assemble(self.on(face))
        return forces.reshape(-1, 3)


@pytest.fixture(
    scope="module",
    params=[("P1", "panes"), ("P2", "panes"), ("P1", "nodal"), ("P2", "nodal")],
    ids="-".join,
)
def case(request, contact3d, tmp_path_factory):
    """A run file with its body."""
    element, multipliers = request.param
    folder = tmp_path_factory.mktemp("supports")
    scene, path = folder / "scene.toml", folder / "run.h5"
    text = SCENE.replace("ELEMENT", element).replace("MULTIPLIERS", multipliers)
    scene.write_text(text)
    contact3d("run", scene, path, "--no-figures")
    with open_run(path) as file:
        yield file, Body(file, element)


def close(found, expected, tolerance):
    """Distance over the largest expected entry."""
    found, expected = np.asarray(found), np.asarray(expected)
    assert abs(found - expected).max() <= tolerance * abs(expected).max()


def prescribed(body):
    """Held components and their displacement, [n_nodes, 3] both."""
    held, values = np.zeros(body.nodes.shape, dtype=bool), np.zeros(body.nodes.shape)
    for face, components, value in CLAMPS:
        nodes = body.face_nodes(face)
        given = np.array(value(body.nodes[nodes].T)).T
        for c in components:
            held[nodes, c] = True
            values[nodes, c] = given[:, c]
    return held, values


def contact_forces(file):
    """Forces of the foundation on all nodes, and B over all nodes."""
    mesh, post, solve = file["mesh"], file["post"], file["solve"]
    average, area = read_matrix(mesh["pane_average"]), mesh["pane_area"][:]
    nodes, n = mesh["contact_nodes"][:], len(file["mesh/coordinates"])
    axes = [post["contact_axis_1"][:], post["contact_axis_2"][:]]
    normal = np.broadcast_to([0.0, 0.0, -1.0], axes[0].shape)
    weights = (average.toarray() * area).T
    rows = [np.zeros((area.size, n, 3)) for _ in range(3)]
    for row, direction in zip(rows, [normal, *axes], strict=True):
        row[:, nodes] = weights[:, :, None] * direction
    pairs = np.stack(rows[1:], axis=1).reshape(2 * area.size, n, 3)
    coupling = np.concatenate([rows[0], pairs])
    multiplier = np.concatenate(
        [solve["multiplier_normal"][:], solve["multiplier_tangential"][:].ravel()]
    )
    return -np.tensordot(multiplier, coupling, axes=1), coupling


def test_equations(case):
    """A, l - A_fc u_c and h with the held contact nodes where they are held."""
    file, body = case
    springs = sum(body.spring(*spring) for spring in SPRINGS)
    stiffness = (body.elastic + springs).tocsc()
    held, values = prescribed(body)
    free = ~held.ravel()
    stored = read_matrix(file["assemble/stiffness"]).tocsc()
    # Sums over the tetrahedra and triangles of a node in other orders, by rules of quadrature.
    difference = abs(stored - stiffness[free][:, free]).max()
    assert difference <= 1e-12 * abs(stored).max()
    assert abs(stored - stored.T).max() == 0.0
    close(file["load/prescribed_displacement"][:], values, 1e-15)
    load = body.traction(*TRACTION).ravel()
    taken = stiffness @ values.ravel()
    close(file["load/force"][:], (load - taken)[free], 1e-11)
    _, coupling = contact_forces(file)
    flat = coupling.reshape(len(coupling), -1)
    u = values.ravel().copy()
    u[free] = splu(stored).solve(file["load/force"][:])
    rhs = flat @ u
    area = file["mesh/pane_area"][:]
    rhs[: area.size] -= 2e-6 * area
    # Backsolves with a condition number near 1e4.
    close(file["load/dual_rhs"][:], rhs, 1e-10)


def test_reactions(case):
    """Forces on the body by their sources, energies and works."""
    file, body = case
    held, values = prescribed(body)
    u = file["solve/displacement"][:]
    assert np.array_equal(u[held], file["load/prescribed_displacement"][:][held])
    close(u[held], values[held], 1e-15)
    foundation, _ = contact_forces(file)
    springs = [body.spring(*spring) for spring in SPRINGS]
    of_springs = [-(matrix @ u.ravel()).reshape(-1, 3) for matrix in springs]
    load = body.traction(*TRACTION)
    internal = (body.elastic @ u.ravel()).reshape(-1, 3)
    reaction = internal - load - foundation - sum(of_springs)
    scale = abs(reaction).max()
    # What is left where nothing holds: the solve to 1e-12 and backsolves.
    assert abs(reaction[~held]).max() < 1e-9 * scale
    reaction[~held] = 0.0
    holds = np.zeros((len(CLAMPS), *held.shape))
    for number, (face, components, _) in enumerate(CLAMPS):
        for c in components:
            holds[number, body.face_nodes(face), c] = 1.0
    shares = holds / np.maximum(holds.sum(axis=0), 1.0)
    parts = [*(share * reaction for share in shares), *of_springs, load, foundation]
    names = ["clamp.0", "clamp.1", "spring.0", "spring.1", "traction.0", "contact"]
    faces = ["z_max", "x_max", "x_min", "y_max", "x_max", "z_min"]
    stored = file["post/forces"]
    assert stored["source"].asstr()[:].tolist() == names
    assert stored["face"].asstr()[:].tolist() == faces
    close(stored["force"][:], [part.sum(axis=0) for part in parts], 1e-9)
    moments = [np.cross(body.nodes, part).sum(axis=0) for part in parts]
    close(stored["moment"][:], moments, 1e-9)
    largest = abs(stored["force"][:]).max()
    assert abs(stored["force"][:].sum(axis=0)).max() < 1e-9 * largest
    resultants = file["post/resultants"]
    in_springs = -0.5 * sum((part * u).sum() for part in of_springs)
    expected = {
        "strain_energy": 0.5 * (internal * u).sum() + in_springs,
        "spring_energy": in_springs,
        "load_work": (load * u).sum(),
        "clamp_work": (reaction * u).sum(),
    }
    for name, value in expected.items():
        assert resultants[name][()] == pytest.approx(value, rel=1e-9), name


def test_a_force_on_a_disc_is_a_traction_there(contact3d, tmp_path):
    """Resultants of the stored load, and its parts: a + w x r at points of a circle, times quadratic shape functions."""
    path = tmp_path / "disc.h5"
    contact3d("run", ROOT / "pipelines/force_on_disc.toml", path, "--no-figures")
    centre, radius = np.array([0.13, 0.1, 0.1]), 0.04
    force, moment = np.array([5e3, 0.0, -5e4]), np.array([0.0, 0.0, 2e2])
    with open_run(path) as file:
        x = file["mesh/coordinates"][:]
        # Nothing is held, so all components are free.
        load = file["load/force"][:].reshape(x.shape)
        corners, middles = file["mesh/facets"][:], file["mesh/facet_mid_edges"][:]
    close(load.sum(axis=0), force, 1e-13)
    close(np.cross(x - centre, load).sum(axis=0), moment, 1e-12)
    # Rings and sectors of equal area, for which the error is that of midpoints, and of kinks at edges of triangles.
    rings, sectors = 400, 1600
    distance = radius * np.sqrt((np.arange(rings) + 0.5) / rings)
    angle = 2 * np.pi * (np.arange(sectors) + 0.5) / sectors
    r = np.stack([np.outer(distance, np.cos(angle)), np.outer(distance, np.sin(angle))], axis=-1).reshape(-1, 2)
    turning = moment[2] / (np.pi * radius**4 / 2)
    traction = np.tile(force / (np.pi * radius**2), (len(r), 1))
    traction[:, :2] += turning * np.stack([-r[:, 1], r[:, 0]], axis=1)
    expected = np.zeros_like(load)
    top = np.isclose(x[corners][:, :, 2], centre[2]).all(axis=1)
    taken = np.zeros(len(r), dtype=bool)
    for nodes in np.hstack([corners, middles])[top]:
        a, b, c = x[nodes[:3], :2]
        share = np.linalg.solve(np.column_stack([b - a, c - a]), (r + centre[:2] - a).T)
        share = np.vstack([1 - share.sum(axis=0), share])
        inside = (share >= 0).all(axis=0) & ~taken
        taken |= inside
        p, q, s = share[:, inside]
        shape = [p * (2 * p - 1), q * (2 * q - 1), s * (2 * s - 1), 4 * p * q, 4 * q * s, 4 * s * p]
        expected[nodes] += np.array(shape) @ traction[inside] * (np.pi * radius**2 / len(r))
    assert taken.all()
    close(load, expected, 2e-3)
