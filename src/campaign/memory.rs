//! How many runs at a time fit into the memory that is free.

use laboratory::machine::size;

/// Runs at a time whose memory, `needs`, bytes, fits into what is `free`, bytes, even if the largest come together: at most
/// `parallel`, and at least one. Where they are fewer than `parallel` the second value says why.
pub fn at_a_time(needs: &[f64], parallel: usize, free: Option<u64>) -> (usize, Option<String>) {
    let mut largest = needs.to_vec();
    largest.sort_unstable_by(|a, b| b.total_cmp(a));
    largest.truncate(parallel);
    let (sum, Some(free)) = (largest.iter().sum::<f64>(), free.map(|free| free as f64)) else { return (parallel, None) };
    if sum <= free {
        return (parallel, None);
    }
    let mut sums = largest.iter().scan(0.0, |sum, need| {
        *sum += need;
        Some(*sum)
    });
    let fit = sums.by_ref().take_while(|sum| *sum <= free).count().max(1);
    let runs = largest.len();
    let why = format!(
        "{runs} runs at a time may take some {} of memory, and {} are free on this machine: {fit} at a time {} made",
        size(sum),
        size(free),
        if fit == 1 { "is" } else { "are" }
    );
    // a single run may be larger than that only at its end, as `run` says of it too
    let alone = if largest[0] > free { "; even one may run short of memory at its end" } else { "" };
    (fit, Some(why + alone))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_largest_runs_together_have_to_fit() {
        let gb = 1e9;
        let needs = [1.0 * gb, 4.0 * gb, 2.0 * gb, 4.0 * gb];
        let fit = |parallel, free: u64| at_a_time(&needs, parallel, Some(free * 1_000_000_000));
        assert_eq!(fit(2, 8), (2, None));
        assert_eq!(fit(4, 11), (4, None));
        let (runs, why) = fit(4, 10);
        assert_eq!(runs, 3);
        let why = why.expect("told");
        assert!(why.contains("4 runs at a time may take some 11.0 GB") && why.contains("10.0 GB are free"), "{why}");
        assert!(why.ends_with("3 at a time are made"), "{why}");
        assert_eq!(fit(4, 7).0, 1);
        let (runs, why) = fit(1, 3);
        assert!(runs == 1 && why.expect("told").contains("even one may run short"));
        assert_eq!(at_a_time(&needs, 4, None), (4, None), "the system does not say");
        assert_eq!(at_a_time(&[], 4, Some(1)), (4, None), "nothing is left to do");
    }
}
