//! `/history`: the increments of a load history, every dataset with one row for each.

use contact3d::{
    history::{StepEnergies, StepPane, StepRecord},
    post::Zone,
    scene::Scene,
};
use runfile::{
    DatasetSpec, Extent,
    Extent::{Fixed, Named},
    Group, GroupWriter, Kind, Reader, StoreError, StoredEnum,
};
use units::Dimension;

use super::{
    FormatError, Stage, axes,
    columns::Columns,
    outcome::{StoredMethod, StoredStatus},
    post::StoredZone,
    read_index_vec,
    solve::HISTORY_DIGEST,
};

/// The increments of a load history that were solved.
pub const GROUP: Group = Group::new("history", Stage::Solve.command());

const TITLE: &str = "/history/step_title";
const STEP: &str = "/history/step";
pub(super) const TIME: &str = "/history/time";
const STATUS: &str = "/history/status";
const METHOD: &str = "/history/method";
const ACCURACY: &str = "/history/accuracy";
const APPLICATIONS: &str = "/history/actions";
const CERTIFICATE: &str = "/history/certificate";
const DUAL_RHS: &str = "/history/dual_rhs";
const MULTIPLIER_NORMAL: &str = "/history/multiplier_normal";
const MULTIPLIER_TANGENTIAL: &str = "/history/multiplier_tangential";
const DISPLACEMENT: &str = "/history/displacement";
const VON_MISES: &str = "/history/von_mises";
const TANGENTIAL: &str = "/history/tangential_displacement";
const PATH: &str = "/history/sliding_path";
const ZONE: &str = "/history/contact_zone";
const GAP: &str = "/history/gap";
const SLIP: &str = "/history/slip";
const FRICTION: &str = "/history/friction";
const APPLIED: &str = "/history/applied_force";
const CLAMP: &str = "/history/clamp_force";
const CONTACT: &str = "/history/contact_force";
const MULTIPLIER_FORCE: &str = "/history/multiplier_force";
const LOADED_FORCE: &str = "/history/loaded_force";
const LOADED: &str = "/history/loaded_displacement";
const FORCES: &str = "/history/forces";
const REACTION: &str = "/history/clamp_reaction";
const CONTACT_DISPLACEMENT: &str = "/history/contact_displacement";
const STRAIN: &str = "/history/strain_energy";
const LOAD_WORK: &str = "/history/load_work";
const NORMAL_WORK: &str = "/history/normal_work";
const DISSIPATION: &str = "/history/dissipation";
const FACE_DISSIPATION: &str = "/history/face_dissipation";
const IMBALANCE: &str = "/history/energy_imbalance";

const NO_CONTACT: &str = "absent without contact";
const NO_FRICTION: &str = "absent without friction";
const NO_COULOMB: &str = "absent without Coulomb friction";
const ROWS: &[Extent] = &[Named("n_increments")];
const VECTORS: &[Extent] = &[Named("n_increments"), axes::XYZ];
const PANES: &[Extent] = &[Named("n_increments"), Named("n_panes")];
const PANE_PAIRS: &[Extent] = &[
    Named("n_increments"),
    Named("n_friction_panes"),
    axes::FRICTION_AXES,
];

