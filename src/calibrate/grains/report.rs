//! Files that a calibration writes: `calibration.json`, `report.md`, the material file and the
//! figures.

use super::Calibration;
use super::area::Model;
use super::classes::{Class, size_effect};
use super::figures;
use super::fit::{Estimate, Intervals};
use super::fragment::{self, limits, significant};
use super::goodness::Goodness;
use laboratory::error::{Error, Result};
use serde_json::{Value, json};
use std::fmt::Write;
use std::fs;
use std::path::{Path, PathBuf};

/// File of the result.
pub const JSON: &str = "calibration.json";
/// File of the report.
pub const REPORT: &str = "report.md";

/// Makes the folder `out`. If it holds anything, it is refused without `force`; with `force` the
/// files of an older calibration are removed.
///
/// # Errors
/// [`Error::Exists`], or the folder cannot be made.
pub fn claim(out: &Path, force: bool) -> Result<()> {
    let occupied = out.read_dir().is_ok_and(|mut entries| entries.next().is_some());
    if occupied && !force {
        return Err(Error::Exists { path: out.into() });
    }
    let figures = figures::NAMES.iter().flat_map(|n| ["svg", "png", "csv"].map(|e| format!("{n}.{e}")));
    for name in [JSON, REPORT, fragment::FILE].map(String::from).into_iter().chain(figures) {
        let path = out.join(name);
        if path.is_file() {
            fs::remove_file(&path).map_err(Error::write(&path))?;
        }
    }
    fs::create_dir_all(out).map_err(Error::write(out))
}

/// Writes everything into `out` and returns the files.
pub fn write(c: &Calibration, out: &Path) -> Result<Vec<PathBuf>> {
    let mut files = Vec::new();
    let mut put = |name: &str, text: String| {
        let path = out.join(name);
        let done = fs::write(&path, text).map_err(Error::write(&path));
        files.push(path);
        done
    };
    put(JSON, format!("{:#}\n", json(c)))?;
    let material = fragment::fragment(c, out);
    put(REPORT, report(c, material.as_deref()))?;
    if let Some(text) = material {
        put(fragment::FILE, text)?;
    }
    files.extend(figures::draw(c, out)?);
    Ok(files)
}

/// The calibration as one object. Values that data or inputs do not determine are null.
pub fn json(c: &Calibration) -> Value {
    let inputs = &c.inputs;
    let young = |pair: (f64, f64)| json!({ "E_GPa": rounded(1e-9 * pair.0), "nu": pair.1 });
    let (low, high) = c.data.extent();
    let intervals = match c.settings.intervals {
        Intervals::Profile => json!({ "method": "profile likelihood", "level": 0.95 }),
        Intervals::Bootstrap { resamples, seed } => {
            json!({ "method": "bootstrap", "level": 0.95, "resamples": resamples, "seed": seed })
        }
    };
    let mut best = model(c, c.best);
    if let Value::Object(object) = &mut best {
        object.insert("why".into(), c.why.clone().into());
    }
    let (size_exponent, size_modulus) = size_effect(&c.classes).map_or((None, None), |(b, m)| (Some(b), m));
    json!({
        "data": {
            "file": c.data.path.display().to_string(),
            "grains": c.data.grains.len(),
            "broken": c.data.broken(),
            "censored": c.data.grains.len() - c.data.broken(),
            "smallest_mm": rounded(1e3 * low),
            "largest_mm": rounded(1e3 * high),
            "series": c.data.series.iter().filter(|s| !s.is_empty()).collect::<Vec<_>>(),
        },
        "inputs": {
            "d0_mm": rounded(1e3 * inputs.d0),
            "theta0_rad": inputs.theta0,
            "grain": inputs.grain.map(young),
            "platen": young(inputs.platen),
            "material": inputs.material.as_ref().map(|p| p.display().to_string()),
        },
        "intervals": intervals,
        "goodness_seed": c.settings.seed,
        "best": best,
        "models": (0..c.fits.len()).map(|i| model(c, i)).collect::<Vec<_>>(),
        "per_size": c.classes.iter().map(class).collect::<Vec<_>>(),
        "size_effect": { "exponent_of_sigma_37": size_exponent.map(rounded), "modulus": size_modulus.map(rounded) },
        "series_p_value": c.series_p_value,
        "notes": c.notes(),
    })
}

