//! The fields of an NRRD header that matter for a scalar volume.

use super::super::geometry::{self, Affine, Geometry, LPS_TO_RAS, norm, spacing_from_mm};
use super::super::read_error::excerpt;
use super::super::samples::{ByteOrder, SampleLayout, ScalarType};
use super::super::text_header::Fields;
use super::super::units::mm_per_unit;
use super::super::{ReadError, VolumeFormat};

/// How the voxels are written.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum Encoding {
    Raw,
    Text,
    Gzip,
}

/// What an NRRD header says about its voxels.
#[derive(Debug)]
pub(super) struct Header {
    extents: [u64; 3],
    /// Which file axes are x, y, z.
    axes: [usize; 3],
    scalar: ScalarType,
    order: ByteOrder,
    fields: Fields,
    pub encoding: Encoding,
    pub data_file: Option<String>,
    pub line_skip: usize,
    /// `None`: the voxels are the last bytes.
    pub byte_skip: Option<usize>,
}

impl Header {
    /// The header and the bytes after it.
    pub fn parse(bytes: &[u8]) -> Result<(Self, &[u8]), ReadError> {
        let (fields, rest) = split(bytes)?;
        let encoding = encoding(&fields)?;
        let (axes, extents) = spatial_axes(&fields)?;
        let scalar = scalar(&fields)?;
        let header = Self {
            extents,
            axes,
            scalar,
            order: order(&fields, scalar, encoding)?,
            data_file: data_file(&fields)?,
            line_skip: match fields.get(&["lineskip"]) {
                None => 0,
                Some(text) => parse_number(&fields, "line skip", text)?,
            },
            byte_skip: match fields.get(&["byteskip"]) {
                None => Some(0),
                Some("-1") if encoding == Encoding::Raw => None,
                Some(text) => Some(parse_number(&fields, "byte skip", text)?),
            },
            fields,
            encoding,
        };
        Ok((header, rest))
    }

    pub fn layout(&self) -> Result<SampleLayout, ReadError> {
        SampleLayout::new(self.extents, self.scalar, self.order)
    }

    pub fn geometry(&self, cells: [usize; 3]) -> Result<Geometry, ReadError> {
        if let Some(directions) = self.directions()? {
            return self.oriented(cells, directions);
        }
        let Some(text) = self.fields.get(&["spacings"]) else {
            return Ok(Geometry { cells, spacing: None, voxel_to_world: None });
        };
        let all: Vec<f64> = self.fields.numbers("spacings", text)?;
        let units = quoted(self.fields.get(&["units"]));
        let mut mm = [0.0; 3];
        for (a, &axis) in self.axes.iter().enumerate() {
            let spacing = all.get(axis).ok_or_else(|| self.error("spacings", text, "one number per axis"))?;
            mm[a] = spacing * self.mm_per_unit(units.get(axis))?;
        }
        Ok(Geometry { cells, spacing: Some(spacing_from_mm(mm, "spacings")?), voxel_to_world: None })
    }

    fn oriented(&self, cells: [usize; 3], directions: [[f64; 3]; 3]) -> Result<Geometry, ReadError> {
        let names = quoted(self.fields.get(&["spaceunits"]));
        let mut units = [1.0; 3];
        for (a, unit) in units.iter_mut().enumerate() {
            *unit = self.mm_per_unit(names.get(a))?;
        }
        let scaled = |v: [f64; 3]| -> [f64; 3] { std::array::from_fn(|a| v[a] * units[a]) };
        let directions = directions.map(scaled);
        let spacing = spacing_from_mm(directions.map(norm), "space directions")?;
        let origin = match self.fields.get(&["spaceorigin"]) {
            None => [0.0; 3],
            Some(text) => self.vector("space origin", text)?,
        };
        let world = self
            .mirror_to_ras()
            .map(|signs| -> Affine { geometry::mirrored(geometry::affine(directions, scaled(origin)), signs) });
        Ok(Geometry { cells, spacing: Some(spacing), voxel_to_world: world })
    }

    /// `space directions` of the three spatial axes.
    fn directions(&self) -> Result<Option<[[f64; 3]; 3]>, ReadError> {
        let Some(text) = self.fields.get(&["spacedirections"]) else { return Ok(None) };
        let all = vectors(text);
        let mut directions = [[0.0; 3]; 3];
        for (a, &axis) in self.axes.iter().enumerate() {
            let vector = all.get(axis).ok_or_else(|| self.error("space directions", text, "one vector per axis"))?;
            directions[a] = self.vector("space directions", vector)?;
        }
        Ok(Some(directions))
    }

