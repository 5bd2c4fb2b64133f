//! `.npy` files: one numpy array (NEP 1, versions 1 to 3).
//!
//! The header is a Python dictionary with three keys of fixed form. It is parsed here, because
//! crates that parse any Python literal are much larger.

use std::str::FromStr;

use anyhow::{Context, Error, Result, bail, ensure};

use super::samples::{Format, Number};
use crate::recording::Recording;

const MAGIC: &[u8] = b"\x93NUMPY";
/// Maximum length of a header, bytes: numpy's own limit.
const LONGEST_HEADER: usize = 10_000;
/// Alignment of the header's end, bytes: numpy's alignment of the data.
const ALIGNMENT: usize = 64;

/// Chirps in a numpy array.
#[derive(Debug)]
pub struct Array {
    /// Format of the array's numbers.
    pub format: Format,
    /// Number of complex samples of one chirp, or of pairs of real ones.
    pub samples_per_chirp: usize,
    /// Whether the samples are real.
    pub real: bool,
    /// Bytes of the numbers, I before Q, sample after sample, chirp after chirp.
    pub bytes: Vec<u8>,
}

/// Arrangement of an array's numbers.
#[derive(Clone, Debug, PartialEq, Eq)]
pub enum Layout {
    /// By type and shape, and by the number of samples per chirp if it is known: it distinguishes real samples from pairs.
    ByShape(Option<usize>),
    /// Each row holds all I of a chirp, then all Q.
    Planar,
    /// Real samples with these axes.
    Real(Axes),
}

/// One axis of an array of real samples.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
enum Axis {
    /// Every entry of the axis is taken.
    Whole,
    /// Only the entry with this index is taken, such as one receiver.
    One(usize),
}

/// Axes of an array of real samples, before the last one, which is that of a chirp's samples.
///
/// ```
/// # use stairscan_replay::convert::npy::Axes;
/// assert!("chirp,sample".parse::<Axes>().is_ok());
/// assert!("frame,receiver=0,chirp,sample".parse::<Axes>().is_ok());
/// assert!("sample,chirp".parse::<Axes>().is_err());
/// ```
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Axes(Vec<Axis>);

impl FromStr for Axes {
    type Err = Error;

    fn from_str(text: &str) -> Result<Self> {
        let mut names: Vec<&str> = text.split(',').map(str::trim).collect();
        ensure!(
            names.pop() == Some("sample") && !names.contains(&"sample"),
            "{text}: expected the axes in their order, `sample` last: chirp,sample or \
             frame,receiver=0,chirp,sample"
        );
        let axis = |name: &str| match name.split_once('=') {
            Some((_, entry)) => entry.parse().map(Axis::One).ok(),
            None => matches!(name, "frame" | "chirp").then_some(Axis::Whole),
        };
        let axes = names.into_iter().map(|name| {
            axis(name).with_context(|| {
                format!("{name}: expected frame, chirp, or NAME=ENTRY to take one entry")
            })
        });
        axes.collect::<Result<_>>().map(Self)
    }
}

impl Axes {
    /// Returns the number of sample pairs of a chirp, and the bytes of the chirps that the axes select. `bytes` holds
    /// an array of this shape with numbers of `item` bytes.
    fn chirps(&self, bytes: &[u8], shape: &[usize], item: usize) -> Result<(usize, Vec<u8>)> {
        let Some((&samples, outer)) = shape.split_last() else {
            bail!("shape (): a single number, expected an array");
        };
        ensure!(
            outer.len() == self.0.len(),
            "shape {shape:?}: {} axes, --real names {}",
            shape.len(),
            1 + self.0.len()
        );
        for (axis, count) in self.0.iter().zip(outer) {
            if let Axis::One(entry) = axis {
                ensure!(
                    entry < count,
                    "shape {shape:?}: entry {entry} of an axis of {count}, counted from 0"
                );
            }
        }
        ensure!(
            samples.is_multiple_of(2),
            "shape {shape:?}: {samples} real samples in a chirp, expected an even number"
        );
        let taken = |k: usize| {
            let mut rest = k;
            let axes = self.0.iter().zip(outer).rev();
            axes.into_iter().all(|(axis, &count)| {
                let place = rest % count;
                rest /= count;
                matches!(axis, Axis::Whole) || *axis == Axis::One(place)
            })
        };
        let chirps = bytes.chunks_exact(item * samples).enumerate();
        let chirps = chirps
            .filter(|(k, _)| taken(*k))
            .flat_map(|(_, chirp)| chirp);
        Ok((samples / 2, chirps.copied().collect()))
    }
}

