// Grains: their contacts with each other, with walls and with points, and their motion. Twins (f64): contact/sweep.rs, contact/wall_sweep.rs, dem/gather.rs,
// coupling/mixture.rs.

// The functions of the continuum's passes that depend on grains; without_grains.wgsl has those for continua without grains.

// Keeps the transport velocity of a point, m/s, and the largest stiffness over mass, 1/s², there and where forces act beside it. `stiffness_rate`: that at the point;
// `o`: offset of the point; `base`: its first node.
fn keep_transport_velocity(i: u32, o: vec3<f32>, base: vec3<i32>, v: vec3<f32>, stiffness_rate: f32) {
    let r = transport[i].w;
    transport[i] = vec4<u32>(bitcast<vec3<u32>>(v), r);
    let most = bitcast<u32>(max(stiffness_rate, rate_beside(r, o, base)));
    if most > atomicLoad(&mix_.largest_bound) {
        atomicMax(&mix_.largest_bound, most);
    }
    let speed = bitcast<u32>(length(v));
    if speed > atomicLoad(&mix_.fastest_point) {
        atomicMax(&mix_.fastest_point, speed);
    }
}

// Force and stiffness of the grains on the loading plate `k`.
fn plate_load_of_grains(k: u32) -> vec2<f32> {
    var sum = vec2<f32>(0.0);
    for (var w = 0u; w < coupling.walls; w++) {
        if mix_.sides[w].plate == k {
            sum += vec2<f32>(mix_.sides[w].reaction, mix_.sides[w].stiffness);
        }
    }
    return sum;
}

// ContactRates::END_SHARES in point_contacts.rs
const OF_POINT: f32 = 3.0;
const OF_GRAIN: f32 = 1.5;

// Length of the next step of the continuum, s; `dt`: that for waves alone, s; `rate`: largest stiffness of loading plates over mass of a point, 1/s² (coupling/mixture.rs).
fn longest_step(dt: f32, rate: f32) -> f32 {
    mix_.isolated_bound = OF_POINT * bitcast<f32>(atomicLoad(&mix_.point_rate)) + rate;
    if params.safety <= 0.0 {
        return dt;
    }
    var contacts = bitcast<f32>(atomicLoad(&mix_.point_rate)) + mix_.grain_rate_points + rate;
    if mix_.slow != 0u {
        contacts = max(mix_.bound_ratio * mix_.isolated_bound, OF_GRAIN * mix_.grain_rate_points);
    }
    var own = coupling.least;
    if mix_.grain_rate > 0.0 {
        own = min(own, params.safety * 2.0 / sqrt(mix_.grain_rate));
    }
    return min(with_contacts(own, contacts) * f32(coupling.rates), with_contacts(dt, contacts));
}

fn side_speed(side: Side) -> f32 {
    if side.plate == NONE {
        return side.speed;
    }
    return batch.plates[side.plate].speed;
}

// Geometry of a sphere on a wall; the normal points into the wall.
fn on_side(side: Side, cell: vec3<i32>, units: vec3<i32>, rest: vec3<f32>, whole: i32, part: f32) -> ContactGeometry {
    if SHELLS {
        if side.shell != 0u {
            return on_shell(side, cell.xy, units.xy, rest.xy, whole, part);
        }
    }
    let axis = side.axis;
    let normal = i32(side.normal);
    let across = unit(axis) * -side.normal;
    let cells = normal * (cell[axis] - side.cell);
    if abs(cells) >= coupling.far {
        return ContactGeometry(0.0, across);
    }
    let d = length_of(vec3<i32>(cells, 0, 0), vec3<i32>(normal * (units[axis] - side.units), 0, 0), vec3<f32>(side.normal * (rest[axis] - side.rest), 0.0, 0.0));
    return ContactGeometry((f32(whole - d.whole.x) + (part - d.part.x)) * coupling.quantum, across);
}

