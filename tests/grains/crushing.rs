//! Breakage in the engine itself: when a grain breaks, into what, and what that leaves alone.

use assert_cmd::cargo::cargo_bin;

use crate::common::typed::array;
use crate::common::*;
use comminute::boundary::Drive;
use comminute::breakage::Criterion;
use comminute::breakage::criterion::HertzArea;
use comminute::breakage::pattern::Azimuth;
use comminute::breakage::strength::Truncation;
use comminute::dem::State;
use comminute::dem::event::Breakage;
use comminute::math::random::{lineage_child, lineage_root};
use comminute::scene;
use std::f64::consts::PI;

const COKE: Stuff = Stuff { young: 0.858e9, poisson: 0.3, density: 1040.0, friction: 0.4, restitution: 1.0 };
const THETA: f64 = PI / 9.0;

/// Keys of a crushing material whose daughters are born where their mother was: area model, mean strength at 2 mm in MPa, Weibull modulus, spread.
fn crushing(area: &str, strength: f64, m: f64, var: f64) -> String {
    let own = if area == "hertz" { "" } else { "material.strength.fixed_angle.theta0_rad = 0.3490658503988659\n" };
    let table = if area == "hertz" { "hertz_area" } else { "fixed_angle" };
    format!(
        "crushing.enabled = true\ncrushing.birth = \"overlapping\"\ncrushing.area = \"{area}\"\nmaterial.strength.d0_mm = 2.0\n{own}\
         material.strength.{table}.sigma_lim0_MPa = {strength:?}\nmaterial.strength.{table}.m = {m:?}\n\
         material.strength.{table}.var = {var:?}\nmaterial.comminution.d_limit_over_d50 = 0.25\n\
         material.comminution.d50_mm = 2.0\nmaterial.fines.d_min_mm = 1e-3\n"
    )
}

/// A grain that six platens press alike bears any force by its deviatoric stress, and breaks by the force of a contact.
#[test]
fn pressure_from_all_sides_breaks_no_grain_whose_mean_stress_is_judged() {
    let d = 2e-3;
    let von_mises =
        crushing("fixed_angle", 30.0, 2.0, 0.0).replace("\"fixed_angle\"", "\"von_mises\"").replace(".fixed_angle.", ".von_mises.");
    let von_mises = von_mises.replace("crushing.area", "crushing.criterion");
    let von_mises: String = von_mises.lines().filter(|line| !line.contains("theta0")).map(|line| format!("{line}\n")).collect();
    for (head, breaks) in [(crushing("fixed_angle", 30.0, 2.0, 0.0), true), (von_mises, false)] {
        let plane = |axis: usize, sign: f64| {
            let mut normal = [0.0; 3];
            normal[axis] = sign;
            Plane { point: normal.map(|n| -0.5 * d * n), normal, velocity: 0.2, ..Plane::default() }
        };
        let planes: Vec<Plane> = (0..3).flat_map(|axis| [plane(axis, 1.0), plane(axis, -1.0)]).collect();
        let ball = Ball { radius: 0.5 * d, ..Ball::default() };
        let mut lab = Lab::new(&assembly_text(&format!("{head}damping.local = 0.5\n"), &COKE, &[ball], &planes));
        let mut broken = 0;
        for _ in 0..40_000 {
            lab.step();
            broken += lab.work.breakages.len();
            if broken > 0 || lab.state.walls[0].reaction > 200.0 {
                break;
            }
        }
        assert_eq!(broken > 0, breaks, "{head}: {} N", lab.state.walls[0].reaction);
        assert!(breaks || lab.state.walls[0].reaction > 10.0, "it is pressed hard: {} N", lab.state.walls[0].reaction);
    }
}

/// A grain of diameter `d` at the origin between platens that close along `axis`, each with `speed`.
fn pressed(head: &str, d: f64, axis: [f64; 3], speed: f64) -> Lab {
    let r = 0.5 * d;
    let plane = |sign: f64| Plane {
        point: axis.map(|a| -sign * r * a),
        normal: axis.map(|a| sign * a),
        velocity: speed,
        ..Plane::default()
    };
    let ball = Ball { radius: r, ..Ball::default() };
    Lab::new(&assembly_text(head, &COKE, &[ball], &[plane(1.0), plane(-1.0)]))
}

/// Steps until the first breakage; the walls' reactions before it.
fn until_broken(lab: &mut Lab) -> (Breakage, Vec<f64>) {
    loop {
        let reactions = lab.see(|_, state, _| state.walls.iter().map(|w| w.reaction).collect());
        if let Some(b) = lab.work.breakages.first() {
            return (b.clone(), reactions);
        }
        assert!(lab.state.step < 200_000, "it does not break");
    }
}

