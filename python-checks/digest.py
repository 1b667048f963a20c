"""The digests of a run file, from their description in crates/runfile/src/digest.rs.

A dataset: BLAKE3 of the name of its type, a zero byte, its rank and each extent as u64,
then its values. A text: its length in bytes as u64, then UTF-8. A matrix: its number of
entries as u64, then indptr, indices and data. All numbers are little endian.

Seals, from crates/runfile/src/seal.rs, cover attributes: in the order of their names, each
with its extents, texts by length and UTF-8, numbers as f64 or i64, references by name alone.
"""

import struct

import h5py
import numpy as np
from blake3 import blake3


def dataset_digest(item: h5py.Group | h5py.Dataset, kind: str) -> str:
    """The digest of one dataset or matrix group."""
    hasher = blake3(kind.encode() + b"\0")
    is_matrix = isinstance(item, h5py.Group)
    shape = item.attrs["shape"] if is_matrix else item.shape
    hasher.update(struct.pack(f"<{1 + len(shape)}Q", len(shape), *shape))
    if is_matrix:
        hasher.update(struct.pack("<Q", item["data"].size))
        for part in ("indptr", "indices", "data"):
            hasher.update(little_endian(item[part][:]))
    elif kind == "text":
        for text in np.ravel(item[()]):
            hasher.update(struct.pack("<Q", len(text)) + text)
    else:
        hasher.update(little_endian(item[()]))
    return hasher.hexdigest()


def stage_digest(digests: dict[str, str], units: str) -> str:
    """The digest of a stage from the paths and digests of its datasets, and its attribute `units`."""
    hasher = blake3()
    for path in sorted(digests, key=str.encode):
        hasher.update(path.encode() + b"\0" + digests[path].encode() + b"\0")
    hasher.update(units.encode() + b"\0")
    return hasher.hexdigest()


def input_digest(stage: str, settings: str, upstream: list[str]) -> str:
    """The digest of what a stage is computed from: settings, upstream digests."""
    return blake3((stage + settings + "".join(upstream)).encode()).hexdigest()


def group_seal(group: h5py.Group) -> str:
    """The seal of a stage: all attributes in it, the names and the extents of its datasets."""
    hasher = blake3()
    _add_group(hasher, group)
    return hasher.hexdigest()


def root_seal(file: h5py.File) -> str:
    """The seal of a root: its attributes, and the seals of the groups that it holds itself."""
    hasher = blake3()
    _add_attributes(hasher, file)
    for name in _members(file):
        _add_text(hasher, name.encode())
        if "seal" in file[name].attrs:
            _add_text(hasher, file[name].attrs["seal"].encode())
    return hasher.hexdigest()


def _add_group(hasher: blake3, group: h5py.Group) -> None:
    _add_attributes(hasher, group)
    for name in _members(group):
        _add_text(hasher, name.encode())
        item = group[name]
        if isinstance(item, h5py.Group):
            _add_group(hasher, item)
            continue
        _add_attributes(hasher, item)
        hasher.update(struct.pack(f"<{item.ndim}Q", *item.shape))
        is_scale = item.attrs.get("CLASS") == b"DIMENSION_SCALE"
        if is_scale and h5py.check_string_dtype(item.dtype):
            for label in item[:]:
                _add_text(hasher, label)


def _add_attributes(hasher: blake3, item: h5py.Group | h5py.Dataset) -> None:
    for name in sorted(set(item.attrs) - {"seal"}, key=str.encode):
        _add_text(hasher, name.encode())
        stored = item.attrs.get_id(name)
        hasher.update(struct.pack(f"<{len(stored.shape)}Q", *stored.shape))
        kind = stored.get_type()
        if isinstance(kind, h5py.h5t.TypeStringID):
            for text in np.ravel(item.attrs[name]):
                _add_text(hasher, text if isinstance(text, bytes) else str(text).encode())
        elif isinstance(kind, h5py.h5t.TypeFloatID):
            hasher.update(little_endian(np.asarray(item.attrs[name], "f8")))
        elif isinstance(kind, h5py.h5t.TypeIntegerID):
            hasher.update(little_endian(np.asarray(item.attrs[name], "i8")))


def _members(group: h5py.Group) -> list[str]:
    """The names of what a group holds itself."""
    names = (name for name in group if isinstance(group.get(name, getlink=True), h5py.HardLink))
    return sorted(names, key=str.encode)


def _add_text(hasher: blake3, text: bytes) -> None:
    hasher.update(struct.pack("<Q", len(text)) + text)


def little_endian(values: np.ndarray) -> bytes:
    """The bytes of an array in row-major order, little endian."""
    values = np.asarray(values)
    return values.astype(values.dtype.newbyteorder("<")).tobytes()
