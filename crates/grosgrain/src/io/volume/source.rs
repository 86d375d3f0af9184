//! From a path to bytes: files, their companions, folders of slices.

use super::inflate::{inflate_at_most, is_gzip};
use super::tiff_stack::Stack;
use super::{ReadError, VolumeFormat, dicom, metaimage, nifti, npy, nrrd, tiff_stack};
use crate::mesh::Volume;
use std::fs::{self, File};
use std::io::Read;
use std::path::{Path, PathBuf};

/// So many bytes show the format.
const MARK_BYTES: usize = 132;

/// A volume that is one file, with or without a companion that holds its voxels.
pub(super) fn read_one(path: &Path) -> Result<Volume, ReadError> {
    if has_ending(path, &[".img", ".img.gz"]) {
        return read_nifti_pair(&companion(path, ["hdr", "hdr.gz"])?, path);
    }
    let bytes = read_file(path)?;
    let format = VolumeFormat::of_content(&mark(&bytes)?).or_else(|| VolumeFormat::of_name(path));
    let beside = |name: &str| {
        let path = path.with_file_name("").join(name);
        read_file(&path).map_err(|e| e.in_file(&path))
    };
    match format.ok_or(ReadError::UnknownFormat)? {
        other if is_gzip(&bytes) && other != VolumeFormat::Nifti => Err(ReadError::Unsupported {
            what: format!("a gzip-compressed {other} file"),
            remedy: "expand it with gunzip; only NIfTI is read compressed as a whole",
        }),
        VolumeFormat::Nifti if has_ending(path, &[".hdr", ".hdr.gz"]) => {
            read_nifti_pair(path, &companion(path, ["img", "img.gz"])?)
        }
        VolumeFormat::Nifti => nifti::read_nifti(&bytes),
        VolumeFormat::Nrrd => nrrd::read(&bytes, beside),
        VolumeFormat::MetaImage => metaimage::read(&bytes, beside),
        VolumeFormat::Tiff => tiff_stack::read_tiff(&bytes),
        VolumeFormat::Npy => npy::read_npy(&bytes),
        VolumeFormat::Dicom => Err(ReadError::Unsupported {
            what: "a single DICOM file as a volume".into(),
            remedy: "give the folder that holds the slices of the series",
        }),
    }
}

/// A folder of `.tif` files or of DICOM slices.
pub(super) fn read_folder(path: &Path) -> Result<Volume, ReadError> {
    let mut files = Vec::new();
    for entry in fs::read_dir(path)? {
        let file = entry?.path();
        let hidden = file.file_name().is_some_and(|name| name.to_string_lossy().starts_with('.'));
        if !hidden && file.is_file() {
            files.push(file);
        }
    }
    files.sort_by_cached_key(|file| natural_key(file));
    let pages: Vec<&PathBuf> = files.iter().filter(|file| has_ending(file, &[".tif", ".tiff"])).collect();
    if pages.is_empty() {
        return dicom::read_files(&files, |file| dicom_bytes(file).map_err(|e| e.in_file(file)));
    }
    let mut stack = Stack::default();
    for page in pages {
        read_file(page).and_then(|bytes| stack.push_file(&bytes)).map_err(|e| e.in_file(page))?;
    }
    stack.into_volume()
}

fn read_nifti_pair(header: &Path, image: &Path) -> Result<Volume, ReadError> {
    let header = read_file(header).map_err(|e| e.in_file(header))?;
    let image = read_file(image).map_err(|e| e.in_file(image))?;
    nifti::read_nifti_pair(&header, &image)
}

/// The file of the same name with one of these endings; the first if there is none.
fn companion(path: &Path, endings: [&str; 2]) -> Result<PathBuf, ReadError> {
    let name = path.file_name().ok_or(ReadError::NotAFile)?.to_string_lossy();
    let stem = name.strip_suffix(".gz").unwrap_or(&name);
    let stem = stem.rsplit_once('.').map_or(stem, |(stem, _)| stem);
    let [first, second] = endings.map(|ending| path.with_file_name(format!("{stem}.{ending}")));
    Ok(if !first.exists() && second.exists() { second } else { first })
}

/// The whole content of a regular file: no devices and pipes, which may never end.
fn read_file(path: &Path) -> Result<Vec<u8>, ReadError> {
    match fs::metadata(path)?.is_file() {
        true => Ok(fs::read(path)?),
        false => Err(ReadError::NotAFile),
    }
}

/// The content of a DICOM file; `None` for files of other kinds, unless their name says that they are DICOM.
fn dicom_bytes(path: &Path) -> Result<Option<Vec<u8>>, ReadError> {
    let mut mark = Vec::new();
    File::open(path)?.take(MARK_BYTES as u64).read_to_end(&mut mark)?;
    let is_dicom = VolumeFormat::of_content(&mark) == Some(VolumeFormat::Dicom);
    match is_dicom || VolumeFormat::of_name(path) == Some(VolumeFormat::Dicom) {
        true => Ok(Some(read_file(path)?)),
        false => Ok(None),
    }
}

/// The first bytes, expanded where they are compressed.
fn mark(bytes: &[u8]) -> Result<Vec<u8>, ReadError> {
    match is_gzip(bytes) {
        true => inflate_at_most(bytes, MARK_BYTES),
        false => Ok(bytes[..bytes.len().min(MARK_BYTES)].to_vec()),
    }
}

fn has_ending(path: &Path, endings: &[&str]) -> bool {
    let name = path.file_name().unwrap_or_default().to_string_lossy().to_ascii_lowercase();
    endings.iter().any(|ending| name.ends_with(ending))
}

/// Sorts `slice_2` before `slice_10`: digits compare by the length of their run first.
fn natural_key(path: &Path) -> Vec<(usize, String)> {
    let name = path.file_name().unwrap_or_default().to_string_lossy();
    let mut runs: Vec<(usize, String)> = Vec::new();
    let mut in_digits = false;
    for c in name.chars() {
        match runs.last_mut() {
            Some((length, run)) if c.is_ascii_digit() == in_digits => {
                run.push(c);
                *length += usize::from(in_digits);
            }
            _ => runs.push((usize::from(c.is_ascii_digit()), c.to_string())),
        }
        in_digits = c.is_ascii_digit();
    }
    for (length, run) in &mut runs {
        let digits = run.trim_start_matches('0');
        if *length > 0 {
            (*length, *run) = (digits.len().max(1), digits.into());
        }
    }
    runs
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn slices_are_sorted_by_the_numbers_in_their_names() {
        let mut names = ["s_10.tif", "s_9.tif", "s_0011.tif", "s_2.tif", "r.tif", "s_1b.tif", "s_1a.tif"];
        names.sort_by_key(|name| natural_key(Path::new(name)));
        assert_eq!(names, ["r.tif", "s_1a.tif", "s_1b.tif", "s_2.tif", "s_9.tif", "s_10.tif", "s_0011.tif"]);
    }
}
