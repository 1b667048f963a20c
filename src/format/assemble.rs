//! `/assemble`: stiffness, coupling, Cholesky factor, dense dual operator.

use std::{collections::BTreeMap, sync::Arc};

use contact3d::{
    contact::Coupling,
    dual::{
        Assembly, AssemblySeconds, ContactCompliance, ContactSystem, DualSystem, ExplicitDual,
        OperatorForm, PrimalSystem,
    },
    elasticity::{DofMap, RigidModes, ToolPoint, WeakSupport},
    linalg::{
        CholeskyFactor, CscMatrix, EngineError, Factor, FactorStructure, Precision, RemoteFactor,
        Work,
    },
};
use runfile::{
    DatasetSpec, Extent,
    Extent::{Fixed, Named, Plus},
    Group, GroupWriter, Kind, Reader, SparseMatrix, StoreError,
};
use units::Dimension;

use super::{
    FormatError, Stage, as_columns, columns, extents,
    fields::{Fields, fields, read_finite, read_finite_if_there, read_value, write_value},
    load, require, rows_of_transpose,
};

/// Matrices and the factor.
pub(super) const GROUP: Group = Group::new("assemble", Stage::Assemble.command());

const DOFS: &str = "/assemble/degree_of_freedom";
const TOOL_DOFS: &str = "/assemble/tool_degree_of_freedom";
const TIED_NODES: &str = "/assemble/tied_nodes";
const TIED_LEVERS: &str = "/assemble/tied_levers";
const STIFFNESS: &str = "/assemble/stiffness";
const COUPLING_NORMAL: &str = "/assemble/coupling_normal";
const COUPLING_TANGENTIAL: &str = "/assemble/coupling_tangential";
const RIGID_MODES: &str = "/assemble/rigid_modes";
pub(super) const RIGID_PINS: &str = "/assemble/rigid_pins";
const RIGID_SPRING: &str = "/assemble/rigid_spring";
const RIGID_SUPPORT: &str = "/assemble/rigid_support";
const RIGID_SPRING_RESPONSE: &str = "/assemble/rigid_spring_response";
const DUAL_OPERATOR: &str = "/assemble/dual_operator";
const CONTACT_COMPLIANCE: &str = "/assemble/contact_compliance";
const VALUES: &str = "/assemble/factor/values";
const DUAL_OPERATOR_SINGLE: &str = "/assemble/dual_operator_single";
const CONTACT_COMPLIANCE_SINGLE: &str = "/assemble/contact_compliance_single";
const VALUES_SINGLE: &str = "/assemble/factor/values_single";

const IMPLICIT: &str =
    "absent when the dual operator is applied through the factor, or is stored in single precision";
const IN_DOUBLE: &str =
    "absent when the dual operator is stored in double precision, or applied through the factor";
const SINGLE: &str = "absent when the factor is in single precision, stays with an engine, or is made again from A where it is needed: only \
     a file beside the run file holds it";
const NO_VALUES: &str =
    "absent when no values of the factor are stored; it follows from A and the order";
const DOUBLE: &str = "absent when the factor is in double precision, stays with an engine, or is made again from A where it is needed: only \
     a file beside the run file holds it";
const MADE_IN_DOUBLE: &str = "absent when the factor stays with an engine, or is made again in double precision; without values, it says that \
     the factor is made again in single precision";
const SUPPORTED: &str = "absent where supports hold the body, and not weakly, and no tool is free";
const NO_CONTACT: &str = "absent without contact";
const NO_FRICTION: &str = "absent without friction";
const NO_SLIP: &str =
    "absent unless the dual operator is explicit in double precision and friction follows the slip";
const NO_SLIP_SINGLE: &str =
    "absent unless the dual operator is explicit in single precision and friction follows the slip";
pub(super) const RIGID: Extent = Named("n_rigid_modes");
const FREE: Extent = Named("n_free");
const OFFSETS: &[Extent] = &[Plus("n_supernodes", 1)];

