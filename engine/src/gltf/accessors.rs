//! Accessors: typed streams of numbers in buffers, checked before anything is allocated.

use gltf::json::accessor::{ComponentType, GenericComponentType, Type};
use gltf::json::deserialize::from_value;
use gltf::json::validation::Checked;
use serde_json::{Map, Value};

use super::GltfError;
use super::buffers::{Buffers, whole};
use super::document::{Document, Section};
use super::limits::Budget;

/// The most elements an accessor may have that has no buffer view: nothing else bounds it.
const MAX_COUNT_WITHOUT_VIEW: u64 = 1 << 22;

/// The shape of an accessor's elements, as the format's word says.
fn type_of(declaration: &Map<String, Value>) -> Option<Type> {
    match from_value::<Checked<Type>>(declaration.get("type")?.clone()) {
        Ok(Checked::Valid(known)) => Some(known),
        _ => None,
    }
}

/// The type of an accessor's numbers, as the format's number says.
fn component_type(declaration: &Map<String, Value>) -> Option<ComponentType> {
    match from_value::<Checked<GenericComponentType>>(declaration.get("componentType")?.clone()) {
        Ok(Checked::Valid(GenericComponentType(known))) => Some(known),
        _ => None,
    }
}

/// Reads accessors of one document.
#[derive(Debug)]
pub(super) struct Accessors<'a> {
    pub(super) document: &'a Document,
    pub(super) buffers: Buffers<'a>,
}

/// Where in a buffer view the elements of an accessor lie, in bytes.
#[derive(Clone, Copy, Debug)]
struct Elements {
    offset: u64,
    count: u64,
    stride: usize,
    size: usize,
}

/// An accessor that is read for some purpose, and how many elements of which size in bytes it has.
#[derive(Clone, Copy, Debug)]
struct Stream<'d> {
    accessor: usize,
    purpose: &'static str,
    declaration: &'d Map<String, Value>,
    count: u64,
    size: usize,
}

impl Stream<'_> {
    fn wrong(&self, problem: String) -> GltfError {
        GltfError::Accessor { accessor: self.accessor, purpose: self.purpose, problem }
    }
}

/// How integer components become floats.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum Integers {
    /// As the accessor's `normalized` says.
    AsDeclared,
    /// Always to 0 … 1 or −1 … 1: nothing else makes sense for the stream.
    Normalized,
}

