//! The radii of Lemma 3.3 and the contraction bound (3.13) of HKL.

use super::{face::TriangulatedFace, quartic::triangle_rule, trace::TraceConstants};
use contact3d::{
    contact::{CoulombLaw, FrictionField, LawBounds},
    mesh::ContactSurface,
};

/// The norm of displacements that a set of constants is measured in.
#[derive(Debug, Clone, Copy, Default, PartialEq, Eq)]
pub enum DisplacementNorm {
    /// ‖v‖² = ∫|v|² + ∫|∇v|², HKL's norm of H¹(Ω)³; the unit of length weighs its parts.
    #[default]
    FirstSobolev,
    /// ‖v‖² = a(v, v), in which α = M = 1.
    Energy,
}

impl DisplacementNorm {
    /// Both.
    pub const ALL: [Self; 2] = [Self::FirstSobolev, Self::Energy];

    /// In words.
    #[must_use]
    pub fn words(self) -> &'static str {
        match self {
            Self::FirstSobolev => "H1 norm",
            Self::Energy => "energy norm",
        }
    }
}

/// Constants of the contact face alone, the same in every norm of displacements.
#[derive(Debug, Clone, Copy, Default, PartialEq)]
pub struct FaceConstants {
    /// h_Γ, the largest diameter of a contact triangle, in m.
    pub triangle_size: f64,
    /// H, the largest diameter of a pane, in m; h_Γ for nodal multipliers.
    pub pane_size: f64,
    /// c_inv⁽¹'⁰⁾ of (3.7).
    pub inverse_first: f64,
    /// c_inv⁽∞⁾ of (3.17).
    pub inverse_fourth: f64,
    /// c_t of HKL Lemma 3.2; 1 where the axes of friction do not turn.
    pub axes: f64,
    /// c_r of Lagrange interpolation on |Y^h|, where (3.6) uses it.
    pub lagrange: f64,
    /// c_r of (3.3) for Lagrange interpolation of linear functions on triangles cut in 2², 4² and 8².
    pub lagrange_finer: [f64; 3],
    /// The same for Clément's interpolation (3.19).
    pub clement_finer: [f64; 3],
}

/// Constants of one mesh in one norm of displacements; in the units of the scene, which (3.13) mixes.
#[derive(Debug, Clone, Copy, Default, PartialEq)]
pub struct NormConstants {
    /// The norm.
    pub norm: DisplacementNorm,
    /// α of (2.6) on V^h.
    pub ellipticity: f64,
    /// M of (2.7) on V^h.
    pub continuity: f64,
    /// ‖ℓ‖_* on V^h, below that on H¹(Ω)³.
    pub load: f64,
    /// c_inv⁽⁰'⁻¹ᐟ²⁾ of (3.16) with ‖·‖_{*,h} over V₀^h.
    pub inverse_half: f64,
    /// Traces.
    pub trace: TraceConstants,
    /// R₁ and R₂ of HKL Lemma 3.3.
    pub radii: Radii,
    /// Bounds of the contraction.
    pub bound: ContractionBound,
}

/// The radii of the set 𝒞(R₁, R₂) into which Ψ maps everything, HKL Lemma 3.3.
#[derive(Debug, Clone, Copy, Default, PartialEq)]
pub struct Radii {
    /// R₁, of ‖(φ₁, φ₂)‖_{0,Γ_c}.
    pub slip: f64,
    /// R₂, of ‖λ_ν‖_{*,h}.
    pub pressure: f64,
}

/// Bounds of the Lipschitz modulus of Ψ on 𝒞(R₁, R₂); all grow in proportion to the law of friction.
///
/// `sharp` is a proof, up to the rounding of eigenvalues, where the bounds of the law are. The others are if the law does not follow the
/// slip; else their term of L has c_tr⁽⁴⁾, which an ascent finds from below, and c_inv⁽∞⁾, so they may be too small.
#[derive(Debug, Clone, Copy, Default, PartialEq)]
pub struct ContractionBound {
    /// q of (3.13) in the norm ‖φ‖ + ‖μ‖, whose parts have different units: below 1 there is one solution, and the value
    /// depends on the units of the scene.
    pub paper: f64,
    /// The least bound of this kind with any weight between the parts, M a + c b: free of units in the energy norm.
    pub weighted: f64,
    /// The same with products of constants replaced by the bounds they stand for.
    pub sharp: f64,
    /// `weighted` for the friction functional of the program, averaged over panes or lumped.
    pub averaged: f64,
    /// The share of `weighted` that F_max makes; the rest is that of L.
    pub by_coefficient: f64,
}

