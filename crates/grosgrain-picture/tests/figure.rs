//! What a figure promises: the right pixels, hidden parts hidden, the same bytes every time, errors in sentences.

use grosgrain_picture::{
    Category, ColourMap, ColourScale, Colouring, Figure, Image, Panel, PictureError, QuadSurface, Rgb, View,
};

const RED: Rgb = [220, 40, 40];
const BLUE: Rgb = [40, 60, 220];

/// The eye looks along +y; x runs to the right, z up.
const FRONT: View = View { toward: [0.0, 1.0, 0.0], up: [0.0, 0.0, 1.0], perspective: 0.0 };

/// A cube with its own colour per face: −x, +x, −y, +y, −z, +z.
fn cube(low: [f64; 3], side: f64) -> QuadSurface {
    let positions = (0..8).map(|c| std::array::from_fn(|a| low[a] + side * f64::from(c >> a & 1))).collect();
    let quads = vec![[0, 4, 6, 2], [1, 3, 7, 5], [0, 1, 5, 4], [2, 6, 7, 3], [0, 2, 3, 1], [4, 5, 7, 6]];
    QuadSurface { positions, quads }
}

fn join(a: QuadSurface, b: QuadSurface) -> QuadSurface {
    let shift = a.positions.len() as u32;
    let positions = [a.positions, b.positions].concat();
    let moved = b.quads.into_iter().map(|q| q.map(|v| v + shift));
    QuadSurface { positions, quads: a.quads.into_iter().chain(moved).collect() }
}

fn figure(panel: Panel) -> Figure {
    Figure { panels: vec![panel], view: Some(FRONT), width: 600, ..Figure::default() }
}

fn is_like(pixel: Rgb, colour: Rgb) -> bool {
    let strongest = (0..3).max_by_key(|c| colour[*c]);
    (0..3).all(|c| Some(c) == strongest || f64::from(pixel[c]) < 0.6 * f64::from(strongest.map_or(0, |s| pixel[s])))
}

/// Number of pixels like `colour`, and their bounding box as (width, height).
fn extent(image: &Image, colour: Rgb) -> (usize, [usize; 2]) {
    let all = (0..image.height()).flat_map(|y| (0..image.width()).map(move |x| (x, y)));
    let like: Vec<_> = all.filter(|&(x, y)| image.pixel(x, y).is_some_and(|p| is_like(p, colour))).collect();
    let size = |part: fn(&(usize, usize)) -> usize| {
        let ends = like.iter().map(part).min().zip(like.iter().map(part).max());
        ends.map_or(0, |(low, high)| high - low + 1)
    };
    (like.len(), [size(|p| p.0), size(|p| p.1)])
}

fn by_face(surface: QuadSurface, of_quad: Vec<u32>) -> Panel {
    let legend = [RED, BLUE].map(|c| Category { name: String::new(), colour: Some(c) }).to_vec();
    Panel { surface, colouring: Colouring::Category { of_quad, legend }, ..Panel::default() }
}

#[test]
fn a_cube_seen_from_the_front_is_a_square_of_its_front_colour() -> Result<(), PictureError> {
    let panel = Panel { colouring: Colouring::Plain(RED), surface: cube([0.0; 3], 1.0), ..Panel::default() };
    let image = figure(panel).render()?;
    let (count, [width, height]) = extent(&image, RED);
    assert!(width > 100 && width.abs_diff(height) <= 1, "{width} × {height}");
    // All pixels inside the rim are covered; the rim itself is a dark line, blended over at most two pixels a side.
    assert!(count >= (width - 4) * (height - 4), "{count} of {width} × {height}");
    Ok(())
}

#[test]
fn a_body_behind_another_is_hidden() -> Result<(), PictureError> {
    let (front, back) = (cube([0.0, 0.0, 0.0], 1.0), cube([0.2, 2.0, 0.2], 0.6));
    let colours = |a: u32, b: u32| [[a; 6], [b; 6]].concat();
    for panel in [by_face(join(front.clone(), back.clone()), colours(0, 1)), by_face(join(back, front), colours(1, 0))]
    {
        let image = Figure { view: Some(FRONT), ..figure(panel) }.render()?;
        let swatch = extent(&image, BLUE).1;
        // Only the legend's swatch, 24 of 1800 units wide, is blue.
        assert!(swatch[0] <= 10 && swatch[1] <= 10, "{swatch:?}");
        assert!(extent(&image, RED).0 > 10_000);
    }
    Ok(())
}

