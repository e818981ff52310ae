//! `EXT_meshopt_compression`: buffer views that hold packed vertices or indices, decoded as its specification says.
//!
//! *Vertices* come in blocks. Of each byte of the stride a block stores one row: differences to the byte of the vertex
//! before, in groups of sixteen that take 0, 2, 4 or 8 bits each; a value of all ones stands for a whole byte that
//! follows. *Triangles* name edges and vertices seen lately by their place in two queues of sixteen. *Indices* are
//! differences to one of two earlier ones. *Filters* turn integers back into normals, rotations or floats.

use serde_json::{Map, Value};

use super::GltfError;
use super::buffers::whole;

/// The extension's name.
pub(super) const MESHOPT: &str = "EXT_meshopt_compression";

/// How a view is packed.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
enum Mode {
    Attributes,
    Triangles,
    Indices,
}

#[derive(Clone, Copy, Debug, PartialEq, Eq)]
enum Filter {
    None,
    Octahedral,
    Quaternion,
    Exponential,
}

/// A compressed buffer view.
#[derive(Clone, Copy, Debug)]
pub(super) struct Compressed {
    pub(super) buffer: u64,
    pub(super) offset: u64,
    pub(super) length: u64,
    stride: usize,
    count: u64,
    mode: Mode,
    filter: Filter,
}

impl Compressed {
    /// What a buffer view says of its compression; `None` for one that is not compressed.
    pub(super) fn of(view: &Map<String, Value>, index: usize) -> Result<Option<Self>, GltfError> {
        let Some(value) = view.get("extensions").and_then(|extensions| extensions.get(MESHOPT)) else {
            return Ok(None);
        };
        let wrong = |problem: &str| GltfError::Compressed { view: index, problem: problem.into() };
        let object = value.as_object().ok_or_else(|| wrong("the extension must be a JSON object"))?;
        let number = |field: &str| object.get(field).and_then(Value::as_u64);
        let word = |field: &str| object.get(field).and_then(Value::as_str);
        let mode = match word("mode") {
            Some("ATTRIBUTES") => Mode::Attributes,
            Some("TRIANGLES") => Mode::Triangles,
            Some("INDICES") => Mode::Indices,
            _ => return Err(wrong("its mode must be ATTRIBUTES, TRIANGLES or INDICES")),
        };
        let filter = match word("filter") {
            None | Some("NONE") => Filter::None,
            Some("OCTAHEDRAL") => Filter::Octahedral,
            Some("QUATERNION") => Filter::Quaternion,
            Some("EXPONENTIAL") => Filter::Exponential,
            Some(_) => return Err(wrong("its filter must be NONE, OCTAHEDRAL, QUATERNION or EXPONENTIAL")),
        };
        let needed =
            |field: &str| number(field).ok_or_else(|| wrong(&format!("its {field} must be a whole number")));
        let (buffer, length) = (needed("buffer")?, needed("byteLength")?);
        let (stride, count) = (needed("byteStride")?, needed("count")?);
        let fits = match mode {
            Mode::Attributes => stride % 4 == 0 && (4..=256).contains(&stride),
            Mode::Triangles => matches!(stride, 2 | 4) && count % 3 == 0,
            Mode::Indices => matches!(stride, 2 | 4),
        };
        let filtered = match filter {
            Filter::None => true,
            Filter::Octahedral => mode == Mode::Attributes && matches!(stride, 4 | 8),
            Filter::Quaternion => mode == Mode::Attributes && stride == 8,
            Filter::Exponential => mode == Mode::Attributes,
        };
        if !fits || !filtered || count == 0 {
            return Err(wrong("its byteStride or count do not fit its mode and filter"));
        }
        let offset = whole(object, "byteOffset");
        Ok(Some(Self { buffer, offset, length, stride: stride as usize, count, mode, filter }))
    }

    pub(super) fn decoded_bytes(&self) -> u64 {
        self.count.saturating_mul(self.stride as u64)
    }
}

