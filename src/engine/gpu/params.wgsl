// What all passes read. The Rust twins are in layout.rs; a test compares the offsets.

struct Params {
    // cells of the domain along each axis
    size: vec3<i32>,
    points: u32,
    gravity: vec3<f32>,
    // the time step, or the largest that waves allow
    dt: f32,
    cell: f32,
    inverse_cell: f32,
    // 1: PIC, 0: FLIP
    pic: f32,
    damping: f32,
    // nodes with less mass, kg, count as empty
    mass_floor: f32,
    // always 0, which the compiler does not know: see exact.wgsl
    zero: u32,
    cells: u32,
    nodes: u32,
    // number of groups of cells of the prefix sum
    blocks: u32,
    // points that a cell may hold
    crowd: u32,
    // number of workgroups along x and y for one thread per point, per cell
    point_groups: vec2<u32>,
    cell_groups: vec2<u32>,
    plates: u32,
    // share of what waves and contacts allow that a step may have; 0: it is `dt`
    safety: f32,
    // what the material extends over along each axis, less overlaps, when the batch begins, m; whether it follows the loading plates (1) or stays (0)
    extents: vec3<f32>,
    follows: f32,
    // x low, x high, y low, …: kind (0 open, 1 symmetry, 2 stick, 3 friction), bits of the friction coefficient
    walls: array<vec4<u32>, 6>,
    drives: array<PlateDrive, 6>,
}

// How a loading plate moves: 0 at a speed, m/s, 1 towards a stress, Pa; both from `value` with `slope` to `end`. mpm/plate_drive.rs says what the others are.
struct PlateDrive {
    kind: u32,
    value: f32,
    slope: f32,
    end: f32,
    gain: f32,
    reach: f32,
    // 1/s
    memory: f32,
    unused: f32,
}

// How a parameter follows the plastic strain: 0 constant (`last`), 1 linear, 2 cubic and exponential.
struct Evolution {
    kind: u32,
    initial: f32,
    last: f32,
    strain: f32,
    cubic: vec4<f32>,
    peak_strain: f32,
    peak: f32,
    residual: f32,
    decay: f32,
}

// 0 elastic, 1 Drucker-Prager.
struct Law {
    kind: u32,
    // 0 outer, 1 inner, 2 plane strain
    cone: u32,
    bulk: f32,
    shear: f32,
    volume_return: f32,
    per_multiplier: f32,
    cut: f32,
    settled: f32,
    last_alpha: f32,
    last_kappa: f32,
    unused_a: f32,
    unused_b: f32,
    friction: Evolution,
    cohesion: Evolution,
}

@group(0) @binding(0) var<uniform> params: Params;
@group(0) @binding(1) var<storage, read> laws: array<Law>;
