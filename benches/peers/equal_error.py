"""Error against seconds on quadratic tetrahedra: GetFEM and the program, law F = 0.3 (scene S1).

    equal_error.py --program target/release/contact3d-pipe --json equal_error.json

Both solve on equal and on graded bricks, GetFEM with a multiplier at the middle of every contact
edge, the program with panes; the program also refines by itself (`run --error`). Where both solve
on one mesh, GetFEM reads it from the run file.

The error is ||u - v|| / ||v|| in the energy norm, where v is the program's answer on one fine mesh
that belongs to none of the sequences (`--reference`; made when it does not exist, in minutes and
with 4.4 GB of disk). For every answer the strains of u and v are compared at four points in each
tetrahedron of the fine mesh, those of u taken from the tetrahedron of its own mesh that holds the
point. Nobody's estimate takes part. v has an error of its own, of about 0.6 %.

Seconds are of whole processes, median over the repetitions, in which programs alternate. GetFEM's
Newton method stops at 1e-6, enough here (J moves by 6e-8); the program goes to 1e-12.
"""

import argparse
import json
import statistics
import sys
import tempfile
from pathlib import Path

import getfem as gf
import h5py
import numpy as np

from compare import machine, run_measured
from getfem_scene import POISSON_RATIO, build_mesh, displacement_space
from hkl_brick import Brick
from scenes import PROGRAM, SCENE_FILE, program_settings

FACES = ("x_min", "x_max", "z_min", "z_max")
GRADING = ", ".join(f"{face} = 1.5" for face in FACES)
MESHES = {"equal": [], "graded": ["--set", f"body.brick.grading={{{GRADING}}}"]}
ELEMENT = ["--set", 'body.element="P2"']
# lambda / 2 mu: errors are ratios of energies, so stiffness needs no unit.
RATIO = POISSON_RATIO / (1 - 2 * POISSON_RATIO)
ENERGY = f"Norm_sqr(Sym({{0}}))+{RATIO!r}*sqr(Trace({{0}}))"


class Reference:
    """The answer on the fine mesh, and how far others are from it."""

    def __init__(self, path: Path) -> None:
        brick = Brick.read(path)
        self.mesh = build_mesh(brick)
        self.rule = gf.MeshIm(self.mesh, gf.Integ("IM_TETRAHEDRON(2)"))
        self.space, nodes = displacement_space(brick, self.mesh)
        self.values = stored_displacement(path)[nodes[::3]].ravel()

    def error(self, run_file: Path, displacement: np.ndarray) -> float:
        """The relative error of an answer on the mesh of a run file."""
        brick = Brick.read(run_file)
        mesh = build_mesh(brick)
        space, nodes = displacement_space(brick, mesh)
        model = gf.Model("real")
        model.add_fem_data("fine", self.space)
        model.set_variable("fine", self.values)
        model.add_fem_data("answer", space)
        model.set_variable("answer", displacement[nodes[::3]].ravel())
        model.add_interpolate_transformation_from_expression("at", self.mesh, mesh, "X")
        whole, difference = (
            gf.asm_generic(self.rule, 0, ENERGY.format(gradient), -1, model)
            for gradient in ("Grad_fine", "(Grad_fine-Interpolate(Grad_answer,at))")
        )
        return float(np.sqrt(difference / whole))


def stored_displacement(run_file: Path) -> np.ndarray:
    """u in m at all nodes."""
    with h5py.File(run_file) as file:
        return file["solve/displacement"][:]


def run(command: list, threads: int = 1) -> dict:
    """Wall-clock and processor time of a process that must succeed."""
    code, _, measured = run_measured([str(word) for word in command], threads)
    if code != 0:
        sys.exit(f"exit code {code}")
    return measured


def run_program(arguments, run_file: Path, n_div: int, *options, threads: int = 1):
    """All stages into a new run file."""
    run_file.unlink(missing_ok=True)
    command = [arguments.program, "run", SCENE_FILE, run_file, *ELEMENT, *options]
    command += [*program_settings("S1", n_div), "--no-figures", "--quiet"]
    return run([*command, "--threads", threads], threads)


