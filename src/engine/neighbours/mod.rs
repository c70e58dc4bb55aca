//! Who may touch whom: a local Verlet scheme without global rebuilds.
//!
//! Pairs that touch have a slot among the contacts, with their forces and history; pairs that are only near are listed apart (`near.rs`)
//! and change over when they meet or part.
//!
//! Every grain has a *reference*: the position and reach (radius + skin) it had when its own neighbourhood was last searched.
//! A pair is listed exactly while it touches or its two reference spheres of reach overlap, so no contact can be missed until one of the two has
//! moved by more than its skin; then that grain alone is searched again. Skins are in proportion to the radius, so
//! that a fast small fragment costs its own search and nothing else, and a breakage costs the daughters' searches.
//! What the lists hold beyond touching pairs never reaches a result.

pub mod adjacency;
mod grid;
mod near;

use crate::boundary::Wall;
use crate::boundary::WallShape;
use crate::contact::pairs::{FREE, Pairs};
use crate::grains::Grains;
use crate::math::real::{Four, Plain};
use adjacency::{Adjacency, Entry};
use grid::CellGrid;
use near::Near;

/// The lists. Scratch: can be dropped and made again from the state at any time without changing a bit of the results.
pub struct Neighbours {
    /// Skin over radius.
    skin: f64,
    /// Reference position and reach.
    reference: Vec<Reference>,
    grid: CellGrid,
    near: Near,
    /// All listed grains around each grain, near or touching.
    around: Adjacency,
    /// The contacts of each grain, and the walls near it: what it sums.
    pub contacts: Adjacency,
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
    /// Lists for the state as it is, with the contacts it has.
    pub fn new(g: &Grains, walls: &[Wall], pools: &mut Pools<'_>, skin: f64) -> Neighbours {
        let reference: Vec<Reference> = g.pos.iter().map(|p| Self::reference(p, skin)).collect();
        let mean_radius = g.pos.iter().map(|p| p[3]).sum::<f64>() / g.len().max(1) as f64;
        let mut n = Neighbours {
            skin,
            grid: CellGrid::new(&reference),
            reference,
            near: Near::default(),
            around: Adjacency::default(),
            contacts: Adjacency::default(),
            wall_reference: walls.iter().map(|w| w.shape).collect(),
            wall_skin: skin * mean_radius,
            wall_lists: vec![Vec::new(); walls.len()],
            found: Vec::new(),
            gone: Vec::new(),
            searches: 0,
        };
        n.list_slots(g, pools);
        for i in 0..g.len() {
            n.search(i, g, pools.wall_pairs);
        }
        n.searches = 0;
        n
    }

    /// Makes the grains' and walls' lists from the slots there are.
    fn list_slots(&mut self, g: &Grains, pools: &Pools<'_>) {
        let used = |(slot, e): (usize, &[u32; 2])| (e[0] != FREE).then_some((slot as u32, *e));
        let pairs = pools.pairs.ends.iter().enumerate().filter_map(used);
        let walls = pools.wall_pairs.ends.iter().enumerate().filter_map(used);
        let touching = pairs.flat_map(|(slot, [i, j])| {
            let end = |k: u32, other: u32, second| (k, Entry::grain(g.id[other as usize], slot, second));
            [end(i, j, false), end(j, i, true)]
        });
        let apart = self.near.pairs().flat_map(|(slot, [i, j])| {
            let end = |k: u32, other: u32| (k, Entry::apart(g.id[other as usize], slot as u32));
            [end(i, j), end(j, i)]
        });
        self.around.fill(g.len(), touching.clone().chain(apart));
        self.contacts.fill(g.len(), touching.chain(walls.clone().map(|(slot, [i, k])| (i, Entry::wall(k, slot)))));
        for l in &mut self.wall_lists {
            l.clear();
        }
        for (slot, [i, k]) in walls {
            self.wall_lists[k as usize].push((g.id[i as usize], slot));
        }
        for l in &mut self.wall_lists {
            l.sort_unstable();
        }
    }

    /// Searches the neighbourhoods of the grains listed, and of walls that have moved by more than their skin. All references are
    /// taken before any search, so that each is done with the latest. Contacts are neither read nor changed: this may run beside their sweep.
    pub fn update(&mut self, moved: &[u32], g: &Grains, walls: &[Wall], wall_pairs: &mut Pairs) {
        for &i in moved {
            self.set_reference(i as usize, g);
        }
        for (k, wall) in walls.iter().enumerate() {
            if wall.moved_since(&self.wall_reference[k]) > self.wall_skin {
                self.wall_reference[k] = wall.shape;
                for i in 0..g.len() {
                    self.search_wall(i, k, g, wall_pairs);
                }
            }
        }
        for &i in moved {
            self.search(i as usize, g, wall_pairs);
        }
    }

    /// Takes a grain's present position as its reference and searches its neighbourhood.
    pub fn refresh(&mut self, i: usize, g: &Grains, wall_pairs: &mut Pairs) {
        self.set_reference(i, g);
        self.search(i, g, wall_pairs);
    }

