//! Adaptive meshes: levels of solve, estimate and cut, until the estimate meets the scene's target.
//!
//! Between levels, as often as that costs no more than a twentieth of computing them, the file gets what the next one is
//! made of (`/adapt`: cells, cuts and starting multipliers of all levels so far), at the end the stages of
//! the level in force. They are part of what the stage `mesh` depends on, so every stage of
//! that level can be rerun and judged fresh or stale like any other.

use std::{sync::Arc, time::Instant};

use contact3d::{
    RunStep,
    adaptation::{
        Adaptation, AdaptiveLevel, AdaptiveStatus, LevelForecast, LevelStorage, RefinedLevels,
        SolvedLevel, refine,
    },
    dual::AssemblyError,
    mesh::{Mesh, RefinedLevel},
    scene::Scene,
};
use runfile::{Reader, Transaction};

use super::{
    Session, StageError, StageState, StageTiming, StoreWhen,
    resources::{available_memory, problem_bytes},
    results::Results,
    session::StageCache,
    settings::stage_settings,
    store::{Checkpoints, FIRST_COMMIT_SECONDS},
};
use crate::format::{self, ADAPT, FormatError, Stage};

/// What an adaptive run is doing.
pub enum AdaptStep<'a> {
    /// A stage of a level.
    Stage(usize, Stage),
    /// A step of that stage.
    Run(RunStep<'a>),
    /// A level is done.
    Done(usize, &'a AdaptiveLevel),
    /// The file holds so many levels.
    Kept(usize),
    /// The next level does not fit, for the stated reason.
    TooLarge(usize, String),
    /// What the next level is expected to come to.
    Forecast(usize, &'a LevelForecast),
    /// At the rate so far the target takes more memory than there is.
    OutOfReach {
        /// Free degrees of freedom with which it would be met.
        n_free: f64,
        /// Bytes that it takes.
        needed: u64,
        /// Bytes that there are.
        available: u64,
    },
}

/// The cuts between the first mesh of a scene and the one of its run file, which holds some levels; none for a scene that asks for no
/// adaptive mesh.
pub(super) fn refinement_in_force(
    levels: Option<&(Adaptation, AdaptiveStatus)>,
    scene: &Scene,
) -> Vec<RefinedLevel> {
    let (Some(adapt), Some((adaptation, _))) = (scene.adapt, levels) else {
        return Vec::new();
    };
    let all = &adaptation.refinement;
    let level = adaptation.level_that_meets(adapt.error);
    all[..level.unwrap_or(all.len())].to_vec()
}

/// Digest of all that the levels are computed from: the scene but for its target.
fn levels_input(scene: &Scene) -> String {
    let parts = Stage::ALL.map(|stage| stage_settings(stage, scene));
    blake3::hash(parts.concat().as_bytes()).to_hex().to_string()
}

/// The levels that a file holds for a scene, and how they stood; `None` without any, and for another scene.
pub(super) fn read_levels(
    reader: &Reader,
    scene: &Scene,
) -> Result<Option<(Adaptation, AdaptiveStatus)>, FormatError> {
    if scene.adapt.is_none() {
        return Ok(None);
    }
    let stored = reader.group_record(ADAPT)?;
    let stored = stored.filter(|stored| stored.record.input_digest == levels_input(scene));
    stored.map(|_| format::read_adaptation(reader)).transpose()
}

impl Session {
    /// Runs the stages of one level after the other until the estimated error meets the scene's target, or the next level would end after
    /// the deadline, and stores those of the last one. Goes on from the levels that the file holds. Returns all levels, and the stages
    /// of the one that the file holds then, if they were run now.
    ///
    /// A target that is not met is no error but a status; the file then holds the last level.
    pub fn adapt(
        &mut self,
        deadline: Option<Instant>,
        observe: &mut dyn FnMut(AdaptStep<'_>),
    ) -> Result<(RefinedLevels, Vec<StageTiming>), StageError> {
        let stored = self.stored_levels()?;
        let known = stored.clone().map(|(levels, _)| levels);
        let input = self.store.input.clone();
        let mut levels = LevelInRunFile {
            session: self,
            observe,
            saves: Checkpoints::new(FIRST_COMMIT_SECONDS),
            prepared: None,
            at_hand: None,
        };
        let (scene, folder) = (&input.scene, &input.folder);
        let known = known.unwrap_or_default();
        let refined = refine(scene, folder, deadline, known, &mut levels)?;
        let (all, status) = (&refined.adaptation, refined.status);
        if stored.is_none_or(|(known, ended)| known != *all || ended != status) {
            levels.session.write_levels(all, status)?;
        }
        let performed = levels.at_hand(refined.level, all)?.performed.clone();
        if !self.store.pending.is_empty() {
            self.store.commit(None)?;
        }
        Ok((refined, performed))
    }

    /// Whether nothing is left to do: every stage is fresh, and the levels for the scene's target, if it has
    /// one, have come to an end.
    pub fn is_done(&self) -> Result<bool, StageError> {
        let has_ended = match self.scene().adapt {
            None => true,
            Some(adapt) => self.stored_levels()?.is_some_and(|(levels, _)| {
                levels.status(adapt.error, adapt.of) != AdaptiveStatus::Refining
            }),
        };
        Ok(has_ended && self.states()?.iter().all(StageState::is_fresh))
    }

    /// Whether the file holds a mesh that was refined for an error which the scene does not ask for.
    pub fn holds_other_levels(&self) -> Result<bool, StageError> {
        let reader = self.store.reader_if_there()?;
        let levels = reader.map_or(Ok(None), |reader| reader.group_record(ADAPT))?;
        Ok(self.scene().adapt.is_none() && levels.is_some())
    }

    fn stored_levels(&self) -> Result<Option<(Adaptation, AdaptiveStatus)>, StageError> {
        let reader = self.store.reader_if_there()?;
        let levels = |reader| read_levels(&reader, self.scene()).unwrap_or(None);
        Ok(reader.and_then(levels))
    }

    /// Stores the levels done, beside whatever stages the file holds.
    fn write_levels(
        &mut self,
        adaptation: &Adaptation,
        status: AdaptiveStatus,
    ) -> Result<(), StageError> {
        let seconds = adaptation.levels.iter().map(|level| level.seconds).sum();
        let input = levels_input(self.scene());
        let record = self.store.record(String::new(), seconds, input);
        let mut transaction = Transaction::begin(&self.store.file)?;
        self.store.write_scene(&mut transaction)?;
        transaction.write(ADAPT, &record, |writer| {
            format::write_adaptation(writer, adaptation, status)
        })?;
        Ok(self.store.end(transaction, &[ADAPT])?)
    }
}

/// Has the stages of one level in memory, or fresh in the run file.
struct LevelInRunFile<'a> {
    session: &'a mut Session,
    observe: &'a mut dyn FnMut(AdaptStep<'_>),
    saves: Checkpoints,
    /// The mesh of the next level.
    prepared: Option<Mesh>,
    at_hand: Option<LevelAtHand>,
}

/// The level whose stages are at hand.
struct LevelAtHand {
    level: usize,
    results: Arc<Results>,
    /// The stages that were run for it.
    performed: Vec<StageTiming>,
    /// Seconds that its stages took, now or when they were stored.
    seconds: f64,
}

impl LevelInRunFile<'_> {
    fn at_hand(&mut self, level: usize, known: &Adaptation) -> Result<&LevelAtHand, StageError> {
        let at_hand = match self.at_hand.take() {
            Some(at_hand) if at_hand.level == level => at_hand,
            _ => self.run(level, known)?,
        };
        Ok(self.at_hand.insert(at_hand))
    }

    /// Reads the stages of a level, or runs and holds them.
    fn run(&mut self, level: usize, known: &Adaptation) -> Result<LevelAtHand, StageError> {
        let (session, observe) = (&mut *self.session, &mut *self.observe);
        session.store.pending.clear();
        let mut refinement = known.refinement.clone();
        refinement.truncate(level);
        session.store.refinement = refinement;
        let before = level.checked_sub(1);
        session.store.start = before.map(|before| known.starts[before].clone());
        let is_last = level == known.refinement.len();
        session.cache = StageCache {
            mesh: self.prepared.take().filter(|_| is_last),
            ..StageCache::default()
        };
        let mut performed = Vec::new();
        let states = session.states()?;
        let stored = states.iter().filter_map(|state| state.stored.as_ref());
        let mut seconds: f64 = stored.map(|stored| stored.record.seconds).sum();
        if !states.iter().all(StageState::is_fresh) {
            for stage in Stage::ALL {
                observe(AdaptStep::Stage(level, stage));
                let observe = &mut |step: RunStep<'_>| observe(AdaptStep::Run(step));
                performed.push(session.perform(stage, StoreWhen::Manual, observe)?);
            }
            seconds = performed.iter().map(|it| it.compute_seconds).sum();
        }
        Ok(LevelAtHand {
            level,
            results: session.results()?,
            performed,
            seconds,
        })
    }
}

