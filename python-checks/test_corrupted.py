"""Run files corrupted with h5py, all digests made to fit: the checks of raw arrays must notice.

Each corruption names a test that must fail on the file; on the file with nothing but its digests
written again none may. The program's own `check` sees of them what breaks the certificate: to it a
forged digest is a digest.
"""

import os
import re
import shutil
import subprocess
import sys
from collections.abc import Callable
from pathlib import Path

import h5py
import numpy as np
import pytest

from conftest import ROOT, SCENE, changes
from digest import renew_digest
from faults.mutations import fit_digests
from run_file import enum_members, read_matrix

# Of a number in the file. The tests allow for roundings, 1e-11 of a field at most.
SMALL = 1e-6
TINY = 1e-7
CHECKS = [
    "test_solution.py",
    "test_factor.py",
    "test_elasticity.py",
    "test_inner_problem.py::test_last_inner_problem",
]
NEWTON = ["test_newton.py"]
Corruption = Callable[[h5py.File], None]


def scale(path: str, factor: float, at: Callable[[np.ndarray], tuple] | None = None) -> Corruption:
    """One entry of a dataset times a factor: the largest, or the one that `at` finds."""

    def corrupt(file: h5py.File) -> None:
        values = file[path][()]
        array = np.atleast_1d(values)
        place = at(array) if at else np.unravel_index(np.abs(array).argmax(), array.shape)
        array[place] *= factor
        file[path][...] = array.reshape(np.shape(values))

    return corrupt


def scale_symmetric(file: h5py.File) -> None:
    """The largest A_ij and A_ji beside the diagonal, 1e-7 too large."""
    group = file["assemble/stiffness"]
    rows, data = group["indices"][:], group["data"][:]
    columns = np.repeat(np.arange(group["indptr"].size - 1), np.diff(group["indptr"][:]))
    beside = np.where(rows == columns, 0.0, np.abs(data)).argmax()
    i, j = rows[beside], columns[beside]
    pair = ((rows == i) & (columns == j)) | ((rows == j) & (columns == i))
    data[pair] *= 1 + TINY
    group["data"][...] = data


def scale_row_of_dual_operator(file: h5py.File) -> None:
    """The row and column of S of the first pane, 1e-7 too large."""
    operator = file["assemble/dual_operator"][:]
    operator[0, :] *= 1 + TINY
    operator[:, 0] = operator[0, :]
    file["assemble/dual_operator"][...] = operator


def press_open_pane(file: h5py.File) -> None:
    """An open pane bears a millionth of the largest pressure, in /solve and /post alike."""
    normal = file["solve/multiplier_normal"][:]
    pane = np.flatnonzero(normal == 0)[0]
    normal[pane] = SMALL * normal.max()
    file["solve/multiplier_normal"][...] = normal
    file["post/normal_stress"][...] = -normal


def flip(source: str, target: str) -> Corruption:
    """A pane of one zone passes for another, in the counts too."""

    def corrupt(file: h5py.File) -> None:
        zones = file["post/contact_zone"]
        codes, members = zones[:], enum_members(zones)
        codes[np.flatnonzero(codes == members[source])[0]] = members[target]
        zones[...] = codes
        counts = [np.count_nonzero(codes == members[z]) for z in ("open", "stick", "slip")]
        file["post/zone_counts"][...] = counts

    return corrupt


def rotate_slip_direction(file: h5py.File) -> None:
    """The largest friction stress of a pane, turned by 1e-6, in /solve and /post alike."""
    tangential = file["solve/multiplier_tangential"][:]
    pane = np.linalg.norm(tangential, axis=1).argmax()
    first, second = tangential[pane]
    tangential[pane] = first - SMALL * second, second + SMALL * first
    file["solve/multiplier_tangential"][...] = tangential
    file["post/tangential_stress"][...] = -tangential


def friction_at_one_node(file: h5py.File) -> None:
    """F₁ of the last inner problem 1e-6 too large at one node, 1/F averaged with it."""
    nodal = file["solve/friction"][:]
    average = read_matrix(file["mesh/pane_average"])
    node = average.indices[0]
    nodal[node, 0] *= 1 + SMALL
    file["solve/friction"][...] = nodal
    file["solve/friction_inverse"][...] = average.T @ (1 / nodal)


