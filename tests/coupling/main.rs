//! Grains and a continuum that touch: momentum, mass and energy, rates, and bits. Each test states its error.

mod account;
mod blocks;
#[path = "../common/mod.rs"]
mod common;
mod fines;
mod growth;
mod hard;
mod impact;
mod inertia;
#[path = "../mpm/common.rs"]
mod points;
mod rates;
mod scene;
mod typed;
