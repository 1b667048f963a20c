"""One scene judged: whether the program solved it, and how far its answer is from the solution."""

from dataclasses import dataclass
from pathlib import Path

import h5py
import numpy as np

from convex.reference import (
    ROUNDINGS,
    Dual,
    about,
    by_active_sets,
    newton,
)
from convex.scenes import Scene
from faults.program import Program
from run_file import open_run, read_enum

SOLVED = ("converged", "reduced_accuracy", "machine_precision")
LEAST = 1e-10
"""Errors below this are none."""
MOST_RATIO = 10.0
"""Error over the larger of what was reported and what rounding of S allows."""
PROVEN = 1e-8
"""A natural residual, by local stiffness, that proves the solution beside which it is measured."""
SAME = 1e-3
"""S of a badly conditioned stiffness is wrong by more than the rounding of its entries; answers as near as this are the same."""


@dataclass(frozen=True)
class Judged:
    """What is known of one scene."""

    scene: Scene
    status: str
    wrong: str | None
    """In words; `None` for an answer that is right."""
    accuracy: float = np.nan
    error: float = np.nan
    rounding: float = np.nan
    """epsilon cond S."""
    n_multipliers: int = 0


def judge(program: Program, scene: Scene, folder: Path) -> Judged:
    """Run a scene and prove its answer."""
    text, path = folder / f"{scene.name}.toml", folder / f"{scene.name}.h5"
    text.write_text(scene.text)
    path.unlink(missing_ok=True)
    outcome = program.run("run", text, path, "--no-figures")
    if outcome.fault:
        return Judged(scene, "fault", outcome.fault)
    if not path.is_file():
        return Judged(scene, "refused", outcome.stderr[-300:])
    with open_run(path) as file:
        if "solve" not in file:
            return Judged(scene, "refused", outcome.stderr[-300:])
        status = str(read_enum(file["solve/status"]))
        dual, multiplier, accuracy = answer(file)
        wrong, error = f"{status}, exit code {outcome.code}", np.nan
        if status in SOLVED and outcome.code == 0:
            near = None if dual.motions.size else about(file, dual, multiplier)
            wrong, error = compared(dual, near, multiplier, accuracy)
            if wrong and near and error <= MOST_RATIO * reach(file, near):
                wrong = None
            wrong = wrong or same_sets(dual, multiplier)
    path.unlink()
    return Judged(scene, status, wrong, accuracy, error, dual.rounding, dual.rhs.size)


def answer(file: h5py.File) -> tuple[Dual, np.ndarray, float]:
    """The problem of a run file, its multipliers and their stated accuracy."""
    names = ("multiplier_normal", "multiplier_tangential")
    parts = [file["solve"][name][:].ravel() for name in names if name in file["solve"]]
    dual = Dual.read(file)
    return (
        dual,
        np.concatenate(parts)[: dual.rhs.size],
        float(file["solve/accuracy"][()]),
    )


def compared(
    dual: Dual, near: Dual | None, multiplier: np.ndarray, accuracy: float
) -> tuple[str | None, float]:
    """What is wrong with an answer, and its error: beside the solution of the problem about it, or of S and h."""
    exact = dual if near is None else near
    solution, residual = newton(exact, multiplier)
    whole = max(dual.size(solution), dual.strength(), np.finfo(float).tiny)
    error = dual.size(solution - multiplier) / whole
    rounding = ROUNDINGS * dual.rounding
    if residual > (max(PROVEN, rounding) if near is None else PROVEN):
        return f"no solution nearby: natural residual {residual:.1e}", error
    allowed = max(LEAST, accuracy, rounding if near is None else 0.0)
    if error > MOST_RATIO * allowed:
        return f"off by {error:.1e}, {allowed:.1e} is allowed", error
    return None, error


def reach(file: h5py.File, near: Dual) -> float:
    """How far the solution about an answer is from the one about itself: what extended precision can tell apart."""
    solution, _ = newton(near, near.anchor)
    again, residual = newton(about(file, near, solution), solution)
    whole = max(near.size(again), near.strength(), np.finfo(float).tiny)
    return near.size(again - solution) / whole if residual <= PROVEN else 0.0


def same_sets(dual: Dual, multiplier: np.ndarray) -> str | None:
    """Whether an active set method presses other panes; `None` where rounding of S may decide that."""
    found = by_active_sets(dual)
    if found is None:
        return None
    distance = dual.size(found - multiplier)
    whole = max(dual.size(found), np.finfo(float).tiny)
    if distance <= max(SAME, ROUNDINGS * dual.rounding) * whole:
        return None
    return f"off by {distance / whole:.1e} from the answer of active sets"