    fn set_reference(&mut self, i: usize, g: &Grains) {
        self.reference[i] = Self::reference(&g.pos[i], self.skin);
        self.grid.place(i, &self.reference);
    }

    fn reference(p: &[f64; 4], skin: f64) -> Reference {
        let centre = [p[0] as f32, p[1] as f32, p[2] as f32];
        let rounding = (0..3).map(|a| (p[a] - f64::from(centre[a])).abs()).sum::<f64>();
        let reach = (p[3] * (1.0 + skin) + rounding) as f32;
        [centre[0], centre[1], centre[2], reach.next_up()]
    }

    /// Whether a grain (centre, radius) has left its reference sphere of reach.
    #[inline(always)]
    pub fn has_left<F: Four>(reference: &Reference, p: F, token: F::Token) -> bool {
        let [x, y, z, growth] = (p - F::of(token, reference.map(f64::from))).xyzw();
        // the skin that is left is the reach less the radius
        growth >= 0.0 || x * x + y * y + z * z > growth * growth
    }

    /// Whether grain `i`, whose radius has changed, has left its sphere.
    pub fn outgrown(&self, i: usize, g: &Grains) -> bool {
        Self::has_left(&self.reference[i], Plain::of((), g.pos[i]), ())
    }

    /// After a change of radii: in `moved` the grains that have left their spheres.
    pub fn account_for_growth(&self, g: &Grains, moved: &mut Vec<u32>) {
        moved.clear();
        moved.extend((0..g.len() as u32).filter(|&i| self.outgrown(i as usize, g)));
    }

    /// References of all grains, for the pass that moves them.
    pub fn references(&self) -> &[Reference] {
        &self.reference
    }

    /// A grain was appended to the arrays.
    pub fn append(&mut self, i: usize, g: &Grains, wall_pairs: &mut Pairs) {
        self.reference.push([0.0; 4]);
        self.around.append();
        self.contacts.append();
        self.grid.append();
        debug_assert_eq!(self.reference.len(), i + 1);
        self.refresh(i, g, wall_pairs);
    }

    /// Drops every pair of a grain, with its history.
    pub fn detach(&mut self, i: usize, g: &Grains, pools: &mut Pools<'_>) {
        let mut gone = std::mem::take(&mut self.gone);
        gone.clear();
        gone.extend(self.around.of(i));
        gone.extend(self.contacts.of(i).filter(|e| e.is_wall()));
        for e in &gone {
            if e.is_wall() {
                self.unlink_wall(i, *e, g, pools.wall_pairs);
            } else if e.link.is_apart() {
                self.forget(*e, g);
            } else {
                let [a, b] = pools.pairs.ends[e.slot()];
                for (k, other) in [(a as usize, b as usize), (b as usize, a as usize)] {
                    self.around.remove(k, g.id[other]);
                    self.contacts.remove(k, g.id[other]);
                }
                pools.pairs.remove(e.slot() as u32);
            }
        }
        self.gone = gone;
    }

    /// Drops a near pair.
    fn forget(&mut self, e: Entry, g: &Grains) {
        let [a, b] = self.near.ends(e.slot());
        self.around.remove(a as usize, g.id[b as usize]);
        self.around.remove(b as usize, g.id[a as usize]);
        self.near.remove(e.slot());
    }

    fn unlink_wall(&mut self, i: usize, e: Entry, g: &Grains, wall_pairs: &mut Pairs) {
        self.contacts.remove(i, e.id);
        let list = &mut self.wall_lists[e.wall_index()];
        if let Ok(at) = list.binary_search_by_key(&g.id[i], |&(id, _)| id) {
            list.remove(at);
        }
        wall_pairs.remove(e.slot() as u32);
    }

    /// Index of every grain listed around grain `i`, in the order of ids.
    pub fn around<'a>(&'a self, i: usize, pairs: &'a Pairs) -> impl Iterator<Item = (Entry, usize)> + 'a {
        self.around.of(i).map(move |e| {
            let [a, b] = if e.link.is_apart() { self.near.ends(e.slot()) } else { pairs.ends[e.slot()] };
            (e, if a as usize == i { b } else { a } as usize)
        })
    }

    /// Marks the near pairs that touch now, so many to a parallel task: reads positions only, so that it may run beside the sweep.
    pub fn activate_contacts(&mut self, pos: &[[f64; 4]], task: usize) {
        self.near.activate_contacts(pos, task);
    }

    /// Makes contacts of the pairs marked; their slots are in `slots`.
    pub fn begin_contacts(&mut self, g: &Grains, pairs: &mut Pairs, slots: &mut Vec<u32>) {
        self.near.met(slots);
        for s in slots {
            let [i, j] = self.near.ends(*s as usize);
            self.near.remove(*s as usize);
            *s = pairs.add(i, j);
            for (k, other, second) in [(i as usize, j as usize, false), (j as usize, i as usize, true)] {
                let e = Entry::grain(g.id[other], *s, second);
                self.around.relink(k, e);
                self.contacts.insert(k, e);
            }
        }
    }

