//! Normals and gaps between a contact face and its obstacle.
//!
//! With φ the signed distance from the obstacle, a point x of the body stays outside after a displacement u if
//! φ(x + u) ≥ 0. To first order in u that is u·ν ≤ d with ν = −∇φ(x) and d = φ(x): for small displacements the normal is
//! that of the obstacle at the point nearest to x, and the gap is measured along it. The body's own normal would leave
//! an error of first order in the angle between the two surfaces, and has no value at edges and corners.

mod flaws;
mod height;
mod stl;
mod surface_file;
mod triangulated;

use std::{collections::BTreeMap, path::Path, sync::Arc};

use nalgebra::Vector3;

use self::height::{Clearance, Graph};
pub use triangulated::TriangulatedSurface;
pub(super) use triangulated::beyond_straight;

use super::{GEOMETRY_TOLERANCE, Mesh, contact_parts::under, face_part::WHOLE_SIDE};
use crate::scene::{Contact, InvalidValue, Obstacle, Scene, Side, Written, place_words};

/// The share of a size below which a place touches a surface and directions are one: digits of single precision, in which STL files are
/// written.
const TOUCHING: f64 = 1e-6;

/// The obstacles of triangles in a scene with a body that is so large in m, by the numbers of their contacts; files are looked for in `folder`.
///
/// # Errors
/// A file that holds no surface.
pub(super) fn surfaces_of(
    scene: &Scene,
    folder: &Path,
    body: f64,
) -> Result<BTreeMap<usize, Arc<TriangulatedSurface>>, InvalidValue> {
    let mut surfaces = BTreeMap::new();
    for (entry, contact) in scene.contacts.iter().enumerate() {
        if let Some(Obstacle::Surface(file)) = &contact.obstacle {
            let surface = TriangulatedSurface::read(file, folder, body);
            let surface = surface.map_err(|it| under(&scene.contact_key(entry), it))?;
            surfaces.insert(entry, Arc::new(surface));
        }
    }
    Ok(surfaces)
}

/// The gap function of a face with some triangles and nodes before an obstacle, which may consist of triangles: its contact normals ν, one
/// where it is the same everywhere or one for each node, and its distance d in m along them for each node, d ≥ 0 without interference.
///
/// Depths up to [`depths_allowed`] count as touching, d = 0; on the sides of a mesh that was cut from a coarser
/// one also depths up to `inherited` in m, since they keep the shape of the first mesh.
///
/// # Errors
/// An obstacle that cuts the face, is on its other side, or has no normal at a node.
pub(super) fn gap_function(
    mesh: &Mesh,
    facets: &[usize],
    nodes: &[usize],
    contact: &Contact,
    obstacle: (&Obstacle, Option<&TriangulatedSurface>),
    inherited: f64,
) -> Result<(Vec<[f64; 3]>, Vec<f64>), InvalidValue> {
    let places = nodes.iter().map(|&node| mesh.coordinates[node]);
    let extent = extent(places.clone());
    let measured = Measured::new(obstacle, extent);
    let allowed = depths_allowed(mesh, facets, GEOMETRY_TOLERANCE * extent + inherited);
    if let Some(&node) = nodes.iter().find(|node| !allowed.contains_key(node)) {
        return Err(without_area(mesh.coordinates[node]));
    }
    let outward = outward_before(obstacle.0, mesh, facets);
    let (mut normals, mut clearance) = (Vec::new(), Vec::new());
    let mut cut = Penetration::default();
    for (&node, at) in nodes.iter().zip(places) {
        let outward = outward.get(&node).copied().unwrap_or_default();
        let seen = measured.from(at, &outward)?;
        cut.add(at, seen.distance, allowed[&node]);
        clearance.push(if contact.interference {
            seen.distance
        } else {
            seen.distance.max(0.0)
        });
        normals.push((-seen.away).into());
    }
    let mut faces_it = false;
    for &facet in facets {
        let most = mesh.facet_nodes(facet).map(|node| allowed[&node]);
        let most = most.fold(0.0, f64::max);
        for point in mesh.points_on(facet, &WHOLE_SIDE).1 {
            let seen = measured.from(point.at, &Vector3::zeros())?;
            cut.add(point.at, seen.distance, most);
            faces_it |= point.area.dot(&seen.away) < 0.0;
        }
    }
    if !contact.interference {
        cut.refuse(obstacle.0)?;
    }
    if !faces_it {
        return Err(turned_away(obstacle.0));
    }
    if measured.is_flat() {
        normals.truncate(1);
    }
    Ok((normals, clearance))
}