#[rustfmt::skip]
pub(super) const TABLE: &[DatasetSpec] = &[
    GROUP.row(TITLE, Kind::Text, ROWS, Dimension::Number, "Title of the step that each increment belongs to."),
    GROUP.row(STEP, Kind::I64, ROWS, Dimension::Number, "Step of the scene, from 0, that each increment belongs to."),
    GROUP.row(TIME, Kind::F64, ROWS, Dimension::Time, "Time at the end of each increment.").symbol("t"),
    GROUP.row(STATUS, Kind::Enum(StoredStatus::SPEC), ROWS, Dimension::Number, "How each solve ended, as /solve/status; one that failed is the last."),
    GROUP.row(METHOD, Kind::Enum(StoredMethod::SPEC), ROWS, Dimension::Number, "Algorithm that gave each answer, as /solve/method."),
    GROUP.row(ACCURACY, Kind::F64, ROWS, Dimension::Number, "Relative error of the multipliers, as /solve/accuracy."),
    GROUP.row(APPLICATIONS, Kind::I64, ROWS, Dimension::Number, "Applications of the inverse stiffness matrix, as /solve/actions.").symbol("n_A"),
    GROUP.row(CERTIFICATE, Kind::F64, ROWS, Dimension::Number, "Largest figure of the certificate of each answer."),
    GROUP.row(DUAL_RHS, Kind::F64, &[Named("n_increments"), Named("n_multipliers")], Dimension::VOLUME, "Right-hand side B A^-1 l of each dual problem, minus the integrated gap in its first m entries and minus the integrated tangential displacement where the increment begins in the others.").symbol("h").optional(NO_CONTACT),
    GROUP.row(MULTIPLIER_NORMAL, Kind::F64, PANES, Dimension::STRESS, "Normal contact multiplier, the pressure on each pane.").symbol("lambda_nu").optional(NO_CONTACT),
    GROUP.row(MULTIPLIER_TANGENTIAL, Kind::F64, PANE_PAIRS, Dimension::STRESS, "Tangential contact multipliers along t1 and t2.").symbol("lambda_t").optional(NO_FRICTION),
    GROUP.row(DISPLACEMENT, Kind::F64, &[Named("n_increments"), Named("n_nodes"), axes::XYZ], Dimension::LENGTH, "Displacement of every node.").symbol("u"),
    GROUP.row(VON_MISES, Kind::F64, &[Named("n_increments"), Named("n_tetrahedra")], Dimension::STRESS, "Von Mises stress of each tetrahedron."),
    GROUP.row(TANGENTIAL, Kind::F64, &[Named("n_increments"), Named("n_contact_nodes"), axes::FRICTION_AXES], Dimension::LENGTH, "Tangential displacement of the contact nodes along t1 and t2: the slip of an increment is its row less the one before.").symbol("u_t").optional(NO_FRICTION),
    GROUP.row(PATH, Kind::F64, &[Named("n_increments"), Named("n_contact_nodes"), Fixed(3)], Dimension::LENGTH, "Lengths of the path that each contact node slid: sums of |Delta u_t1|, of |Delta u_t2| and of |Delta u_t| over the increments so far.").optional(NO_FRICTION),
    GROUP.row(ZONE, Kind::Enum(StoredZone::SPEC), PANES, Dimension::Number, "What each pane does in the increment, as /post/contact_zone.").optional(NO_CONTACT),
    GROUP.row(GAP, Kind::F64, PANES, Dimension::LENGTH, "Mean distance of each pane to the foundation.").symbol("d - u_nu").optional(NO_CONTACT),
    GROUP.row(SLIP, Kind::F64, PANE_PAIRS, Dimension::LENGTH, "Mean slip of each pane in the increment.").symbol("Delta u_t").optional(NO_FRICTION),
    GROUP.row(FRICTION, Kind::F64, PANE_PAIRS, Dimension::Number, "Coefficients of friction acting on each pane.").symbol("F_1, F_2").optional(NO_COULOMB),
    GROUP.row(APPLIED, Kind::F64, VECTORS, Dimension::FORCE, "Resultant of the applied loads."),
    GROUP.row(CLAMP, Kind::F64, VECTORS, Dimension::FORCE, "Reaction of the clamps."),
    GROUP.row(CONTACT, Kind::F64, VECTORS, Dimension::FORCE, "Force of the foundation on the body.").optional(NO_CONTACT),
    GROUP.row(MULTIPLIER_FORCE, Kind::F64, &[Named("n_increments"), axes::CONTACT_AXES], Dimension::FORCE, "Sums of area times multiplier: normal, along t1, along t2; zero where there is no friction.").optional(NO_CONTACT),
    GROUP.row(FORCES, Kind::F64, &[Named("n_increments"), Named("n_forces"), axes::XYZ], Dimension::FORCE, "Force on the body of each clamp, load and contact face, in the order of /post/forces."),
    GROUP.row(REACTION, Kind::F64, &[Named("n_increments"), Named("n_nodes"), axes::XYZ], Dimension::FORCE, "Forces of the clamps on the nodes.").optional("absent where all clamps hold at zero in all steps").compressed(),
    GROUP.row(LOADED_FORCE, Kind::F64, VECTORS, Dimension::FORCE, "Force on the body of tractions, pressures and clamps that move; of the body force where there are none."),
    GROUP.row(LOADED, Kind::F64, VECTORS, Dimension::LENGTH, "Mean displacement of the faces that they act on; of all nodes where there are none."),
    GROUP.row(CONTACT_DISPLACEMENT, Kind::F64, &[Named("n_increments"), axes::FRICTION_AXES], Dimension::LENGTH, "Mean tangential displacement of the contact face along t1 and t2.").optional(NO_FRICTION),
    GROUP.row(STRAIN, Kind::F64, ROWS, Dimension::Energy, "Strain energy u.Au / 2 at the end of each increment."),
    GROUP.row(LOAD_WORK, Kind::F64, ROWS, Dimension::Energy, "Work of the loads and of clamps that move in each increment, along a straight way between its ends."),
    GROUP.row(NORMAL_WORK, Kind::F64, ROWS, Dimension::Energy, "Work of the contact pressures on the foundation in each increment, likewise.").optional(NO_CONTACT),
    GROUP.row(DISSIPATION, Kind::F64, ROWS, Dimension::Energy, "Energy that friction took in each increment: the integral of lambda_t . Delta u_t with lambda_t at its end.").optional(NO_FRICTION),
    GROUP.row(FACE_DISSIPATION, Kind::F64, &[Named("n_increments"), Named("n_contact_faces")], Dimension::Energy, "The same on each contact face, in the order of /mesh/contact_face_names.").optional("absent without friction, and without several contact faces"),
    GROUP.row(IMBALANCE, Kind::F64, ROWS, Dimension::Energy, "Work of the loads in each increment less the gain of strain energy, the work on the foundation and the dissipation; falls in proportion to the increments."),
];

