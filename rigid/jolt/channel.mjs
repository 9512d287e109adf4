// Whole messages over a pair of ZeroMQ sockets of this machine; this side binds. A connection within a machine closes
// when its process ends, and never earlier: a process that computes or is stopped is waited for.
import { Exit, Failure, refuse } from './failure.mjs';
import { kMaxMessage } from './messages.mjs';

// Limits that a machine ten times slower than usual does not reach; an end is noticed without them.
const kConnect_s = 120, kSend_ms = 60000, kLinger_ms = 30000;
/** Longest path of a socket [bytes]: sun_path of <sys/un.h> without its last byte. */
const kMostPath = 107;
/** Wait after the end of the connection, so that the other side's last message is still read. */
const kLastWords_ms = 100;

const lost = (message) => new Failure(Exit.peerLost, 'peer_lost', message);

/** A connection to the shell process. */
export class Channel {
  /** Binds an endpoint. The shell process has `connect_s` seconds to come. Throws Failure (bad_input, bad_endpoint). */
  static async bind(zmq, endpoint, connect_s = kConnect_s) {
    if (!endpoint.startsWith('ipc://') && !/^tcp:\/\/127\.0\.0\.1:[0-9]{1,5}$/.test(endpoint))
      throw new Failure(Exit.badInput, 'bad_input',
        `--endpoint ${endpoint}: use ipc://PATH or tcp://127.0.0.1:PORT; beyond this machine nothing is encrypted yet`);
    const bytes = Buffer.byteLength(endpoint) - 'ipc://'.length;
    if (endpoint.startsWith('ipc://') && bytes > kMostPath)
      throw new Failure(Exit.badInput, 'bad_endpoint',
        `--endpoint ${endpoint}: its path has ${bytes} bytes, a socket's at most ${kMostPath}; use a shorter one`);
    const channel = new Channel(new zmq.Pair({
      linger: kLinger_ms, maxMessageSize: kMaxMessage, sendTimeout: kSend_ms,
    }), connect_s);
    try {
      await channel.socket.bind(endpoint);
    } catch (error) {
      channel.close();
      throw new Failure(Exit.badInput, 'bad_endpoint',
        `--endpoint ${endpoint}: ${error.message}; is another run using it, may its folder be written?`);
    }
    return channel;
  }

  constructor(socket, connect_s) {
    this.socket = socket;
    this.isLost = false;
    this.gone = new Promise((_, reject) => {
      let waited_s = 0; // counted, because a timer runs out while this process is stopped
      const unconnected = setInterval(() => {
        if (++waited_s >= connect_s) reject(lost(`the shell process did not connect within ${connect_s} s`));
      }, 1000);
      this.giveUp = () => clearInterval(unconnected);
      let connected = false;
      socket.events.on('handshake', () => {
        connected = true;
        this.giveUp();
      });
      socket.events.on('disconnect', () => {
        if (!connected) return;
        this.isLost = true;
        setTimeout(() => reject(lost('the shell process is gone: its connection closed without a goodbye')), kLastWords_ms);
      });
    });
    this.gone.catch(() => {}); // receive() and send() report it
  }

  /** The next message. Throws Failure: peer_lost, bad_message. */
  async receive() {
    const parts = await Promise.race([this.socket.receive(), this.gone]);
    if (parts.length !== 1) refuse(`a message in ${parts.length} parts`);
    return parts[0];
  }

  /** Sends a message. Throws Failure (peer_lost). */
  async send(bytes) {
    const sent = this.socket.send(bytes).catch(() => {
      throw lost('the shell process takes no messages any more');
    });
    sent.catch(() => {}); // it may fail after `gone` has
    await Promise.race([sent, this.gone]);
  }

  close() {
    this.giveUp();
    if (this.isLost) this.socket.linger = 0; // nobody is there to take the last message
    this.socket.close();
  }
}
