// @ts-check
// Gestures on a chart over time: drag to zoom, shift-drag to pan, wheel, pinch, keys.

import { el } from "./dom.js";

/** Smallest movement of a drag; less is a click, pixels. */
const DRAG = 4;
/** Zoom of one key press or button, and of one notch of a wheel (a notch is 100 pixels). */
export const KEY_ZOOM = 0.6;
const WHEEL_ZOOM = 1.0022;
/** Share of the window by which an arrow key pans. */
const KEY_PAN = 0.2;
/** Time after a scroll event in which the wheel still scrolls the page over a chart, ms. */
const SCROLLING = 300;

let lastScroll = -Infinity;
addEventListener(
  "wheel",
  (event) => {
    if (!event.defaultPrevented) lastScroll = event.timeStamp;
  },
  { passive: true },
);

/**
 * @param {HTMLElement} plot the area between the axes
 * @param {import("./timewindow.js").TimeWindow} time
 * @param {(time_s: number, tolerance_s: number) => void} click
 */
export function listenToHands(plot, time, click) {
  const selection = el("div", { class: "selection", hidden: true });
  plot.append(selection);
  /** @type {Map<number, {x: number, y: number}>} */
  const pointers = new Map();
  /** @type {{kind: "zoom" | "pan", startX: number, lastX: number, moved: boolean} | null} */
  let drag = null;

  const xOf = (/** @type {{clientX: number}} */ event) => event.clientX - plot.getBoundingClientRect().left;
  const timeAt = (/** @type {number} */ x) => time.shown[0] + (x / plot.clientWidth) * time.span;

  plot.addEventListener("pointerdown", (event) => {
    if (event.button !== 0) return;
    plot.setPointerCapture(event.pointerId);
    pointers.set(event.pointerId, { x: event.clientX, y: event.clientY });
    const pans = event.shiftKey || event.pointerType === "touch";
    drag = pointers.size === 1 ? { kind: pans ? "pan" : "zoom", startX: xOf(event), lastX: xOf(event), moved: false } : null;
    hideSelection();
  });

  plot.addEventListener("pointermove", (event) => {
    const before = pointers.get(event.pointerId);
    if (!before) return;
    if (pointers.size === 2) pinch(event.pointerId, event);
    pointers.set(event.pointerId, { x: event.clientX, y: event.clientY });
    if (!drag) return;
    const x = xOf(event);
    drag.moved ||= Math.abs(x - drag.startX) >= DRAG;
    if (drag.moved && drag.kind === "pan") time.pan((drag.lastX - x) / plot.clientWidth);
    if (drag.moved && drag.kind === "zoom") showSelection(drag.startX, x);
    drag.lastX = x;
  });

  for (const end of ["pointerup", "pointercancel"]) {
    plot.addEventListener(end, (event) => {
      const pointer = /** @type {PointerEvent} */ (event);
      if (!pointers.delete(pointer.pointerId) || !drag) return;
      const { kind, startX, moved } = drag;
      drag = null;
      hideSelection();
      if (end === "pointercancel") return;
      const [from, to] = [startX, xOf(pointer)].sort((a, b) => a - b);
      if (!moved) click(timeAt(startX), (6 / plot.clientWidth) * time.span);
      else if (kind === "zoom") time.show(timeAt(Number(from)), timeAt(Number(to)));
    });
  }

  plot.addEventListener("dblclick", () => time.showAll());

  plot.addEventListener(
    "wheel",
    (event) => {
      if (event.timeStamp - lastScroll < SCROLLING && !event.ctrlKey) return;
      const sideways = Math.abs(event.deltaX) > Math.abs(event.deltaY);
      const pixels = (sideways ? event.deltaX : event.deltaY) * (event.deltaMode === WheelEvent.DOM_DELTA_LINE ? 33 : 1);
      // the whole log is shown: the page scrolls
      if (!sideways && pixels > 0 && time.isWhole && !event.ctrlKey) return;
      event.preventDefault();
      if (sideways) time.pan(pixels / plot.clientWidth);
      else time.zoom(WHEEL_ZOOM ** (event.ctrlKey ? 4 * pixels : pixels), timeAt(xOf(event)));
    },
    { passive: false },
  );

  /** Two fingers: each time stays under its finger. @param {number} moved @param {PointerEvent} event */
  function pinch(moved, event) {
    const other = [...pointers].find(([id]) => id !== moved)?.[1];
    const before = pointers.get(moved);
    if (!other || !before) return;
    const wasApart = Math.abs(before.x - other.x);
    const isApart = Math.abs(event.clientX - other.x);
    if (wasApart > 8 && isApart > 8) time.zoom(wasApart / isApart, timeAt(xOf({ clientX: other.x })));
  }

  /** @param {number} a @param {number} b */
  function showSelection(a, b) {
    selection.hidden = false;
    selection.style.left = `${Math.max(0, Math.min(a, b))}px`;
    selection.style.width = `${Math.min(plot.clientWidth, Math.max(a, b)) - Math.max(0, Math.min(a, b))}px`;
  }

  function hideSelection() {
    selection.hidden = true;
  }
}

/**
 * @param {HTMLElement} chart takes the focus
 * @param {import("./timewindow.js").TimeWindow} time
 */
export function listenToKeys(chart, time) {
  /** @type {Record<string, () => void>} */
  const keys = {
    "+": () => time.zoom(KEY_ZOOM),
    "=": () => time.zoom(KEY_ZOOM),
    "-": () => time.zoom(1 / KEY_ZOOM),
    ArrowLeft: () => time.pan(-KEY_PAN),
    ArrowRight: () => time.pan(KEY_PAN),
    PageUp: () => time.pan(-0.9),
    PageDown: () => time.pan(0.9),
    Home: () => time.showAll(),
  };
  chart.addEventListener("keydown", (event) => {
    if (event.ctrlKey || event.metaKey || event.altKey || event.target !== chart) return;
    const act = keys[event.key];
    if (!act) return;
    event.preventDefault();
    act();
  });
}
