"""Laws of friction in double-double arithmetic: constants and ramps, isotropic or not."""

from dataclasses import dataclass

import numpy as np

from trust.double_double import DD


@dataclass(frozen=True)
class Coefficient:
    """`initial` up to the slip `onset`, then a straight line of steepness `rate` to `residual`."""

    initial: float
    residual: float
    onset: float = 0.0
    rate: float = 1.0

    @classmethod
    def of(cls, law: dict) -> "Coefficient":
        """A coefficient as scenes give it."""
        if "constant" in law:
            return cls(float(law["constant"]), float(law["constant"]))
        return cls(**{key: float(value) for key, value in law["ramp"].items()})

    @property
    def follows_slip(self) -> bool:
        """Whether it is no constant."""
        return self.initial != self.residual

    def evaluate(self, slip: DD) -> tuple[DD, np.ndarray]:
        """Values at slips >= 0, and derivatives, from the left at kinks."""
        slope = self.rate if self.residual > self.initial else -self.rate
        line = self.initial + slope * (slip - self.onset)
        before = (slip - self.onset).hi <= 0.0
        over = (line - self.residual).hi
        after = ~before & ((over > 0.0) if slope > 0.0 else (over < 0.0))
        constant = DD.of(np.where(after, self.residual, self.initial))
        flat = before | after
        return constant.where(flat, line), np.where(flat, 0.0, slope)


@dataclass(frozen=True)
class Law:
    """F_1 and F_2 at the contact nodes."""

    pair: tuple[Coefficient, Coefficient]
    isotropic: bool
    cap: float = np.inf
    """The pressure above which the slip bound grows no further."""

    @classmethod
    def of(cls, scene: dict) -> "Law":
        """The law of a scene."""
        friction = scene["friction"]
        cap = float(friction.get("pressure_cap", np.inf))
        if "coefficient" in friction:
            one = Coefficient.of(friction["coefficient"])
            return cls((one, one), True, cap)
        names = ("coefficient_1", "coefficient_2")
        pair = tuple(Coefficient.of(friction[name]) for name in names)
        return cls(pair, False, cap)

    @property
    def follows_slip(self) -> bool:
        """Whether a coefficient depends on the solution."""
        return any(coefficient.follows_slip for coefficient in self.pair)

    def bound(self, pressure: DD) -> tuple[DD, np.ndarray]:
        """The slip bound under pressures, and its derivative."""
        over = (pressure - self.cap).hi >= 0.0 if np.isfinite(self.cap) else False
        over = np.broadcast_to(over, pressure.shape)
        capped = DD.of(np.where(over, self.cap, 0.0))
        return capped.where(over, pressure), np.where(over, 0.0, 1.0)

    def inverse(self, tangential: DD) -> tuple[DD, np.ndarray]:
        """1/F_k, [nodes, 2], and d(1/F_k)/du_l, [nodes, 2, 2], at tangential displacements."""
        sign = np.sign(tangential.hi)
        slope = np.zeros((*tangential.shape, 2))
        if self.isotropic:
            slip = (tangential * tangential).sum().sqrt()
            safe = np.where(slip.hi > 0.0, slip.hi, 1.0)
            value, derivative = self.pair[0].evaluate(slip)
            direction = tangential.hi / safe[:, None]
            gradient = -(derivative / value.hi**2)[:, None] * direction
            one = (1.0 / value).reshape(-1, 1)
            slope[:, 0], slope[:, 1] = gradient, gradient
            return columns(one, one), slope
        values = []
        for k, coefficient in enumerate(self.pair):
            value, derivative = coefficient.evaluate(tangential[:, k].absolute())
            slope[:, k, k] = -derivative * sign[:, k] / value.hi**2
            values.append((1.0 / value).reshape(-1, 1))
        return columns(*values), slope


def columns(first: DD, second: DD) -> DD:
    """Two columns side by side."""
    return DD.concatenate([first.T, second.T]).T
