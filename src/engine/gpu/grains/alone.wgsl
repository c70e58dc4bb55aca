// What a step asks of grains, where there are none. Their own answers: bodies.wgsl.

const GRAINS: bool = false;

fn grains_push(i: u32) -> vec4<f32> {
    return vec4<f32>(0.0);
}

fn carry(i: u32, v: vec3<f32>, felt: f32) {}

fn of_grains(k: u32) -> vec2<f32> {
    return vec2<f32>(0.0);
}

fn longest(dt: f32, rate: f32) -> f32 {
    if params.safety > 0.0 {
        return with_contacts(dt, rate);
    }
    return dt;
}
