//! Where results go: made before anything is computed, taken away again if nothing comes of it.

use std::fs;
use std::path::{Path, PathBuf};

use crate::failure::Failure;

/// A folder that can be written to. Those that were made for it and are still empty when it is dropped go again.
#[derive(Debug)]
pub struct OutputFolder {
    path: PathBuf,
    /// The folders that were not there before, the innermost first.
    made: Vec<PathBuf>,
}

impl OutputFolder {
    /// Makes `path` and the folders around it, and tries whether a file can be written there.
    ///
    /// # Errors
    /// A file in the way; a system that refuses.
    pub fn make(path: &Path) -> Result<Self, Failure> {
        if let Some(file) = path.ancestors().find(|place| place.exists()).filter(|place| !place.is_dir()) {
            let sentence = "is a file; results need a folder there, name another one";
            return Err(Failure::Unusable(format!("{} {sentence}", file.display())));
        }
        let is_new = |place: &&Path| !place.as_os_str().is_empty() && !place.exists();
        let folder = Self { path: path.into(), made: path.ancestors().take_while(is_new).map(PathBuf::from).collect() };
        let probe = path.join(format!(".{}.part", std::process::id()));
        fs::create_dir_all(path)
            .and_then(|()| fs::write(&probe, ""))
            .and_then(|()| fs::remove_file(&probe))
            .map_err(|error| Failure::Failed(format!("no file can be written to {}: {error}", path.display())))?;
        Ok(folder)
    }

    /// Makes the folder that `file` is to stand in.
    ///
    /// # Errors
    /// As [`OutputFolder::make`]; a folder where the file is to stand.
    pub fn around(file: &Path) -> Result<Self, Failure> {
        match file.is_dir() {
            true => {
                Err(Failure::Unusable(format!("{} is a folder; expected the name of a file to write", file.display())))
            }
            false => Self::make(file.parent().unwrap_or(Path::new(""))),
        }
    }

    /// Its path.
    pub fn path(&self) -> &Path {
        &self.path
    }
}

impl Drop for OutputFolder {
    fn drop(&mut self) {
        for folder in &self.made {
            // A folder that holds results is not empty and stays.
            let _ = fs::remove_dir(folder);
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn new_folders_go_unless_something_is_written_into_them() {
        let root = tempfile::tempdir().unwrap();
        let (outer, inner) = (root.path().join("a"), root.path().join("a/b"));
        drop(OutputFolder::make(&inner).unwrap());
        assert!(!outer.exists());
        let folder = OutputFolder::around(&inner.join("model.npz")).unwrap();
        fs::write(folder.path().join("model.npz"), "full").unwrap();
        drop(folder);
        assert_eq!(fs::read(inner.join("model.npz")).unwrap(), b"full");
        drop(OutputFolder::make(&inner).unwrap());
        assert!(inner.exists(), "what was there before stays");
    }
}
