//! The fields of a NIfTI header that matter for a scalar volume.

use super::super::geometry::{self, Affine, Geometry, column_norms, spacing_from_mm};
use super::super::samples::{ByteOrder, SampleLayout, ScalarType};
use super::super::{ReadError, VolumeFormat};

/// Size of the larger of the two headers.
pub(super) const HEADER_BYTES: usize = 540;

/// Offsets in bytes of the fields of one version of the header.
struct Offsets {
    size: usize,
    magic: usize,
    data_type: usize,
    bits: usize,
    dim: usize,
    pixdim: usize,
    vox_offset: usize,
    slope: usize,
    units: usize,
    qform_code: usize,
    sform_code: usize,
    quaternion: usize,
    srow: usize,
    wide: bool,
}

const VERSION_1: Offsets = Offsets {
    size: 348,
    magic: 344,
    data_type: 70,
    bits: 72,
    dim: 40,
    pixdim: 76,
    vox_offset: 108,
    slope: 112,
    units: 123,
    qform_code: 252,
    sform_code: 254,
    quaternion: 256,
    srow: 280,
    wide: false,
};

const VERSION_2: Offsets = Offsets {
    size: 540,
    magic: 4,
    data_type: 12,
    bits: 14,
    dim: 16,
    pixdim: 104,
    vox_offset: 168,
    slope: 176,
    units: 500,
    qform_code: 344,
    sform_code: 348,
    quaternion: 352,
    srow: 400,
    wide: true,
};

/// What a NIfTI header says about its voxels.
#[derive(Debug)]
pub(super) struct Header {
    extents: [u64; 3],
    scalar: ScalarType,
    order: ByteOrder,
    /// `pixdim[0..4]`.
    pixdim: [f64; 4],
    mm_per_unit: f64,
    sform: Option<Affine>,
    /// b, c, d and the offset.
    qform: Option<[f64; 6]>,
    /// Where the voxels start in their file.
    pub data_offset: usize,
    /// Slope and intercept, unless they change nothing.
    pub scaling: Option<(f64, f64)>,
    /// The voxels stand in another file.
    pub detached: bool,
}

impl Header {
    pub fn parse(bytes: &[u8]) -> Result<Self, ReadError> {
        let fields = Fields::of(bytes)?;
        let detached = fields.is_detached()?;
        Ok(Self {
            extents: fields.extents()?,
            scalar: fields.scalar()?,
            order: fields.order,
            pixdim: std::array::from_fn(|a| fields.real(fields.at.pixdim, a)),
            mm_per_unit: fields.mm_per_unit()?,
            sform: fields.sform(),
            qform: fields.qform(),
            data_offset: fields.data_offset(detached)?,
            scaling: fields.scaling()?,
            detached,
        })
    }

    pub fn layout(&self) -> Result<SampleLayout, ReadError> {
        SampleLayout::new(self.extents, self.scalar, self.order)
    }

    /// Spacing and axes: sform, else qform, else pixdim.
    pub fn geometry(&self, cells: [usize; 3]) -> Result<Geometry, ReadError> {
        let sizes = [self.pixdim[1], self.pixdim[2], self.pixdim[3]].map(|h| h.abs() * self.mm_per_unit);
        let in_mm = |affine: Affine| -> Affine {
            let [x, y, z, w] = affine;
            let [x, y, z] = [x, y, z].map(|row| row.map(|v| v * self.mm_per_unit));
            [x, y, z, w]
        };
        let (affine, lengths, field) = match (self.sform, self.qform) {
            (Some(sform), _) => {
                let affine = in_mm(sform);
                (Some(affine), column_norms(&affine), "the sform rows srow_x, srow_y, srow_z")
            }
            (None, Some(qform)) => {
                let affine = in_mm(quaternion_affine(qform, self.pixdim)?);
                (Some(affine), sizes, "pixdim")
            }
            (None, None) => (None, sizes, "pixdim"),
        };
        let spacing = spacing_from_mm(lengths, field)?;
        if let Some(affine) = affine.filter(|a| !geometry::is_finite(a)) {
            let value = format!("{:?}", [affine[0][3], affine[1][3], affine[2][3]]);
            return Err(field_error("offset in the world", value, "three finite numbers"));
        }
        Ok(Geometry { cells, spacing: Some(spacing), voxel_to_world: affine })
    }
}

