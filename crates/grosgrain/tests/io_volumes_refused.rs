//! Files that hold no usable volume are refused with a sentence that names the place, the numbers and what to do.

use grosgrain::io::read_volume;
use std::io::Write;
use std::path::{Path, PathBuf};

fn fixture(name: &str) -> Vec<u8> {
    std::fs::read(fixture_path(name)).unwrap()
}

fn fixture_path(name: &str) -> PathBuf {
    Path::new(env!("CARGO_MANIFEST_DIR")).join("tests/fixtures/volumes").join(name)
}

/// Writes the file into an empty folder and checks that reading it fails with all these texts and a path.
#[track_caller]
fn refused(name: &str, bytes: &[u8], texts: &[&str]) {
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join(name);
    std::fs::write(&path, bytes).unwrap();
    refused_path(&path, texts);
}

/// The path that is named may be that of a companion in the same folder.
#[track_caller]
fn refused_path(path: &Path, texts: &[&str]) {
    let message = read_volume(path).expect_err("must be refused").to_string();
    let folder = if path.is_dir() { path } else { path.parent().unwrap() };
    assert!(message.starts_with(&folder.display().to_string()), "{message}");
    for text in texts {
        assert!(message.contains(text), "`{text}` is missing in: {message}");
    }
}

/// The NIfTI-1 fixture of 5 × 4 × 3 int16 with some bytes replaced.
fn nifti(patches: &[(usize, &[u8])]) -> Vec<u8> {
    patched(fixture("nifti1_i2.nii"), patches)
}

fn patched(mut bytes: Vec<u8>, patches: &[(usize, &[u8])]) -> Vec<u8> {
    for (at, patch) in patches {
        bytes[*at..at + patch.len()].copy_from_slice(patch);
    }
    bytes
}

fn replaced(bytes: &[u8], old: &str, new: &str) -> Vec<u8> {
    let at = bytes.windows(old.len()).position(|w| w == old.as_bytes()).expect(old);
    [&bytes[..at], new.as_bytes(), &bytes[at + old.len()..]].concat()
}

const SHORT: fn(i16) -> [u8; 2] = i16::to_le_bytes;
const FLOAT: fn(f32) -> [u8; 4] = f32::to_le_bytes;

#[test]
fn truncated_nifti() {
    let whole = nifti(&[]);
    refused("a.nii", &whole[..352 + 119], &["voxel data are cut off", "120 bytes are needed, 119 are there"]);
    refused("a.nii", &whole[..347], &["header bytes are cut off", "348 bytes are needed, 347"]);
    refused("a.nii", &[], &["348 bytes are needed, 0 are there"]);
    let zipped = fixture("nifti1_i2.nii.gz");
    for cut in [1, 9, 60] {
        refused("a.nii.gz", &zipped[..zipped.len() - cut], &["damaged or cut off"]);
    }
}

#[test]
fn lying_nifti_extents() {
    let wide = SHORT(30_000);
    let bytes = nifti(&[(42, &wide), (44, &wide), (46, &wide)]);
    refused("a.nii", &bytes, &["54000000000000 bytes are needed, 120 are there"]);
    let big = (1i64 << 40).to_le_bytes();
    let bytes = patched(fixture("nifti2_i2.nii"), &[(24, &big), (32, &big)]);
    refused("a.nii", &bytes, &["1099511627776 × 1099511627776 × 3 voxels, more than memory can address"]);
    refused("a.nii", &nifti(&[(44, &SHORT(0))]), &["extents along x, y, z are 5 × 0 × 3", "at least 1"]);
    refused("a.nii", &nifti(&[(44, &SHORT(-4))]), &["dim[2] is -4"]);
    refused("a.nii", &nifti(&[(40, &SHORT(9))]), &["dim[0] is 9"]);
    refused("a.nii", &nifti(&[(40, &SHORT(2))]), &["2 axes; three are needed"]);
    refused("a.nii", &nifti(&[(108, &FLOAT(1e9))]), &["voxel data are cut off", "0 are there"]);
    refused("a.nii", &nifti(&[(108, &FLOAT(f32::NAN))]), &["vox_offset is NaN"]);
    refused("a.nii", &nifti(&[(108, &FLOAT(12.0))]), &["vox_offset is 12"]);
}

