//! Scenes of rigid bodies alone, step by step.

use crate::common::{Stuff, model};
use comminute::grains::Grains;
use comminute::math::vector::{cross, plus, scaled};
use comminute::model::continuum::MpmTest;
use comminute::model::{Model, Rig};
use comminute::rig::continuum::{Engine, State};
use comminute::rigid::{Block, Blocks};
use rayon::{ThreadPool, ThreadPoolBuilder};

/// A stone without friction whose impacts lose nothing.
pub const SMOOTH: Stuff = Stuff { young: 10e9, poisson: 0.2, density: 2500.0, friction: 0.0, restitution: 1.0 };
/// A stone with friction whose impacts lose most of their energy.
pub const ROUGH: Stuff = Stuff { young: 1e9, poisson: 0.2, density: 2500.0, friction: 0.7, restitution: 0.3 };

/// Steps on a worker of this test's own: from a thread that is none, every parallel piece of a step would wake one and wait for it.
pub fn on_one_thread<T: Send>(job: impl FnOnce() -> T + Send) -> T {
    thread_local! {
        static WORKER: ThreadPool = ThreadPoolBuilder::new().num_threads(1).build().expect("a thread");
    }
    WORKER.with(|worker| worker.install(job))
}

/// A scene under way.
pub struct Scene {
    pub model: Model,
    pub rig: MpmTest,
    pub state: State,
    pub engine: Engine,
}

impl Scene {
    /// Bodies of `stuff` as TOML, under gravity.
    pub fn new(stuff: &Stuff, gravity: [f64; 3], bodies: &str) -> Scene {
        let law = if stuff.restitution < 1.0 { "hertz_viscous" } else { "hertz" };
        let text = format!(
            "kind = \"mixture\"\nduration_s = 1000.0\ngravity_m_s2 = {gravity:?}\n{bodies}\n[contact]\nlaw = \"{law}\"\n[material]\n{}",
            stuff.toml()
        );
        Scene::of(&text)
    }

    /// A whole scene as TOML.
    pub fn of(text: &str) -> Scene {
        let model = model(text, &[]);
        let Rig::Continuum(rig) = &model.rig else { panic!("a mixture") };
        let rig = (**rig).clone();
        let mut state = State::start(&model, &rig).unwrap_or_else(|e| panic!("{e}"));
        let engine = Engine::of_grains(&mut state, &model, &rig);
        Scene { model, rig, state, engine }
    }

    /// Goes on for a time, s; an error ends it.
    pub fn run(&mut self, duration: f64) -> Result<(), String> {
        let end = self.state.time + duration;
        on_one_thread(|| {
            while self.state.time < end {
                self.state.advance(&self.model, &self.rig, &mut self.engine, |_, _| Ok(0.0)).map_err(|e| e.to_string())?;
            }
            Ok(())
        })
    }

    pub fn all(&self) -> &Blocks {
        self.state.blocks().expect("bodies")
    }

    pub fn grains(&self) -> &Grains {
        &self.state.mixture.as_ref().expect("a mixture").grains.grains
    }

    pub fn block(&self, k: usize) -> &Block {
        &self.all().blocks[k]
    }

    /// Momentum, kg m/s, and angular momentum about the origin, kg m²/s, of all bodies.
    pub fn momenta(&self) -> [[f64; 3]; 2] {
        self.all().blocks.iter().fold([[0.0; 3]; 2], |[p, l], b| {
            let own = scaled(b.velocity, b.mass);
            [plus(p, own), plus(l, plus(b.momentum, cross(b.centre, own)))]
        })
    }

    /// Kinetic, potential and elastic energy, J.
    pub fn energy(&self) -> f64 {
        let factor = if self.model.physics.contact.law.is_hertzian() { 0.4 } else { 0.5 };
        self.all().energies(self.model.physics.gravity, factor).iter().sum()
    }
}

/// A box as TOML.
pub fn cuboid(size: [f64; 3], at: [f64; 3], more: &str) -> String {
    format!("[[block]]\nshape = \"box\"\nsize_mm = {size:?}\nposition_mm = {at:?}\n{more}\n")
}

/// A level floor at z = 0 as TOML.
pub const FLOOR: &str = "[[wall]]\nkind = \"plane\"\npoint_m = [0.0, 0.0, 0.0]\nnormal = [0.0, 0.0, 1.0]\nfriction = 0.7\n";