/// Values of the three keys of a `.npy` header: type of the numbers, order of the indices, shape of the array.
struct Header<'a> {
    descr: &'a str,
    fortran_order: bool,
    shape: Vec<usize>,
}

/// The part of the header's text that is not read yet.
struct Text<'a>(&'a str);

impl<'a> Text<'a> {
    fn skip(&mut self) {
        self.0 = self.0.trim_start();
    }

    /// Whether the text continues with `word`, which is then consumed.
    fn take(&mut self, word: &str) -> bool {
        self.skip();
        let rest = self.0.strip_prefix(word);
        self.0 = rest.unwrap_or(self.0);
        rest.is_some()
    }

    fn expect(&mut self, word: &str) -> Result<()> {
        let found: String = self.0.trim_start().chars().take(20).collect();
        ensure!(
            self.take(word),
            "header: found {found:?}, expected {word:?}"
        );
        Ok(())
    }

    fn string(&mut self) -> Result<&'a str> {
        let quote = if self.take("\"") { '"' } else { '\'' };
        if quote == '\'' {
            self.expect("'")?;
        }
        let (text, rest) = self
            .0
            .split_once(quote)
            .context("header: a string without end")?;
        self.0 = rest;
        Ok(text)
    }

    /// Reads a shape: a tuple of whole numbers.
    fn shape(&mut self) -> Result<Vec<usize>> {
        self.expect("(")?;
        let (inside, rest) = self
            .0
            .split_once(')')
            .context("header: shape without end")?;
        self.0 = rest;
        let items = inside
            .split(',')
            .map(str::trim)
            .filter(|item| !item.is_empty());
        items
            // Python 2 wrote long integers with the suffix L.
            .map(|item| item.trim_end_matches('L').parse())
            .collect::<Result<_, _>>()
            .with_context(|| format!("header: shape ({inside}), expected whole numbers"))
    }
}

impl<'a> Header<'a> {
    fn parse(text: &'a str) -> Result<Self> {
        let mut text = Text(text);
        let (mut descr, mut order, mut shape) = (None, None, None);
        text.expect("{")?;
        while !text.take("}") {
            let key = text.string()?;
            text.expect(":")?;
            match key {
                "descr" if text.take("[") => {
                    bail!("descr: a structure, expected one number type, such as '<i2' or '<c8'")
                }
                "descr" => descr = Some(text.string()?),
                "fortran_order" if text.take("True") => order = Some(true),
                "fortran_order" => {
                    text.expect("False")?;
                    order = Some(false);
                }
                "shape" => shape = Some(text.shape()?),
                other => {
                    bail!("header: found key {other:?}, expected descr, fortran_order and shape")
                }
            }
            if !text.take(",") {
                text.expect("}")?;
                break;
            }
        }
        Ok(Self {
            descr: descr.context("header: descr is missing")?,
            fortran_order: order.context("header: fortran_order is missing")?,
            shape: shape.context("header: shape is missing")?,
        })
    }

    /// Returns the format of the array's numbers from the header's type code (`descr`), and whether each item of the
    /// array is a complex pair of such numbers.
    fn format(&self) -> Result<(Format, bool)> {
        let wrong = || {
            format!(
                "descr '{}': expected complex ('<c8', '<c16') or interleaved I and Q ('|i1', '|u1', \
                 '<i2', '<u2', '<i4', '<u4', '<f4', '<f8'), of either order of bytes",
                self.descr
            )
        };
        let mut letters = self.descr.chars();
        let (order, kind) = (letters.next(), letters.next());
        let bytes: usize = letters.as_str().parse().ok().with_context(wrong)?;
        let big_endian = match order {
            Some('<' | '|' | '=') => false,
            Some('>') => true,
            _ => bail!(wrong()),
        };
        let (number, complex) = match kind {
            Some('i') => (Number::Signed, false),
            Some('u') => (Number::Unsigned, false),
            Some('f') => (Number::Float, false),
            Some('c') => (Number::Float, true),
            _ => bail!(wrong()),
        };
        let bytes = if complex { bytes / 2 } else { bytes };
        let format = Format::new(number, bytes, big_endian).with_context(wrong)?;
        Ok((format, complex))
    }

