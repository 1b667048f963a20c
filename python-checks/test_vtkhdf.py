"""The same file through ParaView's own reader."""

import numpy as np
import pytest
from vtkmodules.util.numpy_support import vtk_to_numpy
from vtkmodules.vtkIOHDF import vtkHDFReader

TETRAHEDRON, TRIANGLE = 10, 5
CONTACT_FIELDS = {
    "contact_gap": "pane_gap",
    "contact_zone": "contact_zone",
}


@pytest.fixture(scope="module")
def grid(run):
    """The unstructured grid that vtkHDFReader makes of the file."""
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
        "von_mises",
        "error_indicator",
        "contact_pressure",
        "friction_stress",
        "friction_1",
        "friction_2",
    }
    assert names == CONTACT_FIELDS.keys() | others
    assert grid.GetPointData().GetNumberOfArrays() == 1


def test_von_mises_lives_on_tetrahedra(run, grid):
    n_tetrahedra = run["mesh/tetrahedra"].shape[0]
    field = cell_field(grid, "von_mises")
    assert np.array_equal(field[:n_tetrahedra], run["post/von_mises"][:])
    assert np.isnan(field[n_tetrahedra:]).all()


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
