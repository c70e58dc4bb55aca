//! One grain or wall and a few points, against closed forms.

use super::evaluate::PointContactScene;
use super::*;
use crate::boundary::{Drive, Wall, WallShape, WallSpec};
use crate::contact::pair::Pair;
use crate::contact::{ContactLaw, TangentialUnloading};
use crate::dem::physics::Physics;
use crate::dem::{State, Workspace};
use crate::grains::{Grains, sphere_volume};
use crate::material::{InterfaceFriction, Material};
use crate::math::vector::{cross, dot, less, plus, scaled};
use crate::mpm::law::{Elastic, Law};
use crate::mpm::{Continuum, Dimension, GridWall, Point, Points, Settings, ShapeFunctions, Transfer};
use crate::point_contacts::{ActsOn, GhostFace, PointContactTable};
use crate::rigid::{Block, Blocks};
use crate::shape::{Cuboid, Shape};

/// Radius of the grain and ghost radius of points, m.
const R: f64 = 0.1;
const A: f64 = 0.02;

pub(super) fn material(restitution: f64) -> Material {
    Material {
        name: "glass".into(),
        density: 2500.0,
        internal_porosity: 0.0,
        young: 1e8,
        poisson: 0.2,
        friction: 0.4,
        contact: [restitution, 0.0, 0.0, 0.0],
        rolling_friction: 0.0,
        interface_friction: None,
    }
}

pub(super) fn physics(law: ContactLaw) -> Physics {
    Physics::of(vec![material(0.6)], law)
}

pub(super) fn point(position: [f64; 3], velocity: [f64; 3]) -> Point {
    let volume = sphere_volume(A);
    Point { position, velocity, mass: 2500.0 * volume, volume, stress: [0.0; 6], porosity: 0.0, law: 0 }
}

/// A grid of cells of 0.125 m around the origin.
pub(super) fn settings() -> Settings {
    Settings {
        dimension: Dimension::Space,
        cell: 0.125,
        lower: [-1.0; 3],
        cells: [16; 3],
        walls: [GridWall::Open; 6],
        gravity: [0.0; 3],
        shape: ShapeFunctions::BSpline,
        transfer: Transfer::Blend { pic: 0.0 },
        damping: 0.0,
    }
}

pub(super) fn continuum(points: &[Point]) -> Continuum {
    sheared_continuum(points, |_| 0.0)
}

/// Points that have these plastic strains.
fn sheared_continuum(points: &[Point], plastic: impl Fn(usize) -> f64) -> Continuum {
    let mut all = Points::default();
    for (k, p) in points.iter().enumerate() {
        all.add(p);
        all.memory[k].plastic = plastic(k);
    }
    let mut continuum = Continuum::new(settings(), vec![Law::Elastic(Elastic::of_young(1e6, 0.3))], all).expect("allowed");
    continuum.keep_transport_velocity();
    continuum
}

pub(super) fn grain(at: [f64; 3], velocity: [f64; 3], spin: [f64; 3], physics: &Physics) -> Grains {
    let mut grains = Grains::default();
    grains.add(at, R, 0, &physics.materials);
    grains.vel[0][..3].copy_from_slice(&velocity);
    grains.spin[0][..3].copy_from_slice(&spin);
    grains
}

pub(super) fn floor(speed: f64) -> Wall {
    let shape = WallShape::Plane { point: [0.0; 3], normal: [0.0, 0.0, 1.0] };
    Wall::new(&WallSpec { shape, friction: 0.3, drive: Drive::Velocity(speed), material: None })
}

/// Contacts of everything that is given, found and computed once.
struct Scene {
    physics: Physics,
    grains: Grains,
    walls: Vec<Wall>,
    continuum: Continuum,
    table: PointContactTable,
    contacts: PointContacts,
}

impl Scene {
    fn new(physics: Physics, grains: Grains, walls: Vec<Wall>, continuum: Continuum) -> Scene {
        let table = PointContactTable::new(physics.contact.law, &[0], &physics.materials, &walls).acting_on(ActsOn::Face);
        let mut contacts = PointContacts::default();
        contacts.update(&grains, &walls, &continuum, 1e-6);
        Scene { physics, grains, walls, continuum, table, contacts }
    }

    fn evaluate(&mut self, dt: f64, ahead: [f64; 2]) {
        let Scene { physics, grains, walls, continuum, table, contacts } = self;
        let scene = PointContactScene { grains, walls, continuum, table, unloading: physics.contact.unloading, dt, ahead };
        contacts.evaluate(&scene);
    }

    fn pair(&self) -> Pair {
        *self.table.of_grain(0, 0)
    }
}

fn near(found: f64, expected: f64) {
    assert!((found - expected).abs() <= 1e-10 * expected.abs().max(1e-30), "{found} instead of {expected}");
}

fn near3(found: [f64; 3], expected: [f64; 3]) {
    let size = dot(expected, expected).sqrt();
    assert!((0..3).all(|a| (found[a] - expected[a]).abs() <= 1e-10 * size), "{found:?} instead of {expected:?}");
}

/// A unit vector without zeros.
fn oblique() -> [f64; 3] {
    [2.0 / 7.0, -3.0 / 7.0, 6.0 / 7.0]
}

/// R* of grain and ghost, and Hertz's force and stiffnesses at an overlap.
fn hertz(pair: &Pair, overlap: f64) -> [f64; 3] {
    let r = R * A / (R + A);
    let root = (r * overlap).sqrt();
    [pair.normal_stiffness * root * overlap, 1.5 * pair.normal_stiffness * root, pair.tangential_stiffness * root]
}

/// Where a point overlaps the grain by `overlap`, m, on the line `n` through its centre.
fn beside(centre: [f64; 3], n: [f64; 3], overlap: f64) -> [f64; 3] {
    plus(centre, scaled(n, R + A - overlap))
}

/// A contact acts on a grain and on the face of a point at the same place: forces and moments about any place add up to nothing. The overlap is the distance of
/// the face behind the grain's surface.
#[test]
fn both_ends_of_a_contact_are_pressed_at_one_place() {
    let physics = physics(ContactLaw::Hertz);
    let (centre, n) = ([0.31, -0.2, 0.13], oblique());
    let at = beside(centre, n, 2e-3);
    let grains = grain(centre, [0.5, 0.2, -0.3], [3.0, -4.0, 2.0], &physics);
    let mut scene = Scene::new(physics, grains, Vec::new(), continuum(&[point(at, [0.0; 3])]));
    scene.evaluate(1e-4, [0.0; 2]);
    for beyond in [0.0, 5e-4, -8e-4] {
        scene.contacts.candidates[0].face.as_mut().expect("they touch").beyond = beyond;
        scene.evaluate(1e-4, [0.0; 2]);
        let Scene { grains, continuum, contacts, .. } = &mut scene;
        let contact = contacts.candidates[0];
        near(contact.touch.overlap, 2e-3 + beyond);
        let mut applied = Vec::new();
        contacts.apply_reactions(grains, &mut applied, 1.0, (continuum, ActsOn::Centre), [1.0, 0.0]);
        let [force, torque] = applied[0].map(|v| [v[0], v[1], v[2]]);
        assert!(dot(torque, torque) > 0.0);
        let on_point = cross(plus(at, contact.offset(0.125)), scaled(force, -1.0));
        near3(plus(cross(centre, force), torque), scaled(on_point, -1.0));
    }
}

