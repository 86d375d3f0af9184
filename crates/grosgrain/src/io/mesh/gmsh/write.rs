//! Writing version 4.1 as text.

use super::super::MeshWriteError;
use crate::simplex::SimplexMesh;
use std::collections::BTreeMap;
use std::io::Write;

/// Cells of a tag, and the entity that holds them.
struct Group {
    tag: i32,
    entity: i32,
    cells: Vec<usize>,
}

/// Writes a mesh as Gmsh text, version 4.1: each tag is a geometric entity and a physical group with its name, coordinates are exact.
///
/// Cells of tag 0 are in an entity without a physical group. Cells stand in the order of tags.
///
/// # Errors
/// Tags below 0, which Gmsh does not have; where `out` refuses.
pub fn write_gmsh(out: &mut impl Write, mesh: &SimplexMesh, names: &[(i32, String)]) -> Result<(), MeshWriteError> {
    let groups = groups(mesh)?;
    let dimension = mesh.dimension().axes();
    writeln!(out, "$MeshFormat\n4.1 0 8\n$EndMeshFormat")?;
    write_names(out, dimension, &groups, names)?;
    write_entities(out, mesh, &groups)?;
    let (nodes, cells) = (mesh.nodes().len(), mesh.cell_count());
    writeln!(out, "$Nodes\n1 {nodes} 1 {nodes}\n{dimension} {} 0 {nodes}", groups[0].entity)?;
    (1..=nodes).try_for_each(|node| writeln!(out, "{node}"))?;
    mesh.nodes().iter().try_for_each(|[x, y, z]| writeln!(out, "{x:?} {y:?} {z:?}"))?;
    writeln!(out, "$EndNodes\n$Elements\n{} {cells} 1 {cells}", groups.len())?;
    let kind = [1, 2, 4][dimension - 1];
    let mut number = 0;
    for group in &groups {
        writeln!(out, "{dimension} {} {kind} {}", group.entity, group.cells.len())?;
        for cell in &group.cells {
            number += 1;
            write!(out, "{number}")?;
            mesh.cell(*cell).iter().try_for_each(|node| write!(out, " {}", node + 1))?;
            writeln!(out)?;
        }
    }
    writeln!(out, "$EndElements")?;
    Ok(())
}

fn groups(mesh: &SimplexMesh) -> Result<Vec<Group>, MeshWriteError> {
    let mut cells: BTreeMap<i32, Vec<usize>> = BTreeMap::new();
    for (cell, tag) in mesh.tags().iter().enumerate() {
        cells.entry(*tag).or_default().push(cell);
    }
    let [lowest, highest] = [cells.keys().next(), cells.keys().next_back()].map(|tag| tag.copied().unwrap_or(0));
    if lowest < 0 {
        return Err(MeshWriteError::NegativeTag { tag: lowest, cells: cells[&lowest].len() });
    }
    let free = match highest {
        i32::MAX => (1..i32::MAX).find(|n| !cells.contains_key(n)).unwrap_or(i32::MAX),
        _ => highest + 1,
    };
    let entity = |tag: i32| if tag == 0 { free } else { tag };
    Ok(cells.into_iter().map(|(tag, cells)| Group { tag, entity: entity(tag), cells }).collect())
}

/// Names of the tags that cells have.
fn write_names(
    out: &mut impl Write,
    dimension: usize,
    groups: &[Group],
    names: &[(i32, String)],
) -> Result<(), MeshWriteError> {
    let named = |group: &&Group| names.iter().find(|(tag, _)| *tag == group.tag).filter(|_| group.tag != 0);
    let used: Vec<&(i32, String)> = groups.iter().filter_map(|group| named(&group)).collect();
    if used.is_empty() {
        return Ok(());
    }
    writeln!(out, "$PhysicalNames\n{}", used.len())?;
    for (tag, name) in used {
        let name = name.replace(|c: char| c == '"' || c.is_control(), "'");
        writeln!(out, "{dimension} {tag} \"{name}\"")?;
    }
    writeln!(out, "$EndPhysicalNames")?;
    Ok(())
}

fn write_entities(out: &mut impl Write, mesh: &SimplexMesh, groups: &[Group]) -> Result<(), MeshWriteError> {
    let dimension = mesh.dimension().axes();
    let count = |d: usize| if d == dimension { groups.len() } else { 0 };
    writeln!(out, "$Entities\n0 {} {} {}", count(1), count(2), count(3))?;
    for group in groups {
        let [low, high] = bounds(mesh, &group.cells);
        write!(out, "{}", group.entity)?;
        low.iter().chain(&high).try_for_each(|x| write!(out, " {x:?}"))?;
        match group.tag {
            0 => writeln!(out, " 0 0")?,
            tag => writeln!(out, " 1 {tag} 0")?,
        }
    }
    writeln!(out, "$EndEntities")?;
    Ok(())
}

/// Smallest and largest coordinates of cells.
fn bounds(mesh: &SimplexMesh, cells: &[usize]) -> [[f64; 3]; 2] {
    let mut bounds = [[f64::INFINITY; 3], [f64::NEG_INFINITY; 3]];
    for node in cells.iter().flat_map(|cell| mesh.cell(*cell)) {
        for (a, x) in mesh.nodes()[*node as usize].iter().enumerate() {
            bounds[0][a] = bounds[0][a].min(*x);
            bounds[1][a] = bounds[1][a].max(*x);
        }
    }
    bounds
}
