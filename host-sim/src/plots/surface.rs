//! Line of a staircase's surface from its edges, in metres and in pixels.

use super::page::Frame;
use super::sheet::Spot;
use crate::views::Point;

/// Returns the surface as a line of points, metres: from x = `near` at ground level over `edges` (distance, and
/// height of the tread that begins there) to x = `far`.
pub fn surface(near: f64, far: f64, edges: &[Point]) -> Vec<Point> {
    let mut level = 0.0;
    let mut line = vec![(near, level)];
    for &(x, height) in edges {
        line.push((x, level));
        line.push((x, height));
        level = height;
    }
    let end = line.last().map_or(far, |last| far.max(last.0));
    line.push((end, level));
    line
}

/// Returns the line of the surface over `edges` (distance and height, metres) in pixels.
pub fn surface_to_draw(frame: &Frame, edges: &[Point]) -> Vec<Spot> {
    let [line, _] = surface_up_to(frame, edges, f64::INFINITY);
    line
}

/// Returns the line of the surface over `edges` (distance and height, metres) in two pieces, pixels: up to the distance
/// `x`, metres, and beyond.
pub fn surface_up_to(frame: &Frame, edges: &[Point], x: f64) -> [Vec<Spot>; 2] {
    let line = surface(frame.x.0 - 1.0, beyond(edges), edges);
    parted(&line, x).map(|part| part.iter().map(|p| frame.spot(p.0, p.1)).collect())
}

/// Splits a surface's line into the points up to the distance `x`, metres, and the others; a point at `x` ends the
/// first and begins the second.
pub fn parted(line: &[Point], x: f64) -> [Vec<Point>; 2] {
    let count = line.iter().take_while(|p| p.0 <= x).count();
    let (near, far) = line.split_at(count);
    let [mut near, mut rest] = [near.to_vec(), Vec::new()];
    // The line is level at the split, because it rises and falls at edges only.
    if let (Some(last), false) = (near.last().copied(), far.is_empty()) {
        near.push((x, last.1));
        rest.push((x, last.1));
    }
    rest.extend_from_slice(far);
    [near, rest]
}

/// Returns the distance at which the drawn last tread ends, metres. It is as deep as the tread before it, within 15
/// to 50 cm; 30 cm for a single step.
fn beyond(edges: &[Point]) -> f64 {
    let tread = edges.windows(2).last().map_or(0.3, |w| w[1].0 - w[0].0);
    edges.last().map_or(0.0, |e| e.0 + tread.clamp(0.15, 0.5))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_surface_is_parted_at_the_horizon() {
        let line = surface(0.0, 2.0, &[(0.5, 0.2), (1.0, 0.4)]);
        let [near, far] = parted(&line, 0.8);
        assert_eq!(near, [(0.0, 0.0), (0.5, 0.0), (0.5, 0.2), (0.8, 0.2)]);
        assert_eq!(far, [(0.8, 0.2), (1.0, 0.2), (1.0, 0.4), (2.0, 0.4)]);
        assert_eq!(parted(&line, f64::INFINITY), [line.clone(), Vec::new()]);
        let [near, far] = parted(&line, -1.0);
        assert!(near.is_empty() && far == line);
    }
}
