//! The hand-turned log of an Xsens MTi in raw counts, whose factory certificate is public (imu_tk_matlab, calibrate.m).

use fos_calibrate::{Calibration, Gravity, Imu, Options, Parameter, calibrate};
use fos_data::recording::{LoadOptions, load};
use rand::seq::SliceRandom as _;

use crate::device::rng;

fn xsens() -> Option<Imu> {
    let path = fos_testkit::outside::path("data/xsens_mti_multipose_100hz_rawcounts.csv.gz")?;
    Some(Imu::of(&load(path, &LoadOptions::default()).expect("a log")).expect("six axes"))
}

/// Padua: the laboratory of the log's authors, an assumption.
fn options() -> Options {
    Options { gravity: Gravity::at(45.4, 12.0), ..Options::default() }
}

fn all(found: &Calibration) -> Vec<&Parameter> {
    let gyro = found.gyro.as_ref().expect("a gyro");
    found.accelerometer.parameters.iter().chain(&gyro.parameters).chain(&gyro.derived).collect()
}

#[test]
fn xsens_agrees_with_its_factory_certificate() {
    let Some(imu) = xsens() else { return };
    let found = calibrate(&imu, &options()).expect("a calibration");
    assert!((36..=40).contains(&found.accelerometer.used().count()));
    // value, bar, rounding of the certificate: relative for sensitivities, ° for angles
    let certificate = [
        ("accelerometer.sensitivity.x", 415.02, 0.0015, 0.0012),
        ("accelerometer.sensitivity.y", 413.04, 0.0015, 0.0012),
        ("accelerometer.sensitivity.z", 415.10, 0.0015, 0.0012),
        ("accelerometer.angle.xy", 89.43, 0.5, 0.4),
        ("accelerometer.angle.xz", 89.43, 0.5, 0.3),
        ("accelerometer.angle.yz", 88.84, 0.5, 0.3),
        ("gyro.sensitivity.x", 4779.2, 0.0025, 0.0012),
        ("gyro.sensitivity.y", 4761.8, 0.0025, 0.0012),
        ("gyro.sensitivity.z", 4766.5, 0.0025, 0.0012),
        ("gyro.angle.xy", 90.62, 0.5, 0.3),
        ("gyro.angle.xz", 91.72, 0.5, 0.3),
        ("gyro.angle.yz", 87.14, 0.5, 0.3),
        ("gyro.to_accelerometer.x", 0.81, 0.5, 0.3),
        ("gyro.to_accelerometer.y", 1.81, 0.5, 0.3),
        ("gyro.to_accelerometer.z", 1.72, 0.5, 0.3),
    ];
    for (id, factory, bar, rounding) in certificate {
        let one = all(&found).into_iter().find(|one| one.id == id).expect(id);
        let size = if id.contains("sensitivity") { factory } else { 1.0 };
        println!(
            "{id:28} {:9.3} ± {:.3}, factory {factory}: {:+.3} {}",
            one.value,
            one.half_width,
            (one.value - factory) / size * if size == 1.0 { 1.0 } else { 100.0 },
            if size == 1.0 { "°" } else { "%" }
        );
        assert!((one.value - factory).abs() <= bar * size, "{id}: {one:?}");
        assert!(one.holds(factory, rounding * size), "{id}: {one:?}");
    }
    let rms = found.accelerometer.rms_mps2[0].expect("rests");
    assert!(rms < 1.2e-3, "{rms}");
}

/// Twelve of the rests, twenty draws: the other rests are blanked out.
#[test]
fn twelve_rests_agree_with_all() {
    let Some(imu) = xsens() else { return };
    let full = calibrate(&imu, &options()).expect("a calibration");
    let rests: Vec<_> = full.accelerometer.rests.iter().map(|one| one.rest.rows.clone()).collect();
    let (mut held, mut count, mut refused) = (0, 0, Vec::new());
    let mut half_widths = 0.0;
    for seed in 0..20 {
        let mut order: Vec<usize> = (0..rests.len()).collect();
        order.shuffle(&mut rng(seed));
        let mut some = imu.clone();
        for &index in &order[12..] {
            for axis in &mut some.accelerometer.as_mut().expect("there").values {
                // wider than the margins of the rest
                let rows = rests[index].start.saturating_sub(40)..rests[index].end + 40;
                axis[rows].fill(f64::NAN);
            }
        }
        match calibrate(&some, &options()) {
            Ok(found) => {
                for (one, all) in found.accelerometer.parameters.iter().zip(&full.accelerometer.parameters) {
                    held += usize::from(one.holds(all.value, 0.0));
                    count += 1;
                    half_widths += one.half_width / all.half_width;
                }
            }
            Err(error) => refused.push(error.to_string()),
        }
    }
    let share = held as f64 / count as f64;
    println!(
        "12 of {} rests, 20 draws: {held} of {count} intervals hold the estimate of all rests ({:.1} %), {:.1} times as wide; refused: {refused:?}",
        rests.len(),
        100.0 * share,
        half_widths / count as f64
    );
    assert!((0.90..=0.995).contains(&share), "{share}");
    assert!(refused.len() <= 4, "{refused:?}");
}
