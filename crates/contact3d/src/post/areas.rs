//! The areas of contact and of stick, and where they lie.
//!
//! A count of panes moves by whole panes and cannot tell how sure it is. Here the conditions of contact are asked inside each pane, whose
//! multiplier λ is a mean. A half-space resists waves of the number K like
//!
//!   k = E* K/2,  K² = ∫ |∇g|² / ∫ (g − ḡ)²,  1/E* = (1 − ν²)/E, of two bodies the sum of both,
//!
//! where g is what the mesh leaves between face and obstacle inside the pane; an open pane has k = 2 E*/h, h = √|R|. The narrower the share
//! σ of a pane that is pressed, the more it resists: κ k with κ = (1 + 3 σ̄⁻ⁿ)/4, n = 1 where g varies along one direction and 1/2 where
//! along two, of the mean σ̄ over the pressed panes around. Of waves a (1 − cos Kx), which a pressure λ_ν = k a sin²(πσ/2) closes so far
//! (H. M. Westergaard 1939), κ is that to a ninth. So pressure and shear at a place with the gap g and the slip s (along λ_t) are about
//!
//!   z = λ_ν − c − κ k g,   τ = λ_t/σ + κ k s,   ψ = min(m(z⁺) (1 − ‖τ‖_𝓕), z),
//!
//! with the c for which z⁺ has the mean λ_ν, the ellipse 𝓕 of the pressure z⁺ and the mean m of its semi-axes. Contact is where z > 0 and
//! stick where ψ > 0, both linear on the sixteen parts of a triangle.
//!
//! A level line may lie 0.15 of a pane away, by which z changes as much as from pane to pane; and the pressure itself is off by about the
//! relative error η of the energy norm. So z is known to δ = 0.15 rms |Δz̄| + 0.75 η p̃ and ψ to 0.15 rms |Δψ̄| + 1.5 η m̃ + 0.3 p̂, with root
//! mean squares p̃ and m̃ over the pressed face; where η is small, lines of contact are better known than that by √(η/0.15). Waves of the
//! pressure drag a face along a rigid obstacle: p̂ is their amplitude inside the pane, of which shear has the part (1 − 2ν)/(2 − 2ν), 0.3.
//! The areas lie between those with z > δ and z > −δ for κ k, 4/3 of it and 2/3. The other factors are measured.

use nalgebra::{Matrix3, Matrix3x2, Vector2, Vector3};
use rayon::prelude::*;

use super::{
    ErrorEstimate, FunctionalEstimate, Solved, SolvedContact,
    estimate::{ContactPoints, SolutionData, displacements, multipliers_at},
};
use crate::{
    contact::Ellipse,
    elasticity::MaterialField,
    linalg::ratio,
    mesh::{ContactSurface, Mesh, quarters_of},
    reference::quadrature,
    scene::{Functional, Scene},
};

/// Share of a pane by which a level line may lie away.
const LINE_SHIFT: f64 = 0.15;

/// Errors of pressures and of slip bounds beside the relative error in the energy norm.
const PRESSURE_ERROR: f64 = 0.75;
const BOUND_ERROR: f64 = 1.5;

/// Steps of Newton's method for c, and for the stiffness of a patch; more change no digit that is printed.
const PATCH_STEPS: usize = 8;

/// The stiffness of a patch and what it may be instead, over κ k.
const STIFFNESS: [f64; 3] = [1.0, 4.0 / 3.0, 2.0 / 3.0];

