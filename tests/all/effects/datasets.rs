//! The datasets of a run file are those of the model features present, exactly.

use std::{collections::BTreeSet, fs};

use assert_cmd::Command;
use contact3d_pipe::LAYOUT;
use runfile::Reader;

use super::scenes::{BODY, CONTACT, LOAD, RAMPS, STEEL};

const CONTACT_ONLY: [&str; 33] = [
    "/solve/strategy",
    "/mesh/contact_normal",
    "/mesh/contact_nodes",
    "/mesh/contact_facets",
    "/mesh/contact_facet_pane",
    "/mesh/pane_area",
    "/mesh/pane_centre",
    "/mesh/pane_average",
    "/assemble/coupling_normal",
    "/load/dual_rhs",
    "/assemble/dual_operator",
    "/solve/multiplier_normal",
    "/solve/steplength",
    "/solve/local_stiffness_normal",
    "/post/contact_zone",
    "/post/normal_stress",
    "/post/pane_gap",
    "/post/contact_traction",
    "/post/contact_axis_1",
    "/post/contact_axis_2",
    "/post/zone_counts",
    "/post/resultants/normal_force",
    "/post/resultants/contact_force",
    "/post/resultants/largest_pressure",
    "/post/certificate/penetration",
    "/post/certificate/adhesion",
    "/post/certificate/complementarity",
    "/post/certificate/fixed_point",
    "/post/discretisation_error/penetration",
    "/post/discretisation_error/complementarity",
    "/VTKHDF/{}Data/contact_pressure",
    "/VTKHDF/{}Data/contact_gap",
    "/VTKHDF/{}Data/contact_zone",
];
const FRICTION_ONLY: [&str; 11] = [
    "/assemble/coupling_tangential",
    "/solve/multiplier_tangential",
    "/solve/local_stiffness_tangential",
    "/post/margin",
    "/post/tangential_stress",
    "/post/pane_slip",
    "/post/resultants/tangential_force",
    "/post/certificate/friction_bound",
    "/post/certificate/slip_direction",
    "/post/discretisation_error/friction",
    "/VTKHDF/{}Data/friction_stress",
];
const COULOMB_ONLY: [&str; 12] = [
    "/solve/slip_bound",
    "/solve/friction",
    "/solve/friction_inverse",
    "/solve/mapping_change",
    "/solve/spectral_radius",
    "/solve/determinant_sign",
    "/solve/fold_distance",
    "/post/scaled_tangential_stress",
    "/post/pane_friction",
    "/post/nodal_friction",
    "/VTKHDF/{}Data/friction_1",
    "/VTKHDF/{}Data/friction_2",
];
const SLIP_ONLY: [&str; 3] = [
    "/assemble/contact_compliance",
    "/load/slip_free",
    "/solve/slip",
];
const REGIONS_ONLY: [&str; 2] = ["/mesh/tetrahedron_region", "/post/material_nodes"];
const QUADRATIC_ONLY: [&str; 2] = ["/mesh/tetrahedron_mid_edges", "/mesh/facet_mid_edges"];

const FLOATING_ONLY: [&str; 9] = [
    "/VTKHDF/PointData/mechanism",
    "/assemble/rigid_modes",
    "/assemble/rigid_pins",
    "/assemble/rigid_spring",
    "/assemble/rigid_support",
    "/assemble/rigid_spring_response",
    "/solve/null_space_motions",
    "/solve/rigid_motion",
    "/solve/mechanism",
];

/// Runs a scene on linear tetrahedra and returns the datasets of a run that its file lacks, those of quadratic
/// ones apart; writers refuse any that is not in the table. Checkpoints, studies of accuracy, bounds and paths, and levels of adaptive
/// meshes are no part of a finished run.
fn absent_from(tables: &[&str]) -> BTreeSet<String> {
    let mut absent = absent_from_run(tables);
    for path in QUADRATIC_ONLY {
        assert!(
            absent.remove(path),
            "{path} is there with linear tetrahedra"
        );
    }
    absent
}

