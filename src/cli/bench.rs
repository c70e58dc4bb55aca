//! `comminute bench`: the engine's speed on this machine.

use comminute::bench::{self, Burst, Case, Machine, Packing, Plan, Speed};
use comminute::contact::ContactLaw;
use comminute::error::{Error, Result};
use comminute::machine::processor;
use serde_json::{Value, json};
use std::io::IsTerminal;
use std::path::PathBuf;
use std::time::{Duration, Instant};

/// Measure the engine's speed on this machine
#[derive(Debug, clap::Args)]
#[command(
    after_help = "The case: an oedometer with r = 0.95-1.05 mm at porosity 0.40 and about 90 kPa, E 0.8 GPa, nu 0.12, mu 0.35, frictionless walls,\n\
        dt 1.4 us, top platen 5 mm/s. Packings are made once (50 000 grains: a few minutes) and kept in the cache folder.\n\n\
        Example:\n  comminute bench --grains 5000 --threads 1,2\n  comminute bench mpm --points 64000 --threads 1,2\n  comminute bench mixture experiments/mixture/triaxial_20_50kPa.toml",
    args_conflicts_with_subcommands = true
)]
pub struct Args {
    #[command(subcommand)]
    what: Option<What>,

    /// Packings: of about one size, or with a tenth of the mass in grains thirty times smaller
    #[arg(long = "case", value_name = "CASE,CASE", value_delimiter = ',', default_values_t = [Case::Uniform])]
    cases: Vec<Case>,

    /// Grains of each packing (wide: 100000 at least)
    #[arg(long, value_name = "N,N", value_delimiter = ',', default_values_t = [5000, 50_000], value_parser = clap::value_parser!(u32).range(500..=2_000_000))]
    grains: Vec<u32>,

    /// Numbers of threads; one, and all that this machine has, if not given
    #[arg(long, value_name = "N,N", value_delimiter = ',', value_parser = super::threads())]
    threads: Vec<u16>,

    /// Contact laws: Hertz-Mindlin, and the same with viscous damping (restitution 0.3) as the other codes are measured with
    #[arg(long, value_name = "LAW,LAW", value_delimiter = ',', default_values_t = [Law::Hertz, Law::HertzViscous])]
    law: Vec<Law>,

    /// Steps of one timed block
    #[arg(long, value_name = "N", default_value_t = 1000, value_parser = clap::value_parser!(u64).range(1..))]
    steps: u64,

    /// Timed blocks; the median is reported
    #[arg(long, value_name = "N", default_value_t = 3, value_parser = clap::value_parser!(u16).range(1..))]
    repeats: u16,

    /// Steps before the first timed block
    #[arg(long, value_name = "N", default_value_t = 500)]
    warm_up: u64,

    /// Neighbour skin over radius
    #[arg(long, value_name = "X", default_value_t = bench::SKIN, value_parser = skin)]
    skin: f64,

    /// Grains to break, one a step, after the timed blocks (0: none)
    #[arg(long, value_name = "N", default_value_t = 50, value_parser = clap::value_parser!(u16))]
    breakages: u16,

    #[command(flatten)]
    packings: Packings,
}

/// Options of the benches of grains: where packings are, and what is told.
#[derive(Debug, clap::Args)]
pub(super) struct Packings {
    /// Folder of the packings
    #[arg(long, value_name = "DIR", default_value = "runs/bench")]
    pub cache: PathBuf,

    /// No progress and no table
    #[arg(long)]
    pub quiet: bool,

    /// Print as JSON to standard output
    #[arg(long)]
    pub json: bool,
}

/// Benches other than that of grains.
#[derive(Debug, clap::Subcommand)]
enum What {
    /// Measure the material point method
    Mpm(super::bench_mpm::Args),
    /// Measure a mixture of grains and points
    Mixture(super::bench_mixture::Args),
    /// Measure what each feature of grains costs
    Features(super::bench_features::Args),
}

/// Options of the benches of points and of mixtures.
#[derive(Debug, clap::Args)]
pub(super) struct Blocks {
    /// Numbers of threads; one, and all that this machine has, if not given
    #[arg(long, value_name = "N,N", value_delimiter = ',', value_parser = super::threads())]
    pub threads: Vec<u16>,

