// Sorts the points by cell and, in a cell, by identity: counts them, sums the counts up, writes the points to their cells, sorts each cell. Runs only after a step in
// which a point has left its cell.

@group(1) @binding(0) var<storage, read_write> dispatches: array<u32>;

// Writes the sizes of the dispatches that follow, zero where no point has left its cell: by cells, by groups of the prefix sum, one, by points.
@compute @workgroup_size(1)
fn plan() {
    if atomicLoad(&status.fault) != NO_FAULT {
        status.stop = 1u;
    }
    let needed = select(0u, 1u, atomicExchange(&status.crossed, 0u) > 0u && status.stop == 0u);
    dispatches[0] = needed * params.cell_groups.x;
    dispatches[1] = params.cell_groups.y;
    dispatches[2] = 1u;
    dispatches[3] = needed * params.blocks;
    dispatches[4] = 1u;
    dispatches[5] = 1u;
    dispatches[6] = needed;
    dispatches[7] = 1u;
    dispatches[8] = 1u;
    dispatches[9] = needed * params.point_groups.x;
    dispatches[10] = params.point_groups.y;
    dispatches[11] = 1u;
}

// Sets the counts to zero.
@compute @workgroup_size(GROUP)
fn clear(one: Thread) {
    let c = linear(one);
    if c < params.cells {
        atomicStore(&counts[c], 0u);
    }
}

// Counts the points of each cell.
@compute @workgroup_size(GROUP)
fn count(one: Thread) {
    let i = linear(one);
    if i < params.points {
        atomicAdd(&counts[word(PLACE, i).w], 1u);
    }
}

var<workgroup> shared_sums: array<u32, WIDE>;

// The sum of the values `own` of the threads before this one.
fn before(thread: u32, own: u32) -> u32 {
    shared_sums[thread] = own;
    workgroupBarrier();
    for (var reach = 1u; reach < WIDE; reach *= 2u) {
        var more = 0u;
        if thread >= reach {
            more = shared_sums[thread - reach];
        }
        workgroupBarrier();
        shared_sums[thread] += more;
        workgroupBarrier();
    }
    return shared_sums[thread] - own;
}

// Prefix sum of the counts within each group of WIDE cells, and the sum of the group.
@compute @workgroup_size(WIDE)
fn scan_cells(@builtin(workgroup_id) block: vec3<u32>, @builtin(local_invocation_index) thread: u32) {
    let c = block.x * WIDE + thread;
    var own = 0u;
    if c < params.cells {
        own = atomicLoad(&counts[c]);
    }
    let first = before(thread, own);
    if c < params.cells {
        starts[c] = first;
    }
    if thread == WIDE - 1u {
        starts[params.cells + 1u + block.x] = first + own;
    }
}

// Prefix sum of the sums of groups.
@compute @workgroup_size(WIDE)
fn scan_blocks(@builtin(local_invocation_index) thread: u32) {
    let share = (params.blocks + WIDE - 1u) / WIDE;
    let begin = params.cells + 1u + min(thread * share, params.blocks);
    let to = params.cells + 1u + min((thread + 1u) * share, params.blocks);
    var own = 0u;
    for (var b = begin; b < to; b++) {
        own += starts[b];
    }
    var sum = before(thread, own);
    for (var b = begin; b < to; b++) {
        let here = starts[b];
        starts[b] = sum;
        sum += here;
    }
}

// The sum of both: the first index of each cell.
@compute @workgroup_size(GROUP)
fn scan_add(one: Thread) {
    let c = linear(one);
    if c < params.cells {
        let first = starts[c] + starts[params.cells + 1u + c / WIDE];
        starts[c] = first;
        atomicStore(&counts[c], first);
    } else if c == params.cells {
        starts[c] = params.points;
    }
}

// Writes each point to its cell, in any order.
@compute @workgroup_size(GROUP)
fn scatter(one: Thread) {
    let i = linear(one);
    if i < params.points {
        order[atomicAdd(&counts[word(PLACE, i).w], 1u)] = i;
    }
}

// Sorts the points of each cell by identity (insertion sort), so that the order depends on the state alone, not on the order in which threads ran.
@compute @workgroup_size(GROUP)
fn sort(one: Thread) {
    let c = linear(one);
    if c >= params.cells {
        return;
    }
    let first = starts[c];
    let end = starts[c + 1u];
    if end - first > CROWD {
        atomicMin(&status.fault, 8u * word(ENERGY, order[first]).z + CROWDED);
        return;
    }
    for (var k = first + 1u; k < end; k++) {
        let i = order[k];
        let own = word(ENERGY, i).z;
        var at = k;
        while at > first && word(ENERGY, order[at - 1u]).z > own {
            order[at] = order[at - 1u];
            at -= 1u;
        }
        order[at] = i;
    }
}
