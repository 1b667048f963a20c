"""Two bodies that touch: exact states, images, limits and published numbers, and random scenes against a checker of its own."""

import itertools
import json
import math

import contact3d as package
import h5py
import numpy as np
import pytest
from scipy.linalg import eigvalsh

from conftest import ROOT
from faults.program import Program
from pairs import POINTS, WEIGHTS, Face, judge, overlaps, random_scene, stiffness, triangle_shape, wrong_with
from run_file import open_run, read_matrix, read_scene
from structured_mesh import mesh_text


STEEL = "material.isotropic = { young_modulus = 1.0, poisson_ratio = 0.3 }"


@pytest.fixture
def solved(contact3d, tmp_path):
    """Solves a scene and returns its file."""

    def solve(text, name="pair"):
        scene, file = tmp_path / f"{name}.toml", tmp_path / f"{name}.h5"
        scene.write_text(f'title = "{name}"\n{text}')
        contact3d("run", scene, file, "--no-figures")
        return file

    return solve


def bodies(cells, element="P1", origins=((0, 0, 0), (0, 0, 1)), names=("lower", "upper"), sizes=(1.0, 1.0), upper=""):
    """Tables of two bricks."""
    text = []
    for name, n, origin, size, own in zip(names, cells, origins, sizes, ("", upper), strict=True):
        n = n if isinstance(n, list) else [n, n, n]
        size = size if isinstance(size, list) else [size, size, size]
        text.append(f'[[body]]\nname = "{name}"\nelement = "{element}"\n{own}\norigin = {[float(x) for x in origin]}')
        text.append(f"brick = {{ size = {size}, cells = {n} }}")
    return "\n".join(text) + "\n"


@pytest.mark.parametrize("number", range(6))
def test_random_scenes(number, program, tmp_path):
    """Areas, products, normals, gaps, N, T and the solution, made again; `pairs.py --scenes 200` has more of them."""
    status, wrong = judge(Program.find(program), random_scene(11, number, tmp_path), tmp_path)
    assert wrong is None
    assert status in ("converged", "no_equilibrium")
    if number == 0:
        with h5py.File(tmp_path / "pair.h5", "r+") as changed:
            changed["mesh/opposite_integrals"][0] *= 1.0 + 1e-6
        assert "products" in wrong_with(tmp_path / "pair.h5")[1]


def turned_blocks(cells, element, folder, cut=1.0):
    """Two turned blocks under the tractions of a full constant stress, the lower one on six supports that a rigid motion alone loads.

    The upper one ends at `cut`, where a third one, `rest`, begins. The tables of the scene, the rotation and the stress."""
    draw = np.random.default_rng(3)
    turn, _ = np.linalg.qr(draw.normal(size=(3, 3)))
    turn *= np.linalg.det(turn)
    shift = draw.uniform(-1, 1, 3)
    stress = turn @ np.array([[-0.2, 0.1, 0.2], [0.1, 0.3, -0.1], [0.2, -0.1, -1.0]]) @ turn.T * 1e-3
    lines = [STEEL]
    blocks = [("lower", 0, 0.0, 1.0), ("upper", 1, 0.0, cut), ("rest", 1, cut, 1.0)][: 2 + (cut < 1.0)]
    for name, k, start, end in blocks:

        def place(x, y, z, k=k, start=start, end=end):
            return tuple(map(float, turn @ [start + (end - start) * x, y, z + k] + shift))

        (folder / f"{name}.msh").write_text(mesh_text(place, (cells[k],) * 3, element))
        lines.append(f'[[body]]\nname = "{name}"\nelement = "{element}"\ngmsh.file = "{name}.msh"')
    for corner, components in (((0, 0, 0), "xyz"), ((1, 0, 0), "yz"), ((0, 1, 0), "z")):
        at = turn @ np.array(corner) + shift
        box = [(at - 1e-6).tolist(), (at + 1e-6).tolist()]
        lines.append(f"[[clamp]]\nbox = {box}\ncomponents = {list(components)}".replace("'", '"'))
    for name, k, *_ in blocks:
        for axis in range(3):
            for end, side in ((-1, "min"), (1, "max")):
                if (axis, end) != (2, 1 - 2 * k):
                    traction = end * stress @ turn[:, axis]
                    lines.append(f'[[traction]]\nface = "{name}.{"xyz"[axis]}_{side}"\nvalue = {traction.tolist()}')
    return lines, turn, stress


