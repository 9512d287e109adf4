// The shell side of sessions, for tests. A line of JSON on standard input is a request, a line on standard output is its
// reply. Instead of a request: {"raw": TEXT} sends these bytes, {"silent": REQUEST} waits for no reply, and
// {"anew": true} begins another session where there is no socket. Numbers that JSON lacks are strings, as "NaN". The
// reply {"lost": true} means that the other side is gone. Arguments: name of the engine, and an endpoint. Without an
// endpoint sessions are in this process, and their replies have `ends_with`, the exit status of a server.
import { createInterface } from 'node:readline';

import { JoltEngine } from '../../rigid/jolt/jolt_engine.mjs';
import { loadJolt, loadMessages, loadMuJoCo, loadZeroMq } from '../../rigid/jolt/packages.mjs';
import { Session } from '../../rigid/jolt/session.mjs';
import { MuJoCoEngine } from '../../rigid/mujoco/mujoco_engine.mjs';

const makers = {
  jolt: async () => {
    const module = await loadJolt();
    return () => new JoltEngine(module);
  },
  mujoco: async () => {
    const module = await loadMuJoCo();
    return () => new MuJoCoEngine(module);
  },
};
const [name, endpoint] = process.argv.slice(2);
const { Request, Reply } = await loadMessages();
const plain = { longs: Number, defaults: true, oneofs: true, bytes: String };
const decode = (bytes) => Reply.toObject(Reply.decode(bytes), plain);

async function connected() {
  const zmq = await loadZeroMq();
  const socket = new zmq.Pair({ linger: 500, sendTimeout: 2000 });
  const gone = new Promise((done) => {
    let known = false;
    socket.events.on('handshake', () => { known = true; });
    // its last messages are read first
    socket.events.on('disconnect', () => known && setTimeout(done, 100, null));
  });
  socket.connect(endpoint);
  return {
    tell: (bytes) => socket.send(bytes),
    hear: async () => {
      const parts = await Promise.race([socket.receive(), gone]);
      return parts ? decode(parts[0]) : { lost: true };
    },
    close: () => socket.close(),
  };
}

async function within() {
  const make = await makers[name]();
  const types = { Request, Reply };
  let engine, session, reply;
  const anew = () => {
    engine?.close();
    engine = make();
    session = new Session(engine, types);
  };
  anew();
  return {
    anew,
    tell: (bytes) => { reply = decode(session.answer(bytes)); },
    hear: () => ({ ...reply, ends_with: session.failure?.status ?? 0 }),
    close: () => engine.close(),
  };
}

const other = endpoint ? await connected() : await within();
let sequence = 0;
for await (const line of createInterface({ input: process.stdin })) {
  const asked = JSON.parse(line);
  if (asked.anew) {
    other.anew();
    sequence = 0;
    continue;
  }
  const request = asked.silent ?? asked;
  const bytes = request.raw !== undefined
    ? Buffer.from(request.raw, 'latin1')
    : Request.encode(Request.fromObject({ sequence: ++sequence, ...request })).finish();
  await other.tell(bytes);
  if (!asked.silent) process.stdout.write(`${JSON.stringify(await other.hear())}\n`);
}
other.close();
