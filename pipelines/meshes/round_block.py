"""Writes round_block.msh: a quarter of a block of 10 mm whose lower end is a ball of 40 mm.

Quadratic tetrahedra, six to a cell, between planes that shrink towards the contact; all nodes of the lower face, those
in the middle of edges included, lie on the ball.
"""

import itertools
import math
from pathlib import Path

CELLS, STEEPNESS, EDGE, RADIUS = 5, 3.0, 10.0, 40.0

# The six paths along the edges of a cell from its first corner to its last.
PATHS = [
    [(0, 0, 0)] + list(itertools.accumulate(steps, lambda a, b: tuple(map(sum, zip(a, b)))))
    for steps in itertools.permutations([(1, 0, 0), (0, 1, 0), (0, 0, 1)])
]
EDGES = [(0, 1), (1, 2), (0, 2), (0, 3), (2, 3), (1, 3)]
SIDES = [(1, 2, 3), (0, 3, 2), (0, 1, 3), (0, 2, 1)]
NAMES = ["x_min", "x_max", "y_min", "y_max", "round", "z_max"]


def place(index):
    """Coordinates of a point of the lattice of half cells."""
    x, y, z = (
        EDGE * math.sinh(STEEPNESS * i / (2 * CELLS)) / math.sinh(STEEPNESS) for i in index
    )
    lift = RADIUS - math.sqrt(RADIUS**2 - x * x - y * y)
    return x, y, z + (1 - z / EDGE) * lift


def tetrahedra():
    """Corners in the lattice of half cells, positively oriented."""
    for cell in itertools.product(range(CELLS), repeat=3):
        for path in PATHS:
            nodes = [tuple(2 * (c + d) for c, d in zip(cell, step)) for step in path]
            a, b, c, d = (place(n) for n in nodes)
            u, v, w = ([q - p for p, q in zip(a, other)] for other in (b, c, d))
            volume = sum(
                u[i] * (v[(i + 1) % 3] * w[(i + 2) % 3] - v[(i + 2) % 3] * w[(i + 1) % 3])
                for i in range(3)
            )
            yield nodes if volume > 0 else [nodes[0], nodes[2], nodes[1], nodes[3]]


def middle(a, b):
    """The point of the lattice between two corners."""
    return tuple((p + q) // 2 for p, q in zip(a, b))


def face_of(corners):
    """The face of the block that three corners lie on; None inside."""
    for axis, end in itertools.product(range(3), range(2)):
        if all(c[axis] == 2 * CELLS * end for c in corners):
            return 2 * axis + end
    return None


def main(name="round_block.msh"):
    tags, elements = {}, []
    tag = lambda node: tags.setdefault(node, len(tags) + 1)
    for t in tetrahedra():
        for side in SIDES:
            corners = [t[k] for k in side]
            face = face_of(corners)
            if face is not None:
                a, b, c = corners
                nodes = [*corners, middle(a, b), middle(b, c), middle(c, a)]
                elements.append((9, face + 1, [tag(n) for n in nodes]))
        nodes = t + [middle(t[a], t[b]) for a, b in EDGES]
        elements.append((11, 7, [tag(n) for n in nodes]))
    lines = ["$MeshFormat", "2.2 0 8", "$EndMeshFormat", "$PhysicalNames", "7"]
    lines += [f'2 {i + 1} "{name}"' for i, name in enumerate(NAMES)] + ['3 7 "block"']
    lines += ["$EndPhysicalNames", "$Nodes", str(len(tags))]
    for node, number in tags.items():
        lines.append(f"{number} " + " ".join(f"{x:.17g}" for x in place(node)))
    lines += ["$EndNodes", "$Elements", str(len(elements))]
    for number, (kind, group, nodes) in enumerate(elements, 1):
        lines.append(f"{number} {kind} 2 {group} {group} " + " ".join(map(str, nodes)))
    lines.append("$EndElements")
    Path(__file__).with_name(name).write_text("\n".join(lines) + "\n")


if __name__ == "__main__":
    main()
