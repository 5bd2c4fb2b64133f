//! The settings in force: whether they were configured, and whether memory still holds them unchanged.

use super::planes::plane_of;
use crate::config::{ConfigError, Plane, Planes, RadarConfig};
use crate::drive::Mode;
use crate::scanner::record::MOUNTING;
use crate::scanner::settings::{Settings, Switch};

/// The settings in force. Only [`ActiveSettings::change`] and [`ActiveSettings::adopt`] change them.
#[derive(Debug)]
pub(super) struct ActiveSettings {
    settings: Settings,
    /// Checksum of `settings`, to detect memory corruption.
    checksum: u32,
    /// [`Settings::hash`] of `settings`.
    hash: u32,
    /// Bit mask of the settings of the mounting that count as not set yet: bit k for entry k of [`MOUNTING`].
    missing: u8,
}

/// Error that is reported if memory has corrupted the settings in force.
const DAMAGED: ConfigError = ConfigError {
    field: "settings",
    expected: "a reset: the settings in memory are corrupted",
};

impl ActiveSettings {
    /// Creates the settings after boot: the saved ones, or else unconfigured defaults. `before` is the hash of
    /// the settings in force before a reset. If it differs, a setting was changed and not saved, so the saved
    /// settings count as unconfigured.
    #[inline(never)]
    pub fn new(stored: Option<Settings>, before: Option<u32>) -> Self {
        let settings = stored.unwrap_or_default();
        let hash = settings.hash();
        let known = stored.is_some() && before.is_none_or(|before| before == hash);
        Self {
            settings,
            checksum: settings.checksum(),
            hash,
            missing: if known { 0 } else { (1 << MOUNTING.len()) - 1 },
        }
    }

    /// Returns the settings in force.
    pub fn get(&self) -> &Settings {
        &self.settings
    }

    /// Returns the hash of the settings in force.
    pub fn hash(&self) -> u32 {
        self.hash
    }

    /// Whether the settings are configured: they were saved, or the whole mounting has been set since boot.
    pub fn configured(&self) -> bool {
        self.missing == 0
    }

    /// Whether memory still holds the settings unchanged, by their checksum.
    #[inline(never)]
    pub fn intact(&self) -> bool {
        self.settings.checksum() == self.checksum
    }

    /// Puts `settings` in force, in which `key` has changed. Fails if memory has corrupted the settings in force
    /// before: other values could be wrong, too.
    #[inline(never)]
    pub fn change(&mut self, key: &'static str, settings: &Settings) -> Result<(), ConfigError> {
        if !self.intact() {
            return Err(DAMAGED);
        }
        self.take(settings);
        if let Some(k) = MOUNTING.iter().position(|&needed| needed == key) {
            self.missing &= !(1 << k);
        }
        Ok(())
    }

    /// Puts in force the radar data that the module has reported, so that commands are checked against them.
    /// Ignores data with which no scan is possible: the scan reports that, and commands must still work.
    #[inline(never)]
    pub fn adopt(&mut self, radar: RadarConfig) {
        let mut settings = self.settings;
        settings.config.radar = radar;
        if radar != self.settings.config.radar && settings.validate().is_ok() && self.intact() {
            self.take(&settings);
        }
    }

    #[inline(never)]
    fn take(&mut self, settings: &Settings) {
        self.settings = *settings;
        self.checksum = settings.checksum();
        self.hash = settings.hash();
    }

    /// Whether the settings may be saved: not if they are corrupted, or if any entry of [`MOUNTING`] is still a
    /// default.
    pub fn fit_to_save(&self) -> Result<(), ConfigError> {
        let needed = MOUNTING.get(self.missing.trailing_zeros() as usize);
        match needed {
            _ if !self.intact() => Err(DAMAGED),
            Some(&field) => Err(ConfigError {
                field,
                expected: "to be set first: part of the mounting",
            }),
            None => Ok(()),
        }
    }
}

