"""GetFEM on the two bodies of a run file, frictionless: its integral contact between meshes that do not match.

    contact3d-pipe run benches/peers/pair.toml pair.h5 --no-figures
    python benches/peers/getfem_pair.py pair.h5

The scene has linear tetrahedra, one material, clamps, pressures and one pair of faces. GetFEM takes its integration points on the face
with the multipliers, which are continuous and linear there, and projects them on the other face; the program clips the triangles of both
faces and has one multiplier a pane. Printed are the strain energy and the range of pressures.
"""

import argparse
import tomllib

import getfem as gf
import h5py
import numpy as np

SIDES = ("x_min", "x_max", "y_min", "y_max", "z_min", "z_max")


class Body:
    """A body of a run file as a mesh of GetFEM, whose faces are regions."""

    def __init__(self, file: h5py.File, number: int, name: str) -> None:
        nodes, tetrahedra = (file[f"mesh/body_{what}"][number : number + 2] for what in ("nodes", "tetrahedra"))
        points = file["mesh/coordinates"][slice(*nodes)]
        self.mesh = gf.Mesh("ptND", points.T, (file["mesh/tetrahedra"][slice(*tetrahedra)] - nodes[0]).T.astype(np.int32))
        outer = self.mesh.outer_faces()
        normals = self.mesh.normal_of_faces(outer)
        for side in SIDES:
            axis, sign = "xyz".index(side[0]), 1 if side.endswith("max") else -1
            self.mesh.set_region(1 + SIDES.index(side), outer[:, sign * normals[axis] > 0.99])
        self.name, self.space = name, gf.MeshFem(self.mesh, 3)
        self.space.set_fem(gf.Fem("FEM_PK(3,1)"))
        self.exact = gf.MeshIm(self.mesh, gf.Integ("IM_TETRAHEDRON(2)"))

    def energy(self, displacement: np.ndarray, young: float, nu: float) -> float:
        """The strain energy."""
        corners = self.space.basic_dof_from_cvid()[0].reshape(-1, 4, 3)
        places = self.space.basic_dof_nodes().T[corners[:, :, 0]]
        edges = places[:, 1:] - places[:, :1]
        slopes = displacement[corners[:, 1:]] - displacement[corners[:, :1]]
        gradient = np.linalg.solve(edges, slopes)
        strain = (gradient + gradient.transpose(0, 2, 1)) / 2
        trace = np.trace(strain, axis1=1, axis2=2)
        density = young / (1 + nu) * ((strain**2).sum(axis=(1, 2)) + nu / (1 - 2 * nu) * trace**2)
        return float((density * np.abs(np.linalg.det(edges))).sum() / 12)


def region(face: str) -> int:
    return 1 + SIDES.index(face.split(".")[1])


def solve(scene: dict, bodies: dict[str, Body], side: str, order: int) -> tuple[float, np.ndarray]:
    """Energy and pressures at the nodes of the face with multipliers."""
    law = scene["material"]["isotropic"]
    young, nu = law["young_modulus"], law["poisson_ratio"]
    model = gf.Model("real")
    for name, value in (("lame_lambda", young * nu / ((1 + nu) * (1 - 2 * nu))), ("lame_mu", young / (2 * (1 + nu))), ("r", young)):
        model.add_initialized_data(name, value)
    for name, body in bodies.items():
        model.add_fem_variable(f"u_{name}", body.space)
        model.add_isotropic_linearized_elasticity_brick(body.exact, f"u_{name}", "lame_lambda", "lame_mu")
    for k, clamp in enumerate(scene["clamp"]):
        body = bodies[clamp["face"].split(".")[0]]
        held = np.diag([float(axis in clamp.get("components", ["x", "y", "z"])) for axis in "xyz"])
        model.add_initialized_data(f"moved_{k}", np.array(clamp.get("value", [0.0, 0.0, 0.0])) @ held)
        model.add_initialized_data(f"held_{k}", held)
        model.add_generalized_Dirichlet_condition_with_penalization(
            body.exact, f"u_{body.name}", 1e9 * young, region(clamp["face"]), f"moved_{k}", f"held_{k}"
        )
    for k, load in enumerate(scene.get("pressure", [])):
        body = bodies[load["face"].split(".")[0]]
        axis, end = load["face"].split(".")[1].split("_")
        inwards = -1.0 if end == "max" else 1.0
        model.add_initialized_data(f"pressure_{k}", inwards * load["value"] * np.eye(3)["xyz".index(axis)])
        model.add_source_term_brick(body.exact, f"u_{body.name}", f"pressure_{k}", region(load["face"]))
    pair = scene["contact"]["between"] if isinstance(scene["contact"], dict) else scene["contact"][0]["between"]
    other = next(face for face in pair if face != side)
    own, opposite = (bodies[face.split(".")[0]] for face in (side, other))
    scalar = gf.MeshFem(own.mesh, 1)
    scalar.set_fem(gf.Fem("FEM_PK(3,1)"))
    multiplier = gf.MeshFem("partial", scalar, scalar.basic_dof_on_region(region(side)))
    model.add_fem_variable("multiplier", multiplier)
    points = gf.MeshIm(own.mesh, gf.Integ(f"IM_TETRAHEDRON({order})"))
    model.add_integral_contact_between_nonmatching_meshes_brick(
        points, f"u_{own.name}", f"u_{opposite.name}", "multiplier", "r", region(side), region(other)
    )
    _, converged = model.solve("max_res", 1e-9, "max_iter", 60, "lsolver", "mumps")
    assert converged, "GetFEM's Newton method stopped"
    pressure = -model.variable("multiplier")
    return sum(body.energy(model.variable(f"u_{name}"), young, nu) for name, body in bodies.items()), pressure


def main() -> None:
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("run_file")
    parser.add_argument("--order", type=int, nargs="+", default=[2, 3, 6], help="exactness of the integration rule")
    arguments = parser.parse_args()
    gf.util_trace_level(0)
    gf.util_warning_level(0)
    with h5py.File(arguments.run_file) as file:
        scene = tomllib.loads(file["scene/toml"][()].decode())
        names = file["mesh/body_names"][()].decode().splitlines()
        bodies = {name: Body(file, number, name) for number, name in enumerate(names)}
        facet = file["mesh/contact_facets"][0]
        side = file["mesh/face_names"][()].decode().splitlines()[file["mesh/facet_face"][facet]]
        ours, pressure = file["post/resultants/strain_energy"][()], file["solve/multiplier_normal"][:]
    print(f"program    energy {ours:.9e}, pressures {pressure.min():.9e} to {pressure.max():.9e}")
    for order in arguments.order:
        energy, pressure = solve(scene, bodies, side, order)
        off = energy / ours - 1
        print(f"order {order}    energy {energy:.9e}, {off:+.1e}, pressures {pressure.min():.9e} to {pressure.max():.9e}")


if __name__ == "__main__":
    main()
