//! Files for other programs: frictional contact problems in those of FCLIB, grids for ParaView.
//!
//! `frozen` makes a problem of a solution, `fclib` knows the layout of its file. Files are put together beside their places before the output
//! guard lets them in.

mod fclib;
mod frozen;

use std::{ffi::OsStr, fs, path::Path};

use contact3d::{
    AssembledProblem, contact::MultiplierLayout, dual::Requirement, linalg::Precision,
    mesh::ContactSurface, scene::InvalidValue, solver,
};
use hdf5_metno::File;
use runfile::{AtomicFile, IfMissing, RunFile, StoreError, Transaction, WrittenFile};

use crate::{
    format::{SERIES_LAYOUT, Stage, VTKHDF},
    output::{self, FCLIB_TYPE, Inputs, OutputError, OutputFile, OutputKind},
    pipeline::{OpenRun, StageError, admit_memory, read_solved},
};

use fclib::FclibSolution;
use frozen::{Equations, FrozenProblem, SPACE_DIMENSION};

/// Lets a file of FCLIB into its place; returns its bytes.
fn put(written: &WrittenFile, target: &Path, inputs: &Inputs) -> Result<usize, OutputError> {
    let bytes = fs::read(written.path()).map_err(|source| OutputError::Io {
        file: target.to_owned(),
        action: "read the file just made",
        source,
    })?;
    let file = OutputFile {
        path: target.to_owned(),
        kind: OutputKind::Fclib,
        bytes,
    };
    output::write(std::slice::from_ref(&file), inputs)?;
    Ok(file.bytes.len())
}

/// Copies `/VTKHDF` of a run file; returns the bytes of the file.
///
/// # Errors
/// A run file whose report is not fresh, a target that is an input, no file of this kind, or has an ending that readers do not know.
pub fn export_grid(run_file: &Path, target: &Path) -> Result<u64, StageError> {
    Inputs::of([run_file]).refuse(target)?;
    if target.extension() != Some(OsStr::new("vtkhdf")) {
        return Err(StageError::Setting(InvalidValue {
            key: "TARGET".into(),
            expected: "a name that ends in .vtkhdf, by which ParaView and PyVista know the format"
                .into(),
            found: target.display().to_string(),
            help: format!("write {}", target.with_extension("vtkhdf").display()),
        }));
    }
    let run = OpenRun::open(run_file)?;
    run.require_fresh(Stage::Post, "finished")?;
    let layout = SERIES_LAYOUT.in_units(run.input.scene.units);
    let file = RunFile::lock(target, layout, IfMissing::Create)?;
    let mut transaction = Transaction::begin(&file)?;
    transaction.copy(&run.reader, VTKHDF)?;
    transaction.commit()?;
    let written = fs::metadata(target).map_err(|source| StageError::Write {
        file: target.to_owned(),
        source,
    })?;
    Ok(written.len())
}

/// Bytes for each entry of W: S, W by columns with long indices, W as the file has it, the file in memory.
const BYTES_PER_ENTRY_OF_W: u64 = 8 + 2 * 16 + 2 * 12;

/// What was written.
#[derive(Debug, Clone, PartialEq)]
pub struct Exported {
    /// Number of contacts.
    pub contacts: usize,
    /// Rows of M; `None` for a local problem.
    pub unknowns: Option<usize>,
    /// Smallest and largest μ.
    pub mu: [f64; 2],
    /// The error of the stored forces as Siconos measures it; `None` for a global problem.
    pub error: Option<f64>,
    /// Bytes of the file.
    pub bytes: usize,
}

/// Writes the problem of a solved run file with its friction frozen at the solution: u = W r + q with the dense W or, global,
/// M v = H r + f, u = Hᵀv + w with sparse matrices.
///
/// # Errors
/// A run file that is not solved, a law that such files cannot hold, too little memory, an output that the guard refuses.
pub fn export(run_file: &Path, target: &Path, global: bool) -> Result<Exported, StageError> {
    let inputs = Inputs::of([run_file]);
    output::admit(target, OutputKind::Fclib, &inputs)?;
    let (problem, solution) = read_solved(run_file)?;
    let unfit = |reason: String| StageError::Unfit {
        file: run_file.to_owned(),
        reason,
    };
    let contact = problem.contact_side().ok_or_else(|| {
        unfit("the scene has no contact, so there is no frictional contact problem to write".into())
    })?;
    let friction = frozen_friction(&problem, &solution, contact.surface).map_err(unfit)?;
    let n_contacts = contact.surface.n_panes();
    if !global {
        admit_memory(Requirement {
            step: "writing W, which is dense; --kind fclib-global writes sparse matrices",
            memory: ((SPACE_DIMENSION * n_contacts) as u64)
                .saturating_pow(2)
                .saturating_mul(BYTES_PER_ENTRY_OF_W),
            ..Requirement::default()
        })?;
    }
    let freeze = match global {
        false => FrozenProblem::local,
        true => FrozenProblem::global,
    };
    let frozen = freeze(&problem, contact.surface, contact.interface, &friction);
    let entries = fclib::most_entries(&frozen);
    if i32::try_from(entries).is_err() {
        return Err(unfit(format!(
            "a matrix of {entries} entries does not fit the 32-bit indices of FCLIB files; take a coarser mesh"
        )));
    }
    let layout = MultiplierLayout::new(n_contacts, contact.interface.n_friction_panes());
    let forces = frozen.scaling.forces(layout, &solution.multiplier);
    let answer = frozen.solution(forces, &solution.displacement);
    let nothing = vec![0.0; SPACE_DIMENSION * n_contacts];
    let start = frozen.solution(nothing, &vec![0.0; solution.displacement.len()]);
    let written = write(&problem, &frozen, &friction, [&answer, &start], target)?;
    Ok(Exported {
        contacts: n_contacts,
        unknowns: answer.v.as_ref().map(Vec::len),
        mu: ends(&frozen.scaling.mu),
        error: frozen.error(&answer),
        bytes: put(&written, target, &inputs)?,
    })
}

