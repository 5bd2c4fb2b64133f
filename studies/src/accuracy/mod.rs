//! Tables of `cargo study accuracy`: reliability of the confidence and the horizon ([`reliability`]), and the share of
//! wrong answers weighted by the frequency of scenes ([`weighted`]).

pub mod reliability;
pub mod weighted;