fn absent_from_run(tables: &[&str]) -> BTreeSet<String> {
    let folder = tempfile::tempdir().unwrap();
    let scene = [&[BODY, STEEL, LOAD], tables].concat().concat();
    fs::write(folder.path().join("scene.toml"), scene).unwrap();
    Command::cargo_bin("contact3d-pipe")
        .unwrap()
        .current_dir(folder.path())
        .args(["run", "scene.toml", "run.h5", "--no-figures", "--quiet"])
        .assert()
        .success();
    let reader = Reader::open(&folder.path().join("run.h5"), LAYOUT).unwrap();
    assert!(!reader.has("/adapt/status"), "no target for an error");
    assert_eq!(
        reader.has("/history/time"),
        tables.concat().contains("step")
    );
    assert_eq!(
        reader.has("/VTKHDF/Steps/Values"),
        tables.concat().contains("step")
    );
    let rows = LAYOUT.tables.iter().flat_map(|table| table.iter());
    let of_a_run = rows.filter(|row| {
        let others = [
            "/accuracy/",
            "/checkpoint/",
            "/adapt/",
            "/branches/",
            "/bound/",
            "/history/",
        ];
        !others.iter().any(|group| row.path.starts_with(group))
    });
    let absent = of_a_run.filter(|row| !reader.has(row.path));
    let absent = absent.filter(|row| !row.path.starts_with("/VTKHDF/Steps/"));
    let mut absent: BTreeSet<String> = absent.map(|row| row.path.to_owned()).collect();
    for path in FLOATING_ONLY {
        assert!(
            absent.remove(path),
            "{path} is there, and the clamp holds the body"
        );
    }
    assert!(absent.remove(INDICATOR), "no target for a quantity");
    // Only where the largest stress is at one.
    absent.remove("/post/largest_von_mises/concentration");
    absent.remove("/post/largest_von_mises/concentration_place");
    let tables = tables.concat();
    // Above a half of the answer its quantities have no estimates.
    let error = reader.read_vec::<f64>("/post/discretisation_error/total");
    let is_estimated = !tables.contains("step") && error.is_ok_and(|error| error[0] < 0.5);
    for path in QUANTITIES {
        assert_eq!(absent.remove(path), !is_estimated, "{path}");
    }
    absent
}

/// What load histories lack.
const QUANTITIES: [&str; 7] = [
    "/solve/quantities/name",
    "/solve/quantities/unit",
    "/solve/quantities/value",
    "/solve/quantities/signed_error",
    "/solve/quantities/range",
    "/solve/quantities/box",
    "/solve/quantities/kinks",
];

/// What only a mesh has that is refined for a quantity.
const INDICATOR: &str = "/solve/quantities/indicator";

/// What only a scene with an obstacle has.
const OBSTACLE_ONLY: [&str; 1] = ["/mesh/contact_clearance"];

/// What only a scene with an obstacle of triangles has.
const TRIANGLES_ONLY: [&str; 4] = [
    "/mesh/obstacle_points",
    "/mesh/obstacle_triangles",
    "/mesh/obstacle_normals",
    "/mesh/obstacle_contact",
];

/// What only clamps with values have.
const PRESCRIBED_ONLY: [&str; 2] = [
    "/load/prescribed_displacement",
    "/post/resultants/clamp_work",
];

/// What only springs have.
const SPRINGS_ONLY: [&str; 2] = [
    "/post/resultants/spring_energy",
    "/post/resultants/spring_force",
];

/// What only tools have, and what only tools have that are bonded to a face.
const TOOLS_ONLY: [&str; 10] = [
    "/assemble/tool_degree_of_freedom",
    "/load/prescribed_tool_rows",
    "/solve/tool_rows",
    "/post/tools/point",
    "/post/tools/displacement",
    "/post/tools/turn",
    "/post/tools/force",
    "/post/tools/moment",
    "/assemble/tied_nodes",
    "/assemble/tied_levers",
];

