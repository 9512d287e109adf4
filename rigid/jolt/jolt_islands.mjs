// Restores the angular momentum of linked bodies that have no link to the world.
import * as m from './algebra.mjs';
import { islands } from './islands.mjs';

const moves = (held) => held !== undefined && !held.body.is_static;

/** Groups of bodies that joints connect. A group with a joint to a static body or to the world is left out, since that
 * joint takes up angular momentum. `pairs`: the two bodies of each joint, undefined for the world. */
export function freeIslands(pairs) {
  const hung = new Set(pairs.filter((pair) => !pair.every(moves)).flat());
  return islands(pairs, moves).filter((island) => !island.some((held) => hung.has(held)));
}

/** Jolt corrects joints by moving bodies by s = `held.push` [m], which removes the angular momentum s x p. In bodies
 * that circle one another this is a share (omega H)^2/2 per window, always with one sign. Restores it as a rotation of
 * the whole group, which changes neither its momentum nor the velocity in any joint. */
export function giveBackTurn(island) {
  let missing = [0, 0, 0], centre = [0, 0, 0], mass = 0;
  for (const held of island) {
    const { position, velocity } = held.motion;
    missing = m.subtract(missing, m.cross(held.push, m.scale(held.mass, velocity)));
    centre = m.add(centre, m.scale(held.mass, position));
    mass += held.mass;
  }
  if (m.norm(missing) === 0) return;
  centre = m.scale(1 / mass, centre);
  const inertiaOf = ({ motion, body }, w) => m.applyInertia(motion.orientation, body.principal_inertia, w);
  const columns = [[1, 0, 0], [0, 1, 0], [0, 0, 1]].map((axis) => island.reduce((sum, held) => {
    const arm = m.subtract(held.motion.position, centre);
    return m.add(sum, m.add(inertiaOf(held, axis), m.scale(held.mass, m.cross(arm, m.cross(axis, arm)))));
  }, [0, 0, 0]));
  const turn = m.solve(columns, missing);
  for (const held of island) {
    const { motion } = held, arm = m.subtract(motion.position, centre);
    held.motion = {
      ...motion,
      velocity: m.add(motion.velocity, m.cross(turn, arm)),
      angular_momentum: m.add(motion.angular_momentum, inertiaOf(held, turn)),
    };
  }
}
