//! `/post`: zones, contact quantities on panes, stresses, resultants, certificate.

use contact3d::{
    contact::ContactFrame,
    mesh::{ContactSurface, MaterialNodes, Mesh},
    post::{
        ContactReport, ContactResultants, FaceResultants, PaneCoulomb, PaneFriction, PaneState,
        SourceForce, ToolState, Zone,
    },
};
use runfile::{
    Extent,
    Extent::{Fixed, Named},
    Group, GroupWriter, Kind, Reader, StoreError,
};
use units::Dimension;

use super::{
    FormatError, Stage, extents,
    fields::{Fields, fields, read_if_there, write_value},
    stored::stored_as,
};

const ESTIMATE: &str = "/post/discretisation_error/total";

/// Stresses, zones, resultants and the certificate.
pub(super) const GROUP: Group = Group::new("post", Stage::Post.command());

stored_as! {
    /// What a pane does, as stored.
    StoredZone of Zone as "contact_zone" {
        Open = 0 => "open",
        Stick = 1 => "stick",
        Slip = 2 => "slip",
    }
}

pub(super) const VTKHDF_DIGEST: &str = "/post/vtkhdf_digest";
const TRACTION: &str = "/post/contact_traction";
const MATERIAL_NODES: &str = "/post/material_nodes";
const AXIS_1: &str = "/post/contact_axis_1";
const AXIS_2: &str = "/post/contact_axis_2";
pub(super) const FACE_ZONE_COUNTS: &str = "/post/faces/zone_counts";
pub(super) const FACE_NORMAL_FORCE: &str = "/post/faces/normal_force";
pub(super) const FACE_TANGENTIAL_FORCE: &str = "/post/faces/tangential_force";
pub(super) const FACE_LARGEST_PRESSURE: &str = "/post/faces/largest_pressure";

const NO_SPRINGS: &str = "absent without springs";
const NO_CONTACT: &str = "absent without contact";
const NO_FRICTION: &str = "absent without friction";
const NO_COULOMB: &str = "absent without Coulomb friction";
const NO_ERROR: &str = "absent for a body at rest";
const PANES: &[Extent] = &[Named("n_panes")];
const FRICTION_PANES: &[Extent] = &[Named("n_friction_panes")];
const PANE_PAIRS: &[Extent] = &[Named("n_friction_panes"), extents::FRICTION_AXES];
const FACES: &[Extent] = &[Named("n_contact_faces")];
const FACE_VECTORS: &[Extent] = &[Named("n_contact_faces"), extents::XYZ];
const ONE_FACE: &str = "absent without several contact faces";
const VECTOR: &[Extent] = &[extents::XYZ];
const NODE_VECTORS: &[Extent] = &[Named("n_contact_nodes"), extents::XYZ];