    /// Steps of one timed block
    #[arg(long, value_name = "N", default_value_t = 50, value_parser = clap::value_parser!(u64).range(1..))]
    pub steps: u64,

    /// Timed blocks; the median is reported
    #[arg(long, value_name = "N", default_value_t = 5, value_parser = clap::value_parser!(u16).range(1..))]
    pub repeats: u16,

    /// Steps before the first timed block
    #[arg(long, value_name = "N", default_value_t = 30)]
    pub warm_up: u64,

    /// No table
    #[arg(long)]
    pub quiet: bool,

    /// Print as JSON to standard output
    #[arg(long)]
    pub json: bool,
}

#[derive(Clone, Copy, Debug, PartialEq, Eq, clap::ValueEnum)]
#[value(rename_all = "snake_case")]
enum Law {
    Hertz,
    HertzViscous,
}

impl Law {
    fn name(self) -> &'static str {
        match self {
            Law::Hertz => "hertz",
            Law::HertzViscous => "hertz_viscous",
        }
    }
}

impl std::fmt::Display for Law {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        f.write_str(self.name())
    }
}

impl From<Law> for ContactLaw {
    fn from(law: Law) -> ContactLaw {
        match law {
            Law::Hertz => ContactLaw::Hertz,
            Law::HertzViscous => ContactLaw::HertzViscous,
        }
    }
}

fn skin(text: &str) -> std::result::Result<f64, String> {
    let x: f64 = text.parse().map_err(|_| "must be a number".to_string())?;
    if x > 0.0 && x <= 2.0 { Ok(x) } else { Err("must be above 0 and at most 2".into()) }
}

/// One line of the table.
struct Row {
    case: Case,
    grains: usize,
    threads: usize,
    law: Law,
    speed: Speed,
    burst: Option<Burst>,
}

pub fn call(args: &Args) -> Result<()> {
    match &args.what {
        Some(What::Mpm(args)) => return super::bench_mpm::call(args),
        Some(What::Mixture(args)) => return super::bench_mixture::call(args),
        Some(What::Features(args)) => return super::bench_features::call(args),
        None => {}
    }
    let threads: Vec<usize> = some_threads(&args.threads);
    let plan = Plan { warm_up: args.warm_up, steps: args.steps, repeats: args.repeats.into(), clocked: args.steps.min(500) };
    for &case in &args.cases {
        if let Some(few) = args.grains.iter().find(|&&n| (n as usize) < case.least()) {
            let message = format!("must be at least {} for the {case} packing", case.least());
            return Err(Error::input("bench", "--grains", Some(few.to_string()), message));
        }
    }
    let mut told = Told::new(args.packings.quiet);
    let machines: Vec<Machine> = threads.iter().map(|&n| Ok(bench::pool(n)?.install(Machine::measure))).collect::<Result<_>>()?;
    let mut packings = Vec::new();
    for &case in &args.cases {
        for &grains in &args.grains {
            let packing = bench::packing(case, grains as usize, &args.packings.cache, |text| told.now_and_then(text))?;
            packings.push(packing);
            told.clear();
        }
    }
    if !args.packings.quiet {
        head(&machines, &packings);
    }
    let mut rows: Vec<Row> = Vec::new();
    for packing in &packings {
        for &law in &args.law {
            for machine in &machines {
                let row = measured(args, packing, law, machine, &plan)?;
                if !args.packings.quiet {
                    line(&row);
                }
                rows.push(row);
            }
        }
    }
    if !args.packings.quiet {
        foot(&rows);
    }
    if args.packings.json {
        super::print(&format!("{:#}", as_json(args, &machines, &packings, &rows)))?;
    }
    same_bits(&rows)
}

fn measured(args: &Args, packing: &Packing, law: Law, machine: &Machine, plan: &Plan) -> Result<Row> {
    let (case, grains) = (packing.case, packing.grains.len());
    let model = bench::model(case, grains, law.into(), args.skin);
    let (speed, state) = bench::measure(&model, packing, machine, plan)?;
    let burst = match usize::from(args.breakages) {
        0 => None,
        // in rayon's default pool and not in that of `machine`: a breakage itself is not computed
        // in parallel
        n => Some(bench::burst(&model, state, n.min(grains / 100))?),
    };
    Ok(Row { case, grains, threads: machine.threads, law, speed, burst })
}

