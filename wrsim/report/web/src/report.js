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
const fits = (line) => !part || !line.part || line.part === part;

function limitsPlugin(limits) {
  const draw = (u) => {
    const { ctx, bbox } = u;
    ctx.save();
    ctx.beginPath();
    ctx.rect(bbox.left, bbox.top, bbox.width, bbox.height);
    ctx.clip();
    ctx.strokeStyle = ctx.fillStyle = "#b00020";
    ctx.setLineDash([4, 6]);
    ctx.font = `${11 * devicePixelRatio}px sans-serif`;
    ctx.textAlign = "right";
    for (const limit of limits) {
      const y = u.valToPos(limit.value, "y", true);
      ctx.beginPath();
      ctx.moveTo(bbox.left, y);
      ctx.lineTo(bbox.left + bbox.width, y);
      ctx.stroke();
      const above = y - bbox.top > 20 * devicePixelRatio;
      ctx.fillText(limit.label, bbox.left + bbox.width - 4, above ? y - 4 : y + 13 * devicePixelRatio);
    }
    ctx.restore();
  };
  return { hooks: { draw: [draw] } };
}

function range(chart) {
  return (u, low, high) => {
    if (low == null) return [0, 1];
    const reach = Math.max(high - low, 1e-6 * Math.abs(high), 1e-6);
    for (const limit of chart.limits) {
      if (limit.value > low - reach && limit.value < high + reach) {
        low = Math.min(low, limit.value);
        high = Math.max(high, limit.value);
      }
    }
    return [low - 0.07 * reach, high + 0.07 * reach];
  };
}

function make(figure) {
  const chart = data.charts.find((c) => c.key === figure.dataset.chart);
  const size = { width: figure.clientWidth, height: 210 };
  const series = chart.lines.map((line) => ({
    label: line.label,
    stroke: line.colour,
    width: 1.3,
    dash: line.dash ? line.dash.split(" ").map(Number) : undefined,
    points: { show: false },
    show: fits(line),
    value: (u, v) => number(v),
  }));
  const options = {
    ...size,
    padding: [8, 12, 0, 0],
    cursor: { sync: { key: "wrsim" }, y: false, drag: { x: true, y: false } },
    scales: { x: { time: false }, y: { range: range(chart) } },
    axes: [{ size: 28, font: "12px sans-serif" }, { size: 56, font: "12px sans-serif" }],
    series: [{ label: data.label, value: (u, v) => (v == null ? "–" : `${v.toFixed(2)} ${data.unit}`) }, ...series],
    plugins: [limitsPlugin(chart.limits)],
    hooks: { setScale: [zoomed], setCursor: [moved] },
  };
  const u = new uPlot(options, [x, ...chart.lines.map((line) => line.y)], figure);
  u.chart = chart;
  u.root.setAttribute("aria-hidden", "true");
  plots.push(u);
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
  for (const u of plots) {
    u.batch(() => u.chart.lines.forEach((line, k) => u.setSeries(k + 1, { show: fits(line) })));
    // entries of other wheelsets leave the legend altogether
    u.root.querySelectorAll(".u-legend .u-series").forEach((row, k) => {
      row.style.display = k === 0 || fits(u.chart.lines[k - 1]) ? "" : "none";
    });
  }
}

function begin() {
  document.documentElement.classList.add("live");
  document.querySelector(".cursor").hidden = false;
  slider.min = whole[0];
  slider.max = whole[1];
  slider.step = (whole[1] - whole[0]) / 1000;
  document.querySelectorAll("figure.chart").forEach(make);
  slider.addEventListener("input", () => seek(Number(slider.value)));
  document.getElementById("whole").addEventListener("click", () => stretch(...whole));
  const parts = Object.entries(data.parts);
  if (parts.length > 1) {
    const select = document.getElementById("part");
    document.getElementById("part-label").hidden = false;
    select.append(new Option("all", ""), ...parts.map(([name, called]) => new Option(called, name)));
    select.addEventListener("change", () => choose(select.value));
    if (several) {
      const first = document.body.dataset.part || parts[0][0];
      select.value = first;
      choose(first);
    }
  }
  let waiting = 0;
  addEventListener("resize", () => {
    cancelAnimationFrame(waiting);
    waiting = requestAnimationFrame(() => {
      for (const u of plots) u.setSize({ width: u.root.parentElement.clientWidth, height: 210 });
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
window.wrsim = { seek, data };
