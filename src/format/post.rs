//! `/post`: zones, contact quantities on panes, stresses, resultants, certificate.

use contact3d::{
    contact::ContactFrame,
    mesh::ContactSurface,
    post::{ContactReport, FaceResultants, PaneFriction, PaneState, SourceForce, Zone},
};
use runfile::{
    DatasetSpec, Extent,
    Extent::{Fixed, Named},
    Group, GroupWriter, Kind, Reader, StoreError, StoredEnum,
};
use units::Dimension;

use super::{
    FormatError, Stage, axes, columns::Columns, enumeration::stored_as, read_index_vec, read_scalar,
};

/// Stresses, zones, resultants and the certificate.
pub(super) const GROUP: Group = Group::new("post", Stage::Post.command());

stored_as! {
    /// What a pane does, as stored.
    pub(super) StoredZone of Zone as "contact_zone" {
        Open = 0 => "open",
        Stick = 1 => "stick",
        Slip = 2 => "slip",
    }
}

pub(super) const VTKHDF_DIGEST: &str = "/post/vtkhdf_digest";
const ZONE: &str = "/post/contact_zone";
const MARGIN: &str = "/post/margin";
const NORMAL_STRESS: &str = "/post/normal_stress";
const TANGENTIAL_STRESS: &str = "/post/tangential_stress";
const SCALED_TANGENTIAL: &str = "/post/scaled_tangential_stress";
const TRACTION: &str = "/post/contact_traction";
const AXIS_1: &str = "/post/contact_axis_1";
const AXIS_2: &str = "/post/contact_axis_2";
const PANE_SLIP: &str = "/post/pane_slip";
const PANE_GAP: &str = "/post/pane_gap";
const PANE_FRICTION: &str = "/post/pane_friction";
const NODAL_FRICTION: &str = "/post/nodal_friction";
const STRESS: &str = "/post/stress";
const CORNER_STRESS: &str = "/post/corner_stress";
const ERROR_INDICATOR: &str = "/post/discretisation_error/indicator";
const VON_MISES: &str = "/post/von_mises";
const ZONE_COUNTS: &str = "/post/zone_counts";
const NORMAL_FORCE: &str = "/post/resultants/normal_force";
const STRAIN_ENERGY: &str = "/post/resultants/strain_energy";
pub(super) const FACE_ZONE_COUNTS: &str = "/post/faces/zone_counts";
pub(super) const FACE_NORMAL_FORCE: &str = "/post/faces/normal_force";
pub(super) const FACE_TANGENTIAL_FORCE: &str = "/post/faces/tangential_force";
pub(super) const FACE_LARGEST_PRESSURE: &str = "/post/faces/largest_pressure";
const LARGEST_PRESSURE: &str = "/post/resultants/largest_pressure";

const CLAMP_WORK: &str = "/post/resultants/clamp_work";
const SPRING_FORCE: &str = "/post/resultants/spring_force";
const SPRING_ENERGY: &str = "/post/resultants/spring_energy";
const NO_SPRINGS: &str = "absent without springs";
const FORCE_SOURCE: &str = "/post/forces/source";
const FORCE_FACE: &str = "/post/forces/face";
const FORCE_FORCE: &str = "/post/forces/force";
const FORCE_MOMENT: &str = "/post/forces/moment";

const BEFORE_FORCES: &str = "absent in files before format 1.7";
const NO_CONTACT: &str = "absent without contact";
const NO_CONTACT_OR_OLD: &str = "absent without contact, and in files before format 1.4";
const NO_FRICTION: &str = "absent without friction";
const NO_COULOMB: &str = "absent without Coulomb friction";
const NO_ERROR: &str = "absent in files before format 1.4, and for a body at rest";
const NO_FRICTION_OR_OLD: &str = "absent without friction, and in files before format 1.4";
const PANES: &[Extent] = &[Named("n_panes")];
const FRICTION_PANES: &[Extent] = &[Named("n_friction_panes")];
const PANE_PAIRS: &[Extent] = &[Named("n_friction_panes"), axes::FRICTION_AXES];
const FACES: &[Extent] = &[Named("n_contact_faces")];
const FACE_VECTORS: &[Extent] = &[Named("n_contact_faces"), axes::XYZ];
const ONE_FACE: &str = "absent without several contact faces";
const VECTOR: &[Extent] = &[axes::XYZ];
const NODE_VECTORS: &[Extent] = &[Named("n_contact_nodes"), axes::XYZ];

