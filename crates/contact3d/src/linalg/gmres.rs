//! Linear systems by products with their matrix alone.

use super::{add_scaled, dot, norm};

/// An approximate solution of M x = b by GMRES (Y. Saad, M. H. Schultz, SIAM J. Sci. Stat. Comput.
/// 7 (1986) 856) without restarts: stops when ‖b − M x‖ ≤ `tolerance` ‖b‖ or after `most_steps`
/// products.
#[must_use]
pub(crate) fn gmres(
    b: &[f64],
    tolerance: f64,
    most_steps: usize,
    mut apply: impl FnMut(&[f64]) -> Vec<f64>,
) -> Vec<f64> {
    let size = norm(b);
    let mut solution = vec![0.0; b.len()];
    if !(size > 0.0 && size.is_finite()) {
        return solution;
    }
    let mut basis: Vec<Vec<f64>> = vec![b.iter().map(|v| v / size).collect()];
    // Columns of the triangular factor of the Hessenberg matrix, the rotations that made it, and
    // the right-hand side turned by them.
    let mut triangle: Vec<Vec<f64>> = Vec::new();
    let mut rotations: Vec<(f64, f64)> = Vec::new();
    let mut turned = vec![size];
    for k in 0..most_steps.min(b.len()) {
        let mut next = apply(&basis[k]);
        let mut column = vec![0.0; k + 2];
        // Twice, so that the basis is orthogonal to rounding.
        for _ in 0..2 {
            for (entry, v) in column.iter_mut().zip(&basis) {
                let along = dot(&next, v);
                *entry += along;
                add_scaled(&mut next, -along, v);
            }
        }
        let length = norm(&next);
        column[k + 1] = length;
        for (i, (c, s)) in rotations.iter().enumerate() {
            let (upper, lower) = (column[i], column[i + 1]);
            column[i] = c * upper + s * lower;
            column[i + 1] = c * lower - s * upper;
        }
        let diagonal = column[k].hypot(column[k + 1]);
        if !(diagonal > 0.0 && diagonal.is_finite()) {
            break;
        }
        let (c, s) = (column[k] / diagonal, column[k + 1] / diagonal);
        column.truncate(k + 1);
        column[k] = diagonal;
        triangle.push(column);
        rotations.push((c, s));
        turned.push(-s * turned[k]);
        turned[k] *= c;
        if turned[k + 1].abs() <= tolerance * size || length == 0.0 {
            break;
        }
        basis.push(next.iter().map(|v| v / length).collect());
    }
    let mut weights = turned[..triangle.len()].to_vec();
    for k in (0..triangle.len()).rev() {
        weights[k] /= triangle[k][k];
        let weight = weights[k];
        for (i, upper) in weights[..k].iter_mut().enumerate() {
            *upper -= triangle[k][i] * weight;
        }
    }
    for (weight, v) in weights.iter().zip(&basis) {
        add_scaled(&mut solution, *weight, v);
    }
    solution
}

#[cfg(test)]
mod tests {
    use super::gmres;

    #[test]
    fn an_unsymmetric_system_is_solved_in_as_many_steps_as_it_has_unknowns() {
        let matrix = [[2.0, 1.0, 0.0], [-3.0, 4.0, 1.0], [0.0, 5.0, -1.0]];
        let apply = |x: &[f64]| -> Vec<f64> {
            let rows = matrix.iter();
            rows.map(|row| row.iter().zip(x).map(|(a, x)| a * x).sum())
                .collect()
        };
        let expected = [1.0, -2.0, 3.0];
        let found = gmres(&apply(&expected), 1e-14, 3, apply);
        for (found, expected) in found.iter().zip(expected) {
            // Some roundings of a well-conditioned system.
            assert!((found - expected).abs() < 1e-13, "{found} {expected}");
        }
        assert_eq!(gmres(&[0.0; 3], 1e-14, 3, apply), [0.0; 3]);
    }
}
