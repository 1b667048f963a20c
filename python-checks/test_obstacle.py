"""Obstacles and curved faces: normals, distances, coupling and the contact conditions from the raw arrays."""

import numpy as np
import pytest
from scipy.integrate import dblquad
from scipy.optimize import minimize
from scipy.spatial import ConvexHull

from conftest import ROOT
from run_file import open_run, read_matrix, read_scene

CASES = {
    "hertz_sphere.toml": ["body.brick.cells=[6,6,6]"],
    "hertz_cylinder.toml": ["body.brick.cells=[12,1,12]"],
    "cup.toml": [],
    "wavy.toml": ["body.brick.cells=[24,12,2]"],
}


@pytest.fixture(scope="module", params=CASES)
def run(request, contact3d, tmp_path_factory):
    """A run file of a pipeline with an obstacle."""
    path = tmp_path_factory.mktemp("obstacle") / "run.h5"
    changes = [part for change in CASES[request.param] for part in ("--set", change)]
    contact3d("run", ROOT / "pipelines" / request.param, path, "--no-figures", *changes)
    with open_run(path) as file:
        yield file


def places(run):
    """Coordinates of the contact nodes."""
    return run["mesh/coordinates"][:][run["mesh/contact_nodes"][:]]


def wave(parameters, x):
    """The surface of wavy.toml."""
    k = 2 * np.pi / parameters["length"]
    return parameters["depth"] * (np.cos(k * x[0]) * np.cos(k * x[1]) - 1)


def nearest(scene, point):
    """The point of the obstacle's surface next to a point, and the outward direction there."""
    obstacle = scene["contact"]["obstacle"]
    if "height" in obstacle:
        parameters = scene["parameters"]
        scale = parameters["length"]

        def square(x):
            across = (x * scale - point[:2]) / scale
            return across @ across + ((wave(parameters, x * scale) - point[2]) / scale) ** 2

        start = point[:2] / scale
        x = minimize(square, start, method="BFGS", options={"gtol": 1e-13}).x * scale
        step = 1e-6 * scale
        slope = [
            (wave(parameters, x + step * e) - wave(parameters, x - step * e)) / (2 * step)
            for e in np.eye(2)
        ]
        away = np.array([-slope[0], -slope[1], 1.0])
        return np.array([*x, wave(parameters, x)]), away / np.linalg.norm(away)
    (shape,) = obstacle.values()
    inside = -1.0 if shape.get("side") == "inside" else 1.0
    offset = point - np.array(shape.get("centre", shape.get("point")))
    if "direction" in shape:
        axis = np.array(shape["direction"]) / np.linalg.norm(shape["direction"])
        offset = offset - (offset @ axis) * axis
    outward = offset / np.linalg.norm(offset)
    return point - offset + shape["radius"] * outward, inside * outward


def test_normals_and_distances(run):
    """nu points to the nearest point of the obstacle, d is the distance from it."""
    scene, at = read_scene(run), places(run)
    normals, distance = run["mesh/contact_node_normal"][:], run["mesh/contact_clearance"][:]
    size = np.ptp(at, axis=0).max()
    # The minimiser finds squares to rounding, so places to its root; differences of slopes are as good.
    limit = 1e-7 if "height" in scene["contact"]["obstacle"] else 1e-13
    radius = next(iter(scene["contact"]["obstacle"].values())).get("radius", size)
    for x, normal, d in zip(at, normals, distance, strict=True):
        foot, away = nearest(scene, x)
        assert np.abs(normal + away).max() < limit
        # Roundings of the radius.
        assert abs((x - foot) @ away - d) < limit * max(size, radius)
    assert distance.min() >= 0
    assert "contact_normal" not in run["mesh"]


