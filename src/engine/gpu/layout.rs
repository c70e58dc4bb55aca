//! Structs that the shaders read and write, with the same fields at the same offsets. What the fields are is said with the structs of the same names in
//! `params.wgsl`, `loading_plates.wgsl` and `nodes.wgsl`; a test compares the offsets.

use super::blocks::Blocks;
use super::bounds::{BLOCK, BORDERS, GROUP, PLATES, WIDE};
use crate::mpm::law::dilatancy::Dilatancy;
use crate::mpm::law::{CamClay, Cone, Dilation, Evolution, Law, Parameters};
use crate::mpm::{GridWall, PlateDrive, Ramp, Settings, Transfer};
use bytemuck::{Pod, Zeroable};

/// In place of infinity, which shaders need not have.
pub const HUGE: f64 = 1e30;

/// What stays the same during one batch of steps.
#[repr(C)]
#[derive(Clone, Copy, Debug, Default, PartialEq, Pod, Zeroable)]
pub struct Params {
    pub size: [i32; 3],
    pub points: u32,
    pub gravity: [f32; 3],
    pub dt: f32,
    pub cell: f32,
    pub inverse_cell: f32,
    pub pic: f32,
    pub damping: f32,
    pub mass_floor: f32,
    pub zero: u32,
    pub cells: u32,
    pub share: u32,
    pub cell_groups: u32,
    pub overlaps: f32,
    pub point_groups: [u32; 2],
    pub steps: u32,
    pub unused: u32,
    pub plates: u32,
    pub safety: f32,
    pub extents: [f32; 3],
    pub follows: f32,
    pub blocks: [i32; 3],
    pub block_count: u32,
    pub slots: u32,
    pub stride: u32,
    pub pairs: u32,
    pub unused_too: u32,
    pub walls: [[u32; 4]; BORDERS],
    pub drives: [PlateDrive32; PLATES],
}

/// How a loading plate moves.
#[repr(C)]
#[derive(Clone, Copy, Debug, Default, PartialEq, Pod, Zeroable)]
pub struct PlateDrive32 {
    pub kind: u32,
    pub value: f32,
    pub slope: f32,
    pub end: f32,
    pub gain: f32,
    pub reach: f32,
    pub memory: f32,
    pub unused: f32,
}

impl From<PlateDrive> for PlateDrive32 {
    fn from(drive: PlateDrive) -> PlateDrive32 {
        let ramp =
            |r: Ramp| PlateDrive32 { value: r.value as f32, slope: r.slope as f32, end: r.end as f32, ..PlateDrive32::default() };
        match drive {
            PlateDrive::Speed(speed) => ramp(speed),
            PlateDrive::Stress { target, gain, reach, memory } => {
                PlateDrive32 { kind: 1, gain: gain as f32, reach: reach as f32, memory: (1.0 / memory) as f32, ..ramp(target) }
            }
        }
    }
}

/// State of a loading plate; pairs are compensated sums.
#[repr(C)]
#[derive(Clone, Copy, Debug, Default, PartialEq, Pod, Zeroable)]
pub struct LoadingPlate32 {
    pub axis: u32,
    pub normal: f32,
    pub cell: i32,
    pub units: i32,
    pub rest: f32,
    pub modulus: f32,
    pub speed: f32,
    pub moved: f32,
    pub reaction: f32,
    pub stiffness: f32,
    pub stored: f32,
    pub rate: f32,
    pub work: [f32; 2],
    pub drift: f32,
    pub overlap: f32,
    pub way: f32,
    pub face: f32,
    pub ways: [f32; 2],
    pub overlaps: [f32; 2],
    pub reactions: [f32; 2],
    pub centre_cell: [i32; 2],
    pub centre_units: [i32; 2],
    pub centre_rest: [f32; 2],
    pub shell: u32,
    pub split: u32,
}

/// State of a batch: the first part of the buffer `batch`, before the forces on points.
#[repr(C)]
#[derive(Clone, Copy, Debug, Default, PartialEq, Pod, Zeroable)]
pub struct BatchState {
    pub time: [f32; 2],
    pub dt: f32,
    pub count: u32,
    pub sides: [[f32; 2]; BORDERS],
    pub plates: [LoadingPlate32; PLATES],
}

