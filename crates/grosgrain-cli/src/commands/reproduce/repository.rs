//! Files of the repository that figures are made from.

use std::path::{Path, PathBuf};

use crate::failure::Failure;

/// A folder of the repository.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Shelf {
    /// Its name from the root.
    pub folder: &'static str,
    /// The option that names another one.
    pub option: &'static str,
    /// What a figure takes from it.
    pub holds: &'static str,
}

/// Scenes.
pub const SCENES: Shelf = Shelf { folder: "scenes", option: "--scenes", holds: "scene" };
/// Meshes.
pub const MESHES: Shelf = Shelf { folder: "data/meshes", option: "--meshes", holds: "mesh" };

impl Shelf {
    /// The file `name` in `folder`; without one in the shelf in or above the current folder, else in or above that of the program.
    ///
    /// # Errors
    /// No such file.
    pub fn find(self, name: &str, folder: Option<&Path>) -> Result<PathBuf, Failure> {
        let Self { folder: own_folder, option, holds } = self;
        if let Some(folder) = folder {
            let file = folder.join(name);
            let sentence =
                || format!("{} is missing; expected the figure's {holds} in the folder of {option}", file.display());
            return if file.is_file() { Ok(file) } else { Err(Failure::Unusable(sentence())) };
        }
        let own = Path::new(own_folder).join(name);
        if own.is_file() {
            return Ok(own);
        }
        let here = std::env::current_dir().ok();
        let program = std::env::current_exe().ok().and_then(|program| Some(program.parent()?.to_owned()));
        self.find_from(name, here.as_deref().into_iter().chain(program.as_deref())).ok_or_else(|| {
            Failure::Unusable(format!(
                "{own_folder}/{name} is neither in or above the current folder nor in or above that of the program; \
                 run it in the repository, or give a folder that has it by {option} DIR"
            ))
        })
    }

    /// The file in a shelf in or above the first place that has one.
    fn find_from<'a>(self, name: &str, mut places: impl Iterator<Item = &'a Path>) -> Option<PathBuf> {
        let file = |folder: &Path| folder.join(self.folder).join(name);
        places.find_map(|place| place.ancestors().map(file).find(|file| file.is_file()))
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_folder_of_scenes_is_in_or_above_a_place_and_the_first_place_wins() {
        let folder = tempfile::tempdir().unwrap();
        let root = folder.path();
        let [near, far] = ["near/scenes", "far/scenes"].map(|name| root.join(name));
        for scenes in [&near, &far] {
            std::fs::create_dir_all(scenes.join("deeper")).unwrap();
            std::fs::write(scenes.join("a.toml"), "").unwrap();
        }
        let found = |places: &[&Path]| SCENES.find_from("a.toml", places.iter().copied());
        assert_eq!(found(&[&root.join("near"), &root.join("far")]), Some(near.join("a.toml")));
        assert_eq!(found(&[&near.join("deeper"), &far]), Some(near.join("a.toml")));
        assert_eq!(found(&[Path::new("/nowhere/at/all"), &far.join("deeper")]), Some(far.join("a.toml")));
        assert_eq!(found(&[Path::new("/nowhere")]), None);
        assert_eq!(SCENES.find("a.toml", Some(&near)).unwrap(), near.join("a.toml"));
        let message = SCENES.find("b.toml", Some(&near)).unwrap_err().to_string();
        assert!(
            message.contains("b.toml is missing; expected the figure's scene in the folder of --scenes"),
            "{message}"
        );
        let message = MESHES.find("absent.mesh", None).unwrap_err().to_string();
        assert!(
            message.starts_with("data/meshes/absent.mesh is neither") && message.contains("--meshes DIR"),
            "{message}"
        );
    }
}
