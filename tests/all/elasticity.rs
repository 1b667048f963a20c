//! P1 elasticity against closed forms: patch test, rigid motions, uniaxial tension.

use contact3d::{
    elasticity::{DofMap, InternalForces, Loads, MaterialField, stiffness},
    mesh::{Mesh, RawMesh, brick},
    scene::{Brick, BrickFace, FaceLoad, Isotropic, Material, Traction},
};
use nalgebra::Vector3;

const MATERIAL: Material = Material::Isotropic(Isotropic {
    young_modulus: 2.0e11,
    poisson_ratio: 0.3,
});

fn material() -> MaterialField<'static> {
    MaterialField::uniform(MATERIAL.elasticity().unwrap())
}

fn body() -> Mesh {
    body_of([4, 2, 3])
}

fn body_of(cells: [usize; 3]) -> Mesh {
    let raw: RawMesh = brick(&Brick::new([3.0, 1.0, 2.0], cells), Some(BrickFace::ZMin));
    Mesh {
        glued: Vec::new(),
        coordinates: raw.coordinates,
        tetrahedra: raw.tetrahedra,
        facets: raw.facets,
        facet_face: raw.facet_face,
        face_names: raw.face_names,
        ..Mesh::default()
    }
}

fn nothing_held(mesh: &Mesh) -> DofMap {
    DofMap::new(&vec![[false; 3]; mesh.coordinates.len()])
}

#[test]
fn stiffness_is_symmetric_to_the_last_bit_at_any_thread_count() {
    // More nodes than one thread takes at a time.
    let mesh = body_of([24, 8, 8]);
    let dofs = nothing_held(&mesh);
    let one = rayon::ThreadPoolBuilder::new()
        .num_threads(1)
        .build()
        .unwrap();
    let four = rayon::ThreadPoolBuilder::new()
        .num_threads(4)
        .build()
        .unwrap();
    let a = one.install(|| stiffness(&mesh, &material(), &dofs));
    let b = four.install(|| stiffness(&mesh, &material(), &dofs));
    assert_eq!(a, b);
    assert_eq!(a, a.transpose());
}

#[test]
fn rigid_motions_need_no_force() {
    let mesh = body();
    let dofs = nothing_held(&mesh);
    let a = stiffness(&mesh, &material(), &dofs);
    let largest = a.data.iter().fold(0.0_f64, |m, v| m.max(v.abs()));
    for mode in 0..6 {
        let motion: Vec<[f64; 3]> = mesh
            .coordinates
            .iter()
            .map(|x| {
                let mut unit = Vector3::zeros();
                unit[mode % 3] = 1.0;
                let v = if mode < 3 {
                    unit
                } else {
                    unit.cross(&Vector3::from(*x))
                };
                v.into()
            })
            .collect();
        let mut force = vec![0.0; dofs.n_free];
        a.mul(&dofs.to_free(&motion), &mut force);
        // Cancellation of about 60 entries per row on displacements of size 3.
        assert!(
            force.iter().all(|f| f.abs() < 1e-13 * largest),
            "mode {mode}"
        );
    }
}

#[test]
fn patch_test_linear_displacement_gives_constant_stress() {
    let mesh = body();
    let gradient = nalgebra::Matrix3::new(1e-4, 2e-5, -3e-5, 0.0, -2e-4, 1e-5, 4e-5, 0.0, 3e-4);
    let u: Vec<[f64; 3]> = mesh
        .coordinates
        .iter()
        .map(|x| (gradient * Vector3::from(*x)).into())
        .collect();
    let elasticity = MATERIAL.elasticity().unwrap();
    let strain = nalgebra::Vector6::new(
        gradient[(0, 0)],
        gradient[(1, 1)],
        gradient[(2, 2)],
        gradient[(1, 2)] + gradient[(2, 1)],
        gradient[(0, 2)] + gradient[(2, 0)],
        gradient[(0, 1)] + gradient[(1, 0)],
    );
    let exact: [f64; 6] = (elasticity * strain).into();
    let InternalForces { forces, stress, .. } = InternalForces::of(&mesh, &material(), &u);
    for stress in &stress {
        for (found, expected) in stress.iter().zip(exact) {
            // Rounding of gradients of size 1/h on displacements of size 1e-3, times the modulus.
            assert!((found - expected).abs() < 1e-12 * 2e11 * 1e-3);
        }
    }
    let on_boundary: std::collections::HashSet<usize> =
        mesh.facets.iter().flatten().copied().collect();
    let largest = forces.iter().flatten().fold(0.0_f64, |m, f| m.max(f.abs()));
    for (node, force) in forces
        .iter()
        .enumerate()
        .filter(|(n, _)| !on_boundary.contains(n))
    {
        // A constant stress is in equilibrium inside.
        assert!(
            force.iter().all(|f| f.abs() < 1e-12 * largest),
            "node {node}"
        );
    }
}

#[test]
fn uniaxial_tension_on_symmetry_planes() {
    let mesh = body();
    let mut held = vec![[false; 3]; mesh.coordinates.len()];
    for (component, face) in ["x_min", "y_min", "z_min"].into_iter().enumerate() {
        for facet in mesh.facets_on(face) {
            for node in mesh.facets[facet] {
                held[node][component] = true;
            }
        }
    }
    let dofs = DofMap::new(&held);
    let a = stiffness(&mesh, &material(), &dofs);
    let pull = Traction::on("x_max", [1e8, 0.0, 0.0]);
    let loads = Loads::from(FaceLoad::Traction(0, &pull));
    let mut u = dofs.to_free(&loads.nodal_forces(&mesh).unwrap());
    let order = contact3d::linalg::amd(&a).unwrap();
    let factor = contact3d::linalg::CholeskyFactor::<f64>::factorise(&a, order).unwrap();
    factor.solve_in_place(&mut u);
    let strain = 1e8 / 2.0e11;
    for (x, found) in mesh.coordinates.iter().zip(dofs.to_nodes(&u)) {
        let exact = [strain * x[0], -0.3 * strain * x[1], -0.3 * strain * x[2]];
        for (f, e) in found.iter().zip(exact) {
            // A direct solve of a matrix with condition number near 1e3.
            assert!((f - e).abs() < 1e-12 * strain * 3.0);
        }
    }
}
