"""Random scenes of six kinds, as text.

Every scene is a function of the seed and of its number, so one scene can be made again without the
others. All are built above z = 0 and some are then turned, so that any face may be in contact.
"""

import random
from collections.abc import Callable
from dataclasses import dataclass, field
from enum import StrEnum

from trust.turn import Turn, random_turn

MOST_UNKNOWNS = 1500
MOST_PANES = 40
MOST_NODES = 60


class Kind(StrEnum):
    """What makes a scene hard."""

    SOFT_SPRINGS = "soft_springs"
    WEIGHT_ONLY = "weight_only"
    SLENDER = "slender"
    FAR_CLAMPS = "far_clamps"
    CONTRASTS = "contrasts"
    WEAK_FRICTION = "weak_friction"


@dataclass
class Body:
    """A brick with its loads; contact is on z_min until it is turned."""

    size: list[float]
    cells: list[int]
    clamp: str
    young: float = 1e9
    poisson: float = 0.3
    regions: list[tuple[list[float], list[float], float, float]] = field(
        default_factory=list
    )
    tractions: list[tuple[str, list[float]]] = field(default_factory=list)
    force: list[float] | None = None
    travel: float = 0.0
    """A displacement in m that the loads could cause, the measure of gaps and slips."""
    friction: float = 0.3
    """The first coefficient of friction."""
    pressure: float = 0.0
    """A pressure in Pa that the loads could cause, the measure of caps."""


@dataclass(frozen=True)
class Scene:
    """One scene of a kind."""

    number: int
    kind: Kind
    nodal: bool
    text: str

    @property
    def name(self) -> str:
        """A name for files."""
        space = "nodal" if self.nodal else "panes"
        return f"{self.number:04d}_{self.kind}_{space}"


def scene(
    seed: int, number: int, kind: Kind | None = None, capped: bool = False
) -> Scene:
    """Scene `number` of a seed; kinds take turns unless one is given.

    With `capped` the same scene with a cap of the pressure that friction follows.
    """
    kinds = list(Kind)
    turn = number if kind else number // len(kinds)
    kind = kind or kinds[number % len(kinds)]
    nodal = turn % 2 == 1
    dice = random.Random(f"{seed} {kind} {number}")
    body = BODIES[kind](dice, nodal)
    friction = friction_lines(dice, body)
    if capped:
        # Dice of its own, so that all else is the scene without a cap.
        cap = log_uniform(random.Random(f"cap {seed} {kind} {number}"), 0.03, 3.0)
        friction.append(f"pressure_cap = {cap * body.pressure!r}")
    text = scene_text(dice, body, friction, nodal, f"{kind} {number} of seed {seed}")
    return Scene(number, kind, nodal, text)


def log_uniform(dice: random.Random, low: float, high: float) -> float:
    """A number whose logarithm is uniform between those of two others, to three digits."""
    exponent = dice.uniform(0.0, 1.0)
    return float(f"{low * (high / low) ** exponent:.3g}")


def uniform(dice: random.Random, low: float, high: float) -> float:
    """A number between two others, to three digits."""
    return float(f"{dice.uniform(low, high):.3g}")


