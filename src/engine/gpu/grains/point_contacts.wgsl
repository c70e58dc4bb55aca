// Contacts of material points with grains and walls (Li et al. 2023, section 2.3): one thread per point with candidates. Twins (f64): coupling/search.rs,
// coupling/evaluate.rs.

// Faults of points, besides those of nodes.wgsl: more candidates than ROW_PLACES; more points with candidates than rows.
const SURROUNDED: u32 = 6u;

// Radius of the ghost of a point.
fn ghost_radius(i: u32) -> Length {
    return length_of(vec3<i32>(0), vec3<i32>(radius_in_units(i), 0, 0), vec3<f32>(0.0));
}

// Position of a point, cells from the corner of the domain.
fn point_cells(i: u32) -> vec3<f32> {
    let place = word(PLACE, i);
    return vec3<f32>(cell_place(place.w) - 1) + offset(place);
}

// Position of a grain, cells from the corner of the domain.
fn grain_cells(g: u32) -> vec3<f32> {
    return vec3<f32>(bitcast<vec3<i32>>(grain_word(G_CELL, g).xyz)) + offset(grain_word(G_UNITS, g));
}

// Grid cell of a position; positions outside of the domain belong to the grid cells at its border.
fn grid_cell_of(at: vec3<f32>) -> vec3<i32> {
    return clamp(vec3<i32>(floor((at + 1.0) / coupling.grid_size)), vec3<i32>(0), coupling.grid - 1);
}

fn grid_index(at: vec3<i32>) -> u32 {
    return u32(at.x + coupling.grid.x * (at.y + coupling.grid.y * at.z));
}

// The grain with the index k in the order of grid cells.
fn grain_in_cell(k: u32) -> u32 {
    return atomicLoad(&lists[2u * coupling.grid_cells + 1u + k]);
}

// Index of the first grain of a grid cell.
fn grid_start(grid_cell: u32) -> u32 {
    return atomicLoad(&lists[grid_cell]);
}

// Moves a contact to another place in its row.
fn move_in_row(old: u32, to: u32, r: u32) {
    for (var plane = 0u; plane < ROW_PLANES; plane++) {
        rows[row_at(plane, to, r)] = rows[row_at(plane, old, r)];
    }
}

// Whether a contact must be kept: it has a face or an overlap without force, or its stiffness counts in this step of the continuum.
fn is_kept(s: u32, r: u32) -> bool {
    if FINES {
        if bitcast<f32>(rows[row_at(C_REFERENCE, s, r)].x) > 0.0 {
            return true;
        }
    }
    let pressed = mix_.sub != 0u && bitcast<f32>(rows[row_at(C_PLACE, s, r)].x) < NO_PLACE;
    return bitcast<f32>(rows[row_at(C_TANGENT, s, r)].w) > NO_FACE || pressed;
}

// By how much the faces of a point reach beyond its ghost at most, cells.
fn beyond_ghost(r: u32) -> f32 {
    var most = 0.0;
    if r == NONE {
        return most;
    }
    for (var s = 0u; s < ROW_PLACES; s++) {
        if rows[row_at(C_SPRING, s, r)].w == NONE {
            break;
        }
        if is_kept(s, r) {
            most = max(most, bitcast<f32>(rows[row_at(C_FACE, s, r)].w));
        }
    }
    return most;
}

// Makes the list of candidates of a point anew, in the order of bodies. Contacts with a face keep their history: they are first moved to the front of the row, then,
// from the last one on, to their new places.
fn point_candidates(i: u32) {
    let at = point_cells(i);
    var r = transport[i].w;
    let radius = f32(radius_in_units(i)) / UNITS + beyond_ghost(r);
    var found: array<u32, ROW_PLACES>;
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
            let g = grain_in_cell(entry);
            let d = grain_cells(g) - at;
            let far = grain_number(G_VELOCITY_LOW, g).w * params.inverse_cell + radius + coupling.skin;
            if dot(d, d) >= far * far {
                continue;
            }
            count += 1u;
            if n < ROW_PLACES {
                var place = n;
                while place > 0u && found[place - 1u] > g {
                    found[place] = found[place - 1u];
                    place -= 1u;
                }
                found[place] = g;
                n += 1u;
            }
        }
    }
    for (var k = 0u; k < coupling.point_walls; k++) {
        let side = mix_.sides[k];
        let height = height_over(side, at);
        if height < radius + coupling.skin {
            count += 1u;
            if n < ROW_PLACES {
                found[n] = WALLS + k;
                n += 1u;
            }
        }
    }
    if count > ROW_PLACES {
        report_fault(SURROUNDED, i);
        return;
    }
    if r == NONE {
        if n == 0u {
            return;
        }
        r = atomicAdd(&mix_.rows, 1u);
        if r >= coupling.rows {
            report_fault(NO_ROOM, i);
            return;
        }
        transport[i].w = r;
        rows[owner_at(r)] = vec4<u32>(i, 0u, 0u, 0u);
        for (var s = 0u; s < ROW_PLACES; s++) {
            rows[row_at(C_SPRING, s, r)] = vec4<u32>(0u, 0u, 0u, NONE);
        }
    }
    var kept = 0u;
    for (var s = 0u; s < ROW_PLACES; s++) {
        if rows[row_at(C_SPRING, s, r)].w == NONE {
            break;
        }
        if is_kept(s, r) {
            if kept != s {
                move_in_row(s, kept, r);
            }
            kept += 1u;
        }
    }
    for (var s = n; s > 0u; s--) {
        let to = s - 1u;
        while kept > 0u && rows[row_at(C_SPRING, kept - 1u, r)].w > found[to] {
            kept -= 1u;
        }
        if kept > 0u && rows[row_at(C_SPRING, kept - 1u, r)].w == found[to] {
            kept -= 1u;
            if kept != to {
                move_in_row(kept, to, r);
            }
        } else {
            rows[row_at(C_SPRING, to, r)] = vec4<u32>(0u, 0u, 0u, found[to]);
            for (var plane = 1u; plane < ROW_PLANES; plane++) {
                rows[row_at(plane, to, r)] = vec4<u32>(0u);
            }
            rows[row_at(C_TANGENT, to, r)].w = bitcast<u32>(NO_FACE);
            rows[row_at(C_PLACE, to, r)].x = bitcast<u32>(NO_PLACE);
        }
    }
    for (var s = n; s < ROW_PLACES; s++) {
        rows[row_at(C_SPRING, s, r)].w = NONE;
    }
}

