//! Bodies that their supports leave free to move as rigid ones.

use nalgebra::DMatrix;

use super::{DofMap, ToolPlace, rigid_motion::RigidMotion};
use crate::{
    linalg::{CscMatrix, add_combination, add_scaled, dot},
    mesh::{GEOMETRY_TOLERANCE, Mesh},
    scene::{InvalidValue, Scene},
};

/// The rigid modes Z of a body that only contact holds, or beside it springs that are weak, and of tools that are free to move, and the
/// pins that make the stiffness invertible. A free motion of a tool is a mode of its own degree of freedom, which is its pin.
///
/// Where the kernel of A has k modes, k degrees of freedom are chosen whose motion tells all of them apart (pins). A spring κ
/// at each makes A_κ = A + κ Σ e_p e_pᵀ positive definite, and since there are no more pins than modes, A_κ⁻¹f is for forces in
/// equilibrium, Zᵀf = 0, a displacement with A u = f whose pins do not move and whose springs carry nothing: A_κ⁻¹ is a
/// generalised inverse of A (C. Farhat, F.-X. Roux, *Int. J. Numer. Meth. Engng* 32 (1991) 1205; Z. Dostál, T. Kozubek,
/// A. Markopoulos, *Appl. Math. Comput.* 217 (2011) 7067). A solution u = A_κ⁻¹(l − Bᵀλ) + Z α with Zᵀ(l − Bᵀλ) = 0 depends neither
/// on κ nor on the pins.
///
/// Where weak springs K_s resist the modes, A Z = K_s Z = C, the same holds for Z̃ = Z + Y, Y = −A_κ⁻¹C, in place of Z: with
/// κ EᵀA_κ⁻¹ = Z̃ᵀ the pins' springs carry nothing in u = A_κ⁻¹(l − Bᵀλ) + Z̃ α if Z̃ᵀ(l − Bᵀλ) = D α for D = Z̃ᵀC, what the supports
/// resist. The compliance of the supports, which may be as many times that of the body as a number has digits and more, is then in
/// D alone and not in B A_κ⁻¹Bᵀ. Z α, which may be as much larger, strains nothing; Y α strains the body as the springs' forces do.
/// No support is the case C = 0.
#[derive(Debug, Clone, PartialEq)]
pub struct RigidModes {
    /// Z, `[n_modes][n_free]`, dimensionless: mode p moves pin p by one and no other pin.
    pub modes: Vec<Vec<f64>>,
    /// The pins, `[n_modes]`, as degrees of freedom.
    pub pins: Vec<usize>,
    /// κ in N/m, of the size of A's diagonal at the pins.
    pub spring: f64,
    /// `None` where supports resist none of the modes.
    pub support: Option<WeakSupport>,
    /// A_κ, what the factor is of.
    pub grounded: CscMatrix,
}

/// What weak springs K_s make of the rigid modes.
#[derive(Debug, Clone, PartialEq)]
pub struct WeakSupport {
    /// D in N/m, `[n_modes][n_modes]`, symmetric.
    pub stiffness: Vec<Vec<f64>>,
    /// Y = −A_κ⁻¹K_s Z, `[n_modes][n_free]`, dimensionless: how the body yields to the springs.
    pub spring_response: Vec<Vec<f64>>,
}

impl RigidModes {
    /// The free motions of a body as modes on its free degrees of freedom, with pins away from the contact face where there are
    /// nodes enough; `None` where the numbers do not tell the motions apart.
    fn new(
        scene: &Scene,
        mesh: &Mesh,
        dofs: &DofMap,
        motions: &[RigidMotion],
        stiffness: &CscMatrix,
    ) -> Option<Self> {
        let shapes = motions
            .iter()
            .map(|motion| on_dofs(scene, mesh, dofs, motion));
        let shapes: Vec<Vec<f64>> = shapes.collect();
        let tool_dofs = || loose_tool_dofs(scene, dofs);
        let mut on_contact = vec![false; dofs.n_free];
        for node in mesh
            .contact
            .iter()
            .flat_map(|surface| surface.nodes_of_both_sides())
        {
            for (dof, _) in dofs.terms(node, [1.0; 3]) {
                on_contact[dof] = true;
            }
        }
        let of_body = || (0..dofs.n_free).filter(|dof| !dofs.is_of_tool(*dof));
        let away: Vec<usize> = of_body().filter(|&d| !on_contact[d]).collect();
        let mut pins = telling_dofs(&shapes, &away)
            .or_else(|| telling_dofs(&shapes, &of_body().collect::<Vec<_>>()))?;
        let mut modes = normalised(&shapes, &pins)?;
        let spring = if tool_dofs().next().is_none() {
            let at_pins = pins.iter().map(|&pin| stiffness.diagonal(pin));
            at_pins.fold(f64::INFINITY, f64::min)
        } else {
            // Springs softer than the face cost steps of Newton's method: n nodes of stiffness E h make E h √n.
            let of_face = of_body().filter(|&dof| on_contact[dof]);
            let of_face: Vec<f64> = of_face.map(|dof| stiffness.diagonal(dof)).collect();
            of_face.iter().sum::<f64>() / (of_face.len() as f64).sqrt()
        };
        for dof in tool_dofs() {
            let mut mode = vec![0.0; dofs.n_free];
            mode[dof] = 1.0;
            modes.push(mode);
            pins.push(dof);
        }
        Some(Self::from_parts(modes, pins, spring, None, stiffness))
    }

