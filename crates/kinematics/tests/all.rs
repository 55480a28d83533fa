//! Tests of arms as their users see them, in one binary: a file each.

mod common;

mod accuracy;
mod calibrated;
mod calibrated_truth;
mod calibration_file;
mod iterative;
mod manual_examples;
mod no_allocation;
mod properties;
mod truth;
mod urdf_models;
