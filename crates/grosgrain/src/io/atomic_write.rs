//! Output files that are either whole or absent.

use std::fs::{self, File, OpenOptions};
use std::io::{self, BufWriter, Write};
use std::path::{Path, PathBuf};
use std::sync::atomic::{AtomicU64, Ordering};

static SERIAL: AtomicU64 = AtomicU64::new(0);

/// Calls `write` with a new file beside `path` and renames it to `path` once everything is on disk.
///
/// If `write` fails or panics, the new file is removed and whatever stood at `path` before stays as it was.
/// The writer can seek, so archives can be written too.
///
/// # Errors
/// What `write` returns, or the failure to create, flush or rename the file.
pub fn write_atomically<E: From<io::Error>>(
    path: &Path,
    write: impl FnOnce(&mut BufWriter<File>) -> Result<(), E>,
) -> Result<(), E> {
    let (file, beside) = Beside::create(path)?;
    let mut writer = BufWriter::new(file);
    write(&mut writer)?;
    writer.flush()?;
    writer.get_ref().sync_all()?;
    drop(writer);
    Ok(beside.rename_to(path)?)
}

/// The unfinished file; removed when dropped before its renaming.
struct Beside(Option<PathBuf>);

impl Beside {
    fn create(target: &Path) -> io::Result<(File, Self)> {
        let name = target.file_name().ok_or(io::ErrorKind::InvalidFilename)?;
        let serial = SERIAL.fetch_add(1, Ordering::Relaxed);
        let mut beside = std::ffi::OsString::from(".");
        beside.push(name);
        beside.push(format!(".{}-{serial}.part", std::process::id()));
        let beside = target.with_file_name(beside);
        let file = OpenOptions::new().read(true).write(true).create_new(true).open(&beside)?;
        Ok((file, Self(Some(beside))))
    }

    fn rename_to(mut self, target: &Path) -> io::Result<()> {
        let beside = self.0.as_deref().ok_or(io::ErrorKind::NotFound)?;
        fs::rename(beside, target)?;
        self.0 = None;
        Ok(())
    }
}

impl Drop for Beside {
    fn drop(&mut self) {
        if let Some(beside) = &self.0 {
            // Nothing is left to do about a file that cannot be removed either; the first failure is reported.
            let _ = fs::remove_file(beside);
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn entries(folder: &Path) -> Vec<PathBuf> {
        fs::read_dir(folder).unwrap().map(|e| e.unwrap().path()).collect()
    }

    #[test]
    fn a_failed_write_keeps_the_old_file_and_leaves_nothing_else() {
        let folder = tempfile::tempdir().unwrap();
        let path = folder.path().join("out.bin");
        write_atomically::<io::Error>(&path, |w| w.write_all(b"old")).unwrap();
        let failed = write_atomically::<io::Error>(&path, |w| {
            w.write_all(b"half")?;
            Err(io::Error::other("stop"))
        });
        assert_eq!(failed.unwrap_err().to_string(), "stop");
        assert_eq!(fs::read(&path).unwrap(), b"old");
        assert_eq!(entries(folder.path()), [path]);
    }

    #[test]
    fn a_whole_write_replaces_the_old_file() {
        let folder = tempfile::tempdir().unwrap();
        let path = folder.path().join("out.bin");
        for text in [b"first", b"later"] {
            write_atomically::<io::Error>(&path, |w| w.write_all(text)).unwrap();
            assert_eq!(fs::read(&path).unwrap(), text);
        }
        assert_eq!(entries(folder.path()), [path]);
    }
}
