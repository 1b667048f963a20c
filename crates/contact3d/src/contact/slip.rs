//! Slips: the interpolation r_h that makes them of tangential displacements (HKL §3), and where those of a load history begin.

use std::borrow::Cow;

use crate::{
    mesh::{ContactSurface, Mesh},
    scene::SlipMeasure,
};

/// φ = (r_h|u_t1|, r_h|u_t2|) at the contact nodes, from the signed (u_t1, u_t2) there.
#[derive(Debug, Clone)]
pub enum SlipOperator {
    /// The absolute values at the nodes.
    Lagrange,
    /// The means of the absolute values over the triangles around each node, HKL (3.19); the value itself at held nodes,
    /// 0 where they are held at zero. Integrals are exact for displacements that are linear on triangles.
    Clement(ClementStars),
}

/// The contact triangles around each node that is not held.
#[derive(Debug, Clone)]
pub struct ClementStars {
    /// Contact nodes of each triangle.
    triangles: Vec<[usize; 3]>,
    /// The triangles around each contact node, each with its share of their area.
    stars: Vec<Vec<(usize, f64)>>,
}

/// The derivative of φ by (u_t1, u_t2), one-sided where a displacement vanishes.
#[derive(Debug, Clone)]
pub enum SlipOperatorDerivative {
    /// The signs of both components at each node; 0 for 0.
    Signs(Vec<[f64; 2]>),
    /// For each node the nodes around it with the derivatives of both components by their own.
    Rows(Vec<Vec<(usize, [f64; 2])>>),
}

impl SlipOperator {
    /// φ at the contact nodes in m.
    #[must_use]
    pub fn slip(&self, tangential: &[[f64; 2]]) -> Vec<[f64; 2]> {
        match self {
            Self::Lagrange => tangential.iter().map(|u| u.map(f64::abs)).collect(),
            Self::Clement(stars) => stars.slip(tangential),
        }
    }

    /// ∂φ/∂u_t at the contact nodes.
    #[must_use]
    pub fn derivative(&self, tangential: &[[f64; 2]]) -> SlipOperatorDerivative {
        match self {
            Self::Lagrange => {
                let sign = |u: f64| if u == 0.0 { 0.0 } else { u.signum() };
                SlipOperatorDerivative::Signs(tangential.iter().map(|u| u.map(sign)).collect())
            }
            Self::Clement(stars) => SlipOperatorDerivative::Rows(stars.derivative(tangential)),
        }
    }
}

impl SlipOperatorDerivative {
    /// The change of φ with a change of (u_t1, u_t2) at the nodes.
    pub fn apply(&self, moved: impl Fn(usize) -> [f64; 2]) -> Vec<[f64; 2]> {
        let scaled = |node: usize, by: &[f64; 2]| {
            let moved = moved(node);
            [by[0] * moved[0], by[1] * moved[1]]
        };
        match self {
            Self::Signs(signs) => {
                let nodes = signs.iter().enumerate();
                nodes.map(|(node, sign)| scaled(node, sign)).collect()
            }
            Self::Rows(rows) => {
                let sum = |row: &Vec<(usize, [f64; 2])>| {
                    row.iter().fold([0.0; 2], |sum, (node, by)| {
                        let change = scaled(*node, by);
                        [sum[0] + change[0], sum[1] + change[1]]
                    })
                };
                rows.iter().map(sum).collect()
            }
        }
    }

    /// The transpose of [`Self::apply`], for values at the nodes.
    #[must_use]
    pub fn transposed(&self, values: &[[f64; 2]]) -> Vec<[f64; 2]> {
        match self {
            Self::Signs(_) => self.apply(|node| values[node]),
            Self::Rows(rows) => {
                let mut sums = vec![[0.0; 2]; values.len()];
                for (row, value) in rows.iter().zip(values) {
                    for (node, by) in row {
                        for k in 0..2 {
                            sums[*node][k] += by[k] * value[k];
                        }
                    }
                }
                sums
            }
        }
    }
}

impl ClementStars {
    pub(super) fn new(
        surface: &ContactSurface,
        mesh: &Mesh,
        is_held: impl Fn(usize) -> bool,
    ) -> Self {
        let facets = surface.facets.iter().enumerate();
        let triangles: Vec<[usize; 3]> = facets
            .map(|(place, &facet)| surface.contact_nodes(place, mesh.facets[facet]))
            .collect();
        let mut stars = vec![Vec::new(); surface.nodes.len()];
        for (t, (nodes, &facet)) in triangles.iter().zip(&surface.facets).enumerate() {
            for &node in nodes.iter().filter(|&&n| !is_held(surface.nodes[n])) {
                stars[node].push((t, mesh.facet_area(facet)));
            }
        }
        for star in &mut stars {
            let whole: f64 = star.iter().map(|(_, area)| area).sum();
            star.iter_mut().for_each(|(_, area)| *area /= whole);
        }
        Self { triangles, stars }
    }