    /// Returns the order of the array's numbers; `complex`: its items are complex numbers.
    fn order(&self, complex: bool, layout: &Layout) -> Result<Order> {
        let order = match (complex, layout, self.shape.as_slice()) {
            (true, Layout::ByShape(_), &[_, samples]) => Order::Pairs(samples),
            (true, Layout::Real(_), _) => bail!(
                "descr '{}': complex numbers, --real expects real ones",
                self.descr
            ),
            (false, Layout::Real(axes), _) => Order::Real(axes.clone()),
            (false, Layout::ByShape(_), &[_, samples, 2]) => Order::Pairs(samples),
            (false, Layout::ByShape(_) | Layout::Planar, &[_, 2, samples]) => {
                Order::Planar(samples)
            }
            (false, Layout::Planar, &[_, numbers]) if numbers % 2 == 0 => {
                Order::Planar(numbers / 2)
            }
            (_, Layout::Planar, shape) => bail!(
                "shape {shape:?} of '{}': --planar expects (chirps, 2·samples) or (chirps, 2, samples) of real numbers",
                self.descr
            ),
            (false, Layout::ByShape(stated), &[_, numbers]) => self.flat(*stated, numbers)?,
            _ => bail!(
                "shape {:?} of '{}': expected (chirps, samples) of complex numbers, or (chirps, samples, 2), \
                 (chirps, 2, samples) or (chirps, 2·samples) of I and Q, or --real AXES for real samples",
                self.shape,
                self.descr
            ),
        };
        Ok(order)
    }

    /// Returns the order of a chirp's `numbers` in one row: `stated` samples, or by the numbers' type. Converters give
    /// whole numbers I and Q in turn; a row of floating point is as likely real samples.
    fn flat(&self, stated: Option<usize>, numbers: usize) -> Result<Order> {
        let is_float = self.descr.contains('f');
        match stated {
            Some(samples) if samples == numbers => Ok(Order::Real(Axes(vec![Axis::Whole]))),
            None if is_float => bail!(
                "shape {:?} of '{}': {numbers} real numbers a chirp: --real chirp,sample for real samples, --planar \
                 for all I, then all Q, or --samples-per-chirp {} for I and Q in turn; without options expected \
                 complex numbers, or (chirps, samples, 2)",
                self.shape,
                self.descr,
                numbers / 2
            ),
            _ if numbers.is_multiple_of(2) => Ok(Order::Pairs(numbers / 2)),
            _ => bail!(
                "shape {:?} of '{}': {numbers} numbers a chirp, expected an even number for I and Q in turn, or \
                 --real AXES for real samples",
                self.shape,
                self.descr
            ),
        }
    }
}

/// Order of an array's numbers, with the number of complex samples per chirp.
enum Order {
    /// I and Q in turn.
    Pairs(usize),
    /// All I of a chirp, then all Q.
    Planar(usize),
    /// Real samples.
    Real(Axes),
}

/// Returns the array of a file.
///
/// # Errors
/// Names the header's key or the length, and the expected value.
pub fn read(file: &[u8], layout: &Layout) -> Result<Array> {
    ensure!(!file.is_empty(), "empty: expected an array of numpy");
    let (header, data) = split(file)?;
    let header = Header::parse(header)?;
    let (format, complex) = header.format()?;
    let order = header.order(complex, layout)?;
    let item = format.bytes * if complex { 2 } else { 1 };
    let length = (header.shape.iter()).try_fold(item, |length, n| length.checked_mul(*n));
    ensure!(
        length != Some(0),
        "shape {:?}: the array is empty, expected at least one chirp",
        header.shape
    );
    ensure!(
        length == Some(data.len()),
        "{} bytes of data, expected {} ({:?} items of {item} bytes)",
        data.len(),
        length.map_or("more than there can be".to_owned(), |n| n.to_string()),
        header.shape
    );
    let bytes = match header.fortran_order {
        false => data.to_vec(),
        true => in_rows(data, &header.shape, item),
    };
    let real = matches!(order, Order::Real(_));
    let (samples_per_chirp, bytes) = match order {
        Order::Pairs(samples) => (samples, bytes),
        Order::Planar(samples) => (samples, in_pairs(&bytes, samples, item)),
        Order::Real(axes) => axes.chirps(&bytes, &header.shape, item)?,
    };
    Ok(Array {
        format,
        samples_per_chirp,
        real,
        bytes,
    })
}

