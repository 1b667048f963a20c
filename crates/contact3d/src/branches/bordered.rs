//! Systems with one row more than the equations of a path.

use crate::linalg::DenseLu;

/// The n × (n + 1) derivative of the equations of a path with a last row c: column-major, factorised.
pub(super) fn bordered(derivative: &[f64], constraint: &[f64]) -> Option<DenseLu> {
    let order = constraint.len();
    let mut matrix = vec![0.0; order * order];
    let columns = matrix.chunks_exact_mut(order).zip(constraint);
    for ((to, last), from) in columns.zip(derivative.chunks_exact(order - 1)) {
        to[..order - 1].copy_from_slice(from);
        to[order - 1] = *last;
    }
    DenseLu::new(&matrix, order)
}

#[cfg(test)]
mod tests {
    use super::bordered;

    #[test]
    fn one_equation_and_its_border() {
        // One equation x + 2 y, bordered by (2, −1).
        let lu = bordered(&[1.0, 2.0], &[2.0, -1.0]).unwrap();
        assert_eq!(lu.sign(), -1);
    }
}
