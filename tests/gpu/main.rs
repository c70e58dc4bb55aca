//! The continuum on the graphics device against that of the CPU: whole tests within bands (rung 4 of parity), bits, and what is refused.
//!
//! Without an adapter these tests are skipped with a line that says so; with COMMINUTE_REQUIRE_GPU=1 they fail.
#![cfg(feature = "gpu")]

#[path = "../../src/engine/gpu/tests/adapter.rs"]
mod adapter;
#[path = "../../src/engine/gpu/tests/band.rs"]
mod band;
#[path = "../common/mod.rs"]
mod common;
mod laws;
mod mixture;
mod run;

use adapter::adapter;
use comminute::gpu;
use comminute::mpm::law::{Cone, DruckerPrager, Elastic, Evolution, Law, Parameters};
use comminute::mpm::{
    Continuum, Dimension, GridWall, LoadingPlate, PlateDrive, Point, Points, Ramp, Settings, ShapeFunctions, Transfer,
};
use std::f64::consts::PI;

fn settings(cell: f64, cells: [u32; 3]) -> Settings {
    Settings {
        dimension: Dimension::Space,
        cell,
        lower: [0.0; 3],
        cells,
        walls: [GridWall::Symmetry; 6],
        gravity: [0.0; 3],
        shape: ShapeFunctions::BSpline,
        transfer: Transfer::Blend { pic: 0.0 },
        damping: 0.0,
    }
}

/// Two points to a cell along each axis, from the corner on.
fn lattice(s: &Settings, cells: [u32; 3], density: f64, velocity: impl Fn([f64; 3]) -> [f64; 3]) -> Points {
    let spacing = 0.5 * s.cell;
    let mut points = Points::default();
    for k in 0..2 * cells[2] {
        for j in 0..2 * cells[1] {
            for i in 0..2 * cells[0] {
                let position: [f64; 3] = std::array::from_fn(|a| s.lower[a] + (f64::from([i, j, k][a]) + 0.5) * spacing);
                let volume = spacing.powi(3);
                let velocity = velocity(position);
                points.add(&Point { position, velocity, mass: density * volume, volume, stress: [0.0; 6], porosity: 0.4, law: 0 });
            }
        }
    }
    points
}

/// Li et al. 2023, eq. 43.
fn soil() -> Law {
    let degree = PI / 180.0;
    let friction = Evolution::CubicExponential {
        initial: 18.6 * degree,
        cubic: [1075.64, -407.93, 16.39, 0.32],
        peak_strain: 0.022,
        peak: 28.6 * degree,
        residual: 18.6 * degree,
        decay: 50.0,
    };
    Law::DruckerPrager(DruckerPrager::new(Parameters {
        cone: Cone::Outer,
        friction,
        cohesion: Evolution::Constant(0.0),
        dilation: 0.0,
        ..Parameters::of_elastic(Elastic::of_young(4.6e6, 0.12))
    }))
}

/// Rung 4. A bar, free at one end, in its first axial mode: E 100, ρ 1, L 5, period 2 s. Momentum and energies follow f64 over two periods.
#[test]
fn a_bar_vibrates_as_on_the_cpu() {
    if !adapter("a_bar_vibrates_as_on_the_cpu") {
        return;
    }
    let mut s = settings(0.5, [12, 1, 1]);
    s.walls[1] = GridWall::Open;
    let points = lattice(&s, [10, 1, 1], 1.0, |x| [0.1 * (PI * x[0] / 10.0).sin(), 0.0, 0.0]);
    let mut cpu = Continuum::new(s, vec![Law::Elastic(Elastic::of_young(100.0, 0.0))], points).unwrap();
    let mut gpu = gpu::DeviceContinuum::new(&cpu).unwrap();
    let mut back = cpu.clone();
    let (p, e) = (cpu.totals().momentum[0], cpu.totals().kinetic);
    let (mut in_momentum, mut in_energy, mut in_work): (f64, f64, f64) = (0.0, 0.0, 0.0);
    let mut crossed = 0;
    for _ in 0..16 {
        gpu.steps(25, 0.01).unwrap();
        (0..25).for_each(|_| cpu.step(0.01).unwrap());
        gpu.read_back(&mut back).unwrap();
        let (a, b) = (cpu.totals(), back.totals());
        in_momentum = in_momentum.max((a.momentum[0] - b.momentum[0]).abs() / p);
        in_energy = in_energy.max((a.kinetic - b.kinetic).abs() / e);
        in_work = in_work.max((cpu.stress_work() - back.stress_work()).abs() / e);
        crossed += u32::from(a.momentum[0] < 0.0);
        assert_eq!(cpu.steps(), back.steps());
    }
    println!(
        "rung 4, bar, 400 steps: momentum {in_momentum:e}, kinetic energy {in_energy:e}, stress work {in_work:e} of the start"
    );
    assert!(in_momentum < 1e-5 && in_energy < 1e-5 && in_work < 1e-5);
    assert!((4..12).contains(&crossed), "it swings");
}

