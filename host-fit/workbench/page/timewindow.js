// @ts-check
// The visible time window, shared by all charts over time.

/** @typedef {[number, number]} Span */

export class TimeWindow {
  /** @type {Set<() => void>} */
  #listeners = new Set();
  #scheduled = false;
  /** From first to last second of the log. @type {Span} */
  whole = [0, 1];
  /** Visible window. @type {Span} */
  shown = [0, 1];
  /** Shortest window, s: a few samples. */
  shortest = 0.02;

  /** Calls `listener` once a frame while the window moves. @param {() => void} listener */
  onChange(listener) {
    this.#listeners.add(listener);
  }

  /** Starts with a new log, all of it visible. @param {Span} whole @param {number} period sample period, s */
  reset(whole, period) {
    this.whole = whole;
    this.shortest = 8 * period;
    this.showAll();
  }

  get isWhole() {
    return this.shown[0] <= this.whole[0] && this.shown[1] >= this.whole[1];
  }

  get span() {
    return this.shown[1] - this.shown[0];
  }

  showAll() {
    this.show(this.whole[0], this.whole[1]);
  }

  /** Shows a window, moved inside the log if necessary. @param {number} from @param {number} to */
  show(from, to) {
    const [first, last] = this.whole;
    const span = Math.min(Math.max(to - from, this.shortest), last - first);
    const isWhole = span === last - first;
    const middle = 0.5 * (from + to);
    const left = Math.min(Math.max(middle - 0.5 * span, first), last - span);
    // the sum of begin and span is rounded, and may lie before the end of the log
    this.shown = isWhole ? [first, last] : [left, left + span];
    if (this.#scheduled) return;
    this.#scheduled = true;
    requestAnimationFrame(() => {
      this.#scheduled = false;
      for (const listener of this.#listeners) listener();
    });
  }

  /** Shows a stretch with 1.5 times its length on either side. @param {number} from @param {number} to */
  showAround(from, to) {
    this.show(from - 1.5 * (to - from), to + 1.5 * (to - from));
  }

  /** @param {number} factor below 1: closer @param {number} [at] stays where it is, s */
  zoom(factor, at = 0.5 * (this.shown[0] + this.shown[1])) {
    const span = Math.min(Math.max(this.span * factor, this.shortest), this.whole[1] - this.whole[0]);
    const share = (at - this.shown[0]) / this.span;
    this.show(at - share * span, at + (1 - share) * span);
  }

  /** @param {number} share of what is shown */
  pan(share) {
    this.show(this.shown[0] + share * this.span, this.shown[1] + share * this.span);
  }
}
