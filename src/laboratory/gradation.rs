//! Grain size distributions by mass: of the grains of a run with the lost mass added back (Ciantia et al. 2015, eq. 12
//! and "Upscaling procedure": sizes are divided by the scale N), their indices, and diameters drawn from a given one.
//!
//! Fractions are 0..1 of the mass finer than or equal to a size; sizes are diameters, m; masses kg.

use engine::breakage::lost_mass::Fines;
use rand::seq::SliceRandom;
use rand::{Rng, RngExt};

/// Size to which Hardin (1985) counts breakage, m: the largest silt.
pub const HARDIN_SILT: f64 = 0.074e-3;

/// A gradation: grains, each of one size, and lost mass, each event's spread by [`Fines`]. Sizes are divided by N.
#[derive(Clone, Debug)]
pub struct Gradation {
    /// Sorted by diameter: diameter and mass of the grains up to and with this one.
    grains: Vec<(f64, f64)>,
    /// Sorted by largest size.
    events: Vec<LostEvent>,
    fines: Fines,
    total: f64,
    grain_mass: f64,
}

/// The lost mass of one event.
#[derive(Clone, Copy, Debug)]
struct LostEvent {
    d_max: f64,
    mass: f64,
    /// Lost mass of the events up to and with this one, kg.
    up_to: f64,
    /// Sum over this event and all with a larger `d_max` of mass / rise(d_max): times rise(d), their mass finer than d.
    density_from: f64,
}

impl Gradation {
    /// The gradation of grains (diameter, mass) and lost events (lost mass, diameter of the smallest daughter), all
    /// lengths as in the run, that is multiplied by `scale`, as `fines.d_min` is. Entries whose size or mass is not
    /// positive and finite are left out.
    pub fn new(
        grains: impl IntoIterator<Item = (f64, f64)>,
        lost: impl IntoIterator<Item = (f64, f64)>,
        fines: Fines,
        scale: f64,
    ) -> Self {
        let holds = |d: f64, mass: f64| d > 0.0 && mass > 0.0 && d.is_finite() && mass.is_finite();
        let fines = Fines { d_min: fines.d_min / scale, ..fines };

        let mut grains: Vec<(f64, f64)> =
            grains.into_iter().map(|(d, mass)| (d / scale, mass)).filter(|&(d, mass)| holds(d, mass)).collect();
        grains.sort_unstable_by(|a, b| a.0.total_cmp(&b.0).then(a.1.total_cmp(&b.1)));
        let mut grain_mass = Sum::default();
        for grain in &mut grains {
            grain.1 = grain_mass.add(grain.1);
        }

        let mut events: Vec<LostEvent> = lost
            .into_iter()
            .map(|(mass, d_max)| (d_max / scale, mass))
            .filter(|&(d, mass)| holds(d, mass))
            .map(|(d_max, mass)| LostEvent { d_max, mass, up_to: 0.0, density_from: 0.0 })
            .collect();
        events.sort_unstable_by(|a, b| a.d_max.total_cmp(&b.d_max).then(a.mass.total_cmp(&b.mass)));
        let mut lost_mass = Sum::default();
        for event in &mut events {
            event.up_to = lost_mass.add(event.mass);
        }
        let mut density = Sum::default();
        for event in events.iter_mut().rev() {
            // An event without a range of sizes adds nothing below its own size.
            if event.d_max > fines.d_min {
                density.add(event.mass / fines.rise(event.d_max));
            }
            event.density_from = density.value();
        }

        let (grain_mass, lost_mass) = (grain_mass.value(), lost_mass.value());
        Self { grains, events, fines, total: grain_mass + lost_mass, grain_mass }
    }

    /// Mass of the grains and the lost mass, kg.
    pub fn total_mass(&self) -> f64 {
        self.total
    }

    /// Mass of the grains alone, kg.
    pub fn grain_mass(&self) -> f64 {
        self.grain_mass
    }

    /// Largest size, m; `None` without mass.
    pub fn largest(&self) -> Option<f64> {
        let grain = self.grains.last().map_or(0.0, |g| g.0);
        let lost = self.events.last().map_or(0.0, |e| e.d_max);
        (self.total > 0.0).then_some(grain.max(lost))
    }

    /// Smallest size with mass at or above it, m; `None` without mass.
    pub fn smallest(&self) -> Option<f64> {
        let grain = self.grains.first().map_or(f64::INFINITY, |g| g.0);
        let lost = self.events.first().map_or(f64::INFINITY, |e| e.d_max.min(self.fines.d_min));
        (self.total > 0.0).then_some(grain.min(lost))
    }

