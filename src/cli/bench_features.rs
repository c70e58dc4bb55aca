//! `comminute bench features`: what each feature of grains costs on this machine.

use super::bench::Packings;
use comminute::bench::{self, Case, FeatureCost};
use comminute::error::Result;
use comminute::machine::processor;
use serde_json::{Value, json};

/// Measure what each feature of grains costs
#[derive(Debug, clap::Args)]
#[command(
    after_help = "Each feature is measured by itself beside the same packing without it, in blocks that take turns, on one thread: grains that turn, with\n\
        Hertz-Mindlin contacts, sliding friction and a fixed time step. What a scene leaves out takes no time and no memory.\n\n\
        Example:\n  comminute bench features --grains 5000"
)]
pub struct Args {
    /// Grains of the packing
    #[arg(long, value_name = "N", default_value_t = 5000, value_parser = clap::value_parser!(u32).range(500..=2_000_000))]
    grains: u32,

    /// Steps of one timed block
    #[arg(long, value_name = "N", default_value_t = 100, value_parser = clap::value_parser!(u64).range(1..))]
    steps: u64,

    /// Timed blocks of each; the median is reported
    #[arg(long, value_name = "N", default_value_t = 40, value_parser = clap::value_parser!(u16).range(1..))]
    repeats: u16,

    /// Steps before the first timed block
    #[arg(long, value_name = "N", default_value_t = 200)]
    warm_up: u64,

    #[command(flatten)]
    packings: Packings,
}

pub fn call(args: &Args) -> Result<()> {
    let packing = bench::packing(Case::Uniform, args.grains as usize, &args.packings.cache, |_| {})?;
    if !args.packings.quiet {
        eprintln!("{}; load {}", processor(), bench::load_average().map_or("unknown".into(), |l| format!("{l:.2}")));
        eprintln!("{:<48} {:>8} {:>17} {:>8} {:>9}", "with", "time", "quartiles", "B/grain", "touching");
    }
    let costs = bench::feature_costs(&packing, bench::SKIN, [args.warm_up, args.steps], args.repeats.into(), |cost| {
        if !args.packings.quiet {
            line(cost);
        }
    })?;
    if args.packings.json {
        let simd = comminute::math::real::name(comminute::math::real::arch());
        let rows: Vec<Value> = costs.iter().map(as_json).collect();
        super::print(&format!("{:#}", json!({ "processor": processor(), "simd": simd, "grains": args.grains, "rows": rows })))?;
    }
    Ok(())
}

fn line(cost: &FeatureCost) {
    let percent = |ratio: f64| format!("{:+.1} %", 100.0 * (ratio - 1.0));
    let [low, high] = cost.quartiles();
    eprintln!(
        "{:<48} {:>8} {:>17} {:>8.0} {:>9.2}",
        cost.feature,
        percent(cost.median()),
        format!("{} - {}", percent(low), percent(high)),
        cost.bytes_per_grain,
        cost.touching
    );
}

fn as_json(cost: &FeatureCost) -> Value {
    json!({ "feature": cost.feature, "time_over_plain": cost.median(), "blocks": cost.ratios, "bytes_per_grain": cost.bytes_per_grain,
        "touching_per_grain": cost.touching })
}
