//! What the program is made of: locked, from one registry, under licences that are allowed. Works offline.

use std::{
    collections::{BTreeMap, BTreeSet},
    fs,
    path::Path,
    process::Command,
};

use serde_json::Value;
use spdx::{Expression, ParseMode};
use toml::Table;

fn project(name: &str) -> Table {
    let path = Path::new(env!("CARGO_MANIFEST_DIR")).join(name);
    let text = fs::read_to_string(path).expect("readable file of the project");
    text.parse().expect("TOML")
}

/// Names and manifests of the packages of the workspace.
fn own_packages() -> Vec<(String, Table)> {
    let crates = Path::new(env!("CARGO_MANIFEST_DIR")).join("crates");
    let folders = fs::read_dir(crates).expect("the crates of the workspace");
    let members = folders.map(|folder| {
        let name = folder.expect("a folder").file_name();
        format!("crates/{}/Cargo.toml", name.to_string_lossy())
    });
    let manifests = members
        .chain(["Cargo.toml".to_owned()])
        .map(|path| project(&path));
    let own: Vec<(String, Table)> = manifests
        .map(|manifest| {
            let package = manifest["package"].as_table().expect("a package");
            (text(package, "name").to_owned(), manifest)
        })
        .collect();
    assert!(own.len() > 1, "the workspace was read");
    own
}

/// The texts under a key of `deny.toml`, which cargo-deny reads too.
fn listed(table: &Table, [part, key]: [&str; 2]) -> Vec<Table> {
    let items = table[part][key].as_array().expect("a list").clone();
    let tables = items.into_iter().map(|item| match item {
        toml::Value::Table(table) => table,
        text => Table::from_iter([("crate".to_owned(), text)]),
    });
    tables.collect()
}

fn text<'a>(table: &'a Table, key: &str) -> &'a str {
    table[key].as_str().expect("a text")
}

/// What cargo says, offline and by the lock file.
fn cargo(arguments: &[&str]) -> String {
    let output = Command::new(env!("CARGO"))
        .args(arguments)
        .args(["--locked", "--offline"])
        .current_dir(env!("CARGO_MANIFEST_DIR"))
        .output()
        .expect("cargo");
    let error = String::from_utf8_lossy(&output.stderr).into_owned();
    assert!(output.status.success(), "{error}");
    String::from_utf8(output.stdout).expect("UTF-8")
}

/// The packages of this build, tests included. The metadata also list optional packages that no
/// feature asks for; those are not in the tree.
fn packages() -> Vec<Value> {
    let tree = cargo(&[
        "tree", "--edges", "all", "--prefix", "none", "--format", "{p}",
    ]);
    let built: BTreeSet<Vec<&str>> = tree
        .lines()
        .map(|line| line.split_whitespace().take(2).collect())
        .collect();
    let version = Command::new("rustc").arg("-vV").output().expect("rustc");
    let version = String::from_utf8(version.stdout).expect("UTF-8");
    let host = version.lines().find_map(|line| line.strip_prefix("host: "));
    let host = host.expect("the host of rustc");
    let metadata = cargo(&[
        "metadata",
        "--format-version",
        "1",
        "--filter-platform",
        host,
    ]);
    let metadata: Value = serde_json::from_str(&metadata).expect("JSON");
    let mut packages = metadata["packages"].as_array().expect("packages").clone();
    packages.retain(|package| {
        let version = format!("v{}", package["version"].as_str().expect("a version"));
        built.contains(&vec![name(package), version.as_str()])
    });
    assert!(packages.len() > 100, "the tree was read");
    packages
}

fn name(package: &Value) -> &str {
    package["name"].as_str().expect("a name")
}

fn is_allowed(licence: &str, allowed: &BTreeSet<&str>) -> bool {
    let expression = Expression::parse_mode(licence, ParseMode::LAX).expect(licence);
    expression.evaluate(|required| {
        let id = required.license.id();
        required.addition.is_none() && id.is_some_and(|id| allowed.contains(id.name))
    })
}

