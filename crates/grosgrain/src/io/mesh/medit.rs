//! Medit meshes, as CGAL, TetWild, MMG and FreeFEM write them.

use super::scanner::Scanner;
use super::{Contents, MeshFile, MeshReadError, MeshWriteError};
use crate::simplex::SimplexMesh;
use std::io::Write;

/// Reads a Medit mesh (`.mesh`, text); a cell's tag is its reference.
///
/// # Errors
/// What is damaged, with its line; binary meshes and those of MFEM, which have the same ending; elements of the highest dimension that are no simplices of first order.
pub fn read_medit(bytes: &[u8]) -> Result<MeshFile, MeshReadError> {
    refuse_others(bytes)?;
    let mut text = Scanner::with_comments(bytes);
    text.expect("MeshVersionFormatted")?;
    text.parse::<u32>("a version of the format")?;
    let mut reader = Reader { text, contents: Contents::default(), axes: None };
    while let Some(word) = reader.text.next_word() {
        match word {
            b"End" => break,
            _ => reader.section(word)?,
        }
    }
    reader.contents.into_file()
}

fn refuse_others(bytes: &[u8]) -> Result<(), MeshReadError> {
    let (what, remedy) = match bytes {
        [b'M', b'F', b'E', b'M', ..] => (
            "an MFEM mesh",
            "save it from MFEM as VTK or Gmsh (`mesh.PrintVTK`), or convert it to a Medit .mesh or Gmsh .msh file",
        ),
        [1, 0, 0, 0, ..] | [0, 0, 0, 1, ..] => {
            ("a binary Medit mesh (.meshb)", "save it as text (.mesh), e.g. with `meshio convert IN.meshb OUT.mesh`")
        }
        _ => return Ok(()),
    };
    Err(MeshReadError::Unsupported { what: what.into(), remedy })
}

struct Reader<'a> {
    text: Scanner<'a>,
    contents: Contents,
    axes: Option<usize>,
}

impl Reader<'_> {
    fn section(&mut self, keyword: &[u8]) -> Result<(), MeshReadError> {
        if !keyword.first().is_some_and(u8::is_ascii_alphabetic) {
            return Err(self.text.unexpected(keyword, "a keyword, e.g. Tetrahedra"));
        }
        match keyword {
            b"Dimension" => {
                let axes: usize = self.text.parse("a dimension, 2 or 3")?;
                self.axes = Some(axes).filter(|a| matches!(a, 2 | 3));
                self.axes
                    .map(|_| ())
                    .ok_or_else(|| self.text.unexpected(axes.to_string().as_bytes(), "a dimension, 2 or 3"))
            }
            b"Vertices" => self.vertices(),
            b"Edges" => self.simplices(2),
            b"Triangles" => self.simplices(3),
            b"Tetrahedra" => self.simplices(4),
            b"Quadrilaterals" => self.others(2, "quadrilaterals"),
            b"Hexahedra" | b"Hexaedra" => self.others(3, "hexahedra"),
            b"Prisms" | b"Pentahedra" | b"Wedges" => self.others(3, "prisms"),
            b"Pyramids" => self.others(3, "pyramids"),
            b"TetrahedraP2" => self.others(3, "tetrahedra of second order"),
            b"TrianglesP2" => self.others(2, "triangles of second order"),
            _ => self.skip(),
        }
    }

    fn vertices(&mut self) -> Result<(), MeshReadError> {
        if !self.contents.nodes.is_empty() {
            return Err(self.text.unexpected(b"Vertices", "no second list of vertices"));
        }
        let axes = self.axes.ok_or(MeshReadError::Missing {
            section: "Dimension before Vertices",
            remedy: "write `Dimension 3` (or 2) below its first line",
        })?;
        let count: u64 = self.text.parse("the number of vertices")?;
        for _ in 0..count {
            let mut at = [0.0; 3];
            for x in &mut at[..axes] {
                *x = self.text.parse("a coordinate of a vertex")?;
            }
            self.text.parse::<i64>("the reference of a vertex")?;
            self.contents.nodes.push(at);
        }
        Ok(())
    }

    fn simplices(&mut self, corners: usize) -> Result<(), MeshReadError> {
        if self.contents.nodes.is_empty() {
            return Err(MeshReadError::Missing {
                section: "Vertices before its elements",
                remedy: "move the section Vertices to the front",
            });
        }
        let count: u64 = self.text.parse("the number of elements")?;
        let vertices = self.contents.nodes.len() as u64;
        for _ in 0..count {
            let mut cell = [0; 4];
            for corner in &mut cell[..corners] {
                let vertex: i64 = self.text.parse("the number of a vertex")?;
                let position = u64::try_from(vertex).ok().filter(|v| (1..=vertices).contains(v));
                let position = position.and_then(|v| u32::try_from(v - 1).ok());
                *corner =
                    position.ok_or_else(|| MeshReadError::NoSuchNode { place: self.text.line(), node: vertex })?;
            }
            let tag = self.text.parse("the reference of an element, a whole number of 32 bits")?;
            self.contents.add(&cell[..corners], tag);
        }
        Ok(())
    }

    fn others(&mut self, dimension: usize, plural: &'static str) -> Result<(), MeshReadError> {
        let count: u32 = self.text.parse("the number of elements")?;
        self.contents.add_other(dimension, plural, count as usize);
        self.skip()
    }

    /// Goes to the next keyword.
    fn skip(&mut self) -> Result<(), MeshReadError> {
        let is_keyword = |word: &[u8]| word.first().is_some_and(u8::is_ascii_alphabetic);
        loop {
            let mut ahead = self.text.clone();
            match ahead.next_word() {
                Some(word) if !is_keyword(word) => self.text = ahead,
                _ => return Ok(()),
            }
        }
    }
}

/// Writes a mesh as Medit text, version 2: tags are references, coordinates are exact; segments and triangles in two dimensions.
///
/// # Errors
/// Where `out` refuses.
pub fn write_medit(out: &mut impl Write, mesh: &SimplexMesh) -> Result<(), MeshWriteError> {
    let axes = mesh.dimension().axes().max(2);
    writeln!(out, "MeshVersionFormatted 2\nDimension {axes}\n\nVertices\n{}", mesh.nodes().len())?;
    for node in mesh.nodes() {
        node[..axes].iter().try_for_each(|x| write!(out, "{x:?} "))?;
        writeln!(out, "0")?;
    }
    let section = ["Edges", "Triangles", "Tetrahedra"][mesh.dimension().axes() - 1];
    writeln!(out, "\n{section}\n{}", mesh.cell_count())?;
    for (cell, tag) in mesh.tags().iter().enumerate() {
        mesh.cell(cell).iter().try_for_each(|node| write!(out, "{} ", node + 1))?;
        writeln!(out, "{tag}")?;
    }
    writeln!(out, "\nEnd")?;
    Ok(())
}
