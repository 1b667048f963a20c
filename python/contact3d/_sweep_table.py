"""Tables of sweeps as datasets over their axes."""

import json
import os
from collections.abc import Hashable, Sequence
from pathlib import Path
from typing import Any

import h5py
import numpy as np
import pandas as pd
import xarray as xr

from ._run import columns
from ._tree import open as open_run

SUMMARY = "summary.h5"


class SweepTable(xr.Dataset):
    """The results of a sweep: an ``xarray.Dataset`` with a dimension for each axis, and others for components of vectors."""

    __slots__ = ()

    def to_dataframe(self, dim_order: Sequence[Hashable] | None = None) -> pd.DataFrame:
        """A row for each case: its keys, then its results, vectors with a column for each component, as ``contact_force_x``.

        :param dim_order: the axes, of which the last changes fastest; those of the sweep by default.
        """
        chosen = [name for name, values in self.coords.items() if "key" in values.attrs and values.ndim == 0]
        whole = self.expand_dims(chosen)
        axes = [*chosen, *(dim_order or (dim for dim in self.dims if "key" in self[dim].attrs))]
        of_cases = [name for name, values in whole.data_vars.items() if set(axes) <= set(values.dims)]
        cases = whole[of_cases].stack({"case": axes}, create_index=False)
        if "id" in cases:
            cases = cases.isel(case=np.flatnonzero(cases["id"].values != ""))
        return columns(cases, "case")


def open_sweep(folder: str | os.PathLike[str]) -> SweepTable:
    """The results of a sweep, one dimension for each of its axes.

    Keys that change together share the dimension of the first of them. Values that are no numbers are JSON texts. Cases
    that have not been run are NaN, or -1 where a count is meant. Cases of earlier axes are left out.
    """
    file = Path(folder) / SUMMARY
    if not file.is_file():
        raise FileNotFoundError(f"there is no table {file}; contact3d.sweep makes one")
    table = open_run(file)["cases"].to_dataset(inherit=False).load()
    with h5py.File(file) as content:
        keys = [str(key) for key in content["cases/keys"].asstr()[:]]
        units = dict(zip(keys, content["cases/key_unit"].asstr()[:]))
    cases = table.isel(n_cases=np.flatnonzero(table["planned"].values == 1))
    settings = [json.loads(str(text)) for text in cases["settings"].values]
    axes = _axes(keys, settings)
    results = cases.drop_vars([name for name in ("planned", "settings", "setting_value", "keys", "key_unit") if name in cases])
    shape = tuple(len(values) for _, values, _ in axes)
    place = np.zeros(len(settings), dtype=int)
    for _, values, codes in axes:
        place = place * len(values) + codes
    if len(set(place)) != len(settings):
        raise ValueError(f"{folder}: two cases have the same values of {', '.join(keys)}")
    dimensions = [names[0] for names, _, _ in axes]
    dataset = SweepTable(attrs=dict(table.attrs))
    for name, variable in results.variables.items():
        if "n_cases" not in variable.dims:
            dataset[name] = variable
            continue
        ordered = variable.transpose("n_cases", ...)
        values = _blank(ordered, int(np.prod(shape)))
        values[place] = ordered.values
        dims = (*dimensions, *ordered.dims[1:])
        dataset[name] = xr.Variable(dims, values.reshape(*shape, *ordered.shape[1:]), variable.attrs)
    for name, dimension in {"face_names": "n_case_faces", "quantity_names": "n_case_quantities"}.items():
        if name in dataset:
            dataset = dataset.assign_coords({dimension: dataset[name].values})
    for names, values, _ in axes:
        for position, name in enumerate(names):
            column = _column([row[position] for row in values])
            unit = {"units": str(units[name])} if name in units else {}
            dataset = dataset.assign_coords({name: (names[0], column, {"key": name, **unit})})
    return dataset


def _axes(keys: list[str], settings: list[dict[str, Any]]) -> list[tuple[list[str], list[tuple[Any, ...]], np.ndarray]]:
    """The keys that change together, their rows of values in the order of the cases, and each case's row."""
    columns = {key: [json.dumps(case.get(key)) for case in settings] for key in keys}
    groups: list[list[str]] = []
    for key in keys:
        partners = [group for group in groups if _change_together(columns[group[0]], columns[key])]
        if partners:
            partners[0].append(key)
        else:
            groups.append([key])
    axes = []
    for group in groups:
        rows = list(zip(*(columns[key] for key in group), strict=True))
        distinct = list(dict.fromkeys(rows))
        codes = np.array([distinct.index(row) for row in rows], dtype=int)
        axes.append((group, [tuple(json.loads(text) for text in row) for row in distinct], codes))
    return axes


def _change_together(first: list[str], second: list[str]) -> bool:
    pairs = set(zip(first, second, strict=True))
    return len(pairs) == len(set(first)) == len(set(second)) > 1


def _blank(variable: xr.Variable, rows: int) -> np.ndarray:
    shape = (rows, *variable.shape[1:])
    if variable.dtype.kind == "f":
        return np.full(shape, np.nan)
    if variable.dtype.kind in "iu":
        return np.full(shape, -1, dtype=np.int64)
    return np.full(shape, "", dtype=object)


def _column(values: list[Any]) -> list[Any]:
    """Numbers as they are, anything else as JSON."""
    numbers = all(isinstance(value, (int, float)) and not isinstance(value, bool) for value in values)
    return values if numbers else [value if isinstance(value, str) else json.dumps(value) for value in values]