def strained(file, stress):
    """How far the displacement over the strain is from that of a constant stress and one rigid motion."""
    x, u = file["mesh/coordinates"][:], file["solve/displacement"][:]
    strain = 1.3 * stress - 0.3 * np.trace(stress) * np.eye(3)
    centred = x - x.mean(axis=0)
    modes = np.array([np.tile(e, (len(x), 1)) for e in np.eye(3)] + [np.cross(e, centred) for e in np.eye(3)]).reshape(6, -1).T
    rest = (u - x @ strain).ravel()
    rest = rest - modes @ np.linalg.lstsq(modes, rest, rcond=None)[0]
    return np.abs(rest).max() / np.abs(strain).max()


@pytest.mark.parametrize(
    ("element", "cells", "panes"),
    [("P1", (4, 6), "lower.z_max"), ("P1", (6, 4), "lower.z_max"), ("P2", (1, 3), "upper.z_min"), ("P2", (3, 2), "upper.z_min")],
)
def test_constant_stress_in_any_pose(element, cells, panes, solved, tmp_path):
    """The upper block is held by contact alone."""
    lines, turn, stress = turned_blocks(cells, element, tmp_path)
    lines.append(f'[contact]\nbetween = ["lower.z_max", "upper.z_min"]\npanes_on = "{panes}"\n[friction]\ncoefficient.constant = 0.9')
    with open_run(solved("\n".join(lines))) as file:
        pressure, shear = file["solve/multiplier_normal"][:], file["solve/multiplier_tangential"][:]
        normal = turn[:, 2] * (1 if panes.startswith("lower") else -1)
        assert np.abs(pressure + normal @ stress @ normal).max() < 1e-10 * pressure.max()
        for k in range(2):
            axis = file[f"post/contact_axis_{k + 1}"][:][0]
            assert np.abs(shear[:, k] + axis @ stress @ normal).max() < 1e-10 * pressure.max()
        assert strained(file, stress) < 1e-10


@pytest.mark.parametrize(("element", "cells"), [("P1", (3, 2)), ("P2", (1, 2))])
def test_glued_nodes_follow_by_dual_functions(element, cells, solved, tmp_path):
    """T from faces clipped here and dual functions on whole triangles, T'AT from an assembly here, and constant stress through the joint.

    The nodes follow two bodies as one, which are free of each other."""
    lines, _, stress = turned_blocks(cells, element, tmp_path, cut=0.4)
    joint = '[[contact]]\nbetween = ["lower.z_max", "{}.z_min"]\nglued = true\npanes_on = "lower.z_max"'
    lines += [joint.format(other) for other in ("rest", "upper")]
    with open_run(solved("\n".join(lines))) as file:
        mesh, n_nodes = file["mesh"], len(file["mesh/coordinates"])
        own, *others = (Face(mesh, name, 1.0) for name in ("lower.z_max", "upper.z_min", "rest.z_min"))
        found, n = [overlaps(own, other) for other in others], own.nodes.shape[1]
        phi = triangle_shape(POINTS, n)
        with_integral, ends = np.eye(n), {}
        for middle in range(3, n):
            pair = [middle - 3, (middle - 2) % 3]
            with_integral[middle, middle] = 0.6
            with_integral[pair, middle] = 0.2
        whole, follows = np.zeros(n_nodes), np.zeros((n_nodes, n_nodes))
        for f, nodes in enumerate(own.nodes):
            area, products = (sum(parts[f] for parts in every) for every in ([it.area for it in found], [it.products for it in found]))
            masses = with_integral @ (phi.T * WEIGHTS * area) @ phi @ with_integral.T
            dual = masses.sum(axis=1)[:, None] * np.linalg.inv(masses)
            whole[nodes] += masses.sum(axis=1)
            follows[nodes] += dual @ with_integral @ products[nodes].toarray()
            ends |= {nodes[k]: nodes[[k - 3, (k - 2) % 3]] for k in range(3, n)}
        glued = np.flatnonzero(whole)
        follows[glued] /= whole[glued, None]
        for middle, pair in ends.items():
            follows[middle] = 0.6 * follows[middle] + 0.2 * follows[pair].sum(axis=0)
        # Those of the file follow each other, the followers first, by parts of the joints.
        columns, parts = mesh["glued_nodes"][:, 0], read_matrix(mesh["glued_shares"]).toarray().T
        assert len(columns) > len(glued)
        stored = list(dict.fromkeys(columns))
        shares = np.array([parts[columns == node].sum(axis=0) for node in stored])
        for k in reversed(range(len(stored))):
            later = np.flatnonzero(shares[k, stored])
            shares[k] += sum(shares[k, stored[j]] * (shares[j] - np.eye(n_nodes)[stored[j]]) for j in later)
        assert sorted(stored) == list(glued)
        # Sums of integrals whose errors are roundings.
        assert np.abs(shares - follows[stored]).max() < 1e-12
        follows[np.setdiff1d(np.arange(n_nodes), glued)] = np.eye(n_nodes)[np.setdiff1d(np.arange(n_nodes), glued)]
        dof = file["assemble/degree_of_freedom"][:].ravel()
        by_free = np.kron(follows, np.eye(3))[:, dof >= 0]
        expected = by_free.T @ (stiffness(mesh, read_scene(file)) @ by_free)
        a = read_matrix(file["assemble/stiffness"]).toarray()
        assert np.abs(a - expected).max() < 1e-12 * a.max()
        assert strained(file, stress) < 1e-10


