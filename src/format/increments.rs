//! `/history`: the increments of a load history, every dataset with one row for each.

use contact3d::{
    history::{HistoryErrors, StepPane, StepRecord},
    post::{ToolState, Zone},
    scene::Scene,
};
use runfile::{
    Extent,
    Extent::{Fixed, Named},
    Group, GroupWriter, Kind, Reader, StoreError,
};
use units::Dimension;

use super::{
    FormatError, Stage,
    extents::{self, length},
    fields::{Condition, Fields, each, fields, put_each, write_value},
    quantities, require,
};

/// The increments of a load history that were solved.
pub const GROUP: Group = Group::new("history", Stage::Solve.command());

pub(super) const STEP: &str = "/history/step";
pub(super) const DISSIPATION: &str = "/history/dissipation";
const TITLE: &str = "/history/step_title";
const TIME: &str = "/history/time";
const ESTIMATED_ERROR: &str = "/history/estimated_error";

const NO_ESTIMATE: &str = "absent unless the scene asks for an error";

const NO_CONTACT: Condition<StepRecord> =
    ("absent without contact", |record| !record.panes.is_empty());
const NO_FRICTION: Condition<StepRecord> = ("absent without friction", |record| {
    !record.tangential.is_empty()
});
const FLAT: Condition<StepRecord> = (
    "absent where no face with friction and no obstacle before it is curved",
    |record| !record.slip_origin.is_empty(),
);
const NO_COULOMB: Condition<StepRecord> = ("absent without Coulomb friction", |record| {
    let pane = record.panes.first();
    pane.is_some_and(|pane| !pane.coefficients[0].is_nan())
});
const ONE_FACE: Condition<StepRecord> = (
    "absent without friction, and without several contact faces",
    |record| !record.tangential.is_empty() && record.face_dissipation.len() > 1,
);
const NO_TOOL: Condition<StepRecord> = ("absent without tools", |record| !record.tools.is_empty());
const TOOL_VECTORS: &[Extent] = &[Named("n_increments"), Named("n_tools"), extents::XYZ];
const ROWS: &[Extent] = &[Named("n_increments")];
const VECTORS: &[Extent] = &[Named("n_increments"), extents::XYZ];
const PANES: &[Extent] = &[Named("n_increments"), Named("n_panes")];
const PANE_PAIRS: &[Extent] = &[
    Named("n_increments"),
    Named("n_friction_panes"),
    extents::FRICTION_AXES,
];

