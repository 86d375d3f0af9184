//! Why a picture cannot be drawn.

/// Why a picture cannot be drawn or written.
#[derive(Debug, thiserror::Error)]
#[non_exhaustive]
pub enum PictureError {
    /// The figure has no panels.
    #[error("the figure has no panels; add at least one")]
    NoPanels,
    /// A panel's surface has no quads.
    #[error("panel {panel} (\"{caption}\") has no surface: 0 quads; leave the panel out or give it a body")]
    EmptySurface {
        /// Position of the panel in the figure.
        panel: usize,
        /// The panel's caption.
        caption: String,
    },
    /// A position or a value is NaN or infinite.
    #[error("panel {panel}: {what} {index} is {value}; only finite numbers can be drawn, check the solve that made it")]
    NotFinite {
        /// Position of the panel in the figure.
        panel: usize,
        /// What the number belongs to.
        what: &'static str,
        /// Index of the item.
        index: usize,
        /// The offending number.
        value: f64,
    },
    /// A quad names a vertex or a category that does not exist.
    #[error("panel {panel}: quad {quad} names {what} {index}, but there are only {count}")]
    Index {
        /// Position of the panel in the figure.
        panel: usize,
        /// Index of the quad.
        quad: usize,
        /// What is named.
        what: &'static str,
        /// The index named.
        index: u32,
        /// How many there are.
        count: usize,
    },
    /// A list has the wrong length.
    #[error("panel {panel}: {found} {what} for {expected} {per}; one each is needed")]
    Length {
        /// Position of the panel in the figure.
        panel: usize,
        /// What the list holds.
        what: &'static str,
        /// How many it holds.
        found: usize,
        /// How many it must hold.
        expected: usize,
        /// What one entry belongs to.
        per: &'static str,
    },
    /// A colour range is empty or not finite.
    #[error("panel {panel}: the colour range {low} to {high} is empty; give a lower and a larger upper end")]
    Range {
        /// Position of the panel in the figure.
        panel: usize,
        /// Lower end.
        low: f64,
        /// Upper end.
        high: f64,
    },
    /// The picture's width is out of bounds.
    #[error("a picture {0} pixels wide cannot be drawn; choose 400 to 4000 pixels")]
    Width(usize),
    /// The view has no direction.
    #[error(
        "the view direction {toward:?} with up {up:?} is not a view; both must be finite, nonzero and not parallel"
    )]
    View {
        /// From the eye to the body.
        toward: [f64; 3],
        /// The upward direction.
        up: [f64; 3],
    },
    /// A camera is fitted to nothing, or to a point that is not finite.
    #[error("a camera needs finite points to look at; {}", .0.map_or("there are none".into(), |i| format!("point {i} is not finite")))]
    CameraPoints(Option<usize>),
    /// The number of samples of a volume is not that of its voxels.
    #[error("the volume has {found} samples for {} x {} x {} voxels; one each is needed", size[0], size[1], size[2])]
    VolumeSize {
        /// Number of samples.
        found: usize,
        /// Number of voxels along x, y, z.
        size: [usize; 3],
    },
    /// A sample of a volume is NaN or infinite.
    #[error("sample {index} of the volume is {value}; only finite numbers can be drawn")]
    VolumeSample {
        /// Index of the sample.
        index: usize,
        /// The offending number.
        value: f32,
    },
    /// Spacing, step or rays of a volume are unusable.
    #[error(
        "the volume's spacing {spacing:?} m and the step of {step} voxels must be positive, places finite, and rays per pixel \
         and axis 1 to 8, not {rays}"
    )]
    VolumeSteps {
        /// Edges of a voxel.
        spacing: [f64; 3],
        /// Length of a step in voxels.
        step: f64,
        /// Rays per pixel and axis.
        rays: usize,
    },
    /// A picture of a volume is too small or too large.
    #[error("a picture of {width} x {height} pixels cannot be drawn; choose 16 to 4000 each")]
    VolumePicture {
        /// Width in pixels.
        width: usize,
        /// Height in pixels.
        height: usize,
    },
    /// The number of pictures on a sheet is not that of its places.
    #[error("{found} pictures for {rows} rows and {columns} columns; one each is needed, and at least one")]
    SheetCount {
        /// Number of rows.
        rows: usize,
        /// Number of columns.
        columns: usize,
        /// Number of pictures.
        found: usize,
    },
    /// Pictures that stand beside or follow each other differ in size.
    #[error(
        "pictures of {} x {} and {} x {} pixels cannot stand in one row or follow each other; draw all of them in one size",
        first[0], first[1], other[0], other[1]
    )]
    PictureSizes {
        /// Size of the first.
        first: [usize; 2],
        /// Size of the one that differs.
        other: [usize; 2],
    },
    /// Labels are too small or too large.
    #[error("letters of {0} pixels cannot be drawn; choose 8 to 100")]
    Letters(f32),
    /// An animation has no frames.
    #[error("the animation has no frames; add at least one")]
    NoFrames,
    /// A frame stands too short or too long.
    #[error("a frame cannot stand for {0} s; choose 0.01 to 60 s")]
    Delay(f64),
    /// The transfer function has no nodes.
    #[error("the transfer function has no nodes; give at least one value with its colour and extinction")]
    EmptyTransfer,
    /// A node of a transfer function is unusable.
    #[error(
        "node {index} of the transfer function (value {value}, extinction {extinction}/m): values must increase from node to \
         node, and extinctions be finite and not negative"
    )]
    TransferNode {
        /// Index of the node.
        index: usize,
        /// Its value.
        value: f64,
        /// Its extinction.
        extinction: f64,
    },
    /// A chart has nothing to draw.
    #[error("the chart \"{0}\" has no points")]
    EmptyChart(String),
    /// A point cannot be placed on its axes.
    #[error(
        "series \"{series}\", point {index} ({x}, {y}): coordinates must be finite, and positive on a logarithmic axis"
    )]
    ChartPoint {
        /// Name of the series.
        series: String,
        /// Index of the point.
        index: usize,
        /// Its abscissa.
        x: f64,
        /// Its ordinate.
        y: f64,
    },
    /// An event cannot be placed on its axis.
    #[error("event \"{label}\" at {at}: it must be at a finite place, and a positive one on a logarithmic axis")]
    ChartEvent {
        /// Label of the event.
        label: String,
        /// Where it is.
        at: f64,
    },
    /// The embedded typeface cannot be read.
    #[error("the embedded typeface cannot be read: {0}")]
    Font(#[from] ab_glyph::InvalidFont),
    /// The PNG could not be written.
    #[error("the PNG could not be written: {0}")]
    Png(#[from] png::EncodingError),
    /// The file could not be written.
    #[error("the picture could not be written: {0}")]
    Io(#[from] std::io::Error),
}
