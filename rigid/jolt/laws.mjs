// Contact laws between contact groups.

const kOtherPairs = { friction: 0.5, restitution: 0 };

/** What the shell's side says of pairs of contact groups: friction and restitution, in either order. */
export class ContactLaws {
  #of = new Map(); // by contact group: a map from the other group to coefficients

  /** Replaces all laws. */
  set(laws) {
    this.#of.clear();
    const put = (a, b, law) => {
      if (!this.#of.has(a)) this.#of.set(a, new Map());
      this.#of.get(a).set(b, law);
    };
    for (const law of laws) {
      put(law.first_group, law.second_group, law);
      put(law.second_group, law.first_group, law);
    }
  }

  /** Coefficients of a pair of groups, those of the protocol where it has no law. */
  between(a, b) {
    return this.#of.get(a)?.get(b) ?? kOtherPairs;
  }
}
