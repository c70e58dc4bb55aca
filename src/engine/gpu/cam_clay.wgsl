// Modified Cam-clay. Twin: cam_clay.rs, where the functions are documented.

const LN_2: f32 = 0.69314718;
// smallest mean pressure over the preconsolidation pressure at the start, and its logarithm
const LEAST: f32 = 1e-3;
const LN_LEAST: f32 = -6.9077553;
// largest exponent
const MOST: f32 = 40.0;

struct Moduli {
    bulk: f32,
    shear: f32,
}

struct ClayTrial {
    // over the preconsolidation pressure: ln(2p) of the trial state, and q/M
    critical: f32,
    ratio: f32,
    // of ln p_c over the fall of ln(p/p_c) in the return
    stretch: f32,
    // M² v and 6 G (λ − κ)/p_c
    elastic: f32,
    plastic: f32,
}

struct ClayReturn {
    growth: f32,
    less: f32,
}

fn less_one(x: f32) -> f32 {
    let e = exponential(x);
    return e.power * e.rest + (e.power - 1.0);
}

fn logarithm(x: f32) -> f32 {
    let bits = bitcast<u32>(x);
    var exponent = i32(bits >> 23u) - 127;
    var part = bitcast<f32>((bits & 0x7fffffu) | 0x3f800000u);
    if part > 1.4142135 {
        part *= 0.5;
        exponent += 1;
    }
    let f = (part - 1.0) / (part + 1.0);
    let q = f * f;
    let sum = (((0.11111111 * q + 0.14285714) * q + 0.2) * q + 0.33333333) * q;
    let n = f32(exponent);
    return n * 0.693145752 + (n * 1.42860677e-6 + 2.0 * (f + f * sum));
}

fn clay_volume(id: u32, height: f32, plastic: f32) -> f32 {
    let c = laws[id].clay;
    return max(c.virgin_volume * (1.0 - plastic) - c.swelling_slope * height, 1.0);
}

fn clay_moduli(id: u32, p: f32, v: f32) -> Moduli {
    let bulk = v * p / laws[id].clay.swelling_slope;
    if laws[id].clay.shear_ratio > 0.0 {
        return Moduli(bulk, laws[id].clay.shear_ratio * bulk);
    }
    return Moduli(bulk, laws[id].shear);
}

fn clay_moduli_at(id: u32, normal: vec3<f32>, plastic: f32) -> Moduli {
    let c = laws[id].clay;
    let p = max((normal.x + normal.y + normal.z) * -0.33333333, LEAST * c.preconsolidation);
    return clay_moduli(id, p, clay_volume(id, logarithm(p / c.preconsolidation), plastic));
}

fn clay_returned(trial: ClayTrial) -> ClayReturn {
    let stretch = trial.stretch;
    let critical = trial.critical;
    var inside = 0.0;
    var outside = min(critical, LN_2);
    var z = outside;
    var x = 0.0;
    var e = 0.0;
    var over = 1.0;
    var larger = 1.0;
    var gone = 1.0;
    for (var round = 0; round < 40; round++) {
        x = (critical - z) * stretch;
        let there = exponential(z);
        e = there.power * there.rest + (there.power - 1.0);
        over = there.power * there.rest + there.power;
        larger = less_one(clamp(x, -MOST, MOST)) + 1.0;
        gone = 1.0;
        if z == 0.0 {
            break;
        }
        let flow = trial.elastic * e;
        let g = trial.plastic / larger;
        let sum = flow + g * x;
        let share = flow / sum;
        gone = g * x / sum;
        let ratio = trial.ratio / larger;
        let rest = (share * ratio) * (share * ratio) - 0.25 * (over * (1.0 - e));
        if abs(rest) <= 5e-8 * over {
            break;
        }
        if rest > 0.0 {
            outside = z;
        } else {
            inside = z;
        }
        let share_slope = trial.elastic * (over * g * x - e * g * (x - 1.0) * stretch) / (sum * sum);
        let slope = 2.0 * share * (ratio * ratio) * (share_slope + share * stretch) + 0.5 * e * over;
        let next = z - rest / slope;
        if (next - inside) * (next - outside) < 0.0 {
            z = next;
        } else {
            z = inside + 0.5 * (outside - inside);
        }
        if z == inside || z == outside {
            break;
        }
    }
    if e <= 0.8 && gone >= abs(e) && trial.ratio > 0.0 {
        gone = 1.0 - 0.5 * larger * sqrt(max(over * (1.0 - e), 0.0)) / trial.ratio;
    }
    return ClayReturn(x, -gone);
}

fn cam_clay(id: u32, before: Sym, strain: Sym, plastic: f32) -> Step {
    let c = laws[id].clay;
    let mean = (before.normal.x + before.normal.y + before.normal.z) * -0.33333333;
    let p = max(mean, LEAST * c.preconsolidation);
    let height = logarithm(p / c.preconsolidation);
    let v = clay_volume(id, height, plastic);
    let trace = strain.normal.x + strain.normal.y + strain.normal.z;
    let asked = clamp(min(-v * trace, v - 1.0) / c.swelling_slope, -MOST, MOST);
    let least = LN_LEAST - height;
    var opens = asked < least;
    var rise = max(asked, least);
    var followed = select(trace, -least * c.swelling_slope / v, opens);
    let shear = clay_moduli(id, p, v).shear;
    let d = before.normal - before.normal.yzx;
    let by = strain.normal - strain.normal.yzx;
    let elastic = Sym(2.0 * shear * ((by - by.zxy) * 0.33333333), 2.0 * shear * strain.shear);
    let deviator = Sym((d - d.zxy) * 0.33333333 + elastic.normal, before.shear + elastic.shear);
    let q2 = 1.5 * product(deviator, deviator);
    let hardening = plastic * c.per_plastic;
    let p_c = c.preconsolidation * (less_one(clamp(hardening, -MOST, MOST)) + 1.0);
    var end = ClayReturn(0.0, 0.0);
    let ratio = sqrt(q2) / (c.slope * p_c);
    let high = (p + p * less_one(rise)) / p_c;
    if ratio * ratio > high * (1.0 - high) {
        let base = height - hardening + LN_2;
        let hard = 6.0 * shear * c.swelling_slope * c.ratio / p_c;
        let square = c.slope * c.slope;
        let stretch = 1.0 / (1.0 + c.ratio);
        end = clay_returned(ClayTrial(base + rise, ratio, select(stretch, 1.0, opens), square * max(v + v * followed, 1.0), hard));
        if opens {
            followed -= c.swelling_slope * c.ratio * end.growth / v;
            if followed >= trace {
                opens = false;
                rise = asked;
                followed = trace;
                end = clay_returned(ClayTrial(base + rise, ratio, stretch, square * max(v + v * followed, 1.0), hard));
            }
        }
    }
    let lifted = select(max(rise - c.ratio * end.growth, least), least, opens);
    let pressure = p * less_one(lifted) + (p - mean);
    return Step(
        Sym(elastic.normal + (deviator.normal * end.less - vec3<f32>(pressure)), elastic.shear + deviator.shear * end.less),
        end.growth / c.per_plastic,
        trace - followed,
    );
}
