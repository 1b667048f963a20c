//! Names of cases and settings of stages of the scenes of version 0.1.0.

use std::{collections::BTreeMap, fs};

use contact3d::scene::SceneFile;
use contact3d_pipe::{Plan, Stage, stage_settings};

use super::program::{Scratch, fixture};

/// The first 16 digits of the name of a case, or of the digest of a stage's settings.
type Pins = BTreeMap<String, String>;

/// Every scene with the name it has as a case, and the settings of every stage.
fn pins() -> BTreeMap<String, Pins> {
    let scratch = Scratch::with(&["scenes"]);
    let mut pins = BTreeMap::new();
    for entry in fs::read_dir(scratch.path("scenes")).expect("a folder") {
        let path = entry.expect("an entry").path();
        let name = path.file_stem().and_then(|name| name.to_str());
        let name = name.expect("a plain name").to_owned();
        if name == "digests" {
            continue;
        }
        let sweep = scratch.path(&format!("{name}.sweep"));
        fs::write(&sweep, format!("scene = \"scenes/{name}.toml\"\n")).expect("a sweep");
        let plan = Plan::read(&sweep).unwrap_or_else(|error| panic!("{name}: {error}"));
        let mut of_scene = Pins::from([("case".to_owned(), plan.cases[0].id.clone())]);
        let scene = SceneFile::read(&path).expect("a scene").scene;
        for stage in Stage::ALL {
            let settings = stage_settings(stage, &scene);
            let digest = blake3::hash(settings.as_bytes()).to_hex();
            of_scene.insert(stage.word().to_owned(), digest[..16].to_owned());
        }
        pins.insert(name, of_scene);
    }
    pins
}

/// A key added to scenes shows here if it is written out while it has its default, and so does a default that
/// changed: both would rename the cases of sweeps and make older files stale.
#[test]
fn scenes_of_version_0_1_0_have_the_digests_they_had() {
    let text = fs::read_to_string(fixture("scenes/digests.toml")).expect("the digests");
    let pinned: BTreeMap<String, Pins> = toml::from_str(&text).expect("TOML");
    let now = pins();
    assert!(now.len() >= 25, "{}", now.len());
    for (scene, pins) in &now {
        assert_eq!(
            Some(pins),
            pinned.get(scene),
            "{scene}.toml: the canonical scene has changed; give a new key \
             #[serde(default, skip_serializing_if = …)] so that it is left out while it has its default"
        );
    }
    assert_eq!(now.len(), pinned.len());
}
