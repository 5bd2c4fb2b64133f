//! Checks of scene files. An error message names the key and the expected value.

mod number;
mod stairs;
mod steady;

use anyhow::{Result, bail, ensure};

use number::{DECIBEL, LENGTH, POSITION, WORLD, number, numbers, ordered};

use crate::recording::MAX_CHIRPS;

use super::facets::{self, MAX_FACETS, MAX_PATCHES};
use super::geometry::World;
use super::material::{self, builtin};
use super::maths::{LIGHT, Vec2};
use super::spec::{MaterialSpec, PolylineSpec, SceneSpec};

/// Maximum conductivity of a material whose diffuse scatter comes from inside, S/m: the skin depth is 0.1 mm there.
const MAX_INSIDE: f64 = 300.0;

/// Checks everything in a scene file that can be checked before its surfaces are built.
pub fn spec(s: &SceneSpec) -> Result<()> {
    radar(s)?;
    mount(s)?;
    receiver(s)?;
    for (name, m) in &s.materials {
        material_values(&format!("material.{name}."), m)?;
    }
    surfaces(s)?;
    for (k, flight) in s.stairs.iter().enumerate() {
        stairs::flight(&format!("stairs[{k}]."), flight)?;
    }
    for (k, p) in s.polyline.iter().enumerate() {
        polyline(&format!("polyline[{k}]."), p)?;
    }
    named_materials(s)
}

fn radar(s: &SceneSpec) -> Result<()> {
    let r = &s.radar;
    numbers(
        "radar.",
        &[
            // Below, facets are no longer small compared with the surfaces.
            ("carrier_hz", r.carrier_hz, (10e9, 300e9)),
            (
                "bandwidth_hz",
                r.bandwidth_hz,
                (1e6, 0.5 * r.carrier_hz.max(2e6)),
            ),
            (
                "samples_per_chirp",
                r.samples_per_chirp as f64,
                (16.0, 256.0),
            ),
            ("sample_rate_hz", r.sample_rate_hz, (1e3, 1e9)),
            ("tx_power_dbm", r.tx_power_dbm, DECIBEL),
            (
                "antenna_gain_dbi",
                r.antenna_gain_dbi.unwrap_or(0.0),
                DECIBEL,
            ),
            ("system_loss_db", r.system_loss_db, DECIBEL),
            (
                "chirps_per_row",
                r.chirps_per_row.into(),
                (1.0, MAX_CHIRPS.into()),
            ),
        ],
    )
}

fn mount(s: &SceneSpec) -> Result<()> {
    let (m, mirror, sweep) = (&s.mount, &s.mirror, &s.sweep);
    numbers(
        "mount.",
        &[
            ("height_m", m.height_m, (0.01, 5.0)),
            ("mirror_offset_m", m.mirror_offset_m, (0.0, 2.0)),
            ("beamwidth_deg", m.beamwidth_deg, (0.5, 30.0)),
            (
                "lateral_beamwidth_deg",
                m.lateral_beamwidth_deg.unwrap_or(m.beamwidth_deg),
                (0.5, 30.0),
            ),
            ("height_error_m", m.height_error_m, (-0.5, 0.5)),
            ("pitch_deg", m.pitch_deg.unwrap_or(0.0), (-45.0, 45.0)),
            ("pitch_error_deg", m.pitch_error_deg, (-10.0, 10.0)),
            // Beyond, the beam's rays no longer meet the edges at small angles to their
            // perpendicular.
            ("yaw_deg", m.yaw_deg, (-15.0, 15.0)),
        ],
    )?;
    steady::mount(m)?;
    numbers(
        "mirror.",
        &[
            ("bias_deg", mirror.bias_deg, (-30.0, 30.0)),
            ("jitter_deg", mirror.jitter_deg, (0.0, 5.0)),
            ("turn_deg_s", mirror.turn_deg_s, (0.0, 720.0)),
            ("vibration_deg", mirror.vibration_deg, (0.0, 1.0)),
            (
                "vibration_phase_deg",
                mirror.vibration_phase_deg,
                (0.0, 360.0),
            ),
            ("runout_m", mirror.runout_m, (0.0, 0.01)),
            ("sidelobe_db", mirror.sidelobe_db, (13.26, 60.0)),
            ("sidelobe_floor_db", mirror.sidelobe_floor_db, (10.0, 300.0)),
        ],
    )?;
    steady::mirror(mirror)?;
    numbers(
        "sweep.",
        &[
            ("first_deg", sweep.first_deg, (-170.0, 170.0)),
            ("last_deg", sweep.last_deg, (-170.0, 170.0)),
            ("step_deg", sweep.step_deg, (0.01, 10.0)),
            ("row_s", sweep.row_s, (1e-4, 1.0)),
        ],
    )?;
    let count = (sweep.last_deg - sweep.first_deg) / sweep.step_deg;
    ensure!(
        count >= 2.0 - 1e-6,
        "sweep.last_deg: {}: expected at least two steps above first_deg",
        sweep.last_deg
    );
    let most = stairscan::config::MAX_ROWS;
    ensure!(
        count < most as f64 - 0.5,
        "sweep.step_deg: {}: expected at most {most} angles, not {:.0}",
        sweep.step_deg,
        count + 1.0
    );
    steady::drifts(s, count * sweep.row_s)
}

