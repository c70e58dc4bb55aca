//! What is known without a closed form: a scene that is turned, mirrored, written in another order or in other units has the turned, mirrored,
//! reordered or rescaled result. Where arithmetic gives the same numbers, the results are asked to be the same numbers.

mod breakage;
mod change;
mod continuum;
mod grains;
mod laws;
mod mixture;
