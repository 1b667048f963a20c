"""Writes barrel.stl: the part above a quarter of a block of a roller of 40 mm radius along y, crowned by 80 mm, that touches z = 16 mm."""

import math

RADIUS, CROWN, TOP = 40.0, 80.0, 16.0
CELLS, REACH = (12, 6), (-1.0, 13.0)


def place(i, j):
    """The point of the roller above a node of the grid, to a tenth of a micrometre."""
    x, y = (round(REACH[0] + (REACH[1] - REACH[0]) * k / n, 3) for k, n in zip((i, j), CELLS, strict=True))
    around = RADIUS - CROWN + math.sqrt(CROWN**2 - y**2)
    return f"{x:.3f} {y:.3f} {TOP + RADIUS - math.sqrt(around**2 - x**2):.4f}"


if __name__ == "__main__":
    with open("barrel.stl", "w") as file:
        print("solid barrel", file=file)
        for i in range(CELLS[0]):
            for j in range(CELLS[1]):
                a, b, c, d = place(i, j), place(i, j + 1), place(i + 1, j + 1), place(i + 1, j)
                for corners in ((a, b, c), (a, c, d)):
                    print("facet normal 0 0 0\nouter loop", file=file)
                    print("\n".join(f"vertex {corner}" for corner in corners), file=file)
                    print("endloop\nendfacet", file=file)
        print("endsolid barrel", file=file)