/// Writes the increments that were solved.
///
/// # Errors
/// HDF5 failures.
pub fn write(
    writer: &mut GroupWriter<'_>,
    scene: &Scene,
    records: &[StepRecord],
) -> Result<(), StoreError> {
    let steps = records.iter().map(|record| record.increment.step);
    let titles: Vec<String> = steps.map(|step| scene.step_title(step)).collect();
    writer.write_texts(
        TITLE,
        &titles.iter().map(String::as_str).collect::<Vec<_>>(),
    )?;
    let mut columns = Columns::new(writer, records);
    columns.counts(STEP, |record| record.increment.step)?;
    columns.numbers(TIME, |record| record.increment.time)?;
    columns.members(STATUS, |record| StoredStatus::from(record.status))?;
    columns.members(METHOD, |record| StoredMethod::from(record.solved_by))?;
    columns.numbers(ACCURACY, |record| record.accuracy)?;
    columns.counts(APPLICATIONS, |record| record.applications)?;
    columns.numbers(CERTIFICATE, |record| record.certificate)?;
    columns.vectors(APPLIED, |record| record.applied_force)?;
    columns.vectors(CLAMP, |record| record.clamp_force)?;
    columns.vectors(LOADED_FORCE, |record| record.loaded_force)?;
    columns.vectors(LOADED, |record| record.loaded_displacement)?;
    columns.numbers(STRAIN, |record| record.energies.strain)?;
    columns.numbers(LOAD_WORK, |record| record.energies.load_work)?;
    columns.numbers(IMBALANCE, |record| record.energies.imbalance)?;
    let first = records.first();
    if first.is_some_and(|record| !record.panes.is_empty()) {
        columns.vectors(CONTACT, |record| record.contact_force)?;
        columns.vectors(MULTIPLIER_FORCE, |record| record.multiplier_force)?;
        columns.numbers(NORMAL_WORK, |record| record.energies.normal_work)?;
    }
    if first.is_some_and(|record| !record.tangential.is_empty()) {
        columns.vectors(CONTACT_DISPLACEMENT, |record| record.contact_displacement)?;
        columns.numbers(DISSIPATION, |record| record.energies.dissipation)?;
    }
    write_fields(writer, records)
}

