"""Several contact faces, recomputed from the raw arrays: which triangles, normals and axes belong
to each face, B from them, the displacement, every condition of every law, and the forces."""

from pathlib import Path

import numpy as np
import pytest

from raw_problem import coefficient
from run_file import open_run, read_matrix, read_scene
from scipy import sparse

PIPELINES = Path(__file__).resolve().parent.parent / "pipelines"

SCENES = {
    "corner_block.toml": ["body.brick.cells=[4,4,4]"],
    "two_plates.toml": ["body.brick.cells=[8,4,4]"],
    "dry_and_greased.toml": [],
    "dry_and_greased.toml P2": ['body.element="P2"', "body.brick.cells=[12,4,2]"],
    "wedge.toml": [],
}

# Solves to 1e-12, on problems whose condition takes some digits.
TIGHT = 1e-8


class Faces:
    """The arrays of a run file with several contact faces."""

    def __init__(self, file):
        self.file, self.scene = file, read_scene(file)
        mesh, solve = file["mesh"], file["solve"]
        self.points, self.nodes = mesh["coordinates"][:], mesh["contact_nodes"][:]
        self.area, self.average = mesh["pane_area"][:], read_matrix(mesh["pane_average"])
        self.dof = file["assemble/degree_of_freedom"][:]
        self.u = solve["displacement"][:]
        self.normal = solve["multiplier_normal"][:]
        self.tangential = solve["multiplier_tangential"][:]
        names = mesh["contact_face_names"][()].decode().splitlines()
        given = {c.get("name", c["face"]): i for i, c in enumerate(self.scene["contact"])}
        self.entries = [given[name] for name in names]
        self.contacts = [self.scene["contact"][i] for i in self.entries]
        self.laws = [c.get("friction", self.scene.get("friction")) for c in self.contacts]

    def limits(self, what: str) -> list[slice]:
        """The range of nodes, facets or panes of each face."""
        limits = self.file[f"mesh/contact_face_{what}"][:]
        return [slice(a, b) for a, b in zip(limits[:-1], limits[1:], strict=True)]

    def corners(self, face: int) -> np.ndarray:
        """Corners of the triangles of a face, [n, 3, 3]."""
        facets = self.file["mesh/contact_facets"][:][self.limits("facets")[face]]
        return self.points[self.file["mesh/facets"][:][facets]]

    def frame(self, face: int) -> np.ndarray:
        """Rows: outward normal, t1, t2 = t1 x normal of a flat face without axes of its own."""
        a, b, c = self.corners(face)[0]
        normal = np.cross(b - a, c - a)
        normal /= np.linalg.norm(normal)
        x = np.eye(3)[1 if abs(normal[0]) > 1 - 1e-6 else 0]
        first = x - normal * (x @ normal)
        first /= np.linalg.norm(first)
        return np.array([normal, first, np.cross(first, normal)])

    def forces(self) -> np.ndarray:
        """The force on the body of each face, [n_faces, 3]."""
        found = []
        for face, panes in enumerate(self.limits("panes")):
            stress = np.zeros((panes.stop - panes.start, 3))
            stress[:, 0] = self.normal[panes]
            pairs = self.tangential[panes]
            stress[: len(pairs), 1:] = pairs
            found.append(-(self.area[panes] @ stress) @ self.frame(face))
        return np.array(found)


@pytest.fixture(scope="module", params=list(SCENES))
def faces(request, contact3d, tmp_path_factory):
    """A solved scene."""
    path = tmp_path_factory.mktemp("faces") / "run.h5"
    changes = [part for change in SCENES[request.param] for part in ("--set", change)]
    scene = PIPELINES / request.param.split()[0]
    contact3d("run", scene, path, "--no-figures", *changes)
    with open_run(path) as file:
        yield Faces(file)


def test_faces_with_friction_come_first(faces):
    has = [law is not None for law in faces.laws]
    assert has == sorted(has, reverse=True)
    with_friction = sum(has)
    assert len(faces.tangential) == faces.limits("panes")[with_friction - 1].stop


def test_triangles_of_each_face_are_those_of_its_name_and_box(faces):
    file = faces.file
    names = file["mesh/face_names"][()].decode().splitlines()
    of_face = np.array(names)[file["mesh/facet_face"][:]]
    corners = faces.points[file["mesh/facets"][:]]
    every = file["mesh/contact_facets"][:]
    assert len(set(every)) == len(every)
    for contact, part in zip(faces.contacts, faces.limits("facets"), strict=True):
        low, high = contact.get("box", [[-np.inf] * 3, [np.inf] * 3])
        inside = np.all((corners >= low) & (corners <= high), axis=(1, 2))
        expected = np.flatnonzero((of_face == contact["face"]) & inside)
        assert np.array_equal(np.sort(every[part]), expected)


