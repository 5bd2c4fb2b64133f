//! Messages of ROS 2 (common_interfaces as of Humble): their definitions and their encoding.
//!
//! The order of a structure's fields is their order in the encoding, so each structure stands
//! beside its definition.

use anyhow::{Context, Result};
use byteorder::LittleEndian;
use serde::Serialize;

/// Header of every encoded message: CDR, little-endian, no options.
pub const ENCAPSULATION: [u8; 4] = [0, 1, 0, 0];
/// Separator between a message's definition and those of the types it depends on, as written by rosbag2.
const RULE: &str =
    "================================================================================";

/// A ROS 2 message with its type's name and its definition.
pub trait Message: Serialize {
    /// Name of the type: package, `msg` and type.
    const NAME: &'static str;
    /// Definition of the message's own fields, in ROS 2's text form.
    const FIELDS: &'static str;
    /// Names of the types that the message depends on, with their definitions.
    const PARTS: &'static [(&'static str, &'static str)];
}

/// Returns the definition of a message with all types it depends on.
pub fn definition<M: Message>() -> String {
    let mut text = M::FIELDS.to_owned();
    for (name, fields) in M::PARTS {
        text.push_str(&format!("{RULE}\nMSG: {name}\n{fields}"));
    }
    text
}

/// Encodes a message in CDR.
///
/// # Errors
/// None: encoding these messages does not fail.
pub fn encoded<M: Message>(message: &M) -> Result<Vec<u8>> {
    let body = cdr_encoding::to_vec::<M, LittleEndian>(message);
    let mut bytes = ENCAPSULATION.to_vec();
    bytes.extend(body.with_context(|| format!("a message {}", M::NAME))?);
    Ok(bytes)
}

/// Name and definition of ROS 2's type of a time stamp.
pub const TIME: (&str, &str) = ("builtin_interfaces/Time", "int32 sec\nuint32 nanosec\n");
const DURATION: (&str, &str) = ("builtin_interfaces/Duration", "int32 sec\nuint32 nanosec\n");
/// Name and definition of ROS 2's type of a message header.
pub const HEADER: (&str, &str) = (
    "std_msgs/Header",
    "builtin_interfaces/Time stamp\nstring frame_id\n",
);
/// Name and definition of ROS 2's type of a point.
pub const POINT: (&str, &str) = ("geometry_msgs/Point", "float64 x\nfloat64 y\nfloat64 z\n");

const VECTOR: (&str, &str) = ("geometry_msgs/Vector3", "float64 x\nfloat64 y\nfloat64 z\n");
const QUATERNION: (&str, &str) = (
    "geometry_msgs/Quaternion",
    "float64 x 0\nfloat64 y 0\nfloat64 z 0\nfloat64 w 1\n",
);

/// ROS 2's time or duration: seconds and nanoseconds.
#[derive(Clone, Copy, Debug, Default, Serialize)]
pub struct Time {
    sec: i32,
    nanosec: u32,
}

impl Time {
    /// Creates a time from nanoseconds since 1970. Its seconds end at 2³¹ - 1, in 2038.
    pub fn from_nanos(ns: u64) -> Self {
        Self {
            sec: i32::try_from(ns / 1_000_000_000).unwrap_or(i32::MAX),
            nanosec: (ns % 1_000_000_000) as u32,
        }
    }
}

/// Header of a message: time and frame.
#[derive(Clone, Debug, Serialize)]
pub struct Header {
    /// Time of the measurement.
    pub stamp: Time,
    /// Name of the frame of the message's coordinates.
    pub frame_id: String,
}

/// Description of one field of the points of a cloud.
#[derive(Clone, Debug, Serialize)]
pub struct PointField {
    /// Name of the field.
    pub name: String,
    /// Offset of the field within a point, bytes.
    pub offset: u32,
    /// Type of the field's values; 7: 32-bit floating point.
    pub datatype: u8,
    /// Number of values of the field in a point.
    pub count: u32,
}

/// ROS 2's point cloud, `sensor_msgs/msg/PointCloud2`.
#[derive(Clone, Debug, Serialize)]
pub struct PointCloud2 {
    pub header: Header,
    pub height: u32,
    pub width: u32,
    pub fields: Vec<PointField>,
    pub is_bigendian: bool,
    pub point_step: u32,
    pub row_step: u32,
    pub data: Vec<u8>,
    pub is_dense: bool,
}