/// Reorders the numbers, of `item` bytes, of chirps of `samples` I and then as many Q: I and Q in turn.
fn in_pairs(bytes: &[u8], samples: usize, item: usize) -> Vec<u8> {
    let mut pairs = Vec::with_capacity(bytes.len());
    for chirp in bytes.chunks_exact(2 * samples * item) {
        let (i, q) = chirp.split_at(samples * item);
        for (i, q) in i.chunks_exact(item).zip(q.chunks_exact(item)) {
            pairs.extend_from_slice(i);
            pairs.extend_from_slice(q);
        }
    }
    pairs
}

/// Returns the header's text and the bytes of the data of a file.
fn split(file: &[u8]) -> Result<(&str, &[u8])> {
    let rest = file
        .strip_prefix(MAGIC)
        .context("no array of numpy: it does not begin with \\x93NUMPY")?;
    let (length, rest) = match rest {
        [1, _, a, b, rest @ ..] => (usize::from(u16::from_le_bytes([*a, *b])), rest),
        [2 | 3, _, a, b, c, d, rest @ ..] => (u32::from_le_bytes([*a, *b, *c, *d]) as usize, rest),
        [version, ..] => bail!("version {version} of the format, or cut off: expected 1 to 3"),
        [] => bail!("cut off within its first bytes"),
    };
    ensure!(
        length <= LONGEST_HEADER,
        "header: {length} bytes, expected {LONGEST_HEADER} at most"
    );
    let (header, data) = rest
        .split_at_checked(length)
        .with_context(|| format!("header: cut off, expected {length} bytes"))?;
    let header = std::str::from_utf8(header).context("header: no text")?;
    Ok((header, data))
}

/// Reorders the items of an array from Fortran order (first index fastest) to C order (last index
/// fastest).
fn in_rows(data: &[u8], shape: &[usize], item: usize) -> Vec<u8> {
    let mut bytes = Vec::with_capacity(data.len());
    for k in 0..data.len() / item {
        let (mut rest, mut at) = (k, 0);
        let mut stride: usize = shape.iter().product();
        for &n in shape.iter().rev() {
            stride /= n;
            at += rest % n * stride;
            rest /= n;
        }
        bytes.extend_from_slice(&data[at * item..(at + 1) * item]);
    }
    bytes
}

/// Returns a recording's samples as a numpy file: (chirps, samples, 2) of 16-bit I and Q, or
/// (chirps, samples) of complex64 with 1.0 for full scale (32768). Both are exact.
pub fn write(recording: &Recording, complex: bool) -> Vec<u8> {
    let (chirps, samples) = (recording.chirps(), recording.meta.samples_per_chirp);
    let (descr, shape) = match complex {
        false => ("<i2", format!("({chirps}, {samples}, 2)")),
        true => ("<c8", format!("({chirps}, {samples})")),
    };
    let text = format!("{{'descr': '{descr}', 'fortran_order': False, 'shape': {shape}, }}");
    let before = MAGIC.len() + 4;
    let length = (before + text.len() + 1).next_multiple_of(ALIGNMENT) - before;
    let mut file = MAGIC.to_vec();
    file.extend([1, 0]);
    file.extend((length as u16).to_le_bytes());
    file.extend(format!("{text:<width$}\n", width = length - 1).bytes());
    for part in recording.samples.iter().flat_map(|s| [s.i, s.q]) {
        match complex {
            false => file.extend(part.to_le_bytes()),
            true => file.extend((f32::from(part) / 32768.0).to_le_bytes()),
        }
    }
    file
}

#[cfg(test)]
mod tests {
    use proptest::prelude::*;

    use super::*;

    const SHAPE: Layout = Layout::ByShape(None);

    fn real(axes: &str) -> Layout {
        Layout::Real(axes.parse().unwrap())
    }

