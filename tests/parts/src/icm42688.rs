//! ICM-42688-P (TDK InvenSense). Section numbers refer to its data sheet, DS-000347.

use crate::bus::Chip;
use crate::codes::{Sample, at_range};
use crate::sampler::Sampler;

/// Registers of bank 0 (§14).
const DEVICE_CONFIG: usize = 0x11;
const INT_CONFIG: usize = 0x14;
const FIFO_CONFIG: usize = 0x16;
const TEMP_DATA: usize = 0x1d;
const ACCEL_DATA: usize = 0x1f;
const GYRO_DATA: usize = 0x25;
const INT_STATUS: usize = 0x2d;
const FIFO_COUNT: usize = 0x2e;
const FIFO_DATA: usize = 0x30;
const SIGNAL_PATH_RESET: usize = 0x4b;
const INTF_CONFIG0: usize = 0x4c;
const PWR_MGMT0: usize = 0x4e;
const GYRO_CONFIG0: usize = 0x4f;
const ACCEL_CONFIG0: usize = 0x50;
const TMST_CONFIG: usize = 0x54;
const FIFO_CONFIG1: usize = 0x5f;
const FIFO_CONFIG2: usize = 0x60;
const FIFO_CONFIG3: usize = 0x61;
const INT_SOURCE0: usize = 0x65;
const INT_SOURCE3: usize = 0x68;
const FIFO_LOST_PKT0: usize = 0x6c;
const WHO_AM_I: usize = 0x75;
/// In every bank.
const REG_BANK_SEL: usize = 0x76;

/// Registers of bank 0 with another reset value than 0.
const RESET: [(usize, u8); 14] = [
    (0x13, 0x05), // DRIVE_CONFIG
    (INTF_CONFIG0, 0x30),
    (0x4d, 0x91), // INTF_CONFIG1
    (GYRO_CONFIG0, 0x06),
    (ACCEL_CONFIG0, 0x06),
    (0x51, 0x16), // GYRO_CONFIG1
    (0x52, 0x11), // GYRO_ACCEL_CONFIG0
    (0x53, 0x0d), // ACCEL_CONFIG1
    (TMST_CONFIG, 0x23),
    (0x56, 0x82), // APEX_CONFIG0
    (0x62, 0x10), // FSYNC_CONFIG
    (0x64, 0x10), // INT_CONFIG1
    (INT_SOURCE0, 0x10),
    (WHO_AM_I, 0x47),
];

/// Bits of INT_STATUS.
const FIFO_FULL: u8 = 1 << 1;
const FIFO_WATERMARK: u8 = 1 << 2;
const DATA_READY: u8 = 1 << 3;
const RESET_DONE: u8 = 1 << 4;

/// Bits of INTF_CONFIG0, TMST_CONFIG and FIFO_CONFIG1.
const DATA_BIG_ENDIAN: u8 = 1 << 4;
const COUNT_BIG_ENDIAN: u8 = 1 << 5;
const COUNT_RECORDS: u8 = 1 << 6;
const TMST_EN: u8 = 1 << 0;
const TMST_RES: u8 = 1 << 3;
const FIFO_ACCEL: u8 = 1 << 0;
const FIFO_GYRO: u8 = 1 << 1;
const FIFO_HIRES: u8 = 1 << 4;

/// Code of a sensor without data.
const NOTHING: i16 = i16::MIN;

/// FIFO of 2 kB (§6).
const FIFO_BYTES: usize = 2048;

/// Counts of the timestamp, ps: 1 or 16 µs, as it counts 30 of 32 periods without an external clock (§12.7).
const TIMESTAMP_PS: [u64; 2] = [1_066_667, 17_066_667];

/// Start-up from off of the accelerometer and the gyro (§3).
const ACCEL_START_NS: u64 = 10_000_000;
const GYRO_START_NS: u64 = 30_000_000;

/// Time after a sensor was switched on in which nothing may be written (§14.36).
const NO_WRITE_NS: u64 = 200_000;

/// Period of the thermometer, with its filter at the reset value.
const THERMOMETER_NS: u64 = 1_000_000;

/// Registers of an ICM-42688-P.
#[derive(Debug)]
pub(crate) struct Icm42688 {
    banks: [[u8; 128]; 8],
    /// Latched bits of INT_STATUS.
    events: u8,
    /// Part time at which each sensor was switched on, ns.
    accel_on_ns: Option<u64>,
    gyro_on_ns: Option<u64>,
}

/// Period of a rate code, ns.
fn period_ns(code: u8) -> Option<u64> {
    match code {
        1..=6 => Some(31_250 << (code - 1)),
        7..=14 => Some(5_000_000 << (code - 7)),
        15 => Some(2_000_000),
        _ => None,
    }
}

impl Icm42688 {
    fn register(&self, register: usize) -> u8 {
        self.banks[0][register]
    }

    fn accel_ns(&self) -> Option<u64> {
        let on = self.register(PWR_MGMT0) & 2 != 0;
        period_ns(self.register(ACCEL_CONFIG0) & 0x0f).filter(|_| on)
    }

