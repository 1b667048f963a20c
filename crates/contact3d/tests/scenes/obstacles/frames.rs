//! Normals and axes that vary over the face.

use nalgebra::Vector3;

use super::solved::Solved;

fn on_sphere(contact: &str, friction: &str) -> Solved {
    Solved::new(&format!(
        "title = 'frames'\n[body.brick]\nsize = [1.0, 1.0, 0.5]\ncells = [8, 8, 4]\n\
         [material.isotropic]\nyoung_modulus = 1.0\npoisson_ratio = 0.3\n\
         [[clamp]]\nface = 'z_max'\n[body_force]\nvalue = [0.02, 0.01, -0.2]\n\
         [contact]\nface = 'z_min'\n{contact}\nobstacle.sphere = {{ centre = [0.5, 0.4, -1.0], radius = 1.0 }}\n{friction}"
    ))
}

const ORTHOTROPIC: &str =
    "[friction]\ncoefficient_1.constant = 0.3\ncoefficient_2.constant = 0.1\n";

#[test]
fn frames_are_orthonormal_and_project_the_axis() {
    for (contact, wanted) in [
        ("", Vector3::x()),
        ("axis_1 = [1.0, 2.0, 0.5]", Vector3::new(1.0, 2.0, 0.5)),
    ] {
        let solved = on_sphere(contact, ORTHOTROPIC);
        let frame = &solved
            .problem
            .contact_side()
            .expect("contact")
            .interface
            .frame;
        let (mesh, surface) = (solved.problem.mesh(), solved.surface());
        for (local, &node) in surface.nodes.iter().enumerate() {
            let x = Vector3::from(mesh.coordinates[node]);
            let normal = (Vector3::new(0.5, 0.4, -1.0) - x).normalize();
            let [first, second] = frame.axes_at(local).map(Vector3::from);
            let found = Vector3::from(frame.normal_at(local));
            let projected = (wanted - normal * wanted.dot(&normal)).normalize();
            // Roundings of unit vectors.
            assert!((found - normal).norm() < 1e-14);
            assert!((first - projected).norm() < 1e-14);
            assert!((second - first.cross(&normal)).norm() < 1e-14);
        }
        // Seen along the mean normal, which leans with the place of the sphere.
        let reference = Vector3::from(frame.references[0].normal);
        assert!((reference.norm() - 1.0).abs() < 1e-14 && reference.z < -0.9);
    }
}

#[test]
fn forces_on_varying_normals_balance() {
    for contact in ["", "multipliers = 'nodal'"] {
        let solved = on_sphere(contact, ORTHOTROPIC);
        let resultants = &solved.report.resultants;
        // Sums of a few hundred forces.
        assert!(resultants.force_imbalance < 1e-10 && resultants.moment_imbalance < 1e-10);
        let contact = resultants.contact.expect("contact");
        let tangential = contact.tangential_force.expect("friction");
        assert!(tangential[0].abs() > 1e-3 * contact.normal_force);
        // Pressures on leaning normals add to less than their sum.
        assert!(contact.contact_force[2] < contact.normal_force * (1.0 + 1e-3));
        let slipping = solved
            .report
            .panes
            .iter()
            .filter_map(|p| p.friction)
            .count();
        assert_eq!(slipping, solved.report.panes.len());
    }
}

/// Isotropic friction does not know its axes.
#[test]
fn isotropic_friction_does_not_follow_the_axes() {
    let isotropic = "[friction]\ncoefficient.constant = 0.2\n";
    let [a, b] = [
        "multipliers = 'nodal'",
        "multipliers = 'nodal'\nangle = 35.0",
    ]
    .map(|contact| on_sphere(contact, isotropic).force());
    let difference = (Vector3::from(a) - Vector3::from(b)).norm();
    // The accuracy that both are solved to.
    assert!(difference < 1e-9 * Vector3::from(b).norm(), "{a:?} {b:?}");
}
