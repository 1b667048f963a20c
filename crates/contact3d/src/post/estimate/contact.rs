//! What the conditions of contact and friction are violated by inside panes.

use super::{
    Field, FieldLoads, SolutionData,
    boundary::multipliers_at,
    contact_points::{ContactPoint, ContactPoints, interpolated},
};
use crate::{
    contact::Ellipse,
    elasticity::InternalForces,
    post::{Solved, SolvedContact},
    reference::quadrature,
    scene::{ContactFeatures, FrictionModel, Obstacle, Quantity, Scene},
};

/// A multiplier with its law at a point of the contact face.
#[derive(Clone, Copy, Default)]
struct Law {
    /// λ_ν, λ_t1, λ_t2 in Pa.
    stress: [f64; 3],
    /// Local stiffness, normal and tangential, in Pa/m.
    stiffness: [f64; 2],
    /// Semi-axes of friction in Pa.
    semi_axes: [f64; 2],
    /// What they gain with the pressure.
    axes_by_pressure: [f64; 2],
    /// By how much the pane moves into the obstacle before the pressures of its points have the mean λ_ν, in m.
    shift: f64,
    /// Q_λ over the area of the pane, along ν, t₁, t₂; zero for the solution itself.
    wanted: [f64; 3],
    /// What that shift makes of Q over the area of the pane; zero for the solution itself.
    by_shift: f64,
}

impl Law {
    /// The sum with a multiple of another one.
    fn plus(self, by: f64, other: Self) -> Self {
        fn sum<const K: usize>(a: [f64; K], by: f64, b: [f64; K]) -> [f64; K] {
            std::array::from_fn(|c| a[c] + b[c] * by)
        }
        Self {
            stress: sum(self.stress, by, other.stress),
            stiffness: sum(self.stiffness, by, other.stiffness),
            semi_axes: sum(self.semi_axes, by, other.semi_axes),
            axes_by_pressure: sum(self.axes_by_pressure, by, other.axes_by_pressure),
            shift: self.shift + by * other.shift,
            wanted: sum(self.wanted, by, other.wanted),
            by_shift: self.by_shift + by * other.by_shift,
        }
    }

    /// Takes the friction of a place instead of that of the pane around it.
    fn follow(&mut self, model: &FrictionModel, at: [f64; 3]) {
        let of_place = || {
            model
                .bound
                .place_dependent()
                .map_or(0.0, |(_, stress)| stress.at(at))
        };
        let bound = model.bound.at(self.stress[0], of_place);
        let coefficients = model.coefficients.evaluate([0.0; 3], at, [0.0; 2]);
        self.semi_axes = coefficients.map(|f| f * bound);
        let slope = model.bound.slope(self.stress[0]);
        self.axes_by_pressure = coefficients.map(|f| f * slope);
    }

    /// δλ in Pa for a displacement (u_ν − d, u_t1, u_t2) in m, with semi-axes that follow the pressure.
    fn change(&self, at: [f64; 3]) -> [f64; 3] {
        let [normal, tangential] = self.stiffness;
        let [pressure, first, second] = self.stress;
        let pressed = (pressure + normal * (at[0] + self.shift)).max(0.0) - pressure;
        let ellipse = Ellipse {
            semi_axes: [0, 1]
                .map(|k| (self.semi_axes[k] + self.axes_by_pressure[k] * pressed).max(0.0)),
        };
        let found = ellipse.project([first + tangential * at[1], second + tangential * at[2]]);
        [pressed, found[0] - first, found[1] - second]
    }