# What is corrupted, and a test that must notice.
CASES: dict[str, tuple[Corruption, str]] = {
    "a pressure": (
        scale("solve/multiplier_normal", 1 + SMALL),
        "test_solution.py::test_displacement_solves_the_elastic_problem",
    ),
    "an open pane pressed": (press_open_pane, "test_solution.py::test_certificate"),
    "the direction of slip": (rotate_slip_direction, "test_solution.py::test_certificate"),
    "a sticking pane slips": (flip("stick", "slip"), "test_solution.py::test_zones"),
    "a slipping pane sticks": (flip("slip", "stick"), "test_solution.py::test_zones"),
    "an open pane slips": (flip("open", "slip"), "test_solution.py::test_zones"),
    "a displacement": (
        scale("solve/displacement", 1 + SMALL),
        "test_solution.py::test_displacement_solves_the_elastic_problem",
    ),
    "friction at one node": (friction_at_one_node, "test_solution.py::test_margins"),
    "friction of the solution": (
        scale("post/nodal_friction", 1 + SMALL),
        "test_solution.py::test_friction_of_the_solution",
    ),
    "h": (scale("load/dual_rhs", 1 + TINY), "test_factor.py::test_dual_rhs"),
    "the load": (scale("load/force", 1 + TINY), "test_elasticity.py::test_load"),
    "the stiffness": (scale_symmetric, "test_elasticity.py::test_stiffness"),
    "the coupling": (
        scale("assemble/coupling_normal/data", 1 + TINY),
        "test_elasticity.py::test_coupling_is_the_exact_quadrature",
    ),
    "the area of a pane": (
        scale("mesh/pane_area", 1 + TINY),
        "test_elasticity.py::test_contact_surface",
    ),
    "a stress": (scale("post/stress", 1 + TINY), "test_solution.py::test_stress"),
    "a stress of a node": (scale("post/nodal_stress", 1 + TINY), "test_solution.py::test_nodal_stresses"),
    "the strain energy": (
        scale("post/resultants/strain_energy", 1 + TINY),
        "test_solution.py::test_energies_and_extremes",
    ),
    "a moment": (
        scale("post/resultants/moments", 1 + TINY),
        "test_solution.py::test_forces_and_moments",
    ),
    "a figure of the certificate": (
        scale("post/certificate/fixed_point", 0.5),
        "test_solution.py::test_certificate",
    ),
    "the counted applications": (
        scale("solve/applications", 2),
        "test_solution.py::test_history_ends_converged",
    ),
}
DENSE: dict[str, tuple[Corruption, str]] = {
    "a row of S": (
        scale_row_of_dual_operator,
        "test_newton.py::test_dense_operator_is_symmetric_and_equals_backsolves",
    ),
    "an entry of S": (
        scale("assemble/dual_operator", 1 + TINY, at=lambda _: (0, 1)),
        "test_newton.py::test_dense_operator_is_symmetric_and_equals_backsolves",
    ),
    "the compliance": (
        scale("assemble/contact_compliance", 1 + TINY),
        "test_newton.py::test_compliance_is_that_of_unit_stresses",
    ),
    "a pressure": (
        scale("solve/multiplier_normal", 1 + SMALL),
        "test_newton.py::test_answer_is_a_fixed_point_of_projected_gradient_steps",
    ),
    "the local stiffness": (
        scale("solve/local_stiffness_normal", 1 + SMALL),
        "test_newton.py::test_local_stiffness_is_the_diagonal_of_the_inverse",
    ),
}


# The run file that is corrupted, and what is done to it.
SOURCES = {"fixed point": CASES, "newton": DENSE}
FORGED = [(source, what) for source, cases in SOURCES.items() for what in cases]

# What breaks the certificate that the file holds: there the program's own `check` sees it, too.
SEEN = {
    "a pressure",
    "an open pane pressed",
    "the direction of slip",
    "a displacement",
    "the load",
    "the stiffness",
    "the coupling",
    "a figure of the certificate",
}