impl Params {
    /// Everything but the time step and the drives. `lightest`: mass of the lightest point, kg. Sizes must have been checked before.
    pub fn of(settings: &Settings, blocks: &Blocks, points: usize, lightest: f64) -> Params {
        let size = settings.cells.map(|n| n as i32);
        let cells = BLOCK as u32 * blocks.slots;
        Params {
            size,
            points: points as u32,
            gravity: settings.gravity.map(|g| g as f32),
            cell: settings.cell as f32,
            inverse_cell: (1.0 / settings.cell) as f32,
            pic: if let Transfer::Blend { pic } = settings.transfer { pic as f32 } else { 1.0 },
            damping: settings.damping as f32,
            mass_floor: (1e-12 * lightest) as f32,
            cells,
            share: share(cells),
            cell_groups: cell_groups(cells),
            blocks: blocks.along.map(|n| n as i32),
            block_count: blocks.count(),
            slots: blocks.slots,
            stride: 1,
            pairs: blocks.slots / 2,
            point_groups: groups(points as u32),
            walls: settings.walls.map(wall),
            ..Params::default()
        }
    }
}

/// Cells of a thread of `find_starts`, whose workgroups have [`WIDE`] threads each: at most 1024 workgroups, each of which adds up the points of all before it.
pub fn share(cells: u32) -> u32 {
    cells.div_ceil(1024 * WIDE as u32)
}

/// Number of groups of cells with a common sum, and of workgroups of `find_starts`.
pub fn cell_groups(cells: u32) -> u32 {
    cells.div_ceil(share(cells) * WIDE as u32)
}

/// Numbers of workgroups of [`GROUP`] threads along x and y for at least so many threads.
pub fn groups(threads: u32) -> [u32; 2] {
    rows(threads.div_ceil(GROUP as u32).max(1))
}

/// Numbers along x and y of at least so many workgroups.
pub fn rows(workgroups: u32) -> [u32; 2] {
    const MOST: u32 = 32_768;
    let y = workgroups.div_ceil(MOST).max(1);
    [workgroups.div_ceil(y), y]
}

/// Kind of the wall on each side of the domain.
pub fn wall_kinds(settings: &Settings) -> [u32; BORDERS] {
    settings.walls.map(|side| wall(side)[0])
}

/// Number of nodes in the planes of all walls, for a domain of so many cells with walls of these kinds.
pub fn nodes_on_walls(cells: [u32; 3], kinds: &[u32; BORDERS]) -> u64 {
    let in_plane = |axis: usize| [1, 2].map(|k| u64::from(cells[(axis + k) % 3]) + 3).iter().product::<u64>();
    (0..BORDERS).filter(|side| kinds[*side] != 0).map(|side| in_plane(side / 2)).sum()
}

/// Kind of a wall with friction in the parameters of the shaders, where 0 is none.
pub const RUBS: u32 = 3;

fn wall(wall: GridWall) -> [u32; 4] {
    match wall {
        GridWall::Open => [0; 4],
        GridWall::Symmetry => [1, 0, 0, 0],
        GridWall::Stick => [2, 0, 0, 0],
        GridWall::Friction { friction } => [RUBS, (friction as f32).to_bits(), 0, 0],
    }
}

/// How a parameter follows the plastic strain.
#[repr(C)]
#[derive(Clone, Copy, Debug, Default, PartialEq, Pod, Zeroable)]
pub struct Evolution32 {
    pub kind: u32,
    pub initial: f32,
    pub last: f32,
    pub strain: f32,
    pub cubic: [f32; 4],
    pub peak_strain: f32,
    pub peak: f32,
    pub residual: f32,
    pub decay: f32,
}

impl From<Evolution> for Evolution32 {
    fn from(evolution: Evolution) -> Evolution32 {
        let none = Evolution32::default();
        match evolution {
            Evolution::Constant(value) => Evolution32 { last: value as f32, ..none },
            Evolution::Linear { initial, last, strain } => {
                Evolution32 { kind: 1, initial: initial as f32, last: last as f32, strain: strain as f32, ..none }
            }
            Evolution::CubicExponential { initial, cubic, peak_strain, peak, residual, decay } => Evolution32 {
                kind: 2,
                initial: initial as f32,
                cubic: cubic.map(|c| c as f32),
                peak_strain: peak_strain as f32,
                peak: peak as f32,
                residual: residual as f32,
                decay: decay as f32,
                ..none
            },
        }
    }
}

/// Constants of Modified Cam-clay; names as in `mpm::law::cam_clay`. `shear_ratio` is 0 where the shear modulus stays.
#[repr(C)]
#[derive(Clone, Copy, Debug, Default, PartialEq, Pod, Zeroable)]
pub struct Clay32 {
    pub slope: f32,
    pub swelling_slope: f32,
    pub ratio: f32,
    pub per_plastic: f32,
    pub preconsolidation: f32,
    pub virgin_volume: f32,
    pub shear_ratio: f32,
    pub unused: f32,
}