#[test]
fn grid_lines_show_on_the_front_and_not_through_the_body() -> Result<(), PictureError> {
    let render = |y: f64| {
        let grid = vec![[[0.2, y, 0.3], [0.8, y, 0.3]], [[0.2, y, 0.7], [0.8, y, 0.7]]];
        figure(Panel { surface: cube([0.0; 3], 1.0), colouring: Colouring::Plain(RED), grid, ..Panel::default() })
            .render()
    };
    let none = figure(Panel { surface: cube([0.0; 3], 1.0), colouring: Colouring::Plain(RED), ..Panel::default() });
    let (bare, drawn) = (none.render()?, render(0.0)?);
    let all = (0..bare.height()).flat_map(|y| (0..bare.width()).map(move |x| (x, y)));
    let changed = all.filter(|&(x, y)| bare.pixel(x, y) != drawn.pixel(x, y)).count();
    // Two lines of 0.6 sides, at least a pixel wide.
    let side = extent(&bare, RED).1[0];
    assert!(changed > side, "{changed} pixels changed on a face of {side}");
    assert_eq!(bare, render(1.0)?);
    Ok(())
}

#[test]
fn ends_of_the_colour_scale_take_the_ends_of_the_map() -> Result<(), PictureError> {
    let surface = cube([0.0; 3], 1.0);
    let at_vertex = surface.positions.iter().map(|p| p[2]).collect();
    let scale = ColourScale { label: "height [m]".into(), map: ColourMap::Viridis, ..ColourScale::default() };
    let panel = Panel { surface, colouring: Colouring::Scalar { at_vertex, scale }, ..Panel::default() };
    let image = figure(panel).render()?;
    let column: Vec<Rgb> = (0..image.height()).filter_map(|y| image.pixel(image.width() / 2, y)).collect();
    let yellow = column.iter().position(|p| p[0] > 190 && p[2] < 100);
    let violet = column.iter().position(|p| p[0] < 80 && p[1] < 25 && p[2] > 50);
    assert!(yellow < violet && yellow.is_some(), "{yellow:?} {violet:?}");
    Ok(())
}

#[test]
fn all_panels_share_one_scale() -> Result<(), PictureError> {
    let panel =
        |side, colour| Panel { surface: cube([0.0; 3], side), colouring: Colouring::Plain(colour), ..Panel::default() };
    let figure = Figure { panels: vec![panel(1.0, RED), panel(0.5, BLUE)], width: 900, ..figure(panel(1.0, RED)) };
    let image = figure.render()?;
    let (large, small) = (extent(&image, RED).1[0], extent(&image, BLUE).1[0]);
    // Rims are dark, up to two pixels a side.
    assert!((large + 2).abs_diff(2 * (small + 2)) <= 4, "{large} and {small}");
    Ok(())
}

#[test]
fn the_same_figure_gives_the_same_bytes() -> Result<(), Box<dyn std::error::Error>> {
    let surface = join(cube([0.0; 3], 1.0), cube([1.0, 0.3, 0.2], 0.5));
    let at_vertex = (0..16).map(|v| f64::from(v).sin()).collect();
    let scale = ColourScale { label: "u [m]".into(), ..ColourScale::default() };
    let panel = Panel { surface, colouring: Colouring::Scalar { at_vertex, scale }, ..Panel::default() };
    let figure = Figure { title: "Twice".into(), panels: vec![panel.clone(), panel], width: 500, ..Figure::default() };
    let (mut one, mut other) = (Vec::new(), Vec::new());
    figure.render()?.write_png(&mut one)?;
    figure.render()?.write_png(&mut other)?;
    assert_eq!(one, other);
    let reader = png::Decoder::new(std::io::Cursor::new(one)).read_info()?;
    assert_eq!(reader.info().width, 500);
    Ok(())
}

