//! Wavelet de-noising, the pre-processing of the paper's rivals.
//!
//! The discrete wavelet transform (Mallat, IEEE Trans. PAMI 11 (1989) 674) with Daubechies' orthogonal filters, the
//! universal threshold of Donoho and Johnstone (Biometrika 81 (1994) 425) and its robust noise estimate:
//!
//! ```text
//!   σ = median |finest detail| / 0.6745,    threshold = σ √(2 ln N)
//! ```
//!
//! applied to every level of detail; the approximation is unchanged. A value depends on later samples as well as on
//! earlier ones: a fit to de-noised samples has seen the future.
//!
//! Beyond its ends a stretch is mirrored, with the end sample twice: … x₁ x₀ | x₀ x₁ … Numbers agree with PyWavelets' to rounding.

use std::fmt;
use std::str::FromStr;

use fos_data::statistics::midpoint_median;
use fos_data::stored_as_text;

/// Treatment of the details.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Details {
    /// Soft threshold: details beyond it are reduced by it, the others are set to zero.
    Soft,
    /// Hard threshold: details beyond it are kept, the others are set to zero.
    Hard,
    /// All details are set to zero: only the low band is kept.
    None,
}

/// An orthogonal wavelet.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Wavelet {
    name: &'static str,
    /// Low-pass filter of the reconstruction, of even length; the other three follow from it.
    scaling: &'static [f64],
}

/// De-noising of a series, as on the command line: `db4:4:soft`, `db4:3:approximation`.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Denoising {
    pub wavelet: Wavelet,
    /// Number of levels of decomposition, 1 to [`MAX_LEVELS`].
    pub levels: usize,
    /// Treatment of the details.
    pub details: Details,
}

/// Largest number of levels of a [`Denoising`]: at 200 Hz six levels keep 1.6 Hz.
pub const MAX_LEVELS: usize = 6;

/// Median of |x| of a normal variable of unit deviation.
const MEDIAN_TO_DEVIATION: f64 = 0.6745;

impl Wavelet {
    /// Returns a wavelet by its name: db1 (Haar), db2, db3, db4, db6, db8, sym4, sym8; the number is that of vanishing
    /// moments.
    pub fn named(name: &str) -> Option<Self> {
        SCALING_FILTERS
            .iter()
            .find(|(known, _)| *known == name)
            .map(|&(name, scaling)| Self { name, scaling })
    }

    /// Returns the name, as `db4`.
    pub fn name(&self) -> &'static str {
        self.name
    }

    /// Returns low-pass h(j) and high-pass g(j) of the analysis, tap by tap; one is the quadrature mirror of the other.
    fn analysis(&self) -> Vec<(f64, f64)> {
        let low = self.scaling.iter().rev();
        let high = self.scaling.iter().enumerate().map(|(j, h)| if j.is_multiple_of(2) { -h } else { *h });
        low.copied().zip(high).collect()
    }
}

/// Decomposes one level: approximation and detail, each about half as long.
fn analyse(wavelet: &Wavelet, series: &[f64]) -> (Vec<f64>, Vec<f64>) {
    let filters = wavelet.analysis();
    let (taps, length) = (filters.len(), series.len());
    // approximation(k) = Σ_j low(j) x(2k + 1 − j)
    let count = (length + taps - 1) / 2;
    // the series with all samples that the filters need beyond its ends
    let extended: Vec<f64> =
        (0..2 * count + taps).map(|place| series[mirrored(place as isize - taps as isize, length)]).collect();
    (0..count)
        .map(|k| {
            let newest = 2 * k + 1 + taps;
            let window = extended[newest + 1 - taps..=newest].iter().rev();
            window.zip(&filters).fold((0.0, 0.0), |(a, d), (x, (l, h))| (a + l * x, d + h * x))
        })
        .unzip()
}

