//! How long work reports where it stands.

/// Called with a stage's name, the steps done and the steps in all; returning `false` interrupts the work.
///
/// It may be called from several threads at once. The library itself prints nothing.
pub type Progress<'a> = &'a (dyn Fn(&'static str, usize, usize) -> bool + Sync);

/// Ignores all reports and never interrupts.
pub fn silent(_: &'static str, _: usize, _: usize) -> bool {
    true
}

/// The stage in which equations are solved by iteration. Its steps are percent of the decimal digits to be won, because
/// the number of iterations is not known beforehand.
pub const SOLVING: &str = "solving";
