//! A sweep of version 0.1.0 that was killed: one case done, one half-done with its checkpoint, one
//! not begun.

use std::{collections::BTreeMap, fs};

use contact3d_pipe::{CHECKPOINT, LAYOUT};
use runfile::Reader;

use super::program::Scratch;

const DONE: &str = "3ef00d97ea0cd6be";
const HALF_DONE: &str = "12656c655feacdc9";
const MISSING: &str = "cf63a16de53d047e";

fn scratch() -> Scratch {
    Scratch::with(&["sweep/scene.toml", "sweep/sweep.toml", "sweep/half"])
}

/// The table by the names of the cases, and then of the columns.
fn table(scratch: &Scratch, folder: &str) -> BTreeMap<String, BTreeMap<String, String>> {
    let file = scratch.path(&format!("{folder}/summary.csv"));
    let mut reader = csv::Reader::from_path(file).expect("a table");
    let rows = reader.deserialize::<BTreeMap<String, String>>();
    rows.map(|row| row.expect("a row"))
        .map(|row| (row["id"].clone(), row))
        .collect()
}

#[test]
fn the_cases_still_have_their_names() {
    let output = scratch().run(&["sweep", "plan", "sweep.toml", "--out", "half"]);
    let plan: Vec<serde_json::Value> = serde_json::from_slice(&output.stdout).expect("JSON");
    let names: Vec<&str> = plan.iter().filter_map(|case| case["id"].as_str()).collect();
    assert_eq!(names, [DONE, HALF_DONE, MISSING]);
}

#[test]
fn it_goes_on_keeps_what_is_done_and_agrees_with_a_new_one() {
    let scratch = scratch();
    let file = scratch.path(&format!("half/{DONE}.h5"));
    let done = fs::read(&file).expect("a run file");
    let reader = Reader::open(&scratch.path(&format!("half/{HALF_DONE}.h5")), LAYOUT);
    let reader = reader.expect("a run file");
    assert!(matches!(reader.group_record(CHECKPOINT), Ok(Some(_))));
    drop(reader);
    let said = scratch.done(&["sweep", "sweep.toml", "--out", "half", "--no-figures"]);
    assert!(said.contains("2 computed, 1 kept, 0 failed"), "{said}");
    assert_eq!(fs::read(&file).expect("a run file"), done);
    for case in [DONE, HALF_DONE, MISSING] {
        scratch.done(&["check", &format!("half/{case}.h5")]);
    }
    scratch.done(&["sweep", "sweep.toml", "--out", "new", "--no-figures"]);
    let (old, new) = (table(&scratch, "half"), table(&scratch, "new"));
    assert_eq!(
        old.keys().collect::<Vec<_>>(),
        new.keys().collect::<Vec<_>>()
    );
    for (case, row) in &old {
        // What an older version stored stays as it was; now the published stopping rule has a
        // status of its own.
        let status = if case == DONE { "converged" } else { "stopped" };
        assert_eq!(row["status"], status, "{case}");
        for column in ["normal_force", "tangential_force_1", "strain_energy"] {
            let value =
                |row: &BTreeMap<String, String>| row[column].parse::<f64>().expect("number");
            let (a, b) = (value(row), value(&new[case]));
            assert!(
                (a - b).abs() < 1e-9 * a.abs(),
                "{case}, {column}: {a} and {b}"
            );
        }
    }
    // The checkpoint was used: its steps come first in the history.
    assert_eq!(old[HALF_DONE]["outer_steps"], new[HALF_DONE]["outer_steps"]);
}

#[test]
fn its_table_is_gone_on_with_and_drawn() {
    let scratch = scratch();
    scratch.done(&["sweep", "summary", "sweep.toml", "--out", "half"]);
    let row = &table(&scratch, "half")[DONE];
    assert_eq!(row["status"], "converged");
    // The file has the count under its former name.
    let file = hdf5_metno::File::open(scratch.path(&format!("half/{DONE}.h5"))).expect("HDF5");
    let counted = file.dataset("solve/actions").expect("a dataset");
    let counted = counted.read_scalar::<i64>().expect("a number");
    assert_eq!(row["applications"], counted.to_string());
    assert_eq!(table(&scratch, "half")[MISSING]["status"], "missing");
    scratch.done(&["report", "half", "-o", "report.html"]);
}

#[test]
fn another_sweep_does_not_write_over_its_table() {
    let scratch = scratch();
    let text = fs::read_to_string(scratch.path("sweep.toml")).expect("a sweep");
    let other = text.replace("[0.1, 0.2, 0.25]", "[0.11, 0.21]");
    assert_ne!(text, other);
    fs::write(scratch.path("other.toml"), other).expect("written");
    let tables = || ["half/summary.csv", "half/summary.h5"].map(|f| fs::read(scratch.path(f)).ok());
    let before = tables();
    let output = scratch.run(&["sweep", "other.toml", "--out", "half"]);
    let text = String::from_utf8_lossy(&output.stderr).into_owned();
    assert_eq!(output.status.code(), Some(2), "{text}");
    assert!(text.contains("belongs to another sweep"), "{text}");
    assert_eq!(tables(), before);
}
