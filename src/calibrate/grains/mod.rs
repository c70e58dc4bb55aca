//! Strength of grains from the forces that crushed them between platens (Ciantia et al. 2015, section "Model
//! calibration", eqs 16, 17, Figs 7, 8): sigma_lim0, m and var. by maximum likelihood.
//!
//! A grain of diameter d that breaks under the force F had the limit strength sigma = F / A_F(F, d), and
//!
//! ```text
//! sigma = sigma_lim0 (d / d0)^(-s) y,   s = 3/m,   y from a spread with the coefficient of variation var.
//! ```
//!
//! The likelihood is that of the forces (the density of sigma times d sigma / d F), so that fits with different area
//! models can be compared. A grain that bore its force counts with the probability of a higher strength.

pub mod area;
mod bootstrap;
pub mod classes;
pub mod data;
pub mod figures;
pub mod fit;
pub mod fragment;
pub mod goodness;
pub mod likelihood;
mod profile;
pub mod report;
pub mod simulate;
pub mod spread;
pub mod study;
