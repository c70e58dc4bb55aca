//! `comminute check SCENE`

use super::{Overrides, print};
use comminute::error::Result;
use comminute::machine::Pace;
use comminute::model::{Model, Rig};
use comminute::scene::{self, Checked, Estimate, Scene};
use std::fmt::Write;
use std::io::IsTerminal;
use std::path::PathBuf;

/// Rigid bodies that are described one by one.
const LISTED: usize = 12;

/// Validate a scene and say what the run would be
#[derive(Debug, clap::Args)]
#[command(after_help = "Example, from the repository root:\n  comminute check experiments/petroleum_coke/h-c-2.toml")]
pub struct Args {
    /// Scene file (TOML)
    #[arg(required_unless_present_any = ["keys", "columns"])]
    scene: Option<PathBuf>,

    #[command(flatten)]
    overrides: Overrides,

    /// Print every key of scenes and materials instead, with its default and meaning
    #[arg(long)]
    keys: bool,

    /// Print every column of the tables that runs leave instead, with its unit and meaning
    #[arg(long, conflicts_with = "keys")]
    columns: bool,

    /// Measure the range of void ratios that can be made of these grains, by making the loosest and the densest specimen (seconds to minutes); it is kept in the user's cache
    #[arg(long, conflicts_with_all = ["keys", "columns"])]
    range: bool,

    /// Measure how fast this machine is (a second), anew if that is known, for the time that is expected; it is kept in the user's cache
    #[arg(long, conflicts_with_all = ["keys", "columns"])]
    measure: bool,

    /// Only say what is wrong
    #[arg(long)]
    quiet: bool,

    /// Print as JSON to standard output
    #[arg(long)]
    json: bool,
}

pub fn call(args: &Args) -> Result<()> {
    if args.columns {
        return print(comminute::record::dictionary::reference().trim_end());
    }
    let path = match &args.scene {
        Some(path) if !args.keys => path,
        _ => return print(scene::key_reference().trim_end()),
    };
    let scene = args.overrides.load(path)?;
    let Checked { model, estimate } = scene::check(&scene, args.range, || pace(args))?;
    if args.json {
        print(&format!("{:#}", scene::in_json(&scene, &model, &estimate)))?;
    } else if !args.quiet {
        eprint!("{}", as_text(&scene, &model, &estimate));
    }
    Ok(())
}

/// How fast this machine is: as was measured once, else measured now, where the option or a person at a terminal asks; `None` where it
/// is not known.
fn pace(args: &Args) -> Result<Option<Pace>> {
    let known = Pace::known();
    let asks = known.is_none() && !args.quiet && std::io::stderr().is_terminal();
    if !(args.measure || asks) {
        return Ok(known);
    }
    let pace = comminute::bench::yardstick()?;
    pace.keep();
    Ok(Some(pace))
}

fn as_text(scene: &Scene, model: &Model, estimate: &Estimate) -> String {
    let mut text = String::new();
    // writing to a String does not fail
    let _ = facts(&mut text, scene, model, estimate);
    let assumed = scene::assumptions(scene);
    if !assumed.is_empty() {
        text += "\nassumed values (no paper gives them):\n";
        for a in assumed {
            let _ = writeln!(text, "  {} = {}  ({})", a.key, scene::shown(&a.value), a.source);
        }
    }
    if let Some(level) = model.accuracy {
        let _ = writeln!(text, "\naccuracy = \"{}\": {}; it sets", level.word, level.promise.in_words());
        for a in scene::set_by_accuracy(scene) {
            let _ = writeln!(text, "  {} = {}  ({})", a.key, scene::shown(&a.value), a.source);
        }
        for o in scene::accuracy_overruled(scene) {
            let [own, level] = [&o.value, &o.level].map(scene::shown);
            let _ = writeln!(
                text,
                "  {} stays {own}, as the scene has it, not {level}: no study has measured the level with it",
                o.key
            );
        }
    }
    text += "\ndecisions where the papers are silent:\n";
    for d in scene::decisions(scene) {
        let _ = match d.key {
            "" => writeln!(text, "  {}: {} (fixed)", d.matter, d.value.as_str().unwrap_or("")),
            key => writeln!(text, "  {}: {key} = {}", d.matter, scene::shown(&d.value)),
        };
    }
    for (i, warning) in estimate.warnings.iter().enumerate() {
        let gap = if i == 0 { "\n" } else { "" };
        let _ = writeln!(text, "{gap}warning: {warning}");
    }
    text
}

