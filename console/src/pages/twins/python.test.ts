import { expect, test } from 'vitest';

import { pythonOf } from './python';

test('the program names the server and the twin, and moves control points only if there are some', () => {
  const held = pythonOf({ name: 'twins/1', control_count: 4 }, 'http://lab:7070');
  expect(held).toContain('with Client("http://lab:7070") as client:\n    twin = client.twin("twins/1")\n');
  expect(held).toContain('trajectories=actions');
  const free = pythonOf({ name: 'twins/1', control_count: 0 }, 'http://lab:7070');
  expect(free).not.toMatch(/controls|np\./);
  expect(free).toContain('twin.rollout(frames=30,');
});