// Of a sphere in a shell, as touch_of_shell in loading_plates.wgsl.
fn on_shell(side: Side, cell: vec2<i32>, units: vec2<i32>, rest: vec2<f32>, whole: i32, part: f32) -> ContactGeometry {
    let cells = cell - side.centre_cell;
    if any(abs(cells) >= vec2<i32>(i32(16384u >> side.split))) {
        return ContactGeometry(0.0, vec3<f32>(0.0));
    }
    let between = units - side.centre_units;
    let x = quanta(cells.x, between.x, rest.x - side.centre_rest.x, side.split);
    let y = quanta(cells.y, between.y, rest.y - side.centre_rest.y, side.split);
    // the shell's radius less that of the sphere, which is in quanta of its own
    let bits = 30u - coupling.split;
    let left = whole & ((1i << coupling.split) - 1);
    let inner = quanta(side.cell + 1 - (whole >> coupling.split), side.units - (left << bits), side.rest - part * f32(1u << bits), side.split);
    let at = vec2<f32>(x.x + x.y, y.x + y.y);
    let overlap = overlap_with_shell(x, y, inner, vec2<f32>(0.0)) * (params.cell / f32(1u << side.split));
    return ContactGeometry(overlap, vec3<f32>(at / max(length(at), 1e-37), 0.0));
}

// Height of a place over a wall, cells, for the search. `at`: coordinates in cells.
fn height_over(side: Side, at: vec3<f32>) -> f32 {
    let wall = f32(side.cell) + f32(side.units) / UNITS;
    if side.shell != 0u {
        return (wall + 1.0) - length(at.xy - (vec2<f32>(side.centre_cell) + vec2<f32>(side.centre_units) / UNITS));
    }
    return side.normal * (at[side.axis] - wall);
}

// Local damping −α |f| sign(v) of each component.
fn damped(f: vec3<f32>, v: vec3<f32>) -> vec3<f32> {
    return f - coupling.damping * abs(f) * sign(v);
}

// Moves the grains between two of their steps in a step of the continuum; the last of these is in `accelerate`.
@compute @workgroup_size(GROUP)
fn move_grains(one: Thread) {
    move_grain(linear(one));
}

// Moves a grain by one of its steps: velocity, spin, position.
fn move_grain(g: u32) {
    if g >= coupling.grains || status.stop != 0u {
        return;
    }
    let dt = batch.dt / f32(coupling.rates);
    let kick = dt * select(1.0, 0.5, mix_.fresh != 0u);
    let v = grain_number(G_VELOCITY, g);
    let v_low = grain_number(G_VELOCITY_LOW, g);
    let w = grain_number(G_SPIN, g);
    let w_low = grain_number(G_SPIN_LOW, g);
    let radius = v_low.w;
    let force = damped(grain_number(G_FORCE, g).xyz + v.w * params.gravity, v.xyz);
    let next = add(vec4<f32>(v.xyz, 0.0), vec4<f32>(v_low.xyz, 0.0), vec4<f32>(force * (kick / v.w), 0.0));
    let torque = damped(grain_number(G_TORQUE, g).xyz, w.xyz);
    // I = 2/5 m r²
    let turn = select(0.0, 2.5 * kick / (v.w * radius * radius), coupling.turning != 0u);
    let spin = add(vec4<f32>(w.xyz, 0.0), vec4<f32>(w_low.xyz, 0.0), vec4<f32>(torque * turn, 0.0));
    let speed = length(next.high.xyz);
    let by = (next.high.xyz + next.low.xyz) * (dt * params.inverse_cell);
    if not_finite(speed) || max(abs(by.x), max(abs(by.y), abs(by.z))) >= 1.0 {
        atomicMin(&mix_.lost, g);
        return;
    }
    let own = grain_word(G_UNITS, g);
    let cell = grain_word(G_CELL, g);
    let rest = grain_number(G_REST, g);
    let there = moved(bitcast<vec3<i32>>(own.xyz), rest.xyz, by);
    grains[G_UNITS * coupling.grains + g] = vec4<u32>(bitcast<vec3<u32>>(there.units), own.w);
    grains[G_CELL * coupling.grains + g] = vec4<u32>(bitcast<vec3<u32>>(bitcast<vec3<i32>>(cell.xyz) + there.shift), cell.w);
    put_grain(G_REST, g, vec4<f32>(there.rest, rest.w));
    put_grain(G_VELOCITY, g, vec4<f32>(next.high.xyz, v.w));
    put_grain(G_VELOCITY_LOW, g, vec4<f32>(next.low.xyz, radius));
    put_grain(G_SPIN, g, vec4<f32>(spin.high.xyz, w.w));
    grains[G_SPIN_LOW * coupling.grains + g] = vec4<u32>(bitcast<vec3<u32>>(spin.low.xyz), grain_word(G_SPIN_LOW, g).w);
    atomicMax(&mix_.fastest_grain, bitcast<u32>(speed));
}

