// Rigid bodies in MuJoCo, taken through windows (rigid/README.md "A window"). Motions are kept here. MuJoCo finds contacts
// and solves them; a body without contacts ends in its predicted state, to the bit.
import * as m from '../jolt/algebra.mjs';
import { islands } from '../jolt/islands.mjs';
import { ContactLaws } from '../jolt/laws.mjs';
import { reach } from '../jolt/rebound.mjs';
import { armOf, corners, findContacts } from './mujoco_contacts.mjs';
import { takeGainBack } from './mujoco_energy.mjs';
import { makeJoint } from './mujoco_joints.mjs';
import { Model, prepare } from './mujoco_model.mjs';
import { bounceApart } from './mujoco_rebound.mjs';
import { Solver } from './mujoco_solver.mjs';

/** Turn per window above which the average angular velocity is not used, because its logarithm is ambiguous from pi on.
 * The solver then gets the predicted angular velocity. */
const kFastTurn = 0.7; // [rad]
/** Contacts that close more slowly do not bounce: a resting body closes with g H per window. */
const kImpactSpeed = 0.05; // [m/s]
/** Overlap that stays. MuJoCo finds all corners of touching faces only where bodies overlap. */
const kSlack = 5e-6; // [m]
const kPushShare = 0.2; // of an overlap from before, removed in a window; what turning bodies add in it goes at once
/** Multiple of the largest overlap to remove, above which no body of a group is moved: among jammed bodies contacts may
 * contradict each other. Then the group's overlaps stay in that window. Bodies that turn out of an overlap move further than
 * it is deep, by the ratio of arms, some times. */
const kMostPush = 10;

/** Key of a pair of bodies, in either order. */
const pair = (a, b) => (a < b ? `${a} ${b}` : `${b} ${a}`);

/** The engine that a session asks; its calls are those of link::Engine (coupler/link/engine.h). */
export class MuJoCoEngine {
  constructor(mujoco) {
    this.mujoco = mujoco;
    this.held = []; // by ascending id
    this.moving = []; // by ascending id
    this.joints = new Map(); // by id
    this.linked = new Set(); // pairs of bodies that do not collide: pair()
    this.laws = new ContactLaws();
    this.model = null; // null: bodies came since it was compiled
    this.info = {
      name: 'mujoco',
      version: mujoco.mj_versionString(),
      capabilities: [
        'spheres', 'boxes', 'half_spaces', 'convex_hulls', 'compound', 'contact', 'friction', 'restitution', 'joints',
        'release_joints', 'mass_ratios', 'deterministic', 'double_precision',
      ],
    };
  }

  /** Frees MuJoCo's memory. */
  close() {
    this.model?.close();
    this.model = null;
  }

  /** Replaces all contact laws. */
  setContactLaws(laws) {
    this.laws.set(laws);
  }

  /** Adds a body with a new id. Throws Failure (bad_body). */
  add(body) {
    const text = prepare(this.mujoco, body);
    this.held.push({
      id: body.id, group: body.contact_group, mass: body.mass, motion: body.motion, body, text, reach: reach(body),
      corners: corners(body),
    });
    this.held.sort((a, b) => a.id - b.id);
    this.moving = this.held.filter((held) => !held.body.is_static);
    this.close();
  }

  /** Adds a joint between bodies that the engine holds. Throws Failure (bad_joint). */
  addJoint(joint) {
    this.joints.set(joint.id, makeJoint(joint, new Map(this.held.map((held) => [held.id, held]))));
    this.linked.add(pair(joint.first, joint.second));
    this.close();
  }

  /** Releases a joint; its bodies still do not collide. */
  releaseJoint(id) {
    this.joints.get(id).holds = false;
  }

  /** State of every body that is not static, by ascending id. */
  states() {
    return this.moving.map(({ id, mass, motion }) => ({ id, mass, ...motion }));
  }

  /** One window [s]. `predicted`: one state for each moving body, by ascending id (checked by the session). `solved`:
   * ids of bodies whose contacts are left out. */
  advance(window, predicted, solved) {
    this.moving.forEach((held, index) => this.depart(held, predicted[index], window));
    const out = new Set(solved);
    const meetings = this.meet(out);
    const joints = [...this.joints.values()]
      .filter(({ holds, first, second }) => holds && !out.has(first.id) && !(second && out.has(second.id)));
    if (meetings.length + joints.length > 0 && this.solve(window, meetings, joints)) {
      this.push(window, meetings, joints);
      this.relax(meetings, joints);
      const given = new Map(this.moving.map((held, k) => [held, predicted[k]]));
      takeGainBack([...meetings.filter(({ met }) => met), ...joints], given);
      this.bounceApart(window, meetings, joints, given);
    }
    for (const held of this.moving) held.motion = held.end;
  }

