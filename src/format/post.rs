//! `/post`: zones, contact quantities on panes, stresses, resultants, certificate.

use super::{FormatError, read_finite_scalar, read_index_vec};
use crate::{
    post::{ContactReport, PaneState, Zone},
    store::{
        DatasetSpec, Extent,
        Extent::{Fixed, Named},
        Kind, Reader, Stage, StageWriter, StoreError, StoredEnum, stored_enum,
    },
};

stored_enum! {
    /// What a pane does, as stored.
    enum StoredZone as "contact_zone" {
        Open = 0 => "open",
        Stick = 1 => "stick",
        Slip = 2 => "slip",
    }
}

const ZONE: &str = "/post/contact_zone";
const MARGIN: &str = "/post/margin";
const NORMAL_STRESS: &str = "/post/normal_stress";
const TANGENTIAL_STRESS: &str = "/post/tangential_stress";
const SCALED_TANGENTIAL: &str = "/post/scaled_tangential_stress";
const PANE_SLIP: &str = "/post/pane_slip";
const PANE_GAP: &str = "/post/pane_gap";
const PANE_FRICTION: &str = "/post/pane_friction";
const NODAL_FRICTION: &str = "/post/nodal_friction";
const STRESS: &str = "/post/stress";
const VON_MISES: &str = "/post/von_mises";
const ZONE_COUNTS: &str = "/post/zone_counts";
const NORMAL_FORCE: &str = "/post/resultants/normal_force";
const STRAIN_ENERGY: &str = "/post/resultants/strain_energy";
const LARGEST_PRESSURE: &str = "/post/resultants/largest_pressure";

const PANES: &[Extent] = &[Named("n_panes")];
const PANE_PAIRS: &[Extent] = &[Named("n_panes"), Fixed(2)];
const VECTOR: &[Extent] = &[Fixed(3)];

#[rustfmt::skip]
pub(super) const TABLE: &[DatasetSpec] = &[
    Stage::Post.row(ZONE, Kind::Enum(StoredZone::SPEC), PANES, "1", "Open: no contact stress; slip: the trial stress lambda_t + alpha |R_i| u_t lies outside the ellipse of the last inner problem; stick: inside."),
    Stage::Post.row(MARGIN, Kind::F64, PANES, "1", "1 - |F^-1 lambda_t| / g: 0 on the boundary of the ellipse, 1 at its centre and on open panes."),
    Stage::Post.row(NORMAL_STRESS, Kind::F64, PANES, "Pa", "Normal contact stress, negative in compression.").symbol("sigma_nu"),
    Stage::Post.row(TANGENTIAL_STRESS, Kind::F64, PANE_PAIRS, "Pa", "Tangential contact stress along t1 and t2.").symbol("sigma_t"),
    Stage::Post.row(SCALED_TANGENTIAL, Kind::F64, PANES, "Pa", "Norm of the tangential stress scaled by the inverse friction matrix at the solution; at most -sigma_nu.").symbol("|F^-1 sigma_t|"),
    Stage::Post.row(PANE_SLIP, Kind::F64, PANE_PAIRS, "m", "Mean tangential displacement of each pane.").symbol("u_t"),
    Stage::Post.row(PANE_GAP, Kind::F64, PANES, "m", "Mean distance of each pane to the foundation.").symbol("d - u_nu"),
    Stage::Post.row(PANE_FRICTION, Kind::F64, PANE_PAIRS, "1", "Coefficients of friction acting on each pane at the solution.").symbol("F_1, F_2"),
    Stage::Post.row(NODAL_FRICTION, Kind::F64, &[Named("n_contact_nodes"), Fixed(2)], "1", "Coefficients of friction at the contact nodes at the solution.").symbol("F_1, F_2"),
    Stage::Post.row(STRESS, Kind::F64, &[Named("n_tetrahedra"), Fixed(6)], "Pa", "Stress xx, yy, zz, yz, xz, xy of each tetrahedron.").symbol("sigma"),
    Stage::Post.row(VON_MISES, Kind::F64, &[Named("n_tetrahedra")], "Pa", "Von Mises stress of each tetrahedron."),
    Stage::Post.row(ZONE_COUNTS, Kind::I64, &[Fixed(3)], "1", "Numbers of open, sticking and slipping panes."),
    Stage::Post.row(NORMAL_FORCE, Kind::F64, &[], "N", "Total normal contact force."),
    Stage::Post.row("/post/resultants/tangential_force", Kind::F64, &[Fixed(2)], "N", "Sum of area times tangential multiplier along t1 and t2; the foundation acts with its opposite."),
    Stage::Post.row("/post/resultants/contact_force", Kind::F64, VECTOR, "N", "Force of the foundation on the body."),
    Stage::Post.row("/post/resultants/applied_force", Kind::F64, VECTOR, "N", "Resultant of the applied loads."),
    Stage::Post.row("/post/resultants/clamp_force", Kind::F64, VECTOR, "N", "Reaction of the clamps."),
    Stage::Post.row("/post/resultants/moments", Kind::F64, &[Fixed(3), Fixed(3)], "N m", "Moments about the origin of contact, applied and clamp forces, one row each."),
    Stage::Post.row("/post/resultants/force_imbalance", Kind::F64, &[], "1", "Norm of the sum of forces over the sum of their norms."),
    Stage::Post.row("/post/resultants/moment_imbalance", Kind::F64, &[], "1", "Norm of the sum of moments over the sum of their norms."),
    Stage::Post.row(STRAIN_ENERGY, Kind::F64, &[], "J", "Strain energy u.Au / 2."),
    Stage::Post.row("/post/resultants/load_work", Kind::F64, &[], "J", "Work l.u of the loads."),
    Stage::Post.row("/post/resultants/largest_displacement", Kind::F64, VECTOR, "m", "Largest |u_x|, |u_y|, |u_z| of a node."),
    Stage::Post.row(LARGEST_PRESSURE, Kind::F64, &[], "Pa", "Largest normal multiplier."),
    Stage::Post.row("/post/certificate/equilibrium", Kind::F64, &[], "1", "|A u + B^T lambda - l| / |l|."),
    Stage::Post.row("/post/certificate/penetration", Kind::F64, &[], "1", "Largest mean penetration of a pane over the largest displacement component."),
    Stage::Post.row("/post/certificate/adhesion", Kind::F64, &[], "1", "Largest tensile normal multiplier over the largest multiplier."),
    Stage::Post.row("/post/certificate/complementarity", Kind::F64, &[], "1", "Sum over panes of |lambda_nu gap| times area, over l.u."),
    Stage::Post.row("/post/certificate/friction_bound", Kind::F64, &[], "1", "Largest excess of |F^-1 lambda_t| over lambda_nu, over the largest lambda_nu."),
    Stage::Post.row("/post/certificate/slip_direction", Kind::F64, &[], "1", "Sum over panes of the frictional work that misses to that of the law's slip direction, in absolute value, over l.u."),
    Stage::Post.row("/post/certificate/fixed_point", Kind::F64, &[], "1", "|lambda - P(lambda - alpha r)| / |lambda| on the solution's own admissible set."),
];

