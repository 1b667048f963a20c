"""Checks a linear engine of contact3d-pipe (engines/protocol.md, version 1) against SciPy in double precision.

`python check_engine.py [--tolerance T] [--large CELLS] ENGINE [ARGUMENTS]` starts the engine as often as it needs,
prints a line for each check, and ends with 1 where one failed. T bounds the error of an answer relative to its largest
number. --large CELLS takes one cube of CELLS^3 nodes with 300 rows in B instead, its order a geometric nested
dissection.
"""

import argparse
import signal
import struct
import subprocess
import sys
import time

import numpy as np
from scipy.sparse import coo_array, csr_array, diags_array, eye_array, random_array, tril
from scipy.sparse.csgraph import reverse_cuthill_mckee
from scipy.sparse.linalg import splu

SEED = 7
LEAVE, FACTORISE, SOLVE, COMPLIANCE = range(4)
DONE, NOT_POSITIVE, NO_MEMORY, OTHER = range(4)
SECONDS = 300  # the longest wait for one answer


class Engine:
    """A running engine."""

    def __init__(self, command):
        self.process = subprocess.Popen(command, stdin=subprocess.PIPE, stdout=subprocess.PIPE)
        signal.alarm(SECONDS)
        assert self.get(8) == b"C3DENG01"
        self.name = self.get(self.u64()).decode()

    def __enter__(self):
        return self

    def __exit__(self, *failure):
        if failure[0]:
            self.process.kill()
        self.process.stdin.close()
        self.process.wait()
        signal.alarm(0)

    def get(self, size):
        """Bytes of an answer."""
        data = self.process.stdout.read(size)
        if len(data) < size:
            raise EOFError(f"the engine ended with {self.process.wait()}")
        return data

    def u64(self):
        """An integer of an answer."""
        return struct.unpack("<Q", self.get(8))[0]

    def numbers(self, *shape):
        """Numbers of an answer."""
        return np.frombuffer(self.get(4 * int(np.prod(shape))), "<f4").reshape(shape).astype(float)

    def ask(self, request):
        """Sends a request; the status of its answer, with the text or unknown of a failure in `self.said`."""
        signal.alarm(SECONDS)
        self.process.stdin.write(request)
        self.process.stdin.flush()
        status = self.u64()
        if status == NOT_POSITIVE:
            self.said = self.u64()
        elif status != DONE:
            self.said = self.get(self.u64()).decode()
        return status

    def end(self):
        """Closes the engine's input; its exit status. Nothing may be left in its output."""
        self.process.stdin.close()
        assert self.process.stdout.read() == b""
        return self.process.wait()


def packed(*parts):
    """Integers as u64, bytes and arrays as they are."""
    return b"".join(struct.pack("<Q", p) if isinstance(p, int) else bytes(p) for p in parts)


def sparse_bytes(start, index, value):
    """The three arrays of a sparse matrix."""
    return np.asarray(start).astype("<u8").tobytes() + index.astype("<u4").tobytes() + value.astype("<f8").tobytes()


def factorise_request(a, order, b, edit=lambda parts: None):
    """Request 1; `edit` may spoil the parts first."""
    lower = tril(a).tocsc()
    lower.sort_indices()
    parts = {
        "start": lower.indptr.astype("<u8"), "rows": lower.indices.astype("<u4"), "values": lower.data.astype("<f8"),
        "order": np.asarray(order).astype("<u4"),
        "b_start": b.indptr.astype("<u8"), "b_columns": b.indices.astype("<u4"), "b_values": b.data.astype("<f8"),
    }
    edit(parts)
    return packed(FACTORISE, a.shape[0], len(parts["rows"]), b.shape[0], len(parts["b_columns"]),
                  *(p.tobytes() for p in parts.values()))


def solve_request(right):
    """Request 2 of right-hand sides in rows."""
    return packed(SOLVE, len(right), right.astype("<f4").tobytes())


