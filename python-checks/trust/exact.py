"""S = B A^-1 B', h = B A^-1 l - gap and the slip of the contact nodes, to some 28 digits.

The arrays are those of a run file, taken as exact. A^-1 [B', l] comes from a factorisation in double
precision and iterative refinement: every correction is found in double precision from a residual in
sums of four doubles, until corrections vanish, whatever the condition of A below 1e15.
"""

from dataclasses import dataclass

import h5py
import numpy as np
from scipy import sparse
from scipy.sparse.linalg import splu

from run_file import read_matrix, read_scene
from trust.double_double import DD
from trust.sliced import LongSum, SlicedMatrix

KEPT_BITS = 160
"""Products keep the bits down to 2^-160 of the largest term of a row and column: 2^-106 and what the
condition of A takes."""
SMALLEST_CORRECTION = 2.0**-106
MOST_CORRECTIONS = 60
LARGEST_ASYMMETRY = 1e-28
"""Of S over its largest entry: both halves come from different columns of A^-1 B'."""
SLOWEST = 0.25
"""Refinement that does not gain two bits a step does not settle."""


class Unsettled(ArithmeticError):
    """Iterative refinement does not converge: A is singular to double precision."""


@dataclass(frozen=True)
class Exact:
    """The dual problem of a run file: minimise lambda' S lambda / 2 - h' lambda, and its law."""

    scene: dict
    area: np.ndarray
    pane_average: np.ndarray
    operator: DD
    rhs: DD
    slip_free: DD
    compliance: DD

    @property
    def n_panes(self) -> int:
        """Number of panes, or of nodes that carry multipliers."""
        return self.area.size

    @classmethod
    def read(cls, file: h5py.File) -> "Exact":
        """Compute everything from an assembled file."""
        assemble, mesh = file["assemble"], file["mesh"]
        scene = read_scene(file)
        names = ("coupling_normal", "coupling_tangential")
        coupling = sparse.vstack([read_matrix(assemble[n]) for n in names], "csr")
        dof = assemble["degree_of_freedom"][:]
        nodes = mesh["contact_nodes"][:]
        slip = slip_rows(scene, dof[nodes], coupling.shape[1])
        right = sparse.hstack([coupling.T, file["load/force"][:][:, None]]).toarray()
        rows = sparse.vstack([coupling, slip], "csr")
        values = applied_inverse(read_matrix(assemble["stiffness"]), right, rows)
        m3 = coupling.shape[0]
        asymmetry = np.abs((values[:m3, :m3] - values[:m3, :m3].T).hi).max()
        if asymmetry > LARGEST_ASYMMETRY * np.abs(values[:m3, :m3].hi).max():
            raise Unsettled(f"S is not symmetric: {asymmetry:.1e}")
        average = read_matrix(mesh["pane_average"])
        area = mesh["pane_area"][:]
        gap = gap_integrals(scene, average, area, mesh["coordinates"][:][nodes])
        closing = np.concatenate([gap, np.zeros(2 * area.size)])
        pairs = (len(nodes), 2)
        return cls(
            scene=scene,
            area=area,
            pane_average=average.toarray(),
            operator=values[:m3, :m3],
            rhs=values[:m3, m3] - closing,
            slip_free=values[m3:, m3].reshape(*pairs),
            compliance=values[m3:, :m3].reshape(*pairs, m3),
        )


def applied_inverse(
    stiffness: sparse.csc_matrix, right: np.ndarray, rows: sparse.csr_matrix
) -> DD:
    """rows * A^-1 * right."""
    # Powers of two scale A to a diagonal between 1/2 and 2 without rounding.
    scale = np.ldexp(1.0, -(np.frexp(stiffness.diagonal())[1] // 2))
    diagonal = sparse.diags_array(scale)
    scaled = sparse.csc_matrix(diagonal @ stiffness @ diagonal)
    factor = splu(
        scaled,
        permc_spec="MMD_AT_PLUS_A",
        diag_pivot_thresh=0.0,
        options={"SymmetricMode": True},
    )
    sliced = SlicedMatrix.of(scaled)
    reading = SlicedMatrix.of(rows @ diagonal)
    residual = LongSum(*right.shape)
    residual.add(scale[:, None] * right)
    values = LongSum(rows.shape[0], right.shape[1])
    largest, before = np.zeros(right.shape[1]), np.inf
    for _ in range(MOST_CORRECTIONS):
        correction = factor.solve(residual.value().hi)
        size = np.abs(correction).max(axis=0)
        largest = np.maximum(largest, size)
        share = float(np.max(size / np.where(largest > 0.0, largest, 1.0)))
        if share <= SMALLEST_CORRECTION:
            return values.value()
        if share > SLOWEST * before:
            raise Unsettled(f"corrections shrink from {before:.1e} to {share:.1e} only")
        drop = KEPT_BITS + int(np.ceil(np.log2(share)))
        reading.add_product(values, correction, drop)
        sliced.add_product(residual, -correction, drop)
        before = share
    raise Unsettled("too many corrections")


def frame(scene: dict) -> np.ndarray:
    """Rows: t1 and t2 = t1 x normal of a flat face of a brick."""
    contact = scene["contact"]
    axis, end = contact["face"].split("_")
    normal = np.eye(3)["xyz".index(axis)] * (1.0 if end == "max" else -1.0)
    default = [0.0, 1.0, 0.0] if axis == "x" else [1.0, 0.0, 0.0]
    first = np.array(contact.get("axis_1", default), dtype=float)
    first = first / np.linalg.norm(first)
    return np.array([first, np.cross(first, normal)])


def slip_rows(scene: dict, dof: np.ndarray, n_free: int) -> sparse.csr_matrix:
    """The matrix that reads u_t1, u_t2 of every contact node from the free components of u."""
    axes = frame(scene)
    rows, columns, values = [], [], []
    for node, triple in enumerate(dof):
        for direction, axis in enumerate(axes):
            for component in np.flatnonzero((triple >= 0) & (axis != 0.0)):
                rows.append(2 * node + direction)
                columns.append(triple[component])
                values.append(axis[component])
    shape = (2 * len(dof), n_free)
    return sparse.csr_matrix((values, (rows, columns)), shape=shape)


def gap_integrals(
    scene: dict, average: sparse.csc_matrix, area: np.ndarray, places: np.ndarray
) -> np.ndarray:
    """Integrals of the initial gap over the panes, in the order of the program's sums."""
    gap = nodal_gap(scene["contact"].get("gap", 0.0), places)
    integrals = np.zeros(area.size)
    for pane in range(area.size):
        mean = 0.0
        for k in range(average.indptr[pane], average.indptr[pane + 1]):
            mean += average.data[k] * gap[average.indices[k]]
        integrals[pane] = area[pane] * mean
    return integrals


def nodal_gap(gap: float | str, places: np.ndarray) -> np.ndarray:
    """The gap at the contact nodes: a number, or a sum of products as `scenes` writes them."""
    if not isinstance(gap, str):
        return np.full(len(places), float(gap))
    total = np.zeros(len(places))
    for term in gap.split(" + "):
        slope, _, name = term.partition("*")
        along = places[:, "xyz".index(name)] if name else 1.0
        total = total + float(slope) * along
    return total