#[rustfmt::skip]
pub(super) const OPERATORS: &[DatasetSpec] = &[
    GROUP.row(DOFS, Kind::I64, &[Named("n_nodes"), extents::XYZ], Dimension::Number, "Free degree of freedom of each node and component, -1 where held.").compressed(),
    GROUP.row(TOOL_DOFS, Kind::I64, &[Named("n_tool_rows"), extents::XYZ], Dimension::Number, "The same of the tools, which follow: displacement of the point, and turn times arm.").optional("absent without tools"),
    GROUP.row(TIED_NODES, Kind::I64, &[Named("n_tied_nodes"), Fixed(2)], Dimension::Number, "Node of a face that is bonded to a tool, and the tool: they have no degrees of freedom of their own.").optional("absent unless a tool is bonded to a face"),
    GROUP.row(TIED_LEVERS, Kind::F64, &[Named("n_tied_nodes"), extents::XYZ], Dimension::Number, "Place of these nodes from the point of the tool over its arm: they move by the first row of the tool plus the second one times this.").optional("absent unless a tool is bonded to a face"),
    GROUP.row(STIFFNESS, Kind::CscMatrix, &[FREE, FREE], Dimension::STIFFNESS, "Stiffness matrix over the free degrees of freedom; symmetric, both triangles stored.").symbol("A").compressed(),
    GROUP.row(RIGID_MODES, Kind::F64, &[RIGID, FREE], Dimension::Number, "Rigid modes of a body that only contact holds, and free motions of tools: the kernel of A; mode p moves pin p by one and no other pin.").symbol("Z").optional(SUPPORTED),
    GROUP.row(RIGID_PINS, Kind::I64, &[RIGID], Dimension::Number, "The pins, one free degree of freedom for each rigid mode: the factor is that of A with the spring added to these entries of its diagonal.").optional(SUPPORTED),
    GROUP.row(RIGID_SPRING, Kind::F64, &[], Dimension::STIFFNESS, "Spring at each pin; answers do not depend on it.").symbol("kappa").optional(SUPPORTED),
    GROUP.row(RIGID_SUPPORT, Kind::F64, &[RIGID, RIGID], Dimension::STIFFNESS, "Stiffness of weak springs in the rigid modes, which are unknowns of their own: (Z + Y)^T (l - B^T lambda) = D alpha.").symbol("D").optional("absent where no weak spring resists the rigid modes"),
    GROUP.row(RIGID_SPRING_RESPONSE, Kind::F64, &[RIGID, FREE], Dimension::Number, "How the body yields to the forces of weak springs K_s in the rigid modes, -A_kappa^-1 K_s Z.").symbol("Y").optional("absent where no weak spring resists the rigid modes"),
    GROUP.row(COUPLING_NORMAL, Kind::CsrMatrix, &[Named("n_panes"), FREE], Dimension::AREA, "Integral of the normal displacement over each pane.").symbol("N").optional(NO_CONTACT),
    GROUP.row(COUPLING_TANGENTIAL, Kind::CsrMatrix, &[Named("n_tangential"), FREE], Dimension::AREA, "Integrals of the tangential displacements over each pane; rows 2i and 2i + 1 belong to pane i.").symbol("T").optional(NO_FRICTION),
    GROUP.row(DUAL_OPERATOR, Kind::F64, &[Named("n_multipliers"), Named("n_multipliers")], Dimension::DUAL, "Dual operator B A^-1 B^T, symmetric; rows and columns in the order of the multipliers: one normal for each pane, then t1 and t2 of each pane with friction.").symbol("S").optional(IMPLICIT),
    GROUP.row(CONTACT_COMPLIANCE, Kind::F64, &[Named("n_multipliers"), Named("n_contact_nodes"), extents::FRICTION_AXES], Dimension::COMPLIANCE, "Tangential displacement of the contact nodes that a unit of each multiplier takes away.").symbol("H").optional(NO_SLIP),
];

