//! What cases share, and what must not depend on it.

use std::{fs, process::Command};

use assert_cmd::cargo::CommandCargoExt;
use contact3d_pipe::{LAYOUT, SWEEP_LAYOUT, Stage};
use runfile::Reader;

use crate::program::{FRICTION, Sweep, names, stage_digests};
#[test]
fn cases_share_the_files_of_mesh_and_factor() {
    let sweep = Sweep::new(FRICTION);
    let (code, text) = sweep.run("out", &[]);
    assert_eq!(code, 0, "{text}");
    let out = sweep.path("out");
    let shared = |stage: &str| {
        names(&out, ".h5")
            .iter()
            .filter(|n| n.starts_with(stage))
            .count()
    };
    assert_eq!((shared("mesh-"), shared("assemble-")), (1, 2));
    assert_eq!(names(&out, ".h5").len(), 8 + 3 + 1);
    let table = fs::read_to_string(out.join("summary.csv")).unwrap();
    assert_eq!(table.lines().count(), 9);
    assert_eq!(table.matches(",converged,").count(), 8);
    // The same case alone, without sharing, has the same solution and report.
    let plan = sweep.plan();
    for case in [&plan[2], &plan[7]] {
        let mut run = Command::cargo_bin("contact3d-pipe").unwrap();
        run.current_dir(sweep.path("")).args([
            "run",
            "scene.toml",
            "alone.h5",
            "--quiet",
            "--no-figures",
        ]);
        run.args(["--set", "body.brick.cells=[12,4,4]"]);
        for (key, value) in case["settings"].as_object().unwrap() {
            let value: toml::Value = serde_json::from_value(value.clone()).unwrap();
            run.args(["--set", &format!("{key}={value}")]);
        }
        assert!(run.status().unwrap().success());
        let file = out.join(format!("{}.h5", case["id"].as_str().unwrap()));
        assert_eq!(
            stage_digests(&file, LAYOUT),
            stage_digests(&sweep.path("alone.h5"), LAYOUT)
        );
    }
}

#[test]
fn number_of_jobs_and_self_containedness_change_no_digest() {
    let warm = format!("warm_start = true\n{FRICTION}");
    for text in [FRICTION, &warm] {
        let sweep = Sweep::new(text);
        assert_eq!(sweep.run("one", &["--jobs", "1", "--threads", "1"]).0, 0);
        assert_eq!(
            sweep.run("three", &["--jobs", "3", "--memory", "1e-9"]).0,
            0
        );
        assert_eq!(sweep.run("whole", &["--self-contained"]).0, 0);
        assert_eq!(sweep.digests("one"), sweep.digests("three"));
        assert_eq!(sweep.digests("one"), sweep.digests("whole"));
        let reader = |out: &str| {
            let name = format!("{}.h5", sweep.plan()[0]["id"].as_str().unwrap());
            Reader::open(&sweep.path(out).join(name), LAYOUT).unwrap()
        };
        assert!(reader("one").linked_file(Stage::Assemble.group()).is_some());
        assert!(
            reader("whole")
                .linked_file(Stage::Assemble.group())
                .is_none()
        );
    }
}

#[test]
fn warm_starts_need_fewer_steps_and_agree_with_cold_ones() {
    let text = r#"
[set]
"body.brick.cells" = [12, 4, 4]
"solve.method" = "fixed-point"
"solve.epsilon" = 1e-7
"solve.precision" = "fixed"
[[axis]]
key = "friction.coefficient_1.ramp.residual"
values = [0.2, 0.201, 0.202, 0.203]
"#;
    let results = |text: &str| {
        let sweep = Sweep::new(text);
        assert_eq!(sweep.run("out", &[]).0, 0);
        let reader = Reader::open(&sweep.path("out/summary.h5"), SWEEP_LAYOUT).unwrap();
        let applications: i64 = reader
            .read_vec::<i64>("/cases/applications")
            .unwrap()
            .iter()
            .sum();
        (
            applications,
            reader.read_vec::<f64>("/cases/normal_force").unwrap(),
        )
    };
    let (cold, cold_force) = results(text);
    let (warm, warm_force) = results(&format!("warm_start = true\n{text}"));
    assert!(warm < cold, "{warm} applications instead of {cold}");
    for (a, b) in warm_force.iter().zip(&cold_force) {
        // ε = 1e-7 for both, times the contraction of the outer loop and the condition of S.
        assert!((a / b - 1.0).abs() < 1e-5, "{a} {b}");
    }
}

/// Displacements of clamps are loads: all values share one mesh and one factor, and give what a run alone gives.
#[test]
fn prescribed_displacements_share_one_factor() {
    let sweep = Sweep::new(
        "[set]\n\"body.brick.cells\" = [6, 2, 2]\ntraction = []\n\
         clamp = [{ face = \"z_max\", value = [0.0, 0.0, -3e-5] }]\n\
         [[axis]]\nkey = \"clamp.0.value.2\"\nvalues = [0.0, -1e-5, -2e-5]\n",
    );
    let (code, text) = sweep.run("out", &[]);
    assert_eq!(code, 0, "{text}");
    let files = names(&sweep.path("out"), ".h5");
    let shared = |stage: &str| files.iter().filter(|n| n.starts_with(stage)).count();
    assert_eq!((shared("mesh-"), shared("assemble-")), (1, 1));
    // Twice the displacement of a face without gap is twice the force.
    let forces: Vec<f64> = sweep
        .plan()
        .iter()
        .map(|case| {
            let file = format!("{}.h5", case["id"].as_str().unwrap());
            let reader = Reader::open(&sweep.path("out").join(file), LAYOUT).unwrap();
            reader.read_vec::<f64>("/post/forces/force").unwrap()[2]
        })
        .collect();
    assert_eq!(forces[0], 0.0);
    // Frictional slip scales with the displacement, and the law's slips do not: a per cent or so.
    assert!(
        forces[1] < 0.0 && (forces[2] / forces[1] / 2.0 - 1.0).abs() < 0.05,
        "{forces:?}"
    );
}
