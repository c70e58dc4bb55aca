//! The vocabulary of scene and material files: what a key may hold, its default, and how it is refused.
//!
//! A key that holds a dimension ends in its unit (`_mm`, `_kPa`, `_rad`, …); see [`unit`] for the one conversion.

pub use engine::parameter::Range;
use toml::Value;

/// Which scenes a key belongs to; of a scene: its kind, `Every` while it is not known.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Of {
    Every,
    /// All but continua.
    Grains,
    /// Assemblies of grains: all but platens and continua.
    Both,
    /// All but platens.
    States,
    /// Tests of a cylindrical specimen.
    Cylinder,
    /// Tests of a specimen of grains, and continua and mixtures, which may be tested.
    Tests,
    /// Compression by stages of stress.
    Compression,
    Oedometer,
    Triaxial,
    Isotropic,
    Assembly,
    GrainCrushing,
    Continuum,
    /// Grains in a continuum; every key of continua is one of theirs too.
    Mixture,
    /// Scenes in which fines from crushing can become points.
    Fines,
    /// Scenes that list grains and walls.
    Listed,
    /// Free scenes of grains, continua, and both.
    Free,
    /// Scenes whose specimen can be read from a file.
    Prepared,
}

/// The kinds of scenes: the word for each in files, and what a message calls it.
const KINDS: [(Of, &str, &str); 7] = [
    (Of::Oedometer, "oedometer", "an oedometer"),
    (Of::Triaxial, "triaxial", "a triaxial test"),
    (Of::Isotropic, "isotropic", "isotropic compression"),
    (Of::Assembly, "assembly", "an assembly"),
    (Of::GrainCrushing, "platen", "a platen test"),
    (Of::Continuum, "continuum", "a continuum"),
    (Of::Mixture, "mixture", "a mixture"),
];

/// The words of [`KINDS`].
pub const KIND_WORDS: [&str; KINDS.len()] = {
    let mut words = [""; KINDS.len()];
    let mut k = 0;
    while k < KINDS.len() {
        words[k] = KINDS[k].1;
        k += 1;
    }
    words
};

impl Of {
    /// The kind of scene of this word, or every kind where there is none.
    pub fn kind(word: Option<&str>) -> Of {
        KINDS.iter().find(|(_, own, _)| word == Some(*own)).map_or(Of::Every, |(kind, ..)| *kind)
    }

    /// What a message calls a scene of this kind.
    pub fn called(self) -> &'static str {
        KINDS.iter().find(|(kind, ..)| *kind == self).map_or("a scene", |(.., name)| name)
    }

    /// Whether a key of this kind may stand in a scene of that one.
    pub fn fits(self, scene: Of) -> bool {
        match (self, scene) {
            (Of::Every, _) | (_, Of::Every) => true,
            (Of::Grains, kind) => kind != Of::Continuum,
            (Of::Both, kind) => !matches!(kind, Of::GrainCrushing | Of::Continuum),
            (Of::States, kind) => kind != Of::GrainCrushing,
            (Of::Continuum, kind) => matches!(kind, Of::Continuum | Of::Mixture),
            (Of::Fines, kind) => matches!(kind, Of::Oedometer | Of::Mixture),
            (Of::Listed, kind) => matches!(kind, Of::Assembly | Of::Mixture),
            (Of::Free, kind) => matches!(kind, Of::Assembly | Of::Continuum | Of::Mixture),
            (Of::Cylinder, kind) => matches!(kind, Of::Oedometer | Of::Triaxial | Of::Isotropic),
            (Of::Tests, kind) => Of::Continuum.fits(kind) || Of::Cylinder.fits(kind),
            (Of::Prepared, kind) => kind == Of::Mixture || Of::Cylinder.fits(kind),
            (Of::Compression, kind) => matches!(kind, Of::Oedometer | Of::Isotropic),
            (own, kind) => own == kind,
        }
    }
}

/// Larger magnitudes are refused: squares and cubes of them must stay finite in SI units.
const LARGEST: f64 = 1e15;
/// Smaller magnitudes are what rounding leaves of a zero (a cosine of 90° is 6e-17): they are taken as 0 where 0 is allowed and refused elsewhere.
const SMALLEST: f64 = 1e-15;

