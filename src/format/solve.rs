//! `/solve`: multipliers, displacement, state of friction, what each step of the solvers did; and `/checkpoint`, where successive
//! approximations stand.

use contact3d::{
    elasticity::DofMap,
    solver::{
        FrictionState, LocalMapping, NewtonStep, OuterState, OuterStep, RigidMotions, Solution,
        SolvedBy, StartStrategy, Status, Trace,
    },
};
use runfile::{DatasetSpec, Extent, Extent::Named, Group, GroupWriter, Kind, Reader, StoreError};
use units::Dimension;

use super::{
    FormatError, Stage,
    assemble::RIGID,
    extents::{self, length},
    fields::{Condition, Fields, fields, read_as, read_value, rows, write_value},
    increments,
    stored::stored_as,
};

/// Multipliers, displacement and history.
pub(super) const GROUP: Group = Group::new("solve", Stage::Solve.command());

stored_as! {
    /// How a solve ended, as stored.
    StoredStatus of Status as "status" {
        Converged = 0 => "converged",
        MaxOuterSteps = 1 => "max_outer_steps",
        MaxOperatorApplications = 2 => "max_operator_applications",
        NumericalError = 3 => "numerical_error",
        MachinePrecision = 4 => "machine_precision",
        MaxNewtonSteps = 5 => "max_newton_steps",
        Cycling = 6 => "cycling",
        ReducedAccuracy = 7 => "reduced_accuracy",
        Inaccurate = 8 => "inaccurate",
        NoEquilibrium = 9 => "no_equilibrium",
    }
}

stored_as! {
    /// Which algorithm gave the answer, as stored.
    StoredMethod of SolvedBy as "method" {
        FixedPoint = 0 => "fixed_point",
        Newton = 1 => "newton",
        Minimisation = 2 => "minimisation",
        Direct = 3 => "direct",
    }
}

stored_as! {
    /// The start strategy that led to the solution, as stored.
    StoredStrategy of StartStrategy as "strategy" {
        Separated = 0 => "separated",
        Warm = 1 => "warm",
        Relaxed = 2 => "relaxed",
        BondedContact = 3 => "bonded_contact",
        BilateralFrictionless = 4 => "bilateral_frictionless",
        ProximalPoint = 5 => "proximal_point",
        InteriorPoint = 6 => "interior_point",
        FrictionGraph = 7 => "friction_graph",
        SuccessiveApproximations = 8 => "successive_approximations",
        ContactSprings = 9 => "contact_springs",
    }
}

const STATUS: &str = "/solve/status";
const MULTIPLIER_NORMAL: &str = "/solve/multiplier_normal";
const MULTIPLIER_TANGENTIAL: &str = "/solve/multiplier_tangential";
const DISPLACEMENT: &str = "/solve/displacement";
const TOOL_ROWS: &str = "/solve/tool_rows";
const LOCAL_STIFFNESS_NORMAL: &str = "/solve/local_stiffness_normal";
const LOCAL_STIFFNESS_TANGENTIAL: &str = "/solve/local_stiffness_tangential";
const APPLICATIONS: &str = "/solve/applications";
const METHOD: &str = "/solve/method";
const ACCURACY: &str = "/solve/accuracy";
pub(super) const HISTORY_DIGEST: &str = "/solve/history_digest";

const NO_CONTACT: Condition<Solution> = ("absent without contact", |solution| {
    !solution.multiplier.is_empty()
});
const NO_COULOMB: Condition<Solution> = ("absent without Coulomb friction", |solution| {
    solution.friction.is_some()
});
const NO_LINEARISATION: Condition<Solution> = (
    "absent unless a solution with Coulomb friction was found with the dense operator, without contact springs",
    |solution| {
        let friction = solution.friction.as_ref();
        friction.is_some_and(|it| it.local_mapping.is_some())
    },
);

const PANES: &[Extent] = &[Named("n_panes")];
const PANE_PAIRS: &[Extent] = &[Named("n_friction_panes"), extents::FRICTION_AXES];

