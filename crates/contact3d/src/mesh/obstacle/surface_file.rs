//! The triangles of a surface file as an obstacle: corners that coincide are one point, and what is no surface is refused.

use std::{
    collections::{BTreeMap, BTreeSet},
    fs,
    path::Path,
};

use nalgebra::{Matrix2, Matrix3x2, Rotation3, Vector2, Vector3};
use rstar::{RTree, primitives::GeomWithData};

use super::{stl, triangulated::TriangulatedSurface};
use crate::{
    mesh::{GEOMETRY_TOLERANCE, extents, gmsh},
    scene::{InvalidValue, SurfaceFile, Written, place_words, require_regular},
};

/// How many times larger or smaller than the body a surface may be: between mm and m lies 1000, and a surface in the right unit is seldom
/// five times as large as the body or a fifth of it. A larger one can be cut, and no mesh of the body sees a smaller one.
const MISTAKEN_UNIT: f64 = 200.0;

impl TriangulatedSurface {
    /// The surface of a file that is looked for in `folder`, before a body that is so large in m.
    ///
    /// # Errors
    /// A file that is missing, is not the one of the digest, or holds no surface with an inside and an outside.
    pub(in crate::mesh) fn read(
        file: &SurfaceFile,
        folder: &Path,
        body: f64,
    ) -> Result<Self, InvalidValue> {
        let path = folder.join(&file.file);
        let invalid = |expected: &str, found: String, help: &str| InvalidValue {
            key: "contact.obstacle.surface.file".into(),
            expected: expected.into(),
            found: format!("{}: {found}", path.display()),
            help: help.into(),
        };
        let bytes = require_regular(&path).and_then(|()| fs::read(&path));
        let bytes = bytes.map_err(|error| {
            let help = "paths are relative to the scene file";
            invalid(
                "an STL or Gmsh file that can be read",
                error.to_string(),
                help,
            )
        })?;
        let digest = blake3::hash(&bytes).to_hex();
        if let Some(given) = &file.digest
            && !given.eq_ignore_ascii_case(&digest)
        {
            return Err(InvalidValue {
                key: "contact.obstacle.surface.digest".into(),
                expected: "the digest of the file".into(),
                found: digest.to_string(),
                help: "the file has changed; remove the key to accept it".into(),
            });
        }
        let mut stated = if bytes.starts_with(b"$MeshFormat") {
            gmsh::triangles(&bytes, file.face.as_deref()).map_err(|flaw| {
                let place = flaw.place.map(|place| format!("{place}: "));
                let found = place.unwrap_or_default() + &flaw.found;
                invalid(&flaw.expected, found, flaw.help)
            })?
        } else if let Some(face) = &file.face {
            return Err(InvalidValue {
                key: "contact.obstacle.surface.face".into(),
                expected: "no face beside an STL, which is one surface".into(),
                found: Written(face).to_string(),
                help: "leave the key out, or name a .msh file".into(),
            });
        } else {
            stl::parse(&bytes).map_err(|found| {
                let help = "export the surface as STL, text or binary, or mesh it by Gmsh; its triangles are the obstacle";
                invalid("an STL or Gmsh file", found, help)
            })?
        };
        let rotation = Rotation3::from_scaled_axis(Vector3::from(file.turn));
        for [normal, corners @ ..] in &mut stated {
            *normal = rotation * *normal;
            for place in corners {
                *place = Vector3::from(file.origin) + rotation * (*place * file.unit);
            }
        }
        let is_finite =
            |triangle: &[Vector3<f64>; 4]| triangle[1..].iter().flatten().all(|x| x.is_finite());
        if stated.is_empty() || !stated.iter().all(is_finite) {
            let found = if stated.is_empty() {
                "none"
            } else {
                "some not finite"
            };
            let help = "export the surface again";
            return Err(invalid("triangles with finite corners", found.into(), help));
        }
        let places = stated.iter().flat_map(|triangle| &triangle[1..]);
        let places: Vec<[f64; 3]> = places.map(|x| (*x).into()).collect();
        let extent = extents(&places).into_iter().fold(0.0, f64::max);
        let ratio = extent / body;
        if !(MISTAKEN_UNIT.recip()..=MISTAKEN_UNIT).contains(&ratio) {
            return Err(InvalidValue {
                key: "contact.obstacle.surface.unit".into(),
                expected: "a surface about as large as the body".into(),
                found: format!("an extent of {}, that of the body is {}", Written(&extent), Written(&body)),
                help: "is the file in millimetres and the scene in metres? then unit = 0.001; the other way round unit = 1000".into(),
            });
        }
        let digits = GEOMETRY_TOLERANCE * extent;
        let mut surface = Self::merged(&stated, digits);
        let at_edge = surface.checked_edges().and_then(|at_edge| {
            surface.refuse_cracks(&at_edge)?;
            surface.refuse_cuts(digits)?;
            Ok(at_edge)
        });
        let at_edge =
            at_edge.map_err(|(found, help)| invalid("a surface with two sides", found, help))?;
        surface.normals = surface.corner_normals(&at_edge, file.sharp_angle.to_radians().cos());
        Ok(surface)
    }

