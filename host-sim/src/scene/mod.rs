//! The project's radar simulator: scene files in, recordings out.
//!
//! A scene is a profile in the plane that the mirror sweeps ([`shapes`], [`geometry`]), cut into
//! facets shorter than a quarter wavelength with a random relief ([`facets`]). Physical optics,
//! edge diffraction and inner corners turn them into echoes ([`scatter`], [`edge`], [`sight`]),
//! once per scan. The beam ([`beam`]) weights the echoes anew at every angle, the beat tones are
//! summed ([`tones`]), and the receiver adds its noise and errors (`receiver.rs`). The simulator is
//! independent of the detector.
//!
//! Not modelled: transmission through surfaces, the near field of the beam (the far-field pattern
//! is centred on the mirror), the rotation of polarisation with the mirror, and echoes of more than
//! two bounces.

pub mod beam;
mod bundles;
pub mod check;
mod chirp;
mod displacement;
pub mod driving;
pub mod edge;
pub mod facets;
mod flight;
#[cfg(test)]
mod form_tests;
mod fourier;
pub mod geometry;
#[cfg(test)]
mod ground_tests;
pub mod lateral;
pub mod material;
pub mod maths;
mod passing;
mod receiver;
#[cfg(test)]
mod scan_tests;
pub mod scatter;
mod scatterers;
pub mod sequence;
mod shaft;
pub mod shapes;
pub mod sight;
pub mod spec;
#[cfg(test)]
mod steady_tests;
#[cfg(test)]
mod textbook;
pub mod tones;
pub mod truth;
mod turning;
pub mod view;
pub mod way;

use core::f64::consts::TAU;
use std::path::Path;
use std::sync::{Arc, OnceLock};

use anyhow::{Result, anyhow, ensure};
use stairscan::Iq;
use stairscan::config::Plane;

use crate::recording::{self, Metadata, MirrorSetup, Recording, Truth};
use beam::Beam;
use bundles::{Bundles, Tone};
use facets::Relief;
use geometry::{BuiltStep, World};
use material::{Material, builtin};
use maths::{LIGHT, Random, Vec2, amplitude, cis, decibel};
use receiver::Receiver;
use scatter::{Diffuse, EVERYWHERE, Echo};
use spec::{PlaneSpec, SceneSpec};
use tones::{HIGHEST, Moving, Tones};
use truth::ScanGeometry;
use view::View;

/// Numbers of the streams of random numbers of one seed: the surfaces', and from [`CHIRPS`] on one per chirp.
const SURFACES: u64 = 1;
const CHIRPS: u64 = 1000;

/// A checked and built scene, ready to be scanned.
pub struct Scene {
    spec: SceneSpec,
    materials: Vec<Material>,
    world: World,
    eye: Vec2,
    beam: Beam,
    /// Beat tones' transform and echoes from inside the scanner; computed at the first scan, because some scenes are
    /// only built.
    beats: OnceLock<Arc<Beats>>,
    angles: Vec<f64>,
}

/// Data shared by the chirps of all rows.
struct Beats {
    tones: Tones,
    /// Echoes from inside the scanner, sample by sample: the leakage, then the mirror's own echo without the phase of
    /// its run-out.
    inside: [Vec<Moving>; 2],
}

/// One scan: the samples of every row in the order of the angles, and the ground truth.
struct Scan {
    chirps: Vec<Vec<Iq>>,
    truth: Truth,
}

impl Scene {
    /// Reads and builds a scene file. Errors name the file and the line or key.
    pub fn read(path: &Path) -> Result<Self> {
        recording::regular(path)?;
        let text = recording::text(path)?;
        Self::parse(&text).map_err(|e| anyhow!("{}{e}", path.display()))
    }

    /// Builds a scene from the text of a scene file. Errors begin with the line or key.
    pub fn parse(text: &str) -> Result<Self> {
        let spec: SceneSpec = toml::from_str(text).map_err(|e| {
            let start = e.span().map_or(0, |s| s.start);
            let line = text.get(..start).unwrap_or_default().matches('\n').count() + 1;
            let message = e.message().split_whitespace().collect::<Vec<_>>().join(" ");
            anyhow!(":{line}: {message}")
        })?;
        Self::new(spec).map_err(|e| anyhow!(": {e}"))
    }

