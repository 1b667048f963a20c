"""Paths of solutions against all states of small problems, from raw arrays of run files."""

from pathlib import Path

import numpy as np
import pytest

from closed_forms import all_solutions, one_node_slip_runs_to_infinity
from conftest import ROOT
from raw_problem import RawProblem
from run_file import open_run, read_enum
from schema_check import schema_problems

HARD = ROOT / "pipelines" / "hard"
KEY = "friction.coefficient.constant"


def follow(contact3d, scene: str, path: Path, start: float, end: float) -> Path:
    """All paths over the coefficient of friction, in the file of a solve at its end."""
    friction = ["--set", f"{KEY}={end}"]
    contact3d("run", HARD / scene, path, "--no-figures", *friction)
    span = ["--parameter", KEY, "--from", start, "--to", end, "--all", "--no-figures"]
    contact3d("branches", HARD / scene, path, *span, *friction)
    return path


@pytest.fixture(scope="module")
def files(contact3d, tmp_path_factory) -> dict[str, Path]:
    """Paths of one and of two nodes."""
    folder = tmp_path_factory.mktemp("branches")
    return {
        "one": follow(contact3d, "one_node.toml", folder / "one.h5", 0.5, 4.0),
        "two": follow(contact3d, "two_nodes.toml", folder / "two.h5", 0.3, 3.0),
    }


def planar(problem: RawProblem) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
    """S and h of the components along the normal and t1, and their indices."""
    m = len(problem.pane_area)
    kept = np.concatenate([np.arange(m), m + 2 * np.arange(m)])
    return problem.dual_operator[np.ix_(kept, kept)], problem.dual_rhs[kept], kept


def crossings(file, parameter: float) -> int:
    """How often the paths pass a value of the parameter."""
    values = file["branches/point/parameter"][:]
    ends = np.cumsum(file["branches/path/n_points"][:])
    below = np.array_split(values < parameter, ends[:-1])
    return sum(int(np.count_nonzero(part[1:] != part[:-1])) for part in below)


@pytest.mark.parametrize("name", ["one", "two"])
def test_every_point_is_one_of_the_enumerated_solutions(files, schema, name):
    with open_run(files[name]) as file:
        assert schema_problems(file, schema) == []
        S, h, kept = planar(RawProblem.read(file))
        points = file["branches/point"]
        kinds = read_enum(points["kind"])
        checked = 0
        for parameter, multiplier, kind, sign in zip(
            points["parameter"][:],
            points["multiplier"][:],
            kinds,
            points["determinant_sign"][:],
            strict=True,
        ):
            if kind != "regular":
                continue
            known = all_solutions(S, h, parameter, slack=1e-9)
            away = [np.linalg.norm(multiplier[kept] - k[1]) for k in known]
            # Two factorisations of a matrix of condition 1e2, systems of condition 1e3.
            assert min(away) <= 1e-11 * max(np.linalg.norm(k[1]) for k in known) + 1e-30
            assert sign == known[int(np.argmin(away))][2]
            checked += 1
        assert checked > 50


@pytest.mark.parametrize(
    ("name", "span", "most"), [("one", (0.5, 4.0), 3), ("two", (0.3, 3.0), 5)]
)
def test_no_solution_is_missing(files, name, span, most):
    with open_run(files[name]) as file:
        S, h, _ = planar(RawProblem.read(file))
        numbers = []
        # Odd places, which are no kinks.
        for parameter in np.linspace(*span, 173)[1:-1] + 1.234e-5:
            known = all_solutions(S, h, parameter)
            assert crossings(file, parameter) == len(known), parameter
            assert sum(sign for *_, sign in known) == 1
            numbers.append(len(known))
        assert max(numbers) == most


def test_spectral_radius_of_a_sliding_node_is_its_share_of_the_critical_friction(files):
    with open_run(files["one"]) as file:
        S, _, _ = planar(RawProblem.read(file))
        points = file["branches/point"]
        slides = points["zone_counts"][:, 2] == 1
        assert slides.any()
        expected = points["parameter"][:] / one_node_slip_runs_to_infinity(S)
        found = points["spectral_radius"][:]
        # Repeated squaring ends at 1e-5.
        assert np.abs(found / expected - 1)[slides].max() < 2e-5
        assert np.array_equal(points["attracting"][:] == 1, found < 1)


def test_resultants_are_sums_over_panes(files):
    with open_run(files["two"]) as file:
        area = RawProblem.read(file).pane_area
        points = file["branches/point"]
        multiplier = points["multiplier"][:]
        m = len(area)
        # Sums of two products.
        assert np.allclose(points["normal_force"][:], multiplier[:, :m] @ area, rtol=1e-14)
        tangential = multiplier[:, m:].reshape(-1, m, 2)
        expected = np.einsum("pmk,m->pk", tangential, area)
        assert np.allclose(points["tangential_force"][:], expected, rtol=1e-13, atol=1e-20)


def test_random_planar_problems_have_degree_one():
    """The sum of signs over all solutions is one, for the closed forms themselves."""
    random = np.random.default_rng(1)
    several = 0
    for _ in range(500):
        m = int(random.integers(1, 3))
        factor = random.normal(size=(2 * m, 2 * m))
        S = factor @ factor.T + 0.05 * np.eye(2 * m)
        h = random.normal(size=2 * m)
        known = all_solutions(S, h, 10 ** random.uniform(-1, 1.5))
        assert sum(sign for *_, sign in known) == 1
        several += len(known) > 1
    assert several > 5
