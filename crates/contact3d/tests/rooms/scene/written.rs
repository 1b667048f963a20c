//! Values and titles as messages show them.

use contact3d::scene::{
    Coefficient, Formula, Part, Quantity, Ramp, Written, escape_control, escape_control_lines,
};

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
    assert_eq!(
        escape_control_lines(title),
        "a\nb\\u{1b}]0;c\\u{7}\t\\u{202e}é λ"
    );
    assert_eq!(
        escape_control(title),
        "a\\nb\\u{1b}]0;c\\u{7}\\t\\u{202e}é λ"
    );
}
