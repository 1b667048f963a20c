//! Vectors of ℝ³ for the drawings.

/// A vector of ℝ³.
pub(super) type Vector = [f64; 3];

pub(super) fn dot(a: Vector, b: Vector) -> f64 {
    a[0] * b[0] + a[1] * b[1] + a[2] * b[2]
}

pub(super) fn cross(a: Vector, b: Vector) -> Vector {
    [
        a[1] * b[2] - a[2] * b[1],
        a[2] * b[0] - a[0] * b[2],
        a[0] * b[1] - a[1] * b[0],
    ]
}

pub(super) fn minus(a: Vector, b: Vector) -> Vector {
    [a[0] - b[0], a[1] - b[1], a[2] - b[2]]
}

pub(super) fn scaled(a: Vector, factor: f64) -> Vector {
    a.map(|component| factor * component)
}

pub(super) fn norm(a: Vector) -> f64 {
    a[0].hypot(a[1]).hypot(a[2])
}

/// `a` divided by its length; the zero vector stays.
pub(super) fn unit(a: Vector) -> Vector {
    let length = norm(a);
    if length > 0.0 {
        scaled(a, 1.0 / length)
    } else {
        a
    }
}

/// Smallest and largest value; (0, 0) when there is none.
pub(super) fn bounds(values: impl Iterator<Item = f64>) -> (f64, f64) {
    let (low, high) = values.fold((f64::INFINITY, f64::NEG_INFINITY), |(low, high), value| {
        (low.min(value), high.max(value))
    });
    if low <= high { (low, high) } else { (0.0, 0.0) }
}
