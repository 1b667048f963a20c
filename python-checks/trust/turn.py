"""Turned scenes: the same body with other faces up."""

import random
from dataclasses import dataclass


@dataclass(frozen=True)
class Turn:
    """A change of axes: the body's axis i becomes `axes[i]`, reversed where `reverse` says."""

    axes: tuple[int, int, int]
    reverse: tuple[bool, bool, bool]

    def vector(self, vector: list[float]) -> list[float]:
        """A vector after the turn."""
        turned = [0.0, 0.0, 0.0]
        for axis, value in enumerate(vector):
            turned[self.axes[axis]] = -value if self.reverse[axis] else value
        return turned

    def sizes(self, values: list) -> list:
        """Lengths or numbers of cells after the turn."""
        turned = [values[0]] * 3
        for axis, value in enumerate(values):
            turned[self.axes[axis]] = value
        return turned

    def face(self, face: str) -> str:
        """A face after the turn."""
        axis, end = "xyz".index(face[0]), face[2:]
        if self.reverse[axis]:
            end = "max" if end == "min" else "min"
        return f"{'xyz'[self.axes[axis]]}_{end}"

    def box(self, low: list, high: list, size: list) -> tuple[list, list]:
        """Corners of a box after the turn."""
        pairs = [
            (size[i] - high[i], size[i] - low[i])
            if self.reverse[i]
            else (low[i], high[i])
            for i in range(3)
        ]
        return tuple(self.sizes([pair[end] for pair in pairs]) for end in (0, 1))


def random_turn(dice: random.Random) -> Turn:
    """No turn for two scenes in three."""
    if dice.random() < 2 / 3:
        return Turn((0, 1, 2), (False, False, False))
    axes = dice.choice(
        [(0, 1, 2), (1, 2, 0), (2, 0, 1), (1, 0, 2), (0, 2, 1), (2, 1, 0)]
    )
    return Turn(axes, tuple(dice.random() < 0.5 for _ in range(3)))
