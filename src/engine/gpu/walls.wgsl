// The walls at the sides of the domain, node by node: what lies behind a wall is folded onto its mirror image, a node on the wall keeps what the wall lets, and a node behind it
// moves as its image does. Twins (f64): mpm/walls.rs and mpm/walls/friction.rs, where the method is documented. They fold one wall after the other; here each node finds by itself
// what all of them leave it, so nothing waits for a wall. A set of sides is a word with a bit for each.

// What a node has: momentum and mass, and the impulse of this step.
struct Content {
    momentum: vec4<f32>,
    impulse: vec3<f32>,
}

// A place that some walls fold onto a node, and which components keep their sign in that, as 1 and −1; across each axis the side that folds it, or BORDERS.
struct Image {
    place: vec3<i32>,
    parity: vec3<f32>,
    by: vec3<u32>,
}

fn unit(axis: u32) -> vec3<f32> {
    return select(vec3<f32>(0.0), vec3<f32>(1.0), vec3<u32>(0u, 1u, 2u) == vec3<u32>(axis));
}

fn holds(side: u32) -> bool {
    return params.walls[side].x == 1u || params.walls[side].x == 2u;
}

fn rubs(side: u32) -> bool {
    return params.walls[side].x == 3u;
}

fn friction_of(side: u32) -> f32 {
    return bitcast<f32>(params.walls[side].y);
}

fn sign_of(side: u32) -> f32 {
    return select(1.0, -1.0, side % 2u == 1u);
}

// Which components keep their sign in the mirror image across a wall, as 1 and −1; which ones the wall lets be at a node on its plane, as 1 and 0.
fn parity(side: u32) -> vec3<f32> {
    return select(vec3<f32>(1.0) - 2.0 * unit(side / 2u), vec3<f32>(-1.0), params.walls[side].x == 2u);
}

fn stays_at(side: u32) -> vec3<f32> {
    return max(parity(side), vec3<f32>(0.0));
}

fn last_node(axis: u32) -> i32 {
    return node_size()[axis] - 1;
}

// Places along the axis of a wall: behind it, on its plane, in front of it.
fn behind_of(side: u32) -> i32 {
    return select(0, last_node(side / 2u), side % 2u == 1u);
}

fn plane_of(side: u32) -> i32 {
    return select(1, last_node(side / 2u) - 1, side % 2u == 1u);
}

fn front_of(side: u32) -> i32 {
    return select(2, last_node(side / 2u) - 2, side % 2u == 1u);
}

// Number of nodes in the plane of a wall across `axis`.
fn plane_size(axis: u32) -> u32 {
    let n = vec3<u32>(node_size());
    return n.x * n.y * n.z / n[axis];
}

// Index in `touching` of the first node of a wall: sides without a wall have no entries.
fn plane_first(side: u32) -> u32 {
    var first = 0u;
    for (var s = 0u; s < side; s++) {
        first += select(0u, plane_size(s / 2u), params.walls[s].x != 0u);
    }
    return first;
}

// Index in `touching` of a node on the plane of a wall.
fn entry_of(side: u32, at: vec3<i32>) -> u32 {
    let b = (side / 2u + 1u) % 3u;
    let c = (side / 2u + 2u) % 3u;
    return plane_first(side) + u32(at[b] + node_size()[b] * at[c]);
}

fn has(sides: u32, side: u32) -> bool {
    return ((sides >> side) & 1u) != 0u;
}

// The sides that hold, of those below `below`.
fn holding(below: u32) -> u32 {
    var sides = 0u;
    for (var side = 0u; side < BORDERS; side++) {
        sides |= select(0u, 1u << side, side < below && holds(side));
    }
    return sides;
}

// The sides with friction.
fn rubbing() -> u32 {
    var sides = 0u;
    for (var side = 0u; side < BORDERS; side++) {
        sides |= select(0u, 1u << side, rubs(side));
    }
    return sides;
}

