//! What the program advises after a failed solve helps on the case that prints it.

use serde_json::Value;

use crate::program::{Program, SMALL, pipeline};

/// A scene, the settings with which it fails, and the status it fails with.
type Failure = (&'static str, &'static [&'static str], &'static str);

const FAILURES: [Failure; 5] = [
    (
        "hkl2011_table1.toml",
        &[
            SMALL[1],
            "solve.method=\"fixed-point\"",
            "solve.max_operator_applications=5",
        ],
        "max_operator_applications",
    ),
    (
        "hkl2011_table1.toml",
        &[
            SMALL[1],
            "solve.method=\"fixed-point\"",
            "solve.max_outer_steps=2",
        ],
        "max_outer_steps",
    ),
    (
        "hard/one_node.toml",
        &[
            "solve.method=\"fixed-point\"",
            "traction.0.value=[-4e-3,0.0,-1e-3]",
        ],
        "cycling",
    ),
    (
        "hard/soft_block.toml",
        &["solve.method=\"fixed-point\"", "solve.epsilon=1e-4"],
        "inaccurate",
    ),
    (
        "hard/soft_block.toml",
        &[
            "solve.method=\"fixed-point\"",
            "solve.inner=\"gpcg\"",
            "solve.epsilon=1e-4",
        ],
        "inaccurate",
    ),
];

#[test]
fn advice_after_a_failed_solve_helps() {
    for (scene, settings, status) in FAILURES {
        let program = Program::new();
        let scene = pipeline(scene);
        let run = |more: &[String]| {
            let mut command = program.command(&["run"]);
            command
                .arg(&scene)
                .args(["run.h5", "--no-figures", "--json"]);
            for setting in settings
                .iter()
                .map(ToString::to_string)
                .chain(more.to_vec())
            {
                command.args(["--set", &setting]);
            }
            command.output().expect("the program runs")
        };
        let failed = run(&[]);
        let said = String::from_utf8_lossy(&failed.stderr).into_owned();
        assert_eq!(failed.status.code(), Some(1), "{said}");
        let results: Value = serde_json::from_slice(&failed.stdout).expect("JSON");
        assert_eq!(results["status"], status, "{said}");
        let last = said.lines().last().expect("a last line");
        let helps = |more: &[String]| {
            let helped = run(more);
            let said = String::from_utf8_lossy(&helped.stderr).into_owned();
            assert_eq!(helped.status.code(), Some(0), "{last}\n{said}");
        };
        if let Some(advised) = last.split("choose ").nth(1) {
            // The line reads `choose KEY = VALUE with KEY = VALUE`, as a scene would.
            let settings = advised.split(" with ");
            helps(
                &settings
                    .map(|s| s.trim().replace(" = ", "="))
                    .collect::<Vec<_>>(),
            );
        } else {
            let key = last.split("raise ").nth(1).expect("advice");
            helps(&[format!("{}=100000", key.trim())]);
        }
    }
}

/// Newton's method stopped one step early at a loose ε and said that it had run out of steps.
#[test]
fn a_loose_epsilon_is_reached() {
    for epsilon in ["1e-2", "1e-3"] {
        let program = Program::new();
        let set = format!("solve.epsilon={epsilon}");
        program
            .run(&["--set", "solve.method=\"auto\"", "--set", &set])
            .assert()
            .success();
    }
}
