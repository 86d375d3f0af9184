//! Films of runs, and the scan of a deformed and cut body.

use std::fs;
use std::path::Path;

use grosgrain::fine::FineModel;
use grosgrain::io::read_volume;
use grosgrain::material::{Elasticity, IsotropicMaterial, Material, MaterialTable};
use grosgrain::mesh::{Label, Node, Volume, VoxelGrid, pad_to_multiple};
use grosgrain_cli::deformed_volume::{DeformedScan, ScannedBody, write_scan};
use grosgrain_cli::film::{Film, FilmOptions, ScanFilm, ScanLook};
use tempfile::tempdir;

fn model(grid: VoxelGrid) -> FineModel {
    let material =
        |young| Material::linear("m", Elasticity::Isotropic(IsotropicMaterial::new(young, 0.3).unwrap()), 1.0);
    let mut table = MaterialTable::new();
    table.insert(Label(1), material(1e6));
    table.insert(Label(2), material(1e8));
    FineModel::new(grid, &table).unwrap()
}

fn beam() -> VoxelGrid {
    let mut grid = VoxelGrid::uniform([16, 4, 4], [0.01; 3], Label(1));
    (0..grid.labels.len()).filter(|c| c / 16 % 2 == 0).for_each(|c| grid.labels[c] = Label(2));
    grid
}

/// Bent downwards by `sag` at the end.
fn bent(model: &FineModel, sag: f64) -> Vec<f64> {
    let lattice = model.grid().lattice;
    let u = |n: usize| {
        let x = model.node_position(Node(n))[0] / 0.16;
        [0.0, 0.0, -sag * x * x]
    };
    (0..lattice.node_count()).flat_map(u).collect()
}

/// Width, height and number of frames of a PNG.
fn header(path: &Path) -> (u32, u32, u32) {
    let reader = png::Decoder::new(std::io::Cursor::new(fs::read(path).unwrap())).read_info().unwrap();
    let info = reader.info();
    (info.width, info.height, info.animation_control().map_or(1, |c| c.num_frames))
}

#[test]
fn a_film_of_two_runs_with_a_cut_becomes_a_strip_and_an_animation() {
    let folder = tempdir().unwrap();
    let whole = model(beam());
    let mut cut = beam();
    (0..cut.void.len()).filter(|c| c % 16 == 8 && c / 64 > 0).for_each(|c| cut.void[c] = true);
    let cut = model(cut);
    let options = FilmOptions { ground: Some(-0.06), footer: vec!["To scale.".into()], ..FilmOptions::default() };
    let mut film = Film::new("A beam is cut", &["fine", "coarse"], options);
    for step in 0..12 {
        let model = if step < 6 { &whole } else { &cut };
        let sag = 0.004 * f64::from(step);
        film.record(0, 0.02 * f64::from(step), model, &bent(model, sag));
        film.record(1, 0.02 * f64::from(step), model, &bent(model, 0.9 * sag));
        film.set_note(1, format!("error {:.1} %", 10.0 * sag));
    }
    let (strip, animation) = (folder.path().join("strip.png"), folder.path().join("film.png"));
    film.write_strip(&strip, 4).unwrap();
    film.write_animation(&animation).unwrap();
    assert_eq!((header(&strip).0, header(&strip).2), (1800, 1));
    assert_eq!((header(&animation).0, header(&animation).2), (900, 12));
    assert_eq!(fs::read_dir(folder.path()).unwrap().count(), 2, "no half-written file stays");
    assert!(fs::metadata(&animation).unwrap().len() < 600_000);
}

#[test]
fn a_film_without_frames_is_refused_with_a_sentence() {
    let film = Film::new("nothing", &["fine"], FilmOptions::default());
    let refusal = film.write_strip(Path::new("never.png"), 3).map_or_else(|e| e.to_string(), |_| "written".into());
    assert_eq!(refusal, "never.png: a camera needs finite points to look at; there are none");
    assert!(film.write_animation(Path::new("never.png")).is_err() && !Path::new("never.png").exists());
}

/// A scan whose values are a linear function of the voxel: 10 i + 100 j + 1000 k, of 2 mm and turned axes.
fn scan() -> Volume {
    let cells = [12, 8, 8];
    let value = |c: usize| (10 * (c % 12) + 100 * (c / 12 % 8) + 1000 * (c / 96)) as f64;
    let voxel_to_world =
        Some([[0.0, -2.0, 0.0, 40.0], [2.0, 0.0, 0.0, -10.0], [0.0, 0.0, 2.0, 5.0], [0.0, 0.0, 0.0, 1.0]]);
    Volume { cells, spacing: Some([0.002; 3]), voxel_to_world, values: (0..768).map(value).collect(), integral: true }
}

/// A body of 4 mm cells on the scan, padded to a multiple of four, with two cells cut away.
fn scanned() -> (ScannedBody, FineModel) {
    let grid = VoxelGrid::uniform([6, 4, 4], [0.004; 3], Label(1));
    let mut grid = pad_to_multiple(&grid, 4, Label(-1)).grid;
    assert_eq!(grid.lattice.cells, [8, 4, 4]);
    let body = ScannedBody::from_scan(&scan(), &grid, [6, 4, 4]).unwrap();
    for at in [[5, 3, 3], [4, 3, 3]] {
        let cell = grid.lattice.cell(at);
        grid.void[cell.0] = true;
    }
    (body, model(grid))
}

