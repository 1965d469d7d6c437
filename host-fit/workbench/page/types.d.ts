// What the server answers with, from its Rust types. Written by
// FOS_WRITE_PAGE_TYPES=1 cargo test --workspace --lib page_types

/** Effect that was added. */
export type Added = {
/** Definition of the effect, so that the study can be read without its file. */
effect: Effect,
/** Finding as estimated, with the predicted reduction. */
finding: FindingWithRms,
/** Measured reduction, in the band of the effect. */
realised_fall: number, };

/** Allan deviation at one averaging time. */
export type AllanValue = {
/** Averaging time, s. */
tau_s: number,
/** Deviation, in the axis' unit. */
deviation: number, };

/** An axis. Its range is that of the finite values (on a logarithmic axis, of the positive ones). */
export type Axis = {
/** Quantity and unit, as in `Rate (rad/s)`. */
label: string,
/** Spacing of the values. */
scale: Scale,
/** Names of the values 0, 1, …, in place of numbers. */
names: Array<string>, };

/** Comparison of one axis with the measurements. */
export type AxisComparison = {
/** Name in the log format, as `gx_rads`. */
column: string,
/** Unit of the column; squared errors are in its square. */
unit: string,
/** Number of evaluation rows at rest. */
rows: number,
/** Lowest mean square error of any causal predictor, in the square of the unit, with its 95 % interval. */
noise_floor: [number, [number, number]] | null,
/** Reasons to distrust these numbers. */
cautions: Array<string>,
/** Errors of the rivals, then of the model. */
errors: Array<ModelErrors>,
/** Stretches with an outstanding slow error, worst first: at most five, possibly none. */
worst: Array<Stretch>,
/** Dependence of the residual on all logged columns; absent if there are too few data. */
dependence: Dependence | null, };

/** An axis in a list. */
export type AxisEntry = { column: string, label: string, unit: string, sentence: string | null,
/** Effects that were added, in order. */
added: Array<string>,
/** RMS of the slow error in a free run, in `unit`, as in [`AxisPage`]: of the constant mean, and of the model. */
slow_error: [number | null, number | null] | null, errors_in: UnitChoice, };

/** Axis with its standing and the units in which its numbers are shown. */
export type AxisPage = { standing: Standing | null,
/** Reason why there is no model, comparison or diagnosis. */
failure: string | null,
/** RMS of the slow error in a free run, in the axis' unit: of the constant mean, and of the model. */
slow_error: [number | null, number | null] | null,
/** One entry per refinement step: true if its effect reduces the error by more than noise. */
pays: Array<boolean>, units: AxisUnits,
/** Column of the log format, such as `gx_rads`. */
column: string,
/** Name for people, such as `gyro x`. */
label: string,
/** Unit of the column, such as `rad/s`. */
unit: string,
/** Summary of the present model. */
model: ModelSummary | null,
/** Comparison of the present model with the log to explain. */
comparison: AxisComparison | null,
/** First and last timestamp of the compared rows, s. */
evaluated_s: [number, number] | null,
/** Effects missing from the present model. */
diagnosis: Diagnosis | null,
/** One offer for each finding of the diagnosis. */
offers: Array<Offer>,
/** Every step of the refinement, with the errors of its model. */
refinement: Refinement | null,
/** Refinement as a figure. */
staircase: Figure | null, };

/** An axis of a part. */
export type AxisReport = {
/** Column of the log format, such as `gx_rads`. */
column: string,
/** Name for people, such as `gyro x`. */
label: string,
/** Reason why there is no population. */
without: string | null,
/** Coefficients of the population. */
coefficients: Array<CoefficientReport>,
/** Effects that the diagnoses of units found. */
effects: Array<EffectReport>, };

export type AxisSeries = { axis: string, unit: string, from_s: number, to_s: number,
/** Period of the samples or of the means, s. */
period_s: number,
/** Length of the means, s; none for samples. */
mean_s: number | null,
/** True if every sample is included; otherwise each entry is a bucket. */
exact: boolean,
/** Timestamps, or middles of buckets, s. */
time_s: Array<number>,
/** Logged value, minus the reference where there is one. */
measured: LowAndHigh,
/** Measured value minus residual; none without a model. */
predicted: LowAndHigh | null,
/** Residual; none without a model. */
left: LowAndHigh | null,
/** The same two with the model before any effect was added; none if no effect was added. */
predicted_before: LowAndHigh | null, left_before: LowAndHigh | null,
/** Temperature and supply voltage, where they are logged. */
beside: Array<Beside>, };

/** One axis of a replay. */
export type AxisSummary = {
/** Column of the log format, such as `gx_rads`. */
column: string,
/** Number of rows with an innovation. */
innovations: number,
/** RMS of the innovations in f32, in the axis' unit; NaN without innovations. */
innovation_rms_f32: number | null,
/** RMS of the innovations in f64, in the axis' unit; NaN without innovations. */
innovation_rms_f64: number | null,
/** Largest difference between f32 and f64, in the axis' unit; NaN without innovations. */
largest_difference: number | null,
/** Largest difference between fixed point and f64, in the axis' unit; NaN also if the model does not run in fixed point. */
largest_difference_fixed: number | null,
/** Share of the tracked rows with a valid correction that does not lead away from gravity; NaN without tracked rows. */
valid_share: number | null,
/** Remaining errors at rest in f32, the same as those of a comparison; none if the device never rests. */
errors: ModelErrors | null, };

