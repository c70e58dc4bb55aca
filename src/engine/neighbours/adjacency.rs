//! Partners of each grain, sorted by their persistent ids with walls last: the order in which it sums forces.
//! One arena; each grain owns a block whose capacity is a multiple of `UNIT`. Ids, which only searches read, and links, which every step
//! reads, stand apart.

const GRAIN_END: u32 = 1 << 31;
const WALL: u32 = 1 << 30;
const APART: u32 = 1 << 29;
/// Ids from here on are walls.
const WALL_IDS: u32 = u32::MAX - 0xffff;

/// Where a pair's slot is and which end of it the grain is.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Link(u32);

impl Link {
    #[inline(always)]
    pub fn slot(self) -> usize {
        (self.0 & !(GRAIN_END | WALL | APART)) as usize
    }

    /// Whether the grain is the second end of the slot (forces then change sign).
    #[inline(always)]
    pub fn second_end(self) -> bool {
        self.0 & GRAIN_END != 0
    }

    /// 1 if the grain is the slot's first end, else 0.
    #[inline(always)]
    pub fn first_end(self) -> f64 {
        static SHARES: [f64; 2] = [1.0, 0.0];
        SHARES[(self.0 >> 31) as usize]
    }

    /// What the force in the slot is to be multiplied with: it acts on the first end.
    #[inline(always)]
    pub fn sign(self) -> f64 {
        static SIGNS: [f64; 2] = [1.0, -1.0];
        SIGNS[(self.0 >> 31) as usize]
    }

    #[inline(always)]
    pub fn is_wall(self) -> bool {
        self.0 & WALL != 0
    }

    /// Whether the slot is one of pairs that do not touch (`near`).
    pub fn is_apart(self) -> bool {
        self.0 & APART != 0
    }
}

/// One partner of a grain.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Entry {
    /// Persistent id of the partner; walls have ids above every grain.
    pub id: u32,
    pub link: Link,
}

impl Entry {
    pub fn grain(id: u32, slot: u32, second_end: bool) -> Entry {
        Entry { id, link: Link(slot | if second_end { GRAIN_END } else { 0 }) }
    }

    /// A pair that does not touch.
    pub fn apart(id: u32, slot: u32) -> Entry {
        Entry { id, link: Link(slot | APART) }
    }

    pub fn wall(k: u32, slot: u32) -> Entry {
        Entry { id: WALL_IDS + k, link: Link(slot | WALL) }
    }

    pub fn slot(self) -> usize {
        self.link.slot()
    }

    pub fn second_end(self) -> bool {
        self.link.second_end()
    }

    pub fn is_wall(self) -> bool {
        self.link.is_wall()
    }

    pub fn wall_index(self) -> usize {
        (self.id - WALL_IDS) as usize
    }
}

#[derive(Clone, Copy, Default)]
struct Span {
    start: u32,
    len: u32,
    /// Capacity in units.
    units: u32,
}

impl Span {
    fn range(self) -> std::ops::Range<usize> {
        self.start as usize..self.start as usize + self.len as usize
    }
}

/// All adjacency lists.
#[derive(Default)]
pub struct Adjacency {
    blocks: Vec<Span>,
    ids: Vec<u32>,
    links: Vec<Link>,
    /// Starts of free blocks by units.
    free: Vec<Vec<u32>>,
}

/// Entries by which blocks grow, at first; large ones grow by a quarter.
const UNIT: usize = 4;

impl Adjacency {
    /// Empty lists for `n` grains.
    pub fn clear(&mut self, n: usize) {
        self.blocks.clear();
        self.blocks.resize(n, Span::default());
        self.ids.clear();
        self.links.clear();
        self.free.clear();
    }

    pub fn append(&mut self) {
        self.blocks.push(Span::default());
    }

    /// Partners of grain `i`.
    #[inline]
    pub fn of(&self, i: usize) -> impl Iterator<Item = Entry> + '_ {
        self.ids(i).iter().zip(self.links(i)).map(|(&id, &link)| Entry { id, link })
    }

    /// Links to grain `i`'s partners, in the same order.
    #[inline(always)]
    pub fn links(&self, i: usize) -> &[Link] {
        &self.links[self.blocks[i].range()]
    }

    fn ids(&self, i: usize) -> &[u32] {
        &self.ids[self.blocks[i].range()]
    }

    pub fn contains(&self, i: usize, id: u32) -> bool {
        self.ids(i).binary_search(&id).is_ok()
    }

    pub fn find(&self, i: usize, id: u32) -> Option<Entry> {
        self.ids(i).binary_search(&id).ok().map(|at| Entry { id, link: self.links(i)[at] })
    }

    /// Points the entry of a partner that is there to another slot.
    pub fn relink(&mut self, i: usize, e: Entry) {
        let at = self.ids(i).binary_search(&e.id).expect("a partner");
        self.links[self.blocks[i].start as usize + at] = e.link;
    }

    pub fn insert(&mut self, i: usize, e: Entry) {
        if let Err(at) = self.ids(i).binary_search(&e.id) {
            self.push(i, e);
            let range = self.blocks[i].range();
            self.ids[range.start + at..range.end].rotate_right(1);
            self.links[range.start + at..range.end].rotate_right(1);
        }
    }

    fn push(&mut self, i: usize, e: Entry) {
        let b = self.blocks[i];
        if b.len as usize == b.units as usize * UNIT {
            self.grow(i);
        }
        let b = &mut self.blocks[i];
        b.len += 1;
        let end = b.range().end - 1;
        self.ids[end] = e.id;
        self.links[end] = e.link;
    }

    pub fn remove(&mut self, i: usize, id: u32) {
        if let Ok(at) = self.ids(i).binary_search(&id) {
            let range = self.blocks[i].range();
            self.ids[range.start + at..range.end].rotate_left(1);
            self.links[range.start + at..range.end].rotate_left(1);
            self.blocks[i].len -= 1;
        }
    }

    fn grow(&mut self, i: usize) {
        let old = self.blocks[i];
        let units = old.units + 1 + old.units / 4;
        if self.free.len() <= units as usize {
            self.free.resize(units as usize + 1, Vec::new());
        }
        let start = self.free[units as usize].pop().unwrap_or_else(|| self.reserve(units as usize * UNIT));
        self.ids.copy_within(old.range(), start as usize);
        self.links.copy_within(old.range(), start as usize);
        if old.units > 0 {
            self.free[old.units as usize].push(old.start);
        }
        self.blocks[i] = Span { start, units, ..old };
    }

    fn reserve(&mut self, more: usize) -> u32 {
        let start = self.ids.len();
        self.ids.resize(start + more, 0);
        self.links.resize(start + more, Link::default());
        start as u32
    }

    /// Fills the lists of all grains anew from `(grain, entry)`, blocks in the order of grains with room to spare.
    pub fn fill(&mut self, n: usize, entries: impl Iterator<Item = (u32, Entry)> + Clone) {
        self.clear(n);
        for (i, _) in entries.clone() {
            self.blocks[i as usize].len += 1;
        }
        for i in 0..n {
            let units = self.blocks[i].len as usize / UNIT + 1;
            self.blocks[i] = Span { start: self.reserve(units * UNIT), len: 0, units: units as u32 };
        }
        for (i, e) in entries {
            self.insert(i as usize, e);
        }
    }

    /// Bytes held.
    pub fn bytes(&self) -> usize {
        self.blocks.capacity() * size_of::<Span>()
            + (self.ids.capacity() + self.links.capacity()) * 4
            + self.free.iter().map(|f| f.capacity() * 4).sum::<usize>()
    }
}
