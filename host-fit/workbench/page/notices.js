// @ts-check
// Messages of the server, until they are dismissed.

import { el, icon } from "./dom.js";

export class Notices {
  element = el("div", { class: "notices" });

  /** @param {string} message */
  show(message) {
    for (const shown of this.element.children) {
      if (shown instanceof HTMLElement && shown.dataset.message === message) return;
    }
    const notice = alertElement(message, () => notice.remove());
    notice.dataset.message = message;
    this.element.append(notice);
  }

  clear() {
    this.element.replaceChildren();
  }
}

/** Terms of the libraries, and where the page has them. @type {[RegExp, string][]} */
const ON_PAGE = [
  [/read the log with `keep_moved`/g, "press Include these rows"],
  [/pass it as `reference`/g, "choose it as reference log under Columns…"],
  [/log the true values \(`ref_…`\)/g, "log the true values in columns such as ref_gx_rads"],
  [/one with the true values \(`ref_…`\)/g, "one with the true values in columns such as ref_gx_rads"],
  [/`rate_hz`/g, "the sampling rate under Columns…"],
  [/the column map/g, "the table under Columns…"],
];

/** A message of the libraries in the terms of the page. @param {string} text */
export const onPage = (text) => ON_PAGE.reduce((message, [from, to]) => message.replace(from, to), text);

/** True if the rows with detected motion would make the log usable. @param {string} message */
export const needsMovedRows = (message) => message.includes("`keep_moved`");

/**
 * A message with the problem and, after `help:`, the remedy.
 * @param {string} message
 * @param {() => void} [dismiss]
 */
export function alertElement(message, dismiss) {
  const [wrong, ...help] = onPage(message).split(/\n?^help: /m);
  return el(
    "div",
    { class: "alert", role: "alert" },
    icon("caution"),
    el("div", {}, el("p", { class: "wrong" }, wrong), help.map((text) => el("p", { class: "help" }, text))),
    dismiss && el("button", { type: "button", class: "quiet", "aria-label": "Dismiss this message", onclick: dismiss }, icon("close")),
  );
}
