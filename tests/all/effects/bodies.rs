//! Bodies, materials and loads that are described in two ways.

use std::{collections::BTreeMap, fmt::Write, fs};

use contact3d::{scene::Scene, solver::Status};

use super::{
    scenes::{BODY, CONTACT, LOAD, RAMPS, STEEL, distance, steel},
    support::{Case, pipelines},
};

/// Residuals below 1e-12 ‖λ‖ and backsolves with condition numbers near 1e4 on either side.
const SAME: f64 = 1e-10;

fn assert_same(found: &Case, expected: &Case) {
    let [f, e] = [found, expected].map(|case| case.displacement().concat());
    let difference = distance(&f, &e);
    assert!(difference < SAME, "{difference:e}");
}

/// A rigid motion of the box (0, 3) × (0, 1) × (0, 1) onto another place in the first octant.
struct Motion {
    /// The scene of the moved problem.
    scene: &'static str,
    /// Where a point goes.
    place: fn([f64; 3]) -> [f64; 3],
    /// Where a direction goes.
    direction: fn([f64; 3]) -> [f64; 3],
}

/// A cyclic change of the axes: x to y, y to z, z to x.
const CYCLE: Motion = Motion {
    scene: "
title = 'cycled'
body.brick = { size = [1.0, 3.0, 1.0], cells = [4, 12, 4] }
clamp = [{ face = 'y_min' }]
traction = [
    { face = 'y_max', value = [2e7, 1e7, 4e6] },
    { face = 'x_max', value = [-3e7, 0.0, 0.0] },
]
contact = { face = 'x_min' }
",
    place: |[x, y, z]| [z, x, y],
    direction: |[x, y, z]| [z, x, y],
};

/// Half a turn about the x axis: the contact face comes to lie above.
const HALF_TURN: Motion = Motion {
    scene: "
title = 'upside down'
body.brick = { size = [3.0, 1.0, 1.0], cells = [12, 4, 4] }
clamp = [{ face = 'x_min' }]
traction = [
    { face = 'x_max', value = [1e7, -4e6, -2e7] },
    { face = 'z_min', value = [0.0, 0.0, 3e7] },
]
contact = { face = 'z_max' }
",
    place: |[x, y, z]| [x, 1.0 - y, 1.0 - z],
    direction: |[x, y, z]| [x, -y, -z],
};

/// Half a turn about the z axis after the cycle: contact on x_max.
const BOTH: Motion = Motion {
    scene: "
title = 'against a wall'
body.brick = { size = [1.0, 3.0, 1.0], cells = [4, 12, 4] }
clamp = [{ face = 'y_max' }]
traction = [
    { face = 'y_min', value = [-2e7, -1e7, 4e6] },
    { face = 'x_min', value = [3e7, 0.0, 0.0] },
]
contact = { face = 'x_max', axis_1 = [0.0, -1.0, 0.0] }
",
    place: |[x, y, z]| [1.0 - z, 3.0 - x, y],
    direction: |[x, y, z]| [-z, -x, y],
};

/// A name of a lattice point that rounding does not change.
fn lattice(x: [f64; 3]) -> [i64; 3] {
    x.map(|c| (c * 1e6).round() as i64)
}

#[test]
fn the_answer_does_not_depend_on_where_the_body_stands() {
    let still = steel(&[CONTACT, RAMPS]);
    let displacement = still.displacement();
    for motion in [CYCLE, HALF_TURN, BOTH] {
        let moved = Case::of(&[motion.scene, STEEL, RAMPS].concat());
        assert_eq!(moved.solution.status, Status::Converged);
        let places = moved.mesh().coordinates.iter().zip(moved.displacement());
        let found: BTreeMap<_, _> = places.map(|(x, u)| (lattice(*x), u)).collect();
        let pairs: Vec<_> = still
            .mesh()
            .coordinates
            .iter()
            .zip(&displacement)
            .map(|(x, u)| (found[&lattice((motion.place)(*x))], (motion.direction)(*u)))
            .collect();
        let (found, expected): (Vec<_>, Vec<_>) = pairs.into_iter().unzip();
        let difference = distance(&found.concat(), &expected.concat());
        assert!(difference < SAME, "{}: {difference:e}", moved.scene().title);
        // The frames move with the body, so forces along t₁ and t₂ stay.
        let [forces, unmoved] = [&moved, &still].map(|case| {
            let contact = case.report().resultants.contact.unwrap();
            let [first, second] = contact.tangential_force.unwrap();
            [contact.normal_force, first, second]
        });
        assert!(
            distance(&forces, &unmoved) < SAME,
            "{}",
            moved.scene().title
        );
    }
}

