//! The areas of contact and of stick, and where they lie.
//!
//! A count of panes moves by whole panes and cannot tell how sure it is. Here the conditions of contact are asked at the nodes of each
//! pane, whose multiplier λ is a mean: a face that is pressed by a wave of the length 2h of a pane resists like a half-space with
//!
//!   k = 2 E*/h,  h = √|R|,  1/E* = (1 − ν²)/E, of two bodies the sum of both,
//!
//! so that pressure and shear at a node with the gap g and the slip s (along λ_t) are about
//!
//!   z = λ_ν − k g,   τ = λ_t + k s,   ψ = min(m(z⁺) (1 − ‖τ‖_𝓕), z),
//!
//! with the ellipse 𝓕 of the pressure z⁺ and the mean m of its semi-axes. Contact is where z > 0 and stick where ψ > 0, both linear
//! between the nodes of a triangle, of quadratic ones on four parts.
//!
//! A level line may lie 0.15 of a pane away, by which z changes as much as from pane to pane; and the pressure itself is off by about the
//! relative error η of the energy norm. So z is known to δ = 0.15 rms |Δz̄| + 0.75 η p̃ and ψ to 0.15 rms |Δψ̄| + 1.5 η m̃, with root mean
//! squares p̃ and m̃ over the pressed face; where η is small, lines of contact are better known than that by √(η/0.15). Where the gap g
//! differs between the nodes from its interpolation g_h, the amplitude k √2 rms |g − g_h| of such a wave adds to δ, of ψ as m̃/p̃ says. Where
//! a pane is partly open z⁺ would carry more than λ_ν, and (z − c)⁺ just that for some c: z is taken less c/2, which adds to δ. The
//! areas lie between those with z > δ and z > −δ. The other factors are measured: in 171 of 174 runs of 30 scenes the ranges held without c, at
//! half the width of ranges by whole panes.

use super::{
    ErrorEstimate, FunctionalEstimate, Solved, SolvedContact,
    estimate::{ContactPoints, SolutionData, displacements, multipliers_at},
};
use crate::{
    contact::Ellipse,
    elasticity::MaterialField,
    linalg::ratio,
    mesh::{ContactSurface, Mesh},
    reference::QUADRATIC_TRIANGLE_NODES,
    scene::{Functional, Scene},
};

/// Share of a pane by which a level line may lie away.
const LINE_SHIFT: f64 = 0.15;

/// Errors of pressures and of slip bounds beside the relative error in the energy norm.
const PRESSURE_ERROR: f64 = 0.75;
const BOUND_ERROR: f64 = 1.5;

/// Steps of Newton's method for c; more change no digit that is printed.
const EXCESS_STEPS: usize = 8;

/// Fewest panes that tell an area.
pub(super) const FEWEST_PANES: usize = 16;

/// Largest ‖τ‖_𝓕 that counts, so that ψ has a zero between nodes where the ellipse vanishes at one of them.
const LARGEST_LEVEL: f64 = 10.0;

/// The areas of contact and of stick with their ranges, for the stiffness k of each pane; of the wanted one with what each tetrahedron contributes to its range.
pub(super) fn areas(
    solved: &Solved<'_>,
    known: &SolutionData<'_>,
    energy: &ErrorEstimate,
    stiffness: &[f64],
    wanted: Option<Functional>,
) -> Vec<FunctionalEstimate> {
    let Some(contact) = &solved.contact else {
        return Vec::new();
    };
    let margins = Margins::new(solved, contact, known, stiffness);
    let error = energy.relative();
    let sharper = (error / LINE_SHIFT).sqrt().min(1.0);
    let of_contact = ErrorOfMargin {
        functional: Functional::ContactArea,
        margin: 0,
        of_line: sharper,
        of_gap: 1.0,
        of_pressure: sharper * PRESSURE_ERROR * margins.sizes[0] * error,
    };
    let of_stick = ErrorOfMargin {
        functional: Functional::StickArea,
        margin: 1,
        of_line: 1.0,
        of_gap: ratio(margins.sizes[1], margins.sizes[0]),
        of_pressure: BOUND_ERROR * margins.sizes[1] * error,
    };
    let has_friction = contact.state.interface.has_friction();
    let errors = [of_contact]
        .into_iter()
        .chain(has_friction.then_some(of_stick));
    errors
        .map(|error| margins.area(&error, energy, wanted))
        .collect()
}

