// The charts of a report: one cursor, one piece of track for all of them. Print, and readers whose browser runs no
// scripts, have pictures instead.
import uPlot from "uplot";
import "uplot/dist/uPlot.min.css";

const data = JSON.parse(document.getElementById("data").textContent);
const x = data.x;
const plots = [];
const whole = [x[0], x[x.length - 1]];
const slider = document.getElementById("place");
const shown = document.getElementById("place-shown");
const several = data.charts.some((chart) => chart.lines.some((line) => line.run > 0));
let part = "";
let quiet = false;

const number = (v) => (v == null ? "–" : Number(v.toPrecision(4)).toString().replace("-", "\u2212"));
/** Words of the ticks of an axis, with the decimals that their distance needs: 0.0075 beside 0.008, and never \u22120. */
function ticks(u, splits, axis, space, step) {
  const power = Math.floor(Math.log10(step) + 1e-9), halves = Math.abs(step / 10 ** power - 2.5) < 1e-6;
  const places = Math.min(Math.max(halves - power, 0), 12);
  return splits.map((v) => (v == null ? "" : (Math.round(v / step) * step || 0).toFixed(places).replace("-", "\u2212")));
}

const fits = (line) => !part || !line.part || line.part === part;

const fitting = (chart) => chart.lines.filter(fits);

/** Limits of a chart: lines across it; those beyond its ends are said at its edge. */
function limitsPlugin(limits) {
  const draw = (u) => {
    const { ctx, bbox } = u, dot = devicePixelRatio;
    ctx.save();
    ctx.beginPath();
    ctx.rect(bbox.left, bbox.top, bbox.width, bbox.height);
    ctx.clip();
    ctx.fillStyle = "#b00020";
    ctx.font = `${11 * dot}px sans-serif`;
    ctx.textAlign = "right";
    const right = bbox.left + bbox.width - 4;
    const write = (words, at, edge = right) => {
      ctx.setLineDash([]);
      ctx.lineWidth = 4 * dot;
      ctx.strokeStyle = "#ffffffd8";
      ctx.strokeText(words, edge, at);
      ctx.fillText(words, edge, at);
    };
    for (const { label, value, spans } of limits) {
      const { min, max } = u.scales.y;
      if (value > max || value < min) {
        const end = value > max ? Math.min(...limits.map((l) => l.value).filter((v) => v > max)) : Math.max(...limits.map((l) => l.value).filter((v) => v < min));
        const words = `${label} ${value > max ? "\u2191" : "\u2193"}`, left = bbox.left + 4 + ctx.measureText(words).width;
        if (value === end) write(words, value > max ? bbox.top + 12 * dot : bbox.top + bbox.height - 4, left);
        continue;
      }
      const y = u.valToPos(value, "y", true);
      ctx.setLineDash([4, 6]);
      ctx.lineWidth = dot;
      ctx.strokeStyle = "#b00020";
      ctx.beginPath();
      for (const [from, to] of spans) {
        ctx.moveTo(u.valToPos(from, "x", true), y);
        ctx.lineTo(u.valToPos(to, "x", true), y);
      }
      ctx.stroke();
      const end = u.valToPos(spans.at(-1)[1], "x", true) - 4;
      write(label, y - bbox.top > 20 * dot ? y - 4 : y + 13 * dot, Math.min(right, Math.max(end, bbox.left + ctx.measureText(label).width)));
    }
    ctx.restore();
  };
  return { hooks: { draw: [draw] } };
}

/** One scale for all panels of a chart: that of the lines that are seen. */
function range(chart) {
  return (u) => {
    const from = u.scales.x.min ?? whole[0], to = u.scales.x.max ?? whole[1];
    let low = Infinity, high = -Infinity;
    for (const { y } of fitting(chart)) {
      for (let i = 0; i < y.length; i++) {
        if (y[i] == null || x[i] < from || x[i] > to) continue;
        low = Math.min(low, y[i]);
        high = Math.max(high, y[i]);
      }
    }
    if (low > high) return [0, 1];
    const reach = Math.max(high - low, 1e-6 * Math.abs(high), 1e-6);
    for (const { value } of chart.limits) {
      if (value > low - reach && value < high + reach) [low, high] = [Math.min(low, value), Math.max(high, value)];
    }
    return [low - 0.07 * reach, high + 0.07 * reach];
  };
}

