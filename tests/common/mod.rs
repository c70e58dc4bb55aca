//! What the tests share: scenes from text, the engine step by step, a small oedometer and what makes two states the same.
#![allow(dead_code)] // each test binary uses its part

pub mod typed;

use comminute::dem::ledger::Balance;
use comminute::dem::observables;
use comminute::dem::{State, Workspace, gather};
use comminute::model::{Model, Rig};
use comminute::record::specimen;
use comminute::rig::assembly;
use comminute::rig::cylinder::space;
use comminute::rig::preparation::Preparation;
use comminute::scene;
use comminute::testing::SpecimenTest;
use comminute::testing::oedometer::{Loading, Phase};
use std::fmt::Write as _;
use std::path::Path;

pub const ROOT: &str = env!("CARGO_MANIFEST_DIR");

/// A model from the text of a scene.
pub fn model(text: &str, sets: &[String]) -> Model {
    let scene = scene::from_text(text, "", sets).unwrap_or_else(|e| panic!("{e}\n{text}"));
    scene::model(&scene).unwrap_or_else(|e| panic!("{e}\n{text}"))
}

/// What grains are made of.
#[derive(Clone, Copy)]
pub struct Stuff {
    pub young: f64,
    pub poisson: f64,
    pub density: f64,
    pub friction: f64,
    pub restitution: f64,
}

impl Stuff {
    pub fn toml(&self) -> String {
        format!(
            "name = \"stuff\"\ngrain.density_kg_m3 = {:?}\nelastic.E_GPa = {:?}\nelastic.nu = {:?}\n\
             contact.friction = {:?}\ncontact.restitution = {:?}\n",
            self.density,
            self.young * 1e-9,
            self.poisson,
            self.friction,
            self.restitution
        )
    }

    /// E / (1 - nu^2), Pa.
    pub fn plane_modulus(&self) -> f64 {
        self.young / (1.0 - self.poisson * self.poisson)
    }

    /// Shear modulus, Pa.
    pub fn shear(&self) -> f64 {
        self.young / (2.0 * (1.0 + self.poisson))
    }

    pub fn mass(&self, radius: f64) -> f64 {
        self.density * 4.0 / 3.0 * std::f64::consts::PI * radius.powi(3)
    }
}

/// A grain of a free scene.
#[derive(Clone, Copy, Default)]
pub struct Ball {
    pub at: [f64; 3],
    pub radius: f64,
    pub velocity: [f64; 3],
    pub spin: [f64; 3],
    /// Name of a material where the scene has several.
    pub material: Option<&'static str>,
}

/// A plane of a free scene.
#[derive(Clone, Copy, Default)]
pub struct Plane {
    pub point: [f64; 3],
    pub normal: [f64; 3],
    pub friction: f64,
    pub velocity: f64,
}

/// The text of a free scene of one material: `head` holds keys of the top table and `key.key = …` lines.
pub fn assembly_text(head: &str, stuff: &Stuff, balls: &[Ball], planes: &[Plane]) -> String {
    let material = stuff.toml().lines().map(|l| format!("material.{l}\n")).collect::<String>();
    assembly_text_of(&format!("{head}\n{material}"), balls, planes)
}

/// As [`assembly_text`], the materials in `head`.
pub fn assembly_text_of(head: &str, balls: &[Ball], planes: &[Plane]) -> String {
    let steps = if head.contains("duration_s") || head.contains("steps =") { "" } else { "steps = 1000000000\n" };
    format!("kind = \"assembly\"\n{steps}{head}\n{}", bodies_text(balls, planes))
}

/// Grains and walls of a free scene.
pub fn bodies_text(balls: &[Ball], planes: &[Plane]) -> String {
    let mut text = String::new();
    for b in balls {
        let _ = writeln!(
            text,
            "[[grain]]\nposition_m = {:?}\nradius_m = {:?}\nvelocity_m_s = {:?}\nspin_rad_s = {:?}",
            b.at, b.radius, b.velocity, b.spin
        );
        if let Some(m) = b.material {
            let _ = writeln!(text, "material = \"{m}\"");
        }
    }
    for p in planes {
        let _ = writeln!(
            text,
            "[[wall]]\nkind = \"plane\"\npoint_m = {:?}\nnormal = {:?}\nfriction = {:?}\nvelocity_m_s = {:?}",
            p.point, p.normal, p.friction, p.velocity
        );
    }
    text
}

/// A free scene under way.
pub struct Lab {
    pub model: Model,
    pub state: State,
    pub work: Workspace,
}

/// One grain at the instant of its forces: velocity and spin are those of that instant, not of the half step.
#[derive(Clone, Copy, Debug, Default)]
pub struct Now {
    pub at: [f64; 3],
    pub velocity: [f64; 3],
    pub spin: [f64; 3],
    pub force: [f64; 3],
    pub torque: [f64; 3],
}