/// The outward normals of some triangles at their nodes, with lengths of any size, where an obstacle may have sharp edges that ask for them.
pub(crate) fn outward_before(
    obstacle: &Obstacle,
    mesh: &Mesh,
    facets: &[usize],
) -> BTreeMap<usize, Vector3<f64>> {
    let mut outward: BTreeMap<usize, Vector3<f64>> = BTreeMap::new();
    if !matches!(obstacle, Obstacle::Height(_) | Obstacle::Surface(_)) {
        return outward;
    }
    for (node, normal) in facets.iter().flat_map(|&facet| mesh.side_normals(facet)) {
        *outward.entry(node).or_default() += normal;
    }
    outward
}

/// The contact normal and the signed distance in m from an obstacle at each of some places, with the outward normals of the body there.
///
/// # Errors
/// A place where the obstacle has no normal.
pub(crate) fn distances_from(
    obstacle: (&Obstacle, Option<&TriangulatedSurface>),
    places: &[([f64; 3], Vector3<f64>)],
) -> Result<Vec<([f64; 3], f64)>, InvalidValue> {
    let measured = Measured::new(obstacle, extent(places.iter().map(|(at, _)| *at)));
    let seen = places.iter().map(|(at, outward)| {
        let seen = measured.from(*at, outward)?;
        Ok(((-seen.away).into(), seen.distance))
    });
    seen.collect()
}

/// The distance of a face from its obstacle between the nodes, where that is not the one of the nodes interpolated.
pub(crate) struct DistanceBetweenNodes<'a> {
    measured: Measured<'a>,
    /// φ in m, by node of the mesh.
    at_nodes: BTreeMap<usize, f64>,
    /// What a mesh leaves of a curved face around each node in m.
    faceting: BTreeMap<usize, f64>,
}

impl<'a> DistanceBetweenNodes<'a> {
    /// That of a face with some triangles and nodes; `None` where interpolation is exact, for a plane before flat triangles, and where
    /// a node has no distance.
    pub(crate) fn new(
        mesh: &Mesh,
        facets: &[usize],
        nodes: &[usize],
        obstacle: (&'a Obstacle, Option<&'a TriangulatedSurface>),
    ) -> Option<Self> {
        let places = nodes.iter().map(|&node| mesh.coordinates[node]);
        let extent = extent(places.clone());
        let measured = Measured::new(obstacle, extent);
        if measured.is_flat() {
            return None;
        }
        let pairs = nodes.iter().zip(places);
        let at_nodes = pairs
            .map(|(&node, at)| Some((node, measured.from(at, &Vector3::zeros()).ok()?.distance)));
        Some(Self {
            at_nodes: at_nodes.collect::<Option<_>>()?,
            faceting: faceting_of(mesh, facets, GEOMETRY_TOLERANCE * extent),
            measured,
        })
    }

    /// Whether the obstacle may have bumps between the nodes: a formula, or triangles.
    pub(crate) fn may_have_bumps(&self) -> bool {
        matches!(self.measured, Measured::Graph(_) | Measured::Triangles(_))
    }