/// A column of soil that slumps under its own weight on a rough floor.
fn slump() -> Continuum {
    let mut s = settings(0.1, [7, 3, 6]);
    s.walls = [
        GridWall::Symmetry,
        GridWall::Open,
        GridWall::Symmetry,
        GridWall::Symmetry,
        GridWall::Friction { friction: 0.4 },
        GridWall::Open,
    ];
    (s.gravity, s.transfer) = ([0.0, 0.0, -9.81], Transfer::Blend { pic: 0.02 });
    let points = lattice(&s, [3, 3, 5], 1800.0, |_| [0.0; 3]);
    Continuum::new(s, vec![soil()], points).unwrap()
}

/// Rung 4. A slump with eq. 43 of Li et al., 360 points: front, height, energies and forces after 200 steps follow f64.
#[test]
fn a_column_slumps_as_on_the_cpu() {
    if !adapter("a_column_slumps_as_on_the_cpu") {
        return;
    }
    let mut cpu = slump();
    let mut gpu = gpu::DeviceContinuum::new(&cpu).unwrap();
    let mut back = cpu.clone();
    let start = cpu.totals();
    let dt = cpu.stable_step(0.5);
    gpu.steps(200, dt).unwrap();
    (0..200).for_each(|_| cpu.step(dt).unwrap());
    gpu.read_back(&mut back).unwrap();
    let (a, b) = (cpu.totals(), back.totals());
    let front = |c: &Continuum| c.points().position.iter().map(|x| x[0]).fold(0.0, f64::max);
    let plastic = |c: &Continuum| c.points().memory.iter().map(|m| m.plastic).sum::<f64>() / c.points().len() as f64;
    let fallen = start.potential - a.potential;
    let in_fall = (a.potential - b.potential).abs() / fallen;
    let in_kinetic = (a.kinetic - b.kinetic).abs() / a.kinetic;
    let in_front = (front(&cpu) - front(&back)).abs() / 0.1;
    let in_plastic = (plastic(&cpu) - plastic(&back)).abs() / plastic(&cpu);
    let in_floor = (cpu.wall_force()[4][2] - back.wall_force()[4][2]).abs() / (9.81 * a.mass);
    println!(
        "rung 4, slump, 200 steps of {dt:e} s: fall {in_fall:e}, kinetic {in_kinetic:e}, front {in_front:e} cells of {:e}, plastic strain {in_plastic:e} of {:e}, floor {in_floor:e} of the weight",
        front(&cpu) - 0.275,
        plastic(&cpu)
    );
    assert!(front(&cpu) > 0.3 && plastic(&cpu) > 1e-3, "it has slumped");
    assert!(in_fall < 1e-5 && in_kinetic < 1e-5 && in_front < 1e-5 && in_plastic < 1e-5 && in_floor < 1e-5);
    assert_eq!((a.mass, cpu.steps()), (b.mass, back.steps()));
}