/// Numbers of threads to measure with: those asked for, else one and all of the machine.
pub(super) fn some_threads(asked: &[u16]) -> Vec<usize> {
    if !asked.is_empty() {
        return asked.iter().map(|&n| n.into()).collect();
    }
    match std::thread::available_parallelism().map_or(1, usize::from) {
        1 => vec![1],
        n => vec![1, n],
    }
}

/// Refuses results that depend on the number of threads: the hashes of the states at the end must
/// be equal.
fn same_bits(rows: &[Row]) -> Result<()> {
    for row in rows {
        let first = rows.iter().find(|r| (r.case, r.grains, r.law) == (row.case, row.grains, row.law));
        if let Some(first) = first
            && first.speed.hash != row.speed.hash
        {
            let what = format!(
                "{} grains, {}: the final state with {} threads differs from that with {}",
                row.grains, row.law, row.threads, first.threads
            );
            return Err(Error::Failed { step: row.speed.steps, what });
        }
    }
    Ok(())
}

fn head(machines: &[Machine], packings: &[Packing]) {
    let simd = comminute::math::real::name(comminute::math::real::arch());
    eprintln!("{}, {simd}; load {}", processor(), bench::load_average().map_or("unknown".into(), |l| format!("{l:.2}")));
    for m in machines {
        eprintln!("{} threads: memory {:.1} GB/s, {:.1} Gflop/s (f64, not fused)", m.threads, 1e-9 * m.bandwidth, 1e-9 * m.flops);
    }
    for p in packings {
        let made = p.seconds.map_or(String::new(), |s| format!(", made in {s:.0} s"));
        eprintln!("{}, {} grains: porosity {:.4}{made}, {}", p.case, p.grains.len(), p.porosity(), p.path.display());
    }
    eprintln!(
        "\n{:>7} {:>7} {:>3} {:>13}  {:>16} {:>13} {:>8} {:>7}  {:>13}  {:>22} {:>15}  {:>8} {:>9} {:>9} {:>9}",
        "case",
        "grains",
        "thr",
        "law",
        "M grain-steps/s",
        "min - max",
        "/cpu-s",
        "B/grain",
        "pairs/grain",
        "ns: list/contact/grain",
        "% flops, memory",
        "searches",
        "kPa (vol)",
        "us/break",
        "ns trip"
    );
}

fn line(row: &Row) {
    let s = &row.speed;
    let least = s.blocks.iter().copied().fold(f64::INFINITY, f64::min);
    let most = s.blocks.iter().copied().fold(0.0, f64::max);
    let [contacts, grains] = s.roofline.map(|r| r.map(|x| 100.0 * x));
    eprintln!(
        "{:>7} {:>7} {:>3} {:>13}  {:>16.2} {:>13} {:>8} {:>7.0}  {:>13}  {:>22} {:>15}  {:>8} {:>9.3} {:>9} {:>9}",
        row.case,
        row.grains,
        row.threads,
        row.law.name(),
        1e-6 * s.median(),
        format!("{:.2} - {:.2}", 1e-6 * least, 1e-6 * most),
        s.cpu_median().map_or("-".into(), |x| format!("{:.2}", 1e-6 * x)),
        s.bytes_per_grain,
        format!("{:.2} / {:.2}", s.touching, s.near),
        format!("{:.1} / {:.1} / {:.1}", s.stages[0], s.stages[1], s.stages[2]),
        format!("{:.0},{:.0} / {:.0},{:.0}", contacts[0], contacts[1], grains[0], grains[1]),
        s.searches,
        1e-3 * s.stress_volume,
        row.burst.as_ref().map_or("-".into(), |b| format!("{:.1}", 1e6 * b.each)),
        s.round_trip.map(|trip| trip.map_or("-".into(), |t| format!("{:.0}", 1e9 * t))).join(", "),
    );
}

fn foot(rows: &[Row]) {
    eprintln!(
        "\n/cpu-s: per second of processor time, all threads together. pairs: touching / listed. ns: per grain-step in neighbour lists, contacts, grains (a pass with clocks). %: of the machine's operations and bandwidth, contacts / grains (a packing in the caches may pass 100). us/break: one grain into 14. ns trip: a number goes from one thread to another and back, before and after; several times 50 where they share no cache."
    );
    if let Some(row) = rows.first() {
        eprintln!(
            "stress: mean over the volume after {} steps; load now {}",
            row.speed.steps,
            bench::load_average().unwrap_or(0.0)
        );
    }
}

