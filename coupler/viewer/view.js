// The page: gets state, frames and curves from the server, and plays them.
import { BROKEN, DEBRIS, GLASS, highest, ramp, wholeIds } from "./colours.js";
import { FrameStore } from "./frame.js";
import { Plots, short } from "./plots.js";
import { Picture } from "./scene.js";

const AHEAD = 3;             // number of frames fetched in advance
const ASK_RUNNING_MS = 2000; // interval of requests for new frames of a run in progress
const ASK_ENDED_MS = 6000;   // the same after its end: a run may be resumed or replaced
const CLICK_PX = 4;          // most that a click moves
const UNITS = { speed: "m/s", damage: "", c_his: "" };

const $ = (id) => document.getElementById(id);
const store = new FrameStore();
const plots = new Plots($("plots"), (k) => { pause(); go(k); });
let picture = null;
let state = { frames: [], shells: [], palette: [], part_of: {}, status: "" };
let shown = -1, wanted = 0, timer = null, busy = false, current = null;
const tops = {}; // highest value so far, by coloured quantity

// look of the parts, by their materials; a single shell of which nothing is known is drawn as glass, as in the other pictures
const look = {
  whole: new Set(), // ids of the parts before they broke
  partColour: (n) => state.shells[n]?.colour ?? (look.isGlass(n) || !look.several() ? GLASS : state.palette[n % state.palette.length]),
  bodyColour: (body, other) => (state.body_colours?.[body - 1]?.length ? state.body_colours[body - 1] : other),
  isGlass: (n) => state.shells[n]?.glass ?? state.shells.length === 0,
  several: () => state.shells.length > 1 || state.shells.some((shell) => !shell.glass) || new Set(current?.arrays["shell.part"] ?? []).size > 1,
  shardPart: (body, shell) => (shell >= 0 ? shell : state.part_of[body]), // not known for every shard of earlier versions
  isGlassShard: (body, shell) => (look.several() ? look.shardPart(body, shell) !== undefined && look.isGlass(look.shardPart(body, shell))
                                                 : look.isGlass(0)),
  shardColour: (body, shell) => {
    const part = look.shardPart(body, shell);
    return !look.several() ? look.partColour(0) : part === undefined ? DEBRIS : look.partColour(part);
  },
  get glassOpacity() { return look.several() ? 0.45 : 0.75; },
};

function say(text) { $("message").textContent = text; }

function timeText(s) {
  if (s === 0) return "0 s";
  if (s < 0.9995e-3) return `${Number((s * 1e6).toPrecision(4))} \u00b5s`;
  return s < 0.9995 ? `${Number((s * 1e3).toPrecision(4))} ms` : `${Number(s.toPrecision(4))} s`;
}

async function ask(path) {
  const answer = await fetch(path);
  if (!answer.ok) throw new Error(await answer.text());
  return answer.json();
}

async function refresh() {
  let wait = ASK_ENDED_MS;
  try {
    const news = await ask("state");
    const changed = JSON.stringify(news) !== JSON.stringify(state);
    const replaced = state.frames.length > 0 && news.frames[0]?.version !== state.frames[0].version;
    const atEnd = shown >= 0 && shown === state.frames.length - 1 && state.status === "running";
    const before = state.frames[shown]?.version;
    state = news;
    if (changed) {
      describe();
      plots.setTimes(state.frames.map((f) => f.time_s));
      plots.set((await ask("curves")).plots);
      if (replaced) { for (const key of Object.keys(tops)) delete tops[key]; wanted = 0; }
      if (atEnd && !replaced) wanted = state.frames.length - 1; // follow the newest frame
      if (state.frames.length && (shown < 0 || replaced || wanted !== shown || state.frames[shown]?.version !== before))
        await go(Math.min(wanted, state.frames.length - 1));
      else if (shown >= 0) draw(); // update counts and names
    }
    if (!state.frames.length)
      say(state.status === "running" ? "no frame yet" : "this run has no frames");
    if (state.status === "running") wait = ASK_RUNNING_MS;
  } catch (error) {
    say(`${error.message}\n(asking again)`);
  }
  setTimeout(refresh, wait);
}

function describe() {
  $("name").textContent = state.name;
  $("status").textContent = state.status + (state.error?.message ? `: ${state.error.message}` : "");
  $("slider").max = Math.max(state.frames.length - 1, 0);
  const counts = Object.entries(state.counts ?? {}).map(([key, value]) => `${key.replaceAll("_", " ")} ${value}`);
  $("counts").textContent = counts.join(" \u00b7 ");
  document.title = `${state.name} \u2013 Sunder`;
}

function options() {
  const by = $("colour").value;
  return { by, top: tops[by] ?? 0, look, lines: $("lines").checked, bodies: $("bodies").checked, fixed: $("static").checked,
           mesh: $("mesh").checked };
}

