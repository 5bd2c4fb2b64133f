//! Reader of `.bin` files of TI's DCA1000 capture card, with a TOML file that describes the radar's
//! settings.
//!
//! The file contains only 16-bit little-endian words (TI, "mmWave Radar Device ADC Raw Data
//! Capture", SWRA581), in one of two orders:
//!
//! | lanes | devices | words |
//! |---|---|---|
//! | 2 | xWR16xx, xWR18xx, xWR64xx, xWR68xx | for each chirp one receiver after the other, each with pairs of samples: I₀ I₁ Q₀ Q₁, I₂ I₃ Q₂ Q₃, … |
//! | 4 | xWR12xx, xWR14xx, xWR22xx | for each sample I of all four lanes, then Q of all four: I₀ I₁ I₂ I₃ Q₀ Q₁ Q₂ Q₃; always four lanes; those of disabled receivers hold no data |
//!
//! Converters of fewer than 16 bits require sign extension by the reader. Real samples are
//! rejected: their half of the spectrum is not known, and the scanner's transform is complex.

use anyhow::{Result, anyhow, ensure};
use serde::Deserialize;
use stairscan::Iq;

/// Number of lanes of the 4-lane devices, and maximum number of receivers.
const MAX_RECEIVERS: usize = 4;

/// Order of I and Q within a complex sample.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Deserialize)]
#[serde(rename_all = "lowercase")]
pub enum Order {
    /// I first, as mmWave Studio sets by default.
    #[default]
    Iq,
    /// Q first (`iqSwapSel` 1): without swapping back, targets would beat at negative frequencies.
    Qi,
}

/// Content of the TOML file: the radar's settings during the capture.
#[derive(Clone, Debug, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Setup {
    /// Number of bits of the converter: 12, 14 or 16.
    pub adc_bits: u32,
    /// Number of LVDS lanes of the device: 2 or 4.
    pub lanes: usize,
    /// Number of receivers that were on: 1 to 4.
    pub receivers: usize,
    /// The receiver to take, from 0; with four lanes the number of its lane.
    pub receiver: usize,
    /// Number of complex samples of one chirp.
    pub samples_per_chirp: usize,
    /// Number of chirps of one frame.
    pub chirps_per_frame: usize,
    /// The one chirp of each frame to take, from 0; all chirps if absent.
    pub chirp: Option<usize>,
    /// Whether the captured samples are complex; real ones are rejected.
    pub complex: bool,
    /// Order of I and Q.
    #[serde(default)]
    pub iq_order: Order,
}

impl Setup {
    /// Parses the text of a TOML file.
    ///
    /// # Errors
    /// Begins with line and message if the text is no TOML; else names the key and the expected value.
    pub fn parse(text: &str) -> Result<Self> {
        let setup: Self = toml::from_str(text).map_err(|e| {
            let start = e.span().map_or(0, |s| s.start);
            let line = text.get(..start).unwrap_or_default().matches('\n').count() + 1;
            let message = e.message().split_whitespace().collect::<Vec<_>>().join(" ");
            anyhow!("line {line}: {message}")
        })?;
        setup.check()?;
        Ok(setup)
    }

