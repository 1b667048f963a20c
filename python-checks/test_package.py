"""The Python package over the program: runs, run files as trees, sweeps, errors."""

import json
import os
import runpy
import sys
import tomllib
import warnings
from pathlib import Path

import h5py
import numpy as np
import matplotlib
import pint
import pytest
import pyvista
import xarray as xr

from conftest import ROOT, SCENE
from schema_check import scales_of

import contact3d as package

SMALL = {"body.brick.cells": [12, 4, 4]}


@pytest.fixture(scope="module", autouse=True)
def same_program(program):
    """The package runs the program that all checks run."""
    before = os.environ.get("CONTACT3D_PIPE")
    os.environ["CONTACT3D_PIPE"] = str(program)
    yield
    if before is None:
        del os.environ["CONTACT3D_PIPE"]
    else:
        os.environ["CONTACT3D_PIPE"] = before


@pytest.fixture(scope="module")
def solved(tmp_path_factory):
    path = tmp_path_factory.mktemp("package") / "run.h5"
    return package.run(SCENE, path, set=SMALL), path


def test_xarray_alone_sees_named_dimensions(solved):
    _, path = solved
    with warnings.catch_warnings():
        warnings.simplefilter("error")
        tree = xr.open_datatree(path, engine="h5netcdf")
    assert tree["solve/displacement"].dims[0] == "n_nodes"
    assert tree["solve/multiplier_normal"].dims == ("n_panes",)
    assert not [name for node in tree.subtree for name in node.dims if "phony" in str(name)]


def test_hdf5_itself_knows_every_scale(solved):
    _, path = solved
    with h5py.File(path) as file:
        # The names that h5py and netCDF-C ask HDF5's library of dimension scales for.
        assert [list(axis.keys())[0] for axis in file["solve/displacement"].dims][1] == "axis"
        scales = [axis[0] for axis in file["solve/displacement"].dims]
        assert all(scale.is_scale for scale in scales)
        assert [scale.name for scale in scales] == ["/solve/n_nodes", "/solve/axis"]


def test_names_survive_the_copy_of_a_stage(contact3d, tmp_path):
    path = tmp_path / "run.h5"
    arguments = ["--no-figures", "--set", "body.brick.cells=[6,2,2]"]
    contact3d("run", SCENE, path, *arguments)
    # The second run keeps mesh and factor, which HDF5 copies, and writes the rest anew.
    contact3d("run", SCENE, path, *arguments, "--set", "contact.gap=1e-6")
    with h5py.File(path) as file:
        for name in ("mesh/coordinates", "assemble/stiffness/indptr", "solve/displacement"):
            lengths = [[scale.shape[0] for scale in scales] for scales in scales_of(file[name])]
            assert lengths == [[size] for size in file[name].shape]


def test_tree_holds_what_h5py_reads(solved):
    tree, path = solved
    with h5py.File(path) as file:
        for node in tree.subtree:
            for name, variable in node.to_dataset(inherit=False).data_vars.items():
                stored = file[node.path][name]
                if stored.dtype.kind == "f":
                    np.testing.assert_array_equal(variable.values, stored[()])
                assert variable.attrs["units"] == stored.attrs["units"]
        members = h5py.check_enum_dtype(file["post/contact_zone"].dtype)
        codes = [members[word] for word in tree["post/contact_zone"].values]
        assert codes == list(file["post/contact_zone"][:])
        contact = file["mesh/coordinates"][:][file["mesh/contact_nodes"][:]]
    # The paper's rule of stopping at 1e-4.
    assert tree["solve/status"].item() == "reduced_accuracy"
    # Panes are squares of 0.5 m on the face z = 0.
    panes = tree["solve"].to_dataset()
    assert set(panes.pane_x.values.round(12)) == {0.25, 0.75, 1.25, 1.75, 2.25, 2.75}
    assert set(panes.pane_z.values) == {0.0}
    np.testing.assert_array_equal(panes.contact_x.values, contact[:, 0])


def test_matrices_are_those_of_scipy(solved):
    tree, path = solved
    matrices = tree.attrs["matrices"]
    assert {"assemble/stiffness", "mesh/pane_average"} <= set(matrices)
    stiffness = matrices["assemble/stiffness"]
    # A is assembled symmetric to the bit.
    assert abs(stiffness - stiffness.T).max() == 0.0
    with h5py.File(path) as file:
        assert stiffness.nnz == file["assemble/stiffness/data"].size
    with pytest.raises(KeyError):
        matrices["assemble"]


def test_every_unit_is_a_unit_of_pint(schema):
    registry = pint.UnitRegistry()
    expected = {"Pa": "N/m^2", "J": "N m", "Pa/m^3": "N/m^5", "(N/m)^(1/2)": "N^0.5/m^0.5"}
    for word in {row["unit"] for row in schema["datasets"]}:
        dimension = registry(word).dimensionality
        if word in expected:
            assert dimension == registry(expected[word]).dimensionality


