// The walls at the sides of the domain, in one workgroup with a barrier after each wall. Twins (f64): mpm/walls.rs and mpm/walls/friction.rs, where the method is documented.

var<workgroup> partial: array<vec3<f32>, WIDE>;

// Number of nodes in the plane of a wall across `axis`.
fn plane_size(axis: u32) -> u32 {
    let n = vec3<u32>(node_size());
    return n.x * n.y * n.z / n[axis];
}

// Index in `touching` of the first node of a wall.
fn plane_first(side: u32) -> u32 {
    var first = 0u;
    for (var s = 0u; s < side; s++) {
        first += plane_size(s / 2u);
    }
    return first;
}

// The `t`-th node of the plane `layer`: 0 behind the wall, 1 on it, 2 in front of it.
fn wall_node(side: u32, t: u32, layer: i32) -> vec3<i32> {
    let axis = side / 2u;
    let n = node_size();
    let b = (axis + 1u) % 3u;
    let c = (axis + 2u) % 3u;
    var at = vec3<i32>(0);
    at[b] = i32(t) % n[b];
    at[c] = i32(t) / n[b];
    at[axis] = select(layer, n[axis] - 1 - layer, side % 2u == 1u);
    return at;
}

// Whether the node `at` is finished with this side: of several walls close to a node the first one does it.
fn owned(side: u32, at: vec3<i32>) -> bool {
    for (var s = 0u; s < side; s++) {
        if params.walls[s].x != 0u {
            let x = at[s / 2u];
            if (s % 2u == 0u && x <= 2) || (s % 2u == 1u && x >= params.size[s / 2u]) {
                return false;
            }
        }
    }
    return true;
}

fn unit(axis: u32) -> vec3<f32> {
    return select(vec3<f32>(0.0), vec3<f32>(1.0), vec3<u32>(0u, 1u, 2u) == vec3<u32>(axis));
}

fn rubs(side: u32) -> bool {
    return params.walls[side].x == 3u;
}

fn holds(side: u32) -> bool {
    return params.walls[side].x == 1u || params.walls[side].x == 2u;
}

fn sign_of(side: u32) -> f32 {
    return select(1.0, -1.0, side % 2u == 1u);
}

// Which components keep their sign in the mirror image across a wall, as 1 and -1.
fn parity(side: u32) -> vec3<f32> {
    return select(vec3<f32>(1.0) - 2.0 * unit(side / 2u), vec3<f32>(-1.0), params.walls[side].x == 2u);
}

// The impulse that a wall must give so that nothing passes.
fn needed(side: u32, t: u32) -> vec3<f32> {
    let I = CHANGE * params.cells;
    return -(nodes[I + node_index(wall_node(side, t, 1))].xyz + 2.0 * nodes[I + node_index(wall_node(side, t, 0))].xyz);
}

// Adds what the node behind the wall has to the node in front of it, mirrored.
fn mirror(side: u32, t: u32) {
    let P = SPEED * params.cells;
    let I = CHANGE * params.cells;
    let behind = node_index(wall_node(side, t, 0));
    let before = node_index(wall_node(side, t, 2));
    let p_behind = nodes[P + behind];
    nodes[P + before] += vec4<f32>(parity(side) * p_behind.xyz, p_behind.w);
    nodes[I + before] += vec4<f32>(parity(side) * nodes[I + behind].xyz, 0.0);
    nodes[P + behind] = vec4<f32>(0.0);
    nodes[I + behind] = vec4<f32>(vec3<f32>(0.0), nodes[I + behind].w);
}

// Folds a wall that holds the material, and returns the impulse that it gives.
fn hold(side: u32, t: u32) -> vec3<f32> {
    let P = SPEED * params.cells;
    let I = CHANGE * params.cells;
    let on = node_index(wall_node(side, t, 1));
    let given = needed(side, t);
    mirror(side, t);
    let stays = max(parity(side), vec3<f32>(0.0));
    nodes[P + on] = vec4<f32>(nodes[P + on].xyz * stays, nodes[P + on].w);
    nodes[I + on] = vec4<f32>(nodes[I + on].xyz * stays, nodes[I + on].w);
    return given * (vec3<f32>(1.0) - stays);
}

