import { expect, it } from 'vitest';
import fixture from './carry.fixture.json';
import { Carrier } from './carry';
import { startsOf } from '../skin';

it('carries Gaussians as crates/splat does', () => {
  const skin = {
    starts: startsOf(Uint32Array.from(fixture.weight_counts)),
    nodes: Uint32Array.from(fixture.weight_nodes),
    weights: Float32Array.from(fixture.weights),
    frames: Uint32Array.from(fixture.frames.flat()),
    offsets: Float32Array.from(fixture.offsets.flat()),
  };
  const rest = Float32Array.from(fixture.rest.flat());
  const carrier = new Carrier(rest, Uint32Array.from(fixture.springs.flat()), skin);
  const count = fixture.weight_counts.length;
  const [means, rotations] = [new Float32Array(3 * count), new Float32Array(4 * count)];
  carrier.at(Float32Array.from(fixture.nodes.flat()), means, rotations);
  fixture.means.flat().forEach((x, i) => expect(means[i]).toBeCloseTo(x, 5));
  fixture.rotations.flat().forEach((x, i) => expect(rotations[i]).toBeCloseTo(x, 5));
});