def cells_within(
    dice: random.Random, ranges: list[tuple[int, int]], nodal: bool
) -> list[int]:
    """Random numbers of cells that keep within the limits, even along the contact face."""
    while True:
        nx, ny, nz = (dice.randint(*r) for r in ranges)
        if not nodal:
            nx, ny = 2 * ((nx + 1) // 2), 2 * ((ny + 1) // 2)
        points = (nx + 1) * (ny + 1)
        carriers = points if nodal else nx * ny // 4
        if 3 * points * (nz + 1) <= MOST_UNKNOWNS and carriers <= (
            MOST_NODES if nodal else MOST_PANES
        ):
            return [nx, ny, nz]


def sideways(
    dice: random.Random, down: float, share: tuple[float, float]
) -> list[float]:
    """A load that presses down and pushes to a side by a share of that."""
    along, across = dice.choice([(1.0, 0.0), (0.0, 1.0), (1.0, 1.0), (1.0, 0.1)])
    push = [
        down * c * dice.choice((-1, 1)) * dice.uniform(*share) for c in (along, across)
    ]
    return [float(f"{v:.4g}") for v in (*push, -down)]


def soft_springs(dice: random.Random, nodal: bool) -> Body:
    """A block on the foundation that a much softer upper part holds from above."""
    cells = cells_within(dice, [(2, 6), (2, 6), (3, 8)], nodal)
    size = [uniform(dice, 0.5, 2.0), uniform(dice, 0.5, 2.0), uniform(dice, 0.5, 2.0)]
    level = size[2] * dice.randint(1, cells[2] - 1) / cells[2]
    ratio = log_uniform(dice, 1e2, 1e6)
    body = Body(size, cells, "z_max", poisson=uniform(dice, 0.0, 0.45))
    body.friction = uniform(dice, 0.05, 0.8)
    upper = ([-1.0, -1.0, level], [9.0, 9.0, 9.0], body.young / ratio)
    body.regions.append((*upper, dice.choice((0.0, uniform(dice, 0.0, 0.45)))))
    # From firmly held to sliding as a whole; in between the block sticks here and slides there.
    body.force = sideways(dice, 1e5, (0.1 * body.friction, 1.3 * body.friction))
    body.travel = 1e5 * size[2] ** 2 / body.young
    body.pressure = 1e5 * size[2]
    return body


def weight_only(dice: random.Random, nodal: bool) -> Body:
    """A body under its own weight, pushed from the side."""
    cells = cells_within(dice, [(2, 8), (2, 6), (2, 6)], nodal)
    size = [uniform(dice, 1.0, 4.0), uniform(dice, 0.5, 2.0), uniform(dice, 0.5, 2.0)]
    clamp = dice.choice(("x_max", "z_max", "y_max"))
    body = Body(
        size, cells, clamp, log_uniform(dice, 1e7, 2e11), uniform(dice, 0.0, 0.45)
    )
    weight = log_uniform(dice, 1e3, 1e5)
    body.force = [0.0, 0.0, -weight]
    face = dice.choice([f for f in ("x_min", "y_min") if f != clamp])
    pressure = weight * size[2]
    push = [dice.uniform(-0.3, 0.3) * pressure for _ in range(3)]
    body.tractions.append((face, [float(f"{v:.4g}") for v in push]))
    body.travel = pressure * size[2] / body.young
    body.pressure = pressure
    body.friction = uniform(dice, 0.05, 0.8)
    return body


def slender(dice: random.Random, nodal: bool) -> Body:
    """A bar or a plate, up to fifty times as long as thick, held at one end."""
    aspect = log_uniform(dice, 5.0, 50.0)
    thick = uniform(dice, 0.05, 0.2)
    if dice.random() < 0.5:
        cells = cells_within(dice, [(8, 20), (1, 2), (1, 2)], nodal)
        size = [thick * aspect, thick * uniform(dice, 0.7, 1.5), thick]
    else:
        cells = cells_within(dice, [(4, 10), (3, 6), (1, 2)], nodal)
        size = [thick * aspect, thick * aspect * uniform(dice, 0.5, 1.0), thick]
    body = Body(
        size, cells, "x_min", log_uniform(dice, 1e8, 2e11), uniform(dice, 0.0, 0.45)
    )
    pressure = log_uniform(dice, 1e3, 1e6)
    body.tractions.append(("z_max", sideways(dice, pressure, (0.0, 0.4))))
    if dice.random() < 0.5:
        push = [dice.uniform(-1.0, 1.0) * pressure for _ in range(3)]
        body.tractions.append(("x_max", [float(f"{v:.4g}") for v in push]))
    body.travel = pressure * thick / body.young
    body.pressure = pressure
    body.friction = uniform(dice, 0.05, 0.8)
    return body


def far_clamps(dice: random.Random, nodal: bool) -> Body:
    """A column that stands on the foundation and is clamped at its far end."""
    cells = cells_within(dice, [(2, 6), (2, 4), (10, 30)], nodal)
    size = [uniform(dice, 0.5, 1.0), uniform(dice, 0.5, 1.0), uniform(dice, 5.0, 30.0)]
    body = Body(
        size, cells, "z_max", log_uniform(dice, 1e8, 2e11), uniform(dice, 0.0, 0.45)
    )
    pressure = log_uniform(dice, 1e4, 1e7)
    weight = pressure / size[2]
    body.force = sideways(dice, weight, (0.0, 0.02))
    if dice.random() < 0.5:
        push = [dice.uniform(-1.0, 1.0) * pressure * 0.02 for _ in range(3)]
        body.tractions.append(
            (dice.choice(("x_max", "y_min")), [float(f"{v:.4g}") for v in push])
        )
    body.travel = pressure / body.young * 0.1
    body.pressure = pressure
    body.friction = uniform(dice, 0.05, 0.8)
    return body


def contrasts(dice: random.Random, nodal: bool) -> Body:
    """A brick with parts that are up to a million times stiffer or softer."""
    cells = cells_within(dice, [(3, 6), (3, 6), (2, 6)], nodal)
    size = [uniform(dice, 0.5, 3.0), uniform(dice, 0.5, 2.0), uniform(dice, 0.5, 2.0)]
    clamp = dice.choice(("x_min", "z_max", "y_max"))
    body = Body(size, cells, clamp, 1e9, uniform(dice, 0.0, 0.45))
    for _ in range(dice.randint(1, 3)):
        low, high = [0.0] * 3, [0.0] * 3
        for axis in range(3):
            first = dice.randint(0, cells[axis] - 1)
            last = dice.randint(first + 1, cells[axis])
            step = size[axis] / cells[axis]
            low[axis], high[axis] = first * step - step / 10, last * step + step / 10
        ratio = log_uniform(dice, 1e-6, 1e6)
        body.regions.append((low, high, body.young * ratio, uniform(dice, 0.0, 0.45)))
    pressure = log_uniform(dice, 1e4, 1e6)
    if clamp == "z_max":
        body.force = sideways(dice, pressure / size[2], (0.0, 0.5))
    else:
        body.tractions.append(("z_max", sideways(dice, pressure, (0.0, 0.5))))
    body.travel = pressure * size[2] / body.young
    body.pressure = pressure
    body.friction = uniform(dice, 0.05, 0.8)
    return body


def weak_friction(dice: random.Random, nodal: bool) -> Body:
    """A sound brick; its friction is next to nothing."""
    cells = cells_within(dice, [(3, 8), (3, 6), (2, 5)], nodal)
    size = [uniform(dice, 1.0, 3.0), uniform(dice, 0.5, 2.0), uniform(dice, 0.5, 1.5)]
    clamp = dice.choice(("x_min", "y_max"))
    body = Body(
        size, cells, clamp, log_uniform(dice, 1e8, 2e11), uniform(dice, 0.0, 0.45)
    )
    pressure = log_uniform(dice, 1e5, 1e7)
    body.tractions.append(("z_max", sideways(dice, pressure, (0.0, 0.5))))
    push = [dice.uniform(-0.5, 0.5) * pressure for _ in range(3)]
    side = "x_max" if clamp == "x_min" else "y_min"
    body.tractions.append((side, [float(f"{v:.4g}") for v in push]))
    body.travel = pressure * size[2] / body.young
    body.pressure = pressure
    body.friction = log_uniform(dice, 1e-6, 1e-2)
    return body


BODIES: dict[Kind, Callable[[random.Random, bool], Body]] = {
    Kind.SOFT_SPRINGS: soft_springs,
    Kind.WEIGHT_ONLY: weight_only,
    Kind.SLENDER: slender,
    Kind.FAR_CLAMPS: far_clamps,
    Kind.CONTRASTS: contrasts,
    Kind.WEAK_FRICTION: weak_friction,
}


def law_line(dice: random.Random, value: float, travel: float, ramp: bool) -> str:
    """One law of friction as an inline table."""
    if not ramp:
        return f"{{ constant = {value!r} }}"
    residual = float(f"{value * dice.uniform(0.4, 1.2):.3g}")
    onset = dice.choice((0.0, log_uniform(dice, 0.01 * travel, travel)))
    width = log_uniform(dice, 0.3 * travel, 10.0 * travel)
    rate = float(f"{max(abs(value - residual), 1e-3 * value) / width:.3g}")
    keys = {"initial": value, "residual": residual, "onset": onset, "rate": rate}
    inner = ", ".join(f"{key} = {number!r}" for key, number in keys.items())
    return f"{{ ramp = {{ {inner} }} }}"


def friction_lines(dice: random.Random, body: Body) -> list[str]:
    """The table of friction: three quarters are constants, and more than half isotropic."""
    ramp = dice.random() < 0.25
    if dice.random() < 0.6:
        laws = {"coefficient": body.friction}
    else:
        other = body.friction * log_uniform(dice, 0.2, 5.0)
        other = float(f"{min(other, 1.0):.3g}")
        laws = {"coefficient_1": body.friction, "coefficient_2": other}
    return [
        f"{name} = {law_line(dice, f, body.travel, ramp)}" for name, f in laws.items()
    ]


def scene_text(
    dice: random.Random, body: Body, friction: list[str], nodal: bool, title: str
) -> str:
    """The scene as TOML."""
    turn = random_turn(dice)
    face = turn.face("z_min")
    lines = [
        f'title = "{title}"',
        "[body.brick]",
        f"size = {turn.sizes(body.size)}",
        f"cells = {turn.sizes(body.cells)}",
        *material("[material.isotropic]", body.young, body.poisson),
    ]
    for low, high, young, poisson in body.regions:
        low, high = turn.box(low, high, body.size)
        inner = f"young_modulus = {young!r}, poisson_ratio = {poisson!r}"
        lines += ["[[region]]", f"part.box = [{low}, {high}]"]
        lines.append(f"material.isotropic = {{ {inner} }}")
    lines += ["[[clamp]]", f'face = "{turn.face(body.clamp)}"']
    for loaded, value in body.tractions:
        lines += ["[[traction]]", f'face = "{turn.face(loaded)}"']
        lines.append(f"value = {turn.vector(value)}")
    if body.force:
        lines += ["[body_force]", f"value = {turn.vector(body.force)}"]
    lines += ["[contact]", f'face = "{face}"', *contact_lines(dice, body, turn, face)]
    if nodal:
        lines.append('multipliers = "nodal"')
    return "\n".join([*lines, "[friction]", *friction, ""])


def material(head: str, young: float, poisson: float) -> list[str]:
    """An isotropic material."""
    return [head, f"young_modulus = {young!r}", f"poisson_ratio = {poisson!r}"]


def contact_lines(dice: random.Random, body: Body, turn: Turn, face: str) -> list[str]:
    """A gap and axes of friction, in some scenes."""
    lines = []
    if dice.random() < 0.25:
        gap = log_uniform(dice, 1e-3 * body.travel, 0.3 * body.travel)
        axis = turn.axes[0]
        slope = float(f"{gap / body.size[0]:.3g}")
        linear = f'"{slope!r}*{"xyz"[axis]}"'
        lines.append(f"gap = {dice.choice((repr(gap), linear))}")
    if dice.random() < 0.25:
        first = [uniform(dice, -1.0, 1.0) for _ in range(3)]
        first["xyz".index(face[0])] = 0.0
        lines.append(f"axis_1 = {first}")
    return lines
