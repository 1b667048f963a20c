#!/usr/bin/env python3
"""The seconds of the whole program in one table, and held against another build of it.

    python3 benches/table.py [--repeat 3] [--skip ROW ...] [--long] [--against PROGRAM]

Every row is the time of whole processes with all files and no pictures: wall-clock and processor seconds, medians, and peak memory.
`gemm` is the time of one product of two matrices of 3000 x 3000 in numpy on as many threads, measured in the same run, so that tables of
two machines can be compared. With `--against` each row runs both programs in turn, and the exit code is 1 where the median ratio of some
row is above 1.1: for developers, by hand, on an idle machine. `--long` adds the rows that take minutes. Needs Python 3 and the program
(target/release/contact3d-pipe, or CONTACT3D_PIPE); peers have a command of their own, benches/peers/compare.py.
"""

import argparse
import dataclasses
import datetime
import json
import os
import pathlib
import platform
import statistics
import subprocess
import sys
import tempfile
import time

from scaling import PROGRAM, gemm_rate

PIPELINES = pathlib.Path(__file__).resolve().parent.parent / "pipelines"

WORST_RATIO = 1.1
"""Medians of three runs on an idle machine differ by up to 5 %."""


@dataclasses.dataclass
class Row:
    """A command: its name, its arguments after the program's name, its threads, and whether it takes minutes."""

    name: str
    arguments: list
    threads: int
    is_long: bool = False
    prepare: list = dataclasses.field(default_factory=list)
    """A command before it that is not timed."""


def cells(n_div):
    return ["--set", f"body.brick.cells=[{3 * n_div},{n_div},{n_div}]"]


def run(scene, *more):
    return ["run", str(PIPELINES / scene), "run.h5", "--no-figures", *more]


ROWS = [
    Row("n_div 4, a tiny scene", run("newton.toml", *cells(4)), 2),
    *(Row(f"n_div {n}", run("newton.toml", *cells(n)), threads, is_long=n == 32) for n in (16, 24, 32) for threads in (2, 1)),
    Row(
        "n_div 24, solve and report again",
        run("newton.toml", *cells(24), "--set", "solve.epsilon=1e-11"),
        2,
        prepare=run("newton.toml", *cells(24)),
    ),
    Row("n_div 16, one static run", run("history.toml", *cells(16), "--set", "step=[]"), 1),
    Row("n_div 16, history of 25 increments", run("history.toml", *cells(16)), 1),
    Row("sweep of 64 cases, n_div 4", ["sweep", str(PIPELINES / "sweep_friction.toml"), "sweep", "--no-figures"], 2),
    Row("adaptive to 5 %", run("newton.toml", "--error", "5%"), 1),
    Row("adaptive to 2 %", run("newton.toml", "--error", "2%"), 1),
    Row("adaptive to 1.1 %", run("newton.toml", "--error", "1.1%"), 2, is_long=True),
    *(
        Row(f"{study}, n_div 8", [study, str(PIPELINES / scene), "study.h5", "--no-figures", *more, *cells(8)], 2, is_long=True)
        for study, scene, more in (
            ("branches", "coulomb_isotropic.toml", ["--parameter", "friction.coefficient.constant", "--from", "0.3", "--to", "1"]),
            ("accuracy", "newton.toml", []),
        )
    ),
]


def measure(program, row):
    """Wall-clock and processor seconds and peak memory in MB of one run from scratch."""
    with tempfile.TemporaryDirectory() as folder:
        def command(arguments):
            return [program, *arguments, "--quiet", "--threads", str(row.threads)]

        if row.prepare:
            subprocess.run(command(row.prepare), cwd=folder, stdout=subprocess.DEVNULL, check=True)
        began = time.perf_counter()
        child = subprocess.Popen(command(row.arguments), cwd=folder, stdout=subprocess.DEVNULL)
        _, status, usage = os.wait4(child.pid, 0)
        wall = time.perf_counter() - began
        if os.waitstatus_to_exitcode(status) != 0:
            sys.exit(f"failed: {' '.join(command(row.arguments))}")
        return wall, usage.ru_utime + usage.ru_stime, usage.ru_maxrss / 1024


def medians(runs):
    return [statistics.median(values) for values in zip(*runs)]


def main():
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("--repeat", type=int, default=3)
    parser.add_argument("--skip", nargs="*", default=[], help="rows whose names begin so")
    parser.add_argument("--long", action="store_true", help="also the rows that take minutes")
    parser.add_argument("--against", metavar="PROGRAM", help="another build, to be no slower than")
    parser.add_argument("--json", metavar="PATH", type=pathlib.Path)
    arguments = parser.parse_args()
    rows = [row for row in ROWS if arguments.long or not row.is_long]
    rows = [row for row in rows if not row.name.startswith(tuple(arguments.skip))]
    other = arguments.against and str(pathlib.Path(arguments.against).resolve())
    product = {n: 2 * 3000**3 / 1e9 / gemm_rate("double", n) for n in (1, 2)}
    print(f"{platform.machine()}, {os.cpu_count()} processors, {datetime.date.today()}, medians of {arguments.repeat}; one product of")
    print(f"3000 x 3000 in double precision: {product[1]:.2f} s on one thread, {product[2]:.2f} s on two\n")
    head = ["what", "threads", "wall [s]", "processor [s]", "peak [MB]", "wall / gemm"] + (["ratio"] if other else [])
    print("| " + " | ".join(head) + " |")
    print("|---" * len(head) + "|")
    found, slower = [], []
    for row in rows:
        own, others = [], []
        for _ in range(arguments.repeat):
            own.append(measure(str(pathlib.Path(PROGRAM).resolve()), row))
            if other:
                others.append(measure(other, row))
        wall, processor, peak = medians(own)
        line = [row.name, str(row.threads), f"{wall:.3g}", f"{processor:.3g}", f"{peak:.0f}", f"{wall / product[row.threads]:.3g}"]
        if other:
            ratio = statistics.median(mine[0] / theirs[0] for mine, theirs in zip(own, others))
            line.append(f"{ratio:.2f}")
            if ratio > WORST_RATIO:
                slower.append(row.name)
        print("| " + " | ".join(line) + " |", flush=True)
        found.append({"name": row.name, "threads": row.threads, "wall": wall, "processor": processor, "peak_megabytes": peak})
    if arguments.json:
        arguments.json.write_text(json.dumps({"gemm_seconds": product, "rows": found}, indent=1))
    if slower:
        sys.exit(f"slower than the other build by more than {WORST_RATIO}: {', '.join(slower)}")


if __name__ == "__main__":
    main()
