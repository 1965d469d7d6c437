// @ts-check
// A hostile page in the same browser, while a workbench runs: what it can read, change or show of it. Nothing, or this fails.
//
//   node foreign.mjs short|full
//
// The same page meets a workbench through a door that lets everything in first, where every attempt must succeed, or it would
// show nothing; in full also doors that leave out one of the four checks each.

import assert from "node:assert/strict";
import { createServer, request } from "node:http";
import { startBrowser, startServer } from "./workbench.js";

/** A name that the browser takes for this machine, as after "DNS rebinding". */
const FOREIGN = "foreign.test";
/** In the name of a log: who reads it has read what is not theirs. */
const SECRET = `secret-${process.pid}`;
/** What must happen happens within this time, ms. */
const AT_MOST = 10_000;
/** What does not happen within so many times what it takes where nothing is in its way does not happen, and within this, ms. */
const [TIMES_AS_LONG, AT_LEAST] = [3, 1500];

/** @typedef {"host" | "origin" | "header" | "answers"} Check */
const CHECKS = /** @type {Check[]} */ (["host", "origin", "header", "answers"]);
const CALLED = { host: "host name of the request", origin: "origin of the request", header: "request header of the workbench page", answers: "security headers of the response" };

/**
 * What a page tries. It runs in that page; what it says is true if it got in. What was sent blindly shows at the workbench.
 * @type {Record<string, {does: (to: {at: string, secret: string, patience: number, watch: number}) => Promise<boolean>, blind?: true, watched?: true, everywhere?: true}>}
 */
const ATTEMPTS = {
  "reads with fetch": {
    everywhere: true,
    does: async ({ at, secret }) => (await (await fetch(`${at}api/logs`)).text()).includes(secret),
  },
  "reads with XMLHttpRequest": {
    everywhere: true,
    does: ({ at, secret }) =>
      new Promise((done) => {
        const asked = new XMLHttpRequest();
        asked.open("GET", `${at}api/logs`);
        asked.onloadend = () => done(asked.responseText.includes(secret));
        asked.send();
      }),
  },
  "reads with the header of the own page": {
    everywhere: true,
    does: async ({ at, secret }) => (await (await fetch(`${at}api/logs`, { headers: { "x-fos-workbench": "1" } })).text()).includes(secret),
  },
  "sends with the header of the own page": {
    everywhere: true,
    blind: true,
    does: async ({ at }) => (await fetch(`${at}api/uploads?name=planted.csv`, { method: "POST", headers: { "x-fos-workbench": "1" }, body: "planted" })).ok,
  },
  "sends without asking": {
    everywhere: true,
    blind: true,
    does: async ({ at }) => (await fetch(`${at}api/uploads?name=planted.csv`, { method: "POST", mode: "no-cors", body: "planted" })).ok,
  },
  "sends a beacon": {
    everywhere: true,
    blind: true,
    does: async ({ at }) => !navigator.sendBeacon(`${at}api/uploads?name=planted.csv`, "planted"),
  },
  "sends a form": {
    everywhere: true,
    blind: true,
    does: async ({ at }) => {
      const form = document.createElement("form");
      const frame = document.createElement("iframe");
      frame.name = form.target = "nowhere";
      Object.assign(form, { action: `${at}api/uploads?name=planted.csv`, method: "post", enctype: "text/plain" });
      document.body.append(frame, form);
      form.submit();
      return false;
    },
  },
  "runs a file of it": {
    does: ({ at, patience }) =>
      new Promise((done) => {
        const script = document.createElement("script");
        script.src = `${at}main.js`;
        script.onload = () => done(true);
        script.onerror = () => done(false);
        setTimeout(done, patience, false);
        document.body.append(script);
      }),
  },
  "keeps a handle to its window": {
    watched: true,
    does: async ({ at, watch }) => {
      const opened = window.open(at);
      const until = performance.now() + watch;
      while (opened && !opened.closed && performance.now() < until) await new Promise((done) => setTimeout(done, 50));
      const kept = opened !== null && !opened.closed;
      opened?.close();
      return kept;
    },
  },
};
/** The last one is seen from outside: a page cannot look into a frame of another. */
const FRAME = "shows it in a frame of its own";

/**
 * A door in front of a workbench that leaves checks out: it makes of every request one that passes them.
 * @param {string} url of the workbench @param {Check[]} without
 */
async function door(url, without) {
  const own = new URL(url).host;
  const server = createServer((asked, answer) => {
    const names = [`127.0.0.1:${port}`, `localhost:${port}`];
    const headers = { ...asked.headers };
    if (without.includes("host") || names.includes(headers.host ?? "")) headers.host = own;
    if (without.includes("origin")) {
      for (const name of ["origin", "sec-fetch-site", "sec-fetch-mode", "sec-fetch-dest", "referer"]) delete headers[name];
    }
    if (without.includes("header")) headers["x-fos-workbench"] = "1";
    const open = { "access-control-allow-origin": "*", "access-control-allow-headers": "*" };
    if (without.includes("answers") && asked.method === "OPTIONS") return void answer.writeHead(204, open).end();
    const passed = request(url, { method: asked.method, path: asked.url, headers }, (from) => {
      const said = { ...from.headers };
      if (without.includes("answers")) {
        for (const name of ["content-security-policy", "x-frame-options", "x-content-type-options", "cross-origin-resource-policy", "cross-origin-opener-policy"]) delete said[name];
        Object.assign(said, open);
      }
      answer.writeHead(from.statusCode ?? 502, said);
      from.pipe(answer);
    });
    passed.on("error", () => answer.destroy());
    asked.pipe(passed);
  });
  const port = await listening(server);
  return { url: `http://127.0.0.1:${port}/`, close: () => server.close() };
}