    /// Checks and builds a scene.
    pub fn new(spec: SceneSpec) -> Result<Self> {
        check::spec(&spec)?;
        let mut names: Vec<&str> = material::NAMES.to_vec();
        names.extend(spec.materials.keys().map(String::as_str));
        let lookup = |name: &str| names.iter().rposition(|n| *n == name).unwrap_or(0);
        let world = shapes::build(&spec, &lookup);
        let eye = Vec2::new(0.0, spec.mount.height_m + spec.mount.height_error_m);
        check::world(&spec, &world, eye)?;
        let materials = names
            .iter()
            .filter_map(|name| spec.materials.get(*name).cloned().or_else(|| builtin(name)))
            .map(|m| Material::new(&m, spec.radar.carrier_hz, spec.radar.polarisation))
            .collect();
        let mount = &spec.mount;
        let beam = Beam::new(
            mount.beamwidth_deg,
            mount.lateral_beamwidth_deg.unwrap_or(mount.beamwidth_deg),
            spec.mirror.sidelobe_db,
            spec.mirror.sidelobe_floor_db,
        );
        let aside = beam.lateral_reach() + libm::tan(world.yaw).abs();
        check::patches(&spec, &world, (eye, reach(&spec)), aside)?;
        let sweep = &spec.sweep;
        let count = libm::floor((sweep.last_deg - sweep.first_deg) / sweep.step_deg + 1e-6);
        let angles = (0..=count as usize)
            .map(|k| libm::floor((sweep.first_deg + k as f64 * sweep.step_deg) * 1e6 + 0.5) / 1e6)
            .collect();
        Ok(Self {
            materials,
            world,
            eye,
            beam,
            beats: OnceLock::new(),
            angles,
            spec,
        })
    }

    /// Returns the scene scanned with `chirps` chirps per row.
    ///
    /// # Errors
    /// The number is not 1 to 32.
    pub fn with_chirps(mut self, chirps: u8) -> Result<Self> {
        self.spec.radar.chirps_per_row = chirps;
        check::spec(&self.spec)?;
        Ok(self)
    }

    /// Returns an error if the scene has several chirps per row: the travel between a row's chirps is not simulated.
    fn check_one_chirp(&self) -> Result<()> {
        let chirps = self.spec.radar.chirps_per_row;
        ensure!(
            chirps == 1,
            "radar.chirps_per_row: found {chirps}, expected 1 for a chair that drives"
        );
        Ok(())
    }

    /// Scans the scene. The same seed gives the same bytes on every host.
    pub fn simulate(&self, name: &str, seed: u64) -> Recording {
        let receiver = Receiver::new(&self.spec.radar, &self.spec.receiver);
        let tones = self.place(&receiver, &self.echoes(seed));
        let scan = self.scan(&receiver, &tones, (seed, CHIRPS));
        let mut recording = self.empty_recording(name);
        recording.samples = scan.chirps.concat();
        let meta = &mut recording.meta;
        meta.angles_deg.clone_from(&self.angles);
        meta.truth = Some(scan.truth);
        let pitch = self.spec.mount.pitch_deg;
        meta.motion.pitch_deg = pitch.map_or(Vec::new(), |pitch| vec![pitch; self.angles.len()]);
        recording
    }

    /// Returns the chirps of all rows and the truth. `stream` is the number of the first row's stream of random
    /// numbers; each row has the next one.
    fn scan(&self, receiver: &Receiver, tones: &Bundles, (seed, stream): (u64, u64)) -> Scan {
        let rows = 0..self.angles.len();
        let (chirps, clean): (Vec<_>, Vec<_>) = rows
            .map(|row| {
                let mut random = Random::new(seed, stream + row as u64);
                let time_s = row as f64 * self.spec.sweep.row_s;
                self.chirp(receiver, &[tones], (row, time_s), &mut random)
            })
            .unzip();
        let scan = self.geometry();
        let noise = receiver.noise_power() + receiver.quantisation_power();
        let noise = noise / f64::from(self.spec.radar.chirps_per_row);
        let truth = scan.truth(&self.world, |steps| {
            let snr = scan.snr(steps, &clean, noise);
            snr.into_iter().map(Some).collect()
        });
        Scan { chirps, truth }
    }

    /// Returns a recording with this scanner's metadata and without chirps.
    fn empty_recording(&self, name: &str) -> Recording {
        let (radar, mount) = (&self.spec.radar, &self.spec.mount);
        Recording {
            name: name.into(),
            meta: Metadata {
                description: self.spec.description.clone(),
                sample_rate_hz: Some(radar.values_per_sample() as f64 * radar.sample_rate_hz),
                carrier_hz: radar.carrier_hz,
                bandwidth_hz: radar.bandwidth_hz,
                samples_per_chirp: radar.samples_per_chirp,
                chirps_per_row: (radar.chirps_per_row > 1).then_some(radar.chirps_per_row),
                real: radar.real,
                mirror: Some(MirrorSetup {
                    offset_m: mount.mirror_offset_m,
                    beamwidth_deg: mount.beamwidth_deg,
                    mount_height_m: mount.height_m,
                    plane: match mount.plane {
                        PlaneSpec::Depth => Plane::Depth,
                        PlaneSpec::Height => Plane::Height,
                    },
                }),
                ..Metadata::default()
            },
            samples: Vec::new(),
        }
    }

    /// Returns the ground truth, the report of a perfect scanner, without a scan and so without signal-to-noise ratios.
    pub fn truth(&self) -> Truth {
        let unknown = |steps: &[BuiltStep]| vec![None; steps.len()];
        self.geometry().truth(&self.world, unknown)
    }

