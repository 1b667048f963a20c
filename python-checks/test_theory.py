"""The theory of HKL section 3, computed again with scipy from the raw arrays of run files."""

from pathlib import Path

import h5py
import numpy as np
import pytest

from conftest import ROOT
from quadratic_program import polished
from raw_problem import RawProblem
from run_file import open_run
from schema_check import schema_problems
from theory import Face, Norms, lagrange_of_absolute, largest, sum_norm

SCENE = ROOT / "pipelines" / "newton.toml"
CLEMENT = ["--set", 'contact.slip_interpolation="clement"']


def cells(n_div: int) -> list[str]:
    """The flags that cut the published body in 3 n_div x n_div x n_div cells."""
    return ["--set", f"body.brick.cells=[{3 * n_div},{n_div},{n_div}]"]


@pytest.fixture(scope="module")
def measured(contact3d, tmp_path_factory) -> Path:
    """The theory of the published problem at n_div = 2 and 4."""
    path = tmp_path_factory.mktemp("theory") / "theory.h5"
    contact3d("theory", SCENE, path, "--no-figures", *cells(4))
    return path


@pytest.fixture(scope="module")
def runs(contact3d, tmp_path_factory) -> dict[int, Path]:
    """The published problem at n_div = 2 and 4 by `run`."""
    folder = tmp_path_factory.mktemp("theory-runs")
    paths = {n_div: folder / f"n{n_div}.h5" for n_div in (2, 4)}
    for n_div, path in paths.items():
        contact3d("run", SCENE, path, "--no-figures", *cells(n_div))
    return paths


@pytest.fixture(scope="module")
def solved(runs) -> dict[int, tuple[RawProblem, Face]]:
    """Their raw problems."""
    problems = {}
    for n_div, path in runs.items():
        with open_run(path) as file:
            problems[n_div] = read(file)
    return problems


def read(file: h5py.File) -> tuple[RawProblem, Face]:
    """The raw problem of a run file and its contact face."""
    problem = RawProblem.read(file)
    facets = file["mesh/facets"][:][file["mesh/contact_facets"][:]]
    return problem, Face.of(problem, facets)


@pytest.fixture(scope="module")
def norms(solved) -> dict[int, list[Norms]]:
    """Both norms of displacements on both meshes, in the order of the columns."""
    return {
        n_div: [Norms.first_sobolev(*pair), Norms.energy(*pair)]
        for n_div, pair in solved.items()
    }


def columns(file: h5py.File, name: str) -> np.ndarray:
    """A figure of both meshes in both norms."""
    return file[f"theory/norms/{name}"][:]


def test_the_file_is_what_the_schema_says(measured, schema):
    with open_run(measured) as file:
        assert schema_problems(file, schema) == []
        assert set(file) == {"scene", "theory"}
        assert file["theory/levels/n_div"][:].tolist() == [2, 4]


def test_constants_of_the_face(measured, solved):
    with open_run(measured) as file:
        levels = file["theory/levels"]
        for row, (_, face) in enumerate(solved.values()):
            assert levels["triangle_size"][row] == pytest.approx(face.size, rel=1e-14)
            # Lanczos' method ends at a residual of 1e-6, whose square is the error.
            expected = face.inverse_first()
            assert levels["inverse_first"][row] == pytest.approx(expected, rel=1e-9)
            least = min(face.least_fourth(node) for node in face.free)
            expected = np.sqrt(face.size) / least
            # The program adds rings of nodes until 1e-10; the Hessian here is shifted.
            assert levels["inverse_fourth"][row] == pytest.approx(expected, rel=1e-7)
            # A composite rule does not see the kink exactly.
            expected = lagrange_of_absolute(face)
            stored = levels["interpolation_lagrange"][row]
            assert stored == pytest.approx(expected, rel=1e-4)


