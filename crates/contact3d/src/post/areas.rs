//! The areas of contact and of stick, and where they lie.
//!
//! A count of panes moves by whole panes and cannot tell how sure it is. Here the conditions of contact are asked inside each pane, whose
//! multiplier λ is a mean; that of a node is one over what its linear function has of the triangles around. A pane has the stiffness κ k of a
//! patch on the share σ of it ([`super::patch`]). So pressure and shear at a place with the gap g and the slip s (along λ_t) are about
//!
//!   z = λ_ν − c − κ k g,   τ = λ_t/σ + κ k s,   ψ = min(m(z⁺) (1 − ‖τ‖_𝓕), z),
//!
//! with the c for which z⁺ has the mean λ_ν, the ellipse 𝓕 of the pressure z⁺ and the mean m of its semi-axes. Contact is where z > 0 and
//! stick where ψ > 0, both linear on the sixteen parts of a triangle.
//!
//! A level line may lie 0.15 of a pane away, by which z changes as much as from pane to pane; and the pressure itself is off by about the
//! relative error η of the energy norm. So z is known to δ = 0.15 rms |Δz̄| + 0.75 η p̃ and ψ to 0.15 rms |Δψ̄| + 1.5 η m̃ + 0.3 p̂, with root
//! mean squares p̃ and m̃ over the pressed face. Waves of the
//! pressure drag a face along a rigid obstacle: p̂ is their amplitude inside the pane, of which shear has the part (1 − 2ν)/(2 − 2ν), 0.3.
//! The areas lie between those with z > δ and z > −δ for κ k, 4/3 of it and 2/3, and not nearer than if the line lay 0.15 away in the panes
//! inside it. The other factors are measured.

use rayon::prelude::*;

use super::{
    ErrorEstimate, FunctionalEstimate, Solved, SolvedContact, Zone,
    estimate::{ContactPoints, SolutionData, displacements, multipliers_at},
    patch::{Opening, PATCH_STEPS, Patch, positive_share},
};
use crate::{
    contact::Ellipse, elasticity::MaterialField, mesh::quarters_of, reference::quadrature,
    scene::Functional,
};

/// Share of a pane by which a level line may lie away.
const LINE_SHIFT: f64 = 0.15;

/// Errors of pressures and of slip bounds over the relative error in the energy norm.
const PRESSURE_ERRORS: [f64; 2] = [0.75, 1.5];

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
    let sizes = margins.sizes.into_iter().zip(PRESSURE_ERRORS);
    let errors = sizes.map(|(size, share)| share * size * energy.relative());
    let has_friction = contact.state.interface.has_friction();
    let errors: Vec<f64> = errors.take(1 + usize::from(has_friction)).collect();
    let places = (0..margins.moved.len()).into_par_iter();
    let of_triangles: Vec<_> = places
        .map(|place| margins.areas_of_triangle(place, &errors))
        .collect();
    let kinds = [Functional::ContactArea, Functional::StickArea].into_iter();
    kinds
        .take(errors.len())
        .enumerate()
        .map(|(margin, functional)| {
            margins.area((margin, functional), &of_triangles, energy, wanted)
        })
        .collect()
}

/// z and ψ of the contact face, all in Pa.
struct Margins<'a> {
    solved: &'a Solved<'a>,
    contact: &'a SolvedContact<'a>,
    known: &'a SolutionData<'a>,
    /// Barycentric coordinates of the corners of the parts of a triangle on which margins are linear.
    parts: Vec<[[f64; 3]; 3]>,
    /// −g, s₁, s₂ at these of each contact triangle in m, `[n_contact_facets]`.
    moved: Vec<Vec<[[f64; 3]; 3]>>,
    /// k in Pa/m, `[n_panes]`.
    stiffness: &'a [f64],
    /// Of each triangle in m², as far as its pane has something opposite, `[n_contact_facets]`.
    area: Vec<f64>,
    /// How each pane may rest on what lies opposite, `[n_panes]`.
    patches: Vec<[Patch; 3]>,
    /// 0.15 rms |Δz̄| and 0.15 rms |Δψ̄| + 0.3 p̂, `[n_panes]`.
    line_shift: Vec<[f64; 2]>,
    /// p̃ and m̃.
    sizes: [f64; 2],
    /// What panes have in m² that are pressed beside open ones, and that stick beside others.
    borders: [f64; 2],
}

