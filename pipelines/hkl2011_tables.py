#!/usr/bin/env python3
"""Tables 1 and 2 of HKL 2011 next to the published ones (outer steps and applications of A^-1).

    python3 pipelines/hkl2011_tables.py [--largest N_DIV] [--keep FOLDER]

Runs target/release/contact3d-pipe (or the program named by CONTACT3D_PIPE) on every row: both
friction laws, precision controls (a) fixed and (b) adaptive. Needs Python 3 only.
"""

import argparse
import json
import os
import pathlib
import subprocess
import sys
import tempfile

HERE = pathlib.Path(__file__).resolve().parent
PROGRAM = os.environ.get("CONTACT3D_PIPE", str(HERE.parent / "target/release/contact3d-pipe"))

# n_div: published (iterations a, b, applications a, b) of Table 1 and of Table 2.
PUBLISHED = {
    4: ((6, 11, 779, 66), (7, 19, 720, 413)),
    6: ((8, 18, 1091, 319), (8, 21, 849, 366)),
    8: ((8, 24, 1131, 477), (8, 23, 860, 429)),
    10: ((8, 20, 1134, 323), (8, 27, 911, 479)),
    12: ((8, 25, 1127, 629), (8, 23, 974, 575)),
    14: ((9, 24, 1077, 461), (8, 18, 977, 293)),
    16: ((9, 29, 1088, 672), (10, 20, 1044, 332)),
}


def run(scene, file, *changes):
    """Runs a scene of this folder with changed keys and returns its results."""
    command = [PROGRAM, "run", str(HERE / scene), str(file), "--no-figures", "--quiet", "--json"]
    for change in changes:
        command += ["--set", change]
    done = subprocess.run(command, stdout=subprocess.PIPE, text=True, check=False)
    if done.returncode > 1:
        sys.exit(f"{' '.join(command)} ended with exit code {done.returncode}")
    return json.loads(done.stdout)


def solve(table, n_div, precision, folder):
    """Runs one case and returns its results."""
    return run(
        f"hkl2011_table{table}.toml", folder / f"table{table}_{n_div}.h5",
        f"body.brick.cells=[{3 * n_div}, {n_div}, {n_div}]", f'solve.precision="{precision}"',
    )


def solve_seconds(result):
    """Seconds of the solve stage, if it ran."""
    return sum(s["compute_seconds"] for s in result["stages"] if s["stage"] == "solve")


def print_table(table, largest, folder):
    print(f"\nTable {table}: outer steps and operator applications n_A, ours / published")
    print(f"{'n_div':>5} {'3n':>6} {'3m':>4}   {'iter (a)':>8} {'iter (b)':>8}"
          f"   {'n_A (a)':>11} {'n_A (b)':>9}   {'s (a)':>7} {'s (b)':>7}")
    for n_div, rows in PUBLISHED.items():
        if n_div > largest:
            continue
        a, b = (solve(table, n_div, precision, folder) for precision in ("fixed", "adaptive"))
        iter_a, iter_b, n_a, n_b = rows[table - 1]
        steps = [f"{r['outer_steps']}/{p}" for r, p in ((a, iter_a), (b, iter_b))]
        applications = [f"{r['applications']}/{p}" for r, p in ((a, n_a), (b, n_b))]
        print(f"{n_div:>5} {a['n_free']:>6} {a['n_multipliers']:>4}   {steps[0]:>8} {steps[1]:>8}"
              f"   {applications[0]:>11} {applications[1]:>9}   {solve_seconds(a):>7.2f} {solve_seconds(b):>7.2f}",
              flush=True)


def main():
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("--largest", type=int, default=16, help="largest n_div (default 16)")
    parser.add_argument("--keep", type=pathlib.Path, help="keep the run files in this folder")
    arguments = parser.parse_args()
    with tempfile.TemporaryDirectory() as scratch:
        folder = arguments.keep or pathlib.Path(scratch)
        folder.mkdir(parents=True, exist_ok=True)
        for table in (1, 2):
            print_table(table, arguments.largest, folder)


if __name__ == "__main__":
    main()