// The impulse with which a wall with friction has to push at its `t`-th node.
fn push(side: u32, t: u32) -> f32 {
    let P = SPEED * params.cells;
    let axis = side / 2u;
    let p = nodes[P + node_index(wall_node(side, t, 1))][axis] + 2.0 * nodes[P + node_index(wall_node(side, t, 0))][axis];
    return sign_of(side) * (needed(side, t)[axis] - p);
}

// Number of a node on the plane of a wall across `axis`, as `wall_node` counts.
fn number_on(axis: u32, at: vec3<i32>) -> u32 {
    let b = (axis + 1u) % 3u;
    return u32(at[b] + node_size()[b] * at[(axis + 2u) % 3u]);
}

// Place along `axis` of what a place behind a wall with friction is the image of; any other place is itself.
fn in_front(axis: u32, x: i32) -> i32 {
    let last = node_size()[axis] - 1;
    if x == 0 && rubs(2u * axis) {
        return 2;
    }
    return select(x, last - 2, x == last && rubs(2u * axis + 1u));
}

// Whether a wall with friction has to push at its `t`-th node: decided for the node and its images in other walls with friction together.
fn pushes(side: u32, t: u32) -> bool {
    let axis = side / 2u;
    let b = (axis + 1u) % 3u;
    let c = (axis + 2u) % 3u;
    let n = node_size();
    var at = wall_node(side, t, 1);
    at[b] = in_front(b, at[b]);
    at[c] = in_front(c, at[c]);
    // the places behind walls whose image is this one, and itself
    let bs = vec3<i32>(at[b], 0, n[b] - 1);
    let cs = vec3<i32>(at[c], 0, n[c] - 1);
    var sum = 0.0;
    for (var j = 0; j < 3; j++) {
        for (var k = 0; k < 3; k++) {
            if (j == 0 || (bs[j] != at[b] && in_front(b, bs[j]) == at[b])) && (k == 0 || (cs[k] != at[c] && in_front(c, cs[k]) == at[c])) {
                var other = at;
                other[b] = bs[j];
                other[c] = cs[k];
                sum += push(side, number_on(axis, other));
            }
        }
    }
    return sum > 0.0;
}

// What walls with friction do to a node on the plane of one of them.
struct Rubbing {
    // across each axis: impulse of the wall that presses, and the largest impulse of its friction
    given: vec3<f32>,
    limits: vec3<f32>,
    // momentum along the walls without friction, the part that friction leaves, the same without the impulse
    along: vec3<f32>,
    kept: f32,
    p: vec3<f32>,
}

// Whether the wall with friction on this side is at a node, and touches it.
fn presses(side: u32, at: vec3<i32>) -> bool {
    let axis = side / 2u;
    return rubs(side) && at[axis] == select(1, node_size()[axis] - 2, side % 2u == 1u) && (touching[plane_first(side) + number_on(axis, at)] & 1u) != 0u;
}

// The first side whose friction acts on a node; BORDERS: none does.
fn first_to_rub(at: vec3<i32>) -> u32 {
    for (var side = 0u; side < BORDERS; side++) {
        if presses(side, at) && bitcast<f32>(params.walls[side].y) > 0.0 {
            return side;
        }
    }
    return BORDERS;
}

