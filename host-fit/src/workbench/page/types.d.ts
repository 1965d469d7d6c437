// What the server answers with, from its Rust types. Written by
// FOS_WRITE_PAGE_TYPES=1 cargo test -p host-fit --lib page_types

/** An effect that was added. */
export type Added = {
/** The effect itself: the study can be read without the file it came from. */
effect: Effect,
/** What it was found to be, with the reduction that is predicted. */
finding: FindingWithRms,
/** The reduction that was measured, in the band of the effect. */
realised_fall: number, };

/** Allan deviation at one averaging time. */
export type AllanValue = {
/** Averaging time, s. */
tau_s: number,
/** Deviation, in the axis' unit. */
deviation: number, };

/** An axis. Its range is that of the finite values drawn (on a logarithmic axis, of the positive ones). */
export type Axis = {
/** Quantity and unit, as in `Rate (rad/s)`. */
label: string,
/** Spacing of the values. */
scale: Scale,
/** Names of the values 0, 1, …, in place of numbers. */
names: Array<string>, };

/** One axis against the measurements. */
export type AxisComparison = {
/** As in the log format, as `gx_rads`. */
column: string,
/** Unit of the column; errors are in its square. */
unit: string,
/** Rows at rest that were judged. */
rows: number,
/** What no causal predictor can beat, in the square of the unit, and its 95 % interval. */
noise_floor: [number, [number, number]] | null,
/** Why the floor should not be trusted. */
floor_cautions: Array<string>,
/** The rivals, then the model. */
errors: Array<ModelErrors>,
/** Stretches whose slow error stands out, worst first: at most five, none where no stretch stands out. */
worst: Array<Stretch>,
/** What is left against everything that is logged; absent where that is too little to tell. */
dependence: Dependence | null, };

/** An axis in a list. */
export type AxisEntry = { column: string, label: string, unit: string, sentence: string | null,
/** Effects that were added, in order. */
added: Array<string>,
/** Root of the variance of the 1-s means that are left on unseen data, before the first effect and now, in the
 * unit. */
slow_before: number | null, slow_now: number | null, errors_in: UnitChoice, };

/** An axis with its standing and the units that its numbers are shown in. */
export type AxisPage = { standing: Standing | null,
/** Why there is no model, comparison or diagnosis. */
failure: string | null,
/** RMS of the slow error in a free run, in the unit: of the constant mean, and of the model. */
slow_error: [number | null, number | null] | null,
/** Of each refinement step: whether its effect reduces the error by more than noise. */
pays: Array<boolean>, units: AxisUnits,
/** As in the log format, as `gx_rads`. */
column: string,
/** As in `gyro x`. */
label: string,
/** Unit of the column, as `rad/s`. */
unit: string,
/** Its model as it is now. */
model: ModelSummary | null,
/** The model as it is now against the field log. */
comparison: AxisComparison | null,
/** First and last time stamp that the comparison is of, s. */
judged_s: [number, number] | null,
/** What is missing from the model as it is now. */
diagnosis: Diagnosis | null,
/** One for each finding of the diagnosis. */
offers: Array<Offer>,
/** Every step of the model, with its errors. */
growth: Refinement | null,
/** The same as a figure. */
staircase: Figure | null, };

/** An axis of a part. */
export type AxisReport = {
/** As in the log format, as `gx_rads`. */
column: string,
/** As in `gyro x`. */
label: string,
/** Why there is no population. */
without: string | null,
/** Its coefficients. */
coefficients: Array<CoefficientReport>,
/** The effects that units were found to have. */
effects: Array<EffectReport>, };

export type AxisSeries = { axis: string, unit: string, from_s: number, to_s: number,
/** Of the samples, or of the means. */
period_s: number,
/** Length of the means, s; none of samples. */
mean_s: number | null,
/** Every sample is there; else each entry is a bucket. */
exact: boolean,
/** Stamps, or middles of buckets, s. */
time_s: Array<number>,
/** As logged, less the reference where there is one. */
measured: LowAndHigh,
/** Measured less what is left; none without a model. */
predicted: LowAndHigh | null,
/** What is left. */
left: LowAndHigh | null,
/** The same two with the model before any effect was added; none where none was. */
predicted_before: LowAndHigh | null, left_before: LowAndHigh | null,
/** Temperature and supply voltage, where they are logged. */
beside: Array<Beside>, };

/** One axis of a replay. */
export type AxisSummary = {
/** As in the log format, as `gx_rads`. */
column: string,
/** Rows with an innovation. */
innovations: number,
/** Root mean square of the innovations in f32, in the axis' unit; NaN where there are none. */
innovation_rms_f32: number | null,
/** The same in f64. */
innovation_rms_f64: number | null,
/** Largest difference between the two, in the axis' unit; NaN where there are none. */
largest_difference: number | null,
/** The same between fixed point and f64; NaN also where the model does not fit it. */
largest_difference_fixed: number | null,
/** Share of the tracked rows whose correction is valid, and does not lead away from gravity; NaN where none was
 * tracked. */
valid_share: number | null,
/** What is left at rest, in f32: the same errors as those of a comparison; none where the unit never rests. */
errors: ModelErrors | null, };