pub(super) const SECONDS: Fields<AssemblySeconds> = fields! { AssemblySeconds => GROUP;
    (stiffness) "/assemble/seconds/stiffness", &[], Dimension::Time, "Wall-clock time of assembling stiffness and load.".volatile().finite();
    (ordering) "/assemble/seconds/ordering", &[], Dimension::Time, "Wall-clock time of the fill-reducing order.".volatile().finite();
    (factorisation) "/assemble/seconds/factorisation", &[], Dimension::Time, "Wall-clock time of the Cholesky factorisation.".volatile().finite();
    (dual_operator) "/assemble/seconds/dual_operator", &[], Dimension::Time, "Wall-clock time of forming the dual operator and the contact compliance; 0 when it is implicit.".volatile().finite();
};

pub(super) const FACTOR: Fields<FactorStructure> = fields! { FactorStructure => GROUP;
    (permutation) "/assemble/factor/permutation", &[FREE], Dimension::Number, "Fill-reducing order: row i of P A P^T = L L^T is row permutation[i] of A.".symbol("P").compressed();
    (supernode_columns) "/assemble/factor/supernode_columns", OFFSETS, Dimension::Number, "First column of each supernode of L, then n_free.".compressed().optional(MADE_IN_DOUBLE).volatile();
    (row_offsets) "/assemble/factor/row_offsets", OFFSETS, Dimension::Number, "Where the rows of each supernode begin in row_indices.".compressed().optional(NO_VALUES).volatile();
    (row_indices) "/assemble/factor/row_indices", &[Named("n_factor_rows")], Dimension::Number, "Rows of each supernode, increasing; the first are its own columns.".compressed().optional(NO_VALUES).volatile();
    (value_offsets) "/assemble/factor/value_offsets", OFFSETS, Dimension::Number, "Where the panel of each supernode begins in values.".compressed().optional(NO_VALUES).volatile();
    {Kind::F64} VALUES, &[Named("n_factor_values")], Dimension::ROOT_OF_STIFFNESS, "Dense column-major panel (rows, columns) of each supernode of the Cholesky factor.".symbol("L").optional(SINGLE).volatile();
    {Kind::F32} VALUES_SINGLE, &[Named("n_factor_values")], Dimension::ROOT_OF_STIFFNESS, "The same in single precision: L L^T is A to about seven digits, a preconditioner.".symbol("L").optional(DOUBLE).volatile();
    {Kind::F32} DUAL_OPERATOR_SINGLE, &[Named("n_multipliers"), Named("n_multipliers")], Dimension::DUAL, "Dual operator made from a factor in single precision, symmetric; solves correct its error by exact residuals.".symbol("S").optional(IN_DOUBLE);
    {Kind::F32} CONTACT_COMPLIANCE_SINGLE, &[Named("n_multipliers"), Named("n_contact_nodes"), extents::FRICTION_AXES], Dimension::COMPLIANCE, "Contact compliance made from a factor in single precision.".symbol("H").optional(NO_SLIP_SINGLE);
};

/// Bytes of the large arrays of an assembled problem in the file; the rest adds a few percent.
pub fn stored_bytes(system: &DualSystem) -> usize {
    let assembly = &system.assembly;
    let explicit = system.contact.as_ref().and_then(ContactSystem::explicit);
    let dense = explicit.map_or(0, |explicit| {
        let compliance = explicit.compliance.as_ref();
        explicit.operator.as_slice().len() + compliance.map_or(0, |c| c.matrix.len())
    });
    let in_factor = match &*assembly.factor {
        Factor::Double(_) | Factor::Single(_) => assembly.factor.structure().value_count(),
        Factor::Remote(_) => 0,
    };
    let in_precision = in_factor + dense;
    let double = assembly.primal.stiffness.data.len() * size_of::<f64>();
    in_precision * assembly.factor.precision().bytes() + double
}

