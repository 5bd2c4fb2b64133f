//! Reliability of reported probabilities: in each bin of probability, the mean that was reported is
//! compared with the share that came true.

use serde_json::{Value, json};

use super::share::Share;

/// Edges of the bins of an answer's confidence, 0…1. The bins are narrow near the threshold of
/// `ok`.
const CONFIDENCE: &[f64] = &[0.0, 0.5, 0.8, 0.9, 0.95, 0.97, 0.98, 0.99, 1.0];
/// Edges of the bins of the probability, 0…1, of a `MAYBE` (a possible step), which is reported
/// from 5 % on.
const MAYBES: &[f64] = &[0.0, 0.1, 0.2, 0.5, 0.8, 1.0];
/// Minimum number of predictions in a bin for a comparison with their outcomes.
const MIN_PREDICTIONS: usize = 30;
/// Difference between mean probability and share of true outcomes up to which they agree, 0…1.
const AGREES: f64 = 0.05;
/// Difference between mean probability and share of true outcomes up to which they agree, standard
/// errors; the larger of this limit and [`AGREES`] applies.
const AGREES_ERRORS: f64 = 2.0;

/// A reported probability with its outcome.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Prediction {
    /// Reported probability, 0…1.
    pub predicted: f64,
    /// Whether the predicted event was true.
    pub outcome: bool,
}

/// Predictions whose probabilities fall into one interval.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Bin {
    /// Lower edge of the interval of probability, 0…1.
    pub from: f64,
    /// Upper edge of the interval of probability, 0…1.
    pub to: f64,
    /// Share of predictions whose event was true.
    pub actual: Share,
    /// Sum of the reported probabilities of all predictions.
    sum: f64,
    /// Variance of the number of true events if the probabilities are calibrated: the sum of p (1 −
    /// p).
    variance: f64,
}

impl Bin {
    fn new<'a>(from: f64, to: f64, predictions: impl Iterator<Item = &'a Prediction>) -> Self {
        let mut bin = Self {
            from,
            to,
            actual: Share::default(),
            sum: 0.0,
            variance: 0.0,
        };
        for prediction in predictions {
            bin.actual.of += 1;
            bin.actual.hits += usize::from(prediction.outcome);
            bin.sum += prediction.predicted;
            bin.variance += prediction.predicted * (1.0 - prediction.predicted);
        }
        bin
    }

    /// Returns the mean of the reported probabilities, 0…1; `None` without predictions.
    pub fn predicted(&self) -> Option<f64> {
        let count = self.actual.of as f64;
        (self.actual.of > 0).then(|| self.sum / count)
    }

    /// Returns the standard error of the share that came true, assuming calibrated and independent
    /// predictions; `None` without predictions. It does not vanish when all predictions of a bin
    /// came true, unlike the standard error from the actual share.
    pub fn standard_error(&self) -> Option<f64> {
        let count = self.actual.of as f64;
        (self.actual.of > 0).then(|| self.variance.sqrt() / count)
    }

    /// Whether the mean probability and the share that came true differ by at most 5 points or
    /// twice the standard error; `None` with fewer than 30 predictions.
    pub fn agrees(&self) -> Option<bool> {
        let is_compared = self.actual.of >= MIN_PREDICTIONS;
        let apart = (self.predicted()? - self.actual.value()?).abs();
        let most = AGREES.max(AGREES_ERRORS * self.standard_error()?);
        is_compared.then_some(apart <= most)
    }

    /// Returns the bin's interval, shares and standard error as JSON, probabilities 0…1.
    fn json(&self) -> Value {
        json!({
            "from": self.from,
            "to": self.to,
            "actual": self.actual.json(),
            "actual_mean": self.actual.value(),
            "predicted_mean": self.predicted(),
            "standard_error": self.standard_error(),
            "agrees": self.agrees(),
        })
    }
}

/// Reliability of one kind of reported probability, by bins and overall.
#[derive(Clone, Debug, PartialEq)]
pub struct Reliability {
    /// The bins in ascending order of probability.
    pub bins: Vec<Bin>,
    /// One bin that holds all predictions.
    pub all: Bin,
}

