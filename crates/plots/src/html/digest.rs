//! The digests (SHA-256, FIPS 180-4) by which the Content-Security-Policy of a page knows script and style.

use base64::{Engine, engine::general_purpose::STANDARD};

/// A source of a Content-Security-Policy: the digest of a text.
pub(super) fn policy_source(text: &str) -> String {
    let digest = sha256(text.as_bytes()).map(u32::to_be_bytes);
    format!("'sha256-{}'", STANDARD.encode(digest.as_flattened()))
}

/// The first 32 bits of the fractional parts of roots of the first primes: square roots to begin with, cube roots to
/// mix in.
fn prime_roots<const N: usize>(root: fn(f64) -> f64) -> [u32; N] {
    let is_prime = |n: &u32| {
        (2..*n)
            .take_while(|d| d * d <= *n)
            .all(|d| !n.is_multiple_of(d))
    };
    let mut primes = (2_u32..).filter(is_prime);
    // Primes below 312 have roots below 18: 32 bits of the fraction are within the 53 of a double.
    let bits = |prime: u32| (root(f64::from(prime)).fract() * 4_294_967_296.0) as u32;
    std::array::from_fn(|_| primes.next().map_or(0, bits))
}

fn sha256(message: &[u8]) -> [u32; 8] {
    let mut hash: [u32; 8] = prime_roots(f64::sqrt);
    let constants: [u32; 64] = prime_roots(f64::cbrt);
    let mut padded = message.to_vec();
    padded.push(0x80);
    padded.resize((padded.len() + 8).next_multiple_of(64) - 8, 0);
    padded.extend((8 * message.len() as u64).to_be_bytes());
    for block in padded.chunks(64) {
        let mut words = [0_u32; 64];
        for (word, bytes) in words.iter_mut().zip(block.as_chunks().0) {
            *word = u32::from_be_bytes(*bytes);
        }
        for k in 16..64 {
            let (near, far) = (words[k - 2], words[k - 15]);
            let far = far.rotate_right(7) ^ far.rotate_right(18) ^ (far >> 3);
            let near = near.rotate_right(17) ^ near.rotate_right(19) ^ (near >> 10);
            let sum = words[k - 16].wrapping_add(far).wrapping_add(words[k - 7]);
            words[k] = sum.wrapping_add(near);
        }
        let mixed = words
            .iter()
            .zip(&constants)
            .fold(hash, |state, (&word, &constant)| {
                round(state, word.wrapping_add(constant))
            });
        for (value, mixed) in hash.iter_mut().zip(mixed) {
            *value = value.wrapping_add(mixed);
        }
    }
    hash
}

fn round([a, b, c, d, e, f, g, h]: [u32; 8], word: u32) -> [u32; 8] {
    let of_e = e.rotate_right(6) ^ e.rotate_right(11) ^ e.rotate_right(25);
    let chosen = (e & f) ^ (!e & g);
    let first = h.wrapping_add(of_e).wrapping_add(chosen).wrapping_add(word);
    let of_a = a.rotate_right(2) ^ a.rotate_right(13) ^ a.rotate_right(22);
    let majority = (a & b) ^ (a & c) ^ (b & c);
    let second = of_a.wrapping_add(majority);
    [
        first.wrapping_add(second),
        a,
        b,
        c,
        d.wrapping_add(first),
        e,
        f,
        g,
    ]
}

#[cfg(test)]
mod tests {
    use super::*;

    /// The examples of FIPS 180-4 (NIST): one block, and a message whose padding needs a second one.
    #[test]
    fn digests_are_those_of_the_standard() {
        let hex = |text: &str| {
            sha256(text.as_bytes())
                .map(|word| format!("{word:08x}"))
                .concat()
        };
        let abc = "ba7816bf8f01cfea414140de5dae2223b00361a396177a9cb410ff61f20015ad";
        assert_eq!(hex("abc"), abc);
        let two = "248d6a61d20638b8e5c026930c3e6039a33ce45964ff2167f6ecedd419db06c1";
        assert_eq!(
            hex("abcdbcdecdefdefgefghfghighijhijkijkljklmklmnlmnomnopnopq"),
            two
        );
    }
}
