"""The body and its contact faces as triangles, tetrahedra and grids of pyvista."""

from typing import TYPE_CHECKING, Any

import numpy as np
import xarray as xr

if TYPE_CHECKING:
    from ._run import Run

#: Kinds of cells in VTK; the edges of a quadratic tetrahedron stand in the file in VTK's order.
TETRAHEDRON, QUADRATIC_TETRAHEDRON = 10, 24


def pane_triangles(run: "Run") -> tuple[np.ndarray, np.ndarray]:
    """The corners of triangles of faces with panes [n, 3], and the pane of each [n]; none where multipliers are nodal."""
    mesh = run["mesh"].to_dataset(inherit=False)
    if "contact_facet_pane" not in mesh:
        return np.empty((0, 3), dtype=int), np.empty(0, dtype=int)
    facets = mesh["contact_facets"].values
    if "contact_face_is_nodal" in mesh:
        lengths = np.diff(mesh["contact_face_facets"].values)
        facets = facets[np.repeat(mesh["contact_face_is_nodal"].values == 0, lengths)]
    return mesh["facets"].values[facets], mesh["contact_facet_pane"].values


def body(run: "Run", time: float | None) -> Any:
    """The tetrahedra with displacement, von Mises stress and stress."""
    pyvista = _pyvista()
    mesh = run["mesh"].to_dataset(inherit=False)
    tetrahedra, kind = mesh["tetrahedra"].values, TETRAHEDRON
    if "tetrahedron_mid_edges" in mesh:
        tetrahedra, kind = np.hstack([tetrahedra, mesh["tetrahedron_mid_edges"].values]), QUADRATIC_TETRAHEDRON
    grid = pyvista.UnstructuredGrid({kind: tetrahedra}, mesh["coordinates"].values)
    state = _state(run, time)
    grid.point_data["displacement"] = state["displacement"].values
    grid.cell_data["von_mises"] = state["von_mises"].values
    if time is None:
        grid.cell_data["stress"] = run["post/stress"].values
    if "tetrahedron_region" in mesh:
        grid.cell_data["region"] = mesh["tetrahedron_region"].values
    return grid


def contact(run: "Run", time: float | None) -> Any:
    """The triangles of the contact faces with the figures of their panes; points where multipliers are nodal."""
    pyvista = _pyvista()
    figures = run.row_of_panes(history=time is not None)
    if time is not None:
        figures = figures.sel(time=time, method="nearest")
    triangles, panes = pane_triangles(run)
    if len(triangles):
        surface = pyvista.PolyData.from_regular_faces(run["mesh/coordinates"].values, triangles).clean()
        target = surface.cell_data
    else:
        surface = pyvista.PolyData(np.column_stack([figures[axis].values for axis in "xyz"]))
        target, panes = surface.point_data, np.arange(run.n_panes)
    for name, values in figures.data_vars.items():
        target[str(name)] = values.transpose("pane", ...).values[panes]
    return surface


def _state(run: "Run", time: float | None) -> xr.Dataset:
    if time is None:
        return xr.Dataset({"displacement": run["solve/displacement"].variable, "von_mises": run["post/von_mises"].variable})
    return run.history[["displacement", "von_mises"]].sel(time=time, method="nearest")


def _pyvista() -> Any:
    try:
        import pyvista
    except ImportError:
        raise ImportError("grids need pyvista: pip install 'contact3d-pipe[pyvista]'") from None
    return pyvista