    /// A vector `(x,y,z)`.
    fn vector(&self, field: &str, text: &str) -> Result<[f64; 3], ReadError> {
        let inner = text.trim().strip_prefix('(').and_then(|t| t.strip_suffix(')'));
        let numbers = inner.map(|t| t.split(',').map(|n| n.trim().parse::<f64>()).collect::<Result<Vec<_>, _>>());
        match numbers {
            Some(Ok(n)) if n.len() == 3 && n.iter().all(|v| v.is_finite()) => Ok([n[0], n[1], n[2]]),
            _ => Err(self.error(field, text, "vectors of three finite numbers, as in (1,0,0)")),
        }
    }

    /// Signs that turn the axes of `space` into RAS; `None` for a frame that is not anatomical.
    fn mirror_to_ras(&self) -> Option<[f64; 3]> {
        let space = self.fields.get(&["space"])?.to_ascii_lowercase();
        match space.trim_end_matches("-time") {
            "right-anterior-superior" | "ras" | "rast" => Some([1.0; 3]),
            "left-anterior-superior" | "las" | "last" => Some([-1.0, 1.0, 1.0]),
            "left-posterior-superior" | "lps" | "lpst" => Some(LPS_TO_RAS),
            _ => None,
        }
    }

    /// Millimetres where no unit is named.
    fn mm_per_unit(&self, name: Option<&&str>) -> Result<f64, ReadError> {
        match name.map(|name| name.trim()) {
            None | Some("" | "???" | "none") => Ok(1.0),
            Some(name) => mm_per_unit(name).ok_or_else(|| self.error("unit", name, "m, cm, mm or um")),
        }
    }

    fn error(&self, field: &str, value: &str, expected: &'static str) -> ReadError {
        self.fields.error(field, value, expected)
    }
}

/// The names between quotation marks.
fn quoted(text: Option<&str>) -> Vec<&str> {
    text.unwrap_or_default().split('"').skip(1).step_by(2).collect()
}

/// Fields and data: the header ends with an empty line, or with the file if the data stand elsewhere.
fn split(bytes: &[u8]) -> Result<(Fields, &[u8]), ReadError> {
    let mut fields = Fields::new(VolumeFormat::Nrrd);
    let mut rest = bytes;
    for number in 0.. {
        let end = rest.iter().position(|b| *b == b'\n');
        let line = String::from_utf8_lossy(&rest[..end.unwrap_or(rest.len())]);
        let line = line.trim_end_matches('\r');
        match number {
            0 if line.len() == 8 && line.starts_with("NRRD000") => {}
            0 => return Err(fields.error("first line", line, "NRRD0001 to NRRD0006")),
            _ if line.is_empty() => {
                rest = end.map_or(&[][..], |end| &rest[end + 1..]);
                break;
            }
            _ => add_line(&mut fields, line)?,
        }
        match end {
            Some(end) => rest = &rest[end + 1..],
            None => return Ok((fields, &[])),
        }
    }
    Ok((fields, rest))
}

/// `field: value`; comments (`#`) and key/value pairs (`key:=value`) say nothing about the voxels.
fn add_line(fields: &mut Fields, line: &str) -> Result<(), ReadError> {
    if line.starts_with('#') || line.contains(":=") {
        return Ok(());
    }
    match line.split_once(": ").or_else(|| line.split_once(':')) {
        Some((field, value)) => {
            fields.add(&field.to_ascii_lowercase().replace([' ', '-'], ""), value.trim());
            Ok(())
        }
        None => Err(fields.error("line", line, "`field: value`")),
    }
}

fn encoding(fields: &Fields) -> Result<Encoding, ReadError> {
    let text = fields.need(&["encoding"], "encoding")?;
    match text.to_ascii_lowercase().as_str() {
        "raw" => Ok(Encoding::Raw),
        "txt" | "text" | "ascii" => Ok(Encoding::Text),
        "gz" | "gzip" => Ok(Encoding::Gzip),
        _ => Err(ReadError::Unsupported {
            what: format!("the NRRD encoding `{}`", excerpt(text)),
            remedy: "save it again as raw or gzip, e.g. `unu save -f nrrd -e gzip`",
        }),
    }
}

fn scalar(fields: &Fields) -> Result<ScalarType, ReadError> {
    let text = fields.need(&["type"], "type")?;
    match text.to_ascii_lowercase().as_str() {
        "signed char" | "int8" | "int8_t" => Ok(ScalarType::I8),
        "uchar" | "unsigned char" | "uint8" | "uint8_t" => Ok(ScalarType::U8),
        "short" | "short int" | "signed short" | "signed short int" | "int16" | "int16_t" => Ok(ScalarType::I16),
        "ushort" | "unsigned short" | "unsigned short int" | "uint16" | "uint16_t" => Ok(ScalarType::U16),
        "int" | "signed int" | "int32" | "int32_t" => Ok(ScalarType::I32),
        "uint" | "unsigned int" | "uint32" | "uint32_t" => Ok(ScalarType::U32),
        "longlong"
        | "long long"
        | "long long int"
        | "signed long long"
        | "signed long long int"
        | "int64"
        | "int64_t" => Ok(ScalarType::I64),
        "ulonglong" | "unsigned long long" | "unsigned long long int" | "uint64" | "uint64_t" => Ok(ScalarType::U64),
        "float" => Ok(ScalarType::F32),
        "double" => Ok(ScalarType::F64),
        _ => Err(ReadError::Unsupported {
            what: format!("the NRRD type `{}`", excerpt(text)),
            remedy: "convert it to one integer or float per voxel, e.g. `unu convert -t float`",
        }),
    }
}

