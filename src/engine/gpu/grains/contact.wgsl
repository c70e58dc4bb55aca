// Grains and their contacts: buffers, parameters, and the force of one contact. Twins (f64): contact/force.rs, contact/law.

// What stays the same during a batch.
struct Coupling {
    // number of grains
    grains: u32,
    // number of rows: of points close to grains or walls that there is room for
    rows: u32,
    // number of walls of the grains; points touch the first `point_walls` of them
    walls: u32,
    point_walls: u32,
    // numbers of materials of grains and of laws of points
    materials: u32,
    laws: u32,
    // distances between spheres are computed in quanta of 2^-split cells, as a whole number and a rest
    split: u32,
    // 0 linear, 1 Hertz, 2 Hertz with viscous damping
    law: u32,
    // steps of the grains in a step of the continuum
    rates: u32,
    // 1 where grains rotate; where the failure criterion weighs contacts by Hertz's area; where grains may break
    turning: u32,
    hertz_area: u32,
    crushing: u32,
    // by how much further than contacts the lists of candidates reach, cells; largest ghost radius, cells
    skin: f32,
    reach: f32,
    // Rayleigh's time step of the grains, s
    least: f32,
    // coefficient of local damping
    damping: f32,
    // the grid for the search of grains: number of grid cells along each axis, and in all
    grid: vec3<i32>,
    grid_cells: u32,
    // edge of a grid cell, cells; length of a quantum, m; quanta in a unit of coordinates; number of cells from which on nothing touches
    grid_size: f32,
    quantum: f32,
    fine: f32,
    far: i32,
    // where in `tables` the parameters of contacts of points with grains, of grains with walls, and of points with walls begin
    tables: vec4<u32>,
}

// A wall of the grains: a plane across an axis, or an upright shell.
struct Side {
    axis: u32,
    // component of the normal along the axis, 1 or -1; the normal points to the grains. Of a shell -1
    normal: f32,
    // coordinate along the axis, as for points; of a shell its radius in the same form
    cell: i32,
    units: i32,
    rest: f32,
    // speed along the normal, m/s
    speed: f32,
    // index of the loading plate that it moves with, or NONE
    plate: u32,
    // sums over its contacts with grains: normal force, N; normal stiffness, N/m
    reaction: f32,
    stiffness: f32,
    // 1: a shell
    shell: u32,
    // work of the wall on the grains, J
    work: vec2<f32>,
    // of a shell: x and y of its axis, as for points; its distances are computed in quanta of 2^-split cells
    centre_cell: vec2<i32>,
    centre_units: vec2<i32>,
    centre_rest: vec2<f32>,
    split: u32,
    unused: u32,
}

// State of the grains as a whole.
struct Mix {
    // number of rows in use
    rows: atomic<u32>,
    // index of the first grain with too many candidates; that fails; without a finite velocity. NONE where there is none
    crowded: atomic<u32>,
    broken: atomic<u32>,
    lost: atomic<u32>,
    // bits of the largest speed of points and of grains since they were last read, m/s; bits of the largest sum of stiffness over mass of a point, 1/s²
    fastest_point: atomic<u32>,
    fastest_grain: atomic<u32>,
    point_rate: atomic<u32>,
    // 1 where the lists of candidates must be made whatever has moved
    search: u32,
    // upper bound on how far a point and a grain have approached each other since the lists were made, m; largest speed of points in the last step, m/s
    travelled: f32,
    point_speed: f32,
    // by how much points are moved ahead of their positions with their transport velocity, s; number of steps of the grains done in the present step of the points
    ahead: f32,
    sub: u32,
    // largest sums of stiffness over mass of a grain, 1/s²: of contacts with grains and walls; of contacts with points
    grain_rate: f32,
    grain_rate_points: f32,
    // 1 where the next change of velocities is over half a step; 1 where the contacts have been computed already
    fresh: u32,
    contacts_known: u32,
    // ratio of the nodes' bound on stiffness over mass to that of isolated points in the last step; that of isolated points, 1/s²; bits of the largest of a node, 1/s²
    bound_ratio: f32,
    isolated_bound: f32,
    largest_bound: atomic<u32>,
    // 1 where contacts of points need only be stable, not resolved in time (coupling/mixture.rs)
    slow: u32,
    // bits of the furthest that a face has been beyond the ghost of its point, cells (C_FACE)
    furthest: atomic<u32>,
    // 1 where lists of candidates are made anew after this step of the grains
    wanted: u32,
    sides: array<Side, SIDES>,
    // sums of the walls' reactions over the steps of the batch, N
    reactions: array<vec2<f32>, SIDES>,
}