    /// Ends the contacts of grain `i` that have parted; the pairs stay listed.
    pub fn end_contacts(&mut self, i: usize, g: &Grains, pairs: &mut Pairs) {
        let mut gone = std::mem::take(&mut self.gone);
        gone.clear();
        gone.extend(self.contacts.of(i).filter(|e| !e.is_wall() && pairs.touch[e.slot()].overlap == 0.0));
        for e in &gone {
            let [a, b] = pairs.ends[e.slot()];
            pairs.remove(e.slot() as u32);
            let slot = self.near.add(a, b);
            for (k, other) in [(a as usize, b as usize), (b as usize, a as usize)] {
                self.contacts.remove(k, g.id[other]);
                self.around.relink(k, Entry::apart(g.id[other], slot));
            }
        }
        self.gone = gone;
    }

    /// Whether two reference spheres overlap.
    #[inline]
    fn references_overlap(a: &Reference, b: &Reference) -> bool {
        let (a, b) = (a.map(f64::from), b.map(f64::from));
        let (x, y, z) = (a[0] - b[0], a[1] - b[1], a[2] - b[2]);
        let reach = a[3] + b[3];
        x * x + y * y + z * z < reach * reach
    }

    fn search(&mut self, i: usize, g: &Grains, wall_pairs: &mut Pairs) {
        self.searches += 1;
        let here = self.reference[i];
        let mut gone = std::mem::take(&mut self.gone);
        gone.clear();
        // contacts stay: the other's reference may be the older one
        gone.extend(self.around.of(i).filter(|e| {
            e.link.is_apart() && {
                let [a, b] = self.near.ends(e.slot());
                !Self::references_overlap(&self.reference[a as usize], &self.reference[b as usize])
            }
        }));
        for e in &gone {
            self.forget(*e, g);
        }
        self.gone = gone;

        let mut found = std::mem::take(&mut self.found);
        found.clear();
        self.grid.for_each_near(&here, |j| {
            if j as usize != i && Self::references_overlap(&here, &self.reference[j as usize]) {
                found.push(j);
            }
        });
        for &j in &found {
            let j = j as usize;
            if !self.around.contains(i, g.id[j]) {
                let (first, second) = if g.id[i] < g.id[j] { (i, j) } else { (j, i) };
                let slot = self.near.add(first as u32, second as u32);
                self.around.insert(i, Entry::apart(g.id[j], slot));
                self.around.insert(j, Entry::apart(g.id[i], slot));
            }
        }
        self.found = found;
        for k in 0..self.wall_reference.len() {
            self.search_wall(i, k, g, wall_pairs);
        }
    }

    fn search_wall(&mut self, i: usize, k: usize, g: &Grains, wall_pairs: &mut Pairs) {
        let (_, gap) = self.wall_reference[k].towards(self.reference[i].map(f64::from));
        let entry = Entry::wall(k as u32, 0);
        let has = self.contacts.contains(i, entry.id);
        if gap < self.wall_skin && !has {
            let slot = wall_pairs.add(i as u32, k as u32);
            self.contacts.insert(i, Entry::wall(k as u32, slot));
            let list = &mut self.wall_lists[k];
            let at = list.partition_point(|&(id, _)| id < g.id[i]);
            list.insert(at, (g.id[i], slot));
        } else if gap >= self.wall_skin && has {
            let e = self.contacts.find(i, entry.id).expect("contained");
            if wall_pairs.touch[e.slot()].overlap <= 0.0 {
                self.unlink_wall(i, e, g, wall_pairs);
            }
        }
    }

    /// After grains and slots were permuted: `order` is the grains' new order, `place` the new index of each.
    pub fn permute(&mut self, order: &[u32], place: &[u32], g: &Grains, pools: &Pools<'_>) {
        self.near.permute(place);
        self.reference = order.iter().map(|&i| self.reference[i as usize]).collect();
        self.grid = CellGrid::new(&self.reference);
        self.list_slots(g, pools);
        self.searches = 0;
    }

    /// Number of pairs listed that do not touch.
    pub fn near_pairs(&self) -> usize {
        self.near.len()
    }

    /// Bytes held.
    pub fn bytes(&self) -> usize {
        self.reference.capacity() * size_of::<Reference>()
            + self.grid.bytes()
            + self.near.bytes()
            + self.around.bytes()
            + self.contacts.bytes()
            + self.wall_lists.iter().map(|l| l.capacity() * 8).sum::<usize>()
    }
}

/// Calls `each` with the index and value of every flag that is not zero.
pub fn flagged(flags: &[u8], mut each: impl FnMut(u32, u8)) {
    let (chunks, rest) = flags.as_chunks::<8>();
    for (c, chunk) in chunks.iter().enumerate() {
        if u64::from_ne_bytes(*chunk) != 0 {
            for (k, &f) in chunk.iter().enumerate().filter(|(_, f)| **f != 0) {
                each((8 * c + k) as u32, f);
            }
        }
    }
    for (k, &f) in rest.iter().enumerate().filter(|(_, f)| **f != 0) {
        each((8 * chunks.len() + k) as u32, f);
    }
}
