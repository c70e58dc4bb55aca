//! The same bytes whatever the number of threads, the age of neighbour lists, the place of grains in memory or the instruction set.

mod common;

use comminute::dem::{State, Workspace, permute};
use comminute::math::real::at_best;
use comminute::model::Model;
use common::*;
use rand::seq::SliceRandom;
use rand::{RngExt, SeedableRng};
use rand_chacha::ChaCha8Rng;
use std::sync::OnceLock;

/// Coke weak enough for many breakages.
const WEAK: [&str; 3] = ["crushing.enabled=true", "material.strength.fixed_angle.sigma_lim0_MPa=60", "specimen.diameter_mm=165"];

fn scene(more: &[&str]) -> Model {
    let sets: Vec<String> = WEAK.iter().chain(more).map(|s| s.to_string()).collect();
    model(&oedometer_text(110, 350.0, ""), &sets)
}

/// Contacts per parallel task: few, so that small runs are shared among threads.
const TASK: usize = 32;

/// Preparation and loading, with prints on the way; `each` may tamper with memory before every step.
fn run(model: Model, each: impl FnMut(&mut State, &mut Workspace)) -> Vec<Print> {
    run_until(model, u64::MAX, each)
}

/// The same, at most to this step of the loading.
fn run_until(model: Model, last: u64, mut each: impl FnMut(&mut State, &mut Workspace)) -> Vec<Print> {
    let mut each = |state: &mut State, work: &mut Workspace| {
        work.task = TASK;
        each(state, work);
    };
    let (prepared, steps) = prepare(&model, &mut each);
    let mut prints = vec![print(&prepared)];
    prints[0].counters += &format!(" {steps} steps");
    let mut press = Press::new(model, &prepared);
    while !press.done() && press.state.step < last {
        each(&mut press.state, &mut press.work);
        press.step();
        if press.state.step.is_multiple_of(3000) {
            prints.push(print(&press.state));
        }
    }
    if press.done() {
        prints.push(print(&press.state));
    }
    let s = &press.state;
    println!("{steps} + {} steps, {} events, {} slots", s.step, s.crush_events, s.pairs.slots());
    assert!(s.crush_events > 40 && s.grains.len() > 600, "enough breaks");
    assert!(s.pairs.slots() > 8 * TASK, "enough contacts to share among threads");
    prints
}

/// The run as it is, on one thread.
fn reference() -> &'static [Print] {
    static RUN: OnceLock<Vec<Print>> = OnceLock::new();
    RUN.get_or_init(|| on_threads(1, || run(scene(&[]), |_, _| ())))
}

fn on_threads<T: Send>(n: usize, job: impl FnOnce() -> T + Send) -> T {
    rayon::ThreadPoolBuilder::new().num_threads(n).build().expect("threads").install(job)
}

#[track_caller]
fn same(a: &[Print], b: &[Print]) {
    for (k, (a, b)) in a.iter().zip(b).enumerate() {
        assert_eq!(a.counters, b.counters, "print {k}");
        assert_eq!((&a.walls, &a.ledger), (&b.walls, &b.ledger), "print {k}");
        for (x, y) in a.grains.iter().zip(&b.grains) {
            assert_eq!(x, y, "print {k}: grain {}", x.0);
        }
        for (x, y) in a.contacts.iter().zip(&b.contacts) {
            assert_eq!(x, y, "print {k}: contact {:?}", x.0);
        }
        assert!(a == b, "print {k}: numbers of grains or contacts");
    }
    assert_eq!(a.len(), b.len());
}

#[test]
fn two_threads_give_the_same_bytes() {
    same(reference(), &on_threads(2, || run(scene(&[]), |_, _| ())));
}

#[test]
fn seven_threads_give_the_same_bytes() {
    same(reference(), &on_threads(7, || run(scene(&[]), |_, _| ())));
}

#[test]
fn skins_of_half_and_twice_the_size_give_the_same_bytes() {
    for skin in ["stepping.skin=0.1", "stepping.skin=0.4"] {
        same(reference(), &on_threads(1, || run(scene(&[skin]), |_, _| ())));
    }
}

/// Not to the end of the loading: lists take ten times as long as steps.
#[test]
fn lists_made_anew_at_every_step_give_the_same_bytes() {
    let found = on_threads(1, || run_until(scene(&[]), 36_000, |_, work| work.rebuild_always = true));
    assert!(found.len() == 13);
    same(&reference()[..13], &found);
}

/// Dropping the scratch now and then is what a resumed run does.
#[test]
fn scratch_dropped_now_and_then_gives_the_same_bytes() {
    let model = scene(&[]);
    let again = scene(&[]);
    let mut steps = 0u32;
    same(
        reference(),
        &on_threads(1, || {
            run(model, |state, work| {
                steps += 1;
                if steps.is_multiple_of(101) {
                    *work = Workspace::new(&again.physics, state);
                }
            })
        }),
    );
}

