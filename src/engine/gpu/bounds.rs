//! Numbers that bound arrays and loops both in Rust and in the shaders, written once: `bounds_wgsl!()` is their WGSL, with which every source begins.

macro_rules! bounds {
    ($($(#[$doc:meta])* $name:ident = $value:literal;)*) => {
        $($(#[$doc])* pub const $name: usize = $value;)*

        /// The same constants in WGSL, as a literal that `concat!` takes.
        macro_rules! bounds_wgsl {
            () => {
                concat!($("const ", stringify!($name), ": u32 = ", $value, "u;\n"),*)
            };
        }
        pub(super) use bounds_wgsl;
    };
}

bounds! {
    /// Threads in a workgroup of passes with one thread per point, node or cell, and one workgroup per grain.
    GROUP = 64;
    /// Threads in a workgroup of passes that have one workgroup alone, and of the prefix sum.
    WIDE = 256;
    /// Sides of the domain.
    BORDERS = 6;
    /// Largest number of loading plates.
    PLATES = 6;
    /// Largest number of points in a cell: the sort of more would exceed the number of iterations that software adapters allow in a loop.
    CROWD = 256;
    /// Largest number of contacts of a grain with other grains.
    PARTNERS = 32;
    /// Largest number of walls of the grains.
    SIDES = 8;
    /// Largest number of contacts of a point with grains and walls; and where grains may break, whose daughters are many and small.
    PLACES = 16;
    MANY_PLACES = 32;
    /// Cells of a block of the grid, and its nodes: 4 × 4 × 2.
    BLOCK = 32;
    /// Nodes that the points of a block reach: 6 × 6 × 4.
    TILE = 144;
    /// Columns of a block along z, of two cells each.
    COLUMNS = 16;
    /// Nodes above the columns of a block, each column with its own nine in each of four layers.
    PARTS = 576;
}

/// Number of slots for the contacts of a grain: for other grains, then one for each wall.
pub const SLOTS: usize = PARTNERS + SIDES;

// one thread of a grain's workgroup for each of its slots
const _: () = assert!(SLOTS <= GROUP);
// a thread for each layer of each column
const _: () = assert!(4 * COLUMNS == GROUP && 2 * COLUMNS == BLOCK && PARTS == 36 * COLUMNS);
