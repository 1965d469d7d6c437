//! A single coefficient of a population: x = μ + a(lot) + b(device) + e, with a known variance of e for each device.
//!
//! Small samples need degrees of freedom for each estimated variance (Satterthwaite 1946, from the expected information of the restricted
//! likelihood), exact intervals of the variances (Q profile: Viechtbauer 2007; for lots Williams 1962 and Tukey 1951) and the deviation of
//! a device from the population without it. V = diag(B + error) + A on the blocks of lots has a closed-form inverse, so every sum below is
//! a sum over lots, and a device is removed without another pass over all devices.

use crate::tails::{OUTSIDE, chi_squared_quantile, f_quantile, f_tail, falls_to, t_tail};

/// Up to this number of devices, variances are estimated again without each of them; above it, a device is removed by one step of Fisher
/// scoring.
const REFITTED: usize = 40;

/// Maximum number of steps of Fisher scoring, and the change of a scaled variance (about 1) at which it ends.
const MOST_STEPS: usize = 60;
const CHANGE: f64 = 1e-8;

/// Start of the search for scaled variances.
const START: Variances = Variances { units: 0.5, lots: 0.3 };

/// Smallest variance of a scaled error, used for estimates without an error.
pub(crate) const LEAST_ERROR: f64 = 1e-12;

/// Variance between lots that makes them independent: a device is compared with its own lot only.
const APART: f64 = 1e6;

/// Maximum number of halvings of a step that lowers the likelihood.
const HALVINGS: usize = 8;

/// Value of a device, number of its lot, and variance of its error.
#[derive(Debug, Clone, Copy)]
pub(crate) struct Value {
    pub(crate) lot: usize,
    pub(crate) value: f64,
    pub(crate) error: f64,
}

/// Variance between devices of a lot (B) and between lots (A).
#[derive(Debug, Clone, Copy, PartialEq)]
pub(crate) struct Variances {
    pub(crate) units: f64,
    pub(crate) lots: f64,
}

/// Deviation of a device from the population without it.
#[derive(Debug, Clone, Copy)]
pub(crate) struct Deviation {
    /// Deviation in standard deviations of a device of its lot, the error of its log and that of the estimated mean together.
    pub(crate) by: f64,
    /// Degrees of freedom of that standard deviation.
    pub(crate) freedom: f64,
    /// Probability that a device of the population deviates further.
    pub(crate) p_value: f64,
    /// Standard deviation of device and log error, divided by that of `by`, which includes the error of the mean.
    pub(crate) share: f64,
}

/// Degrees of freedom of a coefficient's variances.
#[derive(Debug, Clone)]
pub(crate) struct Freedom {
    /// Degrees of freedom of the variance of the mean.
    pub(crate) mean: f64,
    /// Degrees of freedom of the variance of a device of unknown lot.
    pub(crate) unit: f64,
    /// Degrees of freedom for each lot: of its mean, and of a device in it.
    pub(crate) lots: Vec<[f64; 2]>,
}

/// Values of a coefficient, scaled so that they vary by about 1.
#[derive(Debug, Clone)]
pub(crate) struct Coefficient {
    values: Vec<Value>,
    lots: usize,
    /// The variance between lots is estimated.
    has_lots: bool,
    /// Lots are independent: the variance between them is [`APART`].
    apart: bool,
    centre: f64,
    scale: f64,
}

/// Sums over the devices of a lot, w = 1/(B + error): of ln(1/w), w, w², w³, wx, w²x, wx², w²x².
#[derive(Debug, Clone, Copy, Default)]
struct Sums {
    logs: f64,
    w: [f64; 3],
    x: [f64; 2],
    xx: [f64; 2],
}

#[derive(Debug, Clone, Copy, Default)]
struct Totals([f64; 15]);