pub(super) const ON_THE_BODY: Fields<ContactReport> = fields! { ContactReport => GROUP;
    {Kind::Text} VTKHDF_DIGEST, &[], Dimension::Number, "Digest of /VTKHDF, which shows the same results.";
    [|report| of_panes(report, |pane| pane.zone)] "/post/contact_zone", PANES, Dimension::Number, "Open: no pressure, and no tangential stress but that under a given slip bound (Tresca's law); slip: the trial stress lambda_t + rho |R_i| u_t with local stiffness rho lies outside the ellipse of the last inner problem; stick: inside.".optional(NO_CONTACT);
    [|report| with_friction(report, |pane| pane.margin)] "/post/margin", FRICTION_PANES, Dimension::Number, "1 - |F^-1 lambda_t| / g: 0 on the boundary of the ellipse, 1 at its centre, and on open panes where g follows the pressure.".optional(NO_FRICTION);
    [|report| of_panes(report, |pane| pane.normal_stress)] "/post/normal_stress", PANES, Dimension::STRESS, "Normal contact stress, negative in compression.".symbol("sigma_nu").optional(NO_CONTACT);
    [|report| with_friction(report, |pane| pane.stress)] "/post/tangential_stress", PANE_PAIRS, Dimension::STRESS, "Tangential contact stress along t1 and t2.".symbol("sigma_t").optional(NO_FRICTION);
    [|report| with_coulomb(report, |pane| pane.scaled_stress)] "/post/scaled_tangential_stress", FRICTION_PANES, Dimension::STRESS, "Norm of the tangential stress scaled by the inverse friction matrix at the solution; at most -sigma_nu, and no more than a cap.".symbol("|F^-1 sigma_t|").optional(NO_COULOMB);
    {Kind::F64} TRACTION, &[Named("n_panes"), extents::XYZ], Dimension::STRESS, "Contact stress on the body in the global axes, sigma_nu nu + sigma_t1 t1 + sigma_t2 t2; times pane areas it sums to the contact force.".symbol("sigma nu").optional(NO_CONTACT);
    {Kind::F64} AXIS_1, NODE_VECTORS, Dimension::Number, "First axis of friction at each contact node.".symbol("t1").optional(NO_CONTACT);
    {Kind::F64} AXIS_2, NODE_VECTORS, Dimension::Number, "Second axis of friction at each contact node, t1 x nu with the outward normal nu.".symbol("t2").optional(NO_CONTACT);
    [|report| with_friction(report, |pane| pane.slip)] "/post/pane_slip", PANE_PAIRS, Dimension::LENGTH, "Mean tangential displacement of each pane, in a load history since the increment before.".symbol("u_t").optional(NO_FRICTION);
    [|report| of_panes(report, |pane| pane.gap)] "/post/pane_gap", PANES, Dimension::LENGTH, "Mean distance of each pane to the foundation.".symbol("d - u_nu").optional(NO_CONTACT);
    [|report| with_coulomb(report, |pane| pane.coefficients)] "/post/pane_friction", PANE_PAIRS, Dimension::Number, "Coefficients of friction acting on each pane at the solution.".symbol("F_1, F_2").optional(NO_COULOMB);
    [|report| report.friction.as_ref().map(|friction| friction.nodal.clone())] "/post/nodal_friction", &[Named("n_friction_nodes"), extents::FRICTION_AXES], Dimension::Number, "Coefficients of friction at the contact nodes at the solution.".symbol("F_1, F_2").optional(NO_COULOMB);
    (stress) "/post/stress", &[Named("n_tetrahedra"), extents::STRESS_COMPONENTS], Dimension::STRESS, "Stress xx, yy, zz, yz, xz, xy at the centroid of each tetrahedron.".symbol("sigma");
    (nodal_stress) "/post/nodal_stress", &[Named("n_material_nodes"), extents::STRESS_COMPONENTS], Dimension::STRESS, "Stress xx, yy, zz, yz, xz, xy (the order of Voigt; /VTKHDF has that of VTK) at each node in each of its materials: recovered from linear tetrahedra, the mean of quadratic ones.".symbol("sigma*");
    (von_mises) "/post/von_mises", &[Named("n_material_nodes")], Dimension::STRESS, "Von Mises stress of /post/nodal_stress.";
    {Kind::I64} MATERIAL_NODES, &[Named("n_material_nodes"), Fixed(2)], Dimension::Number, "Node and region of each row of nodal_stress: all nodes with their first region, then again those where materials meet.".optional("absent where no two materials meet: rows are nodes");
    (largest_von_mises.value) "/post/largest_von_mises/value", &[], Dimension::STRESS, "Largest von Mises stress of a node.";
    (largest_von_mises.error) "/post/largest_von_mises/error", &[], Dimension::STRESS, "Its error bar, from how much the stresses of tetrahedra there differ from nodal ones; infinite where it grows with every finer mesh or is not known.";
    (largest_von_mises.at) "/post/largest_von_mises/place", VECTOR, Dimension::LENGTH, "Its place.";
    [|report| report.largest_von_mises.concentration.map(|it| it.word().to_owned())] "/post/largest_von_mises/concentration", &[], Dimension::Number, "Why it grows with every finer mesh: a notch, a clamp, stiff springs, the end of shear or of contact no further than one tetrahedron, or materials that meet there.".optional("absent where it has a limit");
    [|report| report.largest_von_mises.concentration.map(|_| report.largest_von_mises.limit)] "/post/largest_von_mises/concentration_place", VECTOR, Dimension::LENGTH, "Where it grows; two thirds of the largest or more are found there.".optional("absent where it has a limit");
    [|report| contact(report, |_| [Zone::Open, Zone::Stick, Zone::Slip].map(|zone| report.count(zone)))] "/post/zone_counts", &[extents::ZONES], Dimension::Number, "Numbers of open, sticking and slipping panes.".optional(NO_CONTACT);
    [|report| contact(report, |contact| contact.normal_force)] "/post/resultants/normal_force", &[], Dimension::FORCE, "Total normal contact force.".optional(NO_CONTACT);
    [|report| report.resultants.contact.as_ref().and_then(|contact| contact.tangential_force)] "/post/resultants/tangential_force", &[extents::FRICTION_AXES], Dimension::FORCE, "Sum of area times tangential multiplier along t1 and t2; the foundation acts with its opposite.".optional("absent without friction, and with several contact faces");
    [|report| contact(report, |contact| contact.contact_force)] "/post/resultants/contact_force", VECTOR, Dimension::FORCE, "Force of the foundation on the body.".optional(NO_CONTACT);
    (resultants.applied_force) "/post/resultants/applied_force", VECTOR, Dimension::FORCE, "Resultant of the applied loads.";
    (resultants.clamp_force) "/post/resultants/clamp_force", VECTOR, Dimension::FORCE, "Reaction of the clamps.";
    (resultants.moments) "/post/resultants/moments", &[extents::FORCE_SOURCES, extents::XYZ], Dimension::MOMENT, "Moments about the origin of contact, applied and clamp forces, one row each.";
    (resultants.force_imbalance) "/post/resultants/force_imbalance", &[], Dimension::Number, "Norm of the sum of forces over the sum of the norms of all nodal forces.";
    (resultants.moment_imbalance) "/post/resultants/moment_imbalance", &[], Dimension::Number, "Norm of the sum of moments over the sum of the norms of those of all nodal forces.";
    (resultants.spring_force) "/post/resultants/spring_force", VECTOR, Dimension::FORCE, "Force of the springs on the body.".optional(NO_SPRINGS);
    (resultants.spring_energy) "/post/resultants/spring_energy", &[], Dimension::Energy, "Energy in the springs, a part of the strain energy.".optional(NO_SPRINGS);
    (resultants.clamp_work) "/post/resultants/clamp_work", &[], Dimension::Energy, "Work of the reactions on prescribed displacements.".optional("absent where all clamps hold at zero");
};

