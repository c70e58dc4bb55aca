// The return of Mohr and Coulomb's law in principal stresses. Twin: mohr_coulomb.rs, where the functions are documented.

// A symmetric tensor on its way to its principal axes: entries on and off the diagonal (xx, yy, zz and xy, yz, zx) in the axes u, v, w.
struct Turned {
    on: vec3<f32>,
    off: vec3<f32>,
    u: vec3<f32>,
    v: vec3<f32>,
    w: vec3<f32>,
}

// Rotations of the first two of the axes, then the next two, and so on.
const ROTATIONS: i32 = 18;

fn rotated(a: Turned) -> Turned {
    let half = (a.on.y - a.on.x) / (2.0 * a.off.x);
    let root = sqrt(half * half + 1.0);
    let tangent = select(1.0 / (root + half), -1.0 / (root - half), half < 0.0);
    let cosine = 1.0 / sqrt(tangent * tangent + 1.0);
    let sine = tangent * cosine;
    let by = tangent * a.off.x;
    return Turned(
        vec3<f32>(a.on.x - by, a.on.y + by, a.on.z),
        vec3<f32>(0.0, sine * a.off.z + cosine * a.off.y, cosine * a.off.z - sine * a.off.y),
        cosine * a.u - sine * a.v,
        sine * a.u + cosine * a.v,
        a.w,
    );
}

fn principal(deviator: Sym) -> Turned {
    var a = Turned(deviator.normal, deviator.shear, vec3<f32>(1.0, 0.0, 0.0), vec3<f32>(0.0, 1.0, 0.0), vec3<f32>(0.0, 0.0, 1.0));
    let on = abs(deviator.normal);
    let off = abs(deviator.shear);
    let nothing = 1e-9 * (on.x + on.y + on.z + off.x + off.y + off.z);
    for (var round = 0; round < ROTATIONS; round++) {
        if abs(a.off.x) > nothing {
            a = rotated(a);
        }
        a = Turned(a.on.yzx, a.off.yzx, a.v, a.w, a.u);
    }
    if a.on.x < a.on.y {
        a = Turned(a.on.yxz, a.off, a.v, a.u, a.w);
    }
    if a.on.y < a.on.z {
        a = Turned(a.on.xzy, a.off, a.u, a.w, a.v);
    }
    if a.on.x < a.on.y {
        a = Turned(a.on.yxz, a.off, a.v, a.u, a.w);
    }
    return a;
}

fn correction(id: u32, s: vec3<f32>, mean: f32, excess: f32) -> vec3<f32> {
    let sine = laws[id].sin_friction;
    let flow = laws[id].sin_dilation;
    let g = laws[id].shear;
    let swell = 2.0 * laws[id].bulk * flow;
    let largest = -(2.0 * g * (1.0 + flow * 0.33333333) + swell);
    let other = 1.3333334 * g * flow - swell;
    let smallest = 2.0 * g * (1.0 - flow * 0.33333333) - swell;
    let own = 4.0 * g * (1.0 + sine * flow * 0.33333333) + 2.0 * swell * sine;
    let upper = s.x - s.y;
    let lower = s.y - s.z;
    let m = excess / own;
    if upper >= 2.0 * g * (1.0 + flow) * m && lower >= 2.0 * g * (1.0 - flow) * m {
        return vec3<f32>(largest, other, smallest) * m;
    }
    let extension = upper - lower - flow * (s.x - s.z) > 0.0;
    let sign = select(-1.0, 1.0, extension);
    let gap = select(upper, lower, extension);
    let across = 2.0 * g * (1.0 + sign * (sine + flow) - sine * flow * 0.33333333) + 2.0 * swell * sine;
    let sum = (2.0 * excess - gap * (1.0 - sign * sine)) / (own + across);
    if mean - swell * sum > laws[id].apex {
        return vec3<f32>(laws[id].apex - mean) - s;
    }
    if extension {
        let both = (other + smallest) * sum;
        return vec3<f32>(largest * sum, 0.5 * (both - gap), 0.5 * (both + gap));
    }
    let both = (largest + other) * sum;
    return vec3<f32>(0.5 * (both - gap), 0.5 * (both + gap), smallest * sum);
}

fn mohr_coulomb(id: u32, elastic: Sym, deviator: Sym, mean: f32) -> Step {
    let a = principal(deviator);
    let s = a.on;
    let excess = (s.x - s.z) + ((s.x + s.z) + 2.0 * mean) * laws[id].sin_friction - laws[id].strength;
    if excess <= 0.0 {
        return Step(elastic, 0.0);
    }
    let by = correction(id, s, mean, excess);
    let middle = (by.x + by.y + by.z) * 0.33333333;
    let plastic = (by - middle) / (2.0 * laws[id].shear) + vec3<f32>(middle / (3.0 * laws[id].bulk));
    return Step(
        Sym(
            elastic.normal + (by.x * (a.u * a.u) + by.y * (a.v * a.v) + by.z * (a.w * a.w)),
            elastic.shear + (by.x * (a.u * a.u.yzx) + by.y * (a.v * a.v.yzx) + by.z * (a.w * a.w.yzx)),
        ),
        sqrt(0.66666667 * (plastic.x * plastic.x + plastic.y * plastic.y + plastic.z * plastic.z)),
    );
}