/// The restricted likelihood at a pair of variances.
#[derive(Debug, Clone, Copy)]
struct Likelihood {
    /// −2 ln L, up to a constant.
    deviance: f64,
    mean: f64,
    /// Ω = 1ᵀV⁻¹1, and in `loss` its negative derivatives by B and A.
    precision: f64,
    loss: [f64; 2],
    score: [f64; 2],
    /// Expected information: BB, BA, AA.
    information: [f64; 3],
}

impl Sums {
    fn add(&mut self, value: &Value, units: f64, sign: f64) {
        let w = 1.0 / (units + value.error);
        let (wx, x) = (w * value.value, value.value);
        self.logs -= sign * w.ln();
        self.w[0] += sign * w;
        self.w[1] += sign * w * w;
        self.w[2] += sign * w * w * w;
        self.x[0] += sign * wx;
        self.x[1] += sign * w * wx;
        self.xx[0] += sign * wx * x;
        self.xx[1] += sign * wx * wx;
    }

    /// 1/(1 + A·Σw): share of a lot's deviation that its devices do not reveal.
    fn hidden(&self, lots: f64) -> f64 {
        1.0 / (1.0 + lots * self.w[0])
    }
}

impl Totals {
    /// Adds a lot (`sign` 1) or removes it (−1).
    fn add(&mut self, lot: &Sums, lots: f64, sign: f64) {
        let Sums { logs, w: [w1, w2, w3], x: [x1, x2], xx: [xx1, xx2] } = *lot;
        let h = lot.hidden(lots);
        let (k, omega, g) = (lots * h, w1 * h, lots * x1 * h);
        let terms = [
            omega,
            x1 * h,
            w2 * h * h,
            w1 - k * w2,
            w2 - 2.0 * k * w3 + k * k * w2 * w2,
            h * h * (w3 - k * w2 * w2),
            omega * omega,
            omega * omega * omega,
            w2 * h * h * omega,
            xx2 - 2.0 * g * x2 + g * g * w2,
            2.0 * h * (g * w2 - x2),
            (x1 * h).powi(2),
            x1 * h * omega,
            logs - h.ln(),
            xx1 - k * x1 * x1,
        ];
        for (total, term) in self.0.iter_mut().zip(terms) {
            *total += sign * term;
        }
    }

    fn likelihood(&self) -> Likelihood {
        let [omega, x, u2, trace, trace2, uvu, omega2, omega3, u2_omega, q0, q1, r0, r1, logs, xx] = self.0;
        let mean = x / omega;
        let square_b = q0 + q1 * mean + u2 * mean * mean;
        let square_a = r0 - 2.0 * mean * r1 + mean * mean * omega2;
        Likelihood {
            deviance: logs + omega.ln() + xx - x * mean,
            mean,
            precision: omega,
            loss: [u2, omega2],
            score: [0.5 * (square_b - trace + u2 / omega), 0.5 * (square_a - omega + omega2 / omega)],
            information: [
                0.5 * (trace2 - 2.0 * uvu / omega + (u2 / omega).powi(2)),
                0.5 * (u2 - 2.0 * u2_omega / omega + omega2 * u2 / (omega * omega)),
                0.5 * (omega2 - 2.0 * omega3 / omega + (omega2 / omega).powi(2)),
            ],
        }
    }
}

impl Likelihood {
    /// Degrees of freedom f of an estimated variance V with this `gradient` by B and A, from Var(V)/V² = 2/f.
    fn freedom(&self, variance: f64, gradient: [f64; 2], has_lots: bool) -> f64 {
        let [bb, ba, aa] = self.information;
        let [b, a] = gradient;
        let of_variance = match has_lots {
            true => (b * b * aa - 2.0 * a * b * ba + a * a * bb) / (bb * aa - ba * ba),
            false => b * b / bb,
        };
        let freedom = 2.0 * variance * variance / of_variance;
        if freedom.is_finite() { freedom.clamp(0.0, 1e9) } else { 0.0 }
    }

