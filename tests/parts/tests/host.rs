//! The parts as a host sees them: bytes on the bus, interrupt pins, time.

use fos_parts::{Codes, Fate, Fault, NAMES, Part, Sample, generated};

/// I2C address of every part here.
const ADDRESS: u8 = 0x6a;

/// A host with a part on both buses.
struct Host {
    part: Box<dyn Part>,
    now_ns: u64,
}

impl Host {
    /// Powers a part and waits until it has started.
    fn new(name: &str, codes: Codes) -> Self {
        let mut host =
            Self { part: fos_parts::new(name, ADDRESS, codes).expect("a part with this name"), now_ns: 0 };
        host.wait_ms(20.0);
        host.spi(&[0]);
        host
    }

    fn wait_ms(&mut self, ms: f64) {
        self.now_ns += (ms * 1e6) as u64;
        self.part.advance_to(self.now_ns);
    }

    fn spi_in_mode(&mut self, mode: u8, bytes: &[u8]) -> Vec<u8> {
        self.part.spi_select(mode);
        let read = bytes.iter().map(|byte| self.part.spi_exchange(*byte)).collect();
        self.part.spi_deselect();
        read
    }

    fn spi(&mut self, bytes: &[u8]) -> Vec<u8> {
        self.spi_in_mode(0, bytes)
    }

    /// Reads registers on SPI, without the byte of the command.
    fn read(&mut self, register: u8, bytes: usize) -> Vec<u8> {
        let command = [vec![0x80 | register], vec![0; bytes]].concat();
        self.spi(&command)[1..].to_vec()
    }

    /// Reads registers on I2C; `None` if the part does not acknowledge.
    fn i2c_read(&mut self, register: u8, bytes: usize) -> Option<Vec<u8>> {
        let answers = self.part.i2c_start(ADDRESS, false)
            && self.part.i2c_write(register)
            && self.part.i2c_start(ADDRESS, true);
        let read = answers.then(|| (1..=bytes).map(|n| self.part.i2c_read(n < bytes)).collect());
        self.part.i2c_stop();
        read
    }

    fn write(&mut self, writes: &[&[u8]]) {
        for write in writes {
            self.spi(write);
            self.wait_ms(1.0);
        }
    }

    /// Sets up FIFO and both sensors at ±4 g, ±500 °/s and 200 Hz (LSM6DSO: 208 Hz); the watermark, ten samples, goes to
    /// pin 1, active high.
    fn set_up(name: &str, codes: Codes) -> Self {
        let mut host = Self::new(name, codes);
        let writes: &[&[u8]] = match name {
            "bmi323" => &[
                &[0x36, 0x00, 0x0f],
                &[0x35, 80, 0],
                &[0x38, 0x05, 0x00],
                &[0x3b, 0x00, 0x10],
                &[0x20, 0x19, 0x70],
                &[0x21, 0x29, 0x70],
                &[0x37, 1, 0],
            ],
            "lsm6dsv16x" => &[
                &[0x13, 0x08],
                &[0x15, 0x02],
                &[0x17, 0x01],
                &[0x62, 0x02],
                &[0x50, 0x40],
                &[0x07, 30],
                &[0x09, 0x77],
                &[0x0d, 0x08],
                &[0x10, 0x17],
                &[0x11, 0x17],
                &[0x0a, 0x46],
            ],
            "lsm6dso" => &[
                &[0x12, 0x44],
                &[0x13, 0x08],
                &[0x19, 0x20],
                &[0x07, 30],
                &[0x09, 0x55],
                &[0x0d, 0x08],
                &[0x10, 0x58],
                &[0x11, 0x54],
                &[0x0a, 0x46],
            ],
            _ => &[
                &[0x4f, 0x47],
                &[0x50, 0x47],
                &[0x54, 0x29],
                &[0x5f, 0x0f],
                &[0x60, 160],
                &[0x14, 0x01],
                &[0x65, 0x04],
                &[0x4e, 0x0f],
                &[0x16, 0x40],
            ],
        };
        host.write(writes);
        host
    }