/** Shows frame k. Of several calls while a frame is fetched only the last one counts. */
async function go(k) {
  wanted = k;
  if (busy) return;
  busy = true;
  try {
    do {
      k = wanted;
      const frame = await store.get(k, state.frames[k].version);
      const first = current === null;
      current = frame;
      shown = k;
      if (k === 0) look.whole = wholeIds(frame);
      draw();
      if (first) picture.fit(frame);
      say("");
    } while (wanted !== k);
    const ahead = (n) => (k + n < state.frames.length && timer !== null ? store.get(k + n, state.frames[k + n].version) : null);
    for (let n = 1; n <= AHEAD; n++) ahead(n)?.catch(() => {});
  } catch (error) {
    say(error.message);
    pause();
  } finally {
    busy = false;
  }
}

function draw() {
  if (!current) return;
  const by = $("colour").value;
  tops[by] = Math.max(tops[by] ?? 0, highest(current, by));
  picture.show(current, options());
  $("slider").value = shown;
  $("time").textContent = `${timeText(current.time_s)}  (${shown + 1}/${state.frames.length})`;
  document.body.dataset.frame = shown; // read by tests of the page
  plots.setFrame(shown);
  legend(by);
}

function legend(by) {
  const rows = [];
  const row = (colour, text) => {
    const span = document.createElement("span"), swatch = document.createElement("span");
    span.className = "row";
    swatch.className = "swatch";
    swatch.style.background = `rgb(${colour.map((v) => Math.round(255 * v)).join(" ")})`;
    span.append(swatch, text);
    rows.push(span);
  };
  if (by === "part") {
    const parts = [...new Set(current.arrays["shell.part"] ?? [])].sort((a, b) => a - b);
    for (const n of parts) row(look.partColour(n), (state.shells[n]?.name ?? `shell ${n}`).replaceAll("_", " "));
  } else if (by in UNITS) {
    const canvas = document.createElement("canvas"), scale = document.createElement("div");
    canvas.width = 180;
    canvas.height = 1;
    const ink = canvas.getContext("2d");
    for (let x = 0; x < 180; x++) {
      ink.fillStyle = `rgb(${ramp(x / 179).map((v) => Math.round(255 * v)).join(" ")})`;
      ink.fillRect(x, 0, 1, 1);
    }
    scale.className = "scale";
    for (const text of ["0", `${short(tops[by])}${UNITS[by] ? ` ${UNITS[by]}` : ""}`]) {
      const span = document.createElement("span");
      span.textContent = text;
      scale.append(span);
    }
    rows.push(canvas, scale);
  }
  $("legend").replaceChildren(...rows);
}

/** Says which piece or body is at a place of the screen. */
function point(event) {
  const hit = current && picture.pick(event.clientX, event.clientY);
  const id = hit && current.arrays[hit.shell ? "shell.fragment" : "bodies.body"][hit.triangle];
  const piece = hit && (hit.shell || BROKEN.includes(current.arrays["bodies.kind"][hit.triangle]));
  $("picked").textContent = hit ? `${piece ? "piece" : "body"} ${id}` : "";
}

function pause() {
  clearInterval(timer);
  timer = null;
  $("play").textContent = "Play";
}

function play() {
  if (!state.frames.length) return;
  if (shown >= state.frames.length - 1) go(0);
  $("play").textContent = "Pause";
  timer = setInterval(() => {
    if (busy) return; // play more slowly instead of skipping frames
    if (shown < state.frames.length - 1) go(shown + 1);
    else if (state.status !== "running") pause();
  }, 1000 / Number($("rate").value));
}

function step(by) {
  pause();
  const k = Math.min(Math.max(shown + by, 0), state.frames.length - 1);
  if (k >= 0) go(k);
}

function listen() {
  let down = null; // where the pointer went down: a turn of the camera is no click
  $("picture").addEventListener("pointerdown", (event) => { down = event; });
  $("picture").addEventListener("pointerup", (event) => {
    if (down && Math.hypot(event.clientX - down.clientX, event.clientY - down.clientY) < CLICK_PX) point(event);
    down = null;
  });
  $("play").addEventListener("click", () => (timer === null ? play() : pause()));
  $("back").addEventListener("click", () => step(-1));
  $("forth").addEventListener("click", () => step(1));
  $("slider").addEventListener("input", () => { pause(); if (state.frames.length) go(Number($("slider").value)); });
  $("rate").addEventListener("change", () => { if (timer !== null) { pause(); play(); } });
  $("fit").addEventListener("click", () => current && picture.fit(current));
  $("by_frame").addEventListener("change", () => plots.setByFrame($("by_frame").checked));
  for (const id of ["colour", "lines", "bodies", "static", "mesh"]) $(id).addEventListener("change", draw);
  document.addEventListener("keydown", (event) => {
    if (["INPUT", "SELECT", "BUTTON"].includes(event.target.tagName)) return;
    const keys = { " ": () => (timer === null ? play() : pause()), ArrowLeft: () => step(-1), ArrowRight: () => step(1),
                   Home: () => step(-Infinity), End: () => step(Infinity), f: () => current && picture.fit(current) };
    if (!keys[event.key]) return;
    event.preventDefault();
    keys[event.key]();
  });
}

try {
  picture = new Picture($("picture"));
  listen();
  refresh();
} catch (error) {
  say(`This browser shows no WebGL: ${error.message}`);
}
