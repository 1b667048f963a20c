//! The largest pressure: how well the panes around it resolve it, and whether it has a limit.
//!
//! A pane holds a mean. Where the pressure is smooth the panes beside the largest hardly differ from it; at a sharp edge or at the rim of a
//! clamp it grows with every finer mesh and only the last pane is steep. With the largest pressure p of pane i, its neighbour j of the
//! greatest fall and the pane k behind j in the same direction, d₁ = (p − p_j)/p and d₂ = (p_j − p_k)/p tell the three cases apart
//! ([`PeakShape`]). The bounds are measured: over 29 scenes no peak that converges was taken for one that grows, and the error bars of
//! resolved ones held in 14 of 14.
//!
//! Contact without friction on something rigid holds the normal alone. Theory knows where that leaves stress without a bound
//! ([`Concentrations`](super::concentration::Concentrations)), and pressure with it; d₁ and d₂ tell edges of other contact, and those at
//! which the gap jumps.

use std::collections::{BTreeMap, BTreeSet};

use nalgebra::Matrix3;

use super::{
    FunctionalEstimate, Solved, SolvedContact, Zone,
    areas::FEWEST_PANES,
    concentration::{JUMP, is_mirror, normal_at},
    estimate::{SolutionData, multipliers_at},
};
use crate::{mesh::Mesh, reference::quadrature, scene::Functional};

/// What the panes around the largest pressure say of it.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(super) enum PeakShape {
    /// d₁ ≤ 0.1 and |d₂| ≤ 0.2 of not too few panes: known to the larger of both, and to 2 % at best.
    Resolved,
    /// Fewer than some three panes across it: known to d₁, and to 20 % at best.
    Coarse,
    /// Larger on every finer mesh: with d₁ ≥ 0.02 where theory knows no bound, elsewhere at an edge of the face that is no plane of symmetry with
    /// d₁ ≥ 0.12 and d₂ < d₁/3, and −0.25 ≤ d₂ < 0 if d₁ > 0.75. Pane j is pressed.
    Growing,
}

/// An open pane beside the largest pressure belongs to a sharp edge if closing it would take this many times that pressure.
const EDGE_STIFFNESS: f64 = 10.0;

/// The largest pressure as a quantity, with the box of its pane, for the stiffness of each pane in Pa/m and the largest pressure of a point
/// inside panes in Pa; `None` without contact forces.
pub(super) fn largest_pressure(
    solved: &Solved<'_>,
    known: &SolutionData<'_>,
    stiffness: &[f64],
    inside: f64,
) -> Option<FunctionalEstimate> {
    let (contact, panes) = (solved.contact.as_ref()?, known.panes);
    let pressure = |pane: usize| -panes[pane].normal_stress;
    let highest = (0..panes.len()).max_by(|a, b| pressure(*a).total_cmp(&pressure(*b)))?;
    let largest = pressure(highest);
    if largest <= 0.0 {
        return None;
    }
    // Without a formula a face presses unevenly inside panes by what interpolation makes of it, less than this unless it is tilted.
    let mut features = solved.scene.contact_features().into_iter();
    let is_flat = features.all(|face| face.obstacle.is_none() && face.gap.is_none());
    let is_uneven = inside > 2.0 * largest;
    let bar = match shape_of_peak((solved, contact), known, stiffness, highest) {
        (PeakShape::Resolved, falls) => largest * falls[0].max(falls[1].abs()).max(0.02),
        // What looks like an edge may be a trough between waves that panes do not see.
        (PeakShape::Growing, _) if !is_uneven || is_level(solved, contact, highest) => {
            f64::INFINITY
        }
        (_, falls) => largest * falls[0].max(0.2),
    };
    let bar = match is_uneven || !is_flat {
        true => bar.max(inside - largest),
        false => bar,
    };
    let below = if bar.is_infinite() { 0.0 } else { bar };
    Some(FunctionalEstimate {
        functional: Functional::LargestPressure,
        value: largest,
        signed_error: bar,
        range: [(largest - below).max(0.0), largest + bar],
        corners: Some(box_of(solved, contact, highest)),
        kinks: 0,
        indicator: Vec::new(),
    })
}

