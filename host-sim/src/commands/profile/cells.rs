//! Cells of CA-CFAR for `profile`, the echoes that they hide from each other, and those removed as I/Q images.

use stairscan::config::CfarConfig;
use stairscan::signal::range::Profile;

/// Options of CA-CFAR; each is a setting of the scanner.
#[derive(clap::Args, Clone, Debug, Default)]
pub struct Cells {
    /// Guard cells on each side of a tested cell, 0 to 16; without it 3 (setting cfar-guard)
    #[arg(long, value_name = "N", value_parser = clap::value_parser!(u8).range(0..=16))]
    cfar_guard: Option<u8>,
    /// Training cells on each side beyond the guard cells, 1 to 32; without it 8 (setting cfar-training)
    #[arg(long, value_name = "N", value_parser = clap::value_parser!(u8).range(1..=32))]
    cfar_training: Option<u8>,
    /// Probability of false alarm per cell, 1e-9 to 0.5; without it 1.7e-4 (setting cfar-false-alarm)
    #[arg(long, value_name = "P", value_parser = probability)]
    cfar_false_alarm: Option<f32>,
}

fn probability(text: &str) -> Result<f32, String> {
    let value = text.parse().ok();
    let value = value.filter(|value| (1e-9..=0.5).contains(value));
    value.ok_or_else(|| "expected a probability from 1e-9 to 0.5".to_owned())
}

impl Cells {
    /// Returns `default` with the given options in place of its values.
    pub fn config(&self, default: CfarConfig) -> CfarConfig {
        CfarConfig {
            guard: self.cfar_guard.unwrap_or(default.guard),
            training: self.cfar_training.unwrap_or(default.training),
            false_alarm: self.cfar_false_alarm.unwrap_or(default.false_alarm),
            ..default
        }
    }
}

/// Level above the median of the tested bins from which a peak is an echo, dB. Of noise alone one bin in 10^9 exceeds the
/// median by so much.
const ECHO_DB: f32 = 15.0;
/// Maximum level of an echo's own sidelobes behind the Hann window, dB below its peak.
const SIDELOBE_DB: f32 = 30.0;

/// Returns the bins of a profile that hold an echo, and are no detection because other echoes lie in their training
/// cells.
pub fn masked(profile: &Profile, cfar: &CfarConfig) -> Vec<usize> {
    let tested: Vec<usize> = (0..profile.bins())
        .filter(|&bin| profile.threshold_db(bin).is_some())
        .collect();
    let level = |bin: usize| profile.power_db(bin);
    let mut levels: Vec<f32> = tested.iter().map(|&bin| level(bin)).collect();
    levels.sort_by(f32::total_cmp);
    let Some(median) = levels.get(levels.len() / 2) else {
        return Vec::new();
    };
    let reach = usize::from(cfar.guard) + usize::from(cfar.training);
    let is_masked = |&bin: &usize| {
        let around = tested.iter().filter(|&&other| other.abs_diff(bin) <= reach);
        let strongest = around.fold(f32::NEG_INFINITY, |most, &other| most.max(level(other)));
        is_peak(profile, bin)
            && !profile.is_hit(bin)
            && !profile.is_image(bin)
            && level(bin) > median + ECHO_DB
            && level(bin) > strongest - SIDELOBE_DB
    };
    tested.iter().copied().filter(is_masked).collect()
}

/// Returns the bins of a profile that hold an echo above its threshold, and are no detection because they may be the I/Q
/// image of the echo at their negative frequency.
pub fn images(profile: &Profile) -> Vec<usize> {
    let inner = 0..profile.bins().saturating_sub(1);
    inner
        .filter(|&bin| profile.is_image(bin) && is_peak(profile, bin))
        .collect()
}

/// Returns whether a bin has more power than the bin before, and no less than the next one.
fn is_peak(profile: &Profile, bin: usize) -> bool {
    let level = |bin: usize| profile.power_db(bin);
    bin > 0 && level(bin - 1) < level(bin) && level(bin) >= level(bin + 1)
}
