//! Studies of what a choice costs: a scene with other levels of some factors, against a reference, with several seeds.
//!
//! A plan ([`Plan`]) names factors and their levels, one factor at a time or in a factorial. Its runs are processes of their own. Each
//! setting is compared with the reference seed by seed ([`Sample`]): the difference of the means has an interval, so that what seeds do is
//! not called an error. The report has each setting's error against its time, effects and interactions of a factorial, and the fastest
//! setting that is shown to be within the tolerance.

mod compare;
mod effects;
mod measure;
mod plan;
mod report;

pub use compare::{Difference, Sample, Verdict};
pub use effects::Effect;
pub use measure::Measure;
pub use plan::{Design, Plan, Setting};
pub use report::write;