def test_coupling(run):
    """N and T: integrals of hat functions over panes times nu, t1 and t2 of each node."""
    average, area = read_matrix(run["mesh/pane_average"]), run["mesh/pane_area"][:]
    number = run["assemble/degree_of_freedom"][:][run["mesh/contact_nodes"][:]]
    normals = run["mesh/contact_node_normal"][:]
    axes = [run[f"post/contact_axis_{k}"][:] for k in (1, 2)]
    assert np.abs(axes[1] - np.cross(axes[0], normals)).max() < 1e-14
    assert np.abs(np.sum(axes[0] * normals, axis=1)).max() < 1e-14

    def rows(direction):
        matrix = np.zeros((area.size, run["load/force"].shape[0]))
        weights = average.toarray() * area
        for node, dofs in enumerate(number):
            for component in np.flatnonzero(dofs >= 0):
                matrix[:, dofs[component]] += weights[node] * direction[node, component]
        return matrix

    found = read_matrix(run["assemble/coupling_normal"]).toarray()
    assert np.abs(found - rows(normals)).max() < 1e-14 * np.abs(found).max()
    if "coupling_tangential" in run["assemble"]:
        found = read_matrix(run["assemble/coupling_tangential"]).toarray()
        for k in range(2):
            assert np.abs(found[k::2] - rows(axes[k])).max() < 1e-14 * np.abs(found).max()


def test_contact_conditions(run):
    """Pressure where there is no distance left, none elsewhere; the forces are those of the tractions."""
    average, area = read_matrix(run["mesh/pane_average"]), run["mesh/pane_area"][:]
    nodes, normals = run["mesh/contact_nodes"][:], run["mesh/contact_node_normal"][:]
    displacement = run["solve/displacement"][:][nodes]
    left = run["mesh/contact_clearance"][:] - np.sum(displacement * normals, axis=1)
    gap = average.T @ left
    pressure = run["solve/multiplier_normal"][:]
    assert np.abs(run["post/pane_gap"][:] - gap).max() < 1e-12 * np.abs(displacement).max()
    # The accuracy of the answer, 1e-12 of the stresses, through a body that is soft at single panes.
    assert gap.min() > -1e-9 * np.abs(displacement).max()
    assert np.abs(gap[pressure > 0]).max() < 1e-9 * np.abs(displacement).max()
    assert 0 < np.count_nonzero(pressure) < pressure.size
    force = run["post/contact_traction"][:].T @ area
    stored = run["post/resultants/contact_force"][:]
    assert np.abs(force - stored).max() < 1e-12 * np.abs(stored).max()


def test_area_of_a_curved_face(run):
    """Panes of a round face have the area of the ball that its nodes lie on."""
    scene = read_scene(run)
    if "gmsh" not in scene["body"]:
        pytest.skip("flat")
    edge, radius = 10.0, 40.0

    def density(y, x):
        return radius / np.sqrt(radius**2 - x * x - y * y)

    exact, _ = dblquad(density, 0.0, edge, 0.0, edge)
    # Quadratic sides miss the ball by (h/R)^4 of it, h being a quarter of R at most.
    assert run["mesh/pane_area"][:].sum() == pytest.approx(exact, rel=1e-4)
    x = places(run)
    centre = np.array([0.0, 0.0, radius])
    assert np.linalg.norm(x - centre, axis=1) == pytest.approx(radius, rel=1e-14)


def nearest_on_triangles(x, corners):
    """The nearest point of some triangles, each of them looked at."""
    a, b, c = corners.transpose(1, 0, 2)
    normal = np.cross(b - a, c - a)
    normal /= np.linalg.norm(normal, axis=1)[:, None]
    feet = [x - np.sum((x - a) * normal, axis=1)[:, None] * normal]
    sides = [np.sum(np.cross(q - p, feet[0] - p) * normal, axis=1) for p, q in ((a, b), (b, c), (c, a))]
    feet[0][np.min(sides, axis=0) < 0] = np.inf
    for p, q in ((a, b), (b, c), (c, a)):
        part = np.clip(np.sum((x - p) * (q - p), axis=1) / np.sum((q - p) ** 2, axis=1), 0, 1)
        feet.append(p + part[:, None] * (q - p))
    feet = np.concatenate(feet)
    return feet[np.argmin(np.linalg.norm(feet - x, axis=1))]


