//! "Did you mean …?"

/// Length of the longest word that is taken for a slip, bytes; the time of a comparison goes with the length of both words.
const LONGEST: usize = 200;

/// The candidate nearest to `word`, if it is near enough to be a slip.
pub fn nearest<'a>(word: &str, candidates: impl Iterator<Item = &'a str>) -> Option<&'a str> {
    if word.len() > LONGEST {
        return None;
    }
    let lower = word.to_lowercase();
    candidates
        .filter(|c| c.len() <= LONGEST)
        .map(|c| {
            let folded = c.to_lowercase();
            let edits = strsim::damerau_levenshtein(&lower, &folded);
            (edits, strsim::jaro_winkler(&lower, &folded), c)
        })
        .filter(|(edits, likeness, _)| *edits <= 2 || *likeness > 0.85)
        .max_by(|a, b| a.1.total_cmp(&b.1).then(b.0.cmp(&a.0)))
        .map(|(_, _, c)| c)
}

#[cfg(test)]
mod tests {
    use super::nearest;

    #[test]
    fn slips_are_found_and_strangers_are_not() {
        let keys = ["max_stress_kPa", "rate", "stages_kPa", "servo_gain"];
        assert_eq!(nearest("max_stres_kpa", keys.into_iter()), Some("max_stress_kPa"));
        assert_eq!(nearest("raet", keys.into_iter()), Some("rate"));
        assert_eq!(nearest("temperature", keys.into_iter()), None);
    }
}