/** Units of an axis for people; the page chooses between field units and SI. */
export type AxisUnits = {
/** Measured values. */
measured: UnitChoice,
/** Errors and residuals. */
errors: UnitChoice,
/** Heading or position without aiding. */
unaided: UnitChoice,
/** N, B and K. */
noise: [UnitChoice, UnitChoice, UnitChoice],
/** Coefficients of findings, by the unit they are stored in. */
sizes: { [key in string]: UnitChoice }, };

/** Band in which an effect shows. */
export type Band = "slow" | "wide" | "data" | "stochastic";

/** Channel that is drawn below on the same time axis. */
export type Beside = { column: string, label: string, unit: string, values: LowAndHigh, };

/** Residual in one bin of a channel. */
export type Bin = {
/** Mean of the channel in the bin. */
channel: number, blocks: number,
/** Plain mean of the residual, in the axis' unit. */
mean: number,
/** Mean of the residual by generalised least squares, which weights the blocks by their correlated noise, relative
 * to the mean over all bins. */
level: number,
/** Half of the 95 % interval of `level` under coloured noise. */
half_width: number, };

/** Residual by bins of a channel. */
export type Bins = {
/** All blocks, by ascending value of the channel. */
all: Array<Bin>,
/** Blocks in which the channel rises; for temperatures only. */
rising: Array<Bin>,
/** Blocks in which the channel falls; for temperatures only. */
falling: Array<Bin>, };

/** One stretch of the log in one band. */
export type Cell = {
/** Begin as timestamp, s. */
begin_s: number,
/** End as timestamp, s. */
end_s: number,
/** Lower end of the band, Hz. */
low_hz: number,
/** Upper end of the band, Hz. */
high_hz: number,
/** Power divided by the usual power in this band. */
times: number,
/** Degrees of freedom of the power of noise. */
freedom: number,
/** Probability of such power in any cell under noise alone (Bonferroni over all cells). */
p: number, };

/** Dependence of the residual of an axis on one channel. */
export type ChannelDependence = {
/** Column of the channel, as `temp_c`. */
channel: string,
/** Unit of the channel. */
unit: string,
/** Test of a curve of the channel against a constant. */
curve: Test,
/** p of the curve, corrected for the number of channels (Bonferroni). */
p_of_all: number,
/** Residual by value of the channel. */
bins: Bins,
/** Residual by delay of the channel. */
lag: LagProfile, };

/** Coast error at one horizon. */
export type CoastError = {
/** Horizon, s. */
horizon_s: number,
/** Mean square error after exactly that time. */
mse: number,
/** Standard error of the mean, with the coasts taken as independent of one another. */
standard_error: number,
/** Number of coasts in the mean. */
origins: number, };

/** Coefficient over the units of a part; every number is in `unit`. */
export type CoefficientReport = {
/** Name: `bias`, or the regressor. */
name: string,
/** Unit of all numbers, such as `(°/s)/K`. */
unit: string,
/** Number of units in the population. */
units: number,
/** Number of named lots. */
lots: number,
/** Mean of the part. */
mean: number,
/** 90 % interval of `mean`. */
mean_interval: [number, number],
/** Standard deviation between units of a lot. */
between_units: number,
/** 90 % interval of `between_units`. */
between_units_interval: [number, number],
/** Standard deviation between lots; none with fewer than two lots. */
between_lots: number | null,
/** 90 % interval of `between_lots`. */
between_lots_interval: [number, number],
/** p-value of the observed difference between lots if lots do not differ; none with fewer than two lots. */
lots_alike: number | null,
/** Standard deviation of an estimate about the value of its unit: the error of a log. */
error_of_log: number,
/** Shares of the variance of estimates: lots, units, error of a log. */
shares: [number, number, number],
/** Remaining error for each way of calibrating. */
left: LeftBy,
/** Reasons not to trust the numbers, a sentence each. */
cautions: Array<string>,
/** Figure of the units about the population, and lot by lot. */
figure: Figure, };

/** A column of a file with its probable channel. */
export type ColumnPreview = { name: string,
/** Name as written in an entry of a column map. */
quoted: string, values: Array<string>,
/** Probable channel. */
target: string | null,
/** Probable unit. */
unit: string | null,
/** Scale and offset in front of the unit, as in `-32768*0.061`. */
arithmetic: string | null,
/** Column map entry for them; `None` if the name is sufficient. */
spec: string | null,
/** Reason for the guess. */
why: string,
/** True if the name alone determines it. */
sure: boolean,
/** Reason why its values cannot be in this unit. */
caution: string | null, };

/** A channel of a log. */
export type ColumnSummary = {
/** Name of the column, such as `gx_rads`. */
name: string,
/** Unit of the values, such as `rad/s`. */
unit: string, };

/** Another effect that an effect is confused with. */
export type ConfusedWith = {
/** Identifier of the other effect, as `thermal_lag`. */
effect: string,
/** Experiment that separates the two. */
separate: string, };

/** Term of a correction: coefficient times regressor, in the unit of the axis. */
export type CorrectionTerm = {
/** Products of inputs, their sum, or `clock:step(t)`, which is 1 from t seconds after the first sample on and in
 * every later log. */
regressor: string,
/** Coefficient, in the unit of the axis per unit of the regressor. */
coefficient: number, standard_error: number, };

/** Cost of the terms and inputs of an axis; the axis itself and the part shared by all axes are not included. */
export type Cost = {
/** Number of terms, physical and stochastic. */
terms: number,
/** Number of factors in all terms. */
factors: number, inputs: number,
/** RAM of terms and inputs, bytes. */
ram_bytes: number,
/** Approximate number of instructions per sample. */
instructions: number, };

