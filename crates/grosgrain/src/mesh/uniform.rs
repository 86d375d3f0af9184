//! Random numbers that are the same on every machine.

use rand_chacha::ChaCha8Rng;
use rand_chacha::rand_core::{Rng, SeedableRng};

/// A ChaCha8 stream whose 256-bit key is the seed, little-endian, followed by zeros.
pub(super) fn random_stream(seed: u64) -> ChaCha8Rng {
    let mut key = [0; 32];
    key[..8].copy_from_slice(&seed.to_le_bytes());
    ChaCha8Rng::from_seed(key)
}

/// A number from [0, 1): the upper 53 bits of the stream's next 64.
pub(super) fn uniform(stream: &mut ChaCha8Rng) -> f64 {
    (stream.next_u64() >> 11) as f64 * (0.5f64).powi(53)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_stream_of_seed_zero_is_that_of_the_chacha8_test_vector() {
        // Strombergson, "Test vectors for the stream cipher ChaCha", TC1: key and nonce zero, 8 rounds: 3e00ef2f895f40d6…
        assert_eq!(random_stream(0).next_u64().to_le_bytes(), [0x3e, 0x00, 0xef, 0x2f, 0x89, 0x5f, 0x40, 0xd6]);
    }
}
