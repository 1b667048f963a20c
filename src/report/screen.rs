//! The first screen of a run: what an engineer asks first, in at most fifteen lines.

use std::path::Path;

use contact3d::{
    post::{FunctionalEstimate, Zone},
    scene::{Functional, escape_control},
};
use units::{Dimension, Unit};

use super::{
    Figures, SolvedRun,
    answer::{motion_words, null_space_words},
    percent,
    run::estimate_words,
};
use crate::format::{Stage, dimension_of_quantity as dimension};

/// Most contact faces whose force has a line of its own.
const MOST_FACES: usize = 3;

impl SolvedRun<'_> {
    /// Status, forces, peaks, areas, displacement and the error of the mesh, in four digits with prefixes; what was not solved has a
    /// status alone.
    pub fn summary(&self) -> Figures {
        let units = self.scene.units;
        let mut lines = Figures::new(units);
        let mut line = |name: &str, words: Option<String>| lines.human_only(name, words);
        line("status", Some(self.status_words()));
        line("mesh", Some(self.sizes_in_words()));
        let motion = motion_words(units, self.mesh, self.solution, self.report);
        let motions = null_space_words(units, self.mesh, self.solution);
        for (name, words) in motion.into_iter().chain(motions) {
            line(name, Some(words));
        }
        if !self.solution.status.is_solved() {
            return lines;
        }
        line("contact", self.nothing_touches());
        for (name, force) in self.contact_forces() {
            line(&name, Some(force));
        }
        let of = |functional| self.quantity(functional);
        line("normal force", of(Functional::NormalForce));
        line("friction force", of(Functional::TangentialForce));
        line("largest pressure", of(Functional::LargestPressure));
        line("contact area", of(Functional::ContactArea));
        line("stick area", of(Functional::StickArea));
        line("largest von Mises", self.largest_von_mises());
        line("largest displacement", Some(self.largest_displacement()));
        let words = estimate_words(&self.report.discretisation_error, self.scene);
        line("error of the mesh", Some(words));
        lines
    }

    fn unit(&self, dimension: Dimension) -> Unit {
        self.scene.units.of(dimension)
    }

    fn sizes_in_words(&self) -> String {
        let (nodes, tetrahedra) = (self.mesh.coordinates.len(), self.mesh.tetrahedra.len());
        let panes = self.report.panes.len();
        let mut words = format!("{nodes} nodes, {tetrahedra} tetrahedra");
        if panes > 0 && self.solution.status.is_solved() {
            let zones = [Zone::Open, Zone::Stick, Zone::Slip].map(|zone| self.report.count(zone));
            let [open, stick, slip] = zones;
            words += &format!(", {panes} panes: {open} open, {stick} stick, {slip} slip");
        }
        words
    }

    /// The force on the body from each contact face, or from all of many.
    fn contact_forces(&self) -> Vec<(String, String)> {
        let unit = self.unit(Dimension::FORCE);
        let told = |force| unit.told(&self.without_noise(force, |row| row.force)) + " on the body";
        let faces = &self.report.faces;
        if (1..=MOST_FACES).contains(&faces.len()) {
            let features = self.scene.contact_features();
            let named = faces.iter().zip(features).map(|(face, has)| {
                let name = format!("force on {}", escape_control(&has.name));
                (name, told(face.contact.contact_force))
            });
            return named.collect();
        }
        let contact = self.report.resultants.contact.iter();
        contact
            .map(|contact| ("contact force".to_owned(), told(contact.contact_force)))
            .collect()
    }

    /// A quantity of the answer with its error bar or range, without them where they were not estimated.
    fn quantity(&self, functional: Functional) -> Option<String> {
        let unit = self.unit(dimension(functional));
        let mut estimates = self.report.functionals.iter();
        match estimates.find(|it| it.functional == functional) {
            Some(it) => Some(self.with_bar(it, &unit)),
            None => {
                let contact = self.report.resultants.contact.as_ref()?;
                let value = match functional {
                    Functional::NormalForce => contact.normal_force,
                    Functional::LargestPressure => contact.largest_pressure,
                    Functional::TangentialForce => {
                        let force = self.without_noise(contact.tangential_force?, |row| row.force);
                        force[0].hypot(force[1])
                    }
                    _ => return None,
                };
                Some(unit.told(&[value]))
            }
        }
    }

    fn with_bar(&self, it: &FunctionalEstimate, unit: &Unit) -> String {
        let value = unit.told(&[it.value]);
        let [low, high] = it.range;
        let place = self.place(it);
        match it.functional {
            of if of.is_area() => {
                let few = if self.report.has_few_panes() {
                    ", on few panes"
                } else {
                    ""
                };
                let (told, word) = unit.parts(&[it.value, low, high]);
                format!("{} {word} ({} to {}{few})", told[0], told[1], told[2])
            }
            Functional::TangentialForce if it.value.abs() <= self.noise(|row| row.force) => {
                unit.told(&[0.0])
            }
            _ if !high.is_finite() => {
                format!(
                    "above {value}{place}, an edge of the contact face where it grows with every finer mesh"
                )
            }
            _ if it.relative() > 1.0 => {
                let bar = (high - it.value).max(it.value - low);
                format!("{value} ± {}{place}", unit.told(&[bar]))
            }
            _ => format!("{value} ± {}{place}", percent(it.relative())),
        }
    }

    /// Where the largest pressure is.
    fn place(&self, it: &FunctionalEstimate) -> String {
        it.corners.map_or_else(String::new, |[low, high]| {
            let middle = [0, 1, 2].map(|axis| f64::midpoint(low[axis], high[axis]));
            format!(" at {}", self.unit(Dimension::LENGTH).told(&middle))
        })
    }

    fn largest_displacement(&self) -> String {
        let lengths = self
            .report
            .displacement
            .iter()
            .map(|[x, y, z]| x.hypot(*y).hypot(*z));
        self.unit(Dimension::LENGTH)
            .told(&[lengths.fold(0.0, f64::max)])
    }
}

/// What to do next with the run file of a solution, once a stage is done.
pub fn next_command(file: &Path, done: Option<Stage>) -> String {
    let shown = file.display();
    if done == Some(Stage::Solve) {
        return format!("contact3d-pipe post {shown}");
    }
    let page = file.with_extension("html");
    format!("contact3d-pipe report {shown} {}", page.display())
}