pub(super) const INCREMENTS: Fields<StepRecord> = fields! { StepRecord => GROUP;
    {Kind::Text} TITLE, ROWS, Dimension::Number, "Title of the step that each increment belongs to.";
    [|record| record.increment.step] STEP, ROWS, Dimension::Number, "Step of the scene, from 0, that each increment belongs to.";
    (increment.time) TIME, ROWS, Dimension::Time, "Time at the end of each increment.".symbol("t");
    (status) "/history/status", ROWS, Dimension::Number, "How each solve ended, as /solve/status; one without a solution is the last, and has NaN for forces and energies.";
    (solved_by) "/history/method", ROWS, Dimension::Number, "Algorithm that gave each answer, as /solve/method.";
    (accuracy) "/history/accuracy", ROWS, Dimension::Number, "Relative error of the multipliers, as /solve/accuracy.";
    (applications) "/history/applications", ROWS, Dimension::Number, "Applications of the inverse stiffness matrix, as /solve/applications.".symbol("n_A");
    (certificate) "/history/certificate", ROWS, Dimension::Number, "Largest figure of the certificate of each answer.";
    (dual_rhs) "/history/dual_rhs", &[Named("n_increments"), Named("n_multipliers")], Dimension::VOLUME, "Right-hand side B A^-1 l of each dual problem, minus the integrated gap in its first m entries and minus the integrated tangential displacement where the increment begins in the others.".symbol("h").when(NO_CONTACT);
    [|record| record.multiplier[..record.panes.len()].to_vec(), |record, normal| record.multiplier = normal] "/history/multiplier_normal", PANES, Dimension::STRESS, "Normal contact multiplier, the pressure on each pane.".symbol("lambda_nu").when(NO_CONTACT);
    [|record| record.multiplier[record.panes.len()..].as_chunks::<2>().0.to_vec(), |record, pairs: Vec<[f64; 2]>| record.multiplier.extend(pairs.as_flattened())] "/history/multiplier_tangential", PANE_PAIRS, Dimension::STRESS, "Tangential contact multipliers along t1 and t2.".symbol("lambda_t").when(NO_FRICTION);
    (displacement) "/history/displacement", &[Named("n_increments"), Named("n_nodes"), extents::XYZ], Dimension::LENGTH, "Displacement of every node.".symbol("u");
    (von_mises) "/history/von_mises", &[Named("n_increments"), Named("n_material_nodes")], Dimension::STRESS, "Von Mises stress at each node in each of its materials, as /post/von_mises.";
    (tangential) "/history/tangential_displacement", &[Named("n_increments"), Named("n_contact_nodes"), extents::FRICTION_AXES], Dimension::LENGTH, "Tangential displacement of the contact nodes along t1 and t2: the slip of an increment is its row less the one before.".symbol("u_t").when(NO_FRICTION);
    (slip_origin) "/history/slip_origin", &[Named("n_increments"), Named("n_contact_nodes"), extents::FRICTION_AXES], Dimension::LENGTH, "Tangential displacement that the slip of each increment is counted from: that of the row before, and where nodes of a curved face touch within the increment, that at which they touch.".when(FLAT);
    (path) "/history/sliding_path", &[Named("n_increments"), Named("n_contact_nodes"), Fixed(3)], Dimension::LENGTH, "Lengths of the path that each contact node slid: sums of |Delta u_t1|, of |Delta u_t2| and of |Delta u_t| over the increments so far.".when(NO_FRICTION);
    [|record| each(&record.panes, |pane| pane.zone), put_zones] "/history/contact_zone", PANES, Dimension::Number, "What each pane does in the increment, as /post/contact_zone.".when(NO_CONTACT);
    [|record| each(&record.panes, |pane| pane.gap), |record, gaps| put_each(&mut record.panes, gaps, |pane, gap| pane.gap = gap)] "/history/gap", PANES, Dimension::LENGTH, "Mean distance of each pane to the foundation.".symbol("d - u_nu").when(NO_CONTACT);
    [|record| each(friction_panes(record), |pane| pane.slip), |record, slips| put_each(&mut record.panes, slips, |pane, slip| pane.slip = slip)] "/history/slip", PANE_PAIRS, Dimension::LENGTH, "Mean slip of each pane in the increment.".symbol("Delta u_t").when(NO_FRICTION);
    [|record| each(friction_panes(record), |pane| pane.coefficients), |record, pairs| put_each(&mut record.panes, pairs, |pane, pair| pane.coefficients = pair)] "/history/friction", PANE_PAIRS, Dimension::Number, "Coefficients of friction acting on each pane.".symbol("F_1, F_2").when(NO_COULOMB);
    (applied_force) "/history/applied_force", VECTORS, Dimension::FORCE, "Resultant of the applied loads.";
    (clamp_force) "/history/clamp_force", VECTORS, Dimension::FORCE, "Reaction of the clamps.";
    (contact_force) "/history/contact_force", VECTORS, Dimension::FORCE, "Force of the foundation on the body.".when(NO_CONTACT);
    (multiplier_force) "/history/multiplier_force", &[Named("n_increments"), extents::CONTACT_AXES], Dimension::FORCE, "Sums of area times multiplier: normal, along t1, along t2; the last two zero where there is no friction, or of several faces, whose axes differ: `forces` has those of each.".when(NO_CONTACT);
    (forces) "/history/forces", &[Named("n_increments"), Named("n_forces"), extents::XYZ], Dimension::FORCE, "Force on the body of each clamp, load and contact face, in the order of /post/forces.";
    [|record| each(&record.tools, |tool| tool.displacement), |record, values| put_tools(record, values, |tool, value| tool.displacement = value)] "/history/tool_displacement", TOOL_VECTORS, Dimension::LENGTH, "Displacement of the point of each tool.".when(NO_TOOL);
    [|record| each(&record.tools, |tool| tool.turn), |record, values| put_tools(record, values, |tool, value| tool.turn = value)] "/history/tool_turn", TOOL_VECTORS, Dimension::Number, "Rotation vector of each tool in radians.".when(NO_TOOL);
    [|record| each(&record.tools, |tool| tool.force), |record, values| put_tools(record, values, |tool, value| tool.force = value)] "/history/tool_force", TOOL_VECTORS, Dimension::FORCE, "Force of each tool on the body, which is that on the tool from outside.".when(NO_TOOL);
    [|record| each(&record.tools, |tool| tool.moment), |record, values| put_tools(record, values, |tool, value| tool.moment = value)] "/history/tool_moment", TOOL_VECTORS, Dimension::MOMENT, "Its moment about the point of the tool: where it begins, or where the increment drives it to if normals follow it.".when(NO_TOOL);
    (reaction) "/history/clamp_reaction", &[Named("n_increments"), Named("n_nodes"), extents::XYZ], Dimension::FORCE, "Forces of the clamps on the nodes.".optional("absent where all clamps hold at zero in all steps").compressed();
    (loaded_force) "/history/loaded_force", VECTORS, Dimension::FORCE, "Force on the body of tractions, pressures and clamps that move; of the body force where there are none.";
    (loaded_displacement) "/history/loaded_displacement", VECTORS, Dimension::LENGTH, "Mean displacement of the faces that they act on; of all nodes where there are none.";
    (contact_displacement) "/history/contact_displacement", &[Named("n_increments"), extents::FRICTION_AXES], Dimension::LENGTH, "Mean tangential displacement of the contact face along t1 and t2, against what it touches.".when(NO_FRICTION);
    (energies.strain) "/history/strain_energy", ROWS, Dimension::Energy, "Strain energy u.Au / 2 at the end of each increment.";
    (energies.load_work) "/history/load_work", ROWS, Dimension::Energy, "Work of the loads and of clamps that move in each increment, along a straight way between its ends.";
    (energies.normal_work) "/history/normal_work", ROWS, Dimension::Energy, "Work of the contact pressures on the foundation in each increment, likewise, by pressures and normals of both ends.".when(NO_CONTACT);
    (energies.dissipation) DISSIPATION, ROWS, Dimension::Energy, "Energy that friction took in each increment: the integral of lambda_t . Delta u_t with lambda_t at its end.".when(NO_FRICTION);
    (face_dissipation) "/history/face_dissipation", &[Named("n_increments"), Named("n_contact_faces")], Dimension::Energy, "The same on each contact face, in the order of /mesh/contact_face_names.".when(ONE_FACE);
    (energies.imbalance) "/history/energy_imbalance", ROWS, Dimension::Energy, "Work of the loads in each increment less the gain of strain energy, the work on the foundation and the dissipation; falls in proportion to the increments.";
    {Kind::F64} ESTIMATED_ERROR, ROWS, Dimension::Number, "Estimated |u_h - u|_A of each increment, given those before it, over the largest |u_h|_A of the history: the largest is the estimated error of the mesh.".optional(NO_ESTIMATE);
    (error_energy) "/history/error_energy", &[Named("n_increments"), Named("n_tetrahedra")], Dimension::Energy, "Share of each tetrahedron in the square of that error, before it is made relative.".symbol("eta_T^2").optional(NO_ESTIMATE);
};

