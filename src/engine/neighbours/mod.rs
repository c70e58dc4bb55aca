//! Lists of the pairs of grains that touch or may touch soon: Verlet lists that are renewed grain by grain, never all at once.
//!
//! Each grain has a *reference sphere*: the centre that it had when its neighbourhood was last searched, and its reach (radius + skin) at that time.
//! A pair is listed exactly while the two grains touch or their reference spheres overlap. So no contact can be missed before a grain has
//! moved by more than its skin; then the neighbourhood of that grain alone is searched again. Skins are in proportion to radii, those of fast grains wider:
//! a small fast fragment costs its own searches only, a breakage those of the daughters.
//!
//! Pairs that touch have a slot among the contacts, with forces and history; listed pairs that do not touch are kept apart (`near.rs`). A pair
//! changes from one to the other when the grains begin or cease to touch. Pairs that do not touch never influence a result.

pub mod adjacency;
mod grid;
mod near;
pub mod overlap;

use crate::boundary::Wall;
use crate::boundary::WallShape;
use crate::contact::pairs::{FREE, Pairs};
use crate::grains::Grains;
use crate::math::real::{Four, Plain};
use crate::math::vector::dot;
use adjacency::Adjacency;
pub(crate) use adjacency::Entry;
use grid::CellGrid;
pub use near::Half;
use near::Near;

/// Grains close to a wall in the order of their identities, as (identity of the grain, slot).
pub type WallList = Vec<(u32, u32)>;

/// Steps for which the skin of a fast grain should last.
const LASTS: f64 = 64.0;
/// Widest skin, over that of a grain at rest.
const WIDEST: f64 = 4.0;

/// The lists of all grains. They can be dropped and made again from the state between any two steps without changing a bit of the results.
pub struct Neighbours {
    /// Skin of a grain at rest over its radius.
    skin: f64,
    /// Time step of the last search, s.
    dt: f64,
    /// Reference sphere of each grain.
    reference: Vec<Reference>,
    /// Reference spheres by cells.
    grid: CellGrid,
    /// Listed pairs that do not touch.
    near: Near,
    /// Of each grain: all grains with which it makes a listed pair, touching or not.
    around: Adjacency,
    /// Of each grain: its contacts with grains, and the walls close to it. These are what it sums.
    pub contacts: Adjacency,
    /// Shape and place of each wall when the grains close to it were last searched.
    wall_reference: Vec<WallShape>,
    /// Skin of the walls, m.
    wall_skin: f64,
    /// Of each wall: the grains close to it.
    pub wall_lists: Vec<WallList>,
    /// Buffer of a search: grains found.
    found: Vec<u32>,
    /// Buffer: entries to be removed.
    gone: Vec<Entry>,
    /// Number of searches around one grain since grains were last sorted in memory.
    pub searches: u64,
}

/// Reference sphere of a grain: centre x, y, z and reach at the last search of its neighbourhood, m. Single precision halves the memory that every
/// step reads; the reach is enlarged by the rounding of the centre, so that no contact is missed and no result depends on the rounding.
pub type Reference = [f32; 4];

/// The stored contacts that belong to the lists.
pub struct Pools<'a> {
    /// Contacts between grains.
    pub pairs: &'a mut Pairs,
    /// Contacts of grains with walls.
    pub wall_pairs: &'a mut Pairs,
}

