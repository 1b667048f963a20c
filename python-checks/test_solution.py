"""Everything in /post and the history of the solve, recomputed from raw arrays."""

import h5py
import numpy as np
import pytest

from conftest import ROOT
from run_file import facet_faces, read_enum

# Rows and columns of the components in files: xx, yy, zz, yz, xz, xy.
VOIGT = ([0, 1, 2, 1, 0, 0], [0, 1, 2, 2, 2, 1])
# Values that are a few roundings of their own size away from ours.
ROUNDING = 1e-13


def close(actual, expected, tolerance=ROUNDING):
    """Whether two arrays agree relative to the largest expected entry."""
    actual, expected = np.asarray(actual), np.asarray(expected)
    assert actual.shape == expected.shape
    return np.abs(actual - expected).max() <= tolerance * np.abs(expected).max()


@pytest.fixture(scope="module")
def integrals(problem):
    """B u: integrals of u_nu and of u_t1, u_t2 over the panes."""
    values = problem.coupling @ problem.free_displacement
    return values[: problem.n_panes], values[problem.n_panes :].reshape(-1, 2)


@pytest.fixture(scope="module")
def friction(problem):
    """Nodal F and pane means of its inverse for the slip of the solution."""
    nodal = problem.nodal_friction(problem.slip(problem.displacement))
    return nodal, problem.friction_inverse(nodal)


@pytest.fixture(scope="module")
def gradients(problem):
    """Volumes and hat function gradients of the tetrahedra, [n, 4, 3]."""
    corners = problem.coordinates[problem.tetrahedra]
    edges = corners[:, 1:] - corners[:, :1]
    inner = np.swapaxes(np.linalg.inv(edges), 1, 2)
    first = -inner.sum(axis=1, keepdims=True)
    return np.linalg.det(edges) / 6, np.concatenate([first, inner], axis=1)


@pytest.fixture(scope="module")
def stress(problem, gradients):
    """Stress matrices of the tetrahedra, [n, 3, 3]."""
    material = problem.scene["material"]["isotropic"]
    young, poisson = material["young_modulus"], material["poisson_ratio"]
    nodal = problem.displacement[problem.tetrahedra]
    gradient = np.einsum("eai,eaj->eij", nodal, gradients[1])
    strain = (gradient + np.swapaxes(gradient, 1, 2)) / 2
    trace = np.trace(strain, axis1=1, axis2=2)[:, None, None] * np.eye(3)
    dilation = poisson / (1 - 2 * poisson) * trace
    return young / (1 + poisson) * (strain + dilation)


@pytest.fixture(scope="module")
def nodal_forces(run, problem, gradients, stress):
    """Forces on all nodes: of the foundation, of the loads, of the clamps."""
    shape = problem.coordinates.shape
    volumes, hats = gradients
    internal = np.zeros(shape)
    shares = np.einsum("e,eij,eaj->eai", volumes, stress, hats)
    np.add.at(internal, problem.tetrahedra, shares)
    applied = np.zeros(shape)
    facets, faces = run["mesh/facets"][:], facet_faces(run["mesh"])
    for traction in problem.scene["traction"]:
        for nodes in facets[faces == traction["face"]]:
            a, b, c = problem.coordinates[nodes]
            area = np.linalg.norm(np.cross(b - a, c - a)) / 2
            applied[nodes] += area / 3 * np.array(traction["value"])
    stresses = np.column_stack([problem.normal, problem.tangential]) @ problem.frame
    contact = np.zeros(shape)
    pane_forces = problem.pane_area[:, None] * stresses
    contact[problem.contact_nodes] = -(problem.pane_average @ pane_forces)
    clamp = np.where(problem.dof < 0, internal - applied - contact, 0.0)
    return contact, applied, clamp


def test_displacement_solves_the_elastic_problem(problem):
    expected = problem.displacement_of(problem.multiplier)
    # Two factorisations of one matrix of condition 1e4 to 1e5, 1e-16 times that each.
    assert close(problem.displacement, expected, 1e-11)


def test_slip_and_friction_of_the_last_inner_problem(run, problem):
    assert close(run["solve/slip"][:], problem.slip(problem.displacement))
    inverse = problem.friction_inverse(run["solve/friction"][:])
    assert close(run["solve/friction_inverse"][:], inverse)
    # The bound is that of the pressure one step earlier, so within the last change of it.
    bound = run["solve/slip_bound"][:]
    change = run["solve/history/change"][-1] * np.linalg.norm(problem.multiplier)
    own = problem.slip_bound(problem.normal)
    assert np.linalg.norm(bound - own) <= change * (1 + ROUNDING)