    fn gyro_ns(&self) -> Option<u64> {
        let on = self.register(PWR_MGMT0) >> 2 & 3 == 3;
        period_ns(self.register(GYRO_CONFIG0) & 0x0f).filter(|_| on)
    }

    fn temperature(&self, sampler: &Sampler) -> i16 {
        let is_off = self.register(PWR_MGMT0) & 1 << 5 != 0;
        let is_silent = self.accel_on_ns.is_none() && self.gyro_on_ns.is_none();
        if is_off || is_silent || sampler.faults.no_temperature {
            return NOTHING;
        }
        sampler.temperature(THERMOMETER_NS)
    }

    fn timestamp(&self, sampler: &Sampler) -> u16 {
        let control = self.register(TMST_CONFIG);
        let ps = TIMESTAMP_PS[usize::from(control & TMST_RES != 0)];
        if control & TMST_EN == 0 { 0 } else { (sampler.since_reset_ns() * 1000 / ps) as u16 }
    }

    fn data_bytes(&self, code: i16) -> [u8; 2] {
        let is_big = self.register(INTF_CONFIG0) & DATA_BIG_ENDIAN != 0;
        if is_big { code.to_be_bytes() } else { code.to_le_bytes() }
    }

    /// Bytes of a packet: 8 of one triad, 16 of both, 20 of both with 20 bits.
    fn packet_bytes(&self) -> usize {
        let control = self.register(FIFO_CONFIG1);
        match (control & FIFO_HIRES != 0, control & (FIFO_ACCEL | FIFO_GYRO)) {
            (_, 0) => 0,
            (true, _) => 20,
            (false, both) if both == FIFO_ACCEL | FIFO_GYRO => 16,
            _ => 8,
        }
    }

    fn batch(&self, sampler: &mut Sampler, codes: Sample, has_accel: bool, has_gyro: bool) {
        let (mode, control) = (self.register(FIFO_CONFIG) >> 6, self.register(FIFO_CONFIG1));
        let length = self.packet_bytes();
        if mode == 0 || length == 0 || sampler.faults.silent {
            return;
        }
        let both = length > 8;
        let mut packet = vec![u8::from(control & FIFO_ACCEL != 0 || both) << 6];
        packet[0] |= u8::from(control & FIFO_GYRO != 0 || both) << 5 | u8::from(length == 20) << 4;
        // an ODR timestamp
        packet[0] |= u8::from(both) << 3;
        for (bit, has, axes) in [(6, has_accel, codes.accel), (5, has_gyro, codes.gyro)] {
            if packet[0] & 1 << bit != 0 {
                let axes = if has { axes } else { [NOTHING; 3] };
                packet.extend(axes.iter().flat_map(|code| self.data_bytes(*code)));
            }
        }
        if length == 20 {
            packet.extend(self.data_bytes(codes.temperature));
        } else {
            // 2.07 instead of 132.48 LSB/K
            packet.push((codes.temperature >> 6) as u8);
        }
        if both {
            packet.extend(self.data_bytes(self.timestamp(sampler) as i16));
        }
        packet.resize(length, 0);
        let row = (has_accel && has_gyro).then(|| sampler.fifo.record(sampler.tick(), codes));
        sampler.fifo.push(packet, row, FIFO_BYTES / length, mode > 1);
    }

    fn count(&self, sampler: &Sampler) -> u16 {
        let each = if self.register(INTF_CONFIG0) & COUNT_RECORDS != 0 { 1 } else { self.packet_bytes() };
        (sampler.fifo.len() * each) as u16
    }

    /// INT_STATUS: latched events and the present state of the FIFO.
    fn status(&self, sampler: &Sampler) -> u8 {
        let [low, high] = [FIFO_CONFIG2, FIFO_CONFIG3].map(|register| self.register(register));
        let watermark = u16::from_le_bytes([low, high & 0x0f]);
        let mut status = self.events;
        if watermark > 0 && self.count(sampler) >= watermark {
            status |= FIFO_WATERMARK;
        }
        if sampler.fifo.overrun {
            status |= FIFO_FULL;
        }
        status
    }
}

impl Chip for Icm42688 {
    const REGISTER_BYTES: u8 = 1;
    const DUMMY_BYTES: [u8; 2] = [0, 0];
    const STARTS_ON_I2C: bool = false;
    const FIFO_DATA: u8 = FIFO_DATA as u8;
    const BOOT_NS: u64 = 1_000_000;
    const TICK_NS: u64 = 5_000_000;
    /// 26 °C
    const ROOM: i16 = 132;

    fn new() -> Self {
        let mut banks = [[0; 128]; 8];
        for (register, value) in RESET {
            banks[0][register] = value;
        }
        Self { banks, events: RESET_DONE, accel_on_ns: None, gyro_on_ns: None }
    }

