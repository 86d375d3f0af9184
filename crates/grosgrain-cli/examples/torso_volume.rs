//! A CT of a torso as volume renderings: through the skin, and cut open.
//!
//! ```sh
//! cargo run --release -p grosgrain-cli --example torso_volume -- data/ct_torso/example_ct.nii.gz out
//! ```
//!
//! writes `out/torso.png`, `out/torso-cut.png` and `out/torso-sheet.png`.

use grosgrain::io::read_volume;
use grosgrain::mesh::{Cell, Label, LabelRule, Neighbourhood, keep_largest, label_by_rules};
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
    Ok(())
}

fn draw(scene: &VolumeScene, path: &Path) -> Result<Image, Box<dyn Error>> {
    let start = Instant::now();
    let image = scene.render()?;
    println!("{}: {:.2} s", path.display(), start.elapsed().as_secs_f64());
    image.write_png(File::create(path)?)?;
    Ok(image)
}
