//! Logs that give no calibration, or only part of one: each is refused or flagged by name, with the remedy.

use fos_calibrate::{CalibrateError, Determined, Exclusion, Options, Scale, TurnExclusion, calibrate};

use crate::device::{Device, Handling, faces, orientations, rng};

fn log(ups: &[[f64; 3]], handling: &Handling) -> fos_calibrate::Imu {
    let mut rng = rng(3);
    Device::random(&mut rng).log(ups, handling, &mut rng)
}

fn refused(ups: &[[f64; 3]], handling: &Handling) -> CalibrateError {
    calibrate(&log(ups, handling), &Options::default()).expect_err("refused")
}

#[test]
fn nine_orientations_for_nine_unknowns_are_refused() {
    let error = refused(&orientations(9, &mut rng(1)), &Handling::default());
    assert!(matches!(error, CalibrateError::NoRedundancy { orientations: 9, .. }), "{error}");
    let text = error.to_string();
    assert!(
        text.contains("for 9 unknowns leave no redundancy")
            && text.contains("record 3 more")
            && text.contains("one dwell with"),
        "{text}"
    );
}

/// Six faces, each three times: 18 rests, but no orientation shows the angles between the axes.
#[test]
fn six_faces_give_bias_and_sensitivity_but_no_angles() {
    let ups: Vec<[f64; 3]> = faces().into_iter().cycle().take(18).collect();
    let found = calibrate(&log(&ups, &Handling::default()), &Options::default())
        .expect("a calibration")
        .accelerometer;
    let determined: Vec<Determined> = found.parameters.iter().map(|one| one.determined).collect();
    assert_eq!(determined[..6], [Determined::Well; 6]);
    assert_eq!(determined[6..], [Determined::NotByThisLog; 3]);
    assert_eq!(found.orientations, 6);
    assert!(
        found.next.instruction.contains("edge") || found.next.instruction.contains("corner"),
        "{:?}",
        found.next
    );
    // Four orientations determine less, for any number of repetitions.
    let four: Vec<[f64; 3]> = faces().into_iter().take(4).cycle().take(20).collect();
    let error = refused(&four, &Handling::default());
    assert!(matches!(error, CalibrateError::NoRedundancy { orientations: 4, .. }), "{error}");
}

#[test]
fn rests_within_20_degrees_are_refused() {
    let near: Vec<[f64; 3]> = (0..14)
        .map(|n| {
            let (turn, tilt) = (n as f64 * 0.9, if n % 2 == 0 { 0.05_f64 } else { 0.14 });
            [tilt.sin() * turn.cos(), tilt.sin() * turn.sin(), tilt.cos()]
        })
        .collect();
    let error = refused(&near, &Handling::default());
    assert!(matches!(error, CalibrateError::OneOrientation { .. }), "{error}");
    assert!(error.to_string().contains("z pointing down"), "{error}");
}

#[test]
fn rejects_rotation_about_one_axis_only() {
    // y stays level
    let ups: Vec<[f64; 3]> = (0..14)
        .map(|n| {
            let turn = n as f64 * std::f64::consts::TAU / 14.0;
            [turn.cos(), 0.0, turn.sin()]
        })
        .collect();
    let error = refused(&ups, &Handling::default());
    let CalibrateError::NotIdentifiable { parameters, next } = &error else { panic!("{error}") };
    assert!(parameters.iter().any(|name| name.contains(" y ")), "{parameters:?}");
    assert!(next.contains("y pointing"), "{next}");
}

#[test]
fn flags_unseen_direction_with_missing_orientation() {
    let up_only: Vec<[f64; 3]> = orientations(60, &mut rng(5))
        .into_iter()
        .filter(|up| up[1] < 0.5 && up[1] > -0.55)
        .take(12)
        .collect();
    let handling = Handling { scatter: [0.002, 1e-4], ..Handling::default() };
    let found = calibrate(&log(&up_only, &handling), &Options::default()).expect("a calibration");
    assert!(
        found.accelerometer.unseen.iter().any(|face| face.starts_with('y')),
        "{:?}",
        found.accelerometer.unseen
    );
    let y = &found.accelerometer.parameters[4];
    assert!(y.id == "accelerometer.sensitivity.y" && y.determined == Determined::Weakly, "{y:?}");
    assert!(found.accelerometer.next.instruction.contains('y'), "{:?}", found.accelerometer.next);
}

