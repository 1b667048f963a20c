#!/usr/bin/env python3
"""Seconds of every part and peak memory against mesh refinement, our method beside the paper's.

    python3 benches/scaling.py [--n-div 8 16 24 32] [--paper 8 16] [--threads 1 2] [--repeat 3]

Beside the factorisation stand its rate and its share of the machine's gemm in the same precision, measured with
numpy's BLAS on the same number of threads (where numpy is installed).

Our method: dense dual operator and Newton, to 1e-12. The paper's method: backsolves and Algorithm 4.1
with KPRGP, precision control (a), to 1e-4. Runs alternate; medians are printed as Markdown, with
the growth exponent of each part in the number of unknowns fitted over all sizes. Needs Python 3
and the program (target/release/contact3d-pipe, or CONTACT3D_PIPE).
"""

import argparse
import datetime
import json
import math
import os
import pathlib
import platform
import statistics
import subprocess
import sys
import tempfile

HERE = pathlib.Path(__file__).resolve().parent
SCENE = HERE.parent / "pipelines" / "newton.toml"
PROGRAM = os.environ.get("CONTACT3D_PIPE", str(HERE.parent / "target/release/contact3d-pipe"))
METHODS = {
    "ours": ['assemble.dual_operator="explicit"', 'solve.method="newton"'],
    "paper": [
        'assemble.dual_operator="implicit"',
        'solve.method="fixed-point"',
        'solve.precision="fixed"',
    ],
}
PARTS = ["mesh", "stiffness", "ordering", "factorisation", "dual operator", "solve", "post", "files", "total"]


def run(method, n_div, threads, folder):
    """One run from scratch: seconds of its parts, counts, peak memory in MB."""
    path = folder / "run.h5"
    path.unlink(missing_ok=True)
    changes = [f"body.brick.cells=[{3 * n_div},{n_div},{n_div}]", *METHODS[method]]
    command = [PROGRAM, "run", str(SCENE), str(path), "--no-figures", "--quiet", "--json",
               "--threads", str(threads)]
    for change in changes:
        command += ["--set", change]
    child = subprocess.Popen(command, stdout=subprocess.PIPE)
    output = child.stdout.read()
    _, status, usage = os.wait4(child.pid, 0)
    if os.waitstatus_to_exitcode(status) != 0:
        sys.exit(f"failed: {' '.join(command)}")
    result = json.loads(output)
    stages = {s["stage"]: s for s in result["stages"]}
    parts = result["assembly_seconds"]
    seconds = {
        "mesh": stages["mesh"]["compute_seconds"],
        "stiffness": parts["stiffness"],
        "ordering": parts["ordering"],
        "factorisation": parts["factorisation"],
        "dual operator": parts["dual_operator"],
        "solve": stages["solve"]["compute_seconds"],
        "post": stages["post"]["compute_seconds"],
        "files": sum(s["store_seconds"] for s in stages.values()),
    }
    seconds["total"] = sum(s["compute_seconds"] + s["store_seconds"] for s in stages.values())
    factor = result["factor"]
    return {
        "seconds": seconds,
        "precision": factor["precision"],
        "rate": factor["operations"] / parts["factorisation"] / 1e9,
        "memory": usage.ru_maxrss / 1024,
        "unknowns": result["n_free"],
        "multipliers": result["n_multipliers"],
        "steps": result["newton_steps"] or result["outer_steps"],
        "applications": result["applications"],
        "certificate": max(result["certificate"].values()),
        "megabytes": path.stat().st_size / 1e6,
    }


GEMM = """
import sys, time, numpy
a = numpy.random.default_rng(1).random((3000, 3000)).astype(sys.argv[1])
a @ a
best = min((lambda t: (a @ a, time.perf_counter() - t)[1])(time.perf_counter()) for _ in range(5))
print(2 * 3000**3 / best / 1e9)
"""


def gemm_rate(precision, threads):
    """GFlop/s of numpy's product of two matrices of 3000 x 3000; NaN without numpy."""
    names = ("OPENBLAS_NUM_THREADS", "OMP_NUM_THREADS", "MKL_NUM_THREADS")
    environment = os.environ | {name: str(threads) for name in names}
    dtype = {"single": "float32", "double": "float64"}[precision]
    done = subprocess.run([sys.executable, "-c", GEMM, dtype], env=environment, capture_output=True, text=True, check=False)
    return float(done.stdout) if done.returncode == 0 else float("nan")


