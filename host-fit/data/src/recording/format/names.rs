//! Names of the formats.

/// A supported format of logs.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
pub enum Format {
    /// The log format of fos: the names of the columns define everything.
    Log,
    /// A table whose columns name their quantity, axis and unit.
    Named,
    /// PX4 ULog.
    Ulog,
    /// ArduPilot DataFlash.
    Dataflash,
    /// MCAP with messages of ROS 2.
    Mcap,
    /// A bag of ROS 1.
    Bag,
    /// The CSV of the EuRoC data sets.
    Euroc,
    /// The CSV that Kalibr reads.
    Kalibr,
    /// Sensor Logger, of phones.
    SensorLogger,
    /// phyphox, of phones.
    Phyphox,
    /// SensorLog, of iPhones.
    SensorLog,
    /// Google's GnssLogger.
    GnssLogger,
    /// Unicleo and MEMS Studio, of ST.
    StTools,
    /// Physics Toolbox, of phones.
    PhysicsToolbox,
    /// AndroSensor, of phones.
    AndroSensor,
    /// Betaflight's blackbox as CSV.
    Betaflight,
    /// Movella DOT, and Xsens MT Manager, as text.
    Xsens,
    /// GENEActiv wrist-worn accelerometers.
    GeneActiv,
    /// Axivity AX3 and AX6.
    Axivity,
}