pub(super) const FORCES: Fields<SourceForce> = fields! { SourceForce => GROUP;
    (source) "/post/forces/source", &[Named("n_forces")], Dimension::Number, "Where each force on the body comes from: the key of a clamp, a spring, a load or a contact face in the scene.";
    (face) "/post/forces/face", &[Named("n_forces")], Dimension::Number, "Its face; empty for boxes of nodes and the body force.";
    (force) "/post/forces/force", &[Named("n_forces"), extents::XYZ], Dimension::FORCE, "Its resultant on the body; reactions for clamps, in equal parts where several hold a component. All sum to zero.";
    (moment) "/post/forces/moment", &[Named("n_forces"), extents::XYZ], Dimension::MOMENT, "Its moment about the origin of coordinates.";
};

const NO_TOOLS: &str = "absent without tools";

const TOOL_VECTORS: &[Extent] = &[Named("n_tools"), extents::XYZ];

pub(super) const TOOLS: Fields<ToolState> = fields! { ToolState => GROUP;
    (point) "/post/tools/point", TOOL_VECTORS, Dimension::LENGTH, "Point that each tool turns about.".symbol("c").optional(NO_TOOLS);
    (displacement) "/post/tools/displacement", TOOL_VECTORS, Dimension::LENGTH, "Displacement of the point.".optional(NO_TOOLS);
    (turn) "/post/tools/turn", TOOL_VECTORS, Dimension::Number, "Rotation vector in radians.".optional(NO_TOOLS);
    (force) "/post/tools/force", TOOL_VECTORS, Dimension::FORCE, "Force of the tool on the body, which is that on the tool from outside.".optional(NO_TOOLS);
    (moment) "/post/tools/moment", TOOL_VECTORS, Dimension::MOMENT, "Its moment about the point: where it begins, or where the increment drives it to if normals follow it.".optional(NO_TOOLS);
};