#[test]
fn rests_that_move_are_excluded() {
    let handling = Handling { restless: vec![4, 9], ..Handling::default() };
    let found = calibrate(&log(&orientations(16, &mut rng(1)), &handling), &Options::default())
        .expect("a calibration");
    let moving: Vec<usize> = (0..16)
        .filter(|index| {
            let at = *index as f64 * 5.0 + 1.5;
            !found
                .accelerometer
                .used()
                .any(|one| (one.rest.start_s..one.rest.start_s + one.rest.duration_s).contains(&at))
        })
        .collect();
    assert_eq!(moving, [4, 9]);
}

#[test]
fn excludes_clipped_rests() {
    // one face at a time lies beyond the range
    let handling = Handling { full_scale: [9.7, f64::INFINITY], ..Handling::default() };
    let found = calibrate(&log(&orientations(18, &mut rng(1)), &handling), &Options::default())
        .expect("a calibration");
    let clipped = found
        .accelerometer
        .rests
        .iter()
        .filter(|one| matches!(one.rest.excluded, Some(Exclusion::Clips { .. })));
    assert!(
        clipped.count() >= 3,
        "{:?}",
        found.accelerometer.rests.iter().map(|r| &r.rest.excluded).collect::<Vec<_>>()
    );
}

#[test]
fn turns_beyond_full_scale_leave_the_accelerometer() {
    let handling = Handling { full_scale: [f64::INFINITY, 0.4], ..Handling::default() };
    let found = calibrate(&log(&orientations(14, &mut rng(1)), &handling), &Options::default())
        .expect("a calibration");
    let gyro = found.gyro.expect("a gyro");
    assert!(gyro.matrix.is_none() && gyro.parameters.len() >= 3, "bias only");
    let reason = gyro.refused.expect("a reason");
    assert!(reason.contains("faster than its full scale") && reason.contains("turn slower"), "{reason}");
    assert!(gyro.turns.iter().any(|turn| turn.excluded == Some(TurnExclusion::Clips)));
}

#[test]
fn values_that_are_not_gravity_are_refused() {
    let mut in_g = log(&orientations(14, &mut rng(1)), &Handling::default());
    for axis in &mut in_g.accelerometer.as_mut().expect("there").values {
        axis.iter_mut().for_each(|value| *value /= 9.80665);
    }
    let error = calibrate(&in_g, &Options::default()).expect_err("refused");
    assert!(
        matches!(error, CalibrateError::NotGravity { .. }) && error.to_string().contains(":g"),
        "{error}"
    );
}

#[test]
fn rejects_log_without_rests() {
    let mut shaken = log(&orientations(14, &mut rng(1)), &Handling::default());
    for axis in &mut shaken.accelerometer.as_mut().expect("there").values {
        // growing: no stretch is as quiet as another
        axis.iter_mut()
            .enumerate()
            .for_each(|(n, value)| *value += (n as f64 * 1.1).sin() * (2.0 + n as f64 * 1e-2));
    }
    assert!(calibrate(&shaken, &Options::default()).is_err());
}

/// The same device in counts: the scale is found.
#[test]
fn counts_need_no_scale() {
    let mut counts = log(&orientations(20, &mut rng(1)), &Handling::default());
    let si = calibrate(&counts, &Options::default()).expect("a calibration");
    for (axes, per, zero) in
        [(&mut counts.accelerometer, 417.0, 32_900.0), (&mut counts.gyro, 4800.0, 32_500.0)]
    {
        let axes = axes.as_mut().expect("there");
        axes.scale = Scale::Counts;
        for axis in &mut axes.values {
            axis.iter_mut().for_each(|value| *value = *value * per + zero);
        }
    }
    let found = calibrate(&counts, &Options::default()).expect("a calibration");
    for axis in 0..3 {
        let (one, other) =
            (&si.accelerometer.parameters[3 + axis], &found.accelerometer.parameters[3 + axis]);
        assert!((other.value / 417.0 - one.value).abs() < 0.1 * one.half_width, "{one:?} {other:?}");
    }
    let sensitivity = |found: &fos_calibrate::Calibration| {
        let gyro = found.gyro.as_ref().expect("a gyro");
        gyro.parameters.iter().find(|one| one.id == "gyro.sensitivity.x").expect("estimated").clone()
    };
    let (one, other) = (sensitivity(&si), sensitivity(&found));
    assert!((other.value / 4800.0 - one.value).abs() < 0.3 * one.half_width, "{one:?} {other:?}");
}