    /// Reads `samples` samples from the FIFO: accelerometers and gyros; `None` before the sensors have started.
    fn samples(&mut self, name: &str, samples: usize) -> Vec<Option<([i16; 3], [i16; 3])>> {
        let axes = |bytes: &[u8], big: bool| {
            let code = |n: usize| {
                let pair = [bytes[2 * n], bytes[2 * n + 1]];
                if big { i16::from_be_bytes(pair) } else { i16::from_le_bytes(pair) }
            };
            [code(0), code(1), code(2)]
        };
        match name {
            "bmi323" => {
                let bytes = self.read(0x16, 1 + 16 * samples);
                let frames = bytes[1..].chunks(16);
                frames
                    .map(|frame| {
                        let (accel, gyro) = (axes(frame, false), axes(&frame[6..], false));
                        (accel[0] != 0x7f01 && gyro[0] != 0x7f02).then_some((accel, gyro))
                    })
                    .collect()
            }
            "icm42688" => {
                let bytes = self.read(0x30, 16 * samples);
                let packets = bytes.chunks(16);
                packets
                    .map(|packet| {
                        assert_eq!(packet[0], 0x68);
                        let (accel, gyro) = (axes(&packet[1..], true), axes(&packet[7..], true));
                        (accel[0] != i16::MIN && gyro[0] != i16::MIN).then_some((accel, gyro))
                    })
                    .collect()
            }
            _ => {
                // gyro, accelerometer, timestamp
                let bytes = self.read(0x78, 21 * samples);
                let instants = bytes.chunks(21);
                instants
                    .map(|words| {
                        assert_eq!([words[0] >> 3, words[7] >> 3, words[14] >> 3], [1, 2, 4]);
                        let (gyro, accel) = (axes(&words[1..], false), axes(&words[8..], false));
                        (accel[0] < 0x7ffd && gyro[0] < 0x7ffd).then_some((accel, gyro))
                    })
                    .collect()
            }
        }
    }
}

/// Register with the identity, dummy bytes on SPI and I2C, and the identity.
fn identity(name: &str) -> (u8, [usize; 2], u8) {
    match name {
        "bmi323" => (0x00, [1, 2], 0x43),
        "lsm6dsv16x" => (0x0f, [0, 0], 0x70),
        "lsm6dso" => (0x0f, [0, 0], 0x6c),
        _ => (0x75, [0, 0], 0x47),
    }
}

#[test]
fn every_part_identifies_itself_on_both_buses() {
    for name in NAMES {
        let mut host = Host::new(name, Codes::Generated);
        let (register, [spi, i2c], identity) = identity(name);
        assert_eq!(host.read(register, spi + 1)[spi], identity, "{name}");
        assert_eq!(host.i2c_read(register, i2c + 1).expect("an acknowledge")[i2c], identity, "{name}");
        assert!(!host.part.i2c_start(ADDRESS + 1, false), "{name}");
        host.part.fault(Fault::Identity, 66.0);
        assert_eq!(host.read(register, spi + 1)[spi], 66, "{name}");
    }
}

#[test]
fn spi_modes_0_and_3_are_understood() {
    for name in NAMES {
        let (register, [dummy, _], identity) = identity(name);
        for mode in 0..4 {
            let mut host = Host::new(name, Codes::Generated);
            let command = [vec![0x80 | register], vec![0; dummy + 1]].concat();
            let read = host.spi_in_mode(mode, &command)[dummy + 1];
            assert_eq!(read == identity, matches!(mode, 0 | 3), "{name}, mode {mode}");
        }
    }
}

#[test]
fn bmi323_is_on_i2c_until_cs_rises() {
    let mut part = fos_parts::new("bmi323", ADDRESS, Codes::Generated).expect("a BMI323");
    let id = |part: &mut Box<dyn Part>| {
        part.spi_select(0);
        let read = [0x80, 0, 0].map(|byte| part.spi_exchange(byte))[2];
        part.spi_deselect();
        read
    };
    part.advance_to(5_000_000);
    assert_eq!([id(&mut part), id(&mut part)], [0xff, 0x43]);
    part.fault(Fault::Reset, 1.0);
    part.advance_to(10_000_000);
    assert_eq!([id(&mut part), id(&mut part)], [0xff, 0x43]);
}

#[test]
fn does_not_answer_while_it_boots() {
    for name in NAMES {
        let mut host = Host::new(name, Codes::Generated);
        let (register, [_, dummy], identity) = identity(name);
        host.part.fault(Fault::Reset, 1.0);
        assert_eq!(host.i2c_read(register, 1), None, "{name}");
        host.wait_ms(11.0);
        assert_eq!(host.i2c_read(register, dummy + 1).expect("an acknowledge")[dummy], identity, "{name}");
    }
}

