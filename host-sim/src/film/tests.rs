use super::*;
use crate::answer::metres;
use crate::recording::Recording;
use crate::replay::{self, Options};
use stairscan::report::{DropLine, Tenths};
use std::path::Path;

fn film(name: &str) -> (Film, String) {
    let dir = Path::new(env!("CARGO_MANIFEST_DIR")).join("../recordings");
    let recording = Recording::read(&dir.join(name)).unwrap();
    let mut film = Film::new(&recording);
    let options = Options {
        scans: Some(2),
        ..Options::default()
    };
    replay::answers(&recording, &options, |scanned| {
        film.take(&recording, scanned)
    })
    .unwrap();
    let svg = film.svg();
    (film, svg)
}

/// Returns the elements with the tag `tag` of the document, each up to its end.
fn elements<'s>(svg: &'s str, tag: &str) -> Vec<&'s str> {
    let open = format!("<{tag} ");
    svg.match_indices(&open)
        .map(|(at, _)| svg[at..].split_inclusive('>').next().unwrap())
        .collect()
}

#[test]
fn each_scan_is_reported_with_its_steps() {
    let (film, svg) = film("stair_a");
    assert_eq!(film.shots.len(), 2);
    for shot in &film.shots {
        assert_eq!(shot.answer.steps.len(), 3);
        assert!(shot.echoes.len() >= 6, "{}", shot.echoes.len());
        let label = format!("1:  {:.1} ±", 100.0 * metres(shot.answer.steps[0].distance));
        assert!(svg.contains(&label), "{label}");
    }
    assert!(svg.contains("ok: 3 steps up"));
    assert!(svg.contains("valid up to 1."));
    // As in the recording's angles.
    assert_eq!(film.shots[0].sweep_deg, (-20.0, 50.0));
    let (down, _) = self::film("descending");
    assert_eq!(down.shots[0].sweep_deg, (110.0, 40.0));
}

#[test]
fn where_the_ground_ends_is_drawn() {
    let (mut film, svg) = film("stair_a");
    assert!(!svg.contains("the ground ends"));
    film.shots[0].answer.drop = Some(DropLine {
        distance: Tenths(15_000),
        distance_sigma: Tenths(200),
        ..DropLine::default()
    });
    assert_eq!(film.svg().matches("the ground ends").count(), 1);
}

#[test]
fn times_ascend_from_nought_to_one() {
    for name in ["stair_a", "empty", "descending"] {
        let (_, svg) = film(name);
        let moving = ["animate", "animateTransform"].map(|tag| elements(&svg, tag));
        assert!(moving.iter().all(|kind| !kind.is_empty()));
        for element in moving.concat() {
            let list = |key: &str| {
                let from = element.find(&format!("{key}=\"")).unwrap() + key.len() + 2;
                element[from..]
                    .split('"')
                    .next()
                    .unwrap()
                    .split(';')
                    .count()
            };
            assert_eq!(list("keyTimes"), list("values"), "{element}");
            let from = element.find("keyTimes=\"").unwrap() + 10;
            let times: Vec<f64> = (element[from..].split('"').next().unwrap())
                .split(';')
                .map(|t| t.parse().unwrap())
                .collect();
            assert_eq!((times[0], times[times.len() - 1]), (0.0, 1.0), "{element}");
            assert!(times.windows(2).all(|t| t[0] <= t[1]), "{element}");
        }
        let mut words = svg.split(|c: char| !c.is_alphanumeric());
        assert!(words.all(|word| word != "NaN" && word != "inf"), "{name}");
    }
}