// Of these sides, those on whose planes a node is.
fn planes_at(at: vec3<i32>, among: u32) -> u32 {
    var sides = 0u;
    for (var side = 0u; side < BORDERS; side++) {
        sides |= select(0u, 1u << side, has(among, side) && at[side / 2u] == plane_of(side));
    }
    return sides;
}

// The image of a place in front of those of these sides behind which it lies.
fn in_front(at: vec3<i32>, sides: u32) -> Image {
    var image = Image(at, vec3<f32>(1.0), vec3<u32>(BORDERS));
    for (var side = 0u; side < BORDERS; side++) {
        if has(sides, side) && at[side / 2u] == behind_of(side) {
            image.place[side / 2u] = front_of(side);
            image.parity *= parity(side);
        }
    }
    return image;
}

// How many places along each axis these sides fold onto a node, itself included.
fn images_along(at: vec3<i32>, sides: u32) -> vec3<u32> {
    var along = vec3<u32>(1u);
    for (var side = 0u; side < BORDERS; side++) {
        along[side / 2u] += u32(has(sides, side) && at[side / 2u] == front_of(side));
    }
    return along;
}

// One of these places, by its number along each axis.
fn image_of(at: vec3<i32>, sides: u32, number: vec3<u32>) -> Image {
    var image = Image(at, vec3<f32>(1.0), vec3<u32>(BORDERS));
    for (var axis = 0u; axis < 3u; axis++) {
        if number[axis] > 0u {
            let low = has(sides, 2u * axis) && at[axis] == front_of(2u * axis);
            let side = 2u * axis + select(1u, 0u, low && number[axis] == 1u);
            image.place[axis] = behind_of(side);
            image.parity *= parity(side);
            image.by[axis] = side;
        }
    }
    return image;
}