/// Eqs (7), (16), (17): between platens a grain breaks at σ_lim π/4 d² sin²θ0, or at (σ_lim π)³ (3 r'/4E')² with the Hertzian area, r' = r and
/// E' = E/(1 − ν²) on a rigid platen, σ_lim = σ_lim,0 (d/d0)^(−3/m).
#[test]
fn a_grain_between_platens_breaks_at_its_limit_force() {
    for (area, strength, m) in [("fixed_angle", 300.0, 2.0), ("fixed_angle", 300.0, 10.0), ("hertz", 200.0, 10.0)] {
        for d in [1e-3f64, 2e-3, 8e-3] {
            for scale in [1.0f64, 4.0] {
                let sigma = strength * 1e6 * f64::powf(d / (2e-3 * scale), -3.0 / m);
                let limit = match area {
                    "hertz" => (sigma * PI).powi(3) * (3.0 * 0.5 * d / (4.0 * COKE.plane_modulus())).powi(2),
                    _ => sigma * PI / 4.0 * d * d * THETA.sin().powi(2),
                };
                // the comminution limit follows the scale: it must not hold the grain
                let head = crushing(area, strength, m, 0.0).replace("d50_mm = 2.0", "d50_mm = 0.5");
                let overlap = (limit / (4.0 / 3.0 * COKE.plane_modulus() * (0.5 * d).sqrt())).powf(2.0 / 3.0);
                let steps = 20_000.0;
                let dt = 5e-9;
                let head = format!("{head}specimen.scale = {scale:?}\nstepping.dt_s = {dt:?}\nrecords.energy = false");
                let mut lab = pressed(&head, d, [0.0, 0.0, 1.0], overlap / (steps * dt));
                let (b, reactions) = until_broken(&mut lab);
                let what = format!("{area}, d = {d}, N = {scale}");
                // the force passes its limit within one step, 3/2 of a step's share of the overlap
                let over = b.force / limit - 1.0;
                assert!((-1e-9..2.0 * 1.5 / steps).contains(&over), "{what}: broke at {} of {limit}", b.force);
                close(&format!("{what}: limit"), b.limit_force, limit, 1e-9);
                close(&format!("{what}: strength"), b.strength, sigma, 1e-9);
                close("bottom platen", reactions[0], b.force, 1e-12);
                close("top platen", reactions[1], b.force, 1e-6);
                let area = if area == "hertz" {
                    PI * (3.0 * b.force * 0.5 * d / (4.0 * COKE.plane_modulus())).powf(2.0 / 3.0)
                } else {
                    PI / 4.0 * d * d * THETA.sin().powi(2)
                };
                close("area", b.area, area, 1e-9);
                close("stress on it is the strength", b.force / b.area, sigma, 1e-3);
            }
        }
    }
}

/// Below the comminution limit nothing breaks.
/// With `linear_inherited` the fragments' contacts have the stiffness of their mother's size (eq. 13 with its diameter), with `linear` that of their own.
#[test]
fn fragments_keep_their_mothers_stiffness_where_the_law_says_so() {
    let (d, k_eff) = (2e-3, 33.3e6);
    for (law, own) in [("linear", true), ("linear_inherited", false)] {
        let head = format!(
            "contact.law = \"{law}\"\nmaterial.linear.K_eff_MPa = 33.3\ndamping.local = 0.5\n{}",
            crushing("fixed_angle", 30.0, 2.0, 0.0)
        );
        let mut lab = pressed(&head, d, [0.0, 0.0, 1.0], 1e-2);
        until_broken(&mut lab);
        assert!(lab.state.grains.len() == 14);
        let mut seen = [0, 0];
        for _ in 0..4000 {
            lab.see(|_, _, _| ());
            let (s, size) = (&lab.state, |i: u32| if own { lab.state.grains.pos[i as usize][3] } else { 0.5 * d });
            for (k, pool) in [&s.pairs, &s.wall_pairs].into_iter().enumerate() {
                for slot in (0..pool.slots()).filter(|slot| pool.ends[*slot][0] != u32::MAX && pool.touch[*slot].overlap > 1e-9) {
                    let [i, j] = pool.ends[slot];
                    let r_eff = if k == 0 { size(i) * size(j) / (size(i) + size(j)) } else { size(i) };
                    let touch = &pool.touch[slot];
                    close("force", touch.normal_force, 4.0 * k_eff * r_eff * touch.overlap, 1e-12);
                    seen[k] += 1;
                }
            }
        }
        assert!(seen[0] > 100 && seen[1] > 100, "{law}: {seen:?} contacts");
    }
}

#[test]
fn grains_below_the_comminution_limit_bear_anything() {
    let head = crushing("fixed_angle", 20.0, 2.0, 0.0) + "stepping.dt_s = 5e-9\n";
    for (d, breaks) in [(0.51e-3, true), (0.49e-3, false)] {
        let mut lab = pressed(&head, d, [0.0, 0.0, 1.0], 1.0);
        // 7 N in the end, the limit of the larger is 4 N
        lab.steps(10_000);
        assert_eq!(lab.state.crush_events > 0, breaks, "{d}: {:?} N", lab.state.walls[0].reaction);
        assert!(breaks || lab.state.walls[0].reaction > 6.0);
    }
}

