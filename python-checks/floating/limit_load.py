"""Loads up to which contact can hold a random body, by linear programmes with cutting planes, and the program's proofs beside them."""

from dataclasses import dataclass
from pathlib import Path

import h5py
import numpy as np
from scipy.optimize import linprog

from faults.program import Program
from run_file import open_run, read_enum, read_matrix

MARGINS = (1e-2, 1e-4, 1e-6, 1e-7)
"""Work that is left in the critical motion, for a load and a motion of length one, at loads on both sides of the limit."""
SETTLED = 1e-9
"""Distance, as a share, between forces in hand and a motion that they cannot resist; HiGHS solves to 1e-10."""
LARGEST_MOTION = 1e6
"""Of y in a linear programme, which is otherwise unbounded where the limit is zero."""


@dataclass(frozen=True)
class Scene:
    """A body under its weight and under LOAD times a traction; the laws of its faces are (F1, F2, g), g = inf for Coulomb's."""

    text: str
    laws: dict[str, tuple[float, float, float]]

    def at(self, load: float) -> str:
        """The scene at a load."""
        return self.text.replace("LOAD", repr(float(load)))


def scene(seed: int, number: int) -> Scene:
    """A block on a floor, beside walls, or below a ceiling, each with a law of its own."""
    draw = np.random.default_rng([seed, number])
    size = np.exp(draw.uniform(-0.7, 0.7, 3))
    faces = [["z_min"], ["z_min"], ["z_min", "x_min"], ["z_min", "x_min", "y_min"], ["z_min", "z_max"]][draw.integers(5)]
    weight = [-draw.uniform(0, 0.3) * ("x_min" in faces), -draw.uniform(0, 0.3) * ("y_min" in faces), -1.0]
    push = draw.normal(size=3) * [1.0, 1.0, 0.3]
    lines = [
        'title = "limit"',
        f"body.brick = {{ size = {size.tolist()}, cells = {draw.choice([2, 4], 3).tolist()} }}",
        "material.isotropic = { young_modulus = 1e9, poisson_ratio = 0.3 }",
        f"body_force.value = {[float(w) for w in weight]}",
        f"traction = [{{ face = 'x_max', value = {[f'{p!r}*LOAD' for p in push.tolist()]} }}]",
    ]
    laws = {}
    for face in faces:
        first, second = (10.0 ** draw.uniform(-1.3, 0.2, 2)).tolist()
        law = draw.choice(["isotropic", "orthotropic", "given", "none"], p=(0.4, 0.3, 0.15, 0.15))
        second = second if law == "orthotropic" else first
        given = float(draw.uniform(0, 0.5))
        multipliers = draw.choice(["panes", "nodal"]) if {"x_min", "y_min"}.isdisjoint(faces) else "panes"
        lines += ["[[contact]]", f'face = "{face}"', f'multipliers = "{multipliers}"']
        if law != "none":
            laws[face] = (first, second, given if law == "given" else np.inf)
            lines += [f"friction.coefficient_1.constant = {first!r}", f"friction.coefficient_2.constant = {second!r}"]
        if law == "given":
            lines.append(f"friction.slip_bound = {given!r}")
    return Scene("\n".join(lines), laws)


