"""Judging a run file without the program: h5py opens it and every digest holds."""

from functools import cache
from pathlib import Path

import h5py

from digest import dataset_digest, fits_digest, stage_digest
from schema_check import schemas

STEADY = ("mesh", "assemble", "load", "solve", "post", "accuracy")
"""Stages whose digests say what was computed."""


@cache
def rows_by_stage() -> dict[str, list[dict]]:
    """The table of datasets, stage by stage."""
    rows: dict[str, list[dict]] = {}
    for row in schemas()["run_file.json"]["datasets"]:
        rows.setdefault(row["stage"], []).append(row)
    return rows


def stage_digests(path: Path) -> dict[str, str]:
    """The digest of every stage of a file; `ValueError` unless each fits what is there."""
    found = {}
    if not fits_digest(path):
        raise ValueError(f"{path} does not have the digest that it begins with")
    with h5py.File(path, "r") as file:
        for stage in file:
            found[stage] = checked_digest(file, stage)
    return found


def checked_digest(file: h5py.File, stage: str) -> str:
    """The digest of a stage, computed from its values."""
    digests = {}
    for row in rows_by_stage().get(stage, []):
        if row["path"] not in file:
            continue
        item = file[row["path"]]
        if row["in_stage_digest"]:
            digests[row["path"]] = dataset_digest(item, row["type"])
    if stage_digest(digests, file[stage].attrs["units"]) != file[stage].attrs["digest"]:
        raise ValueError(f"/{stage} is not what its digest says")
    return file[stage].attrs["digest"]


def results(path: Path) -> dict[str, str]:
    """The digests that two runs of the same scene must share."""
    found = stage_digests(path)
    return {stage: found[stage] for stage in STEADY if stage in found}