  /** Average velocities of the window. */
  depart(held, predicted, window) {
    const start = held.motion, principal = held.body.principal_inertia;
    const turn = m.multiply(predicted.orientation, m.conjugate(start.orientation));
    let spin = m.scale(1 / window, m.vectorOf(turn));
    const endSpin = m.applyInverseInertia(predicted.orientation, principal, predicted.angular_momentum);
    if (Math.max(m.norm(endSpin), m.norm(spin)) * window > kFastTurn) spin = endSpin;
    held.angular = spin;
    held.linear = m.scale(1 / window, m.subtract(predicted.position, start.position));
    held.way = window * (m.norm(held.linear) + m.norm(spin) * held.reach);
    held.end = {
      position: predicted.position, orientation: predicted.orientation, velocity: predicted.velocity,
      angular_momentum: predicted.angular_momentum,
    };
  }

  /** Contacts of the window, without those of `solved` bodies. */
  meet(solved) {
    if (this.moving.length === 0) return [];
    if (this.model === null) {
      this.model = new Model(this.mujoco, this.held, [...this.joints.values()]);
      this.solver = new Solver(this.model);
    }
    const ways = this.moving.map((held) => held.way);
    const left = ({ first, second }) => solved.has(first.id) || solved.has(second.id);
    const all = findContacts(this.model, ways, (held) => held.motion, (held) => held.end)
      .filter(({ first, second }) => !this.linked.has(pair(first.id, second.id)));
    this.besideSolved = all.filter(left).flatMap(({ first, second }) => [first, second]);
    const found = all.filter((one) => !left(one));
    for (const one of found) {
      one.law = this.laws.between(one.first.group, one.second.group);
      const speed = (held, local) => (held.slot < 0 ? [0, 0, 0] :
        m.add(held.linear, m.cross(held.angular, armOf(held, local))));
      one.approach = m.dot(one.normal, m.subtract(speed(one.first, one.firstPoint), speed(one.second, one.secondPoint)));
    }
    return found;
  }

  /** A contact for the solver at the present poses, and its gap [m] but for the overlap that stays. */
  place({ first, second, normal, firstPoint, secondPoint, share, law }) {
    const a = m.add(first.at.position, armOf(first, firstPoint)), b = m.add(second.at.position, armOf(second, secondPoint));
    return {
      first, second, normal, point: m.add(m.scale(1 - share, a), m.scale(share, b)), friction: law.friction,
      gap: m.dot(normal, m.subtract(b, a)) + kSlack,
    };
  }

  /** First solve, on the average velocities: contacts may close their gaps. False where nothing changes. */
  solve(window, meetings, joints) {
    const contacts = meetings.map((meeting) => {
      const contact = this.place(meeting);
      meeting.before = contact.gap;
      return { ...contact, target: -Math.max(0, contact.gap) / window };
    });
    const velocity = ({ linear, angular }) => ({ linear, angular });
    const impulses = this.solver.solve(contacts, joints, 1 / window, velocity);
    contacts.forEach(({ acted }, k) => { meetings[k].acted = meetings[k].met = acted; });
    for (const one of meetings) one.bounces = one.acted && one.approach > kImpactSpeed && one.law.restitution > 0;
    const final = this.bounce(window, meetings, contacts, joints, velocity) ?? impulses;
    for (const [held, { linear, angular }] of impulses) {
      const start = held.motion, principal = held.body.principal_inertia, { end } = held;
      const dv = m.scale(1 / held.mass, linear), dw = m.applyInverseInertia(start.orientation, principal, angular);
      // Turn the predicted pose by the difference between two free flights, with and without the change of angular
      // velocity. A turn with constant angular velocity would give energy to a thin shard that an impact sets spinning.
      const without = m.freeTurn(start.orientation, principal, held.angular, window);
      const withIt = m.freeTurn(start.orientation, principal, m.add(held.angular, dw), window);
      held.end = {
        ...end,
        position: m.add(end.position, m.scale(window, dv)),
        orientation: m.normalized(m.multiply(m.multiply(withIt, m.conjugate(without)), end.orientation)),
      };
    }
    for (const [held, { linear, angular }] of final) {
      const { end } = held;
      held.end = {
        ...end, velocity: m.add(end.velocity, m.scale(1 / held.mass, linear)),
        angular_momentum: m.add(end.angular_momentum, angular),
      };
    }
    return impulses.size > 0;
  }