#[test]
fn long_texts_and_many_categories_stay_inside_the_picture() -> Result<(), PictureError> {
    let long = "a caption that is much longer than its panel is wide, and then some more of it ".repeat(4);
    let legend = (0..60).map(|i| Category::named(format!("material number {i}"))).collect();
    let colouring = Colouring::Category { of_quad: (0..6).collect(), legend };
    let panel = Panel {
        caption: long.clone(),
        detail: long.clone(),
        surface: cube([0.0; 3], 1.0),
        colouring,
        ..Panel::default()
    };
    let figure =
        Figure { title: long.clone(), panels: vec![panel; 5], footer: vec![long; 2], width: 900, ..Figure::default() };
    let image = figure.render()?;
    let page = image.pixel(0, 0);
    for y in 0..image.height() {
        for x in (0..10).chain(image.width() - 10..image.width()) {
            assert_eq!(image.pixel(x, y), page, "something lies in the margin at {x}, {y}");
        }
    }
    Ok(())
}

#[test]
fn a_picture_does_not_depend_on_the_unit_of_length() -> Result<(), PictureError> {
    let render = |unit: f64| {
        let mut surface = join(cube([0.0; 3], 1.0), cube([1.0, 0.3, 0.2], 0.5));
        surface.positions.iter_mut().for_each(|p| *p = p.map(|x| x * unit));
        Figure { view: None, ..figure(Panel { surface, ..Panel::default() }) }.render()
    };
    // Powers of two scale without rounding.
    assert_eq!(render(1.0)?, render(2f64.powi(-200))?);
    assert_eq!(render(1.0)?, render(2f64.powi(200))?);
    Ok(())
}

#[test]
fn flat_and_pointlike_bodies_are_drawn() -> Result<(), PictureError> {
    for positions in [vec![[1.0; 3]; 4], vec![[0.0; 3], [1.0, 0.0, 0.0], [1.0, 1.0, 0.0], [0.0, 1.0, 0.0]]] {
        let surface = QuadSurface { positions, quads: vec![[0, 1, 2, 3]] };
        let image = figure(Panel { surface, ..Panel::default() }).render()?;
        assert!(image.height() > 100);
    }
    Ok(())
}

#[test]
fn what_cannot_be_drawn_is_refused_with_a_sentence() {
    let cube = || Panel { surface: cube([0.0; 3], 1.0), ..Panel::default() };
    let refusal = |panel: Panel| figure(panel).render().map_or_else(|e| e.to_string(), |_| "drawn".into());

    assert!(
        refusal(Panel { caption: "left".into(), ..Panel::default() }).contains("\"left\") has no surface: 0 quads")
    );
    let mut broken = cube();
    broken.surface.positions[3][1] = f64::NAN;
    assert!(refusal(broken).starts_with("panel 0: a coordinate of vertex 3 is NaN"));
    let mut broken = cube();
    broken.surface.quads[2][0] = 8;
    assert_eq!(refusal(broken), "panel 0: quad 2 names vertex 8, but there are only 8");
    let values = |at_vertex, range| Panel {
        colouring: Colouring::Scalar { at_vertex, scale: ColourScale { range, ..ColourScale::default() } },
        ..cube()
    };
    assert_eq!(refusal(values(vec![0.0; 7], None)), "panel 0: 7 values for 8 vertices; one each is needed");
    assert!(refusal(values(vec![f64::INFINITY; 8], None)).contains("the value at vertex 0 is inf"));
    assert!(refusal(values(vec![0.0; 8], Some([1.0, 1.0]))).contains("range 1 to 1 is empty"));
    assert!(refusal(by_face(cube().surface, vec![2; 6])).contains("quad 0 names category 2, but there are only 2"));
    let wide = Figure { width: 100_000, ..figure(cube()) };
    assert!(matches!(wide.render(), Err(PictureError::Width(100_000))));
    assert!(matches!(Figure::default().render(), Err(PictureError::NoPanels)));
}
