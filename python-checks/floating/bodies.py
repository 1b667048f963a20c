"""Random scenes of bodies that no clamp and no spring holds."""

from dataclasses import dataclass

import numpy as np

LAWS = ("coulomb", "orthotropic", "frictionless")
FACES = ("plane", "plane", "slope", "cup", "cup", "trough", "gap")


@dataclass(frozen=True)
class Body:
    """One scene."""

    number: int
    text: str
    coefficients: tuple[float, float] | None


def body(seed: int, number: int) -> Body:
    """The scene of a number: a block on a plane, a slope, in a cup or a trough, or above a gap."""
    draw = np.random.default_rng([seed, number])
    size = np.exp(draw.uniform(-0.7, 0.7, 3))
    cells = draw.choice([2, 4], 2).tolist() + [int(draw.integers(1, 4))]
    face, law = draw.choice(FACES), draw.choice(LAWS, p=(0.6, 0.2, 0.2))
    multipliers = draw.choice(["panes", "nodal"])
    element = draw.choice(["P1", "P2"])
    modulus = 10.0 ** draw.uniform(6, 11)
    coefficients = tuple(10.0 ** draw.uniform(-1.3, 0.2, 2))
    if law == "coulomb":
        coefficients = (coefficients[0],) * 2
    weight = modulus * 10.0 ** draw.uniform(-7, -4)
    tilt = draw.uniform(0, 1.2) * min(coefficients) if law != "frictionless" else 0.0
    angle = draw.uniform(0, 2 * np.pi)
    force = [tilt * np.cos(angle), tilt * np.sin(angle), -1.0]
    if law == "frictionless" and face in ("cup", "trough") and draw.random() < 0.7:
        force[0] = draw.uniform(-0.05, 0.05)
    lines = [
        f'title = "body {number}"',
        f'body.element = "{element}"',
        f"body.brick = {{ size = {numbers(size)}, cells = {cells} }}",
        f"material.isotropic = {{ young_modulus = {modulus!r}, poisson_ratio = {draw.uniform(0, 0.45)!r} }}",
        f"body_force.value = {numbers(weight * np.array(force))}",
    ]
    if draw.random() < 0.5:
        pressure = float(weight * size[2] * draw.uniform(0, 2))
        lines.append(f'pressure = [{{ face = "z_max", value = {pressure!r} }}]')
    lines += ["[contact]", 'face = "z_min"', f'multipliers = "{multipliers}"']
    lines += obstacle(face, size, draw)
    if law != "frictionless":
        first, second = map(float, coefficients)
        lines += ["[friction]", f"coefficient_1.constant = {first!r}", f"coefficient_2.constant = {second!r}"]
    return Body(number, "\n".join(lines), coefficients if law != "frictionless" else None)


def obstacle(face: str, size: np.ndarray, draw: np.random.Generator) -> list[str]:
    """What the body rests on."""
    x, y = size[0] / 2, size[1] / 2
    # The corners touch, so that nothing penetrates at the start.
    if face == "cup":
        height = 10.0 ** draw.uniform(0.5, 1.6)
        radius = float(np.sqrt(x**2 + y**2 + height**2))
        centre = numbers((x, y, height))
        return [f'obstacle.sphere = {{ centre = {centre}, radius = {radius * (1 + 1e-12)!r}, side = "inside" }}']
    if face == "trough":
        height = 10.0 ** draw.uniform(0.5, 1.6)
        radius = float(np.sqrt(x**2 + height**2))
        point = numbers((x, 0.0, height))
        return [
            f'obstacle.cylinder = {{ point = {point}, direction = [0.0, 1.0, 0.0], radius = {radius * (1 + 1e-12)!r}, side = "inside" }}'
        ]
    if face == "slope":
        slope = 10.0 ** draw.uniform(-4, -2)
        return [f"gap = \"{float(slope)!r}*x\""]
    if face == "gap":
        return [f"gap = {float(10.0 ** draw.uniform(-5, -2))!r}"]
    return []


def numbers(values) -> str:
    """A list as a scene writes it."""
    return "[" + ", ".join(repr(float(value)) for value in values) + "]"
