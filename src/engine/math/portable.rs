//! Power, exponential, logarithm, sine and ln Γ computed by + − × ÷ in a stated order, so that their results have the same bits on every machine. (System
//! libraries choose different variants by instruction set.)

use std::f64::consts::{FRAC_1_SQRT_2, SQRT_2};

/// ln 2 in two parts. The first ends with zero bits, so that its product with an exponent is exact.
const LN2_HIGH: f64 = 6.931_471_803_691_238e-1;
const LN2_LOW: f64 = 1.908_214_929_270_587_7e-10;

/// `base` to the power of `exponent`, for a positive `base`; accurate to a few units in the last place unless the result is extreme. NaN if `base` is not a
/// positive normal number.
pub fn pow(base: f64, exponent: f64) -> f64 {
    exp(exponent * ln(base))
}

/// Natural logarithm of a positive normal number (else NaN), with ln m = 2 artanh((m − 1)/(m + 1)) for the mantissa m in 0.7..1.42.
pub fn ln(x: f64) -> f64 {
    if !(x.is_normal() && x > 0.0) {
        return f64::NAN;
    }
    let bits = x.to_bits();
    let mut exponent = ((bits >> 52) as i32) - 1023;
    let mut mantissa = f64::from_bits((bits & ((1 << 52) - 1)) | (1023 << 52));
    if mantissa > SQRT_2 {
        mantissa *= 0.5;
        exponent += 1;
    }
    debug_assert!(mantissa > 0.999 * FRAC_1_SQRT_2);
    let s = (mantissa - 1.0) / (mantissa + 1.0);
    let s2 = s * s;
    let mut sum = 0.0;
    for k in (1..=12).rev() {
        sum = (sum + 1.0 / f64::from(2 * k + 1)) * s2;
    }
    let e = f64::from(exponent);
    e * LN2_HIGH + (e * LN2_LOW + 2.0 * s * (1.0 + sum))
}

/// Exponential function: 2^n times the Taylor series of the remainder, which is at most ln 2 / 2. Infinite above 709, 0 below −708.
pub fn exp(x: f64) -> f64 {
    if x.is_nan() {
        return x;
    }
    if x > 709.0 {
        return f64::INFINITY;
    }
    if x < -708.0 {
        return 0.0;
    }
    let n = (x / (LN2_HIGH + LN2_LOW)).round();
    let r = (x - n * LN2_HIGH) - n * LN2_LOW;
    let mut sum = 1.0;
    for k in (1..=16).rev() {
        sum = 1.0 + sum * r / f64::from(k);
    }
    // n is within -1022..=1023 by the bounds above.
    sum * f64::from_bits(((n as i64 + 1023) as u64) << 52)
}

/// Sine of an angle from −π/2 to π/2, rad, by its Taylor series.
pub fn sin(angle: f64) -> f64 {
    let square = angle * angle;
    let mut sum = 1.0;
    for k in (1..=12).rev() {
        sum = 1.0 - sum * square / f64::from(2 * k * (2 * k + 1));
    }
    angle * sum
}

/// Angle from 0 to π/2, rad, whose tangent is the ratio of two numbers that are not negative and not both zero.
pub fn angle(opposite: f64, adjacent: f64) -> f64 {
    if opposite <= adjacent { atan(opposite / adjacent) } else { std::f64::consts::FRAC_PI_2 - atan(adjacent / opposite) }
}

/// Arc tangent of a number from 0 to 1, rad: four times that of what halving the angle twice leaves, by its Taylor series.
fn atan(tangent: f64) -> f64 {
    let half = |t: f64| t / (1.0 + (1.0 + t * t).sqrt());
    let t = half(half(tangent));
    let square = t * t;
    let mut sum = 0.0;
    for k in (0..=12).rev() {
        sum = 1.0 / f64::from(2 * k + 1) - square * sum;
    }
    4.0 * t * sum
}

/// ln Γ(x) for x > 0: Stirling's series for x ≥ 12, and Γ(x + 1) = x Γ(x) below.
pub fn ln_gamma(x: f64) -> f64 {
    const SERIES: [f64; 6] = [1.0 / 12.0, -1.0 / 360.0, 1.0 / 1260.0, -1.0 / 1680.0, 1.0 / 1188.0, -691.0 / 360_360.0];
    const HALF_LN_2_PI: f64 = 0.918_938_533_204_672_7;
    let (mut large, mut product) = (x, 1.0);
    while large < 12.0 {
        product *= large;
        large += 1.0;
    }
    let inverse = 1.0 / large;
    let series = SERIES.iter().rev().fold(0.0, |sum, c| sum * (inverse * inverse) + c) * inverse;
    (large - 0.5) * ln(large) - large + HALF_LN_2_PI + series - ln(product)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn arc_tangent_follows_the_library() {
        for k in 0..=1000 {
            let t = 1e-3 * f64::from(k);
            assert!((atan(t) - t.atan()).abs() < 4e-16, "{t}: {:e}", atan(t) - t.atan());
            for [y, x] in [[t, 1.0], [1.0, t]] {
                assert!((angle(y, x) - y.atan2(x)).abs() < 4e-16, "{y} {x}: {:e}", angle(y, x) - y.atan2(x));
            }
        }
    }

    #[test]
    fn power_follows_the_library() {
        for i in 1..2000 {
            let base = 1e-4 * f64::from(i) * f64::from(i);
            for exponent in [-1.5, -1.0, -0.3, -0.017, 0.0, 2.0 / 3.0, 3.0] {
                let expected = base.powf(exponent);
                let error = (pow(base, exponent) / expected - 1.0).abs();
                assert!(error < 1e-14, "{base}^{exponent}: {error:e}");
            }
        }
        assert_eq!(pow(1.0, -1.5), 1.0);
        assert!(pow(0.0, 2.0).is_nan() && pow(-1.0, 2.0).is_nan() && pow(f64::NAN, 1.0).is_nan());
        assert_eq!(pow(1e300, 3.0), f64::INFINITY);
        assert_eq!(pow(1e-300, 3.0), 0.0);
    }

    #[test]
    fn exponential_follows_the_library() {
        for i in -700..=700 {
            let x = f64::from(i) + 0.37;
            let error = (exp(x) / x.exp() - 1.0).abs();
            assert!(error < 1e-15, "exp {x}: {error:e}");
        }
        assert_eq!((exp(0.0), exp(-1e9), exp(1e9)), (1.0, 0.0, f64::INFINITY));
    }

    #[test]
    fn gamma_follows_the_library() {
        for i in 1..400 {
            let x = 0.05 * f64::from(i);
            let expected = statrs::function::gamma::ln_gamma(x);
            assert!((ln_gamma(x) - expected).abs() < 1e-13 * expected.abs().max(1.0), "{x}");
        }
    }

    #[test]
    fn sine_follows_the_library() {
        for i in 0..=1000 {
            let angle = f64::from(i) * 1e-3 * std::f64::consts::FRAC_PI_2;
            assert!((sin(angle) - angle.sin()).abs() < 4e-16, "{angle}");
        }
    }
}