pub(super) const FIELDS: Fields<Solution> = fields! { Solution => GROUP;
    (status) STATUS, &[], Dimension::Number, "How the solve ended: converged to epsilon; machine_precision and reduced_accuracy near the solution, as far as accuracy says; anything else is a failed solve.";
    {Kind::F64} MULTIPLIER_NORMAL, PANES, Dimension::STRESS, "Normal contact multiplier, the pressure on each pane.".symbol("lambda_nu").when(NO_CONTACT);
    {Kind::F64} MULTIPLIER_TANGENTIAL, PANE_PAIRS, Dimension::STRESS, "Tangential contact multipliers along t1 and t2.".symbol("lambda_t").optional("absent without friction");
    {Kind::F64} DISPLACEMENT, &[Named("n_nodes"), extents::XYZ], Dimension::LENGTH, "Displacement of every node, that of its clamp where held.".symbol("u");
    {Kind::F64} TOOL_ROWS, &[Named("n_tool_rows"), extents::XYZ], Dimension::LENGTH, "For each tool the displacement of its point, and its turn times its arm; /post/tools has the turn itself.".optional("absent without tools");
    (rigid?.motion) "/solve/rigid_motion", &[RIGID], Dimension::LENGTH, "Rigid motions of a body that only contact or weak springs hold: the part R alpha of the displacement beside that of a body whose pins rest; zero without equilibrium.".symbol("alpha").optional("absent where supports hold the body").missing(|solution| solution.rigid = None).finite();
    (rigid?.mechanism) "/solve/mechanism", &[Named("n_rows"), extents::XYZ], Dimension::Number, "Rigid motion in which the load works and which no admissible contact force opposes, of largest component one.".symbol("q").optional("absent unless there is no equilibrium").finite();
    (rigid?.null_space) "/solve/null_space_motions", &[Named("n_null_space_motions"), Named("n_rows"), extents::XYZ], Dimension::Number, "Rigid motions that neither contact nor supports feel, each of largest component one; the displacement has none of them.".optional("absent where every rigid motion is felt").finite();
    (friction?.slip) "/solve/slip", &[Named("n_contact_nodes"), extents::FRICTION_AXES], Dimension::LENGTH, "Slips that the friction follows at the contact nodes: |u_t1| and |u_t2|.".symbol("phi").optional("absent unless friction follows the slip").finite();
    (friction?.coulomb.slip_bound) "/solve/slip_bound", &[Named("n_friction_panes")], Dimension::STRESS, "Slip bound of the last inner problem.".symbol("g").when(NO_COULOMB).missing(|solution| solution.friction = None).finite();
    (friction?.coulomb.friction.nodal) "/solve/friction", &[Named("n_friction_nodes"), extents::FRICTION_AXES], Dimension::Number, "Coefficients at the contact nodes in the last inner problem.".symbol("F_1, F_2").when(NO_COULOMB).finite();
    (friction?.coulomb.friction.pane_inverse) "/solve/friction_inverse", PANE_PAIRS, Dimension::Number, "Diagonal of the inverse friction matrix averaged over each pane, in the last inner problem.".symbol("Fbar^-1").when(NO_COULOMB).finite();
    (trace.steplength) "/solve/steplength", &[], Dimension::PER_DUAL, "Steplength of projected gradient steps, 1.9 over the norm of the dual operator.".symbol("alpha").when(NO_CONTACT).finite();
    {Kind::F64} LOCAL_STIFFNESS_NORMAL, PANES, Dimension::PER_DUAL, "Stiffness of each pane along the normal while the others do not move, that residuals are measured by.".symbol("rho_nu").optional("absent without contact");
    {Kind::F64} LOCAL_STIFFNESS_TANGENTIAL, PANE_PAIRS, Dimension::PER_DUAL, "The same along t1 and t2: one for both where both can move.".symbol("rho_t").optional("absent without friction");
    (trace.applications) APPLICATIONS, &[], Dimension::Number, "Applications of the inverse stiffness matrix in the whole solve.".symbol("n_A");
    (trace.solved_by) METHOD, &[], Dimension::Number, "Algorithm that gave the answer: minimisation without friction or with a given slip bound, direct without contact; after a failed Newton solve it is fixed_point and both histories are there.";
    (trace.strategy) "/solve/strategy", &[], Dimension::Number, "Start strategy of Newton's method that led to the solution, or came nearest to one.".optional("absent without a dense dual operator, and with the fixed-point method");
    (accuracy) ACCURACY, &[], Dimension::Number, "Relative error of the multipliers, measured by one more solution from them with exact residuals; the last relative change of successive approximations that did not end.".finite();
    (friction?.mapping_change) "/solve/mapping_change", &[], Dimension::Number, "|Psi(lambda) - lambda| / |lambda| for one evaluation of the paper's mapping.".optional("absent unless Newton's method gave the answer");
    [|solution| mapping(solution).spectral_radius, |solution, value| mapping_mut(solution).spectral_radius = value] "/solve/spectral_radius", &[], Dimension::Number, "Spectral radius of the derivative of the mapping Psi at the solution: successive approximations converge to it from nearby where it is below 1.".symbol("rho(Psi')").when(NO_LINEARISATION).finite();
    [|solution| mapping(solution).determinant_sign, |solution, sign| mapping_mut(solution).determinant_sign = sign] "/solve/determinant_sign", &[], Dimension::Number, "Sign of the determinant of Newton's matrix at the solution; the signs of all solutions add up to 1, so where it is -1 there are others.".symbol("sign det R'").when(NO_LINEARISATION);
    [|solution| mapping(solution).fold_distance, |solution, value| mapping_mut(solution).fold_distance = value] "/solve/fold_distance", &[], Dimension::Number, "Least |1 - mu| over the eigenvalues mu of the derivative of Psi at the solution: 0 where Newton's matrix is singular, as in a fold where two solutions meet.".symbol("min |1 - mu|").when(NO_LINEARISATION).finite();
    (trace.law_evaluations) "/solve/law_evaluations", &[], Dimension::Number, "Evaluations of the friction law at a node.";
    {Kind::Text} HISTORY_DIGEST, &[], Dimension::Number, "Digest of /history, whose last increment this is.".optional("absent without a load history");
};