var<workgroup> wanted: u32;

// Share of the skin that may be used up before lists are made anew. Not all of it, as the positions of points ahead of their time are estimates.
const TRUST: f32 = 0.5;

// Between two steps of the grains in a step of the continuum, and before the first one.
@compute @workgroup_size(WIDE)
fn build_grid(@builtin(local_invocation_index) thread: u32) {
    end_step(thread);
}

// After each step of the grains: advances time and walls and, where a body may have come closer than the skin allows, sorts the grains into the grid.
fn end_step(thread: u32) {
    if thread == 0u {
        wanted = 0u;
        if status.stop == 0u {
            wanted = advance_time();
        }
        mix_.wanted = wanted;
    }
    if workgroupUniformLoad(&wanted) == 0u {
        return;
    }
    let counts_at = coupling.grid_cells + 1u;
    for (var c = thread; c < coupling.grid_cells; c += WIDE) {
        atomicStore(&lists[counts_at + c], 0u);
    }
    storageBarrier();
    for (var g = thread; g < coupling.grains; g += WIDE) {
        atomicAdd(&lists[counts_at + grid_index(grid_cell_of(grain_cells(g)))], 1u);
    }
    storageBarrier();
    let share = (coupling.grid_cells + WIDE - 1u) / WIDE;
    let begin = min(thread * share, coupling.grid_cells);
    let end = min((thread + 1u) * share, coupling.grid_cells);
    var own = 0u;
    for (var c = begin; c < end; c++) {
        own += atomicLoad(&lists[counts_at + c]);
    }
    var first = before(thread, own);
    for (var c = begin; c < end; c++) {
        let here = atomicLoad(&lists[counts_at + c]);
        atomicStore(&lists[c], first);
        atomicStore(&lists[counts_at + c], first);
        first += here;
    }
    if thread == 0u {
        atomicStore(&lists[coupling.grid_cells], coupling.grains);
    }
    storageBarrier();
    for (var g = thread; g < coupling.grains; g += WIDE) {
        let at = atomicAdd(&lists[counts_at + grid_index(grid_cell_of(grain_cells(g)))], 1u);
        atomicStore(&lists[2u * coupling.grid_cells + 1u + at], g);
    }
}

// Advances time and walls by one step of the grains; returns 1 where lists of candidates must be made anew.
fn advance_time() -> u32 {
    atomicStore(&mix_.point_rate, 0u);
    if mix_.search != 0u {
        mix_.search = 0u;
        mix_.travelled = 0.0;
        return 1u;
    }
    let dt = batch.dt / f32(coupling.rates);
    mix_.fresh = 0u;
    mix_.sub = (mix_.sub + 1u) % coupling.rates;
    mix_.ahead = f32(mix_.sub) * dt;
    if mix_.sub == 0u {
        mix_.point_speed = bitcast<f32>(atomicExchange(&mix_.fastest_point, 0u));
        let most = bitcast<f32>(atomicExchange(&mix_.largest_bound, 0u));
        mix_.bound_ratio = 1.0;
        if mix_.isolated_bound > 0.0 {
            mix_.bound_ratio = most / mix_.isolated_bound;
        }
    }
    var fastest = bitcast<f32>(atomicExchange(&mix_.fastest_grain, 0u));
    for (var k = 0u; k < coupling.walls; k++) {
        let side = mix_.sides[k];
        let speed = side_speed(side);
        fastest = max(fastest, abs(speed));
        let by = clamp(side.normal * speed * dt * params.inverse_cell, -1.0, 1.0);
        let there = moved(vec3<i32>(side.units, 0, 0), vec3<f32>(side.rest, 0.0, 0.0), vec3<f32>(by, 0.0, 0.0));
        mix_.sides[k].speed = speed;
        mix_.sides[k].units = there.units.x;
        mix_.sides[k].rest = there.rest.x;
        mix_.sides[k].cell = side.cell + there.shift.x;
    }
    mix_.travelled += dt * (mix_.point_speed + fastest);
    if mix_.travelled <= TRUST * coupling.skin * params.cell {
        return 0u;
    }
    mix_.travelled = 0.0;
    return 1u;
}

