#!/usr/bin/env python3
"""The seconds of the whole program in one table, and held against another build of it.

    python3 benches/table.py [--repeat 3] [--skip ROW ...] [--long] [--against PROGRAM] [--peers PYTHON]

Every row is the time of whole processes with all files and no pictures: wall-clock and processor seconds, medians, and peak memory.
`gemm` is the time of one product of two matrices of 3000 x 3000 in numpy on as many threads, measured in the same run, so that tables of
two machines can be compared. The floor of a run is what this machine takes for the operations of its last factor at the rate of that
product, for writing that factor once and reading it twice at the rate of copying memory, and for writing and syncing its files. With
`--against` each row runs both programs in turn, and the exit code is 1 where the median ratio of some row is above 1.1: for developers, by
hand, on an idle machine. `--long` adds the rows that take minutes, `--peers` the programs of benches/peers/README.md at n_div 16. Needs
Python 3, numpy and the program (target/release/contact3d-pipe, or CONTACT3D_PIPE).
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

BENCHES = pathlib.Path(__file__).resolve().parent
PIPELINES = BENCHES.parent / "pipelines"
PEERS = BENCHES / "peers" / "compare.py"

HISTORY = ("n_div 16, history of 25 increments", "n_div 16, one static run")
"""Rows of which the ratio is printed."""

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
    Row(HISTORY[1], run("history.toml", *cells(16), "--set", "step=[]"), 1),
    Row(HISTORY[0], run("history.toml", *cells(16)), 1),
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


RATES = """
import os, tempfile, time
data = bytearray(os.urandom(1 << 20) * 256)
def write():
    with tempfile.NamedTemporaryFile() as file:
        file.write(data)
        file.flush()
        os.fsync(file.fileno())
def best(work):
    return min((lambda t: (work(), time.perf_counter() - t)[1])(time.perf_counter()) for _ in range(3))
