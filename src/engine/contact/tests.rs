//! Sweeps over contacts, against the laws written out, and what contacts keep from step to step.

use super::chunk::Chunk;
use super::force::{self, ContactGeometry, ContactHistory, RelativeMotion, Rules};
use super::law::{Elastic, Hertz, HertzViscous, Law, Moduli, viscous_coefficient, viscous_coefficient_without_tension};
use super::pair::{Pair, PairTable};
use super::pairs::{ContactForce, FREE, Kept, Pairs};
use super::{ContactLaw, TangentialUnloading};
use crate::boundary::{Drive, Wall, WallShape, WallSpec};
use crate::grains::Grains;
use crate::material::Material;
use crate::math::real::{arch, at_best};
use crate::math::vector::{cross, dot, less, plus, scaled};

const DT: f64 = 1e-6;

fn materials(law: ContactLaw) -> Vec<Material> {
    let of = |young: f64, poisson, friction, rolling_friction| Material {
        name: "stuff".into(),
        density: 2500.0,
        internal_porosity: 0.0,
        young,
        poisson,
        friction,
        rolling_friction,
        interface_friction: None,
        contact: std::array::from_fn(|k| match law.table().parameters.get(k).map(|p| p.key) {
            Some("linear.K_eff_MPa") => 0.01 * young,
            Some("linear.alpha_s") => 0.4,
            Some("contact.yield_pressure_MPa") => 0.02 * young,
            Some(_) => 0.6,
            None => 0.0,
        }),
    };
    vec![of(1e8, 0.2, 0.4, 0.1), of(3e7, 0.35, 0.25, 0.3)]
}

fn rules(unloading: TangentialUnloading, arch: pulp::Arch) -> Rules {
    Rules { dt: DT, unloading, weighs_radius: true, task: 16, arch }
}

const ALL: Kept = Kept { work: true, rolling: true, spring: true, load: true, largest: true };

/// Numbers between -1 and 1 that look drawn.
fn wobble(k: usize, seed: f64) -> f64 {
    (seed * (k as f64 + 1.0)).sin()
}

fn vector(k: usize, seed: f64) -> [f64; 3] {
    [wobble(k, seed), wobble(k, seed + 1.3), wobble(k, seed + 2.9)]
}

/// Pairs of grains far from the other pairs; every seventh pair is apart. Slow ones stick, fast ones slide.
fn pairs_of_grains(law: ContactLaw, n: usize, kept: Kept) -> (Grains, Pairs) {
    let materials = materials(law);
    let (mut g, mut pairs) = (Grains::default(), Pairs::new(kept));
    for k in 0..n {
        let (r, s) = (0.01 + 0.004 * wobble(k, 3.1), 0.012 + 0.005 * wobble(k, 5.7));
        let v = vector(k, 2.3);
        let n = scaled(v, 1.0 / dot(v, v).sqrt());
        let gap = if k % 7 == 3 { 1e-5 } else { -1e-5 * (k + 1) as f64 };
        let at = [k as f64, 0.3, -0.2];
        let speed = if k % 2 == 0 { 1e-3 } else { 3.0 };
        for (centre, radius, material, seed) in [(at, r, 0, 1.1), (plus(at, scaled(n, r + s + gap)), s, (k % 2) as u8, 7.9)] {
            let i = g.add(centre, radius, material, &materials);
            g.vel[i][..3].copy_from_slice(&scaled(vector(k, seed), speed));
            g.spin[i][..3].copy_from_slice(&scaled(vector(k, seed + 0.7), 100.0 * speed));
        }
        pairs.add(2 * k as u32, 2 * k as u32 + 1);
    }
    (g, pairs)
}

fn lead(v: [f64; 4]) -> [f64; 3] {
    [v[0], v[1], v[2]]
}

fn close(what: &str, found: f64, expected: f64, size: f64) {
    assert!((found - expected).abs() <= 1e-9 * size.abs().max(expected.abs()), "{what}: {found} instead of {expected}");
}

fn close3(what: &str, found: [f64; 3], expected: [f64; 3], size: f64) {
    for a in 0..3 {
        close(what, found[a], expected[a], size.abs());
    }
}

