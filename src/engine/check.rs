//! Checks of a state that comes from outside, such as a file: what every number, list and index of it must be before it is used. Each type checks what it
//! owns (`check` beside the type); these are the parts that they share. A failed check says in plain words what is wrong.

use std::borrow::Borrow;
use std::fmt::Display;

/// Result of a check; the error says what is wrong.
pub type Checked = Result<(), String>;

/// Largest magnitude of a number in a state, SI units: far above all that a run can need, and still a number in single precision.
pub const LARGEST: f64 = 1e36;
/// Largest number of steps or events in a state: counting on from here overflows in no lifetime.
pub const MOST: u64 = 1 << 53;

/// Fails with the words of `wrong` unless `ok`.
///
/// # Errors
/// What is wrong.
pub fn ensure(ok: bool, wrong: impl FnOnce() -> String) -> Checked {
    if ok { Ok(()) } else { Err(wrong()) }
}

/// Checks that all values are numbers of possible size; `of` names them.
///
/// # Errors
/// The first value that is not.
pub fn numbers(of: impl Display, values: impl IntoIterator<Item = impl Borrow<f64>>) -> Checked {
    all(of, values, "no number that can be", |x| x.abs() <= LARGEST)
}

/// As [`numbers`], for values that must not be negative.
///
/// # Errors
/// The first value that is not.
pub fn not_negative(of: impl Display, values: impl IntoIterator<Item = impl Borrow<f64>>) -> Checked {
    all(of, values, "not from 0 on", |x| (0.0..=LARGEST).contains(&x))
}

/// As [`numbers`], for values that must be above 0.
///
/// # Errors
/// The first value that is not.
pub fn positive(of: impl Display, values: impl IntoIterator<Item = impl Borrow<f64>>) -> Checked {
    all(of, values, "not above 0", |x| (LARGEST.recip()..=LARGEST).contains(&x))
}

/// Checks every value by `fits`; `of` names the values, `not` says what one is that does not fit.
///
/// # Errors
/// The first value that does not fit.
pub fn all(of: impl Display, values: impl IntoIterator<Item = impl Borrow<f64>>, not: &str, fits: impl Fn(f64) -> bool) -> Checked {
    let mut values = values.into_iter().map(|x| *x.borrow()).enumerate();
    values.find(|(_, x)| !fits(*x)).map_or(Ok(()), |(k, x)| Err(format!("{of}, value {k}: {x:e} is {not}")))
}

/// Checks that lists have as many entries as there are `of`: `n`.
///
/// # Errors
/// The first list of another length.
pub fn lengths(of: impl Display, n: usize, lengths: impl IntoIterator<Item = usize>) -> Checked {
    let mut lengths = lengths.into_iter().enumerate();
    lengths
        .find(|(_, length)| *length != n)
        .map_or(Ok(()), |(k, length)| Err(format!("{of}: list {k} has {length} entries for {n}")))
}

/// Checks an index or a count, which must be below `end`.
///
/// # Errors
/// One that is not.
pub fn below(of: impl Display, k: impl TryInto<u64> + Copy + Display, end: usize) -> Checked {
    ensure(k.try_into().is_ok_and(|k| k < end as u64), || format!("{of} {k} of {end}"))
}

/// Checks counters, which must not exceed [`MOST`].
///
/// # Errors
/// The first that does.
pub fn counters(of: impl Display, values: &[u64]) -> Checked {
    values.iter().find(|n| **n > MOST).map_or(Ok(()), |n| Err(format!("{of}: {n} is no number that can be reached by counting")))
}

/// Checks identities: each stands once and is below `next`, which the next new one gets.
///
/// # Errors
/// One that stands twice or is too high.
pub fn identities(of: impl Display, ids: &[u32], next: u32) -> Checked {
    let mut sorted = ids.to_vec();
    sorted.sort_unstable();
    if let Some(twice) = sorted.windows(2).find(|w| w[0] == w[1]) {
        return Err(format!("{of} {} stands twice", twice[0]));
    }
    sorted.last().map_or(Ok(()), |last| below(of, *last, next as usize))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn what_is_wrong_is_said_in_words() {
        let told = |checked: Checked| checked.expect_err("wrong");
        assert_eq!(told(numbers("speeds", [1.0, f64::NAN])), "speeds, value 1: NaN is no number that can be");
        assert!(numbers("speeds", [-LARGEST, 0.0, LARGEST]).is_ok() && numbers("speeds", [f64::INFINITY]).is_err());
        assert!(not_negative("works", [0.0]).is_ok() && not_negative("works", [-1e-300]).is_err());
        assert_eq!(told(positive("radii", [0.1, 0.0])), "radii, value 1: 0e0 is not above 0");
        assert!(positive("radii", [5e-324]).is_err(), "what vanishes in the next product is nothing");
        assert_eq!(told(lengths("grains", 2, [2, 3])), "grains: list 1 has 3 entries for 2");
        assert_eq!(told(below("grain", 300_u32, 120)), "grain 300 of 120");
        assert_eq!(told(identities("grain", &[4, 1, 4], 9)), "grain 4 stands twice");
        assert!(identities("grain", &[8, 1], 9).is_ok() && identities("grain", &[9], 9).is_err());
        assert!(counters("steps", &[MOST]).is_ok() && counters("steps", &[u64::MAX]).is_err());
    }
}
