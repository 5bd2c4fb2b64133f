//! What a scene file may say: the TOML of `scenes/*.toml`, with every default and its source.
//!
//! Lengths are metres and angles degrees unless the key says otherwise. `x` counts forward from the
//! mirror's centre, heights from the surface that the wheelchair stands on.

use std::collections::BTreeMap;

use serde::{Deserialize, Serialize};

/// A whole scene: the radar, how it is mounted, and what stands in front of it.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields, default)]
pub struct SceneSpec {
    /// Goes into the recording's `core:description`.
    pub description: String,
    /// The radar module.
    pub radar: RadarSpec,
    /// How the scanner is mounted.
    pub mount: MountSpec,
    /// The angles of the scan.
    pub sweep: SweepSpec,
    /// What the mirror and its shaft do wrong.
    pub mirror: MirrorSpec,
    /// Everything between the antenna and the samples.
    pub receiver: ReceiverSpec,
    /// Materials of this scene, or built-in ones with other values.
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
    /// Anything else.
    pub polyline: Vec<PolylineSpec>,
}

/// The radar module (paper, section II-A, and the radar equation, Skolnik, Introduction to Radar
/// Systems, ch. 1).
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields, default)]
pub struct RadarSpec {
    /// Centre of the sweep, Hz.
    pub carrier_hz: f64,
    /// Swept bandwidth B, Hz.
    pub bandwidth_hz: f64,
    /// Complex samples per chirp.
    pub samples_per_chirp: usize,
    /// Rate of the ADC, Hz: with the samples per chirp it gives the length of the sweep.
    pub sample_rate_hz: f64,
    /// Transmitted power, dBm. A few milliwatts are what W-band MMIC modules give.
    pub tx_power_dbm: f64,
    /// Peak gain of the beam leaving the mirror, dBi; without it 10 log10(0.7 · 41253 / (w_e w_a)) of
    /// its 3 dB widths in degrees (Balanis, Antenna Theory, eq. 2-27 with 70 % efficiency).
    pub antenna_gain_dbi: Option<f64>,
    /// Losses out and back together, dB: lens, radome, and above all the mirror, which takes its 5° out
    /// of the radar's 11° (section II-B) and leaves the rest beside it, 20 log10 (11 / 5) a way.
    pub system_loss_db: f64,
    /// Electric field along the steps' edges ("horizontal") or across them ("vertical").
    pub polarisation: Polarisation,
}

impl Default for RadarSpec {
    fn default() -> Self {
        Self {
            carrier_hz: 94e9,
            bandwidth_hz: 10e9,
            samples_per_chirp: 200,
            sample_rate_hz: 200e3,
            tx_power_dbm: 0.0,
            antenna_gain_dbi: None,
            system_loss_db: 15.0,
            polarisation: Polarisation::Horizontal,
        }
    }
}

/// Direction of the electric field.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize)]
#[serde(rename_all = "lowercase")]
pub enum Polarisation {
    /// Along the edges of the steps, perpendicular to the plane of incidence (TE, "soft").
    Horizontal,
    /// In the plane that the mirror sweeps (TM, "hard").
    Vertical,
}

/// How the scanner is mounted (paper, section II-B).
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields, default)]
pub struct MountSpec {
    /// Height of the mirror's centre above the surface that the wheelchair stands on.
    pub height_m: f64,
    /// Radar lens to mirror centre.
    pub mirror_offset_m: f64,
    /// Two-sided 3 dB width of the beam leaving the mirror, in the plane that it sweeps.
    pub beamwidth_deg: f64,
    /// The same across that plane; without it the beam is round.
    pub lateral_beamwidth_deg: Option<f64>,
    /// Angles from the horizontal ("depth", stairs going up) or from straight down ("height").
    pub plane: PlaneSpec,
    /// Real height less the recorded one: soft tyres, a bent bracket.
    pub height_error_m: f64,
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
        }
    }
}

/// The plane that the mirror sweeps.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize)]
#[serde(rename_all = "lowercase")]
pub enum PlaneSpec {
    /// Angles count from the horizontal, positive downwards.
    Depth,
    /// Angles count from straight down, positive towards the front.
    Height,
}

/// The angles of the scan (paper, section II-B).
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields, default)]
pub struct SweepSpec {
    /// First angle.
    pub first_deg: f64,
    /// Last angle, included.
    pub last_deg: f64,
    /// From one angle to the next.
    pub step_deg: f64,
}

impl Default for SweepSpec {
    fn default() -> Self {
        Self {
            first_deg: -20.0,
            last_deg: 50.0,
            step_deg: 0.25,
        }
    }
}