/// What two ends of a contact do to each other in the first step: overlap and R*, relative velocity of the centres, arms times spins, sum and difference of spins.
struct First {
    n: [f64; 3],
    overlap: f64,
    r_eff: f64,
    mass: f64,
    velocity: [f64; 3],
    bending: [f64; 3],
}

/// Checks the contact in a slot after its first step.
fn check(what: &str, law: ContactLaw, pair: &Pair, first: &First, pairs: &Pairs, slot: usize) {
    let First { n, overlap, r_eff, mass, velocity: v, bending } = *first;
    let e = law.elastic(overlap, overlap, r_eff, pair);
    let approach = dot(v, n);
    let dashpot = if law.is_viscous() { pair.viscous * (e.k_n * mass).sqrt() * approach } else { 0.0 };
    let mut normal = e.force + dashpot;
    if law == ContactLaw::HertzViscousNoTension {
        normal = normal.max(0.0);
    }
    let touch = &pairs.touch[slot];
    close(what, touch.overlap, overlap, 1e-3);
    close3(what, touch.normal, n, 1.0);
    close(&format!("{what}: normal"), touch.normal_force, normal, e.force);
    let slip = less(v, scaled(n, approach));
    let limit = pair.friction * normal.max(0.0);
    let limited = |t: [f64; 3]| {
        let size = dot(t, t).sqrt();
        if size > limit { scaled(t, limit / size) } else { t }
    };
    let free = scaled(slip, -e.k_t * DT);
    let spring = limited(free);
    let slides = dot(free, free).sqrt() > limit;
    let viscous = if law.is_viscous() && !slides { pair.viscous * (e.k_t * mass).sqrt() } else { 0.0 };
    let tangential = limited(less(spring, scaled(slip, viscous)));
    close3(&format!("{what}: tangential"), touch.tangential, tangential, limit + 1e-9);
    if law.is_viscous() {
        close3(&format!("{what}: spring"), pairs.spring[slot], spring, limit + 1e-9);
    }
    let moment = scaled(bending, -e.k_t * r_eff * r_eff * DT);
    let (size, most) = (dot(moment, moment).sqrt(), pair.rolling * r_eff * normal.max(0.0));
    let moment = if size > most { scaled(moment, most / size) } else { moment };
    if pairs.kept().rolling {
        close3(&format!("{what}: rolling"), pairs.rolling[slot], moment, most + 1e-12);
    }
    let weight = if pairs.kept().load { (pair.e_eff / r_eff).powi(2) } else { 1.0 };
    close(&format!("{what}: load"), pairs.load(slot), normal * weight, e.force * weight);
    if law == ContactLaw::ElastoPlastic {
        close(what, pairs.largest[slot], overlap, overlap);
    }
    // works: half of the new force's; what sliding does not take up; what dashpots or yielding take
    let path = -0.5 * DT * (dot(tangential, v) - normal * approach);
    let taken = match law {
        ContactLaw::ElastoPlastic => None,
        _ if law.is_viscous() => Some(((normal - e.force) * approach - dot(less(tangential, spring), slip)) * DT),
        _ => Some(0.0),
    };
    let work = pairs.work[slot];
    close(&format!("{what}: path"), work[0], path, e.force * DT);
    let slid = if slides { limit * (dot(free, free).sqrt() - limit) / e.k_t } else { 0.0 };
    close(&format!("{what}: slip"), work[1], slid, limit * DT);
    if let Some(taken) = taken {
        close(&format!("{what}: taken"), work[2], taken, e.force * DT);
    }
}