def test_a_mirror_image_is_a_rigid_plane(solved, tmp_path):
    """Two blocks that are images of each other, with any friction between them, and one on a smooth plane."""
    up, down = (
        mesh_text(lambda x, y, z, end=end: (x, 1.3 * y, end * 0.8 * z), (3, 3, 2), "P2") for end in (1.0, -1.0)
    )
    (tmp_path / "up.msh").write_text(up)
    (tmp_path / "down.msh").write_text(down)
    moved = '[[clamp]]\nface = "{}z_max"\nvalue = [0.0, 0.0, {}]\n[[traction]]\nface = "{}x_max"\nvalue = [2e-3, 1e-3, {}]\n'
    own = '[[body]]\nname = "{0}"\nelement = "P2"\ngmsh.file = "{0}.msh"\n'
    two = STEEL + "\n" + own.format("up") + own.format("down")
    two += moved.format("up.", -2e-3, "up.", 4e-3) + moved.format("down.", 2e-3, "down.", -4e-3)
    two += '[contact]\nbetween = ["up.z_min", "down.z_min"]\npanes_on = "up.z_min"\n[friction]\ncoefficient.constant = 0.4\n'
    one = STEEL + '\n[body]\nelement = "P2"\ngmsh.file = "up.msh"\n' + moved.format("", -2e-3, "", 4e-3)
    one += '[contact]\nface = "z_min"\n'
    with open_run(solved(two)) as pair, open_run(solved(one, "plane")) as plane:
        a, b = (file["solve/multiplier_normal"][:] for file in (pair, plane))
        n = pair["mesh/body_nodes"][1]
        upper = pair["solve/displacement"][:n] - plane["solve/displacement"][:]
        assert (b == 0).any()
        assert np.abs(a - b).max() < 1e-11 * b.max()
        assert np.abs(upper).max() < 1e-11 * 2e-3
        assert np.abs(pair["solve/multiplier_tangential"][:]).max() < 1e-11 * b.max()


def test_bodies_that_never_touch_are_two_runs(solved):
    """One solve of two blocks on planes of their own, and one of each."""
    own = '[[clamp]]\nface = "{0}x_min"\n[[pressure]]\nface = "{0}z_max"\nvalue = {1}\n'
    own += '[[traction]]\nface = "{0}x_max"\nvalue = [{1}, 0.0, 0.0]\n'
    contact = '[[contact]]\nface = "{}z_min"\n'
    law = "[friction]\ncoefficient.constant = 0.3\n"
    cells, sizes, loads = ([6, 4, 4], [4, 2, 2]), ([2.0, 1.0, 1.0], [1.5, 1.0, 0.5]), (1e-3, 2e-3)
    text = STEEL + "\n" + bodies(cells, origins=((0, 0, 0), (5, 0, 0)), sizes=sizes)
    text += "".join(own.format(f"{name}.", load) + contact.format(f"{name}.") for name, load in zip(("lower", "upper"), loads, strict=True))
    with open_run(solved(text + law)) as both:
        starts, u = both["mesh/body_nodes"][:], both["solve/displacement"][:]
        pressure = both["solve/multiplier_normal"][:]
        first = 0
        for k in range(2):
            alone = f"{STEEL}\nbody.brick = {{ size = {sizes[k]}, cells = {cells[k]} }}\n"
            alone += own.format("", loads[k]) + contact.format("") + law
            with open_run(solved(alone, f"alone{k}")) as one:
                theirs = one["solve/multiplier_normal"][:]
                assert np.abs(pressure[first : first + len(theirs)] - theirs).max() < 1e-12 * theirs.max()
                first += len(theirs)
                wanted = one["solve/displacement"][:]
                assert np.abs(u[starts[k] : starts[k + 1]] - wanted).max() < 1e-12 * np.abs(wanted).max()