/// (F₁, F₂) that act on each pane at the solution, `None` without friction; refused where Coulomb's law with fixed coefficients is
/// not the law.
fn frozen_friction(
    problem: &AssembledProblem,
    solution: &solver::Solution,
    surface: &ContactSurface,
) -> Result<Vec<Option<[f64; 2]>>, String> {
    if !solution.status.is_solved() {
        return Err(format!(
            "the solve ended as {}, and its friction can only be frozen at a solution; solve it by another method or with a looser epsilon, or change the scene",
            solution.status.word()
        ));
    }
    if problem.system.assembly.factor.precision() == Precision::Single {
        return Err("the factor is in single precision, and so W would be; \
                    run `contact3d-pipe assemble FILE --set assemble.factor=\"double\"`, and `solve` again"
            .into());
    }
    if !problem.scene().tools.is_empty() {
        return Err("the scene has tools, whose motions files of FCLIB do not hold; leave contact.tool out, and move the clamps instead".into());
    }
    if let Some(body) = &problem.system.assembly.primal.rigid_modes {
        let (holds, why) = match body.support {
            None => (
                "only contact holds the body, so its stiffness is singular, there is no W",
                "clamp the body, or put it on springs",
            ),
            Some(_) => (
                "only contact and weak springs hold the body, W would have no digits of its own compliance",
                "clamp the body, or put it on stiffer springs",
            ),
        };
        return Err(format!(
            "{holds}, and FCLIB wants a positive definite M; {why}"
        ));
    }
    if !problem.scene().steps.is_empty() {
        return Err("the scene is a load history, and files of FCLIB hold one problem; write its last step as a scene of its own".into());
    }
    for face in problem.scene().contact_features() {
        let Some(law) = face.friction.filter(|law| !law.bound.is_pressure()) else {
            continue;
        };
        return Err(format!(
            "the contact face {} has {}, and files of FCLIB hold Coulomb's law alone, a bound of mu times the normal force; \
             take friction.coefficient without slip_bound or pressure_cap",
            face.name,
            law.bound.words().bound
        ));
    }
    let state = solution.friction.as_ref().map(|it| &it.coulomb);
    let panes = 0..surface.n_panes();
    let coefficients = panes.map(|pane| {
        let friction = &state?.friction;
        (pane < friction.pane_inverse.len()).then(|| friction.pane(pane))
    });
    Ok(coefficients.collect())
}

/// Writes a problem with its solution, a guess, and what leads back to stresses and displacements.
fn write(
    problem: &AssembledProblem,
    frozen: &FrozenProblem,
    friction: &[Option<[f64; 2]>],
    [solution, start]: [&FclibSolution; 2],
    target: &Path,
) -> Result<WrittenFile, StageError> {
    let units = problem.scene().units;
    let description = format!(
        "An elastic body on its foundation, written by contact3d-pipe {}. Orthotropic friction with coefficients that follow the \
         solution is frozen at the solution. The group contact3d holds what r and u are scaled by, and areas of panes, in {} and {}.",
        env!("CARGO_PKG_VERSION"),
        units.length(),
        units.force(),
    );
    let info = [
        ("title", problem.scene().title.as_str()),
        ("description", &description),
        (
            "math_info",
            "W is symmetric and positive definite up to rounding; solution is that of the program, guess 1 is zero",
        ),
    ];
    let n_free = problem.system.assembly.primal.dofs.n_free;
    let all = |file: &File| {
        fclib::write_problem(file, frozen, info, n_free)?;
        fclib::write_solutions(file, solution, start)?;
        write_scaling(file, frozen, friction)
    };
    let written = AtomicFile::filled(target, FCLIB_TYPE, |file| {
        all(file).map_err(|source| StoreError::Hdf5 {
            file: target.to_owned(),
            dataset: "/".into(),
            action: "write the problem",
            source: Box::new(source),
        })
    });
    Ok(written?)
}

/// What leads back from the file to stresses and displacements.
fn write_scaling(
    file: &File,
    frozen: &FrozenProblem,
    friction: &[Option<[f64; 2]>],
) -> hdf5_metno::Result<()> {
    let scaling = &frozen.scaling;
    let friction = friction.iter().flat_map(|f| f.unwrap_or([0.0; 2]));
    let friction: Vec<f64> = friction.collect();
    let group = &fclib::new_group(file, "contact3d")?;
    fclib::write_array(
        group,
        "scale",
        "D: contact forces are unit * scale * r, relative displacements unit * u / scale",
        &scaling.scale,
        SPACE_DIMENSION,
    )?;
    fclib::write_array(
        group,
        "unit",
        "t: one number that all of q, r and u are divided by",
        &[scaling.unit],
        1,
    )?;
    fclib::write_array(
        group,
        "pane_area",
        "a: contact stresses are contact forces over these areas",
        &scaling.area,
        1,
    )?;
    fclib::write_array(
        group,
        "friction",
        "F1 and F2 on each pane at the solution; 0 without friction",
        &friction,
        2,
    )?;
    match &frozen.equations {
        Equations::Local { .. } => Ok(()),
        Equations::Global {
            displacement_scale, ..
        } => fclib::write_array(
            group,
            "displacement_scale",
            "c: displacements are displacement_scale * unit * v",
            &[*displacement_scale],
            1,
        ),
    }
}

fn ends(mu: &[f64]) -> [f64; 2] {
    let least = mu.iter().copied().fold(f64::INFINITY, f64::min);
    let most = mu.iter().copied().fold(0.0, f64::max);
    [least, most]
}