/// Sweeps over pairs of grains of two materials: normal and tangential force, spring, rolling moment, load and works of the first step are those of the law,
/// alone in a register or side by side with others.
#[test]
fn a_sweep_gives_pairs_of_grains_their_law() {
    for &law in ContactLaw::ALL {
        // without rolling and weights two materials alone ask for the longer code
        let plain = Kept { rolling: false, load: false, ..ALL };
        for (arch, kept) in [(arch(), ALL), (pulp::Arch::Scalar, ALL), (arch(), plain), (pulp::Arch::Scalar, plain)] {
            let (g, mut pairs) = pairs_of_grains(law, 43, kept);
            pairs.remove(5);
            let table = law.pairs(&materials(law), &[], None);
            (law.table().sweep_grains)(kept.rolling, &table, &rules(TangentialUnloading::Keep, arch), &g, Chunk::all(&mut pairs));
            for slot in 0..43 {
                let what = format!("{} {slot}", law.word());
                let [i, j] = [2 * slot, 2 * slot + 1];
                let d = less(lead(g.pos[j]), lead(g.pos[i]));
                let distance = dot(d, d).sqrt();
                let (r, s) = (g.radius(i), g.radius(j));
                if slot == 5 || slot % 7 == 3 {
                    assert_eq!((pairs.touch[slot], pairs.work[slot]), (ContactForce::default(), [0.0; 4]), "{what}");
                    continue;
                }
                let n = scaled(d, 1.0 / distance);
                let overlap = r + s - distance;
                let mean = scaled(plus(lead(g.spin[i]), lead(g.spin[j])), 0.5 * overlap);
                let arms = less(plus(scaled(lead(g.spin[i]), r), scaled(lead(g.spin[j]), s)), mean);
                let velocity = plus(less(lead(g.vel[i]), lead(g.vel[j])), cross(arms, n));
                let difference = less(lead(g.spin[i]), lead(g.spin[j]));
                let bending = less(difference, scaled(n, dot(n, difference)));
                let mass = g.mass[i] * g.mass[j] / (g.mass[i] + g.mass[j]);
                let first = First { n, overlap, r_eff: r * s / (r + s), mass, velocity, bending };
                check(&what, law, table.grains(g.material[i], g.material[j]), &first, &pairs, slot);
            }
        }
    }
}

fn two_walls() -> Vec<Wall> {
    let of = |point, normal, friction, speed, material| {
        Wall::new(&WallSpec { shape: WallShape::Plane { point, normal }, friction, drive: Drive::Velocity(speed), material })
    };
    vec![of([0.0; 3], [0.0, 0.0, 1.0], 0.3, 0.2, None), of([0.0, 0.0, 0.05], [0.0, 0.6, -0.8], 0.7, -0.1, Some(1))]
}

/// Sweeps over pairs of grains with a rigid wall and a wall of a material, both moving.
#[test]
fn a_sweep_gives_pairs_with_walls_their_law() {
    for &law in ContactLaw::ALL {
        for arch in [arch(), pulp::Arch::Scalar] {
            let (materials, walls) = (materials(law), two_walls());
            let table = law.pairs(&materials, &walls, None);
            let (mut g, mut pairs) = (Grains::default(), Pairs::new(ALL));
            for k in 0..41usize {
                let r = 0.01 + 0.004 * wobble(k, 3.1);
                let wall = k % 2;
                let gap = if k % 7 == 3 { 1e-5 } else { -1e-5 * (k + 1) as f64 };
                let WallShape::Plane { point, normal } = walls[wall].shape else { unreachable!() };
                let i = g.add(plus(point, scaled(normal, r + gap)), r, (k / 2 % 2) as u8, &materials);
                let speed = if k % 3 == 0 { 1e-3 } else { 3.0 };
                g.vel[i][..3].copy_from_slice(&scaled(vector(k, 1.7), speed));
                g.spin[i][..3].copy_from_slice(&scaled(vector(k, 4.3), 100.0 * speed));
                pairs.add(i as u32, wall as u32);
            }
            pairs.remove(6);
            (law.table().sweep_walls)(&table, &rules(TangentialUnloading::Keep, arch), &g, &walls, &mut pairs);
            for slot in 0..41 {
                let what = format!("{} {slot}", law.word());
                if slot == 6 || slot % 7 == 3 {
                    assert_eq!((pairs.touch[slot], pairs.work[slot]), (ContactForce::default(), [0.0; 4]), "{what}");
                    continue;
                }
                let wall = &walls[slot % 2];
                let (n, gap) = wall.shape.towards(g.pos[slot]);
                let (r, w) = (g.radius(slot), lead(g.spin[slot]));
                let velocity = plus(plus(lead(g.vel[slot]), scaled(n, wall.speed)), cross(scaled(w, r + gap), n));
                let bending = less(w, scaled(n, dot(n, w)));
                let first = First { n, overlap: -gap, r_eff: r, mass: g.mass[slot], velocity, bending };
                check(&what, law, table.wall(slot % 2, g.material[slot]), &first, &pairs, slot);
            }
        }
    }
}

