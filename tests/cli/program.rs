//! Running the program in a scratch folder.

use std::{
    collections::BTreeMap,
    fs,
    path::{Path, PathBuf},
};

use assert_cmd::Command;
use serde_json::Value;
use tempfile::TempDir;

/// A small scene: table 1 on 12 × 4 × 4 cells.
pub(crate) const SMALL: [&str; 2] = ["--set", "body.brick.cells=[12,4,4]"];

/// A scratch folder with the program.
pub(crate) struct Program {
    folder: TempDir,
}

impl Program {
    pub(crate) fn new() -> Self {
        Self {
            folder: TempDir::new().expect("scratch folder"),
        }
    }

    pub(crate) fn path(&self, name: &str) -> PathBuf {
        self.folder.path().join(name)
    }

    /// All files and folders of the scratch folder, hidden ones too, with the contents of files;
    /// the lock files of run files that are there are left out.
    pub(crate) fn everything(&self) -> BTreeMap<String, Option<Vec<u8>>> {
        let mut found = BTreeMap::new();
        let mut folders = vec![self.folder.path().to_owned()];
        while let Some(folder) = folders.pop() {
            for entry in fs::read_dir(&folder).expect("a folder") {
                let path = entry.expect("an entry").path();
                let name = path.strip_prefix(self.folder.path()).expect("inside");
                let name = name.to_string_lossy().into_owned();
                if path.is_dir() && !path.is_symlink() {
                    folders.push(path);
                    found.insert(name, None);
                } else if !is_lock_of_a_file(&path) {
                    found.insert(name, fs::read(&path).ok());
                }
            }
        }
        found
    }

    /// The temporary files of the scratch folder.
    pub(crate) fn hidden(&self) -> Vec<String> {
        let names = self.everything().into_keys();
        names.filter(|name| name.contains(".part")).collect()
    }

    /// The program with its arguments, run in the scratch folder.
    pub(crate) fn command(&self, arguments: &[&str]) -> Command {
        let mut command = Command::cargo_bin("contact3d-pipe").expect("built program");
        command.current_dir(self.folder.path()).args(arguments);
        command
    }

    /// Runs a scene to `run.h5` without pictures.
    pub(crate) fn run(&self, more: &[&str]) -> Command {
        let scene = pipeline("hkl2011_table1.toml");
        let scene = scene.to_str().expect("plain path");
        let mut command = self.command(&["run", scene, "run.h5", "--no-figures", "-v"]);
        command.args(SMALL).args(more);
        command
    }

    /// The status of `run.h5` as JSON.
    pub(crate) fn status(&self) -> Value {
        let output = self
            .command(&["status", "run.h5", "--json"])
            .output()
            .expect("status");
        assert!(
            output.status.success(),
            "{}",
            String::from_utf8_lossy(&output.stderr)
        );
        serde_json::from_slice(&output.stdout).expect("JSON")
    }

    /// (stage, fresh / stale / missing) of `run.h5`.
    pub(crate) fn states(&self) -> Vec<(String, String)> {
        let status = self.status();
        let stages = status["stages"].as_array().expect("stages").iter();
        let word = |value: &Value| value.as_str().expect("text").to_owned();
        stages
            .map(|s| (word(&s["stage"]), word(&s["state"])))
            .collect()
    }

    /// The digest of every stage of `run.h5`.
    pub(crate) fn digests(&self) -> Vec<Value> {
        let status = self.status();
        status["stages"]
            .as_array()
            .expect("stages")
            .iter()
            .map(|s| s["digest"].clone())
            .collect()
    }
}

fn is_lock_of_a_file(path: &Path) -> bool {
    let name = path.file_name().unwrap_or_default().to_string_lossy();
    let locked = name.strip_prefix('.').and_then(|n| n.strip_suffix(".lock"));
    locked.is_some_and(|locked| path.with_file_name(locked).exists())
}

/// A file of `pipelines/`.
pub(crate) fn pipeline(name: &str) -> PathBuf {
    Path::new(env!("CARGO_MANIFEST_DIR"))
        .join("pipelines")
        .join(name)
}
