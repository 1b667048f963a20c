"""contact3d.theory against closed forms, other algorithms on raw arrays, the program, and what a Rust program measured before.

theory_figures.json has the figures of ``contact3d-pipe theory`` at commit af6d89b1, to twelve digits.
"""

import json
import math
import subprocess
import sys
from dataclasses import asdict
from pathlib import Path

import numpy as np
import pytest

import contact3d as package
from conftest import ROOT
from contact3d.theory import Level, NotCovered, Theory, measure
from contact3d.theory._face import ContactFace, triangle_rule
from contact3d.theory._law import FrictionLaw
from contact3d.theory._mapping import nearest_in_ellipses
from quadratic_program import polished
from raw_problem import RawProblem
from run_file import open_run
from theory import Face, Norms, lagrange_of_absolute, largest

PIPELINES = ROOT / "pipelines"
SCENE = PIPELINES / "newton.toml"
FIGURES = json.loads((Path(__file__).parent / "theory_figures.json").read_text())
ONE_PANE = """
title = "a block on one pane, pulled along x so that it slides"
body.brick = { size = [1.0, 1.0, 1.0], cells = [2, 2, 2] }
material.isotropic = { young_modulus = 2e11, poisson_ratio = 0.3 }
clamp = [{ face = "x_min" }]
pressure = [{ face = "z_max", value = 1e7 }]
traction = [{ face = "x_max", value = [3e7, 0.0, 0.0] }]
contact.face = "z_min"
friction.coefficient.constant = 0.1
"""


@pytest.fixture(scope="module", autouse=True)
def environment(program):
    """The package runs the program under test."""
    with pytest.MonkeyPatch.context() as patch:
        patch.setenv("CONTACT3D_PIPE", str(program))
        yield


def cells(n_div: int) -> dict[str, list[int]]:
    """The published body in 3 n_div x n_div x n_div cells."""
    return {"body.brick.cells": [3 * n_div, n_div, n_div]}


@pytest.fixture(scope="module")
def measured() -> Theory:
    """The theory of the published problem at n_div = 2 and 4."""
    return measure(SCENE, set=cells(4))


@pytest.fixture(scope="module")
def runs(contact3d, tmp_path_factory) -> dict[int, Path]:
    """The published problem at n_div = 2 and 4 by `run`."""
    folder = tmp_path_factory.mktemp("theory-runs")
    paths = {n_div: folder / f"n{n_div}.h5" for n_div in (2, 4)}
    for n_div, path in paths.items():
        contact3d("run", SCENE, path, "--no-figures", "--set", f"body.brick.cells=[{3 * n_div},{n_div},{n_div}]")
    return paths


@pytest.fixture(scope="module")
def solved(runs) -> dict[int, tuple[RawProblem, Face]]:
    """Their raw problems and contact faces."""
    return {n_div: read(path) for n_div, path in runs.items()}


def read(path: Path) -> tuple[RawProblem, Face]:
    """The raw problem of a run file and its contact face."""
    with open_run(path) as file:
        problem = RawProblem.read(file)
        return problem, Face.of(problem, file["mesh/facets"][:][file["mesh/contact_facets"][:]])


@pytest.fixture(scope="module")
def norms(solved) -> dict[int, list[Norms]]:
    """Both norms of displacements on both meshes."""
    return {n_div: [Norms.first_sobolev(*pair), Norms.energy(*pair)] for n_div, pair in solved.items()}


def figures(level: Level) -> dict[str, object]:
    """What a level of theory_figures.json holds, in its words."""
    found = json.loads(json.dumps(asdict(level)))
    found["multipliers"] = [[space["space"], space["smallest"], space["beta"]] for space in found["multipliers"]]
    return found


def compare(found: object, expected: object, name: str, tolerances: dict[str, float]) -> None:
    """Every number of a nested table, to a tolerance by the end of its name."""
    if isinstance(expected, dict):
        for key, value in expected.items():
            compare(found[key], value, f"{name}.{key}", tolerances)
    elif isinstance(expected, list):
        assert len(found) == len(expected), name
        for k, value in enumerate(expected):
            compare(found[k], value, f"{name}.{k}", tolerances)
    elif isinstance(expected, float):
        tolerance = next((value for end, value in tolerances.items() if end in name), 1e-8)
        assert found == pytest.approx(expected, rel=tolerance, abs=1e-12), name
    else:
        assert found == expected, name


