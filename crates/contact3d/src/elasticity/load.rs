//! Load vectors, and loads that do nothing.

use std::ops::{AddAssign, Mul};

use nalgebra::{DMatrix, Matrix3, Vector3};

use super::Element;
use crate::{
    linalg::UNIT_ROUNDING,
    mesh::{GEOMETRY_TOLERANCE, Mesh, SidePart, SidePoint, tetrahedron_volume},
    reference::{quadratic_tetrahedron, quadrature},
    scene::{
        BodyForce, Component, FaceLoad, Force, InvalidValue, Quantity, Scene, UNDEFINED, Warning,
        Written, place_words,
    },
};

/// Loads of a scene.
#[derive(Debug, Clone, Default)]
pub struct Loads<'a> {
    /// Those on faces.
    pub faces: Vec<FaceLoad<'a>>,
    /// The body force f.
    pub body_force: Option<&'a BodyForce>,
}

impl<'a> From<FaceLoad<'a>> for Loads<'a> {
    fn from(load: FaceLoad<'a>) -> Self {
        Self {
            faces: vec![load],
            body_force: None,
        }
    }
}

impl<'a> Loads<'a> {
    /// All loads of a scene.
    #[must_use]
    pub fn of(scene: &'a Scene) -> Self {
        Self {
            faces: scene.face_loads().collect(),
            body_force: scene.body_force.as_ref(),
        }
    }

    /// Consistent nodal forces ∫_{Γ_p} φ p + ∫_Ω φ f in N, `[n_nodes]`.
    ///
    /// Constants are integrated exactly on straight sides, whole or cut, formulas by Gauss points of degree 6 on
    /// triangles and 5 in tetrahedra.
    ///
    /// # Errors
    /// A formula that is not finite somewhere, and those of [`SurfaceLoad::new`].
    pub fn nodal_forces(&self, mesh: &Mesh) -> Result<Vec<[f64; 3]>, InvalidValue> {
        let mut load = vec![[0.0; 3]; mesh.coordinates.len()];
        for face_load in &self.faces {
            SurfaceLoad::new(*face_load, mesh)?.add_forces(mesh, &mut load)?;
        }
        if let Some(force) = self.body_force {
            add_body_force(force, mesh, &mut load)?;
        }
        Ok(load)
    }
}

/// A load on the triangles of a mesh that bear it.
#[derive(Debug, Clone)]
pub struct SurfaceLoad<'a> {
    /// The load of the scene.
    pub load: FaceLoad<'a>,
    /// The triangles, or what of them is loaded.
    pub sides: Vec<SidePart>,
    /// The traction of a total force; zero for other loads.
    spread: SpreadForce,
}

/// The force of a load on a node, integrated over a side cut in four or a tetrahedron cut in eight.
pub(crate) struct MissedForce {
    /// The node.
    pub(crate) node: usize,
    /// The whole force in N.
    whole: Vector3<f64>,
    /// What of it the quadrature over the whole side or tetrahedron misses in N.
    pub(crate) missed: Vector3<f64>,
}

impl MissedForce {
    fn between(
        fine: impl IntoIterator<Item = (usize, Vector3<f64>)>,
        coarse: impl IntoIterator<Item = (usize, Vector3<f64>)>,
    ) -> Vec<Self> {
        let all = fine.into_iter().zip(coarse);
        let force = |((node, whole), (_, coarse)): ((usize, Vector3<f64>), (usize, _))| Self {
            node,
            whole,
            missed: whole - coarse,
        };
        all.map(force).collect()
    }
}

impl<'a> SurfaceLoad<'a> {
    /// A load on a mesh.
    ///
    /// # Errors
    /// A box or a disc that holds nothing of the face; a total force that is not finite, or whose moment the loaded part is too narrow for.
    pub fn new(load: FaceLoad<'a>, mesh: &Mesh) -> Result<Self, InvalidValue> {
        let sides = mesh.sides_of(&load.key(), &load.part())?;
        let spread = match load {
            FaceLoad::Force(_, force) => SpreadForce::new(force, &load.key(), mesh, &sides)?,
            FaceLoad::Traction(..) | FaceLoad::Pressure(..) => SpreadForce::default(),
        };
        Ok(Self {
            load,
            sides,
            spread,
        })
    }