export type Delay = {
/** Delay, s. */
delay_s: number,
/** Increase of 2 ln L with the delayed channel as a linear term, at the same noise levels for all delays. */
gain: number,
/** Coefficient of the channel, in the axis' unit per unit of the channel. */
slope: number,
/** Standard error of the coefficient. */
slope_error: number, };

/** Dependence of the residual of an axis on all logged columns. */
export type Dependence = {
/** Length of the blocks, s. */
block_s: number,
/** Number of blocks with enough data. */
blocks: number,
/** Noise levels without any channel. */
noise: NoiseLevels,
/** True if the noise prior is from the rows that the model was fitted to; else it is from the evaluation rows,
 * which is less certain. */
learnt: boolean,
/** Every channel that varies, lowest p first. */
channels: Array<ChannelDependence>,
/** Power by time and frequency. */
power: PowerMap, };

/** Search method of an effect: `search` in its file. */
export type Detector = "terms" | "step" | "line" | "wandering_line" | "saturation" | "dropped_samples" | "coarse_steps" | "gauss_markov" | "random_walk" | "telegraph" | "noise_level" | "dead_zone";

/** Diagnosis of one axis: the effects that are missing from its model. */
export type Diagnosis = {
/** Column that was explained. */
target: string,
/** Unit of the column, of the noise and of the corrections. */
unit: string, verdict: Verdict,
/** Outcome in a sentence. */
sentence: string,
/** Missing effects, best first, then faults of the data. */
findings: Array<FindingWithRms>,
/** Further quantities that the residual follows. They are leads, not findings. */
leads: Array<Lead>,
/** Effects that were tried and rejected, with their scores, the highest first. */
rejected: Array<Rejected>,
/** Slow effects that were tested. Empty if the log allows no such test; the verdict is then never
 * [`Verdict::NothingMissing`]. */
tested: Array<string>,
/** Effects that could not be tested, with the data that they need. */
untested: Array<Untested>,
/** Noise levels that the scores are based on. */
noise: NoiseReport,
/** Reasons to read the result with care. */
cautions: Array<string>,
/** Properties of the log that are neither faults nor reasons for doubt, such as its duty cycle. */
notes: Array<string>,
/** Detected motion in a log at rest, in words. */
moved: Array<string>,
/** Slow signal that the axis shares with other axes of the log, if several were diagnosed. */
shared_signal?: SharedSignal | null, };

/** A physical effect: its cause, its equation and how to search for it. */
export type Effect = {
/** Unique identifier, stable across releases: `thermal_lag`. */
id: string,
/** Name as it stands in a sentence. */
name: string,
/** Band of the error: block means, single samples, the data themselves, or noise. */
band: Band,
/** Axes that the effect can act on. */
targets: Targets,
/** Search method. */
search: Detector,
/** True if any subset of the terms is the effect too: terms that explain nothing are excluded. */
any_terms: boolean,
/** Physical mechanism in the sensor. */
mechanism: string, equation: string,
/** Typical size on phone-class parts. */
typical_size: string,
/** Reference for the typical size. */
source: string,
/** Experiment that shows the effect. */
experiment: string,
/** Signature in a plot. */
gives_away: string,
/** Cost of the correction on the device. */
device: string,
/** Terms whose coefficients are fitted; empty if the effect is not searched for by regression. */
terms: Array<EffectTerm>,
/** Parameter that is searched for. */
parameter: Parameter | null,
/** Effects that it is confused with, the most similar first. */
confused_with: Array<ConfusedWith>, };

/** Effect on an axis of a part. */
export type EffectReport = {
/** Identifier in the library, such as `thermal_lag`. */
effect: string,
/** Number of units with the effect, and number of diagnosed units. */
units: [number, number],
/** 90 % interval of the share of all units of the part that have the effect. */
share_interval: [number, number],
/** Predicted reduction if every unit's model had the effect: the mean over all diagnosed units. */
mean_reduction: number,
/** Cost of the effect on the device, in words. */
device: string, };

/** One regressor of an effect. */
export type EffectTerm = {
/** Products of inputs, or a sum of products: `ref_{target} * temp_c:lowpass({tau_s})`. */
regressor: string,
/** Axes that the term can act on, among those of the effect. */
targets: Targets,
/** Unit of the coefficient for a gyro. */
gyro: string | null,
/** Unit of the coefficient for an accelerometer. */
accelerometer: string | null,
/** Largest typical coefficient of a gyro, in its unit. */
gyro_typical?: number | null,
/** Largest typical coefficient of an accelerometer, in its unit. */
accelerometer_typical?: number | null, };

/** A study in a list. */
export type Entry = { id: number, name: string,
/** Worst outcome of its axes. */
outcome: Outcome | null, working: boolean,
/** Open axis with its results, for comparing studies side by side. */
axis: AxisEntry | null, };

/** A picture of one or more panels below each other. */
export type Figure = {
/** Headline. */
title: string,
/** Panels from top to bottom. Panels with the same x range are aligned. */
panels: Array<Panel>, };

