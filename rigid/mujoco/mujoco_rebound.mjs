// Rebounds of pairs of bodies that meet nothing else in a window: solved at their touch, from which they go on.
import * as m from '../jolt/algebra.mjs';
import {
  areBalls, commonTouch, energyOf, flown, isFree, isParting, partnersOf, pullOf, struck, touchOf, touchOfBalls, velocitiesOf,
} from '../jolt/rebound.mjs';

/** Largest gain of energy, relative: residuals of the solver. */
const kGain = 1e-9;
const kStill = { linear: [0, 0, 0], angular: [0, 0, 0] };
const moves = (held) => held.slot >= 0;

/** Pairs that bounce: { first, second, touch [s], meetings }; `touch` is null where two balls pass one another. `meetings`: all
 * of the window, with `bounces`, `acted` and the gap `before`; `bound(held)`: something else acts on the body. */
function pairsOf(meetings, bound, end, pull, window) {
  const groups = new Map(), partners = partnersOf(meetings.map(({ first, second }) => [first, second]), moves);
  for (const one of meetings) {
    const key = `${one.first.id} ${one.second.id}`;
    if (!groups.has(key)) groups.set(key, []);
    groups.get(key).push(one);
  }
  const alone = (held) => !moves(held) || (partners.get(held) !== null && !bound(held));
  const found = [];
  for (const group of groups.values()) {
    const { first, second } = group[0], acted = group.filter((one) => one.acted);
    if (!alone(first) || !alone(second) || !acted.every((one) => one.bounces)) continue;
    const touch = commonTouch(acted.map(({ before, approach, normal, law }) =>
      touchOf(before, approach, m.dot(normal, m.subtract(pull(second), pull(first))), law.restitution, window)), window);
    if (touch === null) continue;
    const met = areBalls(first, second) && moves(first) && moves(second) ?
      touchOfBalls(first, second, end, pull, window, touch) : touch;
    found.push({ first, second, touch: met, meetings: acted });
  }
  return found;
}

/** Sets the ends of the bodies that bounce within the window [s] and whose way is free. Arguments: the engine (its model, its
 * solver, bodies, place(meeting)); the meetings and bound() as pairsOf() has them; `predicted`: by body. */
export function bounceApart(engine, window, meetings, bound, predicted) {
  const pulls = new Map(engine.moving.map((held) => [held, pullOf(held.linear, predicted.get(held), window)]));
  const pull = (held) => pulls.get(held) ?? [0, 0, 0];
  const all = pairsOf(meetings, bound, (held) => predicted.get(held), pull, window);
  const pairs = all.filter(({ touch }) => touch !== null);
  for (const { first, second } of all.filter(({ touch }) => touch === null))
    for (const held of [first, second]) held.end = predicted.get(held);
  if (pairs.length === 0) return;
  const touches = new Map(); // motions with which bodies reach their touch
  for (const { first, second, touch } of pairs)
    for (const held of [first, second].filter(moves))
      touches.set(held, flown(held, predicted.get(held), pull(held), touch - window));
  engine.model.place((held) => touches.get(held) ?? held.end);
  const speed = (held) => (touches.has(held) ? velocitiesOf(held, touches.get(held)) : kStill);
  const contacts = pairs.flatMap((pair) => pair.meetings.map((meeting) => {
    const contact = engine.place(meeting), { first, second } = contact;
    if (areBalls(first, second)) {
      contact.normal = between(first, second);
      contact.point = m.add(first.at.position, m.scale(first.body.shape.sphere, contact.normal));
    }
    const { point } = contact;
    const at = (held) => {
      const { linear, angular } = speed(held);
      return moves(held) ? m.add(linear, m.cross(angular, m.subtract(point, held.at.position))) : linear;
    };
    const closing = m.dot(contact.normal, m.subtract(at(first), at(second)));
    return { ...contact, target: meeting.law.restitution * Math.max(0, closing) };
  }));
  const impulses = engine.solver.solve(contacts, [], 0, speed);
  const wayOf = (held) => (moves(held) ? held.way : 0);
  for (const { first, second, touch, meetings: met } of pairs) {
    const both = [first, second].filter(moves), rest = window - touch;
    if (!both.some((held) => impulses.has(held))) continue;
    const after = new Map(both.map((held) => {
      const { linear, angular } = impulses.get(held) ?? kStill;
      return [held, struck(touches.get(held), m.scale(1 / held.mass, linear), angular)];
    }));
    const sum = (motions) => both.reduce((total, held) => total + energyOf(held, motions.get(held)), 0);
    if (sum(after) > sum(touches) * (1 + kGain)) continue;
    const normals = met.map(({ normal }) => (areBalls(first, second) ? between(first, second) : normal));
    if (!isParting(first, second, normals, (held) => after.get(held) ?? null, pull, rest)) continue;
    const free = (held) => isFree(held, held === first ? second : first, after.get(held), rest, engine.held, wayOf);
    if (!both.every(free)) continue;
    for (const held of both) held.end = flown(held, after.get(held), pull(held), rest);
  }
}

function between(first, second) {
  const apart = m.subtract(second.at.position, first.at.position);
  return m.scale(1 / m.norm(apart), apart);
}