def compliance_request(c):
    """Request 3."""
    return packed(COMPLIANCE, c.shape[0], c.nnz, sparse_bytes(c.indptr, c.indices, c.data))


# ---- matrices ----


def scaled(a):
    """With a unit diagonal."""
    d = diags_array(1 / np.sqrt(a.diagonal()))
    return csr_array(d @ a @ d)


def grid_pairs(cells, reach):
    """Pairs of neighbouring nodes of a cube of nodes, and their directions; reach 1: 6 neighbours, 3: 26."""
    node = np.arange(cells**3).reshape(cells, cells, cells)
    for step in np.ndindex(3, 3, 3):
        d = np.array(step) - 1
        if tuple(d) <= (0, 0, 0) or np.sum(np.abs(d)) > reach:
            continue
        first = tuple(slice(max(0, -s), cells - max(0, s)) for s in d)
        second = tuple(slice(max(0, s), cells + min(0, s)) for s in d)
        yield node[first].ravel(), node[second].ravel(), d / np.linalg.norm(d)


def laplace(rng, cells, reach=1, shift=0.02):
    """A random conductance on each edge of the grid."""
    a = shift * eye_array(cells**3)
    for i, j, _ in grid_pairs(cells, reach):
        k = rng.uniform(0.5, 2, len(i))
        a = a + coo_array((np.r_[k, k, -k, -k], (np.r_[i, j, i, j], np.r_[i, j, j, i])), a.shape)
    return scaled(a)


def elastic(rng, cells, shift=0.05):
    """Springs between neighbouring nodes, which move in three directions."""
    a = shift * eye_array(3 * cells**3)
    for i, j, d in grid_pairs(cells, 3):
        k = rng.uniform(0.5, 2, len(i))
        for p, q in np.argwhere(np.abs(np.outer(d, d)) > 1e-12):
            v, ip, jp, iq, jq = k * d[p] * d[q], 3 * i + p, 3 * j + p, 3 * i + q, 3 * j + q
            a = a + coo_array((np.r_[v, v, -v, -v], (np.r_[ip, jp, ip, jp], np.r_[iq, jq, jq, iq])), a.shape)
    return scaled(a)


def random_rows(rng, m, n, density):
    """A matrix such as B or C."""
    return csr_array(random_array((m, n), density=density, rng=rng, data_sampler=rng.standard_normal))


def dissection(low, high):
    """Nodes of a box of the grid, halves before the plane between them."""
    size = [h - l for l, h in zip(low, high)]
    axis = int(np.argmax(size))
    if size[axis] < 4:
        return [tuple(l + s for l, s in zip(low, step)) for step in np.ndindex(*size)]
    middle = low[axis] + size[axis] // 2
    cut = lambda corner, value: [value if k == axis else c for k, c in enumerate(corner)]
    return (dissection(low, cut(high, middle)) + dissection(cut(low, middle + 1), high)
            + dissection(cut(low, middle), cut(high, middle + 1)))


def dissection_order(cells):
    """A fill-reducing order of a cube of nodes."""
    nodes = np.array(dissection([0, 0, 0], [cells] * 3))
    return nodes @ [cells * cells, cells, 1]


# ---- checks ----


class Checks:
    """Prints what passed and what did not."""

    def __init__(self, tolerance):
        self.tolerance, self.failed = tolerance, 0

    def that(self, passed, what):
        """One check."""
        self.failed += not passed
        print(f"{'ok    ' if passed else 'FAILED'}  {what}", flush=True)

    def close(self, what, got, wanted):
        """An answer against double precision."""
        scale = np.max(np.abs(wanted), initial=0.0)
        error = np.max(np.abs(got - wanted), initial=0.0) / scale if scale else float(np.any(got))
        self.that(error <= self.tolerance, f"{what}: error {error:.1e}")