@dataclass(frozen=True)
class Contact:
    """What motions of a rigid body, which move its face by about one, do to panes: rows [m, n] and [m, 2, n]."""

    pressure: np.ndarray
    """Mean normal displacement."""
    friction: np.ndarray
    """F times the tangential one, where friction follows the pressure; else zero."""
    bounded: np.ndarray
    """Area g F times it, where friction has a given bound; else zero."""
    felt: np.ndarray
    """The motions in terms of degrees of freedom, [n, n_free]."""
    null: np.ndarray
    """Those that move no pane."""

    @classmethod
    def read(cls, file: h5py.File, laws: dict[str, tuple[float, float, float]]) -> "Contact":
        """From B, the rigid modes and the areas."""
        assemble, mesh = file["assemble"], file["mesh"]
        area, modes = mesh["pane_area"][:], assemble["rigid_modes"][:]
        moved = np.zeros((area.size, 3, modes.shape[0]))
        moved[:, 0] = read_matrix(assemble["coupling_normal"]) @ modes.T
        if "coupling_tangential" in assemble:
            pairs = read_matrix(assemble["coupling_tangential"]) @ modes.T
            moved[: pairs.shape[0] // 2, 1:] = pairs.reshape(-1, 2, modes.shape[0])
        moved /= area[:, None, None]
        weighted = (moved * np.sqrt(area / area.sum())[:, None, None]).reshape(-1, modes.shape[0])
        _, sizes, axes = np.linalg.svd(np.vstack([weighted, np.zeros((modes.shape[0],) * 2)]), full_matrices=False)
        is_felt = sizes > 1e-9 * sizes.max()
        felt = (axes[is_felt] / sizes[is_felt, None]) @ modes
        moved = moved @ (axes[is_felt] / sizes[is_felt, None]).T
        coulomb, given = np.zeros((2, area.size, 2, 1))
        names, starts = ["z_min"], [0, area.size]
        if "contact_face_names" in mesh:
            names, starts = mesh["contact_face_names"][()].decode().splitlines(), mesh["contact_face_panes"][:]
        for name, first, last in zip(names, starts, starts[1:], strict=False):
            *f, g = laws.get(name, (0.0, 0.0, np.inf))
            coulomb[first:last, :, 0] = f if np.isinf(g) else 0.0
            given[first:last, :, 0] = 0.0 if np.isinf(g) else np.multiply(f, g)
        given *= area[:, None, None]
        return cls(moved[:, 0], coulomb * moved[:, 1:], given * moved[:, 1:], felt, axes[~is_felt] @ modes)

    def opposed(self, motion: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
        """Work per unit of pressure, and work of given bounds, [m] each."""
        return self.pressure @ motion + np.linalg.norm(self.friction @ motion, axis=1), np.linalg.norm(
            self.bounded @ motion, axis=1
        )


def limit(contact: Contact, dead: np.ndarray, live: np.ndarray) -> tuple[float, float] | None:
    """The largest factor t at which admissible forces balance dead + t live, inf if all do, and the change of t that makes the work of the
    load in the critical motion one for a load and a motion of length one; None if it cannot be told.

    The least of (sum |W_i y| - dead y) / live y over motions y that no pressure opposes, by planes instead of cones where the last
    motion violates them. Forces in hand (the multipliers of the linear programme) and the motion must give one limit.
    """
    m, n = contact.pressure.shape
    rows, pulls, given = [contact.pressure], [np.zeros((m, m))], []
    for angle in 2 * np.pi * np.arange(16) / 16:
        d = np.array([np.cos(angle), np.sin(angle)])
        rows += [contact.pressure + d @ contact.friction, np.einsum("t,mtn->mn", d, contact.bounded)]
        pulls += [np.zeros((m, m)), np.eye(m)]
    for _ in range(60):
        planes, work = np.vstack(rows), np.vstack(pulls)
        found = linprog(
            np.concatenate([-dead, np.ones(m)]),
            A_ub=np.hstack([planes, -work]),
            b_ub=np.zeros(planes.shape[0]),
            A_eq=np.concatenate([live, np.zeros(m)])[None],
            b_eq=[1.0],
            bounds=[(-LARGEST_MOTION, LARGEST_MOTION)] * n + [(0, None)] * m,
            method="highs",
            options={"primal_feasibility_tolerance": 1e-10, "dual_feasibility_tolerance": 1e-10},
        )
        if found.status == 2:
            return np.inf, np.inf
        if not found.success:
            return None
        motion = found.x[:n]
        if np.abs(motion).max() > 0.99 * LARGEST_MOTION:
            return None
        by_pressure, by_bounds = contact.opposed(motion)
        upper = by_bounds.sum() - dead @ motion
        violated = by_pressure > SETTLED
        if not violated.any() and upper - found.fun <= SETTLED * abs(upper):
            forces = -found.ineqlin.marginals @ planes
            balanced = np.abs(forces - dead - found.fun * live).max() <= SETTLED * np.abs(dead).max()
            size = np.linalg.norm(dead + upper * live) * np.linalg.norm(motion)
            return (float(upper), float(size)) if balanced else None
        for lengths, matrix, keep, force in (
            (np.linalg.norm(contact.friction @ motion, axis=1), contact.friction, violated, 0.0),
            (by_bounds, contact.bounded, by_bounds > 0, 1.0),
        ):
            d = (matrix @ motion)[keep] / np.maximum(lengths[keep], 1e-300)[:, None]
            base = contact.pressure[keep] if force == 0.0 else 0.0
            rows.append(base + np.einsum("kt,ktn->kn", d, matrix[keep]))
            pulls.append(force * np.eye(m)[keep])
    return None


def proof_fails(contact: Contact, load: np.ndarray, motion: np.ndarray) -> str | None:
    """Why a motion of the degrees of freedom proves nothing: pressures oppose it, or the load does no more work than given bounds."""
    weights = np.linalg.lstsq(np.vstack([contact.felt, contact.null]).T, motion, rcond=None)[0]
    felt = weights[: contact.felt.shape[0]]
    by_pressure, by_bounds = contact.opposed(felt)
    size = np.abs(weights).max()
    if by_pressure.max() > 1e-12 * size:
        return f"pressure does work of {by_pressure.max():.1e} in a motion of {size:.1e}"
    left = load @ motion - by_bounds.sum()
    return None if left > 0.0 else f"the load does work of {left:.1e} more than contact"


def judge(program: Program, seed: int, number: int, folder: Path) -> tuple[str, list[str]]:
    """What is known of the limit of a scene, and what is wrong with the program's verdicts around it."""
    one = scene(seed, number)
    path, run = folder / "limit.toml", folder / "limit.h5"

    def solved(load: float) -> tuple[str, np.ndarray, Contact, str | None]:
        path.write_text(one.at(load))
        run.unlink(missing_ok=True)
        outcome = program.run("run", path, run, "--no-figures")
        if outcome.fault or outcome.code not in (0, 1):
            raise RuntimeError(f"{number}: {outcome.fault or outcome.stderr[-300:]}")
        with open_run(run) as file:
            status = str(read_enum(file["solve/status"]))
            contact, force = Contact.read(file, one.laws), file["load/force"][:]
            if status != "no_equilibrium":
                return status, force, contact, None
            dof, nodal = file["assemble/degree_of_freedom"][:], file["solve/mechanism"][:]
            motion = np.empty(dof.max() + 1)
            motion[dof[dof >= 0]] = nodal[dof >= 0]
            return status, force, contact, proof_fails(contact, force, motion)

    wrong = []

    def expect(load: float, holds: bool) -> None:
        status, _, _, fault = solved(load)
        if fault or holds == (status == "no_equilibrium"):
            wrong.append(f"scene {number} at {load!r}, which {'can' if holds else 'cannot'} be held: {status}; {fault}")

    _, dead, contact, _ = solved(0.0)
    _, whole, _, _ = solved(1.0)
    live = whole - dead
    if np.abs(contact.null @ live).max(initial=0.0) > 1e-9 * np.abs(contact.null).max(initial=0.0) * np.abs(live).sum():
        expect(1.0, False)
        return "null motion", wrong
    found = limit(contact, contact.felt @ dead, contact.felt @ live)
    if found is None or found[0] <= 0.0:
        return "unknown", wrong
    most, work = found
    if np.isinf(most):
        expect(1.0, True)
        expect(1e3, True)
        return "held", wrong
    for margin in MARGINS:
        expect(max(most - margin * work, 0.0), True)
        expect(most + margin * work, False)
    return "limit", wrong