#[test]
fn every_licence_is_allowed() {
    let deny = project("deny.toml");
    let allowed = listed(&deny, ["licenses", "allow"]);
    let allowed: BTreeSet<&str> = allowed.iter().map(|item| text(item, "crate")).collect();
    let exceptions = listed(&deny, ["licenses", "exceptions"]);
    for package in packages() {
        let name = name(&package);
        // A package that says its licence in a file only is an exception by name.
        let excepted = exceptions.iter().any(|item| text(item, "crate") == name);
        match package["license"].as_str() {
            Some(licence) => assert!(is_allowed(licence, &allowed), "{name}: {licence}"),
            None => assert!(excepted, "{name} does not say its licence"),
        }
    }
}

#[test]
fn licences_that_are_not_listed_are_refused() {
    let allowed = BTreeSet::from(["MIT"]);
    assert!(is_allowed("MIT/Apache-2.0", &allowed));
    assert!(is_allowed("GPL-3.0 OR MIT", &allowed));
    assert!(!is_allowed("GPL-3.0", &allowed));
    assert!(!is_allowed("MIT AND GPL-3.0", &allowed));
}

#[test]
fn every_package_is_locked_with_a_checksum_of_the_registry() {
    let lock = project("Cargo.lock");
    let packages = lock["package"].as_array().expect("packages");
    let own = own_packages();
    let own: BTreeSet<&str> = own.iter().map(|(name, _)| name.as_str()).collect();
    assert!(packages.len() > own.len());
    for package in packages {
        let package = package.as_table().expect("a package");
        if own.contains(text(package, "name")) {
            continue;
        }
        let source = text(package, "source");
        let is_registry = source.starts_with("registry+") && source.ends_with("/crates.io-index");
        assert!(is_registry, "{package}");
        let checksum = text(package, "checksum");
        let is_digest = checksum.len() == 64 && checksum.bytes().all(|c| c.is_ascii_hexdigit());
        assert!(is_digest, "{package}");
    }
}

#[test]
fn only_known_packages_come_in_two_versions() {
    let deny = project("deny.toml");
    let known = listed(&deny, ["bans", "skip"]);
    let known: BTreeSet<&str> = known.iter().map(|item| text(item, "crate")).collect();
    let packages = packages();
    let mut counts: BTreeMap<&str, usize> = BTreeMap::new();
    for package in &packages {
        *counts.entry(name(package)).or_default() += 1;
    }
    let twice = counts.into_iter().filter(|(_, count)| *count > 1);
    let twice: BTreeSet<&str> = twice.map(|(name, _)| name).collect();
    assert_eq!(
        twice, known,
        "packages in several versions, and those deny.toml knows"
    );
}

#[test]
fn our_own_code_forbids_unsafe() {
    let workspace = project("Cargo.toml");
    assert_eq!(
        workspace["workspace"]["lints"]["rust"]["unsafe_code"].as_str(),
        Some("forbid")
    );
    for (name, manifest) in own_packages() {
        assert_eq!(
            manifest["lints"]["workspace"].as_bool(),
            Some(true),
            "{name}"
        );
    }
}

/// The library is for programs that want neither a file format nor a command line nor pictures.
#[test]
fn the_library_needs_neither_hdf5_nor_a_command_line_nor_pictures() {
    let tree = |package: &str| -> BTreeSet<String> {
        let tree = cargo(&[
            "tree",
            "--package",
            package,
            "--edges",
            "normal",
            "--prefix",
            "none",
            "--format",
            "{p}",
        ]);
        let names = tree.lines().filter_map(|line| line.split(' ').next());
        names.map(str::to_owned).collect()
    };
    let (library, program) = (tree("contact3d"), tree("contact3d-pipe"));
    for package in [
        "hdf5-metno",
        "hdf5-metno-sys",
        "clap",
        "tiny-skia",
        "resvg",
        "ttf-parser",
    ] {
        assert!(
            program.contains(package),
            "the program no longer uses {package}"
        );
        assert!(!library.contains(package), "contact3d needs {package}");
    }
    assert!(library.contains("faer"), "the tree was read");
}