    fn geometry(&self) -> ScanGeometry<'_> {
        ScanGeometry {
            spec: &self.spec,
            angles: &self.angles,
            resolution: LIGHT / (2.0 * self.spec.radar.bandwidth_hz),
        }
    }

    /// Returns all echoes of the scene for one draw of its surfaces.
    pub fn echoes(&self, seed: u64) -> Vec<Echo> {
        let mut random = Random::new(seed, SURFACES);
        let relief = self.relief_from(&mut random, &[0.0]);
        self.view()
            .echoes(&relief, &mut Diffuse::Fresh(&mut random))
    }

    /// Returns the relief of one draw of the surfaces, for all facets that are in view after any of the `travels`,
    /// metres.
    fn relief(&self, seed: u64, travels: &[f64]) -> Relief {
        self.relief_from(&mut Random::new(seed, SURFACES), travels)
    }

    fn relief_from(&self, random: &mut Random, travels: &[f64]) -> Relief {
        let view = self.view();
        let across = libm::cos(self.world.yaw);
        let eyes: Vec<Vec2> = travels
            .iter()
            .map(|t| self.eye + Vec2::new(t * across, 0.0))
            .collect();
        Relief::new(
            &self.world,
            &self.materials,
            (check::facet_limit(&self.spec), view.reach),
            (&eyes, view.lateral_reach()),
            random,
        )
    }

    fn view(&self) -> View<'_> {
        View {
            world: &self.world,
            materials: &self.materials,
            eye: self.eye,
            plane: self.spec.mount.plane,
            beam: &self.beam,
            wavenumber: TAU * self.spec.radar.carrier_hz / LIGHT,
            polarisation: self.spec.radar.polarisation,
            reach: reach(&self.spec),
            between: EVERYWHERE,
        }
    }

    fn beats(&self) -> &Beats {
        self.beats.get_or_init(|| {
            let receiver = Receiver::new(&self.spec.radar, &self.spec.receiver);
            let tones = Tones::new(&receiver.times(), |f| receiver.filter(f));
            let inside = self.inside(&receiver, &tones);
            Arc::new(Beats { tones, inside })
        })
    }

    /// Places the echoes on the grid of beat frequencies, summed into bundles of equal directions.
    fn place(&self, receiver: &Receiver, echoes: &[Echo]) -> Bundles {
        let gain = receiver.gain(self.antenna_gain_dbi());
        let tones = echoes.iter().map(|e| self.tone(receiver, gain, e));
        Bundles::new(tones.flatten())
    }

    /// Places one echo on the grid of beat frequencies, with `gain` from [`Receiver::gain`]; `None` if its frequency is
    /// beyond the grid.
    fn tone(&self, receiver: &Receiver, gain: f64, echo: &Echo) -> Option<Tone> {
        let offset = self.spec.mount.mirror_offset_m;
        let place = self
            .beats()
            .tones
            .place(receiver.beat(echo.range + offset))?;
        Some(Tone {
            amplitude: echo.amplitude * gain * place.centre,
            place,
            range: echo.range,
            out: echo.out,
            back: echo.back,
        })
    }

    fn antenna_gain_dbi(&self) -> f64 {
        let mount = &self.spec.mount;
        let lateral = mount.lateral_beamwidth_deg.unwrap_or(mount.beamwidth_deg);
        let directivity = 0.7 * 41_253.0 / (mount.beamwidth_deg * lateral);
        self.spec
            .radar
            .antenna_gain_dbi
            .unwrap_or_else(|| decibel(directivity))
    }

    /// Returns the echoes from inside the scanner, sample by sample: the leakage, and the mirror's own echo, without
    /// the phase that the mirror's run-out adds.
    fn inside(&self, receiver: &Receiver, tones: &Tones) -> [Vec<Moving>; 2] {
        let spec = &self.spec.receiver;
        let wavenumber = self.view().wavenumber;
        [
            (spec.leakage_range_m, spec.leakage_dbfs),
            (self.spec.mount.mirror_offset_m, spec.mirror_echo_dbfs),
        ]
        .map(|(range, level)| {
            let mut grid = tones.grid();
            if let Some(place) = tones.place(receiver.beat(range)) {
                let phase = cis(2.0 * wavenumber * range);
                Tones::add(&mut grid, &place, phase * amplitude(level) * place.centre);
            }
            tones.sums(&grid).collect()
        })
    }
}

/// Returns the range from the mirror beyond which the anti-alias filter suppresses all echoes,
/// metres.
fn reach(spec: &SceneSpec) -> f64 {
    let radar = &spec.radar;
    let longest = LIGHT * radar.samples_per_chirp as f64 / (2.0 * radar.bandwidth_hz);
    HIGHEST * longest - spec.mount.mirror_offset_m
}
