// @ts-check
// How numbers and axes are written; needs no browser.

import assert from "node:assert/strict";
import { test } from "node:test";
import { count, firstSentence, number, percent, quantity } from "../../host-fit/src/workbench/page/format.js";
import { linearTicks, logTicks } from "../../host-fit/src/workbench/page/ticks.js";

const spaced = (/** @type {string} */ text) => text.replaceAll("\u202f", " ");

test("numbers have three digits, a real minus and powers of ten where they are needed", () => {
  assert.equal(number(52.66568), "52.7");
  assert.equal(number(-0.26061), "−0.261");
  assert.equal(number(1271.73), "1272");
  assert.equal(number(3.0912e-7), "3.09×10⁻⁷");
  assert.equal(number(0), "0");
  assert.equal(number(null), "–");
  assert.equal(number(Number.NaN), "–");
});

test("units take the prefix that suits the number", () => {
  assert.equal(spaced(quantity(0.0033094, "rad/s")), "3.31 mrad/s");
  assert.equal(spaced(quantity(-7.5e-7, "rad/s")), "−750 nrad/s");
  assert.equal(spaced(quantity(0, "rad/s")), "0 rad/s");
  assert.equal(spaced(quantity(0.0204, "dps/K")), "0.0204 dps/K");
});

test("counts are grouped, shares are percent", () => {
  assert.equal(spaced(count(181_900)), "181 900");
  assert.equal(count(2888), "2888");
  assert.equal(spaced(percent(0.95238)), "95.2 %");
});

test("a first sentence ends where the next begins", () => {
  assert.deepEqual(firstSentence("Off by 0.5 K. Then more. And more."), ["Off by 0.5 K.", "Then more. And more."]);
  assert.deepEqual(firstSentence("One only."), ["One only.", ""]);
});

test("even marks are round, inside, and share one power of ten", () => {
  assert.deepEqual(linearTicks(-2.4, 2.4, 5).map((tick) => tick.label), ["−2", "−1", "0", "1", "2"]);
  assert.deepEqual(linearTicks(0.02, 0.09, 4).map((tick) => tick.label), ["0.02", "0.04", "0.06", "0.08"]);
  assert.deepEqual(linearTicks(-6e-5, 11e-5, 4).map((tick) => tick.label), ["−0.5×10⁻⁴", "0", "0.5×10⁻⁴", "1.0×10⁻⁴"]);
  for (const tick of linearTicks(-0.37, 12.2, 7)) assert.ok(tick.value >= -0.37 && tick.value <= 12.2);
  assert.deepEqual(linearTicks(1, 1, 5), []);
});

test("logarithmic marks are decades, subdivided where there is room", () => {
  const labelled = (/** @type {import("../../host-fit/src/workbench/page/ticks.js").Tick[]} */ ticks) => ticks.map((tick) => tick.label).filter((label) => label);
  assert.deepEqual(labelled(logTicks(1e-10, 1e-4, 4)), ["10⁻¹⁰", "10⁻⁸", "10⁻⁶", "10⁻⁴"]);
  assert.deepEqual(labelled(logTicks(0.9, 110, 8)), ["1", "2", "5", "10", "20", "50", "100"]);
  assert.deepEqual(logTicks(0, 1, 4), []);
});
