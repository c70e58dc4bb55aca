//! Rung 2: laws in f32 against f64, and their shader against f32.

use super::{JUMPS, adapter, laws, pyramids};
use crate::gpu::device::Device;
use crate::gpu::exact;
use crate::gpu::law::stress_step;
use crate::gpu::layout::{Law32, Params};
use crate::gpu::shader::tests::{ALL, LAW_TEST};
use crate::math::eigen::principal;
use crate::mpm::law::{InternalVariables, Law, Sym};
use bytemuck::{Pod, Zeroable};
use rand::{RngExt, SeedableRng};
use rand_chacha::ChaCha8Rng;
use wgpu::BufferUsages as Usage;

/// A state and a strain increment; `law_test.wgsl` has the same.
#[repr(C)]
#[derive(Clone, Copy, Pod, Zeroable)]
struct Case {
    normal: [f32; 3],
    law: u32,
    shear: [f32; 3],
    plastic: f32,
    strain_normal: [f32; 3],
    unused_a: u32,
    strain_shear: [f32; 3],
    unused_b: u32,
}

impl Case {
    fn stress(&self) -> [f32; 6] {
        join(self.normal, self.shear)
    }

    fn strain(&self) -> [f32; 6] {
        join(self.strain_normal, self.strain_shear)
    }

    /// Size of the elastic trial stress: what rounding is measured by.
    fn scale(&self, law: &Law) -> f64 {
        let trial = law.elastic().update(self.stress().map(f64::from), self.strain().map(f64::from));
        size(&trial) + size(&self.stress().map(f64::from)) + 1.0
    }
}

fn join([a, b, c]: [f32; 3], [d, e, f]: [f32; 3]) -> [f32; 6] {
    [a, b, c, d, e, f]
}

fn size(s: &Sym) -> f64 {
    s.iter().map(|x| x * x).sum::<f64>().sqrt()
}

/// States that the laws can reach, at any plastic strain, and increments of 1e-8 to 5 %.
fn cases(per_law: usize) -> Vec<Case> {
    let mut rng = ChaCha8Rng::seed_from_u64(1);
    let mut cases = Vec::new();
    for (k, law) in laws().iter().enumerate() {
        for _ in 0..per_law {
            let mut symmetric = |size: f64| -> Sym { std::array::from_fn(|_| size * rng.random_range(-1.0..1.0)) };
            let (mut path, mut strain) = (symmetric(0.02), symmetric(1.0));
            let plastic = [0.0, rng.random_range(0.0..0.03), rng.random_range(0.0..2.0)][rng.random_range(0..3)];
            let squeeze = 0.05 * rng.random_range(-1.0..0.2);
            (0..3).for_each(|i| path[i] += squeeze);
            let (stress, memory) = law.update([0.0; 6], path, InternalVariables { plastic });
            let size = 10f64.powf(rng.random_range(-8.0..-1.3));
            strain = strain.map(|e| size * e);
            let [a, b, c, d, e, f] = stress.map(|s| s as f32);
            let [u, v, w, x, y, z] = strain.map(|s| s as f32);
            cases.push(Case {
                normal: [a, b, c],
                law: k as u32,
                shear: [d, e, f],
                plastic: memory.plastic as f32,
                strain_normal: [u, v, w],
                unused_a: 0,
                strain_shear: [x, y, z],
                unused_b: 0,
            });
        }
    }
    cases
}

/// Stresses on the pyramids of Mohr and Coulomb or beside them, in any directions: on planes, on and near both kinds of edges, at and near the apex; and a triaxial
/// cube along the axes. Increments as above.
fn at_pyramids(per_law: usize) -> Vec<Case> {
    let mut rng = ChaCha8Rng::seed_from_u64(2);
    let mut cases = Vec::new();
    let first = laws().len() - pyramids().len();
    for (k, law) in pyramids().iter().enumerate() {
        for n in 0..per_law {
            let turn = principal(std::array::from_fn(|_| rng.random_range(-1.0..1.0))).1;
            let axes = if n % 4 == 0 { [[1.0, 0.0, 0.0], [0.0, 1.0, 0.0], [0.0, 0.0, 1.0]] } else { turn };
            let cell = 10f64.powf(rng.random_range(1.0..6.0));
            let least = -cell - law.q_compression(cell, 0.0).expect("a strength");
            let off = [0.0, 10f64.powf(rng.random_range(-9.0..-2.0))][n % 2];
            // in compression, in extension, between them, at the apex
            let middle = match n / 2 % 4 {
                0 => -cell * (1.0 + off),
                1 => least * (1.0 - off),
                _ => -cell + rng.random_range(0.0..1.0) * (least + cell),
            };
            let mut values = [-cell, middle, least];
            if n / 2 % 4 == 3 {
                let apex = -law.q_compression(0.0, 0.0).expect("a strength");
                values = [1.0, 0.5, 1.0].map(|share| share * apex * off);
            }
            let pairs = [(0, 0), (1, 1), (2, 2), (0, 1), (1, 2), (2, 0)];
            let stress: Sym = pairs.map(|(i, j)| (0..3).map(|m| values[m] * (axes[m][i] * axes[m][j])).sum());
            let size = 10f64.powf(rng.random_range(-8.0..-1.3));
            let mut strain: Sym = std::array::from_fn(|_| size * rng.random_range(-1.0..1.0));
            if n % 8 == 0 {
                let lateral = rng.random_range(-0.5..1.0);
                strain = [size * lateral, size * lateral, -size, 0.0, 0.0, 0.0];
            }
            let [a, b, c, d, e, f] = stress.map(|s| s as f32);
            let [u, v, w, x, y, z] = strain.map(|s| s as f32);
            cases.push(Case {
                normal: [a, b, c],
                law: (first + k) as u32,
                shear: [d, e, f],
                plastic: 0.0,
                strain_normal: [u, v, w],
                unused_a: 0,
                strain_shear: [x, y, z],
                unused_b: 0,
            });
        }
    }
    cases
}

