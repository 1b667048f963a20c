"""The body and its contact faces as triangles, tetrahedra and grids of pyvista."""

from typing import TYPE_CHECKING, Any

import h5py
import numpy as np

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
    """The tetrahedra with all fields that the results have on points and tetrahedra, and the stress. A node where materials meet is a point of
    each, with the stress there."""
    pyvista = _pyvista()
    mesh = run["mesh"].to_dataset(inherit=False)
    tetrahedra, kind = mesh["tetrahedra"].values, TETRAHEDRON
    if "tetrahedron_mid_edges" in mesh:
        tetrahedra, kind = np.hstack([tetrahedra, mesh["tetrahedron_mid_edges"].values]), QUADRATIC_TETRAHEDRON
    with h5py.File(run.file) as file:
        points = file["VTKHDF/Points"][:]
        corners = file["VTKHDF/Connectivity"][: tetrahedra.size].reshape(tetrahedra.shape)
    grid = pyvista.UnstructuredGrid({kind: corners}, points)
    on_points, on_cells = fields(run, time)
    grid.point_data.update(on_points)
    for name, values in on_cells.items():
        # Contact triangles are behind the tetrahedra; what they alone have is a field of the contact faces.
        if not np.isnan(values[: len(tetrahedra)]).all():
            grid.cell_data[name] = values[: len(tetrahedra)]
    if time is None:
        # The order of VTK.
        grid.point_data["stress"] = run["post/nodal_stress"].values[:, [0, 1, 2, 5, 3, 4]]
    if "tetrahedron_region" in mesh:
        grid.cell_data["region"] = mesh["tetrahedron_region"].values
    return grid


def fields(run: "Run", time: float | None) -> tuple[dict[str, np.ndarray], dict[str, np.ndarray]]:
    """The fields that ParaView reads, on points and on cells, by name: of the increment of a history nearest to a time, or the last."""
    with h5py.File(run.file) as file:
        grid = file["VTKHDF"]
        times = grid["Steps/Values"][:] if "Steps" in grid else np.zeros(1)
        step = len(times) - 1 if time is None else int(np.abs(times - time).argmin())

        def at_step(group: str, size: str) -> dict[str, np.ndarray]:
            rows = int(grid[size][0])
            found = grid[group].items() if group in grid else ()
            return {name: values[step * rows : (step + 1) * rows] for name, values in found
                    if not values.is_scale and len(values) == rows * len(times)}

        return at_step("PointData", "NumberOfPoints"), at_step("CellData", "NumberOfCells")


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


def _pyvista() -> Any:
    try:
        import pyvista
    except ImportError:
        raise ImportError("grids need pyvista: pip install pyvista") from None
    return pyvista
