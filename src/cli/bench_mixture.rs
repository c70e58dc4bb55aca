//! `comminute bench mixture`: the speed of a mixture on this machine.

use super::Overrides;
use super::bench::{Blocks, some_threads};
use comminute::bench::{self, MixtureSpeed};
use comminute::error::Result;
use comminute::machine::processor;
use comminute::scene;
use serde_json::{Value, json};
use std::path::PathBuf;

/// Measure a mixture of grains and points
#[derive(Debug, clap::Args)]
#[command(after_help = "Example, from the repository root: a mixture, its fines alone, and while it yields\n\
        \x20 comminute bench mixture experiments/mixture/triaxial_20_50kPa.toml --threads 1\n\
        \x20 comminute bench mixture experiments/mixture/triaxial_20_50kPa.toml --threads 1 --set coarse.mass_fraction=0\n\
        \x20 comminute bench mixture experiments/mixture/triaxial_20_50kPa.toml --set test.strain_per_wave=2e-3 --warm-up 4000\n\
        \x20 comminute bench mixture experiments/mixture/triaxial_20_50kPa.toml --gpu")]
pub struct Args {
    /// Scene of a mixture (TOML) whose grains need not be grown first
    scene: PathBuf,

    #[command(flatten)]
    overrides: Overrides,

    /// Measure the graphics device instead, and what each pass takes there
    #[cfg(feature = "gpu")]
    #[arg(long, conflicts_with = "threads")]
    gpu: bool,

    #[command(flatten)]
    blocks: Blocks,
}

pub fn call(args: &Args) -> Result<()> {
    let model = scene::model(&args.overrides.load(&args.scene)?)?;
    let blocks = &args.blocks;
    #[cfg(feature = "gpu")]
    if args.gpu {
        return device(&model, blocks);
    }
    if !blocks.quiet {
        eprintln!("{}; load {}", processor(), bench::load_average().map_or("unknown".into(), |l| format!("{l:.2}")));
        eprintln!("{:>9} {:>7} {:>9} {:>3}  {:>8} {:>13}", "points", "grains", "contacts", "thr", "ms/step", "min - max");
    }
    let mut rows = Vec::new();
    for threads in some_threads(&blocks.threads) {
        let row = bench::mixture_speed(&model, threads, [blocks.warm_up, blocks.steps], blocks.repeats.into())?;
        if !blocks.quiet {
            line(&row);
        }
        rows.push(row);
    }
    if blocks.json {
        let simd = comminute::math::real::name(comminute::math::real::arch());
        let rows: Vec<Value> = rows.iter().map(as_json).collect();
        super::print(&format!("{:#}", json!({ "processor": processor(), "simd": simd, "steps": blocks.steps, "rows": rows })))?;
    }
    Ok(())
}

/// The scene on the graphics device.
#[cfg(feature = "gpu")]
fn device(model: &comminute::model::Model, blocks: &Blocks) -> Result<()> {
    let row = bench::mixture_gpu_speed(model, [blocks.warm_up, blocks.steps], blocks.repeats.into())?;
    if !blocks.quiet {
        eprintln!("{}: {} points, {} grains, {:.3} ms a step", row.adapter, row.points, row.grains, row.median());
        let [copied, measured] = row.row();
        eprintln!("a row of the history: {copied:.1} ms to copy the state back, {measured:.1} ms to measure it");
        match &row.passes {
            Ok(passes) => {
                eprintln!("{:<22} {:>8}", "pass, by its clock", "ms/step");
                passes.iter().for_each(|(pass, ms)| eprintln!("{pass:<22} {ms:>8.4}"));
                eprintln!("{:<22} {:>8.4}", "sum", passes.iter().map(|(_, ms)| ms).sum::<f64>());
            }
            Err(why) => eprintln!("{why}"),
        }
    }
    if blocks.json {
        let passes = row.passes.as_ref().ok().map(|passes| passes.iter().copied().collect::<std::collections::BTreeMap<_, _>>());
        let row = json!({ "adapter": row.adapter, "points": row.points, "grains": row.grains, "ms_per_step": row.median(), "blocks": row.blocks,
            "row_ms": row.row(), "pass_ms_per_step": passes });
        super::print(&format!("{row:#}"))?;
    }
    Ok(())
}

fn line(row: &MixtureSpeed) {
    let least = row.blocks.iter().copied().fold(f64::INFINITY, f64::min);
    let most = row.blocks.iter().copied().fold(0.0, f64::max);
    eprintln!(
        "{:>9} {:>7} {:>9} {:>3}  {:>8.2} {:>13}",
        row.points,
        row.grains,
        row.contacts,
        row.threads,
        row.median(),
        format!("{least:.2} - {most:.2}")
    );
}

fn as_json(row: &MixtureSpeed) -> Value {
    json!({ "points": row.points, "grains": row.grains, "contacts": row.contacts, "threads": row.threads, "ms_per_step": row.median(),
        "blocks": row.blocks })
}
