//! The program as a user runs it: whole runs, what they write, and what they refuse.

mod accepted_runs;
mod edits;
mod homogenize;
mod interruption;
mod models;
mod moving;
mod program;
mod readme;
mod refused_runs;
mod reproduce;
mod reproduce_arguments;
mod reproduce_moving;
mod scenes;
mod stopped;
mod tables;
mod vtu;