    /// δλ²/k in J/m² of penetration, complementarity and friction for a displacement (u_ν − d, u_t1,
    /// u_t2) in m.
    fn energies(&self, at: [f64; 3]) -> [f64; 3] {
        let [normal, tangential] = self.stiffness;
        let (pressure, depth) = (self.stress[0], at[0] + self.shift);
        let change = (pressure + normal * depth).max(0.0) - pressure;
        let energy = if normal > 0.0 {
            change * change / normal
        } else {
            0.0
        };
        let [penetration, complementarity] = if depth > 0.0 {
            [energy, 0.0]
        } else {
            [0.0, energy]
        };
        let friction = if tangential > 0.0 {
            let shear = [self.stress[1], self.stress[2]];
            let trial = [0, 1].map(|c| shear[c] + tangential * at[c + 1]);
            let ellipse = Ellipse {
                semi_axes: self.semi_axes,
            };
            let found = ellipse.project(trial);
            ((found[0] - shear[0]).powi(2) + (found[1] - shear[1]).powi(2)) / tangential
        } else {
            0.0
        };
        [penetration, complementarity, friction]
    }
}

/// The conditions of contact and friction at a solution.
pub(super) struct PointConditions<'a> {
    solved: &'a Solved<'a>,
    contact: &'a SolvedContact<'a>,
    /// Of each pane, `[n_panes]`.
    laws: Vec<Law>,
    /// Friction that differs inside panes, of each contact face, `[n_faces]`.
    varying: Vec<Option<FrictionModel>>,
    /// (u_ν − d, u_t1, u_t2) at the contact nodes in m, `[n_contact_nodes]`.
    moved: Vec<[f64; 3]>,
    /// Where the conditions are measured on each contact triangle, `[n_contact_facets]`.
    points: Vec<Vec<ContactPoint>>,
    /// How many times stiffer the body is where it is only pressed in some place inside an open pane, of each contact triangle, at
    /// least 1, `[n_contact_facets]`.
    stiffening: Vec<f64>,
    /// Share of k that the body has at violations inside panes, at most 1.
    share: f64,
}

/// Tractions that would correct the violations inside panes.
pub(super) struct Correction {
    /// Tractions δλ on the foundation at the contact nodes in Pa, `[n_contact_nodes]`.
    at_nodes: Vec<[f64; 3]>,
    /// ∫ δλ·δλ/k in J: their work, were the body as stiff there as k.
    work: f64,
    displacement: Vec<[f64; 3]>,
    internal: InternalForces,
    multiplier: Vec<f64>,
}

impl Correction {
    /// The displacement of the body under these tractions alone.
    pub(super) fn field(&self) -> Field<'_> {
        Field {
            tools: &[],
            displacement: &self.displacement,
            internal: &self.internal,
            loads: FieldLoads {
                of_scene: false,
                multiplier: &self.multiplier,
                at_nodes: &self.at_nodes,
                in_box: None,
            },
            by_multiplier: &[],
            is_galerkin: false,
            over: None,
        }
    }
}

impl<'a> PointConditions<'a> {
    pub(super) fn new(
        solved: &'a Solved<'a>,
        contact: &'a SolvedContact<'a>,
        known: &SolutionData<'_>,
    ) -> Self {
        let panes = 0..contact.state.surface.n_panes();
        let moved = displacements(contact, known);
        let conditions = Self {
            solved,
            contact,
            laws: panes
                .map(|pane| law_of(contact, solved, known, pane))
                .collect(),
            stiffening: vec![1.0; contact.state.surface.facets.len()],
            points: ContactPoints::new(solved, contact, known, &moved).of_facets(),
            moved,
            share: 1.0,
            varying: varying_friction(solved.scene),
        };
        let mut conditions = conditions.stiffened();
        conditions.laws = conditions.with_shifts(conditions.laws.clone());
        conditions
    }

    /// With panes that have moved until the pressures of their points have the mean λ_ν: the condition of a pane holds on average for
    /// distances interpolated between nodes, but a face rests on what formulas have between them, and where it turns inside a pane on an
    /// edge of it. The force on a pane is known far better than where in the pane it acts.
    fn with_shifts(&self, mut laws: Vec<Law>) -> Vec<Law> {
        let mut points = vec![Vec::new(); laws.len()];
        for place in 0..self.points.len() {
            self.visit(place, &laws, |point, law, weight| {
                let depth = point.moved(&self.moved)[0];
                for (pane, share) in
                    multipliers_at(self.solved.mesh, self.contact, place, point.share)
                {
                    points[pane].push([weight * share, law.stress[0], law.stiffness[0], depth]);
                }
            });
        }
        for (law, points) in laws.iter_mut().zip(points) {
            if law.stress[0] > 0.0 && law.stiffness[0] > 0.0 {
                law.shift = settlement(&points);
            }
        }
        laws
    }

