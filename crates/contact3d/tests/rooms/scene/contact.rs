//! Contact faces as a table or an array, and their order.

use std::collections::BTreeMap;

use contact3d::scene::{Contact, Quantity, Scene, Step, StepValue};

const BODY: &str = r#"
    title = "faces"
    clamp = [{ face = "x_max" }]
    body.brick = { size = [1.0, 1.0, 1.0], cells = [2, 2, 2] }
    material.isotropic = { young_modulus = 1.0, poisson_ratio = 0.3 }
"#;

fn scene(contact: &str) -> Scene {
    Scene::parse("faces", &format!("{BODY}\n{contact}")).expect("a scene")
}

#[test]
fn one_face_is_a_table_and_several_are_an_array() {
    let table = scene("[contact]\nface = \"z_min\"");
    let array = scene("[[contact]]\nface = \"z_min\"");
    assert_eq!(table, array);
    assert!(table.to_toml().expect("no functions").contains("[contact]"));
    let both = scene("[[contact]]\nface = \"z_min\"\n[[contact]]\nface = \"x_min\"");
    let text = both.to_toml().expect("no functions");
    assert_eq!(text.matches("[[contact]]").count(), 2);
    assert_eq!(Scene::parse("again", &text).expect("a scene"), both);
}

#[test]
fn faces_with_friction_come_first() {
    let own = scene(
        "[[contact]]\nface = \"z_min\"\n[[contact]]\nface = \"x_min\"\nfriction.coefficient.constant = 0.3",
    );
    assert_eq!(own.contact_order(), [1, 0]);
    assert_eq!(
        own.friction_on(1).expect("friction").0,
        "contact.1.friction"
    );
    let common = scene(
        "[[contact]]\nface = \"z_min\"\n[[contact]]\nface = \"x_min\"\n[friction]\ncoefficient.constant = 0.3",
    );
    assert_eq!(common.contact_order(), [0, 1]);
}

#[test]
fn builders_say_what_keys_say() {
    let scene = scene(
        "[contact]\nface = \"z_min\"\naxis_1 = [0.0, 1.0, 0.0]\n[[step]]\ntitle = \"lift\"\nvalue.\"contact.gap\" = 0.5",
    );
    let turned = Contact {
        axis_1: Some([0.0, 1.0, 0.0].map(Quantity::Constant)),
        ..Contact::on("z_min")
    };
    assert_eq!(scene.contacts, [turned]);
    let gap = StepValue::Number(Quantity::Constant(0.5));
    assert_eq!(
        scene.steps,
        [Step {
            value: BTreeMap::from([("contact.gap".to_owned(), gap)]),
            ..Step::new("lift")
        }]
    );
}
