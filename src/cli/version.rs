//! What `--version` says.

/// The version of the program, the commit it was built from where the build named it (`CONTACT3D_COMMIT`), and the
/// version of HDF5.
pub(super) fn words() -> &'static str {
    static WORDS: std::sync::LazyLock<String> = std::sync::LazyLock::new(|| {
        let commit = option_env!("CONTACT3D_COMMIT")
            .map_or_else(String::new, |commit| format!("commit {commit}\n"));
        let [major, minor, patch] = runfile::hdf5_version();
        format!(
            "{}\n{commit}HDF5 {major}.{minor}.{patch}",
            env!("CARGO_PKG_VERSION")
        )
    });
    &WORDS
}
