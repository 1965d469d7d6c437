// @ts-check
// The samples of the charts over time. Three times the visible window is loaded, so that panning has something to draw until
// finer data arrive.

import { get, isAbort } from "./api.js";

/** @typedef {import("./types.js").AxisSeries} Series */
/** @typedef {import("./types.js").LowAndHigh} Trace */
/** @typedef {import("./types.js").ViewKind} ViewName */
/** @typedef {{study: number, axis: string, view: ViewName, mean: number | null, model: string}} Subject `mean`: length of means, s, null follows the zoom; `model` tells one state of the model from the next */
/** Drawn samples: detail where it is loaded, the whole log at low resolution around it. @typedef {{shown: Series, whole: Series}} Drawn */

/** Pause after a change of the window before finer data are requested, ms. */
const DEBOUNCE = 70;
/** Pause after a failed request, ms. */
const RETRY = 2000;
/** Buckets of the whole log. */
const WHOLE_WIDTH = 1600;
/** Buckets per pixel below which finer ones are requested. */
const COARSEST = 0.7;

/** Approximate largest number of means over a window. */
const MEANS = 1000;

/** Averaging time for a window of this many seconds: 1, 2, 5, 10, … s. @param {number} span */
export function meanFor(span) {
  const decade = 10 ** Math.floor(Math.log10(Math.max(span / MEANS, 1)));
  const digit = [5, 2, 1].find((of) => of * decade <= span / MEANS) ?? 1;
  return Math.max(1, digit * decade);
}

export class SeriesSource {
  /** @type {import("./timewindow.js").TimeWindow} */
  #time;
  #width = 1000;
  /** @type {Subject | null} */
  #subject = null;
  /** @type {Series | null} */
  #whole = null;
  /** @type {Series | null} */
  #detail = null;
  /** Requests of the whole log and of the detail. */
  #request = new AbortController();
  #detailRequest = new AbortController();
  /** What the whole log was read of. @type {Subject | null} */
  #wholeOf = null;
  #timer = 0;
  /** @type {Set<(drawn: Drawn | null) => void>} */
  #listeners = new Set();
  /** What to do with an error. @type {(error: unknown) => void} */
  failed = () => {};

