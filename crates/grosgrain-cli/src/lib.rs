//! The command line of grosgrain: scenes, commands, progress, reports.

pub mod scene;
