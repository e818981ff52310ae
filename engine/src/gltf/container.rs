//! The .glb container: header, JSON chunk, binary chunk.

use super::GltfError;

/// The two parts of a glTF file.
#[derive(Clone, Debug)]
pub(super) struct Parts<'a> {
    pub(super) json: &'a [u8],
    pub(super) bin: Option<&'a [u8]>,
    /// What is not as it should be, but does no harm.
    pub(super) remarks: Vec<String>,
}

const JSON_CHUNK: u32 = 0x4E4F_534A;
const BIN_CHUNK: u32 = 0x004E_4942;

/// Splits a file into JSON and binary chunk; what does not begin with the .glb magic is JSON as a whole.
///
/// Lengths in the file are never taken from one another unchecked: it may claim any.
pub(super) fn split(bytes: &[u8]) -> Result<Parts<'_>, GltfError> {
    if !bytes.starts_with(b"glTF") {
        let json = bytes.strip_prefix(b"\xEF\xBB\xBF").unwrap_or(bytes);
        let marked = json.len() < bytes.len();
        let remarks =
            marked.then(|| "the file begins with a byte order mark".to_owned()).into_iter().collect();
        return Ok(Parts { json, bin: None, remarks });
    }
    let glb = |problem: String| GltfError::Glb { problem };
    let (Some(version), Some(length)) = (u32_at(bytes, 4), u32_at(bytes, 8)) else {
        return Err(glb(format!("it ends after {} bytes, within the header", bytes.len())));
    };
    if version != 2 {
        return Err(GltfError::Version { found: format!("{version} (of the .glb container)") });
    }
    let Some(mut rest) = bytes.get(12..length as usize) else {
        return Err(glb(format!("its header says {length} bytes, the file has {}", bytes.len())));
    };
    let (mut json, mut bin, mut remarks) = (None, None, Vec::new());
    let mut chunks = 0;
    while !rest.is_empty() {
        let (Some(size), Some(kind)) = (u32_at(rest, 0), u32_at(rest, 4)) else {
            return Err(glb(format!("{} stray bytes follow the last chunk", rest.len())));
        };
        let end = 8 + size as usize;
        let Some(data) = rest.get(8..end) else {
            return Err(glb(format!("a chunk says {size} bytes, {} are left", rest.len() - 8)));
        };
        if size % 4 != 0 {
            remarks.push(format!("chunk {chunks} of the .glb has {size} bytes, no multiple of 4"));
        }
        if kind == BIN_CHUNK && chunks > 1 {
            remarks.push(format!("the .glb's binary chunk comes as chunk {chunks}, not 1"));
        }
        chunks += 1;
        match kind {
            JSON_CHUNK if json.is_none() => json = Some(data),
            BIN_CHUNK if json.is_some() && bin.is_none() => bin = Some(data),
            JSON_CHUNK | BIN_CHUNK => return Err(glb("its chunks are out of order or repeated".into())),
            // The specification asks readers to skip chunks they do not know, once the JSON is there.
            _ if json.is_some() => {}
            _ => return Err(glb("its first chunk is not JSON".into())),
        }
        // The last chunk's padding may be missing, so the next start is clamped to the end.
        rest = rest.get(end.next_multiple_of(4)..).unwrap_or(&[]);
    }
    let json = json.ok_or_else(|| glb("it has no JSON chunk".into()))?;
    Ok(Parts { json, bin, remarks })
}

fn u32_at(bytes: &[u8], offset: usize) -> Option<u32> {
    let four = bytes.get(offset..offset + 4)?;
    Some(u32::from_le_bytes([four[0], four[1], four[2], four[3]]))
}
