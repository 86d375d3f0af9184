//! What the user must know about effective tensors.

use grosgrain::homogenization::{EffectiveTensors, Homogenized};

use crate::progress::Progress;
use crate::quantities::{counted, number};
use crate::scene::alternatives;

/// Tensors that are so many times stiffer than the volume average are told.
const SUSPICIOUS_STIFFENING: f64 = 2.0;

/// How many tensors are suspiciously stiff.
pub fn stiffened(effective: &EffectiveTensors) -> usize {
    effective.stiffening.iter().filter(|s| **s > SUSPICIOUS_STIFFENING).count()
}

/// The largest value and its cell, from 0.
pub fn worst_of(values: &[f64]) -> (usize, f64) {
    let worst = values.iter().enumerate().max_by(|a, b| a.1.total_cmp(b.1));
    worst.map_or((0, 0.0), |(cell, value)| (cell, *value))
}

/// Warns of strains that took the volume average, and of tensors that are stiffer than anything can be; `remedies` are what the user has not tried yet.
pub fn tell_doubts(found: &Homogenized, remedies: &[&str], progress: &Progress) {
    let effective = &found.effective;
    if let [first, ..] = effective.averaged[..] {
        progress.warn(&format!(
            "in {}, the first being cell {first}, the harmonic displacements do not determine all strains; the volume average stands in for them",
            counted(effective.averaged.len(), "coarse cell")
        ));
    }
    let count = stiffened(effective);
    if count > 0 {
        let (cell, worst) = worst_of(&effective.stiffening);
        let mut remedies: Vec<String> = remedies.iter().map(|remedy| (*remedy).to_owned()).collect();
        remedies.push("other coarse nodes".into());
        progress.warn(&format!(
            "the tensors of {} are more than twice as stiff as the volume average of the material, which nothing can be; at worst {} times, in cell {cell}: \
             coarse nodes there move less than the body around them. Try {}",
            counted(count, "coarse cell"),
            number(worst),
            alternatives(&remedies)
        ));
    }
}
