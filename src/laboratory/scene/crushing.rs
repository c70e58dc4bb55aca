//! Makes [`CrushModel`] and [`Fines`] from the keys of crushing, strength, comminution and fines.

use super::material::Named;
use super::view::View;
use crate::model::{GrainSpec, Rig, Subject};
use engine::breakage::criterion::limit_strength::limit_strength;
use engine::breakage::criterion::size_factor;
use engine::breakage::criterion::{HertzArea, Judges};
use engine::breakage::crushing_stress::Quoted;
use engine::breakage::lost_mass::Fines;
use engine::breakage::pattern::{Azimuth, Pattern};
use engine::breakage::strength::{Distribution, StrengthModel, Truncation, weibull_variation};
use engine::breakage::{Birth, Criterion, CrushModel};
use engine::rigid::Block;
use toml::{Table, Value};

/// Most pieces into which a rigid body breaks.
const MOST_PIECES: usize = 100;

/// Fills in the defaults that depend on the kind of scene, on whether grains break, or on another key: `contact.unloading`,
/// `crushing.criterion` and `crushing.birth`.
pub fn fill(scene: &mut Table) {
    let kind = scene.get("kind").and_then(Value::as_str).unwrap_or("").to_string();
    let breaks = scene.get("crushing").and_then(|c| c.get("enabled")).and_then(Value::as_bool) == Some(true);
    let named = ["criterion", "area"].iter().any(|key| scene.get("crushing").is_some_and(|c| c.get(*key).is_some()));
    let mut fill = |table: &str, key: &str, value: &str| {
        if let Some(Value::Table(table)) = scene.get_mut(table) {
            table.entry(key).or_insert(Value::String(value.into()));
        }
    };
    if !matches!(kind.as_str(), "platen" | "continuum") {
        // a breakage unloads the contacts around it; a tangential force kept while its normal force falls creates energy
        fill("contact", "unloading", if breaks { "rescale" } else { "keep" });
    }
    if !named {
        fill("crushing", "criterion", "fixed_angle");
    }
    if breaks && kind != "platen" {
        // gradual birth has not been tried in a mixture
        fill("crushing", "birth", if kind == "mixture" { "overlapping" } else { "gradual" });
    }
}

