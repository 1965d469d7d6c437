// @ts-check
// Parameters of an effect in words: "time constant 52.7 s" for tau_s.

import { capitalised, isNumber, number, percent, quantity } from "./format.js";

/** Units of parameters, by the end of their name. @type {Record<string, string>} */
const UNITS = { s: "s", k: "K", hz: "Hz", v: "V" };

/** Names that do not say what the parameter is. @type {Record<string, string>} */
const NAMES = { tau_s: "time constant", freq_hz: "frequency", dwell_s: "mean dwell time", mult: "step, multiple of the usual one", frac: "share of the samples" };

/** Names of shares, by effect. @type {Record<string, string>} */
const SHARES = { dropped_samples: "missing samples", saturation: "clipped samples" };

/** @param {string} name @param {string} [effect] */
export function parameterName(name, effect = "") {
  const words = name === "frac" ? SHARES[effect] : undefined;
  return capitalised(words ?? NAMES[name] ?? name.replace(/_(s|k|hz|v)$/, "").replaceAll("_", " "));
}

/** @param {string} name @param {number | null | undefined} value */
export function parameterValue(name, value) {
  if (name === "frac") return shareOf(value);
  return quantity(value, UNITS[name.split("_").pop() ?? ""] ?? "");
}

/** A share of few samples in as many digits as it needs. @param {number | null | undefined} share */
const shareOf = (share) => (isNumber(share) && share !== 0 && Math.abs(share) < 0.01 ? quantity(100 * share, "%", 2) : percent(share));

/** Limits of a parameter, without its unit where it is one of the value. @param {string} name @param {number | null} value */
export const parameterLimit = (name, value) => (name === "frac" ? shareOf(value) : number(value));

/** A sentence with its parameters in words: "(tau_s = 52.7)" is written "(time constant 52.7 s)". @param {string} text */
export const withParameters = (text) =>
  text
    .replace(/\b([a-z]\w*) = (-?\d[\d.]*(?:e-?\d+)?)(?=[,)])/g, (_, name, value) => `${name === "frac" ? "" : `${parameterName(name).toLowerCase()} `}${parameterValue(name, Number(value))}`)
    .replace(/\b(tau_s|freq_hz|half_width_k|dwell_s|onset_s)\b/g, (name) => parameterName(name).toLowerCase());
