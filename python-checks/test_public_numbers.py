"""Round bodies of Code_Aster's public tests: the punch on a block of SSNA122, the hemisphere of SSNV104."""

import math

import numpy as np
import pytest

from run_file import open_run
from structured_mesh import mesh_text


def between(share, values):
    """Linear between equidistant values."""
    at = share * (len(values) - 1)
    first = min(int(at), len(values) - 2)
    return values[first] + (at - first) * (values[first + 1] - values[first])


def quarter_of_disc(u, v, radii):
    """From the unit square to a quarter of a disc whose rings have these radii."""
    x, y = u * math.sqrt(1 - v * v / 2), v * math.sqrt(1 - u * u / 2)
    share = min(math.hypot(x, y), 1.0)
    scale = between(share, radii) / share if share > 0 else 0.0
    return x * scale, y * scale


def quarter(radii, heights, profile, up, cells):
    """A quarter of a round body in z_min < |z| < the last height, whose side in z_min has a profile over its radius."""

    def place(u, v, w):
        x, y = quarter_of_disc(u, v, radii)
        bottom = profile(math.hypot(x, y))
        return x, y, up * (bottom + (1 - bottom / heights[-1]) * between(w, heights))

    def onto(x, y, z):
        return x, y, up * profile(math.hypot(x, y))

    return mesh_text(place, (cells[0], cells[0], cells[1]), "P2", onto)


PUNCH = """
title = "punch on a block"
units = {{ length = "mm", force = "N" }}
body = [
  {{ name = "punch", element = "P2", gmsh.file = "punch.msh", material.isotropic = {{ young_modulus = 2.1e5, poisson_ratio = 0.3 }} }},
  {{ name = "block", element = "P2", gmsh.file = "block.msh", material.isotropic = {{ young_modulus = 7e4, poisson_ratio = 0.3 }} }},
]
clamp = [
  {{ face = "punch.x_min", components = ["x"] }}, {{ face = "punch.y_min", components = ["y"] }},
  {{ face = "block.x_min", components = ["x"] }}, {{ face = "block.y_min", components = ["y"] }},
  {{ face = "block.z_max" }},
]
pressure = [{{ face = "punch.z_max", value = 100.0 }}]
contact.between = ["punch.z_min", "block.z_min"]
{friction}
"""


def test_a_steel_punch_sinks_into_an_aluminium_block(contact3d, tmp_path):
    """SSNA122, NAFEMS R0094-2: the middle of the contact sinks by 0.130734 mm without friction and by 0.128580 mm with F = 0.1."""

    def rounded(r):
        return 10 - math.sqrt(max(100 - (r - 40) ** 2, 0.0)) if r > 40 else 0.0

    # Rings and layers, fine where the punch leaves the block; there are fewer cells, and lines between these radii.
    steel = [0, 8, 16, 23, 29, 33.5, 37, 39.5, 41, 42.5, 44.5, 47, 50]
    aluminium = [0, 9, 17, 24, 30, 34.5, 37.8, 40, 41.5, 43.5, 47, 53, 63, 78, 100]
    down = [0, 2, 5, 10, 18, 30, 50, 75, 100]
    punch = quarter(steel, down, rounded, 1.0, (9, 6))
    block = quarter(aluminium, [*down[:-2], 85, 130, 200], lambda r: 0.0, -1.0, (10, 6))
    (tmp_path / "punch.msh").write_text(punch)
    (tmp_path / "block.msh").write_text(block)

    def sinks(friction):
        scene, path = tmp_path / "punch.toml", tmp_path / "punch.h5"
        scene.write_text(PUNCH.format(friction=friction))
        contact3d("run", scene, path, "--no-figures")
        with open_run(path) as file:
            # The quarter of a circle of chords bears a little less than 100 MPa times pi 50^2 / 4 mm^2.
            force = file["post/resultants/contact_force"][2]
            assert force == pytest.approx(100 * math.pi * 50**2 / 4, rel=3e-3)
            middle = np.flatnonzero((np.abs(file["mesh/coordinates"][:]) < 1e-9).all(axis=1))
            return file["solve/displacement"][:][middle, 2].mean()

    smooth, rough = sinks(""), sinks("friction.coefficient.constant = 0.1")
    # Other programs end 2.5 % away, as a prototype with twenty times the unknowns does; this mesh adds a half.
    assert [smooth, rough] == pytest.approx([-0.130734, -0.128580], rel=0.035)
    # What friction changes does not depend on what the mesh leaves of the fillet.
    assert rough - smooth == pytest.approx(0.002154, rel=0.03)
    assert rough / smooth == pytest.approx(0.128580 / 0.130734, abs=0.002)


HEMISPHERE = """
title = "hemisphere on a plane"
units = { length = "mm", force = "N" }
body = { element = "P2", gmsh.file = "hemisphere.msh" }
material.isotropic = { young_modulus = 2e4, poisson_ratio = 0.3 }
clamp = [
  { face = "x_min", components = ["x"] }, { face = "y_min", components = ["y"] },
  { face = "z_max", components = ["z"], value = [0.0, 0.0, -2.0] },
]
contact.face = "z_min"
contact.multipliers = "nodal"
contact.obstacle.half_space = { point = [0.0, 0.0, 0.0], normal = [0.0, 0.0, 1.0] }
"""


def test_a_hemisphere_is_pushed_against_a_plane(contact3d, tmp_path):
    """SSNV104: two spheres, 2 mm each; -2798.3 MPa at the pole and a radius of 10 mm, by Hertz for half-spaces."""
    radii = [48.5 * math.sinh(2.2 * k / 16) / math.sinh(2.2) for k in range(17)]
    heights = [50 * math.sinh(2.5 * k / 16) / math.sinh(2.5) for k in range(17)]
    ball = quarter(radii, heights, lambda r: 50 - math.sqrt(2500 - r * r), 1.0, (7, 5))
    (tmp_path / "hemisphere.msh").write_text(ball)
    scene, path = tmp_path / "hemisphere.toml", tmp_path / "hemisphere.h5"
    scene.write_text(HEMISPHERE)
    contact3d("run", scene, path, "--no-figures")
    with open_run(path) as file:
        pressure, area = file["solve/multiplier_normal"][:], file["mesh/pane_area"][:]
        force = 4 * pressure @ area
    # The body is no half-space, and contact a fifth of its radius: 4 %, where the published test allows 14 %.
    assert pressure.max() == pytest.approx(2798.3, rel=0.04)
    # A body held at a depth of five radii of contact; Hertz at the force that it bears.
    modulus = 2e4 / (1 - 0.3**2)
    radius = (3 * force * 50 / (4 * modulus)) ** (1 / 3)
    assert radius == pytest.approx(10.0, rel=0.05)
    assert pressure.max() == pytest.approx(3 * force / (2 * math.pi * radius**2), rel=0.03)
