//! The frame (ν, t₁, t₂) of the contact face, fixed or turning from node to node.

use nalgebra::Vector3;

use crate::{
    mesh::{ContactSurface, Mesh},
    scene::{Contact, Invalid, UNDEFINED, Written, numbers, place_words},
};

/// The orthonormal frame (ν, t₁, t₂) of the contact face, with t₂ = t₁ × ν; normals and the axes of
/// friction may turn from node to node.
#[derive(Debug, Clone, PartialEq)]
pub struct ContactFrame {
    /// Outward unit normal ν: one for the whole face, or one for each contact node.
    pub normals: Vec<[f64; 3]>,
    /// (t₁, t₂): one pair for the whole face, or one for each contact node.
    pub axes: Vec<[[f64; 3]; 2]>,
    /// A normal that does not turn, to draw along: ν itself where it is the same everywhere,
    /// otherwise the direction of the mean over the nodes.
    pub reference_normal: [f64; 3],
    /// A pair that does not turn, to draw in: the axes themselves where they are the same everywhere,
    /// otherwise those of `reference_normal` in a scene without `axis_1` and `angle`.
    pub reference: [[f64; 3]; 2],
}

/// Share of an axis that may point along the normal: hand-typed digits.
const TANGENTIAL: f64 = 1e-6;

impl ContactFrame {
    /// The frame that a scene asks for, one pair of axes for the whole face unless it is `turning`.
    ///
    /// # Errors
    /// An axis that vanishes or is not tangential, an angle that is not finite.
    pub fn new(
        contact: &Contact,
        turning: bool,
        surface: &ContactSurface,
        mesh: &Mesh,
    ) -> Result<Self, Invalid> {
        let turns = turning || surface.normals.len() > 1;
        let places = if turns {
            surface.nodes.as_slice()
        } else {
            &surface.nodes[..1.min(surface.nodes.len())]
        };
        let axes: Vec<[[f64; 3]; 2]> = places
            .iter()
            .enumerate()
            .map(|(local, &node)| {
                let normal = Vector3::from(surface.normal_at(local));
                let first = first_axis(contact, &normal, mesh.coordinates[node])?;
                Ok([first.into(), first.cross(&normal).into()])
            })
            .collect::<Result<_, Invalid>>()?;
        let reference_normal = mean_direction(&surface.normals);
        let reference = match axes.as_slice() {
            [everywhere] => *everywhere,
            _ => {
                let first = default_axis(&reference_normal);
                [first.into(), first.cross(&reference_normal).into()]
            }
        };
        Ok(Self {
            normals: surface.normals.clone(),
            axes,
            reference_normal: reference_normal.into(),
            reference,
        })
    }

    /// ν at a contact node.
    #[must_use]
    pub fn normal_at(&self, contact_node: usize) -> [f64; 3] {
        match self.normals.as_slice() {
            [everywhere] => *everywhere,
            each => each[contact_node],
        }
    }

    /// (t₁, t₂) at a contact node.
    #[must_use]
    pub fn axes_at(&self, contact_node: usize) -> &[[f64; 3]; 2] {
        match self.axes.as_slice() {
            [everywhere] => everywhere,
            each => &each[contact_node],
        }
    }

    /// The mean of [`Self::vector`] over a pane: the stress that acts on it, since its two tangential
    /// components follow the axes of its nodes.
    #[must_use]
    pub fn pane_vector(
        &self,
        surface: &ContactSurface,
        pane: usize,
        normal: f64,
        tangential: [f64; 2],
    ) -> [f64; 3] {
        let weights = surface.pane_weights(pane);
        weights.fold([0.0; 3], |sum, (node, weight)| {
            let vector = self.vector(node, normal, tangential);
            std::array::from_fn(|c| sum[c] + weight * vector[c])
        })
    }

    /// The angle in radians by which the mean t₁ of a pane is turned from `reference`.
    #[must_use]
    pub fn mean_turn(&self, surface: &ContactSurface, pane: usize) -> f64 {
        if self.axes.len() == 1 {
            return 0.0;
        }
        let [right, up] = self.reference.map(Vector3::from);
        let mean: Vector3<f64> = surface
            .pane_weights(pane)
            .map(|(node, weight)| Vector3::from(self.axes_at(node)[0]) * weight)
            .sum();
        mean.dot(&up).atan2(mean.dot(&right))
    }

