//! Cells for the search of neighbours, in several levels: each grain is in the level whose cells fit its reach. Levels differ by a factor of two, so
//! the cost of a search does not depend on the ratio of grain sizes. A cell is a linked list; the number of cells follows the number of grains,
//! not the size of the box.

use super::Reference;

/// No grain, no cell.
const NONE: u32 = u32::MAX;

/// The cells of one level.
struct Level {
    /// Largest reach of a grain of this level, m.
    reach: f64,
    /// 1 / edge of a cell, 1/m.
    inverse: f64,
    /// Number of cells along x, y, z.
    dims: [usize; 3],
    /// First grain of each cell's list.
    heads: Vec<u32>,
    /// Number of grains in this level.
    count: usize,
    /// Number of grains for which the cells were made; at four times as many they are made anew.
    capacity: usize,
}

/// Grains by cells, for searches of what is near a grain.
pub struct CellGrid {
    /// Lower corner of the box, m. Grains beyond the box are in its outermost cells.
    low: [f64; 3],
    /// Extents of the box, m.
    size: [f64; 3],
    /// Levels from the largest grains to the smallest.
    levels: Vec<Level>,
    /// Largest reach of level 1, m; level 0 holds all grains above.
    base: f64,
    /// Next grain in the list of the same cell.
    next: Vec<u32>,
    /// Grain before in the list of the same cell.
    previous: Vec<u32>,
    /// Level and cell of each grain; `NONE`: in no cell.
    home: Vec<(u32, u32)>,
}

impl Level {
    /// A level for grains up to the reach `reach`, m, in a box of extents `size`, with at most about four cells for each of `grains` grains.
    fn new(reach: f64, size: &[f64; 3], grains: usize) -> Level {
        let mut cell = 2.0 * reach;
        let capacity = (grains * 2).max(64);
        let cells = |cell: f64| size.map(|s| (s / cell).ceil().clamp(1.0, 1e6));
        while cells(cell).iter().product::<f64>() > (2 * capacity) as f64 {
            cell *= 1.25;
        }
        let dims = cells(cell).map(|c| c as usize);
        Level { reach, inverse: 1.0 / cell, dims, heads: vec![NONE; dims.iter().product()], count: 0, capacity }
    }

    /// Cell coordinate along one axis, clamped to the box (monotone, so searches with clamped bounds miss nothing).
    fn coordinate(&self, axis: usize, x: f64, low: f64) -> usize {
        (((x - low) * self.inverse) as i64).clamp(0, self.dims[axis] as i64 - 1) as usize
    }

    /// Index of the cell that holds a centre.
    fn cell(&self, p: &Reference, low: &[f64; 3]) -> usize {
        let c: [usize; 3] = std::array::from_fn(|a| self.coordinate(a, f64::from(p[a]), low[a]));
        (c[2] * self.dims[1] + c[1]) * self.dims[0] + c[0]
    }
}

impl CellGrid {
    /// A grid around the given reference spheres (x, y, z, reach), with all of them in their cells.
    pub fn new(reference: &[Reference]) -> CellGrid {
        let mut low = [f64::INFINITY; 3];
        let mut high = [f64::NEG_INFINITY; 3];
        let mut largest = 0.0f64;
        // a grain whose position is not finite (the run's watchdog will report it) does not count for the extents
        for p in reference.iter().filter(|p| p.iter().all(|x| x.is_finite())) {
            let p = p.map(f64::from);
            for a in 0..3 {
                low[a] = low[a].min(p[a]);
                high[a] = high[a].max(p[a]);
            }
            largest = largest.max(p[3]);
        }
        if largest == 0.0 {
            (low, high, largest) = ([0.0; 3], [1.0; 3], 1.0);
        }
        let size = std::array::from_fn(|a| (high[a] - low[a]).max(largest));
        let n = reference.len();
        let mut grid = CellGrid {
            low,
            size,
            levels: vec![Level::new(largest * 1.0001, &size, n)],
            base: 0.5 * largest,
            next: vec![NONE; n],
            previous: vec![NONE; n],
            home: vec![(NONE, NONE); n],
        };
        for i in 0..n {
            grid.place(i, reference);
        }
        grid
    }

    /// Makes room for one more grain, in no cell yet.
    pub fn append(&mut self) {
        self.next.push(NONE);
        self.previous.push(NONE);
        self.home.push((NONE, NONE));
    }

    /// Level for a reach, m: level 0 takes all above `base`, each further level down to half of the reach of the one before. Levels are added as grains
    /// get smaller; a reach above that of level 0 makes all levels anew.
    fn level(&mut self, reach: f64, reference: &[Reference]) -> usize {
        if reach > self.levels[0].reach {
            self.widen(reach * 1.25, reference);
        }
        let (mut l, mut bound) = (0, self.base);
        while reach <= bound && l < 40 {
            l += 1;
            if l == self.levels.len() {
                self.levels.push(Level::new(bound, &self.size, 64));
            }
            bound *= 0.5;
        }
        l
    }

