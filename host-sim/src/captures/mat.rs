//! Reader of the numeric variables of MATLAB's level-5 files (MathWorks, "MAT-File Format", chapter
//! 1), as far as captures need them: real or complex matrices, little-endian, compressed or not.

use std::collections::BTreeMap;
use std::io::Read as _;

use anyhow::{Context, Result, bail, ensure};
use byteorder::{ByteOrder, LittleEndian as LE};
use flate2::read::ZlibDecoder;
use num_complex::Complex64;

/// Number of bytes of the file's header, before the first data element.
const HEADER: usize = 128;
/// Data types of elements, matrix and compressed data (table 1-1).
const MATRIX: u32 = 14;
const COMPRESSED: u32 = 15;
/// Array flag that marks a complex matrix (table 1-3).
const COMPLEX: f64 = 2048.0;
/// Maximum size of a file's decompressed data, bytes.
const MAX_BYTES: u64 = 256 << 20;

/// Returns the values of each numeric matrix of a MAT-file by the matrix's name, in column order.
///
/// # Errors
/// The bytes are no little-endian MAT-file of level 5.
pub fn read(bytes: &[u8]) -> Result<BTreeMap<String, Vec<Complex64>>> {
    let header = bytes.get(..HEADER).context("too short for a MAT-file")?;
    ensure!(
        header.starts_with(b"MATLAB 5.0") && header.ends_with(b"IM"),
        "expected a little-endian MAT-file of level 5"
    );
    let mut found = BTreeMap::new();
    let mut rest = &bytes[HEADER..];
    while let Some((kind, mut data)) = element(&mut rest)? {
        let mut unpacked = Vec::new();
        if kind == COMPRESSED {
            ZlibDecoder::new(data)
                .take(MAX_BYTES)
                .read_to_end(&mut unpacked)
                .context("compressed element")?;
            let mut inner = &unpacked[..];
            let Some((MATRIX, inside)) = element(&mut inner)? else {
                continue;
            };
            data = inside;
        } else if kind != MATRIX {
            continue;
        }
        if let Some((name, values)) = matrix(data)? {
            found.insert(name, values);
        }
    }
    Ok(found)
}

/// Removes the next data element from the beginning of `rest` and returns its type and data; `None`
/// at the end.
fn element<'a>(rest: &mut &'a [u8]) -> Result<Option<(u32, &'a [u8])>> {
    if rest.len() < 8 {
        return Ok(None);
    }
    let tag = LE::read_u32(rest);
    let (kind, from, length) = match tag >> 16 {
        0 => (tag, 8, LE::read_u32(&rest[4..]) as usize),
        // A small element holds its data in its tag.
        length => (tag & 0xFFFF, 4, length as usize),
    };
    let data = rest
        .get(from..from + length)
        .context("an element beyond the file's end")?;
    let padded = match kind {
        COMPRESSED => from + length,
        _ => (from + length).next_multiple_of(8),
    };
    *rest = rest.get(padded..).unwrap_or_default();
    Ok(Some((kind, data)))
}

/// Returns name and values (in column order) of a matrix from its element's data; `None` if it is
/// not numeric, such as a structure.
fn matrix(mut data: &[u8]) -> Result<Option<(String, Vec<Complex64>)>> {
    let mut part = || {
        element(&mut data)
            .transpose()
            .context("a matrix without its parts")?
    };
    let (flags, _dimensions, name) = (part()?, part()?, part()?);
    let flags = numbers(flags)?;
    let class = flags.first().map_or(0, |&f| f as u32 & 0xFF);
    if !(6..=15).contains(&class) {
        return Ok(None);
    }
    let complex = flags
        .first()
        .is_some_and(|&f| f as u32 & COMPLEX as u32 != 0);
    let real = numbers(part()?)?;
    let imaginary = match complex {
        true => numbers(part()?)?,
        false => vec![0.0; real.len()],
    };
    let values = real.iter().zip(&imaginary);
    let name = String::from_utf8_lossy(name.1).into_owned();
    Ok(Some((
        name,
        values.map(|(&re, &im)| Complex64::new(re, im)).collect(),
    )))
}

fn numbers((kind, data): (u32, &[u8])) -> Result<Vec<f64>> {
    let of = |size: usize, read: fn(&[u8]) -> f64| data.chunks_exact(size).map(read).collect();
    Ok(match kind {
        1 => of(1, |b| f64::from(b[0] as i8)),
        2 => of(1, |b| f64::from(b[0])),
        3 => of(2, |b| LE::read_i16(b).into()),
        4 => of(2, |b| LE::read_u16(b).into()),
        5 => of(4, |b| LE::read_i32(b).into()),
        6 => of(4, |b| LE::read_u32(b).into()),
        7 => of(4, |b| LE::read_f32(b).into()),
        9 => of(8, LE::read_f64),
        other => bail!("numbers of type {other}"),
    })
}

#[cfg(test)]
mod tests {
    use std::io::Write as _;

    use flate2::write::ZlibEncoder;

    use super::*;

    fn part(kind: u32, data: &[u8]) -> Vec<u8> {
        let mut out = [kind.to_le_bytes(), (data.len() as u32).to_le_bytes()].concat();
        out.extend(data);
        out.resize(out.len().next_multiple_of(8), 0);
        out
    }

    fn file(elements: &[Vec<u8>]) -> Vec<u8> {
        let mut out = b"MATLAB 5.0 MAT-file".to_vec();
        out.resize(HEADER - 2, b' ');
        out.extend(b"IM");
        out.extend(elements.concat());
        out
    }

    fn pair(name: &[u8], re: [i8; 3], im: [i16; 3]) -> Vec<u8> {
        let flags = [(6 | COMPLEX as u32).to_le_bytes(), [0; 4]].concat();
        let size = [1u32.to_le_bytes(), 3u32.to_le_bytes()].concat();
        let name = [&[1, 0, name.len() as u8, 0], name, &[0; 4][name.len()..]].concat();
        let im: Vec<u8> = im.iter().flat_map(|v| v.to_le_bytes()).collect();
        let re = re.map(|v| v as u8);
        let parts = [
            part(6, &flags),
            part(5, &size),
            name,
            part(1, &re),
            part(3, &im),
        ];
        part(MATRIX, &parts.concat())
    }

    #[test]
    fn matrices_packed_and_not() {
        let plain = pair(b"x", [1, -2, 3], [400, -500, 600]);
        let mut packer = ZlibEncoder::new(Vec::new(), flate2::Compression::fast());
        packer.write_all(&pair(b"y", [0; 3], [7; 3])).unwrap();
        let packed = packer.finish().unwrap();
        let mut element = [
            COMPRESSED.to_le_bytes(),
            (packed.len() as u32).to_le_bytes(),
        ]
        .concat();
        element.extend(packed);
        let found = read(&file(&[plain, element])).unwrap();
        let [x, y] = ["x", "y"].map(|name| found[name].clone());
        assert_eq!(x[1], Complex64::new(-2.0, -500.0));
        assert_eq!(y, [Complex64::new(0.0, 7.0); 3]);
    }

    #[test]
    fn what_is_no_such_file_is_refused() {
        assert!(read(b"MATLAB").is_err());
        assert!(read(&[0; 500]).is_err());
        let whole = file(&[pair(b"x", [1; 3], [1; 3])]);
        for cut in HEADER + 8..whole.len() {
            assert!(read(&whole[..cut]).is_err(), "{cut}");
        }
    }
}
