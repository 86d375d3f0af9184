//! What triangles promise: the pixels of the same surface in quads, sharp materials, values by cell.

use grosgrain_picture::{
    Category, ColourMap, ColourScale, Colouring, Figure, Image, Panel, PictureError, QuadSurface, Rgb, View,
};

const RED: Rgb = [220, 40, 40];
const BLUE: Rgb = [40, 60, 220];
/// The eye looks down on the plane of x and y.
const FRONT: View = View { toward: [0.0, 0.0, -1.0], up: [0.0, 1.0, 0.0], perspective: 0.0 };

/// A square of n × n quads with this height over the unit square.
fn sheet(n: usize, height: impl Fn(f64, f64) -> f64) -> QuadSurface {
    let part = |i: usize| i as f64 / n as f64;
    let place = |at: usize| {
        let (x, y) = (part(at % (n + 1)), part(at / (n + 1)));
        [x, y, height(x, y)]
    };
    let quad = |at: usize| {
        let first = (at % n + at / n * (n + 1)) as u32;
        [first, first + 1, first + n as u32 + 2, first + n as u32 + 1]
    };
    QuadSurface { positions: (0..(n + 1) * (n + 1)).map(place).collect(), quads: (0..n * n).map(quad).collect() }
}

/// Each quad cut along its first diagonal, the way in which small quads are drawn.
fn cut(surface: &QuadSurface) -> QuadSurface {
    let halves: Vec<[u32; 3]> = surface.quads.iter().flat_map(|[a, b, c, d]| [[*a, *b, *c], [*a, *c, *d]]).collect();
    QuadSurface::of_triangles(surface.positions.clone(), &halves)
}

fn draw(surface: QuadSurface, colouring: Colouring, view: Option<View>) -> Result<Image, PictureError> {
    let panel = Panel { surface, colouring, ..Panel::default() };
    Figure { panels: vec![panel], view, width: 600, ..Figure::default() }.render()
}

fn pixels(image: &Image) -> impl Iterator<Item = Rgb> + '_ {
    (0..image.width() * image.height()).filter_map(|at| image.pixel(at % image.width(), at / image.width()))
}

fn scale() -> ColourScale {
    ColourScale { label: "height [m]".into(), map: ColourMap::Viridis, ..ColourScale::default() }
}

#[test]
fn a_surface_of_triangles_looks_like_the_same_in_quads() -> Result<(), PictureError> {
    // So fine that edges of cells are not drawn.
    let quads = sheet(150, |x, y| 0.2 * (6.0 * x).sin() * (5.0 * y).cos());
    let triangles = cut(&quads);
    let heights: Vec<f64> = quads.positions.iter().map(|p| p[2]).collect();
    let values = || Colouring::Scalar { at_vertex: heights.clone(), scale: scale() };
    for view in [None, Some(FRONT)] {
        let (one, other) = (draw(quads.clone(), values(), view)?, draw(triangles.clone(), values(), view)?);
        assert_eq!((one.width(), one.height()), (other.width(), other.height()));
        let difference = |(a, b): (Rgb, Rgb)| (0..3).map(|c| a[c].abs_diff(b[c])).max().unwrap_or(0);
        let differences: Vec<u8> = pixels(&one).zip(pixels(&other)).map(difference).collect();
        let far = differences.iter().filter(|d| **d > 3).count();
        assert!(far < differences.len() / 2000, "{far} of {} pixels", differences.len());
        assert!(pixels(&one).filter(|p| p[1] > p[0] && p[1] > p[2]).count() > 10_000, "the surface is seen");
    }
    Ok(())
}

#[test]
fn materials_of_a_flat_mesh_are_crisp_and_its_rim_is_a_line() -> Result<(), PictureError> {
    let surface = cut(&sheet(150, |_, _| 0.0));
    let centre = |quad: &[u32; 4]| (0..3).map(|c| surface.positions[quad[c] as usize][0]).sum::<f64>() / 3.0;
    let of_quad = surface.quads.iter().map(|quad| u32::from(centre(quad) > 0.5)).collect();
    let legend = [RED, BLUE].map(|c| Category { name: String::new(), colour: Some(c) }).to_vec();
    let image = draw(surface, Colouring::Category { of_quad, legend }, Some(FRONT))?;
    let row: Vec<Rgb> = (0..image.width()).filter_map(|x| image.pixel(x, image.height() / 3)).collect();
    let red: Vec<usize> = (0..row.len()).filter(|x| row[*x][0] > 150 && row[*x][2] < 80).collect();
    let blue: Vec<usize> = (0..row.len()).filter(|x| row[*x][2] > 150 && row[*x][0] < 80).collect();
    assert!(red.len() > 100 && red.len().abs_diff(blue.len()) <= 2, "{} and {}", red.len(), blue.len());
    // One colour each from the rim to the middle: flat light, no veil of edges.
    assert_eq!((red.len(), blue.len()), (red[red.len() - 1] - red[0] + 1, blue[blue.len() - 1] - blue[0] + 1));
    assert!([&red, &blue].iter().all(|run| run[2..run.len() - 2].iter().all(|x| row[*x] == row[run[5]])));
    assert!(blue[0] - red[red.len() - 1] <= 4, "materials meet at {} and {}", red[red.len() - 1], blue[0]);
    // On the rim red is darkened by a line; without one its pixels would lie between red and the lighter paper.
    let rim = (red[0] - 2..red[0] + 2).map(|x| row[x][0]).min();
    assert!(rim < Some(row[red[5]][0] - 10), "{rim:?} on the rim of {:?}", row[red[5]]);
    Ok(())
}

