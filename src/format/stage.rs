//! The stages a user can run, in the order data flow.

use runfile::Group;

use super::{assemble, load, mesh, post, solve};

/// A step of the pipeline: it computes one group from those of the stages before it.
///
/// What a run file holds besides (the scene, checkpoints, accuracy) is no stage.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord, Hash)]
pub enum Stage {
    /// Mesh, boundary and panes.
    Mesh,
    /// Matrices and the factor.
    Assemble,
    /// Loads and what follows from them linearly.
    Load,
    /// Multipliers, displacement and history.
    Solve,
    /// Stresses, zones, resultants and the certificate; the same for ParaView.
    Post,
}

impl Stage {
    /// Every stage, upstream first.
    pub const ALL: [Self; 5] = [
        Self::Mesh,
        Self::Assemble,
        Self::Load,
        Self::Solve,
        Self::Post,
    ];

    /// The command that runs the stage.
    #[must_use]
    pub const fn command(self) -> &'static str {
        match self {
            Self::Mesh => "mesh",
            Self::Assemble | Self::Load => "assemble",
            Self::Solve => "solve",
            Self::Post => "post",
        }
    }

    /// The group that the stage writes.
    #[must_use]
    pub const fn group(self) -> Group {
        match self {
            Self::Mesh => mesh::GROUP,
            Self::Assemble => assemble::GROUP,
            Self::Load => load::GROUP,
            Self::Solve => solve::GROUP,
            Self::Post => post::GROUP,
        }
    }

    /// What messages call the stage.
    #[must_use]
    pub const fn word(self) -> &'static str {
        self.group().name()
    }

    /// The stages it builds on.
    pub fn upstream(self) -> impl Iterator<Item = Self> {
        Self::ALL.into_iter().filter(move |other| *other < self)
    }
}
