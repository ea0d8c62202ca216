import { expect, it } from 'vitest';
import { readAppearance } from './appearance';

type Tensors = Record<string, Float32Array | Uint32Array | Uint8Array>;

function read(tensors: Tensors): ReturnType<typeof readAppearance> {
  const low = 13;
  const total = Object.values(tensors).reduce((sum, { byteLength }) => sum + byteLength, 0);
  const bytes = new Uint8Array(total);
  let at = 0;
  const entries = Object.entries(tensors).map(([name, values]) => {
    const start = at;
    bytes.set(new Uint8Array(values.buffer), start);
    at += values.byteLength;
    const dtype = values instanceof Uint8Array ? 'U8' : values instanceof Uint32Array ? 'U32' : 'F32';
    return [name, { dtype, data_offsets: [low + start, low + at] as const }] as const;
  });
  return readAppearance(new Map(entries), bytes, low);
}

const SPLATS: Tensors = {
  'skin.color': Uint8Array.of(1, 2, 3),
  'splats.weight_count': Uint32Array.of(2),
  'splats.weight_node': Uint32Array.of(0, 4),
  'splats.weight': Float32Array.of(0.25, 0.75),
  'splats.frame': Uint32Array.of(0, 1, 2),
  'splats.offset': Float32Array.of(0, 0, 0.5),
  'splats.scale': Float32Array.of(0.1, 0.2, 0.3),
  'splats.rotation': Float32Array.of(0, 0, 0, 1),
  'splats.opacity': Float32Array.of(0.5),
  'splats.color': Float32Array.of(1, 0.5, 0),
};

it('reads tensors that begin anywhere', () => {
  const appearance = read(SPLATS);
  expect(appearance?.skinColours).toEqual(Uint8Array.of(1, 2, 3));
  expect(appearance?.splats?.carriers.nodes).toEqual(Uint32Array.of(0, 4));
  expect(appearance?.splats?.colours).toEqual(Float32Array.of(1, 0.5, 0));
});

it('accepts colours alone, and their absence', () => {
  expect(read({ 'skin.color': Uint8Array.of(9, 9, 9) })?.splats).toBeNull();
  expect(read({ 'skin.color': new Uint8Array(0) })).toBeNull();
});

it('refuses tensors that do not belong together', () => {
  expect(() => read({ ...SPLATS, 'splats.color': Float32Array.of(1, 0.5) })).toThrow('belong together');
  expect(() => read({ ...SPLATS, 'splats.weight': Float32Array.of(1) })).toThrow('belong together');
});