    /// Mass fraction finer than or equal to `d`, m, with the lost mass; 0 without mass.
    pub fn passing(&self, d: f64) -> f64 {
        match self.largest() {
            None => 0.0,
            Some(largest) if d >= largest => 1.0,
            Some(_) => ((self.finer_grains(d) + self.finer_lost(d)) / self.total).clamp(0.0, 1.0),
        }
    }

    /// Fraction of the grains' mass in grains finer than or equal to `d`, m, without the lost mass.
    pub fn passing_grains(&self, d: f64) -> f64 {
        match self.grains.last() {
            None => 0.0,
            Some(last) if d >= last.0 => 1.0,
            Some(_) => (self.finer_grains(d) / self.grain_mass).clamp(0.0, 1.0),
        }
    }

    /// [`Self::passing`] at increasing sizes, m; never decreases.
    pub fn curve(&self, sizes: &[f64]) -> Vec<f64> {
        rising(sizes, |d| self.passing(d))
    }

    /// [`Self::passing_grains`] at increasing sizes, m; never decreases.
    pub fn curve_grains(&self, sizes: &[f64]) -> Vec<f64> {
        rising(sizes, |d| self.passing_grains(d))
    }

    /// Smallest size, m, with at least `fraction` of the mass finer or equal; `None` without mass.
    pub fn diameter_at(&self, fraction: f64) -> Option<f64> {
        let mut high = self.largest()?;
        let mut low = self.smallest()?;
        if self.passing(low) >= fraction {
            return Some(low);
        }
        // Halving in proportion ends at neighbouring numbers.
        loop {
            let middle = low * (high / low).sqrt();
            if !(middle > low && middle < high) {
                return Some(high);
            }
            if self.passing(middle) >= fraction {
                high = middle;
            } else {
                low = middle;
            }
            if high - low < 1e-13 * high {
                return Some(high);
            }
        }
    }

    /// Mean over the mass of ln(d / `size`) where d is above `size`, 0 where it is not: the area above the curve from
    /// `size` up, over ln d. Exact for the grains and for eq. (12).
    fn mean_log_above(&self, size: f64) -> f64 {
        if !(self.total > 0.0 && size > 0.0) {
            return 0.0;
        }
        let mut sum = Sum::default();
        let mut before = 0.0;
        for &(d, up_to) in &self.grains {
            if d > size {
                sum.add((up_to - before) * (d / size).ln());
            }
            before = up_to;
        }
        for event in &self.events {
            sum.add(event.mass * self.fines.mean_log_above(size, event.d_max));
        }
        sum.value() / self.total
    }

    /// Passing from `d`, not below `d_min`, to the next size at which the curve jumps or bends: a + b rise(d).
    fn piece(&self, d: f64) -> (f64, f64) {
        let n = self.events.partition_point(|e| e.d_max <= d);
        let whole = if n == 0 { 0.0 } else { self.events[n - 1].up_to };
        let density = self.events.get(n).map_or(0.0, |coarser| coarser.density_from);
        ((self.finer_grains(d) + whole) / self.total, density / self.total)
    }

    fn finer_grains(&self, d: f64) -> f64 {
        match self.grains.partition_point(|g| g.0 <= d) {
            0 => 0.0,
            n => self.grains[n - 1].1,
        }
    }

    fn finer_lost(&self, d: f64) -> f64 {
        let n = self.events.partition_point(|e| e.d_max <= d);
        let whole = if n == 0 { 0.0 } else { self.events[n - 1].up_to };
        match self.events.get(n) {
            Some(coarser) if d > self.fines.d_min => whole + self.fines.rise(d) * coarser.density_from,
            _ => whole,
        }
    }
}

/// Values at increasing sizes. A value smaller than the one before, which rounding may give, is replaced by that one.
fn rising(sizes: &[f64], passing: impl Fn(f64) -> f64) -> Vec<f64> {
    let mut last = (f64::NEG_INFINITY, 0.0_f64);
    sizes
        .iter()
        .map(|&d| {
            let mut value = passing(d);
            if d >= last.0 {
                value = value.max(last.1);
            }
            last = (d, value);
            value
        })
        .collect()
}

/// `count` sizes, m, evenly in the logarithm from `smallest` to `largest`, both exactly. One size, `largest`, where
/// there is no range.
pub fn sieve_sizes(smallest: f64, largest: f64, count: usize) -> Vec<f64> {
    if count < 2 || !(smallest > 0.0 && largest > smallest && largest.is_finite()) {
        return vec![largest];
    }
    let step = (largest / smallest).ln() / (count - 1) as f64;
    (0..count)
        .map(|i| match i {
            0 => smallest,
            _ if i + 1 == count => largest,
            _ => smallest * (step * i as f64).exp(),
        })
        .collect()
}

