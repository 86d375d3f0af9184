//! The filled hull of a body.

use super::{Cell, Lattice, Neighbourhood};

/// Which cells belong to the filled hull: the solid cells and the interior voids.
///
/// A void is exterior if a path over cells that share at least a node leads from it out of the box; so an
/// interior void is enclosed by one face-connected component. `void` and the result hold one entry per cell.
pub fn hull(void: &[bool], lattice: &Lattice) -> Vec<bool> {
    let mut inside = vec![true; void.len()];
    let outermost: Vec<Cell> =
        (0..void.len()).map(Cell).filter(|c| void[c.0] && on_the_box(lattice.cell_position(*c), lattice)).collect();
    outermost.iter().for_each(|c| inside[c.0] = false);
    Neighbourhood::Nodes.flood(lattice, outermost, |cell| {
        let new = void[cell.0] && inside[cell.0];
        if new {
            inside[cell.0] = false;
        }
        new
    });
    inside
}

fn on_the_box(at: [usize; 3], lattice: &Lattice) -> bool {
    (0..3).any(|a| at[a] == 0 || at[a] + 1 == lattice.cells[a])
}

#[cfg(test)]
mod tests {
    use super::*;

    fn shell() -> (Lattice, Vec<bool>) {
        let lattice = Lattice::new([5, 5, 5]);
        let void = (0..125).map(|c| !on_the_box(lattice.cell_position(Cell(c)), &lattice)).collect();
        (lattice, void)
    }

    #[test]
    fn a_closed_shell_holds_its_inside() {
        let (lattice, void) = shell();
        assert_eq!(hull(&void, &lattice), vec![true; 125]);
    }

    #[test]
    fn a_shell_that_is_open_at_one_corner_node_holds_nothing() {
        let (lattice, mut void) = shell();
        void[lattice.cell([0, 0, 0]).0] = true;
        let solid: Vec<bool> = void.iter().map(|v| !v).collect();
        assert_eq!(hull(&void, &lattice), solid, "the inside touches the removed corner cell at one node");
    }

    #[test]
    fn voids_around_a_body_are_outside() {
        let lattice = Lattice::new([3, 3, 3]);
        let mut void = vec![true; 27];
        void[13] = false;
        assert_eq!(hull(&void, &lattice).iter().filter(|i| **i).count(), 1);
    }
}
