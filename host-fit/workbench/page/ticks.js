// @ts-check
// Ticks and labels of an axis: the same as in a figure file (host-fit/figures/src/scale.rs), which cannot know the width of a
// panel or the zoom of a chart. Both are tested against host-fit/figures/src/ticks.json.

import { raised } from "./format.js";

/** @typedef {{value: number, label: string}} Tick */

/** Fewest labels of an axis. */
const FEWEST = 3;
const MOST = 24;

/**
 * Marks at even, round numbers, about `count` of them.
 * @param {number} low @param {number} high @param {number} count
 * @returns {Tick[]}
 */
export function linearTicks(low, high, count) {
  const wanted = (high - low) / Math.max(count, 1);
  if (!(wanted > 0) || !Number.isFinite(wanted)) return [];
  const decade = 10 ** Math.floor(Math.log10(wanted));
  const step = decade * ([1, 2, 5, 10].find((multiple) => multiple * decade >= wanted * 0.999) ?? 10);
  const first = Math.ceil(low / step - 1e-9);
  const last = Math.floor(high / step + 1e-9);
  if (last - first < FEWEST - 1 && count < MOST) return linearTicks(low, high, 2 * count);
  const write = evenLabels(step, Math.max(Math.abs(first * step), Math.abs(last * step)));
  return Array.from({ length: Math.max(0, last - first + 1) }, (_, n) => ({ value: (first + n) * step, label: write((first + n) * step) }));
}

/** As many decimals as the step needs, and one power of ten for all. @param {number} step @param {number} largest */
function evenLabels(step, largest) {
  const power = largest > 0 ? Math.floor(Math.log10(largest) + 1e-9) : 0;
  const isPlain = power >= -3 && power <= 5;
  const shift = isPlain ? 0 : power;
  const decimals = Math.max(0, shift - Math.floor(Math.log10(step) + 1e-9));
  /** @param {number} value */
  return (value) => {
    if (Math.abs(value) < step / 2) return "0";
    const mantissa = (value / 10 ** shift).toFixed(decimals).replace("-", "−");
    return isPlain ? mantissa : `${mantissa}×${powerOfTen(power)}`;
  };
}

/**
 * Marks on a logarithmic axis: decades, with 2 and 5 where there is room, and even numbers where fewer than two of these would be
 * named. Marks without a text subdivide.
 * @param {number} low @param {number} high @param {number} count
 * @returns {Tick[]}
 */
export function logTicks(low, high, count) {
  const decades = Math.log10(high / low);
  if (!(decades > 0) || !Number.isFinite(decades)) return [];
  const room = Math.floor(Math.max(count, 0)) + 2;
  const labelled = 3 * decades <= room ? [1, 2, 5] : [1];
  const every = Math.max(1, Math.ceil(decades / room));
  const [first, last] = [Math.floor(Math.log10(low)), Math.ceil(Math.log10(high))];
  // one notation for all labels of an axis
  const isPlain = first >= -3 && last <= 4;
  /** @type {Tick[]} */
  const ticks = [];
  for (let exponent = first; exponent <= last; exponent += 1) {
    for (let digit = 1; digit < 10; digit += 1) {
      const value = Number(`${digit}e${exponent}`);
      if (value < low * 0.999999 || value > high * 1.000001) continue;
      const named = labelled.includes(digit) && exponent % every === 0;
      if (named || decades < 3) ticks.push({ value, label: named ? powerLabel(digit, exponent, isPlain) : "" });
    }
  }
  if (ticks.filter((tick) => tick.label).length < 2) return linearTicks(low, high, count).filter((tick) => tick.value > 0);
  return ticks;
}

/** @param {number} digit @param {number} exponent @param {boolean} isPlain */
function powerLabel(digit, exponent, isPlain) {
  if (isPlain) return String(Number(`${digit}e${exponent}`));
  return digit === 1 ? powerOfTen(exponent) : `${digit}×${powerOfTen(exponent)}`;
}

/** @param {number} exponent */
const powerOfTen = (exponent) => `10${raised(exponent)}`;

/** Room between labels, pixels. */
const ROOM = 4;

/**
 * Every tick, or every second, third, … of them, so that labels neither overlap nor pass the end of the canvas.
 * @param {Tick[]} ticks
 * @param {(value: number) => number} place of a value, pixels
 * @param {(label: string) => number} size of a label along the axis, pixels
 * @param {number} [end] of the canvas, pixels
 */
export function spaced(ticks, place, size, end = Infinity) {
  const labelled = ticks.filter(({ label }) => label);
  const fits = (/** @type {Tick[]} */ some) =>
    some.every((tick, at) => {
      const next = some[at + 1];
      return !next || Math.abs(place(next.value) - place(tick.value)) >= 0.5 * (size(tick.label) + size(next.label)) + ROOM;
    });
  const step = (labelled[1]?.value ?? 1) - (labelled[0]?.value ?? 0);
  for (let every = 1; every <= labelled.length; every += 1) {
    // round numbers stay: 0, 20, 40 of 0, 10, 20, 30, 40
    const kept = labelled.filter(({ value }, at) => (every === 1 ? true : step > 0 && isEven(labelled, step) ? Math.round(value / step) % every === 0 : at % every === 0));
    if (fits(kept)) return kept.filter(({ value, label }) => place(value) + 0.5 * size(label) <= end);
  }
  return labelled.slice(0, 1);
}

/** @param {Tick[]} ticks @param {number} step */
const isEven = (ticks, step) => ticks.every((tick, at) => at === 0 || Math.abs(tick.value - Number(ticks[at - 1]?.value) - step) < 1e-6 * step);
