"""Checking a run file against the schema that the program writes: every group, dataset, attribute."""

import json
import os
import re
import subprocess
from functools import cache
from pathlib import Path
from tempfile import TemporaryDirectory

import h5py
import numpy as np

from units import unit_word

# What VTK itself demands on its group, besides the attributes of every stage.
VTK_ATTRIBUTES = {"Type", "Version"}
# On the group of the steps of a series.
SERIES_ATTRIBUTES = {"NSteps"}
NUMBERS = {"f64": np.dtype("<f8"), "f32": np.dtype("<f4"), "i64": np.dtype("<i8"), "u8": np.dtype("u1")}


@cache
def schemas() -> dict[str, dict]:
    """The tables of datasets that the program writes, by the names of their files."""
    built = Path(__file__).resolve().parent.parent / "target" / "release" / "contact3d-pipe"
    program = os.environ.get("CONTACT3D_PIPE", built)
    with TemporaryDirectory() as folder:
        subprocess.run([program, "schema", folder], check=True, capture_output=True)
        return {path.name: json.loads(path.read_text()) for path in Path(folder).glob("*.json")}


def schema_problems(file: h5py.File, schema: dict) -> list[str]:
    """Every difference between a file and the schema, one sentence each."""
    return _Checker(file, schema).run()