fn receiver(s: &SceneSpec) -> Result<()> {
    let r = &s.receiver;
    numbers(
        "receiver.",
        &[
            ("noise_figure_db", r.noise_figure_db, DECIBEL),
            ("full_scale_dbm", r.full_scale_dbm, DECIBEL),
            ("leakage_dbfs", r.leakage_dbfs, (-300.0, 60.0)),
            ("leakage_range_m", r.leakage_range_m, (0.0, 2.0)),
            ("mirror_echo_dbfs", r.mirror_echo_dbfs, (-300.0, 60.0)),
            ("dc_i", r.dc_i, (-1.0, 1.0)),
            ("dc_q", r.dc_q, (-1.0, 1.0)),
            ("phase_noise_dbc_hz", r.phase_noise_dbc_hz, (-300.0, -30.0)),
            ("sweep_slope", r.sweep_slope, (-0.01, 0.01)),
            ("sweep_bow", r.sweep_bow, (-0.01, 0.01)),
            ("sweep_ripple", r.sweep_ripple, (-0.01, 0.01)),
            ("sweep_ripple_cycles", r.sweep_ripple_cycles, (0.0, 1000.0)),
            ("slope_drift_s", r.slope_drift_s, (-0.01, 0.01)),
            ("carrier_drift_hz_s", r.carrier_drift_hz_s, (-1e9, 1e9)),
            ("trigger_jitter_s", r.trigger_jitter_s, (0.0, 1e-3)),
            ("start_phase_deg", r.start_phase_deg, (0.0, 360.0)),
            ("iq_gain_db", r.iq_gain_db, (-20.0, 20.0)),
            ("iq_phase_deg", r.iq_phase_deg, (-60.0, 60.0)),
            ("antialias_cutoff", r.antialias_cutoff, (0.05, 10.0)),
            ("antialias_order", f64::from(r.antialias_order), (0.0, 16.0)),
            ("adc_bits", f64::from(r.adc_bits), (2.0, 16.0)),
        ],
    )
}

fn material_values(prefix: &str, m: &MaterialSpec) -> Result<()> {
    ensure!(
        !m.diffuse_inside || m.conductivity <= MAX_INSIDE,
        "{prefix}diffuse_inside: true: expected false for a conductivity above {MAX_INSIDE}, which is {}",
        m.conductivity
    );
    numbers(
        prefix,
        &[
            ("permittivity", m.permittivity, (1.0, 1000.0)),
            ("conductivity", m.conductivity, (0.0, 1e9)),
            ("roughness_m", m.roughness_m, (0.0, 0.01)),
            ("correlation_m", m.correlation_m, (1e-5, 1.0)),
            ("diffuse_db", m.diffuse_db, (-300.0, 10.0)),
            ("joint_pitch_m", m.joint_pitch_m, (0.0, WORLD)),
            ("joint_width_m", m.joint_width_m, (0.0, WORLD)),
            ("joint_depth_m", m.joint_depth_m, (0.0, 0.1)),
            ("joint_reflection", m.joint_reflection, (0.0, 1.0)),
        ],
    )
}

