//! The settings in force: whether somebody vouches for them, and whether memory still holds them.

use super::planes::plane_of;
use crate::config::{ConfigError, Plane, Planes, RadarConfig};
use crate::drive::Mode;
use crate::scanner::record::MOUNTING;
use crate::scanner::settings::{Settings, Switch};

/// The settings in force. They change by [`Keeper::change`] and [`Keeper::adopt`] only.
#[derive(Debug)]
pub(super) struct Keeper {
    settings: Settings,
    /// Of `settings`: memory must not change them by itself.
    seal: u32,
    /// Hash of `settings`.
    hash: u32,
    /// Which of [`MOUNTING`] are still to come, a bit each.
    missing: u8,
}

/// Memory has changed what was set.
const DAMAGED: ConfigError = ConfigError {
    field: "settings",
    expected: "a reset first: memory has changed them",
};

impl Keeper {
    /// After boot: the settings that were saved, or else defaults for which nobody vouches. `before` is
    /// the hash of those in force before a reset: where it is another, something was set and not
    /// saved, and what was saved is not what was asked for.
    #[inline(never)]
    pub fn new(stored: Option<Settings>, before: Option<u32>) -> Self {
        let settings = stored.unwrap_or_default();
        let hash = settings.hash();
        let known = stored.is_some() && before.is_none_or(|before| before == hash);
        Self {
            settings,
            seal: settings.seal(),
            hash,
            missing: if known { 0 } else { (1 << MOUNTING.len()) - 1 },
        }
    }

    /// The settings.
    pub fn get(&self) -> &Settings {
        &self.settings
    }

    /// Their hash.
    pub fn hash(&self) -> u32 {
        self.hash
    }

    /// Whether somebody vouches for them: they were saved, or the scanner has been told since boot how
    /// it is mounted.
    pub fn configured(&self) -> bool {
        self.missing == 0
    }

    /// Whether they are still those that were set.
    #[inline(never)]
    pub fn intact(&self) -> bool {
        self.settings.seal() == self.seal
    }

    /// Takes what they became by setting `key`, unless memory has changed them: then nobody knows what
    /// else would be vouched for.
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

    /// Keeps what the module says, so that commands are checked against it, unless no scan can be
    /// made of it: then the scan says so, and commands must still work.
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
        self.seal = settings.seal();
        self.hash = settings.hash();
    }

    /// Whether they may be saved: nobody's defaults may become somebody's settings.
    pub fn fit_to_save(&self) -> Result<(), ConfigError> {
        let needed = MOUNTING.get(self.missing.trailing_zeros() as usize);
        match needed {
            _ if !self.intact() => Err(DAMAGED),
            Some(&field) => Err(ConfigError {
                field,
                expected: "to be set before: how the scanner is mounted",
            }),
            None => Ok(()),
        }
    }
}

/// What of a scan's settings is told with it or needed after it: others may have come meanwhile.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) struct ScanSettings {
    /// Their hash.
    pub hash: u32,
    /// Whether somebody vouches for them.
    pub configured: bool,
    /// What holds without motion input.
    pub motion: Mode,
    /// Whether earlier scans have a say.
    pub fusion: Switch,
    /// Duration of a chirp.
    pub chirp_us: u32,
    /// Which planes there are.
    pub planes: Planes,
    /// The plane that it is made in.
    pub plane: Plane,
    /// Whether it is a guard sweep.
    pub guard: bool,
}

impl ScanSettings {
    /// Those that a scan begins with now; `below` says that the answer before asks for the height plane.
    pub fn of(keeper: &Keeper, below: bool) -> Self {
        let planes = keeper.get().config.mount.plane;
        Self {
            planes,
            plane: plane_of(planes, below),
            guard: false,
            hash: keeper.hash(),
            configured: keeper.configured(),
            motion: keeper.get().motion,
            fusion: keeper.get().fusion,
            chirp_us: keeper.get().timing.chirp_duration,
        }
    }

    /// Whether it comes in between scans of the other plane.
    pub fn stands_aside(&self) -> bool {
        self.plane != self.planes.first()
    }

    /// The plane, where settings alone do not say it.
    pub fn told_plane(&self) -> Option<Plane> {
        (self.planes == Planes::Both).then_some(self.plane)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn every_bit_that_memory_changes_is_found() {
        let keeper = Keeper::new(Some(Settings::default()), None);
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
            let mut keeper = Keeper::new(Some(Settings::default()), None);
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
        let mut keeper = Keeper::new(None, None);
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
    fn what_a_reset_lost_is_told() {
        let mut other = Settings::default();
        other.set("mount-height", "41000").unwrap();
        let saved = Some(Settings::default());
        assert!(Keeper::new(saved, None).configured());
        assert!(Keeper::new(saved, Some(Settings::default().hash())).configured());
        assert!(!Keeper::new(saved, Some(other.hash())).configured());
    }
}
