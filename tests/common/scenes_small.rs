//! Scenes that run in a second.

/// A hundred grains of coke, weak enough to crush below 60 kPa; `root` is the folder of the repository.
pub fn crushes(root: &str) -> String {
    format!(
        "base = \"{root}/experiments/petroleum_coke/h-c-2.toml\"\nname = \"small\"\n[specimen]\nscale = 4.0\ngrains = 100\nporosity = 0.48\n\
         [preparation]\ngrowth_friction = 0.4\ngrowth_steps = 1000\nporosity_tolerance = 0.05\nmax_steps = 30000\n\
         [loading]\nmax_stress_kPa = 60.0\nprogramme = \"adaptive\"\nsettle_steps = 100\n\
         [records]\nat_kPa = []\nfigures = false\nsnapshots = false\n\
         [material]\nbase = \"{root}/materials/petroleum_coke.toml\"\n[material.strength.fixed_angle]\nsigma_lim0_MPa = 30.0\n"
    )
}