    fn check(&self) -> Result<()> {
        ensure!(
            self.complex,
            "complex: false: real samples do not contain the sign of the beat frequency; expected a \
             capture of complex samples (complex 1x or 2x)"
        );
        ensure!(
            matches!(self.adc_bits, 12 | 14 | 16),
            "adc_bits: {}: expected 12, 14 or 16",
            self.adc_bits
        );
        ensure!(
            matches!(self.lanes, 2 | 4),
            "lanes: {}: expected 2 or 4",
            self.lanes
        );
        ensure!(
            (1..=MAX_RECEIVERS).contains(&self.receivers),
            "receivers: {}: expected 1 to {MAX_RECEIVERS}",
            self.receivers
        );
        let stored = self.stored_receivers();
        ensure!(
            self.receiver < stored,
            "receiver: {}: expected 0 to {}",
            self.receiver,
            stored - 1
        );
        ensure!(
            (1..=65_536).contains(&self.samples_per_chirp),
            "samples_per_chirp: {}: expected 1 to 65536",
            self.samples_per_chirp
        );
        ensure!(
            (1..=65_536).contains(&self.chirps_per_frame),
            "chirps_per_frame: {}: expected 1 to 65536",
            self.chirps_per_frame
        );
        ensure!(
            self.chirp.is_none_or(|chirp| chirp < self.chirps_per_frame),
            "chirp: {}: expected 0 to {}",
            self.chirp.unwrap_or_default(),
            self.chirps_per_frame - 1
        );
        let in_chirp = self.samples_per_chirp * self.receivers;
        ensure!(
            self.lanes == 4 || in_chirp.is_multiple_of(2),
            "samples_per_chirp: {} of {} receiver: two lanes hold samples two by two, expected an even \
             number of samples in a chirp",
            self.samples_per_chirp,
            self.receivers
        );
        Ok(())
    }

    /// Returns the number of receivers for which the file contains words: all four with four lanes, else those that
    /// were on.
    fn stored_receivers(&self) -> usize {
        if self.lanes == 4 {
            MAX_RECEIVERS
        } else {
            self.receivers
        }
    }

    /// Returns the indices of the words that hold I and Q of sample `n` of chirp `k`, counted in the file.
    fn place(&self, k: usize, n: usize) -> (usize, usize) {
        let (ns, all) = (self.samples_per_chirp, self.stored_receivers());
        let (i, q) = match self.lanes {
            4 => {
                let first = 2 * all * (k * ns + n) + self.receiver;
                (first, first + all)
            }
            _ => {
                let sample = (k * all + self.receiver) * ns + n;
                let first = 4 * (sample / 2) + sample % 2;
                (first, first + 2)
            }
        };
        match self.iq_order {
            Order::Iq => (i, q),
            Order::Qi => (q, i),
        }
    }

    /// Converts a 16-bit word of the file to a sample, scaled from the converter's full scale to that of a recording.
    fn value(&self, word: [u8; 2]) -> i16 {
        // Shifted to the upper bits, which puts the sign bit in place and drops the bits above it.
        i16::from_le_bytes(word) << (16 - self.adc_bits)
    }

    /// Returns the chosen receiver's samples, chirp after chirp.
    ///
    /// # Errors
    /// The file does not hold whole frames.
    pub fn samples(&self, file: &[u8]) -> Result<Vec<Iq>> {
        let chirp = 4 * self.stored_receivers() * self.samples_per_chirp;
        let frame = chirp * self.chirps_per_frame;
        ensure!(
            !file.is_empty(),
            "empty: expected frames of {frame} bytes; did the capture card record?"
        );
        ensure!(
            file.len().is_multiple_of(frame),
            "{} bytes, expected whole frames of {frame} bytes ({} chirps of {} samples of {} receivers of 4 \
             bytes): a wrong key, or a capture cut off ({} bytes too many)",
            file.len(),
            self.chirps_per_frame,
            self.samples_per_chirp,
            self.stored_receivers(),
            file.len() % frame
        );
        let (words, _) = file.as_chunks::<2>();
        let taken = |k: &usize| {
            self.chirp
                .is_none_or(|chirp| k % self.chirps_per_frame == chirp)
        };
        let word = |at: usize| words.get(at).map_or(0, |word| self.value(*word));
        let samples = (0..file.len() / chirp).filter(taken).flat_map(|k| {
            (0..self.samples_per_chirp).map(move |n| {
                let (i, q) = self.place(k, n);
                Iq::new(word(i), word(q))
            })
        });
        Ok(samples.collect())
    }
}

#[cfg(test)]
mod tests {
    use proptest::prelude::*;

    use super::*;

    const SETUP: &str = "adc_bits = 16\nlanes = 2\nreceivers = 2\nreceiver = 1\nsamples_per_chirp = 2\n\
                         chirps_per_frame = 2\ncomplex = true\n";

