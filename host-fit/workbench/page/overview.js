// @ts-check
// The whole log on a narrow strip. A frame marks the range of the charts: drag it or its edges.

import uPlot from "./vendor/uplot.esm.js";
import { el } from "./dom.js";
import { whileOnPage } from "./onpage.js";
import { paint, rangeOutside } from "./shading.js";
import { colour, faint, onTheme } from "./theme.js";
import { RIGHT, Y_AXIS, padded } from "./timechart.js";

/** @typedef {import("./types.js").AxisSeries} Series */

const HEIGHT = 48;
/** Distance from an edge at which it can be dragged, pixels. */
const EDGE = 7;

export class Overview {
  #host = el("div", { class: "plot" });
  #frame = el("div", { class: "frame" });
  element = el("div", { class: "overview", "aria-hidden": "true" }, this.#host);
  #time;
  /** @type {uPlot | null} */
  #plot = null;
  /** @type {import("./types.js").Shading | null} */
  #moved = null;

  /** @param {import("./timewindow.js").TimeWindow} time */
  constructor(time) {
    this.#time = time;
    time.onChange(() => this.#place());
    const forget = onTheme(() => this.#plot?.redraw(false));
    const gone = () => {
      forget();
      this.setData(null);
    };
    whileOnPage(this.#host, (width) => this.#resize(width), gone);
  }

  /** @param {number} width */
  #resize(width) {
    this.#plot?.setSize({ width, height: HEIGHT });
    this.#place();
  }

  /** @param {Series | null} whole */
  setData(whole) {
    this.#plot?.destroy();
    this.#plot = null;
    if (!whole) return;
    const ink = "--ink-measured";
    this.#plot = new uPlot(
      {
        width: this.#host.clientWidth || 600,
        height: HEIGHT,
        legend: { show: false },
        cursor: { show: false },
        scales: { x: { time: false, range: () => this.#time.whole }, y: { range: (u, low, high) => padded(...rangeOutside(u, this.#moved, low, high)) } },
        axes: [{ show: false }, { show: false }],
        padding: [4, RIGHT, 4, Y_AXIS],
        series: [{}, { stroke: () => faint(ink, 0.7), width: 1, points: { show: false } }, { stroke: () => faint(ink, 0.7), width: 1, points: { show: false } }],
        bands: [{ series: [2, 1], fill: () => faint(ink, 0.3) }],
        hooks: { drawClear: [(u) => fill(u), (u) => this.#moved && paint(u, this.#moved)] },
      },
      /** @type {uPlot.AlignedData} */ ([whole.time_s, whole.measured.low, whole.measured.high]),
      this.#host,
    );
    this.#plot.over.append(this.#frame);
    this.#listen(this.#plot.over);
    this.#place();
  }

  /** Shades detected motion. @param {import("./types.js").Shading | null} moved */
  setMoved(moved) {
    if (this.#moved === moved) return;
    this.#moved = moved;
    this.#plot?.redraw();
  }

  #place() {
    const [first, last] = this.#time.whole;
    const [from, to] = this.#time.shown;
    const share = (/** @type {number} */ at) => `${(100 * (at - first)) / (last - first)}%`;
    this.#frame.style.left = share(from);
    this.#frame.style.width = `max(4px, ${(100 * (to - from)) / (last - first)}%)`;
  }

  /** @param {HTMLElement} over */
  #listen(over) {
    /** @type {{moves: "window" | "from" | "to", offset: number} | null} */
    let drag = null;
    const timeAt = (/** @type {PointerEvent} */ event) => {
      const box = over.getBoundingClientRect();
      const [first, last] = this.#time.whole;
      return first + ((event.clientX - box.left) / box.width) * (last - first);
    };
    over.addEventListener("pointerdown", (event) => {
      over.setPointerCapture(event.pointerId);
      const { shown, span, whole } = this.#time;
      const at = timeAt(event);
      const edge = (EDGE / over.clientWidth) * (whole[1] - whole[0]);
      const isWide = span > 4 * edge;
      if (isWide && Math.abs(at - shown[0]) < edge) drag = { moves: "from", offset: 0 };
      else if (isWide && Math.abs(at - shown[1]) < edge) drag = { moves: "to", offset: 0 };
      else {
        if (at < shown[0] || at > shown[1]) this.#time.show(at - 0.5 * span, at + 0.5 * span);
        drag = { moves: "window", offset: at - this.#time.shown[0] };
      }
    });
    over.addEventListener("pointermove", (event) => {
      if (!drag) return;
      const at = timeAt(event);
      const { shown, span } = this.#time;
      if (drag.moves === "window") this.#time.show(at - drag.offset, at - drag.offset + span);
      else if (drag.moves === "from") this.#time.show(Math.min(at, shown[1] - this.#time.shortest), shown[1]);
      else this.#time.show(shown[0], Math.max(at, shown[0] + this.#time.shortest));
    });
    for (const end of ["pointerup", "pointercancel"]) over.addEventListener(end, () => (drag = null));
  }
}

/** @param {uPlot} u */
function fill(u) {
  u.ctx.fillStyle = colour("--sunken");
  u.ctx.fillRect(u.bbox.left, u.bbox.top, u.bbox.width, u.bbox.height);
}
