"""Groups of HDF5 files as datasets of xarray whose values are read when they are used."""

from pathlib import Path
from typing import Any

import h5py
import numpy as np
import xarray as xr
from xarray.backends.common import BackendArray
from xarray.core.indexing import ExplicitIndexer, IndexingSupport, LazilyIndexedArray, explicit_indexing_adapter

#: Attributes that HDF5 and netCDF need, and people do not.
PLUMBING = ("CLASS", "NAME", "DIMENSION_LIST", "REFERENCE_LIST", "_Netcdf4Dimid", "_Netcdf4Coordinates", "_FillValue")
WITHOUT_VALUES = b"This is a netCDF dimension but not a netCDF variable"


class Stored(BackendArray):
    """A dataset in an open file: numbers, or the members of an enumeration as words. A pickled one opens the file anew."""

    def __init__(self, dataset: h5py.Dataset, file: Path):
        self.dataset, self.file = dataset, file
        members = h5py.check_enum_dtype(dataset.dtype)
        self.words = np.array(_by_code(members)) if members else None
        self.shape = dataset.shape
        self.dtype = dataset.dtype if self.words is None else self.words.dtype

    def __getitem__(self, key: ExplicitIndexer) -> np.ndarray:
        return explicit_indexing_adapter(key, self.shape, IndexingSupport.BASIC, self._read)

    def _read(self, key: tuple[int | slice, ...]) -> np.ndarray:
        backward = tuple(isinstance(part, slice) and (part.step or 1) < 0 for part in key)
        values = np.asarray(self.dataset[()][key] if any(backward) else self.dataset[key])
        return values if self.words is None else self.words[values]

    def __reduce__(self) -> tuple[Any, ...]:
        return reopened, (self.file, self.dataset.name)


class Closing:
    """Closes a file; what is sent to another process has none to close."""

    def __init__(self, file: h5py.File | None):
        self.file = file

    def __call__(self) -> None:
        if self.file is not None:
            self.file.close()

    def __reduce__(self) -> tuple[Any, ...]:
        return Closing, (None,)


def reopened(file: Path, name: str) -> Stored:
    """A dataset of a file that is opened for it."""
    return Stored(h5py.File(file)[name], file)


def dataset(group: h5py.Group, file: Path) -> xr.Dataset:
    """A group, with dimensions by the names of their scales."""
    stored = {name: item for name, item in group.items() if isinstance(item, h5py.Dataset)}
    variables = {name: variable(item, file) for name, item in stored.items() if not _is_bare(item)}
    return xr.Dataset(variables, attrs=_attributes(group))


def variable(item: h5py.Dataset, file: Path) -> xr.Variable:
    """One dataset."""
    values: Any
    if h5py.check_string_dtype(item.dtype):
        values = np.asarray(item.asstr()[()], dtype=str)
    else:
        values = LazilyIndexedArray(Stored(item, file))
    return xr.Variable(_dimensions(item), values, _attributes(item))


def _dimensions(item: h5py.Dataset) -> list[str]:
    """The names of scales; of axes without one, as in files of old formats, their length."""
    if item.is_scale:
        return [_last(item.name)]
    scales = [list(axis.values()) for axis in item.dims]
    names = [_last(found[0].name) if found else f"n_{length}" for found, length in zip(scales, item.shape, strict=True)]
    return [f"{name}_{k + 1}" if name in names[:k] else name for k, name in enumerate(names)]


def _by_code(members: dict[str, int]) -> list[str]:
    """The words of an enumeration, each at its code."""
    words = {code: word for word, code in members.items()}
    return [words.get(code, "") for code in range(max(words) + 1)]


def _last(path: str) -> str:
    return path.rpartition("/")[2]


def _is_bare(item: h5py.Dataset) -> bool:
    return item.is_scale and bytes(item.attrs.get("NAME", b"")).startswith(WITHOUT_VALUES)


def _attributes(item: h5py.HLObject) -> dict[str, Any]:
    return {name: _plain(item.attrs[name]) for name in item.attrs if name not in PLUMBING}


def _plain(value: Any) -> Any:
    """Texts as texts, and the only number of an array by itself."""
    if isinstance(value, bytes):
        return value.decode()
    return value.item() if isinstance(value, np.ndarray) and value.size == 1 else value