    /// Puts a body together again from Z, the pins, κ in N/m, the springs' part and A.
    #[must_use]
    pub fn from_parts(
        modes: Vec<Vec<f64>>,
        pins: Vec<usize>,
        spring: f64,
        support: Option<WeakSupport>,
        stiffness: &CscMatrix,
    ) -> Self {
        let mut grounded = stiffness.clone();
        for at in pins
            .iter()
            .filter_map(|&pin| stiffness.place_of_diagonal(pin))
        {
            grounded.data[at] += spring;
        }
        Self {
            modes,
            pins,
            spring,
            support,
            grounded,
        }
    }

    /// The same with weak springs, from their forces C = K_s Z in N/m, `[n_modes][n_free]`, and Y.
    pub(crate) fn resisted(self, forces: &[Vec<f64>], spring_response: Vec<Vec<f64>>) -> Self {
        let work = |p: usize, q: usize| {
            dot(&self.modes[p], &forces[q]) + dot(&spring_response[p], &forces[q])
        };
        let all = || 0..self.n_modes();
        let row = |p| all().map(|q| 0.5 * (work(p, q) + work(q, p))).collect();
        let stiffness = all().map(row).collect();
        Self {
            support: Some(WeakSupport {
                stiffness,
                spring_response,
            }),
            ..self
        }
    }

    /// Number of rigid modes k.
    #[must_use]
    pub fn n_modes(&self) -> usize {
        self.modes.len()
    }

    /// The rigid part Z a of a motion in terms of the modes; what is no more than rounding of its terms is zero, so that a motion along a
    /// plane does not leave it, however far.
    pub(crate) fn rigid_part(&self, weights: &[f64]) -> Vec<f64> {
        let n = self.grounded.cols;
        let (mut sum, mut size) = (vec![0.0; n], vec![0.0; n]);
        for (mode, by) in self.modes.iter().zip(weights) {
            for ((sum, size), value) in sum.iter_mut().zip(&mut size).zip(mode) {
                *sum += by * value;
                *size += (by * value).abs();
            }
        }
        for (sum, size) in sum.iter_mut().zip(&size) {
            if sum.abs() <= 16.0 * f64::EPSILON * size {
                *sum = 0.0;
            }
        }
        sum
    }

    /// Y a; empty where supports resist no mode.
    pub(crate) fn spring_response_part(&self, weights: &[f64]) -> Vec<f64> {
        let Some(support) = &self.support else {
            return Vec::new();
        };
        let mut sum = vec![0.0; self.grounded.cols];
        add_combination(&mut sum, weights, &support.spring_response);
        sum
    }
}

/// The free degrees of freedom of tools that are bonded to no face.
fn loose_tool_dofs<'a>(scene: &'a Scene, dofs: &'a DofMap) -> impl Iterator<Item = usize> + 'a {
    let rows = dofs.dof[dofs.n_nodes..].as_chunks::<2>().0.iter();
    let loose = scene
        .tools
        .iter()
        .zip(rows)
        .filter(|(tool, _)| tool.face.is_none());
    loose.flat_map(|(_, rows)| rows.iter().flatten().flatten().copied())
}