// Parameters of a contact of a point with a grain, with the friction at the plastic strain that the point has now.
fn softened(at: u32, i: u32) -> Pair {
    var pair = pair_at(at);
    let softening = tables[at + 1u];
    if softening.z > 0.0 {
        let plastic = number(SHEAR, i).w + number(SHEAR_LOW, i).w;
        pair.friction = softening.y + (pair.friction - softening.y) * decay_of(softening.z * plastic);
    }
    return pair;
}

// The overlap without force of a contact at this overlap, m, which it never exceeds.
fn reference_at(s: u32, r: u32, overlap: f32) -> vec2<f32> {
    let reference = bitcast<vec2<f32>>(rows[row_at(C_REFERENCE, s, r)].xy);
    if (overlap - reference.x) - reference.y > 0.0 {
        return reference;
    }
    return vec2<f32>(max(overlap, 0.0), 0.0);
}

// Keeps the overlap without force of a contact with the force `force`, lowered by sliding over `way` ghost diameters, and the energy gained (coupling/reactions.rs).
fn release(s: u32, r: u32, reference: vec2<f32>, way: f32, force: f32) {
    let released = reference.x * min(way, 1.0);
    rows[row_at(C_REFERENCE, s, r)] = vec4<u32>(bitcast<vec2<u32>>(grown(reference, -released)), 0u, 0u);
    if released * force != 0.0 {
        let energy = grown(bitcast<vec2<f32>>(rows[owner_at(r)].zw), released * force);
        rows[owner_at(r)] = vec4<u32>(rows[owner_at(r)].xy, bitcast<vec2<u32>>(energy));
    }
}

