//! The parity of permutations.

/// The number of transpositions that a permutation is made of, up to an even number.
pub(crate) fn transpositions(permutation: &[usize]) -> usize {
    let mut seen = vec![false; permutation.len()];
    let mut count = 0;
    for start in 0..permutation.len() {
        let mut at = start;
        while !seen[at] {
            seen[at] = true;
            at = permutation[at];
            count += usize::from(!seen[at]);
        }
    }
    count
}

#[cfg(test)]
mod tests {
    use super::transpositions;

    #[test]
    fn permutations_have_the_parity_of_their_cycles() {
        assert_eq!(transpositions(&[0, 1, 2]) % 2, 0);
        assert_eq!(transpositions(&[1, 0, 2]) % 2, 1);
        assert_eq!(transpositions(&[1, 2, 0]) % 2, 0);
        assert_eq!(transpositions(&[1, 0, 3, 2]) % 2, 0);
    }
}
