//! The command line of grosgrain: scenes, commands, progress, reports.

pub mod arguments;
pub mod body;
pub mod body_surface;
pub mod commands;
pub mod deformed_volume;
pub mod failure;
pub mod film;
pub mod frames;
pub mod interruption;
pub mod machine;
pub mod memory;
pub mod method;
pub mod models;
pub mod outcome;
pub mod output;
pub mod picture;
pub mod placed_loads;
pub mod problem;
pub mod progress;
pub mod quantities;
pub mod report;
pub mod results;
pub mod scene;
pub mod schedule;
pub mod sequence;
pub mod timing;
