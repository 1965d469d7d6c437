// @ts-check
// The workbench: a top bar, and below it the study, population or opening panel of the address.

import { addressedStudy, isOfColumns } from "./address.js";
import { get, messageOf, remove } from "./api.js";
import { el, icon, replace } from "./dom.js";
import { JobStatus } from "./jobstatus.js";
import { Notices } from "./notices.js";
import { OpenPanel } from "./openpanel.js";
import { PopulationPage, addressedPopulation } from "./populationpage.js";
import { sideBySide } from "./sidebyside.js";
import { StudyPage } from "./studypage.js";
import { themeSwitch } from "./theme.js";
import { OUTCOMES } from "./verdict.js";

/** @typedef {import("./types.js").Entry} StudyEntry */

const notices = new Notices();
const job = new JobStatus((error) => notices.show(messageOf(error)));
const tabs = el("nav", { class: "tabs", "aria-label": "Studies" });
const beside = el("div");
const main = el("main", { id: "main", tabindex: -1 });

document.body.append(
  el("a", { class: "skip", href: "#main", onclick: skip }, "Skip to the study"),
  el("header", { class: "top" }, el("a", { class: "brand", href: "#/open", "aria-label": "fos workbench: open a log" }, "fos"), tabs, job.element, themeSwitch()),
  notices.element,
  main,
);

/** @type {StudyEntry[]} */
let studies = [];
/** @type {StudyPage | null} */
let page = null;
/** @type {OpenPanel | null} */
let opening = null;
/** @type {PopulationPage | null} */
let population = null;

/** @param {Event} event */
function skip(event) {
  event.preventDefault(); // the address is of the study
  main.focus();
}

/** The study of the address. */
const addressed = () => addressedStudy(location.hash);

async function listStudies() {
  try {
    studies = await get("/api/studies");
    drawTabs();
    replace(beside, sideBySide(studies));
  } catch (error) {
    notices.show(messageOf(error));
  }
}

function drawTabs() {
  const current = addressed();
  const tab = (/** @type {StudyEntry} */ { id, name, outcome, working }) =>
    el(
      "span",
      { class: "tab", "data-current": String(id === current) },
      el(
        "a",
        { href: `#/study/${id}`, title: name, "aria-current": id === current ? "page" : null, "data-key": `tab:${id}` },
        working ? el("i", { class: "working" }) : outcome ? icon(outcome) : null,
        el("span", { class: "tab-name" }, name),
        el("span", { class: "unseen" }, working ? ", working" : outcome ? `, ${OUTCOMES[outcome].word}` : ""),
      ),
      el("button", { type: "button", class: "quiet", "aria-label": `Close ${name}`, "data-key": `close:${id}`, onclick: () => void close(id) }, icon("close")),
    );
  const isOpening = current === null && !addressedPopulation(location.hash);
  replace(tabs, studies.map(tab), el("a", { class: "new", href: "#/open", "aria-current": isOpening ? "page" : null, "data-key": "tab:new" }, "New"));
  showCurrentTab();
}

const showCurrentTab = () => tabs.querySelector(".tab[data-current=true], .new[aria-current]")?.scrollIntoView({ block: "nearest", inline: "nearest" });
// the status of a job takes room from the tabs
new ResizeObserver(showCurrentTab).observe(tabs);

/** @param {number} id */
async function close(id) {
  try {
    await remove(`/api/studies/${id}`);
  } catch (error) {
    return notices.show(messageOf(error));
  }
  const at = studies.findIndex((study) => study.id === id);
  studies = studies.filter((study) => study.id !== id);
  const neighbour = studies[Math.min(Math.max(at, 0), studies.length - 1)];
  if (addressed() === id) location.hash = neighbour ? `#/study/${neighbour.id}` : "#/open";
  else drawTabs();
}

/** Shows the study, population or panel of the address. */
function route() {
  const id = addressed();
  const isColumns = isOfColumns(location.hash);
  if (page?.id !== id || isColumns) {
    page?.close();
    page = null;
    job.follow(null, null);
  }
  const named = addressedPopulation(location.hash);
  if (!named) population = null;
  if (named) {
    if (population?.path !== named.path) {
      notices.clear();
      population = new PopulationPage(named.path, { notices, opened });
      main.replaceChildren(population.element);
      document.title = `${named.path} – fos workbench`;
      scrollTo(0, 0);
    }
    population.show(named);
  } else if (id === null) {
    opening ??= new OpenPanel(opened);
    opening.refresh();
    main.replaceChildren(opening.element, beside);
    void listStudies();
    document.title = "fos workbench";
  } else if (isColumns) {
    notices.clear();
    const columns = new OpenPanel(opened);
    void columns.edit(id);
    main.replaceChildren(columns.element);
    document.title = "Columns – fos workbench";
    scrollTo(0, 0);
  } else if (page) {
    page.visit(location.hash);
  } else {
    page = new StudyPage(id, {
      notices,
      changed(state) {
        job.follow(id, state.job);
        const { outcome, name } = state;
        document.title = `${outcome ? `${OUTCOMES[outcome].title}: ` : ""}${name} – fos workbench`;
        if (state.logs) opening = null;
        const entry = studies.find((study) => study.id === id);
        const working = state.job !== null;
        if (!entry) return void listStudies();
        if (entry.outcome === outcome && entry.working === working && entry.name === name) return;
        Object.assign(entry, { outcome, working, name });
        drawTabs();
      },
      connected: (connected) => job.connected(connected),
      gone() {
        notices.show("This study is no longer open.\nhelp: it was closed; open its logs again");
        location.hash = "#/open";
        void listStudies();
      },
    });
    main.replaceChildren(page.element);
    scrollTo(0, 0);
  }
  drawTabs();
}

/** @param {number} id */
function opened(id) {
  notices.clear();
  location.hash = `#/study/${id}`;
  void listStudies();
}

// A file dropped anywhere on the page opens the panel.
addEventListener("dragover", (event) => event.preventDefault());
addEventListener("drop", (event) => {
  event.preventDefault();
  const files = [...(event.dataTransfer?.files ?? [])];
  if (files.length === 0) return;
  location.hash = "#/open";
  opening ??= new OpenPanel(opened);
  void opening.take(files);
});
addEventListener("hashchange", route);
document.addEventListener("visibilitychange", () => {
  if (!document.hidden) void listStudies();
});

await listStudies();
const last = studies[studies.length - 1];
if (location.hash === "" && last) location.replace(`#/study/${last.id}`);
else route();