/// The text of a mesh as a Gmsh file, format 2.2, with the six faces as physical surfaces.
fn as_gmsh(case: &Case) -> String {
    let mesh = &case.mesh();
    let mut text = "$MeshFormat\n2.2 0 8\n$EndMeshFormat\n$PhysicalNames\n7\n".to_owned();
    for (i, name) in mesh.face_names.iter().enumerate() {
        let _ = writeln!(text, "2 {} \"{name}\"", i + 1);
    }
    let _ = writeln!(
        text,
        "3 7 \"all\"\n$EndPhysicalNames\n$Nodes\n{}",
        mesh.coordinates.len()
    );
    for (i, [x, y, z]) in mesh.coordinates.iter().enumerate() {
        let _ = writeln!(text, "{} {x:?} {y:?} {z:?}", i + 1);
    }
    let elements = mesh.facets.len() + mesh.tetrahedra.len();
    let _ = writeln!(text, "$EndNodes\n$Elements\n{elements}");
    for (i, (facet, face)) in mesh.facets.iter().zip(&mesh.facet_face).enumerate() {
        let [a, b, c] = facet.map(|n| n + 1);
        let _ = writeln!(text, "{} 2 2 {} 1 {a} {b} {c}", i + 1, face + 1);
    }
    for (i, tetrahedron) in mesh.tetrahedra.iter().enumerate() {
        let [a, b, c, d] = tetrahedron.map(|n| n + 1);
        let _ = writeln!(
            text,
            "{} 4 2 7 1 {a} {b} {c} {d}",
            mesh.facets.len() + i + 1
        );
    }
    text + "$EndElements\n"
}

#[test]
fn a_brick_from_a_gmsh_file_is_that_brick() {
    let nodal = [CONTACT, "multipliers = 'nodal'", RAMPS];
    let brick = steel(&nodal);
    let folder = tempfile::tempdir().unwrap();
    fs::write(folder.path().join("brick.msh"), as_gmsh(&brick)).unwrap();
    let body = "title = 'test'\nclamp = [{ face = 'x_min' }]\nbody.gmsh.file = 'brick.msh'\n";
    let text = [&[body, STEEL, LOAD], &nodal[..]].concat().concat();
    let scene = Scene::parse("test", &text).unwrap();
    let gmsh = Case::try_new(scene, folder.path()).unwrap();
    assert_same(&gmsh, &brick);
}

#[test]
fn millimetres_are_metres() {
    let text = fs::read_to_string(pipelines().join("millimetres.toml")).unwrap();
    let millimetres = Case::of(&text);
    let metres = fs::read_to_string(pipelines().join("newton.toml")).unwrap();
    let metres = Case::of(&metres.replace("[48, 16, 16]", "[24, 8, 8]"));
    let [mm, m] = [&millimetres.solution, &metres.solution];
    assert_eq!(mm.trace.newton.len(), m.trace.newton.len());
    // The last relaxation at rounding may take one more or less.
    assert!(mm.trace.applications.abs_diff(m.trace.applications) <= 1);
    let pascals: Vec<f64> = mm.multiplier.iter().map(|l| 1e6 * l).collect();
    let difference = distance(&pascals, &m.multiplier);
    assert!(difference < SAME, "{difference:e}");
}