def test_friction_of_the_solution(run, friction):
    nodal, inverse = friction
    # The steepest law here is 3000/m on slips of 1e-4 m: rounding grows by one at most.
    assert close(run["post/nodal_friction"][:], nodal)
    assert close(run["post/pane_friction"][:], 1 / inverse)


def test_no_pane_carries_more_than_its_bound(run, problem, friction):
    bound = problem.slip_bound(problem.normal)
    used = np.linalg.norm(friction[1] * problem.tangential, axis=1)
    # The answer is that accurate, measured as a mean over the face.
    allowed = 10 * run["solve/accuracy"][()] * problem.normal.max()
    assert (used <= bound + allowed).all()
    cap = problem.scene["friction"].get("pressure_cap")
    if cap is not None:
        # The case has panes on both sides of the cap, and some slip at it.
        assert 0 < np.count_nonzero(problem.normal > cap) < problem.n_panes
        assert np.count_nonzero(used >= cap - allowed) > 0


def test_contact_stresses(run, problem, friction):
    assert np.array_equal(run["post/normal_stress"][:], -problem.normal)
    assert np.array_equal(run["post/tangential_stress"][:], -problem.tangential)
    scaled = np.linalg.norm(friction[1] * problem.tangential, axis=1)
    assert close(run["post/scaled_tangential_stress"][:], scaled)


def test_margins(run, problem):
    bound = run["solve/slip_bound"][:]
    used = np.linalg.norm(run["solve/friction_inverse"][:] * problem.tangential, axis=1)
    touching = (problem.normal > 0) & (bound > 0)
    margin = np.ones(problem.n_panes)
    margin[touching] = 1 - used[touching] / bound[touching]
    # A difference of two numbers near 1.
    assert np.abs(run["post/margin"][:] - margin).max() <= ROUNDING


def test_zones(run, problem, integrals):
    """A pane slips when a trial step along its slip leaves the friction ellipse.

    The primal-dual sign of contact: the trial stress lambda_t + rho |R| u_t lies
    outside the ellipse on slipping panes (stress on the boundary, u_t along its
    normal) and inside on sticking ones (u_t = 0), with no tolerance to choose.
    """
    rho = problem.local_stiffness[problem.n_panes :].reshape(-1, 2)
    trial = problem.tangential + rho * integrals[1]
    used = np.linalg.norm(run["solve/friction_inverse"][:] * trial, axis=1)
    zones = np.where(used > run["solve/slip_bound"][:], "slip", "stick")
    zones[problem.normal <= 0] = "open"
    assert read_enum(run["post/contact_zone"]).tolist() == zones.tolist()
    counts = [np.count_nonzero(zones == zone) for zone in ("open", "stick", "slip")]
    assert run["post/zone_counts"][:].tolist() == counts
    assert counts[0] > 0 and counts[2] > 0  # the cases have more than one zone


@pytest.fixture
def explicit(contact3d, tmp_path):
    """A run whose file has S."""
    path = tmp_path / "run.h5"
    contact3d("run", ROOT / "pipelines" / "newton.toml", path, "--no-figures", "--set", "body.brick.cells=[12,4,4]")
    with h5py.File(path) as file:
        yield file


def test_the_dual_residual_is_gap_and_slip(explicit):
    """S lambda - h in the words of docs/reference/run_file.md, and the centres of panes."""
    run = explicit
    parts = [run["solve/multiplier_normal"][:], run["solve/multiplier_tangential"][:].ravel()]
    operator, rhs = run["assemble/dual_operator"][:], run["load/dual_rhs"][:]
    residual = operator @ np.concatenate(parts) - rhs
    area, gap, slip = run["mesh/pane_area"][:], run["post/pane_gap"][:], run["post/pane_slip"][:]
    expected = np.concatenate([area * gap, -(area[:, None] * slip).ravel()])
    # The residual of the solve and sums of n terms, relative to what cancels.
    assert np.abs(residual - expected).max() <= 1e-9 * np.abs(rhs).max()
    average = run["mesh/pane_average"]
    nodes = run["mesh/coordinates"][:][run["mesh/contact_nodes"][:]]
    columns = np.repeat(np.arange(len(area)), np.diff(average["indptr"][:]))
    centres = np.zeros((len(area), 3))
    np.add.at(centres, columns, average["data"][:][:, None] * nodes[average["indices"][:]])
    assert close(run["mesh/pane_centre"][:], centres)