/// Writes all of the assembled problem that does not depend on the loads; to a file that run files share also a factor that could be made
/// again.
pub fn write(
    writer: &mut GroupWriter<'_>,
    system: &DualSystem,
    is_shared: bool,
) -> Result<(), StoreError> {
    if let Some(contact) = &system.contact {
        write_contact(writer, contact)?;
    }
    let assembly = &system.assembly;
    let primal = &assembly.primal;
    let (of_nodes, of_tools) = primal.dofs.dof.split_at(primal.dofs.n_nodes);
    for (path, rows) in [(DOFS, of_nodes), (TOOL_DOFS, of_tools)] {
        let dofs = rows.iter().flatten();
        let dofs: Vec<i64> = dofs.map(|dof| dof.map_or(-1, |d| d as i64)).collect();
        if path == DOFS || !dofs.is_empty() {
            writer.write(path, &dofs, &[rows.len(), 3])?;
        }
    }
    if !primal.dofs.tied.is_empty() {
        let tied = || primal.dofs.tied.iter();
        let nodes = tied().map(|(node, point)| [*node, point.tool]);
        write_value(writer, TIED_NODES, &nodes.collect::<Vec<_>>())?;
        let levers = tied().map(|(_, point)| point.lever);
        write_value(writer, TIED_LEVERS, &levers.collect::<Vec<_>>())?;
    }
    writer.write_matrix(STIFFNESS, columns(&primal.stiffness))?;
    if let Some(modes) = &primal.rigid_modes {
        write_rigid_modes(writer, modes)?;
    }
    SECONDS.write_one(writer, &assembly.seconds)?;
    let structure = assembly.factor.structure();
    let shape = [structure.value_count()];
    match &*assembly.factor {
        Factor::Double(factor) if is_shared => writer.write(VALUES, factor.values(), &shape)?,
        Factor::Single(factor) if is_shared => {
            writer.write(VALUES_SINGLE, factor.values(), &shape)?;
        }
        // It is made again, or stays with the engine.
        other => {
            let mut order = FactorStructure {
                permutation: structure.permutation.clone(),
                ..FactorStructure::default()
            };
            if let Factor::Single(_) = other {
                order.supernode_columns = structure.supernode_columns.clone();
            }
            return FACTOR.write_one(writer, &order);
        }
    }
    FACTOR.write_one(writer, structure)
}

fn write_rigid_modes(writer: &mut GroupWriter<'_>, rigid: &RigidModes) -> Result<(), StoreError> {
    write_value(writer, RIGID_MODES, &rigid.modes)?;
    write_value(writer, RIGID_PINS, &rigid.pins)?;
    write_value(writer, RIGID_SPRING, &rigid.spring)?;
    match &rigid.support {
        None => Ok(()),
        Some(support) => {
            write_value(writer, RIGID_SUPPORT, &support.stiffness)?;
            write_value(writer, RIGID_SPRING_RESPONSE, &support.spring_response)
        }
    }
}

fn write_contact(writer: &mut GroupWriter<'_>, contact: &ContactSystem) -> Result<(), StoreError> {
    let [normal, tangential] = contact.coupling.parts();
    writer.write_matrix(COUPLING_NORMAL, rows_of_transpose(&normal))?;
    if tangential.cols > 0 {
        writer.write_matrix(COUPLING_TANGENTIAL, rows_of_transpose(&tangential))?;
    }
    let Some(explicit) = contact.explicit() else {
        return Ok(());
    };
    let dimension = explicit.dimension();
    // Made from a factor in single precision, in whose range they are.
    let is_single = |matrix: &[f64]| matrix.iter().all(|v| f64::from(*v as f32) == *v);
    let mut dense = |double, single, matrix: &[f64], shape: &[usize]| {
        if is_single(matrix) {
            let rounded: Vec<f32> = matrix.iter().map(|value| *value as f32).collect();
            writer.write(single, &rounded, shape)
        } else {
            writer.write(double, matrix, shape)
        }
    };
    let operator = explicit.operator.as_slice();
    dense(
        DUAL_OPERATOR,
        DUAL_OPERATOR_SINGLE,
        operator,
        &[dimension, dimension],
    )?;
    if let Some(compliance) = &explicit.compliance {
        let shape = [dimension, compliance.slip_free.len(), 2];
        dense(
            CONTACT_COMPLIANCE,
            CONTACT_COMPLIANCE_SINGLE,
            &compliance.matrix,
            &shape,
        )?;
    }
    Ok(())
}

