//! The largest pressure: how well the panes around it resolve it, and whether it has a limit.
//!
//! A pane holds a mean. Where the pressure is smooth the panes beside the largest hardly differ from it; at a sharp edge or at the rim of a
//! clamp it grows with every finer mesh and only the last pane is steep. With the largest pressure p of pane i, its neighbour j of the
//! greatest fall and the pane k behind j in the same direction, d₁ = (p − p_j)/p and d₂ = (p_j − p_k)/p tell the three cases apart
//! ([`PeakShape`]). The bounds are measured: over 29 scenes no peak that converges was taken for one that grows, and the error bars of
//! resolved ones held in 14 of 14.
//!
//! Contact without friction on something rigid holds the normal alone: theory knows the edges at which its pressure has no bound
//! ([`Edge::is_singular`](super::concentration::Edge::is_singular)), so that d₁ and d₂ only tell those of other contact.

use std::collections::BTreeMap;

use super::{
    FunctionalEstimate, PaneState, Solved, SolvedContact, Zone,
    areas::FEWEST_PANES,
    concentration::{clamped, edges, normal_at},
    estimate::{joint_sides, multipliers_at},
};
use crate::{
    mesh::GEOMETRY_TOLERANCE,
    reference::quadrature,
    scene::{ContactFeatures, Functional},
};

/// What the panes around the largest pressure say of it.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(super) enum PeakShape {
    /// d₁ ≤ 0.1 and |d₂| ≤ 0.2 of not too few panes: known to the larger of both, and to 2 % at best.
    Resolved,
    /// Fewer than some three panes across it: known to d₁, and to 20 % at best.
    Coarse,
    /// With d₁ ≥ 0.12 at an edge, and pane j pressed where theory knows no bound, elsewhere d₁ ≤ 0.75 and d₂ < d₁/3: larger on every finer mesh.
    Growing,
}

/// How a pane ends.
#[derive(Debug, Clone, Copy, PartialEq, Eq, PartialOrd, Ord)]
enum PaneEnd {
    /// Inside its face, or where the pressure of closed contact is bounded.
    Inside,
    /// At an edge where it may have no bound.
    Edge,
    /// At one where it has none.
    Unbounded,
}

/// An open pane beside the largest pressure belongs to a sharp edge if closing it would take this many times that pressure.
const EDGE_STIFFNESS: f64 = 10.0;

