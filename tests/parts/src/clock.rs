//! The part's own oscillator.

/// Converts the host's time to the part's, whose rate may be off and may drift.
#[derive(Debug)]
pub(crate) struct Clock {
    /// Both times at the last change of the rate, ns.
    host_ns: u64,
    part_ns: u64,
    /// Deviation of the rate, ppm, and its change, ppm/s.
    ppm: f64,
    drift_ppm_s: f64,
}

impl Clock {
    pub(crate) const fn new() -> Self {
        Self { host_ns: 0, part_ns: 0, ppm: 0.0, drift_ppm_s: 0.0 }
    }

    /// Time of the part, ns of its nominal rate.
    pub(crate) fn part_ns(&self, host_ns: u64) -> u64 {
        let passed = host_ns.saturating_sub(self.host_ns);
        let s = passed as f64 * 1e-9;
        let ppm = self.ppm + 0.5 * self.drift_ppm_s * s;
        // 1 ppm of 1 s is 1000 ns
        self.part_ns + passed.saturating_add_signed((ppm * s * 1000.0).round() as i64)
    }

    /// Sets the deviation of the rate from now on, which ends its drift.
    pub(crate) fn set_ppm(&mut self, host_ns: u64, ppm: f64) {
        *self = Self { host_ns, part_ns: self.part_ns(host_ns), ppm, drift_ppm_s: 0.0 };
    }

    /// Lets the rate drift from its present value on.
    pub(crate) fn set_drift(&mut self, host_ns: u64, drift_ppm_s: f64) {
        let s = host_ns.saturating_sub(self.host_ns) as f64 * 1e-9;
        let ppm = self.ppm + self.drift_ppm_s * s;
        *self = Self { host_ns, part_ns: self.part_ns(host_ns), ppm, drift_ppm_s };
    }
}
