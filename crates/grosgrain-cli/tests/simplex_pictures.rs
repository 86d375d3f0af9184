//! Skins of meshes, whole and cut open, and the panels and films that show them.

use std::fs;
use std::path::Path;
use std::sync::Arc;

use grosgrain::homogenization::HarmonicDisplacements;
use grosgrain::mesh::Label;
use grosgrain::simplex::{BoundingBox, BoxCut, Dimension, SimplexLattice, SimplexMesh};
use grosgrain_cli::film::{FilmOptions, SimplexFilm};
use grosgrain_cli::meshes::{MeshCut, Paint, Posed, SimplexLook, SimplexSkin, harmonic_panels, simplex_view};
use grosgrain_picture::{ColourScale, Colouring, Figure, Image, Panel, Rgb};
use tempfile::tempdir;

const RED: Rgb = [220, 40, 40];
const BLUE: Rgb = [40, 60, 220];

/// The unit square or cube.
fn unit_mesh(dimension: Dimension, boxes: usize) -> SimplexMesh {
    let around = BoundingBox { lower: [0.0; 3], upper: [1.0; 3] };
    SimplexLattice { dimension, boxes: [boxes; 3], around, cut: BoxCut::Alternating }.mesh().unwrap()
}

/// A cube with a core of tag 2, a cube half as wide in its middle.
fn cored(boxes: usize) -> SimplexMesh {
    let in_core = |x: [f64; 3]| x.iter().all(|x| (x - 0.5).abs() < 0.25);
    unit_mesh(Dimension::Three, boxes).tagged(|x| if in_core(x) { 2 } else { 1 })
}

fn skin(mesh: &SimplexMesh, cut: Option<&MeshCut>) -> Arc<SimplexSkin> {
    Arc::new(SimplexSkin::new(mesh, cut).unwrap())
}

fn displacement(mesh: &SimplexMesh, u: impl Fn([f64; 3]) -> [f64; 3]) -> Vec<f64> {
    mesh.nodes().iter().flat_map(|x| u(*x)).collect()
}

fn still(mesh: &SimplexMesh) -> Vec<f64> {
    displacement(mesh, |_| [0.0; 3])
}

fn corners(skin: &SimplexSkin, places: &[[f64; 3]]) -> Vec<[[f64; 3]; 4]> {
    skin.faces().iter().map(|face| face.map(|v| places[v as usize])).collect()
}

/// Area vector of a plane quadrilateral or triangle.
fn area([a, b, c, d]: [[f64; 3]; 4]) -> [f64; 3] {
    let [p, q]: [[f64; 3]; 2] = [[a, c], [b, d]].map(|[from, to]| std::array::from_fn(|r| to[r] - from[r]));
    [0, 1, 2].map(|r| 0.5 * (p[(r + 1) % 3] * q[(r + 2) % 3] - p[(r + 2) % 3] * q[(r + 1) % 3]))
}

/// What closed faces enclose by the divergence theorem, ⅓ ∮ x·n dA, and the sum of their area vectors.
fn enclosed(faces: &[[[f64; 3]; 4]]) -> (f64, [f64; 3]) {
    let (mut volume, mut sum) = (0.0, [0.0; 3]);
    for face in faces {
        // A plane face: any of its points will do.
        let normal = area(*face);
        volume += (0..3).map(|r| face[0][r] * normal[r]).sum::<f64>() / 3.0;
        sum = std::array::from_fn(|r| sum[r] + normal[r]);
    }
    (volume, sum)
}

