//! Ciantia et al. 2015 eq. (14) as printed against Li et al. 2023 eqs (20), (21) as the engine has them, for equal materials.

use crate::common::*;

/// k_N = 2⟨G⟩ √(2R̃) √U / (3(1−⟨ν⟩)), a secant, and k_S = 2 (⟨G⟩² 3(1−⟨ν⟩) R̃)^{1/3} F_N^{1/3} / (2−⟨ν⟩), a tangent, R̃ = D1 D2/(D1+D2).
fn eq_14(g: f64, nu: f64, d1: f64, d2: f64, overlap: f64) -> (f64, f64) {
    let r = d1 * d2 / (d1 + d2);
    let normal = 2.0 * g * (2.0 * r).sqrt() * overlap.sqrt() / (3.0 * (1.0 - nu)) * overlap;
    (normal, 2.0 * (g * g * 3.0 * (1.0 - nu) * r).cbrt() / (2.0 - nu) * normal.cbrt())
}

#[test]
fn eq_14_is_hertz_and_mindlin_for_equal_materials() {
    for (young, poisson) in [(0.858e9, 0.3), (70e9, 0.17), (5e6, 0.45)] {
        let stuff = Stuff { young, poisson, density: 2650.0, friction: 100.0, restitution: 1.0 };
        for (r1, r2) in [(0.01, 0.01), (0.01, 0.003), (1e-4, 0.02)] {
            for share in [1e-6, 1e-4, 1e-2] {
                let overlap = share * f64::min(r1, r2);
                // one step from first touch: the tangential force is k_S times the way slid
                let (dt, slide) = (1e-9, 1e-3 * share);
                let balls = [
                    Ball { at: [0.0; 3], radius: r1, velocity: [0.0, slide, 0.0], ..Ball::default() },
                    Ball { at: [r1 + r2 - overlap, 0.0, 0.0], radius: r2, ..Ball::default() },
                ];
                let mut lab = Lab::new(&assembly_text(&format!("stepping.dt_s = {dt:?}"), &stuff, &balls, &[]));
                let [now] = lab.watch([0]);
                let (normal, k_s) = eq_14(stuff.shear(), poisson, 2.0 * r1, 2.0 * r2, overlap);
                // the overlap is a difference of lengths: its rounding is what is left
                let rounding = 1e-12 + 1e-15 / share * r2.max(r1) / r1.min(r2);
                close("normal force", -now.force[0], normal, rounding);
                close("tangential stiffness", -now.force[1] / (slide * dt), k_s, rounding);
            }
        }
    }
}