    /// At a point of a triangle: by how much in m the obstacle is farther than the distances of its nodes with their shape functions say,
    /// and the contact normal there; what the mesh leaves of a curved face counts for nothing. `None` where the obstacle has no normal.
    pub(crate) fn at(
        &self,
        at: [f64; 3],
        nodes: &[usize],
        shape: &[f64],
    ) -> Option<(f64, [f64; 3])> {
        let seen = self.measured.from(at, &Vector3::zeros()).ok()?;
        let terms = nodes.iter().zip(shape);
        let interpolated: f64 = terms.map(|(node, shape)| shape * self.at_nodes[node]).sum();
        let faceting = nodes.iter().map(|node| self.faceting[node]);
        let beyond = seen.distance - interpolated;
        let counted = (beyond.abs() - faceting.fold(0.0, f64::max)).max(0.0);
        Some((counted.copysign(beyond), (-seen.away).into()))
    }
}

/// As [`depths_allowed`], and what quadratic sides leave of a curved face: with edges h, and normals that turn by θ on a side, less than
/// hθ²/8, the part of its depth hθ/8 that they do not have.
fn faceting_of(mesh: &Mesh, facets: &[usize], digits: f64) -> BTreeMap<usize, f64> {
    let mut depths = depths_allowed(mesh, facets, digits);
    if mesh.mid_edges.is_none() {
        return depths;
    }
    for &facet in facets {
        let normals = mesh.side_normals(facet);
        let pairs = normals
            .iter()
            .flat_map(|(_, n)| normals.iter().map(move |(_, m)| (n - m).norm()));
        let turn = pairs.fold(0.0, f64::max);
        let longest = mesh.longest_edge(facet);
        for node in mesh.facet_nodes(facet) {
            let depth = depths.entry(node).or_default();
            *depth = depth.max(digits + longest * turn * turn / 8.0);
        }
    }
    depths
}

/// What a mesh leaves of a curved face at most, in m, or the share of it that is told by the angle in radians between its triangles.
pub(super) fn faceting(mesh: &Mesh, facets: &[usize], share: impl Fn(f64) -> f64) -> f64 {
    let depths = shares_of_depths(mesh, facets, 0.0, share);
    depths.values().copied().fold(0.0, f64::max)
}

/// Largest distance of a place from the first one in m.
fn extent(mut places: impl Iterator<Item = [f64; 3]>) -> f64 {
    let first = Vector3::from(places.next().unwrap_or_default());
    let distances = places.map(|at| (Vector3::from(at) - first).norm());
    distances.fold(0.0, f64::max)
}

/// How far in m each node may lie inside the obstacle and count as touching it: `digits`, what the digits of mesh files
/// leave, and on top what a mesh leaves of a curved face. A node whose triangles have no area is left out.
///
/// A face with curvature κ lies within κh²/6 of triangles with edges h, and normals of triangles around a node differ by
/// κh/√3 at least: half the product of that difference with h is no less than the distance.
fn depths_allowed(mesh: &Mesh, facets: &[usize], digits: f64) -> BTreeMap<usize, f64> {
    shares_of_depths(mesh, facets, digits, |_| 1.0)
}

/// The same with a share of what a mesh leaves of a curved face, told by the angle in radians between its triangles.
fn shares_of_depths(
    mesh: &Mesh,
    facets: &[usize],
    digits: f64,
    share: impl Fn(f64) -> f64,
) -> BTreeMap<usize, f64> {
    let mut around: BTreeMap<usize, Vec<(Vector3<f64>, f64)>> = BTreeMap::new();
    for &facet in facets {
        let longest = mesh.longest_edge(facet);
        for (node, normal) in mesh.side_normals(facet) {
            around.entry(node).or_default().push((normal, longest));
        }
    }
    let allowed = |sides: &Vec<(Vector3<f64>, f64)>| {
        let pairs = sides
            .iter()
            .flat_map(|one| sides.iter().map(move |other| (one, other)));
        let facets = pairs.filter(|((n, _), (m, _))| is_smooth(n, m));
        let depth = |turn: f64, longest: f64| 0.5 * turn * longest * share(turn);
        let most = facets.map(|((n, h), (m, k))| depth((n - m).norm(), h.max(*k)));
        digits + most.fold(0.0, f64::max)
    };
    let nodes = around.iter();
    nodes.map(|(node, sides)| (*node, allowed(sides))).collect()
}

