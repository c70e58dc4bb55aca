//! The sources of the shaders, put together from their files and the numbers of `bounds.rs`.

use super::bounds::bounds_wgsl;

/// Parts of the shaders for which runs without them shall not pay: software adapters go through both branches of a condition.
#[derive(Clone, Copy)]
pub struct Uses {
    /// Dilation that ends with softening.
    pub mobilised: bool,
    /// Mohr and Coulomb's law.
    pub mohr_coulomb: bool,
    /// Pyramids of Mohr and Coulomb that harden or soften.
    pub changing_pyramids: bool,
    /// Modified Cam-clay.
    pub cam_clay: bool,
    /// A law other than elasticity.
    pub yields: bool,
    /// One law for all points.
    pub one_law: bool,
    /// Walls of the grid.
    pub walls: bool,
    /// One of them with friction.
    pub rubbed: bool,
    /// Loading plates.
    pub pressed: bool,
    /// Loading plates or walls of grains that are shells.
    pub shells: bool,
    /// Contacts of grains that act on the faces of points.
    pub faces: bool,
    /// Grains that may break, whose daughters are many around a point.
    pub crushing: bool,
    /// Points from breakages, whose contacts have overlaps without force.
    pub fines: bool,
}

impl Uses {
    /// A source with these parts.
    pub fn of(self, source: &str) -> String {
        let Uses {
            mobilised,
            mohr_coulomb,
            changing_pyramids,
            cam_clay,
            yields,
            one_law,
            walls,
            rubbed,
            pressed,
            shells,
            faces,
            crushing,
            fines,
        } = self;
        let switches = [
            ("MOBILISED", mobilised),
            ("MOHR_COULOMB", mohr_coulomb),
            ("CHANGING_PYRAMIDS", changing_pyramids),
            ("CAM_CLAY", cam_clay),
            ("YIELDS", yields),
            ("ONE_LAW", one_law),
            ("WALLED", walls),
            ("RUBBED", rubbed),
            ("PRESSED", pressed),
            ("SHELLS", shells),
            ("FACES", faces),
            ("CRUSHING", crushing),
            ("FINES", fines),
        ];
        let switches: String = switches.iter().map(|(name, is)| format!("const {name}: bool = {is};\n")).collect();
        switches + source
    }
}

/// Source for a continuum without grains.
pub const STEP: &str = concat!(
    bounds_wgsl!(),
    include_str!("params.wgsl"),
    include_str!("exact.wgsl"),
    include_str!("mohr_coulomb.wgsl"),
    include_str!("cam_clay.wgsl"),
    include_str!("law.wgsl"),
    include_str!("grains/without_grains.wgsl"),
    include_str!("blocks.wgsl"),
    include_str!("nodes.wgsl"),
    include_str!("tiles.wgsl"),
    include_str!("loading_plates.wgsl"),
    include_str!("walls.wgsl"),
    include_str!("points.wgsl"),
    include_str!("order.wgsl")
);

/// Source for a continuum with grains.
pub const MIXTURE: &str = concat!(
    bounds_wgsl!(),
    include_str!("params.wgsl"),
    include_str!("exact.wgsl"),
    include_str!("mohr_coulomb.wgsl"),
    include_str!("cam_clay.wgsl"),
    include_str!("law.wgsl"),
    include_str!("grains/contact.wgsl"),
    include_str!("blocks.wgsl"),
    include_str!("nodes.wgsl"),
    include_str!("tiles.wgsl"),
    include_str!("loading_plates.wgsl"),
    include_str!("walls.wgsl"),
    include_str!("points.wgsl"),
    include_str!("order.wgsl"),
    include_str!("grains/faces.wgsl"),
    include_str!("grains/point_contacts.wgsl"),
    include_str!("grains/bodies.wgsl")
);

#[cfg(test)]
pub mod tests {
    use super::*;
    use crate::gpu::grains::{Coupling, Mix, Side};
    use crate::gpu::layout::{BatchState, Clay32, Evolution32, Law32, LoadingPlate32, Params, PlateDrive32, Status};
    use std::mem::{offset_of, size_of};
    use wgpu::naga;

    /// Source for tests of the laws alone.
    pub const LAW_TEST: &str = concat!(
        bounds_wgsl!(),
        include_str!("params.wgsl"),
        include_str!("exact.wgsl"),
        include_str!("mohr_coulomb.wgsl"),
        include_str!("cam_clay.wgsl"),
        include_str!("law.wgsl"),
        include_str!("law_test.wgsl")
    );

    /// All parts, and none.
    pub const ALL: Uses = Uses {
        mobilised: true,
        mohr_coulomb: true,
        changing_pyramids: true,
        cam_clay: true,
        yields: true,
        one_law: false,
        walls: true,
        rubbed: true,
        pressed: true,
        shells: true,
        faces: true,
        crushing: true,
        fines: true,
    };
    const NONE: Uses = Uses {
        mobilised: false,
        mohr_coulomb: false,
        changing_pyramids: false,
        cam_clay: false,
        yields: false,
        one_law: true,
        walls: false,
        rubbed: false,
        pressed: false,
        shells: false,
        faces: false,
        crushing: false,
        fines: false,
    };

    /// The module of a source with all parts.
    pub fn parsed(source: &str) -> naga::Module {
        module(source, ALL)
    }

    /// The module of a source without parts that not all runs have.
    pub fn plain(source: &str) -> naga::Module {
        module(source, NONE)
    }

    fn module(source: &str, uses: Uses) -> naga::Module {
        let source = uses.of(source);
        naga::front::wgsl::parse_str(&source).unwrap_or_else(|e| panic!("{}", e.emit_to_string(&source)))
    }

