//! Who does the steps of a run: the processor, or for a continuum, with grains or without, a graphics device.

use crate::error::{Error, Result};
use crate::model::continuum::Continuum as Rig;
use crate::model::{self, Model};
use crate::rig::continuum::{Engine, State};
use serde::{Deserialize, Serialize};

/// What is asked for.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum Backend {
    #[default]
    Cpu,
    /// The graphics device, or an error.
    Gpu,
    /// A graphics device that is hardware and has all that the scene asks for, else the processor.
    Auto,
}

impl Backend {
    /// As it is typed.
    pub fn name(self) -> &'static str {
        match self {
            Backend::Cpu => "cpu",
            Backend::Gpu => "gpu",
            Backend::Auto => "auto",
        }
    }
}

/// What it comes to.
#[derive(Clone, Debug, Default, PartialEq, Eq)]
pub struct Chosen {
    pub gpu: bool,
    /// Why, where it was left open.
    pub why: Option<String>,
}

impl Chosen {
    /// As it stands in summaries.
    pub fn name(&self) -> &'static str {
        if self.gpu { "gpu" } else { "cpu" }
    }
}

/// Who is to do the steps of a run. Nothing is started.
///
/// # Errors
/// A graphics device is asked for, and there is none, or it lacks what the scene needs: by name.
pub fn choose(asked: Backend, model: &Model) -> Result<Chosen> {
    if asked == Backend::Cpu {
        return Ok(Chosen::default());
    }
    let found = model.spheres_only().and_then(|()| adapter(model));
    if asked == Backend::Gpu {
        return found.map(|_| Chosen { gpu: true, why: None });
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
            "--backend gpu",
            "",
            None,
            "is for continuum and mixture scenes: grains alone are computed on the CPU",
        ));
    };
    of_continuum(model, rig)
}

#[cfg(feature = "gpu")]
fn of_continuum(model: &Model, rig: &Rig) -> Result<(String, bool)> {
    let state = State::start(model, rig)?;
    let adapter = state.on_device(model, rig, engine::gpu::fits)?;
    Ok((adapter.name, adapter.software))
}

#[cfg(not(feature = "gpu"))]
fn of_continuum(_: &Model, _: &Rig) -> Result<(String, bool)> {
    Err(Error::input(
        "--backend gpu",
        "",
        None,
        "needs a program that was built with the feature gpu: this one was not; use --backend cpu",
    ))
}

/// What a run remembers of its backends; part of the checkpoint.
#[derive(Default, Serialize, Deserialize)]
pub struct Used {
    /// In turn, where a resumed run went on elsewhere.
    pub names: Vec<String>,
    pub why: Option<String>,
    /// Graphics adapter, and whether it is software.
    pub adapter: Option<(String, bool)>,
    /// The device's own state at a checkpoint.
    pub saved: Option<Vec<u8>>,
}

impl Used {
    /// Whether the last one was a graphics device.
    pub fn gpu(&self) -> bool {
        self.names.last().is_some_and(|name| name == "gpu")
    }

    /// Sets the engine up, with the device's own state where there is one.
    ///
    /// # Errors
    /// What the device says.
    pub fn engine(&mut self, chosen: Chosen, state: &mut State, model: &Model, rig: &Rig) -> Result<Engine> {
        let name = chosen.name();
        let saved = self.saved.take().filter(|_| chosen.gpu && self.gpu());
        if self.names.last().is_none_or(|last| last != name) {
            self.names.push(name.into());
        }
        self.why = chosen.why;
        match &mut state.mixture {
            _ if chosen.gpu => self.device(saved, state, model, rig),
            Some(_) => Ok(Engine::of_grains(state, model, rig)),
            None => Ok(Engine::Cpu),
        }
    }

    #[cfg(feature = "gpu")]
    fn device(&mut self, saved: Option<Vec<u8>>, state: &mut State, model: &Model, rig: &Rig) -> Result<Engine> {
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
    fn device(&mut self, _: Option<Vec<u8>>, _: &mut State, _: &Model, _: &Rig) -> Result<Engine> {
        unreachable!("refused when it was chosen")
    }

    /// Brings points and device's state up to date for a checkpoint.
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
