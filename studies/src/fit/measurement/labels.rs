//! Labels each echo with a class of the measurement model, given a staircase. The labelled echoes are the data that
//! the model's parameters are fitted to.
//!
//! An echo belongs to the point feature with the largest share of it, if that share exceeds the share of every class
//! of extended features. Otherwise it belongs to the extended class with the largest density. The shares are those of
//! [`Model::riser`].

use std::ops::Deref;

use heapless::Vec;
use stairscan::math;
use stairscan::model::{
    Class, FeaturePlace, MAX_MODEL_ECHOES, MAX_STEPS, Model, ModelEcho, NEAR, Staircase,
    excess_level, logistic,
};
use stairscan::params::generative::EXTENDED;
use stairscan::params::posterior::{self, BEHIND_RISER_M, MAX_P_DETECTED, MIN_P_DETECTED};

/// SNR of an echo, with the quantities on which its expected value depends.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Level {
    /// SNR of the echo, dB.
    pub snr_db: f32,
    /// Change of the expected SNR with the echo's distance, dB, relative to the class's reference distance (1 m for
    /// point features); 0 where the class has none.
    pub fade_db: f32,
    /// SNR of the scan's strongest echo, tens of dB over 30 dB.
    pub q: f32,
}

/// An echo that is assigned to a point feature, with its offsets from it.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Hit {
    /// Range of the echo less that of the feature, metres; of a hidden riser the horizontal distance of the echo from
    /// it, projected on the line of sight.
    pub range_m: f32,
    /// Offset of the echo from the feature across the line of sight, upwards, metres.
    pub across_m: f32,
    /// Standard deviation of `across_m` from the echo's estimated angle error, metres.
    pub noise_m: f32,
    /// Excess of the lobe's width over a point scatterer's, in units of the latter.
    pub wide: f32,
    /// Cosine of the echo's angle below the horizontal.
    pub cos: f32,
    /// Height of the echo above the lower end of the riser's visible part, and above the upper end, metres. Used for
    /// hidden risers.
    pub above_m: [f32; 2],
    /// Overhang of the nosings, projected on the line of sight, metres.
    pub over_m: f32,
}

/// A sample that labelling gives for the fit.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Sample {
    /// A point feature that was expected to be visible, with its echo if there is one.
    Feature {
        /// Class of the feature.
        class: Class,
        /// Index of the riser that has the feature.
        riser: usize,
        /// SNR that the scan's strongest echo predicts at the feature's range, tens of dB over 30 dB.
        q: f32,
        /// Distance from the feature to its neighbour, resolution cells.
        room: f32,
        /// Echo that is assigned to the feature; `None` if it is not detected.
        hit: Option<(Hit, Level)>,
    },
    /// A riser; follows the samples of its features.
    Riser {
        /// SNR that the scan's strongest echo predicts at the range of the riser's first feature, tens of dB over 30
        /// dB.
        q: f32,
        /// Whether the riser's foot is hidden.
        hidden: bool,
        /// SNR of the riser before this one, tens of dB over 15 dB.
        before: f32,
        /// Whether none of the riser's features has an echo.
        nothing: bool,
    },
    /// An echo that is assigned to no point feature, but to a class of extended features.
    Extended {
        /// Index of the echo's class: face, tread, floor, air, inside, noise.
        class: usize,
        /// SNR of the echo, with its covariates.
        level: Level,
        /// Distance of the echo from the surface of its class, metres; 0 for classes without a surface.
        off_m: f32,
        /// Standard deviation of `off_m` from the echo's estimated angle error, metres.
        noise_m: f32,
    },
}

/// A point feature with the echo that may be assigned to it.
#[derive(Clone, Copy)]
struct EchoAssignment {
    riser: usize,
    place: FeaturePlace,
    /// Index of the echo that most probably stems from the feature, and the probability that it does.
    echo: Option<(usize, f32)>,
}

/// A model that labels echoes, given a staircase.
struct Labeller<'m, 'p>(&'m Model<'p>);

impl<'p> Deref for Labeller<'_, 'p> {
    type Target = Model<'p>;

    fn deref(&self) -> &Model<'p> {
        self.0
    }
}

