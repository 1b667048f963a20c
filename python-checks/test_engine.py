"""Factors that another program holds: the same answers, and what goes wrong with it."""

import os
import shutil
import subprocess
import sys
from pathlib import Path

import h5py
import numpy as np
import pytest

from conftest import ROOT

REFERENCE = f"{sys.executable} {ROOT / 'python-checks' / 'reference_engine.py'}"
CELLS = "body.brick.cells=[18,6,6]"


def pipe(folder, *arguments):
    program = os.environ.get("CONTACT3D_PIPE", ROOT / "target" / "release" / "contact3d-pipe")
    return subprocess.run([program, *arguments], cwd=folder, capture_output=True, text=True, check=False)


def run(folder, file, *more):
    scene = ROOT / "pipelines" / "newton.toml"
    return pipe(folder, "run", scene, file, "--no-figures", "--set", CELLS, *more)


def answers(path):
    with h5py.File(path) as file:
        names = ["multiplier_normal", "multiplier_tangential", "displacement"]
        return [file["solve"][name][:] for name in names]


def require_same_answers(folder, engine, *more):
    assert run(folder, "here.h5").returncode == 0
    done = run(folder, "there.h5", "--engine", engine, *more)
    assert done.returncode == 0, done.stderr
    for there, here in zip(answers(folder / "there.h5"), answers(folder / "here.h5"), strict=True):
        # Both are solved to 1e-12; two digits are left for the norms in which errors are measured.
        assert np.linalg.norm(there - here) <= 1e-10 * np.linalg.norm(here)


@pytest.mark.parametrize("operator", ["explicit", "implicit"])
def test_a_factor_elsewhere_gives_the_answers_of_one_here(tmp_path, operator):
    require_same_answers(tmp_path, REFERENCE, "--set", f"assemble.dual_operator='{operator}'")
    with h5py.File(tmp_path / "there.h5") as file:
        assert not {"values", "values_single"} & set(file["assemble/factor"])
        assert ("dual_operator_single" in file["assemble"]) == (operator == "explicit")


@pytest.mark.parametrize("operator", ["explicit", "implicit"])
def test_bodies_that_contact_alone_holds_have_factors_elsewhere_too(tmp_path, operator):
    scene = ROOT / "pipelines" / "pushed_block.toml"
    change = f"assemble.dual_operator='{operator}'"
    for file, more in [("here.h5", ()), ("there.h5", ("--engine", REFERENCE))]:
        done = pipe(tmp_path, "run", scene, file, "--no-figures", "--set", change, *more)
        assert done.returncode == 0, done.stderr
    for there, here in zip(answers(tmp_path / "there.h5"), answers(tmp_path / "here.h5"), strict=True):
        # Balanced answers are accurate to 1e-10 or better.
        assert np.linalg.norm(there - here) <= 1e-8 * np.linalg.norm(here)


def test_a_factor_that_is_not_at_hand_is_made_again(tmp_path):
    assert run(tmp_path, "run.h5", "--engine", REFERENCE).returncode == 0
    first = answers(tmp_path / "run.h5")
    assert pipe(tmp_path, "export", "run.h5", "problem.h5", "--kind", "fclib").returncode == 0
    assert pipe(tmp_path, "solve", "run.h5").returncode == 0
    for here, there in zip(answers(tmp_path / "run.h5"), first, strict=True):
        # As above.
        assert np.linalg.norm(here - there) <= 1e-10 * np.linalg.norm(there)
    assert pipe(tmp_path, "solve", "run.h5", "--engine", REFERENCE).returncode == 0
    assert all(map(np.array_equal, answers(tmp_path / "run.h5"), first))
    assert pipe(tmp_path, "post", "run.h5", "--no-figures").returncode == 0


def test_a_sweep_takes_cases_that_an_engine_assembled(tmp_path):
    (tmp_path / "sweep.toml").write_text(
        f'scene = "{ROOT / "pipelines" / "newton.toml"}"\n[set]\n"body.brick.cells" = [12, 4, 4]\n'
        '[[axis]]\nkey = "friction.coefficient_1"\nvalues = [{ constant = 0.1 }, { constant = 0.2 }]\n'
    )
    assert pipe(tmp_path, "sweep", "sweep.toml", "out").returncode == 0
    case = next(path for path in sorted((tmp_path / "out").glob("*.h5")) if "-" not in path.name and path.stem != "summary")
    assert pipe(tmp_path, "assemble", case, "--engine", REFERENCE).returncode == 0
    again = pipe(tmp_path, "sweep", "sweep.toml", "out")
    assert again.returncode == 0, again.stderr


WRONG = """
import sys
sys.path.insert(0, {folder!r})
import reference_engine
wrong = {{
    "dies": lambda engine: sys.exit(7),
    "answers NaN": lambda engine: reference_engine.put(0, tail=b"\\xff" * 4 * engine.n),
}}[sys.argv[1]]
reference_engine.Engine.solve = wrong
reference_engine.main()
"""


@pytest.mark.parametrize(
    ("engine", "expected"),
    [
        ("false", "is no engine"),
        ("no-such-program-at-all", "is no engine"),
        ("echo C3DENG00", "is no engine"),
        ("", "the command is empty"),
        ("python wrong.py dies", "ended in the middle of its work: exit status: 7"),
        ("python wrong.py 'answers NaN'", "numbers that are not finite"),
    ],
)
def test_engines_that_fail_leave_nothing_behind(tmp_path, engine, expected):
    (tmp_path / "wrong.py").write_text(WRONG.format(folder=str(ROOT / "python-checks")))
    engine = engine.replace("python", sys.executable)
    failed = run(tmp_path, "run.h5", "--engine", engine)
    assert failed.returncode == 2
    assert expected in " ".join(failed.stderr.replace("│", " ").split())
    assert not (tmp_path / "run.h5").exists()


def find_mumps():
    headers = [Path("/usr/include/smumps_c.h"), Path("/usr/local/include/smumps_c.h")]
    return shutil.which("mpicc") and shutil.which("mpirun") and any(header.exists() for header in headers)


@pytest.mark.skipif(not find_mumps(), reason="needs MPI and MUMPS: libmumps-dev, libopenmpi-dev, openmpi-bin")
def test_two_processes_of_mumps_hold_a_factor(tmp_path):
    for file in ["Makefile", "contact3d_mumps.c"]:
        shutil.copy(ROOT / "engines" / "mumps" / file, tmp_path)
    subprocess.run(["make", "-C", tmp_path], check=True, capture_output=True)
    as_root = "--allow-run-as-root" if os.geteuid() == 0 else ""
    engine = f"mpirun {as_root} --oversubscribe -n 2 {tmp_path / 'contact3d-mumps'}"
    require_same_answers(tmp_path, engine)
