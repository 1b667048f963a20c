"""The bound of the error, from raw arrays: the forces between tetrahedra balance, and their stress is as far from the answer's."""

import h5py
import numpy as np
import pytest
from equilibrated import SIDES, area_vector, balanced_stress, distance, isotropic, strains

FORCE = np.array([0.0, 1e5, -4e5])
SCENE = """
title = "pressed, pulled and heavy"
body_force.value = [0.0, 1e5, -4e5]
[body]
element = "P2"
[body.brick]
size = [3.0, 1.0, 1.0]
cells = [3, 2, 2]
[material.isotropic]
young_modulus = 2e9
poisson_ratio = 0.3
[[clamp]]
face = "x_min"
[[pressure]]
face = "z_max"
value = 3e5
[[traction]]
face = "x_max"
value = [1e5, 0.0, 2e5]
[contact]
face = "z_min"
"""


@pytest.fixture(scope="module")
def bounded(tmp_path_factory, contact3d):
    """A solved scene with its bound."""
    folder = tmp_path_factory.mktemp("bound")
    (folder / "scene.toml").write_text(SCENE)
    contact3d("run", folder / "scene.toml", folder / "run.h5", "--no-figures")
    contact3d("bound", folder / "run.h5")
    with h5py.File(folder / "run.h5") as file:
        yield file


def test_the_forces_balance_every_tetrahedron_and_the_loads(bounded):
    points, tetrahedra = bounded["mesh/coordinates"][:], bounded["mesh/tetrahedra"][:]
    nodes, inside, forces = (bounded[f"bound/side_{name}"][:] for name in ("nodes", "tetrahedron", "force"))
    sides = {tuple(n): (t, f) for n, t, f in zip(nodes, inside, forces)}
    largest = np.abs(forces).max()
    for t, corners in enumerate(tetrahedra):
        volume = abs(np.linalg.det(points[corners][1:] - points[corners[0]])) / 6
        total = FORCE * volume
        moment = np.cross(points[corners].mean(axis=0), total)
        for side in SIDES:
            key = tuple(sorted(corners[side]))
            of, force = sides[key]
            sign = 1 if of == t else -1
            total = total + sign * force.sum(axis=0)
            moment = moment + sign * np.cross(points[list(key)], force).sum(axis=0)
        # Roundings of the minimisation, which moves forces some hundred times.
        assert np.abs(total).max() < 1e-9 * largest and np.abs(moment).max() < 1e-9 * largest
    names = bounded["mesh/face_names"][()].decode().split("\n")
    panes = dict(zip(bounded["mesh/contact_facets"][:], bounded["mesh/contact_facet_pane"][:]))
    traction = {"x_max": np.array([1e5, 0, 2e5]), "z_max": np.array([0, 0, -3e5])}
    for f, (triangle, face) in enumerate(zip(bounded["mesh/facets"][:], bounded["mesh/facet_face"][:])):
        key = tuple(sorted(triangle))
        of, force = sides[key]
        if names[face] == "x_min":
            continue
        area = np.linalg.norm(area_vector(points[list(key)], points[tetrahedra[of]].mean(axis=0)))
        acts = bounded["post/contact_traction"][panes[f]] if f in panes else traction.get(names[face], np.zeros(3))
        assert np.abs(force - acts * area / 3).max() < 1e-12 * largest


def test_their_stress_is_as_far_from_the_answer_as_the_bound_says(bounded):
    points, tetrahedra = bounded["mesh/coordinates"][:], bounded["mesh/tetrahedra"][:]
    middles, displacement = bounded["mesh/tetrahedron_mid_edges"][:], bounded["solve/displacement"][:]
    nodes, inside, forces = (bounded[f"bound/side_{name}"][:] for name in ("nodes", "tetrahedron", "force"))
    sides = {tuple(n): (t, f) for n, t, f in zip(nodes, inside, forces)}
    elasticity, own = isotropic(2e9, 0.3), strains(points, tetrahedra, middles, displacement)
    balanced = []
    for t, corners in enumerate(tetrahedra):
        own_forces = np.zeros((4, 3, 3))
        for k, side in enumerate(SIDES):
            key = tuple(sorted(corners[side]))
            of, force = sides[key]
            order = [key.index(n) for n in corners[side]]
            own_forces[k] = force[order] * (1 if of == t else -1)
        values, residual = balanced_stress(points[corners], own_forces, FORCE)
        # Stresses of 1e6 with the balance above.
        assert residual < 1e-9 * 1e6
        balanced.append(values)
    square = sum(distance(points[c], b, s, elasticity) for c, b, s in zip(tetrahedra, balanced, own))
    energy = 2 * bounded["post/resultants/strain_energy"][()]
    # Both sums have their own roundings; the square is a hundredth of the energies that cancel in one of them.
    assert np.sqrt(square / energy) == pytest.approx(bounded["bound/elements"][()], rel=1e-9)


def test_contact_adds_its_gap_of_duality(bounded):
    triangles, middles = bounded["mesh/facets"][:], bounded["mesh/facet_mid_edges"][:]
    displacement, panes = bounded["solve/displacement"][:], bounded["mesh/contact_facet_pane"][:]
    points, lifting, total = bounded["mesh/coordinates"][:], np.zeros(len(displacement)), 0.0
    contact = bounded["mesh/contact_facets"][:]
    coefficients = {}
    for f in contact:
        corners, edges = triangles[f], middles[f]
        # nu = -z, and the foundation is at the face itself.
        at = -displacement[corners, 2]
        pairs = [(0, 1), (1, 2), (2, 0)]
        between = [2 * -displacement[n, 2] - (at[a] + at[b]) / 2 for n, (a, b) in zip(edges, pairs)]
        lifted = np.maximum(np.concatenate([at, between]), 0)
        lifting[corners] = lifted[:3]
        for n, (a, b), c in zip(edges, pairs, lifted[3:]):
            lifting[n] = c / 2 + (lifted[a] + lifted[b]) / 4
        coefficients[f] = np.concatenate([at, between]) - lifted
    for f, pane in zip(contact, panes):
        area = np.linalg.norm(area_vector(points[triangles[f]], np.array([1.5, 0.5, 5.0])))
        total -= bounded["solve/multiplier_normal"][pane] * coefficients[f].mean() * area
    tetrahedra, elasticity = bounded["mesh/tetrahedra"][:], isotropic(2e9, 0.3)
    lift = np.outer(lifting, [0, 0, -1.0])
    strain = strains(points, tetrahedra, bounded["mesh/tetrahedron_mid_edges"][:], lift)
    energy = 2 * bounded["post/resultants/strain_energy"][()]
    work = sum(distance(points[c], np.zeros((4, 4, 6)), s, elasticity) for c, s in zip(tetrahedra, strain))
    assert np.sqrt(work / energy) == pytest.approx(bounded["bound/lifting"][()], rel=1e-9)
    assert np.sqrt(2 * total / energy) == pytest.approx(bounded["bound/complementarity"][()], rel=1e-7)
    # Lifting costs its norm, and adds to the distance of stresses.
    assert bounded["bound/total"][()] > bounded["bound/elements"][()] + 1e-3
