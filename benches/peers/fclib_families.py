"""Generated families of local problems: solve-fclib against solvers of Siconos.

    fclib_families.py --program target/release/contact3d-pipe

Families: a tower of cubes on four contacts each (sparse W, singular: twelve forces on six degrees of freedom), a wall of such cubes
in bond, one cube on many contacts (W dense, of rank six), and elastic points (W of full rank, dense). Every solver gets the same file,
starts from zero, and is held to the same tolerance; errors are computed here.
"""

import argparse
import json
import subprocess
import tempfile
import time
from pathlib import Path

import numpy as np
from scipy import sparse

from fclib_files import LocalProblem, natural_map_error, read_solution, write_local
from siconos_fclib import ROOT, SOLVERS, solve

TOLERANCE = 1e-8


def frame(arm: np.ndarray) -> np.ndarray:
    """Velocities along N = z, T1 = x, T2 = y at a point of a body for its twist (v, omega), [3, 6]."""
    x, y, z = arm
    spin = np.array([[0, z, -y], [-z, 0, x], [y, -x, 0]])
    return np.hstack([np.eye(3), spin])[[2, 0, 1]]


def assemble(
    n_bodies: int,
    contacts: list[tuple[int, np.ndarray, int, np.ndarray]],
    free: np.ndarray,
    mu: float,
) -> LocalProblem:
    """W = H' M^-1 H and q = H' v for cubes of mass 1 and side 1; body -1 is the ground."""
    rows = []
    for upper, arm, lower, other in contacts:
        row = sparse.lil_matrix((3, 6 * n_bodies))
        row[:, 6 * upper : 6 * upper + 6] = frame(arm)
        if lower >= 0:
            row[:, 6 * lower : 6 * lower + 6] = -frame(other)
        rows.append(row.tocsr())
    h = sparse.vstack(rows).tocsr()
    inverse = sparse.diags(np.tile([1.0, 1.0, 1.0, 6.0, 6.0, 6.0], n_bodies))
    w = h @ inverse @ h.T
    return LocalProblem(sparse.csc_matrix((w + w.T) / 2), h @ free, np.full(len(contacts), mu))


CORNERS = [np.array([x, y, -0.5]) for x in (-0.5, 0.5) for y in (-0.5, 0.5)]
UP = np.array([0.0, 0.0, 1.0])


def tower(n: int, mu: float = 0.5) -> LocalProblem:
    """n cubes on each other under their weight, each pushed a little aside."""
    contacts = [(k, c, k - 1, c + UP) for k in range(n) for c in CORNERS]
    free = np.zeros(6 * n)
    free[2::6], free[0::6] = -1.0, 0.05
    return assemble(n, contacts, free, mu)


def wall(height: int, width: int, mu: float = 0.5) -> LocalProblem:
    """Courses of cubes, each moved by half a cube: every cube stands on the halves of two."""
    contacts = []
    for level in range(height):
        for k in range(width):
            at = level * width + k
            shift = 0.5 if level % 2 else -0.5
            for side in (-1, 1):
                below = k + (side + (1 if level % 2 else -1)) // 2
                if level == 0:
                    below_at, step = -1, 0.0
                elif 0 <= below < width:
                    below_at, step = at - k - width + below, below - k - shift
                else:
                    continue
                for x, y in ((0.1, -0.5), (0.1, 0.5), (0.5, -0.5), (0.5, 0.5)):
                    arm = np.array([side * x, y, -0.5])
                    other = arm + UP - np.array([step, 0.0, 0.0])
                    contacts.append((at, arm, below_at, other))
    free = np.zeros(6 * height * width)
    free[2::6], free[1::6] = -1.0, 0.1
    return assemble(height * width, contacts, free, mu)


def cube(side: int, mu: float = 0.5) -> LocalProblem:
    """One cube on side x side contacts, pushed near the limit of friction."""
    at = np.linspace(-0.5, 0.5, side)
    contacts = [(0, np.array([x, y, -0.5]), -1, np.zeros(3)) for x in at for y in at]
    return assemble(1, contacts, np.array([0.3, 0.1, -1.0, 0.0, 0.0, 0.2]), mu)


