//! Panels that show meshes of simplices: by material or by value, with the edges of a coarse mesh, and their outline at rest.

use std::sync::Arc;

use grosgrain::mesh::Label;
use grosgrain::simplex::Dimension;
use grosgrain_picture::{Category, ColourScale, Colouring, Lines, Panel, QuadSurface, Rgb, View, category_colour};

use super::SimplexSkin;

/// A skin under displacements \[m\] of the nodes of its mesh, three per node.
#[derive(Clone, Copy, Debug)]
pub struct Posed<'a> {
    /// What is seen.
    pub skin: &'a Arc<SimplexSkin>,
    /// How its mesh is displaced.
    pub displacement: &'a [f64],
}

/// How a mesh is coloured.
#[derive(Clone, Debug)]
pub enum Paint<'a> {
    /// In one colour.
    Plain(Rgb),
    /// By the tags of cells, with a legend where there are several.
    Tags,
    /// By a value per node, linear in between, with a colour bar.
    Nodes(&'a [f64], ColourScale),
    /// By a value per cell, with a colour bar.
    Cells(&'a [f64], ColourScale),
}

/// How meshes are drawn.
#[derive(Clone, Debug)]
pub struct SimplexLook {
    /// Name and colour of each tag in the legend; others are called `tag N`.
    pub materials: Vec<(Label, String, Option<Rgb>)>,
    /// Displacements are drawn so many times.
    pub scale: f64,
    /// Whether the outline at rest is drawn faintly behind the body.
    pub ghost: bool,
}

impl Default for SimplexLook {
    fn default() -> Self {
        Self { materials: Vec::new(), scale: 1.0, ghost: true }
    }
}

impl SimplexLook {
    /// A panel without caption that shows a mesh; `wires` is a mesh whose edges are drawn over it, such as a coarse one.
    ///
    /// ```
    /// use std::sync::Arc;
    /// use grosgrain::simplex::{BoundingBox, BoxCut, Dimension, SimplexLattice};
    /// use grosgrain_cli::meshes::{Paint, Posed, SimplexLook, SimplexSkin, simplex_view};
    /// use grosgrain_picture::{Figure, Panel};
    /// let around = BoundingBox { lower: [0.0; 3], upper: [0.2, 0.1, 0.0] };
    /// let lattice = |boxes| SimplexLattice { dimension: Dimension::Two, boxes, around, cut: BoxCut::Alternating };
    /// let fine = lattice([16, 8, 0]).mesh()?.tagged(|x| if x[1] < 0.05 { 1 } else { 2 });
    /// let coarse = lattice([4, 2, 0]).mesh()?;
    /// let skins = [&fine, &coarse].map(|mesh| SimplexSkin::new(mesh, None).map(Arc::new));
    /// let [fine_skin, coarse_skin] = skins;
    /// let (fine_skin, coarse_skin) = (fine_skin?, coarse_skin?);
    /// let still = [vec![0.0; 3 * fine.nodes().len()], vec![0.0; 3 * coarse.nodes().len()]];
    /// let body = Posed { skin: &fine_skin, displacement: &still[0] };
    /// let wires = Posed { skin: &coarse_skin, displacement: &still[1] };
    /// let panel = Panel { caption: "Two layers".into(), ..SimplexLook::default().panel(body, &Paint::Tags, Some(wires)) };
    /// let figure = Figure { panels: vec![panel], view: simplex_view(Dimension::Two), ..Figure::default() };
    /// assert_eq!(figure.render()?.width(), 1800);
    /// # Ok::<(), Box<dyn std::error::Error>>(())
    /// ```
    ///
    /// # Panics
    /// Displacements or values whose number is not that of nodes or cells.
    pub fn panel(&self, body: Posed<'_>, paint: &Paint<'_>, wires: Option<Posed<'_>>) -> Panel {
        let skin = body.skin;
        Panel {
            surface: self.surface(body),
            colouring: self.colouring(skin, paint),
            wires: wires.map(|wires| self.surface(wires)).unwrap_or_default(),
            ghost: if self.ghost { skin.outline() } else { Lines::new() },
            ..Panel::default()
        }
    }

    fn surface(&self, posed: Posed<'_>) -> QuadSurface {
        let positions = posed.skin.displaced(posed.displacement, self.scale).collect();
        QuadSurface { positions, quads: posed.skin.faces().to_vec() }
    }

    fn colouring(&self, skin: &SimplexSkin, paint: &Paint<'_>) -> Colouring {
        match paint {
            Paint::Plain(colour) => Colouring::Plain(*colour),
            Paint::Tags => self.by_tag(skin),
            Paint::Nodes(values, scale) => {
                Colouring::Scalar { at_vertex: skin.at_vertices(values), scale: scale.clone() }
            }
            Paint::Cells(values, scale) => {
                Colouring::QuadScalar { of_quad: skin.of_faces(values), scale: scale.clone() }
            }
        }
    }

    /// Tags have the same colours in all panels of a mesh, and the legend names those that are seen.
    fn by_tag(&self, skin: &SimplexSkin) -> Colouring {
        let mut seen = skin.tags().to_vec();
        seen.sort_unstable();
        seen.dedup();
        let legend: Vec<Category> = seen.iter().map(|tag| self.category(skin, *tag)).collect();
        match &legend[..] {
            [Category { colour: Some(only), .. }] => Colouring::Plain(*only),
            _ => {
                let number = |tag: &Label| seen.binary_search(tag).unwrap_or_default() as u32;
                Colouring::Category { of_quad: skin.tags().iter().map(number).collect(), legend }
            }
        }
    }

    fn category(&self, skin: &SimplexSkin, tag: Label) -> Category {
        let own = category_colour(skin.tags_of_mesh().binary_search(&tag).unwrap_or_default());
        match self.materials.iter().find(|(known, _, _)| *known == tag) {
            Some((_, name, colour)) => Category { name: name.clone(), colour: Some(colour.unwrap_or(own)) },
            None => Category { name: format!("tag {}", tag.0), colour: Some(own) },
        }
    }
}

/// The view in which meshes of this dimension are drawn unless another is chosen: the plane from the front; `None`, which is a three-quarter view, in space.
pub fn simplex_view(dimension: Dimension) -> Option<View> {
    match dimension {
        Dimension::Three => None,
        _ => Some(View { toward: [0.0, 0.0, -1.0], up: [0.0, 1.0, 0.0], perspective: 0.0 }),
    }
}