#[test]
fn several_volumes_in_one_nifti() {
    let bytes = nifti(&[(40, &SHORT(4)), (48, &SHORT(12))]);
    refused("a.nii", &bytes, &["12 time points; choose one", "slicer[..., 0]"]);
    let bytes = nifti(&[(40, &SHORT(5)), (48, &SHORT(1)), (50, &SHORT(3))]);
    refused("a.nii", &bytes, &["3 components per voxel; choose one"]);
}

#[test]
fn nifti_fields_that_disagree() {
    refused("a.nii", &nifti(&[(72, &SHORT(8))]), &["bitpix is 8 while the data type is int16"]);
    refused("a.nii", &nifti(&[(70, &SHORT(32))]), &["voxel type complex cannot be read", "one real number per voxel"]);
    refused("a.nii", &nifti(&[(70, &SHORT(128))]), &["voxel type RGB colour"]);
    refused("a.nii", &nifti(&[(70, &SHORT(1536))]), &["128-bit float"]);
    refused("a.nii", &nifti(&[(70, &SHORT(7))]), &["unknown type 7"]);
    refused("a.nii", &nifti(&[(344, b"\0\0\0")]), &["magic", "Analyze 7.5"]);
    refused("a.nii", &nifti(&[(344, b"ni1")]), &["another file", ".hdr"]);
    refused("a.nii", &nifti(&[(0, &[1, 2, 3, 4])]), &["sizeof_hdr is 67305985"]);
    refused("a.nii", &nifti(&[(112, &FLOAT(f32::INFINITY))]), &["scl_slope and scl_inter", "inf"]);
    refused("a.nii", &nifti(&[(123, &[5])]), &["xyzt_units is 5"]);
}

#[test]
fn bad_nifti_spacing() {
    let zero = [0; 4];
    let bytes = nifti(&[(284, &zero), (300, &zero), (316, &zero)]);
    refused("a.nii", &bytes, &["spacing along y is 0", "sform", "positive and finite"]);
    refused("a.nii", &nifti(&[(280, &FLOAT(f32::NAN))]), &["spacing along x is NaN"]);
    refused("a.nii", &nifti(&[(292, &FLOAT(f32::NAN))]), &["offset in the world"]);
    let none = SHORT(0);
    let bytes = nifti(&[(252, &none), (254, &none), (88, &zero)]);
    refused("a.nii", &bytes, &["spacing along z is 0 (from pixdim)"]);
    let bytes = nifti(&[(252, &SHORT(1)), (254, &none), (256, &FLOAT(f32::NAN))]);
    refused("a.nii", &bytes, &["quaternion is NaN"]);
}

#[test]
fn a_nifti_header_without_its_image() {
    refused("a.hdr", &fixture("nifti1_pair.hdr"), &["a.img", "cannot be read"]);
    refused("a.img", &fixture("nifti1_pair.img"), &["a.hdr", "cannot be read"]);
}

#[test]
fn voxels_that_are_not_numbers() {
    let nan = f32::NAN.to_le_bytes();
    let bytes = patched(fixture("nifti2_f4.nii"), &[(544 + 4 * 26, &nan), (544 + 4 * 59, &nan)]);
    refused("a.nii", &bytes, &["2 of 60 voxels are NaN, the first at (1, 1, 1)", "replace them"]);
    let bytes = patched(fixture("npy_f8.npy"), &[(128 + 8 * 7, &f64::NAN.to_le_bytes())]);
    refused("a.npy", &bytes, &["1 of 60 voxels are NaN, the first at (2, 1, 0)"]);
}

#[test]
fn integers_that_would_be_rounded() {
    let bytes = patched(fixture("npy_i8.npy"), &[(128 + 8 * 3, &((1i64 << 53) + 1).to_le_bytes())]);
    refused("a.npy", &bytes, &["voxel (3, 0, 0) is beyond 2^53"]);
}

/// An NRRD header of 2 × 2 × 2 bytes with one line replaced or added, and its data.
fn nrrd(old: &str, new: &str) -> Vec<u8> {
    let header = "NRRD0005\ntype: uint8\ndimension: 3\nsizes: 2 2 2\nspacings: 1 1 1\nencoding: raw\n";
    assert!(header.contains(old), "{old}");
    [header.replace(old, new).as_bytes(), b"\n12345678"].concat()
}

