//! The axes of friction in the file: t₂ = t₁ × ν, and which way angles turn.

use std::fs;

use assert_cmd::Command;
use contact3d_pipe::LAYOUT;
use runfile::Reader;

use super::scenes::{RAMPS, STEEL};

/// A cube on one of its faces, with a load that presses and drags along both axes.
fn cube(face: &str, contact: &str) -> String {
    let opposite = match face.split_at(2) {
        (axis, "min") => format!("{axis}max"),
        (axis, _) => format!("{axis}min"),
    };
    let push = if face.ends_with("min") { -2e7 } else { 2e7 };
    let load = ["x", "y", "z"].map(|axis| {
        if face.starts_with(axis) {
            format!("{push:?}")
        } else {
            "4e6".to_owned()
        }
    });
    let side = if face.starts_with('x') {
        "y_max"
    } else {
        "x_max"
    };
    format!(
        "title = 'cube'\n[body.brick]\nsize = [1.0, 1.0, 1.0]\ncells = [4, 4, 4]\n{STEEL}\
         [[clamp]]\nface = '{side}'\n[[traction]]\nface = '{opposite}'\nvalue = [{}]\n\
         [contact]\nface = '{face}'\n{contact}\n{RAMPS}",
        load.join(", ")
    )
}

fn run(scene: &str) -> (tempfile::TempDir, Reader) {
    let folder = tempfile::tempdir().unwrap();
    fs::write(folder.path().join("scene.toml"), scene).unwrap();
    Command::cargo_bin("contact3d-pipe")
        .unwrap()
        .current_dir(folder.path())
        .args(["run", "scene.toml", "run.h5", "--no-figures", "--quiet"])
        .assert()
        .success();
    let reader = Reader::open(&folder.path().join("run.h5"), LAYOUT).unwrap();
    (folder, reader)
}

fn vectors(reader: &Reader, path: &str) -> Vec<[f64; 3]> {
    let values = reader.read_vec::<f64>(path).unwrap();
    values.as_chunks::<3>().0.to_vec()
}

fn near(a: [f64; 3], b: [f64; 3], scale: f64) -> bool {
    // A few roundings of sums of a hundred terms of that size.
    (0..3).all(|c| (a[c] - b[c]).abs() < 1e-12 * scale)
}

fn cross(a: [f64; 3], b: [f64; 3]) -> [f64; 3] {
    [0, 1, 2].map(|c| {
        let [p, q] = [(c + 1) % 3, (c + 2) % 3];
        a[p] * b[q] - a[q] * b[p]
    })
}

/// A signed axis such as `−y`, as docs/reference/contact.md writes it.
fn axis(word: &str) -> [f64; 3] {
    let word = word.trim();
    let (sign, name) = match word.strip_prefix('−') {
        Some(name) => (-1.0, name),
        None => (1.0, word),
    };
    ["x", "y", "z"].map(|axis| if axis == name { sign } else { 0.0 })
}

#[test]
fn the_faces_of_a_brick_have_the_axes_of_the_page() {
    let page = concat!(env!("CARGO_MANIFEST_DIR"), "/docs/reference/contact.md");
    let page = fs::read_to_string(page).unwrap();
    let (_, table) = page.split_once("| face | ν | t₁ | t₂ |").unwrap();
    let rows = table.lines().filter(|line| line.starts_with("| `"));
    let mut faces = 0;
    for row in rows.take(6) {
        let cells: Vec<&str> = row.split('|').map(|cell| cell.trim()).collect();
        let face = cells[1].trim_matches('`');
        let (_folder, reader) = run(&cube(face, ""));
        let normal = vectors(&reader, "/mesh/contact_normal")[0];
        let [first, second] =
            ["/post/contact_axis_1", "/post/contact_axis_2"].map(|path| vectors(&reader, path)[0]);
        assert!(near(normal, axis(cells[2]), 1.0), "{face}: {normal:?}");
        assert!(near(first, axis(cells[3]), 1.0), "{face}: {first:?}");
        assert!(near(second, axis(cells[4]), 1.0), "{face}: {second:?}");
        faces += 1;
    }
    assert_eq!(faces, 6);
}

#[test]
fn positive_angles_turn_the_first_axis_towards_the_second() {
    let (_folder, reader) = run(&cube("z_min", "angle = 30.0"));
    let (sine, cosine) = 30.0_f64.to_radians().sin_cos();
    // From above, x to the right and y up: counterclockwise.
    for first in vectors(&reader, "/post/contact_axis_1") {
        assert!(near(first, [cosine, sine, 0.0], 1.0), "{first:?}");
    }
    for second in vectors(&reader, "/post/contact_axis_2") {
        assert!(near(second, [-sine, cosine, 0.0], 1.0), "{second:?}");
    }
}

#[test]
fn tractions_in_global_axes_are_those_along_the_frame() {
    for contact in [
        "",
        "angle = '40*x - 20*y'",
        "angle = '40*x - 20*y'\nmultipliers = 'nodal'",
    ] {
        let (_folder, reader) = run(&cube("z_min", contact));
        let normal = vectors(&reader, "/mesh/contact_normal")[0];
        let axes = ["/post/contact_axis_1", "/post/contact_axis_2"].map(|p| vectors(&reader, p));
        for (first, second) in axes[0].iter().zip(&axes[1]) {
            assert!(near(*second, cross(*first, normal), 1.0));
        }
        let turns = axes[0].iter().any(|axis| !near(*axis, axes[0][0], 1.0));
        assert_eq!(turns, !contact.is_empty());
        let traction = vectors(&reader, "/post/contact_traction");
        let pressure = reader.read_vec::<f64>("/post/normal_stress").unwrap();
        let area = reader.read_vec::<f64>("/mesh/pane_area").unwrap();
        let force = vectors(&reader, "/post/resultants/contact_force")[0];
        let mut sum = [0.0; 3];
        for (pane, vector) in traction.iter().enumerate() {
            let along: f64 = (0..3).map(|c| vector[c] * normal[c]).sum();
            assert!((along - pressure[pane]).abs() <= 1e-12 * pressure[pane].abs());
            sum = [0, 1, 2].map(|c| sum[c] + area[pane] * vector[c]);
        }
        assert!(near(sum, force, force[2].abs()), "{sum:?} {force:?}");
        assert!(
            force[0].abs() > 1e-3 * force[2],
            "the load drags: {force:?}"
        );
    }
}
