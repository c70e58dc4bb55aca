//! Faces of points on which a grain presses, against f64.

use super::adapter;
use crate::contact::ContactLaw;
use crate::coupling::exchange::{ExchangedContact, ExchangedContacts};
use crate::coupling::{Cycle, Mixture, Parts, Rates, Rule};
use crate::dem::physics::Physics;
use crate::dem::{State, Workspace};
use crate::gpu::continuum::DeviceContinuum;
use crate::gpu::grains::CoarseGrains;
use crate::grains::Grains;
use crate::material::{InterfaceFriction, Material};
use crate::math::vector::{dot, less};
use crate::mpm::law::{Elastic, Law};
use crate::mpm::loading_plate::{self, LoadingPlate};
use crate::mpm::{Continuum, Dimension, GridWall, Point, Points, Settings, ShapeFunctions, Transfer};
use crate::point_contacts::{ActsOn, PointContactTable};

/// Edge of a cell, m; step of the grain, s; steps in a step of the continuum.
pub(super) const CELL: f64 = 0.1;
pub(super) const DT: f64 = 1e-4;
pub(super) const RATES: Rates = Rates { grains: 3, continuum: 1 };

/// A grain that moves askew in a block of points.
pub(super) struct Impact {
    pub physics: Physics,
    pub table: PointContactTable,
    pub work: Workspace,
    pub continuum: Continuum,
    pub mixture: Mixture,
    pub plates: Vec<LoadingPlate>,
}

impl Impact {
    /// `fines`: how lost mass becomes points.
    pub fn new(fines: Option<Rule>) -> Impact {
        let material = Material {
            name: "glass".into(),
            density: 2500.0,
            internal_porosity: 0.0,
            young: 2e6,
            poisson: 0.2,
            friction: 0.4,
            contact: [0.6, 0.0, 0.0, 0.0],
            rolling_friction: 0.0,
            // falls with the plastic strain that the points have from the start
            interface_friction: Some(InterfaceFriction { initial: 0.5, residual: 0.1, decay: 20.0 }),
        };
        let physics = Physics::of(vec![material], ContactLaw::Hertz);
        let settings = Settings {
            dimension: Dimension::Space,
            cell: CELL,
            lower: [0.0; 3],
            cells: [10; 3],
            walls: [GridWall::Open; 6],
            gravity: [0.0; 3],
            shape: ShapeFunctions::BSpline,
            transfer: Transfer::Blend { pic: 0.03 },
            damping: 0.0,
        };
        let mut points = Points::default();
        let (centre, radius) = ([0.503, 0.497, 0.455], 0.15);
        for k in 0..10 * 10 * 8 {
            let position = [k % 10, k / 10 % 10, k / 100].map(|n: i32| 0.275 + 0.05 * f64::from(n));
            // ghosts have a radius of 26 mm
            let away = less(position, centre);
            if dot(away, away).sqrt() < radius + 0.022 {
                continue;
            }
            points.add(&Point {
                position,
                velocity: [0.0; 3],
                mass: 0.25,
                volume: 1.25e-4,
                stress: [0.0; 6],
                porosity: 0.4,
                law: 0,
            });
            points.memory.last_mut().expect("a point").plastic = 0.02 * f64::from(k % 7);
        }
        let mut continuum = Continuum::new(settings, vec![Law::Elastic(Elastic::of_young(1e6, 0.3))], points).expect("allowed");
        let mut grains = Grains::default();
        grains.add(centre, radius, 0, &physics.materials);
        grains.vel[0][..3].copy_from_slice(&[0.4, 0.2, -2.0]);
        grains.spin[0][1] = 2.0;
        let mut state = State::new(&physics, grains, Vec::new(), false);
        let work = Workspace::new(&physics, &mut state);
        let table = PointContactTable::new(physics.contact.law, &[0], &physics.materials, &[]).acting_on(ActsOn::Face);
        let mixture = Mixture::new(&physics, state, &mut continuum, fines);
        Impact { physics, table, work, continuum, mixture, plates: Vec::new() }
    }

    /// Computes all forces on the processor.
    pub fn forces(&mut self) {
        let Impact { physics, table, work, continuum, mixture, plates } = self;
        loading_plate::press(plates, continuum).expect("no platen has passed a point");
        mixture.compute_forces(&mut Parts { physics, table, work, continuum, plates: &mut [] }).expect("forces");
    }

    /// Makes `n` cycles on the processor, from known forces to known forces.
    pub fn cycles(&mut self, n: u32) {
        for _ in 0..n {
            let time = DT * f64::from(RATES.grains);
            let Impact { physics, table, work, continuum, mixture, plates } = self;
            let mut parts = Parts { physics, table, work, continuum, plates };
            mixture.make_cycle(&mut parts, Cycle { time, rates: RATES }).expect("a cycle");
            self.forces();
        }
    }