  /** Impulses of the first solve with rebounds, which change velocities and no poses; null where nothing bounces. */
  bounce(window, meetings, contacts, joints, velocity) {
    let any = false;
    const bouncing = contacts.map((contact, k) => {
      const { bounces, approach, law } = meetings[k];
      if (!bounces) return contact;
      any = true;
      return { ...contact, target: law.restitution * approach };
    });
    return any ? this.solver.solve(bouncing, joints, 1 / window, velocity) : null;
  }

  /** Bodies that bounce within the window go on from their touch, as far as they meet nothing else. */
  bounceApart(window, meetings, joints, predicted) {
    if (!meetings.some(({ bounces }) => bounces)) return;
    const bound = new Set([...joints.flatMap(({ first, second }) => [first, second]), ...this.besideSolved]);
    bounceApart(this, window, meetings, (held) => bound.has(held), predicted);
  }

  /** Moves poses out of overlaps. Velocities do not change. */
  push(window, meetings, joints) {
    this.model.place((held) => held.end);
    for (const held of this.moving) held.unturned = held.end.orientation;
    const contacts = meetings.map((meeting) => {
      const contact = this.place(meeting), { gap } = contact, old = Math.max(gap, Math.min(0, meeting.before));
      return { ...contact, friction: 0, target: (gap > 0 ? -gap : old - gap - kPushShare * old) / window };
    });
    if (!contacts.some(({ target }) => target > 0)) return;
    const impulses = this.solver.solve(contacts, joints, 0, () => ({ linear: [0, 0, 0], angular: [0, 0, 0] }));
    for (const held of this.tooFar(contacts, joints, impulses)) impulses.delete(held);
    contacts.forEach(({ acted }, k) => { meetings[k].met ||= acted; });
    for (const [held, { linear, angular }] of impulses) {
      const { end } = held, spin = m.applyInverseInertia(end.orientation, held.body.principal_inertia, angular);
      held.end = {
        ...end,
        position: m.add(end.position, m.scale(window / held.mass, linear)),
        orientation: m.normalized(m.multiply(m.turnOf(m.scale(window, spin)), end.orientation)),
      };
    }
  }

  /** Bodies of the groups in which a push would move one of them too far. */
  tooFar(contacts, joints, impulses) {
    const links = [...contacts, ...joints].map(({ first, second }) => [first, second]);
    const speed = (held) => {
      const { linear, angular } = impulses.get(held) ?? { linear: [0, 0, 0], angular: [0, 0, 0] };
      return m.norm(linear) / held.mass +
        held.reach * m.norm(m.applyInverseInertia(held.end.orientation, held.body.principal_inertia, angular));
    };
    const all = [];
    for (const group of islands(links, (held) => held !== undefined && held.slot >= 0)) {
      const own = new Set(group);
      const most = contacts.reduce((found, { first, second, target }) =>
        (own.has(first) || own.has(second) ? Math.max(found, target) : found), 0);
      if (!group.every((held) => speed(held) <= kMostPush * most)) all.push(...group);
    }
    return all;
  }

  /** Second solve, of velocities only, at the new poses. Contacts that acted or touch now do not close; without it bodies
   * squeezed between shell and floor gain energy. */
  relax(meetings, joints) {
    this.model.place((held) => held.end);
    const contacts = [];
    for (const meeting of meetings) {
      const contact = this.place(meeting);
      if (meeting.acted || contact.gap <= 0) contacts.push({ ...contact, target: 0, meeting });
    }
    const velocity = (held) => ({
      linear: held.end.velocity,
      angular: m.applyInverseInertia(held.end.orientation, held.body.principal_inertia, held.end.angular_momentum),
    });
    const impulses = this.solver.solve(contacts, joints, 0, velocity);
    for (const { meeting, acted } of contacts) meeting.met ||= acted;
    for (const [held, { linear, angular }] of impulses) {
      const { end } = held;
      held.end = {
        ...end, velocity: m.add(end.velocity, m.scale(1 / held.mass, linear)),
        angular_momentum: m.add(end.angular_momentum, angular),
      };
    }
  }
}
