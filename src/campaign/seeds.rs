//! Lists of seeds as a person writes them: `1..8`, `1,2,5`.

use laboratory::error::{Error, Result};
use std::collections::HashSet;

/// Largest number of seeds in one list.
const MOST: usize = 10_000;

/// Which random streams are set by the seeds of an ensemble.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum Vary {
    /// Specimen and strengths.
    #[default]
    Both,
    /// The specimen; strengths as the scene says.
    Packing,
    /// Strengths; the specimen as the scene says.
    Strength,
}

/// Seeds from `1..8` (both ends included), `1,2,5` or both (`1..3,7`), in the order written.
///
/// # Errors
/// Text that is no such list, or a seed that stands in the list twice.
pub fn parse(text: &str) -> Result<Vec<u64>> {
    let fail = |message: String| Error::input(format!("seeds {text}"), "", None, message);
    let number = |s: &str| {
        let wanted = || fail(format!("`{s}` is no seed: write whole numbers as in 1..8 or 1,2,5"));
        // a scene holds seeds as whole numbers of 63 bits
        s.trim().parse::<u64>().ok().filter(|&n| i64::try_from(n).is_ok()).ok_or_else(wanted)
    };
    let (mut seeds, mut seen) = (Vec::new(), HashSet::new());
    for part in text.split(',') {
        let (first, last) = match part.split_once("..") {
            Some((a, b)) => (number(a)?, number(b.strip_prefix('=').unwrap_or(b))?),
            None => (number(part)?, number(part)?),
        };
        if last < first {
            return Err(fail(format!("{part} counts down: write the smaller seed first")));
        }
        if last - first >= MOST as u64 || seeds.len() + (last - first) as usize >= MOST {
            return Err(fail(format!("more than {MOST} seeds")));
        }
        for seed in first..=last {
            if !seen.insert(seed) {
                return Err(fail(format!("{seed} stands there twice")));
            }
            seeds.push(seed);
        }
    }
    Ok(seeds)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn ranges_include_their_ends_and_lists_keep_their_order() {
        assert_eq!(parse("1..4").expect("range"), [1, 2, 3, 4]);
        assert_eq!(parse("1..=2").expect("range"), [1, 2]);
        assert_eq!(parse("5, 1,2").expect("list"), [5, 1, 2]);
        assert_eq!(parse("1..3,7").expect("both"), [1, 2, 3, 7]);
        assert_eq!(parse("0").expect("one"), [0]);
    }

    #[test]
    fn what_is_no_list_is_refused_with_its_text() {
        for (text, says) in [
            ("", "is no seed"),
            ("1,", "is no seed"),
            ("a..3", "`a` is no seed"),
            ("-1", "is no seed"),
            ("1.5", "is no seed"),
            ("18446744073709551615", "is no seed"),
            ("3..1", "counts down"),
            ("1,2,1", "1 stands there twice"),
            ("1..3,2", "2 stands there twice"),
            ("1..1000000000000", "more than"),
            ("0..9223372036854775807", "more than"),
        ] {
            let error = parse(text).expect_err(text).to_string();
            assert!(error.contains(says) && error.contains("seeds "), "{text}: {error}");
        }
    }
}
