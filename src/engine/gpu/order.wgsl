// Keeps the points in the order of cells, by their slots, and, in a cell, of identities. `advance` keeps the number of points of each cell and of each group of cells; after a
// step in which a point has left its cell, `find_starts` sums them up, `scatter` writes the points to their cells and `sort` sorts each cell. In other steps they do nothing.

// Moves a point from one cell to another, by their indices.
fn change_cell(old: u32, to: u32) {
    atomicAdd(&status.crossed, 1u);
    atomicSub(&counts[old], 1u);
    atomicAdd(&counts[to], 1u);
    let groups = vec2<u32>(old, to) / (WIDE * params.share);
    if groups.x != groups.y {
        atomicSub(&counts[params.cells + groups.x], 1u);
        atomicAdd(&counts[params.cells + groups.y], 1u);
    }
}

// Whether a point has left its cell in this step.
fn is_disordered() -> bool {
    return atomicLoad(&status.crossed) > 0u;
}

var<workgroup> shared_sums: array<u32, WIDE>;
var<workgroup> disordered: u32;

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

// The index of the first point of each cell, in a workgroup for each group of cells: the points of the groups before it, and those of the cells before a cell in its group. Each
// thread has `share` cells.
@compute @workgroup_size(WIDE)
fn find_starts(@builtin(workgroup_id) group: vec3<u32>, @builtin(local_invocation_index) thread: u32) {
    if thread == 0u {
        disordered = u32(is_disordered());
    }
    if workgroupUniformLoad(&disordered) == 0u {
        return;
    }
    var others = 0u;
    for (var g = thread; g < group.x; g += WIDE) {
        others += atomicLoad(&counts[params.cells + g]);
    }
    shared_sums[thread] = others;
    workgroupBarrier();
    for (var half = WIDE / 2u; half > 0u; half /= 2u) {
        if thread < half {
            shared_sums[thread] += shared_sums[thread + half];
        }
        workgroupBarrier();
    }
    let base = shared_sums[0];
    workgroupBarrier();
    let begin = min((group.x * WIDE + thread) * params.share, params.cells);
    let end = min(begin + params.share, params.cells);
    var own = 0u;
    for (var c = begin; c < end; c++) {
        own += atomicLoad(&counts[c]);
    }
    var first = base + before(thread, own);
    for (var c = begin; c < end; c++) {
        starts[c] = first;
        // the next free index, for `scatter`
        first += atomicExchange(&counts[c], first);
    }
    if thread == 0u {
        starts[params.cells] = params.points;
    }
}

// Writes each point to its cell, in any order.
@compute @workgroup_size(GROUP)
fn scatter(one: Thread) {
    let i = linear(one);
    if i < params.points && is_disordered() {
        starts[params.cells + 1u + atomicAdd(&counts[cell_index(cell_place(word(PLACE, i).w))], 1u)] = i;
    }
}

// Sorts the points of a cell by identity (insertion sort), so that the order depends on the state alone, not on the order in which threads ran.
fn sort(cell: u32) {
    if !is_disordered() {
        return;
    }
    let first = starts[cell];
    let end = starts[cell + 1u];
    atomicStore(&counts[cell], end - first);
    if end - first > CROWD {
        atomicMin(&status.fault, 8u * identity(nth(first)) + CROWDED);
        return;
    }
    let order = params.cells + 1u;
    for (var k = first + 1u; k < end; k++) {
        let i = nth(k);
        let own = identity(i);
        var at = k;
        while at > first && identity(nth(at - 1u)) > own {
            starts[order + at] = nth(at - 1u);
            at -= 1u;
        }
        starts[order + at] = i;
    }
}