export type FindingWithRms = {
/** Identifier in the library, as `thermal_lag`. */
effect: string, name: string,
/** Band of the error: block means, single samples, the data themselves, or noise. */
band: Band,
/** Value of the parameter, by name. */
params: { [key in string]: number },
/** 95 % intervals of the parameters, where they are known. */
params_interval: { [key in string]: [number | null, number | null] },
/** Sizes in data-sheet units, one per regressor. */
sizes: Array<Size>,
/** Decrease of −2 ln L. None for faults of the data, which are counted and not weighed. */
gain: number | null,
/** Gain minus a penalty for its coefficients and for every candidate tried; accepted from 9 (lines from 15). None
 * for faults of the data. */
score: number | null,
/** Predicted reduction as a share of the error's variance: of 1-s means (slow) or of samples (wide). */
expected_drop: number,
/** 90 % interval of the predicted reduction. */
expected_drop_ci: [number, number],
/** Reduction measured on the evaluation log, with the findings before it in the model; a share of the variance. */
realised_fall?: number | null,
/** Reason why the finding is not conclusive; `None` if it is conclusive. */
doubt?: string | null,
/** Effects that are indistinguishable from it in this log. */
confounded_with: Array<string>,
/** Experiments that separate them. */
separate: Array<Separation>,
/** Column against which the effect shows best, if any. */
shows_against: string | null,
/** Stretch of the log in which the effect is largest: begin and end as timestamps, s. */
shows_from_to_s: [number, number] | null,
/** Regressors with their coefficients in SI, as the model uses them. */
correction: Array<CorrectionTerm>,
/** Limits to which inputs are clamped, by the text of the input: the range in which a curve may be extrapolated. */
limits: { [key in string]: [number, number] }, rms_before?: number, rms_after?: number, rms_reduction?: number, rms_reduction_interval?: [number, number], measured_rms_reduction?: number, };

/** Report on a population. */
export type FleetReport = {
/** Program that wrote the report. */
tool: Tool,
/** Path of the population. */
path: string,
/** Regressors that the error may depend on, as requested. */
regressors: Array<string>,
/** True if units were diagnosed as well. */
diagnosed: boolean,
/** Reports on the parts, sorted by name. */
parts: Array<PartReport>, };

/** Axes in which values are given. */
export type Frame = "unstated" | "sensor" | "board" | "vehicle" | "phone";

/** A first-order Gauss-Markov process. */
export type GaussMarkov = {
/** Standard deviation, the axis' unit. */
deviation: number,
/** Correlation time, s. */
tau_s: number, };

/** Rests of a replay, and those at which the corrected specific force is further from gravity than the measured one by more than a valid
 * model can cause ([`leads_away`]). Such a model was fitted to other data, for example to two orientations. */
export type Gravity = {
/** Number of rests. */
rests: number,
/** Number of rows at rest. */
rows: number,
/** Rests with more than half of their rows away from gravity. */
rests_away: number,
/** Rows away from gravity. */
rows_away: number,
/** RMS over the rests of |a| − g, m/s²: of the mean measured and of the mean corrected specific force. */
residual_mps2: [number, number], };

/** Acceptance of the exported model by the hubs. */
export type Hubs = {
/** Refusal of a hub and its remedy, in the words of the command line; none if all hubs accept the model. */
refusal: string | null, };

/** Origin of the numbers of a series. A colour has the same meaning in every figure; the colours are those of Okabe & Ito (Color Universal
 * Design, 2008), distinguishable with any kind of colour vision. */
export type Ink = "Measured" | "Predicted" | "Residual" | "Floor" | "Bound" | "Other" | { "Step": number } | { "Method": number };

/** Description and progress of a job. */
export type Job = {
/** Description, such as `fitting gyro x`. */
what: string,
/** Number of steps done; none where it is unknown. */
done: number | null,
/** Total number of steps; none where it is unknown. */
of: number | null,
/** True if a user waits for the job, or for a later one: other requests should wait for the answer. */
asked_for: boolean, };

/** Source of the rows at rest. */
export type KnownBy = "column" | "detector" | "no_motion" | "assumed";

/** Gain by delay. */
export type LagProfile = { delays: Array<Delay>,
/** Delay with the largest gain, s. */
best_s: number,
/** Shortest and longest delay that are indistinguishable from the best, s. */
possible_s: [number, number],
/** Test of a linear term with the best delay, with the noise levels fitted. */
test: Test,
/** p of the test, corrected for the number of delays (Bonferroni). */
p: number, };

/** A quantity that the residual follows. */
export type Lead = {
/** Kind of lead. */
kind: LeadKind,
/** Description of the quantity. */
follows: string,
/** Decrease of −2 ln L. */
gain: number,
/** Gain minus a penalty for its coefficients and for every candidate tried. */
score: number,
/** Share of the variance of the block means of the residual. */
share: number,
/** Band of the lead: one in the samples does not contradict a slow effect. */
band: Band,
/** True if the lead alone decides the verdict; false if it is rare or negligibly small. */
decides: boolean, };

/** Kind of lead. */
export type LeadKind = "course" | "jumps" | "level" | "intermittent" | "refuted";

/** Residual of the physical part, in the square of the axis' unit. */
export type Left = {
/** Mean square of the 1-s means: about their mean, or, if the evaluation rows continue the log to explain, about the
 * bias of that. */
slow: number,
/** Variance of the samples. */
wide: number,
/** Error of the model's bias: mean on the evaluation rows minus the mean on the rows that effects are estimated
 * from, in the axis' unit. Absent if the log does not show the bias, and in studies of earlier versions. */
bias?: number | null, };

/** Standard deviation of the remaining error of a unit's coefficient, by the value in its model. */
export type LeftBy = {
/** The mean of the part. */
part_mean: number,
/** Mean of the unit's lot, for known lots; none with fewer than two lots. */
lot_mean: number | null,
/** Estimate from one log like these. */
own_log: number,
/** Estimate from one log combined with the population, for a unit of an unknown lot. */
with_population: number, };

