//! The pipelines, and their order in a step.

use super::continuum::{Buffers, Groups};
use super::device::Device;

/// Names of the entry points that all share one layout.
const NAMES: [&str; 18] = [
    "press",
    "feel",
    "drive",
    "survey",
    "project",
    "accelerate",
    "walls_project",
    "walls_accelerate",
    "advance",
    "strain",
    "finish",
    "clear",
    "count",
    "scan_cells",
    "scan_blocks",
    "scan_add",
    "scatter",
    "sort",
];

/// Offsets of the sizes that `plan` writes.
const CELLS: u64 = 0;
const BLOCKS: u64 = 12;
const ONE: u64 = 24;
const POINTS: u64 = 36;

/// Pipelines, and the buffers that they are bound to.
pub struct Passes {
    pipelines: Vec<wgpu::ComputePipeline>,
    plan: wgpu::ComputePipeline,
    layouts: [wgpu::BindGroupLayout; 2],
    bound: Option<(wgpu::BindGroup, wgpu::BindGroup, wgpu::Buffer)>,
}

impl Passes {
    pub fn new(device: &Device, source: &str) -> Passes {
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
        let layouts = [layout("state", &entries), layout("dispatches", &[entry(0, storage(false))])];
        let common = device.create_pipeline_layout(&wgpu::PipelineLayoutDescriptor {
            label: Some("common"),
            bind_group_layouts: &[Some(&layouts[0])],
            immediate_size: 0,
        });
        let planning = device.create_pipeline_layout(&wgpu::PipelineLayoutDescriptor {
            label: Some("planning"),
            bind_group_layouts: &[Some(&layouts[0]), Some(&layouts[1])],
            immediate_size: 0,
        });
        let module = device.create_shader_module(wgpu::ShaderModuleDescriptor {
            label: Some("step"),
            source: wgpu::ShaderSource::Wgsl(source.into()),
        });
        let pipeline = |name: &str, layout: &wgpu::PipelineLayout| {
            device.create_compute_pipeline(&wgpu::ComputePipelineDescriptor {
                label: Some(name),
                layout: Some(layout),
                module: &module,
                entry_point: Some(name),
                compilation_options: wgpu::PipelineCompilationOptions::default(),
                cache: None,
            })
        };
        let pipelines = NAMES.iter().map(|name| pipeline(name, &common)).collect();
        let plan = pipeline("plan", &planning);
        Passes { pipelines, plan, layouts, bound: None }
    }

    pub fn bind(mut self, device: &Device, b: &Buffers) -> Passes {
        let buffers = [&b.params, &b.laws, &b.state, &b.nodes, &b.starts, &b.counts, &b.order, &b.status, &b.touching, &b.outside];
        let entries: Vec<wgpu::BindGroupEntry<'_>> = (0..)
            .zip(buffers)
            .map(|(binding, buffer)| wgpu::BindGroupEntry { binding, resource: buffer.as_entire_binding() })
            .collect();
        let group =
            |layout, entries: &[_]| device.device.create_bind_group(&wgpu::BindGroupDescriptor { label: None, layout, entries });
        let all = group(&self.layouts[0], &entries);
        let sizes = wgpu::BindGroupEntry { binding: 0, resource: b.dispatches.as_entire_binding() };
        self.bound = Some((all, group(&self.layouts[1], &[sizes]), b.dispatches.clone()));
        self
    }

    fn pipeline(&self, name: &str) -> &wgpu::ComputePipeline {
        &self.pipelines[NAMES.iter().position(|n| *n == name).expect("a pass")]
    }

    fn run(&self, pass: &mut wgpu::ComputePass<'_>, name: &str, [x, y]: [u32; 2]) {
        pass.set_pipeline(self.pipeline(name));
        pass.dispatch_workgroups(x, y, 1);
    }

    /// Order of the points, if one has crossed.
    fn sort(&self, pass: &mut wgpu::ComputePass<'_>) {
        let Some((_, sizes, dispatches)) = &self.bound else { return };
        pass.set_pipeline(&self.plan);
        pass.set_bind_group(1, sizes, &[]);
        pass.dispatch_workgroups(1, 1, 1);
        pass.set_bind_group(1, None, &[]);
        for (name, offset) in [
            ("clear", CELLS),
            ("count", POINTS),
            ("scan_cells", BLOCKS),
            ("scan_blocks", ONE),
            ("scan_add", CELLS),
            ("scatter", POINTS),
            ("sort", CELLS),
        ] {
            pass.set_pipeline(self.pipeline(name));
            pass.dispatch_workgroups_indirect(dispatches, offset);
        }
    }

    /// Mass, momentum and velocity of the nodes.
    fn project(&self, pass: &mut wgpu::ComputePass<'_>, groups: &Groups) {
        self.run(pass, "project", groups.nodes);
        if groups.walls {
            self.run(pass, "walls_project", [1, 1]);
        }
    }

    fn start(&self, pass: &mut wgpu::ComputePass<'_>) {
        if let Some((all, ..)) = &self.bound {
            pass.set_bind_group(0, all, &[]);
        }
    }

    /// What platens feel of the points as they are.
    fn press(&self, pass: &mut wgpu::ComputePass<'_>, groups: &Groups) {
        if groups.platens {
            self.run(pass, "press", groups.points);
            self.run(pass, "feel", [1, 1]);
        }
    }

    /// What must stand before the first step.
    pub fn prepare(&self, pass: &mut wgpu::ComputePass<'_>, groups: &Groups) {
        self.start(pass);
        self.sort(pass);
        self.project(pass, groups);
        self.press(pass, groups);
        self.run(pass, "survey", groups.points);
    }

    /// One step; the order of mpm/step.rs, from what platens feel to what they feel.
    pub fn step(&self, pass: &mut wgpu::ComputePass<'_>, groups: &Groups) {
        self.start(pass);
        if groups.platens {
            self.run(pass, "drive", [1, 1]);
        }
        self.run(pass, "accelerate", groups.nodes);
        if groups.walls {
            self.run(pass, "walls_accelerate", [1, 1]);
        }
        self.run(pass, "advance", groups.points);
        self.sort(pass);
        self.project(pass, groups);
        self.run(pass, "strain", groups.points);
        self.run(pass, "finish", [1, 1]);
        self.press(pass, groups);
    }

    /// What a batch leaves besides.
    pub fn survey(&self, pass: &mut wgpu::ComputePass<'_>, groups: &Groups) {
        self.start(pass);
        self.run(pass, "survey", groups.points);
    }
}
