"""GetFEM on the HKL brick: Alart-Curnier augmented Lagrangian as a weak form, Newton with MUMPS.

The element is that of the run file, P1 or P2. Contact lives at the nodes: the Newton-Cotes rule of
the element's order puts the quadrature points of every triangle at its vertices (P1) or at the
middle of its edges (P2, whose vertices have weight zero and no multiplier). Unknowns are u and the
multiplier (p, s1, s2): pressure p, and the tangential stress scaled by friction, F s. With the slip
v = F u_t the law is isotropic,
    p = (p - r u_z)+,   s = projection of s - r v on the disc of radius (p - r u_z)+,
so one weak form serves all scenes; GetFEM differentiates it, F(u) included.

Everything is in units of 1e7 Pa and 1e-4 m: in SI units Newton's stopping test, scaled by forces,
accepts an answer without friction.
"""

import getfem as gf
import numpy as np
from scipy.spatial import cKDTree

from hkl_brick import Brick, Report, peer_arguments
from scenes import SCENES, Ramp

UNIT_STRESS = 1e7  # Pa
UNIT_LENGTH = 1e-4  # m, for displacements; coordinates stay in m
YOUNG_MODULUS = 21.19e10  # Pa
POISSON_RATIO = 0.277
LOADS = {"x_max": (1e7, 0.0, 2e7), "z_max": (0.0, 0.0, -3e7)}  # Pa
X_MIN, X_MAX, Z_MIN, Z_MAX = 1, 2, 3, 4


def build_mesh(brick: Brick) -> gf.Mesh:
    """The run file's mesh with its four faces as regions."""
    corners, cells = np.unique(brick.tetrahedra, return_inverse=True)
    cells = cells.reshape(-1, 4).T.astype(np.int32)
    mesh = gf.Mesh("ptND", brick.coordinates[corners].T, cells)
    outer = mesh.outer_faces()
    normals = mesh.normal_of_faces(outer)
    for region, axis, sign in (
        (X_MIN, 0, -1),
        (X_MAX, 0, 1),
        (Z_MIN, 2, -1),
        (Z_MAX, 2, 1),
    ):
        mesh.set_region(region, outer[:, sign * normals[axis] > 0.99])
    return mesh


def friction_expression(law: Ramp, component: int) -> str:
    """F of one axis in GetFEM's language, slips in the unit of displacement."""
    if law.is_constant:
        return repr(law.initial)
    slip = f"abs(u({component}))"
    onset, rate = law.onset / UNIT_LENGTH, law.rate * UNIT_LENGTH
    fall = f"{rate!r}*pos_part({slip}-{onset!r})"
    return f"({law.residual!r}+pos_part({law.initial - law.residual!r}-{fall}))"


def contact_expression(scene: str) -> str:
    """The weak form of contact and friction on z = 0; forces act on the body along +z."""
    laws = SCENES[scene]
    f1, f2 = (friction_expression(law, i + 1) for i, law in enumerate(laws))
    pressure = "pos_part(multiplier(1)-r*u(3))"
    trial = f"[multiplier(2)-r*{f1}*u(1);multiplier(3)-r*{f2}*u(2)]"
    force = f"[{f1}*multiplier(2);{f2}*multiplier(3);multiplier(1)]"
    tangential = "[multiplier(2);multiplier(3)]"
    test = "[Test_multiplier(2);Test_multiplier(3)]"
    projection = f"Ball_projection({trial},{pressure})"
    if all(law.is_constant and law.initial == 0.0 for law in laws):
        projection = "0*multiplier(2)*[1;1]"  # without friction s would be undetermined
    return (
        f"-{force}.Test_u"
        f"+(1/r)*({pressure}-multiplier(1))*Test_multiplier(1)"
        f"+(1/r)*({projection}-{tangential}).{test}"
    )


