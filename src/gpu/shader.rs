//! The sources of the passes, assembled.

/// All passes of a step.
pub const STEP: &str = concat!(
    include_str!("params.wgsl"),
    include_str!("exact.wgsl"),
    include_str!("law.wgsl"),
    include_str!("nodes.wgsl"),
    include_str!("platens.wgsl"),
    include_str!("walls.wgsl"),
    include_str!("points.wgsl"),
    include_str!("order.wgsl")
);

#[cfg(test)]
pub mod tests {
    use super::*;
    use crate::gpu::layout::{Drive32, Evolution32, Law32, Params, Platen32, Status};
    use std::mem::{offset_of, size_of};
    use wgpu::naga;

    /// Rung 2b runs the laws by themselves.
    pub const LAW_TEST: &str =
        concat!(include_str!("params.wgsl"), include_str!("exact.wgsl"), include_str!("law.wgsl"), include_str!("law_test.wgsl"));

    fn parsed(source: &str) -> naga::Module {
        naga::front::wgsl::parse_str(source).unwrap_or_else(|e| panic!("{}", e.emit_to_string(source)))
    }

    /// Rung 0.
    #[test]
    fn shaders_are_valid() {
        for source in [STEP, LAW_TEST] {
            let module = parsed(source);
            let mut validator =
                naga::valid::Validator::new(naga::valid::ValidationFlags::all(), naga::valid::Capabilities::empty());
            validator.validate(&module).unwrap_or_else(|e| panic!("{}", e.emit_to_string(source)));
        }
    }

    /// Offsets and size of a struct of the shaders.
    fn offsets(module: &naga::Module, name: &str) -> (Vec<usize>, usize) {
        let (_, t) = module.types.iter().find(|(_, t)| t.name.as_deref() == Some(name)).expect("a struct");
        let naga::TypeInner::Struct { members, span } = &t.inner else { panic!("{name} is a struct") };
        (members.iter().map(|m| m.offset as usize).collect(), *span as usize)
    }

    /// Rung 1.
    #[test]
    fn structs_have_the_same_offsets() {
        let module = parsed(STEP);
        macro_rules! same {
            ($type:ty, $name:literal, $($field:ident),+) => {
                assert_eq!(offsets(&module, $name), (vec![$(offset_of!($type, $field)),+], size_of::<$type>()), $name);
            };
        }
        same!(
            Params,
            "Params",
            size,
            points,
            gravity,
            dt,
            cell,
            inverse_cell,
            pic,
            damping,
            mass_floor,
            zero,
            cells,
            nodes,
            blocks,
            crowd,
            point_groups,
            cell_groups,
            platens,
            walls,
            drives
        );
        same!(Drive32, "Drive", kind, value, gain, limit);
        same!(
            Platen32, "Platen", axis, normal, cell, units, rest, modulus, speed, moved, reaction, stiffness, stored, rate, work,
            work_low, unused_a, unused_b
        );
        same!(Evolution32, "Evolution", kind, initial, last, strain, cubic, peak_strain, peak, residual, decay);
        same!(
            Law32,
            "Law",
            kind,
            cone,
            bulk,
            shear,
            volume_return,
            per_multiplier,
            cut,
            settled,
            last_alpha,
            last_kappa,
            unused_a,
            unused_b,
            friction,
            cohesion
        );
        same!(Status, "Status", fault, crossed, steps, stop, reaction);
    }
}