/// The largest pressure as a quantity, with the box of its pane, for the stiffness of each pane in Pa/m and the largest pressure of a point
/// inside panes in Pa; `None` without contact forces.
pub(super) fn largest_pressure(
    solved: &Solved<'_>,
    panes: &[PaneState],
    stiffness: &[f64],
    inside: f64,
) -> Option<FunctionalEstimate> {
    let contact = solved.contact.as_ref()?;
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
    let bar = match shape_of_peak((solved, contact), panes, stiffness, highest) {
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

/// Whether the half-space behind a face is the same distance away all over a pane.
fn is_level(solved: &Solved<'_>, contact: &SolvedContact<'_>, pane: usize) -> bool {
    let (mesh, surface) = (solved.mesh, contact.state.surface);
    let features = &solved.scene.contact_features()[surface.face_of_pane(pane)];
    let Some(gap) = &features.gap else {
        return features.obstacle.is_none();
    };
    let facets = surface.facets.iter().enumerate();
    let of_pane = facets.filter(|(it, _)| surface.panes_of_facet(mesh, *it).contains(&pane));
    let mut gaps = of_pane.flat_map(|(_, &facet)| {
        let corners = mesh.corners(&mesh.facets[facet]);
        quadrature::triangle_4().map(move |(share, _)| gap.at(quadrature::point(&corners, &share)))
    });
    let first = gaps.next();
    features.obstacle.is_none() && gaps.all(|gap| Some(gap) == first)
}

/// The shape of the peak with d₁ and d₂.
fn shape_of_peak(
    (solved, contact): (&Solved<'_>, &SolvedContact<'_>),
    panes: &[PaneState],
    stiffness: &[f64],
    highest: usize,
) -> (PeakShape, [f64; 2]) {
    let (neighbours, ends) = neighbours(solved, contact);
    let pressure = |pane: usize| -panes[pane].normal_stress;
    let largest = pressure(highest);
    let is_beyond_edge = |pane: &usize| {
        let state = &panes[*pane];
        state.zone == Zone::Open && stiffness[*pane] * state.gap > EDGE_STIFFNESS * largest
    };
    let beside = &neighbours[highest];
    let at_edge = ends[highest] > PaneEnd::Inside || beside.iter().any(is_beyond_edge);
    let lower = beside.iter().copied().filter(|pane| !is_beyond_edge(pane));
    let Some(next) = lower.min_by(|a, b| pressure(*a).total_cmp(&pressure(*b))) else {
        return (PeakShape::Coarse, [1.0, 0.0]);
    };
    let first = (largest - pressure(next)) / largest;
    let Some(behind) = pane_behind(&neighbours[next], (solved, contact), highest, next) else {
        return (PeakShape::Coarse, [first, 0.0]);
    };
    let second = (pressure(next) - pressure(behind)) / largest;
    let is_unbounded = ends[highest] == PaneEnd::Unbounded && first >= 0.12 && pressure(next) > 0.0;
    let is_steep = (0.12..=0.75).contains(&first) && second < first / 3.0;
    let shape = if is_unbounded || at_edge && is_steep {
        PeakShape::Growing
    } else if first <= 0.1 && second.abs() <= 0.2 && panes.len() >= FEWEST_PANES {
        PeakShape::Resolved
    } else {
        PeakShape::Coarse
    };
    (shape, [first, second])
}

/// Which panes share an edge, or nodes with multipliers a triangle, and how each pane ends there.
fn neighbours(solved: &Solved<'_>, contact: &SolvedContact<'_>) -> (Vec<Vec<usize>>, Vec<PaneEnd>) {
    let (mesh, surface) = (solved.mesh, contact.state.surface);
    let mut on_edge: BTreeMap<[usize; 3], Vec<usize>> = BTreeMap::new();
    let mut beside = vec![Vec::new(); surface.n_panes()];
    let mut faces = BTreeMap::new();
    for (place, &facet) in surface.facets.iter().enumerate() {
        let corners = mesh.facets[facet];
        let here = surface.panes_of_facet(mesh, place);
        here.iter().for_each(|&pane| beside[pane].extend(&here));
        faces.insert(facet, surface.face_number(place));
        for (a, b) in [(0, 1), (1, 2), (2, 0)] {
            let ends = [corners[a].min(corners[b]), corners[a].max(corners[b])];
            let mut middle = [0.0; 3];
            (middle[a], middle[b]) = (0.5, 0.5);
            let acting = multipliers_at(mesh, contact, place, middle).into_iter();
            let acting = acting.filter(|(_, weight)| *weight > 0.0);
            let key = [surface.face_number(place), ends[0], ends[1]];
            let panes = on_edge.entry(key).or_default();
            panes.extend(acting.map(|(pane, _)| pane));
        }
    }
    for here in on_edge.values() {
        here.iter().for_each(|&pane| beside[pane].extend(here));
    }
    let mut ends = vec![PaneEnd::Inside; surface.n_panes()];
    for (nodes, face, end) in ends_of_faces(solved, &faces) {
        let here = on_edge.get(&[face, nodes[0], nodes[1]]);
        for &pane in here.into_iter().flatten() {
            ends[pane] = ends[pane].max(end);
        }
    }
    for (pane, others) in beside.iter_mut().enumerate() {
        others.sort_unstable();
        others.dedup();
        others.retain(|&other| other != pane);
    }
    (beside, ends)
}

/// The edges at which contact faces end, each with its nodes and the number of the face, for the face of each contact triangle.
///
/// Closed contact holds the normal alone; where the body beyond the edge is held otherwise pressure has no bound as stress has none.
fn ends_of_faces(
    solved: &Solved<'_>,
    faces: &BTreeMap<usize, usize>,
) -> Vec<([usize; 2], usize, PaneEnd)> {
    let (mesh, held, joints) = (solved.mesh, clamped(solved), joint_sides(solved));
    let features = solved.scene.contact_features();
    let slides_on_rigid = |face: usize| {
        let ContactFeatures {
            entry, friction, ..
        } = &features[face];
        friction.is_none() && solved.scene.contacts[*entry].between.is_none()
    };
    let along_normal = |(facet, edge): (usize, usize)| {
        let normal = normal_at(mesh, facet, edge);
        normal * normal.transpose()
    };
    let mut ends = Vec::new();
    for edge in edges(mesh) {
        let [a, b, _] = edge.nodes(mesh);
        for [own, other] in [edge.sides, [edge.sides[1], edge.sides[0]]] {
            let face = faces.get(&own.0);
            let beyond = faces.get(&other.0);
            let Some(&face) = face.filter(|_| face != beyond) else {
                continue;
            };
            let (closed, mirror) = (along_normal(own), along_normal(other));
            let is_between = beyond.is_some() || joints.contains_key(&other.0);
            // Of the unit vectors along the axes one alone is held, and is the normal to the digits of a file: the body goes on in a mirror.
            let end = if (held[other.0] - mirror).norm() < GEOMETRY_TOLERANCE {
                PaneEnd::Inside
            } else if !is_between && edge.is_singular([closed, held[other.0]]) {
                PaneEnd::Unbounded
            } else if !is_between && slides_on_rigid(face) {
                PaneEnd::Inside
            } else {
                PaneEnd::Edge
            };
            ends.push(([a.min(b), a.max(b)], face, end));
        }
    }
    ends
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
