"""Random bodies of three tetrahedra with one to three contact nodes, their laws and loads."""

from dataclasses import dataclass
from pathlib import Path

import h5py
import numpy as np
from scipy.sparse.linalg import splu

from faults.program import Program
from paths.solutions import Law, Problem
from run_file import read_matrix

TETRAHEDRA = [[0, 1, 2, 5], [0, 1, 5, 4], [0, 4, 5, 3]]
LAWS = ("constant", "ramp", "orthotropic", "two ramps")
GRIDS = {1: (36, 10), 2: (12, 4), 3: (12, 4)}


@dataclass(frozen=True)
class Body:
    """A scene without its law and load, S, and h for a unit of body force along each axis."""

    text: str
    operator: np.ndarray
    rhs: np.ndarray
    area: np.ndarray


@dataclass(frozen=True)
class Case:
    """A scene file, the range of one of its keys, and the problem at the end of the range."""

    path: Path
    key: str
    span: tuple[float, float]
    problem: Problem


def body(program: Program, folder: Path, nodes: int, random: np.random.Generator) -> Body:
    """A body whose foot has so many free nodes."""
    while True:
        foot = random.uniform(0, 3, size=(3, 2))
        top = np.c_[random.uniform(0, 3, size=(3, 2)), random.uniform(0.4, 1.2, size=3)]
        points = np.r_[np.c_[foot, np.zeros(3)], top]
        edges = [points[t[1:]] - points[t[0]] for t in TETRAHEDRA]
        volumes = np.array([np.linalg.det(e) / 6 for e in edges])
        if (volumes > 0.08).all():
            break
    mesh = folder / "body.msh"
    mesh.write_text(gmsh(points))
    held = [*range(nodes, 3), 3, 4, 5]
    clamps = "".join(
        f"[[clamp]]\nbox=[{(points[i] - 1e-3).tolist()},{(points[i] + 1e-3).tolist()}]\n" for i in held
    )
    poisson = random.uniform(0.2, 0.45)
    text = (
        f'title="random"\nbody.gmsh={{file="body.msh"}}\n[material.isotropic]\n'
        f"young_modulus=2.6\npoisson_ratio={poisson}\n{clamps}"
        '[contact]\nface="foot"\nmultipliers="nodal"\n'
    )
    scene = folder / "unit.toml"
    force = "[body_force]\nvalue=[1.0,1.0,1.0]\n"
    scene.write_text(text + force + "[friction]\ncoefficient.constant=0.1\n")
    run = folder / "unit.h5"
    program.run("run", scene, run, "--no-figures")
    with h5py.File(run) as file:
        assemble = file["assemble"]
        coupling = [read_matrix(assemble[f"coupling_{k}"]).toarray() for k in ("normal", "tangential")]
        factor = splu(read_matrix(assemble["stiffness"]).tocsc())
        dof = assemble["degree_of_freedom"][:]
        load = file["load/force"][:]
        area = file["mesh/pane_area"][:]
    B = np.concatenate(coupling)
    axis = np.zeros(len(load), int)
    for node in dof:
        for k, place in enumerate(node):
            if place >= 0:
                axis[place] = k
    loads = np.stack([np.where(axis == k, load, 0.0) for k in range(3)], axis=1)
    return Body(text, B @ factor.solve(B.T.copy()), B @ factor.solve(loads), area)


def gmsh(points: np.ndarray) -> str:
    """The body in Gmsh's format 2.2, its foot the face of the first three points."""
    nodes = "".join(f"{i + 1} {x} {y} {z}\n" for i, (x, y, z) in enumerate(points.tolist()))
    tetrahedra = "".join(
        f"{i + 2} 4 2 2 2 {' '.join(str(n + 1) for n in t)}\n" for i, t in enumerate(TETRAHEDRA)
    )
    return (
        "$MeshFormat\n2.2 0 8\n$EndMeshFormat\n$PhysicalNames\n2\n"
        '2 1 "foot"\n3 2 "body"\n$EndPhysicalNames\n'
        f"$Nodes\n6\n{nodes}$EndNodes\n$Elements\n4\n1 2 2 1 1 1 3 2\n{tetrahedra}$EndElements\n"
    )


