"""Factorisation of the stiffness matrix by CHOLMOD, supernodal, with several orderings.

Ordering and analysis are timed apart from the numerical factorisation; the median of several
repetitions counts. The number of BLAS threads comes from OPENBLAS_NUM_THREADS and OMP_NUM_THREADS,
read when the library loads: run it once for each.
"""

import argparse
import json
import os
import statistics
import time
from pathlib import Path

import numpy as np
from sksparse.cholmod import analyze

from hkl_brick import Brick

ORDERINGS = ("metis", "nesdis", "amd")


def measure(brick: Brick, ordering: str, repeat: int) -> dict:
    """Times of one ordering, and how well the factor solves."""
    analysis, numeric = [], []
    for _ in range(repeat):
        factor = None  # the previous one must not count for memory
        start = time.perf_counter()
        symbolic = analyze(brick.stiffness, mode="supernodal", ordering_method=ordering)
        middle = time.perf_counter()
        factor = symbolic.cholesky(brick.stiffness)
        numeric.append(time.perf_counter() - middle)
        analysis.append(middle - start)
    residual = brick.stiffness @ factor.solve_A(brick.load) - brick.load
    return {
        "ordering": ordering,
        "analysis_seconds": statistics.median(analysis),
        "factor_seconds": statistics.median(numeric),
        "factor_seconds_all": numeric,
        "entries": int(factor.L().nnz),
        "residual": float(np.linalg.norm(residual) / np.linalg.norm(brick.load)),
    }


def main() -> None:
    """Print a table, and write JSON when asked to."""
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("run_file", type=Path, help="an assembled run file")
    parser.add_argument("--ordering", choices=ORDERINGS, action="append")
    parser.add_argument("--repeat", type=int, default=3)
    parser.add_argument("--json", type=Path, help="also write the results here")
    arguments = parser.parse_args()

    brick = Brick.read(arguments.run_file)
    threads = os.environ.get("OPENBLAS_NUM_THREADS", "all")
    print(f"CHOLMOD, n_div = {brick.n_div}, n = {brick.load.size}, threads: {threads}")
    print("ordering  analysis s  factor s  million entries  residual")
    rows = []
    for ordering in arguments.ordering or ORDERINGS:
        row = measure(brick, ordering, arguments.repeat)
        rows.append(row)
        print(
            f"{ordering:<8}  {row['analysis_seconds']:10.3f}  {row['factor_seconds']:8.3f}  "
            f"{row['entries'] / 1e6:15.2f}  {row['residual']:8.1e}"
        )
    if arguments.json:
        result = {"n_div": brick.n_div, "threads": threads, "orderings": rows}
        arguments.json.write_text(json.dumps(result, indent=1) + "\n")


if __name__ == "__main__":
    main()
