//! Adaptive meshes: levels of solve, estimate and cut, until the estimate meets the scene's wish.
//!
//! Between levels, as often as that costs no more than a twentieth of computing them, the file gets what the next one is
//! made of (`/adapt`: cuts and starting multipliers of all levels so far), at the end the stages of
//! the level in force. The cuts are part of what the stage `mesh` depends on, so every stage of
//! that level can be rerun and judged fresh or stale like any other.

use contact3d::{
    adaptation::{Adaptation, AdaptiveLevel, AdaptiveStatus, Target, next_cuts, transferred},
    dual::AssemblyError,
    mesh::{RefinableBody, Refinement},
    scene::Scene,
};
use runfile::{Home, Reader, StoreError, Transaction};

use super::{
    Commit, Freshness, Performed, Session, StageError, Step,
    mesh::refused,
    solve::StartFrom,
    stages::{Chosen, settings},
    store::{Checkpoints, write_group, write_scene},
};
use crate::format::{self, ADAPT, FormatError, Stage};

/// The cuts between the first mesh of a scene and the one of its run file.
#[derive(Debug, Clone, Default)]
pub(super) struct RefinementInForce {
    cuts: Refinement,
    digest: Option<String>,
}

/// What storing the levels takes before it is known.
const SECONDS_OF_A_COMMIT: f64 = 0.02;

/// How an adaptive run went.
#[derive(Debug)]
pub struct Adapted {
    /// The relative error that was asked for.
    pub wish: f64,
    /// All levels, those of earlier runs included.
    pub adaptation: Adaptation,
    /// How it ended.
    pub status: AdaptiveStatus,
    /// The level whose stages the file holds.
    pub level: usize,
    /// The stages of that level, if they were run now.
    pub performed: Vec<Performed>,
}

