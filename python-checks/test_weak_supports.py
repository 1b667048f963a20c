"""A stiff block that weak springs hold against sliding: closed forms, and Code_Aster's SSNV503 on a foundation turned by 30 degrees."""

import itertools

import h5py
import numpy as np
import pytest

from run_file import facet_faces, open_run, read_enum

STEPS = """
[[step]]
title = "press"
factor = { pt = 0.0 }
[[step]]
title = "stick"
factor = { pt = 1.0 }
[[step]]
title = "slide"
value = { pt = 181.8 }
"""

# A pad 40 x 1 x 20 mm, 1 mm above its foundation, on 4 N/mm along x.
PAD = """
title = "pad on weak springs"
units = {{ length = "mm", force = "N" }}
body.brick = {{ size = [40.0, 1.0, 20.0], cells = [8, 2, 4] }}
material.isotropic = {{ young_modulus = {modulus}, poisson_ratio = 0.0 }}
clamp = [{{ face = "y_min", components = ["y"] }}, {{ face = "y_max", components = ["y"] }}]
pressure = [{{ name = "pn", face = "z_max", value = 300.0 }}, {{ name = "pt", face = "x_min", value = 178.2 }}]
contact = {{ face = "z_min", gap = 1.0 }}
friction.coefficient.constant = 0.3
[[spring]]
face = "x_min"
tensor = [[0.1, 0.0, 0.0], [0.0, 0.0, 0.0], [0.0, 0.0, 0.0]]
[[spring]]
face = "x_max"
tensor = [[0.1, 0.0, 0.0], [0.0, 0.0, 0.0], [0.0, 0.0, 0.0]]
"""


@pytest.mark.parametrize("modulus", [2e5, 1e6, 1e8])
def test_a_uniform_pressure_and_a_slide_whatever_the_stiffness(contact3d, tmp_path, modulus):
    scene, path = tmp_path / "pad.toml", tmp_path / "pad.h5"
    scene.write_text(PAD.format(modulus=modulus) + STEPS.split("[[step]]")[1].join(["[[step]]", ""]))
    contact3d("run", scene, path, "--no-figures")
    with open_run(path) as file:
        pressure = file["solve/multiplier_normal"][:]
        # Without a Poisson ratio the load goes straight down.
        assert np.abs(pressure / 300.0 - 1.0).max() < 1e-9
    scene.write_text(PAD.format(modulus=modulus) + STEPS)
    contact3d("run", scene, path, "--no-figures")
    with open_run(path) as file:
        u = file["solve/displacement"][:]
        # 3636 N push, friction takes 3600, springs of 4 N/mm the rest; the block is shortened by 3 mm of its 40 at 2e5 / 6000.
        compliance = 20.0 * (300.0 + 181.8) * 4 / modulus
        assert abs(u[:, 0].mean() - 9.0) < 1e-6 + compliance
        forces = dict(zip(file["post/forces/source"].asstr()[:], file["post/forces/force"][:]))
        springs = forces["spring.0"] + forces["spring.1"]
        assert springs[0] == pytest.approx(-36.0, abs=1e-4)
        assert forces["contact"][2] == pytest.approx(12000.0, rel=1e-6)


def test_springs_that_hold_next_to_nothing_are_refused(contact3d, tmp_path):
    scene, path = tmp_path / "pad.toml", tmp_path / "pad.h5"
    scene.write_text(PAD.format(modulus=2e11))
    words = " ".join(contact3d("run", scene, path, "--no-figures", expect=2).stderr.replace("│", " ").split())
    # 0.1 N/mm3 on two faces, z^2 of them over the mean square of a rotation about y, and c V / r^2 over the nodes.
    x, y, z = (np.linspace(-side / 2, side / 2, n + 1) for side, n in ((40.0, 8), (1.0, 2), (20.0, 4)))
    x2, y2, z2 = (np.mean(axis**2) for axis in (x, y, z))
    number = 0.1 * 2 * 20.0**3 / 12 / (x2 + z2) / (2e11 * 800.0 / (x2 + y2 + z2))
    assert f"{number:.1e} of it in a rotation about y" in words and "remove them" in words
    assert not path.exists()


