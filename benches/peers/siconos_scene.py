"""Siconos on the HKL brick: local problems on CHOLMOD's dense Delassus matrix, or global ones.

Local, for the methods newton, nsgs and admm:
    u_c = q + W r,  W = H' A^-1 H,  q = H' A^-1 l,  Coulomb's law between r and u_c at each node.
Global, for global-admm: A u = l + H r, u_c = H' u; Siconos factorises with MUMPS, W is not formed.

Orthotropic friction at frozen coefficients is isotropic with mu = 1 after the exact scaling
D = diag(1, F1, F2): W' = D W D, q' = D q, r' = D^-1 r. A law F(u) needs an outer fixed point.
"""

from dataclasses import dataclass

import numpy as np
import siconos.numerics as sn
from scipy import sparse
from scipy.linalg.lapack import dpotri
from sksparse.cholmod import analyze

from hkl_brick import Brick, Report, coefficient, peer_arguments
from scenes import SCENES

LOCAL_SOLVERS = {
    "newton": sn.SICONOS_FRICTION_3D_NSN_AC,
    "nsgs": sn.SICONOS_FRICTION_3D_NSGS,
    "admm": sn.SICONOS_FRICTION_3D_ADMM,
}
GLOBAL_SOLVERS = {"global-admm": sn.SICONOS_GLOBAL_FRICTION_3D_ADMM}
MAX_ITERATIONS = 20000
BLOCK_COLUMNS = 128
OUTER_TOLERANCE = 1e-10
MAX_OUTER_STEPS = 100


@dataclass(frozen=True)
class Delassus:
    """W in m/N and q in m over contact nodes, normal component first."""

    matrix: np.ndarray
    offset: np.ndarray


def delassus_by_backsolves(brick: Brick, factor) -> Delassus:
    """Solve A X = H for blocks of columns."""
    dof = brick.contact_dof
    matrix = np.empty((dof.size, dof.size))
    for start in range(0, dof.size, BLOCK_COLUMNS):
        block = dof[start : start + BLOCK_COLUMNS]
        columns = np.zeros((brick.load.size, block.size), order="F")
        columns[block, np.arange(block.size)] = 1.0
        matrix[:, start : start + block.size] = factor.solve_A(columns)[dof]
    return Delassus((matrix + matrix.T) / 2, factor.solve_A(brick.load)[dof])


def contact_last(brick: Brick, ordering: np.ndarray) -> np.ndarray:
    """A fill-reducing order with the contact unknowns moved to its end."""
    is_contact = np.zeros(brick.load.size, dtype=bool)
    is_contact[brick.contact_dof] = True
    return np.concatenate([ordering[~is_contact[ordering]], brick.contact_dof])


def delassus_by_schur(brick: Brick, factor, order: np.ndarray) -> Delassus:
    """W = (L_cc L_cc')^-1 from the trailing block of a factor with contact unknowns last."""
    n_contact = brick.contact_dof.size
    # The trailing block is full, so CHOLMOD's postordering may reorder it but keeps it last.
    position = np.argsort(factor.P())[-n_contact:]
    start = brick.load.size - n_contact
    if position.min() < start:
        raise RuntimeError("CHOLMOD moved contact unknowns away from the end")
    trailing = factor.L()[start:, start:].toarray(order="F")
    lower, failed = dpotri(trailing, lower=1, overwrite_c=1)
    if failed:
        raise RuntimeError("singular Schur complement")
    full = np.tril(lower) + np.tril(lower, -1).T
    back = position - start
    offset = factor.solve_A(brick.load[order])[start:]
    return Delassus(full[np.ix_(back, back)], offset)