def test_a_very_stiff_body_is_an_obstacle(solved):
    """A block on a block 10^6 times stiffer, and on the rigid plane."""
    held = '[[clamp]]\nface = "{0}z_max"\nvalue = [4e-3, 0.0, -4e-3]\n'
    law = "[friction]\ncoefficient.constant = 0.5\n"
    two = STEEL + "\n" + bodies((2, 3), "P2", sizes=([1.0, 1.0, 0.5], 1.0), origins=((0, 0, 0), (0, 0, 0.5)))
    two = two.replace('name = "lower"', 'name = "lower"\nmaterial.isotropic = { young_modulus = 1e6, poisson_ratio = 0.3 }')
    two += '[[clamp]]\nface = "lower.z_min"\n' + held.format("upper.") + '[contact]\nbetween = ["upper.z_min", "lower.z_max"]\n' + law
    one = STEEL + '\n[body]\nelement = "P2"\nbrick = { size = [1.0, 1.0, 1.0], cells = [3, 3, 3] }\n' + held.format("")
    one += '[contact]\nface = "z_min"\n' + law
    with open_run(solved(two)) as pair, open_run(solved(one, "plane")) as plane:
        p, q = (file["solve/multiplier_normal"][:] for file in (pair, plane))
        assert np.abs(p - q).max() < 1e-3 * q.max()
        p, q = (file["solve/multiplier_tangential"][:] for file in (pair, plane))
        assert np.abs(p - q).max() < 3e-3 * np.abs(q).max()


def strain_energy(solved, cells, panes):
    """Of a block that is pressed and sheared on another of half the stiffness."""
    text = STEEL + "\n" + bodies(cells, "P2", upper="material.isotropic = { young_modulus = 2.0, poisson_ratio = 0.2 }")
    text += '[[clamp]]\nface = "lower.z_min"\n[[clamp]]\nface = "upper.z_max"\nvalue = [2e-3, 0.0, -1e-2]\n'
    text += f'[contact]\nbetween = ["lower.z_max", "upper.z_min"]\npanes_on = "{panes}"\n[friction]\ncoefficient.constant = 0.3\n'
    with open_run(solved(text, panes)) as file:
        return float(file["post/resultants/strain_energy"][()])


def test_the_side_with_panes_matters_less_on_finer_meshes(solved):
    """Whichever face has the panes, the limit is the same: energies differ by an order more than h²."""
    differences = []
    for n in (1, 2):
        a, b = (strain_energy(solved, (2 * n, 3 * n), face) for face in ("lower.z_max", "upper.z_min"))
        differences.append(abs(a / b - 1))
    assert differences[1] < differences[0] / 2
    assert differences[1] < 2e-2


def smallest_eigenvalue(file):
    """Of the normal part of S, with rows scaled by the compliance of panes of their size on both sides."""
    m = len(file["mesh/pane_area"])
    compliance = sum(
        (1 - own["poisson_ratio"] ** 2) / own["young_modulus"]
        for own in ((body.get("material") or read_scene(file)["material"])["isotropic"] for body in read_scene(file)["body"])
    )
    scale = file["mesh/pane_area"][:] ** 0.75 * np.sqrt(compliance)
    return eigvalsh(file["assemble/dual_operator"][:m, :m] / np.outer(scale, scale))[0]


@pytest.mark.parametrize(("stiffer", "least", "most"), [(1.0, 0.08, 0.2), (100.0, 1e-3, 1e-2)])
def test_multipliers_are_stable_on_the_softer_side(stiffer, least, most, solved):
    """On a mesh three times finer: stable at equal stiffness, not on a side a hundred times stiffer, which a scene has to ask for."""
    own = f"material.isotropic = {{ young_modulus = {stiffer}, poisson_ratio = 0.3 }}"
    text = STEEL + "\n" + bodies((2, 6), "P2", upper=own)
    text += '[[clamp]]\nface = "lower.z_min"\n[[clamp]]\nface = "upper.z_max"\n[contact]\nbetween = ["lower.z_max", "upper.z_min"]\n'
    with open_run(solved(text + 'panes_on = "upper.z_min"\n')) as file:
        found = smallest_eigenvalue(file)
        assert least < found < most
    with open_run(solved(text, "chosen")) as file:
        # What the program chooses is the finer of similar ones, else the softer.
        assert len(file["mesh/pane_area"]) == (36 if stiffer == 1.0 else 4)
        assert smallest_eigenvalue(file) >= 0.08