/// A flying, spinning grain breaks on a wall; its twin that cannot break is what it was in that instant.
fn impact(pattern: u32, normal: [f64; 3], velocity: [f64; 3], spin: [f64; 3]) -> (Lab, Lab, Breakage) {
    let (d, weak) = (4e-3, crushing("fixed_angle", 10.0, 2.0, 0.0));
    let ball = Ball { at: [1.0, 2.0, 3.0].map(|x| 1e-3 * x), radius: 0.5 * d, velocity, spin, ..Ball::default() };
    let wall =
        Plane { point: std::array::from_fn(|a| ball.at[a] - 0.500_001 * d * normal[a]), normal, friction: 0.3, ..Plane::default() };
    let text =
        |head: &str| assembly_text(&format!("{head}\ncrushing.pattern = {pattern}\nstepping.dt_s = 5e-8"), &COKE, &[ball], &[wall]);
    let mut lab = Lab::new(&text(&weak));
    let mut twin = Lab::new(&text(&weak.replace("enabled = true", "enabled = false")));
    loop {
        lab.step();
        twin.step();
        if let Some(b) = lab.work.breakages.first() {
            let b = b.clone();
            return (lab, twin, b);
        }
        assert!(lab.state.step < 20_000, "it does not break");
    }
}

fn lead(v: [f64; 4]) -> [f64; 3] {
    [v[0], v[1], v[2]]
}

#[test]
fn daughters_keep_the_motion_of_the_mass_that_is_kept() {
    let diagonal = [1.0, -2.0, 0.5].map(|x: f64| x / 5.25f64.sqrt());
    let axes = [[0.0, 0.0, 1.0], [0.0, 0.0, -1.0], [1.0, 0.0, 0.0], [0.0, -1.0, 0.0], diagonal];
    for pattern in [2, 5, 14, 26, 38, 50, 68] {
        for normal in axes {
            let velocity: [f64; 3] = std::array::from_fn(|a| -4.0 * normal[a] + [0.3, -0.2, 0.5][a]);
            let (lab, twin, b) = impact(pattern, normal, velocity, [40.0, -300.0, 90.0]);
            let (g, t) = (&lab.state.grains, &twin.state.grains);
            let (centre, radius, v, w) = (lead(t.pos[0]), t.pos[0][3], lead(t.vel[0]), lead(t.spin[0]));
            assert_eq!(g.len(), pattern as usize);
            assert!(length(v) > 0.3 && length(w) > 100.0);
            // the decisive force points along the axis
            near("axis", dot(b.axis, normal).abs(), 1.0, 1e-14);

            let (mut kept, mut p, mut l, mut rigid) = (0.0, [0.0; 3], [0.0; 3], [0.0; 3]);
            let (mut deepest, mut reach) = (f64::NEG_INFINITY, 0.0f64);
            for i in 0..g.len() {
                let (m, r) = (g.mass[i], g.pos[i][3]);
                close("mass", m, COKE.mass(r), 1e-13);
                let arm = minus(lead(g.pos[i]), centre);
                let moment = cross(arm, minus(lead(g.vel[i]), v));
                let about = cross(arm, cross(w, arm));
                kept += m;
                for a in 0..3 {
                    p[a] += m * g.vel[i][a];
                    l[a] += m * moment[a] + 0.4 * m * r * r * g.spin[i][a];
                    rigid[a] += m * about[a] + 0.4 * m * r * r * w[a];
                }
                reach = reach.max((length(arm) + r) / radius);
                assert!((length(arm) + r) / radius > 1.0 - 1e-12 || pattern != 14, "each of the 14 touches the mother's sphere");
                for j in 0..i {
                    let gap = length(minus(lead(g.pos[i]), lead(g.pos[j]))) - r - g.pos[j][3];
                    deepest = deepest.max(-gap / radius);
                }
                assert_eq!(g.generation[i], 1);
                assert!(g.id[i] > 0, "daughters are new");
            }
            near("inscribed", reach, 1.0, 1e-12);
            near("siblings only touch", deepest, 0.0, 1e-12);
            close("mass kept and lost", kept + b.lost_mass, t.mass[0], 1e-13);
            for a in 0..3 {
                near("momentum", p[a] / kept, v[a], 1e-12 * length(v));
                near("angular momentum", l[a] / length(rigid), rigid[a] / length(rigid), 1e-11);
            }
            // without history and without new elastic energy
            assert!(b.stored_after <= b.stored_before, "{} J after {} J", b.stored_after, b.stored_before);
            assert!(b.stored_before > 0.0);
            assert_eq!(lab.state.ledger.rises, 0);
            for s in 0..lab.state.pairs.slots() {
                assert_eq!(lab.state.pairs.spring(s), [0.0; 3]);
            }
            if pattern >= 5 {
                // the three largest lie across the force
                let mut order: Vec<usize> = (0..g.len()).collect();
                order.sort_by(|&a, &b| g.pos[b][3].total_cmp(&g.pos[a][3]));
                for &i in &order[..3] {
                    near("across the force", dot(minus(lead(g.pos[i]), centre), b.axis) / radius, 0.0, 1e-12);
                }
            }
        }
    }
}