/// Moves grains for some steps, so that contacts begin, slide and end: every instruction set and every list of slots makes the same bits, and so does a run
/// that keeps no works.
#[test]
fn lanes_change_no_bit_of_a_history() {
    let history = |law: ContactLaw, arch: pulp::Arch, kept: Kept, unloading, some: bool| {
        let (mut g, mut pairs) = pairs_of_grains(law, 35, kept);
        let table = law.pairs(&materials(law), &[], None);
        for step in 0..12 {
            let sweep = |slots: Chunk<'_>| (law.table().sweep_grains)(kept.rolling, &table, &rules(unloading, arch), &g, slots);
            if some {
                (0..35).rev().for_each(|slot| sweep(Chunk::one(&mut pairs, slot)));
            } else {
                sweep(Chunk::all(&mut pairs));
            }
            for i in 0..g.len() {
                let shift = scaled(vector(i, f64::from(step)), 2e-5);
                g.pos[i] = [g.pos[i][0] + shift[0], g.pos[i][1] + shift[1], g.pos[i][2] + shift[2], g.pos[i][3]];
            }
        }
        let touch: Vec<_> = pairs.touch.iter().map(|t| (t.first(), t.second())).collect();
        (touch, pairs.rolling.to_vec(), pairs.spring.to_vec(), pairs.load.to_vec(), pairs.largest.to_vec())
    };
    for &law in ContactLaw::ALL {
        let kept = Kept { spring: law.is_viscous(), largest: law.table().plastic, ..ALL };
        for unloading in [TangentialUnloading::Keep, TangentialUnloading::Rescale] {
            let scalar = history(law, pulp::Arch::Scalar, kept, unloading, false);
            assert!(scalar.0.iter().any(|t| t.1[3] > 0.0) && scalar.0.iter().any(|t| t.1[3] == 0.0));
            for name in ["avx512", "avx2", "scalar"] {
                assert!(history(law, at_best(name), kept, unloading, false) == scalar, "{} {name}", law.word());
                assert!(history(law, at_best(name), kept, unloading, true) == scalar, "{} {name}, listed", law.word());
                assert!(
                    history(law, at_best(name), Kept { work: false, ..kept }, unloading, false) == scalar,
                    "{} {name}",
                    law.word()
                );
            }
        }
    }
}

fn still(normal: [f64; 3], overlap: f64) -> ContactGeometry {
    ContactGeometry { normal, overlap, r_eff: 0.01, m_eff: 0.02, motion: RelativeMotion::default() }
}

fn history(spring: [f64; 3], normal_force: f64, normal: [f64; 3], overlap: f64) -> ContactHistory {
    let touch = ContactForce { tangential: spring, normal_force, normal, overlap };
    ContactHistory { touch, spring: None, rolling: Some([0.0; 3]), load: Some(0.0), largest: None, work: Some([0.0; 3]) }
}

fn hertz_pair() -> Pair {
    Pair::of(&Hertz::coefficients(Moduli { young: 5e7, shear: 2e7 }, &[0.0; 4], None), 0.5, 0.1, 5e7)
}

/// Spins both ends about the normal, or turns the normal: the spring turns with the contact and keeps its length up to the fourth power of the angle.
#[test]
fn a_spring_turns_with_its_contact() {
    let pair = hertz_pair();
    let rules = Rules { dt: 0.1, ..rules(TangentialUnloading::Keep, pulp::Arch::Scalar) };
    let old = history([0.03, 0.0, 0.0], 1.0, [0.0, 0.0, 1.0], 1e-4);
    for angle in [0.01, -0.1] {
        let mut m = still([0.0, 0.0, 1.0], 1e-4);
        m.motion.mean_spin = [0.0, 0.0, angle / 0.1];
        let new = force::touching::<f64, Hertz, true, true>(&m, &pair, &rules, &old);
        let t = new.touch.tangential;
        let size = dot(t, t).sqrt();
        assert!((size / 0.03 - 1.0).abs() < 0.4 * f64::powi(angle, 4) + 1e-12, "{t:?}");
        // of a turn by θ the first order is θ
        assert!((t[1].atan2(t[0]) - angle).abs() < f64::powi(angle, 3).abs() && t[2] == 0.0, "{t:?} {angle}");
        let (s, c) = angle.sin_cos();
        let new = force::touching::<f64, Hertz, true, true>(&still([s, 0.0, c], 1e-4), &pair, &rules, &old);
        let t = new.touch.tangential;
        assert!(
            (t[0] / 0.03 - c).abs() < 0.5 * f64::powi(angle, 4) + 1e-12 && (t[2] / 0.03 + s).abs() < f64::powi(angle, 4) + 1e-9,
            "{t:?} {angle}"
        );
        assert!(dot(t, [s, 0.0, c]).abs() < 1e-15);
    }
}

