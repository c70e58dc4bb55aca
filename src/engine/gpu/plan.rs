//! Which passes a step has, in which order, and of how many workgroups: what `passes.rs` encodes and `work.rs` counts.

use super::bounds::GROUP;
use super::layout::{cell_groups, groups};

/// One dispatch: the entry point of the shaders, and its numbers of workgroups along x and y.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Dispatch {
    pub pass: &'static str,
    pub groups: [u32; 2],
}

/// Numbers of what the passes go through.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Extent {
    pub points: u32,
    /// Cells of the domain along each axis.
    pub size: [u32; 3],
    /// Sides of the domain that have a wall.
    pub walls: [bool; 6],
    pub plates: u32,
    pub grains: Option<GrainExtent>,
}

/// Numbers of grains, of points close to them that there is room for, and of their steps in a step of the continuum.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct GrainExtent {
    pub grains: u32,
    pub rows: u32,
    pub rates: u32,
}

/// A pass of one workgroup.
fn alone(pass: &'static str) -> Dispatch {
    Dispatch { pass, groups: [1, 1] }
}

/// A pass of so many threads.
fn threads(pass: &'static str, threads: u32) -> Dispatch {
    Dispatch { pass, groups: groups(threads) }
}

impl Extent {
    /// Number of cells about nodes.
    pub fn cells(&self) -> u32 {
        self.count(1)
    }

    /// Number of nodes.
    pub fn nodes(&self) -> u32 {
        self.count(3)
    }

    /// Product of the cells along each axis and so many `more`; no device has a grid whose nodes do not fit into 32 bits.
    fn count(&self, more: u32) -> u32 {
        let all = self.size.iter().map(|n| u128::from(*n) + u128::from(more)).product::<u128>();
        u32::try_from(all).unwrap_or(u32::MAX)
    }

    /// What must be computed before the first step: order of the points, velocities of the nodes, forces on loading plates and grains.
    pub fn prepare(&self) -> Vec<Dispatch> {
        let mut all = self.order();
        all.extend(self.of_nodes("project", "walls_project", 0));
        if self.plates > 0 {
            all.extend([threads("plate_forces", self.points), alone("plate_loads")]);
        }
        if let Some(grains) = &self.grains {
            all.push(alone("build_grid"));
            all.extend(self.grain_forces(grains));
        }
        all.extend(self.survey());
        all
    }

    /// What begins the first step of a batch; the end of a step begins the next one.
    pub fn begin(&self) -> Vec<Dispatch> {
        if self.plates > 0 || self.grains.is_some() { vec![alone("drive")] } else { Vec::new() }
    }

    /// One step, in the order of mpm/step.rs; it begins with the forces known and ends with those of the new positions.
    pub fn step(&self) -> Vec<Dispatch> {
        let mut all = Vec::new();
        if let Some(grains) = &self.grains {
            for _ in 1..grains.rates {
                all.extend([threads("move_grains", grains.grains), alone("build_grid")]);
                all.extend(self.grain_forces(grains));
            }
        }
        all.extend(self.of_nodes("accelerate", "walls_accelerate", self.grains.map_or(0, |g| g.grains)));
        all.push(threads("advance", self.points));
        all.extend(self.order());
        all.extend(self.of_nodes("project", "walls_project", 0));
        all.push(threads("strain", self.points));
        if self.plates > 0 {
            all.push(threads("plate_forces", self.points));
        }
        all.push(alone("finish"));
        if let Some(grains) = &self.grains {
            all.extend(self.grain_forces(grains));
        }
        all
    }

    /// The largest speed of waves and points, at the end of a batch.
    pub fn survey(&self) -> Vec<Dispatch> {
        vec![threads("survey", self.points)]
    }

    /// Puts the points in the order of cells, if one of them has moved to another cell.
    fn order(&self) -> Vec<Dispatch> {
        let starts = Dispatch { pass: "find_starts", groups: [cell_groups(self.cells()), 1] };
        vec![starts, threads("scatter", self.points), threads("sort", self.cells())]
    }

    /// A pass over the nodes with so many `more` threads, and that over the walls.
    fn of_nodes(&self, pass: &'static str, walls: &'static str, more: u32) -> Vec<Dispatch> {
        let mut all = vec![threads(pass, self.nodes().saturating_add(more))];
        if self.walls.contains(&true) {
            all.push(alone(walls));
        }
        all
    }

    /// Forces on the grains and contacts with points, after each step of the grains: lists of candidates where they are due, then contacts.
    fn grain_forces(&self, of: &GrainExtent) -> [Dispatch; 4] {
        [
            threads("candidates", self.points.saturating_add(of.grains)),
            threads("point_contact_forces", of.rows),
            threads("grain_forces", (GROUP as u32).saturating_mul(of.grains)),
            alone("step_bound"),
        ]
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Ten dispatches between the walls of a grid and nine between loading plates, with grains four more, and six for each further step of the grains.
    #[test]
    fn a_step_has_few_dispatches() {
        let count = |walls, plates, rates: Option<u32>| {
            let grains = rates.map(|rates| GrainExtent { grains: 10, rows: 200, rates });
            Extent { points: 1000, size: [6; 3], walls: [walls; 6], plates, grains }.step().len()
        };
        assert_eq!([count(true, 0, None), count(false, 6, None), count(true, 1, None)], [10, 9, 11]);
        assert_eq!([1, 2, 5].map(|rates| count(true, 0, Some(rates))), [14, 20, 38]);
        assert_eq!(count(false, 6, Some(1)), 13);
    }
}
