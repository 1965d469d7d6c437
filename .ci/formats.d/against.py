"""What fos reads of a log is what the format's own tools read of it, and what they write is read.

Usage: against.py HOST_FIT FOLDER [ULOG...]: FOLDER holds the logs of tests/examples/foreign_logs.rs; further ULogs are
read by both.
"""

import csv
import subprocess
import sys
from pathlib import Path

import numpy as np
from pymavlink import DFReader
from pyulog import ULog
from rosbags.highlevel import AnyReader
from rosbags.rosbag1 import Writer as BagWriter
from rosbags.rosbag2 import CompressionFormat, CompressionMode, StoragePlugin, Writer as Bag2Writer
from rosbags.typesys import Stores, get_typestore

HOST_FIT, FOLDER = sys.argv[1], Path(sys.argv[2])
FORCE, RATE = ["ax_mps2", "ay_mps2", "az_mps2"], ["gx_rads", "gy_rads", "gz_rads"]


def ours(log):
    """Columns of a log as fos reads it."""
    out = FOLDER / "ours.csv"
    subprocess.run([HOST_FIT, "convert", str(log), "-o", str(out)], check=True, stdout=subprocess.DEVNULL)
    with open(out, newline="") as file:
        rows = csv.reader(file)
        names = next(rows)
        columns = np.array([[float(cell) if cell else np.nan for cell in row] for row in rows]).T
    return dict(zip(names, columns))


def same(log, found, expected):
    """Every column to the last bit."""
    for name, values in expected.items():
        values = np.asarray(values, dtype=float)
        assert len(found[name]) == len(values), f"{log}: {name}: {len(found[name])} rows, not {len(values)}"
        wrong = np.flatnonzero(~((found[name] == values) | (np.isnan(found[name]) & np.isnan(values))))
        assert not len(wrong), f"{log}: {name}, row {wrong[0]}: {found[name][wrong[0]]!r}, not {values[wrong[0]]!r}"
    print(f"{Path(log).name}: {len(values)} rows, {', '.join(expected)}: the same bits")


def ulog(log):
    topics = {(data.name, data.multi_id): data.data for data in ULog(str(log)).data_list}
    accel, gyro = topics.get(("sensor_accel", 0)), topics.get(("sensor_gyro", 0))
    if accel is not None and np.median(np.diff(accel["timestamp_sample"])) < 50e3:
        expected = {"t_s": gyro["timestamp_sample"] / 1e6}
        expected |= {name: accel[axis] for name, axis in zip(FORCE, "xyz")}
        expected |= {name: gyro[axis] for name, axis in zip(RATE, "xyz")}
        expected["temp_c"] = accel["temperature"]
    else:
        combined = topics["sensor_combined", 0]
        stamps = combined["timestamp"].astype(np.int64)
        expected = {"t_s": stamps / 1e6} if stamps[0] < 2**53 // 1000 else {}
        expected |= {name: combined[f"gyro_rad[{axis}]"] for axis, name in enumerate(RATE)}
        if not combined["accelerometer_timestamp_relative"].any():
            expected |= {name: combined[f"accelerometer_m_s2[{axis}]"] for axis, name in enumerate(FORCE)}
    same(log, ours(log), expected)


def ulog_written(log):
    """What pyulog writes."""
    again = FOLDER / "written_by_pyulog.ulg"
    ULog(str(log)).write_ulog(str(again))
    ulog(again)


def dataflash(log, force_type, rate_type):
    reader = DFReader.DFReader_binary(str(log))
    columns = {"t_s": [], **{name: [] for name in FORCE + RATE}}
    while (message := reader.recv_msg()) is not None:
        kind = message.get_type()
        if kind == force_type and message.I == 0:
            columns["t_s"].append((message.SampleUS if kind == "ACC" else message.TimeUS) / 1e6)
            for name, axis in zip(FORCE, "XYZ"):
                columns[name].append(getattr(message, f"Acc{axis}"))
        if kind == rate_type and message.I == 0:
            for name, axis in zip(RATE, "XYZ"):
                columns[name].append(getattr(message, f"Gyr{axis}"))
    same(log, ours(log), columns)