/// Labels the echoes and features under the staircase `s` and passes each sample to `emit`. Returns the exposures of
/// face, tread and floor: expected numbers of echoes over their rates.
pub fn label(model: &Model<'_>, s: &Staircase, emit: &mut dyn FnMut(Sample)) -> [f32; 3] {
    Labeller(model).label(s, emit)
}

impl Labeller<'_, '_> {
    fn label(&self, s: &Staircase, emit: &mut dyn FnMut(Sample)) -> [f32; 3] {
        let mut assignments: Vec<EchoAssignment, { posterior::FEATURES * (MAX_STEPS + 1) }> =
            Vec::new();
        for k in 0..=s.len() {
            self.claim(s, k, &mut assignments);
        }
        let mut owner = [None; MAX_MODEL_ECHOES];
        for (i, claim) in assignments.iter().enumerate() {
            let Some((echo, share)) = claim.echo.filter(|e| self.most(s, e.0, e.1)) else {
                continue;
            };
            if let Some(owner) = owner.get_mut(echo)
                && owner.is_none_or(|(_, other)| share > other)
            {
                *owner = Some((i, share));
            }
        }
        for k in 0..s.len() {
            self.label_riser(s, k, &assignments, &owner, emit);
        }
        let mut exposure = [0.0; posterior::SURFACES];
        for k in 0..=s.len() {
            for (sum, more) in exposure.iter_mut().zip(self.exposure(s, k)) {
                *sum += more;
            }
        }
        for (e, _) in self.echoes.iter().zip(&owner).filter(|(_, o)| o.is_none()) {
            self.label_extended(s, e, emit);
        }
        exposure
    }

    /// Whether an echo belongs to a point feature: whether `share`, the probability that the echo stems from it,
    /// exceeds that of every class of extended features.
    fn most(&self, s: &Staircase, echo: usize, share: f32) -> bool {
        let Some(e) = self.echoes.get(echo) else {
            return false;
        };
        let parts = self.parts(s, self.tread_of(s, e), e);
        let largest = parts.iter().copied().fold(0.0, math::max);
        share > (1.0 - share) * largest / parts.iter().sum::<f32>()
    }

    /// Returns the index of the tread below an echo: the number of risers before it.
    fn tread_of(&self, s: &Staircase, e: &ModelEcho) -> usize {
        let behind = |k: &usize| e.x_m > s.x(*k) + BEHIND_RISER_M;
        (0..s.len()).take_while(behind).count()
    }

    /// Appends the features of riser `k`, in the order of the likelihood, to `assignments`, each with the echo that
    /// most probably stems from it.
    fn claim(
        &self,
        s: &Staircase,
        k: usize,
        assignments: &mut Vec<EchoAssignment, { posterior::FEATURES * (MAX_STEPS + 1) }>,
    ) {
        let x = if k < s.len() { s.x(k) } else { s.wall_m };
        let near = self.between(x - posterior::RISER_BEFORE_M, x + posterior::RISER_BEHIND_M);
        let first = self
            .echoes
            .partition_point(|e| e.x_m <= x - posterior::RISER_BEFORE_M);
        let mut used = [0f32; NEAR];
        for place in self.places(s, k) {
            let Some(p) = self.g.points.get(place.class as usize) else {
                continue;
            };
            let q = self.expected_q(place.range_m);
            let odds =
                p.seen + p.seen_per_ten_db * q + p.seen_per_room * (place.separation_cells - 1.0);
            let seen = logistic(odds).clamp(MIN_P_DETECTED, MAX_P_DETECTED);
            let mut gains = [0f32; NEAR];
            for ((e, gain), used) in near.iter().zip(&mut gains).zip(&used) {
                let tread = if e.x_m > s.x(k) + BEHIND_RISER_M {
                    k + 1
                } else {
                    k
                };
                let b = self.background(s, tread.min(s.len()), e);
                *gain = seen * self.density(s, k, &place, p, e) / b * (1.0 - used);
            }
            let z = 1.0 - seen + gains.iter().sum::<f32>();
            for (used, gain) in used.iter_mut().zip(&gains) {
                *used = math::min(
                    *used + posterior::MAX_USED_SHARE * gain / z,
                    posterior::MAX_USED_SHARE,
                );
            }
            let shares = gains.iter().enumerate();
            let most = shares.max_by(|a, b| a.1.total_cmp(b.1));
            let _ = assignments.push(EchoAssignment {
                riser: k,
                place,
                echo: most.map(|(i, gain)| (first + i, gain / z)),
            });
        }
    }

