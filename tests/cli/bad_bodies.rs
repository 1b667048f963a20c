//! Wrong Gmsh bodies and bodies that do not fit the machine: exit code 2, the reason, no run file.

use std::fs;

use crate::{
    bad_scenes::{SCENE, flaw},
    program::Program,
};

/// A foot of two materials, in millimetres, on a round contact face.
const FOOT: &str = r#"title = "a foot"

[body.gmsh]
file = "foot.msh"
unit = 0.001

[material.isotropic]
young_modulus = 5e6
poisson_ratio = 0.4

[[region]]
part.group = "steel"
material.isotropic = { young_modulus = 2e11, poisson_ratio = 0.3 }

[[clamp]]
face = "held end"

[[pressure]]
face = "unnamed"
value = 1e3

[contact]
face = "contact"
"#;

const FOOT_MESH: &str = include_str!("../../crates/contact3d/tests/meshes/foot_22.msh");

/// Two tetrahedra that share a triangle.
const PAIR_MESH: &str = "$MeshFormat\n2.2 0 8\n$EndMeshFormat\n\
    $PhysicalNames\n3\n2 5 \"held end\"\n2 6 \"contact\"\n3 7 \"steel\"\n$EndPhysicalNames\n\
    $Nodes\n5\n1 0 0 0\n2 1 0 0\n3 0 1 0\n4 0 0 1\n5 0 0 -1\n$EndNodes\n\
    $Elements\n4\n1 2 2 5 1 1 2 4\n2 2 2 6 2 1 3 4\n3 4 2 7 1 1 2 3 4\n4 4 2 7 1 1 3 2 5\n$EndElements\n";

/// Changes of the scene: what, by what, and what the message says.
#[rustfmt::skip] // one case a line
const SCENES: [(&str, &str, &[&str]); 12] = [
    ("foot.msh", "no.msh", &["body.gmsh.file", "no.msh", "[bad.toml:4:"]),
    ("foot.msh", ".", &["body.gmsh.file", "[bad.toml:4:"]),
    ("unit = 0.001", "unit = -1.0", &["body.gmsh.unit", "positive"]),
    ("unit = 0.001", "unit = 0.001\ndigest = \"00ff\"", &["body.gmsh.digest", "has changed", "[bad.toml:6:"]),
    ("\"steel\"", "\"wood\"", &["region.0.part", "rubber, steel", "wood"]),
    ("\"steel\"", "\"\"", &["region.0.part", "rubber, steel"]),
    ("face = \"held end\"", "face = \"x_min\"", &["clamp.0.face", "contact, held end", "x_min"]),
    ("face = \"unnamed\"", "face = \"top\"", &["pressure.0.face", "contact, held end"]),
    ("face = \"contact\"", "face = \"bottom\"", &["contact.face", "contact, held end"]),
    ("face = \"contact\"", "face = \"unnamed\"", &["pressure.0.face", "nor in contact"]),
    ("[[clamp]]\nface = \"held end\"\n\n[[pressure]]\nface = \"unnamed\"\nvalue = 1e3\n\n[contact]\nface = \"contact\"", "[[clamp]]\nface = \"held end\"\ncomponents = [\"z\"]", &["clamp", "rigid", "translation along x"]),
    ("[[pressure]]\nface = \"unnamed\"\nvalue = 1e3\n\n[contact]\nface = \"contact\"", "[contact]\nface = \"unnamed\"", &["contact.face", "a flat face"]),
];

/// Changes of the mesh of two tetrahedra.
#[rustfmt::skip] // one case a line
const MESHES: [(&str, &str, &[&str]); 16] = [
    ("2.2 0 8", "3.0 0 8", &["line 2", "4.1 or 2.2", "save it again"]),
    ("2.2 0 8", "2.2 1 8", &["line 2", "without -bin"]),
    ("$Nodes\n5\n", "$Nodes\n5000000000000\n", &["line 11", "5000000000000"]),
    ("$Nodes\n5\n", "$Nodes\n-1\n", &["line 11"]),
    ("3 0 1 0", "3 0 nan 0", &["line 14", "node 3", "finite"]),
    ("3 0 1 0", "2 0 1 0", &["line 14", "node 2 again"]),
    ("4 0 0 1\n", "4 0 0 0\n", &["volume", "optimise"]),
    ("4 0 0 1\n", "4 0 0 -2\n", &["tetrahedron"]),
    ("1 2 3 4\n", "1 2 3 9\n", &["element 3", "node 9"]),
    ("1 2 3 4\n", "1 2 3 3\n", &["element 3", "node 3 twice"]),
    ("3 4 2 7 1 1 2 3 4\n", "3 11 2 7 1 1 2 3 4 5 1 2 3 4 5\n", &["tetrahedra of one order", "-order 2"]),
    ("4 4 2 7 1 1 3 2 5\n", "4 4 2 7 1 1 2 3 4\n", &["tetrahedron 4", "tetrahedron 3"]),
    ("$Nodes\n5\n1 0 0 0\n2 1 0 0\n3 0 1 0\n4 0 0 1\n5 0 0 -1\n$EndNodes\n", "", &["section $Nodes"]),
    ("1 2 2 5 1 1 2 4\n", "1 2 2 5 1 1 2 3\n", &["held end", "boundary of the body"]),
    ("4 4 2 7 1 1 3 2 5\n$EndElements\n", "4 4 2", &["line 23", "end of the file"]),
    ("4\n1 2 2 5 1 1 2 4\n2 2 2 6 2 1 3 4\n3 4 2 7 1 1 2 3 4\n4 4 2 7 1 1 3 2 5\n", "2\n1 2 2 5 1 1 2 4\n2 2 2 6 2 1 3 4\n", &["expected tetrahedra", "gmsh -3"]),
];