fn surfaces(s: &SceneSpec) -> Result<()> {
    for (k, f) in s.floor.iter().enumerate() {
        let prefix = format!("floor[{k}].");
        number(&format!("{prefix}height_m"), f.height_m, POSITION)?;
        let end = f.to_m.unwrap_or(WORLD);
        ordered(&prefix, ("from_m", f.from_m), ("to_m", end))?;
    }
    for (k, r) in s.ramp.iter().enumerate() {
        let prefix = format!("ramp[{k}].");
        ordered(&prefix, ("from_m", r.from_m), ("to_m", r.to_m))?;
        let heights = [
            ("from_height_m", r.from_height_m, POSITION),
            ("to_height_m", r.to_height_m, POSITION),
        ];
        numbers(&prefix, &heights)?;
    }
    for (k, w) in s.wall.iter().enumerate() {
        let prefix = format!("wall[{k}].");
        number(&format!("{prefix}at_m"), w.at_m, POSITION)?;
        ordered(&prefix, ("bottom_m", w.bottom_m), ("top_m", w.top_m))?;
    }
    for (k, p) in s.post.iter().enumerate() {
        let prefix = format!("post[{k}].");
        let values = [
            ("at_m", p.at_m, POSITION),
            ("lateral_m", p.lateral_m, POSITION),
            ("diameter_m", p.diameter_m, (2e-3, 2.0)),
        ];
        numbers(&prefix, &values)?;
        ordered(&prefix, ("bottom_m", p.bottom_m), ("top_m", p.top_m))?;
    }
    for (k, b) in s.boxes.iter().enumerate() {
        let prefix = format!("box[{k}].");
        ordered(&prefix, ("from_m", b.from_m), ("to_m", b.to_m))?;
        ordered(&prefix, ("bottom_m", b.bottom_m), ("top_m", b.top_m))?;
        let values = [
            ("width_m", b.width_m.unwrap_or(1.0), LENGTH),
            ("lateral_m", b.lateral_m, POSITION),
        ];
        numbers(&prefix, &values)?;
    }
    for (k, d) in s.door.iter().enumerate() {
        let prefix = format!("door[{k}].");
        let values = [
            ("at_m", d.at_m, POSITION),
            ("depth_m", d.depth_m, LENGTH),
            ("width_m", d.width_m, LENGTH),
            ("height_m", d.height_m, LENGTH),
            ("lateral_m", d.lateral_m, POSITION),
            ("frame_m", d.frame_m, LENGTH),
            ("threshold_m", d.threshold_m, (0.0, d.height_m)),
        ];
        numbers(&prefix, &values)?;
    }
    Ok(())
}

fn polyline(prefix: &str, p: &PolylineSpec) -> Result<()> {
    let least = if p.closed { 3 } else { 2 };
    ensure!(
        p.points.len() >= least,
        "{prefix}points: {}: expected at least {least} corners",
        p.points.len()
    );
    for (k, [x, y]) in p.points.iter().enumerate() {
        number(&format!("{prefix}points[{k}][0]"), *x, POSITION)?;
        number(&format!("{prefix}points[{k}][1]"), *y, POSITION)?;
    }
    let mut pairs = p.points.windows(2).enumerate();
    if let Some((k, _)) = pairs.find(|(_, pair)| pair[0] == pair[1]) {
        bail!(
            "{prefix}points[{}]: the same as the corner before: expected another one",
            k + 1
        );
    }
    let values = [
        ("width_m", p.width_m.unwrap_or(1.0), LENGTH),
        ("lateral_m", p.lateral_m, POSITION),
    ];
    numbers(prefix, &values)
}

/// Returns every use of a material in a scene: the key that names it, and the material's name.
pub fn used_materials<'a>(s: &'a SceneSpec) -> Vec<(String, &'a str)> {
    let mut used: Vec<(String, &'a str)> = Vec::new();
    let mut add = |kind: &str, names: Vec<&'a str>| {
        let keys = names.into_iter().enumerate();
        used.extend(keys.map(|(k, name)| (format!("{kind}[{k}].material"), name)));
    };
    add(
        "floor",
        s.floor.iter().map(|f| f.material.as_str()).collect(),
    );
    add("ramp", s.ramp.iter().map(|f| f.material.as_str()).collect());
    add("wall", s.wall.iter().map(|f| f.material.as_str()).collect());
    add("post", s.post.iter().map(|f| f.material.as_str()).collect());
    add("box", s.boxes.iter().map(|f| f.material.as_str()).collect());
    add("door", s.door.iter().map(|f| f.material.as_str()).collect());
    add(
        "polyline",
        s.polyline.iter().map(|f| f.material.as_str()).collect(),
    );
    add(
        "stairs",
        s.stairs.iter().map(|f| f.material.as_str()).collect(),
    );
    for (k, f) in s.stairs.iter().enumerate() {
        if let Some(riser) = &f.riser_material {
            used.push((format!("stairs[{k}].riser_material"), riser));
        }
        if let Some(strip) = &f.strip_material {
            used.push((format!("stairs[{k}].strip_material"), strip));
        }
    }
    used
}

