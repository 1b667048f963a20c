"""Blocks on springs judged by the conditions of their answers, from raw arrays and the geometry of the springs.

A strain energy, an admissible set and springs are convex, so whatever satisfies the conditions of contact and Tresca's law is the
solution; with Coulomb's law it is one of the law frozen at its own pressure. A displacement that soft springs allow may be a billion
times larger than what strains the body; balances of forces, gaps and slips are held to the last digits of that displacement.
"""

from dataclasses import dataclass
from itertools import pairwise
from pathlib import Path

import h5py
import numpy as np
from scipy import sparse

from convex.judge import SOLVED
from convex.sprung import Sprung
from faults.program import Program
from run_file import facet_faces, open_run, read_enum, read_matrix, read_scene

BALANCE = 1e-6
"""Forces on the body, and on every node, that may be missing beside all of them: what the gate of the program lets pass."""
ROUNDINGS = 1e3
"""Of the largest displacement, in gaps and slips."""
STRAINED = 1e-9
"""Of the displacement beside rigid motions: rounding times the condition of the body's stiffness, likewise."""
TOO_SOFT = "of the body's own stiffness in every motion that they hold"
"""Words of the error on springs that are refused."""
STRESS = 1e-6
"""Of the largest stress, in bounds of friction and in stresses that should vanish."""


@dataclass(frozen=True)
class Judged:
    """What is known of one block."""

    scene: Sprung
    status: str
    wrong: str | None
    """In words; `None` for an answer that is right."""
    softness: float = np.nan
    """E / (k L) of the softest spring."""


def judge(program: Program, scene: Sprung, folder: Path) -> Judged:
    """Run a block and hold its answer against its conditions."""
    text, path = folder / f"{scene.name}.toml", folder / f"{scene.name}.h5"
    text.write_text(scene.text)
    path.unlink(missing_ok=True)
    outcome = program.run("run", text, path, "--no-figures")
    # Messages are broken into lines, within a frame.
    if outcome.code == 2 and TOO_SOFT in " ".join(outcome.stderr.replace("│", " ").split()):
        return Judged(scene, "refused", None)
    if outcome.fault or not path.is_file():
        return Judged(scene, "fault", outcome.fault or outcome.stderr[-300:])
    with open_run(path) as file:
        status = str(read_enum(file["solve/status"]))
        softness = softest(read_scene(file))
        wrong = f"{status}, exit code {outcome.code}"
        if status in SOLVED and outcome.code == 0:
            wrong = violated(file)
    path.unlink()
    return Judged(scene, status, wrong, softness)


def softest(scene: dict) -> float:
    """E / (k L) with the softest spring along any direction and the volume's root as L."""
    stiffness = [
        spring[way]
        for spring in scene["spring"]
        for way in ("normal", "tangential")
        if spring.get(way)
    ]
    length = np.prod(scene["body"]["brick"]["size"]) ** (1 / 3)
    return scene["material"]["isotropic"]["young_modulus"] / (min(stiffness) * length)


def violated(file: h5py.File) -> str | None:
    """The condition that an answer breaks."""
    scene, area = read_scene(file), file["mesh/pane_area"][:]
    m = area.size
    dof = file["assemble/degree_of_freedom"][:]
    u = file["solve/displacement"][:]
    names = ("normal", "tangential")
    names = [n for n in names if f"coupling_{n}" in file["assemble"]]
    coupling = sparse.vstack(
        [read_matrix(file["assemble"][f"coupling_{n}"]) for n in names]
    ).tocsr()
    stress = np.concatenate(
        [file[f"solve/multiplier_{n}"][:].ravel() for n in names]
    )
    load, free = file["load/force"][:], np.empty(dof.max() + 1, dtype=int)
    free[dof.ravel()] = np.arange(dof.size)
    springs = spring_matrix(file, scene)
    stiffness, unknowns = read_matrix(file["assemble/stiffness"]), u.ravel()[free]
    left = np.abs(stiffness @ unknowns + coupling.T @ stress - load).sum()
    size = np.abs(load).sum() + np.abs(coupling.T @ stress).sum()
    # What rounding of u makes of the forces of single nodes.
    rounding = np.finfo(float).eps * (abs(stiffness) @ np.abs(unknowns)).sum()
    if left > BALANCE * size + rounding:
        return f"nodes are out of balance by {left / size:.1e}"
    forces = np.zeros(dof.size)
    forces[free] = load - coupling.T @ stress
    whole = (forces - springs @ u.ravel()).reshape(-1, 3)
    places = file["mesh/coordinates"][:]
    moment = np.cross(places, whole).sum(axis=0)
    missing = max(np.abs(whole.sum(axis=0)).max(), np.abs(moment).max())
    if missing > BALANCE * size:
        return f"the body is out of balance by {missing / size:.1e}"
    moved = (coupling @ unknowns) / np.concatenate(
        [area, np.repeat(area, 2)]
    )[: stress.size]
    resolved = ROUNDINGS * np.finfo(float).eps * np.abs(u).max()
    strained = unknowns
    if "rigid_motion" in file["solve"]:
        strained = unknowns - file["solve/rigid_motion"][:] @ file["assemble/rigid_modes"][:]
    resolved += STRAINED * np.abs(strained).max()
    return contact(scene, area.size, stress, moved, resolved, load, area)