/// What a margin is known to.
struct ErrorOfMargin {
    functional: Functional,
    /// 0 for z, 1 for ψ.
    margin: usize,
    /// Factors of the shift of its line, and of pressures by gaps between nodes.
    of_line: f64,
    of_gap: f64,
    /// What the error of pressures adds, in Pa.
    of_pressure: f64,
}

/// z and ψ of the contact face, all in Pa.
struct Margins<'a> {
    solved: &'a Solved<'a>,
    contact: &'a SolvedContact<'a>,
    known: &'a SolutionData<'a>,
    /// −g, s₁, s₂ at the contact nodes in m, `[n_contact_nodes]`.
    moved: Vec<[f64; 3]>,
    /// k in Pa/m, `[n_panes]`.
    stiffness: &'a [f64],
    /// The share of the triangles of each pane that something lies opposite of, `[n_panes]`.
    covered: Vec<f64>,
    /// √2 rms |g − g_h| in m, `[n_contact_facets]`.
    unseen: Vec<f64>,
    /// c/2 in Pa, `[n_panes]`.
    excess: Vec<f64>,
    /// 0.15 rms |Δz̄| and 0.15 rms |Δψ̄|, `[n_panes]`.
    line_shift: Vec<[f64; 2]>,
    /// p̃ and m̃.
    sizes: [f64; 2],
}

impl<'a> Margins<'a> {
    fn new(
        solved: &'a Solved<'a>,
        contact: &'a SolvedContact<'a>,
        known: &'a SolutionData<'a>,
        stiffness: &'a [f64],
    ) -> Self {
        let surface = contact.state.surface;
        let panes = 0..surface.n_panes();
        let mut whole = vec![0.0; surface.n_panes()];
        for (place, facet) in surface.facets.iter().enumerate() {
            if let Some(pane) = surface.pane_of_facet(place) {
                whole[pane] += solved.mesh.facet_area(*facet);
            }
        }
        let covered = surface.pane_area.iter().zip(whole);
        let moved = displacements(contact, known);
        let mut margins = Self {
            covered: covered
                .map(|(area, whole)| (area / whole).min(1.0))
                .collect(),
            solved,
            contact,
            known,
            unseen: ContactPoints::new(solved, contact, known, &moved).unseen(),
            moved,
            stiffness,
            excess: vec![0.0; surface.n_panes()],
            line_shift: vec![[0.0; 2]; surface.n_panes()],
            sizes: [0.0; 2],
        };
        let means: Vec<[f64; 2]> = panes.map(|pane| margins.of_pane(pane)).collect();
        margins.line_shift = margins.line_shifts(&means);
        margins.excess = margins.excesses();
        let pressed = || {
            let states = known.panes.iter().zip(&surface.pane_area);
            states.filter(|(state, _)| state.normal_stress < 0.0)
        };
        margins.sizes = [0, 1].map(|k| {
            root_mean_square(pressed().map(|(state, area)| {
                let axes = state
                    .friction
                    .map_or([0.0; 2], |friction| friction.semi_axes);
                ([-state.normal_stress, (axes[0] + axes[1]) / 2.0][k], *area)
            }))
        });
        margins
    }

    /// z and ψ of some multipliers with their weights, for −g, s₁, s₂ in m.
    fn at(&self, multipliers: &[(usize, f64)], moved: [f64; 3]) -> [f64; 2] {
        let layout = self.contact.coupling.layout;
        let values = &self.solved.solution.multiplier;
        let sum = |of: &dyn Fn(usize) -> f64| -> f64 {
            multipliers
                .iter()
                .map(|(pane, weight)| weight * of(*pane))
                .sum()
        };
        let stiffness = sum(&|pane| self.stiffness[pane]);
        let contact =
            sum(&|pane| values[layout.normal(pane)] - self.excess[pane]) + stiffness * moved[0];
        let shear = [0, 1].map(|k| {
            let of_pane = |pane| layout.tangential(pane).map_or(0.0, |pair| values[pair[k]]);
            sum(&of_pane) + stiffness * moved[k + 1]
        });
        let semi_axes = [0, 1].map(|k| sum(&|pane| self.semi_axes(pane, contact.max(0.0))[k]));
        let size = (semi_axes[0] + semi_axes[1]) / 2.0;
        let level = match shear {
            [0.0, 0.0] => 0.0,
            _ => Ellipse { semi_axes }.level(shear).min(LARGEST_LEVEL),
        };
        let inside = if size > 0.0 {
            size * (1.0 - level)
        } else {
            -shear[0].hypot(shear[1])
        };
        [contact, inside.min(contact)]
    }