impl Lab {
    pub fn new(text: &str) -> Lab {
        Lab::of(model(text, &[]))
    }

    pub fn of(model: Model) -> Lab {
        let Rig::Assembly(rig) = &model.rig else { panic!("an assembly") };
        let mut state = assembly::start(&model, rig);
        let work = Workspace::new(&model.physics, &mut state);
        Lab { model, state, work }
    }

    pub fn step(&mut self) {
        self.see(|_, _, _| ());
    }

    pub fn steps(&mut self, n: usize) {
        for _ in 0..n {
            self.step();
        }
    }

    /// One step; `eye` sees the instant at which the forces of the present positions are known.
    pub fn see<T>(&mut self, eye: impl FnOnce(&Model, &State, &Workspace) -> T) -> T {
        let Lab { model, state, work } = self;
        let mut seen = None;
        assembly::advance(model, state, work, |state, work| {
            seen = Some(eye(model, state, work));
            Ok(())
        })
        .unwrap_or_else(|e| panic!("{e}"));
        seen.expect("observed")
    }

    /// One step, with the grains given (by id) as they were at its forces.
    pub fn watch<const N: usize>(&mut self, ids: [u32; N]) -> [Now; N] {
        self.see(|model, state, work| ids.map(|id| now(model, state, work, id)))
    }

    /// One step, with the energy balance of its forces.
    pub fn balance(&mut self) -> Balance {
        self.see(|model, state, work| state.ledger.balance(&state.walls, &observables::sums(&model.physics, state, work)))
    }

    pub fn index(&self, id: u32) -> usize {
        self.state.grains.id.iter().position(|&k| k == id).expect("a grain of this id")
    }

    /// Velocity of the last half step: in free flight that of every instant.
    pub fn velocity(&self, id: u32) -> [f64; 3] {
        lead(self.state.grains.vel[self.index(id)])
    }

    pub fn spin(&self, id: u32) -> [f64; 3] {
        lead(self.state.grains.spin[self.index(id)])
    }

    pub fn position(&self, id: u32) -> [f64; 3] {
        lead(self.state.grains.pos[self.index(id)])
    }
}

fn now(model: &Model, state: &State, work: &Workspace, id: u32) -> Now {
    let g = &state.grains;
    let i = g.id.iter().position(|&k| k == id).expect("a grain of this id");
    let (force, torque) = gather::force_and_torque(i, &model.physics, state, &work.neighbours);
    let half = if state.fresh { 0.0 } else { 0.5 * state.dt };
    let (m, r) = (g.inertia(i), g.pos[i][3]);
    Now {
        at: lead(g.pos[i]),
        velocity: std::array::from_fn(|a| g.vel[i][a] + half * force[a] / m),
        spin: std::array::from_fn(|a| g.spin[i][a] + half * torque[a] / (0.4 * m * r * r)),
        force,
        torque,
    }
}

fn lead(v: [f64; 4]) -> [f64; 3] {
    [v[0], v[1], v[2]]
}

pub fn dot(a: [f64; 3], b: [f64; 3]) -> f64 {
    a[0] * b[0] + a[1] * b[1] + a[2] * b[2]
}

pub fn cross(a: [f64; 3], b: [f64; 3]) -> [f64; 3] {
    [a[1] * b[2] - a[2] * b[1], a[2] * b[0] - a[0] * b[2], a[0] * b[1] - a[1] * b[0]]
}

pub fn minus(a: [f64; 3], b: [f64; 3]) -> [f64; 3] {
    [a[0] - b[0], a[1] - b[1], a[2] - b[2]]
}

pub fn length(a: [f64; 3]) -> f64 {
    dot(a, a).sqrt()
}

/// Within this share of what is expected.
#[track_caller]
pub fn close(what: &str, value: f64, expected: f64, relative: f64) {
    let off = (value / expected - 1.0).abs();
    println!("{what}: {value:e}, off by {off:.1e} of {relative:.0e}");
    assert!(off <= relative, "{what}: {value:e} instead of {expected:e}, off by {off:.2e} (allowed {relative:.0e})");
}

/// Within this distance of what is expected.
#[track_caller]
pub fn near(what: &str, value: f64, expected: f64, distance: f64) {
    let off = (value - expected).abs();
    println!("{what}: {value:e}, off by {off:.1e} of {distance:.0e}");
    assert!(off <= distance, "{what}: {value:e} instead of {expected:e}, off by {off:.2e} (allowed {distance:.0e})");
}

