//! Mutated lines: changed fields in a frame with a correct CRC, and changed bytes anywhere.

use std::collections::BTreeMap;

use rand_core::{Rng, SeedableRng};
use rand_xoshiro::Xoshiro128PlusPlus;

use super::{Way, vectors};
use crate::mutate::Mutator;

/// Fields with a high chance of parser errors, in addition to [`KINDS`].
const ODD: &[&str] = &[
    "",
    "-",
    "+",
    ".",
    "0",
    "00",
    "-0",
    "+0",
    "-1",
    "+1",
    "007",
    "255",
    "256",
    "65535",
    "65536",
    "4294967295",
    "4294967296",
    "18446744073709551616",
    "0.0",
    "-0.0",
    "+1.0",
    "1.",
    ".1",
    "1..",
    "1.0",
    "1.00",
    "1-0",
    "--1.0",
    "12.5",
    "-999.9",
    "100.0",
    "100.1",
    "214748364.7",
    "214748364.8",
    "-214748364.7",
    "-214748364.8",
    "00000000000000000000001.5",
    "45000",
    "-45000",
    "45001",
    "-45001",
    "ok",
    "degraded",
    "fault",
    "OK",
    "ok ",
    "none",
    "up",
    "down",
    "rise",
    "obstacle",
    "unknown",
    "on",
    "off",
    "lost-rows",
    "crash-loop",
    "+crash",
    "lost-rows+crash",
    "lost-rows++crash+",
    "lost-rows+crashed",
    "weak-echoes+weak-echoes",
    "00000000",
    "0123abCD",
    "+1234567",
    "0123456",
    "012345678",
    "0123456789abcdefABCDEF00",
    "PSTR",
    "PSTC",
    "seed",
    "20261122",
    "stack-used",
    "plane",
    "$",
    "*",
    "a*b",
    "$PSTC",
    "~",
    " ",
    "  x",
];

/// Kinds of lines with fields; all others are one kind.
const KINDS: &[&str] = &[
    "SCAN",
    "STEP",
    "DROP",
    "MAYBE",
    "GUARD",
    "BOOT",
    "CRASH",
    "STAT",
    "LIVE",
    "CONF",
    "DONE",
    "FAIL",
    "HALT",
    "get",
    "set",
    "guard",
    "watch",
    "calibrate",
    "MOTION",
];

/// A parsed golden vector.
#[derive(Clone, Debug)]
struct Origin {
    way: Way,
    framed: bool,
    /// Fields of the frame, or of the line without one.
    fields: Vec<String>,
}

impl Origin {
    fn new((way, line): (Way, String)) -> Self {
        let Some(body) = line.strip_prefix('$') else {
            let words = line.split([',', ' ']).map(str::to_owned);
            return Self {
                way,
                framed: false,
                fields: std::iter::once("PSTC".to_owned()).chain(words).collect(),
            };
        };
        let body = body.rsplit_once('*').map_or(body, |(body, _)| body);
        Self {
            way,
            framed: true,
            fields: body.split(',').map(str::to_owned).collect(),
        }
    }

    /// Returns its kind: direction, and the name of the sentence or command.
    fn kind(&self) -> (Way, Option<&'static str>) {
        let name = self.fields.get(1);
        let known = KINDS
            .iter()
            .find(|&&kind| name.is_some_and(|name| name == kind));
        (self.way, known.copied())
    }
}

/// An infinite sequence of lines, determined by the seed.
pub struct Lines<'a> {
    /// Golden vectors by kind: rare kinds are mutated as often as frequent ones.
    kinds: Vec<Vec<Origin>>,
    bytes: Mutator<'a>,
    random: Xoshiro128PlusPlus,
}

/// Returns the golden vectors as the corpus for mutations of bytes.
pub fn corpus() -> Vec<Vec<u8>> {
    let all = vectors::all().into_iter();
    all.map(|(_, line)| line.into_bytes()).collect()
}

impl<'a> Lines<'a> {
    /// Mutates the golden vectors, of which `corpus` consists.
    pub fn new(corpus: &'a [Vec<u8>], seed: u64) -> Self {
        let mut kinds: BTreeMap<_, Vec<Origin>> = BTreeMap::new();
        for origin in vectors::all().into_iter().map(Origin::new) {
            kinds.entry(origin.kind()).or_default().push(origin);
        }
        Self {
            kinds: kinds.into_values().collect(),
            bytes: Mutator::new(corpus, seed),
            random: Xoshiro128PlusPlus::seed_from_u64(!seed),
        }
    }

    /// Returns a random number below `end`, which is not 0.
    fn below(&mut self, end: usize) -> usize {
        let wide = u64::from(self.random.next_u32()) * end as u64;
        (wide >> 32) as usize
    }

    /// Returns a random vector of a kind.
    fn origin(&mut self, kind: usize) -> Origin {
        let k = self.below(self.kinds[kind].len());
        self.kinds[kind][k].clone()
    }

    fn change(&mut self, fields: &mut Vec<String>, kind: usize) {
        let at = self.below(fields.len());
        match self.below(12) {
            0..=5 => {
                // The same field of another line of this kind, or rarely of any kind.
                let any = self.below(self.kinds.len());
                let from = if self.below(8) == 0 { any } else { kind };
                let other = self.origin(from).fields;
                fields[at] = other.get(at).cloned().unwrap_or_default();
            }
            6 | 7 => {
                let k = self.below(ODD.len() + KINDS.len());
                let odd = ODD.iter().chain(KINDS).nth(k);
                fields[at] = odd.copied().unwrap_or_default().to_owned();
            }
            8 if fields.len() > 1 => drop(fields.remove(at)),
            9 => fields.insert(at, fields[at].clone()),
            10 => {
                let place = self.below(fields[at].len() + 1);
                let letter = char::from(b' ' + self.below(95) as u8);
                fields[at].insert(place, letter);
            }
            _ => {
                let place = self.below(fields[at].len() + 1);
                fields[at].truncate(place);
            }
        }
    }

    /// Returns a line with some changed fields, with a correct frame or without one.
    fn of_fields(&mut self) -> (Way, Vec<u8>) {
        let kind = self.below(self.kinds.len());
        let Origin {
            way,
            framed,
            mut fields,
        } = self.origin(kind);
        for _ in 0..self.below(4) {
            self.change(&mut fields, kind);
        }
        let between = if framed {
            ","
        } else {
            [",", " "][self.below(2)]
        };
        let body = fields.join(between);
        let line = match self.below(16) {
            0 => body,
            1 => vectors::closed(&body).to_lowercase(),
            2 => vectors::closed(&body) + ["\r\n", "\n", "\r", " "][self.below(4)],
            3 => vectors::closed(&format!("PSTC,{body}")),
            _ if framed => vectors::closed(&body),
            _ => body,
        };
        (way, line.into_bytes())
    }

    /// Returns a line with some changed bytes, or a correct frame with changed bytes in it.
    fn of_bytes(&mut self) -> (Way, Vec<u8>) {
        let way = [Way::Report, Way::Command][self.below(2)];
        let line = self.bytes.input();
        match (self.below(2), str::from_utf8(&line)) {
            (0, Ok(text)) => {
                let body = text.trim_start_matches('$');
                let body = body.rsplit_once('*').map_or(body, |(body, _)| body);
                (way, vectors::closed(body).into_bytes())
            }
            _ => (way, line),
        }
    }
}

impl Iterator for Lines<'_> {
    type Item = (Way, Vec<u8>);

    fn next(&mut self) -> Option<Self::Item> {
        Some(match self.below(8) {
            0 => self.of_bytes(),
            _ => self.of_fields(),
        })
    }
}