/// What is wrong with packed bytes.
type Problem = &'static str;

const TOO_SHORT: Problem = "its data end too early";

/// The bytes that `data` stand for; the caller has made sure that there may be so many.
pub(super) fn decode(data: &[u8], view: &Compressed) -> Result<Vec<u8>, Problem> {
    let count = usize::try_from(view.count).map_err(|_| TOO_SHORT)?;
    let mut bytes = match view.mode {
        Mode::Attributes => attributes(data, count, view.stride)?,
        Mode::Triangles => packed(&triangles(data, count / 3)?, view.stride),
        Mode::Indices => packed(&indices(data, count)?, view.stride),
    };
    match view.filter {
        Filter::None => {}
        Filter::Octahedral if view.stride == 4 => bytes.chunks_exact_mut(4).for_each(|texel| {
            let [x, y, z] = [0, 1, 2].map(|i| f32::from(texel[i] as i8));
            let unit = octahedral([x, y, z], 127.0);
            (0..3).for_each(|i| texel[i] = unit[i] as i8 as u8);
        }),
        Filter::Octahedral => bytes.chunks_exact_mut(8).for_each(|texel| {
            let unit = octahedral([0, 1, 2].map(|i| f32::from(short(texel, i))), 32767.0);
            (0..3).for_each(|i| set_short(texel, i, unit[i] as i16));
        }),
        Filter::Quaternion => bytes.chunks_exact_mut(8).for_each(quaternion),
        Filter::Exponential => bytes.chunks_exact_mut(4).for_each(|word| {
            let bits = u32::from_le_bytes([word[0], word[1], word[2], word[3]]);
            let (mantissa, exponent) = ((bits << 8) as i32 >> 8, bits as i32 >> 24);
            let value = (f64::from(mantissa) * f64::from(exponent).exp2()) as f32;
            word.copy_from_slice(&value.to_le_bytes());
        }),
    }
    Ok(bytes)
}

/// Reads bytes one after another.
struct Reader<'a> {
    data: &'a [u8],
    at: usize,
}

impl<'a> Reader<'a> {
    fn bytes(&mut self, count: usize) -> Result<&'a [u8], Problem> {
        let bytes = self.data.get(self.at..self.at + count).ok_or(TOO_SHORT)?;
        self.at += count;
        Ok(bytes)
    }

    fn byte(&mut self) -> Result<u8, Problem> {
        Ok(self.bytes(1)?[0])
    }

    /// A number in groups of seven bits, the lowest first.
    fn number(&mut self) -> Result<u32, Problem> {
        let mut value = 0;
        for shift in (0..35).step_by(7) {
            let byte = self.byte()?;
            value |= u32::from(byte & 127).wrapping_shl(shift);
            if byte < 128 {
                return Ok(value);
            }
        }
        Err("one of its numbers does not end")
    }

    fn ended(&self) -> Result<(), Problem> {
        if self.at == self.data.len() { Ok(()) } else { Err("bytes are left over at its end") }
    }
}

fn signed(value: u32) -> u32 {
    (value >> 1) ^ (value & 1).wrapping_neg()
}