/// Grains in a row between the same platens, apart from each other.
fn row(diameters: &[f64], head: &str, speed: f64) -> Lab {
    let balls: Vec<Ball> = diameters
        .iter()
        .enumerate()
        .map(|(k, d)| Ball { at: [0.01 * k as f64, 0.0, 0.5 * d], radius: 0.5 * d, ..Ball::default() })
        .collect();
    let top = diameters.iter().copied().fold(0.0, f64::max);
    let planes = [
        Plane { normal: [0.0, 0.0, 1.0], ..Plane::default() },
        Plane { point: [0.0, 0.0, top], normal: [0.0, 0.0, -1.0], velocity: speed, ..Plane::default() },
    ];
    Lab::new(&assembly_text(&format!("{head}stepping.dt_s = 1e-8\n"), &COKE, &balls, &planes))
}

/// All that exceed break in the same step, in the order of ids whatever their place in memory, each by the forces of before.
#[test]
fn grains_that_fail_together_break_in_the_order_of_ids() {
    let head = crushing("fixed_angle", 300.0, 2.0, 0.0);
    let run = |shuffle: bool| {
        let mut lab = row(&[2e-3; 5], &head, 2.0);
        if shuffle {
            comminute::dem::permute(&mut lab.state, &mut lab.work, &[3, 0, 4, 2, 1]);
        }
        until_broken(&mut lab);
        let events = lab.work.breakages.clone();
        (lab, events)
    };
    let (lab, events) = run(false);
    assert_eq!(events.iter().map(|b| b.mother).collect::<Vec<_>>(), [0, 1, 2, 3, 4]);
    assert_eq!(events.iter().map(|b| b.event).collect::<Vec<_>>(), [1, 2, 3, 4, 5]);
    assert!(events.iter().all(|b| b.force == events[0].force && b.step == events[0].step));
    assert_eq!(lab.state.grains.len(), 5 + 13 * 5);
    // daughters of the first mother have the first new ids
    let g = &lab.state.grains;
    for i in 0..g.len() {
        let mother = (g.id[i] - 5) / 14;
        assert!((g.pos[i][0] - 0.01 * f64::from(mother)).abs() < 1e-3, "grain {} lies where mother {mother} was", g.id[i]);
    }
    let (other, again) = run(true);
    assert_eq!(events, again);
    assert_eq!(print(&lab.state), print(&other.state));
}

/// Two that touch each other and fail in the same step are both judged by the force between them, which the first breakage ends.
#[test]
fn forces_are_not_looked_at_again_between_breakages_of_a_step() {
    let head = crushing("fixed_angle", 30.0, 2.0, 0.0) + "stepping.dt_s = 1e-8\n";
    let ball = |z: f64| Ball { at: [0.0, 0.0, z], radius: 1e-3, velocity: [0.0, 0.0, -z * 3e4], ..Ball::default() };
    let mut lab = Lab::new(&assembly_text(&head, &COKE, &[ball(-1e-3), ball(1e-3)], &[]));
    until_broken(&mut lab);
    let events = &lab.work.breakages;
    assert_eq!(events.iter().map(|b| b.mother).collect::<Vec<_>>(), [0, 1]);
    assert_eq!(events[0].force, events[1].force);
    near("one line", dot(events[0].axis, events[1].axis).abs(), 1.0, 1e-14);
    assert_eq!(lab.state.grains.len(), 28);
}

/// Strengths are keyed by lineage: whether another grain has broken before moves neither those of the mother nor of her daughters.
#[test]
fn an_unrelated_earlier_breakage_moves_no_strength() {
    let spread = crushing("fixed_angle", 300.0, 2.0, 1.0);
    // strengths and radii of grain 1's daughters, and who broke, with a left neighbour of this size
    let line = |first: f64| {
        let mut lab = row(&[first, 2e-3], &spread, 2.0);
        let mine = lab.state.grains.lineage[1];
        let mut order = Vec::new();
        while !order.contains(&1) {
            lab.step();
            order.extend(lab.work.breakages.iter().map(|b| b.mother));
            assert!(lab.state.step < 100_000);
        }
        let g = &lab.state.grains;
        let daughters: Vec<_> = (0..14)
            .map(|k| {
                let lineage = lineage_child(mine, k);
                let i = g.lineage.iter().position(|&l| l == lineage).expect("a daughter");
                (g.strength[i].to_bits(), g.pos[i][3].to_bits())
            })
            .collect();
        assert!(daughters.windows(2).any(|d| d[0].0 != d[1].0), "strengths are spread");
        (daughters, order)
    };
    // a large neighbour is touched first; a small one is not touched at all
    let (with, order_with) = line(2.2e-3);
    let (without, order_without) = line(1.0e-3);
    assert_eq!(order_with[0], 0, "the neighbour breaks first");
    assert_eq!(order_without, [1], "the neighbour does not break");
    assert_eq!(with, without);
}

