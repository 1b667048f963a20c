"""What is measured: figures in the units of the scene, which HKL's norms mix."""

import math
from collections.abc import Callable
from dataclasses import asdict, dataclass, replace
from typing import Any

import pandas as pd

from .._plots import axes

#: An observed rate that differs less from the spectral radius agrees; radii outside of this range are too fast or slow to observe.
AGREEMENT = 0.02
OBSERVABLE = (0.02, 0.98)


@dataclass(frozen=True)
class LawConstants:
    """F_min and F_max of (2.4), L of (3.10), kappa of Lemma 3.5; estimates where a coefficient is a formula."""

    f_min: float
    f_max: float
    lipschitz: float
    kappa: float
    estimated: bool


@dataclass(frozen=True)
class FaceConstants:
    """Constants of the contact face alone.

    :param h: the largest diameter of a triangle; :param big_h: that of a pane, h for nodal multipliers.
    :param c_r_absolute: (3.3) for Lagrange's interpolation of |phi| with phi in Y^h, where (3.6) uses it.
    :param c_r_lagrange: (3.3) on linear functions of triangles cut in 2^2, 4^2, 8^2; :param c_r_clement: the same for (3.19).
    """

    h: float
    big_h: float
    c_inv_10: float
    c_inv_infinity: float
    c_t: float
    c_r_absolute: float
    c_r_lagrange: tuple[float, ...]
    c_r_clement: tuple[float, ...]


@dataclass(frozen=True)
class NormConstants:
    """Constants of one mesh in a norm of displacements, the radii of Lemma 3.3, and bounds of the Lipschitz modulus of Psi.

    Bounds grow in proportion to the law. ``q_composed`` is a proof up to rounding, unless the constants of the law are estimates.
    For a law that follows the slip ``c_tr_4``, a lower bound, may make the others too small.

    :param load: |l|_*; :param continuity: M.
    :param max_trace: max |v| <= c |v|, in place of c_inv(inf) c_tr(4) / sqrt(h).
    :param interpolated_trace: of r_h |v_t|, in place of c_tr(2) (c_inv(1,0) c_r c_t + 1).
    :param tangential_trace: of v_t, in place of c_tr(2).
    :param q: (3.13) in the norm |phi| + |mu|, whose parts have different units.
    :param q_weighted: the least bound over all weights of the parts, free of units in the energy norm.
    :param q_composed: the same with products of constants replaced by the bounds that they stand for.
    :param q_averaged: q_weighted for the program's friction functional, which averages over panes or lumps.
    """

    alpha: float
    continuity: float
    load: float
    c_inv_half: float
    c_tr_2: float
    c_tr_4: float
    max_trace: float
    interpolated_trace: float
    tangential_trace: float
    radius_slip: float
    radius_pressure: float
    q: float
    q_weighted: float
    q_composed: float
    q_averaged: float


@dataclass(frozen=True)
class MultiplierSpace:
    """How stable a space of multipliers on the contact face of a brick is in the norm of H1.

    :param ratio: H / h; :param smallest: the least |mu|^2_*,h / |mu|^2_0, positive by (3.1); :param c_inv_half: (3.16).
    :param beta: the Babuska-Brezzi constant against the finest mesh; None there.
    """

    space: str
    ratio: float
    smallest: float
    c_inv_half: float
    beta: float | None


@dataclass(frozen=True)
class Contraction:
    """Psi' at a solution: its spectral radius, the sign of det(I - Psi'), and its least norms |Psi'| in w |phi| + |mu| over all
    weights w, in H1 and in the energy norm. The signs of all solutions add up to 1 (Theorem 3.1 by Brouwer's degree)."""

    spectral_radius: float
    sign: int
    norms: tuple[float, ...]


@dataclass(frozen=True)
class ScaledSolution:
    """The solution for the law times a factor; ``contraction`` is None where none was found."""

    scale: float
    contraction: Contraction | None


@dataclass(frozen=True)
class Level:
    """The theory on one mesh. What describes a solution is None without one.

    :param h1: constants in the norm of H1(Omega)^3; :param energy: in the energy norm.
    :param observed_rate: by which a small disturbance shrinks in each application of Psi; None without contact stresses.
    :param steps_from_zero: of successive approximations to a change of 1e-11; None where 200 do not suffice.
    :param lemma: the largest |phi| / R_1 and |lambda_nu|_* / R_2 on the way, in the energy norm: Lemma 3.3 says at most 1.
    :param functional: the program's friction functional over HKL's j, less 1, and the largest |F^-1 lambda_t| / g - 1 at points
        of pressed panes.
    :param norm_thresholds: the least factors of the law, to four digits, at which ``contraction.norms`` are 1; None where none
        up to 1e6 is found. :param radius_threshold: of the spectral radius; :param sign_threshold: of det(I - Psi') = 0.
    """

    mesh: str
    unknowns: int
    panes: int
    face: FaceConstants
    h1: NormConstants
    energy: NormConstants
    multipliers: tuple[MultiplierSpace, ...]
    contraction: Contraction | None
    observed_rate: float | None
    steps_from_zero: int | None
    lemma: tuple[float, float] | None
    functional: tuple[float, float] | None
    scaled: tuple[ScaledSolution, ...]
    norm_thresholds: tuple[float | None, ...]
    radius_threshold: float | None
    sign_threshold: float | None


