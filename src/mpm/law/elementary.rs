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

/// Sine of an angle within -pi/2..pi/2, rad: Taylor series.
#[inline]
pub fn sin(angle: f64) -> f64 {
    let square = angle * angle;
    let mut sum = 0.0;
    let mut n = 21;
    while n > 1 {
        // the signs alternate: + at 1, 5, 9 …
        let term = if n % 4 == 1 { FACTORIALS[n] } else { -FACTORIALS[n] };
        sum = term + sum * square;
        n -= 2;
    }
    angle + angle * (square * sum)
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
    let mut sum = 0.0;
    let mut k = 14;
    while k > 0 {
        sum = FACTORIALS[k] + sum * r;
        k -= 1;
    }
    let power = f64::from_bits((1023 - halvings) << 52);
    (1.0 + r * sum) * power
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
