// Rigid bodies in Jolt, taken through windows (rigid/README.md "A window"). Motions are kept here in double precision;
// Jolt has copies in single precision. So a body without contacts and joints ends in its predicted state, to the bit.
import * as m from './algebra.mjs';
import { freeIslands, giveBackTurn } from './jolt_islands.mjs';
import { addJoint } from './jolt_joints.mjs';
import { bounceApart } from './jolt_rebound.mjs';
import { kLength, kMass } from './jolt_shapes.mjs';
import { World } from './jolt_world.mjs';
import { reach } from './rebound.mjs';

/** Turn per window above which the average angular velocity is not used, because its logarithm is ambiguous from pi on.
 * The solver then gets the predicted angular velocity. */
const kFastTurn = 0.7; // [rad]
/** Changes of a pose below the round-off of single precision do not count. */
const kPositionNoise = 4 * 2 ** -24; // share of the largest coordinate [-]
const kTurnNoise = 1e-6; // [rad]

const rounded = (v) => v.map(Math.fround);
const same = (a, b) => a[0] === b[0] && a[1] === b[1] && a[2] === b[2];

/** The engine that a session asks; its calls are those of link::Engine (coupler/link/engine.h). */
export class JoltEngine {
  constructor({ jolt, version }) {
    this.world = new World(jolt);
    this.held = new Map(); // by id
    this.moving = []; // by ascending id
    this.newborn = [];
    this.jointed = new Map(); // by the joint's id: its two bodies
    this.islands = null; // groups of linked bodies without a link to the world; null: not found yet
    this.info = {
      name: 'jolt',
      version,
      capabilities: [
        'spheres', 'boxes', 'half_spaces', 'convex_hulls', 'compound', 'contact', 'friction', 'restitution', 'joints',
        'release_joints', 'deterministic',
      ],
    };
  }

  /** Frees the world's memory, which is a large part of Jolt's. */
  close() {
    this.world.close();
  }

  setContactLaws(laws) {
    this.world.setLaws(laws);
  }

  /** Adds a body with a new id. Throws Failure (bad_body). */
  add(body) {
    const held = {
      id: body.id, group: body.contact_group, mass: body.mass, motion: body.motion, body, rigid: null,
      shape: this.world.shapes.make(body), reach: reach(body), met: false, struck: false, touched: false,
    };
    this.held.set(body.id, held);
    this.newborn.push(held);
    if (body.is_static) return;
    this.moving.push(held);
    if (this.moving.at(-2)?.id > body.id) this.moving.sort((a, b) => a.id - b.id);
  }

  /** Adds a joint between bodies that the engine holds. Throws Failure (bad_joint). */
  addJoint(joint) {
    this.insertNewborn();
    addJoint(this.world, joint, this.held);
    this.jointed.set(joint.id, [this.held.get(joint.first), this.held.get(joint.second)]);
    this.islands = null;
  }

  /** Releases a joint; its bodies still do not collide. A released joint stays released. */
  releaseJoint(id) {
    const ends = this.jointed.get(id);
    if (!ends) return;
    this.jointed.delete(id);
    this.world.release(id);
    this.islands = null;
    const left = [...this.jointed.values()];
    for (const held of ends) if (held) held.jointed = left.some((pair) => pair.includes(held));
  }

  /** Adds new bodies to the world by ascending id, in whatever order add() was called. */
  insertNewborn() {
    this.newborn.sort((a, b) => a.id - b.id);
    for (const held of this.newborn) {
      held.rigid = this.world.add(held, held.body, held.shape);
      held.shape.Release();
      held.shape = null;
      if (!held.body.is_static) held.mass = 1 / (kMass * held.rigid.GetMotionProperties().GetInverseMass());
    }
    this.newborn = [];
  }

  /** State of every body that is not static, by ascending id. */
  states() {
    return this.moving.map(({ id, mass, motion }) => ({ id, mass, ...motion }));
  }

  /** One window [s]. `predicted`: one state for each moving body, by ascending id (checked by the session). `solved`:
   * ids of bodies whose contacts and joints are left out. */
  advance(window, predicted, solved) {
    this.insertNewborn();
    this.world.leaveOut(solved);
    let way = 0;
    this.moving.forEach((held, index) => {
      this.depart(held, predicted[index], window);
      way = Math.max(way, m.norm(held.linear) * window);
    });
    this.world.solve(window, way);
    let anyTouched = false;
    for (const held of this.moving) {
      this.arrive(held, window);
      anyTouched ||= held.touched;
    }
    // only without contacts: with contacts, an outside body may have moved the group
    this.islands ??= freeIslands([...this.jointed.values()]);
    for (const island of this.islands) if (!island.some((held) => held.struck)) giveBackTurn(island);
    if (!anyTouched) return;
    this.relax(window);
    bounceApart(this, window);
  }