/** A log that may be opened. */
export type Listed = {
/** Path by which the log is opened. */
path: string, bytes: number, };

/** Options for reading a log. The default suits a log with the columns of the log format. */
export type LoadOptions = {
/** Channel and unit of each column. */
columns: Array<string>,
/** Sampling rate, Hz; needed if the log has no timestamps, and overrides timestamps that show another rate. */
rate_hz?: number,
/** Format, unless it is to be recognised by content. */
format?: string,
/** Choice among several sensors of a log: number of an instance, or name of a topic. */
topic?: string,
/** Include rows with detected motion although the device should be at rest. */
keep_moved?: boolean, };

/** Paths of the logs of a study, and how they are read. */
export type LogFiles = {
/** The log to explain. */
log: string,
/** The reference log. */
reference: string | null,
/** The evaluation log. */
evaluation: string | null, read: LoadOptions, };

/** Logs that effects were estimated from and evaluated on. */
export type LogSources = {
/** Log to explain. */
log: Source,
/** Reference log for the noise. */
reference: Source | null,
/** Evaluation log; without one, the rows of the log to explain from `fitted_rows` on. */
evaluation: Source | null,
/** Number of rows of the log to explain, from the first on, that effects are estimated from. */
fitted_rows: number,
/** Channel and unit of each column. */
columns: Array<string>,
/** Sampling rate, Hz; needed if the log has no timestamps, and overrides timestamps that show another rate. */
rate_hz?: number,
/** Format, unless it is to be recognised by content. */
format?: string,
/** Choice among several sensors of a log: number of an instance, or name of a topic. */
topic?: string,
/** Include rows with detected motion although the device should be at rest. */
keep_moved?: boolean, };

/** Summary of a log. */
export type LogSummary = {
/** Path that the log was read from. */
path: string,
/** SHA-256 of the file, hexadecimal; of the first one if there are several. */
sha256: string,
/** Number of samples, of all segments together. */
rows: number,
/** Time from the first sample to the last, s. */
seconds: number,
/** First timestamp, s. */
from_s: number,
/** Last timestamp, s. */
to_s: number,
/** True sampling rate, Hz. */
rate_hz: number,
/** Number of gap-free segments. */
segments: number,
/** Number of samples missing between the segments. */
missing: number,
/** Share of the rows in which the device is still. */
still_share: number,
/** Source of `still_share`. */
still_known_by: KnownBy,
/** Channels of the log. */
columns: Array<ColumnSummary>,
/** Notes on quality, a line each: recognised format, alignment of streams, defects, detected motion, cautions. */
quality: Array<string>,
/** Detected motion of a device meant to be at rest, shaded wherever the log is drawn over time. */
moved: Shading, };

/** Minimum and maximum of each bucket; `None` without values. An f32 has seven digits, more than a screen shows, and
 * half the size for the browser to read. */
export type LowAndHigh = { low: Array<number | null>, high: Array<number | null>, };

/** Errors of one axis with one model. Squared errors are in the square of the axis' unit. A value is absent where the
 * data are too short for it. */
export type ModelErrors = {
/** Name of the model, as in tables. */
model: string,
/** Mean square one-step prediction error: measured − predicted from measured history, on the raw samples. */
one_step_mse: number,
/** Mean square error of a free run after exactly 1 s, 10 s and 60 s. */
coast: Array<CoastError>,
/** Mean square error of a free run over all evaluated rows, never restarted. */
coast_whole_mse: number,
/** Variance of the 1-s block means of the one-step residual, at rest. */
slow_error_one_step: number | null,
/** Variance of the 1-s block means of the residual of free runs of at most 60 s, at rest. */
slow_error_coast: number | null,
/** Variance of the samples of the one-step residual, at rest. */
wide_error_one_step: number,
/** Variance of the samples of the residual of free runs of at most 60 s, at rest. */
wide_error_coast: number,
/** Heading or position error after a time without aiding; empty for an axis that is neither gyro nor accelerometer,
 * and in studies of earlier versions. */
unaided: Array<UnaidedError>,
/** Allan deviation of the residual of free runs of at most 60 s. */
allan: Array<AllanValue>,
/** True if the one-step MSE is below the noise floor; such a result is not to be trusted. */
below_noise_floor: boolean,
/** Number of rows whose prediction has a caution (out of range, stuck, saturated, not finite, …). */
cautions: number, };

/** Summary of the model of an axis, for people. */
export type ModelSummary = {
/** Number of terms, physical and stochastic together. */
terms: number,
/** Number of candidates that were searched. */
candidates: number,
/** Search method. */
method: string,
/** Reason why the search stopped. */
stopped: string,
/** Terms of the stochastic part, in the order of their selection. */
monomials: Array<string>,
/** Terms of the physical part, as in a data sheet: `0.0123 ± 0.0004 (°/s)/K of temp_c`. */
physical: Array<string>, };

/** Figure with the name by which the page finds it: `residual`, `against:temp_c`. */
export type NamedFigure = { name: string, figure: Figure, };

/** Noise levels of an axis. */
export type NoiseLevels = {
/** White noise (angle or velocity random walk coefficient N), unit·√s: its mean over t seconds has variance N²/t. */
white: number,
/** Flicker noise: bias instability B, the axis' unit. */
flicker: number,
/** Random walk of the bias (rate random walk coefficient K), unit/√s. */
walk: number,
/** A further Gauss-Markov process in addition to those of the flicker noise. */
gauss_markov: GaussMarkov | null, };

