//! Typed reading of a validated scene, in SI units, and the list of what does not agree.

use super::layers::{Layer, shown};
use super::schema::unit;
use crate::error::Error;
use crate::model::{Model, Records, Rig, Seeds};
use engine::contact::{ContactLaw, ContactModel, TangentialUnloading};
use engine::dem::physics::Physics;
use engine::dem::physics::Stepping;
use engine::material::Material;
use std::cell::RefCell;
use toml::{Table, Value};

pub struct View<'a> {
    layer: &'a Layer,
    errors: RefCell<Vec<Error>>,
}

impl<'a> View<'a> {
    pub fn of(layer: &'a Layer) -> Self {
        View { layer, errors: RefCell::new(Vec::new()) }
    }

    pub fn into_errors(self) -> Vec<Error> {
        self.errors.into_inner()
    }

    /// Note, once, that the value at `key` does not go with the rest.
    pub fn refuse(&self, key: &str, message: impl Into<String>) {
        let origin = self.layer.origin(key);
        let error = Error::input(origin.place, origin.key, self.get(key).map(shown), message);
        let (mut errors, text) = (self.errors.borrow_mut(), error.to_string());
        // several questions may stumble over one value
        if errors.iter().all(|e| e.to_string() != text) {
            errors.push(error);
        }
    }

    /// Note it unless `good`.
    pub fn check(&self, good: bool, key: &str, message: impl Into<String>) {
        if !good {
            self.refuse(key, message);
        }
    }