// Force of each contact of a point, and where it acts on the point.
@compute @workgroup_size(GROUP)
fn point_contact_forces(one: Thread) {
    let r = linear(one);
    if r >= min(atomicLoad(&mix_.rows), coupling.rows) || status.stop != 0u {
        return;
    }
    let i = rows[owner_at(r)].x;
    var pressed = select(rows[owner_at(r)].y, 0u, mix_.sub == 0u);
    let place = word(PLACE, i);
    let own_velocity = bitcast<vec3<f32>>(transport[i].xyz);
    let there = moved(bitcast<vec3<i32>>(place.xyz), number(REST, i).xyz, own_velocity * (mix_.ahead * params.inverse_cell));
    let cell = cell_place(place.w) - 1 + there.shift;
    let radius = ghost_radius(i);
    let metres = (f32(radius.whole.x) + radius.part.x) * coupling.quantum;
    let mass = number(VELOCITY, i).w;
    let law = word(VELOCITY_LOW, i).w;
    let dt = batch.dt / f32(coupling.rates);
    var rate = 0.0;
    for (var s = 0u; s < ROW_PLACES; s++) {
        let head = rows[row_at(C_SPRING, s, r)];
        let body = head.w;
        if body == NONE {
            break;
        }
        var pair: Pair;
        var c: Contact;
        let on_wall = body >= WALLS;
        var of_pair: u32;
        if on_wall {
            of_pair = coupling.tables.z + 2u * ((body - WALLS) * coupling.laws + law);
            pair = pair_at(of_pair);
        } else {
            of_pair = coupling.tables.x + 2u * (law * coupling.materials + (grain_word(G_UNITS, body).w));
            pair = softened(of_pair, i);
        }
        var place_of_force = bitcast<vec4<f32>>(rows[row_at(C_PLACE, s, r)]);
        var face = bitcast<vec4<f32>>(rows[row_at(C_FACE, s, r)]);
        if mix_.contacts_known != 0u {
            let normal = bitcast<vec4<f32>>(rows[row_at(C_NORMAL, s, r)]);
            let tangent = bitcast<vec4<f32>>(rows[row_at(C_TANGENT, s, r)]);
            c = no_contact();
            c.normal = normal.xyz;
            c.force = normal.w;
            c.tangent = tangent.xyz;
            c.overlap = tangent.w;
            c.stiffness = bitcast<f32>(rows[row_at(C_LOW, s, r)].w);
        } else {
            let spring = bitcast<vec3<f32>>(head.xyz);
            let low = bitcast<vec3<f32>>(rows[row_at(C_LOW, s, r)].xyz);
            var m: ContactGeometry;
            var motion: RelativeMotion;
            var r_eff = metres;
            var m_eff = mass;
            // once pressed, the ghost moves with the face of the point, not with the point
            let followed = FACES && bitcast<f32>(rows[row_at(C_TANGENT, s, r)].w) > NO_FACE;
            if !followed {
                face = vec4<f32>(own_velocity, 0.0);
                place_of_force.w = 0.0;
            }
            let further = face.w * f32(1u << coupling.split);
            let quanta = floor(further + 0.5);
            let whole = radius.whole.x + i32(quanta);
            let part = radius.part.x + ((further - quanta) + place_of_force.w * f32(1u << coupling.split));
            if on_wall {
                let side = mix_.sides[body - WALLS];
                m = on_side(side, cell, there.units, there.rest, whole, part);
                m.normal = -m.normal;
                motion = RelativeMotion(m.normal * side_speed(side) - face.xyz, vec3<f32>(0.0), vec3<f32>(0.0));
            } else {
                let own = grain_word(G_CELL, body);
                let rest = grain_number(G_REST, body);
                let apart = cell - bitcast<vec3<i32>>(own.xyz);
                m = ContactGeometry(0.0, vec3<f32>(0.0));
                if all(abs(apart) < vec3<i32>(coupling.far)) {
                    let d = length_of(apart, there.units - bitcast<vec3<i32>>(grain_word(G_UNITS, body).xyz), there.rest - rest.xyz);
                    m = spheres_geometry(d, bitcast<i32>(own.w) + whole, rest.w + part);
                }
                let low_v = grain_number(G_VELOCITY_LOW, body);
                let v = grain_number(G_VELOCITY, body);
                let spin = grain_number(G_SPIN, body).xyz;
                motion = RelativeMotion((v.xyz - face.xyz) + low_v.xyz, spin * low_v.w, 0.5 * spin);
                r_eff = low_v.w * metres / (low_v.w + metres);
                m_eff = v.w * mass / (v.w + mass);
            }
            let of_ghost = m.overlap - face.w * params.cell;
            var reference = vec2<f32>(0.0);
            if FINES {
                reference = reference_at(s, r, m.overlap);
                m.overlap = (m.overlap - reference.x) - reference.y;
            }
            c = no_contact();
            if m.overlap > 0.0 {
                c = contact_force(m, r_eff, m_eff, motion, pair, dt, spring, low);
            } else if FACES && of_ghost > 0.0 {
                c.normal = m.normal;
            } else {
                c.overlap = NO_FACE;
            }
            if c.overlap > NO_FACE {
                rows[row_at(C_FACE, s, r)] = bitcast<vec4<u32>>(face);
            }
            rows[row_at(C_SPRING, s, r)] = vec4<u32>(bitcast<vec3<u32>>(c.spring), body);
            rows[row_at(C_NORMAL, s, r)] = bitcast<vec4<u32>>(vec4<f32>(c.normal, c.force));
            rows[row_at(C_TANGENT, s, r)] = bitcast<vec4<u32>>(vec4<f32>(c.tangent, c.overlap));
            rows[row_at(C_LOW, s, r)] = bitcast<vec4<u32>>(vec4<f32>(c.low, c.stiffness));
            if FINES {
                release(s, r, reference, length(motion.centres) * dt / (2.0 * metres * tables[of_pair + 1u].w), c.force);
            }
        }
        let stiffness = c.stiffness * max(1.0, stiffness_ratio(pair));
        rate += stiffness / mass;
        // the stiffness is that at the start of the step of the continuum
        let starts_step = mix_.sub == 0u;
        if starts_step {
            place_of_force.x = NO_PLACE;
        }
        if c.overlap > 0.0 {
            if pressed == 0u {
                clear_pushes(r);
                pressed = 1u;
            }
            let push = vec4<f32>(c.normal * c.force - c.tangent, select(0.0, OF_POINT * stiffness, starts_step));
            if FACES {
                let beside = face_place(c.normal, c.overlap, metres, face.w);
                press(r, offset(place) + beside, push);
                if starts_step {
                    place_of_force = vec4<f32>(beside, place_of_force.w);
                }
            } else {
                press_centre(r, offset(place), push);
            }
        }
        rows[row_at(C_PLACE, s, r)] = bitcast<vec4<u32>>(place_of_force);
    }
    rows[owner_at(r)].y = pressed;
    atomicMax(&mix_.point_rate, bitcast<u32>(rate));
}