const ends = (y, i) => {
  const both = [y[i - (i % 2)], y[i - (i % 2) + 1]].filter((v) => v != null);
  return both.length ? [Math.min(...both), Math.max(...both)] : null;
};

/** True for a line whose pieces are often as high as a part of its whole range: it is drawn as a band. */
function isRough(y) {
  let most = -Infinity, least = Infinity, inside = 0, count = 0;
  for (let i = 0; i < y.length; i += 2) {
    const both = ends(y, i);
    if (!both) continue;
    [least, most, inside, count] = [Math.min(least, both[0]), Math.max(most, both[1]), inside + both[1] - both[0], count + 1];
  }
  return count > 20 && inside / count > 0.06 * (most - least);
}

/** Gaps of a line, in pixels: where it has no values, and where its contact jumps elsewhere. */
const gaps = (line) => (u, k, from, to, missing) => {
  const at = (i) => u.valToPos(x[i], "x", true);
  const own = (line.breaks ?? []).filter((i) => i >= from && i < to && line.y[i] != null && line.y[i + 1] != null);
  return [...missing, ...own.map((i) => [at(i) - 1, at(i + 1) + 1])].sort((a, b) => a[0] - b[0]);
};

/** Values without neighbours, which a line would not show. */
function alone(line) {
  const apart = new Set(line.breaks), joined = (i) => line.y[i] != null && line.y[i + 1] != null && !apart.has(i);
  return line.y.flatMap((v, i) => (v == null || joined(i - 1) || joined(i) ? [] : [i]));
}

/** The panel of some lines of a chart, in an element; short: their wheelset is named above. */
function panel(chart, lines, element, height, short) {
  const series = [], values = [], bands = [];
  const told = (line) => (u, v, k, i) => {
    const both = i == null ? null : ends(line.y, i);
    if (!both) return "\u2013";
    const same = both[1] - both[0] <= 1e-3 * Math.abs(both[1]);
    return same ? number(both[1]) : `${number(both[0])} to ${number(both[1])}`;
  };
  for (const line of lines) {
    const look = { label: short ? line.label.replace(`${data.parts[line.part]}, `, "") : line.label, stroke: line.colour, value: told(line), gaps: gaps(line) };
    look.points = { show: false, size: 3, width: 0, fill: line.colour, filter: () => alone(line) };
    if (isRough(line.y)) {
      for (const k of [1, 0]) {
        series.push({ ...look, width: 0.5, edge: k === 0 });
        values.push(line.y.map((v, i) => ends(line.y, i)?.[k] ?? null));
      }
      bands.push({ series: [series.length - 1, series.length], fill: `${line.colour}59` });
    } else {
      series.push({ ...look, width: 1.3, dash: line.dash ? line.dash.split(" ").map(Number) : undefined });
      values.push(line.y);
    }
  }
  const options = {
    width: element.clientWidth,
    height,
    padding: [8, 12, 0, 0],
    cursor: { sync: { key: "wrsim" }, y: false, drag: { x: true, y: false } },
    scales: { x: { time: false }, y: { range: range(chart) } },
    axes: [{ size: 28, font: "12px sans-serif", values: ticks }, { size: 56, font: "12px sans-serif", values: ticks }],
    series: [{ label: "place", value: (u, v) => (v == null ? "\u2013" : `${v.toFixed(2)} ${data.unit}`) }, ...series],
    bands,
    plugins: [limitsPlugin(chart.limits)],
    hooks: { setScale: [zoomed], setCursor: [moved], setSeries: [together] },
  };
  const u = new uPlot(options, [x, ...values], element);
  // the lower edge of a band has no entry of its own
  u.root.querySelectorAll(".u-legend .u-series").forEach((row, k) => row.classList.toggle("edge", Boolean(u.series[k].edge)));
  u.root.setAttribute("aria-hidden", "true");
  u.shape = height;
  plots.push(u);
}

function together(u, k, { show }) {
  if (show != null && u.series[k + 1]?.edge && u.series[k + 1].show !== show) u.setSeries(k + 1, { show });
}

/** A chart: one panel, or one for each wheelset on one scale, the leading one first. */
function make(figure) {
  const chart = data.charts.find((c) => c.key === figure.dataset.chart);
  const lines = fitting(chart), own = [...new Set(lines.map((line) => line.part))];
  figure.querySelector(".panels")?.remove();
  const panels = figure.appendChild(document.createElement("div"));
  panels.className = own.length > 1 ? "panels multiples" : "panels";
  const cells = own.map((name) => {
    const cell = panels.appendChild(document.createElement("div"));
    if (own.length > 1) cell.appendChild(document.createElement("h4")).textContent = data.parts[name] ?? name;
    return [cell, lines.filter((line) => line.part === name)];
  });
  for (const [cell, of] of cells) panel(chart, of, cell, own.length > 1 ? 165 : 210, own.length > 1);
}

