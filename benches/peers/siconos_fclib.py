"""Siconos as a judge of exported problems: it reads their matrices, measures the error of our solution, and solves from zero.

    siconos_fclib.py --program target/release/contact3d-pipe

Each scene is solved by the program at a small size and exported. fc3d_compute_error must confirm the stored forces, and each
solver of Siconos that converges must find the same ones; uniqueness is not proved, so a solver that finds others is shown, not hidden.
"""

import argparse
import json
import subprocess
import tempfile
import time
from dataclasses import asdict, dataclass
from pathlib import Path

import numpy as np
import siconos.numerics as sn

from fclib_files import LocalProblem, natural_map_error, read_local, read_solution
from siconos_scene import with_long_indices

ROOT = Path(__file__).resolve().parent.parent.parent
PIPELINES = ROOT / "pipelines"

# One half with orthotropic friction, one without any.
HALVES = (
    'contact=[{face="z_min",name="dry",box=[[0.0,0.0,0.0],[1.0,1.0,0.0]],'
    "friction={coefficient_1={constant=0.6},coefficient_2={constant=0.4}}},"
    '{face="z_min",name="greased",box=[[1.5,0.0,0.0],[3.0,1.0,0.0]]}]'
)

SMALL = ["body.brick.cells=[12,4,4]"]
SCENES = {
    "HKL Table 1": ("newton.toml", SMALL),
    "constant, isotropic": (
        "newton.toml",
        [*SMALL, "friction={coefficient={constant=0.3}}"],
    ),
    "constant, orthotropic": (
        "newton.toml",
        [*SMALL, "friction={coefficient_1={constant=0.4},coefficient_2={constant=0.15}}"],
    ),
    "gap and turned axes": (
        "newton.toml",
        [*SMALL, "contact.gap=1e-5", "contact.axis_1=[1.0,2.0,0.0]"],
    ),
    "no friction": ("frictionless.toml", SMALL),
    "multipliers at nodes": ("newton.toml", [*SMALL, 'contact.multipliers="nodal"']),
    "quadratic": ("newton.toml", ["body.brick.cells=[6,2,2]", 'body.element="P2"']),
    "two faces, one greased": ("dry_and_greased.toml", ["body.brick.cells=[12,4,2]", HALVES]),
}
SOLVERS = {
    "NSN_AC": sn.SICONOS_FRICTION_3D_NSN_AC,
    "ADMM": sn.SICONOS_FRICTION_3D_ADMM,
    "NSGS": sn.SICONOS_FRICTION_3D_NSGS,
}
TOLERANCE = 1e-10
MAX_ITERATIONS = 20_000

# The stored forces are accurate to rounding, and the frozen law is that of the solution.
CONFIRMED = 1e-10
# Solved to 1e-10 by a solver that knows nothing of ours, on a W of condition about 1e3.
SAME = 1e-6


@dataclass(frozen=True)
class Attempt:
    """What a solver of Siconos came to."""

    solver: str
    converged: bool
    error: float
    seconds: float
    iterations: int
    distance: float


def siconos_problem(problem: LocalProblem, blocks: bool) -> sn.FrictionContactProblem:
    """The problem as Siconos takes it: W dense or by blocks of three."""
    if blocks:
        matrix = sn.SBM_from_csparse(3, with_long_indices(problem.matrix))[1]
    else:
        matrix = problem.matrix.toarray()
    return sn.FrictionContactProblem(3, matrix, problem.offset, problem.mu)


def siconos_error(problem: LocalProblem, force: np.ndarray) -> float:
    """fc3d_compute_error of some forces."""
    options = sn.SolverOptions(sn.SICONOS_FRICTION_3D_NSN_AC)
    size = np.linalg.norm(problem.offset)
    velocity = np.zeros_like(force)
    fc = siconos_problem(problem, blocks=False)
    return sn.fc3d_compute_error(fc, force.copy(), velocity, TOLERANCE, options, size)[1]


def solve(
    problem: LocalProblem, solver: str, answer: np.ndarray, tolerance: float = TOLERANCE, blocks: bool = False
) -> Attempt:
    """Solve from zero and compare with an answer."""
    options = sn.SolverOptions(SOLVERS[solver])
    options.dparam[sn.SICONOS_DPARAM_TOL] = tolerance
    options.iparam[sn.SICONOS_IPARAM_MAX_ITER] = MAX_ITERATIONS
    force, velocity = np.zeros_like(answer), np.zeros_like(answer)
    fc = siconos_problem(problem, blocks)
    started = time.perf_counter()
    info = sn.fc3d_driver(fc, force, velocity, options)
    seconds = time.perf_counter() - started
    distance = np.linalg.norm(force - answer) / max(np.linalg.norm(answer), 1e-300)
    return Attempt(
        solver,
        info == 0,
        float(natural_map_error(problem, force)),
        seconds,
        int(options.iparam[sn.SICONOS_IPARAM_ITER_DONE]),
        float(distance),
    )


def export(program: Path, scene: str, changes: list[str], folder: Path) -> Path:
    """Run a scene, export it, and solve the export by the program itself, too."""
    run, out = folder / "run.h5", folder / "problem.hdf5"
    settings = [part for change in changes for part in ("--set", change)]
    for command in (
        ["run", PIPELINES / scene, run, "--no-figures", *settings],
        ["export", run, "--fclib", out],
        ["solve-fclib", out],
    ):
        subprocess.run([program, "--quiet", *command], check=True, stdout=subprocess.DEVNULL)
    return out


def judge(program: Path, name: str) -> dict:
    """One scene: our error by Siconos and by ourselves, and what its solvers find."""
    scene, changes = SCENES[name]
    with tempfile.TemporaryDirectory() as folder:
        path = export(program, scene, changes, Path(folder))
        problem, (force, _) = read_local(path), read_solution(path)
    ours = natural_map_error(problem, force)
    theirs = siconos_error(problem, force)
    attempts = [solve(problem, solver, force) for solver in SOLVERS]
    print(f"{name}: {len(problem.mu)} contacts, our error {theirs:.1e} by Siconos, {ours:.1e} by ourselves")
    for a in attempts:
        state = "converged" if a.converged else "NOT CONVERGED"
        print(
            f"    {a.solver:<7} {state:<13} error {a.error:.1e}, distance {a.distance:.1e}, "
            f"{a.iterations} iterations, {a.seconds:.3f} s"
        )
    return {
        "scene": name,
        "contacts": len(problem.mu),
        "error_by_siconos": theirs,
        "error": ours,
        "attempts": [asdict(a) for a in attempts],
        "confirmed": theirs <= CONFIRMED,
        "same": any(a.converged and a.distance <= SAME for a in attempts),
    }


def main() -> None:
    """Judge all scenes; fail where Siconos does not confirm one."""
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    default = ROOT / "target" / "release" / "contact3d-pipe"
    parser.add_argument("--program", type=Path, default=default)
    parser.add_argument("--scenes", nargs="*", default=list(SCENES), choices=list(SCENES))
    parser.add_argument("--json", type=Path)
    arguments = parser.parse_args()
    results = [judge(arguments.program, name) for name in arguments.scenes]
    if arguments.json:
        arguments.json.write_text(json.dumps(results, indent=1))
    bad = [r["scene"] for r in results if not (r["confirmed"] and r["same"])]
    if bad:
        raise SystemExit(f"not confirmed: {', '.join(bad)}")
    print(f"{len(results)} scenes confirmed")


if __name__ == "__main__":
    main()
