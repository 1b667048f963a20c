//! Numbers that double precision does not hold: no answer with such figures passes as converged.

use contact3d_pipe::LAYOUT;
use runfile::Reader;
use serde_json::Value;

use crate::program::{Program, SMALL, pipeline};

/// Runs a scene with changes, `newton.toml` on 12 × 4 × 4 cells; exit code, JSON and messages.
fn run(program: &Program, changes: &[&str]) -> (Option<i32>, Value, String) {
    let scene = pipeline("newton.toml");
    let arguments = [
        "run",
        scene.to_str().unwrap(),
        "run.h5",
        "--no-figures",
        "--json",
    ];
    let mut command = program.command(&arguments);
    command.args(SMALL);
    for change in changes {
        command.args(["--set", change]);
    }
    let output = command.output().unwrap();
    let text = String::from_utf8_lossy(&output.stderr).into_owned();
    let json = serde_json::from_slice(&output.stdout);
    (output.status.code(), json.unwrap_or_default(), text)
}

#[test]
fn figures_that_overflow_or_underflow_are_a_failed_solve() {
    let cases: [&[&str]; 7] = [
        &["material.isotropic.young_modulus=1e-200"],
        &["material.isotropic.young_modulus=1e300"],
        &["body.brick.size=[3e60,1e60,1e60]"],
        &["traction=[{face=\"x_max\",value=[1e200,0,-1e200]}]"],
        &["traction=[{face=\"x_max\",value=[1e-200,0,-1e-200]}]"],
        &["traction=[{face=\"x_max\",value=[1e-320,0,-1e-320]}]"],
        &["body_force.value=[1e308,0,0]"],
    ];
    for changes in cases {
        let program = Program::new();
        let (code, json, text) = run(&program, changes);
        assert_eq!(code, Some(1), "{changes:?}: {text}");
        assert_eq!(json["status"], "numerical_error", "{changes:?}");
        assert!(text.contains("NOT CONVERGED: the "), "{changes:?}: {text}");
        // Stored with that status, and said again.
        let reader = Reader::open(&program.path("run.h5"), LAYOUT).unwrap();
        let (status, _) = contact3d_pipe::read_multiplier(&reader).unwrap();
        assert_eq!(status.word(), "numerical_error", "{changes:?}");
        let again = program.command(&["post", "run.h5", "--no-figures"]);
        { again }.assert().code(1);
    }
}

/// What overflows before a solve can begin is refused, whichever way the dual operator is held.
#[test]
fn assembled_numbers_that_overflow_are_refused() {
    let implicit = "assemble.dual_operator=\"implicit\"";
    let cases: [&[&str]; 4] = [
        &["material.isotropic.young_modulus=1e-308"],
        &["material.isotropic.young_modulus=1e-308", implicit],
        &["body.brick.size=[1e100,1e100,1e100]"],
        &[
            "pressure=[{face=\"z_max\",value=1e308}]",
            "body.brick.size=[30,30,30]",
        ],
    ];
    for changes in cases {
        let (code, _, text) = run(&Program::new(), changes);
        assert_eq!(code, Some(2), "{changes:?}: {text}");
        assert!(text.contains("not finite"), "{changes:?}: {text}");
        assert!(text.contains("choose units"), "{changes:?}: {text}");
    }
}

/// Pictures, report, status and sweeps tell of a failed solve instead of failing themselves.
#[test]
fn a_failed_solve_is_told_everywhere() {
    let program = Program::new();
    let scene = pipeline("newton.toml");
    let size = "body.brick.size=[3e60,1e60,1e60]";
    let mut run = program.command(&["run", scene.to_str().unwrap(), "run.h5"]);
    let failed = run.args(SMALL).args(["--set", size]).assert().code(1);
    let text = String::from_utf8_lossy(&failed.get_output().stderr).into_owned();
    assert!(text.contains("figures   none"), "{text}");
    for arguments in [
        &["status", "run.h5"][..],
        &["check", "run.h5"],
        &["report", "run.h5"],
    ] {
        program.command(arguments).assert().success();
    }
    let page = std::fs::read_to_string(program.path("report.html")).unwrap();
    assert!(page.contains("The solve failed and nothing is drawn"));
    std::fs::copy(scene, program.path("scene.toml")).unwrap();
    let sweep = format!(
        "scene = \"scene.toml\"\n[set]\n\"body.brick.cells\" = [12, 4, 4]\n\
         [[axis]]\nkey = \"body.brick.size\"\nvalues = [[3.0, 1.0, 1.0], {}]\n",
        size.split_once('=').unwrap().1
    );
    std::fs::write(program.path("sweep.toml"), sweep).unwrap();
    let sweep = program.command(&["sweep", "sweep.toml", "out"]);
    let done = { sweep }.assert().code(1);
    let text = String::from_utf8_lossy(&done.get_output().stdout).into_owned();
    assert!(
        text.contains("2 computed") && text.contains("1 not converged"),
        "{text}"
    );
    let csv = std::fs::read_to_string(program.path("out/summary.csv")).unwrap();
    assert!(csv.contains("numerical_error"), "{csv}");
    program.command(&["report", "out"]).assert().success();
}

#[test]
fn a_body_whose_volume_overflows_or_vanishes_is_refused() {
    for size in ["1e103", "1e-103"] {
        let program = Program::new();
        let size = format!("body.brick.size=[{size},{size},{size}]");
        let (code, _, text) = run(&program, &[&size]);
        assert_eq!(code, Some(2), "{text}");
        assert!(
            text.contains("body.brick.size") && text.contains("volume"),
            "{text}"
        );
        assert!(!program.path("run.h5").exists());
    }
}

#[test]
fn only_the_direction_of_axis_1_counts() {
    let program = Program::new();
    let expected = run(&program, &["contact.axis_1=[1,0,0]"]).1;
    assert!(
        expected["tangential_force"][0].as_f64().unwrap().abs() > 1e6,
        "{expected}"
    );
    for axis in ["1e200", "1e-200", "1e-320", "1.7e308"] {
        let (code, json, text) = run(&program, &[&format!("contact.axis_1=[{axis},0,0]")]);
        assert_eq!(code, Some(0), "{text}");
        assert_eq!(
            json["tangential_force"], expected["tangential_force"],
            "{axis}"
        );
        assert_eq!(json["stick"], expected["stick"], "{axis}");
    }
    let (code, _, text) = run(&program, &["contact.axis_1=[1e300,0,1e300]"]);
    assert_eq!(code, Some(2), "{text}");
    assert!(text.contains("contact.axis_1"), "{text}");
}

/// Small and large units of ordinary problems stay solvable.
#[test]
fn ordinary_ranges_converge() {
    for change in [
        "material.isotropic.young_modulus=1e-100",
        "material.isotropic.young_modulus=1e130",
        "body.brick.size=[3e-9,1e-9,1e-9]",
    ] {
        let (code, json, text) = run(&Program::new(), &[change]);
        assert_eq!(code, Some(0), "{change}: {text}");
        assert_eq!(json["status"], "converged", "{change}");
    }
}