/** Units of an axis for people; the page chooses between field units and SI. */
export type AxisUnits = {
/** Measured values. */
measured: UnitChoice,
/** Errors and residuals. */
errors: UnitChoice,
/** N, B and K. */
noise: [UnitChoice, UnitChoice, UnitChoice],
/** Coefficients of findings, by the unit they are stored in. */
sizes: { [key in string]: UnitChoice }, };

/** Where an effect shows. */
export type Band = "slow" | "wide" | "data" | "stochastic";

/** What a page is told without asking. */
export type Beat = { revision: number, job: Job | null, };

/** A channel that is drawn under the same time axis. */
export type Beside = { column: string, label: string, unit: string, values: LowAndHigh, };

/** What is left in one bin of a channel. */
export type Bin = {
/** Mean of the channel in it. */
channel: number, blocks: number,
/** Plain mean of what is left, in the axis' unit. */
mean: number,
/** The same less the mean over all bins, every block weighed by what its noise, and that of its neighbours, leaves
 * of it (generalised least squares). */
level: number,
/** Half of the 95 % interval of `level`, under noise as it is coloured. */
half_width: number, };

/** What is left, bin by bin. */
export type Bins = {
/** All blocks, by ascending value of the channel. */
all: Array<Bin>,
/** Blocks where the channel rises; only of a temperature. */
rising: Array<Bin>,
/** Blocks where it falls. */
falling: Array<Bin>, };

/** An effect in plain language: texts of the library. */
export type Card = {
/** As in the library, as `thermal_lag`. */
id: string,
/** Name, as in a sentence. */
name: string,
/** In block means, in single samples, in the data themselves, or as noise. */
band: Band,
/** What happens in the sensor. */
mechanism: string,
/** The error it makes. */
equation: string,
/** How large it is on phone-class parts. */
typical_size: string,
/** Where that comes from. */
source: string,
/** Which experiment shows it. */
experiment: string,
/** What in a plot gives it away. */
gives_away: string,
/** What it costs on the device, in words. */
device: string, };

/** One stretch of the log in one band. */
export type Cell = {
/** Begin, s as stamped. */
begin_s: number,
/** End, s. */
end_s: number,
/** Lower end of the band, Hz. */
low_hz: number,
/** Upper end, Hz. */
high_hz: number,
/** Power over the usual in this band. */
times: number,
/** Degrees of freedom of that power where it is noise. */
freedom: number,
/** Chance of so much power somewhere where nothing is wrong anywhere: allowing for all cells (Bonferroni). */
p: number, };

/** What is left of an axis, against one channel. */
export type ChannelDependence = {
/** Its column, as `temp_c`. */
channel: string,
/** Unit that the channel's values are in. */
unit: string,
/** A curve of the channel against a constant. */
curve: Test,
/** p of the curve after allowing for all channels (Bonferroni). */
p_of_all: number,
/** What is left by value of the channel. */
bins: Bins,
/** What is left by delay of the channel. */
lag: LagProfile, };

/** Coast error at one horizon. */
export type CoastError = {
/** Horizon, s. */
horizon_s: number,
/** Mean square error after exactly that time. */
mse: number,
/** Standard error of the mean, coasts taken as independent of one another. */
standard_error: number,
/** Coasts that it is the mean of. */
origins: number, };

/** A coefficient over units; every number is in `unit`. */
export type CoefficientReport = {
/** `bias`, or the regressor. */
name: string,
/** As in `dps/K`. */
unit: string,
/** Units that the population is of. */
units: number,
/** Lots with a name. */
lots: number,
/** Mean of the part. */
mean: number,
/** Its 90 % interval. */
mean_interval: [number, number],
/** Standard deviation between units of a lot. */
between_units: number,
/** Its 90 % interval. */
between_units_interval: [number, number],
/** Standard deviation between lots; none where they cannot be told. */
between_lots: number | null,
/** Its 90 % interval. */
between_lots_interval: [number, number],
/** How often lots that do not differ would look so different. */
lots_alike: number | null,
/** Standard deviation of an estimate about its unit. */
error_of_log: number,
/** Of the variance of estimates: lots, units, error of a log. */
shares: [number, number, number],
/** What each way of calibrating leaves. */
left: LeftBy,
/** When its numbers are not to be trusted, a sentence each. */
cautions: Array<string>,
/** Units about the population, and lot by lot. */
figure: Figure, };

/** A column of a file, and what it may be. */
export type ColumnPreview = { name: string,
/** The same as it stands in an entry of a column map. */
quoted: string, values: Array<string>,
/** The channel that it seems to be. */
target: string | null,
/** The unit that it seems to be in. */
unit: string | null,
/** Scale and offset in front of the unit, as in `-32768*0.061`. */
arithmetic: string | null,
/** The column map entry for that; none where the name says all. */
spec: string | null,
/** What the guess rests on. */
why: string,
/** Whether its name alone settles it. */
sure: boolean,
/** Reason why its values cannot be in this unit. */
caution: string | null, };

/** A channel of a log. */
export type ColumnSummary = {
/** Its column, as `gx_rads`. */
name: string,
/** Unit that its values are in, as `rad/s`. */
unit: string, };