/// The numbers of laws in shaders are those of the list of laws.
#[test]
fn laws_have_their_numbers() {
    for law in laws() {
        assert_eq!(Ok(Law32::from(&law).kind), law.on_gpu(), "{law:?}");
    }
}

/// Rung 2a. Stress within 2e-6 of the size of the trial stress; the plastic strain within that over G.
#[test]
fn laws_in_f32_follow_f64() {
    let laws = laws();
    let (mut in_stress, mut in_plastic, mut yielded): (f64, f64, u32) = (0.0, 0.0, 0);
    let mut worst = vec![(0.0_f64, 0_u32); laws.len()];
    for case in cases(4000).into_iter().chain(at_pyramids(8000)) {
        let law = &laws[case.law as usize];
        let (change, made) = stress_step(&Law32::from(law), case.stress(), case.strain(), case.plastic);
        let before = case.stress().map(f64::from);
        let memory = InternalVariables { plastic: f64::from(case.plastic) };
        let (exact, after) = law.update(before, case.strain().map(f64::from), memory);
        let apart: Sym = std::array::from_fn(|k| before[k] + f64::from(change[k]) - exact[k]);
        let grown = after.plastic - memory.plastic;
        yielded += u32::from(grown > 0.0);
        // where the strength jumps, rounding decides on which side a state lies
        if JUMPS.contains(&(case.law as usize))
            && (memory.plastic == 0.0 || (memory.plastic..=after.plastic + 1e-6).contains(&0.022))
        {
            continue;
        }
        let scale = case.scale(law);
        let stress = size(&apart) / scale;
        let plastic = (f64::from(made) - grown).abs() * law.shear_modulus() / scale;
        assert!(
            stress < 2e-6 && plastic < 2e-6,
            "{law:?}: stress {stress:e}, plastic strain {plastic:e}; {grown:e} {made:e} {before:?}"
        );
        (in_stress, in_plastic) = (in_stress.max(stress), in_plastic.max(plastic));
        let own = &mut worst[case.law as usize];
        *own = (own.0.max(stress), own.1 + u32::from(grown > 0.0));
    }
    println!("rung 2a, largest in stress and number yielded of each law: {worst:?}");
    assert!(worst[1..].iter().all(|(_, yielded)| *yielded > 300));
    assert!(yielded > 10_000, "{yielded}");
    println!("rung 2a: stress {in_stress:e}, plastic strain {in_plastic:e}, {yielded} yielded");
}

/// Rung 2a over many steps: 100 000 increments of 1e-7 in compensated sums, of a cone through its peak, where it hardens and softens, with dilation that stays and that ends, and of a pyramid without
/// cohesion, on whose edge a triaxial cube is.
#[test]
fn small_steps_in_f32_follow_f64() {
    for law in [laws().remove(9), laws().remove(13), pyramids().remove(0)] {
        let law32 = Law32::from(&law);
        let start = [-5e4, -5e4, -5e4, 0.0, 0.0, 0.0];
        let (mut exact, mut sums, mut plastic) = ((start, InternalVariables::default()), start.map(exact::split), [0.0_f32; 2]);
        let strain = [3e-7_f32, 3e-7, -1e-6, 0.0, 0.0, 0.0];
        let mut worst: f64 = 0.0;
        for _ in 0..100_000 {
            exact = law.update(exact.0, strain.map(f64::from), exact.1);
            let (change, made) = stress_step(&law32, sums.map(|[high, low]| high + low), strain, plastic[0] + plastic[1]);
            sums = std::array::from_fn(|k| exact::add(sums[k], change[k]));
            plastic = exact::add(plastic, made);
            let apart: Sym = std::array::from_fn(|k| f64::from(sums[k][0]) + f64::from(sums[k][1]) - exact.0[k]);
            worst = worst.max(size(&apart) / size(&exact.0));
        }
        let in_plastic = (f64::from(plastic[0]) + f64::from(plastic[1])) / exact.1.plastic - 1.0;
        println!("rung 2a, many steps, {}: stress {worst:e}, plastic strain {in_plastic:e} of {}", law.word(), exact.1.plastic);
        assert!(worst < 2e-6 && in_plastic.abs() < 2e-6, "{}: {worst:e} {in_plastic:e}", law.word());
    }
}