/** Noise model behind a diagnosis. */
export type NoiseReport = {
/** Noise levels with all findings in the model, in the unit of the axis. */
levels: NoiseLevels,
/** Source of the noise levels, in words. */
learnt_from: string,
/** Length of the blocks for slow effects, s. */
block_s: number,
/** Number of blocks. */
blocks: number, };

/** Unit without results, or with results for some axes only. */
export type NotRead = {
/** Name of the unit. */
unit: string,
/** Lot of the unit. */
lot: string | null,
/** True if some axes have results. */
is_partly: boolean,
/** Reasons, a line each. */
reasons: Array<string>,
/** Remedies, each once. */
help: Array<string>, };

/** Unit that deviates significantly from its population. */
export type OddReport = {
/** Name of the unit. */
unit: string,
/** Lot of the unit. */
lot: string | null,
/** Axis with the smallest p-value, such as `gyro x`. */
label: string,
/** Coefficient that deviates most on that axis. */
coefficient: string,
/** Deviation from the population without the unit, in standard deviations: Student's t. */
by: number,
/** Probability that a unit of the population deviates this far on any of its axes. */
p_value: number,
/** Unit of `estimate` and `expected`. */
unit_of_size: string,
/** Estimate from the unit's own log, and half of its 90 % interval. */
estimate: [number, number] | null,
/** 90 % interval of the units of its lot. */
expected: [number, number] | null, };

/** Detected effect, offered for addition to the model. */
export type Offer = {
/** Identifier in the library, such as `thermal_lag`. */
effect: string,
/** True if the effect can be corrected sample by sample and the finding is conclusive. */
can_be_added: boolean,
/** Reason why the effect cannot be added, or the alternative; none if it can. */
why_not: string | null,
/** Physics of the effect. */
card: Effect,
/** Additional cost of the model on the device. */
cost: Cost | null,
/** Figure of the evidence. */
evidence: Figure | null, };

/** Outcome for an axis, or the worst of a study's axes; later ones are worse. */
export type Outcome = "nothing_missing" | "not_enough_data" | "data_fault" | "did_not_pay" | "unexplained" | "missing";

/** Everything that a page shows of a study, except time series. */
export type Page = { id: number, name: string, revision: number, job: Job | null, error: string | null,
/** Logs that were requested last; none for an example that is not written yet. */
files: LogFiles | null, logs: Summaries | null,
/** True if rows with detected motion are used like any others. */
keeps_moved: boolean,
/** Worst outcome of its axes; an all-clear only once all are diagnosed. */
outcome: Outcome | null,
/** True if the log to explain has enough orientations for a calibration by hand. */
is_turned: boolean,
/** True if every axis that can have a model has one, so that the study can be exported. */
is_whole: boolean, axis: string | null, axes: Array<AxisPage>, commands: Array<string>, };

/** A pair of axes with its content. */
export type Panel = {
/** Title, beside the legend. */
title: string,
/** Horizontal axis. */
x: Axis,
/** Vertical axis. */
y: Axis,
/** Series in the order of drawing, later ones on top. */
series: Array<Series>,
/** Ranges of x set apart by a shaded background; later ones on top. */
shading: Array<Shading>, };

/** Parameter of an effect, searched for on a logarithmic grid and then refined. */
export type Parameter = {
/** Name, with the unit as its last part: `tau_s`. */
name: string,
/** Unit of `low` and `high`; empty for a plain number. */
unit: string,
/** Lower end of the search range. */
low: number,
/** Upper end of the search range. */
high: number,
/** True if values below `low` give the same error, so that an estimate at `low` is only an upper bound. */
open_below?: boolean, };

/** Report on one part. */
export type PartReport = {
/** Name of the part; empty if the fleet has none. */
part: string,
/** Units that were read, and those that were not. */
read: UnitsRead,
/** Duplicate logs and reasons not to trust the numbers, a sentence each. */
cautions: Array<string>,
/** Figure of the sources of the differences between units; none where no axis has a population. */
variance: Figure | null,
/** Axes of the part. */
axes: Array<AxisReport>,
/** Units that deviate significantly from the population, the furthest first. */
odd: Array<OddReport>,
/** Reason why the search for odd units is not conclusive; none if it is conclusive. */
not_conclusive: string | null, };

/** A population, as `fos fleet report --json` prints it, and its units. */
export type PopulationPage = { report: FleetReport,
/** Units in the order of parts and names. */
units: Array<UnitEntry>, };

/** Power over time and frequency. */
export type PowerMap = {
/** Cells with enough data, band by band, ascending in time. */
cells: Array<Cell>, };

/** Columns of a file with their probable channels. */
export type Preview = {
/** Columns in the order of the file. */
columns: Array<ColumnPreview>,
/** Channels that a column can be mapped to. */
targets: Array<string>,
/** Possible units of each channel, the SI unit first. */
units: { [key in string]: Array<string> }, };

/** Provenance of the inertial values of a log. */
export type Provenance = {
/** Provenance of the accelerometers. */
accelerometers: SensorProvenance, gyros: SensorProvenance, };

/** Format as which a log was read, and the assumptions made. */
export type ReadAs = { format: string,
/** Columns, units, clock, frame, gravity, corrections already applied: in words. */
assumed: string,
/** Sensor, corrections and frame of the inertial values; absent in studies of earlier versions. */
provenance?: Provenance | null, };

/** Axis of a study that effects were added to. */
export type Refinement = {
/** Column of the axis. */
column: string, logs: LogSources,
/** Model before any effect was added, then after each. */
steps: Array<StepWithRms>, };