    /// Every source is valid WGSL.
    #[test]
    fn shaders_are_valid() {
        for (source, uses) in [STEP, MIXTURE, LAW_TEST].into_iter().flat_map(|source| [(source, ALL), (source, NONE)]) {
            let module = module(source, uses);
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

    /// Structs have the same fields at the same offsets in Rust and WGSL.
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
            share,
            cell_groups,
            overlaps,
            point_groups,
            steps,
            unused,
            plates,
            safety,
            extents,
            follows,
            blocks,
            block_count,
            slots,
            stride,
            pairs,
            unused_too,
            walls,
            drives
        );
        same!(PlateDrive32, "PlateDrive", kind, value, slope, end, gain, reach, memory, unused);
        same!(
            LoadingPlate32,
            "LoadingPlate",
            axis,
            normal,
            cell,
            units,
            rest,
            modulus,
            speed,
            moved,
            reaction,
            stiffness,
            stored,
            rate,
            work,
            drift,
            overlap,
            way,
            face,
            ways,
            overlaps,
            reactions,
            centre_cell,
            centre_units,
            centre_rest,
            shell,
            split
        );
        // the last field of the struct in WGSL is an array of any length
        let (mut fields, size) = offsets(&module, "BatchState");
        assert_eq!(fields.pop(), Some(size_of::<BatchState>()));
        assert_eq!(size, size_of::<BatchState>() + 16);
        let own = [offset_of!(BatchState, time), offset_of!(BatchState, dt), offset_of!(BatchState, count)];
        assert_eq!(fields[..3], own);
        assert_eq!(fields[3..], [offset_of!(BatchState, sides), offset_of!(BatchState, plates)]);
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
            sin_friction,
            sin_dilation,
            strength,
            apex,
            critical,
            dilation_factor,
            friction,
            cohesion,
            clay
        );
        same!(Clay32, "Clay", slope, swelling_slope, ratio, per_plastic, preconsolidation, virgin_volume, shear_ratio, unused);
        same!(Status, "Status", fault, crossed, steps, stop, fastest, slots, reaction);
        let module = parsed(MIXTURE);
        macro_rules! same {
            ($type:ty, $name:literal, $($field:ident),+) => {
                assert_eq!(offsets(&module, $name), (vec![$(offset_of!($type, $field)),+], size_of::<$type>()), $name);
            };
        }
        same!(
            Coupling,
            "Coupling",
            grains,
            rows,
            walls,
            point_walls,
            materials,
            laws,
            split,
            law,
            rates,
            turning,
            hertz_area,
            crushing,
            skin,
            reach,
            least,
            damping,
            grid,
            grid_cells,
            grid_size,
            quantum,
            fine,
            far,
            tables
        );
        same!(
            Side,
            "Side",
            axis,
            normal,
            cell,
            units,
            rest,
            speed,
            plate,
            reaction,
            stiffness,
            shell,
            work,
            centre_cell,
            centre_units,
            centre_rest,
            split,
            unused
        );
        same!(
            Mix,
            "Mix",
            rows,
            crowded,
            broken,
            lost,
            fastest_point,
            fastest_grain,
            point_rate,
            search,
            travelled,
            point_speed,
            ahead,
            sub,
            grain_rate,
            grain_rate_points,
            fresh,
            contacts_known,
            bound_ratio,
            isolated_bound,
            largest_bound,
            slow,
            furthest,
            wanted,
            sides,
            reactions
        );
    }

    /// Constants have the same values in Rust and WGSL.
    #[test]
    fn constants_are_those_of_the_processor() {
        use crate::gpu::bounds::{
            BLOCK, BORDERS, COLUMNS, GROUP, MANY_PLACES, PARTNERS, PARTS, PLACES, PLATES, SIDES, SLOTS, WIDE,
        };
        use crate::gpu::grains::FURTHEST;
        use crate::gpu::grains::layout::{NO_FACE, NODES, NONE, POINT_CONTACT, WALLS, WITH_FINES};
        use crate::point_contacts::ContactRates;
        use naga::{Expression, Literal};
        let (module, least) = (parsed(MIXTURE), plain(MIXTURE));
        let literal_of = |module: &naga::Module, name: &str| {
            let (_, constant) = module.constants.iter().find(|(_, c)| c.name.as_deref() == Some(name)).expect("a constant");
            let Expression::Literal(literal) = module.global_expressions[constant.init] else { panic!("{name} is a number") };
            literal
        };
        let literal = |name: &str| literal_of(&module, name);
        for (name, value) in [("ROW_PLANES", POINT_CONTACT), ("ROW_PLACES", PLACES)] {
            assert_eq!(literal_of(&least, name), Literal::U32(value as u32), "{name}");
        }
        for (name, value) in [
            ("OF_POINT", ContactRates::END_SHARES[0]),
            ("OF_GRAIN", ContactRates::END_SHARES[1]),
            ("FURTHEST", FURTHEST.into()),
            ("NO_FACE", NO_FACE.into()),
        ] {
            assert_eq!(literal(name), Literal::F32(value as f32), "{name}");
        }
        for (name, value) in [
            ("BLOCK", BLOCK),
            ("COLUMNS", COLUMNS),
            ("GROUP", GROUP),
            ("PARTS", PARTS),
            ("WIDE", WIDE),
            ("BORDERS", BORDERS),
            ("PLATES", PLATES),
            ("PARTNERS", PARTNERS),
            ("SIDES", SIDES),
            ("SLOTS", SLOTS),
            ("PLACES", PLACES),
            ("ROW_PLANES", WITH_FINES),
            ("ROW_PLACES", MANY_PLACES),
            ("NODES", NODES),
            ("WALLS", WALLS as usize),
            ("NONE", NONE as usize),
        ] {
            assert_eq!(literal(name), Literal::U32(value as u32), "{name}");
        }
    }
}