// Moves a contact of grain g to another slot.
fn move_slot(old: u32, to: u32, g: u32) {
    for (var plane = 0u; plane < 4u; plane++) {
        slots[slot_at(plane, to, g)] = slots[slot_at(plane, old, g)];
    }
}

// Makes the lists of candidates of all points and grains anew, where they are wanted.
@compute @workgroup_size(GROUP)
fn candidates(one: Thread) {
    let i = linear(one);
    if mix_.wanted == 0u || status.stop != 0u {
        return;
    }
    if i < params.points {
        point_candidates(i);
    } else if i - params.points < coupling.grains {
        grain_candidates(i - params.points);
    }
}

// Makes the list of candidates of a grain anew, as point_candidates does for a point.
fn grain_candidates(g: u32) {
    let at = grain_cells(g);
    let radius = grain_number(G_VELOCITY_LOW, g).w * params.inverse_cell;
    var found: array<u32, PARTNERS>;
    var n = 0u;
    var count = 0u;
    let here = grid_cell_of(at);
    for (var k = 0; k < 27; k++) {
        let there = here + vec3<i32>(k % 3, (k / 3) % 3, k / 9) - 1;
        if any(there < vec3<i32>(0)) || any(there >= coupling.grid) {
            continue;
        }
        let grid_cell = grid_index(there);
        let end = grid_start(grid_cell + 1u);
        for (var entry = grid_start(grid_cell); entry < end; entry++) {
            let other = grain_in_cell(entry);
            let d = grain_cells(other) - at;
            let far = grain_number(G_VELOCITY_LOW, other).w * params.inverse_cell + radius + coupling.skin;
            if other == g || dot(d, d) >= far * far {
                continue;
            }
            count += 1u;
            if n < PARTNERS {
                var place = n;
                while place > 0u && found[place - 1u] > other {
                    found[place] = found[place - 1u];
                    place -= 1u;
                }
                found[place] = other;
                n += 1u;
            }
        }
    }
    if count > PARTNERS {
        atomicMin(&mix_.crowded, g);
        return;
    }
    var kept = 0u;
    for (var s = 0u; s < PARTNERS; s++) {
        if slots[slot_at(C_SPRING, s, g)].w == NONE {
            break;
        }
        if bitcast<f32>(slots[slot_at(C_TANGENT, s, g)].w) > 0.0 {
            if kept != s {
                move_slot(s, kept, g);
            }
            kept += 1u;
        }
    }
    for (var s = n; s > 0u; s--) {
        let to = s - 1u;
        while kept > 0u && slots[slot_at(C_SPRING, kept - 1u, g)].w > found[to] {
            kept -= 1u;
        }
        if kept > 0u && slots[slot_at(C_SPRING, kept - 1u, g)].w == found[to] {
            kept -= 1u;
            if kept != to {
                move_slot(kept, to, g);
            }
        } else {
            slots[slot_at(C_SPRING, to, g)] = vec4<u32>(0u, 0u, 0u, found[to]);
            for (var plane = 1u; plane < 4u; plane++) {
                slots[slot_at(plane, to, g)] = vec4<u32>(0u);
            }
        }
    }
    for (var s = n; s < PARTNERS; s++) {
        slots[slot_at(C_SPRING, s, g)].w = NONE;
    }
}

