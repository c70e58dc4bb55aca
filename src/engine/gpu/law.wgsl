// Stress increments of the laws. Twin: law.rs, where the functions are documented.

// xx, yy, zz and xy, yz, zx
struct Sym {
    normal: vec3<f32>,
    shear: vec3<f32>,
}

struct Step {
    stress: Sym,
    plastic: f32,
    gap: f32,
}

struct YieldParameters {
    alpha: f32,
    kappa: f32,
}

struct Surface {
    yield_parameters: YieldParameters,
    slope: YieldParameters,
}

struct Value {
    value: f32,
    slope: f32,
}

// power (1 + rest), the power one of 2
struct Exponential {
    power: f32,
    rest: f32,
}

struct Returned {
    di1: f32,
    dj: f32,
    on_cone: bool,
}

struct Hardened {
    end: Returned,
    plastic: f32,
}

struct Flow {
    volume_return: f32,
    per_multiplier: f32,
    alpha: f32,
    per_alpha: f32,
}

fn product(a: Sym, b: Sym) -> f32 {
    return dot(a.normal, b.normal) + 2.0 * dot(a.shear, b.shear);
}

fn sine(angle: f32) -> f32 {
    let q = angle * angle;
    let sum = ((((1.6059044e-10 * q - 2.5052108e-8) * q + 2.7557319e-6) * q - 1.9841270e-4) * q + 8.3333333e-3) * q - 1.6666667e-1;
    return angle + angle * (q * sum);
}

fn exponential(x: f32) -> Exponential {
    let n = floor(0.5 - x * 1.4426950);
    let r = (x + n * 0.693145752) + n * 1.42860677e-6;
    let sum = (((((1.9841270e-4 * r + 1.3888889e-3) * r + 8.3333333e-3) * r + 4.1666667e-2) * r + 1.6666667e-1) * r + 0.5) * r + 1.0;
    return Exponential(bitcast<f32>((127 - i32(n)) << 23u), r * sum);
}

fn decay_of(x: f32) -> f32 {
    if x > 80.0 {
        return 0.0;
    }
    let e = exponential(-x);
    return (1.0 + e.rest) * e.power;
}

fn evolution_at(e: Evolution, x: f32) -> Value {
    if e.kind == 0u {
        return Value(e.last, 0.0);
    }
    if e.kind == 1u {
        if x < e.strain {
            let slope = (e.last - e.initial) / e.strain;
            return Value(e.initial + slope * x, slope);
        }
        return Value(e.last, 0.0);
    }
    let c = e.cubic;
    if x <= 0.0 {
        return Value(e.initial, c.z);
    }
    if x <= e.peak_strain {
        return Value(((c.x * x + c.y) * x + c.z) * x + c.w, (3.0 * c.x * x + 2.0 * c.y) * x + c.z);
    }
    let left = (e.peak - e.residual) * decay_of(e.decay * (x - e.peak_strain));
    return Value(e.residual + left, -e.decay * left);
}

fn edge(angle: Value, cohesion: Value, s: f32, c: f32, sign: f32) -> Surface {
    let root = 1.1547005;
    let below = 1.0 / (3.0 + sign * s);
    let k = 3.0 * root * c * below;
    let dalpha = 3.0 * root * c * (below * below);
    let dk = 3.0 * root * (-s * below - sign * (c * c) * (below * below));
    return Surface(
        YieldParameters(root * s * below, k * cohesion.value),
        YieldParameters(dalpha * angle.slope, dk * angle.slope * cohesion.value + k * cohesion.slope),
    );
}

