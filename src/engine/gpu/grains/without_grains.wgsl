// The functions of a step that depend on grains, for continua without grains. Those for continua with grains are in grains/bodies.wgsl.

const GRAINS: bool = false;

fn force_of_grains(i: u32, d: vec3<i32>) -> vec4<f32> {
    return vec4<f32>(0.0);
}

fn keep_transport_velocity(i: u32, o: vec3<f32>, base: vec3<i32>, v: vec3<f32>, stiffness_rate: f32) {}

fn follow_faces(i: u32, o: vec3<f32>, base: vec3<i32>) {}

fn plate_load_of_grains(k: u32) -> vec2<f32> {
    return vec2<f32>(0.0);
}

fn move_grain(g: u32) {}

// After the end of a step.
fn end_step(thread: u32) {
    if thread == 0u && PRESSED {
        drive_plates();
    }
}

fn longest_step(dt: f32, rate: f32) -> f32 {
    if params.safety > 0.0 {
        return with_contacts(dt, rate);
    }
    return dt;
}