@pytest.mark.parametrize("case", FIGURES, ids=lambda case: Path(case["scene"]).stem)
def test_figures_are_those_of_the_rust_program(case):
    theory = measure(PIPELINES / case["scene"], set={"body.brick.cells": case["cells"]} if case["cells"] else None)
    compare(asdict(theory.law), case["law"], "law", {})
    assert len(theory.levels) == len(case["levels"])
    tolerances = {
        # Both are means of the growth of a random disturbance, which pairs of eigenvalues a few per cent apart disturb.
        "observed_rate": 2e-3,
        # Displacements that vanish by symmetry had signs of rounding there, which decide how neighbours add up in a norm.
        "contraction.norms": 1e-3,
        "norm_thresholds": 1e-2,
        # Elsewhere with several solutions of two nodes.
        "two_nodes.norm_thresholds": 1.0,
        # On two triangles Lanczos' method met functions of rounding.
        "two_nodes.face.c_r_lagrange": 0.3,
    }
    for level, expected in zip(theory.levels, case["levels"], strict=True):
        name = f"{Path(case['scene']).stem}.{level.mesh}"
        named = {key.replace("two_nodes.", f"{name}.") if "two_nodes" in name else key: value for key, value in tolerances.items()}
        compare(figures(level), expected, name, dict(sorted(named.items(), key=lambda item: -len(item[0]))))
    assert theory.problems == []


def test_constants_of_the_face(measured, solved):
    for level, (_, face) in zip(measured.levels, solved.values(), strict=True):
        assert level.face.h == pytest.approx(face.size, rel=1e-14)
        # Lanczos' method ends at a residual of 1e-8, whose square is the error.
        assert level.face.c_inv_10 == pytest.approx(face.inverse_first(), rel=1e-9)
        least = min(face.least_fourth(node) for node in face.free)
        # The module leaves out nodes beyond eight rings; the Hessian here is shifted.
        assert level.face.c_inv_infinity == pytest.approx(np.sqrt(face.size) / least, rel=1e-7)
        # A composite rule does not see the kink exactly.
        assert level.face.c_r_absolute == pytest.approx(lagrange_of_absolute(face), rel=1e-4)
        # Means of more functions are worse, and settle for Clement's interpolation only.
        lagrange, clement = level.face.c_r_lagrange, level.face.c_r_clement
        assert lagrange == tuple(sorted(lagrange)) and clement == tuple(sorted(clement))
        assert lagrange[2] - lagrange[1] > 10 * (clement[2] - clement[1])
        assert level.face.c_t == 1.0


def test_constants_in_both_norms(measured, norms):
    for level, pair in zip(measured.levels, norms.values(), strict=True):
        for found, norm in zip((level.h1, level.energy), pair, strict=True):
            expected = {
                "alpha": norm.ellipticity,
                "continuity": norm.continuity,
                "load": norm.load,
                "c_inv_half": norm.inverse_half(level.face.big_h),
                "c_tr_2": norm.trace_second(),
                "max_trace": norm.trace_largest(),
                "interpolated_trace": norm.trace_absolute(),
            }
            for name, value in expected.items():
                # Dense eigenvalues against Lanczos' method to a residual of 1e-8.
                assert getattr(found, name) == pytest.approx(value, rel=1e-9), name
            # Hoelder's inequality on a face of area 3, and between L2, L4 and Linf; traces of vectors and of their parts.
            assert found.c_tr_2 <= found.c_tr_4 * 3**0.25
            assert found.c_tr_4 <= math.sqrt(found.c_tr_2 * found.max_trace)
            # The same number but for the error of Lanczos' method where a tangential trace is the largest.
            assert found.tangential_trace <= found.c_tr_2 * (1 + 1e-9)
            assert found.tangential_trace <= found.interpolated_trace
            assert found.max_trace <= level.face.c_inv_infinity / math.sqrt(level.face.h) * found.c_tr_4