print(2 * len(data) / best(lambda: data.copy()), len(data) / best(write))
"""


@dataclasses.dataclass
class Machine:
    """Rates of this machine: products in operations a second by precision and threads, copying memory and writing files in bytes a second."""

    products: dict
    copying: float
    writing: float

    @classmethod
    def measured(cls):
        products = {(p, n): 1e9 * gemm_rate(p, n) for p in ("single", "double") for n in (1, 2)}
        # In a process of its own: the peak of a child counts what its parent held.
        done = subprocess.run([sys.executable, "-c", RATES], capture_output=True, text=True, check=True)
        return cls(products, *map(float, done.stdout.split()))

    def floor(self, factor, threads, file_bytes):
        """Seconds that a run with a factor takes at least."""
        factor_bytes = factor["coefficients"] * {"single": 4, "double": 8}[factor["precision"]]
        operations = factor["operations"] / self.products[factor["precision"], threads]
        return operations + 3 * factor_bytes / self.copying + file_bytes / self.writing


def measure(program, row):
    """Wall-clock and processor seconds and peak memory in MB of one run from scratch, what it says as JSON, and the bytes of its files."""
    with tempfile.TemporaryDirectory() as folder:
        def command(arguments):
            return [program, *arguments, "--quiet", "--threads", str(row.threads)]

        if row.prepare:
            subprocess.run(command(row.prepare), cwd=folder, stdout=subprocess.DEVNULL, check=True)
        is_run = row.arguments[0] == "run"
        began = time.perf_counter()
        child = subprocess.Popen([*command(row.arguments), *["--json"] * is_run], cwd=folder, stdout=subprocess.PIPE)
        output = child.stdout.read()
        _, status, usage = os.wait4(child.pid, 0)
        wall = time.perf_counter() - began
        if os.waitstatus_to_exitcode(status) != 0:
            sys.exit(f"failed: {' '.join(command(row.arguments))}")
        files = sum(path.stat().st_size for path in pathlib.Path(folder).rglob("*") if path.is_file())
        seconds = wall, usage.ru_utime + usage.ru_stime, usage.ru_maxrss / 1024
        return seconds, json.loads(output) if is_run else None, files


def medians(runs):
    return [statistics.median(values) for values in zip(*(seconds for seconds, *_ in runs))]


def parts(name, threads, runs, machine):
    """A line with the parts of runs: medians."""
    def median(part):
        return statistics.median(part(result) for _, result, _ in runs)

    factor = runs[0][1]["factor"]
    rate = factor["operations"] / median(lambda it: it["assembly_seconds"]["factorisation"])
    solving = median(lambda it: sum(s["compute_seconds"] for s in it["stages"] if s["stage"] in ("solve", "post")))
    storing = median(lambda it: sum(s["store_seconds"] for s in it["stages"]))
    dual = median(lambda it: it["assembly_seconds"]["dual_operator"])
    share = rate / machine.products[factor["precision"], threads]
    return f"| {name} | {threads} | {factor['precision']} | {share:.2f} | {dual:.3g} | {solving:.3g} | {storing:.3g} |"


def main():
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("--repeat", type=int, default=3)
    parser.add_argument("--skip", nargs="*", default=[], help="rows whose names begin so")
    parser.add_argument("--long", action="store_true", help="also the rows that take minutes")
    parser.add_argument("--against", metavar="PROGRAM", help="another build, to be no slower than")
    parser.add_argument("--peers", metavar="PYTHON", help="also the peers, by a Python that has them")
    parser.add_argument("--json", metavar="PATH", type=pathlib.Path)
    arguments = parser.parse_args()
    rows = [row for row in ROWS if arguments.long or not row.is_long]
    rows = [row for row in rows if not row.name.startswith(tuple(arguments.skip))]
    other = arguments.against and str(pathlib.Path(arguments.against).resolve())
    machine = Machine.measured()
    product = {n: 2 * 3000**3 / machine.products["double", n] for n in (1, 2)}
    print(f"{platform.machine()}, {os.cpu_count()} processors, {datetime.date.today()}, medians of {arguments.repeat}; one product of")
    print(f"3000 x 3000 in double precision: {product[1]:.2f} s on one thread, {product[2]:.2f} s on two; copying {machine.copying / 1e9:.1f},")
    print(f"writing {machine.writing / 1e9:.2f} GB/s\n")
    head = ["what", "threads", "wall [s]", "processor [s]", "peak [MB]", "wall / gemm", "floor [s]"] + (["ratio"] if other else [])
    print("| " + " | ".join(head) + " |")
    print("|---" * len(head) + "|")
    found, slower, in_parts = [], [], []
    for row in rows:
        own, others = [], []
        for _ in range(arguments.repeat):
            own.append(measure(str(pathlib.Path(PROGRAM).resolve()), row))
            if other:
                others.append(measure(other, row))
        wall, processor, peak = medians(own)
        _, result, files = own[0]
        floor = machine.floor(result["factor"], row.threads, files) if result else None
        in_parts += [parts(row.name, row.threads, own, machine)] if result else []
        line = [row.name, str(row.threads), f"{wall:.3g}", f"{processor:.3g}", f"{peak:.0f}", f"{wall / product[row.threads]:.3g}"]
        line.append(f"{floor:.3g}" if result else "")
        if other:
            ratio = statistics.median(mine[0][0] / theirs[0][0] for mine, theirs in zip(own, others))
            line.append(f"{ratio:.2f}")
            if ratio > WORST_RATIO:
                slower.append(row.name)
        print("| " + " | ".join(line) + " |", flush=True)
        found.append({"name": row.name, "threads": row.threads, "wall": wall, "processor": processor, "peak_megabytes": peak, "floor": floor})
    print("\n| what | threads | factor | share of gemm | dual operator [s] | solve and post [s] | storing [s] |")
    print("|---" * 7 + "|", *in_parts, sep="\n")
    walls = {row["name"]: row["wall"] for row in found}
    if set(HISTORY) <= walls.keys():
        print("\n{} over {}: {:.2f}".format(*HISTORY, walls[HISTORY[0]] / walls[HISTORY[1]]))
    if arguments.peers:
        command = [arguments.peers, PEERS, "--n-div", "16", "--repeat", str(arguments.repeat), "--skip", "siconos-global", "cholmod"]
        subprocess.run([*map(str, command), "--program", str(pathlib.Path(PROGRAM).resolve())], check=True)
    if arguments.json:
        arguments.json.write_text(json.dumps({"gemm_seconds": product, "rows": found}, indent=1))
    if slower:
        sys.exit(f"slower than the other build by more than {WORST_RATIO}: {', '.join(slower)}")


if __name__ == "__main__":
    main()
