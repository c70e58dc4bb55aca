//! `comminute bench mpm`: the speed of the material point method on this machine.

use super::bench::{Blocks, some_threads};
use comminute::bench::{self, MpmSpeed};
use comminute::error::{Error, Result};
use comminute::machine::processor;
use comminute::mpm::Transfer;
use serde_json::{Value, json};

/// Measure the material point method
#[derive(Debug, clap::Args)]
#[command(after_help = "The case: a cube of points, eight per cell, f64, elastic, quadratic B-splines, MUSL, on smooth walls.\n\n\
        Example:\n  comminute bench mpm --points 64000 --threads 1,2")]
pub struct Args {
    /// Least number of material points; they fill a cube
    #[arg(long, value_name = "N,N", value_delimiter = ',', default_values_t = [64_000], value_parser = clap::value_parser!(u32).range(8..=50_000_000))]
    points: Vec<u32>,

    /// Affine particle-in-cell instead of FLIP
    #[arg(long)]
    affine: bool,

    /// Measure the graphics device, too
    #[cfg(feature = "gpu")]
    #[arg(long, conflicts_with = "affine")]
    gpu: bool,

    #[command(flatten)]
    blocks: Blocks,
}

pub fn call(args: &Args) -> Result<()> {
    let threads = some_threads(&args.blocks.threads);
    let transfer = if args.affine { Transfer::Affine } else { Transfer::Blend { pic: 0.0 } };
    let simd = comminute::math::real::name(comminute::math::real::arch());
    if !args.blocks.quiet {
        eprintln!("{}, {simd}; load {}", processor(), bench::load_average().map_or("unknown".into(), |l| format!("{l:.2}")));
        eprintln!("{:>9} {:>3}  {:>16} {:>13} {:>8} {:>7}", "points", "thr", "M point-steps/s", "min - max", "/cpu-s", "B/point");
    }
    let mut rows: Vec<MpmSpeed> = Vec::new();
    for &points in &args.points {
        for &threads in &threads {
            let row = bench::mpm_speed(
                points as usize,
                transfer,
                threads,
                [args.blocks.warm_up, args.blocks.steps],
                args.blocks.repeats.into(),
            )?;
            if !args.blocks.quiet {
                line(&row);
            }
            rows.push(row);
        }
    }
    let device = device(args)?;
    if args.blocks.json {
        let json = json!({ "gpu": device, "processor": processor(), "simd": simd, "affine": args.affine, "warm_up": args.blocks.warm_up,
            "steps": args.blocks.steps, "rows": rows.iter().map(as_json).collect::<Vec<_>>() });
        super::print(&format!("{json:#}"))?;
    }
    same_bits(&rows)
}

/// The same case on the graphics device, as JSON; null where it is not asked for.
#[cfg(feature = "gpu")]
fn device(args: &Args) -> Result<Value> {
    if !args.gpu {
        return Ok(Value::Null);
    }
    let mut rows = Vec::new();
    for &points in &args.points {
        let row = bench::mpm_gpu_speed(points as usize, [args.blocks.warm_up, args.blocks.steps], args.blocks.repeats.into())?;
        if !args.blocks.quiet {
            let (speed, bytes) = (1e-6 * row.median(), row.bytes_per_point);
            eprintln!("{:>9} gpu  {speed:>16.2} {:>13} {:>8} {bytes:>7.0}  {}", row.points, "", "", row.adapter);
            let seconds = row.points as f64 / row.median();
            let [mb, mflop] = [row.step.bytes, row.step.flops].map(|n| 1e-6 * n as f64);
            eprintln!(
                "          a step: {:.2} ms, {} dispatches, {mb:.1} MB moved ({:.2} GB/s), {mflop:.1} Mflop ({:.2} Gflop/s)",
                1e3 * seconds,
                row.step.dispatches,
                1e-3 * mb / seconds,
                1e-3 * mflop / seconds
            );
        }
        rows.push(json!({ "adapter": row.adapter, "points": row.points, "point_steps_per_second": row.median(),
            "blocks": row.blocks, "bytes_per_point": row.bytes_per_point, "step": row.step }));
    }
    Ok(rows.into())
}

#[cfg(not(feature = "gpu"))]
fn device(_: &Args) -> Result<Value> {
    Ok(Value::Null)
}

fn line(row: &MpmSpeed) {
    let least = row.blocks.iter().copied().fold(f64::INFINITY, f64::min);
    let most = row.blocks.iter().copied().fold(0.0, f64::max);
    eprintln!(
        "{:>9} {:>3}  {:>16.2} {:>13} {:>8} {:>7.0}",
        row.points,
        row.threads,
        1e-6 * row.median(),
        format!("{:.2} - {:.2}", 1e-6 * least, 1e-6 * most),
        row.cpu_median().map_or("-".into(), |x| format!("{:.2}", 1e-6 * x)),
        row.bytes_per_point
    );
}

fn as_json(row: &MpmSpeed) -> Value {
    json!({
        "points": row.points,
        "threads": row.threads,
        "point_steps_per_second": row.median(),
        "blocks": row.blocks,
        "point_steps_per_cpu_second": row.cpu_median(),
        "cpu_blocks": row.cpu_blocks,
        "bytes_per_point": row.bytes_per_point,
        "hash": format!("{:016x}", row.hash),
        "load_average": row.load,
    })
}

/// Refuses results that depend on the number of threads: the hashes of the states at the end must
/// be equal.
fn same_bits(rows: &[MpmSpeed]) -> Result<()> {
    for row in rows {
        if let Some(first) = rows.iter().find(|r| r.points == row.points)
            && first.hash != row.hash
        {
            let what = format!(
                "{} points: the final state with {} threads differs from that with {}",
                row.points, row.threads, first.threads
            );
            return Err(Error::Failed { step: 0, what });
        }
    }
    Ok(())
}
