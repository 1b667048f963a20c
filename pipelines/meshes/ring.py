"""Writes ring.msh and sleeve.msh: quarters of rings of 20 to 30 and of 14 to 20.05 mm, 10 mm long, whose curved sides have their middle
nodes on the cylinders."""

import math

import round_block as block


def ring(inner, outer, cells):
    """Coordinates of a point of the lattice of half cells: along the radius, the angle and the axis."""

    def place(index):
        radius, angle, along = (i / (2 * cells) for i in index)
        radius, angle = inner + (outer - inner) * radius, math.pi / 2 * angle
        return radius * math.cos(angle), radius * math.sin(angle), 10.0 * along

    return place


if __name__ == "__main__":
    block.NAMES = ["inner", "outer", "y_min", "x_min", "z_min", "z_max"]
    for name, radii, cells in (("ring", (20.0, 30.0), 4), ("sleeve", (14.0, 20.05), 5)):
        block.CELLS, block.place = cells, ring(*radii, cells)
        block.main(f"{name}.msh")
