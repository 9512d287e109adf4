// The program of an engine under Node.js: command line, one session, exit status. `coupler/sunder engine new NAME
// --language node` writes an engine that uses it.
import { Channel } from './channel.mjs';
import { Exit, Failure } from './failure.mjs';
import { loadMessages, loadZeroMq } from './packages.mjs';
import { Session } from './session.mjs';

export { Exit, Failure };

const kParent_ms = 250; // interval of checks for the parent process; a window delays them

const usage = (program) => `${program} --endpoint ipc://PATH [--engine NAME] [--die-with-parent]
${program} --check     says whether it can run
Binds the endpoint, serves one session and ends with it. There is one engine here, whatever NAME is.
Exit status: 0 after a goodbye, 2 bad arguments or bodies, 3 the shell process is lost.
`;

function options(program, argv) {
  const found = { endpoint: '' };
  for (let i = 0; i < argv.length; ++i) {
    const option = argv[i];
    if (option === '--help') found.help = true;
    else if (option === '--check') found.check = true;
    else if (option === '--die-with-parent') found.dieWithParent = true;
    else if (['--endpoint', '--engine'].includes(option) && i + 1 < argv.length) found[option.slice(2)] = argv[++i];
    else throw new Failure(Exit.badInput, 'bad_input', `${option}: unknown option or no value\n${usage(program)}`);
  }
  if (!found.help && !found.check && !found.endpoint)
    throw new Failure(Exit.badInput, 'bad_input', `--endpoint is missing\n${usage(program)}`);
  return found;
}

function dieWithParent() {
  const parent = process.ppid;
  setInterval(() => {
    if (process.ppid !== parent) process.kill(process.pid, 'SIGTERM');
  }, kParent_ms).unref();
}

async function serve(endpoint, make, diesWithParent) {
  const zmq = await loadZeroMq();
  // One that ends with its parent waits for as long as that lives, which watches the other side too.
  const patient = diesWithParent && endpoint.startsWith('ipc://');
  const channel = await Channel.bind(zmq, endpoint, patient ? Infinity : undefined);
  try {
    const session = new Session(await make(), await loadMessages());
    while (!session.over) {
      const reply = session.answer(await channel.receive());
      if (!session.abandoned) await channel.send(reply);
    }
    if (session.failure) throw session.failure;
  } finally {
    channel.close();
  }
}

async function run(program, make, argv) {
  const { help, check, endpoint, dieWithParent: watch } = options(program, argv);
  if (help) return void process.stdout.write(usage(program));
  if (watch) dieWithParent();
  if (!check) return serve(endpoint, make, watch);
  await loadZeroMq();
  await loadMessages();
  return void await make();
}

/** Serves one session with the engine that `make` makes, and sets the exit status. `program`: its name in messages. */
export async function engineMain(program, make, argv = process.argv.slice(2)) {
  try {
    await run(program, make, argv);
  } catch (error) {
    const known = error instanceof Failure;
    process.stderr.write(`${program}: ${known ? `${error.kind}: ${error.message}` : error.stack}\n`);
    process.exitCode = known ? error.status : Exit.physics;
  }
}