def test_scenes_as_path_text_and_dict_are_the_same_scene(solved, tmp_path):
    tree, _ = solved
    text = SCENE.read_text()
    scene = tomllib.loads(text)
    scene["body"]["brick"]["cells"] = np.array([12, 4, 4])
    assert tree.attrs["scene"]["body"]["brick"]["cells"] == [12, 4, 4]
    for name, given, changes in (("text", text, SMALL), ("dict", scene, None)):
        other = package.run(given, tmp_path / f"{name}.h5", set=changes)
        assert other["solve"].attrs["digest"] == tree["solve"].attrs["digest"]
        assert other.attrs["scene"] == tree.attrs["scene"]


def test_errors_have_types_and_the_words_of_the_program(tmp_path):
    path = tmp_path / "run.h5"
    with pytest.raises(package.BadInput, match="missing key `body`") as refused:
        package.run({"title": "nothing else"}, path)
    assert refused.value.exit_code == 2
    assert not path.exists()
    short = {"solve.method": "fixed-point", "solve.max_outer_steps": 2}
    with pytest.raises(package.NotConverged, match="NOT CONVERGED") as failed:
        package.run(SCENE, path, set={**SMALL, **short})
    assert package.open(failed.value.file)["solve/status"].item() == "max_outer_steps"


def test_pyvista_reads_what_is_exported(solved, tmp_path):
    tree, path = solved
    package.export(path, vtkhdf=tmp_path / "grid.vtkhdf")
    grid = pyvista.read(tmp_path / "grid.vtkhdf")
    np.testing.assert_array_equal(grid["displacement"], tree["solve/displacement"].values)
    triangles = grid.extract_cells(grid.celltypes == pyvista.CellType.TRIANGLE)
    pressure = tree["solve/multiplier_normal"].values
    panes = tree["mesh/contact_facet_pane"].values
    np.testing.assert_array_equal(triangles["contact_pressure"], pressure[panes])
    body = tree.to_pyvista()
    assert set(body.point_data.keys()) == {"displacement", "von_mises", "stress"}
    assert "error_indicator" in body.cell_data and "contact_gap" not in body.cell_data
    np.testing.assert_array_equal(body["displacement"], tree["solve/displacement"].values)
    np.testing.assert_array_equal(body["von_mises"], tree["post/von_mises"].values)
    np.testing.assert_array_equal(body["stress"], grid["stress"])
    stress, error = (tree[f"post/largest_von_mises/{name}"].item() for name in ("value", "error"))
    values, place = tree["post/von_mises"], tree["post/largest_von_mises/place"].values
    is_there = np.all([values[f"material_node_{axis}"] == x for axis, x in zip("xyz", place, strict=True)], axis=0)
    assert values.values[is_there].max() == stress
    told = tree.summary["largest von Mises"]
    assert f"{stress / 1e6:.4g} MPa" in told and ("± " in told) == np.isfinite(error)
    with pytest.raises(package.BadInput, match="reads that file"):
        package.export(path, vtkhdf=path)


def test_problem_for_siconos_is_that_of_the_file(solved, tmp_path):
    tree, path = solved
    package.export(path, fclib=tmp_path / "problem.hdf5")
    with h5py.File(tmp_path / "problem.hdf5") as file:
        forces = file["contact3d/unit"][0] * file["contact3d/scale"][:, 0] * file["solution/r"][:].reshape(-1, 3)[:, 0]
        area = file["contact3d/pane_area"][:]
    pressure = tree["solve/multiplier_normal"].values
    # A few products.
    np.testing.assert_allclose(forces / area, pressure, rtol=1e-14, atol=1e-14 * pressure.max())
    package.export(path, fclib=tmp_path / "global.hdf5", sparse=True)
    with h5py.File(tmp_path / "global.hdf5") as file:
        assert file["fclib_global/M/m"][()] == tree.attrs["matrices"]["assemble/stiffness"].shape[0]


@pytest.mark.parametrize("example", ["modes", "pressure", "sweep"])
def test_examples_run(contact3d, example, tmp_path, monkeypatch):
    """All but `grid`, which draws with what the machine has of OpenGL, and `fit`, which another test runs."""
    matplotlib.use("Agg")
    monkeypatch.chdir(tmp_path)
    (tmp_path / "pipelines").symlink_to(ROOT / "pipelines")
    if example == "sweep":
        (tmp_path / "sweep.toml").write_text("""
scene = "pipelines/newton.toml"
set = { "body.brick.cells" = [6, 2, 2], "friction.coefficient_1" = { constant = 0.3 } }
[[axis]]
key = "friction.coefficient_2"
values = [{ constant = 0.3 }]
[[axis]]
key = "traction.0.value"
values = [[1e7, 0.0, 2e7], [5e6, 8.7e6, 2e7]]
[[axis]]
key = "friction.coefficient_1.constant"
values = [0.1, 0.3]
""")
        contact3d("sweep", "sweep.toml", "cases", "--no-figures")
        monkeypatch.setattr(sys, "argv", ["sweep.py", "cases"])
    runpy.run_path(str(ROOT / "python" / "examples" / f"{example}.py"))
    assert example == "modes" or (tmp_path / f"{example}.png").stat().st_size > 10_000


