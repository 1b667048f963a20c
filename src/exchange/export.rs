//! A solved run file as a problem of FCLIB, with its solution.

use std::path::Path;

use contact3d::{
    AssembledProblem,
    contact::{Interface, MultiplierLayout},
    dual::{ExplicitDual, Need},
    linalg::{CscMatrix, Precision},
    mesh::ContactSurface,
    scene::ModelFeatures,
    solver::{self, FrozenGlobal, FrozenScaling, frozen_global, frozen_local},
};
use fclib::{Array, FclibError, FclibSolution, GlobalProblem, Info, LocalProblem, Matrix};
use hdf5_metno::File;
use runfile::{WholeFile, WrittenFile};

use super::{PROGRAM, put};
use crate::{
    output::{self, Inputs, OutputKind},
    pipeline::{StageError, admit_memory, read_solved},
};

/// Bytes for each entry of W: S, W by columns with long indices, W as the file has it, the file in memory.
const BYTES_PER_ENTRY: u64 = 8 + 2 * 16 + 2 * 12;

/// Which of the two problems is written.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum FclibForm {
    /// u = W r + q, with the dense W.
    Local,
    /// M v = H r + f, u = Hᵀv + w, with sparse matrices.
    Global,
}

/// What was written.
#[derive(Debug, Clone, PartialEq)]
pub struct Exported {
    /// Number of contacts.
    pub contacts: usize,
    /// Rows of M; `None` for a local problem.
    pub unknowns: Option<usize>,
    /// Smallest and largest μ.
    pub mu: [f64; 2],
    /// [`DelassusProblem::error`](contact3d::solver::DelassusProblem::error) of the stored forces; `None` for a global problem.
    pub error: Option<f64>,
    /// Bytes of the file.
    pub bytes: usize,
}

