//! A simulated device that a hand lays down in one orientation after the other. Its formulas are independent of the crate's.

use fos_calibrate::{Axes, Imu, Scale};
use nalgebra::{Matrix3, Rotation3, SymmetricEigen, Unit, Vector3};
use rand::{RngExt as _, SeedableRng as _};
use rand_chacha::ChaCha8Rng;
use rand_distr::{Distribution as _, Normal, StandardNormal, UnitSphere};

/// Gravity of the simulation, m/s².
pub(crate) const G: f64 = 9.80665;

/// The truth about a device.
#[derive(Debug, Clone)]
pub(crate) struct Device {
    pub(crate) bias: [f64; 3],
    pub(crate) sensitivity: [f64; 3],
    /// Cosines of the angles between the axes xy, xz, yz.
    pub(crate) cosine: [f64; 3],
    pub(crate) gyro_bias: [f64; 3],
    /// Rows: what each axis of the gyro shows of a rate in the frame of the accelerometer.
    pub(crate) gyro: Matrix3<f64>,
    /// Gyro bias per m/s².
    pub(crate) by_g: Matrix3<f64>,
    /// Accelerometer bias per K, m/s²/K, and relative sensitivity per K.
    pub(crate) bias_per_k: [f64; 3],
    pub(crate) sensitivity_per_k: [f64; 3],
}

/// Conditions of the recording.
#[derive(Debug, Clone)]
pub(crate) struct Handling {
    pub(crate) rate_hz: f64,
    pub(crate) rest_s: f64,
    pub(crate) turn_s: f64,
    /// Standard deviation of a sample, m/s² and rad/s.
    pub(crate) noise: [f64; 2],
    /// Scatter of the bias from rest to rest, m/s² and rad/s.
    pub(crate) scatter: [f64; 2],
    /// Gravity, m/s².
    pub(crate) g: f64,
    /// Temperature of each rest, °C; none: constant and not logged.
    pub(crate) temperature_c: Option<[f64; 2]>,
    /// Values at which the accelerometer clips, m/s², and the gyro, rad/s.
    pub(crate) full_scale: [f64; 2],
    /// Rests that keep turning, rad/s.
    pub(crate) restless: Vec<usize>,
}

impl Default for Handling {
    fn default() -> Self {
        Self {
            rate_hz: 50.0,
            rest_s: 3.0,
            turn_s: 2.0,
            noise: [0.02, 0.003],
            scatter: [0.004, 2e-4],
            g: G,
            temperature_c: None,
            full_scale: [f64::INFINITY; 2],
            restless: Vec::new(),
        }
    }
}

fn draw(rng: &mut ChaCha8Rng, deviation: f64) -> f64 {
    Normal::new(0.0, deviation).expect("a deviation").sample(rng)
}

fn three(rng: &mut ChaCha8Rng, mean: f64, deviation: f64) -> [f64; 3] {
    [0; 3].map(|_| mean + draw(rng, deviation))
}

impl Device {
    /// A consumer part: 0.2 m/s² of bias, 1 % of sensitivity, 0.5° of cross-axis.
    pub(crate) fn random(rng: &mut ChaCha8Rng) -> Self {
        let sensitivity = three(rng, 1.0, 0.01);
        let entries: Vec<f64> = (0..9).map(|_| draw(rng, 0.008)).collect();
        Self {
            bias: three(rng, 0.0, 0.2),
            sensitivity,
            cosine: three(rng, 0.0, 0.008),
            gyro_bias: three(rng, 0.0, 0.01),
            gyro: Matrix3::identity() + Matrix3::from_row_slice(&entries),
            by_g: Matrix3::zeros(),
            bias_per_k: [0.0; 3],
            sensitivity_per_k: [0.0; 3],
        }
    }

    /// The unit vectors of the accelerometer's axes, one per row: the symmetric root of their cosines.
    pub(crate) fn axes(&self) -> Matrix3<f64> {
        let [xy, xz, yz] = self.cosine;
        let eigen = SymmetricEigen::new(Matrix3::new(1.0, xy, xz, xy, 1.0, yz, xz, yz, 1.0));
        let roots = Matrix3::from_diagonal(&eigen.eigenvalues.map(f64::sqrt));
        eigen.eigenvectors * roots * eigen.eigenvectors.transpose()
    }

    fn force(&self, a: &Vector3<f64>, kelvin: f64) -> [f64; 3] {
        let along = self.axes() * a;
        [0, 1, 2].map(|i| {
            self.sensitivity[i] * (1.0 + self.sensitivity_per_k[i] * kelvin) * along[i]
                + self.bias[i]
                + self.bias_per_k[i] * kelvin
        })
    }