def plug_and_ring(folder, depth=0.0, element="P1"):
    """Quarters of a thick tube in another, by straight triangles, the inner one thicker by a depth; plane strain."""

    def sector(inner, outer):
        def place(x, y, z):
            angle, radius = np.pi / 2 * x, inner + (outer - inner) * z
            return float(radius * np.cos(angle)), 0.2 * y, float(radius * np.sin(angle))

        return place

    text = STEEL + "\n"
    for name, radii, cells in (("plug", (1.0 + depth, 0.3), (24, 2, 5)), ("ring", (1.0, 2.0), (16, 2, 5))):
        (folder / f"{name}.msh").write_text(mesh_text(sector(*radii), cells, "P1"))
        text += f'[[body]]\nname = "{name}"\nelement = "{element}"\ngmsh.file = "{name}.msh"\n'
    for body in ("plug", "ring"):
        for face, axis in (("x_min", "z"), ("x_max", "x"), ("y_min", "y"), ("y_max", "y")):
            text += f'[[clamp]]\nface = "{body}.{face}"\ncomponents = ["{axis}"]\n'
    return text + '[contact]\nbetween = ["plug.z_min", "ring.z_min"]\n'


@pytest.mark.parametrize(("panes", "element", "error"), [("plug", "P1", 6e-2), ("ring", "P1", 6e-2), ("ring", "P2", 1e-2)])
def test_a_plug_fits_its_ring_whatever_the_facets(panes, element, error, solved, tmp_path):
    """Under pressure inside, as one body by Lamé: gaps are those of the curved faces, not of their facets, at their ends as well."""
    text = plug_and_ring(tmp_path, element=element) + f'panes_on = "{panes}.z_min"\n'
    with open_run(solved(text + '[[pressure]]\nface = "plug.z_max"\nvalue = 1e-3\n')) as file:
        pressure, area = file["solve/multiplier_normal"][:], file["mesh/pane_area"][:]
        # Fourth order in the size of triangles; facets make 1e-3 of the radius.
        assert "contact_clearance" not in file["mesh"] or np.abs(file["mesh/contact_clearance"][:]).max() < 1e-6
    inner, joint, outer = 0.3, 1.0, 2.0
    exact = 1e-3 * inner**2 / (outer**2 - inner**2) * (outer**2 / joint**2 - 1.0)
    # Five linear elements across the plug: 4.3 % in the mean.
    assert area @ pressure / area.sum() == pytest.approx(exact, rel=error)
    assert pressure.min() > 0.9 * exact


def test_bodies_that_overlap_are_refused_or_pressed_apart(solved, contact3d, tmp_path):
    depth, joint, inner, outer = 2e-3, 1.0, 0.3, 2.0
    text = 'title = "ring"\n' + plug_and_ring(tmp_path, depth)
    (tmp_path / "ring.toml").write_text(text)
    result = contact3d("run", tmp_path / "ring.toml", tmp_path / "ring.h5", expect=2)
    assert all(word in result.stderr for word in ("contact.between", "interference = true")), result.stderr
    assert not (tmp_path / "ring.h5").exists()
    with open_run(solved(plug_and_ring(tmp_path, depth) + "interference = true\n")) as file:
        pressure, area = file["solve/multiplier_normal"][:], file["mesh/pane_area"][:]
        assert np.abs(file["mesh/contact_clearance"][:] + depth).max() < 1e-6
    # Lamé for two rings in plane strain; Poisson's parts of equal materials cancel.
    soft = sum((big**2 + small**2) / (big**2 - small**2) for small, big in ((inner, joint), (joint, outer)))
    assert area @ pressure / area.sum() == pytest.approx(depth / (joint * (1 - 0.3**2) * soft), rel=4e-2)


@pytest.mark.parametrize("panes", ["ring.inner", "sleeve.outer"])
def test_a_ring_is_shrunk_on_a_sleeve(panes, contact3d, tmp_path):
    scene = ROOT / "pipelines" / "two_rings.toml"
    contact3d("run", scene, tmp_path / "run.h5", "--no-figures", "--set", f'contact.panes_on="{panes}"')
    with open_run(tmp_path / "run.h5") as file:
        pressure = file["solve/multiplier_normal"][:]
    a, b, c = 14.0, 20.0, 30.0
    (ring, sleeve), ratios = (21e4 / (1 - 0.3**2), 11e4 / (1 - 0.34**2)), (0.3 / 0.7, 0.34 / 0.66)
    soft = ((c * c + b * b) / (c * c - b * b) + ratios[0]) / ring + ((b * b + a * a) / (b * b - a * a) - ratios[1]) / sleeve
    # Four and five quadratic elements through a quarter; 0.25 % of the radius is the depth.
    assert np.abs(pressure / (0.05 / (b * soft)) - 1.0).max() < 8e-3