impl Accessors<'_> {
    /// The number of components of each element.
    pub(super) fn width(&self, accessor: usize, purpose: &'static str) -> Result<usize, GltfError> {
        Ok(kind(self.get(accessor, purpose)?, accessor, purpose)?.0.multiplicity())
    }

    /// An accessor of scalars or vectors of `N` components as floats, every one of them finite.
    pub(super) fn floats<const N: usize>(
        &self,
        accessor: usize,
        purpose: &'static str,
        integers: Integers,
        budget: &mut Budget,
    ) -> Result<Vec<[f32; N]>, GltfError> {
        let declaration = self.get(accessor, purpose)?;
        let (found, component) = kind(declaration, accessor, purpose)?;
        if found != vector(N) {
            let problem = format!("it is {found:?}, {:?} is needed", vector(N));
            return Err(GltfError::Accessor { accessor, purpose, problem });
        }
        let normalized =
            declaration.get("normalized") == Some(&Value::Bool(true)) || integers == Integers::Normalized;
        let size = component.size();
        let values = self.read(accessor, purpose, N * size, [0.0; N], budget, |bytes| {
            std::array::from_fn(|i| float(&bytes[i * size..], component, normalized))
        })?;
        if let Some(element) = values.iter().position(|value: &[f32; N]| !value.iter().all(|x| x.is_finite()))
        {
            let problem = format!("element {element} is {:?}; finite numbers are needed", values[element]);
            return Err(GltfError::Accessor { accessor, purpose, problem });
        }
        if component == ComponentType::F32 {
            self.compare_bounds(accessor, declaration, &values);
        }
        Ok(values)
    }

    /// An accessor of unsigned integers.
    pub(super) fn indices(
        &self,
        accessor: usize,
        purpose: &'static str,
        budget: &mut Budget,
    ) -> Result<Vec<u32>, GltfError> {
        let (found, component) = kind(self.get(accessor, purpose)?, accessor, purpose)?;
        let unsigned = matches!(component, ComponentType::U8 | ComponentType::U16 | ComponentType::U32);
        if found != Type::Scalar || !unsigned {
            let problem = format!("it is {found:?} of {component:?}; Scalar of U8, U16 or U32 is needed");
            return Err(GltfError::Accessor { accessor, purpose, problem });
        }
        self.read(accessor, purpose, component.size(), 0, budget, |bytes| unsigned_at(bytes, component))
    }

    /// An accessor of four joints for each element.
    pub(super) fn joints(
        &self,
        accessor: usize,
        purpose: &'static str,
        budget: &mut Budget,
    ) -> Result<Vec<[u16; 4]>, GltfError> {
        let (found, component) = kind(self.get(accessor, purpose)?, accessor, purpose)?;
        if found != Type::Vec4 || !matches!(component, ComponentType::U8 | ComponentType::U16) {
            let problem = format!("it is {found:?} of {component:?}; Vec4 of U8 or U16 is needed");
            return Err(GltfError::Accessor { accessor, purpose, problem });
        }
        let size = component.size();
        self.read(accessor, purpose, 4 * size, [0; 4], budget, |bytes| {
            std::array::from_fn(|i| unsigned_at(&bytes[i * size..], component) as u16)
        })
    }

    /// An accessor of 4×4 matrices of floats, column after column.
    pub(super) fn matrices(
        &self,
        accessor: usize,
        purpose: &'static str,
        budget: &mut Budget,
    ) -> Result<Vec<[f32; 16]>, GltfError> {
        let (found, component) = kind(self.get(accessor, purpose)?, accessor, purpose)?;
        if found != Type::Mat4 || component != ComponentType::F32 {
            let problem = format!("it is {found:?} of {component:?}; Mat4 of F32 is needed");
            return Err(GltfError::Accessor { accessor, purpose, problem });
        }
        self.floats::<16>(accessor, purpose, Integers::AsDeclared, budget)
    }

    fn get(&self, accessor: usize, purpose: &'static str) -> Result<&Map<String, Value>, GltfError> {
        let count = self.document.accessors.len();
        if accessor >= count {
            let (item, field) = (purpose.into(), "accessor".into());
            return Err(GltfError::IndexOutOfRange {
                item,
                field,
                kind: "accessor",
                index: accessor as u64,
                count,
            });
        }
        self.document.used(Section::Accessors, accessor)
    }

    /// Whether an accessor says between which values its elements lie.
    pub(super) fn has_bounds(&self, accessor: usize) -> bool {
        let value = self.document.accessors.get(accessor);
        value.is_some_and(|value| value.get("min").is_some() && value.get("max").is_some())
    }

    /// Whether an accessor has any values of its own; all others are zero.
    pub(super) fn has_data(&self, accessor: usize) -> bool {
        let value = self.document.accessors.get(accessor);
        value.is_some_and(|value| value.get("bufferView").is_some() || value.get("sparse").is_some())
    }

    /// Notes bounds that are not the values'; nothing here relies on them.
    fn compare_bounds<const N: usize>(
        &self,
        accessor: usize,
        declaration: &Map<String, Value>,
        values: &[[f32; N]],
    ) {
        for (field, of) in [("min", f32::min as fn(f32, f32) -> f32), ("max", f32::max)] {
            let Some(declared) = declaration.get(field).and_then(Value::as_array) else { continue };
            let found: [f32; N] = values
                .iter()
                .skip(1)
                .fold(values[0], |found, value| std::array::from_fn(|i| of(found[i], value[i])));
            let size = found.iter().fold(1e-6, |size: f64, x| size.max(f64::from(x.abs())));
            // Exporters write them with fewer digits than the values have.
            let differs = |(declared, found): (&Value, &f32)| {
                declared.as_f64().is_none_or(|declared| (declared - f64::from(*found)).abs() > 1e-3 * size)
            };
            if declared.len() != N || declared.iter().zip(&found).any(differs) {
                self.document.note(format!(
                    "accessor {accessor}: its '{field}' is not that of its values, and not used"
                ));
            }
        }
    }

    /// Base values, then sparse ones over them.
    fn read<T: Copy>(
        &self,
        accessor: usize,
        purpose: &'static str,
        size: usize,
        zero: T,
        budget: &mut Budget,
        parse: impl Fn(&[u8]) -> T,
    ) -> Result<Vec<T>, GltfError> {
        let declaration = self.get(accessor, purpose)?;
        let stream = Stream { accessor, purpose, declaration, count: whole(declaration, "count"), size };
        if stream.count == 0 {
            return Err(stream.wrong("it is empty; at least 1 element is needed".into()));
        }
        let mut values = self.base_values(&stream, zero, budget, &parse)?;
        if let Some(sparse) = declaration.get("sparse").and_then(Value::as_object) {
            self.replace_sparse(&stream, sparse, &mut values, budget, &parse)?;
        }
        Ok(values)
    }

    /// The values of the accessor's buffer view; zeros where it has none.
    fn base_values<T: Copy>(
        &self,
        stream: &Stream<'_>,
        zero: T,
        budget: &mut Budget,
        parse: impl Fn(&[u8]) -> T,
    ) -> Result<Vec<T>, GltfError> {
        let Stream { accessor, purpose, declaration, count, size } = *stream;
        let Some(view) = declaration.get("bufferView").and_then(Value::as_u64) else {
            if count > MAX_COUNT_WITHOUT_VIEW {
                let what = format!("accessor {accessor} ({purpose}): elements without a buffer view");
                return Err(GltfError::TooLarge { what, count, limit: MAX_COUNT_WITHOUT_VIEW });
            }
            budget.charge_elements(count)?;
            return Ok(vec![zero; count as usize]);
        };
        let view = view as usize;
        let declared = self.document.used(Section::BufferViews, view)?;
        let stride =
            declared.get("byteStride").and_then(Value::as_u64).map_or(size, |stride| stride as usize);
        if stride < size {
            let problem = format!("its buffer view's byteStride {stride} is below its elements' {size}");
            return Err(stream.wrong(problem));
        }
        let offset = whole(declaration, "byteOffset");
        let bytes = self.range(accessor, view, Elements { offset, count, stride, size }, budget)?;
        budget.charge_elements(count)?;
        Ok(bytes.chunks(stride).map(parse).collect())
    }

    /// Puts sparse values in their places.
    fn replace_sparse<T: Copy>(
        &self,
        stream: &Stream<'_>,
        sparse: &Map<String, Value>,
        values: &mut [T],
        budget: &mut Budget,
        parse: impl Fn(&[u8]) -> T,
    ) -> Result<(), GltfError> {
        let Stream { accessor, count: most, size, .. } = *stream;
        let count = whole(sparse, "count");
        if count == 0 || count > most {
            return Err(stream.wrong(format!("it has {count} sparse values; 1 to {most} are needed")));
        }
        // Both objects are there: the accessor's fields were checked.
        let nothing = Map::new();
        let inner = |field: &str| sparse.get(field).and_then(Value::as_object).unwrap_or(&nothing);
        let (indices, replaced) = (inner("indices"), inner("values"));
        let Some(component) = component_type(indices) else {
            return Err(stream.wrong("its sparse indices have no valid component type".into()));
        };
        let mut part = |object: &Map<String, Value>, size| {
            let (view, offset) = (whole(object, "bufferView") as usize, whole(object, "byteOffset"));
            self.range(accessor, view, Elements { offset, count, stride: size, size }, budget)
        };
        let (places, replaced) = (part(indices, component.size())?, part(replaced, size)?);
        let mut previous = None;
        for (place, bytes) in places.chunks_exact(component.size()).zip(replaced.chunks_exact(size)) {
            let place = unsigned_at(place, component);
            if previous.is_some_and(|previous| place <= previous) || u64::from(place) >= most {
                return Err(stream.wrong(format!(
                    "its sparse index {place} is not above the one before it and below {most}"
                )));
            }
            values[place as usize] = parse(bytes);
            previous = Some(place);
        }
        Ok(())
    }

    /// The bytes from the first element to the end of the last, checked to lie in the view.
    fn range(
        &self,
        accessor: usize,
        view: usize,
        Elements { offset, count, stride, size }: Elements,
        budget: &mut Budget,
    ) -> Result<&[u8], GltfError> {
        let bytes = self.buffers.view(view, budget)?;
        let length = (u128::from(count) - 1) * stride as u128 + size as u128;
        let needed = u128::from(offset) + length;
        if needed > bytes.len() as u128 {
            let available = bytes.len();
            return Err(GltfError::AccessorRange { accessor, needed, view, available });
        }
        Ok(&bytes[offset as usize..needed as usize])
    }
}