    /// The largest pressure in Pa of a point, for the stiffness of each pane in Pa/m as a half-space.
    pub(super) fn largest_pressure(&self, stiffness: &[f64]) -> f64 {
        // Of waves as long as a pane instead of twice as long.
        let waves = |(law, k): (&Law, &f64)| Law {
            stiffness: [2.0 * k, law.stiffness[1]],
            ..*law
        };
        let laws = self.with_shifts(self.laws.iter().zip(stiffness).map(waves).collect());
        let mut largest = 0.0_f64;
        for place in 0..self.points.len() {
            self.visit(place, &laws, |point, law, _| {
                let depth = point.moved(&self.moved)[0] + law.shift;
                largest = largest.max(law.stress[0] + law.stiffness[0] * depth);
            });
        }
        largest
    }

    /// With open triangles as much stiffer than their panes as the place that penetrates is narrower: a body resists the more, the smaller
    /// the place is that it is pressed on, k ~ E/√a for an area a.
    fn stiffened(mut self) -> Self {
        let surface = self.contact.state.surface;
        let mut inside = vec![0.0; surface.n_panes()];
        let mut of_facets = Vec::with_capacity(self.points.len());
        for place in 0..self.points.len() {
            let mut here = 0.0;
            self.visit(place, &self.laws, |point, law, weight| {
                if law.stress[0] == 0.0 && point.moved(&self.moved)[0] > 0.0 {
                    here += weight;
                }
            });
            if let Some(pane) = surface.pane_of_facet(place) {
                inside[pane] += here;
            }
            of_facets.push(here);
        }
        let factor = |(place, here): (usize, f64)| {
            // A node takes about as much of the face as one of its triangles.
            let (whole, inside) = match surface.pane_of_facet(place) {
                Some(pane) => (surface.pane_area[pane], inside[pane]),
                None => (self.solved.mesh.facet_area(surface.facets[place]), here),
            };
            if inside > 0.0 {
                (whole / inside).sqrt().max(1.0)
            } else {
                1.0
            }
        };
        self.stiffening = of_facets.into_iter().enumerate().map(factor).collect();
        self
    }

    /// The law at a point of a contact triangle: that of its pane, or of nodes, linear between them; nodes without a multiplier, whose
    /// displacement is held, have a law of zero.
    fn law_at(&self, place: usize, share: [f64; 3], laws: &[Law]) -> Law {
        let acting = multipliers_at(self.solved.mesh, self.contact, place, share).into_iter();
        let mut law = acting.fold(Law::default(), |sum, (pane, weight)| {
            sum.plus(weight, laws[pane])
        });
        if law.stress[0] == 0.0 {
            law.stiffness[0] *= self.stiffening[place];
        }
        law
    }

    /// The tractions δλ of the violations inside panes, averaged at nodes.
    pub(super) fn correction(&self) -> Correction {
        let (surface, mesh) = (self.contact.state.surface, self.solved.mesh);
        let mut sums = vec![([0.0; 3], 0.0); self.moved.len()];
        let mut work = 0.0;
        for place in 0..surface.facets.len() {
            self.visit(place, &self.laws, |point, law, weight| {
                let at = point.moved(&self.moved);
                let change = law.change(at);
                for (&node, shape) in point.nodes.iter().zip(&point.shape) {
                    let weight = weight * shape.max(0.0);
                    sums[node].1 += weight;
                    (0..3).for_each(|c| sums[node].0[c] += weight * change[c]);
                }
                work += weight * law.energies(at).iter().sum::<f64>();
            });
        }
        let frame = &self.contact.state.interface.frame;
        let traction = |(node, (sum, weight)): (usize, ([f64; 3], f64))| {
            // Nothing lies opposite some nodes.
            let mean = |part: f64| if weight > 0.0 { part / weight } else { 0.0 };
            let [normal, first, second] = sum.map(mean);
            frame.vector(node, normal, [first, second])
        };
        Correction {
            at_nodes: sums.into_iter().enumerate().map(traction).collect(),
            work,
            displacement: vec![[0.0; 3]; mesh.coordinates.len()],
            internal: InternalForces {
                forces: Vec::new(),
                stress: Vec::new(),
                corner_stress: vec![[[0.0; 6]; 4]; mesh.tetrahedra.len()],
            },
            multiplier: vec![0.0; self.solved.solution.multiplier.len()],
        }
    }

