// Measures the time that frames of twin files take in the simulator of their web page, in node:
//
//   npm run frame-time -- FILE…
//
// It is time of the processor, as other programs may take most of it.

import { readFileSync } from 'node:fs';
import { fileURLToPath } from 'node:url';
import { createServer } from 'vite';

/** Frames that are measured, after those that run before the code is compiled. */
const FRAMES = 120;
const FIRST = 30;

const root = fileURLToPath(new URL('..', import.meta.url));
const server = await createServer({ root, logLevel: 'error', server: { middlewareMode: true } });
try {
  const { Simulator } = await server.ssrLoadModule('/src/embed/physics/simulator.ts');
  const { TwinFile } = await server.ssrLoadModule('/src/embed/file.ts');
  const { readModel } = await server.ssrLoadModule('/src/embed/twin.ts');
  for (const file of process.argv.slice(2)) {
    const { model } = readModel(new TwinFile(new Uint8Array(readFileSync(file))));
    const simulator = new Simulator(model);
    const times = Array.from({ length: FIRST + FRAMES }, () => {
      const begun = process.cpuUsage();
      simulator.advance(model.controls);
      const { user, system } = process.cpuUsage(begun);
      return (user + system) / 1000;
    }).slice(FIRST);
    const sorted = times.sort((a, b) => a - b);
    const [half, most] = [0.5, 0.95].map((share) => Number(sorted[Math.floor(share * FRAMES)]));
    const { springs, triplets, masses, substeps, fps } = model;
    console.log(`${file}: ${masses.length} nodes, ${springs.rest.length} springs, ${triplets.restBend.length} triplets`);
    console.log(`  a frame of ${substeps} substeps: p50 ${half?.toFixed(2)} ms, p95 ${most?.toFixed(2)} ms`);
    console.log(`  ${(1000 / Number(half)).toFixed(0)} frames a second, of which real time needs ${fps}`);
  }
} finally {
  await server.close();
}
