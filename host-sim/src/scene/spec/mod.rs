//! Keys of a scene file: the TOML of `scenes/*.toml`, with every default and its source.
//!
//! Lengths are metres and angles degrees unless the key says otherwise. `x` is measured forward
//! from the mirror's centre, heights from the surface that the wheelchair stands on.

mod shapes;

use std::collections::BTreeMap;

use serde::{Deserialize, Serialize};

pub use shapes::{
    BoxSpec, DoorSpec, FloorSpec, PolylineSpec, PostSpec, RampSpec, StairsSpec, WallSpec, Way,
};

/// A whole scene: the radar, its mounting, and the objects in front of it.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields, default)]
pub struct SceneSpec {
    /// Text for the recording's `core:description`.
    pub description: String,
    /// The radar module.
    pub radar: RadarSpec,
    /// Mounting of the scanner.
    pub mount: MountSpec,
    /// Mirror angles of the scan.
    pub sweep: SweepSpec,
    /// Errors of the mirror and its shaft.
    pub mirror: MirrorSpec,
    /// The receiver, from the antenna to the samples.
    pub receiver: ReceiverSpec,
    /// Materials of this scene, and built-in ones with changed values.
    #[serde(rename = "material")]
    pub materials: BTreeMap<String, MaterialSpec>,
    /// Flights of stairs and kerbs.
    pub stairs: Vec<StairsSpec>,
    /// Level surfaces.
    pub floor: Vec<FloorSpec>,
    /// Inclined surfaces.
    pub ramp: Vec<RampSpec>,
    /// Upright surfaces.
    pub wall: Vec<WallSpec>,
    /// Round posts and the legs of chairs, tables and people.
    pub post: Vec<PostSpec>,
    /// Rectangular solids: boxes, beams, thresholds, kerb stones.
    #[serde(rename = "box")]
    pub boxes: Vec<BoxSpec>,
    /// Door frames.
    pub door: Vec<DoorSpec>,
    /// Free shapes.
    pub polyline: Vec<PolylineSpec>,
}

/// The radar module (paper, section II-A, and the radar equation, Skolnik, Introduction to Radar Systems, ch. 1).
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields, default)]
pub struct RadarSpec {
    /// Centre of the sweep, Hz.
    pub carrier_hz: f64,
    /// Swept bandwidth B, Hz.
    pub bandwidth_hz: f64,
    /// Complex samples per chirp.
    pub samples_per_chirp: usize,
    /// Number of chirps of a row, 1 to 32, whose mean the samples are; above 1 for a chair that stands.
    pub chirps_per_row: u8,
    /// Rate of the ADC, Hz: with the samples per chirp it gives the length of the sweep.
    pub sample_rate_hz: f64,
    /// Whether the receiver has no Q channel: one ADC takes the real part, twice as many values at
    /// twice the rate. Beat frequencies, anti-alias filter and ranges do not change. The noise of
    /// the negative frequencies, which I and Q separate, is added to the echoes (3 dB).
    pub real: bool,
    /// Transmitted power, dBm. W-band MMIC modules give a few milliwatts.
    pub tx_power_dbm: f64,
    /// Peak gain of the beam leaving the mirror, dBi. The default is 10 log10(0.7 · 41253 / (w_e
    /// w_a)) of its 3 dB widths in degrees (Balanis, Antenna Theory, eq. 2-27 with 70 %
    /// efficiency).
    pub antenna_gain_dbi: Option<f64>,
    /// Two-way losses, dB: lens, radome, and above all the mirror, which uses its 5° of the radar's
    /// 11° (section II-B) and passes the rest by, 20 log10 (11 / 5) one way.
    pub system_loss_db: f64,
    /// Electric field along the steps' edges ("horizontal") or across them ("vertical").
    pub polarisation: Polarisation,
}

impl RadarSpec {
    /// Returns the number of ADC values per complex sample: 2 of a real receiver.
    pub fn values_per_sample(&self) -> usize {
        1 + usize::from(self.real)
    }
}

impl Default for RadarSpec {
    fn default() -> Self {
        Self {
            carrier_hz: 94e9,
            bandwidth_hz: 10e9,
            samples_per_chirp: 200,
            chirps_per_row: 1,
            sample_rate_hz: 200e3,
            real: false,
            tx_power_dbm: 0.0,
            antenna_gain_dbi: None,
            system_loss_db: 15.0,
            polarisation: Polarisation::Horizontal,
        }
    }
}