fn rubbing(at: vec3<i32>) -> Rubbing {
    let node = node_index(at);
    let i = nodes[CHANGE * params.cells + node].xyz;
    var found = Rubbing(vec3<f32>(0.0), vec3<f32>(0.0), vec3<f32>(0.0), 1.0, vec3<f32>(0.0));
    var free = vec3<f32>(1.0);
    for (var side = 0u; side < BORDERS; side++) {
        if presses(side, at) {
            let axis = side / 2u;
            found.given[axis] = -i[axis];
            found.limits[axis] = bitcast<f32>(params.walls[side].y) * max(-i[axis] * sign_of(side), 0.0);
            free[axis] = 0.0;
        }
    }
    found.p = nodes[SPEED * params.cells + node].xyz * free;
    found.along = found.p + i * free;
    let size = sqrt(dot(found.along, found.along));
    let limit = found.limits.x + found.limits.y + found.limits.z;
    found.kept = select(0.0, 1.0 - limit / max(size, 1e-37), size > limit);
    return found;
}

// The impulse of a wall with friction at its `t`-th node, where it touches: its own push and its share of the friction.
fn given(side: u32, t: u32) -> vec3<f32> {
    let node = rubbing(wall_node(side, t, 1));
    let own = node.limits[side / 2u];
    let share = select(0.0, own / max(node.limits.x + node.limits.y + node.limits.z, 1e-37), own > 0.0);
    return unit(side / 2u) * node.given + share * (node.along * node.kept - node.along);
}

// Adds up the impulse of a wall over the threads.
fn add_up(thread: u32, side: u32, sum: vec3<f32>, moving: bool) {
    partial[thread] = sum;
    workgroupBarrier();
    storageBarrier();
    for (var half = WIDE / 2u; half > 0u; half /= 2u) {
        if thread < half {
            partial[thread] += partial[thread + half];
        }
        workgroupBarrier();
    }
    if thread == 0u && moving {
        status.reaction[side] = vec4<f32>(partial[0] / batch.dt, 0.0);
    }
    workgroupBarrier();
}

// Folds the walls with friction, all together (mpm/walls/friction.rs).
fn rub(thread: u32, moving: bool) {
    for (var side = 0u; side < BORDERS; side++) {
        if rubs(side) {
            let first = plane_first(side);
            for (var t = thread; t < plane_size(side / 2u); t += WIDE) {
                // where the wall touched at the last acceleration it still does
                let held = !moving && (touching[first + t] & 2u) != 0u;
                touching[first + t] = select(0u, select(1u, 3u, moving), held || pushes(side, t));
            }
        }
    }
    storageBarrier();
    // what the walls give across stays at the nodes on their planes, for another wall may fold it onto its image
    for (var side = 0u; side < BORDERS; side++) {
        if !rubs(side) {
            continue;
        }
        let axis = side / 2u;
        for (var t = thread; t < plane_size(axis); t += WIDE) {
            if (touching[plane_first(side) + t] & 1u) != 0u {
                let across = needed(side, t)[axis];
                let on = node_index(wall_node(side, t, 1));
                nodes[SPEED * params.cells + on][axis] = 0.0;
                nodes[CHANGE * params.cells + on][axis] = -across;
            }
        }
        storageBarrier();
    }
    for (var side = 0u; side < BORDERS; side++) {
        if !rubs(side) {
            continue;
        }
        for (var t = thread; t < plane_size(side / 2u); t += WIDE) {
            if (touching[plane_first(side) + t] & 1u) != 0u {
                mirror(side, t);
            }
        }
        storageBarrier();
    }
    for (var side = 0u; side < BORDERS; side++) {
        if !rubs(side) {
            continue;
        }
        var sum = vec3<f32>(0.0);
        for (var t = thread; t < plane_size(side / 2u); t += WIDE) {
            if (touching[plane_first(side) + t] & 1u) != 0u {
                sum += given(side, t);
            }
        }
        add_up(thread, side, sum, moving);
    }
    // of several walls with friction that touch a node the first one rubs it
    for (var side = 0u; side < BORDERS; side++) {
        if !rubs(side) {
            continue;
        }
        for (var t = thread; t < plane_size(side / 2u); t += WIDE) {
            let at = wall_node(side, t, 1);
            if first_to_rub(at) == side {
                let node = rubbing(at);
                let k = CHANGE * params.cells + node_index(at);
                nodes[k] = vec4<f32>(node.along * node.kept - node.p, nodes[k].w);
            }
        }
    }
    storageBarrier();
}

