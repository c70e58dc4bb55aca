//! Loading plates, walls and rigid bodies that a program moves instead of the programme of the test.

use super::specimen::{DRIFT, LATERAL};
use super::{MpmTest, Phase, State, dimensions};
use ::engine::boundary::Drive;
use ::engine::mpm::{PlateDrive, Ramp};

impl State {
    /// Ends the programme of a test: strains count from here on if it was still settling, and the friction of the preparation gives way to that of the materials.
    pub fn take_over(&mut self, rig: &MpmTest) {
        if self.phase == Phase::Settle {
            (self.phase_time, self.extents) = (0.0, self.extents_now(rig));
            if let Some(mixture) = &mut self.mixture {
                mixture.grains.friction = None;
            }
        }
        self.phase = Phase::Load;
    }

    /// Sets the motion of each loading plate for the next step to what a program has told it. A plate that holds a stress has the gain and, unless one is told, the largest speed of the test's
    /// own lateral plates.
    pub fn obey(&mut self, rig: &MpmTest, told: &[Drive]) {
        let Some(specimen) = rig.specimen() else { return };
        let extents = self.extents_now(rig);
        self.drives = self
            .plates
            .iter()
            .zip(told)
            .map(|(plate, drive)| match *drive {
                Drive::Fixed | Drive::Programme => PlateDrive::Speed(Ramp::constant(0.0)),
                Drive::Velocity(v) => PlateDrive::Speed(Ramp::constant(v)),
                Drive::Stress { stress, gain, fastest, .. } => PlateDrive::Stress {
                    target: Ramp::constant(stress),
                    gain: if gain == 0.0 { specimen.gain } else { gain },
                    reach: fastest.map_or(0.5 * LATERAL * self.rate, |v| v / extents[plate.axis()]),
                    memory: DRIFT * self.wave,
                },
            })
            .collect();
    }

    /// Lets a wall of a free scene move as told from the next step on.
    pub fn drive_wall(&mut self, wall: usize, drive: Drive) {
        let Some(wall) = self.mixture.as_mut().and_then(|m| m.grains.walls.get_mut(wall)) else { return };
        wall.drive = drive;
        // the speed of a wall that holds a stress is set at each step
        wall.speed = if let Drive::Velocity(v) = drive { v } else { 0.0 };
    }

    /// Lets the driven rigid body `body` move at a velocity, m/s, and a spin, rad/s, from the next step on.
    pub fn drive_body(&mut self, body: usize, velocity: [f64; 3], spin: [f64; 3]) {
        if let Some(blocks) = self.mixture.as_mut().and_then(|m| m.blocks.as_mut()) {
            blocks.drive_at(body, velocity, spin);
        }
    }

    /// Volume of the specimen, m³ (m² in plane strain); `None` in a free scene.
    pub fn volume(&self, rig: &MpmTest) -> Option<f64> {
        let extents = self.extents_now(rig);
        rig.specimen().map(|s| s.fullness() * extents[..dimensions(rig)].iter().product::<f64>())
    }
}