    /// One step of Fisher scoring; negative variances are set to 0.
    fn step(&self, at: Variances, has_lots: bool) -> Variances {
        let ([b, a], [bb, ba, aa]) = (self.score, self.information);
        let alone = |value: f64, score: f64, information: f64| {
            let next = value + score / information;
            if next.is_finite() { next.max(0.0) } else { value }
        };
        if !has_lots {
            return Variances { units: alone(at.units, b, bb), ..at };
        }
        let determinant = bb * aa - ba * ba;
        let both = Variances {
            units: at.units + (aa * b - ba * a) / determinant,
            lots: at.lots + (bb * a - ba * b) / determinant,
        };
        match (both.units >= 0.0, both.lots >= 0.0) {
            (true, true) => both,
            (true, false) => Variances { units: alone(at.units, b, bb), lots: 0.0 },
            _ => Variances { units: 0.0, lots: alone(at.lots, a, aa) },
        }
    }
}

impl Coefficient {
    /// `values` of the devices of `lots` lots, some of which may be empty.
    pub(crate) fn of(mut values: Vec<Value>, lots: usize) -> Self {
        let n = values.len().max(1) as f64;
        let centre = values.iter().map(|value| value.value).sum::<f64>() / n;
        let square = values.iter().map(|value| (value.value - centre).powi(2) + value.error).sum::<f64>() / n;
        // Equal values without errors have no scale.
        let scale = if square > 0.0 { square.sqrt() } else { 1.0 };
        for value in &mut values {
            value.value = (value.value - centre) / scale;
            value.error = (value.error / (scale * scale)).max(LEAST_ERROR);
        }
        Self { centre, scale, ..Self::scaled(values, lots) }
    }

    /// Takes scaled values. Lots of one device each are indistinguishable from their devices; their variance is then part of that of
    /// the devices.
    fn scaled(mut values: Vec<Value>, lots: usize) -> Self {
        let mut of_lots = vec![0_usize; lots];
        values.iter().for_each(|value| of_lots[value.lot] += 1);
        let has_lots =
            of_lots.iter().filter(|units| **units > 0).count() > 1 && of_lots.iter().any(|units| *units > 1);
        if !has_lots {
            values.iter_mut().for_each(|value| value.lot = 0);
        }
        let lots = if has_lots { lots } else { 1 };
        Self { values, lots, has_lots, apart: false, centre: 0.0, scale: 1.0 }
    }

    /// The same values with independent lots.
    fn apart(&self) -> Self {
        Self { has_lots: false, apart: true, ..self.clone() }
    }

    /// The same values without one device.
    fn without(&self, index: usize) -> Self {
        let mut values = self.values.clone();
        values.remove(index);
        if self.apart { Self { values, ..*self } } else { Self::scaled(values, self.lots) }
    }

    /// Sums of the lot of a device.
    fn of_lot(&self, sums: &[Sums], lot: usize) -> Sums {
        if self.has_lots || self.apart { sums.get(lot).copied().unwrap_or_default() } else { sums[0] }
    }

    pub(crate) fn has_lots(&self) -> bool {
        self.has_lots
    }

    fn sums(&self, units: f64) -> Vec<Sums> {
        let mut sums = vec![Sums::default(); self.lots];
        self.values.iter().for_each(|value| sums[value.lot].add(value, units, 1.0));
        sums
    }

    fn totals(sums: &[Sums], lots: f64) -> Totals {
        let mut totals = Totals::default();
        sums.iter().for_each(|lot| totals.add(lot, lots, 1.0));
        totals
    }

    fn likelihood(&self, at: Variances) -> Likelihood {
        Self::totals(&self.sums(at.units), at.lots).likelihood()
    }

    /// Variances of the greatest restricted likelihood, in the squared unit of the values.
    pub(crate) fn variances(&self) -> Variances {
        let Variances { units, lots } = self.fit(START);
        let square = self.scale * self.scale;
        Variances { units: units * square, lots: lots * square }
    }

