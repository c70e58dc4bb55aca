// The walls at the sides of the domain, in one workgroup with a barrier after each wall. Twin (f64): mpm/walls.rs, where the method is documented.

const WALL_THREADS: u32 = 256u;

var<workgroup> partial: array<vec3<f32>, 256>;

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

struct Folded {
    touches: bool,
    given: vec3<f32>,
}

// Adds what the node behind the wall has to the node in front of it, mirrored, and applies the condition of the wall to the node on it; for a wall with friction only if
// the wall presses on the material, or where `held` says that it touches. Returns whether the wall touches, and the impulse that it gives.
fn fold(side: u32, t: u32, held: bool) -> Folded {
    let axis = side / 2u;
    let across = unit(axis);
    let sign_of = select(1.0, -1.0, side % 2u == 1u);
    let kind = params.walls[side].x;
    let behind = node_index(wall_node(side, t, 0));
    let on = node_index(wall_node(side, t, 1));
    let before = node_index(wall_node(side, t, 2));
    let P = SPEED * params.nodes;
    let I = CHANGE * params.nodes;
    let p_behind = nodes[P + behind];
    let i_behind = nodes[I + behind].xyz;
    let p_on = nodes[P + on];
    let i_on = nodes[I + on].xyz;
    let needed = -(i_on + 2.0 * i_behind);
    let pushes = sign_of * dot(across, needed - (p_on.xyz + 2.0 * p_behind.xyz)) > 0.0;
    if kind == 3u && !(pushes || held) {
        return Folded(false, vec3<f32>(0.0));
    }
    let mirror = select(vec3<f32>(1.0) - 2.0 * across, vec3<f32>(-1.0), kind == 2u);
    nodes[P + before] += vec4<f32>(mirror * p_behind.xyz, p_behind.w);
    nodes[I + before] += vec4<f32>(mirror * i_behind, 0.0);
    nodes[P + behind] = vec4<f32>(0.0);
    nodes[I + behind] = vec4<f32>(vec3<f32>(0.0), nodes[I + behind].w);
    if kind == 2u {
        nodes[P + on] = vec4<f32>(0.0, 0.0, 0.0, p_on.w);
        nodes[I + on] = vec4<f32>(vec3<f32>(0.0), nodes[I + on].w);
        return Folded(true, needed);
    }
    let tangent = vec3<f32>(1.0) - across;
    let p = p_on.xyz * tangent;
    var i = i_on * tangent;
    var given = across * needed;
    let friction = bitcast<f32>(params.walls[side].y);
    if kind == 3u && friction > 0.0 {
        let limit = friction * max(sign_of * dot(across, needed), 0.0);
        let along = p + i;
        let size = sqrt(dot(along, along));
        let kept = select(0.0, 1.0 - limit / max(size, 1e-37), size > limit);
        given += along * kept - along;
        i = along * kept - p;
    }
    nodes[P + on] = vec4<f32>(p, p_on.w);
    nodes[I + on] = vec4<f32>(i, nodes[I + on].w);
    return Folded(true, given);
}

// Applies all walls; `moving`: to forces and velocities of a step, not to the velocities after projection alone.
fn all_walls(thread: u32, moving: bool) {
    let P = SPEED * params.nodes;
    let I = CHANGE * params.nodes;
    for (var side = 0u; side < 6u; side++) {
        if params.walls[side].x == 0u {
            continue;
        }
        var sum = vec3<f32>(0.0);
        let first = plane_first(side);
        for (var t = thread; t < plane_size(side / 2u); t += WALL_THREADS) {
            let folded = fold(side, t, !moving && (touching[first + t] & 2u) != 0u);
            touching[first + t] = select(0u, select(1u, 3u, moving), folded.touches);
            sum += folded.given;
        }
        partial[thread] = sum;
        workgroupBarrier();
        storageBarrier();
        for (var half = WALL_THREADS / 2u; half > 0u; half /= 2u) {
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
    // velocities
    for (var side = 0u; side < 6u; side++) {
        if params.walls[side].x == 0u {
            continue;
        }
        for (var t = thread; t < plane_size(side / 2u); t += WALL_THREADS) {
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
    for (var side = 0u; side < 6u; side++) {
        if params.walls[side].x == 0u {
            continue;
        }
        let first = plane_first(side);
        let stays = select(vec4<f32>(vec3<f32>(1.0) - unit(side / 2u), 0.0), vec4<f32>(0.0), params.walls[side].x == 2u);
        for (var t = thread; t < plane_size(side / 2u); t += WALL_THREADS) {
            if (touching[first + t] & 1u) != 0u {
                let k = node_index(wall_node(side, t, 1));
                nodes[P + k] *= stays;
                nodes[I + k] *= vec4<f32>(stays.xyz, 1.0);
            }
        }
        storageBarrier();
    }
    for (var r = 0u; r < 6u; r++) {
        let side = 5u - r;
        if params.walls[side].x == 0u {
            continue;
        }
        let first = plane_first(side);
        let mirror = select(vec4<f32>(vec3<f32>(1.0) - 2.0 * unit(side / 2u), 0.0), vec4<f32>(-1.0, -1.0, -1.0, 0.0), params.walls[side].x == 2u);
        for (var t = thread; t < plane_size(side / 2u); t += WALL_THREADS) {
            if (touching[first + t] & 1u) != 0u {
                let behind = node_index(wall_node(side, t, 0));
                let before = node_index(wall_node(side, t, 2));
                nodes[P + behind] = nodes[P + before] * mirror;
                nodes[I + behind] = vec4<f32>(nodes[I + before].xyz * mirror.xyz, nodes[I + behind].w);
            }
        }
        storageBarrier();
    }
    if !moving {
        return;
    }
    for (var side = 0u; side < 6u; side++) {
        if params.walls[side].x == 0u {
            continue;
        }
        for (var t = thread; t < plane_size(side / 2u); t += WALL_THREADS) {
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

@compute @workgroup_size(256)
fn walls_project(@builtin(local_invocation_index) thread: u32) {
    all_walls(thread, false);
}

@compute @workgroup_size(256)
fn walls_accelerate(@builtin(local_invocation_index) thread: u32) {
    all_walls(thread, true);
}
