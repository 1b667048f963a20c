//! An estimate of ‖S‖ and the steplength that follows from it.

use crate::{dual::DualOperator, linalg::largest_eigenvalue};

/// An upper estimate of ‖S‖, within some per cent: enough for the steplength 1.9/‖S‖.
pub fn operator_norm(operator: &mut dyn DualOperator) -> f64 {
    largest_eigenvalue(operator.dimension(), |v| operator.apply(v))
}

/// The steplength ᾱ = 1.9/‖S‖ of projected gradient steps in Pa/m³ (KPRGP asks for ᾱ in (0, 2/‖S‖)); 1 for
/// S = 0, where any will do.
pub(super) fn projected_gradient_steplength(operator: &mut dyn DualOperator) -> f64 {
    match operator_norm(operator) {
        0.0 => 1.0,
        largest => 1.9 / largest,
    }
}
