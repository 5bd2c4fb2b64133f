//! Labels each echo with a class of the measurement model, given a staircase: the data that the model's numbers are
//! fitted to.
//!
//! An echo belongs to the point feature with the largest share of it, if that share exceeds the share of every class
//! of extended features. Otherwise it belongs to the extended class with the largest density. The shares are those of
//! [`Model::riser`].

use std::ops::Deref;

use heapless::Vec;
use stairscan::math;
use stairscan::model::{
    BEHIND_M, Class, FeaturePlace, LEAST_SEEN, MAX_SEEN, MAX_STEPS, MOST_SEEN, Model, NEAR, Seen,
    Staircase, before, logistic,
};
use stairscan::params::generative::EXTENDED;
use stairscan::params::posterior as number;

/// Level of an echo with its covariates.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Level {
    /// Level of the echo, dB.
    pub snr_db: f32,
    /// Contribution of its distance to the level, dB.
    pub fade_db: f32,
    /// The scan's strongest echo over 30 dB, tens of dB.
    pub q: f32,
}

/// An echo that is assigned to a point feature.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Hit {
    /// Offset in range, metres.
    pub range_m: f32,
    /// Offset across the line of sight, upwards, metres.
    pub across_m: f32,
    /// Standard deviation of `across_m` from the echo's estimated angle error, metres.
    pub noise_m: f32,
    /// Excess of the lobe's width over a point's.
    pub wide: f32,
    /// Cosine of the angle below the horizontal.
    pub cos: f32,
    /// Height above the lower and above the upper end of the visible part of the riser, metres. Used for hidden
    /// risers.
    pub above_m: [f32; 2],
    /// The overhang in range, metres.
    pub over_m: f32,
}

/// A labelled sample.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Sample {
    /// A point feature that was expected to be visible, with its echo if there is one.
    Feature {
        /// Its class.
        class: Class,
        /// Index of its riser.
        riser: usize,
        /// Predicted level, tens of dB over 30 dB.
        q: f32,
        /// Distance to its neighbour, resolution cells.
        room: f32,
        /// Its echo.
        hit: Option<(Hit, Level)>,
    },
    /// A riser, after its features.
    Riser {
        /// Predicted level at its first feature, tens of dB over 30 dB.
        q: f32,
        /// Whether its foot is hidden.
        hidden: bool,
        /// Level of the riser before, tens of dB over 15 dB.
        before: f32,
        /// Whether none of its features showed an echo.
        nothing: bool,
    },
    /// An echo that is assigned to no point feature.
    Extended {
        /// Its class: face, tread, floor, air, inside, noise.
        class: usize,
        /// Its level.
        level: Level,
        /// Distance from the surface, metres.
        off_m: f32,
        /// Standard deviation of `off_m` from the echo's estimated angle error, metres.
        noise_m: f32,
    },
}

/// Assignment of an echo to a point feature.
#[derive(Clone, Copy)]
struct Claim {
    riser: usize,
    place: FeaturePlace,
    /// Index of the echo and the feature's share of it.
    echo: Option<(usize, f32)>,
}

/// A model that labels echoes.
struct Labeller<'m, 'p>(&'m Model<'p>);

impl<'p> Deref for Labeller<'_, 'p> {
    type Target = Model<'p>;

    fn deref(&self) -> &Model<'p> {
        self.0
    }
}

/// Passes the labels of the echoes and features under `s` to `tell`. Returns the exposures of face, tread and floor:
/// expected numbers of echoes over their rates.
pub fn label(model: &Model<'_>, s: &Staircase, tell: &mut dyn FnMut(Sample)) -> [f32; 3] {
    Labeller(model).label(s, tell)
}

impl Labeller<'_, '_> {
    fn label(&self, s: &Staircase, tell: &mut dyn FnMut(Sample)) -> [f32; 3] {
        let mut claims: Vec<Claim, { number::FEATURES * (MAX_STEPS + 1) }> = Vec::new();
        for k in 0..=s.len() {
            self.claim(s, k, &mut claims);
        }
        let mut owner = [None; MAX_SEEN];
        for (i, claim) in claims.iter().enumerate() {
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
            self.tell_riser(s, k, &claims, &owner, tell);
        }
        let mut exposure = [0.0; number::SURFACES];
        for k in 0..=s.len() {
            for (sum, more) in exposure.iter_mut().zip(self.exposure(s, k)) {
                *sum += more;
            }
        }
        for (e, _) in self.echoes.iter().zip(&owner).filter(|(_, o)| o.is_none()) {
            self.tell_extended(s, e, tell);
        }
        exposure
    }

    /// Whether a share of an echo exceeds that of every class of extended features.
    fn most(&self, s: &Staircase, echo: usize, share: f32) -> bool {
        let Some(e) = self.echoes.get(echo) else {
            return false;
        };
        let parts = self.parts(s, self.tread_of(s, e), e);
        let largest = parts.iter().copied().fold(0.0, math::max);
        share > (1.0 - share) * largest / parts.iter().sum::<f32>()
    }