def test_constants_in_both_norms(measured, norms):
    with open_run(measured) as file:
        size = file["theory/levels/pane_size"][:]
        for row, pair in enumerate(norms.values()):
            for k, norm in enumerate(pair):
                stored = lambda name, r=row, c=k: columns(file, name)[r, c]  # noqa: E731
                expected = {
                    "ellipticity": norm.ellipticity,
                    "continuity": norm.continuity,
                    "load": norm.load,
                    "inverse_half": norm.inverse_half(size[row]),
                    "trace_second": norm.trace_second(),
                    "trace_pointwise": norm.trace_largest(),
                    "trace_interpolated": norm.trace_absolute(),
                }
                for name, value in expected.items():
                    # Dense eigenvalues against Lanczos' method to a residual of 1e-6.
                    assert stored(name) == pytest.approx(value, rel=1e-8), name


def test_the_trace_in_the_fourth_power_is_no_smaller_than_its_samples(measured, norms):
    starts = np.random.default_rng(5).standard_normal((3, 10**6))
    with open_run(measured) as file:
        for k, norm in enumerate(norms[2]):
            shape = (norm.gram.shape[0] // 3, 3)
            random = [s[: norm.gram.shape[0]].reshape(shape) for s in starts]
            best = norm.trace_fourth([(norm.gram @ s.ravel()).reshape(shape) for s in random])
            # Both are local maxima to 1e-12, the program's from more starts.
            assert columns(file, "trace_fourth")[0, k] >= best * (1 - 1e-9)


def test_multipliers_over_glued_displacements_are_those_of_the_paper_in_h1_only(norms):
    for first, energy in norms.values():
        size = np.abs(first.normal_gram).max()
        # One factorisation; the tangential block decouples exactly.
        assert np.abs(first.glued_gram - first.normal_gram).max() <= 1e-12 * size
        assert largest(energy.normal_gram, energy.glued_gram) > 2.0


def test_bounds_follow_from_their_constants(measured):
    with open_run(measured) as file:
        law, levels = file["theory/law"], file["theory/levels"]
        h, big = (levels[name][:][:, None] for name in ("triangle_size", "pane_size"))
        first, fourth, c_r, c_t = (
            levels[name][:][:, None]
            for name in ("inverse_first", "inverse_fourth", "interpolation_lagrange", "axes")
        )
        get = lambda name: columns(file, name)  # noqa: E731
        alpha, continuity, load = (get(n) for n in ("ellipticity", "continuity", "load"))
        trace, trace_4, half = (
            get(n) for n in ("trace_second", "trace_fourth", "inverse_half")
        )
        image = trace * (first * c_r * c_t + 1)
        radius_1, radius_2 = image * load / alpha, (1 + continuity / alpha) * load
        steep = law["lipschitz"][()] * (2 + law["anisotropy"][()])
        a = law["coefficient_max"][()] / np.sqrt(big) * half * trace / alpha
        b = steep / np.sqrt(h * big) * half * fourth * trace_4 / alpha * radius_2
        q = (image + continuity) * np.maximum(a, b)
        gradient = trace * (np.sqrt(first**2 - h**2) * c_r * c_t + 1)
        weighted = continuity * a + gradient * b
        # The same formulas in another order.
        assert get("slip_radius") == pytest.approx(radius_1, rel=1e-13)
        assert get("pressure_radius") == pytest.approx(radius_2, rel=1e-13)
        assert get("contraction_bound") == pytest.approx(q, rel=1e-13)
        assert get("contraction_bound_weighted") == pytest.approx(weighted, rel=1e-12)
        assert get("threshold_bound") == pytest.approx(1 / q, rel=1e-13)


class Mapping:
    """Psi of HKL section 3 by MINPACK on the projected gradient of the inner problem."""

    def __init__(self, problem: RawProblem):
        self.problem = problem
        nodes, frame = problem.contact_nodes, problem.frame[1:].T
        moved = problem.solve_stiffness(problem.coupling.T.toarray())
        compliance = [problem.to_nodes(column)[nodes] @ frame for column in moved.T]
        self.compliance = np.stack(compliance)
        free = problem.to_nodes(problem.solve_stiffness(problem.load))
        self.free = free[nodes] @ frame

    def tangential(self, multiplier: np.ndarray) -> np.ndarray:
        """Signed (u_t1, u_t2) at the contact nodes."""
        return self.free - np.tensordot(multiplier, self.compliance, axes=1)

    def __call__(self, slip: np.ndarray, pressure: np.ndarray) -> np.ndarray:
        """The multipliers of the frozen problem."""
        problem = self.problem
        inverse = problem.friction_inverse(problem.nodal_friction(slip))
        bound = problem.slip_bound(np.maximum(pressure, 0.0))
        return polished(problem, problem.multiplier, bound, inverse)


def jacobian(problem: RawProblem, face: Face) -> np.ndarray:
    """Psi' at the stored solution by central differences, over free slips and pressures."""
    mapping = Mapping(problem)
    slip = np.abs(mapping.tangential(problem.multiplier))
    units = [slip.max(), problem.normal.max()]
    free = np.repeat(face.free, 2) * 2 + np.tile([0, 1], face.free.size)
    point = np.concatenate([slip.ravel()[free] / units[0], problem.normal / units[1]])

    def image(x: np.ndarray) -> np.ndarray:
        at = np.zeros(slip.size)
        at[free] = np.abs(x[: free.size]) * units[0]
        found = mapping(at.reshape(slip.shape), x[free.size :] * units[1])
        moved = np.abs(mapping.tangential(found)).ravel()[free]
        return np.concatenate([moved / units[0], found[: problem.n_panes] / units[1]])

    step = 1e-6
    differences = [
        (image(point + d) - image(point - d)) / (2 * step)
        for d in step * np.eye(point.size)
    ]
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
            sign = np.sign(np.linalg.det(np.eye(len(matrix)) - matrix))
            assert file["solve/determinant_sign"][()] == sign


def test_the_derivative_is_that_of_differences(measured, solved, jacobians, norms):
    _, face = solved[2]
    matrix = jacobians[2]
    radius = np.abs(np.linalg.eigvals(matrix)).max()
    n = 2 * face.free.size
    mass = np.kron(face.on_free(face.mass), np.eye(2))
    with open_run(measured) as file:
        # Central differences of answers accurate to 1e-13 over 1e-6.
        assert file["theory/levels/spectral_radius"][0] == pytest.approx(radius, rel=1e-6)
        rate = file["theory/levels/observed_rate"][0]
        # A disturbance of 1e-8, of which rounding is 1e-5, of a function with second derivatives.
        assert rate == pytest.approx(radius, rel=1e-4)
        for k, norm in enumerate(norms[2]):
            slip, pressure = np.linalg.cholesky(mass), np.linalg.cholesky(norm.glued_gram)
            # |x|^2 = |L' x|^2 turns norms into Euclidean ones.
            to_ball = [np.linalg.inv(slip.T), np.linalg.inv(pressure.T)]
            parts = {
                "slip_by_slip": slip.T @ matrix[:n, :n] @ to_ball[0],
                "slip_by_pressure": slip.T @ matrix[:n, n:] @ to_ball[1],
                "pressure_by_slip": pressure.T @ matrix[n:, :n] @ to_ball[0],
                "pressure_by_pressure": pressure.T @ matrix[n:, n:] @ to_ball[1],
            }
            for name, part in parts.items():
                expected = np.linalg.norm(part, 2)
                assert columns(file, name)[0, k] == pytest.approx(expected, rel=1e-5), name
            forms = {name: part.T @ part for name, part in parts.items()}
            sums = [
                sum_norm(forms[f"slip_by_{part}"], forms[f"pressure_by_{part}"])
                for part in ("slip", "pressure")
            ]
            stored = columns(file, "jacobian_norm")[0, k]
            # The search for the weight ends at a share of 1e-9 here.
            assert stored == pytest.approx(max(sums), rel=1e-3)


def test_lemma_3_3_and_the_stability_of_multipliers(measured, norms):
    with open_run(measured) as file:
        for name in ("lemma_slip", "lemma_pressure"):
            assert (0 < columns(file, name)).all() and (columns(file, name) <= 1).all()
        rows = file["theory/inf_sup"]
        wanted = (rows["level"][:] == 0) & (rows["space"][:] == 1)
        (place,) = np.flatnonzero(wanted)
        coarse, fine = norms[2][0], norms[4][0]
        gathered = gather(coarse.problem, fine.problem)
        finer = gathered @ fine.normal_gram @ gathered.T
        beta = 1 / np.sqrt(largest(finer, coarse.normal_gram))
        # Dense eigenvalues of small well-conditioned matrices.
        assert rows["inf_sup"][place] == pytest.approx(beta, rel=1e-10)


def gather(coarse: RawProblem, fine: RawProblem) -> np.ndarray:
    """1 where a pane of the fine mesh lies in one of the coarse mesh, else 0."""
    centres = [
        (p.pane_average.T @ p.coordinates[p.contact_nodes])[:, :2] for p in (coarse, fine)
    ]
    apart = np.abs(centres[0][:, None] - centres[1][None]).max(axis=2)
    inside = apart < 0.5 * np.sqrt(coarse.pane_area[0])
    assert (inside.sum(axis=0) == 1).all()
    return inside.astype(float)


def mean_of_absolute(corners: np.ndarray, parts: int = 200) -> np.ndarray:
    """The mean over a triangle of |v| for linear functions, by midpoints of parts^2 triangles."""
    i, j = (part.ravel() for part in np.mgrid[:parts, :parts])
    up = np.column_stack([i, j])[i + j < parts] + 1 / 3
    down = np.column_stack([i, j])[i + j < parts - 1] + 2 / 3
    at = np.vstack([up, down]) / parts
    barycentric = np.column_stack([1 - at.sum(axis=1), at])
    return np.abs(barycentric @ corners).mean(axis=0)


def test_the_friction_functional_of_the_program_beside_that_of_the_paper(measured, solved):
    problem, face = solved[4]
    mapping = Mapping(problem)
    tangential = mapping.tangential(problem.multiplier)
    slip, points = np.abs(tangential), np.array([[0.6, 0.2, 0.2], [0.2, 0.6, 0.2], [0.2, 0.2, 0.6]])
    weights = problem.pane_average.toarray()
    with open_run(measured) as file:
        difference = file["theory/levels/functional_difference"][1]
        excess = file["theory/levels/pointwise_excess"][1]
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
    # Rules of degree 3 and 5 differ where |F u_t| has a kink: a few per mille of j on this mesh.
    assert difference == pytest.approx(averaged / exact - 1, abs=5e-3)
    # Points of one rule are nearer the corners than those of the other.
    assert excess == pytest.approx(worst, abs=0.05)
    assert excess > 0


def test_clement_interpolation_is_the_mean_around_each_node(contact3d, tmp_path):
    path = tmp_path / "clement.h5"
    contact3d("run", SCENE, path, "--no-figures", *cells(2), *CLEMENT)
    with open_run(path) as file:
        problem, face = read(file)
        stored = file["solve/slip"][:] if "slip" in file["solve"] else None
        inverse = file["solve/friction_inverse"][:]
    mapping = Mapping(problem)
    tangential = mapping.tangential(problem.multiplier)
    sums, areas = np.zeros_like(tangential), np.zeros(len(tangential))
    for nodes in face.triangles:
        a, b, c = face.coordinates[nodes]
        area = np.linalg.norm(np.cross(b - a, c - a)) / 2
        sums[nodes] += area * mean_of_absolute(tangential[nodes])
        areas[nodes] += area
    slip = np.zeros_like(sums)
    slip[face.free] = sums[face.free] / areas[face.free, None]
    if stored is not None:
        assert stored == pytest.approx(slip, abs=1e-4 * slip.max())
    # Midpoints see the kink of |u| to 1e-5 or so.
    expected = problem.friction_inverse(problem.nodal_friction(slip))
    assert inverse == pytest.approx(expected, rel=1e-4)
    # Nodal values would give another friction.
    nodal = problem.friction_inverse(problem.nodal_friction(np.abs(tangential)))
    assert np.abs(nodal / inverse - 1).max() > 1e-2
    image = mapping(slip, problem.normal)
    change = np.linalg.norm(image - problem.multiplier)
    assert change <= 1e-4 * np.linalg.norm(problem.multiplier)
