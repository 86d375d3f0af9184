//! What strips and animations promise.

use grosgrain_picture::{
    Animation, Category, Colouring, Image, Panel, PictureError, QuadSurface, Rgb, Sheet, SheetPicture, Strip, View,
};

const RED: Rgb = [220, 40, 40];
const FRONT: View = View { toward: [0.0, 1.0, 0.0], up: [0.0, 0.0, 1.0], perspective: 0.0 };

/// A square of side 1 in the plane y = 0, moved by `x`.
fn square(x: f64, side: f64) -> Option<Panel> {
    let positions = vec![[x, 0.0, 0.0], [x + side, 0.0, 0.0], [x + side, 0.0, side], [x, 0.0, side]];
    let legend = vec![Category { name: "iron".into(), colour: Some(RED) }];
    let surface = QuadSurface { positions, quads: vec![[0, 1, 2, 3]] };
    Some(Panel { surface, colouring: Colouring::Category { of_quad: vec![0], legend }, ..Panel::default() })
}

fn strip(rows: usize, panels: Vec<Option<Panel>>) -> Strip {
    let columns = panels.len() / rows;
    Strip {
        rows: (0..rows).map(|r| format!("row {r}")).collect(),
        columns: (0..columns).map(|c| format!("{c} s")).collect(),
        panels,
        view: Some(FRONT),
        width: 900,
        ..Strip::default()
    }
}

/// Boxes of connected columns with many red pixels within some rows: first and last column.
fn red_runs(image: &Image, rows: std::ops::Range<usize>) -> Vec<[usize; 2]> {
    let is_red = |x: usize, y: usize| image.pixel(x, y).is_some_and(|[r, g, _]| r > 120 && g < 90);
    let columns: Vec<usize> =
        (0..image.width()).filter(|x| rows.clone().filter(|y| is_red(*x, *y)).count() > 30).collect();
    columns.chunk_by(|a, b| b - a == 1).map(|run| [run[0], run[run.len() - 1]]).collect()
}

#[test]
fn panels_share_camera_and_scale() -> Result<(), PictureError> {
    let image = strip(1, vec![square(0.0, 1.0), square(1.0, 1.0), square(0.0, 0.5)]).render()?;
    let runs = red_runs(&image, 0..image.height() - 40);
    assert_eq!((image.width(), runs.len()), (900, 3), "{runs:?}");
    let width = |run: [usize; 2]| (run[1] - run[0]) as f64;
    assert!((width(runs[1]) - width(runs[0])).abs() <= 2.0, "{runs:?}");
    assert!((width(runs[2]) - 0.5 * width(runs[0])).abs() <= 3.0, "{runs:?}");
    // The second square has moved by its own width within its panel.
    let pitch = (runs[2][0] - runs[0][0]) as f64 / 2.0;
    let shift = (runs[1][0] - runs[0][0]) as f64 - pitch;
    assert!((shift - width(runs[0])).abs() <= 4.0, "{runs:?}");
    Ok(())
}

#[test]
fn an_empty_place_stays_empty_and_rows_stand_below_each_other() -> Result<(), PictureError> {
    let image = strip(2, vec![square(0.0, 1.0), None, square(0.0, 1.0), square(0.0, 1.0)]).render()?;
    let middle = image.height() / 2;
    assert_eq!(red_runs(&image, 0..middle).len(), 1);
    assert_eq!(red_runs(&image, middle..image.height() - 40).len(), 2);
    Ok(())
}

#[test]
fn grids_that_do_not_fit_are_refused() {
    let refusal = |strip: Strip| strip.render().map_or_else(|e| e.to_string(), |_| "drawn".into());
    let mut wrong = strip(1, vec![square(0.0, 1.0)]);
    wrong.columns.push("1 s".into());
    assert_eq!(refusal(wrong), "1 pictures for 1 rows and 2 columns; one each is needed, and at least one");
    assert!(refusal(strip(1, vec![None])).starts_with("a camera needs finite points"));
    assert!(matches!(Sheet::default().render(), Err(PictureError::SheetCount { .. })));
}

