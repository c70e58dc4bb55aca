// Loading plates: rigid planes across an axis, and upright shells, that press on the ghosts of points (Li et al. 2023, eqs 18, 20, 22), with tractions on the points' faces.
// Twins (f64): mpm/loading_plate.rs, mpm/plate_drive.rs, where the method is documented.

struct LoadingPlate {
    // of a shell 0
    axis: u32,
    // component of the normal along the axis, 1 or -1; the normal points to the material. Of a shell -1
    normal: f32,
    // coordinate along the axis, as for points; of a shell its radius in the same form
    cell: i32,
    units: i32,
    rest: f32,
    // reduced modulus of the contacts, Pa
    modulus: f32,
    // speed along the normal, m/s; displacement in this step, m
    speed: f32,
    moved: f32,
    // sums over the contacts: normal force, N; normal stiffness, N/m; elastic energy, J. Largest stiffness over mass of a point, 1/s²
    reaction: f32,
    stiffness: f32,
    stored: f32,
    rate: f32,
    // work of the plate on the points, J
    work: vec2<f32>,
    // mean speed under servo control, m/s; mean overlap of the contacts, m; displacement since the batch began, m
    drift: f32,
    overlap: f32,
    way: f32,
    // area of the face over the product of the extents across the axis
    face: f32,
    // sums of way, overlap and reaction over the steps of the batch
    ways: vec2<f32>,
    overlaps: vec2<f32>,
    reactions: vec2<f32>,
    // of a shell: x and y of its axis, as for points
    centre_cell: vec2<i32>,
    centre_units: vec2<i32>,
    centre_rest: vec2<f32>,
    // 1: a shell; its distances are computed in quanta of 2^-split cells
    shell: u32,
    split: u32,
}

// State of a batch. Pairs are compensated sums.
struct BatchState {
    // seconds since the batch began
    time: vec2<f32>,
    // time step, s; number of terms in the sums
    dt: f32,
    count: u32,
    // sums of the normal forces of the sides of the domain on the material, N
    sides: array<vec2<f32>, BORDERS>,
    plates: array<LoadingPlate, PLATES>,
    // for each point the force of the loading plates, N, and its stiffness, N/m; then for each workgroup of points the sums for each loading plate
    parts: array<vec4<f32>>,
}

@group(0) @binding(9) var<storage, read_write> batch: BatchState;

var<workgroup> partial_sums: array<vec4<f32>, WIDE>;

fn cube_root(x: f32) -> f32 {
    let y = exp2(log2(x) * 0.33333333);
    // a Newton step, as the logarithm of the device may be inaccurate
    return y - (y * y * y - x) / (3.0 * y * y);
}

// Half the edge of the cube with the initial volume of a point, cells. With the bits that a face keeps at the first touch (keep): a run that is resumed computes the forces
// of that instant anew, with the face, and a product that is fused with the difference to it would leave its rounding error there.
fn half_edge(i: u32) -> f32 {
    return keep(vec4<f32>(0.5 * cube_root(number(REST, i).w) * params.inverse_cell)).x;
}

// Sums of three numbers, the maximum of the fourth.
fn summed(a: vec4<f32>, b: vec4<f32>) -> vec4<f32> {
    return vec4<f32>(a.xyz + b.xyz, max(a.w, b.w));
}

// How a plate and a point touch: overlap with the ghost, m, which keeps its distance from a followed face, and with a ghost about the point; normal into the
// material at that ghost, and at the point; whether a face is followed.
struct Touch {
    overlap: f32,
    of_point: f32,
    normal: vec3<f32>,
    at_point: vec3<f32>,
    followed: bool,
}

// Of a plane. In whole units as far as possible: the overlap is a small difference of coordinates.
fn touch_of_plane(plate: LoadingPlate, i: u32, arm: vec3<f32>, arm_low: vec3<f32>) -> Touch {
    let place = word(PLACE, i);
    let axis = plate.axis;
    let normal = i32(plate.normal);
    let cells = normal * (cell_place(place.w)[axis] - 1 - plate.cell);
    let units = normal * (bitcast<vec3<i32>>(place.xyz)[axis] - plate.units);
    let deep = f32(radius_in_units(i) - cells * WIDTH - units) - plate.normal * (number(REST, i)[axis] - plate.rest);
    // two cells away or more the plate is out of reach, or the point is far behind it
    let of_point = select(select(deep * (params.cell / UNITS), 2.0 * params.cell, cells < -1), 0.0, cells > 1);
    // once pressed, the ghost moves with the face of the point, not with the point
    let followed = arm[axis] * plate.normal < 0.0;
    var further = 0.0;
    if followed {
        further = (abs(arm[axis]) - half_edge(i)) - plate.normal * arm_low[axis];
    }
    let across = select(vec3<f32>(0.0), vec3<f32>(plate.normal), vec3<u32>(0u, 1u, 2u) == vec3<u32>(axis));
    return Touch(of_point + further * params.cell, of_point, across, across, followed);
}

