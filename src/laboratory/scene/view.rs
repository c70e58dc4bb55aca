//! Reads the values of a validated scene, in SI units, and collects errors: values that are missing, or that contradict others.

use super::accuracy::Level;
use super::layers::{Layer, PackedFrom, shown};
use super::schema::unit;
use super::validate::TOLD;
use crate::error::Error;
use crate::model::{Model, Records, Rig, Seeds};
use engine::contact::{ContactLaw, ContactModel, TangentialUnloading};
use engine::dem::physics::Physics;
use engine::dem::physics::Stepping;
use engine::material::Material;
use engine::rigid::Block;
use engine::shape::PlacedCompound;
use std::cell::{Cell, RefCell};
use std::sync::PoisonError;
use toml::{Table, Value};

/// A validated scene whose values are read one by one. Missing and contradictory values are collected as errors; reading goes on,
/// so that all errors are reported together.
pub struct View<'a> {
    layer: &'a Layer,
    errors: RefCell<Vec<Error>>,
    /// Compounds that have been made, by their parts: many bodies of a scene are alike.
    pub compounds: RefCell<Vec<(&'a Value, PlacedCompound)>>,
    /// Whether of many points and grains only some are made ([`super::outline`]).
    pub outlined: bool,
    /// Whether the outline lacks anything that the model has.
    pub incomplete: Cell<bool>,
}

impl<'a> View<'a> {
    /// A view of the scene `layer`, without errors.
    pub fn of(layer: &'a Layer) -> Self {
        let (errors, compounds) = (RefCell::new(Vec::new()), RefCell::new(Vec::new()));
        View { layer, errors, compounds, outlined: false, incomplete: Cell::new(false) }
    }

    /// A view that makes the outline of a model ([`super::outline`]).
    pub fn outlining(layer: &'a Layer) -> Self {
        View { outlined: true, ..View::of(layer) }
    }

    /// The bodies of a set, if they have been packed before.
    pub fn packed(&self, from: &PackedFrom) -> Option<Vec<Block>> {
        let packed = self.layer.packed.lock().unwrap_or_else(PoisonError::into_inner);
        packed.iter().find(|(of, _)| of == from).map(|(_, blocks)| blocks.clone())
    }

    /// Keeps the bodies of a set for the next time.
    pub fn keep_packed(&self, from: PackedFrom, blocks: &[Block]) {
        self.layer.packed.lock().unwrap_or_else(PoisonError::into_inner).push((from, blocks.to_vec()));
    }

    /// The errors collected so far, in the order in which they were found.
    pub fn into_errors(self) -> Vec<Error> {
        self.errors.into_inner()
    }

    /// Adds an error about the value at `key`: `message`, and the place where the value was written. An error with the same text is
    /// added once only.
    pub fn refuse(&self, key: &str, message: impl Into<String>) {
        if self.errors.borrow().len() >= TOLD {
            return;
        }
        let origin = self.layer.origin(key);
        let error = Error::input(origin.place, origin.key, self.get(key).map(shown), message);
        let (mut errors, text) = (self.errors.borrow_mut(), error.to_string());
        // several checks may refuse the same value for the same reason
        if errors.iter().all(|e| e.to_string() != text) {
            errors.push(error);
        }
    }

    /// Adds an error about the value at `key` unless `good` is true ([`View::refuse`]).
    pub fn check(&self, good: bool, key: &str, message: impl Into<String>) {
        if !good {
            self.refuse(key, message);
        }
    }

    /// The value at a dotted key, in the unit of the key; `[0]` behind a name is the entry of a list (`wall[0].friction`). `None`
    /// where there is none.
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

    /// Whether the scene has the key, written or filled in by default.
    pub fn has(&self, key: &str) -> bool {
        self.get(key).is_some()
    }