/** An effect that another is confused with. */
export type ConfusedWith = {
/** Identifier of the rival, as `thermal_lag`. */
effect: string,
/** The experiment that separates the two. */
separate: string, };

/** One term of a correction: coefficient times regressor, in the axis' unit. */
export type CorrectionTerm = {
/** Products of inputs, their sum, or `clock:step(t)`: 1 from t seconds after the first sample on, and in every
 * later log. */
regressor: string,
/** Coefficient, unit of the axis per unit of the product. */
coefficient: number, standard_error: number, };

/** What the terms and inputs of an axis cost; the axis itself and what all axes share come on top. */
export type Cost = {
/** Physical and stochastic together. */
terms: number,
/** Factors of all terms. */
factors: number, inputs: number,
/** RAM of terms and inputs, bytes. */
ram_bytes: number,
/** Instructions a sample, about. */
instructions: number, };

export type Delay = {
/** The delay, s. */
delay_s: number,
/** By how much 2 ln L rises with the delayed channel as a linear term; the same noise levels for all delays. */
gain: number,
/** Its coefficient, the axis' unit per unit of the channel. */
slope: number,
/** Standard error of the coefficient. */
slope_error: number, };

/** What is left of an axis, against everything that is logged. */
export type Dependence = {
/** Length of the blocks that means were taken over, s. */
block_s: number,
/** Blocks with enough data. */
blocks: number,
/** The noise, with no channel taken into account. */
noise: NoiseLevels,
/** The noise was learnt from the rows that the model was fitted to; else from the judged rows themselves, which is
 * less sure. */
learnt: boolean,
/** Every channel that changes, least likely first. */
channels: Array<ChannelDependence>,
/** Power by time and frequency. */
power: PowerMap, };

/** What looks for an effect: `search` in its file. */
export type Detector = "terms" | "step" | "line" | "wandering_line" | "saturation" | "dropped_samples" | "coarse_steps" | "gauss_markov" | "random_walk" | "telegraph" | "noise_level" | "dead_zone";

/** What is missing from a model on a log. */
export type Diagnosis = {
/** The column that was explained. */
target: string,
/** Unit of the column, which noise and corrections are in. */
unit: string, verdict: Verdict,
/** The outcome in a sentence. */
sentence: string,
/** Missing effects, best first, then faults of the data. */
findings: Array<FindingWithRms>,
/** What else the log follows; leads and no findings. */
leads: Array<Lead>,
/** Effects that were tried and rejected, with their score; the nearest first. */
rejected: Array<Rejected>,
/** Slow effects that were tested. Empty if the log allows no such test; the verdict is then never
 * [`Verdict::NothingMissing`]. */
tested: Array<string>,
/** Effects that could not be tested, with the data that would be needed. */
untested: Array<Untested>,
/** The noise levels that the evidence rests on. */
noise: NoiseReport,
/** Why the answer should be taken with care. */
cautions: Array<string>,
/** Properties of the log that are neither faults nor reasons for doubt, as its duty cycle. */
notes: Array<string>,
/** When the unit was moved though it was meant to be at rest, in words. */
moved: Array<string>,
/** A slow signal that the axis shares with others of the log, where several were diagnosed. */
shared_signal?: SharedSignal | null, };

/** A physical effect: what it is, and how it is looked for. */
export type Effect = {
/** Identifier, the same everywhere. */
id: string,
/** Name, as in a sentence. */
name: string,
/** In block means, in single samples, in the data themselves, or as noise. */
band: Band,
/** Which axes it can strike. */
targets: Targets,
/** How it is looked for. */
search: Detector,
/** Any of its terms alone is the effect too: those that explain nothing are left out. */
any_terms: boolean,
/** What happens in the sensor. */
mechanism: string, equation: string,
/** How large it is on phone-class parts. */
typical_size: string,
/** Where that comes from. */
source: string,
/** Which experiment shows it. */
experiment: string,
/** What in a plot gives it away. */
gives_away: string,
/** What it costs on the device. */
device: string,
/** Terms whose coefficients are fitted; none where it is not looked for by regression. */
terms: Array<EffectTerm>,
/** The parameter that is searched for. */
parameter: Parameter | null,
/** What it is confused with, the most similar first. */
confused_with: Array<ConfusedWith>, };

/** An effect on an axis of a part. */
export type EffectReport = {
/** As in the library. */
effect: string,
/** Units that have it, and units that were asked. */
units: [number, number],
/** The 90 % interval of the share of all units of the part that have it. */
share_interval: [number, number],
/** By how much the error should fall if every unit's model had it, in the mean over all units. */
mean_reduction: number,
/** What it costs on the device. */
device: string, };

/** One regressor of an effect. */
export type EffectTerm = {
/** Products of inputs, or their sum, as `ref_{target} * temp_c:lowpass({tau_s})`. */
regressor: string,
/** Axes that it can strike, among those of the effect. */
targets: Targets,
/** Unit of its coefficient for a gyro. */
gyro: string | null,
/** Unit of its coefficient for an accelerometer. */
accelerometer: string | null,
/** The largest coefficient that is typical of a gyro, in its unit. */
gyro_typical?: number | null,
/** The same of an accelerometer. */
accelerometer_typical?: number | null, };

