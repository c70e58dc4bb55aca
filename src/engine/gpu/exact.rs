//! Sums that keep what f32 would lose, and positions as a cell, a whole number of units and what is left of one. Twin of `exact.wgsl`, f32.

/// Units in a cell; offsets are counted from the cell's middle node.
pub const UNITS: f32 = 1_073_741_824.0;
#[cfg(test)]
const WIDTH: i32 = 1 << 30;
const HALF: i32 = 1 << 29;

/// high + low + x, with what does not fit into the first in the second (Knuth's two-sum).
#[cfg(test)]
pub fn add([high, low]: [f32; 2], x: f32) -> [f32; 2] {
    let b = low + x;
    let sum = high + b;
    let part = sum - high;
    [sum, (high - (sum - part)) + (b - part)]
}

/// A high and a low part of a number.
pub fn split(x: f64) -> [f32; 2] {
    let high = x as f32;
    [high, (x - f64::from(high)) as f32]
}

/// An offset after a move of `by` cells, |by| < 1.5: units, what is left of one, cells passed.
#[cfg(test)]
pub fn moved(units: i32, rest: f32, by: f32) -> (i32, f32, i32) {
    let sum = by * UNITS + rest;
    let whole = sum.floor();
    let there = units + whole as i32;
    let shift = i32::from(there >= HALF) - i32::from(there < -HALF);
    (there - shift * WIDTH, sum - whole, shift)
}

/// Cell, units and rest of a place, in cells from the domain's corner.
pub fn place(x: f64) -> (i32, i32, f32) {
    let cell = (x - 0.5).floor();
    let units = (x - cell - 1.0) * f64::from(UNITS);
    let whole = units.floor();
    if whole as i32 >= HALF {
        // x − ½ lies just below a whole number
        return (cell as i32 + 1, -HALF, 0.0);
    }
    (cell as i32, whole as i32, (units - whole) as f32)
}

/// The place again.
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
