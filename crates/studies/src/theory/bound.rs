//! The radii of Lemma 3.3 and the contraction bound (3.13) of HKL.

use super::{level::TheoryProblem, quartic::triangle_rule, trace::TraceConstants};
use contact3d::{
    contact::{FrictionField, LawBounds},
    reference::quadrature,
    solver::Solution,
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

impl NormConstants {
    /// With the radii and the bounds that follow from the constants, from c_r of the scene's r_h and the bound of the norm of
    /// r_h|v_t| by ‖v‖ that does without it.
    pub(super) fn bounded(
        self,
        face: &FaceConstants,
        law: &LawBounds,
        [interpolation, interpolated]: [f64; 2],
        nodal: bool,
    ) -> Self {
        // c_tr⁽²⁾ (c_inv⁽¹'⁰⁾ c_r c_t + 1), the bound of ‖(r_h|v_t1|, r_h|v_t2|)‖ by ‖v‖ in (3.6).
        let trace_by =
            |inverse: f64| self.trace.second * (inverse * interpolation * face.axes + 1.0);
        let interpolated_trace = trace_by(face.inverse_first);
        let radii = Radii {
            slip: interpolated_trace * self.load / self.ellipticity,
            pressure: (1.0 + self.continuity / self.ellipticity) * self.load,
        };
        // The same with the inverse inequality for ‖∇ψ‖ alone, which (3.6) could use as well, as constants are interpolated
        // exactly: unlike ‖ψ‖_1 it does not depend on the unit of length. λ_max(K + M, M) = λ_max(K, M) + 1.
        let (whole, size) = (face.inverse_first, face.triangle_size);
        let image = trace_by((whole * whole - size * size).sqrt());
        let steep = law.lipschitz.value * (2.0 + law.anisotropy.value);
        // ‖μ‖_0 ≤ of_pressure ‖μ‖_*.
        let of_pressure = self.inverse_half / face.pane_size.sqrt();
        let largest = face.inverse_fourth / face.triangle_size.sqrt() * self.trace.fourth;
        // ‖u − ū‖ ≤ a ‖g − ḡ‖_* + b ‖φ − φ̄‖_0.
        let moved = |coefficient: f64, steep: f64, trace: f64, largest: f64| {
            let a = coefficient * of_pressure * trace / self.ellipticity;
            // A constant law has no second term, whatever the constants are.
            let b = match steep {
                0.0 => 0.0,
                steep => steep * of_pressure * largest * radii.pressure / self.ellipticity,
            };
            (a, b)
        };
        let weighted = |(a, b): (f64, f64), image: f64| self.continuity * a + image * b;
        let (coefficient, trace) = (law.largest.value, &self.trace);
        let (a, b) = moved(coefficient, steep, trace.second, largest);
        let sharp = moved(coefficient, steep, trace.tangential, trace.pointwise);
        let [on_coefficient, on_slope] = functional_factors(law, nodal);
        let averaged = moved(
            on_coefficient * coefficient,
            on_slope * steep,
            trace.second,
            largest,
        );
        let bound = ContractionBound {
            paper: (interpolated_trace + self.continuity) * a.max(b),
            weighted: weighted((a, b), image),
            sharp: weighted(sharp, interpolated),
            averaged: weighted(averaged, image),
            by_coefficient: self.continuity * a / weighted((a, b), image),
        };
        Self {
            radii,
            bound,
            ..self
        }
    }
}

/// What F_max and L grow by where the friction functional is not the exact integral of g ‖F v_t‖.
///
/// On panes it is Σ g_i |Rⁱ| ‖𝓕_i mean v_t‖ with the mean 𝓕_i⁻¹ of F⁻¹ at the nodes. |𝓕 − 𝓕̄| ≤ (F_max/F_min)² L times
/// the mean of |φ − φ̄| at the nodes. On a triangle of area |T| the linear function with the values |v_i| has the squared norm
/// |T|/6 (Σ|v_i|² + Σ|v_i||v_j|) ≤ |T|/3 Σ|v_i|², that of v is |T|/12 (Σ|v_i|² + |Σ v_i|²); so the norm grows by 2 at most, which
/// three unit vectors at 120° reach (one component alone grows by √(2+√3) at most). Nodal values are lumped: the lumped norm,
/// |T|/3 Σ|v_i|², is at most twice the norm for the same reason.
fn functional_factors(law: &LawBounds, nodal: bool) -> [f64; 2] {
    if nodal {
        return [2.0, 2.0];
    }
    let spread = law.largest.value / law.smallest.value;
    [1.0, 2.0 * spread * spread]
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

impl TheoryProblem {
    /// By a rule of degree 5 on each triangle; `None` for nodal multipliers, which have no panes.
    pub(super) fn functional(&self, solution: &Solution) -> Option<FrictionFunctional> {
        let (surface, law, face) = (self.surface(), self.law(), &self.face);
        if surface.is_nodal() {
            return None;
        }
        let (normal, pairs) = self.dual().layout.split(&solution.multiplier);
        let tangential = self.tangential_of(&solution.displacement);
        let slip = self.contact().interface.slip.operator.slip(&tangential);
        let bound = law.slip_bounds(normal, |l| l.max(0.0));
        let (mut exact, mut excess) = (0.0, f64::NEG_INFINITY);
        for (t, &pane) in surface.facet_pane.iter().enumerate() {
            let corners = face.corners(t);
            for (weight, shape) in triangle_rule() {
                let place = quadrature::point(&corners, &shape);
                let coefficients = law
                    .only()
                    .law()
                    .evaluate(place, face.mean(&slip, t, &shape));
                let [first, second] = face.mean(&tangential, t, &shape);
                let work = (coefficients[0] * first).hypot(coefficients[1] * second);
                exact += bound[pane] * weight * face.area(t) * work;
                if bound[pane] > 0.0 {
                    let [first, second] = pairs[pane];
                    let size = (first / coefficients[0]).hypot(second / coefficients[1]);
                    excess = f64::max(excess, size / bound[pane] - 1.0);
                }
            }
        }
        // Σ g_i |Rⁱ| ‖𝓕_i mean u_t‖.
        let field = FrictionField::new(law, &surface.pane_average, &slip);
        let panes = bound.iter().enumerate().map(|(pane, g)| {
            let mean = |k: usize| -> f64 {
                let nodes = surface.pane_weights(pane);
                nodes
                    .map(|(node, weight)| weight * tangential[node][k])
                    .sum()
            };
            let [first, second] = field.pane(pane);
            g * surface.pane_area[pane] * (first * mean(0)).hypot(second * mean(1))
        });
        let averaged: f64 = panes.sum();
        let difference = if exact == 0.0 {
            0.0
        } else {
            (averaged - exact) / exact
        };
        Some(FrictionFunctional { difference, excess })
    }
}
