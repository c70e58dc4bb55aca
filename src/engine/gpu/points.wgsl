// Velocity, position, strain and stress of the points from the velocities of the nodes: one thread per point. Twins (f64): mpm/pass.rs, mpm/stress.rs, with which
// gpu/tests/step.rs compares it.

fn report_fault(fault: u32, i: u32) {
    atomicMin(&status.fault, 8u * identity(i) + fault);
}

// Velocities of three nodes along x.
fn speeds(at: vec3<u32>) -> mat3x3<f32> {
    let plane = SPEED * params.cells;
    return mat3x3<f32>(nodes[plane + at.x].xyz, nodes[plane + at.y].xyz, nodes[plane + at.z].xyz);
}

// Changes of their velocities, and stiffness over mass.
fn changes(at: vec3<u32>) -> mat3x4<f32> {
    let plane = CHANGE * params.cells;
    return mat3x4<f32>(nodes[plane + at.x], nodes[plane + at.y], nodes[plane + at.z]);
}

// Velocity (Li et al. 2023, eq. 30) and position (eq. 33).
@compute @workgroup_size(GROUP)
fn advance(one: Thread) {
    let i = linear(one);
    if i >= params.points || status.stop != 0u {
        return;
    }
    let place = word(PLACE, i);
    let base = cell_place(place.w);
    let c = corners(base >> SHIFT);
    let o = offset(place);
    let x = spline(o.x);
    let y = spline(o.y);
    let z = spline(o.z);
    var field = vec3<f32>(0.0);
    var gain_and_rate = vec4<f32>(0.0);
    for (var k = 0; k < 9; k++) {
        let at = three_nodes(c, base + vec3<i32>(0, k % 3, k / 3));
        let weights = x * (y[k % 3] * z[k / 3]);
        field += speeds(at) * weights;
        gain_and_rate += changes(at) * weights;
    }
    let gain = gain_and_rate.xyz;
    let own = number(VELOCITY, i);
    let low = number(VELOCITY_LOW, i);
    // the new velocity (1 − α)(v + Σ N Δv) + α Σ N v of the blend, as an increment
    let by = (1.0 - params.pic) * gain + params.pic * ((field - own.xyz) - low.xyz);
    let next = add(vec4<f32>(own.xyz, 0.0), vec4<f32>(low.xyz, 0.0), vec4<f32>(by, 0.0));
    let d = field * (batch.dt * params.inverse_cell);
    let far = abs(d);
    if not_finite(d.x) || not_finite(d.y) || not_finite(d.z) || not_finite(next.high.x) || not_finite(next.high.y) || not_finite(next.high.z) {
        report_fault(NOT_FINITE, i);
        return;
    }
    if max(far.x, max(far.y, far.z)) >= 1.5 {
        report_fault(TOO_FAST, i);
        return;
    }
    if GRAINS {
        keep_transport_velocity(i, o, base, field, gain_and_rate.w);
    }
    let rest = number(REST, i);
    let there = moved(bitcast<vec3<i32>>(place.xyz), rest.xyz, d);
    put(VELOCITY, i, vec4<f32>(next.high.xyz, own.w));
    state[VELOCITY_LOW * params.points + i] = vec4<u32>(bitcast<vec3<u32>>(next.low.xyz), word(VELOCITY_LOW, i).w);
    put(REST, i, vec4<f32>(there.rest, rest.w));
    if PRESSED {
        follow(i, -d);
    }
    var home = place.w;
    if any(there.shift != vec3<i32>(0)) {
        if any(there.units >= vec3<i32>(HALF)) || any(there.units < vec3<i32>(-HALF)) {
            report_fault(TOO_FAST, i);
            return;
        }
        let to = base + there.shift;
        let n = cell_size();
        if any(to < vec3<i32>(0)) || any(to >= n) {
            report_fault(OUTSIDE, i);
            return;
        }
        home = cell_number(to);
        change_cell(cell_index(base), cell_index(to));
    }
    state[PLACE * params.points + i] = vec4<u32>(bitcast<vec3<u32>>(there.units), home);
}

// Moves the pressed faces of a point by `by` cells relative to the point.
fn follow(i: u32, by: vec3<f32>) {
    let arm = number(ARM, i);
    let pressed = arm.xyz != vec3<f32>(0.0);
    if any(pressed) {
        let next = add(arm, number(ARM_LOW, i), vec4<f32>(select(vec3<f32>(0.0), by, pressed), 0.0));
        put(ARM, i, next.high);
        put(ARM_LOW, i, next.low);
    }
}