/// The vertices of a view, `stride` bytes each.
fn attributes(data: &[u8], count: usize, stride: usize) -> Result<Vec<u8>, Problem> {
    const GROUP: usize = 16;
    let tail = stride.max(32);
    if data.len() < 1 + tail {
        return Err(TOO_SHORT);
    }
    if data[0] != 0xA0 {
        return Err("it does not begin as packed vertices of version 0 do");
    }
    let (blocks, tail) = data[1..].split_at(data.len() - 1 - tail);
    let mut reader = Reader { data: blocks, at: 0 };
    let mut last = tail[tail.len() - stride..].to_vec();
    let block = (8192 / stride / GROUP * GROUP).min(256);
    // Each block has at least a byte of its own for each byte of the stride.
    if blocks.len() < count.div_ceil(block).saturating_mul(stride) {
        return Err(TOO_SHORT);
    }
    let mut bytes = vec![0; count * stride];
    for vertices in bytes.chunks_mut(block * stride) {
        let groups = (vertices.len() / stride).div_ceil(GROUP);
        for place in 0..stride {
            let widths = reader.bytes(groups.div_ceil(4))?;
            for group in 0..groups {
                let deltas = match widths[group / 4] >> (group % 4 * 2) & 3 {
                    0 => [0; GROUP],
                    1 => deltas(&mut reader, 2)?,
                    2 => deltas(&mut reader, 4)?,
                    _ => deltas(&mut reader, 8)?,
                };
                let first = group * GROUP;
                let rows = vertices.chunks_exact_mut(stride).skip(first);
                for (vertex, delta) in rows.zip(deltas) {
                    last[place] = last[place].wrapping_add((delta >> 1) ^ (delta & 1).wrapping_neg());
                    vertex[place] = last[place];
                }
            }
        }
    }
    reader.ended()?;
    Ok(bytes)
}

/// A group of sixteen differences of so many bits, the first in the highest bits.
fn deltas(reader: &mut Reader<'_>, bits: usize) -> Result<[u8; 16], Problem> {
    let packed = reader.bytes(2 * bits)?;
    let mut deltas = [0; 16];
    let per_byte = 8 / bits;
    let ones = (0xFF_u16 >> (8 - bits)) as u8;
    for (index, delta) in deltas.iter_mut().enumerate() {
        *delta = packed[index / per_byte] >> ((per_byte - 1 - index % per_byte) * bits) & ones;
        if bits < 8 && *delta == ones {
            *delta = reader.byte()?;
        }
    }
    Ok(deltas)
}

/// The last sixteen of something.
#[derive(Default)]
struct Queue<T> {
    values: [T; 16],
    next: usize,
}

impl<T: Copy> Queue<T> {
    fn push(&mut self, value: T) {
        self.values[self.next] = value;
        self.next = (self.next + 1) % 16;
    }

    /// The one that `back` others came after.
    fn back(&self, back: usize) -> T {
        self.values[(self.next + 31 - back) % 16]
    }
}

/// What lies between the first byte, which has to be `first`, and a tail of so many: at least `count` bytes. And the tail.
fn body_and_tail(
    data: &[u8],
    (first, otherwise): (u8, Problem),
    count: usize,
    tail: usize,
) -> Result<(&[u8], &[u8]), Problem> {
    match data.split_first() {
        Some((_, rest)) if rest.len() < tail || rest.len() - tail < count => Err(TOO_SHORT),
        Some((found, rest)) if *found == first => Ok(rest.split_at(rest.len() - tail)),
        Some(_) => Err(otherwise),
        None => Err(TOO_SHORT),
    }
}