/// Writes the problem of a solved run file with its friction frozen at the solution.
///
/// # Errors
/// A run file that is not solved, a law that such files cannot hold, too little memory, an output that the guard refuses.
pub fn export(run_file: &Path, target: &Path, form: FclibForm) -> Result<Exported, StageError> {
    let inputs = Inputs::of([run_file]);
    output::admit(target, OutputKind::Fclib, &inputs)?;
    let (problem, solution) = read_solved(run_file)?;
    let unfit = |reason: String| StageError::Unfit {
        file: run_file.to_owned(),
        reason,
    };
    let contact = problem.contact_state().ok_or_else(|| {
        unfit("the scene has no contact, so there is no frictional contact problem to write".into())
    })?;
    let friction = frozen_friction(&problem, &solution, contact.surface).map_err(unfit)?;
    let face = ExportedFace {
        problem: &problem,
        solution: &solution,
        surface: contact.surface,
        interface: contact.interface,
        friction: &friction,
    };
    let (mut exported, written) = match form {
        FclibForm::Local => face.write_local(run_file, target)?,
        FclibForm::Global => face.write_global(target)?,
    };
    exported.bytes = put(&written, target, &inputs)?;
    Ok(exported)
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
    if problem.system().assembly.factor.precision() == Precision::Single {
        return Err("the factor is in single precision, and so W would be; \
                    run `contact3d-pipe assemble FILE --factor double`, and `solve` again"
            .into());
    }
    if let Some(body) = &problem.system().assembly.primal.floating {
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
    for face in ModelFeatures::of(problem.scene()).contact {
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
    let state = solution.coulomb.as_ref();
    let panes = 0..surface.n_panes();
    let coefficients = panes.map(|pane| {
        let friction = &state?.friction;
        (pane < friction.pane_inverse.len()).then(|| friction.pane(pane))
    });
    Ok(coefficients.collect())
}

/// A contact face with frozen friction.
struct ExportedFace<'a> {
    problem: &'a AssembledProblem,
    solution: &'a solver::Solution,
    surface: &'a ContactSurface,
    interface: &'a Interface,
    friction: &'a [Option<[f64; 2]>],
}

impl ExportedFace<'_> {
    fn write_local(
        &self,
        run_file: &Path,
        target: &Path,
    ) -> Result<(Exported, WrittenFile), StageError> {
        let size = 3 * self.surface.n_panes();
        let memory = (size as u64)
            .saturating_pow(2)
            .saturating_mul(BYTES_PER_ENTRY);
        admit_memory(Need {
            step: "writing W, which is dense; --global writes sparse matrices",
            memory,
            stored: 0,
        })?;
        let (problem, scaling) = {
            let dual = self.dense();
            let frozen = frozen_local(&dual, &self.surface.pane_area, self.friction);
            frozen.map_err(|source| StageError::Delassus {
                file: run_file.to_owned(),
                source,
            })?
        };
        let force = scaling.forces(self.layout(), &self.solution.multiplier);
        let solution = FclibSolution {
            v: None,
            u: problem.velocity(&force),
            r: force,
        };
        let start = FclibSolution {
            v: None,
            u: problem.offset().to_vec(),
            r: vec![0.0; size],
        };
        let exported = Exported {
            contacts: self.surface.n_panes(),
            unknowns: None,
            mu: ends(&scaling.mu),
            error: Some(problem.error(&solution.r)),
            bytes: 0,
        };
        let local = LocalProblem {
            space_dimension: 3,
            q: problem.offset().to_vec(),
            mu: scaling.mu.clone(),
            info: self.info(),
            w: to_file(problem.into_matrix()),
        };
        let write = |file: &File| fclib::write_local(file, &local);
        let written = self.write_with(target, write, &[solution, start], &scaling, None)?;
        Ok((exported, written))
    }

    fn write_global(&self, target: &Path) -> Result<(Exported, WrittenFile), StageError> {
        let primal = &self.problem.system().assembly.primal;
        let frozen = frozen_global(primal, self.surface, self.interface, self.friction);
        let scaling = &frozen.scaling;
        let v = frozen.displacement(&self.solution.displacement);
        let solution = FclibSolution {
            u: frozen.velocity(&v),
            v: Some(v),
            r: scaling.forces(self.layout(), &self.solution.multiplier),
        };
        let zero = vec![0.0; frozen.load.len()];
        let start = FclibSolution {
            u: frozen.velocity(&zero),
            v: Some(zero),
            r: vec![0.0; scaling.scale.len()],
        };
        let exported = Exported {
            contacts: self.surface.n_panes(),
            unknowns: Some(frozen.load.len()),
            mu: ends(&scaling.mu),
            error: None,
            bytes: 0,
        };
        let FrozenGlobal {
            matrix,
            contact,
            load,
            distance,
            displacement_scale,
            scaling,
        } = frozen;
        let global = GlobalProblem {
            space_dimension: 3,
            m: to_file(matrix),
            h: to_file(contact),
            f: load,
            w: distance,
            mu: scaling.mu.clone(),
            info: self.info(),
        };
        let write = |file: &File| fclib::write_global(file, &global);
        let (answers, scale) = ([solution, start], Some(displacement_scale));
        let written = self.write_with(target, write, &answers, &scaling, scale)?;
        Ok((exported, written))
    }

    /// Writes a problem with its solution, a guess, and what leads back to stresses and displacements.
    fn write_with(
        &self,
        target: &Path,
        write_problem: impl Fn(&File) -> Result<(), FclibError>,
        [solution, start]: &[FclibSolution; 2],
        scaling: &FrozenScaling,
        displacement: Option<f64>,
    ) -> Result<WrittenFile, StageError> {
        let written = WholeFile::filled(target, None, |file| {
            write_problem(file)?;
            fclib::write_solution(file, solution)?;
            fclib::write_guesses(file, std::slice::from_ref(start))?;
            self.write_scaling(file, scaling, displacement)?;
            fclib::write_program(file, PROGRAM)
        });
        Ok(written?)
    }

    /// S with tangential pairs on all panes: that of the file where it has them.
    fn dense(&self) -> ExplicitDual {
        let system = self.problem.system();
        let held = system
            .contact
            .as_ref()
            .and_then(|contact| contact.explicit());
        match held {
            Some(dual) if dual.layout.n_pairs() == dual.n_panes() => dual.clone(),
            _ => ExplicitDual::everywhere(&system.assembly, self.surface, self.interface),
        }
    }

    /// The order of the multipliers of the solution.
    fn layout(&self) -> MultiplierLayout {
        let panes = self.surface.n_panes();
        MultiplierLayout::new(panes, self.interface.n_friction_panes())
    }

    fn info(&self) -> Info {
        let units = self.problem.scene().units;
        Info {
            title: Some(self.problem.scene().title.clone()),
            description: Some(format!(
                "An elastic body on its foundation, written by contact3d-pipe {}. Orthotropic friction with coefficients that follow the \
                 solution is frozen at the solution. The group contact3d holds what r and u are scaled by, and areas of panes, in \
                 {} and {}.",
                env!("CARGO_PKG_VERSION"),
                units.length(),
                units.force(),
            )),
            math_info: Some(
                "W is symmetric and positive definite up to rounding; solution is that of the program, guess 1 is zero".into(),
            ),
            degrees_of_freedom: Some(self.problem.system().assembly.primal.dofs.n_free),
        }
    }

    /// What leads back from the file to stresses and displacements.
    fn write_scaling(
        &self,
        file: &File,
        scaling: &FrozenScaling,
        displacement: Option<f64>,
    ) -> Result<(), FclibError> {
        let friction: Vec<f64> = self
            .friction
            .iter()
            .flat_map(|f| f.unwrap_or([0.0; 2]))
            .collect();
        let unit = [scaling.unit];
        let displacement = displacement.map(|c| [c]);
        let array = |name, meaning, values, columns| Array {
            name,
            meaning,
            values,
            columns,
        };
        let mut arrays = vec![
            array(
                "scale",
                "D: contact forces are unit * scale * r, relative displacements unit * u / scale",
                &scaling.scale,
                3,
            ),
            array(
                "unit",
                "t: one number that all of q, r and u are divided by",
                &unit[..],
                1,
            ),
            array(
                "pane_area",
                "a: contact stresses are contact forces over these areas",
                &scaling.area,
                1,
            ),
            array(
                "friction",
                "F1 and F2 on each pane at the solution; 0 without friction",
                &friction,
                2,
            ),
        ];
        if let Some(c) = &displacement {
            arrays.push(array(
                "displacement_scale",
                "c: displacements are displacement_scale * unit * v",
                c,
                1,
            ));
        }
        fclib::write_arrays(file, "contact3d", &arrays)
    }
}

fn to_file(matrix: CscMatrix) -> Matrix {
    Matrix {
        rows: matrix.rows,
        columns: matrix.cols,
        starts: matrix.indptr,
        indices: matrix.indices,
        values: matrix.data,
    }
}

fn ends(mu: &[f64]) -> [f64; 2] {
    let least = mu.iter().copied().fold(f64::INFINITY, f64::min);
    let most = mu.iter().copied().fold(0.0, f64::max);
    [least, most]
}
