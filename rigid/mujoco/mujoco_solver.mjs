// MuJoCo's Newton solver on velocities. MuJoCo solves for accelerations that bring softly defined motions about. Here one
// "second" is one solution: its accelerations are the changes of velocity, and each contact says with which speed its
// bodies part.
import * as m from '../jolt/algebra.mjs';
import { fillRows, kRows } from './mujoco_joints.mjs';
import { kLength, kMass } from './mujoco_model.mjs';

/** MuJoCo's contacts give way by a share of the unconstrained motion: 1 - 0.9999 of it at the hardest. This share of that
 * is left. */
const kSoftness = 1e-3;
const kImpedance = [0.9999, 0.9999, 0.001, 0.5, 2];
/** MuJoCo's cones lift sliding bodies by (friction x slip). Solutions are repeated with that taken off. */
const kMostPasses = 12;
const kLiftTolerance = 1e-4; // [cm/s]
/** The least of a function is where M a equals the forces of contacts. A search that ends elsewhere leaves a share of them of
 * about 1, one that arrives less than this. */
const kArrived = 1e-2;
/** A search that does not arrive begins again with MuJoCo's own softness, and comes to the wanted one by this factor. */
const kHarder = 10;

/** Contacts and bodies at the poses that Model.place() has set. */
export class Solver {
  constructor(model) {
    this.model = model;
  }

  /** Solves for contacts { first, second: bodies, normal: from the first to the second, point [m], friction, target: least
   * speed of parting [m/s] } and joints (mujoco_joints.mjs); velocity(held): linear [m/s] and angular [rad/s]. `rate`:
   * share of the joints' errors that is undone in a second [1/s]. Sets `acted` of contacts that had an impulse. Returns a
   * map from each body that has one to its impulse and the angular one about its centre [kg m/s, kg m^2/s]. */
  solve(contacts, joints, rate, velocity) {
    const { model } = this;
    const { mujoco, model: mj, data } = model;
    const given = model.moving.map(velocity);
    model.run(() => {
      this.take(contacts);
      this.speeds(given);
      mujoco.mj_makeConstraint(mj, data);
    });
    const errors = fillRows(model, joints);
    const rows = data.efc_R.length, softness = data.efc_R, stiffness = data.efc_D;
    for (let i = 0; i < rows; ++i) softness[i] *= kSoftness, stiffness[i] /= kSoftness;
    model.run(() => {
      mujoco.mj_island(mj, data);
      mujoco.mj_projectConstraint(mj, data);
      mujoco.mj_referenceConstraint(mj, data);
    });
    data.qacc_smooth.fill(0);
    data.qfrc_smooth.fill(0);
    data.qacc_warmstart.fill(0);
    const lifts = new Float64Array(contacts.length);
    let impulses;
    for (let pass = 0; pass < kMostPasses; ++pass) {
      this.ask(contacts, lifts, errors, rate);
      this.search();
      impulses = this.impulses(contacts);
      if (!this.lift(contacts, given, impulses, lifts)) break;
      data.qacc_warmstart.set(data.qacc);
    }
    return impulses;
  }

  /** MuJoCo's Newton search, of each island of bodies by itself. Bodies that jam among others may be too stiff for it: then
   * from soft contacts to hard ones, each search from where the last one arrived. Contacts of an island are as hard as the
   * last that did; none of it act where no search did. */
  search() {
    const { model } = this, { mujoco, model: mj, data } = model;
    const run = () => model.run(() => mujoco.mj_fwdConstraint(mj, data));
    const soften = (factor) => { // MuJoCo has copies by island
      for (const softness of [data.efc_R, data.iefc_R]) for (let i = 0; i < softness.length; ++i) softness[i] *= factor;
      for (const stiffness of [data.efc_D, data.iefc_D]) for (let i = 0; i < stiffness.length; ++i) stiffness[i] /= factor;
    };
    run();
    let open = this.stuck();
    if (open.size === 0) return;
    const results = () => [
      [data.qacc, data.dof_island], [data.qfrc_constraint, data.dof_island], [data.efc_force, data.efc_island],
    ];
    const good = results().map(([values, island]) => values.map((value, i) => (open.has(island[i]) ? 0 : value)));
    let factor = 1 / kSoftness;
    soften(factor);
    // the others begin where they have arrived, and are soon done
    data.qacc.forEach((value, i) => { data.qacc_warmstart[i] = open.has(data.dof_island[i]) ? 0 : value; });
    for (;;) {
      run();
      const stuck = this.stuck();
      open = new Set([...open].filter((island) => !stuck.has(island)));
      results().forEach(([values, island], k) => {
        for (let i = 0; i < values.length; ++i) if (open.has(island[i])) good[k][i] = values[i];
      });
      if (open.size === 0 || factor <= 1) break;
      data.qacc_warmstart.set(data.qacc);
      const next = Math.max(1, factor / kHarder);
      soften(next / factor);
      factor = next;
    }
    soften(1 / factor);
    results().forEach(([values], k) => values.set(good[k]));
  }