// A coordinate in quanta of 2^-split cells: a whole number of them, and the rest.
fn quanta(cells: i32, units: i32, rest: f32, split: u32) -> vec2<f32> {
    let bits = 30u - split;
    let near = (units + (1i << (bits - 1u))) >> bits;
    return vec2<f32>(f32((cells << split) + near), (f32(units - (near << bits)) + rest) / f32(1u << bits));
}

// Of a shell: ρ − (R − r) with the distance ρ of the ghost from the axis, the shell's radius R and the ghost's r, as a difference of squares, which is computed in whole
// numbers as far as possible. Both numbers are below 2^14 quanta.
fn overlap_with_shell(x: vec2<f32>, y: vec2<f32>, inner: vec2<f32>, by: vec2<f32>) -> f32 {
    let part = vec2<f32>(x.y, y.y) + by;
    let whole = vec3<i32>(vec3<f32>(x.x, y.x, inner.x));
    let first = whole.x * whole.x + whole.y * whole.y - whole.z * whole.z;
    let second = 2.0 * (x.x * part.x + y.x * part.y - inner.x * inner.y);
    let third = dot(part, part) - inner.y * inner.y;
    return (f32(first) + (second + third)) / (length(vec2<f32>(x.x, y.x) + part) + (inner.x + inner.y));
}

fn touch_of_shell(plate: LoadingPlate, i: u32, arm: vec3<f32>, arm_low: vec3<f32>) -> Touch {
    let place = word(PLACE, i);
    let radius = radius_in_units(i);
    let cells = cell_place(place.w).xy - 1 - plate.centre_cell;
    let most = i32(16384u >> plate.split);
    if any(abs(cells) >= vec2<i32>(most)) {
        return Touch(2.0 * params.cell, 2.0 * params.cell, vec3<f32>(0.0), vec3<f32>(0.0), false);
    }
    let units = bitcast<vec3<i32>>(place.xyz).xy - plate.centre_units;
    let rest = number(REST, i).xy - plate.centre_rest;
    let x = quanta(cells.x, units.x, rest.x, plate.split);
    let y = quanta(cells.y, units.y, rest.y, plate.split);
    let inner = quanta(plate.cell + 1, plate.units - radius, plate.rest, plate.split);
    let quantum = params.cell / f32(1u << plate.split);
    let at = vec2<f32>(x.x + x.y, y.x + y.y);
    let away = length(at);
    let normal = -at / max(away, 1e-37);
    let of_point = overlap_with_shell(x, y, inner, vec2<f32>(0.0)) * quantum;
    // once pressed, the ghost moves with the faces of the point, not with the point
    let pressed = arm.xy * normal < vec2<f32>(0.0);
    if !any(pressed) {
        return Touch(of_point, of_point, vec3<f32>(normal, 0.0), vec3<f32>(normal, 0.0), false);
    }
    let back = keep(vec4<f32>(normal * half_edge(i), 0.0, 0.0)).xy;
    let by = select(vec2<f32>(0.0), (arm.xy + back) + arm_low.xy, pressed) * f32(1u << plate.split);
    let there = at + by;
    let ghost = -there / max(length(there), 1e-37);
    return Touch(overlap_with_shell(x, y, inner, by) * quantum, of_point, vec3<f32>(ghost, 0.0), vec3<f32>(normal, 0.0), true);
}

// Whether a loading plate may touch a point, or has passed it: it is at most a cell away. A face is let go before its plate is further away.
fn is_near_plates(i: u32) -> bool {
    let at = cell_place(word(PLACE, i).w) - 1;
    var near = false;
    for (var k = 0u; k < params.plates; k++) {
        if SHELLS && batch.plates[k].shell != 0u {
            // corners of cells are less than two cells from the places in them and from the axis
            let from_axis = vec2<f32>(at.xy - batch.plates[k].centre_cell);
            near = near || length(from_axis) + 4.0 > f32(batch.plates[k].cell);
        } else {
            let axis = batch.plates[k].axis;
            near = near || i32(batch.plates[k].normal) * (at[axis] - batch.plates[k].cell) <= 1;
        }
    }
    return near;
}

// 1 where a point of the workgroup touches a loading plate
var<workgroup> touched: u32;

