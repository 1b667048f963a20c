//! The report of a session, from what it has computed or reads back.

use contact3d::{
    contact::Interface,
    mesh::Mesh,
    post::{ContactReport, Solved, SolvedContact},
    scene::Scene,
    solver::Solution,
};

use super::{Session, StageError, persistence::loaded};

/// What a solve came to.
#[derive(Debug, Clone, Copy)]
pub struct Results<'a> {
    /// The scene.
    pub scene: &'a Scene,
    /// The mesh.
    pub mesh: &'a Mesh,
    /// The laws of the contact face; `None` without contact.
    pub interface: Option<&'a Interface>,
    /// Multipliers and displacement.
    pub solution: &'a Solution,
    /// What follows from them.
    pub report: &'a ContactReport,
}

impl Session {
    /// The results of a post-processed file.
    ///
    /// # Errors
    /// Unreadable datasets.
    pub fn results(&mut self) -> Result<Results<'_>, StageError> {
        self.load_mesh()?;
        self.load_interface()?;
        self.load_solution()?;
        if self.report.is_none() {
            self.report = Some(self.evaluate()?);
        }
        Ok(Results {
            scene: self.scene(),
            mesh: loaded(&self.mesh),
            interface: self.interface.as_ref(),
            solution: loaded(&self.solution),
            report: loaded(&self.report),
        })
    }

    /// The report of the solution, which has failed if a figure of the report is out of range.
    pub(super) fn evaluate(&mut self) -> Result<ContactReport, StageError> {
        self.load_interface()?;
        let contact = self.coupling().zip(self.contact_state());
        let report = ContactReport::new(&Solved {
            scene: self.scene(),
            mesh: loaded(&self.mesh),
            system: self.primal(),
            contact: contact.map(|(coupling, state)| SolvedContact { coupling, state }),
            solution: loaded(&self.solution),
        });
        let report = report.map_err(|invalid| self.refuse(invalid))?;
        if let Some(solution) = &mut self.solution {
            solution.status = report.judged(solution.status);
        }
        Ok(report)
    }
}
