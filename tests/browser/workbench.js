// @ts-check
// What every test needs: a running workbench, a browser, and hands.

import assert from "node:assert/strict";
import { spawn } from "node:child_process";
import { mkdtemp, readFile, rm } from "node:fs/promises";
import { createRequire } from "node:module";
import { tmpdir } from "node:os";
import { dirname, join, resolve } from "node:path";
import { createInterface } from "node:readline";
import { after, before } from "node:test";
import { fileURLToPath } from "node:url";
import { chromium } from "playwright-core";

/** @typedef {import("playwright-core").Page} Page */
/** @typedef {import("playwright-core").Browser} Browser */

const HERE = dirname(fileURLToPath(import.meta.url));
export const ROOT = resolve(HERE, "../..");
/** The program under test. */
export const HOST_FIT = resolve(ROOT, process.env.FOS_HOST_FIT ?? "target/release/fos");
/** A workbench that runs already, in place of the program: answers only need the right shape. */
const RUNNING = process.env.FOS_WORKBENCH_URL;
export const IS_REAL = RUNNING === undefined;

/** A fit, a comparison and a diagnosis, on a slow machine, ms. */
export const SLOW = 180_000;
const BROWSER = process.env.FOS_CHROMIUM ?? "/usr/bin/chromium";
const FLAGS = ["--no-sandbox", "--headless", "--disable-gpu", "--disable-quic", "--no-first-run", "--disable-background-networking", "--disable-component-update", "--disable-sync"];

/** @typedef {{width?: number, height?: number, theme?: "light" | "dark"}} Looks */
/** @typedef {{url: string, folder: string, pid: number | undefined, stop: () => Promise<void>}} Server */

/** Starts the workbench in a folder of its own, on a free port. @returns {Promise<Server>} */
export async function startServer() {
  const folder = await mkdtemp(join(tmpdir(), "fos-workbench-"));
  if (RUNNING) return { url: RUNNING.replace(/\/?$/, "/"), folder, pid: undefined, stop: () => rm(folder, { recursive: true }) };
  const server = await startIn(folder);
  const stop = async () => {
    await server.stop();
    await rm(folder, { recursive: true, force: true });
  };
  return { ...server, stop };
}

/** Starts the program in a folder that stays, on a port; 0: a free one. @param {string} folder @returns {Promise<Server>} */
export async function startIn(folder, port = "0") {
  // paths are shown as they are given: relative to where the program was started, as people do
  const process_ = spawn(HOST_FIT, ["serve", "--port", port], { cwd: folder, stdio: ["ignore", "pipe", "inherit"] });
  const url = await new Promise((found, failed) => {
    process_.once("error", failed);
    process_.once("exit", (code) => failed(new Error(`${HOST_FIT} serve ended with ${code} and no address`)));
    createInterface({ input: process_.stdout }).on("line", (line) => {
      const address = /^workbench at (http:\S+)$/.exec(line)?.[1];
      if (address) found(address);
    });
  });
  process_.removeAllListeners("exit");
  const stop = async () => {
    const ended = new Promise((done) => process_.once("exit", done));
    process_.kill();
    await ended;
  };
  return { url, folder, pid: process_.pid, stop };
}

/** @param {string[]} [flags] */
export const startBrowser = (flags = []) => chromium.launch({ executablePath: BROWSER, args: [...FLAGS, ...flags] });

/** A server and a browser, there from before the first test of a file to after its last, and the pages that they open. */
export function bench() {
  const server = startServer();
  const browser = startBrowser();
  /** @type {Page[]} */
  const pages = [];
  before(() => Promise.all([server, browser]));
  after(async () => {
    try {
      for (const page of pages) if (!page.isClosed()) await closePage(page);
    } finally {
      // each also when the other did not start, which the tests say: what runs on would keep this process from ending
      await browser.then((started) => started.close(), () => {});
      await server.then((started) => started.stop(), () => {});
    }
  });
  return {
    server,
    /** @param {Looks} [looks] */
    async open(looks) {
      const page = await openPage(await browser, await server, looks);
      pages.push(page);
      return page;
    },
  };
}

