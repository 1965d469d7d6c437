// @ts-check
// A hostile page in the same browser, while a workbench runs: what it can read, change or show of it. Nothing, or this fails.
//
//   node foreign.mjs short|full
//
// The same page then meets a workbench through a door that lets everything in, where every attempt must succeed, or it would
// show nothing; in full also doors that leave out one of the four checks each.

import assert from "node:assert/strict";
import { createServer, request } from "node:http";
import { startBrowser, startServer } from "./workbench.js";

/** A name that the browser takes for this machine, as after "DNS rebinding". */
const FOREIGN = "foreign.test";
/** In the name of a log: who reads it has read what is not theirs. */
const SECRET = `secret-${process.pid}`;
/** What does not happen within this time does not happen, ms. */
const PATIENCE = 1500;

/** @typedef {"host" | "origin" | "header" | "answers"} Check */
const CHECKS = /** @type {Check[]} */ (["host", "origin", "header", "answers"]);
const CALLED = { host: "the name that is asked for", origin: "the page that asks", header: "the header of the own page", answers: "what the browser is told with an answer" };

/**
 * What a page tries. It runs in that page; what it says is true if it got in. What was sent blindly shows at the workbench.
 * @type {Record<string, {does: (to: {at: string, secret: string, patience: number}) => Promise<boolean>, blind?: true, everywhere?: true}>}
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
  "keeps a hand on its window": {
    does: async ({ at, patience }) => {
      const opened = window.open(at);
      await new Promise((done) => setTimeout(done, patience));
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
 * All attempts from all places: what got in, by place and attempt.
 * @param {import("./workbench.js").Browser} browser @param {string} workbench where it is @param {string} door where it is met
 */
async function attack(browser, workbench, door) {
  const elsewhere = createServer((_, answer) => answer.setHeader("content-type", "text/html").end(PAGE));
  const there = await listening(elsewhere);
  const { port } = new URL(door);
  const logs = async () => (await fetch(`${workbench}api/logs`)).text();
  /** @type {Record<string, {page: string, at: string, rebound?: true}>} */
  const places = {
    "another site": { page: `http://${FOREIGN}:${there}/`, at: door },
    "another port of this machine": { page: `http://127.0.0.1:${there}/`, at: door },
    "a name that has come to mean this machine": { page: `http://${FOREIGN}:${port}/`, at: `http://${FOREIGN}:${port}/`, rebound: true },
  };
  const got = /** @type {string[]} */ ([]);
  let tried = 0;
  for (const [place, { page: from, at, rebound }] of Object.entries(places)) {
    for (const [name, { does, blind, everywhere }] of Object.entries(ATTEMPTS)) {
      if (rebound && !everywhere) continue;
      const context = await browser.newContext();
      const page = await context.newPage();
      // what the name meant before
      if (rebound) await page.route(from, (route) => route.fulfill({ contentType: "text/html", body: PAGE }));
      await page.goto(from);
      const before = await logs();
      let is_in = await page.evaluate(does, { at, secret: SECRET, patience: PATIENCE }).catch(() => false);
      if (blind) {
        for (let waited = 0; waited < PATIENCE && !is_in; waited += 50) {
          await new Promise((done) => setTimeout(done, 50));
          is_in = (await logs()) !== before;
        }
      }
      tried += 1;
      if (is_in) got.push(`${place}: ${name}`);
      await context.close();
    }
    if (rebound) continue;
    const context = await browser.newContext();
    const page = await context.newPage();
    await page.goto(from);
    await page.evaluate((url) => void document.body.append(Object.assign(document.createElement("iframe"), { src: url })), at);
    const shown = await page.frameLocator("iframe").locator(".opening").waitFor({ timeout: PATIENCE }).then(() => true, () => false);
    tried += 1;
    if (shown) got.push(`${place}: ${FRAME}`);
    await context.close();
  }
  elsewhere.close();
  return { got, tried, places: Object.keys(places) };
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
  const { got, tried, places } = await attack(browser, server.url, server.url);
  assert.deepEqual(got, [], "a hostile page gets in");
  console.log(`A page of three kinds (${places.join(", ")}) in Chromium ${browser.version()}, in ${tried} attempts to read the logs, to send one, to run a file of the workbench, to keep a hand on its window or to show it in a frame: none got in.\n`);
  /** @param {Check[]} without */
  const through = async (without) => {
    const open = await door(server.url, without);
    const result = await attack(browser, server.url, open.url);
    open.close();
    return result;
  };
  const control = await through(CHECKS);
  assert.equal(control.got.length, control.tried, `an attempt that fails where nothing keeps it out shows nothing:\n${control.got.join("\n")}`);
  console.log(`Negative control, a door in front of the same workbench that leaves out all four checks: ${control.got.length} of the same ${control.tried} attempts get in.`);
  if (form === "full") {
    console.log("\n| left out alone | get in |\n|---|---|");
    for (const check of CHECKS) console.log(`| ${CALLED[check]} | ${(await through([check])).got.length} |`);
  }
} finally {
  await browser.close();
  await server.stop();
}