impl LevelStorage for LevelInRunFile<'_> {
    type Error = StageError;

    fn solved(&mut self, level: usize, known: &Adaptation) -> Result<SolvedLevel<'_>, StageError> {
        self.at_hand(level, known)?;
        let LevelAtHand {
            results, seconds, ..
        } = self.at_hand.as_ref().expect("made sure just now");
        let assembled = self.session.cache.assembled.as_ref();
        let has_dense_operator = assembled.is_some_and(|(it, _)| {
            it.system
                .contact
                .as_ref()
                .is_some_and(|contact| contact.explicit().is_some())
        });
        Ok(SolvedLevel {
            mesh: results.mesh(),
            has_dense_operator,
            solution: &results.solution,
            report: &results.report,
            increments: &results.increments,
            seconds: *seconds,
        })
    }

    fn done(&mut self, number: usize, level: &AdaptiveLevel) {
        (self.observe)(AdaptStep::Done(number, level));
    }

    fn too_large(&mut self, level: usize, error: StageError) -> Result<(), StageError> {
        match error {
            StageError::InsufficientResource(shortage)
            | StageError::Assembly(AssemblyError::InsufficientResource(shortage)) => {
                (self.observe)(AdaptStep::TooLarge(level, shortage.to_string()));
                Ok(())
            }
            error => Err(error),
        }
    }

    fn forecast(&mut self, level: usize, forecast: &LevelForecast) {
        (self.observe)(AdaptStep::Forecast(level, forecast));
        let needed = forecast
            .n_free_of_target
            .map(|n_free| problem_bytes(n_free / 3.0));
        if let (Some(n_free), Some(needed), Some(available)) =
            (forecast.n_free_of_target, needed, available_memory())
            && needed > available
        {
            (self.observe)(AdaptStep::OutOfReach {
                n_free,
                needed,
                available,
            });
        }
    }

    fn checkpoint(&mut self, known: &Adaptation, next: Mesh) {
        self.prepared = Some(next);
        let (session, observe) = (&mut *self.session, &mut *self.observe);
        self.saves.keep(|| {
            session.write_levels(known, AdaptiveStatus::Refining)?;
            observe(AdaptStep::Kept(known.levels.len()));
            Ok(())
        });
    }
}