/// Reconstructs one level: the series of `length` samples with this approximation and detail.
fn synthesise(wavelet: &Wavelet, approximation: &[f64], detail: &[f64], length: usize) -> Vec<f64> {
    let filters = wavelet.analysis();
    // the transpose of the analysis: x(2k + 1 − j) += low(j) a(k) + high(j) d(k)
    let mut series = vec![0.0; length];
    for (k, (a, d)) in approximation.iter().zip(detail).enumerate() {
        for (j, (l, h)) in filters.iter().enumerate() {
            if let Some(x) = (2 * k + 1).checked_sub(j).and_then(|place| series.get_mut(place)) {
                *x += l * a + h * d;
            }
        }
    }
    series
}

/// Returns the index of the sample at `place`, which may lie beyond the ends.
fn mirrored(place: isize, length: usize) -> usize {
    let length = length as isize;
    let place = place.rem_euclid(2 * length);
    place.min(2 * length - 1 - place) as usize
}

/// A decomposed series.
#[derive(Debug, Clone, PartialEq)]
pub struct Decomposition {
    /// Approximation after the last level.
    pub approximation: Vec<f64>,
    /// Details, the finest first.
    pub details: Vec<Vec<f64>>,
    wavelet: Wavelet,
    /// Number of samples before each level.
    lengths: Vec<usize>,
}

/// Decomposes a series into `levels` levels.
pub fn decompose(wavelet: &Wavelet, series: &[f64], levels: usize) -> Decomposition {
    let mut approximation = series.to_vec();
    let (mut details, mut lengths) = (Vec::new(), Vec::new());
    for _ in 0..levels {
        lengths.push(approximation.len());
        let (coarser, detail) = analyse(wavelet, &approximation);
        details.push(detail);
        approximation = coarser;
    }
    Decomposition { approximation, details, wavelet: *wavelet, lengths }
}

impl Decomposition {
    /// Reconstructs the series.
    pub fn recompose(&self) -> Vec<f64> {
        let levels = self.details.iter().zip(&self.lengths).rev();
        levels.fold(self.approximation.clone(), |approximation, (detail, length)| {
            synthesise(&self.wavelet, &approximation, detail, *length)
        })
    }

    /// Universal threshold for a series of this length, from the finest detail. Unit of the series.
    pub fn universal_threshold(&self) -> f64 {
        let mut sizes: Vec<f64> = self.details.first().into_iter().flatten().map(|d| d.abs()).collect();
        if sizes.is_empty() {
            return 0.0;
        }
        midpoint_median(&mut sizes) / MEDIAN_TO_DEVIATION * (2.0 * (self.lengths[0] as f64).ln()).sqrt()
    }

    pub fn shrink(&mut self, details: Details) {
        let threshold = self.universal_threshold();
        for detail in self.details.iter_mut().flatten() {
            *detail = match details {
                Details::Soft => detail.signum() * (detail.abs() - threshold).max(0.0),
                Details::Hard if detail.abs() >= threshold => *detail,
                Details::Hard | Details::None => 0.0,
            };
        }
    }
}

impl Denoising {
    /// Daubechies 4, four levels, soft: as in the paper, as far as it is specified.
    pub fn of_the_paper() -> Self {
        let (name, scaling) = SCALING_FILTERS[DB4];
        Self { wavelet: Wavelet { name, scaling }, levels: 4, details: Details::Soft }
    }

    /// Upper end of the band that the approximation keeps, from 0, Hz. Each level halves it.
    pub fn band_hz(&self, rate_hz: f64) -> f64 {
        rate_hz / 2.0 / f64::from(1_u32 << self.levels)
    }

    /// Shortest series for all levels: below it the filter is longer than its input.
    pub fn shortest(&self) -> usize {
        (self.wavelet.scaling.len() - 1) << self.levels
    }

    /// Returns the de-noised series.
    pub fn denoise(&self, series: &[f64]) -> Vec<f64> {
        let mut decomposition = decompose(&self.wavelet, series, self.levels);
        decomposition.shrink(self.details);
        decomposition.recompose()
    }
}

impl FromStr for Denoising {
    type Err = String;

