"""Reading a run file of contact3d-pipe: the few things h5py does not do by itself.

>>> from run_file import open_run, read_matrix
>>> with open_run("table1.h5") as file:
...     pressure = file["solve/multiplier_normal"][:]        # Pa, one per pane
...     stiffness = read_matrix(file["assemble/stiffness"])  # scipy, N/m
"""

import tomllib
from pathlib import Path

import h5py
import numpy as np
from scipy import sparse

FILETYPE = "contact3d-pipe run"
FORMAT_MAJOR = 2
STAGES = ("mesh", "assemble", "load", "solve", "post")


class RunFileError(ValueError):
    """The file is missing, is no run file, or lacks what was asked for."""


def open_run(path: str | Path) -> h5py.File:
    """Open a run file for reading; `RunFileError` if it is none of this version."""
    path = Path(path)
    if not path.is_file():
        raise RunFileError(f"{path}: no such file")
    try:
        file = h5py.File(path, "r")
    except OSError as error:
        raise RunFileError(f"{path}: not a readable HDF5 file ({error})") from error
    try:
        check_header(file, path)
    except RunFileError:
        file.close()
        raise
    return file


def check_header(file: h5py.File, path: Path) -> None:
    """Refuse files of another type or of another major version."""
    filetype = file.attrs.get("filetype")
    if filetype != FILETYPE:
        raise RunFileError(f"{path}: filetype is {filetype!r}, not {FILETYPE!r}")
    version = [int(part) for part in np.ravel(file.attrs.get("format_version", []))]
    if version[:1] != [FORMAT_MAJOR]:
        raise RunFileError(
            f"{path}: format version {version}, this reader knows {FORMAT_MAJOR}.x"
        )


def stored_stages(file: h5py.File) -> list[str]:
    """The computing stages that the file holds completely, upstream first."""
    return [s for s in STAGES if s in file and file[s].attrs.get("complete") == 1]


def require_stage(file: h5py.File, stage: str) -> h5py.Group:
    """The group of a finished stage; `RunFileError` names the command to run."""
    if stage not in stored_stages(file):
        raise RunFileError(
            f"{file.filename}: no results of the stage {stage}; "
            f"run `contact3d-pipe {stage}` first"
        )
    return file[stage]


def read_scene(file: h5py.File) -> dict:
    """The scene that the file was computed from."""
    if "scene/toml" not in file:
        raise RunFileError(f"{file.filename}: no scene")
    return tomllib.loads(file["scene/toml"].asstr()[()])


def read_matrix(group: h5py.Group) -> sparse.csc_matrix | sparse.csr_matrix:
    """A sparse matrix group {data, indices, indptr} as a scipy matrix."""
    kinds = {"csc_matrix": sparse.csc_matrix, "csr_matrix": sparse.csr_matrix}
    encoding = group.attrs.get("encoding-type")
    if encoding not in kinds:
        raise RunFileError(f"{group.name}: not a sparse matrix ({encoding!r})")
    parts = tuple(group[part][:] for part in ("data", "indices", "indptr"))
    matrix = kinds[encoding](parts, shape=tuple(group.attrs["shape"]))
    matrix.check_format(full_check=True)
    return matrix


def enum_members(dataset: h5py.Dataset) -> dict[str, int]:
    """Names and codes of an HDF5 enumeration."""
    members = h5py.check_enum_dtype(dataset.dtype)
    if members is None:
        raise RunFileError(f"{dataset.name}: not an enumeration")
    return members


def facet_faces(mesh: h5py.Group) -> np.ndarray:
    """The name of the face of every boundary triangle."""
    names = mesh["face_names"].asstr()[()].split("\n")
    return np.array(names)[mesh["facet_face"][:]]


def read_enum(dataset: h5py.Dataset) -> np.ndarray:
    """The names in an enumeration dataset, in its shape."""
    names = {code: name for name, code in enum_members(dataset).items()}
    codes = np.asarray(dataset[()])
    return np.array([names[int(c)] for c in codes.flat]).reshape(codes.shape)
