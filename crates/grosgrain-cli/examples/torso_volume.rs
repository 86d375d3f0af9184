//! A CT of a torso as volume renderings: through the skin, and cut open.
//!
//! ```sh
//! cargo run --release -p grosgrain-cli --example torso_volume -- data/ct_torso/example_ct.nii.gz out
//! ```
//!
//! writes `out/torso.png`, `out/torso-cut.png`, and the scan bent by a given displacement, before and after a cut, as
//! `out/torso-film.png` and `out/torso-film-animated.png`; the cells of the body in the same motion as `out/cells-film.png` and
//! `out/cells-film-animated.png`.

use grosgrain::fine::FineModel;
use grosgrain::io::read_volume;
use grosgrain::material::{Elasticity, IsotropicMaterial, Material, MaterialTable};
use grosgrain::mesh::{
    Cell, Label, LabelRule, Neighbourhood, Node, Volume, VoxelGrid, keep_largest, label_by_rules, resample,
};
use grosgrain_cli::deformed_volume::ScannedBody;
use grosgrain_cli::film::{Film, FilmOptions, ScanFilm, ScanLook};
use grosgrain_picture::{ClipPlane, Image, TransferFunction, View, VolumeScene};
use std::{error::Error, fs::File, path::Path, time::Instant};

fn main() -> Result<(), Box<dyn Error>> {
    let mut arguments = std::env::args().skip(1);
    let (Some(scan), Some(folder)) = (arguments.next(), arguments.next()) else {
        return Err("two arguments are needed: the scan and the folder for the pictures".into());
    };
    let folder = Path::new(&folder);
    std::fs::create_dir_all(folder)?;
    let volume = read_volume(&scan)?;
    let spacing = volume.spacing.ok_or("the scan has no voxel spacing")?;
    // The table and the arms go: only the largest connected part stays.
    let air = LabelRule { label: Label(0), below: Some(-300.0), values: None, void: true };
    let rules = [air, LabelRule { label: Label(1), below: None, values: None, void: false }];
    let mut body = label_by_rules(&volume, &rules, spacing)?;
    keep_largest(&mut body);
    let mut near: Vec<bool> = body.void.iter().map(|void| !void).collect();
    for cell in (0..near.len()).map(Cell).filter(|c| !body.void[c.0]) {
        // Voxels at the skin are partly air; without them the skin would have steps.
        Neighbourhood::Nodes.for_each(&body.lattice, cell, |neighbour| near[neighbour.0] = true);
    }
    let kept = |(value, near): (&f64, &bool)| if *near { *value as f32 } else { -1000.0 };
    let samples: Vec<f32> = volume.values.iter().zip(&near).map(kept).collect();
    let view = View { toward: [-0.45, -0.85, -0.18], up: [0.0, 0.0, 1.0], perspective: 0.2 };
    let scene =
        |transfer| VolumeScene { view: Some(view), ..VolumeScene::new(&samples, volume.cells, spacing, transfer) };
    draw(&scene(TransferFunction::ct()), &folder.join("torso.png"))?;
    let middle: [f64; 3] = std::array::from_fn(|a| 0.5 * spacing[a] * volume.cells[a] as f64);
    let plane = ClipPlane { point: middle, normal: [0.0, 1.0, 0.0] };
    let cut = VolumeScene { clip_planes: vec![plane], ..scene(TransferFunction::ct_opaque()) };
    draw(&cut, &folder.join("torso-cut.png"))?;
    let scan = Volume { values: samples.iter().map(|v| f64::from(*v)).collect(), ..volume };
    films(&scan, &body, view, folder)
}

/// The body on cells of about 9 mm leans to the side and is cut.
fn films(scan: &Volume, body: &VoxelGrid, view: View, folder: &Path) -> Result<(), Box<dyn Error>> {
    let cells = scan.cells.map(|n| n / 3);
    let mut grid = resample(body, cells, &[])?;
    keep_largest(&mut grid);
    let scanned = ScannedBody::from_scan(scan, &grid, cells).ok_or("the scan is empty")?;
    let whole = model(grid.clone())?;
    for cell in (0..grid.void.len()).map(Cell) {
        let [x, y, z] = grid.lattice.cell_position(cell);
        grid.void[cell.0] |= z == cells[2] / 2 && y > cells[1] / 2 && x > cells[0] / 4 && x < 3 * cells[0] / 4;
    }
    let cut = model(grid.clone())?;
    let size: [f64; 3] = std::array::from_fn(|a| grid.spacing[a] * cells[a] as f64);
    let room = [[-0.02, 0.03, 0.0], [size[0] + 0.02, size[1] - 0.03, size[2] + 0.02]];
    let look = ScanLook { view: Some(view), ..ScanLook::default() };
    let mut film = ScanFilm::new("A torso leans and is cut", &["scan"], look, room)?;
    let options = FilmOptions { ground: Some(0.0), view: Some(view), ..FilmOptions::default() };
    let mut bodies = Film::new("A torso leans and is cut", &["fine", "half as far"], options);
    let steps = 24;
    for step in 0..=steps {
        let time = f64::from(step) / f64::from(steps);
        let model = if step < 12 { &whole } else { &cut };
        let lean = 0.09 * (std::f64::consts::TAU * time).sin();
        let gape = if step < 12 { 0.0 } else { 0.12 * (time - 0.5) };
        let half = leant(model, 0.5 * lean, gape, size);
        let displacement = leant(model, lean, gape, size);
        film.record(0, time, &scanned.deformed(model, &displacement)?)?;
        bodies.record(0, time, model, &displacement);
        bodies.record(1, time, model, &half);
        bodies.set_note(1, format!("off by {:.0} mm at the top", 500.0 * lean.abs()));
    }
    let start = Instant::now();
    film.write_strip(&folder.join("torso-film.png"), 5)?;
    film.write_animation(&folder.join("torso-film-animated.png"))?;
    bodies.write_strip(&folder.join("cells-film.png"), 5)?;
    bodies.write_animation(&folder.join("cells-film-animated.png"))?;
    println!("strips and animations: {:.2} s", start.elapsed().as_secs_f64());
    Ok(())
}

fn model(grid: VoxelGrid) -> Result<FineModel, Box<dyn Error>> {
    let mut table = MaterialTable::new();
    let elasticity = Elasticity::Isotropic(IsotropicMaterial::new(1e5, 0.4)?);
    table.insert(Label(1), Material::linear("tissue", elasticity, 1000.0));
    Ok(FineModel::new(grid, &table)?)
}

/// Leans along x by `lean` \[m\] at the top; the upper half rises by `gape` \[m\] towards the front.
fn leant(model: &FineModel, lean: f64, gape: f64, size: [f64; 3]) -> Vec<f64> {
    let of_node = |n: usize| {
        let [_, y, z] = model.node_position(Node(n));
        let (height, depth) = (z / size[2], y / size[1]);
        [lean * height * height, 0.0, if height > 0.5 { gape * depth } else { 0.0 }]
    };
    (0..model.grid().lattice.node_count()).flat_map(of_node).collect()
}

fn draw(scene: &VolumeScene, path: &Path) -> Result<Image, Box<dyn Error>> {
    let start = Instant::now();
    let image = scene.render()?;
    println!("{}: {:.2} s", path.display(), start.elapsed().as_secs_f64());
    image.write_png(File::create(path)?)?;
    Ok(image)
}
