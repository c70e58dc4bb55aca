//! Who may touch whom: a local Verlet scheme without global rebuilds.
//!
//! Every grain has a *reference*: the position and reach (radius + skin) it had when its own neighbourhood was last searched.
//! A pair has a slot exactly while the two reference spheres of reach overlap, so no contact can be missed until one of the two has
//! moved by more than its skin; then that grain alone is searched again. Skins are in proportion to the radius, so
//! that a fast small fragment costs its own search and nothing else, and a breakage costs the daughters' searches.
//! What the lists hold beyond touching pairs never reaches a result.

pub mod adjacency;
mod grid;

use crate::boundary::Wall;
use crate::contact::pairs::{FREE, Pairs};
use crate::grains::Grains;
use crate::model::WallShape;
use adjacency::{Adjacency, Entry};
use grid::Grid;

/// The lists. Scratch: can be dropped and made again from the state at any time without changing a bit of the results.
pub struct Neighbours {
    /// Skin over radius.
    skin: f64,
    /// Reference position and reach.
    reference: Vec<Reference>,
    grid: Grid,
    pub adjacency: Adjacency,
    wall_reference: Vec<WallShape>,
    wall_skin: f64,
    /// Contacts of each wall in the order of grain ids: (grain id, slot).
    pub wall_lists: Vec<Vec<(u32, u32)>>,
    found: Vec<u32>,
    gone: Vec<Entry>,
    /// Local searches since the last re-ordering.
    pub searches: u64,
}

/// Centre x, y, z and reach of a grain when its neighbourhood was last searched, m. Single precision halves what every step reads; no
/// result depends on it, and the reach makes up for what rounding took from the centre.
pub type Reference = [f32; 4];

/// The contact pools the lists look after.
pub struct Pools<'a> {
    pub pairs: &'a mut Pairs,
    pub wall_pairs: &'a mut Pairs,
}

impl Neighbours {
    /// Lists for the state as it is: the pairs it has are kept with their history, missing ones are added.
    pub fn new(g: &Grains, walls: &[Wall], pools: &mut Pools<'_>, skin: f64) -> Neighbours {
        let reference: Vec<Reference> = g.pos.iter().map(|p| Self::reference(p, skin)).collect();
        let mean_radius = g.pos.iter().map(|p| p[3]).sum::<f64>() / g.len().max(1) as f64;
        let mut n = Neighbours {
            skin,
            grid: Grid::new(&reference),
            reference,
            adjacency: Adjacency::default(),
            wall_reference: walls.iter().map(|w| w.shape).collect(),
            wall_skin: skin * mean_radius,
            wall_lists: vec![Vec::new(); walls.len()],
            found: Vec::new(),
            gone: Vec::new(),
            searches: 0,
        };
        n.adopt(g, pools);
        for i in 0..g.len() {
            n.search(i, g, pools);
        }
        n.searches = 0;
        n
    }

    /// Makes adjacency and wall lists from the slots there are.
    fn adopt(&mut self, g: &Grains, pools: &Pools<'_>) {
        let Pools { pairs, wall_pairs } = pools;
        let used = |ends: &[u32; 2]| ends[0] != FREE;
        let of_grains = pairs.ends.iter().enumerate().filter(|(_, e)| used(e)).flat_map(|(slot, &[i, j])| {
            let end = |k: u32, other: u32, second| (k, Entry::grain(g.id[other as usize], slot as u32, second));
            [end(i, j, false), end(j, i, true)]
        });
        let of_walls = wall_pairs.ends.iter().enumerate().filter(|(_, e)| used(e));
        self.adjacency.fill(g.len(), of_grains.chain(of_walls.clone().map(|(slot, &[i, k])| (i, Entry::wall(k, slot as u32)))));
        for l in &mut self.wall_lists {
            l.clear();
        }
        for (slot, &[i, k]) in of_walls {
            self.wall_lists[k as usize].push((g.id[i as usize], slot as u32));
        }
        for l in &mut self.wall_lists {
            l.sort_unstable();
        }
    }

    /// Searches the neighbourhoods of the grains listed, and of walls that have moved by more than their skin. All references are
    /// taken before any search: against a stale one a touching pair could look far apart and lose its history.
    pub fn update(&mut self, moved: &[u32], g: &Grains, walls: &[Wall], pools: &mut Pools<'_>) {
        for &i in moved {
            self.refer(i as usize, g);
        }
        for (k, wall) in walls.iter().enumerate() {
            if wall.moved_since(&self.wall_reference[k]) > self.wall_skin {
                self.wall_reference[k] = wall.shape;
                for i in 0..g.len() {
                    self.search_wall(i, k, g, pools);
                }
            }
        }
        for &i in moved {
            self.search(i as usize, g, pools);
        }
    }

    /// Takes a grain's present position as its reference and searches its neighbourhood.
    pub fn refresh(&mut self, i: usize, g: &Grains, pools: &mut Pools<'_>) {
        self.refer(i, g);
        self.search(i, g, pools);
    }

    fn refer(&mut self, i: usize, g: &Grains) {
        self.reference[i] = Self::reference(&g.pos[i], self.skin);
        self.grid.place(i, &self.reference);
    }

    fn reference(p: &[f64; 4], skin: f64) -> Reference {
        let centre = [p[0] as f32, p[1] as f32, p[2] as f32];
        let rounding = (0..3).map(|a| (p[a] - f64::from(centre[a])).abs()).sum::<f64>();
        [centre[0], centre[1], centre[2], (p[3] * (1.0 + skin) + rounding) as f32]
    }