def compute_delassus(brick: Brick, way: str, ordering: str, report: Report):
    """W, q and the function b -> A^-1 b."""
    matrix = brick.stiffness
    with report.timed("factorisation"):
        symbolic = analyze(matrix, mode="supernodal", ordering_method=ordering)
        if way == "schur":
            order = contact_last(brick, symbolic.P())
            matrix = sparse.csc_matrix(matrix[order][:, order])
            symbolic = analyze(matrix, mode="supernodal", ordering_method="natural")
        factor = symbolic.cholesky(matrix)
    with report.timed("Delassus"):
        if way == "backsolve":
            return delassus_by_backsolves(brick, factor), factor.solve_A
        delassus = delassus_by_schur(brick, factor, order)

    def solve(right_hand_side: np.ndarray) -> np.ndarray:
        solution = np.empty_like(right_hand_side)
        solution[order] = factor.solve_A(right_hand_side[order])
        return solution

    return delassus, solve


def scaled_friction(friction: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    """One mu per node, and the diagonal of D that makes coefficients [n, 2] isotropic."""
    ones = np.ones(len(friction))
    if (friction[:, 0] == friction[:, 1]).all():
        return friction[:, 0].copy(), np.ones(3 * len(friction))
    return ones, np.column_stack([ones, friction]).ravel()


def with_long_indices(matrix: sparse.csc_matrix) -> sparse.csc_matrix:
    """The matrix with 64-bit indices, which Siconos takes without converting."""
    matrix.indices = matrix.indices.astype(np.int64)
    matrix.indptr = matrix.indptr.astype(np.int64)
    return matrix


class SiconosSolver:
    """Settings and counters of a Siconos driver.

    Everything handed to it is scaled to numbers of order one: in SI units ADMM fails.
    """

    def __init__(self, solver: int, tolerance: float) -> None:
        self.solver = solver
        self.tolerance = tolerance
        self.iterations = 0
        self.residual = 0.0

    def drive(self, driver, problem, *unknowns: np.ndarray) -> None:
        """Run a driver, which overwrites the unknowns; they are also its guess."""
        options = sn.SolverOptions(self.solver)
        options.dparam[sn.SICONOS_DPARAM_TOL] = self.tolerance
        options.iparam[sn.SICONOS_IPARAM_MAX_ITER] = MAX_ITERATIONS
        info = driver(problem, *unknowns, options)
        self.iterations += int(options.iparam[sn.SICONOS_IPARAM_ITER_DONE])
        self.residual = float(options.dparam[sn.SICONOS_DPARAM_RESIDU])
        if info != 0:
            raise RuntimeError(f"Siconos: info {info}, residual {self.residual}")


class LocalSolver(SiconosSolver):
    """Coulomb friction on W."""

    def __init__(self, delassus: Delassus, solver: int, tolerance: float) -> None:
        super().__init__(solver, tolerance)
        self.delassus = delassus
        self.unit_length = np.abs(delassus.offset).max()
        self.unit_force = self.unit_length / np.diag(delassus.matrix).mean()
        self.matrix = delassus.matrix * (self.unit_force / self.unit_length)
        self.force = np.zeros(delassus.offset.size)

    def solve(self, friction: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
        """Contact forces in N and displacements in m, from the previous ones."""
        mu, d = scaled_friction(friction)
        offset = self.delassus.offset / self.unit_length * d
        matrix = self.matrix * d[:, None] * d[None, :]
        problem = sn.FrictionContactProblem(3, matrix, offset, mu)
        reaction = self.force / (self.unit_force * d)
        self.drive(sn.fc3d_driver, problem, reaction, np.zeros_like(reaction))
        self.force = reaction * d * self.unit_force
        return self.force, self.delassus.matrix @ self.force + self.delassus.offset


class GlobalSolver(SiconosSolver):
    """Coulomb friction on A itself; keeps the displacement of the whole body."""

    def __init__(self, brick: Brick, solver: int, tolerance: float) -> None:
        super().__init__(solver, tolerance)
        self.dof = brick.contact_dof
        self.unit_length = np.linalg.norm(brick.load, np.inf)
        self.unit_length /= brick.stiffness.diagonal().mean()
        self.unit_force = np.linalg.norm(brick.load, np.inf)
        scale = self.unit_length / self.unit_force
        self.stiffness = with_long_indices(brick.stiffness * scale)
        self.load = brick.load / self.unit_force
        self.force = np.zeros(self.dof.size)
        self.displacement = np.zeros(brick.load.size)

    def solve(self, friction: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
        """Contact forces in N and displacements in m, from the previous ones."""
        mu, d = scaled_friction(friction)
        forces = (d, self.dof, np.arange(d.size + 1))
        shape = (self.load.size, d.size)
        problem = sn.GlobalFrictionContactProblem(3)
        problem.numberOfContacts = mu.size
        problem.M = self.stiffness
        problem.H = with_long_indices(sparse.csc_matrix(forces, shape))
        problem.q, problem.b, problem.mu = self.load, np.zeros(d.size), mu
        reaction = self.force / (self.unit_force * d)
        velocity = self.displacement / self.unit_length
        contact = velocity[self.dof] * d
        self.drive(sn.gfc3d_driver, problem, reaction, contact, velocity)
        self.force = reaction * d * self.unit_force
        self.displacement = velocity * self.unit_length
        return self.force, self.displacement[self.dof]


def solve_scene(solver: LocalSolver | GlobalSolver, scene: str, report: Report) -> None:
    """Successive approximations of F(u) where the law asks for them, else one solve."""
    laws = SCENES[scene]
    is_constant = all(law.is_constant for law in laws)
    slip = np.zeros((solver.force.size // 3, 2))
    steps, change = 0, np.inf
    while change > OUTER_TOLERANCE:
        if steps == MAX_OUTER_STEPS:
            raise RuntimeError(f"no fixed point of F(u) after {steps} steps")
        friction = np.column_stack([coefficient(laws[i], slip[:, i]) for i in (0, 1)])
        previous = solver.force
        force, contact = solver.solve(friction)
        slip = np.abs(contact.reshape(-1, 3)[:, 1:])
        steps += 1
        moved = np.linalg.norm(force - previous) / np.linalg.norm(force)
        change = 0.0 if is_constant else moved
    report.data |= {"outer_steps": steps, "iterations": solver.iterations}
    report.data |= {"residual": solver.residual, "converged": True}


def solve_locally(brick: Brick, arguments, report: Report) -> np.ndarray:
    """Displacement by way of W."""
    delassus, solve = compute_delassus(
        brick, arguments.delassus, arguments.ordering, report
    )
    with report.timed("friction"):
        solver = LocalSolver(
            delassus, LOCAL_SOLVERS[arguments.method], arguments.tolerance
        )
        solve_scene(solver, arguments.scene, report)
    with report.timed("displacement"):
        right_hand_side = brick.load.copy()
        right_hand_side[brick.contact_dof] += solver.force
        return solve(right_hand_side)


def solve_globally(brick: Brick, arguments, report: Report) -> np.ndarray:
    """Displacement straight from Siconos."""
    with report.timed("friction"):
        solver = GlobalSolver(
            brick, GLOBAL_SOLVERS[arguments.method], arguments.tolerance
        )
        solve_scene(solver, arguments.scene, report)
    return solver.displacement


def main(arguments) -> None:
    """Solve one scene and report."""
    brick = Brick.read(arguments.run_file)
    report = Report.begin(f"Siconos {arguments.method}", arguments.scene, brick)
    is_global = arguments.method in GLOBAL_SOLVERS
    way = solve_globally if is_global else solve_locally
    report.finish(way(brick, arguments, report), arguments.json)


if __name__ == "__main__":
    parser = peer_arguments(__doc__.splitlines()[0])
    parser.add_argument(
        "--method", choices=(*LOCAL_SOLVERS, *GLOBAL_SOLVERS), default="newton"
    )
    parser.add_argument("--delassus", choices=("schur", "backsolve"), default="schur")
    parser.add_argument(
        "--ordering", choices=("metis", "nesdis", "amd"), default="nesdis"
    )
    parser.add_argument("--tolerance", type=float, default=1e-10)
    main(parser.parse_args())
