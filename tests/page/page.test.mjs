// The page of `fissure view` and `export --to html` in a real browser.

import { after, before, test } from 'node:test';
import assert from 'node:assert/strict';
import { cpSync, mkdirSync, rmSync } from 'node:fs';
import { join } from 'node:path';
import { pathToFileURL } from 'node:url';
import { browser, count, differing, fissure, folder, open, pixels, run, shown, until, view } from './browser.mjs';

/** Glazed white is far brighter than the dark ground. */
const bright = (r, g, b) => r + g + b > 420;
const legend = (page) => page.locator('#legend h2').innerText();
let server;

before(async () => {
  run('a');
  run('b', '--set', 'body.box.velocity=[0.2, -5, 0]');
  server = await view('a');
});

after(async () => {
  server.end();
  await browser.close();
  rmSync(folder, { recursive: true });
});

test('it loads, shows the body, and complains of nothing', async () => {
  const { page, said } = await open(server.url);
  await until(page, 0);
  const picture = await pixels(page);
  const share = count(picture, bright) / (picture.length / 4);
  assert.ok(share > 0.01 && share < 0.5, `${share} of the picture is bright`);
  assert.equal(await page.title(), 'A box breaks · Fissure');
  assert.equal(await page.locator('#plots figure').count(), 4);
  assert.deepEqual(said, []);
  await page.close();
});

test('it plays, steps and scrubs', async () => {
  const { page, said } = await open(server.url);
  await page.selectOption('#speed', '60');
  await page.locator('#canvas').focus();
  await page.keyboard.press('Space');
  assert.equal(await page.locator('#play').getAttribute('aria-label'), 'Pause');
  await page.waitForFunction(() => Number(document.body.dataset.frame) >= 3);
  await page.keyboard.press('Space');
  await page.keyboard.press('Home');
  await until(page, 0);
  const start = await pixels(page);
  await page.keyboard.press('ArrowRight');
  await until(page, 1);
  await page.keyboard.press('End');
  await until(page, 4);
  assert.match(await page.locator('#clock').innerText(), /40\.00 ms\s+frame 4 of 4/);
  assert.match(await page.locator('#scrub').getAttribute('aria-valuetext'), /^frame 4, 40\.00 ms$/);
  assert.ok(differing(start, await pixels(page)) > 1000);
  await page.locator('#scrub').fill('2');
  await until(page, 2);
  const plot = await page.locator('#plots svg').first().boundingBox();
  await page.mouse.click(plot.x + 0.74 * plot.width, plot.y + plot.height / 2);
  await until(page, 3);
  assert.deepEqual(said, []);
  await page.close();
});

test('colours, shapes, crack faces and fragments change what is seen', async () => {
  const { page, said } = await open(server.url);
  await page.keyboard.press('End');
  await until(page, 4);
  let before = await pixels(page);
  const changes = async (what, act, least = 500) => {
    await act();
    await page.waitForTimeout(100);
    const now = await pixels(page);
    assert.ok(differing(before, now) > least, `${what}: ${differing(before, now)} pixels`);
    before = now;
  };
  for (const [key, name] of [['2', 'Damage'], ['3', 'Speed'], ['4', 'Piece'], ['5', 'Inside'],
    ['6', 'Stretch'], ['1', 'Material']]) {
    await changes(name, () => page.keyboard.press(key));
    assert.equal(await legend(page), name);
  }
  await changes('crack faces', () => page.getByLabel('Crack faces').click());
  await changes('crack faces again', () => page.getByLabel('Crack faces').click());
  await changes('explode', () => page.getByLabel('Explode').fill('120'));
  await changes('together', () => page.getByLabel('Explode').fill('0'));
  await changes('wireframe', () => page.getByRole('radio', { name: 'Wireframe' }).check());
  await changes('particles', () => page.getByRole('radio', { name: 'Particles' }).check());
  await changes('surface', () => page.getByRole('radio', { name: 'Surface' }).check());
  await changes('colliders', () => page.getByLabel('Colliders').click(), 200);
  await changes('a view from elsewhere', async () => {
    await page.mouse.move(300, 300);
    await page.mouse.down();
    await page.mouse.move(500, 340, { steps: 4 });
    await page.mouse.up();
  });
  assert.deepEqual(said, []);
  await page.close();
});

