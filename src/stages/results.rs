//! The report of a session, from what it has computed or reads back.

use std::path::PathBuf;

use contact3d::{
    mesh::Mesh,
    post::{ContactReport, Solved, SolvedContact},
    solver::Solution,
};

use super::{PictureFolder, Session, StageError, persistence::loaded};

impl Session {
    /// The mesh, the solution and the report of a post-processed file.
    ///
    /// # Errors
    /// Unreadable datasets.
    pub fn results(&mut self) -> Result<(&Mesh, &Solution, &ContactReport), StageError> {
        self.load_mesh()?;
        self.load_interface()?;
        self.load_solution()?;
        if self.report.is_none() {
            self.report = Some(self.evaluate()?);
        }
        Ok((
            loaded(&self.mesh),
            loaded(&self.solution),
            loaded(&self.report),
        ))
    }

    /// Draws the pictures of a post-processed file whose results are loaded; returns the files.
    ///
    /// # Errors
    /// A folder that cannot be written.
    pub fn draw(&self, folder: &PictureFolder) -> Result<Vec<PathBuf>, StageError> {
        let frame = self.interface.as_ref().map(|interface| &interface.frame);
        let report = loaded(&self.report);
        super::picture::draw(folder, self.scene(), loaded(&self.mesh), frame, report)
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
