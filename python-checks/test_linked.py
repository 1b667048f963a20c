"""A large assembly in a file of its own, as h5py sees it."""

import shutil
import subprocess

import h5py
import numpy as np
import pytest

from conftest import ROOT
from digest import dataset_digest, stage_digest
from run_file import STAGES, open_run, stored_stages
from schema_check import schema_problems

SCENE = ROOT / "pipelines" / "newton.toml"


@pytest.fixture(scope="module")
def linked_path(contact3d, tmp_path_factory):
    """A run file whose assembled data are kept beside it."""
    path = tmp_path_factory.mktemp("linked") / "run.h5"
    contact3d("run", SCENE, path, "--no-figures", "--linked", "--set", "body.brick.cells=[12,4,4]")
    return path


def test_h5py_sees_one_complete_file(linked_path, schema, monkeypatch, tmp_path):
    # HDF5 also looks in the working directory; the folder of the run file must be enough.
    monkeypatch.chdir(tmp_path)
    with open_run(linked_path) as file:
        link = file.get("assemble", getlink=True)
        assert isinstance(link, h5py.ExternalLink)
        assert (linked_path.parent / link.filename).is_file()
        assert schema_problems(file, schema) == []
        assert {f"/{name}" for name in file} == set(schema["stages"]) - {
            "/checkpoint",
            "/accuracy",
            "/adapt",
            "/branches",
            "/bound",
            "/history",
        }
        assert stored_stages(file) == list(STAGES)


def test_digests_hold_across_the_link(linked_path, schema):
    with open_run(linked_path) as file:
        digests = {}
        for row in schema["datasets"]:
            if row["stage"] == "assemble" and row["path"] in file:
                item = file[row["path"]]
                if row["in_stage_digest"]:
                    digests[row["path"]] = dataset_digest(item, row["type"])
        assert stage_digest(digests, file["assemble"].attrs["units"]) == file["assemble"].attrs["digest"]


def test_the_checker_sees_a_wrong_link(linked_path, schema):
    with open_run(linked_path) as file:
        right = file.get("assemble", getlink=True).filename
    copy = linked_path.with_name("copy.h5")
    shutil.copy(linked_path, copy)
    with h5py.File(copy, "r+") as file:
        file.attrs["assemble_file"] = f"other.{right}"
    with open_run(copy) as file:
        assert "/assemble: its link and the attribute of the root differ" in schema_problems(file, schema)


def test_h5py_can_copy_it_into_one_file(linked_path, program, tmp_path):
    whole = tmp_path / "whole.h5"
    with open_run(linked_path) as source, h5py.File(whole, "w", libver="v110") as target:
        for name in source:
            source.copy(source[name], target, name)
        for name, value in source.attrs.items():
            if name != "assemble_file":
                target.attrs[name] = value
        factor = source["assemble/factor/values"][:]
    with open_run(whole) as file:
        assert isinstance(file.get("assemble", getlink=True), h5py.HardLink)
        assert np.array_equal(file["assemble/factor/values"][:], factor)
    # What another program wrote is for reading.
    before = whole.read_bytes()
    solve = [program, "solve", whole]
    refused = subprocess.run(solve, capture_output=True, text=True, check=False)
    assert refused.returncode == 2 and "not one of our files" in refused.stderr
    assert whole.read_bytes() == before