/// Unloads a contact that does not slip: the tangential force stays, or falls with k_t, until friction limits it; loading leaves it in any case.
#[test]
fn tangential_force_in_unloading() {
    let pair = hertz_pair();
    let normal = [0.0, 0.0, 1.0];
    let at = |unloading, overlap: f64| {
        let old = history([0.01, 0.0, 0.0], 1.0, normal, 1e-4);
        let rules = rules(unloading, pulp::Arch::Scalar);
        force::touching::<f64, Hertz, true, true>(&still(normal, overlap), &pair, &rules, &old).touch.tangential[0]
    };
    for (overlap, kept, fallen) in [(0.81e-4, 0.01, 0.009), (2e-4, 0.01, 0.01)] {
        close("kept", at(TangentialUnloading::Keep, overlap), kept, 1.0);
        close("fallen", at(TangentialUnloading::Rescale, overlap), fallen, 1e-3);
    }
    let limit = 0.5 * ContactLaw::Hertz.elastic(1e-9, 1e-9, 0.01, &pair).force;
    assert!(limit < 0.01);
    close("limited", at(TangentialUnloading::Keep, 1e-9), limit, 0.0);
    // a contact that begins has nothing to rescale
    let old = history([0.0; 3], 0.0, [0.0; 3], 0.0);
    let new = force::touching::<f64, Hertz, true, true>(
        &still(normal, 1e-4),
        &pair,
        &rules(TangentialUnloading::Rescale, pulp::Arch::Scalar),
        &old,
    );
    assert_eq!(new.touch.tangential, [0.0; 3]);
}

/// Ends a contact: the history is empty, and the last half of its work is counted once.
#[test]
fn a_contact_that_ends_leaves_its_last_work() {
    let motion = RelativeMotion { centres: [0.3, 0.0, -0.5], ..RelativeMotion::default() };
    let old = history([0.02, 0.0, 0.0], 4.0, [0.0, 0.0, 1.0], 1e-6);
    let ended = force::apart::<true>(|| motion, DT, &old);
    // power of the force on the first end: t · v − N n · v
    close("work", ended.work.expect("kept")[0], -0.5 * (0.02 * 0.3 + 4.0 * 0.5) * DT, 0.0);
    assert_eq!((ended.touch, ended.rolling, ended.load), (ContactForce::default(), Some([0.0; 3]), Some(0.0)));
    assert_eq!(force::apart::<true>(|| motion, DT, &ended).work, Some([0.0; 3]));
    assert_eq!(force::apart::<false>(|| motion, DT, &old).work, None);
}

/// Rolls a contact on: moments add up to the limit and turn with the contact.
#[test]
fn rolling_moments_add_up() {
    let pair = hertz_pair();
    let rules = rules(TangentialUnloading::Keep, pulp::Arch::Scalar);
    let mut m = still([0.0, 0.0, 1.0], 1e-4);
    m.motion.spin_difference = [2.0, 0.0, 5.0];
    let e = ContactLaw::Hertz.elastic(1e-4, 1e-4, 0.01, &pair);
    let mut old = history([0.0; 3], 0.0, [0.0, 0.0, 1.0], 1e-4);
    for k in 1..4 {
        old = force::touching::<f64, Hertz, true, true>(&m, &pair, &rules, &old);
        close3("moment", old.rolling.expect("kept"), [-2.0 * e.k_t * 1e-4 * DT * f64::from(k), 0.0, 0.0], 1e-12);
    }
    m.motion.spin_difference = [2e6, 0.0, 5.0];
    old = force::touching::<f64, Hertz, true, true>(&m, &pair, &rules, &old);
    close3("limit", old.rolling.expect("kept"), [-0.1 * 0.01 * e.force, 0.0, 0.0], 1e-12);
    let none = force::touching::<f64, Hertz, true, false>(&m, &pair, &rules, &old);
    assert!(none.rolling.is_none() && none.load.is_none(), "the shorter code keeps neither");
}

