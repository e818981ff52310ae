//! Checks of single fields, by tables: whether a field that must be there is, has its type, and names things there are.
//!
//! What is found refuses the file if something needs the thing, and is noted otherwise; a number out of its range is
//! only noted here, since whoever reads it knows whether it does harm.

use std::fmt;

use serde_json::{Map, Value};

use super::GltfError;
use super::document::{Document, Section};
use super::names::few_digits;
use super::{shapes, together};

/// What a field may hold.
#[derive(Clone, Copy, Debug)]
pub(super) enum Kind {
    Anything,
    Bool,
    Text,
    /// A finite number between these.
    Number(f64, f64),
    /// So many numbers, each between these.
    Numbers(usize, f64, f64),
    /// At least one number.
    SomeNumbers,
    /// A whole number between these.
    Whole(u64, u64),
    /// One of these numbers.
    Code(&'static [u64]),
    /// One of these words.
    Word(&'static [&'static str]),
    /// Should be one of these words, but is not looked at.
    Hint(&'static [&'static str]),
    Index(Section),
    /// At least one index, each once.
    Indices(Section),
    /// An object whose every value is the index of an accessor.
    Attributes,
    Object(Shape),
    /// At least one object.
    Objects(Shape),
    /// At least one object, each with [`Kind::Attributes`].
    Targets,
}

/// One field of an object.
#[derive(Clone, Copy, Debug)]
pub(super) struct Field {
    pub(super) name: &'static str,
    pub(super) kind: Kind,
    pub(super) needed: bool,
}

pub(super) const fn may(name: &'static str, kind: Kind) -> Field {
    Field { name, kind, needed: false }
}

pub(super) const fn must(name: &'static str, kind: Kind) -> Field {
    Field { name, kind, needed: true }
}

/// The fields of an object.
pub(super) type Shape = &'static [Field];

/// One thing that is wrong.
#[derive(Debug)]
pub(super) struct Finding {
    path: String,
    /// The name of the thing, where it has one.
    name: Option<String>,
    problem: String,
    /// It does not refuse the file: nothing reads the field, or its reader copes with it.
    pub(super) harmless: bool,
}

impl fmt::Display for Finding {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        write!(f, "{} is not valid glTF: {}", self.named(), self.problem)
    }
}

impl Finding {
    fn named(&self) -> String {
        match &self.name {
            Some(name) => format!("{} (of '{}')", self.path, super::names::shown(name)),
            None => self.path.clone(),
        }
    }
}

impl From<Finding> for GltfError {
    fn from(finding: Finding) -> Self {
        Self::Invalid { path: finding.named(), problem: finding.problem }
    }
}

/// All that is wrong with the thing at `index`, harmful things first.
pub(super) fn findings(document: &Document, section: Section, index: usize) -> Vec<Finding> {
    let mut checker = Checker { document, name: None, findings: Vec::new() };
    let path = format!("{}[{index}]", section.key());
    match document.section(section).get(index) {
        Some(Value::Object(object)) => {
            checker.name = object.get("name").and_then(Value::as_str).map(str::to_owned);
            checker.object(&path, object, shapes::of(section));
            together::check(section, object, &mut |problem: &str| checker.odd(&path, problem));
        }
        Some(_) => checker.wrong(&path, "must be a JSON object".into()),
        None => {}
    }
    checker.findings.sort_by_key(|finding| finding.harmless);
    checker.findings
}

/// "index 9 is out of bounds: …".
pub(super) fn out_of_bounds(document: &Document, section: Section, index: u64) -> String {
    let count = document.section(section).len();
    format!("index {index} is out of bounds: the file has {count} {} (counted from 0)", section.plural())
}

/// So many findings of one thing are enough.
const MAX_FINDINGS: usize = 20;

struct Checker<'a> {
    document: &'a Document,
    name: Option<String>,
    findings: Vec<Finding>,
}

