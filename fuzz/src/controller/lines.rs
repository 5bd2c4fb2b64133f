//! Mutated lines: fields changed within a frame that stays right, and bytes changed anywhere.

use rand_core::{Rng, SeedableRng};
use rand_xoshiro::Xoshiro128PlusPlus;

use super::{Way, vectors};
use crate::mutate::Mutator;

/// Fields at which parsers go wrong.
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
    "SCAN",
    "STEP",
    "MAYBE",
    "BOOT",
    "STAT",
    "LIVE",
    "CONF",
    "DONE",
    "FAIL",
    "HALT",
    "PSTR",
    "PSTC",
    "MOTION",
    "set",
    "get",
    "seed",
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

/// An endless row of lines: the same for the same seed.
pub struct Lines<'a> {
    ways: &'a [Way],
    corpus: &'a [Vec<u8>],
    bytes: Mutator<'a>,
    random: Xoshiro128PlusPlus,
}

/// What the mutations are made of: the golden vectors.
pub fn corpus() -> (Vec<Way>, Vec<Vec<u8>>) {
    let all = vectors::all().into_iter();
    all.map(|(way, line)| (way, line.into_bytes())).unzip()
}

impl<'a> Lines<'a> {
    /// Mutations of [`corpus`].
    pub fn new((ways, corpus): (&'a [Way], &'a [Vec<u8>]), seed: u64) -> Self {
        Self {
            ways,
            corpus,
            bytes: Mutator::new(corpus, seed),
            random: Xoshiro128PlusPlus::seed_from_u64(!seed),
        }
    }

    /// A number below `end`, which is not 0.
    fn below(&mut self, end: usize) -> usize {
        let wide = u64::from(self.random.next_u32()) * end as u64;
        (wide >> 32) as usize
    }

    /// A vector: its way and what stands in its frame, or all of it where it has none.
    fn chosen(&mut self) -> (Way, Vec<String>) {
        let k = self.below(self.corpus.len());
        let line = String::from_utf8_lossy(&self.corpus[k]).into_owned();
        let body = line.strip_prefix('$').unwrap_or(&line);
        let body = body.rsplit_once('*').map_or(body, |(body, _)| body);
        (self.ways[k], body.split(',').map(str::to_owned).collect())
    }

    fn change(&mut self, fields: &mut Vec<String>) {
        let at = self.below(fields.len());
        match self.below(8) {
            0..=2 => fields[at] = ODD[self.below(ODD.len())].to_owned(),
            3 if fields.len() > 1 => drop(fields.remove(at)),
            4 => fields.insert(at, fields[at].clone()),
            5 => {
                // The same field of another line.
                let (_, other) = self.chosen();
                fields[at] = other.get(at).cloned().unwrap_or_default();
            }
            6 => {
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

    /// Some fields changed; the frame is right, or there is none.
    fn of_fields(&mut self) -> (Way, Vec<u8>) {
        let (way, mut fields) = self.chosen();
        for _ in 0..self.below(4) {
            self.change(&mut fields);
        }
        fields
            .iter_mut()
            .for_each(|field| field.retain(|c| c.is_ascii()));
        let body = fields.join(",");
        let line = match self.below(8) {
            0 => body,
            1 => vectors::closed(&body).to_lowercase(),
            2 => vectors::closed(&body) + ["\r\n", "\n", "\r", " "][self.below(4)],
            _ => vectors::closed(&body),
        };
        (way, line.into_bytes())
    }

    /// Some bytes changed, of a line or of what stands in its frame.
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
        Some(match self.below(4) {
            0 => self.of_bytes(),
            _ => self.of_fields(),
        })
    }
}