fn surface(id: u32, plastic: f32) -> Surface {
    if plastic >= laws[id].settled {
        return Surface(YieldParameters(laws[id].last_alpha, laws[id].last_kappa), YieldParameters(0.0, 0.0));
    }
    let angle = evolution_at(laws[id].friction, plastic);
    let cohesion = evolution_at(laws[id].cohesion, plastic);
    let s = sine(angle.value);
    let c = sqrt(max(1.0 - s * s, 0.0));
    if laws[id].cone == 0u {
        return edge(angle, cohesion, s, c, -1.0);
    }
    if laws[id].cone == 1u {
        return edge(angle, cohesion, s, c, 1.0);
    }
    let below = 1.0 / sqrt(9.0 + 3.0 * s * s);
    let cube = below * below * below;
    let k = 3.0 * c * below;
    let dalpha = 9.0 * c * cube;
    let dk = -3.0 * s * below - 9.0 * s * c * c * cube;
    return Surface(
        YieldParameters(s * below, k * cohesion.value),
        YieldParameters(dalpha * angle.slope, dk * angle.slope * cohesion.value + k * cohesion.slope),
    );
}

fn cut_of(id: u32, s: YieldParameters) -> f32 {
    if s.alpha > 0.0 {
        return min(laws[id].cut, s.kappa / s.alpha);
    }
    return laws[id].cut;
}

fn corner(s: YieldParameters, cut: f32) -> f32 {
    if s.alpha > 0.0 {
        return max(s.kappa - s.alpha * cut, 0.0);
    }
    return s.kappa;
}

fn inside(id: u32, s: YieldParameters, i1: f32, j: f32) -> bool {
    return j + s.alpha * i1 <= s.kappa && i1 <= cut_of(id, s);
}

fn potential_slope(id: u32, alpha: f32) -> f32 {
    return laws[id].dilation_factor * max(alpha - laws[id].critical, 0.0);
}

fn flow_at(id: u32, alpha: f32) -> Flow {
    if MOBILISED {
        if laws[id].dilation_factor > 0.0 {
            let slope = potential_slope(id, alpha);
            let per_alpha = select(0.0, laws[id].dilation_factor, alpha > laws[id].critical);
            return Flow(9.0 * laws[id].bulk * slope, sqrt(0.33333333 + 2.0 * (slope * slope)), slope, per_alpha);
        }
    }
    return Flow(laws[id].volume_return, laws[id].per_multiplier, 0.0, 0.0);
}

fn returned(id: u32, s: YieldParameters, i1: f32, j: f32) -> Returned {
    let cut = cut_of(id, s);
    let excess = j + s.alpha * i1 - s.kappa;
    if i1 <= cut {
        if excess <= 0.0 {
            return Returned(0.0, 0.0, false);
        }
    } else if j <= corner(s, cut) {
        return Returned(cut - i1, 0.0, false);
    }
    let volume_return = flow_at(id, s.alpha).volume_return;
    let multiplier = excess / (laws[id].shear + volume_return * s.alpha);
    let di1 = -volume_return * multiplier;
    if i1 + di1 > cut {
        return Returned(cut - i1, corner(s, cut) - j, false);
    }
    return Returned(di1, max(-laws[id].shear * multiplier, -j), true);
}

fn increment_of(id: u32, end: Returned) -> f32 {
    let shear = end.dj / laws[id].shear;
    let volume = end.di1 / (3.0 * laws[id].bulk);
    return sqrt((shear * shear) * 0.33333333 + (volume * volume) * 0.22222222);
}

fn largest_increment(id: u32, i1: f32, j: f32) -> f32 {
    let multiplier = j / laws[id].shear;
    let volume = max(laws[id].volume_return * multiplier, i1) / (3.0 * laws[id].bulk);
    return sqrt((multiplier * multiplier) * 0.33333333 + (volume * volume) * 0.22222222) * 1.00001 + 1e-30;
}

fn at_jump(id: u32, i1: f32, j: f32, increment: f32, s: YieldParameters) -> Returned {
    let flow = flow_at(id, s.alpha);
    let multiplier = increment / flow.per_multiplier;
    let end = Returned(-flow.volume_return * multiplier, -laws[id].shear * multiplier, true);
    if j + end.dj >= 0.0 && inside(id, s, i1 + end.di1, j + end.dj) {
        return end;
    }
    return returned(id, s, i1, j);
}

