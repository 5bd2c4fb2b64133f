//! Settings as 32-bit words: input of their hash and checksum, and layout of a record.

use super::settings::Settings;
use crate::crc;
use crate::setting::Effect;

/// Settings of the mounting, for which no default is right. Until each of these has been set or loaded, no
/// answer is `ok`.
pub const MOUNTING: [&str; 4] = ["plane", "mirror-offset", "mount-height", "home-angle"];

/// Number of values of a stored record, one 32-bit word for each setting.
pub const WORDS: usize = Settings::KEYS.len();

/// Hash of all keys in their order (FNV-1a): a record with other keys was written by another firmware.
pub const LAYOUT: u32 = layout();

const fn layout() -> u32 {
    const PRIME: u32 = 0x0100_0193;
    let (mut hash, mut k) = (0x811c_9dc5_u32, 0);
    while k < WORDS {
        let key = Settings::KEYS[k].as_bytes();
        let mut at = 0;
        while at < key.len() {
            hash = (hash ^ key[at] as u32).wrapping_mul(PRIME);
            at += 1;
        }
        hash = (hash ^ ',' as u32).wrapping_mul(PRIME);
        k += 1;
    }
    hash
}

impl Settings {
    /// CRC-32 (ISO-HDLC) of the settings that affect an answer, those that `docs/user/hardware.md` marks, in the
    /// order of its table, as 32-bit little-endian words: numbers as they are, `cfar-false-alarm` as an IEEE
    /// float, enumerated values as their index in the list of values, from 0. `chirps-per-row` is left out if it is 1.
    ///
    /// ```
    /// use stairscan::scanner::Settings;
    ///
    /// let mut settings = Settings::default();
    /// let before = settings.hash();
    /// settings.set("chirp-timeout", "60000").unwrap();
    /// assert_eq!(settings.hash(), before);
    /// settings.set("mount-height", "41000").unwrap();
    /// assert_ne!(settings.hash(), before);
    /// ```
    pub fn hash(&self) -> u32 {
        let (mut words, mut count) = ([0; WORDS], 0);
        self.see(&mut |row, value| {
            let enters = match row.effect {
                Effect::Answer => true,
                Effect::AnswerUnlessOne => value.number() != 1,
                Effect::Operation | Effect::Module => false,
            };
            if enters && let Some(word) = words.get_mut(count) {
                *word = value.word();
                count += 1;
            }
        });
        crc::of_words(words.get(..count).unwrap_or(&words))
    }

    /// CRC-32 of every bit of the settings, to detect memory corruption. The flag `radar.real` is added
    /// separately, since no record holds it.
    pub(super) fn checksum(&self) -> u32 {
        crc::of_words(&self.words()) ^ u32::from(self.config.radar.real)
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use proptest::prelude::*;

    #[test]
    fn every_setting_comes_back_to_the_last_bit() {
        let mut settings = Settings::default();
        assert_eq!(Settings::from_words(&settings.words()), Some(settings));
        settings.set("cfar-false-alarm", "123457").unwrap();
        settings.set("first-angle", "-15000").unwrap();
        settings.set("estimator", "paper").unwrap();
        settings.set("sweep", "up").unwrap();
        settings.set("motion", "required").unwrap();
        settings.config.radar.samples = 256;
        settings.config.radar.bandwidth_khz = 5_000_000;
        let back = Settings::from_words(&settings.words()).unwrap();
        assert_eq!(back, settings);
        let alarm = |s: &Settings| s.config.cfar.false_alarm.to_bits();
        assert_eq!(alarm(&back), alarm(&settings));
        // `radar.real` is in no record: the radar module reports at every scan whether its samples are real.
        settings.config.radar.real = true;
        assert_ne!(settings.checksum(), back.checksum());
        assert_eq!(settings.hash(), back.hash());
        assert_eq!(Settings::from_words(&settings.words()), Some(back));
    }

    #[test]
    fn values_that_are_not_valid_are_not_used() {
        let good = Settings::default().words();
        for (key, word) in [
            ("plane", 3),
            ("estimator", 100),
            ("cfar-guard", 256),
            ("angle-count", 2),
            ("angle-count", 65_536),
            ("cfar-false-alarm", f32::NAN.to_bits()),
            ("radar-samples", 70_000),
        ] {
            let mut words = good;
            words[Settings::KEYS.iter().position(|&k| k == key).unwrap()] = word;
            assert_eq!(Settings::from_words(&words), None, "{key}");
        }
    }

    #[test]
    fn the_hash_is_over_what_decides_an_answer() {
        let settings = Settings::default();
        let default = settings.words();
        let mut effects = Vec::new();
        settings.see(&mut |row, _| effects.push((row.key, row.effect)));
        for (k, &(key, effect)) in effects.iter().enumerate() {
            // The nearest value that is valid alone; if there is none, the structure is changed unchecked.
            let other = (1..4096).find_map(|by| {
                let mut words = default;
                words[k] ^= by;
                Settings::from_words(&words)
            });
            let other = other.unwrap_or_else(|| {
                let mut other = settings;
                let mut at = 0;
                other.each(&mut |_, value| {
                    if at == k {
                        value.restore(default[k] ^ 1).unwrap();
                    }
                    at += 1;
                });
                other
            });
            assert_ne!(other.checksum(), settings.checksum(), "{key}");
            let hashed = matches!(effect, Effect::Answer | Effect::AnswerUnlessOne);
            assert_eq!(other.hash() != settings.hash(), hashed, "{key}");
        }
        let hashed = |key| effects.contains(&(key, Effect::Answer));
        assert!(MOUNTING.iter().all(|key| hashed(*key)));
        assert!(hashed("microsteps-per-turn"));
    }

    /// A controller that knows the hash of its scanner's settings keeps it over the update that brings the setting.
    #[test]
    fn one_chirp_per_row_leaves_the_hash_as_it_was() {
        let mut settings = Settings::default();
        let mut hashed = Vec::new();
        settings.see(&mut |row, value| {
            if row.effect == Effect::Answer {
                hashed.push(value.word());
            }
        });
        assert_eq!(settings.hash(), crc::of_words(&hashed));
        settings.set("chirps-per-row", "8").unwrap();
        let eight = settings.hash();
        assert_ne!(eight, crc::of_words(&hashed));
        settings.set("chirps-per-row", "16").unwrap();
        assert_ne!(settings.hash(), eight);
        settings.set("chirps-per-row", "1").unwrap();
        assert_eq!(settings.hash(), crc::of_words(&hashed));
    }

    proptest! {
        #[test]
        fn any_words_are_valid_settings_or_none(
            words in proptest::array::uniform32(any::<u32>()), more in any::<[u32; WORDS - 32]>()
        ) {
            let mut all = [0; WORDS];
            all[..32].copy_from_slice(&words);
            all[32..].copy_from_slice(&more);
            if let Some(settings) = Settings::from_words(&all) {
                prop_assert!(settings.validate().is_ok());
            }
        }
    }
}