    fn slip(&self, tangential: &[[f64; 2]]) -> Vec<[f64; 2]> {
        let means: Vec<[f64; 2]> = self.of_triangles(tangential, |mean, _| mean);
        let star = |(star, own): (&Vec<(usize, f64)>, &[f64; 2])| {
            if star.is_empty() {
                own.map(f64::abs)
            } else {
                [0, 1].map(|k| star.iter().map(|(t, share)| share * means[*t][k]).sum())
            }
        };
        self.stars.iter().zip(tangential).map(star).collect()
    }

    fn derivative(&self, tangential: &[[f64; 2]]) -> Vec<Vec<(usize, [f64; 2])>> {
        let slopes: Vec<[[f64; 3]; 2]> = self.of_triangles(tangential, |_, slope| slope);
        let row = |star: &Vec<(usize, f64)>| {
            let mut row: Vec<(usize, [f64; 2])> = Vec::new();
            for &(t, share) in star {
                for (corner, node) in self.triangles[t].into_iter().enumerate() {
                    let by = [0, 1].map(|k| share * slopes[t][k][corner]);
                    match row.iter_mut().find(|(n, _)| *n == node) {
                        Some((_, sum)) => *sum = [sum[0] + by[0], sum[1] + by[1]],
                        None => row.push((node, by)),
                    }
                }
            }
            row
        };
        self.stars.iter().map(row).collect()
    }

    /// What is taken of the mean of |u_ti| and its slope, for each triangle and both components.
    fn of_triangles<T: Copy>(
        &self,
        tangential: &[[f64; 2]],
        take: impl Fn(f64, [f64; 3]) -> T,
    ) -> Vec<[T; 2]> {
        let each = self.triangles.iter().map(|nodes| {
            [0, 1].map(|k| {
                let (mean, slope) = mean_absolute(nodes.map(|n| tangential[n][k]));
                take(mean, slope)
            })
        });
        each.collect()
    }
}

/// The mean over a triangle of the absolute value of a linear function with given values at the corners, and its derivatives
/// by these: the means of sign times barycentric coordinates.
///
/// Where one corner has its own sign, the function is split at shares s and t of the edges there; the part beyond the cut is
/// a triangle of s t times the area.
fn mean_absolute(values: [f64; 3]) -> (f64, [f64; 3]) {
    let negative = values.iter().filter(|v| **v < 0.0).count();
    let whole = match negative {
        0 | 1 => 1.0,
        _ => -1.0,
    };
    let upright = values.map(|v| whole * v);
    let Some(corner) = upright.iter().position(|v| *v < 0.0) else {
        let slope = if values == [0.0; 3] { 0.0 } else { whole / 3.0 };
        return (upright.iter().sum::<f64>() / 3.0, [slope; 3]);
    };
    let [next, last] = [(corner + 1) % 3, (corner + 2) % 3];
    let depth = -upright[corner];
    let [s, t] = [next, last].map(|other| depth / (upright[other] + depth));
    let mut slope = [1.0 / 3.0; 3];
    slope[corner] -= 2.0 * s * t * (3.0 - s - t) / 3.0;
    slope[next] -= 2.0 * s * s * t / 3.0;
    slope[last] -= 2.0 * s * t * t / 3.0;
    let mean = upright.iter().sum::<f64>() / 3.0 + 2.0 * depth * s * t / 3.0;
    (mean, slope.map(|d| whole * d))
}

#[cfg(test)]
mod tests {
    use super::*;
    use proptest::prelude::*;

    /// The mean by the midpoints of n² small triangles.
    fn sampled(values: [f64; 3], n: usize) -> f64 {
        let mut sum = 0.0;
        let mut add = |i: f64, j: f64| {
            let (x, y) = (i / n as f64, j / n as f64);
            sum += (values[0] * (1.0 - x - y) + values[1] * x + values[2] * y).abs();
        };
        for (i, j) in (0..n).flat_map(|i| (0..n - i).map(move |j| (i as f64, j as f64))) {
            add(i + 1.0 / 3.0, j + 1.0 / 3.0);
            if i + j + 1.0 < n as f64 {
                add(i + 2.0 / 3.0, j + 2.0 / 3.0);
            }
        }
        sum / (n * n) as f64
    }

