"""The contact problem of `exact` and the conditions of its solutions.

Multipliers are the m normal ones, then m pairs. With r = S lambda - h and u_t = -r_t:
open panes have lambda = 0 and r_nu >= 0; pressed ones r_nu = 0, and either stick, r_t = 0 inside the
ellipse |f lambda_t| <= g (f the pane's mean of 1/F, g = lambda_nu or no more than the law's cap), or slip with lambda_t on the ellipse and u_t
along its outer normal.
"""

from dataclasses import dataclass
from enum import IntEnum
from functools import cached_property

import numpy as np

from trust.double_double import DD
from trust.exact import Exact
from trust.law import Law


NEGLIGIBLE = 1e-30
"""Multipliers below this share of the typical stress are none."""


class Zone(IntEnum):
    """What a pane does."""

    OPEN = 0
    SLIP = 1
    STICK = 2


@dataclass(frozen=True)
class Problem:
    """S, h, the law, and the local stiffness that makes displacements comparable to stresses."""

    exact: Exact
    law: Law
    stiffness: np.ndarray

    @classmethod
    def of(cls, exact: Exact) -> "Problem":
        """Measure the local stiffness (S^-1)_ii, one for each tangential pair."""
        s = exact.operator.hi
        scale = 1.0 / np.sqrt(np.diag(s))
        inverse = np.diag(np.linalg.inv(scale[:, None] * (s + s.T) / 2.0 * scale))
        local = np.abs(inverse) * scale**2
        return cls(exact, Law.of(exact.scene), paired(local, exact.n_panes))

    @property
    def m(self) -> int:
        """Number of panes."""
        return self.exact.n_panes

    @cached_property
    def own_stiffness(self) -> np.ndarray:
        """1/S_ii, one for each tangential pair: where all other panes follow freely."""
        return paired(1.0 / np.diag(self.exact.operator.hi), self.m)

    @cached_property
    def typical_stress(self) -> float:
        """The stress that would press the free displacement back pane by pane."""
        return self.size(self.exact.rhs.hi * self.stiffness)

    @cached_property
    def constant_friction(self) -> DD:
        """f of a law that does not follow the slip, [m, 2]."""
        return self.averaged(self.law.inverse(DD.zeros(*self.exact.slip_free.shape))[0])

    def averaged(self, nodal: DD) -> DD:
        """Means over panes of values at the contact nodes, [m, 2]."""
        weights = DD.of(self.exact.pane_average.T[:, None, :])
        return (weights * nodal.T).sum()

    def gradient(self, multiplier: DD) -> DD:
        """r = S lambda - h."""
        return self.exact.operator @ multiplier - self.exact.rhs

    def friction(self, multiplier: DD) -> tuple[DD, np.ndarray | None]:
        """f, [m, 2], and its derivative by the multipliers, [m, 2, 3m]; None where it is 0."""
        if not self.law.follows_slip:
            return self.constant_friction, None
        moved = (self.exact.compliance * multiplier).sum()
        nodal, slope = self.law.inverse(self.exact.slip_free - moved)
        by_multiplier = -np.einsum("nkl,nlj->nkj", slope, self.exact.compliance.hi)
        mean = np.einsum("nm,nkj->mkj", self.exact.pane_average, by_multiplier)
        return self.averaged(nodal), mean

    def size(self, multiplier: np.ndarray) -> float:
        """The root of the area-weighted mean square of a multiplier vector."""
        area = self.exact.area
        weight = np.concatenate([area, np.repeat(area, 2)])
        return float(np.sqrt(np.sum(weight * multiplier**2) / np.sum(area)))

    def violations(self, multiplier: DD, zones: np.ndarray) -> dict[str, float]:
        """How far a solution violates each condition of its zones, relative to its size.

        Displacements count by local stiffness; angles of slip as shares of the slip bound.
        What is not a number counts as infinite.
        """
        m = self.m
        size = max(self.size(multiplier.hi), NEGLIGIBLE * self.typical_stress)
        r, f = self.gradient(multiplier), self.friction(multiplier)[0]
        normal, pairs = multiplier[:m], multiplier[m:].reshape(m, 2)
        opening = r[:m].hi * self.stiffness[:m] / size
        slip = -r[m:].reshape(m, 2)
        moved = slip.hi * self.stiffness[m:].reshape(m, 2) / size
        is_open, sticks, slides = (
            zones == zone for zone in (Zone.OPEN, Zone.STICK, Zone.SLIP)
        )
        g = self.law.bound(normal)[0]
        excess = (((f * pairs) * (f * pairs)).sum() - g * g).hi / size**2
        outer = f * f * pairs
        turn = (slip[:, 0] * outer[:, 1] - slip[:, 1] * outer[:, 0]).hi
        along = (slip * outer).sum().hi
        length = np.hypot(*slip.hi.T) * np.hypot(*outer.hi.T)
        turn = turn / np.where(length > 0.0, length, 1.0)

        def worst(values: np.ndarray, where: np.ndarray) -> float:
            numbers = np.nan_to_num(values[where], nan=np.inf)
            return float(np.max(numbers, initial=0.0))

        return {
            "force on open panes": worst(
                np.abs(blocks(multiplier.hi, m)).max(1) / size, is_open
            ),
            "penetration": worst(-opening, is_open),
            "distance of pressed panes": worst(np.abs(opening), ~is_open),
            "tension": worst(-normal.hi / size, ~is_open),
            "slip of sticking panes": worst(np.abs(moved).max(axis=1), sticks),
            "outside the ellipse": worst(excess, sticks),
            "off the ellipse": worst(np.abs(excess), slides),
            "direction of slip": worst(np.abs(turn), slides),
            "slip along the force": worst(-along * np.sign(length), slides),
        }


def blocks(multiplier: np.ndarray, m: int) -> np.ndarray:
    """Normal and two tangential components of every pane, [m, 3]."""
    return np.column_stack([multiplier[:m], multiplier[m:].reshape(m, 2)])


def paired(values: np.ndarray, m: int) -> np.ndarray:
    """Values with both of each tangential pair replaced by their mean."""
    mean = values[m:].reshape(m, 2).mean(axis=1)
    return np.concatenate([values[:m], np.repeat(mean, 2)])