fn frames(count: usize) -> Result<Vec<Image>, PictureError> {
    let camera = grosgrain_picture::Camera::new(Some(FRONT), &[[0.0; 3], [3.0, 0.0, 1.0]])?;
    let frame = |at: usize| {
        let panel = square(2.0 * at as f64 / count as f64, 1.0);
        Strip { camera: Some(camera.clone()), ..strip(1, vec![panel]) }.render()
    };
    (0..count).map(frame).collect()
}

/// The pixels of each frame, and how long each stands.
type Played = (Vec<Vec<Rgb>>, Vec<f64>);

/// The frames that a viewer shows, from a file by the rules of the APNG specification.
fn played(bytes: &[u8]) -> Result<Played, Box<dyn std::error::Error>> {
    let mut decoder = png::Decoder::new(std::io::Cursor::new(bytes));
    decoder.set_transformations(png::Transformations::EXPAND | png::Transformations::ALPHA);
    let mut reader = decoder.read_info()?;
    let (width, height) = (reader.info().width as usize, reader.info().height as usize);
    let control = reader.info().animation_control().ok_or("no animation")?;
    assert_eq!(control.num_plays, 0, "it plays for ever");
    let count = control.num_frames;
    let mut canvas = vec![[0; 3]; width * height];
    let (mut shown, mut times) = (Vec::new(), Vec::new());
    for _ in 0..count {
        let mut buffer = vec![0; reader.output_buffer_size().ok_or("too large")?];
        reader.next_frame(&mut buffer)?;
        let frame = *reader.info().frame_control().ok_or("no frame control")?;
        assert_eq!(frame.dispose_op, png::DisposeOp::None);
        let (w, x, y) = (frame.width as usize, frame.x_offset as usize, frame.y_offset as usize);
        for (at, pixel) in buffer[..4 * w * frame.height as usize].as_chunks::<4>().0.iter().enumerate() {
            if pixel[3] == 255 {
                canvas[(y + at / w) * width + x + at % w] = [pixel[0], pixel[1], pixel[2]];
            }
        }
        times.push(f64::from(frame.delay_num) / f64::from(frame.delay_den));
        shown.push(canvas.clone());
    }
    Ok((shown, times))
}

#[test]
fn an_animation_plays_its_frames() -> Result<(), Box<dyn std::error::Error>> {
    let frames = frames(6)?;
    let mut bytes = Vec::new();
    Animation { frames: &frames, delay: 0.05, hold: 1.5 }.write_apng(&mut bytes)?;
    let (shown, times) = played(&bytes)?;
    assert_eq!(times, [0.05, 0.05, 0.05, 0.05, 0.05, 1.5]);
    for (at, (frame, shown)) in frames.iter().zip(&shown).enumerate() {
        let exact = |i: usize| frame.pixel(i % frame.width(), i / frame.width()).unwrap_or_default();
        let far = |i: &usize| (0..3).any(|c| exact(*i)[c].abs_diff(shown[*i][c]) > 12);
        assert_eq!((0..shown.len()).filter(far).count(), 0, "frame {at}");
    }
    let mut stills = 0;
    for frame in &frames {
        let mut still = Vec::new();
        frame.write_png(&mut still)?;
        stills += still.len();
    }
    assert!(bytes.len() < stills / 2, "{} bytes, as stills {stills}", bytes.len());
    Ok(())
}

#[test]
fn frames_that_do_not_fit_are_refused() -> Result<(), PictureError> {
    let frames = frames(2)?;
    let mut other = frames.clone();
    other[1] = Sheet {
        rows: vec![String::new()],
        columns: vec![String::new()],
        pictures: vec![SheetPicture { image: Some(frames[0].clone()), note: "n".into() }],
        ..Sheet::default()
    }
    .render()?;
    let refusal = |animation: Animation| {
        animation.write_apng(&mut Vec::new()).map_or_else(|e| e.to_string(), |()| "written".into())
    };
    assert!(refusal(Animation { frames: &other, delay: 0.1, hold: 0.1 }).contains("draw all of them in one size"));
    assert!(refusal(Animation { frames: &frames, delay: 0.0, hold: 0.1 }).starts_with("a frame cannot stand for 0 s"));
    assert_eq!(
        refusal(Animation { frames: &[], delay: 0.1, hold: 0.1 }),
        "the animation has no frames; add at least one"
    );
    assert_eq!(refusal(Animation { frames: &frames[..1], delay: 0.1, hold: 0.1 }), "written");
    Ok(())
}
