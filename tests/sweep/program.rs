//! A sweep in a folder of its own, run by the program.

use std::{
    collections::BTreeMap,
    fs,
    path::{Path, PathBuf},
    process::{Command, Stdio},
};

use assert_cmd::cargo::CommandCargoExt;
use contact3d_pipe::{CHECKPOINT, HISTORY, LAYOUT, SWEEP_LAYOUT, Stage};
use runfile::{Layout, Reader};
use tempfile::TempDir;

/// A folder with a scene and a sweep over it.
pub(crate) struct Sweep {
    pub(crate) folder: TempDir,
}

impl Sweep {
    pub(crate) fn new(sweep: &str) -> Self {
        let folder = TempDir::new().expect("scratch folder");
        let scene = Path::new(env!("CARGO_MANIFEST_DIR")).join("pipelines/newton.toml");
        fs::copy(scene, folder.path().join("scene.toml")).expect("a scene");
        let this = Self { folder };
        this.write(sweep);
        this
    }

    /// Replaces the sweep file.
    pub(crate) fn write(&self, sweep: &str) {
        let text = format!("scene = \"scene.toml\"\n{sweep}");
        fs::write(self.path("sweep.toml"), text).expect("a sweep file");
    }

    pub(crate) fn path(&self, name: &str) -> PathBuf {
        self.folder.path().join(name)
    }

    pub(crate) fn command(&self, arguments: &[&str]) -> Command {
        let mut command = self.program();
        command.arg("sweep").args(arguments);
        command
    }

    fn program(&self) -> Command {
        let mut command = Command::cargo_bin("contact3d-pipe").expect("built program");
        let command_in = command.current_dir(self.folder.path());
        command_in.stderr(Stdio::piped()).stdout(Stdio::piped());
        command
    }

    /// What another command says that succeeds.
    pub(crate) fn said(&self, arguments: &[&str]) -> String {
        let output = self.program().args(arguments).output().expect("a process");
        let text = String::from_utf8_lossy(&output.stdout).into_owned();
        assert!(output.status.success(), "{arguments:?}: {text}");
        text
    }

    /// Runs the sweep to a folder and returns its exit code and what it said.
    pub(crate) fn run(&self, out: &str, more: &[&str]) -> (i32, String) {
        let mut arguments = vec!["sweep.toml", out];
        arguments.extend(more);
        let output = self.command(&arguments).output().expect("a process");
        let said = [output.stderr, output.stdout].concat();
        let text = String::from_utf8_lossy(&said).into_owned();
        (output.status.code().expect("an exit code"), text)
    }

    pub(crate) fn plan(&self) -> Vec<serde_json::Value> {
        let output = self.command(&["plan", "sweep.toml", "x"]).output();
        let output = output.expect("a process");
        serde_json::from_slice(&output.stdout).expect("JSON")
    }

    /// Whether a run file holds a half-done solve: a checkpoint, or increments of a history without its end.
    pub(crate) fn has_checkpoint(&self, out: &str) -> bool {
        let folder = self.path(out);
        let files = if folder.exists() {
            names(&folder, ".h5")
        } else {
            Vec::new()
        };
        files.iter().any(|name| {
            let reader = Reader::open(&folder.join(name), LAYOUT);
            reader.is_ok_and(|r| {
                let has = |group| matches!(r.group_record(group), Ok(Some(_)));
                has(CHECKPOINT) || has(HISTORY) && !has(Stage::Solve.group())
            })
        })
    }

    /// The digest of every stage of every run file, and of the table.
    pub(crate) fn digests(&self, out: &str) -> BTreeMap<String, Vec<String>> {
        let mut digests = BTreeMap::new();
        for name in names(&self.path(out), ".h5") {
            if !name.contains('-') {
                let layout = if name == "summary.h5" {
                    SWEEP_LAYOUT
                } else {
                    LAYOUT
                };
                let file = self.path(out).join(&name);
                digests.insert(name, stage_digests(&file, layout));
            }
        }
        digests
    }
}

/// Digests of all stages, each checked against the digests of its datasets.
pub(crate) fn stage_digests(file: &Path, layout: Layout) -> Vec<String> {
    let reader = Reader::open(file, layout).expect("a whole file");
    let held = layout
        .groups()
        .filter(|s| matches!(reader.group_record(*s), Ok(Some(_))));
    held.map(|group| {
        let stored = reader.require_group(group).expect("a sound stage");
        format!("{group} {}", stored.digest)
    })
    .collect()
}

pub(crate) fn names(folder: &Path, ending: &str) -> Vec<String> {
    let entries = fs::read_dir(folder).expect("a folder");
    let names = entries.map(|entry| entry.unwrap().file_name().into_string().unwrap());
    names.filter(|name| name.ends_with(ending)).collect()
}

/// Two laws (one needs the contact compliance), two loads, two coefficients; small meshes.
pub(crate) const FRICTION: &str = r#"
[set]
"body.brick.cells" = [12, 4, 4]
[[axis]]
key = "friction.coefficient_2"
values = [{ constant = 0.3 }, { ramp = { initial = 0.3, residual = 0.2, onset = 1e-5, rate = 1000.0 } }]
[[axis]]
key = "traction.0.value"
values = [[1e7, 0.0, 2e7], [9e6, 3e6, 2e7]]
[[axis]]
key = "friction.coefficient_1"
values = [{ constant = 0.1 }, { constant = 0.9 }]
"#;

/// Successive approximations with KPRGP to many digits: solves that last long enough to be killed.
pub(crate) const SLOW: &str = r#"
[set]
"body.brick.cells" = [12, 4, 4]
"solve.method" = "fixed-point"
"solve.epsilon" = 1e-9
"solve.precision" = "fixed"
[[axis]]
key = "assemble.dual_operator"
values = ["implicit", "explicit"]
"#;

/// A long and a short history; the long one is stored before it ends.
pub(crate) const STEPPED: &str = r#"
[set]
"body.brick.cells" = [6, 2, 2]
[[axis]]
key = "step"
values = [
    [{ factor = { "traction.0" = 0.0 } }, { factor = { "traction.0" = 1.0 }, increments = 1500 }],
    [{ factor = { "traction.0" = 0.5 } }, { factor = { "traction.0" = -0.5 }, increments = 3 }],
]
"#;
