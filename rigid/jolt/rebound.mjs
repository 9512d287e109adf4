// Rebounds within a window, of two bodies that meet nothing else in it: when they touch, and their flights to and from there
// (rigid/engine/rebound.h). `pull`: mean acceleration that leads to a predicted motion [m/s^2].
import * as m from './algebra.mjs';

const kMostPull = 0.2; // change of the closing speed by the pull in a window, as a share of it
const kMostSteps = 8; // of Newton's method, whose error squares in each
const kAtOneTime = 0.05; // spread of the touches of a pair [of a window]

/** Radius about a body's centre that holds it [m]. */
export function reach({ shape: { sphere, box, parts } }) {
  if (sphere) return sphere;
  if (box) return m.norm(box);
  return parts ? Math.max(...parts.flat().map(m.norm)) : Infinity;
}

/** When two bodies touch [s since the window's begin] that are `gap` [m] apart and close with the average speed `approach`
 * [m/s], pulled apart by `pull` [m/s^2]; null where gravity decides. */
export function touchOf(gap, approach, pull, restitution, window) {
  if (!(approach > 0) || Math.abs(pull) * window > kMostPull * approach) return null;
  const begin = approach + 0.5 * pull * window, square = begin * begin - 2 * pull * Math.max(0, gap);
  if (!(square > 0)) return null;
  const closing = Math.sqrt(square), touch = (2 * Math.max(0, gap)) / (begin + closing), rest = window - touch;
  return rest >= 0 && restitution * closing + pull * rest > 0 ? touch : null;
}

/** The common time of the touches of a pair: the latest one; null where one is null, or they are apart. */
export function commonTouch(touches, window) {
  if (touches.length === 0 || touches.includes(null)) return null;
  const late = Math.max(...touches);
  return late - Math.min(...touches) <= kAtOneTime * window ? late : null;
}

/** Mean acceleration that leads to a predicted motion, from the average velocity [m/s]. */
export const pullOf = (velocity, predicted, window) => m.scale(2 / window, m.subtract(predicted.velocity, velocity));

const spinOf = (held, { orientation, angular_momentum: momentum }) =>
  m.applyInverseInertia(orientation, held.body.principal_inertia, momentum);

/** A motion after `time` seconds of flight, which may be negative. */
export function flown(held, motion, pull, time) {
  const way = m.add(m.scale(time, motion.velocity), m.scale(0.5 * time * time, pull));
  return {
    position: m.add(motion.position, way),
    orientation: m.freeTurn(motion.orientation, held.body.principal_inertia, spinOf(held, motion), time),
    velocity: m.add(motion.velocity, m.scale(time, pull)),
    angular_momentum: motion.angular_momentum,
  };
}

/** A motion after an impulse: changes of velocity and angular momentum. */
export const struck = (motion, dv, dl) => ({
  ...motion, velocity: m.add(motion.velocity, dv), angular_momentum: m.add(motion.angular_momentum, dl),
});

/** Linear velocity, and angular one [rad/s]. */
export const velocitiesOf = (held, motion) => ({ linear: motion.velocity, angular: spinOf(held, motion) });

/** Kinetic energy [J]. */
export const energyOf = (held, motion) => 0.5 * (held.mass * m.dot(motion.velocity, motion.velocity) +
  m.dot(motion.angular_momentum, spinOf(held, motion)));

/** When two balls touch [s since the window's begin], from a first guess; null where they pass one another or touch later.
 * `end(held)`, `pull(held)`: predicted motion, and the mean acceleration that leads to it. */
export function touchOfBalls(first, second, end, pull, window, guess) {
  const wanted = first.body.shape.sphere + second.body.shape.sphere;
  const between = (of) => m.subtract(of(second), of(first));
  const place = between((held) => end(held).position), speed = between((held) => end(held).velocity), pulled = between(pull);
  let touch = guess;
  for (let step = 0; step < kMostSteps; ++step) {
    const rest = window - touch;
    const apart = m.add(m.subtract(place, m.scale(rest, speed)), m.scale(0.5 * rest * rest, pulled)), distance = m.norm(apart);
    if (touch === 0 && distance <= wanted) return touch; // they overlap from the start
    const opening = m.dot(apart, m.subtract(speed, m.scale(rest, pulled))) / distance;
    if (!(opening < 0)) return null;
    const next = Math.max(0, touch - (distance - wanted) / opening);
    if (next > window) return null;
    if (next === touch) break;
    touch = next;
  }
  return touch;
}

export const areBalls = (first, second) => first.body.shape.sphere > 0 && second.body.shape.sphere > 0;

/** The partner of each body that moves; null where there are several. `pairs`: [first, second] of contacts. */
export function partnersOf(pairs, moves) {
  const partners = new Map();
  const note = (held, other) => {
    if (moves(held)) partners.set(held, partners.has(held) && partners.get(held) !== other ? null : other);
  };
  for (const [first, second] of pairs) note(first, second), note(second, first);
  return partners;
}

/** True where all of the second body goes away from the first along these normals, from the first to the second, for `rest`
 * seconds. `motion(held)`: after the touch; null for what stands still. */
export function isParting(first, second, normals, motion, pull, rest) {
  const speed = (held) => motion(held)?.velocity ?? [0, 0, 0];
  const rim = [first, second].reduce((sum, held) => sum + (motion(held) === null || held.body.shape.sphere ? 0 :
    m.norm(spinOf(held, motion(held))) * held.reach), 0);
  const opening = m.subtract(speed(second), speed(first)), pulled = m.scale(rest, m.subtract(pull(second), pull(first)));
  return normals.every((normal) => m.dot(normal, opening) + Math.min(0, m.dot(normal, pulled)) >= rim);
}

/** True where no body but the partner comes within reach of a body on its flight from `motion`, for `rest` seconds: bodies are
 * taken as the balls around them, with `wayOf(other)`, how far another one comes in the window [m]. */
export function isFree(held, partner, motion, rest, bodies, wayOf) {
  const own = held.reach + rest * m.norm(motion.velocity), [x, y, z] = motion.position;
  for (const other of bodies) {
    if (other === held || other === partner) continue;
    const [a, b, c] = other.motion.position;
    if (other.reach === Infinity) {
      if (m.dot(m.rotate(other.motion.orientation, [0, 0, 1]), [x - a, y - b, z - c]) <= own) return false;
      continue;
    }
    const near = own + other.reach + wayOf(other);
    if ((x - a) ** 2 + (y - b) ** 2 + (z - c) ** 2 <= near * near) return false;
  }
  return true;
}
