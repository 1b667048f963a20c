"""The sparse matrices of a run file."""

import os
from collections.abc import Callable, Iterator, Mapping
from pathlib import Path

import h5py
import scipy.sparse


class Matrices(Mapping[str, scipy.sparse.csc_array | scipy.sparse.csr_array]):
    """The sparse matrices of a run file by their path, such as ``assemble/stiffness``; read when asked for."""

    def __init__(self, file: str | os.PathLike[str]):
        self.file = Path(file)
        with h5py.File(self.file) as content:
            self._paths: list[str] = []
            visit(content, lambda path, item: self._paths.append(path) if is_matrix(item) else None)

    def __getitem__(self, path: str) -> scipy.sparse.csc_array | scipy.sparse.csr_array:
        path = path.strip("/")
        if path not in self._paths:
            raise KeyError(path)
        with h5py.File(self.file) as content:
            stored = content[path]
            parts = tuple(stored[name][:] for name in ("data", "indices", "indptr"))
            kinds = {"csc_matrix": scipy.sparse.csc_array, "csr_matrix": scipy.sparse.csr_array}
            return kinds[stored.attrs["encoding-type"]](parts, shape=tuple(stored.attrs["shape"]))

    def __iter__(self) -> Iterator[str]:
        return iter(self._paths)

    def __len__(self) -> int:
        return len(self._paths)

    def __repr__(self) -> str:
        return f"Matrices({', '.join(self._paths)})"


def visit(group: h5py.Group, see: Callable[[str, h5py.HLObject], None]) -> None:
    """Shows every object below a group, groups behind external links too."""
    for item in group.values():
        see(item.name.strip("/"), item)
        if isinstance(item, h5py.Group) and not is_matrix(item):
            visit(item, see)


def is_matrix(item: h5py.HLObject) -> bool:
    return isinstance(item, h5py.Group) and "encoding-type" in item.attrs
