"""The program and its peers side by side on the HKL brick: medians and ratios in one table.

Every contender runs once per repetition, in turn, as a process of its own; the kernel reports its
processor time and peak memory. `inner s` is what the contender times itself: for the program all
stages without storing, for the peers all but reading the run file, mesh and assembly. The program
draws no pictures.
"""

import argparse
import json
import os
import platform
import statistics
import subprocess
import sys
import tempfile
import time
from dataclasses import asdict, dataclass, replace
from datetime import UTC, datetime
from pathlib import Path

from scenes import (
    PROGRAM,
    REFERENCE_ENERGY,
    SCENE_FILE,
    SCENES,
    make_run_file,
    program_settings,
)

HERE = Path(__file__).resolve().parent
PEERS = {
    "getfem": ["getfem_scene.py"],
    "siconos": ["siconos_scene.py"],
    "siconos-backsolve": ["siconos_scene.py", "--delassus", "backsolve"],
    "siconos-admm": ["siconos_scene.py", "--method", "admm", "--tolerance", "1e-12"],
    "siconos-global": ["siconos_scene.py", "--method", "global-admm"],
}
OURS = "contact3d-pipe"
# Above this the program's answer is too rough to compare its time with the peers' converged ones.
CERTIFICATE_LIMIT = 1e-6


@dataclass(frozen=True)
class Sample:
    """One run of one contender; times in s, memory in MB, energy J in N m."""

    wall: float
    cpu: float
    memory: float
    inner: float | None
    energy: float | None
    converged: bool
    certificate: float | None = None


def run_measured(command: list[str], threads: int) -> tuple[int, str, dict]:
    """Exit code, standard output, and wall, cpu and memory of a process."""
    names = ("OPENBLAS_NUM_THREADS", "OMP_NUM_THREADS")
    environment = os.environ | {name: str(threads) for name in names}
    with tempfile.TemporaryFile("w+") as output, tempfile.TemporaryFile("w+") as errors:
        start = time.perf_counter()
        process = subprocess.Popen(
            command, stdout=output, stderr=errors, env=environment
        )
        _, status, usage = os.wait4(process.pid, 0)
        wall = time.perf_counter() - start
        process.returncode = os.waitstatus_to_exitcode(status)
        if process.returncode != 0:
            errors.seek(0)
            print(
                f"{' '.join(command)}: exit code {process.returncode}", file=sys.stderr
            )
            print(errors.read()[-2000:], file=sys.stderr)
        output.seek(0)
        cpu = usage.ru_utime + usage.ru_stime
        measured = {"wall": wall, "cpu": cpu, "memory": usage.ru_maxrss / 1024}
        return process.returncode, output.read(), measured


def run_program(arguments, scene: str, folder: Path) -> Sample:
    """All stages into a new run file."""
    file = folder / f"{scene}.h5"
    file.unlink(missing_ok=True)
    extra = [word for setting in arguments.set for word in ("--set", setting)]
    command = [arguments.program, "run", SCENE_FILE, file]
    command += [*program_settings(scene, arguments.n_div), *extra]
    command += ["--no-figures", "--json", "--threads", arguments.threads]
    code, output, measured = run_measured([str(w) for w in command], arguments.threads)
    inner, certificate = None, None
    if code in (0, 1):
        result = json.loads(output)
        inner = sum(stage["compute_seconds"] for stage in result["stages"])
        certificate = max(result["certificate"].values())
    converged = code == 0
    sample = Sample(**measured, inner=inner, energy=None, converged=converged)
    return replace(sample, certificate=certificate)


def run_peer(arguments, peer: str, scene: str, folder: Path) -> Sample:
    """One of our scripts on the assembled run file."""
    result = folder / "peer.json"
    result.unlink(missing_ok=True)
    script, *options = PEERS[peer]
    command = [arguments.python, str(HERE / script), str(folder / "assembled.h5")]
    command += [*options, "--scene", scene, "--json", str(result)]
    code, _, measured = run_measured(command, arguments.threads)
    if code != 0:
        return Sample(**measured, inner=None, energy=None, converged=False)
    data = json.loads(result.read_text())
    return Sample(
        **measured,
        inner=data["seconds_without_assembly"],
        energy=data["energy"],
        converged=data["converged"],
    )


def program_energy(file: Path) -> float | None:
    """J of the program's solution; with panes, so it differs from the peers' by discretisation."""
    import h5py  # here, after all measurements: see scenes.py about memory

    with h5py.File(file) as run:
        if "post/resultants" not in run:
            return None
        resultants = run["post/resultants"]
        return float(resultants["strain_energy"][()] - resultants["load_work"][()])


def factor_times(arguments, folder: Path) -> dict | None:
    """CHOLMOD's factorisation with several orderings."""
    result = folder / "cholmod.json"
    script = [arguments.python, str(HERE / "cholmod_factor.py")]
    script += [str(folder / "assembled.h5"), "--repeat", str(arguments.repeat)]
    code, output, _ = run_measured([*script, "--json", str(result)], arguments.threads)
    print(output)
    return json.loads(result.read_text()) if code == 0 else None


def median_of(samples: list[Sample], name: str) -> float | None:
    """Median over the runs that have the figure."""
    values = [v for s in samples if (v := getattr(s, name)) is not None]
    return statistics.median(values) if values else None


