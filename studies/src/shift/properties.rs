//! Scenes drawn alike with one property of instrument or world moved out of the usual draw.

use anyhow::Result;
use host_sim::random::{balusters, change_materials, random_with, roughen};
use host_sim::recording::Recording;
use host_sim::scene::spec::{SceneSpec, Way};
use host_sim::simulation::scan_of;

use crate::harness::Drawn;

/// A property and the values to which it is moved.
#[derive(Clone, Copy)]
pub struct Property {
    /// Name of the property, as `--only` takes it.
    pub name: &'static str,
    /// Values to which it is moved, in order.
    pub values: &'static [f64],
    /// Unit of the values, with the sense in which they apply.
    pub unit: &'static str,
    /// Changes the scene.
    change: fn(&mut SceneSpec, f64),
}

/// One property moved to one value.
#[derive(Clone, Copy)]
pub struct Shift {
    /// The property.
    pub property: &'static Property,
    /// Value to which it is moved.
    pub value: f64,
}

/// The noise's shifts, dB: exact answers and `ok` must not fall along them.
pub const NOISE: &str = "noise";

/// All properties. Rain itself is none: its backscatter of 1e-3 m²/m³ (25 mm/h at 94 GHz; Currie, Dyer and Hayes 1975) in
/// a cell of 0.7 dm³ at 1 m is 15 dB below that of ground; what it leaves on the ground is `wet`.
pub const PROPERTIES: &[Property] = &[
    property(NOISE, &[6.0, -6.0, -12.0, -24.0], "dB", |s, db| {
        s.receiver.noise_figure_db += db;
    }),
    property("chirps-per-row", &[4.0, 16.0], "chirps", |s, n| {
        s.radar.chirps_per_row = n as u8;
    }),
    property("side-lobes", &[-16.0, -30.0, -45.0], "dB", |s, db| {
        s.mirror.sidelobe_db = -db;
        s.mirror.sidelobe_floor_db = 10.0 - db;
    }),
    property("phase-noise", &[10.0, -10.0], "dB more", |s, db| {
        s.receiver.phase_noise_dbc_hz += db;
    }),
    property("sweep-errors", &[0.25, 4.0], "times", |s, factor| {
        let receiver = &mut s.receiver;
        for error in [
            &mut receiver.sweep_slope,
            &mut receiver.sweep_bow,
            &mut receiver.sweep_ripple,
        ] {
            *error *= factor;
        }
    }),
    property("roughness", &[0.4, 2.5], "times", |s, factor| {
        change_materials(s, |m| roughen(m, factor));
    }),
    property("scatter", &[-5.0, 5.0], "dB more", |s, db| {
        change_materials(s, |m| m.diffuse_db += db);
    }),
    // A film of water: reflects as a mirror does, and what is rough lies below it.
    property("wet", &[1.0], "film", |s, _| {
        change_materials(s, |m| {
            m.permittivity = m.permittivity.max(7.0);
            m.roughness_m *= 0.3;
            m.diffuse_db -= 8.0;
        });
    }),
    property("leak", &[-10.0, 10.0], "dB more", |s, db| {
        s.receiver.leakage_dbfs = (s.receiver.leakage_dbfs + db).min(-6.0);
    }),
    property("yaw", &[0.0, 3.0, 6.0], "degrees", |s, deg| {
        s.mount.yaw_deg = deg
    }),
    property("angle-jitter", &[0.0, 4.0], "times", |s, factor| {
        s.mirror.jitter_deg *= factor;
    }),
    property("beam-width", &[0.9, 1.1], "times as stated", |s, factor| {
        s.mount.beamwidth_deg *= factor;
    }),
    property("mount-height", &[-0.01, 0.01], "m more", |s, m| {
        s.mount.height_error_m += m;
    }),
    property("balusters", &[0.08, 0.2], "m beside the beam", |s, m| {
        let up = s.stairs.iter().filter(|stairs| stairs.direction == Way::Up);
        let posts = up.flat_map(|stairs| balusters(stairs, m, 0.02, "metal"));
        s.post.extend(posts.collect::<Vec<_>>());
    }),
    property("several", &[1.0], "at once", |s, _| {
        s.receiver.noise_figure_db -= 12.0;
        s.mirror.sidelobe_db = 20.0;
        s.receiver.sweep_bow *= 2.0;
        s.receiver.sweep_ripple *= 2.0;
        change_materials(s, |m| {
            roughen(m, 1.6);
            m.diffuse_db += 3.0;
        });
    }),
];

const fn property(
    name: &'static str,
    values: &'static [f64],
    unit: &'static str,
    change: fn(&mut SceneSpec, f64),
) -> Property {
    Property {
        name,
        values,
        unit,
        change,
    }
}

impl Shift {
    /// Returns all shifts of the properties with these names; of every property if there are none.
    pub fn all(only: &[String]) -> Vec<Self> {
        let chosen = |p: &&Property| only.is_empty() || only.iter().any(|name| name == p.name);
        let of = |property: &'static Property| {
            let shift = move |&value: &f64| Self { property, value };
            property.values.iter().map(shift)
        };
        PROPERTIES.iter().filter(chosen).flat_map(of).collect()
    }

    /// Simulates a scan of a drawn scene with the property moved. What a recording states of its scanner stays as drawn.
    ///
    /// # Errors
    /// The scene cannot be built; the message names the cause.
    pub fn scan(&self, drawn: &Drawn) -> Result<Recording> {
        let mut spec = random_with(drawn.kind, drawn.kind.variety(), drawn.seed);
        let stated_deg = spec.mount.beamwidth_deg;
        (self.property.change)(&mut spec, self.value);
        let mut recording = scan_of(spec, &drawn.name(), drawn.seed)?;
        if let Some(mirror) = &mut recording.meta.mirror {
            mirror.beamwidth_deg = stated_deg;
        }
        Ok(recording)
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use host_sim::random::Kind;

    const DRAWN: Drawn = Drawn {
        kind: Kind::Beside,
        seed: 3,
    };

    #[test]
    fn every_shift_changes_the_samples_and_nothing_that_is_stated() {
        let plain = DRAWN.scan().unwrap();
        for shift in Shift::all(&[]) {
            let name = format!("{} {}", shift.property.name, shift.value);
            let moved = shift.scan(&DRAWN).unwrap();
            let same = moved.meta.angles_deg == plain.meta.angles_deg
                && moved.meta.mirror == plain.meta.mirror;
            assert!(same, "{name}");
            let chirp = |r: &Recording, row| r.chirp(row).unwrap().to_vec();
            let differs = (0..plain.meta.angles_deg.len())
                .any(|row| chirp(&plain, row) != chirp(&moved, row));
            assert!(differs, "{name}");
        }
    }

    #[test]
    fn names_are_unique_and_choose() {
        for property in PROPERTIES {
            let only = Shift::all(&[property.name.into()]);
            assert_eq!(only.len(), property.values.len());
        }
    }
}