/// How far an unfinished solve has come.
pub const CHECKPOINT: Group = Group::new("checkpoint", Stage::Solve.command());

const NEWTON: &[Extent] = &[Named("n_newton_steps")];
const OUTER: &[Extent] = &[Named("n_outer_steps")];
const DONE: &[Extent] = &[Named("n_done_steps")];

/// Successive approximations, in a place of a group.
macro_rules! outer_steps {
    ($group:expr, $place:literal, $steps:expr) => {
        fields! { OuterStep => $group;
            (change) concat!($place, "/change"), $steps, Dimension::Number, "Relative change of the multipliers in each outer step.".symbol("err");
            (inner_tolerance) concat!($place, "/inner_tolerance"), $steps, Dimension::Number, "Tolerance of each inner problem, relative to the norm of h.".symbol("epsilon_lambda");
            (inner_residual) concat!($place, "/inner_residual"), $steps, Dimension::Number, "Norm of the reduced gradient at the end of each inner problem, relative to the norm of h.";
            (steps.conjugate_gradient) concat!($place, "/conjugate_gradient_steps"), $steps, Dimension::Number, "Conjugate gradient steps.";
            (steps.expansion) concat!($place, "/expansion_steps"), $steps, Dimension::Number, "Expansion steps.";
            (steps.proportioning) concat!($place, "/proportioning_steps"), $steps, Dimension::Number, "Proportioning steps.";
            (applications) concat!($place, "/applications"), $steps, Dimension::Number, "Applications of the inverse stiffness matrix; the first step includes those that estimate the norm of S.";
            (seconds) concat!($place, "/seconds"), $steps, Dimension::Time, "Wall-clock time of each outer step.".volatile();
        }
    };
}

pub(super) const OUTER_STEPS: Fields<OuterStep> = outer_steps!(GROUP, "/solve/history", OUTER);
pub(super) const DONE_STEPS: Fields<OuterStep> =
    outer_steps!(CHECKPOINT, "/checkpoint/history", DONE);

pub(super) const NEWTON_STEPS: Fields<NewtonStep> = fields! { NewtonStep => GROUP;
    (residual) "/solve/newton/residual", NEWTON, Dimension::Number, "|R| / |lambda| after each Newton step.";
    (step_length) "/solve/newton/step_length", NEWTON, Dimension::Number, "Share of the Newton step taken.";
    (halvings) "/solve/newton/halvings", NEWTON, Dimension::Number, "Halvings of the step tried.";
    (zone_changes) "/solve/newton/zone_changes", NEWTON, Dimension::Number, "Panes that changed between open, stick and slip.";
    (free_unknowns) "/solve/newton/free_unknowns", NEWTON, Dimension::Number, "Unknowns of the dense linear system.";
    (safeguard) "/solve/newton/safeguard", NEWTON, Dimension::Number, "1 where a safeguard replaced Newton's step.";
    (seconds) "/solve/newton/seconds", NEWTON, Dimension::Time, "Wall-clock time of each Newton step.".volatile();
};