    fn fit(&self, start: Variances) -> Variances {
        let lots = if self.apart { APART } else { 0.0 };
        let mut now = if self.has_lots { start } else { Variances { lots, ..start } };
        let mut likelihood = self.likelihood(now);
        for _ in 0..MOST_STEPS {
            let target = likelihood.step(now, self.has_lots);
            let (mut share, mut next, mut there) = (1.0, target, self.likelihood(target));
            for _ in 0..HALVINGS {
                if there.deviance <= likelihood.deviance + CHANGE {
                    break;
                }
                share *= 0.5;
                next = Variances {
                    units: now.units + share * (target.units - now.units),
                    lots: now.lots + share * (target.lots - now.lots),
                };
                there = self.likelihood(next);
            }
            let change = (next.units - now.units).abs().max((next.lots - now.lots).abs());
            (now, likelihood) = (next, there);
            if change < CHANGE {
                break;
            }
        }
        now
    }

    /// Deviation of each member from the population without it, and of each of `others`, which are not members. None if fewer than two
    /// devices remain for comparison.
    ///
    /// If other devices of the same lot exist, the larger of two p-values counts: against the population, and against the device's own
    /// lot. The scatter between few lots is poorly known, and the second p-value does not depend on it.
    pub(crate) fn deviations(&self, others: &[Value]) -> [Vec<Option<Deviation>>; 2] {
        let scaled = |other: &Value| Value {
            lot: other.lot,
            value: (other.value - self.centre) / self.scale,
            error: (other.error / (self.scale * self.scale)).max(LEAST_ERROR),
        };
        let others: Vec<Value> = others.iter().map(scaled).collect();
        let mut found = self.deviations_by_itself(&others, REFITTED);
        if self.has_lots {
            let mut of_lots = vec![0_usize; self.lots];
            self.values.iter().for_each(|value| of_lots[value.lot] += 1);
            let apart = self.apart().deviations_by_itself(&others, REFITTED);
            for (kind, values) in [&self.values, &others].into_iter().enumerate() {
                for ((value, both), in_lot) in values.iter().zip(&mut found[kind]).zip(&apart[kind]) {
                    // A member is not compared with itself.
                    let has_others = of_lots.get(value.lot).is_some_and(|units| units + kind > 1);
                    let in_lot = in_lot.filter(|in_lot| has_others && in_lot.freedom >= 1.0);
                    if in_lot.is_some_and(|in_lot| both.is_none_or(|both| both.p_value < in_lot.p_value)) {
                        *both = in_lot;
                    }
                }
            }
        }
        found
    }

    /// Deviations against the population only. With up to `refitted` members, each has a fit of its own without it.
    fn deviations_by_itself(&self, others: &[Value], refitted: usize) -> [Vec<Option<Deviation>>; 2] {
        if self.values.len() < 2 {
            return [vec![None; self.values.len()], vec![None; others.len()]];
        }
        let at = self.fit(START);
        let sums = self.sums(at.units);
        let totals = Self::totals(&sums, at.lots);
        let refit = |index: usize| {
            let (member, rest) = (self.values[index], self.without(index));
            let at = rest.fit(at);
            let sums = rest.sums(at.units);
            let likelihood = Self::totals(&sums, at.lots).likelihood();
            deviation(&member, &rest.of_lot(&sums, member.lot), &likelihood, at, at, rest.has_lots)
        };
        let downdate = |index: usize| {
            let member = self.values[index];
            let mut lot = sums[member.lot];
            lot.add(&member, at.units, -1.0);
            let mut rest = totals;
            rest.add(&sums[member.lot], at.lots, -1.0);
            rest.add(&lot, at.lots, 1.0);
            let likelihood = rest.likelihood();
            deviation(&member, &lot, &likelihood, at, likelihood.step(at, self.has_lots), self.has_lots)
        };
        let of_member = |index| match self.values.len() {
            0..3 => None,
            n if n <= refitted => Some(refit(index)),
            _ => Some(downdate(index)),
        };
        let likelihood = totals.likelihood();
        let of_other = |other: &Value| {
            Some(deviation(other, &self.of_lot(&sums, other.lot), &likelihood, at, at, self.has_lots))
        };
        [(0..self.values.len()).map(of_member).collect(), others.iter().map(of_other).collect()]
    }

