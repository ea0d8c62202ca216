import { describe, expect, it } from 'vitest';
import { twinFile } from '../../scripts/motion/file.mjs';
import { TwinFile } from './file';
import { readShape } from './shape';
import { readModel } from './twin';

const LINE = {
  nodes: [[0, 0, 0.1], [0.1, 0, 0.1], [0.2, 0, 0.1]],
  // Two hands: 5 cm and 20 cm apart.
  controls: [[0, 0, 0.1], [0, 0.05, 0.1], [0, 0.25, 0.1]],
  springs: [[0, 1], [1, 2]],
  triplets: [[0, 1, 2]],
  pins: [[0, 0]],
};

/** A twin file, with tensors added or replaced. */
function fileOf(others: Readonly<Record<string, { dtype: string; values: Uint32Array | Float32Array }>> = {}): TwinFile {
  const bytes = new Uint8Array(twinFile(LINE));
  const start = 8 + Number(new DataView(bytes.buffer).getBigUint64(0, true));
  const header = JSON.parse(new TextDecoder().decode(bytes.subarray(8, start))) as Record<string, unknown>;
  let data = bytes.slice(start);
  for (const [name, { dtype, values }] of Object.entries(others)) {
    header[name] = { dtype, shape: [values.length], data_offsets: [data.length, data.length + values.byteLength] };
    data = new Uint8Array([...data, ...new Uint8Array(values.buffer)]);
  }
  const text = new TextEncoder().encode(JSON.stringify(header));
  const length = new Uint8Array(new BigUint64Array([BigInt(text.length)]).buffer);
  return new TwinFile(new Uint8Array([...length, ...text, ...data]));
}

describe('a twin file', () => {
  it('is read as a model', () => {
    const { model, fast } = readModel(fileOf());
    expect(fast).toBeNull();
    expect(model.triplets.restBend).toEqual(new Float64Array([0]));
    expect([...model.hands]).toEqual([0, 0, 2]);
    expect(model.springs.rate[0]! * model.springs.rest[0]!).toBeGreaterThan(400);
    expect(model.ground?.skin).toBeNull();
    expect(readModel(fileOf({ 'controls.hand': { dtype: 'U32', values: new Uint32Array([0, 1, 1]) } })).model.hands[1]).toBe(1);
  });

  it('is seen as tubes where it has these, as its skin otherwise', () => {
    const surface = {
      'surface.tube_length': { dtype: 'U32', values: new Uint32Array([3]) },
      'surface.tube_node': { dtype: 'U32', values: new Uint32Array([0, 1, 2]) },
      'surface.tube_radius': { dtype: 'F32', values: new Float32Array([0.005]) },
    };
    const shape = readShape(fileOf(surface), readModel(fileOf()).model);
    expect(shape.surface?.tubes).toEqual([{ nodes: new Uint32Array([0, 1, 2]), radius: Math.fround(0.005) }]);
    expect(shape.spacing).toBeCloseTo(0.1, 6);
    const bare = readShape(fileOf(), readModel(fileOf()).model);
    expect(bare.surface).toBeNull();
    expect([...bare.skin.nodes]).toEqual([0, 1, 2]);
  });

  it('is refused where its parts do not belong together', () => {
    const indices = (...values: number[]) => ({ dtype: 'U32', values: new Uint32Array(values) });
    expect(() => readModel(fileOf({ 'springs.ends': indices(0, 1, 1, 6) }))).toThrow('do not belong together');
    expect(() => readModel(fileOf({ 'pins.ends': indices(0, 3) }))).toThrow('do not belong together');
    expect(() => readModel(fileOf({ 'springs.ends': { dtype: 'F32', values: new Float32Array(4) } }))).toThrow('no U32');
    const outside = { 'surface.triangle': indices(0, 1, 2) };
    expect(() => readShape(fileOf(outside), readModel(fileOf()).model)).toThrow('surface.triangle');
  });
});
