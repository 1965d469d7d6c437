// @ts-check
// An hour of six axes at 200 Hz in the workbench: how soon the first picture is there, how smoothly it moves, how much memory the
// server takes. Prints the figures; fails where one is beyond its limit.

import assert from "node:assert/strict";
import { execFile } from "node:child_process";
import { readFile } from "node:fs/promises";
import { promisify } from "node:util";
import { HOST_FIT, SLOW, atRest, closePage, framesWhilePanningAndZooming, openPage, startBrowser, startServer, stateOf } from "./workbench.js";

/** From the log being read to the first picture, s. */
const FIRST_PICTURE_S = 1.5;
/** Frames a second. */
const SMOOTH = 30;
/** Bytes of the report. */
const REPORT = 5e6;
/** Times the log as numbers of 64 bits. */
const MEMORY = 6;

const server = await startServer();
const browser = await startBrowser();
try {
  await promisify(execFile)(HOST_FIT, ["simulate", "hour.parquet", "--minutes", "60", "--seed", "5", "--at-rest"], { cwd: server.folder });
  const page = await openPage(browser, server);
  // when the page learns that the log is read, and when it has painted a picture of it
  await page.evaluate(() => {
    const seen = /** @type {any} */ (window);
    const fetched = seen.fetch;
    seen.fetch = async (/** @type {unknown[]} */ ...request) => {
      const response = await fetched(...request);
      if (/\/api\/studies\/\d+$/.test(String(request[0])) && seen.read_ === undefined) {
        const state = await response.clone().json();
        if (state.logs) seen.read_ = performance.now();
      }
      return response;
    };
    const look = () => {
      const canvas = /** @type {HTMLCanvasElement | null} */ (document.querySelector(".time-chart canvas"));
      if (canvas && seen.read_ !== undefined) seen.painted_ = performance.now();
      else requestAnimationFrame(look);
    };
    requestAnimationFrame(look);
  });
  const { id } = await page.evaluate(async () => {
    const request = { method: "POST", headers: { "content-type": "application/json", "x-fos-workbench": "1" }, body: JSON.stringify({ log: "hour.parquet" }) };
    return (await fetch("/api/studies", request)).json();
  });
  await page.evaluate((study) => (location.hash = `#/study/${study}`), id);
  await page.waitForFunction(() => /** @type {any} */ (window).painted_ !== undefined, undefined, { timeout: SLOW });
  const first = await page.evaluate(() => (/** @type {any} */ (window).painted_ - /** @type {any} */ (window).read_) / 1000);
  const atWork = await memory();
  await atRest(page);
  const frames = await framesWhilePanningAndZooming(page);
  const state = await stateOf(page, server);
  const { rows, columns } = /** @type {NonNullable<typeof state.logs>} */ (state.logs).log;
  const raw = rows * (columns.length + 1) * 8;
  // all that can be known of all six axes
  for (const { column } of state.axes) {
    await page.locator(`input[value="${column}"]`).check({ force: true });
    await page.waitForFunction((axis) => document.querySelector("[data-verdict]") && document.querySelector(`input[value="${axis}"]:checked`), column);
    await page.waitForTimeout(500);
    await atRest(page);
  }
  await page.waitForSelector(".replay .digest", { timeout: SLOW });
  const report = (await (await fetch(`${server.url}api/studies/${id}/export/report.html`)).arrayBuffer()).byteLength;
  const most = await memory();

  const megabytes = (/** @type {number} */ bytes) => `${(bytes / 1e6).toFixed(0)} MB`;
  console.log(`${rows} rows, ${columns.length} channels and time: ${megabytes(raw)} as numbers of 64 bits`);
  console.log(`first picture: ${first.toFixed(2)} s after the log was read (at most ${FIRST_PICTURE_S} s)`);
  for (const [what, { mean, longest }] of Object.entries(frames)) console.log(`${what}: ${mean.toFixed(0)} frames a second, longest frame ${longest.toFixed(0)} ms (at least ${SMOOTH})`);
  console.log(`memory of the server, at most: ${megabytes(most)}, ${(most / raw).toFixed(2)} times the numbers (at most ${MEMORY}); when the picture was there: ${megabytes(atWork)}`);
  console.log(`report of six axes: ${megabytes(report)} (at most ${megabytes(REPORT)})`);
  assert.ok(report <= REPORT, "the report is too large");
  assert.ok(first <= FIRST_PICTURE_S && most <= MEMORY * raw && frames.panning.mean >= SMOOTH && frames.zooming.mean >= SMOOTH, "beyond a limit");
  await closePage(page);
} finally {
  await browser.close();
  await server.stop();
}

/** Most memory that the server ever had, bytes. */
async function memory() {
  const status = await readFile(`/proc/${server.pid}/status`, "utf8");
  return 1024 * Number(/VmHWM:\s+(\d+)/.exec(status)?.[1]);
}