/// A face whose point moves away from the body for long stays within a cell of the ghost: from then on the distance from the body opens the contact.
#[test]
fn a_face_is_torn_off_at_a_cell() {
    let (x, cell) = ([0.13, 0.0, 0.0], settings().cell);
    let mut continuum = continuum(&[point(x, [1.0, 0.0, 0.0]), point(less(x, [0.5 * cell, 0.0, 0.0]), [-1.0, 0.0, 0.0])]);
    continuum.step(1e-6).expect("a step");
    let mut face = GhostFace::at_first_touch([1.0, 0.0, 0.0], [0.0; 3]);
    let mut grown = Vec::new();
    for _ in 0..10_000 {
        face.follow(&continuum, 0, [A, 0.0], 1e-3 * cell);
        grown.push(face.beyond / cell);
    }
    assert!(grown[0] > 1e-4 && grown[0] < 1e-2 && grown.is_sorted(), "{}", grown[0]);
    near(grown[9999], GhostFace::FURTHEST);
}

/// Presses many points around a grain, one by one as deep as the next: each has Hertz's force, whether it is computed alone or with others side by side.
#[test]
fn points_around_a_grain_have_the_force_of_hertz() {
    let physics = physics(ContactLaw::Hertz);
    let centre = [0.01, -0.02, 0.03];
    let directions: Vec<[f64; 3]> = (0..37)
        .map(|k| {
            let z = -0.95 + 0.05 * f64::from(k);
            let (s, c) = (2.4 * f64::from(k)).sin_cos();
            let h = (1.0 - z * z).sqrt();
            [h * c, h * s, z]
        })
        .collect();
    // every fourth does not touch
    let overlap = |k: usize| if k % 4 == 3 { -1e-4 } else { 1e-5 * (k + 1) as f64 };
    let points: Vec<Point> = directions.iter().enumerate().map(|(k, n)| point(beside(centre, *n, overlap(k)), [0.0; 3])).collect();
    let grains = grain(centre, [0.0; 3], [0.0; 3], &physics);
    let mut scene = Scene::new(physics, grains, Vec::new(), continuum(&points));
    scene.evaluate(1e-5, [0.0; 2]);
    let pair = scene.pair();
    assert_eq!(scene.contacts.candidates.len(), 37);
    let (mut sum, mut energy, mut per_mass, mut of_grain) = ([0.0; 3], 0.0, 0.0f64, 0.0);
    for (contact, k) in scene.contacts.candidates.iter().zip(0..) {
        assert_eq!((contact.point, contact.body), (k as u32, Body::Grain(0)));
        if overlap(k) <= 0.0 {
            assert_eq!((contact.touch, contact.stiffness), (ContactForce::default(), [0.0; 2]));
            assert_eq!((contact.energy(0.4), contact.inertia_stiffness()), (0.0, 0.0));
            continue;
        }
        let [force, k_n, k_t] = hertz(&pair, overlap(k));
        let n = directions[k];
        // rounding of the distance over the overlap
        let close = |a: f64, b: f64| assert!((a / b - 1.0).abs() < 1e-9, "{k}: {a} {b}");
        close(contact.touch.normal_force, force);
        close(contact.stiffness[0], k_n);
        close(contact.stiffness[1], k_t);
        close(contact.inertia_stiffness(), (2.0 * k_n).max(7.0 * k_t));
        // where the tangential stiffness is small, the normal one counts
        close(PointContact { stiffness: [k_n, 0.1 * k_n], ..*contact }.inertia_stiffness(), 2.0 * k_n);
        assert!((0..3).all(|a| (contact.force()[a] + force * n[a]).abs() < 1e-9 * force));
        sum = less(sum, scaled(n, force));
        energy += 0.4 * force * overlap(k);
        per_mass = per_mass.max(k_n.max(k_t) / points[k].mass);
        of_grain += k_n.max(3.5 * k_t) / scene.grains.mass[0];
    }
    let close = |a: f64, b: f64| assert!((a / b - 1.0).abs() < 1e-9, "{a} {b}");
    close(scene.contacts.stored(0.4), energy);
    let n = scene.continuum.points().len();
    let mut buffers = [Vec::new(), Vec::new()];
    let rates = scene.contacts.rates(&scene.grains, &mut buffers, n);
    close(rates.points, per_mass);
    close(rates.grains, of_grain);
    assert!(buffers.iter().flatten().all(|x| *x == 0.0), "left as zeros");
    assert_eq!(scene.contacts.touching().count(), 28);
    assert_eq!(scene.contacts.on_grains().map(|(_, point, _, _)| point).collect::<Vec<_>>().len(), 28);

    // the grain gets a share of the sum, points get shares of the opposite forces; as without points at first
    let mut external = vec![[[1.0, 2.0, 3.0, 0.0], [0.0; 4]]];
    scene.contacts.apply_reactions(&scene.grains, &mut external, 0.25, (&mut scene.continuum, ActsOn::Centre), [0.5, 1.0]);
    let [x, y, z, _] = external[0][0];
    near3([x - 1.0, y - 2.0, z - 3.0], scaled(sum, 0.25));
    let before = scene.continuum.totals().momentum;
    scene.continuum.step(1e-6).expect("a step");
    let given = less(scene.continuum.totals().momentum, before);
    assert!((0..3).all(|a| (given[a] + 0.5e-6 * sum[a]).abs() < 1e-6 * dot(sum, sum).sqrt() * 1e-6), "{given:?} {sum:?}");
}