impl<'a> Margins<'a> {
    fn new(
        solved: &'a Solved<'a>,
        contact: &'a SolvedContact<'a>,
        known: &'a SolutionData<'a>,
        stiffness: &'a [f64],
    ) -> Self {
        let surface = contact.state.surface;
        let mut whole = vec![0.0; surface.n_panes()];
        let panes = || (0..surface.facets.len()).map(|place| surface.pane_of_facet(place));
        let mut area: Vec<f64> = surface
            .facets
            .iter()
            .map(|facet| solved.mesh.side_integrals(*facet).0)
            .collect();
        for (pane, area) in panes().zip(&area) {
            if let Some(pane) = pane {
                whole[pane] += area;
            }
        }
        for (pane, area) in panes().zip(&mut area) {
            *area *= pane.map_or(1.0, |pane| (surface.pane_area[pane] / whole[pane]).min(1.0));
        }
        let nodal = displacements(contact, known);
        let whole_triangle = [[1.0, 0.0, 0.0], [0.0, 1.0, 0.0], [0.0, 0.0, 1.0]];
        let parts: Vec<_> = quarters_of(&whole_triangle)
            .iter()
            .flat_map(quarters_of)
            .collect();
        let shares: Vec<[f64; 3]> = parts.iter().flatten().copied().collect();
        let at_shares =
            ContactPoints::new(solved, contact, known, &nodal).moved_at(&nodal, &shares);
        let of_parts = |at: Vec<[f64; 3]>| at.as_chunks().0.to_vec();
        let mut margins = Self {
            parts,
            area,
            solved,
            contact,
            known,
            moved: at_shares.into_iter().map(of_parts).collect(),
            stiffness,
            patches: stiffness
                .iter()
                .map(|k| {
                    [Patch {
                        stiffness: *k,
                        ..Patch::default()
                    }; 3]
                })
                .collect(),
            line_shift: vec![[0.0; 2]; surface.n_panes()],
            sizes: [0.0; 2],
            borders: [0.0; 2],
        };
        let means = (0..surface.n_panes()).map(|pane| margins.of_pane(&nodal, pane));
        let means: Vec<[f64; 2]> = means.collect();
        let beside = surface.panes_beside(solved.mesh);
        margins.line_shift = line_shifts(&means, &beside);
        margins.patches = margins.settled(&beside);
        for (shift, [patch, ..]) in margins.line_shift.iter_mut().zip(&margins.patches) {
            shift[1] += DRAG * patch.wave;
        }
        let is_in = |pane: &usize, margin: usize| match margin {
            0 => known.panes[*pane].zone != Zone::Open,
            _ => known.panes[*pane].zone == Zone::Stick,
        };
        margins.borders = [0, 1].map(|margin| {
            let inside = (0..surface.n_panes()).filter(|pane| is_in(pane, margin));
            let at_border =
                inside.filter(|pane| beside[*pane].iter().any(|other| !is_in(other, margin)));
            at_border.map(|pane| surface.pane_area[pane]).sum()
        });
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

    /// z and ψ by a multiplier, for −g, s₁, s₂ in m.
    fn at(&self, pane: usize, moved: [f64; 3], kind: usize) -> [f64; 2] {
        let layout = self.contact.coupling.layout;
        let values = &self.solved.solution.multiplier;
        let patch = self.patches[pane][kind];
        let contact = values[layout.normal(pane)] - patch.excess + patch.stiffness * moved[0];
        let pair = layout.tangential(pane);
        let pair = pair.map_or([0.0; 2], |pair| pair.map(|j| values[j]));
        let shear = [0, 1].map(|k| pair[k] / (1.0 - patch.open) + patch.stiffness * moved[k + 1]);
        let semi_axes = self.semi_axes(pane, contact.max(0.0));
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
        self.at(pane, mean, 0)
    }

    /// The patches of all panes, of which those that share a node with a pane are `beside` it.
    fn settled(&self, beside: &[Vec<usize>]) -> Vec<[Patch; 3]> {
        let (mesh, surface) = (self.solved.mesh, self.contact.state.surface);
        let n_panes = surface.n_panes();
        let mut openings: Vec<Opening> = (0..n_panes).map(|_| Opening::default()).collect();
        for (place, moved) in self.moved.iter().enumerate() {
            let corners = mesh.corners(&mesh.facets[surface.facets[place]]);
            let area = self.area[place] / moved.len() as f64;
            for (part, at) in self.parts.iter().zip(moved) {
                let corners = part.map(|share| quadrature::point(&corners, &share));
                for (pane, weight) in self.multipliers_of(place, part) {
                    openings[pane].add(corners, at.map(|at| at[0]), weight * area);
                }
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
                (sum + 1.0 - patches[*pane].open, n + 1.0)
            });
            let narrower = (n / sum).powf(openings[pane].exponent());
            of_waves[pane] * (1.0 + 3.0 * narrower) / 4.0
        };
        let settled = |pane: usize, stiffness: f64| match is_pressed(&pane) {
            true => openings[pane].settled(pressure(pane), stiffness),
            false => Patch {
                stiffness,
                ..Patch::default()
            },
        };
        let panes = (0..n_panes).into_par_iter();
        let mut patches: Vec<Patch> = self.patches.iter().map(|kinds| kinds[0]).collect();
        for _ in 0..PATCH_STEPS {
            let next = panes
                .clone()
                .map(|pane| settled(pane, stiffness(&patches, pane)));
            patches = next.collect();
        }
        let of_pane = |pane| {
            let (stiffness, sway) = (stiffness(&patches, pane), openings[pane].amplitude());
            let wave = if is_pressed(&pane) {
                stiffness * sway
            } else {
                0.0
            };
            STIFFNESS.map(|by| Patch {
                wave,
                ..settled(pane, by * stiffness)
            })
        };
        panes.map(of_pane).collect()
    }