def contact(
    scene: dict,
    m: int,
    stress: np.ndarray,
    moved: np.ndarray,
    resolved: float,
    load: np.ndarray,
    area: np.ndarray,
) -> str | None:
    """The condition of contact and friction that is broken, for gaps and slips up to what is resolved."""
    pressure, rise = stress[:m], -moved[:m]
    least = STRESS * max(np.abs(stress).max(), np.abs(load).sum() / area.sum())
    if pressure.min() < -least:
        return f"adhesion of {-pressure.min():.1e}"
    if rise.min() < -resolved:
        return f"penetration by {-rise.min():.1e}, resolved are {resolved:.1e}"
    if (np.abs(rise[pressure > least]) > resolved).any():
        return "a pressed pane is open"
    if stress.size == m:
        return None
    pairs, slips = stress[m:].reshape(-1, 2), moved[m:].reshape(-1, 2)
    law = scene["friction"]
    friction = law["coefficient"]["constant"]
    bound = friction * (law["slip_bound"] if "slip_bound" in law else pressure)
    bound = np.broadcast_to(bound, (m,))
    excess = (np.linalg.norm(pairs, axis=1) - bound).max()
    if excess > least:
        return f"friction beyond its bound by {excess:.1e}"
    length = np.linalg.norm(slips, axis=1)
    slides = length > resolved
    # Friction is along the slip, whose direction is known as well as it is resolved.
    along = np.einsum("pk,pk->p", pairs, slips)[slides] / length[slides]
    lost = (bound[slides] * (1 - resolved / length[slides]) - along).max(initial=0.0)
    return f"friction is {lost:.1e} short of its bound" if lost > least else None


def spring_matrix(file: h5py.File, scene: dict) -> sparse.csr_matrix:
    """K over all components of all nodes, from the triangles of the faces on springs."""
    places, facets = file["mesh/coordinates"][:], file["mesh/facets"][:]
    names = facet_faces(file["mesh"])
    middles = mid_edges(file)
    rows, columns, values = [], [], []
    for spring in scene["spring"]:
        axis = "xyz".index(spring["face"][0])
        stiffness = np.full(3, spring.get("tangential", 0.0))
        stiffness[axis] = spring.get("normal", 0.0)
        for corners in facets[names == spring["face"]]:
            a, b, c = places[corners]
            area = np.linalg.norm(np.cross(b - a, c - a)) / 2
            nodes, mass = triangle(corners, middles)
            for k in range(3):
                at = 3 * nodes + k
                rows.append(np.repeat(at, at.size))
                columns.append(np.tile(at, at.size))
                values.append((stiffness[k] * area * mass).ravel())
    entries = np.concatenate(values), (np.concatenate(rows), np.concatenate(columns))
    return sparse.csr_matrix(entries, shape=(3 * len(places), 3 * len(places)))


def mid_edges(file: h5py.File) -> dict[tuple[int, int], int]:
    """The node in the middle of every edge, of quadratic elements."""
    mesh = file["mesh"]
    if "tetrahedron_mid_edges" not in mesh:
        return {}
    places = mesh["coordinates"][:]
    known = {}
    for corners, middles in zip(
        mesh["tetrahedra"][:], mesh["tetrahedron_mid_edges"][:]
    ):
        edges = [(i, j) for i in range(4) for j in range(i)]
        for i, j in edges:
            middle = (places[corners[i]] + places[corners[j]]) / 2
            nearest = np.linalg.norm(places[middles] - middle, axis=1).argmin()
            known[tuple(sorted((corners[i], corners[j])))] = middles[nearest]
    return known


def triangle(
    corners: np.ndarray, middles: dict[tuple[int, int], int]
) -> tuple[np.ndarray, np.ndarray]:
    """The nodes of a triangle and the integrals of the products of their shape functions over its area."""
    if not middles:
        return corners, (np.ones((3, 3)) + np.eye(3)) / 12
    edges = list(pairwise([*corners, corners[0]]))
    nodes = [*corners, *(middles[tuple(sorted(edge))] for edge in edges)]
    mass = np.zeros((6, 6))
    mass[:3, :3] = 7 * np.eye(3) - 1
    mass[3:, 3:] = 16 * (np.eye(3) + 1)
    for corner in range(3):
        opposite = 3 + (corner + 1) % 3
        mass[corner, opposite] = mass[opposite, corner] = -4
    return np.array(nodes), mass / 180