/// Writes the fields, one after the other.
fn write_fields(writer: &mut GroupWriter<'_>, records: &[StepRecord]) -> Result<(), StoreError> {
    let Some(first) = records.first() else {
        return Ok(());
    };
    let n = records.len();
    let m = first.panes.len();
    let flat =
        |of: &dyn Fn(&StepRecord) -> Vec<f64>| records.iter().flat_map(of).collect::<Vec<f64>>();
    let u = flat(&|record| record.displacement.as_flattened().to_vec());
    writer.write(DISPLACEMENT, &u, &[n, first.displacement.len(), 3])?;
    let von_mises = flat(&|record| record.von_mises.clone());
    writer.write(VON_MISES, &von_mises, &[n, first.von_mises.len()])?;
    let forces = flat(&|record| record.forces.as_flattened().to_vec());
    writer.write(FORCES, &forces, &[n, first.forces.len(), 3])?;
    if !first.reaction.is_empty() {
        let reaction = flat(&|record| record.reaction.as_flattened().to_vec());
        writer.write(REACTION, &reaction, &[n, first.reaction.len(), 3])?;
    }
    if m == 0 {
        return Ok(());
    }
    let rhs = flat(&|record| record.dual_rhs.clone());
    writer.write(DUAL_RHS, &rhs, &[n, first.dual_rhs.len()])?;
    let normal = flat(&|record| record.multiplier[..m].to_vec());
    writer.write(MULTIPLIER_NORMAL, &normal, &[n, m])?;
    let zones = records.iter().flat_map(|record| &record.panes);
    let zones: Vec<StoredZone> = zones.map(|pane| StoredZone::from(pane.zone)).collect();
    writer.write_enum(ZONE, &zones, &[n, m])?;
    // Panes with friction come first.
    let panes = |of: &dyn Fn(&StepPane) -> [f64; 2]| {
        flat(&|record| {
            let pairs = (record.multiplier.len() - record.panes.len()) / 2;
            record.panes[..pairs].iter().flat_map(of).collect()
        })
    };
    let gap = flat(&|record| record.panes.iter().map(|pane| pane.gap).collect());
    writer.write(GAP, &gap, &[n, m])?;
    if first.tangential.is_empty() {
        return Ok(());
    }
    let pairs = (first.multiplier.len() - m) / 2;
    let tangential = flat(&|record| record.multiplier[m..].to_vec());
    writer.write(MULTIPLIER_TANGENTIAL, &tangential, &[n, pairs, 2])?;
    writer.write(SLIP, &panes(&|pane| pane.slip), &[n, pairs, 2])?;
    if !first.panes[0].coefficients[0].is_nan() {
        writer.write(FRICTION, &panes(&|pane| pane.coefficients), &[n, pairs, 2])?;
    }
    let nodes = first.tangential.len();
    let moved = flat(&|record| record.tangential.as_flattened().to_vec());
    writer.write(TANGENTIAL, &moved, &[n, nodes, 2])?;
    let n_faces = first.face_dissipation.len();
    if n_faces > 1 {
        let faces = flat(&|record| record.face_dissipation.clone());
        writer.write(FACE_DISSIPATION, &faces, &[n, n_faces])?;
    }
    let path = flat(&|record| record.path.as_flattened().to_vec());
    writer.write(PATH, &path, &[n, nodes, 3])
}

