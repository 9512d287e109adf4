// Compiles bodies into a MuJoCo model. Its models have a fixed size, so it is compiled anew when bodies come. Nothing is
// lost by that: the adapter keeps all motions, and MuJoCo's solver starts each window from nothing.
import { Exit, Failure, rejectBody } from '../jolt/failure.mjs';

/** Units in MuJoCo: lengths in cm, masses in g. It refuses masses and inertias below 1e-15 of its unit, and shards weigh
 * grams. */
export const kLength = 100; // [1/m]
export const kMass = 1000; // [1/kg]

/** Memory for contacts and their equations, about 2 kB each. It grows in steps, so that models which follow one another fit
 * in the place of the last one. */
const kArena_MB = 128, kBodiesOfArena = 1000;
/** Bytes of integers behind the arrays of a contact: exclude and efc_address. */
const kContactTail = 8;
const kDouble = 8, kInteger = 4;
/** MuJoCo's compiler: a part of less volume is flat. */
const kFlatShare = 1e-12; // of (diagonal of its bounds)^3

const kHead = (memory_MB) => `<mujoco>
<compiler angle="radian" autolimits="false" inertiafromgeom="false" fusestatic="false"/>
<option timestep="1" gravity="0 0 0" cone="elliptic" solver="Newton" jacobian="sparse" iterations="100" tolerance="1e-16"
  ls_iterations="100" ls_tolerance="1e-8" impratio="1" ccd_tolerance="1e-8" ccd_iterations="100"/>
<size memory="${Math.ceil(memory_MB)}M"/>
`;

const numbers = (values) => values.join(' ');
const lengths = (values) => numbers(values.map((v) => kLength * v));

/** XML of a body's meshes and of the body itself. */
function texts(body) {
  const { sphere, box, half_space: halfSpace, parts } = body.shape;
  const { position, orientation } = body.motion;
  let meshes = '', geoms;
  if (sphere) geoms = `<geom type="sphere" size="${kLength * sphere}"/>`;
  else if (box) geoms = `<geom type="box" size="${lengths(box)}"/>`;
  else if (halfSpace) geoms = '<geom type="plane" size="1 1 1" contype="0" conaffinity="0"/>'; // mujoco_planes.mjs
  else {
    const name = (k) => `${body.id}_${k}`;
    meshes = parts.map((part, k) =>
      `<mesh name="${name(k)}" inertia="convex" vertex="${part.map(lengths).join(' ')}"/>\n`).join('');
    geoms = parts.map((_, k) => `<geom type="mesh" mesh="${name(k)}"/>`).join('');
  }
  const moving = body.is_static ? '' : '<freejoint/><inertial pos="0 0 0" mass="1" diaginertia="1 1 1"/>';
  return {
    meshes, body: `<body name="${body.id}" pos="${lengths(position)}" quat="${numbers(orientation)}">${moving}${geoms}</body>\n`,
  };
}

const compile = (mujoco, all, joints, memory_MB) => mujoco.MjModel.from_xml_string(
  `${kHead(memory_MB)}<asset>\n${all.map((t) => t.meshes).join('')}</asset>\n<worldbody>\n${
    all.map((t) => t.body).join('')}</worldbody>\n<equality>\n${joints.join('')}</equality>\n</mujoco>\n`);

/** Volume of the hull of a compiled mesh, and the diagonal of its bounds, in MuJoCo's units. */
function measure(model, mesh) {
  const vertices = model.mesh_vert, faces = model.mesh_face;
  const first = model.mesh_vertadr[mesh], count = model.mesh_vertnum[mesh];
  const at = (i) => vertices.subarray(3 * (first + i), 3 * (first + i) + 3);
  const least = [Infinity, Infinity, Infinity], most = [-Infinity, -Infinity, -Infinity];
  for (let i = 0; i < count; ++i)
    at(i).forEach((c, k) => { least[k] = Math.min(least[k], c), most[k] = Math.max(most[k], c); });
  let volume = 0;
  const begin = model.mesh_faceadr[mesh], end = begin + model.mesh_facenum[mesh];
  for (let f = begin; f < end; ++f) {
    const [a, b, c] = [0, 1, 2].map((k) => at(faces[3 * f + k]));
    volume += (a[0] * (b[1] * c[2] - b[2] * c[1]) + a[1] * (b[2] * c[0] - b[0] * c[2]) +
      a[2] * (b[0] * c[1] - b[1] * c[0])) / 6;
  }
  return { volume: Math.abs(volume), diagonal: Math.hypot(...most.map((c, k) => c - least[k])) };
}

/** The texts of a body for Model. Throws Failure (bad_body) where MuJoCo cannot hold it. */
export function prepare(mujoco, body) {
  const { half_space: halfSpace, parts } = body.shape;
  if (halfSpace && !body.is_static) rejectBody(body, 'shape', 'is a half space that moves; make it static or use a box');
  const text = texts(body);
  if (!parts) return text;
  const refuse = (index, said) => rejectBody(body, `shape.parts[${index}]`,
    `is no hull (${parts[index].length} corners): ${said}; leave flat parts out, thin fine ones`);
  let alone = null;
  try {
    alone = compile(mujoco, [text], [], 1);
    parts.forEach((_, k) => {
      const { volume, diagonal } = measure(alone, k);
      if (!(volume > kFlatShare * diagonal ** 3)) refuse(k, 'it is flat');
    });
  } catch (error) {
    if (error instanceof Failure) throw error;
    const said = String(error.message ?? error).split('\n')[0];
    const which = parts.findIndex((_, k) => said.includes(`${body.id}_${k}`));
    refuse(Math.max(which, 0), said);
  } finally {
    alone?.delete();
  }
  return text;
}

