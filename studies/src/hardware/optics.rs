//! Dimensions of lens and mirror, computed from beam width and wavelength, and their drawing.

use super::sheet::{Anchor, BEAM, BODY, FAINT, INK, Place, Sheet};

/// Speed of light, mm · GHz.
const LIGHT: f64 = 299.792_458;
/// Middle of the BGT60TR13C's band, GHz (docs/design/modules.md).
const CARRIER_GHZ: f64 = 60.75;
/// Beam width in the default setting `beamwidth`, degrees between the 3 dB points.
const BEAM_DEG: f64 = 5.0;
/// Product of beam width in degrees and aperture in wavelengths (docs/design/modules.md).
const SPREAD_DEG: f64 = 70.0;
/// Optical path in the setting `mirror-offset`, from the chip to the mirror's centre, mm of air.
const OFFSET_MM: f64 = 220.0;
/// Index of refraction of HDPE at 60 GHz.
const INDEX: f64 = 1.53;
/// Distance from the chip to the lens's vertex, mm. Seen from the chip, the lens then spans 70°,
/// similar to the chip's own beam (65° by 35 to 40°).
const FOCUS_MM: f64 = 50.0;
/// Width and thickness of the rim around the clear aperture, mm.
const RIM_MM: f64 = 3.0;
/// Thickness of the mirror's aluminium sheet, mm.
const SHEET_MM: f64 = 1.0;
/// Distance from the mirror's centre to the motor's face, mm.
const MOTOR_MM: f64 = 60.0;
/// Divisor of the wavelength that gives the tolerance of roughness and flatness: λ/16.
const FLAT: f64 = 16.0;

/// Dimensions of lens and mirror, mm.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Optics {
    /// Wavelength at the middle of the band, mm.
    pub wavelength: f64,
    /// Diameter of the lens's clear aperture, mm.
    pub clear: f64,
    /// Outer diameter of the lens, with its rim, mm.
    pub outer: f64,
    /// Depth of the lens's curved side, from the edge of the aperture to the vertex, mm.
    pub sag: f64,
    /// Thickness of the lens in its middle, mm.
    pub thick: f64,
    /// Distance from the lens's flat side to the mirror's centre, mm.
    pub gap: f64,
    /// Short and long axis of the elliptical mirror, mm.
    pub mirror: (f64, f64),
    /// Tolerance of the mirror's flatness and of the lens's shape, mm.
    pub flat: f64,
}

/// Returns the depth of the lens's curved side, mm, `y` mm off the axis. The hyperbola makes the
/// optical path through glass and air the same for every ray from the focus.
pub fn sag(y: f64) -> f64 {
    let (a, b) = (INDEX * INDEX - 1.0, (INDEX - 1.0) * FOCUS_MM);
    ((b * b + a * y * y).sqrt() - b) / a
}

impl Optics {
    /// Computes the dimensions for the default radar module.
    pub fn new() -> Self {
        let wavelength = LIGHT / CARRIER_GHZ;
        let clear = (SPREAD_DEG * wavelength / BEAM_DEG).ceil();
        let sag = sag(clear / 2.0);
        let thick = sag + RIM_MM;
        let gap = OFFSET_MM - FOCUS_MM - INDEX * thick;
        // The beam at the mirror's centre, widened by its half width on either side.
        let short = (clear + 2.0 * gap * (BEAM_DEG / 2.0).to_radians().tan()).ceil();
        Self {
            wavelength,
            clear,
            outer: clear + 2.0 * RIM_MM,
            sag,
            thick,
            gap,
            mirror: (short, short * std::f64::consts::SQRT_2),
            flat: wavelength / FLAT,
        }
    }
}

impl Default for Optics {
    fn default() -> Self {
        Self::new()
    }
}

/// Scale of the drawing of the arrangement, and scale of the drawings of lens and mirror, pixels
/// per millimetre.
const SCALE: f64 = 2.9;
const PART: f64 = 3.4;
/// Place of the chip in the drawing of the arrangement, pixels.
const CHIP: Place = (90.0, 285.0);

/// Returns the drawing of arrangement, lens and mirror.
pub fn draw() -> Sheet {
    let optics = Optics::new();
    let mut sheet = Sheet::new(1180.0, 960.0);
    sheet.text(
        (20.0, 32.0),
        Anchor::Start,
        18.0,
        INK,
        "Lens and mirror for a BGT60TR13C",
    );
    let about = format!(
        "made by `cargo study hardware optics`: {CARRIER_GHZ} GHz (wavelength {:.2} mm), beam {BEAM_DEG:.0}°, mirror-offset {:.2} m; millimetres",
        optics.wavelength,
        OFFSET_MM / 1e3
    );
    sheet.text((20.0, 50.0), Anchor::Start, 11.0, FAINT, &about);
    arrangement(&mut sheet, &optics);
    lens(&mut sheet, &optics);
    mirror(&mut sheet, &optics);
    sheet
}