/// What the bounds are made of.
pub(super) struct Ingredients<'a> {
    pub(super) face: &'a FaceConstants,
    pub(super) law: &'a LawBounds,
    pub(super) ellipticity: f64,
    pub(super) continuity: f64,
    pub(super) load: f64,
    pub(super) inverse_half: f64,
    pub(super) trace: TraceConstants,
    /// c_r of the scene's r_h.
    pub(super) interpolation: f64,
    /// The bound of the norm of r_h|v_t| by ‖v‖ that does without c_r.
    pub(super) interpolated: f64,
    /// Whether multipliers belong to nodes.
    pub(super) nodal: bool,
}

impl Ingredients<'_> {
    /// c_tr⁽²⁾ (c_inv⁽¹'⁰⁾ c_r c_t + 1), the bound of ‖(r_h|v_t1|, r_h|v_t2|)‖ by ‖v‖ in (3.6).
    fn interpolated_trace(&self) -> f64 {
        self.interpolated_trace_by(self.face.inverse_first)
    }

    /// The same with the inverse inequality for ‖∇ψ‖ alone, which (3.6) could use as well, as constants are interpolated
    /// exactly: unlike ‖ψ‖_1 it does not depend on the unit of length.
    fn interpolated_trace_by_gradient(&self) -> f64 {
        let (whole, size) = (self.face.inverse_first, self.face.triangle_size);
        // λ_max(K + M, M) = λ_max(K, M) + 1.
        self.interpolated_trace_by((whole * whole - size * size).sqrt())
    }

    fn interpolated_trace_by(&self, inverse: f64) -> f64 {
        self.trace.second * (inverse * self.interpolation * self.face.axes + 1.0)
    }

    pub(super) fn radii(&self) -> Radii {
        Radii {
            slip: self.interpolated_trace() * self.load / self.ellipticity,
            pressure: (1.0 + self.continuity / self.ellipticity) * self.load,
        }
    }

    pub(super) fn bound(&self) -> ContractionBound {
        let law = self.law;
        let steep = law.lipschitz.value * (2.0 + law.anisotropy.value);
        // ‖μ‖_0 ≤ of_pressure ‖μ‖_*.
        let of_pressure = self.inverse_half / self.face.pane_size.sqrt();
        let largest = self.face.inverse_fourth / self.face.triangle_size.sqrt() * self.trace.fourth;
        let radius = self.radii().pressure;
        // ‖u − ū‖ ≤ a ‖g − ḡ‖_* + b ‖φ − φ̄‖_0.
        let moved = |coefficient: f64, steep: f64, trace: f64, largest: f64| {
            let a = coefficient * of_pressure * trace / self.ellipticity;
            // A constant law has no second term, whatever the constants are.
            let b = match steep {
                0.0 => 0.0,
                steep => steep * of_pressure * largest * radius / self.ellipticity,
            };
            (a, b)
        };
        let image = self.interpolated_trace_by_gradient();
        let weighted = |(a, b): (f64, f64), image: f64| self.continuity * a + image * b;
        let (a, b) = moved(law.largest.value, steep, self.trace.second, largest);
        let sharp = moved(
            law.largest.value,
            steep,
            self.trace.tangential,
            self.trace.pointwise,
        );
        let [on_coefficient, on_slope] = self.functional_factors();
        let averaged = moved(
            on_coefficient * law.largest.value,
            on_slope * steep,
            self.trace.second,
            largest,
        );
        ContractionBound {
            paper: (self.interpolated_trace() + self.continuity) * a.max(b),
            weighted: weighted((a, b), image),
            sharp: weighted(sharp, self.interpolated),
            averaged: weighted(averaged, image),
            by_coefficient: self.continuity * a / weighted((a, b), image),
        }
    }

    /// What F_max and L grow by where the friction functional is not the exact integral of g ‖F v_t‖.
    ///
    /// On panes it is Σ g_i |Rⁱ| ‖𝓕_i mean v_t‖ with the mean 𝓕_i⁻¹ of F⁻¹ at the nodes. |𝓕 − 𝓕̄| ≤ (F_max/F_min)² L times
    /// the mean of |φ − φ̄| at the nodes. On a triangle of area |T| the linear function with the values |v_i| has the squared norm
    /// |T|/6 (Σ|v_i|² + Σ|v_i||v_j|) ≤ |T|/3 Σ|v_i|², that of v is |T|/12 (Σ|v_i|² + |Σ v_i|²); so the norm grows by 2 at most, which
    /// three unit vectors at 120° reach (one component alone grows by √(2+√3) at most). Nodal values are lumped: the lumped norm,
    /// |T|/3 Σ|v_i|², is at most twice the norm for the same reason.
    fn functional_factors(&self) -> [f64; 2] {
        if self.nodal {
            return [2.0, 2.0];
        }
        let spread = self.law.largest.value / self.law.smallest.value;
        [1.0, 2.0 * spread * spread]
    }
}

