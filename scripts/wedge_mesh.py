"""Writes the wedge of pipelines/wedge.toml: a brick of 8 x 4 x 4 cells, five tetrahedra each, whose
top rises by 1 in 5.

    python3 scripts/wedge_mesh.py > pipelines/meshes/wedge.msh
"""

import itertools

CELLS = (8, 4, 4)
LENGTH, WIDTH, HEIGHT, SLOPE = 2.0, 0.5, 0.5, 0.2

FACES = {
    "back": (0, 0),
    "front": (0, 1),
    "left": (1, 0),
    "right": (1, 1),
    "base": (2, 0),
    "top": (2, 1),
}


def number(node: tuple[int, int, int]) -> int:
    """The number of a node in the file, from 1."""
    i, j, k = node
    return 1 + i + (CELLS[0] + 1) * (j + (CELLS[1] + 1) * k)


def place(node: tuple[int, int, int]) -> tuple[float, float, float]:
    """Coordinates of a node."""
    x, y, z = (index / cells for index, cells in zip(node, CELLS))
    return LENGTH * x, WIDTH * y, z * (HEIGHT + SLOPE * LENGTH * x)


def tetrahedra():
    """Corners of all tetrahedra: four at odd corners of a cell and one between its even corners."""
    for cell in itertools.product(*map(range, CELLS)):
        bits = itertools.product((0, 1), repeat=3)
        corners = [tuple(c + b for c, b in zip(cell, offset)) for offset in bits]
        even = [c for c in corners if sum(c) % 2 == 0]
        yield even
        for odd in (c for c in corners if sum(c) % 2 == 1):
            yield [odd, *(e for e in even if sum(a != b for a, b in zip(e, odd)) == 1)]


def oriented(corners):
    """The same tetrahedron with a positive volume."""
    a, b, c, d = map(place, corners)
    u, v, w = ([q - p for p, q in zip(a, x)] for x in (b, c, d))
    volume = (
        u[0] * (v[1] * w[2] - v[2] * w[1])
        - u[1] * (v[0] * w[2] - v[2] * w[0])
        + u[2] * (v[0] * w[1] - v[1] * w[0])
    )
    return corners if volume > 0 else [corners[0], corners[1], corners[3], corners[2]]


def main() -> None:
    """Prints the mesh."""
    nodes = sorted(itertools.product(*(range(c + 1) for c in CELLS)), key=number)
    solids = [oriented(list(t)) for t in tetrahedra()]
    triangles = []
    for solid in solids:
        for three in itertools.combinations(solid, 3):
            for tag, (axis, end) in enumerate(FACES.values(), 1):
                if all(node[axis] == end * CELLS[axis] for node in three):
                    triangles.append((tag, three))
    print("$MeshFormat\n2.2 0 8\n$EndMeshFormat\n$PhysicalNames")
    print(len(FACES) + 1)
    for tag, name in enumerate(FACES, 1):
        print(f'2 {tag} "{name}"')
    print(f'3 {len(FACES) + 1} "body"\n$EndPhysicalNames\n$Nodes\n{len(nodes)}')
    for node in nodes:
        print(number(node), *place(node))
    print(f"$EndNodes\n$Elements\n{len(triangles) + len(solids)}")
    elements = [(2, tag, three) for tag, three in triangles]
    elements += [(4, len(FACES) + 1, solid) for solid in solids]
    for i, (kind, tag, corners) in enumerate(elements, 1):
        print(i, kind, 2, tag, tag, *map(number, corners))
    print("$EndElements")


if __name__ == "__main__":
    main()