/// An elastic block, 0.5 m high, between smooth walls under a platen that is driven to a force: it comes to rest with that force on its floor, and shortens as
/// an oedometer, σ/M, M 13.46 MPa.
#[test]
fn a_platen_presses_a_block_to_its_stress() {
    if !adapter("a_platen_presses_a_block_to_its_stress") {
        return;
    }
    let mut s = settings(0.1, [2, 2, 7]);
    (s.walls[5], s.damping) = (GridWall::Open, 0.4);
    let points = lattice(&s, [2, 2, 5], 2000.0, |_| [0.0; 3]);
    let start = points.clone();
    let mut c = Continuum::new(s, vec![Law::Elastic(Elastic::of_young(10e6, 0.3))], points).unwrap();
    // the points' spheres just touch it
    let radius = (0.6 * 0.05_f64.powi(3) * 0.75 / PI).cbrt();
    let force = 1e5 * 0.2 * 0.2;
    let plate = LoadingPlate::new(&c, [0.1, 0.1, 0.475 + radius], [0.0, 0.0, -1.0], 2e8);
    let mut device = gpu::DeviceContinuum::with_plates(&c, &[plate]).unwrap();
    device.material([0.2, 0.2, 0.5], [false; 2]);
    device.drive(0, PlateDrive::Stress { target: Ramp::constant(1e5), gain: 0.1, reach: 1.0, memory: f64::INFINITY }).unwrap();
    let dt = 0.3 * c.stable_step(1.0);
    device.steps(1500, dt).unwrap();
    device.read_back(&mut c).unwrap();
    let p = &device.plates()[0];
    let floor = c.wall_force()[4][2];
    let at = |points: &Points, k: u32| points.position[points.id.iter().position(|id| *id == k).unwrap()][2];
    let top = start.len() as u32 - 1;
    let shortening = at(&start, top) - at(c.points(), top) - (at(&start, 0) - at(c.points(), 0));
    let strain = shortening / (at(&start, top) - at(&start, 0));
    // 1e5 Pa over 13.461538 MPa; Cauchy stress against the logarithm of the height
    let exact = 1.0 - (-1e5_f64 / 13.461_538e6).exp();
    println!(
        "platen: reaction {:e}, floor {:e} of the target, strain {:e}; dt {dt:e} s of {:e} s",
        p.reaction / force - 1.0,
        floor / force - 1.0,
        strain / exact - 1.0,
        2.0 / p.rate.sqrt()
    );
    assert!((p.reaction / force - 1.0).abs() < 5e-3 && (floor / force - 1.0).abs() < 5e-3 && (strain / exact - 1.0).abs() < 0.01);
    // what the platen did is in its contacts, the block and, a twentieth, the damping
    let balance = (p.work - p.stored) / c.stress_work() - 1.0;
    println!("platen: work {:e} J, stored {:e} J, stress work {:e} J, balance {balance:e}", p.work, p.stored, c.stress_work());
    assert!(c.stress_work() > 0.0 && p.stored > 0.0 && balance.abs() < 0.1);
    assert!(device.drive(1, PlateDrive::Speed(Ramp::constant(0.0))).is_err());
}

/// Two batches are one. What was read back and taken up again goes on the same but for the rounding of f64 places and volumes.
#[test]
fn batches_change_no_bit() {
    if !adapter("batches_change_no_bit") {
        return;
    }
    let start = slump();
    let dt = start.stable_step(0.5);
    let run = |parts: &[u64], through_cpu: bool| {
        let mut gpu = gpu::DeviceContinuum::new(&start).unwrap();
        let mut back = start.clone();
        for &n in parts {
            gpu.steps(n, dt).unwrap();
            gpu.read_back(&mut back).unwrap();
            if through_cpu {
                gpu = gpu::DeviceContinuum::new(&back).unwrap();
            }
        }
        back
    };
    let whole = run(&[60], false);
    let parts = run(&[13, 47], false);
    assert!(whole.points() == parts.points() && whole.wall_force() == parts.wall_force());
    let again = run(&[13, 47], true);
    assert_eq!(again.steps(), 60);
    let (p, q) = (whole.points(), again.points());
    let apart = (0..p.len()).flat_map(|i| (0..3).map(move |a| (i, a))).map(|(i, a)| (p.position[i][a] - q.position[i][a]).abs());
    let apart = apart.fold(0.0, f64::max);
    println!("taken up again: {apart:e} m apart after 47 steps");
    assert!(apart < 1e-9);
}

/// The bits of a run, for [`threads_change_no_bit`], in the file of that name.
#[test]
fn bits_of_a_run() {
    let Some(path) = std::env::var_os("COMMINUTE_TEST_BITS") else { return };
    let mut c = slump();
    let dt = c.stable_step(0.5);
    let mut gpu = gpu::DeviceContinuum::new(&c).unwrap();
    gpu.steps(80, dt).unwrap();
    gpu.read_back(&mut c).unwrap();
    std::fs::write(path, serde_json::to_vec(&c).unwrap()).unwrap();
}

fn again(test: &str, environment: &[(&str, &std::path::Path)]) -> std::process::Output {
    let mut command = std::process::Command::new(std::env::current_exe().unwrap());
    command.args([test, "--exact", "--nocapture"]).envs(environment.iter().copied());
    command.output().unwrap()
}

/// LP_NUM_THREADS is the number of threads of the software adapter.
#[test]
fn threads_change_no_bit() {
    if !adapter("threads_change_no_bit") {
        return;
    }
    let dir = tempfile::tempdir().unwrap();
    let bits = ["1", "2"].map(|threads| {
        let path = dir.path().join(threads);
        let output = again("bits_of_a_run", &[("COMMINUTE_TEST_BITS", &path), ("LP_NUM_THREADS", threads.as_ref())]);
        assert!(output.status.success(), "{output:?}");
        std::fs::read(path).unwrap()
    });
    assert!(bits[0].len() > 10_000);
    assert!(bits[0] == bits[1]);
}