/// Steel as an orthotropic material in turned axes, and as a full matrix.
#[test]
fn isotropy_is_a_case_of_anisotropy() {
    let (young, poisson) = (21.19e10, 0.277);
    let shear = young / (2.0 * (1.0 + poisson));
    let orthotropic = format!(
        "[material.orthotropic]\nyoung_moduli = [{young:?}, {young:?}, {young:?}]\n\
         poisson_ratios = [{poisson}, {poisson}, {poisson}]\n\
         shear_moduli = [{shear:?}, {shear:?}, {shear:?}]\naxes = [[1, 2, 0.5], [-2, 1, 0]]\n"
    );
    let lambda = 2.0 * shear * poisson / (1.0 - 2.0 * poisson);
    let rows: Vec<Vec<f64>> = (0..6)
        .map(|i| {
            let entry = |j: usize| match (i < 3, j < 3, i == j) {
                (true, true, true) => lambda + 2.0 * shear,
                (true, true, false) => lambda,
                (false, false, true) => shear,
                _ => 0.0,
            };
            (0..6).map(entry).collect()
        })
        .collect();
    let voigt = format!("[material.voigt]\nstiffness = {rows:?}\n");
    let isotropic = steel(&[CONTACT, RAMPS]);
    for material in [orthotropic, voigt] {
        assert_same(
            &Case::of(&[BODY, &material, LOAD, CONTACT, RAMPS].concat()),
            &isotropic,
        );
    }
}

#[test]
fn equal_regions_are_one_body() {
    let region = "[[region]]\npart.box = [[0, 0, 0], [1.3, 0.5, 2]]\n\
                  material.isotropic = { young_modulus = 21.19e10, poisson_ratio = 0.277 }\n";
    let parts = steel(&[CONTACT, RAMPS, region]);
    let whole = steel(&[CONTACT, RAMPS]);
    assert!(parts.mesh().tetrahedron_region.contains(&1));
    assert_eq!(parts.solution.multiplier, whole.solution.multiplier);
    assert_eq!(parts.solution.displacement, whole.solution.displacement);
}

#[test]
fn a_pressure_is_a_traction_along_the_normal() {
    let traction = "[[traction]]\nface = 'z_max'\nvalue = [0, 0, -3e7]\n\
                    [[traction]]\nface = 'x_max'\nvalue = ['-1e7*z', 0, 0]\n";
    let pressure = "[[pressure]]\nface = 'z_max'\nvalue = 3e7\n\
                    [[pressure]]\nface = 'x_max'\nvalue = '1e7*z'\n";
    let [traction, pressure] =
        [traction, pressure].map(|load| Case::of(&[BODY, STEEL, load, CONTACT, RAMPS].concat()));
    assert_same(&pressure, &traction);
}

#[test]
fn weight_is_density_times_gravity_times_volume() {
    let weight = 7850.0 * 9.81;
    let force = format!("[body_force]\nvalue = [0, 0, {:?}]\n", -weight);
    let law = "[friction]\ncoefficient.constant = 0.3\n";
    for contact in ["", &[CONTACT, law].concat()] {
        let report = Case::of(&[BODY, STEEL, &force, contact].concat()).report();
        let r = &report.resultants;
        // 720 tetrahedra summed: some hundred roundings.
        assert!(distance(&r.applied_force, &[0.0, 0.0, -3.0 * weight]) < 1e-13);
        // Through the centre (1.5, 0.5, 0.5): x × f = (y f, −x f, 0).
        assert!(distance(&r.moments[1], &[-1.5 * weight, 4.5 * weight, 0.0]) < 1e-13);
        // What carries it: backsolves with condition number near 1e4.
        let carried = match r.contact {
            Some(contact) => contact.contact_force[2] + r.clamp_force[2],
            None => r.clamp_force[2],
        };
        assert!((carried / (3.0 * weight) - 1.0).abs() < 1e-10);
    }
}