    /// Whether a grain (centre, radius) has left its reference sphere of reach.
    #[inline(always)]
    pub fn outside(reference: &Reference, p: &[f64; 4]) -> bool {
        let [x, y, z, reach] = reference.map(f64::from);
        let (x, y, z, left) = (p[0] - x, p[1] - y, p[2] - z, reach - p[3]);
        left <= 0.0 || x * x + y * y + z * z > left * left
    }

    /// After a change of radii: in `moved` the grains that have left their spheres.
    pub fn account_for_growth(&self, g: &Grains, moved: &mut Vec<u32>) {
        moved.clear();
        moved.extend((0..g.len() as u32).filter(|&i| Self::outside(&self.reference[i as usize], &g.pos[i as usize])));
    }

    /// References of all grains, for the pass that moves them.
    pub fn references(&self) -> &[Reference] {
        &self.reference
    }

    /// A grain was appended to the arrays.
    pub fn append(&mut self, i: usize, g: &Grains, pools: &mut Pools<'_>) {
        self.reference.push([0.0; 4]);
        self.adjacency.append();
        self.grid.append();
        debug_assert_eq!(self.reference.len(), i + 1);
        self.refresh(i, g, pools);
    }

    /// Drops every contact of a grain, with its history.
    pub fn detach(&mut self, i: usize, g: &Grains, pools: &mut Pools<'_>) {
        let mut gone = std::mem::take(&mut self.gone);
        gone.clear();
        gone.extend(self.adjacency.of(i));
        for e in &gone {
            self.unlink(i, *e, g, pools);
        }
        self.gone = gone;
    }

    fn unlink(&mut self, i: usize, e: Entry, g: &Grains, pools: &mut Pools<'_>) {
        self.adjacency.remove(i, e.id);
        let slot = e.slot();
        if e.is_wall() {
            let list = &mut self.wall_lists[e.wall_index()];
            if let Ok(at) = list.binary_search_by_key(&g.id[i], |&(id, _)| id) {
                list.remove(at);
            }
            pools.wall_pairs.remove(slot as u32);
        } else {
            let [a, b] = pools.pairs.ends[slot];
            let other = if a as usize == i { b } else { a } as usize;
            self.adjacency.remove(other, g.id[i]);
            pools.pairs.remove(slot as u32);
        }
    }

    /// Whether two reference spheres overlap.
    #[inline]
    fn near(a: &Reference, b: &Reference) -> bool {
        let (a, b) = (a.map(f64::from), b.map(f64::from));
        let (x, y, z) = (a[0] - b[0], a[1] - b[1], a[2] - b[2]);
        let reach = a[3] + b[3];
        x * x + y * y + z * z < reach * reach
    }

    fn search(&mut self, i: usize, g: &Grains, pools: &mut Pools<'_>) {
        self.searches += 1;
        let here = self.reference[i];
        let mut gone = std::mem::take(&mut self.gone);
        gone.clear();
        for e in self.adjacency.of(i) {
            if !e.is_wall() {
                let [a, b] = pools.pairs.ends[e.slot()];
                let other = if a as usize == i { b } else { a } as usize;
                // a touching pair stays until a sweep has ended it: the other's reference may be the older one
                let touches = pools.pairs.touch[e.slot()].overlap > 0.0;
                if !touches && !Self::near(&here, &self.reference[other]) {
                    gone.push(e);
                }
            }
        }
        for e in &gone {
            self.unlink(i, *e, g, pools);
        }
        self.gone = gone;

        let mut found = std::mem::take(&mut self.found);
        found.clear();
        self.grid.for_each_near(&here, |j| {
            if j as usize != i && Self::near(&here, &self.reference[j as usize]) {
                found.push(j);
            }
        });
        for &j in &found {
            let j = j as usize;
            if !self.adjacency.contains(i, g.id[j]) {
                let (first, second) = if g.id[i] < g.id[j] { (i, j) } else { (j, i) };
                let slot = pools.pairs.add(first as u32, second as u32);
                self.adjacency.insert(first, Entry::grain(g.id[second], slot, false));
                self.adjacency.insert(second, Entry::grain(g.id[first], slot, true));
            }
        }
        self.found = found;
        for k in 0..self.wall_reference.len() {
            self.search_wall(i, k, g, pools);
        }
    }

    fn search_wall(&mut self, i: usize, k: usize, g: &Grains, pools: &mut Pools<'_>) {
        let (_, gap) = self.wall_reference[k].towards(self.reference[i].map(f64::from));
        let entry = Entry::wall(k as u32, 0);
        let has = self.adjacency.contains(i, entry.id);
        if gap < self.wall_skin && !has {
            let slot = pools.wall_pairs.add(i as u32, k as u32);
            self.adjacency.insert(i, Entry::wall(k as u32, slot));
            let list = &mut self.wall_lists[k];
            let at = list.partition_point(|&(id, _)| id < g.id[i]);
            list.insert(at, (g.id[i], slot));
        } else if gap >= self.wall_skin && has {
            let e = self.adjacency.find(i, entry.id).expect("contained");
            if pools.wall_pairs.touch[e.slot()].overlap <= 0.0 {
                self.unlink(i, e, g, pools);
            }
        }
    }

    /// After grains and slots were permuted: `order` is the grains' new order.
    pub fn permute(&mut self, order: &[u32], g: &Grains, pools: &Pools<'_>) {
        self.reference = order.iter().map(|&i| self.reference[i as usize]).collect();
        self.grid = Grid::new(&self.reference);
        self.adopt(g, pools);
        self.searches = 0;
    }

    /// Bytes held.
    pub fn bytes(&self) -> usize {
        self.reference.capacity() * size_of::<Reference>()
            + self.grid.bytes()
            + self.adjacency.bytes()
            + self.wall_lists.iter().map(|l| l.capacity() * 8).sum::<usize>()
    }
}
