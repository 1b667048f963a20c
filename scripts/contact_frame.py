"""Draws docs/contact_frame.svg: the frame of the contact face, and which way contact.angle turns.

`python3 scripts/contact_frame.py` writes the picture; `--check` says whether it is up to date.
"""

import math
import sys
from pathlib import Path

PICTURE = Path(__file__).resolve().parent.parent / "docs" / "contact_frame.svg"
ANGLE = 30.0

X, Y, Z = (1.0, 0.0, 0.0), (0.0, 1.0, 0.0), (0.0, 0.0, 1.0)
NORMAL = (0.0, 0.0, -1.0)  # outward on z_min

BLACK, GREY, BLUE, ORANGE = "#000000", "#8a8a8a", "#00559c", "#c44e00"


def cross(a, b):
    """The vector product."""
    pairs = ((1, 2), (2, 0), (0, 1))
    return tuple(a[p] * b[q] - a[q] * b[p] for p, q in pairs)


def turned(first, degrees):
    """t1 turned towards t2 = t1 x nu."""
    second = cross(first, NORMAL)
    c, s = math.cos(math.radians(degrees)), math.sin(math.radians(degrees))
    return tuple(c * a + s * b for a, b in zip(first, second))


class Drawing:
    """SVG elements, drawn through a projection of points in space to pixels."""

    def __init__(self):
        self.parts = []

    def line(self, start, end, colour, width=1.2, dash=""):
        """A line between two pixels."""
        dashes = f' stroke-dasharray="{dash}"' if dash else ""
        self.parts.append(
            f'<line x1="{start[0]:.1f}" y1="{start[1]:.1f}" x2="{end[0]:.1f}" y2="{end[1]:.1f}" '
            f'stroke="{colour}" stroke-width="{width}"{dashes}/>'
        )

    def polygon(self, points, fill, edge="none"):
        """A filled polygon."""
        path = " ".join(f"{x:.1f},{y:.1f}" for x, y in points)
        self.parts.append(f'<polygon points="{path}" fill="{fill}" stroke="{edge}"/>')

    def text(self, place, words, colour=BLACK, size=15, anchor="middle"):
        """Words at a pixel."""
        self.parts.append(
            f'<text x="{place[0]:.1f}" y="{place[1]:.1f}" fill="{colour}" font-size="{size}" '
            f'text-anchor="{anchor}">{words}</text>'
        )

    def arrow(self, start, end, colour, words, width=2.2, beyond=16.0):
        """An arrow with its name beyond the tip."""
        dx, dy = end[0] - start[0], end[1] - start[1]
        length = math.hypot(dx, dy)
        ux, uy = dx / length, dy / length
        neck = (end[0] - 9 * ux, end[1] - 9 * uy)
        self.line(start, neck, colour, width)
        barbs = [(neck[0] + s * 4.5 * uy, neck[1] - s * 4.5 * ux) for s in (1, -1)]
        self.polygon([end, *barbs], colour)
        place = (end[0] + beyond * ux, end[1] + beyond * uy + 5)
        self.text(place, words, colour)

    def arc(self, centre, radius, degrees, colour, words):
        """An arrow that turns counterclockwise from the right."""
        points = [
            (
                centre[0] + radius * math.cos(math.radians(a)),
                centre[1] - radius * math.sin(math.radians(a)),
            )
            for a in [degrees * k / 24 for k in range(23)]
        ]
        path = " ".join(f"{x:.1f},{y:.1f}" for x, y in points)
        self.parts.append(
            f'<polyline points="{path}" fill="none" stroke="{colour}" stroke-width="1.6"/>'
        )
        a = math.radians(degrees)
        tip = (centre[0] + radius * math.cos(a), centre[1] - radius * math.sin(a))
        tangent = (-math.sin(a), -math.cos(a))
        base = (tip[0] - 8 * tangent[0], tip[1] - 8 * tangent[1])
        barbs = [
            (base[0] + s * 4 * tangent[1], base[1] - s * 4 * tangent[0])
            for s in (1, -1)
        ]
        self.polygon([tip, *barbs], colour)
        middle = math.radians(degrees / 2)
        place = (
            centre[0] + (radius + 24) * math.cos(middle),
            centre[1] - (radius + 24) * math.sin(middle) + 5,
        )
        self.text(place, words, colour)