def turned_block(path, cells, size, angle):
    """A block of Kuhn's tetrahedra whose lower face is turned about z, as MSH 2.2."""
    nx, ny, nz = cells
    along = np.array([np.cos(angle), np.sin(angle), 0.0])
    up = np.array([-np.sin(angle), np.cos(angle), 0.0])
    axes = np.array([along, up, [0.0, 0.0, 1.0]])
    shape = (nx + 1, ny + 1, nz + 1)
    number = np.arange(np.prod(shape)).reshape(shape)
    places = np.array(list(itertools.product(*(np.linspace(0, s, n) for s, n in zip(size, shape))))) @ axes
    tetrahedra, sides = [], {}
    for cell in itertools.product(range(nx), range(ny), range(nz)):
        for order in itertools.permutations(range(3)):
            at, nodes = list(cell), [number[cell]]
            for axis in order:
                at[axis] += 1
                nodes.append(number[tuple(at)])
            if np.linalg.det(np.eye(3)[list(order)]) < 0.0:
                nodes[2:] = nodes[:1:-1]
            tetrahedra.append(nodes)
    local = np.array(list(itertools.product(*(range(n) for n in shape))))
    for nodes in tetrahedra:
        for facet in itertools.combinations(nodes, 3):
            for axis, end in itertools.product(range(3), range(2)):
                if (local[list(facet), axis] == end * cells[axis]).all():
                    sides.setdefault((axis, end), []).append(facet)
    names = {(0, 0): "left", (0, 1): "right", (1, 0): "foundation", (1, 1): "top", (2, 0): "back", (2, 1): "front"}
    lines = ["$MeshFormat", "2.2 0 8", "$EndMeshFormat", "$PhysicalNames", "7"]
    groups = {key: k + 1 for k, key in enumerate(names)}
    lines += [f'2 {groups[key]} "{name}"' for key, name in names.items()] + ['3 7 "block"', "$EndPhysicalNames"]
    lines += ["$Nodes", str(len(places))]
    lines += [f"{k + 1} " + " ".join(repr(float(c)) for c in x) for k, x in enumerate(places)]
    elements = [f"2 2 {groups[key]} 1 " + " ".join(str(n + 1) for n in facet) for key, all in sides.items() for facet in all]
    elements += ["4 2 7 1 " + " ".join(str(n + 1) for n in nodes) for nodes in tetrahedra]
    lines += ["$EndNodes", "$Elements", str(len(elements))]
    lines += [f"{k + 1} {element}" for k, element in enumerate(elements)] + ["$EndElements"]
    path.write_text("\n".join(lines) + "\n")
    return along


SSNV503 = """
title = "SSNV503"
units = {{ length = "mm", force = "N" }}
body.gmsh.file = "block.msh"
material.isotropic = {{ young_modulus = 2.1e6, poisson_ratio = 0.0 }}
clamp = [{{ face = "back", components = ["z"] }}, {{ face = "front", components = ["z"] }}]
pressure = [{{ name = "pn", face = "top", value = 300.0 }}, {{ name = "pt", face = "left", value = 178.2 }}]
spring = [{{ face = "left", tensor = {tensor} }}, {{ face = "right", tensor = {tensor} }}]
contact = {{ face = "foundation", gap = 2.0, multipliers = "nodal" }}
friction.coefficient.constant = 0.3
"""