@pytest.mark.parametrize("angle", [0, 30])
def test_triangles(angle, contact3d, tmp_path):
    """A polyhedron with sharp edges: distances and normals from all triangles. A crowned roller: those of the torus."""
    scene = (ROOT / "pipelines/barrel.toml").read_text().replace("meshes/", str(ROOT / "pipelines/meshes") + "/")
    if angle == 0:
        hull = ConvexHull(np.random.default_rng(46).normal(size=(40, 3)) * 6.0 + [6.0, 6.0, 36.0])
        outward = [np.linalg.det(hull.points[s] - hull.points.mean(axis=0)) > 0 for s in hull.simplices]
        corners = [hull.points[s if out else s[::-1]] for s, out in zip(hull.simplices, outward, strict=True)]
        record = np.zeros(len(corners), [("numbers", "<f4", 12), ("rest", "<u2")])
        record["numbers"][:, 3:] = np.reshape(corners, (-1, 9))
        (tmp_path / "hull.stl").write_bytes(bytes(80) + np.uint32(len(corners)).tobytes() + record.tobytes())
        start, end = scene.index("{ file"), scene.index("}", scene.index("{ file"))
        scene = scene[:start] + '{ file = "hull.stl", sharp_angle = 0 ' + scene[end:]
    (tmp_path / "scene.toml").write_text(scene)
    contact3d("mesh", tmp_path / "scene.toml", tmp_path / "run.h5")
    with open_run(tmp_path / "run.h5") as file:
        at, distance = places(file), file["mesh/contact_clearance"][:]
        normals = file["mesh/contact_node_normal"][:]
        corners = file["mesh/obstacle_points"][:][file["mesh/obstacle_triangles"][:]]
        assert set(file["mesh/obstacle_contact"][:]) == {0}
    feet = np.array([nearest_on_triangles(x, corners) for x in at])
    to_feet = np.linalg.norm(feet - at, axis=1)
    if angle == 0:
        assert np.abs(distance - to_feet).max() < 1e-13 * to_feet.max()
        assert np.abs(normals - (feet - at) / to_feet[:, None]).max() < 1e-13
        return
    around = np.hypot(at[:, 0], at[:, 2] - 56.0)
    across = np.stack([around + 40.0, at[:, 1]], axis=1)
    reach = np.linalg.norm(across, axis=1)
    # Facets lie up to h^2/8 (1/40 + 1/80) = 1e-2 mm inside the roller. Numbers of the STL are good to 1e-4 mm, normals at its corners worse.
    assert np.abs(distance - (reach - 80.0)).max() < 1.2e-3 < 3e-3 < np.abs(distance - to_feet).max()
    away = np.stack([across[:, 0] * at[:, 0] / around, at[:, 1], across[:, 0] * (at[:, 2] - 56.0) / around], axis=1)
    assert np.abs(normals + away / reach[:, None]).max() < 2e-3


RING = ROOT / "pipelines" / "shrink_fit.toml"


def lame(ratio, depth=0.02, inner=20.0, outer=30.0, modulus=2.1e5):
    """Pressure in MPa and the two terms of u(r) = A r + B/r in plane strain, free outside, moved by the depth inside."""
    second = depth / (1.0 / inner + (1.0 - 2.0 * ratio) * inner / outer**2)
    first = (1.0 - 2.0 * ratio) * second / outer**2
    return modulus * second * (1.0 / inner**2 - 1.0 / outer**2) / (1.0 + ratio), first, second


