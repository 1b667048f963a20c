"""Rigid tools: motions, forces and the conditions of contact against them, recomputed from meshes and scenes."""

import os
import subprocess

import numpy as np
import pytest
from scipy.optimize import linprog

from conftest import ROOT
from run_file import open_run, read_matrix, read_scene

MOTIONS = ("x", "y", "z", "turn_x", "turn_y", "turn_z")

# Random scenes; 200 for a campaign.
SCENES = int(os.environ.get("CONTACT3D_TOOL_SCENES", "8"))


def random_scene(seed):
    """A clamped block against a plane, a ball or a rod whose six motions are given, or free under loads that press it."""
    draw = np.random.default_rng(seed)
    size = np.exp(draw.uniform(-0.4, 0.4, 3))
    cells = [int(n) for n in 2 * draw.integers(1, 4, 3)]
    top, middle = size[2], size / 2
    unit = 10.0 ** draw.integers(-3, 4)
    radius = draw.uniform(1.0, 4.0)
    shapes = [
        f"half_space = {{ point = [0.0, 0.0, {top}], normal = [0.0, 0.0, -1.0] }}",
        f"sphere = {{ centre = [{middle[0]}, {middle[1]}, {top + radius}], radius = {radius} }}",
        f"cylinder = {{ point = [{middle[0]}, 0.0, {top + radius}], direction = [0.0, 1.0, 0.0], radius = {radius} }}",
    ]
    friction = draw.choice([0.0, 0.2, 0.5])
    free = [name for name in MOTIONS if draw.random() < 0.5]
    if friction == 0.0:
        # What friction alone resists has no equilibrium, or any place.
        free = [name for name in free if name == "z"]
    given = 1e-2 * draw.uniform(-0.4, 0.4, 6)
    given[2] = -1e-2 * draw.uniform(0.5, 1.5)
    area = size[0] * size[1]
    load = unit * area * 1e-2 * draw.uniform(-0.05, 0.05, 6) * max(friction, 0.0)
    load[2] = -unit * area * 1e-2 * draw.uniform(0.3, 1.0)
    load[3:] *= 0.2
    is_free = np.isin(MOTIONS, free)
    given, load = np.where(is_free, 0.0, given), np.where(is_free, load, 0.0)
    point = f"point = {(middle + draw.uniform(-0.2, 0.2, 3)).tolist()}" if draw.random() < 0.5 else ""
    law = f"[friction]\ncoefficient.constant = {friction}\n" if friction else ""
    # Some in two steps, half of loads and motions first.
    steps = "[[step]]\nfactor.tool = 0.5\n[[step]]\nfactor.tool = 1.0\n" if draw.random() < 0.3 else ""
    return f"""title = "random tool {seed}"
[body]
element = "{draw.choice(["P1", "P2"])}"
[body.brick]
size = {size.tolist()}
cells = {cells}
[material.isotropic]
young_modulus = {unit}
poisson_ratio = {draw.uniform(0.0, 0.45)}
[[clamp]]
face = "z_min"
[contact]
face = "z_max"
tool = "tool"
follow = "start"
multipliers = "{draw.choice(["panes", "nodal"])}"
[contact.obstacle]
{draw.choice(shapes)}
[[tool]]
name = "tool"
{point}
free = {free}
displacement = {given[:3].tolist()}
turn = {given[3:].tolist()}
force = {load[:3].tolist()}
moment = {load[3:].tolist()}
{law}{steps}"""


