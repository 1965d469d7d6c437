// @ts-check
// Numbers for people: three or four digits, a real minus, plain notation where it is readable.

const NARROW = "\u202f"; // narrow space that does not break
const MINUS = "\u2212";
const SUPERSCRIPT = "⁰¹²³⁴⁵⁶⁷⁸⁹";

/** Text in place of an absent number. */
export const UNKNOWN = "–";

/** @param {number | null | undefined} value @returns {value is number} */
export function isNumber(value) {
  return typeof value === "number" && Number.isFinite(value);
}

/** @param {string} text */
function typeset(text) {
  const [mantissa, exponent] = text.replace(/-/g, MINUS).split("e");
  if (exponent === undefined) return grouped(/** @type {string} */ (mantissa));
  return `${mantissa}×10${raised(Number(exponent.replace(MINUS, "-")))}`;
}

/** As an exponent. @param {number} exponent */
export function raised(exponent) {
  return [...String(exponent)].map((c) => (c === "-" ? "⁻" : SUPERSCRIPT[Number(c)])).join("");
}

/** Groups of three from five digits on. @param {string} text */
function grouped(text) {
  const [whole, part] = text.split(".");
  const digits = /** @type {string} */ (whole);
  const spaced = digits.replace(MINUS, "").length > 4 ? digits.replace(/\B(?=(\d{3})+$)/g, NARROW) : digits;
  return part === undefined ? spaced : `${spaced}.${part}`;
}

/**
 * A number with this many significant digits.
 * @param {number | null | undefined} value
 */
export function number(value, digits = 3) {
  if (!isNumber(value)) return UNKNOWN;
  if (value === 0) return "0";
  const size = Math.abs(value);
  if (size >= 1e6 || size < 1e-5) return typeset(value.toExponential(digits - 1));
  const decimals = Math.max(0, digits - 1 - Math.floor(Math.log10(size)));
  return typeset(value.toFixed(decimals));
}

/** A count, in groups of three. @param {number | null | undefined} value */
export function count(value) {
  return isNumber(value) ? typeset(String(Math.round(value))) : UNKNOWN;
}

/**
 * A number with its unit.
 * @param {number | null | undefined} value
 * @param {string} unit
 */
export function quantity(value, unit, digits = 3) {
  if (!isNumber(value)) return UNKNOWN;
  const text = number(value, digits);
  return unit ? `${text}${NARROW}${unit}` : text;
}

/** A share as percent. @param {number | null | undefined} share */
export function percent(share, digits = 1) {
  return isNumber(share) ? `${typeset((100 * share).toFixed(digits))}${NARROW}%` : UNKNOWN;
}

/**
 * From one number to another, with one unit.
 * @param {[number | null, number | null] | null | undefined} interval
 * @param {(value: number | null) => string} write
 */
export function interval(interval, write) {
  return interval ? `${write(interval[0])} … ${write(interval[1])}` : UNKNOWN;
}

/** Seconds, with a decimal only if the log is short. @param {number} value */
export function seconds(value, span = 100) {
  const decimals = span >= 100 ? 0 : span >= 10 ? 1 : span >= 1 ? 2 : 3;
  return `${typeset(value.toFixed(decimals))}${NARROW}s`;
}

/** Duration of a log. @param {number} value */
export function duration(value) {
  if (value < 120) return seconds(value);
  if (value < 7200) return `${brief(value / 60)}${NARROW}min`;
  return `${brief(value / 3600)}${NARROW}h`;
}

/** Three digits without trailing zeros. @param {number} value */
const brief = (value) => String(Number(value.toPrecision(3)));

/** @param {number} value */
export function bytes(value) {
  if (value < 1000) return `${value}${NARROW}B`;
  return value < 1e6 ? `${number(value / 1e3)}${NARROW}kB` : `${number(value / 1e6)}${NARROW}MB`;
}

/** Last part of a path. @param {string} path */
export function fileName(path) {
  return path.split(/[\\/]/).pop() ?? path;
}

/** Text with a capital first letter. @param {string} text */
export function capitalised(text) {
  return text.charAt(0).toUpperCase() + text.slice(1);
}

/** The first sentence, and the rest. @param {string} text @returns {[string, string]} */
export function firstSentence(text) {
  const end = text.search(/[.:](?=\s+[A-Z])/);
  return end < 0 ? [text, ""] : [text.slice(0, end + 1), text.slice(end + 1).trim()];
}
