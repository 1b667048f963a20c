"""Meshes of bent bricks in Gmsh's format 2.2: cells of six tetrahedra, whose nodes a function places.

    python3 scripts/structured_mesh.py    # writes the meshes of pipelines/two_cylinders.toml and pipelines/two_balls.toml
"""

import functools
import itertools
import math
from collections.abc import Callable
from pathlib import Path

Place = Callable[[float, float, float], tuple[float, float, float]]
"""From the unit cube to the body."""
Round = Callable[[float, float, float], tuple[float, float, float]]
"""From a point beside a face to the face."""

FACES = ("x_min", "x_max", "y_min", "y_max", "z_min", "z_max")

# The six paths along the edges of a cell from its first corner to its last.
PATHS = [
    [(0, 0, 0), *itertools.accumulate(steps, lambda a, b: tuple(map(sum, zip(a, b))))]
    for steps in itertools.permutations([(1, 0, 0), (0, 1, 0), (0, 0, 1)])
]
EDGES = [(0, 1), (1, 2), (0, 2), (0, 3), (2, 3), (1, 3)]
TRIANGLE_EDGES = [(0, 1), (1, 2), (0, 2)]


def mesh_text(place: Place, cells: tuple[int, int, int], element: str, onto: Round | None = None) -> str:
    """The file of a body with so many cells; `onto` bends the edges of quadratic elements in z_min."""
    numbers: dict[tuple[int, ...], int] = {}
    places: dict[tuple[int, ...], tuple[float, float, float]] = {}

    def number(node, at):
        places.setdefault(node, at)
        return numbers.setdefault(node, len(numbers) + 1)

    @functools.cache
    def corner(node):
        return place(*(index / (2 * count) for index, count in zip(node, cells)))

    def nodes(corners, edges):
        found = [number(node, corner(node)) for node in corners]
        for i, j in edges if element == "P2" else ():
            a, b = corners[i], corners[j]
            middle = tuple((x + y) / 2 for x, y in zip(corner(a), corner(b)))
            on_face = onto and a[2] == b[2] == 0
            found.append(number(tuple((x + y) // 2 for x, y in zip(a, b)), onto(*middle) if on_face else middle))
        return found

    solids, sides = [], []
    for cell in itertools.product(*map(range, cells)):
        for path in PATHS:
            corners = [tuple(2 * (c + d) for c, d in zip(cell, step)) for step in path]
            if volume(*map(corner, corners)) < 0.0:
                corners = [corners[0], corners[2], corners[1], corners[3]]
            solids.append(nodes(corners, EDGES))
            for three in itertools.combinations(corners, 3):
                for tag, (axis, end) in enumerate(itertools.product(range(3), (0, 1)), 1):
                    if all(node[axis] == 2 * end * cells[axis] for node in three):
                        sides.append((tag, nodes(list(three), TRIANGLE_EDGES)))
    names = [f'2 {tag} "{name}"' for tag, name in enumerate(FACES, 1)] + ['3 7 "body"']
    points = [" ".join(map(repr, (index, *places[node]))) for node, index in numbers.items()]
    triangle, tetrahedron = (9, 11) if element == "P2" else (2, 4)
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


def half_cylinder(radius: float, width: float, end: float) -> tuple[Place, Round]:
    """The part within 70 degrees of a cylinder along y whose lowest line (`end` = 1) or highest one (-1) is the y axis.

    Cells shrink towards this line.
    """
    half_angle = math.radians(70)

    def place(x, y, z):
        along, up = 2 * x - 1, z**1.8
        graded = math.copysign(abs(along) ** 2.2, along)
        angle, flat = half_angle * graded, radius * math.sin(half_angle) * graded
        across = (1 - up) * radius * math.sin(angle) + up * flat
        height = (1 - up) * radius * (1 - math.cos(angle)) + up * radius
        return across, width * y, end * height

    def onto(x, y, z):
        above = end * radius - z
        share = radius / math.hypot(x, above)
        return share * x, y, end * radius - share * above

    return place, onto


def ball_quarter(radius: float, edge: float, end: float) -> tuple[Place, Round]:
    """A quarter of a block between the planes x = 0 and y = 0 whose lower face (`end` = 1) or upper one (-1) is round.

    The ball touches the plane z = 0; cells shrink towards this point.
    """
    steepness = 2.5

    def place(*at):
        x, y, z = (edge * math.sinh(steepness * s) / math.sinh(steepness) for s in at)
        lift = radius - math.sqrt(radius**2 - x * x - y * y)
        return x, y, end * (z + (1 - z / edge) * lift)

    def onto(x, y, z):
        above = end * radius - z
        share = radius / math.sqrt(x * x + y * y + above * above)
        return share * x, share * y, end * radius - share * above

    return place, onto


def main() -> None:
    """Writes the meshes of the pipelines."""
    folder = Path(__file__).resolve().parent.parent / "pipelines" / "meshes"
    bodies = {
        "upper_cylinder": (half_cylinder(8.0, 0.2, 1.0), (40, 1, 8)),
        "lower_cylinder": (half_cylinder(8.0, 0.2, -1.0), (34, 1, 7)),
        "upper_ball": (ball_quarter(40.0, 10.0, 1.0), (8, 8, 5)),
        "lower_ball": (ball_quarter(60.0, 10.0, -1.0), (7, 7, 5)),
    }
    for name, ((place, onto), cells) in bodies.items():
        (folder / f"{name}.msh").write_text(mesh_text(place, cells, "P2", onto))


if __name__ == "__main__":
    main()
