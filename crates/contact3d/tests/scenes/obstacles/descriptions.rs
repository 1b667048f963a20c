//! One obstacle in several descriptions.

use contact3d::{
    mesh::{ContactSurface, Mesh},
    scene::Scene,
};

use super::{
    moved::MATERIAL,
    solved::{Solved, distance},
};

fn scene(face: &str, element: &str, contact: &str) -> String {
    let held = if face == "x_max" { "x_min" } else { "x_max" };
    format!(
        "title = 'descriptions'\n[body]\nelement = '{element}'\n[body.brick]\nsize = [1.0, 0.8, 0.6]\ncells = [4, 4, 4]\n\
         {MATERIAL}[[clamp]]\nface = '{held}'\n[body_force]\nvalue = [0.01, 0.02, -0.03]\n[contact]\nface = '{face}'\n{contact}"
    )
}

fn surface(text: &str) -> ContactSurface {
    let scene = Scene::parse("test", text).unwrap_or_else(|e| panic!("{e}\n{text}"));
    let mesh = Mesh::of_scene(&scene, std::path::Path::new("")).unwrap_or_else(|e| panic!("{e}"));
    mesh.contact.expect("contact")
}

/// A face, an obstacle near it, and its height.
const HEIGHTS: [[&str; 3]; 7] = [
    [
        "z_min",
        "sphere = { centre = [0.4, 0.3, -2.0], radius = 1.95 }",
        "height.value = 'sqrt(1.95^2 - (x - 0.4)^2 - (y - 0.3)^2) - 2'",
    ],
    [
        "z_max",
        "sphere = { centre = [0.4, 0.3, 2.7], radius = 2.1 }",
        "height = { value = '2.7 - sqrt(2.1^2 - (x - 0.4)^2 - (y - 0.3)^2)', direction = '-z' }",
    ],
    [
        "y_max",
        "cylinder = { point = [0.5, 2.3, 7.0], direction = [0.0, 0.0, -3.0], radius = 1.5 }",
        "height = { value = '2.3 - sqrt(1.5^2 - (x - 0.5)^2)', direction = '-y' }",
    ],
    [
        "y_min",
        "cylinder = { point = [0.5, -1.3, 7.0], direction = [0.0, 0.0, -3.0], radius = 1.3 }",
        "height = { value = 'sqrt(1.3^2 - (x - 0.5)^2) - 1.3', direction = 'y' }",
    ],
    [
        "x_max",
        "half_space = { point = [1.2, 0.0, 0.0], normal = [-1.0, 0.1, -0.2] }",
        "height = { value = '1.2 + 0.1*y - 0.2*z', direction = '-x' }",
    ],
    [
        "x_min",
        "half_space = { point = [-0.3, 0.0, 0.0], normal = [1.0, 0.1, -0.2] }",
        "height = { value = '-0.3 - 0.1*y + 0.2*z', direction = 'x' }",
    ],
    [
        "z_min",
        "half_space = { point = [0.0, 0.0, -0.1], normal = [0.0, 0.0, 1.0] }",
        "height.value = -0.1",
    ],
];

#[test]
fn heights_are_the_obstacles_that_they_describe() {
    for element in ["P1", "P2"] {
        for [face, obstacle, height] in HEIGHTS {
            let [plain, by_height] = [obstacle, height]
                .map(|o| surface(&scene(face, element, &format!("obstacle.{o}\n"))));
            assert_eq!(plain.clearance.len(), plain.nodes.len());
            for node in 0..plain.nodes.len() {
                // The nearest point is found to 1e-12 of the face; its slope moves as far.
                let off = plain.clearance[node] - by_height.clearance[node];
                assert!(off.abs() < 1e-11, "{face} {height}: {off:e}");
                let [n, m] = [&plain, &by_height].map(|s| s.normal_at(node));
                assert!(
                    (0..3).all(|c| (n[c] - m[c]).abs() < 1e-11),
                    "{height} {n:?} {m:?}"
                );
            }
        }
    }
}

