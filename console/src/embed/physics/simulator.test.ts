import { gunzipSync } from 'node:zlib';
import { describe, expect, it } from 'vitest';
import { TwinFile } from '../file';
import { readModel } from '../twin';
import type { Model } from './model';
import fixture from './motion.fixture.json';
import { Simulator } from './simulator';

// The fixture is the engine's motion, in single precision, of the twins in scripts/motion: `npm run motion` writes it.
// Where nothing amplifies rounding the two stay within 1 µm. Impacts of nodes do: a start that is moved by 3e-8 m moves
// the twin `dropped` by 1.5 mm after 15 frames, so it is compared closely before that, and loosely then.
const TOLERANCE_M = { early: 2e-6, late: 1e-4, scattered: 3e-3 };
/** Frames up to which the tighter tolerance holds. */
const EARLY = 5;

const SCENES = fixture.scenes.map((scene) => ({
  ...scene,
  model: readModel(new TwinFile(new Uint8Array(gunzipSync(Buffer.from(scene.twin, 'base64'))))).model,
  path: floats(scene.controls),
  expected: floats(scene.positions),
}));

/** Rules without which a scene moves otherwise: it shows them. */
const RULES: Readonly<Record<string, (model: Model) => Model>> = {
  dragged: (model) => ({ ...model, ground: { ...model.ground!, skin: null } }),
  dropped: (model) => ({ ...model, contact: { ...model.contact, betweenObjects: false } }),
  folded: (model) => ({ ...model, contact: { ...model.contact, withinObject: false } }),
  twisted: (model) => ({ ...model, rods: [] }),
};

describe.each(SCENES)('the twin $name', ({ name, model, path, expected }) => {
  it('moves as in the engine', () => {
    for (const [k, error] of errors(model, path, expected).entries()) {
      const frame = fixture.kept[k]!;
      expect(error, `frame ${frame}`).toBeLessThan(frame <= EARLY ? TOLERANCE_M.early : late(name));
    }
  });

  it('moves otherwise without the rule that it shows', () => {
    const other = errors(RULES[name]!(model), path, expected);
    expect(Math.max(...other)).toBeGreaterThan(10 * late(name));
  });
});

function late(name: string): number {
  return name === 'dropped' ? TOLERANCE_M.scattered : TOLERANCE_M.late;
}

/** Largest distance of a node from where the engine has it, after each of the kept frames [m]. */
function errors(model: Model, path: Float32Array, expected: Float32Array): number[] {
  const simulator = new Simulator(model);
  const [nodes, controls] = [model.rest.length, model.controls.length];
  const all: number[] = [];
  for (let frame = 1; all.length < fixture.kept.length; frame += 1) {
    expect(simulator.advance(Float64Array.from(path.subarray(frame * controls, (frame + 1) * controls)))).toBe(true);
    if (frame !== fixture.kept[all.length]) continue;
    const engine = expected.subarray(all.length * nodes, (all.length + 1) * nodes);
    const apart = model.masses.map((_, n) => Math.hypot(...[0, 1, 2].map((c) => simulator.x[3 * n + c]! - engine[3 * n + c]!)));
    all.push(Math.max(...apart));
  }
  return all;
}

function floats(text: string): Float32Array {
  return new Float32Array(new Uint8Array(Buffer.from(text, 'base64')).buffer);
}
