//! Accessors: typed streams of numbers in buffers, checked before anything is allocated.

use gltf::json;
use json::accessor::{ComponentType, Type};
use json::validation::Checked;

use super::GltfError;
use super::buffers::Buffers;
use super::limits::Budget;

/// The most elements an accessor may have that has no buffer view, only sparse values: nothing else bounds it.
const MAX_COUNT_WITHOUT_VIEW: u64 = 1 << 20;

/// Reads accessors of one document.
#[derive(Debug)]
pub(super) struct Accessors<'a> {
    pub(super) root: &'a json::Root,
    pub(super) buffers: &'a Buffers<'a>,
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
        let normalized = declaration.normalized || integers == Integers::Normalized;
        let size = component.size();
        let values = self.read(accessor, purpose, N * size, [0.0; N], budget, |bytes| {
            std::array::from_fn(|i| float(&bytes[i * size..], component, normalized))
        })?;
        if let Some(element) = values.iter().position(|value: &[f32; N]| !value.iter().all(|x| x.is_finite()))
        {
            let problem = format!("element {element} is {:?}; finite numbers are needed", values[element]);
            return Err(GltfError::Accessor { accessor, purpose, problem });
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

    fn get(&self, accessor: usize, purpose: &'static str) -> Result<&json::Accessor, GltfError> {
        self.root.accessors.get(accessor).ok_or_else(|| GltfError::IndexOutOfRange {
            item: purpose.into(),
            field: "accessor".into(),
            kind: "accessor",
            index: accessor as u64,
            count: self.root.accessors.len(),
        })
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
        let wrong = |problem: String| GltfError::Accessor { accessor, purpose, problem };
        let count = declaration.count.0;
        if count == 0 {
            return Err(wrong("it is empty; at least 1 element is needed".into()));
        }
        let mut values = match declaration.buffer_view {
            Some(view) => {
                let stride = self.root.get(view).and_then(|view| view.byte_stride).map_or(size, |s| s.0);
                if stride < size {
                    return Err(wrong(format!(
                        "its buffer view's byteStride {stride} is below its elements' {size}"
                    )));
                }
                let offset = declaration.byte_offset.unwrap_or_default().0;
                let bytes = self.range(accessor, view, offset, count, stride, size)?;
                budget.charge_elements(count)?;
                bytes.chunks(stride).map(&parse).collect()
            }
            None if count > MAX_COUNT_WITHOUT_VIEW => {
                let what = format!("accessor {accessor} ({purpose}): elements without a buffer view");
                return Err(GltfError::TooLarge { what, count, limit: MAX_COUNT_WITHOUT_VIEW });
            }
            None => {
                // Memory without a byte of the file behind it counts sixteenfold.
                budget.charge_elements(count * 16)?;
                vec![zero; count as usize]
            }
        };
        let Some(sparse) = &declaration.sparse else { return Ok(values) };
        if sparse.count.0 == 0 || sparse.count.0 > count {
            return Err(wrong(format!("it has {} sparse values; 1 to {count} are needed", sparse.count.0)));
        }
        let Checked::Valid(json::accessor::IndexComponentType(component)) = sparse.indices.component_type
        else {
            return Err(wrong("its sparse indices have no valid component type".into()));
        };
        let (indices, places) = (&sparse.indices, component.size());
        let places_bytes =
            self.range(accessor, indices.buffer_view, indices.byte_offset.0, sparse.count.0, places, places)?;
        let values_bytes = self.range(
            accessor,
            sparse.values.buffer_view,
            sparse.values.byte_offset.0,
            sparse.count.0,
            size,
            size,
        )?;
        let mut previous = None;
        for (place, bytes) in places_bytes.chunks_exact(places).zip(values_bytes.chunks_exact(size)) {
            let place = unsigned_at(place, component);
            if previous.is_some_and(|previous| place <= previous) || u64::from(place) >= count {
                return Err(wrong(format!(
                    "its sparse index {place} is not above the one before it and below {count}"
                )));
            }
            values[place as usize] = parse(bytes);
            previous = Some(place);
        }
        Ok(values)
    }

    /// The bytes from the first element to the end of the last, checked to lie in the view.
    fn range(
        &self,
        accessor: usize,
        view: json::Index<json::buffer::View>,
        offset: u64,
        count: u64,
        stride: usize,
        size: usize,
    ) -> Result<&[u8], GltfError> {
        let bytes = self.buffers.view(self.root, view)?;
        let length = (u128::from(count) - 1) * stride as u128 + size as u128;
        let needed = u128::from(offset) + length;
        if needed > bytes.len() as u128 {
            let (view, available) = (view.value(), bytes.len());
            return Err(GltfError::AccessorRange { accessor, needed, view, available });
        }
        Ok(&bytes[offset as usize..needed as usize])
    }
}

fn kind(
    declaration: &json::Accessor,
    accessor: usize,
    purpose: &'static str,
) -> Result<(Type, ComponentType), GltfError> {
    match (declaration.type_, declaration.component_type) {
        (Checked::Valid(found), Checked::Valid(component)) => Ok((found, component.0)),
        _ => {
            let problem = "its type or componentType is unknown".into();
            Err(GltfError::Accessor { accessor, purpose, problem })
        }
    }
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
