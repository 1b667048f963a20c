//! Damaged scenes, meshes and laws give an error or a result, never a panic.
//!
//! Every file of `tests/corpus` runs as a plain test. `FUZZ_CASES=100000 cargo test --release --test all fuzz`
//! looks longer; what it finds goes into the corpus.

use std::{fs, path::Path, sync::LazyLock};

use contact3d::{
    contact::Ellipse,
    dual::DualSystem,
    mesh::{Mesh, parse_gmsh},
    scene::{Formula, FrictionLaw, GivenPlanes, Scene},
};
use proptest::{prelude::*, sample::Index};

/// Damaged inputs a test tries, unless `FUZZ_CASES` says another number.
fn cases(by_default: u32) -> ProptestConfig {
    let given = std::env::var("FUZZ_CASES").ok();
    let cases = given.map_or(by_default, |text| {
        text.parse().expect("FUZZ_CASES is a number")
    });
    ProptestConfig {
        failure_persistence: None,
        ..ProptestConfig::with_cases(cases)
    }
}

fn corpus(kind: &str) -> Vec<(String, Vec<u8>)> {
    let folder = Path::new(env!("CARGO_MANIFEST_DIR"))
        .join("tests/corpus")
        .join(kind);
    let mut files: Vec<_> = fs::read_dir(folder)
        .expect("corpus folder")
        .map(|entry| {
            let path = entry.expect("directory entry").path();
            let bytes = fs::read(&path).expect("readable file");
            (path.display().to_string(), bytes)
        })
        .collect();
    files.sort();
    files
}

/// Scenes of every model feature: the pipelines and the scenes of the corpus.
static SCENES: LazyLock<Vec<Vec<String>>> = LazyLock::new(|| {
    let pipelines = fs::read_dir(crate::support::pipelines()).expect("pipelines");
    let mut texts: Vec<String> = pipelines
        .map(|entry| entry.expect("directory entry").path())
        .filter(|path| path.extension().is_some_and(|e| e == "toml"))
        .map(|path| fs::read_to_string(path).expect("readable scene"))
        .collect();
    texts.sort();
    texts.extend(
        corpus("scenes")
            .into_iter()
            .filter_map(|(_, bytes)| String::from_utf8(bytes).ok()),
    );
    texts.iter().map(|text| words(text)).collect()
});

/// Splits a text where one token of TOML or MSH ends; the parts together are the text.
fn words(text: &str) -> Vec<String> {
    let separator = |c: char| c.is_whitespace() || "[]{}=,\"".contains(c);
    text.split_inclusive(separator)
        .flat_map(|part| {
            let (word, end) = part.split_at(part.trim_end_matches(separator).len());
            [word.to_owned(), end.to_owned()]
        })
        .filter(|word| !word.is_empty())
        .collect()
}

#[derive(Debug, Clone)]
enum Change {
    Delete(Index),
    Double(Index),
    Swap(Index, Index),
    Replace(Index, String),
}

fn any_change() -> impl Strategy<Value = Change> {
    let word = prop_oneof![
        prop::sample::select(vec![
            "0",
            "-0.0",
            "-1",
            "1",
            "2",
            "0.5",
            "1e308",
            "-1e308",
            "5e-324",
            "1e-300",
            "nan",
            "inf",
            "-inf",
            "9223372036854775807",
            "18446744073709551616",
            "true",
            "\"\"",
            "\"x\"",
            "[]",
            "{}",
            "\"z_max\"",
            "\"1/x\"",
            "\"sqrt(-x)\"",
            "\"x^y^z\"",
            "\"ln(s1)\"",
            "\"if(x<mu,abs(y),max(z,0))\"",
            "[parameters]",
            "=",
            "[[",
            "\n",
        ])
        .prop_map(str::to_owned),
        any::<f64>().prop_map(|x| format!("{x:e}")),
        any::<i64>().prop_map(|n| n.to_string()),
        "\\PC{0,8}",
    ];
    prop_oneof![
        1 => any::<Index>().prop_map(Change::Delete),
        1 => any::<Index>().prop_map(Change::Double),
        1 => (any::<Index>(), any::<Index>()).prop_map(|(a, b)| Change::Swap(a, b)),
        3 => (any::<Index>(), word).prop_map(|(at, word)| Change::Replace(at, word)),
    ]
}

fn changed(words: &[String], changes: &[Change]) -> String {
    let mut words = words.to_vec();
    for change in changes {
        let n = words.len();
        match change {
            _ if n == 0 => {}
            Change::Delete(at) => drop(words.remove(at.index(n))),
            Change::Double(at) => words.insert(at.index(n), words[at.index(n)].clone()),
            Change::Swap(a, b) => words.swap(a.index(n), b.index(n)),
            Change::Replace(at, word) => words[at.index(n)].clone_from(word),
        }
    }
    words.concat()
}

/// Words of Rust and of its parsers that no message to a user has; scenes have none of them.
const RUST: [&str; 12] = [
    "usize", "f64", "i64", "u64", "i128", "untagged", "newtype", "variant", "struct ", "Some(",
    "wanted ", "field `",
];

