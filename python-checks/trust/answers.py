"""What the program says of a scene: its answers at several accuracies and by several methods."""

import json
import time
from dataclasses import dataclass
from pathlib import Path

import h5py
import numpy as np

from faults.program import Outcome, Program
from run_file import open_run, read_enum

DEFAULT_EPSILON = 1e-12
SOLVED = ("converged", "machine_precision")


@dataclass(frozen=True)
class Answer:
    """One solve."""

    asked: str
    epsilon: float
    code: int | None
    status: str
    accuracy: float
    newton_steps: int
    outer_steps: int
    multiplier: np.ndarray | None
    seconds: float
    fault: str | None = None

    @property
    def claims(self) -> bool:
        """Whether it says that it is a solution."""
        return self.code == 0 or self.status in SOLVED


def answer_of(
    file: h5py.File, asked: str, epsilon: float, outcome: Outcome, begun: float
) -> Answer:
    """The answer that a run file holds after a solve."""
    solve = file["solve"]
    parts = [solve["multiplier_normal"][:], solve["multiplier_tangential"][:].ravel()]
    said = said_by(outcome)
    return Answer(
        asked=asked,
        epsilon=epsilon,
        code=outcome.code,
        status=str(read_enum(solve["status"])),
        accuracy=float(said.get("accuracy", solve["accuracy"][()])),
        newton_steps=solve["newton/residual"].size if "newton" in solve else 0,
        outer_steps=solve["history/change"].size if "history" in solve else 0,
        multiplier=np.concatenate(parts),
        seconds=time.monotonic() - begun,
        fault=outcome.fault,
    )


def said_by(outcome: Outcome) -> dict:
    """What it printed for programs, if it did."""
    try:
        return outcome.json
    except json.JSONDecodeError:
        return {}


def solved(
    program: Program, command: list, run_file: Path, asked: str, epsilon: float
) -> Answer:
    """Give one command and read its answer."""
    begun = time.monotonic()
    outcome = program.run(*command, "--json")
    if outcome.code in (0, 1) and run_file.is_file():
        with open_run(run_file) as file:
            if "solve" in file:
                return answer_of(file, asked, epsilon, outcome, begun)
    seconds = time.monotonic() - begun
    fault = (
        outcome.fault or f"{asked}: ended with {outcome.code}: {outcome.stderr[-300:]}"
    )
    return Answer(
        asked, epsilon, outcome.code, "none", np.nan, 0, 0, None, seconds, fault
    )


def default_answer(program: Program, scene: Path, run_file: Path) -> Answer:
    """The answer of `run` without any settings."""
    command = ["run", scene, run_file, "--no-figures"]
    return solved(program, command, run_file, "default", DEFAULT_EPSILON)


def answer_at(program: Program, run_file: Path, epsilon: float) -> Answer:
    """The answer at another accuracy, on the operator that the file holds."""
    command = ["solve", run_file, "--set", f"solve.epsilon={epsilon}"]
    return solved(program, command, run_file, f"epsilon {epsilon:.0e}", epsilon)


BY_FIXED_POINT = ('--set=solve.method="fixed-point"',)
METHODS = {
    "fixed point, Newton": (*BY_FIXED_POINT, '--set=solve.inner="newton"'),
    "fixed point, GPCG": (*BY_FIXED_POINT, '--set=solve.inner="gpcg"'),
    "fixed point, KPRGP": (*BY_FIXED_POINT, '--set=solve.inner="kprgp"'),
}


LIMITS = ("--set=solve.max_outer_steps=100", "--set=solve.max_operator_applications=50000")
"""The slow methods may give up; what they call solved is judged."""


def answer_by(program: Program, run_file: Path, method: str, epsilon: float) -> Answer:
    """The answer of another method."""
    command = ["solve", run_file, *METHODS[method], *LIMITS, f"--set=solve.epsilon={epsilon}"]
    return solved(program, command, run_file, method, epsilon)
