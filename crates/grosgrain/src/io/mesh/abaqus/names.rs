//! Names of sets and materials in Abaqus input files.

use std::collections::BTreeSet;

/// Longest name that Abaqus takes.
const LONGEST: usize = 80;

/// The names that are taken; Abaqus does not tell upper from lower case.
#[derive(Debug, Default)]
pub(super) struct SetNames(BTreeSet<String>);

impl SetNames {
    /// A name like `wanted` that Abaqus takes and that is not yet used: letters, digits, `_` and `-`, a letter first. What is left out becomes `_`; a number at the end is
    /// counted up, or put there.
    pub fn unused(&mut self, wanted: &str) -> String {
        let plain = |c: char| if c.is_ascii_alphanumeric() || "_-".contains(c) { c } else { '_' };
        let mut name: String = wanted.chars().map(plain).take(LONGEST - 20).collect();
        if !name.starts_with(|c: char| c.is_ascii_alphabetic()) {
            name.insert_str(0, "SET_");
        }
        if self.0.insert(name.to_ascii_uppercase()) {
            return name;
        }
        let stem = name.trim_end_matches(|c: char| c.is_ascii_digit()).trim_end_matches('_');
        (2..).map(|n: u64| format!("{stem}_{n}")).find(|name| self.0.insert(name.to_ascii_uppercase())).unwrap_or(name)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn names_are_made_fit_and_different() {
        let mut names = SetNames::default();
        let wanted = ["liver", "Liver", "left lung, 2", "7", "TAG_-3", "MATERIAL_1", "MATERIAL_1", "MATERIAL_1", ""];
        let found: Vec<String> = wanted.iter().map(|name| names.unused(name)).collect();
        let expected =
            ["liver", "Liver_2", "left_lung__2", "SET_7", "TAG_-3", "MATERIAL_1", "MATERIAL_2", "MATERIAL_3", "SET_"];
        assert_eq!(found, expected);
        assert!(names.unused(&"x".repeat(500)).len() <= LONGEST);
    }
}
