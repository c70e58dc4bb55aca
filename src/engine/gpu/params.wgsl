// What all passes read, the same during a batch of steps. The Rust twins are in layout.rs; a test compares the offsets.

struct Params {
    // cells of the domain along each axis
    size: vec3<i32>,
    points: u32,
    gravity: vec3<f32>,
    // number of points above; gravity, m/s²; time step or, where `safety` is not 0, its upper bound, s
    dt: f32,
    // edge of a cell, m, and its inverse, 1/m
    cell: f32,
    inverse_cell: f32,
    // weight of PIC in the blend: 1 is PIC, 0 is FLIP
    pic: f32,
    // coefficient of local damping
    damping: f32,
    // nodes with less mass, kg, count as empty
    mass_floor: f32,
    // always 0, which the compiler does not know: see keep() in exact.wgsl
    zero: u32,
    // number of cells, and of nodes, that there is memory for: BLOCK for each slot
    cells: u32,
    // cells of a thread where the points are put in order, and number of the groups of cells of a workgroup there
    share: u32,
    cell_groups: u32,
    // share of the overlap of a loading plate that belongs to the extents of the material: 1 or 0
    overlaps: f32,
    // number of workgroups along x and y for one thread per point
    point_groups: vec2<u32>,
    // number of steps of the batch
    steps: u32,
    unused: u32,
    // number of loading plates
    plates: u32,
    // time step over the stable step for waves and contacts; 0: every step is `dt`
    safety: f32,
    // extents of the material along each axis at the start of the batch, without overlaps, m; share of the displacement of a loading plate by which they shrink: 1 or 0
    extents: vec3<f32>,
    follows: f32,
    // blocks along each axis, and their number; number of slots
    blocks: vec3<i32>,
    block_count: u32,
    slots: u32,
    // by how many pairs of slots apart neighbouring workgroups work, and number of pairs
    stride: u32,
    pairs: u32,
    unused_too: u32,
    // the sides x low, x high, y low, …: kind (0 open, 1 symmetry, 2 stick, 3 friction), bits of the coefficient of friction
    walls: array<vec4<u32>, BORDERS>,
    drives: array<PlateDrive, PLATES>,
}

// How a loading plate moves: at a speed, m/s (kind 0), or towards a stress, Pa (kind 1). Speed and stress go from `value` with `slope`, per second, to `end`. The other
// fields are those of PlateDrive::Stress in mpm/plate_drive.rs, `memory` as 1/time.
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

// A parameter as a function of the plastic strain (mpm/law/evolution.rs): kind 0 constant (`last`), 1 linear, 2 cubic and exponential.
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

// Constants of Modified Cam-clay, names as in mpm/law/cam_clay.rs: M, -; κ, -; (λ − κ)/κ, -; ln(p_c/p_c0) per plastic compression, -; p_c0, Pa; v_c0, -; G/K, - (0 where G
// stays).
struct Clay {
    slope: f32,
    swelling_slope: f32,
    ratio: f32,
    per_plastic: f32,
    preconsolidation: f32,
    virgin_volume: f32,
    shear_ratio: f32,
    unused: f32,
}

// A constitutive law: kind 0 linear elasticity, 1 Drucker-Prager, 2 Mohr-Coulomb, 3 Modified Cam-clay. The other fields are those of DruckerPrager in mpm/law/drucker_prager.rs, with bulk and shear modulus,
// Pa; from the plastic strain `settled` on the yield surface is `last_alpha`, `last_kappa`. For Mohr-Coulomb that is a cone
// inside its pyramid at every plastic strain, in which nothing yields up to I1 = `cut`.
struct Law {
    kind: u32,
    // 0 outer, 1 inner, 2 plane strain (mpm/law/cone.rs)
    cone: u32,
    bulk: f32,
    shear: f32,
    volume_return: f32,
    per_multiplier: f32,
    cut: f32,
    settled: f32,
    last_alpha: f32,
    last_kappa: f32,
    // of Mohr-Coulomb, from the plastic strain `settled` on: sines of the friction and the dilation angle; 2 c cos φ, Pa; mean stress at the apex, Pa
    sin_friction: f32,
    sin_dilation: f32,
    strength: f32,
    apex: f32,
    // of dilation that ends with softening (mpm/law/dilatancy.rs): slope of the cone at the critical state; slope of the potential per slope of the cone above it, 0 where
    // dilation stays
    critical: f32,
    dilation_factor: f32,
    friction: Evolution,
    cohesion: Evolution,
    clay: Clay,
}

@group(0) @binding(0) var<uniform> params: Params;
@group(0) @binding(1) var<storage, read> laws: array<Law>;
