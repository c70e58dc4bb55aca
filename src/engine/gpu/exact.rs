//! Arithmetic in f32 that loses less than f32 alone: compensated sums (a high part and a low part, the rounding error of the high one), and coordinates as a
//! cell, a whole number of units (2^-30 cells) and a fraction of a unit, the rest. Twin of `exact.wgsl`.

/// Units in a cell. The cell of a coordinate is that of the B-spline: the offset is counted from the nearest node, the middle one of the three that the point
/// reaches along an axis, and lies within half a cell of it.
pub const UNITS: f32 = 1_073_741_824.0;
#[cfg(test)]
const WIDTH: i32 = 1 << 30;
const HALF: i32 = 1 << 29;

/// The compensated sum of high + low and x: the rounded sum, and its rounding error (Knuth's two-sum).
#[cfg(test)]
pub fn add([high, low]: [f32; 2], x: f32) -> [f32; 2] {
    let b = low + x;
    let sum = high + b;
    let part = sum - high;
    [sum, (high - (sum - part)) + (b - part)]
}

/// A number as the sum of two f32: its rounded value and the rest.
pub fn split(x: f64) -> [f32; 2] {
    let high = x as f32;
    [high, (x - f64::from(high)) as f32]
}

/// An offset after a displacement of `by` cells, |by| < 1.5: units, rest, and number of cells passed.
#[cfg(test)]
pub fn moved(units: i32, rest: f32, by: f32) -> (i32, f32, i32) {
    let sum = by * UNITS + rest;
    let whole = sum.floor();
    let there = units + whole as i32;
    let shift = i32::from(there >= HALF) - i32::from(there < -HALF);
    (there - shift * WIDTH, sum - whole, shift)
}

/// Cell, units and rest of the coordinate `x`, in cells from the corner of the domain.
pub fn place(x: f64) -> (i32, i32, f32) {
    let cell = (x - 0.5).floor();
    let units = (x - cell - 1.0) * f64::from(UNITS);
    let whole = units.floor();
    if whole as i32 >= HALF {
        // x − ½ is a whole number but for rounding
        return (cell as i32 + 1, -HALF, 0.0);
    }
    (cell as i32, whole as i32, (units - whole) as f32)
}

/// The coordinate, in cells from the corner of the domain, from cell, units and rest.
pub fn placed(cell: i32, units: i32, rest: f32) -> f64 {
    f64::from(cell) + 1.0 + (f64::from(units) + f64::from(rest)) / f64::from(UNITS)
}

#[cfg(test)]
mod tests {
    use super::*;
    use proptest::prelude::*;

    proptest! {
        #[test]
        fn places_come_back(x in -0.5..1e3_f64) {
            let (cell, units, rest) = place(x);
            prop_assert!((-HALF..HALF).contains(&units));
            prop_assert!((placed(cell, units, rest) - x).abs() < 1e-12);
        }

        #[test]
        fn a_move_is_a_move(x in 5.0..6.0_f64, by in -1.4..1.4_f32) {
            let (cell, units, rest) = place(x);
            let (units, rest, shift) = moved(units, rest, by);
            // f32 keeps 24 bits of the move
            prop_assert!((placed(cell + shift, units, rest) - x - f64::from(by)).abs() < 1e-7 * f64::from(by.abs()) + 1e-15);
        }
    }

    #[test]
    fn slow_drifts_are_kept() {
        let (mut sum, mut naive) = (split(-1e5), -1e5_f32);
        let (_, mut units, mut rest) = place(5.0);
        for _ in 0..500_000 {
            sum = add(sum, 1e-3);
            naive += 1e-3;
            (units, rest, _) = moved(units, rest, 1e-9);
        }
        let change = f64::from(sum[0]) + f64::from(sum[1]) + 1e5;
        assert!((change / 500.0 - 1.0).abs() < 1e-6, "{change}");
        assert_eq!(naive, -1e5, "which plain f32 loses");
        let drift = placed(4, units, rest) - 5.0;
        assert!((drift / 5e-4 - 1.0).abs() < 1e-6, "{drift}");
    }
}