impl From<&CamClay> for Clay32 {
    fn from(law: &CamClay) -> Clay32 {
        let clay = law.clay();
        Clay32 {
            slope: law.critical_slope() as f32,
            swelling_slope: clay.swelling_slope as f32,
            ratio: law.ratio() as f32,
            per_plastic: law.per_plastic() as f32,
            preconsolidation: clay.preconsolidation as f32,
            virgin_volume: clay.virgin_volume as f32,
            shear_ratio: law.shear_ratio().unwrap_or(0.0) as f32,
            unused: 0.0,
        }
    }
}

/// A law's parameters; names as in `mpm::law`.
#[repr(C)]
#[derive(Clone, Copy, Debug, Default, PartialEq, Pod, Zeroable)]
pub struct Law32 {
    pub kind: u32,
    pub cone: u32,
    pub bulk: f32,
    pub shear: f32,
    pub volume_return: f32,
    pub per_multiplier: f32,
    pub cut: f32,
    pub settled: f32,
    pub last_alpha: f32,
    pub last_kappa: f32,
    pub sin_friction: f32,
    pub sin_dilation: f32,
    pub strength: f32,
    pub apex: f32,
    pub critical: f32,
    pub dilation_factor: f32,
    pub friction: Evolution32,
    pub cohesion: Evolution32,
    pub clay: Clay32,
}

/// Of dilation that ends: slope of the cone at the critical state, and slope of the potential per slope above it; zeros where dilation stays.
fn dilation(p: &Parameters, cone: Cone) -> [f32; 2] {
    Dilatancy::of(p, cone).map_or([0.0; 2], |d| [d.critical, d.factor].map(|x| x as f32))
}

impl From<&Law> for Law32 {
    /// Of a law that shaders have ([`Law::on_gpu`]).
    fn from(law: &Law) -> Law32 {
        let elastic = law.elastic();
        let moduli = Law32 { bulk: elastic.bulk as f32, shear: elastic.shear as f32, ..Law32::default() };
        let law = match law {
            Law::Elastic(_) => return moduli,
            Law::CamClay(law) => return Law32 { kind: 3, clay: law.into(), ..moduli },
            Law::DruckerPrager(law) => law,
            Law::MohrCoulomb(law) => {
                let ([sin_friction, sin_dilation], (inside, cut)) = (law.sines().map(|s| s as f32), law.inscribed());
                let p = law.parameters();
                let [critical, dilation_factor] = dilation(p, Cone::Outer);
                return Law32 {
                    kind: 2,
                    cut: cut.min(HUGE) as f32,
                    settled: p.friction.settled().max(p.cohesion.settled()) as f32,
                    last_alpha: inside.alpha as f32,
                    last_kappa: inside.kappa as f32,
                    critical,
                    dilation_factor,
                    friction: p.friction.into(),
                    cohesion: p.cohesion.into(),
                    sin_friction,
                    sin_dilation,
                    strength: law.strength() as f32,
                    apex: law.apex().min(HUGE) as f32,
                    ..moduli
                };
            }
        };
        let p = law.parameters();
        let [critical, dilation_factor] = dilation(p, p.cone);
        // dilation that ends but never begins is none
        let none = p.dilation_rule == Dilation::Mobilised && dilation_factor == 0.0;
        let alpha_psi = if none { 0.0 } else { p.cone.at(p.dilation).alpha };
        let last = law.strength(f64::INFINITY);
        Law32 {
            kind: 1,
            cone: match p.cone {
                Cone::Outer => 0,
                Cone::Inner => 1,
                Cone::PlaneStrain => 2,
            },
            volume_return: (9.0 * elastic.bulk * alpha_psi) as f32,
            per_multiplier: (1.0 / 3.0 + 2.0 * (alpha_psi * alpha_psi)).sqrt() as f32,
            cut: (3.0 * p.tension).min(HUGE) as f32,
            settled: p.friction.settled().max(p.cohesion.settled()) as f32,
            last_alpha: last.alpha as f32,
            last_kappa: last.kappa as f32,
            critical,
            dilation_factor,
            friction: p.friction.into(),
            cohesion: p.cohesion.into(),
            ..moduli
        }
    }
}

/// Status of a batch.
#[repr(C)]
#[derive(Clone, Copy, Debug, PartialEq, Pod, Zeroable)]
pub struct Status {
    /// The smallest 8 · identity + fault over all points with a fault; all bits set where there is none.
    pub fault: u32,
    pub crossed: u32,
    pub steps: u32,
    pub stop: u32,
    pub fastest: u32,
    pub slots: u32,
    pub unused: [u32; 2],
    pub reaction: [[f32; 4]; BORDERS],
}

impl Default for Status {
    fn default() -> Status {
        Status {
            fault: u32::MAX,
            crossed: 0,
            steps: 0,
            stop: 0,
            fastest: 0,
            slots: 0,
            unused: [0; 2],
            reaction: [[0.0; 4]; BORDERS],
        }
    }
}
