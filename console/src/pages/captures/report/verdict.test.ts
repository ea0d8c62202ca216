import { expect, test } from 'vitest';

import type { Finding, Report } from './report';
import { verdictText } from './verdict';

function report(verdict: string, kind: string, ...severities: Finding['severity'][]): Report {
  const findings = severities.map((severity, index) => ({ severity, message: `fault ${index}` }));
  return { verdict, kind, findings } as unknown as Report;
}

test('a verdict is one sentence, with the first error of what cannot be fitted', () => {
  expect(verdictText(report('good', 'observed', 'info'))).toBe('This capture is good: nothing limits a fit.');
  expect(verdictText(report('usable', 'recording', 'warning', 'info'))).toBe(
    'This recording can be fitted; 1 warning says what makes the twin worse.',
  );
  expect(verdictText(report('unusable', 'recording', 'info', 'error', 'error'))).toBe(
    'This recording cannot be fitted: fault 1.',
  );
});