def median_of(runs):
    """Medians of repeated runs."""
    middle = dict(runs[0])
    middle["seconds"] = {
        part: statistics.median(r["seconds"][part] for r in runs) for part in PARTS
    }
    middle["rate"] = statistics.median(r["rate"] for r in runs)
    middle["memory"] = statistics.median(r["memory"] for r in runs)
    return middle


def exponent(cases, part):
    """Least-squares slope of log seconds over log unknowns."""
    points = [(math.log(c["unknowns"]), math.log(max(c["seconds"][part], 1e-6))) for c in cases]
    x0 = statistics.mean(x for x, _ in points)
    y0 = statistics.mean(y for _, y in points)
    spread = sum((x - x0) ** 2 for x, _ in points)
    return sum((x - x0) * (y - y0) for x, y in points) / spread if spread else float("nan")


def print_table(title, cases, threads):
    print(f"\n### {title}\n")
    sizes = list(cases)
    print("| | " + " | ".join(f"n_div {n}" for n in sizes) + " | growth |")
    print("|---|" + "---|" * (len(sizes) + 1))
    for label, key in (("unknowns", "unknowns"), ("multipliers", "multipliers"), ("steps", "steps"), ("applications n_A", "applications")):
        print(f"| {label} | " + " | ".join(str(cases[n][key]) for n in sizes) + " | |")
    for part in PARTS:
        row = " | ".join(f"{cases[n]['seconds'][part]:.3f}" for n in sizes)
        growth = f"{exponent(list(cases.values()), part):.2f}" if len(sizes) > 1 else ""
        print(f"| {part} [s] | {row} | {growth} |")
    rates = {precision: gemm_rate(precision, threads) for precision in {cases[n]["precision"] for n in sizes}}
    print("| precision of the factor | " + " | ".join(cases[n]["precision"] for n in sizes) + " | |")
    print("| factorisation [GFlop/s] | " + " | ".join(f"{cases[n]['rate']:.1f}" for n in sizes) + " | |")
    print("| gemm of that precision [GFlop/s] | " + " | ".join(f"{rates[cases[n]['precision']]:.1f}" for n in sizes) + " | |")
    print("| share of gemm | " + " | ".join(f"{cases[n]['rate'] / rates[cases[n]['precision']]:.2f}" for n in sizes) + " | |")
    print("| peak memory [MB] | " + " | ".join(f"{cases[n]['memory']:.0f}" for n in sizes) + " | |")
    print("| file [MB] | " + " | ".join(f"{cases[n]['megabytes']:.0f}" for n in sizes) + " | |")
    print("| worst certificate figure | " + " | ".join(f"{cases[n]['certificate']:.0e}" for n in sizes) + " | |")
    sys.stdout.flush()


def main():
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("--n-div", type=int, nargs="+", default=[8, 16, 24, 32])
    parser.add_argument("--paper", type=int, nargs="*", default=[8, 16], help="sizes of the paper's method")
    parser.add_argument("--threads", type=int, nargs="+", default=[1, 2])
    parser.add_argument("--repeat", type=int, default=3)
    arguments = parser.parse_args()
    print(f"{platform.machine()}, {os.cpu_count()} processors, {datetime.date.today()}, "
          f"medians of {arguments.repeat}")
    with tempfile.TemporaryDirectory() as scratch:
        folder = pathlib.Path(scratch)
        for threads in arguments.threads:
            results = {"ours": {}, "paper": {}}
            for n_div in sorted({*arguments.n_div, *arguments.paper}):
                methods = [w for w, sizes in (("ours", arguments.n_div), ("paper", arguments.paper)) if n_div in sizes]
                runs = {method: [] for method in methods}
                for _ in range(arguments.repeat):
                    for method in methods:
                        runs[method].append(run(method, n_div, threads, folder))
                for method in methods:
                    results[method][n_div] = median_of(runs[method])
            for method, title in (("ours", "Newton to 1e-12"), ("paper", "The paper's method to 1e-4")):
                if results[method]:
                    print_table(f"{title}, {threads} thread{'s' if threads > 1 else ''}", results[method], threads)
            for n_div in results["paper"]:
                if n_div in results["ours"]:
                    ratio = results["paper"][n_div]["seconds"]["total"] / results["ours"][n_div]["seconds"]["total"]
                    print(f"\nn_div {n_div}: the paper's method takes {ratio:.1f} times our total.")


if __name__ == "__main__":
    main()
