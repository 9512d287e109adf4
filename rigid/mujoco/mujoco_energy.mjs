// Contacts and joints never add energy. The first solve sees average velocities at the begin of the window, but a body that
// tumbles has others at its end; and to turn a pose changes the energy of an angular momentum. Both are small and are
// taken back here.
import * as m from '../jolt/algebra.mjs';
import { islands } from '../jolt/islands.mjs';

const kMostRounds = 60;

const energy = (held, { orientation, velocity, angular_momentum: momentum }) => 0.5 * (held.mass * m.dot(velocity, velocity) +
  m.dot(momentum, m.applyInverseInertia(orientation, held.body.principal_inertia, momentum)));

const moves = (held) => held !== undefined && held.slot >= 0;

/** Acts on each group of bodies that `links` [{ first, second }] connect (`second` may be undefined), where it has more
 * energy than its predicted states (by body). Takes back turns out of overlaps (`unturned`: orientation before), then a
 * share of the impulses, and their turns where that is not enough. The share is one for the group, so momentum stays. */
export function takeGainBack(links, predicted) {
  for (const group of islands(links.map(({ first, second }) => [first, second]), moves)) {
    const allowed = group.reduce((sum, held) => sum + energy(held, predicted.get(held)), 0);
    const now = () => group.reduce((sum, held) => sum + energy(held, held.end), 0);
    const orient = (of) => {
      for (const held of group) held.end = { ...held.end, orientation: of(held) };
    };
    if (now() <= allowed) continue;
    orient((held) => held.unturned);
    if (now() <= allowed || scaleDown(group, predicted, now, allowed)) continue;
    orient((held) => predicted.get(held).orientation);
    scaleDown(group, predicted, now, allowed);
  }
}

/** Leaves the largest share of the impulses with which the energy now() is at most `allowed`; false where there is none. */
function scaleDown(group, predicted, now, allowed) {
  const whole = group.map((held) => held.end);
  const at = (share) => {
    group.forEach((held, k) => {
      const { velocity, angular_momentum: momentum } = predicted.get(held), end = whole[k];
      held.end = {
        ...held.end,
        velocity: m.add(velocity, m.scale(share, m.subtract(end.velocity, velocity))),
        angular_momentum: m.add(momentum, m.scale(share, m.subtract(end.angular_momentum, momentum))),
      };
    });
    return now();
  };
  // a quadratic function of the share; the share that is looked for lies between its least value and 1
  const none = at(0), half = at(0.5), full = at(1), curve = 2 * (none + full - 2 * half);
  let good = curve > 0 ? Math.min(1, Math.max(0, -(full - none - curve) / (2 * curve))) : 0, bad = 1;
  if (at(good) > allowed) {
    at(1);
    return false;
  }
  for (let round = 0; round < kMostRounds; ++round) {
    const middle = 0.5 * (good + bad);
    if (middle <= good || middle >= bad) break;
    if (at(middle) <= allowed) good = middle;
    else bad = middle;
  }
  at(good);
  return true;
}