/// The panes with friction, which come first.
fn friction_panes(record: &StepRecord) -> &[StepPane] {
    let pairs = (record.multiplier.len() - record.panes.len()) / 2;
    &record.panes[..pairs]
}

/// Puts a figure into each tool, and makes the tools where they are not there.
fn put_tools<V>(record: &mut StepRecord, values: Vec<V>, put: fn(&mut ToolState, V)) {
    record.tools.resize(values.len(), ToolState::default());
    put_each(&mut record.tools, values, put);
}

/// Makes the panes, whose other figures follow.
fn put_zones(record: &mut StepRecord, zones: Vec<Zone>) {
    let panes = zones.into_iter().map(|zone| StepPane {
        zone,
        gap: 0.0,
        slip: [0.0; 2],
        coefficients: [f64::NAN; 2],
    });
    record.panes = panes.collect();
}

/// Writes the increments that were solved.
pub fn write(
    writer: &mut GroupWriter<'_>,
    scene: &Scene,
    records: &[StepRecord],
) -> Result<(), StoreError> {
    let steps = records.iter().map(|record| record.increment.step);
    let titles: Vec<String> = steps.map(|step| scene.step_title(step)).collect();
    write_value(writer, TITLE, &titles)?;
    if let Some(errors) = HistoryErrors::new(records, None) {
        write_value(writer, ESTIMATED_ERROR, &errors.relative)?;
    }
    quantities::write_of_increments(writer, scene, records)?;
    INCREMENTS.write_rows(writer, records)
}

/// How many increments a file holds.
pub fn n_increments(reader: &Reader) -> Result<usize, FormatError> {
    Ok(length::<f64>(reader, TIME)?.unwrap_or(0))
}

/// Reads the increments back; none where there is no history.
pub fn read(reader: &Reader, scene: &Scene) -> Result<Vec<StepRecord>, FormatError> {
    let increments = scene.increments();
    let mut records = INCREMENTS.read_rows(reader, StepRecord::default)?;
    let known = increments.iter().map(|increment| increment.time);
    let mut times = records.iter().map(|record| record.increment.time);
    let n_increments = increments.len();
    let fits =
        records.len() <= n_increments && known.zip(&mut times).all(|(known, time)| known == time);
    require(fits, TIME, || {
        format!("expected the times of {n_increments} increments, found others")
    })?;
    for (record, increment) in records.iter_mut().zip(increments) {
        record.increment = increment;
    }
    quantities::read_of_increments(reader, scene, &mut records)?;
    Ok(records)
}
