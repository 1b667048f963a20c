"""Random frictional contact problems for solve-fclib, made with a solution or with a proof that there is none.

    python3 python-checks/random_contacts.py --count 100

W = H'H. With a solution: every contact is open, sticks or slides, and q = u - W r. Without: H p = 0 and q.p < 0 for a direction p of
pressed contacts, so u_N >= 0 nowhere holds, whatever the forces. What the program claims is measured anew in extended precision.
"""

import argparse
import json
import os
import subprocess
import sys
import tempfile
from collections import Counter
from collections.abc import Callable, Iterator
from dataclasses import dataclass
from pathlib import Path

import h5py
import numpy as np

TOLERANCE = 1e-10
# Rounding of norms in another order, and of a scale that need not be a power of two: those of the program are within sqrt(2) of ours.
SLACK = 2.0
# Scaled W p of a direction that proves something, over its work; the program asks for 1e10.
PROOF = 1e9


@dataclass(frozen=True)
class Problem:
    """u = W r + q with Coulomb's law, rows N, T1, T2, and whether it has a solution."""

    w: np.ndarray
    q: np.ndarray
    mu: np.ndarray
    solvable: bool


def coefficients(rng: np.random.Generator, n: int) -> np.ndarray:
    """From none to ten, some contacts without friction."""
    return np.where(rng.random(n) < 0.15, 0.0, 10.0 ** rng.uniform(-1.5, 1.0, n))


