//! `/bound`: a bound of the discretisation error, with the balanced forces between tetrahedra that prove it.

use runfile::{
    Extent,
    Extent::{Fixed, Named},
    Group, GroupWriter, Reader, StoreError,
};
use studies::bound::{BoundParts, ErrorBound, SideForce};
use units::Dimension;

use super::{
    FormatError, extents,
    fields::{Fields, fields},
};

/// The bound of the error; computed from a solved file.
pub const GROUP: Group = Group::new("bound", "bound");

const NO_TOTAL: &str =
    "absent where friction follows the pressure, or a slip bound or gap is a formula";
const NO_CONTACT: &str = "absent without contact, and where friction follows the pressure, or a slip bound or gap is a formula";
const NO_FRICTION: &str = "absent without a given slip bound";
const SIDES: Extent = Named("n_tetrahedron_sides");

pub(super) const FIELDS: Fields<BoundParts> = fields! { BoundParts => GROUP;
    (elements) "/bound/elements", &[], Dimension::Number, "|u - u_h|_A / |u_h|_A is no larger, for the body under the contact stresses of the answer.";
    (total) "/bound/total", &[], Dimension::Number, "|u - u_h|_A / |u_h|_A is no larger.".optional(NO_TOTAL);
    (lifting) "/bound/lifting", &[], Dimension::Number, "Part of total: energy norm of the displacement that lifts what penetrates inside panes.".optional(NO_CONTACT);
    (complementarity) "/bound/complementarity", &[], Dimension::Number, "Part of total: pressure across a gap, once lifted.".optional(NO_CONTACT);
    (friction) "/bound/friction", &[], Dimension::Number, "Part of total: slip that friction does not fully oppose.".optional(NO_FRICTION);
};

pub(super) const SIDE_FORCES: Fields<SideForce> = fields! { SideForce => GROUP;
    (nodes) "/bound/side_nodes", &[SIDES, Fixed(3)], Dimension::Number, "Corners of each side of a tetrahedron, increasing.";
    (tetrahedron) "/bound/side_tetrahedron", &[SIDES], Dimension::Number, "The tetrahedron that its force acts on; the opposite acts on the one on the other side.";
    (force) "/bound/side_force", &[SIDES, Fixed(3), extents::XYZ], Dimension::FORCE, "Force of each corner: integral of its hat function times the traction, in balance with all loads.";
};

/// Writes a bound and its proof.
pub fn write(writer: &mut GroupWriter<'_>, bound: &ErrorBound) -> Result<(), StoreError> {
    FIELDS.write_one(writer, &bound.relative())?;
    SIDE_FORCES.write_rows(writer, &bound.forces)
}

/// Reads a bound over ‖u_h‖_A, without its proof.
pub fn read(reader: &Reader) -> Result<BoundParts, FormatError> {
    let mut bound = BoundParts::default();
    FIELDS.read_one(reader, &mut bound, true)?;
    Ok(bound)
}
