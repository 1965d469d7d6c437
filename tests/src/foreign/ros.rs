//! Definitions of the messages, as ROS writes them into a log.

/// Definition of a message, with those of its parts.
fn definition(fields: &str, header: &str, others: &[(&str, &str)]) -> String {
    let header = ("std_msgs/Header", header);
    let parts = [header].into_iter().chain(others.iter().copied());
    let parts = parts.map(|(name, fields)| format!("{}\nMSG: {name}\n{fields}", "=".repeat(80)));
    [fields.to_owned()].into_iter().chain(parts).collect::<Vec<_>>().join("\n")
}

const IMU: &str = "std_msgs/Header header\ngeometry_msgs/Quaternion orientation\nfloat64[9] orientation_covariance\ngeometry_msgs/Vector3 angular_velocity\nfloat64[9] angular_velocity_covariance\ngeometry_msgs/Vector3 linear_acceleration\nfloat64[9] linear_acceleration_covariance";
const TEMPERATURE: &str = "std_msgs/Header header\nfloat64 temperature\nfloat64 variance";
const TRIADS: [(&str, &str); 2] = [
    ("geometry_msgs/Quaternion", "float64 x\nfloat64 y\nfloat64 z\nfloat64 w"),
    ("geometry_msgs/Vector3", "float64 x\nfloat64 y\nfloat64 z"),
];

/// Definitions of ROS 1: Imu and Temperature.
pub(super) fn ros1() -> [String; 2] {
    let header = "uint32 seq\ntime stamp\nstring frame_id";
    [definition(IMU, header, &TRIADS), definition(TEMPERATURE, header, &[])]
}

/// Definitions of ROS 2: Imu and Temperature.
pub(super) fn ros2() -> [String; 2] {
    let header = "builtin_interfaces/Time stamp\nstring frame_id";
    let time = [("builtin_interfaces/Time", "int32 sec\nuint32 nanosec")];
    let all: Vec<_> = TRIADS.into_iter().chain(time).collect();
    [definition(IMU, header, &all), definition(TEMPERATURE, header, &time)]
}