def test_pane_slip_and_gap(run, problem, integrals):
    area = problem.pane_area
    local = problem.displacement[problem.contact_nodes] @ problem.frame.T
    mean = problem.pane_average.T @ local
    # Means of nodal values up to 4e-4 m that partly cancel, hence relative to those.
    limit = ROUNDING * np.abs(problem.displacement).max()
    assert np.abs(run["post/pane_slip"][:] - mean[:, 1:]).max() <= limit
    assert np.abs(run["post/pane_gap"][:] - (problem.gap - mean[:, 0])).max() <= limit
    # The same through B, which ties the stored N and T to the panes.
    assert np.abs(integrals[0] / area - mean[:, 0]).max() <= limit
    assert np.abs(integrals[1] / area[:, None] - mean[:, 1:]).max() <= limit


def test_stress(run, stress):
    # Strains are differences of displacements: about a digit of cancellation.
    assert close(run["post/stress"][:], stress[:, *VOIGT], 1e-12)


def von_mises(stress):
    """Of Voigt stresses, [n]."""
    xx, yy, zz, yz, xz, xy = np.transpose(stress)
    squares = (xx - yy) ** 2 + (yy - zz) ** 2 + (zz - xx) ** 2
    return np.sqrt(squares / 2 + 3 * (yz**2 + xz**2 + xy**2))


@pytest.fixture(scope="module")
def nodal_stress(run, problem, gradients, stress):
    """The recovered stress of every node: inside the body the linear polynomial nearest to the stresses at the centroids around it, weighted by
    volume; on the boundary the mean of those of its neighbours inside, or of its tetrahedra where there are none."""
    x, tetrahedra = problem.coordinates, problem.tetrahedra
    values, volumes = stress[:, *VOIGT], gradients[0]
    centroids = x[tetrahedra].mean(axis=1)
    stars = [np.flatnonzero((tetrahedra == node).any(axis=1)) for node in range(len(x))]
    fits = {}
    for node in np.setdiff1d(np.arange(len(x)), run["mesh/facets"][:]):
        star = stars[node]
        rows = np.column_stack([np.ones(len(star)), centroids[star] - x[node]])
        weight = np.sqrt(volumes[star])[:, None]
        fits[node] = np.linalg.lstsq(rows * weight, values[star] * weight)[0]
    nodal = []
    for node, star in enumerate(stars):
        near = [node] if node in fits else [n for n in np.unique(tetrahedra[star]) if n in fits]
        told = [np.append(1, x[node] - x[n]) @ fits[n] for n in near]
        nodal.append(np.mean(told, axis=0) if told else np.average(values[star], axis=0, weights=volumes[star]))
    return np.array(nodal)


def test_nodal_stresses(run, problem, stress, nodal_stress):
    # Polynomials of a few tetrahedra are extrapolated: another digit.
    assert close(run["post/nodal_stress"][:], nodal_stress, 1e-11)
    assert close(run["post/von_mises"][:], von_mises(nodal_stress), 1e-11)
    largest = run["post/largest_von_mises"]
    value = run["post/von_mises"][:].max()
    assert largest["value"][()] == value
    # How far tetrahedra and nodes differ around each node and its neighbours: another node may have the largest stress.
    tetrahedra = problem.tetrahedra
    differences = von_mises(stress[:, *VOIGT] - nodal_stress[tetrahedra].mean(axis=1))
    around, near = np.zeros((2, len(nodal_stress)))
    np.maximum.at(around, tetrahedra, differences[:, None])
    np.maximum.at(near, tetrahedra, around[tetrahedra].max(axis=1, keepdims=True))
    reach = von_mises(nodal_stress) + near
    place = (problem.coordinates == largest["place"][:]).all(axis=1).argmax()
    assert run["post/von_mises"][place] == value
    if "concentration" in largest:
        assert largest["error"][()] == np.inf
        at = (problem.coordinates == largest["concentration_place"][:]).all(axis=1)
        # Half the size of tetrahedra makes at most half as much again of it.
        may_lead = at.any() and max(reach[at.argmax()], 1.5 * run["post/von_mises"][at.argmax()]) > value
        assert may_lead or largest["concentration"][()] == b"contact"
        return
    least = max(1.5 * near[place], reach.max() - value)
    # The bar of the largest pressure may be wider.
    assert close(max(largest["error"][()], least), largest["error"][()], 1e-10)


