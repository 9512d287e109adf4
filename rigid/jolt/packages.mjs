// Loads the packages of package-lock.json from the folder where coupler/sunder_tools/launch/node.py unpacks them.
import { existsSync, readFileSync } from 'node:fs';
import { createRequire } from 'node:module';
import { homedir } from 'node:os';
import { dirname, join, resolve } from 'node:path';
import { fileURLToPath, pathToFileURL } from 'node:url';

import { Exit, Failure } from './failure.mjs';

const repository = join(dirname(fileURLToPath(import.meta.url)), '..', '..');
const installed = existsSync(join(repository, 'coupler', 'VERSION')); // else a checkout, as in coupler/sunder_tools/places.py
const work = installed ? join(process.env.XDG_CACHE_HOME || join(homedir(), '.cache'), 'sunder') : join(repository, 'build');

/** The first place where coupler/sunder_tools/places.py (npm_folder) looks and finds the packages of package-lock.json. */
function packageFolder() {
  const build = process.env.SUNDER_BUILD_DIR;
  const places = (build ? [build, join(build, '..'), work] : [work]).map((place) => join(place, 'node'));
  const wanted = readFileSync(join(repository, 'rigid', 'jolt', 'package-lock.json'));
  const has = (place) => existsSync(join(place, 'package-lock.json')) && wanted.equals(readFileSync(join(place, 'package-lock.json')));
  return join(places.find(has) ?? places[0], 'node_modules');
}

const folder = resolve(packageFolder());
const require = createRequire(join(folder, 'none.cjs'));

/** Exports of a package. Throws Failure (no_package) where it is missing or does not run on this machine. */
async function load(name, entry) {
  try {
    if (!existsSync(join(folder, name))) throw new Error('there is no such folder');
    return entry ? await import(pathToFileURL(require.resolve(entry))) : require(name);
  } catch (error) {
    const remedy = `/usr/bin/python3 -m sunder_tools.launch.node in ${join(repository, 'coupler')} gets it`;
    throw new Failure(Exit.badInput, 'no_package', `node package ${join(folder, name)}: ${error.message}; ${remedy}`);
  }
}

export const loadZeroMq = () => load('zeromq');

/** Message types Request and Reply. Fields have their names in the .proto files. */
export async function loadMessages() {
  const protobuf = await load('protobufjs');
  const root = new protobuf.Root();
  root.resolvePath = (_, name) => join(repository, 'proto', name);
  root.loadSync('exchange.proto', { keepCase: true });
  return { Request: root.lookupType('sunder.proto.Request'), Reply: root.lookupType('sunder.proto.Reply') };
}

/** Jolt's module, and its version. */
export async function loadJolt() {
  const start = (await load('jolt-physics', 'jolt-physics/wasm')).default;
  return { jolt: await start(), version: require('jolt-physics/package.json').version };
}

/** MuJoCo's module. */
export async function loadMuJoCo() {
  const start = (await load('@mujoco/mujoco', '@mujoco/mujoco')).default;
  return start();
}
