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

/// The packages of this build, tests included.
fn packages() -> Vec<Value> {
    let version = Command::new("rustc").arg("-vV").output().expect("rustc");
    let version = String::from_utf8(version.stdout).expect("UTF-8");
    let host = version.lines().find_map(|line| line.strip_prefix("host: "));
    let metadata = Command::new(env!("CARGO"))
        .args(["metadata", "--locked", "--offline", "--format-version", "1"])
        .args(["--filter-platform", host.expect("the host of rustc")])
        .current_dir(env!("CARGO_MANIFEST_DIR"))
        .output()
        .expect("cargo");
    let error = String::from_utf8_lossy(&metadata.stderr).into_owned();
    assert!(metadata.status.success(), "{error}");
    let metadata: Value = serde_json::from_slice(&metadata.stdout).expect("JSON");
    metadata["packages"].as_array().expect("packages").clone()
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
    let clarified = listed(&deny, ["licenses", "clarify"]);
    for package in packages() {
        let name = name(&package);
        let clarified = clarified.iter().find(|item| text(item, "crate") == name);
        let licence = match (package["license"].as_str(), clarified) {
            (Some(licence), _) => licence,
            (None, Some(item)) => text(item, "expression"),
            (None, None) => panic!("{name} does not say its licence"),
        };
        assert!(is_allowed(licence, &allowed), "{name}: {licence}");
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
    assert!(packages.len() > 1);
    for package in packages {
        let package = package.as_table().expect("a package");
        if text(package, "name") == env!("CARGO_PKG_NAME") {
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
    let manifest = project("Cargo.toml");
    assert_eq!(
        manifest["lints"]["rust"]["unsafe_code"].as_str(),
        Some("forbid")
    );
}
