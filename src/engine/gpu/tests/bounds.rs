//! Rung 1: no index of a fixed array in the shaders can be beyond its end. A device answers such an index with another element or drops it, silently.
//!
//! The largest value of every whole number is followed through the statements of each function (interval analysis, upper ends alone): a condition that leads to a
//! branch lowers it there, a loop is gone through until nothing grows, a call takes along those of its arguments. What comes from memory may be anything, except the
//! fields in [`LIMITED`], whose limits Rust guarantees. An index below zero is not looked for.

use crate::gpu::bounds::{PLATES, SIDES};
use crate::gpu::shader::{MIXTURE, STEP, tests::parsed};
use std::collections::{BTreeMap, BTreeSet};
use wgpu::naga::{
    self, ArraySize, BinaryOperator as Op, Block, BuiltIn, Expression as E, Function, Handle, Literal, MathFunction, Module,
    Statement as S, TypeInner, UnaryOperator,
    valid::{FunctionInfo, ModuleInfo},
};

/// Fields of the buffers with their largest values: the struct, the field, the value, and what guarantees it.
const LIMITED: [(&str, &str, u64); 3] = [
    // `loading_plate::wrong`
    ("Params", "plates", PLATES as u64),
    // `grains::support::lacking`
    ("Coupling", "walls", SIDES as u64),
    // `Bodies::new`: the first of the walls
    ("Coupling", "point_walls", SIDES as u64),
];

/// Arrays in buffers that functions index by what they read from a buffer: the function, the array, and why it holds.
const FROM_MEMORY: [(&str, &str); 3] = [
    // the loading plate that a wall moves with, or NONE, which is looked for first (`Bodies::new`)
    ("side_speed", "plates"),
    // the wall of a contact: `point_candidates` and the slot of a wall give no others
    ("evaluated", "sides"),
    ("point_contact_forces", "sides"),
];

/// Larger than any 32-bit number: nothing is known.
const ANY: u64 = u64::MAX;

type Key = Handle<E>;
type Variable = Handle<naga::LocalVariable>;

/// Largest values at a place in a function.
#[derive(Clone, Default, PartialEq)]
struct Largest {
    variables: BTreeMap<Variable, u64>,
    expressions: BTreeMap<Key, u64>,
    /// Expressions that are what a variable holds at this place.
    loaded: BTreeMap<Key, Variable>,
}

impl Largest {
    /// What holds where one or the other does.
    fn or(mut self, other: &Largest) -> Largest {
        fn both<K: Ord>(own: &mut BTreeMap<K, u64>, other: &BTreeMap<K, u64>) {
            own.retain(|k, _| other.contains_key(k));
            own.iter_mut().for_each(|(k, most)| *most = other[k].max(*most));
        }
        both(&mut self.variables, &other.variables);
        both(&mut self.expressions, &other.expressions);
        self.loaded.retain(|e, v| other.loaded.get(e) == Some(v));
        self
    }
}

fn either(a: Option<Largest>, b: Option<Largest>) -> Option<Largest> {
    match (a, b) {
        (Some(a), Some(b)) => Some(a.or(&b)),
        (a, b) => a.or(b),
    }
}

/// Ways out of a block but for its end.
#[derive(Default)]
struct Leaving {
    broken: Option<Largest>,
    continued: Option<Largest>,
}

/// What has been found in a module.
#[derive(Default)]
struct Found {
    /// Functions with the arguments with which they have been read.
    seen: BTreeSet<(Handle<Function>, Vec<u64>)>,
    /// Arrays with a length, and the functions that index them.
    indexed: BTreeSet<(String, String)>,
    wrong: BTreeSet<String>,
}

/// Reads one function, with the largest values of its arguments.
struct Reader<'a> {
    module: &'a Module,
    types: &'a ModuleInfo,
    function: &'a Function,
    info: &'a FunctionInfo,
    name: &'a str,
    arguments: Vec<u64>,
    /// Values to which a growing one is raised in a loop: all numbers of the module.
    marks: &'a BTreeSet<u64>,
    found: &'a mut Found,
}