#[test]
fn feature_engine_of_the_bmi323_starts_on_its_command() {
    let mut host = Host::new("bmi323", Codes::Generated);
    let status = |host: &mut Host| host.read(0x11, 3)[1] & 0x0f;
    host.write(&[&[0x40, 1, 0]]);
    assert_eq!(status(&mut host), 0, "without its configuration");
    host.spi(&[0x12, 0x2c, 0x01]);
    host.spi(&[0x14, 1, 0]);
    host.spi(&[0x40, 1, 0]);
    assert_eq!(status(&mut host), 1);
    host.wait_ms(3.0);
    assert_eq!(status(&mut host), 5);
}

#[test]
fn fifo_gives_the_codes_recorded_as_delivered() {
    for name in NAMES {
        let mut host = Host::set_up(name, Codes::Generated);
        while !host.part.interrupt(1) {
            host.wait_ms(1.0);
        }
        host.wait_ms(300.0);
        let samples: Vec<_> = host.samples(name, 40).into_iter().flatten().collect();
        assert!((24..39).contains(&samples.len()), "{name}: the gyro starts later; {}", samples.len());
        let delivered = host.part.delivered();
        for (row, (accel, gyro)) in delivered.iter().zip(&samples) {
            assert_eq!((row.codes.accel, row.codes.gyro), (*accel, *gyro), "{name}");
            assert_eq!(generated(row.tick), (*accel, *gyro), "{name}");
            assert_eq!(row.fate, Fate::Read, "{name}");
        }
        assert!(delivered[samples.len()..].iter().all(|row| row.fate == Fate::Queued), "{name}");
        assert!(delivered.windows(2).all(|rows| rows[1].tick == rows[0].tick + 1), "{name}");
    }
}

#[test]
fn watermark_drives_the_interrupt_pin() {
    for name in NAMES {
        let mut host = Host::set_up(name, Codes::Generated);
        host.wait_ms(20.0);
        assert!(!host.part.interrupt(1), "{name}");
        host.wait_ms(40.0);
        assert!(host.part.interrupt(1), "{name}");
        host.samples(name, 10);
        assert!(!host.part.interrupt(1), "{name}");
        host.part.fault(Fault::Pin, 2.0);
        assert!(host.part.interrupt(1), "{name}: stuck");
    }
}

#[test]
fn full_fifo_overwrites_the_oldest_samples() {
    for (name, samples) in [("bmi323", 128), ("lsm6dsv16x", 85), ("lsm6dso", 170), ("icm42688", 128)] {
        let mut host = Host::set_up(name, Codes::Generated);
        host.wait_ms(3000.0);
        let delivered = host.part.delivered();
        let queued = delivered.iter().rev().take_while(|row| row.fate == Fate::Queued).count();
        assert_eq!(queued, samples, "{name}");
        assert!(delivered[..delivered.len() - queued].iter().all(|row| row.fate == Fate::Lost), "{name}");
    }
}

#[test]
fn full_fifo_stops_if_it_is_told_to() {
    let mut host = Host::new("bmi323", Codes::Generated);
    host.write(&[&[0x36, 0x01, 0x0f], &[0x20, 0x19, 0x70], &[0x21, 0x29, 0x70]]);
    host.wait_ms(3000.0);
    assert_eq!(host.read(0x15, 3)[1..], [0x00, 0x04], "1024 words");
    let queued = host.part.delivered().iter().take_while(|row| row.fate == Fate::Queued).count();
    assert!((115..128).contains(&queued), "{queued}: the first frames have no gyro");
}

#[test]
fn log_is_played_tick_by_tick_and_clipped_at_full_scale() {
    let row = |n: i16| Sample { accel: [n, 20_000, -20_000], gyro: [0, n, 32_767], temperature: 300 + n };
    let mut host = Host::set_up("lsm6dsv16x", Codes::Log((0..10).map(row).collect()));
    // ±2 g is twice as sensitive
    host.write(&[&[0x17, 0x00]]);
    host.wait_ms(200.0);
    let delivered = host.part.delivered();
    assert!(delivered.len() > 20);
    for row in &delivered[1..] {
        let n = (row.tick % 10) as i16;
        assert_eq!(row.codes.accel, [2 * n, 32_767, -32_768]);
        assert_eq!(row.codes.gyro, [0, n, 32_767]);
    }
}

