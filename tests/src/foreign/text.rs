//! Text and archives written by phone apps and tools.

use std::fmt::Write as _;

use super::{Flight, zip};

/// A text format: the id to be recognised, the file name, and the writer of a flight.
pub type Text = (&'static str, &'static str, fn(&Flight) -> Vec<u8>);

/// All text formats, and variants of some.
pub const TEXTS: &[Text] = &[
    ("named", "named.csv", named),
    ("euroc", "data.csv", euroc),
    ("kalibr", "imu0.csv", kalibr),
    ("sensor-logger", "android.zip", |flight| sensor_logger(flight, false)),
    ("sensor-logger", "ios.zip", |flight| sensor_logger(flight, true)),
    ("phyphox", "phyphox.csv", phyphox),
    ("phyphox", "phyphox.zip", phyphox_zip),
    ("sensorlog", "sensorlog.csv", sensorlog),
    ("gnsslogger", "gnss_log.txt", gnss_logger),
    ("st", "st.tsv", st),
    ("physics-toolbox", "physics.csv", physics_toolbox),
    ("androsensor", "androsensor.csv", androsensor),
    ("betaflight", "blackbox.csv", betaflight),
    ("xsens", "dot.csv", dot),
];

const G: f64 = 9.80665;

/// One line for each sample: `row` gets the timestamp in µs, acceleration and rate.
fn lines(flight: &Flight, header: &str, row: impl Fn(u64, [f64; 3], [f64; 3]) -> String) -> Vec<u8> {
    let mut text = format!("{header}\n");
    for sample in 0..flight.len() {
        let wide = |values: [f32; 3]| values.map(f64::from);
        let line =
            row(flight.stamps_us[sample], wide(flight.acceleration[sample]), wide(flight.rate[sample]));
        writeln!(text, "{line}").expect("a String takes all");
    }
    text.into_bytes()
}

fn joined(values: impl IntoIterator<Item = f64>, separator: &str) -> String {
    values.into_iter().map(|value| value.to_string()).collect::<Vec<_>>().join(separator)
}

fn named(flight: &Flight) -> Vec<u8> {
    lines(
        flight,
        "time [ms],acc_x (mg),acc_y (mg),acc_z (mg),gyro_x [dps],gyro_y [dps],gyro_z [dps]",
        |us, a, w| {
            let a = a.map(|a| a / G * 1000.0);
            let w = w.map(f64::to_degrees);
            format!("{},{},{}", us as f64 / 1e3, joined(a, ","), joined(w, ","))
        },
    )
}

/// Export of a DOT by the app of Movella: its clock has 32 bits and is about to wrap.
fn dot(flight: &Flight) -> Vec<u8> {
    const HEADER: &str = "sep=,\nDeviceTag:,Xsens DOT\nFirmwareVersion:,2.0.0\n\nPacketCounter,SampleTimeFine,Acc_X,Acc_Y,Acc_Z,Gyr_X,Gyr_Y,Gyr_Z";
    let first = flight.stamps_us[0];
    let before_wrap = u64::from(u32::MAX) - 2_000_000;
    lines(flight, HEADER, |us, a, w| {
        let ticks = (before_wrap + us - first) % (1 << 32);
        format!("{},{ticks},{},{}", (us - first) / 5000, joined(a, ","), joined(w.map(f64::to_degrees), ","))
    })
}

fn euroc(flight: &Flight) -> Vec<u8> {
    lines(
        flight,
        "#timestamp [ns],w_RS_S_x [rad s^-1],w_RS_S_y [rad s^-1],w_RS_S_z [rad s^-1],a_RS_S_x [m s^-2],a_RS_S_y [m s^-2],a_RS_S_z [m s^-2]",
        |us, a, w| format!("{},{},{}", us * 1000, joined(w, ","), joined(a, ",")),
    )
}

