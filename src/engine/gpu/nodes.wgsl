// State of points and nodes, and the sums of the nodes over the points: one thread per node; the points of a cell are in the order of their identities.
// Twins (f64): mpm/spline.rs, mpm/pass.rs, mpm/grid.rs, with which gpu/tests/step.rs compares it.

// Planes of the state of points, `points` entries each. A number that is a compensated sum has its low part in another plane.
const PLACE: u32 = 0u; // offset x, y, z in units (bits of i32); cell
const REST: u32 = 1u; // offset x, y, z: fractions of a unit; initial volume, m³
const VELOCITY: u32 = 2u; // velocity, m/s; mass, kg
const VELOCITY_LOW: u32 = 3u; // its low part; index of the law
const NORMAL: u32 = 4u; // stress xx, yy, zz, Pa; volume over initial volume, less 1
const SHEAR: u32 = 5u; // stress xy, yz, zx, Pa; accumulated plastic strain
const NORMAL_LOW: u32 = 6u; // low parts of NORMAL
const SHEAR_LOW: u32 = 7u; // low parts of SHEAR
const ENERGY: u32 = 8u; // stress work, J, and its low part; identity; ghost radius, units (bits of i32)
// with loading plates only
const ARM: u32 = 9u; // distance from the point to its pressed face along each axis, cells, with sign; 0 where no plate presses
const ARM_LOW: u32 = 10u; // its low part

// Planes of the nodes, `nodes` entries each. Near walls SPEED and CHANGE hold momentum and mass, and impulse, until the walls have been applied.
const MOMENTUM: u32 = 0u; // momentum, kg m/s; mass, kg
const SPEED: u32 = 1u; // velocity, m/s
const CHANGE: u32 = 2u; // change of the velocity in this step, m/s; stiffness of external forces over mass, 1/s²

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
const NO_FAULT: u32 = 0xffffffffu;

@group(0) @binding(2) var<storage, read_write> state: array<vec4<u32>>;
@group(0) @binding(3) var<storage, read_write> nodes: array<vec4<f32>>;
// for each cell the index in `order` of its first point; the number of points
@group(0) @binding(4) var<storage, read_write> starts: array<u32>;
// number of points of each cell, then of each group of cells; while points are sorted, for each cell the next free index in `order`
@group(0) @binding(5) var<storage, read_write> counts: array<atomic<u32>>;
// points by cell, in a cell by identity
@group(0) @binding(6) var<storage, read_write> order: array<u32>;
@group(0) @binding(7) var<storage, read_write> status: Status;
// for each node in the plane of a wall, whether the wall touches the material there: bit 1 in the pass at hand, bit 2 in the last pass with forces
@group(0) @binding(8) var<storage, read_write> touching: array<u32>;

fn word(plane: u32, i: u32) -> vec4<u32> {
    return state[plane * params.points + i];
}

fn number(plane: u32, i: u32) -> vec4<f32> {
    return bitcast<vec4<f32>>(state[plane * params.points + i]);
}

