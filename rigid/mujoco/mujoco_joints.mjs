// Joints. MuJoCo's own equations of a weld hold a place for each; their rows are filled here, so that a ball joint has
// three of them, a hinge five, a slider five and a fixed joint six. Frames are in body coordinates; z is the axis.
import * as m from '../jolt/algebra.mjs';
import { Exit, Failure } from '../jolt/failure.mjs';
import { kLength } from './mujoco_model.mjs';

export const kRows = 6; // of a weld

const kAxes = [[1, 0, 0], [0, 1, 0], [0, 0, 1]];

/** A joint between bodies that are held: `second` is undefined for the world. Throws Failure (bad_joint). */
export function makeJoint(joint, held) {
  const first = held.get(joint.first), second = held.get(joint.second);
  if (first.body.is_static && (!second || second.body.is_static))
    throw new Failure(Exit.badInput, 'bad_joint',
      `joint ${joint.id} '${joint.name}': both bodies are static; name one that moves`);
  return {
    text: jointText(first, second), id: joint.id, kind: joint.kind, first, second, firstFrame: joint.first_frame, secondFrame: joint.second_frame,
    holds: true,
  };
}

/** XML of a joint's place in the model; bodies are named by their ids. */
const jointText = (first, second) =>
  `<weld body1="${first.id}"${second ? ` body2="${second.id}"` : ''} solref="-1 -1" solimp="0.9999 0.9999 0.001 0.5 2"/>\n`;

function placed(held, frame) {
  if (!held) return frame;
  const { position, orientation } = held.at;
  return {
    position: m.add(position, m.rotate(orientation, frame.position)),
    orientation: m.multiply(orientation, frame.orientation),
  };
}

/** What a joint holds at the present poses: axes of the linear and the angular rows, each with the error along it [m,
 * rad], and the point [m] where linear impulses act on both bodies. */
function held(joint) {
  const a = placed(joint.first, joint.firstFrame), b = placed(joint.second, joint.secondFrame);
  const away = m.subtract(b.position, a.position), axis = m.rotate(a.orientation, [0, 0, 1]);
  const across = [[1, 0, 0], [0, 1, 0]].map((v) => m.rotate(a.orientation, v));
  const along = (axes, error) => axes.map((v) => ({ axis: v, error: m.dot(v, error) }));
  const turn = () => m.vectorOf(m.multiply(b.orientation, m.conjugate(a.orientation)));
  const middle = m.scale(0.5, m.add(a.position, b.position));
  switch (joint.kind) {
    case 'BALL': return { linear: along(kAxes, away), angular: [], point: middle };
    case 'HINGE': {
      const tilt = m.cross(axis, m.rotate(b.orientation, [0, 0, 1]));
      return { linear: along(kAxes, away), angular: along(across, tilt), point: middle };
    }
    // the line turns with the first body, so its speed counts where the second one is
    case 'SLIDER': return { linear: along(across, away), angular: along(kAxes, turn()), point: b.position };
    default: return { linear: along(kAxes, away), angular: along(kAxes, turn()), point: middle };
  }
}

/** Fills MuJoCo's rows of all joints of the model; those that are not in `joints` hold nothing. Returns for each row the
 * error [cm, rad]. */
export function fillRows(model, joints) {
  const { data } = model;
  const { efc_J: values, efc_J_rowadr: begins, efc_J_rownnz: counts, efc_J_colind: columns } = data;
  const errors = [];
  const put = (row, body, sign, linear, angular) => {
    if (!body || body.slot < 0) return;
    const local = m.rotate(m.conjugate(body.at.orientation), angular); // MuJoCo has spins in body axes
    const begin = begins[row], end = begin + counts[row];
    for (let k = begin; k < end; ++k) {
      const place = columns[k] - 6 * body.slot;
      if (place >= 0 && place < 6) values[k] = sign * (place < 3 ? linear[place] : local[place - 3]);
    }
  };
  model.joints.forEach((joint, j) => {
    const { linear, angular, point } = joints.includes(joint) ? held(joint) : { linear: [], angular: [] };
    let row = kRows * j;
    for (let i = row; i < row + kRows; ++i) values.fill(0, begins[i], begins[i] + counts[i]);
    const arm = (body, axis) => (body ? m.cross(m.scale(kLength, m.subtract(point, body.at.position)), axis) : null);
    for (const { axis, error } of linear) {
      put(row, joint.second, 1, axis, arm(joint.second, axis));
      put(row++, joint.first, -1, axis, arm(joint.first, axis));
      errors.push(kLength * error);
    }
    for (const { axis, error } of angular) {
      put(row, joint.second, 1, [0, 0, 0], axis);
      put(row++, joint.first, -1, [0, 0, 0], axis);
      errors.push(error);
    }
    while (errors.length < kRows * (j + 1)) errors.push(0); // rows without entries ask for nothing
  });
  return errors;
}