#[test]
fn skins_enclose_what_is_left_of_the_body() {
    let mesh = cored(4);
    let cut = |x: f64, away, spared: &[i32]| MeshCut {
        through: [x; 3],
        away,
        spared: spared.iter().map(|tag| Label(*tag)).collect(),
    };
    // Through cells, along faces of cells, slanted, with the core spared, with all but the core.
    let cases = [
        (cut(0.37, [2.0, 0.0, 0.0], &[]), 0.37),
        (cut(0.5, [0.0, -1.0, 0.0], &[]), 0.5),
        (cut(0.5, [1.0, 1.0, 0.3], &[]), 0.5),
        (cut(0.5, [0.3, 0.2, -0.1], &[2]), 0.5 + 0.0625),
        (cut(0.37, [1.0, 0.0, 0.0], &[2]), 0.37 + 0.25 * (0.75 - 0.37)),
        (cut(0.37, [1.0, 0.0, 0.0], &[1]), 1.0 - 0.25 * (0.75 - 0.37)),
        (cut(0.5, [1.0, 0.0, 0.0], &[1, 2]), 1.0),
        (cut(9.0, [1.0, 0.0, 0.0], &[]), 1.0),
    ];
    let whole = skin(&mesh, None);
    assert_eq!((whole.faces().len(), whole.vertex_count()), (6 * 2 * 16, 98));
    assert!((enclosed(&corners(&whole, whole.rest())).0 - 1.0).abs() < 1e-13);
    for (cut, volume) in cases {
        let skin = skin(&mesh, Some(&cut));
        let (found, sum) = enclosed(&corners(&skin, skin.rest()));
        assert!((found - volume).abs() < 1e-13, "{cut:?}: {found} for {volume}");
        assert!(sum.iter().all(|x| x.abs() < 1e-13), "{cut:?}: not closed, {sum:?}");
        // Every edge lies between faces in pairs, so that no seam shows.
        let sides = |face: &[u32; 4]| (0..4).map(|n| [face[n], face[(n + 1) % 4]]).collect::<Vec<_>>();
        let mut edges: Vec<[u32; 2]> = skin.faces().iter().flat_map(sides).filter(|[a, b]| a != b).collect();
        edges.iter_mut().for_each(|edge| edge.sort_unstable());
        edges.sort_unstable();
        assert!(edges.chunk_by(|a, b| a == b).all(|group| group.len() % 2 == 0), "{cut:?}");
    }
}

#[test]
fn skins_move_as_their_mesh_does_and_carry_its_values() {
    let mesh = cored(4);
    let cut = MeshCut { through: [0.4, 0.5, 0.45], away: [1.0, -0.4, 0.2], spared: vec![Label(2)] };
    let skin = skin(&mesh, Some(&cut));
    let gradient = [[0.2, 0.1, -0.3], [0.05, -0.1, 0.2], [0.1, 0.0, 0.3]];
    let linear = |x: [f64; 3]| [0, 1, 2].map(|r| (0..3).map(|c| gradient[r][c] * x[c]).sum());
    let moved: Vec<[f64; 3]> = skin.displaced(&displacement(&mesh, linear), 2.0).collect();
    for (at, found) in skin.rest().iter().zip(&moved) {
        let u = linear(*at);
        assert!((0..3).all(|r| (found[r] - at[r] - 2.0 * u[r]).abs() < 1e-14), "{at:?} went to {found:?}");
    }
    // By the determinant of 1 + 2 ∇u.
    let f: [[f64; 3]; 3] = std::array::from_fn(|r| std::array::from_fn(|c| f64::from(r == c) + 2.0 * gradient[r][c]));
    let determinant: f64 =
        (0..3).map(|c| f[0][c] * (f[1][(c + 1) % 3] * f[2][(c + 2) % 3] - f[1][(c + 2) % 3] * f[2][(c + 1) % 3])).sum();
    let [before, after] = [skin.rest(), &moved].map(|places| enclosed(&corners(&skin, places)).0);
    assert!((after - determinant * before).abs() < 1e-13, "{after} of {before}");
    let value = |x: &[f64; 3]| 3.0 + x[0] - 2.0 * x[1] + 0.5 * x[2];
    let values = skin.at_vertices(&mesh.nodes().iter().map(value).collect::<Vec<_>>());
    assert!(skin.rest().iter().zip(values).all(|(x, found)| (value(x) - found).abs() < 1e-14));
}

