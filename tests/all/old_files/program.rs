//! The program in a scratch folder with copies of fixtures.

use std::{
    fs,
    path::{Path, PathBuf},
    process::Output,
};

use assert_cmd::Command;
use tempfile::TempDir;

/// A file or folder of `tests/fixtures`.
pub(crate) fn fixture(name: &str) -> PathBuf {
    Path::new(env!("CARGO_MANIFEST_DIR"))
        .join("tests/fixtures")
        .join(name)
}

pub(crate) struct Scratch {
    folder: TempDir,
}

impl Scratch {
    /// A folder with copies of some fixtures, folders with all that is in them.
    pub(crate) fn with(names: &[&str]) -> Self {
        let folder = TempDir::new().expect("scratch folder");
        for name in names {
            let from = fixture(name);
            copy(
                &from,
                &folder.path().join(from.file_name().expect("a name")),
            );
        }
        Self { folder }
    }

    pub(crate) fn path(&self, name: &str) -> PathBuf {
        self.folder.path().join(name)
    }

    pub(crate) fn run(&self, arguments: &[&str]) -> Output {
        let mut command = Command::cargo_bin("contact3d-pipe").expect("built program");
        let command = command.current_dir(self.folder.path()).args(arguments);
        command.output().expect("a process")
    }

    /// Runs a command that must end well; returns all that it said.
    pub(crate) fn done(&self, arguments: &[&str]) -> String {
        let output = self.run(arguments);
        let text = [output.stderr, output.stdout].concat();
        let text = String::from_utf8_lossy(&text).into_owned();
        assert_eq!(output.status.code(), Some(0), "{arguments:?}: {text}");
        text
    }
}

fn copy(from: &Path, to: &Path) {
    if from.is_dir() {
        fs::create_dir(to).expect("a folder");
        for entry in fs::read_dir(from).expect("a folder") {
            let entry = entry.expect("an entry");
            copy(&entry.path(), &to.join(entry.file_name()));
        }
    } else {
        fs::copy(from, to).expect("a copy");
    }
}