def test_code_aster_ssnv503(contact3d, tmp_path):
    """V6.04.503: u in mm and the sum of reactions in N after each load, within what the test there allows."""
    along = turned_block(tmp_path / "block.msh", (8, 4, 4), (40.0, 20.0, 20.0), np.pi / 6)
    # 80 N/mm on two faces of 400 mm2.
    tensor = (0.1 * np.outer(along, along)).tolist()
    published = {
        "press": ((1.0, -1.732), (-1.2e5, 2.0784e5), (0.01, 0.01)),
        "stick": (None, (-1.8173e5, 1.722e5), (None, 0.01)),
        "slide": ((8.794, 2.768), (-1.82977e5, 1.71486e5), (0.01, 0.05)),
    }
    scene = tmp_path / "ssnv503.toml"
    steps = STEPS.split("[[step]]\n")[1:]
    for count, name in enumerate(published, 1):
        scene.write_text(SSNV503.format(tensor=tensor) + "".join("[[step]]\n" + s for s in steps[:count]))
        path = tmp_path / f"{name}.h5"
        contact3d("run", scene, path, "--no-figures")
        with h5py.File(path) as file:
            u = file["solve/displacement"][:].mean(axis=0)
            sources = file["post/forces/source"].asstr()[:]
            reacting = [source == "contact" or source.startswith("spring") for source in sources]
            reaction = file["post/forces/force"][:][np.array(reacting)].sum(axis=0)
        moved, forces, (of_u, of_r) = published[name]
        if moved:
            assert np.allclose(u[:2], moved, rtol=of_u), (name, u)
        assert np.allclose(reaction[:2], forces, rtol=of_r), (name, reaction)


FORCE, MODULUS = 1e4, 1e9
LAWS = {
    "frictionless": "",
    "tresca": "[friction]\nslip_bound = {bound!r}\ncoefficient.constant = 1.0",
    "coulomb": "[friction]\ncoefficient.constant = 0.3",
}
TRACTIONS = {"lifted": (1e3, 0.0, 1e4), "pressed": (1e3, 0.0, -1e4), "pushed": (4e3, 5e2, -1e4)}
UNITS = {"m": ('length = "m", force = "N"', 1.0, 1.0), "mm": ('length = "mm", force = "kN"', 1e3, 1e-3)}


def cube_on_springs(stiffness, law, load, element, units):
    """A unit cube that springs of one face hold, its scene and the units of length and force."""
    words, length, force = UNITS[units]
    stress = force / length**2
    spring = stiffness * stress / length
    value = [v * stress for v in TRACTIONS[load]]
    return f"""
title = "cube on springs"
units = {{ {words} }}
[body]
element = "{element}"
brick = {{ size = [{length}, {length}, {length}], cells = [2, 2, 2] }}
[material]
isotropic = {{ young_modulus = {MODULUS * stress!r}, poisson_ratio = 0.3 }}
[[spring]]
face = "x_max"
normal = {spring!r}
tangential = {spring!r}
[[traction]]
face = "z_max"
value = {value}
[contact]
face = "z_min"
multipliers = "nodal"
{LAWS[law].format(bound=400.0 * stress)}
"""


def product_over(triangles, x, height, field):
    """The integral of a height and a nodal field over flat triangles, linear or with the nodes of their middles, by cubic quadrature."""
    corners = x[triangles[0]]
    areas = np.linalg.norm(np.cross(corners[:, 1] - corners[:, 0], corners[:, 2] - corners[:, 0]), axis=1) / 2
    points = [(np.full(3, 1 / 3), -27 / 48)] + [(np.full(3, 0.2) + 0.4 * np.eye(3)[k], 25 / 48) for k in range(3)]
    total = 0.0
    for at, weight in points:
        values = field[triangles[0]] @ at
        if len(triangles) == 2:
            products = [at[a] * at[b] for a, b in ((0, 1), (1, 2), (2, 0))]
            values = field[triangles[0]] @ (at * (2 * at - 1)) + 4 * field[triangles[1]] @ products
        total += weight * (areas * (height[triangles[0]] @ at) * values).sum()
    return total