#[test]
fn what_the_gpu_lacks_is_refused_by_name() {
    let told = |change: &dyn Fn(&mut Settings)| {
        let mut s = settings(0.1, [4, 4, 4]);
        change(&mut s);
        let points = lattice(&s, [2, 2, 1], 1000.0, |_| [0.0; 3]);
        let cpu = Continuum::new(s, vec![soil()], points).unwrap();
        let error = gpu::DeviceContinuum::new(&cpu).err().expect("refused");
        let error = comminute::error::Error::from(error);
        assert_eq!(error.exit_code(), 2);
        error.to_string()
    };
    let plane = told(&|s| s.dimension = Dimension::PlaneStrain);
    assert_eq!(plane, "gpu: grid.plane_strain = true: is not available on the GPU: use the processor");
    let gimp = told(&|s| s.shape = ShapeFunctions::Gimp { half_width: 0.25 });
    assert!(gimp.contains("grid.shape_functions = gimp"), "{gimp}");
    let affine = told(&|s| s.transfer = Transfer::Affine);
    assert!(affine.contains("grid.transfer = apic"), "{affine}");
    let two = told(&|s| (s.dimension, s.transfer) = (Dimension::PlaneStrain, Transfer::Affine));
    assert!(two.contains("grid.plane_strain") && two.contains("grid.transfer"), "{two}");
}

#[test]
fn a_grid_that_does_not_fit_is_refused_with_its_size() {
    if !adapter("a_grid_that_does_not_fit_is_refused_with_its_size") {
        return;
    }
    if !gpu::available().expect("an adapter").software {
        println!("graphics hardware has room for the largest grids that there may be");
        return;
    }
    let s = settings(0.1, [1900, 1900, 900]);
    let points = lattice(&s, [2, 2, 1], 1000.0, |_| [0.0; 3]);
    let cpu = Continuum::new(s, vec![soil()], points).unwrap();
    let told = gpu::DeviceContinuum::new(&cpu).err().expect("refused").to_string();
    assert!(told.contains("memory of the cells") && told.contains("MiB") && told.contains("use a smaller domain"), "{told}");
}

/// The same words as on the CPU, with the same step and point.
#[test]
fn lost_points_are_named() {
    if !adapter("lost_points_are_named") {
        return;
    }
    let elastic = || vec![Law::Elastic(Elastic::of_young(1e6, 0.3))];
    let told = |velocity: &dyn Fn([f64; 3]) -> [f64; 3]| {
        let mut s = settings(0.1, [10; 3]);
        s.walls = [GridWall::Open; 6];
        let points = lattice(&s, [2, 2, 2], 1000.0, velocity);
        let mut cpu = Continuum::new(s, elastic(), points).unwrap();
        let mut gpu = gpu::DeviceContinuum::new(&cpu).unwrap();
        let there = gpu.steps(300, 1e-3).unwrap_err().to_string();
        let here = (0..300).find_map(|_| cpu.step(1e-3).err()).expect("lost").to_string();
        (here, there)
    };
    let (here, there) = told(&|_| [-0.7, 0.0, 0.0]);
    assert_eq!(here, there);
    assert!(there.contains("has left the grid"), "{there}");
    let (here, there) = told(&|_| [300.0, 0.0, 0.0]);
    assert_eq!(here, there);
    assert!(there.contains("more than one cell"), "{there}");
    let (_, there) = told(&|_| [1e38, 1e38, 0.0]);
    assert!(there.starts_with("step 1: point 0 "), "{there}");
}

/// Without a driver: no adapter, said at once and clearly.
#[test]
fn without_an_adapter() {
    if std::env::var_os("COMMINUTE_TEST_NO_ADAPTER").is_none() {
        if cfg!(target_os = "linux") {
            let none = std::path::Path::new("/nowhere.json");
            let environment = [("COMMINUTE_TEST_NO_ADAPTER", none), ("VK_DRIVER_FILES", none), ("VK_ICD_FILENAMES", none)];
            let output = again("without_an_adapter", &environment);
            assert!(output.status.success(), "{output:?}");
        }
        return;
    }
    assert_eq!(gpu::available(), None);
    let told = gpu::DeviceContinuum::new(&slump()).err().expect("refused").to_string();
    assert!(told.contains("found no graphics adapter") && told.contains("use the processor"), "{told}");
}

#[test]
fn the_bench_measures_the_device() {
    if !adapter("the_bench_measures_the_device") {
        return;
    }
    let few =
        ["bench", "mpm", "--gpu", "--points", "64", "--threads", "1", "--steps", "2", "--repeats", "1", "--warm-up", "0", "--json"];
    let output = assert_cmd::Command::cargo_bin("comminute").unwrap().args(few).assert().success().get_output().stdout.clone();
    let json: serde_json::Value = serde_json::from_slice(&output).unwrap();
    assert_eq!(json["gpu"][0]["points"], 64);
    assert!(json["gpu"][0]["bytes_per_point"].as_f64().unwrap() > 150.0);
}
