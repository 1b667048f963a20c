//! Failed cases, changed axes, changed files.

use std::fs;

use contact3d_pipe::SWEEP_LAYOUT;
use runfile::Reader;

use crate::program::{FRICTION, Sweep, names};
#[test]
fn failed_cases_are_recorded_and_tried_again_only_on_demand() {
    let text = "[set]\n\"body.brick.cells\" = [12, 4, 4]\n[[axis]]\nkey = \"body_force\"\nvalues = \
                [{ value = [0.0, 0.0, 0.0] }, { value = [\"1/(x-x)\", 0.0, 0.0] }, { value = [0.0, 0.0, 1e8] }]";
    let sweep = Sweep::new(text);
    let (code, said) = sweep.run("out", &[]);
    assert_eq!(code, 1, "{said}");
    assert!(said.contains("2 computed, 0 kept, 1 failed"), "{said}");
    // The last one is lifted off.
    let lifted = said
        .split_once("warnings of solutions")
        .expect("warnings")
        .1;
    assert!(
        lifted.contains("100000000.0") && lifted.contains("no pane is in contact"),
        "{said}"
    );
    let table = fs::read_to_string(sweep.path("out/summary.csv")).unwrap();
    assert!(
        table.contains("failed") && table.contains("finite"),
        "{table}"
    );
    let stamp = |id: &str| {
        fs::metadata(sweep.path(&format!("out/{id}.error.txt")))
            .unwrap()
            .modified()
            .unwrap()
    };
    let failed = sweep.plan()[1]["id"].as_str().unwrap().to_owned();
    let first = stamp(&failed);
    let (_, said) = sweep.run("out", &[]);
    assert!(said.contains("0 computed, 2 kept, 1 failed"), "{said}");
    assert_eq!(stamp(&failed), first);
    let (_, said) = sweep.run("out", &["--retry-failed"]);
    assert!(said.contains("0 computed, 2 kept, 1 failed"), "{said}");
    assert!(stamp(&failed) > first);
}

/// A write-protected file is no fault of its case: the next run does not count it as failed.
#[test]
fn cases_that_the_machine_refuses_are_tried_again() {
    let sweep = Sweep::new(
        "[set]\n\"body.brick.cells\" = [12, 4, 4]\n[[axis]]\nkey = \"friction.coefficient_1\"\n\
         values = [{ constant = 0.1 }, { constant = 0.2 }]",
    );
    assert_eq!(sweep.run("out", &[]).0, 0);
    // Without the files that they share the cases have to be computed again.
    let out = sweep.path("out");
    for shared in names(&out, ".h5").iter().filter(|name| name.contains('-')) {
        fs::remove_file(out.join(shared)).unwrap();
    }
    let case = sweep.plan()[0]["id"].as_str().unwrap().to_owned();
    let file = sweep.path(&format!("out/{case}.h5"));
    let writable = fs::metadata(&file).unwrap().permissions();
    let mut protected = writable.clone();
    protected.set_readonly(true);
    fs::set_permissions(&file, protected).unwrap();
    // One after the other: beside another case that makes the shared files first, the protected file need not be written.
    let (code, said) = sweep.run("out", &["--jobs", "1"]);
    assert!(
        code == 1 && said.contains("1 computed, 0 kept, 1 failed"),
        "{said}"
    );
    fs::set_permissions(&file, writable).unwrap();
    let (code, said) = sweep.run("out", &[]);
    // The other case has made the shared files again.
    assert!(code == 0 && said.contains("2 kept, 0 failed"), "{said}");
}

#[test]
fn changed_axes_add_cases_and_keep_old_ones() {
    let axis = |values: &str| {
        format!(
            "[set]\n\"body.brick.cells\" = [12, 4, 4]\n[[axis]]\nkey = \"friction.coefficient_1\"\nvalues = [{values}]"
        )
    };
    let sweep = Sweep::new(&axis("{ constant = 0.1 }, { constant = 0.2 }"));
    assert_eq!(sweep.run("out", &[]).0, 0);
    let before = sweep.digests("out");
    sweep.write(&axis("{ constant = 0.2 }, { constant = 0.3 }"));
    let (code, said) = sweep.run("out", &[]);
    assert_eq!(code, 0, "{said}");
    assert!(said.contains("1 computed, 1 kept"), "{said}");
    let after = sweep.digests("out");
    for (name, digests) in before.iter().filter(|(name, _)| *name != "summary.h5") {
        assert_eq!(after.get(name), Some(digests), "{name}");
    }
    let reader = Reader::open(&sweep.path("out/summary.h5"), SWEEP_LAYOUT).unwrap();
    assert_eq!(reader.read_vec::<u8>("/cases/planned").unwrap(), [1, 1, 0]);
}