fn hardened(id: u32, i1: f32, j: f32, before: f32, first: Surface) -> Hardened {
    let noise = 2e-7 * (j + abs(i1)) / laws[id].shear;
    var low = 0.0;
    var high = largest_increment(id, i1, j);
    var at = 0.0;
    var now = first;
    for (var round = 0; round < 40; round++) {
        let end = returned(id, now.yield_parameters, i1, j);
        let increment = increment_of(id, end);
        let rest = at - increment;
        if abs(rest) <= 1e-6 * increment + noise {
            return Hardened(end, increment);
        }
        if rest < 0.0 {
            low = at;
        } else {
            high = at;
        }
        var tangent = 1.0;
        if end.on_cone {
            let alpha = now.yield_parameters.alpha;
            let flow = flow_at(id, alpha);
            let stiffness = laws[id].shear + flow.volume_return * alpha;
            tangent = 1.0 - flow.per_multiplier * ((i1 + end.di1) * now.slope.alpha - now.slope.kappa) / stiffness;
            if MOBILISED {
                let change = flow.per_alpha * now.slope.alpha;
                let multiplier = increment / flow.per_multiplier;
                let stiffer = 9.0 * laws[id].bulk * alpha * flow.per_multiplier / stiffness;
                tangent += multiplier * change * (stiffer - 2.0 * flow.alpha / flow.per_multiplier);
            }
        }
        let next = at - rest / tangent;
        if round < 10 && next > low && next < high {
            at = next;
        } else {
            at = low + 0.5 * (high - low);
        }
        if at <= low || at >= high {
            break;
        }
        now = surface(id, before + at);
    }
    return Hardened(at_jump(id, i1, j, high, surface(id, before + high).yield_parameters), high);
}

fn stress_step(id: u32, before: Sym, strain: Sym, plastic: f32) -> Step {
    if CAM_CLAY {
        if laws[id].kind == 3u {
            return cam_clay(id, before, strain, plastic);
        }
    }
    let two_g = 2.0 * laws[id].shear;
    let lame = laws[id].bulk - two_g * 0.33333333;
    let volume = lame * (strain.normal.x + strain.normal.y + strain.normal.z);
    let elastic = Sym(vec3<f32>(volume) + two_g * strain.normal, two_g * strain.shear);
    if !YIELDS || laws[id].kind == 0u {
        return Step(elastic, 0.0, 0.0);
    }
    let normal = before.normal + elastic.normal;
    let shear = before.shear + elastic.shear;
    let i1 = normal.x + normal.y + normal.z;
    let d = normal - normal.yzx;
    let j = sqrt((d.x * d.x + d.y * d.y + d.z * d.z) * 0.16666667 + (shear.x * shear.x + shear.y * shear.y + shear.z * shear.z));
    // the deviator from differences of normal stresses, so that a large pressure does not spoil its digits
    let deviator = (d - d.zxy) * 0.33333333;
    if MOHR_COULOMB {
        if laws[id].kind == 2u {
            if inside(id, YieldParameters(laws[id].last_alpha, laws[id].last_kappa), i1, j) {
                return Step(elastic, 0.0, 0.0);
            }
            return mohr_coulomb(id, elastic, Sym(deviator, shear), i1 * 0.33333333, plastic);
        }
    }
    let now = surface(id, plastic);
    if inside(id, now.yield_parameters, i1, j) {
        return Step(elastic, 0.0, 0.0);
    }
    var end = Hardened(Returned(0.0, 0.0, false), 0.0);
    if plastic >= laws[id].settled {
        let there = returned(id, now.yield_parameters, i1, j);
        end = Hardened(there, increment_of(id, there));
    } else {
        end = hardened(id, i1, j, plastic, now);
    }
    var share = 0.0;
    if j > 0.0 {
        share = end.end.dj / j;
    }
    let mean = end.end.di1 * 0.33333333;
    let gap = select(-end.end.di1 / (3.0 * laws[id].bulk), 0.0, end.end.on_cone);
    return Step(Sym(elastic.normal + (deviator * share + vec3<f32>(mean)), elastic.shear + shear * share), end.plastic, gap);
}
