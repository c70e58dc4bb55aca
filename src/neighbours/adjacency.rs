//! The contacts of each grain, sorted by the partner's persistent id with walls last: the order in which it sums forces.
//! One arena; each grain owns a block whose capacity is a power of two.

const GRAIN_END: u32 = 1 << 31;
const WALL: u32 = 1 << 30;
/// Ids from here on are walls.
const WALL_IDS: u32 = u32::MAX - 0xffff;

/// One contact as seen from one grain.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Entry {
    /// Persistent id of the partner; walls have ids above every grain.
    pub id: u32,
    slot: u32,
}

impl Entry {
    pub fn grain(id: u32, slot: u32, second_end: bool) -> Entry {
        Entry { id, slot: slot | if second_end { GRAIN_END } else { 0 } }
    }

    pub fn wall(k: u32, slot: u32) -> Entry {
        Entry { id: WALL_IDS + k, slot: slot | WALL }
    }

    #[inline(always)]
    pub fn slot(self) -> u32 {
        self.slot & !(GRAIN_END | WALL)
    }

    /// Whether this grain is the second end of the slot (forces then change sign).
    #[inline(always)]
    pub fn second_end(self) -> bool {
        self.slot & GRAIN_END != 0
    }

    /// 1 if this grain is the slot's first end, else 0.
    #[inline(always)]
    pub fn first_end(self) -> f64 {
        f64::from(1 - (self.slot >> 31))
    }

    #[inline(always)]
    pub fn is_wall(self) -> bool {
        self.slot & WALL != 0
    }

    pub fn wall_index(self) -> usize {
        (self.id - WALL_IDS) as usize
    }
}

#[derive(Clone, Copy, Default)]
struct Block {
    start: u32,
    len: u32,
    /// log2 of the capacity plus one; 0 = no block.
    class: u32,
}

/// All adjacency lists.
#[derive(Default)]
pub struct Adjacency {
    blocks: Vec<Block>,
    arena: Vec<Entry>,
    /// Starts of free blocks by class.
    free: Vec<Vec<u32>>,
}

const EMPTY: Entry = Entry { id: 0, slot: 0 };
/// Smallest block: 8 entries.
const SMALLEST: u32 = 4;

impl Adjacency {
    /// Empty lists for `n` grains.
    pub fn clear(&mut self, n: usize) {
        self.blocks.clear();
        self.blocks.resize(n, Block::default());
        self.arena.clear();
        self.free.clear();
    }

    pub fn append(&mut self) {
        self.blocks.push(Block::default());
    }

    /// Contacts of grain `i`.
    #[inline(always)]
    pub fn of(&self, i: usize) -> &[Entry] {
        let b = self.blocks[i];
        &self.arena[b.start as usize..(b.start + b.len) as usize]
    }

    fn position(&self, i: usize, id: u32) -> Result<usize, usize> {
        self.of(i).binary_search_by_key(&id, |e| e.id)
    }

    pub fn contains(&self, i: usize, id: u32) -> bool {
        self.position(i, id).is_ok()
    }

    pub fn find(&self, i: usize, id: u32) -> Option<&Entry> {
        self.position(i, id).ok().map(|at| &self.of(i)[at])
    }

    pub fn insert(&mut self, i: usize, e: Entry) {
        if let Err(at) = self.position(i, e.id) {
            self.push(i, e);
            let b = self.blocks[i];
            let (start, end) = (b.start as usize, (b.start + b.len) as usize);
            self.arena[start + at..end].rotate_right(1);
        }
    }

    /// Appends without sorting; call [`Self::sort_all`] afterwards.
    pub fn push(&mut self, i: usize, e: Entry) {
        let b = self.blocks[i];
        if b.class == 0 || b.len == 1 << (b.class - 1) {
            self.grow(i);
        }
        let b = &mut self.blocks[i];
        self.arena[(b.start + b.len) as usize] = e;
        b.len += 1;
    }

    pub fn remove(&mut self, i: usize, id: u32) {
        if let Ok(at) = self.position(i, id) {
            let b = self.blocks[i];
            let (start, end) = (b.start as usize, (b.start + b.len) as usize);
            self.arena[start + at..end].rotate_left(1);
            self.blocks[i].len -= 1;
        }
    }

    pub fn sort_all(&mut self) {
        for b in &self.blocks {
            self.arena[b.start as usize..(b.start + b.len) as usize].sort_unstable_by_key(|e| e.id);
        }
    }

    fn grow(&mut self, i: usize) {
        let old = self.blocks[i];
        let class = (old.class + 1).max(SMALLEST);
        if self.free.len() <= class as usize {
            self.free.resize(class as usize + 1, Vec::new());
        }
        let start = self.free[class as usize].pop().unwrap_or_else(|| {
            let start = self.arena.len() as u32;
            self.arena.resize(self.arena.len() + (1 << (class - 1)), EMPTY);
            start
        });
        self.arena.copy_within(old.start as usize..(old.start + old.len) as usize, start as usize);
        if old.class > 0 {
            self.free[old.class as usize].push(old.start);
        }
        self.blocks[i] = Block { start, len: old.len, class };
    }

    /// Bytes held.
    pub fn bytes(&self) -> usize {
        self.blocks.capacity() * 12 + self.arena.capacity() * 8 + self.free.iter().map(|f| f.capacity() * 4).sum::<usize>()
    }
}
