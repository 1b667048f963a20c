//! Whose tables a sweep may write over: its own.

use std::{
    fs,
    thread::sleep,
    time::{Duration, Instant},
};

use contact3d_pipe::{LAYOUT, SWEEP_LAYOUT};
use hdf5_metno::File;
use runfile::Reader;

use crate::program::{SLOW, Sweep};

const AXIS: &str = "[set]\n\"body.brick.cells\" = [6, 2, 2]\n[[axis]]\nkey = \"friction.coefficient_1.ramp.residual\"\nvalues = [0.1, 0.2]";

fn tables(sweep: &Sweep) -> [Option<Vec<u8>>; 2] {
    ["out/summary.csv", "out/summary.h5"].map(|name| fs::read(sweep.path(name)).ok())
}

/// Runs another command in the folder, which must be refused with the tables as they were.
fn refused(sweep: &Sweep, arguments: &[&str], word: &str) {
    let before = tables(sweep);
    let files = || fs::read_dir(sweep.path("out")).map_or(0, Iterator::count);
    let count = files();
    let output = sweep.command(arguments).output().unwrap();
    let said = String::from_utf8_lossy(&output.stderr).into_owned();
    assert_eq!(output.status.code(), Some(2), "{said}");
    assert!(said.contains(word), "{said}");
    assert_eq!(tables(sweep), before);
    assert_eq!(files(), count, "files were made: {said}");
}

#[test]
fn foreign_tables_are_not_written_over() {
    for (name, content, word) in [
        (
            "summary.csv",
            "date,price\n1,2\n",
            "expected the CSV table of a sweep",
        ),
        (
            "summary.csv",
            "id,planned\n1,2\n",
            "expected the CSV table of a sweep",
        ),
        ("summary.h5", "text", "not an HDF5 file"),
    ] {
        let sweep = Sweep::new(AXIS);
        fs::create_dir(sweep.path("out")).unwrap();
        fs::write(sweep.path("out").join(name), content).unwrap();
        refused(&sweep, &["sweep.toml", "out"], word);
        refused(&sweep, &["summary", "sweep.toml", "out"], word);
    }
}

#[test]
fn a_folder_of_an_older_format_is_left_as_it_is() {
    let sweep = Sweep::new(AXIS);
    assert_eq!(sweep.run("out", &[]).0, 0);
    File::create(sweep.path("out/summary.h5")).expect("HDF5");
    let word =
        "of a format before 2.0); nothing was changed, give such a file to read, or run again";
    refused(&sweep, &["sweep.toml", "out"], word);
    refused(&sweep, &["summary", "sweep.toml", "out"], word);
}

