//! Typed access to the fields of one JSON object, with errors that name object and field.
//!
//! Nodes, cameras, lights, skins and animations are read through it, numbers as f64: transforms and angles keep all
//! their digits.

use serde_json::{Map, Value};

use super::GltfError;
use super::names::shown;

/// One object of an array of the document: node 3, light 0, …
#[derive(Clone, Copy, Debug)]
pub(super) struct Item<'v> {
    pub(super) kind: &'static str,
    pub(super) index: usize,
    name: Option<&'v str>,
    value: &'v Value,
}

impl<'v> Item<'v> {
    pub(super) fn new(kind: &'static str, index: usize, value: &'v Value) -> Result<Self, GltfError> {
        let name = value.get("name").and_then(Value::as_str);
        let item = Self { kind, index, name, value };
        if value.is_object() { Ok(item) } else { Err(item.wrong("", "must be a JSON object")) }
    }

    /// "node 3 'wheel'".
    pub(super) fn label(&self) -> String {
        match self.name {
            Some(name) => format!("{} {} '{}'", self.kind, self.index, shown(name)),
            None => format!("{} {}", self.kind, self.index),
        }
    }

    /// Its name; a sub-object has that of the whole.
    pub(super) fn name(&self) -> Option<&'v str> {
        self.name
    }

    /// The field, unless it is absent or null.
    pub(super) fn get(&self, field: &str) -> Option<&'v Value> {
        self.value.get(field).filter(|value| !value.is_null())
    }

    /// The value of the extension `name`, if the object has it.
    pub(super) fn extension(&self, name: &str) -> Option<&'v Value> {
        self.get("extensions")?.get(name)
    }

    pub(super) fn wrong(&self, field: &str, problem: impl Into<String>) -> GltfError {
        GltfError::Field { item: self.label(), field: field.into(), problem: problem.into() }
    }

    /// The same item seen at one of its sub-objects (`spot` of a light, say), if it has it.
    pub(super) fn inner(&self, field: &str) -> Result<Option<Self>, GltfError> {
        match self.get(field) {
            Some(value) if value.is_object() => Ok(Some(Self { value, ..*self })),
            Some(_) => Err(self.wrong(field, "must be a JSON object")),
            None => Ok(None),
        }
    }

    /// The objects of the array in `field`, seen as this item in errors; empty when the field is absent.
    pub(super) fn objects(&self, field: &str) -> Result<Vec<Self>, GltfError> {
        let Some(value) = self.get(field) else { return Ok(Vec::new()) };
        let values = value.as_array().filter(|values| values.iter().all(Value::is_object));
        let values = values.ok_or_else(|| self.wrong(field, "must be an array of JSON objects"))?;
        Ok(values.iter().map(|value| Self { value, ..*self }).collect())
    }

    pub(super) fn number(&self, field: &str) -> Result<Option<f64>, GltfError> {
        self.get(field)
            .map(|value| value.as_f64().ok_or_else(|| self.wrong(field, "must be a number")))
            .transpose()
    }

    pub(super) fn numbers<const N: usize>(&self, field: &str) -> Result<Option<[f64; N]>, GltfError> {
        let Some(value) = self.get(field) else { return Ok(None) };
        let wrong = || self.wrong(field, format!("must be an array of {N} numbers"));
        let values = value.as_array().filter(|values| values.len() == N).ok_or_else(wrong)?;
        let mut numbers = [0.0; N];
        for (number, value) in numbers.iter_mut().zip(values) {
            *number = value.as_f64().ok_or_else(wrong)?;
        }
        Ok(Some(numbers))
    }

    /// The index in `field`, checked against the `count` things of `kind` there are.
    pub(super) fn index(
        &self,
        field: &str,
        kind: &'static str,
        count: usize,
    ) -> Result<Option<usize>, GltfError> {
        self.get(field).map(|value| self.checked_index(field, value, kind, count)).transpose()
    }

    /// The indices in `field`, each checked; empty when the field is absent.
    pub(super) fn indices(
        &self,
        field: &str,
        kind: &'static str,
        count: usize,
    ) -> Result<Vec<usize>, GltfError> {
        let Some(value) = self.get(field) else { return Ok(Vec::new()) };
        let values = value.as_array().ok_or_else(|| self.wrong(field, "must be an array of indices"))?;
        values.iter().map(|value| self.checked_index(field, value, kind, count)).collect()
    }

    fn checked_index(
        &self,
        field: &str,
        value: &Value,
        kind: &'static str,
        count: usize,
    ) -> Result<usize, GltfError> {
        let index =
            value.as_u64().ok_or_else(|| self.wrong(field, format!("must be the index of a {kind}")))?;
        match usize::try_from(index) {
            Ok(index) if index < count => Ok(index),
            _ => Err(GltfError::IndexOutOfRange {
                item: self.label(),
                field: field.into(),
                kind,
                index,
                count,
            }),
        }
    }

    /// `castShadow` and `receiveShadow` of its `extras` or its `KHR_lights_shadows`.
    pub(super) fn shadow_switches(&self) -> Switches {
        let of =
            |value: Option<&Value>| value.and_then(Value::as_object).map(Switches::of).unwrap_or_default();
        of(self.get("extras")).or(of(self.extension(LIGHTS_SHADOWS)))
    }
}

/// The proposed extension with cast and receive flags.
pub(super) const LIGHTS_SHADOWS: &str = "KHR_lights_shadows";

/// Shadow flags as far as a file states them.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub(super) struct Switches {
    pub(super) casts: Option<bool>,
    pub(super) receives: Option<bool>,
}

impl Switches {
    /// The flags of an object; exporters write the names in the singular, the proposal also in the plural.
    pub(super) fn of(object: &Map<String, Value>) -> Self {
        let flag = |names: [&str; 2]| names.iter().find_map(|name| object.get(*name)?.as_bool());
        Self {
            casts: flag(["castShadow", "castShadows"]),
            receives: flag(["receiveShadow", "receiveShadows"]),
        }
    }

    /// These flags, with `other`'s where these are silent.
    pub(super) fn or(self, other: Self) -> Self {
        Self { casts: self.casts.or(other.casts), receives: self.receives.or(other.receives) }
    }
}