    /// The semi-axes of friction on a pane under a pressure in Pa.
    fn semi_axes(&self, pane: usize, pressure: f64) -> [f64; 2] {
        let Some(friction) = &self.known.panes[pane].friction else {
            return [0.0; 2];
        };
        match (friction.coulomb, self.contact.state.interface.coulomb()) {
            (Some(coulomb), Some(law)) => {
                let bound = law.slip_bound(pane, pressure);
                coulomb.coefficients.map(|f| f * bound)
            }
            _ => friction.semi_axes,
        }
    }

    /// z̄ and ψ̄.
    fn of_pane(&self, pane: usize) -> [f64; 2] {
        let nodes = self.contact.state.surface.pane_weights(pane);
        let mut mean = [0.0; 3];
        for (node, weight) in nodes {
            (0..3).for_each(|c| mean[c] += weight * self.moved[node][c]);
        }
        self.at(&[(pane, 1.0)], mean)
    }

    /// c/2 of each pane, by Newton's method on the mean of (z − c)⁺, a convex function of c.
    fn excesses(&self) -> Vec<f64> {
        let surface = self.contact.state.surface;
        let mut parts: Vec<Vec<([f64; 3], f64)>> = vec![Vec::new(); surface.n_panes()];
        for place in 0..surface.facets.len() {
            let Some(pane) = surface.pane_of_facet(place) else {
                continue;
            };
            let nodes = self.contact.nodes_of(self.solved.mesh, place);
            let z: Vec<f64> = nodes
                .iter()
                .map(|node| self.at(&[(pane, 1.0)], self.moved[*node])[0])
                .collect();
            let of_part = parts_of(nodes.len());
            let area = self.area_of(place) / of_part.len() as f64;
            parts[pane].extend(of_part.iter().map(|part| (part.map(|k| z[k]), area)));
        }
        let of_pane = |(pane, parts): (usize, Vec<([f64; 3], f64)>)| {
            let whole: f64 = parts.iter().map(|(_, area)| area).sum();
            let wanted = whole * -self.known.panes[pane].normal_stress;
            let mut c = 0.0;
            for _ in 0..EXCESS_STEPS {
                let shifted = || parts.iter().map(|(z, area)| (z.map(|z| z - c), area));
                let force: f64 = shifted().map(|(z, area)| area * positive_mean(z)).sum();
                let share: f64 = shifted().map(|(z, area)| area * positive_share(z)).sum();
                if share <= 0.0 {
                    break;
                }
                c += (force - wanted) / share;
            }
            0.5 * c.max(0.0)
        };
        parts.into_iter().enumerate().map(of_pane).collect()
    }

    /// What z̄ and ψ̄ change by from each pane to those that share a node with it.
    fn line_shifts(&self, means: &[[f64; 2]]) -> Vec<[f64; 2]> {
        let beside = self.contact.state.surface.panes_beside(self.solved.mesh);
        let of_pane = |(pane, others): (usize, Vec<usize>)| {
            [0, 1].map(|k| {
                let changes = others.iter().map(|&other| means[other][k] - means[pane][k]);
                LINE_SHIFT * root_mean_square(changes.map(|change| (change, 1.0)))
            })
        };
        beside.into_iter().enumerate().map(of_pane).collect()
    }