// The number of the next one, x first.
fn next_image(number: vec3<u32>, along: vec3<u32>) -> vec3<u32> {
    let x = number.x + 1u;
    let y = number.y + u32(x == along.x);
    return vec3<u32>(select(x, 0u, x == along.x), select(y, 0u, y == along.y), number.z + u32(y == along.y));
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

// What a node has once these sides, which hold, have folded what lies behind them: nothing for a node behind one of them.
fn folded(at: vec3<i32>, sides: u32, moving: bool) -> Content {
    var sum = Content(vec4<f32>(0.0), vec3<f32>(0.0));
    let along = images_along(at, sides);
    let count = along.x * along.y * along.z;
    var number = vec3<u32>(0u);
    for (var k = 0u; k < count; k++) {
        let image = image_of(at, sides, number);
        var sign = image.parity;
        for (var side = 0u; side < BORDERS; side++) {
            // the walls before the one that folds it have held already
            let still = image.by[side / 2u] == BORDERS || side > image.by[side / 2u];
            if still && has(sides, side) && at[side / 2u] == plane_of(side) {
                sign *= stays_at(side);
            }
        }
        let own = own_content(image.place, moving);
        sum.momentum += own.momentum * vec4<f32>(sign, 1.0);
        sum.impulse += own.impulse * sign;
        number = next_image(number, along);
    }
    if any(in_front(at, sides).place != at) {
        return Content(vec4<f32>(0.0), vec3<f32>(0.0));
    }
    return sum;
}

// The sides with friction of whose rows of three nodes, or of whose images behind other walls with friction, a place is part.
fn rows_at(at: vec3<i32>) -> u32 {
    let x = in_front(at, rubbing()).place;
    var sides = 0u;
    for (var side = 0u; side < BORDERS; side++) {
        let axis = side / 2u;
        sides |= select(0u, 1u << side, rubs(side) && (x[axis] == plane_of(side) || x[axis] == front_of(side)));
    }
    return sides;
}

// Whether a wall with friction acts on its row of nodes through `at`, after the walls that hold: whether it has to push, or, where the nodes are not `moving`, acted when they were.
// Decided for the row and its images in other walls with friction together.
fn acts(side: u32, at: vec3<i32>, moving: bool) -> bool {
    let axis = side / 2u;
    let others = rubbing() & ~(3u << (2u * axis));
    var on = in_front(at, others).place;
    on[axis] = plane_of(side);
    let along = images_along(on, others);
    let count = along.x * along.y * along.z;
    var number = vec3<u32>(0u);
    var sum = 0.0;
    var behind = false;
    for (var k = 0u; k < 2u * count; k++) {
        var there = image_of(on, others, number).place;
        there[axis] = select(there[axis], behind_of(side), behind);
        let had = folded(there, holding(BORDERS), moving);
        // what is behind counts twice, with its image
        sum += select(1.0, 2.0, behind) * (had.momentum[axis] + had.impulse[axis]);
        if behind {
            number = next_image(number, along);
        }
        behind = !behind;
    }
    return -sign_of(side) * sum > 0.0 || (!moving && touching[entry_of(side, on)].w > 0.0);
}

// What a node has once all walls have folded, of those with friction the sides `acting`, each of which has taken away the momentum across it on its plane; minus what they have
// given there is still among the impulses.
fn rubbed_content(at: vec3<i32>, acting: u32, moving: bool) -> Content {
    var sum = Content(vec4<f32>(0.0), vec3<f32>(0.0));
    let along = images_along(at, acting);
    let count = along.x * along.y * along.z;
    var number = vec3<u32>(0u);
    for (var k = 0u; k < count; k++) {
        let image = image_of(at, acting, number);
        let planes = planes_at(image.place, acting);
        // the node behind each of these planes, which counts twice, and the node itself
        for (var rest = planes | (1u << BORDERS); rest != 0u; rest &= rest - 1u) {
            let side = firstTrailingBit(rest);
            let axis = min(side, BORDERS - 1u) / 2u;
            var there = image.place;
            there[axis] = select(there[axis], behind_of(side), side < BORDERS);
            let had = folded(there, holding(BORDERS), moving);
            if side < BORDERS {
                sum.impulse += 2.0 * image.parity * unit(axis) * had.impulse;
            } else {
                sum.momentum += vec4<f32>(image.parity * let_be(planes), 1.0) * had.momentum;
                sum.impulse += image.parity * had.impulse;
            }
        }
        number = next_image(number, along);
    }
    return sum;
}

// Which components these walls let be at a node on their planes, as 1 and 0.
fn let_be(planes: u32) -> vec3<f32> {
    var stays = vec3<f32>(1.0);
    for (var side = 0u; side < BORDERS; side++) {
        stays *= select(vec3<f32>(1.0), stays_at(side), has(planes, side));
    }
    return stays;
}

// What walls with friction do to a node on their planes.
struct Rubbing {
    // across each axis: impulse of the wall that presses, and the largest impulse of its friction; the sum of these
    given: vec3<f32>,
    limits: vec3<f32>,
    limit: f32,
    // momentum along the walls without friction, and the part that friction leaves
    along: vec3<f32>,
    kept: f32,
}

fn rubbing_of(own: Content, planes: u32) -> Rubbing {
    var found = Rubbing(vec3<f32>(0.0), vec3<f32>(0.0), 0.0, vec3<f32>(0.0), 1.0);
    for (var side = 0u; side < BORDERS; side++) {
        if has(planes, side) {
            let axis = side / 2u;
            found.given[axis] = -own.impulse[axis];
            found.limits[axis] = friction_of(side) * max(-own.impulse[axis] * sign_of(side), 0.0);
        }
    }
    found.along = (own.momentum.xyz + own.impulse) * let_be(planes);
    let size = sqrt(dot(found.along, found.along));
    found.limit = found.limits.x + found.limits.y + found.limits.z;
    if found.limit > 0.0 {
        found.kept = select(0.0, 1.0 - found.limit / max(size, 1e-37), size > found.limit);
    }
    return found;
}

// The impulse of one of these walls: its own push and its share of the friction.
fn given_by(side: u32, node: Rubbing) -> vec3<f32> {
    let axis = side / 2u;
    let share = node.limits[axis] / max(node.limit, 1e-37);
    return unit(axis) * node.given + share * (node.along * node.kept - node.along);
}

// Velocity, and its change where the node is `moving`, of the node `k` at a place.
fn node_at_walls(k: u32, at: vec3<i32>, moving: bool) {
    let held = holding(BORDERS);
    let held_image = in_front(at, held);
    var seen = held_image.place;
    var sign = held_image.parity;
    var acting = 0u;
    var own: Content;
    // for each wall that holds on whose plane the node is: what it and the node behind it had before that wall
    var rest = select(0u, planes_at(at, held), moving);
    if RUBBED {
        for (var rows = rows_at(seen); rows != 0u; rows &= rows - 1u) {
            let side = min(firstTrailingBit(rows), BORDERS - 1u);
            acting |= select(0u, 1u << side, acts(side, seen, moving));
        }
        let image = in_front(seen, acting);
        seen = image.place;
        sign *= image.parity;
        own = rubbed_content(seen, acting, moving);
    } else {
        // and what it has after all of them
        rest |= 1u << BORDERS;
    }
    if moving || !RUBBED {
        var needed = vec3<f32>(0.0);
        var behind = false;
        while rest != 0u {
            let side = firstTrailingBit(rest);
            let wall = min(side, BORDERS - 1u);
            var place = select(at, seen, side == BORDERS);
            place[wall / 2u] = select(place[wall / 2u], behind_of(wall), behind);
            let there = folded(place, holding(side), moving);
            if side == BORDERS {
                own = there;
            } else if behind {
                touching[entry_of(wall, at)] = vec4<f32>((needed - 2.0 * there.impulse) * (vec3<f32>(1.0) - stays_at(wall)), 1.0);
            } else {
                needed = -there.impulse;
            }
            behind = !behind && side < BORDERS;
            rest = select(rest & (rest - 1u), rest, behind);
        }
    }
    if RUBBED {
        let planes = planes_at(seen, acting);
        let node = rubbing_of(own, planes);
        if moving {
            // the node behind a wall that acts has nothing left
            let left = all(seen == at);
            for (var sides = planes_at(at, rubbing()); sides != 0u; sides &= sides - 1u) {
                let side = min(firstTrailingBit(sides), BORDERS - 1u);
                let given = select(vec3<f32>(0.0), given_by(side, node), left && has(acting, side));
                touching[entry_of(side, at)] = vec4<f32>(given, f32(has(acting, side)));
            }
        }
        own.momentum *= vec4<f32>(let_be(planes), 1.0);
        own.impulse = select(own.impulse * let_be(planes), node.along * node.kept - own.momentum.xyz, node.limit > 0.0);
    }
    // again, as in a domain one cell wide the opposite wall has folded onto the plane
    let stays = let_be(planes_at(seen, held));
    let over = select(0.0, 1.0 / own.momentum.w, own.momentum.w > 0.0);
    let v = own.momentum.xyz * stays * over * sign;
    if !moving {
        nodes[SPEED * params.cells + k] = vec4<f32>(v, 0.0);
        return;
    }
    var stiffness_rate = 0.0;
    if PRESSED || GRAINS {
        let mass = nodes[MOMENTUM * params.cells + k].w;
        stiffness_rate = select(0.0, from_tiles(at).w / mass, mass > 0.0);
    }
    damped_velocity(k, v, vec4<f32>(own.impulse * stays * over * sign, stiffness_rate));
}

// Forces of the walls on the material in the last step, from the impulses at their nodes.
fn sum_walls(thread: u32) {
    for (var side = 0u; side < BORDERS; side++) {
        if params.walls[side].x == 0u {
            continue;
        }
        var own = vec3<f32>(0.0);
        for (var t = thread; t < plane_size(side / 2u); t += WIDE) {
            own += touching[plane_first(side) + t].xyz;
        }
        let sum = plain_total(thread, vec4<f32>(own, 0.0));
        if thread == 0u {
            status.reaction[side] = sum / batch.dt;
        }
        workgroupBarrier();
    }
}
