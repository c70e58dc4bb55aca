// State of points and nodes, and what nodes do: one thread per node. Twins (f64): mpm/spline.rs, mpm/pass.rs, mpm/grid.rs, with which gpu/tests/step.rs compares it.

// Planes of the state of points, `points` entries each. A number that is a compensated sum has its low part in another plane.
const PLACE: u32 = 0u; // offset x, y, z in units (bits of i32); cell
const REST: u32 = 1u; // offset x, y, z: fractions of a unit; initial volume, m³
const VELOCITY: u32 = 2u; // velocity, m/s; mass, kg
const VELOCITY_LOW: u32 = 3u; // its low part; index of the law
const NORMAL: u32 = 4u; // stress xx, yy, zz, Pa; volume, m³
const SHEAR: u32 = 5u; // stress xy, yz, zx, Pa; accumulated plastic strain
const NORMAL_LOW: u32 = 6u; // low parts of NORMAL
const SHEAR_LOW: u32 = 7u; // low parts of SHEAR
const WORK: u32 = 8u; // stress work, J, and its low part; opening of the gap in soil that was pulled apart, and its low part
// with loading plates only
const ARM: u32 = 9u; // distance from the point to its pressed face along each axis, cells, with sign; 0 where no plate presses
const ARM_LOW: u32 = 10u; // its low part
// then what takes one word for each point, a quarter of a plane each: identity; ghost radius, units (bits of i32)

// Planes of the nodes, `cells` entries each, by their slots.
const MOMENTUM: u32 = 0u; // momentum, kg m/s; mass, kg
const SPEED: u32 = 1u; // velocity, m/s
const CHANGE: u32 = 2u; // change of the velocity in this step, m/s; stiffness of external forces over mass, 1/s²
// then the tiles of the blocks, TILE entries for each slot
const TILES: u32 = 3u;

struct Status {
    // the smallest 8 · identity + fault over all points with a fault; NO_FAULT where there is none
    fault: atomic<u32>,
    // number of points that have left their cell in this step
    crossed: atomic<u32>,
    // number of steps done; 1 where the remaining steps of the batch are skipped
    steps: u32,
    stop: u32,
    // bits of the largest sum of wave speed and speed of a point, m/s
    fastest: atomic<u32>,
    // number of slots in use
    slots: atomic<u32>,
    // force of each side of the domain on the material, N
    reaction: array<vec4<f32>, BORDERS>,
}

// Faults of points.

const NOT_FINITE: u32 = 0u;
const OUTSIDE: u32 = 1u;
const TOO_FAST: u32 = 2u;
const INVERTED: u32 = 3u;
const CROWDED: u32 = 4u;
const PASSED: u32 = 5u;
const NO_ROOM: u32 = 7u;
const NO_FAULT: u32 = 0xffffffffu;

@group(0) @binding(2) var<storage, read_write> state: array<vec4<u32>>;
@group(0) @binding(3) var<storage, read_write> nodes: array<vec4<f32>>;
// for each cell, by its slot, the number in the order of cells of its first point; the number of points; then the points in the order of cells, in a cell by identity
@group(0) @binding(4) var<storage, read_write> starts: array<u32>;
// number of points of each cell, then of each group of cells; while points are sorted, for each cell the next free number in the order; then the claims of the blocks
@group(0) @binding(5) var<storage, read_write> counts: array<atomic<u32>>;
@group(0) @binding(7) var<storage, read_write> status: Status;
// for each node in the plane of a wall: the impulse that the wall has given there in the last step, N s; 1 where it acted, else 0
@group(0) @binding(8) var<storage, read_write> touching: array<vec4<f32>>;

fn word(plane: u32, i: u32) -> vec4<u32> {
    return state[plane * params.points + i];
}

fn number(plane: u32, i: u32) -> vec4<f32> {
    return bitcast<vec4<f32>>(state[plane * params.points + i]);
}

fn put(plane: u32, i: u32, value: vec4<f32>) {
    state[plane * params.points + i] = bitcast<vec4<u32>>(value);
}

// The word of a point in the `k`-th quarter of a plane.
fn single(k: u32, i: u32) -> u32 {
    let planes = select(ARM, ARM_LOW + 1u, PRESSED);
    let quarter = (params.points + 3u) / 4u;
    return state[planes * params.points + k * quarter + i / 4u][i % 4u];
}

fn identity(i: u32) -> u32 {
    return single(0u, i);
}

fn radius_in_units(i: u32) -> i32 {
    return bitcast<i32>(single(1u, i));
}

// Index of the law of a point.
fn law_of(i: u32) -> u32 {
    if ONE_LAW {
        return 0u;
    }
    return word(VELOCITY_LOW, i).w;
}

// A thread in workgroups of GROUP.
struct Thread {
    @builtin(global_invocation_id) id: vec3<u32>,
    @builtin(num_workgroups) groups: vec3<u32>,
}

// Number of the thread.
fn linear(one: Thread) -> u32 {
    return one.id.x + one.id.y * one.groups.x * GROUP;
}

// The point with the number `p` in the order of cells.
fn nth(p: u32) -> u32 {
    return starts[params.cells + 1u + p];
}

fn offset(place: vec4<u32>) -> vec3<f32> {
    return vec3<f32>(bitcast<vec3<i32>>(place.xyz)) * (1.0 / UNITS);
}