def test_panes_and_frames_of_each_face(faces):
    file = faces.file
    pane_of = file["mesh/contact_facet_pane"][:]
    for face, (nodes, facets, panes) in enumerate(
        zip(*(faces.limits(w) for w in ("nodes", "facets", "panes")), strict=True)
    ):
        a, b, c = np.moveaxis(faces.corners(face), 1, 0)
        area = np.linalg.norm(np.cross(b - a, c - a), axis=1) / 2
        own = pane_of[facets] - panes.start
        assert np.bincount(own, weights=area) == pytest.approx(faces.area[panes], rel=1e-13)
        assert np.all(np.diff(faces.nodes[nodes]) > 0)
        frame = faces.frame(face)
        for path, row in zip(
            ("mesh/contact_node_normal", "post/contact_axis_1", "post/contact_axis_2"),
            frame,
            strict=True,
        ):
            assert np.abs(file[path][nodes] - row).max() < 1e-9
    columns = np.asarray(faces.average.sum(axis=0)).ravel()
    assert columns == pytest.approx(np.ones_like(columns), rel=1e-13)


def coupling(faces) -> sparse.csr_matrix:
    """B of the free degrees of freedom, from areas, averages, normals and axes."""
    n_free = faces.dof.max() + 1
    blocks = {0: [], 1: []}
    for face, panes in enumerate(faces.limits("panes")):
        frame = faces.frame(face)
        kinds = [(0, [frame[0]])]
        if faces.laws[face] is not None:
            kinds.append((1, frame[1:]))
        for kind, axes in kinds:
            for pane in range(panes.start, panes.stop):
                column = faces.average[:, [pane]].tocoo()
                for axis in axes:
                    row = np.zeros(n_free)
                    for node, weight in zip(column.row, column.data, strict=True):
                        for dof, part in zip(faces.dof[faces.nodes[node]], axis, strict=True):
                            if dof >= 0:
                                row[dof] += weight * faces.area[pane] * part
                    blocks[kind].append(row)
    return sparse.csr_matrix(np.array(blocks[0] + blocks[1]))


def test_coupling_and_equilibrium(faces):
    file = faces.file
    own = coupling(faces)
    names = ("coupling_normal", "coupling_tangential")
    stored = sparse.vstack([read_matrix(file[f"assemble/{name}"]) for name in names])
    # Normals of a mesh file keep the digits of its coordinates.
    assert abs(own - stored).max() < 1e-9 * abs(stored).max()
    multiplier = np.concatenate([faces.normal, faces.tangential.ravel()])
    load = file["load/force"][:]
    free = np.empty(load.size)
    free[faces.dof[faces.dof >= 0]] = faces.u[faces.dof >= 0]
    pushed = own.T @ multiplier
    left = read_matrix(file["assemble/stiffness"]) @ free + pushed - load
    assert np.abs(left).max() < TIGHT * np.abs(pushed).max()


def test_every_pane_obeys_the_law_of_its_face(faces):
    for face, (nodes, panes) in enumerate(
        zip(faces.limits("nodes"), faces.limits("panes"), strict=True)
    ):
        moved = faces.u[faces.nodes[nodes]] @ faces.frame(face).T
        average = faces.average[nodes, panes].T
        gap = -(average @ moved[:, 0])
        size = np.abs(moved).max()
        pressure = faces.normal[panes]
        assert pressure.min() >= 0
        assert gap.min() > -TIGHT * size
        assert np.max(pressure * np.abs(gap)) < TIGHT * size * pressure.max()
        if faces.laws[face] is None:
            continue
        law, stress = faces.laws[face], faces.tangential[panes]
        bound = slip_bound(law, pressure)
        inverse = average @ (1 / nodal_friction(law, np.abs(moved[:, 1:])))
        used = np.linalg.norm(inverse * stress, axis=1)
        assert np.max(used - bound) < TIGHT * bound.max()
        slip = average @ moved[:, 1:]
        inside = used < bound * (1 - 1e-6)
        assert np.abs(slip[inside]).max(initial=0) < TIGHT * size
        # The slip of a sliding pane is along the normal of its ellipse.
        normal = inverse**2 * stress
        work = np.sum(normal * slip, axis=1)
        strength = np.linalg.norm(normal, axis=1)
        missing = np.abs(work - strength * np.linalg.norm(slip, axis=1))
        assert missing.max() < TIGHT * size * strength.max()


