"""An opened run file: a tree of datasets, what they come to, and tables, grids and pictures of it."""

import difflib
import html
import itertools
from pathlib import Path
from typing import Any, Literal

import numpy as np
import pandas as pd
import xarray as xr

from ._matrices import Matrices

#: What panes are told of: name here, the dataset of the last state, the one in a history.
PANES = {
    "pressure": ("solve/multiplier_normal", "multiplier_normal"),
    "friction_stress": ("post/tangential_stress", "multiplier_tangential"),
    "zone": ("post/contact_zone", "contact_zone"),
    "gap": ("post/pane_gap", "gap"),
    "slip": ("post/pane_slip", "slip"),
    "friction": ("post/pane_friction", "friction"),
}


class Run(xr.DataTree):
    """A run file as an ``xarray.DataTree`` whose ``repr`` is a summary; that of xarray is in :attr:`datasets`."""

    __slots__ = ()

    def __getitem__(self, key: Any) -> Any:
        try:
            return super().__getitem__(key)
        except KeyError as error:
            names = [f"{node.path}/{name}".lstrip("/") for node in self.subtree for name in node.data_vars]
            near = difflib.get_close_matches(str(key), names, 4, 0.4)
            hint = f"; near to it are {', '.join(near)}" if near else ""
            raise KeyError(f"there is no {key}{hint}; .datasets lists all") from error

    @property
    def file(self) -> Path:
        """The run file."""
        return Path(self.attrs["file"])

    @property
    def scene(self) -> dict[str, Any]:
        """The scene with every default, as a dict."""
        return self.attrs["scene"]

    @property
    def matrices(self) -> Matrices:
        """The sparse matrices, such as ``assemble/stiffness``; read when asked for."""
        return self.attrs["matrices"]

    @property
    def datasets(self) -> xr.DataTree:
        """The plain tree, which prints every dataset."""
        return xr.DataTree(self.to_dataset(inherit=False), children=dict(self.children))

    @property
    def certificate(self) -> dict[str, float]:
        """The residuals of all conditions; ``open(file, everything=True)`` has them as datasets."""
        from ._tree import open as open_run

        with open_run(self.file, everything=True) as whole:
            whole._demand("post/certificate/equilibrium")
            group = whole["post/certificate"].to_dataset(inherit=False)
            return {str(name): float(value) for name, value in group.data_vars.items() if value.ndim == 0}

    @property
    def summary(self) -> dict[str, str]:
        """The first screen of the run by name, in the words of ``contact3d-pipe status``, of the file as it is now."""
        from ._program import ProgramError, ProgramNotFound, name, perform

        found = {"title": str(self.scene.get("title", ""))} if "scene" in self.attrs else {}
        try:
            told = perform(["status", name(self.file)])
            told.check(self.file)
            found.update(told.data["summary"] or {})
        except (ProgramError, ProgramNotFound) as error:
            found["status"] = str(error)
        if status := self._text("adapt/status"):
            # All there is of a run that was interrupted.
            errors = self["adapt/levels/estimated_error"].values
            found["levels"] = f"{status}: {len(errors)} solved, the last with an error of about {100 * errors[-1]:.2g} %"
        if "history" in self.children and "time" in self.history.dims:
            times = self.history["time"].values
            found["history"] = f"{len(times)} increments, time {times[0]:g} to {times[-1]:g} s"
        return found

    @property
    def forces(self) -> xr.Dataset:
        """Force and moment on the body of each clamp, spring, load and contact face, by its name in the scene."""
        self._demand("post/forces/source")
        return self["post/forces"].to_dataset(inherit=False)

    @property
    def tools(self) -> xr.Dataset:
        """Point, displacement, turn, force and moment of each tool, in the order of the scene."""
        self._demand("post/tools/point")
        return self["post/tools"].to_dataset(inherit=False)

    @property
    def history(self) -> xr.Dataset:
        """The increments of a load history over ``time``."""
        if "history" not in self.children:
            raise ValueError(f"{self.file} has no history: its scene has no [[step]]")
        return self["history"].to_dataset(inherit=False)

    @property
    def n_panes(self) -> int:
        """The panes of all contact faces."""
        return self._size("mesh", "n_panes")

    @property
    def faces(self) -> list[str]:
        """The contact faces by name."""
        if self._has("mesh/contact_face_names"):
            return self._text("mesh/contact_face_names").split("\n")
        contact = self.scene.get("contact")
        only = contact[0] if isinstance(contact, list) else contact
        return [only.get("name") or only.get("face") or only["between"][0]] if only else []

    @property
    def bodies(self) -> list[str]:
        """Several bodies by name; none where there is only one."""
        return self._text("mesh/body_names").split("\n") if self._has("mesh/body_names") else []

    def body(self, name: str) -> xr.Dataset:
        """Displacement, stress and von Mises stress of one of several bodies over its nodes, ``node``, with ``x``, ``y``, ``z`` and the
        ``number`` in the file as coordinates; where materials meet, the stress in the first of them.

        :raises ValueError: no such body, or not solved.
        """
        self._demand("post/nodal_stress")
        start, stop = self._range_of_body("mesh/body_nodes", name)
        stored = {"displacement": self["solve/displacement"], "stress": self["post/nodal_stress"], "von_mises": self["post/von_mises"]}
        found = xr.Dataset()
        for key, values in stored.items():
            own = values.drop_vars([place for place in values.coords if str(place).startswith("node_")])
            own = own.rename({own.dims[0]: "node"})
            found[key] = own.isel(node=slice(start, stop))
        nodes = self["solve"].to_dataset(inherit=False)
        places = {axis: ("node", *_parts(nodes[f"node_{axis}"][start:stop])) for axis in "xyz"}
        return found.assign_coords(number=("node", np.arange(start, stop)), **places)

    def panes(self, face: str | None = None, *, history: bool = False) -> xr.Dataset:
        """Pressure, friction stress, zone, gap, slip, coefficients and area of the panes.

        On a flat face of a brick they are a grid over two of ``x``, ``y``, ``z``, NaN where there is no contact;
        elsewhere they are a row, ``pane``, with these as coordinates.

        :param face: one contact face by name; all by default.
        :param history: every increment, over ``time``, in place of the last state.
        :raises ValueError: no such face, no contact or no history.
        """
        return self._grid(self.row_of_panes(face, history=history), self._plane(face))

    def row_of_panes(self, face: str | None = None, *, history: bool = False) -> xr.Dataset:
        """The same of panes in a row, in the order of the file."""
        if not self.faces:
            raise ValueError(f"{self.file} has no contact")
        self._demand("mesh/pane_x")
        source = self.history if history else None
        found = xr.Dataset()
        for name, (last, each) in PANES.items():
            if source is not None and each in source:
                values = source[each]
                # Multipliers are the stresses on the obstacle.
                found[name] = self._over_panes(values.copy(data=-values.values) if name == "friction_stress" else values)
            elif source is None and self._has(last):
                found[name] = self._over_panes(self[last])
        found["area"] = self._over_panes(self["mesh/pane_area"])
        places = self["mesh"].to_dataset(inherit=False)
        for axis in "xyz":
            found = found.assign_coords({axis: ("pane", *_parts(places[f"pane_{axis}"]))})
        found = found.assign_coords(number=("pane", np.arange(self.n_panes)))
        if len(self.faces) > 1:
            found = found.assign_coords(face=("pane", np.array(self.faces)[self._face_of_panes()]))
        if face is None:
            return found
        if face not in self.faces:
            raise ValueError(f"there is no contact face {face!r}; there are {', '.join(self.faces)}")
        return found.isel(pane=np.flatnonzero(self._face_of_panes() == self.faces.index(face)))

    def plot(self, name: str = "pressure", face: str | None = None, *, time: float | None = None, ax: Any = None,
             **style: Any) -> Any:
        """Draws a figure of the panes with matplotlib: ``pressure``, ``zone``, ``gap``, ``area``, or one of ``slip``,
        ``friction_stress`` and ``friction`` along an axis, as ``"slip.t1"``.

        :param time: the increment of a history nearest to it; the last by default.
        :param style: for ``pcolormesh``, or ``tripcolor`` where panes are no grid.
        """
        from ._plots import draw_panes

        return draw_panes(self, name, face, time, ax, style)

    def to_dataframe(self, what: Literal["panes", "nodes", "forces", "history", "quantities"] = "panes") -> pd.DataFrame:
        """A table of pandas: a row for each pane, node, force, increment of a history, or quantity with its error bar."""
        makers = {
            "panes": self._pane_table,
            "nodes": self._node_table,
            "forces": self._force_table,
            "history": self._history_table,
            "quantities": self._quantity_table,
        }
        if what not in makers:
            raise ValueError(f"expected {', '.join(makers)}, found {what!r}")
        return makers[what]()

    def to_pyvista(self, what: str = "body", *, time: float | None = None) -> Any:
        """A grid of pyvista: the body with its fields, ``displacement``, ``von_mises`` and ``stress`` (xx, yy, zz, xy, yz, xz) among them, or
        the contact faces with what panes have. Nodes where materials meet are points of each: stresses jump there.

        :param what: ``"body"`` for all bodies, ``"contact"``, or the name of one of several bodies.
        :param time: the increment of a history nearest to it; the last by default.
        """
        from ._grids import body, contact

        self._demand("post/von_mises")
        if time is not None:
            time = float(self.history["time"].sel(time=time, method="nearest"))
        makers = {"body": body, "contact": contact}
        if what in makers:
            return makers[what](self, time)
        start, stop = self._range_of_body("mesh/body_tetrahedra", what)
        return body(self, time).extract_cells(np.arange(start, stop))

    def _pane_table(self) -> pd.DataFrame:
        return columns(self.row_of_panes(), "pane")

    def _node_table(self) -> pd.DataFrame:
        self._demand("solve/displacement")
        self._demand("solve/node_x")
        nodes = self["solve"].to_dataset(inherit=False)
        places = {axis: ("node", nodes[f"node_{axis}"].values) for axis in "xyz"}
        displacement = {"displacement": (("node", "axis"), nodes["displacement"].values)}
        moved = xr.Dataset(displacement, {**places, "axis": list("xyz")})
        return columns(moved, "node")

    def _force_table(self) -> pd.DataFrame:
        forces = self.forces
        return columns(forces.assign_coords(axis=list("xyz")), "source")

    def _history_table(self) -> pd.DataFrame:
        history = self.history
        small = {"time", "axis", "friction_axis", "contact_axis", "source", "n_tools"}
        kept = [name for name, value in history.data_vars.items() if "time" in value.dims and small.issuperset(value.dims)]
        return columns(history[kept], "time")

    def _quantity_table(self) -> pd.DataFrame:
        if not self._has("solve/quantities/value"):
            raise ValueError(f"{self.file} has no error bars: it is not solved, or a load history without an error to refine for")
        stored = self["solve/quantities"].to_dataset(inherit=False)
        names = [str(name) for name in stored["name"].values]
        smallest, largest = stored["range"].values.T
        value = stored["value"].values
        signed_error, kinks = stored["signed_error"].values, stored["kinks"].values
        if "largest_von_mises" not in names and self._has("post/largest_von_mises/value"):
            stress, error = (self[f"post/largest_von_mises/{part}"].item() for part in ("value", "error"))
            names.append("largest_von_mises")
            value, signed_error, kinks = np.append(value, stress), np.append(signed_error, error), np.append(kinks, 0)
            smallest, largest = np.append(smallest, max(stress - error, 0.0)), np.append(largest, stress + error)
        units = [_unit(self[IN_THE_UNIT_OF[name]]) if name in IN_THE_UNIT_OF else "" for name in names]
        return pd.DataFrame({"value": value, "error_bar": np.maximum(largest - value, value - smallest),
                             "signed_error": signed_error, "smallest": smallest,
                             "largest": largest, "unit": units, "kinks": kinks},
                            pd.Index(names, name="quantity"))

    def _range_of_body(self, limits: str, name: str) -> tuple[int, int]:
        """First and one past the last of the nodes or tetrahedra of a body."""
        if name not in self.bodies:
            raise ValueError(f"there is no body {name!r}; there are {', '.join(self.bodies) or 'no several bodies'}")
        number = self.bodies.index(name)
        start, stop = self[limits].values[number : number + 2]
        return int(start), int(stop)

    def _over_panes(self, values: xr.DataArray) -> xr.DataArray:
        """Values of panes under the dimension ``pane``; NaN on those without friction."""
        own = [dim for dim in values.dims if dim in ("n_panes", "n_friction_panes")]
        plain = values.drop_vars([name for name in values.coords if str(name).startswith("pane_")], errors="ignore")
        renamed = plain.rename({own[0]: "pane"})
        missing = self.n_panes - renamed.sizes["pane"]
        return renamed.pad(pane=(0, missing)) if missing else renamed

    def _face_of_panes(self) -> np.ndarray:
        if not self._has("mesh/contact_face_panes"):
            return np.zeros(self.n_panes, dtype=int)
        starts = self["mesh/contact_face_panes"].values
        return np.searchsorted(starts, np.arange(self.n_panes), side="right") - 1

    def _grid(self, panes: xr.Dataset, plane: str | None) -> xr.Dataset:
        """Panes of one plane across an axis, over the two others; as they are where there is no such grid."""
        along = [axis for axis in "zyx" if axis != plane]
        index = pd.MultiIndex.from_arrays([_merged(panes[axis].values) for axis in along], names=along)
        if plane is None or index.has_duplicates:
            return panes
        kept = panes.drop_vars([*"xyz", "number"]).assign_coords(xr.Coordinates.from_pandas_multiindex(index, "pane"))
        words = [str(name) for name, values in kept.variables.items() if values.dtype.kind in "UO"]
        missing = {str(name): "" if name in words else np.nan for name in kept.variables}
        grid = kept.unstack("pane", fill_value=missing)
        for axis in along:
            grid = grid.reindex({axis: self._centres(axis, grid[axis].values)}, fill_value=missing)
            grid[axis].attrs.update(panes[axis].attrs)
        return grid.transpose(..., *along).assign_coords({plane: panes[plane][0].variable})

    def _centres(self, axis: str, known: np.ndarray) -> np.ndarray:
        """The centres of panes along an axis of a brick, to the bit those that are known; of nodal multipliers these alone."""
        planes = np.unique(self[f"mesh/node_{axis}"].values)[::2]
        centres = (planes[1:] + planes[:-1]) / 2
        nearest = np.abs(centres[:, None] - known).argmin(axis=0)
        # A centre is a mean of nodes, known to a few roundings of the edge length.
        if not np.allclose(centres[nearest], known, rtol=0.0, atol=1e-12 * np.ptp(planes)):
            return known
        centres[nearest] = known
        return centres

    def _plane(self, face: str | None) -> str | None:
        """The axis across the only plane of a brick that holds the contact faces."""
        if "brick" not in self.scene["body"] or "adapt" in self.scene:
            return None
        contact = self.scene["contact"]
        entries = contact if isinstance(contact, list) else [contact]
        chosen = {entry["face"] for entry in entries if face in (None, entry.get("name") or entry["face"])}
        return chosen.pop()[0] if len(chosen) == 1 else None

    def _has(self, path: str) -> bool:
        group, _, name = path.rpartition("/")
        try:
            return name in self[group].to_dataset(inherit=False)
        except KeyError:
            return False

    def _demand(self, path: str) -> None:
        if not self._has(path):
            why = "it is not solved; contact3d.run brings it up to date"
            if self._has("solve/status"):
                why = "the scene has no panes: nothing may touch, or faces are glued"
            raise ValueError(f"{self.file} has no {path}: {why}")

    def _size(self, group: str, dim: str) -> int:
        return int(self[group].sizes.get(dim, 0)) if group in self.children else 0

    def _number(self, path: str) -> float | None:
        return float(self[path]) if self._has(path) else None

    def _text(self, path: str) -> str:
        return str(self[path].item()) if self._has(path) else ""

    def __repr__(self) -> str:
        if "file" not in self.attrs:
            return repr(self.datasets)
        summary = self.summary
        width = max(map(len, summary), default=0)
        lines = [f"  {name:<{width}}  {words}" for name, words in summary.items()]
        groups = f"  groups: {', '.join(self.children)}; .datasets lists all"
        return "\n".join([f"<contact3d.Run {self.file}>", *lines, groups])

    __str__ = __repr__

    def _repr_html_(self) -> str:
        if "file" not in self.attrs:
            return self.datasets._repr_html_()
        left = "style='text-align:left'"
        cells = ((html.escape(name), html.escape(words)) for name, words in self.summary.items())
        rows = "".join(f"<tr><th {left}>{name}</th><td {left}>{words}</td></tr>" for name, words in cells)
        return (f"<b>{html.escape(str(self.file))}</b><table>{rows}</table>"
                f"<details><summary>datasets</summary>{self.datasets._repr_html_()}</details>")


