// Corners of a convex part that may come down on a face of another one in the rest of a window. MuJoCo finds one point for
// a pair of hulls that are apart; a fast body stopped at that point alone would turn through the other one.
import * as m from '../jolt/algebra.mjs';

/** Corners count up to so many times the way of the pair, because a body that is stopped at one corner turns. */
export const kFarther = 4;
/** A corner that moves along the face, or off it, has its foot below it; one that comes down at a larger share of its speed
 * has it where it is going. */
const kSteep = 0.05;
/** A corner that comes down this far beside a face still meets it. */
const kBeside = 5e-5; // [m]

/** Half spaces { normal, offset [m] } whose intersection is a geometry of MuJoCo's, in body coordinates. */
function sides(model, geom) {
  const { model: mj, owner, firstGeom } = model;
  const { box, parts } = owner[geom].body.shape;
  if (box)
    return [0, 1, 2].flatMap((k) => [-1, 1].map((sign) => {
      const normal = [0, 0, 0];
      normal[k] = sign;
      return { normal, offset: box[k] };
    }));
  if (!parts) return [];
  const corners = parts[geom - firstGeom.get(owner[geom])], mesh = mj.geom_dataid[geom];
  const turn = Array.from(mj.geom_quat.subarray(4 * geom, 4 * geom + 4));
  const begin = mj.mesh_polyadr[mesh], end = begin + mj.mesh_polynum[mesh], normals = mj.mesh_polynormal;
  const found = [];
  for (let k = begin; k < end; ++k) {
    const normal = m.rotate(turn, Array.from(normals.subarray(3 * k, 3 * k + 3)));
    found.push({ normal, offset: Math.max(...corners.map((c) => m.dot(normal, c))) });
  }
  return found;
}

/** Sides and corners of a geometry; both are made once for a model. */
function shapeOf(model, geom) {
  model.shapes ??= new Map();
  if (!model.shapes.has(geom)) {
    const held = model.owner[geom], { parts } = held.body.shape;
    const corners = parts ? parts[geom - model.firstGeom.get(held)] : held.corners;
    model.shapes.set(geom, { sides: sides(model, geom), corners });
  }
  return model.shapes.get(geom);
}

const world = (held, local) => m.add(held.at.position, m.rotate(held.at.orientation, local));
const speed = (held, point) => (held.slot < 0 ? [0, 0, 0] :
  m.add(held.linear, m.cross(held.angular, m.subtract(point, held.at.position))));

/** Corners of `geom` that come down on `other`, whose surface has the outward normal `up` at `point` [m]. `way`: how far
 * the two may come towards one another in the window [m]. Returns [{ corner, foot }] [m]. */
export function cornersOver(model, geom, other, up, point, way) {
  const held = model.owner[geom], under = model.owner[other], face = shapeOf(model, other).sides;
  const found = [];
  for (const local of shapeOf(model, geom).corners) {
    const corner = world(held, local), height = m.dot(up, m.subtract(corner, point));
    if (height > kFarther * way) continue;
    const relative = m.subtract(speed(held, corner), speed(under, corner)), closing = -m.dot(up, relative);
    const falls = height > 0 && closing > kSteep * m.norm(relative);
    const meets = falls ? m.add(corner, m.scale(height / closing, relative)) : m.subtract(corner, m.scale(height, up));
    const inside = m.rotate(m.conjugate(under.at.orientation), m.subtract(meets, under.at.position));
    if (face.every(({ normal, offset }) => m.dot(normal, inside) <= offset + kBeside))
      found.push({ corner, foot: m.subtract(corner, m.scale(height, up)) });
  }
  return found;
}