    /// The conditions of a body in which the tractions of a correction do some work in J: a plate bends inside panes where a block is
    /// only pressed.
    pub(super) fn with_response(self, correction: &Correction, response: f64) -> Self {
        let share = if response > correction.work {
            correction.work / response
        } else {
            1.0
        };
        Self { share, ..self }
    }

    /// Whether formulas give data of contact that differ inside panes: what they make of a quantity in one place says little of the next.
    pub(super) fn has_formulas(&self) -> bool {
        let is_formula = |face: &ContactFeatures| {
            let gap = face.gap.as_ref().is_some_and(Quantity::depends_on_place);
            gap || matches!(
                face.obstacle,
                Some(Obstacle::Height(_) | Obstacle::Surface(_))
            )
        };
        let varies = self.varying.iter().any(Option::is_some);
        varies || self.solved.scene.contact_features().iter().any(is_formula)
    }

    pub(super) fn has_friction(&self) -> bool {
        self.contact.state.interface.has_friction()
    }

    /// The largest depth of a point in the obstacle in m, 0 of none.
    pub(super) fn deepest(&self) -> f64 {
        let mut deepest = 0.0_f64;
        for place in 0..self.points.len() {
            self.visit(place, &self.laws, |point, _, _| {
                deepest = deepest.max(point.moved(&self.moved)[0]);
            });
        }
        deepest
    }

    /// The energies in J of penetration, complementarity and friction of each contact triangle, `[n_contact_facets]`.
    pub(super) fn residuals(&self) -> Vec<[f64; 3]> {
        let of_facet = |place| {
            let mut sum = [0.0; 3];
            self.visit(place, &self.laws, |point, law, weight| {
                let energies = law.energies(point.moved(&self.moved));
                for (sum, energy) in sum.iter_mut().zip(energies) {
                    *sum += weight * self.share * energy;
                }
            });
            sum
        };
        let n_facets = self.contact.state.surface.facets.len();
        (0..n_facets).map(of_facet).collect()
    }

