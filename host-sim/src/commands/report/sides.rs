//! The two sides of `report --compare`: recordings, and the settings for scanning each of them.

use std::path::{Path, PathBuf};
use std::str::FromStr;

use anyhow::{Context, Result, anyhow, bail, ensure};
use stairscan::config::{MountConfig, Plane, Planes};

use crate::html::compare::Side;
use crate::playback::Playback;
use crate::recording::{MirrorSetup, Recording};
use crate::replay::Options;
use crate::setting_file::table::{self, Row};

/// Settings that can be changed for the scan of a recording; all others are given by the recording, or have no
/// effect.
const KEYS: [&str; 20] = [
    "estimator",
    "seed",
    "motion",
    "plane",
    "mount-height",
    "mirror-offset",
    "beamwidth",
    "mirror-echo",
    "mirror-level",
    "range-scale",
    "cfar-guard",
    "cfar-training",
    "cfar-false-alarm",
    "cfar-near-margin",
    "particles",
    "modes",
    "spread",
    "rounds",
    "mode-sigma",
    "vigilance",
];

/// Settings of one side in command-line syntax: `mount-height=43cm,seed=7`.
#[derive(Clone, Debug)]
pub struct Set {
    text: String,
    /// Settings in the order of the command line's text: the row in the table of settings, and the value as the
    /// scanner's commands write it.
    values: Vec<(&'static Row, String)>,
}

impl FromStr for Set {
    type Err = String;

    fn from_str(text: &str) -> Result<Self, String> {
        let value = |pair: &str| {
            let (key, value) = pair
                .split_once('=')
                .ok_or_else(|| format!("{pair:?}: expected KEY=VALUE"))?;
            let (key, value) = (key.trim(), value.trim());
            let row = KEYS.iter().find(|known| **known == key);
            let row = row
                .and_then(|key| table::row(key))
                .ok_or_else(|| format!("{key:?}: expected one of {}", KEYS.join(", ")))?;
            Ok((row, row.without_unit(value)?))
        };
        Ok(Self {
            text: text.to_owned(),
            values: text.split(',').map(value).collect::<Result<_, String>>()?,
        })
    }
}

impl Set {
    /// Returns the settings as they stand on the command line.
    pub fn words(&self) -> &str {
        &self.text
    }
}

/// Arguments of the command line for a comparison.
pub struct Wanted<'a> {
    /// Paths of two recordings, or of one that is compared under two settings.
    pub paths: &'a [PathBuf],
    /// Options for scanning that the command line gives, and a text with those that differ from the defaults.
    pub given: (Options, String),
    /// The scanner's default options.
    pub defaults: Options,
    /// Settings of `--with`: of the second side, or of both in order.
    pub sets: &'a [Set],
}

/// Returns the first and the second side of a comparison.
///
/// # Errors
/// There are not two sides to compare, a recording cannot be read, or a setting cannot be used for its scans.
pub fn sides(wanted: &Wanted<'_>) -> Result<[Side; 2]> {
    let Wanted {
        paths,
        given: (given, words),
        defaults,
        sets,
    } = wanted;
    ensure!(
        sets.len() <= 2,
        "--with: found {} sets, expected one for the second side, or two",
        sets.len()
    );
    let (first, second) = match paths {
        [one] => (one, one),
        [first, second] => (first, second),
        many => bail!(
            "--compare: found {} recordings, expected two, or one under two settings",
            many.len()
        ),
    };
    // For a single recording without `--with` sets, the options belong to the second side.
    let options_differ = first == second && sets.is_empty();
    ensure!(
        !options_differ || !words.is_empty(),
        "--compare: found one recording under one setting, expected a second recording, --with KEY=VALUE, \
         or another --estimator, --seed or --single"
    );
    let sets = match sets {
        [] => [None, None],
        [second] => [None, Some(second)],
        [first, second, ..] => [Some(first), Some(second)],
    };
    let names = names([first, second]);
    let [first_name, second_name] = names;
    let base = if options_differ { defaults } else { given };
    let mut second = side(second, second_name, given, sets[1])?;
    if options_differ {
        second.name = format!("{} with {words}", second.name);
    }
    Ok([side(first, first_name, base, sets[0])?, second])
}

/// Returns the names of two recordings, with their directories if the names are equal.
fn names([first, second]: [&PathBuf; 2]) -> [String; 2] {
    let stems = [first, second].map(|path| crate::recording::name_of(path));
    if stems[0] != stems[1] || first == second {
        return stems;
    }
    [first, second].map(|path| path.with_extension("").display().to_string())
}

fn side(path: &Path, name: String, options: &Options, set: Option<&Set>) -> Result<Side> {
    let mut side = Side {
        name,
        recording: Recording::read(path)?,
        options: *options,
    };
    if let Some(set) = set {
        apply(&mut side, set).with_context(|| format!("--with {}", set.text))?;
        side.name = format!("{} with {}", side.name, set.text.replace(',', ", "));
    }
    Ok(side)
}

/// Applies the settings of `set` to a side: to the recording's mounting, and to the options for scanning it.
fn apply(side: &mut Side, set: &Set) -> Result<()> {
    let Side {
        recording, options, ..
    } = side;
    let mut settings = Playback::new(recording, &options.config)?.settings();
    for (row, value) in &set.values {
        settings.set(row.key, value).map_err(|e| {
            let expected = match row.range() {
                range if e.field == row.key && !range.is_empty() => range,
                _ => e.expected.to_owned(),
            };
            anyhow!(
                "{}: found {}, expected {expected}",
                e.field,
                row.with_unit(value)
            )
        })?;
        if row.key == "motion" {
            options.motion = Some(settings.motion);
        }
    }
    options.config = settings.config;
    let mirror = recording
        .meta
        .mirror
        .as_ref()
        .context("a recording without a mirror")?;
    let is_given = |key: &str| set.values.iter().any(|(row, _)| row.key == key);
    recording.meta.mirror = Some(mount(&settings.config.mount, mirror, is_given)?);
    Ok(())
}

/// Returns the mounting `own` of a recording, in which the values of `set` replace those whose keys `is_given` selects.
fn mount(
    set: &MountConfig,
    own: &MirrorSetup,
    is_given: impl Fn(&str) -> bool,
) -> Result<MirrorSetup> {
    let metres = |key, value: i32, own| match is_given(key) {
        true => f64::from(value) * 1e-5,
        false => own,
    };
    let plane = match (is_given("plane"), set.plane) {
        (false, _) => own.plane,
        (true, Planes::Depth) => Plane::Depth,
        (true, Planes::Height) => Plane::Height,
        (true, Planes::Both) => {
            bail!("plane: found both, expected depth or height: a recording has one plane")
        }
    };
    Ok(MirrorSetup {
        offset_m: metres("mirror-offset", set.mirror_offset, own.offset_m),
        mount_height_m: metres("mount-height", set.mount_height, own.mount_height_m),
        beamwidth_deg: match is_given("beamwidth") {
            true => f64::from(set.beamwidth) * 1e-3,
            false => own.beamwidth_deg,
        },
        plane,
    })
}