def test_forces_and_moments(run, problem, nodal_forces):
    forces = np.array([f.sum(axis=0) for f in nodal_forces])
    moments = np.array(
        [np.cross(problem.coordinates, f).sum(axis=0) for f in nodal_forces]
    )
    stored = run["post/resultants"]
    names = ("contact_force", "applied_force", "clamp_force")
    # Clamp forces are sums of internal forces that cancel to 1e-2 of their size.
    assert close([stored[name][:] for name in names], forces, 1e-12)
    assert close(stored["moments"][:], moments, 1e-12)
    for name, parts in (("force", forces), ("moment", moments)):
        imbalance = np.linalg.norm(parts.sum(axis=0))
        imbalance /= np.linalg.norm(parts, axis=1).sum()
        # Equilibrium holds up to the rounding of the elastic solve.
        assert max(imbalance, stored[f"{name}_imbalance"][()]) <= 1e-12


def test_reactions_balance_the_stored_raw_arrays(problem, nodal_forces):
    """Free nodes carry no resultant force: internal = applied + contact."""
    contact, applied, _ = nodal_forces
    expected = problem.load - problem.coupling.T @ problem.multiplier
    # Both are sums of areas times stresses over the panes and triangles of a node.
    assert close(problem.to_free(applied + contact), expected)


def test_energies_and_extremes(run, problem):
    u, stored = problem.free_displacement, run["post/resultants"]
    area = problem.pane_area
    expected = {
        "strain_energy": u @ (problem.stiffness @ u) / 2,
        "load_work": problem.load @ u,
        "normal_force": area @ problem.normal,
        "largest_pressure": problem.normal.max(),
    }
    for name, value in expected.items():
        # Sums of a few hundred terms that cancel by at most a digit.
        assert stored[name][()] == pytest.approx(value, rel=1e-12), name
    # Along t2 the published scene has no resultant: relative to the larger one.
    assert close(stored["tangential_force"][:], area @ problem.tangential)
    largest = np.abs(problem.displacement).max(axis=0)
    assert np.array_equal(stored["largest_displacement_along"][:], largest)
    # Two roots in place of one: some roundings.
    assert stored["largest_displacement"][()] == pytest.approx(np.linalg.norm(problem.displacement, axis=1).max(), rel=1e-14)


def certificate(problem, integrals, friction) -> dict[str, float]:
    """The figures of merit, by their definitions in schemas/run_file.md."""
    u, area = problem.free_displacement, problem.pane_area
    inverse = friction[1]
    slip = integrals[1] / area[:, None]
    gap = problem.gap - integrals[0] / area
    residual = problem.stiffness @ u + problem.coupling.T @ problem.multiplier
    used = np.linalg.norm(inverse * problem.tangential, axis=1)
    bound = problem.slip_bound(problem.normal)
    most = bound * np.linalg.norm(slip / inverse, axis=1)
    missing = area @ np.abs(most - np.sum(problem.tangential * slip, axis=1))
    # r = S lambda - h = -(B u) + gap, so no matrix S is needed.
    r = np.concatenate([area * gap, -integrals[1].ravel()])
    rho, m = problem.local_stiffness, problem.n_panes
    step = problem.multiplier - rho * r
    nearest = problem.project(step, np.maximum(bound, 0), inverse)
    moved = np.abs(nearest - problem.multiplier)
    pressure = problem.normal.max()
    semi_axes = bound[:, None] / inverse
    shear = max(np.linalg.norm(problem.tangential, axis=1).max(), semi_axes.max())
    works = problem.multiplier**2 / rho
    return {
        "equilibrium": np.linalg.norm(residual - problem.load)
        / np.linalg.norm(problem.load),
        "penetration": (np.maximum(-gap, 0) * area * rho[:m]).max() / pressure,
        "adhesion": np.maximum(-problem.normal, 0).max() / pressure,
        "complementarity": (area @ np.abs(problem.normal * gap)) / works[:m].sum(),
        "friction_bound": np.maximum(used - bound, 0).max() / bound.max(),
        "slip_direction": missing / (area @ np.abs(most) + works[m:].sum()),
        "fixed_point": max(moved[:m].max() / pressure, moved[m:].max() / shear),
    }


