//! `/accuracy/levels`, `/accuracy/order`, `/accuracy/limit`: the discretisation ladder.

use contact3d::convergence::{Cost, DiscretisationLadder, Forces, Level};
use runfile::{
    DatasetSpec, Extent, Extent::Named, GroupWriter, Kind, Reader, StoreError, StoredEnum,
};
use units::Dimension;

use super::{GROUP, NO_CONTACT, read_costs, write_costs};
use crate::format::axes;
use crate::format::{FormatError, columns::Columns, outcome::StoredStatus, read_index_vec};

const SCENE_N_DIV: &str = "/accuracy/scene_n_div";
const N_DIV: &str = "/accuracy/levels/n_div";
const CELLS: &str = "/accuracy/levels/cells";
const CELL_SIZE: &str = "/accuracy/levels/cell_size";
const N_FREE: &str = "/accuracy/levels/unknowns";
const N_MULTIPLIERS: &str = "/accuracy/levels/multipliers";
const LEVEL_STATUS: &str = "/accuracy/levels/status";
const LEVEL_APPLICATIONS: &str = "/accuracy/levels/actions";
const ENERGY_DIFFERENCE: &str = "/accuracy/levels/energy_difference";
const LEVEL_ENERGY_ERROR: &str = "/accuracy/levels/energy_error";
const ESTIMATED_ERROR: &str = "/accuracy/levels/estimated_error";
const POTENTIAL_ENERGY: &str = "/accuracy/levels/potential_energy";
const NORMAL_FORCE: &str = "/accuracy/levels/normal_force";
const TANGENTIAL_FORCE: &str = "/accuracy/levels/tangential_force";
const LEVEL_SECONDS: &str = "/accuracy/levels/seconds";
const LEVEL_REPEATS: &str = "/accuracy/levels/repeats";
const LEVEL_PEAK: &str = "/accuracy/levels/peak_memory";
const ENERGY_NORM_ORDER: &str = "/accuracy/order/energy_norm";
const POTENTIAL_ENERGY_ORDER: &str = "/accuracy/order/potential_energy";
const FORCE_ORDER: &str = "/accuracy/order/forces";
const POTENTIAL_ENERGY_LIMIT: &str = "/accuracy/limit/potential_energy";
const FORCE_LIMIT: &str = "/accuracy/limit/forces";

const NO_FRICTION: &str = "absent without friction";
const NO_BRICK: &str = "absent for a mesh file, which has no finer meshes";
const LEVELS: &[Extent] = &[Named("n_levels")];

/// A row of the discretisation ladder.
const fn level(
    path: &'static str,
    kind: Kind,
    dimension: Dimension,
    meaning: &'static str,
) -> DatasetSpec {
    GROUP
        .row(path, kind, LEVELS, dimension, meaning)
        .optional(NO_BRICK)
}

