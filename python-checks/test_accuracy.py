"""The studies of accuracy, computed again from the raw arrays of run files."""

import itertools
from pathlib import Path

import numpy as np
import pytest

from conftest import ROOT
from raw_problem import RawProblem
from run_file import open_run
from schema_check import schema_problems

SCENE = ROOT / "pipelines" / "newton.toml"


def cells(n_div: int) -> list[str]:
    """The flags that cut the published body in 3 n_div x n_div x n_div cells."""
    return ["--set", f"body.brick.cells=[{3 * n_div},{n_div},{n_div}]"]


@pytest.fixture(scope="module")
def study_path(contact3d, tmp_path_factory) -> Path:
    """Both studies of the published scene at n_div = 4."""
    path = tmp_path_factory.mktemp("accuracy") / "studies.h5"
    sizes = ["--coarsest", "2", "--finest", "8", "--budget", "20"]
    contact3d("accuracy", SCENE, path, "--no-figures", *cells(4), *sizes)
    return path


@pytest.fixture(scope="module")
def solved(contact3d, tmp_path_factory) -> dict[int, RawProblem]:
    """The published problem at n_div = 2, 4, 8 by `run`."""
    folder = tmp_path_factory.mktemp("levels")
    problems = {}
    for n_div in (2, 4, 8):
        path = folder / f"n{n_div}.h5"
        contact3d("run", SCENE, path, "--no-figures", *cells(n_div))
        with open_run(path) as file:
            problems[n_div] = RawProblem.read(file)
    return problems