fn as_json(args: &Args, machines: &[Machine], packings: &[Packing], rows: &[Row]) -> Value {
    let packings: Vec<Value> = packings
        .iter()
        .map(|p| {
            json!({
                "case": p.case.name(),
                "time_step_s": p.case.time_step(),
                "grains": p.grains.len(),
                "porosity": p.porosity(),
                "radius_m": p.walls.radius,
                "height_m": p.walls.height,
                "file": p.path,
                "made_in_seconds": p.seconds,
            })
        })
        .collect();
    json!({
        "version": env!("CARGO_PKG_VERSION"),
        "machine": {
            "processor": processor(),
            "cores": std::thread::available_parallelism().map_or(1, usize::from),
            "load_average": bench::load_average(),
            "simd": comminute::math::real::name(comminute::math::real::arch()),
            "limits": machines
                .iter()
                .map(|m| json!({ "threads": m.threads, "bytes_per_second": m.bandwidth, "flops": m.flops }))
                .collect::<Vec<_>>(),
        },
        "case": {
            "platen_speed_m_s": bench::PLATEN_SPEED,
            "skin": args.skin,
            "warm_up": args.warm_up,
            "steps": args.steps,
            "repeats": args.repeats,
            "restitution_hertz_viscous": bench::RESTITUTION,
        },
        "packings": packings,
        "rows": rows.iter().map(row_as_json).collect::<Vec<_>>(),
    })
}

fn row_as_json(row: &Row) -> Value {
    let s = &row.speed;
    let named = |x: [f64; 4]| json!({ "neighbours": x[0], "contacts": x[1], "grains": x[2], "crush": x[3] });
    let shares = |x: [f64; 2]| json!({ "operations": x[0], "bandwidth": x[1] });
    json!({
        "case": row.case.name(),
        "grains": row.grains,
        "threads": row.threads,
        "law": row.law.name(),
        "grain_steps_per_second": s.median(),
        "blocks": s.blocks,
        "grain_steps_per_cpu_second": s.cpu_median(),
        "cpu_blocks": s.cpu_blocks,
        "bytes_per_grain": s.bytes_per_grain,
        "pairs_per_grain": { "touching": s.touching, "listed": s.near },
        "wall_contacts_per_grain": { "touching": s.wall_touching, "listed": s.wall_near },
        "stage_ns_per_grain_step": named(s.stages),
        "stage_shares": named(s.shares()),
        "roofline": { "contacts": shares(s.roofline[0]), "grains": shares(s.roofline[1]) },
        "searches": s.searches,
        "steps": s.steps,
        "stress_kPa": { "volume": 1e-3 * s.stress_volume, "platens": 1e-3 * s.stress_platens, "radial": 1e-3 * s.stress_radial },
        "hash": format!("{:016x}", s.hash),
        "load_average": s.load,
        "round_trip_seconds": s.round_trip,
        "breakage": row.burst.as_ref().map(|b| json!({
            "events": b.events,
            "microseconds": 1e6 * b.each,
            "mean_microseconds": 1e6 * b.mean,
            "neighbours_microseconds_per_step": 1e6 * b.neighbours,
            "step_longer_by_microseconds": 1e6 * b.extra,
        })),
    })
}

/// Progress messages: one line that is overwritten on a terminal, a line every 15 s elsewhere.
struct Told {
    quiet: bool,
    terminal: bool,
    last: Instant,
}

impl Told {
    fn new(quiet: bool) -> Told {
        Told { quiet, terminal: std::io::stderr().is_terminal(), last: Instant::now() }
    }

    fn now_and_then(&mut self, text: &str) {
        let wait = Duration::from_millis(if self.terminal { 200 } else { 15_000 });
        if self.quiet || self.last.elapsed() < wait {
            return;
        }
        self.last = Instant::now();
        if self.terminal {
            eprint!("\r{text}\x1b[K");
        } else {
            eprintln!("{text}");
        }
    }

    fn clear(&self) {
        if self.terminal && !self.quiet {
            eprint!("\r\x1b[K");
        }
    }
}