/// Numbers that sum up a gradation and its change since the start. Diameters in m, divided by N, with the lost mass.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Indices {
    /// Smallest size with at least 10 % of the mass finer or equal, m.
    pub d10: f64,
    /// The same for 30 %.
    pub d30: f64,
    /// The same for 50 %: the median size.
    pub d50: f64,
    /// The same for 60 %.
    pub d60: f64,
    /// Uniformity coefficient d60 / d10.
    pub cu: f64,
    /// Coefficient of curvature d30^2 / (d10 d60).
    pub cc: f64,
    /// Hardin's relative breakage B_r = B_t / B_p0 (Hardin 1985, J. Geotech. Engng 111, 1177-1192), -: area between the
    /// initial and the current curve over the area between the initial curve and the line at 0.074 mm, both over
    /// log10 d and above 0.074 mm only. `None` where no initial grain is larger than that: there is no potential.
    pub hardin_br: Option<f64>,
    /// Einav's relative breakage B (Einav 2007, J. Mech. Phys. Solids 55, 1274-1297), -: area between the initial and the
    /// current curve over the area between the initial curve and the ultimate one, both over ln d. The ultimate curve
    /// is eq. (12) with the run's alpha from its `d_min` to the largest initial grain; areas count from `d_min` up. Where the
    /// current curve is finer than the ultimate one, the ultimate one counts in its place, so B lies between 0 and 1.
    /// `None` where the initial curve is not coarser than the ultimate one.
    pub einav_br: Option<f64>,
    /// Area by which the current curve is finer than the ultimate one, over the same area as `einav_br`, -. In Einav's
    /// theory it is 0. Eq. (12) puts the lost mass of each breakage below its smallest daughter, so this mass is finer
    /// than that of the ultimate gradation, which begins at the largest grain: grains that break once into 14 balls
    /// already leave more fines than Einav's ultimate gradation has.
    pub einav_beyond: Option<f64>,
}

/// An error: the gradation is coarser than at the start. Breakage cannot do this, so mass was lost or added, and no index of breakage
/// is meaningful.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Coarser {
    /// Area over ln d by which the current curve is coarser than the initial one, -.
    pub by: f64,
}

impl std::fmt::Display for Coarser {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        let by = self.by;
        write!(
            f,
            "the reconstructed gradation is coarser than at the start, by an area of {by:.3e} over ln d: mass was lost or added"
        )
    }
}

/// Areas over ln d up to this size come from rounding.
const ROUNDING: f64 = 1e-9;

impl Indices {
    /// Indices of `current`, breakage counted from `initial`; `None` where one of them has no mass.
    ///
    /// # Errors
    /// A current gradation that is coarser than the initial one.
    pub fn between(initial: &Gradation, current: &Gradation) -> Result<Option<Self>, Coarser> {
        let at = [0.1, 0.3, 0.5, 0.6].map(|fraction| current.diameter_at(fraction));
        let ([Some(d10), Some(d30), Some(d50), Some(d60)], Some(largest)) = (at, initial.largest()) else { return Ok(None) };

        // The area between two curves is the difference of their mean logarithms; B_r is free of the base.
        let potential = initial.mean_log_above(HARDIN_SILT);
        let broken = finer(potential - current.mean_log_above(HARDIN_SILT))?;
        let hardin_br = (potential > 0.0).then(|| broken / potential);

        let fines = current.fines;
        let start = initial.mean_log_above(fines.d_min);
        let broken = finer(start - current.mean_log_above(fines.d_min))?;
        let [above, beyond] = areas_above([initial, current], largest);
        // the ultimate curve where it is finer than the initial one
        let possible = start - fines.mean_log_above(fines.d_min, largest) + above;
        let reachable = possible > 1e-12 * start;
        let einav_br = reachable.then(|| ((broken - beyond) / possible).clamp(0.0, 1.0));
        let einav_beyond = reachable.then_some(beyond / possible);
        let (cu, cc) = (d60 / d10, d30 * d30 / (d10 * d60));
        Ok(Some(Self { d10, d30, d50, d60, cu, cc, hardin_br, einav_br, einav_beyond }))
    }
}

/// An area of breakage, which rounding may have made negative; an error where it is negative beyond rounding.
fn finer(area: f64) -> Result<f64, Coarser> {
    if area < -ROUNDING { Err(Coarser { by: -area }) } else { Ok(area.max(0.0)) }
}

