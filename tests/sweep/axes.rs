//! What axes can change, and how errors name the case.

use std::path::Path;

use contact3d_pipe::{Plan, SWEEP_LAYOUT};
use runfile::Reader;

use crate::program::{Sweep, names};

fn refusal(sweep: &Sweep) -> String {
    let (code, said) = sweep.run("out", &[]);
    assert_eq!(code, 2, "{said}");
    let words: Vec<&str> = said.split_whitespace().filter(|w| *w != "│").collect();
    words.join(" ")
}

#[test]
fn errors_name_the_case() {
    let sweep = Sweep::new(
        "[set]\n\"body.brick.cells\" = [12, 4, 4]\n\
         [[axis]]\nkey = \"solve.epsilon\"\nvalues = [1e-8, 1e-6]\n\
         [[axis]]\nkey = \"friction.coefficient_1\"\nvalues = [{ constant = 0.3 }, { constant = -0.5 }]",
    );
    let said = refusal(&sweep);
    let case = "scene.toml with case 1 of sweep.toml (solve.epsilon = 1e-8, friction.coefficient_1 = { constant = -0.5 }): \
                friction.coefficient_1.constant: expected a positive coefficient, 1e-100 at least, found -0.5";
    assert!(said.contains(case), "{said}");
    sweep.write("[set]\n\"solve.epsilon\" = 7.0\n[[axis]]\nkey = \"title\"\nvalues = [\"a\"]");
    let said = refusal(&sweep);
    assert!(
        said.contains("scene.toml with [set] of sweep.toml (solve.epsilon = 7.0): solve.epsilon"),
        "{said}"
    );
    sweep.write(
        "[[axis]]\nkey = \"title\"\nvalues = [\"a\"]\n[[axis]]\nkey = \"title.x\"\nvalues = [1]",
    );
    let said = refusal(&sweep);
    assert!(
        said.contains("case 0 of sweep.toml: title.x: expected a key of the scene"),
        "{said}"
    );
    sweep.write("[[axis]]\nkey = \"solve.epsilon\"\nvalues = [1e-8, 1e-6, 1e-8]");
    let said = refusal(&sweep);
    assert!(said.contains("solve.epsilon = 1e-8: expected every key on one axis, and every case once, found it at numbers 0 and 2"), "{said}");
}

#[test]
fn failed_cases_are_named_and_their_error_says_what_to_do() {
    let sweep = Sweep::new(
        "[set]\n\"body.brick.cells\" = [12, 4, 4]\n[[axis]]\nkey = \"contact.gap\"\nvalues = [\"x - 1\"]",
    );
    let (code, said) = sweep.run("out", &[]);
    assert_eq!(code, 1, "{said}");
    let id = sweep.plan()[0]["id"].as_str().unwrap().to_owned();
    for fragment in [
        format!("case {id} (contact.gap = \"x - 1\") failed: "),
        "found -1.0 at x, y, z = 0.0, 0.0, 0.0; write max(FORMULA, 0)".to_owned(),
    ] {
        assert!(said.contains(&fragment), "{fragment}: {said}");
    }
    sweep.write(
        "[set]\n\"body.brick.cells\" = [12, 4, 4]\n[[axis]]\nkey = \"contact.gap\"\nvalues = [\"max(x - 1, 0)\"]",
    );
    let (code, said) = sweep.run("out", &[]);
    assert_eq!(code, 0, "the advice was followed: {said}");
}

#[test]
fn ranges_of_whole_numbers_change_meshes() {
    let sweep = Sweep::new(
        "[set]\n\"body.brick.cells\" = [12, 4, 4]\n\
         [[axis]]\nkey = \"body.brick.cells.0\"\nrange = { from = 4, to = 12, count = 3 }",
    );
    let cells: Vec<_> = sweep
        .plan()
        .iter()
        .map(|case| case["settings"]["body.brick.cells.0"].clone())
        .collect();
    assert_eq!(cells, [4, 8, 12]);
    let (code, said) = sweep.run("out", &[]);
    assert_eq!(code, 0, "{said}");
    sweep.write("[[axis]]\nkey = \"body.brick.cells.0\"\nrange = { from = 4, to = 12, count = 4 }");
    let said = refusal(&sweep);
    assert!(
        said.contains("axis 0: expected ends and a count that make whole numbers"),
        "{said}"
    );
}

