//! What version 0.1.0 wrote counts as our own and is replaced.

use std::fs;

use super::program::Scratch;

const SCENE: &str = "scenes/coulomb_isotropic.toml";

#[test]
fn pictures_pages_and_schemas_are_replaced() {
    let scratch = Scratch::with(&["outputs", SCENE, "run_1.3.h5"]);
    let old: Vec<Vec<u8>> = [
        "law.svg",
        "law.png",
        "report.html",
        "scene.json",
        "run_file.md",
    ]
    .iter()
    .map(|name| fs::read(scratch.path(&format!("outputs/{name}"))).expect("bytes"))
    .collect();
    assert!(old.iter().all(|bytes| !bytes.is_empty()));
    scratch.done(&["law", "coulomb_isotropic.toml", "--figures", "outputs"]);
    scratch.done(&["report", "run_1.3.h5", "-o", "outputs/report.html"]);
    scratch.done(&["schema", "--out", "outputs"]);
    let page = fs::read_to_string(scratch.path("outputs/report.html")).expect("a page");
    assert!(
        page.contains("id=\"results\""),
        "the page is that of the run file"
    );
    scratch.done(&["schema", "--out", "outputs", "--check"]);
    // Once more: the files of this version are our own too, also a PNG without its SVG.
    fs::remove_file(scratch.path("outputs/law.svg")).expect("removed");
    scratch.done(&["law", "coulomb_isotropic.toml", "--figures", "outputs"]);
}

/// Nothing in an old PNG says who made it; the drawing beside it does.
#[test]
fn an_old_png_without_its_drawing_is_not_known() {
    let scratch = Scratch::with(&["outputs", SCENE]);
    fs::remove_file(scratch.path("outputs/law.svg")).expect("removed");
    let png = fs::read(scratch.path("outputs/law.png")).expect("bytes");
    let output = scratch.run(&["law", "coulomb_isotropic.toml", "--figures", "outputs"]);
    let text = String::from_utf8_lossy(&output.stderr).into_owned();
    assert_eq!(output.status.code(), Some(2), "{text}");
    assert!(
        text.contains("law.png: expected a PNG picture of this program"),
        "{text}"
    );
    assert_eq!(
        fs::read(scratch.path("outputs/law.png")).expect("bytes"),
        png
    );
    assert!(!scratch.path("outputs/law.svg").exists());
}
