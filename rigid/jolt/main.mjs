// sunder-rigid-jolt: serves one session with Jolt, as sunder-rigid does with the engines of rigid/engine.
import { engineMain } from './engine_main.mjs';
import { JoltEngine } from './jolt_engine.mjs';
import { loadJolt } from './packages.mjs';

await engineMain('sunder-rigid-jolt', async () => new JoltEngine(await loadJolt()));