def test_a_sweep_is_one_dataset_over_its_axes(contact3d, tmp_path):
    sweep = f"""
scene = "{ROOT / "pipelines" / "newton.toml"}"
set = {{ "body.brick.cells" = [6, 2, 2] }}
[[axis]]
keys = ["material.isotropic.young_modulus", "material.isotropic.poisson_ratio"]
rows = [[2.1e11, 0.28], [7.0e10, 0.33]]
[[axis]]
key = "friction.coefficient_1"
values = [{{ constant = 0.1 }}, {{ constant = 0.3 }}, {{ constant = 0.5 }}]
"""
    (tmp_path / "sweep.toml").write_text(sweep)
    contact3d("sweep", tmp_path / "sweep.toml", tmp_path / "cases", "--no-figures")
    table = package.open_sweep(tmp_path / "cases")
    modulus, ratio = "material.isotropic.young_modulus", "material.isotropic.poisson_ratio"
    assert table["normal_force"].dims == (modulus, "friction.coefficient_1")
    assert list(table[ratio].values) == [0.28, 0.33]
    with h5py.File(tmp_path / "cases" / "summary.h5") as file:
        for row, settings in enumerate(file["cases/settings"].asstr()[:]):
            values = json.loads(settings)
            law = json.dumps(values["friction.coefficient_1"])
            case = table.sel({modulus: values[modulus], "friction.coefficient_1": law})
            assert case["normal_force"].item() == file["cases/normal_force"][row]
            assert case["id"].item() == file["cases/id"].asstr()[row]
        rows = table.to_dataframe()
        assert rows["id"].tolist() == file["cases/id"].asstr()[:].tolist() and rows[ratio].tolist() == [0.28] * 3 + [0.33] * 3
        np.testing.assert_array_equal(rows[["contact_force_x", "contact_force_y", "contact_force_z"]], file["cases/contact_force"])


def test_linked_files_and_cases_of_a_sweep_are_opened(contact3d, tmp_path):
    """Scales of axes lie in another file there, to which h5netcdf does not follow a reference."""
    linked = tmp_path / "linked.h5"
    contact3d("run", SCENE, linked, "--no-figures", "--linked", "--set", "body.brick.cells=[6,2,2]")
    sweep = tmp_path / "sweep.toml"
    sweep.write_text(
        f'scene = "{SCENE}"\nset = {{ "body.brick.cells" = [6, 2, 2] }}\n'
        '[[axis]]\nkey = "traction.0.value.0"\nvalues = [1e7, 2e7]\n'
    )
    contact3d("sweep", sweep, tmp_path / "out")
    cases = [path for path in (tmp_path / "out").glob("*.h5") if "-" not in path.name and path.name != "summary.h5"]
    assert len(cases) == 2
    for path in (linked, *cases):
        with package.open(path) as tree:
            assert tree["assemble/degree_of_freedom"].dims == ("n_nodes", "axis")
            assert tree["solve/displacement"].values.shape == tree["assemble/degree_of_freedom"].shape
            assert not [name for node in tree.subtree for name in node.dims if "phony" in str(name)]


def test_names_that_look_like_options_are_names(tmp_path, monkeypatch):
    monkeypatch.chdir(tmp_path)
    Path("-scene.toml").write_text(Path(SCENE).read_text())
    package.run("-scene.toml", "-run.h5", set={"body.brick.cells": [6, 2, 2]}, figures="--pictures").close()
    package.export("-run.h5", vtkhdf="-grid.vtkhdf")
    assert {path.name for path in tmp_path.iterdir()} >= {"-run.h5", "-grid.vtkhdf", "--pictures"}


def test_bodies_by_name(tmp_path, monkeypatch):
    run = package.run(ROOT / "pipelines" / "stack.toml", tmp_path / "stack.h5")
    assert run.bodies == ["steel", "wood", "rubber"]
    with pytest.raises(ValueError, match="steel, wood, rubber"):
        run.body("glass")
    rubber = run.body("rubber")
    on = rubber["number"].values
    assert rubber["z"].min().item() == pytest.approx(0.2) and rubber["z"].attrs["units"] == "m"
    assert np.array_equal(rubber["displacement"], run["solve/displacement"].values[on])
    assert np.array_equal(rubber["von_mises"], run["post/von_mises"].values[on])
    grid = run.to_pyvista("rubber")
    assert grid.bounds[4] == pytest.approx(0.2)
    assert np.ptp(grid["von_mises"]) == np.ptp(rubber["von_mises"].values)
    # Mesh files of a dict count from the working directory, those of several bodies, too.
    monkeypatch.chdir(ROOT / "pipelines")
    scene = tomllib.loads(Path("two_balls.toml").read_text())
    assert package.run(scene, tmp_path / "balls.h5").faces == ["upper.z_min"]
