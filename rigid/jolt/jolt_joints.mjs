// Makes Jolt's joints. Frames are in body coordinates; z is the axis of a hinge or slider.
import { rotate } from './algebra.mjs';
import { Exit, Failure } from './failure.mjs';
import { kLength } from './jolt_shapes.mjs';

/** Adds the joint and marks its bodies as `jointed`. Throws Failure (bad_joint). */
export function addJoint(world, joint, held) {
  const { jolt } = world;
  const first = held.get(joint.first), second = held.get(joint.second);
  if (first.body.is_static && (!second || second.body.is_static))
    throw new Failure(Exit.badInput, 'bad_joint',
      `joint ${joint.id} '${joint.name}': both bodies are static; name one that moves`);
  // The lever arm of the first body of Jolt's slider is the whole distance slid. In single precision a moving first
  // body leaves the line after some metres, so a static one goes first.
  const ends = [{ held: first, frame: joint.first_frame }, { held: second, frame: joint.second_frame }];
  if (!second || second.body.is_static) ends.reverse();
  const frames = ends.map(({ frame }) => frame);
  const axes = (settings, names, axis) => frames.forEach((frame, i) => {
    const v = new jolt.Vec3(...rotate(frame.orientation, axis));
    settings[names + (i + 1)] = v;
    jolt.destroy(v);
  });
  const points = (settings) => frames.forEach((frame, i) => {
    const p = new jolt.RVec3(...frame.position.map((c) => kLength * c));
    settings['mPoint' + (i + 1)] = p;
    jolt.destroy(p);
  });
  const settings = {
    BALL: () => new jolt.PointConstraintSettings(),
    HINGE: () => {
      const s = new jolt.HingeConstraintSettings();
      axes(s, 'mHingeAxis', [0, 0, 1]), axes(s, 'mNormalAxis', [1, 0, 0]);
      return s;
    },
    SLIDER: () => {
      const s = new jolt.SliderConstraintSettings();
      axes(s, 'mSliderAxis', [0, 0, 1]), axes(s, 'mNormalAxis', [1, 0, 0]);
      return s;
    },
    FIXED: () => {
      const s = new jolt.FixedConstraintSettings();
      axes(s, 'mAxisX', [1, 0, 0]), axes(s, 'mAxisY', [0, 1, 0]);
      return s;
    },
  }[joint.kind]();
  settings.mSpace = jolt.EConstraintSpace_LocalToBodyCOM;
  points(settings);
  const still = world.interface.sGetFixedToWorldBody();
  const constraint = settings.Create(...ends.map(({ held: end }) => end?.rigid ?? still));
  world.system.AddConstraint(constraint);
  world.joints.push({ constraint, id: joint.id, ids: [joint.first, joint.second], holds: true });
  world.letThrough(joint.first, joint.second);
  first.jointed = true;
  if (second) second.jointed = true;
}