/// Points that slide around a grain that spins: each passes on the friction at its own plastic strain, whether it is computed alone or with others side by side.
#[test]
fn friction_falls_with_the_plastic_strain_of_each_point() {
    let falling = InterfaceFriction { initial: 0.3, residual: 0.1, decay: 20.0 };
    let material = Material { interface_friction: Some(falling), ..material(0.6) };
    let physics = Physics::of(vec![material], ContactLaw::Hertz);
    let around = |k: usize| {
        let (s, c) = (0.3 * k as f64).sin_cos();
        point(beside([0.0; 3], [c, s, 0.0], 1e-3), [0.0; 3])
    };
    let points: Vec<Point> = (0..19).map(around).collect();
    let strain = |k: usize| 0.01 * k as f64;
    let grains = grain([0.0; 3], [0.0; 3], [0.0, 0.0, 500.0], &physics);
    let mut scene = Scene::new(physics, grains, Vec::new(), sheared_continuum(&points, strain));
    scene.evaluate(1e-4, [0.0; 2]);
    assert_eq!(scene.contacts.touching().count(), 19);
    for (k, contact) in scene.contacts.candidates.iter().enumerate() {
        let tangential = dot(contact.touch.tangential, contact.touch.tangential).sqrt();
        let expected = 0.1 + 0.2 * (-20.0 * strain(k)).exp();
        assert!((tangential / contact.touch.normal_force / expected - 1.0).abs() < 1e-12, "{k}: {tangential} {expected}");
    }
}

/// Slides the contact of a grain that moves and spins: the spring takes k_t times the slip at the middle of the overlap, and friction limits it; the torque
/// on the grain has the arm r − δ/2.
#[test]
fn tangential_force_and_torque_follow_the_slip_at_the_contact() {
    for (speed, slides) in [(1e-3, false), (100.0, true)] {
        let physics = physics(ContactLaw::Hertz);
        let (n, overlap, dt) = (oblique(), 2e-3, 1e-5);
        let (v, w, u) =
            ([0.3 * speed, 0.5 * speed, -0.1 * speed], [4.0 * speed, -3.0 * speed, 7.0 * speed], [-0.2 * speed, 0.0, 0.4 * speed]);
        let p = point(beside([0.0; 3], n, overlap), u);
        let grains = grain([0.0; 3], v, w, &physics);
        let mut scene = Scene::new(physics, grains, Vec::new(), continuum(&[p]));
        scene.evaluate(dt, [0.0; 2]);
        let [force, _, k_t] = hertz(&scene.pair(), overlap);
        let relative = plus(less(v, u), cross(w, scaled(n, R - 0.5 * overlap)));
        let slip = less(relative, scaled(n, dot(relative, n)));
        let mut tangential = scaled(slip, -k_t * dt);
        let size = dot(tangential, tangential).sqrt();
        assert_eq!(size > 0.4 * force, slides);
        if slides {
            tangential = scaled(tangential, 0.4 * force / size);
        }
        let contact = scene.contacts.candidates[0];
        near3(contact.touch.tangential, tangential);
        near3(contact.force(), less(tangential, scaled(n, force)));
        near(contact.energy(0.4), 0.4 * force * overlap + 0.5 * dot(tangential, tangential) / k_t);
        let mut external = Vec::new();
        scene.contacts.apply_reactions(&scene.grains, &mut external, 1.0, (&mut scene.continuum, ActsOn::Centre), [1.0, 0.0]);
        let [x, y, z, _] = external[0][1];
        near3([x, y, z], cross(scaled(n, R - 0.5 * overlap), tangential));
        // the second evaluation adds another step to the spring that sticks
        scene.evaluate(dt, [0.0; 2]);
        let again = scene.contacts.candidates[0].touch.tangential;
        let sum = dot(again, again).sqrt();
        assert!((sum / if slides { 0.4 * force } else { 2.0 * size } - 1.0).abs() < 1e-3, "{again:?}");
    }
}

/// Damps: the dashpot has the reduced mass of grain and point, and on a wall the mass of the point.
#[test]
fn dashpots_have_the_reduced_mass() {
    let physics = physics(ContactLaw::HertzViscous);
    let overlap = 1e-3;
    let (n, v) = ([0.0, 0.0, 1.0], 0.05);
    let at = beside([0.0, 0.0, 0.3], n, overlap);
    let on_floor = point([0.5, 0.0, A - overlap], [0.0, 0.0, -v]);
    let grains = grain([0.0, 0.0, 0.3], [0.0, 0.0, v], [0.0; 3], &physics);
    let mut scene = Scene::new(physics, grains, vec![floor(0.01)], continuum(&[point(at, [0.0; 3]), on_floor]));
    scene.evaluate(1e-6, [0.0; 2]);
    let [of_grain, of_wall] = [0, 1].map(|k| scene.contacts.candidates[k]);
    let (pair, mass) = (scene.pair(), on_floor.mass);
    let [force, k_n, _] = hertz(&pair, overlap);
    let reduced = mass * scene.grains.mass[0] / (mass + scene.grains.mass[0]);
    near(of_grain.touch.normal_force, force + pair.viscous * (k_n * reduced).sqrt() * v);
    let wall = *scene.table.of_wall(0, 0);
    let root = (A * overlap).sqrt();
    let force =
        wall.normal_stiffness * root * overlap + wall.viscous * (1.5 * wall.normal_stiffness * root * mass).sqrt() * (v + 0.01);
    near(of_wall.touch.normal_force, force);
    near3(of_wall.force(), [0.0, 0.0, -force]);
    near(scene.contacts.reaction(0), force);
    assert_eq!(scene.contacts.reaction(1), 0.0);
    // the grain's contact is not the wall's: only one of them is on a grain, and only the wall's has no torque
    assert_eq!(scene.contacts.on_grains().count(), 1);
}

/// Extrapolates positions in time: grains and walls by the first time, points by the second.
#[test]
fn positions_are_extrapolated_with_the_velocities() {
    let physics = physics(ContactLaw::Hertz);
    let overlap = 1e-3;
    let at = beside([0.0, 0.0, 0.3], [1.0, 0.0, 0.0], overlap);
    let on_floor = point([0.5, 0.0, A - overlap], [0.0, 0.0, -0.2]);
    let grains = grain([0.0, 0.0, 0.3], [0.3, 0.0, 0.0], [0.0; 3], &physics);
    let mut scene = Scene::new(physics, grains, vec![floor(0.4)], continuum(&[point(at, [0.1, 0.0, 0.0]), on_floor]));
    for (ahead, of_grain, of_wall) in
        [([0.0, 0.0], 0.0, 0.0), ([1e-3, 0.0], 0.3e-3, 0.4e-3), ([0.0, 1e-3], -0.1e-3, 0.2e-3), ([1e-3, 2e-3], 0.1e-3, 0.8e-3)]
    {
        scene.evaluate(1e-9, ahead);
        let found = [0, 1].map(|k: usize| scene.contacts.candidates[k].touch.overlap - overlap);
        assert!((found[0] - of_grain).abs() < 1e-15 && (found[1] - of_wall).abs() < 1e-15, "{ahead:?}: {found:?}");
    }
}