fn facts(text: &mut String, scene: &Scene, model: &Model, e: &Estimate) -> std::fmt::Result {
    writeln!(text, "{}: {}", model.name, scene.description())?;
    let names: Vec<&str> = model.physics.materials.iter().map(|m| m.name.as_str()).collect();
    writeln!(text, "  material        {}", names.join(", "))?;
    if let Some(c) = &e.continuum {
        return continuum(text, scene, c, e);
    }
    writeln!(text, "  grains          {}", e.grains)?;
    match &model.physics.crush {
        None => writeln!(text, "  crushing        off")?,
        Some(c) if matches!(model.rig, Rig::GrainCrushing(_)) => writeln!(text, "  crushing        {}", c.criterion.meaning())?,
        Some(c) => writeln!(
            text,
            "  crushing        {}-ball pattern above {:.4} mm; perhaps {:.0} grains at the end (estimate)",
            c.pattern.count(),
            1e3 * c.d_limit,
            e.grains_final
        )?,
    }
    crushing_stress(text, e)?;
    if let Some(s) = &e.specimen {
        writeln!(
            text,
            "  specimen        D = {:.2} mm, H = {:.2} mm (estimate); D = {:.1} d50 = {:.1} d_max, H = {:.1} d_max",
            s.diameter_mm, s.height_mm, s.diameter_over_d50, s.diameter_over_largest, s.height_over_largest
        )?;
        if let Some(r) = &e.void_ratio_range {
            let how = if r.measured { "measured" } else { "estimate; --range measures it" };
            let (dense, loose) = (r.void_ratio_densest, r.void_ratio_loosest);
            writeln!(text, "  void ratio      {:.3} is asked for; {dense:.3} to {loose:.3} can be made ({how})", s.void_ratio)?;
        }
        if e.steps_expected > e.steps {
            writeln!(
                text,
                "  loading steps   {:.0} by the programme alone, {:.0} with waiting (estimate)",
                e.steps, e.steps_expected
            )?;
        } else {
            writeln!(text, "  loading steps   {:.0} or more (the programme without waiting)", e.steps)?;
        }
    } else {
        writeln!(text, "  steps           {:.0} (estimate)", e.steps_expected)?;
    }
    match e.time_step {
        Some(dt) => writeln!(text, "  time step       {dt:.3e} s (estimate): {}", e.time_step_limit)?,
        None => writeln!(text, "  time step       {}", e.time_step_limit)?,
    }
    writeln!(text, "  time            {}", time(e))?;
    writeln!(text, "  memory          {:.0} MB (estimate)", e.memory_mb.ceil())?;
    writeln!(text, "  files           {}", files(&e.output))?;
    writeln!(text, "  seeds           packing {}, strength {}", model.seeds.packing, model.seeds.strength)?;
    writeln!(text, "  folder          {}", scene.default_out().display())
}

/// Writes the mean strength of single grains as the crushing stress F/d² of a laboratory.
fn crushing_stress(text: &mut String, e: &Estimate) -> std::fmt::Result {
    let Some(s) = &e.crushing_stress else { return Ok(()) };
    writeln!(
        text,
        "  grain strength  mean F/d² of single grains of {:.3} mm (d50) between rigid platens: {} MPa",
        s.d_mm,
        // four digits
        format!("{:.3e}", s.mean_mpa).parse::<f64>().unwrap_or(s.mean_mpa)
    )
}

/// The time of a run in one line.
fn time(e: &Estimate) -> String {
    let of =
        if e.pace.is_some() { "of this machine (estimate)" } else { "(estimate for a fast machine; --measure measures this one)" };
    format!("{} on one thread {of}", comminute::run::human(e.seconds))
}

/// The files of a run in one line.
fn files(o: &scene::Output) -> String {
    let counts = [(o.rows, "rows"), (o.snapshots, "snapshots")];
    let counts: Vec<String> = counts.iter().filter(|(n, _)| *n > 0.0).map(|(n, what)| format!("{n:.0} {what}")).collect();
    let of = if counts.is_empty() { String::new() } else { format!(": {}", counts.join(", ")) };
    format!("{} (estimate){of}", comminute::machine::size(1e6 * o.total_mb))
}

fn continuum(text: &mut String, scene: &Scene, c: &scene::Points, e: &Estimate) -> std::fmt::Result {
    let [x, y, z] = c.cells;
    let grows = if c.grows { " (estimate: the specimen grows)" } else { "" };
    if c.grows {
        writeln!(text, "  points          {}{grows}", c.points)?;
    } else if c.points > 0 {
        writeln!(text, "  points          {} ({} per cell)", c.points, c.points_per_cell)?;
    }
    if e.grains > 0 {
        writeln!(text, "  grains          {}{grows}", e.grains)?;
    }
    crushing_stress(text, e)?;
    for (k, block) in c.blocks.iter().enumerate().take(LISTED) {
        writeln!(text, "  block {k:<9} {block}")?;
    }
    if c.blocks.len() > LISTED {
        writeln!(text, "  blocks          {} more of them", c.blocks.len() - LISTED)?;
    }
    if c.points > 0 {
        writeln!(text, "  grid            {x} × {y} × {z} cells; memory only where material is")?;
    }
    writeln!(text, "  steps           {:.0} (estimate)", e.steps_expected)?;
    if let Some(dt) = e.time_step {
        writeln!(text, "  time step       {dt:.3e} s (estimate): {}", e.time_step_limit)?;
    }
    if let Some([points, coarse]) = c.inertial_numbers {
        let both = [(points, "points"), (coarse, "coarse grains")];
        let both: Vec<String> = both.iter().filter_map(|(i, of)| i.map(|i| format!("{i:.1e} of the {of}"))).collect();
        writeln!(text, "  inertial number {} at the start; quasi-static loading keeps below 0.001", both.join(", "))?;
    }
    let breakages = if c.without_breakages { ", as if nothing broke" } else { "" };
    writeln!(text, "  time            {}{breakages}", time(e))?;
    writeln!(text, "  memory          {:.0} MB (estimate)", e.memory_mb.ceil())?;
    writeln!(text, "  files           {}", files(&e.output))?;
    match (c.device_mb, c.device_step) {
        (Some(mb), Some(s)) => writeln!(
            text,
            "  graphics device {:.0} MB (estimate), with --backend gpu; a step: {} dispatches, {:.1} MB moved, {:.1} Mflop",
            mb.ceil(),
            s.dispatches,
            s.mb,
            s.mflop
        )?,
        _ => writeln!(text, "  graphics device no: {}", c.device_lacks.as_deref().unwrap_or("unknown"))?,
    }
    writeln!(text, "  folder          {}", scene.default_out().display())
}
