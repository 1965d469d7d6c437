//! Formulas of the effects, on the true covariates: the simulator's own, in plain loops and independent of the code
//! under test.

use super::axis::Axis;
use super::effect::Effect;
use super::world::World;

/// Reference points of the covariates, from the log to explain.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(super) struct Anchor {
    /// Middle and half of the range of the temperature, °C and K.
    pub(super) temp: [f64; 2],
    /// Middle and half of the range of the supply, V.
    pub(super) supply: [f64; 2],
    /// Middle and half of the range of the load, %.
    pub(super) load: [f64; 2],
    /// Largest true value of the target, in its unit; 1 if it is zero throughout.
    pub(super) largest: f64,
}

impl Anchor {
    pub(super) fn of(field: &World, target: Axis) -> Self {
        let middle = |values: &[f64]| {
            let (low, high) =
                values.iter().fold((f64::MAX, f64::MIN), |(low, high), x| (low.min(*x), high.max(*x)));
            [0.5 * (low + high), (0.5 * (high - low)).max(1e-9)]
        };
        let largest = field.truth(target).iter().fold(0.0, |largest: f64, x| largest.max(x.abs()));
        Self {
            temp: middle(&field.temp_c),
            supply: middle(&field.supply_v),
            load: middle(&field.load_pct),
            largest: if largest > 0.0 { largest } else { 1.0 },
        }
    }
}

pub(super) type NamedSeries = (String, Vec<f64>);

/// Columns whose weighted sum is the error of a slow effect of the library, or of a line; empty for random effects.
pub(super) fn regressors(
    effect: Effect,
    parameter: f64,
    world: &World,
    target: Axis,
    anchor: &Anchor,
) -> Vec<NamedSeries> {
    let n = world.len();
    let dt = world.period_s;
    let truth = || world.truth(target).to_vec();
    let one = |name: &str, values: Vec<f64>| vec![(name.to_owned(), values)];
    let three = |name: &str, columns: &[Vec<f64>; 3]| -> Vec<NamedSeries> {
        ["x", "y", "z"].iter().zip(columns).map(|(axis, c)| (format!("{name}_{axis}"), c.clone())).collect()
    };
    match effect {
        Effect::TempLinear => one("temp_k", map(&world.temp_c, |t| t - anchor.temp[0])),
        Effect::TempPoly => (1..=3)
            .map(|power| {
                let x = map(&world.temp_c, |t| ((t - anchor.temp[0]) / anchor.temp[1]).powi(power));
                (format!("temp_scaled_{power}"), x)
            })
            .collect(),
        Effect::ThermalLag => {
            one("temp_lagged_k", map(&low_pass(&world.temp_c, parameter, dt), |t| t - anchor.temp[0]))
        }
        Effect::TempRate => one("temp_rate_k_per_s", rate(&world.temp_c, dt)),
        Effect::ThermalHysteresis => one("temp_play_k", play_less_input(&world.temp_c, parameter)),
        Effect::WarmupExp => one("warmup", (0..n).map(|k| (-(k as f64) * dt / parameter).exp()).collect()),
        Effect::LogCreep => one("creep", (0..n).map(|k| (1.0 + k as f64 * dt / parameter).ln()).collect()),
        Effect::BiasRamp => one("time_s", (0..n).map(|k| k as f64 * dt).collect()),
        Effect::BiasStep => {
            one("step", (0..n).map(|k| f64::from(u8::from(k as f64 * dt > parameter))).collect())
        }
        Effect::SupplySensitivity => one("supply_v", map(&world.supply_v, |v| v - anchor.supply[0])),
        Effect::LoadHeating => one("load_lagged_pct", low_pass(&world.load_pct, parameter, dt)),
        Effect::MagSensitivity => three("field_ut", &world.field_ut),
        Effect::GSensitivity => three("force_mps2", &world.force_mps2),
        Effect::VibrationRectification => one("vibration_mps2_squared", world.vibration.clone()),
        Effect::SfError => one("ref", truth()),
        Effect::SfNonlinearity => (2..=3)
            .map(|p| (format!("ref_scaled_{p}"), map(&truth(), |x| (x / anchor.largest).powi(p))))
            .collect(),
        Effect::SfAsymmetry => one("ref_abs", map(&truth(), f64::abs)),
        Effect::SfTemp => {
            let pairs = world.truth(target).iter().zip(&world.temp_c);
            one("ref_times_k", pairs.map(|(x, t)| x * (t - anchor.temp[0])).collect())
        }
        Effect::CrossAxis => Axis::ALL
            .into_iter()
            .filter(|axis| axis.is_gyro() == target.is_gyro() && *axis != target)
            .map(|axis| (format!("ref_{}", axis.column()), world.truth(axis).to_vec()))
            .collect(),
        Effect::LeverArm => lever_arm(world, target.direction()),
        Effect::SpectralLine => {
            let phase = |k: usize| std::f64::consts::TAU * parameter * k as f64 * dt;
            vec![
                ("line_sin".to_owned(), (0..n).map(|k| phase(k).sin()).collect()),
                ("line_cos".to_owned(), (0..n).map(|k| phase(k).cos()).collect()),
            ]
        }
        Effect::DriftingLine
        | Effect::Saturation
        | Effect::DroppedSamples
        | Effect::Quantisation
        | Effect::GaussMarkov
        | Effect::RateRandomWalk
        | Effect::RandomTelegraph
        | Effect::NoiseTemperature
        | Effect::DeadZone
        | Effect::Outside(_) => Vec::new(),
    }
}