impl Reader<'_> {
    fn inner(&self, e: Key) -> &TypeInner {
        self.info[e].ty.inner_with(&self.module.types)
    }

    /// The type that a pointer points to, or the type itself.
    fn pointed(&self, e: Key) -> &TypeInner {
        match self.inner(e) {
            TypeInner::Pointer { base, .. } => &self.module.types[*base].inner,
            inner => inner,
        }
    }

    /// Struct and field of `base.index`.
    fn field(&self, base: Key, index: u32) -> Option<(&str, &str)> {
        let resolved = &self.info[base].ty;
        let handle = match (resolved.handle(), resolved.inner_with(&self.module.types)) {
            (_, TypeInner::Pointer { base, .. }) => *base,
            (handle, _) => handle?,
        };
        let t = &self.module.types[handle];
        let TypeInner::Struct { members, .. } = &t.inner else { return None };
        Some((t.name.as_deref()?, members[index as usize].name.as_deref()?))
    }

    /// Name of a variable or field.
    fn name_of(&self, e: Key) -> String {
        let name = match &self.function.expressions[e] {
            E::LocalVariable(v) => self.function.local_variables[*v].name.clone(),
            E::GlobalVariable(v) => self.module.global_variables[*v].name.clone(),
            E::AccessIndex { base, index } => self.field(*base, *index).map(|(_, field)| field.to_string()),
            E::Access { base, .. } | E::Load { pointer: base } => Some(self.name_of(*base)),
            _ => self.function.named_expressions.get(&e).cloned(),
        };
        name.unwrap_or_else(|| "a value".into())
    }

    /// The largest value of an expression.
    fn most(&self, e: Key, at: &Largest) -> u64 {
        at.expressions.get(&e).copied().unwrap_or_else(|| self.computed(e, at))
    }

    fn computed(&self, e: Key, at: &Largest) -> u64 {
        let most = |e: &Key| self.most(*e, at);
        let limit = |base: Key, index: u32| {
            let name = self.field(base, index);
            LIMITED.iter().find(|(s, f, _)| Some((*s, *f)) == name).map_or(ANY, |(.., most)| *most)
        };
        match &self.function.expressions[e] {
            E::Literal(l) => whole(l).unwrap_or(ANY),
            E::Constant(c) => match &self.module.global_expressions[self.module.constants[*c].init] {
                E::Literal(l) => whole(l).unwrap_or(ANY),
                _ => ANY,
            },
            E::ZeroValue(_) => 0,
            E::FunctionArgument(k) => self.arguments[*k as usize],
            E::Load { pointer } => match &self.function.expressions[*pointer] {
                E::LocalVariable(v) => at.variables.get(v).copied().unwrap_or(ANY),
                E::AccessIndex { base, index } => limit(*base, *index),
                _ => ANY,
            },
            E::AccessIndex { base, index } => match &self.function.expressions[*base] {
                E::Compose { components, .. } => components.get(*index as usize).map_or(ANY, most),
                _ => limit(*base, *index),
            },
            E::Binary { op, left, right } => {
                let (a, b) = (most(left), most(right));
                let divisor = match &self.function.expressions[*right] {
                    E::Literal(l) => whole(l),
                    E::Constant(_) => Some(b),
                    _ => None,
                };
                match op {
                    _ if a == ANY && !matches!(op, Op::Modulo | Op::And) => ANY,
                    Op::Add => a.saturating_add(b),
                    Op::Multiply => a.saturating_mul(b),
                    Op::Subtract => a.saturating_sub(divisor.unwrap_or(0)),
                    Op::Divide => a / divisor.unwrap_or(1).max(1),
                    Op::Modulo => a.min(divisor.map_or(ANY, |d| d.saturating_sub(1))),
                    Op::And => a.min(b),
                    _ => ANY,
                }
            }
            E::Select { accept, reject, .. } => most(accept).max(most(reject)),
            E::Math { fun: MathFunction::Min, arg, arg1: Some(other), .. } => most(arg).min(most(other)),
            E::Math { fun: MathFunction::Max, arg, arg1: Some(other), .. } => most(arg).max(most(other)),
            E::Math { fun: MathFunction::Clamp, arg2: Some(high), .. } => most(high),
            E::As { expr, convert: Some(_), .. } => most(expr),
            _ => ANY,
        }
    }

    /// Lowers what a value can be, and the variable that it was loaded from.
    fn lower(&self, e: Key, most: u64, at: &mut Largest) {
        let own = self.most(e, at).min(most);
        at.expressions.insert(e, own);
        if let Some(v) = at.loaded.get(&e) {
            at.variables.entry(*v).and_modify(|m| *m = own.min(*m)).or_insert(own);
        }
    }

    /// What holds besides where a condition is `truth`.
    fn assume(&self, condition: Key, truth: bool, at: &mut Largest) {
        match &self.function.expressions[condition] {
            E::Unary { op: UnaryOperator::LogicalNot, expr } => self.assume(*expr, !truth, at),
            E::Binary { op, left, right } => {
                let (a, b) = (self.most(*left, at), self.most(*right, at));
                let below = |most: u64| if most == ANY { ANY } else { most.saturating_sub(1) };
                match (op, truth) {
                    (Op::Less, true) | (Op::GreaterEqual, false) => self.lower(*left, below(b), at),
                    (Op::LessEqual, true) | (Op::Greater, false) => self.lower(*left, b, at),
                    (Op::Greater, true) | (Op::LessEqual, false) => self.lower(*right, below(a), at),
                    (Op::GreaterEqual, true) | (Op::Less, false) => self.lower(*right, a, at),
                    (Op::Equal, true) | (Op::NotEqual, false) => {
                        self.lower(*left, b, at);
                        self.lower(*right, a, at);
                    }
                    (Op::And, true) | (Op::InclusiveOr, false) => {
                        self.assume(*left, truth, at);
                        self.assume(*right, truth, at);
                    }
                    _ => {}
                }
            }
            _ => {}
        }
    }

    /// Compares an index with the length of its array.
    fn check(&mut self, base: Key, index: Key, at: &Largest) {
        let TypeInner::Array { size: ArraySize::Constant(length), .. } = self.pointed(base) else { return };
        let (length, most, array) = (u64::from(length.get()), self.most(index, at), self.name_of(base));
        self.found.indexed.insert((self.name.to_string(), array.clone()));
        let read = most == ANY && FROM_MEMORY.contains(&(self.name, array.as_str()));
        if most >= length && !read {
            let most = if most == ANY { "anything".to_string() } else { most.to_string() };
            self.found.wrong.insert(format!("{}: {array} has {length} elements, its index may be {most}", self.name));
        }
    }

    /// Follows the whole function. Variables without a value at the start are zero.
    fn all(&mut self) {
        let mut start = Largest::default();
        for (v, variable) in self.function.local_variables.iter() {
            let most = variable.init.map_or(0, |e| self.computed(e, &start));
            start.variables.insert(v, most);
        }
        self.block(&self.function.body, start, &mut Leaving::default());
    }

    /// Follows a block; `None`: its end is not reached.
    fn block(&mut self, block: &Block, mut at: Largest, out: &mut Leaving) -> Option<Largest> {
        for statement in block {
            match statement {
                S::Emit(range) => {
                    for e in range.clone() {
                        at.expressions.remove(&e);
                        at.loaded.remove(&e);
                        let most = self.computed(e, &at);
                        at.expressions.insert(e, most);
                        match &self.function.expressions[e] {
                            E::Load { pointer } => {
                                if let E::LocalVariable(v) = &self.function.expressions[*pointer] {
                                    at.loaded.insert(e, *v);
                                }
                            }
                            E::Access { base, index } => self.check(*base, *index, &at),
                            _ => {}
                        }
                    }
                }
                S::Block(inner) => at = self.block(inner, at, out)?,
                S::If { condition, accept, reject } => {
                    let [yes, no] = [(accept, true), (reject, false)].map(|(branch, truth)| {
                        let mut there = at.clone();
                        self.assume(*condition, truth, &mut there);
                        self.block(branch, there, out)
                    });
                    at = either(yes, no)?;
                }
                S::Loop { body, continuing, break_if } => at = self.repeated(body, continuing, *break_if, at, out)?,
                S::Break => {
                    out.broken = either(out.broken.take(), Some(at));
                    return None;
                }
                S::Continue => {
                    out.continued = either(out.continued.take(), Some(at));
                    return None;
                }
                S::Return { .. } => return None,
                S::Store { pointer, value } => {
                    if let E::LocalVariable(v) = &self.function.expressions[*pointer] {
                        let most = self.most(*value, &at);
                        at.variables.insert(*v, most);
                        at.loaded.retain(|_, of| of != v);
                    }
                }
                S::Call { function, arguments, .. } => {
                    let given: Vec<u64> = arguments.iter().map(|e| self.most(*e, &at)).collect();
                    let pointer = |e: &Key| matches!(self.inner(*e), TypeInner::Pointer { .. });
                    assert!(!arguments.iter().any(pointer), "{}: pointers as arguments are not followed", self.name);
                    read(self.module, self.types, *function, given, self.marks, self.found);
                }
                S::Switch { .. } => panic!("{}: `switch` is not followed", self.name),
                S::Kill => return None,
                _ => {}
            }
        }
        Some(at)
    }

    /// Follows a loop until nothing grows; returns what holds after it.
    fn repeated(
        &mut self,
        body: &Block,
        continuing: &Block,
        break_if: Option<Key>,
        start: Largest,
        out: &mut Leaving,
    ) -> Option<Largest> {
        let mut head = start;
        loop {
            let mut own = Leaving::default();
            let end = self.block(body, head.clone(), &mut own);
            let mut back = either(end, own.continued.take());
            if let Some(there) = back {
                back = self.block(continuing, there, out);
            }
            let mut after = own.broken;
            if let (Some(condition), Some(there)) = (break_if, &back) {
                let mut ended = there.clone();
                self.assume(condition, true, &mut ended);
                after = either(after, Some(ended));
            }
            let Some(back) = back else { return after };
            let mut next = head.clone().or(&back);
            for (v, most) in &mut next.variables {
                if *most > head.variables[v] {
                    *most = self.marks.range(*most..).next().copied().unwrap_or(ANY);
                }
            }
            if next == head {
                return after;
            }
            head = next;
        }
    }
}