def doubled(field: np.ndarray, n_div: int) -> np.ndarray:
    """A P1 field at the nodes of the mesh with cells halved along every edge.

    A fine node is a coarse one, or the middle of a cell edge, of a face diagonal, or of
    a cell, which is the centroid of the central tetrahedron; face diagonals and central
    tetrahedra join the coarse nodes with an even sum of indices.
    """
    shape = (n_div + 1, n_div + 1, 3 * n_div + 1, 3)
    coarse = field.reshape(shape)
    fine = np.zeros([2 * n + 1 for n in (n_div, n_div, 3 * n_div)] + [3])
    for index in np.ndindex(*fine.shape[:3]):
        ends = [sorted({i // 2, (i + 1) // 2}) for i in index]
        corners = list(itertools.product(*ends))
        if len(corners) > 2:
            corners = [corner for corner in corners if sum(corner) % 2 == 0]
        fine[index] = np.mean([coarse[corner] for corner in corners], axis=0)
    return fine.reshape(-1, 3)


def energy_norm(problem: RawProblem, field: np.ndarray) -> float:
    free = problem.to_free(field)
    return float(np.sqrt(free @ problem.stiffness @ free))


def test_the_file_is_what_the_schema_says(study_path, schema):
    with open_run(study_path) as file:
        assert schema_problems(file, schema) == []
        assert set(file) == {"scene", "accuracy"}


def test_differences_to_the_finest_mesh(study_path, solved):
    with open_run(study_path) as file:
        stored = file["accuracy/levels/energy_difference"][:]
        assert file["accuracy/levels/cells"][:, 2].tolist() == [2, 4, 8]
    finest = solved[8]
    size = energy_norm(finest, finest.displacement)
    for value, n_div in zip(stored, (2, 4, 8), strict=True):
        field = solved[n_div].displacement
        while n_div < 8:
            field, n_div = doubled(field, n_div), 2 * n_div
        difference = energy_norm(finest, field - finest.displacement) / size
        # Both solves are converged to 1e-12; the difference is a few tenths.
        assert value == pytest.approx(difference, abs=1e-9)


def test_energies_orders_and_limits(study_path, solved):
    problems = [solved[n] for n in (2, 4, 8)]
    energy = [
        (u := p.free_displacement) @ (0.5 * (p.stiffness @ u) - p.load)
        for p in problems
    ]
    with open_run(study_path) as file:
        study = file["accuracy"]
        # Solves to 1e-12 of well-conditioned problems.
        assert study["levels/potential_energy"][:] == pytest.approx(energy, rel=1e-9)
        # With cells halved, (v1 - v2) / (v2 - v3) = 2^p.
        ratio = (energy[0] - energy[1]) / (energy[1] - energy[2])
        order = study["order/potential_energy"][-1]
        # Six digits are left of differences of a few per cent.
        assert order == pytest.approx(np.log2(ratio), rel=1e-6)
        limit = energy[2] + (energy[2] - energy[1]) / (ratio - 1)
        assert study["limit/potential_energy"][()] == pytest.approx(limit, rel=1e-8)
        squares = study["levels/energy_difference"][:] ** 2
        ratio = (squares[0] - squares[1]) / squares[1]
        order = study["order/energy_norm"][-1]
        assert order == pytest.approx(0.5 * np.log2(ratio), rel=1e-6)
        errors = study["levels/energy_error"][:] ** 2
        limit = -squares[1] / (ratio - 1)
        assert errors == pytest.approx(squares - limit, rel=1e-6)


def test_quantities_their_orders_and_limits(study_path, solved):
    with open_run(study_path) as file:
        study = file["accuracy"]
        names = [name.decode() for name in study["quantities/name"][:]]
        values = dict(zip(names, study["levels/quantities"][:].T, strict=True))
        orders = study["order/quantities"][:]
        limits = study["limit/quantities"][:]
        places = [place.decode() for place in study["quantities/concentration"][:]]
    concentration = dict(zip(names, places, strict=True))
    assert concentration["largest_von_mises"] == "clamp"
    assert concentration["normal_force"] == ""
    assert names == [
        "normal_force",
        "largest_pressure",
        "largest_von_mises",
        "contact_area",
        "stick_area",
    ]
    for k, problem in enumerate(solved[n] for n in (2, 4, 8)):
        pressure = problem.multiplier[: len(problem.pane_area)]
        # Solves to 1e-12 of well-conditioned problems.
        force = problem.pane_area @ pressure
        assert values["normal_force"][k] == pytest.approx(force, rel=1e-9)
        assert values["largest_pressure"][k] == pytest.approx(pressure.max(), rel=1e-9)
    for name, order, limit in zip(names, orders, limits, strict=True):
        v = values[name]
        assert np.isnan(order[:2]).all()
        ratio = (v[0] - v[1]) / (v[1] - v[2])
        # With cells halved, an order p is log2 of the ratio, from 0 to 4.
        if not 1 < ratio < 16:
            assert np.isnan([order[2], limit]).all()
            continue
        assert order[2] == pytest.approx(np.log2(ratio), rel=1e-6)
        # It takes four meshes.
        assert np.isnan(limit)


def test_algebraic_errors_are_those_of_solves_of_that_accuracy(
    study_path, contact3d, solved, tmp_path
):
    exact = solved[4]
    flags = ['assemble.dual_operator="explicit"', 'solve.method="fixed-point"']
    flags += ['solve.precision="fixed"', "solve.epsilon=1e-4"]
    path = tmp_path / "entry.h5"
    more = [part for flag in flags for part in ("--set", flag)]
    contact3d("run", SCENE, path, "--no-figures", *cells(4), *more)
    with open_run(path) as file:
        rough = RawProblem.read(file)
        applications = file["solve/applications"][()]
    with open_run(study_path) as file:
        solves = file["accuracy/solves"]
        names = {column: solves[column][:] for column in solves}
    wanted = (names["method"] == 0) & (names["operator"] == 1)
    (place,) = np.flatnonzero(wanted & (names["epsilon"] == 1e-4))
    change = rough.multiplier - exact.multiplier
    error = np.linalg.norm(change) / np.linalg.norm(exact.multiplier)
    # The reference of the test is converged to 1e-12, the error is near 1e-3.
    assert names["multiplier_error"][place] == pytest.approx(error, rel=1e-6)
    # |u - u*|_A^2 = (lambda - lambda*) . S (lambda - lambda*).
    energy = np.sqrt(change @ exact.dual_operator @ change)
    energy /= energy_norm(exact, exact.displacement)
    assert names["energy_error"][place] == pytest.approx(energy, rel=1e-6)
    assert names["applications"][place] == applications