#[rustfmt::skip]
pub(in crate::format) const TABLE: &[DatasetSpec] = &[
    GROUP.row(SCENE_N_DIV, Kind::I64, &[], Dimension::Number, "Smallest number of cells along an edge in the scene itself.").optional(NO_BRICK),
    level(N_DIV, Kind::I64, Dimension::Number, "Smallest number of cells along an edge.").symbol("n_div"),
    GROUP.row(CELLS, Kind::I64, &[Named("n_levels"), axes::XYZ], Dimension::Number, "Cells along the edges.").optional(NO_BRICK),
    level(CELL_SIZE, Kind::F64, Dimension::LENGTH, "Cube root of the mean volume of a cell.").symbol("h"),
    level(N_FREE, Kind::I64, Dimension::Number, "Free degrees of freedom."),
    level(N_MULTIPLIERS, Kind::I64, Dimension::Number, "Multipliers."),
    level(LEVEL_STATUS, Kind::Enum(StoredStatus::SPEC), Dimension::Number, "How the solve ended."),
    level(LEVEL_APPLICATIONS, Kind::I64, Dimension::Number, "Applications of the dual operator.").symbol("n_A"),
    level(ENERGY_DIFFERENCE, Kind::F64, Dimension::Number, "|u_h - u_f|_A / |u_f|_A with u_f of the finest mesh.").symbol("e_h"),
    level(LEVEL_ENERGY_ERROR, Kind::F64, Dimension::Number, "|u_h - u|_A / |u_f|_A with the extrapolated limit of e_h^2; NaN where no order is observed."),
    level(ESTIMATED_ERROR, Kind::F64, Dimension::Number, "Error of u_h over |u_h|_A as its own report estimates it.").optional("absent for a mesh file, and in files before format 1.4"),
    level(POTENTIAL_ENERGY, Kind::F64, Dimension::Energy, "u.Au / 2 - l.u.").symbol("J"),
    level(NORMAL_FORCE, Kind::F64, Dimension::FORCE, "Total normal contact force.").optional(NO_CONTACT),
    GROUP.row(TANGENTIAL_FORCE, Kind::F64, &[Named("n_levels"), axes::FRICTION_AXES], Dimension::FORCE, "Total tangential multiplier force along t1 and t2.").optional(NO_FRICTION),
    level(LEVEL_SECONDS, Kind::F64, Dimension::Time, "Median wall-clock time of mesh, assembly, solve and evaluation in memory.").volatile(),
    level(LEVEL_REPEATS, Kind::I64, Dimension::Number, "Runs the median is taken of.").volatile(),
    level(LEVEL_PEAK, Kind::F64, Dimension::Memory, "Peak resident memory of the process meanwhile, NaN where unknown.").volatile(),
    level(ENERGY_NORM_ORDER, Kind::F64, Dimension::Number, "Order of the energy-norm error observed from each level and the two before it; NaN where none is.").symbol("p"),
    level(POTENTIAL_ENERGY_ORDER, Kind::F64, Dimension::Number, "Order of the potential energy, likewise."),
    GROUP.row(FORCE_ORDER, Kind::F64, &[Named("n_levels"), axes::CONTACT_AXES], Dimension::Number, "Orders of the normal and the two tangential forces, likewise; NaN for forces the scene does not have.").optional(NO_CONTACT),
    GROUP.row(POTENTIAL_ENERGY_LIMIT, Kind::F64, &[], Dimension::Energy, "Extrapolated potential energy; NaN where no order is observed.").optional(NO_BRICK),
    GROUP.row(FORCE_LIMIT, Kind::F64, &[axes::CONTACT_AXES], Dimension::FORCE, "Extrapolated normal and tangential forces, likewise.").optional(NO_CONTACT),
];

/// Writes meshes, orders and limits.
pub(super) fn write(
    writer: &mut GroupWriter<'_>,
    ladder: &DiscretisationLadder,
) -> Result<(), StoreError> {
    write_levels(writer, ladder)?;
    write_trends(writer, ladder)
}

fn write_levels(
    writer: &mut GroupWriter<'_>,
    ladder: &DiscretisationLadder,
) -> Result<(), StoreError> {
    let levels = &ladder.levels;
    writer.write_indices(SCENE_N_DIV, &[ladder.scene_n_div], &[])?;
    let cells: Vec<usize> = levels.iter().flat_map(|level| level.cells).collect();
    writer.write_indices(CELLS, &cells, &[levels.len(), 3])?;
    let mut columns = Columns::new(writer, levels);
    columns.counts(N_DIV, |l| l.n_div)?;
    columns.counts(N_FREE, |l| l.n_free)?;
    columns.counts(N_MULTIPLIERS, |l| l.n_multipliers)?;
    columns.counts(LEVEL_APPLICATIONS, |l| l.applications)?;
    columns.members(LEVEL_STATUS, |l| StoredStatus::from(l.status))?;
    columns.numbers(CELL_SIZE, |l| l.cell_size)?;
    columns.numbers(ENERGY_DIFFERENCE, |l| l.energy_difference)?;
    columns.numbers(LEVEL_ENERGY_ERROR, |l| l.energy_error.unwrap_or(f64::NAN))?;
    columns.numbers(ESTIMATED_ERROR, |l| l.estimated_error)?;
    columns.numbers(POTENTIAL_ENERGY, |l| l.potential_energy)?;
    let forces: Option<Vec<Forces>> = levels.iter().map(|level| level.forces).collect();
    if let Some(forces) = forces {
        Columns::new(writer, &forces).numbers(NORMAL_FORCE, |f| f.normal)?;
        let tangential: Option<Vec<[f64; 2]>> = forces.iter().map(|f| f.tangential).collect();
        if let Some(pairs) = tangential {
            writer.write(TANGENTIAL_FORCE, pairs.as_flattened(), &[levels.len(), 2])?;
        }
    }
    let costs: Vec<Option<Cost>> = levels.iter().map(|level| Some(level.cost)).collect();
    write_costs(writer, [LEVEL_SECONDS, LEVEL_REPEATS, LEVEL_PEAK], &costs)
}