@group(1) @binding(0) var<uniform> coupling: Coupling;
// two entries for each pair of materials: normal and tangential stiffness, friction, viscous coefficient; then E' (contact/pair.rs), of points friction in the end and its
// rate (softened), and the way over the ghost's diameter on which an overlap without force falls to 1/e
@group(1) @binding(1) var<storage, read> tables: array<vec4<f32>>;
// planes of the grains
@group(1) @binding(2) var<storage, read_write> grains: array<vec4<u32>>;
// planes of the contacts of each grain: `PARTNERS` slots for grains in the order of their indices, `SIDES` slots for walls
@group(1) @binding(3) var<storage, read_write> slots: array<vec4<u32>>;
// planes of the contacts of each point close to grains or walls, in the order of bodies; then what they press on each node of the point, N and N/m, summed over the steps of
// the grains in this step of the continuum; then for each row the point, 1 where anything has pressed on it in this step, and the energy, J, that its contacts have gained
// in this batch as their overlaps without force shrank, as a sum of two
@group(1) @binding(4) var<storage, read_write> rows: array<vec4<u32>>;
@group(1) @binding(5) var<storage, read_write> mix_: Mix;
// the grid for the search: index of the first grain of each grid cell; the next free index; grains by grid cell
@group(1) @binding(6) var<storage, read_write> lists: array<atomic<u32>>;
// for each point its transport velocity, m/s, and its row or NONE
@group(1) @binding(7) var<storage, read_write> transport: array<vec4<u32>>;

const GRAINS: bool = true;

const NONE: u32 = 0xffffffffu;
// bodies from here on are walls
const WALLS: u32 = 0x40000000u;
// contacts of a grain: with other grains, then with walls
const SLOTS: u32 = PARTNERS + SIDES;

// Planes of `grains` entries each.
const G_UNITS: u32 = 0u; // offsets x, y, z in units; material
const G_CELL: u32 = 1u; // cells x, y, z; radius in whole quanta
const G_REST: u32 = 2u; // fractions of a unit x, y, z; of a quantum of the radius
const G_VELOCITY: u32 = 3u; // velocity, m/s; inertial mass, kg
const G_VELOCITY_LOW: u32 = 4u; // its low part; radius, m
const G_SPIN: u32 = 5u; // spin, rad/s; largest load that the grain bears
const G_SPIN_LOW: u32 = 6u; // its low part; identity
const G_FORCE: u32 = 7u; // force, N; sum of stiffness over mass of contacts with grains and walls, 1/s²
const G_TORQUE: u32 = 8u; // torque, N m; sum of stiffness over mass of contacts with points, 1/s²

