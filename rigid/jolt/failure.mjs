// Errors that end a session: exit status, kind in one word, and a sentence (coupler/core/error.h).

export const Exit = { done: 0, badInput: 2, peerLost: 3, physics: 4 };

export class Failure extends Error {
  /** `body`: id of the body that it is about; 0: of none. */
  constructor(status, kind, message, body = 0) {
    super(message);
    this.status = status;
    this.kind = kind;
    this.body = body;
  }
}

/** Throws Failure (bad_message): a request is out of order or out of range. */
export function refuse(message) {
  throw new Failure(Exit.peerLost, 'bad_message', message);
}

/** refuse() with message() where `good` is false. */
export function check(good, message) {
  if (!good) refuse(message());
}

/** Throws Failure (bad_body) with id, name and field; `what`: value and remedy. */
export function rejectBody(body, field, what) {
  throw new Failure(Exit.badInput, 'bad_body', `body ${body.id} '${body.name}': ${field} ${what}`, body.id);
}