def test_what_overhangs_bears_nothing(solved):
    """Panes over the edge of the other face count what lies on it; slivers join a neighbour."""
    text = STEEL + "\n" + bodies((4, [5, 3, 2]), "P2", origins=((0, 0, 0), (-0.2, 0.1, 1)), sizes=(1.0, [1.0, 0.6, 0.5]))
    text += '[[clamp]]\nface = "lower.z_min"\n[[pressure]]\nface = "upper.z_max"\nvalue = 1e-3\n'
    text += '[contact]\nbetween = ["lower.z_max", "upper.z_min"]\npanes_on = "lower.z_max"\n[friction]\ncoefficient.constant = 0.3\n'
    with open_run(solved(text)) as file:
        area, centre = file["mesh/pane_area"][:], file["mesh/pane_centre"][:]
        assert area.sum() == pytest.approx(0.8 * 0.6, rel=1e-13)
        assert area.min() > 0.25 * 0.0625
        pressure = file["solve/multiplier_normal"][:]
        assert area @ pressure == pytest.approx(1e-3 * 0.6, rel=1e-10)
        # The weight lies in the middle of the whole upper block.
        assert (area * pressure) @ centre[:, 0] == pytest.approx(1e-3 * 0.6 * 0.3, rel=2e-2)


def test_same_bits_with_any_number_of_threads(contact3d, tmp_path):
    """Clipping is done by triangle, sums in one order."""
    (tmp_path / "pair.toml").write_text(random_scene(11, 2, tmp_path))
    files = [tmp_path / f"threads{n}.h5" for n in (1, 2)]
    for n, path in enumerate(files, 1):
        contact3d("run", tmp_path / "pair.toml", path, "--no-figures", "--threads", n)
    with open_run(files[0]) as one, open_run(files[1]) as two:
        for name in ("mesh/opposite_integrals", "assemble/dual_operator", "solve/multiplier_normal", "solve/displacement"):
            assert np.array_equal(one[name][:], two[name][:]), name


@pytest.fixture
def pipeline(contact3d, tmp_path):
    """Areas, centres, pressures and friction stresses of a solved pipeline."""

    def solve(name):
        contact3d("run", ROOT / "pipelines" / f"{name}.toml", tmp_path / "run.h5", "--no-figures")
        with open_run(tmp_path / "run.h5") as file:
            shear = file["solve/multiplier_tangential"][:] if "multiplier_tangential" in file["solve"] else None
            return file["mesh/pane_area"][:], file["mesh/pane_centre"][:], file["solve/multiplier_normal"][:], shear

    return solve


def test_bolt(contact3d, tmp_path):
    """Preload passes head and plates whole; a load parts them, and then the bolt bears it alone. Stiffnesses by VDI 2230-1 (2015), 5.1."""
    told = contact3d("run", ROOT / "pipelines" / "bolt.toml", tmp_path / "run.h5", "--no-figures", "--json").stdout
    with open_run(tmp_path / "run.h5") as file:
        tension = -file["history/tool_force"][:, 0, 2]
        normal = file["history/multiplier_normal"][:] * file["mesh/pane_area"][:]
        starts = file["mesh/contact_face_panes"][:]
        lowered = read_matrix(file["mesh/pane_average"]).T @ file["history/displacement"][0][file["mesh/contact_nodes"][:], 2]
    head, joint = (normal[:, a:b].sum(axis=1) for a, b in itertools.pairwise(starts))
    load = np.array([0.0, 2500.0, 5000.0, 7500.0])
    # Sums of forces of a solve to 1e-12.
    assert np.abs(head - tension).max() < 1e-9 * load[-1]
    assert np.abs(joint + load - tension).max() < 1e-9 * load[-1]
    assert (np.diff(tension) > 0).all() and joint[-2] > 0 and joint[-1] == 0
    # The force of each face of each contact has a column, and a row of each increment.
    table = package.open(tmp_path / "run.h5").to_dataframe("history")
    increments = json.loads(told)["history"]
    for contact, face, force in [(0, "bolt.under_head", head), (0, "upper.top", -head), (1, "upper.joint", joint), (1, "lower.joint", -joint)]:
        named = f"contact.{contact}"
        assert table[f"forces_{named} on {face}_z"].values == pytest.approx(force, abs=1e-9 * load[-1])
        rows = [row for row in itertools.chain(*(it["forces"] for it in increments)) if (row["source"], row["face"]) == (named, face)]
        assert [row["force"][2] for row in rows] == pytest.approx(force, abs=1e-9 * load[-1])
    modulus, length, shank, bearing, hole, plate = 2.1e5, 20.0, (4.0, 10.0), 17.0, 11.0, 40.0
    bolt = (length + 0.4 * shank[1]) / (modulus * math.pi / 4 * (shank[1] ** 2 - shank[0] ** 2))
    slope = 0.362 + 0.032 * math.log(length / bearing / 2) + 0.153 * math.log(plate / bearing)
    wide = bearing + length * slope
    cone = (bearing + hole) * (wide - hole) / ((bearing - hole) * (wide + hole))
    plates = 2 * math.log(cone) / (modulus * math.pi * hole * slope)
    # Its cone of pressure stands for the plates: 6 and 8 % measured.
    assert 4 * tension[0] == pytest.approx(0.05 / (bolt + plates), rel=0.1)
    of_head = normal[0, : starts[1]]
    sunk = -(of_head @ lowered[: starts[1]]) / of_head.sum()
    assert sunk / 0.05 == pytest.approx(plates / (bolt + plates), rel=0.1)
    # What the load adds to the bolt is at most that share, of a load that acts under the head.
    assert 0 < tension[1] - tension[0] < plates / (bolt + plates) * load[1]