/// The rotation of a quaternion (a ≥ 0, b, c, d) times the voxel sizes, as the NIfTI-1 standard has it.
fn quaternion_affine([b, c, d, x, y, z]: [f64; 6], pixdim: [f64; 4]) -> Result<Affine, ReadError> {
    let squares = b * b + c * c + d * d;
    if !squares.is_finite() {
        return Err(field_error(
            "quaternion",
            format!("{b}, {c}, {d}"),
            "three numbers whose squares sum to at most 1",
        ));
    }
    let (a, [b, c, d]) = match 1.0 - squares {
        rest if rest >= 1e-7 => (rest.sqrt(), [b, c, d]),
        _ => (0.0, [b, c, d].map(|v| v / squares.sqrt())),
    };
    let rotation = [
        [a * a + b * b - c * c - d * d, 2.0 * (b * c - a * d), 2.0 * (b * d + a * c)],
        [2.0 * (b * c + a * d), a * a + c * c - b * b - d * d, 2.0 * (c * d - a * b)],
        [2.0 * (b * d - a * c), 2.0 * (c * d + a * b), a * a + d * d - b * b - c * c],
    ];
    let handedness = if pixdim[0] < 0.0 { -1.0 } else { 1.0 };
    let sizes = [pixdim[1].abs(), pixdim[2].abs(), pixdim[3].abs() * handedness];
    let axis = |column: usize| std::array::from_fn(|row| rotation[row][column] * sizes[column]);
    Ok(geometry::affine([axis(0), axis(1), axis(2)], [x, y, z]))
}

/// The raw fields, at the offsets of their version and in their byte order.
struct Fields<'a> {
    bytes: &'a [u8],
    at: &'static Offsets,
    order: ByteOrder,
}

impl<'a> Fields<'a> {
    fn of(bytes: &'a [u8]) -> Result<Self, ReadError> {
        let truncated = |needed: usize| ReadError::Truncated {
            part: "header bytes",
            needed: needed as u64,
            found: bytes.len() as u64,
        };
        let word = *bytes.first_chunk::<4>().ok_or_else(|| truncated(VERSION_1.size))?;
        let (at, order) = match (i32::from_le_bytes(word), i32::from_be_bytes(word)) {
            (348, _) => (&VERSION_1, ByteOrder::Little),
            (_, 348) => (&VERSION_1, ByteOrder::Big),
            (540, _) => (&VERSION_2, ByteOrder::Little),
            (_, 540) => (&VERSION_2, ByteOrder::Big),
            (size, _) => return Err(field_error("sizeof_hdr", size.to_string(), "348 (NIfTI-1) or 540 (NIfTI-2)")),
        };
        let bytes = bytes.get(..at.size).ok_or_else(|| truncated(at.size))?;
        Ok(Self { bytes, at, order })
    }

    /// The N bytes at `offset`, least significant first. Offsets are those of the tables above, all inside the header.
    fn word<const N: usize>(&self, offset: usize) -> [u8; N] {
        let word = self.bytes.get(offset..).and_then(|rest| rest.first_chunk::<N>());
        self.order.to_little(word.copied().unwrap_or([0; N]))
    }

    fn short(&self, offset: usize) -> i16 {
        i16::from_le_bytes(self.word(offset))
    }

    /// Entry `index` of an array of reals: f32 in version 1, f64 in version 2.
    fn real(&self, offset: usize, index: usize) -> f64 {
        match self.at.wide {
            true => f64::from_le_bytes(self.word(offset + 8 * index)),
            false => f64::from(f32::from_le_bytes(self.word(offset + 4 * index))),
        }
    }

    fn code(&self, offset: usize) -> i32 {
        match self.at.wide {
            true => i32::from_le_bytes(self.word(offset)),
            false => i32::from(self.short(offset)),
        }
    }

    fn dim(&self, index: usize) -> i64 {
        match self.at.wide {
            true => i64::from_le_bytes(self.word(self.at.dim + 8 * index)),
            false => i64::from(self.short(self.at.dim + 2 * index)),
        }
    }

    fn is_detached(&self) -> Result<bool, ReadError> {
        let magic: &[u8] = self.bytes.get(self.at.magic..self.at.magic + 3).unwrap_or_default();
        match magic {
            b"n+1" | b"n+2" => Ok(false),
            b"ni1" | b"ni2" => Ok(true),
            _ => Err(field_error(
                "magic",
                format!("`{}`", magic.escape_ascii()),
                "n+1, ni1, n+2 or ni2 (an Analyze 7.5 file must be converted to NIfTI)",
            )),
        }
    }