class _Checker:
    def __init__(self, file: h5py.File, schema: dict):
        self.file = file
        self.schema = schema
        self.rows = {row["path"]: row for row in schema["datasets"]}
        self.sizes: dict[str, tuple[int, str]] = {}
        self.units = ["m", "N"]
        self.users: dict[h5py.Dataset, set[tuple[str | None, int]]] = {}
        self.problems: list[str] = []

    def run(self) -> list[str]:
        """Check the root, then every stage that is there."""
        linked = {f"{name}_file" for name in self.file if self.is_linked(name)}
        self.attributes(self.file, self.schema["root_attributes"], linked)
        if self.file.attrs.get("filetype") != self.schema["filetype"]:
            self.say("/", "another filetype")
        version = list(self.file.attrs.get("format_version", []))
        if version != self.schema["format_version"]:
            self.say("/", f"format version {version}")
        for name in self.file:
            if f"/{name}" not in self.schema["stages"]:
                self.say(f"/{name}", "not in the schema")
            else:
                self.stage(name)
        return self.problems

    def is_linked(self, name: str) -> bool:
        """Whether a stage is kept in a file of its own, joined as the schema says."""
        link = self.file.get(name, getlink=True)
        if not isinstance(link, h5py.ExternalLink):
            return False
        digest = self.file[name].attrs["digest"]
        if link.filename != f"{name}-{digest[:16]}.h5":
            self.say(f"/{name}", f"is linked to {link.filename}")
        if self.file.attrs.get(f"{name}_file") != link.filename:
            self.say(f"/{name}", "its link and the attribute of the root differ")
        if link.path != f"/{name}":
            self.say(f"/{name}", f"is linked to the group {link.path}")
        if self.file[name].file.attrs["filetype"] != self.schema["linked_filetype"]:
            self.say(f"/{name}", "its file has another filetype")
        return True

    def say(self, path: str, problem: str) -> None:
        self.problems.append(f"{path}: {problem}")

    def stage(self, name: str) -> None:
        """Check a stage group: attributes, nothing unknown, nothing missing."""
        group = self.file[name]
        extra = VTK_ATTRIBUTES if name == "VTKHDF" else set()
        self.attributes(group, self.schema["stage_attributes"], extra)
        self.units = group.attrs.get("units", "").split(", ")
        if group.attrs.get("complete") != 1:
            self.say(f"/{name}", "not complete")
        found: set[str] = set()
        self.walk(group, found)
        for path, row in self.rows.items():
            if row["stage"] == name and row["required"] and path not in found:
                self.say(path, "missing")

    def walk(self, group: h5py.Group, found: set[str]) -> None:
        """Visit what lies below a group; matrices are one thing."""
        for name in group:
            path = f"{group.name}/{name}"
            if not isinstance(group.get(name, getlink=True), h5py.HardLink):
                self.say(path, "is a link")
            elif is_scale(group[name]):
                continue
            elif path in self.rows:
                found.add(path)
                self.row(group[name], self.rows[path])
            elif any(known.startswith(f"{path}/") for known in self.rows):
                if not isinstance(group[name], h5py.Group):
                    self.say(path, "is a dataset instead of a group")
                    continue
                extra = SERIES_ATTRIBUTES if path == "/VTKHDF/Steps" else set()
                self.attributes(group[name], [], extra)
                self.walk(group[name], found)
            else:
                self.say(path, "not in the schema")

    def row(self, item: h5py.Group | h5py.Dataset, row: dict) -> None:
        """Check one dataset or matrix against its row of the table."""
        path = row["path"]
        is_matrix = row["type"].endswith("_matrix")
        if isinstance(item, h5py.Group) != is_matrix:
            self.say(path, f"is not of type {row['type']}")
            return
        expected = list(self.schema["dataset_attributes"])
        if is_matrix:
            expected += self.schema["matrix_attributes"]
        self.attributes(item, expected, axis_attributes(item))
        words = {
            "units": unit_word(row, *self.units),
            "symbol": row["symbol"],
            "description": row["description"],
        }
        for attribute, word in words.items():
            if item.attrs.get(attribute) != word:
                self.say(path, f"{attribute} is {item.attrs.get(attribute)!r}")
        if is_matrix:
            self.matrix(item, row)
        else:
            self.kind(item, row)
            self.shape(path, row["shape"], item.shape)
            self.axes(item, row["dimensions"], row.get("labels", {}))
            self.storage(item, row)

    def matrix(self, group: h5py.Group, row: dict) -> None:
        """Check the members of a sparse matrix group."""
        path = row["path"]
        if group.attrs.get("encoding-type") != row["type"]:
            self.say(path, f"encoding-type is not {row['type']}")
        members = {member["name"]: member for member in self.schema["matrix_members"]}
        parts = {name for name in group if not is_scale(group[name])}
        for name in sorted(parts ^ set(members)):
            self.say(f"{path}/{name}", "missing or not in the schema")
        for name in sorted(set(group) & set(members)):
            if group[name].ndim != 1:
                self.say(f"{path}/{name}", "is not a vector")
            self.kind(group[name], {**members[name], "path": f"{path}/{name}"})
            self.axes(group[name], ["n_pointers" if name == "indptr" else "n_entries"], {})
            # Compression is for indices; the values of a matrix hardly shrink.
            storage = "plain" if name == "data" else row["storage"]
            self.storage(group[name], {"storage": storage})
        self.shape(path, row["shape"], tuple(group.attrs.get("shape", ())))

    def axes(self, dataset: h5py.Dataset, names: list[str], labels: dict) -> None:
        """Check the dimension scale of every axis: its name, its length, its labels, and that it knows the dataset."""
        for axis, (scales, name) in enumerate(zip(scales_of(dataset), names, strict=True)):
            if [scale.name.rsplit("/", 1)[-1] for scale in scales] != [name]:
                self.say(dataset.name, f"axis {axis} is not named {name}")
                continue
            (scale,) = scales
            # By HDF5's own library of dimension scales, as netCDF-C asks it.
            if not scale.is_scale or list(dataset.dims[axis].values()) != [scale]:
                self.say(scale.name, f"is no scale of axis {axis} of {dataset.name} to HDF5")
            if scale.shape != (dataset.shape[axis],):
                self.say(scale.name, f"length {scale.shape} instead of {dataset.shape[axis]}")
            if name in labels and list(scale.asstr()[:]) != labels[name]:
                self.say(scale.name, f"labels are not {labels[name]}")
            if (dataset.name, axis) not in self.users_of(scale):
                self.say(scale.name, f"does not list axis {axis} of {dataset.name}")

    def users_of(self, scale: h5py.Dataset) -> set[tuple[str | None, int]]:
        """Names of the datasets that a scale lists, each with the axis; looked up once, since many share a scale."""
        if scale not in self.users:
            references = scale.attrs["REFERENCE_LIST"]
            self.users[scale] = {(name_of(scale.file, dataset), axis) for dataset, axis in references}
        return self.users[scale]

    def kind(self, dataset: h5py.Dataset, row: dict) -> None:
        """Check the type of the values."""
        if not has_type(dataset.dtype, row):
            self.say(row["path"], f"type {dataset.dtype} instead of {row['type']}")

    def shape(self, path: str, symbolic: list, shape: tuple) -> None:
        """Check a shape; symbolic sizes must mean the same everywhere."""
        if len(symbolic) != len(shape):
            self.say(path, f"shape {shape} instead of {symbolic}")
            return
        for extent, size in zip(symbolic, shape, strict=True):
            if isinstance(extent, int):
                expected, source = extent, "the schema"
            else:
                name, plus = re.fullmatch(r"(\w+)(?: \+ (\d+))?", extent).groups()
                more = int(plus or 0)
                if name not in self.schema["extents"]:
                    self.say(path, f"size {name} is not explained")
                base, source = self.sizes.setdefault(name, (size - more, path))
                expected = base + more
            if size != expected:
                self.say(path, f"{extent} is {size}, but {expected} by {source}")

    def storage(self, dataset: h5py.Dataset, row: dict) -> None:
        """Check that arrays are compressed exactly where the schema says so, and they are more than 16 KiB."""
        packed = dataset.compression == "gzip" and dataset.shuffle
        wanted = row["storage"] == "compressed" and dataset.size * dataset.dtype.itemsize > 1 << 14
        if packed != wanted:
            self.say(dataset.name, f"storage is not {row['storage']}")

    def attributes(self, item, expected: list[dict], extra: set = frozenset()) -> None:
        """Check names and types of all attributes of an object."""
        names = {attribute["name"] for attribute in expected} | extra
        for name in sorted(names ^ set(item.attrs)):
            self.say(item.name, f"attribute {name} missing or not in the schema")
        for attribute in expected:
            name = attribute["name"]
            if name not in item.attrs:
                continue
            stored = item.attrs.get_id(name)
            scalar, count = re.fullmatch(
                r"(\w+)(?:\[(\d+)\])?", attribute["type"]
            ).groups()
            shape = (int(count),) if count else ()
            if stored.shape != shape or not has_type(stored.dtype, {"type": scalar}):
                self.say(item.name, f"attribute {name} is not {attribute['type']}")


