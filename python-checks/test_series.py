"""Series of paths and sweeps, and copies for viewers, through ParaView's own reader."""

import subprocess

import h5py
import numpy as np
import pytest
from vtkmodules.util.numpy_support import vtk_to_numpy
from vtkmodules.vtkIOHDF import vtkHDFReader

from conftest import ROOT
from raw_problem import RawProblem
from run_file import open_run
from schema_check import is_scale, schema_problems

KEY = "friction.coefficient.constant"
FIELDS = ("parameter", "determinant_sign", "spectral_radius")
SCENES = {
    # Folds and kinks: the parameter goes back and forth.
    "two_nodes.toml": ("0.3", "3", "--all"),
    # One path along which the parameter grows.
    "one_node.toml": ("0.5", "0.9"),
}


@pytest.fixture(scope="module")
def folders(contact3d, tmp_path_factory):
    """A run file and a folder of series for each scene."""
    made = {}
    for scene, (start, end, *options) in SCENES.items():
        folder = tmp_path_factory.mktemp("series")
        path = ROOT / "pipelines" / "hard" / scene
        friction = ["--set", f"{KEY}={end}"]
        contact3d("run", path, folder / "run.h5", "--no-figures", *friction)
        span = ["--parameter", KEY, "--from", start, "--to", end, *options]
        series = ["--series", folder / "series", "--no-figures"]
        contact3d("branches", path, folder / "run.h5", *span, *series, *friction)
        made[scene] = folder
    return made


def played(file):
    """Times of a series, and its grid at each, by the reader of ParaView."""
    reader = vtkHDFReader()
    errors = []
    reader.AddObserver("ErrorEvent", lambda *_: errors.append("error"))
    assert reader.CanReadFile(str(file))
    reader.SetFileName(str(file))
    reader.UpdateInformation()
    information = reader.GetOutputInformation(0)
    key = reader.GetExecutive().TIME_STEPS()
    times = [information.Get(key, k) for k in range(information.Length(key))]
    assert len(times) == reader.GetNumberOfSteps()
    for step, time in enumerate(times):
        reader.SetStep(step)
        reader.Update()
        assert not errors
        yield time, reader.GetOutputDataObject(0)


def array(data, name):
    """One array of a grid."""
    return vtk_to_numpy(data.GetArray(name))


@pytest.mark.parametrize("scene", SCENES)
def test_each_step_is_a_point_of_its_path(folders, scene):
    folder = folders[scene]
    with open_run(folder / "run.h5") as run:
        counts = run["branches/path/n_points"][:]
        points = {name: run[f"branches/point/{name}"][:] for name in FIELDS}
        points["multiplier"] = run["branches/point/multiplier"][:]
        problem = RawProblem.read(run)
        coordinates = run["mesh/coordinates"][:]
        contact_nodes = problem.contact_nodes
        carriers = problem.pane_average
    files = [folder / "series" / f"path_{k + 1}.vtkhdf" for k in range(len(counts))]
    assert set(files) == set((folder / "series").glob("*.vtkhdf"))
    point = 0
    m = len(problem.pane_area)
    for file, count in zip(files, counts, strict=True):
        last = -np.inf
        number = 0
        parameters = points["parameter"][point : point + count]
        grows = bool((np.diff(parameters) > 0).all())
        for time, grid in played(file):
            number += 1
            assert time == (parameters[number - 1] if grows else number) and time > last
            last = time
            assert np.array_equal(vtk_to_numpy(grid.GetPoints().GetData()), coordinates)
            fields = grid.GetFieldData()
            for name in FIELDS:
                known = points[name][point : point + 1]
                assert np.array_equal(array(fields, name), known, equal_nan=True)
            multiplier = points["multiplier"][point]
            # Both scenes have multipliers at nodes, one node each.
            pressure = array(grid.GetPointData(), "contact_pressure")
            expected = np.full(len(coordinates), np.nan)
            for pane in range(m):
                node = carriers[:, [pane]].indices
                expected[contact_nodes[node]] = multiplier[pane]
            assert np.array_equal(pressure, expected, equal_nan=True)
            # u solves A u = l - B'lambda: one factorisation against another, condition 1e2.
            expected = problem.displacement_of(multiplier)
            found = array(grid.GetPointData(), "displacement")
            scale = np.abs(expected).max()
            assert np.abs(found - expected).max() <= 1e-11 * scale
            point += 1
        assert number == count
    assert point == len(points["parameter"])


def test_the_file_is_what_its_schema_says(folders, series_schema):
    for folder in folders.values():
        for path in (folder / "series").glob("*.vtkhdf"):
            with h5py.File(path) as file:
                assert schema_problems(file, series_schema) == []
                assert file["VTKHDF/Steps"].attrs["NSteps"] == len(
                    file["VTKHDF/Steps/Values"]
                )


def test_a_second_search_replaces_its_own_series_only(contact3d, program, folders):
    folder = folders["two_nodes.toml"]
    series = folder / "series"
    path = ROOT / "pipelines" / "hard" / "one_node.toml"
    span = ["--parameter", KEY, "--from", "0.5", "--to", "0.9", "--no-figures"]
    foreign = series / "path_99.vtkhdf"
    foreign.write_text("not ours")
    command = [program, "branches", path, folder / "one.h5", *span, "--series", series]
    refused = subprocess.run(command, capture_output=True, text=True, check=False)
    assert refused.returncode == 2 and "path_99.vtkhdf" in refused.stderr
    assert not (folder / "one.h5").exists()
    foreign.unlink()
    contact3d(*command[1:])
    assert [file.name for file in series.glob("*.vtkhdf")] == ["path_1.vtkhdf"]