def test_two_cylinders(pipeline):
    """Half width, pressure and stick zone of Hertz, Cattaneo and Mindlin; with normals of one face alone the stick zone is 25 % wider."""
    area, centre, pressure, shear = pipeline("two_cylinders")
    load, push, friction, x = 10.0, 0.93622, 0.2, centre[:, 0]

    def half_width(weights):
        # Of an ellipse with the same second moment.
        middle = weights @ x / weights.sum()
        return 2 * np.sqrt(weights @ (x - middle) ** 2 / weights.sum())

    modulus = 200.0 / (2 * (1 - 0.3**2))
    a = np.sqrt(4 * load * 4.0 / (np.pi * modulus))
    found = half_width(area * pressure)
    assert found == pytest.approx(a, rel=0.02)
    assert pressure.max() == pytest.approx(2 * load / (np.pi * a), rel=0.015)
    stick = half_width(area * (friction * pressure - np.abs(shear[:, 0]))) / found
    assert stick == pytest.approx(np.sqrt(1 - push / (friction * load)), rel=0.025)


def test_two_balls(pipeline):
    """Radius and pressure of Hertz for the force on a quarter."""
    area, centre, pressure, _ = pipeline("two_balls")
    quarter = area @ pressure
    modulus = 1 / ((1 - 0.3**2) / 8000 + (1 - 0.35**2) / 3000)
    a = (3 * 4 * quarter * 24.0 / (4 * modulus)) ** (1 / 3)
    assert pressure.max() == pytest.approx(1.5 * 4 * quarter / (np.pi * a**2), rel=0.01)
    distance = (centre[:, :2] ** 2).sum(axis=1)
    assert np.sqrt(2.5 * (area * pressure) @ distance / quarter) == pytest.approx(a, rel=0.05)


def test_crossed_cylinders(solved, tmp_path):
    """Two equal cylinders at right angles touch as a ball and a plane do; Hertz for the force on a quarter."""
    radius, width, modulus = 40.0, 16.0, 1 / (2 * (1 - 0.3**2) / 7e4)

    def onto_cylinder(axis, up):
        def onto(x, y, _):
            return x, y, up * (radius - math.sqrt(radius**2 - (y if axis == 0 else x) ** 2))

        def place(u, v, w):
            x, y, z = (width * math.sinh(3 * share) / math.sinh(3) for share in (u, v, w))
            surface = onto(x, y, 0)[2]
            return x, y, up * z + (1 - z / width) * surface

        return place, onto

    for name, axis, up, cells in (("upper", 0, 1.0, (8, 8, 6)), ("lower", 1, -1.0, (7, 7, 6))):
        place, onto = onto_cylinder(axis, up)
        (tmp_path / f"{name}.msh").write_text(mesh_text(place, cells, "P2", onto))
    tables = "".join(f'[[body]]\nname = "{name}"\nelement = "P2"\ngmsh.file = "{name}.msh"\n' for name in ("upper", "lower"))
    planes = [(f"{body}.{face}", face[0], 0.0) for body in ("upper", "lower") for face in ("x_min", "y_min")]
    planes += [("lower.z_max", "z", 0.0), ("upper.z_max", "z", -0.15)]
    clamps = "".join(f'[[clamp]]\nface = "{face}"\ncomponents = ["{c}"]\n' + (f"value = [0.0, 0.0, {v}]\n" if v else "") for face, c, v in planes)
    file = solved(
        'units = { length = "mm", force = "N" }\n' + tables + clamps + '[contact]\nbetween = ["upper.z_min", "lower.z_min"]\n'
        "[material.isotropic]\nyoung_modulus = 7e4\npoisson_ratio = 0.3\n"
    )
    with open_run(file) as run:
        area, centre, pressure = run["mesh/pane_area"][:], run["mesh/pane_centre"][:], run["solve/multiplier_normal"][:]
    force = 4 * area @ pressure
    a = (3 * force * radius / (4 * modulus)) ** (1 / 3)
    moments = (area * pressure) @ centre[:, :2] ** 2 / (area @ pressure)
    # Bodies of six radii of contact, panes of a quarter of one at its middle.
    assert pressure.max() == pytest.approx(1.5 * force / (np.pi * a**2), rel=0.02)
    # The mean square of a coordinate is a^2 / 5; the contact is round although neither body is.
    assert np.sqrt(5 * moments) == pytest.approx([a, a], rel=0.05)


