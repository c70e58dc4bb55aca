// Compensated sums (a high part, and a low part: the rounding error of the high one), and coordinates in cells, units and rests. Twin: exact.rs.

// The value itself. The compiler does not know that `params.zero` is 0, and so cannot simplify a compensated sum to a plain one.
fn keep(x: vec4<f32>) -> vec4<f32> {
    return bitcast<vec4<f32>>(bitcast<vec4<u32>>(x) ^ vec4<u32>(params.zero));
}

struct Sum {
    high: vec4<f32>,
    low: vec4<f32>,
}

// The compensated sum of high + low and x (Knuth's two-sum).
fn add(high: vec4<f32>, low: vec4<f32>, x: vec4<f32>) -> Sum {
    let b = keep(low + x);
    let sum = keep(high + b);
    let part = keep(sum - high);
    let lost = keep(high - keep(sum - part)) + keep(b - part);
    return Sum(sum, lost);
}

// The same for a single number; `sum`: its high and low part.
fn grown(sum: vec2<f32>, x: f32) -> vec2<f32> {
    let next = add(vec4<f32>(sum.x, 0.0, 0.0, 0.0), vec4<f32>(sum.y, 0.0, 0.0, 0.0), vec4<f32>(x, 0.0, 0.0, 0.0));
    return vec2<f32>(next.high.x, next.low.x);
}

// A cell is 2^30 units wide. Offsets are counted from the nearest node, the middle one of the three that a point reaches along an axis.
const UNITS: f32 = 1073741824.0;
const WIDTH: i32 = 1073741824;
const HALF: i32 = 536870912;

struct Place {
    // offset: whole units, and the rest as a fraction of a unit
    units: vec3<i32>,
    rest: vec3<f32>,
    // cells passed
    shift: vec3<i32>,
}

// An offset after a displacement of `by` cells, each component below 1.5 in absolute value.
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