#[rustfmt::skip]
pub(super) const TABLE: &[DatasetSpec] = &[
    GROUP.row(VTKHDF_DIGEST, Kind::Text, &[], Dimension::Number, "Digest of /VTKHDF, which shows the same results.").optional("absent in files before format 1.4"),
    GROUP.row(ZONE, Kind::Enum(StoredZone::SPEC), PANES, Dimension::Number, "Open: no contact stress; slip: the trial stress lambda_t + rho |R_i| u_t with local stiffness rho lies outside the ellipse of the last inner problem; stick: inside.").optional(NO_CONTACT),
    GROUP.row(MARGIN, Kind::F64, FRICTION_PANES, Dimension::Number, "1 - |F^-1 lambda_t| / g: 0 on the boundary of the ellipse, 1 at its centre and on open panes.").optional(NO_FRICTION),
    GROUP.row(NORMAL_STRESS, Kind::F64, PANES, Dimension::STRESS, "Normal contact stress, negative in compression.").symbol("sigma_nu").optional(NO_CONTACT),
    GROUP.row(TANGENTIAL_STRESS, Kind::F64, PANE_PAIRS, Dimension::STRESS, "Tangential contact stress along t1 and t2.").symbol("sigma_t").optional(NO_FRICTION),
    GROUP.row(SCALED_TANGENTIAL, Kind::F64, FRICTION_PANES, Dimension::STRESS, "Norm of the tangential stress scaled by the inverse friction matrix at the solution; at most -sigma_nu, and no more than a cap.").symbol("|F^-1 sigma_t|").optional(NO_COULOMB),
    GROUP.row(TRACTION, Kind::F64, &[Named("n_panes"), axes::XYZ], Dimension::STRESS, "Contact stress on the body in the global axes, sigma_nu nu + sigma_t1 t1 + sigma_t2 t2; times pane areas it sums to the contact force.").symbol("sigma nu").optional(NO_CONTACT_OR_OLD),
    GROUP.row(AXIS_1, Kind::F64, NODE_VECTORS, Dimension::Number, "First axis of friction at each contact node.").symbol("t1").optional(NO_CONTACT_OR_OLD),
    GROUP.row(AXIS_2, Kind::F64, NODE_VECTORS, Dimension::Number, "Second axis of friction at each contact node, t1 x nu with the outward normal nu.").symbol("t2").optional(NO_CONTACT_OR_OLD),
    GROUP.row(PANE_SLIP, Kind::F64, PANE_PAIRS, Dimension::LENGTH, "Mean tangential displacement of each pane.").symbol("u_t").optional(NO_FRICTION),
    GROUP.row(PANE_GAP, Kind::F64, PANES, Dimension::LENGTH, "Mean distance of each pane to the foundation.").symbol("d - u_nu").optional(NO_CONTACT),
    GROUP.row(PANE_FRICTION, Kind::F64, PANE_PAIRS, Dimension::Number, "Coefficients of friction acting on each pane at the solution.").symbol("F_1, F_2").optional(NO_COULOMB),
    GROUP.row(NODAL_FRICTION, Kind::F64, &[Named("n_friction_nodes"), axes::FRICTION_AXES], Dimension::Number, "Coefficients of friction at the contact nodes at the solution.").symbol("F_1, F_2").optional(NO_COULOMB),
    GROUP.row(STRESS, Kind::F64, &[Named("n_tetrahedra"), axes::STRESS_COMPONENTS], Dimension::STRESS, "Stress xx, yy, zz, yz, xz, xy at the centroid of each tetrahedron.").symbol("sigma"),
    GROUP.row(CORNER_STRESS, Kind::F64, &[Named("n_tetrahedra"), Fixed(4), axes::STRESS_COMPONENTS], Dimension::STRESS, "Stress xx, yy, zz, yz, xz, xy at the four corners of each quadratic tetrahedron.").optional("absent with linear tetrahedra"),
    GROUP.row(VON_MISES, Kind::F64, &[Named("n_tetrahedra")], Dimension::STRESS, "Von Mises stress of each tetrahedron."),
    GROUP.row(ZONE_COUNTS, Kind::I64, &[axes::ZONES], Dimension::Number, "Numbers of open, sticking and slipping panes.").optional(NO_CONTACT),
    GROUP.row(NORMAL_FORCE, Kind::F64, &[], Dimension::FORCE, "Total normal contact force.").optional(NO_CONTACT),
    GROUP.row("/post/resultants/tangential_force", Kind::F64, &[axes::FRICTION_AXES], Dimension::FORCE, "Sum of area times tangential multiplier along t1 and t2; the foundation acts with its opposite.").optional("absent without friction, and with several contact faces"),
    GROUP.row("/post/resultants/contact_force", Kind::F64, VECTOR, Dimension::FORCE, "Force of the foundation on the body.").optional(NO_CONTACT),
    GROUP.row("/post/resultants/applied_force", Kind::F64, VECTOR, Dimension::FORCE, "Resultant of the applied loads."),
    GROUP.row("/post/resultants/clamp_force", Kind::F64, VECTOR, Dimension::FORCE, "Reaction of the clamps."),
    GROUP.row("/post/resultants/moments", Kind::F64, &[axes::FORCE_SOURCES, axes::XYZ], Dimension::MOMENT, "Moments about the origin of contact, applied and clamp forces, one row each."),
    GROUP.row("/post/resultants/force_imbalance", Kind::F64, &[], Dimension::Number, "Norm of the sum of forces over the sum of the norms of all nodal forces."),
    GROUP.row("/post/resultants/moment_imbalance", Kind::F64, &[], Dimension::Number, "Norm of the sum of moments over the sum of the norms of those of all nodal forces."),
    GROUP.row(SPRING_FORCE, Kind::F64, VECTOR, Dimension::FORCE, "Force of the springs on the body.").optional(NO_SPRINGS),
    GROUP.row(SPRING_ENERGY, Kind::F64, &[], Dimension::Energy, "Energy in the springs, a part of the strain energy.").optional(NO_SPRINGS),
    GROUP.row(CLAMP_WORK, Kind::F64, &[], Dimension::Energy, "Work of the reactions on prescribed displacements.").optional("absent where all clamps hold at zero"),
    GROUP.row(FORCE_SOURCE, Kind::Text, &[Named("n_forces")], Dimension::Number, "Where each force on the body comes from: the key of a clamp, a spring, a load or a contact face in the scene.").optional(BEFORE_FORCES),
    GROUP.row(FORCE_FACE, Kind::Text, &[Named("n_forces")], Dimension::Number, "Its face; empty for boxes of nodes and the body force.").optional(BEFORE_FORCES),
    GROUP.row(FORCE_FORCE, Kind::F64, &[Named("n_forces"), axes::XYZ], Dimension::FORCE, "Its resultant on the body; reactions for clamps, in equal parts where several hold a component. All sum to zero.").optional(BEFORE_FORCES),
    GROUP.row(FORCE_MOMENT, Kind::F64, &[Named("n_forces"), axes::XYZ], Dimension::MOMENT, "Its moment about the origin of coordinates.").optional(BEFORE_FORCES),
    GROUP.row(STRAIN_ENERGY, Kind::F64, &[], Dimension::Energy, "Strain energy a(u, u) / 2 of body and springs."),
    GROUP.row("/post/resultants/load_work", Kind::F64, &[], Dimension::Energy, "Work l.u of the loads, on held nodes too."),
    GROUP.row("/post/resultants/largest_displacement", Kind::F64, VECTOR, Dimension::LENGTH, "Largest |u_x|, |u_y|, |u_z| of a node."),
    GROUP.row(LARGEST_PRESSURE, Kind::F64, &[], Dimension::STRESS, "Largest normal multiplier.").optional(NO_CONTACT),
    GROUP.row(FACE_ZONE_COUNTS, Kind::I64, FACE_VECTORS, Dimension::Number, "Numbers of open, sticking and slipping panes of each contact face.").optional(ONE_FACE),
    GROUP.row(FACE_NORMAL_FORCE, Kind::F64, FACES, Dimension::FORCE, "Total normal contact force of each contact face.").optional(ONE_FACE),
    GROUP.row(FACE_TANGENTIAL_FORCE, Kind::F64, &[Named("n_friction_faces"), axes::FRICTION_AXES], Dimension::FORCE, "Sum of area times tangential multiplier along the t1 and t2 of each contact face with friction.").optional("absent without several contact faces, and without friction"),
    GROUP.row(FACE_LARGEST_PRESSURE, Kind::F64, FACES, Dimension::STRESS, "Largest normal multiplier of each contact face.").optional(ONE_FACE),
    GROUP.row("/post/certificate/equilibrium", Kind::F64, &[], Dimension::Number, "|A u + B^T lambda - l| / |l|."),
    GROUP.row("/post/certificate/penetration", Kind::F64, &[], Dimension::Number, "Largest mean penetration of a pane times its area and local stiffness, over the largest pressure.").optional(NO_CONTACT),
    GROUP.row("/post/certificate/adhesion", Kind::F64, &[], Dimension::Number, "Largest tensile normal multiplier over the largest pressure.").optional(NO_CONTACT),
    GROUP.row("/post/certificate/complementarity", Kind::F64, &[], Dimension::Number, "Sum over panes of |lambda_nu gap| times area, over that of lambda_nu^2 over local stiffness.").optional(NO_CONTACT),
    GROUP.row("/post/certificate/friction_bound", Kind::F64, &[], Dimension::Number, "Largest excess of |F^-1 lambda_t| over the slip bound, lambda_nu or no more than its cap, over the largest slip bound.").optional(NO_FRICTION),
    GROUP.row("/post/certificate/slip_direction", Kind::F64, &[], Dimension::Number, "Sum over panes of the frictional work that misses to that of the law's slip direction, in absolute value, over the frictional work plus the sum of |lambda_t|^2 over local stiffness.").optional(NO_FRICTION),
    GROUP.row("/post/certificate/fixed_point", Kind::F64, &[], Dimension::Number, "Largest entry of lambda - P(lambda - rho r) on the solution's own admissible set with local stiffness rho, normal ones over the largest pressure, tangential ones over the largest tangential stress or semi-axis.").optional(NO_CONTACT),
    GROUP.row(ERROR_INDICATOR, Kind::F64, &[Named("n_tetrahedra")], Dimension::Number, "Share of each tetrahedron in the estimated error, over the energy norm of the displacement; the root of the sum of squares is total.").optional(NO_ERROR),
    GROUP.row("/post/discretisation_error/total", Kind::F64, &[], Dimension::Number, "Estimated |u_h - u|_A / |u_h|_A.").optional(NO_ERROR),
    GROUP.row("/post/discretisation_error/elements", Kind::F64, &[], Dimension::Number, "Part of it that the displacement has for the multipliers as they are.").optional(NO_ERROR),
    GROUP.row("/post/discretisation_error/penetration", Kind::F64, &[], Dimension::Number, "Part of it from places inside panes that are in the foundation.").optional(NO_CONTACT_OR_OLD),
    GROUP.row("/post/discretisation_error/complementarity", Kind::F64, &[], Dimension::Number, "Part of it from pressure across a gap inside panes.").optional(NO_CONTACT_OR_OLD),
    GROUP.row("/post/discretisation_error/friction", Kind::F64, &[], Dimension::Number, "Part of it from slip inside sticking panes and from stress in another direction than the slip's.").optional(NO_FRICTION_OR_OLD),
];

