//! The compute pipelines, one for each entry point of the shaders, and their order in a step.

use super::buffers::{Buffers, Groups};
use super::device::Device;
use super::layout::Law32;
use super::shader::Uses;
use super::{grains, shader};
use crate::mpm::LoadingPlate;

/// Entry points for points and nodes; they share one layout of bindings.
const NAMES: [&str; 18] = [
    "plate_forces",
    "sum_plate_loads",
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

/// Entry points for grains.
const OF_GRAINS: [&str; 6] =
    ["move_grains", "point_candidates", "grain_candidates", "point_contact_forces", "grain_forces", "step_bound"];

/// Offsets, bytes, of the sizes of dispatches that `build_grid` writes.
const POINT_CANDIDATES: u64 = 0;
const GRAIN_CANDIDATES: u64 = 12;

/// Offsets, bytes, of the sizes of dispatches that `plan` writes.
const CELLS: u64 = 0;
const BLOCKS: u64 = 12;
const ONE: u64 = 24;
const POINTS: u64 = 36;

/// The pipelines, and the buffers that they are bound to.
#[derive(Clone)]
pub struct Passes {
    pipelines: Vec<wgpu::ComputePipeline>,
    plan: wgpu::ComputePipeline,
    /// `None` without grains.
    build_grid: Option<wgpu::ComputePipeline>,
    /// Bindings of the state, of the sizes of dispatches, and of grains.
    layouts: [wgpu::BindGroupLayout; 3],
    bound: Option<BindGroups>,
}

/// Buffers bound for the shaders.
#[derive(Clone)]
struct BindGroups {
    state: wgpu::BindGroup,
    sizes: wgpu::BindGroup,
    dispatches: wgpu::Buffer,
    /// Of grains: their buffers, the sizes of the dispatches of their search, and the buffer of these sizes.
    grains: Option<(wgpu::BindGroup, wgpu::BindGroup, wgpu::Buffer)>,
}

impl Passes {
    /// Compiles the pipelines for these laws and loading plates, with or without those for grains. `faces`: contacts of grains act on the faces of points.
    pub fn new(device: &Device, [with_grains, faces]: [bool; 2], laws: &[Law32], plates: &[LoadingPlate]) -> Passes {
        let uses = Uses {
            mobilised: laws.iter().any(|law| law.dilation_factor > 0.0),
            mohr_coulomb: laws.iter().any(|law| law.kind == 2),
            changing_pyramids: laws.iter().any(|law| law.kind == 2 && law.settled > 0.0),
            cam_clay: laws.iter().any(|law| law.kind == 3),
            shells: plates.iter().any(|plate| plate.radius.is_some()),
            faces,
        };
        let source = uses.of(if with_grains { shader::MIXTURE } else { shader::STEP });
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
        let layouts = [layout("state", &entries), layout("dispatches", &[entry(0, storage(false))]), layout("grains", &of_grains)];
        let of = |label, groups: &[_]| {
            device.create_pipeline_layout(&wgpu::PipelineLayoutDescriptor {
                label: Some(label),
                bind_group_layouts: groups,
                immediate_size: 0,
            })
        };
        let [state, sizes, grains] = layouts.each_ref().map(Some);
        let common = of("common", &[state, grains][..if with_grains { 2 } else { 1 }]);
        let planning = of("planning", &[state, sizes]);
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
        let names = NAMES.iter().chain(if with_grains { &OF_GRAINS[..] } else { &[] });
        let pipelines = names.map(|name| pipeline(name, &common)).collect();
        let plan = pipeline("plan", &planning);
        let build_grid = with_grains.then(|| pipeline("build_grid", &of("building the grid", &[state, grains, sizes])));
        Passes { pipelines, plan, build_grid, layouts, bound: None }
    }

    /// Binds them to buffers.
    pub fn bind(mut self, device: &Device, b: &Buffers, grains: Option<&grains::GrainBuffers>) -> Passes {
        let buffers = [&b.params, &b.laws, &b.state, &b.nodes, &b.starts, &b.counts, &b.order, &b.status, &b.touching, &b.batch];
        let group = |layout, buffers: &[&wgpu::Buffer]| {
            let entries: Vec<wgpu::BindGroupEntry<'_>> = (0..)
                .zip(buffers)
                .map(|(binding, buffer)| wgpu::BindGroupEntry { binding, resource: buffer.as_entire_binding() })
                .collect();
            device.device.create_bind_group(&wgpu::BindGroupDescriptor { label: None, layout, entries: &entries })
        };
        let of_grains = |g: &grains::GrainBuffers| {
            let all = [&g.coupling, &g.tables, &g.grains, &g.slots, &g.rows, &g.mix, &g.lists, &g.transport];
            (group(&self.layouts[2], &all), group(&self.layouts[1], &[&g.searches]), g.searches.clone())
        };
        self.bound = Some(BindGroups {
            state: group(&self.layouts[0], &buffers),
            sizes: group(&self.layouts[1], &[&b.dispatches]),
            dispatches: b.dispatches.clone(),
            grains: grains.map(of_grains),
        });
        self
    }

    fn pipeline(&self, name: &str) -> &wgpu::ComputePipeline {
        &self.pipelines[NAMES.iter().chain(&OF_GRAINS).position(|n| *n == name).expect("a pass")]
    }

    fn run(&self, pass: &mut wgpu::ComputePass<'_>, name: &str, [x, y]: [u32; 2]) {
        pass.set_pipeline(self.pipeline(name));
        pass.dispatch_workgroups(x, y, 1);
    }

    /// Sorts the points by cell, if one of them has moved to another cell.
    fn sort(&self, pass: &mut wgpu::ComputePass<'_>) {
        let Some(BindGroups { sizes, dispatches, grains, .. }) = &self.bound else { return };
        pass.set_pipeline(&self.plan);
        pass.set_bind_group(1, sizes, &[]);
        pass.dispatch_workgroups(1, 1, 1);
        pass.set_bind_group(1, grains.as_ref().map(|(all, ..)| all), &[]);
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

    /// Binds the buffers at the start of a pass.
    fn start(&self, pass: &mut wgpu::ComputePass<'_>) {
        if let Some(BindGroups { state, grains, .. }) = &self.bound {
            pass.set_bind_group(0, state, &[]);
            if let Some((all, ..)) = grains {
                pass.set_bind_group(1, all, &[]);
            }
        }
    }

    /// Forces on the grains and contacts with points, after each step of the grains: lists of candidates where they are due, then contacts.
    fn compute_grain_forces(&self, pass: &mut wgpu::ComputePass<'_>, groups: &Groups) {
        let (Some(build_grid), Some(BindGroups { grains: Some((_, sizes, searches)), .. }), Some(grains)) =
            (&self.build_grid, &self.bound, &groups.grains)
        else {
            return;
        };
        pass.set_pipeline(build_grid);
        pass.set_bind_group(2, sizes, &[]);
        pass.dispatch_workgroups(1, 1, 1);
        pass.set_bind_group(2, None, &[]);
        for (name, offset) in [("point_candidates", POINT_CANDIDATES), ("grain_candidates", GRAIN_CANDIDATES)] {
            pass.set_pipeline(self.pipeline(name));
            pass.dispatch_workgroups_indirect(searches, offset);
        }
        self.run(pass, "point_contact_forces", grains.rows);
        self.run(pass, "grain_forces", grains.each);
        self.run(pass, "step_bound", [1, 1]);
    }

    /// Forces between loading plates and points at their present positions.
    fn compute_plate_forces(&self, pass: &mut wgpu::ComputePass<'_>, groups: &Groups) {
        if groups.plates {
            self.run(pass, "plate_forces", groups.points);
            self.run(pass, "sum_plate_loads", [1, 1]);
        }
    }

    /// What must be computed before the first step: order of the points, velocities of the nodes, forces on loading plates and grains.
    pub fn prepare(&self, pass: &mut wgpu::ComputePass<'_>, groups: &Groups) {
        self.start(pass);
        self.sort(pass);
        self.project(pass, groups);
        self.compute_plate_forces(pass, groups);
        self.compute_grain_forces(pass, groups);
        self.run(pass, "survey", groups.points);
    }

    /// One step, in the order of mpm/step.rs; it begins with the forces known and ends with those of the new positions.
    pub fn step(&self, pass: &mut wgpu::ComputePass<'_>, groups: &Groups) {
        self.start(pass);
        if groups.plates || groups.grains.is_some() {
            self.run(pass, "drive", [1, 1]);
        }
        if let Some(grains) = &groups.grains {
            self.run(pass, "move_grains", grains.grains);
            for _ in 1..grains.rates {
                self.compute_grain_forces(pass, groups);
                self.run(pass, "move_grains", grains.grains);
            }
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
        self.compute_plate_forces(pass, groups);
        self.compute_grain_forces(pass, groups);
    }

    /// The largest speed of waves and points, at the end of a batch.
    pub fn survey(&self, pass: &mut wgpu::ComputePass<'_>, groups: &Groups) {
        self.start(pass);
        self.run(pass, "survey", groups.points);
    }
}