// Forces of the loading plates on each point; for each workgroup and plate the sums of normal force, stiffness and elastic energy, and the largest stiffness over mass.
@compute @workgroup_size(GROUP)
fn plate_forces(one: Thread, @builtin(workgroup_id) group: vec3<u32>, @builtin(local_invocation_index) thread: u32) {
    let i = linear(one);
    var force = vec3<f32>(0.0);
    var arm = vec4<f32>(0.0);
    var arm_low = vec4<f32>(0.0);
    var changed = false;
    let near = i < params.points && is_near_plates(i);
    if near {
        arm = number(ARM, i);
        arm_low = number(ARM_LOW, i);
    }
    var stiffness = 0.0;
    for (var k = 0u; k < params.plates; k++) {
        var own = vec4<f32>(0.0);
        if near {
            let plate = batch.plates[k];
            var m: Touch;
            if SHELLS {
                if plate.shell == 0u {
                    m = touch_of_plane(plate, i, arm.xyz, arm_low.xyz);
                } else {
                    m = touch_of_shell(plate, i, arm.xyz, arm_low.xyz);
                }
            } else {
                m = touch_of_plane(plate, i, arm.xyz, arm_low.xyz);
            }
            let radius = f32(radius_in_units(i)) * (params.cell / UNITS);
            if m.overlap > radius {
                atomicMin(&status.fault, 8u * identity(i) + PASSED);
            } else if m.overlap > 0.0 {
                let tangent = 2.0 * plate.modulus * sqrt(radius * m.overlap);
                let f = 0.66666667 * tangent * m.overlap;
                own = vec4<f32>(f, tangent, 0.4 * f * m.overlap, tangent / number(VELOCITY, i).w);
                stiffness += tangent;
                force += m.normal * f;
                // a face is followed from the first touch on
                let fresh = (m.normal != vec3<f32>(0.0)) & (arm.xyz == vec3<f32>(0.0));
                if any(fresh) {
                    arm = select(arm, vec4<f32>(-m.normal * half_edge(i), 0.0), vec4<bool>(fresh, false));
                    arm_low = select(arm_low, vec4<f32>(0.0), vec4<bool>(fresh, false));
                    changed = true;
                }
            } else if m.followed && m.of_point <= 0.0 {
                let let_go = arm.xyz * m.at_point < vec3<f32>(0.0);
                arm = select(arm, vec4<f32>(0.0), vec4<bool>(let_go, false));
                arm_low = select(arm_low, vec4<f32>(0.0), vec4<bool>(let_go, false));
                changed = true;
            }
        }
        let total = total_of_group(thread, own);
        if thread == 0u {
            batch.parts[params.points + (group.x + group.y * one.groups.x) * PLATES + k] = total;
        }
    }
    if i < params.points {
        batch.parts[i] = vec4<f32>(force, stiffness);
        if changed {
            put(ARM, i, arm);
            put(ARM_LOW, i, arm_low);
        }
    }
}

// Sums of a workgroup of GROUP threads. Most workgroups have no point at a loading plate: all their numbers are zero.
fn total_of_group(thread: u32, own: vec4<f32>) -> vec4<f32> {
    if thread == 0u {
        touched = 0u;
    }
    workgroupBarrier();
    if own.x > 0.0 {
        touched = 1u;
    }
    if workgroupUniformLoad(&touched) == 0u {
        return vec4<f32>(0.0);
    }
    return total(thread, own, GROUP);
}

// Sums of a workgroup of so many threads.
fn total(thread: u32, own: vec4<f32>, threads: u32) -> vec4<f32> {
    partial_sums[thread] = own;
    workgroupBarrier();
    for (var half = threads / 2u; half > 0u; half /= 2u) {
        if thread < half {
            partial_sums[thread] = summed(partial_sums[thread], partial_sums[thread + half]);
        }
        workgroupBarrier();
    }
    return partial_sums[0];
}

// The plain sum of a workgroup of WIDE threads.
fn plain_total(thread: u32, own: vec4<f32>) -> vec4<f32> {
    partial_sums[thread] = own;
    workgroupBarrier();
    for (var half = WIDE / 2u; half > 0u; half /= 2u) {
        if thread < half {
            partial_sums[thread] += partial_sums[thread + half];
        }
        workgroupBarrier();
    }
    return partial_sums[0];
}

// Reactions of the loading plates at the end of a step, and their work.
fn sum_plate_loads(thread: u32, sound: bool) {
    let count = params.point_groups.x * params.point_groups.y;
    for (var k = 0u; k < params.plates; k++) {
        var own = vec4<f32>(0.0);
        for (var g = thread; g < count; g += WIDE) {
            own = summed(own, batch.parts[params.points + g * PLATES + k]);
        }
        let load = total(thread, own, WIDE);
        if thread == 0u && sound {
            store_plate_load(k, load);
        }
        workgroupBarrier();
    }
}