impl Neighbours {
    /// Lists for grains and walls at their present places; the contacts in `pools` stay. `skin`: skin of a grain over its radius.
    pub fn new(g: &Grains, walls: &[Wall], pools: &mut Pools<'_>, skin: f64) -> Neighbours {
        let reference: Vec<Reference> = g.pos.iter().map(|p| Self::reference(p, skin)).collect();
        let mean_radius = g.pos.iter().map(|p| p[3]).sum::<f64>() / g.len().max(1) as f64;
        let mut n = Neighbours {
            skin,
            dt: 0.0,
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

    /// Fills the lists of grains and walls from the stored contacts and the pairs that do not touch.
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

    /// Searches the neighbourhoods of the grains `moved`, and of walls that have moved by more than their skin. All new reference spheres are set before
    /// the first search, so that the result does not depend on the order. Stored contacts between grains are neither read nor changed: this may run in
    /// parallel with the computation of their forces. `dt`: present time step, s.
    pub fn update(&mut self, moved: &[u32], dt: f64, g: &Grains, walls: &[Wall], wall_pairs: &mut Pairs) {
        self.dt = dt;
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

    /// Sets the reference sphere of grain `i` to its present place and searches its neighbourhood.
    pub fn refresh(&mut self, i: usize, g: &Grains, wall_pairs: &mut Pairs) {
        self.set_reference(i, g);
        self.search(i, g, wall_pairs);
    }

    /// Sets the reference sphere of grain `i` to its present place, with a skin that lasts for some steps at its present speed.
    fn set_reference(&mut self, i: usize, g: &Grains) {
        let [x, y, z, _] = g.vel[i];
        let way = LASTS * self.dt * dot([x, y, z], [x, y, z]).sqrt() / g.radius(i);
        // a speed that is not a number, which the run's watchdog will report, makes the widest skin
        self.reference[i] = Self::reference(&g.pos[i], way.min(WIDEST * self.skin).max(self.skin));
        self.grid.place(i, &self.reference);
    }

    /// Reference sphere of a grain with centre and radius `p`, m, and a skin of `skin` radii.
    fn reference(p: &[f64; 4], skin: f64) -> Reference {
        let centre = [p[0] as f32, p[1] as f32, p[2] as f32];
        let rounding = (0..3).map(|a| (p[a] - f64::from(centre[a])).abs()).sum::<f64>();
        let reach = (p[3] * (1.0 + skin) + rounding) as f32;
        [centre[0], centre[1], centre[2], reach.next_up()]
    }

    /// Whether a grain with centre and radius `p`, m, is not inside its reference sphere any more.
    #[inline(always)]
    pub fn has_left<F: Four>(reference: &Reference, p: F, token: F::Token) -> bool {
        let [x, y, z, growth] = (p - F::of(token, reference.map(f64::from))).xyzw();
        // the fourth difference is radius − reach: minus the skin that is left
        growth >= 0.0 || x * x + y * y + z * z > growth * growth
    }

    /// Whether grain `i`, whose radius has changed, is not inside its reference sphere any more.
    pub fn outgrown(&self, i: usize, g: &Grains) -> bool {
        Self::has_left(&self.reference[i], Plain::of((), g.pos[i]), ())
    }

    /// After a change of radii: writes into `moved` the indices of the grains that are not inside their reference spheres any more.
    pub fn account_for_growth(&self, g: &Grains, moved: &mut Vec<u32>) {
        moved.clear();
        moved.extend((0..g.len() as u32).filter(|&i| self.outgrown(i as usize, g)));
    }

    /// Reference spheres of all grains, for the loop that moves the grains.
    pub fn references(&self) -> &[Reference] {
        &self.reference
    }

    /// Adds the lists of grain `i`, which was appended to the arrays.
    pub fn append(&mut self, i: usize, g: &Grains, wall_pairs: &mut Pairs) {
        self.reference.push([0.0; 4]);
        self.around.append();
        self.contacts.append();
        self.grid.append();
        debug_assert_eq!(self.reference.len(), i + 1);
        self.refresh(i, g, wall_pairs);
    }

    /// Removes all pairs of grain `i` with grains and walls, with their history.
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

    /// Removes a listed pair that does not touch.
    fn forget(&mut self, e: Entry, g: &Grains) {
        let [a, b] = self.near.ends(e.slot());
        self.around.remove(a as usize, g.id[b as usize]);
        self.around.remove(b as usize, g.id[a as usize]);
        self.near.remove(e.slot());
    }

    /// Removes the pair of grain `i` with a wall.
    fn unlink_wall(&mut self, i: usize, e: Entry, g: &Grains, wall_pairs: &mut Pairs) {
        self.contacts.remove(i, e.id);
        let list = &mut self.wall_lists[e.wall_index()];
        if let Ok(at) = list.binary_search_by_key(&g.id[i], |&(id, _)| id) {
            list.remove(at);
        }
        wall_pairs.remove(e.slot() as u32);
    }

    /// All grains with which grain `i` makes a listed pair, in the order of identities: entry and index of the other grain.
    pub fn around<'a>(&'a self, i: usize, pairs: &'a Pairs) -> impl Iterator<Item = (Entry, usize)> + 'a {
        self.around.of(i).map(move |e| {
            let ends = if e.link.is_apart() { self.near.ends(e.slot()) } else { pairs.ends[e.slot()] };
            (e, other_end(ends, i))
        })
    }

    /// The contacts of grain `i` with other grains, in the order of their identities, each with the index of the other one.
    pub fn touching<'a>(&'a self, i: usize, pairs: &'a Pairs) -> impl Iterator<Item = (Entry, usize)> + 'a {
        self.contacts.of(i).filter(|e| !e.is_wall()).map(move |e| (e, other_end(pairs.ends[e.slot()], i)))
    }

    /// Both halves of the listed pairs that do not touch, for those to be marked that now do, and the lists of the walls.
    pub fn apart(&mut self) -> ([Half<'_>; 2], &[WallList]) {
        let (first, second) = self.near.halves();
        ([first, second], &self.wall_lists)
    }

    /// Makes contacts of the pairs marked by [`Half::mark_touching`], without forces yet; their slots are written into `slots`.
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

    /// Ends the contacts of grain `i` that do not touch any more; they stay listed as pairs that do not touch.
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

    /// Moves contacts into the free places of their storage, so that a sweep finds as many side by side as it computes at once.
    pub fn close_gaps(&mut self, g: &Grains, pairs: &mut Pairs) {
        pairs.close_gaps(|slot, [a, b]| {
            for (k, other, second) in [(a as usize, b as usize, false), (b as usize, a as usize, true)] {
                let e = Entry::grain(g.id[other], slot, second);
                self.around.relink(k, e);
                self.contacts.relink(k, e);
            }
        });
    }

    /// Whether two reference spheres overlap.
    #[inline]
    fn references_overlap(a: &Reference, b: &Reference) -> bool {
        let (a, b) = (a.map(f64::from), b.map(f64::from));
        let (x, y, z) = (a[0] - b[0], a[1] - b[1], a[2] - b[2]);
        let reach = a[3] + b[3];
        x * x + y * y + z * z < reach * reach
    }

    /// Searches the neighbourhood of grain `i`: drops pairs that do not touch and whose reference spheres are apart, adds those that are missing.
    fn search(&mut self, i: usize, g: &Grains, wall_pairs: &mut Pairs) {
        self.searches += 1;
        let here = self.reference[i];
        let mut gone = std::mem::take(&mut self.gone);
        gone.clear();
        // contacts stay listed whatever the reference spheres are
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

    /// Adds or removes the pair of grain `i` with wall `k`, by the wall's reference place.
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

    /// Follows a permutation of grains and slots: `order[k]` is the old index of grain `k`, `place[i]` the new index of what was grain `i`.
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

    /// Memory in use, bytes.
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

/// The other one of two grains, of which one is `i`.
#[inline]
fn other_end([a, b]: [u32; 2], i: usize) -> usize {
    if a as usize == i { b as usize } else { a as usize }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::contact::pairs::Kept;

    /// Grains of these radii, m, in a row, each at its distance, m, from the origin.
    fn row(grains: &[(f64, f64)]) -> Grains {
        Grains {
            pos: grains.iter().map(|&(x, r)| [x, 0.0, 0.0, r]).collect(),
            vel: vec![[0.0, 0.0, 0.0, 1.0]; grains.len()],
            id: (0..grains.len() as u32).collect(),
            ..Grains::default()
        }
    }

    /// At rest a skin of a fifth of the radius would ask for a search in every fourth step.
    #[test]
    fn the_skin_of_a_fast_grain_lasts_longer() {
        let mut g = row(&[(0.0, 1.0), (100.0, 1.0)]);
        g.vel[0][0] = 0.05;
        let (mut pairs, mut wall_pairs) = (Pairs::new(Kept::default()), Pairs::new(Kept::default()));
        let mut lists = Neighbours::new(&g, &[], &mut Pools { pairs: &mut pairs, wall_pairs: &mut wall_pairs }, 0.2);
        for _ in 0..320 {
            g.pos[0][0] += 0.05;
            if lists.outgrown(0, &g) {
                lists.update(&[0], 1.0, &g, &[], &mut wall_pairs);
            }
        }
        assert!((18..=22).contains(&lists.searches), "{} searches", lists.searches);
        assert!(!lists.outgrown(1, &g));
    }

    /// The lists of both grains follow a contact that moves in memory.
    #[test]
    fn gaps_between_contacts_are_closed() {
        let g = row(&[(0.0, 0.6), (1.0, 0.6), (2.0, 0.6), (3.0, 0.6), (4.0, 0.6)]);
        let (mut pairs, mut wall_pairs) = (Pairs::new(Kept::default()), Pairs::new(Kept::default()));
        let mut lists = Neighbours::new(&g, &[], &mut Pools { pairs: &mut pairs, wall_pairs: &mut wall_pairs }, 0.2);
        lists.apart().0.into_iter().for_each(|half| half.mark_touching(&g.pos, 1000));
        lists.begin_contacts(&g, &mut pairs, &mut Vec::new());
        let of = |lists: &Neighbours, pairs: &Pairs, i| lists.touching(i, pairs).map(|(_, j)| j).collect::<Vec<_>>();
        assert_eq!((pairs.slots(), of(&lists, &pairs, 3)), (4, vec![2, 4]));
        // the first grain flies away with its contact, and the last one
        lists.detach(0, &g, &mut Pools { pairs: &mut pairs, wall_pairs: &mut wall_pairs });
        lists.detach(4, &g, &mut Pools { pairs: &mut pairs, wall_pairs: &mut wall_pairs });
        assert_eq!(pairs.slots(), 4);
        lists.close_gaps(&g, &mut pairs);
        assert_eq!(pairs.slots(), 2);
        let all: Vec<_> = (0..5).map(|i| of(&lists, &pairs, i)).collect();
        assert_eq!(all, [vec![], vec![2], vec![1, 3], vec![2], vec![]]);
    }
}