def displacement_space(brick: Brick, mesh: gf.Mesh) -> tuple[gf.MeshFem, np.ndarray]:
    """The finite element space of u, and the run file's node of each degree of freedom."""
    space = gf.MeshFem(mesh, 3)
    space.set_fem(gf.Fem("FEM_PK(3,2)" if brick.is_quadratic else "FEM_PK(3,1)"))
    return space, cKDTree(brick.coordinates).query(space.basic_dof_nodes().T)[1]


def build_model(brick: Brick, mesh: gf.Mesh, scene: str, augmentation: float):
    """The model, and the run file's node of each degree of freedom of u."""
    space, nodes = displacement_space(brick, mesh)
    contact = set(space.basic_dof_on_region(Z_MIN))
    clamped = set(space.basic_dof_on_region(X_MIN))
    # At clamped nodes the multiplier would be undetermined, and where the rule has weight zero.
    weightless = np.isin(nodes, brick.tetrahedra) & brick.is_quadratic
    loose = contact - clamped - set(np.flatnonzero(weightless))
    multiplier = gf.MeshFem("partial", space, np.array(sorted(loose)))
    exact = gf.MeshIm(mesh, gf.Integ("IM_TETRAHEDRON(2)"))
    rule = "IM_NC(3,2)" if brick.is_quadratic else "IM_NC(3,1)"
    nodal = gf.MeshIm(mesh, gf.Integ(rule))

    young = YOUNG_MODULUS * UNIT_LENGTH / UNIT_STRESS
    nu = POISSON_RATIO
    model = gf.Model("real")
    model.add_fem_variable("u", space)
    model.add_fem_variable("multiplier", multiplier)
    model.add_initialized_data("lame_lambda", young * nu / ((1 + nu) * (1 - 2 * nu)))
    model.add_initialized_data("lame_mu", young / (2 * (1 + nu)))
    model.add_initialized_data("r", augmentation * young)
    model.add_isotropic_linearized_elasticity_brick(
        exact, "u", "lame_lambda", "lame_mu"
    )
    for face, region in (("x_max", X_MAX), ("z_max", Z_MAX)):
        model.add_initialized_data(face, np.array(LOADS[face]) / UNIT_STRESS)
        model.add_source_term_brick(exact, "u", face, region)
    model.add_Dirichlet_condition_with_simplification("u", X_MIN)
    model.add_nonlinear_term(nodal, contact_expression(scene), Z_MIN)
    return model, nodes


def main(arguments) -> None:
    """Solve one scene and report."""
    gf.util_trace_level(0)
    gf.util_warning_level(0)
    brick = Brick.read(arguments.run_file)
    report = Report.begin("GetFEM", arguments.scene, brick)
    with report.timed("assembly"):
        mesh = build_mesh(brick)
        model, nodes = build_model(brick, mesh, arguments.scene, arguments.augmentation)
        model.assembly()
    with report.timed("Newton"):
        words = ["max_res", arguments.tolerance, "max_iter", arguments.max_iterations]
        words += ["lsolver", "mumps", "lsearch", arguments.line_search]
        if arguments.noisy:
            words.append("noisy")
        iterations, converged = model.solve(*words)
    report.data |= {"iterations": int(iterations), "converged": bool(converged)}
    displacement = np.zeros_like(brick.coordinates)
    displacement[nodes[::3]] = model.variable("u").reshape(-1, 3) * UNIT_LENGTH
    if arguments.displacement:
        np.save(arguments.displacement, displacement)
    free = np.empty(brick.load.size)
    free[brick.dof[brick.dof >= 0]] = displacement[brick.dof >= 0]
    report.finish(free, arguments.json)


if __name__ == "__main__":
    parser = peer_arguments(__doc__.splitlines()[0])
    parser.add_argument("--augmentation", type=float, default=10.0, help="r over E / m")
    parser.add_argument("--tolerance", type=float, default=1e-10)
    parser.add_argument("--max-iterations", type=int, default=100)
    parser.add_argument("--line-search", default="default")
    parser.add_argument("--displacement", help="a file .npy for u in m at all nodes")
    parser.add_argument("--noisy", action="store_true")
    main(parser.parse_args())
