//! Backends: the CPU computes every scene; a graphics device computes continuum and mixture scenes.

use crate::error::{Error, Result};
use crate::model::continuum::MpmTest;
use crate::model::{self, Model};
use crate::rig::continuum::{Engine, State};
use engine::check::{Checked, ensure};
use serde::{Deserialize, Serialize};

/// The backend that the caller asks for.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum Backend {
    /// The CPU, in double precision.
    #[default]
    Cpu,
    /// The graphics device, in single precision with compensated sums; an error where it cannot compute the scene.
    Gpu,
    /// The graphics device where there is one in hardware that can compute the scene, else the CPU.
    Auto,
}

impl Backend {
    /// The word for it in options and messages: `cpu`, `gpu` or `auto`.
    pub fn name(self) -> &'static str {
        match self {
            Backend::Cpu => "cpu",
            Backend::Gpu => "gpu",
            Backend::Auto => "auto",
        }
    }
}

/// The backend that computes a run, found by [`choose`].
#[derive(Clone, Debug, Default, PartialEq, Eq)]
pub struct Chosen {
    /// True: the graphics device. False: the CPU.
    pub gpu: bool,
    /// With [`Backend::Auto`]: the name of the adapter, or why the CPU was taken.
    pub why: Option<String>,
}

impl Chosen {
    /// The word for it in `summary.json`: `cpu` or `gpu`.
    pub fn name(&self) -> &'static str {
        if self.gpu { "gpu" } else { "cpu" }
    }
}

/// Finds the backend for `model`. Looks for a graphics adapter where one is asked for; starts nothing on it.
///
/// # Errors
/// [`Error::Device`]: [`Backend::Gpu`] is asked for, and there is no graphics device or it cannot compute this scene. The
/// message names the key of the scene.
pub fn choose(asked: Backend, model: &Model) -> Result<Chosen> {
    if asked == Backend::Cpu {
        return Ok(Chosen::default());
    }
    let found = model.spheres_only().and_then(|()| adapter(model));
    if asked == Backend::Gpu {
        return match found {
            Ok(_) => Ok(Chosen { gpu: true, why: None }),
            Err(error @ Error::Device(_)) => Err(error),
            Err(error) => Err(error.on_device()),
        };
    }
    Ok(match found {
        Ok((name, false)) => Chosen { gpu: true, why: Some(name) },
        Ok((name, true)) => {
            Chosen { gpu: false, why: Some(format!("the only graphics adapter, {name}, computes on the processor itself")) }
        }
        Err(e) => Chosen { gpu: false, why: Some(e.to_string().replace('\n', "; ")) },
    })
}

/// Name of the adapter that takes the model, and whether it is software.
fn adapter(model: &Model) -> Result<(String, bool)> {
    let model::Rig::Continuum(rig) = &model.rig else {
        return Err(Error::input(
            "gpu",
            "",
            None,
            "computes continuum and mixture scenes only: grains alone are computed on the CPU",
        ));
    };
    of_continuum(model, rig)
}

#[cfg(feature = "gpu")]
fn of_continuum(model: &Model, rig: &MpmTest) -> Result<(String, bool)> {
    let state = State::start(model, rig)?;
    let adapter = state.on_device(model, rig, engine::gpu::fits)?;
    Ok((adapter.name, adapter.software))
}

#[cfg(not(feature = "gpu"))]
fn of_continuum(_: &Model, _: &MpmTest) -> Result<(String, bool)> {
    Err(Error::input("gpu", "", None, "is not part of this program, which was built without the feature gpu"))
}

/// The backends that a run has used; part of the checkpoint.
#[derive(Default, Serialize, Deserialize)]
pub struct Used {
    /// Names in the order of use: more than one where a run was resumed on another backend.
    pub names: Vec<String>,
    /// [`Chosen::why`] of the last one.
    pub why: Option<String>,
    /// Name of the graphics adapter, and whether it is software (computes on the CPU itself).
    pub adapter: Option<(String, bool)>,
    /// The graphics device's own state; only in a checkpoint.
    pub saved: Option<Vec<u8>>,
}

impl Used {
    /// Checks the names from a checkpoint. A device looks at its own state when it takes it.
    ///
    /// # Errors
    /// What is wrong, in words.
    pub fn check(&self) -> Checked {
        let known = |name: &String| [Backend::Cpu, Backend::Gpu].iter().any(|backend| backend.name() == name);
        ensure(!self.names.is_empty() && self.names.iter().all(known), || format!("no backends: {:?}", self.names))
    }

    /// Whether the last one was a graphics device.
    pub fn gpu(&self) -> bool {
        self.names.last().is_some_and(|name| name == "gpu")
    }

    /// Notes the chosen backend as the last one that the run uses. Called before [`Self::engine`]; a specimen that grows on the
    /// CPU first can be taken up between the two.
    pub fn note(&mut self, chosen: Chosen) {
        let name = chosen.name();
        // only the device that made it goes on with its own state
        self.saved = self.saved.take().filter(|_| chosen.gpu && self.gpu());
        if self.names.last().is_none_or(|last| last != name) {
            self.names.push(name.into());
        }
        self.why = chosen.why;
    }

    /// Sets up the engine that makes the steps on the last backend. A graphics device takes over its own state from the
    /// checkpoint, so that a resumed run has the same bits.
    ///
    /// # Errors
    /// A graphics device that cannot be opened, has too little memory, or whose saved state is damaged.
    pub fn engine(&mut self, state: &mut State, model: &Model, rig: &MpmTest) -> Result<Engine> {
        let saved = self.saved.take();
        if self.gpu() { self.device(saved, state, model, rig) } else { Ok(Engine::of_grains(state, model, rig)) }
    }

    #[cfg(feature = "gpu")]
    fn device(&mut self, saved: Option<Vec<u8>>, state: &mut State, model: &Model, rig: &MpmTest) -> Result<Engine> {
        let damaged = |e: postcard::Error| Error::Failed {
            step: state.continuum.steps(),
            what: format!("the device's state is damaged ({e})"),
        };
        let saved = saved.map(|bytes| postcard::from_bytes(&bytes)).transpose().map_err(damaged)?;
        let device = crate::rig::continuum::Device::new(state, model, rig, saved.as_ref())?;
        self.adapter = Some((device.adapter().name.clone(), device.adapter().software));
        Ok(Engine::Gpu(Box::new(device)))
    }

    #[cfg(not(feature = "gpu"))]
    fn device(&mut self, _: Option<Vec<u8>>, _: &mut State, _: &Model, _: &MpmTest) -> Result<Engine> {
        unreachable!("refused when it was chosen")
    }

    /// Copies points, grains and the device's own state from the graphics device, so that a checkpoint holds them. On the CPU
    /// nothing is to be done.
    ///
    /// # Errors
    /// A device that was lost.
    pub fn save(&mut self, engine: &Engine, model: &Model, state: &mut State) -> Result<()> {
        engine.read_back(state, model)?;
        #[cfg(feature = "gpu")]
        if let Engine::Gpu(device) = engine {
            let failed = |e: postcard::Error| Error::Failed { step: state.continuum.steps(), what: e.to_string() };
            self.saved = Some(postcard::to_stdvec(&device.save()?).map_err(failed)?);
        }
        Ok(())
    }
}