    /// σν in Pa at a place in m of the loaded part with some outward unit normal.
    #[must_use]
    pub fn at(&self, place: [f64; 3], normal: [f64; 3]) -> [f64; 3] {
        match self.load {
            FaceLoad::Traction(_, load) => load.value.each_ref().map(|value| value.at(place)),
            FaceLoad::Pressure(_, load) => {
                let pressure = load.value.at(place);
                normal.map(|part| -(part * pressure))
            }
            FaceLoad::Force(..) => self.spread.at(place).into(),
        }
    }

    /// Whether its components, one or three, are the same on all of some whole triangles.
    #[must_use]
    pub fn is_uniform(&self) -> bool {
        let is_constant = match self.load {
            FaceLoad::Traction(_, load) => !load.value.iter().any(Quantity::depends_on_place),
            FaceLoad::Pressure(_, load) => !load.value.depends_on_place(),
            FaceLoad::Force(..) => self.spread.turning == Vector3::zeros(),
        };
        is_constant && self.sides.iter().all(|side| side.cut.is_none())
    }

    /// What formulas do inside triangles beyond their quadrature, by sides; none of a load that is uniform.
    pub(crate) fn missed_forces(
        &self,
        mesh: &Mesh,
    ) -> impl Iterator<Item = (usize, Vec<MissedForce>)> {
        let varying = self.sides.iter().filter(|_| !self.is_uniform());
        varying.map(|side| {
            let fine = self.forces_on(mesh, side.facet, &side.quarters());
            let coarse = self.forces_on(mesh, side.facet, side.triangles());
            (side.facet, MissedForce::between(fine, coarse))
        })
    }

    /// ∫ |p − Πp|² dA in Pa² m² over whole sides, with what Π the shape functions can be of the load p there; none of a load that is uniform.
    pub(crate) fn unresolved(&self, mesh: &Mesh) -> impl Iterator<Item = (usize, f64)> {
        let varying = self.sides.iter().filter(|_| !self.is_uniform());
        varying.filter(|side| side.cut.is_none()).map(|side| {
            let (nodes, points) = mesh.points_on(side.facet, &side.quarters());
            let weight = |i: usize| points[i].area.norm().sqrt();
            let shape = |i: usize, node: usize| weight(i) * points[i].shape[node];
            let load = |i: usize, component: usize| {
                let normal = points[i].area.normalize().into();
                weight(i) * self.at(points[i].at, normal)[component]
            };
            let shapes = DMatrix::from_fn(points.len(), nodes.len(), shape).qr().q();
            let loads = DMatrix::from_fn(points.len(), 3, load);
            let missed = &loads - &shapes * shapes.tr_mul(&loads);
            (side.facet, missed.norm_squared())
        })
    }

    /// ∫ φ p over triangles of a side in N, with the node of each φ.
    fn forces_on(
        &self,
        mesh: &Mesh,
        facet: usize,
        triangles: &[[[f64; 3]; 3]],
    ) -> Vec<(usize, Vector3<f64>)> {
        let (nodes, points) = mesh.points_on(facet, triangles);
        let mut forces = vec![Vector3::zeros(); nodes.len()];
        for point in points {
            let normal = point.area.normalize().into();
            let force = Vector3::from(self.at(point.at, normal)) * point.area.norm();
            let shares = forces.iter_mut().zip(point.shape);
            shares.for_each(|(sum, shape)| *sum += force * shape);
        }
        nodes.into_iter().zip(forces).collect()
    }