/// The settings of a scan that are reported with it or needed after it; the settings in force may have changed
/// in the meantime.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) struct ScanSettings {
    /// Hash of the settings with which the scan began.
    pub hash: u32,
    /// Whether the settings were configured when the scan began.
    pub configured: bool,
    /// Mode of the motion input, the setting `motion`.
    pub motion: Mode,
    /// Whether evidence of earlier scans is used, the setting `fusion`.
    pub fusion: Switch,
    /// Duration of a chirp by the setting `chirp-duration`, µs; 0: unknown.
    pub chirp_us: u32,
    /// The setting `plane`.
    pub planes: Planes,
    /// Plane of this scan.
    pub plane: Plane,
    /// Whether the scan is a guard sweep.
    pub guard: bool,
}

impl ScanSettings {
    /// Returns these settings for a scan that begins now; `height_requested` if the previous answer requests the
    /// height plane.
    pub fn of(active: &ActiveSettings, height_requested: bool) -> Self {
        let planes = active.get().config.mount.plane;
        Self {
            planes,
            plane: plane_of(planes, height_requested),
            guard: false,
            hash: active.hash(),
            configured: active.configured(),
            motion: active.get().motion,
            fusion: active.get().fusion,
            chirp_us: active.get().timing.chirp_duration,
        }
    }

    /// Whether the scan is in the other plane than the regular scans: with `plane both` the height plane.
    pub fn is_other_plane(&self) -> bool {
        self.plane != self.planes.first()
    }

    /// Returns the plane for the sentence `SCAN`; `None` if the setting `plane` alone determines it.
    pub fn reported_plane(&self) -> Option<Plane> {
        (self.planes == Planes::Both).then_some(self.plane)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn every_bit_that_memory_changes_is_found() {
        let keeper = ActiveSettings::new(Some(Settings::default()), None);
        assert!(keeper.intact() && keeper.configured() && keeper.fit_to_save().is_ok());
        let changes: [fn(&mut Settings); 6] = [
            |s| s.config.mount.mount_height ^= 1,
            |s| s.config.cfar.false_alarm *= 1.0 + f32::EPSILON,
            |s| s.timing.retries ^= 1,
            |s| s.motor.home_angle ^= 1 << 14,
            |s| s.config.radar.samples ^= 1 << 4,
            |s| s.config.radar.real ^= true,
        ];
        for change in changes {
            let mut keeper = ActiveSettings::new(Some(Settings::default()), None);
            change(&mut keeper.settings);
            assert!(!keeper.intact());
            let refused = keeper.change("seed", &Settings::default()).unwrap_err();
            assert_eq!(refused.field, "settings");
            assert_eq!(keeper.fit_to_save().unwrap_err().field, "settings");
            keeper.adopt(RadarConfig {
                samples: 100,
                ..RadarConfig::default()
            });
            assert!(!keeper.intact(), "what the module says does not heal it");
        }
    }

    #[test]
    fn only_how_the_scanner_is_mounted_configures_it() {
        let mut keeper = ActiveSettings::new(None, None);
        let settings = Settings::default();
        for &key in Settings::KEYS {
            if !MOUNTING.contains(&key) {
                keeper.change(key, &settings).unwrap();
            }
        }
        for key in MOUNTING {
            assert!(!keeper.configured());
            assert_eq!(keeper.fit_to_save().unwrap_err().field, key);
            keeper.change(key, &settings).unwrap();
        }
        assert!(keeper.configured() && keeper.fit_to_save().is_ok());
    }

    #[test]
    fn what_a_reset_lost_is_reported() {
        let mut other = Settings::default();
        other.set("mount-height", "41000").unwrap();
        let saved = Some(Settings::default());
        assert!(ActiveSettings::new(saved, None).configured());
        assert!(ActiveSettings::new(saved, Some(Settings::default().hash())).configured());
        assert!(!ActiveSettings::new(saved, Some(other.hash())).configured());
    }
}