/// The contact triangles that a pane acts on.
fn facets_of(solved: &Solved<'_>, contact: &SolvedContact<'_>, pane: usize) -> Vec<usize> {
    let surface = contact.state.surface;
    let places = 0..surface.facets.len();
    let here = places.filter(|it| surface.panes_of_facet(solved.mesh, *it).contains(&pane));
    here.map(|place| surface.facets[place]).collect()
}

/// Whether the half-space behind a face is the same distance away all over a pane.
fn is_level(solved: &Solved<'_>, contact: &SolvedContact<'_>, pane: usize) -> bool {
    let (mesh, surface) = (solved.mesh, contact.state.surface);
    let features = &solved.scene.contact_features()[surface.face_of_pane(pane)];
    let Some(gap) = &features.gap else {
        return features.obstacle.is_none();
    };
    let facets = facets_of(solved, contact, pane).into_iter();
    let mut gaps = facets.flat_map(|facet| {
        let corners = mesh.corners(&mesh.facets[facet]);
        quadrature::triangle_4().map(move |(share, _)| gap.at(quadrature::point(&corners, &share)))
    });
    let first = gaps.next();
    features.obstacle.is_none() && gaps.all(|gap| Some(gap) == first)
}

/// The shape of the peak with d₁ and d₂.
fn shape_of_peak(
    (solved, contact): (&Solved<'_>, &SolvedContact<'_>),
    known: &SolutionData<'_>,
    stiffness: &[f64],
    highest: usize,
) -> (PeakShape, [f64; 2]) {
    let (panes, concentrations) = (known.panes, known.concentrations);
    let (neighbours, ends_at_edge) = neighbours((solved, contact), &concentrations.clamped);
    let facets = facets_of(solved, contact, highest);
    let is_known = facets.iter().any(|&it| concentrations.is_supported(it));
    let has_bound = !is_known || concentrations.of_facets(facets).is_none();
    let pressure = |pane: usize| -panes[pane].normal_stress;
    let largest = pressure(highest);
    let is_beyond_edge = |pane: &usize| {
        let state = &panes[*pane];
        state.zone == Zone::Open && stiffness[*pane] * state.gap > EDGE_STIFFNESS * largest
    };
    let beside = &neighbours[highest];
    let at_edge = !is_known && ends_at_edge[highest] || beside.iter().any(is_beyond_edge);
    let lower = beside.iter().copied().filter(|pane| !is_beyond_edge(pane));
    let Some(next) = lower.min_by(|a, b| pressure(*a).total_cmp(&pressure(*b))) else {
        return (PeakShape::Coarse, [1.0, 0.0]);
    };
    let first = (largest - pressure(next)) / largest;
    let is_pressed = pressure(next) > 0.0;
    // What curves away may end before the edge.
    let reaches_edge = panes.len() >= FEWEST_PANES || is_level(solved, contact, highest);
    if !has_bound && reaches_edge && is_pressed && first >= JUMP {
        return (PeakShape::Growing, [first, 0.0]);
    }
    let Some(behind) = pane_behind(&neighbours[next], (solved, contact), highest, next) else {
        return (PeakShape::Coarse, [first, 0.0]);
    };
    let second = (pressure(next) - pressure(behind)) / largest;
    // A small patch ends beside its peak, but goes on behind a pane that presses a little less than the next; waves do so by more.
    let is_steep = match first <= 0.75 {
        true => second < first / 3.0,
        false => (-0.25..0.0).contains(&second),
    };
    let shape = if at_edge && is_pressed && first >= 0.12 && is_steep {
        PeakShape::Growing
    } else if first <= 0.1 && second.abs() <= 0.2 && panes.len() >= FEWEST_PANES {
        PeakShape::Resolved
    } else {
        PeakShape::Coarse
    };
    (shape, [first, second])
}