    fn from_str(text: &str) -> Result<Self, String> {
        let wrong = |what: String| format!("{text:?}: {what}; write it like db4:4:soft");
        let mut parts = text.split(':');
        let name = parts.next().unwrap_or_default();
        let wavelet = Wavelet::named(name).ok_or_else(|| {
            let known: Vec<&str> = SCALING_FILTERS.iter().map(|(name, _)| *name).collect();
            wrong(format!("{name:?} is not one of {}", known.join(", ")))
        })?;
        let levels = parts.next().unwrap_or("4");
        let levels: usize =
            levels.parse().map_err(|_| wrong(format!("{levels:?} is not a number of levels")))?;
        if !(1..=MAX_LEVELS).contains(&levels) {
            return Err(wrong(format!("levels are 1 to {MAX_LEVELS}")));
        }
        let details = match parts.next().unwrap_or("soft") {
            "soft" => Details::Soft,
            "hard" => Details::Hard,
            "approximation" => Details::None,
            other => return Err(wrong(format!("{other:?} is not one of soft, hard, approximation"))),
        };
        if parts.next().is_some() {
            return Err(wrong("there is more than wavelet, levels and kind".to_owned()));
        }
        Ok(Self { wavelet, levels, details })
    }
}

impl fmt::Display for Denoising {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let details = match self.details {
            Details::Soft => "soft",
            Details::Hard => "hard",
            Details::None => "approximation",
        };
        write!(f, "{}:{}:{details}", self.wavelet.name, self.levels)
    }
}

stored_as_text!(Denoising);

/// Index of db4 among the filters.
const DB4: usize = 3;

/// Scaling filters by name, computed to the last digit by PyWavelets 1.9 from Daubechies, Ten Lectures on Wavelets
/// (1992), tables 6.1 and 6.3; Σ h = √2 and Σ h(n) h(n − 2k) = δ(k) are tested.
#[rustfmt::skip]
const SCALING_FILTERS: [(&str, &[f64]); 8] = [
    ("db1", &[
        std::f64::consts::FRAC_1_SQRT_2,
        std::f64::consts::FRAC_1_SQRT_2,
    ]),
    ("db2", &[
        0.48296291314453416,
        0.8365163037378079,
        0.2241438680420134,
        -0.12940952255126037,
    ]),
    ("db3", &[
        0.33267055295008263,
        0.8068915093110925,
        0.45987750211849154,
        -0.13501102001025458,
        -0.08544127388202666,
        0.03522629188570953,
    ]),
    ("db4", &[
        0.2303778133088965,
        0.7148465705529157,
        0.6308807679298589,
        -0.027983769416859854,
        -0.18703481171909309,
        0.030841381835560764,
        0.0328830116668852,
        -0.010597401785069032,
    ]),
    ("db6", &[
        0.11154074335010947,
        0.49462389039845306,
        0.7511339080210954,
        0.31525035170919763,
        -0.22626469396543983,
        -0.12976686756726194,
        0.09750160558732304,
        0.027522865530305727,
        -0.03158203931748603,
        0.0005538422011614961,
        0.004777257510945511,
        -0.0010773010853084796,
    ]),
    ("db8", &[
        0.05441584224310401,
        0.31287159091429995,
        0.6756307362972898,
        0.5853546836542067,
        -0.015829105256349306,
        -0.2840155429615469,
        0.0004724845739132828,
        0.12874742662047847,
        -0.017369301001807547,
        -0.044088253930794755,
        0.013981027917398282,
        0.008746094047405777,
        -0.004870352993451574,
        -0.00039174037337694705,
        0.0006754494064505693,
        -0.00011747678412476953,
    ]),
    ("sym4", &[
        0.0322231006040427,
        -0.012603967262037833,
        -0.09921954357684722,
        0.29785779560527736,
        0.8037387518059161,
        0.49761866763201545,
        -0.02963552764599851,
        -0.07576571478927333,
    ]),
    ("sym8", &[
        0.0018899503327594609,
        -0.0003029205147213668,
        -0.01495225833704823,
        0.003808752013890615,
        0.049137179673607506,
        -0.027219029917056003,
        -0.05194583810770904,
        0.3644418948353314,
        0.7771857517005235,
        0.4813596512583722,
        -0.061273359067658524,
        -0.1432942383508097,
        0.007607487324917605,
        0.03169508781149298,
        -0.0005421323317911481,
        -0.0033824159510061256,
    ]),
];

