//! The first screen of a run: what an engineer asks first, in at most fifteen lines.

use std::path::Path;

use contact3d::{
    mesh::{ContactSurface, extents},
    post::{FunctionalEstimate, StressConcentration, ToolState, Zone},
    scene::{ElementOrder, Functional, escape_control},
};
use units::{Dimension, Unit};

use super::{
    Figures, SolvedRun,
    answer::{motion_words, name_of_quantity, null_space_words, with_bar},
    increment_in_words,
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
        let motion = motion_words(self.scene, self.mesh, self.solution, self.report);
        let motions = null_space_words(self.scene, self.mesh, self.solution);
        for (name, words) in motion.into_iter().chain(motions) {
            line(name, Some(words));
        }
        line("interference", self.interference());
        if !self.solution.status.is_solved() {
            return lines;
        }
        line("contact", self.nothing_touches());
        for (name, force) in self.contact_forces().into_iter().chain(self.joint_forces()) {
            line(&name, Some(force));
        }
        for (tool, state) in self.report.tools.iter().enumerate() {
            let name = format!("tool {}", escape_control(&self.scene.tool_name(tool)));
            let words = self.tool_in_words(state);
            line(&name, (!words.is_empty()).then_some(words));
        }
        for of in self.first_quantities() {
            let share = match of {
                Functional::TangentialForce => self.friction_words(),
                _ => String::new(),
            };
            line(
                &name_of_quantity(of),
                self.quantity(of).map(|words| words + &share),
            );
        }
        line("largest von Mises", self.largest_von_mises());
        let displacement = self.report.resultants.largest_displacement;
        let displacement = self.unit(Dimension::LENGTH).told(&[displacement]);
        line(
            "largest displacement",
            Some(displacement + self.if_unresolved()),
        );
        line("error of the mesh", Some(self.estimate_words()));
        let last = self.increments.last();
        line(
            "state",
            last.map(|last| {
                let words = increment_in_words(self.scene, last.increment);
                format!("all of this is of the last increment, {words}")
            }),
        );
        lines
    }

    /// Where a tool is, and what holds or drives it; what is rounding of the largest part, or of a force at the end of the body, is zero.
    fn tool_in_words(&self, tool: &ToolState) -> String {
        let size = |vector: &[f64; 3]| {
            vector
                .iter()
                .fold(0.0_f64, |most, part| most.max(part.abs()))
        };
        let lever = size(&tool.force) * self.mesh.extent();
        let parts = [
            ("moved by", Dimension::LENGTH, tool.displacement, 0.0, ""),
            ("turned by", Dimension::Number, tool.turn, 0.0, " rad"),
            ("force", Dimension::FORCE, tool.force, 0.0, ""),
            ("moment", Dimension::MOMENT, tool.moment, lever, ""),
        ];
        let told = parts.map(|(name, dimension, vector, least, unit)| {
            let noise = 1e-9 * size(&vector).max(least);
            let clean = vector.map(|part| if part.abs() <= noise { 0.0 } else { part });
            let words = self.unit(dimension).told(&clean);
            (size(&clean) > 0.0).then(|| format!("{name} {words}{unit}"))
        });
        let words = told.into_iter().flatten().collect::<Vec<_>>().join(", ");
        match size(&tool.displacement) > 0.0 {
            true => words + self.if_unresolved(),
            false => words,
        }
    }

    /// The quantities of the first screen, the one that the mesh is refined for among them.
    pub(super) fn first_quantities(&self) -> Vec<Functional> {
        let mut first = vec![
            Functional::NormalForce,
            Functional::TangentialForce,
            Functional::LargestPressure,
            Functional::ContactArea,
            Functional::StickArea,
        ];
        // Each of several faces has its own force; a sum of theirs acts nowhere.
        if !self.report.faces.is_empty() {
            let is_force = |of: &Functional| {
                matches!(of, Functional::NormalForce | Functional::TangentialForce)
            };
            first.retain(|of| !is_force(of));
        }
        let wanted = self.scene.adapt.and_then(|adapt| adapt.of);
        let is_shown = |of: &Functional| first.contains(of) || *of == Functional::LargestVonMises;
        let wanted = wanted.filter(|of| !is_shown(of));
        first.extend(wanted);
        first
    }

    fn unit(&self, dimension: Dimension) -> Unit {
        self.scene.units.of(dimension)
    }

    fn sizes_in_words(&self) -> String {
        let (nodes, tetrahedra) = (self.mesh.coordinates.len(), self.mesh.tetrahedra.len());
        let panes = self.report.panes.len();
        let size = self
            .unit(Dimension::LENGTH)
            .told(&extents(&self.mesh.coordinates));
        let size = size.replace(", ", " × ").replace(['(', ')'], "");
        let mut words = format!("{size}, {nodes} nodes, {tetrahedra} tetrahedra");
        if panes > 0 && self.solution.status.is_solved() {
            let zones = [Zone::Open, Zone::Stick, Zone::Slip].map(|zone| self.report.count(zone));
            let [open, stick, slip] = zones;
            words += &match self.scene.has_friction() {
                true => format!(", {panes} panes: {open} open, {stick} stick, {slip} slip"),
                false => format!(", {panes} panes: {open} open, {slip} in contact"),
            };
        }
        words
    }

    /// The force on the body from each contact face, or from all of many that one body has.
    fn contact_forces(&self) -> Vec<(String, String)> {
        let unit = self.unit(Dimension::FORCE);
        let told = |force| unit.told(&self.without_noise(force, |row| row.force));
        let faces = self.rows_of_faces();
        if let Some(contact) = self.report.resultants.contact.as_ref()
            && faces.len() > MOST_FACES
            && !self.scene.bodies_touch()
        {
            let force = told(contact.contact_force) + " on the body";
            return vec![("contact force".to_owned(), force)];
        }
        let faces = faces.into_iter().take(MOST_FACES);
        let line = |(row, name, body): (usize, String, String)| {
            (
                name,
                format!("{} on {body}", told(self.report.forces[row].force)),
            )
        };
        faces.map(line).collect()
    }

    /// The forces of glued faces on the body of the first of each pair, of the first pairs.
    fn joint_forces(&self) -> Vec<(String, String)> {
        let unit = self.unit(Dimension::FORCE);
        // One more takes as many lines as to say so.
        let n_pairs = self.scene.glued_pairs().count();
        let most = MOST_FACES + usize::from(n_pairs == MOST_FACES + 1);
        let others = n_pairs.saturating_sub(most);
        let others = (others > 0).then(|| (format!("and {others} more"), "post -v".to_owned()));
        let pairs = self.scene.glued_pairs().take(most);
        let told = |(entry, [face, other]): (usize, &[String; 2])| {
            let key = self.scene.contact_key(entry);
            let mut rows = self.report.forces.iter();
            let row = rows.find(|row| row.source == key && row.face == *face)?;
            let force = unit.told(&self.without_noise(row.force, |row| row.force));
            let body = escape_control(self.scene.contacts[entry].first_body());
            let name = format!("joint {}-{}", escape_control(face), escape_control(other));
            Some((name, format!("{force} on {body}")))
        };
        pairs.filter_map(told).chain(others).collect()
    }

    /// How much of what friction can bear is used, by the force and by panes whose forces cancel in it, and the longest slip.
    fn friction_words(&self) -> String {
        let share = self.friction_used().map_or_else(String::new, |shares| {
            let [force, panes] = shares.map(|share| format!("{:.0} %", 100.0 * share));
            let words = format!(", {force} of what friction can bear");
            match shares[1] > 1.5 * shares[0] {
                true => words + &format!(", {panes} on panes, which oppose each other"),
                false => words,
            }
        });
        let slip = self.largest_slip();
        let slip = slip.map(|slip| self.unit(Dimension::LENGTH).told(&[slip]));
        let of = if self.increments.is_empty() {
            ""
        } else {
            " in the last increment"
        };
        let slip = slip.map(|slip| format!("; slips by up to {slip}{of}"));
        share + &slip.unwrap_or_default()
    }

    /// The friction force over the largest one in its direction that the panes can bear as they are pressed, and the stresses of panes over what
    /// these can bear, both summed by size.
    fn friction_used(&self) -> Option<[f64; 2]> {
        let areas = &self.mesh.contact.as_ref()?.pane_area;
        let force = self.report.resultants.contact.as_ref()?.tangential_force?;
        let [mut along, mut used, mut most] = [0.0; 3];
        for (pane, area) in self.report.panes.iter().zip(areas) {
            let friction = pane.friction?;
            let [first, second] = friction.semi_axes;
            let share = |of: [f64; 2]| (of[0] / first).hypot(of[1] / second);
            let bound = area * (first * second).sqrt();
            if bound > 0.0 {
                along += area / share(force);
                used += bound * share(friction.stress);
                most += bound;
            }
        }
        (most > 0.0).then(|| [1.0 / along, used / most])
    }

    /// The longest slip of a pane that slips; `None` where none does, or without friction.
    fn largest_slip(&self) -> Option<f64> {
        let panes = self.report.panes.iter();
        let slipping = panes.filter(|pane| pane.zone == Zone::Slip);
        let slips = slipping
            .filter_map(|pane| pane.friction)
            .map(|it| it.slip[0].hypot(it.slip[1]));
        slips.reduce(f64::max)
    }

    /// The first screen with all warnings, as it is told of a file later.
    pub fn summary_with_warnings(&self) -> Figures {
        let mut summary = self.summary();
        let warnings = self.all_warnings();
        summary.human_only(
            "warning",
            (!warnings.is_empty()).then(|| warnings.join("; ")),
        );
        summary
    }

    /// A quantity of the solution with its error bar or range, without them where they were not estimated.
    pub(super) fn quantity(&self, of: Functional) -> Option<String> {
        let unit = &self.unit(dimension(of));
        let mut estimates = self.report.functionals.iter();
        if let Some(it) = estimates.find(|it| it.functional == of) {
            return Some(self.with_error(it, unit));
        }
        let (largest, words) = (self.pane_of_largest_pressure(), self.if_unresolved());
        let contact = self.report.discretisation_error.contact;
        let is_near = largest.is_some() || contact.is_some_and(|it| it.penetration > 0.0);
        let words = if is_near { words } else { "" };
        let Some(value) = self.report.value(of) else {
            let has_area = match of {
                Functional::StickArea => self.scene.has_friction(),
                _ => of.is_area(),
            };
            let words = words.strip_prefix(", ").filter(|_| has_area);
            return words.map(str::to_owned);
        };
        let is_noise = of == Functional::TangentialForce && value <= self.noise(|row| row.force);
        let told = unit.told(&[if is_noise { 0.0 } else { value }]);
        if of != Functional::LargestPressure {
            return Some(told + words);
        }
        let place = largest.map_or_else(String::new, |(pane, surface)| {
            let middle = surface.pane_centre(self.mesh, pane);
            let at = self.unit(Dimension::LENGTH).told(&middle);
            format!(" at {at}{}", self.face_of_largest_pressure())
        });
        Some(told + &place + words)
    }

    /// The pane with the largest pressure; `None` where none is pressed.
    fn pane_of_largest_pressure(&self) -> Option<(usize, &ContactSurface)> {
        let stress = |pane: &usize| self.report.panes[*pane].normal_stress;
        let panes = 0..self.report.panes.len();
        let highest = panes.min_by(|a, b| stress(a).total_cmp(&stress(b)))?;
        Some((highest, self.mesh.contact.as_ref()?)).filter(|_| stress(&highest) < 0.0)
    }

    /// The name of its contact face, where there are several.
    fn face_of_largest_pressure(&self) -> String {
        let faces = self.scene.contact_features();
        let at = self.pane_of_largest_pressure().filter(|_| faces.len() > 1);
        at.map_or_else(String::new, |(pane, surface)| {
            let name = &faces[surface.face_of_pane(pane)].name;
            format!(" on {}", escape_control(name))
        })
    }

    fn with_error(&self, it: &FunctionalEstimate, unit: &Unit) -> String {
        if it.functional.is_area() {
            let few = if self.report.has_few_panes() {
                ", on few panes"
            } else {
                ""
            };
            // What rounding leaves of a face that lies open.
            let least = 1e-12 * self.mesh.extent().powi(2);
            let figures = [it.value, it.range[0], it.range[1]];
            let figures = figures.map(|area| if area < least { 0.0 } else { area });
            let (told, word) = unit.parts(&figures);
            return format!("{} {word} ({} to {}{few})", told[0], told[1], told[2]);
        }
        let noise = self.noise(|row| row.force);
        if it.functional == Functional::TangentialForce && it.value.abs() <= noise {
            return unit.told(&[0.0]);
        }
        let length = self.unit(Dimension::LENGTH);
        let at = |place: [f64; 3]| format!(" at {}", length.told(&place));
        let mut place = it.middle().map_or_else(String::new, at);
        if it.functional == Functional::LargestPressure {
            place += &self.face_of_largest_pressure();
        }
        let unbounded = self.unbounded.filter(|of| *of == it.functional);
        let grows = self.report.concentration(it.functional);
        let grows = grows.or(unbounded.map(|_| StressConcentration::Contact));
        let grows = grows.map(|what| (what, None));
        // A mesh for the energy norm may leave a peak far behind.
        let is_behind = it.functional == Functional::LargestPressure
            && it.relative() > 0.25
            && self.scene.element() == ElementOrder::P2;
        let of_energy = self.scene.adapt.filter(|adapt| adapt.of.is_none());
        let more = match is_behind && grows.is_none() && of_energy.is_some() {
            true => "; --quantity largest_pressure refines for it",
            false => "",
        };
        with_bar(unit, [it.value, it.error_bar()], &place, grows) + more
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