/// Returns points `(depth, y)` of the lens's curved side from edge to edge, mm; depth counts from
/// the vertex, and `y` upwards from the axis.
fn profile(optics: &Optics) -> Vec<(f64, f64)> {
    const PIECES: i32 = 24;
    let half = optics.clear / 2.0;
    let points = (-PIECES..=PIECES).map(|k| f64::from(k) / f64::from(PIECES) * half);
    points.map(|y| (sag(y), y)).collect()
}

/// Draws the section of the lens, with its vertex at `vertex` (pixels) and its flat side to the
/// right; `scale` is in pixels per millimetre.
fn section(sheet: &mut Sheet, optics: &Optics, vertex: Place, scale: f64) {
    let place = |x: f64, y: f64| (vertex.0 + scale * x, vertex.1 - scale * y);
    let (half, edge) = (optics.outer / 2.0, optics.sag);
    let mut points = vec![place(optics.thick, -half), place(edge, -half)];
    points.extend(profile(optics).into_iter().map(|(x, y)| place(x, y)));
    points.extend([
        place(edge, half),
        place(optics.thick, half),
        place(optics.thick, -half),
    ]);
    sheet.path(&points, &format!("fill=\"{BODY}\" stroke=\"{INK}\""));
}

fn arrangement(sheet: &mut Sheet, optics: &Optics) {
    let x = |mm: f64| CHIP.0 + SCALE * mm;
    let y = |mm: f64| CHIP.1 - SCALE * mm;
    let (vertex, back) = (FOCUS_MM, FOCUS_MM + optics.thick);
    let centre = back + optics.gap;
    let motor = centre + MOTOR_MM;
    let half = optics.clear / 2.0;
    sheet.dashed((x(-20.0), y(0.0)), (x(motor + 58.0), y(0.0)), FAINT);
    // Radar board with its chip at the focus.
    sheet.rect((x(-4.0), y(14.0)), (3.0 * SCALE, 28.0 * SCALE), BODY);
    sheet.rect((x(-1.0), y(3.0)), (SCALE, 6.0 * SCALE), INK);
    section(sheet, optics, (x(vertex), y(0.0)), SCALE);
    for side in [-1.0, 1.0] {
        let edge = side * half;
        let bend = (x(centre - edge), y(edge));
        let ray = [
            (x(0.0), y(0.0)),
            (x(vertex + optics.sag), y(edge)),
            bend,
            (bend.0, y(-78.0)),
        ];
        sheet.path(
            &ray,
            &format!("fill=\"none\" stroke=\"{BEAM}\" stroke-dasharray=\"5 3\""),
        );
    }
    // The mirror at 45° on the motor's shaft.
    let reach = optics.mirror.1 / 2.0 / std::f64::consts::SQRT_2;
    let (top, bottom) = (
        (x(centre - reach), y(reach)),
        (x(centre + reach), y(-reach)),
    );
    sheet.path(
        &[top, bottom],
        &format!("fill=\"none\" stroke=\"{INK}\" stroke-width=\"4\""),
    );
    sheet.rect(
        (x(centre + 6.0), y(4.0)),
        ((MOTOR_MM - 6.0) * SCALE, 8.0 * SCALE),
        BODY,
    );
    sheet.rect((x(motor), y(17.5)), (34.0 * SCALE, 35.0 * SCALE), BODY);
    sheet.rect((x(motor + 34.0), y(2.5)), (8.0 * SCALE, 5.0 * SCALE), BODY);
    sheet.rect((x(motor + 44.0), y(8.0)), (2.0 * SCALE, 16.0 * SCALE), BODY);
    // Text outside the beam.
    let words = |sheet: &mut Sheet, mm: f64, at: f64, text: &str| {
        sheet.text((x(mm), y(at)), Anchor::Middle, 12.0, INK, text);
    };
    words(sheet, 0.0, -22.0, "chip at the focus");
    words(
        sheet,
        vertex + optics.thick / 2.0,
        -half - 9.0,
        "lens, curved side to the chip",
    );
    words(sheet, motor + 17.0, -22.0, "motor");
    words(sheet, motor + 53.0, 13.0, "magnet, AS5600");
    words(sheet, centre + 62.0, -62.0, "beam, towards the stairs:");
    words(sheet, centre + 62.0, -68.0, "it turns with the shaft");
    // Dimensions above, with extension lines down to the measured points.
    let (upper, lower) = (y(62.0), y(50.0));
    for (mm, from, to) in [
        (0.0, upper, y(4.0)),
        (vertex, lower, y(1.0)),
        (back, lower, y(optics.outer / 2.0)),
        (centre, upper, y(1.0)),
        (motor, lower, y(17.5)),
    ] {
        sheet.line((x(mm), from - 6.0), (x(mm), to), "#c3c9d1");
    }
    sheet.dimension(
        (x(0.0), lower),
        (x(vertex), lower),
        &format!("{FOCUS_MM:.1}"),
    );
    sheet.dimension(
        (x(vertex), lower),
        (x(back), lower),
        &format!("{:.1}", optics.thick),
    );
    sheet.dimension(
        (x(back), lower),
        (x(centre), lower),
        &format!("{:.1}", optics.gap),
    );
    sheet.dimension(
        (x(centre), lower),
        (x(motor), lower),
        &format!("{MOTOR_MM:.1}"),
    );
    let path = format!(
        "path: {FOCUS_MM:.1} + {INDEX} × {:.1} + {:.1} = {OFFSET_MM:.0} (mirror-offset)",
        optics.thick, optics.gap
    );
    sheet.dimension((x(0.0), upper), (x(centre), upper), &path);
}