    pub fn coarse(&self) -> CoarseGrains<'_> {
        CoarseGrains { physics: &self.physics, mixture: &self.mixture, table: &self.table }
    }

    /// Takes the state from the device.
    pub fn take(&mut self, gpu: &DeviceContinuum) {
        gpu.read_back(&mut self.continuum).expect("points");
        gpu.read_grains((&self.physics, &self.table), &mut self.mixture, &mut self.continuum).expect("grains");
    }

    /// Contacts of points with a face, by point.
    pub fn contacts(&self) -> Vec<ExchangedContact> {
        let ExchangedContacts { points, .. } = self.mixture.contacts(&self.physics, &self.work.table);
        let id = |c: &ExchangedContact| self.continuum.points().id[c.ends[1] as usize];
        let mut all: Vec<ExchangedContact> = points.into_iter().map(|(_, c)| ExchangedContact { ends: [0, id(&c)], ..c }).collect();
        all.sort_unstable_by_key(|c| c.ends);
        all
    }
}

pub(super) fn steps(gpu: &mut DeviceContinuum, n: u64) {
    gpu.rates(RATES.grains);
    gpu.steps(n, DT * f64::from(RATES.grains)).expect("steps");
}

/// A grain moves in a block with three steps to one of the points: faces move as on the processor, contacts that are apart and have a face stay known, and a
/// device that goes on from a saved state leaves the same bits. Measured: 24 contacts, 2 of them apart, faces that have moved by up to
/// 0.019 cells; off by 6e-9 cells, velocities by 2e-7 m/s, forces by 2e-7 of the largest.
#[test]
fn faces_move_as_on_the_processor() {
    if !adapter("faces_move_as_on_the_processor") {
        return;
    }
    const STEPS: u32 = 110;
    let mut here = Impact::new(None);
    here.forces();
    here.cycles(5);
    let begin = |of: &Impact, saved| DeviceContinuum::begin(&of.continuum, &[], &[], Some(&of.coarse()), saved).expect("device");
    let mut there = Impact { work: Workspace::new(&here.physics, &mut here.mixture.grains.clone()), ..Impact::new(None) };
    (there.continuum, there.mixture) = (here.continuum.clone(), here.mixture.clone());
    here.cycles(STEPS);
    let mut gpu = begin(&there, None);
    steps(&mut gpu, u64::from(STEPS) / 2);
    let saved = gpu.save().expect("state");
    let mut other = begin(&there, Some(&saved));
    for gpu in [&mut gpu, &mut other] {
        steps(gpu, u64::from(STEPS) / 2);
    }
    there.take(&other);
    let resumed = (there.contacts(), there.continuum.points().position.clone());
    there.take(&gpu);
    assert_eq!((there.contacts(), there.continuum.points().position.clone()), resumed);

    let (exact, found) = (here.contacts(), there.contacts());
    let face = |c: &ExchangedContact| c.face.expect("a contact of a point has one");
    let moved = exact.iter().map(|c| face(c).beyond.abs()).fold(0.0, f64::max) / CELL;
    let apart = exact.iter().filter(|c| c.touch.overlap == 0.0).count();
    println!("faces: {} contacts, {apart} of them apart, moved by up to {moved:e} cells", exact.len());
    assert!(exact.len() > 15 && apart > 0 && moved > 0.01);
    assert_eq!(exact.iter().map(|c| c.ends[1]).collect::<Vec<_>>(), found.iter().map(|c| c.ends[1]).collect::<Vec<_>>());
    let largest = |of: &dyn Fn(&ExchangedContact, &ExchangedContact) -> f64| {
        exact.iter().zip(&found).map(|(e, f)| of(e, f)).fold(0.0, f64::max)
    };
    let of_beyond = largest(&|e, f| (face(e).beyond - face(f).beyond).abs()) / CELL;
    let of_velocity = largest(&|e, f| (0..3).map(|a| (face(e).velocity[a] - face(f).velocity[a]).abs()).fold(0.0, f64::max));
    let strongest = exact.iter().map(|c| c.touch.normal_force).fold(0.0, f64::max);
    let of_force = largest(&|e, f| (e.touch.normal_force - f.touch.normal_force).abs()) / strongest;
    let of_friction =
        largest(&|e, f| (0..3).map(|a| (e.touch.tangential[a] - f.touch.tangential[a]).abs()).fold(0.0, f64::max)) / strongest;
    println!(
        "off by {of_beyond:e} cells, velocity {of_velocity:e} m/s, force {of_force:e} of the largest, tangential {of_friction:e}"
    );
    assert!(of_beyond < 1e-7 && of_velocity < 3e-6 && of_force < 3e-6 && of_friction < 3e-6);
    // friction of points of different plastic strain, on both sides, differs
    let sliding: Vec<f64> = exact
        .iter()
        .filter(|c| c.touch.normal_force > 0.0)
        .map(|c| c.touch.tangential.iter().map(|x| x * x).sum::<f64>().sqrt() / c.touch.normal_force)
        .collect();
    let least = sliding.iter().copied().fold(f64::INFINITY, f64::min);
    assert!(sliding.iter().any(|mu| *mu > 0.3) && least < 0.2, "{sliding:?}");
}