#[test]
fn plane_meshes_are_cut_through_their_triangles() {
    let mesh = unit_mesh(Dimension::Two, 8).tagged(|x| if x[0] < 0.5 { 1 } else { 2 });
    let whole = skin(&mesh, None);
    assert_eq!((whole.faces().len(), whole.outline().len()), (128, 32));
    let cut = MeshCut { through: [0.3, 0.55, 0.0], away: [0.0, 1.0, 0.0], spared: vec![] };
    let part = skin(&mesh, Some(&cut));
    let total: f64 = corners(&part, part.rest()).iter().map(|face| area(*face)[2]).sum();
    assert!((total - 0.55).abs() < 1e-14, "{total}");
    let length: f64 = part.outline().iter().map(|[a, b]| (a[0] - b[0]).hypot(a[1] - b[1])).sum();
    assert!((length - 2.0 * 1.55).abs() < 1e-13, "{length}");
}

#[test]
fn what_cannot_be_seen_is_refused() {
    let refusal = |mesh: &SimplexMesh, cut: Option<&MeshCut>| {
        SimplexSkin::new(mesh, cut).map_or_else(|e| e.to_string(), |_| "drawn".into())
    };
    let mesh = cored(4);
    let all = MeshCut { through: [-1.0; 3], away: [1.0, 0.0, 0.0], spared: vec![Label(7)] };
    assert_eq!(
        refusal(&mesh, Some(&all)),
        "a cut through (-1, -1, -1) leaves nothing of the mesh to draw; turn its normal round or move it"
    );
    assert!(
        refusal(&mesh, Some(&MeshCut::default())).starts_with("no plane goes through [0.0, 0.0, 0.0] with the normal")
    );
    let line = unit_mesh(Dimension::One, 3);
    assert!(refusal(&line, None).starts_with("a mesh of segments has no surface"));
}

fn is_like(pixel: Rgb, colour: Rgb) -> bool {
    let strongest = if colour[0] > colour[2] { 0 } else { 2 };
    (0..3).all(|c| c == strongest || f64::from(pixel[c]) < 0.6 * f64::from(pixel[strongest]))
}

/// Centre and number of pixels like a colour above the legend.
fn centre(image: &Image, colour: Rgb) -> ([f64; 2], usize) {
    let all = (0..image.height() - 50).flat_map(|y| (0..image.width()).map(move |x| (x, y)));
    let like: Vec<_> = all.filter(|(x, y)| image.pixel(*x, *y).is_some_and(|p| is_like(p, colour))).collect();
    let mean = |part: fn(&(usize, usize)) -> usize| like.iter().map(part).sum::<usize>() as f64 / like.len() as f64;
    ([mean(|p| p.0), mean(|p| p.1)], like.len())
}

fn look() -> SimplexLook {
    let materials = vec![(Label(1), "matrix".into(), Some(RED)), (Label(2), "core".into(), Some(BLUE))];
    SimplexLook { materials, ..SimplexLook::default() }
}

fn draw(panel: Panel, dimension: Dimension) -> Image {
    Figure { panels: vec![panel], view: simplex_view(dimension), width: 600, ..Figure::default() }.render().unwrap()
}

fn names(panel: &Panel) -> Vec<String> {
    match &panel.colouring {
        Colouring::Category { legend, .. } => legend.iter().map(|c| c.name.clone()).collect(),
        _ => Vec::new(),
    }
}

#[test]
fn a_cut_shows_the_core_that_the_whole_hides() {
    let (mesh, zero) = (cored(8), still(&cored(8)));
    let cut = MeshCut { through: [0.5; 3], away: [0.0, -1.0, 0.0], spared: vec![] };
    let [whole, open] = [None, Some(&cut)].map(|cut| {
        let skin = skin(&mesh, cut);
        look().panel(Posed { skin: &skin, displacement: &zero }, &Paint::Tags, None)
    });
    assert!(names(&whole).is_empty(), "one material needs no legend");
    assert_eq!(whole.colouring, Colouring::Plain(RED));
    assert_eq!(names(&open), ["matrix", "core"]);
    let [whole, open] = [whole, open].map(|panel| draw(panel, Dimension::Three));
    assert_eq!(centre(&whole, BLUE).1, 0);
    let ((red, matrix), (blue, core)) = (centre(&open, RED), centre(&open, BLUE));
    // Of the section a quarter; the other faces that are seen are all matrix.
    assert!(core > 1000 && (3 * core..10 * core).contains(&matrix), "{core} and {matrix}");
    assert!((blue[0] - red[0]).hypot(blue[1] - red[1]) < 60.0, "{blue:?} in {red:?}");
    // Colours belong to tags, whichever of them are seen, also without names.
    let bare = |cut: Option<&MeshCut>| {
        let skin = skin(&mesh, cut);
        SimplexLook::default().panel(Posed { skin: &skin, displacement: &zero }, &Paint::Tags, None).colouring
    };
    let (Colouring::Plain(alone), Colouring::Category { legend, .. }) = (bare(None), bare(Some(&cut))) else {
        unreachable!("one tag is seen of the whole, two of the part");
    };
    assert_eq!((Some(alone), legend[1].name.as_str()), (legend[0].colour, "tag 2"));
    assert_ne!(legend[0].colour, legend[1].colour);
}