/// Direction of the electric field relative to the edges of the steps.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize)]
#[serde(rename_all = "lowercase")]
pub enum Polarisation {
    /// Along the edges of the steps, perpendicular to the plane of incidence (TE, "soft").
    Horizontal,
    /// In the plane that the mirror sweeps (TM, "hard").
    Vertical,
}

/// Mounting of the scanner (paper, section II-B).
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields, default)]
pub struct MountSpec {
    /// Height of the mirror's centre above the surface that the wheelchair stands on.
    pub height_m: f64,
    /// Distance from the radar lens to the mirror's centre.
    pub mirror_offset_m: f64,
    /// Two-sided 3 dB width of the beam leaving the mirror, in the plane that it sweeps.
    pub beamwidth_deg: f64,
    /// Two-sided 3 dB width across that plane; the default is a round beam.
    pub lateral_beamwidth_deg: Option<f64>,
    /// Angles from the horizontal ("depth", stairs going up) or from straight down ("height").
    pub plane: PlaneSpec,
    /// True height less the recorded one: soft tyres, a bent bracket.
    pub height_error_m: f64,
    /// The chair's pitch by its IMU, nose up positive. It turns the whole scan about the mirror's
    /// centre, and is in the recording. Without it the chair stands level and the recording has no
    /// pitch.
    pub pitch_deg: Option<f64>,
    /// True pitch less the recorded one; MEMS inclinometers hold 0.1° over temperature.
    pub pitch_error_deg: f64,
    /// Heading of the chair relative to the perpendicular of the edges. All lengths of the scene
    /// are measured in the plane that the mirror sweeps, at any yaw.
    pub yaw_deg: f64,
    /// Amplitude of the vibration of chair, radar and mirror together: echoes turn by its part along their direction,
    /// the mirror's own echo does not. A sine of the acceleration a has the amplitude a / (2πf)²; on wheelchairs the seat
    /// has some 1 to 2 m/s² at 5 to 60 Hz (VanSickle et al., J. Rehabil. Res. Dev. 38, 2001): 0.01 to 0.5 mm.
    pub vibration_m: f64,
    /// Frequency of this vibration, Hz: seat and frame have resonances at 5 to 60 Hz.
    pub vibration_hz: f64,
    /// Direction of this vibration, from forward to straight up.
    pub vibration_up_deg: f64,
    /// Phase of this vibration at the first row.
    pub vibration_phase_deg: f64,
}

impl MountSpec {
    /// Returns the beam angle less the mirror angle, degrees, at a pitch of `pitch_deg`. Nose up
    /// raises the beam: less below the horizontal, and more to the front of straight down.
    pub fn tilt_deg(&self, pitch_deg: f64) -> f64 {
        match self.plane {
            PlaneSpec::Depth => -pitch_deg,
            PlaneSpec::Height => pitch_deg,
        }
    }
}

impl Default for MountSpec {
    fn default() -> Self {
        Self {
            height_m: 0.40,
            mirror_offset_m: 0.22,
            beamwidth_deg: 5.0,
            lateral_beamwidth_deg: None,
            plane: PlaneSpec::Depth,
            height_error_m: 0.0,
            pitch_deg: None,
            pitch_error_deg: 0.0,
            yaw_deg: 0.0,
            vibration_m: 0.0,
            vibration_hz: 20.0,
            vibration_up_deg: 90.0,
            vibration_phase_deg: 0.0,
        }
    }
}

/// The plane that the mirror sweeps.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize)]
#[serde(rename_all = "lowercase")]
pub enum PlaneSpec {
    /// Angles are measured from the horizontal, positive downwards.
    Depth,
    /// Angles are measured from straight down, positive towards the front.
    Height,
}

/// Mirror angles of the scan (paper, section II-B).
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields, default)]
pub struct SweepSpec {
    /// First mirror angle of the scan.
    pub first_deg: f64,
    /// Last mirror angle of the scan, included.
    pub last_deg: f64,
    /// Step from one mirror angle to the next.
    pub step_deg: f64,
    /// Time from one row to the next, s, by which vibrations and drifts go on: 281 rows in 1.3 s. A drive has its own.
    pub row_s: f64,
}

impl Default for SweepSpec {
    fn default() -> Self {
        Self {
            first_deg: -20.0,
            last_deg: 50.0,
            step_deg: 0.25,
            row_s: 4.63e-3,
        }
    }
}

