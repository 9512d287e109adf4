// Finds the contacts that bodies may have in a window.
import * as m from '../jolt/algebra.mjs';
import { cornersOver, kFarther } from './mujoco_corners.mjs';
import { kLength } from './mujoco_model.mjs';

/** Beyond the way of a window, bodies this close are found as well. */
const kSkin = 5e-5; // [m]
/** Pairs of hulls that come less far in a window are slow: their faces are those at its end. */
const kSlow = 5e-4; // [m]
/** Contacts of two bodies belong to one plane where their normals are the same in such steps; so many directions in it have
 * an outermost point each. */
const kNormalSteps = 32, kMostOfPlane = 16;
/** The faces that MuJoCo finds at the end of a window count where their normal is within 45 degrees of that at its begin. */
const kSameSide = 0.7;

/** A contact: `normal` from the first body to the second, points on both surfaces, `share`: where between them the bodies
 * touch as they slide. A corner or a ball has its point, and the face takes it from there. */
function meeting(first, second, normal, firstPoint, secondPoint, share) {
  const local = (held, point) => {
    const offset = m.subtract(point, held.at.position);
    return held.body.shape.sphere ? offset : m.rotate(m.conjugate(held.at.orientation), offset);
  };
  return { first, second, normal, firstPoint: local(first, firstPoint), secondPoint: local(second, secondPoint), share };
}

/** Where a point of meeting() is now, relative to the body's centre [m]. Points of balls do not turn with them. */
export const armOf = (held, local) => (held.body.shape.sphere ? local : m.rotate(held.at.orientation, local));

/** Corners of a body [m], each once, or the centre of a sphere. */
export function corners({ shape: { sphere, box, parts } }) {
  if (sphere) return [[0, 0, 0]];
  if (box)
    return [-1, 1].flatMap((x) => [-1, 1].flatMap((y) => [-1, 1].map((z) => [x * box[0], y * box[1], z * box[2]])));
  return parts ? [...new Map(parts.flat().map((corner) => [corner.join(' '), corner])).values()] : [];
}

/** Contacts that MuJoCo finds at the poses that Model.place() has set. `ways`: by moving body, how far it comes in the
 * window [m]; 0 for bodies that overlap alone, with all corners of touching faces. */
function detect(model, ways) {
  const { mujoco, model: mj, data, layout, contacts: base } = model;
  const margins = mj.geom_margin, wide = mj.body_margin, bodies = mj.geom_bodyid;
  const margin = model.bodies.map((held) => (held && held.slot >= 0 && ways ? kLength * (ways[held.slot] + kSkin) : 0));
  wide.set(margin);
  for (let g = 0; g < bodies.length; ++g) margins[g] = margin[bodies[g]];
  const single = mujoco.mjtDisableBit.mjDSBL_MULTICCD.value;
  model.option.disableflags = ways ? single : 0;
  model.run(() => {
    mujoco.mj_kinematics(mj, data);
    mujoco.mj_collision(mj, data);
  });
  const { doubles, integers } = model.memory(), found = [];
  for (let k = 0; k < data.ncon; ++k) {
    const begin = base + k * layout.size, real = (name) => (begin + layout[name]) / 8;
    const dist = doubles[real('dist')] / kLength;
    const point = Array.from(doubles.subarray(real('pos'), real('pos') + 3), (c) => c / kLength);
    const normal = Array.from(doubles.subarray(real('frame'), real('frame') + 3));
    const geoms = integers.subarray((begin + layout.geom) / 4, (begin + layout.geom) / 4 + 2);
    const first = model.owner[geoms[0]], second = model.owner[geoms[1]];
    const half = m.scale(0.5 * dist, normal), surfaces = [m.subtract(point, half), m.add(point, half)];
    const ball = (held) => (held.body.shape.sphere ? 1 : 0);
    found.push({
      ...meeting(first, second, normal, ...surfaces, 0.5 + 0.5 * (ball(second) - ball(first))),
      surfaces, geoms: [geoms[0], geoms[1]], pair: geoms[0] * bodies.length + geoms[1],
    });
  }
  return found;
}

/** True for pairs of hulls, or of a hull and a box. Pairs of boxes have all their points from MuJoCo, balls one. */
const hulls = ({ first, second }) => ![first, second].some(({ body: { shape } }) => shape.sphere) &&
  [first, second].some(({ body: { shape } }) => shape.parts);