/// The mirror and its shaft.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields, default)]
pub struct MirrorSpec {
    /// Real beam angle less the recorded one, the same for the whole scan: homing error and the
    /// wheelchair's pitch.
    pub bias_deg: f64,
    /// Standard deviation of the beam angle from chirp to chirp; microstepping drives repeat to some
    /// 5 % of a full step of 1.8°, less with settling.
    pub jitter_deg: f64,
    /// Run-out of the mirror's surface over a turn: it turns the phase of the mirror's own echo.
    pub runout_m: f64,
    /// First side lobe of the beam, one way, dB below its peak (Hansen, Phased Array Antennas, sec.
    /// 3.2: one-parameter distribution; a lens feeding a mirror lies between 18 and 25 dB).
    pub sidelobe_db: f64,
    /// What the mirror's surface errors scatter everywhere, one way, dB below the peak (Ruze, Proc.
    /// IEEE 54, 1966).
    pub sidelobe_floor_db: f64,
}

impl Default for MirrorSpec {
    fn default() -> Self {
        Self {
            bias_deg: 0.0,
            jitter_deg: 0.02,
            runout_m: 5e-6,
            sidelobe_db: 20.0,
            sidelobe_floor_db: 35.0,
        }
    }
}

/// From the antenna to the samples.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields, default)]
pub struct ReceiverSpec {
    /// Noise figure at the beat frequencies, dB. White noise of power k T F f_s reaches the ADC
    /// (Skolnik, ch. 1). Homodyne W-band receivers are ruled by flicker noise and by the transmitter's
    /// amplitude noise at tens of kilohertz (Maas, Microwave Mixers, ch. 4), which is why this is not
    /// the 8 dB of their high-frequency data sheets.
    pub noise_figure_db: f64,
    /// Power of the echo that just fills the ADC, dBm: the gain of the receiver.
    pub full_scale_dbm: f64,
    /// Transmitter leaking into the receiver, dB of full scale.
    pub leakage_dbfs: f64,
    /// Apparent range of the leakage.
    pub leakage_range_m: f64,
    /// The mirror's own echo, dB of full scale; it lies at `mount.mirror_offset_m`.
    pub mirror_echo_dbfs: f64,
    /// Offset of the I channel, share of full scale.
    pub dc_i: f64,
    /// Offset of the Q channel, share of full scale.
    pub dc_q: f64,
    /// Phase noise L(f) at 100 kHz from the carrier, dBc/Hz, falling with 20 dB a decade. What
    /// reaches the beat signal is cut by the range correlation 4 sin²(π f τ) (Budge and Burt, 1993).
    pub phase_noise_dbc_hz: f64,
    /// Bow of the sweep: largest deviation from the straight line, share of B.
    pub sweep_bow: f64,
    /// Ripple of the sweep: amplitude of a sine, share of B (Griffiths, 1991: paired echoes).
    pub sweep_ripple: f64,
    /// Periods of that ripple in one sweep.
    pub sweep_ripple_cycles: f64,
    /// Gain of Q over I, dB.
    pub iq_gain_db: f64,
    /// Departure of I and Q from 90°.
    pub iq_phase_deg: f64,
    /// 3 dB corner of the anti-alias filter, share of the sample rate; complex samples use the beat
    /// frequencies from 0 to the sample rate (eq. 2).
    pub antialias_cutoff: f64,
    /// Order of that filter (Butterworth).
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

/// A surface's electrical and mechanical nature. Every key has a default, those of bare wood.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields, default)]
pub struct MaterialSpec {
    /// Real part of the relative permittivity.
    pub permittivity: f64,
    /// Conductivity, S/m.
    pub conductivity: f64,
    /// Standard deviation of the surface's height.
    pub roughness_m: f64,
    /// Length over which that height is correlated (exponential autocorrelation).
    pub correlation_m: f64,
    /// What the volume and the fine texture scatter evenly: γ of σ° = γ cos θ, dB.
    pub diffuse_db: f64,
    /// Distance from one joint (or gap of a grating) to the next along the surface; 0 for none.
    pub joint_pitch_m: f64,
    /// Width of a joint.
    pub joint_width_m: f64,
    /// Depth of a joint below the surface.
    pub joint_depth_m: f64,
    /// Reflection inside a joint as a share of the surface's: 0 for the holes of a grating.
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
            joint_pitch_m: 0.0,
            joint_width_m: 0.0,
            joint_depth_m: 0.0,
            joint_reflection: 1.0,
        }
    }
}

/// Which way a flight leads.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Serialize, Deserialize)]
#[serde(rename_all = "lowercase")]
pub enum Way {
    /// Upwards, away from the wheelchair.
    #[default]
    Up,
    /// Downwards, away from the wheelchair.
    Down,
}

