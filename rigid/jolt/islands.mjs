// Groups of bodies that contacts or joints connect.

/** Bodies for which `moves` holds, grouped: two are in one group where a chain of pairs leads from one to the other. A
 * pair is two bodies, either of which may be undefined, for the world. A body that does not move connects nothing.
 * Groups and their bodies are in the order of the pairs. */
export function islands(pairs, moves) {
  const above = new Map(); // union-find
  const top = (held) => {
    while (above.get(held) !== held) held = above.get(held);
    return held;
  };
  for (const held of pairs.flat()) if (moves(held)) above.set(held, held);
  for (const [first, second] of pairs) if (moves(first) && moves(second)) above.set(top(second), top(first));
  const all = new Map();
  for (const held of above.keys()) all.set(top(held), [...(all.get(top(held)) ?? []), held]);
  return [...all.values()];
}
