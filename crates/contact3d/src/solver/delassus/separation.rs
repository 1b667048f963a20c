//! Directions of force that prove that no forces solve a problem.
//!
//! Let p lie in the cones of friction, and W p = 0. Then p·u = p·q for whatever forces. Where p·q < 0:
//!
//! * **if p has normal components only**, p·u is a sum of p_N u_N with p_N ≥ 0, so u_N < 0 at a contact at least: Coulomb's law has no
//!   solution, whatever the coefficients. By Farkas' lemma there is such a p unless some velocity q + W x penetrates nowhere, which every
//!   solution needs;
//! * **otherwise** no u = q + W r lies in the dual cones: the associated law, u ∈ K*, has no solution, and the criterion fails that
//!   forces exist for if W p = 0 ≠ p ∈ K implies p·q > 0 (A. Klarbring, J.-S. Pang, *SIAM J. Optim.* 8 (1998) 712; V. Acary, F. Cadoux, in:
//!   *Recent Advances in Contact Mechanics*, Springer 2013, 131). Coulomb's law may have one all the same, in which contacts slide:
//!   û = u + μ‖u_T‖ e_N lies in K*, hence Σ μ p_N ‖u_T‖ ≥ −p·q > 0. It proves nothing about that.
//!
//! W p vanishes up to rounding of its terms only. What holds then is p·q + (W p)·r ≥ 0, so all forces of a solution together are at least
//! −p·q / ‖W p‖, and it is the size of this bound that tells a proof from none.
//!
//! The direction is that of the least penetration: p = P(−u) for the u = q + W x that minimises ½ ‖P(−u)‖², half the squared distance of u
//! from K* (P projects on K; μ = 0 makes it that from u_N ≥ 0). There W p = 0 and p·q = −‖p‖², and p = 0 where u reaches K*.

use crate::linalg::{CholeskyFactor, CscMatrix, Workspace, add_scaled, amd, dot, norm};

use super::{
    problem::{DelassusProblem, project},
    scaled::Scaled,
};

/// Least bound on the forces, in units of the problem scaled to unit diagonals and offset, by which W p = 0: that of rounding is beyond 1e13, and forces of
/// 1e6 already cannot be told from those one digit further.
const PROVEN: f64 = 1e10;

/// Share of its terms up to which W p vanishes: rounding of W, of which files of other programs keep some twelve digits, and of p.
const VANISHED: f64 = 1e-10;

/// Weights α of xᵀW x, each a tenth of the one before, to that which shifts p by as much as rounding does.
const LEAST_WEIGHT: f64 = 1e-8;

/// Most Newton steps for a weight, and most halvings of one.
const MOST_STEPS: usize = 30;
const MOST_HALVINGS: i32 = 30;

/// Weight by which a direction is projected on the kernel of W within its face of the cone, and how often, on how many faces: each time takes this share of what
/// is not in the kernel, and the square of what the face bends.
const POLISHING: f64 = 1e-6;
const POLISHES: usize = 4;
const FACES: usize = 3;

/// What a direction proves.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Obstruction {
    /// No velocity q + W x is without penetration: Coulomb's law has no solution, whatever the friction.
    Penetration,
    /// No velocity q + W r lies in the dual cones: the associated law has no solution, and Coulomb's has none in which these contacts stick.
    Sticking,
}

/// A direction p of the cones of friction with W p = 0 and p·q < 0.
#[derive(Debug, Clone, PartialEq)]
pub struct Separation {
    /// What it proves.
    pub obstruction: Obstruction,
    /// p in the order and units of the given forces, of largest component one, `[3 n]`.
    pub direction: Vec<f64>,
    /// Forces of a solution are at least this many times those of a unit diagonal and the given offset, −p·q / (‖q‖ ‖W p‖);
    /// infinite where W p = 0.
    pub force_bound: f64,
}

/// The direction; `None` where there is none, or rounding hides it.
pub(super) fn separation(scaled: &Scaled<'_>, obstruction: Obstruction) -> Option<Separation> {
    let problem = &scaled.judge;
    let mu = match obstruction {
        Obstruction::Penetration => vec![0.0; problem.n_contacts()],
        Obstruction::Sticking => problem.mu().to_vec(),
    };
    let size = norm(problem.offset());
    let program = LeastPenetration { problem, mu };
    let mut at = vec![0.0; problem.offset().len()];
    let mut weight = 1.0;
    while weight >= LEAST_WEIGHT && size > 0.0 {
        program.minimise(&mut at, weight);
        let (direction, _) = program.projected(&at);
        // All penetration that is left is that of the weight.
        if norm(&direction) <= LEAST_WEIGHT * size {
            return None;
        }
        let direction = program.polished(direction);
        let force_bound = program.force_bound(&direction);
        if force_bound >= PROVEN {
            return Some(Separation {
                obstruction,
                direction: scaled.unscaled(&direction),
                force_bound,
            });
        }
        weight *= 0.1;
    }
    None
}