/// What only a load history has, beside its own group.
const HISTORY_ONLY: [&str; 1] = ["/solve/history_digest"];
/// What only contact faces have whose normals are not the same everywhere, several ones among them.
const VARYING_NORMALS_ONLY: [&str; 2] = [
    "/mesh/contact_node_normal",
    "/VTKHDF/CellData/contact_normal",
];
/// What only several contact faces have, and what only one has.
const SEVERAL_FACES_ONLY: [&str; 11] = [
    "/mesh/contact_node_normal",
    "/VTKHDF/CellData/contact_normal",
    "/mesh/contact_face_names",
    "/mesh/contact_face_nodes",
    "/mesh/contact_face_facets",
    "/mesh/contact_face_panes",
    "/mesh/contact_face_is_nodal",
    "/post/faces/zone_counts",
    "/post/faces/normal_force",
    "/post/faces/largest_pressure",
    "/VTKHDF/CellData/contact_face",
];
/// What only glued faces have.
const GLUED_ONLY: [&str; 4] = [
    "/mesh/glued_nodes",
    "/mesh/glued_shares",
    "/mesh/joint_gap",
    "/mesh/joint_cover",
];
/// What only several bodies that touch each other have.
const BODIES_ONLY: [&str; 8] = [
    "/mesh/body_names",
    "/mesh/body_nodes",
    "/mesh/body_tetrahedra",
    "/mesh/opposite_points",
    "/mesh/opposite_panes",
    "/mesh/opposite_pairs",
    "/mesh/opposite_integrals",
    "/VTKHDF/CellData/body",
];
const FACES_WITH_FRICTION_ONLY: &str = "/post/faces/tangential_force";
const ONE_FACE_ONLY: [&str; 2] = ["/mesh/contact_normal", "/post/resultants/tangential_force"];

/// What only a factor in single precision has, and one that is in a file beside the run file: those of run files are made again.
const STORED_FACTORS_ONLY: [&str; 8] = [
    "/assemble/factor/supernode_columns",
    "/assemble/factor/row_offsets",
    "/assemble/factor/row_indices",
    "/assemble/factor/value_offsets",
    "/assemble/contact_compliance_single",
    "/assemble/dual_operator_single",
    "/assemble/factor/values_single",
    "/assemble/factor/values",
];

/// The paths of some effects. Fields of the contact face are cell data of ParaView with panes and
/// point data with nodal multipliers; `present` names those that are there.
fn expected(effects: &[&[&str]], present: Option<&str>) -> BTreeSet<String> {
    let absent = effects.concat().into_iter();
    let mut paths: BTreeSet<String> = absent
        .flat_map(|path| ["Cell", "Point"].map(|data| path.replace("{}", data)))
        .collect();
    paths.extend(STORED_FACTORS_ONLY.map(str::to_owned));
    paths.extend(OBSTACLE_ONLY.map(str::to_owned));
    paths.extend(TRIANGLES_ONLY.map(str::to_owned));
    paths.extend(PRESCRIBED_ONLY.map(str::to_owned));
    paths.extend(SPRINGS_ONLY.map(str::to_owned));
    paths.extend(HISTORY_ONLY.map(str::to_owned));
    paths.extend(TOOLS_ONLY.map(str::to_owned));
    paths.extend(SEVERAL_FACES_ONLY.map(str::to_owned));
    paths.extend(BODIES_ONLY.map(str::to_owned));
    paths.extend(GLUED_ONLY.map(str::to_owned));
    paths.insert(FACES_WITH_FRICTION_ONLY.to_owned());
    let all = [&CONTACT_ONLY[..], &FRICTION_ONLY, &COULOMB_ONLY].concat();
    if let Some(present) = present {
        let other = if present == "Cell" { "Point" } else { "Cell" };
        let fields = all.iter().filter(|path| path.contains("{}"));
        paths.extend(fields.map(|path| path.replace("{}", other)));
    }
    paths
}

#[test]
fn without_contact() {
    let absent = [
        &CONTACT_ONLY[..],
        &FRICTION_ONLY,
        &COULOMB_ONLY,
        &SLIP_ONLY,
        &REGIONS_ONLY,
    ];
    assert_eq!(absent_from(&[]), expected(&absent, None));
}

#[test]
fn without_friction() {
    let absent: [&[&str]; 4] = [&FRICTION_ONLY, &COULOMB_ONLY, &SLIP_ONLY, &REGIONS_ONLY];
    assert_eq!(absent_from(&[CONTACT]), expected(&absent, Some("Cell")));
}