/// The displacement of the free degrees of freedom in a rigid motion.
fn on_dofs(scene: &Scene, mesh: &Mesh, dofs: &DofMap, motion: &RigidMotion) -> Vec<f64> {
    let mut rows = vec![[0.0; 3]; mesh.coordinates.len()];
    let glued = mesh.glued_bodies().into_iter();
    let bodies = glued
        .filter(|bodies| bodies.contains(&motion.body))
        .flatten();
    let bodies: Vec<usize> = bodies.collect();
    for node in bodies.iter().flat_map(|body| mesh.body_nodes(*body)) {
        rows[node] = motion.at(&mesh.coordinates[node]);
    }
    // What is bonded to the body moves with it.
    let places = ToolPlace::of_scene(scene, mesh);
    let prefixes: Vec<String> = bodies.iter().map(|b| scene.face_prefix(*b)).collect();
    for (tool, place) in scene.tools.iter().zip(&places) {
        let moved = [motion.at(&place.point), motion.rotation.into()];
        let moved = place.rows(moved);
        let is_own = |face: &&String| prefixes.iter().any(|prefix| face.starts_with(prefix));
        let bonded = tool.face.as_ref().filter(is_own);
        rows.extend(bonded.map_or([[0.0; 3]; 2], |_| moved));
    }
    let shape = dofs.to_free(&rows);
    let largest = shape.iter().fold(0.0_f64, |m, v| m.max(v.abs()));
    shape.iter().map(|v| v / largest).collect()
}

/// One degree of freedom of `candidates` for each mode, such that the modes' values there are as independent as can be: columns
/// of Zᵀ chosen by pivoted Gram–Schmidt; `None` where they are dependent.
fn telling_dofs(shapes: &[Vec<f64>], candidates: &[usize]) -> Option<Vec<usize>> {
    let mut left: Vec<Vec<f64>> = candidates
        .iter()
        .map(|&dof| shapes.iter().map(|shape| shape[dof]).collect())
        .collect();
    let mut pins = Vec::with_capacity(shapes.len());
    for _ in 0..shapes.len() {
        let squares = left.iter().map(|row| dot(row, row));
        let larger =
            |best: (usize, f64), next: (usize, f64)| if next.1 > best.1 { next } else { best };
        let (at, square) = squares.enumerate().fold((0, 0.0), larger);
        if square <= GEOMETRY_TOLERANCE * GEOMETRY_TOLERANCE {
            return None;
        }
        pins.push(candidates[at]);
        let chosen: Vec<f64> = left[at].iter().map(|v| v / square.sqrt()).collect();
        for row in &mut left {
            let along = dot(row, &chosen);
            add_scaled(row, -along, &chosen);
        }
    }
    Some(pins)
}

/// The modes of the same space in which mode p moves pin p by one and no other.
fn normalised(shapes: &[Vec<f64>], pins: &[usize]) -> Option<Vec<Vec<f64>>> {
    let k = pins.len();
    let at_pins = DMatrix::from_fn(k, k, |mode, pin| shapes[mode][pins[pin]]);
    let inverse = at_pins.try_inverse()?;
    let modes = (0..k)
        .map(|p| {
            let mut mode = vec![0.0; shapes[0].len()];
            for (m, shape) in shapes.iter().enumerate() {
                add_scaled(&mut mode, inverse[(p, m)], shape);
            }
            for (q, &pin) in pins.iter().enumerate() {
                mode[pin] = if q == p { 1.0 } else { 0.0 };
            }
            mode
        })
        .collect();
    Some(modes)
}

/// The floating body of a mesh with its free tools, before springs resist it; `None` where all are held.
///
/// # Errors
/// Coordinates so large or small that rounding hides the motions.
pub(crate) fn rigid_modes(
    scene: &Scene,
    mesh: &Mesh,
    dofs: &DofMap,
    motions: &[RigidMotion],
    stiffness: &CscMatrix,
) -> Result<Option<RigidModes>, InvalidValue> {
    if motions.is_empty() && loose_tool_dofs(scene, dofs).next().is_none() {
        return Ok(None);
    }
    match RigidModes::new(scene, mesh, dofs, motions, stiffness) {
        Some(body) => Ok(Some(body)),
        None => Err(InvalidValue {
            key: "body".into(),
            expected: "a size in which double precision tells the rigid motions of the body apart"
                .into(),
            found: format!("{} motions that it does not", motions.len()),
            help: "choose units in which lengths are moderate, or hold the body with [[clamp]]"
                .into(),
        }),
    }
}
