// Converts messages to plain values and back. Decoding checks every value, as coupler/link/messages.cpp does: finite,
// sizes, ids, unit quaternions. An absent value is zero.
import { check } from './failure.mjs';

export const kProtocol = 2;
export const kMaxHash = 256; // [bytes]
export const kMaxMessage = 256 * 2 ** 20; // [bytes]
const kQuaternionTolerance = 1e-9; // deviation from unit length: round-off of a window
const kMaxBodies = 100000, kMaxParts = 65536, kMaxCorners = 4096, kMaxJoints = 100000, kMaxLaws = 1000000;
const kMaxWord = 255; // [bytes]
const kJointKinds = [null, 'BALL', 'HINGE', 'SLIDER', 'FIXED'];

/** A 64-bit integer as a number; above 2^53 it is rounded. */
export const integer = (value) => (typeof value === 'number' ? value : value.toNumber());

/** A BigInt as a 64-bit integer of a message, for nanoseconds. */
export const wide = (value) => ({
  low: Number(BigInt.asIntN(32, value)), high: Number(BigInt.asIntN(32, value >> 32n)), unsigned: false,
});

function vector(v, field) {
  const r = v ? [v.x, v.y, v.z] : [0, 0, 0];
  check(r.every(Number.isFinite), () => `${field} is (${r.join(', ')}): not finite`);
  return r;
}

function quaternion(q, field) {
  const r = q ? [q.w, q.x, q.y, q.z] : [0, 0, 0, 0];
  // also false where a number is not finite
  check(Math.abs(Math.hypot(...r) - 1) < kQuaternionTolerance,
    () => `${field} is (${r.join(', ')}): not of unit length`);
  return r;
}

const motion = (m, field) => ({
  position: vector(m.position, `${field}.position`),
  orientation: quaternion(m.orientation, `${field}.orientation`),
  velocity: vector(m.velocity, `${field}.velocity`),
  angular_momentum: vector(m.angular_momentum, `${field}.angular_momentum`),
});

function word(text, field) {
  const size = Buffer.byteLength(text);
  check(size <= kMaxWord, () => `${field} has ${size} bytes; ${kMaxWord} at most`);
  return text;
}

function convexPart({ corners }, field) {
  check(corners.length % 3 === 0 && corners.length >= 12 && corners.length <= 3 * kMaxCorners,
    () => `${field}.convex: ${corners.length} coordinates in a part`);
  check(corners.every(Number.isFinite), () => `${field}.convex: a corner is not finite`);
  const points = [];
  for (let i = 0; i < corners.length; i += 3) points.push(corners.slice(i, i + 3));
  return points;
}

function shape(m, field) {
  switch (m.shape) {
    case 'sphere_radius_m':
      check(Number.isFinite(m.sphere_radius_m) && m.sphere_radius_m > 0,
        () => `${field}.sphere_radius_m is ${m.sphere_radius_m}`);
      return { sphere: m.sphere_radius_m };
    case 'box_half_size_m': {
      const box = vector(m.box_half_size_m, `${field}.box_half_size_m`);
      check(Math.min(...box) > 0, () => `${field}.box_half_size_m must be positive`);
      return { box };
    }
    case 'half_space':
      return { half_space: true };
    case 'convex': {
      const { parts } = m.convex;
      check(parts.length >= 1 && parts.length <= kMaxParts, () => `${field}.convex has ${parts.length} parts`);
      return { parts: parts.map((part) => convexPart(part, field)) };
    }
    default:
      return check(false, () => `${field} has no shape`);
  }
}

function body(m, field) {
  check(m.id !== 0, () => `${field}.id is 0; ids start at 1`);
  const b = {
    id: m.id, name: word(m.name, `${field}.name`), is_static: m.is_static, mass: m.mass,
    principal_inertia: vector(m.principal_inertia, `${field}.principal_inertia`),
    motion: motion(m, field), contact_group: m.contact_group, shape: shape(m, field),
  };
  if (!b.is_static)
    check(Number.isFinite(b.mass) && b.mass > 0 && Math.min(...b.principal_inertia) > 0,
      () => `${field}: mass ${b.mass} and inertia must be positive`);
  return b;
}

function decodeBodies(bodies, field) {
  check(bodies.length <= kMaxBodies, () => `${field}: ${bodies.length} bodies; ${kMaxBodies} at most`);
  return bodies.map((b) => body(b, `${field}[${b.id}]`));
}

function law({ first_group, second_group, friction, restitution }) {
  check(Number.isFinite(friction) && friction >= 0, () => `contacts.friction is ${friction}`);
  check(restitution >= 0 && restitution <= 1, () => `contacts.restitution is ${restitution}`);
  return { first_group, second_group, friction, restitution };
}

function joint(m) {
  const field = `joints[${m.id}]`;
  check(m.id !== 0 && m.first !== 0, () => `${field}: joint ${m.id} of body ${m.first}; ids start at 1`);
  check(m.kind >= 1 && m.kind < kJointKinds.length, () => `${field}.kind is ${m.kind}`);
  const frame = (pose, name) => ({
    position: vector(pose?.position, field + name), orientation: quaternion(pose?.orientation, field + name),
  });
  return {
    id: m.id, name: word(m.name, `${field}.name`), kind: kJointKinds[m.kind], first: m.first, second: m.second,
    first_frame: frame(m.first_frame, '.first_frame'), second_frame: frame(m.second_frame, '.second_frame'),
  };
}

export function decodeLoad(load) {
  check(load.contacts.length <= kMaxLaws, () => `contacts: ${load.contacts.length} of them; ${kMaxLaws} at most`);
  check(load.joints.length <= kMaxJoints, () => `joints: ${load.joints.length} of them; ${kMaxJoints} at most`);
  return {
    bodies: decodeBodies(load.bodies, 'bodies'), laws: load.contacts.map(law), joints: load.joints.map(joint),
    tick: integer(load.tick), keep_windows: load.keep_windows,
  };
}

function ascending(ids, what) {
  check(ids.length <= kMaxBodies, () => `${what}: ${ids.length} of them; ${kMaxBodies} at most`);
  ids.forEach((id, i) => check(i === 0 || id > ids[i - 1], () => `${what}[${id}]: twice, or out of order`));
}

export function decodeWindow(w) {
  ascending(w.predicted.map((h) => h.id), 'predicted');
  ascending(w.solved, 'solved');
  ascending(w.released, 'released');
  return {
    tick: integer(w.tick), ticks: w.ticks, window_s: w.window_s, again: w.again, solved: w.solved,
    released: w.released,
    predicted: w.predicted.map((h) => ({ id: h.id, ...motion(h, `predicted[id ${h.id}]`) })),
    births: decodeBodies(w.births, 'births'),
  };
}

export function encodeStates(states) {
  const xyz = ([x, y, z]) => ({ x, y, z });
  return states.map((s) => {
    const [w, x, y, z] = s.orientation;
    return {
      id: s.id, mass: s.mass, position: xyz(s.position), orientation: { w, x, y, z }, velocity: xyz(s.velocity),
      angular_momentum: xyz(s.angular_momentum),
    };
  });
}
