//! Prints the calibration of a hand-turned log: `cargo run -p fos-calibrate --example hand -- LOG`.
use fos_calibrate::{Imu, Options, calibrate};
use fos_data::recording::{LoadOptions, load};

fn main() -> Result<(), Box<dyn std::error::Error>> {
    let path = std::env::args().nth(1).ok_or("give a log")?;
    let recording = load(path, &LoadOptions::default())?;
    let found = calibrate(&Imu::of(&recording)?, &Options::default())?;
    for parameter in &found.accelerometer.parameters {
        println!(
            "{} {:.5} ± {:.5} {} {:?}",
            parameter.label, parameter.value, parameter.half_width, parameter.unit, parameter.determined
        );
    }
    let a = &found.accelerometer;
    println!(
        "{} rests, {} used, {} orientations, rms {:?}, scatter {:.5}, noise {:.5}, worst {:.5}, next {:?}",
        a.rests.len(),
        a.used().count(),
        a.orientations,
        a.rms_mps2,
        a.scatter_mps2,
        a.noise_mps2,
        a.worst_mps2,
        a.next
    );
    for one in &a.rests {
        println!(
            "{:8.2} s {:6.2} s {:?} {:?} {:+.5}",
            one.rest.start_s,
            one.rest.duration_s,
            one.up.map(|x| (x * 100.0).round() / 100.0),
            one.rest.excluded,
            one.residual_mps2
        );
    }
    if let Some(gyro) = &found.gyro {
        println!(
            "{:?} {:?} rms {:?} dof {}",
            gyro.refused, gyro.axis_order, gyro.rms_deg, gyro.degrees_of_freedom
        );
        for p in gyro.parameters.iter().chain(&gyro.derived) {
            println!("{} {:.5} ± {:.5} {}", p.label, p.value, p.half_width, p.unit);
        }
        for t in &gyro.turns {
            println!(
                "{:?} {:.1} s {:.1} s {:.0}° {:.3}° {:?}",
                t.rests, t.start_s, t.duration_s, t.angle_deg, t.residual_deg, t.excluded
            );
        }
    }
    Ok(())
}