/// Bears points from a breakage with overlaps that make no force; overlaps that grow press, overlaps that shrink are forgotten, and sliding releases them.
#[test]
fn an_overlap_from_birth_bears_no_force() {
    let physics = physics(ContactLaw::Hertz);
    let (n, overlap) = (oblique(), 2e-3);
    let grains = grain([0.0; 3], [0.0; 3], [0.0; 3], &physics);
    let mut scene =
        Scene::new(physics, grains, Vec::new(), continuum(&[point(beside([0.0; 3], [0.0, 0.0, -1.0], overlap), [0.0; 3])]));
    let first = scene.continuum.insert(&[point(beside([0.0; 3], n, overlap), [0.0; 3])]);
    scene.contacts.note_newborn(first, 1);
    scene.contacts.update(&scene.grains, &scene.walls, &scene.continuum, 1e-6);
    assert!(!scene.contacts.is_newborn(0) && scene.contacts.is_newborn(first));
    scene.evaluate(1e-6, [0.0; 2]);
    let of = |scene: &Scene, k: usize| scene.contacts.candidates[k];
    assert!(of(&scene, 0).touch.normal_force > 0.0);
    assert_eq!(of(&scene, 1).touch.normal_force, 0.0);
    assert!((of(&scene, 1).reference - overlap).abs() < 1e-15);
    // deeper by a quarter: only that presses
    let place = |scene: &mut Scene, overlap: f64| {
        let [x, y, z] = beside([0.0; 3], n, overlap);
        scene.continuum.points_mut().position[1][..3].copy_from_slice(&[x, y, z]);
        scene.evaluate(1e-6, [0.0; 2]);
    };
    place(&mut scene, 1.25 * overlap);
    let pressed = of(&scene, 1).touch;
    assert!((pressed.overlap / (0.25 * overlap) - 1.0).abs() < 1e-9, "{pressed:?}");
    // slides by a tenth of the release strain times the ghost's diameter
    let strain = 0.5;
    let speed = 0.1 * strain * 2.0 * A / 1e-6;
    scene.contacts.candidates[1].face.as_mut().expect("they touch").velocity = [speed, 0.0, 0.0];
    let Scene { physics, grains, walls, continuum, table, contacts } = &mut scene;
    let view =
        PointContactScene { grains, walls, continuum, table, unloading: physics.contact.unloading, dt: 1e-6, ahead: [0.0; 2] };
    let gained = contacts.release(&view, strain);
    near(of(&scene, 1).reference, 0.9 * overlap);
    near(gained, pressed.normal_force * 0.1 * overlap);
    assert_eq!(of(&scene, 0).reference, 0.0);
    // apart and back: nothing is left of it
    scene.contacts.candidates[1].face.as_mut().expect("they touch").velocity = [0.0; 3];
    place(&mut scene, -1e-4);
    assert_eq!((of(&scene, 1).reference, of(&scene, 1).touch), (0.0, ContactForce::default()));
    place(&mut scene, overlap);
    assert!((of(&scene, 1).touch.overlap / overlap - 1.0).abs() < 1e-9);
}

/// Lists every pair that touches or may touch soon, keeps its history in a new search, and follows grains and points whose places in memory change.
#[test]
fn lists_hold_all_pairs_and_follow_memory() {
    let physics = physics(ContactLaw::Hertz);
    let mut grains = Grains::default();
    for k in 0..5 {
        grains.add([0.25 * f64::from(k) - 0.5, 0.0, 0.12], 0.06 + 0.01 * f64::from(k), 0, &physics.materials);
    }
    let mut points = Vec::new();
    for k in 0..600 {
        let x = |p: f64| (p * f64::from(k + 1)).fract();
        points.push(point([1.6 * x(0.618_034) - 0.8, 0.5 * x(0.414_214) - 0.25, 0.3 * x(0.732_051)], [0.0; 3]));
    }
    let mut scene = Scene::new(physics, grains, vec![floor(0.0)], continuum(&points));
    scene.evaluate(1e-6, [0.0; 2]);
    let touching = |scene: &Scene| {
        let mut pairs = Vec::new();
        let (g, p) = (&scene.grains, scene.continuum.points());
        for j in 0..p.len() {
            let [x, y, z, _] = p.position[j];
            for i in 0..g.len() {
                let d = less([x, y, z], [g.pos[i][0], g.pos[i][1], g.pos[i][2]]);
                if dot(d, d).sqrt() < g.radius(i) + A {
                    pairs.push((Body::Grain(g.id[i]), p.id[j]));
                }
            }
            if z < A {
                pairs.push((Body::Wall(0), p.id[j]));
            }
        }
        pairs.sort();
        pairs
    };
    let listed = |scene: &Scene| scene.contacts.touching().map(|c| (c.body, c.point)).collect::<Vec<_>>();
    let forces = |scene: &Scene| scene.contacts.touching().map(|c| c.force()).collect::<Vec<_>>();
    assert!(listed(&scene).len() > 60);
    assert_eq!(listed(&scene), touching(&scene));
    let before = forces(&scene);
    // memory changes, the list does not
    scene.grains.permute(&[3, 0, 4, 1, 2]);
    let reversed: Vec<usize> = (0..600).rev().collect();
    let p = scene.continuum.points_mut();
    p.position = reversed.iter().map(|&i| p.position[i]).collect();
    p.id = reversed.iter().map(|&i| p.id[i]).collect();
    scene.contacts.update(&scene.grains, &scene.walls, &scene.continuum, 1e-9);
    scene.evaluate(1e-6, [0.0; 2]);
    assert_eq!((listed(&scene), forces(&scene)), (touching(&scene), before.clone()));
    // a way that uses up the skin: a search, which keeps what contacts have
    scene.contacts.candidates.iter_mut().for_each(|c| c.spring = [f64::from(c.point), 1.0, 2.0]);
    scene.contacts.update(&scene.grains, &scene.walls, &scene.continuum, 0.1);
    assert_eq!(forces(&scene), before);
    assert!(scene.contacts.touching().all(|c| c.spring == [f64::from(c.point), 1.0, 2.0]));
    assert!(scene.contacts.candidates.len() > before.len() && scene.contacts.bytes() > 100 * before.len());
    // a grain that has gone takes its contacts with it
    let gone = scene.grains.id[0];
    scene.grains.id[0] = scene.grains.id[4];
    scene.grains.id.truncate(4);
    scene.grains.pos[0] = scene.grains.pos[4];
    scene.grains.pos.truncate(4);
    scene.grains.vel.truncate(4);
    scene.grains.spin.truncate(4);
    scene.contacts.update(&scene.grains, &scene.walls, &scene.continuum, 1e-9);
    scene.evaluate(1e-6, [0.0; 2]);
    assert!(listed(&scene).iter().all(|(body, _)| *body != Body::Grain(gone)));
    assert_eq!(listed(&scene), touching(&scene));
    scene.contacts.clear();
    assert!(scene.contacts.candidates.is_empty());
}

