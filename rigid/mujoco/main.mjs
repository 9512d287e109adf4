// sunder-rigid-mujoco: serves one session with MuJoCo, as sunder-rigid does with the engines of rigid/engine.
import { engineMain } from '../jolt/engine_main.mjs';
import { loadMuJoCo } from '../jolt/packages.mjs';
import { MuJoCoEngine } from './mujoco_engine.mjs';

await engineMain('sunder-rigid-mujoco', async () => new MuJoCoEngine(await loadMuJoCo()));
