// A Jolt world without gravity, damping and sleeping. Lengths and masses are in Jolt's units (jolt_shapes.mjs).
import * as m from './algebra.mjs';
import { Exit, Failure } from './failure.mjs';
import { kLength, kMass, Shapes } from './jolt_shapes.mjs';
import { ContactLaws } from './laws.mjs';

// Limits: Jolt's scratch memory of 10 MB holds 472 bytes for each possible contact.
const kMaxBodies = 65536, kMaxPairs = 131072, kMaxContacts = 12288;
const kVelocitySteps = 20, kPositionSteps = 2;
const kCastShare = 0.75; // a body that moves by more than this share of its inner radius in a window is cast
/** Overlap that stays. */
const kSlop = 0.005; // [cm]
/** Bounds of the gap up to which contacts are found. Between them it is the farthest distance of a body in a window. */
const kLeastForeseen = 0.02, kMostForeseen = 0.2; // [cm]
const kTouching = 0.005; // [cm]
/** Contacts that close more slowly do not bounce: a resting body closes with g H per window. */
const kImpactSpeed = 5; // [cm/s]
/** Jolt clamps larger speeds without a message; bodies here are far slower. */
const kNoLimit = 1e9;
const kStill = 0, kMoving = 1; // layers

const xyz = (v) => [v.GetX(), v.GetY(), v.GetZ()];

/** Key of a pair of bodies, in either order. */
const pair = (a, b) => (a < b ? `${a} ${b}` : `${b} ${a}`);

/** Finds and solves contacts and joints, and moves bodies. */
export class World {
  constructor(jolt) {
    this.jolt = jolt;
    this.shapes = new Shapes(jolt);
    const settings = new jolt.JoltSettings();
    settings.mMaxBodies = kMaxBodies;
    settings.mMaxBodyPairs = kMaxPairs;
    settings.mMaxContactConstraints = kMaxContacts;
    settings.mMaxWorkerThreads = 0;
    const pairs = new jolt.ObjectLayerPairFilterTable(2);
    pairs.EnableCollision(kStill, kMoving);
    pairs.EnableCollision(kMoving, kMoving);
    const layers = new jolt.BroadPhaseLayerInterfaceTable(2, 2);
    for (const layer of [kStill, kMoving]) layers.MapObjectToBroadPhaseLayer(layer, new jolt.BroadPhaseLayer(layer));
    settings.mObjectLayerPairFilter = pairs;
    settings.mBroadPhaseLayerInterface = layers;
    settings.mObjectVsBroadPhaseLayerFilter = new jolt.ObjectVsBroadPhaseLayerFilterTable(layers, 2, pairs, 2);
    this.interface = new jolt.JoltInterface(settings);
    jolt.destroy(settings);
    this.system = this.interface.GetPhysicsSystem();
    this.bodies = this.system.GetBodyInterfaceNoLock();
    this.position = new jolt.RVec3(0, 0, 0);
    this.rotation = new jolt.Quat(0, 0, 0, 1);
    this.linear = new jolt.Vec3(0, 0, 0);
    this.angular = new jolt.Vec3(0, 0, 0);
    this.system.SetGravity(this.linear);

    this.laws = new ContactLaws();
    this.byPointer = new Map(); // from Jolt's body to the argument of add()
    this.solved = new Set(); // ids of bodies whose contacts are left out
    this.joints = [];
    this.linked = new Set(); // pairs that do not collide: pair()
    this.contacts = 0;
    this.relaxing = false;
    this.bouncing = null; // in bounce(): the pairs that it solves, by pair()
    this.seen = []; // contacts of the last solve()
    this.recorder = new jolt.StateRecorderImpl();
    this.impulses = jolt.EStateRecorderState_Contacts | jolt.EStateRecorderState_Constraints;
    this.system.SetContactListener(this.listener());
  }

  close() {
    this.jolt.destroy(this.interface);
  }