#[test]
fn bad_nrrd() {
    let cases: [(&str, &str, &[&str]); 24] = [
        ("sizes: 2 2 2", "sizes: 2 2 3", &["12 bytes are needed, 8 are there"]),
        ("sizes: 2 2 2", "sizes: 2 2", &["sizes is `2 2`", "as many numbers as `dimension` says"]),
        ("sizes: 2 2 2", "sizes: 2 0 2", &["2 × 0 × 2"]),
        ("sizes: 2 2 2", "sizes: 2 two 2", &["sizes is `2 two 2`"]),
        ("sizes: 2 2 2", "sizes: 4294967296 4294967296 2", &["more than memory can address"]),
        ("sizes: 2 2 2", "key:=value", &["has no sizes"]),
        ("dimension: 3\nsizes: 2 2 2", "dimension: 2\nsizes: 2 4", &["2 axes; three are needed"]),
        ("dimension: 3\nsizes: 2 2 2", "dimension: 4\nsizes: 2 2 1 2", &["2 time points; choose one", "unu slice"]),
        ("dimension: 3", "dimension: 99", &["dimension is `99`", "at most 16"]),
        (
            "dimension: 3\nsizes: 2 2 2",
            "dimension: 4\nkinds: vector domain domain domain\nsizes: 2 2 2 1",
            &["2 components per voxel"],
        ),
        ("spacings: 1 1 1", "spacings: 1 0 1", &["spacing along y is 0 (from spacings)"]),
        ("spacings: 1 1 1", "spacings: 1 1 nan", &["spacing along z is NaN"]),
        ("spacings: 1 1 1", "spacings: 1 1", &["spacings is `1 1`", "one number per axis"]),
        ("spacings: 1 1 1", "spacings: 1 1 1\nunits: \"inch\" \"mm\" \"mm\"", &["unit is `inch`"]),
        ("spacings: 1 1 1", "space directions: (1,0,0) (0,0,0) (0,0,1)", &["spacing along y is 0"]),
        ("spacings: 1 1 1", "space directions: (1,0,0) (0,1)", &["space directions is `(0,1)`"]),
        ("spacings: 1 1 1", "space directions: (1,0,0) (0,1,0)", &["one vector per axis"]),
        ("type: uint8", "type: int16", &["has no endian"]),
        ("type: uint8", "type: block", &["type `block` cannot be read"]),
        ("encoding: raw", "encoding: bzip2", &["encoding `bzip2` cannot be read", "gzip"]),
        ("encoding: raw", "encoding: gzip", &["compressed data are damaged or cut off"]),
        ("encoding: raw", "encoding: text", &["8 numbers are needed, 1 are there"]),
        ("encoding: raw", "encoding: raw\nbyte skip: -2", &["byte skip is `-2`"]),
        ("encoding: raw", "encoding: raw\nrubbish", &["line is `rubbish`"]),
    ];
    for (old, new, texts) in cases {
        refused("a.nrrd", &nrrd(old, new), texts);
    }
    refused("a.nrrd", b"NRRD", &["first line is `NRRD`"]);
    let text = [nrrd("encoding: raw", "encoding: text"), b" 2 x 4 5 6 7 8".to_vec()].concat();
    refused("a.nrrd", &text, &["value 2 of the text-encoded voxels is `x`", "uint8"]);
}

#[test]
fn detached_data_that_are_missing_short_or_no_file() {
    let header = |name: &str| nrrd("encoding: raw", &format!("encoding: raw\ndata file: {name}"));
    refused("a.nhdr", &header("gone.raw"), &["gone.raw", "cannot be read"]);
    refused("a.nhdr", &header("."), &["is not a regular file"]);
    refused("a.nhdr", &header("s%03d.raw 1 4 1"), &["several data files"]);
    refused("a.nhdr", &header("LIST"), &["several data files"]);
    let mhd = replaced(&fixture("meta_detached.mhd"), "meta_detached.raw", "gone.raw");
    refused("a.mhd", &mhd, &["gone.raw", "cannot be read"]);
    let folder = tempfile::tempdir().unwrap();
    std::fs::write(folder.path().join("a.nhdr"), header("a.raw")).unwrap();
    std::fs::write(folder.path().join("a.raw"), b"1234567").unwrap();
    refused_path(&folder.path().join("a.nhdr"), &["8 bytes are needed, 7 are there"]);
}

