//! Folders for outputs, claimed before anything is computed.

use std::{
    fs::{self, File},
    io,
    path::{Path, PathBuf},
};

use runfile::is_still_at;

use super::OutputError;

/// Written and removed to see whether a folder takes files.
const PROBE: &str = ".contact3d-pipe.part";

/// How often a folder is made that another process removes at the same moment.
const ATTEMPTS: usize = 16;

/// A folder that is there and takes files. What was made for it vanishes again when this is dropped,
/// nothing was put there and no other process has claimed it meanwhile.
#[derive(Debug)]
pub struct Folder {
    path: PathBuf,
    /// The folders that were made, the innermost last.
    made: Vec<PathBuf>,
    /// The open folder with a shared lock, where the system knows such; only the last of those who share it removes it.
    held: Option<File>,
}

impl Folder {
    /// Makes a folder, with those around it, unless it is there.
    pub fn make(path: &Path) -> Result<Self, OutputError> {
        let path = if path.as_os_str().is_empty() {
            Path::new(".")
        } else {
            path
        };
        let mut folder = Self {
            path: path.to_owned(),
            made: Vec::new(),
            held: None,
        };
        let refuse = |source: io::Error| OutputError::Folder {
            folder: path.to_owned(),
            found: if path.exists() && !path.is_dir() {
                "a file".to_owned()
            } else {
                source.to_string()
            },
        };
        let mut claims = (0..ATTEMPTS).map(|_| folder.claim());
        let is_removed =
            |claim: &io::Result<()>| matches!(claim, Err(e) if e.kind() == io::ErrorKind::NotFound);
        let claimed = claims.find(|claim| !is_removed(claim));
        claimed
            .unwrap_or_else(|| Err(io::ErrorKind::NotFound.into()))
            .map_err(refuse)?;
        let probe = path.join(PROBE);
        let probed = File::options().write(true).create_new(true).open(&probe);
        // Another process may be at the same.
        let _ = fs::remove_file(&probe);
        match probed {
            Err(error) if error.kind() != io::ErrorKind::AlreadyExists => Err(refuse(error)),
            _ => Ok(folder),
        }
    }

    /// Makes what is missing, and shares the folder with whoever has claimed it; `NotFound` if another process has just
    /// removed it.
    fn claim(&mut self) -> io::Result<()> {
        let missing: Vec<&Path> = self
            .path
            .ancestors()
            .take_while(|folder| !folder.as_os_str().is_empty() && !folder.exists())
            .collect();
        for missing in missing.into_iter().rev() {
            match fs::create_dir(missing) {
                Ok(()) => self.made.push(missing.to_owned()),
                Err(error) if error.kind() == io::ErrorKind::AlreadyExists && missing.is_dir() => {}
                Err(error) => return Err(error),
            }
        }
        if cfg!(unix) {
            let held = File::open(&self.path)?;
            // A file system without locks has nobody who waits for one.
            if held.lock_shared().is_ok() {
                if !is_still_at(&held, &fs::canonicalize(&self.path)?) {
                    return Err(io::ErrorKind::NotFound.into());
                }
                self.held = Some(held);
            }
        }
        Ok(())
    }

    /// The folder.
    pub fn path(&self) -> &Path {
        &self.path
    }
}

impl Drop for Folder {
    fn drop(&mut self) {
        let is_shared = |held: &File| held.try_lock().is_err();
        if self.made.is_empty() || self.held.as_ref().is_some_and(is_shared) {
            return;
        }
        for made in self.made.iter().rev() {
            let _ = fs::remove_dir(made);
        }
    }
}

#[cfg(all(test, unix))]
mod tests {
    use super::*;

    /// Of several that claim a folder at once, those that fail take nothing from the one that does not.
    #[test]
    fn a_folder_that_another_has_claimed_stays() {
        let around = tempfile::tempdir().expect("a folder");
        let path = around.path().join("a/b");
        let maker = Folder::make(&path).expect("made");
        let winner = Folder::make(&path).expect("there");
        drop(maker);
        assert!(path.is_dir());
        fs::write(path.join("result"), "").expect("the folder takes files");
        drop(winner);
        assert!(path.join("result").is_file());
        let alone = around.path().join("c");
        drop(Folder::make(&alone).expect("made"));
        assert!(!alone.exists());
        std::thread::scope(|scope| {
            for _ in 0..8 {
                scope.spawn(|| {
                    for _ in 0..50 {
                        let folder = Folder::make(&alone).expect("made");
                        fs::write(folder.path().join("x"), "").expect("the folder takes files");
                        let _ = fs::remove_file(folder.path().join("x"));
                    }
                });
            }
        });
    }
}
