//! A k-d tree that finds nodes at the same place.

/// A k-d tree over points, for queries with boxes.
///
/// A range of the order is a subtree: the point at its middle splits it along `axis`, with no
/// larger coordinates before and no smaller ones behind it.
pub(super) struct Nearby<'a> {
    points: &'a [[f64; 3]],
    order: Vec<usize>,
    axis: Vec<usize>,
}

impl<'a> Nearby<'a> {
    /// Sorts the chosen points; each range is split along its longest extent.
    pub(super) fn new(points: &'a [[f64; 3]], chosen: Vec<usize>) -> Self {
        let mut order = chosen;
        let mut axis = vec![0; order.len()];
        let mut ranges = vec![(0, order.len())];
        while let Some((start, end)) = ranges.pop() {
            if end - start < 2 {
                continue;
            }
            let range = &mut order[start..end];
            let along = longest_extent(range.iter().map(|&i| &points[i]));
            let middle = range.len() / 2;
            range.select_nth_unstable_by(middle, |&a, &b| {
                points[a][along]
                    .total_cmp(&points[b][along])
                    .then(a.cmp(&b))
            });
            axis[start + middle] = along;
            ranges.push((start, start + middle));
            ranges.push((start + middle + 1, end));
        }
        Self {
            points,
            order,
            axis,
        }
    }

    /// The chosen points in a closed box, in increasing order.
    pub(super) fn in_box(&self, low: [f64; 3], high: [f64; 3]) -> Vec<usize> {
        let mut found = Vec::new();
        let mut ranges = vec![(0, self.order.len())];
        while let Some((start, end)) = ranges.pop() {
            if start == end {
                continue;
            }
            let middle = start + (end - start) / 2;
            let (point, axis) = (self.order[middle], self.axis[middle]);
            let at = self.points[point];
            if (0..3).all(|a| low[a] <= at[a] && at[a] <= high[a]) {
                found.push(point);
            }
            if low[axis] <= at[axis] {
                ranges.push((start, middle));
            }
            if at[axis] <= high[axis] {
                ranges.push((middle + 1, end));
            }
        }
        found.sort_unstable();
        found
    }
}

fn longest_extent<'p>(points: impl Iterator<Item = &'p [f64; 3]>) -> usize {
    let (mut low, mut high) = ([f64::INFINITY; 3], [f64::NEG_INFINITY; 3]);
    for point in points {
        for a in 0..3 {
            low[a] = low[a].min(point[a]);
            high[a] = high[a].max(point[a]);
        }
    }
    let extent = [0, 1, 2].map(|a| high[a] - low[a]);
    (0..3)
        .rev()
        .max_by(|&a, &b| extent[a].total_cmp(&extent[b]))
        .unwrap_or(0)
}

#[cfg(test)]
mod tests {
    use proptest::prelude::*;

    use super::Nearby;

    /// Few different coordinates, so that many are equal and some extents are zero.
    fn any_point() -> impl Strategy<Value = [f64; 3]> {
        prop::array::uniform3((0..5_i32).prop_map(f64::from))
    }

    proptest! {
        #[test]
        fn boxes_hold_what_brute_force_finds(
            points in prop::collection::vec(any_point(), 0..60),
            (low, size) in (any_point(), any_point()),
        ) {
            let high: [f64; 3] = std::array::from_fn(|a| low[a] + size[a] - 1.0);
            let chosen: Vec<usize> = (0..points.len()).filter(|i| i % 3 != 0).collect();
            let is_inside = |i: &usize| (0..3).all(|a| (low[a]..=high[a]).contains(&points[*i][a]));
            let expected: Vec<usize> = chosen.iter().copied().filter(is_inside).collect();
            prop_assert_eq!(Nearby::new(&points, chosen).in_box(low, high), expected);
        }
    }
}