/// Pulled to and fro: what friction took between the ends of the first and the third step, where the loads are the same.
#[test]
fn energies_of_a_cycle_are_those_of_its_steps() {
    let loads = ["1.0", "-1.0", "1.0"].map(|factor| {
        format!("[[step]]\nincrements = 2\nfactor = {{ \"traction.0\" = {factor} }}\n")
    });
    let block = format!(
        "body.brick = {{ size = [1.0, 1.0, 0.5], cells = [4, 4, 2] }}
material.isotropic = {{ young_modulus = 2e11, poisson_ratio = 0.3 }}
clamp = [{{ face = \"x_min\" }}]
pressure = [{{ face = \"z_max\", value = 1e8 }}]
traction = [{{ face = \"x_max\", value = [1e8, 0.0, 0.0] }}]
contact.face = \"z_min\"
friction.coefficient.constant = 0.3
{}",
        loads.concat()
    );
    let sweep =
        Sweep::new("[[axis]]\nkey = \"friction.coefficient.constant\"\nvalues = [0.1, 0.2]");
    fs::write(sweep.path("scene.toml"), block).unwrap();
    let (code, said) = sweep.run("out", &["--no-figures"]);
    assert_eq!(code, 0, "{said}");
    let table = Reader::open(&sweep.path("out/summary.h5"), SWEEP_LAYOUT).unwrap();
    let told = table.read_vec::<f64>("/cases/cycle_dissipation").unwrap();
    let names = table.read_texts("/cases/id").unwrap();
    for (name, told) in names.iter().zip(&told) {
        let case = Reader::open(&sweep.path(&format!("out/{name}.h5")), LAYOUT).unwrap();
        let took = case.read_vec::<f64>("/history/dissipation").unwrap();
        assert_eq!(*told, took[2..].iter().sum::<f64>(), "{name}");
    }
    assert!(
        told.iter().all(|it| *it > 1.0) && told[0] != told[1],
        "{told:?}"
    );
}

#[test]
fn commands_for_run_files_take_sweeps() {
    let sweep = Sweep::new(AXIS);
    assert_eq!(sweep.run("out", &[]).0, 0);
    let n_cases = sweep.plan().len();
    let counts = format!("{n_cases} cases: {n_cases} converged");
    let status = sweep.said(&["status", "out"]);
    assert!(
        status.contains(&counts) && !status.contains("goes on"),
        "{status}"
    );
    let json: serde_json::Value =
        serde_json::from_str(&sweep.said(&["status", "out", "--json"])).unwrap();
    assert_eq!(json["status"]["converged"], n_cases);
    assert_eq!(json["is_busy"], false);
    sweep.said(&["report", "out/summary.h5", "page.html"]);
    let page = fs::read_to_string(sweep.path("page.html")).unwrap();
    assert!(page.contains(&counts));
}

#[test]
fn the_tables_of_another_sweep_are_not_written_over() {
    let sweep = Sweep::new(AXIS);
    assert_eq!(sweep.run("out", &[]).0, 0);
    // Shares a case with the first, and has one more of its own.
    let other = AXIS.replace("0.1", "0.15");
    let text = format!("scene = \"scene.toml\"\n{other}");
    fs::write(sweep.path("other.toml"), &text).unwrap();
    let word = "belongs to another sweep, ../sweep.toml";
    refused(&sweep, &["other.toml", "out"], word);
    refused(&sweep, &["summary", "other.toml", "out"], word);
    // Without the HDF5 table the CSV table alone tells nothing but its cases.
    let unlike = AXIS.replace("0.1", "0.15").replace("0.2", "0.25");
    fs::write(
        sweep.path("other.toml"),
        format!("scene = \"scene.toml\"\n{unlike}"),
    )
    .unwrap();
    fs::remove_file(sweep.path("out/summary.h5")).unwrap();
    refused(&sweep, &["other.toml", "out"], "belongs to another sweep");
    // Single cases share the folder.
    let plan = sweep
        .command(&["plan", "other.toml", "out"])
        .output()
        .unwrap();
    let plan: serde_json::Value = serde_json::from_slice(&plan.stdout).expect("JSON");
    let id = plan[0]["id"].as_str().expect("a name");
    let case = sweep
        .command(&["run-case", "other.toml", "out", id])
        .output();
    assert!(case.unwrap().status.success());
}

#[test]
fn a_renamed_sweep_with_all_its_cases_goes_on() {
    let sweep = Sweep::new(AXIS);
    assert_eq!(sweep.run("out", &[]).0, 0);
    let more = AXIS.replace("0.2]", "0.2, 0.25]");
    fs::remove_file(sweep.path("sweep.toml")).unwrap();
    fs::write(
        sweep.path("renamed.toml"),
        format!("scene = \"scene.toml\"\n{more}"),
    )
    .unwrap();
    let output = sweep.command(&["renamed.toml", "out"]).output().unwrap();
    let said = String::from_utf8_lossy(&[output.stderr, output.stdout].concat()).into_owned();
    assert_eq!(output.status.code(), Some(0), "{said}");
    assert!(said.contains("1 computed, 2 kept"), "{said}");
}

#[test]
fn charts_replace_only_charts_of_ours() {
    let sweep = Sweep::new(AXIS);
    fs::create_dir_all(sweep.path("out/figures")).unwrap();
    fs::write(sweep.path("out/figures/normal_force.svg"), "<svg/>").unwrap();
    refused(&sweep, &["sweep.toml", "out"], "normal_force.svg");
    fs::remove_file(sweep.path("out/figures/normal_force.svg")).unwrap();
    assert_eq!(sweep.run("out", &[]).0, 0);
    assert_eq!(sweep.run("out", &[]).0, 0);
    assert!(sweep.path("out/figures/normal_force.png").exists());
}

#[test]
fn a_folder_that_cannot_be_made_is_refused() {
    let sweep = Sweep::new(AXIS);
    fs::write(sweep.path("file"), "text").unwrap();
    for out in ["file", "file/below", "/proc/nowhere"] {
        let (code, said) = sweep.run(out, &[]);
        assert_eq!(code, 2, "{said}");
    }
}

/// A case that fails is recorded, so this is no refusal.
#[test]
fn a_single_case_that_fails_is_recorded_with_exit_code_1() {
    let text = "[set]\n\"body.brick.cells\" = [6, 2, 2]\n[[axis]]\nkey = \"body_force\"\nvalues = \
                [{ value = [\"1/(x-x)\", 0.0, 0.0] }]";
    let sweep = Sweep::new(text);
    let id = sweep.plan()[0]["id"].as_str().expect("a name").to_owned();
    let case = sweep
        .command(&["run-case", "sweep.toml", "out", &id])
        .output();
    assert_eq!(case.unwrap().status.code(), Some(1));
    assert!(sweep.path(&format!("out/{id}.error.txt")).exists());
}

/// A folder belongs to its sweep from the start, also if that was killed before any case had ended.
#[test]
fn an_interrupted_sweep_keeps_its_folder() {
    let sweep = Sweep::new(SLOW);
    let mut child = sweep.command(&["sweep.toml", "out"]).spawn().unwrap();
    let started = Instant::now();
    while !sweep.path("out/summary.h5").exists() {
        assert!(started.elapsed() < Duration::from_secs(60), "no table");
        sleep(Duration::from_millis(1));
    }
    child.kill().unwrap();
    child.wait().unwrap();
    fs::write(
        sweep.path("other.toml"),
        format!("scene = \"scene.toml\"\n{AXIS}"),
    )
    .unwrap();
    let word = "belongs to another sweep, ../sweep.toml";
    refused(&sweep, &["other.toml", "out"], word);
    let (code, said) = sweep.run("out", &[]);
    assert_eq!(code, 0, "{said}");
}

#[test]
fn tables_have_the_results_of_each_of_several_faces() {
    let sweep = Sweep::new(
        "[set]\n\"body.brick.cells\" = [12, 4, 4]\n\
         contact = [{ face = \"z_min\", name = \"floor\" }, { face = \"y_min\", name = \"wall\", gap = 1e-6 }]\n\
         [[axis]]\nkey = \"traction.0.value.1\"\nvalues = [0.0, -5e6]",
    );
    let (code, said) = sweep.run("out", &[]);
    assert_eq!(code, 0, "{said}");
    let summary = Reader::open(&sweep.path("out/summary.h5"), SWEEP_LAYOUT).unwrap();
    assert_eq!(
        summary.read_texts("/cases/face_names").unwrap(),
        ["floor", "wall"]
    );
    let numbers = |path: &str| summary.read_vec::<f64>(path).unwrap();
    let (all, each) = (
        numbers("/cases/normal_force"),
        numbers("/cases/face_normal_force"),
    );
    let pairs = numbers("/cases/face_tangential_force");
    let csv = fs::read_to_string(sweep.path("out/summary.csv")).unwrap();
    let mut lines = csv.lines().map(|line| line.split(',').collect::<Vec<_>>());
    let head = lines.next().unwrap();
    for (case, cells) in lines.enumerate() {
        let id = cells[0];
        let file = Reader::open(&sweep.path(&format!("out/{id}.h5")), LAYOUT).unwrap();
        let stored = file.read_vec::<f64>("/post/faces/normal_force").unwrap();
        assert_eq!(each[2 * case..2 * case + 2], stored);
        let tangential = file
            .read_vec::<f64>("/post/faces/tangential_force")
            .unwrap();
        assert_eq!(pairs[4 * case..4 * case + 4], tangential);
        // Two sums of the same forces.
        assert!((stored.iter().sum::<f64>() / all[case] - 1.0).abs() < 1e-13);
        let column = head
            .iter()
            .position(|name| *name == "normal_force_wall")
            .unwrap();
        assert_eq!(cells[column].parse::<f64>().unwrap(), stored[1]);
        // Quantities with error bars have their columns, too.
        let names = file.read_texts("/solve/quantities/name").unwrap();
        let place = names
            .iter()
            .position(|name| name == "contact_area")
            .unwrap();
        let value = file.read_vec::<f64>("/solve/quantities/value").unwrap()[place];
        let range = file.read_vec::<f64>("/solve/quantities/range").unwrap();
        let bar = (range[2 * place + 1] - value).max(value - range[2 * place]);
        for (name, number) in [
            ("quantity_contact_area", value),
            ("error_bar_contact_area", bar),
        ] {
            let column = head.iter().position(|it| *it == name).unwrap();
            assert_eq!(cells[column].parse::<f64>().unwrap(), number);
        }
        assert_eq!(cells.len(), head.len());
    }
    // One face has no such columns; a sum over several has no size.
    assert!(
        numbers("/cases/friction_force")
            .iter()
            .all(|it| it.is_nan())
    );
    let sweep = Sweep::new(AXIS);
    assert_eq!(sweep.run("out", &[]).0, 0);
    let summary = Reader::open(&sweep.path("out/summary.h5"), SWEEP_LAYOUT).unwrap();
    assert!(!summary.has("/cases/face_names"));
    let numbers = |path: &str| summary.read_vec::<f64>(path).unwrap();
    let pairs = numbers("/cases/tangential_force");
    let sizes = pairs.as_chunks::<2>().0.iter().map(|[a, b]| a.hypot(*b));
    assert!(sizes.eq(numbers("/cases/friction_force")));
    let along = numbers("/cases/largest_displacement_along");
    let largest = numbers("/cases/largest_displacement");
    for (along, largest) in along.as_chunks::<3>().0.iter().zip(largest) {
        // No node moves less than along an axis, nor more than all largest motions together.
        let [x, y, z] = *along;
        assert!(largest >= x.max(y).max(z) && largest <= x.hypot(y).hypot(z));
    }
}

/// What a spreadsheet would compute is a text, and what a terminal would obey is seen.
#[test]
fn axis_values_are_texts_in_the_table() {
    let sweep = Sweep::new(
        "[set]\n\"body.brick.cells\" = [6, 2, 2]\n[[axis]]\nkey = \"title\"\n\
         values = [\"=1+1\", \"+1\", \"-1\", \"@a\", \"\\u001b]0;x\\u0007\", \"plain\"]\n\
         [[axis]]\nkey = \"traction.0.value.0\"\nvalues = [-1e7]",
    );
    let (code, said) = sweep.run("out", &[]);
    assert_eq!(code, 0, "{said}");
    let table = fs::read_to_string(sweep.path("out/summary.csv")).expect("a table");
    assert!(!table.contains(['\u{1b}', '\u{7}']) && !said.contains('\u{1b}'));
    for cell in ["'=1+1", "'+1", "'-1", "'@a", "\\u{1b}]0;x\\u{7}", "plain"] {
        assert!(
            table.contains(&format!(",{cell},-10000000.0,")),
            "{cell}: {table}"
        );
    }
}