// W σ − σ W with the spin increments w = (W_xy, W_yz, W_zx).
fn spin_rate(a: Sym, w: vec3<f32>) -> Sym {
    let n = a.normal;
    let s = a.shear;
    let c = w * s;
    return Sym(
        2.0 * vec3<f32>(c.x - c.z, c.y - c.x, c.z - c.y),
        vec3<f32>(
            w.x * (n.y - n.x) - w.z * s.y + w.y * s.z,
            w.y * (n.z - n.y) - w.x * s.z + w.z * s.x,
            w.z * (n.x - n.z) - w.y * s.x + w.x * s.y,
        ),
    );
}

// What soil with a gap makes of a strain increment: whether it still has its stress, its gap, and the share of the increment that it follows.
struct Opened {
    bonded: bool,
    gap: vec2<f32>,
    share: f32,
}

// Mean tension over bulk modulus up to which a stress is none.
const NO_TENSION: f32 = 1e-7;

// Twin: mpm/law/gap.rs.
fn opened(law: u32, stress: Sym, growth: f32, gap: vec2<f32>) -> Opened {
    let tension = stress.normal.x + stress.normal.y + stress.normal.z;
    if gap.x <= 0.0 || (growth >= 0.0 && tension > 3.0 * NO_TENSION * laws[law].bulk) {
        return Opened(true, gap, 1.0);
    }
    let next = grown(gap, growth);
    if next.x > 0.0 {
        return Opened(false, next, 0.0);
    }
    return Opened(false, vec2<f32>(0.0), next.x / growth);
}

// Strain and spin increments, volume, stress.
@compute @workgroup_size(GROUP)
fn strain(one: Thread) {
    let i = linear(one);
    if i >= params.points || status.stop != 0u {
        return;
    }
    let place = word(PLACE, i);
    let base = cell_place(place.w);
    let c = corners(base >> SHIFT);
    let o = offset(place);
    let x = spline(o.x);
    let y = spline(o.y);
    let z = spline(o.z);
    let slope_x = spline_slope(o.x);
    let slope_y = spline_slope(o.y);
    let slope_z = spline_slope(o.z);
    // columns of the velocity gradient: ∂v/∂x, ∂v/∂y, ∂v/∂z
    var dx = vec3<f32>(0.0);
    var dy = vec3<f32>(0.0);
    var dz = vec3<f32>(0.0);
    for (var k = 0; k < 9; k++) {
        let v = speeds(three_nodes(c, base + vec3<i32>(0, k % 3, k / 3)));
        let along = v * x;
        dx += (v * slope_x) * (y[k % 3] * z[k / 3]);
        dy += along * (slope_y[k % 3] * z[k / 3]);
        dz += along * (y[k % 3] * slope_z[k / 3]);
    }
    let scale = batch.dt * params.inverse_cell;
    if PRESSED {
        let arm = number(ARM, i).xyz;
        if any(arm != vec3<f32>(0.0)) {
            var way = vec3<f32>(0.0);
            for (var k = 0; k < 27; k++) {
                let d = vec3<i32>(k % 3, (k / 3) % 3, k / 9);
                let own = vec3<f32>(x[d.x], y[d.y], z[d.z]);
                let there = at_faces(d, o, arm, own);
                let at_node = vec3<f32>(there.x * own.y * own.z, own.x * there.y * own.z, own.x * own.y * there.z);
                way += nodes[SPEED * params.cells + node_index(base + d)].xyz * at_node;
            }
            follow(i, way * scale);
        }
    }
    if GRAINS {
        follow_faces(i, o, base);
    }
    dx *= scale;
    dy *= scale;
    dz *= scale;
    let increment = Sym(vec3<f32>(dx.x, dy.y, dz.z), 0.5 * vec3<f32>(dx.y + dy.x, dy.z + dz.y, dz.x + dx.z));
    let spin = 0.5 * vec3<f32>(dy.x - dx.y, dz.y - dy.z, dx.z - dz.x);

    let normal = number(NORMAL, i);
    let shear = number(SHEAR, i);
    let normal_low = number(NORMAL_LOW, i);
    let shear_low = number(SHEAR_LOW, i);
    let law = law_of(i);
    // rotation of the stress to second order, as in mpm/stress.rs
    let first = spin_rate(Sym(normal.xyz, shear.xyz), spin);
    let second = spin_rate(first, spin);
    let turn = Sym(first.normal + 0.5 * second.normal, first.shear + 0.5 * second.shear);
    let before = Sym(normal.xyz + (normal_low.xyz + turn.normal), shear.xyz + (shear_low.xyz + turn.shear));
    let trace = increment.normal.x + increment.normal.y + increment.normal.z;
    let none = vec3<f32>(0.0);
    let kept = number(WORK, i);
    var gap = vec2<f32>(0.0);
    var now = Opened(true, gap, 1.0);
    if YIELDS {
        gap = kept.zw;
        now = opened(law, before, trace, gap);
    }
    let begin = Sym(select(none, before.normal, now.bonded), select(none, before.shear, now.bonded));
    var step = Step(Sym(none, none), 0.0, 0.0);
    if now.share > 0.0 {
        step = stress_step(law, begin, Sym(increment.normal * now.share, increment.shear * now.share), shear.w + shear_low.w);
    }
    // a gap is no part of the volume of the soil
    let growth = normal.w * ((trace - (now.gap.x - gap.x)) - step.gap);
    let bonded = vec4<bool>(vec3<bool>(now.bonded), true);
    let turned = select(none, turn.normal, now.bonded);
    let a = add(select(vec4<f32>(0.0), normal, bonded), select(vec4<f32>(0.0), normal_low, bonded), vec4<f32>(turned + step.stress.normal, growth));
    let turned_shear = select(none, turn.shear, now.bonded);
    let b = add(select(vec4<f32>(0.0), shear, bonded), select(vec4<f32>(0.0), shear_low, bonded), vec4<f32>(turned_shear + step.stress.shear, step.plastic));
    if not_finite(a.high.x) || not_finite(a.high.y) || not_finite(a.high.z) || not_finite(b.high.x) || not_finite(b.high.y) || not_finite(b.high.z) {
        report_fault(NOT_FINITE, i);
        return;
    }
    if !(a.high.w > 0.0) {
        report_fault(INVERTED, i);
        return;
    }
    put(NORMAL, i, a.high);
    put(SHEAR, i, b.high);
    put(NORMAL_LOW, i, a.low);
    put(SHEAR_LOW, i, b.low);
    if YIELDS {
        if step.gap != 0.0 || gap.x > 0.0 {
            gap = grown(now.gap, step.gap);
        }
    }
    // stress work, from the mean of the stresses and volumes before and after
    let mean = 0.5 * (normal.w + a.high.w);
    let after = Sym(a.high.xyz, b.high.xyz);
    let done = 0.5 * mean * (product(before, increment) + product(after, increment));
    put(WORK, i, vec4<f32>(grown(kept.xy, done), gap));
}