    /// The area where a margin is positive.
    fn area(
        &self,
        error: &ErrorOfMargin,
        energy: &ErrorEstimate,
        wanted: Option<Functional>,
    ) -> FunctionalEstimate {
        let (mesh, surface) = (self.solved.mesh, self.contact.state.surface);
        let is_pressed = |face: usize| {
            let mut panes = self.known.panes[surface.faces[face].panes.clone()].iter();
            panes.any(|pane| pane.normal_stress < 0.0)
        };
        let is_pressed: Vec<bool> = (0..surface.faces.len()).map(is_pressed).collect();
        let mut indicator = vec![0.0; mesh.tetrahedra.len()];
        let (mut sums, mut by_pressure) = ([0.0; 3], 0.0);
        for (place, tetrahedron) in mesh.behind_contact().into_iter().enumerate() {
            let (mut areas, line_part) = self.areas_of_triangle(place, error);
            // A face without any force may touch, but bears nothing.
            if !is_pressed[surface.face_number(place)] {
                areas = [0.0, 0.0, areas[2]];
            }
            (0..3).for_each(|k| sums[k] += areas[k]);
            let width = areas[2] - areas[1];
            indicator[tetrahedron] += line_part * width;
            by_pressure += (1.0 - line_part) * width;
        }
        if wanted == Some(error.functional) {
            // Pressures are off by what all tetrahedra contribute to the error in the energy norm.
            let square = energy.total().powi(2);
            let shares = indicator.iter_mut().zip(&energy.indicator);
            shares.for_each(|(share, eta)| *share += by_pressure * eta * eta / square);
        }
        let [value, low, high] = sums;
        FunctionalEstimate {
            functional: error.functional,
            value,
            signed_error: (high - value).max(value - low),
            range: [low, high],
            corners: None,
            kinks: 0,
            indicator,
        }
    }

    /// The areas of a contact triangle in m² where a margin is positive, above its error and above the opposite of it; and the part of
    /// that error which is of the line.
    fn areas_of_triangle(&self, place: usize, error: &ErrorOfMargin) -> ([f64; 3], f64) {
        let nodes = self.contact.nodes_of(self.solved.mesh, place);
        let (mut margins, mut errors, mut of_line) = ([0.0; 6], [0.0; 6], 0.0);
        for (k, (&node, share)) in nodes.iter().zip(QUADRATIC_TRIANGLE_NODES).enumerate() {
            let multipliers = self.multipliers_at(place, share);
            margins[k] = self.at(&multipliers, self.moved[node])[error.margin];
            let shifts = multipliers.iter().map(|(pane, weight)| {
                let unseen = self.stiffness[*pane] * self.unseen[place] + self.excess[*pane];
                weight
                    * (error.of_line * self.line_shift[*pane][error.margin] + error.of_gap * unseen)
            });
            let line = shifts.sum::<f64>().max(0.0);
            errors[k] = line + error.of_pressure;
            of_line += line;
        }
        let parts = parts_of(nodes.len());
        let of_part = self.area_of(place) / parts.len() as f64;
        let areas = [0.0, 1.0, -1.0].map(|by| {
            let shares = parts
                .iter()
                .map(|part| part.map(|k| margins[k] - by * errors[k]));
            of_part * shares.map(positive_share).sum::<f64>()
        });
        let whole: f64 = errors.iter().sum();
        (areas, if whole > 0.0 { of_line / whole } else { 1.0 })
    }

    /// The area of a contact triangle in m², as far as its pane has something opposite.
    fn area_of(&self, place: usize) -> f64 {
        let surface = self.contact.state.surface;
        let whole = self.solved.mesh.facet_area(surface.facets[place]);
        let covered = surface.pane_of_facet(place).map(|pane| self.covered[pane]);
        whole * covered.unwrap_or(1.0)
    }

    /// The multipliers at a place of a contact triangle with their weights; where a held node has none, those of the others in the triangle.
    fn multipliers_at(&self, place: usize, share: [f64; 3]) -> Vec<(usize, f64)> {
        let acting = multipliers_at(self.solved.mesh, self.contact, place, share);
        let whole: f64 = acting.iter().map(|(_, weight)| weight).sum();
        if (whole - 1.0).abs() < 1e-9 {
            return acting;
        }
        let surface = self.contact.state.surface;
        let panes = surface.panes_of_facet(self.solved.mesh, place);
        let weight = (panes.len() as f64).recip();
        panes.into_iter().map(|pane| (pane, weight)).collect()
    }
}