/** Effect that was tried and rejected. */
export type Rejected = {
/** Identifier in the library, as `thermal_lag`. */
effect: string,
/** Score of the effect alone on the log. */
score: number,
/** Reason for the rejection, if its score alone would have made it a finding. */
why?: string | null, };

/** Result of running the exported image over the evaluation log, or over the log to explain if there is none. */
export type Replayed = {
/** Path of the log. */
log: string, summary: Summary,
/** Command line with the same result. */
command: string,
/** Size of the image, bytes. */
bytes: number, };

/** An RMS with its 90 % interval. */
export type RmsInterval = {
/** RMS over the windows. */
rms: number,
/** Lower bound. */
low: number,
/** Upper bound. */
high: number, };

/** Spacing of the values along an axis. */
export type Scale = "Linear" | "Log";

/** Provenance of the three axes of a sensor. Fields that a log does not state are absent or `Unstated`. */
export type SensorProvenance = {
/** Number of the sensor as the autopilot counts it, from 0. */
instance?: number | null,
/** The autopilot's `device_id` of the sensor. */
device_id?: number | null,
/** Corrections that the values contain. */
values: Values,
/** Axes in which the values are given. */
frame: Frame, };

/** Experiment that separates a finding from a rival. */
export type Separation = {
/** Identifier of the rival. */
effect: string, experiment: string, };

/** Numbers to draw, all of one kind. */
export type Series = {
/** Text in the legend. Series with the same label share one entry (pieces of a recording with gaps); an empty label has none. */
label: string,
/** Origin of the numbers; decides the colour. */
ink: Ink,
/** Numbers and their shape. */
shape: Shape, };

/** One shaded range. */
export type ShadedRange = {
/** Left end, in units of x. */
from: number,
/** Right end, in units of x. */
to: number,
/** Short text at the top, such as a number. */
mark: string,
/** Description for a tooltip; empty if the legend suffices. */
says: string, };

/** Shaded ranges of x with one legend entry for all of them. */
export type Shading = {
/** Text in the legend. */
label: string,
/** Reason for the shading; decides the colour. */
tone: Tone,
/** Ranges of x. */
ranges: Array<ShadedRange>, };

/** Shape of a series. A value that is not finite (in JSON null) interrupts a line or band and is otherwise skipped. */
export type Shape = { "Line": Array<[number | null, number | null]> } | { "Band": Array<[number | null, number | null, number | null]> } | { "Points": Array<[number | null, number | null]> } | { "Bars": Array<[number | null, number | null, number | null, number | null]> } | { "Stems": Array<[number | null, number | null]> } | { "Level": number } | { "Cells": Array<[number | null, number | null, number | null, number | null]> } | { "Frames": Array<[number | null, number | null, number | null, number | null]> };

/** Slow signal that several axes of a log share. */
export type SharedSignal = {
/** Columns of the axes that share it. */
axes: Array<string>,
/** Correlation of the changes from one mean to the next, of each of these axes with the others. */
correlations: Array<number>,
/** Length of the means, s. */
mean_s: number,
/** Signal at each mean: time in s after the first sample, and value in standard deviations. */
course: Array<[number, number]>, };

/** A unit with its label for people; a stored value is divided by `divisor`. */
export type ShownUnit = { label: string, divisor: number, };

/** Coefficient in data-sheet units. */
export type Size = { of: string,
/** Value in `unit`. */
value: number,
/** 95 % interval in `unit`; in JSON an end that is not finite is null. */
interval: [number | null, number | null],
/** Unit as on data sheets. */
unit: string, };

/** File that a recording was read from. */
export type Source = {
/** Path as given; for data that never were a file, a description of their origin. */
path: string,
/** Size of the file, bytes (0: not a file). */
bytes: number,
/** SHA-256 of the file as stored (compressed, if it is), hexadecimal (empty: not a file). */
sha256: string,
/** Path relative to the folder of the study that names it; `None` without a study, or with an older one. */
from_study?: string | null,
/** Format and assumptions of the reader; `None` for the log format. */
read_as?: ReadAs | null, };

/** Standing of one axis. */
export type Standing = { outcome: Outcome, sentence: string,
/** Data to record so that the tests become possible. */
record: Array<string>, };

/** Status that is sent to the page with every change. */
export type StatusEvent = { revision: number, job: Job | null, };

export type StepWithRms = {
/** Effect added in this step; none in the first state. */
added: Added | null, model: unknown,
/** Errors on the evaluation rows. */
errors: ModelErrors,
/** Variances of the residual of the physical part on the evaluation rows. */
left: Left,
/** Cost of the axis on the device. */
cost: Cost, rms_before?: number, rms_after?: number, rms_reduction?: number, rms_reduction_interval?: [number, number], measured_rms_reduction?: number, };

/** A stretch of the recording. */
export type Stretch = {
/** Timestamp of the first row, s. */
begin_s: number,
/** Timestamp of the last row, s. */
end_s: number,
/** Slow error: RMS of the 1-s means of the residual in a free run of at most 60 s, in the axis' unit. */
rms: number,
/** Mean of the residual, in the axis' unit. */
mean: number,
/** `rms` divided by that of the median stretch. */
ratio: number,
/** Unusual channels and circumstances of the stretch, most striking first; empty if nothing logged is unusual. */
special: Array<string>, };