impl Checker<'_> {
    fn add(&mut self, path: &str, problem: String, harmless: bool) {
        // One that refuses is never lost among those that do not.
        if self.findings.len() < MAX_FINDINGS || !harmless {
            self.findings.push(Finding { path: path.into(), name: self.name.clone(), problem, harmless });
        }
    }

    fn wrong(&mut self, path: &str, problem: String) {
        self.add(path, problem, false);
    }

    fn odd(&mut self, path: &str, problem: &str) {
        self.add(path, problem.into(), true);
    }

    fn object(&mut self, path: &str, object: &Map<String, Value>, shape: Shape) {
        for field in shape {
            match object.get(field.name).filter(|value| !value.is_null()) {
                Some(value) => self.field(&format!("{path}.{}", field.name), value, field.kind),
                None if field.needed => self.wrong(&format!("{path}.{}", field.name), "it is missing".into()),
                None => {}
            }
        }
    }

    fn field(&mut self, path: &str, value: &Value, kind: Kind) {
        let wrong_type = |needed: &str| format!("it is {}; {needed} is needed", brief(value));
        match kind {
            Kind::Anything => {}
            Kind::Bool if value.is_boolean() => {}
            Kind::Bool => self.wrong(path, wrong_type("true or false")),
            Kind::Text if value.is_string() => {}
            Kind::Text => self.wrong(path, wrong_type("text")),
            Kind::Number(least, most) => match value.as_f64() {
                Some(number) => self.range(path, number, least, most),
                None => self.wrong(path, wrong_type("a number")),
            },
            Kind::Numbers(count, least, most) => {
                let numbers: Option<Vec<f64>> =
                    value.as_array().and_then(|all| all.iter().map(Value::as_f64).collect());
                match numbers.filter(|numbers| numbers.len() == count) {
                    Some(numbers) => numbers.iter().for_each(|number| self.range(path, *number, least, most)),
                    None => self.wrong(path, wrong_type(&format!("an array of {count} numbers"))),
                }
            }
            Kind::SomeNumbers => match value.as_array() {
                Some(all) if all.iter().all(Value::is_number) => self.not_empty(path, all),
                _ => self.wrong(path, wrong_type("an array of numbers")),
            },
            Kind::Whole(least, most) => match value.as_u64() {
                Some(number) => self.range(path, number as f64, least as f64, most as f64),
                None => self.wrong(path, wrong_type("a whole number from 0")),
            },
            Kind::Code(codes) => {
                if !value.as_u64().is_some_and(|code| codes.contains(&code)) {
                    let codes: Vec<String> = codes.iter().map(u64::to_string).collect();
                    self.wrong(path, wrong_type(&format!("one of {}", codes.join(", "))));
                }
            }
            Kind::Word(words) | Kind::Hint(words) => {
                if !value.as_str().is_some_and(|word| words.contains(&word)) {
                    let harmless = matches!(kind, Kind::Hint(_));
                    self.add(path, wrong_type(&format!("one of {}", words.join(", "))), harmless);
                }
            }
            Kind::Index(section) => self.index(path, value, section),
            Kind::Indices(section) => match value.as_array() {
                Some(all) => self.indices(path, all, section),
                None => self.wrong(path, wrong_type("an array of indices")),
            },
            Kind::Attributes => match value.as_object() {
                Some(attributes) => self.attributes(path, attributes),
                None => self.wrong(path, wrong_type("a JSON object")),
            },
            Kind::Object(shape) => match value.as_object() {
                Some(object) => self.object(path, object, shape),
                None => self.wrong(path, wrong_type("a JSON object")),
            },
            Kind::Objects(shape) => self.each(path, value, Kind::Object(shape)),
            Kind::Targets => self.each(path, value, Kind::Attributes),
        }
    }

    /// An array of at least one object, each of this kind.
    fn each(&mut self, path: &str, value: &Value, kind: Kind) {
        let Some(all) = value.as_array() else {
            return self.wrong(path, format!("it is {}; an array of JSON objects is needed", brief(value)));
        };
        self.not_empty(path, all);
        for (place, value) in all.iter().enumerate() {
            self.field(&format!("{path}[{place}]"), value, kind);
        }
    }

    fn indices(&mut self, path: &str, all: &[Value], section: Section) {
        self.not_empty(path, all);
        for (place, value) in all.iter().enumerate() {
            self.index(&format!("{path}[{place}]"), value, section);
        }
        let mut seen: Vec<u64> = all.iter().filter_map(Value::as_u64).collect();
        seen.sort_unstable();
        if seen.windows(2).any(|pair| pair[0] == pair[1]) {
            self.odd(path, "it names one thing twice");
        }
    }

    fn attributes(&mut self, path: &str, attributes: &Map<String, Value>) {
        if attributes.is_empty() {
            self.odd(path, "it is empty");
        }
        for (name, value) in attributes {
            let path = format!("{path}[\"{}\"]", super::names::shown(name));
            self.index(&path, value, Section::Accessors);
        }
    }

    fn not_empty(&mut self, path: &str, all: &[Value]) {
        if all.is_empty() {
            self.odd(path, "it is empty");
        }
    }

    fn range(&mut self, path: &str, number: f64, least: f64, most: f64) {
        if !(least <= number && number <= most) {
            let most = if most < 1e15 { format!(" to {most}") } else { String::new() };
            self.odd(path, &format!("it is {}; from {least}{most} is accepted", few_digits(number)));
        }
    }

    fn index(&mut self, path: &str, value: &Value, section: Section) {
        match value.as_u64() {
            Some(index) if (index as usize) < self.document.section(section).len() => {}
            Some(index) => self.wrong(path, out_of_bounds(self.document, section, index)),
            None => self.wrong(path, format!("it is {}; an index is needed", brief(value))),
        }
    }
}

fn brief(value: &Value) -> String {
    match value {
        Value::Object(_) => "an object".into(),
        Value::Array(_) => "an array".into(),
        other => super::names::shown(&other.to_string()).into_owned(),
    }
}
