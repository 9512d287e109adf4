// The rigid side of a session: decodes requests, checks their order, asks the engine and encodes replies (as
// coupler/link/session.cpp and host.cpp).
import { check, Exit, Failure, refuse } from './failure.mjs';
import {
  decodeLoad, decodeWindow, encodeStates, integer, kMaxHash, kProtocol, wide,
} from './messages.mjs';

const kNew = 0, kGreeted = 1, kLoaded = 2, kDone = 3;

/** State of one session with an engine. */
export class Session {
  /** `types`: result of loadMessages(). */
  constructor(engine, types) {
    this.engine = engine;
    this.types = types;
    this.state = kNew;
    this.sequence = 0;
    this.tick = 0;
    this.known = new Set(); // ids of bodies
    this.joints = new Set(); // ids of joints
    this.moving = []; // ids of bodies that are not static, ascending
    this.trace = false;
    this.abandoned = false; // true: the other side reported its own failure and reads no reply
    this.failure = null; // error that ended the session; null after Bye
  }

  get over() {
    return this.state === kDone;
  }

  /** Reply to a request, as bytes. Where the request is wrong or the engine fails, the reply is an Error, `failure` has
   * it, and the session is over. */
  answer(bytes) {
    this.spans = [];
    let reply;
    try {
      const request = this.parse(bytes);
      const sequence = integer(request.sequence);
      check(sequence === ++this.sequence, () => `request ${sequence}, expected ${this.sequence}`);
      reply = { ...this.to(request), spans: this.spans };
    } catch (error) {
      // any other error is one in this program or in the engine: tell the other side too
      this.failure = error instanceof Failure
        ? error
        : new Failure(Exit.physics, 'internal', error.stack ?? String(error));
      this.state = kDone;
      const { kind, message, body } = this.failure;
      reply = { error: { kind, message, body } };
    }
    return this.types.Reply.encode({ sequence: this.sequence, ...reply }).finish();
  }

  parse(bytes) {
    try {
      return this.types.Request.decode(bytes);
    } catch {
      return refuse('bytes that are no request');
    }
  }

  timed(name, work) {
    if (!this.trace) return work();
    const begin = process.hrtime.bigint();
    const result = work();
    this.spans.push({ name, begin_ns: wide(begin), end_ns: wide(process.hrtime.bigint()) });
    return result;
  }

  loaded(what) {
    check(this.state === kLoaded, () => `${what} before Load`);
  }

  /** Refuses a request for a capability that the engine does not declare. */
  needs(capability, what) {
    check(this.engine.info.capabilities.includes(capability), () => `${what}: the engine cannot do '${capability}'`);
  }

  /** Refuses a request for a capability that no engine under Node.js has. */
  unable(capability, what) {
    this.loaded(what);
    return refuse(`${what}: the engine cannot do '${capability}'`);
  }

  /** Checks that there is one state for each moving body, by ascending id. */
  match(predicted) {
    let next = 0;
    for (const { id } of predicted) {
      if (next < this.moving.length && id > this.moving[next]) break;
      check(id === this.moving[next],
        () => `predicted state of body ${id}: names no moving body, or comes twice or out of order`);
      ++next;
    }
    check(next === this.moving.length,
      () => `predicted state of body ${this.moving[next]}: is missing; give one for each moving body`);
  }

  add(bodies, what) {
    for (const body of bodies) {
      check(!this.known.has(body.id), () => `${what}[${body.id}]: comes twice, or is held already`);
      this.known.add(body.id);
      if (!body.is_static) this.moving.push(body.id);
      this.engine.add(body);
    }
    this.moving.sort((a, b) => a - b);
  }

  /** The engine's states. Throws Failure (engine_failed) where a number is not finite. */
  states() {
    const states = this.engine.states();
    for (const { id, mass, position, orientation, velocity, angular_momentum: momentum } of states)
      if (![mass, ...position, ...orientation, ...velocity, ...momentum].every(Number.isFinite))
        throw new Failure(Exit.physics, 'engine_failed', `${this.engine.info.name}: body ${id} has a motion that is ` +
          'not finite; are its numbers beyond what the engine can do?', id);
    return states;
  }

