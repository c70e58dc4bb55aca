//! The same bytes whatever the number of threads, the order of points in memory, the instruction set or the age of the grid.

use crate::common::*;
use comminute::math::real::at_best;
use comminute::mpm::{Continuum, Dimension, GridWall, Points, Settings, ShapeFunctions, Transfer};

/// A block thrown into a corner, so that points cross cells and blocks all the time.
fn thrown(dimension: Dimension, transfer: Transfer, shape: ShapeFunctions) -> (Settings, Points) {
    let mut s = settings(dimension, 0.1, [40, 40, 40]);
    s.walls =
        [GridWall::Stick, GridWall::Open, GridWall::Friction { friction: 0.3 }, GridWall::Open, GridWall::Symmetry, GridWall::Open];
    (s.gravity, s.damping) = ([0.0, -9.81, 0.0], 0.05);
    (s.transfer, s.shape) = (transfer, shape);
    let high = if dimension == Dimension::Space { 1.3 } else { 3.3 };
    let v = |[x, y, z]: [f64; 3]| [-2.0 + 0.3 * y, -3.0 + 0.2 * z, -1.0 + 0.1 * x];
    let points = fill(&s, [[0.05; 3], [high; 3]], 2, 1800.0, |x| x[0] + x[1] < 1.8 * high, v);
    (s, points)
}

fn cases() -> Vec<(Settings, Points)> {
    vec![
        thrown(Dimension::Space, FLIP, ShapeFunctions::BSpline),
        thrown(Dimension::Space, Transfer::Affine, ShapeFunctions::BSpline),
        thrown(Dimension::PlaneStrain, Transfer::Blend { pic: 0.05 }, ShapeFunctions::Gimp { half_width: 0.25 }),
    ]
}

/// Every bit of the points in the order of ids, of the walls' forces and of the stress work.
fn bits(c: &Continuum) -> Vec<u64> {
    let p = c.points();
    let mut bits = vec![c.stress_work().to_bits()];
    bits.extend(c.wall_force().iter().flatten().map(|x| x.to_bits()));
    for i in p.by_id() {
        let i = i as usize;
        bits.push(u64::from(p.id[i]));
        bits.extend(p.position[i].iter().chain(&p.velocity[i]).chain(&p.stress[i]).map(|x| x.to_bits()));
        bits.extend([p.memory[i].plastic, p.memory[i].gap].map(f64::to_bits));
        bits.extend(p.affine.get(i).into_iter().flatten().flatten().map(|x| x.to_bits()));
    }
    bits
}

fn run(settings: Settings, points: Points, threads: usize, mut each: impl FnMut(u64, &mut Continuum) + Send) -> Vec<u64> {
    let pool = rayon::ThreadPoolBuilder::new().num_threads(threads).build().unwrap();
    let mut c = continuum(settings, elastic(2e6, 0.3), points);
    let dt = c.stable_step(0.4);
    pool.install(|| {
        for k in 0..60 {
            each(k, &mut c);
            // a contact pushes some points now and then, which are found by their ids
            if k.is_multiple_of(3) {
                for i in 0..c.points().len() {
                    let id = c.points().id[i];
                    if id.is_multiple_of(17) {
                        c.add_external_force(i, [0.01 * f64::from(id % 5), 0.5, -0.1], 0.0);
                    }
                }
            }
            c.step(dt).unwrap();
        }
    });
    bits(&c)
}

fn quiet(_: u64, _: &mut Continuum) {}

#[test]
fn threads_change_no_bit() {
    for (s, p) in cases() {
        let one = run(s.clone(), p.clone(), 1, quiet);
        for threads in [2, 7] {
            assert!(run(s.clone(), p.clone(), threads, quiet) == one, "{threads} threads, {:?}", s.transfer);
        }
    }
}

#[test]
fn instructions_change_no_bit() {
    for (s, p) in cases() {
        let best = run(s.clone(), p.clone(), 1, quiet);
        for name in ["avx512", "avx2", "scalar"] {
            let other = run(s.clone(), p.clone(), 1, |k, c| {
                if k == 0 {
                    c.use_instructions(at_best(name))
                }
            });
            assert!(other == best, "{name}, {:?}", s.transfer);
        }
    }
}

#[test]
fn memory_order_changes_no_bit() {
    for (s, p) in cases() {
        let sorted = run(s.clone(), p.clone(), 1, quiet);
        let mut shuffled = p.clone();
        let n = p.len();
        for i in 0..n {
            // 7919 is a prime that does not divide n
            let j = i * 7919 % n;
            shuffled.position[i] = p.position[j];
            shuffled.velocity[i] = p.velocity[j];
            shuffled.id[i] = p.id[j];
        }
        assert!(n % 7919 != 0 && run(s.clone(), shuffled, 1, quiet) == sorted, "{:?}", s.transfer);
    }
}

#[test]
fn a_grid_made_anew_changes_no_bit() {
    for (s, p) in cases() {
        let kept = run(s.clone(), p.clone(), 1, quiet);
        let dropped = run(s.clone(), p.clone(), 1, |k, c| {
            if k % 7 == 3 {
                c.drop_scratch()
            }
        });
        assert!(dropped == kept, "scratch dropped, {:?}", s.transfer);
        let touched = run(s.clone(), p.clone(), 1, |k, c| {
            if k % 11 == 5 {
                c.points_mut();
            }
        });
        assert!(touched == kept, "points looked at, {:?}", s.transfer);
        let restarted = run(s.clone(), p.clone(), 1, |k, c| {
            if k == 30 {
                *c = postcard::from_bytes(&postcard::to_stdvec(c).unwrap()).unwrap();
            }
        });
        assert!(restarted == kept, "restarted, {:?}", s.transfer);
    }
}
