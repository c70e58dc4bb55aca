// What points give to nodes, in two stages: each block sums up what its own points give, in its tile of 6 × 6 × 4 nodes (one workgroup a block, here), and each node sums up the
// tiles that reach it (`from_tiles` in nodes.wgsl). A thread has one of the four layers of nodes along z above the two cells of a column of the block. Sums go by cells and,
// in a cell, by identities. Twins (f64): mpm/spline.rs, mpm/pass.rs, with which gpu/tests/step.rs compares it.

// For each of the nine nodes above a column, in each layer, what the column gives to it.
var<workgroup> given_by_columns: array<vec4<f32>, PARTS>;

// 1 where the block has points
var<workgroup> occupied: u32;

// What goes to the nodes of one layer: for each place along y a column for each place along x.
struct Layer {
    y0: mat3x4<f32>,
    y1: mat3x4<f32>,
    y2: mat3x4<f32>,
}

// A column for each of three weights.
fn spread(a: vec4<f32>, w: vec3<f32>) -> mat3x4<f32> {
    return mat3x4<f32>(a * w.x, a * w.y, a * w.z);
}

// The slot of a workgroup.
fn slot_here(group: vec3<u32>, groups: vec3<u32>) -> u32 {
    let own = group.x + group.y * groups.x;
    return 2u * pair_of(own / 2u) + own % 2u;
}

// The points of the lower or upper (`up` = 0, 1) cell of the column of a thread that give to its layer of nodes, as numbers in the order of cells; and which of the three
// layers above that cell it is.
struct Givers {
    first: u32,
    end: u32,
    layer: u32,
}

fn givers(slot: u32, thread: u32, up: u32) -> Givers {
    let layer = thread / COLUMNS - up;
    let cell = slot * BLOCK + thread % COLUMNS + up * COLUMNS;
    let first = starts[cell];
    // one layer lies below the upper cell, and one too high above the lower one
    return Givers(first, select(first, starts[cell + 1u], layer < 3u), min(layer, 2u));
}

// Keeps what a column gives to three nodes along x of a layer, at the place `y` of three along y.
fn keep_row(thread: u32, y: u32, row: mat3x4<f32>) {
    let first = (9u * min(thread / COLUMNS, 3u) + 3u * y) * COLUMNS + thread % COLUMNS;
    given_by_columns[first] = row[0];
    given_by_columns[first + COLUMNS] = row[1];
    given_by_columns[first + 2u * COLUMNS] = row[2];
}

fn keep_layer(thread: u32, sum: Layer) {
    keep_row(thread, 0u, sum.y0);
    keep_row(thread, 1u, sum.y1);
    keep_row(thread, 2u, sum.y2);
}

fn tile_entry(slot: u32, n: u32) -> u32 {
    return TILES * params.cells + slot * TILE + n;
}

// Sums up the tile of a block.
fn sum_tile(slot: u32, thread: u32) {
    for (var n = thread; n < TILE; n += GROUP) {
        let x = n % 6u;
        let y = (n / 6u) % 6u;
        let z = min(n / 36u, 3u);
        var sum = vec4<f32>(0.0);
        for (var dy = max(y, 3u) - 3u; dy <= min(y, 2u); dy++) {
            for (var dx = max(x, 3u) - 3u; dx <= min(x, 2u); dx++) {
                let column = min(x - dx, 3u) + 4u * min(y - dy, 3u);
                sum += given_by_columns[(9u * z + 3u * dy + dx) * COLUMNS + column];
            }
        }
        nodes[tile_entry(slot, n)] = sum;
    }
}

fn clear_tile(slot: u32, thread: u32) {
    if packed_place(slot) != NOWHERE {
        for (var n = thread; n < TILE; n += GROUP) {
            nodes[tile_entry(slot, n)] = vec4<f32>(0.0);
        }
    }
}

// Mass and momentum (Li et al. 2023, eqs 36, 37). The points of each cell are put in order first.
@compute @workgroup_size(GROUP)
fn deposit(@builtin(workgroup_id) group: vec3<u32>, @builtin(num_workgroups) groups: vec3<u32>, @builtin(local_invocation_index) thread: u32) {
    let slot = slot_here(group, groups);
    if slot >= params.slots {
        return;
    }
    let first_cell = slot * BLOCK;
    if thread == 0u {
        occupied = u32(starts[first_cell] != starts[first_cell + BLOCK]);
    }
    if thread < BLOCK {
        sort(first_cell + thread);
    }
    storageBarrier();
    if workgroupUniformLoad(&occupied) == 0u {
        clear_tile(slot, thread);
        return;
    }
    if thread < 27u {
        ring(slot, thread);
    }
    var sum: Layer;
    for (var up = 0u; up < 2u; up++) {
        let these = givers(slot, thread, up);
        for (var p = these.first; p < these.end; p++) {
            let i = nth(p);
            let o = offset(word(PLACE, i));
            let v = number(VELOCITY, i);
            let x = spline(o.x);
            let y = spline(o.y);
            let here = vec4<f32>(v.xyz * v.w, v.w) * spline(o.z)[these.layer];
            sum.y0 += spread(here * y.x, x);
            sum.y1 += spread(here * y.y, x);
            sum.y2 += spread(here * y.z, x);
        }
    }
    keep_layer(thread, sum);
    workgroupBarrier();
    if thread == 0u {
        ringed(slot);
    }
    sum_tile(slot, thread);
}

