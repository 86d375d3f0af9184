//! Entities, nodes and elements of version 4.1.

use super::MeshReadError;
use super::encoding::Numbers;
use super::kind::Kind;
use super::read::Sections;

/// `$Entities`: of points, curves, surfaces and volumes the physical groups are kept.
pub(super) fn read_entities(sections: &mut Sections, numbers: &mut Numbers<'_>) -> Result<(), MeshReadError> {
    let mut counts = [0; 4];
    for count in &mut counts {
        *count = numbers.size("the number of entities")?;
    }
    let mut several = 0;
    for (dimension, count) in (0..).zip(counts) {
        for _ in 0..count {
            let entity = numbers.int("the number of an entity")?;
            for _ in 0..if dimension == 0 { 3 } else { 6 } {
                numbers.real("a coordinate of an entity")?;
            }
            let groups = numbers.size("the number of physical groups of an entity")?;
            for n in 0..groups {
                // A negative number stands for the group with its orientation turned.
                let group = numbers.int("the number of a physical group")?.saturating_abs();
                sections.physical.entry((dimension, entity)).or_insert(group);
                several += usize::from(n == 1);
            }
            let bounds = if dimension == 0 { 0 } else { numbers.size("the number of bounding entities")? };
            for _ in 0..bounds {
                numbers.int("the number of a bounding entity")?;
            }
        }
    }
    if several > 0 {
        sections
            .contents
            .notes
            .push(format!("entities in several physical groups, of which the first counts: {several}"));
    }
    numbers.scanner.expect("$EndEntities")
}

/// `$Nodes`: blocks of numbers and then coordinates, on surfaces and curves perhaps with parameters.
pub(super) fn read_nodes(sections: &mut Sections, numbers: &mut Numbers<'_>) -> Result<(), MeshReadError> {
    let blocks = numbers.size("the number of blocks of nodes")?;
    for _ in 0..3 {
        numbers.size("the number of nodes, the lowest and the highest of their numbers")?;
    }
    let mut of_file = Vec::new();
    for _ in 0..blocks {
        let dimension = dimension(numbers)?;
        numbers.int("the number of an entity")?;
        let parameters = if numbers.int("0 or 1 for parametric nodes")? == 0 { 0 } else { dimension };
        let count = numbers.size("the number of nodes of a block")?;
        for _ in 0..count {
            of_file.push(numbers.size("the number of a node")?);
        }
        for _ in 0..count {
            sections.contents.nodes.push(numbers.point()?);
            for _ in 0..parameters {
                numbers.real("a parameter of a node")?;
            }
        }
    }
    sections.set_numbers(&of_file)?;
    numbers.scanner.expect("$EndNodes")
}

/// `$Elements`: blocks of one kind on one entity.
pub(super) fn read_elements(sections: &mut Sections, numbers: &mut Numbers<'_>) -> Result<(), MeshReadError> {
    let blocks = numbers.size("the number of blocks of elements")?;
    for _ in 0..3 {
        numbers.size("the number of elements, the lowest and the highest of their numbers")?;
    }
    for _ in 0..blocks {
        let dimension = dimension(numbers)?;
        let entity = numbers.int("the number of an entity")?;
        let number = numbers.int("the kind of elements")?;
        let kind = Kind::of_number(number)
            .ok_or_else(|| numbers.unexpected(number.into(), "a kind of element of Gmsh up to order 4"))?;
        let group = sections.physical.get(&(dimension, entity)).copied().unwrap_or(0);
        let count = numbers.size("the number of elements of a block")?;
        let mut nodes = [0; Kind::MOST_NODES];
        for _ in 0..count {
            numbers.size("the number of an element")?;
            for node in &mut nodes[..kind.nodes] {
                *node = numbers.size("the number of a node of an element")?;
            }
            sections.add(kind, &nodes[..kind.nodes], [group, entity], || numbers.place())?;
        }
    }
    numbers.scanner.expect("$EndElements")
}

fn dimension(numbers: &mut Numbers<'_>) -> Result<i32, MeshReadError> {
    const EXPECTED: &str = "the dimension of an entity, 0 to 3";
    let dimension = numbers.int(EXPECTED)?;
    match dimension {
        0..=3 => Ok(dimension),
        _ => Err(numbers.unexpected(dimension.into(), EXPECTED)),
    }
}
