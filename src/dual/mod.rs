//! The dual operator S = B A⁻¹ Bᵀ and right-hand side h = B A⁻¹ l − gap (HKL (4.5)).

mod assembly;
mod implicit;

pub use assembly::{Assembly, AssemblyError, PrimalSystem};
pub use implicit::ImplicitOperator;

/// Actions of the dual problem: minimise ½ λᵀSλ − λᵀh over the admissible multipliers.
pub trait DualOperator {
    /// Number of multipliers 3m.
    fn dimension(&self) -> usize;
    /// The right-hand side h in m³.
    fn rhs(&self) -> &[f64];
    /// S λ in m³ (λ in Pa).
    fn apply(&mut self, multiplier: &[f64]) -> Vec<f64>;
    /// The displacement u = A⁻¹(l − Bᵀλ) over the free degrees of freedom in m.
    fn to_primal(&mut self, multiplier: &[f64]) -> Vec<f64>;
    /// Actions of A⁻¹ so far (n_A of HKL §4).
    fn actions(&self) -> usize;
}
