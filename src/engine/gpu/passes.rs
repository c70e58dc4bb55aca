//! The compute pipelines, one for each entry point of the shaders that a run uses; `plan.rs` has their order in a step.

use super::bounds::BORDERS;
use super::buffers::Buffers;
use super::device::Device;
use super::grains::CoarseGrains;
use super::layout::{Law32, RUBS};
use super::plan::{self, Dispatch};
use super::shader::Uses;
use super::{grains, shader};
use crate::mpm::LoadingPlate;
use crate::point_contacts::ActsOn;

/// The pipelines, and the buffers that they are bound to.
#[derive(Clone)]
pub struct Passes {
    /// With the names of their entry points.
    pipelines: Vec<(&'static str, wgpu::ComputePipeline)>,
    /// Bindings of the state and of grains.
    layouts: [wgpu::BindGroupLayout; 2],
    /// Buffers bound for the shaders: of the state, then of grains where there are some.
    bound: Vec<wgpu::BindGroup>,
}

impl Passes {
    /// Compiles the pipelines that runs with these walls, laws and loading plates use, with or without grains. `shells`: one of the plates or of the grains' walls is a shell.
    pub fn new(
        device: &Device,
        grains: Option<&CoarseGrains<'_>>,
        shells: bool,
        walls: &[u32; BORDERS],
        laws: &[Law32],
        plates: &[LoadingPlate],
    ) -> Passes {
        let uses = Uses {
            mobilised: laws.iter().any(|law| law.dilation_factor > 0.0),
            mohr_coulomb: laws.iter().any(|law| law.kind == 2),
            changing_pyramids: laws.iter().any(|law| law.kind == 2 && law.settled > 0.0),
            cam_clay: laws.iter().any(|law| law.kind == 3),
            yields: laws.iter().any(|law| law.kind != 0),
            one_law: laws.len() == 1,
            walls: walls.iter().any(|kind| *kind != 0),
            rubbed: walls.contains(&RUBS),
            pressed: !plates.is_empty(),
            shells,
            faces: grains.is_some_and(|g| g.table.acts_on == ActsOn::Face),
            crushing: grains.is_some_and(|g| g.physics.crush.is_some()),
            fines: grains.is_some_and(|g| g.mixture.fines.is_some()),
        };
        let source = uses.of(if grains.is_some() { shader::MIXTURE } else { shader::STEP });
        let device = &device.device;
        let entry = |binding: u32, ty: wgpu::BufferBindingType| wgpu::BindGroupLayoutEntry {
            binding,
            visibility: wgpu::ShaderStages::COMPUTE,
            ty: wgpu::BindingType::Buffer { ty, has_dynamic_offset: false, min_binding_size: None },
            count: None,
        };
        let storage = |read_only| wgpu::BufferBindingType::Storage { read_only };
        let mut entries = vec![entry(0, wgpu::BufferBindingType::Uniform), entry(1, storage(true))];
        entries.extend((2..10).map(|k| entry(k, storage(false))));
        let layout = |label, entries: &[_]| {
            device.create_bind_group_layout(&wgpu::BindGroupLayoutDescriptor { label: Some(label), entries })
        };
        let mut of_grains = vec![entry(0, wgpu::BufferBindingType::Uniform), entry(1, storage(true))];
        of_grains.extend((2..8).map(|k| entry(k, storage(false))));
        let layouts = [layout("state", &entries), layout("grains", &of_grains)];
        let common = device.create_pipeline_layout(&wgpu::PipelineLayoutDescriptor {
            label: Some("common"),
            bind_group_layouts: &layouts.each_ref().map(Some)[..if grains.is_some() { 2 } else { 1 }],
            immediate_size: 0,
        });
        let module = device.create_shader_module(wgpu::ShaderModuleDescriptor {
            label: Some("step"),
            source: wgpu::ShaderSource::Wgsl(source.into()),
        });
        let pipeline = |name: &'static str| {
            let described = wgpu::ComputePipelineDescriptor {
                label: Some(name),
                layout: Some(&common),
                module: &module,
                entry_point: Some(name),
                compilation_options: wgpu::PipelineCompilationOptions::default(),
                cache: None,
            };
            (name, device.create_compute_pipeline(&described))
        };
        let pipelines = plan::passes(!plates.is_empty(), grains.is_some()).into_iter().map(pipeline).collect();
        Passes { pipelines, layouts, bound: Vec::new() }
    }

    /// Binds them to buffers.
    pub fn bind(mut self, device: &Device, b: &Buffers, grains: Option<&grains::GrainBuffers>) -> Passes {
        let buffers = [&b.params, &b.laws, &b.state, &b.nodes, &b.starts, &b.counts, &b.blocks, &b.status, &b.touching, &b.batch];
        let group = |layout, buffers: &[&wgpu::Buffer]| {
            let entries: Vec<wgpu::BindGroupEntry<'_>> = (0..)
                .zip(buffers)
                .map(|(binding, buffer)| wgpu::BindGroupEntry { binding, resource: buffer.as_entire_binding() })
                .collect();
            device.device.create_bind_group(&wgpu::BindGroupDescriptor { label: None, layout, entries: &entries })
        };
        self.bound = vec![group(&self.layouts[0], &buffers)];
        if let Some(g) = grains {
            let all = [&g.coupling, &g.tables, &g.grains, &g.slots, &g.rows, &g.mix, &g.lists, &g.transport];
            self.bound.push(group(&self.layouts[1], &all));
        }
        self
    }

    /// Records `times` times these dispatches, each of which waits for the one before it.
    pub fn encode(&self, pass: &mut wgpu::ComputePass<'_>, dispatches: &[Dispatch], times: u64) {
        let of = |pass: &str| &self.pipelines.iter().find(|(name, _)| *name == pass).expect("a pass of the plan").1;
        let all: Vec<_> = dispatches.iter().map(|d| (of(d.pass), d.groups)).collect();
        for (index, group) in (0..).zip(&self.bound) {
            pass.set_bind_group(index, group, &[]);
        }
        for (pipeline, [x, y]) in (0..times).flat_map(|_| &all) {
            pass.set_pipeline(pipeline);
            pass.dispatch_workgroups(*x, *y, 1);
        }
    }
}
