//! The stages side by side: what each depends on in the scene, how it runs, what it writes.

use std::{cell::RefCell, sync::Arc};

use contact3d::{
    dual::{DualSystem, Need},
    linalg::Work,
    scene::{Increment, Scene},
    solver::Progress,
};
use runfile::{GroupRecord, Home, StoreError, Transaction};
use serde::Serialize;

use super::{
    AssemblyFile, Session, StageError, assemble, history,
    homes::KEEP_BESIDE_ABOVE,
    load,
    mesh::{self, Meshed},
    post::{self, Evaluated},
    resources,
    solve::{self, Answer},
    store::{Checkpoints, write_group},
};
use crate::format::{self, HISTORY, Stage, VTKHDF};

/// What a stage at work is doing.
#[derive(Debug, Clone, Copy)]
pub enum Step<'a> {
    /// The name of a long step of `assemble` that begins.
    Assembling(&'static str),
    /// How far that step is, to be read while it is at work.
    Counting(&'static str, &'a Arc<Work>),
    /// A step of the solver.
    Solving(Progress<'a>),
    /// A step of the solver in an increment of a load history.
    Stepping(Increment, Progress<'a>),
}

/// What a stage computed, with all that it takes to write it.
#[derive(Debug)]
pub(super) enum Output {
    Mesh(Arc<Meshed>),
    Assemble(Arc<DualSystem>),
    Load(Arc<DualSystem>),
    Solve(Arc<Meshed>, Arc<Evaluated>),
    Post(Arc<Meshed>, Arc<Evaluated>),
}

/// What stages depend on beside the scene, by digests.
#[derive(Debug, Clone, Copy, Default)]
pub(super) struct Chosen<'a> {
    /// Of the cuts that lead from the first mesh to this one; `None` for the first.
    pub(super) refinement: Option<&'a str>,
    /// Of the multipliers that a solve starts from; `None` for λ = 0.
    pub(super) start: Option<&'a str>,
}

/// The part of a scene that a stage depends on directly, as TOML.
pub(super) fn settings(stage: Stage, scene: &Scene, chosen: Chosen<'_>) -> String {
    let Chosen { refinement, start } = chosen;
    let text = match stage {
        Stage::Mesh => toml(&mesh::Settings::of(scene, refinement)),
        Stage::Assemble => toml(&assemble::Settings::of(scene)),
        Stage::Load => toml(&load::Settings::of(scene)),
        Stage::Solve => toml(&solve::Settings::of(scene, start)),
        Stage::Post => toml(&post::Settings::of(scene)),
    };
    text + &units_settings(scene)
}

fn toml(settings: &impl Serialize) -> String {
    toml::to_string(settings).expect("settings hold only TOML types")
}

/// The units as settings of every stage, since attributes speak them; nothing for those of a scene
/// that names none, whose stages keep the digests they had before units could be named.
fn units_settings(scene: &Scene) -> String {
    if scene.units.is_default() {
        return String::new();
    }
    format!("\n[units]\n{}", toml(&scene.units))
}

impl Session {
    /// Computes a stage from those before it, which are fresh.
    pub(super) fn compute(
        &mut self,
        stage: Stage,
        observe: &mut dyn FnMut(Step<'_>),
    ) -> Result<Output, StageError> {
        match stage {
            Stage::Mesh => self.make_mesh(),
            Stage::Assemble => self.assemble(observe),
            Stage::Load => self.apply_loads(),
            Stage::Solve => self.solve(observe),
            Stage::Post => self.post(),
        }
    }

    fn make_mesh(&mut self) -> Result<Output, StageError> {
        let meshed = Arc::new(mesh::run(&mesh::Inputs {
            input: &self.task.input,
            refinement: self.task.refinement.cuts(),
            run_file: self.store.path(),
        })?);
        self.known.set_mesh(meshed.clone());
        Ok(Output::Mesh(meshed))
    }

    fn assemble(&mut self, observe: &mut dyn FnMut(Step<'_>)) -> Result<Output, StageError> {
        let source = self.task.source(&self.store);
        let meshed = self.known.meshed(source)?;
        let observe = RefCell::new(observe);
        let system = Arc::new(assemble::run(&assemble::Inputs {
            input: source.input,
            mesh: &meshed.mesh,
            admit: &|need: Need| {
                (observe.borrow_mut())(Step::Assembling(need.step));
                resources::admit(need, source.run_file)
            },
            begun: &|step, work| (observe.borrow_mut())(Step::Counting(step, work)),
        })?);
        // The loads of a history are those of its last increment, which nothing has applied yet.
        if self.scene().has_history() {
            self.known.set_operator(system.clone())
        } else {
            self.known.set_problem(system.clone())
        }
        Ok(Output::Assemble(system))
    }

    fn apply_loads(&mut self) -> Result<Output, StageError> {
        let source = self.task.source(&self.store);
        let meshed = self.known.meshed(source)?;
        self.known.operator(source)?;
        self.store.require_unchanged(&self.task)?;
        let system = self.known.loaded(source, |operator| {
            load::run(load::Inputs {
                input: source.input,
                mesh: &meshed.mesh,
                operator,
            })
        })?;
        Ok(Output::Load(system))
    }

    fn solve(&mut self, observe: &mut dyn FnMut(Step<'_>)) -> Result<Output, StageError> {
        if self.scene().has_history() {
            return self.solve_history(observe);
        }
        let source = self.task.source(&self.store);
        let meshed = self.known.meshed(source)?;
        let problem = self.known.problem(source)?;
        let checkpoint = self.store.read_checkpoint(&self.task)?;
        self.store.require_unchanged(&self.task)?;
        let (task, store) = (&self.task, &mut self.store);
        let mut checkpoints = Checkpoints::new(store.last_store_seconds());
        let inputs = solve::Inputs {
            settings: &task.input.scene.solve,
            meshed: &meshed,
            problem: problem.clone(),
            start: &task.start,
            checkpoint: checkpoint.as_ref(),
        };
        let mut answer = solve::run(inputs, &mut |progress| match progress {
            Progress::Between(state) => {
                checkpoints.keep(|| store.write_checkpoint(task, state));
            }
            Progress::Outer(..) | Progress::Newton(..) => observe(Step::Solving(progress)),
        })?;
        if let Some(double) = self.reconsidered(&meshed, &problem, &answer, observe) {
            self.known.reconsider(double.clone());
            let inputs = solve::Inputs {
                settings: &self.task.input.scene.solve,
                meshed: &meshed,
                problem: double,
                start: &self.task.start,
                checkpoint: None,
            };
            answer = solve::run(inputs, &mut |progress| match progress {
                Progress::Between(_) => {}
                Progress::Outer(..) | Progress::Newton(..) => observe(Step::Solving(progress)),
            })?;
        }
        let evaluated = Arc::new(post::run(post::Inputs {
            input: &task.input,
            meshed: &meshed,
            answer,
        })?);
        self.known.set_evaluated(evaluated.clone());
        Ok(Output::Solve(meshed, evaluated))
    }

    /// The problem in double precision where a solve gave up with a factor in single precision that the program chose.
    fn reconsidered(
        &self,
        meshed: &Meshed,
        problem: &DualSystem,
        answer: &Answer,
        observe: &mut dyn FnMut(Step<'_>),
    ) -> Option<Arc<DualSystem>> {
        let settings = &self.task.input.scene.solve;
        if !answer.solution.status.gave_up(settings) {
            return None;
        }
        let observe = RefCell::new(observe);
        let double = problem.in_double_precision(
            self.scene(),
            &meshed.mesh,
            &|need: Need| {
                (observe.borrow_mut())(Step::Assembling(need.step));
                resources::admit(need, self.store.path())
            },
            &|step, work| (observe.borrow_mut())(Step::Counting(step, work)),
        );
        double.map(Arc::new)
    }

    /// The increments of a load history, stored as they are done where that costs no more than a twentieth of computing them.
    fn solve_history(&mut self, observe: &mut dyn FnMut(Step<'_>)) -> Result<Output, StageError> {
        let source = self.task.source(&self.store);
        let meshed = self.known.meshed(source)?;
        let operator = self.known.operator(source)?;
        let need = history::need_of(source.input, &meshed.mesh);
        resources::admit(need, source.run_file)?;
        let done = self.store.read_history(&self.task)?;
        self.store.require_unchanged(&self.task)?;
        let run_file = self.store.path().to_owned();
        let (task, store) = (&self.task, &mut self.store);
        let cost = store.last_store_seconds().max(history::SECONDS_OF_A_COMMIT);
        let mut checkpoints = Checkpoints::new(cost);
        let inputs = history::Inputs {
            input: &task.input,
            settings: &task.input.scene.solve,
            mesh: &meshed.mesh,
            operator: &operator,
            start: task.start.multiplier(),
            done,
            admit: &|need| resources::admit(need, &run_file),
        };
        let outcome = history::run(
            inputs,
            &mut |increment, progress| match progress {
                Progress::Between(_) => {}
                Progress::Outer(..) | Progress::Newton(..) => {
                    observe(Step::Stepping(increment, progress));
                }
            },
            &mut |records| checkpoints.keep(|| store.write_history(task, records)),
        )?;
        if let Some(double) = outcome.double {
            self.known.reconsider(Arc::new(double));
        }
        let evaluated = Arc::new(outcome.evaluated);
        self.known.set_evaluated(evaluated.clone());
        Ok(Output::Solve(meshed, evaluated))
    }

    /// A solve of this session has evaluated its solution already.
    fn post(&mut self) -> Result<Output, StageError> {
        let source = self.task.source(&self.store);
        let meshed = self.known.meshed(source)?;
        let evaluated = self.known.evaluated(source)?;
        self.store.require_unchanged(&self.task)?;
        Ok(Output::Post(meshed, evaluated))
    }
}

impl Output {
    /// The stage it is of.
    pub(super) fn stage(&self) -> Stage {
        match self {
            Self::Mesh(_) => Stage::Mesh,
            Self::Assemble(_) => Stage::Assemble,
            Self::Load(_) => Stage::Load,
            Self::Solve(..) => Stage::Solve,
            Self::Post(..) => Stage::Post,
        }
    }

    /// Whether no stage follows that it could be stored with.
    pub(super) fn is_last(&self) -> bool {
        match self {
            Self::Mesh(_) | Self::Assemble(_) | Self::Load(_) | Self::Solve(..) => false,
            Self::Post(..) => true,
        }
    }

    /// Where its groups are kept.
    pub(super) fn home(&self, assembly_file: AssemblyFile) -> Home {
        match (self, assembly_file) {
            (Self::Assemble(system), AssemblyFile::BySize)
                if format::assembly_bytes(system) > KEEP_BESIDE_ABOVE =>
            {
                Home::Beside
            }
            (Self::Assemble(_), AssemblyFile::Beside) => Home::Beside,
            (Self::Mesh(_) | Self::Assemble(_), AssemblyFile::Shared) => Home::Shared,
            (
                Self::Mesh(_) | Self::Assemble(_),
                AssemblyFile::BySize | AssemblyFile::SelfContained | AssemblyFile::Beside,
            )
            | (Self::Load(_) | Self::Solve(..) | Self::Post(..), _) => Home::RunFile,
        }
    }

    /// Writes the groups of the stage and returns the digest of its own.
    pub(super) fn write(
        &self,
        transaction: &mut Transaction,
        home: Home,
        record: &GroupRecord,
        scene: &Scene,
    ) -> Result<String, StoreError> {
        let group = self.stage().group();
        match self {
            Self::Mesh(meshed) => write_group(transaction, group, home, record, |writer| {
                mesh::write(writer, meshed)
            }),
            Self::Assemble(system) => write_group(transaction, group, home, record, |writer| {
                format::write_assembly(writer, system)
            }),
            Self::Load(system) => write_group(transaction, group, home, record, |writer| {
                format::write_loads(writer, system)
            }),
            Self::Solve(meshed, evaluated) => {
                let steps = evaluated.history.as_ref();
                let steps = steps.map(|history| {
                    write_group(transaction, HISTORY, home, record, |writer| {
                        format::write_history(writer, scene, &history.records)
                    })
                });
                let steps = steps.transpose()?;
                write_group(transaction, group, home, record, |writer| {
                    solve::write(writer, meshed, &evaluated.answer, steps.as_deref())
                })
            }
            Self::Post(meshed, evaluated) => {
                // The report of another scene has other sizes, and would bind those of the grid, which is written first.
                transaction.remove(group);
                let vtkhdf = write_group(transaction, VTKHDF, home, record, |writer| {
                    post::write_vtkhdf(writer, meshed, evaluated)
                })?;
                write_group(transaction, group, home, record, |writer| {
                    post::write(writer, meshed, evaluated, &vtkhdf)
                })
            }
        }
    }
}