    /// Adds ∫ φ p.
    fn add_forces(&self, mesh: &Mesh, load: &mut [[f64; 3]]) -> Result<(), InvalidValue> {
        let key = self.load.key() + ".value";
        for side in &self.sides {
            let (facet, curved) = ((mesh, side.facet), mesh.points_unless_plain(side));
            match self.load {
                FaceLoad::Traction(_, traction) => {
                    for (component, value) in traction.value.iter().enumerate() {
                        let norm = |area: Vector3<f64>| area.norm();
                        let shares = side_integrals(facet, curved.as_ref(), value, &key, norm)?;
                        for (node, share) in shares {
                            load[node][component] += share;
                        }
                    }
                }
                FaceLoad::Pressure(_, pressure) => {
                    let value = &pressure.value;
                    let shares = side_integrals(facet, curved.as_ref(), value, &key, |a| a)?;
                    for (node, share) in shares {
                        for c in 0..3 {
                            load[node][c] -= share[c];
                        }
                    }
                }
                FaceLoad::Force(..) => {
                    let (nodes, points) = mesh.points_of(side);
                    for point in points {
                        let force = self.spread.at(point.at) * point.area.norm();
                        for (node, shape) in nodes.iter().zip(point.shape) {
                            (0..3).for_each(|c| load[*node][c] += force[c] * shape);
                        }
                    }
                }
            }
        }
        Ok(())
    }
}

/// The traction a + ω × (x − x_c) that a total force spreads over the loaded part.
#[derive(Debug, Clone, Copy, Default)]
struct SpreadForce {
    /// a in Pa.
    uniform: Vector3<f64>,
    /// ω in Pa/m.
    turning: Vector3<f64>,
    /// The centroid x_c of the loaded part in m.
    centre: Vector3<f64>,
}

impl SpreadForce {
    /// With area A and J = ∫ (|r|² I − r rᵀ) of the part, r = x − x_c: a = F/A and Jω = M about x_c. The moments are those of the points
    /// at which nodal forces are integrated, so that these have the resultants F and M to rounding on any mesh.
    fn new(
        force: &Force,
        key: &str,
        mesh: &Mesh,
        sides: &[SidePart],
    ) -> Result<Self, InvalidValue> {
        let points = sides.iter().flat_map(|side| mesh.points_of(side).1);
        let points: Vec<(Vector3<f64>, f64)> =
            points.map(|p| (p.at.into(), p.area.norm())).collect();
        let area: f64 = points.iter().map(|(_, area)| area).sum();
        // From a place nearby: the part may be small and far from the origin.
        let near = points.first().map_or_else(Vector3::zeros, |(at, _)| *at);
        let arms = points.iter().map(|(at, area)| (at - near) * *area);
        let centre = near + arms.sum::<Vector3<f64>>() / area;
        let vector = |name: &str, values: &[Quantity; 3]| {
            let mut vector = Vector3::zeros();
            for (part, value) in vector.iter_mut().zip(values) {
                *part = finite_at(value, centre.into(), &format!("{key}.{name}"))?;
            }
            Ok(vector)
        };
        let total = vector("value", &force.value)?;
        let about = force.point.map_or(centre, Vector3::from);
        let moment = vector("moment", &force.moment)? + (about - centre).cross(&total);
        let mut spread = Self {
            uniform: total / area,
            turning: Vector3::zeros(),
            centre,
        };
        if moment != Vector3::zeros() {
            let second = points.iter().map(|(at, area)| {
                let r = at - centre;
                (Matrix3::identity() * r.norm_squared() - r * r.transpose()) * *area
            });
            let second: Matrix3<f64> = second.sum();
            let eigen = second.symmetric_eigen();
            if eigen.eigenvalues.min() < GEOMETRY_TOLERANCE.powi(2) * eigen.eigenvalues.max() {
                return Err(InvalidValue {
                    key: format!("{key}.moment"),
                    expected: "a part of the face that is wide enough to bear a moment".into(),
                    found: "one that is a line to six digits".into(),
                    help: "widen box, or write disc = { centre, radius } in its place".into(),
                });
            }
            let vectors = eigen.eigenvectors;
            let turn = |moment: Vector3<f64>| {
                vectors * (vectors.transpose() * moment).component_div(&eigen.eigenvalues)
            };
            spread.turning = turn(moment);
            // The large tractions of a moment on a small part leave a resultant by rounding; what is left of it is theirs again.
            for _ in 0..2 {
                let (mut force_left, mut moment_left) = (total, moment);
                for (at, area) in &points {
                    let traction = spread.at((*at).into()) * *area;
                    force_left -= traction;
                    moment_left -= (at - centre).cross(&traction);
                }
                spread.uniform += force_left / area;
                spread.turning += turn(moment_left);
            }
        }
        Ok(spread)
    }

