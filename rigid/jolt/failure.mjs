// What ends a session: exit status, one word for the kind, and a sentence (coupler/core/error.h).

export const Exit = { done: 0, badInput: 2, peerLost: 3, physics: 4 };

export class Failure extends Error {
  constructor(status, kind, message) {
    super(message);
    this.status = status;
    this.kind = kind;
  }
}

/** The other side spoke out of turn or out of range. */
export function refuse(message) {
  throw new Failure(Exit.peerLost, 'bad_message', message);
}

export function check(good, message) {
  if (!good) refuse(message());
}

export function rejectBody(body, field, what) {
  throw new Failure(Exit.badInput, 'bad_body', `body ${body.id} '${body.name}': ${field} ${what}`);
}
