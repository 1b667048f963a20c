"""A sweep through Snakemake on this machine: the same files as the program's own."""

import subprocess
import sys
from pathlib import Path

import h5py

from conftest import ROOT

SNAKEFILE = ROOT / "pipelines" / "snakemake" / "Snakefile"

SWEEP = """
scene = "{scene}"
warm_start = true
[set]
"body.brick.cells" = [12, 4, 4]
[[axis]]
key = "friction.coefficient_2"
values = [{{ constant = 0.3 }}, {{ constant = 0.5 }}]
[[axis]]
key = "friction.coefficient_1"
values = [{{ constant = 0.1 }}, {{ constant = 0.3 }}]
"""


def snakemake(program: Path, folder: Path) -> str:
    """Run the workflow on two processors and return what it says."""
    command = [sys.executable, "-m", "snakemake", "-s", SNAKEFILE, "--cores", "2"]
    command += ["--directory", folder, "--config", f"program={program}"]
    command += ["sweep=sweep.toml", "out=jobs"]
    result = subprocess.run(command, capture_output=True, text=True, check=False)
    assert result.returncode == 0, result.stderr
    return result.stderr


def table_digest(folder: Path) -> str:
    with h5py.File(folder / "summary.h5") as file:
        return file["cases"].attrs["digest"]


def test_workflow_gives_the_table_of_the_sweep(program, contact3d, tmp_path):
    scene = ROOT / "pipelines" / "newton.toml"
    (tmp_path / "sweep.toml").write_text(SWEEP.format(scene=scene))
    contact3d("sweep", tmp_path / "sweep.toml", tmp_path / "whole")
    snakemake(program, tmp_path)
    assert table_digest(tmp_path / "jobs") == table_digest(tmp_path / "whole")
    assert len(list((tmp_path / "jobs" / "done").iterdir())) == 4
    # Nothing is left to do.
    assert "Nothing to be done" in snakemake(program, tmp_path)