fn kalibr(flight: &Flight) -> Vec<u8> {
    lines(flight, "timestamp,omega_x,omega_y,omega_z,alpha_x,alpha_y,alpha_z", |us, a, w| {
        format!("{},{},{}", us * 1000, joined(w, ","), joined(a, ","))
    })
}

fn sensor_logger(flight: &Flight, ios: bool) -> Vec<u8> {
    const HEADER: &str = "time,seconds_elapsed,z,y,x";
    const EPOCH_US: u64 = 1_760_000_000_000_000;
    let first = flight.stamps_us[0];
    let row = |us: u64, [x, y, z]: [f64; 3]| {
        format!("{},{},{z},{y},{x}", (EPOCH_US + us) * 1000, (us - first) as f64 / 1e6)
    };
    // an iPhone uses g with the opposite sign
    let scale = if ios { -1.0 / G } else { 1.0 };
    let force = lines(flight, HEADER, |us, a, _| row(us, a.map(|a| a * scale)));
    // without gravity
    let linear = lines(flight, HEADER, |us, [x, y, z], _| row(us, [x, y, z - G]));
    let turn = lines(flight, HEADER, |us, _, w| row(us, w));
    let metadata = format!(
        "version,device name,recording epoch time,recording time,recording timezone,platform,appVersion,device id,sensors,sampleRateMs,standardisation,platform version\n3,phone,1760000000000,2025-10-09,UTC,{},1.47,id,Accelerometer|Gyroscope,0|0,false,18\n",
        if ios { "ios" } else { "android" }
    );
    zip(&[
        ("AccelerometerUncalibrated.csv", &force),
        ("Accelerometer.csv", &linear),
        ("Gyroscope.csv", &turn),
        ("Metadata.csv", metadata.as_bytes()),
    ])
}

fn phyphox(flight: &Flight) -> Vec<u8> {
    lines(
        flight,
        "\"Time (s)\",\"Acceleration x (m/s^2)\",\"Acceleration y (m/s^2)\",\"Acceleration z (m/s^2)\",\"Gyroscope x (rad/s)\",\"Gyroscope y (rad/s)\",\"Gyroscope z (rad/s)\"",
        |us, a, w| format!("{:E},{},{}", us as f64 / 1e6, joined(a, ","), joined(w, ",")),
    )
}

fn phyphox_zip(flight: &Flight) -> Vec<u8> {
    let norm = |[x, y, z]: [f64; 3]| (x * x + y * y + z * z).sqrt();
    let force = lines(
        flight,
        "\"Time (s)\",\"Acceleration x (m/s^2)\",\"Acceleration y (m/s^2)\",\"Acceleration z (m/s^2)\",\"Absolute acceleration (m/s^2)\"",
        |us, a, _| format!("{},{},{}", us as f64 / 1e6, joined(a, ","), norm(a)),
    );
    let turn = lines(
        flight,
        "\"Time (s)\",\"Gyroscope x (rad/s)\",\"Gyroscope y (rad/s)\",\"Gyroscope z (rad/s)\",\"Absolute (rad/s)\"",
        |us, _, w| format!("{},{},{}", us as f64 / 1e6, joined(w, ","), norm(w)),
    );
    zip(&[
        ("Accelerometer.csv", &force),
        ("Gyroscope.csv", &turn),
        ("meta/device.csv", b"property,value\nversion,1.1.16\n"),
    ])
}

fn sensorlog(flight: &Flight) -> Vec<u8> {
    lines(
        flight,
        "loggingTime(txt),loggingSample(N),accelerometerTimestamp_sinceReboot(s),accelerometerAccelerationX(G),accelerometerAccelerationY(G),accelerometerAccelerationZ(G),gyroTimestamp_sinceReboot(s),gyroRotationX(rad/s),gyroRotationY(rad/s),gyroRotationZ(rad/s)",
        |us, a, w| {
            let stamp = us as f64 / 1e6;
            let a = a.map(|a| -a / G);
            format!(
                "2025-10-09 12:00:00.000 +0200,{us},{stamp},{},{stamp},{}",
                joined(a, ","),
                joined(w, ",")
            )
        },
    )
}

