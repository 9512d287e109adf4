// Rebounds within a window, of two bodies that meet nothing else in it: when they touch, and their flights to and from there
// (rigid/engine/rebound.h). `pull`: mean acceleration that leads to a predicted motion [m/s^2].
import * as m from './algebra.mjs';

const kMostPull = 0.2; // change of the closing speed by the pull in a window, as a share of it
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

/** True where no other body comes within reach of a body on its flight from `motion`, for `rest` seconds. `wayOf(other)`: how
 * far another body comes in the window [m]; each body has its `reach`. */
export function isFree(held, motion, rest, others, wayOf) {
  const own = held.reach + rest * m.norm(motion.velocity);
  return others.every((other) => {
    const apart = m.subtract(motion.position, other.motion.position);
    if (other.body.is_static && other.reach === Infinity)
      return m.dot(m.rotate(other.motion.orientation, [0, 0, 1]), apart) > own;
    return m.norm(apart) > own + other.reach + wayOf(other);
  });
}