pub(super) const TOTALS: Fields<ContactReport> = fields! { ContactReport => GROUP;
    (resultants.strain_energy) "/post/resultants/strain_energy", &[], Dimension::Energy, "Strain energy a(u, u) / 2 of body and springs.";
    (resultants.load_work) "/post/resultants/load_work", &[], Dimension::Energy, "Work l.u of the loads, on held nodes too.";
    (resultants.largest_displacement) "/post/resultants/largest_displacement", &[], Dimension::LENGTH, "Largest |u| of a node, rigid-body motion included.";
    (resultants.largest_displacement_along) "/post/resultants/largest_displacement_along", VECTOR, Dimension::LENGTH, "Largest |u_x|, |u_y|, |u_z| of a node.";
    [|report| contact(report, |contact| contact.largest_pressure)] "/post/resultants/largest_pressure", &[], Dimension::STRESS, "Largest normal multiplier.".optional(NO_CONTACT);
    [|report| of_faces(report, |face| face.zone_counts)] FACE_ZONE_COUNTS, FACE_VECTORS, Dimension::Number, "Numbers of open, sticking and slipping panes of each contact face.".optional(ONE_FACE);
    [|report| of_faces(report, |face| face.contact.normal_force)] FACE_NORMAL_FORCE, FACES, Dimension::FORCE, "Total normal contact force of each contact face.".optional(ONE_FACE);
    [|report| report.faces.iter().filter_map(|face| face.contact.tangential_force).collect::<Vec<_>>()] FACE_TANGENTIAL_FORCE, &[Named("n_friction_faces"), extents::FRICTION_AXES], Dimension::FORCE, "Sum of area times tangential multiplier along the t1 and t2 of each contact face with friction.".optional("absent without several contact faces, and without friction");
    [|report| of_faces(report, |face| face.contact.largest_pressure)] FACE_LARGEST_PRESSURE, FACES, Dimension::STRESS, "Largest normal multiplier of each contact face.".optional(ONE_FACE);
    (certificate.equilibrium) "/post/certificate/equilibrium", &[], Dimension::Number, "|A u + B^T lambda - l| / |l|.";
    (certificate.penetration) "/post/certificate/penetration", &[], Dimension::Number, "Largest mean penetration of a pane times its area and local stiffness, over the largest pressure.".optional(NO_CONTACT);
    (certificate.adhesion) "/post/certificate/adhesion", &[], Dimension::Number, "Largest tensile normal multiplier over the largest pressure.".optional(NO_CONTACT);
    (certificate.complementarity) "/post/certificate/complementarity", &[], Dimension::Number, "Sum over panes of |lambda_nu gap| times area, over that of lambda_nu^2 over local stiffness.".optional(NO_CONTACT);
    (certificate.friction_bound) "/post/certificate/friction_bound", &[], Dimension::Number, "Largest excess of |F^-1 lambda_t| over the slip bound, lambda_nu or no more than its cap, over the largest slip bound.".optional(NO_FRICTION);
    (certificate.slip_direction) "/post/certificate/slip_direction", &[], Dimension::Number, "Sum over panes of the frictional work that misses to that of the law's slip direction, in absolute value, over the frictional work plus the sum of |lambda_t|^2 over local stiffness.".optional(NO_FRICTION);
    (certificate.fixed_point) "/post/certificate/fixed_point", &[], Dimension::Number, "Largest entry of lambda - P(lambda - rho r) on the solution's own admissible set with local stiffness rho, normal ones over the largest pressure, tangential ones over the largest tangential stress or semi-axis.".optional(NO_CONTACT);
    [indicator] "/post/discretisation_error/indicator", &[Named("n_tetrahedra")], Dimension::Number, "Share of each tetrahedron in the estimated error, over the energy norm of the displacement; the root of the sum of squares is total.".optional(NO_ERROR);
    [|report| share(report, "total")] ESTIMATE, &[], Dimension::Number, "Estimated |u_h - u|_A / |u_h|_A.".optional(NO_ERROR);
    [|report| share(report, "elements")] "/post/discretisation_error/elements", &[], Dimension::Number, "Part of it that the displacement has for the multipliers as they are.".optional(NO_ERROR);
    [|report| share(report, "penetration")] "/post/discretisation_error/penetration", &[], Dimension::Number, "Part of it from places inside panes that are in the foundation.".optional(NO_CONTACT);
    [|report| share(report, "complementarity")] "/post/discretisation_error/complementarity", &[], Dimension::Number, "Part of it from pressure across a gap inside panes.".optional(NO_CONTACT);
    [|report| share(report, "friction")] "/post/discretisation_error/friction", &[], Dimension::Number, "Part of it from slip inside sticking panes and from stress in another direction than the slip's.".optional(NO_FRICTION);
};

