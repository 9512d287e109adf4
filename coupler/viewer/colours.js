// Colours of triangles and corners: [r, g, b] in 0..1, as on the screen.

export const GLASS = [0.56, 0.80, 0.75];
export const DEBRIS = [0.66, 0.69, 0.71]; // shards of an unknown one of several shells
const STEEL = [0.58, 0.60, 0.63];
const FLOOR = [0.87, 0.87, 0.86];
const SHARD = 1, STATIC = 2, FROZEN = 3; // `kind` of a triangle of bodies

// From light grey over yellow and red to dark, so that it also works in grey. The same as in
// coupler/sunder_tools/pictures/palette.py.
const STOPS = [[0.88, 0.90, 0.91], [0.95, 0.80, 0.47], [0.89, 0.49, 0.27], [0.69, 0.19, 0.25], [0.29, 0.06, 0.20]];

export function ramp(share) {
  const at = Math.min(Math.max(share, 0), 1) * (STOPS.length - 1);
  const k = Math.min(Math.floor(at), STOPS.length - 2);
  return STOPS[k].map((v, axis) => v + (at - k) * (STOPS[k + 1][axis] - v));
}

/** `base`, lighter or darker by the id; id 0 gives `base`. */
function varied(id, base, amount) {
  const tone = id === 0 ? 0 : 2 * ((id * 0.6180339887498949) % 1) - 1;
  return [1, 0.6, 0.4].map((share, axis) => Math.min(base[axis] * (1 + amount * share * tone), 1));
}

/** A pale colour by the id, different for neighbouring ids. */
function pastel(id) {
  const hue = ((id * 0.6180339887498949) % 1) * 2 * Math.PI;
  return [0, 2.0943951, 4.1887902].map((shift) => 0.72 + 0.2 * Math.cos(hue - shift));
}

function largest(values) {
  const count = new Map();
  for (const v of values) count.set(v, (count.get(v) ?? 0) + 1);
  let best = [undefined, 0];
  for (const entry of count) if (entry[1] > best[1]) best = entry;
  return best[0];
}

/** Highest value of the coloured quantity in this frame. The legend ends at the highest value of all frames so far. */
export function highest(frame, by) {
  const names = by === "speed" ? ["shell.speed", "bodies.speed"] : by === "c_his" ? ["shell.c_his"] : [];
  let top = by === "damage" ? 1 : 0;
  for (const name of names) for (const v of frame.arrays[name] ?? []) if (v > top) top = v;
  return top;
}

/** Returns a function from (triangle, point of a corner) to the shell's colour there. */
export function shellColour(frame, by, top, look) {
  const of = (name) => frame.arrays[`shell.${name}`];
  if (by === "speed") return (_, point) => ramp(of("speed")[point] / (top || 1));
  if (by === "damage" || by === "c_his") return (t) => ramp(of(by)[t] / (top || 1));
  const most = largest(of("fragment"));
  if (by === "fragment") return (t) => (of("fragment")[t] === most ? [0.90, 0.92, 0.92] : pastel(of("fragment")[t]));
  return (t) => varied(of("fragment")[t] === most ? 0 : of("fragment")[t] + 1, look.partColour(of("part")[t]), 0.1);
}

export function bodyColour(frame, by, top, look) {
  const kind = frame.arrays["bodies.kind"], body = frame.arrays["bodies.body"], part = frame.arrays["bodies.part"], speed = frame.arrays["bodies.speed"];
  return (t, point) => {
    if (kind[t] === STATIC) return look.bodyColour(body[t], FLOOR);
    if (by === "speed") return ramp(speed[point] / (top || 1));
    const broken = kind[t] === SHARD || kind[t] === FROZEN;
    if (!broken) return look.bodyColour(body[t], STEEL);
    if (by === "fragment") return kind[t] === FROZEN ? [0.90, 0.92, 0.92] : pastel(body[t]);
    return varied(kind[t] === FROZEN ? 0 : body[t] + 1, look.shardColour(body[t], part?.[t] ?? -1), 0.14);
  };
}
