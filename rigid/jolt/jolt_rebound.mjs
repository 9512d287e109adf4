// Rebounds of pairs of bodies that meet nothing else in a window: solved at their touch, from which they go on. Jolt solves a
// rebound at the begin of its step.
import * as m from './algebra.mjs';
import { kLength } from './jolt_shapes.mjs';
import {
  areBalls, commonTouch, energyOf, flown, isFree, isParting, partnersOf, pullOf, struck, touchOf, touchOfBalls, velocitiesOf,
} from './rebound.mjs';

/** Largest gain of energy, relative: residuals of Jolt's solver, in single precision. */
const kGain = 1e-5;
/** Contacts that close more slowly do not bounce. */
const kImpactSpeed = 0.05; // [m/s]
const moves = (held) => !held.body.is_static;

/** Pairs that may bounce: { first, second, touch [s], normals }; `touch` is null where two balls pass one another. `seen`:
 * contacts of the window (jolt_world.mjs). */
function pairsOf(seen, pull, window) {
  const groups = new Map(), partners = partnersOf(seen.map(({ first, second }) => [first, second]), moves);
  for (const { first, second, ...contact } of seen) {
    const key = `${first.id} ${second.id}`;
    if (!groups.has(key)) groups.set(key, { first, second, contacts: [] });
    groups.get(key).contacts.push(contact);
  }
  const alone = (held) => !moves(held) || (partners.get(held) !== null && held.jointed !== true);
  const found = [];
  for (const { first, second, contacts } of groups.values()) {
    if (!alone(first) || !alone(second)) continue;
    const touches = contacts.map(({ normal, point, gap, restitution }) => {
      const speed = (held) => {
        if (!moves(held)) return [0, 0, 0];
        const { position, linear, angular } = held.departure;
        return m.add(linear, m.cross(angular, m.subtract(point, position)));
      };
      const approach = m.dot(normal, m.subtract(speed(first), speed(second)));
      if (!(restitution > 0 && approach > kImpactSpeed)) return null;
      return touchOf(gap, approach, m.dot(normal, m.subtract(pull(second), pull(first))), restitution, window);
    });
    const touch = commonTouch(touches, window);
    if (touch === null) continue;
    const met = areBalls(first, second) && moves(first) && moves(second) ?
      touchOfBalls(first, second, (held) => held.predicted, pull, window, touch) : touch;
    found.push({ first, second, touch: met, normals: contacts.map(({ normal }) => normal) });
  }
  return found;
}

/** Sets the motions of the bodies that bounce within the window [s] and whose way is free. `engine`: its world and bodies,
 * which have `predicted` and `departure`: position and velocities at the window's begin [m, m/s, rad/s]. */
export function bounceApart(engine, window) {
  const pulls = new Map();
  const pull = (held) => {
    if (!moves(held)) return [0, 0, 0];
    if (!pulls.has(held)) pulls.set(held, pullOf(held.departure.linear, held.predicted, window));
    return pulls.get(held);
  };
  const all = pairsOf(engine.world.seen, pull, window), pairs = all.filter(({ touch }) => touch !== null);
  for (const { first, second } of all.filter(({ touch }) => touch === null))
    for (const held of [first, second]) held.motion = held.predicted;
  if (pairs.length === 0) return;
  const touches = new Map(); // motions with which bodies reach their touch
  for (const { first, second, touch } of pairs)
    for (const held of [first, second].filter(moves))
      touches.set(held, flown(held, held.predicted, pull(held), touch - window));
  const given = new Map();
  for (const held of engine.moving) {
    const motion = touches.get(held) ?? held.motion, { linear, angular } = velocitiesOf(held, motion);
    const put = { linear: m.scale(kLength, linear).map(Math.fround), angular: angular.map(Math.fround) };
    given.set(held, put);
    engine.world.put(held.rigid, motion, put.linear, put.angular);
  }
  engine.world.bounce(window, pairs.map(({ first, second }) => [first, second]));
  const bodies = [...engine.held.values()], wayOf = (held) => (moves(held) ? held.way : 0);
  for (const { first, second, touch, normals } of pairs) {
    const both = [first, second].filter(moves), rest = window - touch;
    const after = new Map(both.map((held) => {
      const now = engine.world.read(held.rigid), { linear, angular } = given.get(held), motion = touches.get(held);
      const turn = m.applyInertia(motion.orientation, held.body.principal_inertia, m.subtract(now.angular, angular));
      return [held, struck(motion, m.scale(1 / kLength, m.subtract(now.linear, linear)), turn)];
    }));
    if (both.every((held) => m.norm(m.subtract(after.get(held).velocity, touches.get(held).velocity)) === 0)) continue;
    const sum = (motions) => both.reduce((total, held) => total + energyOf(held, motions.get(held)), 0);
    if (sum(after) > sum(touches) * (1 + kGain)) continue;
    if (!isParting(first, second, normals, (held) => after.get(held) ?? null, pull, rest)) continue;
    const free = (held) => isFree(held, held === first ? second : first, after.get(held), rest, bodies, wayOf);
    if (!both.every(free)) continue;
    for (const held of both) held.motion = flown(held, after.get(held), pull(held), rest);
  }
}