/// A flight of stairs (a kerb is a flight of one step).
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct StairsSpec {
    /// Upwards or downwards.
    #[serde(default)]
    pub direction: Way,
    /// Mirror to the first step's foremost edge (up), or to the first edge (down).
    pub distance_m: f64,
    /// Height of the surface before the first step.
    #[serde(default)]
    pub base_m: f64,
    /// Number of steps.
    pub count: usize,
    /// Height of every step.
    pub rise_m: f64,
    /// From one foremost edge to the next.
    pub going_m: f64,
    /// Heights one by one instead: as many as steps.
    #[serde(default)]
    pub rises_m: Vec<f64>,
    /// Goings one by one instead: one fewer than steps.
    #[serde(default)]
    pub goings_m: Vec<f64>,
    /// How far a tread stands out over the riser below it.
    #[serde(default)]
    pub nosing_m: f64,
    /// Rounding of the foremost edge; real treads are broken or rounded by 2 to 10 mm.
    #[serde(default = "default_radius")]
    pub nosing_radius_m: f64,
    /// Thickness of a tread: seen where it stands out and where risers are open.
    #[serde(default = "default_thickness")]
    pub tread_thickness_m: f64,
    /// No risers: treads float.
    #[serde(default)]
    pub open: bool,
    /// Depth of a floating tread; without it the going and 2 cm.
    #[serde(default)]
    pub tread_depth_m: Option<f64>,
    /// Length of the surface after the last step.
    #[serde(default = "default_landing")]
    pub landing_m: f64,
    /// Treads and, unless given below, risers.
    pub material: String,
    /// Risers.
    #[serde(default)]
    pub riser_material: Option<String>,
    /// Width across the plane, and where its middle lies; without it wider than the beam.
    #[serde(default)]
    pub width_m: Option<f64>,
}

fn default_radius() -> f64 {
    0.003
}

fn default_thickness() -> f64 {
    0.04
}

fn default_landing() -> f64 {
    1.2
}

/// A level surface, seen from above.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct FloorSpec {
    /// Where it starts.
    #[serde(default = "default_floor_start")]
    pub from_m: f64,
    /// Where it ends; without it at the foot of the first flight going up, else at 4 m.
    #[serde(default)]
    pub to_m: Option<f64>,
    /// Its height.
    #[serde(default)]
    pub height_m: f64,
    /// Its material.
    pub material: String,
}

fn default_floor_start() -> f64 {
    -0.6
}

/// An inclined surface, seen from above.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct RampSpec {
    /// Where it starts.
    pub from_m: f64,
    /// Where it ends.
    pub to_m: f64,
    /// Height at its start.
    #[serde(default)]
    pub from_height_m: f64,
    /// Height at its end.
    pub to_height_m: f64,
    /// Its material.
    pub material: String,
}

/// An upright surface, seen from the front.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct WallSpec {
    /// Its distance.
    pub at_m: f64,
    /// Height of its foot.
    #[serde(default)]
    pub bottom_m: f64,
    /// Height of its top.
    #[serde(default = "default_wall_top")]
    pub top_m: f64,
    /// Its material.
    pub material: String,
}

fn default_wall_top() -> f64 {
    2.5
}

/// A round upright post or leg.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct PostSpec {
    /// Distance of its axis.
    pub at_m: f64,
    /// How far its axis lies beside the plane that the mirror sweeps.
    #[serde(default)]
    pub lateral_m: f64,
    /// Its diameter.
    pub diameter_m: f64,
    /// Height of its lower end.
    #[serde(default)]
    pub bottom_m: f64,
    /// Height of its upper end.
    pub top_m: f64,
    /// Its material.
    pub material: String,
}

/// A rectangular solid.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct BoxSpec {
    /// Distance of its front.
    pub from_m: f64,
    /// Distance of its back.
    pub to_m: f64,
    /// Height of its underside.
    #[serde(default)]
    pub bottom_m: f64,
    /// Height of its top.
    pub top_m: f64,
    /// Width across the plane; without it wider than the beam.
    #[serde(default)]
    pub width_m: Option<f64>,
    /// How far its middle lies beside the plane that the mirror sweeps.
    #[serde(default)]
    pub lateral_m: f64,
    /// Its material.
    pub material: String,
}

/// A door frame: two jambs, a lintel and, if it has one, a threshold.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct DoorSpec {
    /// Distance of its front.
    pub at_m: f64,
    /// Thickness of the wall that it stands in.
    #[serde(default = "default_door_depth")]
    pub depth_m: f64,
    /// Clear width.
    #[serde(default = "default_door_width")]
    pub width_m: f64,
    /// Clear height.
    #[serde(default = "default_door_height")]
    pub height_m: f64,
    /// How far the middle of the opening lies beside the plane that the mirror sweeps.
    #[serde(default)]
    pub lateral_m: f64,
    /// Width of a jamb and height of the lintel.
    #[serde(default = "default_frame")]
    pub frame_m: f64,
    /// Height of the threshold, 0 for none.
    #[serde(default)]
    pub threshold_m: f64,
    /// Its material.
    pub material: String,
}

fn default_door_depth() -> f64 {
    0.12
}

fn default_door_width() -> f64 {
    0.9
}

fn default_door_height() -> f64 {
    2.0
}

fn default_frame() -> f64 {
    0.08
}

/// A free shape: an open one is a thin sheet seen from both sides, a closed one a solid.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct PolylineSpec {
    /// Corners, `[x, height]` each.
    pub points: Vec<[f64; 2]>,
    /// Joins the last corner to the first.
    #[serde(default)]
    pub closed: bool,
    /// Width across the plane; without it wider than the beam.
    #[serde(default)]
    pub width_m: Option<f64>,
    /// How far its middle lies beside the plane that the mirror sweeps.
    #[serde(default)]
    pub lateral_m: f64,
    /// Its material.
    pub material: String,
}
