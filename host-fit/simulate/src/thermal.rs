//! Temperature: an ambient that wanders and may be cycled, a board heated by the load, the die behind the board.

use super::random::{Random, between, chance, log_between, normal};

/// Course of the ambient temperature.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(super) enum Ambient {
    /// A closed box: hundredths of a kelvin, for the reference log.
    Still,
    /// A room: tenths of a kelvin.
    Room,
    /// A chamber that cycles: 8 to 15 K up and down.
    Cycle,
    /// A line in time, K/s, from power-on; nothing else.
    Ramp(f64),
    /// ΔT (1 − exp(−t/τ)) from power-on; nothing else.
    Exponential {
        /// ΔT, K.
        rise_k: f64,
        /// τ, s.
        tau_s: f64,
    },
}

/// Thermal properties of a device and its surroundings; drawn once for a device.
#[derive(Debug, Clone, Copy)]
pub(super) struct Thermal {
    /// Ambient temperature, °C.
    base_c: f64,
    /// Rise of the board at full load, K.
    load_rise_k: f64,
    /// Time constant of the board, s.
    board_tau_s: f64,
    /// Time constant of the die behind the board, s.
    die_tau_s: f64,
}

impl Thermal {
    pub(super) fn draw(random: &mut Random) -> Self {
        Self {
            base_c: between(random, 19.0, 31.0),
            load_rise_k: between(random, 3.0, 8.0),
            board_tau_s: log_between(random, 40.0, 160.0),
            die_tau_s: between(random, 2.0, 8.0),
        }
    }

    /// Die temperature of every sample, °C, for the load in per cent; in equilibrium at the first.
    pub(super) fn die(&self, ambient: Ambient, load: &[f64], period_s: f64, random: &mut Random) -> Vec<f64> {
        let duration_s = load.len() as f64 * period_s;
        let base = self.base_c + between(random, -1.5, 1.5);
        let (wander_k, wander_tau_s) = match ambient {
            Ambient::Still => (between(random, 0.01, 0.03), 120.0),
            Ambient::Room => (between(random, 0.2, 0.45), log_between(random, 80.0, 300.0)),
            Ambient::Cycle => (between(random, 0.05, 0.2), log_between(random, 80.0, 300.0)),
            Ambient::Ramp(_) | Ambient::Exponential { .. } => (0.0, 100.0),
        };
        let cycle = if ambient == Ambient::Cycle { cycle(duration_s, random) } else { Vec::new() };
        let planned = |t: f64| match ambient {
            Ambient::Ramp(slope) => slope * t,
            Ambient::Exponential { rise_k, tau_s } => rise_k * (1.0 - (-t / tau_s).exp()),
            _ => raised_cosine(&cycle, t),
        };
        if matches!(ambient, Ambient::Ramp(_) | Ambient::Exponential { .. }) {
            // the board is in a bath with a prescribed course: its own lag would bend the line
            return (0..load.len()).map(|n| base + planned(n as f64 * period_s)).collect();
        }
        let wander_decay = (-period_s / wander_tau_s).exp();
        let wander_drive = wander_k * (1.0 - wander_decay * wander_decay).sqrt();
        let (board_gain, die_gain) =
            (1.0 - (-period_s / self.board_tau_s).exp(), 1.0 - (-period_s / self.die_tau_s).exp());
        let heat = self.load_rise_k / 100.0;
        let mut wander = wander_k * normal(random);
        let mut board = heat * load.first().copied().unwrap_or(0.0);
        let mut die = board + wander;
        // a second pole, since the room would otherwise be as rough as a random walk
        let mut room = wander;
        (0..load.len())
            .map(|n| {
                wander = wander_decay * wander + wander_drive * normal(random);
                room += (wander - room) * period_s / 5.0;
                board += board_gain * (heat * load[n] - board);
                die += die_gain * (planned(n as f64 * period_s) + room + board - die);
                base + die
            })
            .collect()
    }
}

/// Times, s, and levels, K, between which the ambient moves as a raised cosine.
fn cycle(duration_s: f64, random: &mut Random) -> Vec<(f64, f64)> {
    let mut points = vec![(0.0, 0.0)];
    let mut t = between(random, 20.0, 150.0);
    let mut level = 0.0;
    let mut up = chance(random, 0.7);
    points.push((t, level));
    while t < duration_s {
        // a cycle up or down and back: 5 to 15 minutes, ramps of 2 to 5
        let swing = between(random, 8.0, 15.0);
        level = if level != 0.0 {
            0.0
        } else if up {
            swing
        } else {
            -swing
        };
        up = level < 0.0 || (level == 0.0 && chance(random, 0.6));
        t += between(random, 120.0, 300.0);
        points.push((t, level));
        t += between(random, 20.0, 180.0);
        points.push((t, level));
    }
    points
}

/// Course through points of time and level, flat before the first and after the last.
pub(super) fn raised_cosine(points: &[(f64, f64)], t: f64) -> f64 {
    let next = points.partition_point(|(time, _)| *time <= t);
    match (next.checked_sub(1).map(|i| points[i]), points.get(next).copied()) {
        (Some((from, low)), Some((to, high))) => {
            low + (high - low) * 0.5 * (1.0 - (std::f64::consts::PI * (t - from) / (to - from)).cos())
        }
        (Some((_, level)), None) | (None, Some((_, level))) => level,
        (None, None) => 0.0,
    }
}
