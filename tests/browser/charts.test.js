// @ts-check
// The charts over time under real hands: zoom to single samples, pan smoothly.

import assert from "node:assert/strict";
import { before, test } from "node:test";
import { SLOW, bench, framesWhilePanningAndZooming, openExample, plotOf, shownBy } from "./workbench.js";

/** Least that counts as smooth. */
const SMOOTH = 30;

/** @type {import("playwright-core").Page} */
let page;
const workbench = bench();
before(async () => {
  page = await workbench.open();
  await openExample(page);
});

const shown = () => shownBy(page);
const rest = () => page.waitForTimeout(400);

test("panning and zooming keep thirty frames a second", { timeout: SLOW }, async () => {
  await page.locator('input[name="view"][value="coast"]').check({ force: true });
  await page.getByRole("button", { name: "Show the whole log" }).click();
  await rest();
  const frames = await framesWhilePanningAndZooming(page);
  for (const [what, { mean, longest }] of Object.entries(frames)) {
    console.log(`${what}: ${mean.toFixed(0)} frames a second, longest frame ${longest.toFixed(0)} ms`);
    assert.ok(mean >= SMOOTH, `${what} at ${mean.toFixed(1)} frames a second`);
  }
});

test("a drag zooms to what it spans, down to single samples", { timeout: SLOW }, async () => {
  await page.getByRole("button", { name: "Show the whole log" }).click();
  await rest();
  const whole = await shown();
  const { x, y, width } = await plotOf(page);
  await page.mouse.move(x + 0.25 * width, y);
  await page.mouse.down();
  await page.mouse.move(x + 0.75 * width, y, { steps: 5 });
  await page.mouse.up();
  await rest();
  const half = await shown();
  const share = (half[1] - half[0]) / (whole[1] - whole[0]);
  assert.ok(Math.abs(share - 0.5) < 0.02, `a drag over half of the plot shows ${share}`);

  await page.locator('input[name="view"][value="one_step"]').check({ force: true });
  for (let n = 0; n < 24; n += 1) await page.getByRole("button", { name: "Zoom in" }).click();
  await rest();
  const finest = await shown();
  assert.ok(finest[1] - finest[0] < 0.1, `zoomed in to ${finest}`);
  await page.waitForFunction(() => document.querySelector(".time-chart")?.closest(".card")?.querySelector(".swatch.line") !== null);
  const finestPlot = await plotOf(page);
  await page.mouse.dblclick(finestPlot.x + 0.5 * finestPlot.width, finestPlot.y);
  await rest();
  assert.deepEqual(await shown(), whole);
});

test("the strip below moves what is shown", { timeout: SLOW }, async () => {
  for (let n = 0; n < 3; n += 1) await page.getByRole("button", { name: "Zoom in" }).click();
  await rest();
  const before = await shown();
  const strip = await page.locator(".overview .frame").boundingBox();
  assert.ok(strip);
  await page.mouse.move(strip.x + strip.width / 2, strip.y + strip.height / 2);
  await page.mouse.down();
  await page.mouse.move(strip.x + strip.width / 2 + 100, strip.y + strip.height / 2, { steps: 4 });
  await page.mouse.up();
  await rest();
  const moved = await shown();
  assert.ok(moved[0] > before[0]);
  assert.ok(Math.abs(moved[1] - moved[0] - (before[1] - before[0])) <= 1.01, "as much as before");
});
