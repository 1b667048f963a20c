//! Obstacles that cannot be met.

use contact3d::{
    mesh::{Mesh, RefinedLevel},
    scene::Scene,
};

use super::moved::{MATERIAL, moved, written};

fn refusal(face: &str, contact: &str) -> String {
    use std::path::Path;
    let text = format!(
        "title = 'refused'\n[body.brick]\nsize = [1.0, 1.0, 1.0]\ncells = [4, 4, 2]\n{MATERIAL}[[clamp]]\nface = 'x_max'\n\
         [contact]\nface = '{face}'\n{contact}\n"
    );
    match super::solved::Solved::in_folder(&text, Path::new("")) {
        Ok(_) => panic!("accepted: {contact}"),
        Err(error) => error,
    }
}

#[test]
fn obstacles_in_the_body_are_refused_with_place_and_depth() {
    let cases = [
        (
            "obstacle.half_space = { point = [0.0, 0.0, 0.001], normal = [0.0, 0.0, 1.0] }",
            [
                "contact.obstacle.half_space",
                "0.001 at x, y, z",
                "normal points out",
            ],
        ),
        (
            "obstacle.half_space = { point = [0.0, 0.0, -0.1], normal = [0.0, 0.0, -1.0] }",
            [
                "contact.obstacle.half_space",
                "0.1 at x, y, z",
                "normal points out",
            ],
        ),
        (
            "obstacle.sphere = { centre = [0.5, 0.5, -0.9], radius = 1.0 }",
            [
                "contact.obstacle.sphere",
                "at x, y, z = 0.5, 0.5, 0.0",
                "side says",
            ],
        ),
        // Between the nodes.
        (
            "obstacle.sphere = { centre = [0.34, 0.4, -0.01], radius = 0.06 }",
            [
                "contact.obstacle.sphere",
                "of the contact face inside it",
                "side says",
            ],
        ),
        (
            "obstacle.height.value = '0.1*x - 0.05'",
            [
                "contact.obstacle.height",
                "at x, y, z = 1.0, 0.0, 0.0",
                "direction points",
            ],
        ),
    ];
    for (contact, words) in cases {
        let message = refusal("z_min", contact);
        for word in words {
            assert!(message.contains(word), "{contact}: {message}");
        }
    }
}

#[test]
fn obstacles_without_a_meaning_are_refused() {
    let cases = [
        (
            "obstacle.sphere = { centre = [0.0, 0.0, -1.0], radius = 0.0 }",
            "contact.obstacle.sphere.radius",
        ),
        (
            "obstacle.sphere = { centre = [0.0, 0.0, 'a'], radius = 1.0 }",
            "contact.obstacle",
        ),
        (
            "obstacle.sphere = { centre = [0.0, 0.0, nan], radius = 1.0 }",
            "contact.obstacle.sphere.centre",
        ),
        (
            "obstacle.half_space = { point = [0.0, 0.0, 0.0], normal = [0.0, 0.0, 0.0] }",
            "contact.obstacle.half_space.normal",
        ),
        (
            "obstacle.cylinder = { point = [0.0, 0.0, -1.0], direction = [0.0, inf, 0.0], radius = 1.0 }",
            "contact.obstacle.cylinder.direction",
        ),
        ("obstacle.height.value = 'z - 1'", "an expression without z"),
        (
            "obstacle.height.value = 'sqrt(x - 0.5) - 1'",
            "contact.obstacle.height.value",
        ),
        (
            "obstacle = {}",
            "expected exactly one of half_space, sphere, cylinder, height",
        ),
        (
            "obstacle.sphere = { centre = [0.5, 0.5, 0.0], radius = 1.0, side = 'inside' }",
            "away from the centre",
        ),
        (
            "obstacle.sphere = { centre = [0.5, 0.5, -2.0], radius = 1.0 }\naxis_1 = [0.0, 0.0, 1.0]",
            "nowhere along the normal",
        ),
    ];
    for (contact, words) in cases {
        let message = refusal("z_min", contact);
        assert!(message.contains(words), "{contact}: {message}");
    }
    let message = refusal(
        "z_max",
        "obstacle.sphere = { centre = [0.5, 0.5, -2.0], radius = 1.0 }",
    );
    assert!(message.contains("looks towards the obstacle"), "{message}");
}

/// The lower face of a brick of edge 1 as a part of the unit sphere about (1/2, 1/2, −1).
fn hollow([x, y, z]: [f64; 3]) -> [f64; 3] {
    let s = 1.0 - (1.0 - (x - 0.5).powi(2) - (y - 0.5).powi(2)).sqrt();
    [x, y, z - (1.0 - z) * s]
}

/// Cut meshes keep the shape of the first one, whose quadratic sides miss the sphere.
#[test]
fn cut_meshes_of_a_curved_face_may_touch() {
    let scene = "[[clamp]]\nface = 'z_max'\n[contact]\nface = 'z_min'\nmultipliers = 'nodal'\n\
                 obstacle.sphere = { centre = [0.5, 0.5, -1.0], radius = 1.0 }\n";
    let (folder, text) = written(
        "size = [1.0, 1.0, 1.0]\ncells = [4, 4, 4]",
        "P2",
        hollow,
        scene,
    );
    let scene = Scene::parse("cut", &text).expect("a scene");
    let first = Mesh::of_scene(&scene, folder.path()).expect("a mesh");
    let cut = [RefinedLevel::Cuts(vec![3; first.tetrahedra.len()])];
    let cut = Mesh::refined(&scene, folder.path(), &cut).expect("a cut mesh");
    let clearance = &cut.contact.expect("contact").clearance;
    assert!(clearance.len() > 200);
    // Quadratic sides with edges up to h = R/2 where the face is steep: (h/R)⁴/100, and as much from the middles of edges.
    assert!(clearance.iter().all(|d| (0.0..2e-3).contains(d)));
    assert!(clearance.iter().any(|d| *d > 1e-7));
}

/// A round face of straight triangles on a round obstacle of its own radius: nodes touch, triangles cut in.
#[test]
fn facets_of_a_curved_face_may_touch() {
    let scene = |depth: f64| {
        format!(
            "[[clamp]]\nface = 'z_max'\n[[pressure]]\nface = 'x_max'\nvalue = 0.01\n[contact]\nface = 'z_min'\nmultipliers = 'nodal'\n\
             obstacle.sphere = {{ centre = [0.5, 0.5, {:?}], radius = 1.0 }}\n",
            depth - 1.0
        )
    };
    let brick = "size = [1.0, 1.0, 1.0]\ncells = [4, 4, 2]";
    for element in ["P1", "P2"] {
        let solved = moved(brick, element, hollow, &scene(0.0)).unwrap_or_else(|e| panic!("{e}"));
        // On the sphere to the digits of the file, and never inside it.
        assert!(
            solved
                .surface()
                .clearance
                .iter()
                .all(|d| (0.0..1e-12).contains(d))
        );
        // h²/6R is 2e-2 for the edges of the triangles; a tenth of the radius is no facet.
        let Err(message) = moved(brick, element, hollow, &scene(0.1)) else {
            panic!("accepted");
        };
        assert!(message.contains("inside it"), "{message}");
    }
    let Err(message) = moved(
        brick,
        "P1",
        hollow,
        "[[clamp]]\nface = 'z_max'\n[contact]\nface = 'z_min'\n",
    ) else {
        panic!("accepted");
    };
    assert!(
        message.contains("contact.obstacle for a curved one"),
        "{message}"
    );
}