  /** @param {import("./timewindow.js").TimeWindow} time */
  constructor(time) {
    this.#time = time;
    time.onChange(() => this.#ask());
  }

  /** @param {(drawn: Drawn | null) => void} listener */
  onData(listener) {
    this.#listeners.add(listener);
  }

  /** @param {number} width of the plot, pixels */
  setWidth(width) {
    this.#width = Math.max(200, Math.round(width));
    this.#ask();
  }

  /** Changes axis, view or model; no effect if nothing changed. @param {Subject | null} subject */
  look(subject) {
    if (JSON.stringify(subject) === JSON.stringify(this.#subject)) return;
    const before = this.#subject;
    this.#subject = subject;
    this.#request.abort();
    this.#detailRequest.abort();
    clearTimeout(this.#timer);
    this.#detail = null;
    // A refined model is redrawn in place; another axis must not show the numbers of the previous one.
    if (before?.axis !== subject?.axis || before?.study !== subject?.study) {
      this.#whole = null;
      this.#tell();
    }
    if (subject) void this.#readWhole(subject);
  }

  /** @param {Subject} subject */
  async #readWhole(subject) {
    this.#request = new AbortController();
    const [from, to] = this.#time.whole;
    const whole = await this.#read(subject, from, to, WHOLE_WIDTH, to - from, this.#request.signal);
    if (!whole) {
      // the next change of the study repeats the request
      setTimeout(() => this.#subject === subject && (this.#subject = null), RETRY);
      return;
    }
    this.#whole = whole;
    this.#wholeOf = subject;
    this.#tell();
    this.#ask();
  }

  /**
   * @param {Subject} subject
   * @param {number} from @param {number} to @param {number} width @param {number} span in view, s @param {AbortSignal} signal
   * @returns {Promise<Series | null>} null: stale or failed
   */
  async #read(subject, from, to, width, span, signal) {
    const query = new URLSearchParams({
      axis: subject.axis,
      view: subject.view,
      from: String(from),
      to: String(to),
      width: String(width),
      mean_s: String(this.#mean(subject, span)),
    });
    try {
      const series = /** @type {Series} */ (await get(`/api/studies/${subject.study}/series?${query}`, signal));
      return signal.aborted ? null : series;
    } catch (error) {
      if (!isAbort(error) && !signal.aborted) this.failed(error);
      return null;
    }
  }

  /** Requests detail once the window rests and the loaded samples are too coarse. */
  #ask() {
    clearTimeout(this.#timer);
    // detail and whole log must be of one subject
    if (!this.#whole || this.#wholeOf !== this.#subject || this.#isEnough()) return;
    this.#timer = window.setTimeout(() => void this.#readDetail(), DEBOUNCE);
  }

  #isEnough() {
    const { shown, span, whole } = this.#time;
    const known = this.#detail ?? this.#whole;
    if (!known) return false;
    // half a window more on either side
    const from = Math.max(shown[0] - 0.5 * span, whole[0]);
    const to = Math.min(shown[1] + 0.5 * span, whole[1]);
    const covered = known.from_s <= from + 1e-9 && known.to_s >= to - 1e-9;
    const means = this.#subject?.view !== "slow" || known.mean_s === this.#mean(this.#subject, span);
    return covered && means && isFine(known, span, this.#width);
  }

  /** @param {Subject} subject @param {number} span */
  #mean(subject, span) {
    return subject.mean ?? meanFor(span);
  }

  async #readDetail() {
    const subject = this.#subject;
    if (!subject) return;
    this.#detailRequest.abort();
    this.#detailRequest = new AbortController();
    const { shown, span, whole } = this.#time;
    const from = Math.max(shown[0] - span, whole[0]);
    const to = Math.min(shown[1] + span, whole[1]);
    const detail = await this.#read(subject, from, to, Math.ceil((this.#width * (to - from)) / span), span, this.#detailRequest.signal);
    if (!detail) return;
    // the requested range counts as loaded even if the log has no samples there
    this.#detail = { ...detail, from_s: Math.min(detail.from_s, from), to_s: Math.max(detail.to_s, to) };
    this.#tell();
    this.#ask();
  }

  #tell() {
    const whole = this.#whole;
    const drawn = whole ? { whole, shown: this.#detail ? spliced(whole, this.#detail) : whole } : null;
    for (const listener of this.#listeners) listener(drawn);
  }
}

/** @param {Series} series @param {number} span shown, s @param {number} width pixels */
function isFine(series, span, width) {
  if (series.exact) return true;
  const buckets = (series.time_s.length / (series.to_s - series.from_s)) * span;
  return buckets >= COARSEST * width;
}

/** The detail, with the whole log around it. @param {Series} whole @param {Series} detail @returns {Series} */
function spliced(whole, detail) {
  const before = whole.time_s.findIndex((time) => time >= detail.from_s);
  const after = whole.time_s.findIndex((time) => time > detail.to_s);
  const left = before < 0 ? whole.time_s.length : before;
  const right = after < 0 ? whole.time_s.length : after;
  /** @template T @param {T[]} all @param {T[]} middle */
  const join = (all, middle) => all.slice(0, left).concat(middle, all.slice(right));
  /** @param {Trace | null} all @param {Trace | null} middle */
  const trace = (all, middle) => (all && middle ? { low: join(all.low, middle.low), high: join(all.high, middle.high) } : null);
  return {
    ...detail,
    time_s: join(whole.time_s, detail.time_s),
    measured: /** @type {Trace} */ (trace(whole.measured, detail.measured)),
    predicted: trace(whole.predicted, detail.predicted),
    left: trace(whole.left, detail.left),
    predicted_before: trace(whole.predicted_before, detail.predicted_before),
    left_before: trace(whole.left_before, detail.left_before),
    beside: detail.beside.map((one, at) => ({ ...one, values: /** @type {Trace} */ (trace(whole.beside[at]?.values ?? null, one.values)) })),
  };
}
