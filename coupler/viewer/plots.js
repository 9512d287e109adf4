// Curves over time by uPlot, with a mark at the shown frame.
import uPlot from "uplot";

// Okabe and Ito's palette: colour-blind readers tell its colours apart.
const COLOURS = ["#0072b2", "#d55e00", "#009e73", "#cc79a7", "#e69f00", "#56b4e9", "#000000", "#7f7f7f"];
const FONT = '10px system-ui, "DejaVu Sans", sans-serif', INK = "#5a646e", GRID = "#e3e6e9", MARK = "#9a3412";
const HEIGHT = 150;  // of a plot with its axes [px]
const PREFIXES = { "-12": "p", "-9": "n", "-6": "\u00b5", "-3": "m", 0: "", 3: "k", 6: "M", 9: "G", 12: "T" };

/** A power of 1000 for numbers up to `most`, from pico to tera. */
function thousands(most) {
  if (!(most > 0) || !Number.isFinite(most)) return 0;
  return 3 * Math.min(Math.max(Math.floor(Math.log10(most) / 3 + 1e-9), -4), 4);
}

/** A number as '1.2k', '3.4M', '50m' or '7µ', with at most three digits. */
export function short(value) {
  if (value === 0 || !Number.isFinite(value)) return String(value);
  const power = thousands(Math.abs(value));
  return `${Number((value / 10 ** power).toPrecision(3))}${PREFIXES[power]}`;
}

/** The unit of an axis with numbers up to `most`, and what they are divided by: 0.6 m is shown as 600 mm. */
export function axisUnit(unit, most) {
  if (!/^(m|s|J|N|W|Pa|Hz)(?![a-z])/.test(unit)) return { label: unit, by: 1 };  // a pure number, or kg, rad ...
  const power = thousands(most);
  return { label: PREFIXES[power] + unit, by: 10 ** power };
}

const plain = (value) => Number(value.toPrecision(3)).toString();

export class Plots {
  #root; #plots = []; #times = [0]; #shown = 0; #byFrame = true; #onPick; #hidden = new Set();