/// A gyro whose axes are exchanged is recognised.
#[test]
fn another_order_of_the_gyro_s_axes_is_reported() {
    let mut exchanged = log(&orientations(20, &mut rng(1)), &Handling::default());
    let gyro = exchanged.gyro.as_mut().expect("there");
    gyro.values.swap(0, 1);
    gyro.values[2].iter_mut().for_each(|value| *value = -*value);
    let found = calibrate(&exchanged, &Options::default()).expect("a calibration").gyro.expect("a gyro");
    assert_eq!(found.axis_order.as_deref(), Some("x is y, y is x, z is −z"), "{:?}", found.refused);
    assert!(found.matrix.is_some());
}

#[test]
fn reports_stuck_axis() {
    for (value, scale) in [(5.0, Scale::Si), (0.0, Scale::Si), (2048.0, Scale::Counts)] {
        for axis in 0..3 {
            let mut stuck = log(&orientations(14, &mut rng(1)), &Handling::default());
            let axes = stuck.accelerometer.as_mut().expect("there");
            axes.scale = scale;
            axes.values[axis].iter_mut().for_each(|one| *one = value);
            let error = calibrate(&stuck, &Options::default()).expect_err("refused").to_string();
            assert!(
                error.starts_with(&format!("{} repeats one value, {value:?}", axes_column(axis))),
                "{error}"
            );
        }
    }
}

fn axes_column(axis: usize) -> String {
    format!("a{}_mps2", ["x", "y", "z"][axis])
}

/// Nearly stuck: the noise of one axis is a millionth of the others', so that it is not recognised by its values.
#[test]
fn rejects_axis_that_hardly_changes() {
    let mut dead = log(&orientations(14, &mut rng(1)), &Handling::default());
    let axes = dead.accelerometer.as_mut().expect("there");
    axes.values[1].iter_mut().for_each(|one| *one = 5.0 + 1e-9 * *one);
    assert!(calibrate(&dead, &Options::default()).is_err());
}

#[test]
fn gyro_with_stuck_axis_has_no_result() {
    let mut dead = log(&orientations(14, &mut rng(1)), &Handling::default());
    dead.gyro.as_mut().expect("there").values[1].iter_mut().for_each(|one| *one = 0.0);
    let gyro = calibrate(&dead, &Options::default()).expect("an accelerometer").gyro.expect("a gyro");
    assert!(gyro.parameters.is_empty() && gyro.matrix.is_none());
    let reason = gyro.refused.expect("a reason");
    assert!(reason.starts_with("gy_rads repeats one value, 0.0: stuck"), "{reason}");
}

#[test]
fn large_cross_axis_angles_are_estimated() {
    let mut generator = rng(3);
    let device = Device { cosine: [0.156, -0.1, 0.05], ..Device::random(&mut generator) };
    let log = device.log(&orientations(18, &mut generator), &Handling::default(), &mut generator);
    let found = calibrate(&log, &Options::default()).expect("a calibration").accelerometer;
    for pair in 0..3 {
        let error = found.model.cosine[pair] - device.cosine[pair];
        assert!(error.abs() < 2e-3, "{pair}: {error}");
    }
}

/// 12 bits over ± 8 g, quieter than a step: at rest the axis shows one code, and at one face that is its largest.
#[test]
fn coarse_axis_at_rest_does_not_clip() {
    let handling = Handling { noise: [0.005, 0.003], ..Handling::default() };
    let mut coarse = log(&orientations(18, &mut rng(1)), &handling);
    let step = 8.0 * 9.80665 / 2048.0;
    for axis in &mut coarse.accelerometer.as_mut().expect("there").values {
        // no axis exceeds its largest code at rest
        axis.iter_mut().for_each(|value| *value = (*value / step).round().clamp(-250.0, 250.0) * step);
        let largest = (0..18)
            .flat_map(|n| &axis[n * 250 + 10..n * 250 + 140])
            .fold(0.0_f64, |largest, value| largest.max(value.abs()));
        axis.iter_mut().for_each(|value| *value = value.clamp(-largest, largest));
    }
    let found = calibrate(&coarse, &Options::default()).expect("a calibration").accelerometer;
    assert!(
        !found.rests.iter().any(|one| matches!(one.rest.excluded, Some(Exclusion::Clips { .. }))),
        "{:?}",
        found.rests.iter().map(|one| &one.rest.excluded).collect::<Vec<_>>()
    );
}