def known(rng: np.random.Generator, mu: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    """r and u of contacts that are open, stick or slide."""
    r, u = np.zeros((2, len(mu), 3))
    for k, own in enumerate(mu):
        angle = rng.uniform(0.0, 2.0 * np.pi)
        along = np.array([np.cos(angle), np.sin(angle)])
        state = rng.choice(["open", "stick", "slide"])
        if state == "open":
            u[k] = [rng.exponential(), *rng.normal(size=2)]
            continue
        r[k, 0] = rng.exponential()
        if state == "stick" and own > 0.0:
            r[k, 1:] = 0.95 * rng.random() * own * r[k, 0] * along
        else:
            r[k, 1:], u[k, 1:] = -own * r[k, 0] * along, rng.exponential() * along
    return r.ravel(), u.ravel()


def with_solution(rng: np.random.Generator, h: np.ndarray, mu: np.ndarray, own_units: bool) -> Problem:
    """The problem of a known solution, each contact in units of its own if asked for."""
    w = h.T @ h
    r, u = known(rng, mu)
    scale = np.repeat(10.0 ** rng.uniform(-2.0, 2.0, len(mu)), 3) if own_units else np.ones(len(r))
    w, r, u = scale[:, None] * w * scale, r / scale, u * scale
    w = 0.5 * (w + w.T)
    return Problem(w, u - w @ r, mu, True)


def without_solution(rng: np.random.Generator, h: np.ndarray, mu: np.ndarray, own_units: bool) -> Problem:
    """Some pressed contacts between bodies that do not move apart."""
    n = len(mu)
    p = np.zeros((n, 3))
    pressed = rng.permutation(n)[: rng.integers(1, n + 1)]
    p[pressed, 0] = 0.1 + rng.exponential(size=len(pressed))
    p = p.ravel()
    h = h - np.outer(h @ p, p) / (p @ p)
    q = rng.normal(size=3 * n)
    q -= p * (q @ p + rng.exponential() * np.linalg.norm(p)) / (p @ p)
    scale = np.repeat(10.0 ** rng.uniform(-2.0, 2.0, n), 3) if own_units else np.ones(3 * n)
    w = scale[:, None] * (h.T @ h) * scale
    return Problem(0.5 * (w + w.T), scale * q, mu, False)


def point(arm: np.ndarray, normal: np.ndarray) -> np.ndarray:
    """Velocities along N, T1, T2 at a point of a body for its twist (v, omega), [3, 6]."""
    first = np.cross(normal, [0.0, 0.0, 1.0] if abs(normal[2]) < 0.9 else [1.0, 0.0, 0.0])
    first /= np.linalg.norm(first)
    x, y, z = arm
    spin = np.array([[0.0, z, -y], [-z, 0.0, x], [y, -x, 0.0]])
    return np.array([normal, first, np.cross(normal, first)]) @ np.hstack([np.eye(3), spin])


# M^-1/2 of a cube of mass 1 and side 1.
INVERSE_ROOT = np.sqrt([1.0, 1.0, 1.0, 6.0, 6.0, 6.0])
CORNERS = [np.array([x, y, -0.5]) for x in (-0.5, 0.5) for y in (-0.5, 0.5)]
UP = np.array([0.0, 0.0, 1.0])


def stack(places: list[np.ndarray]) -> np.ndarray:
    """H of cubes at some places that rest on the ground and on each other, four points for each pair that overlaps."""
    columns = []
    for upper, place in enumerate(places):
        if place[2] == 0.5:
            below = [(-1, place - UP)]
        else:
            others = enumerate(places)
            below = [(k, o) for k, o in others if np.allclose(o[2] + 1.0, place[2]) and np.all(abs(o - place)[:2] < 1.0)]
        for lower, other in below:
            low, high = np.maximum(place, other) - 0.5, np.minimum(place, other) + 0.5
            for x in (low[0], high[0]):
                for y in (low[1], high[1]):
                    at = np.array([x, y, place[2] - 0.5])
                    column = np.zeros((3, 6 * len(places)))
                    column[:, 6 * upper : 6 * upper + 6] = point(at - place, UP) * INVERSE_ROOT
                    if lower >= 0:
                        column[:, 6 * lower : 6 * lower + 6] = -point(at - other, UP) * INVERSE_ROOT
                    columns.append(column)
    return np.vstack(columns).T


def tower(rng: np.random.Generator) -> np.ndarray:
    """Cubes on each other."""
    return stack([np.array([0.0, 0.0, 0.5 + k]) for k in range(rng.integers(1, 13))])


def wall(rng: np.random.Generator) -> np.ndarray:
    """Courses of cubes in bond."""
    height, width = rng.integers(1, 4), rng.integers(1, 5)
    return stack([np.array([k + 0.5 * (level % 2), 0.0, 0.5 + level]) for level in range(height) for k in range(width)])


def squeezed(rng: np.random.Generator) -> tuple[np.ndarray, np.ndarray]:
    """A cube between two walls and on the ground; H, and which contacts the walls have."""
    columns, walls = [], []
    for normal in (UP, np.array([1.0, 0.0, 0.0]), np.array([-1.0, 0.0, 0.0])):
        across = [e for e in np.eye(3) if abs(e @ normal) < 0.5]
        for _ in range(rng.integers(3, 6)):
            a, b = rng.uniform(-0.5, 0.5, 2)
            columns.append(point(-0.5 * normal + a * across[0] + b * across[1], normal) * INVERSE_ROOT)
            walls.append(normal[2] == 0.0)
    return np.vstack(columns).T, np.array(walls)


def closing(rng: np.random.Generator) -> Problem:
    """A cube that two walls with contacts all over their faces close upon, faster than it can give way."""
    corners = [(a, b) for a in (-0.5, 0.5) for b in (-0.5, 0.5)]
    columns, offset = [], []
    for side in (-1.0, 1.0):
        normal = np.array([-side, 0.0, 0.0])
        speed = rng.uniform(0.1, 1.0)
        for a, b in corners:
            columns.append(point(np.array([0.5 * side, a, b]), normal) * INVERSE_ROOT)
            offset += [-speed, *rng.normal(size=2)]
    h = np.vstack(columns).T
    return Problem(h.T @ h, np.array(offset), coefficients(rng, len(columns)), False)


def dense(rng: np.random.Generator, deficient: bool) -> tuple[np.ndarray, np.ndarray]:
    """H of random numbers, with fewer rows than columns if W is to be singular, and coefficients."""
    n = rng.integers(1, 25)
    rows = rng.integers(1, 3 * n) if deficient else 3 * n
    return rng.normal(size=(rows, 3 * n)) / np.sqrt(rows), coefficients(rng, n)


def of_bodies(make: Callable, solution: bool) -> Callable[[np.random.Generator], Problem]:
    """A problem on the W of bodies."""

    def problem(rng: np.random.Generator) -> Problem:
        h = make(rng)
        build = with_solution if solution else without_solution
        return build(rng, h, coefficients(rng, h.shape[1] // 3), False)

    return problem


FAMILIES: dict[str, Callable[[np.random.Generator], Problem]] = {
    "regular W": lambda rng: with_solution(rng, *dense(rng, False), False),
    "singular W": lambda rng: with_solution(rng, *dense(rng, True), False),
    "singular W, own units": lambda rng: with_solution(rng, *dense(rng, True), True),
    "tower": of_bodies(tower, True),
    "wall": of_bodies(wall, True),
    "squeezed cube": of_bodies(lambda rng: squeezed(rng)[0], True),
    "no solution": lambda rng: without_solution(rng, *dense(rng, True), False),
    "no solution, own units": lambda rng: without_solution(rng, *dense(rng, True), True),
    "no solution, wall": of_bodies(wall, False),
    "closing walls": closing,
}


def write(path: Path, problem: Problem) -> None:
    """A file with the problem, W by compressed columns."""
    n = len(problem.q)
    with h5py.File(path, "w") as file:
        group = file.create_group("fclib_local")
        w = group.create_group("W")
        whole = {"nzmax": [n * n], "m": [n], "n": [n], "nz": [-1], "p": n * np.arange(n + 1), "i": np.tile(np.arange(n), n)}
        for name, values in whole.items():
            w[name] = np.array(values, dtype=np.int32)
        w["x"] = problem.w.T.ravel()
        group["spacedim"] = np.array([3], dtype=np.int32)
        group["vectors/q"], group["vectors/mu"] = problem.q, problem.mu


def unit_diagonal(problem: Problem) -> np.ndarray:
    """Scale of each component by which the contacts of W have diagonals of one, with friction in it."""
    diagonal = problem.w.diagonal().reshape(-1, 3)
    weights = np.column_stack([np.ones(len(problem.mu)), problem.mu**2, problem.mu**2])
    mean = (diagonal * weights).sum(axis=1) / np.where(problem.mu > 0.0, 3.0, 1.0)
    whole = diagonal.mean(axis=1)
    mean = np.where(mean > 1e-12 * whole, mean, whole)
    return np.repeat(np.where(mean > 0.0, 1.0 / np.sqrt(np.where(mean > 0.0, mean, 1.0)), 1.0), 3)


def project(z: np.ndarray, mu: np.ndarray) -> np.ndarray:
    """Nearest points of the cones |z_T| <= mu z_N."""
    slope = np.hypot(z[:, 1], z[:, 2])
    along = np.maximum(z[:, 0] + mu * slope, 0.0) / (1.0 + mu**2)
    turn = np.divide(mu * along, slope, out=np.zeros_like(slope), where=slope > 0.0)
    nearest = np.column_stack([along, turn * z[:, 1], turn * z[:, 2]])
    return np.where((slope <= mu * z[:, 0])[:, None], z, nearest)


def violation(problem: Problem, force: np.ndarray) -> float:
    """How far forces violate the law, over |q|, contacts scaled to unit diagonals, in extended precision."""
    scale = unit_diagonal(problem).astype(np.longdouble)
    q = problem.q * scale
    if not q.any():
        return float(abs(force).max(initial=0.0))
    r = (force / scale).reshape(-1, 3)
    u = ((problem.w.astype(np.longdouble) @ force + problem.q) * scale).reshape(-1, 3)
    penetration = np.minimum(u[:, 0], 0.0)
    u[:, 0] += problem.mu * np.hypot(u[:, 1], u[:, 2])
    nearest = project(r - u, problem.mu.astype(np.longdouble))
    forms = [r - nearest, u - ((u - r) + nearest), penetration]
    return float(max(map(np.linalg.norm, forms)) / np.linalg.norm(q))


def proves(problem: Problem, direction: np.ndarray) -> bool:
    """Whether a direction shows that no forces keep the contacts from penetrating."""
    p = direction.reshape(-1, 3)
    if p[:, 1:].any() or (p[:, 0] < 0.0).any():
        return False
    scale = unit_diagonal(problem).astype(np.longdouble)
    moved = (problem.w.astype(np.longdouble) @ direction) * scale
    work = -(problem.q.astype(np.longdouble) @ direction) / np.linalg.norm(problem.q * scale)
    return bool(work > 0.0 and work >= PROOF * np.linalg.norm(moved))


def judge(program: Path, problem: Problem, folder: Path) -> tuple[str, str | None]:
    """The status of a solve, and what is wrong about it."""
    given, out = folder / "given.hdf5", folder / "out.hdf5"
    write(given, problem)
    command = [program, "--json", "--threads", "1", "solve-fclib", given, "--out", out]
    done = subprocess.run(command, capture_output=True, text=True, check=False)
    if done.returncode not in (0, 1):
        return "failed", f"exit code {done.returncode}: {done.stderr}"
    answer = json.loads(done.stdout)
    status, obstruction = answer["status"], answer["obstruction"] or {"kind": None}
    with h5py.File(out) as file:
        error = violation(problem, file["solution/r"][:])
        stored = file["solution/obstruction"][:] if "solution/obstruction" in file else None
    wrong = None
    if (done.returncode == 0) != (status == "converged"):
        wrong = f"exit code {done.returncode}"
    elif (stored is None) != (obstruction["kind"] is None) or (stored is not None and stored.tolist() != obstruction["direction"]):
        wrong = "the direction stored is not the one printed"
    elif status == "converged" and not error <= SLACK * TOLERANCE:
        wrong = f"converged with an error of {error:.1e}"
    elif problem.solvable and status != "converged":
        wrong = f"not solved, error {error:.1e}"
    elif not problem.solvable and status == "converged":
        wrong = "converged without a solution"
    elif status == "no_solution" and not proves(problem, stored):
        wrong = "a proof that is none"
    return status, wrong


def run(program: Path, count: int, seed: int, folder: Path) -> Iterator[tuple[str, Counter, list[str]]]:
    """Each family with what came of its problems, and what is wrong."""
    for number, (name, make) in enumerate(FAMILIES.items()):
        statuses, wrong = Counter(), []
        for k in range(count):
            problem = make(np.random.default_rng([seed, number, k]))
            status, problems = judge(program, problem, folder)
            statuses[status] += 1
            if problems:
                wrong.append(f"{name} {k}: {problems}")
        yield name, statuses, wrong


def main() -> int:
    """Print a table; the exit code tells whether anything is wrong."""
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    default = Path(__file__).resolve().parent.parent / "target/release/contact3d-pipe"
    parser.add_argument("--program", type=Path, default=os.environ.get("CONTACT3D_PIPE", default))
    parser.add_argument("--count", type=int, default=100, help="problems of each family")
    parser.add_argument("--seed", type=int, default=1)
    chosen = parser.parse_args()
    everything = []
    with tempfile.TemporaryDirectory() as folder:
        for name, statuses, wrong in run(chosen.program, chosen.count, chosen.seed, Path(folder)):
            told = ", ".join(f"{count} {status}" for status, count in sorted(statuses.items()))
            print(f"{name:24} {told}", flush=True)
            everything += wrong
    print("\n".join(everything) or "nothing is wrong")
    return int(bool(everything))


if __name__ == "__main__":
    sys.exit(main())