    /// (u·t₁, u·t₂) of a vector at a contact node.
    #[must_use]
    pub fn tangential(&self, contact_node: usize, vector: [f64; 3]) -> [f64; 2] {
        let u = Vector3::from(vector);
        self.axes_at(contact_node)
            .map(|axis| u.dot(&Vector3::from(axis)))
    }

    /// The component of a vector along ν at a contact node.
    #[must_use]
    pub fn normal_part(&self, contact_node: usize, vector: [f64; 3]) -> f64 {
        Vector3::from(vector).dot(&Vector3::from(self.normal_at(contact_node)))
    }

    /// λ_ν ν + λ_t1 t₁ + λ_t2 t₂ at a contact node.
    #[must_use]
    pub fn vector(&self, contact_node: usize, normal: f64, tangential: [f64; 2]) -> [f64; 3] {
        let [first, second] = self.axes_at(contact_node).map(Vector3::from);
        let outward = Vector3::from(self.normal_at(contact_node));
        let sum = outward * normal + first * tangential[0] + second * tangential[1];
        sum.into()
    }
}

fn first_axis(
    contact: &Contact,
    normal: &Vector3<f64>,
    place: [f64; 3],
) -> Result<Vector3<f64>, Invalid> {
    if let Some(axis) = &contact.axis_1 {
        let given = Vector3::from(axis.each_ref().map(|a| a.at(place)));
        // Only the direction counts; squares of very large or small components would overflow or vanish. A power of
        // two leaves every digit as it is.
        let given = match given.amax() {
            size if size > 0.0 && size.is_finite() => {
                given * 2.0_f64.powi((-size.log2() as i32).clamp(-1000, 1000))
            }
            _ => given,
        };
        let along = given.dot(normal);
        let tangential = along.abs() <= TANGENTIAL * given.norm();
        let flat = given - normal * along;
        return match flat.try_normalize(0.0) {
            Some(first) if tangential && first.iter().all(|v| v.is_finite()) => Ok(first),
            _ => Err(Invalid {
                key: "contact.axis_1".into(),
                expected: "a non-zero vector in the plane of the contact face".into(),
                found: format!(
                    "({}) at {}, where the normal is ({})",
                    numbers(given.as_slice()),
                    place_words(place),
                    numbers(normal.as_slice())
                ),
                help: "t1 must be tangential, for example [1.0, 0.0, 0.0] on z_min".into(),
            }),
        };
    }
    let first = default_axis(normal);
    let Some(angle) = &contact.angle else {
        return Ok(first);
    };
    let (sine, cosine) = angle.at(place).to_radians().sin_cos();
    if !sine.is_finite() {
        return Err(Invalid {
            key: "contact.angle".into(),
            expected: "a finite angle in degrees on the whole face".into(),
            found: format!("{} at {}", Written(&angle.at(place)), place_words(place)),
            help: UNDEFINED.into(),
        });
    }
    Ok(first * cosine + first.cross(normal) * sine)
}

/// The direction of the mean of unit vectors; that of a single one is itself. Where the mean vanishes, as on a
/// closed surface, the direction of z.
fn mean_direction(normals: &[[f64; 3]]) -> Vector3<f64> {
    if let [everywhere] = normals {
        return Vector3::from(*everywhere);
    }
    let sum: Vector3<f64> = normals.iter().map(|n| Vector3::from(*n)).sum();
    let least = TANGENTIAL * normals.len() as f64;
    sum.try_normalize(least).unwrap_or_else(Vector3::z)
}

/// The x axis projected on the face; the y axis where the face is perpendicular to x.
fn default_axis(normal: &Vector3<f64>) -> Vector3<f64> {
    let project = |axis: Vector3<f64>| (axis - normal * axis.dot(normal)).normalize();
    if normal.x.abs() > 1.0 - TANGENTIAL {
        project(Vector3::y())
    } else {
        project(Vector3::x())
    }
}
