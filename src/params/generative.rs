//! Types of the measurement model's parameters.

/// Number of classes of point features.
pub const POINTS: usize = 7;
/// Number of classes of extended features.
pub const EXTENDED: usize = 6;

/// Accuracy, level and detection of a class of point features.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Point {
    /// Mean offset in range, metres.
    pub range_m: f32,
    /// Standard deviation in range, metres.
    pub range_sigma_m: f32,
    /// Mean offset across the line of sight, upwards, metres.
    pub across_m: f32,
    /// Standard deviation across the line of sight, metres.
    pub across_sigma_m: f32,
    /// Increase of the mean across with the lobe's width beyond a point scatterer's, metres per unit of width.
    pub across_per_width_m: f32,
    /// Standard deviation across per unit of that width, metres.
    pub sigma_per_width_m: f32,
    /// Level at a range of one metre where the scene's strongest echo has 30 dB, dB.
    pub snr_db: f32,
    /// Increase of the level per dB of the strongest echo.
    pub snr_per_db: f32,
    /// Standard deviation of the level, dB.
    pub snr_sigma_db: f32,
    /// Log-odds of detection.
    pub seen: f32,
    /// Increase of the log-odds per 10 dB of the level that the strongest echo predicts at the feature's range.
    pub seen_per_ten_db: f32,
    /// Increase of the log-odds per resolution cell of room around the feature.
    pub seen_per_room: f32,
}

/// Rate and level of a class of extended features.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Extended {
    /// Logarithm of the number of echoes, per metre or per scan.
    pub rate: f32,
    /// Increase of the logarithm per 10 dB of the strongest echo.
    pub rate_per_ten_db: f32,
    /// Level, dB.
    pub snr_db: f32,
    /// Increase of the level per dB of the strongest echo.
    pub snr_per_db: f32,
    /// Standard deviation of the level, dB.
    pub snr_sigma_db: f32,
    /// Standard deviation of the distance from the surface, metres.
    pub off_sigma_m: f32,
}

/// Echoes of a riser whose foot is hidden, and the log-odds that a riser has no echo.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Hidden {
    /// Lower end of the visible part: share of the echoes there, their offset and standard deviation, metres.
    pub low: [f32; 3],
    /// Upper end: share of the echoes there, their offset and standard deviation, metres.
    pub top: [f32; 3],
    /// Log-odds of no echo: constant, per 10 dB of the expected level, if the foot is hidden, per 10 dB of the riser
    /// before.
    pub nothing: [f32; 4],
}

/// Number of level classes of echoes going down.
pub const LEVELS: usize = 20;

/// Echoes of the end of a tread that is seen from above.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct TreadEnd {
    /// Expected number of echoes at the end itself.
    pub number: f32,
    /// Mean place of these echoes, metres along the tread from its end.
    pub off_m: f32,
    /// Standard deviation of their place, metres.
    pub sigma_m: f32,
}

/// Echoes of treads that are seen from above, in the height plane.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct TreadNumbers {
    /// Logarithm of the number of echoes per metre straight below the mirror where the scene's strongest echo has 30
    /// dB; its increase per 10 dB of that echo, per 10° from the vertical, and per both.
    pub rate: [f32; 4],
    /// Density of levels on treads over that of all other echoes in a square metre, by level class, m².
    pub ratio_m2: [f32; LEVELS],
    /// Standard deviation of heights, metres.
    pub height_sigma_m: f32,
    /// Ends of a tread: at an edge behind the mirror, and at one ahead of it.
    pub ends: [TreadEnd; 2],
    /// Beginnings of a tread, behind an edge behind the mirror, and behind one ahead of it.
    pub starts: [TreadEnd; 2],
    /// Factor on the standard deviations of edges: echoes lie more evenly along a tread than independent ones would.
    pub edge_sigma_scale: f32,
}

impl TreadNumbers {
    /// Parameters before anything is counted: treads without echoes.
    pub const NOTHING: Self = {
        let end = TreadEnd {
            number: 0.0,
            off_m: 0.0,
            sigma_m: 0.01,
        };
        Self {
            rate: [0.0; 4],
            ratio_m2: [0.0; LEVELS],
            height_sigma_m: 0.01,
            ends: [end; 2],
            starts: [end; 2],
            edge_sigma_scale: 1.0,
        }
    };
}

/// All parameters of the measurement model.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Generative {
    /// By class: corner, nosing, flash, top above a flash, hidden riser, open edge below and above the mirror.
    pub points: [Point; POINTS],
    /// By class: face, tread, floor, air, inside, noise.
    pub extended: [Extended; EXTENDED],
    /// Risers whose foot is hidden.
    pub hidden: Hidden,
    /// Treads that are seen from above.
    pub treads: TreadNumbers,
}