/// Writes the report, with the contact face and its frame where there is contact; it belongs to a `/VTKHDF` with
/// some digest.
///
/// # Errors
/// HDF5 failures.
pub fn write(
    writer: &mut GroupWriter<'_>,
    report: &ContactReport,
    face: Option<(&ContactSurface, &ContactFrame)>,
    vtkhdf_digest: &str,
) -> Result<(), StoreError> {
    writer.write_text(VTKHDF_DIGEST, vtkhdf_digest)?;
    if let Some((surface, frame)) = face {
        write_in_space(writer, &report.panes, surface, frame)?;
    }
    if report.resultants.contact.is_some() {
        write_panes(writer, &report.panes)?;
        let counts = [Zone::Open, Zone::Stick, Zone::Slip].map(|zone| report.count(zone));
        writer.write_indices(ZONE_COUNTS, &counts, &[3])?;
    }
    if let Some(friction) = &report.friction {
        let nodal = &friction.nodal;
        writer.write(NODAL_FRICTION, nodal.as_flattened(), &[nodal.len(), 2])?;
    }
    writer.write(
        STRESS,
        report.stress.as_flattened(),
        &[report.stress.len(), 6],
    )?;
    if !report.corner_stress.is_empty() {
        let corners = report.corner_stress.as_flattened().as_flattened();
        writer.write(CORNER_STRESS, corners, &[report.corner_stress.len(), 4, 6])?;
    }
    writer.write(VON_MISES, &report.von_mises, &[report.von_mises.len()])?;
    let r = &report.resultants;
    let mut scalars = vec![
        ("/post/resultants/force_imbalance", r.force_imbalance),
        ("/post/resultants/moment_imbalance", r.moment_imbalance),
        (STRAIN_ENERGY, r.strain_energy),
        ("/post/resultants/load_work", r.load_work),
    ];
    let mut vectors = vec![
        ("/post/resultants/applied_force", r.applied_force),
        ("/post/resultants/clamp_force", r.clamp_force),
        (
            "/post/resultants/largest_displacement",
            r.largest_displacement,
        ),
    ];
    scalars.extend(r.clamp_work.map(|work| (CLAMP_WORK, work)));
    scalars.extend(r.spring_energy.map(|energy| (SPRING_ENERGY, energy)));
    vectors.extend(r.spring_force.map(|force| (SPRING_FORCE, force)));
    if let Some(contact) = &r.contact {
        scalars.push((NORMAL_FORCE, contact.normal_force));
        scalars.push((LARGEST_PRESSURE, contact.largest_pressure));
        vectors.push(("/post/resultants/contact_force", contact.contact_force));
        if let Some(force) = &contact.tangential_force {
            writer.write("/post/resultants/tangential_force", force, &[2])?;
        }
    }
    if !report.faces.is_empty() {
        write_faces(writer, &report.faces)?;
    }
    for (path, value) in scalars {
        writer.write(path, &[value], &[])?;
    }
    for (path, value) in vectors {
        writer.write(path, &value, &[3])?;
    }
    writer.write(
        "/post/resultants/moments",
        r.moments.as_flattened(),
        &[3, 3],
    )?;
    write_forces(writer, &report.forces)?;
    for (name, value) in report.certificate.figures() {
        writer.write(&format!("/post/certificate/{name}"), &[value], &[])?;
    }
    write_discretisation_error(writer, report)
}