    /// The log of a device laid down with each of `ups` pointing up, in turn.
    pub(crate) fn log(&self, ups: &[[f64; 3]], handling: &Handling, rng: &mut ChaCha8Rng) -> Imu {
        let dt = 1.0 / handling.rate_hz;
        let (rest, turn) = ((handling.rest_s / dt) as usize, (handling.turn_s / dt) as usize);
        let mut accelerometer = [Vec::new(), Vec::new(), Vec::new()];
        let mut gyro = [Vec::new(), Vec::new(), Vec::new()];
        let mut temperature = Vec::new();
        // from space to the device
        let mut attitude = Rotation3::rotation_between(&Vector3::z(), &Vector3::from(ups[0]))
            .unwrap_or_else(|| Rotation3::from_axis_angle(&Vector3::x_axis(), std::f64::consts::PI));
        let celsius = |index: usize| {
            handling.temperature_c.map(|[low, high]| {
                // warms and cools again, so that temperature and orientation are not confounded
                let phase = index as f64 / ups.len() as f64;
                low + (high - low) * (2.5 * std::f64::consts::TAU * phase).sin().powi(2)
            })
        };
        let mut push =
            |a: Vector3<f64>, w: Vector3<f64>, scatter: &[[f64; 3]; 2], kelvin: f64, rng: &mut ChaCha8Rng| {
                let force = self.force(&a, kelvin);
                let rate = self.gyro * w + self.by_g * a;
                for axis in 0..3 {
                    let noise: [f64; 2] = [StandardNormal.sample(rng), StandardNormal.sample(rng)];
                    let value = force[axis] + scatter[0][axis] + handling.noise[0] * noise[0];
                    accelerometer[axis].push(value.clamp(-handling.full_scale[0], handling.full_scale[0]));
                    let value =
                        rate[axis] + self.gyro_bias[axis] + scatter[1][axis] + handling.noise[1] * noise[1];
                    gyro[axis].push(value.clamp(-handling.full_scale[1], handling.full_scale[1]));
                }
            };
        for (index, up) in ups.iter().enumerate() {
            let scatter = handling.scatter.map(|deviation| three(rng, 0.0, deviation));
            let kelvin = celsius(index).map_or(0.0, |celsius| celsius - 25.0);
            for n in 0..rest {
                let spin = if handling.restless.contains(&index) { 0.02 * n as f64 * dt } else { 0.0 };
                let axis = Unit::new_normalize(Vector3::new(1.0, 0.3, -0.2).cross(&Vector3::from(*up)));
                let tilted = Rotation3::from_axis_angle(&axis, spin) * attitude;
                push(tilted * Vector3::z() * handling.g, Vector3::zeros(), &scatter, kelvin, rng);
                temperature.push(25.0 + kelvin);
            }
            let Some(next) = ups.get(index + 1) else { break };
            // the shortest turn, and one about the vertical, as hands do
            let shortest = Rotation3::rotation_between(&Vector3::from(*up), &Vector3::from(*next))
                .unwrap_or_else(|| Rotation3::from_axis_angle(&Vector3::x_axis(), std::f64::consts::PI));
            let vertical = Rotation3::from_axis_angle(
                &Unit::new_normalize(Vector3::from(*next)),
                rng.random_range(-1.5..1.5),
            );
            let whole = (vertical * shortest).scaled_axis();
            let from = attitude;
            for n in 0..turn {
                // a raised cosine: from rest to rest
                let phase = std::f64::consts::TAU * n as f64 / turn as f64;
                let share = n as f64 / turn as f64 - phase.sin() / std::f64::consts::TAU;
                let speed = (1.0 - phase.cos()) / handling.turn_s;
                attitude = Rotation3::new(whole * share) * from;
                let shake = Vector3::new((9.0 * phase).sin(), (7.0 * phase).cos(), (11.0 * phase).sin());
                // vectors of space turn by `whole` in the frame of the device: the device turns the other way
                push(attitude * Vector3::z() * handling.g + shake, -whole * speed, &scatter, kelvin, rng);
                temperature.push(25.0 + kelvin);
            }
            attitude = Rotation3::new(whole) * from;
        }
        let rows = accelerometer[0].len();
        let columns = |letter: char, unit: &str| ['x', 'y', 'z'].map(|axis| format!("{letter}{axis}_{unit}"));
        Imu {
            period_s: dt,
            time_s: (0..rows).map(|row| row as f64 * dt).collect(),
            segments: std::iter::once(0..rows).collect(),
            accelerometer: Some(Axes {
                values: accelerometer,
                columns: columns('a', "mps2"),
                scale: Scale::Si,
            }),
            gyro: Some(Axes { values: gyro, columns: columns('g', "rads"), scale: Scale::Si }),
            temperature_c: handling.temperature_c.map(|_| temperature),
        }
    }
}

/// The six faces.
pub(crate) fn faces() -> Vec<[f64; 3]> {
    vec![
        [0.0, 0.0, 1.0],
        [1.0, 0.0, 0.0],
        [0.0, -1.0, 0.0],
        [-1.0, 0.0, 0.0],
        [0.0, 1.0, 0.0],
        [0.0, 0.0, -1.0],
    ]
}

/// The six faces to within the 3° of a hand, and others at random: `count` in all, any two 15° apart.
pub(crate) fn orientations(count: usize, rng: &mut ChaCha8Rng) -> Vec<[f64; 3]> {
    let mut all: Vec<[f64; 3]> = Vec::new();
    for face in faces().into_iter().take(count) {
        let tilted = Vector3::from(face) + Vector3::from(three(rng, 0.0, 0.03));
        all.push(tilted.normalize().into());
    }
    while all.len() < count {
        let other: [f64; 3] = UnitSphere.sample(rng);
        let far = |one: &[f64; 3]| Vector3::from(*one).dot(&Vector3::from(other)) < 15_f64.to_radians().cos();
        if all.iter().all(far) || all.len() > 60 {
            all.push(other);
        }
    }
    all
}

pub(crate) fn rng(seed: u64) -> ChaCha8Rng {
    ChaCha8Rng::seed_from_u64(seed)
}