def is_scale(item: h5py.Group | h5py.Dataset) -> bool:
    """Whether a dataset is the dimension scale of an axis."""
    return isinstance(item, h5py.Dataset) and item.attrs.get("CLASS") == b"DIMENSION_SCALE"


def scales_of(dataset: h5py.Dataset) -> list[list[h5py.Dataset]]:
    """The scales that a dataset names for each of its axes."""
    axes = dataset.attrs.get("DIMENSION_LIST", [[]] * dataset.ndim)
    return [[dataset.file[reference] for reference in references] for references in axes]


def name_of(file: h5py.File, reference: h5py.Reference) -> str | None:
    """The name of what a reference leads to; nothing for an object that was removed."""
    try:
        return file[reference].name
    except (KeyError, ValueError):
        return None


def axis_attributes(item: h5py.Group | h5py.Dataset) -> set[str]:
    """What names the axes of a dataset."""
    return {"DIMENSION_LIST"} if isinstance(item, h5py.Dataset) and item.shape else set()


def has_type(dtype: np.dtype, row: dict) -> bool:
    """Whether an HDF5 type is the one a row of the schema names."""
    members = h5py.check_enum_dtype(dtype)
    if row["type"] == "enum":
        return members == row["enum"]["members"] and dtype == np.uint8
    if row["type"] == "text":
        text = h5py.check_string_dtype(dtype)
        return text is not None and text.encoding == "utf-8" and text.length is None
    return members is None and dtype == NUMBERS[row["type"]]