/** Places of the members of MuJoCo's contact [bytes from its begin], read from the views that its bindings give. */
function contactLayout(contact) {
  const begin = contact.pos.byteOffset - kDouble; // `dist` comes first
  const at = (view) => view.byteOffset - begin;
  const layout = {
    dist: 0, pos: at(contact.pos), frame: at(contact.frame), friction: at(contact.friction), solref: at(contact.solref),
    solimp: at(contact.solimp), geom: at(contact.geom), begin,
    size: Math.ceil((at(contact.vert) + 2 * kInteger + kContactTail) / kDouble) * kDouble,
  };
  layout.dim = layout.geom - 3 * kInteger; // then geom1 and geom2
  return layout;
}

/** A compiled model of bodies (`held` of mujoco_engine.mjs, each with `text` of prepare()) and joints of
 * mujoco_joints.mjs. */
export class Model {
  constructor(mujoco, all, joints) {
    this.mujoco = mujoco;
    this.joints = joints;
    this.moving = all.filter(({ body }) => !body.is_static);
    this.model = compile(mujoco, all.map((held) => held.text), joints.map((joint) => joint.text),
      kArena_MB * Math.ceil((all.length + 1) / kBodiesOfArena));
    this.data = new mujoco.MjData(this.model);
    this.scratch = new mujoco.MjContact();
    this.option = this.model.opt; // these two are parts of theirs: to delete them deletes the parts
    this.warnings = this.data.warning;
    const masses = this.model.body_mass, inertias = this.model.body_inertia;
    all.forEach((held, k) => { // MuJoCo's body 0 is the world
      held.slot = -1;
      held.at = held.motion;
      if (held.body.is_static) return;
      masses[k + 1] = kMass * held.mass;
      inertias.set(held.body.principal_inertia.map((i) => kMass * kLength * kLength * i), 3 * (k + 1));
    });
    this.moving.forEach((held, k) => { held.slot = k; });
    mujoco.mj_setConst(this.model, this.data);
    this.bodies = [null, ...all]; // by MuJoCo's index
    this.owner = Array.from(this.model.geom_bodyid, (b) => this.bodies[b]); // by geom
    this.firstGeom = new Map(all.map((held, k) => [held, this.model.body_geomadr[k + 1]]));
    this.layout = contactLayout(this.scratch);
    this.contacts = this.findContacts();
  }

  /** Address of MuJoCo's contacts, checked with two of them. Its bindings give copies. */
  findContacts() {
    const { mujoco, model, data, scratch, layout } = this;
    data.ncon = 0;
    for (const dist of [-1, -2]) {
      scratch.dist = dist;
      mujoco.mj_addContact(model, data, scratch);
    }
    const address = data.arena.byteOffset, { doubles } = this.memory();
    const good = doubles[address / kDouble] === -1 && doubles[(address + layout.size) / kDouble] === -2;
    data.ncon = 0;
    if (!good)
      throw new Failure(Exit.badInput, 'bad_engine', `MuJoCo ${mujoco.mj_versionString()} keeps its contacts in a way ` +
        'that is not known here; the version of rigid/jolt/package-lock.json is right');
    return address;
  }

  close() {
    this.scratch.delete();
    this.data.delete();
    this.model.delete();
  }

  /** The memory as doubles and integers. It may move whenever MuJoCo is called. */
  memory() {
    const { buffer } = this.data.qpos;
    return { doubles: new Float64Array(buffer), integers: new Int32Array(buffer) };
  }

  /** Sets the pose of every moving body, also as its `at`; pose(held): position [m] and orientation. */
  place(pose) {
    const { qpos } = this.data;
    this.moving.forEach((held, k) => {
      held.at = pose(held);
      const { position, orientation } = held.at;
      for (let i = 0; i < 3; ++i) qpos[7 * k + i] = kLength * position[i];
      for (let i = 0; i < 4; ++i) qpos[7 * k + 3 + i] = orientation[i];
    });
  }

  /** Lets MuJoCo work. Throws Failure (contacts) where its memory ends; it would drop the contacts beyond. */
  run(work) {
    const { mjtWarning } = this.mujoco;
    const tooMany = () => new Failure(Exit.physics, 'contacts',
      `more contacts in a window than MuJoCo has room for (${this.data.ncon} found); shorten window_s`);
    try {
      work();
    } catch (error) {
      throw /out of memory/.test(error.message) ? tooMany() : error;
    }
    for (const kind of [mjtWarning.mjWARN_CONTACTFULL, mjtWarning.mjWARN_CNSTRFULL]) {
      const one = this.warnings.get(kind.value), full = one.number > 0;
      one.delete();
      if (full) throw tooMany();
    }
  }
}
