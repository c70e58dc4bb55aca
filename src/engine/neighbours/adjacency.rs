//! Partners of each grain, sorted by their identities with walls last: the order in which a grain sums its contact forces.
//!
//! All lists are in one array; each grain owns a span of it whose capacity is a multiple of `UNIT`. Identities (read by searches only) and links
//! (read at every step) are in arrays of their own.

/// Bit of a link: the grain is the second end of the pair.
const GRAIN_END: u32 = 1 << 31;
/// Bit of a link: the partner is a wall.
const WALL: u32 = 1 << 30;
/// Bit of a link: the pair does not touch, and its slot is in `near.rs`.
const APART: u32 = 1 << 29;
/// Identities from this one on stand for walls: wall `k` has `WALL_IDS + k`.
const WALL_IDS: u32 = u32::MAX - 0xffff;

/// From a grain to one of its pairs: the pair's slot, which end of the pair the grain is, and what kind of pair. Packed in 32 bits.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Link(u32);

impl Link {
    /// Slot of the pair: its index in the contacts between grains, in the contacts with walls, or in the pairs that do not touch.
    #[inline(always)]
    pub fn slot(self) -> usize {
        (self.0 & !(GRAIN_END | WALL | APART)) as usize
    }

    /// Whether the grain is the second end of the pair: a stored force acts on the first end, so its sign changes.
    #[inline(always)]
    pub fn second_end(self) -> bool {
        self.0 & GRAIN_END != 0
    }

    /// 1 if the grain is the first end of the pair, else 0.
    #[inline(always)]
    pub fn first_end(self) -> f64 {
        static SHARES: [f64; 2] = [1.0, 0.0];
        SHARES[(self.0 >> 31) as usize]
    }

    /// Factor for the stored force, which acts on the first end: 1 for the first end, −1 for the second.
    #[inline(always)]
    pub fn sign(self) -> f64 {
        static SIGNS: [f64; 2] = [1.0, -1.0];
        SIGNS[(self.0 >> 31) as usize]
    }

    /// Whether the partner is a wall.
    #[inline(always)]
    pub fn is_wall(self) -> bool {
        self.0 & WALL != 0
    }

    /// Whether the pair does not touch; its slot then is in the list of such pairs (`near.rs`).
    pub fn is_apart(self) -> bool {
        self.0 & APART != 0
    }
}

/// One partner of a grain, with the link to their pair.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Entry {
    /// Identity of the partner; those of walls are above those of all grains.
    pub id: u32,
    /// Link to the pair.
    pub link: Link,
}

impl Entry {
    /// A contact with grain `id` in slot `slot`; `second_end`: whether the owner of the entry is the second end.
    pub fn grain(id: u32, slot: u32, second_end: bool) -> Entry {
        Entry { id, link: Link(slot | if second_end { GRAIN_END } else { 0 }) }
    }

    /// A pair with grain `id` that does not touch.
    pub fn apart(id: u32, slot: u32) -> Entry {
        Entry { id, link: Link(slot | APART) }
    }

    /// A pair with wall `k`.
    pub fn wall(k: u32, slot: u32) -> Entry {
        Entry { id: WALL_IDS + k, link: Link(slot | WALL) }
    }

    /// As [`Link::slot`].
    pub fn slot(self) -> usize {
        self.link.slot()
    }

    /// As [`Link::second_end`].
    pub fn second_end(self) -> bool {
        self.link.second_end()
    }

    /// As [`Link::is_wall`].
    pub fn is_wall(self) -> bool {
        self.link.is_wall()
    }

    /// Index of the wall that is the partner; meaningless for a grain.
    pub fn wall_index(self) -> usize {
        (self.id - WALL_IDS) as usize
    }
}

/// The part of the arrays that a grain owns.
#[derive(Clone, Copy, Default)]
struct Span {
    /// First entry.
    start: u32,
    /// Entries in use.
    len: u32,
    /// Capacity, in multiples of [`UNIT`] entries.
    units: u32,
}