impl Message for PointCloud2 {
    const NAME: &'static str = "sensor_msgs/msg/PointCloud2";
    const FIELDS: &'static str = "std_msgs/Header header\nuint32 height\nuint32 width\n\
        sensor_msgs/PointField[] fields\nbool is_bigendian\nuint32 point_step\nuint32 row_step\n\
        uint8[] data\nbool is_dense\n";
    const PARTS: &'static [(&'static str, &'static str)] = &[
        HEADER,
        TIME,
        (
            "sensor_msgs/PointField",
            "uint8 INT8=1\nuint8 UINT8=2\nuint8 INT16=3\nuint8 UINT16=4\nuint8 INT32=5\nuint8 UINT32=6\n\
             uint8 FLOAT32=7\nuint8 FLOAT64=8\nstring name\nuint32 offset\nuint8 datatype\nuint32 count\n",
        ),
    ];
}

/// ROS 2's uncompressed picture, `sensor_msgs/msg/Image`.
#[derive(Clone, Debug, Serialize)]
pub struct Image {
    pub header: Header,
    pub height: u32,
    pub width: u32,
    pub encoding: String,
    pub is_bigendian: u8,
    pub step: u32,
    pub data: Vec<u8>,
}

impl Message for Image {
    const NAME: &'static str = "sensor_msgs/msg/Image";
    const FIELDS: &'static str = "std_msgs/Header header\nuint32 height\nuint32 width\n\
        string encoding\nuint8 is_bigendian\nuint32 step\nuint8[] data\n";
    const PARTS: &'static [(&'static str, &'static str)] = &[HEADER, TIME];
}

/// A point or a vector; as a point in metres.
#[derive(Clone, Copy, Debug, Default, Serialize)]
pub struct Point {
    pub x: f64,
    pub y: f64,
    pub z: f64,
}

/// A rotation as a quaternion.
#[derive(Clone, Copy, Debug, Serialize)]
pub struct Quaternion {
    pub x: f64,
    pub y: f64,
    pub z: f64,
    pub w: f64,
}

/// Position and rotation, such as the origin of a marker's coordinates.
#[derive(Clone, Copy, Debug, Serialize)]
pub struct Pose {
    pub position: Point,
    pub orientation: Quaternion,
}

impl Pose {
    /// Creates a pose without rotation.
    pub fn at(position: Point) -> Self {
        let orientation = Quaternion {
            x: 0.0,
            y: 0.0,
            z: 0.0,
            w: 1.0,
        };
        Self {
            position,
            orientation,
        }
    }
}

/// Red, green and blue, and opacity, 0 to 1 each.
#[derive(Clone, Copy, Debug, Default, Serialize)]
pub struct Colour {
    pub r: f32,
    pub g: f32,
    pub b: f32,
    pub a: f32,
}

/// Texture of a marker, always empty here.
#[derive(Clone, Debug, Serialize)]
pub struct CompressedImage {
    pub header: Header,
    pub format: String,
    pub data: Vec<u8>,
}

/// Mesh of a marker, always empty here.
#[derive(Clone, Debug, Default, Serialize)]
pub struct MeshFile {
    pub filename: String,
    pub data: Vec<u8>,
}

/// ROS 2's object to display, `visualization_msgs/msg/Marker`.
#[derive(Clone, Debug, Serialize)]
pub struct Marker {
    pub header: Header,
    pub ns: String,
    pub id: i32,
    pub kind: i32,
    pub action: i32,
    pub pose: Pose,
    pub scale: Point,
    pub color: Colour,
    pub lifetime: Time,
    pub frame_locked: bool,
    pub points: Vec<Point>,
    pub colors: Vec<Colour>,
    pub texture_resource: String,
    pub texture: CompressedImage,
    pub uv_coordinates: Vec<(f32, f32)>,
    pub text: String,
    pub mesh_resource: String,
    pub mesh_file: MeshFile,
    pub mesh_use_embedded_materials: bool,
}

impl Marker {
    /// Kind of marker: lines between each two points (first and second, third and fourth, …).
    pub const LINE_LIST: i32 = 5;
    /// Kind of marker: a sphere.
    pub const SPHERE: i32 = 2;
    /// Kind of marker: text that faces the viewer.
    pub const TEXT: i32 = 9;
    /// Action: shows the marker until another one with its name and number replaces it.
    pub const ADD: i32 = 0;
    /// Action: deletes all markers shown so far.
    pub const DELETE_ALL: i32 = 3;

