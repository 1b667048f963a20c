"""Double-double arithmetic on numpy arrays: some 32 decimal digits, and the range of a double.

A number is the unevaluated sum hi + lo of two doubles with |lo| <= ulp(hi)/2. The error-free sums
are Knuth's, the error-free products Dekker's and Veltkamp's; with a correctly rounded double
arithmetic a relative error is at most a few times 2^-104.
"""

from dataclasses import dataclass
from fractions import Fraction

import numpy as np

SPLITTER = 2.0**27 + 1.0


def two_sum(a: np.ndarray, b: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    """fl(a + b) and what rounding lost of it."""
    total = a + b
    part = total - a
    return total, (a - (total - part)) + (b - part)


def quick_two_sum(a: np.ndarray, b: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    """The same where |a| >= |b|."""
    total = a + b
    return total, b - (total - a)


def split(a: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    """Two halves of at most 26 bits each, for |a| below 1e300."""
    scaled = SPLITTER * a
    high = scaled - (scaled - a)
    return high, a - high


def two_product(a: np.ndarray, b: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    """fl(a b) and what rounding lost of it."""
    product = a * b
    (a1, a2), (b1, b2) = split(a), split(b)
    return product, ((a1 * b1 - product) + a1 * b2 + a2 * b1) + a2 * b2


@dataclass(frozen=True, eq=False)
class DD:
    """An array of double-double numbers."""

    hi: np.ndarray
    lo: np.ndarray

    # numpy must leave `array * DD` to this class.
    __array_ufunc__ = None

    @classmethod
    def of(cls, value: "DD | np.ndarray | float") -> "DD":
        """A number of double precision, or one that is of this kind already."""
        if isinstance(value, DD):
            return value
        hi = np.asarray(value, dtype=float)
        return cls(hi, np.zeros_like(hi))

    @classmethod
    def zeros(cls, *shape: int) -> "DD":
        """Zeros."""
        return cls(np.zeros(shape), np.zeros(shape))

    @classmethod
    def concatenate(cls, parts: list["DD"]) -> "DD":
        """Arrays one after the other."""
        parts = [cls.of(part) for part in parts]
        return cls(
            *(np.concatenate([getattr(p, k) for p in parts]) for k in ("hi", "lo"))
        )

    @property
    def shape(self) -> tuple[int, ...]:
        """Shape of the array."""
        return self.hi.shape

    @property
    def T(self) -> "DD":
        """The transposed matrix."""
        return DD(self.hi.T, self.lo.T)

    def __getitem__(self, index) -> "DD":
        return DD(self.hi[index], self.lo[index])

    def reshape(self, *shape: int) -> "DD":
        """The same numbers in another shape."""
        return DD(self.hi.reshape(shape), self.lo.reshape(shape))

    def __neg__(self) -> "DD":
        return DD(-self.hi, -self.lo)

    def __add__(self, other: "DD | np.ndarray | float") -> "DD":
        other = DD.of(other)
        total, error = two_sum(self.hi, other.hi)
        low, low_error = two_sum(self.lo, other.lo)
        total, error = quick_two_sum(total, error + low)
        return DD(*quick_two_sum(total, error + low_error))

    __radd__ = __add__

    def __sub__(self, other: "DD | np.ndarray | float") -> "DD":
        return self + (-DD.of(other))

    def __rsub__(self, other: "DD | np.ndarray | float") -> "DD":
        return DD.of(other) + (-self)

    def __mul__(self, other: "DD | np.ndarray | float") -> "DD":
        other = DD.of(other)
        product, error = two_product(self.hi, other.hi)
        return DD(
            *quick_two_sum(product, error + (self.hi * other.lo + self.lo * other.hi))
        )

    __rmul__ = __mul__

    def __truediv__(self, other: "DD | np.ndarray | float") -> "DD":
        other = DD.of(other)
        first = self.hi / other.hi
        rest = self - other * first
        second = rest.hi / other.hi
        rest = rest - other * second
        third = rest.hi / other.hi
        return DD(*quick_two_sum(first, second)) + third

    def __rtruediv__(self, other: "DD | np.ndarray | float") -> "DD":
        return DD.of(other) / self

    def sqrt(self) -> "DD":
        """Square roots of numbers >= 0."""
        root = np.sqrt(self.hi)
        safe = np.where(root > 0.0, root, 1.0)
        first = DD.of(root) + (self - DD.of(root) * root).hi / (2.0 * safe)
        return first + (self - first * first).hi / (2.0 * safe)

    def absolute(self) -> "DD":
        """Absolute values."""
        sign = np.where(self.hi < 0.0, -1.0, 1.0)
        return DD(sign * self.hi, sign * self.lo)

    def sum(self) -> "DD":
        """Sums along the last axis, pair by pair."""
        values = self
        while values.shape[-1] > 1:
            n = values.shape[-1]
            half = n // 2
            pairs = values[..., :half] + values[..., half : 2 * half]
            if n % 2:
                last = values[..., -1:]
                hi = np.concatenate([pairs.hi, last.hi], axis=-1)
                values = DD(hi, np.concatenate([pairs.lo, last.lo], axis=-1))
            else:
                values = pairs
        return values[..., 0] if values.shape[-1] else DD.zeros(*values.shape[:-1])

    def __matmul__(self, vector: "DD | np.ndarray") -> "DD":
        """A matrix times a vector."""
        return (self * DD.of(vector)).sum()

    def where(self, condition: np.ndarray, other: "DD | np.ndarray | float") -> "DD":
        """These numbers where the condition holds, the others elsewhere."""
        other = DD.of(other)
        hi = np.where(condition, self.hi, other.hi)
        return DD(hi, np.where(condition, self.lo, other.lo))

    def fraction(self) -> Fraction:
        """The exact value of a single number."""
        return Fraction(float(self.hi)) + Fraction(float(self.lo))