#[test]
fn parameters_are_swept_over() {
    let sweep = Sweep::new(
        "[set]\n\"body.brick.cells\" = [12, 4, 4]\n\"friction.coefficient_1\" = { expression = \"mu*(1 + 0*s1)\" }\n\
         \"parameters.spare\" = 1.0\n\"parameters.mu\" = 0.2\n\
         [[axis]]\nkey = \"parameters.mu\"\nrange = { from = 0.1, to = 0.3, count = 3 }",
    );
    let (code, said) = sweep.run("out", &[]);
    assert_eq!(code, 0, "{said}");
    assert!(said.contains("3 computed"), "{said}");
    assert_eq!(
        said.matches("warning: parameters.spare: no formula uses it")
            .count(),
        1,
        "{said}"
    );
    let table = std::fs::read_to_string(sweep.path("out/summary.csv")).unwrap();
    assert!(table.contains("parameters.mu"), "{table}");
}

/// Cases of a scene without parameters have the names they had before there were any.
#[test]
fn names_of_cases_stay() {
    let file = Path::new(env!("CARGO_MANIFEST_DIR")).join("pipelines/sweep_friction.toml");
    let plan = Plan::read(&file).unwrap();
    let names = [&plan.cases[0].id, &plan.cases[plan.cases.len() - 1].id];
    assert_eq!(names, ["5e9b839d72df206e", "45226780ab822201"]);
}

/// The text of a scene leaves out the zeros of a clamp, and they can be changed one by one all the same.
#[test]
fn a_clamp_at_zero_can_be_moved_on_an_axis() {
    let sweep = Sweep::new(
        "[set]\n\"body.brick.cells\" = [12, 4, 4]\n\
         [[axis]]\nkey = \"clamp.0.value.2\"\nvalues = [0.0, 1e-6]\n\
         [[axis]]\nkey = \"contact.gap\"\nvalues = [0.0, 1e-6]",
    );
    let (code, said) = sweep.run("out", &[]);
    assert_eq!(code, 0, "{said}");
    assert_eq!(
        names(&sweep.path("out"), ".h5")
            .iter()
            .filter(|n| n.starts_with("assemble-"))
            .count(),
        1
    );
    // Cases of an older plan keep their values in their own columns, though their scenes leave out what is zero.
    sweep.write(
        "[set]\n\"body.brick.cells\" = [12, 4, 4]\n\
         [[axis]]\nkey = \"contact.gap\"\nvalues = [2e-6]\n\
         [[axis]]\nkey = \"clamp.0.value.2\"\nvalues = [1e-6]",
    );
    let (code, said) = sweep.run("out", &[]);
    assert_eq!(code, 0, "{said}");
    let reader = Reader::open(&sweep.path("out/summary.h5"), SWEEP_LAYOUT).expect("a table");
    let values: Vec<f64> = reader.read_vec("/cases/setting_value").expect("numbers");
    let rows = values.as_chunks::<2>().0;
    assert_eq!(rows[0], [2e-6, 1e-6]);
    let mut older: Vec<[f64; 2]> = rows[1..].to_vec();
    older.sort_by(|a, b| a.partial_cmp(b).unwrap_or_else(|| a[1].total_cmp(&b[1])));
    // A gap of zero is not in the scene.
    assert_eq!(older.iter().filter(|row| row[0].is_nan()).count(), 2);
    assert_eq!(older.iter().filter(|row| row[0] == 1e-6).count(), 2);
    assert!(older.iter().all(|row| row[1] == 0.0 || row[1] == 1e-6));
}

#[test]
fn what_is_no_sweep_is_refused_in_words() {
    for (axes, fragment) in [
        (
            "[[axis]]\nkey = \"contact.gap\"\nrange = { from = 1, to = 2, count = -3 }",
            "axis.0.range.count: expected a whole number from 0 on, found integer `-3`",
        ),
        (
            "axis = [[\"contact.gap\", [1.0]]]",
            "axis: expected a table, found a list",
        ),
        (
            "warm_start = 1",
            "warm_start: expected true or false, found integer `1`",
        ),
    ] {
        let sweep = Sweep::new(axes);
        let (code, said) = sweep.run("out", &[]);
        assert_eq!(code, 2, "{said}");
        let words: Vec<&str> = said.split_whitespace().filter(|w| *w != "│").collect();
        assert!(words.join(" ").contains(fragment), "{fragment}: {said}");
    }
}
