// Algebra of vectors [x, y, z] and unit quaternions [w, x, y, z], in double precision.

export const add = (a, b) => [a[0] + b[0], a[1] + b[1], a[2] + b[2]];
export const subtract = (a, b) => [a[0] - b[0], a[1] - b[1], a[2] - b[2]];
export const scale = (s, a) => [s * a[0], s * a[1], s * a[2]];
export const norm = (a) => Math.hypot(...a);
export const cross = (a, b) => [a[1] * b[2] - a[2] * b[1], a[2] * b[0] - a[0] * b[2], a[0] * b[1] - a[1] * b[0]];
export const dot = (a, b) => a[0] * b[0] + a[1] * b[1] + a[2] * b[2];

export const conjugate = (q) => [q[0], -q[1], -q[2], -q[3]];

export const multiply = (a, b) => [
  a[0] * b[0] - a[1] * b[1] - a[2] * b[2] - a[3] * b[3],
  a[0] * b[1] + a[1] * b[0] + a[2] * b[3] - a[3] * b[2],
  a[0] * b[2] - a[1] * b[3] + a[2] * b[0] + a[3] * b[1],
  a[0] * b[3] + a[1] * b[2] - a[2] * b[1] + a[3] * b[0],
];

/** Solves a x[0] + b x[1] + c x[2] = d for x; a, b and c are linearly independent. */
export function solve([a, b, c], d) {
  const bc = cross(b, c), volume = dot(a, bc);
  return [dot(d, bc) / volume, dot(a, cross(d, c)) / volume, dot(a, cross(b, d)) / volume];
}

export function normalized(q) {
  const length = Math.hypot(...q);
  return q.map((c) => c / length);
}

export function rotate(q, v) {
  const u = [q[1], q[2], q[3]];
  const t = scale(2, cross(u, v));
  return add(add(v, scale(q[0], t)), cross(u, t));
}

/** Quaternion of the turn by |v| radians about v. */
export function turnOf(v) {
  const angle = norm(v);
  // sin(x/2)/x; for small x its series, because the quotient would lose digits
  const share = angle < 1e-4 ? 0.5 - (angle * angle) / 48 : Math.sin(angle / 2) / angle;
  return [Math.cos(angle / 2), ...scale(share, v)];
}

/** Shortest rotation vector of a unit quaternion [rad]; inverse of turnOf. */
export function vectorOf(q) {
  const s = q[0] < 0 ? -1 : 1;
  const u = [s * q[1], s * q[2], s * q[3]];
  const sine = norm(u);
  return sine === 0 ? [0, 0, 0] : scale((2 * Math.atan2(sine, s * q[0])) / sine, u);
}

/** Inertia, given by principal moments along the body axes, times a vector in world axes. */
export function applyInertia(q, principal, v) {
  const local = rotate(conjugate(q), v);
  return rotate(q, [local[0] * principal[0], local[1] * principal[1], local[2] * principal[2]]);
}

/** Inverse inertia times a vector in world axes. */
export function applyInverseInertia(q, principal, v) {
  const local = rotate(conjugate(q), v);
  return rotate(q, [local[0] / principal[0], local[1] / principal[1], local[2] / principal[2]]);
}

/** Orientation after h seconds of free flight by the midpoint rule; w: angular velocity at the start [rad/s]. */
export function freeTurn(start, principal, w, h) {
  const momentum = applyInertia(start, principal, w);
  const middle = normalized(multiply(turnOf(scale(0.5 * h, w)), start));
  const spin = applyInverseInertia(middle, principal, momentum);
  return normalized(multiply(turnOf(scale(h, spin)), start));
}

/** Two unit vectors across a unit vector. */
export function tangents(n) {
  const least = n.map(Math.abs);
  const k = least.indexOf(Math.min(...least));
  const axis = [0, 0, 0];
  axis[k] = 1;
  const across = cross(n, axis), first = scale(1 / norm(across), across);
  return [first, cross(n, first)];
}
