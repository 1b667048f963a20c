//! Factors from stored arrays, sound and damaged ones.

use contact3d::linalg::{CholeskyFactor, FactorStructure, PartsError, amd};
use proptest::prelude::*;

use super::brick::Brick;

fn factor() -> CholeskyFactor {
    let stiffness = Brick::new(2).stiffness();
    let order = amd(&stiffness).expect("square");
    CholeskyFactor::factorise(&stiffness, order).expect("positive definite")
}

/// The arrays of a factor, to be damaged.
struct Parts {
    structure: FactorStructure,
    values: Vec<f64>,
}

fn parts() -> Parts {
    let factor = factor();
    Parts {
        structure: factor.structure().clone(),
        values: factor.values().to_vec(),
    }
}

fn rebuild(parts: Parts) -> Result<CholeskyFactor, PartsError> {
    CholeskyFactor::from_parts(parts.structure, parts.values)
}

#[test]
fn sound_parts_give_the_same_factor() {
    assert_eq!(rebuild(parts()), Ok(factor()));
}

#[test]
fn empty_parts_are_sound() {
    let empty = FactorStructure {
        supernode_columns: vec![0],
        row_offsets: vec![0],
        value_offsets: vec![0],
        ..FactorStructure::default()
    };
    let factor = CholeskyFactor::<f64>::from_parts(empty, vec![]);
    assert_eq!(factor.map(|factor| factor.size()), Ok(0));
    assert!(CholeskyFactor::<f64>::from_parts(FactorStructure::default(), vec![]).is_err());
}

#[test]
fn coefficients_of_no_factor_are_refused() {
    for (place, value) in [(0, -1.0), (0, 0.0), (0, f64::NAN), (1, f64::INFINITY)] {
        let mut damaged = parts();
        damaged.values[place] = value;
        let refused = PartsError {
            rule: "finite coefficients, positive on the diagonal and zero above it",
            supernode: 0,
        };
        assert_eq!(rebuild(damaged), Err(refused));
    }
}

proptest! {
    #[test]
    fn any_changed_index_is_refused(array in 0..5_usize, place in 0.0..1.0_f64, value in prop_oneof![0..400_usize, Just(usize::MAX)]) {
        let mut damaged = parts();
        let target = match array {
            0 => &mut damaged.structure.permutation,
            1 => &mut damaged.structure.supernode_columns,
            2 => &mut damaged.structure.row_offsets,
            3 => &mut damaged.structure.row_indices,
            _ => &mut damaged.structure.value_offsets,
        };
        let place = (place * target.len() as f64) as usize;
        prop_assume!(target[place] != value);
        target[place] = value;
        // a changed row index may still describe a (different) sound factor; then a solve must
        // not panic
        if let Ok(other) = rebuild(damaged) {
            prop_assert_eq!(array, 3);
            let mut rhs = vec![1.0; other.size()];
            other.solve_in_place(&mut rhs);
        }
    }

    #[test]
    fn shortened_arrays_are_refused(array in 0..6_usize) {
        let mut damaged = parts();
        match array {
            0 => drop(damaged.structure.permutation.pop()),
            1 => drop(damaged.structure.supernode_columns.pop()),
            2 => drop(damaged.structure.row_offsets.pop()),
            3 => drop(damaged.structure.row_indices.pop()),
            4 => drop(damaged.structure.value_offsets.pop()),
            _ => drop(damaged.values.pop()),
        }
        prop_assert!(rebuild(damaged).is_err());
    }
}