GRIDS = "/VTKHDF/PointData/displacement", "/VTKHDF/CellData/contact_pressure"
GAPS = (0.0, 1e-6, 4e-6)
SWEEP = f"""
scene = "{ROOT / "pipelines" / "newton.toml"}"
[[axis]]
key = "body.brick.cells"
values = [[6, 2, 2], [12, 4, 4]]
[[axis]]
key = "contact.gap"
values = {list(GAPS)}
"""


@pytest.fixture(scope="module")
def swept(contact3d, tmp_path_factory):
    """The folder of a sweep over two meshes, with its series."""
    folder = tmp_path_factory.mktemp("sweep")
    (folder / "sweep.toml").write_text(SWEEP)
    series = ["--series", folder / "series"]
    contact3d("sweep", folder / "sweep.toml", folder / "cases", "--no-figures", *series)
    return folder


def test_each_step_of_a_sweep_is_a_case(swept, series_schema):
    with h5py.File(swept / "cases" / "summary.h5") as file:
        names = file["cases/id"].asstr()[:]
        values = file["cases/setting_value"][:]
    files = [swept / "series" / f"cases_{k + 1}.vtkhdf" for k in range(2)]
    assert set(files) == set((swept / "series").glob("*.vtkhdf"))
    rows = iter(range(len(names)))
    for file in files:
        with h5py.File(file) as stored:
            assert schema_problems(stored, series_schema) == []
        for (time, grid), gap in zip(played(file), GAPS, strict=True):
            row = next(rows)
            # The only key that varies on a mesh grows, so it is the time.
            assert time == gap
            assert array(grid.GetFieldData(), "case") == row
            setting = array(grid.GetFieldData(), "setting").ravel()
            assert np.array_equal(setting, values[row], equal_nan=True)
            with open_run(swept / "cases" / f"{names[row]}.h5") as run:
                assert np.array_equal(vtk_to_numpy(grid.GetPoints().GetData()), run["mesh/coordinates"][:])
                for data, path in zip((grid.GetPointData(), grid.GetCellData()), GRIDS, strict=True):
                    shown = array(data, path.rsplit("/", 1)[1])
                    assert np.array_equal(shown, run[path][:], equal_nan=True)
    assert next(rows, None) is None


def test_normals_of_contact_are_those_of_every_case(contact3d, tmp_path, series_schema):
    """Of several contact faces; written once, since they belong to the grid."""
    scene = ROOT / "pipelines" / "wedge.toml"
    (tmp_path / "sweep.toml").write_text(f"""
scene = "{scene}"
[[axis]]
key = "material.isotropic.young_modulus"
values = [1e11, 2e11]
""")
    contact3d("sweep", tmp_path / "sweep.toml", tmp_path / "cases", "--no-figures", "--series", tmp_path)
    file = tmp_path / "cases_1.vtkhdf"
    with h5py.File(file) as stored:
        assert schema_problems(stored, series_schema) == []
        normals = stored["VTKHDF/CellData/contact_normal"][:]
    for _, grid in played(file):
        assert np.array_equal(array(grid.GetCellData(), "contact_normal"), normals, equal_nan=True)
    lengths = np.linalg.norm(normals, axis=1)
    # Unit vectors, rounded.
    assert np.nanmax(np.abs(lengths - 1.0)) <= 4e-16 and np.isfinite(lengths).any()


def test_what_viewers_open_has_a_file_of_its_own(contact3d, program, swept, series_schema, tmp_path):
    run_file = next(f for f in sorted((swept / "cases").glob("*.h5")) if len(f.stem) == 16)
    copy, link = tmp_path / "copy.vtkhdf", tmp_path / "link.vtkhdf"
    link.symlink_to(run_file)
    for _ in range(2):
        # The second time it replaces its own file.
        contact3d("export", run_file, copy, "--kind", "vtkhdf")
    with h5py.File(copy) as file:
        assert schema_problems(file, series_schema) == []
        assert list(file) == ["VTKHDF"]
    # One step has no times; the reader shows all fields of the run file, from the copy and through a link.
    with h5py.File(run_file) as run:
        for file in (copy, link):
            reader = vtkHDFReader()
            reader.SetFileName(str(file))
            reader.Update()
            grid = reader.GetOutputDataObject(0)
            for data, kind in ((grid.GetPointData(), "PointData"), (grid.GetCellData(), "CellData")):
                for name in run[f"VTKHDF/{kind}"]:
                    if not is_scale(run[f"VTKHDF/{kind}/{name}"]):
                        assert np.array_equal(array(data, name), run[f"VTKHDF/{kind}/{name}"][:], equal_nan=True)
    notes = tmp_path / "notes.vtkhdf"
    notes.write_text("not ours")
    for arguments in ([notes, "--kind", "vtkhdf"], [run_file, "--kind", "vtkhdf"], [], [copy]):
        command = [program, "export", run_file, *arguments]
        refused = subprocess.run(command, capture_output=True, text=True, check=False)
        assert refused.returncode == 2, arguments
    assert notes.read_text() == "not ours"