// Forces: internal ones −Σ V σ ∇N (Li et al. 2023, eqs 8, 12), those of loading plates and grains (eq. 29), and the stiffness of the latter two, N/m.
@compute @workgroup_size(GROUP)
fn press_nodes(@builtin(workgroup_id) group: vec3<u32>, @builtin(num_workgroups) groups: vec3<u32>, @builtin(local_invocation_index) thread: u32) {
    let slot = slot_here(group, groups);
    if slot >= params.slots {
        return;
    }
    if thread == 0u {
        occupied = u32(starts[slot * BLOCK] != starts[slot * BLOCK + BLOCK]);
    }
    if workgroupUniformLoad(&occupied) == 0u {
        clear_tile(slot, thread);
        return;
    }
    var sum: Layer;
    for (var up = 0u; up < 2u; up++) {
        let these = givers(slot, thread, up);
        let layer = i32(these.layer);
        for (var p = these.first; p < these.end; p++) {
            let i = nth(p);
            let o = offset(word(PLACE, i));
            let x = spline(o.x);
            let y = spline(o.y);
            let z = spline(o.z)[these.layer];
            let slope_x = spline_slope(o.x);
            let slope_y = spline_slope(o.y);
            let slope_z = spline_slope(o.z)[these.layer];
            let a = number(NORMAL, i);
            let b = number(SHEAR, i);
            let volume = a.w * -params.inverse_cell;
            let on_x = vec4<f32>(volume * vec3<f32>(a.x, b.x, b.z), 0.0) * z;
            let on_y = vec4<f32>(volume * vec3<f32>(b.x, a.y, b.y), 0.0) * z;
            let on_z = vec4<f32>(volume * vec3<f32>(b.z, b.y, a.z), 0.0) * slope_z;
            sum.y0 += spread(on_x * y.x, slope_x) + spread(on_y * slope_y.x + on_z * y.x, x);
            sum.y1 += spread(on_x * y.y, slope_x) + spread(on_y * slope_y.y + on_z * y.y, x);
            sum.y2 += spread(on_x * y.z, slope_x) + spread(on_y * slope_y.z + on_z * y.z, x);
            if PRESSED {
                let push = batch.parts[i];
                if any(push.xyz != vec3<f32>(0.0)) {
                    let arm = number(ARM, i).xyz;
                    sum.y0 += of_plates(push, arm, vec2<i32>(0, layer), o, x, y.x, z);
                    sum.y1 += of_plates(push, arm, vec2<i32>(1, layer), o, x, y.y, z);
                    sum.y2 += of_plates(push, arm, vec2<i32>(2, layer), o, x, y.z, z);
                }
            }
            if GRAINS {
                sum.y0 += of_grains(i, vec2<i32>(0, layer));
                sum.y1 += of_grains(i, vec2<i32>(1, layer));
                sum.y2 += of_grains(i, vec2<i32>(2, layer));
            }
        }
    }
    keep_layer(thread, sum);
    workgroupBarrier();
    sum_tile(slot, thread);
}

// What the loading plates press on three nodes along x, `at` along y and z; each component acts on the face along its axis. `x`: weights of the point itself along x; `y`,
// `z`: those at the place along the other axes.
fn of_plates(push: vec4<f32>, arm: vec3<f32>, at: vec2<i32>, o: vec3<f32>, x: vec3<f32>, y: f32, z: f32) -> mat3x4<f32> {
    let size = abs(push.xyz);
    let share = size * (push.w / (size.x + size.y + size.z));
    var there = mat3x4<f32>();
    for (var d = 0; d < 3; d++) {
        let w = vec3<f32>(x[d], y, z);
        let face = at_faces(vec3<i32>(d, at), o, arm, w);
        let at_node = vec3<f32>(face.x * y * z, w.x * face.y * z, w.x * y * face.z);
        there[d] = vec4<f32>(push.xyz * at_node, dot(share, at_node));
    }
    return there;
}

// The same of grains and their walls.
fn of_grains(i: u32, at: vec2<i32>) -> mat3x4<f32> {
    return mat3x4<f32>(force_of_grains(i, vec3<i32>(0, at)), force_of_grains(i, vec3<i32>(1, at)), force_of_grains(i, vec3<i32>(2, at)));
}