/** A study in a list. */
export type Entry = { id: number, name: string,
/** The worst of its axes. */
outcome: Outcome | null, working: boolean,
/** The axis that is looked at, with what is known of it: what studies are held side by side by. */
axis: AxisEntry | null, };

/** A picture of one or more panels below each other. */
export type Figure = {
/** Headline. */
title: string,
/** From top to bottom. Panels that show the same x range line up. */
panels: Array<Panel>, };

export type FindingWithRms = {
/** As in the library, as `thermal_lag`. */
effect: string, name: string,
/** In block means, in single samples, in the data themselves, or as noise. */
band: Band,
/** Its parameter, by name. */
params: { [key in string]: number },
/** 95 % intervals of the parameters, where they are known. */
params_interval: { [key in string]: [number | null, number | null] },
/** Its size in data-sheet units, one per regressor. */
sizes: Array<Size>,
/** By how much −2 ln L falls with it. None for faults of the data, which are counted and not weighed. */
gain: number | null,
/** The gain after the price of its coefficients and of everything that was tried; accepted from 9 (lines from 15).
 * None for faults of the data. */
score: number | null,
/** Share of the error of its band that should go: of the variance of 1-s means (slow), of the samples (wide). */
expected_drop: number,
/** Its 90 % interval. */
expected_drop_ci: [number, number],
/** The reduction that was measured on the log that was given to judge on, those before it in the model. */
realised_fall?: number | null,
/** Why it is no claim; none where nothing speaks against it. */
doubt?: string | null,
/** Effects that this log cannot tell from it. */
confounded_with: Array<string>,
/** The experiments that separate them. */
separate: Array<Separation>,
/** The column against which it shows best, if any. */
shows_against: string | null,
/** Where in the log it is largest: begin and end, s as stamped. */
shows_from_to_s: [number, number] | null,
/** Its regressors and their coefficients in SI, as the model takes them. */
correction: Array<CorrectionTerm>,
/** Limits that inputs are kept inside, by their text: how far a curve may be followed. */
limits: { [key in string]: [number, number] }, rms_before?: number, rms_after?: number, rms_reduction?: number, rms_reduction_interval?: [number, number], measured_rms_reduction?: number, };

/** What a population says. */
export type FleetReport = {
/** The program that wrote it. */
tool: Tool,
/** Where the population was read. */
path: string,
/** What the error may depend on, as it was asked. */
regressors: Array<string>,
/** Units were diagnosed too. */
diagnosed: boolean,
/** Each part. */
parts: Array<PartReport>, };

/** Axes that values are given in. */
export type Frame = "unstated" | "sensor" | "board" | "vehicle" | "phone";

/** A first-order Gauss-Markov process. */
export type GaussMarkov = {
/** Standard deviation, the axis' unit. */
deviation: number,
/** Correlation time, s. */
tau_s: number, };

/** The rests of a replay, and those whose corrected specific force is further from gravity than as measured, by more
 * than a sound model can lead it ([`leads_away`]): the model was fitted to something else, as to two poses. */
export type Gravity = {
/** Rests. */
rests: number,
/** Rows at rest. */
rows: number,
/** Rests that most rows of are away from gravity. */
rests_away: number,
/** Rows that are. */
rows_away: number, };

/** Whether the device takes what is exported. */
export type Hubs = {
/** Which hub refuses the model, and what to do, in the words of the command line; none if all take it. */
refusal: string | null, };

/** Whose numbers a series shows. The same colour means the same thing in every figure; the colours are those of
 * Okabe & Ito (Color Universal Design, 2008), told apart with any kind of colour vision. */
export type Ink = "Measured" | "Predicted" | "Residual" | "Floor" | "Bound" | "Other" | { "Step": number } | { "Method": number };

/** What a job is doing. */
export type Job = {
/** As in `fitting gyro x`. */
what: string,
/** Steps done. */
done: number | null,
/** Steps in all; none where that is not known. */
of: number | null,
/** Somebody waits for it, or for what comes after it: what else could be asked for should wait for the answer. */
asked_for: boolean, };

/** How it is known where the unit is still. */
export type KnownBy = "column" | "detector" | "assumed";

/** The profile over delays. */
export type LagProfile = { delays: Array<Delay>,
/** The delay that explains most, s. */
best_s: number,
/** The shortest and longest delay that the log does not tell from it, s. */
possible_s: [number, number],
/** A linear term with that delay, noise levels fitted along. */
test: Test,
/** Its p after allowing for all delays (Bonferroni). */
p: number, };

/** Something that what is left follows. */
export type Lead = {
/** What kind of remainder it is. */
kind: LeadKind,
/** What it follows, in words. */
follows: string,
/** By how much −2 ln L falls with it. */
gain: number,
/** The gain after the price of its coefficients and of everything that was tried. */
score: number,
/** Its share of the variance of the block means of what is left. */
share: number,
/** In block means or in the samples: what shows in the samples alone says nothing against a slow effect. */
band: Band,
/** Whether it alone makes an answer: not what is hardly ever there, or so small that nobody would notice. */
decides: boolean, };

/** What kind of remainder a lead is. */
export type LeadKind = "course" | "jumps" | "level" | "intermittent" | "refuted";

