//! Run files of formats 1.0 to 1.3, all of one scene.

use std::path::Path;

use serde_json::Value;

use super::program::{Scratch, fixture};

/// The formats, and the stages of their files that can be gone on from; later ones are computed
/// again.
const FORMATS: [(&str, &[&str]); 4] = [
    ("1.0", &[]),
    ("1.1", &["mesh"]),
    ("1.2", &["mesh", "assemble", "load", "solve", "post"]),
    ("1.3", &["mesh", "assemble", "load", "solve", "post"]),
];

/// The scene of all files, as the command line changed it.
const CHANGES: [&str; 4] = [
    "--set",
    "body.brick.cells=[6,2,2]",
    "--set",
    "solve.epsilon=1e-10",
];

fn states(scratch: &Scratch, file: &str) -> Vec<(String, String, String)> {
    let output = scratch.run(&["status", file, "--json"]);
    let text = String::from_utf8_lossy(&output.stderr).into_owned();
    assert_eq!(output.status.code(), Some(0), "{file}: {text}");
    let status: Value = serde_json::from_slice(&output.stdout).expect("JSON");
    let word = |value: &Value| value.as_str().expect("text").to_owned();
    let stages = status["stages"].as_array().expect("stages").iter();
    stages
        .map(|s| (word(&s["stage"]), word(&s["state"]), word(&s["why"])))
        .collect()
}

fn values(file: &Path, dataset: &str) -> Vec<f64> {
    let file = hdf5_metno::File::open(file).expect("HDF5");
    file.dataset(dataset)
        .and_then(|dataset| dataset.read_raw())
        .expect("numbers")
}

/// What was solved then and what is solved now differ by no more than both accuracies asked for.
fn agree(old: &Path, new: &Path) {
    for dataset in [
        "solve/multiplier_normal",
        "solve/multiplier_tangential",
        "solve/displacement",
        "post/resultants/contact_force",
    ] {
        let (old, new) = (values(old, dataset), values(new, dataset));
        assert_eq!(old.len(), new.len(), "{dataset}");
        let size = old.iter().fold(0.0_f64, |size, v| size.max(v.abs()));
        for (a, b) in old.iter().zip(&new) {
            assert!((a - b).abs() < 1e-8 * size, "{dataset}: {a} and {b}");
        }
    }
}

#[test]
fn sound_stages_are_fresh_or_said_to_be_of_an_older_form_and_never_damaged() {
    for (format, usable) in FORMATS {
        let name = format!("run_{format}.h5");
        let scratch = Scratch::with(&[&name]);
        for (stage, state, why) in states(&scratch, &name) {
            let expected = match (usable.contains(&stage.as_str()), stage.as_str()) {
                (true, _) => "fresh",
                (false, "load") => "missing",
                (false, _) => "stale",
            };
            assert_eq!(state, expected, "{format}, {stage}: {why}");
        }
        let states = states(&scratch, &name);
        let first = states.iter().find(|(_, state, _)| state != "fresh");
        if let Some((_, _, why)) = first {
            assert!(why.contains("an older version wrote it"), "{format}: {why}");
        }
    }
}

#[test]
fn they_pass_the_check_and_altered_ones_do_not() {
    for (format, _) in FORMATS {
        let name = format!("run_{format}.h5");
        let scratch = Scratch::with(&[&name]);
        scratch.done(&["check", &name]);
        // A dataset that the table no longer has, one that it has, and a matrix.
        for dataset in [
            "assemble/load",
            "solve/multiplier_normal",
            "assemble/stiffness/data",
        ] {
            let scratch = Scratch::with(&[&name]);
            let file = hdf5_metno::File::open_rw(scratch.path(&name)).expect("HDF5");
            if !file.link_exists(dataset) {
                continue;
            }
            let values = file.dataset(dataset).expect("a dataset");
            let mut altered: Vec<f64> = values.read_raw().expect("numbers");
            altered[0] += 1.0;
            values.write_raw(&altered).expect("written");
            drop(values);
            file.close().expect("closed");
            let output = scratch.run(&["check", &name]);
            assert_eq!(output.status.code(), Some(2), "{format}, {dataset}");
            let text = String::from_utf8_lossy(&output.stderr).into_owned();
            assert!(text.contains("was altered since it was written"), "{text}");
        }
    }
}

#[test]
fn run_goes_on_with_them_to_the_same_numbers() {
    for (format, usable) in FORMATS {
        let name = format!("run_{format}.h5");
        let scratch = Scratch::with(&[&name, "table1.toml"]);
        let mut run = vec!["run", "table1.toml", &name, "--no-figures"];
        run.extend(CHANGES);
        let said = scratch.done(&run);
        assert_eq!(said.matches("fresh, kept").count(), usable.len(), "{said}");
        for (stage, state, why) in states(&scratch, &name) {
            assert_eq!(state, "fresh", "{format}, {stage}: {why}");
        }
        scratch.done(&["check", &name]);
        agree(&fixture(&name), &scratch.path(&name));
    }
}

#[test]
fn post_and_solve_run_alone_on_what_can_be_gone_on_from() {
    for (format, usable) in FORMATS {
        let name = format!("run_{format}.h5");
        let scratch = Scratch::with(&[&name]);
        for command in ["post", "solve"] {
            let output = scratch.run(&[command, &name]);
            let text = String::from_utf8_lossy(&output.stderr).into_owned();
            if usable.contains(&"solve") {
                assert_eq!(output.status.code(), Some(0), "{format}: {text}");
            } else {
                assert_eq!(output.status.code(), Some(2), "{format}: {text}");
                assert!(text.contains("an older version wrote it"), "{text}");
                let unchanged = std::fs::read(fixture(&name)).expect("bytes");
                assert_eq!(
                    std::fs::read(scratch.path(&name)).expect("bytes"),
                    unchanged
                );
            }
        }
        if usable.contains(&"solve") {
            agree(&fixture(&name), &scratch.path(&name));
        }
    }
}

/// A commit keeps what it does not replace, in a file of the present version.
#[test]
fn stages_of_an_older_form_stay_what_they_are_beside_new_ones() {
    let scratch = Scratch::with(&["run_1.1.h5", "table1.toml"]);
    let mut mesh = vec!["mesh", "table1.toml", "run_1.1.h5"];
    mesh.extend(CHANGES);
    scratch.done(&mesh);
    let states = states(&scratch, "run_1.1.h5");
    let words: Vec<&str> = states.iter().map(|(_, state, _)| state.as_str()).collect();
    assert_eq!(words, ["fresh", "stale", "missing", "stale", "stale"]);
    scratch.done(&["check", "run_1.1.h5"]);
}

#[test]
fn reports_leave_out_what_cannot_be_read_and_say_so() {
    for (format, usable) in FORMATS {
        let name = format!("run_{format}.h5");
        let scratch = Scratch::with(&[&name]);
        scratch.done(&["report", &name, "-o", "report.html"]);
        let page = std::fs::read_to_string(scratch.path("report.html")).expect("a page");
        let complete = usable.contains(&"post");
        assert_eq!(page.contains("id=\"results\""), complete, "{format}");
        assert_eq!(
            page.contains("an older version wrote it"),
            !complete,
            "{format}"
        );
    }
}