@pytest.mark.parametrize(
    ("stiffness", "law", "load", "element", "units"),
    [
        (2e1, "frictionless", "lifted", "P1", "m"),
        (1e2, "coulomb", "lifted", "P2", "mm"),
        (1e3, "tresca", "lifted", "P1", "m"),
        (2e1, "frictionless", "pressed", "P2", "mm"),
        (1e3, "tresca", "pushed", "P1", "mm"),
        (1e4, "coulomb", "pushed", "P1", "m"),
    ],
)
def test_springs_as_soft_as_can_be(contact3d, tmp_path, stiffness, law, load, element, units):
    """Every law, 2e-8 to 1e-5 of E L: the motion is what the springs make of the forces, and the stress that of the forces."""
    scene, path = tmp_path / "cube.toml", tmp_path / "cube.h5"
    scene.write_text(cube_on_springs(stiffness, law, load, element, units))
    contact3d("run", scene, path, "--no-figures")
    _, length, force = UNITS[units]
    with open_run(path) as file:
        x, u = file["mesh/coordinates"][:] / length, file["solve/displacement"][:] / length
        sources = list(file["post/forces/source"].asstr()[:])
        forces, moments = file["post/forces/force"][:] / force, file["post/forces/moment"][:] / (force * length)
        stress, nodes = file["post/stress"][:] * length**2 / force, file["mesh/tetrahedra"][:][:, :4]
        on_face = facet_faces(file["mesh"]) == "x_max"
        triangles = [file[name][:][on_face] for name in ("mesh/facets", "mesh/facet_mid_edges") if name in file]
    springs = sources.index("spring.0")
    others = [k for k in range(len(sources)) if k != springs]
    # Of numbers that are sums of some hundred.
    assert np.abs(forces.sum(axis=0)).max() < 1e-10 * FORCE and np.abs(moments.sum(axis=0)).max() < 1e-10 * FORCE
    # Springs of a square of side one about its middle: k in each direction, k / 6 and k / 12 against turns.
    middle = np.array([1.0, 0.5, 0.5])
    pull = forces[others].sum(axis=0)
    shift = pull / stiffness
    turn = (moments[others].sum(axis=0) - np.cross(middle, pull)) / (stiffness * np.array([1 / 6, 1 / 12, 1 / 12]))
    moved = shift + np.cross(turn, x - middle)
    # The cube's own strain, a few times that of a uniform stress, and rounding of forces of some 1e4 N where they nearly balance.
    assert np.abs(u - moved).max() < 10 * FORCE / MODULUS + 1e-9 * np.abs(u).max() + 1e-9 * FORCE / stiffness
    # The mean stress along z is the sum of forces times their heights: 1 of the top, 0 of the foundation; the springs
    # take -k u_z in each place.
    corners = x[nodes]
    volumes = np.abs(np.linalg.det(corners[:, 1:] - corners[:, :1])) / 6
    mean = (stress[:, 2] * volumes).sum()
    by_springs = -stiffness * product_over(triangles, x, x[:, 2], u[:, 2])
    # Strains do not know of the long way: rounding of the balance alone, and linear stresses are exact at centroids.
    assert abs(mean - (TRACTIONS[load][2] + by_springs)) < 1e-8 * FORCE


@pytest.mark.parametrize("friction", [0.02, 0.0])
def test_what_rollers_press_friction_holds_only_so_far(contact3d, tmp_path, friction):
    """A block on rollers above and on its foundation below is pushed by ten times what friction can bear."""
    law = f"[friction]\ncoefficient.constant = {friction}" if friction else ""
    scene, path = tmp_path / "rollers.toml", tmp_path / "rollers.h5"
    scene.write_text(f"""
title = "rollers"
body.brick = {{ size = [1.0, 1.0, 1.0], cells = [4, 4, 2] }}
material.isotropic = {{ young_modulus = 1e9, poisson_ratio = 0.3 }}
clamp = [{{ face = "z_max", components = ["z"] }}]
traction = [{{ face = "x_max", value = [1e3, 0.0, 0.0] }}]
body_force.value = [0.0, 0.0, -1e4]
contact = {{ face = "z_min", multipliers = "nodal" }}
{law}
""")
    contact3d("run", scene, path, "--no-figures", expect=1)
    with h5py.File(path) as file:
        assert read_enum(file["solve/status"]) == "no_equilibrium"
        motion = file["solve/mechanism"][:]
    # Along the push; in whose plane turns do no work.
    assert np.abs(motion - [1.0, 0.0, 0.0]).max() < 1e-3