    /// −∫ (z − q)·δλ over each contact triangle and ∫ ζ δu_ν for the shift δu_ν of its pane, `[n_contact_facets]`: what the contact
    /// conditions that are violated inside panes make of a functional with an adjoint (z, ζ) and derivative Q_λ = ∫ q; `errors` are the local ones of solution and adjoint behind a
    /// contact triangle at a point in barycentric coordinates of the tetrahedron, in the global axes, which are added to u and to z.
    pub(super) fn weighted(
        &self,
        adjoint: &Field<'_>,
        errors: impl Fn(usize, &[f64; 4]) -> [[f64; 3]; 2],
    ) -> Vec<f64> {
        let (mesh, surface) = (self.solved.mesh, self.contact.state.surface);
        let layout = self.contact.coupling.layout;
        let law = |(pane, law): (usize, &Law)| {
            let density = |j: usize| adjoint.by_multiplier[j] / surface.pane_area[pane];
            let pair = layout.tangential(pane);
            let [first, second] = pair.map_or([0.0; 2], |pair| pair.map(density));
            let own = adjoint.loads.of_scene.then_some(law.stress[0]);
            let of_adjoint = adjoint.loads.multiplier[pane] - own.unwrap_or(0.0);
            Law {
                wanted: [density(pane), first, second],
                by_shift: of_adjoint * law.shift,
                ..*law
            }
        };
        let laws: Vec<Law> = self.laws.iter().enumerate().map(law).collect();
        let frame = &self.contact.state.interface.frame;
        let in_frame = |local: usize, vector: [f64; 3]| {
            let [first, second] = frame.tangential(local, vector);
            [frame.normal_part(local, vector), first, second]
        };
        let nodes = surface.nodes.iter().enumerate();
        let nodal: Vec<[f64; 3]> = nodes
            .map(|(local, &node)| {
                let at_node = |node: usize| adjoint.displacement[node];
                let z = frame.relative(local, node, at_node, |row| adjoint.tools[row]);
                in_frame(local, z)
            })
            .collect();
        let behind = mesh.behind_contact();
        let sum3 = |a: [f64; 3], b: [f64; 3]| -> [f64; 3] { std::array::from_fn(|c| a[c] + b[c]) };
        let of_facet = |place: usize| {
            let mut sum = 0.0;
            let facet = mesh.facets[surface.facets[place]];
            let tetrahedron = mesh.tetrahedra[behind[place]];
            self.visit(place, &laws, |point, law, weight| {
                let at = tetrahedron.map(|node| {
                    let corner = facet.iter().position(|n| *n == node);
                    corner.map_or(0.0, |corner| point.share[corner])
                });
                let [own, of_adjoint] = errors(place, &at).map(|e| in_frame(point.nodes[0], e));
                let z = sum3(interpolated(&nodal, point.nodes, &point.shape), of_adjoint);
                let change = law.change(sum3(point.moved(&self.moved), own));
                let wanted = match &adjoint.over {
                    None => law.wanted,
                    Some(part) => {
                        let place = quadrature::point(&mesh.corners(&facet), &point.share);
                        [part.density(place), 0.0, 0.0]
                    }
                };
                for c in 0..3 {
                    sum -= weight * self.share * (z[c] - wanted[c]) * change[c];
                }
                sum += weight * law.by_shift;
            });
            sum
        };
        (0..surface.facets.len()).map(of_facet).collect()
    }

    /// Visits the points of integration of a contact triangle with the law there and their weight in m².
    fn visit(&self, place: usize, laws: &[Law], mut visited: impl FnMut(FacePoint<'_>, Law, f64)) {
        let (mesh, surface) = (self.solved.mesh, self.contact.state.surface);
        let facet = surface.facets[place];
        if self.points[place].is_empty() {
            return;
        }
        let nodes = self.contact.nodes_of(mesh, place);
        let area = mesh.facet_area(facet);
        for at in &self.points[place] {
            let mut law = self.law_at(place, at.share, laws);
            if let Some(model) = &self.varying[surface.face_number(place)] {
                let corners = mesh.corners(&mesh.facets[facet]);
                law.follow(model, quadrature::point(&corners, &at.share));
            }
            let point = FacePoint {
                nodes: &nodes,
                shape: mesh.facet_shape(&at.share),
                share: at.share,
                beyond_nodes: at.beyond_nodes,
            };
            visited(point, law, at.weight * area);
        }
    }
}

/// A point of integration on a contact triangle.
struct FacePoint<'a> {
    /// Contact nodes of the triangle.
    nodes: &'a [usize],
    /// Their shape functions here.
    shape: Vec<f64>,
    /// Its barycentric coordinates.
    share: [f64; 3],
    /// As [`ContactPoint::beyond_nodes`].
    beyond_nodes: f64,
}

impl FacePoint<'_> {
    /// (u_ν − d, u_t1, u_t2) here in m, from its values at the nodes.
    fn moved(&self, nodal: &[[f64; 3]]) -> [f64; 3] {
        let [depth, first, second] = interpolated(nodal, self.nodes, &self.shape);
        [depth - self.beyond_nodes, first, second]
    }
}

