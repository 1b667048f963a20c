"""The digest that a file begins with, changes by h5py, and forged solutions, as `check` sees them."""

import random
import shutil
import subprocess

import h5py
import numpy as np
import pytest

from conftest import ROOT
from digest import renew_digest, fits_digest
from faults.bad_files import editable
from faults.mutations import fit_digests

SCENE = ROOT / "pipelines" / "newton.toml"
SMALL = ["--no-figures", "--set", "body.brick.cells=[12,4,4]"]
REFERENCES = {"DIMENSION_LIST", "REFERENCE_LIST"}
ALTERED = "its bytes are not those that contact3d-pipe wrote: another program opened it for writing"


@pytest.fixture(scope="module")
def path(contact3d, tmp_path_factory):
    """A run file with every kind of group that a stage does not write."""
    path = tmp_path_factory.mktemp("integrity") / "run.h5"
    contact3d("run", SCENE, path, *SMALL)
    meshes = ["--coarsest", "2", "--finest", "4", "--budget", "0.1"]
    contact3d("accuracy", SCENE, path, *SMALL, *meshes)
    return path


def test_a_file_begins_with_its_digest(path):
    assert fits_digest(path)


def test_a_file_that_h5py_opens_and_leaves_is_as_it_was(path, contact3d, tmp_path):
    copy = tmp_path / "copy.h5"
    shutil.copy(path, copy)
    with h5py.File(copy, "r+") as file:
        assert "multiplier_normal" in file["solve"]
    assert copy.read_bytes() == path.read_bytes()
    contact3d("check", copy)


def test_a_dataset_that_a_user_adds_is_refused(path, contact3d, tmp_path):
    copy = tmp_path / "copy.h5"
    shutil.copy(path, copy)
    with h5py.File(copy, "r+") as file:
        file["notes"] = [1.0]
    before = copy.read_bytes()
    for command in (("status", copy), ("check", copy), ("post", copy), ("run", SCENE, copy)):
        assert ALTERED in contact3d(*command, expect=2).stderr
    assert copy.read_bytes() == before


def damages(path) -> list[tuple[str, str | None, bool]]:
    """Every attribute to delete or to alter, every dataset and stage to delete."""
    found = []
    with h5py.File(path) as file:
        def see(_, item):
            for name in item.attrs:
                found.append((item.name, name, False))
                if name not in REFERENCES:
                    found.append((item.name, name, True))
            if item.name != "/":
                found.append((item.name, None, False))

        see("", file)
        file.visititems(see)
    return found


def damage(path, name: str, attribute: str | None, altered: bool) -> None:
    with editable(path) as file:
        if attribute is None:
            del file[name]
        elif not altered:
            del file[name].attrs[attribute]
        else:
            value = file[name].attrs[attribute]
            if isinstance(value, bytes):
                file[name].attrs[attribute] = np.bytes_(b"X" + value[1:])
            elif isinstance(value, str):
                file[name].attrs.modify(attribute, f"{value}x")
            else:
                file[name].attrs.modify(attribute, value + np.ones_like(value))


def test_check_misses_nothing_that_is_gone_or_altered(path, program, tmp_path):
    chosen = random.Random(7).sample(damages(path), 40)
    # Left out of all digests: they depend on the clock.
    with h5py.File(path) as file:
        clocked = [name for name in ("/accuracy/solves/seconds", "/solve/seconds") if name in file]
    for case in [*chosen, *((name, None, False) for name in clocked)]:
        copy = tmp_path / "copy.h5"
        shutil.copy(path, copy)
        damage(copy, *case)
        answer = subprocess.run([program, "check", copy], capture_output=True, text=True, check=False)
        assert answer.returncode == 2, case


def test_a_forged_solution_is_no_solution(path, contact3d, tmp_path):
    """With digests that fit, nothing but the equations tells."""
    honest = tmp_path / "honest.h5"
    shutil.copy(path, honest)
    with editable(honest) as file:
        fit_digests(file)
    assert ALTERED in contact3d("check", honest, expect=2).stderr
    renew_digest(honest)
    contact3d("check", honest)
    for dataset, word in [
        ("solve/multiplier_normal", "no solution"),
        ("solve/displacement", "no solution"),
        ("post/certificate/equilibrium", "/post/certificate/equilibrium"),
    ]:
        forged = tmp_path / "forged.h5"
        shutil.copy(path, forged)
        with editable(forged) as file:
            file[dataset][...] = file[dataset][()] * 1.01 + 1e-3 * (np.ndim(file[dataset]) == 0)
            fit_digests(file)
        renew_digest(forged)
        assert word in contact3d("check", forged, expect=2).stderr


def test_damaged_data_are_not_copied(path, contact3d, tmp_path):
    copy, target = tmp_path / "copy.h5", tmp_path / "grid.vtkhdf"
    for name in ("VTKHDF/PointData/displacement", "VTKHDF/Points"):
        shutil.copy(path, copy)
        with editable(copy) as file:
            file[name][0] += 1e-3
        assert ALTERED in contact3d("export", copy, target, "--kind", "vtkhdf", expect=2).stderr
        assert not target.exists()


def test_a_file_that_claims_much_takes_little(path, program, tmp_path):
    """Coordinates of 480 MB in 1 MB of deflated zeros."""
    bomb = tmp_path / "bomb.h5"
    shutil.copy(path, bomb)
    rows = 20_000_000
    with editable(bomb) as file:
        attributes = dict(file["mesh/coordinates"].attrs)
        del file["mesh/coordinates"]
        chunk = (1 << 20, 3)
        stored = file.create_dataset("mesh/coordinates", (rows, 3), "f8", chunks=chunk, compression="gzip", compression_opts=9)
        for first in range(0, rows, chunk[0]):
            stored[first : first + chunk[0]] = 0.0
        for name, value in attributes.items():
            if name not in REFERENCES:
                stored.attrs[name] = value
    assert bomb.stat().st_size < path.stat().st_size + 2_000_000
    page = tmp_path / "page.html"
    for command in (["check", bomb], ["report", bomb, page], ["post", bomb, "--no-figures"]):
        limited = ["sh", "-c", 'ulimit -v 400000 && exec "$@"', "sh", program, *command]
        answer = subprocess.run(limited, capture_output=True, text=True, check=False)
        assert answer.returncode == 2, answer.stderr
        assert ALTERED in answer.stderr