/// Whether triangles with two normals are facets of a curved face: those that meet at more than 30° are an edge of the body.
pub(super) fn is_smooth(normal: &Vector3<f64>, other: &Vector3<f64>) -> bool {
    normal.dot(other) > 0.75_f64.sqrt()
}

/// The deepest place inside the obstacle.
#[derive(Default)]
struct Penetration {
    places: usize,
    deepest: Option<([f64; 3], f64, f64)>,
}

impl Penetration {
    fn add(&mut self, at: [f64; 3], distance: f64, allowed: f64) {
        // A distance that is not a number is no distance.
        if distance >= -allowed {
            return;
        }
        self.places += 1;
        let least = f64::NEG_INFINITY;
        let deepest = self.deepest.map_or(least, |(_, d, a)| d - a);
        if distance.is_nan() || -distance - allowed > deepest {
            self.deepest = Some((at, -distance, allowed));
        }
    }

    fn refuse(&self, obstacle: &Obstacle) -> Result<(), InvalidValue> {
        let Some((at, depth, allowed)) = self.deepest else {
            return Ok(());
        };
        Err(InvalidValue {
            key: format!("contact.obstacle.{}", obstacle.word()),
            expected: format!(
                "an obstacle outside the body; up to {allowed:.1e} deep counts as touching there"
            ),
            found: format!(
                "{} of the contact face inside it, the deepest by {} at {}",
                match self.places {
                    1 => "one place".to_owned(),
                    places => format!("{places} places"),
                },
                Written(&depth),
                place_words(at)
            ),
            help: match obstacle {
                Obstacle::HalfSpace(_) => "move it away by that depth, or write interference = true; normal points out of the obstacle, towards the body",
                Obstacle::Sphere(_) | Obstacle::Cylinder(_) => "move it away by that depth, or write interference = true; side says whether the body is outside or inside",
                Obstacle::Height(_) => "move it away by that depth, or write interference = true; direction points from the obstacle to the body",
                Obstacle::Surface(_) => "move it away by that depth, or write interference = true; seen from the body, corners go counter-clockwise",
            }
            .into(),
        })
    }
}

fn without_area(at: [f64; 3]) -> InvalidValue {
    InvalidValue {
        key: "contact.face".into(),
        expected: "triangles with an area around every node of the contact face".into(),
        found: format!("none around the node at {}", place_words(at)),
        help:
            "correct the mesh; lengths whose products vanish in double precision need another unit"
                .into(),
    }
}

fn turned_away(obstacle: &Obstacle) -> InvalidValue {
    InvalidValue {
        key: "contact.face".into(),
        expected: "a face that looks towards the obstacle".into(),
        found: format!(
            "one whose outward normals all point away from the {}",
            obstacle.word()
        ),
        help: "name the face on the obstacle's side of the body, or move the obstacle".into(),
    }
}