    /// Degrees of freedom of means and devices, at variances in the squared unit of the values.
    pub(crate) fn freedom(&self, units: f64, lots: f64) -> Freedom {
        let square = self.scale * self.scale;
        let at = Variances { units: units / square, lots: if self.has_lots { lots / square } else { 0.0 } };
        let sums = self.sums(at.units);
        let likelihood = Self::totals(&sums, at.lots).likelihood();
        let of = |lot: &Sums, unit: bool| {
            let (variance, [b, a]) = variance_of_mean(lot, &likelihood, at.lots);
            let (variance, b) = if unit { (variance + at.units, b + 1.0) } else { (variance, b) };
            likelihood.freedom(variance, [b, a], self.has_lots)
        };
        let omega = likelihood.precision;
        let of_mean = likelihood.loss.map(|loss| loss / (omega * omega));
        Freedom {
            mean: likelihood.freedom(1.0 / omega, of_mean, self.has_lots),
            unit: of(&if self.has_lots { Sums::default() } else { sums[0] }, true),
            lots: sums.iter().map(|lot| [of(lot, false), of(lot, true)]).collect(),
        }
    }

    /// Exact 90 % interval of the variance between devices of a lot: all B at which the weighted sum of squares within lots lies in the
    /// central 90 % of χ², for any scatter of lots.
    pub(crate) fn units_interval(&self) -> [f64; 2] {
        let n = self.values.len();
        let lots = self.sums(0.0).iter().filter(|lot| lot.w[0] > 0.0).count();
        let Some(freedom) = n.checked_sub(lots).filter(|freedom| *freedom > 0) else { return [0.0; 2] };
        let freedom = freedom as f64;
        let within = |units: f64| self.sums(units).iter().map(Sums::within).sum::<f64>();
        // Scatter below the log errors admits no smaller upper bound than scatter equal to them.
        let expected = |units: f64| {
            let errors = self.values.iter().map(|value| (value, 1.0 / (units + value.error)));
            let mut lots = vec![[0.0; 2]; self.lots];
            let mut sum = 0.0;
            for (value, w) in errors {
                sum += w * value.error;
                lots[value.lot][0] += w;
                lots[value.lot][1] += w * w * value.error;
            }
            sum - lots.iter().filter(|[w, _]| *w > 0.0).map(|[w, squares]| squares / w).sum::<f64>()
        };
        let [most, least] = [OUTSIDE, 1.0 - OUTSIDE].map(|outside| chi_squared_quantile(freedom, outside));
        let high = falls_to(least, within).max(falls_to(least, expected));
        [falls_to(most, within), high].map(|end| end * self.scale * self.scale)
    }

    /// 90 % interval of the variance between lots, with the uncertainty of the variance of the devices.
    pub(crate) fn lots_interval(&self) -> [f64; 2] {
        let Some(between) = self.between() else { return [0.0; 2] };
        let Between { freedoms, .. } = between;
        let [most, least] = [OUTSIDE, 1.0 - OUTSIDE].map(|outside| {
            let square = chi_squared_quantile(freedoms[0], outside);
            (square, freedoms[0] * f_quantile(freedoms, outside) / square)
        });
        let end = |(square, error): (f64, f64)| falls_to(square, |lots| between.squares(lots, error));
        // As between devices: means of lots that agree better than by chance admit no smaller upper bound.
        let expected = falls_to(least.0, |lots| between.expected(lots, least.1));
        [end(most), end(least).max(expected)].map(|end| end * self.scale * self.scale)
    }