def check_system(checks, engine, rng, name, a, order, b, counts=(1, 3)):
    """FACTORISE, SOLVE for each count, and COMPLIANCE."""
    n, m = a.shape[0], b.shape[0]
    exact = splu(a.tocsc())
    status = engine.ask(factorise_request(a, order, b))
    if status != DONE:
        checks.that(False, f"{name}: status {status}, {engine.said}")
        return
    entries, largest, total = engine.u64(), engine.u64(), engine.u64()
    s = engine.numbers(m, m)
    dense = n * (n + 1) // 2 + n * m  # with the rows of B, which MUMPS counts
    checks.that(n <= entries <= dense and largest <= total, f"{name}: {entries} entries, {total} bytes")
    wanted = exact.solve(b.toarray().T)
    checks.close(f"{name}: S", s, b @ wanted)
    checks.that(np.array_equal(s, s.T), f"{name}: S is symmetric")
    for count in counts:
        right = rng.standard_normal((count, n)).astype("<f4")
        if engine.ask(solve_request(right)) == DONE:
            checks.close(f"{name}: {count} solved", engine.numbers(count, n), exact.solve(right.T.astype(float)).T)
        else:
            checks.that(False, f"{name}: SOLVE, {engine.said}")
    for c in (random_rows(rng, 40, n, 0.1), random_rows(rng, 0, n, 0.1), b):
        if engine.ask(compliance_request(c)) == DONE:
            checks.close(f"{name}: G of {c.shape[0]}", engine.numbers(m, c.shape[0]), (c @ wanted).T)
        else:
            checks.that(False, f"{name}: COMPLIANCE, {engine.said}")


def systems(rng):
    """Name, A, order, B and numbers of right-hand sides."""
    one = csr_array([[1.0]])
    yield "1 unknown, m = 0", one, [0], csr_array((0, 1)), (1,)
    yield "1 unknown, m = 2", one, [0], csr_array([[2.0], [-1.0]]), (1,)
    yield "diagonal", csr_array(eye_array(50)), rng.permutation(50), random_rows(rng, 7, 50, 0.2), (1,)
    a = laplace(rng, 2)
    yield "more rows than unknowns", a, rng.permutation(8), random_rows(rng, 20, 8, 0.5), (1, 200)
    empty = csr_array((130, a.shape[0]))
    yield "B without entries", a, rng.permutation(8), empty, (1,)
    a = laplace(rng, 6)
    twice = csr_array((np.ones(4), np.array([5, 5, 9, 3]), np.array([0, 2, 2, 4])), (3, 216))
    yield "repeated and unsorted columns in B", a, rng.permutation(216), twice, (2,)
    yield "Laplace 216, random order, m = 0", a, rng.permutation(216), csr_array((0, 216)), (1, 64, 65)
    yield "Laplace 216, dense B", a, rng.permutation(216), random_rows(rng, 30, 216, 1.0), (1,)
    a = elastic(rng, 6)
    yield "elastic 648, RCM", a, reverse_cuthill_mckee(a), random_rows(rng, 90, 648, 0.02), (1, 130)
    a = elastic(rng, 11)
    yield "elastic 3993, random order", a, rng.permutation(3993), random_rows(rng, 200, 3993, 0.005), (1, 5)
    yield "elastic 3993, RCM, m = 0", a, reverse_cuthill_mckee(a), csr_array((0, 3993)), (1,)
    a = laplace(rng, 17, 3)
    yield "Laplace 4913, 27 points, dissection", a, dissection_order(17), random_rows(rng, 500, 4913, 0.002), (1, 70)
    yield "Laplace 4913, 27 points, m = 0", a, dissection_order(17), csr_array((0, 4913)), (1, 70)