def test_a_wedge_slides_into_a_groove(solved, tmp_path):
    """Both flanks slip, and the press bears 2 N (sin a + mu cos a), by pairs whose meshes match neither in size nor in place."""
    taper, friction = 0.3, 0.2

    def between(left, right):
        def place(u, v, w):
            ends = [side * (1.0 + taper * (w - 1.0)) if abs(side) == 1.0 else side for side in (left, right)]
            return ends[0] + u * (ends[1] - ends[0]), v, w

        return place

    parts = {"left": (-2.0, -1.0, (3, 4, 6)), "wedge": (-1.0, 1.0, (6, 2, 4)), "right": (1.0, 2.0, (2, 6, 6))}
    for name, (left, right, cells) in parts.items():
        (tmp_path / f"{name}.msh").write_text(mesh_text(between(left, right), cells, "P1"))
    text = "".join(f'[[body]]\nname = "{name}"\ngmsh.file = "{name}.msh"\n' for name in parts)
    text += '[[clamp]]\nface = "left.x_min"\n[[clamp]]\nface = "right.x_max"\n'
    text += '[[clamp]]\nface = "wedge.z_max"\ncomponents = ["z"]\nvalue = [0.0, 0.0, -0.01]\n'
    text += '[[clamp]]\nface = "wedge.y_min"\ncomponents = ["y"]\n'
    text += '[[contact]]\nbetween = ["wedge.x_min", "left.x_max"]\n[[contact]]\nbetween = ["wedge.x_max", "right.x_min"]\n'
    text += f"[friction]\ncoefficient.constant = {friction}\n[material.isotropic]\nyoung_modulus = 1e3\npoisson_ratio = 0.3\n"
    with open_run(solved(text)) as run:
        area, traction = run["mesh/pane_area"][:], run["post/contact_traction"][:]
        pressure, shear = run["solve/multiplier_normal"][:], run["solve/multiplier_tangential"][:]
        left = run["mesh/pane_centre"][:, 0] < 0.0
    assert np.hypot(*shear.T) == pytest.approx(friction * pressure, rel=1e-10)
    one, other = ((area * pressure)[on].sum() for on in (left, ~left))
    # The flanks' meshes differ.
    assert one == pytest.approx(other, rel=1e-3)
    angle = np.arctan(taper)
    # The wedge is squeezed, so that a thousandth of friction points along the groove.
    assert -area @ traction[:, 2] == pytest.approx((one + other) * (np.sin(angle) + friction * np.cos(angle)), rel=1e-3)


def test_a_stack(contact3d, tmp_path):
    """Each interface bears the whole load, and moments balance about the middle of each block."""
    contact3d("run", ROOT / "pipelines" / "stack.toml", tmp_path / "run.h5", "--no-figures")
    with open_run(tmp_path / "run.h5") as file:
        traction, area, centre = file["post/contact_traction"][:], file["mesh/pane_area"][:], file["mesh/pane_centre"][:]
        height = centre[:, 2].round(6)
        for z in np.unique(height):
            on = height == z
            force = (traction[on] * area[on, None]).sum(axis=0)
            assert np.abs(force) == pytest.approx([60.0, 0.0, 300.0], abs=1e-9)
            # About the place where the load is put in.
            moment = np.cross(centre[on] - [0.15, 0.15, 0.28], traction[on] * area[on, None]).sum(axis=0)
            assert moment == pytest.approx(np.zeros(3), abs=1e-9)