/** What the physical part leaves of the error, in the square of the axis' unit. */
export type Left = {
/** Variance of 1-s means. */
slow: number,
/** Variance of the samples. */
wide: number,
/** Mean on the judged rows less that on the rows that effects are estimated from, in the axis' unit: what the
 * model's bias is off by. Absent where the log does not tell, and in studies from before it was kept. */
bias?: number | null, };

/** Standard deviation of the error of a unit's coefficient, by what its model has. */
export type LeftBy = {
/** The mean of the part. */
part_mean: number,
/** The mean of the unit's lot, over the lots that are known; none where lots cannot be told. */
lot_mean: number | null,
/** The estimate of a log as these are. */
own_log: number,
/** The same beside the population, for a unit of a lot that is not known. */
with_population: number, };

/** A log that may be opened. */
export type Listed = {
/** As it is opened. */
path: string,
/** Size. */
bytes: number, };

/** How a log is read. The default suits a log with the columns of the log format. */
export type LoadOptions = {
/** Which column is which channel, in what unit. */
columns: Array<string>,
/** Sample rate, Hz; needed if the log has no time stamps, and replaces stamps that show another rate. */
rate_hz?: number,
/** The format, where it is not to be found by the content. */
format?: string,
/** Which of several sensors, where a log has more than one: the number of an instance, the name of a topic. */
topic?: string,
/** Count the rows in which the unit was moved as any others, though it was meant to be at rest. */
keep_moved?: boolean, };

/** Paths of the logs of a study, and how they are read. */
export type LogFiles = {
/** The log to explain. */
field: string,
/** The reference log. */
quiet: string | null,
/** The evaluation log. */
judged: string | null, read: LoadOptions, };

/** The logs that effects were estimated from and judged on. */
export type LogSources = {
/** The log with the hidden effect. */
field: Source,
/** A quiet log that the noise was learnt from. */
quiet: Source | null,
/** The log that the errors are of; none: the rows of the field log from `fitted_rows` on. */
judged: Source | null,
/** Rows of the field log that effects are estimated from, from the first on. */
fitted_rows: number,
/** Which column is which channel, in what unit. */
columns: Array<string>,
/** Sample rate, Hz; needed if the log has no time stamps, and replaces stamps that show another rate. */
rate_hz?: number,
/** The format, where it is not to be found by the content. */
format?: string,
/** Which of several sensors, where a log has more than one: the number of an instance, the name of a topic. */
topic?: string,
/** Count the rows in which the unit was moved as any others, though it was meant to be at rest. */
keep_moved?: boolean, };

/** A log in a few facts. */
export type LogSummary = {
/** Where it was read from. */
path: string,
/** Digest of the file. */
sha256: string,
/** Samples that were read, of all segments together. */
rows: number,
/** From the first sample to the last, s. */
seconds: number,
/** First stamp, s. */
from_s: number,
/** Last stamp, s. */
to_s: number,
/** True sample rate, Hz. */
rate_hz: number,
/** Stretches without gaps. */
segments: number,
/** Samples missing between them. */
missing: number,
/** Share of the rows in which the unit is still. */
still_share: number,
/** How that is known. */
still_known_by: KnownBy,
/** Its channels. */
columns: Array<ColumnSummary>,
/** As what it was read, how its streams were joined, and what was wrong with it, a line each. */
quality: Array<string>,
/** Where the unit was moved though it was meant to be at rest, as it is shaded wherever the log is drawn over time. */
moved: Shading, };

/** The lowest and the highest of each bucket; `None` where there is nothing. In f32, which keeps seven digits: more
 * than a screen shows, half the size of what a browser has to read. */
export type LowAndHigh = { low: Array<number | null>, high: Array<number | null>, };

/** What is left of the error of one axis with one model. Squares are in the square of the axis' unit. A value is
 * absent where the data are too short for it. */
export type ModelErrors = {
/** Its name, as in tables. */
model: string,
/** Mean square of measured − predicted from measured history, on the raw samples. */
one_step_mse: number,
/** The same from own history after exactly 1 s, 10 s and 60 s. */
coast: Array<CoastError>,
/** The same from own history over all judged rows, never starting anew. */
coast_whole_mse: number,
/** Variance of 1-s block means of what is left, one-step, while still. */
slow_error_one_step: number | null,
/** Variance of 1-s block means of what is left, coasting for at most 60 s, while still. */
slow_error_coast: number | null,
/** Variance of the samples of what is left, one-step, while still. */
wide_error_one_step: number,
/** Variance of the samples of what is left, coasting for at most 60 s, while still. */
wide_error_coast: number,
/** The paper's column, from the one-step MSE, m; absent for an axis that is neither accelerometer nor gyro. */
position_error_m: number | null,
/** Allan deviation of what is left when coasting for at most 60 s. */
allan: Array<AllanValue>,
/** The one-step MSE is below the noise floor: not to be trusted. */
below_noise_floor: boolean,
/** Rows whose prediction came with a caution (out of range, stuck, saturated, not finite, …). */
cautions: number, };

