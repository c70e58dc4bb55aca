//! The material point method's speed: an elastic cube, eight points per cell, with gravity and
//! shearing velocities at the start, on smooth walls.

use super::speed::cpu_seconds;
use super::{load_average, pool};
use engine::mpm::law::{Elastic, Law};
use engine::mpm::{Continuum, Dimension, GridWall, Point, Points, Settings, ShapeFunctions, Transfer};
use laboratory::error::Result;
use std::time::Instant;
use table::median;

/// Edge of a cell, m; density, kg/m³; Young's modulus, Pa, and Poisson's ratio; time step over the
/// largest stable one.
const CELL: f64 = 0.1;
const DENSITY: f64 = 2000.0;
const ELASTIC: (f64, f64) = (10e6, 0.3);
const SAFETY: f64 = 0.3;

/// Measured speed of the material point method.
#[derive(Clone, Debug)]
pub struct MpmSpeed {
    /// Number of points.
    pub points: usize,
    /// Number of threads.
    pub threads: usize,
    /// Point-steps per second of each block.
    pub blocks: Vec<f64>,
    /// Point-steps per second of processor time of each block; empty where the system does not
    /// tell.
    pub cpu_blocks: Vec<f64>,
    /// Memory for each point with its share of the grid, bytes.
    pub bytes_per_point: f64,
    /// Hash of every position, velocity and stress in the order of ids.
    pub hash: u64,
    /// Load average of the last minute before and after, where the system tells.
    pub load: [Option<f64>; 2],
}

impl MpmSpeed {
    /// Median point-steps per second.
    pub fn median(&self) -> f64 {
        median(&self.blocks)
    }

    /// Median point-steps per second of processor time; `None` where the system does not tell.
    pub fn cpu_median(&self) -> Option<f64> {
        (!self.cpu_blocks.is_empty()).then(|| median(&self.cpu_blocks))
    }
}

/// A cube of at least `points` points in its domain, and its time step.
///
/// # Errors
/// None: the case is sound.
pub fn mpm_case(points: usize, transfer: Transfer) -> Result<(Continuum, f64)> {
    let mut edge = 2;
    while edge * edge * edge < points {
        edge += 2;
    }
    let cells = (edge / 2 + 6) as u32;
    let settings = Settings {
        dimension: Dimension::Space,
        cell: CELL,
        lower: [0.0; 3],
        cells: [cells; 3],
        walls: [GridWall::Symmetry; 6],
        gravity: [0.0, 0.0, -9.81],
        shape: ShapeFunctions::BSpline,
        transfer,
        damping: 0.0,
    };
    let spacing = 0.5 * CELL;
    let volume = spacing * spacing * spacing;
    let at = |k: usize| spacing * (k as f64 + 0.5);
    let mut points = Points::default();
    for n in 0..edge * edge * edge {
        let position = [at(n % edge), at(n / edge % edge), at(n / (edge * edge))];
        let velocity = [0.3 * position[2], 0.1 * position[0], 0.2 * position[1]];
        points.add(&Point { position, velocity, mass: DENSITY * volume, volume, stress: [0.0; 6], porosity: 0.4, law: 0 });
    }
    let c = Continuum::new(settings, vec![Law::Elastic(Elastic::of_young(ELASTIC.0, ELASTIC.1))], points)?;
    let dt = c.stable_step(SAFETY);
    Ok((c, dt))
}

/// Steps `points` points on `threads` threads: `repeats` blocks of `steps` steps after `warm_up`.
///
/// # Errors
/// Threads that cannot be started, or a lost point.
pub fn mpm_speed(
    points: usize,
    transfer: Transfer,
    threads: usize,
    [warm_up, steps]: [u64; 2],
    repeats: usize,
) -> Result<MpmSpeed> {
    pool(threads)?.install(|| {
        let before = load_average();
        let (mut c, dt) = mpm_case(points, transfer)?;
        let count = c.points().len();
        let run = |c: &mut Continuum, n: u64| (0..n).try_for_each(|_| c.step(dt));
        run(&mut c, warm_up)?;
        let (mut blocks, mut cpu_blocks) = (Vec::new(), Vec::new());
        for _ in 0..repeats {
            let (since, cpu) = (Instant::now(), cpu_seconds());
            run(&mut c, steps)?;
            let point_steps = count as f64 * steps as f64;
            blocks.push(point_steps / since.elapsed().as_secs_f64());
            cpu_blocks.extend(cpu.zip(cpu_seconds()).map(|(from, to)| point_steps / (to - from)));
        }
        let bytes_per_point = c.bytes() as f64 / count as f64;
        Ok(MpmSpeed { points: count, threads, blocks, cpu_blocks, bytes_per_point, hash: hash(&c), load: [before, load_average()] })
    })
}

fn hash(c: &Continuum) -> u64 {
    let p = c.points();
    let mut h = 0xcbf2_9ce4_8422_2325_u64;
    for i in p.by_id() {
        let i = i as usize;
        for x in p.position[i].iter().chain(&p.velocity[i]).chain(&p.stress[i]) {
            for byte in x.to_bits().to_le_bytes() {
                h = (h ^ u64::from(byte)).wrapping_mul(0x0100_0000_01b3);
            }
        }
    }
    h
}