/// Takes slots, frees them, sorts them: histories stay with their pairs.
#[test]
fn slots_keep_histories_with_their_pairs() {
    let mut pairs = Pairs::new(ALL);
    for k in 0..5u32 {
        assert_eq!(pairs.add(k, k + 10), k);
        let s = k as usize;
        pairs.touch[s].overlap = if k == 2 { 0.0 } else { 1.0 + f64::from(k) };
        pairs.touch[s].normal_force = 10.0 * f64::from(k);
        (pairs.load[s], pairs.largest[s], pairs.spring[s]) = (100.0 * f64::from(k), 3.0, [f64::from(k), 0.0, 0.0]);
    }
    assert_eq!(pairs.touching(|[i, j]| [100 - i, j]), [4, 3, 1, 0]);
    assert_eq!((pairs.load(3), pairs.spring(3), pairs.largest(3, 2.0), pairs.largest(3, 4.0)), (300.0, [3.0, 0.0, 0.0], 3.0, 4.0));
    pairs.remove(1);
    assert_eq!((pairs.ends[1], pairs.touch[1], pairs.load[1], pairs.slots()), ([FREE; 2], ContactForce::default(), 0.0, 5));
    assert_eq!((pairs.spring[1], pairs.largest[1]), ([0.0; 3], 0.0));
    assert_eq!(pairs.touching(|ends| ends), [0, 3, 4]);
    assert_eq!((pairs.add(7, 8), pairs.ends[1]), (1, [7, 8]));
    pairs.remove(0);
    pairs.permute(&[4, 1, 3], |[i, j]| [j, i]);
    assert_eq!((pairs.ends.clone(), pairs.slots()), (vec![[14, 4], [8, 7], [13, 3]], 3));
    assert_eq!((pairs.load[0], pairs.spring[2]), (400.0, [3.0, 0.0, 0.0]));
    assert_eq!(pairs.add(1, 2), 3, "no slot that was dropped is used again");
    let plain = {
        let mut pairs = Pairs::new(Kept::default());
        pairs.add(0, 1);
        pairs.touch[0] = ContactForce { tangential: [1.0, 2.0, 3.0], normal_force: 5.0, normal: [0.0, 1.0, 0.0], overlap: 0.5 };
        pairs
    };
    assert_eq!((plain.load(0), plain.spring(0), plain.largest(0, 0.5)), (5.0, [1.0, 2.0, 3.0], 0.5));
    assert_eq!(plain.touch[0].force(), [1.0, -3.0, 3.0]);
    assert_eq!((plain.kept(), pairs.kept()), (Kept::default(), ALL));
}

/// Parameters of pairs: moduli in series, the smaller friction of two materials, the wall's own friction, and the friction of a preparation between grains only.
#[test]
fn parameters_of_pairs_are_those_of_their_materials() {
    let law = ContactLaw::Hertz;
    let (m, walls) = (materials(law), two_walls());
    let table = law.pairs(&m, &walls, None);
    let plane = |m: &Material| m.young / (1.0 - m.poisson * m.poisson);
    let shear = |m: &Material| m.young / (2.0 * (1.0 + m.poisson)) / (2.0 - m.poisson);
    let series = |a: f64, b: f64| 1.0 / (1.0 / a + 1.0 / b);
    for (found, young, shear, friction, rolling) in [
        (table.grains(0, 1), series(plane(&m[0]), plane(&m[1])), series(shear(&m[0]), shear(&m[1])), 0.25, 0.1),
        (table.grains(1, 1), 0.5 * plane(&m[1]), 0.5 * shear(&m[1]), 0.25, 0.3),
        (table.wall(0, 1), plane(&m[1]), shear(&m[1]), 0.3, 0.3),
        (table.wall(1, 0), series(plane(&m[0]), plane(&m[1])), series(shear(&m[0]), shear(&m[1])), 0.7, 0.1),
    ] {
        close("E*", found.normal_stiffness, 4.0 / 3.0 * young, 0.0);
        close("G*", found.tangential_stiffness, 8.0 * shear, 0.0);
        close("E'", found.e_eff, young, 0.0);
        assert_eq!((found.friction, found.rolling, found.viscous, found.yield_overlap), (friction, rolling, 0.0, 0.0));
    }
    assert_eq!(table.grains(0, 1), table.grains(1, 0));
    assert!(!table.is_single() && table.materials() == 2 && law.pairs(&m[..1], &[], None).is_single());
    let smooth = law.pairs(&m, &walls, Some(0.05));
    assert_eq!((smooth.grains(0, 1).friction, smooth.wall(0, 0).friction), (0.05, 0.3));
}

