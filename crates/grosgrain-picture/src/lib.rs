//! Software-rendered pictures of deformed voxel bodies, and charts of curves, as PNG.
//!
//! Volumes, such as CT, are drawn by ray casting ([`VolumeScene`]); a [`Strip`] shows bodies and a [`Sheet`] ready pictures in
//! rows and columns; an [`Animation`] is an animated PNG.
//!
//! No display, window system or graphics driver is needed, and the input is plain data: positions, quads and
//! numbers. A [`Figure`] shows panels side by side, all seen by the same camera at the same scale; a [`Chart`] shows
//! curves. Both give an [`Image`], which writes itself as PNG. The same input gives the same bytes.
//!
//! ```
//! use grosgrain_picture::{Figure, Panel, QuadSurface};
//! let positions = vec![[0.0, 0.0, 0.0], [1.0, 0.0, 0.0], [1.0, 1.0, 0.1], [0.0, 1.0, 0.0]];
//! let surface = QuadSurface { positions, quads: vec![[0, 1, 2, 3]] };
//! let figure = Figure { panels: vec![Panel { caption: "A sheet".into(), surface, ..Panel::default() }], ..Figure::default() };
//! let mut png = Vec::new();
//! figure.render()?.write_png(&mut png)?;
//! # Ok::<(), grosgrain_picture::PictureError>(())
//! ```

mod animation;
mod body;
mod camera;
mod chart;
mod colour;
mod error;
mod figure;
mod image;
mod key;
mod layout;
mod occlusion;
mod palette;
mod raster;
mod sheet;
mod strip;
mod surface;
mod text;
mod theme;
mod ticks;
mod volume;

pub use animation::Animation;
pub use camera::{Camera, View};
pub use chart::{Axis, Chart, Event, Series};
pub use colour::{ColourMap, Rgb, category_colour};
pub use error::PictureError;
pub use figure::{Category, ColourScale, Colouring, Figure, Lines, Panel, QuadSurface};
pub use image::Image;
pub use sheet::{Sheet, SheetPicture};
pub use strip::Strip;
pub use ticks::Ticks;
pub use volume::{ClipPlane, TransferFunction, TransferNode, VolumeScene};
