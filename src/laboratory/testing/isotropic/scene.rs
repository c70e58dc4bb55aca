//! Makes [`Compression`] from the keys of isotropic compression.

use crate::model::{Compression, Loading};
use crate::scene::material::Named;
use crate::scene::view::View;

impl View<'_> {
    /// The isotropic compression of the scene; `None`, with the reasons noted, where it is refused.
    pub fn isotropic(&self, named: &[Named]) -> Option<Compression> {
        let specimen = self.specimen(&named[0])?;
        let mut stages = vec![self.si("loading.max_stress_kPa")];
        stages.extend(self.numbers("loading.stages_kPa"));
        self.check(
            stages[0] > specimen.isotropic_stress,
            "loading.max_stress_kPa",
            format!("must be > {}, the isotropic stress at the start", 1e-3 * specimen.isotropic_stress),
        );
        self.check(stages.iter().all(|s| *s > 0.0), "loading.stages_kPa", "must all be > 0");
        self.check(stages.windows(2).all(|w| w[0] != w[1]), "loading.stages_kPa", "must each differ from the stress before it");
        self.check(
            specimen.wall_friction.cylinder == 0.0,
            "walls.friction.cylinder",
            "must be 0: with friction the cylinder would carry a part of the platens' force, and the stress would not be isotropic",
        );
        let loading = Loading {
            stages,
            rate: 0.0,
            sigma_ref: 0.0,
            load_increment: Some(self.si("loading.pace")),
            max_inertial_number: self.si("loading.max_inertial_number"),
            max_lag: self.si("loading.max_lag"),
            max_wait: self.whole("loading.max_wait_steps").unwrap_or(u64::MAX),
            strain_controlled: None,
            row_strain: self.number("records.every_strain"),
            row_events: self.whole("records.every_events"),
        };
        Some(Compression { specimen, loading, all_sides: true, fines: None })
    }
}