class Against:
    """The contact of one face with one tool, from coordinates, panes and normals."""

    def __init__(self, file):
        mesh = file["mesh"]
        self.x = mesh["coordinates"][:][mesh["contact_nodes"][:]]
        self.nodes = mesh["contact_nodes"][:]
        n = len(self.x)
        if "contact_node_normal" in mesh:
            self.normal = mesh["contact_node_normal"][:]
        else:
            self.normal = np.broadcast_to(mesh["contact_normal"][:], (n, 3))
        self.gap = mesh["contact_clearance"][:]
        self.axes = [file[f"post/contact_axis_{k}"][:] for k in (1, 2)]
        self.mean = read_matrix(mesh["pane_average"]).tocsc().T.tocsr()
        self.area = mesh["pane_area"][:]
        self.opposite = self.x + self.gap[:, None] * self.normal

    def relative(self, u, displacement, turn, point):
        """u less the displacement of the opposite points."""
        return u - displacement - np.cross(turn, self.opposite - point)

    def over_panes(self, vector):
        """Means along nu, t1 and t2, [3, m]."""
        along = [self.normal, *self.axes]
        return np.array([self.mean @ (vector * axis).sum(axis=1) for axis in along])

    def forces(self, pressure, shear):
        """Forces of the tool on the contact nodes."""
        parts = zip([self.normal, *self.axes], [pressure, *shear.T], strict=True)
        return -sum(axis * (self.mean.T @ (self.area * part))[:, None] for axis, part in parts)


def states(file):
    """Displacement, pressure, shear and tool of each increment, and from where its slip counts."""
    if "history" in file:
        history = file["history"]
        normal = history["multiplier_normal"][:]
        frictionless = np.zeros((*normal.shape, 2))
        rows = zip(
            history["displacement"][:],
            normal,
            history["multiplier_tangential"][:] if "multiplier_tangential" in history else frictionless,
            *(history[f"tool_{name}"][:, 0] for name in ("displacement", "turn", "force", "moment")),
            strict=True,
        )
        return list(rows)
    solve, tools = file["solve"], file["post/tools"]
    pressure = solve["multiplier_normal"][:]
    shear = np.zeros((pressure.size, 2))
    if "multiplier_tangential" in solve:
        shear = solve["multiplier_tangential"][:]
    of_tool = [tools[name][0] for name in ("displacement", "turn", "force", "moment")]
    return [(solve["displacement"][:], pressure, shear, *of_tool)]


def check(file):
    """Holds every increment against the conditions of contact, friction and equilibrium."""
    scene, against = read_scene(file), Against(file)
    friction = scene.get("friction", {}).get("coefficient", {}).get("constant", 0.0)
    point = file["post/tools/point"][0]
    dof = file["assemble/degree_of_freedom"][:]
    stiffness = read_matrix(file["assemble/stiffness"])
    of_nodes = dof.max() + 1
    before = np.zeros((2, against.area.size))
    for k, (u, pressure, shear, displacement, turn, force, moment) in enumerate(states(file)):
        nodal = np.zeros_like(u)
        np.add.at(nodal, against.nodes, against.forces(pressure, shear))
        size = np.abs(nodal).sum()
        # Equilibrium of the body at its free nodes, in which loads do not act here but on the tool.
        moved = np.zeros(stiffness.shape[0])
        moved[dof[dof >= 0]] = u[dof >= 0]
        inner = (stiffness @ moved)[:of_nodes]
        left = inner[dof[dof >= 0]] - nodal[dof >= 0]
        assert np.abs(left).max() <= 1e-9 * size
        # That of the tool.
        on_nodes = against.forces(pressure, shear)
        lever = against.opposite - point
        assert np.abs(on_nodes.sum(axis=0) - force).max() <= 1e-10 * size
        reach = np.abs(lever).max()
        assert np.abs(np.cross(lever, on_nodes).sum(axis=0) - moment).max() <= 1e-10 * size * reach
        # Contact and friction on the panes.
        normal, *slid = against.over_panes(against.relative(u[against.nodes], displacement, turn, point))
        gap = against.mean @ against.gap - normal
        if "history/slip_origin" in file:
            before = (against.mean @ file["history/slip_origin"][k]).T
        slip = np.array(slid) - before
        before = np.array(slid)
        high = pressure.max()
        scale = np.abs(u).max() + np.abs(against.gap).max()
        assert pressure.min() >= -1e-9 * high
        assert gap.min() >= -1e-9 * scale
        assert np.abs(pressure * gap).max() <= 1e-9 * high * scale
        limit = friction * np.maximum(pressure, 0.0)
        size_of_shear = np.linalg.norm(shear, axis=1)
        assert (size_of_shear <= limit + 1e-8 * high).all()
        # Stress at the limit works along the slip, and less than that sticks.
        missing = limit * np.linalg.norm(slip, axis=0) - (shear * slip.T).sum(axis=1)
        assert np.abs(missing).max() <= 1e-8 * high * scale
        yield displacement, turn, force, moment