/// Passes that skip candidates without a history find those that a look at each finds: as contacts form and end, and when somebody has given one a history.
#[test]
fn no_candidate_with_a_history_is_skipped() {
    let physics = physics(ContactLaw::Hertz);
    let row: Vec<Point> = (0..12).map(|k| point([0.04 * f64::from(k), 0.0, 0.0], [0.0; 3])).collect();
    let mut scene = Scene::new(physics.clone(), grain([0.0, 0.0, 0.11], [0.0; 3], [0.0; 3], &physics), vec![], continuum(&row));
    let both = |scene: &Scene| {
        let skipping: Vec<u32> = scene.contacts.candidates.with_history().map(|c| c.point).collect();
        let all: Vec<u32> = scene.contacts.candidates.iter().filter(|c| c.has_history()).map(|c| c.point).collect();
        assert_eq!(skipping, all);
        all
    };
    let mut seen = Vec::new();
    for step in 0..10 {
        scene.grains.pos[0][0] = 0.05 * f64::from(step);
        scene.contacts.update(&scene.grains, &scene.walls, &scene.continuum, 0.05);
        scene.evaluate(1e-6, [0.0; 2]);
        seen.push(both(&scene));
    }
    assert!(seen.iter().all(|found| !found.is_empty() && found.len() < 12), "{seen:?}");
    assert!(seen[0].contains(&0) && !seen[9].contains(&0), "contacts ended: {seen:?}");
    let silent = scene.contacts.candidates.iter().position(|c| !c.has_history()).expect("one that does not touch");
    scene.contacts.candidates[silent].reference = 1e-3;
    assert!(both(&scene).contains(&scene.contacts.candidates[silent].point));
}

/// Chooses the longest cycle: squares of frequencies add up, and the faster side makes as many steps as the slower one needs.
#[test]
fn the_longest_cycle_is_that_of_the_slower_side() {
    let allowed = Allowed { grains: 3e-4, continuum: 1e-4, contacts: 0.0, safety: 0.5, nearly: 1.0, rates: None };
    let cycle = Cycle::longest(&allowed);
    assert_eq!(cycle.rates, Rates { grains: 1, continuum: 3 });
    near(cycle.time, 3e-4);
    let cycle = Cycle::longest(&Allowed { grains: 1e-4, continuum: 3.5e-4, ..allowed });
    assert_eq!(cycle.rates, Rates { grains: 4, continuum: 1 });
    near(cycle.time, 3.5e-4);
    // a cycle a little shorter saves a step
    let cycle = Cycle::longest(&Allowed { grains: 1e-4, continuum: 3.1e-4, nearly: 0.9, ..allowed });
    assert_eq!(cycle.rates, Rates { grains: 3, continuum: 1 });
    near(cycle.time, 3e-4);
    // rates that are given: the side that needs the shorter cycle decides
    let cycle = Cycle::longest(&Allowed { rates: Some(Rates { grains: 2, continuum: 1 }), ..allowed });
    near(cycle.time, 1e-4);
    // (2 · 0.5/dt)² + contacts, with contacts as large as the own part: dt/√2 on the side of 1e-4
    let cycle = Cycle::longest(&Allowed { grains: 1e-4, continuum: 1e-4, contacts: 1e8, ..allowed });
    assert_eq!(cycle.rates, Rates { grains: 1, continuum: 1 });
    near(cycle.time, 1e-4 / 2f64.sqrt());
    // no bound on one side
    let cycle = Cycle::longest(&Allowed { grains: f64::INFINITY, ..allowed });
    assert_eq!((cycle.rates, cycle.time), (Rates { grains: 1, continuum: 1 }, 1e-4));
    // far apart: not more than a thousand
    let cycle = Cycle::longest(&Allowed { grains: 1e-9, continuum: 1e-4, ..allowed });
    assert_eq!(cycle.rates, Rates { grains: 1000, continuum: 1 });
}

/// A grain that hits a point of its own mass without loss, or rests on it.
struct Meeting {
    physics: Physics,
    table: PointContactTable,
    work: Workspace,
    continuum: Continuum,
    mixture: Mixture,
}

impl Meeting {
    fn new(physics: Physics, grains: Grains, walls: Vec<Wall>, continuum: Continuum) -> Meeting {
        let mut continuum = continuum;
        let mut state = State::new(&physics, grains, walls, false);
        let work = Workspace::new(&physics, &mut state);
        let table = PointContactTable::new(physics.contact.law, &[0], &physics.materials, &state.walls).acting_on(ActsOn::Face);
        let mixture = Mixture::new(&physics, state, &mut continuum, None);
        Meeting { physics, table, work, continuum, mixture }
    }

    fn cycle(&mut self, cycle: Option<Cycle>) {
        let Meeting { physics, table, work, continuum, mixture } = self;
        let mut parts = Parts { physics, table, work, continuum, plates: &mut [] };
        mixture.compute_forces(&mut parts).expect("forces");
        if let Some(cycle) = cycle {
            mixture.make_cycle(&mut parts, cycle).expect("a cycle");
        }
    }
}

/// Shoots a grain at a point of its own mass: they change velocities whatever the steps of either side, momentum is kept to rounding, and the impact lasts as
/// long and is as deep as Hertz says.
#[test]
fn a_grain_and_a_point_of_its_mass_change_velocities() {
    let (speed, time) = (1.0, 4e-6);
    for (grains, steps) in [(1, 1), (4, 1), (1, 4)] {
        let physics = physics(ContactLaw::Hertz);
        let volume = sphere_volume(R);
        let resting = Point { mass: 2500.0 * volume, volume, ..point([2.0 * R + 5e-6, 0.0, 0.0], [0.0; 3]) };
        let mut m = Meeting::new(
            physics.clone(),
            grain([0.0; 3], [speed, 0.0, 0.0], [0.0; 3], &physics),
            Vec::new(),
            continuum(&[resting]),
        );
        let before = m.mixture.mass_and_momentum(&m.continuum);
        near(before.0, 2.0 * resting.mass);
        near3(before.1, [resting.mass * speed, 0.0, 0.0]);
        let cycle = Cycle { time, rates: Rates { grains, continuum: steps } };
        let (mut cycles, mut touched, mut deepest) = (0, 0, 0.0f64);
        while cycles < 10 || m.mixture.point_contacts.touching().next().is_some() {
            m.cycle(Some(cycle));
            cycles += 1;
            touched += u64::from(m.mixture.point_contacts.touching().next().is_some());
            deepest = m.mixture.point_contacts.touching().map(|c| c.touch.overlap).fold(deepest, f64::max);
            assert!(cycles < 5000);
        }
        assert_eq!(
            (m.mixture.cycles, m.continuum.steps(), m.mixture.grains.step),
            (cycles, cycles * u64::from(steps), cycles * u64::from(grains))
        );
        near(m.mixture.grains.time, cycles as f64 * time);
        let after = m.mixture.mass_and_momentum(&m.continuum);
        assert!((after.1[0] / before.1[0] - 1.0).abs() < 1e-12, "{grains} {steps}: {after:?}");
        let (own, other) = (m.mixture.grains.grains.vel[0][0], m.continuum.points().velocity[0][0]);
        assert!(own.abs() < 3e-3 && (other - speed).abs() < 3e-3, "{own} {other}");
        // Hertz: δ = (15 m*/(16 E* √R*))^(2/5) v^(4/5), T = 2.9432 δ/v
        let modulus = 0.75 * m.table.of_grain(0, 0).normal_stiffness;
        let depth = (15.0 * 0.5 * resting.mass / (16.0 * modulus * (0.5 * R).sqrt())).powf(0.4) * speed.powf(0.8);
        assert!((deepest / depth - 1.0).abs() < 2e-3, "{deepest} {depth}");
        assert!((touched as f64 * time / (2.9432 * depth / speed) - 1.0).abs() < 1e-2, "{touched}");
    }
}