/// The forces on the body by their sources.
fn write_forces(writer: &mut GroupWriter<'_>, forces: &[SourceForce]) -> Result<(), StoreError> {
    let mut columns = Columns::new(writer, forces);
    columns.texts(FORCE_SOURCE, |row| &row.source)?;
    columns.texts(FORCE_FACE, |row| &row.face)?;
    columns.vectors(FORCE_FORCE, |row| row.force)?;
    columns.vectors(FORCE_MOMENT, |row| row.moment)
}

/// What happens on each of several contact faces.
fn write_faces(writer: &mut GroupWriter<'_>, faces: &[FaceResultants]) -> Result<(), StoreError> {
    let n = faces.len();
    let counts: Vec<[usize; 3]> = faces.iter().map(|face| face.zone_counts).collect();
    writer.write_indices(FACE_ZONE_COUNTS, counts.as_flattened(), &[n, 3])?;
    let mut columns = Columns::new(writer, faces);
    columns.numbers(FACE_NORMAL_FORCE, |face| face.contact.normal_force)?;
    columns.numbers(FACE_LARGEST_PRESSURE, |face| face.contact.largest_pressure)?;
    let tangential = faces
        .iter()
        .filter_map(|face| face.contact.tangential_force);
    let tangential: Vec<[f64; 2]> = tangential.collect();
    if tangential.is_empty() {
        return Ok(());
    }
    let shape = [tangential.len(), 2];
    writer.write(FACE_TANGENTIAL_FORCE, tangential.as_flattened(), &shape)
}

