"""Random convex scenes that are hard for their conditioning: slender, thin, soft, nearly floating, floating.

Every scene is a function of the seed and of its number. Contact is frictionless or follows Tresca's law.
"""

import random
from dataclasses import dataclass
from enum import StrEnum

MOST_PANES = 200
MOST_NODES = 350


class Kind(StrEnum):
    """What makes a scene hard."""

    SAGGING = "sagging"
    BEAM = "beam"
    PLATE = "plate"
    SOFT_SPRINGS = "soft_springs"
    FAR_CLAMP = "far_clamp"
    FLOATING = "floating"


@dataclass(frozen=True)
class Scene:
    """One scene of a kind."""

    number: int
    kind: Kind
    is_nodal: bool
    is_quadratic: bool
    has_friction: bool
    text: str

    @property
    def name(self) -> str:
        """A name for files."""
        words = [
            f"{self.number:04d}",
            str(self.kind),
            "nodal" if self.is_nodal else "panes",
            "P2" if self.is_quadratic else "P1",
            "tresca" if self.has_friction else "frictionless",
        ]
        return "_".join(words)


def scene(seed: int, number: int) -> Scene:
    """Scene `number` of a seed: kinds, multipliers, elements and laws take turns."""
    kinds = list(Kind)
    kind, turn = kinds[number % len(kinds)], number // len(kinds)
    is_nodal, is_quadratic, has_friction = (bool(turn >> bit & 1) for bit in range(3))
    dice = random.Random(f"convex {seed} {number}")
    # Linear elements are far too stiff to bend so.
    is_quadratic |= kind == Kind.SAGGING
    body = {
        Kind.SAGGING: sagging,
        Kind.BEAM: beam,
        Kind.PLATE: plate,
        Kind.SOFT_SPRINGS: soft_springs,
        Kind.FAR_CLAMP: far_clamp,
        Kind.FLOATING: floating,
    }[kind]
    lines, pressure = body(dice, is_nodal, is_quadratic)
    title = f'title = "{kind} {number} of seed {seed}"'
    if is_quadratic:
        lines.insert(0, 'element = "P2"')
    lines = [title, "[body]", *lines]
    if is_nodal:
        lines.append('multipliers = "nodal"')
    if has_friction:
        lines += friction(dice, pressure)
    return Scene(
        number, kind, is_nodal, is_quadratic, has_friction, "\n".join([*lines, ""])
    )


def log_uniform(dice: random.Random, low: float, high: float) -> float:
    """A number whose logarithm is uniform between those of two others, to three digits."""
    return float(f"{low * (high / low) ** dice.random():.3g}")


def uniform(dice: random.Random, low: float, high: float) -> float:
    """A number between two others, to three digits."""
    return float(f"{dice.uniform(low, high):.3g}")