impl Span {
    fn range(self) -> std::ops::Range<usize> {
        self.start as usize..self.start as usize + self.len as usize
    }
}

/// The partners of all grains.
#[derive(Default)]
pub struct Adjacency {
    /// Span of each grain.
    blocks: Vec<Span>,
    /// Identities of the partners.
    ids: Vec<u32>,
    /// Links, in the same places as `ids`.
    links: Vec<Link>,
    /// Starts of spans that are free, by their capacity in units.
    free: Vec<Vec<u32>>,
}

/// Entries by which a small span grows; larger ones grow by a quarter of their capacity.
const UNIT: usize = 4;

impl Adjacency {
    /// Makes the lists of `n` grains, all empty.
    pub fn clear(&mut self, n: usize) {
        self.blocks.clear();
        self.blocks.resize(n, Span::default());
        self.ids.clear();
        self.links.clear();
        self.free.clear();
    }

    /// Adds an empty list for one more grain.
    pub fn append(&mut self) {
        self.blocks.push(Span::default());
    }

    /// Partners of grain `i`, in the order of their identities, walls last.
    #[inline]
    pub fn of(&self, i: usize) -> impl Iterator<Item = Entry> + '_ {
        self.ids(i).iter().zip(self.links(i)).map(|(&id, &link)| Entry { id, link })
    }

    /// Links of grain `i` to its pairs, in the order of [`Self::of`].
    #[inline(always)]
    pub fn links(&self, i: usize) -> &[Link] {
        &self.links[self.blocks[i].range()]
    }

    fn ids(&self, i: usize) -> &[u32] {
        &self.ids[self.blocks[i].range()]
    }

    /// Whether grain `i` has the partner `id`.
    pub fn contains(&self, i: usize, id: u32) -> bool {
        self.ids(i).binary_search(&id).is_ok()
    }

    /// The entry of partner `id` of grain `i`, if there is one.
    pub fn find(&self, i: usize, id: u32) -> Option<Entry> {
        self.ids(i).binary_search(&id).ok().map(|at| Entry { id, link: self.links(i)[at] })
    }

    /// Replaces the link of grain `i` to the partner `e.id`, which must be listed, by `e.link`.
    pub fn relink(&mut self, i: usize, e: Entry) {
        let at = self.ids(i).binary_search(&e.id).expect("a partner");
        self.links[self.blocks[i].start as usize + at] = e.link;
    }

    /// Adds a partner to grain `i`, in its place in the order; nothing happens if the partner is listed already.
    pub fn insert(&mut self, i: usize, e: Entry) {
        if let Err(at) = self.ids(i).binary_search(&e.id) {
            self.push(i, e);
            let range = self.blocks[i].range();
            self.ids[range.start + at..range.end].rotate_right(1);
            self.links[range.start + at..range.end].rotate_right(1);
        }
    }

    /// Adds a partner behind all others of grain `i`.
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

    /// Removes the partner `id` of grain `i`, if there is one.
    pub fn remove(&mut self, i: usize, id: u32) {
        if let Ok(at) = self.ids(i).binary_search(&id) {
            let range = self.blocks[i].range();
            self.ids[range.start + at..range.end].rotate_left(1);
            self.links[range.start + at..range.end].rotate_left(1);
            self.blocks[i].len -= 1;
        }
    }

    /// Moves the list of grain `i` to a larger span.
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

    /// Adds `more` entries at the end of the arrays; returns the first of them.
    fn reserve(&mut self, more: usize) -> u32 {
        let start = self.ids.len();
        self.ids.resize(start + more, 0);
        self.links.resize(start + more, Link::default());
        start as u32
    }

    /// Makes the lists of `n` grains from (grain, entry) pairs. Spans follow the order of grains and have room for at least one more entry each.
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

    /// Memory in use, bytes.
    pub fn bytes(&self) -> usize {
        self.blocks.capacity() * size_of::<Span>()
            + (self.ids.capacity() + self.links.capacity()) * 4
            + self.free.iter().map(|f| f.capacity() * 4).sum::<usize>()
    }
}
