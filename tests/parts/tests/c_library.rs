//! The C interface: the same part behind it.

use std::ffi::CString;
use std::ptr::null;

use fos_parts::c::{
    DELIVERED_COLUMNS, parts_advance_to, parts_delivered, parts_fault, parts_free, parts_i2c_read,
    parts_i2c_start, parts_i2c_stop, parts_i2c_write, parts_interrupt, parts_new, parts_spi_deselect,
    parts_spi_exchange, parts_spi_select, parts_stretch_ns, parts_tick,
};

#[test]
fn unknown_names_and_faults_are_refused() {
    let name = CString::new("bmi999").expect("no zero in it");
    // SAFETY: the name ends with zero, there is no log, the part is freed once
    unsafe {
        assert!(parts_new(name.as_ptr(), 0x68, null(), 0).is_null());
        parts_free(std::ptr::null_mut());
        let name = CString::new("bmi323").expect("no zero in it");
        let part = parts_new(name.as_ptr(), 0x68, null(), 0);
        assert!(parts_fault(part, 17, 1e6) && !parts_fault(part, 18, 1.0));
        assert_eq!(parts_stretch_ns(part), 1_000_000);
        parts_free(part);
    }
}

#[test]
fn log_comes_back_as_delivered() {
    let log: Vec<[i16; 7]> = (0..100).map(|n| [n, 1, 2, 3, 4, 5, 6 + n]).collect();
    let name = CString::new("bmi323").expect("no zero in it");
    // SAFETY: the name ends with zero, lengths are those of the slices, the part is freed once
    unsafe {
        let part = parts_new(name.as_ptr(), 0x68, log.as_ptr(), log.len());
        parts_advance_to(part, 5_000_000);
        let spi = |bytes: &[u8]| -> Vec<u8> {
            parts_spi_select(part, 3);
            let read = bytes.iter().map(|byte| parts_spi_exchange(part, *byte)).collect();
            parts_spi_deselect(part);
            read
        };
        spi(&[0x80, 0, 0, 0]);
        assert_eq!(spi(&[0x80, 0, 0, 0])[2], 0x43);
        for write in [[0x36, 0x00, 0x0f], [0x20, 0x19, 0x70], [0x21, 0x29, 0x70]] {
            spi(&write);
        }
        parts_advance_to(part, 500_000_000);
        assert_eq!(parts_tick(part), 100);
        assert!(!parts_interrupt(part, 1));
        let mut rows = [[0; DELIVERED_COLUMNS]; 200];
        let copied = parts_delivered(part, 0, rows.as_mut_ptr(), rows.len());
        assert_eq!(copied, 91, "after the start-up of the gyro");
        let [tick, ax, .., temperature, fate] = rows[5];
        assert_eq!((tick, fate), (15, 0));
        assert_eq!((ax, temperature), (15, 6 + 12), "the thermometer is slower");
        assert_eq!(parts_delivered(part, 80, rows.as_mut_ptr(), 3), 3);
        assert_eq!(parts_delivered(part, 1000, rows.as_mut_ptr(), 3), 0);
        // the level on I2C, after two dummy bytes
        assert!(parts_i2c_start(part, 0x68, false) && parts_i2c_write(part, 0x15));
        assert!(parts_i2c_start(part, 0x68, true));
        let level = [true, true, true, false].map(|ack| parts_i2c_read(part, ack));
        parts_i2c_stop(part);
        assert_eq!(u16::from_le_bytes([level[2], level[3]]), 8 * 99);
        parts_free(part);
    }
}
