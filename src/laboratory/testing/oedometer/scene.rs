//! Makes [`Compression`] from the keys of an oedometer.

use crate::model::{Compression, Loading};
use crate::scene::estimate::median;
use crate::scene::material::Named;
use crate::scene::view::View;
use engine::coupling::Embedding;

/// Edge of a cell of the grid for points from breakages, over d50, where the scene does not state it: two points then have about
/// the volume of one daughter.
const CELL: f64 = 0.4;
/// Allowed edges over d50: with smaller cells a breakage makes more points than find a place, larger ones hold several grains.
const CELLS: std::ops::RangeInclusive<f64> = 0.1..=2.0;

impl View<'_> {
    /// The oedometer of the scene; `None`, with the reasons noted, where it is refused.
    pub fn oedometer(&self, named: &[Named]) -> Option<Compression> {
        let (specimen, loading) = (self.specimen(&named[0])?, self.loading());
        let fines = if self.flag("crushing.enabled") && self.text("crushing.lost_mass") == "points" {
            Some(Box::new(self.embedding(named, median(&specimen.gradation))?))
        } else {
            None
        };
        Some(Compression { specimen, loading, all_sides: false, fines })
    }

    /// The continuum of points from breakages in a specimen with median size `d50`, m; `None`, with the reasons noted, where it
    /// is refused.
    fn embedding(&self, named: &[Named], d50: f64) -> Option<Embedding> {
        let key = "crushing.lost_mass";
        self.check(
            self.flag("stepping.inertia_scaling"),
            key,
            "\"points\" needs stepping.inertia_scaling = true in an oedometer: both sides make the same steps",
        );
        let law = &named[0].key("continuum");
        if !self.has(law) {
            self.refuse(law, "is missing: with crushing.lost_mass = \"points\" the lost mass becomes a continuum and needs a constitutive law (law, E_MPa, nu …)");
            return None;
        }
        let cell = self.number("crushing.points_cell_mm").map_or(CELL * d50, |cell| cell * self.scale());
        self.check(
            CELLS.contains(&(cell / d50)),
            "crushing.points_cell_mm",
            format!(
                "must be between {} and {} of the specimen's d50 with its grain scale, {:.4} mm here",
                CELLS.start(),
                CELLS.end(),
                1e3 * d50
            ),
        );
        Some(Embedding {
            law: self.continuum(&named[0])?,
            porosity: self.si("crushing.points_porosity"),
            cell,
            release_strain: self.si("crushing.release_strain"),
        })
    }

    /// The load programme of the scene.
    pub fn loading(&self) -> Loading {
        let mut stages = vec![self.si("loading.max_stress_kPa")];
        stages.extend(self.numbers("loading.stages_kPa"));
        let loading = Loading {
            stages,
            rate: self.si("loading.rate"),
            sigma_ref: self.si("loading.sigma_ref_kPa"),
            load_increment: (self.text("loading.programme") == "adaptive").then(|| self.si("loading.pace")),
            max_inertial_number: self.si("loading.max_inertial_number"),
            max_lag: self.si("loading.max_lag"),
            max_wait: self.whole("loading.max_wait_steps").unwrap_or(u64::MAX),
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
