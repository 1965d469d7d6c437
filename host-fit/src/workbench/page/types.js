// @ts-check
// The shapes that the server answers with. Nothing here runs; every other module names these types.

/** @typedef {"missing" | "nothing_missing" | "unexplained"} Verdict */
/** @typedef {{column: string, label: string, unit: string, sentence: string | null, added: string[], slow_before: number | null, slow_now: number | null}} AxisEntry */
/** @typedef {{id: number, name: string, verdict: Verdict | null, working: boolean, axis?: AxisEntry | null}} StudyEntry */
/** asked_for: somebody waits for it; otherwise it goes on in the background. @typedef {{what: string, done: number | null, of: number | null, asked_for: boolean}} Job */
/** @typedef {{name: string, unit: string}} Column */
/**
 * @typedef {object} Log
 * @property {string} path
 * @property {number} rows
 * @property {number} seconds
 * @property {number} from_s
 * @property {number} to_s
 * @property {number} rate_hz
 * @property {number} segments
 * @property {number} missing
 * @property {string} sha256
 * @property {number | null} still_share
 * @property {string} still_known_by
 * @property {Column[]} columns
 * @property {string[]} quality
 */
/** @typedef {{field: Log, quiet: Log | null, judged: Log | null}} Logs */
/**
 * @typedef {object} State
 * @property {number} id
 * @property {string} name
 * @property {number} revision
 * @property {Job | null} job
 * @property {string | null} error
 * @property {Logs | null} logs
 * @property {string | null} axis
 * @property {AxisState[]} axes
 * @property {string[]} commands
 */
/**
 * @typedef {object} AxisState
 * @property {string} column
 * @property {string} label
 * @property {string} unit
 * @property {ModelSummary | null} model
 * @property {AxisComparison | null} comparison
 * @property {[number, number] | null} judged_s
 * @property {Diagnosis | null} diagnosis
 * @property {Offer[]} offers
 * @property {Refinement | null} growth
 * @property {Figure | null} staircase
 */
/** @typedef {{terms: number, candidates: number, method: string, stopped: string, monomials: string[], physical: {term: string, coefficient: number}[]}} ModelSummary */
/**
 * @typedef {object} AxisComparison
 * @property {string} column
 * @property {string} unit
 * @property {number} rows
 * @property {[number, [number, number]] | null} noise_floor
 * @property {string[]} floor_cautions
 * @property {Errors[]} errors
 * @property {Stretch[]} worst
 * @property {{channels: {channel: string, unit: string, p_of_all: number | null}[]} | null} dependence
 */
/** @typedef {{begin_s: number, end_s: number, rms: number, mean: number, ratio: number, special: string[]}} Stretch */
/**
 * @typedef {object} Errors
 * @property {string} model
 * @property {number} one_step_mse
 * @property {{horizon_s: number, mse: number}[]} coast
 * @property {number | null} slow_error_coast
 */
/**
 * @typedef {object} Diagnosis
 * @property {string} target
 * @property {string} unit
 * @property {Verdict} verdict
 * @property {string} sentence
 * @property {Finding[]} findings
 * @property {{follows: string, score: number}[]} leads
 * @property {{effect: string, score: number}[]} rejected
 * @property {{effect: string, needs: string[]}[]} untested
 * @property {{levels: {white: number, flicker: number, walk: number, gauss_markov: unknown}, learnt_from: string, block_s: number, blocks: number}} noise
 * @property {string[]} cautions
 */
/** @typedef {"slow" | "wide" | "data" | "stochastic"} Band */
/** @typedef {{of: string, value: number, interval: [number | null, number | null], unit: string}} Size */
/**
 * @typedef {object} Finding
 * @property {string} effect
 * @property {string} name
 * @property {Band} band
 * @property {Record<string, number>} params
 * @property {Record<string, [number | null, number | null]>} params_interval
 * @property {Size[]} sizes
 * @property {number} gain
 * @property {number} score
 * @property {number} expected_drop
 * @property {[number, number]} expected_drop_ci
 * @property {number} [realised_fall]
 * @property {string[]} confounded_with
 * @property {{effect: string, experiment: string}[]} separate
 * @property {string | null} shows_against
 * @property {[number, number] | null} shows_from_to_s
 */