fn write_trends(
    writer: &mut GroupWriter<'_>,
    ladder: &DiscretisationLadder,
) -> Result<(), StoreError> {
    let n = ladder.levels.len();
    let known = |value: &Option<f64>| value.unwrap_or(f64::NAN);
    for (path, trend) in [
        (ENERGY_NORM_ORDER, &ladder.energy_norm),
        (POTENTIAL_ENERGY_ORDER, &ladder.potential_energy),
    ] {
        let orders: Vec<f64> = trend.orders.iter().map(known).collect();
        writer.write(path, &orders, &[n])?;
    }
    let limit = known(&ladder.potential_energy.limit);
    writer.write(POTENTIAL_ENERGY_LIMIT, &[limit], &[])?;
    if ladder.forces.is_empty() {
        return Ok(());
    }
    let component = |k: usize| ladder.forces.get(k);
    let order = |level: usize, k: usize| component(k).and_then(|t| t.orders[level]);
    let orders: Vec<f64> = (0..n)
        .flat_map(|level| (0..3).map(move |k| known(&order(level, k))))
        .collect();
    writer.write(FORCE_ORDER, &orders, &[n, 3])?;
    let limits: Vec<f64> = (0..3)
        .map(|k| known(&component(k).and_then(|trend| trend.limit)))
        .collect();
    writer.write(FORCE_LIMIT, &limits, &[3])
}

/// The discretisation ladder; `None` in a file without it.
pub(super) fn read(reader: &Reader) -> Result<Option<DiscretisationLadder>, FormatError> {
    if !reader.has(N_DIV) {
        return Ok(None);
    }
    let n_div = read_index_vec(reader, N_DIV)?;
    let cells = read_index_vec(reader, CELLS)?;
    let cell_size: Vec<f64> = reader.read_vec(CELL_SIZE)?;
    let n_free = read_index_vec(reader, N_FREE)?;
    let n_multipliers = read_index_vec(reader, N_MULTIPLIERS)?;
    let statuses = reader.read_enum::<StoredStatus>(LEVEL_STATUS)?;
    let applications = read_index_vec(reader, LEVEL_APPLICATIONS)?;
    let difference: Vec<f64> = reader.read_vec(ENERGY_DIFFERENCE)?;
    let energies: Vec<f64> = reader.read_vec(POTENTIAL_ENERGY)?;
    let costs = read_costs(reader, [LEVEL_SECONDS, LEVEL_REPEATS, LEVEL_PEAK])?;
    let optional = |path| match reader.has(path) {
        true => reader.read_vec::<f64>(path).map(Some),
        false => Ok(None),
    };
    let estimated = optional(ESTIMATED_ERROR)?;
    let normal = optional(NORMAL_FORCE)?;
    let tangential = optional(TANGENTIAL_FORCE)?;
    let forces = |k: usize| {
        Some(Forces {
            normal: normal.as_ref()?[k],
            tangential: tangential.as_ref().map(|t| [t[2 * k], t[2 * k + 1]]),
        })
    };
    let levels = (0..n_div.len()).map(|k| Level {
        n_div: n_div[k],
        cells: [cells[3 * k], cells[3 * k + 1], cells[3 * k + 2]],
        cell_size: cell_size[k],
        n_free: n_free[k],
        n_multipliers: n_multipliers[k],
        status: statuses[k].into(),
        applications: applications[k],
        energy_difference: difference[k],
        energy_error: None,
        estimated_error: estimated.as_ref().map_or(f64::NAN, |values| values[k]),
        potential_energy: energies[k],
        forces: forces(k),
        cost: costs[k],
    });
    let levels = levels.collect();
    let scene_n_div = read_index_vec(reader, SCENE_N_DIV)?;
    Ok(Some(DiscretisationLadder::new(
        scene_n_div.first().copied().unwrap_or(0),
        levels,
    )))
}