def slip_bound(law: dict, pressure: np.ndarray) -> np.ndarray:
    """g of a law with a constant bound or cap."""
    if "slip_bound" in law:
        return np.full(pressure.shape, float(law["slip_bound"]))
    return np.minimum(pressure, law.get("pressure_cap", np.inf))


def nodal_friction(law: dict, slip: np.ndarray) -> np.ndarray:
    """F1, F2 at the nodes."""
    if "coefficient" in law:
        own = coefficient(law["coefficient"], np.linalg.norm(slip, axis=1))
        return np.column_stack([own, own])
    if "coefficient_1" not in law:
        return np.ones(slip.shape)
    pairs = ((law[f"coefficient_{i}"], slip[:, i - 1]) for i in (1, 2))
    return np.column_stack([coefficient(law, s) for law, s in pairs])


def test_forces_of_each_face(faces):
    file, forces = faces.file, faces.forces()
    keys = [f"contact.{entry}" for entry in faces.entries]
    source = [text.decode() for text in file["post/forces/source"][:]]
    stored = file["post/forces/force"][:]
    rows = [source.index(key) for key in keys]
    size = np.abs(stored).max()
    assert np.abs(stored[rows] - forces).max() < TIGHT * size
    assert np.abs(stored.sum(axis=0)).max() < TIGHT * size
    assert np.abs(file["post/forces/moment"][:].sum(axis=0)).max() < TIGHT * size * np.ptp(
        faces.points
    )
    normal = [faces.area[p] @ faces.normal[p] for p in faces.limits("panes")]
    assert file["post/faces/normal_force"][:] == pytest.approx(np.array(normal), rel=1e-12)
    zones = file["post/contact_zone"][:]
    counts = [np.bincount(zones[p], minlength=3) for p in faces.limits("panes")]
    assert np.array_equal(file["post/faces/zone_counts"][:], counts)


def run(contact3d, tmp_path, name: str, *changes: str) -> tuple[dict, np.ndarray]:
    """The force on the body by its sources, and the counts of zones by face or as a whole."""
    path = tmp_path / f"{name}.h5"
    options = [part for change in changes for part in ("--set", change)]
    contact3d("run", PIPELINES / f"{name}.toml", path, "--no-figures", *options)
    with open_run(path) as file:
        sources = [text.decode() for text in file["post/forces/source"][:]]
        several = "post/faces/zone_counts" in file
        zones = file["post/faces/zone_counts" if several else "post/zone_counts"][:]
        return dict(zip(sources, file["post/forces/force"][:], strict=True)), np.atleast_2d(zones)


@pytest.mark.parametrize("friction", [(0.3, 0.15), (0.05, 0.4)])
def test_a_wedge_is_driven_by_its_friction_angles(contact3d, tmp_path, friction):
    """F/V = tan(alpha + phi_1) + tan(phi_2) on any mesh, where all panes slide."""
    changes = [f"contact.{i}.friction.coefficient.constant={f}" for i, f in enumerate(friction)]
    forces, zones = run(contact3d, tmp_path, "wedge", *changes)
    assert not zones[:, :2].any()
    top, base = forces["contact.0"], forces["contact.1"]
    assert -top[2] == pytest.approx(base[2], rel=1e-9)
    alpha, (first, second) = np.arctan(0.2), np.arctan(friction)
    ratio = np.tan(alpha + first) + np.tan(second)
    assert -forces["clamp.0"][0] / base[2] == pytest.approx(ratio, rel=1e-9)


def test_a_block_between_plates_is_held_by_both(contact3d, tmp_path):
    """What the clamp bears is the push less mu N of one plate and g times the area of the other."""
    forces, zones = run(contact3d, tmp_path, "two_plates", "body.brick.cells=[8,4,4]")
    assert not zones[:, :2].any()
    resisted = 0.3 * forces["contact.0"][2] + 2e6 * 2.0
    assert forces["clamp.0"][0] == pytest.approx(1e8 - resisted, rel=1e-9)


@pytest.mark.parametrize("push", [1.01, 1.001])
def test_a_block_is_pushed_up_a_slope_at_its_limit(contact3d, tmp_path, push):
    """F/G = (tan(alpha) + mu)/(1 - mu tan(alpha)): the spring bears what exceeds it."""
    forces, zones = run(contact3d, tmp_path, "slope", f"parameters.push={push}")
    assert zones[0, 1] == 0
    alpha, mu, weight = np.radians(20.0), 0.3, 1e6
    limit = weight * (np.tan(alpha) + mu) / (1 - mu * np.tan(alpha))
    expected = (push - 1) * limit * (np.cos(alpha) - mu * np.sin(alpha))
    # Balance of forces: the spring pushes along the slope alone.
    assert -forces["spring.0"][0] == pytest.approx(expected, abs=1e-9 * weight)
