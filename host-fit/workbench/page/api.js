// @ts-check
// Requests to the server. Errors keep the text of the server.

/** Error answer with the complete text of the server. */
export class ApiError extends Error {
  /** @param {string} message @param {number} status */
  constructor(message, status) {
    super(message);
    this.status = status;
  }
}

/** Message if there is no answer. */
const SILENT = "The server does not answer.\nhelp: start `fos serve` again; the page reconnects without a reload.";

/**
 * @param {string} path
 * @param {RequestInit} [options]
 * @returns {Promise<any>}
 */
async function request(path, options = {}) {
  let response;
  try {
    response = await fetch(path, options);
  } catch (error) {
    if (options.signal?.aborted) throw error;
    throw new ApiError(SILENT, 0);
  }
  const text = await response.text();
  if (response.ok) return text ? JSON.parse(text) : {};
  throw new ApiError(errorText(text) ?? `${response.status} ${response.statusText}`, response.status);
}

/** @param {string} text */
function errorText(text) {
  try {
    return /** @type {string} */ (JSON.parse(text).error);
  } catch {
    return text || null;
  }
}

/** Header that the server requires for changes, because no other page can send it. */
const OURS = { "x-fos-workbench": "1" };

/** @param {string} path @param {AbortSignal} [signal] */
export const get = (path, signal) => request(path, signal ? { signal } : {});

/** @param {string} path @param {unknown} [body] */
export const post = (path, body = {}) =>
  request(path, {
    method: "POST",
    headers: { ...OURS, "content-type": "application/json" },
    body: JSON.stringify(body),
  });

/** @param {string} path */
export const remove = (path) => request(path, { method: "DELETE", headers: OURS });

/**
 * Sends a file as it is.
 * @param {File} file
 * @returns {Promise<{path: string}>}
 */
export const upload = (file) =>
  request(`/api/uploads?name=${encodeURIComponent(file.name)}`, {
    method: "POST",
    headers: { ...OURS, "content-type": "application/octet-stream" },
    body: file,
  });

/** @param {unknown} error */
export const messageOf = (error) => (error instanceof Error ? error.message : String(error));

/** @param {unknown} error */
export const isAbort = (error) => error instanceof DOMException && error.name === "AbortError";
