//! Platens on the device: rigid planes along the axes that press on the points' ghost spheres (`platens.wgsl`).

use super::device::refused;
use super::exact::{place, placed};
use super::layout::{Drive32, Platen32};
use super::state::ghost_radius;
use crate::error::Error;
use crate::mpm::{Points, Settings};

/// How a platen moves during a batch of steps.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Drive {
    /// Into the material, m/s.
    Speed(f64),
    /// Towards a force, N, by the share `gain` of the imbalance over the contacts' stiffness in each step, at most `limit` m/s. For a stress the caller
    /// gives its force on the area of the moment, anew for each batch.
    Force { target: f64, gain: f64, limit: f64 },
}

impl Drive {
    pub(super) fn to_device(self) -> Drive32 {
        match self {
            Drive::Speed(speed) => Drive32 { value: speed as f32, ..Drive32::default() },
            Drive::Force { target, gain, limit } => {
                Drive32 { kind: 1, value: target as f32, gain: gain as f32, limit: limit as f32 }
            }
        }
    }
}

/// A platen and what is known of it after the last batch.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Platen {
    /// Axis of its normal, 0 to 2, and whether the material lies on its upper side.
    pub axis: usize,
    pub upward: bool,
    /// Coordinate along the axis, m.
    pub place: f64,
    /// E* of its contacts, Pa.
    pub modulus: f64,
    pub drive: Drive,
    /// Force of the points on it along its normal, N, when it pressed last.
    pub reaction: f64,
    /// Sum of the contacts' tangent stiffness, N/m; largest of them over the mass of its point, 1/s².
    pub stiffness: f64,
    pub rate: f64,
    /// Elastic energy of its contacts; work done on the points up to the last contact, J.
    pub stored: f64,
    pub work: f64,
    /// Last speed into the material, m/s, and distance moved since the last contact, m.
    pub speed: f64,
    pub moved: f64,
}

impl Platen {
    /// A platen that has not touched yet.
    pub fn new(axis: usize, upward: bool, place: f64, modulus: f64, drive: Drive) -> Platen {
        let (reaction, stiffness, rate, stored, work, speed, moved) = Default::default();
        Platen { axis, upward, place, modulus, drive, reaction, stiffness, rate, stored, work, speed, moved }
    }

    pub(super) fn to_device(self, settings: &Settings) -> Platen32 {
        let (cell, units, rest) = place((self.place - settings.lower[self.axis]) / settings.cell);
        Platen32 {
            axis: self.axis as u32,
            normal: if self.upward { 1.0 } else { -1.0 },
            cell,
            units,
            rest,
            modulus: self.modulus as f32,
            speed: self.speed as f32,
            moved: self.moved as f32,
            reaction: self.reaction as f32,
            stiffness: self.stiffness as f32,
            stored: self.stored as f32,
            rate: self.rate as f32,
            work: self.work as f32,
            work_low: (self.work - f64::from(self.work as f32)) as f32,
            ..Platen32::default()
        }
    }

    /// What the device knows of it now.
    pub(super) fn take(&mut self, p: &Platen32, settings: &Settings) {
        self.place = settings.lower[self.axis] + settings.cell * placed(p.cell, p.units, p.rest);
        (self.reaction, self.stiffness, self.rate) = (p.reaction.into(), p.stiffness.into(), p.rate.into());
        (self.stored, self.work) = (p.stored.into(), f64::from(p.work) + f64::from(p.work_low));
        (self.speed, self.moved) = (p.speed.into(), p.moved.into());
    }
}

/// What is not allowed.
pub(super) fn wrong(platens: &[Platen], settings: &Settings, points: &Points) -> Vec<Error> {
    let mut errors = Vec::new();
    if platens.len() > 6 {
        errors.push(refused("platens", platens.len(), "at most six on the GPU"));
    }
    for p in platens {
        if p.axis > 2 || !p.place.is_finite() || !(p.modulus > 0.0 && p.modulus.is_finite()) {
            errors.push(refused("platen", format!("{p:?}"), "needs an axis of 0 to 2, a finite place and a modulus above 0"));
        }
    }
    let largest = (0..points.len()).map(|i| ghost_radius(points, i)).fold(0.0, f64::max);
    if !platens.is_empty() && largest > 0.9 * settings.cell {
        errors.push(refused(
            "ghost radius",
            largest,
            format!("m is above 0.9 cells of {} m: use larger cells, or the CPU", settings.cell),
        ));
    }
    errors
}