    /// Returns the index of the riser behind the tread below an echo.
    fn tread_of(&self, s: &Staircase, e: &Seen) -> usize {
        let behind = |k: &usize| e.x_m > s.x(*k) + BEHIND_M;
        (0..s.len()).take_while(behind).count()
    }

    /// Assigns echoes to the features of riser `k`, in the order of the likelihood; each feature gets the echo of
    /// which it has the largest share.
    fn claim(
        &self,
        s: &Staircase,
        k: usize,
        claims: &mut Vec<Claim, { number::FEATURES * (MAX_STEPS + 1) }>,
    ) {
        let x = if k < s.len() { s.x(k) } else { s.wall_m };
        let near = self.between(x - number::RISER_BEFORE_M, x + number::RISER_BEHIND_M);
        let first = self
            .echoes
            .partition_point(|e| e.x_m <= x - number::RISER_BEFORE_M);
        let mut used = [0f32; NEAR];
        for place in self.places(s, k) {
            let Some(p) = self.g.points.get(place.class as usize) else {
                continue;
            };
            let q = self.expected_q(place.range_m);
            let odds = p.seen + p.seen_per_ten_db * q + p.seen_per_room * (place.room - 1.0);
            let seen = logistic(odds).clamp(LEAST_SEEN, MOST_SEEN);
            let mut gains = [0f32; NEAR];
            for ((e, gain), used) in near.iter().zip(&mut gains).zip(&used) {
                let tread = if e.x_m > s.x(k) + BEHIND_M { k + 1 } else { k };
                let b = self.background(s, tread.min(s.len()), e);
                *gain = seen * self.density(s, k, &place, p, e) / b * (1.0 - used);
            }
            let z = 1.0 - seen + gains.iter().sum::<f32>();
            for (used, gain) in used.iter_mut().zip(&gains) {
                *used = math::min(*used + number::MOST_USED * gain / z, number::MOST_USED);
            }
            let shares = gains.iter().enumerate();
            let most = shares.max_by(|a, b| a.1.total_cmp(b.1));
            let _ = claims.push(Claim {
                riser: k,
                place,
                echo: most.map(|(i, gain)| (first + i, gain / z)),
            });
        }
    }

    fn tell_riser(
        &self,
        s: &Staircase,
        k: usize,
        claims: &[Claim],
        owner: &[Option<(usize, f32)>; MAX_SEEN],
        tell: &mut dyn FnMut(Sample),
    ) {
        let (mut riser, mut nothing) = (None, true);
        for (i, claim) in claims.iter().enumerate().filter(|(_, c)| c.riser == k) {
            let echo = claim.echo.map_or(MAX_SEEN, |e| e.0);
            let mine = owner.get(echo).copied().flatten().is_some_and(|o| o.0 == i);
            let e = self.echoes.get(echo).filter(|_| mine);
            let q = self.expected_q(claim.place.range_m);
            tell(Sample::Feature {
                class: claim.place.class,
                riser: k,
                q,
                room: claim.place.room,
                hit: e.map(|e| self.hit(s, k, &claim.place, e)),
            });
            nothing &= e.is_none();
            riser = riser.or(Some((q, claim.place.class == Class::Hidden)));
        }
        if let Some((q, hidden)) = riser {
            tell(Sample::Riser {
                q,
                hidden,
                before: before(self.shown(s, k)),
                nothing,
            });
        }
    }

    fn hit(&self, s: &Staircase, k: usize, place: &FeaturePlace, e: &Seen) -> (Hit, Level) {
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
            fade_db: number::TEN_DB * (self.expected_q(e.range_m) - self.q),
            q: self.q,
        };
        (hit, level)
    }

    fn tell_extended(&self, s: &Staircase, e: &Seen, tell: &mut dyn FnMut(Sample)) {
        let k = self.tread_of(s, e);
        let parts = self.parts(s, k, e);
        let largest = parts.iter().enumerate().max_by(|a, b| a.1.total_cmp(b.1));
        let class = largest.map_or(EXTENDED - 1, |(class, _)| class);
        let up = e.across_m * e.x_m / math::max(e.range_m, number::LEAST_RANGE_M);
        let along =
            e.across_m * (self.height_m - e.y_m) / math::max(e.range_m, number::LEAST_RANGE_M);
        let mut level = Level {
            snr_db: e.snr_db,
            fade_db: 0.0,
            q: self.q,
        };
        let (off_m, noise_m) = match class {
            0 => {
                let faces = [k.checked_sub(1), Some(k).filter(|k| *k < s.len())];
                let off = |k: usize| e.x_m - s.x(k) + number::FACE_BEFORE * s.overhang_m;
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
                level.fade_db = -number::FLOOR_FALL_DB
                    * math::max(e.x_m - number::FLOOR_M, -number::FLOOR_NEARER_M);
                let level = if k == 0 { self.base(s, 0, e.x_m) } else { 0.0 };
                (e.y_m - level, up)
            }
            _ => (0.0, 0.0),
        };
        tell(Sample::Extended {
            class,
            level,
            off_m,
            noise_m,
        });
    }
}