fn model(c: &Calibration, i: usize) -> Value {
    let fit = &c.fits[i];
    let goodness = c.goodness[i];
    let criteria = fit.criteria();
    let least = c.fits.iter().map(|f| f.criteria().aic).fold(f64::INFINITY, f64::min);
    let (mean_ratio, realised_var) = fit.law().realised();
    let mean = fit.sigma_lim0_mpa().estimate;
    let natural: serde_json::Map<String, Value> = match mean.filter(|_| !fit.at_limit()) {
        Some(mean) => fit.law().natural(mean).into_iter().map(|(k, v)| (k.to_string(), rounded(v).into())).collect(),
        None => serde_json::Map::new(),
    };
    let realised = mean.map(|m| json!({ "mean_MPa": rounded(m * mean_ratio), "coefficient_of_variation": rounded(realised_var) }));
    json!({
        "area_model": fit.area.model.name(),
        "spread": fit.spread.name(),
        "sigma_lim0_MPa": estimate(&fit.sigma_lim0_mpa()),
        "m": estimate(&fit.m()),
        "var": estimate(&fit.var()),
        "size_slope": estimate(&fit.slope()),
        "identified": {
            "name": fit.area.identified_name(),
            "unit": "MPa",
            "at": if fit.sample.sized { "d0" } else { "the size of the grains" },
            "value": estimate(&fit.identified_mpa()),
        },
        "strength_at_the_one_size_MPa": fit.sigma_at_size_mpa().map(|e| estimate(&e)),
        "drawn_by_scenes": fit.spread == super::spread::Spread::TruncatedNormal,
        "natural": natural,
        "realised_at_d0": realised,
        "parameters": fit.parameters(),
        "ln_likelihood": fit.ln_likelihood,
        "aic": criteria.aic,
        "aicc": criteria.aicc,
        "bic": criteria.bic,
        "delta_aic": criteria.aic - least,
        "goodness": { "anderson_darling": goodness.anderson_darling, "p_value": goodness.p_value, "samples": goodness.samples },
        "notes": fit.notes(),
    })
}

fn class(class: &Class) -> Value {
    json!({
        "diameter_mm": rounded(class.diameter_mm),
        "smallest_mm": rounded(class.smallest_mm),
        "largest_mm": rounded(class.largest_mm),
        "grains": class.grains,
        "censored": class.censored,
        "mean_force_N": class.mean_force_n.map(rounded),
        "sigma_37_MPa": estimate(&class.sigma_37_mpa),
        "weibull_modulus": estimate(&class.modulus),
        "weibull_modulus_of_line": class.modulus_line.map(rounded),
    })
}

fn estimate(e: &Estimate) -> Value {
    json!({ "estimate": e.estimate.map(rounded), "lower": e.lower.map(rounded), "upper": e.upper.map(rounded) })
}

/// Eight significant digits.
fn rounded(value: f64) -> f64 {
    format!("{value:.7e}").parse().unwrap_or(value)
}

/// Estimate and limits as text, `5017 (4780 to 5260)`; a missing estimate is `–`.
pub fn in_words(e: &Estimate) -> String {
    match e.estimate {
        Some(value) => format!("{} ({})", significant(value), limits(e)),
        None if e.lower.is_some() || e.upper.is_some() => format!("– ({})", limits(e)),
        None => "–".into(),
    }
}

fn report(c: &Calibration, material: Option<&str>) -> String {
    let mut t = String::new();
    // writing to a String does not fail
    let _ = body(&mut t, c, material);
    t
}

fn body(t: &mut String, c: &Calibration, material: Option<&str>) -> std::fmt::Result {
    let (best, data, inputs) = (c.best(), &c.data, &c.inputs);
    writeln!(t, "# Strength of grains from {}\n", data.path.display())?;
    let (low, high) = data.extent();
    writeln!(
        t,
        "{} grains of {} to {} mm, {} broken, {} not. Reference diameter d0 = {} mm.",
        data.grains.len(),
        significant(1e3 * low),
        significant(1e3 * high),
        data.broken(),
        data.grains.len() - data.broken(),
        significant(1e3 * inputs.d0)
    )?;
    match inputs.theta0 {
        Some(theta0) => writeln!(t, "Contact angle θ0 = {} rad (given).", significant(theta0))?,
        None => writeln!(t, "No contact angle was given.")?,
    }
    match inputs.grain {
        Some((young, nu)) => writeln!(
            t,
            "Grain E = {} GPa, ν = {}; platen E = {} GPa, ν = {} (given).",
            significant(1e-9 * young),
            significant(nu),
            significant(1e-9 * inputs.platen.0),
            significant(inputs.platen.1)
        )?,
        None => writeln!(t, "No moduli of the grain were given.")?,
    }
    let method = match c.settings.intervals {
        Intervals::Profile => "profile likelihood".to_string(),
        Intervals::Bootstrap { resamples, seed } => format!("bootstrap within sizes, {resamples} resamples, seed {seed}"),
    };
    writeln!(t, "\nIn brackets: 95 % limits by {method}.\n\n## Preferred\n")?;
    writeln!(t, "Area model **{}**, spread **{}** ({}).\n", best.area.model.name(), best.spread.name(), c.why)?;
    writeln!(t, "| σ_lim,0 (MPa) | m | var. | {} (MPa) |\n|---|---|---|---|", best.area.identified_name())?;
    let row = [best.sigma_lim0_mpa(), best.m(), best.var(), best.identified_mpa()].map(|e| in_words(&e));
    writeln!(t, "| {} |\n", row.join(" | "))?;
    writeln!(
        t,
        "Forces alone identify only the last column; σ_lim,0 is as good as the θ0, or the moduli, that were given. σ_lim,0 and var. of a \
         (truncated) normal are those of the normal before truncation, as in scenes; of log-normal and Weibull, the mean and the \
         coefficient of variation of the strengths at d0."
    )?;
    if let Some(p) = c.series_p_value {
        writeln!(t, "\nOne law for all {} series against a law for each: likelihood ratio, p = {p:.4}.", data.series.len())?;
    }
    let notes = c.notes();
    if !notes.is_empty() {
        writeln!(t, "\n## To be noted\n")?;
        for note in notes {
            writeln!(t, "- {note}")?;
        }
    }
    models(t, c)?;
    sizes(t, c)?;
    writeln!(t, "\n## Material\n")?;
    match material {
        Some(text) => writeln!(t, "`{}`:\n\n```toml\n{}```", fragment::FILE, text)?,
        None => writeln!(
            t,
            "None was written: a scene needs σ_lim,0, m and var., and not all of them could be estimated with the spread that scenes draw."
        )?,
    }
    writeln!(t, "\n## Figures\n")?;
    for name in figures::NAMES {
        writeln!(t, "![{}]({name}.svg)", name.replace('_', " "))?;
    }
    Ok(())
}