/// What a key may hold.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Shape {
    Number(Range),
    /// A number, or this word.
    NumberOr(Range, &'static str),
    Integer {
        low: i64,
        high: i64,
    },
    Flag,
    Text,
    /// Text that can name a folder.
    Name,
    Choice(&'static [&'static str]),
    /// A list of numbers; with a count when it must have one.
    Numbers(Range, Option<usize>),
    /// A list of pairs of numbers.
    Points,
    /// A list of whole numbers from 0.
    Indices,
    /// A list of whole numbers from 0, or this word.
    IndicesOr(&'static str),
    /// A list of some of these words.
    Words(&'static [&'static str]),
}

/// What stands in for a key that is not written.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Default {
    Required,
    /// Nothing: the key may be absent.
    Absent,
    /// A TOML literal.
    Is(&'static str),
    /// TOML literals for an oedometer, an assembly and platens.
    ByKind(&'static str, &'static str, &'static str),
}

/// A key of a scene; those of a material begin with `material.`.
#[derive(Clone, Copy, Debug)]
pub struct Key {
    /// Dotted path; `grain.` and `wall.` stand for each entry of a list.
    pub path: &'static str,
    /// The values that are allowed.
    pub shape: Shape,
    /// The value where the key is not written.
    pub default: Default,
    /// The kinds of scenes that have the key.
    pub of: Of,
    /// Meaning.
    pub what: &'static str,
}

impl Key {
    /// The table the key stands in and its own name.
    pub fn split(&self) -> (&'static str, &'static str) {
        self.path.rsplit_once('.').unwrap_or(("", self.path))
    }

    /// The default for a kind of scene.
    pub fn default_for(&self, kind: Of) -> Option<Value> {
        let literal = match self.default {
            Default::Is(text) => text,
            Default::ByKind(oedometer, free, platen) => match kind {
                Of::Assembly | Of::Continuum | Of::Mixture => free,
                Of::GrainCrushing => platen,
                _ => oedometer,
            },
            Default::Required | Default::Absent => return None,
        };
        parse_literal(literal)
    }

    /// What stands in for the key where it is not written, in words.
    pub fn default_text(&self) -> String {
        match self.default {
            Default::Required => "required".into(),
            Default::Absent => "optional".into(),
            Default::Is(value) => format!("default {value}"),
            Default::ByKind(test, free, _) if self.of == Of::States => {
                format!("default {test}, in an assembly and a continuum {free}")
            }
            Default::ByKind(test, free, platen) if test == free => format!("default {test}, between platens {platen}"),
            Default::ByKind(test, free, _) => format!("default {test}, in an assembly {free}"),
        }
    }

    /// Kinds of scenes in which the key may stand, with commas between; empty for all.
    pub fn scenes(&self) -> String {
        if self.of == Of::Every {
            return String::new();
        }
        let words: Vec<&str> = KINDS.iter().filter(|(kind, ..)| self.of.fits(*kind)).map(|(_, word, _)| *word).collect();
        words.join(", ")
    }
}

/// A TOML value from its text.
pub fn parse_literal(text: &str) -> Option<Value> {
    let mut table: toml::Table = toml::from_str(&format!("v = {text}")).ok()?;
    if table.len() != 1 {
        return None;
    }
    table.remove("v")
}

/// SI value of one unit of `key`, read from its suffix; 1 without one.
pub fn unit(key: &str) -> f64 {
    const DEGREE: f64 = std::f64::consts::PI / 180.0;
    const SUFFIXES: [(&str, f64); 5] = [("_mm", 1e-3), ("_kPa", 1e3), ("_MPa", 1e6), ("_GPa", 1e9), ("_deg", DEGREE)];
    SUFFIXES.iter().find(|(suffix, _)| key.ends_with(suffix)).map_or(1.0, |(_, si)| *si)
}

impl Shape {
    /// The value in its canonical form (whole numbers become decimals where a decimal is meant), or what is allowed.
    pub fn accept(&self, value: Value) -> Result<Value, String> {
        match (self, value) {
            (Shape::Number(range), v) => number(&v, range).map(Value::Float),
            (Shape::NumberOr(_, word), Value::String(s)) if s == *word => Ok(Value::String(s)),
            (Shape::NumberOr(range, word), v) => number(&v, range).map(Value::Float).map_err(|m| format!("{m}, or \"{word}\"")),
            (Shape::Integer { low, high }, v) => integer(&v, *low, *high).map(Value::Integer),
            (Shape::Flag, Value::Boolean(b)) => Ok(Value::Boolean(b)),
            (Shape::Flag, _) => Err("must be true or false".into()),
            (Shape::Text, Value::String(s)) => Ok(Value::String(s)),
            (Shape::Text, _) => Err("must be text in quotes".into()),
            (Shape::Name, Value::String(s)) if names_a_folder(&s) => Ok(Value::String(s)),
            (Shape::Name, _) => Err("must be text of letters, digits, '-', '_' and '.', not beginning with '.'".into()),
            (Shape::Choice(words), Value::String(s)) if words.contains(&s.as_str()) => Ok(Value::String(s)),
            (Shape::Choice(words), v) => Err(choice(words, &v)),
            (Shape::Numbers(range, count), v) => numbers(v, range, *count),
            (Shape::Points, v) => points(v),
            (Shape::Indices, v) => indices(v).ok_or("must be a list of whole numbers from 0".into()),
            (Shape::IndicesOr(word), Value::String(s)) if s == *word => Ok(Value::String(s)),
            (Shape::Words(words), v) => listed(words, v),
            (Shape::IndicesOr(word), v) => indices(v).ok_or(format!("must be a list of grain numbers from 0, or \"{word}\"")),
        }
    }

    /// What is allowed, for the key reference.
    pub fn text(&self) -> String {
        let ranged = |kind: &str, range: &Range| format!("{kind} {}", range.text());
        match self {
            Shape::Number(r) => ranged("number", r).trim_end().into(),
            Shape::NumberOr(r, word) => format!("{} or \"{word}\"", ranged("number", r)),
            Shape::Integer { low, .. } => format!("whole number >= {low}"),
            Shape::Flag => "true or false".into(),
            Shape::Text => "text".into(),
            Shape::Name => "name".into(),
            Shape::Choice(words) => words.join(" | "),
            Shape::Numbers(_, Some(n)) => format!("list of {n} numbers"),
            Shape::Numbers(r, None) => ranged("list of numbers", r).trim_end().into(),
            Shape::Points => "list of [number, number]".into(),
            Shape::Indices => "list of whole numbers from 0".into(),
            Shape::Words(words) => format!("list of {}", words.join(", ")),
            Shape::IndicesOr(word) => format!("list of grain numbers, or \"{word}\""),
        }
    }
}

fn number(value: &Value, range: &Range) -> Result<f64, String> {
    let x = match value {
        Value::Float(x) => *x,
        Value::Integer(i) => *i as f64,
        _ => return Err(format!("must be a number {}", range.text()).trim_end().into()),
    };
    if !x.is_finite() {
        return Err("must be a finite number".into());
    }
    let noise = x != 0.0 && x.abs() < SMALLEST;
    if noise && range.holds(0.0) {
        return Ok(0.0);
    }
    if !range.holds(x) {
        return Err(format!("must be {}", range.text()));
    }
    if x.abs() > LARGEST {
        return Err(format!("must not be larger than {LARGEST:e}"));
    }
    if noise {
        return Err(format!("must be at least {SMALLEST:e} in size"));
    }
    Ok(x)
}

fn integer(value: &Value, low: i64, high: i64) -> Result<i64, String> {
    let limit = if high == i64::MAX { format!(">= {low}") } else { format!(">= {low} and <= {high}") };
    match value {
        Value::Integer(i) if (low..=high).contains(i) => Ok(*i),
        Value::Integer(_) => Err(format!("must be {limit}")),
        _ => Err(format!("must be a whole number {limit}")),
    }
}

fn numbers(value: Value, range: &Range, count: Option<usize>) -> Result<Value, String> {
    let wanted = match count {
        Some(n) => format!("a list of {n} numbers {}", range.text()),
        None => format!("a list of numbers {}", range.text()),
    };
    let wanted = format!("must be {}", wanted.trim_end());
    let Value::Array(list) = value else {
        return Err(wanted);
    };
    if count.is_some_and(|n| n != list.len()) {
        return Err(format!("{wanted}; it has {}", list.len()));
    }
    let mut out = Vec::with_capacity(list.len());
    for (i, item) in list.iter().enumerate() {
        let x = number(item, range).map_err(|m| format!("{wanted}; entry {} {m}", i + 1))?;
        out.push(Value::Float(x));
    }
    Ok(Value::Array(out))
}

fn points(value: Value) -> Result<Value, String> {
    const WANTED: &str = "must be a list of pairs of numbers, [[x, y], …]";
    let Value::Array(list) = value else {
        return Err(WANTED.into());
    };
    list.into_iter()
        .enumerate()
        .map(|(i, pair)| numbers(pair, &Range::ANY, Some(2)).map_err(|m| format!("{WANTED}; entry {} {m}", i + 1)))
        .collect::<Result<Vec<_>, _>>()
        .map(Value::Array)
}

fn indices(value: Value) -> Option<Value> {
    let Value::Array(list) = value else {
        return None;
    };
    let whole = |v: &Value| matches!(v, Value::Integer(i) if (0..=u32::MAX as i64).contains(i));
    list.iter().all(whole).then_some(Value::Array(list))
}

fn listed(words: &[&str], value: Value) -> Result<Value, String> {
    let wanted = || format!("must be a list of some of \"{}\"", words.join("\", \""));
    let Value::Array(list) = value else { return Err(wanted()) };
    match list.iter().find(|word| !word.as_str().is_some_and(|word| words.contains(&word))) {
        Some(_) => Err(wanted()),
        None => Ok(Value::Array(list)),
    }
}

fn names_a_folder(s: &str) -> bool {
    let plain = |c: char| c.is_alphanumeric() || "-_.+".contains(c);
    !s.is_empty() && s.len() <= 100 && !s.starts_with('.') && s.chars().all(plain)
}

fn choice(words: &[&str], value: &Value) -> String {
    let list: Vec<String> = words.iter().map(|w| format!("\"{w}\"")).collect();
    let mut text = format!("must be {}", list.join(" or "));
    if let Value::String(s) = value
        && let Some(near) = super::suggest::nearest(s, words.iter().copied())
    {
        text += &format!("; did you mean \"{near}\"?");
    }
    text
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn numbers_are_finite_and_in_range() {
        let shape = Shape::Number(Range::POSITIVE);
        assert_eq!(shape.accept(Value::Integer(3)), Ok(Value::Float(3.0)));
        for (bad, says) in [
            (Value::Float(f64::NAN), "finite"),
            (Value::Float(f64::INFINITY), "finite"),
            (Value::Float(0.0), "> 0"),
            (Value::Float(-1.0), "> 0"),
            (Value::Float(1e300), "larger"),
            (Value::Float(1e-300), "at least"),
            (Value::String("5".into()), "number"),
            (Value::Boolean(true), "number"),
        ] {
            let message = shape.accept(bad.clone()).unwrap_err();
            assert!(message.contains(says), "{bad:?}: {message}");
        }
    }

    #[test]
    fn what_rounding_leaves_of_zero_is_zero() {
        let cosine = std::f64::consts::FRAC_PI_2.cos();
        for (shape, noise) in [(Shape::Number(Range::ANY), cosine), (Shape::Number(Range::NOT_NEGATIVE), -1e-17)] {
            assert_eq!(shape.accept(Value::Float(noise)), Ok(Value::Float(0.0)));
        }
        let normal = Shape::Numbers(Range::ANY, Some(3)).accept(parse_literal("[6.1e-17, 0, 1]").unwrap());
        assert_eq!(normal, Ok(parse_literal("[0.0, 0.0, 1.0]").unwrap()));
        let pairs = Shape::Points.accept(parse_literal("[[-6.1e-17, 1]]").unwrap());
        assert_eq!(pairs, Ok(parse_literal("[[0.0, 1.0]]").unwrap()));
    }

    #[test]
    fn lists_say_which_entry_is_wrong() {
        let shape = Shape::Numbers(Range::POSITIVE, None);
        let message = shape.accept(parse_literal("[1, 2, -3]").unwrap());
        assert!(message.unwrap_err().contains("entry 3"));
        let message = Shape::Points.accept(parse_literal("[[1, 2], [3]]").unwrap());
        assert!(message.unwrap_err().contains("entry 2"));
    }

    #[test]
    fn words_are_those_of_the_list() {
        let shape = Shape::Words(&["x", "rotation"]);
        let given = parse_literal("[\"rotation\", \"x\"]").unwrap();
        assert_eq!(shape.accept(given.clone()), Ok(given));
        for bad in ["[\"tilt\"]", "[1]", "\"x\""] {
            let message = shape.accept(parse_literal(bad).unwrap()).unwrap_err();
            assert!(message.contains("a list of some of \"x\", \"rotation\""), "{message}");
        }
    }

    #[test]
    fn a_literal_is_one_value() {
        assert_eq!(parse_literal("1\nb = 2"), None);
        assert_eq!(parse_literal("2000"), Some(Value::Integer(2000)));
    }

    #[test]
    fn suffixes_are_units() {
        assert_eq!(unit("diameter_mm"), 1e-3);
        assert_eq!(unit("G_GPa"), 1e9);
        assert_eq!(unit("radius_m"), 1.0);
    }
}
