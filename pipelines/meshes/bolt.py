"""Writes bolt.msh: quarters of a drilled bolt with a head and of two plates around it, in mm, as three volumes that share no nodes."""

import itertools
import math
import sys
from pathlib import Path

sys.path.append(str(Path(__file__).resolve().parents[2] / "scripts"))
from structured_mesh import PATHS, volume

ANGLES = 8
# Of each body the radii and heights of its cells, the profile of radius and height that it fills, and its faces by a test of both.
BODIES = {
    "bolt": (
        [2.0, 3.5, 5.0, 5.5, 7.0, 8.5],
        [-10.0, -7.0, -4.0, 0.0, 4.0, 7.0, 10.0, 12.5, 15.0],
        lambda r, z: r < 5.0 or z > 10.0,
        {"under_head": lambda r, z: z == 10.0 and r >= 5.0, "end": lambda r, z: z == -10.0},
    ),
    "upper": (
        [5.5, 7.0, 8.5, 11.0, 14.0, 17.0, 20.0],
        [0.0, 3.5, 7.0, 10.0],
        lambda r, z: True,
        {"top": lambda r, z: z == 10.0 and r <= 14.0, "rim": lambda r, z: z == 10.0 and r >= 14.0, "joint": lambda r, z: z == 0.0},
    ),
    "lower": (
        [5.5, 7.0, 9.0, 12.0, 16.0, 20.0],
        [-10.0, -6.5, -3.0, 0.0],
        lambda r, z: True,
        {"joint": lambda r, z: z == 0.0, "seat": lambda r, z: z == -10.0 and r <= 9.0},
    ),
}


def main() -> None:
    points, elements = [], []
    surfaces = ["x_min", "y_min", *dict.fromkeys(face for body in BODIES.values() for face in body[3])]
    names = [f'2 {tag} "{face}"' for tag, face in enumerate(surfaces, 1)]
    for body, (radii, heights, fills, faces) in BODIES.items():
        numbers: dict[tuple[int, ...], int] = {}
        names.append(f'3 {len(names) + 1} "{body}"')
        of_body = len(names)

        def number(node):
            r, angle, z = radii[node[0]], math.pi / 2 * node[1] / ANGLES, heights[node[2]]
            if node not in numbers:
                points.append(f"{len(points) + 1} {r * math.cos(angle):.9g} {r * math.sin(angle):.9g} {z:.9g}")
                numbers[node] = len(points)
            return numbers[node]

        def place(node):
            r, angle = radii[node[0]], math.pi / 2 * node[1] / ANGLES
            return r * math.cos(angle), r * math.sin(angle), heights[node[2]]

        sides: dict[tuple[tuple[int, ...], ...], list[tuple[int, ...]] | None] = {}
        for i, j, k in itertools.product(range(len(radii) - 1), range(ANGLES), range(len(heights) - 1)):
            if not fills((radii[i] + radii[i + 1]) / 2, (heights[k] + heights[k + 1]) / 2):
                continue
            for path in PATHS:
                corners = [(i + a, j + b, k + c) for a, b, c in path]
                if volume(*map(place, corners)) < 0.0:
                    corners = [corners[0], corners[2], corners[1], corners[3]]
                elements.append((4, of_body, [number(node) for node in corners]))
                for three in itertools.combinations(corners, 3):
                    key = tuple(sorted(three))
                    sides[key] = None if key in sides else list(three)
        for three in filter(None, sides.values()):
            named = [face for face, holds in faces.items() if all(holds(radii[r], heights[z]) for r, _, z in three)]
            planes = [face for face, at in (("y_min", 0), ("x_min", ANGLES)) if all(node[1] == at for node in three)]
            for face in (named + planes)[:1]:
                elements.append((2, surfaces.index(face) + 1, [number(node) for node in three]))
    lines = [f"{k} {kind} 2 {tag} {tag} {' '.join(map(str, nodes))}" for k, (kind, tag, nodes) in enumerate(elements, 1)]
    text = ["$MeshFormat", "2.2 0 8", "$EndMeshFormat", "$PhysicalNames", str(len(names)), *names, "$EndPhysicalNames"]
    text += ["$Nodes", str(len(points)), *points, "$EndNodes", "$Elements", str(len(lines)), *lines, "$EndElements", ""]
    Path("bolt.msh").write_text("\n".join(text))


if __name__ == "__main__":
    main()