def failures(paths: list[Path], checks: list[str]) -> set[tuple[str, str]]:
    """The tests that fail, each with the name of its run file."""
    folder = ROOT / "python-checks"
    command = [sys.executable, "-m", "pytest", "-q", "--tb=no", "-rfE", *checks]
    command += ["-p", "no:cacheprovider"]
    environment = {**os.environ, "CONTACT3D_RUN_FILES": os.pathsep.join(map(str, paths))}
    result = subprocess.run(
        command, cwd=folder, env=environment, capture_output=True, text=True, check=False
    )
    # 0: all pass, 1: some fail; everything else means that nothing was judged.
    assert result.returncode in (0, 1), result.stdout + result.stderr
    assert not re.search(r"^ERROR ", result.stdout, re.MULTILINE), result.stdout
    return set(re.findall(r"^FAILED .*?::(\w+)\[(.*?)\]", result.stdout, re.MULTILINE))


def forged(source: Path, target: Path, corrupt: Corruption) -> Path:
    """A copy of a run file with a corruption and digests that fit it."""
    shutil.copyfile(source, target)
    with h5py.File(target, "r+", libver="v110") as file:
        corrupt(file)
        fit_digests(file)
    renew_digest(target)
    return target


@pytest.fixture(scope="module")
def sources(contact3d, tmp_path_factory) -> dict[str, Path]:
    """The published problem at n_div = 4 by Algorithm 4.1, and by Newton's method on a dense S."""
    folder = tmp_path_factory.mktemp("sources")
    paths = {name: folder / f"{name}.h5" for name in SOURCES}
    contact3d("run", SCENE, paths["fixed point"], "--no-figures", *changes("n_div=4 tight"))
    newton = ROOT / "pipelines" / "newton.toml"
    cells = "body.brick.cells=[12,4,4]"
    contact3d("run", newton, paths["newton"], "--no-figures", "--set", cells)
    return paths


@pytest.fixture(scope="module")
def forgeries(sources, tmp_path_factory) -> dict[tuple[str, str], Path]:
    """A file for each corruption."""
    folder = tmp_path_factory.mktemp("forgeries")
    return {
        (source, what): forged(
            sources[source], folder / f"{source}, {what}.h5", SOURCES[source][what][0]
        )
        for source, what in FORGED
    }


@pytest.fixture(scope="module")
def noticed(forgeries) -> set[tuple[str, str]]:
    """The tests that fail where each file is judged by the one that must notice it; one process for all."""
    checks = [
        f"{SOURCES[source][what][1]}[{path.stem}]" for (source, what), path in forgeries.items()
    ]
    return failures(list(forgeries.values()), checks)


@pytest.mark.parametrize("name, checks", [("fixed point", CHECKS), ("newton", NEWTON)])
def test_files_with_new_digests_alone_pass(sources, tmp_path, name, checks):
    path = forged(sources[name], tmp_path / "same.h5", lambda _: None)
    assert failures([path], checks) == set()


@pytest.mark.parametrize("source, what", FORGED)
def test_corrupted_data_are_noticed(forgeries, noticed, contact3d, source, what):
    path = forgeries[source, what]
    contact3d("check", path, expect=2 if what in SEEN else 0)
    assert (SOURCES[source][what][1].split("::")[1], path.stem) in noticed


def test_a_forged_order_of_the_factor(sources, tmp_path, contact3d):
    """The factor is made again from A: in any order the answer is the same, and what is no order is refused by name."""
    order = "assemble/factor/permutation"

    def reverse(file: h5py.File) -> None:
        file[order][...] = file[order][:][::-1]

    def repeat(file: h5py.File) -> None:
        file[order][0] = file[order][1]

    reversed_order = forged(sources["newton"], tmp_path / "reversed.h5", reverse)
    contact3d("solve", reversed_order)
    with h5py.File(sources["newton"]) as first, h5py.File(reversed_order) as again:
        pressure = first["solve/multiplier_normal"][:]
        # Two factors of one matrix give displacements that agree to its condition number times rounding.
        close = 1e-9 * pressure.max()
        assert again["solve/multiplier_normal"][:] == pytest.approx(pressure, rel=0, abs=close)
    no_order = forged(sources["newton"], tmp_path / "repeated.h5", repeat)
    told = contact3d("solve", no_order, expect=2)
    assert order in told.stderr
