//! Units as a scene names them: in everything that is printed, stored and drawn.

use std::{fs, path::Path};

use hdf5_metno as hdf5;
use serde_json::Value;

use crate::program::{Program, SMALL, pipeline};

/// Names of units that a text speaks: beside a number, in brackets (perhaps with a power of ten),
/// or below a fraction line.
fn spoken<'t>(text: &'t str, words: &[&'t str]) -> Vec<&'t str> {
    let plain = |token: &'t str| token.trim_matches([',', ';', ':', '(', ')', '.']);
    let tokens: Vec<&str> = text.split_whitespace().map(plain).collect();
    let is_spoken = |word: &&&str| {
        let [bracketed, scaled] = [format!("[{word}]"), format!("{word}]")];
        let per = format!("1/{word}");
        let beside = |pair: &[&str]| pair[0].parse::<f64>().is_ok() && pair[1] == **word;
        tokens
            .iter()
            .any(|t| t.contains(&bracketed) || **t == scaled || **t == per)
            || tokens.windows(2).any(beside)
    };
    words.iter().filter(is_spoken).copied().collect()
}

/// The text of a drawing or a page without its marks.
fn without_marks(text: &str) -> String {
    let mut inside = false;
    let visible = text.chars().map(|c| {
        let was_inside = inside;
        inside = (inside || c == '<') && c != '>';
        if inside || was_inside { ' ' } else { c }
    });
    // Letters of one title are marked one by one, words are not.
    let mut words = String::new();
    for c in visible {
        if c != ' ' || !words.ends_with(' ') {
            words.push(c);
        }
    }
    words.replace("&#160;", " ")
}

/// Every attribute `units` of a file.
fn unit_attributes(file: &Path) -> Vec<String> {
    fn visit(group: &hdf5::Group, found: &mut Vec<String>) {
        for dataset in group.datasets().unwrap() {
            found.extend(unit_of(&dataset));
        }
        for inner in group.groups().unwrap() {
            let is_matrix = inner.attr("encoding-type").is_ok();
            if is_matrix {
                found.extend(unit_of(&inner))
            } else {
                visit(&inner, found)
            }
        }
    }
    let mut found = Vec::new();
    visit(&hdf5::File::open(file).unwrap(), &mut found);
    found
}

fn unit_of(object: &hdf5::Location) -> Option<String> {
    let attribute = object.attr("units").ok()?;
    let text = attribute.read_scalar::<hdf5::types::VarLenUnicode>();
    Some(text.unwrap().to_string())
}

/// Everything that the commands say, draw and store of a scene: (where, text).
fn outputs(scene: &str) -> Vec<(String, String)> {
    let program = Program::new();
    let scene = pipeline(scene);
    let scene = scene.to_str().unwrap();
    let mut texts = Vec::new();
    let mut say = |name: &str, arguments: &[&str]| {
        let output = program.command(arguments).output().unwrap();
        let text = [output.stdout, output.stderr].map(|b| String::from_utf8(b).unwrap());
        assert!(output.status.success(), "{name}: {}", text[1]);
        texts.push((name.to_owned(), text.concat()));
    };
    say("run", &["run", scene, "run.h5", "-v", SMALL[0], SMALL[1]]);
    say("status", &["status", "run.h5"]);
    say("check", &["check", "run.h5"]);
    say("law", &["friction-law", scene, "--figures", "law"]);
    let small = [SMALL[0], SMALL[1]];
    let meshes = ["--coarsest", "2", "--finest", "4", "--budget", "5"];
    let accuracy = ["accuracy", scene, "run.h5"];
    say("accuracy", &[&accuracy[..], &small, &meshes].concat());
    let stability = ["stability", scene, "--table", "stability.h5"];
    let coarse = [SMALL[0], "body.brick.cells=[6,2,2]"];
    say("stability", &[&stability[..], &coarse].concat());
    say("report", &["report", "run.h5", "run.html"]);
    let sweep = format!(
        "scene = {scene:?}\n[set]\n\"body.brick.cells\" = [6, 2, 2]\n[[axis]]\n\
         key = \"friction\"\nvalues = [{{ coefficient.constant = 0.2 }}, {{ coefficient.constant = 0.4 }}]\n\
         zip = \"k\"\n[[axis]]\nkey = \"contact.angle\"\nvalues = [0.0, 20.0]\nzip = \"k\"\n"
    );
    fs::write(program.path("sweep.toml"), sweep).unwrap();
    say("sweep", &["sweep", "sweep.toml", "sweep"]);
    say("report of a sweep", &["report", "sweep", "sweep.html"]);
    for page in ["run.html", "sweep.html"] {
        let page_text = without_marks(&fs::read_to_string(program.path(page)).unwrap());
        texts.push((page.to_owned(), page_text));
    }
    for folder in ["run-figures", "law", "sweep/figures"] {
        let files = fs::read_dir(program.path(folder)).unwrap();
        let files = files.map(|file| file.unwrap().path());
        for file in files.filter(|file| file.extension().is_some_and(|e| e == "svg")) {
            let text = without_marks(&fs::read_to_string(&file).unwrap());
            texts.push((file.display().to_string(), text));
        }
    }
    for file in ["run.h5", "stability.h5", "sweep/summary.h5"] {
        let bracketed = |unit: String| format!("[{unit}]");
        let units = unit_attributes(&program.path(file)).into_iter();
        texts.push((file.to_owned(), units.map(bracketed).collect::<String>()));
    }
    let table = fs::read_to_string(program.path("sweep/summary.csv")).unwrap();
    let [head, row] = [0, 1].map(|n| table.lines().nth(n).unwrap());
    let units = head.split(',').zip(row.split(','));
    let units = units.filter(|(name, _)| name.ends_with("_unit"));
    let units = units.map(|(name, unit)| format!("{name} [{unit}] "));
    texts.push(("summary.csv".to_owned(), units.collect::<String>()));
    texts
}

/// Where each kind of unit is spoken; a change of the scene's units must reach all of these.
const STRESS_IN: [&str; 7] = [
    "run",
    "status",
    "run.html",
    "a_contact_pressure.svg",
    "run.h5",
    "summary.h5",
    "summary.csv",
];
const LENGTH_IN: [&str; 7] = [
    "run",
    "law",
    "friction_law.svg",
    "c_deformed_body.svg",
    "run.html",
    "run.h5",
    "summary.csv",
];
const FORCE_IN: [&str; 4] = ["status", "sweep.html", "normal_force.svg", "run.h5"];

fn assert_spoken(texts: &[(String, String)], places: &[&str], word: &str) {
    for place in places {
        let found = texts.iter().filter(|(name, _)| name.ends_with(place));
        let found: Vec<_> = found.collect();
        assert!(!found.is_empty(), "no output {place}");
        for (name, text) in found {
            assert_eq!(spoken(text, &[word]), [word], "{name}: {text}");
        }
    }
}

fn assert_silent(texts: &[(String, String)], words: &[&str]) {
    for (name, text) in texts {
        assert_eq!(spoken(text, words), [""; 0], "{name}: {text}");
    }
}

#[test]
fn millimetres_are_spoken_everywhere() {
    let texts = outputs("millimetres.toml");
    assert_spoken(&texts, &STRESS_IN, "MPa");
    assert_spoken(&texts, &LENGTH_IN, "mm");
    assert_silent(
        &texts,
        &["Pa", "m", "J", "kPa", "N/m", "m^2", "m^3", "m^3/Pa", "N m"],
    );
    let stability = texts.iter().find(|(name, _)| name == "stability").unwrap();
    assert_eq!(spoken(&stability.1, &["mm^3/MPa"]), ["mm^3/MPa"]);
}

#[test]
fn inches_and_pounds_are_spoken_everywhere() {
    let texts = outputs("inches.toml");
    assert_spoken(&texts, &STRESS_IN, "psi");
    assert_spoken(&texts, &LENGTH_IN, "in");
    assert_spoken(&texts, &FORCE_IN, "lbf");
    let si = [
        "Pa", "kPa", "MPa", "m", "mm", "µm", "N", "kN", "MN", "J", "mJ", "N m", "N/m",
    ];
    assert_silent(&texts, &si);
    let run = texts.iter().find(|(name, _)| name == "run.h5").unwrap();
    for unit in ["lbf in", "lbf/in", "in^3/psi"] {
        assert!(run.1.contains(&format!("[{unit}]")), "{unit}: {}", run.1);
    }
}

/// The same outputs of a scene without `[units]`, so that silence above means something.
#[test]
fn a_scene_without_units_speaks_si_everywhere() {
    let texts = outputs("newton.toml");
    // What people read has prefixes, what programs read has none.
    assert_spoken(&texts, &STRESS_IN[..4], "MPa");
    assert_spoken(&texts, &STRESS_IN[4..], "Pa");
    let places: Vec<&str> = LENGTH_IN
        .into_iter()
        .filter(|p| !p.ends_with("svg"))
        .collect();
    assert_spoken(&texts, &places, "m");
    assert_spoken(&texts, &["status"], "MN");
    assert_spoken(&texts, &["sweep.html", "run.h5"], "N");
}

#[test]
fn json_says_the_units() {
    let program = Program::new();
    let scene = pipeline("inches.toml");
    let arguments = [
        "run",
        scene.to_str().unwrap(),
        "run.h5",
        "--no-figures",
        "--json",
    ];
    let output = program.command(&arguments).args(SMALL).output().unwrap();
    let results: Value = serde_json::from_slice(&output.stdout).unwrap();
    let units = serde_json::json!({
        "length": "in", "force": "lbf", "stress": "psi", "energy": "lbf in",
    });
    assert_eq!(results["units"], units);
    assert_eq!(program.status()["units"], units);
}

#[test]
fn a_word_that_is_no_unit_is_refused_with_those_that_are() {
    let program = Program::new();
    for (setting, key, allowed) in [
        ("units.length=\"furlong\"", "units.length", ["`mm`", "`ft`"]),
        ("units.force=\"dyn\"", "units.force", ["`kN`", "`lbf`"]),
        (
            "units.stress=\"MPa\"",
            "units.stress",
            ["`length`", "`force`"],
        ),
    ] {
        let refused = program.run(&["--set", setting]).assert().code(2);
        let said = String::from_utf8_lossy(&refused.get_output().stderr).into_owned();
        for word in allowed.iter().chain([&key]) {
            assert!(said.contains(word), "{word} is not in {said}");
        }
        assert!(!program.path("run.h5").exists());
    }
}

const MILLIMETRES: [&str; 2] = ["--set", "units.length=\"mm\""];
const METRES: [&str; 2] = ["--set", "units={length=\"m\",force=\"N\"}"];

#[test]
fn other_units_make_every_stage_stale_and_the_default_is_as_none() {
    let program = Program::new();
    program.run(&[]).assert().success();
    let plain = program.digests();
    let named = program.run(&METRES).assert().success();
    let said = String::from_utf8_lossy(&named.get_output().stderr).into_owned();
    assert_eq!(said.matches("fresh, kept").count(), 5, "{said}");
    let changed = program.run(&MILLIMETRES).assert().success();
    let said = String::from_utf8_lossy(&changed.get_output().stderr).into_owned();
    assert_eq!(said.matches("fresh, kept").count(), 0, "{said}");
    let other = program.digests();
    assert!(plain.iter().zip(&other).all(|(a, b)| a != b));
    program.command(&["check", "run.h5"]).assert().success();
    program.run(&[]).assert().success();
    assert_eq!(program.digests(), plain);
}