pub(super) const STATE: Fields<OuterState> = fields! { OuterState => CHECKPOINT;
    (multiplier) "/checkpoint/multiplier", &[Named("n_multipliers")], Dimension::STRESS, "Multipliers after the last step done: the normal ones, then the tangential pairs.".symbol("lambda").finite();
    (slip) "/checkpoint/slip", &[Named("n_contact_nodes"), extents::FRICTION_AXES], Dimension::LENGTH, "Absolute tangential displacements of the contact nodes.".symbol("phi").optional("absent unless friction follows the slip").finite();
    (tolerance) "/checkpoint/inner_tolerance", &[], Dimension::Number, "Tolerance of the last inner problem.".finite();
    (steplength) "/checkpoint/steplength", &[], Dimension::PER_DUAL, "Steplength of projected gradient steps.".symbol("alpha").finite();
    (law_evaluations) "/checkpoint/law_evaluations", &[], Dimension::Number, "Evaluations of the friction law so far.";
};

/// The rows of `DONE_STEPS`, whose meaning is that of `OUTER_STEPS`.
pub(super) const DONE_ROWS: &[DatasetSpec] = &{
    let mut rows = rows::<_, { DONE_STEPS.rows.len() }>(DONE_STEPS.fields);
    let mut k = 0;
    while k < rows.len() {
        rows[k].description = "As in /solve/history.";
        rows[k].symbol = "";
        k += 1;
    }
    rows
};

fn mapping(solution: &Solution) -> LocalMapping {
    let friction = solution.friction.as_ref();
    friction.and_then(|it| it.local_mapping).unwrap_or_default()
}

fn mapping_mut(solution: &mut Solution) -> &mut LocalMapping {
    let friction = solution.friction.get_or_insert_default();
    friction.local_mapping.get_or_insert_default()
}

/// Writes the solution; that of a load history belongs to a `/history` with some digest.
pub fn write(
    writer: &mut GroupWriter<'_>,
    solution: &Solution,
    n_panes: usize,
    dofs: &DofMap,
    history_digest: Option<&str>,
) -> Result<(), StoreError> {
    if let Some(digest) = history_digest {
        writer.write_text(HISTORY_DIGEST, digest)?;
    }
    let multiplier = [MULTIPLIER_NORMAL, MULTIPLIER_TANGENTIAL];
    write_of_panes(writer, multiplier, &solution.multiplier, n_panes)?;
    let stiffness = [LOCAL_STIFFNESS_NORMAL, LOCAL_STIFFNESS_TANGENTIAL];
    write_of_panes(writer, stiffness, &solution.trace.local_stiffness, n_panes)?;
    write_value(writer, DISPLACEMENT, &dofs.to_nodes(&solution.displacement))?;
    let tools = dofs.tool_rows(&solution.displacement);
    if !tools.is_empty() {
        write_value(writer, TOOL_ROWS, &tools)?;
    }
    FIELDS.write_one(writer, solution)?;
    NEWTON_STEPS.write_rows(writer, &solution.trace.newton)?;
    OUTER_STEPS.write_rows(writer, &solution.trace.history)
}

/// Writes one number for each pane, then a pair for each pane with friction; nothing where there are none.
fn write_of_panes(
    writer: &mut GroupWriter<'_>,
    [normal, tangential]: [&str; 2],
    values: &[f64],
    n_panes: usize,
) -> Result<(), StoreError> {
    if values.is_empty() || n_panes == 0 {
        return Ok(());
    }
    let (of_panes, pairs) = values.split_at(n_panes);
    writer.write(normal, of_panes, &[n_panes])?;
    if pairs.is_empty() {
        return Ok(());
    }
    writer.write(tangential, pairs, &[pairs.len() / 2, 2])
}