#[test]
fn bad_metaimage() {
    let whole = fixture("meta_i2.mha");
    let cases: [(&str, &str, &[&str]); 14] = [
        ("DimSize = 5 4 3", "DimSize = 5 4 4", &["160 bytes are needed, 120 are there"]),
        ("DimSize = 5 4 3", "DimSize = 5 4", &["DimSize is `5 4`"]),
        ("DimSize = 5 4 3", "DimSize = 5 0 3", &["5 × 0 × 3"]),
        ("DimSize = 5 4 3", "DimSize = 4294967296 4294967296 2", &["more than memory can address"]),
        ("NDims = 3", "NDims = 2", &["DimSize is `5 4 3`"]),
        ("MET_SHORT", "MET_SHORT_ARRAY", &["type `MET_SHORT_ARRAY` cannot be read"]),
        ("MET_SHORT", "MET_SHORT\nElementNumberOfChannels = 3", &["3 components per voxel"]),
        ("ElementSpacing = 0.5 0.75 2.5", "ElementSpacing = 0.5 0 2.5", &["spacing along y is 0"]),
        ("ElementSpacing = 0.5 0.75 2.5", "ElementSpacing = 0.5 nan 2.5", &["spacing along y is NaN"]),
        ("ElementSpacing = 0.5 0.75 2.5", "ElementSpacing = 0.5", &["ElementSpacing is `0.5`"]),
        ("BinaryDataByteOrderMSB = False", "BinaryDataByteOrderMSB = perhaps", &["perhaps", "True or False"]),
        ("CompressedData = False", "CompressedData = True", &["compressed data are damaged"]),
        ("ElementDataFile = LOCAL", "ElementDataFile = LIST", &["several data files"]),
        ("ElementDataFile = LOCAL", "Nothing = LOCAL", &["line is"]),
    ];
    for (old, new, texts) in cases {
        refused("a.mha", &replaced(&whole, old, new), texts);
    }
    let four = b"NDims = 4\nDimSize = 1 1 1 2\nElementType = MET_UCHAR\nElementDataFile = LOCAL\nab";
    refused("a.mha", four, &["2 time points; choose one", "SimpleITK"]);
    refused("a.mha", b"NDims = 3\nDimSize = 1 1 1\nElementType = MET_UCHAR\n", &["has no ElementDataFile"]);
}

fn npy(descr: &str, shape: &str) -> Vec<u8> {
    let header = format!("{{'descr': {descr}, 'fortran_order': False, 'shape': {shape}, }}\n");
    [b"\x93NUMPY\x01\0".as_slice(), &(header.len() as u16).to_le_bytes(), header.as_bytes(), b"12345678"].concat()
}

#[test]
fn bad_npy() {
    refused("a.npy", &npy("'|u1'", "(2, 2, 3)"), &["12 bytes are needed, 8 are there"]);
    refused("a.npy", &npy("'|u1'", "(2, 0, 3)"), &["3 × 0 × 2"]);
    refused("a.npy", &npy("'|u1'", "(2, 4)"), &["2 axes; three are needed"]);
    refused("a.npy", &npy("'|u1'", "(5, 2, 2, 2)"), &["2 components per voxel", "array[..., 0]"]);
    refused("a.npy", &npy("'|u1'", "(2, 2, 2, 5)"), &["2 time points", "array[0]"]);
    refused("a.npy", &npy("'|u1'", "(4294967296, 4294967296, 1)"), &["more than memory can address"]);
    refused("a.npy", &npy("'|u1'", "(2, -2, 2)"), &["shape is (2, -2, 2)"]);
    refused("a.npy", &npy("'<c8'", "(1, 1, 1)"), &["type `<c8` cannot be read"]);
    refused("a.npy", &npy("[('a', '<f4')]", "(1, 1, 1)"), &["cannot be read", "astype"]);
    refused("a.npy", &npy("'|O'", "(1, 1, 1)"), &["type `|O`"]);
    refused("a.npy", b"\x93NUMPY\x01\0\xff\xff{}", &["header bytes are cut off"]);
    refused("a.npy", b"\x93NUMPY\x07\0\xff\xff{}", &["version is 7"]);
    refused("a.npy", b"other content", &["magic"]);
}

#[test]
fn files_of_no_known_format() {
    refused("a.raw", b"12345678", &["in no format that is read", "Raw voxel data need a header"]);
    refused("a.vtk", b"# vtk DataFile", &["in no format that is read"]);
    let mut gzip = flate2::write::GzEncoder::new(Vec::new(), flate2::Compression::default());
    gzip.write_all(&fixture("nrrd_u1_raw.nrrd")).unwrap();
    refused("a.nrrd.gz", &gzip.finish().unwrap(), &["a gzip-compressed NRRD file", "gunzip"]);
    let folder = tempfile::tempdir().unwrap();
    refused_path(folder.path(), &["neither .tif files nor DICOM slices (0 files"]);
    refused_path(&folder.path().join("gone.nii"), &["cannot be read"]);
}