/** The model of an axis in words. */
export type ModelSummary = {
/** Physical and stochastic together. */
terms: number,
/** Candidates that were searched. */
candidates: number,
/** By which method. */
method: string,
/** Why the search stopped. */
stopped: string,
/** Terms of the stochastic part, in the order of their selection. */
monomials: Array<string>,
/** Terms of the physical part. */
physical: Array<PhysicalTerm>, };

/** A figure, by what the page looks for it by: `residual`, `against:temp_c`. */
export type NamedFigure = { name: string, figure: Figure, };

/** Noise levels of an axis. */
export type NoiseLevels = {
/** White noise (angle or velocity random walk coefficient N), unit·√s: its mean over t seconds has variance N²/t. */
white: number,
/** Flicker noise: bias instability B, the axis' unit. */
flicker: number,
/** Random walk of the bias (rate random walk coefficient K), unit/√s. */
walk: number,
/** A further Gauss-Markov process beyond those that make the flicker. */
gauss_markov: GaussMarkov | null, };

/** The noise behind a diagnosis. */
export type NoiseReport = {
/** Levels with everything that was found, unit of the axis. */
levels: NoiseLevels,
/** Where they were learnt from. */
learnt_from: string,
/** Length of the blocks that slow effects were looked for in, s. */
block_s: number,
/** How many blocks there are. */
blocks: number, };

/** A unit of which nothing, or not everything, could be told. */
export type NotRead = {
/** Its name. */
unit: string,
/** Its lot. */
lot: string | null,
/** Some axes could be told. */
is_partly: boolean,
/** Why, a line each. */
reasons: Array<string>,
/** What helps, each once. */
help: Array<string>, };

/** A unit that does not belong. */
export type OddReport = {
/** Its name. */
unit: string,
/** Its lot. */
lot: string | null,
/** The axis that shows it best, as in `gyro x`. */
label: string,
/** The coefficient that is furthest there. */
coefficient: string,
/** Its deviation from the population without it, in standard deviations: Student's t. */
by: number,
/** Probability that a unit that belongs is so far in any of its axes. */
p_value: number,
/** The unit of the numbers below. */
unit_of_size: string,
/** Its own estimate, and half of its 90 % interval. */
estimate: [number, number] | null,
/** Where nine of ten units of its lot lie. */
expected: [number, number] | null, };

/** An effect that was found, to be added or not. */
export type Offer = {
/** As in the library, as `thermal_lag`. */
effect: string,
/** Whether something of it can be taken off sample by sample. */
can_be_added: boolean,
/** What to do instead. */
why_not: string | null,
/** The physics. */
card: Card,
/** What the model would cost more on the device. */
cost: Cost | null,
/** What speaks for it. */
evidence: Figure | null, };

/** Outcome for an axis, or the worst of a study's axes; later ones are worse. */
export type Outcome = "nothing_missing" | "not_enough_data" | "did_not_pay" | "unexplained" | "missing";

/** All that a page shows of a study, but for what is drawn sample by sample. */
export type Page = { id: number, name: string, revision: number, job: Job | null, error: string | null,
/** The logs that were asked for last; absent of an example that is not written yet. */
files: LogFiles | null, logs: Summaries | null,
/** Rows in which the unit was moved count as any others. */
keeps_moved: boolean,
/** The worst of its axes; an all-clear only once all are diagnosed. */
outcome: Outcome | null,
/** Every axis that can have a model has one: it can be exported. */
is_whole: boolean, axis: string | null, axes: Array<AxisPage>, commands: Array<string>, };

/** One pair of axes and what is drawn in it. */
export type Panel = {
/** What this panel shows, beside the legend. */
title: string,
/** Horizontal axis. */
x: Axis,
/** Vertical axis. */
y: Axis,
/** Drawn in this order, later ones on top. */
series: Array<Series>,
/** Ranges of x set apart by a shaded background; later ones on top. */
shading: Array<Shading>, };

/** The parameter of an effect, searched for on a logarithmic grid and then refined. */
export type Parameter = {
/** Name, with the unit as its last part: `tau_s`. */
name: string,
/** Unit that `low` and `high` are in; empty for a plain number. */
unit: string,
/** Least value looked for. */
low: number,
/** Largest value looked for. */
high: number,
/** Values below `low` give the same error, so that one at `low` is as good as any other. */
open_below?: boolean, };

/** A part. */
export type PartReport = {
/** Its name; empty if the fleet names none. */
part: string,
/** What was read, and what was not. */
read: UnitsRead,
/** When its numbers are not to be trusted, a sentence each. */
cautions: Array<string>,
/** Of what the differences of units are made; none where no axis has a population. */
variance: Figure | null,
/** Its axes. */
axes: Array<AxisReport>,
/** Units that do not belong, the furthest first. */
odd: Array<OddReport>,
/** Why that there is no other odd unit is not conclusive; none where it is. */
not_conclusive: string | null, };

/** A term of the physical part. */
export type PhysicalTerm = {
/** The product of inputs. */
term: string,
/** Coefficient, unit of the axis per unit of the product. */
coefficient: number, };

/** A population, as `fos fleet report --json` prints it, and its units. */
export type PopulationPage = { report: FleetReport,
/** In the order of parts and names. */
units: Array<UnitEntry>, };

