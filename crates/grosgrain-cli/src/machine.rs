//! The machine that times are measured on.

use std::fmt;

/// The machine, as measured times name it.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Machine {
    /// The processor's model name, or its architecture where the system does not tell.
    pub processor: String,
    /// Threads that this program uses where nothing else is said.
    pub threads: usize,
}

impl Machine {
    /// The machine that this runs on.
    pub fn here() -> Self {
        let text = std::fs::read_to_string("/proc/cpuinfo").unwrap_or_default();
        let processor = model_name(&text).unwrap_or(std::env::consts::ARCH).to_owned();
        Self { processor, threads: rayon::current_num_threads() }
    }
}

fn model_name(cpuinfo: &str) -> Option<&str> {
    cpuinfo.lines().find_map(|line| line.strip_prefix("model name")?.split_once(':')).map(|(_, name)| name.trim())
}

impl fmt::Display for Machine {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let noun = if self.threads == 1 { "thread" } else { "threads" };
        write!(f, "{}, {} {noun}", self.processor, self.threads)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_processor_is_the_model_name_of_the_first_core() {
        let text = "processor\t: 0\nmodel name\t: Some CPU @ 2 GHz\nprocessor\t: 1\nmodel name\t: Other\n";
        assert_eq!(model_name(text), Some("Some CPU @ 2 GHz"));
        assert_eq!(model_name("Hardware : board"), None);
    }
}