/// Table 4: N_final = N_initial + 13 events, and no mass goes astray, on a small crushing oedometer with several failures in a step.
#[test]
fn a_crushing_oedometer_obeys_the_identities_of_table_4() {
    let sets = ["crushing.enabled=true", "material.strength.fixed_angle.sigma_lim0_MPa=100"].map(String::from);
    let model = model(&oedometer_text(120, 400.0, ""), &sets);
    let (prepared, _) = prepare(&model, |_, _| ());
    let mut press = Press::new(model, &prepared);
    let (mass, _) = press.state.grains.mass_and_volume();
    let (mut events, mut most, mut ids) = (0u64, 0, std::collections::HashSet::new());
    ids.extend(press.state.grains.id.iter().copied());
    while !press.done() {
        press.step();
        let broken = &press.work.breakages;
        assert!(broken.windows(2).all(|b| b[0].mother < b[1].mother && b[0].event + 1 == b[1].event));
        for b in broken {
            assert!(b.force > b.limit_force, "only what exceeds its limit breaks");
            assert!(b.stored_after <= b.stored_before * (1.0 + 1e-9) || b.stored_before == 0.0);
        }
        events += broken.len() as u64;
        most = most.max(broken.len());
    }
    let g = &press.state.grains;
    println!("{events} events, {} grains, at most {most} in a step, {} rises", g.len(), press.state.ledger.rises);
    assert!(events > 30);
    assert_eq!(press.state.crush_events, events);
    assert_eq!(g.len() as u64, 120 + 13 * events);
    assert_eq!(u64::from(g.next_id), 120 + 14 * events);
    let lost: f64 = press.state.lost.iter().map(|l| l.0).sum();
    let (kept, _) = g.mass_and_volume();
    near("mass error", (kept + lost - mass) / mass, 0.0, 1e-12);
    // whoever is over the comminution limit can break, and nobody else
    for i in 0..g.len() {
        assert_eq!(g.breakage_threshold[i].is_finite(), 2.0 * g.pos[i][3] > 0.25 * 7.5e-3 * 4.0);
    }
}

/// Gradual birth between platens: no daughter overlaps anything, each ends with her own size, and the mass is hers from the first.
#[test]
fn daughters_begin_without_overlap_and_grow_to_their_size() {
    let d = 2e-3;
    // the strong grain is half her radius deep in each platen, and daughters at her edge would begin in it
    for (lost_mass, larger, strength) in [("leave", 1.0, 30.0), ("grow", 1.233, 30.0), ("leave", 1.0, 1300.0)] {
        let head = crushing("fixed_angle", strength, 2.0, 0.0)
            .replace("overlapping", "gradual")
            .replace("d50_mm = 2.0", "d50_mm = 7.0")
            + &format!("crushing.lost_mass = \"{lost_mass}\"\ncrushing.growth_steps = 400\nsteps = 1000000\ndamping.local = 0.7\n");
        // the platens leave once it has broken, and all find room
        let mut lab = pressed(&head, d, [0.0, 0.0, 1.0], 1e-2);
        let (b, _) = until_broken(&mut lab);
        let State { grains: g, walls, .. } = &lab.state;
        let masses: Vec<f64> = g.mass.clone();
        for p in &g.pos {
            for w in walls {
                // but by what it has grown in this one step; the weak mother's overlap was 0.04 mm
                assert!(w.shape.towards(*p).1 > -2e-6, "{p:?} overlaps a platen");
            }
        }
        assert!(g.pos.iter().zip(&masses).any(|(p, m)| COKE.mass(p[3]) < 0.97 * m), "some begin smaller than they are");
        near("mass", masses.iter().sum::<f64>() + b.lost_mass, COKE.mass(0.5 * d), 1e-12 * COKE.mass(0.5 * d));
        for w in &mut lab.state.walls {
            w.drive = Drive::Velocity(-1e-2);
        }
        for _ in 0..2000 {
            lab.see(|_, _, _| ());
        }
        let largest = lab.state.grains.pos.iter().map(|p| p[3]).fold(0.0, f64::max);
        near("largest daughter", largest / (0.5 * d), 0.4641 * larger, 1e-3);
        for (p, m) in lab.state.grains.pos.iter().zip(&lab.state.grains.mass) {
            close("mass", *m, COKE.mass(p[3]), 1e-9);
        }
    }
}

/// Daughters that are born overlapping break by the way they are born: far above limits that they had exceeded before anything moved. Those born without do not.
#[test]
fn breakages_after_gradual_birth_are_loads_or_collisions() {
    let of = |birth: &str| {
        let sets =
            ["crushing.enabled=true", "material.strength.fixed_angle.sigma_lim0_MPa=60", &format!("crushing.birth=\"{birth}\"")]
                .map(String::from);
        let model = model(&oedometer_text(160, 350.0, ""), &sets);
        let (prepared, _) = prepare(&model, |_, _| ());
        let mut press = Press::new(model, &prepared);
        let mut all: Vec<Breakage> = Vec::new();
        while !press.done() {
            press.step();
            all.extend(press.work.breakages.iter().cloned());
        }
        let young = all.iter().filter(|b| b.generation > 0 && b.age <= 20).count();
        let shocks = all.iter().filter(|b| b.utilisation() > 1.1 && !b.is_collision()).count();
        println!("{birth}: {} breakages, {young} young, {shocks} far above their limit at rest", all.len());
        assert!(all.len() > 40);
        (young as f64 / all.len() as f64, shocks as f64 / all.len() as f64)
    };
    let (young, shocks) = of("overlapping");
    assert!(young > 0.1 && shocks > 0.05, "{young} {shocks}");
    let (young, shocks) = of("gradual");
    assert!(young < 0.05 && shocks < 0.01, "{young} {shocks}");
}