#[test]
fn with_a_given_slip_bound() {
    let absent: [&[&str]; 3] = [&COULOMB_ONLY, &SLIP_ONLY, &REGIONS_ONLY];
    let found = absent_from(&[CONTACT, "[friction]\nslip_bound = 1e6"]);
    assert_eq!(found, expected(&absent, Some("Cell")));
}

#[test]
fn with_constant_coefficients() {
    let absent: [&[&str]; 2] = [&SLIP_ONLY, &REGIONS_ONLY];
    let found = absent_from(&[CONTACT, "[friction]\ncoefficient.constant = 0.3"]);
    assert_eq!(found, expected(&absent, Some("Cell")));
}

#[test]
fn with_coefficients_that_follow_the_slip() {
    let found = absent_from(&[CONTACT, RAMPS]);
    assert_eq!(found, expected(&[&REGIONS_ONLY], Some("Cell")));
}

#[test]
fn with_regions_and_nodal_multipliers_everything_is_there_but_the_panes() {
    let region = "[[region]]\npart.box = [[0, 0, 0], [1, 1, 1]]\n\
                  material.isotropic = { young_modulus = 1e11, poisson_ratio = 0.3 }\n";
    let found = absent_from(&[CONTACT, "multipliers = 'nodal'", RAMPS, region]);
    let panes: [&[&str]; 1] = [&["/mesh/contact_facet_pane"]];
    assert_eq!(found, expected(&panes, Some("Point")));
}

#[test]
fn with_an_obstacle_its_distance_is_there_and_normals_where_they_vary() {
    let sphere = "obstacle.sphere = { centre = [1.5, 0.5, -9.0], radius = 9.0 }\n";
    let found = absent_from(&[CONTACT, sphere, RAMPS]);
    let [clearance] = OBSTACLE_ONLY;
    let mut absent = expected(&[&REGIONS_ONLY, &["/mesh/contact_normal"]], Some("Cell"));
    assert!(absent.remove(clearance));
    absent.retain(|path| !VARYING_NORMALS_ONLY.contains(&path.as_str()));
    assert_eq!(found, absent);

    let plane = "obstacle.half_space = { point = [0.0, 0.0, -1e-5], normal = [0.0, 0.0, 1.0] }\n";
    let found = absent_from(&[CONTACT, plane, RAMPS]);
    let mut absent = expected(&[&REGIONS_ONLY], Some("Cell"));
    assert!(absent.remove(clearance));
    assert_eq!(found, absent);
}

#[test]
fn with_prescribed_displacements() {
    let clamp = "[[clamp]]\nface = 'x_max'\ncomponents = ['y']\nvalue = [0.0, 1e-6, 0.0]\n";
    let mut absent = expected(&[&REGIONS_ONLY], Some("Cell"));
    absent.retain(|path| !PRESCRIBED_ONLY.contains(&path.as_str()));
    assert_eq!(absent_from(&[clamp, CONTACT, RAMPS]), absent);
    // Values of zero are no values.
    let resting = clamp.replace("1e-6", "0");
    let absent = expected(&[&REGIONS_ONLY], Some("Cell"));
    assert_eq!(absent_from(&[&resting, CONTACT, RAMPS]), absent);
}

#[test]
fn with_springs() {
    let spring = "[[spring]]\nface = 'x_max'\nnormal = 1e9\n";
    let mut absent = expected(&[&REGIONS_ONLY], Some("Cell"));
    absent.retain(|path| !SPRINGS_ONLY.contains(&path.as_str()));
    assert_eq!(absent_from(&[spring, CONTACT, RAMPS]), absent);
}

#[test]
fn with_a_tool_that_moves() {
    let tool = "tool = 'press'\n[[tool]]\nname = 'press'\ndisplacement = [0.0, 0.0, 1e-6]\n";
    let mut absent = expected(&[&REGIONS_ONLY], Some("Cell"));
    let own = &TOOLS_ONLY[..8];
    absent.retain(|path| !own.contains(&path.as_str()) && path != PRESCRIBED_ONLY[0]);
    assert_eq!(absent_from(&[CONTACT, tool, RAMPS]), absent);
}