#[test]
fn answers_do_not_depend_on_the_description() {
    let friction = "[friction]\ncoefficient.constant = 0.3\n";
    let [_, sphere, height] = HEIGHTS[0];
    let near = |o: &str| o.replace("-2.0]", "-1.95]").replace("- 2'", "- 1.95'");
    for multipliers in ["panes", "nodal"] {
        let [a, b] = [near(sphere), near(height)].map(|obstacle| {
            let contact = format!("multipliers = '{multipliers}'\nobstacle.{obstacle}\n{friction}");
            Solved::new(&scene("z_min", "P2", &contact))
        });
        // Distances that differ by 1e-11 of displacements near 1e-2.
        assert!(distance(&a.multiplier, &b.multiplier) < 1e-7);
        assert!(a.peak() > 0.0);
    }
}

#[test]
fn a_half_space_under_a_flat_face_is_the_foundation() {
    let half_space =
        "obstacle.half_space = { point = [5.0, 1.0, 0.0], normal = [0.0, 0.0, 2.0] }\n";
    let friction = "[friction]\ncoefficient.constant = 0.3\n";
    for multipliers in [
        "multipliers = 'panes'",
        "multipliers = 'nodal'\ngap = '1e-3*x'",
    ] {
        let [with, without] = [half_space, ""].map(|obstacle| {
            Solved::new(&scene(
                "z_min",
                "P1",
                &format!("{multipliers}\n{obstacle}{friction}"),
            ))
        });
        // A distance of 0 and no distance are the same numbers.
        assert_eq!(with.multiplier, without.multiplier);
        assert_eq!(without.surface().clearance, Vec::<f64>::new());
    }
}

#[test]
fn the_gap_of_the_scene_adds_to_the_distance() {
    let sphere = "obstacle.sphere = { centre = [0.4, 0.3, -2.0], radius = 2.0 }\n";
    let lifted = Solved::new(&scene(
        "z_min",
        "P1",
        &format!("gap = '1e-3 + 1e-3*x'\n{sphere}"),
    ));
    let interface = lifted.problem.contact_side().expect("contact").interface;
    let gap = interface.gap.as_ref().expect("a gap");
    let (mesh, surface) = (lifted.problem.mesh(), lifted.surface());
    for (node, gap) in gap.iter().enumerate() {
        let x = mesh.coordinates[surface.nodes[node]];
        let distance = ((x[0] - 0.4).powi(2) + (x[1] - 0.3).powi(2) + 4.0).sqrt() - 2.0;
        // Roundings of numbers near 2.
        assert!((gap - distance - 1e-3 - 1e-3 * x[0]).abs() < 1e-15);
    }
}

/// Panes do not reach over the border between two parts of a face, so both are the whole face.
#[test]
fn two_parts_of_a_face_meet_one_obstacle() {
    let sphere = "obstacle.sphere = { centre = [0.4, 0.3, -2.0], radius = 2.0 }\n";
    let friction = "[friction]\ncoefficient.constant = 0.3\n";
    let whole = Solved::new(&scene("z_min", "P1", &format!("{sphere}{friction}")));
    let part = |name: &str, low: f64, high: f64| {
        format!("name = '{name}'\nbox = [[{low:?}, 0.0, 0.0], [{high:?}, 0.8, 0.0]]\n{sphere}")
    };
    let first = scene("z_min", "P1", &part("left", 0.0, 0.5)).replace("[contact]", "[[contact]]");
    let second = format!("[[contact]]\nface = 'z_min'\n{}", part("right", 0.5, 1.0));
    let parts = Solved::new(&format!("{first}{second}{friction}"));
    assert_eq!(parts.surface().faces.len(), 2);
    assert_eq!(parts.surface().clearance.len(), parts.surface().nodes.len());
    // Both are solved to 1e-12.
    assert!(distance(&parts.force(), &whole.force()) < 1e-9);
    assert!((parts.peak() / whole.peak() - 1.0).abs() < 1e-9);
}

#[test]
fn heights_may_use_parameters() {
    let text = scene(
        "z_min",
        "P1",
        "obstacle.height.value = '-depth'\n[parameters]\ndepth = 0.25\n",
    );
    assert!(surface(&text).clearance.iter().all(|d| *d == 0.25));
}
