// Rigid planes along the axes that press on the points' ghost spheres (Li et al. 2023, eqs 18, 20, 22) with a traction on the points' faces.
// Twin: mpm/platen.rs (f64), which says what is done and why.

struct Platen {
    axis: u32,
    // of the normal, towards the material
    normal: f32,
    // place along the axis, as a point's
    cell: i32,
    units: i32,
    rest: f32,
    modulus: f32,
    speed: f32,
    // since the last contact
    moved: f32,
    reaction: f32,
    stiffness: f32,
    stored: f32,
    rate: f32,
    work: f32,
    work_low: f32,
    unused_a: f32,
    unused_b: f32,
}

struct Outside {
    platens: array<Platen, 6>,
    // force on each point; how far beside it along each axis it acts, cells; then sums of groups of points for each platen
    parts: array<vec4<f32>>,
}

@group(0) @binding(9) var<storage, read_write> outside: Outside;

const PASSED: u32 = 5u;

var<workgroup> pressing: array<vec4<f32>, 256>;

fn cube_root(x: f32) -> f32 {
    let y = exp2(log2(x) * 0.33333333);
    // a Newton step, as the device's logarithm need not be good
    return y - (y * y * y - x) / (3.0 * y * y);
}

fn summed(a: vec4<f32>, b: vec4<f32>) -> vec4<f32> {
    return vec4<f32>(a.xyz + b.xyz, max(a.w, b.w));
}

// Force of every platen on each point; sums of reaction, tangent stiffness, stored energy, and the largest stiffness over mass.
@compute @workgroup_size(64)
fn press(
    @builtin(global_invocation_id) id: vec3<u32>,
    @builtin(num_workgroups) groups: vec3<u32>,
    @builtin(workgroup_id) group: vec3<u32>,
    @builtin(local_invocation_index) thread: u32,
) {
    let i = linear(id, groups);
    var force = vec3<f32>(0.0);
    var moment = vec3<f32>(0.0);
    for (var k = 0u; k < params.platens; k++) {
        var own = vec4<f32>(0.0);
        if i < params.points {
            let place = word(PLACE, i);
            let platen = outside.platens[k];
            let axis = platen.axis;
            // in units as long as can be: overlaps are small differences
            let normal = i32(platen.normal);
            let cells = normal * (cell_place(place.w)[axis] - 1 - platen.cell);
            let units = normal * (bitcast<vec3<i32>>(place.xyz)[axis] - platen.units);
            let radius_units = bitcast<i32>(word(ENERGY, i).w);
            let deep = f32(radius_units - cells * WIDTH - units) - platen.normal * (number(REST, i)[axis] - platen.rest);
            let scale = params.cell / UNITS;
            let radius = f32(radius_units) * scale;
            // further than two cells is out of reach, or far beyond
            let overlap = select(select(deep * scale, 2.0 * params.cell, cells < -1), 0.0, cells > 1);
            if overlap > radius {
                atomicMin(&status.fault, 8u * word(ENERGY, i).z + PASSED);
            } else if overlap > 0.0 {
                let tangent = 2.0 * platen.modulus * sqrt(radius * overlap);
                let f = 0.66666667 * tangent * overlap;
                own = vec4<f32>(f, tangent, 0.4 * f * overlap, tangent / number(VELOCITY, i).w);
                let half = 0.5 * cube_root(number(REST, i).w * (1.0 + number(NORMAL, i).w));
                force[axis] += platen.normal * f;
                moment[axis] -= f * half;
            }
        }
        pressing[thread] = own;
        workgroupBarrier();
        for (var half = 32u; half > 0u; half /= 2u) {
            if thread < half {
                pressing[thread] = summed(pressing[thread], pressing[thread + half]);
            }
            workgroupBarrier();
        }
        if thread == 0u {
            outside.parts[2u * params.points + (group.x + group.y * groups.x) * 6u + k] = pressing[0];
        }
        workgroupBarrier();
    }
    if i < params.points {
        let acts = force != vec3<f32>(0.0);
        let arm = select(vec3<f32>(0.0), moment / select(vec3<f32>(1.0), force, acts), acts) * params.inverse_cell;
        outside.parts[i] = vec4<f32>(force, 0.0);
        outside.parts[params.points + i] = vec4<f32>(arm, 0.0);
    }
}

// What each platen feels, its work, its speed, and its way in this step.
@compute @workgroup_size(256)
fn drive(@builtin(local_invocation_index) thread: u32) {
    let count = params.point_groups.x * params.point_groups.y;
    for (var k = 0u; k < params.platens; k++) {
        var own = vec4<f32>(0.0);
        for (var g = thread; g < count; g += 256u) {
            own = summed(own, outside.parts[2u * params.points + g * 6u + k]);
        }
        pressing[thread] = own;
        workgroupBarrier();
        for (var half = 128u; half > 0u; half /= 2u) {
            if thread < half {
                pressing[thread] = summed(pressing[thread], pressing[thread + half]);
            }
            workgroupBarrier();
        }
        if thread == 0u && status.stop == 0u && atomicLoad(&status.fault) == 0xffffffffu {
            var p = outside.platens[k];
            let felt = pressing[0];
            let done = 0.5 * (p.reaction + felt.x) * p.moved;
            let sum = add(vec4<f32>(p.work, 0.0, 0.0, 0.0), vec4<f32>(p.work_low, 0.0, 0.0, 0.0), vec4<f32>(done, 0.0, 0.0, 0.0));
            p.work = sum.high.x;
            p.work_low = sum.low.x;
            p.reaction = felt.x;
            p.stiffness = felt.y;
            p.stored = felt.z;
            p.rate = felt.w;
            let d = params.drives[k];
            p.speed = d.value;
            if d.kind == 1u {
                // boundary.rs: servo_speed
                p.speed = d.limit;
                if p.stiffness > 0.0 {
                    p.speed = clamp(d.gain * (d.value - p.reaction) / (p.stiffness * params.dt), -d.limit, d.limit);
                }
            }
            p.moved = p.speed * params.dt;
            let by = clamp(p.normal * p.moved * params.inverse_cell, -1.0, 1.0);
            let there = moved(vec3<i32>(p.units, 0, 0), vec3<f32>(p.rest, 0.0, 0.0), vec3<f32>(by, 0.0, 0.0));
            p.units = there.units.x;
            p.rest = there.rest.x;
            p.cell += there.shift.x;
            outside.platens[k] = p;
        }
        workgroupBarrier();
    }
}
