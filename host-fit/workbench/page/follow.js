// @ts-check
// Follows one study: reads its state after each event of the server.

import { ApiError, get } from "./api.js";

/** @typedef {import("./types.js").Page} State */
/** @typedef {{state: (state: State) => void, connected: (connected: boolean) => void, gone: () => void, failed: (error: unknown) => void}} Follower */

/** First wait before trying again, ms; it doubles up to the longest. */
const FIRST_WAIT = 500;
const LONGEST_WAIT = 5000;

/**
 * @param {number} id
 * @param {Follower} follower
 * @returns {{close: () => void, refresh: () => Promise<void>}}
 */
export function follow(id, follower) {
  /** @type {State | null} */
  let state = null;
  /** @type {EventSource | null} */
  let events = null;
  /** @type {Promise<void> | null} */
  let reading = null;
  let again = false;
  let closed = false;
  let wait = FIRST_WAIT;

  async function read() {
    try {
      const answer = /** @type {State} */ (await get(`/api/studies/${id}`));
      if (closed) return;
      state = answer;
      follower.connected(true);
      follower.state(state);
    } catch (error) {
      if (closed) return;
      if (error instanceof ApiError && error.status === 404) {
        close();
        follower.connected(true);
        follower.gone();
      } else if (error instanceof ApiError && error.status === 0) {
        follower.connected(false);
      } else follower.failed(error);
    }
  }

  /** One request at a time. A change during a request leads to one more request after it. */
  function refresh() {
    if (reading) {
      again = true;
      return reading;
    }
    reading = read().finally(() => {
      reading = null;
      if (!again || closed) return;
      again = false;
      void refresh();
    });
    return reading;
  }

  function listen() {
    // A browser has six connections to a server in all: hidden windows free theirs.
    if (closed || document.hidden || events) return;
    events = new EventSource(`/api/studies/${id}/events`);
    events.onopen = () => {
      wait = FIRST_WAIT;
      follower.connected(true);
      void refresh(); // events may have been missed
    };
    events.onmessage = (event) => {
      const { revision, job } = JSON.parse(event.data);
      if (!state || revision !== state.revision) void refresh();
      else {
        state = { ...state, job };
        follower.state(state);
      }
    };
    events.onerror = () => {
      follower.connected(false);
      if (events?.readyState !== EventSource.CLOSED) return; // the browser reconnects
      events = null;
      setTimeout(listen, wait);
      wait = Math.min(2 * wait, LONGEST_WAIT);
      void refresh(); // the study may have been closed
    };
  }

  function rest() {
    events?.close();
    events = null;
  }

  function seen() {
    if (document.hidden) rest();
    else listen();
  }

  function close() {
    closed = true;
    document.removeEventListener("visibilitychange", seen);
    rest();
  }

  document.addEventListener("visibilitychange", seen);
  void refresh();
  listen();
  return { close, refresh };
}