// The contact of grain `g` in slot `s`. Of two grains the one with the lower index is the first end, so that both compute the same numbers.
fn evaluated(g: u32, s: u32, body: u32, pair: Pair, spring: vec3<f32>, low: vec3<f32>) -> Contact {
    var m: ContactGeometry;
    var motion: RelativeMotion;
    var r_eff: f32;
    var m_eff: f32;
    let dt = batch.dt / f32(coupling.rates);
    if body >= WALLS {
        let side = mix_.sides[body - WALLS];
        let cell = grain_word(G_CELL, g);
        let rest = grain_number(G_REST, g);
        m = on_side(side, bitcast<vec3<i32>>(cell.xyz), bitcast<vec3<i32>>(grain_word(G_UNITS, g).xyz), rest.xyz, bitcast<i32>(cell.w), rest.w);
        let v = grain_number(G_VELOCITY, g);
        let v_low = grain_number(G_VELOCITY_LOW, g);
        let spin = grain_number(G_SPIN, g).xyz;
        motion = RelativeMotion(v.xyz + (v_low.xyz + m.normal * side_speed(side)), spin * v_low.w, spin);
        r_eff = v_low.w;
        m_eff = v.w;
    } else {
        let i = min(g, body);
        let j = max(g, body);
        let p = grain_word(G_CELL, i);
        let q = grain_word(G_CELL, j);
        let apart = bitcast<vec3<i32>>(q.xyz) - bitcast<vec3<i32>>(p.xyz);
        if any(abs(apart) >= vec3<i32>(coupling.far)) {
            return no_contact();
        }
        let units = bitcast<vec3<i32>>(grain_word(G_UNITS, j).xyz) - bitcast<vec3<i32>>(grain_word(G_UNITS, i).xyz);
        let rest = grain_number(G_REST, j) - grain_number(G_REST, i);
        m = spheres_geometry(length_of(apart, units, rest.xyz), bitcast<i32>(p.w) + bitcast<i32>(q.w), grain_number(G_REST, i).w + grain_number(G_REST, j).w);
        let v = grain_number(G_VELOCITY, i);
        let u = grain_number(G_VELOCITY, j);
        let v_low = grain_number(G_VELOCITY_LOW, i);
        let u_low = grain_number(G_VELOCITY_LOW, j);
        let w = grain_number(G_SPIN, i).xyz;
        let x = grain_number(G_SPIN, j).xyz;
        motion = RelativeMotion((v.xyz - u.xyz) + (v_low.xyz - u_low.xyz), w * v_low.w + x * u_low.w, 0.5 * (w + x));
        r_eff = v_low.w * u_low.w / (v_low.w + u_low.w);
        m_eff = v.w * u.w / (v.w + u.w);
    }
    if m.overlap <= 0.0 {
        return no_contact();
    }
    return contact_force(m, r_eff, m_eff, motion, pair, dt, spring, low);
}

// Sums of the threads of a workgroup over contacts with points; force and torque of each contact with a grain or wall.
var<workgroup> forces: array<vec4<f32>, GROUP>;
var<workgroup> torques: array<vec4<f32>, GROUP>;
var<workgroup> slot_forces: array<vec4<f32>, SLOTS>;
var<workgroup> slot_torques: array<vec4<f32>, SLOTS>;