    pub fn get(&self, key: &str) -> Option<&'a Value> {
        let mut table = Some(&self.layer.table);
        let mut value = None;
        for step in key.split('.') {
            let (name, entry) = step.split_once('[').unwrap_or((step, ""));
            value = table?.get(name);
            if let Some(index) = entry.strip_suffix(']') {
                value = value?.get(index.parse::<usize>().ok()?);
            }
            table = value.and_then(Value::as_table);
        }
        value
    }

    pub fn has(&self, key: &str) -> bool {
        self.get(key).is_some()
    }

    pub fn table(&self, key: &str) -> Option<&'a Table> {
        self.get(key).and_then(Value::as_table)
    }

    /// The tables of a list, empty if it is not there.
    pub fn list(&self, key: &str) -> Vec<&'a Table> {
        let list = self.get(key).and_then(Value::as_array);
        list.into_iter().flatten().filter_map(Value::as_table).collect()
    }

    /// A number in SI units.
    pub fn number(&self, key: &str) -> Option<f64> {
        self.get(key).and_then(Value::as_float).map(|x| x * unit(key))
    }

    /// A number that has a default or is required; NaN only where validation has refused already.
    pub fn si(&self, key: &str) -> f64 {
        self.number(key).unwrap_or(f64::NAN)
    }

    pub fn numbers(&self, key: &str) -> Vec<f64> {
        let list = self.get(key).and_then(Value::as_array);
        let list = list.into_iter().flatten();
        list.filter_map(Value::as_float).map(|x| x * unit(key)).collect()
    }

    pub fn whole(&self, key: &str) -> Option<u64> {
        self.get(key).and_then(Value::as_integer).and_then(|i| u64::try_from(i).ok())
    }

    pub fn flag(&self, key: &str) -> bool {
        self.get(key).and_then(Value::as_bool).unwrap_or(false)
    }

    pub fn text(&self, key: &str) -> &'a str {
        self.get(key).and_then(Value::as_str).unwrap_or("")
    }

    /// Whether grains turn.
    pub fn turning(&self) -> bool {
        self.text("contact.rotation") != "fixed"
    }

    pub fn scale(&self) -> f64 {
        // single grains have no scale
        self.number("specimen.scale").unwrap_or(1.0)
    }

    pub fn law(&self) -> ContactLaw {
        match self.text("contact.law") {
            // a scene without the key: points or grains between platens
            "" => ContactLaw::Hertz,
            word => ContactLaw::named(word).expect("the word has passed the key's check"),
        }
    }

    /// Everything, or `None` with the reasons noted.
    pub fn model(&self) -> Option<Model> {
        let named = self.materials()?;
        if self.text("kind") == "continuum" {
            return self.continuum_model(&named);
        }
        let materials: Vec<Material> = named.iter().filter_map(|m| self.material(m)).collect();
        if materials.len() != named.len() {
            return None;
        }
        let rolling = materials.iter().any(|m| m.rolling_friction > 0.0);
        self.of_grains_only(rolling);
        let mut rig = match self.text("kind") {
            "assembly" => Rig::Assembly(self.assembly(&named)?),
            "platen" => Rig::GrainCrushing(self.grain_crushing(&named)?),
            "mixture" => Rig::Continuum(Box::new(self.mixture(&named, &materials)?)),
            test => Rig::of_test(test, self, &named)??,
        };
        let mut stepping = self.stepping();
        if let Rig::Continuum(rig) = &rig {
            stepping.slow = rig.is_slow();
        }
        let (crush, fines) = self.crushing(&named, &rig)?;
        let seeds = Seeds { packing: self.whole("seed.packing")?, strength: self.whole("seed.strength")? };
        self.typical(&mut rig, crush.as_ref());
        Some(Model {
            name: self.text("name").into(),
            seeds,
            physics: Physics {
                contact: ContactModel {
                    law: self.law(),
                    unloading: match self.text("contact.unloading") {
                        "rescale" => TangentialUnloading::Rescale,
                        _ => TangentialUnloading::Keep,
                    },
                    rolling,
                    turning: self.turning(),
                },
                materials,
                crush,
                damping: self.number("damping.local").unwrap_or(0.0),
                gravity: self.gravity(),
                stepping,
            },
            fines,
            scale: self.scale(),
            rig,
            records: self.records()?,
        })
    }

    pub fn gravity(&self) -> [f64; 3] {
        self.numbers("gravity_m_s2").try_into().unwrap_or([0.0; 3])
    }

    fn stepping(&self) -> Stepping {
        let stepping = Stepping {
            safety: self.si("stepping.safety"),
            inertia_scaling: self.flag("stepping.inertia_scaling") || self.is_grain_crushing(),
            dt: self.number("stepping.dt_s"),
            slow: false,
            skin: self.number("stepping.skin").unwrap_or(0.2),
        };
        if stepping.inertia_scaling {
            let counts = "time counts steps with stepping.inertia_scaling = true";
            self.check(
                self.gravity() == [0.0; 3],
                "gravity_m_s2",
                format!("must be [0, 0, 0]: weight has no meaning when inertia is scaled; {counts}"),
            );
            self.check(
                !self.law().is_viscous(),
                "contact.law",
                format!("must be \"linear\" or \"hertz\": a rate-dependent law has no meaning where {counts}"),
            );
            self.check(stepping.dt.is_none(), "stepping.dt_s", format!("must be \"auto\": {counts}"));
            self.check(!self.has("duration_s"), "duration_s", format!("must be given as `steps`: {counts}"));
        }
        stepping
    }

    /// Stiffness from another size, and contacts that yield, are followed through the grains' own contacts only.
    fn of_grains_only(&self, rolling: bool) {
        let law = self.law().table();
        let what = match (law.inherited, law.plastic) {
            (true, _) => "stiffness that fragments keep",
            (_, true) => "a contact that yields",
            _ => return,
        };
        for (hit, of) in [
            (self.text("kind") == "mixture", "kind = \"mixture\""),
            (law.plastic && self.text("crushing.lost_mass") == "points", "crushing.lost_mass = \"points\""),
            (
                self.flag("crushing.enabled") && self.criterion() == "hertz_area",
                "crushing.criterion = \"hertz_area\", whose contact area is Hertz's",
            ),
            (law.inherited && rolling, "rolling friction"),
        ] {
            self.check(!hit, "contact.law", format!("must be another law: {what} has no meaning with {of}"));
        }
    }

    pub fn records(&self) -> Option<Records> {
        Some(Records {
            per_decade: self.whole("records.per_decade").unwrap_or(1) as u32,
            at: self.numbers("records.at_kPa"),
            least_void_ratio: self.number("records.least_void_ratio").unwrap_or(0.0),
            end_below_least: self.flag("records.end_below_least_void_ratio"),
            stop_without_voids: self.flag("records.stop_without_voids"),
            stop_at_overlap: self.number("records.stop_at_overlap").unwrap_or(f64::INFINITY),
            energy: self.flag("records.energy"),
            snapshots: self.flag("records.snapshots"),
            contacts: self.flag("records.contacts"),
            figures: self.flag("records.figures"),
            checkpoint_seconds: self.number("records.checkpoint_seconds").unwrap_or(60.0),
        })
    }
}