def check_indefinite(checks, engine, rng):
    """Matrices that are not positive definite, each followed by SOLVE; the last process goes on with a good one."""
    for cells in (2, 6, 16):
        n = cells**3
        good = laplace(rng, cells)
        for name, shift in (("one negative pivot", 3.0), ("a zero row and column", None), ("half the spectrum", 1.0)):
            for m in (0, 5):
                bad = good.tolil()
                if name == "half the spectrum":
                    bad = good - shift * eye_array(n)
                else:
                    at = int(rng.integers(n))
                    if shift is None:
                        bad[at, :] = bad[:, at] = 0
                    else:
                        bad[at, at] -= shift
                status = engine.ask(factorise_request(csr_array(bad), rng.permutation(n), random_rows(rng, m, n, 0.2)))
                said = engine.said if status == NOT_POSITIVE else None
                passed = status == NOT_POSITIVE and (said < n or said == 2**64 - 1)
                checks.that(passed, f"{name} of {n}, m = {m}: status {status}")
                if status == DONE:
                    engine.get(24 + 4 * m * m)
                checks.that(engine.ask(solve_request(np.ones((2, n)))) == OTHER, "  SOLVE after it is refused")
                checks.that(engine.ask(compliance_request(csr_array(eye_array(n)))) == OTHER, "  so is COMPLIANCE")


def spoilt(n):
    """What may be wrong in a FACTORISE."""
    def put(part, at, value):
        def edit(parts):
            parts[part][at] = value
        return edit

    def missing_diagonal(parts):
        parts["start"] = np.zeros(n + 1, "<u8")
        parts["rows"], parts["values"] = parts["rows"][:0], parts["values"][:0]

    yield "a row of A past the end", put("rows", -1, n), OTHER
    yield "a row of A far past the end", put("rows", 3, 2**32 - 1), OTHER
    yield "an entry above the diagonal", put("rows", -1, 0), OTHER
    yield "equal rows in a column", lambda p: p["rows"].__setitem__(1, p["rows"][0]), OTHER
    yield "the first offset of A", put("start", 0, 1), OTHER
    yield "the last offset of A", put("start", -1, 2**63), OTHER
    yield "an offset of A inside", put("start", 5, 2**64 - 1), OTHER
    yield "a column of B past the end", put("b_columns", 0, n), OTHER
    yield "an offset of B", put("b_start", 1, 2**40), OTHER
    yield "an order with a repetition", lambda p: p["order"].__setitem__(0, p["order"][1]), OTHER
    yield "an order past the end", put("order", 0, n), OTHER
    yield "a NaN in A", put("values", 2, np.nan), OTHER
    yield "an infinity in B", put("b_values", 0, np.inf), OTHER
    yield "A without entries", missing_diagonal, NOT_POSITIVE


def check_faults(checks, engine, rng):
    """Requests that are refused."""
    a, order, b = laplace(rng, 4), rng.permutation(64), random_rows(rng, 5, 64, 0.3)
    for name, edit, wanted in spoilt(64):
        status = engine.ask(factorise_request(a, order, b, edit))
        checks.that(status == wanted, f"{name}: status {status}, {engine.said}")
    status = engine.ask(packed(FACTORISE, 0, 0, 0, 0, 0, 0))
    checks.that(status == OTHER, f"no unknowns: status {status}, {engine.said}")
    check_system(checks, engine, rng, "after the faults", a, order, b)
    checks.that(engine.ask(solve_request(np.ones((0, 64)))) == OTHER, "no right-hand sides: refused")
    c = random_rows(rng, 3, 64, 0.2)
    c.indices[0] = 64
    checks.that(engine.ask(compliance_request(c)) == OTHER, f"a column of C past the end: {engine.said}")
    c.indices[0], c.indptr[1] = 0, 1000
    checks.that(engine.ask(compliance_request(c)) == OTHER, f"an offset of C: {engine.said}")
    checks.that(engine.ask(solve_request(np.ones((1, 64)))) == DONE, "the factor outlives them")
    engine.get(4 * 64)