/// Force, stiffness and energy of each elastic law are those of its source, and belong to each other.
#[test]
fn stiffness_is_the_slope_of_the_force_and_energy_its_area() {
    let (r, overlap) = (0.004, 3e-5);
    for &law in ContactLaw::ALL {
        let m = materials(law);
        let pair = law.between(&m[0], &m[1]);
        let at = |x: f64| law.elastic(x, x, r, &pair);
        let e = at(overlap);
        let h = 1e-4 * overlap;
        // beyond yield the larger stiffness is that of unloading
        if law != ContactLaw::ElastoPlastic {
            close(law.word(), (at(overlap + h).force - at(overlap - h).force) / (2.0 * h) / e.k_n, 1.0, 1e2);
            close(law.word(), (at(overlap + h).energy - at(overlap - h).energy) / (2.0 * h) / e.force, 1.0, 1e2);
        }
        if law.is_hertzian() && law != ContactLaw::ElastoPlastic {
            close(law.word(), e.force, pair.normal_stiffness * r.sqrt() * overlap.powf(1.5), 0.0);
            close(law.word(), e.k_t, pair.tangential_stiffness * (r * overlap).sqrt(), 0.0);
        }
    }
    let linear = ContactLaw::Linear;
    let m = materials(linear);
    let pair = linear.between(&m[0], &m[1]);
    let Elastic { force, k_n, k_t, .. } = linear.elastic(overlap, overlap, r, &pair);
    // eq. 13 with the harmonic mean of K_eff, 1 and 0.3 MPa
    let k = 4.0 * (2.0 / (1.0 / 1e6 + 1.0 / 3e5)) * r;
    close("linear", k_n, k, 0.0);
    close("linear", force, k * overlap, 0.0);
    close("linear", k_t, 0.4 * k, 0.0);
    let on_wall = linear.on_wall(&m[0], 0.3);
    close("linear on a wall", linear.elastic(overlap, overlap, r, &on_wall).k_n, 4.0 * 1e6 * r, 0.0);
    close("linear on a wall", linear.elastic(overlap, overlap, r, &on_wall).k_t, 1.6 * 1e6 * r, 0.0);
    // √(m/(4 K_eff R)), and the Rayleigh time
    close("free step", (linear.table().free_step)(&m[0], 0.5, 1.0, 0.02), (0.5 / (4.0 * 1e6 * 0.02f64)).sqrt(), 0.0);
    let rayleigh = std::f64::consts::PI * 0.03 * (2500.0f64 / (1e8 / 2.4)).sqrt() / (0.163 * 0.2 + 0.877);
    close("free step", (ContactLaw::Hertz.table().free_step)(&m[0], 0.5, 0.03, 1.0), rayleigh, 0.0);
    assert_eq!([ContactLaw::Hertz, ContactLaw::Linear].map(|law| (law.table().restitution)(&[0.3; 4])), [1.0; 2]);
    assert_eq!(
        [ContactLaw::HertzViscous, ContactLaw::HertzViscousNoTension].map(|law| (law.table().restitution)(&[0.3; 4])),
        [0.3; 2]
    );
}

