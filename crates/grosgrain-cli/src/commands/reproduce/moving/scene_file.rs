//! Where the scenes of figures are.

use std::path::{Path, PathBuf};

use crate::failure::Failure;

/// The folder of the repository that holds them.
const FOLDER: &str = "scenes";

/// The scene `name` in `folder`; without one in a folder `scenes` in or above the current folder, else in or above that of the program.
///
/// # Errors
/// No such file.
pub fn find(name: &str, folder: Option<&Path>) -> Result<PathBuf, Failure> {
    if let Some(folder) = folder {
        let file = folder.join(name);
        let sentence =
            || format!("{} is missing; expected the figure's scene in the folder of --scenes", file.display());
        return if file.is_file() { Ok(file) } else { Err(Failure::Unusable(sentence())) };
    }
    let own = Path::new(FOLDER).join(name);
    if own.is_file() {
        return Ok(own);
    }
    let here = std::env::current_dir().ok();
    let program = std::env::current_exe().ok().and_then(|program| Some(program.parent()?.to_owned()));
    find_from(name, here.as_deref().into_iter().chain(program.as_deref())).ok_or_else(|| {
        Failure::Unusable(format!(
            "{FOLDER}/{name} is neither in or above the current folder nor in or above that of the program; \
             run it in the repository, or give the repository's folder of scenes by --scenes DIR"
        ))
    })
}

/// The file in a folder of scenes in or above the first place that has one.
fn find_from<'a>(name: &str, mut places: impl Iterator<Item = &'a Path>) -> Option<PathBuf> {
    let file = |folder: &Path| folder.join(FOLDER).join(name);
    places.find_map(|place| place.ancestors().map(file).find(|file| file.is_file()))
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
        let found = |places: &[&Path]| find_from("a.toml", places.iter().copied());
        assert_eq!(found(&[&root.join("near"), &root.join("far")]), Some(near.join("a.toml")));
        assert_eq!(found(&[&near.join("deeper"), &far]), Some(near.join("a.toml")));
        assert_eq!(found(&[Path::new("/nowhere/at/all"), &far.join("deeper")]), Some(far.join("a.toml")));
        assert_eq!(found(&[Path::new("/nowhere")]), None);
        assert_eq!(find("a.toml", Some(&near)).unwrap(), near.join("a.toml"));
        let message = find("b.toml", Some(&near)).unwrap_err().to_string();
        assert!(message.contains("b.toml is missing; expected the figure's scene"), "{message}");
    }
}