    /// The table at a key; `None` where there is none.
    pub fn table(&self, key: &str) -> Option<&'a Table> {
        self.get(key).and_then(Value::as_table)
    }

    /// The tables of the list at a key (`[[grain]]`); empty where there is none.
    pub fn list(&self, key: &str) -> Vec<&'a Table> {
        let list = self.get(key).and_then(Value::as_array);
        list.into_iter().flatten().filter_map(Value::as_table).collect()
    }

    /// The number at a key, in SI units (the unit in the file is the suffix of the key). `None` where the key is absent or holds a
    /// word such as `"auto"`.
    pub fn number(&self, key: &str) -> Option<f64> {
        self.get(key).and_then(Value::as_float).map(|x| x * unit(key))
    }

    /// The number, in SI units, at a key that is required or has a default, so that a validated scene has it; NaN where the key is
    /// absent.
    pub fn si(&self, key: &str) -> f64 {
        self.number(key).unwrap_or(f64::NAN)
    }

    /// The numbers of the list at a key, in SI units; empty where there is none.
    pub fn numbers(&self, key: &str) -> Vec<f64> {
        let list = self.get(key).and_then(Value::as_array);
        let list = list.into_iter().flatten();
        list.filter_map(Value::as_float).map(|x| x * unit(key)).collect()
    }

    /// The whole number at a key; `None` where the key is absent, or the number negative.
    pub fn whole(&self, key: &str) -> Option<u64> {
        self.get(key).and_then(Value::as_integer).and_then(|i| u64::try_from(i).ok())
    }

    /// The true or false at a key; false where the key is absent.
    pub fn flag(&self, key: &str) -> bool {
        self.get(key).and_then(Value::as_bool).unwrap_or(false)
    }

    /// The text at a key; empty where the key is absent or holds no text.
    pub fn text(&self, key: &str) -> &'a str {
        self.get(key).and_then(Value::as_str).unwrap_or("")
    }

    /// Whether grains may rotate (`contact.rotation`).
    pub fn turning(&self) -> bool {
        self.text("contact.rotation") != "fixed"
    }

    /// Scale N, -: grains of the run are N times as large as those of the material. 1 where the scene has no key for it.
    pub fn scale(&self) -> f64 {
        // platen tests and continua have no key for it
        self.number("specimen.scale").unwrap_or(1.0)
    }

    /// The contact law. Hertz's where the scene has no key for it: in platen tests, and in continua, whose platens press with
    /// Hertz's force.
    pub fn law(&self) -> ContactLaw {
        match self.text("contact.law") {
            // platen tests and continua
            "" => ContactLaw::Hertz,
            word => ContactLaw::named(word).expect("the word has passed the key's check"),
        }
    }

    /// The model of the run. It is valid only if no errors were collected ([`View::into_errors`]); `None` where errors leave it
    /// incomplete.
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
            accuracy: self.level(),
        })
    }

    /// The level of accuracy that the scene asks for.
    pub fn level(&self) -> Option<&'static Level> {
        let word = self.text("accuracy");
        let level = Level::of(self.text("kind"), self.text("test.rig"), word);
        self.check(word.is_empty() || level.is_some(), "accuracy", "has a meaning in tests only, not with test.rig = \"free\"");
        let measured = !self.is_without_points() && self.text("growth.fines") != "grains";
        let message =
            "has a meaning in tests of material points: no study has measured levels in mixtures of grains or rigid bodies alone";
        self.check(level.is_none() || measured, "accuracy", message);
        level
    }

    /// Gravity, m/s²; zero where the scene has none.
    pub fn gravity(&self) -> [f64; 3] {
        self.numbers("gravity_m_s2").try_into().unwrap_or([0.0; 3])
    }

    /// How the time step is chosen. Refuses what has no meaning with scaled inertia: weight, viscous contact laws, a time step or a
    /// duration in s.
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
                format!("must be a law without viscous damping, as \"linear\" or \"hertz\": a rate-dependent law has no meaning where {counts}"),
            );
            self.check(stepping.dt.is_none(), "stepping.dt_s", format!("must be \"auto\": {counts}"));
            self.check(!self.has("duration_s"), "duration_s", format!("must be given as `steps`: {counts}"));
        }
        stepping
    }

    /// Refuses two kinds of contact laws where the rest of the scene cannot use them. Laws by which fragments keep the stiffness of
    /// the grain they come from: in mixtures, with the criterion `hertz_area` and with rolling friction. Laws by which contacts
    /// yield: in mixtures, with `hertz_area` and where lost mass becomes points. `rolling`: whether a material has rolling
    /// friction.
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

    /// What the run records. Keys that this kind of scene does not have get values without effect.
    pub fn records(&self) -> Option<Records> {
        Some(Records {
            per_decade: self.whole("records.per_decade").unwrap_or(1) as u32,
            at: self.numbers("records.at_kPa"),
            least_void_ratio: self.number("records.least_void_ratio").unwrap_or(0.0),
            end_below_least: self.flag("records.end_below_least_void_ratio"),
            stop_without_voids: self.flag("records.stop_without_voids"),
            stop_at_overlap: self.number("records.stop_at_overlap").unwrap_or(f64::INFINITY),
            stop_at_step: self.number("records.stop_at_step").unwrap_or(0.0),
            energy: self.flag("records.energy"),
            account: self.flag("records.account"),
            snapshots: self.flag("records.snapshots"),
            contacts: self.flag("records.contacts"),
            figures: self.flag("records.figures"),
            report: self.flag("records.report"),
            checkpoint_seconds: self.number("records.checkpoint_seconds").unwrap_or(60.0),
        })
    }
}