  constructor(root, onPick) {
    this.#root = root;
    this.#onPick = onPick;
    new ResizeObserver(() => {
      for (const { chart } of this.#plots) chart.setSize({ width: this.#width(), height: HEIGHT });
    }).observe(root);
  }

  /** Shows `plots`, the reply to /curves. */
  set(plots) {
    for (const { chart } of this.#plots) chart.destroy();
    this.#root.replaceChildren();
    this.#plots = plots.map((plot) => {
      const div = document.createElement("div"), title = document.createElement("h2");
      div.className = "plot";
      title.textContent = plot.title + (plot.unit ? ` [${plot.unit}]` : "");
      div.append(title);
      this.#root.append(div);
      // one row of times for all curves; a curve goes straight on over times that it has not
      const data = uPlot.join(plot.curves.map((curve) => [curve.t, curve.y]));
      const most = Math.max(...plot.curves.flatMap((curve) => curve.y).map((y) => Math.abs(y ?? 0)), 0);
      const entry = { ...plot, data, scaled: axisUnit(plot.unit, most) };
      entry.chart = new uPlot(this.#options(entry), this.#values(entry), div);
      return entry;
    });
  }

  setTimes(times) { this.#times = times.length ? times : [0]; this.#redraw(); }
  setByFrame(on) { this.#byFrame = on; this.#redraw(); }
  setFrame(k) { this.#shown = k; for (const { chart } of this.#plots) chart.redraw(false, false); }

  #width() { return Math.max(this.#root.clientWidth, 120); }

  #redraw() { for (const entry of this.#plots) entry.chart.setData(this.#values(entry)); }

  /** Data of a chart: places across it in 0..1, then the curves in the unit of the axis. */
  #values({ data, scaled }) {
    return [data[0].map((t) => this.#share(t)),
            ...data.slice(1).map((curve) => curve.map((y) => (y == null ? y : y / scaled.by)))];
  }

  #options({ title, unit, curves, scaled }) {
    const time = axisUnit("s", this.#times[this.#times.length - 1]);
    const axis = { font: FONT, labelFont: FONT, stroke: INK, labelGap: 0, labelSize: 14, ticks: { show: false },
                   grid: { stroke: GRID, width: 1 } };
    const idOf = (curve) => `${title} ${unit} ${curve.name}`;
    return {
      width: this.#width(), height: HEIGHT,
      scales: {
        x: { time: false, range: () => [0, 1] },
        y: { range: (_, low, high) => {  // it includes zero
          const [a, b] = [Math.min(low ?? 0, 0), Math.max(high ?? 0, 0)];
          return a === b ? [a, a + 1] : [a, b];
        } },
      },
      axes: [
        { ...axis, size: 18, label: `time [${time.label}]`, splits: () => [0, 0.5, 1],
          values: (_, splits) => splits.map((share) => plain(this.#timeAt(share) / time.by)) },
        { ...axis, size: 40, label: scaled.label ? `[${scaled.label}]` : undefined,
          values: (_, splits) => splits.map(plain) },
      ],
      series: [
        { label: "time", value: (_, share) => (share == null ? "" : `${plain(this.#timeAt(share) / time.by)} ${time.label}`) },
        ...curves.map((curve, k) => ({
          label: curve.name.replaceAll("_", " "), stroke: COLOURS[k % COLOURS.length], width: 1.2,
          dash: k < COLOURS.length ? undefined : [4, 3], points: { show: false }, show: !this.#hidden.has(idOf(curve)),
          value: (_, y) => (y == null ? "" : `${plain(y)} ${scaled.label}`),
        })),
      ],
      cursor: { drag: { x: false, y: false }, points: { size: 5 } },
      hooks: {
        draw: [(chart) => this.#mark(chart)],
        setSeries: [(_, k, change) => {
          if (k && "show" in change) this.#hidden[change.show ? "delete" : "add"](idOf(curves[k - 1]));
        }],
        ready: [(chart) => chart.over.addEventListener("pointerdown", (event) => this.#pick(chart, event))],
      },
    };
  }

  #mark(chart) {
    const here = this.#times[Math.min(this.#shown, this.#times.length - 1)];
    const x = chart.valToPos(this.#share(here), "x", true), ink = chart.ctx;
    ink.save();
    ink.strokeStyle = MARK;
    ink.setLineDash([]);
    ink.beginPath();
    ink.moveTo(x, chart.bbox.top);
    ink.lineTo(x, chart.bbox.top + chart.bbox.height);
    ink.stroke();
    ink.restore();
  }

  #pick(chart, event) {
    const share = Math.min(Math.max(chart.posToVal(event.offsetX, "x"), 0), 1);
    let best = 0;
    this.#times.forEach((t, k) => {
      if (Math.abs(this.#share(t) - share) < Math.abs(this.#share(this.#times[best]) - share)) best = k;
    });
    this.#onPick(best);
  }

  /** Position in 0..1 across the plot: by time, or by the number of the frame, linear between two frames. */
  #share(t) {
    const times = this.#times, last = times.length - 1;
    if (!this.#byFrame || last < 1) return (t - times[0]) / (times[last] - times[0] || 1);
    let low = 0, high = last;
    while (high - low > 1) { const mid = (low + high) >> 1; if (times[mid] <= t) low = mid; else high = mid; }
    return (low + (t - times[low]) / (times[high] - times[low] || 1)) / last;
  }

  /** The time at such a position. */
  #timeAt(share) {
    const times = this.#times, last = times.length - 1;
    if (!this.#byFrame || last < 1) return times[0] + share * (times[last] - times[0]);
    const k = Math.min(Math.floor(share * last), last - 1);
    return times[k] + (share * last - k) * (times[k + 1] - times[k]);
  }
}
