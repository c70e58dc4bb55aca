//! One run of a campaign.

use super::Vary;
use laboratory::error::Result;
use laboratory::model::Model;
use laboratory::run::{Backend, Found, look};
use laboratory::scene::{self, Scene};
use std::ffi::OsString;
use std::path::{Path, PathBuf};

/// A run in a folder of its own.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Job {
    /// Scene file.
    pub scene: PathBuf,
    /// `key=value`, laid over the scene in this order.
    pub sets: Vec<String>,
    /// Seed of the specimen; `None`: that of the scene.
    pub seed_packing: Option<u64>,
    /// Seed of the strengths; `None`: that of the scene.
    pub seed_strength: Option<u64>,
    /// A prepared specimen to begin with.
    pub specimen: Option<PathBuf>,
    /// Folder of the run.
    pub out: PathBuf,
    /// Threads of the run; the runner shares out the machine's cores if not given.
    pub threads: Option<usize>,
    /// Device that computes the steps of a continuum.
    pub backend: Backend,
}

impl Job {
    /// A job that runs the scene unchanged, in the folder `out`.
    pub fn new(scene: impl Into<PathBuf>, out: impl Into<PathBuf>) -> Job {
        Job { scene: scene.into(), out: out.into(), ..Job::default() }
    }

    /// Adds `key=value` pairs that are laid over the scene.
    pub fn with(mut self, sets: &[String]) -> Job {
        self.sets.extend_from_slice(sets);
        self
    }

    /// Sets `seed` for the random streams that `vary` names.
    pub fn seeded(mut self, vary: Vary, seed: u64) -> Job {
        if vary != Vary::Strength {
            self.seed_packing = Some(seed);
        }
        if vary != Vary::Packing {
            self.seed_strength = Some(seed);
        }
        self
    }

    /// Loads the scene with everything that the job changes, and makes the outline of the model from it ([`scene::outline`]).
    ///
    /// # Errors
    /// Whatever is wrong with the scene or the values laid over it.
    pub fn load(&self) -> Result<(Scene, Model)> {
        let mut sets = self.sets.clone();
        sets.extend(self.specimen.iter().map(|file| format!("specimen.file={:?}", file.display().to_string())));
        sets.extend(self.seed_packing.map(|n| format!("seed.packing={n}")));
        sets.extend(self.seed_strength.map(|n| format!("seed.strength={n}")));
        let scene = scene::load(&self.scene, &sets)?;
        let model = scene::outline(&scene)?;
        Ok((scene, model))
    }

    /// What the folder of the job holds now.
    ///
    /// # Errors
    /// As [`Job::load`], and files that cannot be read.
    pub fn found(&self) -> Result<Found> {
        let (scene, model) = self.load()?;
        look(&self.out, &scene, &model)
    }

    /// Arguments with which `comminute` does what is left of the job.
    pub fn args(&self) -> Vec<OsString> {
        let mut args: Vec<OsString> = vec!["run".into(), self.scene.clone().into()];
        let mut option = |name: &str, value: OsString| args.extend([name.into(), value]);
        for set in &self.sets {
            option("--set", set.into());
        }
        match (self.seed_packing, self.seed_strength) {
            (Some(a), Some(b)) if a == b => option("--seed", a.to_string().into()),
            (a, b) => {
                for (name, seed) in [("--seed-packing", a), ("--seed-strength", b)] {
                    if let Some(seed) = seed {
                        option(name, seed.to_string().into());
                    }
                }
            }
        }
        if let Some(file) = &self.specimen {
            option("--specimen", file.into());
        }
        option("--out", self.out.clone().into());
        if let Some(threads) = self.threads {
            option("--threads", threads.to_string().into());
        }
        if self.backend != Backend::Cpu {
            option("--backend", self.backend.name().into());
        }
        args.extend(["--continue".into(), "--quiet".into()]);
        args
    }

    /// The whole command as a line for a shell; `program` are the words by which the program is
    /// called.
    pub fn command_line(&self, program: &[String]) -> String {
        let words = self.args().into_iter().map(|word| shell_word(&word.to_string_lossy()));
        program.iter().map(|word| shell_word(word)).chain(words).collect::<Vec<_>>().join(" ")
    }

    /// File with the messages of a failed run, beside the folder of the run. It is locked by the campaign and the process that work on
    /// the run.
    pub fn log(&self) -> PathBuf {
        beside(&self.out, ".log")
    }
}

fn beside(path: &Path, end: &str) -> PathBuf {
    let mut name = path.file_name().unwrap_or_default().to_os_string();
    name.push(end);
    path.with_file_name(name)
}

/// A word as a POSIX shell takes it: unchanged, or in quotes where the word needs them.
pub fn shell_word(word: &str) -> String {
    let plain = |c: char| c.is_ascii_alphanumeric() || "-_./=,:+@%".contains(c);
    if !word.is_empty() && word.chars().all(plain) { word.into() } else { format!("'{}'", word.replace('\'', "'\\''")) }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_command_line_holds_everything_that_changes_the_scene() {
        let job = Job::new("a scene.toml", "out/one").with(&["name=\"it's\"".into(), "loading.rate=0.1".into()]);
        let text = job.clone().seeded(Vary::Both, 3).command_line(&["comminute".into()]);
        let sets = r#"--set 'name="it'\''s"' --set loading.rate=0.1"#;
        assert_eq!(text, format!("comminute run 'a scene.toml' {sets} --seed 3 --out out/one --continue --quiet"));
        let text = Job { threads: Some(2), backend: Backend::Gpu, ..job.seeded(Vary::Packing, 4) }
            .command_line(&["python".into(), "-m".into()]);
        assert!(text.starts_with("python -m run 'a scene.toml'"), "{text}");
        assert!(text.contains("--seed-packing 4 --out out/one --threads 2 --backend gpu") && !text.contains("strength"), "{text}");
    }

    #[test]
    fn the_log_lies_beside_the_folder() {
        assert_eq!(Job::new("s.toml", "runs/m-2.5/").log(), PathBuf::from("runs/m-2.5.log"));
    }
}