/// Areas over ln d, from `d_min` to the largest initial grain, by which the initial curve lies above the ultimate one, and
/// the current curve above both. Between two sizes at which a curve jumps or bends, all three are straight over eq. (12)'s
/// `rise`, so each piece between two crossings has a closed form.
fn areas_above([initial, current]: [&Gradation; 2], largest: f64) -> [f64; 2] {
    let fines = current.fines;
    if largest <= fines.d_min {
        return [0.0; 2];
    }
    let mut sizes: Vec<f64> = [initial, current]
        .iter()
        .flat_map(|g| g.grains.iter().map(|g| g.0).chain(g.events.iter().map(|e| e.d_max)))
        .filter(|&d| d > fines.d_min && d < largest)
        .chain([fines.d_min, largest])
        .collect();
    sizes.sort_unstable_by(f64::total_cmp);
    sizes.dedup();
    let mut sums = [Sum::default(), Sum::default()];
    let ultimate = (0.0, 1.0 / fines.rise(largest));
    let mut last = (sizes[0], fines.rise(sizes[0]));
    for &to in &sizes[1..] {
        let (from, rise) = last;
        let end = fines.rise(to);
        last = (to, end);
        let curves = [initial.piece(from), ultimate, current.piece(from)];
        let at = |curve: (f64, f64), rise: f64| curve.0 + curve.1 * rise;
        // all curves rise: below the start of the ultimate one nothing is above it
        if at(curves[0], end).max(at(curves[2], end)) <= at(ultimate, rise) {
            continue;
        }
        let mut cuts = vec![rise, end];
        for (a, b) in [(0, 1), (0, 2), (1, 2)] {
            let crossing = (curves[b].0 - curves[a].0) / (curves[a].1 - curves[b].1);
            if crossing > rise && crossing < end {
                cuts.push(crossing);
            }
        }
        cuts.sort_unstable_by(f64::total_cmp);
        for cut in cuts.windows(2) {
            let middle = 0.5 * (cut[0] + cut[1]);
            let [a, u, c] = curves.map(|curve| at(curve, middle));
            let area = |upper: (f64, f64), lower: (f64, f64)| fines.area((upper.0 - lower.0, upper.1 - lower.1), [cut[0], cut[1]]);
            if a > u {
                sums[0].add(area(curves[0], ultimate).max(0.0));
            }
            if c > a.max(u) {
                sums[1].add(area(curves[2], if a > u { curves[0] } else { ultimate }).max(0.0));
            }
        }
    }
    sums.map(|sum| sum.value())
}

/// A piece of a gradation in which mass is uniform in diameter.
struct Piece {
    from: f64,
    to: f64,
    /// Number of grains per unit of mass fraction: share * mean of d^-3 over the piece, 1/m^3.
    number: f64,
}

/// Pieces of the points (diameter, fraction finer); mass finer than the first point has the first diameter.
fn pieces(gradation: &[(f64, f64)]) -> Vec<Piece> {
    let first = gradation.first().map(|&(d, _)| (d, 0.0));
    let points = || first.iter().chain(gradation).copied();
    points()
        .zip(points().skip(1))
        .map(|((a, below), (b, above))| Piece { from: a, to: b, number: (above - below) * (a + b) / (2.0 * a * a * b * b) })
        .filter(|p| p.from > 0.0 && p.to >= p.from && p.number > 0.0 && p.number.is_finite())
        .collect()
}

/// Mean of d^3 over the grains, m^3, of the gradation through the points (diameter, m; mass fraction finer), mass uniform
/// in diameter between two of them. Uniform from a to b: 2 a^2 b^2 / (a + b). 0 where there is no grain.
pub fn mean_cubed_diameter(gradation: &[(f64, f64)]) -> f64 {
    let pieces = pieces(gradation);
    let number: f64 = pieces.iter().map(|p| p.number).sum();
    let mass = gradation.last().map_or(0.0, |p| p.1);
    if number > 0.0 { mass / number } else { 0.0 }
}

/// `n` diameters, m, of grains whose mass follows the points (diameter, m; fraction finer): the number of grains goes
/// with mass over d^3. One diameter is drawn in each n-th of the distribution of the number of grains, so that the total
/// volume hardly differs from one draw to another; the order is shuffled. Empty where the points hold no grain.
pub fn stratified_diameters(gradation: &[(f64, f64)], n: usize, rng: &mut impl Rng) -> Vec<f64> {
    let pieces = pieces(gradation);
    let number: f64 = pieces.iter().map(|p| p.number).sum();
    let Some(last) = pieces.last() else {
        return Vec::new();
    };

    let mut diameters = Vec::with_capacity(n);
    let mut at = 0;
    let mut before = 0.0;
    for k in 0..n {
        let u: f64 = rng.random();
        let wanted = (k as f64 + u) / n as f64 * number;
        while at + 1 < pieces.len() && wanted > before + pieces[at].number {
            before += pieces[at].number;
            at += 1;
        }
        let piece = pieces.get(at).unwrap_or(last);
        let share = ((wanted - before) / piece.number).clamp(0.0, 1.0);
        // Within a piece the number finer than d goes with 1/from^2 - 1/d^2.
        let (a, b) = (piece.from, piece.to);
        let d = a * b / (b * b - share * (b * b - a * a)).sqrt();
        diameters.push(d.clamp(a, b));
    }
    diameters.shuffle(rng);
    diameters
}

