import { describe, expect, it } from 'vitest';
import { loginElsewhere } from './sign_in';

describe('the origin at which a sign-in begins', () => {
  const here = 'http://localhost:7070';

  it('is the one to which the provider sends browsers back, and keeps the next page', () => {
    expect(loginElsewhere('http://127.0.0.1:7070', '#/twins?q=a&b', here)).toBe(
      'http://127.0.0.1:7070/#/login?next=%23%2Ftwins%3Fq%3Da%26b',
    );
    expect(loginElsewhere('https://twin.example', '#/', here)).toBe('https://twin.example/#/login');
  });

  it('is this one where nothing else is known', () => {
    for (const publicUrl of [here, `${here}/`, '', 'twin.example', 'javascript:alert(1)', 'data:text/html,x']) {
      expect(loginElsewhere(publicUrl, '#/twins', here)).toBeNull();
    }
  });

  it('is no other one, for any next page', () => {
    for (const next of ['#/@evil.example', '//evil.example', 'https://evil.example', '#/\\evil.example']) {
      expect(new URL(loginElsewhere('https://twin.example', next, here) ?? '').origin).toBe('https://twin.example');
    }
  });
});
