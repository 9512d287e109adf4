// Colours of triangles and corners: [r, g, b] in 0..1, as on the screen.

export const GLASS = [0.56, 0.80, 0.75];
export const DEBRIS = [0.66, 0.69, 0.71]; // shards of an unknown one of several shells
const STEEL = [0.58, 0.60, 0.63];
const FLOOR = [0.87, 0.87, 0.86];
const SHARD = 1, STATIC = 2, FROZEN = 3; // `kind` of a triangle of bodies
export const BROKEN = [SHARD, FROZEN]; // of a shell

// From light grey over yellow and red to dark, so that it also works in grey. The same as in
// coupler/sunder_tools/pictures/palette.py.
const STOPS = [[0.88, 0.90, 0.91], [0.95, 0.80, 0.47], [0.89, 0.49, 0.27], [0.69, 0.19, 0.25], [0.29, 0.06, 0.20]];

export function ramp(share) {
  const at = Math.min(Math.max(share, 0), 1) * (STOPS.length - 1);
  const k = Math.min(Math.floor(at), STOPS.length - 2);
  return STOPS[k].map((v, axis) => v + (at - k) * (STOPS[k + 1][axis] - v));
}

const TINT = 0.12; // most that a piece is lighter or darker than its part
const WHOLE = [0.90, 0.92, 0.92];

/** `base`, lighter or darker by the id of a piece, in the shell as among bodies; `base` itself for a whole one. */
export function tint(id, base, whole) {
  const tone = whole.has(id) ? 0 : 2 * (((id + 1) * 0.6180339887498949) % 1) - 1;
  return [1, 0.6, 0.4].map((share, axis) => Math.min(base[axis] * (1 + TINT * share * tone), 1));
}

/** A pale colour by the id of a piece, different for neighbouring ids; grey for a whole one. */
function pastel(id, whole) {
  if (whole.has(id)) return WHOLE;
  const hue = ((id * 0.6180339887498949) % 1) * 2 * Math.PI;
  return [0, 2.0943951, 4.1887902].map((shift) => 0.72 + 0.2 * Math.cos(hue - shift));
}

/** Ids that the parts have in the first frame: they keep the colour of the part. What is left of a part has its id. */
export function wholeIds(frame) {
  const part = frame.arrays["shell.part"] ?? [], least = new Map();
  (frame.arrays["shell.fragment"] ?? []).forEach((id, t) => least.set(part[t], Math.min(id, least.get(part[t]) ?? id)));
  return new Set(least.values());
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
  if (by === "fragment") return (t) => pastel(of("fragment")[t], look.whole);
  return (t) => tint(of("fragment")[t], look.partColour(of("part")[t]), look.whole);
}

export function bodyColour(frame, by, top, look) {
  const kind = frame.arrays["bodies.kind"], body = frame.arrays["bodies.body"], part = frame.arrays["bodies.part"], speed = frame.arrays["bodies.speed"];
  return (t, point) => {
    if (kind[t] === STATIC) return look.bodyColour(body[t], FLOOR);
    if (by === "speed") return ramp(speed[point] / (top || 1));
    if (!BROKEN.includes(kind[t])) return look.bodyColour(body[t], STEEL);
    const base = look.shardColour(body[t], part?.[t] ?? -1);
    if (kind[t] === FROZEN) return by === "fragment" ? WHOLE : base; // what is left, of all its pieces
    return by === "fragment" ? pastel(body[t], look.whole) : tint(body[t], base, look.whole);
  };
}