/** Power over time and frequency. */
export type PowerMap = {
/** Cells in which enough is known, band by band, ascending in time. */
cells: Array<Cell>, };

/** The columns of a file, and what they may be. */
export type Preview = {
/** In the order of the file. */
columns: Array<ColumnPreview>,
/** Channels that a column can be. */
targets: Array<string>,
/** Units that each of them may come in, the SI unit first. */
units: { [key in string]: Array<string> }, };

/** Provenance of the inertial values of a log. */
export type Provenance = {
/** That of the accelerometers. */
accelerometers: SensorProvenance, gyros: SensorProvenance, };

/** As what a log was read, and what was assumed in doing so. */
export type ReadAs = { format: string,
/** Columns, units, clock, frame, gravity, corrections already applied: in words. */
assumed: string,
/** Sensor, corrections and frame of the inertial values; absent in studies of earlier versions. */
provenance?: Provenance | null, };

/** An axis of a study that effects were added to. */
export type Refinement = {
/** The axis, by its column. */
column: string, logs: LogSources,
/** The model before anything was added, then after each effect. */
stairs: Array<StepWithRms>, };

/** An effect that was tried and rejected. */
export type Rejected = {
/** As in the library, as `thermal_lag`. */
effect: string,
/** Its score alone on the log. */
score: number,
/** Why it is no finding, if its score alone would have made it one. */
why?: string | null, };

/** What the exported image does on the log that errors are of. */
export type Replayed = {
/** Path of the log. */
log: string, summary: Summary,
/** The command line that says the same. */
command: string,
/** Size of the image. */
bytes: number, };

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
/** Axes that the values are given in. */
frame: Frame, };

/** The experiment that tells a finding from a rival. */
export type Separation = {
/** Identifier of the rival. */
effect: string, experiment: string, };

/** Numbers to draw, all of one kind. */
export type Series = {
/** Text in the legend. Series with the same label share one entry (the pieces of a recording with gaps);
 * none with an empty one. */
label: string,
/** Whose numbers these are; decides the colour. */
ink: Ink,
/** The numbers, and how they are joined. */
shape: Shape, };

/** One shaded range. */
export type ShadedRange = {
/** Left end, in units of x. */
from: number,
/** Right end, in units of x. */
to: number,
/** Short text at its top, a number for instance. */
mark: string,
/** What it is, in words, for who points at it; empty where the legend says it all. */
says: string, };

/** Shaded ranges of x with one legend entry for all of them. */
export type Shading = {
/** Text in the legend. */
label: string,
/** Why it is set apart; decides the colour. */
tone: Tone,
/** What is shaded. */
ranges: Array<ShadedRange>, };

/** How numbers are drawn. A value that is not finite, in JSON null, interrupts a line or band and is otherwise left
 * out. */
export type Shape = { "Line": Array<[number | null, number | null]> } | { "Band": Array<[number | null, number | null, number | null]> } | { "Points": Array<[number | null, number | null]> } | { "Bars": Array<[number | null, number | null, number | null, number | null]> } | { "Stems": Array<[number | null, number | null]> } | { "Level": number } | { "Cells": Array<[number | null, number | null, number | null, number | null]> } | { "Frames": Array<[number | null, number | null, number | null, number | null]> };

/** A slow signal that several axes of a log share. */
export type SharedSignal = {
/** The axes that share it, as columns. */
axes: Array<string>,
/** Correlation of each of these axes with the others, of changes from one mean to the next. */
correlations: Array<number>,
/** Length of the means, s. */
mean_s: number,
/** Time of each mean, s after the first sample, and the signal there, in standard deviations. */
course: Array<[number, number]>, };

/** A unit as it is spelled for people: a stored value over `divisor` is in it. */
export type ShownUnit = { label: string, divisor: number, };

/** A coefficient in data-sheet units. */
export type Size = { of: string,
/** In `unit`. */
value: number,
/** 95 % interval; in JSON an end that is not finite is null. */
interval: [number | null, number | null],
/** As data sheets state it; `value` and `interval` are in it. */
unit: string, };

/** The file a recording was read from. */
export type Source = {
/** Path as it was given; for data that never were a file, what made them. */
path: string,
/** Size of the file, bytes (0: not a file). */
bytes: number,
/** SHA-256 of the file as stored (compressed, if it is), hexadecimal (empty: not a file). */
sha256: string,
/** Where it lies as seen from the folder of the study that names it; none where no study does, or an older one. */
from_study?: string | null,
/** As what it was read, where it is not in the log format. */
read_as?: ReadAs | null, };

/** Standing of one axis. */
export type Standing = { outcome: Outcome, sentence: string,
/** What to record so that the tests become possible. */
record: Array<string>, };

export type StepWithRms = {
/** What was added; none in the state before. */
added: Added | null, model: unknown,
/** All errors, on the judged rows. */
errors: ModelErrors,
/** Variance of the 1-s means, and of the samples, of what the physical part leaves on the judged rows. */
left: Left,
/** What the axis costs on the device. */
cost: Cost, rms_before?: number, rms_after?: number, rms_reduction?: number, rms_reduction_interval?: [number, number], measured_rms_reduction?: number, };

