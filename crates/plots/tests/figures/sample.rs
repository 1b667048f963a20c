//! A synthetic solved problem for the tests.

use contact3d_plots::{ContactPicture, DrawnFriction, DrawnZone, FrictionKind};
use units::Units;

/// Owned arrays of a [`ContactPicture`].
pub(crate) struct Sample {
    pub(crate) title: String,
    pub(crate) coordinates: Vec<[f64; 3]>,
    pub(crate) displacement: Vec<[f64; 3]>,
    pub(crate) boundary_triangles: Vec<[usize; 3]>,
    pub(crate) contact_triangles: Vec<[usize; 3]>,
    pub(crate) contact_triangle_pane: Vec<usize>,
    pub(crate) pressure: Vec<f64>,
    pub(crate) friction: Vec<DrawnFriction>,
}

impl Sample {
    /// A brick of `size` on z = 0 in `cells` cubes, panes of 2 × 2 cube faces, bent upwards at its
    /// far end.
    pub(crate) fn brick(size: [f64; 3], cells: [usize; 3]) -> Self {
        let [nx, ny, nz] = cells;
        let node = |i: usize, j: usize, k: usize| i + (nx + 1) * (j + (ny + 1) * k);
        let mut coordinates = Vec::new();
        let mut displacement = Vec::new();
        for k in 0..=nz {
            for j in 0..=ny {
                for i in 0..=nx {
                    let [s, t, r] = [(i, nx), (j, ny), (k, nz)].map(|(a, n)| a as f64 / n as f64);
                    coordinates.push([s * size[0], t * size[1], r * size[2]]);
                    let lift = (s - 0.55).max(0.0).powi(2) * 1.5 - 0.3 * r * (1.0 - s);
                    let slide = s * (0.6 + 0.5 * r) - 0.4 * lift * r;
                    displacement.push([3e-4 * slide, 3e-5 * (t - 0.5) * s, 1.1e-3 * lift]);
                }
            }
        }
        let mut sample = Self {
            title: "Steel brick on a rigid support, n_div = 16".to_owned(),
            coordinates,
            displacement,
            boundary_triangles: Vec::new(),
            contact_triangles: Vec::new(),
            contact_triangle_pane: Vec::new(),
            pressure: Vec::new(),
            friction: Vec::new(),
        };
        for j in 0..ny {
            for i in 0..nx {
                let bottom = [
                    node(i, j, 0),
                    node(i, j + 1, 0),
                    node(i + 1, j + 1, 0),
                    node(i + 1, j, 0),
                ];
                sample.quadrilateral(bottom);
                sample.quadrilateral(
                    [(0, 0), (1, 0), (1, 1), (0, 1)].map(|(p, q)| node(i + p, j + q, nz)),
                );
                let pane = i / 2 + nx.div_ceil(2) * (j / 2);
                let [a, b, c, d] = bottom;
                sample.contact_triangles.extend([[a, b, c], [a, c, d]]);
                sample.contact_triangle_pane.extend([pane, pane]);
            }
        }
        for k in 0..nz {
            for i in 0..nx {
                let side =
                    |j: usize| [(0, 0), (1, 0), (1, 1), (0, 1)].map(|(p, q)| node(i + p, j, k + q));
                sample.quadrilateral(side(0));
                let [a, b, c, d] = side(ny);
                sample.quadrilateral([d, c, b, a]);
            }
            for j in 0..ny {
                let side =
                    |i: usize| [(0, 0), (1, 0), (1, 1), (0, 1)].map(|(p, q)| node(i, j + p, k + q));
                sample.quadrilateral(side(nx));
                let [a, b, c, d] = side(0);
                sample.quadrilateral([d, c, b, a]);
            }
        }
        sample.contact_fields(nx.div_ceil(2), ny.div_ceil(2));
        sample
    }

    fn quadrilateral(&mut self, [a, b, c, d]: [usize; 4]) {
        self.boundary_triangles.extend([[a, b, c], [a, c, d]]);
    }

    /// A pressure gradient with an open end, slip in the middle, and ramps of friction between 0.2
    /// and 0.3.
    fn contact_fields(&mut self, panes_1: usize, panes_2: usize) {
        for j in 0..panes_2 {
            for i in 0..panes_1 {
                let s = (i as f64 + 0.5) / panes_1 as f64;
                let t = (j as f64 + 0.5) / panes_2 as f64 - 0.5;
                let pressure = (3.7e7 * (0.8 - s - 0.3 * t * t)).max(0.0);
                let coefficients = [
                    0.3 - 0.1 * (1.6 * s - 0.2).clamp(0.0, 1.0),
                    0.3 - 0.1 * (2.0 * s * t.abs()).clamp(0.0, 1.0),
                ];
                let load = (1.5 * s + 0.3 * t.abs()).min(1.0);
                let zone = if pressure == 0.0 {
                    DrawnZone::Open
                } else if load < 1.0 {
                    DrawnZone::Stick
                } else {
                    DrawnZone::Slip
                };
                let angle = 0.4 + 1.5 * t;
                let contact = if zone == DrawnZone::Open { 0.0 } else { load };
                self.pressure.push(pressure);
                self.friction.push(DrawnFriction {
                    scaled_tangential: contact * pressure,
                    semi_axes: coefficients,
                    stress: [
                        -contact * coefficients[0] * angle.cos(),
                        -contact * coefficients[1] * angle.sin(),
                    ],
                    turn: 0.0,
                    zone,
                });
            }
        }
    }

    /// The sample as input of the figures.
    pub(crate) fn picture(&self) -> ContactPicture<'_> {
        ContactPicture {
            is_to_scale: false,
            title: &self.title,
            units: Units::SI,
            coordinates: &self.coordinates,
            displacement: &self.displacement,
            boundary_triangles: &self.boundary_triangles,
            bodies: &[],
            boundary_face: &[],
            contact_triangles: &self.contact_triangles,
            contact_triangle_pane: &self.contact_triangle_pane,
            normal: [0.0, 0.0, -1.0],
            obstacle: None,
            marks: &[],
            axis_1: [1.0, 0.0, 0.0],
            axis_2: [0.0, 1.0, 0.0],
            pressure: &self.pressure,
            friction: Some((FrictionKind::OverPressure, &self.friction)),
        }
    }
}