def ros(log):
    columns = {"t_s": [], **{name: [] for name in FORCE + RATE}}
    with AnyReader([log], default_typestore=get_typestore(Stores.ROS2_HUMBLE)) as reader:
        topics = [topic for topic in reader.connections if topic.topic in ("/imu", "/imu/data_raw")]
        for connection, _, raw in reader.messages(topics):
            message = reader.deserialize(raw, connection.msgtype)
            stamp = message.header.stamp
            columns["t_s"].append((stamp.sec * 10**9 + stamp.nanosec) / 1e9)
            for names, vector in ((FORCE, message.linear_acceleration), (RATE, message.angular_velocity)):
                for name, value in zip(names, (vector.x, vector.y, vector.z)):
                    columns[name].append(value)
    same(log, ours(log), columns)


def ros_written(folder):
    """What rosbags writes: a bag of ROS 1 in its two compressions, one of ROS 2 in MCAP."""
    flight = ours(FOLDER / "flight.csv")
    expected = {name: flight[name] for name in ["t_s", *FORCE, *RATE]}
    stamps = np.rint(flight["t_s"] * 1e9).astype(np.int64)

    def messages(store):
        types = store.types
        vector, header, time = (types[f"geometry_msgs/msg/Vector3"], types["std_msgs/msg/Header"],
                                types["builtin_interfaces/msg/Time"])
        quaternion = types["geometry_msgs/msg/Quaternion"](x=0.0, y=0.0, z=0.0, w=1.0)
        none = np.zeros(9)
        for row, stamp in enumerate(stamps):
            fields = dict(stamp=time(sec=int(stamp // 10**9), nanosec=int(stamp % 10**9)), frame_id="imu_link")
            if "seq" in header.__dataclass_fields__:
                fields["seq"] = row
            triad = lambda names: vector(*(float(flight[name][row]) for name in names))
            yield int(stamp), types["sensor_msgs/msg/Imu"](
                header=header(**fields), orientation=quaternion, orientation_covariance=none,
                angular_velocity=triad(RATE), angular_velocity_covariance=none,
                linear_acceleration=triad(FORCE), linear_acceleration_covariance=none)

    store = get_typestore(Stores.ROS1_NOETIC)
    for compression in [None, BagWriter.CompressionFormat.BZ2, BagWriter.CompressionFormat.LZ4]:
        path = folder / f"rosbags_{compression.name.lower() if compression else 'plain'}.bag"
        writer = BagWriter(path)
        if compression:
            writer.set_compression(compression)
        with writer:
            connection = writer.add_connection("/imu", "sensor_msgs/msg/Imu", typestore=store)
            for stamp, message in messages(store):
                writer.write(connection, stamp, store.serialize_ros1(message, "sensor_msgs/msg/Imu"))
        same(path, ours(path), expected)

    store = get_typestore(Stores.ROS2_HUMBLE)
    for mode in [None, CompressionMode.STORAGE]:
        path = folder / f"rosbags_{'zstd' if mode else 'plain'}_2"
        writer = Bag2Writer(path, version=9, storage_plugin=StoragePlugin.MCAP)
        if mode:
            writer.set_compression(mode, CompressionFormat.ZSTD)
        with writer:
            connection = writer.add_connection("/imu", "sensor_msgs/msg/Imu", typestore=store)
            for stamp, message in messages(store):
                writer.write(connection, stamp, store.serialize_cdr(message, "sensor_msgs/msg/Imu"))
        same(path, ours(path), expected)


for name in ["flight.ulg", "decimated.ulg"]:
    ulog(FOLDER / name)
ulog_written(FOLDER / "flight.ulg")
dataflash(FOLDER / "flight.bin", "IMU", "IMU")
dataflash(FOLDER / "every_sample.bin", "ACC", "GYR")
ros(FOLDER / "flight.mcap")
ros_written(FOLDER)
for log in sys.argv[3:]:
    ulog(Path(log))
    ulog_written(Path(log))