/// Errors of the mirror and its shaft.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields, default)]
pub struct MirrorSpec {
    /// True beam angle less the recorded one, the same for the whole scan: homing error and the
    /// wheelchair's pitch.
    pub bias_deg: f64,
    /// Standard deviation of the beam angle from chirp to chirp. Microstepping drives repeat to
    /// some 5 % of a full step of 1.8°, less with settling.
    pub jitter_deg: f64,
    /// Speed of the shaft while a chirp is captured, degrees per second; 0: it stands still at each
    /// row. In the middle of the chirp it passes the row's angle.
    pub turn_deg_s: f64,
    /// Amplitude of the vibration of a turning shaft. It has the period of the motor's full steps,
    /// whose torque ripple the driver's microsteps do not even out completely. It is slow compared
    /// with a chirp, so that no chirp averages it.
    pub vibration_deg: f64,
    /// Phase of the shaft's vibration at the mirror angle 0.
    pub vibration_phase_deg: f64,
    /// Run-out of the mirror's surface over a turn, which changes the phase of the mirror's own
    /// echo.
    pub runout_m: f64,
    /// Run-out of the shaft, along its axis and across: the mirror moves with it. Turned by 45°, the path of the
    /// echoes changes by the displacement along the axis less that along the beam, that of the mirror's own echo by
    /// the former. Step motors have 50 µm at the shaft's end (NEMA ICS 16), their bearings play of 20 µm.
    pub shaft_runout_m: f64,
    /// Periods of the shaft's run-out in a turn: 1 for a bent shaft, the number of balls that pass for a bearing.
    pub shaft_runout_cycles: f64,
    /// Phase of the shaft's run-out at the mirror angle 0.
    pub shaft_runout_phase_deg: f64,
    /// Drift of the distance from radar to mirror, m/s: aluminium grows by 23 ppm per kelvin, 5 µm over 0.22 m, and
    /// electronics warm up by some 0.1 K/s.
    pub offset_drift_m_s: f64,
    /// First side lobe of the beam, one way, dB below its peak (Hansen, Phased Array Antennas, sec.
    /// 3.2: one-parameter distribution; a lens feeding a mirror lies between 18 and 25 dB).
    pub sidelobe_db: f64,
    /// Level of the scatter by the mirror's surface errors in all directions, one way, dB below the
    /// peak (Ruze, Proc. IEEE 54, 1966).
    pub sidelobe_floor_db: f64,
}

impl Default for MirrorSpec {
    fn default() -> Self {
        Self {
            bias_deg: 0.0,
            jitter_deg: 0.02,
            turn_deg_s: 0.0,
            vibration_deg: 0.0,
            vibration_phase_deg: 0.0,
            runout_m: 5e-6,
            shaft_runout_m: 0.0,
            shaft_runout_cycles: 1.0,
            shaft_runout_phase_deg: 0.0,
            offset_drift_m_s: 0.0,
            sidelobe_db: 20.0,
            sidelobe_floor_db: 35.0,
        }
    }
}

/// The receiver, from the antenna to the samples.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields, default)]
pub struct ReceiverSpec {
    /// Noise figure at the beat frequencies, dB. White noise of power k T F f_s reaches the ADC
    /// (Skolnik, ch. 1). In homodyne W-band receivers flicker noise and the transmitter's amplitude
    /// noise dominate at tens of kilohertz (Maas, Microwave Mixers, ch. 4), so that the value is
    /// above the 8 dB of their high-frequency data sheets.
    pub noise_figure_db: f64,
    /// Power of an echo that just fills the ADC, dBm, which sets the gain of the receiver.
    pub full_scale_dbm: f64,
    /// Leakage of the transmitter into the receiver, dB of full scale.
    pub leakage_dbfs: f64,
    /// Apparent range of the leakage.
    pub leakage_range_m: f64,
    /// The mirror's own echo, dB of full scale; it lies at `mount.mirror_offset_m`.
    pub mirror_echo_dbfs: f64,
    /// Offset of the I channel, fraction of full scale.
    pub dc_i: f64,
    /// Offset of the Q channel, fraction of full scale.
    pub dc_q: f64,
    /// Phase noise L(f) at 100 kHz from the carrier, dBc/Hz, falling with 20 dB per decade. In the
    /// beat signal it is reduced by the range correlation 4 sin²(π f τ) (Budge and Burt, 1993).
    pub phase_noise_dbc_hz: f64,
    /// Relative excess of the sweep's slope over the recorded one, which scales all ranges. A
    /// voltage-controlled oscillator's slope drifts by some 1e-4 per kelvin until it is calibrated
    /// again.
    pub sweep_slope: f64,
    /// Drift of the sweep's slope, relative, per second: that of `sweep_slope` per kelvin, at 0.1 K/s, is 1e-5. The sweep
    /// begins at the same frequency, so that its middle drifts by half as much of B.
    pub slope_drift_s: f64,
    /// Drift of the sweep's middle, Hz per second. An oscillator that is not locked drifts by some 1e-4 per kelvin: at
    /// 94 GHz and 0.1 K/s by 1 MHz/s. The phase of an echo turns in proportion to its range, 4π R/c a hertz.
    pub carrier_drift_hz_s: f64,
    /// Standard deviation from chirp to chirp of the time between trigger and first sample, s: a tone of the beat
    /// frequency f turns by 2πf times this, so that echoes turn against the mirror's own echo. A timer's tick is 6 ns
    /// at 168 MHz, an interrupt's latency changes by some 0.1 µs.
    pub trigger_jitter_s: f64,
    /// Standard deviation of the phase with which a chirp begins; leakage and all echoes share it. A homodyne radar has
    /// 0, one whose local oscillator is divided or switched between chirps may have any.
    pub start_phase_deg: f64,
    /// Bow of the sweep: largest deviation from the straight line, fraction of B.
    pub sweep_bow: f64,
    /// Ripple of the sweep: amplitude of a sine, fraction of B (Griffiths, 1991: paired echoes).
    pub sweep_ripple: f64,
    /// Periods of the sweep's ripple in one sweep.
    pub sweep_ripple_cycles: f64,
    /// Gain of Q over I, dB.
    pub iq_gain_db: f64,
    /// Deviation of the phase between I and Q from 90°.
    pub iq_phase_deg: f64,
    /// 3 dB corner of the anti-alias filter, fraction of the sample rate. Complex samples use the
    /// beat frequencies from 0 to the sample rate (eq. 2).
    pub antialias_cutoff: f64,
    /// Order of the anti-alias filter (Butterworth).
    pub antialias_order: u32,
    /// Bits of the ADC; samples are left-aligned in 16.
    pub adc_bits: u32,
}