    fn file(header: &str, data: &[u8]) -> Vec<u8> {
        let length = (header.len() as u16).to_le_bytes();
        [MAGIC, &[1, 0], &length, header.as_bytes(), data].concat()
    }

    fn refused(header: &str, data: &[u8], words: &str) {
        let error = read(&file(header, data), &SHAPE).unwrap_err().to_string();
        assert!(error.contains(words), "{error:?} does not say {words:?}");
    }

    #[test]
    fn the_first_index_may_run_fastest() {
        // (2, 2, 2): chirp, sample, I or Q.
        let header =
            |order| format!("{{'descr': '|i1', 'fortran_order': {order}, 'shape': (2, 2, 2)}}");
        let rows = read(&file(&header("False"), &[0, 1, 2, 3, 4, 5, 6, 7]), &SHAPE).unwrap();
        let columns = read(&file(&header("True"), &[0, 4, 2, 6, 1, 5, 3, 7]), &SHAPE).unwrap();
        assert_eq!(rows.bytes, columns.bytes);
        assert_eq!(rows.samples_per_chirp, 2);
    }

    #[test]
    fn interleaved_and_complex() {
        let flat = "{'shape': (1, 4), 'descr': \">u2\", 'fortran_order': False}";
        let array = read(&file(flat, &[0; 8]), &SHAPE).unwrap();
        assert_eq!(
            (array.samples_per_chirp, array.format.big_endian),
            (2, true)
        );
        let complex = "{'descr': '<c8', 'fortran_order': False, 'shape': (1, 2), }";
        let array = read(&file(complex, &[0; 16]), &SHAPE).unwrap();
        assert_eq!((array.samples_per_chirp, array.format.bytes), (2, 4));
    }

    /// Two chirps of three samples: I 0, 1, 2 and Q 3, 4, 5 of the first.
    #[test]
    fn all_i_then_all_q_is_taken_where_shape_or_option_says_it() {
        let array = |shape: &str, layout: &Layout| {
            let header = format!("{{'descr': '|i1', 'fortran_order': False, 'shape': {shape}}}");
            let numbers: Vec<u8> = (0..12).collect();
            read(&file(&header, &numbers), layout)
        };
        let expected = [0, 3, 1, 4, 2, 5, 6, 9, 7, 10, 8, 11];
        for (shape, layout) in [
            ("(2, 6)", &Layout::Planar),
            ("(2, 2, 3)", &Layout::Planar),
            ("(2, 2, 3)", &SHAPE),
        ] {
            let array = array(shape, layout).unwrap();
            assert_eq!((array.samples_per_chirp, array.real), (3, false), "{shape}");
            assert_eq!(array.bytes, expected, "{shape}");
        }
        for shape in ["(12,)", "(4, 3)", "(1, 2, 3, 2)", "(2, 3, 2)"] {
            let error = array(shape, &Layout::Planar).unwrap_err().to_string();
            assert!(error.contains("--planar expects"), "{error}");
        }
    }

    #[test]
    fn rows_of_floating_point_are_not_halved_unless_it_is_said() {
        let array = |descr: &str, layout: &Layout| {
            let header = format!("{{'descr': '{descr}', 'fortran_order': False, 'shape': (2, 4)}}");
            read(
                &file(&header, &vec![0; if descr == "<f8" { 64 } else { 32 }]),
                layout,
            )
        };
        for descr in ["<f4", ">f4", "<f8"] {
            let error = array(descr, &SHAPE).unwrap_err().to_string();
            let options = ["--real chirp,sample", "--planar", "--samples-per-chirp 2"];
            assert!(options.iter().all(|o| error.contains(o)), "{error}");
            for (layout, samples, real) in [
                (Layout::ByShape(Some(2)), 2, false),
                (Layout::ByShape(Some(4)), 2, true),
                (Layout::Planar, 2, false),
                (real("chirp,sample"), 2, true),
            ] {
                let array = array(descr, &layout).unwrap();
                assert_eq!(
                    (array.samples_per_chirp, array.real),
                    (samples, real),
                    "{layout:?}"
                );
            }
        }
        // A converter's whole numbers, for which four samples are no pairs either.
        assert!(!array("<i4", &SHAPE).unwrap().real);
        assert!(array("<i4", &Layout::ByShape(Some(4))).unwrap().real);
    }