/// What an adaptive run is doing.
pub enum AdaptStep<'a> {
    /// A stage of a level.
    Stage(usize, Stage),
    /// A step of that stage.
    Step(Step<'a>),
    /// A level is done.
    Done(usize, &'a AdaptiveLevel),
    /// The next level does not fit, for the stated reason.
    TooLarge(usize, String),
}

impl RefinementInForce {
    fn new(cuts: Refinement) -> Self {
        let digest = (!cuts.is_empty()).then(|| {
            let mut hasher = blake3::Hasher::new();
            for level in cuts.levels() {
                hasher.update(&(level.len() as u64).to_le_bytes());
                hasher.update(level);
            }
            hasher.finalize().to_hex().to_string()
        });
        Self { cuts, digest }
    }

    /// What a file holds for a scene; none for a scene that asks for no adaptive mesh, and before
    /// its first level. Unreadable levels are made again.
    pub(super) fn stored(reader: Option<&Reader>, scene: &Scene) -> Self {
        let (Some(adapt), Some(reader)) = (scene.adapt, reader) else {
            return Self::default();
        };
        match read(reader, scene) {
            Ok(Some((mut adaptation, _))) => {
                if let Some(level) = adaptation.level_that_meets(adapt.error) {
                    adaptation.refinement.truncate(level);
                }
                Self::new(adaptation.refinement)
            }
            Ok(None) | Err(_) => Self::default(),
        }
    }

    pub(super) fn cuts(&self) -> &Refinement {
        &self.cuts
    }

    pub(super) fn digest(&self) -> Option<&str> {
        self.digest.as_deref()
    }
}

/// Digest of all that the levels are computed from: the scene but for its wish.
fn levels_input(scene: &Scene) -> String {
    let parts = Stage::ALL.map(|stage| settings(stage, scene, Chosen::default()));
    blake3::hash(parts.concat().as_bytes()).to_hex().to_string()
}

/// The levels that a file holds for a scene; `None` without any, and for another scene.
fn read(
    reader: &Reader,
    scene: &Scene,
) -> Result<Option<(Adaptation, AdaptiveStatus)>, FormatError> {
    let stored = reader.whole_group(ADAPT)?;
    if stored.is_some_and(|stored| stored.record.input_digest == levels_input(scene)) {
        Ok(Some(format::read_adaptation(reader)?))
    } else {
        Ok(None)
    }
}

impl Session {
    /// Runs the stages of one level after the other until the estimated error meets `wish`, and
    /// stores those of the last one. Goes on from the levels that the file holds.
    ///
    /// A wish that is not met is no error but a status; the file then holds the last level.
    ///
    /// # Errors
    /// As [`Self::perform`].
    pub fn adapt(
        &mut self,
        wish: f64,
        observe: &mut dyn FnMut(AdaptStep<'_>),
    ) -> Result<Adapted, StageError> {
        let stored = self.stored_levels()?;
        let mut adaptation = stored
            .clone()
            .map_or_else(Adaptation::default, |(levels, _)| levels);
        let mut held = KeptLevel::default();
        let mut saves = Checkpoints::new(SECONDS_OF_A_COMMIT);
        let mut too_large = false;
        loop {
            let (n_done, n_made) = (
                adaptation.levels.len(),
                adaptation.refinement.levels().len(),
            );
            if adaptation.level_that_meets(wish).is_some() {
                break;
            }
            if n_done > n_made {
                if too_large || adaptation.status(wish) != AdaptiveStatus::Refining {
                    break;
                }
                self.hold(&mut held, &adaptation, n_made, observe)?;
                self.make_next(&mut adaptation, wish)?;
                saves.keep(|| self.write_levels(&adaptation, AdaptiveStatus::Refining));
                continue;
            }
            match self.hold(&mut held, &adaptation, n_made, observe) {
                Ok(()) => {
                    let level = self.level(&held)?;
                    observe(AdaptStep::Done(n_made, &level));
                    adaptation.levels.push(level);
                }
                Err(
                    StageError::Shortage(shortage)
                    | StageError::Assembly(AssemblyError::Shortage(shortage)),
                ) if n_made > 0 => {
                    observe(AdaptStep::TooLarge(n_made, shortage.to_string()));
                    too_large = true;
                    adaptation.refinement.truncate(n_made - 1);
                    adaptation.starts.truncate(n_made - 1);
                }
                Err(error) => return Err(error),
            }
        }
        let status = if too_large {
            AdaptiveStatus::TooLarge
        } else {
            adaptation.status(wish)
        };
        let meets = adaptation.level_that_meets(wish);
        let level = meets.unwrap_or(adaptation.levels.len() - 1);
        let ended = (adaptation, status);
        if stored.as_ref() != Some(&ended) {
            self.write_levels(&ended.0, status)?;
        }
        let (adaptation, _) = ended;
        self.hold(&mut held, &adaptation, level, observe)?;
        self.store.store_pending(&self.task)?;
        Ok(Adapted {
            wish,
            adaptation,
            status,
            level,
            performed: held.performed,
        })
    }

    /// Whether nothing is left to do: every stage is fresh, and the levels for the scene's wish, if it has
    /// one, have come to an end.
    ///
    /// # Errors
    /// An unreadable file.
    pub fn is_done(&self) -> Result<bool, StageError> {
        let has_ended = match self.scene().adapt {
            None => true,
            Some(adapt) => self
                .stored_levels()?
                .is_some_and(|(levels, _)| levels.status(adapt.error) != AdaptiveStatus::Refining),
        };
        Ok(has_ended && self.is_fresh_throughout()?)
    }

    fn is_fresh_throughout(&self) -> Result<bool, StageError> {
        let mut states = self.states()?.into_iter();
        Ok(states.all(|state| state.freshness == Freshness::Fresh))
    }

    fn stored_levels(&self) -> Result<Option<(Adaptation, AdaptiveStatus)>, StageError> {
        match self.store.reader() {
            Ok(reader) => Ok(read(&reader, self.scene()).unwrap_or(None)),
            Err(StoreError::NotFound { .. }) => Ok(None),
            Err(error) => Err(error.into()),
        }
    }

    /// Has the stages of a level at hand: in memory, or fresh in the file, or by running them.
    fn hold(
        &mut self,
        held: &mut KeptLevel,
        adaptation: &Adaptation,
        level: usize,
        observe: &mut dyn FnMut(AdaptStep<'_>),
    ) -> Result<(), StageError> {
        if held.level == Some(level) {
            return Ok(());
        }
        *held = KeptLevel::default();
        self.store.discard_pending();
        let mut cuts = adaptation.refinement.clone();
        cuts.truncate(level);
        self.task.refinement = RefinementInForce::new(cuts);
        if let Some(before) = level.checked_sub(1) {
            self.task.start = StartFrom::multipliers(adaptation.starts[before].clone());
        } else {
            self.task.start = StartFrom::Any;
        }
        self.known = super::known::StageCache::default();
        if !self.is_fresh_throughout()? {
            for stage in Stage::ALL {
                observe(AdaptStep::Stage(level, stage));
                let commit = Commit::Held;
                let performed =
                    self.perform(stage, commit, &mut |step| observe(AdaptStep::Step(step)))?;
                held.performed.push(performed);
            }
        }
        held.level = Some(level);
        Ok(())
    }

    /// What the level at hand came to.
    fn level(&mut self, held: &KeptLevel) -> Result<AdaptiveLevel, StageError> {
        let results = self.results()?;
        let in_memory = self.known.in_memory();
        let dual = in_memory.and_then(|(_, system)| system.contact.as_ref()?.explicit());
        let seconds = held.performed.iter().map(|p| p.compute_seconds);
        // An empty sum of floats is −0.
        let seconds = 0.0 + seconds.sum::<f64>();
        Ok(AdaptiveLevel::new(
            results.mesh(),
            dual,
            results.solution(),
            results.report(),
            seconds,
        ))
    }

    /// Chooses what to cut of the level at hand, and what the next one starts from.
    fn make_next(&mut self, adaptation: &mut Adaptation, wish: f64) -> Result<(), StageError> {
        let results = self.results()?;
        let (scene, folder) = (&self.task.input.scene, &self.task.input.folder);
        let error = &results.report().discretisation_error;
        let target = Target::of(scene, error, wish);
        let cuts = next_cuts(&error.indicator, target);
        adaptation.refinement.push(cuts);
        let refuse = |error| refused(&self.task.input, error);
        let body = RefinableBody::refined(scene, folder, &adaptation.refinement).map_err(refuse)?;
        adaptation.starts.push(transferred(
            results.mesh(),
            &body.mesh().map_err(refuse)?,
            &body.parents(),
            &results.solution().multiplier,
        ));
        Ok(())
    }

    /// Stores the levels done, beside whatever stages the file holds.
    fn write_levels(
        &mut self,
        adaptation: &Adaptation,
        status: AdaptiveStatus,
    ) -> Result<(), StageError> {
        let seconds = adaptation.levels.iter().map(|level| level.seconds).sum();
        let input = levels_input(self.scene());
        let record = self.task.record(String::new(), seconds, input);
        let mut transaction = Transaction::begin(&self.store.file)?;
        write_scene(&mut transaction, &self.task)?;
        write_group(&mut transaction, ADAPT, Home::RunFile, &record, |writer| {
            format::write_adaptation(writer, adaptation, status)
        })?;
        Ok(self.store.end(transaction, &[ADAPT])?)
    }
}

/// The level whose stages are at hand.
#[derive(Default)]
struct KeptLevel {
    level: Option<usize>,
    performed: Vec<Performed>,
}