  to(request) {
    const { kind } = request;
    check(this.state !== kNew || kind === 'hello' || kind === 'error', () => 'a request before Hello');
    switch (kind) {
      case 'hello': return { hello: this.hello(request.hello) };
      case 'load': return { load: { states: encodeStates(this.load(request.load)) } };
      case 'window': return { window: this.window(request.window) };
      case 'bye':
        this.state = kDone;
        return { bye: {} };
      case 'error':
        this.abandoned = true;
        throw new Failure(Exit.peerLost, 'peer_failed', `the shell process reports: ${request.error.message}`);
      case 'export': return this.unable('export_rows', 'Export');
      case 'save': return this.unable('save_restore', 'Save');
      case 'restore': return this.unable('save_restore', 'Restore');
      case 'add_bodies': return this.unable('save_restore', 'AddBodies'); // sent only in runs that repeat windows
      default: // decoding drops kinds of another protocol
        return refuse('a request without content, or of a kind that is not known here');
    }
  }

  hello(hello) {
    check(this.state === kNew, () => 'a second Hello');
    const { protocol_min: least, protocol_max: most, scene_hash: hash } = hello;
    check(least <= kProtocol && kProtocol <= most,
      () => `protocol ${least} to ${most} asked for, ${kProtocol} is spoken here`);
    check(hash.length <= kMaxHash, () => `hello.scene_hash has ${hash.length} bytes; ${kMaxHash} at most`);
    this.trace = hello.trace;
    this.state = kGreeted;
    const { name, version, capabilities } = this.engine.info;
    return { protocol: kProtocol, engine_name: name, engine_version: version, capabilities, scene_hash: hash };
  }

  load(message) {
    const world = this.timed('decode', () => decodeLoad(message));
    check(this.state !== kLoaded, () => 'a second Load');
    check(Number.isSafeInteger(world.tick) && world.tick >= 0, () => `load.tick is ${world.tick}`);
    if (world.keep_windows) this.needs('save_restore', 'load.keep_windows');
    if (world.joints.length) this.needs('joints', 'load.joints');
    return this.timed('load', () => {
      this.engine.setContactLaws(world.laws);
      this.add(world.bodies, 'bodies');
      for (const joint of world.joints) {
        const { id, first, second } = joint;
        check(!this.joints.has(id), () => `joints[${id}]: comes twice`);
        this.joints.add(id);
        check(this.known.has(first) && (second === 0 || this.known.has(second)) && first !== second,
          () => `joints[${id}]: between bodies ${first} and ${second}, one of which there is not`);
        this.engine.addJoint(joint);
      }
      this.tick = world.tick;
      this.state = kLoaded;
      return this.states();
    });
  }

  window(message) {
    const w = this.timed('decode', () => decodeWindow(message));
    this.loaded('Window');
    check(!w.again, () => 'window.again, and there was none, or none was kept');
    check(w.tick === this.tick && w.ticks >= 1, () => `window at tick ${w.tick} (+${w.ticks}), expected ${this.tick}`);
    check(Number.isSafeInteger(w.tick + w.ticks), () => `window at tick ${w.tick} (+${w.ticks}): too far`);
    check(Number.isFinite(w.window_s) && w.window_s > 0, () => `window_s is ${w.window_s}`);
    this.match(w.predicted);
    for (const id of w.solved) check(this.known.has(id), () => `solved[${id}]: there is no such body`);
    for (const id of w.released) check(this.joints.has(id), () => `released[${id}]: there is no such joint`);
    const states = this.timed('window', () => {
      for (const id of w.released) this.engine.releaseJoint(id);
      this.engine.advance(w.window_s, w.predicted, w.solved);
      this.add(w.births, 'births');
      return this.states();
    });
    this.tick += w.ticks;
    return { tick: this.tick, states: encodeStates(states) };
  }
}