/// Shear of a face without slip on a rigid obstacle, over waves of the pressure.
const DRAG: f64 = 0.3;

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
        of_wave: 0.0,
        of_pressure: sharper * PRESSURE_ERROR * margins.sizes[0] * error,
    };
    let of_stick = ErrorOfMargin {
        functional: Functional::StickArea,
        margin: 1,
        of_line: 1.0,
        of_wave: DRAG,
        of_pressure: BOUND_ERROR * margins.sizes[1] * error,
    };
    let has_friction = contact.state.interface.has_friction();
    let errors = [of_contact, of_stick];
    let places = (0..margins.moved.len()).into_par_iter();
    let of_triangles: Vec<_> = places
        .map(|place| margins.areas_of_triangle(place, &errors))
        .collect();
    let told = &errors[..1 + usize::from(has_friction)];
    told.iter()
        .map(|error| margins.area(error, &of_triangles, energy, wanted))
        .collect()
}

/// What a margin is known to.
struct ErrorOfMargin {
    functional: Functional,
    /// 0 for z, 1 for ψ.
    margin: usize,
    /// Factors of the shift of its line and of waves inside panes.
    of_line: f64,
    of_wave: f64,
    /// What the error of pressures adds, in Pa.
    of_pressure: f64,
}

/// How a pane rests on what lies opposite.
#[derive(Clone, Copy)]
struct Patch {
    /// κ k in Pa/m.
    stiffness: f64,
    /// c in Pa.
    excess: f64,
    /// σ, the share of the pane with z > 0.
    share: f64,
    /// p̂ in Pa.
    wave: f64,
}

impl Patch {
    /// All of a pane.
    fn whole(stiffness: f64) -> Self {
        Self {
            stiffness,
            excess: 0.0,
            share: 1.0,
            wave: 0.0,
        }
    }
}

/// −g inside a pane.
#[derive(Default)]
struct Opening {
    /// In m at the corners of parts of the pane, with their areas.
    depths: Vec<([f64; 3], f64)>,
    /// ∫ ∇g ∇gᵀ in m².
    slopes: Matrix3<f64>,
}

impl Opening {
    /// Adds a part with its corners.
    fn add(&mut self, corners: [[f64; 3]; 3], depths: [f64; 3], area: f64) {
        let [a, b, c] = corners.map(Vector3::from);
        let edges = Matrix3x2::from_columns(&[b - a, c - a]);
        let rises = Vector2::new(depths[1] - depths[0], depths[2] - depths[0]);
        if let Some(inverse) = (edges.transpose() * edges).try_inverse() {
            let slope = edges * (inverse * rises);
            self.slopes += slope * slope.transpose() * area;
        }
        self.depths.push((depths, area));
    }

    fn mean(&self, of: impl Fn([f64; 3]) -> f64) -> f64 {
        let terms = || self.depths.iter();
        terms().map(|(at, area)| area * of(*at)).sum::<f64>()
            / terms().map(|(_, area)| area).sum::<f64>()
    }

    /// The mean of (g − ḡ)² in m².
    fn variance(&self) -> f64 {
        let mean = self.mean(|at| at.iter().sum::<f64>() / 3.0);
        self.mean(|at| {
            let off = at.map(|depth| depth - mean);
            (off.iter().map(|d| d * d).sum::<f64>() + off.iter().sum::<f64>().powi(2)) / 12.0
        })
    }

    /// K in 1/m.
    fn wave_number(&self) -> f64 {
        let whole: f64 = self.depths.iter().map(|(_, area)| area).sum();
        ratio(self.slopes.trace(), whole * self.variance()).sqrt()
    }

    /// n: 1 of waves along one direction, 1/2 of those along two.
    fn exponent(&self) -> f64 {
        let trace = self.slopes.trace();
        let of_two = 2.0 * (1.0 - ratio((self.slopes * self.slopes).trace(), trace * trace));
        1.0 - 0.5 * of_two.clamp(0.0, 1.0)
    }

