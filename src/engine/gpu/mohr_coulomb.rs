//! The return of Mohr and Coulomb's law in f32, for tests. Twin of `mohr_coulomb.wgsl`; the method is that of `mpm::law::mohr_coulomb`, with what f32 asks for:
//! principal values of the deviator, so that a large pressure does not spoil their digits; changes of stress instead of new stresses; and differences of multipliers
//! at an edge from the gap between the two principal stresses that it closes, not from two numbers of nearly the same size.

use super::law::{Step, Sym32, evolution_at, potential_slope, sine};
use super::layout::{HUGE, Law32};

/// A symmetric tensor on its way to its principal axes: entries on and off the diagonal (xx, yy, zz and xy, yz, zx) in the axes.
struct Turned {
    on: [f32; 3],
    off: [f32; 3],
    axes: [[f32; 3]; 3],
}

/// Rotations of the first two of the axes, then the next two, and so on (Jacobi's method).
const ROTATIONS: usize = 18;

/// Turns the first two axes so that the entry between them vanishes.
fn rotated(a: &Turned) -> Turned {
    let ([x, y, z], [xy, yz, zx], [u, v, w]) = (a.on, a.off, a.axes);
    let half = (y - x) / (2.0 * xy);
    let root = (half * half + 1.0).sqrt();
    let tangent = if half < 0.0 { -1.0 / (root - half) } else { 1.0 / (root + half) };
    let cosine = 1.0 / (tangent * tangent + 1.0).sqrt();
    let sine = tangent * cosine;
    let by = tangent * xy;
    Turned {
        on: [x - by, y + by, z],
        off: [0.0, sine * zx + cosine * yz, cosine * zx - sine * yz],
        axes: [std::array::from_fn(|k| cosine * u[k] - sine * v[k]), std::array::from_fn(|k| sine * u[k] + cosine * v[k]), w],
    }
}

/// Principal values, the largest first, and axes. Entries of 10⁻⁹ of the tensor's size off the diagonal count as nothing.
fn principal(deviator: &Sym32) -> Turned {
    let [x, y, z, xy, yz, zx] = *deviator;
    let axes = [[1.0, 0.0, 0.0], [0.0, 1.0, 0.0], [0.0, 0.0, 1.0]];
    let mut a = Turned { on: [x, y, z], off: [xy, yz, zx], axes };
    let nothing = 1e-9 * (x.abs() + y.abs() + z.abs() + xy.abs() + yz.abs() + zx.abs());
    for _ in 0..ROTATIONS {
        if a.off[0].abs() > nothing {
            a = rotated(&a);
        }
        a.on.rotate_left(1);
        a.off.rotate_left(1);
        a.axes.rotate_left(1);
    }
    for k in [0, 1, 0] {
        if a.on[k] < a.on[k + 1] {
            a.on.swap(k, k + 1);
            a.axes.swap(k, k + 1);
        }
    }
    a
}

/// The pyramid and its potential at one plastic strain, as `mpm::law::mohr_coulomb::Pyramid`, with the mean stress at its apex, Pa.
struct Pyramid {
    sin_friction: f32,
    sin_dilation: f32,
    strength: f32,
    apex: f32,
}

/// Changes of the principal stresses in a return, Pa, its plastic strain, and what opens at the apex.
struct PyramidReturn {
    by: [f32; 3],
    plastic: f32,
    gap: f32,
}

/// The pyramid at a plastic strain.
fn pyramid_at(law: &Law32, plastic: f32) -> Pyramid {
    if plastic < law.settled {
        let sine_now = sine(evolution_at(&law.friction, plastic).0);
        let strength = 2.0 * evolution_at(&law.cohesion, plastic).0 * (1.0 - sine_now * sine_now).max(0.0).sqrt();
        let mut flow = law.sin_dilation;
        if law.dilation_factor > 0.0 {
            // the rule is one of slopes of the cone through the edges of triaxial compression
            let rise = 1.732_050_8 * potential_slope(law, 1.154_700_5 * sine_now / (3.0 - sine_now));
            flow = 3.0 * rise / (2.0 + rise);
        }
        let apex = if sine_now > 0.0 { (strength / (2.0 * sine_now)).min(HUGE as f32) } else { HUGE as f32 };
        return Pyramid { sin_friction: sine_now, sin_dilation: flow, strength, apex };
    }
    Pyramid { sin_friction: law.sin_friction, sin_dilation: law.sin_dilation, strength: law.strength, apex: law.apex }
}