fn gnss_logger(flight: &Flight) -> Vec<u8> {
    let mut text = "# \n# Header Description:\n# \n# Version: v3.0.6.4 Platform: 14 Manufacturer: Google Model: Pixel\n# \n# Raw,utcTimeMillis,TimeNanos\n# \n# UncalAccel,utcTimeMillis,elapsedRealtimeNanos,UncalAccelXMps2,UncalAccelYMps2,UncalAccelZMps2,BiasXMps2,BiasYMps2,BiasZMps2\n# \n".to_owned();
    for sample in 0..flight.len() {
        let us = flight.stamps_us[sample];
        let wide = |values: [f32; 3]| joined(values.map(f64::from), ",");
        let (a, w) = (wide(flight.acceleration[sample]), wide(flight.rate[sample]));
        let (utc, ns) = (1_760_000_000_000 + us / 1000, us * 1000);
        writeln!(
            text,
            "UncalAccel,{utc},{ns},{a},0.01,0.02,0.03,3\nUncalGyro,{utc},{ns},{w},0.001,0.002,0.003,3"
        )
        .expect("a String takes all");
        if sample % 200 == 0 {
            writeln!(text, "Raw,{utc},{ns},,,-1,0.0").expect("a String takes all");
        }
    }
    text.into_bytes()
}

fn st(flight: &Flight) -> Vec<u8> {
    let header =
        "MEMS Studio log\nTimestamp [us]\tA_X [mg]\tA_Y [mg]\tA_Z [mg]\tG_X [mdps]\tG_Y [mdps]\tG_Z [mdps]";
    lines(flight, header, |us, a, w| {
        let (a, w) = (a.map(|a| a / G * 1000.0), w.map(|w| w.to_degrees() * 1000.0));
        format!("{us}\t{}\t{}", joined(a, "\t"), joined(w, "\t"))
    })
}

fn physics_toolbox(flight: &Flight) -> Vec<u8> {
    let header = "time;gFx;gFy;gFz;TgF;ax;ay;az;wx;wy;wz";
    // with decimal commas, as a phone in Europe writes
    lines(flight, header, |us, a, w| {
        let linear = [a[0], a[1], a[2] - G];
        let row = format!(
            "{};{};1;{};{}",
            us as f64 / 1e6,
            joined(a.map(|a| a / G), ";"),
            joined(linear, ";"),
            joined(w, ";")
        );
        row.replace('.', ",")
    })
}

fn androsensor(flight: &Flight) -> Vec<u8> {
    let header = "ACCELEROMETER X (m/s²);ACCELEROMETER Y (m/s²);ACCELEROMETER Z (m/s²);GRAVITY X (m/s²);LINEAR ACCELERATION X (m/s²);GYROSCOPE X (rad/s);GYROSCOPE Y (rad/s);GYROSCOPE Z (rad/s);Time since start in ms ;YYYY-MO-DD HH-MI-SS_SSS";
    lines(flight, header, |us, a, w| {
        format!("{};0;0;{};{};2025-10-09 12:00:00:123", joined(a, ";"), joined(w, ";"), us as f64 / 1e3)
    })
}

fn betaflight(flight: &Flight) -> Vec<u8> {
    let header = "\"Product\",\"Blackbox flight data recorder\"\n\"acc_1G\",2048\n\"loopIteration\",\"time\",\"gyroADC[0]\",\"gyroADC[1]\",\"gyroADC[2]\",\"accSmooth[0]\",\"accSmooth[1]\",\"accSmooth[2]\",\"motor[0]\"";
    lines(flight, header, |us, a, w| {
        let (a, w) = (a.map(|a| (a / G * 2048.0).round()), w.map(|w| w.to_degrees().round()));
        format!("{us},{us},{},{},1000", joined(w, ","), joined(a, ","))
    })
}