    fn at(&self, place: [f64; 3]) -> Vector3<f64> {
        self.uniform + self.turning.cross(&(Vector3::from(place) - self.centre))
    }
}

/// ∫ φ_k value dA over a boundary triangle, or over points where it is curved or cut, with the node of each φ_k; `measure` makes dA of the outward
/// normal times area, in m².
fn side_integrals<V: Copy + AddAssign + Mul<f64, Output = V>>(
    (mesh, facet): (&Mesh, usize),
    curved: Option<&(Vec<usize>, Vec<SidePoint>)>,
    value: &Quantity,
    key: &str,
    measure: impl Fn(Vector3<f64>) -> V,
) -> Result<Vec<(usize, V)>, InvalidValue> {
    let Some((nodes, points)) = curved else {
        let nodes = mesh.facets[facet];
        let corners = mesh.corners(&nodes);
        let area = measure(area_vector(&corners));
        let means = hat_means(value, &corners, quadrature::triangle, key)?;
        return Ok(nodes
            .into_iter()
            .zip(means.map(|mean| area * mean))
            .collect());
    };
    let mut shares = [measure(Vector3::zeros()); 6];
    for point in points {
        let weighted = measure(point.area) * finite_at(value, point.at, key)?;
        for (share, shape) in shares.iter_mut().zip(point.shape) {
            *share += weighted * shape;
        }
    }
    Ok(nodes.iter().copied().zip(shares).collect())
}

const BODY_FORCE: &str = "body_force.value";

fn add_body_force(
    force: &BodyForce,
    mesh: &Mesh,
    load: &mut [[f64; 3]],
) -> Result<(), InvalidValue> {
    for t in 0..mesh.tetrahedra.len() {
        let body = (&mesh.corners(&mesh.tetrahedra[t]), &Element::of(mesh, t));
        for (component, value) in force.value.iter().enumerate() {
            let shares = body_shares(body, value, quadrature::tetrahedron)?;
            for (node, share) in mesh.tetrahedron_nodes(t).zip(shares) {
                load[node][component] += share;
            }
        }
    }
    Ok(())
}

/// ∫ φ_k value over a tetrahedron by a rule.
fn body_shares<I: Iterator<Item = ([f64; 4], f64)>>(
    (corners, element): (&[[f64; 3]; 4], &Element),
    value: &Quantity,
    rule: fn() -> I,
) -> Result<Vec<f64>, InvalidValue> {
    match element {
        Element::Linear(_) => {
            let volume = tetrahedron_volume(corners);
            let means = hat_means(value, corners, rule, BODY_FORCE)?;
            Ok(means.map(|mean| volume * mean).to_vec())
        }
        Element::Quadratic(simplex) => {
            let place = |at: &[f64; 4]| (quadrature::point(corners, at), simplex.volume);
            quadratic_shares(value, place, rule())
        }
        Element::Curved(curved) => quadratic_shares(value, |at| curved.place(at), rule()),
    }
}

/// What the formula of a body force does inside tetrahedra beyond its quadrature, by tetrahedra; none of one that does not vary.
pub(crate) fn missed_body_forces(
    force: &BodyForce,
    mesh: &Mesh,
) -> impl Iterator<Item = (usize, Vec<MissedForce>)> {
    let varies = force.value.iter().any(Quantity::depends_on_place);
    let tetrahedra = 0..if varies { mesh.tetrahedra.len() } else { 0 };
    tetrahedra.map(|t| {
        let body = (&mesh.corners(&mesh.tetrahedra[t]), &Element::of(mesh, t));
        // What is not finite was refused before.
        let fine = |value| body_shares(body, value, quadrature::eight_tetrahedra);
        let fine = force
            .value
            .each_ref()
            .map(|it| fine(it).unwrap_or_default());
        let coarse = |value| body_shares(body, value, quadrature::tetrahedron);
        let coarse = force
            .value
            .each_ref()
            .map(|it| coarse(it).unwrap_or_default());
        let nodal = |shares: [Vec<f64>; 3]| {
            let nodes = mesh.tetrahedron_nodes(t).enumerate();
            let at = move |k: usize| {
                shares
                    .each_ref()
                    .map(|of| of.get(k).copied().unwrap_or(0.0))
            };
            nodes.map(move |(k, node)| (node, at(k).into()))
        };
        let (fine, coarse) = (nodal(fine), nodal(coarse));
        (t, MissedForce::between(fine, coarse))
    })
}