    /// Creates an empty marker of this kind; `ns` and `id` identify it.
    pub fn new(header: &Header, ns: &str, id: usize, kind: i32) -> Self {
        let nowhere = Header {
            stamp: Time::default(),
            frame_id: String::new(),
        };
        Self {
            header: header.clone(),
            ns: ns.to_owned(),
            id: id as i32,
            kind,
            action: Self::ADD,
            pose: Pose::at(Point::default()),
            scale: Point::default(),
            color: Colour::default(),
            lifetime: Time::default(),
            frame_locked: false,
            points: Vec::new(),
            colors: Vec::new(),
            texture_resource: String::new(),
            texture: CompressedImage {
                header: nowhere,
                format: String::new(),
                data: Vec::new(),
            },
            uv_coordinates: Vec::new(),
            text: String::new(),
            mesh_resource: String::new(),
            mesh_file: MeshFile::default(),
            mesh_use_embedded_materials: false,
        }
    }
}

/// ROS 2's list of objects to display, `visualization_msgs/msg/MarkerArray`.
#[derive(Clone, Debug, Serialize)]
pub struct MarkerArray {
    pub markers: Vec<Marker>,
}

impl Message for MarkerArray {
    const NAME: &'static str = "visualization_msgs/msg/MarkerArray";
    const FIELDS: &'static str = "visualization_msgs/Marker[] markers\n";
    const PARTS: &'static [(&'static str, &'static str)] = &[
        (
            "visualization_msgs/Marker",
            "int32 ARROW=0\nint32 CUBE=1\nint32 SPHERE=2\nint32 CYLINDER=3\nint32 LINE_STRIP=4\n\
             int32 LINE_LIST=5\nint32 CUBE_LIST=6\nint32 SPHERE_LIST=7\nint32 POINTS=8\n\
             int32 TEXT_VIEW_FACING=9\nint32 MESH_RESOURCE=10\nint32 TRIANGLE_LIST=11\nint32 ARROW_STRIP=12\n\
             int32 ADD=0\nint32 MODIFY=0\nint32 DELETE=2\nint32 DELETEALL=3\n\
             std_msgs/Header header\nstring ns\nint32 id\nint32 type\nint32 action\n\
             geometry_msgs/Pose pose\ngeometry_msgs/Vector3 scale\nstd_msgs/ColorRGBA color\n\
             builtin_interfaces/Duration lifetime\nbool frame_locked\ngeometry_msgs/Point[] points\n\
             std_msgs/ColorRGBA[] colors\nstring texture_resource\nsensor_msgs/CompressedImage texture\n\
             visualization_msgs/UVCoordinate[] uv_coordinates\nstring text\nstring mesh_resource\n\
             visualization_msgs/MeshFile mesh_file\nbool mesh_use_embedded_materials\n",
        ),
        HEADER,
        TIME,
        DURATION,
        (
            "geometry_msgs/Pose",
            "geometry_msgs/Point position\ngeometry_msgs/Quaternion orientation\n",
        ),
        POINT,
        QUATERNION,
        VECTOR,
        (
            "std_msgs/ColorRGBA",
            "float32 r\nfloat32 g\nfloat32 b\nfloat32 a\n",
        ),
        (
            "sensor_msgs/CompressedImage",
            "std_msgs/Header header\nstring format\nuint8[] data\n",
        ),
        ("visualization_msgs/UVCoordinate", "float32 u\nfloat32 v\n"),
        (
            "visualization_msgs/MeshFile",
            "string filename\nuint8[] data\n",
        ),
    ];
}

/// A key of diagnostics with its value, as text.
#[derive(Clone, Debug, Serialize)]
pub struct KeyValue {
    pub key: String,
    pub value: String,
}

/// Status of one device or function, `diagnostic_msgs/msg/DiagnosticStatus`.
#[derive(Clone, Debug, Serialize)]
pub struct DiagnosticStatus {
    pub level: u8,
    pub name: String,
    pub message: String,
    pub hardware_id: String,
    pub values: Vec<KeyValue>,
}

