//! Shape of the measurement model's numbers.

/// Classes of point features.
pub const POINTS: usize = 7;
/// Classes of extended features.
pub const EXTENDED: usize = 6;

/// What a class of point features shows.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Point {
    /// Mean offset in range, metres, …
    pub range_m: f32,
    /// … and its standard deviation.
    pub range_sigma_m: f32,
    /// Mean offset across the line of sight, upwards, metres, …
    pub across_m: f32,
    /// … its standard deviation, …
    pub across_sigma_m: f32,
    /// … what a lobe wider than a point's adds to the mean, metres per unit of width, …
    pub across_per_width_m: f32,
    /// … and to the standard deviation.
    pub sigma_per_width_m: f32,
    /// Level at a metre where the scene's strongest echo has 30 dB, dB, …
    pub snr_db: f32,
    /// … per dB of that, …
    pub snr_per_db: f32,
    /// … and its standard deviation, dB.
    pub snr_sigma_db: f32,
    /// Log-odds of being seen, …
    pub seen: f32,
    /// … per 10 dB, …
    pub seen_per_ten_db: f32,
    /// … and per cell of room around it.
    pub seen_per_room: f32,
}

/// What a class of extended features shows.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Extended {
    /// Logarithm of the number of echoes, per metre or per scan, …
    pub rate: f32,
    /// … and per 10 dB.
    pub rate_per_ten_db: f32,
    /// Level, dB, …
    pub snr_db: f32,
    /// … per dB of the strongest echo's, …
    pub snr_per_db: f32,
    /// … and its standard deviation, dB.
    pub snr_sigma_db: f32,
    /// Standard deviation off the surface, metres.
    pub off_sigma_m: f32,
}

/// What a riser shows whose foot is hidden, and how likely one shows nothing.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Hidden {
    /// Share of echoes at the lower end of what can be seen, their offset and spread, metres.
    pub low: [f32; 3],
    /// The same at the top.
    pub top: [f32; 3],
    /// Log-odds of showing nothing, per 10 dB, if the foot is hidden, per 10 dB of the riser before.
    pub nothing: [f32; 4],
}

/// Levels of echoes that are told apart going down.
pub const LEVELS: usize = 20;

/// What the end of a tread shows that is seen from above.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct TreadEnd {
    /// Expected number of echoes at the end itself.
    pub number: f32,
    /// Where they lie on the mean, metres along the tread from its end, …
    pub off_m: f32,
    /// … and their standard deviation.
    pub sigma_m: f32,
}

/// What treads show that are seen from above, in the height plane.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct TreadNumbers {
    /// Logarithm of the number of echoes per metre straight below the mirror where the scene's strongest echo has
    /// 30 dB; per 10 dB of that; per 10° off the vertical; and per both.
    pub rate: [f32; 4],
    /// Density of levels on treads over that of all other echoes in a square metre, by level: square metres.
    pub ratio_m2: [f32; LEVELS],
    /// Standard deviation of heights, metres.
    pub height_sigma_m: f32,
    /// Where a tread ends: at an edge behind the mirror, and at one before it.
    pub ends: [TreadEnd; 2],
    /// Where a tread begins behind such edges.
    pub starts: [TreadEnd; 2],
    /// Factor on the standard deviations of edges: echoes lie more evenly along a tread than chance would have them.
    pub edge_sigma_scale: f32,
}

impl TreadNumbers {
    /// Before anything is counted: treads that show nothing.
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

/// The whole model.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Generative {
    /// By class: corner, nosing, flash, top over a flash, hidden riser, open edge below and above.
    pub points: [Point; POINTS],
    /// By class: face, tread, floor, air, inside, noise.
    pub extended: [Extended; EXTENDED],
    /// Hidden risers.
    pub hidden: Hidden,
    /// Treads that are seen from above.
    pub treads: TreadNumbers,
}
