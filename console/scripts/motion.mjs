// Writes src/embed/physics/motion.fixture.json: small twins, and how the engine moves them. The simulator of embedded
// twins is compared with it.
//
//   cargo build -p bendtwin-cli && npm run motion
//
// Engines of other processors may differ in the last digits.

import { writeFileSync } from 'node:fs';
import { fileURLToPath } from 'node:url';
import { gzipSync } from 'node:zlib';
import { FRAMES, SCENES } from './motion/scenes.mjs';
import { Server } from './server.mjs';

const FIXTURE = fileURLToPath(new URL('../src/embed/physics/motion.fixture.json', import.meta.url));
/** Frames whose positions are compared. */
const KEPT = [1, 2, 3, 5, 10, 15, 20, 25, 30];

const server = await Server.start(['--client-token', 'none']);
try {
  const scenes = [];
  for (const scene of SCENES) scenes.push(await roll(scene));
  writeFileSync(FIXTURE, `${JSON.stringify({ kept: KEPT, scenes })}\n`);
} finally {
  await server.remove();
}

/** @param {import('./motion/scenes.mjs').Scene} scene */
async function roll({ name, file, path }) {
  const controls = Float32Array.from(path.flat(2));
  const { name: twin } = await post('/v1/twins?display_name=made', file, 'application/octet-stream');
  const positions = { dtype: 'FLOAT32', shape: [1, FRAMES + 1, path[0]?.length, 3], data: base64(controls) };
  const request = { trajectories: { positions }, returns: { every_frames: 1 } };
  const reply = await post(`/v1/${twin}/rollouts?tensors=base64`, JSON.stringify(request), 'application/json');
  const { shape, data } = reply.positions;
  const frame = 4 * shape[2] * 3;
  const all = Buffer.from(data, 'base64');
  const kept = KEPT.map((number) => all.subarray((number - 1) * frame, number * frame));
  return {
    name,
    twin: gzipSync(file, { level: 9 }).toString('base64'),
    controls: base64(controls),
    positions: Buffer.concat(kept).toString('base64'),
  };
}

/**
 * @param {string} path
 * @param {Buffer | string} body
 * @param {string} type
 */
async function post(path, body, type) {
  const content = typeof body === 'string' ? body : new Uint8Array(body);
  const answer = await fetch(server.url + path, { method: 'POST', headers: { 'content-type': type }, body: content });
  const reply = await answer.json();
  if (!answer.ok) throw new Error(`${path}: ${JSON.stringify(reply)}`);
  return reply;
}

/** @param {Float32Array} values */
function base64(values) {
  return Buffer.from(values.buffer).toString('base64');
}
