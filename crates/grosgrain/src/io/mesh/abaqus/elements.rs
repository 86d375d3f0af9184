//! Names of element types.

/// What an element type is to a mesh of simplices.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum ElementKind {
    /// A simplex of first order with so many corners.
    Simplex(usize),
    /// Anything else: its number of axes and the name of several.
    Other(usize, &'static str),
}

/// Families by how their names begin, of which the number of nodes follows. Shells, membranes and beams are surfaces and curves.
const FAMILIES: [(usize, &[&str]); 3] = [
    (3, &["C3D", "DC3D", "AC3D", "EC3D"]),
    (2, &["CPE", "CPS", "DC2D", "AC2D", "CPEG", "M3D", "R3D", "SFM3D", "STRI", "DS", "S"]),
    (1, &["T2D", "T3D", "DC1D", "AC1D", "R2D"]),
];

impl ElementKind {
    /// What a type is, e.g. `C3D4H`; letters after the number of nodes only change its mechanics.
    pub fn of_type(name: &str) -> Self {
        let name = name.to_ascii_uppercase();
        match name.as_str() {
            "B21" | "B21H" | "B23" | "B31" | "B31H" | "B33" | "B31OS" => return Self::Simplex(2),
            "B22" | "B22H" | "B32" | "B32H" => return Self::Other(1, "curved segments"),
            "STRI65" => return Self::Other(2, "triangles of higher order"),
            _ => {}
        }
        let after = |family: &str| -> Option<usize> {
            let rest = name.strip_prefix(family)?;
            let digits = rest.len() - rest.trim_start_matches(|c: char| c.is_ascii_digit()).len();
            rest[..digits].parse().ok()
        };
        let found = FAMILIES.iter().find_map(|(axes, names)| Some((*axes, names.iter().find_map(|n| after(n))?)));
        match found {
            Some((axes, nodes)) => Self::of_nodes(axes, nodes),
            None if name.starts_with("CAX") => Self::Other(2, "axisymmetric elements"),
            None => Self::Other(0, "elements of other types"),
        }
    }

    const fn of_nodes(axes: usize, nodes: usize) -> Self {
        match (axes, nodes) {
            (3, 4) | (2, 3) | (1, 2) => Self::Simplex(nodes),
            (3, 10) => Self::Other(3, "tetrahedra of higher order"),
            (3, 5) => Self::Other(3, "pyramids"),
            (3, 6 | 15) => Self::Other(3, "wedges"),
            (3, 8 | 20 | 27) => Self::Other(3, "hexahedra"),
            (2, 6) => Self::Other(2, "triangles of higher order"),
            (2, 4 | 8 | 9) => Self::Other(2, "quadrilaterals"),
            (1, 3) => Self::Other(1, "curved segments"),
            _ => Self::Other(axes, "elements of other types"),
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn types_are_known_by_their_nodes() {
        for name in ["C3D4", "c3d4h", "DC3D4", "AC3D4"] {
            assert_eq!(ElementKind::of_type(name), ElementKind::Simplex(4), "{name}");
        }
        for name in ["CPE3", "CPS3", "S3", "S3R", "STRI3", "M3D3", "SFM3D3", "CPE3T"] {
            assert_eq!(ElementKind::of_type(name), ElementKind::Simplex(3), "{name}");
        }
        for name in ["T2D2", "T3D2H", "B31"] {
            assert_eq!(ElementKind::of_type(name), ElementKind::Simplex(2), "{name}");
        }
        let others =
            [("C3D10M", 3), ("C3D8R", 3), ("CPS4R", 2), ("S4R", 2), ("CAX3", 2), ("STRI65", 2), ("SPRING1", 0)];
        for (name, axes) in others {
            assert!(matches!(ElementKind::of_type(name), ElementKind::Other(a, _) if a == axes), "{name}");
        }
    }
}