/// An obstacle that points can be measured from.
enum Measured<'a> {
    Plane {
        point: Vector3<f64>,
        away: Vector3<f64>,
    },
    Round {
        centre: Vector3<f64>,
        /// Direction of the axis; zero for a sphere.
        axis: Vector3<f64>,
        radius: f64,
        side: Side,
    },
    Graph(Graph<'a>),
    Triangles(&'a TriangulatedSurface),
}

impl<'a> Measured<'a> {
    /// An obstacle of a validated scene; `extent` in m is that of the face that it is near.
    fn new(
        (obstacle, triangles): (&'a Obstacle, Option<&'a TriangulatedSurface>),
        extent: f64,
    ) -> Self {
        let unit = |v: &[f64; 3]| {
            // Squares of very large or small components would overflow or vanish.
            let v = Vector3::from(*v);
            (v / v.amax()).normalize()
        };
        match obstacle {
            Obstacle::HalfSpace(half) => Self::Plane {
                point: half.point.into(),
                away: unit(&half.normal),
            },
            Obstacle::Sphere(sphere) => Self::Round {
                centre: sphere.centre.into(),
                axis: Vector3::zeros(),
                radius: sphere.radius,
                side: sphere.side,
            },
            Obstacle::Cylinder(cylinder) => Self::Round {
                centre: cylinder.point.into(),
                axis: unit(&cylinder.direction),
                radius: cylinder.radius,
                side: cylinder.side,
            },
            Obstacle::Height(height) => Self::Graph(Graph::new(height, extent)),
            Obstacle::Surface(_) => Self::Triangles(triangles.expect("read with the mesh")),
        }
    }

    /// φ and ∇φ at a point of a body with an outward normal there, which tells the sides of a sharp edge from each other and may be zero.
    ///
    /// # Errors
    /// A centre or an axis, where ∇φ has no direction; a height without a nearest point.
    fn from(&self, at: [f64; 3], outward: &Vector3<f64>) -> Result<Clearance, InvalidValue> {
        let x = Vector3::from(at);
        match self {
            Self::Plane { point, away } => Ok(Clearance {
                distance: (x - point).dot(away),
                away: *away,
            }),
            Self::Round {
                centre,
                axis,
                radius,
                side,
            } => {
                let from_centre = x - centre;
                let across = from_centre - axis * from_centre.dot(axis);
                let distance = across.norm();
                let Some(outward) = across.try_normalize(f64::EPSILON * radius) else {
                    return Err(no_direction(at));
                };
                Ok(Clearance {
                    distance: side.sign() * (distance - radius),
                    away: outward * side.sign(),
                })
            }
            Self::Graph(graph) => graph.from(at, outward),
            Self::Triangles(surface) => surface.from(at, outward),
        }
    }

    /// Whether ∇φ is the same everywhere.
    fn is_flat(&self) -> bool {
        match self {
            Self::Plane { .. } => true,
            Self::Round { .. } => false,
            Self::Graph(graph) => graph.is_level(),
            Self::Triangles(surface) => surface.is_flat(),
        }
    }
}

/// φ and ∇φ where several sides of a sharp edge or a kink are as near to a place as the nearest, but for `digits` in m, and rounding would
/// choose one: those of the side that faces the body most, or half-way between several that do alike, without a normal of the body all.
fn facing(first: Clearance, sides: &[Clearance], outward: &Vector3<f64>, digits: f64) -> Clearance {
    let faces = |side: &Clearance| -side.away.dot(outward) / outward.norm().max(f64::MIN_POSITIVE);
    let as_near = |side: &&Clearance| (side.distance - first.distance).abs() <= digits;
    let as_near = || sides.iter().filter(as_near);
    let most = as_near().map(faces).fold(f64::MIN, f64::max);
    let mut normals: Vec<Vector3<f64>> = Vec::new();
    for side in as_near().filter(|side| faces(side) >= most - TOUCHING.sqrt()) {
        let is_new = |n: &Vector3<f64>| (n - side.away).norm() > TOUCHING;
        if normals.iter().all(is_new) {
            normals.push(side.away);
        }
    }
    let mean: Vector3<f64> = normals.iter().sum::<Vector3<f64>>() / normals.len().max(1) as f64;
    match (&normals[..], mean.norm()) {
        ([], _) => first,
        ([away], _) => Clearance {
            away: *away,
            ..first
        },
        (_, length) if length > TOUCHING => Clearance {
            distance: first.distance / length,
            away: mean / length,
        },
        _ => first,
    }
}

fn no_direction(at: [f64; 3]) -> InvalidValue {
    InvalidValue {
        key: "contact.obstacle".into(),
        expected: "contact nodes away from the centre or axis of the obstacle".into(),
        found: format!("one there, at {}", place_words(at)),
        help: "the obstacle has no normal there; move it or make it larger".into(),
    }
}
