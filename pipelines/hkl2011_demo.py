#!/usr/bin/env python3
"""What accuracy costs in time, on the published problem of HKL 2011, Table 1.

    python3 pipelines/hkl2011_demo.py FOLDER [--n-div 16]

Solves it by the paper's Algorithm 4.1 with its precision controls (a) and (b), by the same fixed point with Newton's
method inside, and by Newton's method for all unknowns at once. The last comes first, with its pictures, and the errors
of the others are distances to it. FOLDER gets table1.h5 and its pictures. Needs h5py.
"""

import argparse
import pathlib
import subprocess
import tempfile

import h5py
import numpy as np
from hkl2011_tables import HERE, PROGRAM, PUBLISHED, run

TABLE_1, NEWTON = "hkl2011_table1.toml", "newton.toml"
# How each row differs from its scene. The last asks of the fixed point what rounding allows.
METHODS = [
    ("Algorithm 4.1, control (a)", TABLE_1, ['solve.precision="fixed"']),
    ("Algorithm 4.1, control (b)", TABLE_1, []),
    ("the same fixed point, Newton's method inside", NEWTON, [
        'solve.method="fixed-point"', 'solve.inner="newton"', 'solve.precision="fixed"', "solve.epsilon=1e-12",
    ]),
]


def multipliers(path):
    """Contact stresses of all panes."""
    with h5py.File(path) as file:
        return np.concatenate([file["solve"][f"multiplier_{part}"][:].ravel() for part in ("normal", "tangential")])


def print_row(name, steps, applications, error, seconds):
    print(f"  {name:<46}{steps:>6}{applications:>7}{error:>12}{seconds:>9}".rstrip(), flush=True)


def print_result(name, result, error):
    seconds = sum(stage["compute_seconds"] for stage in result["stages"])
    steps = result["outer_steps"] or result["newton_steps"]
    print_row(name, steps, result["applications"], f"{error:.1e}", f"{seconds:.1f}")


def main():
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("folder", type=pathlib.Path)
    parser.add_argument("--n-div", type=int, choices=PUBLISHED, default=16, help="cells along the shortest edge")
    arguments = parser.parse_args()
    n_div = arguments.n_div
    mesh = f"body.brick.cells=[{3 * n_div}, {n_div}, {n_div}]"
    arguments.folder.mkdir(parents=True, exist_ok=True)
    solved = arguments.folder / "table1.h5"
    subprocess.run([PROGRAM, "run", HERE / NEWTON, solved, "--set", mesh], check=True)
    exact = multipliers(solved)

    print(f"\nWhat accuracy costs on this problem: Table 1 of the paper, n_div = {n_div}")
    print_row("", "steps", "n_A", "error of λ", "seconds")
    iter_a, iter_b, n_a, n_b = PUBLISHED[n_div][0]
    print_row("published, control (a)", iter_a, n_a, "", "")
    print_row("published, control (b)", iter_b, n_b, "", "")
    with tempfile.TemporaryDirectory() as scratch:
        file = pathlib.Path(scratch) / "run.h5"
        for name, scene, changes in METHODS:
            result = run(scene, file, mesh, *changes)
            print_result(name, result, np.linalg.norm(multipliers(file) - exact) / np.linalg.norm(exact))
            file.unlink()
        at_once = run(NEWTON, file, mesh)
    print_result("Newton's method for all at once", at_once, at_once["accuracy"])
    print("  n_A counts solves with A in Algorithm 4.1, products with the dense S below it; seconds are those of all stages")


if __name__ == "__main__":
    main()