/// Reads the increments back; none where there is no history.
///
/// # Errors
/// Missing, altered or contradictory datasets.
pub fn read(reader: &Reader, scene: &Scene) -> Result<Vec<StepRecord>, FormatError> {
    let increments = scene.increments();
    let time: Vec<f64> = reader.read_vec(TIME)?;
    let n = time.len();
    let known = increments.iter().map(|increment| increment.time);
    if n > increments.len() || !known.zip(&time).all(|(known, stored)| known == *stored) {
        return Err(FormatError::Inconsistent {
            dataset: TIME,
            reason: format!(
                "expected the times of {} increments, found others",
                increments.len()
            ),
        });
    }
    let numbers = |path: &str| -> Result<Vec<f64>, FormatError> {
        Ok(if reader.has(path) {
            reader.read_vec(path)?
        } else {
            Vec::new()
        })
    };
    let accuracy = numbers(ACCURACY)?;
    let certificate = numbers(CERTIFICATE)?;
    let applications = read_index_vec(reader, APPLICATIONS)?;
    let status = reader.read_enum::<StoredStatus>(STATUS)?;
    let method = reader.read_enum::<StoredMethod>(METHOD)?;
    let zones = match reader.has(ZONE) {
        true => {
            reader
                .read_enum::<StoredZone>(ZONE)?
                .into_raw_vec_and_offset()
                .0
        }
        false => Vec::new(),
    };
    let fields = [
        DISPLACEMENT,
        VON_MISES,
        DUAL_RHS,
        MULTIPLIER_NORMAL,
        MULTIPLIER_TANGENTIAL,
        TANGENTIAL,
        PATH,
        GAP,
        SLIP,
        FRICTION,
        APPLIED,
        CLAMP,
        CONTACT,
        MULTIPLIER_FORCE,
        LOADED,
        CONTACT_DISPLACEMENT,
        STRAIN,
        LOAD_WORK,
        NORMAL_WORK,
        DISSIPATION,
        IMBALANCE,
        LOADED_FORCE,
        FORCES,
        REACTION,
        FACE_DISSIPATION,
    ];
    let fields: Vec<Vec<f64>> = fields.into_iter().map(numbers).collect::<Result<_, _>>()?;
    let zones_per = zones.len() / n.max(1);
    (0..n)
        .map(|k| {
            let row = |field: usize| {
                let per = fields[field].len() / n;
                &fields[field][k * per..(k + 1) * per]
            };
            let zones = &zones[k * zones_per..(k + 1) * zones_per];
            Ok(StepRecord {
                increment: increments[k],
                status: status[k].into(),
                solved_by: method[k].into(),
                accuracy: accuracy[k],
                applications: applications[k],
                certificate: certificate[k],
                displacement: row(0).as_chunks().0.to_vec(),
                von_mises: row(1).to_vec(),
                dual_rhs: row(2).to_vec(),
                multiplier: [row(3), row(4)].concat(),
                tangential: row(5).as_chunks().0.to_vec(),
                path: row(6).as_chunks().0.to_vec(),
                panes: zones
                    .iter()
                    .enumerate()
                    .map(|(pane, zone)| StepPane {
                        zone: Zone::from(*zone),
                        gap: row(7)[pane],
                        slip: pair(row(8), pane, 0.0),
                        coefficients: pair(row(9), pane, f64::NAN),
                    })
                    .collect(),
                reaction: row(23).as_chunks().0.to_vec(),
                forces: row(22).as_chunks().0.to_vec(),
                applied_force: vector(row(10)),
                clamp_force: vector(row(11)),
                contact_force: vector(row(12)),
                multiplier_force: vector(row(13)),
                loaded_force: vector(row(21)),
                loaded_displacement: vector(row(14)),
                contact_displacement: pair(row(15), 0, 0.0),
                face_dissipation: row(24).to_vec(),
                energies: StepEnergies {
                    strain: vector::<1>(row(16))[0],
                    load_work: vector::<1>(row(17))[0],
                    normal_work: vector::<1>(row(18))[0],
                    dissipation: vector::<1>(row(19))[0],
                    imbalance: vector::<1>(row(20))[0],
                },
            })
        })
        .collect()
}

/// The first numbers of a row; zeros where the file has none.
fn vector<const K: usize>(row: &[f64]) -> [f64; K] {
    std::array::from_fn(|c| row.get(c).copied().unwrap_or(0.0))
}

fn pair(row: &[f64], at: usize, absent: f64) -> [f64; 2] {
    std::array::from_fn(|k| row.get(2 * at + k).copied().unwrap_or(absent))
}

/// Refuses a solution of a history whose `/history` is missing, altered, or that of another run.
///
/// # Errors
/// Those of [`Reader::whole_group`]; `Missing`, `Altered`.
pub fn check(reader: &Reader) -> Result<(), StoreError> {
    if !reader.has(HISTORY_DIGEST) {
        return Ok(());
    }
    let Some(stored) = reader.whole_group(GROUP)? else {
        return Err(StoreError::Missing {
            file: reader.path().into(),
            dataset: format!("/{GROUP}"),
            group: GROUP,
        });
    };
    let (expected, found) = (reader.read_text(HISTORY_DIGEST)?, stored.digest);
    match expected == found {
        true => Ok(()),
        false => Err(StoreError::Altered {
            file: reader.path().into(),
            dataset: format!("/{GROUP}"),
            expected,
            found,
        }),
    }
}