    fn extents(&self) -> Result<[u64; 3], ReadError> {
        const SLICER: &str = "with nibabel: `nibabel.load(name).slicer[..., 0]`";
        let axes = self.dim(0);
        match axes {
            1..=2 => return Err(ReadError::Axes { found: axes.unsigned_abs() }),
            3..=7 => {}
            _ => return Err(field_error("dim[0]", axes.to_string(), "3 to 7, the number of axes")),
        }
        for a in 1..=axes as usize {
            if self.dim(a) < 0 {
                return Err(field_error(&format!("dim[{a}]"), self.dim(a).to_string(), "a number of voxels"));
            }
        }
        for a in 4..=axes as usize {
            let kind = if a == 4 { "time points" } else { "components per voxel" };
            match self.dim(a).unsigned_abs() {
                1 => {}
                0 => return Err(field_error(&format!("dim[{a}]"), "0".into(), "1")),
                count => return Err(ReadError::SeveralVolumes { count, kind, example: SLICER }),
            }
        }
        Ok([1, 2, 3].map(|a| self.dim(a).unsigned_abs()))
    }

    fn scalar(&self) -> Result<ScalarType, ReadError> {
        let code = self.short(self.at.data_type);
        let scalar = match code {
            2 => ScalarType::U8,
            4 => ScalarType::I16,
            8 => ScalarType::I32,
            16 => ScalarType::F32,
            64 => ScalarType::F64,
            256 => ScalarType::I8,
            512 => ScalarType::U16,
            768 => ScalarType::U32,
            1024 => ScalarType::I64,
            1280 => ScalarType::U64,
            _ => return Err(unsupported_type(code)),
        };
        let bits = self.short(self.at.bits);
        match i32::from(bits) == 8 * scalar.size() as i32 {
            true => Ok(scalar),
            false => Err(field_error(
                "bitpix",
                format!("{bits} while the data type is {}", scalar.name()),
                "the number of bits of the data type",
            )),
        }
    }

    fn mm_per_unit(&self) -> Result<f64, ReadError> {
        match self.bytes.get(self.at.units + usize::from(self.at.wide && self.order == ByteOrder::Big) * 3) {
            Some(units) => match units & 7 {
                0 | 2 => Ok(1.0),
                1 => Ok(1e3),
                3 => Ok(1e-3),
                code => Err(field_error("xyzt_units", code.to_string(), "0 (unknown), 1 (m), 2 (mm) or 3 (µm)")),
            },
            None => Ok(1.0),
        }
    }

    fn sform(&self) -> Option<Affine> {
        let row = |r: usize| std::array::from_fn(|c| self.real(self.at.srow, 4 * r + c));
        (self.code(self.at.sform_code) > 0).then(|| [row(0), row(1), row(2), [0.0, 0.0, 0.0, 1.0]])
    }

    fn qform(&self) -> Option<[f64; 6]> {
        (self.code(self.at.qform_code) > 0).then(|| std::array::from_fn(|a| self.real(self.at.quaternion, a)))
    }

    fn data_offset(&self, detached: bool) -> Result<usize, ReadError> {
        let least = if detached { 0 } else { self.at.size };
        let offset = match self.at.wide {
            true => i64::from_le_bytes(self.word(self.at.vox_offset)) as f64,
            false => self.real(self.at.vox_offset, 0),
        };
        match offset {
            // Some writers leave 0 in a single file: the voxels follow the header and its four extension bytes.
            0.0 if !detached => Ok(least + 4),
            _ if offset.fract() == 0.0 && offset >= least as f64 && offset < 2f64.powi(53) => Ok(offset as usize),
            _ => Err(field_error(
                "vox_offset",
                offset.to_string(),
                "a whole number of bytes that is not inside the header",
            )),
        }
    }

    fn scaling(&self) -> Result<Option<(f64, f64)>, ReadError> {
        let (slope, intercept) = (self.real(self.at.slope, 0), self.real(self.at.slope, 1));
        match (slope, intercept) {
            (slope, _) if slope == 0.0 || slope.is_nan() => Ok(None),
            (1.0, 0.0) => Ok(None),
            _ if slope.is_finite() && intercept.is_finite() => Ok(Some((slope, intercept))),
            _ => Err(field_error(
                "scl_slope and scl_inter",
                format!("{slope} and {intercept}"),
                "two finite numbers, or slope 0 for none",
            )),
        }
    }
}

fn unsupported_type(code: i16) -> ReadError {
    let name = match code {
        1 => "1-bit".into(),
        32 | 1792 | 2048 => "complex".into(),
        128 | 2304 => "RGB colour".into(),
        1536 => "128-bit float".into(),
        _ => format!("unknown type {code}"),
    };
    let remedy = "convert it to one real number per voxel (8- to 64-bit integer or float)";
    ReadError::Unsupported { what: format!("the NIfTI voxel type {name}"), remedy }
}

fn field_error(field: &str, value: String, expected: &'static str) -> ReadError {
    ReadError::Field { format: VolumeFormat::Nifti, field: field.into(), value, expected }
}