def in_space(drawing):
    """The brick above its foundation, with nu, t1 and t2 = t1 x nu."""
    right, up = (0.80, -0.16), (0.0, 1.0)
    back = (0.46, 0.30)

    def pixel(p):
        a = [p[0] * r + p[1] * b + p[2] * u for r, b, u in zip(right, back, up)]
        return (70 + 150 * a[0], 250 - 150 * a[1])

    size = (1.5, 1.0, 0.7)
    def corner(i, j, k):
        return pixel((i * size[0], j * size[1], k * size[2]))

    ground = [(-0.2, -0.25), (1.75, -0.25), (1.75, 1.2), (-0.2, 1.2)]
    drawing.polygon([pixel((x, y, 0.0)) for x, y in ground], "#eeeeee", "#c8c8c8")
    bottom = [corner(0, 0, 0), corner(1, 0, 0), corner(1, 1, 0), corner(0, 1, 0)]
    drawing.polygon(bottom, "#cfe1f4", BLUE)
    edges = [
        ((0, 0, 0), (0, 0, 1)), ((1, 0, 0), (1, 0, 1)), ((1, 1, 0), (1, 1, 1)),
        ((0, 0, 1), (1, 0, 1)), ((1, 0, 1), (1, 1, 1)), ((1, 1, 1), (0, 1, 1)),
        ((0, 1, 1), (0, 0, 1)), ((0, 1, 0), (0, 1, 1)),
    ]
    for start, end in edges:
        hidden = start == (0, 1, 0)
        drawing.line(corner(*start), corner(*end), GREY, 1.0, "4 4" if hidden else "")
    centre = (0.55, 0.4, 0.0)
    first = X
    second = cross(first, NORMAL)
    for vector, colour, name, length in (
        (first, BLUE, "t₁", 0.75),
        (second, ORANGE, "t₂ = t₁ × ν", 0.6),
        (NORMAL, BLACK, "ν", 0.45),
    ):
        tip = tuple(c + length * v for c, v in zip(centre, vector))
        beyond = 40.0 if "×" in name else 14.0
        drawing.arrow(pixel(centre), pixel(tip), colour, name, beyond=beyond)
    drawing.text((200, 28), "Contact face z_min and its frame", size=16)
    drawing.text((200, 350), "ν points out of the body; t₁, t₂, −ν are right-handed", size=13)


def in_plan(drawing):
    """The contact face seen from inside the body: z_min from above."""
    def pixel(p):
        return (520 + 150 * p[0], 265 - 150 * p[1])

    face = [pixel(p) for p in ((-0.7, -0.2), (1.25, -0.2), (1.25, 1.2), (-0.7, 1.2))]
    drawing.polygon(face, "#cfe1f4", BLUE)
    origin = (0.0, 0.0, 0.0)
    for vector, name in ((X, "x"), (Y, "y")):
        drawing.line(pixel(origin), pixel(vector), GREY, 1.0, "4 4")
        drawing.text(pixel(tuple(1.08 * v for v in vector)), name, GREY)
    first = turned(X, ANGLE)
    second = cross(first, NORMAL)
    drawing.arrow(pixel(origin), pixel(first), BLUE, "t₁")
    drawing.arrow(pixel(origin), pixel(second), ORANGE, "t₂")
    drawing.arc(pixel(origin), 80, ANGLE, BLACK, "angle")
    drawing.text((570, 28), "From inside the body (here: from above)", size=16)
    drawing.text((570, 350), f"contact.angle = {ANGLE:.0f}: counterclockwise, from t₁ towards t₂", size=13)


def picture():
    """The whole drawing as SVG."""
    drawing = Drawing()
    in_space(drawing)
    in_plan(drawing)
    body = "\n".join(drawing.parts)
    return (
        '<svg xmlns="http://www.w3.org/2000/svg" viewBox="0 0 770 370" '
        'font-family="DejaVu Sans, sans-serif">\n'
        '<rect width="770" height="370" fill="#ffffff"/>\n'
        f"{body}\n</svg>\n"
    )


def main():
    """Writes the picture, or checks it."""
    if sys.argv[1:] == ["--check"]:
        sys.exit(PICTURE.read_text() != picture())
    PICTURE.write_text(picture())


if __name__ == "__main__":
    main()
