// Walls that hold the material (symmetry, stick), node by node, in scenes without walls with friction: what lies behind a wall is folded onto its mirror image, a node on the wall
// keeps what the wall lets, and a node behind it moves as its image does. Twins (f64): mpm/walls.rs, where the method is documented; walls.wgsl has all walls together.

// What a node has: momentum and mass, and the impulse of this step.
struct Content {
    momentum: vec4<f32>,
    impulse: vec3<f32>,
}

// Whether a wall holds the side, one of those below `below`.
fn has_wall(side: u32, below: u32) -> bool {
    return side < below && params.walls[side].x != 0u;
}

fn last_node(axis: u32) -> i32 {
    return node_size()[axis] - 1;
}

// Place along an axis of the plane of a wall, and behind it.
fn plane_of(side: u32) -> i32 {
    return select(1, last_node(side / 2u) - 1, side % 2u == 1u);
}

fn behind_of(side: u32) -> i32 {
    return select(0, last_node(side / 2u), side % 2u == 1u);
}

// Which components a wall lets be at a node on its plane, as 1 and 0.
fn stays_at(side: u32) -> vec3<f32> {
    return max(parity(side), vec3<f32>(0.0));
}

// What the tiles have for a node by itself; nodes with next to no mass are empty.
fn own_content(at: vec3<i32>, moving: bool) -> Content {
    if !moving {
        let sum = from_tiles(at);
        return Content(select(sum, vec4<f32>(0.0), sum.w < params.mass_floor), vec3<f32>(0.0));
    }
    let momentum = nodes[MOMENTUM * params.cells + node_index(at)];
    let force = momentum.w * params.gravity + from_tiles(at).xyz;
    return Content(momentum, select(vec3<f32>(0.0), force * batch.dt, momentum.w > 0.0));
}

// How many places along an axis are folded onto `at` by the sides below `below`, itself included.
fn images_along(axis: u32, at: vec3<i32>, below: u32) -> u32 {
    let low = at[axis] == 2 && has_wall(2u * axis, below);
    let high = at[axis] == last_node(axis) - 2 && has_wall(2u * axis + 1u, below);
    return 1u + u32(low) + u32(high);
}

// The side whose wall folds the `k`-th of these places, from 1 on.
fn side_of_image(axis: u32, at: vec3<i32>, below: u32, k: u32) -> u32 {
    let low = at[axis] == 2 && has_wall(2u * axis, below);
    return 2u * axis + select(1u, 0u, low && k == 1u);
}

// What a node has once the sides below `below` have folded what lies behind them: nothing for a node behind one of them.
fn folded(at: vec3<i32>, below: u32, moving: bool) -> Content {
    var sum = Content(vec4<f32>(0.0), vec3<f32>(0.0));
    let along = vec3<u32>(images_along(0u, at, below), images_along(1u, at, below), images_along(2u, at, below));
    let count = along.x * along.y * along.z;
    var image = vec3<u32>(0u);
    for (var k = 0u; k < count; k++) {
        var there = at;
        var sign = vec3<f32>(1.0);
        for (var axis = 0u; axis < 3u; axis++) {
            // walls before this one have not held what it folds until all have folded
            var held_from = 2u * axis;
            if image[axis] > 0u {
                let side = min(side_of_image(axis, at, below, image[axis]), BORDERS - 1u);
                there[axis] = behind_of(side);
                sign *= parity(side);
                held_from = select(side + 1u, held_from, below == BORDERS);
            }
            for (var side = held_from; side < 2u * axis + 2u; side++) {
                if has_wall(side, below) && at[axis] == plane_of(side) {
                    sign *= stays_at(side);
                }
            }
        }
        let own = own_content(there, moving);
        sum.momentum += own.momentum * vec4<f32>(sign, 1.0);
        sum.impulse += own.impulse * sign;
        // the next one, x first
        image.x += 1u;
        let y_next = image.x == along.x;
        image.y += u32(y_next);
        let z_next = image.y == along.y;
        image = vec3<u32>(select(image.x, 0u, y_next), select(image.y, 0u, z_next), image.z + u32(z_next));
    }
    for (var side = 0u; side < BORDERS; side++) {
        if has_wall(side, below) && at[side / 2u] == behind_of(side) {
            return Content(vec4<f32>(0.0), vec3<f32>(0.0));
        }
    }
    return sum;
}

// The first side from `side` on that has a wall on whose plane a node is; BORDERS: none.
fn next_plane(at: vec3<i32>, side: u32) -> u32 {
    for (var s = side; s < BORDERS; s++) {
        if has_wall(s, BORDERS) && at[s / 2u] == plane_of(s) {
            return s;
        }
    }
    return BORDERS;
}

// Keeps the impulse of a wall at a node on its plane.
fn keep_impulse(side: u32, at: vec3<i32>, needed: vec3<f32>) {
    let given = needed * (vec3<f32>(1.0) - stays_at(side));
    let first = 3u * (plane_first(side) + number_on(side / 2u, at));
    touching[first] = bitcast<u32>(given.x);
    touching[first + 1u] = bitcast<u32>(given.y);
    touching[first + 2u] = bitcast<u32>(given.z);
}

// Velocity, and its change where the node is `moving`, of the node `k` at a place.
fn held_node(k: u32, at: vec3<i32>, moving: bool) {
    var seen = at;
    var sign = vec3<f32>(1.0);
    for (var side = 0u; side < BORDERS; side++) {
        let axis = side / 2u;
        if has_wall(side, BORDERS) && at[axis] == behind_of(side) {
            seen[axis] = select(2, last_node(axis) - 2, side % 2u == 1u);
            sign *= parity(side);
        }
    }
    // what the node has after all walls; then, for each wall on whose plane it is, what it and the node behind it had before that wall
    var own: Content;
    var needed = vec3<f32>(0.0);
    var side = BORDERS;
    var behind = false;
    loop {
        var place = select(at, seen, side == BORDERS);
        if behind {
            place[side / 2u] = behind_of(side);
        }
        let there = folded(place, side, moving);
        if side == BORDERS {
            own = there;
            side = select(BORDERS, next_plane(at, 0u), moving);
        } else if behind {
            keep_impulse(min(side, BORDERS - 1u), at, needed - 2.0 * there.impulse);
            side = next_plane(at, side + 1u);
            behind = false;
        } else {
            needed = -there.impulse;
            behind = true;
        }
        if side == BORDERS {
            break;
        }
    }
    let over = select(0.0, 1.0 / own.momentum.w, own.momentum.w > 0.0);
    let v = own.momentum.xyz * over * sign;
    if !moving {
        nodes[SPEED * params.cells + k] = vec4<f32>(v, 0.0);
        return;
    }
    var stiffness_rate = 0.0;
    if PRESSED || GRAINS {
        let mass = nodes[MOMENTUM * params.cells + k].w;
        stiffness_rate = select(0.0, from_tiles(at).w / mass, mass > 0.0);
    }
    damped_velocity(k, v, vec4<f32>(own.impulse * over * sign, stiffness_rate));
}

// Forces of the walls on the material in the last step, from the impulses at their nodes.
fn sum_held_walls(thread: u32) {
    for (var side = 0u; side < BORDERS; side++) {
        if params.walls[side].x == 0u {
            continue;
        }
        var sum = vec3<f32>(0.0);
        for (var t = thread; t < plane_size(side / 2u); t += WIDE) {
            let first = 3u * (plane_first(side) + t);
            sum += bitcast<vec3<f32>>(vec3<u32>(touching[first], touching[first + 1u], touching[first + 2u]));
        }
        add_up(thread, side, sum, true);
    }
}
