//! Blocks of points.
#![allow(dead_code)] // each test binary uses its part

use comminute::mpm::law::Law;
use comminute::mpm::{Continuum, Dimension, Points, Settings, Transfer};
use comminute::verify::block;
pub use comminute::verify::block::{elastic, fill};

pub const FLIP: Transfer = Transfer::Blend { pic: 0.0 };

pub fn settings(dimension: Dimension, cell: f64, cells: [u32; 3]) -> Settings {
    block::settings(dimension, cell, cells, block::FLIP)
}

pub fn continuum(settings: Settings, laws: Vec<Law>, points: Points) -> Continuum {
    Continuum::new(settings, laws, points).unwrap_or_else(|e| panic!("{e}"))
}

pub fn steps(c: &mut Continuum, dt: f64, n: u64) {
    block::steps(c, dt, n).unwrap_or_else(|e| panic!("{e}"));
}