/// The value of a whole number; one below zero counts as zero.
fn whole(literal: &Literal) -> Option<u64> {
    match *literal {
        Literal::U32(x) => Some(x.into()),
        Literal::I32(x) => Some(x.max(0) as u64),
        _ => None,
    }
}

/// Reads a function with these largest values of its arguments, unless that has been done.
fn read(
    module: &Module,
    types: &ModuleInfo,
    handle: Handle<Function>,
    arguments: Vec<u64>,
    marks: &BTreeSet<u64>,
    found: &mut Found,
) {
    if !found.seen.insert((handle, arguments.clone())) {
        return;
    }
    let function = &module.functions[handle];
    let name = function.name.as_deref().unwrap_or_default();
    Reader { module, types, function, info: &types[handle], name, arguments, marks, found }.all();
}

/// Follows all entry points of a source.
fn follow(source: &str) -> Found {
    let module = parsed(source);
    let mut validator = naga::valid::Validator::new(naga::valid::ValidationFlags::all(), naga::valid::Capabilities::empty());
    let types = validator.validate(&module).unwrap_or_else(|e| panic!("{}", e.emit_to_string(source)));
    let mut marks: BTreeSet<u64> = [ANY].into();
    let functions = module.functions.iter().map(|(_, f)| f).chain(module.entry_points.iter().map(|e| &e.function));
    for e in functions.flat_map(|f| f.expressions.iter()).chain(module.global_expressions.iter()).map(|(_, e)| e) {
        marks.extend(if let E::Literal(l) = e { whole(l) } else { None });
    }
    let mut found = Found::default();
    for (k, entry) in module.entry_points.iter().enumerate() {
        let threads = entry.workgroup_size.iter().map(|n| u64::from(*n)).product::<u64>();
        let most = |a: &naga::FunctionArgument| match a.binding {
            Some(naga::Binding::BuiltIn(BuiltIn::LocalInvocationIndex)) => threads - 1,
            _ => ANY,
        };
        let (function, info) = (&entry.function, types.get_entry_point(k));
        let arguments = function.arguments.iter().map(most).collect();
        let (module, types, marks, found) = (&module, &types, &marks, &mut found);
        Reader { module, types, function, info, name: &entry.name, arguments, marks, found }.all();
    }
    found
}

