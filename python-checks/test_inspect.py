"""inspect_run.py as a user calls it."""

import subprocess
import sys
from pathlib import Path

import h5py
import numpy as np

from run_file import open_run, read_enum

SCRIPT = Path(__file__).with_name("inspect_run.py")


def inspect(path: Path) -> subprocess.CompletedProcess:
    """Run the script on a file."""
    command = [sys.executable, str(SCRIPT), str(path)]
    return subprocess.run(command, capture_output=True, text=True, check=False)


def test_finished_file(tight_path):
    result = inspect(tight_path)
    assert result.returncode == 0, result.stderr
    words = result.stdout.split()
    assert "HKL 2011, Table 1" in result.stdout.splitlines()[0]
    assert "not run yet" not in result.stdout
    assert "900 primal" in result.stdout
    with open_run(tight_path) as file:
        status = read_enum(file["solve/status"])
        assert status in ("converged", "reduced_accuracy") and status in words
        for group in ("resultants", "certificate"):
            assert set(file["post"][group]) - {"moments"} <= set(words)
        force = file["post/resultants/normal_force"][()]
        open_, stick, slip = file["post/zone_counts"][:]
    assert f"normal_force          {force:.6e} N\n" in result.stdout
    assert f"open {open_}, stick {stick}, slip {slip}" in result.stdout


def test_mesh_only_file(stage_paths):
    result = inspect(stage_paths["mesh"])
    assert result.returncode == 0, result.stderr
    assert result.stdout.count("not run yet") == 4
    assert "tetrahedra          960" in result.stdout
    assert "certificate" not in result.stdout


def test_unusable_files(tmp_path):
    missing = tmp_path / "missing.h5"
    text = tmp_path / "text.h5"
    text.write_text("no HDF5 here")
    foreign = tmp_path / "foreign.h5"
    with h5py.File(foreign, "w") as file:
        file["x"] = np.zeros(3)
    newer = tmp_path / "newer.h5"
    with h5py.File(newer, "w") as file:
        file.attrs["filetype"] = "contact3d-pipe run"
        file.attrs["format_version"] = [3, 0]
    reasons = {
        missing: "no such file",
        text: "not a readable HDF5 file",
        foreign: "filetype is None",
        newer: "format version [3, 0]",
    }
    for path, reason in reasons.items():
        result = inspect(path)
        assert result.returncode == 2
        assert reason in result.stderr
        assert "Traceback" not in result.stderr