/// The estimated error; a body at rest has none.
fn write_discretisation_error(
    writer: &mut GroupWriter<'_>,
    report: &ContactReport,
) -> Result<(), StoreError> {
    let error = &report.discretisation_error;
    if error.displacement == 0.0 {
        return Ok(());
    }
    let indicator: Vec<f64> = error
        .indicator
        .iter()
        .map(|e| e / error.displacement)
        .collect();
    writer.write(ERROR_INDICATOR, &indicator, &[indicator.len()])?;
    for (name, value) in error.relative_parts() {
        writer.write(&format!("/post/discretisation_error/{name}"), &[value], &[])?;
    }
    Ok(())
}

/// The axes of friction, and contact stresses in the global axes.
fn write_in_space(
    writer: &mut GroupWriter<'_>,
    panes: &[PaneState],
    surface: &ContactSurface,
    frame: &ContactFrame,
) -> Result<(), StoreError> {
    for (k, path) in [AXIS_1, AXIS_2].into_iter().enumerate() {
        let nodes = 0..surface.nodes.len();
        let axes: Vec<[f64; 3]> = nodes.map(|node| frame.axes_at(node)[k]).collect();
        writer.write(path, axes.as_flattened(), &[axes.len(), 3])?;
    }
    let traction = |(index, pane): (usize, &PaneState)| {
        let tangential = pane.friction.map_or([0.0; 2], |friction| friction.stress);
        frame.pane_vector(surface, index, pane.normal_stress, tangential)
    };
    let tractions: Vec<[f64; 3]> = panes.iter().enumerate().map(traction).collect();
    writer.write(TRACTION, tractions.as_flattened(), &[tractions.len(), 3])
}