/// Several devices' or functions' statuses, `diagnostic_msgs/msg/DiagnosticArray`.
#[derive(Clone, Debug, Serialize)]
pub struct DiagnosticArray {
    pub header: Header,
    pub status: Vec<DiagnosticStatus>,
}

impl Message for DiagnosticArray {
    const NAME: &'static str = "diagnostic_msgs/msg/DiagnosticArray";
    const FIELDS: &'static str =
        "std_msgs/Header header\ndiagnostic_msgs/DiagnosticStatus[] status\n";
    const PARTS: &'static [(&'static str, &'static str)] = &[
        HEADER,
        TIME,
        (
            "diagnostic_msgs/DiagnosticStatus",
            "byte OK=0\nbyte WARN=1\nbyte ERROR=2\nbyte STALE=3\nbyte level\nstring name\nstring message\n\
             string hardware_id\ndiagnostic_msgs/KeyValue[] values\n",
        ),
        ("diagnostic_msgs/KeyValue", "string key\nstring value\n"),
    ];
}

/// A single number, `std_msgs/msg/Float32`.
#[derive(Clone, Copy, Debug, Serialize)]
pub struct Float32 {
    pub data: f32,
}

impl Message for Float32 {
    const NAME: &'static str = "std_msgs/msg/Float32";
    const FIELDS: &'static str = "float32 data\n";
    const PARTS: &'static [(&'static str, &'static str)] = &[];
}

/// `geometry_msgs/msg/TransformStamped`: translation and rotation of a frame relative to its
/// parent.
#[derive(Clone, Debug, Serialize)]
pub struct TransformStamped {
    pub header: Header,
    pub child_frame_id: String,
    pub transform: Pose,
}

/// ROS 2's list of transformations between frames, `tf2_msgs/msg/TFMessage`.
#[derive(Clone, Debug, Serialize)]
pub struct TfMessage {
    pub transforms: Vec<TransformStamped>,
}

impl Message for TfMessage {
    const NAME: &'static str = "tf2_msgs/msg/TFMessage";
    const FIELDS: &'static str = "geometry_msgs/TransformStamped[] transforms\n";
    const PARTS: &'static [(&'static str, &'static str)] = &[
        (
            "geometry_msgs/TransformStamped",
            "std_msgs/Header header\nstring child_frame_id\ngeometry_msgs/Transform transform\n",
        ),
        HEADER,
        TIME,
        (
            "geometry_msgs/Transform",
            "geometry_msgs/Vector3 translation\ngeometry_msgs/Quaternion rotation\n",
        ),
        VECTOR,
        QUATERNION,
    ];
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Each part of a definition is listed once, and each used type is listed.
    fn whole<M: Message>() {
        let names: Vec<&str> = M::PARTS.iter().map(|(name, _)| *name).collect();
        let fields = M::PARTS.iter().map(|(_, fields)| *fields);
        for line in fields.chain([M::FIELDS]).flat_map(str::lines) {
            let kind = line.split_whitespace().next().unwrap();
            if kind.starts_with('#') {
                continue;
            }
            let kind = kind.trim_end_matches("[]");
            let definitions = names.iter().filter(|name| **name == kind).count();
            assert!(
                !kind.contains('/') || definitions == 1,
                "{}: {kind}: {definitions}",
                M::NAME
            );
        }
        assert_eq!(definition::<M>().matches("MSG: ").count(), names.len());
    }

    #[test]
    fn definitions_are_whole() {
        whole::<PointCloud2>();
        whole::<Image>();
        whole::<MarkerArray>();
        whole::<DiagnosticArray>();
        whole::<TfMessage>();
        whole::<crate::convert::staircase::Staircase>();
    }

    /// The encoding of a message, computed by hand: lengths before variable parts, numbers aligned
    /// to multiples of their length.
    #[test]
    fn the_encoding_is_that_of_dds() {
        let message = DiagnosticArray {
            header: Header {
                stamp: Time::from_nanos(2_000_000_003),
                frame_id: "ab".into(),
            },
            status: Vec::new(),
        };
        let expected = [
            0, 1, 0, 0, // encapsulation
            2, 0, 0, 0, 3, 0, 0, 0, // 2 s and 3 ns
            3, 0, 0, 0, b'a', b'b', 0, // three bytes including the terminator
            0, // padding to a multiple of four
            0, 0, 0, 0, // no status
        ];
        assert_eq!(encoded(&message).unwrap(), expected);
    }
}