    fn read(&mut self, sampler: &mut Sampler, register: u8) -> u16 {
        let register = usize::from(register);
        let bank = usize::from(self.register(REG_BANK_SEL) & 7);
        if bank != 0 && register != REG_BANK_SEL {
            return u16::from(self.banks[bank][register]);
        }
        let value = match register {
            WHO_AM_I => sampler.faults.identity.unwrap_or(self.register(WHO_AM_I)),
            TEMP_DATA..ACCEL_DATA => self.data_bytes(self.temperature(sampler))[register - TEMP_DATA],
            INT_STATUS => {
                let status = self.status(sampler);
                self.events = 0;
                sampler.fifo.overrun = false;
                status
            }
            FIFO_COUNT..FIFO_DATA => {
                let count = self.count(sampler);
                let is_big = self.register(INTF_CONFIG0) & COUNT_BIG_ENDIAN != 0;
                let bytes = if is_big { count.to_be_bytes() } else { count.to_le_bytes() };
                bytes[register - FIFO_COUNT]
            }
            // an empty FIFO gives a packet with this header
            FIFO_DATA => sampler.fifo.read().unwrap_or(0x80),
            FIFO_LOST_PKT0 => sampler.fifo.lost as u8,
            _ if register == FIFO_LOST_PKT0 + 1 => (sampler.fifo.lost >> 8) as u8,
            _ => self.register(register),
        };
        u16::from(value)
    }

    fn write(&mut self, sampler: &mut Sampler, register: u8, value: u16) -> bool {
        let (register, value) = (usize::from(register), value as u8);
        let bank = usize::from(self.register(REG_BANK_SEL) & 7);
        if register == REG_BANK_SEL {
            self.banks[0][REG_BANK_SEL] = value & 7;
            return false;
        }
        if bank != 0 {
            self.banks[bank][register] = value;
            return false;
        }
        let now_ns = sampler.now_ns;
        if register == DEVICE_CONFIG && value & 1 != 0 {
            return true;
        }
        let mut switched_on = [self.accel_on_ns, self.gyro_on_ns].into_iter().flatten();
        let is_busy = switched_on.any(|on_ns| now_ns < on_ns + NO_WRITE_NS);
        if register == SIGNAL_PATH_RESET && value & 2 != 0 {
            sampler.fifo.clear();
            sampler.fifo.lost = 0;
            return false;
        }
        let read_only = matches!(register, TEMP_DATA..=0x3f | WHO_AM_I) || register >= FIFO_LOST_PKT0;
        if is_busy || read_only || sampler.faults.forgetful {
            return false;
        }
        self.banks[0][register] = value;
        self.accel_on_ns = self.accel_ns().and(self.accel_on_ns.or(Some(now_ns)));
        self.gyro_on_ns = self.gyro_ns().and(self.gyro_on_ns.or(Some(now_ns)));
        // bypass, and packets of another composition
        if (register == FIFO_CONFIG && value >> 6 == 0) || register == FIFO_CONFIG1 {
            sampler.fifo.clear();
            sampler.fifo.overrun = false;
        }
        false
    }

    fn next(&self, register: u8) -> u8 {
        if usize::from(register) == FIFO_DATA { register } else { (register + 1) & 0x7f }
    }

    fn period_ns(&self) -> Option<u64> {
        self.accel_ns().into_iter().chain(self.gyro_ns()).min()
    }

    fn sample(&mut self, sampler: &mut Sampler) {
        let now_ns = sampler.now_ns;
        let started =
            |on_ns: Option<u64>, start_ns| on_ns.is_some_and(|on_ns: u64| now_ns >= on_ns + start_ns);
        let has_accel = started(self.accel_on_ns, ACCEL_START_NS);
        let has_gyro = started(self.gyro_on_ns, GYRO_START_NS);
        // packets with 20 bits are always at ±16 g and ±2000 °/s
        let is_hires = self.register(FIFO_CONFIG1) & FIFO_HIRES != 0;
        let ratio = |register: usize| {
            let code = self.register(register) >> 5;
            if is_hires { 0.25 } else { 0.25 * f64::from(1_u32 << code) }
        };
        let mut codes = sampler.sample(THERMOMETER_NS);
        codes.accel = at_range(codes.accel, ratio(ACCEL_CONFIG0));
        codes.gyro = at_range(codes.gyro, ratio(GYRO_CONFIG0));
        codes.temperature = self.temperature(sampler);
        for (first, axes, has) in [(ACCEL_DATA, codes.accel, has_accel), (GYRO_DATA, codes.gyro, has_gyro)] {
            let axes = if has { axes } else { [NOTHING; 3] };
            for (axis, code) in axes.into_iter().enumerate() {
                let bytes = self.data_bytes(code);
                self.banks[0][first + 2 * axis..][..2].copy_from_slice(&bytes);
            }
        }
        if has_accel || has_gyro {
            self.events |= DATA_READY;
        }
        self.batch(sampler, codes, has_accel, has_gyro);
    }

    /// INT_CONFIG: polarity of each pin; INT_SOURCE0 and 3: the bits of INT_STATUS that lead to it.
    fn interrupt(&self, sampler: &Sampler, pin: u8) -> bool {
        let (source, shift) = if pin == 1 { (INT_SOURCE0, 0) } else { (INT_SOURCE3, 3) };
        let active_high = self.register(INT_CONFIG) >> shift & 1 != 0;
        (self.status(sampler) & self.register(source) & 0x7f != 0) == active_high
    }
}
