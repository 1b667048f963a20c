//! The hard cases that are part of the program.

use std::{fs, io, path::Path};

use tempfile::TempDir;

/// Files of the suite with their contents, by their names in its folder.
macro_rules! files {
    ($($name:literal),+) => {
        &[$(($name, include_bytes!(concat!("../../pipelines/hard/", $name)))),+]
    };
}

/// The index of the suite, and what it names.
const FILES: &[(&str, &[u8])] = files![
    "suite.toml",
    "brick.toml",
    "soft_block.toml",
    "faces.toml",
    "block.toml",
    "one_node.toml",
    "two_nodes.toml",
    "meshes/one_node.msh",
    "meshes/slivers.msh",
    "meshes/two_nodes.msh"
];

/// The name of the index in the folder that [`unpack`] makes.
pub const INDEX: &str = "suite.toml";

/// Puts the suite in a temporary folder, which is removed with the value returned.
pub fn unpack() -> io::Result<TempDir> {
    let folder = tempfile::Builder::new()
        .prefix("contact3d-pipe-")
        .tempdir()?;
    for (name, content) in FILES {
        let file = folder.path().join(name);
        fs::create_dir_all(file.parent().unwrap_or(Path::new("")))?;
        fs::write(file, content)?;
    }
    Ok(folder)
}

#[cfg(test)]
mod tests {
    use super::*;

    fn files(folder: &Path) -> Vec<(String, Vec<u8>)> {
        let mut found = Vec::new();
        for entry in fs::read_dir(folder).unwrap() {
            let path = entry.unwrap().path();
            let name = path.file_name().unwrap().to_string_lossy().into_owned();
            if path.is_dir() {
                let inner = files(&path).into_iter();
                found.extend(inner.map(|(file, content)| (format!("{name}/{file}"), content)));
            } else {
                found.push((name, fs::read(&path).unwrap()));
            }
        }
        found.sort();
        found
    }

    #[test]
    fn the_whole_suite_is_in_the_program_and_nothing_stays_behind() {
        let source = Path::new(env!("CARGO_MANIFEST_DIR")).join("pipelines/hard");
        let folder = unpack().unwrap();
        assert_eq!(files(folder.path()), files(&source));
        let path = folder.path().to_owned();
        drop(folder);
        assert!(!path.exists());
    }
}