/// Reads the assembled problem; the loads are left empty for [`super::read_loads`]. A factor that is not there is made again, one that
/// stayed with an engine by the given one.
pub fn read(reader: &Reader, engine: Option<&str>) -> Result<DualSystem, FormatError> {
    let mut structure = FactorStructure::default();
    FACTOR.read_one(reader, &mut structure, true)?;
    let primal = read_stiffness(reader)?;
    let factor = if reader.has(VALUES_SINGLE) {
        let values = reader.read_vec(VALUES_SINGLE)?;
        Factor::Single(CholeskyFactor::from_parts(structure, values)?)
    } else if reader.has(VALUES) {
        let values = reader.read_vec(VALUES)?;
        Factor::Double(CholeskyFactor::from_parts(structure, values)?)
    } else {
        let is_single = !structure.supernode_columns.is_empty();
        let structure = FactorStructure::analyse(&primal.stiffness, structure.permutation)
            .map_err(|error| FormatError::inconsistent("/assemble/factor/permutation", error))?;
        let a = primal.invertible();
        if let Some(engine) = engine {
            let no_rows = CscMatrix::empty(structure.size());
            Factor::Remote(RemoteFactor::new(engine, structure, a, no_rows)?)
        } else if reader.has(DUAL_OPERATOR_SINGLE) && !is_single {
            return Err(EngineError::NotAtHand.into());
        } else {
            let precision = if is_single {
                Precision::Single
            } else {
                Precision::Double
            };
            let made = Factor::of_structure(structure, a, precision, &Work::default());
            made.map_err(|error| FormatError::inconsistent(STIFFNESS, error))?
        }
    };
    let mut seconds = AssemblySeconds::default();
    SECONDS.read_one(reader, &mut seconds, true)?;
    let assembly = Assembly {
        primal,
        factor: Arc::new(factor),
        seconds,
    };
    Ok(DualSystem::of(assembly, read_contact(reader)?))
}

fn read_contact(reader: &Reader) -> Result<Option<ContactSystem>, FormatError> {
    let Some(coupling) = read_coupling(reader)? else {
        return Ok(None);
    };
    let matrix = read_dense(reader, CONTACT_COMPLIANCE, CONTACT_COMPLIANCE_SINGLE)?;
    let compliance = matrix.map(|matrix| ContactCompliance {
        matrix: Arc::new(matrix),
        slip_free: Vec::new(),
    });
    let form = match read_dense(reader, DUAL_OPERATOR, DUAL_OPERATOR_SINGLE)? {
        None => OperatorForm::implicit(Vec::new()),
        Some(operator) => OperatorForm::Explicit(ExplicitDual {
            anchor: None,
            operator: Arc::new(operator),
            rhs: Vec::new(),
            layout: coupling.layout,
            compliance,
            rigid: None,
            contact_springs: None,
        }),
    };
    Ok(Some(ContactSystem {
        coupling,
        unconstrained: Vec::new(),
        form,
    }))
}

/// A dense matrix under the name of its precision; `None` where neither is there.
fn read_dense(
    reader: &Reader,
    double: &'static str,
    single: &'static str,
) -> Result<Option<Vec<f64>>, FormatError> {
    if reader.has(double) {
        let values = reader.read_finite_f64(double)?;
        return Ok(Some(values.into_raw_vec_and_offset().0));
    }
    if !reader.has(single) {
        return Ok(None);
    }
    let values: Vec<f64> = reader
        .read_vec::<f32>(single)?
        .into_iter()
        .map(f64::from)
        .collect();
    let is_finite = values.iter().all(|value| value.is_finite());
    require(is_finite, single, || "expected finite numbers".into())?;
    Ok(Some(values))
}

/// Reads B alone; `None` without contact.
pub fn read_coupling(reader: &Reader) -> Result<Option<Coupling>, FormatError> {
    if !reader.has(COUPLING_NORMAL) {
        return Ok(None);
    }
    let normal = as_transpose(reader.read_matrix(COUPLING_NORMAL)?);
    let tangential = if reader.has(COUPLING_TANGENTIAL) {
        as_transpose(reader.read_matrix(COUPLING_TANGENTIAL)?)
    } else {
        CscMatrix::empty(normal.rows)
    };
    Ok(Some(Coupling::from_parts(&normal, &tangential)))
}