fn value_at(scan: &DeformedScan, at: [usize; 3]) -> f32 {
    scan.samples[at[0] + scan.size[0] * (at[1] + scan.size[1] * at[2])]
}

#[test]
fn an_undeformed_scan_is_the_scan_where_the_body_is_and_air_where_it_was_cut() {
    let (body, model) = scanned();
    let still = vec![0.0; 3 * model.grid().lattice.node_count()];
    let found = body.deformed(&model, &still).unwrap();
    let source = scan();
    // The skin of the padding adds a layer of air at the end of x.
    let offset: [isize; 3] = std::array::from_fn(|a| ((found.origin[a] / 0.002) - 0.5).round() as isize);
    assert_eq!((offset, found.spacing), ([0; 3], [0.002; 3]));
    assert_eq!(found.voxel_to_world, source.voxel_to_world);
    let (mut same, mut cut) = (0, 0);
    for c in 0..source.values.len() {
        let at = [c % 12, c / 12 % 8, c / 96];
        let cell = model.grid().lattice.cell(at.map(|i| i / 2));
        match model.is_void(cell) {
            true => {
                assert_eq!(value_at(&found, at), 0.0, "{at:?} was cut away");
                cut += 1;
            }
            false => {
                assert!((f64::from(value_at(&found, at)) - source.values[c]).abs() < 1e-2, "{at:?}");
                same += 1;
            }
        }
    }
    assert_eq!((same, cut), (768 - 16, 16));
}

#[test]
fn what_moved_is_found_in_the_world_where_it_went() {
    let folder = tempdir().unwrap();
    let (body, model) = scanned();
    // By three voxels of the scan along x, and one and a half against z.
    let shift = [0.006, 0.0, -0.003];
    let moved: Vec<f64> = (0..3 * model.grid().lattice.node_count()).map(|i| shift[i % 3]).collect();
    let found = body.deformed(&model, &moved).unwrap();
    write_scan(&found, folder.path()).unwrap();
    let source = scan();
    for file in ["deformed-scan.nii.gz", "deformed-scan.nrrd"] {
        let read = read_volume(folder.path().join(file)).unwrap();
        assert_eq!(read.cells, found.size, "{file}");
        let spacing = read.spacing.unwrap();
        assert!((0..3).all(|a| (spacing[a] - 0.002).abs() < 1e-8), "{file}: {spacing:?}");
        let (old, new) = (source.voxel_to_world.unwrap(), read.voxel_to_world.unwrap());
        let mut checked = 0;
        for c in (0..read.values.len()).filter(|c| read.values[*c] != 0.0) {
            let at = [c % read.cells[0], c / read.cells[0] % read.cells[1], c / (read.cells[0] * read.cells[1])];
            let world: [f64; 3] =
                std::array::from_fn(|r| (0..3).map(|a| new[r][a] * at[a] as f64).sum::<f64>() + new[r][3]);
            // Back by the shift, which the scan's axes turn: x of the body is y of the world, y is −x, all in millimetres.
            let back = [world[0], world[1] - 6.0, world[2] + 3.0];
            let index = [(back[1] - old[1][3]) / 2.0, (old[0][3] - back[0]) / 2.0, (back[2] - old[2][3]) / 2.0];
            // Centres of the source's outer voxels are the ends of what is linear.
            if (0..3).all(|a| index[a] >= 0.0 && index[a] <= source.cells[a] as f64 - 1.0) {
                let exact = 10.0 * index[0] + 100.0 * index[1] + 1000.0 * index[2];
                assert!((read.values[c] - exact).abs() < 0.51, "{file} {at:?}: {} for {exact}", read.values[c]);
                checked += 1;
            }
        }
        assert!(checked > 500, "{file}: {checked} voxels");
    }
}

#[test]
fn a_scan_film_is_a_strip_and_an_animation() {
    let folder = tempdir().unwrap();
    let (body, model) = scanned();
    let look = ScanLook { picture: [160, 140], ..ScanLook::default() };
    let room = [[-0.01; 3], [0.04, 0.03, 0.03]];
    let mut film = ScanFilm::new("A scan", &["fine"], look, room).unwrap();
    for step in 0..5 {
        let moved: Vec<f64> =
            (0..model.grid().lattice.node_count()).flat_map(|_| [0.002 * f64::from(step), 0.0, 0.0]).collect();
        film.record(0, 0.1 * f64::from(step), &body.deformed(&model, &moved).unwrap()).unwrap();
    }
    let (strip, animation) = (folder.path().join("strip.png"), folder.path().join("film.png"));
    film.write_strip(&strip, 3).unwrap();
    film.write_animation(&animation).unwrap();
    assert!(header(&strip).0 > 480 && header(&animation).2 == 5);
}