    /// Points no nearer to each other than some digits in m, triangles of them with the normals that the file gives; triangles that
    /// collapse are left out.
    fn merged(stated: &[[Vector3<f64>; 4]], digits: f64) -> Self {
        let mut tree: RTree<GeomWithData<[f64; 3], usize>> = RTree::new();
        let mut known: BTreeMap<[u64; 3], usize> = BTreeMap::new();
        let mut points = Vec::new();
        let mut number = |x: &Vector3<f64>| {
            // −0 is 0.
            let x: [f64; 3] = (*x + Vector3::zeros()).into();
            *known.entry(x.map(f64::to_bits)).or_insert_with(|| {
                let same = tree.locate_within_distance(x, digits * digits);
                if let Some(same) = same.map(|item| item.data).min() {
                    return same;
                }
                tree.insert(GeomWithData::new(x, points.len()));
                points.push(x);
                points.len() - 1
            })
        };
        let all = stated.iter().map(|[normal, a, b, c]| {
            let corners = [number(a), number(b), number(c)];
            (corners, *normal)
        });
        let all = all.filter(|([a, b, c], _)| a != b && b != c && c != a);
        let (triangles, normals): (Vec<_>, Vec<_>) = all.unzip();
        let normals = normals
            .into_iter()
            .map(|normal| [normal.into(); 3])
            .collect();
        Self::new(points, triangles, normals)
    }

    /// The triangle at each edge as it goes round it.
    ///
    /// # Errors
    /// What was found and what to do: triangles without area, or that do not go round as their neighbours or as their normals say.
    fn checked_edges(&self) -> Result<BTreeMap<[usize; 2], usize>, (String, &'static str)> {
        let mut at_edge = BTreeMap::new();
        let (mut area, mut against) = (0.0, 0.0);
        for (number, triangle) in self.triangles.iter().enumerate() {
            let [a, b, c] = self.corners(number);
            let stated = Vector3::from(self.normals[number][0]);
            let place = place_words(((a + b + c) / 3.0).into());
            let normal = (b - a).cross(&(c - a));
            let longest = (b - a).norm().max((c - b).norm()).max((a - c).norm());
            // Single precision leaves less of a height than that.
            if normal.norm() <= 1e-7 * longest * longest {
                let found = format!("a triangle without area around {place}");
                return Err((found, "remesh the surface where it has slivers"));
            }
            area += normal.norm();
            against += normal.norm() * f64::from(u8::from(normal.dot(&stated) < 0.0));
            for k in 0..3 {
                let edge = [triangle[k], triangle[(k + 1) % 3]];
                if at_edge.insert(edge, number).is_some() {
                    let found = format!(
                        "neighbours that go round in opposite senses, or more than two triangles at an edge, around {place}"
                    );
                    return Err((
                        found,
                        "let a CAD or mesh program repair the normals, and leave inner walls out",
                    ));
                }
            }
        }
        if self.triangles.is_empty() {
            return Err((
                "triangles of no size alone".into(),
                "export the surface again",
            ));
        }
        if against > 0.5 * area {
            let found = "normals against the order of corners".to_owned();
            return Err((
                found,
                "seen from the body corners go counter-clockwise; let a CAD or mesh program orient the triangles",
            ));
        }
        Ok(at_edge)
    }