/// Changes of the principal stresses, Pa, and of the gap, in the return of a trial stress by which the yield function is `excess` > 0. `s`: principal values of its deviator, Pa;
/// `mean`: its mean stress, Pa.
fn correction(law: &Law32, pyramid: &Pyramid, [a, b, c]: [f32; 3], mean: f32, excess: f32) -> ([f32; 3], f32) {
    let (sine, flow, g) = (pyramid.sin_friction, pyramid.sin_dilation, law.shear);
    let swell = 2.0 * law.bulk * flow;
    let largest = -(2.0 * g * (1.0 + flow * 0.333_333_33) + swell);
    let other = 1.333_333_4 * g * flow - swell;
    let smallest = 2.0 * g * (1.0 - flow * 0.333_333_33) - swell;
    let own = 4.0 * g * (1.0 + sine * flow * 0.333_333_33) + 2.0 * swell * sine;
    let (upper, lower) = (a - b, b - c);
    let m = excess / own;
    if upper >= 2.0 * g * (1.0 + flow) * m && lower >= 2.0 * g * (1.0 - flow) * m {
        return ([largest * m, other * m, smallest * m], 0.0);
    }
    let extension = upper - lower - flow * (a - c) > 0.0;
    let (sign, gap) = if extension { (1.0, lower) } else { (-1.0, upper) };
    let across = 2.0 * g * (1.0 + sign * (sine + flow) - sine * flow * 0.333_333_33) + 2.0 * swell * sine;
    // sum of the multipliers of both planes; their difference is what closes the gap
    let sum = (2.0 * excess - gap * (1.0 - sign * sine)) / (own + across);
    if mean - swell * sum > pyramid.apex {
        return ([a, b, c].map(|s| (pyramid.apex - mean) - s), ((mean - pyramid.apex) / law.bulk).max(0.0));
    }
    if extension {
        let both = (other + smallest) * sum;
        return ([largest * sum, 0.5 * (both - gap), 0.5 * (both + gap)], 0.0);
    }
    let both = (largest + other) * sum;
    ([0.5 * (both - gap), 0.5 * (both + gap), smallest * sum], 0.0)
}

/// The return to a pyramid that stays; nothing for a trial stress inside of it.
fn return_to(law: &Law32, pyramid: &Pyramid, [a, b, c]: [f32; 3], mean: f32) -> PyramidReturn {
    let excess = (a - c) + ((a + c) + 2.0 * mean) * pyramid.sin_friction - pyramid.strength;
    if excess <= 0.0 {
        return PyramidReturn { by: [0.0; 3], plastic: 0.0, gap: 0.0 };
    }
    let (by, gap) = correction(law, pyramid, [a, b, c], mean, excess);
    let middle = (by[0] + by[1] + by[2]) * 0.333_333_33;
    let [x, y, z] = by.map(|d| (d - middle) / (2.0 * law.shear) + middle / (3.0 * law.bulk));
    PyramidReturn { by, plastic: (0.666_666_7 * (x * x + y * y + z * z)).sqrt(), gap }
}

/// As `MohrCoulomb::hardened`; the unknown is the increment of the plastic strain. `first`: the increment of the return to the pyramid at `before`.
fn hardened_pyramid(law: &Law32, s: [f32; 3], mean: f32, before: f32, first: f32) -> PyramidReturn {
    let at = |increment: f32| return_to(law, &pyramid_at(law, before + increment), s, mean);
    // error of the plastic strain from the rounding of the stress
    let noise = 2e-7 * ((s[0] - s[2]) + mean.abs()) / law.shear;
    let (mut low, mut low_rest, mut high) = (0.0, -first, first);
    let mut found = at(high);
    for _ in 0..40 {
        if high >= found.plastic {
            break;
        }
        (low, low_rest) = (high, high - found.plastic);
        high *= 2.0;
        found = at(high);
    }
    let mut high_rest = high - found.plastic;
    if high_rest <= 1e-6 * found.plastic + noise {
        return found;
    }
    let mut stayed = 0;
    for round in 1..=60 {
        let share = if round % 8 == 0 { 0.5 } else { low_rest / (low_rest - high_rest) };
        let middle = low + share * (high - low);
        if middle <= low || middle >= high {
            break;
        }
        let there = at(middle);
        let rest = middle - there.plastic;
        if rest.abs() <= 1e-6 * there.plastic + noise {
            return there;
        }
        if rest < 0.0 {
            (low, low_rest) = (middle, rest);
            high_rest *= if stayed == 1 { 0.5 } else { 1.0 };
            stayed = 1;
        } else {
            (high, high_rest, found) = (middle, rest, there);
            low_rest *= if stayed == -1 { 0.5 } else { 1.0 };
            stayed = -1;
        }
    }
    PyramidReturn { plastic: high, ..found }
}

/// The increments of stress, plastic strain and gap. `elastic`: increment of the trial stress, Pa; `deviator`, `mean`: of the trial stress, Pa.
pub fn mohr_coulomb(law: &Law32, elastic: Sym32, deviator: &Sym32, mean: f32, plastic: f32) -> Step {
    let Turned { on, axes: [u, v, w], .. } = principal(deviator);
    let mut end = return_to(law, &pyramid_at(law, plastic), on, mean);
    if plastic < law.settled && end.plastic > 0.0 {
        end = hardened_pyramid(law, on, mean, plastic, end.plastic);
    }
    let by = end.by;
    let stress = std::array::from_fn(|k| {
        let (i, j) = if k < 3 { (k, k) } else { (k - 3, (k - 2) % 3) };
        elastic[k] + (by[0] * (u[i] * u[j]) + by[1] * (v[i] * v[j]) + by[2] * (w[i] * w[j]))
    });
    Step { stress, plastic: end.plastic, gap: end.gap }
}
