//! From the keys of loading to [`Loading`].

use super::view::View;
use crate::model::Loading;

impl View<'_> {
    pub fn loading(&self) -> Loading {
        let mut stages = vec![self.si("loading.max_stress_kPa")];
        stages.extend(self.numbers("loading.stages_kPa"));
        let loading = Loading {
            stages,
            rate: self.si("loading.rate"),
            sigma_ref: self.si("loading.sigma_ref_kPa"),
            pace: (self.text("loading.programme") == "adaptive").then(|| self.si("loading.pace")),
            max_inertial_number: self.si("loading.max_inertial_number"),
            max_lag: self.si("loading.max_lag"),
            strain_controlled: (self.text("loading.control") == "strain").then(|| self.si("loading.inertial_number")),
            row_strain: self.number("records.every_strain").or((self.text("loading.control") == "strain").then_some(0.002)),
            row_events: self.whole("records.every_events"),
        };
        let isotropic = self.si("specimen.isotropic_stress_kPa");
        let (kpa, sigma_ref) = (1e-3 * isotropic, 1e-3 * loading.sigma_ref);
        self.check(
            loading.stages[0] > isotropic,
            "loading.max_stress_kPa",
            format!("must be > {kpa}, the isotropic stress at the start"),
        );
        self.check(
            isotropic >= loading.sigma_ref,
            "specimen.isotropic_stress_kPa",
            format!("must be >= {sigma_ref}, the reference stress of eq. 18"),
        );
        let low = loading.stages.iter().any(|s| *s < loading.sigma_ref);
        self.check(!low, "loading.stages_kPa", format!("must all be >= {sigma_ref}, the reference stress of eq. 18"));
        let idle = loading.stages.windows(2).any(|w| w[0] == w[1]);
        self.check(!idle, "loading.stages_kPa", "must each differ from the stress before it");
        loading
    }
}