def summarise(samples: list[Sample]) -> dict:
    """Medians of one contender on one scene."""
    names = ("wall", "cpu", "inner", "memory", "energy", "certificate")
    summary = {name: median_of(samples, name) for name in names}
    return summary | {"converged": all(sample.converged for sample in samples)}


def cell(value: float | None, width: int, digits: int) -> str:
    """A number, or a dash where there is none."""
    return f"{'-':>{width}}" if value is None else f"{value:{width}.{digits}f}"


def ratio(theirs: dict, ours: dict | None, name: str) -> float | None:
    """How many times ours."""
    if ours is None or theirs[name] is None or not ours[name]:
        return None
    return theirs[name] / ours[name]


def print_table(rows: dict[tuple[str, str], dict], n_div: int) -> None:
    """Medians, and ratios to the program in the same scene."""
    print(
        "scene contender            wall s    cpu s  inner s  peak MB"
        "     wall x  cpu x inner x  J [N m]"
    )
    for (scene, contender), row in rows.items():
        ours = rows.get((scene, OURS))
        numbers = [cell(row[name], 9, 2) for name in ("wall", "cpu", "inner")]
        ratios = [
            cell(ratio(row, ours, name), 7, 1) for name in ("wall", "cpu", "inner")
        ]
        print(
            f"{scene:<5} {contender:<18}{''.join(numbers)}{cell(row['memory'], 9, 0)}"
            f"    {''.join(ratios)}  {cell(row['energy'], 13, 6)}"
            f"{'' if row['converged'] else '  NOT CONVERGED'}"
        )
        if row["certificate"] is not None and row["certificate"] > CERTIFICATE_LIMIT:
            print(
                f"      {contender}: certificate {row['certificate']:.1e}, not comparable"
            )
        reference = REFERENCE_ENERGY.get((scene, n_div))
        if contender != OURS and reference and row["energy"]:
            error = abs(row["energy"] / reference - 1.0)
            if error > 1e-7:  # references are printed to seven digits at least
                print(f"      {contender}: J is off its reference by {error:.1e}")


def machine() -> dict:
    """Where and when the figures were taken."""
    return {
        "machine": platform.machine(),
        "processors": os.cpu_count(),
        "system": platform.platform(),
        "load_average": os.getloadavg(),
        "date": datetime.now(UTC).isoformat(timespec="seconds"),
    }


def collect(arguments, folder: Path) -> dict[tuple[str, str], list[Sample]]:
    """All repetitions, contenders in turn."""
    contenders = [name for name in (OURS, *PEERS) if name not in arguments.skip]
    samples = {(s, c): [] for s in arguments.scenes for c in contenders}
    for repetition in range(arguments.repeat):
        for scene, contender in samples:
            if contender == OURS:
                sample = run_program(arguments, scene, folder)
            else:
                sample = run_peer(arguments, contender, scene, folder)
            samples[scene, contender].append(sample)
            words = f"{sample.wall:.2f} s wall, {sample.cpu:.2f} s cpu"
            print(f"  {repetition + 1}: {scene} {contender}: {words}", file=sys.stderr)
    return samples


def parse_arguments() -> argparse.Namespace:
    """The command line."""
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("--n-div", type=int, default=8)
    parser.add_argument("--repeat", type=int, default=3)
    parser.add_argument("--threads", type=int, default=1)
    parser.add_argument("--scenes", nargs="+", choices=SCENES, default=["S1", "S3"])
    parser.add_argument(
        "--skip", nargs="+", choices=(OURS, *PEERS, "cholmod"), default=[]
    )
    parser.add_argument("--program", type=Path, default=PROGRAM)
    parser.add_argument("--python", default=sys.executable, help="runs the peers")
    parser.add_argument(
        "--set", action="append", default=[], help="further KEY=VALUE for the program"
    )
    parser.add_argument("--json", type=Path, default=Path("peers.json"))
    return parser.parse_args()


def main() -> None:
    """Measure, print and write."""
    arguments = parse_arguments()
    begin = machine()
    with tempfile.TemporaryDirectory() as name:
        folder = Path(name)
        make_run_file(arguments.program, arguments.n_div, folder / "assembled.h5")
        samples = collect(arguments, folder)
        factor = None
        if "cholmod" not in arguments.skip:
            factor = factor_times(arguments, folder)
        rows = {key: summarise(values) for key, values in samples.items()}
        for (scene, contender), row in rows.items():
            if contender == OURS and row["inner"] is not None:
                row["energy"] = program_energy(folder / f"{scene}.h5")
    print(
        f"n_div = {arguments.n_div}, threads: {arguments.threads}, medians of "
        f"{arguments.repeat}, load average before: {begin['load_average'][0]:.1f}"
    )
    print_table(rows, arguments.n_div)
    result = begin | {
        "n_div": arguments.n_div,
        "threads": arguments.threads,
        "repeat": arguments.repeat,
        "program_settings": arguments.set,
        "cholmod": factor,
        "rows": [
            {"scene": scene, "contender": contender, "median": rows[scene, contender]}
            | {"samples": [asdict(sample) for sample in values]}
            for (scene, contender), values in samples.items()
        ],
    }
    arguments.json.write_text(json.dumps(result, indent=1) + "\n")


if __name__ == "__main__":
    main()
