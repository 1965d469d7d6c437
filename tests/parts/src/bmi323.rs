//! BMI323 (Bosch Sensortec). Section numbers refer to its data sheet, BST-BMI323-DS000.

use crate::bus::Chip;
use crate::codes::{Sample, at_range};
use crate::sampler::Sampler;

/// Registers (§6.1.2).
const CHIP_ID: usize = 0x00;
const ERR_REG: usize = 0x01;
const STATUS: usize = 0x02;
const ACC_DATA: usize = 0x03;
const GYR_DATA: usize = 0x06;
const TEMP_DATA: usize = 0x09;
const SENSOR_TIME_0: usize = 0x0a;
const SENSOR_TIME_1: usize = 0x0b;
const SAT_FLAGS: usize = 0x0c;
const INT_STATUS_INT1: usize = 0x0d;
const INT_STATUS_INT2: usize = 0x0e;
const FEATURE_IO1: usize = 0x11;
const FEATURE_IO2: usize = 0x12;
const FEATURE_IO_STATUS: usize = 0x14;
const FIFO_FILL_LEVEL: usize = 0x15;
const FIFO_DATA: usize = 0x16;
const ACC_CONF: usize = 0x20;
const GYR_CONF: usize = 0x21;
const FIFO_WATERMARK: usize = 0x35;
const FIFO_CONF: usize = 0x36;
const FIFO_CTRL: usize = 0x37;
const IO_INT_CTRL: usize = 0x38;
const INT_MAP2: usize = 0x3b;
const FEATURE_CTRL: usize = 0x40;
const CMD: usize = 0x7e;

/// Registers with another reset value than 0.
const RESET: [(usize, u16); 13] = [
    (CHIP_ID, 0x0043),
    (STATUS, 0x0001),
    (ACC_DATA, NOTHING),
    (ACC_DATA + 1, NOTHING),
    (ACC_DATA + 2, NOTHING),
    (GYR_DATA, NOTHING),
    (GYR_DATA + 1, NOTHING),
    (GYR_DATA + 2, NOTHING),
    (TEMP_DATA, NOTHING),
    (ACC_CONF, 0x0028),
    (GYR_CONF, 0x0048),
    (0x28, 0x3206), // ALT_ACC_CONF
    (0x29, 0x1206), // ALT_GYR_CONF
];

/// Registers that the host cannot write: results, and the FIFO.
const READ_ONLY: [core::ops::RangeInclusive<usize>; 3] =
    [CHIP_ID..=0x0f, FEATURE_IO1..=FEATURE_IO1, FIFO_FILL_LEVEL..=FIFO_DATA];

/// Value of a data register without data, and of an empty FIFO.
const NOTHING: u16 = 0x8000;

/// First words in the FIFO of an accelerometer and a gyro without data yet (§5.7, table 18).
const NO_ACCEL: u16 = 0x7f01;
const NO_GYRO: u16 = 0x7f02;

/// Bits of STATUS and, from the thermometer on, of INT_STATUS.
const STATUS_TEMP: u16 = 1 << 5;
const STATUS_GYR: u16 = 1 << 6;
const STATUS_ACC: u16 = 1 << 7;
const INT_TEMP: u16 = 1 << 11;
const INT_GYR: u16 = 1 << 12;
const INT_ACC: u16 = 1 << 13;
const INT_WATERMARK: u16 = 1 << 14;
const INT_FULL: u16 = 1 << 15;

/// Bits of FIFO_CONF.
const STOP_ON_FULL: u16 = 1 << 0;
const FIFO_TIME: u16 = 1 << 8;
const FIFO_ACC: u16 = 1 << 9;
const FIFO_GYR: u16 = 1 << 10;
const FIFO_TEMP: u16 = 1 << 11;

/// FIFO of 2 kB (§5.7).
const FIFO_BYTES: usize = 2048;

/// Count of the sensor time, ns·1000.
const TIME_PS: u64 = 39_062_500;

/// Start-up from suspend of the accelerometer and the gyro.
const ACCEL_START_NS: u64 = 2_000_000;
const GYRO_START_NS: u64 = 45_000_000;