    proptest! {
        #[test]
        fn means_of_absolute_values_are_exact_and_homogeneous(a in -1.0..1.0_f64, b in -1.0..1.0_f64, c in -1.0..1.0_f64) {
            let (mean, slope) = mean_absolute([a, b, c]);
            // The triangles on the cut, a share of 1/n, are wrong by their size 1/n at most.
            prop_assert!((mean - sampled([a, b, c], 200)).abs() < 1e-4);
            // Euler's identity of functions of degree 1.
            prop_assert!((mean - (slope[0] * a + slope[1] * b + slope[2] * c)).abs() < 1e-14);
        }

        #[test]
        fn slopes_are_differences(a in -1.0..1.0_f64, b in -1.0..1.0_f64, c in -1.0..1.0_f64) {
            let step = 1e-6;
            let (_, slope) = mean_absolute([a, b, c]);
            for k in 0..3 {
                let at = |s: f64| {
                    let mut values = [a, b, c];
                    values[k] += s;
                    mean_absolute(values).0
                };
                // The slope changes by its second derivative, at most 1 over the largest value, on the way.
                let size = a.abs().max(b.abs()).max(c.abs());
                let difference = (at(step) - at(-step)) / (2.0 * step);
                prop_assert!((slope[k] - difference).abs() < 1e-9 + 10.0 * step / size);
            }
        }
    }

    #[test]
    fn signs_that_agree_give_the_mean_itself() {
        assert_eq!(mean_absolute([1.0, 2.0, 3.0]), (2.0, [1.0 / 3.0; 3]));
        assert_eq!(mean_absolute([-1.0, -2.0, -3.0]), (2.0, [-1.0 / 3.0; 3]));
        assert_eq!(mean_absolute([0.0; 3]), (0.0, [0.0; 3]));
    }
}

/// Where the contact nodes are when a step begins, and how far they have slid.
#[derive(Debug, Clone, PartialEq)]
pub struct PreviousIncrement {
    /// (u_t1, u_t2) that the slip of the step is counted from, `[n_contact_nodes]`, in m.
    pub tangential: Vec<[f64; 2]>,
    /// Lengths of the path of sliding: Σ r_h|Δu_t1|, Σ r_h|Δu_t2| and the sum of the roots of their squares,
    /// `[n_contact_nodes]`, in m.
    pub path: Vec<[f64; 3]>,
    /// The slip that coefficients of friction follow.
    pub follows: SlipMeasure,
}

/// How slips φ are made of the signed (u_t1, u_t2) at the contact nodes.
#[derive(Debug, Clone)]
pub struct SlipMap {
    /// r_h.
    pub operator: SlipOperator,
    /// Where the step begins; `None` in the first of a load history, and without a history.
    pub previous: Option<PreviousIncrement>,
}

impl SlipMap {
    /// r_h of the slips that coefficients follow at the contact nodes, for the signed (u_t1, u_t2) there, in m. A path of
    /// sliding from former steps is added by the law.
    #[must_use]
    pub fn slip(&self, tangential: &[[f64; 2]]) -> Vec<[f64; 2]> {
        self.operator.slip(&self.counted(tangential))
    }

    /// The derivative of [`Self::slip`] by (u_t1, u_t2).
    #[must_use]
    pub fn derivative(&self, tangential: &[[f64; 2]]) -> SlipOperatorDerivative {
        self.operator.derivative(&self.counted(tangential))
    }

    /// u_t less where the slip is counted from, where the law counts from there.
    fn counted<'u>(&self, tangential: &'u [[f64; 2]]) -> Cow<'u, [[f64; 2]]> {
        match &self.previous {
            Some(previous) if previous.follows != SlipMeasure::TotalSlip => {
                previous.slip(tangential).into()
            }
            _ => tangential.into(),
        }
    }
}

impl PreviousIncrement {
    /// u_t − u_tⁿ⁻¹ at the contact nodes in m.
    #[must_use]
    pub fn slip(&self, tangential: &[[f64; 2]]) -> Vec<[f64; 2]> {
        let pairs = tangential.iter().zip(&self.tangential);
        pairs
            .map(|(u, from)| [u[0] - from[0], u[1] - from[1]])
            .collect()
    }

    /// u_t1 or u_t2 where the step begins, `[n_contact_nodes]`, in m.
    #[must_use]
    pub fn component(&self, k: usize) -> Vec<f64> {
        self.tangential.iter().map(|u| u[k]).collect()
    }
}
