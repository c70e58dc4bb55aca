//! The engine against closed forms and exact symmetries. Numbers with a source are those of the benchmark tests of Chung & Ooi
//! (2011, Granular Matter 13) and of rigid-body mechanics.

#[path = "../common/mod.rs"]
mod common;

mod chain;
mod energy;
mod friction;
mod impact;
mod invariance;
mod lattice;
mod mindlin;
mod mirror;
mod oedometer;
mod yielding;
