//! What axes can change, and how errors name the case.

use std::path::Path;

use contact3d_pipe::{Plan, SWEEP_LAYOUT};
use runfile::Reader;

use crate::program::{Sweep, names};

/// The settings of all cases, as a scene writes them, or why there are none.
fn settings(axes: &str) -> Result<Vec<Vec<String>>, String> {
    let plan = Plan::read(&Sweep::new(axes).path("sweep.toml"));
    let cases = plan.map_err(|error| error.to_string())?.cases;
    let written = cases.iter().map(|case| &case.settings);
    Ok(written
        .map(|pairs| pairs.iter().map(|(_, value)| value.to_string()).collect())
        .collect())
}

fn along(key: &str, range: &str) -> Result<Vec<String>, String> {
    let cases = settings(&format!("[[axis]]\nkey = \"{key}\"\nrange = {range}"))?;
    Ok(cases.concat())
}

/// A date is no value of any key, and is shown as it was written.
#[test]
fn a_date_is_shown_as_a_date() {
    let axis = "[[axis]]\nkey = \"friction.coefficient.constant\"\nvalues = [1979-05-27]";
    let error = settings(axis).unwrap_err();
    assert!(
        error.contains("friction.coefficient.constant = 1979-05-27"),
        "{error}"
    );
    assert!(!error.contains("private"), "{error}");
}

#[test]
fn ranges_of_whole_numbers_are_whole_where_the_key_is() {
    let linear = "{ from = 4, to = 12, count = 3 }";
    let values = |key: &str, range: &str| along(key, range).unwrap();
    assert_eq!(values("solve.max_outer_steps", linear), ["4", "8", "12"]);
    assert_eq!(values("body.brick.cells.1", linear), ["4", "8", "12"]);
    assert_eq!(values("body.brick.size.0", linear), ["4.0", "8.0", "12.0"]);
    let logarithmic = "{ from = 3, to = 3000, count = 4, scale = \"log\" }";
    let steps = values("solve.max_outer_steps", logarithmic);
    assert_eq!(steps, ["3", "30", "300", "3000"]);
    for range in [
        "{ from = 4, to = 12, count = 4 }",
        "{ from = 0.5, to = 1.5, count = 2 }",
        "{ from = 1, to = 1e300, count = 2 }",
    ] {
        let error = along("solve.max_outer_steps", range).unwrap_err();
        let expected = "axis 0: expected ends and a count";
        assert!(error.contains(expected), "{error}");
    }
}

/// Numbers are those that a person would write, and differ from the line between the ends by its rounding alone.
#[test]
fn ranges_have_the_shortest_decimals() {
    let values = |range: &str| along("body.brick.size.0", range).unwrap();
    let tenths = values("{ from = 0.1, to = 0.7, count = 7 }");
    assert_eq!(tenths, ["0.1", "0.2", "0.3", "0.4", "0.5", "0.6", "0.7"]);
    let decades = values("{ from = 1e-3, to = 10.0, count = 5, scale = \"log\" }");
    assert_eq!(decades, ["0.001", "0.01", "0.1", "1.0", "10.0"]);
    let thirds: f64 = values("{ from = 1.0, to = 2.0, count = 4 }")[1]
        .parse()
        .unwrap();
    assert!((thirds - 4.0 / 3.0).abs() <= 8.0 * f64::EPSILON);
    let across = along("traction.0.value.0", "{ from = -0.3, to = 0.3, count = 7 }").unwrap();
    assert_eq!(across[3], "0.0");
}

#[test]
fn ranges_end_exactly_and_keep_their_ratios() {
    let range = "{ from = 0.05, to = 1.6, count = 6, scale = \"log\" }";
    let values = along("body.brick.size.0", range).unwrap();
    let values: Vec<f64> = values.iter().map(|value| value.parse().unwrap()).collect();
    assert_eq!((values[0], values[5]), (0.05, 1.6));
    for pair in values.windows(2) {
        // Ratio 2, one exponential and one logarithm: a few roundings.
        assert!((pair[1] / pair[0] - 2.0).abs() < 1e-14);
    }
}

#[test]
fn zipped_axes_become_one() {
    let cases = settings(
        "[[axis]]\nkey = \"body.brick.cells.0\"\nvalues = [2, 4]\nzip = \"z\"\n\
         [[axis]]\nkey = \"body.brick.size.0\"\nvalues = [7]\n\
         [[axis]]\nkeys = [\"body.brick.cells.1\", \"body.brick.cells.2\"]\nrows = [[4, 3], [6, 5]]\nzip = \"z\"",
    );
    let expected = [["2", "4", "3", "7"], ["4", "6", "5", "7"]];
    assert_eq!(cases.unwrap(), expected);
}

#[test]
fn axes_that_make_no_sense_are_refused() {
    for (axis, expected) in [
        ("", "key with values"),
        ("values = []", "at least one value"),
        (
            "values = [1]\nrange = { from = 1, to = 2, count = 2 }",
            "key with values",
        ),
        (
            "range = { from = 0.0, to = 2, count = 2, scale = \"log\" }",
            "finite ends, both positive",
        ),
        (
            "range = { from = 1, to = 2, count = 1 }",
            "a count of at least 2",
        ),
        (
            "values = [1, 2]\nzip = \"z\"\n[[axis]]\nkey = \"body.brick.cells.0\"\nvalues = [1]\nzip = \"z\"",
            "as many values as the other axes of its zip",
        ),
    ] {
        let error = settings(&format!("[[axis]]\nkey = \"body.brick.size.0\"\n{axis}"));
        let error = error.unwrap_err();
        assert!(error.contains(&format!("expected {expected}")), "{error}");
    }
    let error = settings("[[axis]]\nkeys = [\"title\", \"b\"]\nrows = [[1]]").unwrap_err();
    assert!(
        error.contains("one value for each key in every row"),
        "{error}"
    );
}

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
                friction.coefficient_1.constant: expected a finite positive number, 1e-100 at least, found -0.5";
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
    assert_eq!(names, ["4b3295317fb85d5a", "a7f0a800be1ab5eb"]);
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
    let units = reader.read_texts("/cases/key_unit").expect("units");
    assert_eq!(units, ["m", "m"]);
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
