// Runs the laws by themselves, for the comparison with their f32 twin.

struct Case {
    normal: vec3<f32>,
    law: u32,
    shear: vec3<f32>,
    plastic: f32,
    strain_normal: vec3<f32>,
    unused_a: u32,
    strain_shear: vec3<f32>,
    unused_b: u32,
}

@group(0) @binding(2) var<storage, read> cases: array<Case>;
@group(0) @binding(3) var<storage, read_write> results: array<vec4<f32>>;

@compute @workgroup_size(GROUP)
fn run(@builtin(global_invocation_id) id: vec3<u32>) {
    let i = id.x;
    if i >= params.points {
        return;
    }
    let c = cases[i];
    let step = stress_step(c.law, Sym(c.normal, c.shear), Sym(c.strain_normal, c.strain_shear), c.plastic);
    results[3u * i] = vec4<f32>(step.stress.normal, step.plastic);
    let sum = add(vec4<f32>(c.normal, 0.0), vec4<f32>(0.0), vec4<f32>(c.strain_normal, 0.0));
    results[3u * i + 1u] = vec4<f32>(step.stress.shear, sum.low.x);
    results[3u * i + 2u] = vec4<f32>(step.gap, 0.0, 0.0, 0.0);
}
