//! What the measurement model takes each echo for under a staircase: what its numbers are counted
//! from.
//!
//! An echo belongs to the point feature that claims most of it, if that is more than the part of any
//! class of extended features; else to the class of these with the largest density. The shares are those of [`Model::riser`].

use std::ops::Deref;

use heapless::Vec;
use stairscan::math;
use stairscan::model::{
    BEHIND_M, Class, FeaturePlace, MAX_MODEL_ECHOES, MAX_P_DETECTED, MAX_STEPS, MIN_P_DETECTED,
    Model, ModelEcho, NEAR, Staircase, excess_level, logistic,
};
use stairscan::params::generative::EXTENDED;
use stairscan::params::posterior as number;

/// A level against what it is expected to depend on.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Level {
    /// Of the echo, dB.
    pub snr_db: f32,
    /// What its distance adds to it, dB.
    pub fade_db: f32,
    /// The scan's strongest echo over 30 dB, tens of dB.
    pub q: f32,
}

/// An echo that a point feature has claimed.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Hit {
    /// Offset in range, metres.
    pub range_m: f32,
    /// Offset across the line of sight, upwards, metres.
    pub across_m: f32,
    /// Standard deviation of the latter by the echo's own account, metres.
    pub noise_m: f32,
    /// Width of the lobe above a point's.
    pub wide: f32,
    /// Cosine of the angle below the horizontal.
    pub cos: f32,
    /// Height above the lower and above the upper end of what can be seen of the riser, metres: for
    /// hidden ones.
    pub above_m: [f32; 2],
    /// The overhang in range, metres.
    pub over_m: f32,
}

/// What there is to count.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Sample {
    /// A point feature that could have been seen, and what it showed.
    Feature {
        /// Its class.
        class: Class,
        /// Of which riser.
        riser: usize,
        /// Predicted level, tens of dB over 30 dB.
        q: f32,
        /// Resolution cells to its neighbour.
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
    /// An echo that no point feature has claimed.
    Extended {
        /// Its class: face, tread, floor, air, inside, noise.
        class: usize,
        /// Its level.
        level: Level,
        /// How far off the surface it lies, metres, …
        off_m: f32,
        /// … and the standard deviation of that by the echo's own account.
        noise_m: f32,
    },
}

/// A point feature's claim to an echo.
#[derive(Clone, Copy)]
struct Claim {
    riser: usize,
    place: FeaturePlace,
    /// Number of the echo and the share that it claims.
    echo: Option<(usize, f32)>,
}

/// The model as what labels echoes.
struct Labeller<'m, 'p>(&'m Model<'p>);

impl<'p> Deref for Labeller<'_, 'p> {
    type Target = Model<'p>;

    fn deref(&self) -> &Model<'p> {
        self.0
    }
}

/// Tells what the echoes and features of `s` are taken for; returns the expected number of
/// echoes on faces, treads and floor over their rates.
pub fn label(model: &Model<'_>, s: &Staircase, tell: &mut dyn FnMut(Sample)) -> [f32; 3] {
    Labeller(model).label(s, tell)
}

impl Labeller<'_, '_> {
    fn label(&self, s: &Staircase, tell: &mut dyn FnMut(Sample)) -> [f32; 3] {
        let mut claims: Vec<Claim, { number::FEATURES * (MAX_STEPS + 1) }> = Vec::new();
        for k in 0..=s.len() {
            self.claim(s, k, &mut claims);
        }
        let mut owner = [None; MAX_MODEL_ECHOES];
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

    /// Whether a share of an echo is larger than that of every class of extended features.
    fn most(&self, s: &Staircase, echo: usize, share: f32) -> bool {
        let Some(e) = self.echoes.get(echo) else {
            return false;
        };
        let parts = self.parts(s, self.tread_of(s, e), e);
        let largest = parts.iter().copied().fold(0.0, math::max);
        share > (1.0 - share) * largest / parts.iter().sum::<f32>()
    }

    /// Number of the riser behind the tread that an echo lies over.
    fn tread_of(&self, s: &Staircase, e: &ModelEcho) -> usize {
        let behind = |k: &usize| e.x_m > s.x(*k) + BEHIND_M;
        (0..s.len()).take_while(behind).count()
    }

    /// Riser `k`'s features, one after the other as in the likelihood, each with the echo that it
    /// claims most of.
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
            let odds =
                p.seen + p.seen_per_ten_db * q + p.seen_per_room * (place.separation_cells - 1.0);
            let seen = logistic(odds).clamp(MIN_P_DETECTED, MAX_P_DETECTED);
            let mut gains = [0f32; NEAR];
            for ((e, gain), used) in near.iter().zip(&mut gains).zip(&used) {
                let tread = if e.x_m > s.x(k) + BEHIND_M { k + 1 } else { k };
                let b = self.background(s, tread.min(s.len()), e);
                *gain = seen * self.density(s, k, &place, p, e) / b * (1.0 - used);
            }
            let z = 1.0 - seen + gains.iter().sum::<f32>();
            for (used, gain) in used.iter_mut().zip(&gains) {
                *used = math::min(
                    *used + number::MAX_USED_SHARE * gain / z,
                    number::MAX_USED_SHARE,
                );
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
        owner: &[Option<(usize, f32)>; MAX_MODEL_ECHOES],
        tell: &mut dyn FnMut(Sample),
    ) {
        let (mut riser, mut nothing) = (None, true);
        for (i, claim) in claims.iter().enumerate().filter(|(_, c)| c.riser == k) {
            let echo = claim.echo.map_or(MAX_MODEL_ECHOES, |e| e.0);
            let mine = owner.get(echo).copied().flatten().is_some_and(|o| o.0 == i);
            let e = self.echoes.get(echo).filter(|_| mine);
            let q = self.expected_q(claim.place.range_m);
            tell(Sample::Feature {
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
            tell(Sample::Riser {
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
            fade_db: number::TEN_DB * (self.expected_q(e.range_m) - self.q),
            q: self.q,
        };
        (hit, level)
    }

    fn tell_extended(&self, s: &Staircase, e: &ModelEcho, tell: &mut dyn FnMut(Sample)) {
        let k = self.tread_of(s, e);
        let parts = self.parts(s, k, e);
        let largest = parts.iter().enumerate().max_by(|a, b| a.1.total_cmp(b.1));
        let class = largest.map_or(EXTENDED - 1, |(class, _)| class);
        let up = e.across_m * e.x_m / math::max(e.range_m, number::MIN_RANGE_M);
        let along =
            e.across_m * (self.height_m - e.y_m) / math::max(e.range_m, number::MIN_RANGE_M);
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
                // What is nearer to the wall behind is no face of a riser.
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