  /** The islands in which the last search has not arrived. */
  stuck() {
    const { data, moving } = this.model, { qacc, qfrc_constraint: forces, dof_island: islands } = data;
    const left = new Float64Array(data.nisland), all = new Float64Array(data.nisland);
    moving.forEach((held, k) => {
      const island = islands[6 * k];
      if (island < 0) return;
      const masses = [held.mass, held.mass, held.mass, ...held.body.principal_inertia.map((i) => kLength * kLength * i)];
      masses.forEach((mass, i) => {
        const force = forces[6 * k + i], off = kMass * mass * qacc[6 * k + i] - force;
        left[island] += off * off / mass, all[island] += force * force / mass;
      });
    });
    return new Set([...left.keys()].filter((island) => !(left[island] <= kArrived * kArrived * all[island])));
  }

  /** Gives MuJoCo the contacts. */
  take(contacts) {
    const { model } = this, { mujoco, model: mj, data, scratch, layout } = model;
    mujoco.mj_fwdKinematics(mj, data);
    mujoco.mj_makeM(mj, data);
    mujoco.mj_factorM(mj, data);
    data.ncon = 0;
    const { doubles, integers } = model.memory();
    const real = (name) => (layout.begin + layout[name]) / 8, whole = (name) => (layout.begin + layout[name]) / 4;
    integers.fill(0, layout.begin / 4, (layout.begin + layout.size) / 4);
    doubles.set(kImpedance, real('solimp'));
    doubles.set([-1, -1], real('solref')); // not used: ask() says what is wanted
    integers.fill(-1, whole('geom') + 2, whole('geom') + 8); // no flexible bodies
    let row = kRows * model.joints.length;
    for (const contact of contacts) {
      const { first, second, normal, point, friction } = contact;
      contact.row = row;
      contact.rows = friction > 0 ? 3 : 1;
      row += contact.rows;
      contact.tangents = m.tangents(normal);
      doubles.set(m.scale(kLength, point), real('pos'));
      doubles.set([...normal, ...contact.tangents[0], ...contact.tangents[1]], real('frame'));
      doubles.fill(friction, real('friction'), real('friction') + 5);
      const geoms = [model.firstGeom.get(first), model.firstGeom.get(second)];
      integers.set([contact.rows, ...geoms, ...geoms], whole('dim'));
      mujoco.mj_addContact(mj, data, scratch);
    }
  }

  speeds(given) {
    const { qvel } = this.model.data;
    this.model.moving.forEach((held, k) => {
      const { orientation } = held.at;
      const spin = m.rotate(m.conjugate(orientation), given[k].angular); // MuJoCo has it in body axes
      for (let i = 0; i < 3; ++i) qvel[6 * k + i] = kLength * given[k].linear[i], qvel[6 * k + 3 + i] = spin[i];
    });
  }

  /** Sets the changes of velocity that contacts and joints want. */
  ask(contacts, lifts, errors, rate) {
    const { efc_aref: wanted, efc_vel: speeds } = this.model.data;
    errors.forEach((error, row) => { wanted[row] = -rate * error - speeds[row]; });
    contacts.forEach(({ row, rows, target }, k) => {
      wanted[row] = kLength * target - lifts[k] - speeds[row];
      for (let i = 1; i < rows; ++i) wanted[row + i] = -speeds[row + i];
    });
  }

  impulses(contacts) {
    const { data, moving } = this.model;
    const { qfrc_constraint: all, efc_force: forces } = data;
    const found = new Map();
    moving.forEach((held, k) => {
      const part = Array.from(all.subarray(6 * k, 6 * k + 6));
      if (part.every((c) => c === 0)) return;
      found.set(held, {
        linear: m.scale(1 / (kMass * kLength), part.slice(0, 3)),
        angular: m.scale(1 / (kMass * kLength * kLength), m.rotate(held.at.orientation, part.slice(3))),
      });
    });
    for (const contact of contacts) contact.acted = forces[contact.row] > 0;
    return found;
  }

  /** Sets the lifts of sliding contacts [cm/s]. False where none of them has changed. */
  lift(contacts, given, impulses, lifts) {
    let changed = false;
    const moves = (held, point) => {
      if (held.slot < 0) return [0, 0, 0];
      let { linear, angular } = given[held.slot];
      const { position, orientation } = held.at, got = impulses.get(held);
      if (got) {
        linear = m.add(linear, m.scale(1 / held.mass, got.linear));
        angular = m.add(angular, m.applyInverseInertia(orientation, held.body.principal_inertia, got.angular));
      }
      return m.add(linear, m.cross(angular, m.subtract(point, position)));
    };
    contacts.forEach((contact, k) => {
      const { first, second, point, friction, rows } = contact;
      if (rows === 1) return;
      const slip = m.subtract(moves(second, point), moves(first, point));
      const lift = kLength * friction * Math.hypot(...contact.tangents.map((t) => m.dot(t, slip)));
      if (Math.abs(lift - lifts[k]) > kLiftTolerance) changed = true;
      lifts[k] = lift;
    });
    return changed;
  }
}