/// Sum with Neumaier's compensation.
#[derive(Clone, Copy, Debug, Default)]
struct Sum {
    sum: f64,
    rest: f64,
}

impl Sum {
    /// Adds and returns the sum so far.
    fn add(&mut self, value: f64) -> f64 {
        let sum = self.sum + value;
        self.rest += if self.sum.abs() >= value.abs() { (self.sum - sum) + value } else { (value - sum) + self.sum };
        self.sum = sum;
        self.value()
    }

    fn value(&self) -> f64 {
        self.sum + self.rest
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use engine::breakage::pattern::Pattern;
    use proptest::prelude::*;
    use rand_chacha::ChaCha8Rng;
    use rand_chacha::rand_core::SeedableRng;

    const FINES: Fines = Fines { alpha: 2.6, d_min: 0.1e-3 };

    fn grains_only(grains: &[(f64, f64)]) -> Gradation {
        Gradation::new(grains.iter().copied(), [], FINES, 1.0)
    }

    /// Fig. 2: of two grains of 1 mm one breaks into two of 0.5 mm.
    fn fig_2(scale: f64) -> (Gradation, Gradation) {
        let pattern = Pattern::new(2).unwrap();
        let (d, small, mass) = (1e-3 * scale, pattern.smallest() * 1e-3 * scale, 1.0);
        let fines = Fines { d_min: 0.1e-3 * scale, ..FINES };
        let lost = (1.0 - pattern.volume_kept()) * mass;
        let after = [(d, mass), (small, 0.125 * mass), (small, 0.125 * mass)];
        (Gradation::new([(d, mass), (d, mass)], [], fines, scale), Gradation::new(after, [(lost, small)], fines, scale))
    }

    #[test]
    fn gradation_of_fig_2() {
        for scale in [1.0, 2.0, 5.0] {
            let (initial, now) = fig_2(scale);
            assert_eq!(now.total_mass(), initial.total_mass());
            assert_eq!(1.0 - now.grain_mass() / now.total_mass(), 0.375);
            assert!((now.passing(0.2e-3) - 0.375 * 0.353573).abs() < 2e-7);
            assert_eq!(now.passing(0.1e-3), 0.0);
            assert_eq!(now.passing(0.50001e-3), 0.5);
            assert_eq!(now.passing(0.999e-3), 0.5);
            assert_eq!(now.passing(1e-3), 1.0);
            assert_eq!(now.passing_grains(0.50001e-3), 0.2);
            assert_eq!(initial.passing(0.999e-3), 0.0);
        }
    }

    #[test]
    fn diameters_are_where_the_curve_says() {
        let grains: Vec<_> = (1..=100).map(|i| (f64::from(i) * 1e-4, 2.0)).collect();
        let gradation = grains_only(&grains);
        for (fraction, d) in [(0.1, 1e-3), (0.095, 1e-3), (0.6, 6e-3), (1.0, 1e-2), (0.0, 1e-4)] {
            let found = gradation.diameter_at(fraction).unwrap();
            assert!((found / d - 1.0).abs() < 1e-12, "{fraction}: {found}");
        }
        let indices = Indices::between(&gradation, &gradation).unwrap().unwrap();
        assert!((indices.cu - 6.0).abs() < 1e-11);
        assert!((indices.cc - 1.5).abs() < 1e-11);
        // Eq. (12) inverted.
        let lost = Gradation::new([], [(3.0, 0.5e-3)], FINES, 1.0);
        assert!((lost.diameter_at(0.353573).unwrap() / 0.2e-3 - 1.0).abs() < 1e-5);
    }

    #[test]
    fn a_grain_passes_a_sieve_of_its_size() {
        let gradation = grains_only(&[(2e-3, 1.0), (1e-3, 1.0), (3e-3, 2.0)]);
        assert_eq!(gradation.curve(&[0.9e-3, 1e-3, 2e-3, 3e-3]), [0.0, 0.25, 0.5, 1.0]);
    }

    #[test]
    fn sums_lose_nothing() {
        let mut sum = Sum::default();
        for _ in 0..1_000_000 {
            sum.add(0.1);
        }
        assert_eq!(sum.value(), 100_000.0);
    }

    #[test]
    fn breakage_is_zero_at_the_start_and_one_at_the_end() {
        let (initial, now) = fig_2(1.0);
        let start = Indices::between(&initial, &initial).unwrap().unwrap();
        assert_eq!((start.hardin_br, start.einav_br), (Some(0.0), Some(0.0)));
        let later = Indices::between(&initial, &now).unwrap().unwrap();
        assert!(later.hardin_br.unwrap() > 0.1 && later.einav_br.unwrap() > 0.1);
        // Everything in the ultimate distribution, and everything silt.
        let ultimate = Gradation::new([], [(2.0, 1e-3)], FINES, 1.0);
        let end = Indices::between(&initial, &ultimate).unwrap().unwrap().einav_br;
        assert!((end.unwrap() - 1.0).abs() < 1e-12);
        let silt = grains_only(&[(0.07e-3, 2.0)]);
        assert_eq!(Indices::between(&initial, &silt).unwrap().unwrap().hardin_br, Some(1.0));
    }

    #[test]
    fn hardin_counts_decades_above_silt() {
        // Two decades of potential, one of them spent.
        let (initial, now) = (grains_only(&[(7.4e-3, 1.0)]), grains_only(&[(0.74e-3, 1.0)]));
        let br = Indices::between(&initial, &now).unwrap().unwrap().hardin_br.unwrap();
        assert!((br - 0.5).abs() < 1e-12);
    }

    #[test]
    fn indices_are_areas_between_the_curves() {
        let (initial, now) = fig_2(1.0);
        let area = |a: &dyn Fn(f64) -> f64, b: &dyn Fn(f64) -> f64, from: f64| {
            let steps = 400_000;
            let step = (1e-3_f64 / from).log10() / f64::from(steps);
            (0..steps).map(|i| from * 10.0_f64.powf((f64::from(i) + 0.5) * step)).map(|d| step * (a(d) - b(d))).sum::<f64>()
        };
        let indices = Indices::between(&initial, &now).unwrap().unwrap();
        let (f0, f) = (|d| initial.passing(d), |d| now.passing(d));
        let hardin = area(&f, &f0, HARDIN_SILT) / area(&|_| 1.0, &f0, HARDIN_SILT);
        assert!((indices.hardin_br.unwrap() - hardin).abs() < 1e-5);
        let ultimate = |d| FINES.finer(d, 1e-3);
        let einav = area(&f, &f0, FINES.d_min) / area(&ultimate, &f0, FINES.d_min);
        assert!((indices.einav_br.unwrap() - einav).abs() < 1e-5);
    }

    /// Every grain breaks once into 14: by eq. (12) that is finer at small sizes than one fractal from the largest grain.
    #[test]
    fn what_is_finer_than_the_ultimate_gradation_stands_apart() {
        let pattern = Pattern::new(14).unwrap();
        let (d, fines) = (10e-3, FINES);
        let daughters = pattern.balls().iter().map(|b| (b.radius * d, b.radius.powi(3)));
        let lost = (1.0 - pattern.volume_kept(), pattern.smallest() * d);
        let (initial, now) = (grains_only(&[(d, 1.0)]), Gradation::new(daughters, [lost], fines, 1.0));
        let indices = Indices::between(&initial, &now).unwrap().unwrap();
        let area = |f: &dyn Fn(f64) -> f64| {
            let steps = 400_000;
            let step = (d / fines.d_min).ln() / f64::from(steps);
            (0..steps).map(|i| f(fines.d_min * ((f64::from(i) + 0.5) * step).exp()) * step).sum::<f64>()
        };
        let ultimate = |x: f64| fines.finer(x, d);
        let possible = area(&|x| ultimate(x) - initial.passing(x));
        let within = area(&|x| ultimate(x).min(now.passing(x)) - initial.passing(x)) / possible;
        let beyond = area(&|x| (now.passing(x) - ultimate(x)).max(0.0)) / possible;
        assert!((indices.einav_br.unwrap() - within).abs() < 1e-5, "{indices:?} {within}");
        assert!((indices.einav_beyond.unwrap() - beyond).abs() < 1e-5, "{indices:?} {beyond}");
        assert!(within < 1.0 && within + beyond > 1.0, "the whole area is above one: {within} {beyond}");
    }

    #[test]
    fn a_coarser_gradation_is_an_error() {
        let (initial, later) = (grains_only(&[(1e-3, 1.0), (2e-3, 1.0)]), grains_only(&[(2e-3, 1.0)]));
        let error = Indices::between(&initial, &later).unwrap_err().to_string();
        assert!(error.contains("coarser than at the start, by an area of 3.466e-1"), "{error}");
    }

    #[test]
    fn breakage_without_potential_is_none() {
        let silt = grains_only(&[(0.05e-3, 1.0)]);
        let indices = Indices::between(&silt, &silt).unwrap().unwrap();
        assert_eq!((indices.hardin_br, indices.einav_br), (None, None));
        assert_eq!(indices.cu, 1.0);
        let empty = grains_only(&[]);
        assert!(Indices::between(&empty, &empty).unwrap().is_none());
        assert_eq!(empty.passing(1.0), 0.0);
        assert_eq!(empty.curve(&[1e-3, 1.0]), [0.0, 0.0]);
        // What is no grain counts for nothing.
        let odd = grains_only(&[(f64::NAN, 1.0), (1e-3, f64::INFINITY), (-1.0, 1.0), (1e-3, 3.0)]);
        assert_eq!(odd.total_mass(), 3.0);
    }

    #[test]
    fn sieves_span_the_range_evenly() {
        let sizes = sieve_sizes(1e-4, 1e-2, 5);
        for (found, expected) in sizes.iter().zip([1e-4, 3.16228e-4, 1e-3, 3.16228e-3, 1e-2]) {
            assert!((found / expected - 1.0).abs() < 1e-5);
        }
        assert_eq!((sizes[0], sizes[4]), (1e-4, 1e-2));
        assert_eq!(sieve_sizes(1e-2, 1e-2, 9), [1e-2]);
        assert_eq!(sieve_sizes(0.0, 1e-2, 9), [1e-2]);
        assert_eq!(sieve_sizes(1e-3, 1e-2, 0), [1e-2]);
    }

    #[test]
    fn mean_cube_of_known_gradations() {
        let (a, b) = (5e-3_f64, 10e-3_f64);
        let uniform = mean_cubed_diameter(&[(a, 0.0), (b, 1.0)]);
        assert!((uniform / (2.0 * a * a * b * b / (a + b)) - 1.0).abs() < 1e-14);
        // The same in three pieces; one size; half the mass of each of two sizes.
        let cut = mean_cubed_diameter(&[(a, 0.0), (6e-3, 0.2), (9e-3, 0.8), (b, 1.0)]);
        assert!((cut / uniform - 1.0).abs() < 1e-14);
        assert!((mean_cubed_diameter(&[(a, 1.0)]) / a.powi(3) - 1.0).abs() < 1e-14);
        let two = mean_cubed_diameter(&[(a, 0.5), (b, 0.5), (b, 1.0)]);
        let expected = 1.0 / (0.5 / a.powi(3) + 0.5 / b.powi(3));
        assert!((two / expected - 1.0).abs() < 1e-14);
        for none in [&[][..], &[(0.0, 0.0), (1e-3, 1.0)], &[(f64::NAN, 1.0)]] {
            assert_eq!(mean_cubed_diameter(none), 0.0);
            assert!(stratified_diameters(none, 5, &mut ChaCha8Rng::from_seed([1; 32])).is_empty());
        }
    }

    #[test]
    fn drawn_diameters_have_the_mass_distribution_and_the_volume() {
        let points = [(4e-3, 0.0), (5e-3, 0.1), (8e-3, 0.7), (10e-3, 1.0)];
        let mut rng = ChaCha8Rng::from_seed([3; 32]);
        for (n, tolerance) in [(680, 2e-3), (5388, 2e-4)] {
            let diameters = stratified_diameters(&points, n, &mut rng);
            assert_eq!(diameters.len(), n);
            let volume: f64 = diameters.iter().map(|d| d * d * d).sum();
            let expected = n as f64 * mean_cubed_diameter(&points);
            assert!((volume / expected - 1.0).abs() < 1e-3, "{n}: {}", volume / expected - 1.0);
            let gradation = grains_only(&diameters.iter().map(|d| (*d, d * d * d)).collect::<Vec<_>>());
            for (d, fraction) in [(4.5e-3, 0.05), (5e-3, 0.1), (6.5e-3, 0.4), (9e-3, 0.85)] {
                let found = gradation.passing(d);
                assert!((found - fraction).abs() < 2.0 * tolerance, "{n} {d}: {found}");
            }
            // Shuffled: no trend of size with position.
            let half: f64 = diameters[..n / 2].iter().sum::<f64>() / (n / 2) as f64;
            let mean: f64 = diameters.iter().sum::<f64>() / n as f64;
            assert!((half / mean - 1.0).abs() < 0.05);
        }
    }

    fn sizes_and_masses(largest: usize) -> impl Strategy<Value = Vec<(f64, f64)>> {
        prop::collection::vec(((-5.0..-1.0_f64).prop_map(|x| 10.0_f64.powf(x)), 1e-9..1.0_f64), 0..largest)
    }

    proptest! {
        /// Any grains, broken in any order as often as one likes, some below the smallest size of fines.
        #[test]
        fn breakage_is_between_none_and_all(
            sizes in prop::collection::vec(0.15e-3..20e-3_f64, 1..20),
            broken in prop::collection::vec(0.0..1.0_f64, 0..200),
            balls in prop::sample::select(vec![2_u32, 14]),
            d_min in (-4.5..-2.5_f64).prop_map(|x| 10.0_f64.powf(x)),
            alpha in prop::sample::select(vec![1.0, 2.6, 3.0, 3.3]),
        ) {
            let (pattern, fines) = (Pattern::new(balls).unwrap(), Fines { alpha, d_min });
            let mut grains: Vec<(f64, f64)> = sizes.iter().map(|d| (*d, d.powi(3))).collect();
            let initial = Gradation::new(grains.iter().copied(), [], fines, 1.0);
            let (mut lost, mut last) = (Vec::new(), 0.0);
            for (k, which) in broken.iter().enumerate() {
                let (d, mass) = grains.swap_remove((which * grains.len() as f64) as usize);
                grains.extend(pattern.balls().iter().map(|b| (b.radius * d, b.radius.powi(3) * mass)));
                lost.push(((1.0 - pattern.volume_kept()) * mass, pattern.smallest() * d));
                if k % 7 == 0 || k + 1 == broken.len() {
                    let now = Gradation::new(grains.iter().copied(), lost.iter().copied(), fines, 1.0);
                    let indices = Indices::between(&initial, &now).unwrap().unwrap();
                    for br in [indices.hardin_br, indices.einav_br].into_iter().flatten() {
                        prop_assert!((0.0..=1.0).contains(&br), "{:?}", indices);
                    }
                    let beyond = indices.einav_beyond.unwrap_or(0.0);
                    let einav = indices.einav_br.unwrap_or(0.0);
                    prop_assert!(beyond >= 0.0 && einav >= last - 1e-9, "{} {:?}", last, indices);
                    last = einav;
                }
            }
        }

        #[test]
        fn curves_rise_from_nothing_to_all(
            grains in sizes_and_masses(60),
            lost in sizes_and_masses(60),
            d_min in (-5.5..-2.0_f64).prop_map(|x| 10.0_f64.powf(x)),
            alpha in 1.0..3.5_f64,
            scale in 1.0..10.0_f64,
        ) {
            let fines = Fines { alpha, d_min };
            let mass: f64 = grains.iter().chain(&lost).map(|g| g.1).sum();
            let lost: Vec<_> = lost.into_iter().map(|(d, m)| (m, d)).collect();
            let gradation = Gradation::new(grains.iter().copied(), lost.iter().copied(), fines, scale);
            prop_assert!((gradation.total_mass() - mass).abs() <= 1e-13 * mass);
            if let (Some(low), Some(high)) = (gradation.smallest(), gradation.largest()) {
                let sizes = sieve_sizes(0.9 * low, high, 120);
                for curve in [gradation.curve(&sizes), gradation.curve_grains(&sizes)] {
                    prop_assert_eq!(curve[0], 0.0);
                    prop_assert!(curve.windows(2).all(|w| w[0] <= w[1]));
                    prop_assert!(curve.iter().all(|v| (0.0..=1.0).contains(v)));
                }
                prop_assert_eq!(*gradation.curve(&sizes).last().unwrap(), 1.0);
                // The prefix sums give what adding up one by one gives.
                for &d in sizes.iter().step_by(7) {
                    let slow: f64 = grains.iter().filter(|g| g.0 / scale <= d).map(|g| g.1).sum::<f64>()
                        + lost.iter().map(|e| e.0 * Fines { alpha, d_min: d_min / scale }.finer(d, e.1 / scale)).sum::<f64>();
                    prop_assert!((gradation.passing(d) - slow / mass).abs() < 1e-11);
                }
                let indices = Indices::between(&gradation, &gradation).unwrap().unwrap();
                prop_assert!(indices.hardin_br.unwrap_or(0.0).abs() < 1e-12);
                prop_assert!(indices.d10 <= indices.d30 && indices.d50 <= indices.d60);
            }
        }
    }
}