/// Writes the report.
///
/// # Errors
/// HDF5 failures.
pub fn write(writer: &mut StageWriter<'_>, report: &ContactReport) -> Result<(), StoreError> {
    write_panes(writer, &report.panes)?;
    let nodal = &report.friction.nodal;
    writer.write(NODAL_FRICTION, nodal.as_flattened(), &[nodal.len(), 2])?;
    writer.write(
        STRESS,
        report.stress.as_flattened(),
        &[report.stress.len(), 6],
    )?;
    writer.write(VON_MISES, &report.von_mises, &[report.von_mises.len()])?;
    let counts = [Zone::Open, Zone::Stick, Zone::Slip].map(|zone| report.count(zone));
    writer.write_indices(ZONE_COUNTS, &counts, &[3])?;
    let r = &report.resultants;
    let scalars = [
        (NORMAL_FORCE, r.normal_force),
        ("/post/resultants/force_imbalance", r.force_imbalance),
        ("/post/resultants/moment_imbalance", r.moment_imbalance),
        (STRAIN_ENERGY, r.strain_energy),
        ("/post/resultants/load_work", r.load_work),
        (LARGEST_PRESSURE, r.largest_pressure),
    ];
    for (path, value) in scalars {
        writer.write(path, &[value], &[])?;
    }
    let vectors = [
        ("/post/resultants/contact_force", r.contact_force),
        ("/post/resultants/applied_force", r.applied_force),
        ("/post/resultants/clamp_force", r.clamp_force),
        (
            "/post/resultants/largest_displacement",
            r.largest_displacement,
        ),
    ];
    for (path, value) in vectors {
        writer.write(path, &value, &[3])?;
    }
    writer.write(
        "/post/resultants/tangential_force",
        &r.tangential_force,
        &[2],
    )?;
    writer.write(
        "/post/resultants/moments",
        r.moments.as_flattened(),
        &[3, 3],
    )?;
    for (name, value) in report.certificate.figures() {
        writer.write(&format!("/post/certificate/{name}"), &[value], &[])?;
    }
    Ok(())
}

fn write_panes(writer: &mut StageWriter<'_>, panes: &[PaneState]) -> Result<(), StoreError> {
    type Measure = fn(&PaneState) -> f64;
    type Pair = fn(&PaneState) -> [f64; 2];
    let zones: Vec<StoredZone> = panes
        .iter()
        .filter_map(|pane| StoredZone::from_code(pane.zone as u8))
        .collect();
    writer.write_enum(ZONE, &zones, &[zones.len()])?;
    let measures: [(&str, Measure); 4] = [
        (MARGIN, |p| p.margin),
        (NORMAL_STRESS, |p| p.normal_stress),
        (SCALED_TANGENTIAL, |p| p.scaled_tangential_stress),
        (PANE_GAP, |p| p.gap),
    ];
    for (path, measure) in measures {
        let values: Vec<f64> = panes.iter().map(measure).collect();
        writer.write(path, &values, &[panes.len()])?;
    }
    let pairs: [(&str, Pair); 3] = [
        (TANGENTIAL_STRESS, |p| p.tangential_stress),
        (PANE_SLIP, |p| p.slip),
        (PANE_FRICTION, |p| p.friction),
    ];
    for (path, pair) in pairs {
        let values: Vec<[f64; 2]> = panes.iter().map(pair).collect();
        writer.write(path, values.as_flattened(), &[panes.len(), 2])?;
    }
    Ok(())
}

/// The few figures that a status line shows.
#[derive(Debug, Clone, PartialEq)]
pub struct Summary {
    /// Numbers of open, sticking and slipping panes.
    pub zone_counts: Vec<usize>,
    /// Total normal contact force in N.
    pub normal_force: f64,
    /// Largest pressure in Pa.
    pub largest_pressure: f64,
    /// Strain energy in J.
    pub strain_energy: f64,
}

/// Reads the main figures.
///
/// # Errors
/// Missing or altered datasets.
pub fn read_summary(reader: &Reader) -> Result<Summary, FormatError> {
    Ok(Summary {
        zone_counts: read_index_vec(reader, ZONE_COUNTS)?,
        normal_force: read_finite_scalar(reader, NORMAL_FORCE)?,
        largest_pressure: read_finite_scalar(reader, LARGEST_PRESSURE)?,
        strain_energy: read_finite_scalar(reader, STRAIN_ENERGY)?,
    })
}