fn models(t: &mut String, c: &Calibration) -> std::fmt::Result {
    writeln!(t, "\n## All models\n")?;
    writeln!(
        t,
        "Likelihoods are those of the forces, so that area models can be compared. All have the same number of parameters: AIC and BIC rank them alike."
    )?;
    writeln!(t, "A²: Anderson and Darling's statistic; p: share of samples of the fitted law that lie further from it.\n")?;
    writeln!(
        t,
        "| area | spread | σ_lim,0 (MPa) | m | var. | ln L | AIC | BIC | ΔAIC | A² | p |\n|---|---|---|---|---|---|---|---|---|---|---|"
    )?;
    let least = c.fits.iter().map(|f| f.criteria().aic).fold(f64::INFINITY, f64::min);
    for (fit, Goodness { anderson_darling, p_value, .. }) in c.fits.iter().zip(&c.goodness) {
        let criteria = fit.criteria();
        let [sigma, m, var] = [fit.sigma_lim0_mpa(), fit.m(), fit.var()].map(|e| in_words(&e));
        writeln!(
            t,
            "| {} | {} | {sigma} | {m} | {var} | {:.2} | {:.2} | {:.2} | {:.2} | {anderson_darling:.3} | {} |",
            fit.area.model.name(),
            fit.spread.name(),
            fit.ln_likelihood,
            criteria.aic,
            criteria.bic,
            criteria.aic - least,
            p_value.map_or("–".into(), |p| format!("{p:.3}"))
        )?;
    }
    for (model, name) in [(Model::FixedAngle, "θ0"), (Model::Hertz, "E'")] {
        if c.fits.iter().any(|f| f.area.model == model && !f.area.known) {
            writeln!(t, "\nThe {} model has no σ_lim,0 because {name} was not given.", model.name())?;
        }
    }
    Ok(())
}

fn sizes(t: &mut String, c: &Calibration) -> std::fmt::Result {
    writeln!(t, "\n## Size by size\n")?;
    writeln!(t, "Stress F/d². Weibull's law by maximum likelihood; in the last column as read from the line of ln ln(1/P_s).\n")?;
    writeln!(
        t,
        "| d (mm) | grains | not broken | mean force (N) | σ 37 % (MPa) | modulus | of the line |\n|---|---|---|---|---|---|---|"
    )?;
    for k in &c.classes {
        let number = |v: Option<f64>| v.map_or("–".into(), significant);
        let d = if k.largest_mm / k.smallest_mm > 1.001 {
            format!("{} ({} to {})", significant(k.diameter_mm), significant(k.smallest_mm), significant(k.largest_mm))
        } else {
            significant(k.diameter_mm)
        };
        let (sigma, modulus) = (in_words(&k.sigma_37_mpa), in_words(&k.modulus));
        let (force, line) = (number(k.mean_force_n), number(k.modulus_line));
        writeln!(t, "| {d} | {} | {} | {force} | {sigma} | {modulus} | {line} |", k.grains, k.censored)?;
    }
    if let Some((exponent, modulus)) = size_effect(&c.classes) {
        let weibull = modulus
            .map_or("no modulus follows (larger grains are not weaker)".into(), |m| format!("a modulus of {}", significant(m)));
        writeln!(t, "\nThe 37 % stress goes with d to the power {}: {weibull} by −3/m.", significant(exponent))?;
    }
    Ok(())
}
