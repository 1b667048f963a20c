"""GetFEM on the HKL brick: Alart-Curnier augmented Lagrangian as a weak form, Newton with MUMPS.

Contact lives at the nodes: the Newton-Cotes rule of order 1 puts the quadrature points of every
triangle at its vertices. Unknowns are u and the multiplier (p, s1, s2): pressure p, and the
tangential stress scaled by friction, F s. With the slip v = F u_t the law is isotropic,
    p = (p - r u_z)+,   s = projection of s - r v on the disc of radius (p - r u_z)+,
so one weak form serves all scenes; GetFEM differentiates it, F(u) included.

Everything is in units of 1e7 Pa and 1e-4 m: in SI units Newton's stopping test, scaled by forces,
accepts an answer without friction.
"""

import getfem as gf
import numpy as np

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
    mesh = gf.Mesh("ptND", brick.coordinates.T, brick.tetrahedra.T.astype(np.int32))
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


def build_model(brick: Brick, mesh: gf.Mesh, scene: str, augmentation: float):
    """The model and the finite element space of u."""
    space = gf.MeshFem(mesh, 3)
    space.set_fem(gf.Fem("FEM_PK(3,1)"))
    contact = set(space.basic_dof_on_region(Z_MIN))
    clamped = set(space.basic_dof_on_region(X_MIN))
    # At clamped nodes the multiplier would be undetermined.
    multiplier = gf.MeshFem("partial", space, np.array(sorted(contact - clamped)))
    exact = gf.MeshIm(mesh, gf.Integ("IM_TETRAHEDRON(2)"))
    nodal = gf.MeshIm(mesh, gf.Integ("IM_NC(3,1)"))

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
    return model, space


def free_displacement(brick: Brick, model: gf.Model, space: gf.MeshFem) -> np.ndarray:
    """u in m over the run file's degrees of freedom; nodes are matched by their places."""
    steps = 2 * 3 * brick.n_div
    key = steps ** np.arange(3)
    places = np.rint(space.basic_dof_nodes()[:, ::3].T * brick.n_div).astype(int) @ key
    nodes = np.rint(brick.coordinates * brick.n_div).astype(int) @ key
    by_place = np.argsort(places)
    row = by_place[np.searchsorted(places[by_place], nodes)]
    nodal = model.variable("u").reshape(-1, 3)[row] * UNIT_LENGTH
    free = np.empty(brick.load.size)
    free[brick.dof[brick.dof >= 0]] = nodal[brick.dof >= 0]
    return free


def main(arguments) -> None:
    """Solve one scene and report."""
    gf.util_trace_level(0)
    gf.util_warning_level(0)
    brick = Brick.read(arguments.run_file)
    report = Report.begin("GetFEM", arguments.scene, brick)
    with report.timed("assembly"):
        mesh = build_mesh(brick)
        model, space = build_model(brick, mesh, arguments.scene, arguments.augmentation)
        model.assembly()
    with report.timed("Newton"):
        words = ["max_res", arguments.tolerance, "max_iter", arguments.max_iterations]
        words += ["lsolver", "mumps", "lsearch", arguments.line_search]
        if arguments.noisy:
            words.append("noisy")
        iterations, converged = model.solve(*words)
    report.data |= {"iterations": int(iterations), "converged": bool(converged)}
    report.finish(free_displacement(brick, model, space), arguments.json)


if __name__ == "__main__":
    parser = peer_arguments(__doc__.splitlines()[0])
    parser.add_argument("--augmentation", type=float, default=10.0, help="r over E / m")
    parser.add_argument("--tolerance", type=float, default=1e-10)
    parser.add_argument("--max-iterations", type=int, default=100)
    parser.add_argument("--line-search", default="default")
    parser.add_argument("--noisy", action="store_true")
    main(parser.parse_args())