#[test]
fn single_cases_give_the_files_of_the_whole_sweep() {
    let text = format!("warm_start = true\n{FRICTION}");
    let sweep = Sweep::new(&text);
    assert_eq!(sweep.run("whole", &[]).0, 0);
    for case in sweep.plan().iter().rev() {
        let id = case["id"].as_str().unwrap();
        let run = sweep
            .command(&["run-case", "sweep.toml", "parts", id])
            .output()
            .unwrap();
        assert!(run.status.success(), "{run:?}");
    }
    let summary = sweep
        .command(&["summary", "sweep.toml", "parts"])
        .output()
        .unwrap();
    assert!(summary.status.success());
    assert_eq!(sweep.digests("parts"), sweep.digests("whole"));
    let unknown = sweep
        .command(&["run-case", "sweep.toml", "parts", "0123"])
        .output()
        .unwrap();
    assert_eq!(unknown.status.code(), Some(2));
}

#[test]
fn a_case_is_redone_when_the_one_it_started_from_has_changed() {
    let text = format!("warm_start = true\n{FRICTION}");
    let sweep = Sweep::new(&text);
    assert_eq!(sweep.run("whole", &[]).0, 0);
    let plan = sweep.plan();
    let file = |case: &serde_json::Value| {
        let id = case["id"].as_str().unwrap();
        sweep.path("out").join(format!("{id}.h5"))
    };
    // A folder in the place of a run file makes its case fail; the next one starts from zero then.
    fs::create_dir_all(file(&plan[0])).unwrap();
    let (code, said) = sweep.run("out", &[]);
    assert_eq!(code, 1, "{said}");
    fs::remove_dir(file(&plan[0])).unwrap();
    let (code, said) = sweep.run("out", &["--retry-failed"]);
    assert_eq!(code, 0, "{said}");
    let redone = plan.iter().take(2).collect::<Vec<_>>();
    assert_eq!(redone[1]["start"], redone[0]["id"]);
    assert_eq!(sweep.digests("out"), sweep.digests("whole"), "{said}");
    assert!(sweep.run("out", &[]).1.contains("0 computed"));
}

#[test]
fn an_altered_shared_file_is_made_again() {
    let sweep = Sweep::new(FRICTION);
    assert_eq!(sweep.run("out", &[]).0, 0);
    let before = sweep.digests("out");
    let out = sweep.path("out");
    let assembled = |name: &String| name.starts_with("assemble-");
    let shared = names(&out, ".h5").into_iter().find(assembled).unwrap();
    let mut bytes = fs::read(out.join(&shared)).unwrap();
    // The factor's values are most of the file, uncompressed.
    let middle = bytes.len() / 2;
    bytes[middle] ^= 1;
    fs::write(out.join(&shared), bytes).unwrap();
    for case in sweep.plan() {
        fs::remove_file(out.join(format!("{}.h5", case["id"].as_str().unwrap()))).unwrap();
    }
    let (code, said) = sweep.run("out", &[]);
    assert_eq!(code, 0, "{said}");
    assert_eq!(sweep.digests("out"), before);
}

#[test]
fn unusable_sweeps_are_refused_before_anything_is_run() {
    for (text, word) in [
        (
            "[[axis]]\nkey = \"solve.epsilon\"\nvalues = [1e-6, 1e-6]",
            "every case once",
        ),
        (
            "[[axis]]\nkey = \"solve.epsilon\"\nvalues = [-1.0]",
            "epsilon",
        ),
        (
            "[[axis]]\nkey = \"solve.epsilom\"\nvalues = [1e-6]",
            "epsilom",
        ),
        (
            "[[axis]]\nkey = \"traction.7.value\"\nvalues = [1.0]",
            "no item 7",
        ),
        ("axes = 3", "axes"),
    ] {
        let sweep = Sweep::new(text);
        let (code, said) = sweep.run("out", &[]);
        assert_eq!(code, 2, "{said}");
        assert!(said.contains(word), "{said}");
        assert!(!sweep.path("out").exists());
    }
}

/// A sweep counts a case at machine precision as `run` would: as done, unless its ε was asked for by name.
#[test]
fn an_accuracy_below_rounding_counts_as_not_converged_where_it_was_asked_for() {
    let cells = "[set]\n\"body.brick.cells\" = [12, 4, 4]\n\"solve.method\" = \"newton\"\n";
    let asked = "[[axis]]\nkey = \"solve.epsilon\"\nvalues = [1e-6, 1e-17]";
    let sweep = Sweep::new(&format!("{cells}{asked}"));
    let (code, said) = sweep.run("out", &[]);
    assert_eq!(code, 1, "{said}");
    assert!(said.contains("2 computed, 0 kept, 0 failed"), "{said}");
    assert!(said.contains("1 not converged"), "{said}");
    let table = fs::read_to_string(sweep.path("out/summary.csv")).unwrap();
    assert!(table.contains("machine_precision"), "{table}");
}
