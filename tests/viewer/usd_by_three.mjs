// Reads a .usda file with three.js and writes what it found as JSON, meshes at the time codes given.
// usd_by_three.mjs LOADER FILE CODE...
import { readFileSync } from 'node:fs';
import { dirname, join } from 'node:path';
import { pathToFileURL } from 'node:url';

const [loader, file, ...codes] = process.argv.slice(2);
const { USDLoader } = await import(pathToFileURL(loader));
const { AnimationMixer, LoopOnce, Vector3 } = await import(pathToFileURL(join(dirname(loader), '../../../build/three.module.js')));

const root = new USDLoader().parse(readFileSync(file, 'utf8'));
const mixer = new AnimationMixer(root);
for (const clip of root.animations) {
  const action = mixer.clipAction(clip);
  action.setLoop(LoopOnce, 1);
  action.clampWhenFinished = true;
  action.play();
}
const perSecond = Number(/timeCodesPerSecond = (\S+)/.exec(readFileSync(file, 'utf8'))[1]);
// z up in the file, y up in three.js: the loader turns the root.
root.rotation.set(0, 0, 0);

const found = [];
root.traverse((mesh) => {
  if (!mesh.isMesh) return;
  const materials = Array.isArray(mesh.material) ? mesh.material : [mesh.material];
  const counts = mesh.geometry.groups.map((group) => group.count / 3);
  found.push({
    thing: mesh.parent.name,
    name: mesh.name,
    counts,
    colours: materials.map((m) => m.color.toArray()),
    opacities: materials.map((m) => m.opacity),
    uv: mesh.geometry.attributes.uv !== undefined,
    at: {},
    mesh,
  });
});
for (const code of codes) {
  mixer.setTime(Number(code) / perSecond);
  root.updateMatrixWorld(true);
  for (const one of found) {
    const points = one.mesh.geometry.attributes.position;
    const order = one.mesh.geometry.index?.array ?? Array.from({ length: points.count }, (_, k) => k);
    one.at[code] = Array.from(order, (k) => new Vector3().fromBufferAttribute(points, k).applyMatrix4(one.mesh.matrixWorld).toArray());
  }
}
for (const one of found) delete one.mesh;
console.log(JSON.stringify(found));