@pytest.mark.parametrize("friction", [0.0, 0.2])
def test_a_shrunk_ring_is_pressed_as_lame_says(friction, contact3d, tmp_path):
    changes = ["--set", f"friction.coefficient.constant={friction}"] if friction else []
    contact3d("run", "--no-figures", RING, tmp_path / "ring.h5", *changes)
    pressure, first, second = lame(0.3)
    with open_run(tmp_path / "ring.h5") as file:
        names = [name.decode() for name in file["solve/quantities/name"][:]]
        closed = file["solve/quantities/value"][names.index("contact_area")]
        found, area = file["solve/multiplier_normal"][:], file["mesh/pane_area"][:]
        x, u = file["mesh/coordinates"][:], file["solve/displacement"][:]
        assert np.abs(file["mesh/contact_clearance"][:] + 0.02).max() < 1e-12
        assert area.sum() == pytest.approx(np.pi / 2 * 20.0 * 10.0, rel=1e-4)
        # All panes are closed; sides of quadratic triangles differ from those of panes by rounding.
        assert closed == pytest.approx(area.sum(), rel=1e-10)
        if friction:
            # The ring moves along the radius, so nothing rubs; the mesh is not the same in both directions.
            assert np.abs(file["solve/multiplier_tangential"][:]).max() < 0.02 * pressure
    # Four cells through the ring: 0.1 % in the mean, 2 % in a pane.
    assert area @ found / area.sum() == pytest.approx(pressure, rel=2e-3)
    assert np.abs(found / pressure - 1.0).max() < 0.03
    radius = np.hypot(x[:, 0], x[:, 1])
    along = (x[:, 0] * u[:, 0] + x[:, 1] * u[:, 1]) / radius
    expected = first * radius + second / radius
    assert np.abs(along - expected).max() < 5e-3 * expected.max()


@pytest.mark.parametrize("share, code", [(0.8, 0), (1.2, 1)])
def test_a_shrunk_ring_holds_what_friction_bears(share, code, contact3d, tmp_path):
    """Without Poisson's effect nothing else holds the ring along the shaft."""
    pressure, *_ = lame(0.0)
    push = share * 0.2 * pressure * np.pi / 2 * 20.0 * 10.0
    text = RING.read_text().replace("meshes/ring.msh", str(RING.parent / "meshes/ring.msh"))
    start, end = text.index("[[clamp]]                  # plane strain"), text.index("[contact]")
    text = text[:start] + f'[[force]]\nface = "z_max"\nvalue = [0.0, 0.0, {push}]\n\n' + text[end:]
    text += "\n[friction]\ncoefficient.constant = 0.2\n"
    (tmp_path / "ring.toml").write_text(text.replace("poisson_ratio = 0.3", "poisson_ratio = 0.0"))
    contact3d("run", "--no-figures", tmp_path / "ring.toml", tmp_path / "ring.h5", expect=code)
    if code == 0:
        with open_run(tmp_path / "ring.h5") as file:
            assert file["post/resultants/contact_force"][2] == pytest.approx(-push, rel=1e-9)


def test_depth_is_asked_for_and_bounded(contact3d, tmp_path):
    text = RING.read_text().replace("meshes/ring.msh", str(RING.parent / "meshes/ring.msh"))
    for old, new, words in [
        ("interference = true", "", ("contact.obstacle.cylinder", "interference = true")),
        ("radius = 20.02", "radius = 25.0", ("contact.interference", "0.1 of the body's size")),
        ("interference = true", "gap = -0.01", ("contact.gap", "interference = true")),
    ]:
        (tmp_path / "ring.toml").write_text(text.replace(old, new))
        result = contact3d("run", tmp_path / "ring.toml", tmp_path / "ring.h5", expect=2)
        assert all(word in result.stderr for word in words), result.stderr
        assert not (tmp_path / "ring.h5").exists()
    # Steps close it: the ring is open by 0.01 mm at first, and shrunk in two increments.
    steps = "\n[[step]]\nvalue.\"contact.gap\" = 0.03\n[[step]]\nincrements = 2\nvalue.\"contact.gap\" = 0.0\n"
    (tmp_path / "ring.toml").write_text(text + steps)
    contact3d("run", "--no-figures", tmp_path / "ring.toml", tmp_path / "ring.h5")
    with open_run(tmp_path / "ring.h5") as file:
        area, found = file["mesh/pane_area"][:], file["history/multiplier_normal"][:]
    assert found[0].max() == 0.0 and found[2] @ area / area.sum() == pytest.approx(lame(0.3)[0], rel=2e-3)