impl View<'_> {
    /// How grains break (`None`: they do not), and how lost mass is spread over sizes. `named`: the materials of the scene, in the
    /// order of their numbers. `None` where the scene is refused, with the reason noted, or where it can have no grains.
    pub fn crushing(&self, named: &[Named], rig: &Rig) -> Option<(Option<CrushModel>, Fines)> {
        let (smallest, largest) = extremes(rig);
        let of = &named[self.grain_material(rig)?];
        let fines = self.fines(of, smallest);
        if !self.flag("crushing.enabled") {
            return Some((None, fines));
        }
        let pattern = self.pattern();
        // a test ends where its grain breaks, and rigid bodies lose no mass, so sizes of daughters and of lost mass are not needed
        let test = matches!(rig, Rig::GrainCrushing(_));
        let single = test || self.has_blocks();
        let d_limit = if test && !self.has(&of.key("comminution")) { Some(0.0) } else { self.d_limit(of) };
        let strength = self.strength(of);
        let (pattern, d_limit, (criterion, strength)) = (pattern?, d_limit?, strength?);
        if !single && !self.has(&of.key("fines")) {
            let message = "is missing: lost mass needs d_min_mm, the smallest sieve after crushing (eq. 12)";
            self.refuse(&of.key("fines"), message);
            return None;
        }
        let finest = pattern.smallest() * d_limit;
        self.check(
            single || fines.d_min < finest,
            &of.key("fines.d_min_mm"),
            format!(
                "must be < {:.4}, below every possible daughter ({:.4} of the comminution limit; eq. 12)",
                1e3 * finest / self.scale(),
                pattern.smallest()
            ),
        );
        let weakest = if test { smallest } else { d_limit };
        let firm = [weakest, largest.max(weakest)].iter().all(|d| {
            let s = strength.sigma_lim0 * size_factor(*d, strength.d0, strength.m);
            s.is_finite() && s > 0.0 && s < 1e18
        });
        self.check(
            firm,
            &of.key(&format!("strength.{}.m", criterion.word())),
            "gives strengths without limit at the sizes of this scene (eq. 7)",
        );
        let birth = match self.text("crushing.birth") {
            "overlapping" => Birth::Overlapping,
            _ => Birth::Gradual { release: self.steps("crushing.release_steps"), growth: self.steps("crushing.growth_steps") },
        };
        let keeps_mass = self.text("crushing.lost_mass") == "grow";
        self.check(
            !keeps_mass || matches!(birth, Birth::Gradual { .. }),
            "crushing.lost_mass",
            "\"grow\" needs crushing.birth = \"gradual\": daughters that together have their mother's mass overlap each other deeply if they begin at full size",
        );
        let points = self.text("crushing.lost_mass") == "points";
        self.check(
            !points || matches!(rig, Rig::Continuum(_) | Rig::Oedometer(_)),
            "crushing.lost_mass",
            "can be \"points\" in an oedometer or a mixture only",
        );
        let interval = self.whole("crushing.interval").unwrap_or(1);
        let azimuth = if self.text("crushing.azimuth") == "fixed" { Azimuth::Fixed } else { Azimuth::Random };
        let seed = self.whole("seed.strength")?;
        let cells = self.cells()?;
        let crush = CrushModel { criterion, strength, seed, pattern, cells, azimuth, d_limit, birth, keeps_mass, interval };
        Some((Some(crush), fines))
    }

    /// The number of steps at a key; 1 where the key is absent.
    fn steps(&self, key: &str) -> u32 {
        self.whole(key).and_then(|n| u32::try_from(n).ok()).unwrap_or(1)
    }

    /// Seeds of the pieces of rigid bodies; `None`, with the reason noted, where they are none.
    fn cells(&self) -> Option<Vec<[f64; 3]>> {
        let (key, numbers) = ("crushing.block_pieces", self.numbers("crushing.block_pieces"));
        if !self.has(key) {
            return Some(Vec::new());
        }
        let of = if self.flag("grid.plane_strain") { 2 } else { 3 };
        let seeds: Vec<[f64; 3]> =
            numbers.chunks(of).map(|seed| std::array::from_fn(|a| seed.get(a).copied().unwrap_or(0.0))).collect();
        let whole = numbers.len().is_multiple_of(of) && (2..=MOST_PIECES).contains(&seeds.len());
        let words = if of == 2 { "x, y" } else { "x, y, z" };
        self.check(whole, key, format!("must be {words} of 2 to {MOST_PIECES} seeds, but has {} numbers", numbers.len()));
        let twice = seeds.iter().enumerate().find(|(k, seed)| seeds[..*k].contains(seed));
        self.check(twice.is_none(), key, format!("has seed {} twice", twice.map_or(0, |(k, _)| k + 1)));
        self.check(self.has_blocks(), key, "is for [[block]] and [[block_set]]; grains break by crushing.pattern");
        (whole && twice.is_none()).then_some(seeds)
    }

    /// Number of the material of the grains: that of the first grain where they have several, 0 where there are none. `None` where
    /// there can be no grains, or, with the reason noted, where grains of several materials would break.
    fn grain_material(&self, rig: &Rig) -> Option<usize> {
        let mut materials = grain_materials(rig)?.into_iter();
        let Some(first) = materials.next() else { return Some(0) };
        let mixed = materials.any(|m| m != first);
        if mixed && self.flag("crushing.enabled") {
            self.refuse(
                "crushing.enabled",
                "must be false where grains are of several materials: one strength law serves all grains",
            );
            return None;
        }
        Some(usize::from(first))
    }

    /// The splitting pattern; `None`, with the reason noted, where there is none with this number of daughters.
    fn pattern(&self) -> Option<Pattern> {
        let count = self.whole("crushing.pattern")?;
        Pattern::new(u32::try_from(count).ok()?).map_err(|message| self.refuse("crushing.pattern", message)).ok()
    }

    /// Comminution limit, m, multiplied by the scale N; `None`, with the reason noted, where keys are missing.
    fn d_limit(&self, of: &Named) -> Option<f64> {
        let table = of.key("comminution");
        if !self.has(&table) {
            let message = "is missing: crushing needs d_limit_over_d50 (and d50_mm where there is no gradation)";
            self.refuse(&table, message);
            return None;
        }
        let d50 = of.key("comminution.d50_mm");
        let Some(d50) = self.number(&d50) else {
            self.refuse(&d50, "is missing: without a gradation the d50 of the comminution limit must be given");
            return None;
        };
        let ratio = self.number("crushing.d_limit_over_d50").unwrap_or(self.si(&of.key("comminution.d_limit_over_d50")));
        Some(ratio * d50 * self.scale())
    }

    /// The word for the failure criterion of the grains: that of `crushing.criterion`, or the one that the older key
    /// `crushing.area` stands for.
    pub fn criterion(&self) -> &str {
        match (self.text("crushing.criterion"), self.text("crushing.area")) {
            // "hertz" is the older name, in `crushing.area`
            ("", "hertz") => "hertz_area",
            ("", _) => "fixed_angle",
            (word, _) => word,
        }
    }

    /// The failure criterion and the distribution of strengths of the material `of`; `None`, with the reason noted, where keys are
    /// missing or do not agree.
    fn strength(&self, of: &Named) -> Option<(Criterion, StrengthModel)> {
        self.check(
            self.text("crushing.criterion").is_empty() || self.text("crushing.area").is_empty(),
            "crushing.area",
            "is the older name of crushing.criterion: write one of them",
        );
        let word = self.criterion();
        let table = of.key(&format!("strength.{word}"));
        let why = format!("crushing.criterion = \"{word}\"");
        if !self.has(&table) {
            self.refuse(&table, format!("is missing: {why} needs it"));
            return None;
        }
        let asked = Criterion::WORDS.iter().position(|other| *other == word).map_or(&[][..], |k| Criterion::PARAMETERS[k]);
        let criterion = Criterion::named(word, &self.parameters(of, asked, &why))?;
        self.judges(criterion);
        let criterion = self.area_radius(criterion);
        let (distribution, var) = self.spread(of, &table)?;
        let shape = StrengthModel {
            sigma_lim0: f64::NAN,
            d0: self.si(&of.key("strength.d0_mm")) * self.scale(),
            m: self.si(&format!("{table}.m")),
            distribution,
            var,
            truncation: match self.text(&of.key("strength.truncation")) {
                "clamp" => Truncation::Clamp,
                "symmetric" => Truncation::Symmetric,
                "absolute" => Truncation::Absolute,
                _ => Truncation::Redraw,
            },
            min_ratio: self.si(&of.key("strength.min_ratio")),
        };
        let scaled = self.text(&of.key("strength.truncation")) == "mean_preserving";
        let shape = if scaled { shape.preserving_mean() } else { shape };
        let sigma_lim0 = self.sigma_lim0(of, &table, criterion, &shape)?;
        Some((criterion, StrengthModel { sigma_lim0, ..shape }))
    }

    /// Refuses criteria that judge the mean stress of a grain where the scene has material points: the mean stress is the sum over
    /// contacts with grains and walls only.
    fn judges(&self, criterion: Criterion) {
        let points = self.text("kind") == "mixture" && !self.is_without_points() || self.text("crushing.lost_mass") == "points";
        self.check(
            criterion.judges() == Judges::Contacts || !points,
            "crushing.criterion",
            "must be \"fixed_angle\" or \"hertz_area\" beside material points: what points bear on a grain is not in its mean stress",
        );
    }

    /// The criterion with the radius that `crushing.area_radius` says. Refuses a grain's own radius where the criterion has no Hertzian area.
    fn area_radius(&self, criterion: Criterion) -> Criterion {
        let own_radius = self.text("crushing.area_radius") == "own";
        match criterion {
            Criterion::HertzArea(_) => Criterion::HertzArea(HertzArea { own_radius }),
            _ => {
                self.check(
                    !own_radius,
                    "crushing.area_radius",
                    "can be \"own\" with crushing.criterion = \"hertz_area\" only: other criteria have no Hertzian area",
                );
                criterion
            }
        }
    }

    /// Distribution of strengths and its coefficient of variation, -; `None`, with the reason noted, where a normal distribution
    /// has no `var`. `table`: the table of the material's strengths for the criterion.
    fn spread(&self, of: &Named, table: &str) -> Option<(Distribution, f64)> {
        let key = format!("{table}.var");
        let var = self.number(&key);
        match (self.text(&of.key("strength.distribution")), var) {
            // Weibull's follows from `m`; a `var`, perhaps from a base file, is not used
            ("weibull", _) => Some((Distribution::Weibull, weibull_variation(self.si(&format!("{table}.m"))))),
            (_, Some(var)) => Some((Distribution::Normal, var)),
            (_, None) => {
                self.refuse(&key, "is missing: coefficient of variation of the limit strength");
                None
            }
        }
    }

    /// Mean limit strength at the reference diameter, Pa: as written, or from the crushing stress of single grains (eqs 16, 17), or
    /// from the uniaxial strengths of the grain's substance (eqs 2, 4, 6). `shape`: the distribution of strengths, whose own
    /// `sigma_lim0` is not used. `None`, with the reason noted, where not exactly one of the three is given, or where a value that
    /// belongs to it is missing or wrong.
    fn sigma_lim0(&self, of: &Named, table: &str, criterion: Criterion, shape: &StrengthModel) -> Option<f64> {
        let given = self.number(&format!("{table}.sigma_lim0_MPa"));
        let crushing = self.number(&format!("{table}.crushing_stress_MPa"));
        let compressive = self.number(&format!("{table}.sigma_c_MPa"));
        let tensile = self.number(&format!("{table}.sigma_t_MPa"));
        let quoted = format!("{table}.crushing_stress_is");
        if crushing.is_none() && self.has(&quoted) {
            self.refuse(&quoted, "belongs to crushing_stress_MPa, which is missing");
            return None;
        }
        match (given, crushing, compressive, tensile) {
            (Some(sigma), None, None, None) => Some(sigma),
            (None, Some(stress), None, None) => {
                let quoted = match self.text(&quoted) {
                    "mean" => Quoted::Mean,
                    "survival_37" => Quoted::Survival37,
                    _ => {
                        let message = "needs crushing_stress_is = \"mean\" or \"survival_37\" beside it: the mean F/d^2 of many grains, or what 37 % of them survive";
                        self.refuse(&format!("{table}.crushing_stress_MPa"), message);
                        return None;
                    }
                };
                let e_eff = match criterion.is_weighted() {
                    false => 1.0,
                    true => rigid_platens(self.elastic(of, true, "sigma_lim0 from crushing_stress_MPa (eq. 17)")?),
                };
                Some(shape.sigma_lim0_from(stress, criterion, e_eff, quoted))
            }
            (None, None, Some(c), Some(t)) => {
                let (_, nu) = self.elastic(of, true, "the limit strength from sigma_c and sigma_t")?;
                if c <= t {
                    let message = "must be larger than sigma_t_MPa (chi > 0, eq. 2)";
                    self.refuse(&format!("{table}.sigma_c_MPa"), message);
                    return None;
                }
                Some(limit_strength(c, t, nu))
            }
            _ => {
                let of_substance = if criterion.judges() == Judges::Contacts { ", or sigma_c_MPa with sigma_t_MPa" } else { "" };
                let message =
                    format!("must have sigma_lim0_MPa, or crushing_stress_MPa with crushing_stress_is{of_substance}, one of them");
                self.refuse(table, message);
                None
            }
        }
    }

    /// How the lost mass of the material `of` is spread over sizes. Where the material does not say, the smallest size is a
    /// hundredth of `smallest`, the diameter of the smallest grain, m; that is without effect, since no mass is lost then.
    fn fines(&self, of: &Named, smallest: f64) -> Fines {
        let d_min = self.number(&of.key("fines.d_min_mm"));
        Fines {
            alpha: self.number(&of.key("fines.alpha")).unwrap_or(2.6),
            d_min: d_min.map_or(0.01 * smallest, |d| d * self.scale()),
        }
    }
}