/// Rung 2b: the shader and its twin, within some units in the last place of the trial stress; compensated sums to the bit.
#[test]
fn laws_on_the_device_follow_their_twin() {
    if !adapter("laws_on_the_device_follow_their_twin") {
        return;
    }
    let device = Device::open(false).expect("device");
    let laws = laws();
    let laws32: Vec<Law32> = laws.iter().map(Law32::from).collect();
    let cases = [cases(1000), at_pyramids(2000)].concat();
    let params = Params { points: cases.len() as u32, ..Params::default() };
    let storage = Usage::STORAGE | Usage::COPY_SRC;
    let buffers = [
        device.buffer("params", bytemuck::bytes_of(&params), Usage::UNIFORM),
        device.buffer("laws", bytemuck::cast_slice(&laws32), storage),
        device.buffer("cases", bytemuck::cast_slice(&cases), storage),
        device.empty("results", 32 * cases.len() as u64, storage),
    ];
    let d = &device.device;
    let module = d.create_shader_module(wgpu::ShaderModuleDescriptor {
        label: None,
        source: wgpu::ShaderSource::Wgsl(ALL.of(LAW_TEST).into()),
    });
    let pipeline = d.create_compute_pipeline(&wgpu::ComputePipelineDescriptor {
        label: None,
        layout: None,
        module: &module,
        entry_point: Some("run"),
        compilation_options: wgpu::PipelineCompilationOptions::default(),
        cache: None,
    });
    let entries: Vec<_> =
        (0..).zip(&buffers).map(|(binding, b)| wgpu::BindGroupEntry { binding, resource: b.as_entire_binding() }).collect();
    let group = d.create_bind_group(&wgpu::BindGroupDescriptor {
        label: None,
        layout: &pipeline.get_bind_group_layout(0),
        entries: &entries,
    });
    let mut encoder = d.create_command_encoder(&wgpu::CommandEncoderDescriptor::default());
    {
        let mut pass = encoder.begin_compute_pass(&wgpu::ComputePassDescriptor::default());
        pass.set_pipeline(&pipeline);
        pass.set_bind_group(0, &group, &[]);
        pass.dispatch_workgroups(params.points.div_ceil(64), 1, 1);
    }
    device.queue.submit([encoder.finish()]);
    let results: Vec<[f32; 4]> =
        bytemuck::pod_collect_to_vec(&device.read(&[(&buffers[3], buffers[3].size())], 0).expect("results"));
    let (mut in_stress, mut in_plastic, mut same): (f64, f64, usize) = (0.0, 0.0, 0);
    for (case, result) in cases.iter().zip(results.chunks_exact(2)) {
        let law = &laws[case.law as usize];
        let (stress, plastic) = stress_step(&laws32[case.law as usize], case.stress(), case.strain(), case.plastic);
        let [[a, b, c, made], [d, e, f, low]] = [result[0], result[1]];
        assert_eq!(
            low.to_bits(),
            exact::add([case.normal[0], 0.0], case.strain_normal[0])[1].to_bits(),
            "compensated sums survive"
        );
        let there = [a, b, c, d, e, f];
        same += usize::from(there == stress && made == plastic);
        if JUMPS.contains(&(case.law as usize))
            && (f64::from(case.plastic)..=f64::from(case.plastic + plastic) + 1e-6).contains(&0.022)
        {
            continue;
        }
        let apart: Sym = std::array::from_fn(|k| f64::from(there[k]) - f64::from(stress[k]));
        let scale = case.scale(law) * f64::from(f32::EPSILON);
        let (s, p) = (size(&apart) / scale, f64::from((made - plastic).abs()) * law.shear_modulus() / scale);
        assert!(
            s < 8.0 && p < 8.0,
            "{law:?}: stress {s}, plastic strain {p} ulp: {there:?} for {stress:?}, {made:e} for {plastic:e}"
        );
        (in_stress, in_plastic) = (in_stress.max(s), in_plastic.max(p));
    }
    println!(
        "rung 2b: stress {in_stress:.2} ulp, plastic strain {in_plastic:.2} ulp of the trial; {same} of {} the same bits",
        cases.len()
    );
}
