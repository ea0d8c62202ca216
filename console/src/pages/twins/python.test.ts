import { expect, test } from 'vitest';

import { pythonOf } from './python';

test('the program names the server and the twin', () => {
  const program = pythonOf('twins/1', 'http://lab:7070');
  expect(program).toContain('with Client("http://lab:7070") as client:\n    twin = client.twin("twins/1")\n');
});
