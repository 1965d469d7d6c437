// @ts-check
// The eight shapes of a series.

import uPlot from "./vendor/uplot.esm.js";
import { isNumber } from "./format.js";

/** @typedef {import("./types.js").Shape} Shape */
/** @typedef {number | null} Num */
/** @typedef {[number, number]} Point */
/** @typedef {{full: string, faint: string}} Colours */

const LINE = 1.5;

/** @param {uPlot} u @param {Shape} shape @param {Colours} colours */
export function drawShape(u, shape, colours) {
  const { ctx } = u;
  const unit = uPlot.pxRatio;
  ctx.strokeStyle = colours.full;
  ctx.fillStyle = colours.full;
  ctx.lineWidth = LINE * unit;
  ctx.lineJoin = "round";
  ctx.setLineDash([]);
  const place = placer(u);

  if ("Line" in shape) strokeRuns(ctx, shape.Line.map(([x, y]) => place(x, y)));
  else if ("Points" in shape) for (const [x, y] of shape.Points) dot(ctx, place(x, y), 2.5 * unit);
  else if ("Band" in shape) {
    ctx.fillStyle = colours.faint;
    ctx.strokeStyle = colours.faint;
    band(ctx, shape.Band.map(([x, low, high]) => [place(x, low), place(x, high)]));
  } else if ("Stems" in shape) {
    ctx.lineWidth = unit;
    for (const [x, y] of shape.Stems) {
      strokeRuns(ctx, [place(x, 0), place(x, y)]);
      dot(ctx, place(x, y), 2 * unit);
    }
  } else if ("Bars" in shape) {
    strokeRuns(ctx, shape.Bars.map(([x, y]) => place(x, y)));
    ctx.lineWidth = unit;
    for (const [x, y, low, high] of shape.Bars) {
      whisker(ctx, place(x, low), place(x, high), 3.5 * unit);
      dot(ctx, place(x, y), 3 * unit);
    }
  } else if ("Level" in shape) {
    const y = u.valToPos(shape.Level, "y", true);
    ctx.setLineDash([6 * unit, 4 * unit]);
    ctx.lineWidth = 1.25 * unit;
    strokeRuns(ctx, [[u.bbox.left, y], [u.bbox.left + u.bbox.width, y]]);
  } else {
    const isFilled = "Cells" in shape;
    for (const [left, right, low, high] of isFilled ? shape.Cells : shape.Frames) {
      const [from, to] = [place(left, high), place(right, low)];
      if (!from || !to) continue;
      if (isFilled) ctx.fillRect(from[0], from[1], to[0] - from[0], to[1] - from[1]);
      else ctx.strokeRect(from[0], from[1], to[0] - from[0], to[1] - from[1]);
    }
  }
}

/** Position of a value on the canvas; null if it is unknown or has no logarithm. @param {uPlot} u */
function placer(u) {
  const isLogX = u.scales.x?.distr === 3;
  const isLogY = u.scales.y?.distr === 3;
  /** @param {Num} x @param {Num} y @returns {Point | null} */
  return (x, y) => {
    if (!isNumber(x) || !isNumber(y) || (isLogX && x <= 0) || (isLogY && y <= 0)) return null;
    return [u.valToPos(x, "x", true), u.valToPos(y, "y", true)];
  };
}

/** Lines, interrupted where a point is missing. @param {CanvasRenderingContext2D} ctx @param {(Point | null)[]} points */
function strokeRuns(ctx, points) {
  ctx.beginPath();
  let isDown = false;
  for (const point of points) {
    if (point) ctx[isDown ? "lineTo" : "moveTo"](point[0], point[1]);
    isDown = point !== null;
  }
  ctx.stroke();
}

/** @param {CanvasRenderingContext2D} ctx @param {[Point | null, Point | null][]} edges low and high */
function band(ctx, edges) {
  /** @type {[Point, Point][]} */
  let run = [];
  const close = () => {
    if (run.length > 0) {
      ctx.beginPath();
      for (const [low] of run) ctx.lineTo(low[0], low[1]);
      for (const [, high] of run.reverse()) ctx.lineTo(high[0], high[1]);
      ctx.closePath();
      ctx.fill();
      ctx.stroke();
    }
    run = [];
  };
  for (const [low, high] of edges) {
    if (low && high) run.push([low, high]);
    else close();
  }
  close();
}

/** @param {CanvasRenderingContext2D} ctx @param {Point | null} at @param {number} radius */
function dot(ctx, at, radius) {
  if (!at) return;
  ctx.beginPath();
  ctx.arc(at[0], at[1], radius, 0, 2 * Math.PI);
  ctx.fill();
}

/** @param {CanvasRenderingContext2D} ctx @param {Point | null} low @param {Point | null} high @param {number} half */
function whisker(ctx, low, high, half) {
  if (!low || !high) return;
  strokeRuns(ctx, [low, high]);
  for (const [x, y] of [low, high]) strokeRuns(ctx, [[x - half, y], [x + half, y]]);
}
