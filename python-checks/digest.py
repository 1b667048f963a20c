"""The digests of a run file, from their description in crates/runfile/src/digest.rs.

A dataset: BLAKE3 of the name of its type, a zero byte, its rank and each extent as u64,
then its values. A text: its length in bytes as u64, then UTF-8. A matrix: its number of
entries as u64, then indptr, indices and data. All numbers are little endian.

A file begins with 512 bytes, which hold its type and the BLAKE3 of all bytes that follow.
"""

import struct
from pathlib import Path

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


USER_BLOCK = 512
"""Bytes before those of HDF5."""


def fits_digest(path: Path) -> bool:
    """Whether a file is as it was written."""
    content = path.read_bytes()
    return content == with_digest(content)


def renew_digest(path: Path) -> None:
    """Give a file that h5py has changed and closed the digest of its bytes."""
    path.write_bytes(with_digest(path.read_bytes()))


def with_digest(content: bytes) -> bytes:
    """The bytes of a file behind the user block that fits them."""
    filetype = content[: content.index(b"\n") + 1]
    digest = blake3(content[USER_BLOCK:]).hexdigest()
    text = filetype + f"BLAKE3 of all bytes from {USER_BLOCK} on:\n{digest}\n".encode()
    return text.ljust(USER_BLOCK, b"\0") + content[USER_BLOCK:]


def little_endian(values: np.ndarray) -> bytes:
    """The bytes of an array in row-major order, little endian."""
    values = np.asarray(values)
    return values.astype(values.dtype.newbyteorder("<")).tobytes()
