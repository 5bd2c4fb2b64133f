//! The first hazard's place, from sweep to sweep.

use super::HazardKind;
use crate::math;
use crate::model::Surfaces;
use crate::model::lines::PastLines;
use crate::model::surfaces::{SLOT_M, SLOTS};

fn env(name: &str, d: f32) -> f32 {
    #[cfg(not(target_os = "none"))]
    {
        extern crate std;
        return std::env::var(name).ok().and_then(|v| v.parse().ok()).unwrap_or(d);
    }
    #[cfg(target_os = "none")]
    d
}

/// How far the ground is free.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Free {
    /// Up to where, metres from the mirror.
    pub free_m: f32,
    /// What ends it, if that is known.
    pub what: Option<HazardKind>,
    /// Probability that no hazard stands nearer.
    pub confidence: f32,
}

/// Log-likelihood ratio of a hazard by kind and place against free ground, over all sweeps.
#[derive(Clone, Debug)]
pub struct Filter {
    pub(crate) past: PastLines,
    sweeps: f32,
    speckles: f32,
    last_m: Option<f32>,
}

impl Default for Filter {
    fn default() -> Self {
        Self::new()
    }
}

impl Filter {
    /// Before the first sweep.
    pub const fn new() -> Self {
        Self { past: PastLines::NONE, sweeps: 0.0, speckles: 0.0, last_m: None }
    }

    /// Kept, sweeps, speckles.
    pub(crate) fn step(&mut self, moved_m: Option<f32>) -> (f32, f32, f32) {
        let kept = if moved_m.is_some() { env("KEPT", 0.6) } else { env("KEPT0", 0.3) };
        let w = kept * self.sweeps;
        self.sweeps = w + 1.0;
        // Effective number: (Σw)²/Σw² of a geometric series.
        let n = (1.0 + kept) / (1.0 - kept);
        let n = math::min(n, self.sweeps);
        let moves = moved_m.is_some_and(|m| m.abs() > 0.002);
        (w, n, if moves { n } else { 1.0 })
    }

    /// How far the ground is free by now.
    pub(crate) fn read(&mut self, s: &Surfaces, things: &[f32; SLOTS], moved_m: Option<f32>) -> Free {
        let t = env("T", 0.6);
        let priors = [env("PR", 0.3) * SLOT_M, env("PD", 0.25) * SLOT_M, env("PO", 0.02) * SLOT_M, env("PB", 0.02) * SLOT_M];
        let slot = |kind: usize, k: usize| {
            let x = (k as f32 + 0.5) * SLOT_M;
            let nats = match kind { 0 => s.rise_at(x), 1 => s.drop_at(x), 2 => things[k], _ => s.bump_at(x) };
            priors[kind] * math::exp(math::min(if kind == 2 { env("TT", 1.0) * nats } else { t * nats }, 40.0))
        };
        let sum = |k: usize| slot(0, k) + slot(1, k);
        let thing = |k: usize| { let w = slot(2, k); w / (1.0 + w) };
        let total: f32 = 1.0 + (0..SLOTS).map(|k| sum(k) + slot(3, k)).sum::<f32>();
        let risk = env("RISK", 0.002);
        let (mut so_far, mut end, mut before) = (0.0, SLOTS, 0.0);
        for k in 0..SLOTS {
            before = so_far;
            so_far += sum(k) / total + thing(k);
            if so_far > risk { end = k; break; }
        }
        #[cfg(not(target_os = "none"))]
        if env("PEEK", 0.0) > 0.0 {
            extern crate std;
            std::eprintln!("things {:?}", things.iter().map(|t| (t * 10.0).round() / 10.0).collect::<std::vec::Vec<_>>());
            for kind in [0, 1] { std::eprintln!("{kind} {:?}", (0..SLOTS).map(|k| { let x = (k as f32 + 0.5) * SLOT_M; let v = if kind == 0 { s.rise_at(x) } else { s.drop_at(x) }; (v * 10.0).round() / 10.0 }).collect::<std::vec::Vec<_>>()); }
        }
        let now = end as f32 * SLOT_M;
        let last = self.last_m.map(|l| l - moved_m.unwrap_or(0.0));
        self.last_m = Some(now);
        let m = last.map_or(now, |l| math::min(l, now));
        let free_m = math::max(m - env("MARGIN", 0.08), 0.0);
        let near = ((free_m + 0.35) / SLOT_M) as usize;
        let of = |kind: usize| (0..near.min(SLOTS)).map(|k| if kind == 2 { thing(k) } else { slot(kind, k) / total }).sum::<f32>();
        let what = if of(2) > 0.5 { Some(HazardKind::Obstacle) } else if of(0) > 0.5 { Some(HazardKind::Rise) } else if of(1) > 0.5 { Some(HazardKind::Drop) } else { None };
        Free { free_m, what, confidence: 1.0 - before }
    }
}
