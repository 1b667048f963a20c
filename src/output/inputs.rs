//! The files that a command reads and may not overwrite.

use std::{
    fs, io,
    path::{Path, PathBuf},
};

use super::OutputError;

/// The files that a command reads; those that do not exist cannot be written over and are left out.
#[derive(Debug, Clone, Default)]
pub struct Inputs(Vec<(PathBuf, Identity)>);

/// What two paths to one file have in common, links followed.
#[derive(Debug, Clone, PartialEq, Eq)]
struct Identity {
    #[cfg(unix)]
    device_and_number: (u64, u64),
    #[cfg(not(unix))]
    path: PathBuf,
}

impl Identity {
    #[cfg(unix)]
    fn of(path: &Path) -> io::Result<Self> {
        use std::os::unix::fs::MetadataExt;
        let metadata = fs::metadata(path)?;
        Ok(Self {
            device_and_number: (metadata.dev(), metadata.ino()),
        })
    }

    #[cfg(not(unix))]
    fn of(path: &Path) -> io::Result<Self> {
        Ok(Self {
            path: fs::canonicalize(path)?,
        })
    }
}

impl Inputs {
    /// The files at some paths.
    pub fn of<P: AsRef<Path>>(paths: impl IntoIterator<Item = P>) -> Self {
        let mut inputs = Self::default();
        for path in paths {
            inputs.add(path.as_ref());
        }
        inputs
    }

    /// One more file.
    pub fn add(&mut self, path: &Path) {
        if let Ok(identity) = Identity::of(path) {
            self.0.push((path.to_owned(), identity));
        }
    }

    /// Refuses an output that is one of these files, by whatever path.
    pub fn refuse(&self, output: &Path) -> Result<(), OutputError> {
        let Ok(identity) = Identity::of(output) else {
            return Ok(());
        };
        match self.0.iter().find(|(_, input)| *input == identity) {
            None => Ok(()),
            Some((input, _)) => Err(OutputError::IsInput {
                file: output.to_owned(),
                input: input.clone(),
            }),
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn links_do_not_hide_an_input() {
        let folder = tempfile::tempdir().expect("scratch folder");
        let path = |name: &str| folder.path().join(name);
        fs::write(path("a"), "text").expect("a file");
        fs::write(path("other"), "text").expect("a file");
        fs::hard_link(path("a"), path("hard")).expect("a hard link");
        #[cfg(unix)]
        std::os::unix::fs::symlink(path("a"), path("soft")).expect("a symbolic link");
        let inputs = Inputs::of([path("a"), path("missing")]);
        for name in [
            "a",
            "hard",
            #[cfg(unix)]
            "soft",
        ] {
            let refused = inputs.refuse(&path(name));
            assert!(
                matches!(refused, Err(OutputError::IsInput { .. })),
                "{name}"
            );
        }
        for name in ["other", "missing"] {
            inputs.refuse(&path(name)).expect("no input");
        }
    }
}