/// Period of the thermometer, 50 Hz.
const THERMOMETER_NS: u64 = 20_000_000;

/// Time that the feature engine takes to start (§5.8.1).
const ENGINE_START_NS: u64 = 3_000_000;

/// Command that starts the feature engine, written to FEATURE_IO2 (§5.8.1).
const ENGINE_CONFIGURATION: u16 = 0x012c;
/// Status of the feature engine while it starts, and after that.
const ENGINE_ACTIVATED: u16 = 0x1;
const ENGINE_NO_ERROR: u16 = 0x5;

/// Command of a soft reset.
const SOFT_RESET: u16 = 0xdeaf;

/// Registers of a BMI323.
#[derive(Debug)]
pub(crate) struct Bmi323 {
    registers: [u16; 128],
    /// Latched bits of INT_STATUS.
    events: u16,
    /// Part time at which each sensor was switched on, ns.
    accel_on_ns: Option<u64>,
    gyro_on_ns: Option<u64>,
    /// FEATURE_IO2 was handed to the feature engine.
    handed_over: bool,
    /// Part time at which the feature engine was started, ns.
    engine_on_ns: Option<u64>,
}

/// Sample period of ACC_CONF or GYR_CONF, ns; `None` if the sensor is off.
fn period_ns(conf: u16) -> Option<u64> {
    let mode = conf >> 12 & 7;
    // codes 1 to 14: 0.78125 Hz · 2^(n-1); modes below 3 have no data
    let odr = conf & 0xf;
    (mode >= 3 && (1..=14).contains(&odr)).then(|| 1_280_000_000 >> (odr - 1))
}

impl Bmi323 {
    fn start(before: Option<u64>, conf: u16, now_ns: u64) -> Option<u64> {
        period_ns(conf).and(before.or(Some(now_ns)))
    }

    fn has_started(on_ns: Option<u64>, start_ns: u64, now_ns: u64) -> bool {
        on_ns.is_some_and(|on_ns| now_ns >= on_ns + start_ns)
    }

    /// Accelerometer and gyro codes at the ranges in force; `None` before a sensor has started.
    fn codes(&self, sampler: &mut Sampler) -> (Sample, bool, bool) {
        let range = |conf: u16| f64::from(1_u32 << (self.registers[usize::from(conf)] >> 4 & 7).min(4));
        let mut sample = sampler.sample(THERMOMETER_NS);
        // ±2, 4, 8, 16 g and ±125, 250, 500, 1000, 2000 °/s
        sample.accel = at_range(sample.accel, 2.0 / range(ACC_CONF as u16));
        sample.gyro = at_range(sample.gyro, 4.0 / range(GYR_CONF as u16));
        if sampler.faults.no_temperature {
            sample.temperature = NOTHING as i16;
        }
        let has_accel = Self::has_started(self.accel_on_ns, ACCEL_START_NS, sampler.now_ns);
        let has_gyro = Self::has_started(self.gyro_on_ns, GYRO_START_NS, sampler.now_ns);
        (sample, has_accel, has_gyro)
    }

    fn time(sampler: &Sampler) -> u64 {
        sampler.since_reset_ns() * 1000 / TIME_PS
    }

    fn batch(&self, sampler: &mut Sampler, codes: Sample, has_accel: bool, has_gyro: bool) {
        let conf = self.registers[FIFO_CONF];
        let mut words = Vec::new();
        let mut triad = |axes: [i16; 3], has: bool, dummy: u16| {
            words.extend(if has { axes.map(|code| code as u16) } else { [dummy, NOTHING, NOTHING] });
        };
        if conf & FIFO_ACC != 0 {
            triad(codes.accel, has_accel, NO_ACCEL);
        }
        if conf & FIFO_GYR != 0 {
            triad(codes.gyro, has_gyro, NO_GYRO);
        }
        if conf & FIFO_TEMP != 0 {
            words.push(codes.temperature as u16);
        }
        if conf & FIFO_TIME != 0 {
            words.push(Self::time(sampler) as u16);
        }
        if words.is_empty() || sampler.faults.silent {
            return;
        }
        let capacity = FIFO_BYTES / (2 * words.len());
        let row = (has_accel && has_gyro).then(|| sampler.fifo.record(sampler.tick(), codes));
        let bytes = words.into_iter().flat_map(u16::to_le_bytes).collect();
        sampler.fifo.push(bytes, row, capacity, conf & STOP_ON_FULL != 0);
    }