impl Default for ReceiverSpec {
    fn default() -> Self {
        Self {
            noise_figure_db: 40.0,
            full_scale_dbm: -26.0,
            leakage_dbfs: -10.0,
            leakage_range_m: 0.025,
            mirror_echo_dbfs: -26.0,
            dc_i: 0.04,
            dc_q: -0.06,
            phase_noise_dbc_hz: -75.0,
            sweep_slope: 0.0,
            slope_drift_s: 0.0,
            carrier_drift_hz_s: 0.0,
            trigger_jitter_s: 0.0,
            start_phase_deg: 0.0,
            sweep_bow: 1e-4,
            sweep_ripple: 3e-5,
            sweep_ripple_cycles: 7.0,
            iq_gain_db: 0.15,
            iq_phase_deg: 1.0,
            antialias_cutoff: 1.05,
            antialias_order: 6,
            adc_bits: 14,
        }
    }
}

/// Electrical and mechanical properties of a surface. All keys have defaults, those of bare wood.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields, default)]
pub struct MaterialSpec {
    /// Real part of the relative permittivity.
    pub permittivity: f64,
    /// Conductivity, S/m.
    pub conductivity: f64,
    /// Standard deviation of the surface's height.
    pub roughness_m: f64,
    /// Correlation length of the surface's height (exponential autocorrelation).
    pub correlation_m: f64,
    /// Diffuse scatter of the volume and the fine texture: γ of σ° = γ cos θ, dB.
    pub diffuse_db: f64,
    /// Whether the diffuse scatter comes from inside the material: σ° is γ cos θ (T(θ) / T(0))²,
    /// with Fresnel's transmissivity T of the surface for the radar's polarisation, once in and
    /// once out (volume scattering of a half space: Ulaby and Long, Microwave Radar and Radiometric
    /// Remote Sensing, ch. 11). If not, γ holds for both polarisations at every angle.
    pub diffuse_inside: bool,
    /// Distance from one joint (or gap of a grating) to the next along the surface; 0 for none.
    pub joint_pitch_m: f64,
    /// Width of a joint.
    pub joint_width_m: f64,
    /// Depth of a joint below the surface.
    pub joint_depth_m: f64,
    /// Reflection inside a joint relative to that of the surface: 0 for the holes of a grating.
    pub joint_reflection: f64,
}

impl Default for MaterialSpec {
    fn default() -> Self {
        Self {
            permittivity: 1.99,
            conductivity: 0.6,
            roughness_m: 60e-6,
            correlation_m: 3e-3,
            diffuse_db: -25.0,
            diffuse_inside: false,
            joint_pitch_m: 0.0,
            joint_width_m: 0.0,
            joint_depth_m: 0.0,
            joint_reflection: 1.0,
        }
    }
}
