#!/usr/bin/env python3
"""Applications of the dual operator and seconds of Algorithm 4.1 with each iterative inner solver.

    python3 benches/inner_solvers.py [--n-div 4 8 16] [--epsilon 1e-4 1e-6 1e-8]
                                     [--dual-operator explicit]

Runs both published friction laws under precision control (a) with KPRGP and with GPCG, and prints
outer steps, operator applications n_A and seconds of the solve stage as Markdown. The counts are the same for
the implicit operator up to rounding and the solves for u; its seconds are not. One thread. Needs
Python 3 and the program (target/release/contact3d-pipe, or CONTACT3D_PIPE).
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
SOLVERS = ("kprgp", "gpcg")


def solve(table, n_div, epsilon, inner, operator, folder):
    """Solves one case: status, outer steps, applications, seconds of solve, worst certificate figure."""
    path = folder / "run.h5"
    path.unlink(missing_ok=True)
    command = [
        PROGRAM, "run", str(HERE.parent / f"pipelines/hkl2011_table{table}.toml"), str(path),
        "--set", f"body.brick.cells=[{3 * n_div},{n_div},{n_div}]",
        "--set", f'assemble.dual_operator="{operator}"',
        "--set", 'solve.method="fixed-point"',
        "--set", 'solve.precision="fixed"',
        "--set", f"solve.epsilon={epsilon}",
        "--set", f'solve.inner="{inner}"',
        "--no-figures", "--quiet", "--json", "--threads", "1",
    ]
    done = subprocess.run(command, stdout=subprocess.PIPE, text=True, check=False)
    if done.returncode != 0:
        sys.exit(f"{' '.join(command)} ended with exit code {done.returncode}")
    result = json.loads(done.stdout)
    return {
        "steps": result["outer_steps"],
        "applications": result["applications"],
        "seconds": sum(s["compute_seconds"] for s in result["stages"] if s["stage"] == "solve"),
        "certificate": max(result["certificate"].values()),
    }


def main():
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("--n-div", type=int, nargs="+", default=[4, 8, 16])
    parser.add_argument("--epsilon", nargs="+", default=["1e-4", "1e-6", "1e-8"])
    parser.add_argument("--dual-operator", choices=["explicit", "implicit"], default="explicit")
    arguments = parser.parse_args()
    print("| law | n_div | epsilon | outer steps, KPRGP / GPCG | n_A, KPRGP / GPCG | ratio "
          "| solve s, KPRGP / GPCG | worst certificate figure, KPRGP / GPCG |")
    print("|---|---|---|---|---|---|---|---|")
    with tempfile.TemporaryDirectory() as scratch:
        for table in (1, 2):
            for n_div in arguments.n_div:
                for epsilon in arguments.epsilon:
                    paper, ours = (
                        solve(table, n_div, epsilon, inner, arguments.dual_operator, pathlib.Path(scratch))
                        for inner in SOLVERS
                    )
                    print(f"| Table {table} | {n_div} | {epsilon} "
                          f"| {paper['steps']} / {ours['steps']} "
                          f"| {paper["applications"]} / {ours["applications"]} "
                          f"| {paper["applications"] / ours["applications"]:.1f} "
                          f"| {paper['seconds']:.3f} / {ours['seconds']:.3f} "
                          f"| {paper['certificate']:.0e} / {ours['certificate']:.0e} |", flush=True)


if __name__ == "__main__":
    main()