    fn words(words: impl IntoIterator<Item = i16>) -> Vec<u8> {
        words.into_iter().flat_map(i16::to_le_bytes).collect()
    }

    fn setup(changes: &[(&str, &str)]) -> Result<Setup> {
        let mut text = SETUP.to_owned();
        for (old, new) in changes {
            text = text.replace(old, new);
        }
        Setup::parse(&text)
    }

    #[test]
    fn two_lanes_hold_receivers_in_turn_and_samples_two_by_two() {
        // Two chirps, each of two receivers of two samples: I I Q Q.
        let file = words(0..16);
        let samples = setup(&[]).unwrap().samples(&file).unwrap();
        let expected = [(4, 6), (5, 7), (12, 14), (13, 15)];
        assert_eq!(samples, expected.map(|(i, q)| Iq::new(i, q)));
        let second = setup(&[("complex", "chirp = 1\niq_order = \"qi\"\ncomplex")]).unwrap();
        let expected = [(14, 12), (15, 13)];
        assert_eq!(
            second.samples(&file).unwrap(),
            expected.map(|(i, q)| Iq::new(i, q))
        );
    }

    #[test]
    fn four_lanes_hold_i_of_all_before_q_of_all() {
        let four = setup(&[("lanes = 2", "lanes = 4"), ("receiver = 1", "receiver = 3")]).unwrap();
        let samples = four.samples(&words(0..32)).unwrap();
        let expected = [(3, 7), (11, 15), (19, 23), (27, 31)];
        assert_eq!(samples, expected.map(|(i, q)| Iq::new(i, q)));
    }

    #[test]
    fn twelve_bits_have_their_sign_in_the_twelfth() {
        let twelve = setup(&[("adc_bits = 16", "adc_bits = 12")]).unwrap();
        let minus_one = 0x0fff;
        let samples = twelve.samples(&words([minus_one; 16])).unwrap();
        assert!(samples.iter().all(|s| (s.i, s.q) == (-16, -16)));
    }

    #[test]
    fn what_is_wrong_is_named() {
        for (old, new, word) in [
            (
                "complex = true",
                "complex = false",
                "complex: false: real samples",
            ),
            ("lanes = 2", "lanes = 3", "lanes: 3"),
            ("adc_bits = 16", "adc_bits = 10", "adc_bits: 10"),
            ("receivers = 2", "receivers = 9", "receivers: 9"),
            (
                "receiver = 1",
                "receiver = 2",
                "receiver: 2: expected 0 to 1",
            ),
            (
                "chirps_per_frame = 2",
                "chirps_per_frame = 0",
                "chirps_per_frame: 0",
            ),
            ("lanes = 2", "lane = 2", "line 2: unknown field `lane`"),
            ("lanes = 2\n", "", "missing field `lanes`"),
            ("complex = true", "complex = ", "line 7"),
        ] {
            let error = setup(&[(old, new)]).unwrap_err().to_string();
            assert!(error.contains(word), "{error:?} does not say {word:?}");
        }
        let short = setup(&[])
            .unwrap()
            .samples(&[0; 40])
            .unwrap_err()
            .to_string();
        assert!(
            short.contains("40 bytes, expected whole frames of 32"),
            "{short}"
        );
    }

    proptest! {
        #[test]
        fn no_setup_and_no_bytes_bring_it_down(
            numbers in proptest::collection::vec(0usize..20, 7),
            bytes in proptest::collection::vec(any::<u8>(), 0..300),
        ) {
            let keys = ["adc_bits", "lanes", "receivers", "receiver", "samples_per_chirp",
                        "chirps_per_frame", "chirp"];
            let mut text = "complex = true\n".to_owned();
            for (key, number) in keys.iter().zip(numbers) {
                text.push_str(&format!("{key} = {number}\n"));
            }
            if let Ok(setup) = Setup::parse(&text) {
                let _ = setup.samples(&bytes);
            }
        }
    }
}