def check_ends(checks, command, rng):
    """How the engine ends."""
    with Engine(command) as engine:
        checks.that(engine.end() == 0, "no request at all: ends with 0")
    with Engine(command) as engine:
        checks.that(engine.ask(packed(SOLVE, 1)) == OTHER, "SOLVE before any FACTORISE is refused")
        checks.that(engine.ask(compliance_request(csr_array((0, 4)))) == OTHER, "so is COMPLIANCE")
        engine.process.stdin.write(packed(LEAVE))
        checks.that(engine.end() == 0, "LEAVE: ends with 0")
    request = factorise_request(laplace(rng, 4), rng.permutation(64), random_rows(rng, 5, 64, 0.3))
    for size in (3, 8, 20, 200, len(request) - 1):
        with Engine(command) as engine:
            engine.process.stdin.write(request[:size])
            status = engine.end()
            checks.that(status == 1, f"{size} bytes of a request: ends with {status}")
    for name, broken in (("an unknown request", packed(99)), ("an endless array", packed(FACTORISE, 4, 2**63, 0, 0))):
        with Engine(command) as engine:
            engine.process.stdin.write(broken)
            status = engine.end()
            checks.that(status == 1, f"{name}: ends with {status}")


def check_large(checks, command, rng, cells):
    """Against residuals, and S against A^-1 B^T from SOLVE."""
    a, n, m = laplace(rng, cells, 3), cells**3, 300
    b = random_rows(rng, m, n, 9 / n)
    request = factorise_request(a, dissection_order(cells), b)
    with Engine(command) as engine:
        begun = time.perf_counter()
        if engine.ask(request) != DONE:
            checks.that(False, f"large: {engine.said}")
            return
        entries, largest, total, s = engine.u64(), engine.u64(), engine.u64(), engine.numbers(m, m)
        took = time.perf_counter() - begun
        print(f"        {engine.name}: {n} unknowns, {len(request) / 1e6:.0f} MB sent, FACTORISE {took:.2f} s,"
              f" {entries / 1e6:.2f} million entries, {total / 1e6:.0f} MB (largest process {largest / 1e6:.0f})")
        begun = time.perf_counter()
        assert engine.ask(solve_request(b.toarray())) == DONE
        x = engine.numbers(m, n)
        middle = time.perf_counter()
        assert engine.ask(compliance_request(b)) == DONE
        g = engine.numbers(m, m)
        print(f"        SOLVE of {m} {middle - begun:.2f} s, COMPLIANCE {time.perf_counter() - middle:.2f} s")
        begun = time.perf_counter()
        assert engine.ask(solve_request(np.ones((1, n)))) == DONE
        engine.get(4 * n)
        print(f"        SOLVE of 1 {time.perf_counter() - begun:.3f} s")
    checks.close("large: A x against b", a @ x.T, b.toarray().T)
    checks.close("large: S against B x", s, b @ x.T)
    checks.close("large: G against S", g, s)


def main():
    """Runs all checks."""
    parser = argparse.ArgumentParser(description="checks a linear engine of contact3d-pipe")
    parser.add_argument("--tolerance", type=float, default=1e-5)
    parser.add_argument("--large", type=int, default=0, metavar="CELLS", help="one cube of CELLS^3 nodes instead")
    parser.add_argument("command", nargs=argparse.REMAINDER)
    options = parser.parse_args()
    rng, checks = np.random.default_rng(SEED), Checks(options.tolerance)
    if options.large:
        check_large(checks, options.command, rng, options.large)
    else:
        with Engine(options.command) as engine:
            print(engine.name)
            for system in systems(rng):
                check_system(checks, engine, rng, *system)
            check_indefinite(checks, engine, rng)
            check_faults(checks, engine, rng)
            checks.that(engine.end() == 0, "the input's end: ends with 0")
        check_ends(checks, options.command, rng)
    print(f"{checks.failed} failed")
    sys.exit(checks.failed > 0)


if __name__ == "__main__":
    main()
