//! Sine and exponential of the yielding points from + - *, so that they are the same bytes on every machine. Those of
//! `crush::portable` are as portable but divide at each term, which a law in the step loop cannot afford.

const LN2_HIGH: f64 = 6.931_471_803_691_238e-1;
const LN2_LOW: f64 = 1.908_214_929_270_587_7e-10;

/// 1 / n! at the n-th place.
const FACTORIALS: [f64; 22] = {
    let mut out = [1.0; 22];
    let mut n = 1;
    let mut factorial = 1.0;
    while n < out.len() {
        factorial *= n as f64;
        out[n] = 1.0 / factorial;
        n += 1;
    }
    out
};

/// Coefficients of sin(x) = x + x³ (c0 + c1 x² + c2 x⁴ …), to x²¹.
const SINE: [f64; 10] = {
    let mut out = [0.0; 10];
    let mut k = 0;
    while k < out.len() {
        out[k] = if k % 2 == 0 { -FACTORIALS[2 * k + 3] } else { FACTORIALS[2 * k + 3] };
        k += 1;
    }
    out
};

/// Coefficients of exp(x) = 1 + x (c0 + c1 x + c2 x² …), to x¹⁴.
const EXPONENTIAL: [f64; 14] = {
    let mut out = [0.0; 14];
    let mut k = 0;
    while k < out.len() {
        out[k] = FACTORIALS[k + 1];
        k += 1;
    }
    out
};

/// c0 + c1 x + c2 x² …, even and odd powers beside each other: half as long a chain of operations that wait for each other.
#[inline(always)]
fn polynomial<const N: usize>(c: &[f64; N], x: f64) -> f64 {
    const { assert!(N.is_multiple_of(2)) };
    let square = x * x;
    let (mut even, mut odd) = (c[N - 2], c[N - 1]);
    let mut k = N - 2;
    while k > 0 {
        k -= 2;
        even = c[k] + even * square;
        odd = c[k + 1] + odd * square;
    }
    even + x * odd
}

/// Sine of an angle within -pi/2..pi/2, rad: Taylor series.
#[inline]
pub fn sin(angle: f64) -> f64 {
    let square = angle * angle;
    angle + angle * (square * polynomial(&SINE, square))
}

/// exp(-x) for x >= 0: a power of two times the Taylor series of the remainder, at most ln 2 / 2 in size. 0 beyond 700.
#[inline]
pub fn decay(x: f64) -> f64 {
    if x > 700.0 {
        return 0.0;
    }
    // to the nearest whole number; x is not negative
    let halvings = (x * std::f64::consts::LOG2_E + 0.5) as u64;
    let n = halvings as f64;
    let r = -((x - n * LN2_HIGH) - n * LN2_LOW);
    let power = f64::from_bits((1023 - halvings) << 52);
    (1.0 + r * polynomial(&EXPONENTIAL, r)) * power
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn both_follow_the_library() {
        for i in 0..=2000 {
            let angle = f64::from(i - 1000) * 1e-3 * std::f64::consts::FRAC_PI_2;
            assert!((sin(angle) - angle.sin()).abs() < 3e-16, "sin {angle}");
            let x = 1e-4 * f64::from(i) * f64::from(i);
            let expected = (-x).exp();
            assert!((decay(x) - expected).abs() <= 6e-16 * expected, "exp -{x}");
        }
        assert_eq!(decay(0.0), 1.0);
        assert_eq!(decay(1e9), 0.0);
    }
}
