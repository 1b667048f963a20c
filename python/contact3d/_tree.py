"""Run files as xarray trees."""

import os
import tomllib
from collections.abc import Iterable
from pathlib import Path
from typing import Any

import h5py
import xarray as xr

from ._matrices import Matrices, is_matrix
from ._run import Run
from ._stored import Closing, dataset

#: Groups that few want to see: what ParaView reads, and residuals.
APART = ("/VTKHDF", "/post/certificate")


def open(file: str | os.PathLike[str], *, everything: bool = False) -> Run:
    """A run file as a tree of datasets with named dimensions and, in ``attrs["units"]``, words that pint understands.

    Values are read when they are used. Enumerations are texts, panes and nodes carry their places as coordinates
    (``pane_x``, ``node_x``, ``contact_x`` …), increments of a history their ``time`` and forces their ``source``, which
    is the name of a clamp or load in the scene where it has one.

    :param everything: the groups ``VTKHDF`` and ``post/certificate`` too.
    """
    file = Path(file)
    if file.is_dir():
        raise IsADirectoryError(f"{file} is a folder; contact3d.open_sweep opens that of a sweep")
    if not file.is_file():
        raise FileNotFoundError(f"there is no run file {file}; contact3d.run makes one")
    if not h5py.is_hdf5(file):
        raise OSError(f"{file} is no run file: it is no HDF5 file, or a damaged one")
    try:
        matrices = Matrices(file)
        content = h5py.File(file)
    except OSError as error:
        raise OSError(f"{file} is no whole run file: {error}; delete or restore it, and run again") from error
    try:
        places = _places(content, matrices)
        scene = tomllib.loads(content["scene/toml"].asstr()[()]) if "scene/toml" in content else None
        nodes = {
            path: _with_labels(path, _with_places(dataset(group, file), places), content, scene or {})
            for path, group in _groups(content)
            if everything or not path.startswith(APART)
        }
        tree = xr.DataTree.from_dict(nodes)
    except BaseException:
        content.close()
        raise
    run = Run(tree.to_dataset(inherit=False), children=dict(tree.children))
    run.set_close(Closing(content))
    run.attrs["file"] = str(file)
    if scene is not None:
        run.attrs["scene"] = scene
    run.attrs["matrices"] = matrices
    return run


def _groups(content: h5py.File) -> list[tuple[str, h5py.Group]]:
    """All groups but matrices with their paths, groups behind external links too."""
    found = [("/", content["/"])]
    for path, group in found:
        inner = [(name, item) for name, item in group.items() if isinstance(item, h5py.Group) and not is_matrix(item)]
        found += [(f"{path.rstrip('/')}/{name}", item) for name, item in inner]
    return found


def _places(content: h5py.File, matrices: Matrices) -> dict[str, xr.Variable]:
    """The places of nodes, also in each of their materials, of contact nodes and of panes, as coordinates."""
    if "mesh/coordinates" not in content:
        return {}
    stored = content["mesh/coordinates"]
    unit = {"units": stored.attrs["units"]}
    nodes = stored[:]
    material = content["post/material_nodes"][:, 0] if "post/material_nodes" in content else slice(None)
    points = {"node": ("n_nodes", nodes), "material_node": ("n_material_nodes", nodes[material])}
    if "mesh/contact_nodes" in content:
        contact = nodes[content["mesh/contact_nodes"][:]]
        points["contact"] = ("n_contact_nodes", contact)
        points["pane"] = ("n_panes", matrices["mesh/pane_average"].T @ contact)
    return {
        f"{what}_{axis}": xr.Variable(dimension, values[:, c], unit)
        for what, (dimension, values) in points.items()
        for c, axis in enumerate("xyz")
    }


def _with_places(values: xr.Dataset, places: dict[str, xr.Variable]) -> xr.Dataset:
    fitting = {name: place for name, place in places.items() if values.sizes.get(place.dims[0]) == place.size}
    return values.assign_coords(fitting)


def _with_labels(path: str, values: xr.Dataset, content: h5py.File, scene: dict[str, Any]) -> xr.Dataset:
    """A group with increments by their time and forces by their source."""
    if path.startswith("/post") and "source" in values.dims:
        values = values.rename({"source": "resultant"})
    if "n_forces" in values.dims and "post/forces/source" in content:
        keys = content["post/forces/source"].asstr()[:]
        named = values.drop_vars(["source", "face"], errors="ignore").rename({"n_forces": "source"})
        faces = content["post/forces/face"].asstr()[:]
        values = named.assign_coords(source=_names(list(keys), faces, scene), key=("source", keys), face=("source", faces))
    if path == "/history" and "n_increments" in values.dims and "time" in values:
        values = values.rename({"n_increments": "increment"}).swap_dims(increment="time").set_coords("time")
    return values


def _names(keys: list[str], faces: Iterable[str], scene: dict[str, Any]) -> list[str]:
    """What the scene calls its clamps, loads and contacts, or their keys: with these where several have the name, with the face on both of a pair."""
    names = [str(_entry(key, scene).get("name") or key) for key in keys]
    called = [len({key for other, key in zip(names, keys, strict=True) if other == name}) for name in names]
    names = [f"{name} ({key})" if n > 1 else name for name, key, n in zip(names, keys, called, strict=True)]
    return [f"{name} on {face}" if keys.count(key) > 1 else name for name, key, face in zip(names, keys, faces, strict=True)]


def _entry(key: str, scene: dict[str, Any]) -> dict[str, Any]:
    kind, _, number = key.partition(".")
    found = scene.get(kind, {})
    if isinstance(found, list):
        found = found[int(number or 0)] if int(number or 0) < len(found) else {}
    return found if isinstance(found, dict) else {}