/// What a test does to memory before a step.
type Tamper = Box<dyn FnMut(&mut State, &mut Workspace) + Send>;

/// A random order in memory, at random steps.
fn shuffled(seed: u64) -> impl FnMut(&mut State, &mut Workspace) + Send {
    let mut rng = ChaCha8Rng::seed_from_u64(seed);
    move |state, work| {
        if rng.random_range(0..50) == 0 {
            let mut order: Vec<u32> = (0..state.grains.len() as u32).collect();
            order.shuffle(&mut rng);
            permute(state, work, &order);
        }
    }
}

#[test]
fn random_orders_in_memory_give_the_same_bytes() {
    same(reference(), &on_threads(1, || run(scene(&[]), shuffled(1))));
    same(reference(), &on_threads(3, || run(scene(&["stepping.skin=0.14"]), shuffled(2))));
}

#[test]
fn every_instruction_set_gives_the_same_bytes() {
    for name in ["scalar", "avx2"] {
        same(reference(), &on_threads(1, || run(scene(&[]), |_, work| work.arch = at_best(name))));
    }
}

/// Two materials that roll and bounce: what an oedometer's contacts do not have.
#[test]
fn every_instruction_set_gives_the_same_bytes_in_a_free_scene() {
    let named = |name: &str, young: f64| {
        let stuff = Stuff { young, poisson: 0.2, density: 2600.0, friction: 0.3, restitution: 0.6 };
        let toml = stuff.toml() + "contact.rolling_friction = 0.1\n";
        toml.lines().map(|l| format!("materials.{name}.{l}\n")).collect::<String>()
    };
    let mut rng = ChaCha8Rng::seed_from_u64(5);
    let balls: Vec<Ball> = (0..200)
        .map(|k| Ball {
            at: [k % 6, k / 6 % 6, k / 36].map(|a| 1.9e-3 * f64::from(a)),
            radius: rng.random_range(1.0e-3..1.06e-3),
            velocity: std::array::from_fn(|_| rng.random_range(-0.3..0.3)),
            spin: std::array::from_fn(|_| rng.random_range(-50.0..50.0)),
            material: Some(if k % 3 == 0 { "hard" } else { "soft" }),
        })
        .collect();
    let head = "contact.law = \"hertz_viscous\"\ngravity_m_s2 = [0, 0, -9.81]\n";
    let text = assembly_text_of(&format!("{head}{}{}", named("hard", 1e9), named("soft", 2e8)), &balls, &[]);
    let text =
        text + "[[wall]]\nkind = \"box\"\nmin_m = [-0.001, -0.001, -0.001]\nmax_m = [0.0105, 0.0105, 0.0105]\nfriction = 0.2\n";
    let run = |name: &str| {
        let mut lab = Lab::new(&text);
        lab.work.arch = at_best(name);
        lab.steps(3000);
        assert!(lab.state.pairs.slots() > 200, "enough contacts: {}", lab.state.pairs.slots());
        vec![print(&lab.state)]
    };
    let reference = run("");
    for name in ["scalar", "avx2"] {
        same(&reference, &run(name));
    }
}

/// The other laws, shorter: linear, Hertzian area, rescaled tangential force.
#[test]
fn other_laws_give_the_same_bytes() {
    for more in [
        ["contact.law=linear", "contact.unloading=keep", "records.energy=false"],
        ["contact.law=hertz", "contact.unloading=rescale", "material.contact.rolling_friction=0.1"],
    ] {
        let short = |skin: &str, threads: usize, arch: &str, seed: Option<u64>| {
            let mut all = more.to_vec();
            all.extend([skin, "preparation.growth_steps=300"]);
            let mut each: Tamper = match seed {
                Some(seed) => Box::new(shuffled(seed)),
                None => Box::new(|_, _| ()),
            };
            on_threads(threads, || {
                let model = scene(&all);
                let (prepared, _) = prepare(&model, &mut each);
                let mut press = Press::new(model, &prepared);
                while press.state.step < 9000 {
                    press.work.arch = at_best(arch);
                    each(&mut press.state, &mut press.work);
                    press.step();
                }
                println!("{more:?}: {} events", press.state.crush_events);
                vec![print(&prepared), print(&press.state)]
            })
        };
        let reference = short("stepping.skin=0.1", 1, "", None);
        same(&reference, &short("stepping.skin=0.2", 2, "avx2", Some(3)));
        same(&reference, &short("stepping.skin=0.04", 7, "scalar", None));
    }
}