/** A stretch of the recording. */
export type Stretch = {
/** Begin, s as stamped. */
begin_s: number,
/** End, s as stamped. */
end_s: number,
/** Slow error: RMS of the 1-s means of the residual in a free run of at most 60 s, in the axis' unit. */
rms: number,
/** Mean of what is left. */
mean: number,
/** `rms` over that of the median stretch. */
ratio: number,
/** What is special there, most striking first; empty if nothing logged is. */
special: Array<string>, };

/** The logs of a study in a few facts. */
export type Summaries = {
/** The log where the model fails. */
field: LogSummary,
/** A log in which nothing is missing; absent where none was given. */
quiet: LogSummary | null,
/** The log that errors are of. */
judged: LogSummary | null, };

/** Counts and digests of a replay. */
export type Summary = {
/** Rows that the model was run over. */
rows: number,
/** Rows that were tracked; the others were coasted. */
tracked: number,
/** How it is known which. */
still_known_by: KnownBy,
/** Why the model does not run in fixed point; none if it does. */
not_in_fixed_point: string | null,
/** One for each axis of the image. */
axes: Array<AxisSummary>,
/** Whether what is taken off leads away from gravity; none if not all three accelerometers are in the model. */
gravity: Gravity | null,
/** CRC-64 of all innovations, tick by tick and axis by axis; in JSON hexadecimal, as JSON numbers have 53 bits. */
innovations_digest: string,
/** CRC-64 of all innovations, corrected values and validities. */
corrections_digest: string, };

/** Which axes an effect can strike. */
export type Targets = "any" | "gyro" | "accelerometer";

/** Whether further regressors explain more than noise would let them. */
export type Test = { terms: number,
/** 2Δ ln L, the noise levels fitted with and without them. */
gain: number,
/** The gain less `terms`·ln(blocks), the price of coefficients (Schwarz 1978). */
score: number,
/** How many independent samples the data and the prior together are worth, for the noise where the regressors are. */
effective_samples: number,
/** Chance of such a gain where nothing depends on anything. */
p: number, };

/** Why a range is set apart. */
export type Tone = "Apart" | "LeftOut";

/** The program that wrote a study. */
export type Tool = {
/** As on the command line. */
name: string, version: string, };

/** An axis of a unit. */
export type UnitAxis = {
/** As in `gyro x`. */
label: string,
/** The coefficients of its population. */
coefficients: Array<UnitCoefficient>,
/** The effects that a diagnosis found. */
effects: Array<string>, };

/** A unit in both systems. */
export type UnitChoice = { field: ShownUnit, si: ShownUnit, };

/** A coefficient of a unit: values in `unit`, each with half of its 90 % interval. */
export type UnitCoefficient = {
/** `bias`, or the regressor. */
name: string,
/** As in `dps/K`. */
unit: string,
/** What its log says; none where it does not tell. */
own: [number, number] | null,
/** What its lot lets expect: nine of ten units lie there. */
expected: [number, number],
/** Both together, as it ships; of a unit that does not belong its own log alone. */
together: [number, number],
/** By how many standard deviations its log is off what is expected. */
by: number | null, };

/** A unit in a list. */
export type UnitEntry = { part: string, unit: string, lot: string | null, };

/** A unit, and its log. */
export type UnitPage = { report: UnitReport,
/** Its log, as it is opened; none where it is not in a folder that may be read. */
log: string | null, };

/** A unit. */
export type UnitReport = {
/** Its name. */
unit: string,
/** Its part. */
part: string,
/** Its lot. */
lot: string | null,
/** It does not belong. */
is_odd: boolean,
/** Length of its log, s. */
seconds: number | null,
/** Lowest and highest temperature of its log, °C. */
temperature_c: [number, number] | null,
/** Why it, or an axis of it, tells nothing. */
failed: Array<string>,
/** The axes of its part. */
axes: Array<UnitAxis>, };

/** What was read of a part. */
export type UnitsRead = {
/** Units that were asked. */
units: number,
/** Those that told all. */
whole: number,
/** Those of which an axis could not be told. */
partly: number,
/** Those that told nothing. */
nothing: number,
/** Lots that are named. */
lots: number,
/** Length of the logs: the shortest, the median, the longest, s. */
seconds: [number, number, number] | null,
/** Lowest and highest temperature of all logs, °C. */
temperature_c: [number, number] | null,
/** By how much the temperature changes in the median log, K. */
warming_k: number | null,
/** The units of which something could not be told. */
not_read: Array<NotRead>,
/** How many more there are. */
more: number, };

/** An effect that could not be tried. */
export type Untested = {
/** As in the library, as `thermal_lag`. */
effect: string,
/** The data that the log lacks, in words: a column that is not there, begins too late or never changes; time at rest. */
needs: Array<string>, };

/** Corrections that logged values contain. */
export type Values = "unstated" | "raw" | { "corrected": string };

/** The outcome in one word. */
export type Verdict = "missing" | "nothing_missing" | "unexplained" | "not_enough_data";

/** What is shown beside the measurements. */
export type ViewKind = "one_step" | "coast" | "slow";

/** What a new study is of. */
export type Wanted = { example?: boolean, field?: string | null, quiet?: string | null, judged?: string | null, columns?: Array<string>, rate_hz?: number | null, };