def is_held(file):
    """Whether any pressures and friction on the panes bear the load of the free motions; friction within a polygon around its circle."""
    scene, against = read_scene(file), Against(file)
    (tool,) = scene["tool"]
    friction = scene.get("friction", {}).get("coefficient", {}).get("constant", 0.0)
    point = np.array(tool.get("point", turning_point(scene["contact"], file, against)))
    free = np.isin(MOTIONS, tool.get("free", []))
    given = [np.array(tool.get(key, [0.0] * 3)) for key in ("displacement", "turn")]
    closed = against.over_panes(against.relative(0.0, *given, point))[0] - against.mean @ against.gap
    if not free[2] and closed.max() < 0.0:
        # Where it is held no pane touches it.
        return False
    angles = np.arange(16) * np.pi / 8
    corners = friction / np.cos(np.pi / 16) * np.column_stack([np.cos(angles), np.sin(angles)])
    columns = []
    for pane in range(against.area.size):
        for corner in corners if friction else [np.zeros(2)]:
            pressure, shear = np.zeros(against.area.size), np.zeros((against.area.size, 2))
            pressure[pane], shear[pane] = 1.0, corner
            forces = against.forces(pressure, shear)
            moment = np.cross(against.opposite - point, forces).sum(axis=0)
            columns.append(np.concatenate([forces.sum(axis=0), moment])[free])
    load = np.concatenate([tool.get(key, [0.0] * 3) for key in ("force", "moment")])[free]
    arms = np.linalg.norm(against.opposite - point, axis=1).max()
    scale = np.abs(columns).max(axis=0) + 1e-300
    # What a pane in the middle of a turn does not bear is rounding of arms.
    is_borne = scale > 1e-12 * against.area.max() * np.where(np.arange(6) < 3, 1.0, arms)[free]
    if (load[~is_borne] != 0.0).any():
        return False
    columns, scale, load = np.array(columns)[:, is_borne], scale[is_borne], load[is_borne]
    size = np.abs(load / scale).max() + 1e-300
    found = linprog(np.zeros(len(columns)), A_eq=(columns / scale).T, b_eq=load / scale / size)
    return found.status == 0


def turning_point(contact, file, against):
    """What a tool turns about unless its scene says otherwise: the centre or the axis of a round one, or the middle of the contact face."""
    middle = against.area @ (against.mean @ against.x) / against.area.sum()
    contact = contact[0] if isinstance(contact, list) else contact
    obstacle = contact.get("obstacle", {})
    if "sphere" in obstacle:
        return np.array(obstacle["sphere"]["centre"])
    if "cylinder" in obstacle:
        start, along = (np.array(obstacle["cylinder"][key]) for key in ("point", "direction"))
        return start + along * (along @ (middle - start)) / (along @ along)
    return middle


@pytest.mark.parametrize("seed", range(SCENES))
def test_random_tools(seed, program, tmp_path):
    """Motions that are given are taken, loads that are given are borne, and all conditions hold; or no contact forces bear the loads."""
    scene, path = tmp_path / "scene.toml", tmp_path / "run.h5"
    scene.write_text(random_scene(seed))
    result = subprocess.run([program, "--quiet", "run", scene, path, "--no-figures"], capture_output=True, text=True, check=False)
    with open_run(path) as file:
        if "contact cannot hold" in result.stderr:
            assert result.returncode == 1 and not is_held(file)
            return
        if result.returncode == 1:
            pytest.skip("no solution was found, and no proof that there is none")
        assert result.returncode == 0, result.stderr
        tool = read_scene(file)["tool"][0]
        keys = ("displacement", "turn", "force", "moment")
        whole = [np.array(tool.get(key, [0.0] * 3)) for key in keys]
        free = np.isin(MOTIONS, tool.get("free", []))
        states = list(check(file))
        for share, found in zip([0.5, 1.0][-len(states) :], states, strict=True):
            motion, load = np.concatenate(found[:2]), np.concatenate(found[2:])
            given = [share * part for part in whole]
            # Turns are stored times an arm: roundings.
            assert np.allclose(motion[~free], np.concatenate(given[:2])[~free], rtol=1e-14, atol=0.0)
            wanted = np.concatenate(given[2:])[free]
            assert np.abs(load[free] - wanted).max(initial=0.0) <= 1e-10 * np.abs(load).max()