def test_the_trace_in_the_fourth_power_is_no_smaller_than_its_samples(measured, norms):
    starts = np.random.default_rng(5).standard_normal((3, 10**6))
    for found, norm in zip((measured.levels[0].h1, measured.levels[0].energy), norms[2], strict=True):
        shape = (norm.gram.shape[0] // 3, 3)
        random = [s[: norm.gram.shape[0]].reshape(shape) for s in starts]
        best = norm.trace_fourth([(norm.gram @ s.ravel()).reshape(shape) for s in random])
        # Both are local maxima to 1e-12, the module's from more starts.
        assert found.c_tr_4 >= best * (1 - 1e-9)


def test_multipliers_over_glued_displacements_are_those_of_the_paper_in_h1_only(norms):
    for first, energy in norms.values():
        size = np.abs(first.normal_gram).max()
        # One factorisation; the tangential block decouples exactly.
        assert np.abs(first.glued_gram - first.normal_gram).max() <= 1e-12 * size
        assert largest(energy.normal_gram, energy.glued_gram) > 2.0


def test_bounds_follow_from_their_constants(measured):
    law = measured.law
    for level in measured.levels:
        face, h, big = level.face, level.face.h, level.face.big_h
        for norm in (level.h1, level.energy):
            image = norm.c_tr_2 * (face.c_inv_10 * face.c_r_absolute * face.c_t + 1)
            radius_1, radius_2 = image * norm.load / norm.alpha, (1 + norm.continuity / norm.alpha) * norm.load
            a = law.f_max / np.sqrt(big) * norm.c_inv_half * norm.c_tr_2 / norm.alpha
            b = law.lipschitz * (2 + law.kappa) / np.sqrt(h * big) * norm.c_inv_half * face.c_inv_infinity * norm.c_tr_4
            b *= radius_2 / norm.alpha
            gradient = norm.c_tr_2 * (np.sqrt(face.c_inv_10**2 - h**2) * face.c_r_absolute * face.c_t + 1)
            # The same formulas in another order.
            assert norm.radius_slip == pytest.approx(radius_1, rel=1e-13)
            assert norm.radius_pressure == pytest.approx(radius_2, rel=1e-13)
            assert norm.q == pytest.approx((image + norm.continuity) * max(a, b), rel=1e-13)
            assert norm.q_weighted == pytest.approx(norm.continuity * a + gradient * b, rel=1e-12)
        # The spectral radius is below every norm, a norm below its bound; a hundred roundings.
        for k, norm in enumerate((level.h1, level.energy)):
            order = [level.contraction.spectral_radius, level.contraction.norms[k], norm.q_composed, norm.q_weighted, norm.q_averaged]
            assert all(first <= second * (1 + 1e-13) for first, second in zip(order, order[1:]))
            assert norm.q_weighted <= norm.q


class Psi:
    """Psi of HKL section 3 by MINPACK on the projected gradient of the inner problem."""

    def __init__(self, problem: RawProblem):
        self.problem = problem
        nodes, frame = problem.contact_nodes, problem.frame[1:].T
        moved = problem.solve_stiffness(problem.coupling.T.toarray())
        self.compliance = np.stack([problem.to_nodes(column)[nodes] @ frame for column in moved.T])
        self.free = problem.to_nodes(problem.solve_stiffness(problem.load))[nodes] @ frame

    def tangential(self, multiplier: np.ndarray) -> np.ndarray:
        """Signed (u_t1, u_t2) at the contact nodes."""
        return self.free - np.tensordot(multiplier, self.compliance, axes=1)

    def __call__(self, slip: np.ndarray, pressure: np.ndarray) -> np.ndarray:
        """The multipliers of the frozen problem."""
        problem = self.problem
        inverse = problem.friction_inverse(problem.nodal_friction(slip))
        return polished(problem, problem.multiplier, problem.slip_bound(np.maximum(pressure, 0.0)), inverse)


def jacobian(problem: RawProblem, face: Face) -> np.ndarray:
    """Psi' at the stored solution by central differences, over free slips and pressures."""
    psi = Psi(problem)
    slip = np.abs(psi.tangential(problem.multiplier))
    units = [slip.max(), problem.normal.max()]
    free = np.repeat(face.free, 2) * 2 + np.tile([0, 1], face.free.size)
    point = np.concatenate([slip.ravel()[free] / units[0], problem.normal / units[1]])

    def image(x: np.ndarray) -> np.ndarray:
        at = np.zeros(slip.size)
        at[free] = np.abs(x[: free.size]) * units[0]
        found = psi(at.reshape(slip.shape), x[free.size :] * units[1])
        moved = np.abs(psi.tangential(found)).ravel()[free]
        return np.concatenate([moved / units[0], found[: problem.n_panes] / units[1]])

    step = 1e-6
    differences = [(image(point + d) - image(point - d)) / (2 * step) for d in step * np.eye(point.size)]
    scale = np.repeat(units, [free.size, problem.n_panes])
    return scale[:, None] * np.array(differences).T / scale


@pytest.fixture(scope="module")
def jacobians(solved) -> dict[int, np.ndarray]:
    """Psi' at the stored solution of both meshes."""
    return {n_div: jacobian(*pair) for n_div, pair in solved.items()}


def test_a_run_knows_how_its_answer_attracts(runs, jacobians):
    for n_div, path in runs.items():
        matrix = jacobians[n_div]
        radius = np.abs(np.linalg.eigvals(matrix)).max()
        with open_run(path) as file:
            # Central differences of answers accurate to 1e-13 over 1e-6.
            assert file["solve/spectral_radius"][()] == pytest.approx(radius, rel=1e-6)
            assert file["solve/determinant_sign"][()] == np.sign(np.linalg.det(np.eye(len(matrix)) - matrix))


def test_the_derivative_is_that_of_differences(measured, solved, jacobians, norms):
    _, face = solved[2]
    matrix, level = jacobians[2], measured.levels[0]
    radius = np.abs(np.linalg.eigvals(matrix)).max()
    n = 2 * face.free.size
    mass = np.kron(face.on_free(face.mass), np.eye(2))
    # Central differences of answers accurate to 1e-13 over 1e-6.
    assert level.contraction.spectral_radius == pytest.approx(radius, rel=1e-6)
    assert level.contraction.sign == 1
    # A disturbance of 1e-8, of which rounding is 1e-5, of a function with second derivatives.
    assert level.observed_rate == pytest.approx(radius, rel=1e-4)
    for found, norm in zip(level.contraction.norms, norms[2], strict=True):
        slip, pressure = np.linalg.cholesky(mass), np.linalg.cholesky(norm.glued_gram)
        # |x|^2 = |L' x|^2 turns norms into Euclidean ones.
        to_ball = [np.linalg.inv(slip.T), np.linalg.inv(pressure.T)]
        parts = np.array([[np.linalg.norm(of.T @ matrix[rows, columns] @ ball, 2)
                           for columns, ball in zip((slice(n), slice(n, None)), to_ball, strict=True)]
                          for rows, of in ((slice(n), slip), (slice(n, None), pressure))])
        assert found == pytest.approx(np.linalg.eigvals(parts).real.max(), rel=1e-5)


def test_the_law_times_a_factor_has_the_radius_that_the_program_stores(measured, tmp_path):
    for point in measured.levels[1].scaled:
        if point.scale not in (1.0, 10**0.5):
            continue
        ramps = {f"friction.coefficient_{k}.ramp": {"initial": 0.3 * point.scale, "residual": 0.2 * point.scale, "onset": 1e-5,
                                                    "rate": rate * point.scale} for k, rate in ((1, 3000.0), (2, 1000.0))}
        run = package.run(SCENE, tmp_path / "scaled.h5", set={**cells(4), **ramps})
        # The program squares Psi' 22 times, which leaves 2e-7 to its root.
        assert point.contraction.spectral_radius == pytest.approx(run["solve/spectral_radius"].item(), rel=1e-6)


def test_lemma_3_3_and_the_stability_of_multipliers(measured, norms):
    for level in measured.levels:
        assert all(0 < part <= 1 for part in level.lemma) and level.steps_from_zero
    (space,) = (space for space in measured.levels[0].multipliers if space.space == "2 x 2 cells")
    coarse, fine = norms[2][0], norms[4][0]
    gathered = gather(coarse.problem, fine.problem)
    beta = 1 / np.sqrt(largest(gathered @ fine.normal_gram @ gathered.T, coarse.normal_gram))
    # Dense eigenvalues of small well-conditioned matrices.
    assert space.beta == pytest.approx(beta, rel=1e-10)
    assert all(0 < space.beta <= 1 for space in measured.levels[0].multipliers)
    assert all(space.beta is None for space in measured.levels[1].multipliers)


def gather(coarse: RawProblem, fine: RawProblem) -> np.ndarray:
    """1 where a pane of the fine mesh lies in one of the coarse mesh, else 0."""
    centres = [(p.pane_average.T @ p.coordinates[p.contact_nodes])[:, :2] for p in (coarse, fine)]
    apart = np.abs(centres[0][:, None] - centres[1][None]).max(axis=2)
    inside = apart < 0.5 * np.sqrt(coarse.pane_area[0])
    assert (inside.sum(axis=0) == 1).all()
    return inside.astype(float)


def test_the_friction_functional_of_the_program_beside_that_of_the_paper(measured, solved):
    problem, face = solved[4]
    psi = Psi(problem)
    tangential = psi.tangential(problem.multiplier)
    slip, points = np.abs(tangential), np.array([[0.6, 0.2, 0.2], [0.2, 0.6, 0.2], [0.2, 0.2, 0.6]])
    weights = problem.pane_average.toarray()
    exact, worst = 0.0, -1.0
    # The pane of a triangle is the one whose node in the middle is among its corners.
    middle = weights.argmax(axis=0)
    for nodes in face.triangles:
        (pane,) = np.flatnonzero(np.isin(middle, nodes))
        area = problem.pane_area[pane] / 8
        # The rule of degree 3 with a negative weight in the middle.
        for at, weight in [(np.full(3, 1 / 3), -27 / 48), *((p, 25 / 48) for p in points)]:
            friction = problem.nodal_friction((at @ slip[nodes])[None])[0]
            work = np.linalg.norm(friction * (at @ tangential[nodes]))
            exact += weight * area * problem.normal[pane] * work
            if problem.normal[pane] > 0:
                ratio = np.linalg.norm(problem.tangential[pane] / friction)
                worst = max(worst, ratio / problem.normal[pane] - 1)
    inverse = problem.friction_inverse(problem.nodal_friction(slip))
    means = weights.T @ tangential
    averaged = problem.pane_area * problem.normal @ np.linalg.norm(means / inverse, axis=1)
    difference, excess = measured.levels[1].functional
    # Rules of degree 3 and 5 differ where |F u_t| has a kink: a few per mille of j on this mesh.
    assert difference == pytest.approx(averaged / exact - 1, abs=5e-3)
    # Points of one rule are nearer the corners than those of the other.
    assert excess == pytest.approx(worst, abs=0.05)
    assert excess > 0


def test_one_sliding_pane_contracts_as_its_closed_form(tmp_path):
    """With the pane sliding along -t1 or t1, lambda_nu = (h_nu +- F S_nut g) / S_nunu, so Psi' = +- F S_nut / S_nunu."""
    run = package.run(ONE_PANE, tmp_path / "pane.h5", set={"assemble.dual_operator": "explicit"})
    normal, (pulled, across) = run["solve/multiplier_normal"].item(), run["solve/multiplier_tangential"].values[0]
    # The pane slides: its circle is reached, along x by symmetry.
    assert abs(pulled) == pytest.approx(0.1 * normal, rel=1e-12) and abs(across) < 1e-9 * normal
    s = run["assemble/dual_operator"].values
    expected = 0.1 * abs(s[0, 1]) / s[0, 0]
    (level,) = measure(ONE_PANE).levels
    # One by one systems and their eigenvalues; a constant law gives the pressure alone a part in Psi'.
    assert level.contraction.spectral_radius == pytest.approx(expected, rel=1e-10)
    assert level.contraction.norms[1] == pytest.approx(expected, rel=1e-10)
    # A disturbance of 1e-8 shrinks by a factor that rounding changes by some 1e-8, over the factor itself, 0.02.
    assert level.observed_rate == pytest.approx(expected, rel=1e-6)
    # A constant law has no second term: the bound is that of F_max alone.
    of_face = 0.1 * level.energy.c_inv_half / math.sqrt(level.face.big_h) * level.energy.c_tr_2
    assert level.energy.q_weighted == pytest.approx(of_face, rel=1e-13)


def test_what_has_no_unit_does_not_depend_on_units():
    in_metres, in_millimetres = (measure(SCENE, set={**cells(2), **units}).levels[0] for units in ({}, {
        "units": {"length": "mm", "force": "N"},
        "body.brick.size": [3000.0, 1000.0, 1000.0],
        "material.isotropic.young_modulus": 21.19e4,
        "traction": [{"face": "x_max", "value": [10.0, 0.0, 20.0]}, {"face": "z_max", "value": [0.0, 0.0, -30.0]}],
        "friction": {f"coefficient_{k}": {"ramp": {"initial": 0.3, "residual": 0.2, "onset": 1e-2, "rate": rate}}
                     for k, rate in ((1, 3.0), (2, 1.0))},
    }))
    for one, other in zip(*([level.contraction.spectral_radius, level.contraction.norms[1], level.energy.q_weighted,
                             level.energy.q_composed, level.face.c_inv_infinity] for level in (in_metres, in_millimetres)), strict=True):
        # Iterations end at relative tolerances of 1e-8, whose squares are errors, or at the rounding of eight decimals.
        assert one == pytest.approx(other, rel=1e-8)


def test_findings_tell_apart_the_solution_followed_and_the_one_found():
    theory = measure(PIPELINES / "hard" / "two_nodes.toml")
    (level,) = theory.levels
    assert level.contraction.spectral_radius > 1.0 and level.radius_threshold is None
    followed = next(point.contraction for point in level.scaled if point.scale == 1.0)
    assert followed.spectral_radius < 1.0 and "is another one" in theory.findings


def test_mesh_files_serve_like_the_meshes_of_a_brick(tmp_path):
    """A family of mesh files, in any order, has the figures of the brick whose meshes they are."""
    nodal = {"contact.multipliers": "nodal"}
    expected = measure(SCENE, set={**cells(4), **nodal})
    for n_div in (4, 2):
        run = package.run(SCENE, tmp_path / "brick.h5", set={**cells(n_div), **nodal})
        (tmp_path / f"{n_div}.msh").write_text(gmsh(run))
    scene = SCENE.read_text().replace("[body.brick]", "[body.gmsh]\nfile = \"4.msh\"").replace("size =", "#").replace("cells =", "#")
    (tmp_path / "scene.toml").write_text(scene)
    found = measure(tmp_path / "scene.toml", set=nodal, meshes=["4.msh", "2.msh"])
    assert [level.mesh for level in found.levels] == ["2.msh", "4.msh"]
    for file, brick in zip(found.levels, expected.levels, strict=True):
        assert (file.unknowns, file.panes, file.multipliers) == (brick.unknowns, brick.panes, ())
        for one, two in zip(*([level.face.big_h, level.face.c_inv_10, level.contraction.spectral_radius, level.h1.alpha, level.energy.load,
                               level.h1.c_inv_half, level.energy.q] for level in (file, brick)), strict=True):
            # Eigenvalues settle to 1e-8 or so; the order of nodes and tetrahedra differs.
            assert one == pytest.approx(two, rel=1e-7)


def gmsh(run: package.Run) -> str:
    """A mesh as a Gmsh file of format 2.2, its faces as physical groups."""
    mesh = run["mesh"]
    names = str(mesh["face_names"].item()).split("\n")
    groups = [*(f'2 {k} "{name}"' for k, name in enumerate(names, 1)), f'3 {len(names) + 1} "body"']
    nodes = [f"{k} {x!r} {y!r} {z!r}" for k, (x, y, z) in enumerate(mesh["coordinates"].values.tolist(), 1)]
    faces = zip((mesh["facet_face"].values + 1).tolist(), (mesh["facets"].values + 1).tolist(), strict=True)
    elements = [f"2 2 {face} {face} {' '.join(map(str, corners))}" for face, corners in faces]
    body = len(names) + 1
    elements += [f"4 2 {body} 1 {' '.join(map(str, corners))}" for corners in (mesh["tetrahedra"].values + 1).tolist()]
    numbered = [f"{k} {element}" for k, element in enumerate(elements, 1)]
    parts = [("MeshFormat", ["2.2 0 8"]), ("PhysicalNames", [str(len(groups)), *groups]), ("Nodes", [str(len(nodes)), *nodes]),
             ("Elements", [str(len(numbered)), *numbered])]
    return "".join(f"${name}\n" + "\n".join(lines) + f"\n$End{name}\n" for name, lines in parts)


REFUSED = {
    "friction: ": {"friction": {"slip_bound": 1e6}},
    "contact.gap: ": {"contact.gap": 1e-5},
    "contact.obstacle: ": {"contact.obstacle.sphere": {"centre": [1.5, 0.5, -9.0], "radius": 9.0}},
    "body.element: ": {"body.element": "P2"},
    "clamp: contact nodes": {"clamp": [{"face": "x_min", "value": [1e-6, 0.0, 0.0]}]},
    "step: ": {"step": [{}]},
}


@pytest.mark.parametrize("key", REFUSED)
def test_scenes_that_the_theory_does_not_cover_are_refused_by_their_key(key):
    with pytest.raises(NotCovered, match=key):
        measure(SCENE, set={**cells(2), **REFUSED[key]})


def test_other_faces_bodies_and_meshes_are_refused():
    frictionless = PIPELINES / "frictionless.toml"
    for scene, words in ((frictionless, "friction"), (PIPELINES / "corner_block.toml", "contact"), (PIPELINES / "block_on_slope.toml", "clamp")):
        with pytest.raises(NotCovered, match=words):
            measure(scene)
    with pytest.raises(NotCovered, match="a multiple of the n_div of the scene, 2, found 3"):
        measure(SCENE, set=cells(2), finest=3)
    with pytest.raises(NotCovered, match="mesh files are for bodies from mesh files"):
        measure(SCENE, set=cells(2), meshes=["foot.msh"])
    with pytest.raises(package.BadInput, match="none.msh"):
        measure(PIPELINES / "gmsh_foot.toml", meshes=["meshes/none.msh"])


def test_the_command_line(tmp_path):
    def answer(*arguments: object) -> subprocess.CompletedProcess:
        command = [sys.executable, "-m", "contact3d.theory", *map(str, arguments)]
        path = {"PYTHONPATH": str(ROOT / "python")}
        return subprocess.run(command, capture_output=True, text=True, env={**__import__("os").environ, **path}, check=False)

    picture = tmp_path / "thresholds.png"
    small = ("--set", "body.brick.cells=[6,2,2]")
    printed = answer(SCENE, *small, "--figure", picture)
    assert printed.returncode == 0 and picture.is_file(), printed.stderr
    assert "contraction.spectral_radius" in printed.stdout and "uniqueness is proven for this law" in printed.stdout
    found = json.loads(answer(SCENE, *small, "--json").stdout)
    assert found["levels"][0]["mesh"] == "n_div = 2" and found["findings"].startswith("n_div = 2")
    for wrong in ((SCENE, *small, "--set", "contact.gap=1e-5"), (SCENE, "--set", "nonsense"), ("missing.toml",)):
        assert answer(*wrong).returncode == 2


def test_the_rule_is_exact_to_degree_five():
    points, weights = triangle_rule()
    for i, j, k in [(0, 0, 0), (1, 0, 0), (2, 1, 0), (2, 2, 0), (4, 0, 0), (2, 2, 1), (5, 0, 0)]:
        exact = 2 * math.factorial(i) * math.factorial(j) * math.factorial(k) / math.factorial(i + j + k + 2)
        assert weights @ np.prod(points ** [i, j, k], axis=1) == pytest.approx(exact, abs=1e-15)


def test_one_triangle_has_known_constants():
    face = ContactFace(np.array([[0.0, 0, 0], [1, 0, 0], [0, 1, 0]]), np.array([[0, 1, 2]]), np.arange(3))
    # Values (1, b, b) on an area of 1/2: |T| / 15 of the complete symmetric polynomial of degree 4 of (1, b, b).
    b = np.linspace(-1, 0, 10_001)
    least = np.min(0.5 / 15 * sum((k + 1) * b**k for k in range(5)))
    # Samples 1e-4 apart miss a minimum with unit curvature by 1e-9.
    assert (face.c_inv_infinity() / math.sqrt(face.h)) ** -4 == pytest.approx(least, rel=1e-7)
    # |phi| less its interpolant for phi = -1 at a corner that cuts the edges there at shares s and t, by midpoints.
    worst = 0.0
    for s, t in np.random.default_rng(3).uniform(0.05, 1.0, (200, 2)):
        for corner in range(3):
            values = np.roll([-1.0, 1 / s - 1, 1 / t - 1], corner)
            slope = values @ face.geometry[0][0]
            gap = 2 / 3 * 0.5 * (1 - s * t * (3 - s - t))
            worst = max(worst, gap / (0.5 * slope @ slope))
    assert 0.9 < math.sqrt(worst) / face.h / face.c_r_absolute() <= 1 + 1e-12


def test_interpolation_reproduces_coarse_functions():
    face = ContactFace(np.array([[0.0, 0, 0], [1, 0, 0], [0, 1, 0]]), np.array([[0, 1, 2]]), np.arange(3))
    fine, origin = face._cut(4)
    assert (len(fine.points), len(fine.triangles)) == (15, 16)
    assert fine.geometry[1].sum() == pytest.approx(0.5, rel=1e-14)
    assert origin @ np.ones(3) == pytest.approx(np.ones(15), rel=1e-15)


def test_projections_on_ellipses_and_their_derivatives():
    random = np.random.default_rng(11)
    points, axes = random.uniform(-3, 3, (200, 2)), random.uniform(0.2, 2, (200, 2))
    nearest, by_point, by_axis = nearest_in_ellipses(points, axes)
    outside = np.sum((points / axes) ** 2, axis=1) > 1
    assert nearest[~outside] == pytest.approx(points[~outside])
    # On the boundary, and the way there is along the outward normal p / a^2.
    assert np.sum((nearest / axes) ** 2, axis=1)[outside] == pytest.approx(1.0, abs=1e-13)
    way, normal = (points - nearest)[outside], (nearest / axes**2)[outside]
    across = way[:, 0] * normal[:, 1] - way[:, 1] * normal[:, 0]
    assert np.abs(across).max() < 1e-12 and np.sum(way * normal, axis=1).min() >= 0
    for k in range(2):
        step = 1e-6 * np.eye(2)[k]
        # Points near the boundary may cross it on the way.
        away = np.abs(np.sum((points / axes) ** 2, axis=1) - 1) > 1e-3
        for slopes, moved in ((by_point, lambda d: (points + d, axes)), (by_axis, lambda d: (points, axes + d))):
            difference = (nearest_in_ellipses(*moved(step))[0] - nearest_in_ellipses(*moved(-step))[0]) / 2e-6
            # Second differences of curves with radii of 0.02 at least.
            assert slopes[away, :, k] == pytest.approx(difference[away], abs=1e-5)
    assert nearest_in_ellipses(points, 0 * axes)[0] == pytest.approx(0 * points)


LAWS = {
    "ramp": {"ramp": {"initial": 0.4, "residual": 0.1, "onset": 0.1, "rate": 0.5}},
    "table": {"table": {"slip": [0.0, 0.2, 0.5], "value": [0.3, 0.5, 0.2]}},
    "grid": {"grid": {"slip_1": [0.0, 0.4], "slip_2": [0.1, 0.3, 0.6], "value": [[0.1, 0.3, 0.2], [0.5, 0.2, 0.4]]}},
    "formula": {"expression": "if(s < 0.3, k + 0.1*tanh(s1/0.2), 0.2 + x*min(s2, 0.3)^2) + 0*abs(y)"},
}


@pytest.mark.parametrize("kind", LAWS)
@pytest.mark.parametrize("isotropic", [True, False])
def test_slopes_of_laws_are_differences(kind, isotropic):
    law = FrictionLaw([LAWS[kind]] if isotropic else [LAWS[kind], {"constant": 0.3}], {"k": 0.25}, math.inf, scale=2.0)
    points, slip = np.random.default_rng(13).uniform(0.01, 0.7, (2, 300, 3))
    slip = slip[:, :2]
    values, slopes = law.at(points, slip)
    assert (values[:, 0] == values[:, 1]).all() == isotropic
    for k in range(2):
        step = 1e-6 * np.eye(2)[k]
        below, above = law.at(points, slip - step), law.at(points, slip + step)
        # Away from kinks, where slopes on both sides are the same.
        smooth = np.abs(above[1] - below[1]).max(axis=(1, 2)) < 1e-3
        assert smooth.sum() > 280
        assert slopes[smooth, :, k] == pytest.approx(((above[0] - below[0]) / 2e-6)[smooth], abs=1e-5)
