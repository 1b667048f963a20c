"""A linear engine for contact3d-pipe on one process: SciPy's sparse factor in double precision.

Speaks the protocol of engines/protocol.md, version 1, and stands in for contact3d-mumps in tests where there is no MPI.
Needs Python with numpy and scipy, and takes no arguments.
"""

import struct
import sys

import numpy as np
from scipy.sparse import csc_array, csr_array, tril
from scipy.sparse.linalg import splu

DONE, NOT_POSITIVE, OTHER = 0, 1, 3


class NotPositive(Exception):
    """The argument is the unknown with the bad pivot, or 2^64 - 1 where not known."""


def get(dtype, count):
    """Numbers from standard input."""
    size = np.dtype(dtype).itemsize * count
    data = sys.stdin.buffer.read(size)
    if len(data) < size:
        sys.exit("reference_engine: standard input ended inside a request")
    return np.frombuffer(data, dtype)


def get_sparse(lines, entries):
    """Offsets, indices and values of a sparse matrix."""
    return get("<u8", lines + 1), get("<u4", entries), get("<f8", entries)


def put(status, *integers, tail=b""):
    """An answer; an array in the tail becomes f32."""
    tail = tail if isinstance(tail, bytes) else tail.astype("<f4").tobytes()
    sys.stdout.buffer.write(struct.pack(f"<{1 + len(integers)}Q", status, *integers) + tail)
    sys.stdout.buffer.flush()


def demand(right, otherwise):
    """Refuses a request."""
    if not right:
        raise ValueError(otherwise)


def sparse(kind, parts, lines, width):
    """A matrix by rows, or a square one by columns, once its parts make one."""
    start, index, value = parts
    demand(start[0] == 0 and start[-1] == len(index) and np.all(start[1:] >= start[:-1]), "bad offsets")
    demand(np.all(index < width), "an index is out of range")
    demand(np.all(np.isfinite(value)), "a value is not finite")
    return kind((value, index.astype(np.int64), start.astype(np.int64)), (lines, width))


def decompose(a, order):
    """L U of A in the order given, with pivots from the diagonal alone."""
    permuted = a.tocsr()[order][:, order].tocsc()
    try:
        lu = splu(permuted, "NATURAL", diag_pivot_thresh=0.0, options={"SymmetricMode": True})
    except RuntimeError as failure:  # a column without any pivot
        raise NotPositive(2**64 - 1) from failure
    bad = np.flatnonzero((lu.U.diagonal() <= 0) | (lu.perm_r != lu.perm_c))
    if len(bad):
        raise NotPositive(int(order[bad[0]]))
    return lu


class Engine:
    """Answers one request after another."""

    n, lu, order, b = 0, None, None, None

    def factorise(self):
        """Request 1; the triangular factors stay in double precision."""
        self.lu = None
        self.n, nnz, m, nnz_b = get("<u8", 4).tolist()
        a, order, b = get_sparse(self.n, nnz), get("<u4", self.n), get_sparse(m, nnz_b)
        demand(self.n > 0, "A has no unknowns")
        lower, self.b = sparse(csc_array, a, self.n, self.n), sparse(csr_array, b, m, self.n)
        column = np.repeat(np.arange(self.n), np.diff(lower.indptr))
        rising = (lower.indices[1:] > lower.indices[:-1]) | (column[1:] > column[:-1])
        demand(np.all(lower.indices >= column) and np.all(rising), "the rows of a column of A do not rise")
        demand(np.array_equal(np.sort(order), np.arange(self.n)), "the order is not a permutation of the unknowns")
        self.order = order.astype(np.int64)
        lu = self.lu = decompose(lower + tril(lower, -1).T, self.order)
        s = self.b @ self.solved(self.b.toarray().T)
        put(DONE, (lu.nnz + self.n) // 2, 12 * lu.nnz, 12 * lu.nnz, tail=s)

    def solved(self, columns):
        """A^-1 columns, an array of two dimensions."""
        return self.lu.solve(columns[self.order])[np.argsort(self.order)]

    def solve(self):
        """Request 2; n is that of the last FACTORISE, failed or not."""
        (count,) = get("<u8", 1).tolist()
        right = get("<f4", self.n * count).reshape(count, self.n)
        demand(self.lu and count > 0, "there is no factor, or no right-hand side")
        put(DONE, tail=self.solved(right.T.astype(float)).T)

    def compliance(self):
        """Request 3."""
        lines, entries = get("<u8", 2).tolist()
        c = get_sparse(lines, entries)
        demand(self.lu, "there is no factor")
        put(DONE, tail=(sparse(csr_array, c, lines, self.n) @ self.solved(self.b.toarray().T)).T)


def main():
    """Serves until standard input ends or request 0 comes."""
    name = b"SciPy reference"
    put(int.from_bytes(b"C3DENG01", "little"), len(name), tail=name)
    engine = Engine()
    requests = {1: engine.factorise, 2: engine.solve, 3: engine.compliance}
    while sys.stdin.buffer.peek(1):
        (request,) = get("<u8", 1).tolist()
        if request not in requests:
            sys.exit("reference_engine: an unknown request" if request else 0)
        try:
            requests[request]()
        except NotPositive as failure:
            put(NOT_POSITIVE, failure.args[0])
        except ValueError as failure:
            put(OTHER, len(str(failure)), tail=str(failure).encode())


if __name__ == "__main__":
    main()