/// The indices of so many triangles.
fn triangles(data: &[u8], count: usize) -> Result<Vec<u32>, Problem> {
    let begins = (0xE1, "it does not begin as packed triangles of version 1 do");
    let (body, table) = body_and_tail(data, begins, count, 16)?;
    let (codes, rest) = body.split_at(count);
    let mut reader = Reader { data: rest, at: 0 };
    let (mut edges, mut vertices) = (Queue::<[u32; 2]>::default(), Queue::<u32>::default());
    let (mut next, mut last) = (0_u32, 0_u32);
    let take_next = |next: &mut u32| std::mem::replace(next, next.wrapping_add(1));
    let mut order = Vec::with_capacity(count * 3);
    for &code in codes {
        let (high, low) = (usize::from(code >> 4), usize::from(code & 15));
        if high < 15 {
            // Two corners are those of an edge seen lately.
            let [a, b] = edges.back(high);
            let c = match low {
                0 => take_next(&mut next),
                1..13 => vertices.back(low),
                13 => last.wrapping_sub(1),
                14 => last.wrapping_add(1),
                _ => last.wrapping_add(signed(reader.number()?)),
            };
            if low == 0 || low >= 13 {
                vertices.push(c);
            }
            if low >= 13 {
                last = c;
            }
            order.extend([a, b, c]);
            edges.push([c, b]);
            edges.push([a, c]);
            continue;
        }
        let other = if low < 14 { table[low] } else { reader.byte()? };
        if low >= 14 && other == 0 {
            next = 0;
        }
        let kinds = [if low == 15 { 15 } else { 0 }, usize::from(other >> 4), usize::from(other & 15)];
        // New corners are counted before any that is written out is read.
        let mut corners = kinds.map(|kind| match kind {
            0 => take_next(&mut next),
            15 => 0,
            back => vertices.back(back - 1),
        });
        for (corner, kind) in corners.iter_mut().zip(kinds) {
            if kind == 15 {
                last = last.wrapping_add(signed(reader.number()?));
                *corner = last;
            }
        }
        for (corner, _) in corners.iter().zip(kinds).filter(|(_, kind)| matches!(kind, 0 | 15)) {
            vertices.push(*corner);
        }
        let [a, b, c] = corners;
        order.extend(corners);
        [[b, a], [c, b], [a, c]].into_iter().for_each(|edge| edges.push(edge));
    }
    reader.ended()?;
    Ok(order)
}

/// So many indices, in any order.
fn indices(data: &[u8], count: usize) -> Result<Vec<u32>, Problem> {
    let begins = (0xD1, "it does not begin as packed indices of version 1 do");
    let (body, _) = body_and_tail(data, begins, count, 4)?;
    let mut reader = Reader { data: body, at: 0 };
    let mut bases = [0_u32; 2];
    let mut index = || {
        let value = reader.number()?;
        let base = &mut bases[(value & 1) as usize];
        *base = base.wrapping_add(signed(value >> 1));
        Ok(*base)
    };
    let order = (0..count).map(|_| index()).collect::<Result<_, _>>()?;
    reader.ended()?;
    Ok(order)
}

/// Indices of 2 or 4 bytes each.
fn packed(indices: &[u32], stride: usize) -> Vec<u8> {
    indices.iter().flat_map(|index| index.to_le_bytes().into_iter().take(stride)).collect()
}

/// A unit vector times `most`, from its place on the octahedron whose corners are at the third number.
fn octahedral([x, y, one]: [f32; 3], most: f32) -> [f32; 3] {
    let z = one - x.abs() - y.abs();
    let folded = z.min(0.0);
    let [x, y] = [x, y].map(|v| if v >= 0.0 { v + folded } else { v - folded });
    let scale = most / (x * x + y * y + z * z).sqrt();
    [x, y, z].map(|v| rounded(v * scale))
}

/// A rotation from its three smaller components; the lowest bits of the fourth number say which is left out.
fn quaternion(texel: &mut [u8]) {
    let (scale, left_out) = (short(texel, 3) | 3, (short(texel, 3) & 3) as usize);
    let unit = std::f32::consts::FRAC_1_SQRT_2 / f32::from(scale);
    let [x, y, z] = [0, 1, 2].map(|i| f32::from(short(texel, i)) * unit);
    let w = (1.0 - x * x - y * y - z * z).max(0.0).sqrt();
    for (i, value) in [w, x, y, z].into_iter().enumerate() {
        set_short(texel, (left_out + i) % 4, rounded(value * 32767.0) as i16);
    }
}

fn rounded(value: f32) -> f32 {
    (value + if value >= 0.0 { 0.5 } else { -0.5 }).trunc()
}

fn short(bytes: &[u8], index: usize) -> i16 {
    i16::from_le_bytes([bytes[index * 2], bytes[index * 2 + 1]])
}

fn set_short(bytes: &mut [u8], index: usize, value: i16) {
    bytes[index * 2..index * 2 + 2].copy_from_slice(&value.to_le_bytes());
}