/// Petroleum coke in a small oedometer; `grains` of four times their size in 200 mm.
pub fn oedometer_text(grains: u32, max_stress: f64, more: &str) -> String {
    format!(
        "kind = \"oedometer\"\nname = \"small\"\nmaterial = \"{ROOT}/materials/petroleum_coke.toml\"\n\
         specimen.scale = 4.0\nspecimen.grains = {grains}\nspecimen.diameter_mm = 200.0\nspecimen.porosity = 0.46\n\
         preparation.growth_friction = 0.4\npreparation.growth_steps = 1500\npreparation.porosity_tolerance = 0.02\n\
         loading.max_stress_kPa = {max_stress:?}\nloading.settle_steps = 500\n\
         stepping.inertia_scaling = true\nrecords.figures = false\n{more}\n"
    )
}

/// A prepared specimen and the number of steps it took; `each` may tamper with memory before every step.
pub fn prepare(model: &Model, mut each: impl FnMut(&mut State, &mut Workspace)) -> (State, u64) {
    let Some(rig) = model.rig.specimen() else { panic!("a specimen") };
    let (mut preparation, mut state) = Preparation::start(model, rig);
    let mut work = Workspace::new(&model.physics, &mut state);
    loop {
        each(&mut state, &mut work);
        if preparation.advance(model, rig, &mut state, &mut work).unwrap_or_else(|e| panic!("{e}")) {
            return (state, preparation.steps());
        }
    }
}

/// An oedometer from a prepared specimen to the end of its programme.
pub struct Press {
    pub model: Model,
    pub loading: Loading,
    pub state: State,
    pub work: Workspace,
}

impl Press {
    /// Starts from a state that was prepared, by way of the file.
    pub fn new(model: Model, prepared: &State) -> Press {
        let folder = tempfile::tempdir().expect("a folder");
        let path = folder.path().join("specimen.csv");
        specimen::write(&path, &prepared.grains, &model.physics.materials, Some(space(prepared))).expect("written");
        Press::from_file(model, &path)
    }

    pub fn from_file(model: Model, path: &Path) -> Press {
        let (grains, walls) = specimen::read(path, &model.physics.materials).unwrap_or_else(|e| panic!("{e}"));
        let Rig::Oedometer(rig) = &model.rig else { panic!("an oedometer") };
        let (loading, mut state) = Loading::start(&model, rig, grains, walls).expect("starts");
        let work = Workspace::new(&model.physics, &mut state);
        Press { model, loading, state, work }
    }

    pub fn done(&self) -> bool {
        self.loading.phase == Phase::Done
    }

    pub fn step(&mut self) {
        self.see(|_, _, _, _| ());
    }

    /// One step; `eye` sees the instant at which forces are known.
    pub fn see(&mut self, mut eye: impl FnMut(&Model, &Loading, &State, &Workspace)) {
        let Press { model, loading, state, work } = self;
        let Rig::Oedometer(rig) = &model.rig else { unreachable!() };
        loading
            .advance(model, rig, state, work, &mut |loading, state, work| {
                eye(model, loading, state, work);
                Ok(())
            })
            .unwrap_or_else(|e| panic!("{e}"));
    }
}

/// Everything of a state that must not depend on threads, lists or memory order, as bits in the order of ids.
#[derive(Debug, PartialEq)]
pub struct Print {
    pub grains: Vec<(u32, Vec<u64>)>,
    pub contacts: Vec<((u32, u32), Vec<u64>)>,
    pub walls: String,
    pub ledger: String,
    pub counters: String,
}

pub fn print(state: &State) -> Print {
    let g = &state.grains;
    let bits = |v: &[f64]| v.iter().map(|x| x.to_bits()).collect::<Vec<u64>>();
    let grains = g
        .by_id()
        .into_iter()
        .map(|i| {
            let i = i as usize;
            let mut b = bits(&g.pos[i]);
            b.extend(bits(&g.vel[i]));
            b.extend(bits(&g.spin[i][..3]));
            b.extend(bits(&[g.mass[i], g.strength[i], g.breakage_threshold[i]]));
            b.extend(bits(&g.work[i]));
            b.extend([g.lineage[i], u64::from(g.generation[i]), u64::from(g.material[i])]);
            (g.id[i], b)
        })
        .collect();
    let mut contacts = Vec::new();
    for (pairs, walls) in [(&state.pairs, false), (&state.wall_pairs, true)] {
        for s in 0..pairs.slots() {
            let touch = pairs.touch[s];
            if touch.overlap > 0.0 {
                let [i, j] = pairs.ends[s];
                let other = if walls { u32::MAX - j } else { g.id[j as usize] };
                let mut b = bits(&pairs.spring(s));
                b.extend(bits(&touch.force()));
                b.push(touch.overlap.to_bits());
                contacts.push(((g.id[i as usize], other), b));
            }
        }
    }
    contacts.sort();
    Print {
        grains,
        contacts,
        walls: format!("{:?}", state.walls),
        ledger: format!("{:?}", state.ledger),
        counters: format!("{:?}", (state.step, state.time, state.dt, state.crush_events, g.next_id, &state.lost)),
    }
}
