"""A factor in single precision: what the file says of it, and answers as good as with double."""

import h5py
import numpy as np
import pytest

from conftest import ROOT
from test_factor import cholesky_factor

SCENE = ROOT / "pipelines" / "newton.toml"
CELLS = ("--set", "body.brick.cells=[12,4,4]")


@pytest.fixture(scope="module")
def paths(contact3d, tmp_path_factory) -> dict[str, str]:
    """The same scene with both factors, in files beside the run files, which themselves hold none in double precision."""
    folder = tmp_path_factory.mktemp("single")
    result = {}
    for precision in ("single", "double"):
        result[precision] = folder / f"{precision}.h5"
        setting = f'assemble.factor="{precision}"'
        contact3d("run", SCENE, result[precision], "--no-figures", "--linked", *CELLS, "--set", setting)
    return result


def test_names_say_the_precision(paths):
    with h5py.File(paths["single"]) as file:
        assemble = file["assemble"]
        for name in ("factor/values", "dual_operator", "contact_compliance"):
            assert name not in assemble
            assert assemble[f"{name}_single"].dtype == np.float32
    with h5py.File(paths["double"]) as file:
        names = []
        file["assemble"].visit(names.append)
        assert not [name for name in names if name.endswith("_single")]


def test_a_factor_that_is_not_stored_is_made_again_in_its_precision(contact3d, paths):
    again = paths["single"].with_name("again.h5")
    setting = 'assemble.factor="single"'
    contact3d("mesh", SCENE, again, *CELLS, "--set", setting)
    for stage in ("assemble", "solve"):
        contact3d(stage, again)
    with h5py.File(paths["single"]) as stored, h5py.File(again) as file:
        assert set(file["assemble/factor"]) == {"permutation", "supernode_columns"}
        assert file["assemble"].attrs["digest"] == stored["assemble"].attrs["digest"]
        for name in ("solve/multiplier_normal", "solve/displacement"):
            assert np.array_equal(file[name][:], stored[name][:])


def test_the_factor_is_that_of_the_stiffness_to_single_precision(paths):
    with h5py.File(paths["single"]) as single, h5py.File(paths["double"]) as double:
        lower = cholesky_factor(single["assemble/factor"], "values_single")
        exact = cholesky_factor(double["assemble/factor"])
        # Rounding 6e-8 times a few hundred products, and the condition number of small pivots.
        assert abs(lower - exact).max() <= 1e-3 * abs(exact).max()
        product, expected = lower @ lower.T, exact @ exact.T
        assert 1e-9 < abs(product - expected).max() / abs(expected).max() <= 1e-5
        operator = single["assemble/dual_operator_single"][:]
        assert np.array_equal(operator, operator.T)
        reference = double["assemble/dual_operator"][:]
        # The factor's rounding times the condition number of A, 1e4 on this mesh.
        assert 1e-9 < abs(operator - reference).max() / abs(reference).max() <= 1e-3


def test_answers_do_not_depend_on_the_precision(paths):
    with h5py.File(paths["single"]) as single, h5py.File(paths["double"]) as double:
        assert single["solve/status"][()] == double["solve/status"][()]
        for name in ("solve/multiplier_normal", "solve/multiplier_tangential", "solve/displacement"):
            x, y = single[name][:], double[name][:]
            # Both are solved to 1e-12.
            assert np.linalg.norm(x - y) <= 1e-11 * np.linalg.norm(y)
        single_figures, double_figures = single["post/certificate"], double["post/certificate"]
        for name in double_figures:
            # The certificate is as good: a few units of rounding more.
            assert single_figures[name][()] <= max(100 * double_figures[name][()], 1e-12)
