// Grains and their contacts: what is kept of them, where they are, and the force of one contact. Twins: contact/force.rs, contact/law.rs (f64).

struct Coupling {
    grains: u32,
    // points near grains or walls that there is room for
    rows: u32,
    // those of grains, and as many of them as points meet
    walls: u32,
    point_walls: u32,
    materials: u32,
    laws: u32,
    // differences of places are taken in whole numbers of 2^-split cells and what is left of one
    split: u32,
    // 0 linear, 1 Hertz, 2 Hertz with viscous damping
    law: u32,
    // steps of the grains in a step of the continuum
    rates: u32,
    turning: u32,
    hertz_area: u32,
    crushing: u32,
    // cells by which lists reach further than contacts; largest ghost radius, cells
    skin: f32,
    reach: f32,
    // the step that grains may have by themselves, s
    least: f32,
    damping: f32,
    // shelves of grains: how many along each axis, in all
    grid: vec3<i32>,
    grid_cells: u32,
    // cells of a shelf; m of a 2^-split cell; its share in a unit of places; cells beyond which nothing touches
    grid_size: f32,
    quantum: f32,
    fine: f32,
    far: i32,
    // where in `tables` ghosts, walls, and ghosts on walls begin
    tables: vec4<u32>,
}

// A wall that stands along an axis.
struct Side {
    axis: u32,
    // of the normal, towards the grains
    normal: f32,
    cell: i32,
    units: i32,
    rest: f32,
    speed: f32,
    // the loading plate that it moves with
    plate: u32,
    // of the grains
    reaction: f32,
    stiffness: f32,
    unused: f32,
    work: vec2<f32>,
}

struct Mix {
    // rows in use
    rows: atomic<u32>,
    // lowest grain with too many neighbours, over its limit, lost
    crowded: atomic<u32>,
    broken: atomic<u32>,
    lost: atomic<u32>,
    // bits of the largest speeds since they were looked at, m/s, and of the largest sum of stiffness over mass of a point
    fastest_point: atomic<u32>,
    fastest_grain: atomic<u32>,
    point_rate: atomic<u32>,
    // lists are to be made, whatever has moved
    search: u32,
    // way of a point and a grain towards each other since the lists were made, m
    travelled: f32,
    point_speed: f32,
    // seconds by which points are taken ahead, and steps of the grains since those of the points
    ahead: f32,
    sub: u32,
    // largest sums of stiffness over mass of a grain: its own contacts, those with points
    grain_rate: f32,
    grain_rate_points: f32,
    // the first kick is half a one; contacts are known already
    fresh: u32,
    contacts_known: u32,
    // what the nodes felt of the stiffness that pushes points, of what each point by itself would have, 1/s²; bits of the most that they felt
    bound_ratio: f32,
    isolated_bound: f32,
    largest_bound: atomic<u32>,
    // contacts have to be stable, and need not be resolved
    slow: u32,
    sides: array<Side, 8>,
    // sums over the steps of the batch
    reactions: array<vec2<f32>, 8>,
}

@group(1) @binding(0) var<uniform> coupling: Coupling;
// two entries a pair of materials: prefactors a, b, friction, viscous coefficient; E'
@group(1) @binding(1) var<storage, read> tables: array<vec4<f32>>;
@group(1) @binding(2) var<storage, read_write> grains: array<vec4<u32>>;
// contacts of each grain: `PARTNERS` with grains in their order, `SIDES` with walls
@group(1) @binding(3) var<storage, read_write> slots: array<vec4<u32>>;
// contacts of each point near something, in the order of bodies, and whose they are
@group(1) @binding(4) var<storage, read_write> rows: array<vec4<u32>>;
@group(1) @binding(5) var<storage, read_write> mix_: Mix;
// first place of each shelf, next free place, grains by shelves
@group(1) @binding(6) var<storage, read_write> lists: array<atomic<u32>>;
// force on each point, summed over the grains' steps, and its row; velocity that carried it, and the stiffness that pushes it
@group(1) @binding(7) var<storage, read_write> pushes: array<vec4<u32>>;

const GRAINS: bool = true;

const NONE: u32 = 0xffffffffu;
// bodies from here on are walls
const WALLS: u32 = 0x40000000u;
const PARTNERS: u32 = 32u;
const SIDES: u32 = 8u;
const SLOTS: u32 = 40u;
const PLACES: u32 = 16u;

// Planes of `grains` entries each.
const G_UNITS: u32 = 0u; // units x, y, z; material
const G_CELL: u32 = 1u; // cells x, y, z; radius in whole 2^-split cells
const G_REST: u32 = 2u; // what is left of a unit; of the radius
const G_VELOCITY: u32 = 3u; // velocity, mass
const G_VELOCITY_LOW: u32 = 4u; // its low part, radius, m
const G_SPIN: u32 = 5u; // spin, largest load
const G_SPIN_LOW: u32 = 6u; // its low part, id
const G_FORCE: u32 = 7u; // force, sum of stiffness over mass of its own contacts
const G_TORQUE: u32 = 8u; // torque, the same of those with points

// Planes of a contact.
const C_SPRING: u32 = 0u; // tangential spring, body
const C_NORMAL: u32 = 1u; // normal, normal force
const C_TANGENT: u32 = 2u; // tangential force, overlap
const C_LOW: u32 = 3u; // low part of the spring, normal stiffness

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
    return (plane * PLACES + s) * coupling.rows + r;
}

// Whose row it is.
fn owner_at(r: u32) -> u32 {
    return 4u * PLACES * coupling.rows + r;
}

// A length, in whole 2^-split cells and what is left of one.
struct Length {
    whole: vec3<i32>,
    part: vec3<f32>,
}

fn length_of(cells: vec3<i32>, units: vec3<i32>, rest: vec3<f32>) -> Length {
    let bits = vec3<u32>(30u - coupling.split);
    let near = (units + vec3<i32>(1 << (29u - coupling.split))) >> bits;
    let left = units - (near << bits);
    return Length(cells * vec3<i32>(1 << coupling.split) + near, (vec3<f32>(left) + rest) * coupling.fine);
}

// How deep two spheres of the radii' sum (`whole`, `part`) overlap that are so far apart, m, and the direction from the first to the second. The difference of squares
// is taken in whole numbers as far as it goes: an overlap is small against the radii.
struct ContactGeometry {
    overlap: f32,
    normal: vec3<f32>,
}

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

// Force, and normal and tangential stiffness.
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

// Motion of a first body against a second one.
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

// The spring turns with the contact and is stretched by the slip, as increments of a sum that keeps what f32 would lose.
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
    let turned = twisted - n * dot(old + twisted, n);
    let u = old + turned;
    // half of 1 − |u|²/|v|²
    let shrunk = -0.5 * (2.0 * dot(old, turned) + dot(turned, turned)) / max(dot(old, old), 1e-37);
    let back = u * max(shrunk, -1.0);
    let sum = add(vec4<f32>(old, 0.0), vec4<f32>(old_low, 0.0), vec4<f32>(turned + back - slip * (e.z * dt), 0.0));
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
    return Contact(spring, low, n, force, tangent, m.overlap, e.y);
}
