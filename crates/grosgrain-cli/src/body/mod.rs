//! From a scene to a body: voxels, materials, and the parts that conditions hold on.

mod materials;
mod support;
mod voxels;

pub use materials::solid_counts;
pub use support::{loose_from_largest, loose_when_held};

use grosgrain::material::MaterialTable;
use grosgrain::mesh::{NodeSelection, Removed, Selector, Volume, VoxelGrid, keep_largest, remove_floating, resample};

use crate::failure::Failure;
use crate::quantities::{counted, triple_count};
use crate::scene::{Keep, Labelling, Scene};

/// The body of a scene, ready to be modelled.
#[derive(Clone, Debug, PartialEq)]
pub struct Body {
    /// Its voxels.
    pub grid: VoxelGrid,
    /// What its labels stand for.
    pub materials: MaterialTable,
    /// The volume that it was read from, where there is one.
    pub volume: Option<Volume>,
    /// What the user should know about how it came about.
    pub remarks: Vec<String>,
}

/// Builds the body of `scene`: reads its files, labels, resamples, keeps the parts that are to stay, and checks that
/// every solid voxel has a material and every condition a node.
///
/// # Errors
/// Files that cannot be read; everything in the scene that does not fit what the files hold.
pub fn build_body(scene: &Scene) -> Result<Body, Failure> {
    let (mut grid, volume) = voxels::read_grid(scene)?;
    materials::require_materials(scene, &grid)?;
    materials::fill_fields(scene, &mut grid);
    let mut remarks = Vec::new();
    if let Some(cells) = scene.body.resample {
        let old = grid.lattice.cells;
        grid = resample(&grid, cells, &precedence(scene)).map_err(|e| unusable(scene, "body.resample", e))?;
        remarks.push(format!("resampled from {} to {} cells", triple_count(old), triple_count(cells)));
    }
    keep_components(scene, &mut grid, &mut remarks)?;
    grid.validate().map_err(|error| unusable(scene, "body", error))?;
    for (key, selector) in conditions(scene) {
        selector.nodes(&grid).map_err(|error| unusable(scene, &format!("{key}.where"), error))?;
    }
    require_edit_regions(scene, &grid)?;
    Ok(Body { materials: materials::table(scene, &grid)?, grid, volume, remarks })
}

/// Refuses edits whose region lies outside of the grid, where geometry alone tells that.
fn require_edit_regions(scene: &Scene, grid: &VoxelGrid) -> Result<(), Failure> {
    let mut picked = Vec::new();
    for edit in scene.edits.iter().filter(|edit| edit.selection.is_geometric()) {
        edit.selection.pick_cells(grid, &mut picked);
        if picked.is_empty() {
            let [low, high] = [[0; 3], grid.lattice.cells].map(|at| grid.position(at));
            let sentence = format!(
                "the region holds no cell of the grid, which extends over x {:.6}..{:.6}, y {:.6}..{:.6}, z {:.6}..{:.6} m; \
                 move or enlarge it",
                low[0], high[0], low[1], high[1], low[2], high[2]
            );
            return Err(unusable(scene, &format!("{}.where", edit.key), sentence));
        }
    }
    Ok(())
}

/// The sentence for an error of the library under the key that caused it.
fn unusable(scene: &Scene, key: &str, error: impl std::fmt::Display) -> Failure {
    scene.unusable(key, error).into()
}

/// Which label wins where two fill a resampled cell equally: the one that the rules name first.
fn precedence(scene: &Scene) -> Vec<grosgrain::mesh::Label> {
    match &scene.body.labelling {
        Labelling::Rules(rules) => rules.iter().map(|rule| rule.label).collect(),
        Labelling::Own { .. } | Labelling::One => Vec::new(),
    }
}

/// The selectors of all conditions with the keys they stand under.
fn conditions(scene: &Scene) -> Vec<(&str, &Selector)> {
    let fixes = scene.fixes.iter().map(|fix| (fix.key.as_str(), &fix.selection));
    let loads = scene.loads.iter().filter_map(|load| Some((load.key.as_str(), load.selection()?)));
    fixes.chain(loads).collect()
}

/// The nodes that any `[[fix]]` of `scene` holds, one entry per node of the lattice.
///
/// # Errors
/// A selection that holds no node of the body.
pub fn held_nodes(scene: &Scene, grid: &VoxelGrid) -> Result<Vec<bool>, Failure> {
    marked_by(scene, grid, scene.fixes.iter().map(|fix| (fix.key.as_str(), &fix.selection)))
}

/// The nodes that a `[[fix]]` or a spring keeps from moving freely.
fn supported_nodes(scene: &Scene, grid: &VoxelGrid) -> Result<Vec<bool>, Failure> {
    let fixes = scene.fixes.iter().map(|fix| (fix.key.as_str(), &fix.selection));
    let springs = scene.loads.iter().filter(|load| load.is_spring());
    marked_by(scene, grid, fixes.chain(springs.filter_map(|load| Some((load.key.as_str(), load.selection()?)))))
}

fn marked_by<'s>(
    scene: &Scene,
    grid: &VoxelGrid,
    selectors: impl Iterator<Item = (&'s str, &'s Selector)>,
) -> Result<Vec<bool>, Failure> {
    let mut held = vec![false; grid.lattice.node_count()];
    for (key, selector) in selectors {
        let NodeSelection { mask, .. } =
            selector.nodes(grid).map_err(|error| unusable(scene, &format!("{key}.where"), error))?;
        held.iter_mut().zip(mask).for_each(|(held, here)| *held |= here);
    }
    Ok(held)
}

fn keep_components(scene: &Scene, grid: &mut VoxelGrid, remarks: &mut Vec<String>) -> Result<(), Failure> {
    let removed = match scene.body.keep {
        Keep::All => return Ok(()),
        Keep::Largest => keep_largest(grid),
        Keep::Supported => {
            let held = held_nodes(scene, grid)?;
            remove_floating(grid, &held)
        }
    };
    if removed != Removed::default() {
        let what = if scene.body.keep == Keep::Largest { "outside the largest part" } else { "that nothing holds" };
        remarks.push(format!(
            "left out {} with {} {what}",
            counted(removed.components, "part"),
            counted(removed.cells, "cell")
        ));
    }
    Ok(())
}