    /// Fill level of the FIFO in words; a frame that was read in part counts in full.
    fn level(&self, sampler: &Sampler) -> u16 {
        let conf = self.registers[FIFO_CONF];
        let triads = (conf & FIFO_ACC).count_ones() + (conf & FIFO_GYR).count_ones();
        let words = 3 * triads + (conf & FIFO_TEMP).count_ones() + (conf & FIFO_TIME).count_ones();
        (sampler.fifo.len() as u32 * words) as u16
    }

    /// INT_STATUS: latched events and the present state of the FIFO.
    fn status(&self, sampler: &Sampler) -> u16 {
        let level = self.level(sampler);
        let watermark = self.registers[FIFO_WATERMARK];
        let mut status = self.events;
        if watermark > 0 && level >= watermark {
            status |= INT_WATERMARK;
        }
        if usize::from(level) * 2 + 16 > FIFO_BYTES {
            status |= INT_FULL;
        }
        status
    }

    /// Bits of INT_STATUS that INT_MAP2 leads to a pin.
    fn mapped(&self, pin: u8) -> u16 {
        let map = self.registers[INT_MAP2];
        // two bits for each of temperature, gyro, accelerometer, watermark and full
        (0..5)
            .filter(|source| map >> (6 + 2 * source) & 3 == u16::from(pin))
            .map(|source| INT_TEMP << source)
            .sum()
    }

    fn engine_status(&self, sampler: &Sampler) -> u16 {
        match self.engine_on_ns {
            None => 0,
            Some(on_ns) if sampler.now_ns < on_ns + ENGINE_START_NS => ENGINE_ACTIVATED,
            Some(_) => ENGINE_NO_ERROR,
        }
    }
}

impl Chip for Bmi323 {
    const REGISTER_BYTES: u8 = 2;
    /// §7.2.3, §7.2.4.2
    const DUMMY_BYTES: [u8; 2] = [1, 2];
    const STARTS_ON_I2C: bool = true;
    const FIFO_DATA: u8 = FIFO_DATA as u8;
    const BOOT_NS: u64 = 1_500_000;
    const TICK_NS: u64 = 5_000_000;
    /// 25 °C (§5.6.3)
    const ROOM: i16 = 1024;

    fn new() -> Self {
        let mut registers = [0; 128];
        for (register, value) in RESET {
            registers[register] = value;
        }
        Self {
            registers,
            events: 0,
            accel_on_ns: None,
            gyro_on_ns: None,
            handed_over: false,
            engine_on_ns: None,
        }
    }

    fn read(&mut self, sampler: &mut Sampler, register: u8) -> u16 {
        let register = usize::from(register);
        let value = self.registers[register];
        match register {
            CHIP_ID => sampler.faults.identity.map_or(value, u16::from),
            // cleared by reading
            STATUS => core::mem::take(&mut self.registers[STATUS]),
            TEMP_DATA if self.accel_on_ns.is_some() || self.gyro_on_ns.is_some() => {
                if sampler.faults.no_temperature {
                    NOTHING
                } else {
                    sampler.temperature(THERMOMETER_NS) as u16
                }
            }
            SENSOR_TIME_0 => Self::time(sampler) as u16,
            SENSOR_TIME_1 => (Self::time(sampler) >> 16) as u16,
            INT_STATUS_INT1 | INT_STATUS_INT2 => {
                let mapped = self.mapped((register - INT_STATUS_INT1) as u8 + 1);
                let status = self.status(sampler) & mapped;
                self.events &= !mapped;
                status
            }
            FEATURE_IO1 => self.engine_status(sampler),
            FIFO_FILL_LEVEL => self.level(sampler),
            FIFO_DATA => match (sampler.fifo.read(), sampler.fifo.read()) {
                (Some(low), Some(high)) => u16::from_le_bytes([low, high]),
                _ => NOTHING,
            },
            _ => value,
        }
    }

