//! What the user must know about parts of a body that hang on nothing.

use grosgrain::mesh::{LoosePart, VoxelGrid, loose_parts, parts_loose_from_largest};

use super::supported_nodes;
use crate::failure::Failure;
use crate::scene::Scene;

/// Loose parts that are told one by one.
const TOLD_PARTS: usize = 3;

/// The sentence about parts that can still move when the scene's `[[fix]]` tables and springs hold the body; `None` if none can.
///
/// # Errors
/// A selection that holds no node of the body.
pub fn loose_when_held(scene: &Scene, grid: &VoxelGrid) -> Result<Option<String>, Failure> {
    let fixed: Vec<[bool; 3]> = supported_nodes(scene, grid)?.into_iter().map(|held| [held; 3]).collect();
    Ok(sentence(&loose_parts(grid, &fixed)))
}

/// The sentence about parts that can move against the largest one; `None` if none can.
pub fn loose_from_largest(grid: &VoxelGrid) -> Option<String> {
    sentence(&parts_loose_from_largest(grid))
}

fn sentence(loose: &[LoosePart]) -> Option<String> {
    let told: Vec<String> = loose.iter().take(TOLD_PARTS).map(|part| format!("{part}")).collect();
    let more = match loose.len().saturating_sub(TOLD_PARTS) {
        0 => String::new(),
        1 => ". So is 1 more part".into(),
        n => format!(". So are {n} more parts"),
    };
    let remedy = match loose.iter().all(|part| part.largest) {
        true => "",
        false => ". body.keep = \"supported\" or \"largest\" leaves loose parts out",
    };
    (!loose.is_empty()).then(|| format!("{}{more}{remedy}", told.join(". ")))
}