/// All indices of fixed arrays in both sources stay within them.
#[test]
fn no_index_is_beyond_its_array() {
    for (source, functions) in [(STEP, 8), (MIXTURE, 16)] {
        let found = follow(source);
        println!("{:?}", found.indexed);
        assert!(found.wrong.is_empty(), "{:#?}", found.wrong);
        assert!(found.indexed.len() > functions, "{:?}", found.indexed);
    }
}

/// The test finds arrays that are too short, and guards and workgroups that are too large; the first of them lost contacts of points silently.
#[test]
fn an_array_that_is_too_short_is_found() {
    for (of, instead, function, array) in [
        ("var found: array<u32, ROW_PLACES>", "var found: array<u32, 8>", "point_candidates", "found"),
        ("var found: array<u32, PARTNERS>", "var found: array<u32, 8>", "grain_candidates", "found"),
        ("if n < ROW_PLACES {", "if n <= ROW_PLACES {", "point_candidates", "found"),
        ("slot_forces: array<vec4<f32>, SLOTS>", "slot_forces: array<vec4<f32>, PARTNERS>", "grain_forces", "slot_forces"),
        ("slot_torques: array<vec4<f32>, SLOTS>", "slot_torques: array<vec4<f32>, 39>", "grain_forces", "slot_torques"),
        ("forces: array<vec4<f32>, GROUP>", "forces: array<vec4<f32>, 32>", "grain_forces", "forces"),
        ("shared_sums: array<u32, WIDE>", "shared_sums: array<u32, GROUP>", "before", "shared_sums"),
        ("partial_sums: array<vec4<f32>, WIDE>", "partial_sums: array<vec4<f32>, 255>", "plain_total", "partial_sums"),
        (
            "@compute @workgroup_size(WIDE)\nfn step_bound",
            "@compute @workgroup_size(512)\nfn step_bound",
            "step_bound",
            "partial_sums",
        ),
        ("sides: array<Side, SIDES>", "sides: array<Side, 7>", "advance_time", "sides"),
        ("plates: array<LoadingPlate, PLATES>", "plates: array<LoadingPlate, 5>", "drive_plates", "plates"),
    ] {
        assert!(MIXTURE.contains(of), "{of}");
        let found = follow(&MIXTURE.replace(of, instead));
        let start = format!("{function}: {array} has ");
        assert!(found.wrong.iter().any(|w| w.starts_with(&start)), "{instead}: {:?}", found.wrong);
    }
}
