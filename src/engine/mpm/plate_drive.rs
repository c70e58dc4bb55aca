//! How a loading plate moves until the test sets another drive: at a speed, or towards a stress. Twin on a graphics device: `loading_plates.wgsl`.

use super::LoadingPlate;
use crate::boundary::{limited, servo_speed};
use std::f64::consts::{FRAC_PI_4, PI};

/// A value that changes in proportion to time until it reaches its end.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Ramp {
    /// Value at the start.
    pub value: f64,
    /// Change per second, towards the end; 0: the value stays.
    pub slope: f64,
    /// Value at the end.
    pub end: f64,
}

impl Ramp {
    /// A value that does not change.
    pub fn constant(value: f64) -> Ramp {
        Ramp { value, slope: 0.0, end: value }
    }

    /// The value after `time` seconds.
    pub fn at(self, time: f64) -> f64 {
        let value = self.value + self.slope * time;
        match self.slope {
            slope if slope > 0.0 => value.min(self.end),
            slope if slope < 0.0 => value.max(self.end),
            _ => self.value,
        }
    }
}

/// How a loading plate moves.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum PlateDrive {
    /// At this speed, m/s, positive into the material.
    Speed(Ramp),
    /// Holds a stress by a servo. The servo acts on top of the plate's mean speed, as it would otherwise lag behind a specimen that deforms steadily.
    Stress {
        /// Stress to be held, Pa, compression positive.
        target: Ramp,
        /// Share of the imbalance that is removed in one step.
        gain: f64,
        /// Largest speed over the extent of the material along the plate's axis, 1/s.
        reach: f64,
        /// Time over which the mean speed is taken, s; infinite: the mean speed stays 0.
        memory: f64,
    },
}

impl PlateDrive {
    /// Speed of `plate`, m/s, positive into the material, `time` seconds after the drive was set, for a step of `dt` seconds. `extent`: extent of the material
    /// along the plate's axis, m; `area`: area of its face, m² (m in plane strain); `drift`: mean speed of the plate, m/s, which is updated.
    pub fn speed(&self, time: f64, plate: &LoadingPlate, [extent, area]: [f64; 2], dt: f64, drift: &mut f64) -> f64 {
        match *self {
            PlateDrive::Speed(speed) => speed.at(time),
            PlateDrive::Stress { target, gain, reach, memory } => {
                let force = target.at(time) * area;
                let limit = reach * extent;
                let servo = servo_speed(force, plate.force(), plate.stiffness + plate.others[1], gain, dt, limit);
                let speed = limited(*drift + servo, limit);
                *drift += (dt / memory).min(1.0) * (speed - *drift);
                speed
            }
        }
    }
}

/// Area of a box with these extents, m, across an axis: product of the other extents, m² (a third extent of 1 gives m²/m in plane strain).
pub fn area(extents: [f64; 3], axis: usize) -> f64 {
    (0..3).filter(|&a| a != axis).map(|a| extents[a]).product()
}

/// Area of a specimen's face across an axis over that of the box around it ([`area`]); `round`: the specimen is an upright cylinder. Across the lateral axes of
/// a cylinder it is that of the whole shell, whose force is the sum of all radial forces.
pub fn face_share(round: bool, axis: usize) -> f64 {
    match (round, axis) {
        (false, _) => 1.0,
        (true, 2) => FRAC_PI_4,
        (true, _) => PI,
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_ramp_ends_where_it_ends() {
        let up = Ramp { value: 1.0, slope: 2.0, end: 2.0 };
        assert_eq!([0.0, 0.25, 9.0].map(|t| up.at(t)), [1.0, 1.5, 2.0]);
        let down = Ramp { value: 1.0, slope: -2.0, end: -1.0 };
        assert_eq!([0.0, 0.5, 9.0].map(|t| down.at(t)), [1.0, 0.0, -1.0]);
        assert_eq!(Ramp::constant(3.0).at(1e9), 3.0);
    }
}
