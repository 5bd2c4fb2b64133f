//! Settings as words: what their hash is taken over, and what a record of them holds.

use super::settings::Settings;
use crate::report::crc;

/// What no default can know: how this scanner is mounted. Until each of these has been set or loaded,
/// no answer is `ok`.
pub const MOUNTING: [&str; 4] = ["plane", "mirror-offset", "mount-height", "home-angle"];

/// Words of a record.
pub const WORDS: usize = Settings::KEYS.len();

/// Which keys stand where, as one number (FNV-1a of all of them): a record of other keys is another
/// firmware's.
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

/// So many keys count in the hash, pace or not: those that came later are left out, so that it stays what it was.
const HASHED: usize = 44;

/// Whether `key` says only how fast, how patiently and by which clock a scan is made or who calibrated it, not
/// what comes of it; or stands with the radar module, which tells it at every scan.
fn is_pace(key: &str) -> bool {
    const PACE: [&str; 16] = [
        "radar-carrier",
        "radar-bandwidth",
        "radar-samples",
        "settle",
        "chirp-timeout",
        "configure-timeout",
        "connect-timeout",
        "retries",
        "max-lost",
        "fault-hold",
        "speed",
        "acceleration",
        "search-speed",
        "internal-clock",
        "calibrated",
        "calibrated-chip",
    ];
    PACE.contains(&key)
        || Settings::KEYS
            .iter()
            .skip(HASHED)
            .any(|later| *later == key)
}

impl Settings {
    /// CRC-32 (ISO-HDLC) of the values that decide an answer, in the order of `get`, as 32-bit
    /// little-endian words: numbers as they are, `cfar-false-alarm` as an IEEE float, words as their
    /// place in the list of `docs/hardware.md`, from 0. Left at 0: `settle`, the radar module's time-outs,
    /// `retries`, `max-lost`, `fault-hold`, `speed`, `search-speed`, `acceleration`, `internal-clock`,
    /// `calibrated`, `calibrated-chip` and what the radar module says (`radar-...`). `sweep-mode` and the keys
    /// behind it, which say how the mirror is turned and what the radar module is, are not among them.
    ///
    /// ```
    /// use stairscan::scan::Settings;
    ///
    /// let mut settings = Settings::default();
    /// let before = settings.hash();
    /// settings.set("chirp-timeout", "60000").unwrap();
    /// assert_eq!(settings.hash(), before);
    /// settings.set("mount-height", "41000").unwrap();
    /// assert_ne!(settings.hash(), before);
    /// ```
    pub fn hash(&self) -> u32 {
        let mut words = self.words();
        for (word, key) in words.iter_mut().zip(Self::KEYS) {
            if is_pace(key) {
                *word = 0;
            }
        }
        crc::of_words(words.get(..HASHED).unwrap_or(&words))
    }

    /// CRC-32 of everything, to the last bit: what memory must not change by itself. Whether samples are
    /// real stands in no word, for no record holds it.
    pub(super) fn seal(&self) -> u32 {
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
        // But what no record holds: the radar module says at every scan whether its samples are real.
        settings.config.radar.real = true;
        assert_ne!(settings.seal(), back.seal());
        assert_eq!(settings.hash(), back.hash());
        assert_eq!(Settings::from_words(&settings.words()), Some(back));
    }

    #[test]
    fn values_that_are_not_valid_are_not_used() {
        let good = Settings::default().words();
        for (key, word) in [
            ("plane", 2),
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
    fn every_key_is_in_the_hash_or_named_as_left_out() {
        let settings = Settings::default();
        let default = settings.words();
        for (k, key) in Settings::KEYS.iter().enumerate() {
            let mut words = default;
            words[k] ^= 1;
            // A value next to the default is valid for most keys; the others are looked at alone.
            let Some(other) = Settings::from_words(&words) else {
                continue;
            };
            assert_ne!(other.seal(), settings.seal(), "{key}");
            assert_eq!(other.hash() == settings.hash(), is_pace(key), "{key}");
        }
        for key in MOUNTING {
            assert!(Settings::key(key).is_some() && !is_pace(key), "{key}");
        }
        let pace = Settings::KEYS.iter().filter(|key| is_pace(key)).count();
        assert_eq!(pace, 33, "every name that is left out is a key");
        let later = &Settings::KEYS[HASHED..];
        assert!(later.iter().all(|key| is_pace(key)), "{later:?}");
        assert_eq!(Settings::KEYS[HASHED - 1], "calibrated-chip");
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