    fn label_riser(
        &self,
        s: &Staircase,
        k: usize,
        assignments: &[EchoAssignment],
        owner: &[Option<(usize, f32)>; MAX_MODEL_ECHOES],
        emit: &mut dyn FnMut(Sample),
    ) {
        let (mut riser, mut nothing) = (None, true);
        for (i, claim) in assignments.iter().enumerate().filter(|(_, c)| c.riser == k) {
            let echo = claim.echo.map_or(MAX_MODEL_ECHOES, |e| e.0);
            let mine = owner.get(echo).copied().flatten().is_some_and(|o| o.0 == i);
            let e = self.echoes.get(echo).filter(|_| mine);
            let q = self.expected_q(claim.place.range_m);
            emit(Sample::Feature {
                class: claim.place.class,
                riser: k,
                q,
                room: claim.place.separation_cells,
                hit: e.map(|e| self.hit(s, k, &claim.place, e)),
            });
            nothing &= e.is_none();
            riser = riser.or(Some((q, claim.place.class == Class::Hidden)));
        }
        if let Some((q, hidden)) = riser {
            emit(Sample::Riser {
                q,
                hidden,
                before: excess_level(self.level_before(s, k)),
                nothing,
            });
        }
    }

    fn hit(&self, s: &Staircase, k: usize, place: &FeaturePlace, e: &ModelEcho) -> (Hit, Level) {
        let cos = e.x_m / e.range_m;
        let (low, top) = self.face_span(s, k);
        let (x, y) = (place.x_m, place.y_m - self.height_m);
        let (range_m, across_m) = match place.class {
            Class::Hidden => ((e.x_m - x) * cos, 0.0),
            _ => (
                e.range_m - place.range_m,
                (x * (e.y_m - self.height_m) - y * e.x_m) / place.range_m,
            ),
        };
        let hit = Hit {
            range_m,
            across_m,
            noise_m: e.across_m,
            wide: e.wide,
            cos,
            above_m: [e.y_m - low, e.y_m - top],
            over_m: s.overhang_m * cos,
        };
        let level = Level {
            snr_db: e.snr_db,
            fade_db: posterior::TEN_DB * (self.expected_q(e.range_m) - self.q),
            q: self.q,
        };
        (hit, level)
    }

    fn label_extended(&self, s: &Staircase, e: &ModelEcho, emit: &mut dyn FnMut(Sample)) {
        let k = self.tread_of(s, e);
        let parts = self.parts(s, k, e);
        let largest = parts.iter().enumerate().max_by(|a, b| a.1.total_cmp(b.1));
        let class = largest.map_or(EXTENDED - 1, |(class, _)| class);
        let up = e.across_m * e.x_m / math::max(e.range_m, posterior::MIN_RANGE_M);
        let along =
            e.across_m * (self.height_m - e.y_m) / math::max(e.range_m, posterior::MIN_RANGE_M);
        let mut level = Level {
            snr_db: e.snr_db,
            fade_db: 0.0,
            q: self.q,
        };
        let (off_m, noise_m) = match class {
            0 => {
                let faces = [k.checked_sub(1), Some(k).filter(|k| *k < s.len())];
                let off = |k: usize| e.x_m - s.x(k) + posterior::FACE_BEFORE * s.overhang_m;
                let offs = faces.into_iter().flatten().map(off);
                let Some(off) = offs.min_by(|a, b| a.abs().total_cmp(&b.abs())) else {
                    return;
                };
                // An echo closer to the wall behind belongs to no riser's face.
                if (e.x_m - s.wall_m).abs() < off.abs() {
                    return;
                }
                (off, along)
            }
            1 => (e.y_m - s.level(k), up),
            2 => {
                level.fade_db = -posterior::FLOOR_FALL_DB
                    * math::max(e.x_m - posterior::FLOOR_M, -posterior::FLOOR_NEARER_M);
                let level = if k == 0 { self.base(s, 0, e.x_m) } else { 0.0 };
                (e.y_m - level, up)
            }
            _ => (0.0, 0.0),
        };
        emit(Sample::Extended {
            class,
            level,
            off_m,
            noise_m,
        });
    }
}