#[test]
fn wrong_scenes_of_a_gmsh_body_are_refused() {
    let program = Program::new();
    fs::write(program.path("foot.msh"), FOOT_MESH).unwrap();
    let mut flaws = Vec::new();
    for (from, to, fragments) in SCENES {
        assert!(FOOT.contains(from), "{from}");
        let text = FOOT.replacen(from, to, 1);
        if let Some(flaw) = flaw(&program, text.as_bytes(), fragments) {
            flaws.push(format!("{from} -> {to}: {flaw}"));
        }
    }
    assert!(flaws.is_empty(), "{}", flaws.join("\n"));
}

#[test]
fn wrong_meshes_are_refused() {
    let program = Program::new();
    let mut flaws = Vec::new();
    for (from, to, fragments) in MESHES {
        assert!(PAIR_MESH.contains(from), "{from}");
        fs::write(program.path("foot.msh"), PAIR_MESH.replacen(from, to, 1)).unwrap();
        let fragments = [&["foot.msh"], fragments].concat();
        if let Some(flaw) = flaw(&program, FOOT.as_bytes(), &fragments) {
            flaws.push(format!("{from} -> {to}: {flaw}"));
        }
    }
    for noise in [&b""[..], b"\xff\x00\x12 noise", b"$MeshFormat"] {
        fs::write(program.path("foot.msh"), noise).unwrap();
        flaws.extend(flaw(&program, FOOT.as_bytes(), &["foot.msh"]));
    }
    assert!(flaws.is_empty(), "{}", flaws.join("\n"));
}

#[test]
fn a_mesh_larger_than_memory_is_refused_before_it_is_made() {
    let program = Program::new();
    // 4096³ cells take some 16 TB.
    let text = SCENE.replacen("[6, 2, 2]", "[4096, 4096, 4096]", 1);
    let fragments = ["assembling the problem", "of memory", "coarser mesh"];
    assert_eq!(flaw(&program, text.as_bytes(), &fragments), None);
}

/// Under limits of the shell the program refuses instead of being killed, and keeps what is stored.
#[cfg(target_os = "linux")]
#[test]
fn an_assembly_larger_than_its_limits_is_refused_and_the_mesh_is_kept() {
    let program = Program::new();
    let text = SCENE.replacen("[6, 2, 2]", "[60, 20, 20]", 1);
    fs::write(program.path("scene.toml"), text).unwrap();
    program
        .command(&["mesh", "scene.toml", "run.h5"])
        .assert()
        .success();
    let before = fs::read(program.path("run.h5")).unwrap();
    let binary = assert_cmd::cargo::cargo_bin("contact3d-pipe");
    // 27,783 nodes: the stiffness takes some 30 MB of memory and 15 MB of the disk, beside the 10
    // MB of the mesh; the factor takes some 300 MB of memory, results 17 MB of the disk. The limits lie
    // between: 461 MB for program and data, 31 MB for the file (in blocks of 512 bytes).
    for (limit, what) in [("-v 450000", "of memory"), ("-f 60000", "of disk space")] {
        let script = format!("ulimit {limit}; exec \"$0\" assemble run.h5 --threads 1");
        let refused = std::process::Command::new("sh")
            .args(["-c", &script])
            .arg(&binary)
            .current_dir(program.path(""))
            .output()
            .unwrap();
        let message = String::from_utf8_lossy(&refused.stderr);
        assert_eq!(refused.status.code(), Some(2), "{limit}: {message}");
        assert!(
            message.contains("factorising") && message.contains(what),
            "{message}"
        );
        assert_eq!(fs::read(program.path("run.h5")).unwrap(), before);
    }
}

#[cfg(target_os = "linux")]
#[test]
fn a_mesh_file_larger_than_memory_is_refused_before_it_is_read() {
    let program = Program::new();
    let mesh = fs::File::create(program.path("foot.msh")).unwrap();
    // 900 MB by the estimate; nothing of the file is on the disk.
    mesh.set_len(100_000_000).unwrap();
    fs::write(program.path("scene.toml"), FOOT).unwrap();
    let refused = std::process::Command::new("sh")
        .args([
            "-c",
            "ulimit -v 700000; exec \"$0\" mesh scene.toml run.h5 --threads 1",
        ])
        .arg(assert_cmd::cargo::cargo_bin("contact3d-pipe"))
        .current_dir(program.path(""))
        .output()
        .unwrap();
    let message = String::from_utf8_lossy(&refused.stderr);
    assert_eq!(refused.status.code(), Some(2), "{message}");
    assert!(message.contains("reading the mesh file"), "{message}");
    assert!(!program.path("run.h5").exists());
}

#[test]
fn changes_on_the_command_line_are_named_with_the_scene() {
    let program = Program::new();
    fs::write(program.path("scene.toml"), SCENE).unwrap();
    let change = "body.brick.cells=[6,3,2]";
    let refused = program
        .command(&["run", "scene.toml", "run.h5", "--set", change])
        .assert()
        .code(2);
    let message = String::from_utf8_lossy(&refused.get_output().stderr).into_owned();
    let words: Vec<&str> = message.split_whitespace().collect();
    let message = words.join(" ");
    assert!(
        message.contains("scene.toml with --set body.brick.cells=[6,3,2]"),
        "{message}"
    );
    assert!(message.contains("[6, 3, 2]"), "{message}");
}
