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

import h5py
import numpy as np
import siconos.numerics as sn
from scipy import sparse


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
class LocalProblem:
    """u = W r + q, components N, T1, T2 contact after contact, Coulomb's law with mu."""

    matrix: sparse.csc_matrix
    offset: np.ndarray
    mu: np.ndarray


@dataclass(frozen=True)
class Attempt:
    """What a solver of Siconos came to."""

    solver: str
    converged: bool
    error: float
    seconds: float
    iterations: int
    distance: float


def read(path: Path) -> tuple[LocalProblem, np.ndarray]:
    """The problem of a file with W by columns, and r of its solution."""
    with h5py.File(path) as file:
        local = file["fclib_local"]
        shape = (int(local["W/m"][0]), int(local["W/n"][0]))
        matrix = sparse.csc_matrix(tuple(local[f"W/{name}"][:] for name in "xip"), shape)
        problem = LocalProblem(matrix, local["vectors/q"][:], local["vectors/mu"][:])
        return problem, file["solution/r"][:]


def cone_projection(points: np.ndarray, mu: np.ndarray) -> np.ndarray:
    """The nearest points of the cones |x_T| <= mu x_N, rows N, T1, T2."""
    normal, tangential = points[:, 0], np.hypot(points[:, 1], points[:, 2])
    height = (normal + mu * tangential) / (1.0 + mu**2)
    with np.errstate(invalid="ignore", divide="ignore"):
        share = mu * height / tangential
    surface = np.column_stack([height, points[:, 1] * share, points[:, 2] * share])
    inside = (tangential <= mu * normal)[:, None]
    polar = (mu * tangential <= -normal)[:, None]
    return np.where(polar, 0.0, np.where(inside, points, surface))


def natural_map_error(problem: LocalProblem, force: np.ndarray) -> float:
    """|r - P(r - u^)| / max(|q|, |r|, |u|) with u^ = u + (mu |u_T|, 0, 0), as Siconos 4.4 has it."""
    u = (problem.matrix @ force + problem.offset).reshape(-1, 3)
    r = force.reshape(-1, 3)
    size = max(map(np.linalg.norm, (problem.offset, r, u)))
    u[:, 0] += problem.mu * np.hypot(u[:, 1], u[:, 2])
    residual = np.linalg.norm(r - cone_projection(r - u, problem.mu))
    return residual / size if size > 0.0 else residual


def siconos_problem(problem: LocalProblem) -> sn.FrictionContactProblem:
    """The problem as Siconos takes it, W dense."""
    return sn.FrictionContactProblem(3, problem.matrix.toarray(), problem.offset, problem.mu)


def siconos_error(problem: LocalProblem, force: np.ndarray) -> float:
    """fc3d_compute_error of some forces."""
    options = sn.SolverOptions(sn.SICONOS_FRICTION_3D_NSN_AC)
    size = np.linalg.norm(problem.offset)
    velocity = np.zeros_like(force)
    fc = siconos_problem(problem)
    return sn.fc3d_compute_error(fc, force.copy(), velocity, TOLERANCE, options, size)[1]


def solve(problem: LocalProblem, solver: str, answer: np.ndarray) -> Attempt:
    """Solve from zero and compare with an answer."""
    options = sn.SolverOptions(SOLVERS[solver])
    options.dparam[sn.SICONOS_DPARAM_TOL] = TOLERANCE
    options.iparam[sn.SICONOS_IPARAM_MAX_ITER] = MAX_ITERATIONS
    force, velocity = np.zeros_like(answer), np.zeros_like(answer)
    fc = siconos_problem(problem)
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
    """Run a scene and export it."""
    run, out = folder / "run.h5", folder / "problem.hdf5"
    settings = [part for change in changes for part in ("--set", change)]
    for command in (
        ["run", PIPELINES / scene, run, "--no-figures", *settings],
        ["export", run, out, "--kind", "fclib"],
    ):
        subprocess.run([program, "--quiet", *command], check=True, stdout=subprocess.DEVNULL)
    return out


def judge(program: Path, name: str) -> dict:
    """One scene: our error by Siconos and by ourselves, and what its solvers find."""
    scene, changes = SCENES[name]
    with tempfile.TemporaryDirectory() as folder:
        path = export(program, scene, changes, Path(folder))
        problem, force = read(path)
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
