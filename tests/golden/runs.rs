//! The runs: each a second or two of what the program can do.

use super::{Run, check};

/// A small oedometer of coke, as the paper's.
macro_rules! coke {
    ($($more:literal),*) => {
        &["specimen.grains=100", "specimen.diameter_mm=80", "specimen.porosity=0.45", "loading.max_stress_kPa=1500", "records.at_kPa=[1000.0]", $($more),*]
    };
}

/// A small oedometer of coke without scaled inertia.
macro_rules! in_time {
    ($($more:literal),*) => {
        coke!("specimen.porosity=0.46", "loading.max_stress_kPa=700", "loading.rate=0.1", "records.at_kPa=[500.0]", "stepping.inertia_scaling=false", $($more),*)
    };
}

macro_rules! runs {
    ($backend:literal: $($name:ident: $scene:literal, $sets:expr;)*) => {
        $(#[test]
        fn $name() {
            check(&Run { name: stringify!($name), scene: $scene, sets: $sets, backend: $backend });
        })*
    };
}

runs! { "cpu":
    oedometer_hertz: "experiments/petroleum_coke/h-c-2.toml", coke!();
    oedometer_hertz_area: "experiments/petroleum_coke/h-v-2.toml", coke!("preparation.growth_friction=0.0", "loading.max_stress_kPa=2500");
    oedometer_linear: "experiments/petroleum_coke/l-c-2.toml", coke!("specimen.porosity=0.46");
    oedometer_linear_inherited: "experiments/petroleum_coke/l-c-2.toml", coke!("specimen.porosity=0.47", "contact.law=linear_inherited");
    oedometer_hertz_viscous: "experiments/petroleum_coke/h-c-2.toml", in_time!("contact.law=hertz_viscous", "loading.max_stress_kPa=300", "records.at_kPa=[200.0]");
    oedometer_hertz_viscous_no_tension: "experiments/petroleum_coke/h-c-2.toml",
        in_time!("contact.law=hertz_viscous_no_tension", "crushing.birth=gradual", "loading.max_stress_kPa=400", "records.at_kPa=[300.0]");
    oedometer_elasto_plastic: "experiments/petroleum_coke/h-c-2.toml",
        coke!("contact.law=elasto_plastic", "material.contact.yield_pressure_MPa=60", "contact.unloading=rescale", "crushing.birth=gradual");
    oedometer_mean_stress_and_weibull: "experiments/criteria/oedometer.toml",
        &["specimen.grains=100", "specimen.diameter_mm=80", "specimen.porosity=0.45", "crushing.criterion=mohr_coulomb", "loading.max_stress_kPa=6000", "records.at_kPa=[]"];
    oedometer_growing_daughters: "experiments/petroleum_coke/h-c-2.toml",
        coke!("specimen.porosity=0.46", "crushing.birth=gradual", "crushing.lost_mass=grow", "contact.unloading=rescale",
            "loading.control=strain", "loading.stages_kPa=[500.0, 1600.0]");
    oedometer_fines_as_points: "tests/golden/sand_oedometer.toml", &["loading.max_stress_kPa=3500", "loading.stages_kPa=[1800.0]"];
    triaxial: "experiments/fontainebleau/triaxial-h.toml",
        &["specimen.grains=300", "specimen.diameter_mm=10.3", "crushing.enabled=true", "loading.axial_strain=0.1", "specimen.isotropic_stress_kPa=2000", "loading.inertial_number=0.001"];
    isotropic: "experiments/isotropic/petroleum_coke.toml",
        &["specimen.grains=120", "specimen.diameter_mm=110", "specimen.porosity=0.45", "preparation.porosity_tolerance=0.02", "loading.max_stress_kPa=600",
            "loading.stages_kPa=[60, 700]", "records.at_kPa=[]"];
    single_grains: "experiments/platen/silica.toml", &["batch.grains=4", "batch.diameters_mm=[1.0, 2.0]"];
    two_materials_and_rolling: "tests/golden/two_materials.toml", &[];
    imported_packing: "experiments/free/imported_packing.toml", &[];
    continuum_flip: "experiments/mpm/triaxial_fine_small.toml", &[];
    continuum_apic: "experiments/mpm/triaxial_fine_small.toml", &["grid.pic=0", "grid.transfer=apic"];
    continuum_gimp: "experiments/mpm/triaxial_fine_small.toml", &["grid.shape_functions=gimp"];
    continuum_cylinder: "experiments/mpm/oedometer_cylinder.toml", &["test.axial_strain=0.002"];
    continuum_mohr_coulomb: "tests/golden/mohr_coulomb.toml", &[];
    plane_strain: "experiments/mpm/column_collapse_2d.toml", &["duration_s=0.1", "grid.cell_mm=10"];
    mixture_spheres: "experiments/mixture/triaxial_small.toml", &["test.axial_strain=0.002"];
    mixture_blocks: "tests/golden/blocks.toml", &[];
    blocks: "experiments/blocks/rocks.toml", &["duration_s=0.06"];
    blocks_in_plane: "experiments/jiang2020/disc_soft.toml", &["duration_s=0.014"];
    blocks_that_break: "experiments/blocks/crushed_cube.toml", &[];
    mixture_crushing: "experiments/mixture/oedometer_crushing.toml", &["test.axial_strain=0.01"];
    mixture_grown_with_fines: "experiments/mixture/coke_in_fines.toml", &["test.axial_strain=0.015"];
}

#[cfg(feature = "gpu")]
runs! { "gpu":
    gpu_continuum: "experiments/mpm/triaxial_fine_small.toml", &["test.axial_strain=0.001"];
    gpu_mixture: "tests/gpu/mixture.toml", &["test.axial_strain=0.0002", "stepping.safety=0.9"];
}