/** Summaries of the logs of a study. */
export type Summaries = {
/** Log to explain. */
log: LogSummary,
/** Reference log; none if not given. */
reference: LogSummary | null,
/** Evaluation log; none if not given. */
evaluation: LogSummary | null, };

/** Counts and digests of a replay. */
export type Summary = {
/** Number of rows. */
rows: number,
/** Number of tracked rows; the others are coasted. */
tracked: number,
/** Source of the decision between tracking and coasting. */
still_known_by: KnownBy,
/** Reason why the model does not run in fixed point; none if it does. */
not_in_fixed_point: string | null,
/** One summary for each axis of the image. */
axes: Array<AxisSummary>,
/** Rests at which the correction leads away from gravity; none unless all three accelerometers are in the model. */
gravity: Gravity | null,
/** CRC-64 of all innovations, tick by tick and axis by axis. Hexadecimal in JSON, because JSON numbers have 53 bits. */
innovations_digest: string,
/** CRC-64 of all innovations, corrected values before the calibration, and validities. */
corrections_digest: string, };

/** Axes that an effect can act on. */
export type Targets = "any" | "gyro" | "accelerometer";

/** Test whether further regressors explain more than noise does. */
export type Test = { terms: number,
/** 2Δ ln L with the noise levels fitted with and without the regressors. */
gain: number,
/** Gain minus `terms`·ln(blocks), the penalty of coefficients (Schwarz 1978). */
score: number,
/** Number of independent samples equivalent to the data and the prior, for the noise in the directions of the
 * regressors. */
effective_samples: number,
/** Probability of such a gain without any dependence. */
p: number, };

/** Reason for the shading of a range. */
export type Tone = "Apart" | "LeftOut";

/** Program that wrote a study. */
export type Tool = {
/** Name of the program on the command line. */
name: string, version: string, };

/** Error of one axis after a time without aiding, over all windows of that length. */
export type UnaidedError = {
/** Length of the windows, s. */
window_s: number,
/** Number of whole windows that were measured throughout. Below [`FEWEST_WINDOWS`] the log is too short for an RMS. */
windows: number,
/** Heading error at the end of a window, rad; for a gyro axis, and for six axes together. */
heading_rad?: RmsInterval,
/** Position error at the end of a window, m; for an accelerometer axis, and for six axes together. */
position_m?: RmsInterval, };

/** An axis of a unit. */
export type UnitAxis = {
/** Name for people, such as `gyro x`. */
label: string,
/** Coefficients of the population of the axis. */
coefficients: Array<UnitCoefficient>,
/** Effects that the diagnosis found. */
effects: Array<string>, };

/** A unit in both systems. */
export type UnitChoice = { field: ShownUnit, si: ShownUnit, };

/** Coefficient of a unit: values in `unit`, each with half of its 90 % interval. */
export type UnitCoefficient = {
/** Name: `bias`, or the regressor. */
name: string,
/** Unit of the values, such as `(°/s)/K`. */
unit: string,
/** Estimate from the unit's own log; none where the log does not determine it. */
own: [number, number] | null,
/** Middle and half of the 90 % interval of the units of its lot. */
expected: [number, number],
/** Own estimate combined with the population, as shipped; for an odd unit its own estimate alone. */
together: [number, number],
/** Deviation of the own estimate from the expected value, in standard deviations. */
by: number | null, };

/** A unit in a list. */
export type UnitEntry = { part: string, unit: string, lot: string | null, };

/** A unit, and its log. */
export type UnitPage = { report: UnitReport,
/** Path by which its log is opened; none if it is not in a folder that may be read. */
log: string | null, };

/** Report on one unit. */
export type UnitReport = {
/** Name of the unit. */
unit: string,
/** Part of the unit. */
part: string,
/** Lot of the unit. */
lot: string | null,
/** True if the unit deviates significantly from its population. */
is_odd: boolean,
/** Length of the log, s. */
seconds: number | null,
/** Lowest and highest temperature in the log, °C. */
temperature_c: [number, number] | null,
/** Reasons why the log or an axis has no results. */
failed: Array<string>,
/** Axes that have a population. */
axes: Array<UnitAxis>, };

/** Counts of the units of a part, and ranges of their logs. */
export type UnitsRead = {
/** Number of units. */
units: number,
/** Number of units with complete results. */
whole: number,
/** Number of units with results for some axes only. */
partly: number,
/** Number of units without results. */
nothing: number,
/** Number of named lots. */
lots: number,
/** Shortest, median and longest length of a log, s. */
seconds: [number, number, number] | null,
/** Lowest and highest temperature of all logs, °C. */
temperature_c: [number, number] | null,
/** Change of temperature within a log, median over the logs, K. */
warming_k: number | null,
/** Units without complete results, at most 100. */
not_read: Array<NotRead>,
/** Number of further units without complete results. */
more: number, };

/** Effect that could not be tested. */
export type Untested = {
/** Identifier in the library, as `thermal_lag`. */
effect: string,
/** Data that the log lacks: a column that is absent, begins too late or never changes, or time at rest. */
needs: Array<string>, };

/** Corrections that logged values contain. */
export type Values = "unstated" | "raw" | { "corrected": string };

/** Outcome of a diagnosis. */
export type Verdict = "missing" | "nothing_missing" | "unexplained" | "not_enough_data";

/** Predictions that are shown with the measurements. */
export type ViewKind = "one_step" | "coast" | "slow";

/** Request for a new study: the example, or logs. */
export type Wanted = { example?: boolean, log?: string | null, reference?: string | null, evaluation?: string | null, columns?: Array<string>, rate_hz?: number | null, };