fn order(fields: &Fields, scalar: ScalarType, encoding: Encoding) -> Result<ByteOrder, ReadError> {
    match fields.get(&["endian"]) {
        Some("little") => Ok(ByteOrder::Little),
        Some("big") => Ok(ByteOrder::Big),
        None if scalar.size() == 1 || encoding == Encoding::Text => Ok(ByteOrder::Little),
        None => Err(ReadError::MissingField { format: VolumeFormat::Nrrd, field: "endian" }),
        Some(text) => Err(fields.error("endian", text, "little or big")),
    }
}

/// The name of the detached file, if the data are detached.
fn data_file(fields: &Fields) -> Result<Option<String>, ReadError> {
    let Some(text) = fields.get(&["datafile"]) else { return Ok(None) };
    let several = text.starts_with("LIST") || (text.contains('%') && text.contains(' '));
    match several {
        false => Ok(Some(text.into())),
        true => Err(ReadError::Unsupported {
            what: format!("an NRRD header with several data files (`{}`)", excerpt(text)),
            remedy: "join them, e.g. `unu save -f nrrd -i name.nhdr -o name.nrrd`",
        }),
    }
}

/// The three axes that are space, and their extents; any other axis must have length 1.
fn spatial_axes(fields: &Fields) -> Result<([usize; 3], [u64; 3]), ReadError> {
    const EXAMPLE: &str = "`unu slice -a AXIS -p 0`";
    let dimension: usize = parse_number(fields, "dimension", fields.need(&["dimension"], "dimension")?)?;
    if dimension > 16 {
        return Err(fields.error("dimension", &dimension.to_string(), "at most 16, as the format has it"));
    }
    let text = fields.need(&["sizes"], "sizes")?;
    let sizes: Vec<u64> = fields.numbers("sizes", text)?;
    if sizes.len() != dimension {
        return Err(fields.error("sizes", text, "as many numbers as `dimension` says"));
    }
    let mut spatial: Vec<usize> = (0..dimension).collect();
    // Axes that are not space go first: those the header marks, then the last ones.
    for axis in (0..dimension).filter(|a| !is_spatial(fields, *a)) {
        if sizes[axis] != 1 {
            return Err(ReadError::SeveralVolumes {
                count: sizes[axis],
                kind: kind_of(fields, axis),
                example: EXAMPLE,
            });
        }
        spatial.retain(|a| *a != axis);
    }
    while spatial.len() > 3 {
        let Some(last) = spatial.pop() else { break };
        if sizes[last] != 1 {
            return Err(ReadError::SeveralVolumes { count: sizes[last], kind: "time points", example: EXAMPLE });
        }
    }
    let axes: [usize; 3] =
        spatial.as_slice().try_into().map_err(|_| ReadError::Axes { found: spatial.len() as u64 })?;
    Ok((axes, axes.map(|a| sizes[a])))
}

/// By `kinds`, or by `none` among the `space directions`.
fn is_spatial(fields: &Fields, axis: usize) -> bool {
    let kind = fields.get(&["kinds"]).and_then(|kinds| kinds.split_ascii_whitespace().nth(axis));
    let direction = fields.get(&["spacedirections"]).and_then(|text| vectors(text).get(axis).copied());
    matches!(kind, None | Some("domain" | "space" | "none" | "???" | "stub")) && !matches!(direction, Some("none"))
}

fn kind_of(fields: &Fields, axis: usize) -> &'static str {
    match fields.get(&["kinds"]).and_then(|kinds| kinds.split_ascii_whitespace().nth(axis)) {
        Some("time") => "time points",
        _ => "components per voxel",
    }
}

/// Splits `none (1,0,0) (0, 1, 0)` at blanks outside parentheses.
fn vectors(text: &str) -> Vec<&str> {
    let mut vectors = Vec::new();
    let mut rest = text.trim();
    while !rest.is_empty() {
        let end = match rest.starts_with('(') {
            true => rest.find(')').map_or(rest.len(), |end| end + 1),
            false => rest.find(|c: char| c.is_ascii_whitespace() || c == '(').unwrap_or(rest.len()),
        };
        vectors.push(&rest[..end]);
        rest = rest[end..].trim_start();
    }
    vectors
}

fn parse_number(fields: &Fields, field: &str, text: &str) -> Result<usize, ReadError> {
    text.parse().map_err(|_| fields.error(field, text, "a whole number"))
}