/// Minimise ½ ‖P(−u)‖² + ½ α xᵀW x over x, with u = q + W x; α x = P(−u) at the minimum.
struct LeastPenetration<'a> {
    problem: &'a DelassusProblem,
    /// Of the cones that count.
    mu: Vec<f64>,
}

/// A direction of force at one contact.
struct ForceDirection {
    contact: usize,
    direction: [f64; 3],
}

impl LeastPenetration<'_> {
    /// P(−u), and rays C with ∂P(−u)/∂(−u) = C Cᵀ.
    fn projected(&self, at: &[f64]) -> (Vec<f64>, Vec<ForceDirection>) {
        let velocity = self.problem.velocity(at);
        let mut rays = Vec::new();
        let contacts = velocity.as_chunks::<3>().0.iter().zip(&self.mu).enumerate();
        let projections = contacts.flat_map(|(contact, (u, &mu))| {
            let pushed = u.map(|u| -u);
            let projected = project(pushed, mu);
            let (slopes, count) = slopes(pushed, projected, mu);
            let slopes = slopes.into_iter().take(count);
            rays.extend(slopes.map(|direction| ForceDirection { contact, direction }));
            projected
        });
        (projections.collect(), rays)
    }

    /// Newton's method: G(x) = α x − P(−u) = 0. The gradient of the objective is W G, the matrix α + C Cᵀ W.
    fn minimise(&self, at: &mut Vec<f64>, weight: f64) {
        let mut objective = self.objective(at, weight);
        for _ in 0..MOST_STEPS {
            let (projected, rays) = self.projected(at);
            let residual: Vec<f64> = at
                .iter()
                .zip(&projected)
                .map(|(x, p)| weight * x - p)
                .collect();
            let gradient = self.product(&residual);
            let Some(response) = self.response(&rays, weight, &gradient) else {
                return;
            };
            // (α + C Cᵀ W)⁻¹ = (1 − C (α + Cᵀ W C)⁻¹ Cᵀ W) / α.
            let step: Vec<f64> = residual
                .iter()
                .zip(&response)
                .map(|(g, c)| (c - g) / weight)
                .collect();
            let slope = dot(&gradient, &step);
            let shorter = (0..MOST_HALVINGS).map(|halvings| 0.5_f64.powi(halvings));
            let found = shorter.into_iter().find_map(|share| {
                let mut next = at.clone();
                add_scaled(&mut next, share, &step);
                let there = self.objective(&next, weight);
                (there < objective + 1e-4 * share * slope).then_some((next, there))
            });
            let Some((next, there)) = found else {
                return;
            };
            *at = next;
            objective = there;
        }
    }

    fn objective(&self, at: &[f64], weight: f64) -> f64 {
        let (projected, _) = self.projected(at);
        0.5 * (dot(&projected, &projected) + weight * dot(at, &self.product(at)))
    }

    fn product(&self, x: &[f64]) -> Vec<f64> {
        let mut product = vec![0.0; x.len()];
        self.problem.matrix().mul(x, &mut product);
        product
    }

    /// |W| |x|, whose rounding W x has.
    fn terms(&self, x: &[f64]) -> Vec<f64> {
        let mut terms = vec![0.0; x.len()];
        for (j, x) in x.iter().enumerate() {
            let (rows, values) = self.problem.matrix().column(j);
            for (&row, value) in rows.iter().zip(values) {
                terms[row] += (value * x).abs();
            }
        }
        terms
    }

    /// C (α + Cᵀ W C)⁻¹ Cᵀ v; `None` where rounding lets no factor exist.
    fn response(&self, rays: &[ForceDirection], weight: f64, vector: &[f64]) -> Option<Vec<f64>> {
        let mut response = vec![0.0; vector.len()];
        let along = |ray: &ForceDirection| {
            (0..3)
                .map(|k| ray.direction[k] * vector[3 * ray.contact + k])
                .sum()
        };
        let mut shares: Vec<f64> = rays.iter().map(along).collect();
        if !rays.is_empty() {
            let matrix = self.restricted(rays, weight);
            let factor: CholeskyFactor =
                CholeskyFactor::factorise(&matrix, amd(&matrix).ok()?).ok()?;
            factor.solve_in_place(&mut shares, &mut Workspace::default());
        }
        for (ray, share) in rays.iter().zip(shares) {
            for k in 0..3 {
                response[3 * ray.contact + k] += share * ray.direction[k];
            }
        }
        Some(response)
    }

    /// α + Cᵀ W C.
    fn restricted(&self, rays: &[ForceDirection], weight: f64) -> CscMatrix {
        let n = rays.len();
        let mut matrix = CscMatrix::empty(n);
        matrix.cols = n;
        let w = self.problem.matrix();
        let mut moved = vec![0.0; w.rows];
        let mut entries: Vec<(usize, f64)> = Vec::new();
        let of_contact = |contact: usize| {
            let first = rays.partition_point(|ray| ray.contact < contact);
            let count = rays[first..].partition_point(|ray| ray.contact == contact);
            first..first + count
        };
        for (j, ray) in rays.iter().enumerate() {
            let mut touched = vec![ray.contact];
            for k in 0..3 {
                let (rows, values) = w.column(3 * ray.contact + k);
                for (&row, value) in rows.iter().zip(values) {
                    moved[row] += ray.direction[k] * value;
                    touched.push(row / 3);
                }
            }
            touched.sort_unstable();
            touched.dedup();
            for i in touched.iter().flat_map(|&contact| of_contact(contact)) {
                let other = &rays[i];
                let work: f64 = (0..3)
                    .map(|k| other.direction[k] * moved[3 * other.contact + k])
                    .sum();
                entries.push((i, work + if i == j { weight } else { 0.0 }));
            }
            touched
                .iter()
                .for_each(|contact| moved[3 * contact..3 * contact + 3].fill(0.0));
            let (rows, values): (Vec<usize>, Vec<f64>) = entries.drain(..).unzip();
            matrix.indices.extend(rows);
            matrix.data.extend(values);
            matrix.indptr.push(matrix.indices.len());
        }
        matrix
    }

    /// A direction near the kernel of W brought into it, within the cones.
    fn polished(&self, mut direction: Vec<f64>) -> Vec<f64> {
        for _ in 0..FACES {
            let contacts = direction
                .as_chunks::<3>()
                .0
                .iter()
                .zip(&self.mu)
                .enumerate();
            let rays: Vec<ForceDirection> = contacts
                .flat_map(|(contact, (p, &mu))| {
                    let rays = face(*p, mu);
                    rays.into_iter()
                        .map(move |direction| ForceDirection { contact, direction })
                })
                .collect();
            let mut inside = direction.clone();
            for _ in 0..POLISHES {
                let moved = self.product(&inside);
                let Some(taken) = self.response(&rays, POLISHING, &moved) else {
                    return direction;
                };
                add_scaled(&mut inside, -1.0, &taken);
            }
            let contacts = inside.as_chunks::<3>().0.iter().zip(&self.mu);
            direction = contacts.flat_map(|(p, &mu)| project(*p, mu)).collect();
        }
        let largest = direction.iter().fold(0.0_f64, |most, p| most.max(p.abs()));
        for p in direction.as_chunks_mut::<3>().0 {
            // Rounding of nothing, and of its sign.
            let is_pressed = p[0] > f64::EPSILON * largest;
            *p = p.map(|p| if is_pressed { p + 0.0 } else { 0.0 });
        }
        direction
    }

    /// −p·q / (‖q‖ ‖W p‖); negative or NaN where p separates nothing.
    fn force_bound(&self, direction: &[f64]) -> f64 {
        let offset = self.problem.offset();
        let work = -dot(direction, offset) / norm(offset);
        let product = self.product(direction);
        // What rounding can make of nothing, and what it cannot: W p of a W that is only small, as a large friction makes it in these
        // units.
        if work <= offset.len() as f64 * f64::EPSILON * norm(direction)
            || norm(&product) > VANISHED * norm(&self.terms(direction))
        {
            return 0.0;
        }
        work / norm(&product)
    }
}

