//! The dual operator S as a dense matrix.

use std::ops::Range;

/// Columns treated together: each entry of y is then loaded once for four coefficients.
const PRODUCT_COLUMNS: usize = 4;

/// Independent partial sums of one dot product.
const PRODUCT_LANES: usize = 4;

/// y = S x for a symmetric S, column-major, `[n, n]`; only its lower triangle is read.
pub(super) fn symmetric_product(matrix: &[f64], x: &[f64]) -> Vec<f64> {
    let n = x.len();
    let mut y = vec![0.0; n];
    let whole = n - n % PRODUCT_COLUMNS;
    for k in (0..whole).step_by(PRODUCT_COLUMNS) {
        let end = k + PRODUCT_COLUMNS;
        add_diagonal_block(matrix, k..end, x, &mut y);
        let below = std::array::from_fn(|c| &matrix[(k + c) * n + end..(k + c + 1) * n]);
        let factors = [x[k], x[k + 1], x[k + 2], x[k + 3]];
        let (solved, rest) = y.split_at_mut(end);
        let dots = add_columns_and_dot(below, factors, &x[end..], rest);
        for (y, dot) in solved[k..].iter_mut().zip(dots) {
            *y += dot;
        }
    }
    add_diagonal_block(matrix, whole..n, x, &mut y);
    y
}

/// y += S x of the rows and columns of a range.
fn add_diagonal_block(matrix: &[f64], range: Range<usize>, x: &[f64], y: &mut [f64]) {
    for j in range.clone() {
        let column = &matrix[j * x.len()..(j + 1) * x.len()];
        y[j] += column[j] * x[j];
        for i in j + 1..range.end {
            y[i] += column[i] * x[j];
            y[j] += column[i] * x[i];
        }
    }
}

/// y += Σ columns[c] factors[c]; returns the products columns[c]ᵀ x.
fn add_columns_and_dot(
    columns: [&[f64]; PRODUCT_COLUMNS],
    factors: [f64; PRODUCT_COLUMNS],
    x: &[f64],
    y: &mut [f64],
) -> [f64; PRODUCT_COLUMNS] {
    let n = y.len();
    let [a, b, c, d] = columns.map(|column| &column[..n]);
    let [fa, fb, fc, fd] = factors;
    let x = &x[..n];
    let mut sums = [[0.0; PRODUCT_LANES]; PRODUCT_COLUMNS];
    let whole = n - n % PRODUCT_LANES;
    for i in (0..whole).step_by(PRODUCT_LANES) {
        for lane in 0..PRODUCT_LANES {
            let at = i + lane;
            y[at] += (a[at] * fa + b[at] * fb) + (c[at] * fc + d[at] * fd);
            sums[0][lane] += a[at] * x[at];
            sums[1][lane] += b[at] * x[at];
            sums[2][lane] += c[at] * x[at];
            sums[3][lane] += d[at] * x[at];
        }
    }
    for at in whole..n {
        y[at] += (a[at] * fa + b[at] * fb) + (c[at] * fc + d[at] * fd);
        for (sum, column) in sums.iter_mut().zip([a, b, c, d]) {
            sum[0] += column[at] * x[at];
        }
    }
    sums.map(|[p, q, r, s]| (p + q) + (r + s))
}

/// y −= M x for a column-major M, `[y.len(), x.len()]`.
pub(super) fn subtract_product(matrix: &[f64], x: &[f64], y: &mut [f64]) {
    let rows = y.len();
    let column = |j: usize| &matrix[j * rows..(j + 1) * rows];
    let whole = x.len() - x.len() % PRODUCT_COLUMNS;
    for k in (0..whole).step_by(PRODUCT_COLUMNS) {
        let [a, b, c, d] = std::array::from_fn(|i| column(k + i));
        let [fa, fb, fc, fd] = [x[k], x[k + 1], x[k + 2], x[k + 3]];
        for i in 0..rows {
            y[i] -= (a[i] * fa + b[i] * fb) + (c[i] * fc + d[i] * fd);
        }
    }
    for j in whole..x.len() {
        y.iter_mut()
            .zip(column(j))
            .for_each(|(y, m)| *y -= m * x[j]);
    }
}

#[cfg(test)]
mod tests {
    use proptest::prelude::*;

    use super::*;

    proptest! {
        #[test]
        fn products_equal_their_definitions(
            n in 1..23_usize, rows in 1..19_usize,
            entries in prop::collection::vec(-1.0..1.0_f64, 23 * 23),
            x in prop::collection::vec(-1.0..1.0_f64, 23),
        ) {
            let x = &x[..n];
            let entry = |i: usize, j: usize| entries[i.max(j) * 23 + i.min(j)];
            let symmetric: Vec<f64> = (0..n * n).map(|k| entry(k % n, k / n)).collect();
            let product = symmetric_product(&symmetric, x);
            let mut difference = vec![0.5; rows];
            subtract_product(&entries, x, &mut difference);
            for i in 0..n {
                let expected: f64 = (0..n).map(|j| entry(i, j) * x[j]).sum();
                // At most 23 products below 1: rounding stays below 23² ε.
                prop_assert!((product[i] - expected).abs() < 1e-13);
            }
            for i in 0..rows {
                let expected: f64 = (0..n).map(|j| entries[j * rows + i] * x[j]).sum();
                prop_assert!((difference[i] - (0.5 - expected)).abs() < 1e-13);
            }
        }
    }
}