#[test]
fn thermometer_has_its_own_rate() {
    let row = |n: i16| Sample { accel: [0; 3], gyro: [0; 3], temperature: n };
    let mut host = Host::set_up("bmi323", Codes::Log((0..1000).map(row).collect()));
    host.wait_ms(500.0);
    let temperatures: Vec<i16> = host.part.delivered().iter().map(|row| row.codes.temperature).collect();
    // 50 Hz: every fourth sample
    assert!(temperatures.iter().all(|code| code % 4 == 0), "{temperatures:?}");
    host.part.fault(Fault::NoTemperature, 1.0);
    assert_eq!(host.read(0x09, 3)[1..], [0x00, 0x80]);
}

#[test]
fn delivered_temperature_is_that_of_the_fifo() {
    let row = |n: i16| Sample { accel: [0; 3], gyro: [0; 3], temperature: n };
    let mut host = Host::set_up("lsm6dsv16x", Codes::Log((0..1000).map(row).collect()));
    // FIFO_CTRL4: temperatures 15 times per second, in bypass and then in stream mode
    host.write(&[&[0x0a, 0x60], &[0x0a, 0x66]]);
    host.wait_ms(500.0);
    let temperatures: Vec<i16> = host.part.delivered().iter().map(|row| row.codes.temperature).collect();
    let changes = temperatures.windows(2).filter(|pair| pair[0] != pair[1]).count();
    assert!((6..=8).contains(&changes), "{temperatures:?}");
}

#[test]
fn clock_is_off_and_drifts() {
    for name in NAMES {
        let ticks = |ppm: f64, drift: f64| {
            let mut host = Host::set_up(name, Codes::Generated);
            let before = host.part.tick();
            host.part.fault(Fault::Ppm, ppm);
            host.part.fault(Fault::Drift, drift);
            host.wait_ms(48_000.0);
            host.part.tick() - before
        };
        let nominal = ticks(0.0, 0.0) as f64;
        assert!((ticks(50_000.0, 0.0) as f64 - 1.05 * nominal).abs() <= 1.0, "{name}");
        assert!((ticks(-50_000.0, 0.0) as f64 - 0.95 * nominal).abs() <= 1.0, "{name}");
        // 48 s of 1000 ppm/s: 2.4 % on average
        assert!((ticks(0.0, 1000.0) as f64 - 1.024 * nominal).abs() <= 1.0, "{name}");
    }
}

#[test]
fn faults_of_the_bus_end() {
    for name in NAMES {
        let mut host = Host::new(name, Codes::Generated);
        let (register, [spi, i2c], identity) = identity(name);
        let ids = |host: &mut Host| {
            let id = host.i2c_read(register, i2c + 1).map(|bytes| bytes[i2c]);
            (host.read(register, spi + 1)[spi], id)
        };
        host.part.fault(Fault::StuckHigh, 1.0);
        assert_eq!(ids(&mut host), (0xff, None), "{name}");
        host.part.fault(Fault::StuckHigh, 0.0);
        host.part.fault(Fault::StuckLow, 1.0);
        assert_eq!(ids(&mut host), (0, Some(0)), "{name}");
        host.part.fault(Fault::None, 0.0);
        host.part.fault(Fault::Unanswered, 5e6);
        assert_eq!(ids(&mut host), (0xff, None), "{name}");
        host.wait_ms(5.0);
        assert_eq!(ids(&mut host), (identity, Some(identity)), "{name}");
        host.part.fault(Fault::Nack, 1.0);
        assert_eq!(ids(&mut host), (identity, None), "{name}");
        assert_eq!(ids(&mut host), (identity, Some(identity)), "{name}");
        host.part.fault(Fault::Flip, 1.0);
        let (flipped, _) = ids(&mut host);
        assert_eq!((flipped ^ identity).count_ones(), 1, "{name}: one bit a byte");
    }
}

#[test]
fn stretches_the_clock_only_if_it_is_told_to() {
    for name in NAMES {
        let mut host = Host::new(name, Codes::Generated);
        assert_eq!(host.part.stretch_ns(), 0);
        host.part.fault(Fault::Stretch, 50_000.0);
        assert_eq!(host.part.stretch_ns(), 50_000);
    }
}
