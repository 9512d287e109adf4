// The rigid side of a session: requests in, replies out, in the right order (coupler/link/session.cpp and host.cpp).
import { check, Exit, Failure, refuse } from './failure.mjs';
import {
  decodeBodies, decodeLoad, decodeWindow, encodeStates, integer, kMaxHash, kProtocol, wide,
} from './messages.mjs';

const kNew = 0, kGreeted = 1, kLoaded = 2, kDone = 3;

export class Session {
  /** `types`: loadMessages(). */
  constructor(engine, types) {
    this.engine = engine;
    this.types = types;
    this.state = kNew;
    this.sequence = 0;
    this.tick = 0;
    this.trace = false;
    this.abandoned = false; // the other side said that it failed: there is nobody to answer
    this.failure = null; // what ended the session, unless that was a goodbye
  }

  get over() {
    return this.state === kDone;
  }

  /** The reply to a request, as bytes; where the request is bad or the engine fails it says so, and `failure` too. */
  answer(bytes) {
    this.spans = [];
    let reply;
    try {
      const request = this.parse(bytes);
      const sequence = integer(request.sequence);
      check(sequence === ++this.sequence, () => `request ${sequence}, expected ${this.sequence}`);
      reply = { ...this.to(request), spans: this.spans };
    } catch (error) {
      // not ours: our own mistake or the engine's, the other side hears of it too
      this.failure = error instanceof Failure
        ? error
        : new Failure(Exit.physics, 'internal', error.stack ?? String(error));
      this.state = kDone;
      reply = { error: { kind: this.failure.kind, message: this.failure.message } };
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

  lacks(capability) {
    throw new Failure(Exit.badInput, 'no_capability', `${this.engine.info.name} cannot do '${capability}'`);
  }

  to(request) {
    const { kind } = request;
    check(this.state !== kNew || kind === 'hello' || kind === 'error', () => 'a request before Hello');
    switch (kind) {
      case 'hello': return { hello: this.hello(request.hello) };
      case 'load': return { load: { states: encodeStates(this.load(request.load)) } };
      case 'window': return { window: this.window(request.window) };
      case 'add_bodies': return { add_bodies: { states: encodeStates(this.addBodies(request.add_bodies)) } };
      case 'bye':
        this.state = kDone;
        return { bye: {} };
      case 'error':
        this.abandoned = true;
        throw new Failure(Exit.peerLost, 'peer_failed', `the shell process reports: ${request.error.message}`);
      case 'export':
        this.loaded('Export');
        return this.lacks('export_rows');
      case 'save':
        this.loaded('Save');
        return this.lacks('save_restore');
      case 'restore':
        this.loaded('Restore');
        return this.lacks('save_restore');
      default:
        return refuse('a request without content');
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
    check(!world.keep_windows, () => "load.keep_windows: the engine cannot do 'save_restore'");
    return this.timed('load', () => {
      this.engine.setContactLaws(world.laws);
      const known = new Set();
      for (const body of world.bodies) {
        check(!known.has(body.id), () => `bodies[${body.id}]: comes twice`);
        known.add(body.id);
        this.engine.add(body);
      }
      const joints = new Set();
      for (const joint of world.joints) {
        const { id, first, second } = joint;
        check(!joints.has(id), () => `joints[${id}]: comes twice`);
        joints.add(id);
        check(known.has(first) && (second === 0 || known.has(second)) && first !== second,
          () => `joints[${id}]: between bodies ${first} and ${second}, one of which there is not`);
        this.engine.addJoint(joint);
      }
      this.tick = world.tick;
      this.state = kLoaded;
      return this.engine.states();
    });
  }

  window(message) {
    const w = this.timed('decode', () => decodeWindow(message));
    this.loaded('Window');
    check(!w.again, () => 'window.again, and there was none, or none was kept');
    check(w.tick === this.tick && w.ticks >= 1, () => `window at tick ${w.tick} (+${w.ticks}), expected ${this.tick}`);
    check(Number.isSafeInteger(w.tick + w.ticks), () => `window at tick ${w.tick} (+${w.ticks}): too far`);
    check(Number.isFinite(w.window_s) && w.window_s > 0, () => `window_s is ${w.window_s}`);
    const states = this.timed('window', () => {
      this.engine.advance(w.window_s, w.handbacks, w.solved);
      for (const body of w.births) this.engine.add(body);
      return this.engine.states();
    });
    this.tick += w.ticks;
    return { tick: this.tick, states: encodeStates(states) };
  }

  addBodies(message) {
    const bodies = decodeBodies(message.bodies, 'bodies');
    this.loaded('AddBodies');
    const ids = new Set();
    for (const body of bodies) {
      this.engine.add(body);
      ids.add(body.id);
    }
    return this.engine.states().filter((s) => ids.has(s.id));
  }
}