#[test]
fn with_a_load_history() {
    let mut absent = expected(&[&REGIONS_ONLY], Some("Cell"));
    absent.retain(|path| !HISTORY_ONLY.contains(&path.as_str()));
    // A series has no estimate of the error and no tensors.
    absent.insert("/VTKHDF/CellData/error_indicator".to_owned());
    absent.insert("/VTKHDF/PointData/stress".to_owned());
    assert_eq!(
        absent_from(&[CONTACT, RAMPS, "[[step]]\n[[step]]\n"]),
        absent
    );
}

#[test]
fn with_several_contact_faces() {
    let faces = "[[contact]]\nface = 'z_min'\n[[contact]]\nface = 'y_max'\n";
    let absent: [&[&str]; 5] = [
        &FRICTION_ONLY,
        &COULOMB_ONLY,
        &SLIP_ONLY,
        &REGIONS_ONLY,
        &ONE_FACE_ONLY,
    ];
    let mut frictionless = expected(&absent, Some("Cell"));
    frictionless.retain(|path| !SEVERAL_FACES_ONLY.contains(&path.as_str()));
    assert_eq!(absent_from(&[faces]), frictionless);
    let mut rough = expected(&[&REGIONS_ONLY, &ONE_FACE_ONLY], Some("Cell"));
    rough.retain(|path| !SEVERAL_FACES_ONLY.contains(&path.as_str()));
    rough.remove(FACES_WITH_FRICTION_ONLY);
    assert_eq!(absent_from(&[faces, RAMPS]), rough);
}

#[test]
fn with_quadratic_tetrahedra() {
    let element = "[body]\nelement = 'P2'\n";
    let absent = absent_from_run(&[CONTACT, RAMPS, element]);
    assert_eq!(absent, expected(&[&REGIONS_ONLY], Some("Cell")));
}

#[test]
fn with_the_implicit_operator_nothing_dense_is_there() {
    let settings = "[assemble]\ndual_operator = 'implicit'\n";
    let found = absent_from(&[CONTACT, RAMPS, settings]);
    let absent: [&[&str]; 2] = [
        &[
            "/assemble/dual_operator",
            "/assemble/contact_compliance",
            "/load/slip_free",
            "/solve/strategy",
            "/solve/mapping_change",
            "/solve/spectral_radius",
            "/solve/determinant_sign",
            "/solve/fold_distance",
        ],
        &REGIONS_ONLY,
    ];
    assert_eq!(found, expected(&absent, Some("Cell")));
}

#[test]
fn with_two_bodies_theirs_are_there_and_the_error_of_both() {
    const BLOCKS: &str = "
        title = 'two blocks'
        [[body]]
        name = 'lower'
        brick = { size = [1.0, 1.0, 1.0], cells = [2, 2, 2] }
        [[body]]
        name = 'upper'
        brick = { size = [1.0, 1.0, 1.0], cells = [4, 4, 2] }
        origin = [0.0, 0.0, 1.0]
        [[body]]
        name = 'cap'
        brick = { size = [1.0, 1.0, 0.5], cells = [3, 3, 1] }
        origin = [0.0, 0.0, 2.0]
        [[clamp]]
        face = 'lower.z_min'
        [[clamp]]
        face = 'cap.z_max'
        value = [0.0, 0.0, -1e-4]
        [[contact]]
        between = ['lower.z_max', 'upper.z_min']
        [[contact]]
        between = ['upper.z_max', 'cap.z_min']
        glued = true
    ";
    let folder = tempfile::tempdir().unwrap();
    fs::write(folder.path().join("scene.toml"), [BLOCKS, STEEL].concat()).unwrap();
    Command::cargo_bin("contact3d-pipe")
        .unwrap()
        .current_dir(folder.path())
        .args(["run", "scene.toml", "run.h5", "--no-figures", "--quiet"])
        .assert()
        .success();
    let reader = Reader::open(&folder.path().join("run.h5"), LAYOUT).unwrap();
    for path in BODIES_ONLY.iter().chain(&GLUED_ONLY) {
        assert!(reader.has(path), "{path}");
    }
    assert!(reader.has("/post/discretisation_error/total"));
    assert!(reader.has("/post/discretisation_error/indicator"));
}