impl Reliability {
    /// Compares the answers' confidence with their outcomes, in bins of confidence.
    pub fn of_confidence<'a>(predictions: impl Iterator<Item = &'a Prediction> + Clone) -> Self {
        Self::by(CONFIDENCE, predictions)
    }

    /// Compares the probabilities of `MAYBE`s with their outcomes, in bins of probability.
    pub fn of_maybes<'a>(predictions: impl Iterator<Item = &'a Prediction> + Clone) -> Self {
        Self::by(MAYBES, predictions)
    }

    fn by<'a>(edges: &[f64], predictions: impl Iterator<Item = &'a Prediction> + Clone) -> Self {
        let last = edges.len().saturating_sub(2);
        let bin = |(k, pair): (usize, &[f64])| {
            let (from, to) = (pair[0], pair[1]);
            // A probability of 1 belongs to the last bin.
            let inside =
                move |p: &&Prediction| p.predicted >= from && (p.predicted < to || k == last);
            Bin::new(from, to, predictions.clone().filter(inside))
        };
        let ends = (edges.first(), edges.last());
        let (from, to) = (ends.0.copied(), ends.1.copied());
        Self {
            bins: edges.windows(2).enumerate().map(bin).collect(),
            all: Bin::new(from.unwrap_or(0.0), to.unwrap_or(1.0), predictions.clone()),
        }
    }

    /// Returns all bins, and the bin of all predictions, as JSON; probabilities 0…1.
    pub fn json(&self) -> Value {
        json!({
            "all": self.all.json(),
            "bins": self.bins.iter().map(Bin::json).collect::<Vec<_>>(),
        })
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Returns `of` predictions of probability `predicted`, of which the events of `right` are
    /// true.
    fn predictions(predicted: f64, right: usize, of: usize) -> Vec<Prediction> {
        (0..of)
            .map(|k| Prediction {
                predicted,
                outcome: k < right,
            })
            .collect()
    }

    fn confidence(lists: &[Vec<Prediction>]) -> Reliability {
        Reliability::of_confidence(lists.concat().iter())
    }

    #[test]
    fn predictions_fall_into_their_bins() {
        let lists = [
            predictions(0.0, 0, 1),
            predictions(0.499, 1, 2),
            predictions(0.5, 1, 3),
            predictions(0.949, 3, 4),
            predictions(0.95, 5, 5),
            predictions(0.99, 5, 6),
            predictions(1.0, 7, 7),
        ];
        let reliability = confidence(&lists);
        let counts: Vec<Share> = reliability.bins.iter().map(|b| b.actual).collect();
        let expected = [
            (1, 3),
            (1, 3),
            (0, 0),
            (3, 4),
            (5, 5),
            (0, 0),
            (0, 0),
            (12, 13),
        ];
        assert_eq!(counts, expected.map(|(hits, of)| Share::new(hits, of)));
        assert_eq!(reliability.all.actual, Share::new(22, 28));
        let last = &reliability.bins[7];
        assert_eq!((last.from, last.to), (0.99, 1.0));
        let mean = (6.0 * 0.99 + 7.0) / 13.0;
        assert!((last.predicted().unwrap() - mean).abs() < 1e-12);
    }

    /// Calculated by hand: 100 predictions of 60 % have a standard error of √(0.6·0.4/100) = 4.9 points.
    /// 70 true ones are 2.04 standard errors off, 69 are 1.84.
    #[test]
    fn agreement_is_within_two_standard_errors() {
        for (right, agrees) in [(60, true), (69, true), (70, false), (51, true), (50, false)] {
            let reliability = confidence(&[predictions(0.6, right, 100)]);
            let bin = &reliability.bins[1];
            assert!((bin.standard_error().unwrap() - 0.048_989_8).abs() < 1e-6);
            assert_eq!(bin.agrees(), Some(agrees), "{right}");
        }
    }

    /// Many predictions: 5 points exceed two standard errors of 0.22 points.
    #[test]
    fn agreement_is_within_five_points() {
        for (right, agrees) in [(1000, true), (941, true), (939, false)] {
            let reliability = confidence(&[predictions(0.99, right, 1000)]);
            assert_eq!(reliability.bins[7].agrees(), Some(agrees), "{right}");
        }
    }

    #[test]
    fn few_predictions_are_reported_and_not_judged() {
        let reliability = confidence(&[predictions(0.99, 0, 29), predictions(0.6, 0, 30)]);
        assert_eq!(reliability.bins[7].agrees(), None);
        assert_eq!(reliability.bins[7].actual, Share::new(0, 29));
        assert_eq!(reliability.bins[1].agrees(), Some(false));
        let empty = &reliability.bins[0];
        assert_eq!((empty.predicted(), empty.standard_error()), (None, None));
        assert!(reliability.json()["bins"][0]["predicted_mean"].is_null());
    }
}
