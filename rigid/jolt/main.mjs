// sunder-rigid-jolt: serves one session with Jolt, as sunder-rigid does with the engines of rigid/engine.
import { Channel } from './channel.mjs';
import { Exit, Failure } from './failure.mjs';
import { JoltEngine } from './jolt_engine.mjs';
import { loadJolt, loadMessages, loadZeroMq } from './packages.mjs';
import { Session } from './session.mjs';

const kUsage = `sunder-rigid-jolt --endpoint ipc://PATH [--engine NAME] [--die-with-parent]
sunder-rigid-jolt --check     says whether it can run
Binds the endpoint, serves one session and ends with it. There is one engine here, whatever NAME is.
Exit status: 0 after a goodbye, 2 bad arguments or bodies, 3 the shell process is lost.
`;
const kParent_ms = 250; // interval of checks for the parent process; a window delays them

function options(argv) {
  const found = { endpoint: '' };
  for (let i = 0; i < argv.length; ++i) {
    const option = argv[i];
    if (option === '--help') found.help = true;
    else if (option === '--check') found.check = true;
    else if (option === '--die-with-parent') found.dieWithParent = true;
    else if (['--endpoint', '--engine'].includes(option) && i + 1 < argv.length) found[option.slice(2)] = argv[++i];
    else throw new Failure(Exit.badInput, 'bad_input', `${option}: unknown option or no value\n${kUsage}`);
  }
  if (!found.help && !found.check && !found.endpoint)
    throw new Failure(Exit.badInput, 'bad_input', `--endpoint is missing\n${kUsage}`);
  return found;
}

function dieWithParent() {
  const parent = process.ppid;
  setInterval(() => {
    if (process.ppid !== parent) process.kill(process.pid, 'SIGTERM');
  }, kParent_ms).unref();
}

async function serve(endpoint) {
  const zmq = await loadZeroMq();
  const channel = await Channel.bind(zmq, endpoint);
  try {
    const session = new Session(new JoltEngine(await loadJolt()), await loadMessages());
    while (!session.over) {
      const reply = session.answer(await channel.receive());
      if (!session.abandoned) await channel.send(reply);
    }
    if (session.failure) throw session.failure;
  } finally {
    channel.close();
  }
}

async function run(argv) {
  const { help, check, endpoint, dieWithParent: watch } = options(argv);
  if (help) return void process.stdout.write(kUsage);
  if (watch) dieWithParent();
  if (!check) return serve(endpoint);
  await loadZeroMq();
  await loadMessages();
  return void new JoltEngine(await loadJolt());
}

try {
  await run(process.argv.slice(2));
} catch (error) {
  const known = error instanceof Failure;
  process.stderr.write(`sunder-rigid-jolt: ${known ? `${error.kind}: ${error.message}` : error.stack}\n`);
  process.exitCode = known ? error.status : Exit.physics;
}
