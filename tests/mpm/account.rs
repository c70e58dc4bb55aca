//! The energy account of points and nodes: it closes to rounding, and not without any one of its terms; it changes no bit of the state.

use crate::common::*;
use comminute::mpm::law::{Cone, DruckerPrager, Elastic, Evolution, Law, Parameters};
use comminute::mpm::{Continuum, Dimension, GridWall, ShapeFunctions, Transfer};

fn sand() -> Vec<Law> {
    vec![Law::DruckerPrager(DruckerPrager::new(Parameters {
        cone: Cone::Outer,
        friction: Evolution::Constant(0.4),
        cohesion: Evolution::Constant(200.0),
        dilation: 0.1,
        ..Parameters::of_elastic(Elastic::of_young(1e6, 0.3))
    }))]
}

/// Sand thrown into a corner of rough, rubbing and smooth walls, pushed at points and at faces.
fn thrown(dimension: Dimension, transfer: Transfer, shape: ShapeFunctions) -> Continuum {
    let mut s = settings(dimension, 0.1, [30, 30, 30]);
    s.walls =
        [GridWall::Stick, GridWall::Open, GridWall::Friction { friction: 0.3 }, GridWall::Open, GridWall::Symmetry, GridWall::Open];
    (s.gravity, s.damping, s.transfer, s.shape) = ([0.0, -9.81, 0.0], 0.05, transfer, shape);
    let v = |[x, y, z]: [f64; 3]| [-1.0 + 0.3 * y, -1.5 + 0.2 * z, 1.0 + 0.1 * x];
    let points = fill(&s, [[0.1; 3], [0.7; 3]], 2, 1800.0, |x| x[0] + x[1] < 1.1, v);
    continuum(s, sand(), points)
}

fn cases() -> [Continuum; 3] {
    [
        thrown(Dimension::Space, Transfer::Blend { pic: 0.02 }, ShapeFunctions::BSpline),
        thrown(Dimension::Space, Transfer::Affine, ShapeFunctions::BSpline),
        thrown(Dimension::PlaneStrain, FLIP, ShapeFunctions::Gimp { half_width: 0.25 }),
    ]
}

fn go(c: &mut Continuum) {
    let dt = c.stable_step(0.3);
    for _ in 0..120 {
        for i in 0..c.points().len() {
            let id = c.points().id[i];
            if id.is_multiple_of(7) {
                c.add_external_force(i, [30.0, 10.0, -5.0], 0.0);
            } else if id.is_multiple_of(11) {
                c.add_face_force(i, 40.0, [-0.6, 0.8, 0.0], 0.0);
            }
        }
        c.step(dt).expect("a step");
    }
}

/// The terms, signed so that they add up to zero.
fn terms(c: &Continuum, start: [f64; 3]) -> Vec<(&'static str, f64)> {
    let (a, t) = (c.account().expect("kept"), c.totals());
    vec![
        ("external", a.external),
        ("gravity", start[1] - t.potential),
        ("kinetic", start[0] - t.kinetic),
        ("elastic", start[2] - c.elastic_energy()),
        ("plastic", -a.plastic),
        ("volume", -a.volume),
        ("transfer", -a.transfer()),
        ("wall impact", -a.wall_impact),
        ("wall friction", -a.wall_friction),
        ("damping", -a.damping),
        ("strain lag", -a.strain_lag),
        ("gravity lag", -a.gravity_lag),
    ]
}

#[test]
fn a_continuum_closes() {
    for mut c in cases() {
        c.keep_account();
        let t = c.totals();
        let start = [t.kinetic, t.potential, c.elastic_energy()];
        go(&mut c);
        let terms = terms(&c, start);
        let open = terms.iter().map(|(_, x)| x).sum::<f64>();
        println!("open by {:.1e} of {:.1e} J: {terms:?}", open, t.kinetic);
        // what is left is the fourth power of the spin in a step, and rounding
        assert!(open.abs() < 1e-7 * t.kinetic, "{open:e} of {:e}: {terms:?}", t.kinetic);
        for (name, term) in terms {
            assert!((open - term).abs() > 1e-5 * t.kinetic, "it closes without {name}: {term:e} of {:e}", t.kinetic);
        }
    }
}

/// What is lost is lost: no term of these can be negative.
#[test]
fn losses_are_positive() {
    for mut c in cases() {
        c.keep_account();
        go(&mut c);
        let a = c.account().expect("kept");
        assert!([a.plastic, a.wall_friction, a.damping].iter().all(|x| *x > 0.0), "{a:?}");
    }
}

/// The state has the same bits with the account and without; the account has them on any number of threads, and after the grid was made anew.
#[test]
fn the_account_changes_no_bit() {
    for c in cases() {
        let mut plain = c.clone();
        go(&mut plain);
        let counted = |threads: usize, anew: bool| {
            let mut c = c.clone();
            c.keep_account();
            let pool = rayon::ThreadPoolBuilder::new().num_threads(threads).build().expect("threads");
            pool.install(|| {
                go(&mut c);
                if anew {
                    c.drop_scratch();
                }
                go(&mut c);
            });
            c
        };
        go(&mut plain);
        let (one, three) = (counted(1, false), counted(3, true));
        assert_eq!(one.account(), three.account());
        for i in 0..plain.points().len() {
            assert_eq!(plain.points().position[i], one.points().position[i]);
            assert_eq!(plain.points().velocity[i], one.points().velocity[i]);
            assert_eq!(plain.points().stress[i], one.points().stress[i]);
        }
    }
}