fn write_panes(writer: &mut GroupWriter<'_>, panes: &[PaneState]) -> Result<(), StoreError> {
    let mut columns = Columns::new(writer, panes);
    columns.members(ZONE, |pane| StoredZone::from(pane.zone))?;
    columns.numbers(NORMAL_STRESS, |pane| pane.normal_stress)?;
    columns.numbers(PANE_GAP, |pane| pane.gap)?;
    let friction: Vec<PaneFriction> = panes.iter().filter_map(|p| p.friction).collect();
    if !friction.is_empty() {
        write_pane_friction(writer, &friction)?;
    }
    Ok(())
}

fn write_pane_friction(
    writer: &mut GroupWriter<'_>,
    panes: &[PaneFriction],
) -> Result<(), StoreError> {
    let mut columns = Columns::new(writer, panes);
    columns.numbers(MARGIN, |pane| pane.margin)?;
    columns.vectors(TANGENTIAL_STRESS, |pane| pane.stress)?;
    columns.vectors(PANE_SLIP, |pane| pane.slip)?;
    let coulomb: Vec<_> = panes.iter().filter_map(|p| p.coulomb).collect();
    if !coulomb.is_empty() {
        let mut columns = Columns::new(writer, &coulomb);
        columns.vectors(PANE_FRICTION, |coulomb| coulomb.coefficients)?;
        columns.numbers(SCALED_TANGENTIAL, |coulomb| coulomb.scaled_stress)?;
    }
    Ok(())
}

/// The few figures that a status line shows.
#[derive(Debug, Clone, PartialEq)]
pub struct Summary {
    /// Strain energy in J.
    pub strain_energy: f64,
    /// What the foundation does; `None` without contact.
    pub contact: Option<ContactSummary>,
}

/// The contact part of a [`Summary`].
#[derive(Debug, Clone, PartialEq)]
pub struct ContactSummary {
    /// Numbers of open, sticking and slipping panes.
    pub zone_counts: Vec<usize>,
    /// Total normal contact force in N.
    pub normal_force: f64,
    /// Largest pressure in Pa.
    pub largest_pressure: f64,
}

/// Reads a figure of the certificate; `None` where the file has none of that name.
///
/// # Errors
/// An altered dataset.
pub fn read_certificate(reader: &Reader, name: &str) -> Result<Option<f64>, FormatError> {
    let path = format!("/post/certificate/{name}");
    Ok(match reader.has(&path) {
        true => reader.read_vec(&path)?.first().copied(),
        false => None,
    })
}

/// Reads the main figures.
///
/// # Errors
/// Missing or altered datasets.
pub fn read_summary(reader: &Reader) -> Result<Summary, FormatError> {
    let contact = match reader.has(ZONE_COUNTS) {
        false => None,
        true => Some(ContactSummary {
            zone_counts: read_index_vec(reader, ZONE_COUNTS)?,
            normal_force: read_scalar(reader, NORMAL_FORCE)?,
            largest_pressure: read_scalar(reader, LARGEST_PRESSURE)?,
        }),
    };
    Ok(Summary {
        strain_energy: read_scalar(reader, STRAIN_ENERGY)?,
        contact,
    })
}
