//! The operations that `work.rs` counts are those of the shaders: additions, multiplications, divisions and roots are counted in the shaders' own statements.

use crate::gpu::shader::{STEP, tests::plain};
use crate::gpu::work::{ADVANCE, DEPOSIT, ELASTIC, PRESS, STRAIN};
use wgpu::naga::{
    self, BinaryOperator as Op, Block, Expression as E, Function, Literal, MathFunction, Module, ScalarKind, Statement as S,
    TypeInner,
    valid::{FunctionInfo, ModuleInfo},
};

/// Counts in one function.
struct Counter<'a> {
    module: &'a Module,
    types: &'a ModuleInfo,
    function: &'a Function,
    info: &'a FunctionInfo,
}

impl Counter<'_> {
    /// Components of an expression of floating-point numbers; 0 of any other.
    fn width(&self, e: naga::Handle<E>) -> u64 {
        match self.info[e].ty.inner_with(&self.module.types) {
            TypeInner::Scalar(s) if s.kind == ScalarKind::Float => 1,
            TypeInner::Vector { size, scalar } if scalar.kind == ScalarKind::Float => *size as u64,
            TypeInner::Matrix { columns, rows, .. } => *columns as u64 * *rows as u64,
            _ => 0,
        }
    }

    fn expression(&self, e: naga::Handle<E>) -> u64 {
        let columns = |e: naga::Handle<E>| match self.info[e].ty.inner_with(&self.module.types) {
            TypeInner::Matrix { columns, .. } => *columns as u64,
            _ => 1,
        };
        match &self.function.expressions[e] {
            // a matrix and a vector
            E::Binary { op: Op::Multiply, left, .. } if columns(*left) > 1 => (2 * columns(*left) - 1) * self.width(e),
            E::Binary { op: Op::Add | Op::Subtract | Op::Multiply | Op::Divide, .. } => self.width(e),
            E::Math { fun: MathFunction::Sqrt, .. } => self.width(e),
            E::Math { fun: MathFunction::Dot | MathFunction::Length, arg, .. } => 2 * self.width(*arg) - 1,
            _ => 0,
        }
    }

    /// How often a loop is gone through: the whole number that its variable stays below, else once.
    fn rounds(&self, body: &Block) -> u64 {
        let below = |e: naga::Handle<E>| match &self.function.expressions[e] {
            E::Binary { op: Op::Less, right, .. } => match &self.function.expressions[*right] {
                E::Literal(Literal::I32(n)) => Some(*n as u64),
                E::Literal(Literal::U32(n)) => Some(u64::from(*n)),
                _ => None,
            },
            _ => None,
        };
        body.iter()
            .find_map(|s| if let S::If { condition, .. } = s { Some(below(*condition)) } else { None })
            .flatten()
            .unwrap_or(1)
    }

    /// What is done in a block where no condition for a special case holds.
    fn block(&self, block: &Block) -> u64 {
        let of = |statement: &S| match statement {
            S::Emit(range) => range.clone().map(|e| self.expression(e)).sum(),
            S::Block(inner) => self.block(inner),
            S::If { reject, .. } => self.block(reject),
            S::Loop { body, continuing, .. } => self.rounds(body) * (self.block(body) + self.block(continuing)),
            // its branches are laws; without them it is ELASTIC
            S::Call { function, .. } if self.module.functions[*function].name.as_deref() == Some("stress_step") => ELASTIC,
            S::Call { function, .. } => {
                let (called, info) = (&self.module.functions[*function], &self.types[*function]);
                Counter { function: called, info, ..*self }.block(&called.body)
            }
            _ => 0,
        };
        block.iter().map(of).sum()
    }
}

#[test]
fn operations_are_those_of_the_shaders() {
    let module = plain(STEP);
    let mut validator = naga::valid::Validator::new(naga::valid::ValidationFlags::all(), naga::valid::Capabilities::empty());
    let types = validator.validate(&module).expect("valid");
    let in_function = |name: &str| {
        let entry = module.entry_points.iter().position(|e| e.name == name);
        let (function, info) = match entry {
            Some(k) => (&module.entry_points[k].function, types.get_entry_point(k)),
            None => {
                let (handle, function) =
                    module.functions.iter().find(|(_, f)| f.name.as_deref() == Some(name)).expect("a function");
                (function, &types[handle])
            }
        };
        Counter { module: &module, types: &types, function, info }.block(&function.body)
    };
    // three threads of a point have one of its layers of nodes each, in one of their two rounds
    for (name, own, times) in
        [("deposit", DEPOSIT, 1.5), ("press_nodes", PRESS, 1.5), ("advance", ADVANCE, 1.0), ("strain", STRAIN, 1.0)]
    {
        let counted = in_function(name) as f64 * times;
        println!("{name}: {counted:.1} in the shader, {own} in the count");
        assert!((counted / own as f64 - 1.0).abs() < 0.1, "{name}: {counted} and {own}");
    }
}