/// Effective modulus E', Pa, of the contact of a grain with a rigid platen (eq. 11), from the grain's Young's modulus, Pa, and
/// Poisson ratio, -.
pub fn rigid_platens((young, poisson): (f64, f64)) -> f64 {
    young / (1.0 - poisson * poisson)
}

/// Number of the material of every grain, or of every fraction of grains that are made later; repetitions are kept. `None` for a
/// continuum without grains.
pub fn grain_materials(rig: &Rig) -> Option<Vec<u8>> {
    let of = |grains: &[GrainSpec]| grains.iter().map(|g| g.material).collect();
    Some(match rig.subject() {
        Subject::Specimen(_) => vec![0],
        Subject::GrainCrushing(platen) => vec![platen.grain],
        Subject::Assembly(assembly) => of(&assembly.grains),
        Subject::Continuum(rig) => match &rig.growth {
            Some(growth) => {
                let all = growth.coarse.into_iter().chain((!growth.as_points).then_some(growth.fines));
                all.map(|fraction| fraction.material).collect()
            }
            None => {
                let coarse = rig.coarse.as_ref()?;
                of(&coarse.grains).into_iter().chain(loose(&coarse.blocks).map(|b| b.material)).collect()
            }
        },
    })
}

/// Smallest and largest diameter of the grains at the start of a run, m, and of rigid bodies those of the spheres of their volumes; infinity and 0 where there are none.
pub fn extremes(rig: &Rig) -> (f64, f64) {
    match rig.subject() {
        Subject::Specimen(specimen) => {
            let first = specimen.gradation.first().map_or(f64::NAN, |p| p.0);
            (first, specimen.gradation.last().map_or(f64::NAN, |p| p.0))
        }
        Subject::Assembly(a) => span(a.grains.iter().map(|g| 2.0 * g.radius)),
        Subject::GrainCrushing(p) => span(p.diameters.iter().copied()),
        Subject::Continuum(rig) => {
            let grown = rig.growth.iter().flat_map(|g| g.coarse.into_iter().chain((!g.as_points).then_some(g.fines)));
            let grown = grown.flat_map(|fraction| fraction.radii);
            let listed = rig.coarse.iter().flat_map(|c| &c.grains).map(|g| g.radius);
            let blocks = rig.coarse.iter().flat_map(|c| loose(&c.blocks)).map(|b| b.radius);
            span(listed.chain(blocks).chain(grown).map(|r| 2.0 * r))
        }
    }
}

/// The rigid bodies that are not driven: those that can break.
pub(super) fn loose(blocks: &[Block]) -> impl Iterator<Item = &Block> {
    blocks.iter().filter(|b| !b.driven)
}

/// Smallest and largest of the sizes; infinity and 0 where there are none.
fn span(sizes: impl Iterator<Item = f64>) -> (f64, f64) {
    sizes.fold((f64::INFINITY, 0.0), |(low, high), d| (low.min(d), high.max(d)))
}
