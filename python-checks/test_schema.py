"""Real files against the schema of run files, and the checker against tampered files."""

import shutil
import subprocess
import sys

import h5py
import numpy as np
import pytest

from conftest import ROOT, SCENE
from digest import dataset_digest, input_digest, stage_digest
from run_file import STAGES, open_run, stored_stages
from schema_check import schema_problems

GROUPS_AFTER = {
    "mesh": {"scene", "mesh"},
    "assemble": {"scene", "mesh", "assemble", "load"},
    "solve": {"scene", "mesh", "assemble", "load", "solve"},
    "post": {"scene", "mesh", "assemble", "load", "solve", "post", "VTKHDF"},
}


def test_finished_files_follow_the_schema(run, schema):
    assert schema_problems(run, schema) == []
    # Every stage was there, so every required row was looked at; a finished solve has no checkpoint.
    assert {f"/{name}" for name in run} == set(schema["stages"]) - {
        "/checkpoint",
        "/accuracy",
        "/adapt",
        "/branches",
        "/bound",
        "/history",
    }


@pytest.mark.parametrize("stage", GROUPS_AFTER)
def test_files_after_each_stage_follow_the_schema(stage, stage_paths, schema):
    with open_run(stage_paths[stage]) as file:
        assert schema_problems(file, schema) == []
        assert set(file) == GROUPS_AFTER[stage]
        expected = [name for name in STAGES if name in GROUPS_AFTER[stage]]
        assert stored_stages(file) == expected


def replace(file: h5py.File, path: str, values: np.ndarray, **options) -> None:
    """Put other values in the place of a dataset, keeping its attributes."""
    attributes = dict(file[path].attrs)
    del file[path]
    file.create_dataset(path, data=values, **options)
    file[path].attrs.update(attributes)


def add_dataset(file):
    file["solve/extra"] = np.zeros(3)


def add_group(file):
    file.create_group("post/extra")


def add_root_group(file):
    file.create_group("notes")


def add_link(file):
    file["post/zones"] = h5py.SoftLink("/post/contact_zone")


def remove_dataset(file):
    del file["post/von_mises"]


def remove_matrix_member(file):
    del file["mesh/pane_average/indptr"]


def change_fixed_size(file):
    replace(file, "post/zone_counts", np.zeros(4, dtype=np.int64))


def change_symbolic_size(file):
    replace(file, "solve/slip_bound", np.append(file["solve/slip_bound"][:], 0.0))


def change_rank(file):
    replace(file, "solve/slip_bound", file["solve/slip_bound"][:].reshape(-1, 1))


def change_type(file):
    replace(file, "solve/slip_bound", file["solve/slip_bound"][:].astype("f4"))


def change_enum(file):
    replace(file, "post/contact_zone", file["post/contact_zone"][:].astype("u1"))


def change_compression(file):
    replace(file, "mesh/coordinates", file["mesh/coordinates"][:], compression="gzip", shuffle=True)


def change_unit(file):
    file["solve/slip_bound"].attrs["units"] = "kPa"


def change_units_of_stage(file):
    file["solve"].attrs["units"] = "mm, N"


def remove_attribute(file):
    del file["solve/slip_bound"].attrs["description"]


def add_attribute(file):
    file["solve"].attrs["note"] = "by hand"


def change_matrix_kind(file):
    file["assemble/stiffness"].attrs["encoding-type"] = "csr_matrix"


def change_matrix_shape(file):
    file["assemble/stiffness"].attrs["shape"] = np.array([900, 899])


def change_version(file):
    file.attrs["format_version"] = np.array([2, 99])


def unfinish_stage(file):
    file["solve"].attrs["complete"] = np.uint8(0)