@dataclass(frozen=True)
class Theory:
    """The theory of a scene on its meshes, coarse to fine."""

    law: LawConstants
    levels: tuple[Level, ...]

    @property
    def table(self) -> pd.DataFrame:
        """A column for each mesh, a row for each figure but those of scaled laws."""
        levels = (asdict(replace(level, multipliers=(), scaled=())) for level in self.levels)
        table = pd.json_normalize([_plain(level) for level in levels]).set_index("mesh")
        for level in self.levels:
            for space in level.multipliers:
                table.loc[level.mesh, [f"{space.space}: (3.1)", f"{space.space}: beta"]] = space.smallest, space.beta
        return table.T

    @property
    def problems(self) -> list[str]:
        """What contradicts the theory or this program, in words; empty where all is well."""
        found = []
        for level in self.levels:
            if level.contraction is None:
                found.append(f"{level.mesh}: no regular solution was found")
                continue
            radius, rate = level.contraction.spectral_radius, level.observed_rate
            if OBSERVABLE[0] < radius < OBSERVABLE[1] and (rate is None or abs(rate / radius - 1) > AGREEMENT):
                found.append(f"{level.mesh}: the rate {rate} is not the spectral radius {radius}")
            if level.lemma and max(level.lemma) > 1:
                found.append(f"{level.mesh}: a value of Psi contradicts Lemma 3.3")
        return found

    @property
    def findings(self) -> str:
        """What the figures of the finest mesh mean."""
        level, estimated = self.levels[-1], self.law.estimated
        proof = "would be proven, were the estimated constants of the law bounds," if estimated else "is proven"
        words = [f"{level.mesh}: uniqueness {proof} for this law times less than {1 / level.energy.q_composed:.2e}, by the bound "
                 f"with composed constants; (3.13) gives {1 / level.energy.q_weighted:.2e}"]
        if self.law.lipschitz > 0:
            words[0] += ", no proof, since c_tr(4) is a lower bound"
        limit = level.radius_threshold
        words.append("Near the solutions followed from small factors successive approximations contract "
                     + (f"up to {limit:.3f}." if limit else "at every factor solved, up to 1e6."))
        if level.contraction:
            radius, rate = level.contraction.spectral_radius, level.observed_rate
            observed = "no rate is observed" if rate is None else f"the observed rate {rate:.4f}"
            words.append(f"For the law itself the spectral radius is {radius:.4f}, {observed}.")
            followed = next((point.contraction for point in level.scaled if point.scale == 1.0), None)
            if followed and abs(followed.spectral_radius - radius) > AGREEMENT * max(radius, AGREEMENT):
                words.append(f"The solution followed to it is another one, with {followed.spectral_radius:.4f}.")
        return " ".join([words[0] + ".", *words[1:]])

    def plot(self, ax: Any = None) -> Any:
        """Draws with matplotlib, against H, the factors of the law at which bounds and Psi' reach 1."""
        ax = axes(ax, 0.7)
        of_level: dict[str, Callable[[Level], float | None]] = {
            "spectral radius = 1": lambda level: level.radius_threshold,
            "norm of Ψ′ = 1": lambda level: level.norm_thresholds[1],
            "q = 1, composed": lambda level: 1 / level.energy.q_composed,
            "q = 1, energy norm": lambda level: 1 / level.energy.q_weighted,
            "q = 1, norm of H¹": lambda level: 1 / level.h1.q_weighted,
        }
        sizes = [level.face.big_h for level in self.levels]
        for words, value in of_level.items():
            heights = [value(level) or math.nan for level in self.levels]
            if not all(map(math.isnan, heights)):
                ax.loglog(sizes, heights, "o-", label=words)
        last = self.levels[-1]
        for words, of in ("like √H", lambda face: face.big_h**0.5), ("like √(hH)", lambda face: (face.h * face.big_h) ** 0.5):
            guide = [of(level.face) / of(last.face) / last.energy.q_weighted for level in self.levels]
            ax.loglog(sizes, guide, ":", color="grey", label=words)
        ax.set(xlabel="diameter H of a pane", ylabel="factor of the law", xticks=sizes, xticklabels=[f"{size:.3g}" for size in sizes])
        ax.minorticks_off()
        ax.legend()
        return ax


def _plain(figures: dict[str, Any]) -> dict[str, Any]:
    """Tuples as an entry for each item."""
    plain: dict[str, Any] = {}
    for name, value in figures.items():
        if isinstance(value, dict):
            plain[name] = _plain(value)
        elif isinstance(value, tuple):
            plain |= {f"{name}_{k + 1}": item for k, item in enumerate(value)}
        else:
            plain[name] = value
    return plain