/// Rejects surfaces of a material that is neither in the scene nor built in.
fn named_materials(s: &SceneSpec) -> Result<()> {
    for (key, name) in used_materials(s) {
        ensure!(
            s.materials.contains_key(name) || builtin(name).is_some(),
            "{key}: \"{name}\": expected one of {}, or a [material.{name}] in the scene",
            material::NAMES.join(", ")
        );
    }
    Ok(())
}

/// Checks the built surfaces: that there are some, that there are not too many, and that the mirror
/// is not inside one.
pub fn world(s: &SceneSpec, world: &World, eye: Vec2) -> Result<()> {
    ensure!(
        !world.segments.is_empty(),
        "no surface: expected at least one of [[stairs]], [[floor]], [[ramp]], [[wall]], [[post]], \
         [[box]], [[door]], [[polyline]]"
    );
    let facets = facets::count(world, facet_limit(s));
    ensure!(
        facets <= MAX_FACETS as f64,
        "too much surface: {facets:.0} facets of a quarter wavelength: expected at most {MAX_FACETS}, so \
         shorten surfaces to what lies within the range of the radar"
    );
    free(s, world, eye)
}

/// Rejects scenes whose surfaces take too much memory and time. `sight` is the mirror's place and the range that the
/// beam reaches, metres; to either side the beam reaches `lateral_reach` per metre of range.
pub fn patches(s: &SceneSpec, world: &World, sight: (Vec2, f64), lateral_reach: f64) -> Result<()> {
    let patches = facets::patches(world, facet_limit(s), sight, lateral_reach);
    ensure!(
        patches <= MAX_PATCHES,
        "too much surface: {:.0} million patches of facets in the beam: expected at most {:.0} \
         million, so narrow the beam or shorten surfaces to what lies within the range of the radar",
        patches * 1e-6,
        MAX_PATCHES * 1e-6
    );
    Ok(())
}

/// Rejects a mirror that is not in free space: inside, behind or less than 1 cm from a surface.
fn free(s: &SceneSpec, world: &World, eye: Vec2) -> Result<()> {
    // From outside, the nearest surface in every direction shows its free side.
    for k in 0..180 {
        let (sin, cos) = libm::sincos((f64::from(k) * 2.0).to_radians());
        let far = eye + Vec2::new(cos, sin) * (2.0 * WORLD);
        let hits = world
            .segments
            .iter()
            .filter_map(|g| Some((g.crossing(eye, far)?, g)));
        let nearest = hits.min_by(|(a, _), (b, _)| a.total_cmp(b));
        let inside = nearest.is_some_and(|(t, g)| {
            let beside = g.lateral.centre.abs() >= g.lateral.half;
            !beside && (t * 2.0 * WORLD < 0.01 || (!g.sheet && g.normal().dot(eye - g.a) < 0.0))
        });
        // A single sheet of floor or wall seen from behind also means a wrong place of the mirror.
        ensure!(
            !inside,
            "mount.height_m: {}: the mirror lies inside or behind a surface (looking {}): expected it \
             in free space, 1 cm or more from everything",
            s.mount.height_m,
            compass(cos, sin)
        );
    }
    Ok(())
}

fn compass(cos: f64, sin: f64) -> &'static str {
    match (cos.abs() > sin.abs(), cos > 0.0, sin > 0.0) {
        (true, true, _) => "forward",
        (true, false, _) => "backward",
        (false, _, true) => "up",
        (false, _, false) => "down",
    }
}

/// Returns the maximum length of a facet, metres: a quarter of the carrier's wavelength.
pub fn facet_limit(s: &SceneSpec) -> f64 {
    0.25 * LIGHT / s.radar.carrier_hz
}
