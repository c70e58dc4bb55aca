//! Balls that meet balls of points.

use crate::common::{Ball, Stuff, model};
use crate::points::{continuum, elastic, settings};
use comminute::coupling::{Allowed, Cycle, Mixture, Parts, Rates, Rule};
use comminute::dem::Workspace;
use comminute::model::{Model, Rig};
use comminute::mpm::{Continuum, Dimension, LoadingPlate, Points, loading_plate};
use comminute::point_contacts::PointContactTable;
use comminute::rig::assembly;
use std::f64::consts::PI;

/// The balls of Li et al. 2023, section 3.1 and Table 1: mass 0.3351 kg each, E = 1 GPa, ν = 0.2, μ = 0.8.
pub const STUFF: Stuff = Stuff { young: 1e9, poisson: 0.2, density: 2000.0, friction: 0.8, restitution: 1.0 };
pub const MASS: f64 = 0.3351;

/// Radius of such a ball, m.
pub fn radius() -> f64 {
    (MASS / STUFF.density * 0.75 / PI).cbrt()
}

/// Grains and a continuum, ready to go.
pub struct Meeting {
    pub model: Model,
    pub table: PointContactTable,
    pub work: Workspace,
    pub continuum: Continuum,
    pub mixture: Mixture,
    /// At rest; none by itself.
    pub plates: Vec<LoadingPlate>,
}

/// `text` is a free scene of grains; ghosts are of its first material.
pub fn meeting(text: &str, continuum: Continuum) -> Meeting {
    with_fines(text, continuum, None)
}

/// The same, where the mass that breakages lose becomes points.
pub fn with_fines(text: &str, mut continuum: Continuum, fines: Option<Rule>) -> Meeting {
    let model = model(text, &[]);
    let Rig::Assembly(rig) = &model.rig else { panic!("a free scene") };
    let mut state = assembly::start(&model, rig);
    let work = Workspace::new(&model.physics, &mut state);
    let table = PointContactTable::new(model.physics.contact.law, &[0], &model.physics.materials, &state.walls);
    let mixture = Mixture::new(&model.physics, state, &mut continuum, fines);
    Meeting { model, table, work, continuum, mixture, plates: Vec::new() }
}

impl Meeting {
    /// So many cycles, each of `time` seconds.
    pub fn go(&mut self, time: f64, rates: Rates, cycles: u64) {
        for _ in 0..cycles {
            self.cycle(|_, _| Cycle { time, rates });
        }
    }

    /// Cycles as long as they may be, for a time, s; answers the rates of the last one.
    pub fn run(&mut self, duration: f64, safety: f64, rates: Option<Rates>) -> Rates {
        let mut time = 0.0;
        while time < duration {
            self.cycle(|mixture, continuum| {
                let (grains, contacts) = mixture.bounds(continuum, &[], false);
                Cycle::longest(&Allowed { grains, continuum: continuum.stable_step(safety), contacts, safety, nearly: 1.0, rates })
            });
            time += self.mixture.cycle.time;
        }
        self.mixture.cycle.rates
    }

    fn cycle(&mut self, decide: impl FnOnce(&mut Mixture, &Continuum) -> Cycle) {
        let Meeting { model, table, work, continuum, mixture, plates } = self;
        loading_plate::press(plates, continuum).unwrap_or_else(|e| panic!("{e}"));
        let mut parts = Parts { physics: &model.physics, table, work, continuum, plates };
        mixture.compute_forces(&mut parts).unwrap_or_else(|e| panic!("{e}"));
        let cycle = decide(mixture, parts.continuum);
        mixture.make_cycle(&mut parts, cycle).unwrap_or_else(|e| panic!("{e}"));
    }

    pub fn velocity_of_points(&self) -> [f64; 3] {
        let totals = self.continuum.totals();
        totals.momentum.map(|p| p / totals.mass)
    }

    pub fn velocity_of_grain(&self) -> [f64; 3] {
        let [x, y, z, _] = self.mixture.grains.grains.vel[0];
        [x, y, z]
    }
}

/// A ball that comes down on a ball of points at rest, one or some, in a grid whose cells are a third of its radius for many.
pub fn impact(per_radius: Option<u32>) -> Meeting {
    let r = radius();
    let (mut points, cell) = match per_radius {
        None => (Points::default(), r),
        Some(n) => (Points::default(), 2.0 * r / f64::from(n)),
    };
    let side = (12.0 * r / cell).ceil() as u32;
    let settings = settings(Dimension::Space, cell, [side; 3]);
    let centre = [6.0 * r; 3];
    match per_radius {
        None => {
            let volume = MASS / STUFF.density;
            points.add(&comminute::mpm::Point {
                position: centre,
                velocity: [0.0; 3],
                mass: MASS,
                volume,
                stress: [0.0; 6],
                porosity: 0.0,
                law: 0,
            });
        }
        Some(_) => {
            let low = settings.lower.map(|x| x + 4.0 * cell);
            let high = low.map(|x| x + f64::from(side - 8) * cell);
            let inside = |p: [f64; 3]| (0..3).map(|a| (p[a] - centre[a]).powi(2)).sum::<f64>() < r * r;
            points = crate::points::fill(&settings, [low, high], 2, STUFF.density, inside, |_| [0.0; 3]);
            // zero void ratio, and the same mass whatever the resolution
            let share = MASS / points.velocity.iter().map(|v| v[3]).sum::<f64>();
            points.velocity.iter_mut().for_each(|v| v[3] *= share);
            points.initial_porosity.fill(0.0);
        }
    }
    let c = continuum(settings, elastic(STUFF.young, STUFF.poisson), points);
    let ball = Ball { at: [6.0 * r, 6.0 * r, 8.1 * r], radius: r, velocity: [0.0, 0.0, -5.0], ..Ball::default() };
    meeting(&free_scene(&[ball]), c)
}

pub fn free_scene(balls: &[Ball]) -> String {
    let mut text = String::from("kind = \"assembly\"\nsteps = 1\n");
    for b in balls {
        text += &format!(
            "[[grain]]\nposition_m = {:?}\nradius_m = {:?}\nvelocity_m_s = {:?}\nspin_rad_s = {:?}\n",
            b.at, b.radius, b.velocity, b.spin
        );
    }
    format!("{text}[material]\n{}", STUFF.toml())
}