fn map(values: &[f64], f: impl Fn(f64) -> f64) -> Vec<f64> {
    values.iter().map(|x| f(*x)).collect()
}

/// First-order low-pass, in equilibrium at the first value.
pub(super) fn low_pass(values: &[f64], tau_s: f64, dt: f64) -> Vec<f64> {
    let gain = 1.0 - (-dt / tau_s).exp();
    let mut state = values.first().copied().unwrap_or(0.0);
    values
        .iter()
        .map(|x| {
            state += gain * (x - state);
            state
        })
        .collect()
}

/// Difference from the previous sample, per second; zero at the first.
fn rate(values: &[f64], dt: f64) -> Vec<f64> {
    let mut last = values.first().copied().unwrap_or(0.0);
    values
        .iter()
        .map(|x| {
            let rate = (x - last) / dt;
            last = *x;
            rate
        })
        .collect()
}

/// Backlash of half width r about the input, minus the input; centred at the first value.
fn play_less_input(values: &[f64], half_width: f64) -> Vec<f64> {
    let mut play = values.first().copied().unwrap_or(0.0);
    values
        .iter()
        .map(|x| {
            play = play.clamp(x - half_width, x + half_width);
            play - x
        })
        .collect()
}

/// ω × (ω × r) + dω/dt × r along axis i, one column for each component of r, m/s² per m.
fn lever_arm(world: &World, i: usize) -> Vec<NamedSeries> {
    let (j, k) = ((i + 1) % 3, (i + 2) % 3);
    let omega = &world.rate_rads;
    let alpha = omega.each_ref().map(|rates| rate(rates, world.period_s));
    let rows = 0..world.len();
    let along_i = rows.clone().map(|n| -(omega[j][n].powi(2) + omega[k][n].powi(2))).collect();
    let along_j = rows.clone().map(|n| omega[i][n] * omega[j][n] - alpha[k][n]).collect();
    let along_k = rows.map(|n| omega[i][n] * omega[k][n] + alpha[j][n]).collect();
    let name = |axis: usize| format!("lever_{}", ["x", "y", "z"][axis]);
    vec![(name(i), along_i), (name(j), along_j), (name(k), along_k)]
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn lever_arm_equals_the_cross_products() {
        let rates = [[0.1, 0.3], [-0.2, 0.5], [0.7, 0.4]];
        let world = World {
            period_s: 0.5,
            rate_rads: rates.map(|r| r.to_vec()),
            temp_c: vec![0.0; 2],
            ..World::default()
        };
        let cross = |a: [f64; 3], b: [f64; 3]| {
            [a[1] * b[2] - a[2] * b[1], a[2] * b[0] - a[0] * b[2], a[0] * b[1] - a[1] * b[0]]
        };
        let (omega, r) = (rates.map(|rate| rate[1]), [0.02, -0.03, 0.05]);
        let alpha = rates.map(|rate| (rate[1] - rate[0]) / 0.5);
        let (centripetal, tangential) = (cross(omega, cross(omega, r)), cross(alpha, r));
        for i in 0..3 {
            let columns = lever_arm(&world, i);
            let sum: f64 = (0..3).map(|k| columns[k].1[1] * r[(i + k) % 3]).sum();
            assert!((sum - centripetal[i] - tangential[i]).abs() < 1e-15);
        }
    }

    #[test]
    fn play_follows_with_its_half_width() {
        let found = play_less_input(&[0.0, 0.5, 2.0, 1.5, -1.0], 1.0);
        assert_eq!(found, [0.0, -0.5, -1.0, -0.5, 1.0]);
    }
}
