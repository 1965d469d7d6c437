// @ts-check
// The running computation, its progress, and the button that cancels it.

import { post } from "./api.js";
import { el } from "./dom.js";

/** @typedef {import("./types.js").Job} Job */

export class JobStatus {
  #what = el("span", { class: "what" });
  #bar = el("progress", { max: 1, "aria-label": "Progress" });
  #cancel = el("button", { type: "button", class: "small", onclick: () => void this.#end() }, "Cancel");
  #work = el("div", { class: "work", hidden: true }, this.#bar, this.#cancel);
  element = el("div", { class: "job" }, el("span", { class: "said", role: "status", "aria-live": "polite" }, this.#what), this.#work);
  /** @type {number | null} */
  #study = null;
  #isConnected = true;
  /** @type {Job | null} */
  #job = null;
  #failed;

  /** @param {(error: unknown) => void} failed */
  constructor(failed) {
    this.#failed = failed;
  }

  /** @param {number | null} study @param {Job | null} job */
  follow(study, job) {
    this.#study = study;
    this.#job = job;
    this.#draw();
  }

  /** @param {boolean} connected */
  connected(connected) {
    this.#isConnected = connected;
    this.#draw();
  }

  #draw() {
    const job = this.#job;
    const text = !this.#isConnected ? "Connection lost, trying again" : job ? job.what : this.#study ? "Ready" : "";
    // a screen reader repeats text that is set again
    if (this.#what.textContent !== text) this.#what.textContent = text;
    this.element.dataset.state = !this.#isConnected ? "lost" : job ? "works" : "rests";
    if (!job && this.#work.contains(document.activeElement)) document.getElementById("main")?.focus({ preventScroll: true });
    this.#work.hidden = !job;
    if (job && job.of !== null) this.#bar.value = (job.done ?? 0) / job.of;
    else this.#bar.removeAttribute("value");
  }

  async #end() {
    if (!this.#study) return;
    try {
      await post(`/api/studies/${this.#study}/cancel`);
    } catch (error) {
      this.#failed(error);
    }
  }
}