    /// The normals at the corners of each triangle: at each point means over triangles that edges with at least that cosine join.
    fn corner_normals(
        &self,
        at_edge: &BTreeMap<[usize; 2], usize>,
        least_cosine: f64,
    ) -> Vec<[[f64; 3]; 3]> {
        let mut normals = vec![[Vector3::zeros(); 3]; self.triangles.len()];
        let mut open = Vec::new();
        for (point, triangles) in self.around.iter().enumerate() {
            let mut left: BTreeSet<usize> = triangles.iter().copied().collect();
            while let Some(first) = left.pop_first() {
                let (mut fan, mut next, mut n_joints) = (vec![first], 0, 0);
                while let Some(&triangle) = fan.get(next) {
                    for other in self.beside(at_edge, triangle, point) {
                        let cosine = self.normal(triangle).dot(&self.normal(other));
                        n_joints += usize::from(cosine >= least_cosine);
                        if cosine >= least_cosine && left.remove(&other) {
                            fan.push(other);
                        }
                    }
                    next += 1;
                }
                let sum: Vector3<f64> = fan.iter().map(|t| self.weighted_normal(*t, point)).sum();
                let mean = sum.normalize();
                for &triangle in &fan {
                    let own = self.normal(triangle);
                    let normal = if mean.dot(&own) > 0.0 { mean } else { own };
                    normals[triangle][self.corner(triangle, point)] = normal;
                }
                if n_joints < 2 * fan.len() {
                    open.push((point, fan));
                }
            }
        }
        self.turn_at_borders(&mut normals, &open);
        let normals = normals.into_iter();
        normals.map(|corners| corners.map(Into::into)).collect()
    }

    /// Turns normals at points that smooth triangles do not surround, whose means are one-sided: on an arc the normals n at x and m at y
    /// make the same angle with the chord, n·(y − x) = −m·(y − x), which n obeys in the least squares of all chords.
    fn turn_at_borders(&self, normals: &mut [[Vector3<f64>; 3]], open: &[(usize, Vec<usize>)]) {
        let means = normals.to_vec();
        // Neighbours on the border turn as well: four passes leave a hundredth of what one does.
        for _ in 0..4 {
            let before = normals.to_vec();
            for (point, fan) in open {
                let mean = means[fan[0]][self.corner(fan[0], *point)];
                let first = Vector3::ith(mean.iamin(), 1.0).cross(&mean).normalize();
                let basis = Matrix3x2::from_columns(&[first, mean.cross(&first)]);
                let (mut matrix, mut rhs) = (Matrix2::zeros(), Vector2::zeros());
                for &triangle in fan {
                    let corner = self.corner(triangle, *point);
                    for other in [(corner + 1) % 3, (corner + 2) % 3] {
                        let [from, to] = [corner, other].map(|k| self.triangles[triangle][k]);
                        let chord =
                            Vector3::from(self.points[to]) - Vector3::from(self.points[from]);
                        let chord = chord.normalize();
                        let across = basis.tr_mul(&chord);
                        matrix += across * across.transpose();
                        rhs -= across * (before[triangle][other] + mean).dot(&chord);
                    }
                }
                let turn = matrix.cholesky().map(|it| basis * it.solve(&rhs));
                let turned = turn.map_or(mean, |turn| (mean + turn).normalize());
                for &triangle in fan {
                    if turned.dot(&self.normal(triangle)) > 0.0 {
                        normals[triangle][self.corner(triangle, *point)] = turned;
                    }
                }
            }
        }
    }

    /// The neighbours of a triangle across its edges at a point.
    fn beside(
        &self,
        at_edge: &BTreeMap<[usize; 2], usize>,
        triangle: usize,
        point: usize,
    ) -> impl Iterator<Item = usize> {
        let corners = self.triangles[triangle];
        let edges = (0..3).map(move |k| [corners[(k + 1) % 3], corners[k]]);
        let edges = edges.filter(move |edge| edge.contains(&point));
        edges.filter_map(|edge| at_edge.get(&edge).copied())
    }

    fn weighted_normal(&self, triangle: usize, point: usize) -> Vector3<f64> {
        let others = self.triangles[triangle].iter().filter(|p| **p != point);
        let squares = others.map(|p| {
            (Vector3::from(self.points[*p]) - Vector3::from(self.points[point])).norm_squared()
        });
        let [a, b, c] = self.corners(triangle);
        let double_area = (b - a).cross(&(c - a)).norm();
        self.normal(triangle) * (double_area / squares.product::<f64>())
    }
}