TAMPERED = {
    add_dataset: "/solve/extra: not in the schema",
    add_group: "/post/extra: not in the schema",
    add_root_group: "/notes: not in the schema",
    add_link: "/post/zones: is a link",
    remove_dataset: "/post/von_mises: missing",
    remove_matrix_member: "/mesh/pane_average/indptr: missing",
    change_fixed_size: "/post/zone_counts: 3 is 4",
    change_symbolic_size: "/solve/slip_bound: n_friction_panes is 13, but 12",
    change_rank: "/solve/slip_bound: shape (12, 1)",
    change_type: "/solve/slip_bound: type float32",
    change_enum: "/post/contact_zone: type uint8",
    change_compression: "/mesh/coordinates: storage",
    change_unit: "/solve/slip_bound: units",
    change_units_of_stage: "/solve/slip_bound: units",
    remove_attribute: "/solve/slip_bound: attribute description",
    add_attribute: "/solve: attribute note",
    change_matrix_kind: "/assemble/stiffness: encoding-type",
    change_matrix_shape: "/assemble/stiffness: n_free is 899, but 900",
    change_version: "/: format version",
    unfinish_stage: "/solve: not complete",
}


@pytest.mark.parametrize("tamper", TAMPERED, ids=lambda tamper: tamper.__name__)
def test_the_checker_sees_tampering(tamper, tight_path, schema, tmp_path):
    copy = tmp_path / "tampered.h5"
    shutil.copy(tight_path, copy)
    with h5py.File(copy, "r+") as file:
        tamper(file)
    with h5py.File(copy, "r") as file:
        problems = schema_problems(file, schema)
    assert any(problem.startswith(TAMPERED[tamper]) for problem in problems), problems


def test_schema_rows_are_complete(schema):
    paths = [row["path"] for row in schema["datasets"]]
    assert len(set(paths)) == len(paths)
    for row in schema["datasets"]:
        assert row["path"].startswith(f"/{row['stage']}/")
        assert row["unit"] and row["description"]
        assert row["required"] or row["optional_because"]


def test_digests_of_stages(run, schema):
    by_stage = {name: {} for name in run}
    for row in schema["datasets"]:
        if row["path"] not in run:
            continue
        if row["in_stage_digest"]:
            digest = dataset_digest(run[row["path"]], row["type"])
            by_stage[row["stage"]][row["path"]] = digest
    for stage, digests in by_stage.items():
        units = run[stage].attrs["units"]
        assert stage_digest(digests, units) == run[stage].attrs["digest"], stage


def test_input_digests_chain_the_stages(run):
    upstream = []
    for stage in STAGES:
        attributes = run[stage].attrs
        expected = input_digest(stage, attributes["settings"], upstream)
        assert attributes["input_digest"] == expected, stage
        upstream.append(attributes["digest"])


def test_stages_one_by_one_give_the_same_bits(stage_paths, tight_path):
    with open_run(tight_path) as whole, open_run(stage_paths["post"]) as single:
        for group in (*STAGES, "scene", "VTKHDF"):
            assert whole[group].attrs["digest"] == single[group].attrs["digest"]


@pytest.mark.parametrize("length, force", [("mm", "N"), ("cm", "kN"), ("in", "lbf")])
def test_files_in_other_units_follow_the_schema(
    length, force, contact3d, schema, tmp_path
):
    path = tmp_path / "run.h5"
    changes = [f'units={{length="{length}",force="{force}"}}', "body.brick.cells=[6,2,2]"]
    arguments = [part for change in changes for part in ("--set", change)]
    contact3d("run", SCENE, path, "--no-figures", *arguments)
    with open_run(path) as file:
        assert schema_problems(file, schema) == []
        assert file["mesh/coordinates"].attrs["units"] == length
        assert file["load/force"].attrs["units"] == force
    assert {length, force} <= set(schema["length_units"] + schema["force_units"])


def test_the_picture_of_the_contact_frame_is_what_its_script_draws():
    script = ROOT / "scripts" / "contact_frame.py"
    subprocess.run([sys.executable, script, "--check"], check=True)
