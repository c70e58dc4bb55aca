// Where cells and nodes are in memory. The grid is kept in blocks of 4 × 4 × 2 cells, and of as many nodes; only blocks with points in them or beside them have a slot, which
// holds 32 cells and 32 nodes. Cells here are those of the B-splines, about a node: one more along each axis than the domain has; nodes go one cell beyond the domain on each
// side. Twin: blocks.rs.

// Shifts from cells to blocks, and the places in a block.
const SHIFT: vec3<u32> = vec3<u32>(2u, 2u, 1u);
const INSIDE: vec3<i32> = vec3<i32>(3, 3, 1);
const ALONG: vec3<i32> = vec3<i32>(4, 4, 2);

// Place of the block of a slot that has none. Such is slot 0: blocks without a slot share it; its cells have no points, and its nodes no mass.
const NOWHERE: u32 = 0xffffffffu;

// Bits of a block's claim: it has a slot; the blocks around it have slots.
const HELD: u32 = 1u;
const RINGED: u32 = 2u;

// for each block of the domain its slot; then for each slot the place of its block, packed as `cell_number` does
@group(0) @binding(6) var<storage, read_write> blocks: array<u32>;

// Numbers of cells and nodes along each axis.
fn cell_size() -> vec3<i32> {
    return params.size + 1;
}

fn node_size() -> vec3<i32> {
    return params.size + 3;
}

// Number of a cell in the state of points: its place along x, y, z in 11, 11, 10 bits.
fn cell_number(at: vec3<i32>) -> u32 {
    return u32(at.x | (at.y << 11u) | (at.z << 22u));
}

fn cell_place(cell: u32) -> vec3<i32> {
    return vec3<i32>(vec3<u32>(cell & 2047u, (cell >> 11u) & 2047u, cell >> 22u));
}

// The pair of slots of the `n`-th of so many workgroups: a processor gives each of its threads a run of workgroups, which must not be all those with points.
fn pair_of(n: u32) -> u32 {
    return select(n, (n * params.stride) % params.pairs, n < params.pairs);
}

// Number of the thread among those for all nodes and what comes after them.
fn node_thread(one: Thread) -> u32 {
    let t = linear(one);
    return pair_of(t / GROUP) * GROUP + t % GROUP;
}

fn block_number(block: vec3<i32>) -> u32 {
    return u32(block.x + params.blocks.x * (block.y + params.blocks.y * block.z));
}

fn slot_of(block: vec3<i32>) -> u32 {
    return blocks[block_number(block)];
}

// Number in its block of the cell or node at a place.
fn in_block(at: vec3<i32>) -> u32 {
    let inside = at & INSIDE;
    return u32(inside.x + 4 * (inside.y + 4 * inside.z));
}

// Index in memory of the cell or the node at a place.
fn cell_index(at: vec3<i32>) -> u32 {
    return slot_of(at >> SHIFT) * BLOCK + in_block(at);
}

fn node_index(at: vec3<i32>) -> u32 {
    return cell_index(at);
}

// Place of the block of a slot, or NOWHERE.
fn packed_place(slot: u32) -> u32 {
    return blocks[params.block_count + slot];
}

// Place of the cell or node with the number `k` in its block.
fn place_in(block: vec3<i32>, k: u32) -> vec3<i32> {
    return block * ALONG + vec3<i32>(vec3<u32>(k & 3u, (k >> 2u) & 3u, (k >> 4u) & 1u));
}

// Slots of a block and of those after it: `low` at its place along x, `high` after it; in each by places along y and z: 00, 10, 01, 11.
struct Corners {
    block: vec3<i32>,
    low: vec4<u32>,
    high: vec4<u32>,
}

fn corners(a: vec3<i32>) -> Corners {
    // nothing reaches beyond the last block
    let b = min(a + 1, params.blocks - 1);
    return Corners(
        a,
        vec4<u32>(slot_of(a), slot_of(vec3<i32>(a.x, b.y, a.z)), slot_of(vec3<i32>(a.x, a.y, b.z)), slot_of(vec3<i32>(a.x, b.y, b.z))),
        vec4<u32>(slot_of(vec3<i32>(b.x, a.y, a.z)), slot_of(vec3<i32>(b.x, b.y, a.z)), slot_of(vec3<i32>(b.x, a.y, b.z)), slot_of(b)),
    );
}

// Indices of the three nodes along x from `at` on.
fn three_nodes(c: Corners, at: vec3<i32>) -> vec3<u32> {
    let block = at >> SHIFT;
    let k = u32(block.y - c.block.y + 2 * (block.z - c.block.z)) & 3u;
    let x = at.x + vec3<i32>(0, 1, 2);
    let along = u32(4 * ((at.y & 3) + 4 * (at.z & 1)));
    return select(vec3<u32>(c.high[k]), vec3<u32>(c.low[k]), (x >> vec3<u32>(2u)) == vec3<i32>(c.block.x)) * BLOCK + along + vec3<u32>(x & vec3<i32>(3));
}

// Gives slots to the blocks around one that points have come to, the `k`-th of 27 to each thread. Other threads read them in later passes only.
fn ring(slot: u32, k: u32) {
    let block = cell_place(packed_place(slot));
    let claims = params.cells + params.cell_groups;
    let own = claims + block_number(block);
    if (atomicLoad(&counts[own]) & RINGED) != 0u {
        return;
    }
    let at = vec3<i32>(vec3<u32>(k % 3u, (k / 3u) % 3u, k / 9u));
    let there = block + at - 1;
    if any(there < vec3<i32>(0)) || any(there >= params.blocks) {
        return;
    }
    let number = block_number(there);
    if (atomicOr(&counts[claims + number], HELD) & HELD) == 0u {
        let claimed = atomicAdd(&status.slots, 1u);
        if claimed >= params.slots {
            report_fault(NO_ROOM, nth(starts[slot * BLOCK]));
            return;
        }
        blocks[number] = claimed;
        blocks[params.block_count + claimed] = cell_number(there);
    }
}

// Keeps in mind that they have.
fn ringed(slot: u32) {
    atomicOr(&counts[params.cells + params.cell_groups + block_number(cell_place(packed_place(slot)))], RINGED);
}
