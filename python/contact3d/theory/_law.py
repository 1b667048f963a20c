"""The law of friction of a scene: coefficients with their slopes by the slips, the slip bound, the slips."""

import re
from collections.abc import Mapping
from dataclasses import dataclass
from typing import Any

import numpy as np
from scipy import sparse

from ._forms import Array

#: A slip moves by this along the imaginary axis; the imaginary part of a formula over it is its slope, to rounding.
COMPLEX_STEP = 1e-30
#: Share of the largest displacement below which another one is zero.
VANISHING = 1e-12
#: What formulas of a scene may use. Complex numbers are compared by their real parts first: slopes are those on the right of kinks.
FUNCTIONS = {
    **{name: getattr(np, name) for name in ("sqrt", "exp", "log10", "sin", "cos", "tan", "sinh", "cosh", "tanh")},
    "asin": np.arcsin, "acos": np.arccos, "atan": np.arctan, "ln": np.log, "PI": np.pi, "E": np.e, "choose": np.where,
    "abs": lambda x: np.where(np.less(x, 0), -x, x), "min": np.minimum, "max": np.maximum,
}


@dataclass(frozen=True)
class FrictionLaw:
    """t F(x, |u_t1|, |u_t2|), and the slip bound g(lambda_nu).

    :param coefficients: that of an isotropic law, or two, as in the scene; :param scale: t.
    """

    coefficients: list[Mapping[str, Any]]
    parameters: Mapping[str, float]
    cap: float
    scale: float = 1.0

    @classmethod
    def of(cls, contact: Mapping[str, Any], scene: Mapping[str, Any]) -> "FrictionLaw":
        """The law of the only contact face of a scene."""
        friction = contact.get("friction") or scene["friction"]
        given = [friction[key] for key in ("coefficient", "coefficient_1", "coefficient_2") if key in friction]
        return cls(given, scene.get("parameters", {}), friction.get("pressure_cap", np.inf))

    def bound(self, pressure: Array) -> tuple[Array, Array]:
        """g and its slope by the pressure; at a cap that of larger pressures."""
        return np.clip(pressure, 0.0, self.cap), (pressure < self.cap).astype(float)

    def at(self, points: Array, slip: Array) -> tuple[Array, Array]:
        """F_1, F_2 at points, [n, 2], and their derivatives by |u_t1|, |u_t2|, [n, 2, 2]."""
        values, slopes, length = np.empty(slip.shape), np.empty((*slip.shape, 2)), np.hypot(*slip.T)
        for axis, given in enumerate(self.coefficients):
            # An isotropic law follows |u_t|, the coefficients of an orthotropic one the slips along their axes.
            along = np.divide(slip, length[:, None], out=np.zeros_like(slip), where=slip > 0)
            own, along = (length, along) if len(self.coefficients) == 1 else (slip[:, axis], np.eye(2)[axis])
            values[:, axis:], by_own, by_pair = (part[:, None] for part in self._coefficient(given, points, own, slip))
            slopes[:, axis:] = (by_own * along)[:, None] + by_pair
        return self.scale * values, self.scale * slopes

    def _coefficient(self, given: Mapping[str, Any], points: Array, own: Array, slip: Array) -> tuple[Array, Array, Array]:
        """A coefficient with its slopes by its own slip, and by the pair of slips."""
        ((kind, content),) = given.items()
        none = np.zeros_like(slip)
        if kind == "constant":
            return np.full(len(own), float(content)), none[:, 0], none
        if kind == "ramp":
            first, last = content["initial"], content["residual"]
            end = content["onset"] + (abs(first - last) / content["rate"] or 1.0)
            return *piecewise_linear([content["onset"], end], [first, last], own), none
        if kind == "table":
            return *piecewise_linear(content["slip"], content["value"], own), none
        if kind == "grid":
            rows = [piecewise_linear(content["slip_2"], row, slip[:, 1]) for row in content["value"]]
            (values, by_second), place = np.array(rows).transpose(1, 0, 2), np.arange(len(own))
            # Along the first slip the rows are the values of a table at each point.
            unit = [piecewise_linear(content["slip_1"], row, slip[:, 0]) for row in np.eye(len(rows))]
            weights, slopes = np.array(unit).transpose(1, 0, 2)
            value = np.sum(weights * values, axis=0)
            return value, none[:, 0], np.column_stack([np.sum(slopes * values, axis=0), np.sum(weights * by_second, axis=0)])
        return self._formula(content, np.column_stack([points, own, slip]))

    def _formula(self, text: str, variables: Array) -> tuple[Array, Array, Array]:
        """A formula in x, y, z, s, s1, s2. The program has read it before: it holds names, numbers and operators alone."""
        code = compile(re.sub(r"\bif\s*\(", "choose(", text).replace("^", "**"), "<coefficient of friction>", "eval")
        found = []
        for slip in (3, 4, 5):
            moved = variables.T.astype(complex)
            moved[slip] += 1j * COMPLEX_STEP
            names = dict(zip(("x", "y", "z", "s", "s1", "s2"), moved, strict=True))
            value = eval(code, {"__builtins__": {}}, {**FUNCTIONS, **self.parameters, **names})
            found.append(np.broadcast_to(value, moved[slip].shape))
        own, *pair = (np.imag(part) / COMPLEX_STEP for part in found)
        return np.real(found[0]), own, np.column_stack(pair)


def piecewise_linear(knots: Any, values: Any, at: Array) -> tuple[Array, Array]:
    """A function through values at knots, constant beyond them, and its slope, from the left at knots."""
    slopes = np.concatenate([[0.0], np.diff(values) / np.diff(knots), [0.0]])
    return np.interp(at, knots, values), slopes[np.searchsorted(knots, at)]


def slips_of(tangential: Array) -> tuple[Array, sparse.csr_array]:
    """phi = (|u_t1|, |u_t2|) at the contact nodes, [n, 2], and its derivative by (u_t1, u_t2), [2 n, 2 n] node by node."""
    # Displacements that vanish by symmetry have a sign of rounding: the derivative is that of growing ones.
    vanishing = np.abs(tangential) <= VANISHING * np.abs(tangential).max(initial=0.0)
    signs = np.where(vanishing, 1.0, np.sign(tangential))
    return np.abs(tangential), sparse.diags_array(signs.ravel(), format="csr")
