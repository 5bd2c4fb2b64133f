//! The measurement model on the echoes of a known staircase.

use super::*;

#[test]
fn an_echo_is_not_counted_twice() {
    // A face that ends 3 cm above the mirror: its flash and its edge are expected at the same place.
    let geometry = geometry();
    let s = flight(&[(0.8, 0.2), (1.1, 0.43)]);
    let at = echo(1.1, 0.402, 38.0);
    let gain = |echoes: &[Echo]| model(echoes, &geometry).riser(&s, 1);
    let (one, two) = (gain(&[at]), gain(&[at, at]));
    // If one echo counted as both features, a second one would add at most the doubled density of each.
    let doubled = 2.0 * core::f32::consts::LN_2;
    assert!(one > 0.0 && two > one + 1.2 * doubled, "{one} {two}");
}

#[test]
fn riser_without_echoes_has_a_negative_log_likelihood_ratio() {
    let geometry = geometry();
    let s = regular(2, 0.7, 0.3, 0.16);
    let all = echoes(&s, &mut Dice::new(5), 0.0);
    let near: Vec<Echo> = all.iter().filter(|e| e.x_m < 0.85).copied().collect();
    let model = model(&near, &geometry);
    // With an echo the riser gains; without one it loses, within reasonable limits.
    assert!(model.riser(&s, 0) > 5.0, "{}", model.riser(&s, 0));
    let silent = model.riser(&s, 1);
    assert!((-12.0..-1.0).contains(&silent), "{silent}");
}

#[test]
fn beyond_a_brink_no_floor_is_expected() {
    let geometry = geometry();
    let near: Vec<Echo> = (0..6)
        .map(|k| echo(0.4 + 0.06 * k as f32, 0.0, 18.0))
        .collect();
    let brink = Staircase::drop(0.8);
    let mut far = near.clone();
    far.extend((0..6).map(|k| echo(0.9 + 0.06 * k as f32, 0.0, 18.0)));
    let odds = |echoes: &[Echo]| {
        let model = model(echoes, &geometry);
        model.log_likelihood(&brink) - model.log_likelihood(&Staircase::nothing())
    };
    assert!(
        odds(&near) > 0.0 && odds(&far) < -5.0,
        "{} {}",
        odds(&near),
        odds(&far)
    );
}