fn of_panes<V>(report: &ContactReport, of: fn(&PaneState) -> V) -> Vec<V> {
    report.panes.iter().map(of).collect()
}

/// A figure of the panes with friction.
fn with_friction<V>(report: &ContactReport, of: fn(PaneFriction) -> V) -> Vec<V> {
    let panes = report.panes.iter();
    panes.filter_map(|pane| pane.friction).map(of).collect()
}

/// A figure of the panes with Coulomb's law.
fn with_coulomb<V>(report: &ContactReport, of: fn(PaneCoulomb) -> V) -> Vec<V> {
    let panes = with_friction(report, |pane| pane.coulomb);
    panes.into_iter().flatten().map(of).collect()
}

/// A figure of each of several contact faces.
fn of_faces<V>(report: &ContactReport, of: fn(&FaceResultants) -> V) -> Vec<V> {
    report.faces.iter().map(of).collect()
}

fn contact<V>(report: &ContactReport, of: impl Fn(&ContactResultants) -> V) -> Option<V> {
    report.resultants.contact.as_ref().map(of)
}

/// The share of each tetrahedron in the estimated error; none for a body at rest.
fn indicator(report: &ContactReport) -> Vec<f64> {
    let error = &report.discretisation_error;
    if error.displacement == 0.0 {
        return Vec::new();
    }
    let shares = error.indicator.iter().map(|e| e / error.displacement);
    shares.collect()
}

/// A part of the estimated error; `None` for a body at rest, which has none.
fn share(report: &ContactReport, name: &str) -> Option<f64> {
    let error = &report.discretisation_error;
    let parts = error.relative_parts();
    let part = parts.into_iter().find(|(part, _)| *part == name);
    part.filter(|_| error.displacement != 0.0)
        .map(|(_, share)| share)
}

/// Reads the estimated error over ‖u_h‖_A; `None` where the answer is not evaluated, and for a body at rest.
pub fn read_estimate(reader: &Reader) -> Result<Option<f64>, FormatError> {
    read_if_there(reader, ESTIMATE)
}

/// Writes the report, with the contact face and its frame where there is contact; it belongs to a `/VTKHDF` with
/// some digest.
pub fn write(
    writer: &mut GroupWriter<'_>,
    mesh: &Mesh,
    report: &ContactReport,
    face: Option<(&ContactSurface, &ContactFrame)>,
    vtkhdf_digest: &str,
) -> Result<(), StoreError> {
    writer.write_text(VTKHDF_DIGEST, vtkhdf_digest)?;
    if let Some(rows) = MaterialNodes::new(mesh).regions() {
        write_value(writer, MATERIAL_NODES, &rows)?;
    }
    if let Some((surface, frame)) = face {
        write_in_space(writer, &report.panes, surface, frame)?;
    }
    ON_THE_BODY.write_one(writer, report)?;
    FORCES.write_rows(writer, &report.forces)?;
    if !report.tools.is_empty() {
        TOOLS.write_rows(writer, &report.tools)?;
    }
    TOTALS.write_one(writer, report)
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
        write_value(writer, path, &axes)?;
    }
    let traction = |(index, pane): (usize, &PaneState)| {
        let tangential = pane.friction.map_or([0.0; 2], |friction| friction.stress);
        frame.pane_vector(surface, index, pane.normal_stress, tangential)
    };
    let tractions: Vec<[f64; 3]> = panes.iter().enumerate().map(traction).collect();
    write_value(writer, TRACTION, &tractions)
}

/// Reads a figure of the certificate; `None` where the file has none of that name.
pub fn read_certificate(reader: &Reader, name: &str) -> Result<Option<f64>, FormatError> {
    let path = format!("/post/certificate/{name}");
    if !reader.has(&path) {
        return Ok(None);
    }
    Ok(reader.read_vec(&path)?.first().copied())
}