#[test]
fn plane_meshes_lie_as_in_a_drawing_with_x_to_the_right_and_y_up() {
    let mesh = unit_mesh(Dimension::Two, 8).tagged(|x| if x[0] < 0.5 || x[1] < 0.5 { 1 } else { 2 });
    let skin = skin(&mesh, None);
    let image =
        draw(look().panel(Posed { skin: &skin, displacement: &still(&mesh) }, &Paint::Tags, None), Dimension::Two);
    let ((red, first), (blue, second)) = (centre(&image, RED), centre(&image, BLUE));
    assert!(red[0] < blue[0] && red[1] > blue[1], "{red:?} and {blue:?}");
    assert!(first > 10_000 && first.abs_diff(3 * second) < first / 20, "{first} and {second}");
    // Nothing lies in the margin.
    let page = image.pixel(0, 0);
    for y in 0..image.height() {
        assert!((0..8).chain(image.width() - 8..image.width()).all(|x| image.pixel(x, y) == page), "row {y}");
    }
}

#[test]
fn values_take_the_colours_of_their_cells_and_nodes() {
    let mesh = unit_mesh(Dimension::Two, 4);
    let skin = skin(&mesh, None);
    let zero = still(&mesh);
    let body = Posed { skin: &skin, displacement: &zero };
    let by_node: Vec<f64> = mesh.nodes().iter().map(|x| x[0]).collect();
    let by_cell: Vec<f64> = (0..mesh.cell_count()).map(|cell| mesh.centre(cell)[0]).collect();
    let scale = ColourScale { label: "x [m]".into(), ..ColourScale::default() };
    for paint in [Paint::Nodes(&by_node, scale.clone()), Paint::Cells(&by_cell, scale)] {
        let image = draw(look().panel(body, &paint, None), Dimension::Two);
        let row: Vec<Rgb> = (0..image.width()).filter_map(|x| image.pixel(x, image.height() / 3)).collect();
        let yellow = row.iter().position(|p| p[0] > 170 && p[2] < 100);
        let violet = row.iter().position(|p| p[0] < 90 && p[1] < 60 && p[2] > 60);
        assert!(violet.is_some() && violet < yellow, "{paint:?}: {violet:?} {yellow:?}");
    }
}