fn put(plane: u32, i: u32, value: vec4<f32>) {
    state[plane * params.points + i] = bitcast<vec4<u32>>(value);
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

// Numbers of cells and nodes along each axis. A cell here is that of the B-spline, about a node, so there is one more than cells of the domain; nodes go one cell
// beyond the domain on each side.
fn cell_size() -> vec3<i32> {
    return params.size + 1;
}

fn node_size() -> vec3<i32> {
    return params.size + 3;
}

fn cell_place(cell: u32) -> vec3<i32> {
    let n = cell_size();
    let c = i32(cell);
    return vec3<i32>(c % n.x, (c / n.x) % n.y, c / (n.x * n.y));
}

fn node_index(at: vec3<i32>) -> u32 {
    let n = node_size();
    return u32(at.x + n.x * (at.y + n.y * at.z));
}

fn offset(place: vec4<u32>) -> vec3<f32> {
    return vec3<f32>(bitcast<vec3<i32>>(place.xyz)) * (1.0 / UNITS);
}

// Quadratic B-splines (Li et al. 2023, eq. 10): along each axis the value for the first, middle or last (d = 0, 1, 2) of the three nodes that a point reaches. `o`:
// offset of the point from the middle node, cells.
fn value(d: vec3<i32>, o: vec3<f32>) -> vec3<f32> {
    let left = 0.5 - o;
    let right = 0.5 + o;
    let outer = select(0.5 * right * right, 0.5 * left * left, d == vec3<i32>(0));
    return select(outer, 0.75 - o * o, d == vec3<i32>(1));
}

// Their derivatives, 1/cell.
fn slope(d: vec3<i32>, o: vec3<f32>) -> vec3<f32> {
    let outer = select(0.5 + o, o - 0.5, d == vec3<i32>(0));
    return select(outer, -2.0 * o, d == vec3<i32>(1));
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

fn near_wall(at: vec3<i32>) -> bool {
    for (var axis = 0u; axis < 3u; axis++) {
        if (params.walls[2u * axis].x != 0u && at[axis] <= 2) || (params.walls[2u * axis + 1u].x != 0u && at[axis] >= params.size[axis]) {
            return true;
        }
    }
    return false;
}

// The cells in one row along x from which points reach a node: the range of their points in `order`.
struct Row {
    first: u32,
    end: u32,
    // number of the row's cell at x = 0
    base: i32,
}

// That row for the node `at`, dy and dz cells back along y and z.
fn row(at: vec3<i32>, dy: i32, dz: i32) -> Row {
    let n = cell_size();
    let y = at.y - dy;
    let z = at.z - dz;
    let low = max(at.x - 2, 0);
    let high = min(at.x, n.x - 1);
    if y < 0 || y >= n.y || z < 0 || z >= n.z || low > high {
        return Row(0u, 0u, 0);
    }
    let base = n.x * (y + n.y * z);
    return Row(starts[u32(base + low)], starts[u32(base + high + 1)], base);
}

fn node_place(k: u32) -> vec3<i32> {
    let n = node_size();
    let i = i32(k);
    return vec3<i32>(i % n.x, (i / n.x) % n.y, i / (n.x * n.y));
}

// Mass, momentum and velocity (Li et al. 2023, eqs 36, 37). The points are in order again, and a point with a fault stops what follows.
@compute @workgroup_size(GROUP)
fn project(one: Thread) {
    let k = linear(one);
    if k >= params.nodes {
        return;
    }
    if k == 0u {
        atomicStore(&status.crossed, 0u);
        if atomicLoad(&status.fault) != NO_FAULT {
            status.stop = 1u;
        }
    }
    let at = node_place(k);
    var sum = vec4<f32>(0.0);
    for (var dz = 0; dz < 3; dz++) {
        for (var dy = 0; dy < 3; dy++) {
            let cells = row(at, dy, dz);
            for (var p = cells.first; p < cells.end; p++) {
                let i = order[p];
                let place = word(PLACE, i);
                let d = vec3<i32>(at.x - (i32(place.w) - cells.base), dy, dz);
                let w = value(d, offset(place));
                let v = number(VELOCITY, i);
                sum += vec4<f32>(v.xyz * v.w, v.w) * (w.x * w.y * w.z);
            }
        }
    }
    if sum.w < params.mass_floor {
        sum = vec4<f32>(0.0);
    }
    nodes[MOMENTUM * params.nodes + k] = sum;
    if near_wall(at) {
        nodes[SPEED * params.nodes + k] = sum;
        nodes[CHANGE * params.nodes + k] = vec4<f32>(0.0);
    } else if sum.w > 0.0 {
        nodes[SPEED * params.nodes + k] = vec4<f32>(sum.xyz / sum.w, 0.0);
    } else {
        nodes[SPEED * params.nodes + k] = vec4<f32>(0.0);
    }
}

// The new velocity v + Δv, with local damping −α |f| sign(v) of the force that remains after walls. Components that friction has stopped are not damped.
fn damped_velocity(k: u32, v: vec3<f32>, change_and_rate: vec4<f32>) {
    let dv = change_and_rate.xyz;
    let moves = (v != vec3<f32>(0.0)) & (v + dv != vec3<f32>(0.0));
    let change = select(dv, dv - params.damping * abs(dv) * sign(v), moves);
    nodes[SPEED * params.nodes + k] = vec4<f32>(v + change, 0.0);
    nodes[CHANGE * params.nodes + k] = vec4<f32>(change, change_and_rate.w);
}

// Forces on the nodes, and the motion of the grains, which goes by forces known as well.
@compute @workgroup_size(GROUP)
fn accelerate(one: Thread) {
    let k = linear(one);
    if k < params.nodes {
        accelerate_node(k);
    } else {
        move_grain(k - params.nodes);
    }
}

// Forces on the nodes: internal ones −Σ V σ ∇N (Li et al. 2023, eqs 8, 12), those of loading plates and grains (eq. 29), gravity; and the new velocity (eq. 28).
fn accelerate_node(k: u32) {
    let momentum = nodes[MOMENTUM * params.nodes + k];
    let m = momentum.w;
    let at = node_place(k);
    if m <= 0.0 {
        nodes[SPEED * params.nodes + k] = vec4<f32>(0.0);
        nodes[CHANGE * params.nodes + k] = vec4<f32>(0.0);
        return;
    }
    var internal = vec3<f32>(0.0);
    var pressed = vec4<f32>(0.0);
    for (var dz = 0; dz < 3; dz++) {
        for (var dy = 0; dy < 3; dy++) {
            let cells = row(at, dy, dz);
            for (var p = cells.first; p < cells.end; p++) {
                let i = order[p];
                let place = word(PLACE, i);
                let d = vec3<i32>(at.x - (i32(place.w) - cells.base), dy, dz);
                let o = offset(place);
                let w = value(d, o);
                let s = slope(d, o);
                let g = vec3<f32>(s.x * w.y * w.z, w.x * s.y * w.z, w.x * w.y * s.z);
                let a = number(NORMAL, i);
                let b = number(SHEAR, i);
                let volume = bitcast<f32>(word(REST, i).w) * (1.0 + a.w);
                internal += volume
                    * vec3<f32>(
                        a.x * g.x + b.x * g.y + b.z * g.z,
                        b.x * g.x + a.y * g.y + b.y * g.z,
                        b.z * g.x + b.y * g.y + a.z * g.z,
                    );
                if params.plates > 0u {
                    let push = batch.parts[i];
                    if any(push.xyz != vec3<f32>(0.0)) {
                        // each component acts on the face along its axis
                        let there = at_faces(d, o, number(ARM, i).xyz, w);
                        let at_node = vec3<f32>(there.x * w.y * w.z, w.x * there.y * w.z, w.x * w.y * there.z);
                        let size = abs(push.xyz);
                        pressed += vec4<f32>(push.xyz * at_node, push.w * dot(size / (size.x + size.y + size.z), at_node));
                    }
                }
                if GRAINS {
                    pressed += force_of_grains(i, d);
                }
            }
        }
    }
    let force = m * params.gravity - internal * params.inverse_cell + pressed.xyz;
    let stiffness_rate = pressed.w / m;
    if near_wall(at) {
        nodes[SPEED * params.nodes + k] = momentum;
        nodes[CHANGE * params.nodes + k] = vec4<f32>(force * batch.dt, stiffness_rate);
    } else {
        damped_velocity(k, nodes[SPEED * params.nodes + k].xyz, vec4<f32>(force * (batch.dt / m), stiffness_rate));
    }
}
