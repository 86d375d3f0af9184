//! What a volume rendering promises: the closed form of slabs, the same picture with and without short cuts.

use grosgrain_picture::{
    Camera, ClipPlane, Image, PictureError, Rgb, TransferFunction, TransferNode, View, VolumeScene,
};

const FRONT: View = View { toward: [0.0, 1.0, 0.0], up: [0.0, 0.0, 1.0], perspective: 0.0 };
const SIZE: [usize; 3] = [40, 32, 36];

fn ramp(extinction: f64) -> TransferFunction {
    let node = |value, extinction| TransferNode { value, colour: [0; 3], extinction };
    TransferFunction { nodes: vec![node(0.0, 0.0), node(1.0, extinction)] }
}

fn scene(samples: &[f32], transfer: TransferFunction) -> VolumeScene<'_> {
    VolumeScene { view: Some(FRONT), width: 120, height: 90, ..VolumeScene::new(samples, SIZE, [0.01; 3], transfer) }
}

/// Linear light of a grey pixel.
fn linear(image: &Image, x: usize, y: usize) -> f64 {
    let c = f64::from(image.pixel(x, y).map_or(0, |p| p[0])) / 255.0;
    if c <= 0.04045 { c / 12.92 } else { ((c + 0.055) / 1.055).powf(2.4) }
}

/// Share of the background that shines through the middle: the difference between a white and a black one.
fn transmittance(scene: &VolumeScene) -> Result<f64, PictureError> {
    let black = VolumeScene { background: [0; 3], ..scene.clone() };
    Ok(linear(&scene.render()?, 60, 45) - linear(&black.render()?, 60, 45))
}

/// A ball of 1 with a soft rim in a corner of the volume, 0 elsewhere.
fn ball() -> Vec<f32> {
    let value = |n: usize| {
        let at = [n % SIZE[0], n / SIZE[0] % SIZE[1], n / (SIZE[0] * SIZE[1])];
        let square: f32 = at.iter().map(|i| (*i as f32 - 11.0).powi(2)).sum();
        (4.0 - 0.5 * square.sqrt()).clamp(0.0, 1.0)
    };
    (0..SIZE.iter().product()).map(value).collect()
}

#[test]
fn a_black_slab_lets_through_what_beer_and_lambert_say() -> Result<(), PictureError> {
    let samples = vec![1.0; SIZE.iter().product()];
    for step in [0.3, 0.5, 1.0] {
        // 31 intervals at full extinction, and one voxel on each side in which it rises linearly.
        let exact = (-4.0_f64 * (0.31 + 0.01)).exp();
        let found = transmittance(&VolumeScene { step, ..scene(&samples, ramp(4.0)) })?;
        // A step across the kink at a face errs by at most an eighth of it; one level of eight bits is 0.004 here.
        let bound = 0.004 + exact * 2.0 * (4.0 * 0.01 * step) / 8.0;
        assert!((found - exact).abs() < bound, "step {step}: {found} for {exact}");
    }
    Ok(())
}

#[test]
fn a_linear_rise_of_extinction_integrates_to_its_mean() -> Result<(), PictureError> {
    let samples: Vec<f32> =
        (0..SIZE.iter().product()).map(|n: usize| (n / SIZE[0] % SIZE[1]) as f32 / (SIZE[1] - 1) as f32).collect();
    let exact = (-6.0_f64 * (0.5 * 0.31 + 0.5 * 0.01)).exp();
    let found = transmittance(&scene(&samples, ramp(6.0)))?;
    assert!((found - exact).abs() < 0.004 + exact * 6.0 * 0.01 / 8.0, "{found} for {exact}");
    Ok(())
}

#[test]
fn leaping_over_empty_space_changes_no_pixel() -> Result<(), PictureError> {
    let samples = ball();
    for view in [None, Some(FRONT), Some(View { toward: [-0.3, 0.2, -0.9], up: [0.0, 1.0, 0.0], perspective: 0.4 })] {
        let leaping = VolumeScene { view, ..scene(&samples, TransferFunction::ct_like_ball()) };
        let walking = VolumeScene { skip_empty: false, ..leaping.clone() };
        assert!(leaping.render()? == walking.render()?);
    }
    Ok(())
}

/// A transfer function with colours, over the values of [`ball`].
trait Coloured {
    fn ct_like_ball() -> Self;
}