def test_certificate(run, problem, integrals, friction):
    expected = certificate(problem, integrals, friction)
    assert set(run["post/certificate"]) == set(expected)
    for name, value in expected.items():
        # Every figure is a small difference of numbers of size 1 (after division), so
        # it carries their rounding, and that of a residual with 1e5 times larger
        # stiffness terms, whatever its own size.
        limit = 1e-9 * value + 1e-13
        assert abs(run[f"post/certificate/{name}"][()] - value) <= limit, name


def test_certificate_shows_a_converged_solution(run, problem):
    """Every figure is at most a small multiple of the accuracy that the solve reports."""
    accuracy = max(problem.scene["solve"]["epsilon"], run["solve/accuracy"][()])
    smallness = np.sqrt(problem.pane_area.mean() / problem.pane_area.min())
    for name, figure in run["post/certificate"].items():
        # Measured by local stiffness, a figure is an error of one component over the
        # largest one; the accuracy is a mean over the face, weighted by area.
        assert 0 <= figure[()] <= 10 * accuracy * smallness, name


def test_history_ends_converged(run, problem):
    history = run["solve/history"]
    epsilon = problem.scene["solve"]["epsilon"]
    change = history["change"][:]
    # The published rule at epsilon 1e-4 leaves a fraction of a per cent; the status says so.
    assert read_enum(run["solve/status"]) in ("converged", "reduced_accuracy")
    # The first step that changes little enough after an accurate enough inner solve.
    accuracy = problem.scene["solve"]["r_tol"] * epsilon
    ends = (change <= epsilon) & (history["inner_residual"][:] <= accuracy)
    assert np.flatnonzero(ends).tolist() == [change.size - 1]
    assert change[0] == 1.0  # from zero, everything is new
    assert history["applications"][:].sum() == run["solve/applications"][()]
    assert (history["inner_residual"][:] <= history["inner_tolerance"][:]).all()
    assert (history["seconds"][:] >= 0).all()


def test_history_counts_applications(run):
    """A step acts with A^-1 once per CG and proportioning step, twice per expansion,
    once for the first gradient and once for u; the first step also estimates |S|."""
    history = run["solve/history"]
    steps = (
        2 + history["conjugate_gradient_steps"][:] + history["proportioning_steps"][:]
    )
    steps += 2 * history["expansion_steps"][:]
    applications = history["applications"][:]
    assert np.array_equal(applications[1:], steps[1:])
    assert 1 <= applications[0] - steps[0] <= 30


def test_inner_tolerances_follow_remark_4_1(run, problem):
    solve, history = problem.scene["solve"], run["solve/history"]
    r_tol, change = solve["r_tol"], history["change"][:]
    if solve["precision"] == "fixed":  # strategy (a)
        expected = np.full(change.size, r_tol * solve["epsilon"])
    else:  # strategy (b)
        assert solve["precision"] == "adaptive"
        expected, last = [], r_tol / solve["c_fact"]
        for previous in [1.0, *change[:-1]]:
            last = min(r_tol * previous, solve["c_fact"] * last)
            last = max(last, r_tol * solve["epsilon"])  # no tighter than (a)
            expected.append(last)
    # One or two products per step.
    assert history["inner_tolerance"][:] == pytest.approx(expected, rel=1e-14)


def test_last_inner_residual(run, problem):
    """The reduced gradient of the last inner problem, with S made by scipy."""
    r = problem.dual_operator @ problem.multiplier - problem.dual_rhs
    nearest = problem.project(
        problem.multiplier - problem.steplength * r,
        run["solve/slip_bound"][:],
        run["solve/friction_inverse"][:],
    )
    reduced = (problem.multiplier - nearest) / problem.steplength
    size = np.linalg.norm(problem.dual_rhs)
    # r is a difference of vectors of the size of h, by two factorisations of A, and the
    # program updates it step by step: 1e-16 times the condition of A and a few steps.
    difference = (
        np.linalg.norm(reduced) / size - run["solve/history/inner_residual"][-1]
    )
    assert abs(difference) <= 1e-12