// Force and torque on each grain, in one workgroup for each grain: one thread for each contact with grains and walls; then all threads over the points in the cells
// around the grain.
@compute @workgroup_size(GROUP)
fn grain_forces(
    @builtin(workgroup_id) group: vec3<u32>,
    @builtin(num_workgroups) groups: vec3<u32>,
    @builtin(local_invocation_index) thread: u32,
) {
    let g = group.x + group.y * groups.x;
    if g >= coupling.grains {
        return;
    }
    let radius = grain_number(G_VELOCITY_LOW, g).w;
    let mass = grain_number(G_VELOCITY, g).w;
    let goes = status.stop == 0u;
    if thread < SLOTS {
        var body = slots[slot_at(C_SPRING, thread, g)].w;
        if thread >= PARTNERS {
            body = select(NONE, WALLS + thread - PARTNERS, thread - PARTNERS < coupling.walls);
        }
        var force = vec4<f32>(0.0);
        var torque = vec4<f32>(0.0);
        if body != NONE && goes {
            let material = grain_word(G_UNITS, g).w;
            var at: u32;
            if body >= WALLS {
                at = coupling.tables.y + 2u * ((body - WALLS) * coupling.materials + material);
            } else {
                at = 2u * (grain_word(G_UNITS, min(g, body)).w * coupling.materials + grain_word(G_UNITS, max(g, body)).w);
            }
            let pair = pair_at(at);
            let head = bitcast<vec4<f32>>(slots[slot_at(C_SPRING, thread, g)]);
            let low = bitcast<vec4<f32>>(slots[slot_at(C_LOW, thread, g)]);
            var c = no_contact();
            if mix_.contacts_known != 0u {
                let normal = bitcast<vec4<f32>>(slots[slot_at(C_NORMAL, thread, g)]);
                let tangent = bitcast<vec4<f32>>(slots[slot_at(C_TANGENT, thread, g)]);
                c.normal = normal.xyz;
                c.force = normal.w;
                c.tangent = tangent.xyz;
                c.overlap = tangent.w;
                c.stiffness = low.w;
            } else {
                c = evaluated(g, thread, body, pair, head.xyz, low.xyz);
                slots[slot_at(C_SPRING, thread, g)] = vec4<u32>(bitcast<vec3<u32>>(c.spring), body);
                slots[slot_at(C_NORMAL, thread, g)] = bitcast<vec4<u32>>(vec4<f32>(c.normal, c.force));
                slots[slot_at(C_TANGENT, thread, g)] = bitcast<vec4<u32>>(vec4<f32>(c.tangent, c.overlap));
                slots[slot_at(C_LOW, thread, g)] = bitcast<vec4<u32>>(vec4<f32>(c.low, c.stiffness));
            }
            if c.overlap > 0.0 {
                let first = select(-1.0, 1.0, g < body);
                let arm = radius - c.overlap * select(0.5, 1.0, body >= WALLS);
                force = vec4<f32>(first * (c.tangent - c.normal * c.force), c.stiffness * max(2.0, 7.0 * stiffness_ratio(pair)));
                var load = c.force;
                if coupling.hertz_area != 0u {
                    var r_eff = radius;
                    if body < WALLS {
                        let other = grain_number(G_VELOCITY_LOW, body).w;
                        r_eff = radius * other / (radius + other);
                    }
                    let weight = tables[at + 1u].x / r_eff;
                    load *= weight * weight;
                }
                torque = vec4<f32>(arm * cross(c.normal, c.tangent), load);
            }
        }
        slot_forces[thread] = force;
        slot_torques[thread] = torque;
    }
    // the cells with points that can touch the grain
    let around = grain_cells(g) + 0.5;
    let far = vec3<f32>(radius * params.inverse_cell + coupling.reach + bitcast<f32>(atomicLoad(&mix_.furthest)) + coupling.skin);
    let n = cell_size();
    let low = clamp(vec3<i32>(floor(around - far)) + 1, vec3<i32>(0), n - 1);
    let high = clamp(vec3<i32>(floor(around + far)) + 1, vec3<i32>(-1), n - 1);
    let wide = max(high - low + 1, vec3<i32>(0));
    var force = vec4<f32>(0.0);
    var torque = vec4<f32>(0.0);
    if goes {
        for (var c = i32(thread); c < wide.x * wide.y * wide.z; c += i32(GROUP)) {
            let at = low + vec3<i32>(c % wide.x, (c / wide.x) % wide.y, c / (wide.x * wide.y));
            let cell = cell_index(at);
            let end = starts[cell + 1u];
            for (var p = starts[cell]; p < end; p++) {
                let i = nth(p);
                let r = transport[i].w;
                if r == NONE {
                    continue;
                }
                for (var s = 0u; s < ROW_PLACES; s++) {
                    let body = rows[row_at(C_SPRING, s, r)].w;
                    if body > g {
                        break;
                    }
                    let tangent = bitcast<vec4<f32>>(rows[row_at(C_TANGENT, s, r)]);
                    if body != g || tangent.w <= 0.0 {
                        continue;
                    }
                    let normal = bitcast<vec4<f32>>(rows[row_at(C_NORMAL, s, r)]);
                    let law = word(VELOCITY_LOW, i).w;
                    let pair = pair_at(coupling.tables.x + 2u * (law * coupling.materials + grain_word(G_UNITS, g).w));
                    let stiffness = bitcast<f32>(rows[row_at(C_LOW, s, r)].w);
                    force += vec4<f32>(tangent.xyz - normal.xyz * normal.w, stiffness * max(1.0, 3.5 * stiffness_ratio(pair)));
                    torque += vec4<f32>((radius - 0.5 * tangent.w) * cross(normal.xyz, tangent.xyz), 0.0);
                }
            }
        }
    }
    forces[thread] = force;
    torques[thread] = torque;
    workgroupBarrier();
    for (var half = GROUP / 2u; half > 0u; half /= 2u) {
        if thread < half {
            forces[thread] += forces[thread + half];
            torques[thread] += torques[thread + half];
        }
        workgroupBarrier();
    }
    if thread != 0u || !goes {
        return;
    }
    force = forces[0];
    torque = torques[0];
    let rate_points = force.w / mass;
    force.w = 0.0;
    var load = 0.0;
    for (var s = 0u; s < SLOTS; s++) {
        force += slot_forces[s];
        torque += vec4<f32>(slot_torques[s].xyz, 0.0);
        load = max(load, slot_torques[s].w);
    }
    put_grain(G_FORCE, g, vec4<f32>(force.xyz, force.w / mass));
    put_grain(G_TORQUE, g, vec4<f32>(torque.xyz, rate_points));
    if coupling.crushing != 0u && load > grain_number(G_SPIN, g).w {
        atomicMin(&mix_.broken, g);
    }
}