// Applies all walls; `moving`: to forces and velocities of a step, not to the velocities after projection alone.
fn all_walls(thread: u32, moving: bool) {
    let P = SPEED * params.cells;
    let I = CHANGE * params.cells;
    var any = false;
    for (var side = 0u; side < BORDERS; side++) {
        any |= rubs(side);
        if !holds(side) {
            continue;
        }
        var sum = vec3<f32>(0.0);
        for (var t = thread; t < plane_size(side / 2u); t += WIDE) {
            sum += hold(side, t);
            touching[plane_first(side) + t] = select(1u, 3u, moving);
        }
        add_up(thread, side, sum, moving);
    }
    if any {
        rub(thread, moving);
    }
    // velocities
    for (var side = 0u; side < BORDERS; side++) {
        if params.walls[side].x == 0u {
            continue;
        }
        for (var t = thread; t < plane_size(side / 2u); t += WIDE) {
            for (var layer = 0; layer < 3; layer++) {
                let at = wall_node(side, t, layer);
                if owned(side, at) {
                    let k = node_index(at);
                    let p = nodes[P + k];
                    var over = 0.0;
                    if p.w > 0.0 {
                        over = 1.0 / p.w;
                    }
                    nodes[P + k] = vec4<f32>(p.xyz * over, 0.0);
                    nodes[I + k] = vec4<f32>(nodes[I + k].xyz * over, nodes[I + k].w);
                }
            }
        }
    }
    storageBarrier();
    // again, as in a domain one cell wide the opposite wall has added to this plane since
    for (var side = 0u; side < BORDERS; side++) {
        if params.walls[side].x == 0u {
            continue;
        }
        let first = plane_first(side);
        let stays = vec4<f32>(max(parity(side), vec3<f32>(0.0)), 0.0);
        for (var t = thread; t < plane_size(side / 2u); t += WIDE) {
            if (touching[first + t] & 1u) != 0u {
                let k = node_index(wall_node(side, t, 1));
                nodes[P + k] *= stays;
                nodes[I + k] *= vec4<f32>(stays.xyz, 1.0);
            }
        }
        storageBarrier();
    }
    // against the order of folding: what lies behind two walls is the image of an image
    for (var r = 0u; r < 2u * BORDERS; r++) {
        let side = BORDERS - 1u - r % BORDERS;
        if (r < BORDERS && !rubs(side)) || (r >= BORDERS && !holds(side)) {
            continue;
        }
        let first = plane_first(side);
        let mirrored = parity(side);
        for (var t = thread; t < plane_size(side / 2u); t += WIDE) {
            if (touching[first + t] & 1u) != 0u {
                let behind = node_index(wall_node(side, t, 0));
                let before = node_index(wall_node(side, t, 2));
                // no point reaches a node whose block has no slot
                if behind >= BLOCK {
                    nodes[P + behind] = vec4<f32>(nodes[P + before].xyz * mirrored, 0.0);
                    nodes[I + behind] = vec4<f32>(nodes[I + before].xyz * mirrored, nodes[I + behind].w);
                }
            }
        }
        storageBarrier();
    }
    if !moving {
        return;
    }
    for (var side = 0u; side < BORDERS; side++) {
        if params.walls[side].x == 0u {
            continue;
        }
        for (var t = thread; t < plane_size(side / 2u); t += WIDE) {
            for (var layer = 0; layer < 3; layer++) {
                let at = wall_node(side, t, layer);
                if owned(side, at) {
                    let k = node_index(at);
                    damped_velocity(k, nodes[P + k].xyz, nodes[I + k]);
                }
            }
        }
    }
}

@compute @workgroup_size(WIDE)
fn walls_project(@builtin(local_invocation_index) thread: u32) {
    all_walls(thread, false);
}

@compute @workgroup_size(WIDE)
fn walls_accelerate(@builtin(local_invocation_index) thread: u32) {
    all_walls(thread, true);
}
