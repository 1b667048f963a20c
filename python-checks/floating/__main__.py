"""Solves random bodies that contact alone holds, and holds every verdict against other algorithms.

* What converged satisfies the conditions of contact, friction and balance, recomputed from A, B, l and the gap.
* What has no equilibrium has none for friction polygons around the ellipses either, by a linear programme.
* What was not solved has no solution that softer and softer springs with block Gauss-Seidel lead to.
"""

import os
import sys
import tempfile
from collections import Counter
from pathlib import Path

os.environ.setdefault("OPENBLAS_NUM_THREADS", "1")

if __package__ in (None, ""):
    # Run as a folder: the folder's parent holds this package and the readers it uses.
    sys.path[0] = str(Path(__file__).resolve().parent.parent)

from campaign import arguments, require

require("blake3", "h5py", "numpy", "scipy")

import numpy as np

from faults.program import Program
from floating.bodies import Body, body
from floating.raw import SIDES, Floating
from floating.reference import solution
from run_file import open_run, read_enum

SOLVED = ("converged", "machine_precision", "reduced_accuracy")
ACCURATE = 1e-6
"""Of an answer's conditions, in units of the panes' mean stiffness; right answers stay below 1e-9."""


def verdict(program: Program, one: Body, folder: Path) -> tuple[str, str | None]:
    """How the solve of a body ended, and what is wrong with that."""
    scene, file = folder / "body.toml", folder / "body.h5"
    scene.write_text(one.text)
    file.unlink(missing_ok=True)
    outcome = program.run("run", scene, file, "--no-figures")
    if outcome.fault or outcome.code not in (0, 1):
        return "fault", outcome.fault or outcome.stderr[-300:]
    with open_run(file) as run:
        status = str(read_enum(run["solve/status"]))
        problem = Floating.read(run, one.coefficients)
        parts = [run[f"solve/multiplier_{n}"][:].ravel() for n in ("normal", "tangential") if f"multiplier_{n}" in run["solve"]]
        error = problem.error_of_file(run, np.concatenate(parts))
    return status, wrong(problem, status, error)


def wrong(problem: Floating, status: str, error: float) -> str | None:
    """What contradicts the status of an answer that is off by `error`; None if nothing does."""
    if status in SOLVED:
        return None if error < ACCURATE else f"{status}, but the conditions are off by {error:.1e}"
    if status == "no_equilibrium":
        # Corners on the ellipses: what such forces balance, the law's do.
        held = problem.can_be_held(1.0)
        return "no_equilibrium, but a linear programme finds forces in balance" if held else None
    if not problem.can_be_held(1.0 / np.cos(np.pi / SIDES)):
        return None
    return None if solution(problem) is None else f"{status}, but there is a solution"


def main() -> int:
    """Judge bodies and print the counts; 1 if anything is wrong."""
    parser = arguments("floating", __doc__)
    parser.add_argument("--bodies", type=int, default=600, help="number of bodies")
    parser.add_argument("--first", type=int, default=0, help="number of the first one")
    parser.add_argument("--write", type=Path, help="write the scene of --first to a file, and do no more")
    chosen = parser.parse_args()
    if chosen.write:
        chosen.write.write_text(body(chosen.seed, chosen.first).text)
        return 0
    program = Program.find(chosen.program)
    counts, faults = Counter(), 0
    with tempfile.TemporaryDirectory() as folder:
        for number in range(chosen.first, chosen.first + chosen.bodies):
            status, fault = verdict(program, body(chosen.seed, number), Path(folder))
            counts[status] += 1
            if fault:
                faults += 1
                print(f"body {number}: {fault}", flush=True)
    print(", ".join(f"{count} {status}" for status, count in counts.most_common()))
    print(f"{faults} wrong of {chosen.bodies}")
    return int(faults > 0)


if __name__ == "__main__":
    sys.exit(main())
