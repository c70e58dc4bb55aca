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

// In place of infinity, as in layout.rs.
const HUGE: f32 = 1e30;

// Sines of the friction and the dilation angle; 2 c cos φ, Pa; mean stress at the apex, Pa.
struct Pyramid {
    sin_friction: f32,
    sin_dilation: f32,
    strength: f32,
    apex: f32,
}

// Changes of the principal stresses in a return, Pa, its plastic strain, and what opens at the apex.
struct PyramidReturn {
    by: vec3<f32>,
    plastic: f32,
    gap: f32,
}

fn pyramid_at(id: u32, plastic: f32) -> Pyramid {
    if CHANGING_PYRAMIDS {
        if plastic < laws[id].settled {
            let sine_now = sine(evolution_at(laws[id].friction, plastic).value);
            let strength = 2.0 * evolution_at(laws[id].cohesion, plastic).value * sqrt(max(1.0 - sine_now * sine_now, 0.0));
            var flow = laws[id].sin_dilation;
            if MOBILISED {
                if laws[id].dilation_factor > 0.0 {
                    let rise = 1.7320508 * potential_slope(id, 1.1547005 * sine_now / (3.0 - sine_now));
                    flow = 3.0 * rise / (2.0 + rise);
                }
            }
            var apex = HUGE;
            if sine_now > 0.0 {
                apex = min(strength / (2.0 * sine_now), HUGE);
            }
            return Pyramid(sine_now, flow, strength, apex);
        }
    }
    return Pyramid(laws[id].sin_friction, laws[id].sin_dilation, laws[id].strength, laws[id].apex);
}

fn correction(id: u32, pyramid: Pyramid, s: vec3<f32>, mean: f32, excess: f32) -> vec4<f32> {
    let sine = pyramid.sin_friction;
    let flow = pyramid.sin_dilation;
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
        return vec4<f32>(vec3<f32>(largest, other, smallest) * m, 0.0);
    }
    let extension = upper - lower - flow * (s.x - s.z) > 0.0;
    let sign = select(-1.0, 1.0, extension);
    let gap = select(upper, lower, extension);
    let across = 2.0 * g * (1.0 + sign * (sine + flow) - sine * flow * 0.33333333) + 2.0 * swell * sine;
    let sum = (2.0 * excess - gap * (1.0 - sign * sine)) / (own + across);
    if mean - swell * sum > pyramid.apex {
        return vec4<f32>(vec3<f32>(pyramid.apex - mean) - s, max((mean - pyramid.apex) / laws[id].bulk, 0.0));
    }
    if extension {
        let both = (other + smallest) * sum;
        return vec4<f32>(largest * sum, 0.5 * (both - gap), 0.5 * (both + gap), 0.0);
    }
    let both = (largest + other) * sum;
    return vec4<f32>(0.5 * (both - gap), 0.5 * (both + gap), smallest * sum, 0.0);
}

fn return_to(id: u32, pyramid: Pyramid, s: vec3<f32>, mean: f32) -> PyramidReturn {
    let excess = (s.x - s.z) + ((s.x + s.z) + 2.0 * mean) * pyramid.sin_friction - pyramid.strength;
    if excess <= 0.0 {
        return PyramidReturn(vec3<f32>(0.0), 0.0, 0.0);
    }
    let change = correction(id, pyramid, s, mean, excess);
    let by = change.xyz;
    let middle = (by.x + by.y + by.z) * 0.33333333;
    let plastic = (by - middle) / (2.0 * laws[id].shear) + vec3<f32>(middle / (3.0 * laws[id].bulk));
    return PyramidReturn(by, sqrt(0.66666667 * (plastic.x * plastic.x + plastic.y * plastic.y + plastic.z * plastic.z)), change.w);
}

fn hardened_pyramid(id: u32, s: vec3<f32>, mean: f32, before: f32, first: f32) -> PyramidReturn {
    let noise = 2e-7 * ((s.x - s.z) + abs(mean)) / laws[id].shear;
    var low = 0.0;
    var low_rest = -first;
    var high = first;
    var found = return_to(id, pyramid_at(id, before + high), s, mean);
    for (var round = 0; round < 40; round++) {
        if high >= found.plastic {
            break;
        }
        low = high;
        low_rest = high - found.plastic;
        high *= 2.0;
        found = return_to(id, pyramid_at(id, before + high), s, mean);
    }
    var high_rest = high - found.plastic;
    if high_rest <= 1e-6 * found.plastic + noise {
        return found;
    }
    var stayed = 0;
    for (var round = 1; round <= 60; round++) {
        let share = select(low_rest / (low_rest - high_rest), 0.5, round % 8 == 0);
        let middle = low + share * (high - low);
        if middle <= low || middle >= high {
            break;
        }
        let there = return_to(id, pyramid_at(id, before + middle), s, mean);
        let rest = middle - there.plastic;
        if abs(rest) <= 1e-6 * there.plastic + noise {
            return there;
        }
        if rest < 0.0 {
            low = middle;
            low_rest = rest;
            if stayed == 1 {
                high_rest *= 0.5;
            }
            stayed = 1;
        } else {
            high = middle;
            high_rest = rest;
            found = there;
            if stayed == -1 {
                low_rest *= 0.5;
            }
            stayed = -1;
        }
    }
    return PyramidReturn(found.by, high, found.gap);
}

fn mohr_coulomb(id: u32, elastic: Sym, deviator: Sym, mean: f32, plastic: f32) -> Step {
    let a = principal(deviator);
    var end = return_to(id, pyramid_at(id, plastic), a.on, mean);
    if CHANGING_PYRAMIDS {
        if plastic < laws[id].settled && end.plastic > 0.0 {
            end = hardened_pyramid(id, a.on, mean, plastic, end.plastic);
        }
    }
    let by = end.by;
    return Step(
        Sym(
            elastic.normal + (by.x * (a.u * a.u) + by.y * (a.v * a.v) + by.z * (a.w * a.w)),
            elastic.shear + (by.x * (a.u * a.u.yzx) + by.y * (a.v * a.v.yzx) + by.z * (a.w * a.w.yzx)),
        ),
        end.plastic,
        end.gap,
    );
}
