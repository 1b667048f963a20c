"""Run files as xarray trees."""

import os
import tomllib
from collections.abc import Iterator, Mapping
from contextlib import ExitStack
from pathlib import Path

import h5py
import numpy as np
import scipy.sparse
import xarray as xr


class Matrices(Mapping[str, scipy.sparse.csc_array | scipy.sparse.csr_array]):
    """The sparse matrices of a run file by their path, such as ``assemble/stiffness``; read when asked for."""

    def __init__(self, file: str | os.PathLike[str]):
        self.file = Path(file)
        with h5py.File(self.file) as content:
            self._paths: list[str] = []
            _visit(content, lambda path, item: self._paths.append(path) if _is_matrix(item) else None)

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


def open(file: str | os.PathLike[str]) -> xr.DataTree:
    """A run file as a tree of datasets with named dimensions and, in ``attrs["units"]``, words that pint understands.

    Values are read when they are used. Enumerations are texts, panes and nodes carry their places as coordinates
    (``pane_x``, ``node_x``, ``contact_x`` …), ``tree.attrs["scene"]`` is the scene as a dict and
    ``tree.attrs["matrices"]`` a mapping of SciPy's sparse matrices (:class:`Matrices`).
    """
    file = Path(file)
    matrices = Matrices(file)
    with h5py.File(file) as content, ExitStack() as opened:
        places = _places(content, matrices)
        nodes = {}
        for path, group in _groups(content):
            # In the file that holds the group: references to the scales of its axes lead nowhere in another one.
            dataset = xr.open_dataset(group.file.filename, group=group.name, engine="h5netcdf", phony_dims="access",
                                      decode_times=False, decode_timedelta=False)
            opened.callback(dataset.close)
            nodes[path] = _with_places(_with_words(dataset, group), places)
        named = xr.DataTree.from_dict(nodes)
        if "scene/toml" in content:
            named.attrs["scene"] = tomllib.loads(content["scene/toml"].asstr()[()])
        named.set_close(opened.pop_all().close)
    named.attrs["matrices"] = matrices
    return named


def _groups(content: h5py.File) -> list[tuple[str, h5py.Group]]:
    """All groups but matrices with their paths, groups behind external links too."""
    found = [("/", content["/"])]
    for path, group in found:
        inner = [(name, item) for name, item in group.items() if isinstance(item, h5py.Group) and not _is_matrix(item)]
        found += [(f"{path.rstrip('/')}/{name}", item) for name, item in inner]
    return found


def _visit(group: h5py.Group, see) -> None:
    """Shows every object below a group, groups behind external links too."""
    for name, item in group.items():
        see(item.name.strip("/"), item)
        if isinstance(item, h5py.Group) and not _is_matrix(item):
            _visit(item, see)


def _is_matrix(item: h5py.HLObject) -> bool:
    return isinstance(item, h5py.Group) and "encoding-type" in item.attrs


def _with_words(dataset: xr.Dataset, group: h5py.Group) -> xr.Dataset:
    """The dataset with the members of enumerations by their names."""
    words = {}
    for name, variable in dataset.variables.items():
        members = h5py.check_enum_dtype(group[name].dtype) if name in group else None
        if members:
            names = np.empty(max(members.values()) + 1, dtype=object)
            for word, code in members.items():
                names[code] = word
            texts = names[np.asarray(group[name][()])]
            words[name] = (variable.dims, np.asarray(texts, dtype=str), variable.attrs)
    return dataset.assign(words)


def _places(content: h5py.File, matrices: Matrices) -> dict[str, xr.Variable]:
    """The places of nodes, contact nodes and panes, as coordinates."""
    if "mesh/coordinates" not in content:
        return {}
    stored = content["mesh/coordinates"]
    unit = {"units": stored.attrs["units"]}
    nodes = stored[:]
    points = {"node": ("n_nodes", nodes)}
    if "mesh/contact_nodes" in content:
        contact = nodes[content["mesh/contact_nodes"][:]]
        points["contact"] = ("n_contact_nodes", contact)
        points["pane"] = ("n_panes", matrices["mesh/pane_average"].T @ contact)
    return {
        f"{what}_{axis}": xr.Variable(dimension, values[:, c], unit)
        for what, (dimension, values) in points.items()
        for c, axis in enumerate("xyz")
    }


def _with_places(dataset: xr.Dataset, places: dict[str, xr.Variable]) -> xr.Dataset:
    fitting = {name: place for name, place in places.items() if dataset.sizes.get(place.dims[0]) == place.size}
    return dataset.assign_coords(fitting)