/// ∫ φ_k value of the ten quadratic shape functions by points with their weights; `place` gives the point in m and the volume
/// of the whole tetrahedron as its Jacobian there says.
fn quadratic_shares(
    value: &Quantity,
    place: impl Fn(&[f64; 4]) -> ([f64; 3], f64),
    points: impl Iterator<Item = ([f64; 4], f64)>,
) -> Result<Vec<f64>, InvalidValue> {
    let mut shares = vec![0.0; 10];
    for (barycentric, weight) in points {
        let (at, volume) = place(&barycentric);
        let weighted = finite_at(value, at, BODY_FORCE)? * weight * volume;
        for (share, shape) in shares.iter_mut().zip(quadratic_tetrahedron(&barycentric)) {
            *share += weighted * shape;
        }
    }
    Ok(shares)
}

/// Means of value · φ_a over a simplex for its K hat functions φ_a.
fn hat_means<const K: usize, I: Iterator<Item = ([f64; K], f64)>>(
    value: &Quantity,
    corners: &[[f64; 3]; K],
    rule: fn() -> I,
    key: &str,
) -> Result<[f64; K], InvalidValue> {
    if let Some(constant) = value.constant() {
        return Ok([constant / K as f64; K]);
    }
    let mut means = [0.0; K];
    for (barycentric, weight) in rule() {
        let found = finite_at(value, quadrature::point(corners, &barycentric), key)?;
        for (mean, hat) in means.iter_mut().zip(barycentric) {
            *mean += weight * found * hat;
        }
    }
    Ok(means)
}

/// The value at a place in m.
fn finite_at(value: &Quantity, at: [f64; 3], key: &str) -> Result<f64, InvalidValue> {
    let found = value.at(at);
    if found.is_finite() {
        return Ok(found);
    }
    Err(InvalidValue {
        key: key.to_owned(),
        expected: "a formula that is finite on the whole face or body".into(),
        found: format!("{} at {}", Written(&found), place_words(at)),
        help: UNDEFINED.into(),
    })
}

/// Outward normal times area.
fn area_vector(corners: &[[f64; 3]; 3]) -> Vector3<f64> {
    let [a, b, c] = corners.map(Vector3::from);
    (b - a).cross(&(c - a)) / 2.0
}

/// The loads of a scene that draw a part of their face the other way, act on held displacements only, or do more inside triangles or tetrahedra than
/// is integrated.
#[must_use]
pub fn load_warnings(scene: &Scene, mesh: &Mesh) -> Vec<Warning> {
    // One that is not finite is refused elsewhere.
    let loads = scene.face_loads();
    let loads: Vec<_> = loads
        .filter_map(|load| SurfaceLoad::new(load, mesh).ok())
        .collect();
    let reversed = loads.iter().filter_map(|load| reversed_force(load, mesh));
    let idle = idle_loads(scene, mesh, &loads);
    reversed
        .chain(idle)
        .chain(unresolved_loads(scene, mesh, &loads))
        .collect()
}

