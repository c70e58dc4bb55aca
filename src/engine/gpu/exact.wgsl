// Sums that keep what f32 would lose. Twin: exact.rs.

// A value behind an operation that the compiler cannot see through: without it, it would simplify a compensated sum to a plain one.
fn keep(x: vec4<f32>) -> vec4<f32> {
    return bitcast<vec4<f32>>(bitcast<vec4<u32>>(x) ^ vec4<u32>(params.zero));
}

struct Sum {
    high: vec4<f32>,
    low: vec4<f32>,
}

// high + low + x, with what does not fit into `high` in `low` (Knuth's two-sum).
fn add(high: vec4<f32>, low: vec4<f32>, x: vec4<f32>) -> Sum {
    let b = keep(low + x);
    let sum = keep(high + b);
    let part = keep(sum - high);
    let lost = keep(high - keep(sum - part)) + keep(b - part);
    return Sum(sum, lost);
}

// The same of a single number.
fn grown(sum: vec2<f32>, x: f32) -> vec2<f32> {
    let next = add(vec4<f32>(sum.x, 0.0, 0.0, 0.0), vec4<f32>(sum.y, 0.0, 0.0, 0.0), vec4<f32>(x, 0.0, 0.0, 0.0));
    return vec2<f32>(next.high.x, next.low.x);
}

// A cell is 2^30 units wide and its offsets are counted from its middle node.
const UNITS: f32 = 1073741824.0;
const WIDTH: i32 = 1073741824;
const HALF: i32 = 536870912;

struct Place {
    // units, and what is left of one
    units: vec3<i32>,
    rest: vec3<f32>,
    // cells that were passed
    shift: vec3<i32>,
}

// An offset after a move of `by` cells, each component below 1.5 in size.
fn moved(units: vec3<i32>, rest: vec3<f32>, by: vec3<f32>) -> Place {
    let sum = by * UNITS + rest;
    let whole = floor(sum);
    let there = units + vec3<i32>(whole);
    let shift = select(vec3<i32>(0), vec3<i32>(1), there >= vec3<i32>(HALF)) - select(vec3<i32>(0), vec3<i32>(1), there < vec3<i32>(-HALF));
    return Place(there - shift * WIDTH, sum - whole, shift);
}

fn not_finite(x: f32) -> bool {
    return (bitcast<u32>(x) & 0x7f800000u) == 0x7f800000u;
}