    fn write(&mut self, sampler: &mut Sampler, register: u8, value: u16) -> bool {
        let register = usize::from(register);
        if register == CMD && value == SOFT_RESET {
            return true;
        }
        if register == FIFO_CTRL && value & 1 != 0 {
            sampler.fifo.clear();
            return false;
        }
        let read_only = READ_ONLY.iter().any(|range| range.contains(&register));
        if read_only || matches!(register, CMD | FIFO_CTRL) || sampler.faults.forgetful {
            return false;
        }
        self.registers[register] = match register {
            ACC_CONF | GYR_CONF => value & 0x77ff,
            FIFO_WATERMARK => value & 0x03ff,
            FIFO_CONF => value & (STOP_ON_FULL | FIFO_TIME | FIFO_ACC | FIFO_GYR | FIFO_TEMP),
            _ => value,
        };
        let now_ns = sampler.now_ns;
        match register {
            ACC_CONF => self.accel_on_ns = Self::start(self.accel_on_ns, value, now_ns),
            GYR_CONF => self.gyro_on_ns = Self::start(self.gyro_on_ns, value, now_ns),
            // frames of another composition cannot be in one FIFO
            FIFO_CONF => sampler.fifo.clear(),
            FEATURE_IO_STATUS => self.handed_over |= value & 1 != 0,
            FEATURE_CTRL if value & 1 != 0 => {
                let starts = self.handed_over && self.registers[FEATURE_IO2] == ENGINE_CONFIGURATION;
                self.engine_on_ns = self.engine_on_ns.or(starts.then_some(now_ns));
            }
            _ => {}
        }
        // acc_conf_err and gyr_conf_err: a sensor that is on has no such rate
        for (conf, bit) in [(ACC_CONF, 1 << 5), (GYR_CONF, 1 << 6)] {
            let conf = self.registers[conf];
            if conf >> 12 & 7 >= 3 && period_ns(conf).is_none() {
                self.registers[ERR_REG] |= bit;
            }
        }
        false
    }

    fn next(&self, register: u8) -> u8 {
        if usize::from(register) == FIFO_DATA { register } else { (register + 1) & 0x7f }
    }

    fn period_ns(&self) -> Option<u64> {
        let [accel, gyro] = [ACC_CONF, GYR_CONF].map(|conf| period_ns(self.registers[conf]));
        accel.into_iter().chain(gyro).min()
    }

    fn sample(&mut self, sampler: &mut Sampler) {
        let (codes, has_accel, has_gyro) = self.codes(sampler);
        let mut saturated = 0;
        for (triad, axes, has, status, event) in [
            (ACC_DATA, codes.accel, has_accel, STATUS_ACC, INT_ACC),
            (GYR_DATA, codes.gyro, has_gyro, STATUS_GYR, INT_GYR),
        ] {
            if !has {
                continue;
            }
            for (axis, code) in axes.into_iter().enumerate() {
                self.registers[triad + axis] = code as u16;
                saturated |= u16::from(matches!(code, i16::MIN | i16::MAX)) << (triad - ACC_DATA + axis);
            }
            self.registers[STATUS] |= status;
            self.events |= event;
        }
        self.registers[SAT_FLAGS] = saturated;
        if sampler.is_due(THERMOMETER_NS, self.period_ns().unwrap_or(THERMOMETER_NS)) {
            self.registers[STATUS] |= STATUS_TEMP;
            self.events |= INT_TEMP;
        }
        self.batch(sampler, codes, has_accel, has_gyro);
    }

    /// IO_INT_CTRL: level and output enable of each pin.
    fn interrupt(&self, sampler: &Sampler, pin: u8) -> bool {
        let control = self.registers[IO_INT_CTRL] >> (8 * (pin.max(1) - 1));
        let (active_high, enabled) = (control & 1 != 0, control & 4 != 0);
        enabled && (self.status(sampler) & self.mapped(pin) != 0) == active_high
    }
}
