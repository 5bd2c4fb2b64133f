//! Finds the order in which a scanner accepts the settings of a file.
//!
//! A scanner checks all of its settings at each `set`, so that `angle-count` may be refused before and accepted after
//! `angle-step`. The order is found on a copy of the scanner's settings, before anything is sent.

use std::collections::BTreeMap;

use stairscan::config::ConfigError;
use stairscan::scanner::Settings;

/// Name of a setting, and its value in the notation of commands.
pub type Change = (&'static str, String);
/// Name of a setting that is refused, and the expected value.
pub type Refused = (&'static str, ConfigError);

/// Returns the settings that a scanner has reported (`get`), given by name in the notation of
/// commands.
///
/// # Errors
/// This program would not accept a value: the scanner has another firmware version. The message
/// names the setting.
pub fn settings_of(values: &BTreeMap<String, String>) -> Result<Settings, ConfigError> {
    let mut settings = Settings::default();
    // The radar module's settings, which no command changes.
    let number = |key: &str| values.get(key).and_then(|value| value.parse::<u32>().ok());
    let radar = &mut settings.config.radar;
    radar.carrier_khz = number("radar-carrier").unwrap_or(radar.carrier_khz);
    radar.bandwidth_khz = number("radar-bandwidth").unwrap_or(radar.bandwidth_khz);
    let samples = number("radar-samples").and_then(|samples| samples.try_into().ok());
    radar.samples = samples.unwrap_or(radar.samples);
    let changes = Settings::KEYS
        .iter()
        .filter(|key| !key.starts_with("radar-"));
    let changes: Vec<Change> = changes
        .filter_map(|key| Some((*key, values.get(*key)?.clone())))
        .collect();
    match in_order(&settings, &changes) {
        Ok((_, settings)) => Ok(settings),
        Err(refused) => Err(refused[0].1),
    }
}

/// Returns `changes` in an order in which each is accepted, starting from `settings`, and the
/// resulting settings.
///
/// # Errors
/// The changes that are refused in any order, with the expected values.
pub fn in_order(
    settings: &Settings,
    changes: &[Change],
) -> Result<(Vec<Change>, Settings), Vec<Refused>> {
    let (mut settings, mut order) = (*settings, Vec::new());
    let mut left: Vec<Change> = changes.to_vec();
    loop {
        let before = left.len();
        left.retain(|(key, value)| {
            let taken = settings.set(key, value).is_ok();
            if taken {
                order.push((*key, value.clone()));
            }
            !taken
        });
        if left.is_empty() {
            return Ok((order, settings));
        }
        if left.len() == before {
            let refused = left.iter().filter_map(|(key, value)| {
                let error = settings.set(key, value).err()?;
                Some((*key, error))
            });
            return Err(refused.collect());
        }
    }
}