def elastic(side: int, mu: float = 0.4) -> LocalProblem:
    """Points of an elastic half-space, 1/distance with a finite value at the point, isotropic in the components."""
    at = np.arange(side, dtype=float)
    points = np.array([(x, y) for x in at for y in at])
    distance = np.linalg.norm(points[:, None] - points[None], axis=2)
    green = 1.0 / np.sqrt(distance**2 + 0.15)
    w = np.kron(green, np.diag([1.0, 1.2, 1.2]))
    hill = np.sum((points - points.mean(0)) ** 2, axis=1) / side
    q = np.zeros((side * side, 3))
    q[:, 0], q[:, 1] = hill - side / 4, 0.4 * side
    return LocalProblem(sparse.csc_matrix(w), q.ravel(), np.full(side * side, mu))


FAMILIES = {
    "tower": ("cubes", tower, [5, 20, 50]),
    "wall": ("courses of 10", lambda n: wall(n, 10), [2, 5, 10]),
    "cube on many contacts": ("contacts a side", cube, [5, 12, 20]),
    "elastic half-space": ("contacts a side", elastic, [8, 16, 22]),
    "large half-space": ("contacts a side", elastic, [40]),
    "large wall": ("courses of 20", lambda n: wall(n, 20), [16]),
}


def ours(program: Path, path: Path, method: str, limit: float) -> dict:
    """solve-fclib with the whole process in the time."""
    out = path.with_suffix(".solved.hdf5")
    command = [program, "--json", "--threads", "1", "solve-fclib", path, "--out", out]
    command += ["--method", method, "--tolerance", str(TOLERANCE)]
    started = time.perf_counter()
    try:
        done = subprocess.run(command, capture_output=True, text=True, timeout=limit, check=False)
    except subprocess.TimeoutExpired:
        return {"solver": f"ours, {method}", "converged": False, "seconds": limit, "error": None}
    seconds = time.perf_counter() - started
    if done.returncode == 2:
        raise SystemExit(done.stderr)
    answer = json.loads(done.stdout)
    return {
        "solver": f"ours, {method}",
        "converged": done.returncode == 0,
        "seconds": seconds,
        "solve_seconds": answer["seconds"],
        "steps": answer["newton_steps"] or answer["outer_steps"],
        "out": out,
    }


def main() -> None:
    """Print a table; a solver that does not converge is part of it."""
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    default = ROOT / "target" / "release" / "contact3d-pipe"
    parser.add_argument("--program", type=Path, default=default)
    parser.add_argument("--families", nargs="*", default=list(FAMILIES), choices=list(FAMILIES))
    parser.add_argument("--solvers", nargs="*", default=list(SOLVERS), choices=list(SOLVERS))
    parser.add_argument("--limit", type=float, default=120.0, help="seconds for one of our solves")
    parser.add_argument("--json", type=Path)
    arguments = parser.parse_args()
    records = []
    for family in arguments.families:
        word, make, sizes = FAMILIES[family]
        for size in sizes:
            problem = make(size)
            zero = np.zeros_like(problem.offset)
            rows = []
            with tempfile.TemporaryDirectory() as folder:
                path = Path(folder) / "problem.hdf5"
                write_local(path, problem, f"{family} {size}")
                for method in ("auto", "newton", "gpcg", "nsgs"):
                    row = ours(arguments.program, path, method, arguments.limit)
                    if out := row.pop("out", None):
                        row["error"] = natural_map_error(problem, read_solution(out)[0])
                    rows.append(row)
            for solver in arguments.solvers:
                a = solve(problem, solver, zero, TOLERANCE, blocks="half-space" not in family)
                rows.append(
                    {
                        "solver": solver,
                        "converged": a.converged and a.error <= 10 * TOLERANCE,
                        "seconds": a.seconds,
                        "steps": a.iterations,
                        "error": a.error,
                    }
                )
            density = problem.matrix.nnz / problem.matrix.shape[0] ** 2
            print(f"{family}, {size} {word}: {len(problem.mu)} contacts, {100 * density:.2g} % of W", flush=True)
            for row in rows:
                state = "" if row["converged"] else "NOT CONVERGED"
                error = row.get("error")
                shown = "-" if error is None else f"{error:.1e}"
                print(
                    f"    {row['solver']:<12} {row['seconds']:8.3f} s  "
                    f"{row.get('steps', '-'):>7} steps  error {shown} {state}",
                    flush=True,
                )
            records.append({"family": family, "size": size, "contacts": len(problem.mu), "rows": rows})
    if arguments.json:
        arguments.json.write_text(json.dumps(records, indent=1))


if __name__ == "__main__":
    main()
