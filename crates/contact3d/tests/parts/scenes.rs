//! Scenes as they are written: contact faces as tables and arrays, values, titles.

use contact3d::scene::{
    Coefficient, Formula, Part, Quantity, Ramp, Scene, Written, shown, shown_lines,
};

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
fn values_are_written_as_in_scenes() {
    let ramp = Coefficient::Ramp(Ramp {
        initial: 0.3,
        residual: f64::NAN,
        onset: 0.0,
        rate: 1.0,
    });
    let formula = Coefficient::Expression(Formula::parse("0.3 + s").unwrap());
    for (found, expected) in [
        (Written(&Quantity::Constant(f64::NAN)).to_string(), "nan"),
        (Written(&[1.0, -2.5e-300]).to_string(), "[1.0, -2.5e-300]"),
        (Written(&"z_min").to_string(), "\"z_min\""),
        (
            Written(&ramp).to_string(),
            "{ ramp = { initial = 0.3, residual = nan, onset = 0.0, rate = 1.0 } }",
        ),
        (
            Written(&formula).to_string(),
            "{ expression = \"0.3 + s\" }",
        ),
        (
            Written(&Part::Box([[0.0; 3], [1.0; 3]])).to_string(),
            "{ box = [[0.0, 0.0, 0.0], [1.0, 1.0, 1.0]] }",
        ),
    ] {
        assert_eq!(found, expected);
    }
}

#[test]
fn a_title_stays_on_its_line_and_commands_nothing() {
    let title = "a\nb\u{1b}]0;c\u{7}\t\u{202e}é λ";
    assert_eq!(shown_lines(title), "a\nb\\u{1b}]0;c\\u{7}\t\\u{202e}é λ");
    assert_eq!(shown(title), "a\\nb\\u{1b}]0;c\\u{7}\\t\\u{202e}é λ");
}
