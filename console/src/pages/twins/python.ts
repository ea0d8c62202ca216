import type { Twin } from '../../api/types';
import { snippet } from '../../ui/copy';
import { showDialog } from '../../ui/dialog';
import { h } from '../../ui/dom';

/** A program that loads a twin with the Python client and predicts a motion: client/python/README.md. */
export function pythonOf({ name, control_count }: Pick<Twin, 'name' | 'control_count'>, server: string): string {
  const hasControls = control_count > 0;
  return [
    'import numpy as np',
    'from bendtwin import Client, Returns',
    '',
    `with Client("${server}") as client:`,
    `    twin = client.twin("${name}")`,
    '    geometry = twin.geometry()',
    ...(hasControls
      ? [
          '    # All control points rise by 5 cm in 30 frames: [B, F + 1, C, 3], metres.',
          '    lift = np.linspace(0, 1, 31)[:, None, None] * [0, 0, 0.05]',
          '    actions = (geometry.controls + lift)[None]',
          '    result = twin.rollout(trajectories=actions, returns=Returns(every_frames=1))',
        ]
      : [
          '    # It moves freely for 30 frames.',
          '    result = twin.rollout(frames=30, returns=Returns(every_frames=1))',
        ]),
    '    print(result.positions.shape)  # [B, F, N, 3]',
    '',
  ]
    .filter((line) => hasControls || line !== 'import numpy as np')
    .join('\n');
}

/** A button that shows how the twin is used in Python. */
export function pythonButton(twin: Twin): HTMLElement {
  const show = (): void =>
    showDialog(
      'Use in Python',
      h('p', {}, 'Install the client from the source tree of BendTwin:'),
      snippet('pip install ./client/python', 'installation of the client'),
      h('p', {}, 'Then load this twin and predict a motion:'),
      snippet(pythonOf(twin, location.origin), 'program that uses this twin'),
      h(
        'p',
        { class: 'muted' },
        'The token of a server of yours on this machine is found by itself; for others set ',
        h('code', {}, 'BENDTWIN_TOKEN'),
        '.',
      ),
    );
  return h('button', { type: 'button', onclick: show }, 'Use in Python');
}
