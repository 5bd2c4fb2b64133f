//! Coordinate frames of ROS 2: the chair, the mirror's centre, and the ground below it, to which all coordinates
//! refer.

use crate::convert::messages::header;
use crate::convert::ros::{Point, Pose, TfMessage, TransformStamped};

/// Place of the mirror in the chair, and the names of the coordinate frames.
#[derive(Clone, Debug, PartialEq)]
pub struct Frames {
    /// Name of the frame in which all coordinates are given: its origin is on the ground below the
    /// mirror.
    pub frame: String,
    /// Name of the chair's frame, whose origin lies on the ground.
    pub base: String,
    /// Mirror's centre in the chair's frame: forward, left, up, metres.
    pub mount: [f64; 3],
}

impl Frames {
    /// Returns the message with both transforms: of the mirror in the chair's frame, and of the
    /// ground below the mirror in the mirror's frame. `stamp_ns` is the time, nanoseconds since
    /// 1970.
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