  /** Gives Jolt the average velocity of the window. */
  depart(held, predicted, window) {
    const start = held.motion, principal = held.body.principal_inertia;
    held.predicted = predicted;
    const turn = m.multiply(predicted.orientation, m.conjugate(start.orientation));
    let spin = m.scale(1 / window, m.vectorOf(turn));
    const endSpin = m.applyInverseInertia(predicted.orientation, principal, predicted.angular_momentum);
    if (Math.max(m.norm(endSpin), m.norm(spin)) * window > kFastTurn) spin = endSpin;
    held.spin = spin;
    held.angular = rounded(spin);
    held.linear = rounded(m.scale(kLength / window, m.subtract(predicted.position, start.position)));
    held.departure = { position: start.position, linear: m.scale(1 / kLength, held.linear), angular: held.angular };
    held.way = window * (m.norm(held.departure.linear) + m.norm(spin) * held.reach);
    held.met = held.jointed === true;
    held.struck = false;
    held.push = [0, 0, 0];
    this.world.put(held.rigid, start, held.linear, held.angular);
  }

  /** Sets the motion at the end of the window: the predicted state plus Jolt's changes. */
  arrive(held, window) {
    const { motion: start, predicted } = held, principal = held.body.principal_inertia;
    held.touched = false;
    held.motion = {
      position: predicted.position, orientation: predicted.orientation, velocity: predicted.velocity,
      angular_momentum: predicted.angular_momentum,
    };
    if (!held.met) return;
    const now = this.world.read(held.rigid);
    const dv = m.subtract(now.linear, held.linear), dw = m.subtract(now.angular, held.angular);
    // Motion beyond that of the velocities: removed overlaps, and motions stopped at an impact.
    const from = rounded(m.scale(kLength, start.position));
    let push = m.subtract(now.position, m.add(from, m.scale(window, now.linear)));
    const furthest = Math.max(...from.map(Math.abs), ...now.position.map(Math.abs));
    if (m.norm(push) <= kPositionNoise * furthest) push = [0, 0, 0];
    const explained = m.multiply(m.turnOf(m.scale(window, now.angular)), start.orientation);
    let pushTurn = m.multiply(now.orientation, m.conjugate(explained));
    if (m.norm(m.vectorOf(pushTurn)) <= kTurnNoise) pushTurn = [1, 0, 0, 0];
    held.touched = !(same(now.linear, held.linear) && same(now.angular, held.angular) && same(push, [0, 0, 0]) &&
      pushTurn[0] === 1);
    if (!held.touched) return;
    held.push = m.scale(1 / kLength, push);
    const change = m.add(m.scale(window / kLength, dv), held.push);
    // Turn the predicted pose by the difference between two free flights, with and without the change of angular
    // velocity. A turn with constant angular velocity would give energy to a thin shard that an impact sets spinning.
    const without = m.freeTurn(start.orientation, principal, held.spin, window);
    const withIt = m.freeTurn(start.orientation, principal, m.add(held.spin, dw), window);
    const turned = m.multiply(m.multiply(withIt, m.conjugate(without)), predicted.orientation);
    held.motion = {
      position: m.add(predicted.position, change),
      orientation: m.normalized(m.multiply(pushTurn, turned)),
      velocity: m.add(predicted.velocity, m.scale(1 / kLength, dv)),
      angular_momentum: m.add(predicted.angular_momentum, m.applyInertia(start.orientation, principal, dw)),
    };
  }

  /** Solves velocities once more, at the new poses. Without it bodies squeezed between shell and floor gain energy. */
  relax(window) {
    for (const held of this.moving) {
      const { orientation, velocity, angular_momentum: momentum } = held.motion;
      held.linear = rounded(m.scale(kLength, velocity));
      held.angular = rounded(m.applyInverseInertia(orientation, held.body.principal_inertia, momentum));
      held.met = held.jointed === true;
      this.world.put(held.rigid, held.motion, held.linear, held.angular);
    }
    this.world.relax(window);
    for (const held of this.moving) {
      if (!held.met) continue;
      const now = this.world.read(held.rigid);
      if (same(now.linear, held.linear) && same(now.angular, held.angular)) continue;
      const { motion } = held;
      const dv = m.subtract(now.linear, held.linear), dw = m.subtract(now.angular, held.angular);
      held.motion = {
        ...motion,
        velocity: m.add(motion.velocity, m.scale(1 / kLength, dv)),
        angular_momentum: m.add(motion.angular_momentum,
          m.applyInertia(motion.orientation, held.body.principal_inertia, dw)),
      };
    }
  }
}
