// From a recording to the best of 64 motions of its grippers:
//
//   node rollout.mjs rope.zip ['{"effort": "standard"}']
//
// The second argument are settings of the fit, which docs/use/settings.md lists.
// `bendtwin server` runs on this machine, or BENDTWIN_SERVER is its address and BENDTWIN_TOKEN a token or key.
import { readFile } from 'node:fs/promises';
import { Client, doubles, floats, idOf, packed } from '@bendtwin/client';

const [file = 'rope.zip', settings = '{"effort": "draft"}'] = process.argv.slice(2);
const [SAMPLES, FRAMES] = [64, 30];

const client = new Client({
  address: process.env['BENDTWIN_SERVER'] ?? 'http://127.0.0.1:7070',
  token: process.env['BENDTWIN_TOKEN'] ?? null,
});

const { name: capture } = await client.uploadCapture(await readFile(file), { displayName: file });
for await (const { ingest, verdict } of client.watchCapture(capture)) {
  if (ingest?.state === 'FAILED') throw new Error(ingest.fault?.message);
  if (ingest?.state === 'SUCCEEDED') console.log(`the recording is ${verdict}`);
}

const { name: fit } = await client.post('/v1/fits', { body: { capture, settings: JSON.parse(settings) } });
let [stage, twin] = ['', ''];
for await (const state of client.watchFit(fit)) {
  if (state.job.state === 'FAILED') throw new Error(state.job.fault?.message);
  if (state.job.progress && state.job.progress.stage !== stage) console.log(`stage of the fit: ${(stage = state.job.progress.stage)}`);
  twin = state.twin ?? '';
}

// Each sample moves all control points the same way, between two knots: [samples, knots, points, 3], metres.
const id = idOf(twin);
const geometry = await client.get('/v1/twins/{id}/geometry', { id, query: { tensors: 'base64' } });
const start = floats(geometry.controls);
const motions = Array.from({ length: SAMPLES }, (_, sample) => {
  const angle = (2 * Math.PI * sample) / SAMPLES;
  const way = [0.1 * Math.cos(angle), 0.1 * Math.sin(angle), 0.05];
  return [...start, ...start.map((value, i) => value + (way[i % 3] ?? 0))];
});

const { costs, positions } = await client.post('/v1/twins/{id}/rollouts', {
  id,
  query: { tensors: 'base64' },
  body: {
    trajectories: { positions: packed(Float32Array.from(motions.flat()), [SAMPLES, 2, start.length / 3, 3]) },
    frames: FRAMES,
    costs: [{ name: 'goal', keypoints: { nodes: [0], targets: [[0.1, 0, 0.2]] } }],
    returns: { every_frames: FRAMES, best: 1 },
  },
});
const found = doubles(costs);
const best = found.indexOf(Math.min(...found));
const [x, y, z] = floats(positions);
console.log(`motion ${best} costs ${found[best]?.toPrecision(3)}: node 0 ends at ${[x, y, z].map((p) => p?.toFixed(3)).join(', ')} m`);