// Planes of a contact.
const C_SPRING: u32 = 0u; // force of the tangential spring, N; body in contact
const C_NORMAL: u32 = 1u; // normal; normal force, N
const C_TANGENT: u32 = 2u; // tangential force, N; overlap, m; of a point apart from the body 0 where it has a face still, and NO_FACE where it has none
const C_LOW: u32 = 3u; // low part of the spring; normal stiffness, N/m
// of points only (faces.wgsl)
const C_FACE: u32 = 4u; // velocity of the face, m/s; distance of the face from the point less the ghost radius, cells
const C_PLACE: u32 = 5u; // where the force acts at the start of this step of the continuum, cells from the point, or NO_PLACE; low part of the distance in C_FACE
// where points come from breakages (coupling/fines.rs)
const C_REFERENCE: u32 = 6u; // overlap without force, m, as a sum of two
// largest number of contacts of a point; number of planes of one; number of nodes that a point reaches
const ROW_PLACES: u32 = PLACES + (MANY_PLACES - PLACES) * u32(CRUSHING);
const ROW_PLANES: u32 = 6u + u32(FINES);
const NODES: u32 = 27u;

const NO_FACE: f32 = -1.0;
const NO_PLACE: f32 = 2.0;

fn grain_word(plane: u32, g: u32) -> vec4<u32> {
    return grains[plane * coupling.grains + g];
}

fn grain_number(plane: u32, g: u32) -> vec4<f32> {
    return bitcast<vec4<f32>>(grains[plane * coupling.grains + g]);
}

fn put_grain(plane: u32, g: u32, value: vec4<f32>) {
    grains[plane * coupling.grains + g] = bitcast<vec4<u32>>(value);
}

fn slot_at(plane: u32, s: u32, g: u32) -> u32 {
    return (plane * SLOTS + s) * coupling.grains + g;
}

fn row_at(plane: u32, s: u32, r: u32) -> u32 {
    return (plane * ROW_PLACES + s) * coupling.rows + r;
}

// Index in `rows` of what presses on the node k of the point of row r.
fn node_at(k: u32, r: u32) -> u32 {
    return (ROW_PLANES * ROW_PLACES + k) * coupling.rows + r;
}

// Index in `rows` of the point of row r.
fn owner_at(r: u32) -> u32 {
    return node_at(NODES, r);
}

// A vector in quanta of 2^-split cells: whole numbers and rests.
struct Length {
    whole: vec3<i32>,
    part: vec3<f32>,
}

// The vector of so many cells, units and fractions of a unit.
fn length_of(cells: vec3<i32>, units: vec3<i32>, rest: vec3<f32>) -> Length {
    let bits = vec3<u32>(30u - coupling.split);
    let near = (units + vec3<i32>(1 << (29u - coupling.split))) >> bits;
    let left = units - (near << bits);
    return Length(cells * vec3<i32>(1 << coupling.split) + near, (vec3<f32>(left) + rest) * coupling.fine);
}

// Overlap of two bodies, m, negative where they are apart, and the unit vector from the first to the second.
struct ContactGeometry {
    overlap: f32,
    normal: vec3<f32>,
}

// Geometry of two spheres with the vector `d` between their centres and the sum of radii `whole` + `part`, quanta. The overlap is small against the radii: the difference
// of their squares is computed in whole numbers as far as possible.
fn spheres_geometry(d: Length, whole: i32, part: f32) -> ContactGeometry {
    let w = d.whole;
    let first = whole * whole - (w.x * w.x + w.y * w.y + w.z * w.z);
    let v = vec3<f32>(w);
    let second = 2.0 * (f32(whole) * part - dot(v, d.part));
    let third = part * part - dot(d.part, d.part);
    let difference = f32(first) + (second + third);
    let all = v + d.part;
    let size = sqrt(dot(all, all));
    return ContactGeometry(difference / (f32(whole) + part + size) * coupling.quantum, all / max(size, 1e-37));
}

struct Pair {
    normal_stiffness: f32,
    tangential_stiffness: f32,
    friction: f32,
    viscous: f32,
}

fn pair_at(at: u32) -> Pair {
    let p = tables[at];
    return Pair(p.x, p.y, p.z, p.w);
}