test('a click tells the values, and they follow in time', async () => {
  const { page, said } = await open(server.url);
  await until(page, 0);
  const box = await page.locator('#canvas').boundingBox();
  const card = page.locator('#card');
  for (let k = 0; k < 40 && !(await card.isVisible()); k++) {
    const [u, v] = [0.3 + 0.1 * (k % 5), 0.25 + 0.06 * Math.floor(k / 5)];
    await page.mouse.click(box.x + u * box.width, box.y + v * box.height);
  }
  const text = await card.innerText();
  assert.match(text, /^Vertex \d+/);
  assert.match(text, /speed\s+4\.\d* m\/s/); // it falls at 4 m/s
  assert.match(text, /side\s+outer surface/);
  await page.keyboard.press('End');
  await until(page, 4);
  const later = await card.innerText();
  assert.equal(later.split('\n')[0], text.split('\n')[0]);
  assert.notEqual(later, text);
  await page.keyboard.press('Escape');
  assert.ok(!(await card.isVisible()));
  assert.deepEqual(said, []);
  await page.close();
});

test('everything has a name, help has the keys, and narrow screens have room', async () => {
  const { page, said } = await open(server.url, { width: 420, height: 800 });
  const nameless = await page.evaluate(() => [...document.querySelectorAll('button, input, select, canvas, svg[role]')]
    .filter((e) => !e.getAttribute('aria-label') && !e.labels?.[0]?.textContent.trim() && !e.textContent.trim())
    .map((e) => e.outerHTML.slice(0, 80)));
  assert.deepEqual(nameless, []);
  assert.ok(await page.evaluate(() => document.documentElement.scrollWidth <= innerWidth), 'wider than the screen');
  await page.keyboard.press('?');
  await page.getByText('play or pause').waitFor();
  await page.keyboard.press('Escape');
  assert.ok(!(await page.locator('#help').isVisible()));
  assert.ok(count(await pixels(page), bright) > 500);
  await page.keyboard.press('Tab');
  const outline = await page.evaluate(() => getComputedStyle(document.activeElement).outlineStyle);
  assert.notEqual(outline, 'none');
  assert.deepEqual(said, []);
  await page.close();
});

test('two runs stand side by side, and their difference has a colour', async (t) => {
  const both = await view('a', 'b');
  t.after(both.end);
  const { page, said } = await open(both.url);
  assert.equal((await page.locator('#labels').innerText()).replace(/\s+/g, ' ').trim(), 'a b');
  await page.keyboard.press('7');
  assert.equal(await legend(page), 'Difference');
  assert.match(await page.locator('#legend').innerText(), /the same in both/);
  const same = await pixels(page);
  const half = (data, side) => data.filter((_, k) => (Math.floor(k / 4) % width < width / 2) === (side === 0));
  const width = Math.round((await page.locator('#stage').boundingBox()).width);
  for (const side of [0, 1]) assert.ok(count(half(same, side), bright) > 1000, `nothing on side ${side}`);
  await page.keyboard.press('End');
  await until(page, 4);
  assert.match(await page.locator('#legend').innerText(), /up to 0\.\d+ m now/);
  assert.ok(differing(same, await pixels(page)) > 1000);
  assert.deepEqual(said, []);
  await page.close();
});

test('frames of a run that goes on appear by themselves', async (t) => {
  const copy = (name) => cpSync(join(folder, 'a', name), join(folder, 'growing', name), { recursive: true });
  mkdirSync(join(folder, 'growing', 'frames'), { recursive: true });
  for (const name of ['scene.toml', 'frames/frame_0000.ply', 'frames/frame_0001.ply']) copy(name);
  const growing = await view('growing');
  t.after(growing.end);
  const { page, said } = await open(growing.url);
  assert.equal(await page.locator('#live').innerText(), 'frame 1 of 4 so far');
  await page.keyboard.press('End');
  await until(page, 1);
  for (const name of ['frames', 'series.csv']) copy(name);
  await until(page, 4);
  await page.locator('#plots figure').first().waitFor();
  assert.equal(await page.locator('#live').innerText(), '');
  assert.deepEqual(said, []);
  await page.close();
});

test('as one file it works without a server', async () => {
  fissure('export', 'a', '--to', 'html');
  const { page, said } = await open(pathToFileURL(join(folder, 'a', 'run.html')).href);
  assert.ok(count(await pixels(page), bright) > 1000);
  await page.keyboard.press('End');
  await until(page, 4);
  await page.keyboard.press('2');
  assert.equal(await legend(page), 'Damage');
  await page.getByRole('radio', { name: 'Particles' }).check();
  assert.ok(count(await pixels(page), bright) > 200);
  assert.equal(await page.locator('#plots figure').count(), 4);
  assert.equal(await shown(page), 4);
  assert.deepEqual(said, []);
  await page.close();
});
