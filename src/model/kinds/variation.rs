//! Variants of hypotheses, as the kinds declare them. [`crate::infer`] makes and weights them.

/// A way in which a hypothesis is varied.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Variation {
    /// The last risers are left out: one, two, …
    FewerRisers,
    /// One more riser behind the last.
    OneMoreRiser,
    /// One riser is higher or lower than the others.
    IrregularRiser,
    /// A single rise on level ground: a step, a box, a threshold.
    SingleRise,
    /// The ground ends: a drop.
    End,
}

/// A single rise that is tried on level ground.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct SingleRise {
    /// Height of the rise, metres.
    pub height_m: f32,
    /// Prior share of a place at an echo.
    pub at_echo: f32,
    /// Prior share of a place without an echo.
    pub elsewhere: f32,
}

impl SingleRise {
    /// Returns a rise of `height_m` metres with its prior shares at an echo and elsewhere.
    pub const fn new(height_m: f32, at_echo: f32, elsewhere: f32) -> Self {
        Self {
            height_m,
            at_echo,
            elsewhere,
        }
    }
}