class Study:
    """Every answer of every sequence, with its error and its times."""

    def __init__(self, reference: Reference) -> None:
        self.reference = reference
        self.rows: dict[tuple[str, str], dict] = {}

    def add(self, sequence: str, size: str, times: dict, run_file: Path, answer) -> None:
        """Keep the times; measure the error of an answer that is new."""
        row = self.rows.setdefault((sequence, size), {"wall": [], "cpu": []})
        for name in ("wall", "cpu"):
            row[name].append(times[name])
        if "error" not in row:
            row["error"] = self.reference.error(run_file, answer)
            with h5py.File(run_file) as file:
                row["unknowns"] = int(file["load/force"].size)
        words = f"{row['error']:.2%}, {times['wall']:.2f} s wall, {times['cpu']:.2f} cpu"
        print(f"  {sequence}, {size}: {words}", file=sys.stderr)

    def seconds(self, sequence: str, error: float, name: str) -> float:
        """Median seconds to an error, between answers on straight lines of logarithms."""
        rows = [row for key, row in self.rows.items() if key[0] == sequence]
        rows.sort(key=lambda row: row["error"])
        errors = np.log([row["error"] for row in rows])
        times = np.log([statistics.median(row[name]) for row in rows])
        return np.exp(np.interp(np.log(error), errors, times, np.nan, np.nan))

    def print(self) -> None:
        """All answers, then seconds to 5 % and to 3 %; nan where nothing was measured."""
        print("sequence         size    unknowns    error   wall s    cpu s")
        for (sequence, size), row in self.rows.items():
            wall, cpu = (statistics.median(row[name]) for name in ("wall", "cpu"))
            words = f"{row['unknowns']:>9}  {row['error']:7.2%} {wall:8.2f} {cpu:8.2f}"
            print(f"{sequence:<17}{size:<9}{words}")
        print("sequence         wall s to 5 %, 3 %      cpu s to 5 %, 3 %")
        for sequence in dict.fromkeys(key[0] for key in self.rows):
            figures = (
                f"{self.seconds(sequence, error, name):10.2f}"
                for name in ("wall", "cpu")
                for error in (0.05, 0.03)
            )
            print(f"{sequence:<17}{''.join(figures)}")


def measure(arguments, study: Study, folder: Path) -> None:
    """One repetition."""
    file, theirs = folder / "answer.h5", folder / "getfem.npy"
    getfem = [sys.executable, Path(__file__).with_name("getfem_scene.py"), file]
    getfem += ["--tolerance", "1e-6", "--displacement", theirs]
    for mesh, settings in MESHES.items():
        for n_div in getattr(arguments, mesh):
            size = f"n = {n_div}"
            times = run_program(arguments, file, n_div, *settings)
            answer = stored_displacement(file)
            study.add(f"program {mesh}", size, times, file, answer)
            times = run(getfem)
            study.add(f"GetFEM {mesh}", size, times, file, np.load(theirs))
    for target in arguments.targets:
        times = run_program(arguments, file, 16, "--error", target)
        answer = stored_displacement(file)
        study.add("program --error", target, times, file, answer)


def main() -> None:
    """Measure, print and write."""
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("--program", type=Path, default=PROGRAM)
    parser.add_argument("--reference", type=Path, default=Path("reference.h5"))
    parser.add_argument("--equal", type=int, nargs="*", default=[3, 4, 6, 8])
    parser.add_argument("--graded", type=int, nargs="*", default=[3, 4, 6, 8])
    parser.add_argument("--targets", nargs="*", default=["8%", "6%", "5%", "3%", "2%"])
    parser.add_argument("--repeat", type=int, default=3)
    parser.add_argument("--json", type=Path, default=Path("equal_error.json"))
    arguments = parser.parse_args()
    gf.util_trace_level(0)
    if not arguments.reference.exists():
        fine = ["--error", "0.7%", "--set", 'adapt.start="scene"']
        run_program(arguments, arguments.reference, 5, *fine, threads=2)
    begin, study = machine(), Study(Reference(arguments.reference))
    with tempfile.TemporaryDirectory() as folder:
        for _ in range(arguments.repeat):
            measure(arguments, study, Path(folder))
    study.print()
    rows = [{"sequence": s, "size": n} | row for (s, n), row in study.rows.items()]
    arguments.json.write_text(json.dumps(begin | {"rows": rows}, indent=1) + "\n")


if __name__ == "__main__":
    main()