    /// p-value of the observed difference between lots if lots do not differ: F test of a one-way layout, weighted where errors differ.
    pub(crate) fn lots_alike(&self) -> Option<f64> {
        let between = self.between()?;
        let square = between.squares(0.0, 1.0);
        // Equal means do not differ, however small their errors.
        Some(if square <= 0.0 { 1.0 } else { f_tail(between.freedoms, square / between.freedoms[0]) })
    }

    /// Means of lots, with their variances estimated from the devices.
    fn between(&self) -> Option<Between> {
        if !self.has_lots {
            return None;
        }
        let lots = |sums: &[Sums]| sums.iter().filter(|lot| lot.w[0] > 0.0).count();
        let n_lots = lots(&self.sums(0.0));
        let freedom = (self.values.len() - n_lots) as f64;
        let within = |units: f64| self.sums(units).iter().map(Sums::within).sum::<f64>();
        let units = falls_to(freedom, within);
        let sums = self.sums(units);
        let mean_square = within(units) / freedom;
        let filled = sums.iter().filter(|lot| lot.w[0] > 0.0);
        Some(Between {
            means: filled
                .map(|lot| [lot.x[0] / lot.w[0], (mean_square / lot.w[0]).max(LEAST_ERROR)])
                .collect(),
            freedoms: [n_lots as f64 - 1.0, freedom],
        })
    }
}

/// Means of lots, each with its variance estimated from the devices.
struct Between {
    means: Vec<[f64; 2]>,
    /// Degrees of freedom of lots, and of devices within lots.
    freedoms: [f64; 2],
}

impl Between {
    /// Weighted sum of squares about the weighted mean, at a variance `lots` between lots and a multiple `error` of the variances of
    /// their means.
    fn squares(&self, lots: f64, error: f64) -> f64 {
        let weights =
            || self.means.iter().map(move |[mean, variance]| (mean, 1.0 / (lots + error * variance)));
        let whole: f64 = weights().map(|(_, weight)| weight).sum();
        let mean = weights().map(|(mean, weight)| weight * mean).sum::<f64>() / whole;
        weights().map(|(of_lot, weight)| weight * (of_lot - mean).powi(2)).sum()
    }

    /// Expectation of [`squares`](Self::squares) if lots do not differ.
    fn expected(&self, lots: f64, error: f64) -> f64 {
        let weights = || {
            self.means.iter().map(move |[_, variance]| (error * variance, 1.0 / (lots + error * variance)))
        };
        let whole: f64 = weights().map(|(_, weight)| weight).sum();
        let squares: f64 = weights().map(|(variance, weight)| weight * weight * variance).sum();
        weights().map(|(variance, weight)| weight * variance).sum::<f64>() - squares / whole
    }
}

impl Sums {
    /// Weighted sum of squares about the mean of the lot.
    fn within(&self) -> f64 {
        if self.w[0] > 0.0 { (self.xx[0] - self.x[0] * self.x[0] / self.w[0]).max(0.0) } else { 0.0 }
    }
}

/// Variance of the mean of a lot, and its gradient by B and A. A lot without devices stands for an unknown lot.
fn variance_of_mean(lot: &Sums, likelihood: &Likelihood, lots: f64) -> (f64, [f64; 2]) {
    let (h, [w1, w2, _], omega) = (lot.hidden(lots), lot.w, likelihood.precision);
    let [loss_b, loss_a] = likelihood.loss.map(|loss| loss / (omega * omega));
    let by_a = h * h * (1.0 - 2.0 * h * w1 / omega + loss_a);
    let by_b = lots * h * h * w2 * (lots + 2.0 * h / omega) + h * h * loss_b;
    (lots * h + h * h / omega, [by_b, by_a])
}

