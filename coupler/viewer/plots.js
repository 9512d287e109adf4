// Draws curves over time on small canvases, with a mark at the shown frame.

const COLOURS = ["#2f6f8f", "#c8553d", "#6a8d4e", "#8a5a9e", "#c79a2b", "#4d4d4d", "#5fa8a0", "#b0486f", "#7c7c3a", "#3f5bb0"];
const MARGIN = { left: 46, right: 6, top: 6, bottom: 16 };

/** A number as '1.2k', '3.4M', '50m' or '7µ', with at most three digits. */
export function short(value) {
  if (value === 0 || !Number.isFinite(value)) return String(value);
  const power = Math.min(Math.max(Math.floor(Math.log10(Math.abs(value)) / 3 + 1e-9), -4), 4);
  return `${Number((value / 1000 ** power).toPrecision(3))}${["p", "n", "\u00b5", "m", "", "k", "M", "G", "T"][power + 4]}`;
}

export class Plots {
  #root; #plots = []; #times = [0]; #shown = 0; #byFrame = true; #onPick; #hidden = new Set();

  constructor(root, onPick) {
    this.#root = root;
    this.#onPick = onPick;
    new ResizeObserver(() => this.draw()).observe(root);
  }

  /** Shows `plots`, the reply to /curves. */
  set(plots) {
    this.#root.replaceChildren();
    this.#plots = plots.map((plot) => {
      const div = document.createElement("div"), title = document.createElement("h2");
      const canvas = document.createElement("canvas"), keys = document.createElement("div");
      div.className = "plot";
      keys.className = "keys";
      title.textContent = plot.title + (plot.unit ? ` [${plot.unit}]` : "");
      plot.curves.forEach((curve, k) => keys.append(this.#key(plot, curve, k)));
      canvas.addEventListener("pointerdown", (event) => this.#pick(canvas, event));
      div.append(title, canvas, keys);
      this.#root.append(div);
      return { ...plot, canvas };
    });
    this.draw();
  }

  setTimes(times) { this.#times = times.length ? times : [0]; this.draw(); }
  setByFrame(on) { this.#byFrame = on; this.draw(); }
  setFrame(k) { this.#shown = k; this.draw(); }

  #key(plot, curve, k) {
    const key = document.createElement("span"), swatch = document.createElement("span");
    const id = `${plot.title} ${plot.unit} ${curve.name}`;
    key.className = this.#hidden.has(id) ? "key off" : "key";
    swatch.className = "swatch";
    swatch.style.background = COLOURS[k % COLOURS.length];
    key.append(swatch, curve.name.replaceAll("_", " "));
    key.addEventListener("click", () => {
      if (!this.#hidden.delete(id)) this.#hidden.add(id);
      key.classList.toggle("off", this.#hidden.has(id));
      this.draw();
    });
    return key;
  }

  /** Position in 0..1 across the plot: by time, or by the number of the frame, linear between two frames. */
  #share(t) {
    const times = this.#times, last = times.length - 1;
    if (!this.#byFrame || last < 1) return (t - times[0]) / (times[last] - times[0] || 1);
    let low = 0, high = last;
    while (high - low > 1) { const mid = (low + high) >> 1; if (times[mid] <= t) low = mid; else high = mid; }
    return (low + (t - times[low]) / (times[high] - times[low] || 1)) / last;
  }

  #pick(canvas, event) {
    const width = canvas.clientWidth - MARGIN.left - MARGIN.right;
    const share = Math.min(Math.max((event.offsetX - MARGIN.left) / width, 0), 1);
    let best = 0;
    this.#times.forEach((t, k) => {
      if (Math.abs(this.#share(t) - share) < Math.abs(this.#share(this.#times[best]) - share)) best = k;
    });
    this.#onPick(best);
  }

  draw() { for (const plot of this.#plots) this.#drawOne(plot); }

  #drawOne({ title, unit, curves, canvas }) {
    const width = canvas.clientWidth, height = canvas.clientHeight, ratio = window.devicePixelRatio || 1;
    if (!width) return;
    canvas.width = Math.round(width * ratio);
    canvas.height = Math.round(height * ratio);
    const ink = canvas.getContext("2d");
    ink.scale(ratio, ratio);
    const seen = curves.filter((curve) => !this.#hidden.has(`${title} ${unit} ${curve.name}`));
    let low = 0, high = 0; // the range includes zero
    for (const curve of seen) for (const y of curve.y) if (y !== null) { low = Math.min(low, y); high = Math.max(high, y); }
    if (low === high) high = low + 1;
    const inner = width - MARGIN.left - MARGIN.right, tall = height - MARGIN.top - MARGIN.bottom;
    const x = (t) => MARGIN.left + inner * this.#share(t), y = (v) => MARGIN.top + tall * (high - v) / (high - low);
    ink.font = "10px system-ui, sans-serif";
    ink.fillStyle = "#5a646e";
    ink.textAlign = "right";
    ink.textBaseline = "middle";
    ink.strokeStyle = "#e3e6e9";
    for (const v of new Set([low, high, 0])) {
      if (v === 0 && Math.min(Math.abs(y(0) - y(low)), Math.abs(y(0) - y(high))) < 10 && low !== 0 && high !== 0) continue;
      ink.fillText(short(v), MARGIN.left - 4, y(v));
      ink.beginPath(); ink.moveTo(MARGIN.left, y(v)); ink.lineTo(width - MARGIN.right, y(v)); ink.stroke();
    }
    ink.textBaseline = "top";
    const last = this.#times.length - 1;
    for (const [k, align] of [[0, "left"], [last >> 1, "center"], [last, "right"]]) {
      ink.textAlign = align;
      ink.fillText(`${short(this.#times[k])}s`, x(this.#times[k]), height - MARGIN.bottom + 3);
    }
    ink.save();
    ink.beginPath(); ink.rect(MARGIN.left, 0, inner, height - MARGIN.bottom + 1); ink.clip();
    ink.lineWidth = 1.2;
    for (const curve of seen) {
      ink.strokeStyle = COLOURS[curves.indexOf(curve) % COLOURS.length];
      ink.beginPath();
      let pen = false;
      curve.t.forEach((t, k) => {
        const v = curve.y[k];
        if (v !== null) { if (pen) ink.lineTo(x(t), y(v)); else ink.moveTo(x(t), y(v)); }
        pen = v !== null;
      });
      ink.stroke();
    }
    const here = this.#times[Math.min(this.#shown, last)];
    ink.strokeStyle = "#9a3412";
    ink.beginPath(); ink.moveTo(x(here), 0); ink.lineTo(x(here), height - MARGIN.bottom); ink.stroke();
    ink.restore();
  }
}