impl Coloured for TransferFunction {
    fn ct_like_ball() -> Self {
        let node = |value, colour, extinction| TransferNode { value, colour, extinction };
        Self {
            nodes: vec![node(0.2, [240, 60, 30], 0.0), node(0.5, [240, 60, 30], 20.0), node(1.0, [40, 60, 220], 90.0)],
        }
    }
}

#[test]
fn the_picture_does_not_depend_on_the_number_of_threads() -> Result<(), Box<dyn std::error::Error>> {
    let samples = ball();
    let scene = scene(&samples, TransferFunction::ct_like_ball());
    let one = rayon::ThreadPoolBuilder::new().num_threads(1).build()?.install(|| scene.render())?;
    let four = rayon::ThreadPoolBuilder::new().num_threads(4).build()?.install(|| scene.render())?;
    assert!(one == four);
    Ok(())
}

#[test]
fn a_clip_shows_the_inside() -> Result<(), PictureError> {
    let samples = ball();
    let node = |value, colour, extinction| TransferNode { value, colour, extinction };
    let transfer = TransferFunction {
        nodes: vec![
            node(0.2, [230, 30, 30], 0.0),
            node(0.3, [230, 30, 30], 5000.0),
            node(0.9, [230, 30, 30], 5000.0),
            node(0.95, [30, 30, 230], 5000.0),
        ],
    };
    let whole = scene(&samples, transfer);
    let camera = whole.fitted_camera()?;
    let plane = ClipPlane { point: [0.0, 0.115, 0.0], normal: [0.0, -2.0, 0.0] };
    let cut = VolumeScene { clip_planes: vec![plane], camera: Some(camera.clone()), ..whole.clone() };
    let boxed = VolumeScene { clip_box: Some([[0.0, 0.115, 0.0], [1.0; 3]]), camera: Some(camera), ..whole.clone() };
    let centre =
        |scene: &VolumeScene| -> Result<Rgb, PictureError> { Ok(scene.render()?.pixel(60, 45).unwrap_or_default()) };
    let [red, _, blue] = centre(&whole)?;
    assert!(red > 2 * blue, "the rim is red: {red} {blue}");
    for scene in [cut, boxed] {
        let [red, _, blue] = centre(&scene)?;
        assert!(blue > 2 * red, "the core is blue: {red} {blue}");
    }
    Ok(())
}

#[test]
fn a_shared_camera_shows_a_half_as_large_ball_half_as_large() -> Result<(), PictureError> {
    let samples = ball();
    let large = scene(&samples, ramp(3000.0));
    let small =
        VolumeScene { spacing: [0.005; 3], origin: [0.0025; 3], camera: Some(large.fitted_camera()?), ..large.clone() };
    let dark = |image: Image| {
        let rows = 0..image.height();
        let count = |y: usize| (0..image.width()).filter(|x| image.pixel(*x, y).is_some_and(|p| p[0] < 128)).count();
        rows.map(count).max().unwrap_or(0)
    };
    let (large, small) = (dark(large.render()?), dark(small.render()?));
    assert!(large > 30 && large.abs_diff(2 * small) <= 3, "{large} and {small} pixels");
    Ok(())
}

#[test]
fn what_cannot_be_drawn_is_refused_with_a_sentence() {
    let samples = ball();
    let good = scene(&samples, ramp(1.0));
    let refusal = |scene: VolumeScene| scene.render().map_or_else(|e| e.to_string(), |_| "drawn".into());
    assert_eq!(refusal(good.clone()), "drawn");
    let short = VolumeScene { size: [3; 3], ..good.clone() };
    assert_eq!(refusal(short), "the volume has 46080 samples for 3 x 3 x 3 voxels; one each is needed");
    assert!(refusal(VolumeScene { size: [usize::MAX; 3], ..good.clone() }).starts_with("the volume has"));
    assert!(refusal(VolumeScene { step: 0.0, ..good.clone() }).contains("step of 0 voxels"));
    assert!(refusal(VolumeScene { width: 0, ..good.clone() }).starts_with("a picture of 0 x 90"));
    assert!(refusal(VolumeScene { transfer: TransferFunction { nodes: vec![] }, ..good.clone() }).contains("no nodes"));
    let mut damaged = samples.clone();
    damaged[7] = f32::NAN;
    assert!(refusal(scene(&damaged, ramp(1.0))).starts_with("sample 7 of the volume is NaN"));
    assert!(matches!(Camera::new(None, &[]), Err(PictureError::CameraPoints(None))));
}