/// Rays whose squares sum up to the derivative of a projection, the first so many of three.
fn slopes(x: [f64; 3], projected: [f64; 3], mu: f64) -> ([[f64; 3]; 3], usize) {
    let axes = [[1.0, 0.0, 0.0], [0.0, 1.0, 0.0], [0.0, 0.0, 1.0]];
    if projected[0] <= 0.0 {
        return (axes, 0);
    }
    if mu == 0.0 {
        return (axes, 1);
    }
    if projected == x {
        return (axes, 3);
    }
    let tangential = x[1].hypot(x[2]);
    let [along, across] = generator(x, mu);
    // The boundary turns with x_T, the less the further x is from the axis.
    let turning = (mu * projected[0] / tangential).sqrt();
    ([along, across.map(|c| turning * c), axes[2]], 2)
}

/// Directions in which a force of the cone can change without leaving its face: all within, the generator and its tangent on the
/// boundary, none at the apex.
fn face(p: [f64; 3], mu: f64) -> Vec<[f64; 3]> {
    let tangential = p[1].hypot(p[2]);
    if p[0] <= 0.0 {
        Vec::new()
    } else if mu == 0.0 {
        vec![[1.0, 0.0, 0.0]]
    } else if tangential < mu * p[0] * (1.0 - POLISHING) {
        vec![[1.0, 0.0, 0.0], [0.0, 1.0, 0.0], [0.0, 0.0, 1.0]]
    } else {
        generator(p, mu).to_vec()
    }
}

/// The unit generator of the cone's boundary towards a point off the axis, and the unit vector around the axis.
fn generator(x: [f64; 3], mu: f64) -> [[f64; 3]; 2] {
    let tangential = x[1].hypot(x[2]);
    let [cos, sin] = [x[1] / tangential, x[2] / tangential];
    let length = mu.hypot(1.0);
    [
        [1.0 / length, mu * cos / length, mu * sin / length],
        [0.0, -sin, cos],
    ]
}