  /** Sets the coefficients of every contact, and marks the bodies that have one. */
  listener() {
    const { jolt, byPointer } = this;
    const listener = new jolt.ContactListenerJS();
    const touch = (first, second, manifold, pointer) => {
      const a = byPointer.get(first), b = byPointer.get(second);
      const settings = jolt.wrapPointer(pointer, jolt.ContactSettings);
      ++this.contacts;
      if (this.bouncing !== null) {
        settings.mIsSensor = !this.bouncing.has(pair(a.id, b.id));
        if (!settings.mIsSensor) this.applyLaw(settings, a, b);
        return;
      }
      if (this.solved.size && (this.solved.has(a.id) || this.solved.has(b.id))) {
        settings.mIsSensor = true; // the shell process has solved it
        return;
      }
      if (this.linked.size && this.linked.has(pair(a.id, b.id))) {
        settings.mIsSensor = true; // a joint links them, or did
        return;
      }
      if (this.relaxing && !(a.touched || b.touched)) {
        settings.mIsSensor = true;
        return;
      }
      const law = this.applyLaw(settings, a, b);
      if (this.relaxing) settings.mCombinedRestitution = 0;
      else this.note(a, b, law.restitution, jolt.wrapPointer(manifold, jolt.ContactManifold));
      a.met = a.struck = true;
      b.met = b.struck = true;
    };
    listener.OnContactValidate = () => jolt.ValidateResult_AcceptAllContactsForThisBodyPair;
    listener.OnContactAdded = touch;
    listener.OnContactPersisted = touch;
    listener.OnContactRemoved = () => {};
    return listener;
  }

  applyLaw(settings, a, b) {
    const law = this.laws.between(a.group, b.group);
    settings.mCombinedFriction = law.friction;
    settings.mCombinedRestitution = law.restitution;
    return law;
  }

  /** Keeps the points of a contact of two bodies: the normal from the first to the second, a place on the first, the gap
   * [m]. */
  note(first, second, restitution, manifold) {
    const normal = xyz(manifold.mWorldSpaceNormal), count = manifold.mRelativeContactPointsOn1.size();
    for (let i = 0; i < count; ++i) {
      const on = xyz(manifold.GetWorldSpaceContactPointOn1(i)), to = xyz(manifold.GetWorldSpaceContactPointOn2(i));
      const gap = m.dot(normal, m.subtract(to, on)) / kLength;
      this.seen.push({ first, second, restitution, normal, point: m.scale(1 / kLength, on), gap });
    }
  }

  /** Replaces all contact laws. */
  setLaws(laws) {
    this.laws.set(laws);
  }

  /** Adds a body and returns Jolt's one, whose origin is its centre of mass. A step marks `held` as `met` and `struck`
   * where the body has a contact. Throws Failure (bad_body) above kMaxBodies. */
  add(held, body, shape) {
    const { jolt } = this;
    this.place(body.motion);
    const settings = new jolt.BodyCreationSettings(shape, this.position, this.rotation,
      body.is_static ? jolt.EMotionType_Static : jolt.EMotionType_Dynamic, body.is_static ? kStill : kMoving);
    if (!body.is_static) {
      settings.mOverrideMassProperties = jolt.EOverrideMassProperties_MassAndInertiaProvided;
      const mass = settings.mMassPropertiesOverride;
      mass.mMass = kMass * body.mass;
      const moments = body.principal_inertia.map((i) => kMass * kLength * kLength * i);
      this.linear.Set(...moments);
      mass.mInertia = jolt.Mat44.prototype.sScaleVec3(this.linear);
      settings.mLinearDamping = 0;
      settings.mAngularDamping = 0;
      settings.mGravityFactor = 0;
      settings.mMaxLinearVelocity = kNoLimit;
      settings.mMaxAngularVelocity = kNoLimit;
      settings.mAllowSleeping = false;
      settings.mMotionQuality = jolt.EMotionQuality_LinearCast;
    }
    const rigid = this.bodies.CreateBody(settings);
    jolt.destroy(settings);
    if (jolt.getPointer(rigid) === 0)
      throw new Failure(Exit.badInput, 'bad_body',
        `body ${body.id} '${body.name}': Jolt holds ${kMaxBodies} bodies here, no more`, body.id);
    this.byPointer.set(jolt.getPointer(rigid), held);
    this.bodies.AddBody(rigid.GetID(), jolt.EActivation_Activate);
    return rigid;
  }

  /** Leaves out contacts and joints of these bodies (ids) until the next call. */
  leaveOut(ids) {
    if (ids.length === 0 && this.solved.size === 0) return;
    this.solved = new Set(ids);
    for (const { constraint, ids: ends, holds } of this.joints)
      constraint.SetEnabled(holds && !ends.some((id) => this.solved.has(id)));
  }