fn lens(sheet: &mut Sheet, optics: &Optics) {
    let vertex: Place = (250.0, 750.0);
    let at = |x: f64, y: f64| (vertex.0 + PART * x, vertex.1 - PART * y);
    sheet.text(
        (20.0, 565.0),
        Anchor::Start,
        15.0,
        INK,
        "Lens: HDPE, section",
    );
    section(sheet, optics, vertex, PART);
    let (half, outer) = (optics.clear / 2.0, optics.outer / 2.0);
    let right = optics.thick;
    sheet.dashed(at(-14.0, 0.0), at(right + 10.0, 0.0), FAINT);
    for (y, far) in [
        (half, -16.0),
        (-half, -16.0),
        (outer, -38.0),
        (-outer, -38.0),
    ] {
        sheet.line(at(far, y), at(optics.sag, y), "#c3c9d1");
    }
    sheet.dimension(
        at(-14.0, half),
        at(-14.0, -half),
        &format!("Ø {:.0}", optics.clear),
    );
    sheet.dimension(
        at(-36.0, outer),
        at(-36.0, -outer),
        &format!("Ø {:.0}", optics.outer),
    );
    for x in [0.0, optics.sag, right] {
        sheet.line(
            at(x, -outer - 14.0),
            at(x, if x == 0.0 { 0.0 } else { -outer }),
            "#c3c9d1",
        );
    }
    sheet.dimension(
        at(0.0, -outer - 6.0),
        at(right, -outer - 6.0),
        &format!("{:.1}", optics.thick),
    );
    let rim = at(right + 3.0, -outer - 12.0);
    sheet.text(
        (rim.0, rim.1 + 4.0),
        Anchor::Start,
        12.0,
        FAINT,
        &format!("rim {RIM_MM:.1}"),
    );
    // Coordinates of the curve as text.
    let (x, mut y) = (400.0, 600.0);
    sheet.text((x, y), Anchor::Start, 12.0, INK, "off the axis");
    sheet.text(
        (x + 95.0, y),
        Anchor::Start,
        12.0,
        INK,
        "depth from the vertex",
    );
    let mut off = 0.0;
    while off < half + 5.0 {
        y += 19.0;
        let here = off.min(half);
        sheet.text((x + 60.0, y), Anchor::End, 12.0, INK, &format!("{here:.1}"));
        sheet.text(
            (x + 150.0, y),
            Anchor::End,
            12.0,
            INK,
            &format!("{:.2}", sag(here)),
        );
        off += 5.0;
    }
    for words in [
        format!("index {INDEX}; shape true to {:.1},", optics.flat),
        "turned marks do no harm".to_owned(),
        "y² = (n² − 1) x² + 2 (n − 1) f x".to_owned(),
    ] {
        y += 22.0;
        sheet.text((x, y), Anchor::Start, 12.0, FAINT, &words);
    }
}

fn mirror(sheet: &mut Sheet, optics: &Optics) {
    let centre: Place = (935.0, 750.0);
    let scale = 2.6;
    let (short, long) = optics.mirror;
    let (rx, ry) = (scale * long / 2.0, scale * short / 2.0);
    sheet.text(
        (720.0, 565.0),
        Anchor::Start,
        15.0,
        INK,
        "Mirror: aluminium, seen square to its face",
    );
    sheet.ellipse(centre, (rx, ry), BODY);
    for x in [-rx, rx] {
        sheet.line(
            (centre.0 + x, centre.1),
            (centre.0 + x, centre.1 - ry - 30.0),
            "#c3c9d1",
        );
    }
    for y in [-ry, ry] {
        sheet.line(
            (centre.0, centre.1 + y),
            (centre.0 - rx - 26.0, centre.1 + y),
            "#c3c9d1",
        );
    }
    let above = centre.1 - ry - 24.0;
    sheet.dimension(
        (centre.0 - rx, above),
        (centre.0 + rx, above),
        &format!("{long:.1}"),
    );
    let beside = centre.0 - rx - 20.0;
    sheet.dimension(
        (beside, centre.1 + ry),
        (beside, centre.1 - ry),
        &format!("{short:.0}"),
    );
    for (k, words) in [
        format!(
            "sheet {SHEET_MM:.1}, flat to {:.1}, on a core of foam",
            optics.flat
        ),
        "its centre on the shaft's axis, 45° ± 0.3° to it".to_owned(),
        "balanced; no screw heads on the face".to_owned(),
    ]
    .iter()
    .enumerate()
    {
        let y = centre.1 + ry + 28.0 + 20.0 * k as f64;
        sheet.text((centre.0, y), Anchor::Middle, 12.0, FAINT, words);
    }
}