/// Flies a mass against a Hertzian contact with a dashpot, in small steps: it leaves with the restitution for which the coefficient was made, with the force that
/// may become tensile and with the one that may not. A restitution of two materials is the geometric mean.
#[test]
fn dashpots_give_their_restitution() {
    let impact = |c: f64, tension: bool| {
        let (mut x, mut v, dt) = (0.0f64, 1.0, 2e-6);
        loop {
            let force = |x: f64, v: f64| {
                let d = x.max(0.0);
                // mass 1, F = d^(3/2), stiffness 1.5 √d
                d.powf(1.5) + c * (1.5 * d.sqrt()).sqrt() * v
            };
            let half = v - 0.5 * dt * force(x, v);
            let middle = x + 0.5 * dt * v;
            let f = force(middle, half);
            if v < 0.0 && (if tension { x <= 0.0 } else { f <= 0.0 }) {
                return -v;
            }
            x += dt * half;
            v -= dt * f;
        }
    };
    for e in [0.9, 0.5, 0.15] {
        let found = [impact(viscous_coefficient(e), true), impact(viscous_coefficient_without_tension(e), false)];
        assert!(found.iter().all(|f| (f - e).abs() < 2e-4), "{e}: {found:?}");
    }
    assert!(viscous_coefficient(1.0) == 0.0 && viscous_coefficient_without_tension(1.0).abs() < 1e-12);
    let of = |second| HertzViscous::coefficients(Moduli { young: 1.0, shear: 1.0 }, &[0.9, 0.0, 0.0, 0.0], second).viscous;
    close("mean", of(Some(&[0.4, 0.0, 0.0, 0.0])), viscous_coefficient(0.6), 0.0);
    close("one", of(None), viscous_coefficient(0.9), 0.0);
}

/// Tables for a law of the calling program.
#[test]
fn a_law_of_the_program_is_its_own() {
    static TABLE: super::registry::LawTable = super::registry::LawTable::of::<Hertz>();
    let custom = ContactLaw::Custom(&TABLE);
    assert!(custom == ContactLaw::Custom(&TABLE) && custom != ContactLaw::Hertz && custom.is_hertzian() && !custom.is_viscous());
    assert_eq!(custom.word(), "custom");
    let m = materials(ContactLaw::Hertz);
    let _: PairTable = custom.pairs(&m, &[], None);
    assert_eq!(custom.between(&m[0], &m[1]), ContactLaw::Hertz.between(&m[0], &m[1]));
}

/// Contacts from outside are taken only if their ends are grains in their order, none stands twice, all numbers are finite, and free places are free.
#[test]
fn contacts_from_outside_are_checked() {
    let ids = [5, 7, 9];
    let mut right = Pairs::new(ALL);
    for (i, j) in [(0, 1), (1, 2), (0, 2)] {
        right.add(i, j);
    }
    right.remove(1);
    assert_eq!(right.check(&ids, 3, true, ALL), Ok(()));
    assert!(right.check(&ids, 3, true, Kept::default()).is_err() && right.check(&ids, 2, true, ALL).is_err());
    let wrong: [&dyn Fn(&mut Pairs); 16] = [
        &|p| p.ends[0] = [1, 0],
        &|p| p.ends[0] = [1, 1],
        &|p| p.ends[0] = [3, 1],
        &|p| p.ends[0] = [0, 3],
        &|p| p.ends[0] = [0, 2],
        &|p| p.ends[0] = [FREE; 2],
        &|p| p.ends[0] = [FREE, 1],
        &|p| p.ends[0] = [0, FREE],
        &|p| p.ends[1] = [1, 2],
        &|p| p.touch[1].overlap = 1.0,
        &|p| p.touch[0].normal[1] = f64::NAN,
        &|p| p.work[2][1] = f64::NAN,
        &|p| p.rolling[0][2] = f64::INFINITY,
        &|p| p.spring[0][0] = f64::NAN,
        &|p| p.load[2] = f64::NAN,
        &|p| p.largest[0] = f64::INFINITY,
    ];
    for (k, change) in wrong.into_iter().enumerate() {
        let mut pairs = right.clone();
        change(&mut pairs);
        assert!(pairs.check(&ids, 3, true, ALL).is_err(), "number {k}");
    }
    // the second ends of pairs with walls are walls, in any order
    let mut on_walls = Pairs::new(Kept::default());
    for (i, k) in [(2, 0), (0, 1)] {
        on_walls.add(i, k);
    }
    assert_eq!(on_walls.check(&ids, 2, false, Kept::default()), Ok(()));
    assert!(on_walls.check(&ids, 1, false, Kept::default()).is_err());
}