/// The side that makes one step in a cycle is carried on meanwhile with its velocity: at the last of three steps of the other side by two thirds of the cycle.
#[test]
fn the_slower_side_is_carried_on_through_the_cycle() {
    let (overlap, speed, time) = (1e-5, 1.0, 3e-6);
    for rates in [Rates { grains: 1, continuum: 3 }, Rates { grains: 3, continuum: 1 }] {
        let physics = physics(ContactLaw::Hertz);
        // the slower side moves towards the other one
        let (of_grain, of_point) = if rates.grains == 1 { (speed, 0.0) } else { (0.0, -speed) };
        let grains = grain([0.0; 3], [of_grain, 0.0, 0.0], [0.0; 3], &physics);
        let hit = point(beside([0.0; 3], [1.0, 0.0, 0.0], overlap), [of_point, 0.0, 0.0]);
        let mut m = Meeting::new(physics, grains, Vec::new(), continuum(&[hit]));
        m.cycle(Some(Cycle { time, rates }));
        let found = m.mixture.point_contacts.candidates[0].touch.overlap - overlap;
        assert!((found / (speed * time * 2.0 / 3.0) - 1.0).abs() < 0.01, "{rates:?}: {found:e}");
    }
}

/// Contacts are found in time whatever moves: a grain, a point, both towards each other, or a wall.
#[test]
fn whatever_moves_meets_what_is_in_its_way() {
    let dt = 1e-3;
    for (of_grain, of_point, of_wall) in [(5.0, 0.0, 0.0), (0.0, 5.0, 0.0), (2.5, 2.5, 0.0), (0.0, 0.0, 5.0)] {
        let physics = physics(ContactLaw::Hertz);
        // gaps wider than the widest skin, to the grain and to the wall
        let gap = 0.052;
        let grains = grain([0.0, 0.0, 0.5], [of_grain, 0.0, 0.0], [0.0; 3], &physics);
        let hit = point([R + A + gap, 0.0, 0.5], [0.0; 3]);
        let pushed = point([0.6, 0.6, A + gap], [0.0; 3]);
        let mut m = Meeting::new(physics, grains, vec![floor(of_wall)], continuum(&[hit, pushed]));
        m.mixture.last = dt;
        m.continuum.points_mut().transport_velocity[0] = [-of_point, 0.0, 0.0];
        let body = if of_wall > 0.0 { Body::Wall(0) } else { Body::Grain(0) };
        for step in 0..12 {
            m.cycle(None);
            let touches = m.mixture.point_contacts.touching().any(|c| c.body == body);
            assert_eq!(touches, 5.0 * dt * f64::from(step) > gap, "{of_grain} {of_point} {of_wall}: {step}");
            m.mixture.grains.grains.pos[0][0] += of_grain * dt;
            m.continuum.points_mut().position[0][0] -= of_point * dt;
            m.mixture.grains.walls[0].advance(dt);
        }
    }
}

/// A box of half the density of a grain that flies beside a point.
fn flying_box() -> Blocks {
    let mut body = Block::new(Shape::Box(Cuboid { half: [0.05; 3] }), 1250.0, 0);
    (body.centre, body.velocity) = ([-0.5, 0.0, 0.5], [0.2, -0.1, 0.3]);
    Blocks::new(vec![body])
}

/// A grain and a box, each of which touches a point; a floor would touch the grain.
fn grain_and_box(walls: Vec<Wall>) -> Meeting {
    let physics = physics(ContactLaw::Hertz);
    let grains = grain([0.0, 0.0, R - 1e-4], [0.1, 0.0, 0.0], [0.0, 3.0, 0.0], &physics);
    let points = [point(beside([0.0, 0.0, R - 1e-4], oblique(), 1e-4), [0.0; 3]), point([-0.45 + A - 1e-4, 0.0, 0.5], [0.0; 3])];
    let mut m = Meeting::new(physics, grains, walls, continuum(&points));
    m.mixture.blocks = Some(Box::new(flying_box()));
    m
}

/// Rigid bodies take part: their forces on points are equal and opposite whatever the steps of either side, and sums over a mixture hold theirs.
#[test]
fn rigid_bodies_are_part_of_a_mixture() {
    let near = |a: f64, b: f64| assert!((a / b - 1.0).abs() < 1e-12, "{a} {b}");
    for rates in [Rates { grains: 1, continuum: 1 }, Rates { grains: 1, continuum: 3 }, Rates { grains: 3, continuum: 1 }] {
        let mut m = grain_and_box(Vec::new());
        let (mass, before) = m.mixture.mass_and_momentum(&m.continuum);
        let box_mass = 1250.0 * 0.1f64.powi(3);
        near(mass, 2500.0 * (sphere_volume(R) + 2.0 * sphere_volume(A)) + box_mass);
        near(before[2], box_mass * 0.3);
        let start = m.continuum.points().velocity[1];
        // velocities of grains and bodies begin half a step back
        m.cycle(Some(Cycle { time: 3e-6, rates }));
        let before = m.mixture.mass_and_momentum(&m.continuum).1;
        for _ in 0..3 {
            m.cycle(Some(Cycle { time: 3e-6, rates }));
        }
        assert!(m.continuum.points().velocity[1][0] > start[0], "the box has pushed its point");
        let after = m.mixture.mass_and_momentum(&m.continuum).1;
        assert!((0..3).all(|a| (after[a] - before[a]).abs() < 1e-13 * mass), "{rates:?}: {before:?} {after:?}");
    }
    let mut m = grain_and_box(vec![floor(0.0)]);
    m.cycle(None);
    let gravity = [0.0, 0.0, -10.0];
    let (whole, bounds) = (m.mixture.energies(gravity), m.mixture.bounds(&m.continuum, &[], false).1);
    let n = m.continuum.points().len();
    let mut blocks = m.mixture.blocks.take().expect("bodies");
    let theirs = blocks.energies(gravity, 0.4);
    let rest = m.mixture.energies(gravity);
    for k in 0..3 {
        assert!(theirs[k] > 0.0 && rest[k] > 0.0);
        near(whole[k], theirs[k] + rest[k]);
    }
    // the largest sum of any point, and of any grain or body
    let of_bodies = blocks.rates(&m.mixture.grains.grains, n);
    let of_grains = m.mixture.point_contacts.rates(&m.mixture.grains.grains, &mut [Vec::new(), Vec::new()], n);
    assert!(of_bodies.points > 0.0 && of_bodies.grains > 0.0 && of_grains.points > 0.0 && of_grains.grains > 0.0);
    near(bounds, of_bodies.points + of_bodies.grains + of_grains.points + of_grains.grains);
}

