"""Meshes of bent bricks in Gmsh's format 2.2: cells of six tetrahedra, whose nodes a function places.

    python3 scripts/structured_mesh.py    # writes the meshes of pipelines/two_cylinders.toml and pipelines/two_balls.toml
"""

import itertools
import math
from collections.abc import Callable
from pathlib import Path

Place = Callable[[float, float, float], tuple[float, float, float]]
"""From the unit cube to the body."""

FACES = ("x_min", "x_max", "y_min", "y_max", "z_min", "z_max")

# The six paths along the edges of a cell from its first corner to its last.
PATHS = [
    [(0, 0, 0), *itertools.accumulate(steps, lambda a, b: tuple(map(sum, zip(a, b))))]
    for steps in itertools.permutations([(1, 0, 0), (0, 1, 0), (0, 0, 1)])
]
EDGES = [(0, 1), (1, 2), (0, 2), (0, 3), (2, 3), (1, 3)]
TRIANGLE_EDGES = [(0, 1), (1, 2), (0, 2)]


def mesh_text(place: Place, cells: tuple[int, int, int], element: str) -> str:
    """The file of a body with so many cells; all nodes of quadratic elements lie where `place` puts them."""
    n = 2 if element == "P2" else 1
    numbers: dict[tuple[int, ...], int] = {}

    def at(node):
        return place(*(index / (n * count) for index, count in zip(node, cells)))

    def nodes(corners, edges):
        middles = [tuple((a + b) // 2 for a, b in zip(corners[i], corners[j])) for i, j in edges]
        return [numbers.setdefault(node, len(numbers) + 1) for node in corners + middles * (n - 1)]

    solids, sides = [], []
    for cell in itertools.product(*map(range, cells)):
        for path in PATHS:
            corners = [tuple(n * (c + d) for c, d in zip(cell, step)) for step in path]
            if volume(*map(at, corners)) < 0.0:
                corners = [corners[0], corners[2], corners[1], corners[3]]
            solids.append(nodes(corners, EDGES))
            for three in itertools.combinations(corners, 3):
                for tag, (axis, end) in enumerate(itertools.product(range(3), (0, 1)), 1):
                    if all(node[axis] == end * n * cells[axis] for node in three):
                        sides.append((tag, nodes(list(three), TRIANGLE_EDGES)))
    names = [f'2 {tag} "{name}"' for tag, name in enumerate(FACES, 1)] + ['3 7 "body"']
    points = [" ".join(map(repr, (number, *at(node)))) for node, number in numbers.items()]
    triangle, tetrahedron = (9, 11) if n == 2 else (2, 4)
    elements = [(triangle, tag, side) for tag, side in sides] + [(tetrahedron, 7, solid) for solid in solids]
    lines = [" ".join(map(str, (i, kind, 2, tag, tag, *of))) for i, (kind, tag, of) in enumerate(elements, 1)]
    return "\n".join([
        "$MeshFormat", "2.2 0 8", "$EndMeshFormat",
        "$PhysicalNames", "7", *names, "$EndPhysicalNames",
        "$Nodes", str(len(points)), *points, "$EndNodes",
        "$Elements", str(len(lines)), *lines, "$EndElements", "",
    ])  # fmt: skip


def volume(a, b, c, d) -> float:
    """Six times the volume of a tetrahedron."""
    u, v, w = ([q - p for p, q in zip(a, x)] for x in (b, c, d))
    return (
        u[0] * (v[1] * w[2] - v[2] * w[1])
        - u[1] * (v[0] * w[2] - v[2] * w[0])
        + u[2] * (v[0] * w[1] - v[1] * w[0])
    )


def half_cylinder(radius: float, width: float, end: float, half_angle: float = math.radians(70)) -> Place:
    """Half of a cylinder along y whose lowest line (`end` = 1) or highest one (-1) is the y axis: z_min is round, cells shrink towards it."""

    def place(x, y, z):
        along, up = 2 * x - 1, z**1.8
        graded = math.copysign(abs(along) ** 2.2, along)
        angle = half_angle * graded
        flat = radius * math.sin(half_angle) * graded
        across = (1 - up) * radius * math.sin(angle) + up * flat
        height = (1 - up) * radius * (1 - math.cos(angle)) + up * radius
        return across, width * y, end * height

    return place


def ball_quarter(radius: float, edge: float, end: float, steepness: float = 3.0) -> Place:
    """A quarter of a block on the planes x = 0 and y = 0 whose lower face (`end` = 1) or upper one (-1) is a ball that touches z = 0."""

    def place(*at):
        x, y, z = (edge * math.sinh(steepness * s) / math.sinh(steepness) for s in at)
        lift = radius - math.sqrt(radius**2 - x * x - y * y)
        return x, y, end * (z + (1 - z / edge) * lift)

    return place


def main() -> None:
    """Writes the meshes of the pipelines."""
    folder = Path(__file__).resolve().parent.parent / "pipelines" / "meshes"
    bodies = {
        "upper_cylinder": (half_cylinder(8.0, 0.2, 1.0), (24, 1, 8), "P2"),
        "lower_cylinder": (half_cylinder(8.0, 0.2, -1.0), (20, 1, 8), "P2"),
        "lower_ball": (ball_quarter(60.0, 10.0, -1.0), (4, 4, 4), "P2"),
    }
    for name, (place, cells, element) in bodies.items():
        (folder / f"{name}.msh").write_text(mesh_text(place, cells, element))


if __name__ == "__main__":
    main()