/// Reads the solution.
pub fn read(reader: &Reader, dofs: &DofMap) -> Result<Solution, FormatError> {
    let (status, multiplier) = read_multiplier(reader)?;
    // Finite numbers, unless the solve ended for want of them.
    let is_finite = status != Status::NumericalError;
    let mut rows: Vec<[f64; 3]> = read_as(reader, DISPLACEMENT, is_finite)?;
    if reader.has(TOOL_ROWS) {
        rows.extend(read_as::<Vec<[f64; 3]>>(reader, TOOL_ROWS, is_finite)?);
    }
    let mut local_stiffness = Vec::new();
    for path in [LOCAL_STIFFNESS_NORMAL, LOCAL_STIFFNESS_TANGENTIAL] {
        if reader.has(path) {
            local_stiffness.extend(reader.read_finite_f64(path)?);
        }
    }
    let mut solution = Solution {
        status,
        accuracy: f64::NAN,
        multiplier,
        displacement: dofs.to_free(&rows),
        rigid: Some(RigidMotions::default()),
        friction: Some(FrictionState::default()),
        trace: Trace {
            local_stiffness,
            history: OUTER_STEPS.read_rows(reader, OuterStep::default)?,
            newton: NEWTON_STEPS.read_rows(reader, NewtonStep::default)?,
            ..Trace::default()
        },
    };
    FIELDS.read_one(reader, &mut solution, is_finite)?;
    Ok(solution)
}

/// Reads the multipliers alone, and how the solve ended.
pub fn read_multiplier(reader: &Reader) -> Result<(Status, Vec<f64>), FormatError> {
    let status = read_value(reader, STATUS)?;
    let is_finite = status != Status::NumericalError;
    let mut multiplier = Vec::new();
    if reader.has(MULTIPLIER_NORMAL) {
        multiplier = read_as(reader, MULTIPLIER_NORMAL, is_finite)?;
    }
    if reader.has(MULTIPLIER_TANGENTIAL) {
        let pairs: Vec<[f64; 2]> = read_as(reader, MULTIPLIER_TANGENTIAL, is_finite)?;
        multiplier.extend(pairs.as_flattened());
    }
    Ok((status, multiplier))
}

/// How a solve ended, in words and numbers.
#[derive(Debug)]
pub struct OutcomeWords {
    /// How it ended.
    pub status: Status,
    /// Which algorithm gave the answer.
    pub method: &'static str,
    /// Outer steps, Newton steps, applications.
    pub counts: [usize; 3],
    /// Relative error of the multipliers.
    pub accuracy: f64,
    /// Increments of a load history that were solved, the last one well or not; 0 without a history.
    pub increments: usize,
}

/// Reads how a solve ended, without its fields.
pub fn read_outcome(reader: &Reader) -> Result<OutcomeWords, FormatError> {
    let [outer, newton] = step_counts(reader)?;
    Ok(OutcomeWords {
        status: read_value(reader, STATUS)?,
        method: read_value::<SolvedBy>(reader, METHOD)?.word(),
        counts: [outer, newton, read_value(reader, APPLICATIONS)?],
        accuracy: read_value(reader, ACCURACY)?,
        increments: increments::n_increments(reader)?,
    })
}

/// Numbers of steps of successive approximations and of Newton's method, by a column of each.
fn step_counts(reader: &Reader) -> Result<[usize; 2], FormatError> {
    let [outer, newton] = [OUTER_STEPS.rows, NEWTON_STEPS.rows].map(|rows| rows[0].path);
    let counts = [
        length::<f64>(reader, outer)?,
        length::<f64>(reader, newton)?,
    ];
    Ok(counts.map(Option::unwrap_or_default))
}

/// Writes the state between two steps.
pub fn write_checkpoint(
    writer: &mut GroupWriter<'_>,
    state: &OuterState,
) -> Result<(), StoreError> {
    STATE.write_one(writer, state)?;
    DONE_STEPS.write_rows(writer, &state.history)
}

/// Reads the state between two steps.
pub fn read_checkpoint(reader: &Reader) -> Result<OuterState, FormatError> {
    let mut state = OuterState {
        history: DONE_STEPS.read_rows(reader, OuterStep::default)?,
        ..OuterState::default()
    };
    STATE.read_one(reader, &mut state, true)?;
    Ok(state)
}