// Quadratic B-splines (Li et al. 2023, eq. 10): along one axis the values for the first, middle and last of the three nodes that a point reaches. `o`: offset of the point
// from the middle node, cells.
fn spline(o: f32) -> vec3<f32> {
    let left = 0.5 - o;
    let right = 0.5 + o;
    return vec3<f32>(0.5 * left * left, 0.75 - o * o, 0.5 * right * right);
}

// Their derivatives, 1/cell.
fn spline_slope(o: f32) -> vec3<f32> {
    return vec3<f32>(o - 0.5, -2.0 * o, 0.5 + o);
}

// Weight of the node d along one axis for a traction on a face at the distance `arm`, cells, from the point: mpm/spline.rs, at_edge.
fn at_edge(d: i32, o: f32, arm: f32) -> f32 {
    let n = clamp(floor(0.5 / abs(arm) + 0.5), 1.0, 8.0);
    var sum = 0.0;
    for (var k = 0.5; k < n; k += 1.0) {
        let t = clamp(o + arm + k / n - 0.5, -1.0, 1.0);
        sum += max(1.0 - abs(t - f32(d - 1)), 0.0) / n;
    }
    return sum;
}

// The same along all axes; along axes without a pressed face the weights `w` of the point itself.
fn at_faces(d: vec3<i32>, o: vec3<f32>, arm: vec3<f32>, w: vec3<f32>) -> vec3<f32> {
    var there = w;
    for (var a = 0u; a < 3u; a++) {
        if arm[a] != 0.0 {
            there[a] = at_edge(d[a], o[a], arm[a]);
        }
    }
    return there;
}

// Place of a node in memory, for a slot that has a block.
fn node_place(k: u32) -> vec3<i32> {
    return place_in(cell_place(packed_place(k / BLOCK)), k % BLOCK);
}

// Whether the slot has a block, and the node lies in the domain, beyond which the last blocks reach.
fn exists(k: u32) -> bool {
    return packed_place(k / BLOCK) != NOWHERE && all(node_place(k) < node_size());
}

// What the tiles that reach a node have for it.
fn from_tiles(at: vec3<i32>) -> vec4<f32> {
    let block = at >> SHIFT;
    let inside = at & INSIDE;
    var sum = vec4<f32>(0.0);
    for (var k = 0; k < 8; k++) {
        let back = vec3<i32>(k & 1, (k >> 1u) & 1, k >> 2u);
        let there = inside + back * ALONG;
        let other = block - back;
        if all(there.xy < vec2<i32>(6)) && all(other >= vec3<i32>(0)) {
            sum += nodes[tile_entry(slot_of(other), u32(there.x + 6 * (there.y + 6 * there.z)))];
        }
    }
    return sum;
}

// Mass, momentum and velocity (Li et al. 2023, eqs 36, 37). The points are in order again, and a point with a fault stops what follows.
@compute @workgroup_size(GROUP)
fn project(one: Thread) {
    let k = node_thread(one);
    if k == 0u {
        atomicStore(&status.crossed, 0u);
        if atomicLoad(&status.fault) != NO_FAULT {
            status.stop = 1u;
        }
    }
    if k >= params.cells || !exists(k) {
        return;
    }
    let at = node_place(k);
    var sum = from_tiles(at);
    if sum.w < params.mass_floor {
        sum = vec4<f32>(0.0);
    }
    nodes[MOMENTUM * params.cells + k] = sum;
    if WALLED {
        node_at_walls(k, at, false);
        return;
    }
    if sum.w > 0.0 {
        nodes[SPEED * params.cells + k] = vec4<f32>(sum.xyz / sum.w, 0.0);
    } else {
        nodes[SPEED * params.cells + k] = vec4<f32>(0.0);
    }
}

// The new velocity v + Δv, with local damping −α |f| sign(v) of the force that remains after walls. Components that friction has stopped are not damped.
fn damped_velocity(k: u32, v: vec3<f32>, change_and_rate: vec4<f32>) {
    let dv = change_and_rate.xyz;
    let moves = (v != vec3<f32>(0.0)) & (v + dv != vec3<f32>(0.0));
    let change = select(dv, dv - params.damping * abs(dv) * sign(v), moves);
    nodes[SPEED * params.cells + k] = vec4<f32>(v + change, 0.0);
    nodes[CHANGE * params.cells + k] = vec4<f32>(change, change_and_rate.w);
}

// Forces on the nodes, and the motion of the grains, which goes by forces known as well.
@compute @workgroup_size(GROUP)
fn accelerate(one: Thread) {
    let k = node_thread(one);
    if k >= params.cells {
        move_grain(k - params.cells);
    } else if exists(k) {
        accelerate_node(k);
    }
}

// The force on a node and its new velocity (Li et al. 2023, eq. 28).
fn accelerate_node(k: u32) {
    if WALLED {
        node_at_walls(k, node_place(k), true);
        return;
    }
    let momentum = nodes[MOMENTUM * params.cells + k];
    let m = momentum.w;
    if m <= 0.0 {
        nodes[SPEED * params.cells + k] = vec4<f32>(0.0);
        nodes[CHANGE * params.cells + k] = vec4<f32>(0.0);
        return;
    }
    let pressed = from_tiles(node_place(k));
    let force = m * params.gravity + pressed.xyz;
    let stiffness_rate = pressed.w / m;
    // as `project` has it
    damped_velocity(k, momentum.xyz / m, vec4<f32>(force * (batch.dt / m), stiffness_rate));
}
