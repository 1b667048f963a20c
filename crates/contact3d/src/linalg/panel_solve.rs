//! Substitution with one panel of the factor, for one right-hand side or several that share the reading of its coefficients.

use std::array::from_fn;

use super::precision::Scalar;

/// Columns treated together: each entry of the running sums is then loaded once for four
/// coefficients.
const UNROLLED: usize = 4;

/// Rows treated together in the dot products of one right-hand side.
const DOT_LANES: usize = 8;

/// Replaces the leading `width` rows of N right-hand sides by their solution with the diagonal block of a column-major panel
/// and adds −L_below times it to the rest.
#[inline(always)]
pub(super) fn forward<T: Scalar, const N: usize>(values: &[T], width: usize, x: &mut [[T; N]]) {
    let height = x.len();
    let mut k = 0;
    while k < width {
        let block = UNROLLED.min(width - k);
        for c in k..k + block {
            let column = &values[c * height..(c + 1) * height];
            x[c] = x[c].map(|x| x / column[c]);
            let factor = x[c];
            for i in c + 1..k + block {
                subtract(&mut x[i], factor, column[i]);
            }
        }
        let (solved, rest) = x.split_at_mut(k + block);
        let tail = |c: usize| &values[c * height + k + block..(c + 1) * height];
        if block == UNROLLED {
            subtract_four(from_fn(|c| tail(k + c)), from_fn(|c| solved[k + c]), rest);
        } else {
            for c in k..k + block {
                for (x, l) in rest.iter_mut().zip(tail(c)) {
                    subtract(x, solved[c], *l);
                }
            }
        }
        k += block;
    }
}

/// Replaces the leading part by L_diagonal⁻ᵀ (x_leading − L_belowᵀ x_below).
#[inline(always)]
pub(super) fn backward<T: Scalar, const N: usize>(values: &[T], width: usize, x: &mut [[T; N]]) {
    let one = T::rounded(1.0);
    let height = x.len();
    let mut end = width;
    while end > 0 {
        // the incomplete block comes last in the forward pass, so first here
        let block = if end.is_multiple_of(UNROLLED) {
            UNROLLED
        } else {
            end % UNROLLED
        };
        let k = end - block;
        let (unknown, known) = x.split_at_mut(end);
        let tail = |c: usize| &values[c * height + end..(c + 1) * height];
        if block == UNROLLED {
            let dots = four_dots(from_fn(|c| tail(k + c)), known);
            for (x, dot) in unknown[k..].iter_mut().zip(dots) {
                subtract(x, dot, one);
            }
        } else {
            for c in k..end {
                subtract(&mut unknown[c], dot(tail(c), known), one);
            }
        }
        for c in (k..end).rev() {
            let column = &values[c * height..(c + 1) * height];
            let known = dot(&column[c + 1..end], &x[c + 1..end]);
            subtract(&mut x[c], known, one);
            x[c] = x[c].map(|x| x / column[c]);
        }
        end = k;
    }
}

/// x −= factor · coefficient.
#[inline(always)]
fn subtract<T: Scalar, const N: usize>(x: &mut [T; N], factor: [T; N], coefficient: T) {
    for i in 0..N {
        x[i] -= factor[i] * coefficient;
    }
}

/// y −= Σ columns[k] · factors[k].
#[inline(always)]
fn subtract_four<T: Scalar, const N: usize>(
    columns: [&[T]; UNROLLED],
    factors: [[T; N]; UNROLLED],
    y: &mut [[T; N]],
) {
    let n = y.len();
    let [a, b, c, d] = columns.map(|column| &column[..n]);
    let [fa, fb, fc, fd] = factors;
    for i in 0..n {
        for j in 0..N {
            y[i][j] -= (fa[j] * a[i] + fb[j] * b[i]) + (fc[j] * c[i] + fd[j] * d[i]);
        }
    }
}

/// columnᵀ y, summed in order.
#[inline(always)]
fn dot<T: Scalar, const N: usize>(column: &[T], y: &[[T; N]]) -> [T; N] {
    let mut sum = [T::default(); N];
    for (l, y) in column.iter().zip(y) {
        add_products(&mut sum, &[*l; N], y);
    }
    sum
}

/// The products columns[k]ᵀ y; those of one right-hand side are summed in interleaved parts.
#[inline(always)]
fn four_dots<T: Scalar, const N: usize>(
    columns: [&[T]; UNROLLED],
    y: &[[T; N]],
) -> [[T; N]; UNROLLED] {
    let columns = columns.map(|column| &column[..y.len()]);
    if N == 1 {
        return interleaved_dots(columns, y.as_flattened()).map(|dot| [dot; N]);
    }
    let [a, b, c, d] = columns;
    let mut sums = [[T::default(); N]; UNROLLED];
    for (i, y) in y.iter().enumerate() {
        add_products(&mut sums[0], &[a[i]; N], y);
        add_products(&mut sums[1], &[b[i]; N], y);
        add_products(&mut sums[2], &[c[i]; N], y);
        add_products(&mut sums[3], &[d[i]; N], y);
    }
    sums
}

#[inline(always)]
fn interleaved_dots<T: Scalar>(columns: [&[T]; UNROLLED], y: &[T]) -> [T; UNROLLED] {
    let [a, b, c, d] = columns.map(|column| column.as_chunks::<DOT_LANES>());
    let (whole, rest) = y.as_chunks::<DOT_LANES>();
    let mut sums = [[T::default(); DOT_LANES]; UNROLLED];
    for ((((y, a), b), c), d) in whole.iter().zip(a.0).zip(b.0).zip(c.0).zip(d.0) {
        add_products(&mut sums[0], a, y);
        add_products(&mut sums[1], b, y);
        add_products(&mut sums[2], c, y);
        add_products(&mut sums[3], d, y);
    }
    let tails = [a.1, b.1, c.1, d.1].map(|tail| dot(tail, rest.as_chunks().0));
    from_fn(|k| {
        let [tail] = tails[k];
        total(&sums[k]) + tail
    })
}

/// The sum of interleaved parts. In line, it would have the compiler mix the parts of the loop before it.
#[inline(never)]
fn total<T: Scalar>(parts: &[T; DOT_LANES]) -> T {
    let [a, b, c, d, e, f, g, h] = *parts;
    ((a + b) + (c + d)) + ((e + f) + (g + h))
}

#[inline(always)]
fn add_products<T: Scalar, const N: usize>(sums: &mut [T; N], x: &[T; N], y: &[T; N]) {
    for i in 0..N {
        sums[i] += x[i] * y[i];
    }
}