/// A state from outside is taken only if it is one of the scene: bodies, fines, law and steps.
#[test]
fn a_mixture_of_another_scene_is_refused() {
    let rule = Rule { release_strain: 0.1, law: 0, porosity: 0.4, solid: 1e-5, density: 2500.0, at_rest: false };
    let mut m = grain_and_box(vec![floor(0.0)]);
    m.mixture.fines = Some(Box::new(FinesAsPoints::new(rule)));
    let (made, room) = (m.mixture.clone(), m.continuum.clone());
    m.cycle(Some(Cycle { time: 1e-6, rates: Rates { grains: 1, continuum: 1 } }));
    let taken = |change: &dyn Fn(&mut Mixture)| {
        let mut from_outside = m.mixture.clone();
        change(&mut from_outside);
        from_outside.check(&m.continuum, &m.physics, (&made, &room), 1)
    };
    assert_eq!(taken(&|_| {}), Ok(()));
    assert_eq!(taken(&|m| m.cycle.rates = Rates { grains: 1000, continuum: 1 }), Ok(()));
    let wrong: [&dyn Fn(&mut Mixture); 19] = [
        &|m| m.blocks = None,
        &|m| m.blocks = Some(Box::new(Blocks::new(Vec::new()))),
        &|m| m.fines = None,
        &|m| m.fines = Some(Box::new(FinesAsPoints::new(Rule { law: 1, ..rule }))),
        &|m| m.fines.as_mut().unwrap().reserve.momentum[1] = f64::NAN,
        &|m| m.fines.as_mut().unwrap().entered.kinetic = f64::INFINITY,
        &|m| m.fines.as_mut().unwrap().released = f64::NAN,
        &|m| m.fines.as_mut().unwrap().points = 3,
        &|m| m.energy_factor = 0.5,
        &|m| m.cycle.rates = Rates { grains: 1001, continuum: 1 },
        &|m| m.cycle.rates = Rates { grains: 2, continuum: 2 },
        &|m| m.cycle.rates = Rates { grains: 0, continuum: 1 },
        &|m| m.cycle.time = -1.0,
        &|m| m.bound_ratio = -1.0,
        &|m| m.point_contacts.candidates = vec![m.point_contacts.candidates[0]; 2].into(),
        &|m| m.point_contacts.candidates[0].body = Body::Grain(1),
        &|m| m.point_contacts.candidates[0].reference = -1.0,
        &|m| m.point_contacts.candidates[0].radius = 0.0,
        &|m| m.point_contacts.candidates[0].face = Some(GhostFace::at_first_touch([1.0, 0.0, 0.0], [0.0, f64::NAN, 0.0])),
    ];
    for (k, change) in wrong.into_iter().enumerate() {
        assert!(taken(change).is_err(), "number {k}");
    }
    // where the scene has neither
    let without = |mixture: &Mixture| {
        let mut plain = mixture.clone();
        (plain.blocks, plain.fines) = (None, None);
        plain
    };
    let plain = without(&made);
    for (bodies, fines) in [(true, false), (false, true)] {
        let mut from_outside = m.mixture.clone();
        from_outside.blocks = from_outside.blocks.filter(|_| bodies);
        from_outside.fines = from_outside.fines.filter(|_| fines);
        assert!(from_outside.check(&m.continuum, &m.physics, (&plain, &room), 1).is_err());
    }
    assert_eq!(without(&m.mixture).check(&m.continuum, &m.physics, (&plain, &room), 1), Ok(()));
}