function zoomed(u, key) {
  if (key !== "x" || quiet || !plots.includes(u)) return;
  const { min, max } = u.scales.x;
  stretch(min, max, u);
}

function stretch(min, max, but) {
  quiet = true;
  for (const u of plots) if (u !== but) u.setScale("x", { min, max });
  // what uPlot does later must not come back here
  requestAnimationFrame(() => (quiet = false));
}

function moved(u) {
  if (u !== plots[0] || u.cursor.idx == null) return;
  const at = x[u.cursor.idx];
  slider.value = at;
  tell(at);
}

function tell(at) {
  shown.textContent = `${at.toFixed(2)} ${data.unit}`;
  slider.setAttribute("aria-valuetext", `${at.toFixed(1)} ${data.unit}`);
}

/** Least and largest value of every curve in the piece of track at s; the cursor of all charts goes there. */
function seek(s) {
  let i = 0;
  for (let k = 0; k < x.length; k += 2) if (x[k] - 0.5 * (x[k + 1] - x[k]) <= s) i = k;
  for (const u of plots) {
    const { min, max } = u.scales.x;
    if (x[i] < min || x[i] > max) u.setScale("x", { min: whole[0], max: whole[1] });
  }
  for (const u of plots) u.setCursor({ left: u.valToPos(x[i], "x"), top: 10 }); // uPlot tells others of the mouse only
  slider.value = s;
  tell(s);
  const found = {};
  for (const chart of data.charts) {
    found[chart.key] = chart.lines.map((line) => {
      const both = [line.y[i], line.y[i + 1]].filter((v) => v != null);
      return { label: line.label, part: line.part, run: line.run, low: Math.min(...both), high: Math.max(...both) };
    });
  }
  return { from: x[i] - 0.5 * (x[i + 1] - x[i]), to: x[i + 1] + 0.5 * (x[i + 1] - x[i]), values: found };
}

function choose(name) {
  part = name;
  const { min, max } = plots[0]?.scales.x ?? { min: whole[0], max: whole[1] };
  for (const u of plots.splice(0)) u.destroy();
  document.querySelectorAll("figure.chart").forEach(make);
  requestAnimationFrame(() => {
    stretch(min, max);
    seek(Number(slider.value));
  });
}

function begin() {
  document.documentElement.classList.add("live");
  document.querySelector(".cursor").hidden = false;
  slider.min = whole[0];
  slider.max = whole[1];
  slider.step = (whole[1] - whole[0]) / 1000;
  slider.addEventListener("input", () => seek(Number(slider.value)));
  document.getElementById("whole").addEventListener("click", () => stretch(...whole));
  const parts = Object.entries(data.parts);
  if (parts.length > 1) {
    const select = document.getElementById("part");
    document.getElementById("part-label").hidden = false;
    select.append(new Option("all", ""), ...parts.map(([name, called]) => new Option(called, name)));
    select.addEventListener("change", () => choose(select.value));
    // several results lie over each other, one wheelset at a time; narrow pages and long trains begin with the worst
    if (several || innerWidth < 600 || parts.length > 8) part = select.value = document.body.dataset.part || parts[0][0];
  }
  document.querySelectorAll("figure.chart").forEach(make);
  let waiting = 0;
  addEventListener("resize", () => {
    cancelAnimationFrame(waiting);
    waiting = requestAnimationFrame(() => {
      for (const u of plots) u.setSize({ width: u.root.parentElement.clientWidth, height: u.shape });
    });
  });
  requestAnimationFrame(() => seek(worst())); // not before uPlot has laid out its charts
}

/** Place of the largest Y/Q, or of the first chart's largest magnitude: where a reader looks first. */
function worst() {
  const chart = data.charts.find((c) => c.key === "Y_over_Q") ?? data.charts[0];
  let best = [-1, whole[0]];
  for (const line of chart.lines) line.y.forEach((v, i) => (best = Math.abs(v) > best[0] ? [Math.abs(v), x[i]] : best));
  return best[1];
}

begin();
window.wrsim = { seek, data, ticks: (values, step) => ticks(null, values, 1, 0, step) };