/// Reads A and l alone, without the factor.
pub fn read_primal(reader: &Reader) -> Result<PrimalSystem, FormatError> {
    let mut primal = read_stiffness(reader)?;
    load::read_into(reader, &mut primal)?;
    Ok(primal)
}

fn read_stiffness(reader: &Reader) -> Result<PrimalSystem, FormatError> {
    let stiffness = as_columns(reader.read_matrix(STIFFNESS)?);
    Ok(PrimalSystem {
        rigid_modes: read_rigid_modes(reader, &stiffness)?,
        dofs: read_dofs(reader, stiffness.cols)?,
        stiffness: Arc::new(stiffness),
        load: Vec::new(),
    })
}

fn read_rigid_modes(
    reader: &Reader,
    stiffness: &CscMatrix,
) -> Result<Option<Arc<RigidModes>>, FormatError> {
    if !reader.has(RIGID_MODES) {
        return Ok(None);
    }
    let modes: Vec<Vec<f64>> = read_finite(reader, RIGID_MODES)?;
    let pins: Vec<usize> = read_value(reader, RIGID_PINS)?;
    let fits = pins.len() == modes.len() && pins.iter().all(|pin| *pin < stiffness.cols);
    require(fits, RIGID_PINS, || {
        let n_modes = modes.len();
        format!("expected a free degree of freedom for each of {n_modes} modes")
    })?;
    let spring = read_finite(reader, RIGID_SPRING)?;
    let support = match read_finite_if_there(reader, RIGID_SUPPORT)? {
        None => None,
        Some(stiffness) => Some(WeakSupport {
            stiffness,
            spring_response: read_finite(reader, RIGID_SPRING_RESPONSE)?,
        }),
    };
    Ok(Some(Arc::new(RigidModes::from_parts(
        modes, pins, spring, support, stiffness,
    ))))
}

fn read_dofs(reader: &Reader, n_free: usize) -> Result<DofMap, FormatError> {
    let mut stored = reader.read_vec::<i64>(DOFS)?;
    let n_nodes = stored.len() / 3;
    if reader.has(TOOL_DOFS) {
        stored.extend(reader.read_vec::<i64>(TOOL_DOFS)?);
    }
    let mut expected = 0..n_free as i64;
    for &dof in stored.iter().filter(|dof| **dof != -1) {
        require(expected.next() == Some(dof), DOFS, || {
            format!("expected -1 or the next of 0..{n_free}, found {dof}")
        })?;
    }
    let dof = stored
        .as_chunks::<3>()
        .0
        .iter()
        .map(|node| node.map(|d| usize::try_from(d).ok()));
    Ok(DofMap {
        dof: dof.collect(),
        n_nodes,
        tied: Arc::new(read_tied(reader, n_nodes)?),
        glued: BTreeMap::new(),
        n_free,
        prescribed: None,
    })
}

/// The nodes that move with tools.
fn read_tied(reader: &Reader, n_nodes: usize) -> Result<BTreeMap<usize, ToolPoint>, FormatError> {
    if !reader.has(TIED_NODES) {
        return Ok(BTreeMap::new());
    }
    let nodes: Vec<[usize; 2]> = read_value(reader, TIED_NODES)?;
    let levers: Vec<[f64; 3]> = read_finite(reader, TIED_LEVERS)?;
    let n_tools = reader.read_vec::<i64>(TOOL_DOFS)?.len() / 6;
    let is_known = |[node, tool]: &[usize; 2]| *node < n_nodes && *tool < n_tools;
    let fits = nodes.iter().all(is_known) && nodes.len() == levers.len();
    require(fits, TIED_NODES, || {
        "expected nodes of the mesh and tools, each with a lever".into()
    })?;
    let pairs = nodes.into_iter().zip(levers);
    Ok(pairs
        .map(|([node, tool], lever)| (node, ToolPoint { tool, lever }))
        .collect())
}

/// The transpose of a matrix compressed by rows.
fn as_transpose(matrix: SparseMatrix) -> CscMatrix {
    let shape = [matrix.shape[1], matrix.shape[0]];
    as_columns(SparseMatrix { shape, ..matrix })
}