    /// The area where z or ψ is positive.
    fn area(
        &self,
        (margin, functional): (usize, Functional),
        of_triangles: &[Vec<([f64; 3], f64)>],
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
            let (mut areas, line_part) = of_triangles[place][margin];
            // A face without any force may touch, but bears nothing.
            if !is_pressed[surface.face_number(place)] {
                areas = [0.0, 0.0, areas[2]];
            }
            (0..3).for_each(|k| sums[k] += areas[k]);
            let width = areas[2] - areas[1];
            indicator[tetrahedron] += line_part * width;
            by_pressure += (1.0 - line_part) * width;
        }
        if wanted == Some(functional) {
            // Pressures are off by what all tetrahedra contribute to the error in the energy norm.
            let square = energy.total().powi(2);
            let shares = indicator.iter_mut().zip(&energy.indicator);
            shares.for_each(|(share, eta)| *share += by_pressure * eta * eta / square);
        }
        // However steep its rise, a line is not known better.
        let [value, low, high] = sums;
        let shift = LINE_SHIFT * self.borders[margin];
        let low = low.min(value - shift).max(0.0);
        let high = high.max((value + shift).min(self.area.iter().sum()));
        FunctionalEstimate {
            functional,
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
    fn areas_of_triangle(&self, place: usize, errors: &[f64]) -> Vec<([f64; 3], f64)> {
        let of_part = self.area[place] / self.parts.len() as f64;
        // Of each margin its area, that above errors and that above the opposite of them for each stiffness.
        let mut sums = [[[0.0; 3]; 3]; 2];
        let mut error_sums = [[0.0; 2]; 2];
        for (part, moved) in self.parts.iter().zip(&self.moved[place]) {
            for (pane, weight) in self.multipliers_of(place, part) {
                let margins = [0, 1, 2].map(|kind| moved.map(|at| self.at(pane, at, kind)));
                for (m, of_pressure) in errors.iter().enumerate() {
                    let line = self.line_shift[pane][m];
                    let whole = line + of_pressure;
                    for (sums, by) in sums[m].iter_mut().zip([0.0, -whole, whole]) {
                        for (sum, z) in sums.iter_mut().zip(&margins) {
                            *sum += weight * of_part * positive_share(z.map(|z| z[m] + by));
                        }
                    }
                    error_sums[m][0] += weight * line;
                    error_sums[m][1] += weight * whole;
                }
            }
        }
        let of_margin = |m: usize| {
            let [value, low, high] = sums[m];
            let low = low.into_iter().fold(f64::INFINITY, f64::min);
            let high = high.into_iter().fold(0.0, f64::max);
            let [of_line, whole] = error_sums[m];
            let of_line = if whole > 0.0 { of_line / whole } else { 1.0 };
            ([value[0], low, high], of_line)
        };
        (0..errors.len()).map(of_margin).collect()
    }

    /// The multipliers that press a part of a contact triangle, with what each has of it; where held nodes have none, the others.
    fn multipliers_of(&self, place: usize, part: &[[f64; 3]; 3]) -> Vec<(usize, f64)> {
        let middle = [0, 1, 2].map(|k| part.iter().map(|share| share[k]).sum::<f64>() / 3.0);
        let mut acting = multipliers_at(self.solved.mesh, self.contact, place, middle);
        acting.retain(|(_, weight)| *weight > 0.0);
        if acting.is_empty() {
            let surface = self.contact.state.surface;
            acting = surface
                .panes_of_facet(self.solved.mesh, place)
                .into_iter()
                .map(|pane| (pane, 1.0))
                .collect();
        }
        let whole: f64 = acting.iter().map(|(_, weight)| weight).sum();
        acting.iter_mut().for_each(|(_, weight)| *weight /= whole);
        acting
    }
}

/// k of the materials behind each pane and opposite it in Pa/m, `[n_panes]`.
pub(super) fn half_space_stiffness(solved: &Solved<'_>) -> Vec<f64> {
    let Some(contact) = &solved.contact else {
        return Vec::new();
    };
    let (scene, mesh, surface) = (solved.scene, solved.mesh, contact.state.surface);
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