#[test]
fn a_coarse_mesh_is_drawn_over_the_body_and_the_outline_behind_it() {
    let (fine, coarse) = (unit_mesh(Dimension::Two, 32), unit_mesh(Dimension::Two, 2));
    let skins = [&fine, &coarse].map(|mesh| skin(mesh, None));
    let stretched = |mesh| displacement(mesh, |x| [0.2 * x[0], 0.0, 0.0]);
    let moved = [stretched(&fine), stretched(&coarse)];
    let [body, wires] = [0, 1].map(|n| Posed { skin: &skins[n], displacement: &moved[n] });
    let panel = |look: SimplexLook, wires| look.panel(body, &Paint::Plain(RED), wires);
    let (bare, drawn) = (panel(look(), None), panel(look(), Some(wires)));
    assert_eq!((drawn.wires.quads.len(), bare.ghost.len()), (8, 128));
    let ghost = bare.ghost.as_flattened();
    assert!(ghost.iter().all(|p| p[0] <= 1.0) && drawn.wires.positions.iter().any(|p| p[0] == 1.2));
    let plain = SimplexLook { ghost: false, scale: 2.0, ..look() };
    let doubled = panel(plain, Some(wires));
    assert!(doubled.ghost.is_empty() && doubled.wires.positions.iter().any(|p| p[0] == 1.4));
    let [bare, drawn] = [bare, drawn].map(|panel| draw(panel, Dimension::Two));
    let row =
        |image: &Image| -> Vec<Rgb> { (0..image.width()).filter_map(|x| image.pixel(x, image.height() / 3)).collect() };
    let dark: Vec<usize> = row(&bare)
        .iter()
        .zip(row(&drawn))
        .enumerate()
        .filter(|(_, (a, b))| a[0].saturating_sub(b[0]) > 15)
        .map(|(x, _)| x)
        .collect();
    // Both sides, the middle and a diagonal on either side of it.
    assert_eq!(dark.chunk_by(|a, b| b - a == 1).count(), 5, "{dark:?}");
}

#[test]
fn harmonic_displacements_stand_in_the_order_of_the_paper() {
    // With C = 1 these are the harmonic displacements: h_αβ = σ_αβ x.
    let pairs = |dimension| match dimension {
        Dimension::Two => vec![(0, 0), (1, 1), (0, 1)],
        _ => vec![(0, 0), (1, 1), (2, 2), (1, 2), (0, 2), (0, 1)],
    };
    for (dimension, captions) in
        [(Dimension::Two, &["h₁₁", "h₂₂", "h₁₂"][..]), (Dimension::Three, &["h₁₁", "h₂₂", "h₃₃", "h₁₂", "h₂₃", "h₁₃"])]
    {
        let mesh = unit_mesh(dimension, 2);
        let field = |x: &[f64; 3]| {
            let mut field = [[0.0; 6]; 3];
            for (n, (a, b)) in pairs(dimension).into_iter().enumerate() {
                field[a][n] += 0.5e-6 * x[b];
                field[b][n] += 0.5e-6 * x[a];
            }
            field
        };
        let fields = HarmonicDisplacements { fields: mesh.nodes().iter().map(field).collect() };
        let skin = skin(&mesh, None);
        let panels = harmonic_panels(&skin, &fields, None, &look());
        assert_eq!(panels.iter().map(|p| p.caption.as_str()).collect::<Vec<_>>(), captions);
        assert_eq!(panels[0].detail, "under a stress σ₁₁ of 150 kPa");
        for panel in panels {
            let [a, b] = [1, 2].map(|n| panel.caption.chars().nth(n).unwrap() as usize - '₁' as usize);
            for (x, moved) in skin.rest().iter().zip(&panel.surface.positions) {
                let mut expected = *x;
                expected[a] += 0.075 * x[b];
                expected[b] += 0.075 * x[a];
                assert!((0..3).all(|r| (moved[r] - expected[r]).abs() < 1e-14), "{}: {moved:?}", panel.caption);
            }
        }
        let far = harmonic_panels(&skin, &fields, Some(2e6), &look()).remove(0);
        assert!(far.detail.ends_with("2 MPa") && far.surface.positions.iter().any(|p| p[0] == 3.0));
    }
}

/// Width, height and number of frames of a PNG.
fn header(path: &Path) -> (u32, u32, u32) {
    let reader = png::Decoder::new(std::io::Cursor::new(fs::read(path).unwrap())).read_info().unwrap();
    let info = reader.info();
    (info.width, info.height, info.animation_control().map_or(1, |c| c.num_frames))
}