#[cfg(test)]
mod tests {
    use super::*;
    use fos_testkit::noise::white_noise;
    use fos_testkit::reference::{self, Reference, assert_all_close, number, numbers};

    #[test]
    fn agrees_with_pywavelets() {
        for reference in reference::each("wavelet", "wavelet_db4") {
            assert_as_pywavelets(&reference);
        }
    }

    fn assert_as_pywavelets(reference: &Reference) {
        let (answers, series) = (&reference.answers, reference.series());
        let tolerance = number(&answers["tolerance_relative"]);
        let mirrored = answers["cases"].as_array().unwrap().iter().filter(|case| case["mode"] == "symmetric");
        for case in mirrored {
            let wavelet = Wavelet::named(case["wavelet"].as_str().unwrap()).unwrap();
            let details = match case["threshold_kind"].as_str().unwrap() {
                "soft" => Details::Soft,
                "hard" => Details::Hard,
                other => panic!("{other}"),
            };
            let levels = case["level"].as_u64().unwrap() as usize;
            let mut decomposition = decompose(&wavelet, series, levels);
            assert_all_close("cA", &decomposition.approximation, &numbers(&case["cA"]), tolerance);
            let coarsest = decomposition.details.last().unwrap();
            assert_all_close("cD", coarsest, &numbers(&case["cD_coarsest"]), tolerance);
            let energy = |band: &Vec<f64>| band.iter().map(|x| x * x).sum::<f64>();
            let energies: Vec<f64> = std::iter::once(&decomposition.approximation)
                .chain(decomposition.details.iter().rev())
                .map(energy)
                .collect();
            assert_all_close("energy", &energies, &numbers(&case["energy_each"]), tolerance);
            let threshold = decomposition.universal_threshold();
            assert!((threshold / number(&case["threshold"]) - 1.0).abs() < tolerance, "{threshold}");

            decomposition.shrink(details);
            let denoised = decomposition.recompose();
            assert_all_close("de-noised", &denoised, &numbers(&case["denoised_soft_or_hard"]), tolerance);
            decomposition.shrink(Details::None);
            let low = decomposition.recompose();
            assert_all_close("approximation", &low, &numbers(&case["approximation_only"]), tolerance);
        }
    }

    #[test]
    fn every_filter_is_orthonormal() {
        for (name, scaling) in SCALING_FILTERS {
            assert!((scaling.iter().sum::<f64>() - 2.0_f64.sqrt()).abs() < 1e-10, "{name}");
            for shift in (0..scaling.len()).step_by(2) {
                let product: f64 = scaling.iter().zip(&scaling[shift..]).map(|(a, b)| a * b).sum();
                let expected = if shift == 0 { 1.0 } else { 0.0 };
                assert!((product - expected).abs() < 1e-10, "{name}, shift {shift}: {product}");
            }
        }
    }

    #[test]
    fn decomposition_round_trips_at_any_length() {
        for (name, _) in SCALING_FILTERS {
            let wavelet = Wavelet::named(name).unwrap();
            for length in [2, 3, 17, 64, 101, 1000] {
                let series = white_noise(length as u64, length);
                for levels in 1..=MAX_LEVELS {
                    let again = decompose(&wavelet, &series, levels).recompose();
                    assert_eq!(again.len(), length);
                    for (a, b) in again.iter().zip(&series) {
                        assert!((a - b).abs() < 1e-9, "{name} {length} {levels}: {a} for {b}");
                    }
                }
            }
        }
    }

    #[test]
    fn the_band_halves_with_every_level() {
        let four: Denoising = "db4:4:soft".parse().unwrap();
        let three: Denoising = "db4:3:approximation".parse().unwrap();
        assert_eq!((four.band_hz(200.0), three.band_hz(200.0)), (6.25, 12.5));
        assert_eq!(four.to_string(), "db4:4:soft");
        for text in ["db5", "db4:7:soft", "db4:0:soft", "db4:4:firm", "db4:4:soft:x", ""] {
            assert!(text.parse::<Denoising>().is_err(), "{text}");
        }
    }
}
