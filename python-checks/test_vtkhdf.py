"""The same file through ParaView's own reader."""

import h5py
import numpy as np
import pytest
from vtkmodules.util.numpy_support import vtk_to_numpy
from vtkmodules.vtkIOHDF import vtkHDFReader

import contact3d as package
from conftest import ROOT

TETRAHEDRON, TRIANGLE = 10, 5
CONTACT_FIELDS = {
    "contact_gap": "pane_gap",
    "contact_zone": "contact_zone",
}


def read(run):
    """The unstructured grid that vtkHDFReader makes of a file."""
    reader = vtkHDFReader()
    errors = []
    reader.AddObserver("ErrorEvent", lambda *_: errors.append("error"))
    assert reader.CanReadFile(run.filename)
    reader.SetFileName(run.filename)
    reader.Update()
    output = reader.GetOutputDataObject(0)
    assert not errors
    assert output.GetClassName() == "vtkUnstructuredGrid"
    return output


@pytest.fixture(scope="module")
def grid(run):
    """That of the file."""
    return read(run)


def cell_field(grid, name: str) -> np.ndarray:
    """A cell array of the grid."""
    return vtk_to_numpy(grid.GetCellData().GetArray(name))


def test_sizes_and_cell_types(run, grid):
    n_tetrahedra = run["mesh/tetrahedra"].shape[0]
    n_triangles = run["mesh/contact_facets"].shape[0]
    assert grid.GetNumberOfPoints() == run["mesh/coordinates"].shape[0]
    assert grid.GetNumberOfCells() == n_tetrahedra + n_triangles
    types = [grid.GetCellType(i) for i in range(grid.GetNumberOfCells())]
    assert types == [TETRAHEDRON] * n_tetrahedra + [TRIANGLE] * n_triangles


def test_points_and_cells(run, grid):
    points = vtk_to_numpy(grid.GetPoints().GetData())
    assert np.array_equal(points, run["mesh/coordinates"][:])
    nodes = vtk_to_numpy(grid.GetCells().GetConnectivityArray())
    tetrahedra = run["mesh/tetrahedra"][:]
    triangles = run["mesh/facets"][:][run["mesh/contact_facets"][:]]
    assert np.array_equal(nodes[: tetrahedra.size], tetrahedra.ravel())
    assert np.array_equal(nodes[tetrahedra.size :], triangles.ravel())


def test_displacement(run, grid):
    field = vtk_to_numpy(grid.GetPointData().GetArray("displacement"))
    assert np.array_equal(field, run["solve/displacement"][:])


def test_only_the_promised_fields(grid):
    cells = grid.GetCellData()
    names = {cells.GetArrayName(i) for i in range(cells.GetNumberOfArrays())}
    others = {
        "error_indicator",
        "contact_pressure",
        "friction_stress",
        "friction_1",
        "friction_2",
    }
    assert names == CONTACT_FIELDS.keys() | others
    points = grid.GetPointData()
    names = {points.GetArrayName(i) for i in range(points.GetNumberOfArrays())}
    assert names == {"displacement", "von_mises", "stress"}


def test_stresses_live_on_points(run, grid):
    points = grid.GetPointData()
    assert np.array_equal(vtk_to_numpy(points.GetArray("von_mises")), run["post/von_mises"][:])
    # VTK has xx, yy, zz, xy, yz, xz.
    stress = vtk_to_numpy(points.GetArray("stress"))
    assert np.array_equal(stress[:, [0, 1, 2, 4, 5, 3]], run["post/nodal_stress"][:])


def test_materials_that_meet_have_points_of_their_own(contact3d, tmp_path):
    file = tmp_path / "run.h5"
    contact3d("run", ROOT / "pipelines" / "regions.toml", file, "--no-figures", "--set", "body.brick.cells=[6,2,4]")
    with h5py.File(file) as run:
        nodes, regions = run["post/material_nodes"][:].T
        grid = read(run)
        points = vtk_to_numpy(grid.GetPoints().GetData())
        assert len(nodes) > len(run["mesh/coordinates"])
        assert np.array_equal(points, run["mesh/coordinates"][:][nodes])
        assert np.array_equal(vtk_to_numpy(grid.GetPointData().GetArray("displacement")), run["solve/displacement"][:][nodes])
        tetrahedra, region = run["mesh/tetrahedra"][:], run["mesh/tetrahedron_region"][:]
        triangles = run["mesh/facets"][:][run["mesh/contact_facets"][:]]
        cells = vtk_to_numpy(grid.GetCells().GetConnectivityArray())
        own, below = np.split(cells, [tetrahedra.size])
        own = own.reshape(-1, 4)
        assert np.array_equal(nodes[own], tetrahedra) and (regions[own] == region[:, None]).all()
        # A contact triangle has three points of one tetrahedron.
        assert np.array_equal(nodes[below.reshape(-1, 3)], triangles)
        sides = {tuple(sorted(np.delete(corners, k))) for corners in own for k in range(4)}
        assert all(tuple(sorted(side)) in sides for side in below.reshape(-1, 3))
        body = package.open(file).to_pyvista()
        assert np.array_equal(body.points, points) and np.array_equal(body["von_mises"], run["post/von_mises"][:])
        assert np.ptp(body["von_mises"][nodes == nodes[-1]]) > 0.01 * run["post/von_mises"][-1]


def test_contact_fields_live_on_triangles(run, grid):
    n_tetrahedra = run["mesh/tetrahedra"].shape[0]
    panes = run["mesh/contact_facet_pane"][:]
    expected = {
        name: run[f"post/{dataset}"][:][panes]
        for name, dataset in CONTACT_FIELDS.items()
    }
    expected["contact_pressure"] = 0.0 - run["post/normal_stress"][:][panes]
    for i in (0, 1):
        expected[f"friction_{i + 1}"] = run["post/pane_friction"][:, i][panes]
    for name, values in expected.items():
        field = cell_field(grid, name)
        assert np.isnan(field[:n_tetrahedra]).all(), name
        assert np.array_equal(field[n_tetrahedra:], values), name


def test_tangential_stress_in_global_axes(run, grid, problem):
    n_tetrahedra = run["mesh/tetrahedra"].shape[0]
    field = cell_field(grid, "friction_stress")
    assert np.isnan(field[:n_tetrahedra]).all()
    stress = run["post/tangential_stress"][:] @ problem.frame[1:]
    expected = stress[run["mesh/contact_facet_pane"][:]]
    # Two products and a sum per component.
    difference = np.abs(field[n_tetrahedra:] - expected).max()
    assert difference <= 1e-14 * np.abs(expected).max()