#[test]
fn edges_of_triangles_show_when_there_is_room() -> Result<(), PictureError> {
    let surface = cut(&sheet(2, |_, _| 0.0));
    let image = draw(surface, Colouring::Plain(RED), Some(FRONT))?;
    let row: Vec<Rgb> = (0..image.width()).filter_map(|x| image.pixel(x, image.height() / 3)).collect();
    let red: Vec<usize> = (0..row.len()).filter(|x| row[*x][0] > 180 && row[*x][2] < 80).collect();
    let inside = &row[red[0]..=red[red.len() - 1]];
    // Two diagonals and the side between the squares cross a row of pixels.
    let dark = |x: &usize| inside[*x][0] + 2 < inside[3][0];
    let lines: Vec<usize> = (4..inside.len() - 4).filter(dark).collect();
    assert_eq!(lines.chunk_by(|a, b| b - a == 1).count(), 3, "{lines:?}");
    Ok(())
}

#[test]
fn values_by_cell_jump_from_cell_to_cell() -> Result<(), PictureError> {
    let surface = cut(&sheet(1, |_, _| 0.0));
    let colouring = |of_quad| Colouring::QuadScalar { of_quad, scale: scale() };
    let image = draw(surface.clone(), colouring(vec![0.0, 1.0]), Some(FRONT))?;
    // The second triangle lies above the diagonal.
    let (w, h) = (image.width(), image.height());
    let yellow = |x: usize, y: usize| image.pixel(x, y).is_some_and(|p| p[0] > 190 && p[2] < 100);
    let violet = |x: usize, y: usize| image.pixel(x, y).is_some_and(|p| p[0] < 90 && p[1] < 25 && p[2] > 50);
    assert!(yellow(w * 2 / 5, h / 4) && violet(w * 3 / 5, h / 2), "{:?}", image.pixel(w * 2 / 5, h / 4));
    let refusal =
        |of_quad| draw(surface.clone(), colouring(of_quad), None).map_or_else(|e| e.to_string(), |_| "drawn".into());
    assert_eq!(refusal(vec![0.0]), "panel 0: 1 values for 2 quads; one each is needed");
    assert!(refusal(vec![0.0, f64::NAN]).starts_with("panel 0: the value of quad 1 is NaN"));
    Ok(())
}

/// A tetrahedron around or in the unit cube, its faces against the clock from outside.
fn tetrahedron(low: f64, side: f64) -> QuadSurface {
    let corners = [[0.0; 3], [1.0, 0.0, 0.0], [0.0, 1.0, 0.0], [0.0, 0.0, 1.0]];
    let positions = corners.iter().map(|c| c.map(|x| low + side * x)).collect();
    QuadSurface::of_triangles(positions, &[[0, 2, 1], [0, 1, 3], [0, 3, 2], [1, 2, 3]])
}

#[test]
fn wires_show_over_the_body_and_not_their_far_side() -> Result<(), PictureError> {
    let draw = |wires: QuadSurface| {
        // Vertices without a face keep the camera where it is.
        let mut surface = tetrahedron(0.0, 1.0);
        surface.positions.extend([[-0.2; 3], [1.2; 3]]);
        let panel = Panel { surface, colouring: Colouring::Plain(RED), wires, ..Panel::default() };
        Figure { panels: vec![panel], view: Some(FRONT), width: 600, ..Figure::default() }.render()
    };
    let changed = |wires: QuadSurface| -> Result<usize, PictureError> {
        let (bare, drawn) = (draw(QuadSurface::default())?, draw(wires)?);
        Ok(pixels(&bare).zip(pixels(&drawn)).filter(|(a, b)| a != b).count())
    };
    // Just inside the body, and deep in it.
    assert!(changed(tetrahedron(0.01, 0.95))? > 200);
    assert_eq!(changed(tetrahedron(0.1, 0.1))?, 0);
    // Turned inside out only the far side looks at the eye, and most of it lies too deep.
    let mut inside_out = tetrahedron(0.01, 0.95);
    inside_out.quads.iter_mut().for_each(|quad| quad.swap(0, 1));
    assert!(changed(inside_out)? < changed(tetrahedron(0.01, 0.95))?);
    let refusal = draw(QuadSurface { positions: vec![[0.0; 3]; 3], quads: vec![[0, 1, 3, 3]] });
    let refusal = refusal.map_or_else(|e| e.to_string(), |_| "drawn".into());
    assert_eq!(refusal, "panel 0: quad 0 names wire vertex 3, but there are only 3");
    Ok(())
}