/// Measures a mixture at an instant: a grain between a floor, another grain and a point.
#[test]
fn measures_are_sums_over_contacts() {
    let physics = physics(ContactLaw::Hertz);
    let mut grains = grain([0.0, 0.0, R - 1e-3], [0.5, 0.0, 0.0], [0.0, 3.0, 4.0], &physics);
    grains.add([0.0, 2.0 * R - 2e-3, R - 1e-3], R, 0, &physics.materials);
    let mut pressed = point(beside([0.0, 0.0, R - 1e-3], [-1.0, 0.0, 0.0], 1.5e-3), [0.0; 3]);
    pressed.stress = [-3e4, -2e4, -1e4, 0.0, 0.0, 0.0];
    let mut m = Meeting::new(physics, grains, vec![floor(0.0)], continuum(&[pressed]));
    m.cycle(None);
    let pair = m.physics.contact.law.between(&m.physics.materials[0], &m.physics.materials[0]);
    let wall = m.physics.contact.law.on_wall(&m.physics.materials[0], 0.3);
    let hertz = |pair: &Pair, r: f64, x: f64| pair.normal_stiffness * (r * x).sqrt() * x;
    let (grain, floor, point) = (hertz(&pair, 0.5 * R, 2e-3), hertz(&wall, R, 1e-3), hertz(&pair, R * A / (R + A), 1.5e-3));
    let close = |a: f64, b: f64| assert!((a - b).abs() < 1e-9 * b.abs().max(1e-12), "{a} {b}");
    let volume = 0.7;
    let shares = m.mixture.shares(&m.continuum, volume);
    for (a, s) in [3e4, 2e4, 1e4].into_iter().enumerate() {
        close(shares.matrix[a], s * pressed.volume / volume);
    }
    close(shares.skeleton[1], grain * (2.0 * R - 2e-3) / volume);
    // both grains stand on the floor
    close(shares.skeleton[2], 2.0 * floor * (R - 1e-3) / volume);
    // to where the force acts, the middle of the overlap
    close(shares.interface[0], point * (R - 0.5 * 1.5e-3) / volume);
    close(shares.total(0), shares.matrix[0] + shares.skeleton[0] + shares.interface[0]);
    let half = shares.midway(Shares::default());
    close(
        half.matrix[0] + half.skeleton[1] + half.interface[0],
        0.5 * (shares.matrix[0] + shares.skeleton[1] + shares.interface[0]),
    );
    let touching = m.mixture.touching();
    assert_eq!((touching.grains, touching.walls, touching.points), (1, 2, 1));
    close(touching.fabric[1], 1.0);
    let [kinetic, potential, stored] = m.mixture.energies([0.0, 0.0, -10.0]);
    let mass = 2500.0 * sphere_volume(R);
    close(kinetic, 0.5 * mass * (0.25 + 0.4 * R * R * 25.0));
    close(potential, 2.0 * mass * 10.0 * (R - 1e-3));
    close(stored, 0.4 * (grain * 2e-3 + 2.0 * floor * 1e-3 + point * 1.5e-3));
    // the bound on a step: sums of stiffness over mass, both ends together
    let root = (R * A / (R + A) * 1.5e-3).sqrt();
    let (k_n, k_t) = (1.5 * pair.normal_stiffness * root, pair.tangential_stiffness * root);
    let (own, contacts) = m.mixture.bounds(&m.continuum, &[], false);
    close(own, m.mixture.grains.dt);
    close(contacts, k_n.max(k_t) / pressed.mass + k_n.max(3.5 * k_t) / mass);
    let (_, slow) = m.mixture.bounds(&m.continuum, &[], true);
    close(slow, (3.0 * k_n.max(k_t) / pressed.mass).max(1.5 * k_n.max(3.5 * k_t) / mass));
    close(m.mixture.isolated_bound.expect("a slow test has one"), 3.0 * k_n.max(k_t) / pressed.mass);
}

/// Takes all contacts out as lists and puts them back: forces, springs and stiffnesses are the same.
#[cfg(feature = "gpu")]
#[test]
fn contacts_taken_out_and_put_back_are_the_same() {
    for law in [ContactLaw::Hertz, ContactLaw::HertzViscous] {
        let physics = physics(law);
        let mut grains = grain([0.0, 0.0, R - 1e-3], [0.1, 0.0, 0.0], [0.0, 3.0, 4.0], &physics);
        grains.add([0.0, 2.0 * R - 2e-3, R - 1e-3], R, 0, &physics.materials);
        let p =
            [point(beside([0.0, 0.0, R - 1e-3], [-1.0, 0.0, 0.0], 1.5e-3), [0.0; 3]), point([0.5, 0.0, A - 1e-3], [0.1, 0.0, 0.0])];
        let mut m = Meeting::new(physics, grains, vec![floor(0.0)], continuum(&p));
        m.cycle(Some(Cycle { time: 1e-6, rates: Rates { grains: 1, continuum: 1 } }));
        m.cycle(None);
        let out = m.mixture.contacts(&m.physics, &m.work.table);
        assert_eq!((out.grains.len(), out.walls.len(), out.points.len()), (1, 2, 2));
        let old: Vec<PointContact> = m.mixture.point_contacts.touching().copied().collect();
        for ((body, c), old) in out.points.iter().zip(&old) {
            assert_eq!((*body, c.touch, c.stiffness), (old.body, old.touch, old.stiffness[0]));
        }
        let Meeting { physics, table, work, continuum, mixture } = &mut m;
        mixture.take_contacts(physics, table, continuum, &out, 1e-6);
        for (new, old) in mixture.point_contacts.touching().zip(&old) {
            assert_eq!(
                (new.body, new.point, new.place, new.law, new.radius),
                (old.body, old.point, old.place, old.law, old.radius)
            );
            assert_eq!((new.mass, new.touch, new.spring), (old.mass, old.touch, old.spring));
            near(new.stiffness[0], old.stiffness[0]);
            near(new.stiffness[1], old.stiffness[1]);
        }
        assert_eq!(mixture.contacts(physics, &work.table), out);
        assert!(mixture.grains.births && mixture.grains.dt == 1e-6);
    }
}

/// Refuses a grain that would go further than a cell in a step, inside of the grid only.
#[test]
fn a_grain_that_goes_further_than_a_cell_is_an_error() {
    for (at, refused) in [([0.0; 3], true), ([5.0, 0.0, 0.0], false)] {
        let physics = physics(ContactLaw::Hertz);
        let grains = grain(at, [0.0, 200.0, 0.0], [0.0; 3], &physics);
        let mut m = Meeting::new(physics, grains, Vec::new(), continuum(&[point([-0.5; 3], [0.0; 3])]));
        let cycle = Cycle { time: 1e-3, rates: Rates { grains: 1, continuum: 1 } };
        let Meeting { physics, table, work, continuum, mixture } = &mut m;
        let mut parts = Parts { physics, table, work, continuum, plates: &mut [] };
        mixture.compute_forces(&mut parts).expect("no step yet");
        mixture.make_cycle(&mut parts, cycle).expect("a cycle");
        mixture.grains.grains.pos[0] = [at[0], at[1], at[2], R];
        assert_eq!(mixture.compute_forces(&mut parts).is_err(), refused);
    }
}

/// The unloading rule reaches point contacts.
#[test]
fn springs_fall_with_the_normal_force_where_the_run_says_so() {
    let fall = |unloading| {
        let mut physics = physics(ContactLaw::Hertz);
        physics.contact.unloading = unloading;
        let (n, overlap, dt) = (oblique(), 2e-3, 1e-5);
        let grains = grain([0.0; 3], [0.0; 3], [0.5, 0.0, 0.0], &physics);
        let mut scene = Scene::new(physics, grains, Vec::new(), continuum(&[point(beside([0.0; 3], n, overlap), [0.0; 3])]));
        scene.evaluate(dt, [0.0; 2]);
        let before = scene.contacts.candidates[0].touch.tangential;
        scene.grains.spin[0] = [0.0; 4];
        let [x, y, z] = beside([0.0; 3], n, 0.25 * overlap);
        scene.continuum.points_mut().position[0][..3].copy_from_slice(&[x, y, z]);
        scene.evaluate(dt, [0.0; 2]);
        let after = scene.contacts.candidates[0].touch.tangential;
        (dot(after, after) / dot(before, before)).sqrt()
    };
    // k_t goes with the root of the overlap
    assert!((fall(TangentialUnloading::Keep) - 1.0).abs() < 1e-9);
    assert!((fall(TangentialUnloading::Rescale) - 0.5).abs() < 1e-9);
}