/// What a run says of the stress of its breakages, as a user runs it, controlled by stress and by strain: each is within 5 % of a row beside it, and under strain control
/// the stress asked for is the one there is.
fn every_breakage_is_near_the_stress_of_a_row(control: &str) {
    let folder = tempfile::tempdir().expect("folder");
    let out = folder.path().join(control);
    let sets = [
        &format!("loading.control={control:?}"),
        "loading.max_stress_kPa=1000",
        "crushing.birth=gradual",
        "crushing.lost_mass=grow",
        "material.strength.fixed_angle.sigma_lim0_MPa=100",
        "records.figures=false",
        "records.snapshots=false",
    ]
    .map(str::to_string);
    let mut run = std::process::Command::new(cargo_bin("comminute"));
    run.current_dir(env!("CARGO_MANIFEST_DIR"))
        .args(["run", "experiments/calibration/coke_small.toml", "--quiet", "--out"])
        .arg(&out);
    for set in &sets {
        run.args(["--set", set]);
    }
    assert!(run.status().expect("started").success());
    let read = |file: &str| csv::Reader::from_path(out.join(file)).expect(file);
    let column = |file: &str, name: &str| -> Vec<f64> {
        let mut reader = read(file);
        let at = reader.headers().expect("header").iter().position(|h| h == name).expect(name);
        reader.records().map(|row| row.expect("row")[at].parse().expect("a number")).collect()
    };
    let (steps, stresses) = (column("history.csv", "step"), column("history.csv", "sigma_v_kPa"));
    let broken: Vec<(f64, f64)> = column("breakage.csv", "step").into_iter().zip(column("breakage.csv", "sigma_v_kPa")).collect();
    assert!(broken.len() > 40, "{control}: {} breakages", broken.len());
    for (step, stress) in broken {
        let after = steps.partition_point(|s| *s < step);
        let near = [after.checked_sub(1), Some(after)].into_iter().flatten().filter_map(|k| stresses.get(k));
        let distance = near.map(|s| (stress / s - 1.0).abs()).fold(f64::INFINITY, f64::min);
        assert!(distance < 0.05, "{control}: a breakage at {stress} kPa in step {step} is {distance:.3} from the rows beside it");
    }
    let text = std::fs::read_to_string(out.join("summary.json")).expect("summary");
    let summary: serde_json::Value = serde_json::from_str(&text).expect("JSON");
    let off = summary["breakages"]["off_stress_share"].as_f64().expect("a share");
    assert!(summary["breakages"]["young_share"].as_f64().expect("a share") < 0.05);
    assert!(control == "stress" || off == 0.0, "{off}");
    assert!(summary["held_every_step"]["steps"].as_u64().expect("steps") > 1000);
}

#[test]
fn breakages_under_a_stress_are_near_the_stress_of_a_row() {
    every_breakage_is_near_the_stress_of_a_row("stress");
}

#[test]
fn breakages_under_a_strain_are_near_the_stress_of_a_row() {
    every_breakage_is_near_the_stress_of_a_row("strain");
}