def cells(
    dice: random.Random,
    ranges: list[tuple[int, int]],
    is_nodal: bool,
    is_quadratic: bool,
) -> list[int]:
    """Numbers of cells with no more multipliers than are solved in a moment."""
    while True:
        nx, ny, nz = (dice.randint(*r) for r in ranges)
        fine = 2 if is_quadratic else 1
        nodes = (fine * nx + 1) * (fine * ny + 1)
        if not is_nodal and not is_quadratic:
            nx, ny = 2 * ((nx + 1) // 2), 2 * ((ny + 1) // 2)
        carriers = nodes if is_nodal else nx * ny // (1 if is_quadratic else 4)
        if carriers <= (MOST_NODES if is_nodal else MOST_PANES):
            return [nx, ny, nz]


def brick(
    size: list[float], counts: list[int], young: float, poisson: float
) -> list[str]:
    """A brick of one material."""
    return [
        "[body.brick]",
        f"size = {size}",
        f"cells = {counts}",
        "[material.isotropic]",
        f"young_modulus = {young!r}",
        f"poisson_ratio = {poisson!r}",
    ]


def clamp(face: str, components: str = "") -> list[str]:
    """A clamp of all components, or of one."""
    lines = ["[[clamp]]", f'face = "{face}"']
    return [*lines, f'components = ["{components}"]'] if components else lines


def traction(face: str, value: list[float]) -> list[str]:
    """A traction on a face."""
    return [
        "[[traction]]",
        f'face = "{face}"',
        f"value = {[float(f'{v:.4g}') for v in value]}",
    ]


def contact(dice: random.Random, travel: float, length: float) -> list[str]:
    """Contact on z_min with a gap: none, constant, sloped or wavy."""
    gap = log_uniform(dice, 1e-2, 1.0) * travel
    wave = uniform(dice, 1.0, 9.0) / length
    shape = dice.choice(
        (None, repr(gap), f'"{gap!r}*x/{length!r}"', f'"{gap!r}*(1 + sin({wave!r}*x))"')
    )
    lines = ["[contact]", 'face = "z_min"']
    return lines if shape is None else [*lines, f"gap = {shape}"]


def friction(dice: random.Random, pressure: float) -> list[str]:
    """Tresca's law, isotropic or orthotropic, with a bound from next to nothing to sticking."""
    bound = log_uniform(dice, 1e-4, 10.0) * pressure
    lines = ["[friction]", f"slip_bound = {bound:.4g}"]
    if dice.random() < 0.5:
        return [*lines, "coefficient.constant = 1.0"]
    other = log_uniform(dice, 0.05, 20.0)
    return [
        *lines,
        "coefficient_1.constant = 1.0",
        f"coefficient_2.constant = {other!r}",
    ]


def sagging(
    dice: random.Random, is_nodal: bool, is_quadratic: bool
) -> tuple[list[str], float]:
    """A cantilever that sags on a floor and lies on most of it."""
    counts = cells(dice, [(40, 200), (1, 1), (1, 2)], is_nodal, is_quadratic)
    thick = log_uniform(dice, 1e-2, 1.0)
    length = float(f"{thick * counts[0] * uniform(dice, 0.7, 1.5):.4g}")
    young = log_uniform(dice, 1e6, 2e11)
    poisson = dice.choice((0.0, uniform(dice, 0.0, 0.45)))
    gap = log_uniform(dice, 0.01, 1.0) * thick
    bend = log_uniform(dice, 10.0, 1000.0) * gap
    pressure = bend * young * thick**3 / (1.5 * length**4)
    lines = brick([length, thick, thick], counts, young, poisson) + clamp("x_min")
    lines += clamp("y_min", "y") + clamp("y_max", "y")
    lines += ["[[pressure]]", 'face = "z_max"', f"value = {pressure!r}"]
    return [*lines, "[contact]", 'face = "z_min"', f"gap = {gap!r}"], pressure


def beam(
    dice: random.Random, is_nodal: bool, is_quadratic: bool
) -> tuple[list[str], float]:
    """A cantilever that its load bends down to a floor; sides may be held."""
    counts = cells(dice, [(40, 200), (1, 2), (1, 2)], is_nodal, is_quadratic)
    thick = log_uniform(dice, 1e-2, 1.0)
    length = thick * log_uniform(dice, 50.0, 400.0)
    young, poisson = log_uniform(dice, 1e6, 2e11), uniform(dice, 0.0, 0.45)
    # The load that bends the free end by some thicknesses or far more.
    bend = log_uniform(dice, 0.3, 300.0) * thick
    pressure = bend * young * thick**3 / (1.5 * length**4)
    lines = brick([length, thick, thick], counts, young, poisson) + clamp("x_min")
    if dice.random() < 0.5:
        lines += clamp("y_min", "y") + clamp("y_max", "y")
    side = dice.choice((0.0, 0.3))
    lines += traction("z_max", [side * pressure, 0.0, -pressure])
    return lines + contact(dice, min(bend, thick), length), pressure


def plate(
    dice: random.Random, is_nodal: bool, is_quadratic: bool
) -> tuple[list[str], float]:
    """A thin plate held along one edge, pressed or pulled."""
    counts = cells(dice, [(6, 24), (6, 16), (1, 2)], is_nodal, is_quadratic)
    thick = log_uniform(dice, 1e-2, 1.0)
    length = thick * log_uniform(dice, 10.0, 150.0)
    young, poisson = log_uniform(dice, 1e6, 2e11), uniform(dice, 0.0, 0.45)
    bend = log_uniform(dice, 0.05, 100.0) * thick
    pressure = bend * young * thick**3 / (1.5 * length**4)
    width = length * uniform(dice, 0.3, 1.0)
    lines = brick([length, width, thick], counts, young, poisson) + clamp("x_min")
    lines += traction("z_max", [0.2 * pressure, 0.0, -pressure])
    if dice.random() < 0.5:
        up = uniform(dice, 0.0, 2.0) * pressure * length / thick
        lines += traction("x_max", [0.0, 0.0, up])
    return lines + contact(dice, min(bend, thick), length), pressure


def soft_springs(
    dice: random.Random, is_nodal: bool, is_quadratic: bool
) -> tuple[list[str], float]:
    """A block that a much softer upper part holds: it nearly floats."""
    counts = cells(dice, [(3, 12), (3, 8), (2, 4)], is_nodal, is_quadratic)
    size = [uniform(dice, 0.5, 3.0), uniform(dice, 0.5, 2.0), uniform(dice, 0.5, 2.0)]
    level = size[2] * dice.randint(1, counts[2] - 1) / counts[2]
    young, ratio = 1e9, log_uniform(dice, 1e2, 1e8)
    weight = log_uniform(dice, 1e3, 1e6)
    lines = brick(size, counts, young, uniform(dice, 0.0, 0.45)) + clamp("z_max")
    inner = f"young_modulus = {young / ratio!r}, poisson_ratio = 0.3"
    lines += ["[[region]]", f"part.box = [[-1.0, -1.0, {level!r}], [9.0, 9.0, 9.0]]"]
    lines.append(f"material.isotropic = {{ {inner} }}")
    push = weight * dice.choice((0.0, 0.1, 0.3))
    lines += ["[body_force]", f"value = [{push!r}, 0.0, {-weight!r}]"]
    travel = weight * size[2] ** 2 / young
    return lines + contact(dice, travel, size[0]), weight * size[2]


def far_clamp(
    dice: random.Random, is_nodal: bool, is_quadratic: bool
) -> tuple[list[str], float]:
    """A column that stands on the foundation and is clamped at its far end."""
    counts = cells(dice, [(3, 12), (3, 8), (8, 16)], is_nodal, is_quadratic)
    height = log_uniform(dice, 5.0, 100.0)
    size = [uniform(dice, 0.5, 1.0), uniform(dice, 0.5, 1.0), height]
    young = log_uniform(dice, 1e6, 2e11)
    pressure = young * log_uniform(dice, 1e-7, 1e-3)
    lines = brick(size, counts, young, uniform(dice, 0.0, 0.45)) + clamp("z_max")
    lines += [
        "[body_force]",
        f"value = [{1e-3 * pressure / height!r}, 0.0, {-pressure / height!r}]",
    ]
    return lines + contact(dice, pressure / young * size[0], size[0]), pressure


def floating(
    dice: random.Random, is_nodal: bool, is_quadratic: bool
) -> tuple[list[str], float]:
    """A slab that contact alone holds in one or in three directions."""
    counts = cells(dice, [(4, 24), (3, 12), (1, 3)], is_nodal, is_quadratic)
    thick = log_uniform(dice, 0.05, 1.0)
    length = thick * log_uniform(dice, 3.0, 60.0)
    size = [length, length * uniform(dice, 0.3, 1.0), thick]
    young = log_uniform(dice, 1e6, 2e11)
    pressure = young * log_uniform(dice, 1e-8, 1e-4)
    lines = brick(size, counts, young, uniform(dice, 0.0, 0.45))
    if dice.random() < 0.5:
        lines += clamp("x_min", "x") + clamp("y_min", "y")
    slope = uniform(dice, -0.8, 0.8)
    lines += ["[[pressure]]", 'face = "z_max"']
    lines.append(f'value = "{pressure!r}*(1 + ({slope!r})*(x/{length!r} - 0.5))"')
    return lines + contact(dice, pressure / young * length, length), pressure