// What loading plates bear before the first step.
@compute @workgroup_size(WIDE)
fn plate_loads(@builtin(local_invocation_index) thread: u32) {
    let sound = status.stop == 0u && atomicLoad(&status.fault) == NO_FAULT;
    workgroupBarrier();
    sum_plate_loads(thread, sound);
    if thread == 0u && !sound {
        status.stop = 1u;
    }
}

// Adds the forces of the sides of the domain to the sums of the batch, and counts the step.
fn count_step() {
    for (var side = 0u; side < BORDERS; side++) {
        let force = status.reaction[side][side / 2u];
        batch.sides[side] = grown(batch.sides[side], select(force, -force, side % 2u == 1u));
    }
    batch.count += 1u;
}

// Stores the sums over the contacts of the loading plate `k`.
fn store_plate_load(k: u32, sums: vec4<f32>) {
    var p = batch.plates[k];
    p.work = grown(p.work, 0.5 * (p.reaction + sums.x) * p.moved);
    p.moved = 0.0;
    p.reaction = sums.x;
    p.stiffness = sums.y;
    p.stored = sums.z;
    p.rate = sums.w;
    p.overlap = 0.0;
    if p.reaction > 0.0 {
        p.overlap = p.stored / (0.4 * p.reaction);
    }
    p.ways = grown(p.ways, p.way);
    p.overlaps = grown(p.overlaps, p.overlap);
    p.reactions = grown(p.reactions, p.reaction);
    batch.plates[k] = p;
}

// Value of a ramp at a time since the start of the batch, s.
fn ramp(d: PlateDrive, time: f32) -> f32 {
    let value = d.value + d.slope * time;
    if d.slope > 0.0 {
        return min(value, d.end);
    }
    if d.slope < 0.0 {
        return max(value, d.end);
    }
    return d.value;
}

// The time step for a part of the system with the step `dt` by itself, where contacts add `contacts`, 1/s², to the square of its largest frequency.
fn with_contacts(dt: f32, contacts: f32) -> f32 {
    let twice = 2.0 * params.safety;
    let own = twice / dt;
    return twice / sqrt(own * own + contacts);
}

// Begins the first step of a batch.
@compute @workgroup_size(1)
fn drive() {
    drive_plates();
}

// Begins a step, if the batch has another one: its length, and the displacements of the loading plates in it.
fn drive_plates() {
    if status.stop != 0u || batch.count >= params.steps {
        return;
    }
    var rate = 0.0;
    var extents = params.extents;
    for (var k = 0u; k < params.plates; k++) {
        let p = batch.plates[k];
        rate = max(rate, p.rate);
        let wider = params.overlaps * p.overlap - params.follows * p.way;
        if p.shell == 0u {
            extents[p.axis] += wider;
        } else {
            extents += vec3<f32>(2.0 * wider, 2.0 * wider, 0.0);
        }
    }
    let dt = longest_step(params.dt, rate);
    batch.dt = dt;
    for (var k = 0u; k < params.plates; k++) {
        var p = batch.plates[k];
        let d = params.drives[k];
        let value = ramp(d, batch.time.x);
        p.speed = value;
        if d.kind == 1u {
            let others = select(extents, vec3<f32>(1.0), vec3<u32>(0u, 1u, 2u) == vec3<u32>(p.axis));
            let force = value * (others.x * others.y * others.z * p.face);
            let limit = d.reach * extents[p.axis];
            // as servo_speed in boundary.rs
            var servo = limit;
            // force and stiffness of the grains on the plate
            let other = plate_load_of_grains(k);
            if p.stiffness + other.y > 0.0 {
                servo = clamp(d.gain * (force - (p.reaction + other.x)) / ((p.stiffness + other.y) * dt), -limit, limit);
            }
            p.speed = clamp(p.drift + servo, -limit, limit);
            p.drift += min(dt * d.memory, 1.0) * (p.speed - p.drift);
        }
        p.moved = p.speed * dt;
        p.way += p.moved;
        let by = clamp(p.normal * p.moved * params.inverse_cell, -1.0, 1.0);
        let there = moved(vec3<i32>(p.units, 0, 0), vec3<f32>(p.rest, 0.0, 0.0), vec3<f32>(by, 0.0, 0.0));
        p.units = there.units.x;
        p.rest = there.rest.x;
        p.cell += there.shift.x;
        batch.plates[k] = p;
    }
}
