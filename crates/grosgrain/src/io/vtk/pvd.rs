//! A time series of VTK files: `.pvd`.

use super::{VtkError, encoding::escape};
use std::io::Write;

/// A frame of a time series.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Frame<'a> {
    /// Time \[s\].
    pub time: f64,
    /// The frame's file, relative to the folder of the series file, with `/` between folders.
    pub file: &'a str,
}

/// Writes a time series. Nothing is written if a frame is refused.
///
/// # Errors
/// Times that are not finite or decrease, file names that are empty, absolute or use `\`, what the writer reports.
pub fn write_pvd<W: Write>(mut writer: W, frames: &[Frame]) -> Result<(), VtkError> {
    validate(frames)?;
    writeln!(writer, "<?xml version=\"1.0\"?>")?;
    writeln!(writer, "<VTKFile type=\"Collection\" version=\"0.1\" byte_order=\"LittleEndian\">\n<Collection>")?;
    for Frame { time, file } in frames {
        writeln!(writer, "<DataSet timestep=\"{time}\" group=\"\" part=\"0\" file=\"{}\"/>", escape(file))?;
    }
    writeln!(writer, "</Collection>\n</VTKFile>")?;
    Ok(writer.flush()?)
}

fn validate(frames: &[Frame]) -> Result<(), VtkError> {
    let mut before = f64::NEG_INFINITY;
    for (at, frame) in frames.iter().enumerate() {
        if !(frame.time.is_finite() && frame.time >= before) {
            return Err(VtkError::Time { frame: at, time: frame.time, before });
        }
        let drive = frame.file.as_bytes().get(1) == Some(&b':');
        if frame.file.is_empty() || frame.file.starts_with('/') || frame.file.contains('\\') || drive {
            return Err(VtkError::Path(frame.file.to_owned()));
        }
        before = frame.time;
    }
    Ok(())
}