def test_a_history_that_follows_its_tool_by_stages(contact3d, tmp_path):
    """The moved obstacle needs B, S and h of its own, with the loads of a stored assembly as with those just made."""
    whole, staged = tmp_path / "whole.h5", tmp_path / "staged.h5"
    small = ["--set", "body.brick.cells=[12,2,3]"]
    contact3d("run", ROOT / "pipelines" / "roller.toml", whole, "--no-figures", *small)
    contact3d("mesh", ROOT / "pipelines" / "roller.toml", staged, *small)
    for stage in ("assemble", "solve"):
        contact3d(stage, staged)
    with open_run(whole) as one, open_run(staged) as other:
        for name in ("solve/multiplier_normal", "solve/displacement", "history/tool_displacement"):
            assert np.array_equal(one[name][:], other[name][:]), name


def test_a_tool_that_is_lifted_leaves_nothing(contact3d, tmp_path):
    """The distances of the last increment are those before it, with an error of |u_t|^2/2R that is no penetration."""
    (tmp_path / "lift.toml").write_text("""
body.brick = { size = [60.0, 10.0, 20.0], cells = [24, 2, 3] }
material.isotropic = { young_modulus = 50.0, poisson_ratio = 0.4 }
clamp = [{ face = "z_min" }]
friction.coefficient.constant = 0.3
contact.face = "z_max"
contact.tool = "roller"
contact.obstacle.cylinder = { point = [25.0, 0.0, 40.0], direction = [0.0, 1.0, 0.0], radius = 20.0 }
tool = [{ name = "roller", displacement = [3.0, 0.0, -0.5] }]
step = [{ increments = 3, factor.roller = 1.0 }, { increments = 3, factor.roller = 0.0 }]
""")
    contact3d("run", "--no-figures", tmp_path / "lift.toml", tmp_path / "lift.h5")
    words = contact3d("status", tmp_path / "lift.h5").stdout
    assert "normal force         0 N" in words
    assert not any(word in words for word in ("no pane", "interference", "inside"))
    with open_run(tmp_path / "lift.h5") as file:
        assert file["history/gap"][-1].min() > 0.0 == file["history/multiplier_normal"][-1].max()


def test_a_tool_without_force_presses_nothing(contact3d, tmp_path):
    """A free tool without force stays near the body that it has left."""
    (tmp_path / "let_go.toml").write_text("""
body.brick = { size = [24.0, 10.0, 10.0], cells = [24, 2, 3] }
material.isotropic = { young_modulus = 50.0, poisson_ratio = 0.4 }
clamp = [{ face = "z_min" }]
friction.coefficient.constant = 0.3
contact.face = "z_max"
contact.tool = "roller"
contact.multipliers = "nodal"
contact.obstacle.cylinder = { point = [9.0, 0.0, 15.0], direction = [0.0, 1.0, 0.0], radius = 5.0 }
tool = [{ name = "roller", free = ["z"], force = [0.0, 0.0, -40.0], displacement = [3.0, 0.0, 0.0] }]

[[step]]
value = { "roller.displacement" = [0.0, 0.0, 0.0] }

[[step]]
increments = 4
value = { "roller.displacement" = [3.0, 0.0, 0.0] }

[[step]]
increments = 2
value = { "roller.force" = [0.0, 0.0, 0.0] }
""")
    contact3d("run", "--no-figures", tmp_path / "let_go.toml", tmp_path / "let_go.h5")
    with open_run(tmp_path / "let_go.h5") as file:
        assert not file["solve/multiplier_normal"][:].any()
        # It may stay anywhere above; a hundredth of how far it was pressed in is near.
        height = file["history/tool_displacement"][:, 0, 2]
        assert 0.0 <= height[-1] < -0.01 * height[-2]
