"""Fixtures: the program, solved run files at small sizes, the schemas.

The program is the environment variable CONTACT3D_PIPE, or target/release/contact3d-pipe. With run
files in CONTACT3D_RUN_FILES, separated as in PATH, the checks of raw arrays judge those files alone:
bricks of one isotropic material under constant tractions, orthotropic Coulomb friction with constants
or ramps. The name of a file without its suffix is the parameter of its tests.
"""

import os
import subprocess
import sys
from collections.abc import Callable
from pathlib import Path

import pytest

from raw_problem import RawProblem
from run_file import open_run
from schema_check import schemas

ROOT = Path(__file__).resolve().parent.parent
# The Python package, also for the process that collects what others report, and the scripts that make meshes.
sys.path[:0] = [str(ROOT / "python"), str(ROOT / "scripts")]
SCENE = ROOT / "pipelines" / "hkl2011_table1.toml"

# Names of the solved cases and the changes they make to the published scene. The last
# turns on everything that the published one leaves at zero: a gap, friction axes that
# are not the global ones, clamps of single components and of a single node, another number
# of layers. Two have cells that are not equal.
CASES = {
    "n_div=4 tight": ["body.brick.cells=[12,4,4]", "solve.epsilon=1e-8"],
    "n_div=6": ["body.brick.cells=[18,6,6]", "solve.epsilon=1e-4"],
    "capped": [
        "body.brick.cells=[12,4,4]",
        "friction.pressure_cap=1e7",
        "solve.epsilon=1e-7",
    ],
    "graded": [
        "body.brick.cells=[12,4,4]",
        "body.brick.grading={x_min=1.6,y_min=1.3,y_max=2.2,z_max=1.5}",
        "solve.epsilon=1e-7",
    ],
    "given planes": [
        "body.brick.cells=[6,4,3]",
        "body.brick.coordinates.x=[0.0,0.15,0.4,0.9,1.5,2.2,3.0]",
        "body.brick.coordinates.z=[0.0,0.2,0.5,1.0]",
        "body.brick.grading.y_max=1.7",
        "solve.epsilon=1e-7",
    ],
    "turned axes and gap": [
        "body.brick.size=[2.0,1.0,1.5]",
        "body.brick.cells=[6,6,5]",
        "contact.gap=1e-5",
        "contact.axis_1=[1.0,2.0,0.0]",
        "friction.coefficient_2={constant=0.4}",
        (
            'clamp=[{face="x_min",components=["x","z"]},{face="y_min",components=["y"]},'
            "{box=[[1.0,1.0,1.5],[1.0,1.0,1.5]]}]"
        ),
        'solve.precision="fixed"',
        "solve.epsilon=1e-7",
    ],
}

Runner = Callable[..., subprocess.CompletedProcess]

# Run files to judge in place of those that the fixtures make.
GIVEN = [Path(path) for path in os.environ.get("CONTACT3D_RUN_FILES", "").split(os.pathsep) if path]


@pytest.fixture(scope="session")
def program() -> Path:
    """Path of the program; a clear failure if it was not built."""
    default = ROOT / "target" / "release" / "contact3d-pipe"
    path = Path(os.environ.get("CONTACT3D_PIPE", default))
    if not path.is_file():
        pytest.fail(
            f"no program at {path}: run `cargo build --release` or set CONTACT3D_PIPE"
        )
    return path


@pytest.fixture(scope="session")
def contact3d(program) -> Runner:
    """Run the program with some arguments; another exit code than expected shows its messages."""

    def run(*arguments, expect: int = 0) -> subprocess.CompletedProcess:
        command = [str(program), "--quiet", *map(str, arguments)]
        result = subprocess.run(command, capture_output=True, text=True, check=False)
        assert result.returncode == expect, f"{command}: {result.stderr}"
        return result

    return run


def changes(case: str) -> list[str]:
    """The command line arguments that turn the published scene into a case."""
    return [part for change in CASES[case] for part in ("--set", change)]


@pytest.fixture(scope="session")
def run_paths(contact3d, tmp_path_factory) -> dict[str, Path]:
    """A finished run file of every case, or those given."""
    if GIVEN:
        return {path.stem: path for path in GIVEN}
    folder = tmp_path_factory.mktemp("runs")
    paths = {case: folder / f"case{i}.h5" for i, case in enumerate(CASES)}
    for case, path in paths.items():
        contact3d("run", SCENE, path, "--no-figures", *changes(case))
    return paths


@pytest.fixture(scope="session")
def tight_path(run_paths) -> Path:
    """The published scene at n_div = 4, solved to 1e-8."""
    return run_paths["n_div=4 tight"]


@pytest.fixture(scope="session")
def stage_paths(contact3d, tmp_path_factory) -> dict[str, Path]:
    """A file after each single stage, every stage made by a process of its own."""
    folder = tmp_path_factory.mktemp("stages")
    path = folder / "run.h5"
    contact3d("mesh", SCENE, path, *changes("n_div=4 tight"))
    paths = {"mesh": path}
    for stage in ("assemble", "solve", "post"):
        previous, path = path, folder / f"{stage}.h5"
        path.write_bytes(previous.read_bytes())
        options = ["--no-figures"] if stage == "post" else []
        contact3d(stage, path, *options)
        paths[stage] = path
    return paths


@pytest.fixture(scope="session", params=[path.stem for path in GIVEN] or list(CASES))
def run(request, run_paths):
    """Each finished run file in turn, open for reading."""
    with open_run(run_paths[request.param]) as file:
        yield file


@pytest.fixture(scope="session")
def problem(run) -> RawProblem:
    """Matrices, vectors and scene of `run`."""
    return RawProblem.read(run)


@pytest.fixture(scope="session")
def tight(tight_path) -> RawProblem:
    """Matrices, vectors and scene of the published scene at n_div = 4."""
    with open_run(tight_path) as file:
        return RawProblem.read(file)


@pytest.fixture(scope="session")
def schema(program) -> dict:
    """The table of datasets."""
    return schemas()["run_file.json"]


@pytest.fixture(scope="session")
def series_schema(program) -> dict:
    """The table of datasets of a series."""
    return schemas()["series.json"]
