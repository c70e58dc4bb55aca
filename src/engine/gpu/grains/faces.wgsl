// Faces of points: where grains and walls press on the points. Each contact has one; it moves with the nodes, and the force of the contact acts there. Twins (f64):
// GhostFace in point_contacts.rs, coupling/evaluate.rs, coupling/reactions.rs, velocity_beside in mpm/step.rs.

// GhostFace::FURTHEST, how far a face may be beyond the ghost of its point, cells; the grid for the search is made for it.
const FURTHEST: f32 = 1.0;

// Where the force of a contact acts, cells from the centre of the point: GhostFace::offset. `normal`: from the body to the point; `radius`: ghost radius, m; `beyond`:
// distance of the face beyond the ghost, cells.
fn face_place(normal: vec3<f32>, overlap: f32, radius: f32, beyond: f32) -> vec3<f32> {
    return normal * -clamp((radius - 0.5 * max(overlap, 0.0)) * params.inverse_cell + beyond, 0.0, 0.5);
}

// Linear weights of the node `d` (0, 1, 2 along each axis) at `at` cells from the middle node.
fn hats(d: vec3<i32>, at: vec3<f32>) -> vec3<f32> {
    return max(1.0 - abs(clamp(at, vec3<f32>(-1.0), vec3<f32>(1.0)) - vec3<f32>(d - 1)), vec3<f32>(0.0));
}

// A plane of the nodes at `at` cells from the middle node of a point, by linear weights. `base`: first node of the point.
fn gathered(plane: u32, base: vec3<i32>, at: vec3<f32>) -> vec4<f32> {
    let first = select(vec3<i32>(1), vec3<i32>(0), at < vec3<f32>(0.0));
    var sum = vec4<f32>(0.0);
    for (var k = 0; k < 8; k++) {
        let d = first + vec3<i32>(k & 1, (k >> 1u) & 1, k >> 2u);
        let w = hats(d, at);
        sum += nodes[plane * params.cells + node_index(base + d)] * (w.x * w.y * w.z);
    }
    return sum;
}

// Nothing has pressed on the point of row `r` so far in this step of the continuum.
fn clear_pushes(r: u32) {
    for (var k = 0u; k < NODES; k++) {
        rows[node_at(k, r)] = vec4<u32>(0u);
    }
}

// Adds a force on the point of row `r`, N, with its stiffness, N/m, to the nodes around `at`, cells from the middle node. Points keep their places while grains make
// several steps in one of the continuum, so each step's force arrives where it acts.
fn press(r: u32, at: vec3<f32>, push: vec4<f32>) {
    let first = select(vec3<i32>(1), vec3<i32>(0), at < vec3<f32>(0.0));
    for (var k = 0; k < 8; k++) {
        let d = first + vec3<i32>(k & 1, (k >> 1u) & 1, k >> 2u);
        let w = hats(d, at);
        let there = node_at(u32(d.x + 3 * (d.y + 3 * d.z)), r);
        rows[there] = bitcast<vec4<u32>>(bitcast<vec4<f32>>(rows[there]) + push * (w.x * w.y * w.z));
    }
}

// As press, for a force at the centre of a point, by its spline. `o`: offset of the point from the middle node.
fn press_centre(r: u32, o: vec3<f32>, push: vec4<f32>) {
    let x = spline(o.x);
    let y = spline(o.y);
    let z = spline(o.z);
    for (var k = 0; k < 27; k++) {
        let there = node_at(u32(k), r);
        let w = x[k % 3] * y[(k / 3) % 3] * z[k / 9];
        rows[there] = bitcast<vec4<u32>>(bitcast<vec4<f32>>(rows[there]) + push * w);
    }
}

// What contacts press on the node `d` of a point: force, N, mean over the steps of the grains, and its stiffness, N/m.
fn force_of_grains(i: u32, d: vec3<i32>) -> vec4<f32> {
    let r = transport[i].w;
    if r == NONE || rows[owner_at(r)].y == 0u {
        return vec4<f32>(0.0);
    }
    let sum = bitcast<vec4<f32>>(rows[node_at(u32(d.x + 3 * (d.y + 3 * d.z)), r)]);
    return vec4<f32>(sum.xyz / f32(coupling.rates), sum.w);
}

// Largest stiffness over mass, 1/s², where contacts press on the point of row `r`.
fn rate_beside(r: u32, o: vec3<f32>, base: vec3<i32>) -> f32 {
    var most = 0.0;
    if r == NONE {
        return most;
    }
    for (var s = 0u; s < ROW_PLACES; s++) {
        if rows[row_at(C_SPRING, s, r)].w == NONE {
            break;
        }
        let place = bitcast<vec3<f32>>(rows[row_at(C_PLACE, s, r)].xyz);
        if place.x < NO_PLACE {
            most = max(most, gathered(CHANGE, base, o + place).w);
        }
    }
    return most;
}

// Moves the faces of a point with the nodes, at the end of a step of the continuum.
fn follow_faces(i: u32, o: vec3<f32>, base: vec3<i32>) {
    let r = transport[i].w;
    if !FACES || r == NONE {
        return;
    }
    let radius = f32(radius_in_units(i)) * (params.cell / UNITS);
    for (var s = 0u; s < ROW_PLACES; s++) {
        if rows[row_at(C_SPRING, s, r)].w == NONE {
            break;
        }
        let overlap = bitcast<f32>(rows[row_at(C_TANGENT, s, r)].w);
        if overlap <= NO_FACE {
            continue;
        }
        let normal = bitcast<vec3<f32>>(rows[row_at(C_NORMAL, s, r)].xyz);
        let beyond = vec2<f32>(bitcast<f32>(rows[row_at(C_FACE, s, r)].w), bitcast<f32>(rows[row_at(C_PLACE, s, r)].w));
        let v = gathered(SPEED, base, o + face_place(normal, overlap, radius, beyond.x)).xyz;
        let way = batch.dt * params.inverse_cell * dot(bitcast<vec3<f32>>(transport[i].xyz) - v, normal);
        var next = grown(beyond, way);
        if next.x >= FURTHEST {
            next = vec2<f32>(FURTHEST, 0.0);
        }
        rows[row_at(C_FACE, s, r)] = bitcast<vec4<u32>>(vec4<f32>(v, next.x));
        rows[row_at(C_PLACE, s, r)].w = bitcast<u32>(next.y);
        let most = bitcast<u32>(max(next.x, 0.0));
        if most > atomicLoad(&mix_.furthest) {
            atomicMax(&mix_.furthest, most);
        }
    }
}
