//! The program as a user runs it: whole runs, what they write, and what they refuse.

mod accepted_runs;
mod edits;
mod homogenize;
mod interruption;
mod mesh_scenes;
mod models;
mod moving;
mod program;
mod readme;
mod refused_runs;
mod reproduce;
mod reproduce_arguments;
mod reproduce_falling;
mod reproduce_moving;
mod reproduce_tensors;
mod scenes;
mod stopped;
mod tables;
mod vtu;