/// k of the materials behind each pane and opposite it in Pa/m, `[n_panes]`.
pub(super) fn half_space_stiffness(
    scene: &Scene,
    mesh: &Mesh,
    surface: &ContactSurface,
) -> Vec<f64> {
    let material = MaterialField::new(scene, mesh);
    let mut yielding = vec![0.0; surface.n_panes()];
    for (entry, face) in scene.contact_order().into_iter().zip(&surface.faces) {
        let with_panes = mesh.face_with_panes(surface, face);
        let pair = scene.contacts[entry].between.iter().flatten();
        for other in pair.filter(|other| *other != with_panes) {
            let behind = mesh.behind(mesh.facets_on(other));
            let terms = behind
                .iter()
                .map(|t| 1.0 / material.plane_strain_modulus(*t));
            yielding[face.panes.clone()].fill(terms.sum::<f64>() / behind.len() as f64);
        }
    }
    let mut sums = vec![[0.0; 2]; surface.n_panes()];
    for (place, tetrahedron) in mesh.behind_contact().into_iter().enumerate() {
        let area = mesh.facet_area(surface.facets[place]);
        for pane in surface.panes_of_facet(mesh, place) {
            sums[pane][0] += area * material.plane_strain_modulus(tetrahedron);
            sums[pane][1] += area;
        }
    }
    let panes = sums.iter().zip(&surface.pane_area).zip(yielding);
    panes
        .map(|(([modulus, area], of_pane), opposite)| {
            2.0 / (area / modulus + opposite) / of_pane.sqrt()
        })
        .collect()
}

/// The root of the mean square of values with their weights; 0 of none.
fn root_mean_square(values: impl Iterator<Item = (f64, f64)>) -> f64 {
    let add = |[sum, whole]: [f64; 2], (value, weight): (f64, f64)| {
        [sum + weight * value * value, whole + weight]
    };
    match values.fold([0.0; 2], add) {
        [_, 0.0] => 0.0,
        [sum, whole] => (sum / whole).sqrt(),
    }
}

/// The parts of a contact triangle on which margins are linear, by its nodes.
fn parts_of(n_nodes: usize) -> &'static [[usize; 3]] {
    match n_nodes {
        3 => &[[0, 1, 2]],
        _ => &[[0, 3, 5], [3, 1, 4], [5, 4, 2], [3, 4, 5]],
    }
}

/// The mean over a triangle of the positive part of a linear function with these values at its corners.
fn positive_mean(corners: [f64; 3]) -> f64 {
    let largest = |values: [f64; 3]| values.into_iter().fold(0.0, f64::max);
    match corners.iter().filter(|v| **v > 0.0).count() {
        0 => 0.0,
        1 => positive_share(corners) * largest(corners) / 3.0,
        _ => {
            let negated = corners.map(|v| -v);
            let cut_off = 1.0 - positive_share(corners);
            corners.iter().sum::<f64>() / 3.0 + cut_off * largest(negated) / 3.0
        }
    }
}

/// The share of a triangle in which a linear function with these values at its corners is positive.
fn positive_share(corners: [f64; 3]) -> f64 {
    let negated = corners.map(|v| -v);
    // The corner cut off by the line through zero: f(a)² / (f(a) − f(b)) (f(a) − f(c)) of the triangle.
    let cut_off = |values: [f64; 3]| {
        let [a, b, c] = match values.map(|v| v > 0.0) {
            [true, false, false] => values,
            [false, true, false] => [values[1], values[2], values[0]],
            _ => [values[2], values[0], values[1]],
        };
        a / (a - b) * (a / (a - c))
    };
    match corners.iter().filter(|v| **v > 0.0).count() {
        0 => 0.0,
        1 => cut_off(corners),
        2 if negated.iter().any(|v| *v > 0.0) => 1.0 - cut_off(negated),
        _ => 1.0,
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn lines_cut_triangles_in_closed_form() {
        for (corners, share) in [
            ([1.0, -1.0, -1.0], 0.25),
            ([-1.0, 1.0, 1.0], 0.75),
            ([-2.0, 1.0, -2.0], 1.0 / 9.0),
            ([1.0, 2.0, 0.0], 1.0),
            ([0.0, 0.0, 0.0], 0.0),
            ([3.0, 1.0, -1.0], 1.0 - 1.0 / 8.0),
        ] {
            assert!(
                (positive_share(corners) - share).abs() < 1e-15,
                "{corners:?}"
            );
        }
    }
}