def case(body: Body, folder: Path, name: str, law: str, random: np.random.Generator) -> Case:
    """A law of a kind, and a load under which there may be several solutions."""
    force, ratio = load(body, random)
    h = body.rhs @ force
    m = len(body.area)
    way = np.abs(h[m:].reshape(m, 2) / body.area[:, None]).max()
    # Above this ratio the face may stick, slide or open.
    high, low = ratio * random.uniform(1.02, 2), random.uniform(0.1, 0.9)

    def ramp() -> tuple[float, float, float, float]:
        onset, width = random.uniform(0.02, 0.5, size=2) * way
        return ratio * random.uniform(1.02, 2), ratio * random.uniform(0.05, 0.9), onset, width

    def toml(initial, residual, onset, width) -> str:
        rate = abs(initial - residual) / width
        return f"ramp={{initial={initial},residual={residual},onset={onset},rate={rate}}}"

    if law == "constant":
        key, text = "friction.coefficient.constant", f"coefficient.constant={high}"
        span, function = (0.1, high), constant(high, high)
    elif law == "orthotropic":
        key = "friction.coefficient_1.constant"
        text = f"coefficient_1.constant={high}\ncoefficient_2.constant={low}"
        span, function = (low, high), constant(high, low)
    elif law == "ramp":
        one = ramp()
        key, text = "friction.coefficient.ramp.residual", f"coefficient.{toml(*one)}"
        span, function = (one[1] / 2, one[1]), isotropic(one)
    else:
        one, two = ramp(), ramp()
        key = "friction.coefficient_1.ramp.residual"
        text = f"coefficient_1.{toml(*one)}\ncoefficient_2.{toml(*two)}"
        span, function = (one[1] / 2, one[1]), orthotropic(one, two)
    path = folder / f"{name}.toml"
    path.write_text(f"{body.text}[body_force]\nvalue={force.tolist()}\n[friction]\n{text}\n")
    problem = Problem(body.operator, h, body.area, function, GRIDS[m])
    return Case(path, key, span, problem)


def load(body: Body, random: np.random.Generator) -> tuple[np.ndarray, float]:
    """A body force that opens a node which the glued face presses, if one of 300 does, and |lambda_t|/lambda_n there."""
    m = len(body.area)
    best = np.array([1e-3, 5e-4, -5e-4]), 2.0
    for force in random.normal(size=(300, 3)) * 1e-3:
        h = body.rhs @ force
        glued = np.linalg.solve(body.operator, h)
        ratio = np.linalg.norm(glued[m:].reshape(m, 2), axis=1) / np.maximum(glued[:m], 1e-30)
        hard = (h[:m] < 0) & (glued[:m] > 0)
        if hard.any() and ratio[hard].min() < 3.5:
            return force, float(ratio[hard].min())
    return best


def constant(first: float, second: float) -> Law:
    """Constant coefficients."""
    return lambda slip: np.broadcast_to([first, second], slip.shape)


def on_ramp(slip: np.ndarray, one) -> np.ndarray:
    """F of a ramp."""
    initial, residual, onset, width = one
    return np.interp(slip, [onset, onset + width], [initial, residual])


def isotropic(one) -> Law:
    """F(|u|)."""
    return lambda slip: np.repeat(on_ramp(np.linalg.norm(slip, axis=-1, keepdims=True), one), 2, -1)


def orthotropic(one, two) -> Law:
    """F_1(|u_1|), F_2(|u_2|)."""
    return lambda slip: np.stack(
        [on_ramp(np.abs(slip[..., 0]), one), on_ramp(np.abs(slip[..., 1]), two)], -1
    )
