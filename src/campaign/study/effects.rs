//! Main effects and interactions of a factorial.

use super::compare::{Difference, Sample};
use super::plan::{Design, Plan, Setting};

/// The effect of a level, or of two levels together.
#[derive(Clone, Debug, PartialEq)]
pub struct Effect {
    /// Factor and levels, as `law: hertz → linear`; of an interaction both, with `×` between.
    pub name: String,
    /// By how much the measure changes from the factor's first level to this one, on the mean over all levels of the other factors. Of an interaction: by how much
    /// more it changes than the two effects one by one.
    pub difference: Difference,
}

/// Indices of the settings of a factorial in which each of these factors has this level.
fn at(settings: &[Setting], levels: &[(usize, usize)]) -> Vec<usize> {
    let has = |s: &Setting| levels.iter().all(|(f, k)| s.levels[*f] == Some(*k));
    (0..settings.len()).filter(|i| has(&settings[*i])).collect()
}

/// All main effects, then all interactions of two factors; none for a study with one factor at a time. In a fraction, those interactions are left out that no run
/// tells from a main effect, and those that no run tells from each other are one effect with both names.
pub fn of(plan: &Plan, settings: &[Setting], sample: &Sample) -> Vec<Effect> {
    if plan.design == Design::OneAtATime {
        return Vec::new();
    }
    let name = |f: usize, k: usize| {
        let levels = &plan.factors[f].levels;
        format!("{}: {} → {}", plan.factors[f].name, levels[0].name, levels[k].name)
    };
    let others = |f: usize| 1..plan.factors[f].levels.len();
    let mut effects = Vec::new();
    let mut add = |name: String, terms: &[(f64, Vec<usize>)]| {
        if let Some(difference) = sample.contrast(terms) {
            effects.push(Effect { name, difference });
        }
    };
    for (f, k) in (0..plan.factors.len()).flat_map(|f| others(f).map(move |k| (f, k))) {
        add(name(f, k), &[(1.0, at(settings, &[(f, k)])), (-1.0, at(settings, &[(f, 0)]))]);
    }
    let both = |[f, g]: [usize; 2], k: usize, l: usize| format!("{} × {}", name(f, k), name(g, l));
    let pairs: Vec<[usize; 2]> = (0..plan.factors.len()).flat_map(|f| (f + 1..plan.factors.len()).map(move |g| [f, g])).collect();
    for (n, &[f, g]) in pairs.iter().enumerate() {
        let mut also = Vec::new();
        if plan.design == Design::Fraction {
            let same = |pair: &&[usize; 2]| is_the_same(settings, &[&[f, g], &pair[..]]);
            let of_main = (0..plan.factors.len()).any(|h| h != f && h != g && is_the_same(settings, &[&[f, g], &[h]]));
            if of_main || pairs[..n].iter().any(|pair| same(&pair)) {
                continue;
            }
            also.extend(pairs[n + 1..].iter().filter(same).map(|pair| both(*pair, 1, 1)));
        }
        for (k, l) in others(f).flat_map(|k| others(g).map(move |l| (k, l))) {
            let part = |sign: f64, k: usize, l: usize| (sign, at(settings, &[(f, k), (g, l)]));
            let names: Vec<String> = std::iter::once(both([f, g], k, l)).chain(also.iter().cloned()).collect();
            add(names.join(" or "), &[part(1.0, k, l), part(-1.0, k, 0), part(-1.0, 0, l), part(1.0, 0, 0)]);
        }
    }
    effects
}

/// Whether the products of these sets of factors, each with two levels, are equal in all runs of a fraction, or opposite in all.
fn is_the_same(settings: &[Setting], products: &[&[usize]]) -> bool {
    let runs: Vec<&Setting> = settings.iter().filter(|s| s.levels.iter().all(Option::is_some)).collect();
    let sign = |s: &Setting, k: usize| if s.levels[k] == Some(0) { -1 } else { 1 };
    let product = |s: &Setting| products.iter().copied().flatten().map(|k| sign(s, *k)).product::<i32>();
    runs.iter().map(|s| product(s)).sum::<i32>().unsigned_abs() as usize == runs.len()
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Four factors in eight runs: the fourth is the product of the others, so interactions come in pairs; in four runs three factors are each other's interactions.
    #[test]
    fn what_a_fraction_cannot_tell_apart_has_both_names() {
        let settings = |columns: &[fn(usize) -> usize], runs: usize| -> Vec<Setting> {
            let levels = |run: usize| columns.iter().map(|of| Some(of(run) % 2)).collect();
            (0..runs).map(|run| Setting { name: String::new(), levels: levels(run), sets: Vec::new(), borrows: false }).collect()
        };
        let of = [|r: usize| r, |r: usize| r / 2, |r: usize| r / 4, |r: usize| 1 + r + r / 2 + r / 4];
        let eight = settings(&of, 8);
        assert!(is_the_same(&eight, &[&[0, 1], &[2, 3]]) && !is_the_same(&eight, &[&[0, 1], &[0, 2]]));
        assert!(!is_the_same(&eight, &[&[0, 1], &[3]]));
        assert!(is_the_same(&settings(&[of[0], of[1], |r| r + r / 2], 4), &[&[0, 1], &[2]]));
    }
}