/// How far the friction functional of the program, Σ g_i |Rⁱ| ‖𝓕_i mean u_t‖ with the mean 𝓕_i⁻¹ of F⁻¹ at the nodes of a pane,
/// is from HKL's j = ∫ g ‖F(φ) u_t‖ at a solution.
#[derive(Debug, Clone, Copy, Default, PartialEq)]
pub struct FrictionFunctional {
    /// (j_H − j)/j; 0 where j vanishes.
    pub difference: f64,
    /// The largest ‖F⁻¹(φ) λ_t‖/g − 1 at points of pressed panes: the stress bound that holds for the mean fails there by this
    /// share; negative where it fails nowhere.
    pub excess: f64,
}

/// A solution on panes.
pub(super) struct OnPanes<'a> {
    pub(super) face: &'a TriangulatedFace,
    pub(super) surface: &'a ContactSurface,
    pub(super) law: &'a CoulombLaw,
    /// λ_ν in Pa.
    pub(super) normal: &'a [f64],
    /// λ_t in Pa.
    pub(super) pairs: &'a [[f64; 2]],
    /// Signed (u_t1, u_t2) at the contact nodes.
    pub(super) tangential: &'a [[f64; 2]],
    /// φ there.
    pub(super) slip: &'a [[f64; 2]],
}

impl OnPanes<'_> {
    /// By a rule of degree 5 on each triangle; `None` for nodal multipliers, which have no panes.
    pub(super) fn functional(&self) -> Option<FrictionFunctional> {
        if self.surface.is_nodal() {
            return None;
        }
        let bound = self.law.slip_bounds(self.normal, |l| l.max(0.0));
        let (mut exact, mut excess) = (0.0, f64::NEG_INFINITY);
        for (t, &pane) in self.surface.facet_pane.iter().enumerate() {
            for (weight, shape) in triangle_rule() {
                let coefficients = self.coefficients(t, &shape);
                let [first, second] = self.mean(self.tangential, t, &shape);
                let work = (coefficients[0] * first).hypot(coefficients[1] * second);
                exact += bound[pane] * weight * self.face.area(t) * work;
                if bound[pane] > 0.0 {
                    let [first, second] = self.pairs[pane];
                    let size = (first / coefficients[0]).hypot(second / coefficients[1]);
                    excess = f64::max(excess, size / bound[pane] - 1.0);
                }
            }
        }
        let averaged = self.averaged(&bound);
        Some(FrictionFunctional {
            difference: if exact == 0.0 {
                0.0
            } else {
                (averaged - exact) / exact
            },
            excess,
        })
    }

    /// Σ g_i |Rⁱ| ‖𝓕_i mean u_t‖.
    fn averaged(&self, bound: &[f64]) -> f64 {
        let field = FrictionField::new(self.law, &self.surface.pane_average, self.slip);
        let panes = bound.iter().enumerate().map(|(pane, g)| {
            let mean = |k: usize| -> f64 {
                let nodes = self.surface.pane_weights(pane);
                nodes
                    .map(|(node, weight)| weight * self.tangential[node][k])
                    .sum()
            };
            let [first, second] = field.pane(pane);
            g * self.surface.pane_area[pane] * (first * mean(0)).hypot(second * mean(1))
        });
        panes.sum()
    }

    /// F at a point of a triangle.
    fn coefficients(&self, triangle: usize, shape: &[f64; 3]) -> [f64; 2] {
        let corners = self.face.corners(triangle);
        let at = std::array::from_fn(|c| corners.iter().zip(shape).map(|(x, s)| s * x[c]).sum());
        self.law
            .only()
            .law()
            .evaluate(at, self.mean(self.slip, triangle, shape))
    }

    fn mean(&self, nodal: &[[f64; 2]], triangle: usize, shape: &[f64; 3]) -> [f64; 2] {
        let nodes = self.face.triangles[triangle];
        [0, 1].map(|k| nodes.iter().zip(shape).map(|(n, s)| s * nodal[*n][k]).sum())
    }
}