fn kind(
    declaration: &Map<String, Value>,
    accessor: usize,
    purpose: &'static str,
) -> Result<(Type, ComponentType), GltfError> {
    let found = type_of(declaration);
    found.zip(component_type(declaration)).ok_or_else(|| {
        let problem = "its type or componentType is unknown".into();
        GltfError::Accessor { accessor, purpose, problem }
    })
}

/// How many components an accessor's elements have, and the bytes of each.
pub(super) fn element_bytes(declaration: &Map<String, Value>) -> Option<(usize, usize)> {
    let found = type_of(declaration)?;
    Some((found.multiplicity(), component_type(declaration)?.size()))
}

fn vector(components: usize) -> Type {
    match components {
        1 => Type::Scalar,
        2 => Type::Vec2,
        3 => Type::Vec3,
        4 => Type::Vec4,
        _ => Type::Mat4,
    }
}

/// The component at the start of `bytes`, which hold at least its size.
fn float(bytes: &[u8], component: ComponentType, normalized: bool) -> f32 {
    let (value, largest) = match component {
        ComponentType::F32 => return f32::from_le_bytes([bytes[0], bytes[1], bytes[2], bytes[3]]),
        ComponentType::I8 => (f32::from(bytes[0] as i8), 127.0),
        ComponentType::I16 => (f32::from(i16::from_le_bytes([bytes[0], bytes[1]])), 32767.0),
        ComponentType::U8 => (f32::from(bytes[0]), 255.0),
        ComponentType::U16 => (f32::from(u16::from_le_bytes([bytes[0], bytes[1]])), 65535.0),
        ComponentType::U32 => (unsigned_at(bytes, component) as f32, u32::MAX as f32),
    };
    if normalized { (value / largest).max(-1.0) } else { value }
}

fn unsigned_at(bytes: &[u8], component: ComponentType) -> u32 {
    match component {
        ComponentType::I8 | ComponentType::U8 => u32::from(bytes[0]),
        ComponentType::I16 | ComponentType::U16 => u32::from(u16::from_le_bytes([bytes[0], bytes[1]])),
        ComponentType::U32 | ComponentType::F32 => {
            u32::from_le_bytes([bytes[0], bytes[1], bytes[2], bytes[3]])
        }
    }
}