// Ends a step: sums up what loading plates bear, counts the step if no point has a fault, and stops the batch otherwise; then what grains or the next step begin with. A
// loading plate has passed through a point at the places of a step that counts.
@compute @workgroup_size(WIDE)
fn finish(@builtin(local_invocation_index) thread: u32) {
    let fault = atomicLoad(&status.fault);
    let passed = status.stop == 0u && fault != NO_FAULT && fault % 8u == PASSED;
    // points from breakages that have been pushed through a loading plate go back to the reserve
    let sound = (status.stop == 0u && fault == NO_FAULT) || (FINES && passed);
    let counts_step = sound || passed;
    workgroupBarrier();
    if WALLED {
        sum_walls(thread);
    }
    if PRESSED {
        sum_plate_loads(thread, sound);
    }
    if thread == 0u {
        if counts_step {
            status.steps += 1u;
            batch.time = grown(batch.time, batch.dt);
        }
        if sound {
            count_step();
        } else {
            status.stop = 1u;
        }
    }
    end_step(thread);
}

// The largest sum of wave speed and speed of a point, for the bound on the time step (mpm/check.rs). Positive numbers are in the order of their bits.
@compute @workgroup_size(GROUP)
fn survey(one: Thread) {
    let i = linear(one);
    if i >= params.points {
        return;
    }
    let law = law_of(i);
    var modulus = laws[law].bulk + 1.3333334 * laws[law].shear;
    if CAM_CLAY {
        if laws[law].kind == 3u {
            let moduli = clay_moduli_at(law, number(NORMAL, i).xyz, number(SHEAR, i).w);
            modulus = moduli.bulk + 1.3333334 * moduli.shear;
        }
    }
    let v = number(VELOCITY, i);
    atomicMax(&status.fastest, bitcast<u32>(sqrt(modulus * number(NORMAL, i).w / v.w) + length(v.xyz)));
}