/**
 * A page that fails the test with any error that is not an answer of the server.
 * @param {Browser} browser
 * @param {Server} server
 * @param {Looks} [looks]
 */
export async function openPage(browser, server, { width = 1440, height = 900, theme = "light" } = {}) {
  const context = await browser.newContext({ viewport: { width, height }, colorScheme: theme, acceptDownloads: true, reducedMotion: "reduce" });
  const page = await context.newPage();
  page.setDefaultTimeout(15_000);
  /** @type {string[]} */
  const errors = [];
  page.on("pageerror", (error) => errors.push(error.stack ?? error.message));
  page.on("console", (message) => {
    if (message.type() === "error" && !/Failed to load resource/.test(message.text())) errors.push(message.text());
  });
  errorsOf.set(page, errors);
  await page.goto(`${server.url}#/open`);
  await page.waitForSelector(".opening");
  return page;
}

/** @type {WeakMap<Page, string[]>} */
const errorsOf = new WeakMap();

/** Ends a page; nothing may have gone wrong on it. @param {Page} page */
export async function closePage(page) {
  const errors = errorsOf.get(page) ?? [];
  await page.context().close();
  assert.deepEqual(errors, [], "errors on the page");
}

/** Opens the built-in example and waits for what stage is named. @param {Page} page @param {"logs" | "diagnosis"} stage */
export async function openExample(page, stage = "diagnosis") {
  await page.getByRole("button", { name: "Open the example with a hidden effect" }).click();
  await page.waitForURL(/#\/study\//);
  if (stage === "logs") await page.waitForSelector(".time-chart canvas", { timeout: SLOW });
  else await atRest(page);
}

/** Waits until a diagnosis is there and nothing is computed. @param {Page} page */
export async function atRest(page) {
  await page.waitForSelector("[data-verdict]", { timeout: SLOW });
  await page.waitForSelector('.job[data-state="rests"]', { timeout: SLOW });
}

/** Adds an effect and waits for its row of the staircase. @param {Page} page @param {string} effect */
export async function add(page, effect) {
  await page.locator(`[data-key="add:${effect}"]`).click();
  await page.waitForSelector(`[data-step="${effect}"]`, { timeout: SLOW });
  await atRest(page);
}

/** The study that the address names, as the server has it. @param {Page} page @param {Server} server */
export async function stateOf(page, server) {
  const id = /#\/study\/(\d+)/.exec(page.url())?.[1];
  const response = await fetch(`${server.url}api/studies/${id}`);
  return /** @type {import("../../host-fit/workbench/page/types.js").Page} */ (await response.json());
}

/** Numbers of a text, as a reader would read them: real minus, powers of ten. @param {string} text */
export function numbersIn(text) {
  const plain = text.replace(/[\u202f\u00a0](?=\d{3})/g, "").replace(/−/g, "-");
  return [...plain.matchAll(/-?\d+(?:\.\d+)?/g)].map(([digits]) => Number(digits));
}

/** What axe finds wrong on the page as it is. @param {Page} page @param {string} state its name in the message */
export async function assertAccessible(page, state) {
  const axe = await readFile(createRequire(import.meta.url).resolve("axe-core/axe.min.js"), "utf8");
  await page.evaluate(axe);
  const found = await page.evaluate(async () => {
    // @ts-ignore axe was just put there
    const { violations } = await globalThis.axe.run(document, { resultTypes: ["violations"] });
    return violations.map((/** @type {any} */ one) => `${one.id} (${one.impact}): ${one.help}\n  ${one.nodes.map((/** @type {any} */ node) => `${node.target.join(" ")}: ${node.failureSummary}`).join("\n  ")}`);
  });
  assert.deepEqual(found, [], `axe on ${state}`);
}

/** @param {Page} page @param {string} state */
export async function assertNoOverflow(page, state) {
  const wide = await page.evaluate(() => document.documentElement.scrollWidth - document.documentElement.clientWidth);
  assert.equal(wide, 0, `${state} is ${wide} px wider than the window`);
}

/**
 * Frames a second while `act` runs.
 * @param {Page} page
 * @param {() => Promise<void>} act
 */
export async function framesPerSecond(page, act) {
  await page.evaluate(() => {
    /** @type {any} */ (window).frames_ = [];
    const tick = (/** @type {number} */ time) => {
      /** @type {any} */ (window).frames_?.push(time);
      if (/** @type {any} */ (window).frames_) requestAnimationFrame(tick);
    };
    requestAnimationFrame(tick);
  });
  await act();
  const times = /** @type {number[]} */ (
    await page.evaluate(() => {
      const { frames_ } = /** @type {any} */ (window);
      /** @type {any} */ (window).frames_ = null;
      return frames_;
    })
  );
  const spans = times.slice(1).map((time, at) => time - Number(times[at]));
  const mean = (1000 * spans.length) / (Number(times[times.length - 1]) - Number(times[0]));
  return { mean, longest: Math.max(...spans) };
}

/** Where the plot of part 1 lies. @param {Page} page */
export async function plotOf(page) {
  const over = page.locator(".time-chart .u-over").first();
  await over.scrollIntoViewIfNeeded();
  const box = await over.boundingBox();
  assert.ok(box);
  return { ...box, y: box.y + box.height / 2 };
}

/** First and last second that the charts over time show. @param {Page} page */
export async function shownBy(page) {
  const [from, to] = numbersIn(await page.locator(".shown").innerText());
  return /** @type {[number, number]} */ ([from, to]);
}

/** Frames a second under a real hand, from the whole log four steps in. @param {Page} page */
export async function framesWhilePanningAndZooming(page) {
  for (let n = 0; n < 4; n += 1) await page.getByRole("button", { name: "Zoom in" }).click();
  await page.waitForTimeout(400);
  // A click may scroll the page, so the plot is looked for after it.
  const { x, y, width } = await plotOf(page);
  const before = await shownBy(page);
  const panning = await framesPerSecond(page, async () => {
    await page.keyboard.down("Shift");
    for (let sweep = 0; sweep < 3; sweep += 1) {
      await page.mouse.move(x + 0.8 * width, y);
      await page.mouse.down();
      for (let step = 0; step < 60; step += 1) {
        await page.mouse.move(x + width * (0.8 - 0.01 * step), y);
        await page.waitForTimeout(8);
      }
      await page.mouse.up();
    }
    await page.keyboard.up("Shift");
  });
  const moved = await shownBy(page);
  assert.ok(moved[0] > before[0] + 1, `panned from ${before} to ${moved}`);
  const zooming = await framesPerSecond(page, async () => {
    await page.mouse.move(x + 0.5 * width, y);
    for (const notch of [-60, 60]) {
      for (let step = 0; step < 30; step += 1) {
        await page.mouse.wheel(0, notch);
        await page.waitForTimeout(16);
      }
    }
  });
  return { panning, zooming };
}

/** A log in the units of data sheets, as a person might have it. */
export function unusualCsv() {
  const rows = ["time_ms,gyro_x,gyro_y,gyro_z,acc_x,acc_y,acc_z"];
  let random = 1;
  const noise = () => {
    let sum = 0;
    for (let n = 0; n < 4; n += 1) sum += (random = (random * 48271) % 2147483647) / 2147483647 - 0.5;
    return sum;
  };
  for (let n = 0; n < 24_000; n += 1) {
    const gyro = [70, -35, 20].map((bias) => (bias + 90 * noise()).toFixed(2));
    const accelerometer = [0.01, -0.02, 0.998].map((pose) => (pose + 0.002 * noise()).toFixed(5));
    rows.push([5 * n, ...gyro, ...accelerometer].join(","));
  }
  return rows.join("\n");
}

/** @param {string} name @param {string} text */
export const csvFile = (name, text) => ({ name, mimeType: "text/csv", buffer: Buffer.from(text) });
