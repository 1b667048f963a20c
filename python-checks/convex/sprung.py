"""Random blocks that springs alone hold, from hardly to stiffer than the block: pressed, lifted, pushed, turned.

Every scene is a function of the seed, of its number and of how soft springs may be. Laws take turns: none, Tresca's, Coulomb's.
"""

import random
from dataclasses import dataclass

from convex.scenes import brick, log_uniform, uniform

LAWS = ("frictionless", "tresca", "coulomb")
FACES = ("x_min", "x_max", "y_min", "y_max", "z_max")
LOADS = {
    "lifted": (0.0, 0.0, 1.0),
    "pressed": (0.0, 0.0, -1.0),
    "pushed": (0.4, 0.1, -1.0),
    "dragged": (1.0, 0.3, 0.0),
    "none": (0.0, 0.0, 0.0),
}


SOFTEST = 1e7
"""E / (k L) up to which no block has springs that are refused as too soft."""


@dataclass(frozen=True)
class Sprung:
    """One block on springs."""

    number: int
    law: str
    load: str
    text: str

    @property
    def name(self) -> str:
        """A name for files."""
        return f"{self.number:04d}_{self.law}_{self.load}"


def sprung(seed: int, number: int, softest: float = SOFTEST) -> Sprung:
    """Scene `number` of a seed with springs up to so many times softer than the block."""
    dice = random.Random(f"sprung {seed} {number}")
    law = LAWS[number % len(LAWS)]
    load = dice.choice(list(LOADS))
    size = [uniform(dice, 0.5, 2.0) for _ in range(3)]
    is_nodal, is_quadratic = dice.random() < 0.5, dice.random() < 0.25
    # A pane takes two cells of linear elements either way.
    counts = [dice.choice((1, 2) if is_quadratic else (2, 4)) for _ in range(2)]
    counts.append(dice.randint(1, 3))
    young = log_uniform(dice, 1e5, 1e12)
    pressure = young * log_uniform(dice, 1e-9, 1e-4)
    lines = [f'title = "block {number} of seed {seed} on springs"', "[body]"]
    lines += ['element = "P2"'] if is_quadratic else []
    lines += brick(size, counts, young, uniform(dice, 0.0, 0.45))
    lines += springs(dice, young / softest) + loads(dice, load, pressure, size)
    lines += ["[contact]", 'face = "z_min"']
    lines += ['multipliers = "nodal"'] if is_nodal else []
    lines += friction(dice, law, pressure)
    return Sprung(number, law, load, "\n".join([*lines, ""]))


def springs(dice: random.Random, least: float) -> list[str]:
    """Springs on one to three faces that hold every motion together, of one stiffness or of several."""
    lines: list[str] = []
    usual = max(least, log_uniform(dice, 1e-6, 1e9))
    for at, face in enumerate(dice.sample(FACES, dice.randint(1, 3))):
        stiffness = dice.choice((usual, max(least, log_uniform(dice, 1e-6, 1e9))))
        # The first face alone holds every motion.
        ways = dice.choice(
            (("normal", "tangential"),)
            if at == 0
            else (("normal",), ("tangential",), ("normal", "tangential"))
        )
        lines += ["[[spring]]", f'face = "{face}"']
        lines += [f"{way} = {stiffness!r}" for way in ways]
    return lines


def loads(
    dice: random.Random, load: str, pressure: float, size: list[float]
) -> list[str]:
    """A load on the upper face, in all of the body, or one that turns it, beside the others or alone."""
    value = [float(f"{pressure * part:.4g}") for part in LOADS[load]]
    lines: list[str] = []
    if dice.random() < 0.6:
        lines += ["[[traction]]", 'face = "z_max"', f"value = {value}"]
    else:
        lines += ["[body_force]", f"value = {[v / size[2] for v in value]}"]
    if load == "none" or dice.random() < 0.3:
        slope = uniform(dice, -2.0, 2.0) * pressure
        turn = f'"{slope!r}*(x/{size[0]!r} - 0.5)"'
        lines += ["[[traction]]", 'face = "z_max"', f"value = [0.0, 0.0, {turn}]"]
    return lines


def friction(dice: random.Random, law: str, pressure: float) -> list[str]:
    """A law with a bound from next to nothing to sticking."""
    match law:
        case "tresca":
            bound = log_uniform(dice, 1e-3, 10.0) * pressure
            return ["[friction]", f"slip_bound = {bound:.4g}", "coefficient.constant = 1.0"]
        case "coulomb":
            return ["[friction]", f"coefficient.constant = {uniform(dice, 0.05, 1.0)}"]
        case _:
            return []