    /// Frames, receivers, chirps, samples: the second receiver of a cube as numpy stores it, in either order.
    #[test]
    fn one_receiver_of_real_samples_is_taken() {
        let shape = [2, 3, 2, 4];
        let header =
            |order| format!("{{'descr': '|u1', 'fortran_order': {order}, 'shape': (2, 3, 2, 4)}}");
        let cube: Vec<u8> = (0..48).collect();
        let axes = real("frame, receiver=1, chirp, sample");
        let rows = read(&file(&header("False"), &cube), &axes).unwrap();
        assert_eq!(rows.samples_per_chirp, 2);
        let expected: Vec<u8> = (8..16).chain(32..40).collect();
        assert_eq!(rows.bytes, expected);
        // Transposed twice it is the same again.
        let mut columns = vec![0; 48];
        for (k, at) in in_rows(&cube, &shape, 1).into_iter().enumerate() {
            columns[usize::from(at)] = k as u8;
        }
        let columns = read(&file(&header("True"), &columns), &axes).unwrap();
        assert_eq!(columns.bytes, expected);
        for (axes, words) in [
            ("chirp,sample", "4 axes, --real names 2"),
            ("frame,receiver=3,chirp,sample", "entry 3 of an axis of 3"),
        ] {
            let error = read(&file(&header("False"), &cube), &real(axes)).unwrap_err();
            assert!(error.to_string().contains(words), "{error}");
        }
        let flat = |descr: &str, samples: usize| {
            format!("{{'descr': '{descr}', 'fortran_order': False, 'shape': (1, {samples})}}")
        };
        let axes = real("chirp,sample");
        let error = read(&file(&flat("|i1", 3), &[0; 3]), &axes).unwrap_err();
        assert!(error.to_string().contains("3 real samples"), "{error}");
        let error = read(&file(&flat("<c8", 2), &[0; 16]), &axes).unwrap_err();
        assert!(error.to_string().contains("complex numbers"), "{error}");
        for wrong in [
            "",
            "sample,chirp",
            "sample,sample",
            "receiver,sample",
            "x=-1,sample",
        ] {
            assert!(wrong.parse::<Axes>().is_err(), "{wrong}");
        }
    }

    #[test]
    fn what_is_wrong_is_named() {
        let header = |descr: &str, shape: &str| {
            format!("{{'descr': '{descr}', 'fortran_order': False, 'shape': {shape}}}")
        };
        refused(
            &header("<c8", "(1, 2)"),
            &[0; 15],
            "15 bytes of data, expected 16",
        );
        refused(&header("<c8", "(4,)"), &[0; 32], "shape [4]");
        refused(&header("<i2", "(2, 3)"), &[0; 12], "shape [2, 3]");
        refused(&header("<c8", "(0, 2)"), &[], "the array is empty");
        refused(&header("<i8", "(1, 2)"), &[0; 16], "descr '<i8'");
        refused(&header("|O", "(1, 2)"), &[0; 16], "descr '|O'");
        refused(&header("<c8", "(1, -2)"), &[], "shape (1, -2)");
        let huge = format!("({0}, {0}, 2)", usize::MAX);
        refused(&header("<i2", &huge), &[], "more than there can be");
        refused("{'descr': [('i', '<i2')]}", &[], "descr: a structure");
        refused("{'descr': '<c8'}", &[], "fortran_order is missing");
        refused("", &[], "expected \"{\"");
        assert!(
            read(b"PK\x03\x04", &SHAPE)
                .unwrap_err()
                .to_string()
                .contains("numpy")
        );
    }

    proptest! {
        #[test]
        fn no_bytes_bring_it_down(bytes in proptest::collection::vec(any::<u8>(), 0..200)) {
            let _ = read(&bytes, &SHAPE);
            let _ = read(&[MAGIC, &bytes[..]].concat(), &SHAPE);
        }

        #[test]
        fn nor_any_header(header in "[{}()\\[\\]':,a-z0-9 <>|]{0,80}") {
            let _ = read(&file(&header, &[0; 8]), &SHAPE);
            let axes = real("chirp,sample");
            let _ = read(&file(&header, &[0; 8]), &axes);
            let _ = read(&file(&header, &[0; 8]), &Layout::Planar);
        }
    }
}
