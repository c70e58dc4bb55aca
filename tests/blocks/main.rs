//! Rigid bodies among themselves, without points: momenta, energy, and what statics says of stacks, slopes and arches. Each test states its error.

mod at_nodes;
mod breaking;
mod breaking_compounds;
#[path = "../common/mod.rs"]
mod common;
mod compound;
mod compound_typed;
mod driven;
mod driven_typed;
mod facets;
mod lists;
mod meeting;
mod mesh;
mod mesh_typed;
mod plane;
mod platens;
mod scene;
mod specimen;
mod statics;
mod superquadrics;
mod typed;