// Factor on the stiffness of contacts, which grows until the bound is computed again (dem/stability.rs).
const MARGIN: f32 = 1.2;

// Reactions of the walls, bounds on the time step, whether the batch must end, and the beginning of the next step of the continuum.
@compute @workgroup_size(WIDE)
fn step_bound(@builtin(local_invocation_index) thread: u32) {
    var most = vec2<f32>(0.0);
    for (var g = thread; g < coupling.grains; g += WIDE) {
        most = max(most, vec2<f32>(grain_number(G_FORCE, g).w, grain_number(G_TORQUE, g).w));
    }
    partial_sums[thread] = vec4<f32>(most, 0.0, 0.0);
    workgroupBarrier();
    for (var half = WIDE / 2u; half > 0u; half /= 2u) {
        if thread < half {
            partial_sums[thread] = max(partial_sums[thread], partial_sums[thread + half]);
        }
        workgroupBarrier();
    }
    let bounds = partial_sums[0];
    workgroupBarrier();
    for (var k = 0u; k < coupling.walls; k++) {
        var own = vec4<f32>(0.0);
        for (var g = thread; g < coupling.grains; g += WIDE) {
            let s = PARTNERS + k;
            own += vec4<f32>(bitcast<f32>(slots[slot_at(C_NORMAL, s, g)].w), bitcast<f32>(slots[slot_at(C_LOW, s, g)].w), 0.0, 0.0);
        }
        let sum = plain_total(thread, own);
        if thread == 0u && status.stop == 0u {
            store_reaction(k, sum.x, sum.y);
        }
        workgroupBarrier();
    }
    if thread != 0u || status.stop != 0u {
        return;
    }
    mix_.grain_rate = (1.0 + coupling.damping) * MARGIN * bounds.x;
    mix_.grain_rate_points = bounds.y;
    let over = coupling.crushing != 0u && atomicLoad(&mix_.broken) != NONE;
    if over || atomicLoad(&mix_.lost) != NONE || atomicLoad(&mix_.crowded) != NONE || atomicLoad(&status.fault) != NO_FAULT {
        status.stop = 1u;
    }
    mix_.contacts_known = 0u;
    // the last step of the grains in one of the continuum
    if mix_.sub == 0u {
        drive_plates();
    }
}

// Stores the sums over the contacts of the wall `k`, and adds to its work.
fn store_reaction(k: u32, reaction: f32, stiffness: f32) {
    let side = mix_.sides[k];
    if mix_.contacts_known == 0u {
        let way = side.speed * (batch.dt / f32(coupling.rates));
        mix_.sides[k].work = grown(side.work, 0.5 * (side.reaction + reaction) * way);
        if mix_.sub == 0u {
            mix_.reactions[k] = grown(mix_.reactions[k], reaction);
        }
    }
    mix_.sides[k].reaction = reaction;
    mix_.sides[k].stiffness = stiffness;
}