/// The multiplier of a pane, its local stiffness and its ellipse.
fn law_of(
    contact: &SolvedContact<'_>,
    solved: &Solved<'_>,
    known: &SolutionData<'_>,
    pane: usize,
) -> Law {
    let layout = contact.coupling.layout;
    let multiplier = &solved.solution.multiplier;
    let area = contact.state.surface.pane_area[pane];
    let pair = layout.tangential(pane);
    let shear = pair.map_or([0.0; 2], |pair| pair.map(|j| multiplier[j]));
    let friction = known.panes[pane].friction;
    let coulomb = friction.and_then(|friction| friction.coulomb);
    let coulomb = contact.state.interface.coulomb().zip(coulomb);
    Law {
        stress: [multiplier[pane], shear[0], shear[1]],
        stiffness: [
            known.stiffness[pane] * area,
            pair.map_or(0.0, |[j, _]| known.stiffness[j] * area),
        ],
        semi_axes: friction.map_or([0.0; 2], |f| f.semi_axes),
        // F dg/dλ_ν.
        axes_by_pressure: coulomb.map_or([0.0; 2], |(law, here)| {
            let slope = law.slip_bound_slope(pane, multiplier[pane]);
            here.coefficients.map(|f| f * slope)
        }),
        shift: 0.0,
        wanted: [0.0; 3],
        by_shift: 0.0,
    }
}

/// The m in m for which Σ w max(λ + k (d + m), 0) = Σ w λ over points with [w, λ, k, d], by Newton's method from the m of points that all
/// stay pressed: of a convex function it comes down to the root from there.
fn settlement(points: &[[f64; 4]]) -> f64 {
    let sum = |of: &dyn Fn(&[f64; 4]) -> f64| points.iter().map(of).sum::<f64>();
    let mut shift = -sum(&|[w, _, k, d]| w * k * d) / sum(&|[w, _, k, _]| w * k);
    // An estimate needs no more than three digits of the force.
    let enough = 1e-3 * sum(&|[w, pressure, _, _]| w * pressure);
    // Each step opens a point or is the last; rounding of k d may hide a force that is small beside it.
    for _ in 0..=points.len() {
        let trial = |[_, pressure, k, d]: &[f64; 4]| pressure + k * (d + shift);
        let excess = sum(&|p| p[0] * (trial(p).max(0.0) - p[1]));
        let slope = sum(&|p| if trial(p) > 0.0 { p[0] * p[2] } else { 0.0 });
        if excess <= enough || slope <= 0.0 || excess.is_nan() {
            break;
        }
        shift -= excess / slope;
    }
    shift
}

/// The friction of each contact face in the order of their multipliers, where a formula may differ inside panes from their means; `None`
/// where it does not, or follows the slip.
pub(super) fn varying_friction(scene: &Scene) -> Vec<Option<FrictionModel>> {
    let features = scene.contact_features().into_iter();
    let varies = |model: &FrictionModel| {
        let of_place = model.bound.place_dependent();
        let bound_varies = of_place.is_some_and(|(_, stress)| stress.depends_on_place());
        let law = &model.coefficients;
        (bound_varies || law.depends_on_place()) && !law.depends_on_slip()
    };
    features.map(|face| face.friction.filter(varies)).collect()
}

/// (u_ν − d, u_t1, u_t2) at the contact nodes in m, `[n_contact_nodes]`; tangential ones since the step began.
pub(in crate::post) fn displacements(
    contact: &SolvedContact<'_>,
    known: &SolutionData<'_>,
) -> Vec<[f64; 3]> {
    let surface = contact.state.surface;
    let interface = contact.state.interface;
    let nodes = surface.nodes.iter().enumerate();
    nodes
        .map(|(local, &node)| {
            let at_node = |node: usize| known.displacement[node];
            let frame = &interface.frame;
            let u = frame.relative(local, node, at_node, |row| known.tools[row]);
            let normal = interface.frame.normal_part(local, u);
            let gap = interface.gap.as_ref().map_or(0.0, |gap| gap[local]);
            let [first, second] = interface.frame.tangential(local, u);
            let from = interface.slip_origin(local);
            [normal - gap, first - from[0], second - from[1]]
        })
        .collect()
}