/// Parses a scene and, on a coarse mesh, does everything up to the dual operator; says whether it
/// was accepted.
fn assemble(text: &str) -> bool {
    let mut scene = match Scene::parse("fuzz", text) {
        Ok(scene) => scene,
        Err(error) => {
            let said = error.to_string();
            let rust = RUST.iter().find(|word| said.contains(**word));
            assert_eq!(rust, None, "{said}");
            return false;
        }
    };
    if let Some(brick) = scene.as_brick_mut() {
        let coarse = brick.cells.map(|cells| if cells % 2 == 0 { 2 } else { 1 });
        brick.cells = coarse;
        brick.coordinates = GivenPlanes::default();
    }
    let folder = Path::new(env!("CARGO_MANIFEST_DIR")).join("crates/contact3d/tests/meshes");
    let text = scene.to_toml().expect("a scene from a text");
    let again = Scene::parse("canonical", &text).expect("canonical text is a scene");
    assert_eq!(again.to_toml(), Ok(text));
    Mesh::of_scene(&scene, &folder).is_ok_and(|mesh| DualSystem::new(&scene, &mesh).is_ok())
}

fn check_mesh(bytes: &[u8]) {
    if let Ok(mesh) = parse_gmsh(bytes) {
        assert!(
            mesh.tetrahedra
                .as_flattened()
                .iter()
                .all(|&n| n < mesh.coordinates.len())
        );
        assert_eq!(mesh.facet_face.len(), mesh.facets.len());
    }
}

fn check_law(text: &str, place: [f64; 3], slip: [f64; 2]) {
    let Ok(formula) = Formula::parse(text) else {
        return;
    };
    let coefficient = contact3d::scene::Coefficient::Expression(formula);
    for law in [
        FrictionLaw::Isotropic(coefficient.clone()),
        FrictionLaw::Orthotropic(Box::new([coefficient.clone(), coefficient])),
    ] {
        let _ = law.evaluate([0.0; 3], place, slip);
        let _ = law.derivative([0.0; 3], place, slip);
    }
}

#[test]
fn the_corpus_of_scenes_is_assembled_or_refused() {
    for (name, bytes) in corpus("scenes") {
        let accepted = std::str::from_utf8(&bytes).is_ok_and(assemble);
        // The files that begin with good_ cover the features: damage to them must start from a
        // scene that works.
        let good = name.contains("/good_");
        assert!(accepted || !good, "{name}");
    }
}

#[test]
fn the_corpus_of_meshes_is_read_or_refused() {
    for (_, bytes) in corpus("meshes") {
        check_mesh(&bytes);
    }
}

#[test]
fn the_corpus_of_laws_is_evaluated_or_refused() {
    let extremes = [
        0.0,
        5e-324,
        1e-300,
        1.0,
        1e300,
        f64::MAX,
        f64::INFINITY,
        f64::NAN,
    ];
    for (_, bytes) in corpus("laws") {
        for line in String::from_utf8_lossy(&bytes).lines() {
            for a in extremes {
                for b in extremes {
                    check_law(line, [a, b, -a], [b, a]);
                }
            }
        }
    }
}

proptest! {
    #![proptest_config(cases(10_000))]

    #[test]
    fn damaged_scenes_do_not_panic(which in any::<Index>(), changes in prop::collection::vec(any_change(), 1..4)) {
        assemble(&changed(&SCENES[which.index(SCENES.len())], &changes));
    }

    #[test]
    fn damaged_laws_do_not_panic(
        words in prop::collection::vec(prop::sample::select(vec![
            "x", "y", "z", "s", "s1", "s2", "0", "1", "2.5", "1e308", "1e-300", "PI", "E", "+", "-", "*", "/", "^",
            "(", ")", "sqrt(", "exp(", "ln(", "log10(", "tan(", "asin(", "sinh(", "tanh(", "abs(", "min(", "max(", "if(", "<", "<=", ">", ">=", " ", ",", "{", "é",
        ]), 1..20),
        place in prop::array::uniform3(any::<f64>()), slip in prop::array::uniform2(any::<f64>()),
    ) {
        check_law(&words.concat(), place, slip);
    }

    /// Over all doubles, infinities, subnormals and NaN; finite input gives a finite point of the ellipse.
    #[test]
    fn projections_of_any_doubles_do_not_panic(
        semi_axes in prop::array::uniform2(prop::num::f64::ANY), point in prop::array::uniform2(prop::num::f64::ANY),
    ) {
        let ellipse = Ellipse { semi_axes: semi_axes.map(f64::abs) };
        let (nearest, _) = ellipse.project_with_multiplier(point);
        let derivative = ellipse.projection_derivative(point);
        if semi_axes.iter().chain(&point).all(|v| v.is_finite()) {
            prop_assert!(nearest.iter().all(|v| v.is_finite()), "{nearest:?}");
            prop_assert!((0..2).all(|i| nearest[i].abs() <= point[i].abs()));
            let entries = derivative.by_point.as_flattened();
            // The projection does not stretch: |∂p/∂z| ≤ 1, up to a few roundings.
            prop_assert!(entries.iter().all(|v| v.abs() <= 1.0 + 1e-12), "{derivative:?}");
        }
    }
}

proptest! {
    #![proptest_config(cases(3_000))]

    #[test]
    fn damaged_meshes_do_not_panic(which in any::<Index>(), changes in prop::collection::vec(any_change(), 1..6)) {
        static MESHES: LazyLock<Vec<Vec<String>>> = LazyLock::new(|| {
            let texts = corpus("meshes").into_iter().filter_map(|(_, bytes)| String::from_utf8(bytes).ok());
            texts.map(|text| words(&text)).collect()
        });
        check_mesh(changed(&MESHES[which.index(MESHES.len())], &changes).as_bytes());
    }

    #[test]
    fn damaged_binary_meshes_do_not_panic(changes in prop::collection::vec((any::<Index>(), any::<u8>()), 1..6)) {
        let mut bytes = include_bytes!("../../crates/contact3d/tests/meshes/foot_41_binary.msh").to_vec();
        for (at, byte) in changes {
            let at = at.index(bytes.len());
            bytes[at] = byte;
        }
        check_mesh(&bytes);
    }
}
