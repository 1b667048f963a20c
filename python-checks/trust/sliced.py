"""Products of a sparse matrix with a dense one, exact down to a given level.

Rows of the matrix and columns of the factor are cut into slices of few bits, the slices
of one row or column with a common exponent, so that products and sums of slices are exact
in double precision (the splitting of Ozaki, Ogita, Oishi and Rump). The sums of slices
are added without loss.
"""

import math
from dataclasses import dataclass

import numpy as np
from scipy import sparse

from trust.double_double import DD, two_sum

DOUBLE_BITS = 53


def exponent(values: np.ndarray) -> np.ndarray:
    """The least e with |value| < 2^e; 0 where the value is 0."""
    return np.frexp(values)[1]


class LongSum:
    """Sums of arrays of doubles, kept as four doubles each: rounding is 2^-200 of the largest."""

    def __init__(self, *shape: int) -> None:
        """Zeros."""
        self.parts = [np.zeros(shape) for _ in range(4)]

    def add(self, values: np.ndarray) -> None:
        """Add an array; every part passes on what its own rounding loses."""
        for k, part in enumerate(self.parts):
            self.parts[k], values = two_sum(part, values)

    def value(self) -> DD:
        """The sum to twice the precision of a double."""
        total = DD.of(self.parts[-1])
        for part in self.parts[-2::-1]:
            total = total + part
        return total


@dataclass(frozen=True)
class SlicedMatrix:
    """A sparse matrix in slices, the first of which holds the leading bits of every row."""

    slices: list[sparse.csr_matrix]
    bits: int

    @classmethod
    def of(cls, matrix: sparse.spmatrix) -> "SlicedMatrix":
        """Cut a matrix into as many slices as it takes to hold all bits."""
        matrix = sparse.csr_matrix(matrix)
        longest = int(np.diff(matrix.indptr).max(initial=1))
        bits = (DOUBLE_BITS - math.ceil(math.log2(max(longest, 1)))) // 2
        largest = abs(matrix).max(axis=1).toarray().ravel()
        of_row = np.repeat(exponent(largest), np.diff(matrix.indptr))
        slices, rest = [], matrix.data.copy()
        while rest.any():
            of_row = of_row - bits
            part = np.ldexp(np.rint(np.ldexp(rest, -of_row)), of_row)
            rest = rest - part
            shape = (part, matrix.indices, matrix.indptr)
            slices.append(sparse.csr_matrix(shape, shape=matrix.shape))
        return cls(slices, bits)

    def add_product(self, total: LongSum, factor: np.ndarray, drop: int) -> None:
        """Add matrix * factor without what is `drop` bits below the leading bits of the product,
        row by row and column by column."""
        of_column = exponent(np.abs(factor).max(axis=0))
        rest = factor.copy()
        # Slices p and q multiply to something 2^(bits (p + q)) below the first two.
        levels = max(1, math.ceil(drop / self.bits))
        for q in range(levels):
            if not rest.any():
                break
            of_column = of_column - self.bits
            part = np.ldexp(np.rint(np.ldexp(rest, -of_column)), of_column)
            rest = rest - part
            for piece in self.slices[: levels - q]:
                total.add(piece @ part)