    /// The patch of a pressure in Pa for a stiffness in Pa/m, by Newton's method for c on the mean of z⁺, a convex function.
    fn settled(&self, pressure: f64, stiffness: f64) -> Patch {
        let trial = |at: [f64; 3]| at.map(|depth| pressure + stiffness * depth);
        let mut patch = Patch {
            stiffness,
            // As if all of it were pressed, when the mean of z is linear in c.
            excess: self.mean(|at| trial(at).iter().sum::<f64>() / 3.0) - pressure,
            share: 1.0,
            wave: stiffness * (2.0 * self.variance()).sqrt(),
        };
        for _ in 0..PATCH_STEPS {
            let z = |at| trial(at).map(|z| z - patch.excess);
            let force = self.mean(|at| positive_mean(z(at)));
            let share = self.mean(|at| positive_share(z(at)));
            if share > 0.0 {
                patch.share = share;
            }
            // Convex, so c comes up to its root from below.
            if share <= 0.0 || force - pressure <= 1e-9 * pressure {
                break;
            }
            patch.excess += (force - pressure) / share;
        }
        patch
    }
}

/// z and ψ of the contact face, all in Pa.
struct Margins<'a> {
    solved: &'a Solved<'a>,
    contact: &'a SolvedContact<'a>,
    known: &'a SolutionData<'a>,
    /// −g, s₁, s₂ at the corners of the parts of each contact triangle in m, `[n_contact_facets]`.
    moved: Vec<Vec<[[f64; 3]; 3]>>,
    /// k in Pa/m, `[n_panes]`.
    stiffness: &'a [f64],
    /// The share of the triangles of each pane that something lies opposite of, `[n_panes]`.
    covered: Vec<f64>,
    /// How each pane may rest on what lies opposite, `[n_panes]`.
    patches: Vec<[Patch; 3]>,
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
        let nodal = displacements(contact, known);
        let shares: Vec<[f64; 3]> = parts().into_iter().flatten().collect();
        let at_shares =
            ContactPoints::new(solved, contact, known, &nodal).moved_at(&nodal, &shares);
        let of_parts = |at: Vec<[f64; 3]>| at.as_chunks().0.to_vec();
        let mut margins = Self {
            covered: covered
                .map(|(area, whole)| (area / whole).min(1.0))
                .collect(),
            solved,
            contact,
            known,
            moved: at_shares.into_iter().map(of_parts).collect(),
            stiffness,
            patches: stiffness.iter().map(|k| [Patch::whole(*k); 3]).collect(),
            line_shift: vec![[0.0; 2]; surface.n_panes()],
            sizes: [0.0; 2],
        };
        let means: Vec<[f64; 2]> = panes.map(|pane| margins.of_pane(&nodal, pane)).collect();
        let beside = surface.panes_beside(solved.mesh);
        margins.line_shift = line_shifts(&means, &beside);
        margins.patches = margins.settled(&beside);
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
    fn at(&self, multipliers: &[(usize, f64)], moved: [f64; 3], kind: usize) -> [f64; 2] {
        let layout = self.contact.coupling.layout;
        let values = &self.solved.solution.multiplier;
        let sum = |of: &dyn Fn(usize, Patch) -> f64| -> f64 {
            let terms = multipliers.iter();
            terms
                .map(|(pane, weight)| weight * of(*pane, self.patches[*pane][kind]))
                .sum()
        };
        let stiffness = sum(&|_, patch| patch.stiffness);
        let contact =
            sum(&|pane, patch| values[layout.normal(pane)] - patch.excess) + stiffness * moved[0];
        let shear = [0, 1].map(|k| {
            let of_pane = |pane, patch: Patch| {
                layout
                    .tangential(pane)
                    .map_or(0.0, |pair| values[pair[k]] / patch.share)
            };
            sum(&of_pane) + stiffness * moved[k + 1]
        });
        let semi_axes = [0, 1].map(|k| sum(&|pane, _| self.semi_axes(pane, contact.max(0.0))[k]));
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

    /// z̄ and ψ̄ for −g, s₁, s₂ at the contact nodes in m.
    fn of_pane(&self, nodal: &[[f64; 3]], pane: usize) -> [f64; 2] {
        let mut mean = [0.0; 3];
        for (node, weight) in self.contact.state.surface.pane_weights(pane) {
            (0..3).for_each(|c| mean[c] += weight * nodal[node][c]);
        }
        self.at(&[(pane, 1.0)], mean, 0)
    }

    /// The patches of all panes, of which those that share a node with a pane are `beside` it.
    fn settled(&self, beside: &[Vec<usize>]) -> Vec<[Patch; 3]> {
        let (mesh, surface) = (self.solved.mesh, self.contact.state.surface);
        let n_panes = surface.n_panes();
        let mut openings: Vec<Opening> = (0..n_panes).map(|_| Opening::default()).collect();
        for (place, moved) in self.moved.iter().enumerate() {
            let Some(pane) = surface.pane_of_facet(place) else {
                continue;
            };
            let corners = mesh.corners(&mesh.facets[surface.facets[place]]);
            let area = self.area_of(place) / moved.len() as f64;
            for (part, at) in parts().iter().zip(moved) {
                let corners = part.map(|share| quadrature::point(&corners, &share));
                openings[pane].add(corners, at.map(|at| at[0]), area);
            }
        }
        let pressure = |pane: usize| -self.known.panes[pane].normal_stress;
        let is_pressed = |pane: &usize| pressure(*pane) > 0.0 && !openings[*pane].depths.is_empty();
        // E* K/2 from k = 2 E*/h.
        let of_waves = |(pane, opening): (usize, &Opening)| {
            self.stiffness[pane] * opening.wave_number() * surface.pane_area[pane].sqrt() / 4.0
        };
        let of_waves: Vec<f64> = openings.iter().enumerate().map(of_waves).collect();
        let stiffness = |patches: &[Patch], pane: usize| {
            if !is_pressed(&pane) {
                return self.stiffness[pane];
            }
            let around = beside[pane]
                .iter()
                .chain([&pane])
                .filter(|pane| is_pressed(pane));
            let (sum, n) = around.fold((0.0, 0.0), |(sum, n), pane| {
                (sum + patches[*pane].share, n + 1.0)
            });
            let narrower = (n / sum).powf(openings[pane].exponent());
            of_waves[pane] * (1.0 + 3.0 * narrower) / 4.0
        };
        let settled = |pane: usize, stiffness: f64| match is_pressed(&pane) {
            true => openings[pane].settled(pressure(pane), stiffness),
            false => Patch::whole(stiffness),
        };
        let panes = (0..n_panes).into_par_iter();
        let mut patches: Vec<Patch> = self.stiffness.iter().map(|k| Patch::whole(*k)).collect();
        for _ in 0..PATCH_STEPS {
            let next = panes
                .clone()
                .map(|pane| settled(pane, stiffness(&patches, pane)));
            patches = next.collect();
        }
        let of_pane = |pane| STIFFNESS.map(|by| settled(pane, by * stiffness(&patches, pane)));
        panes.map(of_pane).collect()
    }

    /// The area where a margin is positive.
    fn area(
        &self,
        error: &ErrorOfMargin,
        of_triangles: &[[([f64; 3], f64); 2]],
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
            let (mut areas, line_part) = of_triangles[place][error.margin];
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

    /// The areas of a contact triangle in m² where z and ψ are positive, above their errors and above the opposite of them; and the part of
    /// those errors which is of the line.
    fn areas_of_triangle(&self, place: usize, errors: &[ErrorOfMargin; 2]) -> [([f64; 3], f64); 2] {
        let of_pane = self.contact.state.surface.pane_of_facet(place);
        let of_pane = of_pane.map(|pane| vec![(pane, 1.0)]);
        let corner = |share: [f64; 3], moved: [f64; 3]| {
            let multipliers = of_pane
                .clone()
                .unwrap_or_else(|| self.multipliers_at(place, share));
            let margins = [0, 1, 2].map(|kind| self.at(&multipliers, moved, kind));
            let lines = errors.each_ref().map(|error| {
                let of_pane = |(pane, weight): &(usize, f64)| {
                    let shift = error.of_line * self.line_shift[*pane][error.margin];
                    weight * (shift + error.of_wave * self.patches[*pane][0].wave)
                };
                multipliers.iter().map(of_pane).sum::<f64>().max(0.0)
            });
            (margins, lines)
        };
        let parts = parts().into_iter().zip(&self.moved[place]);
        let parts: Vec<[_; 3]> = parts
            .map(|(part, moved)| std::array::from_fn(|k| corner(part[k], moved[k])))
            .collect();
        let of_part = self.area_of(place) / parts.len() as f64;
        errors.each_ref().map(|error| {
            let m = error.margin;
            let area = |kind: usize, by: f64| {
                let shares = parts.iter().map(|part| {
                    positive_share(part.map(|(margins, lines)| {
                        margins[kind][m] - by * (lines[m] + error.of_pressure)
                    }))
                });
                of_part * shares.sum::<f64>()
            };
            let [lows, highs] = [1.0, -1.0].map(|by| [0, 1, 2].map(|kind| area(kind, by)));
            let low = lows.into_iter().fold(f64::INFINITY, f64::min);
            let high = highs.into_iter().fold(0.0, f64::max);
            let of_line: f64 = parts.iter().flatten().map(|(_, lines)| lines[m]).sum();
            let whole = of_line + 3.0 * parts.len() as f64 * error.of_pressure;
            (
                [area(0, 0.0), low, high],
                if whole > 0.0 { of_line / whole } else { 1.0 },
            )
        })
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

/// The parts of a contact triangle on which margins are linear, by barycentric coordinates.
fn parts() -> Vec<[[f64; 3]; 3]> {
    let whole = [[1.0, 0.0, 0.0], [0.0, 1.0, 0.0], [0.0, 0.0, 1.0]];
    quarters_of(&whole).iter().flat_map(quarters_of).collect()
}

/// What z̄ and ψ̄ change by from each pane to those that share a node with it.
fn line_shifts(means: &[[f64; 2]], beside: &[Vec<usize>]) -> Vec<[f64; 2]> {
    let of_pane = |(pane, others): (usize, &Vec<usize>)| {
        [0, 1].map(|k| {
            let changes = others.iter().map(|&other| means[other][k] - means[pane][k]);
            LINE_SHIFT * root_mean_square(changes.map(|change| (change, 1.0)))
        })
    };
    beside.iter().enumerate().map(of_pane).collect()
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
    use std::f64::consts::PI;

    use super::*;

    /// Strips of a pane as long as a wave close as far as Westergaard's solution says.
    #[test]
    fn waves_close_as_in_closed_form() {
        let mut wave = Opening::default();
        for k in 0..200 {
            let [from, to] = [k, k + 1].map(|k| f64::from(k) / 200.0);
            let depth = |x: f64| (2.0 * PI * x).cos() - 1.0;
            wave.add(
                [[from, 0.0, 0.0], [to, 0.0, 0.0], [from, 1.0, 0.0]],
                [from, to, from].map(depth),
                1.0,
            );
            wave.add(
                [[to, 1.0, 0.0], [from, 1.0, 0.0], [to, 0.0, 0.0]],
                [to, from, to].map(depth),
                1.0,
            );
        }
        // 200 straight pieces of a wave.
        assert!((wave.wave_number() / (2.0 * PI) - 1.0).abs() < 1e-3);
        assert!((wave.exponent() - 1.0).abs() < 1e-12);
        for share in [0.05, 0.3, 0.6, 0.95] {
            let pressure = (PI * share / 2.0).sin().powi(2);
            let found = wave.settled(pressure, (1.0 + 3.0 / share) / 4.0).share;
            // A stiffness off by a ninth moves the edge by its third.
            assert!((found / share - 1.0).abs() < 0.04, "{found} {share}");
        }
    }

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
