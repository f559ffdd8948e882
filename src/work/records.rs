//! Records of files of pieces: a length (4 bytes, little-endian), the CRC-32 of the content (4 bytes) and the content, written with postcard.

use std::io::{Error as IoError, Read, Result as IoResult};

use serde::{Serialize, de::DeserializeOwned};

/// Bytes before the content of a record.
pub(super) const HEAD: usize = 8;

/// Returns a key or a piece encoded as bytes.
///
/// # Errors
/// It has no form in bytes; no such value is known.
pub(super) fn encode<T: Serialize + ?Sized>(value: &T) -> IoResult<Vec<u8>> {
    postcard::to_stdvec(value).map_err(IoError::other)
}

/// Returns a piece decoded from its bytes; `None` if they are no such piece.
pub(super) fn decode<T: DeserializeOwned>(bytes: &[u8]) -> Option<T> {
    postcard::from_bytes(bytes).ok()
}

/// Returns a record: `content` with its length and checksum before it.
///
/// # Errors
/// It is longer than 4 GiB.
pub(super) fn record(content: &[u8]) -> IoResult<Vec<u8>> {
    let length = u32::try_from(content.len()).map_err(|_| IoError::other("a record of more than 4 GiB"))?;
    Ok([length.to_le_bytes().as_slice(), &crc32fast::hash(content).to_le_bytes(), content].concat())
}

/// Result of reading where a record is expected.
pub(super) enum Record {
    /// Its content.
    Whole(Vec<u8>),
    /// The content, of this length, does not match its checksum.
    Damaged(u64),
    /// There is none, or it was cut short.
    End,
}

/// Reads the next record, if it is not longer than the `remaining` bytes of the file. Nothing that is written is of length 0, but what a power
/// cut leaves often is.
pub(super) fn next_record(reader: &mut impl Read, remaining: u64) -> IoResult<Record> {
    let mut head = [0; HEAD];
    if !fill(reader, &mut head)? {
        return Ok(Record::End);
    }
    let [a, b, c, d, e, f, g, h] = head;
    let (length, sum) = (u32::from_le_bytes([a, b, c, d]), u32::from_le_bytes([e, f, g, h]));
    if length == 0 || HEAD as u64 + u64::from(length) > remaining {
        return Ok(Record::End);
    }
    let mut content = vec![0; length as usize];
    if !fill(reader, &mut content)? {
        return Ok(Record::End);
    }
    Ok(if crc32fast::hash(&content) == sum { Record::Whole(content) } else { Record::Damaged(u64::from(length)) })
}

/// Fills `buffer`; returns whether there were enough bytes.
pub(super) fn fill(reader: &mut impl Read, buffer: &mut [u8]) -> IoResult<bool> {
    match reader.read_exact(buffer) {
        Ok(()) => Ok(true),
        Err(error) if error.kind() == std::io::ErrorKind::UnexpectedEof => Ok(false),
        Err(error) => Err(error),
    }
}
