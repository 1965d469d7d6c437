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

/**
 * A message with the problem and, after `help:`, the remedy.
 * @param {string} message
 * @param {() => void} [dismiss]
 */
export function alertElement(message, dismiss) {
  const [wrong, ...help] = message.split(/\n?^help: /m);
  return el(
    "div",
    { class: "alert", role: "alert" },
    icon("caution"),
    el("div", {}, el("p", { class: "wrong" }, wrong), help.map((text) => el("p", { class: "help" }, text))),
    dismiss && el("button", { type: "button", class: "quiet", "aria-label": "Dismiss this message", onclick: dismiss }, icon("close")),
  );
}