/** Contacts of convex bodies. Those at the begin of the window see fast bodies come, with one point for a pair of hulls and
 * the corners around it. Where a slow pair overlaps at the end, all corners of its touching faces take their place. */
function convex(model, ways, begin, end) {
  model.place(begin);
  const early = detect(model, ways);
  if (early.length === 0) return early;
  const wayOf = ({ first, second }) => [first, second].reduce((sum, held) => sum + (held.slot < 0 ? 0 : ways[held.slot]), 0);
  const slow = new Map(); // normals of pairs
  for (const one of early) if (hulls(one) && wayOf(one) < kSlow) slow.set(one.pair, one.normal);
  let better = [];
  if (slow.size) {
    model.place(end);
    const sameSide = ({ pair, normal }) => slow.has(pair) && m.dot(normal, slow.get(pair)) > kSameSide;
    better = detect(model, null).filter(sameSide);
    model.place(begin);
  }
  const replaced = new Set(better.map(({ pair }) => pair));
  const kept = early.filter(({ pair }) => !replaced.has(pair));
  return [...kept, ...kept.flatMap((one) => around(model, one, wayOf(one) + kSkin)), ...better];
}

/** Corners of both hulls of a pair that come down on the other one. */
function around(model, pair, way) {
  if (!hulls(pair)) return [];
  const { first, second, normal, geoms: [a, b], surfaces } = pair;
  const down = m.scale(-1, normal);
  return [
    ...cornersOver(model, b, a, normal, surfaces[0], way).map(({ corner, foot }) => meeting(first, second, normal, foot, corner, 1)),
    ...cornersOver(model, a, b, down, surfaces[1], way).map(({ corner, foot }) => meeting(first, second, normal, corner, foot, 0)),
  ];
}

/** Contacts with half spaces: corners that can come down to the plane. MuJoCo's own finder gives three at most. */
function planes(model, ways) {
  const found = [];
  for (const plane of model.bodies) {
    if (!plane?.body.shape.half_space) continue;
    const { position, orientation } = plane.motion, up = m.rotate(orientation, [0, 0, 1]);
    model.moving.forEach((held, k) => {
      const way = ways[k] + kSkin, above = m.dot(up, m.subtract(held.at.position, position));
      if (above > held.reach + way) return;
      const radius = held.body.shape.sphere ?? 0;
      const level = m.rotate(m.conjugate(held.at.orientation), up), near = above - radius;
      const low = held.corners.filter((corner) => near + m.dot(level, corner) <= kFarther * way);
      if (!low.some((corner) => near + m.dot(level, corner) <= way)) return;
      for (const corner of low) {
        const point = m.subtract(m.add(held.at.position, m.rotate(held.at.orientation, corner)), m.scale(radius, up));
        const height = m.dot(up, m.subtract(point, position));
        found.push(meeting(plane, held, up, m.subtract(point, m.scale(height, up)), point, 1));
      }
    });
  }
  return found;
}

/** The contacts without those in the middle of a plane along which two bodies of many parts touch. */
function outermost(meetings) {
  const groups = new Map();
  for (const one of meetings) {
    const key = [one.first.id, one.second.id, ...one.normal.map((c) => Math.round(c * kNormalSteps))].join(' ');
    if (!groups.has(key)) groups.set(key, []);
    groups.get(key).push(one);
  }
  return [...groups.values()].flatMap((group) => {
    if (group.length <= kMostOfPlane) return group;
    const { second, normal } = group[0], [u, v] = m.tangents(normal);
    const points = group.map((one) => m.add(second.at.position, armOf(second, one.secondPoint)));
    const gaps = group.map((one, k) =>
      m.dot(one.normal, m.subtract(points[k], m.add(one.first.at.position, armOf(one.first, one.firstPoint)))));
    const kept = new Set([gaps.indexOf(Math.min(...gaps))]);
    for (let k = 0; k < kMostOfPlane; ++k) {
      const angle = (2 * Math.PI * k) / kMostOfPlane;
      const way = m.add(m.scale(Math.cos(angle), u), m.scale(Math.sin(angle), v));
      const places = points.map((point) => m.dot(way, point));
      kept.add(places.indexOf(Math.max(...places)));
    }
    return group.filter((_, k) => kept.has(k));
  });
}

/** Contacts that may act within the window. begin(held), end(held): poses; ways: see detect(). All bodies are at their
 * begin afterwards. */
export function findContacts(model, ways, begin, end) {
  return outermost([...convex(model, ways, begin, end), ...planes(model, ways)]);
}