/// What the snapshots of a run that is loaded and unloaded say, as a user asks for it: contacts bear the stress of their instant, grains the mean stress of the
/// specimen, daughters know whose they are, and ParaView's list goes on while the stress falls.
#[test]
fn snapshots_say_what_grains_bear_and_whose_they_are() {
    let folder = tempfile::tempdir().expect("folder");
    let out = folder.path().join("out");
    let mut run = std::process::Command::new(cargo_bin("comminute"));
    run.current_dir(env!("CARGO_MANIFEST_DIR"));
    run.args(["run", "experiments/calibration/coke_small.toml", "--threads", "1", "--quiet", "--out"]).arg(&out);
    for set in [
        "loading.max_stress_kPa=600",
        "loading.stages_kPa=[100]",
        "material.strength.fixed_angle.sigma_lim0_MPa=100",
        "records.contacts=true",
    ] {
        run.args(["--set", set]);
    }
    assert!(run.status().expect("started").success());
    let text = |name: &str| std::fs::read_to_string(out.join(name)).expect("text");
    let note = |text: &str, key: &str| -> f64 {
        let line = text.lines().find_map(|l| l.strip_prefix(&format!("# {key} = "))).expect("note");
        line.parse().expect("a number")
    };
    let radius = note(&text("specimen.csv"), "cylinder_radius_m");
    let history = csv::Reader::from_path(out.join("history.csv"))
        .expect("history")
        .deserialize::<std::collections::HashMap<String, String>>()
        .map(|row| row.expect("row"))
        .collect::<Vec<_>>();
    let names = |of: &str| {
        let files = std::fs::read_dir(out.join("snapshots"))
            .expect("snapshots")
            .map(|f| f.expect("file").file_name().to_string_lossy().into_owned());
        let mut names: Vec<String> = files.filter(|name| name.starts_with(of)).collect();
        names.sort();
        names
    };
    let steps = names("step_");
    assert!(steps.len() >= 3 && names("walls_").len() == steps.len() && names("contacts_").len() == steps.len());
    let mothers: std::collections::BTreeSet<i64> =
        text("breakage.csv").lines().skip(1).map(|l| l.split(',').nth(3).expect("mother").parse().expect("number")).collect();
    let mut daughters = 0;
    for name in &steps {
        let number = name.trim_start_matches("step_").trim_end_matches(".vtp");
        let row = history.iter().find(|row| row["step"].parse::<u64>() == number.parse::<u64>()).expect("a row of that step");
        let of = |column: &str| -> f64 { row[column].parse().expect("number") };
        // both platens over their area
        let contacts = text(&format!("snapshots/contacts_{number}.csv"));
        let rows: Vec<Vec<&str>> =
            contacts.lines().filter(|l| !l.starts_with('#')).skip(1).map(|l| l.split(',').collect()).collect();
        let on = |wall: &str| -> f64 { rows.iter().filter(|r| r[2] == wall).map(|r| r[14].parse::<f64>().expect("N")).sum() };
        let sigma = 0.5e-3 * (on("bottom") - on("top")) / (PI * radius * radius);
        assert!(
            (sigma / note(&contacts, "sigma_v_kPa") - 1.0).abs() < 1e-6 && (sigma / of("sigma_v_kPa") - 1.0).abs() < 1e-6,
            "{sigma}"
        );
        assert!(rows.iter().all(|r| r[18].parse::<f64>().expect("overlap") > 0.0));
        // the volume's mean stress is that of its grains by their volumes; friction on the walls bears a little of it
        let file = std::fs::read(out.join("snapshots").join(name)).expect("snapshot");
        let numbers = |name: &str| -> Vec<f64> { array(&file, name).into_iter().map(f64::from_le_bytes).collect() };
        let whole = |name: &str| -> Vec<i64> { array(&file, name).into_iter().map(i64::from_le_bytes).collect() };
        let volume = PI * radius * radius * 1e-3 * of("height_mm");
        let borne: f64 = numbers("radius").iter().zip(numbers("mean_stress_Pa")).map(|(r, p)| 4.0 / 3.0 * PI * r.powi(3) * p).sum();
        assert!((1e-3 * borne / volume / of("p_kPa") - 1.0).abs() < 0.05, "{} of {} kPa", 1e-3 * borne / volume, of("p_kPa"));
        assert!(String::from_utf8_lossy(&file).contains("Name=\"sigma_v_kPa\""));
        for ((id, mother), ancestor) in whole("id").into_iter().zip(whole("mother_id")).zip(whole("ancestor_id")) {
            let of_the_start = (0..200).contains(&id);
            assert!(if of_the_start {
                mother == -1 && ancestor == id
            } else {
                mothers.contains(&mother) && (0..200).contains(&ancestor)
            });
            daughters += usize::from(!of_the_start);
        }
    }
    assert!(daughters > 100, "{daughters}");
    let list: Vec<f64> = text("snapshots.pvd")
        .split("timestep=\"")
        .skip(1)
        .map(|t| t.split('"').next().expect("quote").parse().expect("number"))
        .collect();
    assert_eq!(list, (0..steps.len()).map(|k| k as f64).collect::<Vec<f64>>());
    assert!(text("walls.pvd").contains("snapshots/walls_") && out.join("figures/force_chains.svg").exists());
    assert!(text("figures/gradation.svg").contains("unloading stages not shown"));
}

/// A specimen that is loaded again under strain control has its rows and gradations by stress from the start of that stage on, not only past its former largest stress.
#[test]
fn rows_by_stress_go_on_while_a_specimen_is_reloaded() {
    let folder = tempfile::tempdir().expect("folder");
    let out = folder.path().join("out");
    let mut run = std::process::Command::new(cargo_bin("comminute"));
    run.current_dir(env!("CARGO_MANIFEST_DIR"));
    run.args(["run", "experiments/calibration/coke_small.toml", "--threads", "1", "--quiet", "--out"]).arg(&out);
    for set in [
        "crushing.enabled=false",
        "loading.control=strain",
        "loading.max_stress_kPa=400",
        "loading.stages_kPa=[100, 500]",
        "records.every_strain=0.9",
        "records.at_kPa=[200]",
    ] {
        run.args(["--set", set]);
    }
    assert!(run.status().expect("started").success());
    let stresses = |file: &str| -> Vec<f64> {
        let mut reader = csv::Reader::from_path(out.join(file)).expect(file);
        let stress = reader.headers().expect("header").iter().position(|h| h == "sigma_v_kPa").expect("column");
        let rows = reader.records().map(|row| row.expect("row")).filter(|row| &row[1] == "reload");
        rows.map(|row| row[stress].parse().expect("kPa")).collect()
    };
    let rows = stresses("history.csv");
    assert!(rows.iter().filter(|s| (110.0..390.0).contains(*s)).count() > 10, "{rows:?}");
    let mut gradations = stresses("gsd.csv");
    gradations.dedup();
    assert_eq!(gradations.len(), 3, "{gradations:?}");
    for (found, asked) in gradations.iter().zip([100.0, 200.0, 500.0]) {
        assert!((found / asked - 1.0f64).abs() < 0.05, "{gradations:?}");
    }
}