  /** From now on these two bodies (ids) do not collide. */
  letThrough(first, second) {
    this.linked.add(pair(first, second));
  }

  /** Stops a joint for good. */
  release(id) {
    const joint = this.joints.find((one) => one.id === id);
    joint.holds = false;
    joint.constraint.SetEnabled(false);
  }

  place(motion) {
    const [x, y, z] = motion.position, [qw, qx, qy, qz] = motion.orientation;
    this.position.Set(kLength * x, kLength * y, kLength * z);
    this.rotation.Set(qx, qy, qz, qw);
  }

  /** Sets a body's pose to that of `motion`, and its velocities [cm/s, rad/s]. */
  put(rigid, motion, linear, angular) {
    this.place(motion);
    this.linear.Set(...linear);
    this.angular.Set(...angular);
    this.bodies.SetPositionRotationAndVelocity(rigid.GetID(), this.position, this.rotation, this.linear, this.angular);
  }

  /** Position [cm], orientation and velocities of a body. Throws Failure (diverged) where they are not finite. */
  read(rigid) {
    const position = xyz(rigid.GetPosition());
    const q = rigid.GetRotation();
    const orientation = [q.GetW(), q.GetX(), q.GetY(), q.GetZ()];
    const linear = xyz(rigid.GetLinearVelocity()), angular = xyz(rigid.GetAngularVelocity());
    if (![...position, ...orientation, ...linear, ...angular].every(Number.isFinite)) {
      const { id } = this.byPointer.get(this.jolt.getPointer(rigid));
      throw new Failure(Exit.physics, 'diverged', `body ${id}: what Jolt made of its motion is not finite`, id);
    }
    return { position, orientation, linear, angular };
  }

  /** Finds and solves contacts and joints, and moves the bodies. `way`: farthest motion of a body in the window [cm]. */
  solve(window, way) {
    this.seen = [];
    this.step(window, (settings) => {
      settings.mSpeculativeContactDistance = Math.min(kMostForeseen, Math.max(kLeastForeseen, way));
      settings.mNumPositionSteps = kPositionSteps;
      settings.mLinearCastThreshold = kCastShare;
    });
  }

  /** Solves velocities at the present poses, for contacts of bodies marked `touched`. Jolt moves the bodies as well;
   * the caller ignores these poses. */
  relax(window) {
    this.relaxing = true;
    this.stepAside(window);
    this.relaxing = false;
  }

  /** Solves velocities at the present poses, with restitution, for contacts of these pairs of bodies alone. */
  bounce(window, pairs) {
    this.bouncing = new Set(pairs.map(([first, second]) => pair(first.id, second.id)));
    this.stepAside(window);
    this.bouncing = null;
  }

  /** A step whose impulses are forgotten: the next window must start from those of solve(), or stacks collapse. */
  stepAside(window) {
    this.recorder.Clear();
    this.system.SaveState(this.recorder, this.impulses);
    this.step(window, (settings) => {
      settings.mSpeculativeContactDistance = kTouching; // no look-ahead: later contacts belong to the next window
      settings.mNumPositionSteps = 0;
      settings.mLinearCastThreshold = kNoLimit;
    });
    this.recorder.Rewind();
    if (!this.system.RestoreState(this.recorder)) throw new Error('Jolt does not take back the contacts that it gave');
  }

  step(window, prepare) {
    const settings = this.system.GetPhysicsSettings();
    prepare(settings);
    settings.mPenetrationSlop = kSlop;
    settings.mNumVelocitySteps = kVelocitySteps;
    settings.mMinVelocityForRestitution = kImpactSpeed;
    settings.mConstraintWarmStart = !this.relaxing && this.bouncing === null; // velocities include the impulses of solve()
    settings.mAllowSleeping = false;
    this.system.SetPhysicsSettings(settings);
    this.contacts = 0;
    this.interface.Step(window, 1);
    if (this.contacts >= kMaxContacts)
      throw new Failure(Exit.physics, 'contacts',
        `more than ${kMaxContacts} contacts in a window, and Jolt drops the others; shorten window_s`);
  }
}