    /// Puts grain `i` into the cell of its reference centre.
    pub fn place(&mut self, i: usize, reference: &[Reference]) {
        let l = self.level(f64::from(reference[i][3]), reference);
        let cell = self.levels[l].cell(&reference[i], &self.low) as u32;
        if self.home[i] == (l as u32, cell) {
            return;
        }
        self.unplace(i);
        self.link(i, l, cell);
        if self.levels[l].count > 4 * self.levels[l].capacity {
            self.rebuild(l, reference);
        }
    }

    /// Puts grain `i` at the head of the list of a cell of level `l`.
    fn link(&mut self, i: usize, l: usize, cell: u32) {
        let level = &mut self.levels[l];
        let head = level.heads[cell as usize];
        self.next[i] = head;
        self.previous[i] = NONE;
        if head != NONE {
            self.previous[head as usize] = i as u32;
        }
        level.heads[cell as usize] = i as u32;
        level.count += 1;
        self.home[i] = (l as u32, cell);
    }

    /// Takes grain `i` out of its cell, if it is in one.
    fn unplace(&mut self, i: usize) {
        let (l, cell) = self.home[i];
        if l == NONE {
            return;
        }
        let (before, after) = (self.previous[i], self.next[i]);
        let level = &mut self.levels[l as usize];
        match before {
            NONE => level.heads[cell as usize] = after,
            b => self.next[b as usize] = after,
        }
        if after != NONE {
            self.previous[after as usize] = before;
        }
        level.count -= 1;
        self.home[i] = (NONE, NONE);
    }

    /// Makes all levels anew for reaches up to `largest`, m. If the bounds of the levels stayed while grains grow, small grains would be in the cells
    /// of large ones.
    fn widen(&mut self, largest: f64, reference: &[Reference]) {
        let placed: Vec<usize> = (0..self.home.len()).filter(|&i| self.home[i].0 != NONE).collect();
        self.home.fill((NONE, NONE));
        self.levels = vec![Level::new(largest, &self.size, placed.len())];
        self.base = 0.5 * largest;
        for i in placed {
            self.place(i, reference);
        }
    }

    /// Makes the cells of level `l` anew, for the number of grains that it has now.
    fn rebuild(&mut self, l: usize, reference: &[Reference]) {
        let members: Vec<usize> = (0..self.home.len()).filter(|&i| self.home[i].0 == l as u32).collect();
        self.levels[l] = Level::new(self.levels[l].reach, &self.size, members.len());
        for i in members {
            let cell = self.levels[l].cell(&reference[i], &self.low) as u32;
            self.link(i, l, cell);
        }
    }

    /// Calls `visit` with the index of every grain whose cell may hold a grain whose reference sphere overlaps the sphere `here` (centre and reach).
    #[inline]
    pub fn for_each_near(&self, here: &Reference, mut visit: impl FnMut(u32)) {
        let here = here.map(f64::from);
        for level in &self.levels {
            if level.count == 0 {
                continue;
            }
            let reach = here[3] + level.reach;
            let from: [usize; 3] = std::array::from_fn(|a| level.coordinate(a, here[a] - reach, self.low[a]));
            let to: [usize; 3] = std::array::from_fn(|a| level.coordinate(a, here[a] + reach, self.low[a]));
            for z in from[2]..=to[2] {
                for y in from[1]..=to[1] {
                    let row = (z * level.dims[1] + y) * level.dims[0];
                    for &head in &level.heads[row + from[0]..=row + to[0]] {
                        let mut j = head;
                        while j != NONE {
                            visit(j);
                            j = self.next[j as usize];
                        }
                    }
                }
            }
        }
    }

    /// Memory in use, bytes.
    pub fn bytes(&self) -> usize {
        self.next.capacity() * 16 + self.levels.iter().map(|l| l.heads.capacity() * 4).sum::<usize>()
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Grains on a lattice, every hundredth five times as large, at `scale` of their size.
    fn lattice(scale: f32) -> Vec<Reference> {
        let at = |k: usize| [k % 20, k / 20 % 20, k / 400].map(|c| c as f32);
        let reach = |k: usize| scale * if k.is_multiple_of(100) { 2.5 } else { 0.5 };
        (0..8000).map(|k| [at(k)[0], at(k)[1], at(k)[2], reach(k)]).collect()
    }

    fn visits(grid: &CellGrid, reference: &[Reference]) -> usize {
        let mut visits = 0;
        reference.iter().for_each(|r| grid.for_each_near(r, |_| visits += 1));
        visits
    }

    #[test]
    fn a_search_costs_no_more_after_grains_have_grown() {
        let mut reference = lattice(0.35);
        let mut grown = CellGrid::new(&reference);
        for step in 36..=100 {
            for (i, larger) in lattice(0.01 * step as f32).into_iter().enumerate() {
                reference[i] = larger;
                grown.place(i, &reference);
            }
        }
        let (anew, grown) = (visits(&CellGrid::new(&reference), &reference), visits(&grown, &reference));
        assert!(2 * grown < 3 * anew, "{grown} against {anew} of a new grid");
    }
}
