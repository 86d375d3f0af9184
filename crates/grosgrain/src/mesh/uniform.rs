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

/// `count` of the indices 0 … `of` − 1, ascending, drawn without repetition: each index takes one number of a ChaCha8 stream
/// with the seed as key, and those with the smallest numbers are drawn. The same on any machine.
///
/// All of them if `count` is not less than `of`.
pub fn random_subset(seed: u64, count: usize, of: usize) -> Vec<usize> {
    let mut stream = random_stream(seed);
    let mut numbered: Vec<(f64, usize)> = (0..of).map(|index| (uniform(&mut stream), index)).collect();
    numbered.sort_by(|a, b| a.0.total_cmp(&b.0).then(a.1.cmp(&b.1)));
    let mut drawn: Vec<usize> = numbered.into_iter().take(count).map(|(_, index)| index).collect();
    drawn.sort_unstable();
    drawn
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_random_subset_has_the_size_asked_for_and_every_index_gets_its_turn() {
        let (count, of, seeds) = (26, 256, 1000);
        let mut drawn = vec![0usize; of];
        for seed in 0..seeds {
            let subset = random_subset(seed, count, of);
            assert_eq!(subset.len(), count);
            assert!(subset.windows(2).all(|pair| pair[0] < pair[1]) && subset[count - 1] < of, "{subset:?}");
            assert_eq!(subset, random_subset(seed, count, of));
            subset.iter().for_each(|index| drawn[*index] += 1);
        }
        // Binomial with 1000 draws of probability 26/256: mean 101.6, deviation 9.6; six deviations happen once in 10⁹.
        assert!(drawn.iter().all(|n| (44..160).contains(n)), "{drawn:?}");
        assert_eq!(random_subset(1, 9, 4), [0, 1, 2, 3]);
    }

    #[test]
    fn the_stream_of_seed_zero_is_that_of_the_chacha8_test_vector() {
        // Strombergson, "Test vectors for the stream cipher ChaCha", TC1: key and nonce zero, 8 rounds: 3e00ef2f895f40d6…
        assert_eq!(random_stream(0).next_u64().to_le_bytes(), [0x3e, 0x00, 0xef, 0x2f, 0x89, 0x5f, 0x40, 0xd6]);
    }
}
