"""Writes ring.msh: a quarter of a ring of 20 to 30 mm, 10 mm long, whose curved sides have their middle nodes on the cylinders."""

import math

import round_block as block


def place(index):
    """Coordinates of a point of the lattice of half cells: along the radius, the angle and the axis."""
    radius, angle, along = (i / (2 * block.CELLS) for i in index)
    radius, angle = 20.0 + 10.0 * radius, math.pi / 2 * angle
    return radius * math.cos(angle), radius * math.sin(angle), 10.0 * along


if __name__ == "__main__":
    block.CELLS, block.place = 4, place
    block.NAMES = ["inner", "outer", "y_min", "x_min", "z_min", "z_max"]
    block.main("ring.msh")
