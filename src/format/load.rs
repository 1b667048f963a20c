//! `/load`: the loads, and what follows from them linearly.

use std::sync::Arc;

use contact3d::dual::{DualSystem, PrimalSystem};
use runfile::{DatasetSpec, Extent::Named, Group, GroupWriter, Kind, Reader, StoreError};
use units::Dimension;

use super::{
    FormatError, Stage, extents,
    fields::{read_finite, read_finite_if_there, write_list, write_value},
};

/// Loads and what follows from them linearly.
pub(super) const GROUP: Group = Group::new("load", Stage::Load.command());

pub(super) const FORCE: &str = "/load/force";
const PRESCRIBED: &str = "/load/prescribed_displacement";
const PRESCRIBED_TOOLS: &str = "/load/prescribed_tool_rows";
const DUAL_RHS: &str = "/load/dual_rhs";
const SLIP_FREE: &str = "/load/slip_free";

#[rustfmt::skip]
pub(super) const TABLE: &[DatasetSpec] = &[
    GROUP.row(FORCE, Kind::F64, &[Named("n_free")], Dimension::FORCE, "Load vector, less the forces A_fc u_c that prescribed displacements take.").symbol("l"),
    GROUP.row(PRESCRIBED, Kind::F64, &[Named("n_nodes"), extents::XYZ], Dimension::LENGTH, "Displacement at which the clamps hold each node, zero where free.").symbol("u_c").optional("absent where all clamps and tools hold at zero").compressed(),
    GROUP.row(PRESCRIBED_TOOLS, Kind::F64, &[Named("n_tool_rows"), extents::XYZ], Dimension::LENGTH, "Displacement of the point and turn times arm at which each tool is held, zero where free.").optional("absent without tools, and where all clamps and tools hold at zero"),
    GROUP.row(DUAL_RHS, Kind::F64, &[Named("n_multipliers")], Dimension::VOLUME, "Right-hand side B A^-1 l of the dual problem plus B u_c, minus the integrated gap in its first m entries, in the order of S. S lambda - h is -B u, plus the gap: pane area times pane_gap, then times -u_t, the tangential displacement from the first place on (pane_slip without a load history).").symbol("h").optional("absent without contact"),
    GROUP.row(SLIP_FREE, Kind::F64, &[Named("n_contact_nodes"), extents::FRICTION_AXES], Dimension::LENGTH, "Tangential displacement of the contact nodes without contact.").optional("absent unless the dual operator is explicit and friction follows the slip"),
];

/// Writes l, the prescribed displacements, h and the free slip.
pub fn write(writer: &mut GroupWriter<'_>, system: &DualSystem) -> Result<(), StoreError> {
    let primal = &system.assembly.primal;
    write_value(writer, FORCE, &primal.load)?;
    if let Some(prescribed) = &primal.dofs.prescribed {
        let (of_nodes, of_tools) = prescribed.split_at(primal.dofs.n_nodes);
        write_list(writer, PRESCRIBED, of_nodes)?;
        if !of_tools.is_empty() {
            write_list(writer, PRESCRIBED_TOOLS, of_tools)?;
        }
    }
    let Some(contact) = &system.contact else {
        return Ok(());
    };
    write_list(writer, DUAL_RHS, contact.dual_rhs())?;
    let explicit = contact.explicit();
    if let Some(compliance) = explicit.and_then(|explicit| explicit.compliance.as_ref()) {
        write_value(writer, SLIP_FREE, &compliance.slip_free)?;
    }
    Ok(())
}

/// Reads l, h and the free slip into an assembled problem.
pub fn read(reader: &Reader, system: &mut DualSystem) -> Result<(), FormatError> {
    read_into(reader, &mut system.assembly.primal)?;
    if let Some(contact) = &mut system.contact {
        contact.set_dual_rhs(read_finite(reader, DUAL_RHS)?);
        if let Some(explicit) = contact.explicit_mut()
            && let Some(compliance) = &mut explicit.compliance
        {
            compliance.slip_free = read_finite(reader, SLIP_FREE)?;
        }
    }
    Ok(())
}

/// Reads l and the prescribed displacements alone.
pub(super) fn read_into(reader: &Reader, primal: &mut PrimalSystem) -> Result<(), FormatError> {
    primal.load = read_finite(reader, FORCE)?;
    let of_nodes: Option<Vec<[f64; 3]>> = read_finite_if_there(reader, PRESCRIBED)?;
    let of_tools: Option<Vec<[f64; 3]>> = read_finite_if_there(reader, PRESCRIBED_TOOLS)?;
    let prescribed = of_nodes.map(|rows| [rows, of_tools.unwrap_or_default()].concat());
    primal.dofs.prescribed = prescribed.map(Arc::new);
    Ok(())
}
