// A Jolt world without gravity, damping or sleep of its own. Lengths and masses are Jolt's (jolt_shapes.mjs).
import { Exit, Failure } from './failure.mjs';
import { kLength, kMass, Shapes } from './jolt_shapes.mjs';

// The build's scratch memory is 10 MB, 472 bytes of it for each contact that there may be.
const kMaxBodies = 65536, kMaxPairs = 131072, kMaxContacts = 12288;
const kVelocitySteps = 20, kPositionSteps = 2; // a stack of twenty 3 mm plates sinks in by 0.2 mm in all at 1 ms
const kCastShare = 0.75; // of a shape's inner radius: what moves further in a window is cast
/** Overlap that is left alone. */
const kSlop = 0.005; // [cm]
/** Contacts are foreseen over the way that bodies may go in a window, within these bounds. */
const kLeastForeseen = 0.02, kMostForeseen = 0.2; // [cm]
const kTouching = 0.005; // [cm]
/** Meeting slower than this is no impact: resting closes with g H per window. */
const kImpactSpeed = 5; // [cm/s]
/** Jolt clamps what is faster, silently; nothing that is solved here comes near. */
const kNoLimit = 1e9;
const kStill = 0, kMoving = 1; // layers

const kOtherPairs = { friction: 0.5, restitution: 0 };

const pair = (a, b) => (a < b ? `${a} ${b}` : `${b} ${a}`); // of bodies, by id

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

    this.laws = new Map(); // of a group: to the other group's coefficients
    this.byPointer = new Map(); // Jolt's body to what add() was given
    this.solved = new Set(); // ids
    this.joints = [];
    this.linked = new Set(); // pairs that go through one another: pair()
    this.contacts = 0;
    this.relaxing = false;
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
      if (this.solved.size && (this.solved.has(a.id) || this.solved.has(b.id))) {
        settings.mIsSensor = true; // somebody else has solved it
        return;
      }
      if (this.linked.size && this.linked.has(pair(a.id, b.id))) {
        settings.mIsSensor = true; // a joint holds them, or did
        return;
      }
      if (this.relaxing && !(a.touched || b.touched)) {
        settings.mIsSensor = true;
        return;
      }
      const law = this.laws.get(a.group)?.get(b.group) ?? kOtherPairs;
      settings.mCombinedFriction = law.friction;
      settings.mCombinedRestitution = this.relaxing ? 0 : law.restitution;
      a.met = a.struck = true;
      b.met = b.struck = true;
    };
    listener.OnContactValidate = () => jolt.ValidateResult_AcceptAllContactsForThisBodyPair;
    listener.OnContactAdded = touch;
    listener.OnContactPersisted = touch;
    listener.OnContactRemoved = () => {};
    return listener;
  }

  setLaws(laws) {
    this.laws.clear();
    const put = (a, b, law) => {
      if (!this.laws.has(a)) this.laws.set(a, new Map());
      this.laws.get(a).set(b, law);
    };
    for (const law of laws) {
      put(law.first_group, law.second_group, law);
      put(law.second_group, law.first_group, law);
    }
  }

  /** `held` is marked with `met` and `struck` in each step in which it has a contact. Returns Jolt's body, which turns
   * about its origin. */
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
        `body ${body.id} '${body.name}': Jolt holds ${kMaxBodies} bodies here, no more`);
    this.byPointer.set(jolt.getPointer(rigid), held);
    this.bodies.AddBody(rigid.GetID(), jolt.EActivation_Activate);
    return rigid;
  }

  /** Contacts and joints of these bodies (ids) are not solved until this is called again. */
  leaveOut(ids) {
    if (ids.length === 0 && this.solved.size === 0) return;
    this.solved = new Set(ids);
    for (const { constraint, ids: ends, holds } of this.joints)
      constraint.SetEnabled(holds && !ends.some((id) => this.solved.has(id)));
  }

  /** These two (ids) go through one another from now on. */
  letThrough(first, second) {
    this.linked.add(pair(first, second));
  }

  /** The joint acts no longer. */
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

  /** Puts a body to a motion's pose with velocities [cm/s, rad/s]. */
  put(rigid, motion, linear, angular) {
    this.place(motion);
    this.linear.Set(...linear);
    this.angular.Set(...angular);
    this.bodies.SetPositionRotationAndVelocity(rigid.GetID(), this.position, this.rotation, this.linear, this.angular);
  }

  /** A body as it is: position, orientation, velocities. */
  read(rigid) {
    const xyz = (v) => [v.GetX(), v.GetY(), v.GetZ()];
    const position = xyz(rigid.GetPosition());
    const q = rigid.GetRotation();
    const orientation = [q.GetW(), q.GetX(), q.GetY(), q.GetZ()];
    const linear = xyz(rigid.GetLinearVelocity()), angular = xyz(rigid.GetAngularVelocity());
    if (![...position, ...orientation, ...linear, ...angular].every(Number.isFinite)) {
      const { id } = this.byPointer.get(this.jolt.getPointer(rigid));
      throw new Failure(Exit.physics, 'diverged', `body ${id}: what Jolt made of its motion is not finite`);
    }
    return { position, orientation, linear, angular };
  }

  /** Finds and solves contacts and joints, and moves. `way`: the furthest that a body may go [cm]. */
  solve(window, way) {
    this.step(window, (settings) => {
      settings.mSpeculativeContactDistance = Math.min(kMostForeseen, Math.max(kLeastForeseen, way));
      settings.mNumPositionSteps = kPositionSteps;
      settings.mLinearCastThreshold = kCastShare;
    });
  }

  /** Solves the velocities of contacts with bodies marked `touched`, at the present poses; what the bodies' poses are
   * afterwards is no matter. */
  relax(window) {
    this.relaxing = true;
    // The next window starts from the impulses of solve(), else stacks collapse.
    this.recorder.Clear();
    this.system.SaveState(this.recorder, this.impulses);
    this.step(window, (settings) => {
      settings.mSpeculativeContactDistance = kTouching; // what comes near later is for the next window
      settings.mNumPositionSteps = 0;
      settings.mLinearCastThreshold = kNoLimit;
    });
    this.relaxing = false;
    this.recorder.Rewind();
    if (!this.system.RestoreState(this.recorder)) throw new Error('Jolt does not take back the contacts that it gave');
  }

  step(window, prepare) {
    const settings = this.system.GetPhysicsSettings();
    prepare(settings);
    settings.mPenetrationSlop = kSlop;
    settings.mNumVelocitySteps = kVelocitySteps;
    settings.mMinVelocityForRestitution = kImpactSpeed;
    settings.mConstraintWarmStart = !this.relaxing; // the impulses of solve() are in the velocities already
    settings.mAllowSleeping = false;
    this.system.SetPhysicsSettings(settings);
    this.contacts = 0;
    this.interface.Step(window, 1);
    if (this.contacts >= kMaxContacts)
      throw new Failure(Exit.physics, 'contacts',
        `more than ${kMaxContacts} contacts in a window, and Jolt drops the others; shorten window_s`);
  }
}