/** @typedef {{name: string, mechanism: string, equation: string, typical_size: string, source: string, experiment: string, gives_away: string, device: string}} EffectCard */
/** @typedef {{terms: number, factors: number, inputs: number, ram_bytes: number, instructions: number}} Cost */
/** @typedef {{effect: string, can_be_added: boolean, why_not: string | null, card: EffectCard, cost: Cost | null, evidence: Figure | null}} Offer */
/** @typedef {{path: string}} Source */
/**
 * @typedef {object} Stair
 * @property {{effect: {id: string, name: string}, finding: Finding, realised_fall: number} | null} added
 * @property {Errors} errors
 * @property {{slow: number, wide: number}} left
 * @property {Cost} cost
 */
/** @typedef {{column: string, logs: {field: Source, quiet: Source | null, judged: Source | null, fitted_rows: number}, stairs: Stair[]}} Refinement */
/** @typedef {EffectCard & {id: string, band: Band}} LibraryEffect */

/** @typedef {(number | null)[]} Values */
/** @typedef {{low: Values, high: Values}} Trace */
/** @typedef {"one_step" | "coast" | "slow"} ViewName */
/**
 * @typedef {object} Series
 * @property {string} axis
 * @property {string} unit
 * @property {ViewName} view
 * @property {number} from_s
 * @property {number} to_s
 * @property {number} period_s
 * @property {boolean} exact
 * @property {number[]} time_s
 * @property {Trace} measured
 * @property {Trace | null} predicted
 * @property {Trace | null} left
 */

/** @typedef {"Measured" | "Predicted" | "Residual" | "Floor" | "Bound" | "Other" | {Step: number} | {Method: number}} Ink */
/** @typedef {number | null} Num */
/**
 * @typedef {{Line: [Num, Num][]} | {Band: [Num, Num, Num][]} | {Points: [Num, Num][]} | {Bars: [Num, Num, Num, Num][]}
 *   | {Stems: [Num, Num][]} | {Level: number} | {Cells: [Num, Num, Num, Num][]} | {Frames: [Num, Num, Num, Num][]}} Shape
 */
/** @typedef {{label: string, scale: "Linear" | "Log", names: string[]}} FigureAxis */
/** @typedef {{label: string, ink: Ink, shape: Shape}} FigureSeries */
/** @typedef {{label: string, ranges: {from: number, to: number, mark: string}[]}} Shading */
/** @typedef {{title: string, x: FigureAxis, y: FigureAxis, series: FigureSeries[], shading: Shading}} Panel */
/** @typedef {{title: string, panels: Panel[]}} Figure */
/** @typedef {{name: string, figure: Figure}} NamedFigure */

/** @typedef {{path: string, bytes: number}} LogEntry */
/** @typedef {{name: string, quoted: string, values: string[], target: string | null, unit: string | null, spec: string | null, why: string, sure: boolean}} PreviewColumn */
/** @typedef {{columns: PreviewColumn[], targets: string[], units: Record<string, string[]>}} Preview */
/** @typedef {{example: true} | {field: string, quiet: string | null, judged: string | null, columns: string[], rate_hz: number | null}} NewStudy */
/**
 * @typedef {object} Replay
 * @property {string} log
 * @property {{rows: number, tracked: number, axes: ReplayAxis[], corrections_digest: string}} summary
 * @property {string} command
 */
/** @typedef {{column: string, innovations: number, innovation_rms_f32: Num, innovation_rms_f64?: Num, largest_difference?: Num, errors: null | Errors}} ReplayAxis */

export {};