#: A dataset in the unit of each quantity with an error bar.
IN_THE_UNIT_OF = {
    "normal_force": "post/resultants/normal_force",
    "tangential_force": "post/resultants/normal_force",
    "strain_energy": "post/resultants/strain_energy",
    "dissipation": "post/resultants/strain_energy",
    "largest_pressure": "post/resultants/largest_pressure",
    "mean_pressure": "post/resultants/largest_pressure",
    "largest_von_mises": "post/largest_von_mises/value",
    "peak_displacement": "solve/displacement",
    "mean_displacement": "solve/displacement",
    "contact_area": "mesh/pane_area",
    "stick_area": "mesh/pane_area",
}


def _unit(values: xr.DataArray) -> str:
    unit = str(values.attrs.get("units", ""))
    return "" if unit == "1" else unit


def _merged(places: np.ndarray) -> np.ndarray:
    """Coordinates in which those that differ by rounding are the same: the least of them."""
    known, which = np.unique(places, return_inverse=True)
    # Means of nodes differ by some roundings; panes are much farther apart than a billionth of the face.
    first = np.diff(known, prepend=-np.inf) > 1e-9 * np.ptp(places)
    return known[first][np.cumsum(first) - 1][which]


def _parts(values: xr.DataArray) -> tuple[np.ndarray, dict[str, Any]]:
    return values.values, values.attrs


def columns(data: xr.Dataset, rows: str) -> pd.DataFrame:
    """A column for each component of each variable."""
    table = {str(name): values.values for name, values in data.coords.items() if values.dims == (rows,)}
    for name, values in data.data_vars.items():
        rest = [dim for dim in values.dims if dim != rows]
        flat = values.transpose(rows, *rest).values.reshape(values.sizes[rows], -1)
        labels = [[str(label) for label in values[dim].values] for dim in rest]
        for column, label in zip(flat.T, itertools.product(*labels), strict=True):
            table["_".join([str(name), *label])] = column
    index = table.pop(rows, None)
    return pd.DataFrame(table, index=None if index is None else pd.Index(index, name=rows))