/// Which panes share an edge, or nodes with multipliers a triangle, and whether each pane ends at an edge of its contact face.
fn neighbours(
    (solved, contact): (&Solved<'_>, &SolvedContact<'_>),
    clamped: &[Matrix3<f64>],
) -> (Vec<Vec<usize>>, Vec<bool>) {
    let (mesh, surface) = (solved.mesh, contact.state.surface);
    let mut on_edge: BTreeMap<[usize; 3], Vec<Vec<usize>>> = BTreeMap::new();
    let mut beside = vec![Vec::new(); surface.n_panes()];
    for (place, &facet) in surface.facets.iter().enumerate() {
        let corners = mesh.facets[facet];
        let here = surface.panes_of_facet(mesh, place);
        here.iter().for_each(|&pane| beside[pane].extend(&here));
        for (a, b) in [(0, 1), (1, 2), (2, 0)] {
            let ends = [corners[a].min(corners[b]), corners[a].max(corners[b])];
            let mut middle = [0.0; 3];
            (middle[a], middle[b]) = (0.5, 0.5);
            let acting = multipliers_at(mesh, contact, place, middle).into_iter();
            let acting = acting.filter(|(_, weight)| *weight > 0.0);
            let key = [surface.face_number(place), ends[0], ends[1]];
            let sides = on_edge.entry(key).or_default();
            sides.push(acting.map(|(pane, _)| pane).collect());
        }
    }
    let mirrored = mirrored_edges(mesh, clamped);
    let mut at_edge = vec![false; surface.n_panes()];
    for ([_, ends @ ..], sides) in &on_edge {
        let here = sides.concat();
        here.iter().for_each(|&pane| beside[pane].extend(&here));
        if sides.len() == 1 && !mirrored.contains(ends) {
            here.iter().for_each(|&pane| at_edge[pane] = true);
        }
    }
    for (pane, others) in beside.iter_mut().enumerate() {
        others.sort_unstable();
        others.dedup();
        others.retain(|&other| other != pane);
    }
    (beside, at_edge)
}

/// The edges of the boundary triangles that clamps hold along their normal alone, behind which a mirror image of the body goes on.
fn mirrored_edges(mesh: &Mesh, clamped: &[Matrix3<f64>]) -> BTreeSet<[usize; 2]> {
    let held = clamped.iter().enumerate();
    let mirrors = held.filter(|(facet, held)| is_mirror(held, &normal_at(mesh, *facet, 0)));
    let edges = mirrors.flat_map(|(facet, _)| {
        let [a, b, c] = mesh.facets[facet];
        [[a, b], [b, c], [c, a]].map(|[a, b]| [a.min(b), a.max(b)])
    });
    edges.collect()
}

/// The pane behind `next` as seen from `first`, within 45° of that direction.
fn pane_behind(
    beside_next: &[usize],
    (solved, contact): (&Solved<'_>, &SolvedContact<'_>),
    first: usize,
    next: usize,
) -> Option<usize> {
    let centre = |pane| contact.state.surface.pane_centre(solved.mesh, pane);
    let step = |from: [f64; 3], to: [f64; 3]| [0, 1, 2].map(|c| to[c] - from[c]);
    let along = step(centre(first), centre(next));
    let cosine = |pane: usize| {
        let on = step(centre(next), centre(pane));
        let dot = |a: [f64; 3], b: [f64; 3]| -> f64 { (0..3).map(|c| a[c] * b[c]).sum() };
        dot(on, along) / (dot(on, on) * dot(along, along)).sqrt()
    };
    let others = beside_next.iter().filter(|&&pane| pane != first);
    let ahead = others
        .map(|&pane| (cosine(pane), pane))
        .filter(|(cosine, _)| *cosine > 0.5_f64.sqrt());
    ahead
        .max_by(|a, b| a.0.total_cmp(&b.0))
        .map(|(_, pane)| pane)
}

/// Opposite corners in m of the smallest box around the nodes of a pane.
fn box_of(solved: &Solved<'_>, contact: &SolvedContact<'_>, pane: usize) -> [[f64; 3]; 2] {
    let surface = contact.state.surface;
    let end = |c: usize, further: fn(f64, f64) -> f64| {
        let nodes = surface.pane_weights(pane);
        let along = nodes.map(|(node, _)| solved.mesh.coordinates[surface.nodes[node]][c]);
        along.reduce(further).unwrap_or(f64::NAN)
    };
    [f64::min, f64::max].map(|further| [0, 1, 2].map(|c| end(c, further)))
}