/// Two runs of a bar that bends, the second with its coarse mesh.
fn film(dimension: Dimension) -> SimplexFilm {
    let around = BoundingBox { lower: [0.0; 3], upper: [0.4, 0.1, 0.1] };
    let lattice =
        |n| SimplexLattice { dimension, boxes: [4 * n, n, n], around, cut: BoxCut::Alternating }.mesh().unwrap();
    let meshes = [lattice(4).tagged(|x| if x[0] < 0.2 { 1 } else { 2 }), lattice(1)];
    let skins = [0, 1].map(|n| skin(&meshes[n], None));
    let (materials, ground) = (look().materials, (dimension == Dimension::Three).then_some(-0.1));
    let mut film =
        SimplexFilm::new("A bar", &["fine", "coarse"], FilmOptions { materials, ground, ..FilmOptions::default() });
    let axis = dimension.axes() - 1;
    for step in 0..8 {
        let bent = |mesh, sag: f64| {
            displacement(mesh, |x| std::array::from_fn(|r| if r == axis { -sag * (x[0] / 0.4).powi(2) } else { 0.0 }))
        };
        let (time, sag) = (0.05 * f64::from(step), 0.01 * f64::from(step));
        let (u, v, w) = (bent(&meshes[0], sag), bent(&meshes[0], 0.9 * sag), bent(&meshes[1], 0.9 * sag));
        film.record(0, time, Posed { skin: &skins[0], displacement: &u }, None);
        let wires = Posed { skin: &skins[1], displacement: &w };
        film.record(1, time, Posed { skin: &skins[0], displacement: &v }, Some(wires));
        film.set_note(1, format!("error {:.1} %", 100.0 * sag));
    }
    film
}

#[test]
fn a_film_of_two_meshes_becomes_a_strip_and_an_animation() {
    for dimension in [Dimension::Two, Dimension::Three] {
        let folder = tempdir().unwrap();
        let path = |name: &str| folder.path().join(name);
        let first = film(dimension);
        first.write_strip(&path("strip.png"), 4).unwrap();
        first.write_animation(&path("film.png")).unwrap();
        assert_eq!((header(&path("strip.png")).0, header(&path("strip.png")).2), (1800, 1));
        assert_eq!((header(&path("film.png")).0, header(&path("film.png")).2), (900, 8));
        film(dimension).write_strip(&path("again.png"), 4).unwrap();
        assert!(
            fs::read(path("strip.png")).unwrap() == fs::read(path("again.png")).unwrap(),
            "{dimension}: not the same"
        );
        assert_eq!(fs::read_dir(folder.path()).unwrap().count(), 3, "no half-written file stays");
    }
}

#[test]
fn the_frames_of_a_plane_film_show_where_the_bar_is() {
    let folder = tempdir().unwrap();
    let strip = folder.path().join("strip.png");
    film(Dimension::Two).write_strip(&strip, 2).unwrap();
    let mut reader = png::Decoder::new(std::io::Cursor::new(fs::read(&strip).unwrap())).read_info().unwrap();
    let mut bytes = vec![0; reader.output_buffer_size().unwrap()];
    reader.next_frame(&mut bytes).unwrap();
    let (width, height) = (reader.info().width as usize, reader.info().height as usize);
    let samples = bytes.len() / (width * height);
    let pixel = |x: usize, y: usize| std::array::from_fn(|c| bytes[samples * (y * width + x) + c]);
    assert!(samples >= 3, "a colour per pixel");
    // Mean height of the stiff half in the upper row of pictures: it sinks from the first time to the last, and lies right of the soft half.
    let mean = |columns: std::ops::Range<usize>, colour: Rgb| {
        let all = (0..height / 2).flat_map(|y| columns.clone().map(move |x| [x as f64, y as f64]));
        let like: Vec<[f64; 2]> = all.filter(|p| is_like(pixel(p[0] as usize, p[1] as usize), colour)).collect();
        assert!(like.len() > 2000, "{} pixels like {colour:?}", like.len());
        [0, 1].map(|r| like.iter().map(|p| p[r]).sum::<f64>() / like.len() as f64)
    };
    let (left, right) = (0..width / 2, width / 2..width);
    assert!(mean(right, BLUE)[1] > mean(left.clone(), BLUE)[1] + 30.0);
    let [red, blue] = [RED, BLUE].map(|colour| mean(left.clone(), colour));
    assert!(blue[0] > red[0] + 100.0 && (blue[1] - red[1]).abs() < 2.0, "{red:?} {blue:?}");
}