/** @param {import("node:http").Server} server */
async function listening(server) {
  await new Promise((done) => server.listen(0, "127.0.0.1", () => done(undefined)));
  const address = server.address();
  assert.ok(address && typeof address === "object");
  return address.port;
}

const PAGE = "<!doctype html><title>a hostile page</title><body>";

/**
 * All attempts from all places: what got in, by place and attempt, and how long the slowest of them took that was not watched, ms.
 * @param {import("./workbench.js").Browser} browser @param {string} workbench where it is @param {string} door where it is met
 * @param {number} patience ms @param {number} watch how long a window is watched that nothing closes, ms
 */
async function attack(browser, workbench, door, patience, watch = AT_MOST) {
  const elsewhere = createServer((_, answer) => answer.setHeader("content-type", "text/html").end(PAGE));
  const there = await listening(elsewhere);
  const { port } = new URL(door);
  const logs = async () => (await fetch(`${workbench}api/logs`)).text();
  /** @type {Record<string, {page: string, at: string, rebound?: true}>} */
  const places = {
    "another site": { page: `http://${FOREIGN}:${there}/`, at: door },
    "another port of this machine": { page: `http://127.0.0.1:${there}/`, at: door },
    "a foreign host name that now resolves to this machine": { page: `http://${FOREIGN}:${port}/`, at: `http://${FOREIGN}:${port}/`, rebound: true },
  };
  const got = /** @type {string[]} */ ([]);
  let [tried, slowest] = [0, 0];
  /** @param {() => Promise<boolean>} does @param {string} what @param {boolean} [watched] */
  const attempt = async (does, what, watched) => {
    const began = performance.now();
    tried += 1;
    if (!(await does())) return;
    got.push(what);
    if (!watched) slowest = Math.max(slowest, performance.now() - began);
  };
  for (const [place, { page: from, at, rebound }] of Object.entries(places)) {
    for (const [name, { does, blind, watched, everywhere }] of Object.entries(ATTEMPTS)) {
      if (rebound && !everywhere) continue;
      const context = await browser.newContext();
      const page = await context.newPage();
      // what the name meant before
      if (rebound) await page.route(from, (route) => route.fulfill({ contentType: "text/html", body: PAGE }));
      await page.goto(from);
      const before = await logs();
      await attempt(async () => {
        const until = performance.now() + patience;
        let isIn = await page.evaluate(does, { at, secret: SECRET, patience, watch }).catch(() => false);
        while (blind && !isIn && performance.now() < until) {
          await new Promise((done) => setTimeout(done, 50));
          isIn = (await logs()) !== before;
        }
        return isIn;
      }, `${place}: ${name}`, watched);
      await context.close();
    }
    if (rebound) continue;
    const context = await browser.newContext();
    const page = await context.newPage();
    await page.goto(from);
    await page.evaluate((url) => void document.body.append(Object.assign(document.createElement("iframe"), { src: url })), at);
    const shown = () => page.frameLocator("iframe").locator(".opening").waitFor({ timeout: patience }).then(() => true, () => false);
    await attempt(shown, `${place}: ${FRAME}`);
    await context.close();
  }
  elsewhere.close();
  return { got, tried, slowest, places: Object.keys(places) };
}

const form = process.argv[2];
if (form !== "short" && form !== "full") {
  console.error("usage: node foreign.mjs short|full");
  process.exit(2);
}
const server = await startServer();
// newer browsers keep some of it out by themselves; who has an older one relies on the workbench alone
const browser = await startBrowser([`--host-resolver-rules=MAP ${FOREIGN} 127.0.0.1`, "--disable-features=LocalNetworkAccessChecks"]);
try {
  const sent = await fetch(`${server.url}api/uploads?name=${SECRET}.csv`, { method: "POST", headers: { "x-fos-workbench": "1" }, body: "t_s,gx_rads\n" });
  assert.ok(sent.ok, "the own page sends a log");
  /** @param {Check[]} without @param {number} patience @param {number} [watch] */
  const through = async (without, patience, watch) => {
    const open = await door(server.url, without);
    const result = await attack(browser, server.url, open.url, patience, watch);
    open.close();
    return result;
  };
  const control = await through(CHECKS, AT_MOST, AT_LEAST);
  assert.equal(control.got.length, control.tried, `an attempt that fails where nothing keeps it out shows nothing:\n${control.got.join("\n")}`);
  const patience = Math.max(AT_LEAST, TIMES_AS_LONG * control.slowest);
  const { got, tried, places } = await attack(browser, server.url, server.url, patience);
  assert.deepEqual(got, [], "a hostile page gets in");
  console.log(`Pages from three origins (${places.join(", ")}) in Chromium ${browser.version()} made ${tried} attempts to read the logs, to send one, to run a script of the workbench, to keep a handle to its window or to show it in a frame: none succeeded.\n`);
  console.log(`Negative control: through a proxy that disables all four checks of the same workbench, ${control.got.length} of the same ${control.tried} attempts succeed.`);
  if (form === "full") {
    console.log("\n| only this check disabled | successful attempts |\n|---|---|");
    for (const check of CHECKS) console.log(`| ${CALLED[check]} | ${(await through([check], patience)).got.length} |`);
  }
} finally {
  await browser.close();
  await server.stop();
}
