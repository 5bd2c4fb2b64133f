//! Coordinate frames of ROS 2: the chair, the mirror's centre, and the ground below it, to which all coordinates
//! refer.

use crate::convert::messages::header;
use crate::convert::ros::{Point, Pose, TfMessage, TransformStamped};

/// Mounting of the scanner, with the names of the frames.
#[derive(Clone, Debug, PartialEq)]
pub struct Frames {
    /// Frame of the coordinates.
    pub frame: String,
    /// Frame of the chair, whose origin lies on the ground.
    pub base: String,
    /// Mirror's centre in the chair's frame: forward, left, up, metres.
    pub mount: [f64; 3],
}

impl Frames {
    /// Returns both transforms: of the mirror in the chair's frame, and of the ground below the mirror.
    pub fn message(&self, stamp_ns: u64) -> TfMessage {
        let [x, y, z] = self.mount;
        let mirror = format!("{}_mirror", self.frame);
        let transform = |parent: &str, child: &str, place| TransformStamped {
            header: header(stamp_ns, parent),
            child_frame_id: child.to_owned(),
            transform: Pose::at(place),
        };
        TfMessage {
            transforms: vec![
                transform(&self.base, &mirror, Point { x, y, z }),
                transform(
                    &mirror,
                    &self.frame,
                    Point {
                        z: -z,
                        ..Point::default()
                    },
                ),
            ],
        }
    }
}