/// What the paper leaves open are keys, and without them everything is as before: azimuth of the daughters, radius of Hertz's area, negative draws.
#[test]
fn open_choices_are_keys_that_are_off_by_default() {
    let text = oedometer_text(120, 100.0, "crushing.enabled = true");
    let crush = |sets: &[&str]| {
        let sets: Vec<String> = sets.iter().map(|s| s.to_string()).collect();
        let scene = scene::from_text(&text, ".", &sets)?;
        scene::model(&scene).map(|model| model.physics.crush.expect("grains that break"))
    };
    let hertz = "crushing.criterion=hertz_area";
    let plain = crush(&[hertz]).expect("a scene");
    assert_eq!((plain.azimuth, plain.strength.truncation), (Azimuth::Random, Truncation::Redraw));
    assert_eq!(plain.criterion, Criterion::HertzArea(HertzArea { own_radius: false }));

    assert_eq!(crush(&["crushing.azimuth=fixed"]).expect("a scene").azimuth, Azimuth::Fixed);
    let own = crush(&[hertz, "crushing.area_radius=own"]).expect("a scene");
    assert_eq!(own.criterion, Criterion::HertzArea(HertzArea { own_radius: true }));
    let refused = crush(&["crushing.area_radius=own"]).expect_err("no Hertzian area").to_string();
    for word in ["crushing.area_radius", "own", "hertz_area"] {
        assert!(refused.contains(word), "{refused}");
    }
    let refused = crush(&["crushing.azimuth=north"]).expect_err("no such azimuth").to_string();
    for word in ["crushing.azimuth", "north", "random", "fixed"] {
        assert!(refused.contains(word), "{refused}");
    }

    // var. = 1: draws above zero have the mean 1.288, by which they are divided, and absolute ones 1.167
    let drawn = |how: &str| {
        let strength = crush(&[&format!("material.strength.truncation={how}")]).expect("a scene").strength;
        let mean = (0..20_000).map(|i| strength.draw(3, lineage_root(i), strength.d0)).sum::<f64>() / 2e4;
        (strength.truncation, mean / strength.sigma_lim0)
    };
    let (kept, mean) = drawn("mean_preserving");
    assert!(matches!(kept, Truncation::MeanPreserving { mean } if (mean - 1.2876).abs() < 1e-4), "{kept:?}");
    near("mean of scaled strengths", mean, 1.0, 0.02);
    let (absolute, mean) = drawn("absolute");
    assert_eq!(absolute, Truncation::Absolute);
    near("mean of absolute strengths", mean, 1.1666, 0.025);
}

/// Three walls make no specimen: breakages of a free scene that has as many have no vertical stress.
#[test]
fn a_free_scene_with_three_walls_has_no_vertical_stress() {
    let folder = tempfile::tempdir().expect("folder");
    let (d, out) = (2e-3, folder.path().join("out"));
    let plane = |point: [f64; 3], normal: [f64; 3], velocity: f64| Plane { point, normal, velocity, ..Plane::default() };
    let planes = [
        plane([0.0, 0.0, -0.5 * d], [0.0, 0.0, 1.0], 0.5),
        plane([0.0, 0.0, 0.5 * d], [0.0, 0.0, -1.0], 0.5),
        plane([-d, 0.0, 0.0], [1.0, 0.0, 0.0], 0.0),
    ];
    let head = crushing("fixed_angle", 30.0, 2.0, 0.0) + "steps = 3000\nrecords.figures = false\n";
    let text = assembly_text(&head, &COKE, &[Ball { radius: 0.5 * d, ..Ball::default() }], &planes);
    let scene = folder.path().join("scene.toml");
    std::fs::write(&scene, text).expect("written");
    let mut run = std::process::Command::new(cargo_bin("comminute"));
    assert!(run.arg("run").arg(&scene).args(["--quiet", "--out"]).arg(&out).status().expect("started").success());
    let mut reader = csv::Reader::from_path(out.join("breakage.csv")).expect("breakages");
    let at = reader.headers().expect("header").iter().position(|h| h == "sigma_v_kPa").expect("a column");
    let stresses: Vec<String> = reader.records().map(|row| row.expect("row")[at].to_string()).collect();
    assert!(!stresses.is_empty() && stresses.iter().all(String::is_empty), "{stresses:?}");
}