// Normal force, N, and normal and tangential stiffness, N/m, at an overlap, m.
fn elastic(overlap: f32, r_eff: f32, pair: Pair) -> vec3<f32> {
    if coupling.law == 0u {
        let k = pair.normal_stiffness * r_eff;
        return vec3<f32>(k * overlap, k, pair.tangential_stiffness * r_eff);
    }
    let c = sqrt(r_eff * overlap);
    return vec3<f32>(pair.normal_stiffness * c * overlap, 1.5 * pair.normal_stiffness * c, pair.tangential_stiffness * c);
}

// Tangential over normal stiffness.
fn stiffness_ratio(pair: Pair) -> f32 {
    return pair.tangential_stiffness / select(1.5 * pair.normal_stiffness, pair.normal_stiffness, coupling.law == 0u);
}

// Relative motion of the first and the second end (contact/force.rs).
struct RelativeMotion {
    centres: vec3<f32>,
    turning: vec3<f32>,
    mean_spin: vec3<f32>,
}

struct Contact {
    spring: vec3<f32>,
    low: vec3<f32>,
    normal: vec3<f32>,
    force: f32,
    tangent: vec3<f32>,
    overlap: f32,
    stiffness: f32,
}

fn no_contact() -> Contact {
    let zero = vec3<f32>(0.0);
    return Contact(zero, zero, zero, 0.0, zero, 0.0, 0.0);
}

// The force of one contact from its geometry, relative motion and tangential spring (contact/force.rs, touching). Rotation of the spring with the contact and its
// stretching by slip are increments of a compensated sum.
fn contact_force(m: ContactGeometry, r_eff: f32, m_eff: f32, motion: RelativeMotion, pair: Pair, dt: f32, old: vec3<f32>, old_low: vec3<f32>) -> Contact {
    let n = m.normal;
    let v = motion.centres + cross(motion.turning - motion.mean_spin * m.overlap, n);
    let e = elastic(m.overlap, r_eff, pair);
    let approach = dot(v, n);
    let slip = v - n * approach;
    var force = e.x;
    if coupling.law == 2u {
        force += pair.viscous * sqrt(e.y * m_eff) * approach;
    }
    let twisted = cross(n, old) * (dot(motion.mean_spin, n) * dt);
    let rotation = twisted - n * dot(old + twisted, n);
    let u = old + rotation;
    // half of 1 − |u|²/|v|²
    let shrunk = -0.5 * (2.0 * dot(old, rotation) + dot(rotation, rotation)) / max(dot(old, old), 1e-37);
    let back = u * max(shrunk, -1.0);
    let sum = add(vec4<f32>(old, 0.0), vec4<f32>(old_low, 0.0), vec4<f32>(rotation + back - slip * (e.z * dt), 0.0));
    var spring = sum.high.xyz;
    var low = sum.low.xyz;
    let limit = pair.friction * max(force, 0.0);
    let size2 = dot(spring, spring);
    let slides = size2 > limit * limit;
    if slides {
        spring *= limit / sqrt(size2);
        low = vec3<f32>(0.0);
    }
    var tangent = spring;
    if coupling.law == 2u && !slides {
        tangent -= slip * (pair.viscous * sqrt(e.z * m_eff));
        let both2 = dot(tangent, tangent);
        if both2 > limit * limit {
            tangent *= limit / sqrt(both2);
        }
    }
    return rounded(Contact(spring, low, n, force, tangent, m.overlap, e.y));
}

// The contact itself, with the numbers as they are stored. A compiler may fuse a product with a sum that takes it (fma), and the product is then not rounded: without this
// a step that computes a contact and one that reads it from memory could give forces that differ by rounding, and a resumed run other bits than one that was not stopped.
fn rounded(c: Contact) -> Contact {
    let spring = keep(vec4<f32>(c.spring, c.stiffness));
    let normal = keep(vec4<f32>(c.normal, c.force));
    let tangent = keep(vec4<f32>(c.tangent, c.overlap));
    return Contact(spring.xyz, c.low, normal.xyz, normal.w, tangent.xyz, tangent.w, spring.w);
}