/// The loads, or their components, that act on held displacements only.
fn idle_loads(scene: &Scene, mesh: &Mesh, loads: &[SurfaceLoad<'_>]) -> Vec<Warning> {
    // What acts on a face that is bonded to a free tool moves it.
    let held = match scene.n_free_tool_motions() {
        0 => mesh.held_nodes(scene),
        _ => mesh.held_by(&scene.clamps),
    };
    let on_faces = loads.iter().filter_map(|it| {
        let (load, mut forces) = (it.load, vec![[0.0; 3]; mesh.coordinates.len()]);
        it.add_forces(mesh, &mut forces).ok()?;
        let acting = acting_components(&forces);
        let idle = acting.iter().copied();
        let idle = idle.filter(|component| is_held(&forces, &held, *component));
        let components: Vec<Component> = idle.collect();
        let key = load.key() + ".value";
        match load {
            _ if components.is_empty() => None,
            FaceLoad::Traction(..) | FaceLoad::Force(..) => {
                Some(Warning::IdleLoad { key, components })
            }
            // A part of it alone cannot be left out.
            FaceLoad::Pressure(..) => {
                (components.len() == acting.len()).then_some(Warning::IdlePressure { key })
            }
        }
    });
    let whole = scene.body_force.iter().filter_map(|force| {
        let is_idle = |component: &Component| {
            let c = *component as usize;
            force.value[c] != Quantity::Constant(0.0) && held.iter().all(|held| held[c])
        };
        let components: Vec<Component> = Component::ALL.into_iter().filter(is_idle).collect();
        let key = BODY_FORCE.to_owned();
        (!components.is_empty()).then_some(Warning::IdleLoad { key, components })
    });
    on_faces.chain(whole).collect()
}

/// The loads whose integrals change where triangles are cut in four, or tetrahedra in eight: the quadrature does not see all of what formulas
/// do inside.
fn unresolved_loads(scene: &Scene, mesh: &Mesh, loads: &[SurfaceLoad<'_>]) -> Vec<Warning> {
    let told = |key: String, missed: &mut dyn Iterator<Item = (usize, Vec<MissedForce>)>| {
        let (mut apart, mut whole) = (0.0, 0.0);
        for (_, forces) in missed {
            let sum = |of: fn(&MissedForce) -> Vector3<f64>| -> Vector3<f64> {
                forces.iter().map(of).sum()
            };
            apart += sum(|it| it.missed).norm();
            whole += sum(|it| it.whole).norm();
        }
        let share = apart / whole;
        // A part of a hundredth is less than what a mesh of usual size misses of the solution.
        (share > 0.01).then_some(Warning::UnresolvedLoad { key, share })
    };
    let on_faces = loads
        .iter()
        .filter_map(|load| told(load.load.key() + ".value", &mut load.missed_forces(mesh)));
    let inside = scene.body_force.iter();
    let inside =
        inside.filter_map(|it| told(BODY_FORCE.to_owned(), &mut missed_body_forces(it, mesh)));
    on_faces.chain(inside).collect()
}

/// That the point of a total force lies so far from the middle of the loaded part that a part of that is drawn the other way.
fn reversed_force(load: &SurfaceLoad<'_>, mesh: &Mesh) -> Option<Warning> {
    let FaceLoad::Force(
        _,
        Force {
            point: Some(point),
            moment,
            ..
        },
    ) = load.load
    else {
        return None;
    };
    let along = load.spread.uniform;
    let corners = load
        .sides
        .iter()
        .flat_map(|side| mesh.corners(&mesh.facets[side.facet]));
    let is_reversed = |at: [f64; 3]| along.dot(&load.spread.at(at)) < 0.0;
    // Who gives a moment wants both ways.
    let has_moment = moment.iter().any(|part| *part != Quantity::Constant(0.0));
    (!has_moment && corners.into_iter().any(is_reversed)).then(|| Warning::ReversedForce {
        key: load.load.key() + ".point",
        point: *point,
    })
}

/// The components of nodal forces that are more than roundings of a face's normal.
fn acting_components(forces: &[[f64; 3]]) -> Vec<Component> {
    let limit = UNIT_ROUNDING * largest(forces);
    let acts = |component: &Component| {
        let mut along = forces.iter().map(|force| force[*component as usize].abs());
        along.any(|force| force > limit)
    };
    Component::ALL.into_iter().filter(acts).collect()
}

/// Whether a component of nodal forces acts on held displacements only.
fn is_held(forces: &[[f64; 3]], held: &[[bool; 3]], component: Component) -> bool {
    let (c, limit) = (component as usize, UNIT_ROUNDING * largest(forces));
    let mut free = forces.iter().zip(held).filter(|(_, held)| !held[c]);
    free.all(|(force, _)| force[c].abs() <= limit)
}

fn largest(forces: &[[f64; 3]]) -> f64 {
    let forces = forces.as_flattened().iter();
    forces.fold(0.0, |most, force| most.max(force.abs()))
}