/// Deviation of `value` from a population with the likelihood at `at` and the variances `next`. `lot` has the sums of the other devices of
/// its lot.
fn deviation(
    value: &Value,
    lot: &Sums,
    likelihood: &Likelihood,
    at: Variances,
    next: Variances,
    has_lots: bool,
) -> Deviation {
    let (of_mean, [b, a]) = variance_of_mean(lot, likelihood, at.lots);
    let h = lot.hidden(at.lots);
    let expected = at.lots * lot.x[0] * h + h * likelihood.mean;
    let variance = at.units + value.error + of_mean;
    let freedom = likelihood.freedom(variance, [b + 1.0, a], has_lots);
    // First-order update; the variance is at least that of the value's own log.
    let moved = (b + 1.0) * (next.units - at.units) + a * (next.lots - at.lots);
    let variance = (variance + moved).max(value.error);
    let by = (value.value - expected) / variance.sqrt();
    let share = ((next.units + value.error) / variance).sqrt().min(1.0);
    Deviation { by, freedom, p_value: t_tail(freedom, by), share }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Devices of three lots of different sizes, one far off, with different log errors.
    fn values() -> Vec<Value> {
        let wave = |place: usize| (1.7 * place as f64 + 0.3 * (place * place) as f64).sin();
        let value = |place: usize| Value {
            lot: place % 7 % 3,
            value: 5.0 + [0.8, -0.3, 0.1][place % 7 % 3] + wave(place) + if place == 11 { 6.0 } else { 0.0 },
            error: 0.05 + 0.2 * wave(3 * place).powi(2),
        };
        (0..60).map(value).collect()
    }

    #[test]
    fn downdate_agrees_with_refit_without_the_device() {
        let all = Coefficient::of(values(), 3);
        for model in
            [all.apart(), all, Coefficient::of(values().iter().map(|v| Value { lot: 0, ..*v }).collect(), 1)]
        {
            let [fitted, _] = model.deviations_by_itself(&[], usize::MAX);
            let [taken_out, _] = model.deviations_by_itself(&[], 0);
            for (fitted, taken_out) in fitted.iter().flatten().zip(taken_out.iter().flatten()) {
                // The step is of first order, so the error is largest for the far device.
                assert!(
                    (fitted.by - taken_out.by).abs() < 0.01 + 0.05 * fitted.by.abs(),
                    "{fitted:?} {taken_out:?}"
                );
                assert!((fitted.freedom / taken_out.freedom - 1.0).abs() < 0.1, "{fitted:?} {taken_out:?}");
            }
        }
    }

    #[test]
    fn single_lot_without_errors_gives_a_t_test() {
        let given = [1.0, 2.5, 3.0, 0.5, 7.0];
        let values = given.map(|value| Value { lot: 0, value, error: 0.0 });
        let [found, _] = Coefficient::of(values.to_vec(), 1).deviations(&[]);
        let last = found[4].expect("compared");
        // The other four have mean 1.75 and variance 4.25/3.
        let expected = (7.0 - 1.75) / (4.25 / 3.0 * 1.25_f64).sqrt();
        assert!(
            (last.by - expected).abs() < 1e-4 && (last.freedom - 3.0).abs() < 1e-4,
            "{last:?} {expected}"
        );
    }

    #[test]
    fn score_is_the_slope_of_the_likelihood() {
        let all = Coefficient::of(values(), 3);
        let at = Variances { units: 0.7, lots: 0.4 };
        let likelihood = all.likelihood(at);
        let step = 1e-5;
        let deviance = |units: f64, lots: f64| all.likelihood(Variances { units, lots }).deviance;
        let slopes = [
            (deviance(at.units + step, at.lots) - deviance(at.units - step, at.lots)) / (2.0 * step),
            (deviance(at.units, at.lots + step) - deviance(at.units, at.lots - step)) / (2.0 * step),
        ];
        for (slope, score) in slopes.iter().zip(likelihood.score) {
            assert!(
                (slope + 2.0 * score).abs() < 1e-5 * score.abs().max(1.0),
                "{slopes:?} {:?}",
                likelihood.score
            );
        }
        let [bb, ba, aa] = likelihood.information;
        assert!(bb > 0.0 && aa > 0.0 && ba * ba < bb * aa, "{:?}", likelihood.information);
    }
}
