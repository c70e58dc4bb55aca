//! Which passes a step has, in which order, and of how many workgroups: what `passes.rs` encodes and `work.rs` counts.

use super::bounds::{BLOCK, BORDERS, GROUP};
use super::layout::{cell_groups, groups, rows};

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
    /// Whether points have different laws.
    pub several_laws: bool,
    /// Blocks of the grid: slots in use, and all.
    pub blocks: [u32; 2],
    /// Cells of the domain along each axis.
    pub size: [u32; 3],
    /// Kind of the wall on each side of the domain; 0: none.
    pub walls: [u32; 6],
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
    /// Number of cells, and of nodes, that there is memory for.
    fn cells(&self) -> u32 {
        (BLOCK as u32).saturating_mul(self.blocks[1])
    }

    /// A pass with a workgroup for each block.
    fn blocks(&self, pass: &'static str) -> Dispatch {
        Dispatch { pass, groups: rows(self.blocks[1]) }
    }

    /// What must be computed before the first step: order of the points, velocities of the nodes, forces on loading plates and grains.
    pub fn prepare(&self) -> Vec<Dispatch> {
        let mut all = self.order();
        all.push(self.of_nodes("project", 0));
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
        all.push(self.blocks("press_nodes"));
        all.push(self.of_nodes("accelerate", self.grains.map_or(0, |g| g.grains)));
        all.push(threads("advance", self.points));
        all.extend(self.order());
        all.push(self.of_nodes("project", 0));
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

    /// Puts the points in the order of cells, if one of them has moved to another cell, and gives their mass and momentum to the nodes.
    fn order(&self) -> Vec<Dispatch> {
        let starts = Dispatch { pass: "find_starts", groups: [cell_groups(self.cells()), 1] };
        vec![starts, threads("scatter", self.points), self.blocks("deposit")]
    }

    /// A pass over the nodes with so many `more` threads.
    fn of_nodes(&self, pass: &'static str, more: u32) -> Dispatch {
        threads(pass, self.cells().saturating_add(more))
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

/// The passes that runs use, with or without loading plates and grains, each once.
pub fn passes(plates: bool, grains: bool) -> Vec<&'static str> {
    // a run may find by itself that its grains need several steps
    let grains = grains.then_some(GrainExtent { grains: 1, rows: 1, rates: 2 });
    let extent =
        Extent { points: 1, several_laws: false, blocks: [1; 2], size: [1; 3], walls: [0; BORDERS], plates: plates.into(), grains };
    let mut all = Vec::new();
    for dispatch in [extent.prepare(), extent.begin(), extent.step()].concat() {
        if !all.contains(&dispatch.pass) {
            all.push(dispatch.pass);
        }
    }
    all
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Nine dispatches, whatever the walls of the grid are, and one more for loading plates; with grains four more, and six for each further step
    /// of the grains.
    #[test]
    fn a_step_has_few_dispatches() {
        let count = |plates, rates: Option<u32>| {
            let grains = rates.map(|rates| GrainExtent { grains: 10, rows: 200, rates });
            Extent { points: 1000, several_laws: false, blocks: [20, 30], size: [6; 3], walls: [3; 6], plates, grains }.step().len()
        };
        assert_eq!([0, 1, 6].map(|plates| count(plates, None)), [9, 10, 10]);
        assert_eq!([1, 2, 5].map(|rates| count(0, Some(rates))), [13, 19, 37]);
        assert_eq!(count(6, Some(1)), 14);
    }

    #[test]
    fn a_run_has_the_passes_that_it_uses() {
        let [alone, all] = [false, true].map(|with| passes(with, with));
        assert_eq!([alone.len(), all.len()], [10, 19]);
        assert!(!alone.contains(&"plate_forces") && all.contains(&"plate_forces") && all.contains(&"move_grains"));
    }
}
